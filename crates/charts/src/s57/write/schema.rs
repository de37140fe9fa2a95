//! The fields of S-57 and their description at the head of a file (S-57 part 3, annex A and 7.2).

use super::container::FieldBytes;
use crate::iso8211::{FIELD_TERMINATOR, LexicalLevel, Tag, UNIT_TERMINATOR};

/// One field: tag, parent in the tree, name, labels, formats.
struct Described(&'static str, &'static str, &'static str, &'static str, &'static str);

#[rustfmt::skip]
const FIELDS: &[Described] = &[
    Described("DSID", "0001", "Data set identification field",
        "RCNM!RCID!EXPP!INTU!DSNM!EDTN!UPDN!UADT!ISDT!STED!PRSP!PSDN!PRED!PROF!AGEN!COMT",
        "(b11,b14,2b11,3A,2A(8),R(4),b11,2A,b11,b12,A)"),
    Described("DSSI", "DSID", "Data set structure information field",
        "DSTR!AALL!NALL!NOMR!NOCR!NOGR!NOLR!NOIN!NOCN!NOED!NOFA", "(3b11,8b14)"),
    Described("DSPM", "0001", "Data set parameter field",
        "RCNM!RCID!HDAT!VDAT!SDAT!CSCL!DUNI!HUNI!PUNI!COUN!COMF!SOMF!COMT",
        "(b11,b14,3b11,b14,4b11,2b14,A)"),
    Described("VRID", "0001", "Vector record identifier field", "RCNM!RCID!RVER!RUIN", "(b11,b14,b12,b11)"),
    Described("ATTV", "VRID", "Vector record attribute field", "*ATTL!ATVL", "(b12,A)"),
    Described("VRPC", "VRID", "Vector record pointer control field", "VPUI!VPIX!NVPT", "(b11,2b12)"),
    Described("VRPT", "VRID", "Vector record pointer field", "*NAME!ORNT!USAG!TOPI!MASK", "(B(40),4b11)"),
    Described("SGCC", "VRID", "Coordinate control field", "CCUI!CCIX!CCNC", "(b11,2b12)"),
    Described("SG2D", "VRID", "2-D coordinate field", "*YCOO!XCOO", "(2b24)"),
    Described("SG3D", "VRID", "3-D coordinate (sounding array) field", "*YCOO!XCOO!VE3D", "(3b24)"),
    Described("FRID", "0001", "Feature record identifier field",
        "RCNM!RCID!PRIM!GRUP!OBJL!RVER!RUIN", "(b11,b14,2b11,2b12,b11)"),
    Described("FOID", "FRID", "Feature object identifier field", "AGEN!FIDN!FIDS", "(b12,b14,b12)"),
    Described("ATTF", "FRID", "Feature record attribute field", "*ATTL!ATVL", "(b12,A)"),
    Described("NATF", "FRID", "Feature record national attribute field", "*ATTL!ATVL", "(b12,A)"),
    Described("FFPC", "FRID", "Feature record to feature object pointer control field",
        "FFUI!FFIX!NFPT", "(b11,2b12)"),
    Described("FFPT", "FRID", "Feature record to feature object pointer field",
        "*LNAM!RIND!COMT", "(B(64),b11,A)"),
    Described("FSPC", "FRID", "Feature record to spatial record pointer control field",
        "FSUI!FSIX!NSPT", "(b11,2b12)"),
    Described("FSPT", "FRID", "Feature record to spatial record pointer field",
        "*NAME!ORNT!USAG!MASK", "(B(40),3b11)"),
];

/// Fields of the data descriptive record.
pub(super) fn description(attributes: LexicalLevel, national: LexicalLevel) -> Vec<FieldBytes> {
    let mut tree = b"0000;&   ".to_vec();
    tree.push(UNIT_TERMINATOR);
    for Described(tag, parent, ..) in FIELDS {
        tree.extend(parent.bytes().chain(tag.bytes()));
    }
    tree.push(FIELD_TERMINATOR);
    let record = b"0500;&   ISO/IEC 8211 Record Identifier\x1f\x1f(b12)\x1e".to_vec();
    let mut fields = vec![(Tag(*b"0000"), tree), (Tag(*b"0001"), record)];
    for Described(tag, _, name, labels, formats) in FIELDS {
        let structure = if labels.starts_with('*') { '2' } else { '1' };
        // Only the coordinates are of one type (binary); all others are mixed.
        let kind = if matches!(*tag, "SG2D" | "SG3D") { '5' } else { '6' };
        let escape = match *tag {
            "ATTF" | "ATTV" => escape(attributes),
            "NATF" => escape(national),
            _ => "   ",
        };
        let text = format!("{structure}{kind}00;&{escape}{name}\u{1f}{labels}\u{1f}{formats}\u{1e}");
        let tag = tag.as_bytes().try_into().expect("invariant: tags have four letters");
        fields.push((Tag(tag), text.into_bytes()));
    }
    fields
}

/// The truncated escape sequence that announces a character set.
fn escape(level: LexicalLevel) -> &'static str {
    match level {
        LexicalLevel::Ascii => "   ",
        LexicalLevel::Latin1 => "-A ",
        LexicalLevel::Ucs2 => "%/A",
    }
}
