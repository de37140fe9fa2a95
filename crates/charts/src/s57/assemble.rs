//! Nodes and edges become points, lines and surfaces.
//!
//! S-57 part 3, 4.7 (chain-node topology) and appendix B.1, 3.4. Edges are joined by the identity of their
//! nodes, not by coordinates. The order of an area's pointers is usually that of its boundary; where it is
//! not, the remaining edges of the same usage are searched.

use super::codes::{ObjectClass, SKIN_CLASSES};
use super::error::S57Problem;
use super::geometry::{Area, EdgeUse, GeoPoint, Geometry, Path, Sounding};
use super::records::{CONNECTED_NODE, Coordinate, EDGE, ISOLATED_NODE, Name, Pointer};
use super::store::{Store, StoredFeature, StoredVector};
use std::collections::{BTreeMap, BTreeSet};

const REVERSE: u8 = 2;
const EXTERIOR: u8 = 1;
const INTERIOR: u8 = 2;
const DATA_LIMIT: u8 = 3;
const MASKED: u8 = 1;
const BEGIN: u8 = 1;
const END: u8 = 2;

/// Assembles the features of one cell.
pub(super) struct Assembler<'a> {
    store: &'a Store,
    /// Vertices that may still be made. A small file that points to one edge a million times is hostile.
    budget: usize,
    limit: usize,
}

/// An edge as one pointer uses it.
struct Use<'a> {
    pointer: &'a Pointer,
    middle: &'a [Coordinate],
    from: Name,
    to: Name,
}

impl<'a> Assembler<'a> {
    pub(super) fn new(store: &'a Store) -> Self {
        // Real cells use an edge of 8-byte vertices two to four times.
        let limit = store.bytes.saturating_mul(4).saturating_add(100_000);
        Self { store, budget: limit, limit }
    }

    /// The geometry of a feature. What cannot be resolved is reported, not left out.
    pub(super) fn geometry(&mut self, feature: &StoredFeature) -> Result<Geometry, S57Problem> {
        if feature.pointers.is_empty() && feature.last_pointers.is_empty() {
            return Ok(Geometry::None);
        }
        let read = match feature.primitive {
            _ if feature.pointers.is_empty() => unreadable("an update took its place away".to_owned()),
            1 => self.points(feature)?,
            2 => match self.area_of_line(feature)? {
                Some(area) => area,
                None => self.lines(feature)?,
            },
            3 => self.area(feature)?,
            _ => Geometry::None,
        };
        let Geometry::Unreadable { mut paths, reason } = read else { return Ok(read) };
        paths.extend(self.last_known(feature)?);
        Ok(Geometry::Unreadable { paths, reason })
    }

    /// Where an object without readable geometry lay before updates took parts of it away, with its surroundings: all
    /// that its pointers lead to, or once led to.
    fn last_known(&mut self, feature: &StoredFeature) -> Result<Option<Path>, S57Problem> {
        let mut points = Vec::new();
        for pointer in feature.pointers.iter().chain(&feature.last_pointers) {
            for vector in self.known(pointer.name) {
                let nodes = vector.pointers.iter().flat_map(|node| self.known(node.name));
                let coordinates = nodes.chain([vector]).flat_map(|one| &one.coordinates);
                points.extend(coordinates.map(|one| self.degrees(*one)));
                self.spend(vector.coordinates.len() + vector.pointers.len())?;
            }
        }
        if points.is_empty() {
            return Ok(None);
        }
        points.extend(surroundings(&points));
        Ok(Some(Path { points, edges: Vec::new() }))
    }

    /// Whether all parts of an object without readable geometry are known, in their present or last state: then it lies
    /// within these.
    pub(super) fn is_whole(&self, feature: &StoredFeature) -> bool {
        let has_position = |name: Name| self.known(name).any(|one| !one.coordinates.is_empty());
        let end = |edge: Name, topology: u8| {
            let all = self.known(edge).flat_map(|one| &one.pointers);
            all.filter(|one| one.topology == topology).map(|one| one.name).find(|node| has_position(*node))
        };
        let former = !feature.last_pointers.is_empty();
        let pointers = if former { &feature.last_pointers } else { &feature.pointers };
        // Ends at which nothing else of the boundary begins or ends.
        let mut open = BTreeSet::new();
        for pointer in pointers.iter().filter(|one| one.name.kind == EDGE) {
            let (Some(begin), Some(end)) = (end(pointer.name, BEGIN), end(pointer.name, END)) else {
                return false;
            };
            for node in [begin, end] {
                if !open.remove(&node) {
                    open.insert(node);
                }
            }
        }
        let mut nodes = pointers.iter().chain(&feature.pointers).filter(|one| one.name.kind != EDGE);
        let mut edges = feature.pointers.iter().filter(|one| one.name.kind == EDGE);
        nodes.all(|one| has_position(one.name))
            && edges.all(|one| self.known(one.name).next().is_some())
            && (feature.primitive != 3 || open.is_empty())
    }

    /// A node or edge as it is and, where updates took something of it away, as it was last.
    fn known(&self, name: Name) -> impl Iterator<Item = &'a StoredVector> + use<'a> {
        self.store.vectors.get(&name).into_iter().chain(self.store.lost.get(&name))
    }

    fn spend(&mut self, vertices: usize) -> Result<(), S57Problem> {
        self.budget = self.budget.checked_sub(vertices).ok_or(S57Problem::TooLarge(self.limit))?;
        Ok(())
    }

    fn points(&mut self, feature: &StoredFeature) -> Result<Geometry, S57Problem> {
        let mut soundings = Vec::new();
        let mut single = None;
        let mut plain = 0;
        for pointer in &feature.pointers {
            let name = pointer.name;
            let Some(node) = self.store.vectors.get(&name).filter(|_| is_node(name)) else {
                return Ok(unreadable(format!("node {} is not there", name.id)));
            };
            self.spend(node.coordinates.len())?;
            if node.has_depths {
                let factor = f64::from(self.store.parameters.sounding_factor);
                soundings.extend(node.coordinates.iter().map(|coordinate| Sounding {
                    at: self.degrees(*coordinate),
                    depth_m: f64::from(coordinate.z) / factor,
                }));
            } else if let Some(coordinate) = node.coordinates.first() {
                single = single.or(Some(self.degrees(*coordinate)));
                plain += node.coordinates.len();
            }
        }
        Ok(match single {
            Some(_) if plain > 1 || !soundings.is_empty() => {
                unreadable("it is one point at several positions".to_owned())
            }
            _ if !soundings.is_empty() => Geometry::Soundings(soundings),
            Some(point) => Geometry::Point(point),
            None => unreadable("its node has no position".to_owned()),
        })
    }

    fn lines(&mut self, feature: &StoredFeature) -> Result<Geometry, S57Problem> {
        let mut paths: Vec<Path> = Vec::new();
        let mut end = None;
        let mut missing = None;
        for pointer in &feature.pointers {
            let used = match self.edge(pointer) {
                Ok(used) => used,
                Err(reason) => {
                    (end, missing) = (None, Some(reason));
                    continue;
                }
            };
            if end != Some(used.from) {
                paths.push(Path::default());
            }
            end = Some(used.to);
            let at = paths.len() - 1;
            self.append(&mut paths[at], &used)?;
        }
        if let Some(reason) = missing {
            return Ok(Geometry::Unreadable { paths, reason });
        }
        Ok(Geometry::Lines(paths))
    }

    /// The area of a feature that is coded as a line, but whose edges are coded as boundaries and form one. Not of the
    /// skin of the Earth: nothing becomes water by a guess.
    fn area_of_line(&mut self, feature: &StoredFeature) -> Result<Option<Geometry>, S57Problem> {
        let bounds = |one: &Pointer| matches!(one.usage, EXTERIOR | INTERIOR | DATA_LIMIT);
        let skin = SKIN_CLASSES.contains(&ObjectClass(feature.class));
        if skin || !feature.pointers.iter().all(bounds) {
            return Ok(None);
        }
        let read = self.area(feature)?;
        Ok(matches!(read, Geometry::Area(_)).then_some(read))
    }

    fn area(&mut self, feature: &StoredFeature) -> Result<Geometry, S57Problem> {
        let mut area = Area::default();
        let (used, missing): (Vec<_>, Vec<_>) =
            feature.pointers.iter().map(|pointer| self.edge(pointer)).partition(Result::is_ok);
        let all = used.into_iter().flatten();
        if let Some(Err(reason)) = missing.into_iter().next() {
            // The part of the boundary that is there still shows where the danger is.
            let mut paths = Vec::new();
            for used in all {
                let mut path = Path::default();
                self.append(&mut path, &used)?;
                paths.push(path);
            }
            return Ok(Geometry::Unreadable { paths, reason });
        }
        let (holes, exteriors): (Vec<_>, Vec<_>) = all.partition(|used| used.pointer.usage == INTERIOR);
        let (exteriors, exteriors_close) = self.rings(&exteriors)?;
        let (holes, holes_close) = self.rings(&holes)?;
        if !(exteriors_close && holes_close) {
            let paths = exteriors.into_iter().chain(holes).collect();
            return Ok(Geometry::Unreadable { paths, reason: "its boundary does not close".to_owned() });
        }
        for (rings, interior) in [(exteriors, false), (holes, true)] {
            for mut ring in rings {
                if (ring.signed_area_deg2() > 0.0) != interior {
                    reverse(&mut ring);
                }
                if interior { area.holes.push(ring) } else { area.exteriors.push(ring) }
            }
        }
        if area.exteriors.is_empty() {
            return Ok(unreadable("it has no exterior boundary".to_owned()));
        }
        // Of water nothing is left then, and no data is never safe.
        if !is_water(feature.class) && !area.holes.is_empty() && area.area_deg2() <= 0.0 {
            return Ok(unreadable("its holes are as large as itself".to_owned()));
        }
        Ok(Geometry::Area(area))
    }

    /// Chains edges to rings; false where one does not close.
    fn rings(&mut self, edges: &[Use<'_>]) -> Result<(Vec<Path>, bool), S57Problem> {
        let mut by_start: BTreeMap<Name, Vec<usize>> = BTreeMap::new();
        for (at, used) in edges.iter().enumerate().rev() {
            by_start.entry(used.from).or_default().push(at);
        }
        let mut taken = vec![false; edges.len()];
        let mut rings = Vec::new();
        let mut next_free = 0;
        let mut whole = true;
        while let Some(first) = (next_free..edges.len()).find(|at| !taken[*at]) {
            next_free = first;
            let mut ring = Path::default();
            let mut at = first;
            loop {
                taken[at] = true;
                self.append(&mut ring, &edges[at])?;
                let end = edges[at].to;
                if end == edges[first].from {
                    break;
                }
                let follows = edges.get(at + 1).is_some_and(|next| !taken[at + 1] && next.from == end);
                let next = if follows { Some(at + 1) } else { free_from(&mut by_start, end, &taken) };
                let Some(next) = next else {
                    whole = false;
                    break;
                };
                at = next;
            }
            rings.push(ring);
        }
        Ok((rings, whole))
    }

    fn edge<'p>(&self, pointer: &'p Pointer) -> Result<Use<'p>, String>
    where
        'a: 'p,
    {
        let name = pointer.name;
        let missing = || format!("edge {} is not there", name.id);
        let edge = self.store.vectors.get(&name).filter(|_| name.kind == EDGE).ok_or_else(missing)?;
        let node = |topology| edge.pointers.iter().find(|one| one.topology == topology).map(|one| one.name);
        let (Some(begin), Some(end)) = (node(BEGIN), node(END)) else {
            return Err(format!("edge {} lacks a node", name.id));
        };
        for node in [begin, end] {
            let whole = self.store.vectors.get(&node).is_some_and(|one| !one.coordinates.is_empty());
            if !whole || !is_node(node) {
                return Err(format!("node {} of edge {} is not there", node.id, name.id));
            }
        }
        let (from, to) = if pointer.orientation == REVERSE { (end, begin) } else { (begin, end) };
        Ok(Use { pointer, middle: &edge.coordinates, from, to })
    }

    fn append(&mut self, path: &mut Path, used: &Use<'_>) -> Result<(), S57Problem> {
        self.spend(used.middle.len() + 2)?;
        let reversed = used.pointer.orientation == REVERSE;
        let position = |name: &Name| {
            let node = self.store.vectors.get(name);
            node.and_then(|node| node.coordinates.first()).map(|coordinate| self.degrees(*coordinate))
        };
        if path.points.is_empty() {
            path.points.extend(position(&used.from));
        }
        path.edges.push(EdgeUse {
            edge: used.pointer.name.id,
            from: path.points.len().saturating_sub(1),
            reversed,
            masked: used.pointer.mask == MASKED,
            data_limit: used.pointer.usage == DATA_LIMIT,
        });
        path.points.reserve(used.middle.len() + 1);
        if reversed {
            path.points.extend(used.middle.iter().rev().map(|one| self.degrees(*one)));
        } else {
            path.points.extend(used.middle.iter().map(|one| self.degrees(*one)));
        }
        path.points.extend(position(&used.to));
        Ok(())
    }

    fn degrees(&self, coordinate: Coordinate) -> GeoPoint {
        let factor = f64::from(self.store.parameters.coordinate_factor);
        GeoPoint { lon_deg: f64::from(coordinate.x) / factor, lat_deg: f64::from(coordinate.y) / factor }
    }
}

/// The first edge from `node` that is not taken yet.
fn free_from(by_start: &mut BTreeMap<Name, Vec<usize>>, node: Name, taken: &[bool]) -> Option<usize> {
    let list = by_start.get_mut(&node)?;
    while let Some(at) = list.pop() {
        if !taken[at] {
            return Some(at);
        }
    }
    None
}

fn is_water(class: u16) -> bool {
    [ObjectClass::DEPARE, ObjectClass::DRGARE, ObjectClass::UNSARE].contains(&ObjectClass(class))
}

fn is_node(name: Name) -> bool {
    matches!(name.kind, ISOLATED_NODE | CONNECTED_NODE)
}

fn unreadable(reason: String) -> Geometry {
    Geometry::Unreadable { paths: Vec::new(), reason }
}

/// An object whose place an update broke may now lie a little beside the last one (m).
const SURROUNDINGS_M: f64 = 100.0;

/// Two corners of a box that holds points and what lies around them.
fn surroundings(points: &[GeoPoint]) -> [GeoPoint; 2] {
    const M_PER_DEGREE: f64 = 1852.0 * 60.0;
    let margin = SURROUNDINGS_M / M_PER_DEGREE;
    let farthest = points.iter().fold(0.0_f64, |lat, point| lat.max(point.lat_deg.abs()));
    let wide = margin / farthest.min(89.0).to_radians().cos();
    let start = GeoPoint { lon_deg: f64::INFINITY, lat_deg: f64::INFINITY };
    let low = points.iter().fold(start, |low, point| GeoPoint {
        lon_deg: low.lon_deg.min(point.lon_deg - wide).max(-180.0),
        lat_deg: low.lat_deg.min(point.lat_deg - margin).max(-90.0),
    });
    let start = GeoPoint { lon_deg: f64::NEG_INFINITY, lat_deg: f64::NEG_INFINITY };
    let high = points.iter().fold(start, |high, point| GeoPoint {
        lon_deg: high.lon_deg.max(point.lon_deg + wide).min(180.0),
        lat_deg: high.lat_deg.max(point.lat_deg + margin).min(90.0),
    });
    [low, high]
}

fn reverse(ring: &mut Path) {
    let last = ring.points.len().saturating_sub(1);
    ring.points.reverse();
    let starts: Vec<usize> = ring.edges.iter().map(|one| one.from).skip(1).chain([last]).collect();
    for (edge, end) in ring.edges.iter_mut().zip(starts) {
        edge.from = last - end;
        edge.reversed = !edge.reversed;
    }
    ring.edges.reverse();
}
