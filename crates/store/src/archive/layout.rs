//! Where the archive's files lie: `archive/0x2810/20261121/Data.lsf` and its companions.

use crate::error::{Named as _, Result};
use flate2::{Compression, GzBuilder};
use imc::Address;
use std::fs::{self, File};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use units::{Civil, UtcTime};

/// The packets, back to back.
pub(crate) const DATA: &str = "Data.lsf";
/// How and when each came.
pub(crate) const ARRIVALS: &str = "Arrivals.idx";
/// The definitions by which the packets are read; Neptus wants them beside the data.
pub(crate) const DEFINITIONS: &str = "IMC.xml.gz";

/// Says by being there that old days were removed.
pub(crate) const TRIMMED: &str = "trimmed";

/// One folder of the archive: what came from a system on one UTC day.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct DayKey {
    /// The system that sent the packets.
    pub src: Address,
    /// The day of arrival as a number: 20261121.
    pub day: u32,
}

impl DayKey {
    pub(crate) fn of(src: Address, received: UtcTime) -> Self {
        let Civil { year, month, day, .. } = received.civil();
        let year = year.clamp(0, 9999) as u32;
        Self { src, day: year * 10_000 + u32::from(month) * 100 + u32::from(day) }
    }

    /// The folder's name below the archive.
    pub fn name(self) -> String {
        format!("{:#06x}/{:08}", self.src.0, self.day)
    }

    pub(crate) fn folder(self, archive: &Path) -> PathBuf {
        archive.join(self.name())
    }

    /// Midnight at which the day begins.
    pub(crate) fn start(self) -> Option<UtcTime> {
        let (year, month, day) = (self.day / 10_000, self.day / 100 % 100, self.day % 100);
        UtcTime::from_civil(Civil {
            year: year.into(),
            month: month as u8,
            day: day as u8,
            hour: 0,
            minute: 0,
            second: 0,
            microsecond: 0,
        })
    }
}

/// Remembers that old days are removed, so that a stream of a record lane may begin with any number.
pub(crate) fn mark_trimmed(archive: &Path) -> Result<()> {
    let path = archive.join(TRIMMED);
    File::create(&path).and_then(|file| file.sync_all()).named(&path)?;
    File::open(archive).and_then(|folder| folder.sync_all()).named(archive)
}

/// Whether old days were removed.
pub(crate) fn is_trimmed(archive: &Path) -> bool {
    archive.join(TRIMMED).exists()
}

/// All days of the archive, by system and day. Other files and folders are passed over.
pub(crate) fn days(archive: &Path) -> Result<Vec<DayKey>> {
    let mut found = Vec::new();
    for (name, folder) in folders(archive)? {
        let Some(src) = name.strip_prefix("0x").and_then(|hex| u16::from_str_radix(hex, 16).ok()) else {
            continue;
        };
        for (name, folder) in folders(&folder)? {
            let day = name.parse().ok().filter(|_| name.len() == 8);
            if let Some(day) = day.filter(|_| folder.join(DATA).exists()) {
                found.push(DayKey { src: Address(src), day });
            }
        }
    }
    found.sort();
    Ok(found)
}

fn folders(of: &Path) -> Result<Vec<(String, PathBuf)>> {
    let entries = match fs::read_dir(of) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        other => other.named(of)?,
    };
    let mut found = Vec::new();
    for entry in entries {
        let entry = entry.named(of)?;
        if entry.file_type().named(&entry.path())?.is_dir() {
            found.push((entry.file_name().to_string_lossy().into_owned(), entry.path()));
        }
    }
    Ok(found)
}

/// Makes a day's folder, with the definitions, and lets the disk know its name.
pub(crate) fn make_day(archive: &Path, key: DayKey) -> Result<PathBuf> {
    let folder = key.folder(archive);
    fs::create_dir_all(&folder).named(&folder)?;
    let definitions = folder.join(DEFINITIONS);
    if !definitions.exists() {
        let master = master_definitions(archive)?;
        // One file with many names; where the file system has no links, copies do.
        fs::hard_link(&master, &definitions)
            .or_else(|_| fs::copy(&master, &definitions).map(drop))
            .named(&definitions)?;
    }
    for parent in folder.ancestors().take(3) {
        File::open(parent).and_then(|folder| folder.sync_all()).named(parent)?;
    }
    Ok(folder)
}

/// The file that the definitions beside the data are links to. Its name changes with what it says, so that old
/// days keep the definitions of their time.
fn master_definitions(archive: &Path) -> Result<PathBuf> {
    let xml = imc::lsf::definitions_xml();
    let folder = archive.join("definitions");
    let print = crate::fingerprint::of_payload(xml.as_bytes());
    let path = folder.join(format!("IMC-{}-{print:012x}.xml.gz", imc::catalogue::VERSION));
    if !path.exists() {
        fs::create_dir_all(&folder).named(&folder)?;
        let unfinished = path.with_extension("part");
        let write = || -> std::io::Result<()> {
            let mut file = GzBuilder::new().write(File::create(&unfinished)?, Compression::default());
            file.write_all(xml.as_bytes())?;
            file.finish()?.sync_all()?;
            fs::rename(&unfinished, &path)
        };
        write().named(&path)?;
    }
    Ok(path)
}
