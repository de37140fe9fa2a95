//! What ways through one piece of sea room cost by an objective.
//!
//! Costs are sums over pieces of a leg, each with the conditions at its middle. Time runs along the way, so that a current
//! that changes is the one of the moment.

use crate::limits::{Limits, Piece};
use crate::objective::{Objective, Spot, Toll};
use crate::plane::Point;
use crate::room::SeaRoom;
use crate::{Cancel, PlanError};
use std::sync::Arc;

/// Ways are compared in pieces so long (m), but legs in no more than so many.
const COMPARED_M: f64 = 10.0;
const MOST_PIECES: f64 = 4_000.0;
/// A way is compared in about so many pieces; those of longer ways are longer.
const MOST_OF_A_WAY: f64 = 20_000.0;

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
    /// Of the objective, in the room's plane.
    pub(crate) limits: &'a Limits,
    /// Speed through the water (m/s).
    pub(crate) pace_mps: f64,
}

impl Sailing<'_> {
    /// The conditions at a point.
    pub(crate) fn spot(&self, at: Point) -> Spot {
        let Wish { objective, preferred, .. } = self.wish;
        let unmet = preferred.iter().filter(|room| room.mesh.locate(at).is_none()).count();
        let factor = objective.factor(unmet);
        Spot { factor, ..Spot::of(self.room.plane(), at) }
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
        let piece_m = piece_m.max(from.distance_m(to) / MOST_PIECES);
        let mut toll = Toll::default();
        for Piece { begin, end, most_mps, factor } in self.limits.pieces((from, to), piece_m) {
            let here = spot(begin.towards(end, 0.5));
            let since_s = self.wish.since_s + begin_s + toll.duration_s;
            let pace_mps = self.pace_mps.min(most_mps);
            let piece = self.wish.objective.piece(&here, (begin, end), since_s, pace_mps)?;
            toll = toll.and(piece.times(factor));
        }
        Some(toll)
    }

    /// As [`Self::leg_by`], with the conditions as they are.
    pub(crate) fn leg(&self, ends: (Point, Point), begin_s: f64, piece_m: f64) -> Option<Toll> {
        self.leg_by(ends, begin_s, piece_m, |at| self.spot(at))
    }

    /// This wish at another speed.
    pub(crate) fn at(&self, pace_mps: f64) -> Self {
        Self { pace_mps, ..*self }
    }

    /// A way in pieces, as finely as ways are compared, with the conditions at the middle of each.
    fn pieces(&self, way: &[Point], cancel: &Cancel<'_>) -> Result<Vec<(Piece, Spot)>, PlanError> {
        let way_m: f64 = way.windows(2).map(|leg| leg[0].distance_m(leg[1])).sum();
        let piece_m = COMPARED_M.max(way_m / MOST_OF_A_WAY);
        let mut all = Vec::new();
        for leg in way.windows(2) {
            cancel.check()?;
            let piece_m = piece_m.max(leg[0].distance_m(leg[1]) / MOST_PIECES);
            let pieces = self.limits.pieces((leg[0], leg[1]), piece_m);
            all.extend(pieces.map(|piece| (piece, self.spot(piece.begin.towards(piece.end, 0.5)))));
        }
        Ok(all)
    }

    /// What a way costs by its pieces; infinite where it cannot be sailed.
    fn cost_of(&self, pieces: &[(Piece, Spot)]) -> Toll {
        let mut toll = Toll::default();
        for (Piece { begin, end, most_mps, factor }, spot) in pieces {
            let since_s = self.wish.since_s + toll.duration_s;
            let pace_mps = self.pace_mps.min(*most_mps);
            match self.wish.objective.piece(spot, (*begin, *end), since_s, pace_mps) {
                Some(next) => toll = toll.and(next.times(*factor)),
                None => return Toll { cost: f64::INFINITY, duration_s: f64::INFINITY, ..toll },
            }
        }
        toll
    }

    /// What a way costs, as finely as ways are compared.
    pub(crate) fn cost(&self, way: &[Point], cancel: &Cancel<'_>) -> Result<f64, PlanError> {
        Ok(self.cost_of(&self.pieces(way, cancel)?).cost)
    }

    /// The speed at which a way costs least, and what it costs then.
    pub(crate) fn best_pace(&self, way: &[Point], cancel: &Cancel<'_>) -> Result<(f64, Toll), PlanError> {
        let pieces = self.pieces(way, cancel)?;
        let mut best = (self.pace_mps, Toll { cost: f64::INFINITY, ..Toll::default() });
        for pace_mps in self.wish.paces_mps() {
            cancel.check()?;
            let toll = self.at(pace_mps).cost_of(&pieces);
            // Of speeds that cost the same, the fastest: the last one.
            if toll.cost <= best.1.cost {
                best = (pace_mps, toll);
            }
        }
        Ok(best)
    }
}
