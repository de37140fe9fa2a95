//! Depth at a point, within a circle and along a leg.

use super::coords::{Frame, Spot, TURN, unwrap_near};
use super::demand::{Demand, ZoneError};
use super::index::DepthIndex;
use super::object::{State, Stored, Water};
use super::piece::Kind;
use super::plane::{Across, Strip};
use super::restricted::{EntryRule, Restricted, Restriction};
use super::tree::{Node, Run};
use std::cell::Cell;
use units::{Geodetic, LatLon};

/// The way from one place to another along the geodesic.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Leg {
    /// Start.
    pub from: LatLon,
    /// End.
    pub to: LatLon,
}

/// The answer to a question about depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthAnswer {
    /// The deciding object: the worst there.
    pub water: Water,
    /// The object that decides, for [`DepthIndex::object`]; `None` where there is no data.
    pub object: Option<u32>,
    /// Where it comes nearest.
    pub at: LatLon,
    /// How far along the leg that is (m).
    pub along_m: f64,
    /// How far from the leg that is (m).
    pub off_m: f64,
    /// Zone of confidence (CATZOC 1 to 6): where errors of the chart are allowed for, the worst near the
    /// corridor; else the one at the place. `None` where it is not charted.
    pub zone: Option<u8>,
    /// The reduction of the charted depth for errors of the chart (m).
    pub depth_error_m: f64,
    /// Margin of the depth (m): negative = too shallow; `None` where it is not water of known depth.
    pub margin_m: Option<f64>,
    /// Whether the vessel may be there. False for everything that is not known to be deep enough, and in an area that it
    /// may not enter.
    pub navigable: bool,
    /// Of the areas whose entry is prohibited or restricted the one that counts most; `None` of those that the demand
    /// ignores.
    pub area: Option<Restricted>,
    /// The half width that was checked, with all allowances (m).
    pub half_width_m: f64,
}

impl DepthAnswer {
    /// With an area beside the water.
    #[must_use]
    pub fn within(self, area: Option<Restricted>) -> Self {
        let open = !area.is_some_and(|area| area.is_refused());
        Self { area, navigable: self.navigable && open, ..self }
    }
}

/// A finding in one piece of a leg.
#[derive(Debug, Clone, Copy)]
struct Hit {
    stored: Stored,
    object: Option<u32>,
    at: Spot,
    along_m: f64,
    off_m: f64,
}

/// The data of a run: its object's number in answers, its meaning, its zone of confidence and its restriction.
#[derive(Debug, Clone, Copy)]
pub(super) struct RunMeaning {
    pub(super) object: Option<u32>,
    stored: Stored,
    zone: Option<u8>,
    pub(super) restriction: Option<Restriction>,
}

/// A piece of a leg and what the chart's errors are there.
pub(super) struct Piece {
    pub(super) from: Spot,
    /// The water at its beginning.
    pub(super) state: State,
    pub(super) strip: Strip,
    zone: Option<u8>,
    error: Option<ZoneError>,
    /// Distance from the leg's start (m).
    pub(super) before_m: f64,
}

impl DepthIndex {
    /// The charted state at a point: the area that holds it, on a border the shallower of those that meet there, and
    /// dangers with an extent. Single dangers have none; ask [`Self::shallowest_within`] for a vessel that has a size or
    /// an uncertain position.
    pub fn depth_at(&self, place: LatLon, demand: &Demand) -> DepthAnswer {
        let state = self.worst_at(Spot::of(place));
        let mut water = state.stored.water();
        let mut object = state.object;
        if let Some((stored, id)) = state.overhead.filter(|_| demand.air_draught_m.is_some()) {
            let clearance_m = stored.clearance_m();
            if water.least_m().is_some() && !demand.fits_under(clearance_m) {
                (water, object) = (Water::TooLow { clearance_m }, Some(id));
            }
        }
        let error = demand.trust.errors().map(|(errors, _)| errors[zone_index(state.zone)]);
        let (navigable, margin_m) = demand.judge(water, error);
        DepthAnswer {
            water,
            object,
            at: place,
            along_m: 0.0,
            off_m: 0.0,
            zone: state.zone,
            depth_error_m: Demand::depth_error_m(error, water.least_m().unwrap_or(0.0)),
            margin_m,
            navigable,
            area: None,
            half_width_m: 0.0,
        }
        .within(state.restricted(place, demand))
    }

    /// The worst within a circle.
    pub fn shallowest_within(&self, place: LatLon, radius_m: f64, demand: &Demand) -> DepthAnswer {
        self.shallowest_along(Leg { from: place, to: place }, radius_m, demand)
    }

    /// The worst in the corridor of a leg: all places within `half_width_m` of it, its round ends included.
    pub fn shallowest_along(&self, leg: Leg, half_width_m: f64, demand: &Demand) -> DepthAnswer {
        let mut area = None;
        let answers = self.pieces(leg, half_width_m, demand).map(|piece| {
            area = Restricted::worse(area, self.restricted_in(&piece, demand, EntryRule::Warn));
            let hit = self.worst_of(&piece, demand);
            (Self::answer(&piece, hit, demand), hit.at)
        });
        let worst = answers.reduce(|worst, one| if order(&worst.0) <= order(&one.0) { worst } else { one });
        // A leg always has a piece.
        let Some((answer, at)) = worst else { return self.depth_at(leg.from, demand) };
        self.with_zone(answer, at).within(area)
    }

    /// The first danger on a leg: where a disc of the half width, moving along, first touches something that is
    /// not navigable. `along_m` is where the disc's centre is then.
    pub fn first_danger_along(&self, leg: Leg, half_width_m: f64, demand: &Demand) -> Option<DepthAnswer> {
        self.pieces(leg, half_width_m, demand).find_map(|piece| {
            let area = self.restricted_in(&piece, demand, EntryRule::Refuse);
            let hit = self.first_of(&piece, demand);
            let entered =
                area.filter(|area| hit.is_none_or(|hit| area.along_m < piece.before_m + hit.along_m));
            let hit = entered.map(|area| self.hit_in(&piece, &area)).or(hit)?;
            Some(self.with_zone(Self::answer(&piece, hit, demand).within(entered), hit.at))
        })
    }

    /// With the zone of confidence at the place, if no allowance was made for the worst near the corridor. Looked up for
    /// what is answered alone, as it takes longer than the rest.
    fn with_zone(&self, answer: DepthAnswer, at: Spot) -> DepthAnswer {
        DepthAnswer { zone: answer.zone.or_else(|| self.state_at(at).zone), ..answer }
    }

    /// The water where an area is entered.
    fn hit_in(&self, piece: &Piece, area: &Restricted) -> Hit {
        let (at, along_m) = (Spot::of(area.at), area.along_m - piece.before_m);
        let state = self.state_at(at);
        let to = piece.strip.spot(Across { u: along_m, v: 0.0 });
        let off_m = super::coords::distance_m(to, at);
        Hit { stored: state.stored, object: state.object, at, along_m, off_m }
    }

    fn answer(piece: &Piece, hit: Hit, demand: &Demand) -> DepthAnswer {
        let water = hit.stored.water();
        let (navigable, margin_m) = demand.judge(water, piece.error);
        DepthAnswer {
            water,
            object: hit.object,
            at: hit.at.place(),
            along_m: piece.before_m + hit.along_m,
            off_m: hit.off_m,
            zone: piece.zone,
            depth_error_m: Demand::depth_error_m(piece.error, water.least_m().unwrap_or(0.0)),
            margin_m,
            navigable,
            area: None,
            half_width_m: piece.strip.reach_m,
        }
    }

    fn pieces<'a>(
        &'a self,
        leg: Leg,
        half_width_m: f64,
        demand: &'a Demand,
    ) -> impl Iterator<Item = Piece> + 'a {
        // A width that is not a number must find everything dangerous: nothing is within NaN of anything.
        let half_width_m = half_width_m + demand.position_m;
        let half_width_m = if half_width_m.is_nan() { 1e6 } else { half_width_m.clamp(0.0, 1e6) };
        let mut before_m = 0.0;
        divide(leg).map(move |(from, to)| {
            let state = self.state_at(from);
            let (zone, error, wider_m) = self.chart_error((from, state.zone), to, half_width_m, demand);
            let strip = Strip::new(from, to, half_width_m + wider_m);
            let piece = Piece { from, state, strip, zone, error, before_m };
            before_m += strip.length_m;
            piece
        })
    }

    /// The worst zone of confidence that matters to a piece, its errors, and by how much it widens the piece.
    fn chart_error(
        &self,
        (from, zone): (Spot, Option<u8>),
        to: Spot,
        half_width_m: f64,
        demand: &Demand,
    ) -> (Option<u8>, Option<ZoneError>, f64) {
        let Some((errors, widen)) = demand.trust.errors() else { return (None, None, 0.0) };
        let widening = |zone: u8| if widen { errors[zone_index(Some(zone))].horizontal_m } else { 0.0 };
        let widest_m = (1..=6).map(widening).fold(0.0, f64::max);
        let strip = Strip::new(from, to, half_width_m + widest_m);
        let mut zone = zone.unwrap_or(6);
        self.each_segment(
            Kind::Quality,
            &strip,
            |_| true,
            |strip, told, a, b| {
                // Beyond the border of the assessed area the zone of confidence is unknown: 6.
                let found = told.zone.unwrap_or(6);
                let near = |nearest: super::plane::Nearest| {
                    nearest.distance_m <= strip.reach_m - widest_m + widening(found)
                };
                if found > zone && strip.nearest(a, b).is_some_and(near) {
                    zone = found;
                }
            },
        );
        let unassessed = self.charts_touched(&strip).into_iter().any(|chart| {
            let node = |bounds| Node { bounds, least_mm: 0 };
            let waters = self.directory.entries[chart].unassessed.map(node);
            waters.is_some_and(|node| turns(&strip).any(|strip| strip.may_touch(&node)))
        });
        if unassessed {
            zone = 6;
        }
        (Some(zone), Some(errors[zone_index(Some(zone))]), widening(zone))
    }

    /// The charts that a strip may touch, the best first.
    fn charts_touched(&self, strip: &Strip) -> Vec<usize> {
        self.charts_in(|node| turns(strip).any(|strip| strip.may_touch(node)))
    }

    /// Calls for every segment (or point) of the runs that a strip may touch.
    pub(super) fn each_segment(
        &self,
        kind: Kind,
        strip: &Strip,
        wanted: impl Fn(i32) -> bool,
        mut each: impl FnMut(&Strip, RunMeaning, Across, Across),
    ) {
        for chart in self.charts_touched(strip) {
            let piece = self.piece(chart);
            for strip in turns(strip) {
                let visit = |run: &Run| {
                    let object = piece.object(run.object);
                    let told = RunMeaning {
                        object: object.map(|_| self.number(chart, run.object)),
                        stored: piece.stored(run.object),
                        zone: object.and_then(|one| one.zone),
                        restriction: object.and_then(super::ChartObject::restriction),
                    };
                    let vertices = piece.vertices(run);
                    let mut a = strip.across(vertices[0]);
                    if vertices.len() == 1 {
                        each(&strip, told, a, a);
                    }
                    for vertex in &vertices[1..] {
                        let b = strip.across(*vertex);
                        each(&strip, told, a, b);
                        a = b;
                    }
                };
                piece.tree(kind).search(|node| wanted(node.least_mm) && strip.may_touch(node), visit);
            }
        }
    }

    /// What holds the start of a piece, if anything does.
    fn start_of(piece: &Piece, demand: &Demand) -> Hit {
        let state = piece.state;
        let mut hit =
            Hit { stored: state.stored, object: state.object, at: piece.from, along_m: 0.0, off_m: 0.0 };
        let low = |(stored, _): &(Stored, u32)| !demand.fits_under(stored.clearance_m());
        if let Some((stored, id)) = state.overhead.filter(low)
            && stored.least_mm() < hit.stored.least_mm()
        {
            (hit.stored, hit.object) = (stored, Some(id));
        }
        hit
    }

    fn worst_of(&self, piece: &Piece, demand: &Demand) -> Hit {
        let start = Self::start_of(piece, demand);
        let (worst, hit) = (Cell::new(start.stored.least_mm()), Cell::new(start));
        let consider = |strip: &Strip, told: RunMeaning, a: Across, b: Across| {
            let RunMeaning { stored, object, .. } = told;
            if stored.least_mm() >= worst.get() {
                return;
            }
            let Some(nearest) = strip.nearest(a, b) else { return };
            worst.set(stored.least_mm());
            let along_m = nearest.on.u.clamp(0.0, strip.length_m);
            hit.set(Hit { stored, object, at: strip.spot(nearest.on), along_m, off_m: nearest.distance_m });
        };
        self.each_segment(Kind::Danger, &piece.strip, |least| least < worst.get(), consider);
        if demand.air_draught_m.is_some() {
            let too_low = |strip: &Strip, told: RunMeaning, a: Across, b: Across| {
                if !demand.fits_under(told.stored.clearance_m()) {
                    consider(strip, told, a, b);
                }
            };
            self.each_segment(Kind::Overhead, &piece.strip, |least| least < worst.get(), too_low);
        }
        hit.get()
    }

    fn first_of(&self, piece: &Piece, demand: &Demand) -> Option<Hit> {
        let start = Self::start_of(piece, demand);
        let dangerous = |stored: Stored| !demand.judge(stored.water(), piece.error).0;
        if dangerous(start.stored) {
            return Some(start);
        }
        let enough_mm = demand.enough_mm(piece.error);
        let first: Cell<Option<Hit>> = Cell::new(None);
        let consider = |strip: &Strip, told: RunMeaning, a: Across, b: Across| {
            let RunMeaning { stored, object, .. } = told;
            if !dangerous(stored) {
                return;
            }
            let Some((along_m, on)) = strip.first_touch(a, b) else { return };
            let nearer = first
                .get()
                .is_none_or(|hit| (along_m, stored.least_mm()) < (hit.along_m, hit.stored.least_mm()));
            if nearer {
                let off_m = (on.u - along_m).hypot(on.v);
                first.set(Some(Hit { stored, object, at: strip.spot(on), along_m, off_m }));
            }
        };
        self.each_segment(Kind::Danger, &piece.strip, |least| least <= enough_mm, consider);
        if demand.air_draught_m.is_some() {
            let too_low = |strip: &Strip, told: RunMeaning, a: Across, b: Across| {
                if !demand.fits_under(told.stored.clearance_m()) {
                    consider(strip, told, a, b);
                }
            };
            self.each_segment(Kind::Overhead, &piece.strip, |_| true, too_low);
        }
        first.get()
    }
}

/// Less is worse: what is not a depth, then the margin.
fn order(answer: &DepthAnswer) -> (bool, f64, f64) {
    let rank = match answer.water {
        Water::Land => 0.0,
        Water::Obstacle => 1.0,
        Water::UnknownDepth => 2.0,
        Water::NoData => 3.0,
        Water::TooLow { .. } => 4.0,
        Water::Depth { .. } => 5.0,
    };
    (answer.water.least_m().is_some(), rank, answer.margin_m.unwrap_or(0.0))
}

fn zone_index(zone: Option<u8>) -> usize {
    usize::from(zone.filter(|zone| (1..=6).contains(zone)).unwrap_or(6)) - 1
}

/// A strip, and the same a turn away where it reaches over ±180°.
fn turns(strip: &Strip) -> impl Iterator<Item = Strip> {
    let (west, east) = strip.span_x();
    let half = TURN / 2.0;
    let over_east = (east > half).then(|| strip.turned(-TURN));
    let over_west = (west < -half).then(|| strip.turned(TURN));
    std::iter::once(*strip).chain(over_east).chain(over_west)
}

/// Divides a leg into pieces short enough to be straight.
pub(super) fn divide(leg: Leg) -> impl Iterator<Item = (Spot, Spot)> {
    let from = Spot::of(leg.from);
    let mut to = Spot::of(leg.to);
    to.x = unwrap_near(to.x, from.x);
    let frame = Frame::at(f64::midpoint(from.y, to.y));
    // The frame of the steeper end bends most.
    let piece_m = Frame::at(from.y).piece_m().min(Frame::at(to.y).piece_m());
    let length_m = frame.distance_m(from, to).max((to.y - from.y).abs() * frame.ky_m);
    // At most half the Earth's round in pieces of 50 m.
    let count = (length_m / piece_m).ceil().clamp(1.0, 500_000.0) as u32;
    let ends = [leg.from, leg.to].map(|place| {
        Geodetic { lat_rad: place.lat_rad(), lon_rad: place.lon_rad(), height_m: 0.0 }.to_ecef()
    });
    let point = move |at: u32| {
        if at == 0 {
            return from;
        }
        if at == count {
            return to;
        }
        let t = f64::from(at) / f64::from(count);
        let mix = |a: f64, b: f64| a + (b - a) * t;
        let chord = units::Ecef {
            x_m: mix(ends[0].x_m, ends[1].x_m),
            y_m: mix(ends[0].y_m, ends[1].y_m),
            z_m: mix(ends[0].z_m, ends[1].z_m),
        };
        let place = chord.to_geodetic();
        let place = LatLon::from_rad(place.lat_rad, place.lon_rad).unwrap_or(leg.from);
        let spot = Spot::of(place);
        Spot { x: unwrap_near(spot.x, from.x), ..spot }
    };
    (0..count).map(move |at| (point(at), point(at + 1)))
}
