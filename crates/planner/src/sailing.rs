//! What ways through one piece of sea room cost by an objective.
//!
//! Costs are sums over pieces of a leg, each with the conditions at its middle. Time runs along the way, so that a current
//! that changes is the one of the moment.

use crate::objective::{Objective, Spot, Toll};
use crate::plane::Point;
use crate::room::SeaRoom;
use std::sync::Arc;

/// Ways are compared in pieces so long (m), but legs in no more than so many.
const COMPARED_M: f64 = 10.0;
const MOST_PIECES: f64 = 4_000.0;

/// An objective, and the water that it prefers.
#[derive(Debug, Clone)]
pub(crate) struct Wish {
    pub(crate) objective: Arc<Objective>,
    /// Water of the preferred depth, and water of the preferred distance; each prepared around the same middle as the room.
    pub(crate) preferred: Vec<Arc<SeaRoom>>,
    /// How long before the start of this way the vessel departed (s).
    pub(crate) since_s: f64,
    /// The speed through the water that was chosen already (m/s).
    pub(crate) pace_mps: Option<f64>,
}

impl Wish {
    /// Speeds through the water that are tried (m/s), the greatest last.
    fn paces_mps(&self) -> Vec<f64> {
        self.pace_mps.map_or_else(|| self.objective.paces_mps(), |pace_mps| vec![pace_mps])
    }
}

/// A wish in a room.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sailing<'a> {
    pub(crate) room: &'a SeaRoom,
    pub(crate) wish: &'a Wish,
    /// Speed through the water (m/s).
    pub(crate) pace_mps: f64,
}

impl Sailing<'_> {
    /// The conditions at a point.
    pub(crate) fn spot(&self, at: Point) -> Spot {
        let Wish { objective, preferred, .. } = self.wish;
        let unmet = preferred.iter().filter(|room| room.mesh.locate(at).is_none()).count();
        let factor = objective.factor(unmet);
        Spot { factor, ..Spot::of(objective, self.room.plane(), at) }
    }

    /// What a straight leg costs that begins so long after the start of the way (s), in pieces of about so many metres, with
    /// the conditions that `spot` gives; `None` where it cannot be sailed.
    pub(crate) fn leg_by(
        &self,
        (from, to): (Point, Point),
        begin_s: f64,
        piece_m: f64,
        mut spot: impl FnMut(Point) -> Spot,
    ) -> Option<Toll> {
        let pieces = (from.distance_m(to) / piece_m).ceil().clamp(1.0, MOST_PIECES);
        let mut toll = Toll::default();
        let mut begin = from;
        for piece in 1..=pieces as u32 {
            let end = from.towards(to, f64::from(piece) / pieces);
            let here = spot(begin.towards(end, 0.5));
            let since_s = self.wish.since_s + begin_s + toll.duration_s;
            toll = toll.and(self.wish.objective.piece(&here, (begin, end), since_s, self.pace_mps)?);
            begin = end;
        }
        Some(toll)
    }

    /// As [`Self::leg_by`], with the conditions as they are.
    pub(crate) fn leg(&self, ends: (Point, Point), begin_s: f64, piece_m: f64) -> Option<Toll> {
        self.leg_by(ends, begin_s, piece_m, |at| self.spot(at))
    }

    /// What a way costs, in pieces of about so many metres; infinite where it cannot be sailed.
    pub(crate) fn way(&self, way: &[Point], piece_m: f64) -> Toll {
        let mut toll = Toll::default();
        for leg in way.windows(2) {
            match self.leg((leg[0], leg[1]), toll.duration_s, piece_m) {
                Some(next) => toll = toll.and(next),
                None => return Toll { cost: f64::INFINITY, duration_s: f64::INFINITY },
            }
        }
        toll
    }

    /// What a way costs, as finely as ways are compared.
    pub(crate) fn cost(&self, way: &[Point]) -> f64 {
        self.way(way, COMPARED_M).cost
    }

    /// This wish at another speed.
    pub(crate) fn at(&self, pace_mps: f64) -> Self {
        Self { pace_mps, ..*self }
    }

    /// The speed at which a way costs least, and what it costs then.
    pub(crate) fn best_pace(&self, way: &[Point]) -> (f64, f64) {
        let paces = self.wish.paces_mps().into_iter();
        let costs = paces.map(|pace_mps| (pace_mps, self.at(pace_mps).cost(way)));
        // Of speeds that cost the same, the fastest: the last one.
        costs.fold((self.pace_mps, f64::INFINITY), |best, one| if one.1 <= best.1 { one } else { best })
    }
}
