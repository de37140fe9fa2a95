//! Objects near a place.

use crate::layer::{Kind, Layer};
use crate::shape::{Shape, contains, edges};
use crate::sheet::{Changed, Sheet};
use crate::world::{Bounds, Point, metres_per_unit, point};
use charts::s57::GeoPoint;
use units::LatLon;

/// An object near a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Near {
    /// The object, for [`Sheet::about`].
    pub object: u32,
    /// How far it is (m), on the projection's sphere: within 0.4 %; 0 within an area.
    pub distance_m: f64,
    /// `point`, `line`, `area` or `sounding`.
    pub geometry: &'static str,
    /// Depth of a sounding (m).
    pub depth_m: Option<f64>,
    /// Longer side of its box (units), to put the larger of two areas last.
    size: i64,
}

impl Sheet {
    /// The nearest objects within a distance (m), at most `count`. Areas that hold the place come after all others,
    /// the smallest first, and are the last to be left out.
    ///
    /// # Errors
    /// When the charts are others by now.
    pub fn near(&self, place: LatLon, within_m: f64, count: usize) -> Result<Vec<Near>, Changed> {
        let at = point(GeoPoint { lon_deg: place.lon_deg(), lat_deg: place.lat_deg() });
        let unit_m = metres_per_unit(place.lat_deg());
        let reach = (within_m.clamp(0.0, 1e5) / unit_m).ceil() as i32 + 1;
        let side = |value: i32, by: i32| value.saturating_add(by);
        let bounds = Bounds {
            min: Point::new(side(at.x, -reach), side(at.y, -reach)),
            max: Point::new(side(at.x, reach), side(at.y, reach)),
        };
        let layers = Layer::ALL.into_iter().filter(|layer| *layer != Layer::Name).map(Some).chain([None]);
        let scene = self.scene(bounds, u8::MAX)?;
        let mut found: Vec<Near> = layers
            .flat_map(|layer| scene.within(layer, bounds))
            .filter_map(|placed| {
                let item = placed.item;
                let distance_m = distance(&item.shape, at) * unit_m;
                let geometry = match (&item.shape, item.shape.kind()) {
                    (Shape::Sounding(..), _) => "sounding",
                    (_, Kind::Point) => "point",
                    (_, Kind::Line) => "line",
                    (_, Kind::Area) => "area",
                };
                let depth_m = if let Shape::Sounding(_, depth_m) = item.shape { Some(depth_m) } else { None };
                let size = item.bounds.size();
                let near = Near { object: placed.object, distance_m, geometry, depth_m, size };
                (distance_m <= within_m).then_some(near)
            })
            .collect();
        found.sort_by(|a, b| {
            let by_distance = a.distance_m.total_cmp(&b.distance_m);
            by_distance.then(a.size.cmp(&b.size)).then(a.object.cmp(&b.object))
        });
        let holds = |one: &Near| one.geometry == "area" && one.distance_m <= 0.0;
        let (areas, mut found): (Vec<Near>, Vec<Near>) = found.into_iter().partition(holds);
        found.truncate(count.saturating_sub(areas.len()));
        found.extend(areas);
        found.truncate(count);
        Ok(found)
    }
}

/// Units from a shape.
fn distance(shape: &Shape, at: Point) -> f64 {
    let to_line = |a: Point, b: Point| {
        let (ax, ay) = (f64::from(a.x) - f64::from(at.x), f64::from(a.y) - f64::from(at.y));
        let (dx, dy) = (f64::from(b.x) - f64::from(a.x), f64::from(b.y) - f64::from(a.y));
        let length = dx * dx + dy * dy;
        let share = if length > 0.0 { (-(ax * dx + ay * dy) / length).clamp(0.0, 1.0) } else { 0.0 };
        (ax + share * dx).hypot(ay + share * dy)
    };
    match shape {
        Shape::Point(one) | Shape::Sounding(one, _) => to_line(*one, *one),
        Shape::Lines(lines) => lines
            .iter()
            .flat_map(|line| line.windows(2))
            .map(|pair| to_line(pair[0], pair[1]))
            .fold(f64::INFINITY, f64::min),
        Shape::Areas(areas) => {
            if areas.iter().filter(|area| contains(area, at)).count() % 2 == 1 {
                return 0.0;
            }
            let rings = areas.iter().flatten();
            rings.flat_map(|ring| edges(ring)).map(|(a, b)| to_line(a, b)).fold(f64::INFINITY, f64::min)
        }
    }
}
