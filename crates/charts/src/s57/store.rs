//! A cell's records between reading and assembly: what updates work on.

use super::error::{Place, S57Error, S57Problem};
use super::feature::{Attribute, ObjectId};
use super::fields::FileReader;
use super::records::{
    CONNECTED_NODE, Coordinate, DataRecord, DatasetId, DatasetParameters, DatasetStructure, EDGE, Edits,
    FeatureRecord, ISOLATED_NODE, Instruction, Link, Name, Pointer, VectorRecord,
};
use std::collections::BTreeMap;

/// An irregularity that was read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Notice {
    /// The file.
    pub file: String,
    /// The feature's record number, where it concerns one.
    pub feature: Option<u32>,
    /// What it is.
    pub text: String,
}

#[derive(Debug, Clone)]
pub(super) struct StoredFeature {
    pub(super) primitive: u8,
    pub(super) group: u8,
    pub(super) class: u16,
    pub(super) version: u16,
    pub(super) object: ObjectId,
    pub(super) attributes: Vec<Attribute>,
    pub(super) national: Vec<Attribute>,
    pub(super) links: Vec<Link>,
    pub(super) pointers: Vec<Pointer>,
    /// Where it lay before an update took some of its pointers away.
    pub(super) last_pointers: Vec<Pointer>,
}

#[derive(Debug, Clone)]
pub(super) struct StoredVector {
    pub(super) version: u16,
    pub(super) attributes: Vec<Attribute>,
    pub(super) pointers: Vec<Pointer>,
    pub(super) coordinates: Vec<Coordinate>,
    pub(super) has_depths: bool,
}

/// All records of a cell.
#[derive(Debug, Clone)]
pub(super) struct Store {
    pub(super) id: DatasetId,
    pub(super) structure: DatasetStructure,
    pub(super) parameters: DatasetParameters,
    pub(super) features: BTreeMap<u32, StoredFeature>,
    pub(super) vectors: BTreeMap<Name, StoredVector>,
    /// Records that updates deleted or emptied, in their last state: an object that still points there lay there.
    pub(super) lost: BTreeMap<Name, StoredVector>,
    pub(super) notices: Vec<Notice>,
    /// Bytes of the base and its updates: they bound the geometry that is accepted.
    pub(super) bytes: usize,
    /// The update that the base contained when it came: 0 unless it is a re-issue.
    pub(super) reissue: u32,
}

impl Store {
    /// Reads a base cell.
    pub(super) fn read_base(file: &str, bytes: &[u8]) -> Result<Self, S57Error> {
        let mut reader = FileReader::new(file, bytes)?;
        let (mut id, mut structure, mut parameters) = (None, None, None);
        let (mut features, mut vectors) = (BTreeMap::new(), BTreeMap::new());
        let mut tally = Tally::default();
        while let Some((place, record)) = reader.next_record()? {
            let fail = |problem| S57Error { file: file.to_owned(), place: Some(place), problem };
            tally.add(&record);
            match record {
                DataRecord::Id(found, found_structure) => {
                    if found.purpose == 2 {
                        return Err(fail(S57Problem::NotABase));
                    }
                    once(&mut id, found, "data set identification (field DSID)").map_err(fail)?;
                    structure = found_structure;
                }
                DataRecord::Parameters(found) => {
                    once(&mut parameters, found, "set of parameters (field DSPM)").map_err(fail)?;
                }
                DataRecord::Feature(record) => {
                    let key = record.id;
                    if features.insert(key, StoredFeature::from_record(record).map_err(fail)?).is_some() {
                        return Err(fail(repeated("feature", key)));
                    }
                }
                DataRecord::Vector(record) => {
                    let key = record.name;
                    if vectors.insert(key, StoredVector::from_record(record).map_err(fail)?).is_some() {
                        return Err(fail(repeated("vector record", key.id)));
                    }
                }
                DataRecord::Other => {}
            }
        }
        let whole = |problem| S57Error { file: file.to_owned(), place: None, problem };
        let id = id.ok_or_else(|| whole(S57Problem::NoIdentification))?;
        let parameters = parameters.ok_or_else(|| whole(S57Problem::NoParameters))?;
        let structure = structure.unwrap_or_default();
        let reissue = id.update.parse().unwrap_or(0);
        let mut store = {
            let (lost, notices, bytes) = (BTreeMap::new(), Vec::new(), bytes.len());
            Self { id, structure, parameters, features, vectors, lost, notices, bytes, reissue }
        };
        if store.id.edition == "0" {
            return Err(whole(S57Problem::Cancelled));
        }
        let texts = tally.compare(&store.structure).map_err(whole)?;
        store.note(file, texts);
        Ok(store)
    }

    pub(super) fn note(&mut self, file: &str, texts: Vec<String>) {
        let notice = |text| Notice { file: file.to_owned(), feature: None, text };
        self.notices.extend(texts.into_iter().map(notice));
    }
}

/// Records of a file by kind, to be compared with what its head announces.
#[derive(Debug, Default)]
pub(super) struct Tally {
    features: u32,
    isolated_nodes: u32,
    connected_nodes: u32,
    edges: u32,
}

impl Tally {
    /// Counts a record.
    pub(super) fn add(&mut self, record: &DataRecord) {
        let count = match record {
            DataRecord::Feature(_) => &mut self.features,
            DataRecord::Vector(vector) => match vector.name.kind {
                ISOLATED_NODE => &mut self.isolated_nodes,
                CONNECTED_NODE => &mut self.connected_nodes,
                EDGE => &mut self.edges,
                _ => return,
            },
            DataRecord::Id(..) | DataRecord::Parameters(_) | DataRecord::Other => return,
        };
        *count += 1;
    }

    /// Compares the record counts in the file's head with those found. A file cut between two records has whole records
    /// only, so nothing else reveals it, and a lost record may be a danger. More records than announced lose nothing: the
    /// returned texts name them.
    pub(super) fn compare(&self, said: &DatasetStructure) -> Result<Vec<String>, S57Problem> {
        let features = said.meta_features.saturating_add(said.geo_features).saturating_add(said.collections);
        let counts = [
            ("features", features, self.features),
            ("isolated nodes", said.isolated_nodes, self.isolated_nodes),
            ("connected nodes", said.connected_nodes, self.connected_nodes),
            ("edges", said.edges, self.edges),
        ];
        let mut texts = Vec::new();
        for (what, announced, found) in counts {
            if found < announced {
                return Err(S57Problem::Cut { what, announced, found });
            }
            if announced != 0 && found > announced {
                texts.push(format!("the head of the file announces {announced} {what}, but it has {found}"));
            }
        }
        Ok(texts)
    }
}

fn once<T>(held: &mut Option<T>, found: T, what: &'static str) -> Result<(), S57Problem> {
    held.replace(found).map_or(Ok(()), |_| Err(S57Problem::Twice { what }))
}

fn repeated(kind: &'static str, id: u32) -> S57Problem {
    S57Problem::Record { kind, id, what: "there twice" }
}

impl StoredFeature {
    pub(super) fn from_record(record: FeatureRecord) -> Result<Self, S57Problem> {
        let id = record.id;
        let fail = |what| S57Problem::Record { kind: "feature", id, what };
        if record.instruction != Instruction::Insert {
            return Err(fail("to be changed or deleted, but not there"));
        }
        Ok(Self {
            primitive: record.primitive,
            group: record.group,
            class: record.class,
            version: record.version,
            object: record.object.ok_or_else(|| fail("without an object identifier (FOID)"))?,
            attributes: record.attributes,
            national: record.national,
            links: whole_list(record.links).ok_or_else(|| fail("given in pieces"))?,
            pointers: whole_list(record.pointers).ok_or_else(|| fail("given in pieces"))?,
            last_pointers: Vec::new(),
        })
    }
}

impl StoredVector {
    pub(super) fn from_record(record: VectorRecord) -> Result<Self, S57Problem> {
        let id = record.name.id;
        let fail = |what| S57Problem::Record { kind: "vector record", id, what };
        if record.instruction != Instruction::Insert {
            return Err(fail("to be changed or deleted, but not there"));
        }
        Ok(Self {
            version: record.version,
            attributes: record.attributes,
            pointers: whole_list(record.pointers).ok_or_else(|| fail("given in pieces"))?,
            coordinates: whole_list(record.coordinates).ok_or_else(|| fail("given in pieces"))?,
            has_depths: record.has_depths,
        })
    }
}

/// The list of a record that is inserted. Some producers put an "insert" control before it.
fn whole_list<T>(edits: Edits<T>) -> Option<Vec<T>> {
    let mut list = Vec::new();
    for (control, items) in edits {
        let appends = control.is_none_or(|control| {
            control.instruction == Instruction::Insert
                && control.index == list.len() + 1
                && control.count == items.len()
        });
        if !appends {
            return None;
        }
        // The usual record has one list: it is moved, not copied.
        if list.is_empty() { list = items } else { list.extend(items) }
    }
    Some(list)
}

/// The file and record that an update's change comes from.
pub(super) fn at(file: &str, place: Place, problem: S57Problem) -> S57Error {
    S57Error { file: file.to_owned(), place: Some(place), problem }
}
