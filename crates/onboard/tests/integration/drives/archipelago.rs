//! The fictitious archipelago: starts close to its shores, and two judges of where the hull is.
//!
//! The charted depth comes from the index, which is compared with a plain reference elsewhere
//! (`crates/charts/tests/depth_reference.rs`); the true depth from the sea floor that the cells were drawn from.

use super::{HOME, HULL_M, Numbers, Waters};
use charts::demo::{SeaFloor, archipelago, sea_floor};
use charts::depth_index::{Demand, DepthIndex, IndexBuilder, Leg};
use charts::s57::{Cell, NamedBytes};
use onboard::Chart;
use std::sync::OnceLock;
use units::{LatLon, LocalFrame, LocalPoint};

/// Where drives start: the harbour's cell, which is a detailed one, so far from its borders that none leaves it (m
/// north and east of the demonstration's first Otter).
pub(super) const NORTH_M: [f64; 2] = [-1_100.0, 1_400.0];
pub(super) const EAST_M: [f64; 2] = [-1_100.0, 1_750.0];
/// Deep water around a start (m), and danger no farther than this (m).
const HAVEN_M: f64 = 25.0;
const NEAR_M: f64 = 200.0;
/// Plans and dangers lie within this distance along each axis (m).
const REACH_M: f64 = 250.0;

pub(super) struct Known {
    pub(super) chart: Chart,
    pub(super) index: DepthIndex,
    floor: SeaFloor,
}

pub(super) fn known() -> &'static Known {
    static KNOWN: OnceLock<Known> = OnceLock::new();
    KNOWN.get_or_init(|| {
        let mut builder = IndexBuilder::new();
        for file in archipelago().unwrap() {
            let named = NamedBytes { name: file.name, bytes: &file.bytes };
            builder.add_cell(&Cell::read(named, &[]).unwrap()).unwrap();
        }
        let index = builder.build().unwrap();
        Known { chart: Chart::of("archipelago", index.clone()), index, floor: sea_floor() }
    })
}

/// A start in the archipelago.
pub(crate) struct Archipelago {
    known: &'static Known,
    frame: LocalFrame,
}

impl Archipelago {
    fn place(&self, at: LocalPoint) -> LatLon {
        self.frame.to_place(at)
    }

    fn is_deep(&self, at: LocalPoint, radius_m: f64, least_m: f64) -> bool {
        let demand = Demand::least_depth(least_m);
        self.known.index.shallowest_within(self.place(at), radius_m, &demand).navigable
    }
}

impl Waters for Archipelago {
    fn of(numbers: &mut Numbers) -> Self {
        let known = known();
        let middle = LocalFrame::new(SeaFloor::ORIGIN.place().unwrap());
        loop {
            let north_m = numbers.within(NORTH_M[0], NORTH_M[1]);
            let east_m = numbers.within(EAST_M[0], EAST_M[1]);
            let frame = LocalFrame::new(middle.to_place(LocalPoint { north_m, east_m }));
            let waters = Self { known, frame };
            if waters.is_deep(HOME, HAVEN_M, 5.0) && !waters.is_deep(HOME, NEAR_M, 5.0) {
                return waters;
            }
        }
    }

    fn chart(&self) -> Chart {
        self.known.chart.clone()
    }

    fn frame(&self) -> LocalFrame {
        self.frame
    }

    fn danger(&self, numbers: &mut Numbers, least_m: f64) -> LocalPoint {
        let near = self.known.index.distance_to_shallower(self.frame.origin(), least_m, 5_000.0);
        let nearest = near.map_or(HOME, |near| self.frame.to_local(near.at));
        let mut some = (0..50).map(|_| numbers.point(REACH_M));
        some.find(|at| !self.is_deep(*at, 0.0, least_m)).unwrap_or(nearest)
    }

    /// Half of the plans seek room, or nearly all would be refused.
    fn goals(&self, numbers: &mut Numbers) -> Vec<LocalPoint> {
        let seeks = numbers.within(0.0, 1.0) < 0.5;
        let mut goals = Vec::new();
        while goals.len() < 3 {
            let from = goals.last().copied().unwrap_or(HOME);
            let mut some: Vec<LocalPoint> = (0..40).map(|_| numbers.point(REACH_M)).collect();
            let roomy = some.iter().position(|to| seeks && self.has_room(from, *to, 15.0, 5.0));
            goals.push(some.swap_remove(roomy.unwrap_or(0)));
        }
        goals
    }

    fn has_room(&self, from: LocalPoint, to: LocalPoint, room_m: f64, least_m: f64) -> bool {
        let leg = Leg { from: self.place(from), to: self.place(to) };
        self.known.index.shallowest_along(leg, room_m, &Demand::least_depth(least_m)).navigable
    }

    fn is_afloat(&self, at: LocalPoint, least_m: f64) -> bool {
        // The chart's depths are good for half a metre and a hundredth, as its zone of confidence A1 says.
        let floor_m = self.known.floor.depth_m(self.place(at));
        self.is_deep(at, HULL_M, least_m) && floor_m >= least_m - 0.5 - 0.01 * least_m
    }
}
