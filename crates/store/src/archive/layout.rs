//! Where the archive's files lie: `archive/0x2810/20261121/Data.lsf` and its companions, and what they are called.

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
/// Both compressed, of a day to which nothing is added.
pub(crate) const PACKED_DATA: &str = "Data.lsf.zst";
/// See [`PACKED_DATA`].
pub(crate) const PACKED_ARRIVALS: &str = "Arrivals.zst";
/// The folder in which compressed files are made, before they come to their place.
pub(crate) const PACKING: &str = "packing";
/// The folder for compressed files that could not be read and lay beside plain ones. Only a person removes them.
pub(crate) const DAMAGED: &str = "damaged";
/// The definitions by which the packets are read; Neptus wants them beside the data.
pub(crate) const DEFINITIONS: &str = "IMC.xml.gz";

/// Says by being there that old days were removed.
pub(crate) const TRIMMED: &str = "trimmed";

/// Most parts of a day. The last is never compressed, so that it takes all that still comes.
pub(crate) const MOST_PARTS: u8 = 40;
/// Numbers of days of the next part in the catalogue.
const PART: u32 = 100_000_000;

/// The compressed form of a day's file, by the name of its plain form.
pub(crate) fn packed_name(name: &str) -> &'static str {
    if name == DATA { PACKED_DATA } else { PACKED_ARRIVALS }
}

/// One folder of the archive: what came from a system on one UTC day, or a part of it. A day has one part, unless packets
/// still came for it, by a clock that was put back, when it was compressed already.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct DayKey {
    /// The system that sent the packets.
    pub src: Address,
    /// The day of arrival as a number: 20261121.
    pub day: u32,
    /// The part, from 0.
    pub(crate) part: u8,
}

impl DayKey {
    pub(crate) fn of(src: Address, received: UtcTime) -> Self {
        let Civil { year, month, day, .. } = received.civil();
        let year = year.clamp(0, 9999) as u32;
        Self { src, day: year * 10_000 + u32::from(month) * 100 + u32::from(day), part: 0 }
    }

    /// The folder's name below the archive: `0x2810/20261121`, of a further part `0x2810/20261121-2`.
    pub fn name(self) -> String {
        let part = if self.part > 0 { format!("-{}", self.part + 1) } else { String::new() };
        format!("{:#06x}/{:08}{part}", self.src.0, self.day)
    }

    /// The key by the name of the folder below that of its system.
    pub(crate) fn of_folder(src: Address, name: &str) -> Option<Self> {
        let (day, part) = name.split_once('-').map_or((name, None), |(day, part)| (day, Some(part)));
        let part = match part {
            None => 0,
            Some(part) => part.parse::<u8>().ok().filter(|part| (2..=MOST_PARTS).contains(part))? - 1,
        };
        let key = Self { src, day: day.parse().ok().filter(|_| day.len() == 8)?, part };
        // One name for each folder: not `+0261121` and not `20261121-02`.
        key.name().ends_with(&format!("/{name}")).then_some(key)
    }

    /// Day and part as one number, for the catalogue: the day's own for the first part.
    pub(crate) fn number(self) -> u32 {
        self.day + u32::from(self.part) * PART
    }

    /// The key by that number.
    pub(crate) fn of_number(src: Address, number: u32) -> Self {
        Self { src, day: number % PART, part: (number / PART) as u8 }
    }

    /// The next part of the day; the last is followed by itself.
    pub(crate) fn next_part(self) -> Self {
        Self { part: (self.part + 1).min(MOST_PARTS - 1), ..self }
    }

    /// Whether what still comes can go to a further part.
    pub(crate) fn may_close(self) -> bool {
        self.part + 1 < MOST_PARTS
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

/// Removes the half-made files that a program left when it ended while it compressed a day. No file in use is among them.
pub(crate) fn sweep_packing(archive: &Path) -> Result<()> {
    let folder = archive.join(PACKING);
    match fs::remove_dir_all(&folder) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(error).named(&folder),
        _ => Ok(()),
    }
}

/// All days of the archive, by system and day. Other files and folders are passed over.
pub(crate) fn days(archive: &Path) -> Result<Vec<DayKey>> {
    let mut found = Vec::new();
    for (name, folder) in folders(archive)? {
        let Some(src) = name.strip_prefix("0x").and_then(|hex| u16::from_str_radix(hex, 16).ok()) else {
            continue;
        };
        for (name, folder) in folders(&folder)? {
            let key = DayKey::of_folder(Address(src), &name);
            found.extend(key.filter(|_| [DATA, PACKED_DATA].iter().any(|name| folder.join(name).exists())));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_part_of_a_day_has_one_name_and_one_number() {
        let first = DayKey { src: Address(0x2810), day: 20_261_121, part: 0 };
        assert_eq!((first.name().as_str(), first.number()), ("0x2810/20261121", 20_261_121));
        assert_eq!(first.next_part().name(), "0x2810/20261121-2");
        let mut key = first;
        for _ in 0..MOST_PARTS {
            let name = key.name();
            assert_eq!(DayKey::of_folder(key.src, name.strip_prefix("0x2810/").unwrap()), Some(key));
            assert_eq!(DayKey::of_number(key.src, key.number()), key);
            key = key.next_part();
        }
        assert!(first.may_close() && !key.may_close() && key.next_part() == key);
        for name in [
            "2026112",
            "+0261121",
            "20261121-",
            "20261121-1",
            "20261121-02",
            "20261121-41",
            "20261121-2-3",
            "x",
        ] {
            assert_eq!(DayKey::of_folder(first.src, name), None, "{name}");
        }
    }
}
