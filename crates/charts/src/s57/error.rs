//! What can be wrong with a cell, an update or an exchange set, and what to do about it.

use super::codes::ObjectClass;
use crate::iso8211::Iso8211Error;

/// Where in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    /// Record, counted from 0 (the data descriptive record).
    pub record: usize,
    /// Byte of the file at which the record or field starts.
    pub offset: usize,
}

/// A fault of a named file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct S57Error {
    /// The file.
    pub file: String,
    /// Where in it, if at one place.
    pub place: Option<Place>,
    /// What is wrong.
    pub problem: S57Problem,
}

impl std::fmt::Display for S57Error {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.file)?;
        if let Some(Place { record, offset }) = self.place {
            write!(f, ", record {record} at byte {offset}")?;
        }
        write!(f, ": {}", self.problem)?;
        self.problem.remedy().map_or(Ok(()), |remedy| write!(f, "; {remedy}"))
    }
}

impl std::error::Error for S57Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        if let S57Problem::Container(error) = &self.problem { Some(error) } else { None }
    }
}

/// What is wrong with a cell, an update or an exchange set.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum S57Problem {
    /// The container is damaged; its message has place and remedy.
    #[error("{0}")]
    Container(Iso8211Error),
    /// A field has other subfields than S-57 gives it.
    #[error("field {tag} has the subfields {found}, not {expected}")]
    Labels {
        /// The field.
        tag: &'static str,
        /// What S-57 says.
        expected: &'static str,
        /// What the file says.
        found: String,
    },
    /// The file is of the all-ASCII form of S-57.
    #[error("the coordinates are written in the ASCII form of S-57")]
    AsciiForm,
    /// The file has no identification.
    #[error("the file has no data set identification (field DSID)")]
    NoIdentification,
    /// The base cell has no parameters.
    #[error("the cell has no data set parameters (field DSPM)")]
    NoParameters,
    /// A parameter has a value that would make every position or depth wrong.
    #[error("{name} is {value}, not {expected}")]
    Parameter {
        /// The parameter.
        name: &'static str,
        /// Its value.
        value: i64,
        /// What can be read.
        expected: &'static str,
    },
    /// A number lies outside the range of its meaning.
    #[error("{what} is out of range")]
    Range {
        /// Which number.
        what: &'static str,
    },
    /// A name points to nothing of that kind.
    #[error("{kind} {id} is {what}")]
    Record {
        /// Feature, node or edge.
        kind: &'static str,
        /// Its record identification number.
        id: u32,
        /// What is wrong with it.
        what: &'static str,
    },
    /// The file ends before the last of the records that its head announces.
    #[error("the head of the file announces {announced} {what}, but it has only {found}")]
    Cut {
        /// Kind of records.
        what: &'static str,
        /// By the head.
        announced: u32,
        /// In the file.
        found: u32,
    },
    /// The file that should be a base cell is an update.
    #[error("the file is an update, not a base cell")]
    NotABase,
    /// The file that should be an update is a base cell.
    #[error("the file is a base cell, not an update")]
    NotAnUpdate,
    /// The update belongs to another cell.
    #[error("the update is for cell {found}, not {expected}")]
    OtherCell {
        /// The cell to be updated.
        expected: String,
        /// The cell that the update names.
        found: String,
    },
    /// The update belongs to another edition.
    #[error("the update is for edition {found}, but the cell is edition {expected}")]
    OtherEdition {
        /// The cell's edition.
        expected: String,
        /// The update's.
        found: String,
    },
    /// An update is missing or out of order.
    #[error("this is update {found}, but the next must be update {expected}")]
    OutOfOrder {
        /// The number that must come next.
        expected: u32,
        /// The number that came.
        found: u32,
    },
    /// The producer has withdrawn the cell.
    #[error("the producer has cancelled this cell (edition 0)")]
    Cancelled,
    /// The assembled geometry would be out of all proportion to the file.
    #[error("the geometry has more than {0} vertices, far more than the file can mean")]
    TooLarge(usize),
    /// The bytes do not have the checksum that the catalogue gives.
    #[error("the checksum is {found:08X}, but the catalogue gives {expected:08X}")]
    Checksum {
        /// By the catalogue.
        expected: u32,
        /// Of the bytes.
        found: u32,
    },
    /// A line that leads the long way round the globe.
    #[error("{class} {record} has an edge over more than 180 degrees of longitude")]
    Span {
        /// The object's class.
        class: ObjectClass,
        /// Its record number.
        record: u32,
    },
    /// A hazard has no position, and no earlier one is known.
    #[error("{class} {record} has no position that can be read, and what it is must be kept clear of")]
    Nowhere {
        /// The object's class.
        class: ObjectClass,
        /// Its record number.
        record: u32,
    },
    /// A hazard, or the coverage, has a geometry of which a part is in no file.
    #[error(
        "{class} {record} has a boundary or line of which a part is missing, so it is not known how far it reaches"
    )]
    Incomplete {
        /// The object's class.
        class: ObjectClass,
        /// Its record number.
        record: u32,
    },
    /// A cell without what makes it a chart of the sea.
    #[error("the cell has no depth areas or does not say where it has data (M_COVR)")]
    NoWater,
    /// A record that must be unique is there twice.
    #[error("the {what} is there twice")]
    Twice {
        /// What, and its field.
        what: &'static str,
    },
    /// Updates without a base.
    #[error("there are updates but no base cell (.000)")]
    NoBase,
}

impl S57Problem {
    /// What the reader of the message can do; `None` where the message has it already.
    pub fn remedy(&self) -> Option<&'static str> {
        Some(match self {
            Self::Container(_) => return None,
            Self::Labels { .. } | Self::AsciiForm => {
                "ask the producer for an ENC in the binary form of S-57 edition 3.1"
            }
            Self::NoIdentification | Self::NoParameters => {
                "the file is cut or no cell: fetch it again from the producer"
            }
            Self::Cut { .. } => "the file is cut: fetch it again from the producer",
            Self::Parameter { .. } => "only charts on WGS 84 in degrees and metres are read: ask for an ENC",
            Self::Range { .. } => "the file is damaged: fetch it again",
            Self::Record { .. } => {
                "cell and updates do not fit together: fetch the base cell and all its updates again"
            }
            Self::NotABase => "give the file that ends in .000 first",
            Self::NotAnUpdate => "import it as a cell of its own",
            Self::OtherCell { .. } => "give the updates of this cell only",
            Self::OtherEdition { .. } => {
                "fetch the base cell of the update's edition, and remove updates of older editions"
            }
            Self::OutOfOrder { .. } => "fetch the missing update, or the newest re-issue of the base cell",
            Self::Cancelled => "remove the cell from the chart set and look for the cell that replaces it",
            Self::TooLarge(_) => "the file is damaged or hostile: fetch it again from its producer",
            Self::Checksum { .. } => {
                "the file was changed or damaged on its way: fetch the exchange set again"
            }
            Self::Span { .. } => "ask the producer for a cell that is divided at 180 degrees east",
            Self::Nowhere { .. } | Self::Incomplete { .. } => {
                "ask the producer for a cell and updates that fit together"
            }
            Self::NoWater => "fetch it again, or ask the producer for an ENC",
            Self::Twice { .. } => "the file is damaged: fetch it again from the producer",
            Self::NoBase => "add the base cell to the folder of its updates",
        })
    }
}
