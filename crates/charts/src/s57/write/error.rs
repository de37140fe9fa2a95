//! Why a draft cannot be written.

use crate::iso8211::{LexicalLevel, Tag};

/// A draft's value that no S-57 file can hold.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WriteError {
    /// A character that the lexical level does not have, or that ends subfields and fields.
    #[error(
        "{character:?} cannot be written in lexical level {level:?}; take a higher level or another character"
    )]
    Character {
        /// The character.
        character: char,
        /// The level of the text it stands in.
        level: LexicalLevel,
    },
    /// A text of fixed length has another.
    #[error("{text:?} has not {width} characters; give exactly so many")]
    Width {
        /// The text.
        text: String,
        /// How many characters it must have.
        width: usize,
    },
    /// A position or depth beyond the numbers of the file.
    #[error(
        "{value} times the factor {factor} is beyond four bytes; take a smaller factor or a nearer position"
    )]
    Coordinate {
        /// Degrees or metres.
        value: f64,
        /// The coordinate or sounding factor.
        factor: u32,
    },
    /// A list control counts further than two bytes.
    #[error("index or count {0} of a list is beyond 65535; edit the list in parts")]
    Control(usize),
    /// More than one edit of one list in one record; readers take the first and leave the others out.
    #[error("a record has room for one {0}; make a change of its own of each edit of a list")]
    Edits(Tag),
    /// A field that the entry map has no digits for.
    #[error("field {tag} needs {digits} digits in the directory; give the entry map more")]
    EntryMap {
        /// The field.
        tag: Tag,
        /// Digits of its length or position.
        digits: usize,
    },
}
