//! The gaps that vessels declare: `archive/gaps.jsonl`, a line of JSON for each declaration.
//!
//! It is stored beside the archive because it is primary data, as the packets are. But any client with a vessel's token
//! can make such a statement. So it is bounded: adjacent gaps are merged, at most [`MOST_A_DAY`] are kept for a system
//! and a day, no time is later than a day from now. A record that comes for one of its numbers revokes that part of it.

use crate::error::{Named as _, Result, StoreError};
use crate::history::MonthKey;
use imc::Address;
use link::LinkSeq;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::{Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use units::UtcTime;

/// Declarations of one system and one UTC day that are kept apart. One more becomes part of the nearest of them.
const MOST_A_DAY: usize = 100;
const DAY_US: i64 = 86_400_000_000;
/// The substitute for declarations beyond the limit.
const TOO_MANY: &str = "several declarations of one day, more than are kept apart";

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

/// Numbers of a record lane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Numbers {
    /// The run of numbers.
    pub stream: u64,
    /// The first.
    pub from: u64,
    /// The one after the last.
    pub to: u64,
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
    /// Why the packets are missing.
    pub kind: GapKind,
    /// Why, in words.
    pub reason: String,
    /// How many packets are missing, where that is known.
    pub packets: Option<u64>,
    /// Which numbers of the record lane, when it was declared there.
    pub numbers: Option<Numbers>,
    /// When it was declared, by the shore's clock.
    pub declared: UtcTime,
}

impl Gap {
    /// How many packets are missing, and why, in words.
    pub fn told(&self) -> String {
        match self.packets {
            Some(packets) => format!("{packets} packets: {}", self.reason),
            None => self.reason.clone(),
        }
    }

    fn line(&self) -> String {
        let mut line = json!({
            "system": self.system.0,
            "from_us": self.from.micros(),
            "to_us": self.to.micros(),
            "kind": self.kind.name(),
            "reason": self.reason,
            "declared_us": self.declared.micros(),
        });
        if let Some(packets) = self.packets {
            line["packets"] = json!(packets);
        }
        if let Some(Numbers { stream, from, to }) = self.numbers {
            line["numbers"] = json!([stream, from, to]);
        }
        format!("{line}\n")
    }

    fn read(line: &str) -> Option<Self> {
        let value: Value = serde_json::from_str(line).ok()?;
        let time = |name: &str| value[name].as_i64().map(UtcTime::from_micros);
        let kind = value["kind"].as_str()?;
        let number = |at: usize| value["numbers"][at].as_u64();
        Some(Self {
            system: Address(value["system"].as_u64()?.try_into().ok()?),
            from: time("from_us")?,
            to: time("to_us")?,
            kind: GapKind::ALL.into_iter().find(|one| one.name() == kind)?,
            reason: value["reason"].as_str()?.to_owned(),
            packets: value["packets"].as_u64(),
            numbers: number(0).zip(number(1)).zip(number(2)).map(|((stream, from), to)| Numbers {
                stream,
                from,
                to,
            }),
            declared: time("declared_us")?,
        })
    }

    /// The same with times that can be: neither before 2000 nor later than a day after it was declared. Where both
    /// are impossible, the vessel did not know, and the time of its declaration is used.
    fn believable(mut self) -> Self {
        let first = UtcTime::from_micros(MonthKey::DATED.from_us);
        let last = UtcTime::from_micros(self.declared.micros().saturating_add(DAY_US));
        if self.to < first || self.from > last {
            (self.from, self.to) = (self.declared, self.declared);
        }
        self.from = self.from.max(first).min(last);
        self.to = self.to.max(first).min(last);
        self
    }

    /// Whether both say the same of what lies side by side.
    fn is_neighbour(&self, other: &Self) -> bool {
        let touch = match (self.numbers, other.numbers) {
            (Some(a), Some(b)) => a.stream == b.stream && a.from <= b.to && b.from <= a.to,
            (None, None) => self.from <= other.to && other.from <= self.to,
            _ => false,
        };
        touch && (self.system, self.kind, &self.reason) == (other.system, other.kind, &other.reason)
    }

    /// Becomes both.
    fn join(&mut self, other: &Self) {
        (self.from, self.to) = (self.from.min(other.from), self.to.max(other.to));
        let both = self.packets.zip(other.packets);
        match (&mut self.numbers, other.numbers) {
            (Some(a), Some(b)) if a.stream == b.stream => {
                (a.from, a.to) = (a.from.min(b.from), a.to.max(b.to));
                self.packets = both.map(|_| a.to - a.from);
            }
            _ => self.packets = both.map(|(a, b)| a.saturating_add(b)),
        }
        self.declared = self.declared.max(other.declared);
    }

    fn day(&self) -> (Address, i64) {
        (self.system, self.declared.micros().div_euclid(DAY_US))
    }

    /// How far two stretches are from each other (µs).
    fn distance_us(&self, other: &Self) -> i64 {
        (other.from - self.to).max(self.from - other.to).max(0)
    }
}

/// The declared gaps.
#[derive(Debug)]
pub(crate) struct Gaps {
    archive: PathBuf,
    kept: Vec<Gap>,
    /// Of each stream the number after the last that is declared missing.
    ends: BTreeMap<u64, u64>,
    /// Whether something was revoked since the file was written.
    is_changed: bool,
}

impl Gaps {
    /// Reads what was declared.
    pub(crate) fn open(archive: &Path) -> Result<Self> {
        let kept = all(archive)?;
        let mut gaps = Self { archive: archive.to_owned(), kept, ends: BTreeMap::new(), is_changed: false };
        gaps.find_ends();
        Ok(gaps)
    }

    fn find_ends(&mut self) {
        self.ends.clear();
        for Numbers { stream, to, .. } in self.kept.iter().filter_map(|gap| gap.numbers) {
            let end = self.ends.entry(stream).or_default();
            *end = to.max(*end);
        }
    }

    /// Keeps a declaration; it is on the disk when this returns.
    pub(crate) fn declare(&mut self, gap: Gap) -> Result<()> {
        if gap.to < gap.from {
            return Err(StoreError::Query("a gap ends before it begins".to_owned()));
        }
        let gap = gap.believable();
        let before = self.kept.clone();
        // Said again, it is the later statement that holds.
        self.kept.retain(|one| (one.system, one.from, one.to) != (gap.system, gap.from, gap.to));
        let neighbour = self.kept.iter_mut().find(|one| one.is_neighbour(&gap));
        let is_new = neighbour.is_none();
        if let Some(one) = neighbour {
            one.join(&gap);
        } else if self.kept.iter().filter(|one| one.day() == gap.day()).count() >= MOST_A_DAY {
            let same = self.kept.iter_mut().filter(|one| one.day() == gap.day());
            if let Some(nearest) = same.min_by_key(|one| one.distance_us(&gap)) {
                nearest.join(&gap);
                TOO_MANY.clone_into(&mut nearest.reason);
                nearest.kind = nearest.kind.max(gap.kind);
            }
        } else {
            self.kept.push(gap.clone());
        }
        let is_added = is_new && self.kept.len() == before.len() + 1;
        let written = if is_added { append(&self.archive, &gap) } else { self.write() };
        if written.is_err() {
            self.kept = before;
        }
        self.find_ends();
        written
    }

    /// A record came. Where its number is declared missing, the declaration ends before it: for what follows, the
    /// vessel sends a record or declares it again.
    pub(crate) fn revoke(&mut self, LinkSeq { stream, seq }: LinkSeq, time: Option<UtcTime>) {
        if self.ends.get(&stream).is_none_or(|end| seq >= *end) {
            return;
        }
        for gap in &mut self.kept {
            let Some(numbers) = gap.numbers.as_mut().filter(|numbers| numbers.stream == stream) else {
                continue;
            };
            if (numbers.from..numbers.to).contains(&seq) {
                numbers.to = seq;
                gap.packets = gap.packets.map(|_| seq - numbers.from);
                gap.to = gap.to.min(time.unwrap_or(gap.to)).max(gap.from);
                self.is_changed = true;
            }
        }
        self.kept.retain(|gap| gap.numbers.is_none_or(|numbers| numbers.from < numbers.to));
        self.find_ends();
    }

    /// Writes what was revoked. What cannot be written now is written later.
    pub(crate) fn save(&mut self) {
        if self.is_changed && self.write().is_ok() {
            self.is_changed = false;
        }
    }

    fn write(&self) -> Result<()> {
        let path = path(&self.archive);
        let new = path.with_extension("jsonl.new");
        let write = || -> std::io::Result<()> {
            let mut file = File::create(&new)?;
            let text: String = self.kept.iter().map(Gap::line).collect();
            file.write_all(text.as_bytes())?;
            file.sync_all()?;
            fs::rename(&new, &path)?;
            File::open(&self.archive)?.sync_all()
        };
        write().named(&path)
    }
}

fn path(archive: &Path) -> PathBuf {
    archive.join("gaps.jsonl")
}

/// Adds a declaration and waits until it is on the disk.
fn append(archive: &Path, gap: &Gap) -> Result<()> {
    let path = path(archive);
    let append = || -> std::io::Result<()> {
        let mut file = OpenOptions::new().read(true).append(true).create(true).open(&path)?;
        let before = file.metadata()?.len();
        // Behind half a line, which a crash left, this one would be read as a part of it.
        let text = if ends_in_a_line(&mut file, before)? { gap.line() } else { format!("\n{}", gap.line()) };
        let written = file.write_all(text.as_bytes()).and_then(|()| file.sync_data());
        if written.is_err() {
            file.set_len(before).ok();
        }
        written
    };
    append().named(&path)?;
    File::open(archive).and_then(|folder| folder.sync_all()).named(archive)
}

/// Whether the last line of a file of this length is whole, as it is in an empty one.
fn ends_in_a_line(file: &mut File, length: u64) -> std::io::Result<bool> {
    if length == 0 {
        return Ok(true);
    }
    let mut last = [0];
    file.seek(SeekFrom::End(-1))?;
    file.read_exact(&mut last)?;
    Ok(last == *b"\n")
}

/// All gaps, in order of declaration. A later declaration of the same stretch of the same system replaces the
/// earlier; lines that are not valid (a crash can leave half a line) are passed over.
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
