//! How deep is it: exact answers from chart polygons, lines and points.
//!
//! Every safety question about depth has its one implementation here. An index is built
//! from cells ([`IndexBuilder`], or [`assemble`] chart by chart), kept as bytes ([`DepthIndex::to_bytes`]) and asked:
//! [`DepthIndex::depth_at`], [`DepthIndex::shallowest_within`], [`DepthIndex::shallowest_along`],
//! [`DepthIndex::first_danger_along`], [`DepthIndex::distance_to_shallower`],
//! [`DepthIndex::points_of_interest`]. Route planners take [`DepthIndex::barriers`], the lines that corridors are
//! checked against.
//!
//! An index is a directory of charts and one piece for each (`piece`), with its seams to the charts that it meets
//! (`seams`). Pieces are in memory ([`DepthIndex::from_bytes`]) or read when a question touches their box
//! ([`DepthIndex::open`], `piece_cache`); the answers are the same.
//!
//! # Rules
//! - Where cells overlap, the finest band, then the largest scale, then the newest issue answers, exactly up to
//!   its border of coverage: coarser objects are cut off there when the index is built.
//! - What no cell covers, or a cell covers without a depth area, is [`Water::NoData`] and never navigable.
//! - A corridor touches an area if its start lies within it or its border comes within the half width. No
//!   samples are taken, so nothing fits between them.
//! - A leg is the geodesic between its ends. It is checked in pieces of at most 2 km, straight in a local
//!   frame; every width grows by the bound of what that neglects (some centimetres). So a corridor may be
//!   called dangerous for something just outside, never safe for something inside.
//! - A line of the chart is straight in longitude and latitude between its vertices, as all S-57 readers draw
//!   it.
//! - Areas whose entry is prohibited or restricted say nothing about the depth: an answer names them beside the water
//!   ([`Restricted`]), and the demand says whether a vessel may enter.
//! - A piece that cannot be read counts as a danger of unknown depth over all of its box.
//! - Depths are kept in millimetres, rounded to the shallower side; positions in 1e-7 degrees.

mod along;
mod assembly;
mod barriers;
mod build;
mod codec;
mod coords;
mod demand;
mod index;
mod meaning;
mod nearest;
mod object;
mod packed;
mod piece;
mod piece_cache;
mod places;
mod plane;
mod profile;
mod restricted;
mod ring;
mod rows;
mod sealed;
mod seams;
mod sound;
mod tree;

pub use along::{DepthAnswer, Leg};
pub use assembly::{ChartToIndex, assemble, assemble_after};
pub use barriers::{Barriers, Closes, ClosingLine, GeoBox};
pub use build::{BuildError, IndexBuilder};
pub use codec::IndexError;
pub use demand::{ChartTrust, Demand, ZoneError};
pub use index::DepthIndex;
pub use meaning::{clearance_m, is_in_the_way, is_obstacle, is_structure, unsafe_to_use};
pub use nearest::Nearby;
pub use object::{ChartObject, Water};
pub use packed::PackedIndex;
pub use piece_cache::IndexBytes;
pub use restricted::{EntryRule, EntryRules, Restricted, Restriction};
pub use sealed::SealedIndex;
