//! Where ships sail in order: lanes and zones of traffic separation schemes, and deep-water routes.
//!
//! A small vessel may cross them and is to keep out of them otherwise (COLREG rule 10), so a metre in them counts as several, and
//! with twice that surcharge straight against the direction of a lane: a way goes round where that is not far, and else leads across on the
//! shortest way.

use crate::plane::{Plane, Point};
use crate::zones::Zone;
use charts::depth_index::Leg;
use units::{LocalFrame, LocalPoint, wrap_pi};

/// A leg within so much of the direction opposite to that of a lane is said to go against it (rad).
const ALONG_RAD: f64 = std::f64::consts::FRAC_PI_3;
/// How many times the surcharge of a metre with a lane one straight against it has.
const AGAINST: f64 = 2.0;

/// What an area is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TrafficKind {
    /// A lane of a traffic separation scheme.
    Lane,
    /// The zone between lanes.
    SeparationZone,
    /// Where lanes cross, or meet in a roundabout.
    Junction,
    /// A deep-water route.
    DeepWater,
}

impl TrafficKind {
    /// In words, such as `a traffic lane`.
    pub fn words(self) -> &'static str {
        match self {
            Self::Lane => "a traffic lane",
            Self::SeparationZone => "a traffic separation zone",
            Self::Junction => "a junction of traffic lanes",
            Self::DeepWater => "a deep-water route",
        }
    }
}

/// An area of ordered traffic.
#[derive(Debug, Clone, PartialEq)]
pub struct TrafficArea {
    /// Where.
    pub zone: Zone,
    /// What it is.
    pub kind: TrafficKind,
    /// Where ships sail to in it (rad, clockwise from true north); `None` where that is not known or not one direction.
    pub towards_rad: Option<f64>,
}

/// What ordered traffic a leg meets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct InTraffic {
    /// What it enters or touches.
    pub kind: TrafficKind,
    /// It leads against the direction of the lane.
    pub against: bool,
}

impl TrafficArea {
    /// What a leg meets of it.
    pub(crate) fn on(&self, leg: Leg) -> Option<InTraffic> {
        if !self.zone.meets(leg) {
            return None;
        }
        let course_rad = LocalPoint::default().bearing_rad(LocalFrame::new(leg.from).to_local(leg.to));
        let against = self.towards_rad.is_some_and(|towards_rad| {
            wrap_pi(course_rad - towards_rad).abs() >= std::f64::consts::PI - ALONG_RAD
        });
        Some(InTraffic { kind: self.kind, against })
    }

    /// The direction of its ships in a plane, of length 1.
    pub(crate) fn ahead(&self, plane: &Plane) -> Option<Point> {
        let first = *self.zone.corners().first()?;
        let north = plane.north(plane.point(first));
        let (sin, cos) = self.towards_rad?.sin_cos();
        let east = Point { x: north.y, y: -north.x };
        Some(Point { x: cos * north.x + sin * east.x, y: cos * north.y + sin * east.y })
    }
}

/// How many times as much a metre from one point to another counts, in traffic that goes ahead: the surcharge grows to twice as
/// much where it leads straight against it. It grows with how far the way leads against the traffic in all, so that tacking saves
/// nothing.
pub(crate) fn factor(factor: f64, ahead: Option<Point>, (from, to): (Point, Point)) -> f64 {
    let length_m = from.distance_m(to).max(f64::MIN_POSITIVE);
    let against = |ahead: Point| -((to.x - from.x) * ahead.x + (to.y - from.y) * ahead.y) / length_m;
    1.0 + (factor - 1.0) * (1.0 + (AGAINST - 1.0) * ahead.map_or(0.0, against).clamp(0.0, 1.0))
}
