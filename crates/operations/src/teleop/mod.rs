//! Steering by hand from ashore: from a person's stick input to thrust, and to zero thrust.
//!
//! [`Teleop`] takes the samples of one window and the time, and gives the commands to the vessel. A boat is kept
//! moving never by messages alone, but only by a person's fresh input with the dead-man held:
//!
//! - A sample is as old as its echo of the server's own clock, so that no clock of a browser can make it younger: the
//!   whole way there and back counts. To that comes, while the dead-man is held, the time for which the input device
//!   has shown no change. Older than [`MOST_AGE`] it interrupts.
//! - After every interruption, and at the beginning, a fresh sample with the dead-man released and the sticks in
//!   neutral comes first, then one with the dead-man held and the sticks still in neutral; then the boat moves.
//! - Each command to the vessel says how long it is valid ([`Sticks::life`]); aboard it expires on its own.
//!
//! # The budget of 0.75 s from the last fresh human sample to zero thrust
//!
//! | part | ms |
//! |---|---|
//! | age of the sample when the server passes it on, at most [`MOST_AGE`] | a ≤ 250 |
//! | life aboard, counted from the time in the packet: [`LIFE`] at most, [`BUDGET`] less a and the usual way down | ≤ 700 − a − w |
//! | the usual way to the vessel, taken as half of its link's round trip | w |
//! | the loop aboard and the motor command | ≤ 50 |
//!
//! A packet that took longer than usual has that much less life aboard, and none at all beyond it. Nothing in the
//! table needs the server to live: killed, it stops renewing, and the life aboard runs out.
//!
//! | round trip, browser to vessel and back | |
//! |---|---|
//! | over [`WARN_OVER`] | the person is warned |
//! | over [`CAP_OVER`] | thrust is at most [`CAPPED`] |
//! | over [`REFUSE_OVER`] | steering does not begin, and is interrupted if it has begun |

#[cfg(test)]
mod tests;

use api::{Said, say};
use std::time::Duration;
use units::{MonoTime, Now};

/// A person's sample that is older interrupts.
pub const MOST_AGE: Duration = Duration::from_millis(250);
/// Longest life of a stick position aboard.
pub const LIFE: Duration = Duration::from_millis(500);
/// From a person's sample to the end of its life aboard.
pub const BUDGET: Duration = Duration::from_millis(700);
/// A round trip above this is reported.
pub const WARN_OVER: Duration = Duration::from_millis(300);
/// A round trip above this limits thrust to [`CAPPED`].
pub const CAP_OVER: Duration = Duration::from_millis(500);
/// With a round trip above this steering is refused.
pub const REFUSE_OVER: Duration = Duration::from_secs(1);
/// Most thrust and turn while the round trip is long, of 1.
pub const CAPPED: f64 = 0.3;
/// Sticks within this are in neutral, of 1.
pub const NEUTRAL: f64 = 0.08;
/// A browser holds an echo for no longer than this before a sample carries it: it samples at 20 Hz.
const LONGEST_HOLD: Duration = Duration::from_millis(100);
/// A wall clock that moves by more than this against the steady one was set.
const CLOCK_STEP: Duration = Duration::from_millis(100);
/// A stop is sent so often: any one packet may be lost.
const STOPS: u8 = 5;

/// A person's stick input, as a browser reports it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Grows with every sample.
    pub seq: u64,
    /// When it was made, by a clock of the browser that does not step (ms).
    pub made_ms: f64,
    /// Another number than before when the input device has shown life since: a gamepad's own time of change.
    pub change: f64,
    /// The latest echo that the browser had: the server's steady clock when it sent that.
    pub echo: Option<MonoTime>,
    /// How long the browser had it when it made the sample.
    pub echo_held: Duration,
    /// Whether the dead-man is held.
    pub held: bool,
    /// Ahead, −1 to 1.
    pub thrust: f64,
    /// To starboard, −1 to 1.
    pub turn: f64,
}

/// How far steering is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// It waits for the dead-man to be released and the sticks to be in neutral.
    Locked,
    /// The dead-man may be held, with the sticks in neutral.
    Ready,
    /// The sticks steer.
    Steering,
}

/// Why the sticks do not steer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Why {
    /// It just began.
    Begun,
    /// The dead-man was released.
    Released,
    /// No sample came in time.
    Silent,
    /// A sample took too long, or its echo is missing.
    Late,
    /// The input device shows no sign of life.
    Frozen,
    /// The browser's clock jumped.
    Clock,
    /// The server's wall clock was set: the vessel judges by it how late a stick position is.
    ServerClock,
    /// A sample is not valid: one of its values is not a number, or its number is not greater than the previous one.
    Invalid,
    /// The round trip takes too long.
    RoundTrip,
    /// The window was hidden.
    Hidden,
    /// The window or its keys lost the focus.
    Unfocused,
    /// The gamepad that steered is gone.
    GamepadGone,
    /// Two input devices were held at once, or another gamepad came.
    TwoDevices,
    /// No key was pressed or let go, and no finger moved, for too long.
    Unmoved,
    /// The person stopped it, or the window is gone.
    Person,
    /// Control of the vessel is lost.
    Lease,
    /// The vessel is not heard.
    Vessel,
    /// A stick position came to the vessel too late or never.
    Unreached,
}

impl Why {
    /// In words for the person.
    pub fn text(self) -> &'static str {
        match self {
            Self::Begun => "it has just begun",
            Self::Released => "the dead-man was released",
            Self::Silent => "nothing came from the window in time",
            Self::Late => "what the hands did came too late",
            Self::Frozen => "the input device shows no sign of life",
            Self::Clock => "the clock of the computer that steers jumped",
            Self::ServerClock => "the clock of the server was set",
            Self::Invalid => "the window sent something that is not a stick position",
            Self::RoundTrip => "the round trip takes more than 1 s",
            Self::Hidden => "the window was hidden",
            Self::Unfocused => "the keys or the window lost the focus",
            Self::GamepadGone => "the gamepad is gone",
            Self::TwoDevices => "two input devices were used at once",
            Self::Unmoved => "no key was pressed or let go, and no finger moved, for 10 s",
            Self::Person => "the person ended it or left the page",
            Self::Vessel => "the vessel is not heard",
            Self::Unreached => "what the hands did came to the vessel too late",
            Self::Lease => "control of the vessel was lost",
        }
    }

    /// The same, in words of any language.
    pub fn said(self) -> Said {
        say(self.text()).into()
    }

    /// The remedy, in words of any language.
    pub fn remedy_said(self) -> Said {
        let remedy = self.remedy();
        if remedy.is_empty() { Said::default() } else { say(remedy).into() }
    }

    /// The remedy, beyond passing neutral; empty if passing neutral is enough.
    pub fn remedy(self) -> &'static str {
        match self {
            Self::Begun | Self::Released | Self::Person => "",
            Self::Silent => "Look after your network and close what keeps this computer busy.",
            Self::Late => "Your network is slow at present: wait, or send the vessel by a plan.",
            Self::Unreached => "The vessel's network is slow at present: wait, or send the vessel by a plan.",
            Self::Frozen => {
                "A gamepad that is held quite still looks like one that hangs: keep the stick moving a little. If it \
                 hangs, plug it in again or steer with the keys."
            }
            Self::Clock => "If it happens again, see what sets it; steer from another computer meanwhile.",
            Self::ServerClock => {
                "If it was set back, the vessel refuses the sticks for up to a minute: wait, then go on."
            }
            Self::Invalid => "Reload the page.",
            Self::RoundTrip => "Wait until it is shorter, or send the vessel by a plan.",
            Self::Hidden | Self::Unfocused => {
                "Keep this window in front, and its keys in focus, while you steer."
            }
            Self::GamepadGone => "Plug it in again, or steer with keys or touch.",
            Self::TwoDevices => "Hold the dead-man of one device only.",
            Self::Unmoved => {
                "Keys and a touch pad that hang look like that: press or let go any key, or move the finger, at least \
                 every 10 s. If they hang, steer with something else."
            }
            Self::Vessel => "Wait until it is heard again.",
            Self::Lease => "Take control again if you still need it.",
        }
    }
}

/// The command to send to the vessel now.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sticks {
    /// Port motor, −1 to 1, ahead positive.
    pub port: f64,
    /// Starboard motor.
    pub starboard: f64,
    /// How long it is good for, from the time in its packet.
    pub life: Duration,
    /// Whether it is an explicit stop.
    pub stop: bool,
}

impl Sticks {
    const STOP: Self = Self { port: 0.0, starboard: 0.0, life: LIFE, stop: true };

    /// As RemoteActions has it. `Life` (ms) is Lutra's; DUNE passes over names that it does not know, and stops by its
    /// own connection timeout.
    pub fn actions(&self) -> String {
        if self.stop {
            return "Port Motor=0;Starboard Motor=0;Stop=1".to_owned();
        }
        let axis = |value: f64| (value.clamp(-1.0, 1.0) * 127.0).round() as i32;
        let (port, starboard) = (axis(self.port), axis(self.starboard));
        format!("Port Motor={port};Starboard Motor={starboard};Life={}", self.life.as_millis())
    }
}

/// One person's steering of one vessel.
#[derive(Debug, Clone)]
pub struct Teleop {
    state: State,
    /// Why it stopped last.
    why: Why,
    /// Another obstacle since then.
    hinders: Option<Why>,
    last: Option<Last>,
    /// The round trip of the last sample, browser and server alone.
    trip: Option<Duration>,
    /// The vessel link's round trip.
    vessel_trip: Duration,
    /// UTC minus the steady clock at the last tick (µs).
    utc_ahead_us: Option<i64>,
    stops: u8,
}

#[derive(Debug, Clone, Copy)]
struct Last {
    sample: Sample,
    came: MonoTime,
    /// When it was made, at the earliest.
    made: MonoTime,
    /// When the device changed to what the sample says, at the earliest.
    alive: MonoTime,
    /// The device's values are those of the previous sample.
    unchanged: bool,
    /// Since when nothing is known of the person's hands.
    since: MonoTime,
}

impl Default for Teleop {
    fn default() -> Self {
        Self::new()
    }
}

impl Teleop {
    /// Locked; nothing is known yet.
    pub fn new() -> Self {
        Self {
            state: State::Locked,
            why: Why::Begun,
            hinders: None,
            last: None,
            trip: None,
            vessel_trip: Duration::ZERO,
            utc_ahead_us: None,
            stops: STOPS,
        }
    }

    /// How far it is.
    pub fn state(&self) -> State {
        self.state
    }

    /// Why it stopped last.
    pub fn why(&self) -> Why {
        self.why
    }

    /// Another obstacle to continuing since it stopped, if any.
    pub fn hinders(&self) -> Option<Why> {
        self.hinders.filter(|why| self.state == State::Locked && *why != self.why)
    }

    /// The round trip from the browser to the vessel and back, as far as known.
    pub fn round_trip(&self) -> Option<Duration> {
        Some(self.trip? + self.vessel_trip)
    }

    /// How long the vessel's link takes there and back.
    pub fn vessel_trip(&mut self, trip: Duration) {
        self.vessel_trip = trip;
    }

    /// Whether the round trip allows to begin.
    pub fn may_begin(&self) -> bool {
        self.round_trip().is_some_and(|trip| trip <= REFUSE_OVER)
    }

    /// Most thrust and turn at present, of 1.
    pub fn cap(&self) -> f64 {
        if self.round_trip().is_some_and(|trip| trip > CAP_OVER) { CAPPED } else { 1.0 }
    }

    /// The vessel is in the sticks' hands from here on; neutral comes first.
    pub fn begin(&mut self) {
        (self.state, self.why, self.hinders, self.stops) = (State::Locked, Why::Begun, None, STOPS);
    }

    /// Whatever steers stops, and neutral comes first again.
    pub fn interrupt(&mut self, why: Why) {
        if self.state == State::Steering {
            (self.stops, self.why) = (STOPS, why);
        }
        self.hinders = Some(why);
        self.state = State::Locked;
    }

    /// A sample came. What it asks for at once, if it steers.
    pub fn sample(&mut self, now: MonoTime, sample: &Sample) -> Option<Sticks> {
        let judged = self.judge(now, sample);
        let age = match judged {
            Ok(age) => age,
            Err(why) => {
                self.interrupt(why);
                return None;
            }
        };
        self.hinders = None;
        let neutral = sample.thrust.abs() <= NEUTRAL && sample.turn.abs() <= NEUTRAL;
        match (self.state, sample.held) {
            (State::Locked, false) if neutral => self.state = State::Ready,
            (State::Ready, true) if neutral => self.state = State::Steering,
            (State::Steering, false) => self.interrupt(Why::Released),
            _ => {}
        }
        if self.state != State::Steering {
            return None;
        }
        self.stops = 0;
        let way = self.vessel_trip / 2;
        let life = LIFE.min(BUDGET.saturating_sub(age).saturating_sub(way));
        let cap = self.cap();
        let stick = |value: f64| {
            let beyond = (value.abs() - NEUTRAL).max(0.0) / (1.0 - NEUTRAL);
            (beyond.min(1.0) * cap).copysign(value)
        };
        let (thrust, turn) = (stick(sample.thrust), stick(sample.turn));
        let motor = |value: f64| value.clamp(-cap, cap);
        Some(Sticks { port: motor(thrust + turn), starboard: motor(thrust - turn), life, stop: false })
    }

    /// The command to send although no sample came. Call it every 50 ms or so.
    pub fn tick(&mut self, now: Now) -> Option<Sticks> {
        let ahead_us = now.utc.micros().saturating_sub_unsigned(now.mono.micros());
        let before_us = self.utc_ahead_us.replace(ahead_us);
        if before_us.is_some_and(|before| u128::from(before.abs_diff(ahead_us)) > CLOCK_STEP.as_micros()) {
            self.interrupt(Why::ServerClock);
        }
        let now = now.mono;
        if self.state != State::Locked && self.last.is_none_or(|last| now.since(last.since) > MOST_AGE) {
            // Samples still come, but their device shows no change.
            let frozen = self.last.is_some_and(|last| last.unchanged);
            self.interrupt(if frozen { Why::Frozen } else { Why::Silent });
        }
        if self.state == State::Steering || self.stops == 0 {
            return None;
        }
        self.stops -= 1;
        Some(Sticks::STOP)
    }

    /// The age of a sample's input, or why it cannot be used.
    fn judge(&mut self, now: MonoTime, sample: &Sample) -> Result<Duration, Why> {
        let Sample { made_ms, change, thrust, turn, .. } = *sample;
        let before = self.last;
        if ![made_ms, change].into_iter().all(f64::is_finite)
            || ![thrust, turn].into_iter().all(|value| (-1.0..=1.0).contains(&value))
            || before.is_some_and(|last| sample.seq <= last.sample.seq)
        {
            return Err(Why::Invalid);
        }
        let echo = sample.echo.filter(|echo| *echo <= now).ok_or(Why::Late)?;
        let trip = now.since(echo).saturating_sub(sample.echo_held.min(LONGEST_HOLD));
        self.trip = Some(trip);
        // It took no longer than there and back; of that, how much was the way there only a clock could tell.
        let made = earlier(now, trip);
        let alive = match before {
            Some(last) if same(last.sample.change, change) => last.alive,
            // It may have changed right after the sample before was made.
            Some(last) => last.made,
            None => made,
        };
        let unchanged = before.is_some_and(|last| same(last.sample.change, change));
        let since = if sample.held { alive } else { made };
        self.last = Some(Last { sample: *sample, came: now, made, alive, unchanged, since });
        if trip > MOST_AGE {
            return Err(Why::Late);
        }
        if self.round_trip().is_some_and(|trip| trip > REFUSE_OVER) {
            return Err(Why::RoundTrip);
        }
        if let Some(last) = before {
            let by_browser_ms = made_ms - last.sample.made_ms;
            let by_server_ms = now.since(last.came).as_secs_f64() * 1e3;
            if by_browser_ms <= 0.0 || (by_browser_ms - by_server_ms).abs() > MOST_AGE.as_secs_f64() * 1e3 {
                return Err(Why::Clock);
            }
        }
        let age = now.since(since);
        if age > MOST_AGE { Err(Why::Frozen) } else { Ok(age) }
    }
}

fn same(one: f64, other: f64) -> bool {
    one.to_bits() == other.to_bits()
}

fn earlier(now: MonoTime, by: Duration) -> MonoTime {
    MonoTime::from_micros(
        (now.since(MonoTime::default()).as_micros() as u64).saturating_sub(by.as_micros() as u64),
    )
}
