//! Several ways to one shore: a vessel with 4G and a radio keeps a session on each and loses no moment when one dies.
//!
//! # Where the choice is made
//!
//! Aboard, in [`Vessel`](crate::Vessel), for both directions: the vessel sends most, pays for it, and is the first to see
//! that a message is not answered. Each way has its own connection, pauses, clocks and pace. `choice` assigns two lanes to
//! ways: *live values and commands* to the best, *records* to the cheapest good one. The choice is reported to the shore
//! ([`WaysReport`], on the way that carries live values), which sends commands by the way of the latest report.
//!
//! # When a way dies
//!
//! The shore acknowledges every message of such a session at once, heartbeats too. A message that has no acknowledgement after
//! 0.6 s and three times the usual (and the time that the bytes under way need) makes its way *suspect*, long before its
//! connection is given up ([`DEAD_AFTER`]): the lanes go over to another at once. Back they go when the
//! better way has answered without a break for 5 s, after each further break twice as long, up to 5 min: no flapping.
//! After a stall of the vessel's program its ways have 0.6 s more, once: messages that came meanwhile are yet to be read.
//!
//! # How the shore joins the sessions of one vessel
//!
//! Sessions of one stream and one start of the vessel's program run in parallel, one for each way, and share the received
//! records. On a switch the vessel continues with the number that the shore last acknowledged *on the way that takes
//! over*: it may send records again, but never leaves a hole, whatever is still under way on the other. Records with a
//! known number are dropped. Live messages are numbered; one that was overtaken by another way's is dropped, and after a
//! switch records come first, in order, and the latest of each kind again where they lag. (Records that lag for a second
//! are overtaken by the newest values, as over one way.)
//!
//! # Commands
//!
//! Numbers of commands rise within a start of the shore ([`Welcome::run`](crate::frame::Welcome)). Over each way the
//! shore sends all unanswered commands, in order; one without an answer after half a second goes over the other ways too,
//! and a stop goes over all at once. The vessel carries out each number once, and none that comes after a higher one: a
//! command that a stop overtook on another way is refused. Leases are numbered likewise, so that a late frame on a slow
//! way revives no ended lease.
//!
//! # One way, and older programs
//!
//! A vessel with one way sends nothing about ways: each byte is as before. With several it asks for
//! [`Capabilities::WAYS`](crate::Capabilities); an older shore does not answer to that, and then one way is used at a time, and
//! left for the next as soon as it is suspect. Beside a metered way an unmetered one is tried again now and then, and takes over
//! once it connects.
//!
//! # Metered ways
//!
//! All bytes of a day (UTC, and 24 h at most) count, those of handshakes too, with 60 for each message, for TCP, IP, TLS and
//! WebSocket. Thinning by what the day has used:
//!
//! | of the budget | carried by this way |
//! |---|---|
//! | below 70 % | everything |
//! | 70 to 90 % | no records, no charts; the latest of each kind once a second |
//! | 90 to 100 % | position, alarms, states and answers to commands, every 5 s |
//! | beyond | the same once a minute; commands and their acknowledgements always |
//!
//! While another way is open that is not thinned, that is used. Records wait aboard. Heartbeats of a metered way come every
//! 5 s while it carries little or nothing, and it is given up after 15 s of silence: idle it takes 7 MB a day.

pub(crate) mod choice;
pub(crate) mod meter;
pub(crate) mod quality;

pub use meter::{Thinning, Used};

use crate::DEAD_AFTER;
use std::time::Duration;

/// Most ways of one vessel.
pub const MOST_WAYS: usize = 8;
/// Most bytes of a way's name.
pub const MOST_WAY_NAME_BYTES: usize = 32;
/// Beats of a metered way that carries nothing, or is thinned.
pub(crate) const SLOW_HEARTBEAT: Duration = Duration::from_secs(5);
const METERED_DEAD_AFTER: Duration = Duration::from_secs(15);
/// A connection that is silent for longer is given up.
pub(crate) const LONGEST_SILENCE: Duration = METERED_DEAD_AFTER;

/// How long a way that both ends know of may be silent.
pub(crate) fn dead_after(metered: bool) -> Duration {
    if metered { METERED_DEAD_AFTER } else { DEAD_AFTER }
}

/// One way to the shore, as configured.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct WaySettings {
    /// For people and figures.
    pub name: String,
    /// Its bytes cost.
    pub metered: bool,
    /// Bytes that it may carry in a day; `None` for no bound.
    pub daily_bytes: Option<u64>,
    /// The bytes it has carried, as known at the last end of the program.
    pub used: Used,
}

/// A way as the vessel greets on it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WayHello {
    /// Its place in the vessel's configuration.
    pub index: u8,
    /// Its bytes cost.
    pub metered: bool,
    /// Its name.
    pub name: String,
}

/// Why a lane is on its way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Why {
    /// It is on none.
    #[default]
    None,
    /// No other was open.
    Only,
    /// It answers faster.
    Better,
    /// It costs less.
    Cheaper,
    /// The previous way did not answer.
    Failover,
    /// The previous way has used its budget.
    Budget,
}

impl Why {
    const ALL: [Self; 6] =
        [Self::None, Self::Only, Self::Better, Self::Cheaper, Self::Failover, Self::Budget];

    pub(crate) fn code(self) -> u8 {
        self as u8
    }

    pub(crate) fn from_code(code: u8) -> Self {
        Self::ALL.get(usize::from(code)).copied().unwrap_or_default()
    }

    /// A stable word.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Only => "only",
            Self::Better => "better",
            Self::Cheaper => "cheaper",
            Self::Failover => "failover",
            Self::Budget => "budget",
        }
    }
}

/// How a way is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum WayState {
    /// No connection is open.
    #[default]
    Down,
    /// It is open, and does not answer in time.
    Suspect,
    /// It is open.
    Up,
}

impl WayState {
    pub(crate) fn from_code(code: u8) -> Self {
        match code {
            2 => Self::Up,
            1 => Self::Suspect,
            _ => Self::Down,
        }
    }

    /// A stable word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Down => "down",
            Self::Suspect => "suspect",
            Self::Up => "up",
        }
    }
}

/// The vessel's report of one way.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct WayReport {
    /// Its name.
    pub name: String,
    /// Its bytes cost.
    pub metered: bool,
    /// How it is.
    pub state: WayState,
    /// From sending a message to knowing that it arrived, as usual lately (µs); 0 while unknown.
    pub round_trip_us: u32,
    /// Of the last messages so many in a thousand took longer than a packet that is lost and sent again takes.
    pub late_per_mille: u16,
    /// The fastest that it lately carried, B/s; 0 while unknown.
    pub rate_bytes_per_s: u32,
    /// Bytes of today, both directions.
    pub today_bytes: u64,
    /// Bytes that it may carry in a day; 0 for no bound.
    pub daily_bytes: u64,
    /// What it leaves out to save data.
    pub thinning: Thinning,
    /// How often it broke or stopped answering, since the start of the vessel's program.
    pub failures: u32,
}

/// The vessel's report of its ways.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct WaysReport {
    /// Rises with every change of the way for live values; commands come by the way of the highest.
    pub choice: u64,
    /// Place of the way that carries live values.
    pub live: Option<u8>,
    /// Why live values take that way.
    pub live_why: Why,
    /// Place of the way that carries records.
    pub records: Option<u8>,
    /// Why records take that way.
    pub records_why: Why,
    /// All ways, in their order.
    pub ways: Vec<WayReport>,
}
