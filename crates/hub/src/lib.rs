//! Who hears whom, and what the fleet looks like now.
//!
//! [`Hub`] is one state machine without sockets, clock or threads. Peers join at a transport, packets come in as the
//! bytes they were sent as, and what must go out is drained as batches: packets for each peer, records for the
//! archive. Routing reads headers only; a value is decoded when somebody looks at it. It knows IMC and nothing of
//! people: who may order what, and what becomes of orders, is the crate `operations`, which the one downlink asks through
//! [`OrderLog`].
//!
//! - [`Hub`] routes, refuses and records.
//! - [`Fleet`] holds the last packet of every series with its age and period, the names of entities and the
//!   latest events.
//! - [`PeerQueue`] is what stands between the hub and a socket: bounded, so that a peer that does not read costs
//!   nobody else anything.

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
