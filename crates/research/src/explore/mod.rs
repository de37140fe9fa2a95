//! Many detections at once: kept small ([`Sightings`]), and counted for plots ([`summary()`]).
//!
//! A million detections take 32 MB and are counted in some tens of milliseconds; their summary is as large as that of a
//! thousand, for its plots have bounds: 100 tags by 600 steps of time, 400 bars, 61 by 61 squares.

mod count;
mod effort;
mod lags;
mod ranks;
mod sighting;
mod squares;
mod summary;

pub use ranks::{Rank, Ranks, ranks};
pub use sighting::{Sightings, SightingsBuilder};
pub use summary::{Question, summary};

#[cfg(test)]
mod tests;
