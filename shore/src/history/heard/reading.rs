//! Tables of detections as packets, which then come into the archive as those of a log do: what is there already is not added
//! twice.

use api::{Said, say};
use imc::{Header, Packet};
use research::{Carriers, ReadDetections, read_detections, read_parquet};
use std::fs::File;
use std::io::{self, BufReader, Read as _, Seek as _, Write};
use std::path::Path;

/// What a file of Parquet begins with.
const PARQUET: &[u8] = b"PAR1";
/// Most problems in the text of a refusal.
const TOLD: usize = 20;

/// Writes a packet for each detection of a table: of our own as CSV or Parquet, or of another receiver's program. The caller
/// leaves the packets where the answer has problems.
///
/// # Errors
/// The file cannot be read, or `out` not be written.
pub fn packets(file: &Path, carriers: &Carriers<'_>, out: &mut dyn Write) -> io::Result<ReadDetections> {
    let mut input = File::open(file)?;
    let mut start = Vec::new();
    (&input).take(PARQUET.len() as u64).read_to_end(&mut start)?;
    input.rewind()?;
    let take = &mut |one: detections::Detection| {
        let (timestamp, src, src_ent) = (one.origin.reported.seconds(), one.origin.system, one.origin.entity);
        let header = Header { timestamp, src, src_ent, ..Header::default() };
        let packet = Packet::new(header, one.report()).encode().map_err(|error| {
            let text =
                format!("the detection {} does not fit into a packet ({error}): shorten its texts", one.id());
            io::Error::new(io::ErrorKind::InvalidData, text)
        })?;
        out.write_all(&packet)
    };
    if start == PARQUET {
        read_parquet(input, carriers, take)
    } else {
        read_detections(BufReader::with_capacity(1 << 20, input), carriers, take)
    }
}

/// Why nothing is taken of a table; `None` where nothing is wrong with it.
pub fn refusal(read: &ReadDetections) -> Option<Said> {
    if read.wrong.is_empty() {
        if read.rows > 0 {
            return None;
        }
        return Some(say("The table has no detections; look at the time and the receivers that were chosen when it was written.").into());
    }
    let count = read.wrong.len();
    let told = read.wrong.iter().take(TOLD).map(|one| {
        let text = Said::from(one.text.clone());
        let text = if one.column.is_empty() { text } else { text.of_field(&one.column) };
        let place = match (read.has_rows, one.line) {
            (true, 0) => return text,
            (true, _) => say("row {line}, {text}"),
            (false, _) => say("line {line}, {text}"),
        };
        place.with("line", one.line).with_said("text", text).into()
    });
    let more = (count > TOLD).then(|| say("… and {n} more").with("n", count - TOLD).into());
    let text = if count == 1 {
        say("Nothing was imported from the file, which has 1 problem:\n{problems}")
    } else {
        say("Nothing was imported from the file, which has {count} problems:\n{problems}")
    };
    Some(text.with("count", count).with_lines("problems", told.chain(more)).into())
}
