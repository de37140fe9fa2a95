//! The places that were reported, so that each situation is reported once.
//!
//! A place that is asked for every second, moves a little, or alternates with another is one situation for as long as it
//! is met at least once a minute.

use super::goto::distance_m;
use super::search::SAME_PLACE_M;
use std::time::Duration;
use units::{LatLon, MonoTime};

/// A situation that was not met for so long is a new one.
const FORGOTTEN: Duration = Duration::from_mins(1);
/// Situations kept in mind; of more the one met longest ago is forgotten.
const MOST: usize = 8;

/// Places that were reported, with the time each was met last.
#[derive(Debug, Clone, Default)]
pub(super) struct Reported(Vec<(LatLon, MonoTime)>);

impl Reported {
    /// A place was met; returns whether that is to be reported.
    pub(super) fn is_new(&mut self, place: LatLon, now: MonoTime) -> bool {
        self.0.retain(|(_, met)| now.since(*met) < FORGOTTEN);
        let same = self.0.iter().position(|(reported, _)| distance_m(*reported, place) < SAME_PLACE_M);
        match same {
            // It moves on with the place.
            Some(at) => _ = self.0.remove(at),
            None if self.0.len() >= MOST => _ = self.0.remove(0),
            None => {}
        }
        self.0.push((place, now));
        same.is_none()
    }
}
