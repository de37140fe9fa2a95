//! All certificates that the VPN's authority ever signed: `openvpn.issued` in the fleet's folder, a line for each.
//!
//! A line is on disk before its certificate is written anywhere, and lines are never removed. So a certificate can be revoked
//! whatever became of the vessel's own file. A last line without its end is of a run that was killed: its
//! certificate was never made.

use super::super::files;
use super::certificates::{Purpose, Serial};
use anyhow::ensure;
use std::fmt;
use std::path::Path;
use units::UtcTime;

/// A certificate that was signed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Issued {
    pub(super) serial: Serial,
    pub(super) at: UtcTime,
    pub(super) purpose: Purpose,
    /// Whose it is.
    pub(super) name: String,
}

impl Issued {
    /// Reads what `Display` wrote.
    fn parse(line: &str) -> Option<Self> {
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let [serial, at, purpose, name] = words[..] else { return None };
        Some(Self {
            serial: Serial::parse(serial)?,
            at: UtcTime::from_micros(at.parse().ok()?),
            purpose: Purpose::parse(purpose)?,
            name: name.to_owned(),
        })
    }
}

impl fmt::Display for Issued {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {} {} {}", self.serial, self.at.micros(), self.purpose, self.name)
    }
}

/// The list, as far as it can be read.
#[derive(Debug, Default)]
pub(super) struct IssuedList {
    all: Vec<Issued>,
    /// Numbers of the lines that cannot be read, from 1.
    damaged: Vec<usize>,
}

impl IssuedList {
    /// Reads the list; an absent one is empty.
    pub(super) fn read(path: &Path) -> anyhow::Result<Self> {
        let Some(text) = files::read(path)? else { return Ok(Self::default()) };
        let whole = text.rsplit_once('\n').map_or("", |(whole, _)| whole);
        let mut list = Self::default();
        for (at, line) in whole.lines().enumerate() {
            match Issued::parse(line) {
                Some(issued) => list.all.push(issued),
                None => list.damaged.push(at + 1),
            }
        }
        Ok(list)
    }

    /// Adds a certificate to the list on disk.
    pub(super) fn add(path: &Path, issued: &Issued) -> anyhow::Result<()> {
        files::append(path, &issued.to_string())
    }

    /// Whether a certificate is in it.
    pub(super) fn has(&self, serial: Serial) -> bool {
        self.all.iter().any(|one| one.serial == serial)
    }

    /// All certificates of vessels.
    pub(super) fn of_vessels(&self) -> impl Iterator<Item = &Issued> {
        self.all.iter().filter(|one| one.purpose == Purpose::Vessel)
    }

    /// Fails if a line of it cannot be read.
    pub(super) fn check(&self, path: &Path) -> anyhow::Result<()> {
        let lines: Vec<String> = self.damaged.iter().map(ToString::to_string).collect();
        ensure!(
            lines.is_empty(),
            "line {} of {} cannot be read, and the certificate that it names can be revoked only once it can: bring the file back \
             from a backup; without one remove openvpn.key beside it, and `lutra-server fleet apply` makes a new authority: every \
             boat then needs a new bundle",
            lines.join(", "),
            path.display()
        );
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::io::Write as _;

    #[test]
    fn the_list_grows_and_a_line_that_was_cut_off_is_not_in_it() {
        let data = tempfile::tempdir().unwrap();
        let path = data.path().join("fleet/openvpn.issued");
        let issued = |byte: u8, name: &str| Issued {
            serial: Serial([byte; 16]),
            at: UtcTime::from_micros(1_795_700_000_000_000),
            purpose: Purpose::Vessel,
            name: name.to_owned(),
        };
        assert!(!IssuedList::read(&path).unwrap().has(Serial([1; 16])));
        IssuedList::add(&path, &issued(1, "otter-01")).unwrap();
        // A run that was killed in the middle of a line.
        fs::OpenOptions::new().append(true).open(&path).unwrap().write_all(b"0202").unwrap();
        IssuedList::read(&path).unwrap().check(&path).unwrap();
        IssuedList::add(&path, &issued(3, "otter-02")).unwrap();
        let list = IssuedList::read(&path).unwrap();
        list.check(&path).unwrap();
        assert_eq!(list.all, [issued(1, "otter-01"), issued(3, "otter-02")]);

        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, text.replacen("01", "zz", 1)).unwrap();
        let list = IssuedList::read(&path).unwrap();
        assert!(list.has(Serial([3; 16])), "the others can still be read");
        let why = list.check(&path).unwrap_err().to_string();
        assert!(why.contains("line 1 of") && why.contains("from a backup"), "{why}");
    }
}
