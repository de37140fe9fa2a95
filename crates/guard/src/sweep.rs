//! Shapes that a vessel sweeps, covered by corridors.
//!
//! Between two parts of its way the vessel is somewhere in a disc: at a point after a track, anywhere on its circle
//! after a loiter. The ways from one disc to another fill the convex hull of both, which is covered by corridors that
//! narrow towards the smaller one.

use std::f64::consts::{PI, TAU};
use units::{Ecef, Geodetic, LatLon, LocalFrame, LocalPoint};

/// How far an arc may lie outside its chord (m); the corridor is wider by that.
const SAGITTA_M: f64 = 0.25;
/// Most chords of a circle.
const MOST_CHORDS: f64 = 360.0;
/// How much too wide a narrowing corridor may be (m).
const TAPER_M: f64 = 2.0;
/// Most corridors that cover a hull.
const MOST_TAPERS: f64 = 16.0;

/// All places within a radius of one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disc {
    /// Its middle.
    pub centre: LatLon,
    /// Its radius (m); 0 for the place itself.
    pub radius_m: f64,
}

impl Disc {
    /// One place.
    pub fn at(centre: LatLon) -> Self {
        Self { centre, radius_m: 0.0 }
    }
}

/// All places within the half width of the way from one place to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Corridor {
    pub(crate) from: LatLon,
    pub(crate) to: LatLon,
    pub(crate) half_width_m: f64,
}

impl Corridor {
    /// The disc of this radius.
    pub(crate) fn around(centre: LatLon, half_width_m: f64) -> Self {
        Self { from: centre, to: centre, half_width_m }
    }
}

/// Covers the convex hull of two discs: every way from the one to the other, with this half width.
pub(crate) fn hull(from: Disc, to: Disc, half_width_m: f64) -> Vec<Corridor> {
    let narrowing_m = (from.radius_m - to.radius_m).abs();
    let count = (narrowing_m / TAPER_M).ceil().clamp(1.0, MOST_TAPERS);
    let at = |t: f64| between(from.centre, to.centre, t);
    let radius_m = |t: f64| from.radius_m + t * (to.radius_m - from.radius_m);
    let corridor = |n: u32| {
        let (t0, t1) = (f64::from(n) / count, f64::from(n + 1) / count);
        let widest_m = radius_m(t0).max(radius_m(t1));
        Corridor { from: at(t0), to: at(t1), half_width_m: half_width_m + widest_m }
    };
    (0..count as u32).map(corridor).collect()
}

/// Covers the ring that a circle sweeps by its chords.
pub(crate) fn circle(disc: Disc, half_width_m: f64) -> Vec<Corridor> {
    let share = (1.0 - SAGITTA_M / disc.radius_m).clamp(-1.0, 1.0);
    let count = (PI / share.acos()).ceil().clamp(6.0, MOST_CHORDS);
    let sagitta_m = disc.radius_m * (1.0 - (PI / count).cos());
    let half_width_m = half_width_m + sagitta_m;
    let frame = LocalFrame::new(disc.centre);
    let on = |n: f64| frame.to_place(LocalPoint::default().displaced(TAU * n / count, disc.radius_m));
    let chord = |n: u32| Corridor { from: on(f64::from(n)), to: on(f64::from(n + 1)), half_width_m };
    (0..count as u32).map(chord).collect()
}

/// The place at a distance in a direction.
pub(crate) fn displaced(place: LatLon, bearing_rad: f64, distance_m: f64) -> LatLon {
    LocalFrame::new(place).to_place(LocalPoint::default().displaced(bearing_rad, distance_m))
}

/// Distance of two places of one neighbourhood (m).
pub(crate) fn distance_m(from: LatLon, to: LatLon) -> f64 {
    let frame = LocalFrame::new(from);
    frame.to_local(from).distance_m(frame.to_local(to))
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
