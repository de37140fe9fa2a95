//! How much a data folder holds, and of what time.

use crate::archive;
use crate::error::{Named as _, Result};
use crate::history;
use imc::Address;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use units::UtcTime;

/// The contents of a data folder.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Usage {
    /// The archive, by system.
    pub archive: BTreeMap<Address, Archives>,
    /// The history, by the names of its files, in their order.
    pub history: Vec<(String, u64)>,
}

/// The archive's data of a system.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Archives {
    /// Bytes on the disk of packets and of how they came.
    pub bytes: u64,
    /// Days of arrival.
    pub days: u32,
    /// Midnight of the first and of the last of them.
    pub first: UtcTime,
    /// See `first`.
    pub last: UtcTime,
}

impl Usage {
    /// Bytes of the whole archive.
    pub fn archive_bytes(&self) -> u64 {
        self.archive.values().map(|one| one.bytes).sum()
    }

    /// Bytes of the whole history.
    pub fn history_bytes(&self) -> u64 {
        self.history.iter().map(|(_, bytes)| bytes).sum()
    }
}

/// Looks how much a data folder holds. What is written meanwhile may be counted or not.
///
/// # Errors
/// When folders cannot be read.
pub fn usage(data: &Path) -> Result<Usage> {
    let mut usage = Usage::default();
    let root = data.join("archive");
    for key in archive::days(&root)? {
        let folder = key.folder(&root);
        let day = key.start().unwrap_or_default();
        let new = Archives { bytes: 0, days: 0, first: day, last: day };
        let one = usage.archive.entry(key.src).or_insert(new);
        one.bytes += archive::bytes::disk_bytes(&folder);
        one.days += u32::from(key.part == 0);
        (one.first, one.last) = (one.first.min(day), one.last.max(day));
    }
    let folder = data.join("history");
    let months = history::months(&folder)?.into_iter().map(history::MonthKey::file_name);
    for name in months.chain([history::CATALOGUE.to_owned()]) {
        let path = folder.join(&name);
        // Beside a database lies what was not yet written into it.
        let size = |end: &str| fs::metadata(folder.join(format!("{name}{end}"))).map_or(0, |file| file.len());
        if path.try_exists().named(&path)? {
            usage.history.push((name.clone(), size("") + size("-wal")));
        }
    }
    Ok(usage)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Accepted, Store, Transport};
    use imc::Header;
    use imc::messages::Temperature;

    #[test]
    fn what_is_there_is_counted_by_system_and_file() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(usage(folder.path()).unwrap(), Usage::default());
        let mut store = Store::open(folder.path()).unwrap();
        for (src, day) in [(0x2810, 0), (0x2810, 40), (0x2811, 1)] {
            let received = UtcTime::from_micros(1_800_000_000_000_000 + day * 86_400_000_000);
            let header = Header { timestamp: received.seconds(), src: Address(src), ..Header::default() };
            let mut packet = Vec::new();
            imc::encode_into(&mut packet, &header, &Temperature { value: 1.0 }).unwrap();
            store
                .accept(&Accepted { packet: &packet, received, transport: Transport::Tcp, link: None })
                .unwrap();
        }
        store.close().unwrap();
        let usage = usage(folder.path()).unwrap();
        let one = usage.archive[&Address(0x2810)];
        assert_eq!((one.days, one.last - one.first), (2, 40 * 86_400_000_000));
        assert!(one.bytes > 0 && usage.archive_bytes() > one.bytes);
        let names: Vec<&str> = usage.history.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["2027-01.sqlite", "2027-02.sqlite", "catalogue.sqlite"]);
        assert!(usage.history.iter().all(|(_, bytes)| *bytes > 0));
    }
}
