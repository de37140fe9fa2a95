//! Checks of the store, with remedies.

use crate::archive::{self, ARRIVALS, DATA, DayReader, bytes, shortened};
use crate::aside;
use crate::error::{Named as _, Result, StoreError};
use crate::history::look::{self, Sound};
use crate::history::schema::Schema;
use crate::history::{CATALOGUE, MonthKey, chunk, load_months, load_progress, missing};
use crate::layout::{GROWING, REPLACED, free_bytes};
use crate::lock::FolderLock;
use crate::reader::{Memory, Reader, open};
use crate::reindex;
use link::Transport;
use rusqlite::Connection;
use std::fs;
use std::path::Path;
use units::UtcTime;

/// Free bytes below which a disk is nearly full, and as good as full.
const LOW_BYTES: u64 = 5 << 30;
const FULL_BYTES: u64 = 200 << 20;
/// How far a clock may be ahead (µs).
const AHEAD_US: i64 = 60_000_000;

/// How something is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Health {
    /// Well.
    Good,
    /// To be looked at.
    Warning,
    /// To be repaired.
    Problem,
}

/// One check.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Check {
    /// The subject of the check: a stable word.
    pub name: &'static str,
    /// How it is.
    pub health: Health,
    /// The finding.
    pub found: String,
    /// The remedy; empty when none is needed.
    pub remedy: String,
}

impl Check {
    fn good(name: &'static str, found: String) -> Self {
        Self { name, health: Health::Good, found, remedy: String::new() }
    }

    fn new(name: &'static str, health: Health, found: String, remedy: &str) -> Self {
        Self { name, health, found, remedy: remedy.to_owned() }
    }
}

/// Checks a data folder. `thorough` reads the whole archive and every page of the history; `progress` gets the name
/// of the next check and may stop by returning false.
///
/// # Errors
/// When the folder cannot be read at all, and [`StoreError::Cancelled`]. Anything else that is wrong is a check.
pub fn doctor(
    data: &Path,
    now: UtcTime,
    thorough: bool,
    progress: &mut dyn FnMut(&str) -> bool,
) -> Result<Vec<Check>> {
    fs::metadata(data).named(data)?;
    let mut checks = vec![writer(data), disk(data)];
    let mut next = |what: &str| if progress(what) { Ok(()) } else { Err(StoreError::Cancelled) };
    next("archive")?;
    checks.extend(arrivals(data)?);
    if thorough {
        for key in archive::days(&data.join("archive"))? {
            next(&key.name())?;
            checks.extend(day(data, key));
        }
    }
    next("history")?;
    checks.extend(databases(data, thorough, &mut next)?);
    checks.push(history_follows(data)?);
    checks.extend(clocks(data, now));
    checks.extend(left_over(data));
    Ok(checks)
}

fn writer(data: &Path) -> Check {
    match FolderLock::take(data) {
        Ok(_) => Check::good("writer", "no process writes to the folder".to_owned()),
        Err(StoreError::Locked { pid, .. }) => {
            Check::good("writer", format!("process {pid} writes to the folder"))
        }
        Err(error) => Check::new(
            "writer",
            Health::Problem,
            error.to_string(),
            "let the folder belong to the user that runs the server",
        ),
    }
}

fn disk(data: &Path) -> Check {
    match free_bytes(data) {
        Err(error) => Check::new("disk", Health::Problem, error.to_string(), "check the disk and its mount"),
        Ok(free) => {
            let found = format!("{} MiB are free", free >> 20);
            let remedy = "make room: remove old months (retention), or move the data folder to a larger disk";
            let health = match free {
                0..FULL_BYTES => Health::Problem,
                FULL_BYTES..LOW_BYTES => Health::Warning,
                _ => return Check::good("disk", found),
            };
            Check::new("disk", health, found, remedy)
        }
    }
}

/// Whether every day's two files are there.
fn arrivals(data: &Path) -> Result<Vec<Check>> {
    let root = data.join("archive");
    let days = archive::days(&root)?;
    let mut checks = Vec::new();
    let (mut disk_bytes, mut packed) = (0, 0);
    for key in &days {
        let folder = key.folder(&root);
        disk_bytes += bytes::disk_bytes(&folder);
        packed += usize::from(bytes::is_packed(&folder));
        for found in bytes::findings(&folder) {
            let found = format!("archive/{}/{found}", key.name());
            let remedy = "check the disk; copy the day's folder from a backup while the server is stopped";
            checks.push(Check::new("archive", Health::Problem, found, remedy));
        }
        if !bytes::is_there(&folder, ARRIVALS) {
            checks.push(Check::new(
                "archive",
                Health::Warning,
                format!("archive/{}: {ARRIVALS} is missing", key.name()),
                "restart the server: it is made again, without the times of arrival",
            ));
        }
    }
    let aside = fs::read_dir(root.join(archive::DAMAGED)).map_or(0, Iterator::count);
    if aside > 0 {
        checks.push(Check::new(
            "archive",
            Health::Warning,
            format!("{aside} compressed files that could not be read lie in archive/{}", archive::DAMAGED),
            "check the disk that damaged them; the days were compressed again from their plain files. Remove them once \
             `lutra-server doctor --thorough` finds no damage",
        ));
    }
    // Read before the lengths: the files of a server that runs only grow.
    let read = Reader::open(data)?.ask_catalogue(load_progress).ok().flatten().unwrap_or_default();
    for told in
        shortened::told(shortened::seen(&root, read.iter().map(|(key, progress)| (*key, progress.lengths)))?)
    {
        checks.push(Check::new(
            "archive",
            Health::Problem,
            told,
            "check the disk; copy the day from a backup, or import the vessel's own log of that day; then remove \
             archive/shortened.jsonl (a start writes it), so that it is no longer reported",
        ));
    }
    let found =
        format!("{} days of systems, {packed} of them compressed, {} MiB", days.len(), disk_bytes >> 20);
    checks.push(Check::good("archive", found));
    Ok(checks)
}

/// Reads a day to its end.
fn day(data: &Path, key: archive::DayKey) -> Option<Check> {
    let read = || -> Result<(u64, u64)> {
        let mut reader = DayReader::open(&data.join("archive"), key, 0, 0)?;
        let mut without_record = 0;
        while let Some(archived) = reader.next_packet()? {
            without_record += u64::from(archived.arrival.transport == Transport::Recovered);
        }
        Ok((reader.damaged_bytes(), without_record))
    };
    let name = key.name();
    match read() {
        Ok((0, 0)) => None,
        Ok((0, without)) => Some(Check::good(
            "archive",
            format!("archive/{name}: {without} packets whose arrival was lost in a crash"),
        )),
        Ok((damaged, _)) => Some(Check::new(
            "archive",
            Health::Problem,
            format!("archive/{name}: {damaged} bytes are damaged"),
            "check the disk; copy the day from a backup, or import the vessel's own log of that day",
        )),
        Err(error) => {
            Some(Check::new("archive", Health::Problem, error.to_string(), "check the disk and the rights"))
        }
    }
}

/// The remedy for a damaged file of the history.
const MAKE_AGAIN: &str = "restart the server: it keeps the file in history.aside and makes it again from the archive \
                          while it records; or, and always for a damaged chunk, stop it and run `lutra-server reindex`, which \
                          does so at once";
/// The remedy for one of a later version.
const USE_LATER: &str = "run the later version, which reads what is missing; or stop the server and run `lutra-server \
                         reindex`: the history is made again from the archive, and the file kept in history.aside";

fn databases(data: &Path, thorough: bool, next: &mut impl FnMut(&str) -> Result<()>) -> Result<Vec<Check>> {
    let folder = data.join("history");
    let mut checks = Vec::new();
    let mut well = 0;
    for (name, sound) in look::look(&folder)? {
        next(&name)?;
        let problem = match sound {
            Sound::Newer => {
                let found =
                    format!("history/{name} was written by a later version of Lutra, nothing is added to it");
                checks.push(Check::new("history", Health::Problem, found, USE_LATER));
                continue;
            }
            Sound::No(problem) => Some(problem),
            Sound::Yes | Sound::Empty => unreadable(&folder.join(&name), thorough),
        };
        checks.extend(set_aside(&folder, &name));
        match problem {
            None => well += 1,
            Some(problem) => checks.push(Check::new(
                "history",
                Health::Problem,
                format!("history/{name}: {problem}"),
                MAKE_AGAIN,
            )),
        }
    }
    checks.extend(missing(&folder));
    checks.push(Check::good("history", format!("{well} databases are readable")));
    Ok(checks)
}

/// Why a database cannot be read, if so.
fn unreadable(path: &Path, thorough: bool) -> Option<String> {
    let sql = if thorough { "PRAGMA quick_check(1)" } else { "SELECT 'ok'" };
    let verdict: rusqlite::Result<String> =
        open(path, Memory::EXPORT).and_then(|connection| connection.query_row(sql, (), |row| row.get(0)));
    let verdict = verdict.and_then(|verdict| {
        if thorough && verdict == "ok" && path.file_name().is_some_and(|name| name != CATALOGUE) {
            chunk::check(&open(path, Memory::EXPORT)?)?;
        }
        Ok(verdict)
    });
    verdict.map_or_else(|error| Some(error.to_string()), |verdict| (verdict != "ok").then_some(verdict))
}

/// Chunks of a compressed month that were damaged, and moved out of the way.
fn set_aside(folder: &Path, name: &str) -> Option<Check> {
    let connection = open(&folder.join(name), Memory::EXPORT).ok()?;
    let found = missing::aside(&connection, &Schema::new()).ok().filter(|found| !found.is_empty())?;
    let lost: Vec<&missing::Aside> = found.iter().filter(|one| one.missing > 0).collect();
    let Some(first) = lost.first() else {
        return Some(Check::good(
            "history",
            format!("history/{name}: {} damaged chunks were read again from the archive", found.len()),
        ));
    };
    let missing: u64 = lost.iter().map(|one| one.missing).sum();
    Some(Check::new(
        "history",
        Health::Problem,
        format!(
            "history/{name}: {missing} samples are missing, of {} damaged chunks that were set aside, the first {}",
            lost.len(),
            first.what
        ),
        "check the disk; the server reads them again from the archive where that has their days. Otherwise copy \
         those days of the archive from a backup while the server is stopped, and run `lutra-server reindex`",
    ))
}

/// Months that must be there and are not, or hold nothing any more.
fn missing(folder: &Path) -> Vec<Check> {
    let listed = open(&folder.join(CATALOGUE), Memory::EXPORT).and_then(|catalogue| load_months(&catalogue));
    let gone = |key: &MonthKey| fs::metadata(folder.join(key.file_name())).map_or(0, |file| file.len()) == 0;
    let check = |key: MonthKey| {
        Check::new(
            "history",
            Health::Problem,
            format!("history/{} is gone or empty", key.file_name()),
            MAKE_AGAIN,
        )
    };
    listed.unwrap_or_default().into_iter().filter(gone).map(check).collect()
}

/// Whether the history has read all of the archive.
fn history_follows(data: &Path) -> Result<Check> {
    let root = data.join("archive");
    let read = Reader::open(data)?.ask_catalogue(load_progress).ok().flatten().unwrap_or_default();
    let mut unread = 0;
    for key in archive::days(&root)? {
        let length = bytes::readable_bytes(&key.folder(&root), DATA);
        unread += length.saturating_sub(read.get(&key).map_or(0, |progress| progress.lengths.data));
    }
    let found = format!("{} KiB of the archive are not yet marked as read into the history", unread >> 10);
    // While the server runs, the mark is up to half a minute or some MiB behind.
    Ok(if unread <= 64 << 20 {
        Check::good("progress", found)
    } else {
        Check::new(
            "progress",
            Health::Warning,
            found,
            "let the server run: it reads the rest between commits, and /api/v1/recording says how far it is",
        )
    })
}

fn clocks(data: &Path, now: UtcTime) -> Vec<Check> {
    let mut checks = Vec::new();
    let Ok(mut reader) = Reader::open(data) else { return checks };
    let Ok(systems) = reader.systems() else { return checks };
    for system in systems {
        let ahead_us = system.extent.last_us.saturating_sub(now.micros());
        if ahead_us > AHEAD_US {
            checks.push(Check::new(
                "clocks",
                Health::Warning,
                format!("{} sent samples {} s ahead of this clock", system.name, ahead_us / 1_000_000),
                "check the clocks of both; the history keeps the times as they were sent",
            ));
        }
    }
    let is_there = reader.keys().is_ok_and(|keys| keys.contains(&MonthKey::Undated));
    let count = |connection: &Connection| {
        connection.query_row("SELECT coalesce(sum(count),0) FROM _group", (), |row| row.get::<_, i64>(0))
    };
    let undated = is_there.then(|| reader.ask_month(MonthKey::Undated, count).ok()).flatten();
    if let Some(undated) = undated.filter(|count| *count > 0) {
        checks.push(Check::new(
            "clocks",
            Health::Warning,
            format!("{undated} samples have no believable time and lie in history/undated.sqlite"),
            "let the vessel set its clock (NTP or GNSS) before it sends",
        ));
    }
    checks
}

fn left_over(data: &Path) -> Vec<Check> {
    let mut checks = Vec::new();
    let names: Vec<&str> = [GROWING, REPLACED].into_iter().filter(|name| data.join(name).exists()).collect();
    if let Some(why) = reindex::refused(data) {
        checks.push(Check::new(
            "reindex",
            Health::Warning,
            format!("{GROWING} waits: {why}"),
            reindex::ACCEPT,
        ));
    } else if !names.is_empty() {
        checks.push(Check::new(
            "reindex",
            Health::Warning,
            format!("{} is left of a rebuild that was broken off", names.join(" and ")),
            "run `lutra-server reindex` again, which goes on there, or remove it",
        ));
    }
    let aside = aside::all(data).unwrap_or_default();
    if !aside.is_empty() {
        let bytes: u64 = aside.iter().filter_map(|path| Some(fs::metadata(path).ok()?.len())).sum();
        checks.push(Check::new(
            "history",
            Health::Warning,
            format!(
                "{} files that could not be used lie in {}, {} MiB",
                aside.len(),
                aside::ASIDE,
                bytes >> 20
            ),
            "check the disk that damaged them; remove them once the history is whole without them",
        ));
    }
    checks
}
