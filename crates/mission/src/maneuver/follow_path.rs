//! Follow path: one path per point, chained. Its machine is [`waypoints`](super::waypoints).

use crate::checks::Checks;
use crate::place::{Offset, RawPlace};
use units::LatLon;
use units::Speed;

/// Go along points; done at once without any.
#[derive(Debug, Clone, PartialEq)]
pub struct FollowPath<P = LatLon> {
    /// The origin of the points' offsets.
    pub origin: P,
    /// The points.
    pub points: Vec<Offset>,
    /// How fast.
    pub speed: Speed,
}

impl FollowPath<RawPlace> {
    pub(crate) fn check(&self, checks: &mut Checks<'_>) -> Option<FollowPath> {
        checks.speed(self.speed);
        checks.points(self.points.len());
        self.points.iter().for_each(|point| checks.offset(*point));
        let origin = checks.place(self.origin)?;
        Some(FollowPath { origin, points: self.points.clone(), speed: self.speed })
    }
}
