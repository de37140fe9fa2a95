//! Corners that a vessel can sail.
//!
//! A vessel does not turn on the spot: it leaves one leg before the corner and joins the next one after it, on an arc
//! of its turning radius R that touches both. For a change of course a the arc begins R tan(a/2) before the corner and
//! passes it on the inner side at R (1 / cos(a/2) - 1), where the shortest way has what it keeps clear of. So a corner
//! is moved outwards until its arc keeps clear too. What cannot be moved is said at the corner. Arcs are held against
//! the chart by their chords, which lie farther in than they do.

use crate::needs::Needs;
use crate::plane::{Plane, Point};
use crate::zones::Zones;
use charts::depth_index::{DepthIndex, Leg};

/// Changes of course below this need no turn (rad).
const STRAIGHT_RAD: f64 = 0.01;
/// A chord is of at most so much of an arc (rad): its middle lies 0.1 % of the radius inside.
const CHORD_RAD: f64 = 0.1;
/// How far out a corner is moved, in turn, as a share of how far its arc passes inside it.
const OUTWARDS: [f64; 4] = [1.02, 1.2, 1.6, 2.5];
/// Times that all corners are looked at: moving one changes the turns of its neighbours.
const ROUNDS: usize = 3;
/// Turns may overlap by so much (m).
const SAME_M: f64 = 0.01;

/// The change of course at the end of a leg.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn {
    /// By how much the course changes (rad), 0 to π; the same to both hands.
    pub change_rad: f64,
    /// Why a vessel of the turning radius that was asked for leaves the way here; `None` if its arc keeps clear.
    pub trouble: Option<TurnTrouble>,
}

/// Why a turn cannot be sailed as asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum TurnTrouble {
    /// The arc needs more of a leg than there is.
    #[error(
        "the legs are too short for a turn of this radius: turn slower here, or plan with a smaller radius"
    )]
    ShortLegs,
    /// The arc comes nearer to land, shallow water or a danger than asked, or into an area to avoid.
    #[error(
        "a turn of this radius leaves the water that was asked for: turn slower here, or plan with a smaller radius or \
         clearance"
    )]
    NoRoom,
}

/// The change of course at the second of three points (rad).
fn change_rad(a: Point, b: Point, c: Point) -> f64 {
    let along = (b.x - a.x) * (c.x - b.x) + (b.y - a.y) * (c.y - b.y);
    a.cross(b, c).atan2(along).abs()
}

/// How long before the corner, and after it, the vessel is off the legs (m); infinite where it goes back.
pub(crate) fn tangent_m(a: Point, b: Point, c: Point, radius_m: f64) -> f64 {
    let half_rad = change_rad(a, b, c) / 2.0;
    if half_rad > 1.57 { f64::INFINITY } else { radius_m * half_rad.tan() }
}

/// The ends of the chords of a turn, none where the way is straight.
fn arc(a: Point, b: Point, c: Point, radius_m: f64) -> Vec<Point> {
    let (change_rad, tangent_m) = (change_rad(a, b, c), tangent_m(a, b, c, radius_m));
    if change_rad < STRAIGHT_RAD || tangent_m.is_infinite() {
        return Vec::new();
    }
    let begin = b.towards(a, tangent_m / b.distance_m(a));
    let left = a.cross(b, c) > 0.0;
    let ahead_rad = (b.y - a.y).atan2(b.x - a.x);
    let to_centre_rad = ahead_rad + if left { 1.0 } else { -1.0 } * std::f64::consts::FRAC_PI_2;
    let centre = ahead(begin, to_centre_rad, radius_m);
    // Within 1 to 32.
    let chords = (change_rad / CHORD_RAD).ceil() as u32;
    let at = |chord: u32| {
        let turned_rad = change_rad * f64::from(chord) / f64::from(chords);
        let from_centre_rad = to_centre_rad + std::f64::consts::PI;
        ahead(centre, from_centre_rad + if left { turned_rad } else { -turned_rad }, radius_m)
    };
    (0..=chords).map(at).collect()
}

fn ahead(from: Point, direction_rad: f64, distance_m: f64) -> Point {
    let (sin, cos) = direction_rad.sin_cos();
    Point { x: from.x + distance_m * cos, y: from.y + distance_m * sin }
}

/// Moves corners outwards until the arcs of their turns are clear, as far as the legs to them are.
pub(crate) fn move_out(way: &mut [Point], radius_m: f64, is_clear: impl Fn(Point, Point) -> bool) {
    let turns_clear = |a: Point, b: Point, c: Point| {
        arc(a, b, c, radius_m).windows(2).all(|chord| is_clear(chord[0], chord[1]))
    };
    for _ in 0..ROUNDS {
        let mut moved = false;
        for at in 1..way.len().saturating_sub(1) {
            let (a, b, c) = (way[at - 1], way[at], way[at + 1]);
            if tangent_m(a, b, c, radius_m) > b.distance_m(a).min(b.distance_m(c)) || turns_clear(a, b, c) {
                continue;
            }
            let farther = OUTWARDS.iter().map(|share| outside(a, b, c, share * radius_m));
            let mut good =
                farther.filter(|out| is_clear(a, *out) && is_clear(*out, c) && turns_clear(a, *out, c));
            if let Some(out) = good.next() {
                way[at] = out;
                moved = true;
            }
        }
        if !moved {
            return;
        }
    }
}

/// A corner moved outwards by as much as the arc of this radius passes inside it.
fn outside(a: Point, b: Point, c: Point, radius_m: f64) -> Point {
    let half_rad = change_rad(a, b, c) / 2.0;
    let before = b.towards(a, 1.0 / b.distance_m(a));
    let after = b.towards(c, 1.0 / b.distance_m(c));
    let inner = before.towards(after, 0.5);
    let off_m = radius_m * (1.0 / half_rad.cos() - 1.0);
    b.towards(inner, -off_m / b.distance_m(inner).max(1e-9))
}

/// What turn follows each leg but the last, by the chart itself: of legs in order, each with its length (m).
pub(crate) fn judge(
    legs: &[(Leg, f64)],
    radius_m: f64,
    index: &DepthIndex,
    needs: &Needs,
    zones: &Zones,
) -> Vec<Option<Turn>> {
    let mut before_m = 0.0;
    let turn_between = |pair: &[(Leg, f64)]| {
        let [(leg, length_m), (next, next_m)] = [pair[0], pair[1]];
        let plane = Plane::new(leg.to);
        let [a, b, c] = [leg.from, leg.to, next.to].map(|place| plane.point(place));
        let change_rad = change_rad(a, b, c);
        if change_rad < STRAIGHT_RAD {
            before_m = 0.0;
            return None;
        }
        let tangent_m = tangent_m(a, b, c, radius_m);
        let short = before_m + tangent_m > length_m + SAME_M || tangent_m > next_m + SAME_M;
        let confirmed = |chord: &[Point]| {
            let leg = Leg { from: plane.place(chord[0]), to: plane.place(chord[1]) };
            let deep = index.shallowest_along(leg, needs.clearance_m, &needs.demand).navigable;
            // A chord is some metres long.
            deep && zones.allow(leg.from) && zones.allow(leg.to)
        };
        let trouble = if short {
            Some(TurnTrouble::ShortLegs)
        } else if arc(a, b, c, radius_m).windows(2).all(confirmed) {
            None
        } else {
            Some(TurnTrouble::NoRoom)
        };
        // One that cannot be sailed is said once.
        before_m = if short { 0.0 } else { tangent_m };
        Some(Turn { change_rad, trouble })
    };
    legs.windows(2).map(turn_between).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arc_touches_both_legs_and_passes_inside_the_corner() {
        let (a, b) = (Point { x: -500.0, y: 0.0 }, Point::default());
        for c in [Point { x: 0.0, y: 500.0 }, Point { x: 0.0, y: -500.0 }] {
            let arc = arc(a, b, c, 100.0);
            assert!((arc[0].distance_m(Point { x: -100.0, y: 0.0 })) < 1e-9, "{arc:?}");
            assert!((arc[arc.len() - 1].distance_m(b.towards(c, 0.2))) < 1e-9, "{arc:?}");
            let nearest_m = arc.windows(2).map(|chord| b.distance_m(b.nearest_on(chord[0], chord[1])));
            let nearest_m = nearest_m.fold(f64::INFINITY, f64::min);
            assert!((41.4..41.7).contains(&nearest_m), "{nearest_m}");
        }
    }

    #[test]
    fn a_corner_moves_out_until_its_arc_keeps_off_what_lies_inside() {
        // What lies within 50 m of the origin is closed; the way is bent there at a right angle.
        let off_m =
            |from: Point, to: Point| Point::default().distance_m(Point::default().nearest_on(from, to));
        let clear = |from: Point, to: Point| off_m(from, to) >= 50.0;
        let corner = Point { x: 51.0, y: 51.0 };
        let way = [Point { x: -900.0, y: 51.0 }, corner, Point { x: 51.0, y: -900.0 }];
        let mut moved = way;
        move_out(&mut moved, 150.0, clear);
        assert_ne!(moved[1], corner);
        assert!(arc(moved[0], moved[1], moved[2], 150.0).windows(2).all(|chord| clear(chord[0], chord[1])));
        let mut shut = way;
        move_out(&mut shut, 150.0, |from, to| clear(from, to) && from.x.max(to.x) < 52.0);
        assert_eq!(shut, way, "what cannot move stays");
    }
}
