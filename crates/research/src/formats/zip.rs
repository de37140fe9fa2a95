//! A zip file, written from its beginning to its end without looking back (APPNOTE 6.3, with data descriptors).
//!
//! Own code, as rows are written to a target that is handed in anew for each of them, while the crate `zip` must own its target.
//!
//! Times in it are all 1980-01-01, so that the same rows give the same bytes. Without the additions for large files an entry, and where the
//! last one begins, stay below 4 GiB: what would be longer is an error that says so.

use flate2::Compression;
use flate2::write::DeflateEncoder;
use std::io::{self, Write};

/// 1980-01-01, as DOS counts days.
const DAY: u16 = 0x21;
/// Sizes follow the data; names are UTF-8.
const FLAGS: u16 = 0x0808;
const DEFLATED: u16 = 8;
/// Of the program that reads it: 2.0.
const VERSION: u16 = 20;

/// A zip file on its way.
#[derive(Debug, Default)]
pub(super) struct Zip {
    entries: Vec<Entry>,
    open: Option<Open>,
    written: u64,
}

#[derive(Debug)]
struct Entry {
    name: &'static str,
    begins: u32,
    crc: u32,
    packed: u32,
    bytes: u32,
}

#[derive(Debug)]
struct Open {
    name: &'static str,
    begins: u32,
    crc: crc32fast::Hasher,
    packer: DeflateEncoder<Vec<u8>>,
    packed: u64,
    bytes: u64,
}

impl Zip {
    /// Begins a file in it; one that is open is closed before.
    ///
    /// # Errors
    /// `out` cannot be written, or the zip file is too long.
    pub(super) fn begin(&mut self, out: &mut dyn Write, name: &'static str) -> io::Result<()> {
        self.close(out)?;
        let begins = fits(self.written)?;
        let mut header = Vec::new();
        header.extend_from_slice(b"PK\x03\x04");
        shorts(&mut header, &[VERSION, FLAGS, DEFLATED, 0, DAY]);
        words(&mut header, &[0, 0, 0]);
        shorts(&mut header, &[name.len() as u16, 0]);
        header.extend_from_slice(name.as_bytes());
        self.put(out, &header)?;
        let packer = DeflateEncoder::new(Vec::new(), Compression::default());
        self.open = Some(Open { name, begins, crc: crc32fast::Hasher::new(), packer, packed: 0, bytes: 0 });
        Ok(())
    }

    /// Appends to the file that is open.
    ///
    /// # Errors
    /// As [`Self::begin()`], or none is open.
    pub(super) fn push(&mut self, out: &mut dyn Write, bytes: &[u8]) -> io::Result<()> {
        let Some(open) = &mut self.open else {
            return Err(io::Error::other("no file of the archive is open"));
        };
        open.crc.update(bytes);
        open.bytes += bytes.len() as u64;
        open.packer.write_all(bytes)?;
        let ready = std::mem::take(open.packer.get_mut());
        open.packed += ready.len() as u64;
        self.put(out, &ready)
    }

    fn close(&mut self, out: &mut dyn Write) -> io::Result<()> {
        let Some(open) = self.open.take() else { return Ok(()) };
        let ready = open.packer.finish()?;
        self.put(out, &ready)?;
        let (packed, bytes) = (fits(open.packed + ready.len() as u64)?, fits(open.bytes)?);
        let entry = Entry { name: open.name, begins: open.begins, crc: open.crc.finalize(), packed, bytes };
        let mut descriptor = b"PK\x07\x08".to_vec();
        words(&mut descriptor, &[entry.crc, packed, bytes]);
        self.entries.push(entry);
        self.put(out, &descriptor)
    }

    /// Closes it, with the list of its files.
    ///
    /// # Errors
    /// As [`Self::begin()`].
    pub(super) fn end(mut self, out: &mut dyn Write) -> io::Result<()> {
        self.close(out)?;
        let begins = fits(self.written)?;
        let mut list = Vec::new();
        for Entry { name, begins, crc, packed, bytes } in &self.entries {
            list.extend_from_slice(b"PK\x01\x02");
            shorts(&mut list, &[VERSION, VERSION, FLAGS, DEFLATED, 0, DAY]);
            words(&mut list, &[*crc, *packed, *bytes]);
            // No further field, no comment, on the first disk, no attributes.
            shorts(&mut list, &[name.len() as u16, 0, 0, 0, 0]);
            words(&mut list, &[0, *begins]);
            list.extend_from_slice(name.as_bytes());
        }
        let (count, bytes) = (self.entries.len() as u16, list.len() as u32);
        list.extend_from_slice(b"PK\x05\x06");
        shorts(&mut list, &[0, 0, count, count]);
        words(&mut list, &[bytes, begins]);
        shorts(&mut list, &[0]);
        self.put(out, &list)
    }

    fn put(&mut self, out: &mut dyn Write, bytes: &[u8]) -> io::Result<()> {
        self.written += bytes.len() as u64;
        out.write_all(bytes)
    }
}

fn shorts(out: &mut Vec<u8>, values: &[u16]) {
    for value in values {
        out.extend_from_slice(&value.to_le_bytes());
    }
}

fn words(out: &mut Vec<u8>, values: &[u32]) {
    for value in values {
        out.extend_from_slice(&value.to_le_bytes());
    }
}

fn fits(bytes: u64) -> io::Result<u32> {
    u32::try_from(bytes).map_err(|_| {
        io::Error::new(
            io::ErrorKind::FileTooLarge,
            "the archive would have a part of more than 4 GiB, which no zip file of this kind holds; ask for a shorter time",
        )
    })
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use std::io::Read as _;

    fn word(bytes: &[u8], at: usize) -> usize {
        u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize
    }

    fn short(bytes: &[u8], at: usize) -> usize {
        u16::from_le_bytes(bytes[at..at + 2].try_into().unwrap()).into()
    }

    /// The files of an archive by its list, each with its length and checksum compared.
    pub(crate) fn unzipped(bytes: &[u8]) -> Vec<(String, String)> {
        let end = bytes.len() - 22;
        assert_eq!(&bytes[end..end + 4], b"PK\x05\x06");
        let (count, mut at) = (short(bytes, end + 10), word(bytes, end + 16));
        let mut files = Vec::new();
        for _ in 0..count {
            assert_eq!(&bytes[at..at + 4], b"PK\x01\x02");
            let (crc, packed, length) = (word(bytes, at + 16), word(bytes, at + 20), word(bytes, at + 24));
            let (name, begins) = (short(bytes, at + 28), word(bytes, at + 42));
            let name = String::from_utf8(bytes[at + 46..at + 46 + name].to_vec()).unwrap();
            at += 46 + name.len();
            assert_eq!(&bytes[begins..begins + 4], b"PK\x03\x04");
            let data = begins + 30 + short(bytes, begins + 26) + short(bytes, begins + 28);
            let mut text = String::new();
            flate2::read::DeflateDecoder::new(&bytes[data..data + packed]).read_to_string(&mut text).unwrap();
            assert_eq!((text.len(), crc32fast::hash(text.as_bytes()) as usize), (length, crc), "{name}");
            assert_eq!(&bytes[data + packed..data + packed + 4], b"PK\x07\x08");
            assert_eq!(word(bytes, data + packed + 4), crc, "{name}");
            files.push((name, text));
        }
        assert_eq!(at, end);
        files
    }

    #[test]
    fn files_come_out_as_they_went_in() {
        let (mut zip, mut out) = (Zip::default(), Vec::new());
        let long = "salmon ".repeat(50_000);
        zip.begin(&mut out, "a.csv").unwrap();
        zip.push(&mut out, long.as_bytes()).unwrap();
        zip.push(&mut out, b"end").unwrap();
        zip.begin(&mut out, "empty.xml").unwrap();
        zip.end(&mut out).unwrap();
        assert!(out.len() < long.len() / 50, "{} bytes", out.len());
        let files = unzipped(&out);
        assert_eq!(
            files,
            [("a.csv".to_owned(), format!("{long}end")), ("empty.xml".to_owned(), String::new())]
        );
        assert!(Zip::default().push(&mut out, b"x").is_err(), "no file is open");
    }
}
