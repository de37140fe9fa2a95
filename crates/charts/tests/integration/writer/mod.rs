//! Writes small S-57 files for tests: enough of ISO 8211 and S-57 to make what the real cells lack.

#![allow(dead_code, reason = "each test uses a part")]

use std::fmt::Write as _;

pub(crate) const DEPARE: u16 = 42;
pub(crate) const LNDARE: u16 = 71;
pub(crate) const M_COVR: u16 = 302;
pub(crate) const DRVAL1: u16 = 87;
pub(crate) const DRVAL2: u16 = 88;

const FIELDS: &[(&str, &str, &str)] = &[
    ("0001", "", "(b12)"),
    (
        "DSID",
        "RCNM!RCID!EXPP!INTU!DSNM!EDTN!UPDN!UADT!ISDT!STED!PRSP!PSDN!PRED!PROF!AGEN!COMT",
        "(b11,b14,2b11,3A,2A(8),R(4),b11,2A,b11,b12,A)",
    ),
    ("DSSI", "DSTR!AALL!NALL!NOMR!NOCR!NOGR!NOLR!NOIN!NOCN!NOED!NOFA", "(3b11,8b14)"),
    (
        "DSPM",
        "RCNM!RCID!HDAT!VDAT!SDAT!CSCL!DUNI!HUNI!PUNI!COUN!COMF!SOMF!COMT",
        "(b11,b14,3b11,b14,4b11,2b14,A)",
    ),
    ("FRID", "RCNM!RCID!PRIM!GRUP!OBJL!RVER!RUIN", "(b11,b14,2b11,2b12,b11)"),
    ("FOID", "AGEN!FIDN!FIDS", "(b12,b14,b12)"),
    ("ATTF", "*ATTL!ATVL", "(b12,A)"),
    ("NATF", "*ATTL!ATVL", "(b12,A)"),
    ("FSPC", "FSUI!FSIX!NSPT", "(b11,2b12)"),
    ("FSPT", "*NAME!ORNT!USAG!MASK", "(B(40),3b11)"),
    ("VRID", "RCNM!RCID!RVER!RUIN", "(b11,b14,b12,b11)"),
    ("VRPC", "VPUI!VPIX!NVPT", "(b11,2b12)"),
    ("VRPT", "*NAME!ORNT!USAG!TOPI!MASK", "(B(40),4b11)"),
    ("SGCC", "CCUI!CCIX!CCNC", "(b11,2b12)"),
    ("SG2D", "*YCOO!XCOO", "(2b24)"),
    ("SG3D", "*YCOO!XCOO!VE3D", "(3b24)"),
    ("CATD", "RCNM!RCID!FILE!LFIL!VOLM!IMPL!SLAT!WLON!NLAT!ELON!CRCS!COMT", "(A(2),I(10),3A,A(3),4R,2A)"),
];

/// Bytes of one field.
#[derive(Clone, Default)]
pub(crate) struct Bytes(pub(crate) Vec<u8>);

impl Bytes {
    pub(crate) fn u8(mut self, value: u8) -> Self {
        self.0.push(value);
        self
    }
    pub(crate) fn u16(mut self, value: u16) -> Self {
        self.0.extend(value.to_le_bytes());
        self
    }
    pub(crate) fn u32(mut self, value: u32) -> Self {
        self.0.extend(value.to_le_bytes());
        self
    }
    pub(crate) fn i32(mut self, value: i32) -> Self {
        self.0.extend(value.to_le_bytes());
        self
    }
    pub(crate) fn text(mut self, text: &str) -> Self {
        self.0.extend(text.as_bytes());
        self.u8(0x1F)
    }
    pub(crate) fn fixed(mut self, text: &str) -> Self {
        self.0.extend(text.as_bytes());
        self
    }
    pub(crate) fn ucs2(mut self, text: &str) -> Self {
        text.encode_utf16().chain([0x1F]).for_each(|unit| self.0.extend(unit.to_le_bytes()));
        self
    }
}

type Fields = Vec<(&'static str, Vec<u8>)>;

fn whole(leader: [&str; 2], fields: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let (mut directory, mut area) = (String::new(), Vec::<u8>::new());
    for (tag, data) in fields {
        write!(directory, "{tag}{:05}{:05}", data.len(), area.len()).unwrap();
        area.extend(data);
    }
    let base = 24 + directory.len() + 1;
    let [identity, control] = leader;
    let mut record = format!("{:05}{identity}{control}{base:05}   5504", base + area.len()).into_bytes();
    record.extend(directory.as_bytes());
    record.push(0x1E);
    record.extend(area);
    record
}

/// A file of records.
pub(crate) fn file(records: &[Fields]) -> Vec<u8> {
    let described: Vec<(&str, Vec<u8>)> = FIELDS
        .iter()
        .map(|(tag, labels, formats)| {
            (*tag, format!("1600;&   {tag}\u{1F}{labels}\u{1F}{formats}\u{1E}").into_bytes())
        })
        .collect();
    let mut bytes = whole(["3LE1 ", "09"], &described);
    for fields in records {
        let closed: Vec<(&str, Vec<u8>)> = fields
            .iter()
            .map(|(tag, data)| {
                let mut data = data.clone();
                data.push(0x1E);
                if *tag == "NATF" {
                    data.push(0);
                }
                (*tag, data)
            })
            .collect();
        bytes.extend(whole([" D   ", "  "], &closed));
    }
    bytes
}

/// Identification; national attributes are in UCS-2.
pub(crate) fn dsid(update: bool, name: &str, edition: &str, number: &str) -> Fields {
    let id = Bytes::default()
        .u8(10)
        .u32(1)
        .u8(if update { 2 } else { 1 })
        .u8(5)
        .text(name)
        .text(edition)
        .text(number);
    let id = id
        .fixed("20260101")
        .fixed("20260102")
        .fixed("03.1")
        .u8(1)
        .text("")
        .text("2.0")
        .u8(1)
        .u16(550)
        .text("made up");
    let structure = (0..8).fold(Bytes::default().u8(2).u8(1).u8(2), |bytes, _| bytes.u32(0));
    vec![("DSID", id.0), ("DSSI", structure.0)]
}

pub(crate) fn dspm() -> Fields {
    let bytes = Bytes::default().u8(20).u32(1).u8(2).u8(17).u8(23).u32(10_000).u8(1).u8(1).u8(1).u8(1);
    vec![("DSPM", bytes.u32(10_000_000).u32(10).text("").0)]
}

fn coordinates(points: &[(f64, f64)]) -> Vec<u8> {
    let one = |bytes: Bytes, (lat, lon): &(f64, f64)| {
        bytes.i32((lat * 1e7).round() as i32).i32((lon * 1e7).round() as i32)
    };
    points.iter().fold(Bytes::default(), one).0
}

pub(crate) fn vrid(kind: u8, id: u32, version: u16, instruction: u8) -> (&'static str, Vec<u8>) {
    ("VRID", Bytes::default().u8(kind).u32(id).u16(version).u8(instruction).0)
}

pub(crate) fn sg2d(points: &[(f64, f64)]) -> (&'static str, Vec<u8>) {
    ("SG2D", coordinates(points))
}

pub(crate) fn control(tag: &'static str, instruction: u8, index: u16, count: u16) -> (&'static str, Vec<u8>) {
    (tag, Bytes::default().u8(instruction).u16(index).u16(count).0)
}

pub(crate) fn node(id: u32, at: (f64, f64)) -> Fields {
    vec![vrid(120, id, 1, 1), sg2d(&[at])]
}

pub(crate) fn edge(id: u32, from: u32, to: u32, middle: &[(f64, f64)]) -> Fields {
    let pointer =
        |bytes: Bytes, (node, topology)| bytes.u8(120).u32(node).u8(255).u8(255).u8(topology).u8(255);
    let pointers = [(from, 1), (to, 2)].into_iter().fold(Bytes::default(), pointer);
    let mut fields = vec![vrid(130, id, 1, 1), ("VRPT", pointers.0)];
    if !middle.is_empty() {
        fields.push(sg2d(middle));
    }
    fields
}

pub(crate) fn attributes(list: &[(u16, &str)]) -> (&'static str, Vec<u8>) {
    ("ATTF", list.iter().fold(Bytes::default(), |bytes, (code, value)| bytes.u16(*code).text(value)).0)
}

pub(crate) fn frid(id: u32, primitive: u8, class: u16, version: u16, instruction: u8) -> Fields {
    let frid = Bytes::default().u8(100).u32(id).u8(primitive).u8(1).u16(class).u16(version).u8(instruction);
    vec![("FRID", frid.0), ("FOID", Bytes::default().u16(550).u32(id).u16(1).0)]
}

/// Pointers to edges: id, orientation, usage.
pub(crate) fn fspt(edges: &[(u32, u8, u8)]) -> (&'static str, Vec<u8>) {
    let one = |bytes: Bytes, (edge, orientation, usage): &(u32, u8, u8)| {
        bytes.u8(130).u32(*edge).u8(*orientation).u8(*usage).u8(2)
    };
    ("FSPT", edges.iter().fold(Bytes::default(), one).0)
}

pub(crate) fn area(id: u32, class: u16, list: &[(u16, &str)], edges: &[(u32, u8, u8)]) -> Fields {
    let mut fields = frid(id, 3, class, 1, 1);
    fields.push(attributes(list));
    fields.push(fspt(edges));
    fields
}

/// A feature at a connected node.
pub(crate) fn point(id: u32, class: u16, list: &[(u16, &str)], node: u32) -> Fields {
    let mut fields = frid(id, 1, class, 1, 1);
    fields.push(attributes(list));
    fields.push(("FSPT", Bytes::default().u8(120).u32(node).u8(255).u8(255).u8(255).0));
    fields
}

/// A cell of one square of water, 5 to 10 m deep, between two corners, all of whose edges are bare; more
/// records follow.
pub(crate) fn square(name: &str, south_west: (f64, f64), north_east: (f64, f64), more: &[Fields]) -> Vec<u8> {
    file(&square_records(name, south_west, north_east, more))
}

pub(crate) fn square_records(
    name: &str,
    (south, west): (f64, f64),
    (north, east): (f64, f64),
    more: &[Fields],
) -> Vec<Fields> {
    let ring = [(1, 1, 1), (2, 1, 1), (3, 1, 1), (4, 2, 1)];
    let mut records = vec![
        dsid(false, name, "1", "0"),
        dspm(),
        node(1, (south, west)),
        node(2, (north, west)),
        node(3, (north, east)),
        node(4, (south, east)),
        edge(1, 1, 2, &[]),
        edge(2, 2, 3, &[]),
        edge(3, 3, 4, &[]),
        edge(4, 1, 4, &[]),
        area(1, M_COVR, &[(18, "1")], &ring),
        area(2, DEPARE, &[(DRVAL1, "5"), (DRVAL2, "10")], &ring),
    ];
    records.extend_from_slice(more);
    records
}
