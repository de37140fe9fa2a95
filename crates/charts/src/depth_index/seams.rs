//! What lies where charts end or meet.
//!
//! Borders are found once, when an index is built: of coarser objects only what no finer source covers is
//! kept, and along every border of coverage the objects that begin just beyond it, or the absence of any, are
//! entered. Questions then need no knowledge of overlaps at all.

use super::build::cut;
use super::coords::{Bounds, Spot, Vertex};
use super::index::DepthIndex;
use super::object::{ChartObject, Role};
use super::tree::{NO_DATA, Run, Tree};
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

/// Cuts off what a finer source covers.
pub(super) fn best_scale_only(index: &mut DepthIndex, runs: Vec<Run>) -> Vec<Run> {
    let limits: Vec<(u32, Bounds)> = coverage_bounds(index);
    let coverage = tree_of(index, |object| object.role == Role::Coverage);
    let mut kept = Vec::with_capacity(runs.len());
    for run in runs {
        let source = index.objects[run.object as usize].source;
        let vertices = index.areas.vertices[run.first as usize..(run.first + run.count) as usize].to_vec();
        let bounds = Bounds::of(&vertices);
        let hidden = !index.sources[source as usize].supplement
            && limits.iter().any(|(finer, limit)| *finer < source && limit.overlaps(&bounds));
        if !hidden {
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
    let incomplete = incomplete_skins(index);
    let needed = index.sources.len() > 1 || incomplete.contains(&true);
    let all = if needed { tree_of(index, |object| object.role <= Role::Danger) } else { Tree::default() };
    let mut found: BTreeSet<(Vertex, Vertex, u32)> = BTreeSet::new();
    for (a, b, source) in border_segments(index, &incomplete) {
        // Where its own skin has gaps, a segment may lie by a gap in part only: its middle does not tell.
        let own = incomplete[source as usize];
        let cuts = crossings(index, &all, a, b, |object| {
            object.source != source || own && object.role == Role::Skin
        });
        for (a, b) in split(a, b, &cuts) {
            let middle = halfway(a, b);
            let (dx, dy) = (f64::from(b[0]) - f64::from(a[0]), f64::from(b[1]) - f64::from(a[1]));
            let length = dx.hypot(dy);
            if length == 0.0 {
                continue;
            }
            for side in [-STEP, STEP] {
                let at = Spot { x: middle.x - dy / length * side, y: middle.y + dx / length * side };
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

/// Segments beyond which another source, or nothing, may begin, with their own source.
fn border_segments(index: &DepthIndex, incomplete: &[bool]) -> Vec<(Vertex, Vertex, u32)> {
    let (mut borders, mut skins) = (Vec::new(), Vec::new());
    for area in &index.areas.list {
        let object = &index.objects[area.object as usize];
        let list = match object.role {
            Role::Coverage => &mut borders,
            Role::Skin if incomplete[object.source as usize] => &mut skins,
            Role::Skin | Role::Danger | Role::Quality | Role::Overhead | Role::Interest => continue,
        };
        for ring in index.areas.rings_of(*area) {
            for pair in ring.vertices(&index.areas.vertices).windows(2) {
                list.push((pair[0].min(pair[1]), pair[0].max(pair[1]), object.source));
            }
        }
    }
    // What two areas of a skin share has skin on both sides.
    skins.sort_unstable();
    let single = skins.chunk_by(|a, b| a == b).filter(|group| group.len() == 1);
    borders.extend(single.map(|group| group[0]));
    borders.sort_unstable();
    borders.dedup();
    borders
}

/// Whether a source's skin does not add up to its coverage, exactly, in whole units.
fn incomplete_skins(index: &DepthIndex) -> Vec<bool> {
    let mut sums = vec![0_i128; index.sources.len()];
    for area in &index.areas.list {
        let object = &index.objects[area.object as usize];
        let sign = match object.role {
            Role::Coverage => -1,
            Role::Skin => 1,
            Role::Danger | Role::Quality | Role::Overhead | Role::Interest => continue,
        };
        let rings = index.areas.rings_of(*area).iter();
        let mut areas: Vec<i128> =
            rings.map(|ring| twice_area(ring.vertices(&index.areas.vertices))).collect();
        areas.sort_unstable_by(|a, b| b.cmp(a));
        // The largest ring is the outer one, the others are its holes.
        let net = areas.iter().skip(1).fold(areas.first().copied().unwrap_or(0), |net, hole| net - hole);
        sums[object.source as usize] += sign * net;
    }
    sums.into_iter().map(|sum| sum != 0).collect()
}

fn twice_area(ring: &[Vertex]) -> i128 {
    let Some(first) = ring.first() else { return 0 };
    let relative = |at: &Vertex, axis: usize| i128::from(at[axis]) - i128::from(first[axis]);
    let sum: i128 = ring
        .windows(2)
        .map(|pair| {
            relative(&pair[0], 0) * relative(&pair[1], 1) - relative(&pair[1], 0) * relative(&pair[0], 1)
        })
        .sum();
    sum.abs()
}

fn coverage_bounds(index: &DepthIndex) -> Vec<(u32, Bounds)> {
    let of_area = |area: &super::places::AreaEntry| {
        let object = &index.objects[area.object as usize];
        let rings = index.areas.rings_of(*area).iter();
        let mut bounds = Bounds::EMPTY;
        rings.for_each(|ring| bounds.add(Bounds::of(ring.vertices(&index.areas.vertices))));
        (object.role == Role::Coverage).then_some((object.source, bounds))
    };
    index.areas.list.iter().filter_map(of_area).collect()
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
