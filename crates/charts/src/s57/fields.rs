//! Reads the records of one file, field by field.

use super::codes::AttributeCode;
use super::error::{Place, S57Error, S57Problem};
use super::feature::{Attribute, LinkRole, ObjectId};
use super::records::{
    Control, Coordinate, DataRecord, DatasetId, DatasetParameters, DatasetStructure, Edits, FeatureRecord,
    Instruction, Link, Name, Pointer, VectorRecord,
};
use crate::iso8211::{Field, Format, Iso8211Error, LexicalLevel, Reader, Record, Value};

/// The subfields that S-57 gives each field; a file that says otherwise cannot be understood.
const LAYOUTS: &[(&str, &str)] = &[
    ("DSID", "RCNM RCID EXPP INTU DSNM EDTN UPDN UADT ISDT STED PRSP PSDN PRED PROF AGEN COMT"),
    ("DSSI", "DSTR AALL NALL NOMR NOCR NOGR NOLR NOIN NOCN NOED NOFA"),
    ("DSPM", "RCNM RCID HDAT VDAT SDAT CSCL DUNI HUNI PUNI COUN COMF SOMF COMT"),
    ("FRID", "RCNM RCID PRIM GRUP OBJL RVER RUIN"),
    ("FOID", "AGEN FIDN FIDS"),
    ("ATTF", "ATTL ATVL"),
    ("NATF", "ATTL ATVL"),
    ("FFPC", "FFUI FFIX NFPT"),
    ("FFPT", "LNAM RIND COMT"),
    ("FSPC", "FSUI FSIX NSPT"),
    ("FSPT", "NAME ORNT USAG MASK"),
    ("VRID", "RCNM RCID RVER RUIN"),
    ("ATTV", "ATTL ATVL"),
    ("VRPC", "VPUI VPIX NVPT"),
    ("VRPT", "NAME ORNT USAG TOPI MASK"),
    ("SGCC", "CCUI CCIX CCNC"),
    ("SG2D", "YCOO XCOO"),
    ("SG3D", "YCOO XCOO VE3D"),
];

/// Reads one file's records.
pub(super) struct FileReader<'a> {
    file: &'a str,
    reader: Reader<'a>,
    attribute_level: LexicalLevel,
    national_level: LexicalLevel,
}

impl<'a> FileReader<'a> {
    pub(super) fn new(file: &'a str, bytes: &'a [u8]) -> Result<Self, S57Error> {
        let reader = Reader::new(bytes).map_err(|error| container(file, error))?;
        for (tag, expected) in LAYOUTS {
            let key: &[u8; 4] = tag.as_bytes().try_into().expect("invariant: tags have four letters");
            let Some(definition) = reader.definition(key) else { continue };
            let whole = |problem| S57Error { file: file.to_owned(), place: None, problem };
            if !definition.labels().eq(expected.split(' ')) {
                let found = definition.labels().collect::<Vec<_>>().join(" ");
                return Err(whole(S57Problem::Labels { tag, expected, found }));
            }
            let binary = |format: Format| matches!(format, Format::Signed(_) | Format::Unsigned(_));
            if tag.starts_with("SG2") && !definition.subfields.iter().all(|one| binary(one.format)) {
                return Err(whole(S57Problem::AsciiForm));
            }
        }
        let level = LexicalLevel::Latin1;
        Ok(Self { file, reader, attribute_level: level, national_level: level })
    }

    pub(super) fn next_record(&mut self) -> Result<Option<(Place, DataRecord)>, S57Error> {
        let Some(record) = self.reader.next_record().map_err(|error| container(self.file, error))? else {
            return Ok(None);
        };
        let place = Place { record: record.number, offset: record.offset };
        let data = if record.field(b"DSID").is_some() {
            self.dataset(&record)?
        } else if record.field(b"DSPM").is_some() {
            DataRecord::Parameters(self.parameters(&record)?)
        } else if record.field(b"FRID").is_some() {
            DataRecord::Feature(self.feature(&record)?)
        } else if record.field(b"VRID").is_some() {
            DataRecord::Vector(self.vector(&record)?)
        } else {
            DataRecord::Other
        };
        Ok(Some((place, data)))
    }

    fn dataset(&mut self, record: &Record<'a>) -> Result<DataRecord, S57Error> {
        let mut id = DatasetId::default();
        let mut structure = None;
        for field in &record.fields {
            let fail = |what| self.fail(*field, record, S57Problem::Range { what });
            match &field.tag.0 {
                b"DSID" => self.rows(record, *field, LexicalLevel::Latin1, |row| {
                    id = DatasetId {
                        purpose: whole(row[2]).ok_or("the exchange purpose (EXPP)")?,
                        band: whole(row[3]).ok_or("the usage band (INTU)")?,
                        name: text(row[4]),
                        edition: text(row[5]),
                        update: text(row[6]),
                        update_date: text(row[7]),
                        issue_date: text(row[8]),
                        standard: row[9]
                            .real()
                            .map_or_else(|| text(row[9]), |edition| format!("{edition:04.1}")),
                        product: whole(row[10]).unwrap_or(0),
                        agency: whole(row[14]).unwrap_or(0),
                        comment: text(row[15]),
                    };
                    Ok(())
                })?,
                b"DSSI" => {
                    let mut read = None;
                    self.rows(record, *field, LexicalLevel::Latin1, |row| {
                        let count = |at: usize| whole(row[at]).unwrap_or(0);
                        read = Some(DatasetStructure {
                            structure: whole(row[0]).unwrap_or(0),
                            attribute_level: level(row[1]).ok_or("the lexical level (AALL)")?,
                            national_level: level(row[2]).ok_or("the lexical level (NALL)")?,
                            meta_features: count(3),
                            geo_features: count(5),
                            collections: count(6),
                            isolated_nodes: count(7),
                            connected_nodes: count(8),
                            edges: count(9),
                        });
                        Ok(())
                    })?;
                    structure = read;
                }
                _ => {}
            }
            if id.name.len() > 1024 {
                return Err(fail("the length of the data set's name (DSNM)"));
            }
        }
        if let Some(structure) = &structure {
            self.attribute_level = structure.attribute_level;
            self.national_level = structure.national_level;
        }
        Ok(DataRecord::Id(id, structure))
    }

    fn parameters(&self, record: &Record<'a>) -> Result<DatasetParameters, S57Error> {
        let mut parameters = DatasetParameters::default();
        for field in record.fields.iter().filter(|field| &field.tag.0 == b"DSPM") {
            let mut wrong = None;
            self.rows(record, *field, LexicalLevel::Latin1, |row| {
                parameters = DatasetParameters {
                    horizontal_datum: whole(row[2]).ok_or("the horizontal datum (HDAT)")?,
                    vertical_datum: whole(row[3]).unwrap_or(0),
                    sounding_datum: whole(row[4]).unwrap_or(0),
                    scale: whole(row[5]).ok_or("the compilation scale (CSCL)")?,
                    coordinate_factor: whole(row[10]).filter(|f| *f > 0).ok_or("the factor COMF")?,
                    sounding_factor: whole(row[11]).filter(|f| *f > 0).ok_or("the factor SOMF")?,
                    comment: text(row[12]),
                };
                let units = [
                    ("the horizontal datum (HDAT)", row[2], 2, "2 (WGS 84)"),
                    ("the depth unit (DUNI)", row[6], 1, "1 (metres)"),
                    ("the height unit (HUNI)", row[7], 1, "1 (metres)"),
                    ("the unit of accuracy (PUNI)", row[8], 1, "1 (metres)"),
                    ("the coordinate unit (COUN)", row[9], 1, "1 (degrees)"),
                ];
                wrong = units.into_iter().find(|(_, value, right, _)| value.integer() != Some(*right));
                Ok(())
            })?;
            if let Some((name, value, _, expected)) = wrong {
                let value = value.integer().unwrap_or(-1);
                return Err(self.fail(*field, record, S57Problem::Parameter { name, value, expected }));
            }
        }
        Ok(parameters)
    }

    fn feature(&self, record: &Record<'a>) -> Result<FeatureRecord, S57Error> {
        let mut feature = FeatureRecord::default();
        let (mut link_control, mut pointer_control) = (None, None);
        for field in &record.fields {
            let latin = LexicalLevel::Latin1;
            match &field.tag.0 {
                b"FRID" => self.rows(record, *field, latin, |row| {
                    feature.id = whole(row[1]).ok_or("the record number (RCID)")?;
                    feature.primitive = whole(row[2]).ok_or("the primitive (PRIM)")?;
                    feature.group = whole(row[3]).ok_or("the group (GRUP)")?;
                    feature.class = whole(row[4]).ok_or("the object class (OBJL)")?;
                    feature.version = whole(row[5]).ok_or("the version (RVER)")?;
                    feature.instruction = instruction(row[6]).ok_or("the update instruction (RUIN)")?;
                    Ok(())
                })?,
                b"FOID" => self.rows(record, *field, latin, |row| {
                    feature.object = Some(ObjectId {
                        agency: whole(row[0]).ok_or("the agency (AGEN)")?,
                        number: whole(row[1]).ok_or("the object number (FIDN)")?,
                        subdivision: whole(row[2]).ok_or("the object subdivision (FIDS)")?,
                    });
                    Ok(())
                })?,
                b"ATTF" => self.attributes(record, *field, self.attribute_level, &mut feature.attributes)?,
                b"NATF" => self.attributes(record, *field, self.national_level, &mut feature.national)?,
                b"FFPC" => link_control = self.control(record, *field, &mut feature.links)?,
                b"FSPC" => pointer_control = self.control(record, *field, &mut feature.pointers)?,
                b"FFPT" => {
                    let list = list_for(&mut feature.links, link_control.take());
                    self.rows(record, *field, latin, |row| {
                        let to = object_id(row[0]).ok_or("the object pointer (LNAM)")?;
                        list.push(Link { to, role: LinkRole::from_code(row[1].integer().unwrap_or(0)) });
                        Ok(())
                    })?;
                }
                b"FSPT" => {
                    let list = list_for(&mut feature.pointers, pointer_control.take());
                    self.rows(record, *field, latin, |row| {
                        list.push(Pointer {
                            name: name(row[0]).ok_or("the vector pointer (NAME)")?,
                            orientation: whole(row[1]).ok_or("the orientation (ORNT)")?,
                            usage: whole(row[2]).ok_or("the usage (USAG)")?,
                            topology: 0,
                            mask: whole(row[3]).ok_or("the mask (MASK)")?,
                        });
                        Ok(())
                    })?;
                }
                _ => {}
            }
        }
        // A control whose list is missing must not count as no change.
        feature.links.extend(link_control.map(|control| (Some(control), Vec::new())));
        feature.pointers.extend(pointer_control.map(|control| (Some(control), Vec::new())));
        Ok(feature)
    }

    fn vector(&self, record: &Record<'a>) -> Result<VectorRecord, S57Error> {
        let mut vector = VectorRecord::default();
        let (mut pointer_control, mut coordinate_control, mut flat) = (None, None, None);
        for field in &record.fields {
            let latin = LexicalLevel::Latin1;
            match &field.tag.0 {
                b"VRID" => self.rows(record, *field, latin, |row| {
                    vector.name = Name {
                        kind: whole(row[0]).ok_or("the record name (RCNM)")?,
                        id: whole(row[1]).ok_or("the record number (RCID)")?,
                    };
                    vector.version = whole(row[2]).ok_or("the version (RVER)")?;
                    vector.instruction = instruction(row[3]).ok_or("the update instruction (RUIN)")?;
                    Ok(())
                })?,
                b"ATTV" => self.attributes(record, *field, self.attribute_level, &mut vector.attributes)?,
                b"VRPC" => pointer_control = self.control(record, *field, &mut vector.pointers)?,
                b"SGCC" => coordinate_control = self.control(record, *field, &mut vector.coordinates)?,
                b"VRPT" => {
                    let list = list_for(&mut vector.pointers, pointer_control.take());
                    self.rows(record, *field, latin, |row| {
                        list.push(Pointer {
                            name: name(row[0]).ok_or("the vector pointer (NAME)")?,
                            orientation: whole(row[1]).ok_or("the orientation (ORNT)")?,
                            usage: whole(row[2]).ok_or("the usage (USAG)")?,
                            topology: whole(row[3]).ok_or("the topology (TOPI)")?,
                            mask: whole(row[4]).ok_or("the mask (MASK)")?,
                        });
                        Ok(())
                    })?;
                }
                tag @ (b"SG2D" | b"SG3D") => {
                    let depths = tag == b"SG3D";
                    vector.has_depths |= depths;
                    flat = flat.or((!depths).then_some(*field));
                    let list = list_for(&mut vector.coordinates, coordinate_control.take());
                    // Rows of 8 or 12 bytes: the file's own size bounds the list.
                    list.reserve(field.bytes.len() / 12);
                    self.rows(record, *field, latin, |row| {
                        list.push(Coordinate {
                            y: whole(row[0]).ok_or("a coordinate (YCOO)")?,
                            x: whole(row[1]).ok_or("a coordinate (XCOO)")?,
                            z: if depths { whole(row[2]).ok_or("a depth (VE3D)")? } else { 0 },
                        });
                        Ok(())
                    })?;
                }
                _ => {}
            }
        }
        if let Some(field) = flat.filter(|_| vector.has_depths) {
            let (id, what) = (vector.name.id, "given positions with and without depths");
            return Err(self.fail(field, record, S57Problem::Record { kind: "vector record", id, what }));
        }
        // A control whose list is missing must not count as no change.
        vector.pointers.extend(pointer_control.map(|control| (Some(control), Vec::new())));
        vector.coordinates.extend(coordinate_control.map(|control| (Some(control), Vec::new())));
        Ok(vector)
    }

    fn attributes(
        &self,
        record: &Record<'a>,
        field: Field<'a>,
        level: LexicalLevel,
        list: &mut Vec<Attribute>,
    ) -> Result<(), S57Error> {
        self.rows(record, field, level, |row| {
            let code = AttributeCode(whole(row[0]).ok_or("the attribute (ATTL)")?);
            list.push(Attribute { code, value: level.decode(row[1].bytes()) });
            Ok(())
        })
    }

    /// Opens an edit. A delete has no list after it; the others take the next list field.
    fn control<T>(
        &self,
        record: &Record<'a>,
        field: Field<'a>,
        edits: &mut Edits<T>,
    ) -> Result<Option<Control>, S57Error> {
        let mut control = None;
        self.rows(record, field, LexicalLevel::Latin1, |row| {
            control = Some(Control {
                instruction: instruction(row[0]).ok_or("the list's update instruction")?,
                index: whole(row[1]).ok_or("the list's update index")?,
                count: whole(row[2]).ok_or("the list's update count")?,
            });
            Ok(())
        })?;
        if let Some(delete) = control.filter(|control| control.instruction == Instruction::Delete) {
            edits.push((Some(delete), Vec::new()));
            control = None;
        }
        Ok(control)
    }

    fn rows(
        &self,
        record: &Record<'a>,
        field: Field<'a>,
        level: LexicalLevel,
        mut each: impl FnMut(&[Value<'a>]) -> Result<(), &'static str>,
    ) -> Result<(), S57Error> {
        let mut rows = self.reader.rows(record, field, level).map_err(|error| container(self.file, error))?;
        let mut row = Vec::with_capacity(16);
        while rows.next_into(&mut row).map_err(|error| container(self.file, error))? {
            each(&row).map_err(|what| self.fail(field, record, S57Problem::Range { what }))?;
        }
        Ok(())
    }

    fn fail(&self, field: Field<'a>, record: &Record<'a>, problem: S57Problem) -> S57Error {
        let place = Some(Place { record: record.number, offset: field.offset });
        S57Error { file: self.file.to_owned(), place, problem }
    }
}

pub(super) fn container(file: &str, error: Iso8211Error) -> S57Error {
    S57Error { file: file.to_owned(), place: None, problem: S57Problem::Container(error) }
}

/// The list that a list field fills: one under its control, or the plain one, which may come in several fields.
fn list_for<T>(edits: &mut Edits<T>, control: Option<Control>) -> &mut Vec<T> {
    let continues = control.is_none() && edits.last().is_some_and(|(control, _)| control.is_none());
    if !continues {
        edits.push((control, Vec::new()));
    }
    let at = edits.len() - 1;
    &mut edits[at].1
}

fn whole<T: TryFrom<i64>>(value: Value<'_>) -> Option<T> {
    value.integer().and_then(|value| T::try_from(value).ok())
}

fn text(value: Value<'_>) -> String {
    LexicalLevel::Latin1.decode(value.bytes()).trim().to_owned()
}

fn level(value: Value<'_>) -> Option<LexicalLevel> {
    match value.integer()? {
        0 => Some(LexicalLevel::Ascii),
        1 => Some(LexicalLevel::Latin1),
        2 => Some(LexicalLevel::Ucs2),
        _ => None,
    }
}

fn instruction(value: Value<'_>) -> Option<Instruction> {
    Instruction::from_code(value.integer()?)
}

fn name(value: Value<'_>) -> Option<Name> {
    let [kind, a, b, c, d] = *value.bytes() else { return None };
    Some(Name { kind, id: u32::from_le_bytes([a, b, c, d]) })
}

fn object_id(value: Value<'_>) -> Option<ObjectId> {
    let [a, b, c, d, e, f, g, h] = *value.bytes() else { return None };
    Some(ObjectId {
        agency: u16::from_le_bytes([a, b]),
        number: u32::from_le_bytes([c, d, e, f]),
        subdivision: u16::from_le_bytes([g, h]),
    })
}
