//! Detections read from files: our own tables (CSV and Parquet), and those that other receivers' programs and portals write.
//!
//! A file is read row by row; a row that cannot be understood is a problem with its line, its column and a remedy, and the rows
//! after it are read on, so that all problems are told at once. Whether to take anything of a file with problems is the caller's.

mod lines;
mod makers;
mod own;
mod pages;
mod parquet;
mod row;
#[cfg(test)]
mod tests;

use crate::csv::WrongCell;
use crate::study::Study;
use ::parquet::file::reader::ChunkReader;
use api::{Said, Wording, say};
use detections::Detection;
use lines::{Lines, Record};
use makers::Maker;
use row::{Columns, Row};
use std::io::{self, BufRead};

/// Most problems of a file that are told.
const PROBLEMS: usize = 1_000;
/// What a file of Parquet begins with.
const PARQUET: &[u8] = b"PAR1";

/// How it is decided which vessel or station a row is of.
pub struct Carriers<'c> {
    /// All rows are of this one.
    pub system: Option<u16>,
    /// Its address by a name, as the column `vessel` of our own tables has it.
    pub address: &'c dyn Fn(&str) -> Result<u16, Said>,
    /// Deployments of receivers, which decide for files without names of vessels, and say where a fixed station is.
    pub study: &'c Study,
}

/// What a file held.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ReadDetections {
    /// Detections.
    pub rows: u64,
    /// Rows of another kind, such as releases of animals.
    pub left_out: u64,
    /// What is wrong with others, up to 1,000.
    pub wrong: Vec<WrongCell>,
    /// Whether they are named by their rows, of which the first is 1, as a file without lines has them; 0 is the file itself.
    pub has_rows: bool,
}

/// What is wrong with a row: the column, and the text.
type Wrong = (String, Wording);

/// Takes a detection.
type Take<'t> = &'t mut dyn FnMut(Detection) -> io::Result<()>;

/// Kinds of files by what their rows are.
#[derive(Debug, Clone, Copy)]
enum Kind {
    Own,
    Of(&'static Maker),
}

/// Whether a file that begins so is a table of detections, or at least meant as one; the first line must be within `start`.
///
/// # Errors
/// It is a table, but not of detections as we know them.
pub fn is_detections(start: &[u8]) -> Result<bool, Wording> {
    if start.starts_with(PARQUET) {
        return Ok(true);
    }
    let first = start.split(|byte| *byte == b'\n').next().unwrap_or_default();
    let Ok(first) = std::str::from_utf8(first) else { return Ok(false) };
    if first.contains(|letter: char| letter.is_control() && letter != '\t' && letter != '\r') {
        return Ok(false);
    }
    let (mut lines, mut record) = (Lines::new(first.as_bytes()), Record::default());
    match lines.next(&mut record) {
        Ok(Some(Ok(()))) if record.len() > 1 => {}
        _ => return Ok(false),
    }
    if is_log(&record) { Ok(true) } else { kind(&Columns::of(&record)).map(|_| true) }
}

/// Whether the first line is that of a file of several tables.
fn is_log(first: &Record) -> bool {
    first.cell(0) == makers::LOG
}

fn kind(columns: &Columns) -> Result<Kind, Wording> {
    if own::KNOWN_BY.iter().all(|name| columns.has(name)) {
        return Ok(Kind::Own);
    }
    let found = makers::MAKERS.iter().find(|maker| maker.known_by.iter().all(|name| columns.has(name)));
    found.map(Kind::Of).ok_or_else(|| {
        say("these are not the columns of a table of detections that is known here: {columns}; give the file as the receiver's program wrote it (Thelma ComPort, VUE, Fathom, ETN, OTN), or a table of Lutra")
            .with("columns", columns.shown())
    })
}

/// Reads a table of comma-separated values.
///
/// # Errors
/// The input cannot be read, or `take` fails.
pub fn read_detections(
    input: impl BufRead,
    carriers: &Carriers<'_>,
    take: Take<'_>,
) -> io::Result<ReadDetections> {
    let (mut lines, mut record) = (Lines::new(input), Record::default());
    let mut reading = Reading { carriers, take, read: ReadDetections::default() };
    let mut table: Option<(Columns, Kind)> = None;
    let mut is_of_several = false;
    while let Some(next) = lines.next(&mut record)? {
        if let Err(text) = next {
            reading.wrong(record.line, (String::new(), text));
            // What comes after a quote that never closes, or in another coding, cannot be told apart.
            break;
        }
        if table.is_none() && is_log(&record) {
            is_of_several = true;
        } else if is_of_several && record.cell(0) == makers::LOG_HEADER {
            table = Some((Columns::of(&record), Kind::Of(&makers::FATHOM)));
        } else if is_of_several && record.cell(0) != makers::LOG_ROW {
            reading.read.left_out += u64::from(!record.cell(0).ends_with("_DESC"));
        } else if let Some((columns, kind)) = &table {
            reading.row(*kind, &Row::of_record(columns, &record, lines.has_decimal_comma()))?;
        } else if is_of_several {
            let text = say("comes before the line {header} that names its columns; export the file again")
                .with("header", makers::LOG_HEADER);
            reading.wrong(record.line, (String::new(), text));
            break;
        } else {
            let columns = Columns::of(&record);
            match kind(&columns) {
                Ok(kind) => table = Some((columns, kind)),
                Err(text) => {
                    reading.wrong(record.line, (String::new(), text));
                    break;
                }
            }
        }
    }
    if record.line == 0 {
        reading.wrong(1, (String::new(), say("the file is empty; its first line names the columns")));
    }
    Ok(reading.read)
}

/// Reads a table of Parquet, as we write it. Lines are counted from its header on, as in a CSV file.
///
/// # Errors
/// The input cannot be read, is not Parquet or cut, or `take` fails.
pub fn read_parquet<R: ChunkReader + 'static>(
    input: R,
    carriers: &Carriers<'_>,
    take: Take<'_>,
) -> io::Result<ReadDetections> {
    let read = ReadDetections { has_rows: true, ..ReadDetections::default() };
    let mut reading = Reading { carriers, take, read };
    let columns = parquet::columns(&input)?;
    match kind(&columns) {
        Ok(Kind::Own) => parquet::each(input, &columns, &mut |row| reading.row(Kind::Own, row))?,
        Ok(Kind::Of(_)) | Err(_) => {
            let text = say(
                "this Parquet file does not have the columns of Lutra's; download it with format=parquet",
            );
            reading.wrong(0, (String::new(), text));
        }
    }
    Ok(reading.read)
}

/// A file that is being read.
struct Reading<'r> {
    carriers: &'r Carriers<'r>,
    take: Take<'r>,
    read: ReadDetections,
}

impl Reading<'_> {
    fn wrong(&mut self, line: u32, (column, text): Wrong) {
        if self.read.wrong.len() < PROBLEMS {
            self.read.wrong.push(WrongCell { line, column, text });
        }
    }

    fn row(&mut self, kind: Kind, row: &Row<'_>) -> io::Result<()> {
        let made = row.is_whole().and_then(|()| match kind {
            Kind::Own => own::detection(row, self.carriers).map(Some),
            Kind::Of(maker) => maker.detection(row, self.carriers),
        });
        match made {
            Ok(Some(one)) => {
                self.read.rows += 1;
                (self.take)(one)?;
            }
            Ok(None) => self.read.left_out += 1,
            Err(wrong) => self.wrong(row.line, wrong),
        }
        Ok(())
    }
}
