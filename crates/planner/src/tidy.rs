//! From the shortest line to legs that a vessel can sail.
//!
//! Around a headland the shortest line has a corner every few metres. Where legs are shorter than asked, two corners that
//! bend the same way become one where the legs before and after them meet: outside both, so farther from what lies
//! inside, and kept only if the new legs keep clear of everything else.

use crate::plane::Point;
use crate::turns::tangent_m;

/// What a bend of less than this (m) off the straight way adds is not worth a corner.
const STRAIGHT_M: f64 = 0.01;
/// No corner may bend by more than this because of tidying (rad).
const SHARPEST_RAD: f64 = 1.75;

/// Leaves out corners that do not bend, then joins corners until legs are `least_leg_m` long and hold the turns of this
/// radius at both their ends, as far as `is_clear` allows the new legs.
pub(crate) fn tidy(
    way: &[Point],
    least_leg_m: f64,
    turn_radius_m: f64,
    is_clear: impl Fn(Point, Point) -> bool,
) -> Vec<Point> {
    let needed_m = |way: &[Point], at: usize| {
        let turn_m = |at: usize| tangent_m(way[at - 1], way[at], way[at + 1], turn_radius_m);
        if turn_radius_m > 0.0 { least_leg_m.max(turn_m(at) + turn_m(at + 1)) } else { least_leg_m }
    };
    let mut way = straighten(way);
    let mut refused: Vec<(Point, Point)> = Vec::new();
    loop {
        let short = (1..way.len().saturating_sub(2))
            .map(|at| (way[at].distance_m(way[at + 1]), at))
            .filter(|(length_m, at)| {
                *length_m < needed_m(&way, *at) && !refused.contains(&(way[*at], way[at + 1]))
            })
            .min_by(|one, other| one.0.total_cmp(&other.0));
        let Some((_, at)) = short else { return way };
        let (a, b, c, d) = (way[at - 1], way[at], way[at + 1], way[at + 2]);
        match joined(a, b, c, d).filter(|corner| is_clear(a, *corner) && is_clear(*corner, d)) {
            Some(corner) => {
                way.splice(at..=at + 1, [corner]);
            }
            None => refused.push((b, c)),
        }
    }
}

fn straighten(way: &[Point]) -> Vec<Point> {
    let mut kept: Vec<Point> = Vec::with_capacity(way.len());
    for (at, point) in way.iter().enumerate() {
        if let (Some(before), Some(after)) = (kept.last(), way.get(at + 1)) {
            let on = point.nearest_on(*before, *after);
            if point.distance_m(on) < STRAIGHT_M {
                continue;
            }
        }
        kept.push(*point);
    }
    kept
}

/// Where the ways from `a` to `b` and from `d` to `c`, made longer, meet.
fn joined(a: Point, b: Point, c: Point, d: Point) -> Option<Point> {
    let (first, second) = (a.cross(b, c), b.cross(c, d));
    if first * second <= 0.0 || bend_rad(a, b, c) + bend_rad(b, c, d) > SHARPEST_RAD {
        return None;
    }
    let (of_b, of_c) = (d.cross(c, b), a.cross(b, c));
    // a + t (b - a) on the line c-d.
    let of_a = d.cross(c, a);
    let t = of_a / (of_a - of_b);
    let corner = a.towards(b, t);
    (t.is_finite() && t >= 1.0 && of_c != 0.0).then_some(corner)
}

/// By how much the way bends at the second of three points (rad).
fn bend_rad(a: Point, b: Point, c: Point) -> f64 {
    let along = (b.x - a.x) * (c.x - b.x) + (b.y - a.y) * (c.y - b.y);
    b.cross(Point { x: 2.0 * b.x - a.x, y: 2.0 * b.y - a.y }, c).atan2(along).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arc_becomes_few_corners_outside_it() {
        let corner = |deg: f64| {
            let (sin, cos) = deg.to_radians().sin_cos();
            Point { x: 25.0 * sin, y: 25.0 * cos }
        };
        let mut way = vec![Point { x: -500.0, y: 25.0 }];
        way.extend((0..=6).map(|n| corner(15.0 * f64::from(n))));
        way.push(Point { x: 25.0, y: -500.0 });
        let tidied = tidy(&way, 15.0, 0.0, |_, _| true);
        assert!(tidied.len() <= 5, "{tidied:?}");
        for leg in tidied.windows(2) {
            assert!(Point::default().distance_m(Point::default().nearest_on(leg[0], leg[1])) > 24.7);
            assert!(leg[0].distance_m(leg[1]) > 15.0, "{tidied:?}");
        }
        assert_eq!(
            tidy(&way, 15.0, 0.0, |_, _| false).len(),
            way.len(),
            "nothing is joined that is not clear"
        );
    }

    #[test]
    fn straight_ways_have_no_corners() {
        let way: Vec<Point> = (0..50).map(|n| Point { x: f64::from(n), y: 2.0 * f64::from(n) }).collect();
        assert_eq!(tidy(&way, 10.0, 0.0, |_, _| true), [way[0], way[49]]);
    }
}
