//! What lies where charts end or meet.
//!
//! Borders are found once, when an index is built: of coarser objects only what no finer source covers is
//! kept, and along every border of coverage the objects that begin just beyond it, or the absence of any, are
//! entered. Questions then need no knowledge of overlaps at all.

use super::coords::Spot;
use super::index::DepthIndex;
use super::object::{ChartObject, Role, Stored};
use super::tree::{NO_DATA, Run, Tree, cut};
use crate::coverage::Coverage;
use crate::grid::{Bounds, Vertex};
use std::collections::BTreeSet;

/// How far beyond a border its other side is told (units, about 3 cm).
const STEP: f64 = 3.0;

/// Runs by the tree that they go to.
#[derive(Debug, Default)]
pub(super) struct Runs {
    pub(super) danger: Vec<Run>,
    pub(super) quality: Vec<Run>,
    pub(super) overhead: Vec<Run>,
    pub(super) interest: Vec<Run>,
}

impl Runs {
    pub(super) fn add(&mut self, object: &ChartObject, id: u32, first: u32, count: u32) {
        match object.role {
            Role::Skin | Role::Danger => self.danger.extend(cut(id, first, count)),
            Role::Quality => self.quality.extend(cut(id, first, count)),
            Role::Overhead => self.overhead.extend(cut(id, first, count)),
            Role::Coverage | Role::Interest => {}
        }
        if object.interest {
            self.interest.extend(cut(id, first, count));
        }
    }
}

/// Cuts off what a better chart covers.
pub(super) fn best_scale_only(index: &mut DepthIndex, charts: &Coverage, runs: Vec<Run>) -> Vec<Run> {
    let coverage = tree_of(index, |object| object.role == Role::Coverage);
    let mut kept = Vec::with_capacity(runs.len());
    for run in runs {
        let source = index.objects[run.object as usize].source;
        let vertices = index.areas.vertices[run.first as usize..(run.first + run.count) as usize].to_vec();
        let bounds = Bounds::of(&vertices);
        if !charts.may_hide(source as usize, &bounds) {
            kept.push(run);
            continue;
        }
        let visible = |at: Spot| index.visit_at(at, |_, _| {}).is_none_or(|answering| answering >= source);
        if let [point] = vertices[..] {
            if visible(Spot::of_vertex(point)) {
                kept.push(run);
            }
            continue;
        }
        let mut pieces = Vec::new();
        for pair in vertices.windows(2) {
            let cuts = crossings(index, &coverage, pair[0], pair[1], |object| object.source < source);
            pieces.extend(split(pair[0], pair[1], &cuts).filter(|(a, b)| visible(halfway(*a, *b))));
        }
        for (a, b) in pieces {
            kept.push(push_piece(&mut index.areas.vertices, a, b, run.object));
        }
    }
    kept
}

/// Runs along all borders of coverage and of incomplete skins, for what lies just beyond.
pub(super) fn borders(index: &mut DepthIndex) -> Vec<Run> {
    let (doubtful, single) = doubtful_skins(index);
    let needed = index.sources.len() > 1 || doubtful.contains(&true);
    let all = if needed { tree_of(index, |object| object.role <= Role::Danger) } else { Tree::default() };
    let mut found: BTreeSet<(Vertex, Vertex, u32)> = BTreeSet::new();
    for (a, b, source) in border_segments(index, single) {
        // Where its own skin has gaps, a segment may lie by a gap in part only: its middle does not tell.
        let own = doubtful[source as usize];
        let cuts = crossings(index, &all, a, b, |object| {
            object.source != source || own && object.role == Role::Skin
        });
        for (a, b) in split(a, b, &cuts) {
            for at in beside(a, b).into_iter().flatten() {
                let mut skin = false;
                index.visit_at(at, |id, object| {
                    skin |= object.role == Role::Skin;
                    if object.source != source && matches!(object.role, Role::Skin | Role::Danger) {
                        found.insert((a, b, id));
                    }
                });
                if !skin {
                    found.insert((a, b, NO_DATA));
                }
            }
        }
    }
    let vertices = &mut index.areas.vertices;
    found.into_iter().map(|(a, b, object)| push_piece(vertices, a, b, object)).collect()
}

fn push_piece(vertices: &mut Vec<Vertex>, a: Vertex, b: Vertex, object: u32) -> Run {
    let first = vertices.len() as u32;
    vertices.extend([a, b]);
    Run { first, count: 2, object }
}

/// Segments beyond which another source, or nothing, may begin, with their own source; of skins `single` ones only.
fn border_segments(index: &DepthIndex, single: Vec<Segment>) -> Vec<Segment> {
    let mut borders = single;
    for area in &index.areas.list {
        let object = &index.objects[area.object as usize];
        if object.role == Role::Coverage {
            borders.extend(sides(index, *area).map(|(a, b, _)| (a, b, object.source)));
        }
    }
    borders.sort_unstable();
    borders.dedup();
    borders
}

/// Two ends, the lesser first, and the source.
type Segment = (Vertex, Vertex, u32);

/// Which sources have a skin that may not tile their coverage, and the sides of their skins that have no other area on
/// the other side. A skin tiles its coverage exactly where every side is there once in each direction, or is one of the
/// coverage's: sums of areas would not tell a gap from an overlap as large. Where borders are divided otherwise than
/// their neighbours', the skin counts as doubtful, which costs time at building and nothing else.
fn doubtful_skins(index: &DepthIndex) -> (Vec<bool>, Vec<Segment>) {
    let mut all: Vec<(u32, Vertex, Vertex, Role, i32)> = Vec::new();
    for area in &index.areas.list {
        let object = &index.objects[area.object as usize];
        if matches!(object.role, Role::Coverage | Role::Skin) {
            all.extend(sides(index, *area).map(|(a, b, sign)| (object.source, a, b, object.role, sign)));
        }
    }
    all.sort_unstable();
    let mut doubtful = vec![false; index.sources.len()];
    let mut single = Vec::new();
    for same in all.chunk_by(|one, next| (one.0, one.1, one.2) == (next.0, next.1, next.2)) {
        let net = |role: Role| same.iter().filter(|side| side.3 == role).map(|side| side.4).sum::<i32>();
        let (source, a, b, ..) = same[0];
        let (skin, coverage) = (net(Role::Skin), net(Role::Coverage));
        doubtful[source as usize] |= skin != coverage;
        if skin != 0 {
            single.push((a, b, source));
        }
    }
    single.retain(|(_, _, source)| doubtful[*source as usize]);
    (doubtful, single)
}

/// The sides of an area, the lesser end first: 1 where the area lies to the right of the way from there, else -1.
pub(super) fn sides(
    index: &DepthIndex,
    area: super::places::AreaEntry,
) -> impl Iterator<Item = (Vertex, Vertex, i32)> {
    let rings = index.areas.rings_of(area);
    let size = |ring: &super::ring::Ring| twice_area(ring.vertices(&index.areas.vertices));
    // The largest ring is the outer one, the others are its holes.
    let outer = (0..rings.len()).max_by_key(|at| size(&rings[*at]).abs());
    (0..rings.len()).flat_map(move |at| {
        let vertices = rings[at].vertices(&index.areas.vertices);
        let clockwise = size(&rings[at]) < 0;
        let onward = if clockwise == (outer == Some(at)) { 1 } else { -1 };
        vertices.windows(2).filter(|pair| pair[0] != pair[1]).map(move |pair| {
            if pair[0] < pair[1] { (pair[0], pair[1], onward) } else { (pair[1], pair[0], -onward) }
        })
    })
}

/// Runs along the borders of zones of confidence beyond which there is water that nobody assessed.
pub(super) fn unassessed(index: &mut DepthIndex) -> Vec<Run> {
    let mut borders: Vec<(Vertex, Vertex)> = Vec::new();
    for area in &index.areas.list {
        if index.objects[area.object as usize].role == Role::Quality {
            borders.extend(sides(index, *area).map(|(a, b, _)| (a, b)));
        }
    }
    if borders.is_empty() {
        return Vec::new();
    }
    borders.sort_unstable();
    borders.dedup();
    let all = tree_of(index, |object| matches!(object.role, Role::Coverage | Role::Skin | Role::Quality));
    let mut found = Vec::new();
    for (a, b) in borders {
        let cuts = crossings(index, &all, a, b, |_| true);
        for (a, b) in split(a, b, &cuts) {
            let mut sides = beside(a, b).into_iter().flatten();
            let open = sides.any(|at| {
                let (mut zone, mut water) = (false, false);
                index.visit_at(at, |_, object| {
                    zone |= object.role == Role::Quality;
                    water |= object.role == Role::Skin && object.stored != Stored::Land;
                });
                water && !zone
            });
            if open {
                found.push((a, b));
            }
        }
    }
    let vertices = &mut index.areas.vertices;
    found.into_iter().map(|(a, b)| push_piece(vertices, a, b, NO_DATA)).collect()
}

/// Places just beside the middle of a segment; none of one without length.
fn beside(a: Vertex, b: Vertex) -> Option<[Spot; 2]> {
    let middle = halfway(a, b);
    let (dx, dy) = (f64::from(b[0]) - f64::from(a[0]), f64::from(b[1]) - f64::from(a[1]));
    let length = dx.hypot(dy);
    let at = |side: f64| Spot { x: middle.x - dy / length * side, y: middle.y + dx / length * side };
    (length > 0.0).then(|| [at(-STEP), at(STEP)])
}

/// Twice the area of a ring, positive anticlockwise (square units).
fn twice_area(ring: &[Vertex]) -> i128 {
    let Some(first) = ring.first() else { return 0 };
    let relative = |at: &Vertex, axis: usize| i128::from(at[axis]) - i128::from(first[axis]);
    ring.windows(2)
        .map(|pair| {
            relative(&pair[0], 0) * relative(&pair[1], 1) - relative(&pair[1], 0) * relative(&pair[0], 1)
        })
        .sum()
}

fn tree_of(index: &DepthIndex, wanted: impl Fn(&ChartObject) -> bool) -> Tree {
    let mut runs = Vec::new();
    for area in &index.areas.list {
        if wanted(&index.objects[area.object as usize]) {
            for ring in index.areas.rings_of(*area) {
                runs.extend(cut(area.object, ring.first, ring.count));
            }
        }
    }
    Tree::build(runs, &index.areas.vertices, |_| 0)
}

/// Where along a segment (0 to 1) the borders in a tree cross it, in order.
fn crossings(
    index: &DepthIndex,
    tree: &Tree,
    a: Vertex,
    b: Vertex,
    wanted: impl Fn(&ChartObject) -> bool,
) -> Vec<f64> {
    let bounds = Bounds::of(&[a, b]);
    let mut cuts = Vec::new();
    tree.search(
        |node| node.bounds.overlaps(&bounds),
        |run| {
            if !wanted(&index.objects[run.object as usize]) {
                return;
            }
            let vertices = &index.areas.vertices[run.first as usize..(run.first + run.count) as usize];
            cuts.extend(vertices.windows(2).flat_map(|pair| meets(a, b, pair[0], pair[1])).flatten());
        },
    );
    cuts.retain(|t| *t > 0.0 && *t < 1.0);
    cuts.sort_by(f64::total_cmp);
    cuts.dedup();
    cuts
}

/// Where on a-b the segment c-d meets it: one place, or the two ends of a common stretch.
fn meets(a: Vertex, b: Vertex, c: Vertex, d: Vertex) -> [Option<f64>; 2] {
    let wide = |at: Vertex| [i128::from(at[0]), i128::from(at[1])];
    let ([ax, ay], [bx, by], [cx, cy], [dx, dy]) = (wide(a), wide(b), wide(c), wide(d));
    let (ux, uy, vx, vy) = (bx - ax, by - ay, dx - cx, dy - cy);
    let across = ux * vy - uy * vx;
    let (wx, wy) = (cx - ax, cy - ay);
    if across == 0 {
        if ux * wy - uy * wx != 0 {
            return [None, None];
        }
        let square = (ux * ux + uy * uy) as f64;
        let along = |px: i128, py: i128| Some(((px - ax) * ux + (py - ay) * uy) as f64 / square);
        return if square > 0.0 { [along(cx, cy), along(dx, dy)] } else { [None, None] };
    }
    let (t, s) = (wx * vy - wy * vx, wx * uy - wy * ux);
    let within = |value: i128| (value >= 0) == (across > 0) && value.abs() <= across.abs() || value == 0;
    if within(t) && within(s) { [Some(t as f64 / across as f64), None] } else { [None, None] }
}

/// The pieces of a segment between its cuts, rounded to units.
fn split(a: Vertex, b: Vertex, cuts: &[f64]) -> impl Iterator<Item = (Vertex, Vertex)> {
    let at = move |t: f64| {
        let on = |axis: usize| {
            let (from, to) = (f64::from(a[axis]), f64::from(b[axis]));
            // Between two i32 values.
            (from + (to - from) * t).round() as i32
        };
        [on(0), on(1)]
    };
    let mut ends: Vec<Vertex> = cuts.iter().map(|t| at(*t)).collect();
    ends.push(b);
    let mut from = a;
    ends.into_iter().map(move |to| (std::mem::replace(&mut from, to), to))
}

fn halfway(a: Vertex, b: Vertex) -> Spot {
    let (a, b) = (Spot::of_vertex(a), Spot::of_vertex(b));
    Spot { x: f64::midpoint(a.x, b.x), y: f64::midpoint(a.y, b.y) }
}
