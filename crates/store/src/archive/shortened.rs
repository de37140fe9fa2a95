//! Days of which the archive holds less than it once did: `archive/shortened.jsonl`, a line of JSON for each.
//!
//! Data lost from the archive is lost for good, and the next start can no longer see that it was there. So the loss is
//! recorded, and reported until an operator removes the file.

use super::{DATA, DayKey, Lengths, bytes};
use crate::error::{Named as _, Result, StoreError};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::Write as _;
use std::path::Path;

/// The file's name.
pub(crate) const SHORTENED: &str = "shortened.jsonl";

/// Adds a day that held `was` bytes of packets and holds `is`.
pub(crate) fn add(archive: &Path, day: &str, was: u64, is: u64) -> Result<()> {
    let path = archive.join(SHORTENED);
    let line = json!({ "day": day, "was_bytes": was, "is_bytes": is });
    let append = || -> std::io::Result<()> {
        let mut file = OpenOptions::new().append(true).create(true).open(&path)?;
        file.write_all(format!("{line}\n").as_bytes())?;
        file.sync_all()
    };
    append().named(&path)?;
    File::open(archive).and_then(|folder| folder.sync_all()).named(archive)
}

/// Bytes of packets that a day held once, and that it holds.
pub(crate) type Bytes = (u64, u64);

/// The days that are written down, by their names.
pub(crate) fn written(archive: &Path) -> Result<BTreeMap<String, Bytes>> {
    let path = archive.join(SHORTENED);
    let text = match fs::read(&path) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(BTreeMap::new()),
        other => other.named(&path)?,
    };
    let mut days = BTreeMap::new();
    for line in String::from_utf8_lossy(&text).lines() {
        let Ok(value) = serde_json::from_str::<Value>(line) else { continue };
        let bytes = |name: &str| value[name].as_u64();
        if let (Some(day), Some(was), Some(is)) =
            (value["day"].as_str(), bytes("was_bytes"), bytes("is_bytes"))
        {
            merge(&mut days, day.to_owned(), (was, is));
        }
    }
    Ok(days)
}

/// Days of which less lies on the disk than the history once read, whether or not that is written down yet. `read` has the
/// days and what was read of each.
pub(crate) fn seen(
    archive: &Path,
    read: impl Iterator<Item = (DayKey, Lengths)>,
) -> Result<BTreeMap<String, Bytes>> {
    let mut days = written(archive)?;
    for (key, lengths) in read {
        let is = match bytes::plain_bytes(&key.folder(archive), DATA) {
            Ok(bytes) => bytes.unwrap_or(0),
            Err(StoreError::Io { source, .. }) if source.kind() == std::io::ErrorKind::InvalidData => 0,
            // It may be whole, and cannot be read now.
            Err(_) => continue,
        };
        if is < lengths.data {
            merge(&mut days, key.name(), (lengths.data, is));
        }
    }
    Ok(days)
}

fn merge(days: &mut BTreeMap<String, Bytes>, day: String, (was, is): Bytes) {
    let known = days.entry(day).or_insert((was, is));
    *known = (known.0.max(was), known.1.min(is));
}

/// The report for each day.
pub(crate) fn told(days: BTreeMap<String, Bytes>) -> Vec<String> {
    let told = |(day, (was, is)): (String, Bytes)| {
        format!("archive/{day}: of {was} bytes that were once on the disk, {is} were left")
    };
    days.into_iter().map(told).collect()
}
