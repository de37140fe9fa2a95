//! The borders at which charts end or meet.
//!
//! Borders are found once, when an index is built: of coarser objects only what no finer source covers is
//! kept, and along every border of coverage the objects that begin just beyond it, or the absence of any, are
//! entered. Questions then need no knowledge of overlaps at all. The seams of a chart depend on it and on the charts
//! whose boxes meet its own ([`meet`]), and on no other.

use super::coords::{Spot, TURN};
use super::object::{ChartObject, Role, Stored};
use super::piece::Piece;
use super::places::AreaEntry;
use super::ring::Ring;
use super::tree::{NO_DATA, Run, Tree, cut};
use crate::grid::{Bounds, Vertex};
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;
use std::sync::Arc;

/// How far beyond a border its other side is sampled (units, about 3 cm).
const STEP: f64 = 3.0;

/// Runs by the tree that they go to.
#[derive(Debug, Default)]
pub(super) struct Runs {
    pub(super) danger: Vec<Run>,
    pub(super) quality: Vec<Run>,
    pub(super) overhead: Vec<Run>,
    pub(super) interest: Vec<Run>,
    pub(super) restricted: Vec<Run>,
}

impl Runs {
    pub(super) fn add(&mut self, object: &ChartObject, id: u32, first: u32, count: u32) {
        match object.role {
            Role::Skin | Role::Danger => self.danger.extend(cut(id, first, count)),
            Role::Quality => self.quality.extend(cut(id, first, count)),
            Role::Overhead => self.overhead.extend(cut(id, first, count)),
            Role::Prohibited | Role::Restricted => self.restricted.extend(cut(id, first, count)),
            Role::Coverage | Role::Interest => {}
        }
        if object.interest {
            self.interest.extend(cut(id, first, count));
        }
    }
}

/// How far beyond its box a chart is asked for what lies there (units); more than [`STEP`].
const MARGIN: i64 = 16;

/// Whether the seams of charts with these boxes may depend on each other. ±180° is one meridian.
pub(super) fn meet(one: &Bounds, other: &Bounds) -> bool {
    let apart = |axis: usize, turn: i64| {
        i64::from(one.min[axis]) + turn > i64::from(other.max[axis]) + MARGIN
            || i64::from(other.min[axis]) > i64::from(one.max[axis]) + turn + MARGIN
    };
    let turn = TURN as i64;
    !apart(1, 0) && [0, turn, -turn].into_iter().any(|turn| !apart(0, turn))
}

/// A chart as its neighbours need it.
struct View {
    piece: Arc<Piece>,
    /// Borders of all its areas.
    outline: Tree,
    /// Boxes of what it covers.
    covered: Vec<Bounds>,
}

impl View {
    fn of(piece: Arc<Piece>) -> Self {
        let (mut runs, mut covered) = (Vec::new(), Vec::new());
        for area in &piece.areas.list {
            let rings = piece.areas.rings_of(*area);
            let vertices = |ring: &Ring| Bounds::of(ring.vertices(&piece.areas.vertices));
            if piece.objects[area.object as usize].role == Role::Coverage && !piece.supplement {
                let mut bounds = Bounds::EMPTY;
                for ring in rings {
                    bounds.add(vertices(ring));
                }
                covered.push(bounds);
            }
            runs.extend(rings.iter().flat_map(|ring| cut(area.object, ring.first, ring.count)));
        }
        let outline = Tree::build(runs, &piece.areas.vertices, |_| 0);
        Self { piece, outline, covered }
    }

    /// About how much memory it holds.
    fn bytes(&self) -> usize {
        self.piece.areas.vertices.len() * 24 + self.piece.objects.len() * 80 + 1_000
    }
}

/// All charts of a set with what gives their pieces; of those given it keeps the last ones, so many bytes of them.
pub(super) struct Around<F, E> {
    boxes: Vec<Bounds>,
    most_bytes: usize,
    load: F,
    views: RefCell<Views<E>>,
}

struct Views<E> {
    /// With when it was used last.
    kept: BTreeMap<usize, (Rc<View>, u64)>,
    bytes: usize,
    uses: u64,
    failed: Option<E>,
}

impl<E, F: Fn(usize) -> Result<Arc<Piece>, E>> Around<F, E> {
    /// Over charts with these boxes, the best first.
    pub(super) fn new(boxes: Vec<Bounds>, most_bytes: usize, load: F) -> Self {
        let views = Views { kept: BTreeMap::new(), bytes: 0, uses: 0, failed: None };
        Self { boxes, most_bytes, load, views: RefCell::new(views) }
    }

    /// The piece of a chart with its seams.
    ///
    /// # Errors
    /// When a piece is not given.
    pub(super) fn joined(&self, at: usize) -> Result<Piece, E> {
        let near =
            (0..self.boxes.len()).filter(|other| *other == at || meet(&self.boxes[at], &self.boxes[*other]));
        let seam = Seam { around: self, at, near: near.collect(), own: self.view(at) };
        let joined = seam.joined();
        let failed = self.views.borrow_mut().failed.take();
        failed.map_or(Ok(joined), Err)
    }

    /// A chart; an empty one, with a note, where it is not given.
    fn view(&self, at: usize) -> Rc<View> {
        let mut views = self.views.borrow_mut();
        views.uses += 1;
        let now = views.uses;
        if let Some((view, used)) = views.kept.get_mut(&at) {
            *used = now;
            return Rc::clone(view);
        }
        let piece = (self.load)(at).unwrap_or_else(|why| {
            views.failed = Some(why);
            Arc::default()
        });
        let view = Rc::new(View::of(piece));
        views.bytes += view.bytes();
        views.kept.insert(at, (Rc::clone(&view), now));
        while views.bytes > self.most_bytes && views.kept.len() > 1 {
            let oldest = views.kept.iter().min_by_key(|(_, (_, used))| *used).map(|(at, _)| *at);
            let gone = oldest.and_then(|oldest| views.kept.remove(&oldest));
            views.bytes -= gone.map_or(0, |(view, _)| view.bytes());
        }
        view
    }
}

/// One chart among those that it meets.
struct Seam<'a, F, E> {
    around: &'a Around<F, E>,
    at: usize,
    /// The charts that it meets and itself, the best first.
    near: Vec<usize>,
    own: Rc<View>,
}

impl<E, F: Fn(usize) -> Result<Arc<Piece>, E>> Seam<'_, F, E> {
    fn joined(&self) -> Piece {
        let mut piece = Piece::clone(&self.own.piece).own();
        let mut runs = Runs::default();
        for area in &piece.areas.list {
            for ring in piece.areas.rings_of(*area) {
                runs.add(&piece.objects[area.object as usize], area.object, ring.first, ring.count);
            }
        }
        for line in &piece.lines {
            runs.add(&piece.objects[line.object as usize], line.object, line.first, line.count);
        }
        let Runs { danger, quality, overhead, interest, restricted } = runs;
        let [mut danger, mut quality, overhead, mut restricted] =
            [danger, quality, overhead, restricted].map(|runs| self.best_scale_only(&mut piece, runs));
        let borders = self.borders(&mut piece);
        let closed = |run: &Run| piece.object(run.object).is_some_and(|one| one.restriction().is_some());
        let (entered, begun) = borders.into_iter().partition::<Vec<Run>, _>(closed);
        danger.extend(begun);
        restricted.extend(entered);
        quality.extend(self.unassessed(&mut piece));
        piece.trees = [danger, quality, overhead, interest, restricted]
            .map(|runs| Tree::build(runs, &piece.areas.vertices, |object| piece.stored(object).least_mm()));
        piece
    }

    /// Cuts off what a better chart covers.
    fn best_scale_only(&self, piece: &mut Piece, runs: Vec<Run>) -> Vec<Run> {
        if piece.supplement || self.near.first() == Some(&self.at) {
            return runs;
        }
        let mut kept = Vec::with_capacity(runs.len());
        for run in runs {
            let vertices = piece.vertices(&run).to_vec();
            let bounds = Bounds::of(&vertices);
            if !self.may_hide(&bounds) {
                kept.push(run);
                continue;
            }
            if let [point] = vertices[..] {
                if self.visible(Spot::of_vertex(point)) {
                    kept.push(run);
                }
                continue;
            }
            for pair in vertices.windows(2) {
                let better =
                    |chart: usize, object: &ChartObject| chart < self.at && object.role == Role::Coverage;
                let cuts = self.crossings(pair[0], pair[1], better);
                let parts = split(pair[0], pair[1], &cuts).filter(|(a, b)| self.visible(halfway(*a, *b)));
                for (a, b) in parts {
                    kept.push(push_piece(&mut piece.areas.vertices, a, b, run.object));
                }
            }
        }
        kept
    }

    /// Charts whose boxes meet a box.
    fn meeting(&self, bounds: Bounds) -> impl Iterator<Item = (usize, Rc<View>)> {
        let here = self.near.iter().filter(move |chart| self.around.boxes[**chart].overlaps(&bounds));
        here.map(|chart| (*chart, self.around.view(*chart)))
    }

    /// Whether a better chart may cover part of a box.
    fn may_hide(&self, bounds: &Bounds) -> bool {
        let better = self.meeting(*bounds).take_while(|(chart, _)| *chart < self.at);
        better.into_iter().any(|(_, view)| view.covered.iter().any(|one| one.overlaps(bounds)))
    }

    fn visible(&self, at: Spot) -> bool {
        self.visit_at(at, |_, _, _| {}).is_none_or(|answering| answering >= self.at)
    }

    /// Visits what is at a point, with the chart and the number there; gives the chart that answers.
    fn visit_at(&self, at: Spot, mut visit: impl FnMut(usize, u32, &ChartObject)) -> Option<usize> {
        let at = at.wrapped();
        let mut here = self.near.iter().copied().filter(|chart| self.around.boxes[*chart].holds(at));
        here.find(|chart| {
            let view = self.around.view(*chart);
            view.piece.visit_at(at, |id, object| visit(*chart, id, object))
        })
    }

    /// Where along a segment (0 to 1) the borders of areas cross it, in order.
    fn crossings(&self, a: Vertex, b: Vertex, wanted: impl Fn(usize, &ChartObject) -> bool) -> Vec<f64> {
        let bounds = Bounds::of(&[a, b]);
        let mut cuts = Vec::new();
        for (chart, view) in self.meeting(bounds) {
            let visit = |run: &Run| {
                if wanted(chart, &view.piece.objects[run.object as usize]) {
                    let pairs = view.piece.vertices(run).windows(2);
                    cuts.extend(pairs.flat_map(|pair| meets(a, b, pair[0], pair[1])).flatten());
                }
            };
            view.outline.search(|node| node.bounds.overlaps(&bounds), visit);
        }
        cuts.retain(|t| *t > 0.0 && *t < 1.0);
        cuts.sort_by(f64::total_cmp);
        cuts.dedup();
        cuts
    }

    /// Runs along the border of coverage and of an incomplete skin, for what lies just beyond.
    fn borders(&self, piece: &mut Piece) -> Vec<Run> {
        let (doubtful, single) = doubtful_skin(piece);
        // Nothing is the last.
        let nothing = (usize::MAX, NO_DATA);
        let mut found: BTreeSet<(Vertex, Vertex, (usize, u32))> = BTreeSet::new();
        let mut foreign: BTreeMap<(usize, u32), ChartObject> = BTreeMap::new();
        for (a, b) in border_segments(piece, single) {
            // Where its own skin has gaps, only a part of a segment may border a gap: its middle is not enough.
            let cuts = self.crossings(a, b, |chart, object| {
                (object.role <= Role::Danger || object.restriction().is_some())
                    && (chart != self.at || doubtful && object.role == Role::Skin)
            });
            for (a, b) in split(a, b, &cuts) {
                for at in beside(a, b).into_iter().flatten() {
                    let mut skin = false;
                    self.visit_at(at, |chart, id, object| {
                        skin |= object.role == Role::Skin;
                        let counts = matches!(object.role, Role::Skin | Role::Danger)
                            || object.restriction().is_some();
                        if chart != self.at && counts {
                            found.insert((a, b, (chart, id)));
                            foreign.entry((chart, id)).or_insert_with(|| object.clone());
                        }
                    });
                    if !skin {
                        found.insert((a, b, nothing));
                    }
                }
            }
        }
        let numbers = self.adopt(piece, foreign);
        let vertices = &mut piece.areas.vertices;
        let number = |object: &(usize, u32)| numbers.get(object).copied().unwrap_or(NO_DATA);
        found.into_iter().map(|(a, b, object)| push_piece(vertices, a, b, number(&object))).collect()
    }

    /// Takes objects of other charts in; gives their numbers.
    fn adopt(
        &self,
        piece: &mut Piece,
        foreign: BTreeMap<(usize, u32), ChartObject>,
    ) -> BTreeMap<(usize, u32), u32> {
        let mut numbers = BTreeMap::new();
        let mut last = None;
        for ((chart, id), object) in foreign {
            if last != Some(chart) {
                piece.charts.push(self.around.view(chart).piece.charts.first().cloned().unwrap_or_default());
                last = Some(chart);
            }
            numbers.insert((chart, id), piece.objects.len() as u32);
            piece.objects.push(ChartObject { source: piece.charts.len() as u32 - 1, ..object });
        }
        numbers
    }

    /// Runs along the borders of zones of confidence beyond which there is unassessed water.
    fn unassessed(&self, piece: &mut Piece) -> Vec<Run> {
        let mut borders: Vec<(Vertex, Vertex)> = Vec::new();
        for area in &piece.areas.list {
            if piece.objects[area.object as usize].role == Role::Quality {
                borders.extend(sides(piece, *area).map(|(a, b, _)| (a, b)));
            }
        }
        borders.sort_unstable();
        borders.dedup();
        let mut found = Vec::new();
        for (a, b) in borders {
            let cuts = self.crossings(a, b, |_, object| {
                matches!(object.role, Role::Coverage | Role::Skin | Role::Quality)
            });
            for (a, b) in split(a, b, &cuts) {
                let mut sides = beside(a, b).into_iter().flatten();
                let open = sides.any(|at| {
                    let (mut zone, mut water) = (false, false);
                    self.visit_at(at, |_, _, object| {
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
        let vertices = &mut piece.areas.vertices;
        found.into_iter().map(|(a, b)| push_piece(vertices, a, b, NO_DATA)).collect()
    }
}

fn push_piece(vertices: &mut Vec<Vertex>, a: Vertex, b: Vertex, object: u32) -> Run {
    let first = vertices.len() as u32;
    vertices.extend([a, b]);
    Run { first, count: 2, object }
}

/// Two ends, the lesser first.
type Segment = (Vertex, Vertex);

/// Segments beyond which another source, or nothing, may begin; of the skin `single` ones only.
fn border_segments(piece: &Piece, single: Vec<Segment>) -> Vec<Segment> {
    let mut borders = single;
    for area in &piece.areas.list {
        if piece.objects[area.object as usize].role == Role::Coverage {
            borders.extend(sides(piece, *area).map(|(a, b, _)| (a, b)));
        }
    }
    borders.sort_unstable();
    borders.dedup();
    borders
}

/// Whether a skin may not tile what its chart covers, and then the sides of it that have no other area on the other
/// side. A skin tiles the coverage exactly where every side is there once in each direction, or is one of the
/// coverage's: sums of areas would not distinguish a gap from an overlap as large. Where borders are divided otherwise than
/// their neighbours', the skin counts as doubtful, which costs time at building and nothing else.
fn doubtful_skin(piece: &Piece) -> (bool, Vec<Segment>) {
    let mut all: Vec<(Vertex, Vertex, Role, i32)> = Vec::new();
    for area in &piece.areas.list {
        let role = piece.objects[area.object as usize].role;
        if matches!(role, Role::Coverage | Role::Skin) {
            all.extend(sides(piece, *area).map(|(a, b, sign)| (a, b, role, sign)));
        }
    }
    all.sort_unstable();
    let mut doubtful = false;
    let mut single = Vec::new();
    for same in all.chunk_by(|one, next| (one.0, one.1) == (next.0, next.1)) {
        let net = |role: Role| same.iter().filter(|side| side.2 == role).map(|side| side.3).sum::<i32>();
        let (skin, coverage) = (net(Role::Skin), net(Role::Coverage));
        doubtful |= skin != coverage;
        if skin != 0 {
            single.push((same[0].0, same[0].1));
        }
    }
    if !doubtful {
        single.clear();
    }
    (doubtful, single)
}

/// The sides of an area, the lesser end first: 1 where the area lies to the right of the way from there, else -1.
pub(super) fn sides(piece: &Piece, area: AreaEntry) -> impl Iterator<Item = (Vertex, Vertex, i32)> {
    let rings = piece.areas.rings_of(area);
    let size = |ring: &Ring| twice_area(ring.vertices(&piece.areas.vertices));
    // The largest ring is the outer one, the others are its holes.
    let outer = (0..rings.len()).max_by_key(|at| size(&rings[*at]).abs());
    (0..rings.len()).flat_map(move |at| {
        let vertices = rings[at].vertices(&piece.areas.vertices);
        let clockwise = size(&rings[at]) < 0;
        let onward = if clockwise == (outer == Some(at)) { 1 } else { -1 };
        vertices.windows(2).filter(|pair| pair[0] != pair[1]).map(move |pair| {
            if pair[0] < pair[1] { (pair[0], pair[1], onward) } else { (pair[1], pair[0], -onward) }
        })
    })
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
pub(super) fn twice_area(ring: &[Vertex]) -> i128 {
    let Some(first) = ring.first() else { return 0 };
    let relative = |at: &Vertex, axis: usize| i128::from(at[axis]) - i128::from(first[axis]);
    ring.windows(2)
        .map(|pair| {
            relative(&pair[0], 0) * relative(&pair[1], 1) - relative(&pair[1], 0) * relative(&pair[0], 1)
        })
        .sum()
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
