//! Epochs: the sentences of one moment gathered, whatever their order.
//!
//! A new epoch begins with a sentence of another time of day, with one of a kind that the epoch holds already, and with
//! one that stands before the epoch's last in an order which two epochs kept: without that, a lost first sentence would let
//! the next epoch's heading slip into this one. GSA may repeat, as receivers send one for each satellite system. Who knows
//! when bytes came may end an epoch by [`Epochs::close`] when the line is quiet. Of what comes, one epoch is kept.

use super::fields::TimeOfDay;
use super::report::{Attitude, DateTime, Errors, Kind, Position, Precision, Report};
use crate::reading::{GnssFix, GnssReading, GroundVelocity, Quality};
use units::UtcTime;

const DAY_US: i64 = 86_400_000_000;
/// Epochs that must keep an order before it is accepted.
const STEADY: u8 = 2;

/// All that a receiver reported of one moment. A value that no sentence had is `None`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Epoch {
    /// Time of day.
    pub time: Option<TimeOfDay>,
    /// Date and time, where the epoch itself has both.
    pub utc: Option<UtcTime>,
    /// Date and time, the date carried on from an earlier epoch where this one has none.
    pub carried_utc: Option<UtcTime>,
    /// Latitude and longitude (rad); only of a valid position.
    pub lat_lon_rad: Option<(f64, f64)>,
    /// Quality of the position in GGA's numbers; see [`Position::quality`].
    pub quality: Option<u8>,
    /// Satellites in use.
    pub satellites: Option<u8>,
    /// Horizontal dilution of precision.
    pub hdop: Option<f64>,
    /// Height above the ellipsoid (m).
    pub height_m: Option<f64>,
    /// Course over ground, true (rad).
    pub course_rad: Option<f64>,
    /// Speed over ground (m/s).
    pub speed_mps: Option<f64>,
    /// True heading (rad).
    pub heading_rad: Option<f64>,
    /// Magnetic heading (rad).
    pub magnetic_heading_rad: Option<f64>,
    /// Rate of turn, to starboard positive (rad/s).
    pub yaw_rate_rad_s: Option<f64>,
    /// Pitch, roll and heave.
    pub attitude: Option<Attitude>,
    /// Dilution of precision as GSA has it.
    pub precision: Option<Precision>,
    /// Estimated errors of the position.
    pub errors: Option<Errors>,
    /// Whether a sentence that carries positions was among them, with or without one.
    pub positional: bool,
}

impl Epoch {
    /// The reading that the vessel gets of it. A position entered by hand (7) or simulated (8) is not a measured one and is
    /// left out. A speed without course is that of a vessel that stands, where it is small enough, and none where it is not.
    pub fn reading(&self) -> GnssReading {
        let quality = self.quality.and_then(measured);
        let fix = self.lat_lon_rad.zip(quality).map(|((lat_rad, lon_rad), quality)| GnssFix {
            lat_rad,
            lon_rad,
            height_m: self.height_m.unwrap_or(f64::NAN),
            quality,
            hdop: self.hdop.unwrap_or(f64::NAN),
        });
        let velocity = self
            .speed_mps
            .map(|speed_mps| GroundVelocity { course_rad: self.course_rad.unwrap_or(f64::NAN), speed_mps });
        GnssReading {
            utc: self.carried_utc,
            fix,
            satellites: self.satellites.unwrap_or(0),
            velocity: velocity.filter(|velocity| velocity.course_rad.is_finite() || velocity.stands()),
            heading_rad: self.heading_rad,
            yaw_rate_rad_s: self.yaw_rate_rad_s,
            roll_rad: self.attitude.and_then(|attitude| attitude.roll_rad),
            pitch_rad: self.attitude.and_then(|attitude| attitude.pitch_rad),
            magnetic_heading_rad: self.magnetic_heading_rad,
        }
    }
}

/// The quality of a measured position by GGA's number.
const fn measured(number: u8) -> Option<Quality> {
    match number {
        1 | 3 | 9 => Some(Quality::Autonomous),
        2 => Some(Quality::Differential),
        4 => Some(Quality::RtkFixed),
        5 => Some(Quality::RtkFloat),
        6 => Some(Quality::Estimated),
        _ => None,
    }
}

/// Gathers reports into epochs.
#[derive(Debug, Clone, Default)]
pub struct Epochs {
    at_hand: Gathering,
    /// The kinds of the last epoch in their order, each once.
    order: Vec<Kind>,
    /// For how many epochs it was so.
    steady: u8,
    /// The day of the last date, and the time of day that came last with it.
    day: Option<(UtcTime, TimeOfDay)>,
}

/// The epoch at hand.
#[derive(Debug, Clone, Default)]
struct Gathering {
    /// In their order, each once: as many as there are kinds, at most.
    kinds: Vec<Kind>,
    epoch: Epoch,
    midnight: Option<UtcTime>,
}

impl Epochs {
    /// Takes the next report; answers with the epoch before it, if the report begins another. Sentences of no use to
    /// an epoch change nothing.
    pub fn take(&mut self, report: &Report) -> Option<Epoch> {
        if report.kind() == Kind::Other {
            return None;
        }
        let over = self.begins(report).then(|| self.close()).flatten();
        self.at_hand.add(report);
        over
    }

    /// Ends the epoch at hand, if there is one: the line is quiet, or the stream over.
    pub fn close(&mut self) -> Option<Epoch> {
        if self.at_hand.kinds.is_empty() {
            return None;
        }
        let Gathering { kinds, mut epoch, midnight } = std::mem::take(&mut self.at_hand);
        self.learn(kinds);
        epoch.utc = epoch.time.zip(midnight).map(|(time, midnight)| of(midnight, time));
        epoch.carried_utc = self.carry(epoch.time, midnight);
        Some(epoch)
    }

    /// Forgets the epoch at hand, as when a port was opened again.
    pub fn clear(&mut self) {
        self.at_hand = Gathering::default();
    }

    /// The kinds of sentences in the epoch at hand, in their order.
    pub fn kinds(&self) -> &[Kind] {
        &self.at_hand.kinds
    }

    fn begins(&self, report: &Report) -> bool {
        let Gathering { kinds, epoch, .. } = &self.at_hand;
        let kind = report.kind();
        let another_time = epoch.time.zip(report.time()).is_some_and(|(held, time)| held != time);
        another_time || (kinds.contains(&kind) && kind != Kind::Gsa) || self.goes_back(kind)
    }

    /// Whether a sentence stands before the last one in an order that was kept.
    fn goes_back(&self, kind: Kind) -> bool {
        let place = |kind| self.order.iter().position(|&one| one == kind);
        let Some(last) = self.at_hand.kinds.last() else { return false };
        self.steady >= STEADY
            && kind != Kind::Gsa
            && place(kind).zip(place(*last)).is_some_and(|(kind, last)| kind < last)
    }

    /// Compares the order of an epoch with the one known. One that lacks sentences of it says nothing against it.
    fn learn(&mut self, kinds: Vec<Kind>) {
        let mut rest = self.order.iter();
        let within = kinds.iter().all(|kind| rest.any(|one| one == kind));
        if within {
            self.steady = self.steady.saturating_add(u8::from(kinds.len() == self.order.len()));
        } else {
            // One epoch that another sentence joined, or another order, from which learning begins again.
            self.steady = 1;
            self.order = kinds;
        }
    }

    /// Date and time by the date that came last; a time of day that fell by more than half a day is of the next day.
    fn carry(&mut self, time: Option<TimeOfDay>, midnight: Option<UtcTime>) -> Option<UtcTime> {
        let time = time?;
        let day = match (midnight, self.day) {
            (Some(midnight), _) => midnight,
            (None, Some((day, last))) if time.micros + (DAY_US / 2) as u64 <= last.micros => {
                UtcTime::from_micros(day.micros().saturating_add(DAY_US))
            }
            (None, Some((day, _))) => day,
            (None, None) => return None,
        };
        self.day = Some((day, time));
        Some(of(day, time))
    }
}

fn of(midnight: UtcTime, time: TimeOfDay) -> UtcTime {
    // A time of day is at most 24 h, and dates are of the years 1980 to 2999.
    UtcTime::from_micros(midnight.micros() + time.micros as i64)
}

impl Gathering {
    fn add(&mut self, report: &Report) {
        let kind = report.kind();
        if !self.kinds.contains(&kind) {
            self.kinds.push(kind);
        }
        let epoch = &mut self.epoch;
        epoch.time = epoch.time.or(report.time());
        match *report {
            Report::Gga(position) => epoch.position(&position),
            Report::Vtg { course_rad, speed_mps } => {
                epoch.course_rad = course_rad.or(epoch.course_rad);
                epoch.speed_mps = speed_mps.or(epoch.speed_mps);
            }
            Report::Zda(DateTime { midnight, .. }) => self.midnight = midnight.or(self.midnight),
            Report::Hdt(heading_rad) => epoch.heading_rad = heading_rad.or(epoch.heading_rad),
            Report::Hdm(heading_rad) => epoch.magnetic_heading_rad = heading_rad,
            Report::Rot(rate) => epoch.yaw_rate_rad_s = rate,
            Report::Rmc(minimum) => {
                self.midnight = self.midnight.or(minimum.date.midnight);
                // GGA says more of a position and counts where it has come; VTG of movement likewise.
                if !self.kinds.contains(&Kind::Gga) {
                    epoch.lat_lon_rad = minimum.lat_lon_rad;
                    epoch.quality = minimum.quality;
                }
                epoch.course_rad = epoch.course_rad.or(minimum.course_rad);
                epoch.speed_mps = epoch.speed_mps.or(minimum.speed_mps);
                epoch.positional = true;
            }
            Report::Gsa(precision) => {
                epoch.precision = Some(precision);
                epoch.hdop = epoch.hdop.or(precision.hdop);
            }
            Report::Gst(errors) => epoch.errors = Some(errors),
            Report::Hpr(attitude) | Report::Pashr(attitude) => {
                epoch.attitude = Some(attitude);
                epoch.heading_rad = epoch.heading_rad.or(attitude.heading_rad);
            }
            Report::Other => {}
        }
    }
}

impl Epoch {
    fn position(&mut self, position: &Position) {
        self.lat_lon_rad = position.lat_lon_rad;
        self.quality = position.quality.or(self.quality);
        self.satellites = position.satellites;
        self.hdop = position.hdop.or(self.hdop);
        let height_m = position.height_geoid_m.zip(position.separation_m);
        self.height_m = height_m.map(|(geoid_m, separation_m)| geoid_m + separation_m);
        self.positional = true;
    }
}
