//! Logs into the store: LSF files, compressed or not, whole folders of them.
//!
//! Importing the same again adds nothing, neither to the history nor to the archive, also when an import was
//! broken off in between. What a log holds twice is archived twice, as it stands.

use crate::error::{Named as _, Result, StoreError};
use crate::packet::Outcome;
use crate::store::Store;
use imc::lsf::{LogItem, LogReader};
use imc::{Damage, FrameError, PacketView};
use std::fs::{self, File};
use std::io::{self, BufReader, Chain, Cursor, Read, Seek as _};
use std::path::{Path, PathBuf};
use units::UtcTime;

/// Packets between two commits and two reports of progress.
const COMMIT_PACKETS: u64 = 20_000;
/// Bytes between two commits.
const COMMIT_BYTES: usize = 8 << 20;
/// Bytes in which a log must have a packet to count as one.
const LOOKED_AT_BYTES: u64 = 1 << 20;
/// The first four bytes of files that zstd packed.
const ZSTD_MAGIC: u32 = 0xFD2F_B528;
const ZSTD_SKIPPABLE: u32 = 0x184D_2A50;

/// How far an import is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImportProgress<'a> {
    /// The log being read.
    pub file: &'a Path,
    /// Its number, from 1.
    pub number: usize,
    /// Logs altogether.
    pub files: usize,
    /// Bytes of this log read so far, unpacked.
    pub bytes: u64,
    /// Packets found so far in all logs.
    pub packets: u64,
    /// Those that were new.
    pub added: u64,
}

/// The result of an import.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Imported {
    /// Logs read.
    pub files: usize,
    /// Packets found.
    pub packets: u64,
    /// Packets that were new to the archive.
    pub added: u64,
    /// Bytes that are not packets.
    pub damaged_bytes: u64,
    /// Problems of logs, and remedies.
    pub problems: Vec<String>,
}

impl Store {
    /// Imports logs: files of any name, and from folders all that are named as logs. `now` is the time by the
    /// shore's clock; `progress` may stop the import by returning false, what was read before stays.
    ///
    /// # Errors
    /// When a file cannot be read or the archive not written, and [`StoreError::Cancelled`]. A file that holds
    /// no packets is not an error but a problem that is reported.
    pub fn import(
        &mut self,
        paths: &[PathBuf],
        now: UtcTime,
        progress: &mut dyn FnMut(&ImportProgress<'_>) -> bool,
    ) -> Result<Imported> {
        let mut imported = Imported::default();
        let mut files = Vec::new();
        for path in paths {
            if path.is_dir() {
                let before = files.len();
                find_logs(path, &mut files, &mut imported.problems)?;
                if files.len() == before {
                    imported
                        .problems
                        .push(format!("{}: holds no logs (*.lsf, *.lsf.gz, *.lsf.zst)", path.display()));
                }
            } else {
                files.push(path.clone());
            }
        }
        self.make_ready()?;
        // Each log has an arrival time of its own, which distinguishes its packets from earlier ones.
        let start_us = self.reserve_arrivals(now.micros(), files.len())?;
        for (at, file) in files.iter().enumerate() {
            if let Err(error) = open_log(file)
                && is_of_contents(&error)
            {
                imported.problems.push(format!("{}: cannot be unpacked: {error}", file.display()));
                imported.files += 1;
                continue;
            }
            let received = UtcTime::from_micros(start_us + at as i64);
            let mut log = LogImport::open(file, received, std::mem::take(&mut imported))?;
            let number = at + 1;
            loop {
                self.make_ready()?;
                let more = match log.read_some(self, COMMIT_PACKETS, u64::MAX) {
                    // A damaged part of the history was met, and is made again.
                    Err(StoreError::Behind(_)) => true,
                    other => other?,
                };
                let Imported { packets, added, .. } = log.imported;
                let (bytes, files) = (log.read_bytes(), files.len());
                if !progress(&ImportProgress { file, number, files, bytes, packets, added }) {
                    return Err(StoreError::Cancelled);
                }
                if !more {
                    break;
                }
            }
            imported = log.imported;
            imported.files += 1;
        }
        self.settle()?;
        Ok(imported)
    }

    /// Waits until the history lacks nothing.
    fn make_ready(&mut self) -> Result<()> {
        self.sync_quietly()?;
        self.index()?;
        while self.is_behind() {
            self.index()?;
        }
        Ok(())
    }

    /// A commit after which the history must lack nothing, since what is already there is known by it. Where it
    /// does, this took one slice of it, and others have their turn.
    fn commit_all(&mut self) -> Result<()> {
        self.sync_quietly()?;
        self.index()?;
        match self.behind() {
            None => Ok(()),
            Some(why) => Err(StoreError::Behind(why)),
        }
    }
}

/// Takes a packet of a log, and counts it.
fn take(store: &mut Store, view: &PacketView<'_>, received: UtcTime, imported: &mut Imported) -> Result<()> {
    let outcome = store.accept_from_log(view, received)?;
    imported.packets += 1;
    imported.added += u64::from(outcome == Outcome::Recorded);
    Ok(())
}

/// The import of one log, some packets at a time, so that the owner of the store can take other packets in between.
#[derive(Debug)]
pub struct LogImport {
    file: PathBuf,
    log: LogReader<Chain<Cursor<Vec<u8>>, LogFile>>,
    /// Arrival time, which distinguishes its packets from earlier ones.
    received: UtcTime,
    imported: Imported,
    /// Packets of all logs before this one.
    before: u64,
    first_damage: Option<Damage>,
    /// A packed file that ends too early, or is damaged: a problem of its own.
    is_cut: bool,
    /// A packet that was read and not taken, for the history was found damaged.
    waiting: Option<Vec<u8>>,
}

impl LogImport {
    /// Begins the import of one log; `now` is the time by the shore's clock.
    ///
    /// # Errors
    /// When the file or the history cannot be read, or the archive not be written; [`StoreError::Behind`] while the
    /// history lacks something: try again, by which it comes closer.
    pub fn begin(store: &mut Store, file: &Path, now: UtcTime) -> Result<Self> {
        store.commit_all()?;
        let received = UtcTime::from_micros(store.reserve_arrivals(now.micros(), 1)?);
        Self::open(file, received, Imported { files: 1, ..Imported::default() })
    }

    fn open(file: &Path, received: UtcTime, imported: Imported) -> Result<Self> {
        let (log, before) = (open_log(file).named(file)?, imported.packets);
        Ok(Self {
            file: file.to_owned(),
            log,
            received,
            imported,
            before,
            first_damage: None,
            is_cut: false,
            waiting: None,
        })
    }

    /// The result so far.
    pub fn imported(&self) -> &Imported {
        &self.imported
    }

    /// Bytes of the log read so far, unpacked.
    pub fn read_bytes(&self) -> u64 {
        self.log.unpacked_bytes()
    }

    /// Reads some more, about as many packets or unpacked bytes as said, and commits them with all that waits in
    /// the store. Whether there is more.
    ///
    /// Packets read before an error stay; importing the log again adds only the rest.
    ///
    /// # Errors
    /// When the file or history cannot be read or the archive not be written; [`StoreError::Behind`] while the
    /// history lacks something: trying again brings it closer, and nothing of the log is left out.
    pub fn read_some(&mut self, store: &mut Store, packets: u64, bytes: u64) -> Result<bool> {
        // Packets that came meanwhile must be known, or they would be taken twice.
        store.commit_all()?;
        if let Some(packet) = &self.waiting {
            take(store, &PacketView::unchecked(packet)?, self.received, &mut self.imported)?;
            self.waiting = None;
        }
        let (enough_packets, enough_bytes) =
            (self.imported.packets.saturating_add(packets), self.read_bytes().saturating_add(bytes));
        let more = loop {
            let item = match self.log.next_item() {
                // zstd's own errors, and an end that comes too early: this log ends here, and others go on.
                Err(error) if is_of_contents(&error) => {
                    let problem = format!("{}: cannot be unpacked to its end: {error}", self.file.display());
                    self.imported.problems.push(problem);
                    self.is_cut = true;
                    break false;
                }
                other => other.named(&self.file)?,
            };
            match item {
                Some(LogItem::Packet { view, .. }) => {
                    let taken = take(store, &view, self.received, &mut self.imported);
                    if matches!(taken, Err(StoreError::Behind(_))) {
                        self.waiting = Some(view.bytes().to_vec());
                    }
                    taken?;
                }
                Some(LogItem::Damage(damage)) => {
                    self.imported.damaged_bytes += damage.bytes;
                    self.first_damage.get_or_insert(damage);
                }
                Some(LogItem::Cut { offset, problem }) => {
                    let name = self.file.display();
                    self.is_cut = true;
                    self.imported.problems.push(format!("{name}: {problem} ({offset} bytes were unpacked)"));
                }
                None => break false,
            }
            if self.imported.packets >= enough_packets
                || self.log.unpacked_bytes() >= enough_bytes
                || store.waiting_bytes() >= COMMIT_BYTES
            {
                break true;
            }
        };
        store.sync_quietly()?;
        store.index()?;
        if !more {
            self.tell_damage();
        }
        Ok(more)
    }

    fn tell_damage(&mut self) {
        let name = self.file.display();
        if self.imported.packets == self.before {
            let what = match self.first_damage {
                None if self.is_cut => "holds no whole packet".to_owned(),
                None => "is empty".to_owned(),
                Some(damage) if is_of_first(&damage) => {
                    format!(
                        "holds no whole packet: it ends at byte {}, within its first one",
                        self.read_bytes()
                    )
                }
                Some(damage) => format!("is not an IMC log: {} at its first byte", damage.error),
            };
            self.imported.problems.push(format!("{name}: {what}"));
        } else if let Some(damage) = self.first_damage {
            let problem = format!("{name}: damaged from byte {}: {}", damage.offset, damage.error);
            self.imported.problems.push(problem);
        }
    }
}

/// A log's file: as it is, or unpacked by zstd on the way.
enum LogFile {
    AsItIs(File),
    Zstd(Box<zstd::stream::read::Decoder<'static, BufReader<File>>>),
}

impl std::fmt::Debug for LogFile {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str("LogFile")
    }
}

impl Read for LogFile {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::AsItIs(file) => file.read(into),
            Self::Zstd(decoder) => decoder.read(into),
        }
    }
}

/// Opens a log, plain or packed by gzip or zstd, by its first bytes.
fn open_log(path: &Path) -> io::Result<LogReader<Chain<Cursor<Vec<u8>>, LogFile>>> {
    let mut file = File::open(path)?;
    let mut start = Vec::new();
    file.by_ref().take(4).read_to_end(&mut start)?;
    file.rewind()?;
    let magic = start.as_slice().try_into().map_or(0, u32::from_le_bytes);
    // A frame, or a skippable frame, with which compressed days of an archive begin.
    let is_zstd = magic == ZSTD_MAGIC || magic & !0xF == ZSTD_SKIPPABLE;
    let file = if is_zstd {
        let mut decoder = zstd::stream::read::Decoder::new(file)?;
        // Memory that a file from elsewhere can ask for: 8 MiB, as the format recommends.
        decoder.window_log_max(23)?;
        LogFile::Zstd(Box::new(decoder))
    } else {
        LogFile::AsItIs(file)
    };
    LogReader::detect(file)
}

/// Whether an error is about what a packed file holds; those of the system have its number.
fn is_of_contents(error: &io::Error) -> bool {
    error.raw_os_error().is_none()
}

/// What a file is by its first MiB, unpacked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Beginning {
    /// It has a packet. A log that was not written to its end is read as far as it goes.
    Log,
    /// It begins as a log or as a packed file, and ends before the first packet does.
    Cut {
        /// Bytes of the file.
        bytes: u64,
    },
    /// It is something else, or empty.
    Other,
}

/// Looks for a packet at the beginning of a file.
///
/// # Errors
/// When it cannot be read.
pub fn beginning(file: &Path) -> Result<Beginning> {
    let bytes = fs::metadata(file).named(file)?.len();
    let ended = |is_cut: bool| if is_cut && bytes > 0 { Beginning::Cut { bytes } } else { Beginning::Other };
    let mut log = match open_log(file) {
        Err(error) if is_of_contents(&error) => return Ok(ended(is_of_an_end(&error))),
        other => other.named(file)?,
    };
    let (mut is_cut, mut is_damaged) = (false, false);
    while log.unpacked_bytes() <= LOOKED_AT_BYTES {
        let item = match log.next_item() {
            Err(error) if is_of_contents(&error) => {
                is_cut |= is_of_an_end(&error);
                break;
            }
            other => other.named(file)?,
        };
        match item {
            Some(LogItem::Packet { .. }) => return Ok(Beginning::Log),
            Some(LogItem::Damage(damage)) if is_of_first(&damage) => is_cut = true,
            Some(LogItem::Damage(_)) => is_damaged = true,
            Some(LogItem::Cut { .. }) => is_cut = true,
            None => break,
        }
    }
    Ok(ended(is_cut && !is_damaged))
}

/// Whether a packed file ends too early, rather than holds what no packed file does.
fn is_of_an_end(error: &io::Error) -> bool {
    error.kind() == io::ErrorKind::UnexpectedEof
}

/// Whether a log ends within its first packet.
fn is_of_first(damage: &Damage) -> bool {
    damage.offset == 0 && matches!(damage.error, FrameError::Truncated { .. })
}

/// All logs below a folder, in order of their names.
fn find_logs(folder: &Path, files: &mut Vec<PathBuf>, problems: &mut Vec<String>) -> Result<()> {
    let mut entries: Vec<PathBuf> = Vec::new();
    for entry in fs::read_dir(folder).named(folder)? {
        entries.push(entry.named(folder)?.path());
    }
    entries.sort();
    for path in entries {
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
        if fs::symlink_metadata(&path).named(&path)?.is_dir() {
            find_logs(&path, files, problems)?;
        } else if [".lsf", ".lsf.gz", ".lsf.zst", ".imc", ".imc.gz"].iter().any(|end| name.ends_with(end)) {
            files.push(path);
        } else if name.ends_with(".lsf.bz2") {
            problems.push(format!("{}: is packed by bzip2; unpack it with `bunzip2` first", path.display()));
        }
    }
    Ok(())
}
