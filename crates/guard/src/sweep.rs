//! All that a plan may sweep, as corridors.
//!
//! Between maneuvers the vessel is somewhere in a disc: at a point after a path, anywhere on its circle after a
//! loiter. The ways from a disc to a place fill the convex hull of both, which is covered by corridors that
//! narrow towards the end.

use super::limits::GuardLimits;
use super::verdict::{Part, Warning};
use crate::command::Turn;
use crate::maneuver::{Loiter, LoiterShape, Maneuver, distance_m};
use crate::plan::{Node, Plan};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use units::{Ecef, Geodetic, LatLon, LocalFrame, LocalPoint};

/// How far an arc may lie outside its chord (m); the corridor is wider by that.
const SAGITTA_M: f64 = 0.25;
/// Most chords of a circle.
const MOST_CHORDS: f64 = 360.0;
/// How much too wide a narrowing corridor may be (m).
const TAPER_M: f64 = 2.0;
/// Most corridors that cover a hull.
const MOST_TAPERS: f64 = 16.0;
/// A circle is approached along the leg to the point abeam of its centre from at least so many radii.
const OUTSIDE: f64 = 1.25;

/// All places within the half width of the way from one place to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Corridor {
    pub(super) from: LatLon,
    pub(super) to: LatLon,
    pub(super) half_width_m: f64,
}

/// A leg with the corridors that cover it.
#[derive(Debug)]
pub(super) struct Stroke<'a> {
    pub(super) maneuver: &'a str,
    pub(super) part: Part,
    pub(super) number: u32,
    pub(super) corridors: &'a [Corridor],
}

/// Where the vessel may be.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Disc {
    centre: LatLon,
    radius_m: f64,
}

/// Lays a plan out.
pub(super) struct Layout<'a> {
    plan: &'a Plan,
    limits: &'a GuardLimits,
    here: Option<Disc>,
    warnings: Vec<Warning>,
    corridors: Vec<Corridor>,
}

impl<'a> Layout<'a> {
    pub(super) fn new(plan: &'a Plan, limits: &'a GuardLimits) -> Self {
        Self { plan, limits, here: None, warnings: Vec::new(), corridors: Vec::new() }
    }

    pub(super) fn into_warnings(self) -> Vec<Warning> {
        self.warnings
    }

    /// Gives every leg, until told to stop.
    pub(super) fn run(&mut self, from: Option<LatLon>, mut give: impl FnMut(&Stroke<'_>) -> bool) {
        self.here = from.map(|centre| Disc { centre, radius_m: 0.0 });
        let plan = self.plan;
        let order = plan.order();
        for index in &order {
            let Some(node) = plan.node(*index) else { continue };
            if !self.node(node, true, &mut give) {
                return;
            }
        }
        // The way back to the beginning of a circle, and on to its first place.
        let mut next = order.last().and_then(|last| plan.node(*last)?.next());
        for _ in &order {
            let Some(node) = next.and_then(|next| plan.node(next)) else { break };
            if !self.node(node, false, &mut give) || !matches!(node.maneuver(), Maneuver::Idle(_)) {
                break;
            }
            next = node.next();
        }
    }

    /// One maneuver; only the way to its first place unless `whole`.
    fn node(&mut self, node: &Node, whole: bool, give: &mut impl FnMut(&Stroke<'_>) -> bool) -> bool {
        let (id, maneuver) = (node.id(), node.maneuver());
        match maneuver {
            Maneuver::Goto(_)
            | Maneuver::Launch(_)
            | Maneuver::FollowPath(_)
            | Maneuver::FollowTrajectory(_)
            | Maneuver::Rows(_) => self.track(id, &maneuver.places(), 0.0, whole, give),
            // Rows move by up to a step when the sensor sees less than its full width.
            Maneuver::RowsCoverage(rows) => {
                self.track(id, &maneuver.places(), rows.swath.width_m(), whole, give)
            }
            Maneuver::ScheduledGoto(_) => {
                if whole {
                    // It does not start before it must.
                    self.warnings.push(Warning::DriftsOn { maneuver: id.to_owned() });
                }
                self.track(id, &maneuver.places(), 0.0, whole, give)
            }
            Maneuver::StationKeeping(station) => {
                let radius_m = station.radius_m.max(self.limits.least_station_m);
                let disc = Disc { centre: station.centre, radius_m };
                self.transit(id, Disc { radius_m: 0.0, ..disc }, give)
                    && (!whole || self.disc(id, Part::Station, disc, give))
            }
            Maneuver::Loiter(loiter) => self.loiter(id, loiter, whole, give),
            Maneuver::Idle(idle) => {
                match (self.here, idle.duration) {
                    (Some(here), Some(duration)) => {
                        let radius_m = here.radius_m + self.limits.drift_mps * duration.as_secs_f64();
                        return self.disc(id, Part::Drift, Disc { radius_m, ..here }, give);
                    }
                    _ if whole => self.warnings.push(Warning::DriftsOn { maneuver: id.to_owned() }),
                    _ => {}
                }
                true
            }
            Maneuver::FollowReference(_) | Maneuver::FollowSystem(_) | Maneuver::Teleoperation(_) => {
                if whole {
                    let kind = maneuver.kind();
                    self.warnings.push(Warning::Unchecked { maneuver: id.to_owned(), kind });
                }
                self.here = None;
                true
            }
        }
    }

    /// To the first place and on along the others.
    fn track(
        &mut self,
        id: &str,
        places: &[LatLon],
        wider_m: f64,
        whole: bool,
        give: &mut impl FnMut(&Stroke<'_>) -> bool,
    ) -> bool {
        let Some(first) = places.first() else { return true };
        if !self.transit(id, Disc { centre: *first, radius_m: 0.0 }, give) {
            return false;
        }
        if !whole {
            return true;
        }
        let half_width_m = self.limits.half_width_m() + wider_m;
        for (number, leg) in (0_u32..).zip(places.windows(2)) {
            let corridor = Corridor { from: leg[0], to: leg[1], half_width_m };
            if !give(&Stroke { maneuver: id, part: Part::Track, number, corridors: &[corridor] }) {
                return false;
            }
        }
        self.here = places.last().map(|centre| Disc { centre: *centre, radius_m: 0.0 });
        true
    }

    /// From where the vessel may be to anywhere in a disc.
    fn transit(&mut self, id: &str, to: Disc, give: &mut impl FnMut(&Stroke<'_>) -> bool) -> bool {
        self.corridors.clear();
        if let Some(here) = self.here {
            self.hull(here, to);
        } else {
            self.warnings.push(Warning::StartUnknown { maneuver: id.to_owned() });
            let half_width_m = self.limits.half_width_m() + to.radius_m;
            self.corridors.push(Corridor { from: to.centre, to: to.centre, half_width_m });
        }
        self.here = Some(to);
        self.give(id, Part::Transit, give)
    }

    fn disc(&mut self, id: &str, part: Part, disc: Disc, give: &mut impl FnMut(&Stroke<'_>) -> bool) -> bool {
        let half_width_m = disc.radius_m + self.limits.hull_m;
        self.corridors.clear();
        self.corridors.push(Corridor { from: disc.centre, to: disc.centre, half_width_m });
        self.here = Some(disc);
        self.give(id, part, give)
    }

    fn give(&mut self, id: &str, part: Part, give: &mut impl FnMut(&Stroke<'_>) -> bool) -> bool {
        give(&Stroke { maneuver: id, part, number: 0, corridors: &self.corridors })
    }

    /// Covers the convex hull of two discs: every way from the one to the other.
    fn hull(&mut self, from: Disc, to: Disc) {
        let half_width_m = self.limits.half_width_m();
        let narrowing_m = (from.radius_m - to.radius_m).abs();
        let count = (narrowing_m / TAPER_M).ceil().clamp(1.0, MOST_TAPERS);
        let at = |t: f64| between(from.centre, to.centre, t);
        let radius_m = |t: f64| from.radius_m + t * (to.radius_m - from.radius_m);
        for n in 0..count as u32 {
            let (t0, t1) = (f64::from(n) / count, f64::from(n + 1) / count);
            let widest_m = radius_m(t0).max(radius_m(t1));
            let half_width_m = half_width_m + widest_m;
            self.corridors.push(Corridor { from: at(t0), to: at(t1), half_width_m });
        }
    }

    fn loiter(
        &mut self,
        id: &str,
        loiter: &Loiter,
        whole: bool,
        give: &mut impl FnMut(&Stroke<'_>) -> bool,
    ) -> bool {
        let radius_m = loiter.radius_m.max(self.limits.least_loiter_m);
        let disc = Disc { centre: loiter.centre, radius_m };
        match loiter.shape {
            LoiterShape::Circle(turn) | LoiterShape::Other(turn) => {
                let to = self.abeam(disc, turn).unwrap_or(disc);
                if self.here.is_none() {
                    // From anywhere; where the circle is met is not known.
                    self.warnings.push(Warning::StartUnknown { maneuver: id.to_owned() });
                } else if !self.transit(id, to, give) {
                    return false;
                }
                self.corridors.clear();
                if whole {
                    self.circle(disc);
                }
            }
            LoiterShape::Eight { length_m, bearing_rad } => {
                let half_m = length_m.max(2.0 * radius_m) / 2.0;
                let ends = [PI, 0.0].map(|turned| displaced(loiter.centre, bearing_rad + turned, half_m));
                let stadium = Disc { centre: loiter.centre, radius_m: half_m + radius_m };
                let first = Disc { centre: ends[0], radius_m };
                if !self.transit(id, first, give) {
                    return false;
                }
                self.here = Some(stadium);
                self.corridors.clear();
                if whole {
                    // The circles and the ways across.
                    let half_width_m = self.limits.half_width_m() + radius_m;
                    self.corridors.push(Corridor { from: ends[0], to: ends[1], half_width_m });
                }
                return !whole || self.give(id, Part::Circle, give);
            }
        }
        self.here = Some(disc);
        !whole || self.give(id, Part::Circle, give)
    }

    /// Where the approach to a circle ends, when the vessel comes from one place well outside: abeam of the
    /// centre, on the side from which the circle is met along its sense.
    fn abeam(&self, disc: Disc, turn: Turn) -> Option<Disc> {
        let here = self.here.filter(|here| here.radius_m <= 0.0)?;
        if distance_m(here.centre, disc.centre) < OUTSIDE * disc.radius_m + self.limits.half_width_m() {
            return None;
        }
        let side = match turn {
            Turn::Clockwise => -FRAC_PI_2,
            Turn::CounterClockwise => FRAC_PI_2,
        };
        let frame = LocalFrame::new(disc.centre);
        let ahead_rad = frame.to_local(here.centre).bearing_rad(LocalPoint::default());
        Some(Disc { centre: displaced(disc.centre, ahead_rad + side, disc.radius_m), radius_m: 0.0 })
    }

    /// Covers the ring that a circle sweeps by its chords.
    fn circle(&mut self, disc: Disc) {
        let share = (1.0 - SAGITTA_M / disc.radius_m).clamp(-1.0, 1.0);
        let count = (PI / share.acos()).ceil().clamp(6.0, MOST_CHORDS);
        let sagitta_m = disc.radius_m * (1.0 - (PI / count).cos());
        let half_width_m = self.limits.half_width_m() + sagitta_m;
        let frame = LocalFrame::new(disc.centre);
        let on = |n: f64| frame.to_place(LocalPoint::default().displaced(TAU * n / count, disc.radius_m));
        for n in 0..count as u32 {
            let (from, to) = (on(f64::from(n)), on(f64::from(n + 1)));
            self.corridors.push(Corridor { from, to, half_width_m });
        }
    }
}

fn displaced(place: LatLon, bearing_rad: f64, distance_m: f64) -> LatLon {
    LocalFrame::new(place).to_place(LocalPoint::default().displaced(bearing_rad, distance_m))
}

/// The place at a share of the geodesic, found on its chord through the Earth as the index does.
fn between(from: LatLon, to: LatLon, t: f64) -> LatLon {
    if t <= 0.0 {
        return from;
    }
    if t >= 1.0 {
        return to;
    }
    let ends = [from, to].map(|place| {
        Geodetic { lat_rad: place.lat_rad(), lon_rad: place.lon_rad(), height_m: 0.0 }.to_ecef()
    });
    let mix = |a: f64, b: f64| a + (b - a) * t;
    let place = Ecef {
        x_m: mix(ends[0].x_m, ends[1].x_m),
        y_m: mix(ends[0].y_m, ends[1].y_m),
        z_m: mix(ends[0].z_m, ends[1].z_m),
    }
    .to_geodetic();
    LatLon::from_rad(place.lat_rad, place.lon_rad).unwrap_or(from)
}
