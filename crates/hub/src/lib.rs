//! Routing of IMC packets between peers, and the live state of the fleet.
//!
//! [`Hub`] is one state machine without sockets, clock or threads. Peers join at a transport, packets come in as the
//! bytes that were sent, and the output is drained as batches: packets for each peer, records for the archive. Routing
//! reads headers only; a value is decoded when it is read. The hub knows IMC and nothing of people: who may give which
//! order, and what becomes of orders, belongs to the crate `operations`, which the downlink asks through [`OrderLog`].
//!
//! - [`Hub`] routes, refuses and records.
//! - [`Fleet`] holds the last packet of every series with its age and period, the names of entities and the
//!   latest events.
//! - [`PeerQueue`] is the send queue between the hub and a socket: bounded, so that a peer that does not read does
//!   not slow the others.

mod delivery;
mod downlink;
mod duplicates;
mod exchange;
mod fleet;
mod hub;
mod linked;
mod node;
mod peer;
mod queue;
mod route;
mod slot;

pub use delivery::{CommandId, Delivery, Tag, Urgency};
pub use downlink::{CALLED_OFF, Dispatched, OrderLog, STOP_LIFE, TIME_TO_LIVE, Telecommand};
pub use fleet::{Changes, Event, Fleet, Liveness, Series, SeriesKey, System, is_event};
pub use hub::{Counters, Hub, Incoming, Lane, Record};
pub use link::{LinkSeq, Transport};
pub use linked::Contradiction;
pub use node::Settings;
pub use peer::{Peer, PeerId, PeerState, Role, Sources};
pub use queue::{PeerQueue, Pushed, is_stop};
