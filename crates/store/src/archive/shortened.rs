//! Days of which the archive holds less than it once did: `archive/shortened.jsonl`, a line of JSON for each.
//!
//! What is gone from the archive is gone for good, and the next start cannot see it any more. So it is written down,
//! and told until somebody removes the file.

use super::DayKey;
use crate::error::{Named as _, Result};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::Write as _;
use std::path::Path;

/// The file's name.
pub(crate) const SHORTENED: &str = "shortened.jsonl";

/// Adds a day that held `was` bytes of packets and holds `is`.
pub(crate) fn add(archive: &Path, key: DayKey, was: u64, is: u64) -> Result<()> {
    let path = archive.join(SHORTENED);
    let line = json!({ "day": key.name(), "was_bytes": was, "is_bytes": is });
    let append = || -> std::io::Result<()> {
        let mut file = OpenOptions::new().append(true).create(true).open(&path)?;
        file.write_all(format!("{line}\n").as_bytes())?;
        file.sync_all()
    };
    append().named(&path)?;
    File::open(archive).and_then(|folder| folder.sync_all()).named(archive)
}

/// What is to be told of each day, by its name.
pub(crate) fn told(archive: &Path) -> Result<Vec<String>> {
    let path = archive.join(SHORTENED);
    let text = match fs::read(&path) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        other => other.named(&path)?,
    };
    let mut days: BTreeMap<String, (u64, u64)> = BTreeMap::new();
    for line in String::from_utf8_lossy(&text).lines() {
        let Ok(value) = serde_json::from_str::<Value>(line) else { continue };
        let bytes = |name: &str| value[name].as_u64();
        if let (Some(day), Some(was), Some(is)) =
            (value["day"].as_str(), bytes("was_bytes"), bytes("is_bytes"))
        {
            let known = days.entry(day.to_owned()).or_insert((was, is));
            *known = (known.0.max(was), known.1.min(is));
        }
    }
    let told = |(day, (was, is)): (String, (u64, u64))| {
        format!("archive/{day}: of {was} bytes that were once on the disk, {is} were left")
    };
    Ok(days.into_iter().map(told).collect())
}
