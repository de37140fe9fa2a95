//! What a vessel must keep clear of, as lines: for route planning.

use super::demand::{Demand, ZoneError};
use super::index::DepthIndex;
use super::object::{ChartObject, Role, Stored};
use super::piece::{Kind, Piece};
use super::restricted::EntryRule;
use super::seams;
use super::tree::Run;
use crate::grid::{Bounds, PER_DEGREE, Vertex};

/// Lines and points that corridors are checked against.
///
/// [`DepthIndex::shallowest_along`] calls a corridor navigable if none of these comes within its half width and its
/// start lies in navigable water. So a connected piece of water that keeps this distance from all of them is navigable
/// everywhere or nowhere.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Barriers {
    /// Polylines; a single vertex is a point.
    pub lines: Vec<Vec<Vertex>>,
    /// By how much every half width grows where errors of the chart are allowed for (m): the worst zone of confidence
    /// of the whole chart set is taken, so ways may keep farther off than a corridor must.
    pub wider_m: f64,
}

/// From when on a line is in a vessel's way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Closes {
    /// Whatever depth is needed.
    Always,
    /// Whatever depth is needed, by the rule of entry.
    ByRule,
    /// As soon as more depth is needed than this (m).
    DeeperThan(f64),
}

/// A line that corridors are checked against, and from when on.
#[derive(Debug, Clone, PartialEq)]
pub struct ClosingLine {
    /// A polyline; a single vertex is a point.
    pub vertices: Vec<Vertex>,
    /// From when on.
    pub closes: Closes,
}

/// A box on the globe; where `west_deg` is greater than `east_deg` it reaches over ±180°.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GeoBox {
    /// Least longitude (degrees).
    pub west_deg: f64,
    /// Least latitude (degrees).
    pub south_deg: f64,
    /// Greatest longitude (degrees).
    pub east_deg: f64,
    /// Greatest latitude (degrees).
    pub north_deg: f64,
}

impl GeoBox {
    /// In units, one box or two.
    fn bounds(&self) -> Vec<Bounds> {
        // Casts saturate at ±180° and ±90°, which are within i32.
        let unit = |deg: f64, most: f64| (deg.clamp(-most, most) * PER_DEGREE).round() as i32;
        let of = |west: f64, east: f64| Bounds {
            min: [unit(west, 180.0), unit(self.south_deg, 90.0)],
            max: [unit(east, 180.0), unit(self.north_deg, 90.0)],
        };
        if self.west_deg <= self.east_deg {
            vec![of(self.west_deg, self.east_deg)]
        } else {
            vec![of(self.west_deg, 180.0), of(-180.0, self.east_deg)]
        }
    }
}

/// The input of one query for barriers.
struct Wanted<'a> {
    demand: &'a Demand,
    error: Option<ZoneError>,
    within: Vec<Bounds>,
}

impl DepthIndex {
    /// What charts cover, as a box; `None` without charts.
    pub fn extent(&self) -> Option<GeoBox> {
        let mut all = Bounds::EMPTY;
        self.directory.entries.iter().for_each(|entry| all.add(entry.danger));
        if all.min[0] > all.max[0] {
            return None;
        }
        let deg = |unit: i32| f64::from(unit) / PER_DEGREE;
        Some(GeoBox {
            west_deg: deg(all.min[0]),
            south_deg: deg(all.min[1]),
            east_deg: deg(all.max[0]),
            north_deg: deg(all.max[1]),
        })
    }

    /// Vertices of all charts that come into a box, whether these do or not: how much a box may ask for, told without
    /// reading any of it.
    pub fn vertices_of_charts_in(&self, within: &GeoBox) -> usize {
        let within = within.bounds();
        let meets = |bounds: &Bounds| within.iter().any(|part| part.overlaps(bounds));
        let charts = self.charts_in(|node| meets(&node.bounds));
        charts.into_iter().map(|chart| self.directory.entries[chart].vertices as usize).sum()
    }

    /// All that a vessel of this demand must keep clear of and that comes into a box. Borders between two areas that
    /// are both closed to it are left out.
    pub fn barriers(&self, demand: &Demand, within: &GeoBox) -> Barriers {
        let (error, wider_m) = self.worst_error(demand);
        let wanted = Wanted { demand, error, within: within.bounds() };
        let charts = self.charts_in(|node| wanted.meets(&node.bounds));
        let mut sides: Vec<(Side, bool)> = Vec::new();
        for chart in &charts {
            wanted.closed_sides(&self.piece(*chart), &mut sides);
        }
        let inner = inner_sides(sides);
        let mut lines = Vec::new();
        for chart in charts {
            let piece = self.piece(chart);
            let mut runs = wanted.runs(&piece, Kind::Danger, |stored| wanted.closed(stored));
            if demand.air_draught_m.is_some() {
                let too_low = |stored: Stored| !demand.fits_under(stored.clearance_m());
                runs.extend(wanted.runs(&piece, Kind::Overhead, too_low));
            }
            runs.extend(wanted.refused_entry(&piece));
            for chain in chains(runs) {
                outer_parts(piece.vertices(&chain), &inner, &mut lines);
            }
        }
        Barriers { lines, wider_m }
    }

    /// All that [`Self::barriers`] is about, each with the depth from which on it is in the way, and with the borders
    /// between areas that are both closed: for a caller that asks what a smaller demand would open. The second is
    /// [`Barriers::wider_m`].
    pub fn closing_lines(&self, demand: &Demand, within: &GeoBox) -> (Vec<ClosingLine>, f64) {
        let (error, wider_m) = self.worst_error(demand);
        let wanted = Wanted { demand, error, within: within.bounds() };
        let needing_nothing = Demand { draught_m: 0.0, squat_m: 0.0, reserve_m: 0.0, ..*demand };
        let mut lines = Vec::new();
        for chart in self.charts_in(|node| wanted.meets(&node.bounds)) {
            let piece = self.piece(chart);
            let mut add = |runs: Vec<Run>, closes: &dyn Fn(&Run) -> Closes| {
                lines.extend(chains(runs).iter().map(|chain| ClosingLine {
                    vertices: piece.vertices(chain).to_vec(),
                    closes: closes(chain),
                }));
            };
            add(wanted.runs(&piece, Kind::Danger, |stored| wanted.closed(stored)), &|chain| {
                let left_m = needing_nothing.judge(piece.stored(chain.object).water(), error).1;
                left_m.map_or(Closes::Always, Closes::DeeperThan)
            });
            if demand.air_draught_m.is_some() {
                let too_low = |stored: Stored| !demand.fits_under(stored.clearance_m());
                add(wanted.runs(&piece, Kind::Overhead, too_low), &|_| Closes::Always);
            }
            add(wanted.refused_entry(&piece), &|_| Closes::ByRule);
        }
        (lines, wider_m)
    }

    /// The errors of the worst zone of confidence that there is, and by how much they widen a corridor (m).
    fn worst_error(&self, demand: &Demand) -> (Option<ZoneError>, f64) {
        let Some((errors, widen)) = demand.trust.errors() else { return (None, 0.0) };
        let entries = &self.directory.entries;
        let unassessed = entries.iter().any(|entry| entry.unassessed.is_some());
        let zones = entries.iter().filter_map(|entry| entry.worst_zone);
        let worst = if unassessed { 6 } else { zones.max().unwrap_or(1) };
        let error = errors[usize::from(worst.clamp(1, 6)) - 1];
        (Some(error), if widen { error.horizontal_m } else { 0.0 })
    }
}

impl Wanted<'_> {
    fn meets(&self, bounds: &Bounds) -> bool {
        self.within.iter().any(|one| one.overlaps(bounds))
    }

    /// Whether what is in the danger tree is closed to the vessel.
    fn closed(&self, stored: Stored) -> bool {
        !self.demand.judge(stored.water(), self.error).0
    }

    fn runs(&self, piece: &Piece, kind: Kind, closed: impl Fn(Stored) -> bool) -> Vec<Run> {
        let enough_mm = self.demand.enough_mm(self.error);
        let mut runs = Vec::new();
        piece.tree(kind).search(
            |node| node.least_mm <= enough_mm && self.meets(&node.bounds),
            |run| {
                if closed(piece.stored(run.object)) {
                    runs.push(*run);
                }
            },
        );
        runs
    }

    /// Borders of areas that the vessel may not enter.
    fn refused_entry(&self, piece: &Piece) -> Vec<Run> {
        let refused = |restriction| self.demand.entry.of(restriction) == EntryRule::Refuse;
        let mut runs = Vec::new();
        piece.tree(Kind::Restricted).search(
            |node| self.demand.entry.refuse_any() && self.meets(&node.bounds),
            |run| {
                if piece.object(run.object).and_then(ChartObject::restriction).is_some_and(refused) {
                    runs.push(*run);
                }
            },
        );
        runs
    }

    /// Adds the sides of closed areas of a skin, and whether the area lies to the right.
    fn closed_sides(&self, piece: &Piece, sides: &mut Vec<(Side, bool)>) {
        for area in &piece.areas.list {
            let object = &piece.objects[area.object as usize];
            if object.role == Role::Skin && self.closed(object.stored) {
                let near = seams::sides(piece, *area).filter(|(a, b, _)| self.meets(&Bounds::of([a, b])));
                sides.extend(near.map(|(a, b, hand)| ((a, b), hand > 0)));
            }
        }
    }
}

/// Sides with closed areas to the left and to the right, in order: no corridor reaches them without touching others
/// first.
fn inner_sides(mut sides: Vec<(Side, bool)>) -> Vec<Side> {
    sides.sort_unstable();
    sides.dedup();
    // What is left twice has both hands.
    sides.windows(2).filter(|pair| pair[0].0 == pair[1].0).map(|pair| pair[0].0).collect()
}

/// Two ends, the lesser first.
type Side = (Vertex, Vertex);

fn side(a: Vertex, b: Vertex) -> Side {
    if a <= b { (a, b) } else { (b, a) }
}

/// Puts runs together again that were cut from one line.
fn chains(mut runs: Vec<Run>) -> Vec<Run> {
    runs.sort_unstable_by_key(|run| (run.first, run.object));
    let mut chains: Vec<Run> = Vec::new();
    for run in runs {
        match chains.last_mut() {
            Some(last)
                if last.object == run.object
                    && last.first + last.count - 1 == run.first
                    && last.count > 1 =>
            {
                last.count += run.count - 1;
            }
            Some(last) if *last == run => {}
            _ => chains.push(run),
        }
    }
    chains
}

/// The stretches of a line that are not inner sides.
fn outer_parts(vertices: &[Vertex], inner: &[Side], lines: &mut Vec<Vec<Vertex>>) {
    if let [point] = vertices {
        lines.push(vec![*point]);
        return;
    }
    let mut line: Vec<Vertex> = Vec::new();
    for pair in vertices.windows(2) {
        if inner.binary_search(&side(pair[0], pair[1])).is_ok() {
            if line.len() > 1 {
                lines.push(std::mem::take(&mut line));
            }
            line.clear();
            continue;
        }
        if line.is_empty() {
            line.push(pair[0]);
        }
        line.push(pair[1]);
    }
    if line.len() > 1 {
        lines.push(line);
    }
}
