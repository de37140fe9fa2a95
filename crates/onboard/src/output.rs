//! The outputs of the brain.

use crate::peer::Peer;
use crate::routing::RouteRequest;
use control::MotorPair;
use mission::Effect;
use units::UtcTime;

/// Something to do, in the order in which it comes out.
#[derive(Debug, Clone, PartialEq)]
pub enum Output {
    /// Thrust for both motors. It holds until the next; when none comes for a second, the motors must stop.
    Motors(MotorPair),
    /// A packet to write to the log and to send.
    Packet {
        /// The packet, whole.
        bytes: Vec<u8>,
        /// The receivers; may be empty.
        to: Vec<Peer>,
    },
    /// An announcement, to the discovery ports.
    Announce(Vec<u8>),
    /// Close the log and open another with this label.
    OpenLog {
        /// The label; empty for none.
        label: String,
        /// The time it begins.
        utc: UtcTime,
    },
    /// Close the log: nothing follows.
    CloseLog,
    /// Something to keep on disk.
    Keep(Keep),
    /// A power channel is to be switched.
    Power {
        /// Its name in the configuration.
        channel: String,
        /// On or off.
        on: bool,
    },
    /// A route to look for by [`Brain::chart`](crate::Brain::chart), in place of the one before; nothing if none is wanted any
    /// more. The result comes back by [`Input::Route`](crate::Input::Route).
    Route(Option<Box<RouteRequest>>),
    /// A line for the console and the log's text.
    Console(Level, String),
}

/// Something to keep on disk.
#[derive(Debug, Clone, PartialEq)]
pub enum Keep {
    /// A change of the plans; the outcome comes back by [`Input::Stored`](crate::Input::Stored).
    Plans(Effect),
    /// Values of parameters of an entity: its label, then names and values.
    Parameters(String, Vec<(String, String)>),
    /// What is under way, as a packet; nothing at rest. The next start finds it in [`mission::Kept`].
    UnderWay(Option<Vec<u8>>),
}

/// How much a line matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// For the curious.
    Debug,
    /// A change of state.
    Info,
    /// Something to look at.
    Warning,
    /// Something is broken or lost.
    Error,
}
