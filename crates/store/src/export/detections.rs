//! Detections one after another, the oldest report first, in constant memory: for files of them. And which state the messages
//! are in that carry them.

use super::select::Selection;
use super::version::table_version;
use crate::error::Result;
use crate::range::TimeRange;
use crate::reader::{DetectionsWanted, Memory, Order, Page, Reader};
use ::detections::Detection;
use std::path::Path;

/// Detections that are read at once, and the bytes of their texts.
const PAGE: Page = Page { skip: 0, rows: 2_000, bytes: 1 << 20 };

/// Gives each selected detection, with the name that its vessel announced.
///
/// # Errors
/// When the history cannot be read, or what `give` says.
pub fn each_detection(
    data: &Path,
    wanted: &DetectionsWanted,
    give: &mut dyn FnMut(Detection, &str) -> Result<()>,
) -> Result<()> {
    let mut reader = Reader::open_with(data, Memory::EXPORT)?;
    let known = reader.names()?;
    let mut wanted = wanted.clone();
    let mut page = PAGE;
    loop {
        let found = reader.detections_of(&wanted, Order::Oldest, page)?;
        for one in found.items {
            let name = known.system(one.origin.system);
            give(one, &name)?;
        }
        let Some(next) = found.next else { return Ok(()) };
        wanted.range.from_us = next.time_us;
        page.skip = next.skip;
    }
}

/// The months since 1970 that the history has, the oldest first.
///
/// # Errors
/// When the history cannot be read.
pub fn months(reader: &mut Reader) -> Result<Vec<TimeRange>> {
    let dated = TimeRange { from_us: 0, to_us: i64::MAX };
    Ok(reader.parts(dated)?.into_iter().map(|(_, part)| part).collect())
}

/// A number for the messages of a range that can report detections: it changes when some came or went.
///
/// # Errors
/// When the history cannot be read.
pub fn acoustic_version(reader: &mut Reader, range: TimeRange) -> Result<u64> {
    let messages = ["TBRFishTag", "Event"].map(str::to_owned).to_vec();
    table_version(reader, &Selection { messages, range, ..Selection::default() })
}
