//! The GNSS compass: its settings, its epochs as readings, and whether it works.
//!
//! An epoch ends when all kinds of sentences have come that the last epochs had, when the line is quiet, or when the next
//! begins, whichever is first: so a reading does not wait for the next second, and a lost sentence mixes no two epochs. A
//! remnant without position or heading, such as a sentence after a pause, gives no reading where epochs have positions.
//!
//! The compass fails when no usable sentence came for a while, and reports what did come: nothing, bytes that form no
//! sentence (wrong baud rate), or unusable sentences (wrong settings). While it fails its settings are sent again, after
//! waits that double, for a receiver that lost its power loses them; the command that saves them to flash is sent once a
//! day at most. One epoch and one sentence are kept.
//!
//! A Hemisphere whose speed differs from the line's (as delivered, 4800 bit/s) is switched over: `$JBAUD` is sent at each
//! speed that it can have, then the line returns to its own speed.

use crate::outbox::Outbox;
use crate::{Driver, Input, Output, State};
use core::time::Duration;
use devices::Reading;
use devices::nmea::{DamagedSentence, Epoch, Epochs, Framer, Kind, Report};
use units::{MonoTime, Now, wrap_two_pi};

/// So many bytes without a valid sentence are babble: some eight sentences.
const BABBLE_BYTES: u64 = 512;
/// So many bytes are some when time is up: less may be the noise of a plug.
const BABBLE_LEAST: u64 = 64;
/// The longest wait before the settings are sent again.
const LONGEST_WAIT: Duration = Duration::from_mins(1);
/// Settings are written into the receiver's memory again after this.
const SAVE_AGAIN: Duration = Duration::from_hours(24);
/// Speeds that a receiver can have (bit/s): what Hemisphere's `$JBAUD` takes, the one it is delivered with first.
const SPEEDS: [u32; 6] = [4_800, 9_600, 19_200, 38_400, 57_600, 115_200];
/// Bits on the line for a byte: start, eight data, stop.
const BITS_PER_BYTE: u32 = 10;
/// How long the line keeps a speed after the last byte has left, and the receiver has to change its own.
const SETTLING: Duration = Duration::from_millis(50);
/// The start of a Hemisphere's commands.
const HEMISPHERE: &str = "$J";
/// Epochs that must agree before their kinds of sentences are waited for, or a position is missed.
const LEARNED: usize = 3;

/// The settings of a compass.
#[derive(Debug, Clone, PartialEq)]
pub struct CompassSettings {
    /// Sent one after another when the port opens, each with CR LF behind it.
    pub init: Vec<String>,
    /// Speed of the serial line (bit/s), to which a Hemisphere is switched; `None` for a line without a speed.
    pub baud: Option<u32>,
    /// Added to the true heading for how the antennas are mounted (rad, clockwise).
    pub heading_offset_rad: f64,
    /// Added to a magnetic heading, used while the compass gives no true one (rad, east positive); `None` leaves it out.
    pub variation_rad: Option<f64>,
    /// Without anything of use for so long the compass fails.
    pub input_timeout: Duration,
    /// Silence that ends an epoch: longer than pauses between its sentences, shorter than those between epochs.
    pub quiet: Duration,
}

impl Default for CompassSettings {
    /// The sentences of the Otters' V104s each second; 4 s of silence fail, 100 ms end an epoch.
    fn default() -> Self {
        let sentences = ["GPGGA", "GPVTG", "GPZDA", "GPROT", "GPHDT", "GPHDM"];
        let mut init: Vec<String> = sentences.iter().map(|name| format!("$JASC,{name},1")).collect();
        init.push("$JATT,NMEAHE,0".to_owned());
        Self {
            init,
            baud: None,
            heading_offset_rad: 0.0,
            variation_rad: None,
            input_timeout: Duration::from_secs(4),
            quiet: Duration::from_millis(100),
        }
    }
}

/// Counts since the port opened.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Bytes.
    pub bytes: u64,
    /// Valid sentences.
    pub sentences: u64,
    /// Damaged sentences.
    pub damaged: u64,
    /// Epochs given as readings.
    pub epochs: u64,
}

/// The driver of a GNSS compass.
#[derive(Debug, Clone)]
pub struct Compass {
    settings: CompassSettings,
    framer: Framer,
    gathering: Gathering,
    outbox: Outbox,
    counts: Counts,
    watch: Option<Watch>,
    resend: Resend,
    /// When the last true heading came.
    true_heading: Option<MonoTime>,
}

/// When the settings are sent again.
#[derive(Debug, Clone, Copy, Default)]
struct Resend {
    at: MonoTime,
    wait: Duration,
    /// When they were saved last.
    saved: Option<MonoTime>,
}

/// The epoch at hand and what is usual.
#[derive(Debug, Clone, Default)]
struct Gathering {
    epochs: Epochs,
    /// When the first sentence of the epoch at hand came.
    begun: Now,
    /// When the line counts as quiet.
    quiet_at: Option<MonoTime>,
    /// The kinds of sentences of the last epochs, and whether they had positions.
    usual: Vec<(Vec<Kind>, bool)>,
}

/// The state while the port is open.
#[derive(Debug, Clone, Copy)]
struct Watch {
    /// When the compass fails unless something of use comes.
    deadline: MonoTime,
    /// Bytes since the last valid sentence.
    babble: u64,
    /// Valid but unusable sentences since the last usable one.
    useless: u64,
}

impl Compass {
    /// A compass behind a port that is not open.
    pub fn new(settings: CompassSettings) -> Self {
        let mut outbox = Outbox::default();
        outbox.state(State::Starting);
        Self {
            settings,
            framer: Framer::default(),
            gathering: Gathering::default(),
            outbox,
            counts: Counts::default(),
            watch: None,
            resend: Resend::default(),
            true_heading: None,
        }
    }

    /// Counts since the port opened.
    pub const fn counts(&self) -> Counts {
        self.counts
    }

    fn opened(&mut self, now: Now) {
        self.framer.clear();
        self.gathering = Gathering::default();
        self.counts = Counts::default();
        self.watch = Some(Watch { deadline: now.mono + self.settings.input_timeout, babble: 0, useless: 0 });
        self.outbox.state(State::Starting);
        self.resend.wait = self.settings.input_timeout;
        self.send_settings(now, now.mono);
    }

    /// Sends the settings from `at` on, and lays down when they are sent again at the earliest.
    fn send_settings(&mut self, now: Now, at: MonoTime) {
        self.resend.at = now.mono + self.resend.wait;
        self.resend.wait = (self.resend.wait * 2).min(LONGEST_WAIT.max(self.settings.input_timeout));
        let save = self.resend.saved.is_none_or(|saved| now.mono.since(saved) >= SAVE_AGAIN);
        let init = &self.settings.init;
        if save && init.iter().any(|line| saves(line)) {
            self.resend.saved = Some(now.mono);
        }
        for line in init.iter().filter(|line| save || !saves(line)) {
            let bytes = format!("{line}\r\n").into_bytes();
            self.outbox.push(Output::Send { bytes, at, pace: Duration::ZERO });
        }
    }

    /// Commands a Hemisphere at each other speed to switch to the line's; returns when the line has its own again.
    fn change_speed(&mut self, now: Now) -> MonoTime {
        let told = self.settings.init.iter().any(|line| line.starts_with(HEMISPHERE));
        let Some(baud) = self.settings.baud.filter(|baud| told && SPEEDS.contains(baud)) else {
            return now.mono;
        };
        let mut at = now.mono;
        for other in SPEEDS.into_iter().filter(|speed| *speed != baud) {
            let bytes = format!("$JBAUD,{baud}\r\n").into_bytes();
            // A command has some twenty bytes.
            let bits = bytes.len() as u32 * BITS_PER_BYTE;
            let leaving = Duration::from_secs_f64(f64::from(bits) / f64::from(other));
            self.outbox.push(Output::Speed { baud: other, at });
            self.outbox.push(Output::Send { bytes, at, pace: Duration::ZERO });
            at = at + leaving + SETTLING;
        }
        self.outbox.push(Output::Speed { baud, at });
        at + SETTLING
    }

    fn bytes(&mut self, now: Now, bytes: &[u8]) {
        self.counts.bytes += bytes.len() as u64;
        let mut reads = Vec::new();
        self.framer.feed(bytes, |_, read| reads.push(read));
        if let Some(watch) = &mut self.watch {
            watch.babble += bytes.len() as u64;
        }
        for read in reads {
            match read {
                Ok(report) => self.report(now, &report),
                Err(error) => self.damage(&error),
            }
        }
        if !self.gathering.epochs.kinds().is_empty() {
            self.gathering.quiet_at = Some(now.mono + self.settings.quiet);
        }
        if self.watch.is_some_and(|watch| watch.babble >= BABBLE_BYTES) && !self.outbox.is_failing() {
            self.fail(now);
        }
    }

    fn report(&mut self, now: Now, report: &Report) {
        self.counts.sentences += 1;
        if let Some(watch) = &mut self.watch {
            watch.babble = 0;
            if report.kind() == Kind::Other {
                watch.useless += 1;
                return;
            }
            *watch = Watch { deadline: now.mono + self.settings.input_timeout, babble: 0, useless: 0 };
        }
        self.outbox.state(State::Working);
        let kinds = self.gathering.epochs.kinds().to_vec();
        if let Some(epoch) = self.gathering.epochs.take(report) {
            self.give(&epoch, kinds);
        }
        if self.gathering.epochs.kinds().len() == 1 {
            self.gathering.begun = now;
        }
        if self.gathering.is_complete() {
            self.close();
        }
    }

    fn damage(&mut self, error: &DamagedSentence) {
        self.counts.damaged += 1;
        // The first, the tenth, the hundredth: a bad cable does not fill the log.
        if self.counts.damaged.checked_ilog10().is_some_and(|power| 10_u64.pow(power) == self.counts.damaged)
        {
            let Counts { sentences, damaged, .. } = self.counts;
            let text = format!("{damaged} damaged sentences beside {sentences} good ones, the last: {error}");
            self.outbox.note(true, text);
        }
    }

    /// Ends the epoch at hand.
    fn close(&mut self) {
        self.gathering.quiet_at = None;
        let kinds = self.gathering.epochs.kinds().to_vec();
        if let Some(epoch) = self.gathering.epochs.close() {
            self.give(&epoch, kinds);
        }
    }

    fn give(&mut self, epoch: &Epoch, kinds: Vec<Kind>) {
        let missed = !epoch.positional && epoch.heading_rad.is_none() && self.gathering.has_positions();
        if missed {
            return;
        }
        self.gathering.learn(kinds, epoch.positional);
        let mut reading = epoch.reading();
        let begun = self.gathering.begun.mono;
        let CompassSettings { heading_offset_rad, variation_rad, input_timeout, .. } = self.settings;
        let turned = |heading_rad: f64| wrap_two_pi(heading_rad + heading_offset_rad);
        reading.magnetic_heading_rad = reading.magnetic_heading_rad.map(turned);
        if let Some(heading_rad) = &mut reading.heading_rad {
            *heading_rad = turned(*heading_rad);
            self.true_heading = Some(begun);
        } else if self.true_heading.is_none_or(|at| begun.since(at) >= input_timeout) {
            // A sentence that was lost is not a reason to go over to another kind of heading.
            let magnetic = reading.magnetic_heading_rad.zip(variation_rad);
            reading.heading_rad = magnetic.map(|(magnetic, variation)| wrap_two_pi(magnetic + variation));
        }
        self.counts.epochs += 1;
        self.outbox.push(Output::Reading { at: self.gathering.begun, reading: Reading::Gnss(reading) });
    }

    /// No usable sentence came in time: reports what did come, and sends the settings again.
    fn fail(&mut self, now: Now) {
        let Some(watch) = &mut self.watch else { return };
        let seconds = self.settings.input_timeout.as_secs_f64();
        let other_speed = watch.useless == 0;
        let why = if watch.babble >= BABBLE_LEAST {
            "bytes come but no valid NMEA sentence: check the baud rate of the port and of the receiver"
                .to_owned()
        } else if watch.useless > 0 {
            "NMEA comes but no position, time or heading: check the initialisation strings".to_owned()
        } else {
            format!(
                "nothing came for {seconds} s: check power and cable of the receiver, that the port is its own, and both baud rates"
            )
        };
        *watch = Watch { deadline: now.mono + self.settings.input_timeout, babble: 0, useless: 0 };
        self.outbox.state(State::Failing(why));
        if self.resend.at <= now.mono {
            let at = if other_speed { self.change_speed(now) } else { now.mono };
            self.send_settings(now, at);
        }
    }

    fn time(&mut self, now: Now) {
        if self.gathering.quiet_at.is_some_and(|at| at <= now.mono) {
            self.close();
        }
        if self.watch.is_some_and(|watch| watch.deadline <= now.mono) {
            self.fail(now);
        }
    }
}

/// Whether a command writes into the receiver's flash memory.
fn saves(line: &str) -> bool {
    line.starts_with("$JSAVE") || line.ends_with(",SAVE")
}

impl Gathering {
    fn learn(&mut self, kinds: Vec<Kind>, positional: bool) {
        if self.usual.len() == LEARNED {
            self.usual.remove(0);
        }
        self.usual.push((kinds, positional));
    }

    /// Whether all kinds are there that came in any of the last epochs.
    fn is_complete(&self) -> bool {
        let held = self.epochs.kinds();
        self.usual.len() == LEARNED
            && self.usual.iter().all(|(kinds, _)| kinds.iter().all(|kind| held.contains(kind)))
    }

    fn has_positions(&self) -> bool {
        self.usual.len() == LEARNED && self.usual.iter().all(|(_, positional)| *positional)
    }
}

impl Driver for Compass {
    fn longest_silence(&self) -> Option<Duration> {
        Some(2 * self.settings.input_timeout)
    }

    fn handle(&mut self, now: Now, input: Input<'_>) {
        match input {
            Input::Opened => self.opened(now),
            Input::Bytes(bytes) => self.bytes(now, bytes),
            Input::Lost => {
                self.close();
                self.watch = None;
                self.outbox.port_lost();
            }
            Input::Time => self.time(now),
        }
    }

    fn poll_output(&mut self) -> Option<Output> {
        self.outbox.pop()
    }

    fn poll_timeout(&self) -> Option<MonoTime> {
        let fails_at = self.watch.map(|watch| watch.deadline);
        fails_at.into_iter().chain(self.gathering.quiet_at).min()
    }
}

#[cfg(test)]
mod tests;
