//! The dialects of CSV.

/// The byte order mark, by which spreadsheets know UTF-8.
const MARK: &[u8] = "\u{FEFF}".as_bytes();

/// How the cells of a table are separated, and its numbers written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Dialect {
    /// RFC 4180: commas, decimal points, no mark. What programs read.
    #[default]
    Plain,
    /// For spreadsheets where the decimal sign is a point: the same with a byte order mark.
    SpreadsheetPoint,
    /// For spreadsheets where the decimal sign is a comma, as in most of Europe: a byte order mark, semicolons, decimal commas.
    SpreadsheetComma,
}

impl Dialect {
    /// The separator of cells.
    pub fn separator(self) -> u8 {
        if self == Self::SpreadsheetComma { b';' } else { b',' }
    }

    /// The decimal mark.
    pub fn decimal(self) -> u8 {
        if self == Self::SpreadsheetComma { b',' } else { b'.' }
    }

    /// The start of a file.
    pub fn mark(self) -> &'static [u8] {
        if self == Self::Plain { b"" } else { MARK }
    }
}

/// How cells are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Format {
    /// The reader of the table.
    pub dialect: Dialect,
    /// Whether text that a spreadsheet would take for a formula gets an apostrophe before it.
    pub guard: bool,
}

impl Default for Format {
    fn default() -> Self {
        Self { dialect: Dialect::Plain, guard: true }
    }
}

impl Format {
    /// Ends a cell that another follows.
    #[inline]
    pub fn next(self, out: &mut Vec<u8>) {
        out.push(self.dialect.separator());
    }

    /// So many empty cells after the one that was begun.
    pub fn skip(self, out: &mut Vec<u8>, cells: usize) {
        out.extend(std::iter::repeat_n(self.dialect.separator(), cells));
    }
}
