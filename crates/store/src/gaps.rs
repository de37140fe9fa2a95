//! What vessels say is missing: `archive/gaps.jsonl`, a line of JSON for each declaration.
//!
//! It lies with the archive because it is as much the truth as the packets are.

use crate::error::{Named as _, Result, StoreError};
use imc::Address;
use serde_json::{Value, json};
use std::fs::{self, File, OpenOptions};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use units::UtcTime;

/// Why something is not there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum GapKind {
    /// It was never recorded: the program or the sensor did not run.
    NotRecorded,
    /// The vessel has it and has yet to send it.
    NotDelivered,
    /// It was recorded and is gone.
    Lost,
}

impl GapKind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::NotRecorded, Self::NotDelivered, Self::Lost];

    /// A stable word for machines.
    pub fn name(self) -> &'static str {
        match self {
            Self::NotRecorded => "not_recorded",
            Self::NotDelivered => "not_delivered",
            Self::Lost => "lost",
        }
    }
}

/// A stretch of a system's time from which something is missing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Gap {
    /// The system.
    pub system: Address,
    /// From when.
    pub from: UtcTime,
    /// Until when.
    pub to: UtcTime,
    /// Why.
    pub kind: GapKind,
    /// Why, in words.
    pub reason: String,
    /// When it was declared, by the shore's clock.
    pub declared: UtcTime,
}

impl Gap {
    fn line(&self) -> String {
        let mut line = json!({
            "system": self.system.0,
            "from_us": self.from.micros(),
            "to_us": self.to.micros(),
            "kind": self.kind.name(),
            "reason": self.reason,
            "declared_us": self.declared.micros(),
        })
        .to_string();
        line.push('\n');
        line
    }

    fn read(line: &str) -> Option<Self> {
        let value: Value = serde_json::from_str(line).ok()?;
        let time = |name: &str| value[name].as_i64().map(UtcTime::from_micros);
        let kind = value["kind"].as_str()?;
        Some(Self {
            system: Address(value["system"].as_u64()?.try_into().ok()?),
            from: time("from_us")?,
            to: time("to_us")?,
            kind: GapKind::ALL.into_iter().find(|one| one.name() == kind)?,
            reason: value["reason"].as_str()?.to_owned(),
            declared: time("declared_us")?,
        })
    }
}

fn path(archive: &Path) -> PathBuf {
    archive.join("gaps.jsonl")
}

/// Adds a declaration and waits until it is on the disk.
pub(crate) fn declare(archive: &Path, gap: &Gap) -> Result<()> {
    if gap.to < gap.from {
        return Err(StoreError::Query("a gap ends before it begins".to_owned()));
    }
    let path = path(archive);
    let append = || -> std::io::Result<()> {
        let mut file = OpenOptions::new().append(true).create(true).open(&path)?;
        let before = file.metadata()?.len();
        let written = file.write_all(gap.line().as_bytes()).and_then(|()| file.sync_data());
        if written.is_err() {
            file.set_len(before).ok();
        }
        written
    };
    append().named(&path)?;
    File::open(archive).and_then(|folder| folder.sync_all()).named(archive)
}

/// All gaps, in order of declaration. A later declaration of the same stretch of the same system replaces the
/// earlier; lines that are none (a crash can leave half a line) are passed over.
pub(crate) fn all(archive: &Path) -> Result<Vec<Gap>> {
    let path = path(archive);
    let text = match fs::read(&path) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        other => other.named(&path)?,
    };
    let mut gaps: Vec<Gap> = Vec::new();
    for gap in String::from_utf8_lossy(&text).lines().filter_map(Gap::read) {
        gaps.retain(|one| (one.system, one.from, one.to) != (gap.system, gap.from, gap.to));
        gaps.push(gap);
    }
    Ok(gaps)
}
