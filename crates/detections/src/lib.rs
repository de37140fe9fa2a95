//! Detections of tagged fish: what one is, and how IMC carries it.
//!
//! A [`Detection`] is what a receiver heard, by its own clock, with the place of the vessel then and how well it could
//! listen. The vessel makes it; live views, history, API and files ashore get it from here, so that a packet is
//! understood in one place:
//!
//! - [`TBRFishTag`](imc::messages::TBRFishTag) (2007), as every Otter sends it. It carries no clock state, nothing of how
//!   good the place is, no coding without a number, and no raw line.
//! - [`Event`](imc::messages::Event) (660) with the topic [`TOPIC`], which a Lutra vessel sends for each detection: all of
//!   it as a tuple list. See [`Detection::report`] for the names.
//!
//! Both come in packets of one moment and one entity. They are the same detection where [`Detection::is_same`] says so, and
//! [`fused`] makes one of them. What no message carried is absent, and stays absent. A receiver is its serial number and, where a
//! file of another receiver says it, its [`Maker`].
//!
//! [`Listening`] says how a receiver listens, also while it hears nothing: an Event with the topic [`LISTENING_TOPIC`].
//!
//! It knows IMC and units; it has no clock, input or output.

mod area;
mod detection;
mod fish_tag;
mod list;
mod listening;
mod maker;
mod protocol;
mod report;
mod tag;

pub use area::{AREA_CORNERS, Area, NoArea};
pub use detection::{ClockState, Detection, Effort, Noise, Origin, Pose, ReceiverClock, SET_AFTER_S, fused};
pub use listening::{LISTENING_TOPIC, Listening};
pub use maker::Maker;
pub use protocol::Protocol;
pub use report::{TOPIC, is_report};
pub use tag::{NoTag, TagFilter};
