//! The index itself: objects, areas, and the trees over them.

use super::coords::Spot;
use super::object::{ChartObject, Role, Stored};
use super::places::{Areas, Places, WHOLE};
use super::tree::Tree;
use crate::coverage::{ChartCoverage, Coverage, Source};
use crate::grid::Bounds;
use crate::s57::ObjectClass;

/// An index over charts.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DepthIndex {
    /// The best first.
    pub(super) sources: Vec<Source>,
    pub(super) objects: Vec<ChartObject>,
    pub(super) areas: Areas,
    pub(super) places: Places,
    /// Borders of skin and dangers, single dangers, soundings, and the border of what is charted.
    pub(super) danger: Tree,
    /// Borders of quality areas.
    pub(super) quality: Tree,
    /// What is above the water.
    pub(super) overhead: Tree,
    /// Points of interest.
    pub(super) interest: Tree,
    /// Where sources without any quality area lie.
    pub(super) unassessed: Vec<Bounds>,
}

impl DepthIndex {
    /// Sources, the best first.
    pub fn sources(&self) -> &[Source] {
        &self.sources
    }

    /// What it holds, in a line for people.
    pub fn edition(&self) -> String {
        match &self.sources[..] {
            [] => "no charts".to_owned(),
            [one] => one.edition_text(),
            all => {
                let newest = all.iter().max_by_key(|source| (&source.issue_date, &source.name));
                let newest = newest.map(Source::edition_text).unwrap_or_default();
                format!("{} charts, the newest {newest}", all.len())
            }
        }
    }

    /// Which chart covers what, for who needs regions rather than depths.
    pub fn coverage(&self) -> Coverage {
        let charts =
            self.sources.iter().map(|source| ChartCoverage { source: source.clone(), ..Default::default() });
        let mut charts: Vec<ChartCoverage> = charts.collect();
        for area in &self.areas.list {
            let object = &self.objects[area.object as usize];
            let chart = &mut charts[object.source as usize];
            if object.role == Role::Coverage && !chart.source.supplement {
                let rings = self.areas.rings_of(*area).iter();
                chart.areas.push(rings.map(|ring| ring.vertices(&self.areas.vertices).to_vec()).collect());
                chart.by_skin = object.class != ObjectClass::M_COVR;
            }
        }
        Coverage::new(charts)
    }

    /// The source of an object.
    pub fn source(&self, object: &ChartObject) -> &Source {
        &self.sources[object.source as usize]
    }

    /// An object of an answer.
    pub fn object(&self, object: u32) -> Option<&ChartObject> {
        self.objects.get(object as usize)
    }

    /// Number of vertices, for telling how large a chart set is.
    pub fn vertex_count(&self) -> usize {
        self.areas.vertices.len()
    }

    /// Visits the objects of supplements and of the best source whose areas hold a point; `None` where no source
    /// covers it.
    pub(super) fn visit_at(&self, at: Spot, mut visit: impl FnMut(u32, &ChartObject)) -> Option<u32> {
        // ±180° is one meridian; areas are asked on the side on which they are written.
        let at = at.wrapped();
        let (mut answering, mut skinned) = (None, false);
        for entry in self.places.leaf(at) {
            let area = entry & !WHOLE;
            let id = self.areas.list[area as usize].object;
            let object = &self.objects[id as usize];
            let coverage = object.role == Role::Coverage;
            // They stand first in the leaf.
            if self.sources[object.source as usize].supplement {
                if !coverage && (entry & WHOLE != 0 || self.areas.contains(area, at)) {
                    visit(id, object);
                }
                continue;
            }
            match answering {
                Some(source) if object.source != source => break,
                Some(_) if coverage => continue,
                None if !coverage => continue,
                Some(_) | None => {}
            }
            // A skin does not overlap itself; should it, the shallower area stands first in the leaf.
            if skinned && object.role == Role::Skin {
                continue;
            }
            if entry & WHOLE == 0 && !self.areas.contains(area, at) {
                continue;
            }
            skinned |= object.role == Role::Skin;
            if coverage { answering = Some(object.source) } else { visit(id, object) }
        }
        answering
    }

    /// What decides at a point, with its object, and the worst zone of confidence there.
    pub(super) fn state_at(&self, at: Spot) -> State {
        let mut state = State { stored: Stored::NoData, object: None, zone: None, overhead: None };
        let mut skin = false;
        let mut worst = i32::MAX;
        self.visit_at(at, |id, object| match object.role {
            Role::Skin | Role::Danger => {
                skin |= object.role == Role::Skin;
                let least = object.stored.least_mm();
                if least < worst {
                    worst = least;
                    (state.stored, state.object) = (object.stored, Some(id));
                }
            }
            Role::Quality => state.zone = state.zone.max(object.zone),
            // One whose height nobody knows is the lowest.
            Role::Overhead => {
                let lower = |held: u32| self.clearance_m(id) < self.clearance_m(held);
                if state.overhead.is_none_or(lower) {
                    state.overhead = Some(id);
                }
            }
            Role::Coverage | Role::Interest => {}
        });
        // A place that is covered, but by no depth area, is not charted, unless something worse is there.
        if !skin && worst > Stored::NoData.least_mm() {
            (state.stored, state.object) = (Stored::NoData, None);
        }
        state
    }

    pub(super) fn note_unassessed(&mut self) {
        let mut assessed = vec![false; self.sources.len()];
        let mut bounds = vec![Bounds::EMPTY; self.sources.len()];
        for area in &self.areas.list {
            let object = &self.objects[area.object as usize];
            let source = object.source as usize;
            assessed[source] |= object.role == Role::Quality;
            // A mask of land has no depths that could be wrong.
            if object.stored == Stored::Land {
                continue;
            }
            for ring in self.areas.rings_of(*area) {
                bounds[source].add(Bounds::of(ring.vertices(&self.areas.vertices)));
            }
        }
        let told = |bounds: &Bounds| bounds.min[0] <= bounds.max[0];
        let without = bounds.into_iter().zip(assessed).filter(|(bounds, assessed)| !assessed && told(bounds));
        self.unassessed = without.map(|(bounds, _)| bounds).collect();
    }
}

/// What there is at a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct State {
    pub(super) stored: Stored,
    pub(super) object: Option<u32>,
    pub(super) zone: Option<u8>,
    pub(super) overhead: Option<u32>,
}
