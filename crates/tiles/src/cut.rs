//! Cuts the coverage of better charts out of others.

use crate::shape::{Polygon, Shape, contains, edges};
use crate::world::{Bounds, Point, point};
use charts::coverage;
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay::Overlay;
use i_overlay::core::overlay_rule::OverlayRule;

/// The coverage of the charts so far.
#[derive(Debug, Clone, Default)]
pub(crate) struct Cover {
    areas: Vec<(Bounds, Polygon)>,
}

impl Cover {
    /// Adds what a chart covers.
    pub(crate) fn add(&mut self, areas: &[coverage::Polygon]) {
        let ring = |ring: &Vec<coverage::Vertex>| -> Vec<Point> {
            let open =
                ring.split_last().filter(|(last, rest)| rest.first() == Some(last)).map(|(_, rest)| rest);
            open.unwrap_or(ring).iter().map(|at| point(coverage::degrees(*at))).collect()
        };
        for area in areas {
            let area: Polygon = area.iter().map(ring).collect();
            self.areas.push((Bounds::of(area.iter().flatten()), area));
        }
    }

    /// Adds what others cover.
    pub(crate) fn join(&mut self, others: &Self) {
        self.areas.extend_from_slice(&others.areas);
    }

    /// Adds a whole box.
    pub(crate) fn add_box(&mut self, bounds: Bounds) {
        let Bounds { min, max } = bounds;
        if min.x <= max.x {
            let corners = vec![min, Point::new(max.x, min.y), max, Point::new(min.x, max.y)];
            self.areas.push((bounds, vec![corners]));
        }
    }

    /// How large it is.
    pub(crate) fn vertices(&self) -> usize {
        self.areas.iter().flat_map(|(_, area)| area).map(Vec::len).sum()
    }

    /// The rest of a shape; `None` where nothing is left.
    pub(crate) fn cut(&self, shape: Shape) -> Option<Shape> {
        let bounds = shape.bounds();
        let met: Vec<&Polygon> =
            self.areas.iter().filter(|(one, _)| one.meets(&bounds)).map(|(_, area)| area).collect();
        if met.is_empty() {
            return Some(shape);
        }
        match shape {
            Shape::Point(at) | Shape::Sounding(at, _) => {
                let hidden = met.iter().any(|area| contains(area, at));
                (!hidden).then_some(shape)
            }
            Shape::Lines(lines) => {
                let left: Vec<_> = lines.iter().flat_map(|line| outside(line, &met)).collect();
                (!left.is_empty()).then_some(Shape::Lines(left))
            }
            Shape::Areas(areas) => {
                let left: Vec<Polygon> = met.iter().fold(areas, |left, cover| {
                    let mut overlay = Overlay::from_subj_and_clip(&left, *cover);
                    overlay.overlay(OverlayRule::Difference, FillRule::EvenOdd)
                });
                (!left.is_empty()).then_some(Shape::Areas(left))
            }
        }
    }
}

/// The parts of a line that no cover holds.
fn outside(line: &[Point], covers: &[&Polygon]) -> Vec<Vec<Point>> {
    let hidden = |x: f64, y: f64| {
        let at = Point::new(x.round() as i32, y.round() as i32);
        covers.iter().any(|cover| contains(cover, at))
    };
    let mut parts: Vec<Vec<Point>> = Vec::new();
    let mut open = false;
    for pair in line.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let (ax, ay) = (f64::from(a.x), f64::from(a.y));
        let (dx, dy) = (f64::from(b.x) - ax, f64::from(b.y) - ay);
        let mut shares: Vec<f64> = vec![0.0, 1.0];
        let bounds = Bounds::of([&a, &b]);
        for (c, d) in covers.iter().flat_map(|cover| cover.iter()).flat_map(|ring| edges(ring)) {
            if bounds.meets(&Bounds::of([&c, &d])) {
                let (ex, ey) = (f64::from(d.x) - f64::from(c.x), f64::from(d.y) - f64::from(c.y));
                let (fx, fy) = (f64::from(c.x) - ax, f64::from(c.y) - ay);
                let cross = dx * ey - dy * ex;
                let (along, across) = ((fx * ey - fy * ex) / cross, (fx * dy - fy * dx) / cross);
                // Parallel edges give no number and cut nothing.
                if (0.0..=1.0).contains(&along) && (0.0..=1.0).contains(&across) {
                    shares.push(along);
                }
            }
        }
        shares.sort_by(f64::total_cmp);
        let at = |share: f64| Point::new((ax + share * dx).round() as i32, (ay + share * dy).round() as i32);
        for piece in shares.windows(2).filter(|piece| piece[1] > piece[0]) {
            let middle = f64::midpoint(piece[0], piece[1]);
            if hidden(ax + middle * dx, ay + middle * dy) {
                open = false;
                continue;
            }
            match parts.last_mut().filter(|_| open) {
                Some(part) => part.push(at(piece[1])),
                None => parts.push(vec![at(piece[0]), at(piece[1])]),
            }
            open = true;
        }
    }
    parts
}
