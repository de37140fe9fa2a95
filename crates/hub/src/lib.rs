//! The heart of the shore: who hears whom, and what the fleet looks like now.
//!
//! [`Hub`] is one state machine without sockets, clock or threads. Peers join at a door, packets come in as the
//! bytes they were sent as, and what must go out is drained as batches: packets for each peer, records for the
//! archive. Routing reads headers only; a value is decoded when somebody looks at it.
//!
//! - [`Hub`] routes, refuses and records ([`hub`](crate::Hub)).
//! - [`Fleet`] holds the last packet of every series with its age and period, the names of entities and the
//!   latest events.
//! - [`Leases`] says who commands which vessel, [`Commands`] what became of each order.
//! - [`alarm::Alarms`] says what is wrong, and who knows of it.
//! - [`Teleop`] turns stick positions into thrust, and stops the motors when they are no longer fresh.
//! - [`PeerQueue`] is what stands between the hub and a socket: bounded, so that a peer that does not read costs
//!   nobody else anything.

pub mod alarm;
mod command;
mod downlink;
mod duplicates;
mod exchange;
mod fleet;
mod hub;
mod lease;
mod linked;
mod node;
mod peer;
mod queue;
mod route;
mod slot;
mod teleop;

pub use command::{
    Answer, Asked, Command, CommandEvent, CommandId, Commands, EntityTold, GOTO_PLAN, Order, ParameterTold,
    PlanAboard, PlanTold, PlansAboard, Question, Receipt, Stage, Step, TELEOPERATION_PLAN, TIME_TO_LIVE,
    Told, is_same_value,
};
pub use downlink::{Delivery, Dispatched, STOP_LIFE, Tag, Telecommand, Urgency};
pub use fleet::{Changes, Event, Fleet, Liveness, Series, SeriesKey, System, is_event};
pub use hub::{Counters, Hub, Incoming, Lane, LinkSeq, Record, Settings};
pub use lease::{
    ANSWER_WITHIN, Change, Held, Holder, LASTS, Lease, LeaseAsk, LeaseEvent, LeaseRefused, Leases,
    REASON_CHARS, Waiting,
};
pub use peer::{Door, Peer, PeerId, PeerState, Role, Sources};
pub use queue::{PeerQueue, Pushed, is_stop};
pub use teleop::{
    BUDGET, CAP_OVER, CAPPED, LIFE, MOST_AGE, NEUTRAL, REFUSE_OVER, Sample, State as TeleopState, Sticks,
    Teleop, WARN_OVER, Why,
};

use units::{MonoTime, UtcTime};

/// The present by both clocks: deadlines run on the one, records carry the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Now {
    /// The clock that never steps.
    pub mono: MonoTime,
    /// The shore's UTC.
    pub utc: UtcTime,
}
