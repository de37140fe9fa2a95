//! The outputs of the brain.

use crate::peer::Peer;
use crate::routing::RouteRequest;
use control::MotorPair;
use mission::Effect;
use units::UtcTime;

/// An output of the brain, to be carried out in order.
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
    /// Data to store on disk.
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

/// Data to store on disk.
#[derive(Debug, Clone, PartialEq)]
pub enum Keep {
    /// A change of the plans; the outcome comes back by [`Input::Stored`](crate::Input::Stored).
    Plans(Effect),
    /// Values of parameters of an entity: its label, then names and values.
    Parameters(String, Vec<(String, String)>),
    /// The present activity, as a packet; empty at rest. The next start finds it in [`mission::Kept`].
    UnderWay(Option<Vec<u8>>),
}

/// How much a line matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// For the curious.
    Debug,
    /// A change of state.
    Info,
    /// To be looked at.
    Warning,
    /// A part is broken or lost.
    Error,
}
