//! Joins lines that lie near each other, until they part two points.
//!
//! Lines are cut into pieces no longer than half a square of the size of the reach, so that pieces in one square are surely
//! joined. A link between two pieces on the same hand of the line through the two points crosses nothing, and tells nothing
//! new once both are parts of the same whole: for most pieces one look at each square around is enough.

use crate::Cancel;
use crate::boxes::Bounds;
use crate::nearby::Nearby;
use crate::parts::Parts;
use crate::plane::{Point, sides};
use crate::region::Region;
use crate::side::{Gap, Kind, Reach, Side, Trouble};

/// No square is smaller (m).
const LEAST_SQUARE_M: f64 = 10.0;
/// Pieces between two looks at whether the answer is still wanted.
const PIECES_BETWEEN_LOOKS: usize = 1_024;
/// More pieces, or more pairs of them, are too many to look at.
const MOST_PIECES: usize = 3_000_000;
const MOST_PAIRS: usize = 20_000_000;
/// More gaps are too many to keep.
const MOST_GAPS: usize = 2_000_000;
/// On which hand of the line through the points a piece lies; one that meets it is on both.
const LEFT: u8 = 1;
const RIGHT: u8 = 2;

/// What joining came to.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Outcome {
    /// The depth at which the line closes that completes a wall.
    pub(crate) parted_at_m: Option<f64>,
    /// The gap that closes last between the lesser reach and the greater.
    pub(crate) gap: Option<Gap>,
}

/// Lines that are being joined.
pub(crate) struct Joining {
    /// First those that are looked at by all others, then pieces, in the order of the depths at which they close.
    sides: Vec<Side>,
    /// How many are looked at by all others.
    special: usize,
    /// What is joined at once, and up to where gaps are looked at after that.
    reaches: [Reach; 2],
    ends: [Point; 2],
    nearby: Nearby,
    parts: Parts,
    /// Pieces in one square are surely joined.
    squares_join: bool,
    gaps: Vec<(f32, u32, u32)>,
    pairs: usize,
}

impl Joining {
    pub(crate) fn new(
        region: Region,
        lines: &[Side],
        reaches: [Reach; 2],
        ends: [Point; 2],
    ) -> Result<Self, Trouble> {
        let reach_m = reaches[1].chart_m;
        let near = region.wider(reaches[1].most_m());
        let nearby = Nearby::new(near, reach_m.max(LEAST_SQUARE_M));
        let edges = sides(&region.ring())
            .map(|ends| Side { ends, deeper_than_m: f64::NEG_INFINITY, kind: Kind::Edge })
            .collect::<Vec<Side>>();
        let drawn = lines.iter().filter(|side| side.kind == Kind::Zone).copied();
        let mut all: Vec<Side> = edges.into_iter().chain(drawn).collect();
        let special = all.len();
        for side in lines.iter().filter(|side| side.kind != Kind::Zone) {
            let Some((a, b)) = near.clip(side.ends[0], side.ends[1]) else { continue };
            // Saturates where there are too many in any case.
            let count = (2.0 * a.distance_m(b) / nearby.size_m()).ceil().max(1.0) as u32;
            if all.len() + count as usize > MOST_PIECES {
                return Err(Trouble::TooMany);
            }
            let at = |piece: u32| a.towards(b, f64::from(piece) / f64::from(count));
            all.extend((0..count).map(|piece| Side { ends: [at(piece), at(piece + 1)], ..*side }));
        }
        let squares_join = nearby.size_m() <= std::f64::consts::SQRT_2 * reaches[0].chart_m;
        let parts = Parts::new(all.len());
        Ok(Self {
            sides: all,
            special,
            reaches,
            ends,
            nearby,
            parts,
            squares_join,
            gaps: Vec::new(),
            pairs: 0,
        })
    }

    pub(crate) fn run(mut self, cancel: &Cancel<'_>) -> Result<Outcome, Trouble> {
        for at in 0..self.sides.len() {
            if at % PIECES_BETWEEN_LOOKS == 0 {
                cancel.check()?;
            }
            let parted = (0..at.min(self.special)).any(|other| self.look(other, at))
                || (at >= self.special && self.look_around(at));
            if parted {
                return Ok(Outcome { parted_at_m: Some(self.sides[at].deeper_than_m), gap: None });
            }
            if self.pairs > MOST_PAIRS || self.gaps.len() > MOST_GAPS {
                return Err(Trouble::TooMany);
            }
        }
        if self.reaches[0] != self.reaches[1] {
            self.find_gaps(cancel)?;
        }
        Ok(Outcome { parted_at_m: None, gap: self.close_gaps() })
    }

    /// Notes the gaps between what is not joined by the lesser reach: few are left then.
    fn find_gaps(&mut self, cancel: &Cancel<'_>) -> Result<(), Trouble> {
        let within_m = 2.0 * self.reaches[1].chart_m + 0.5 * self.nearby.size_m();
        for at in 0..self.sides.len() {
            if at % PIECES_BETWEEN_LOOKS == 0 {
                cancel.check()?;
            }
            for other in 0..at.min(self.special) {
                self.note(other, at);
            }
            if at < self.special {
                continue;
            }
            let hand = self.hand(at);
            let squares: Vec<usize> = self.nearby.around(self.sides[at].middle(), within_m).collect();
            for newest in
                squares.into_iter().filter_map(|square| self.nearby.newest(square)).collect::<Vec<_>>()
            {
                let whole = self.squares_join && hand != LEFT | RIGHT && self.nearby.mark(newest) == hand;
                if whole && self.is_one(at, newest) {
                    continue;
                }
                let mut piece = Some(newest);
                while let Some(one) = piece {
                    piece = self.nearby.earlier(one);
                    let other = one as usize + self.special;
                    let nothing_new =
                        hand != LEFT | RIGHT && self.hand(other) == hand && self.is_one(at, one);
                    // Each pair once.
                    if other < at && !nothing_new {
                        self.note(other, at);
                    }
                }
            }
            if self.gaps.len() > MOST_GAPS {
                return Err(Trouble::TooMany);
            }
        }
        Ok(())
    }

    /// Notes the gap between two that are not joined by the lesser reach and are by the greater.
    fn note(&mut self, one: usize, other: usize) {
        let pair = [&self.sides[one], &self.sides[other]];
        let [sure_m, most_m] = self.reaches.map(|reach| reach.of(pair[0].kind) + reach.of(pair[1].kind));
        if Bounds::of(&pair[0].ends).distance_m(&Bounds::of(&pair[1].ends)) > most_m {
            return;
        }
        let width_m = Near::of(pair[0], pair[1]).width_m;
        if width_m > sure_m && width_m <= most_m {
            // What the reach is at which they join; within 20 km to the millimetre.
            let grows = pair.iter().filter(|side| matches!(side.kind, Kind::Chart | Kind::Rule)).count();
            let reach_m = (width_m - most_m) / grows.max(1) as f64 + self.reaches[1].chart_m;
            self.gaps.push((reach_m as f32, one as u32, other as u32));
        }
    }

    /// Looks at the pieces near one; whether that completes a wall.
    fn look_around(&mut self, at: usize) -> bool {
        let middle = self.sides[at].middle();
        let hand = self.hand(at);
        let one_hand = self.squares_join && hand != LEFT | RIGHT;
        let here = self.nearby.square_of(middle);
        let newest = self.nearby.newest(here).filter(|newest| one_hand && self.nearby.mark(*newest) == hand);
        // A square all of whose neighbours are one with it learns nothing new by one more piece.
        if let Some(newest) = newest
            && self.nearby.is_settled(here)
        {
            self.nearby.add(here, hand);
            return self.parts.join(newest + self.special as u32, at as u32, false);
        }
        let within_m = 2.0 * self.reaches[0].chart_m + 0.5 * self.nearby.size_m();
        let squares: Vec<usize> = self.nearby.around(middle, within_m).collect();
        let mut settled = one_hand;
        for square in squares {
            let Some(newest) = self.nearby.newest(square) else { continue };
            let whole = one_hand && self.nearby.mark(newest) == hand;
            if whole && self.is_one(at, newest) {
                continue;
            }
            if self.look_into(newest, at, whole) {
                return true;
            }
            if !(whole && self.is_one(at, newest)) {
                settled = false;
                self.nearby.settle(square, false);
            }
        }
        self.nearby.add(here, hand);
        self.nearby.settle(here, settled);
        false
    }

    /// Looks at the pieces of a square; whether that completes a wall. One that it is joined to is enough of a square that is
    /// `whole`: joined within, on the same hand.
    fn look_into(&mut self, newest: u32, at: usize, whole: bool) -> bool {
        let hand = self.hand(at);
        let mut piece = Some(newest);
        while let Some(one) = piece {
            piece = self.nearby.earlier(one);
            let other = one as usize + self.special;
            let nothing_new = hand != LEFT | RIGHT && self.is_one(at, one) && self.hand(other) == hand;
            if !nothing_new && self.look(other, at) {
                return true;
            }
            if whole && self.is_one(at, one) {
                return false;
            }
        }
        false
    }

    fn is_one(&mut self, at: usize, piece: u32) -> bool {
        self.parts.are_one(at as u32, piece + self.special as u32)
    }

    fn hand(&self, at: usize) -> u8 {
        let [from, to] = self.ends;
        let hands = self.sides[at].ends.map(|end| if from.cross(to, end) > 0.0 { LEFT } else { RIGHT });
        hands[0] | hands[1]
    }

    /// Joins two if they lie near enough; whether that completes a wall.
    fn look(&mut self, one: usize, other: usize) -> bool {
        let pair = [&self.sides[one], &self.sides[other]];
        let reach_m = self.reaches[0].of(pair[0].kind) + self.reaches[0].of(pair[1].kind);
        if Bounds::of(&pair[0].ends).distance_m(&Bounds::of(&pair[1].ends)) > reach_m {
            return false;
        }
        self.pairs += 1;
        let near = Near::of(pair[0], pair[1]);
        near.width_m <= reach_m && self.parts.join(one as u32, other as u32, near.crosses(self.ends, pair))
    }

    /// Joins what has gaps between it, the narrowest first; the gap that completes a wall.
    fn close_gaps(mut self) -> Option<Gap> {
        self.gaps.sort_unstable_by(|one, other| one.0.total_cmp(&other.0));
        for (reach_m, one, other) in std::mem::take(&mut self.gaps) {
            let pair = [&self.sides[one as usize], &self.sides[other as usize]];
            let near = Near::of(pair[0], pair[1]);
            if self.parts.join(one, other, near.crosses(self.ends, pair)) {
                let [from, to] = near.points;
                let (reach_m, width_m) = (f64::from(reach_m), near.width_m);
                return Some(Gap { reach_m, width_m, between: [from, to] });
            }
        }
        None
    }
}

/// How near two sides lie.
#[derive(Debug, Clone, Copy)]
struct Near {
    width_m: f64,
    /// The nearest points of both.
    points: [Point; 2],
}

impl Near {
    fn of(one: &Side, other: &Side) -> Self {
        let ([a, b], [c, d]) = (one.ends, other.ends);
        let (of_a, of_b) = (c.cross(d, a), c.cross(d, b));
        if of_a * of_b < 0.0 && a.cross(b, c) * a.cross(b, d) < 0.0 {
            let meet = a.towards(b, of_a / (of_a - of_b));
            return Self { width_m: 0.0, points: [meet, meet] };
        }
        let ways = [
            [a, a.nearest_on(c, d)],
            [b, b.nearest_on(c, d)],
            [c.nearest_on(a, b), c],
            [d.nearest_on(a, b), d],
        ];
        let [first, rest @ ..] = ways.map(|points| (points[0].square_m2(points[1]), points));
        let least = rest.into_iter().fold(first, |best, one| if one.0 < best.0 { one } else { best });
        Self { width_m: least.0.sqrt(), points: least.1 }
    }

    /// Whether the way from the middle of one side to that of the other, by their nearest points, crosses the line between
    /// two points an odd number of times.
    fn crosses(&self, [from, to]: [Point; 2], [one, other]: [&Side; 2]) -> bool {
        let way = [one.middle(), self.points[0], self.points[1], other.middle()];
        let left = way.map(|at| from.cross(to, at) > 0.0);
        let crosses = |n: usize| {
            let (a, b) = (way[n], way[n + 1]);
            left[n] != left[n + 1] && (a.cross(b, from) > 0.0) != (a.cross(b, to) > 0.0)
        };
        (0..3).filter(|n| crosses(*n)).count() % 2 == 1
    }
}
