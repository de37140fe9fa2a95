//! The offset of the computer's clock to the satellites', and its uncertainty.
//!
//! Two sources: the messages of the receiver, which arrive some tenths of a second after their epoch, and the pulse at each
//! whole second, whose moment the kernel notes by the computer's clock. The messages say which second it is, the pulse
//! where it begins. chrony sets the clock; this only judges it, since what is recorded and the
//! hydrophone's clock go by it. The brain's own deadlines run on a steady time and are not affected.
//!
//! A receiver must report an epoch before the next pulse (within a second of its own), or the second is off by one.

use crate::bus::Bus;
use crate::entity::Entity;
use crate::output::Level;
use crate::settings::WatchSettings;
use crate::states::{Condition, States};
use devices::{GnssReading, PulseReading};
use std::collections::VecDeque;
use std::time::Duration;
use units::{MonoTime, UtcTime};

/// A step of the clock that is worth telling (µs).
const STEP_US: i64 = 500_000;
const SECOND_US: i64 = 1_000_000;
/// Pulses whose spread is the jitter.
const PULSES: usize = 16;
/// So many are needed before the pulse counts.
const SETTLED: usize = 8;
/// Whole seconds by the messages, of which the most frequent counts, and how often it must have come.
const SECONDS: usize = 10;
const AGREED: usize = 6;
/// A pulse that is later than this is missing.
const PULSE_SILENCE: Duration = Duration::from_millis(2_500);
/// A pulse farther than this from the middle of the others is noise on the wire (µs); so is a spread of as much.
const NOISE_US: i64 = 1_000;
/// How fast a Raspberry Pi's clock may run away when nothing holds it: its crystal's tolerance.
const DRIFT: f64 = 20e-6;
/// How far a time by the messages alone may be off (s).
const COARSE_S: f64 = 0.5;
/// The clock is good enough to say how long an epoch was under way where it is this far ahead of it on arrival (s): a compass
/// needs a tenth or two to work it out, and a line of 19200 baud as long to carry it.
const GOOD_S: std::ops::RangeInclusive<f64> = -0.05..=0.6;
/// No epoch is longer under way (µs).
const LONGEST_LAG_US: i64 = 1_000_000;
/// How often the figures go out while the quality stays the same.
const FIGURES_EVERY: Duration = Duration::from_secs(10);

/// By what the offset is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Quality {
    /// Not compared with the satellites since the start, or since it was set.
    Unknown,
    /// By the messages of the receiver.
    Coarse,
    /// By the pulse.
    Precise,
    /// By a pulse that is gone.
    Holdover,
}

impl Quality {
    fn name(self) -> &'static str {
        match self {
            Self::Unknown => "unknown",
            Self::Coarse => "coarse",
            Self::Precise => "precise",
            Self::Holdover => "holdover",
        }
    }
}

/// The estimate of the clock's offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Judgement {
    pub(crate) quality: Quality,
    /// The computer's clock minus the satellites' (s); 0 while unknown.
    pub(crate) offset_s: f64,
    /// Standard deviation of the pulses (s); 0 without.
    pub(crate) jitter_s: f64,
    /// How wrong a time of the records may be (s); infinite while unknown.
    pub(crate) bound_s: f64,
}

impl Judgement {
    fn words(&self) -> String {
        let Self { quality, offset_s, jitter_s, .. } = *self;
        match quality {
            Quality::Unknown => "not compared with satellites".to_owned(),
            Quality::Coarse => format!("{offset_s:+.1} s to the satellites"),
            Quality::Precise => {
                format!("{} to the satellites by the pulse, jitter {}", short(offset_s), short(jitter_s))
            }
            Quality::Holdover => "held without a pulse".to_owned(),
        }
    }
}

/// The clock.
#[derive(Debug, Clone, Default)]
pub(crate) struct Clock {
    last: Option<(MonoTime, UtcTime)>,
    /// The computer's clock minus that of the satellites by the messages (s), smoothed.
    coarse_s: Option<f64>,
    pulse: Pulse,
    /// The last whole comparison with a message: the satellites' clock minus the computer's (µs), and the computer's time
    /// when it was made. For chrony.
    latest: Option<(UtcTime, i64)>,
    /// When the figures go out again, and with which quality they went.
    figures: Option<(MonoTime, &'static str)>,
}

/// The pulses since the clock was set.
#[derive(Debug, Clone, Default)]
struct Pulse {
    last: Option<(MonoTime, PulseReading)>,
    /// Of each, how far after a whole second of the computer it was (µs), from -500,000 to 499,999.
    fractions_us: VecDeque<i64>,
    /// Whole seconds that the computer is ahead, by messages that followed a pulse.
    seconds: VecDeque<i64>,
    /// Offset and jitter (s) when all was known last.
    known: Option<(f64, f64)>,
}

impl Pulse {
    fn take(&mut self, now: MonoTime, reading: PulseReading) {
        let fraction_us = (reading.utc.micros() + SECOND_US / 2).rem_euclid(SECOND_US) - SECOND_US / 2;
        self.last = Some((now, reading));
        self.fractions_us.push_back(fraction_us);
        if self.fractions_us.len() > PULSES {
            self.fractions_us.pop_front();
        }
        self.known = self.measured().or(self.known);
    }

    /// The receiver reports a whole second, after the pulse that began it, at this time of the computer.
    fn second(&mut self, arrived: UtcTime, epoch: UtcTime) {
        // Pulses are polled ten times a second: the message may come before its own pulse was seen.
        let follows = |reading: &PulseReading| (0..SECOND_US).contains(&(arrived - reading.utc));
        let Some(reading) = self.last.map(|(_, reading)| reading).filter(follows) else { return };
        let ahead_us = reading.utc - epoch;
        self.seconds.push_back((ahead_us as f64 / SECOND_US as f64).round() as i64);
        if self.seconds.len() > SECONDS {
            self.seconds.pop_front();
        }
        self.known = self.measured().or(self.known);
    }

    /// Offset and jitter (s), when enough pulses agree with each other, and enough messages on the second.
    fn measured(&self) -> Option<(f64, f64)> {
        if self.fractions_us.len() < SETTLED {
            return None;
        }
        let mut sorted: Vec<i64> = self.fractions_us.iter().copied().collect();
        sorted.sort_unstable();
        let middle_us = sorted[sorted.len() / 2];
        let good: Vec<f64> = sorted
            .iter()
            .filter(|one| (**one - middle_us).abs() <= NOISE_US)
            .map(|one| *one as f64 * 1e-6)
            .collect();
        if good.len() < SETTLED {
            return None;
        }
        let count = good.len() as f64;
        let mean_s = good.iter().sum::<f64>() / count;
        let jitter_s = (good.iter().map(|one| (one - mean_s).powi(2)).sum::<f64>() / count).sqrt();
        let seconds = *self.seconds.iter().max_by_key(|one| self.votes(**one))?;
        (self.votes(seconds) >= AGREED).then_some((seconds as f64 + mean_s, jitter_s))
    }

    fn votes(&self, seconds: i64) -> usize {
        self.seconds.iter().filter(|one| **one == seconds).count()
    }

    /// How long ago the last one was.
    fn silence(&self, now: MonoTime) -> Option<Duration> {
        self.last.map(|(at, _)| now.since(at))
    }
}

impl Clock {
    /// Compares both times of the computer; answers a step of the clock (µs).
    pub(crate) fn check(&mut self, bus: &mut Bus) -> Option<i64> {
        let (mono, utc) = (bus.mono(), bus.utc());
        let last = self.last.replace((mono, utc));
        let (mono_before, utc_before) = last?;
        // A gap of days fits 63 bits of microseconds.
        let step = (utc - utc_before) - mono.since(mono_before).as_micros() as i64;
        if step.abs() < STEP_US {
            return None;
        }
        self.coarse_s = None;
        self.pulse = Pulse::default();
        let text = format!(
            "the clock was set by {:+.1} s; records and the hydrophone's clock notice",
            step as f64 / 1e6
        );
        bus.entry(Entity::Clock, Level::Warning, text);
        Some(step)
    }

    /// Compares the clock with that of the satellites, whose epochs arrive a little after they were: this one at `at`.
    pub(crate) fn compare(&mut self, bus: &Bus, at: MonoTime, reading: &GnssReading) {
        let Some(epoch) = reading.utc.filter(|_| reading.fix.is_some()) else { return };
        let arrived = bus.utc_of(at);
        self.latest = Some((arrived, epoch - arrived));
        let offset_s = (arrived - epoch) as f64 / 1e6;
        let before = self.coarse_s.unwrap_or(offset_s);
        self.coarse_s = Some(before + 0.2 * (offset_s - before));
        if epoch.micros().rem_euclid(SECOND_US) == 0 {
            self.pulse.second(arrived, epoch);
        }
    }

    /// A pulse of the receiver.
    pub(crate) fn pulse(&mut self, at: MonoTime, reading: PulseReading) {
        self.pulse.take(at, reading);
    }

    /// How long before its arrival an epoch was, by its own time where the clock is good enough; zero where it is not.
    pub(crate) fn lag(&self, bus: &Bus, at: MonoTime, reading: &GnssReading) -> Duration {
        let good = self.coarse_s.is_some_and(|offset_s| GOOD_S.contains(&offset_s));
        let lag_us = reading.utc.filter(|_| good).map_or(0, |epoch| bus.utc_of(at) - epoch);
        // Both bounds are well within 64 bits.
        Duration::from_micros(lag_us.clamp(0, LONGEST_LAG_US).unsigned_abs())
    }

    /// The last comparison with a message: the computer's time, and the satellites' minus it (µs).
    pub(crate) fn latest(&self) -> Option<(UtcTime, i64)> {
        self.latest
    }

    /// The present estimate.
    pub(crate) fn judge(&self, now: MonoTime) -> Judgement {
        let coarse = |offset_s: f64| Judgement {
            quality: Quality::Coarse,
            offset_s,
            jitter_s: 0.0,
            bound_s: offset_s.abs() + COARSE_S,
        };
        let unknown =
            Judgement { quality: Quality::Unknown, offset_s: 0.0, jitter_s: 0.0, bound_s: f64::INFINITY };
        let by_messages = self.coarse_s.map_or(unknown, coarse);
        let (Some((offset_s, jitter_s)), Some(silence)) = (self.pulse.known, self.pulse.silence(now)) else {
            return by_messages;
        };
        // The uncertainty without a pulse grows until that of the messages is smaller.
        let bound_s = offset_s.abs() + 3.0 * jitter_s + DRIFT * silence.as_secs_f64();
        let quality = if silence < PULSE_SILENCE { Quality::Precise } else { Quality::Holdover };
        let by_pulse = Judgement { quality, offset_s, jitter_s, bound_s };
        if bound_s <= by_messages.bound_s { by_pulse } else { by_messages }
    }

    /// The time of the satellites (s), if known; else that of the computer.
    pub(crate) fn satellite_seconds(&self, bus: &Bus) -> f64 {
        bus.seconds() - self.judge(bus.mono()).offset_s
    }

    /// Why the clock is not good enough to set out by.
    pub(crate) fn doubt(&self, now: MonoTime, settings: &WatchSettings) -> Option<String> {
        let Judgement { quality, offset_s, .. } = self.judge(now);
        match quality {
            Quality::Unknown => Some("clock (not compared with the satellites yet)".to_owned()),
            _ if offset_s.abs() > settings.clock_offset_s => {
                Some(format!("clock ({offset_s:+.1} s off the satellites)"))
            }
            _ => None,
        }
    }

    /// Says how the clock is, in words and in figures.
    pub(crate) fn watch(&mut self, bus: &mut Bus, states: &mut States, settings: &WatchSettings) {
        let judgement = self.judge(bus.mono());
        let fault = self.fault(bus.mono(), &judgement, settings);
        let condition = if fault.is_some() { Condition::Fault } else { Condition::Normal };
        states.set(bus, Entity::Clock, condition, fault.unwrap_or_else(|| judgement.words()));
        self.tell_figures(bus, states, &judgement);
    }

    fn fault(&self, now: MonoTime, judgement: &Judgement, settings: &WatchSettings) -> Option<String> {
        let Judgement { quality, offset_s, .. } = *judgement;
        let off = match quality {
            Quality::Unknown => None,
            Quality::Coarse => (offset_s.abs() > settings.clock_offset_s).then(|| {
                format!("{offset_s:+.1} s off the satellites; records carry wrong times until it is set")
            }),
            Quality::Precise | Quality::Holdover => (offset_s.abs() > settings.pulse_offset_s).then(|| {
                format!(
                    "{} off the satellites by the pulse; records and detections carry it: see whether chrony runs",
                    short(offset_s)
                )
            }),
        };
        // Where a pulse is configured, a missing one is reported, once it could have come.
        let silent = self
            .pulse
            .silence(now)
            .map_or(now.micros() > 30 * SECOND_US as u64, |silence| silence >= PULSE_SILENCE);
        off.or_else(|| {
            (settings.pulse_expected && silent)
                .then(|| "no pulse from the receiver: see its wire and Pulse Device".to_owned())
        })
    }

    fn tell_figures(&mut self, bus: &Bus, states: &mut States, judgement: &Judgement) {
        let name = judgement.quality.name();
        if self.figures.is_some_and(|(again, last)| last == name && bus.mono() < again) {
            return;
        }
        self.figures = Some((bus.mono() + FIGURES_EVERY, name));
        let micros = |value_s: f64| format!("{:.0}", value_s * 1e6);
        let mut pairs = vec![("quality", name.to_owned())];
        if judgement.quality != Quality::Unknown {
            pairs.push(("offset_us", micros(judgement.offset_s)));
            pairs.push(("jitter_us", micros(judgement.jitter_s)));
            pairs.push(("bound_us", micros(judgement.bound_s)));
        }
        states.values(Entity::Clock, &pairs);
    }
}

/// A time in the unit that it is read in.
fn short(value_s: f64) -> String {
    match value_s.abs() {
        large if large >= 1.0 => format!("{value_s:+.1} s"),
        middle if middle >= 1e-3 => format!("{:+.1} ms", value_s * 1e3),
        _ => format!("{:+.0} µs", value_s * 1e6),
    }
}

#[cfg(test)]
mod tests;
