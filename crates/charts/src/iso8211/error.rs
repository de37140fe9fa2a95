//! What can be wrong with a container, where, and what to do about it.

use super::tag::Tag;

/// A fault at a place of the file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("record {record} at byte {offset}: {problem}; {}", problem.remedy())]
pub struct Iso8211Error {
    /// Which record, counted from 0 (the data descriptive record).
    pub record: usize,
    /// Byte of the file at which the fault lies.
    pub offset: usize,
    /// What is wrong.
    pub problem: Iso8211Problem,
}

/// What is wrong with a container.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Iso8211Problem {
    /// The file is empty.
    #[error("the file is empty")]
    Empty,
    /// The first record is not a data descriptive record.
    #[error("this is not an ISO 8211 file: the leader identifier is {0:?}, not 'L'")]
    NotADescription(char),
    /// A later record is not a data record.
    #[error("the leader identifier is {0:?}, not 'D'")]
    NotData(char),
    /// A number of a leader or directory is not written in digits.
    #[error("the {0} is not a decimal number")]
    Number(&'static str),
    /// A leader's numbers contradict each other or the file.
    #[error("the record is {length} bytes long with fields from {base}, but {left} bytes are left")]
    Extent {
        /// Record length by its leader.
        length: usize,
        /// Base address by its leader.
        base: usize,
        /// Bytes from the start of the record to the end of the file.
        left: usize,
    },
    /// The entry map has sizes this reader cannot use.
    #[error("the directory's entry map is length {length}, position {position}, tag {tag}")]
    EntryMap {
        /// Digits of a field's length.
        length: usize,
        /// Digits of a field's position.
        position: usize,
        /// Characters of a tag.
        tag: usize,
    },
    /// The directory does not end in a field terminator.
    #[error("the directory does not end where the fields begin")]
    Directory,
    /// A field lies outside its record.
    #[error("field {tag} of {length} bytes at {position} lies outside the record")]
    FieldExtent {
        /// The field.
        tag: Tag,
        /// Its length.
        length: usize,
        /// Its position after the base address.
        position: usize,
    },
    /// A field does not end in a terminator.
    #[error("field {0} does not end in a field terminator")]
    Unterminated(Tag),
    /// A subfield ends beyond its field.
    #[error("field {tag} ends inside its subfield {label}")]
    Short {
        /// The field.
        tag: Tag,
        /// The subfield.
        label: String,
    },
    /// A subfield that should hold a number does not.
    #[error("subfield {label} of field {tag} is not a number")]
    Subfield {
        /// The field.
        tag: Tag,
        /// The subfield.
        label: String,
    },
    /// The description of a field is not understood.
    #[error("field {tag} is described by {formats:?}, which is not a format")]
    Description {
        /// The field.
        tag: Tag,
        /// Its formats as written.
        formats: String,
    },
    /// A field is used that the data descriptive record does not describe.
    #[error("field {0} is not described at the head of the file")]
    Undescribed(Tag),
}

impl Iso8211Problem {
    /// What the reader of the message can do.
    pub fn remedy(&self) -> &'static str {
        match self {
            Self::Empty => "fetch the file again: the download or copy broke off",
            Self::NotADescription(_) => {
                "give an S-57 cell (.000), update (.001 ...) or CATALOG.031, unzipped and undecrypted"
            }
            Self::NotData(_) | Self::Number(_) | Self::Extent { .. } | Self::Directory => {
                "the file is cut or damaged: fetch it again and compare its length or checksum"
            }
            Self::EntryMap { .. } => "S-57 files have tags of 4 characters: check that this is one",
            Self::FieldExtent { .. } | Self::Unterminated(_) | Self::Short { .. } | Self::Subfield { .. } => {
                "the record is damaged: fetch the file again; if it stays so, tell the chart's producer"
            }
            Self::Description { .. } | Self::Undescribed(_) => {
                "the file follows another product than S-57 edition 3.1: ask its producer for an ENC"
            }
        }
    }
}
