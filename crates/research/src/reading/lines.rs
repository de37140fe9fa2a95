//! Records of comma-separated values, one after another, in constant memory.

use api::{Wording, say};
use std::io::{self, BufRead, Read as _};

/// Bytes of a record at most; in other tables of a cell. An IMC packet has room for three times as much.
pub(super) const LONGEST: usize = 8 << 10;
/// Cells of a record at most.
const CELLS: usize = 200;

/// A line of a table, or several where a quoted cell goes on.
#[derive(Debug, Default)]
pub(super) struct Record {
    /// Where it begins, from 1.
    pub(super) line: u32,
    /// As it came, without its end.
    pub(super) raw: String,
    /// All cells, without quotes, one behind another.
    text: String,
    /// Where each ends.
    ends: Vec<usize>,
    /// Whether a line end came after it; a whole file may lack it after its last record.
    pub(super) is_ended: bool,
}

impl Record {
    /// Cells.
    pub(super) fn len(&self) -> usize {
        self.ends.len()
    }

    /// A cell, trimmed. One that the record lacks is empty.
    pub(super) fn cell(&self, at: usize) -> &str {
        self.exact(at).trim()
    }

    /// A cell as it stands.
    pub(super) fn exact(&self, at: usize) -> &str {
        let Some(end) = self.ends.get(at) else { return "" };
        let begin = at.checked_sub(1).and_then(|before| self.ends.get(before)).copied().unwrap_or(0);
        self.text.get(begin..*end).unwrap_or_default()
    }

    /// Divides `raw` into cells. Whether it could: a line end outside of a quoted cell divides nothing.
    fn divide(&mut self, separator: char) -> bool {
        self.text.clear();
        self.ends.clear();
        let (mut quoted, mut divides) = (false, true);
        let mut letters = self.raw.chars().peekable();
        while let Some(letter) = letters.next() {
            let begin = self.ends.last().copied().unwrap_or(0);
            match letter {
                '"' if quoted => {
                    if letters.next_if_eq(&'"').is_some() {
                        self.text.push('"');
                    } else {
                        quoted = false;
                    }
                }
                '"' if self.text.len() == begin => quoted = true,
                letter if letter == separator && !quoted => self.ends.push(self.text.len()),
                letter => {
                    divides &= quoted || letter != '\n';
                    self.text.push(letter);
                }
            }
        }
        self.ends.push(self.text.len());
        divides && !quoted
    }
}

/// The records of a file. Empty lines, and those of nothing but separators, are passed over.
pub(super) struct Lines<R> {
    input: R,
    line: u32,
    /// Known from the first line on.
    separator: Option<char>,
    bytes: Vec<u8>,
}

impl<R: BufRead> Lines<R> {
    pub(super) fn new(input: R) -> Self {
        Self { input, line: 0, separator: None, bytes: Vec::new() }
    }

    /// Whether numbers have decimal commas: between semicolons they do.
    pub(super) fn has_decimal_comma(&self) -> bool {
        self.separator == Some(';')
    }

    /// The next record; `None` at the end. A text where it cannot be divided: nothing can be read after it.
    ///
    /// # Errors
    /// The input cannot be read.
    pub(super) fn next(&mut self, record: &mut Record) -> io::Result<Option<Result<(), Wording>>> {
        loop {
            record.line = self.line + 1;
            match self.whole()? {
                Some(Ok(())) => {}
                other => {
                    if other.is_none() && self.line > 0 {
                        record.line = self.line;
                    } else if other.is_none() {
                        record.line = 0;
                    }
                    return Ok(other);
                }
            }
            let Ok(text) = std::str::from_utf8(&self.bytes) else {
                let text = say("is not UTF-8 from here on; save the file as \"CSV UTF-8\"");
                return Ok(Some(Err(text)));
            };
            record.is_ended = text.ends_with('\n');
            let text = text.strip_prefix('\u{FEFF}').unwrap_or(text).trim_end_matches(['\r', '\n']);
            record.raw.clear();
            record.raw.push_str(text);
            let separator = *self.separator.get_or_insert_with(|| separator(text));
            if !record.divide(separator) {
                let text = say(
                    "a `\"` within a cell joins lines from here on; double it (`\"\"`) and quote the cell, or take it out",
                );
                return Ok(Some(Err(text)));
            }
            if record.len() > CELLS {
                let text = say("has {n} cells, a table at most {most}; look at its separators")
                    .with("n", record.len())
                    .with("most", CELLS);
                return Ok(Some(Err(text)));
            }
            if !record.text.trim().is_empty() {
                return Ok(Some(Ok(())));
            }
        }
    }

    /// Reads lines until all quotes are closed.
    fn whole(&mut self) -> io::Result<Option<Result<(), Wording>>> {
        self.bytes.clear();
        let mut is_open = false;
        loop {
            let before = self.bytes.len();
            let room = (LONGEST + 1).saturating_sub(before) as u64;
            let read = self.input.by_ref().take(room).read_until(b'\n', &mut self.bytes)?;
            if read == 0 && before == 0 {
                return Ok(None);
            }
            is_open = self.bytes[before..].iter().fold(is_open, |open, byte| open != (*byte == b'"'));
            if self.bytes.len() > LONGEST || (read == 0 && is_open) {
                let text = if is_open {
                    say("a quote that opens here is never closed; look for a `\"` too many")
                } else {
                    say("is longer than {most} bytes; this is not a table of detections")
                        .with("most", LONGEST)
                };
                self.line += 1;
                return Ok(Some(Err(text)));
            }
            self.line += 1;
            if !is_open {
                return Ok(Some(Ok(())));
            }
        }
    }
}

/// What stands between the cells of a header.
fn separator(header: &str) -> char {
    let count = |separator: &char| header.chars().filter(|letter| letter == separator).count();
    ['\t', ';', ','].into_iter().max_by_key(count).unwrap_or(',')
}
