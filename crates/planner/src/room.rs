//! Sea room: the water that is deep enough and far enough from dangers, ready to be searched.

use crate::Cancel;
use crate::boxes::{Bounds, Boxes};
use crate::learned::Learned;
use crate::mesh::Mesh;
use crate::needs::{Needs, NeedsError};
use crate::obstacles::{Cut, Pieces, SLACK_M, cut_out, matched, project};
use crate::plane::{Plane, Point, sides};
use crate::region::Region;
use crate::search::{self, Found, Place};
use crate::tile::Tiles;
use crate::walls::Lines;
use crate::zones::Zones;
use charts::depth_index::{ChartTrust, ClosingLine, DepthIndex, GeoBox};
use std::collections::BTreeSet;
use std::sync::Arc;
use units::LatLon;

/// Around the whole chart (m).
const MARGIN_M: f64 = 500.0;
/// Farther than this from every danger is not measured (m).
pub(crate) const FAR_M: f64 = 5_000.0;
/// Clearances are measured in pieces of a leg so long (m).
const PIECE_M: f64 = 250.0;
/// Points on each border of a box that is brought from the plane to the globe or back.
const BORDER_POINTS: u32 = 16;

/// A search of more intervals, which takes some milliseconds, asks for landmarks.
const MANY_INTERVALS: usize = 10_000;

/// Why sea room cannot be prepared.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// Needs that nothing can meet.
    #[error(transparent)]
    Needs(#[from] NeedsError),
    /// The request was cancelled.
    #[error("the answer is no longer wanted")]
    Cancelled,
    /// The time of the request is used up.
    #[error("the time for planning is used up: ask for a shorter way, or add places on the way")]
    OutOfTime,
    /// The chart's geometry could not be divided.
    #[error("the chart cannot be divided for planning: {0}; report this with the charts' names")]
    Geometry(String),
}

/// Water that meets certain needs, in a region.
#[derive(Debug, Clone)]
pub struct SeaRoom {
    needs: Needs,
    zones: Arc<Zones>,
    /// Sides of the zones' borders.
    borders: Vec<[Point; 2]>,
    plane: Plane,
    pub(crate) region: Region,
    pub(crate) mesh: Mesh,
    pub(crate) learned: Learned,
    barriers: Vec<[Point; 2]>,
    tree: Boxes,
    /// How far from every barrier it keeps, without what is allowed for rounding and bowing (m).
    cut_m: f64,
    /// The greatest scale of the plane in it.
    scale: f64,
    /// Pieces of water that reach the border of the region: these alone may go on beyond it.
    leading_out: BTreeSet<u32>,
}

impl SeaRoom {
    /// Prepares the water of a whole chart.
    ///
    /// # Errors
    /// When the needs are out of range, the geometry is damaged, or the request was cancelled.
    pub fn of_chart(
        index: &DepthIndex,
        needs: &Needs,
        zones: &Arc<Zones>,
        cancel: &Cancel<'_>,
    ) -> Result<Self, PlanError> {
        let Some(extent) = index.extent() else {
            return Self::around(index, (needs, zones), nowhere(), (0.0, 0.0), cancel);
        };
        let middle = middle_of(&extent);
        let plane = Plane::new(middle);
        let border = border_of([extent.west_deg, extent.south_deg], [extent.east_deg, extent.north_deg]);
        let points =
            border.filter_map(|[lon, lat]| LatLon::from_deg(lat, lon).ok()).map(|place| plane.point(place));
        let bounds = Bounds::of(&points.collect::<Vec<_>>());
        let half = |min: f64, max: f64| min.abs().max(max.abs()) + MARGIN_M + needs.reach_m();
        let halves = (half(bounds.min.x, bounds.max.x), half(bounds.min.y, bounds.max.y));
        Self::around(index, (needs, zones), middle, halves, cancel)
    }

    /// Prepares the water as far as so many metres east and west, and north and south, of a place.
    ///
    /// # Errors
    /// When the needs are out of range, the geometry is damaged, or the request was cancelled.
    pub fn around(
        index: &DepthIndex,
        (needs, zones): (&Needs, &Arc<Zones>),
        middle: LatLon,
        (east_m, north_m): (f64, f64),
        cancel: &Cancel<'_>,
    ) -> Result<Self, PlanError> {
        needs.validate()?;
        let plane = Plane::new(middle);
        let region = Region { min: Point { x: -east_m, y: -north_m }, max: Point { x: east_m, y: north_m } };
        let Cutting { pieces, lines, cut_m, scale } =
            Cutter { index, needs, zones, plane: &plane, cancel }.cut(region, MARGIN_M)?;
        let barriers = lines.iter().flat_map(|line| sides(line)).collect();
        // The memory of a large region is what counts aboard.
        drop(lines);
        let parts = Parts { region, pieces, barriers, cut_m, scale };
        let mut room = Self::divided(index, (needs, zones), plane, parts, cancel)?;
        room.leading_out = room.mesh.pieces_at(|at| region.is_at_border(at));
        Ok(room)
    }

    /// Prepares the water of some tiles as one; the chart is read tile by tile. What lies beyond their edge is not their water,
    /// but clearances are measured to it, so far (m).
    pub(crate) fn of_tiles(
        index: &DepthIndex,
        (needs, zones): (&Needs, &Arc<Zones>),
        (Tiles { grid, tiles }, measured_m): (&Tiles, f64),
        cancel: &Cancel<'_>,
    ) -> Result<Self, PlanError> {
        needs.validate()?;
        let plane = Plane::new(grid.middle);
        let cutter = Cutter { index, needs, zones, plane: &plane, cancel };
        let (mut pieces, mut barriers, mut corners) = (Vec::new(), Vec::new(), Vec::new());
        let (mut cut_m, mut scale) = (0.0_f64, 1.0_f64);
        for tile in tiles.iter() {
            let region = grid.region(*tile);
            let part = cutter.cut(region, measured_m)?;
            (cut_m, scale) = (cut_m.max(part.cut_m), scale.max(part.scale));
            pieces.extend(part.pieces);
            corners.extend([region.min, region.max]);
            let around = region.wider(measured_m);
            // What lies in another one of these tiles comes with that.
            barriers.extend(part.lines.iter().flat_map(|line| sides(line)).filter(|side| {
                let home = grid.tile(side[0]);
                home == *tile || !tiles.contains(&home) && around.holds(side[0])
            }));
        }
        let order = |side: &[Point; 2]| side.map(|at| [at.x.to_bits(), at.y.to_bits()]);
        barriers.sort_unstable_by_key(order);
        barriers.dedup();
        let region = Region::of(&corners);
        let pieces = if tiles.len() == 1 { pieces } else { matched(pieces, grid.tile_m, cancel)? };
        let mut room = Self::divided(
            index,
            (needs, zones),
            plane,
            Parts { region, pieces, barriers, cut_m, scale },
            cancel,
        )?;
        // What lies beyond tiles was not looked at.
        room.leading_out = room.mesh.piece.iter().copied().collect();
        Ok(room)
    }

    /// The open pieces of a region, as triangles.
    fn divided(
        index: &DepthIndex,
        (needs, zones): (&Needs, &Arc<Zones>),
        plane: Plane,
        Parts { region, pieces, barriers, cut_m, scale }: Parts,
        cancel: &Cancel<'_>,
    ) -> Result<Self, PlanError> {
        // The chart itself says which pieces are open: by the very question that legs are asked.
        let is_open = |at: Point| {
            let place = plane.place(at);
            zones.allow(place) && index.shallowest_within(place, needs.clearance_m, &needs.demand).navigable
        };
        let mesh = Mesh::new(pieces, is_open, cancel)?;
        let bounds: Vec<Bounds> = barriers.iter().map(|side| Bounds::of(side)).collect();
        let tree = Boxes::new(&bounds);
        let borders = zones.borders(&plane).iter().flat_map(|border| sides(border)).collect();
        Ok(Self {
            needs: *needs,
            zones: Arc::clone(zones),
            borders,
            plane,
            region,
            mesh,
            learned: Learned::default(),
            barriers,
            tree,
            cut_m,
            scale,
            leading_out: BTreeSet::new(),
        })
    }

    /// What it was made for.
    pub fn needs(&self) -> &Needs {
        &self.needs
    }

    /// What its ways keep to beside the chart.
    pub fn zones(&self) -> &Arc<Zones> {
        &self.zones
    }

    /// Number of its triangles.
    pub fn triangles(&self) -> usize {
        self.mesh.corners.len()
    }

    /// How many straight parts it has of what its ways keep clear of.
    pub(crate) fn barriers(&self) -> usize {
        self.barriers.len()
    }

    /// About how much memory it takes (bytes).
    pub fn bytes(&self) -> usize {
        self.mesh.bytes()
            + self.learned.bytes()
            + self.tree.bytes()
            + self.barriers.len() * size_of::<[Point; 2]>()
    }

    /// The shortest way between two points of the room; if a side is closed, given by its corners, the shortest around it.
    pub(crate) fn shortest(
        &self,
        ends: [Place; 2],
        closed: Option<[u32; 2]>,
        cancel: &Cancel<'_>,
    ) -> Result<Found, PlanError> {
        let found = search::shortest((&self.mesh, self.learned.landmarks()), ends, closed, cancel)?;
        if found.as_ref().is_some_and(|(_, effort)| effort.intervals > MANY_INTERVALS) {
            self.learned.ask_for(self.mesh.piece[ends[0].1 as usize]);
        }
        Ok(found)
    }

    /// Whether a piece of water may go on beyond the region.
    pub(crate) fn leads_out(&self, piece: u32) -> bool {
        self.leading_out.contains(&piece)
    }

    /// Vertices of the charts that a region around a place is cut out of, or more: told without reading any.
    pub(crate) fn vertices(index: &DepthIndex, needs: &Needs, middle: LatLon, half_m: f64) -> usize {
        let corner = Point { x: half_m, y: half_m };
        let region = Region { min: Point { x: -half_m, y: -half_m }, max: corner };
        index.vertices_of_charts_in(&box_of(region, &Plane::new(middle), 2.0 * needs.reach_m() + MARGIN_M))
    }

    pub(crate) fn plane(&self) -> &Plane {
        &self.plane
    }

    /// How far from every barrier it keeps, without what is allowed for rounding and bowing (m).
    pub(crate) fn cut_m(&self) -> f64 {
        self.cut_m
    }

    /// All that its ways keep clear of, with the depths at which it closes, and by how much more they keep off (m).
    pub(crate) fn closing_lines(&self, index: &DepthIndex) -> (Vec<ClosingLine>, f64) {
        let reach_m = 2.0 * self.needs.reach_m() + MARGIN_M;
        index.closing_lines(&self.needs.demand, &box_of(self.region, &self.plane, reach_m))
    }

    /// Those lines, and the borders of its zones, in its plane, thinned by so much (m).
    pub(crate) fn lines(&self, chart: &[ClosingLine], thinned_m: f64) -> Lines {
        Lines::new(&self.plane, chart, &self.zones.borders(&self.plane), thinned_m)
    }

    /// A way between two points that leaves the region is at least so long (m).
    pub(crate) fn least_way_out_m(&self, from: Point, to: Point) -> f64 {
        let Region { min, max } = self.region;
        // By way of a border: straight to the mirror image of the goal behind it.
        let across = |a: f64, b: f64, along: f64| (a + b).hypot(along);
        let (dx, dy) = ((to.x - from.x).abs(), (to.y - from.y).abs());
        let borders = [
            across(from.x - min.x, to.x - min.x, dy),
            across(max.x - from.x, max.x - to.x, dy),
            across(from.y - min.y, to.y - min.y, dx),
            across(max.y - from.y, max.y - to.y, dx),
        ];
        borders.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// Whether no barrier and no zone's border comes nearer to a leg than ways in this room keep off.
    pub(crate) fn keeps_clear(&self, from: Point, to: Point) -> bool {
        self.keeps_from_borders(from, to, self.zones.margin_m() + SLACK_M)
            && self.clearance(from, to, self.cut_m + SLACK_M).is_none()
    }

    /// How far around a point legs may lead and keep clear (m), `most_m` at most; 0 where it does not keep clear itself.
    pub(crate) fn free_m(&self, at: Point, most_m: f64) -> f64 {
        let off_m = self.cut_m + SLACK_M;
        let barrier_m = self.clearance(at, at, most_m + off_m).map_or(most_m, |(clear_m, _)| clear_m - off_m);
        let here = Bounds::of(&[at]);
        let border_off_m = self.zones.margin_m() + SLACK_M;
        let near =
            self.borders.iter().filter(|side| Bounds::of(*side).distance_m(&here) <= most_m + border_off_m);
        let border_m = near.map(|[a, b]| at.distance_m(at.nearest_on(*a, *b)) - border_off_m);
        border_m.fold(barrier_m, f64::min).max(0.0)
    }

    /// Whether a leg keeps to the zones: it begins where they allow it, and comes no nearer to a border than their margin.
    pub(crate) fn keeps_to_zones(&self, from: Point, to: Point) -> bool {
        self.zones.allow(self.plane.place(from)) && self.keeps_from_borders(from, to, self.zones.margin_m())
    }

    fn keeps_from_borders(&self, from: Point, to: Point, off_m: f64) -> bool {
        let leg = Bounds::of(&[from, to]);
        let near =
            self.borders.iter().filter(|side| Bounds::of(*side).distance_m(&leg) <= off_m * self.scale);
        near.into_iter().all(|[a, b]| self.distance_m((from, to), (*a, *b)).0 > off_m)
    }

    /// How far a leg keeps from the nearest barrier (m), and where; `None` if no barrier is so near.
    pub(crate) fn clearance(&self, from: Point, to: Point, within_m: f64) -> Option<(f64, Point)> {
        let mut nearest: Option<(f64, Point)> = None;
        // The box around a long leg holds half the chart; those around its pieces hold little.
        let pieces = (from.distance_m(to) / PIECE_M).ceil().clamp(1.0, 1e5) as u32;
        let at = |piece: u32| from.towards(to, f64::from(piece) / f64::from(pieces));
        for piece in 0..pieces {
            let (from, to) = (at(piece), at(piece + 1));
            let within_m = nearest.map_or(within_m, |(held_m, _)| held_m);
            self.tree.nearest(&Bounds::of(&[from, to]), within_m * self.scale, |side| {
                let [a, b] = self.barriers[side as usize];
                let (distance_m, at) = self.distance_m((from, to), (a, b));
                if distance_m <= within_m && nearest.is_none_or(|(held_m, _)| distance_m < held_m) {
                    nearest = Some((distance_m, at));
                }
                nearest.map_or(within_m, |(held_m, _)| held_m) * self.scale
            });
        }
        nearest
    }

    /// Distance of two segments on the sea (m), and the point of the second that is nearest.
    fn distance_m(&self, (from, to): (Point, Point), (a, b): (Point, Point)) -> (f64, Point) {
        let (distance_m, at) = distance(from, to, a, b);
        (distance_m / self.plane.scale(at), at)
    }
}

/// What a room is made of.
struct Parts {
    region: Region,
    pieces: Pieces,
    barriers: Vec<[Point; 2]>,
    cut_m: f64,
    scale: f64,
}

/// What is left of a region, and the chart's lines around it.
struct Cutting {
    pieces: Pieces,
    lines: Vec<Vec<Point>>,
    /// How far from every line water was cut out (m), without what is allowed for rounding and bowing.
    cut_m: f64,
    /// The greatest scale of the plane there.
    scale: f64,
}

/// Cuts what is closed out of regions of a plane.
struct Cutter<'a> {
    index: &'a DepthIndex,
    needs: &'a Needs,
    zones: &'a Arc<Zones>,
    plane: &'a Plane,
    cancel: &'a Cancel<'a>,
}

impl Cutter<'_> {
    /// Cuts a region out of the chart's lines that come nearer to it than twice the reach and this (m).
    fn cut(&self, region: Region, margin_m: f64) -> Result<Cutting, PlanError> {
        let Self { index, needs, zones, plane, cancel } = *self;
        let reach_m = needs.reach_m();
        let barriers = index.barriers(&needs.demand, &box_of(region, plane, 2.0 * reach_m + margin_m));
        cancel.check()?;
        let lines = project(&barriers.lines, plane);
        let cut_m = reach_m + barriers.wider_m;
        // A large region's memory is what counts aboard, and this is in the plane by now.
        drop(barriers);
        // In the plane everything is longer, by up to 0.2 % at 600 km from the middle, and so is the clearance.
        let around = region.wider(2.0 * cut_m).ring();
        let scale = around.into_iter().map(|corner| plane.scale(corner)).fold(1.0, f64::max);
        let borders = zones.borders(plane);
        // Lines are read by the least confidence of all charts, and legs are judged by that of the chart at their place: where
        // depths are not trusted as charted, the two differ, and a hole in what is cut out may be open.
        let closed_m = (needs.demand.trust == ChartTrust::AsCharted).then_some(reach_m);
        let cuts = [
            Cut { lines: &lines, clearance_m: cut_m, plane: Some(plane), closed_m },
            Cut { lines: &borders, clearance_m: zones.margin_m(), plane: Some(plane), closed_m: None },
        ];
        Ok(Cutting { pieces: cut_out(region, &cuts, cancel)?, lines, cut_m, scale })
    }
}

fn nowhere() -> LatLon {
    LatLon::from_deg(0.0, 0.0).expect("invariant: 0, 0 is a place")
}

fn middle_of(extent: &GeoBox) -> LatLon {
    let lat_deg = f64::midpoint(extent.south_deg, extent.north_deg);
    let lon_deg = f64::midpoint(extent.west_deg, extent.east_deg);
    LatLon::from_deg(lat_deg, lon_deg).unwrap_or_else(|_| nowhere())
}

/// Points on the border of a box of two corners.
fn border_of(min: [f64; 2], max: [f64; 2]) -> impl Iterator<Item = [f64; 2]> {
    (0..=BORDER_POINTS).flat_map(move |n| {
        let share = f64::from(n) / f64::from(BORDER_POINTS);
        let (x, y) = (min[0] + (max[0] - min[0]) * share, min[1] + (max[1] - min[1]) * share);
        [[x, min[1]], [x, max[1]], [min[0], y], [max[0], y]]
    })
}

/// A box on the globe that holds a region and so much around it.
fn box_of(region: Region, plane: &Plane, margin_m: f64) -> GeoBox {
    let Region { min, max } = region;
    // Between the points that are looked at, the border of the box bows by far less than a share of its size.
    let more_m = margin_m + 0.02 * (max.x - min.x).max(max.y - min.y);
    let border = border_of([min.x - more_m, min.y - more_m], [max.x + more_m, max.y + more_m]);
    // Longitudes are taken from that of the region's own middle: it may lie far from the plane's, and beyond a pole.
    let middle = plane.place(min.towards(max, 0.5));
    let mut found =
        GeoBox { west_deg: 0.0, east_deg: 0.0, south_deg: middle.lat_deg(), north_deg: middle.lat_deg() };
    for [x, y] in border {
        let place = plane.place(Point { x, y });
        let east_deg = units::wrap_pi(place.lon_rad() - middle.lon_rad()).to_degrees();
        found.west_deg = found.west_deg.min(east_deg);
        found.east_deg = found.east_deg.max(east_deg);
        found.south_deg = found.south_deg.min(place.lat_deg());
        found.north_deg = found.north_deg.max(place.lat_deg());
    }
    if found.east_deg - found.west_deg > 350.0 || found.north_deg > 88.0 || found.south_deg < -88.0 {
        // Around a pole, which may lie within.
        let (south_deg, north_deg) =
            if middle.lat_deg() > 0.0 { (found.south_deg, 90.0) } else { (-90.0, found.north_deg) };
        return GeoBox { west_deg: -180.0, east_deg: 180.0, south_deg, north_deg };
    }
    let lon_deg = |east_deg: f64| units::wrap_pi(middle.lon_rad() + east_deg.to_radians()).to_degrees();
    GeoBox { west_deg: lon_deg(found.west_deg), east_deg: lon_deg(found.east_deg), ..found }
}

/// Distance of two segments (m) and the point of the second that is nearest.
fn distance(from: Point, to: Point, a: Point, b: Point) -> (f64, Point) {
    let (of_a, of_b) = (from.cross(to, a), from.cross(to, b));
    let (of_from, of_to) = (a.cross(b, from), a.cross(b, to));
    if of_a * of_b < 0.0 && of_from * of_to < 0.0 {
        return (0.0, a.towards(b, of_a / (of_a - of_b)));
    }
    let ends = [
        (a.distance_m(a.nearest_on(from, to)), a),
        (b.distance_m(b.nearest_on(from, to)), b),
        (from.distance_m(from.nearest_on(a, b)), from.nearest_on(a, b)),
        (to.distance_m(to.nearest_on(a, b)), to.nearest_on(a, b)),
    ];
    ends.into_iter().fold((f64::INFINITY, a), |best, one| if one.0 < best.0 { one } else { best })
}
