//! The detection and its fields.

use crate::maker::Maker;
use crate::protocol::Protocol;
use imc::Address;
use units::{LatLon, UtcTime};

/// Receiver clocks below this were never set (s; September 2001): they count from power-up, or from a day when none of
/// these receivers existed, as Thelma Biotel's do from 2000-01-01.
pub const SET_AFTER_S: u32 = 1_000_000_000;

/// A tag that a receiver heard.
#[derive(Debug, Clone, PartialEq)]
pub struct Detection {
    /// Who reported it, and when.
    pub origin: Origin,
    /// Serial number of the receiver.
    pub receiver: u32,
    /// Its maker, where a file said so: makers give the same numbers. Absent for what vessels report.
    pub maker: Option<Maker>,
    /// The receiver's clock when the tag was heard.
    pub clock: ReceiverClock,
    /// The coding of the transmission.
    pub protocol: Protocol,
    /// The tag's number.
    pub tag_id: u32,
    /// The tag's measurement as it was sent; absent where it sent none.
    pub data: Option<u16>,
    /// Signal to noise ratio (dB), never 0; absent where the receiver, or its file, does not say it.
    pub snr_db: Option<u8>,
    /// Carrier (kHz), never 0; absent likewise.
    pub frequency_khz: Option<u8>,
    /// Running number of the receiver's line, which is its place in the receiver's memory.
    pub line: u16,
    /// Where the vessel was then; absent where it did not know.
    pub pose: Option<Pose>,
    /// The receiver's listening conditions.
    pub effort: Effort,
    /// The receiver's line as it came, without its end.
    pub raw: Option<String>,
}

/// Who reported a detection, and when.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Origin {
    /// The vessel that carried the receiver.
    pub system: Address,
    /// The entity that reported it.
    pub entity: u8,
    /// When its line came to the vessel and was reported, by the vessel's clock.
    pub reported: UtcTime,
    /// When it first came ashore, by the shore's clock; absent aboard.
    pub received: Option<UtcTime>,
}

/// The receiver's clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct ReceiverClock {
    /// Seconds: since 1970 UTC where it is set, else since an unknown moment.
    pub seconds: u32,
    /// Thousandths of a second beside them.
    pub millis: u16,
    /// What is known of it.
    pub state: ClockState,
}

/// What is known of a receiver's clock, from the least to the best. Consoles' TBRFishTag does not carry it: a stamp alone
/// shows only whether the clock was ever set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum ClockState {
    /// It was never set since power-up: its count is not a time of day.
    NotSet,
    /// It was good and is not known to be any more: its count may be a time of day that is off by anything.
    Lost,
    /// It was set at some time.
    Set,
    /// It was set by the vessel, and kept by its marks or by a pulse since.
    Disciplined,
}

impl ClockState {
    const ALL: [Self; 4] = [Self::NotSet, Self::Lost, Self::Set, Self::Disciplined];

    /// As the reports say it.
    pub const fn word(self) -> &'static str {
        match self {
            Self::NotSet => "not set",
            Self::Lost => "lost",
            Self::Set => "set",
            Self::Disciplined => "disciplined",
        }
    }

    /// From that word; `None` for another.
    pub fn of_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|state| state.word() == word)
    }

    /// The state from two reports: one that says the clock is bad is based on more than a stamp, and so is one that says
    /// the clock is kept.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        if self.min(other) < Self::Set { self.min(other) } else { self.max(other) }
    }
}

/// Where the vessel was when a tag was heard.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// The place.
    pub place: LatLon,
    /// Time between the detection and the nearest measured position (s).
    pub age_s: Option<f64>,
    /// Standard deviation on each axis (m), as the vessel's navigation has it.
    pub sigma_m: Option<f64>,
}

/// The listening conditions of a receiver when it heard a tag.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Effort {
    /// Lines that the receiver wrote since the previous one and that never came.
    pub lines_lost: Option<u16>,
    /// The receiver's last report of the noise.
    pub noise: Option<Noise>,
    /// Speed of the vessel's faster propeller (rpm, without direction).
    pub propeller_rpm: Option<f64>,
}

/// The noise that a receiver reported (its own counts, dB-like).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Mean level.
    pub average: u8,
    /// Peak level.
    pub peak: u8,
    /// How long before the detection's line that was (s).
    pub age_s: f64,
}

impl ReceiverClock {
    /// The state that a receiver's stamp alone shows.
    pub fn read(seconds: u32, millis: u16) -> Self {
        let state = if seconds >= SET_AFTER_S { ClockState::Set } else { ClockState::NotSet };
        Self { seconds, millis, state }
    }

    /// The time of day, where the clock is set and was not lost.
    pub fn utc(self) -> Option<UtcTime> {
        (self.state >= ClockState::Set).then(|| UtcTime::from_micros(self.micros()))
    }

    /// The count, whatever it counts from (µs).
    pub fn micros(self) -> i64 {
        i64::from(self.seconds) * 1_000_000 + i64::from(self.millis) * 1_000
    }
}

impl Detection {
    /// Names it among the detections of its vessel: the same in whatever message and by whatever way it came.
    pub fn id(&self) -> String {
        let Self { receiver, clock: ReceiverClock { seconds, millis, .. }, protocol, tag_id, .. } = self;
        let Origin { entity, reported, .. } = self.origin;
        let maker = self.maker.map_or_else(String::new, |maker| format!("{maker}:"));
        format!("{maker}{receiver}-{seconds}.{millis:03}-{protocol}-{tag_id}-{entity}-{}", reported.micros())
    }

    /// The tag as people write it: `S256-101`.
    pub fn tag(&self) -> String {
        format!("{}-{}", self.protocol, self.tag_id)
    }

    /// Whether both report one detection.
    pub fn is_same(&self, other: &Self) -> bool {
        self.key() == other.key()
    }

    fn key(&self) -> impl Ord + '_ {
        let Origin { system, entity, reported, .. } = self.origin;
        let clock = (self.clock.seconds, self.clock.millis);
        (reported, system, entity, (self.receiver, self.maker), clock, self.tag_id, &self.protocol)
    }

    /// Takes over from another report of the same detection what this one lacks.
    pub fn complete(&mut self, other: Self) {
        let Self { origin, clock, data, snr_db, frequency_khz, pose, effort, raw, .. } = other;
        self.origin.received = [self.origin.received, origin.received].into_iter().flatten().min();
        self.clock.state = self.clock.state.with(clock.state);
        self.data = self.data.or(data);
        self.snr_db = self.snr_db.or(snr_db);
        self.frequency_khz = self.frequency_khz.or(frequency_khz);
        let says_more = |pose: &Pose| pose.age_s.is_some() || pose.sigma_m.is_some();
        if self.pose.is_none()
            || (pose.as_ref().is_some_and(says_more) && !self.pose.as_ref().is_some_and(says_more))
        {
            self.pose = pose.or(self.pose);
        }
        self.effort.lines_lost = self.effort.lines_lost.or(effort.lines_lost);
        self.effort.noise = self.effort.noise.or(effort.noise);
        self.effort.propeller_rpm = self.effort.propeller_rpm.or(effort.propeller_rpm);
        self.raw = self.raw.take().or(raw);
    }
}

/// One for each detection, in order of report, vessel, entity, receiver, its clock and the tag: of several reports of
/// the same, from what they say together.
pub fn fused(mut reports: Vec<Detection>) -> Vec<Detection> {
    reports.sort_by(|one, other| one.key().cmp(&other.key()));
    let mut told: Vec<Detection> = Vec::with_capacity(reports.len());
    for report in reports {
        match told.last_mut().filter(|last| last.is_same(&report)) {
            Some(last) => last.complete(report),
            None => told.push(report),
        }
    }
    told
}
