//! One chart's contribution to an index: its own part, made of it alone, and its seams to the charts around it.
//!
//! The own part is objects, areas and lines, and the quadtree over the areas. The seams are what is left of its lines
//! and borders where better charts hide them, and what lies just beyond its coverage: they change when a chart that
//! overlaps it does. So a set of charts is as many pieces, and a change touches few of them.

use super::coords::Spot;
use super::object::{ChartObject, Role, Stored};
use super::places::{Areas, Places, WHOLE};
use super::tree::{Run, Tree};
use crate::grid::Bounds;

/// A line of a chart, or a point: vertices of the piece.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Line {
    pub(super) object: u32,
    pub(super) first: u32,
    pub(super) count: u32,
}

/// Which of a piece's trees.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Borders of skin and dangers, single dangers, soundings, and the border of what is charted.
    Danger,
    /// Borders of quality areas.
    Quality,
    /// Overhead obstacles.
    Overhead,
    /// Points of interest.
    Interest,
    /// Borders of areas whose entry is prohibited or restricted.
    Restricted,
}

/// One chart of an index.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Piece {
    /// Whether its chart only adds to others.
    pub(super) supplement: bool,
    /// Charts that the objects are from: its own first, then those beyond its borders.
    pub(super) charts: Vec<String>,
    /// Its own, then those just beyond its borders; `source` is the place in `charts`.
    pub(super) objects: Vec<ChartObject>,
    /// Vertices of areas and lines, then of what the seams cut.
    pub(super) areas: Areas,
    pub(super) lines: Vec<Line>,
    pub(super) places: Places,
    pub(super) own_objects: u32,
    pub(super) own_vertices: u32,
    /// In the order of [`Kind`].
    pub(super) trees: [Tree; 5],
}

impl Piece {
    pub(super) fn tree(&self, kind: Kind) -> &Tree {
        &self.trees[kind as usize]
    }

    /// All that is the chart's own, in a box.
    pub(super) fn bounds(&self) -> Bounds {
        Bounds::of(&self.areas.vertices[..self.own_vertices as usize])
    }

    /// The vertices of a run.
    pub(super) fn vertices(&self, run: &Run) -> &[crate::grid::Vertex] {
        &self.areas.vertices[run.first as usize..(run.first + run.count) as usize]
    }

    /// What an object of a run means; `None` stands for the absence of any.
    pub(super) fn object(&self, object: u32) -> Option<&ChartObject> {
        self.objects.get(object as usize)
    }

    /// The meaning of a run for a vessel.
    pub(super) fn stored(&self, object: u32) -> Stored {
        self.object(object).map_or(Stored::NoData, |one| one.stored)
    }

    /// Its own part, as it was before the seams.
    pub(super) fn own(mut self) -> Self {
        self.charts.truncate(1);
        self.objects.truncate(self.own_objects as usize);
        self.areas.vertices.truncate(self.own_vertices as usize);
        self.trees = Default::default();
        self
    }

    /// Visits the objects whose areas hold a point, if the chart covers it or is a supplement. Returns whether it is the
    /// chart that answers there.
    pub(super) fn visit_at(&self, at: Spot, mut visit: impl FnMut(u32, &ChartObject)) -> bool {
        let (mut answers, mut skinned) = (false, false);
        for entry in self.places.leaf(at) {
            let area = entry & !WHOLE;
            let id = self.areas.list[area as usize].object;
            let object = &self.objects[id as usize];
            let coverage = object.role == Role::Coverage;
            // Areas of coverage stand first in the leaf. Where they do not hold the point, what the chart has there all the
            // same can only make it worse.
            let beyond = !self.supplement && !answers && !coverage;
            let told = matches!(object.role, Role::Quality | Role::Interest);
            let idle = if beyond { told } else { coverage && (self.supplement || answers) };
            // A skin does not overlap itself; should it, the shallower area stands first in the leaf.
            if idle || !self.supplement && skinned && object.role == Role::Skin {
                continue;
            }
            if entry & WHOLE == 0 && !self.areas.contains(area, object.hold(), at) {
                continue;
            }
            skinned |= object.role == Role::Skin;
            if coverage {
                answers = true;
            } else if beyond && object.role == Role::Skin {
                visit(id, &ChartObject { role: Role::Danger, ..object.clone() });
            } else {
                visit(id, object);
            }
        }
        answers
    }

    /// The box of its waters, if their survey quality is not stated.
    pub(super) fn unassessed(&self) -> Option<Bounds> {
        let mut bounds = Bounds::EMPTY;
        for area in &self.areas.list {
            let object = &self.objects[area.object as usize];
            if object.role == Role::Quality {
                return None;
            }
            // A mask of land has no depths that could be wrong, nor has an area that may not be entered.
            if object.stored != Stored::Land && object.role.restriction().is_none() {
                for ring in self.areas.rings_of(*area) {
                    bounds.add(Bounds::of(ring.vertices(&self.areas.vertices)));
                }
            }
        }
        (bounds.min[0] <= bounds.max[0]).then_some(bounds)
    }

    /// The worst zone of confidence of its quality areas; one without a zone is the worst there is.
    pub(super) fn worst_zone(&self) -> Option<u8> {
        let quality =
            self.objects[..self.own_objects as usize].iter().filter(|one| one.role == Role::Quality);
        quality.map(|one| one.zone.unwrap_or(6)).max()
    }
}
