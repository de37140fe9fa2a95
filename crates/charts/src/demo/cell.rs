//! Makes one cell: samples the sea, builds the areas, and adds the objects.

use super::contour::Grid;
use super::faces::{BorderNode, Content, Net, Part, Run};
use super::noise::unit;
use super::objects::{Attributes, DRAWN, DREDGED, MARKS, Mark, PONTOONS};
use super::sea::{BASIN_DEPTH_M, BREAKWATERS, Sea};
use super::{Extent, NOT_FOR_NAVIGATION, degrees};
use crate::s57::write::{CellDraft, FeatureDraft, FeatureRef, Records, VectorRef, VectorUse};
use crate::s57::{AttributeCode, LinkRole, ObjectClass, Sounding};

/// Depth of the coastline: mean high water springs stands so far above the datum of depths (m).
pub(super) const COAST_M: f64 = -2.0;

/// Lays the cell of an extent.
pub(super) fn lay(extent: &Extent, sea: &Sea) -> CellDraft {
    let grid = sample(extent, sea);
    let [west, south] = extent.south_west;
    let north_east = grid.point(grid.size[0] - 1, grid.size[1] - 1);
    let made = made_lines(extent);
    let band = extent.levels.iter().filter(|level| grid.depth_m(0, 0) >= **level).count();
    let net = Net::weave([[west, south], north_east], grid.contours(extent.levels), &made, band);
    let mut draft = CellDraft::new(extent.name, extent.band, extent.scale);
    NOT_FOR_NAVIGATION.clone_into(&mut draft.id.comment);
    NOT_FOR_NAVIGATION.clone_into(&mut draft.parameters.comment);
    let mut layer = Layer { records: &mut draft.records, extent, sea };
    let laid = layer.net(&net);
    layer.meta(&laid);
    layer.skin(&net, &laid);
    layer.contours(&net, &laid);
    layer.soundings(&grid);
    layer.rocks(&grid);
    layer.objects();
    draft
}

/// The sea at the cell's grid. A coarse grid takes the shallowest of what lies about each point: to leave a
/// skerry out is worse than to draw it too large.
fn sample(extent: &Extent, sea: &Sea) -> Grid {
    let about = extent.step_m / 2.0;
    let offsets: &[f64] = if extent.fine() { &[0.0] } else { &[-0.5, 0.0, 0.5] };
    let depth = |[x, y]: [f64; 2]| {
        let all =
            offsets.iter().flat_map(|dx| offsets.iter().map(move |dy| [x + dx * about, y + dy * about]));
        all.map(|at| -sea.height_m(at)).fold(f64::INFINITY, f64::min)
    };
    Grid::sample(extent.south_west, extent.step_m, extent.size, extent.levels, depth)
}

/// Lines that people made: the dredged area and the pontoons in it.
fn made_lines(extent: &Extent) -> Vec<Vec<[f64; 2]>> {
    let ring = |[west, south, east, north]: [f64; 4]| {
        vec![[west, south], [east, south], [east, north], [west, north]]
    };
    if extent.fine() { [DREDGED].into_iter().chain(PONTOONS).map(ring).collect() } else { Vec::new() }
}

/// The edges of a net.
struct Laid {
    lines: Vec<VectorRef>,
    border: Vec<VectorRef>,
}

impl Laid {
    fn edge(&self, (part, backwards): Run) -> VectorUse {
        let edge = match part {
            Part::Line(line) => self.lines[line].forward(),
            Part::Border(node) => self.border[node].forward().data_limit(),
        };
        if backwards { edge.turned() } else { edge }
    }

    /// S-57 has exteriors clockwise and holes anticlockwise: all rings of the net are turned.
    fn area(&self, outer: &[Run], holes: &[Run]) -> Vec<VectorUse> {
        let outer = outer.iter().rev().map(|run| self.edge(*run).turned());
        let holes = holes.iter().map(|run| self.edge(*run).turned().interior());
        outer.chain(holes).collect()
    }
}

struct Layer<'a> {
    records: &'a mut Records,
    extent: &'a Extent,
    sea: &'a Sea,
}

impl Layer<'_> {
    fn net(&mut self, net: &Net) -> Laid {
        let nodes: Vec<VectorRef> =
            net.border.iter().map(|node| self.records.connected_node(degrees(node.at))).collect();
        let next = |at: usize| nodes[(at + 1) % nodes.len()];
        let border = (0..nodes.len()).map(|at| self.records.edge(nodes[at], next(at), &[])).collect();
        let end = |line, starts| net.border.iter().position(|node: &BorderNode| node.ends(line, starts));
        let mut lines = Vec::new();
        for (index, line) in net.lines.iter().enumerate() {
            let between: Vec<_> = line.points.iter().map(|at| degrees(*at)).collect();
            lines.push(if let (Some(from), Some(to)) = (end(index, true), end(index, false)) {
                self.records.edge(nodes[from], nodes[to], &between[1..between.len() - 1])
            } else {
                let node = self.records.connected_node(between[0]);
                self.records.edge(node, node, &between[1..])
            });
        }
        Laid { lines, border }
    }

    fn meta(&mut self, laid: &Laid) {
        let whole: Vec<Run> = (0..laid.border.len()).map(|node| (Part::Border(node), false)).collect();
        let ring = laid.area(&whole, &[]);
        let (told, zone) = (("INFORM", NOT_FOR_NAVIGATION), ("CATZOC", self.extent.zone));
        let mut meta = |class: &str, attributes: &[(&str, &str)]| {
            self.records.feature(with(FeatureDraft::area(class_of(class), &ring), attributes));
        };
        meta("M_COVR", &[("CATCOV", "1"), told]);
        meta("M_QUAL", &[zone, told]);
        meta("M_NSYS", &[("MARSYS", "1")]);
    }

    fn skin(&mut self, net: &Net, laid: &Laid) {
        let levels = self.extent.levels;
        for face in &net.faces {
            let (class, depths) = match face.content {
                Content::Band(0) => (ObjectClass::LNDARE, None),
                Content::Band(band) => {
                    let deepest = levels.get(band).copied().unwrap_or(levels[band - 1] * 2.0);
                    (ObjectClass::DEPARE, Some((levels[band - 1], deepest)))
                }
                Content::Made(0) => (ObjectClass::DRGARE, Some((BASIN_DEPTH_M, BASIN_DEPTH_M))),
                Content::Made(_) => (ObjectClass::PONTON, None),
            };
            let mut area = FeatureDraft::area(class, &laid.area(&face.outer, &face.holes));
            if let Some((least, greatest)) = depths {
                area = area.with(AttributeCode::DRVAL1, metres(least));
                area = area.with(AttributeCode::DRVAL2, metres(greatest));
            }
            self.records.feature(area);
        }
    }

    fn contours(&mut self, net: &Net, laid: &Laid) {
        let contours = net.lines.len() - made_lines(self.extent).len();
        for (line, edge) in net.lines[..contours].iter().zip(&laid.lines) {
            let depth_m = self.extent.levels[line.level];
            let edges = [edge.forward()];
            self.records.feature(if line.level == 0 {
                FeatureDraft::line(ObjectClass::COALNE, &edges)
            } else {
                FeatureDraft::line(ObjectClass::DEPCNT, &edges).with(AttributeCode::VALDCO, metres(depth_m))
            });
        }
    }

    /// One sounding in each block of the grid, where it is not too close to land.
    fn soundings(&mut self, grid: &Grid) {
        let block = self.extent.block;
        let mut soundings = Vec::new();
        for (column, row) in blocks(grid.size, block) {
            let random = |salt| unit(column as i64, row as i64, salt) * block as f64;
            // Below the block's size.
            let (i, j) = (column + random(91) as usize, row + random(92) as usize);
            if i >= grid.size[0] || j >= grid.size[1] || grid.depth_m(i, j) < 0.3 {
                continue;
            }
            soundings.push(Sounding { at: degrees(grid.point(i, j)), depth_m: tenths(grid.depth_m(i, j)) });
        }
        let node = self.records.soundings(&soundings);
        let feature = FeatureDraft::point(ObjectClass::SOUNDG, node);
        self.records.feature(with(feature, &[("QUASOU", "1"), ("TECSOU", "3")]));
    }

    /// Tops of the floor close to the surface.
    fn rocks(&mut self, grid: &Grid) {
        const REACH: usize = 3;
        for j in REACH..grid.size[1] - REACH {
            for i in REACH..grid.size[0] - REACH {
                let depth = grid.depth_m(i, j);
                let around =
                    || (j - REACH..=j + REACH).flat_map(|y| (i - REACH..=i + REACH).map(move |x| (x, y)));
                if !(-1.5..3.5).contains(&depth) || around().any(|(x, y)| grid.depth_m(x, y) < depth) {
                    continue;
                }
                // The dredged basin is flat; it has no tops.
                if around().filter(|(x, y)| grid.depth_m(*x, *y) <= depth).count() > 1 {
                    continue;
                }
                let level = if depth < 0.0 { "4" } else { "3" };
                let node = self.records.isolated_node(degrees(grid.point(i, j)));
                let rock = FeatureDraft::point(ObjectClass::UWTROC, node);
                let rock = rock.with(AttributeCode::VALSOU, metres(tenths(depth)));
                self.records.feature(rock.with(AttributeCode::WATLEV, level));
            }
        }
    }

    fn objects(&mut self) {
        let fine = self.extent.fine();
        let limits = self.extent.limits();
        let shown = |mark: &&Mark| (fine || mark.coarse) && limits.distance(mark.at) < 0.0;
        for mark in MARKS.iter().filter(shown) {
            let node = self.records.isolated_node(degrees(stand(mark, self.sea)));
            // The master points to its slaves, not they to it (S-57 appendix B.1, 3.9).
            let lights = mark.lights.iter().map(|light| self.point("LIGHTS", node, light, &[]));
            let lights: Vec<FeatureRef> = lights.collect();
            self.point(mark.class, node, mark.attributes, &lights);
        }
        for drawn in DRAWN.iter().filter(|drawn| fine || drawn.coarse) {
            self.drawn(drawn.class, drawn.points, drawn.area, drawn.attributes);
        }
        for wall in BREAKWATERS.iter().filter(|_| fine) {
            self.drawn("SLCONS", wall, false, &[("CATSLC", "1")]);
        }
    }

    fn point(
        &mut self,
        class: &str,
        node: VectorRef,
        attributes: Attributes,
        slaves: &[FeatureRef],
    ) -> FeatureRef {
        let mut draft = with(FeatureDraft::point(class_of(class), node), attributes);
        for slave in slaves {
            draft = draft.linked(slave.object, LinkRole::Slave);
        }
        self.records.feature(draft)
    }

    fn drawn(&mut self, class: &str, points: &[[f64; 2]], area: bool, attributes: Attributes) {
        let places: Vec<_> = points.iter().map(|at| degrees(*at)).collect();
        let first = self.records.connected_node(places[0]);
        let class = class_of(class);
        let draft = if area {
            let edge = self.records.edge(first, first, &places[1..]);
            FeatureDraft::area(class, &[edge.forward()])
        } else {
            let last = self.records.connected_node(places[places.len() - 1]);
            let edge = self.records.edge(first, last, &places[1..places.len() - 1]);
            FeatureDraft::line(class, &[edge.forward()])
        };
        self.records.feature(with(draft, attributes));
    }
}

/// Where a mark stands.
pub(super) fn stand(mark: &Mark, sea: &Sea) -> [f64; 2] {
    if !mark.perched {
        return mark.at;
    }
    let offsets = || (-12..=12).map(|step| f64::from(step) * 5.0);
    let places = offsets().flat_map(|dx| offsets().map(move |dy| [mark.at[0] + dx, mark.at[1] + dy]));
    let highest = places.max_by(|a, b| sea.height_m(*a).total_cmp(&sea.height_m(*b)));
    highest.unwrap_or(mark.at)
}

/// Corners of the blocks that a grid is cut into.
fn blocks(size: [usize; 2], block: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..size[1])
        .step_by(block)
        .flat_map(move |row| (0..size[0]).step_by(block).map(move |column| (column, row)))
}

fn with(mut draft: FeatureDraft, attributes: &[(&str, &str)]) -> FeatureDraft {
    for (acronym, value) in attributes {
        let code = AttributeCode::from_acronym(acronym).expect("invariant: the tables use S-57's acronyms");
        draft = draft.with(code, *value);
        // Names are given in the national language too, as Norwegian cells do.
        if code == AttributeCode::OBJNAM {
            draft = draft.national(AttributeCode::NOBJNM, *value);
        }
    }
    draft
}

fn class_of(acronym: &str) -> ObjectClass {
    ObjectClass::from_acronym(acronym).expect("invariant: the tables use S-57's acronyms")
}

/// To the shallower tenth of a metre.
fn tenths(depth_m: f64) -> f64 {
    (depth_m * 10.0).floor() / 10.0
}

fn metres(depth_m: f64) -> String {
    format!("{depth_m}")
}
