//! The head and the seek table of a compressed file: parsed from bytes that may be damaged, and written.
//!
//! | head, offset | bytes | field, little-endian |
//! |---|---|---|
//! | 0 | 4 | magic number of a skippable frame, 0x184D2A50 |
//! | 4 | 4 | bytes that follow, 54 |
//! | 8 | 5 | `LUTRA` |
//! | 13 | 1 | version, 1 |
//! | 14 | 1 | what the frames hold: 0 bytes of the plain file, 1 columns of records |
//! | 15 | 1 | 0 |
//! | 16 | 4 | bytes of the plain file in each frame but the last |
//! | 20 | 8 | bytes of the plain file |
//! | 28 | 32 | SHA-256 of the plain file |
//! | 60 | 2 | CRC-16 of the 60 bytes before |

use super::super::ARRIVAL_BYTES;
use std::io;

/// Bytes of the head.
pub(super) const HEAD_BYTES: usize = 62;
/// Bytes of the plain file in a frame.
pub(crate) const FRAME_BYTES: u32 = 1 << 20;
/// Bytes of the footer of a seek table.
pub(super) const FOOTER_BYTES: usize = 9;
const HEAD_MAGIC: u32 = 0x184D_2A50;
const TABLE_MAGIC: u32 = 0x184D_2A5E;
const SEEKABLE_MAGIC: u32 = 0x8F92_EAB1;
const SIGN: &[u8; 5] = b"LUTRA";
const VERSION: u8 = 1;
/// Bytes of a skippable frame before its contents.
const SKIPPABLE_BYTES: usize = 8;
const ENTRY_BYTES: usize = 8;
/// The descriptor's bit that announces checksums in the table.
const HAS_CHECKSUMS: u8 = 1 << 7;

/// What the frames of a file hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Coding {
    /// The bytes of the plain file.
    Bytes,
    /// Columns of records of arrival.
    Records,
}

/// What a file says about the plain file that it was made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Head {
    pub(super) coding: Coding,
    /// Bytes of the plain file in each frame but the last.
    pub(super) frame_bytes: u32,
    pub(super) plain_bytes: u64,
    pub(super) sha256: [u8; 32],
}

/// A frame's place in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Frame {
    pub(super) at: u64,
    /// Bytes in the file.
    pub(super) packed: u32,
    /// Bytes that it unpacks to.
    pub(super) unpacked: u32,
}

/// The error for a file that is not one of these, or is damaged.
pub(super) fn damaged(what: &'static str) -> io::Error {
    io::Error::new(
        io::ErrorKind::InvalidData,
        format!("cannot be unpacked: {what}; copy the file from a backup"),
    )
}

impl Head {
    pub(super) fn write(&self) -> [u8; HEAD_BYTES] {
        let mut out = [0; HEAD_BYTES];
        out[0..4].copy_from_slice(&HEAD_MAGIC.to_le_bytes());
        out[4..8].copy_from_slice(&((HEAD_BYTES - SKIPPABLE_BYTES) as u32).to_le_bytes());
        out[8..13].copy_from_slice(SIGN);
        out[13] = VERSION;
        out[14] = match self.coding {
            Coding::Bytes => 0,
            Coding::Records => 1,
        };
        out[16..20].copy_from_slice(&self.frame_bytes.to_le_bytes());
        out[20..28].copy_from_slice(&self.plain_bytes.to_le_bytes());
        out[28..60].copy_from_slice(&self.sha256);
        let crc = imc::crc16(&out[..60]);
        out[60..62].copy_from_slice(&crc.to_le_bytes());
        out
    }

    pub(super) fn read(bytes: &[u8; HEAD_BYTES]) -> io::Result<Self> {
        let is_head = number(&bytes[0..4]) == u64::from(HEAD_MAGIC)
            && number(&bytes[4..8]) == (HEAD_BYTES - SKIPPABLE_BYTES) as u64
            && bytes[8..13] == *SIGN;
        if !is_head || number(&bytes[60..62]) != u64::from(imc::crc16(&bytes[..60])) {
            return Err(damaged("its head is damaged"));
        }
        if bytes[13] != VERSION {
            return Err(damaged("a later version of Lutra wrote it"));
        }
        let coding = match bytes[14] {
            0 => Coding::Bytes,
            1 => Coding::Records,
            _ => return Err(damaged("its head is damaged")),
        };
        let frame_bytes = number(&bytes[16..20]) as u32;
        let fits = (1..=FRAME_BYTES).contains(&frame_bytes)
            && (coding == Coding::Bytes || (frame_bytes as usize).is_multiple_of(ARRIVAL_BYTES));
        if !fits {
            return Err(damaged("its head is damaged"));
        }
        let mut sha256 = [0; 32];
        sha256.copy_from_slice(&bytes[28..60]);
        Ok(Self { coding, frame_bytes, plain_bytes: number(&bytes[20..28]), sha256 })
    }

    /// How many frames the plain file fills.
    pub(super) fn frames(&self) -> u64 {
        self.plain_bytes.div_ceil(u64::from(self.frame_bytes))
    }

    /// Bytes of the plain file in a frame.
    pub(super) fn plain_in(&self, frame: u64) -> u64 {
        let start = frame.saturating_mul(u64::from(self.frame_bytes));
        self.plain_bytes.saturating_sub(start).min(self.frame_bytes.into())
    }
}

/// Bytes of the seek table of so many frames, the head among them.
pub(super) fn table_bytes(frames: u64) -> u64 {
    (SKIPPABLE_BYTES + FOOTER_BYTES) as u64 + frames * ENTRY_BYTES as u64
}

/// The seek table of a file with a head and these frames (packed and unpacked bytes of each).
pub(super) fn write_table(frames: &[(u32, u32)]) -> Vec<u8> {
    let count = frames.len() as u32 + 1;
    let mut out = Vec::with_capacity(table_bytes(count.into()) as usize);
    out.extend_from_slice(&TABLE_MAGIC.to_le_bytes());
    out.extend_from_slice(&(count * ENTRY_BYTES as u32 + FOOTER_BYTES as u32).to_le_bytes());
    for (packed, unpacked) in [(HEAD_BYTES as u32, 0)].iter().chain(frames) {
        out.extend_from_slice(&packed.to_le_bytes());
        out.extend_from_slice(&unpacked.to_le_bytes());
    }
    out.extend_from_slice(&count.to_le_bytes());
    out.push(0);
    out.extend_from_slice(&SEEKABLE_MAGIC.to_le_bytes());
    out
}

/// How many frames the footer of a file says that there are, the head among them.
pub(super) fn read_footer(footer: &[u8; FOOTER_BYTES]) -> io::Result<u64> {
    if number(&footer[5..9]) != u64::from(SEEKABLE_MAGIC) || footer[4] & HAS_CHECKSUMS != 0 {
        return Err(damaged("its seek table is damaged"));
    }
    Ok(number(&footer[0..4]))
}

/// The frames that a seek table names, held against the head and the length of the file.
pub(super) fn read_table(head: &Head, table: &[u8], file_bytes: u64) -> io::Result<Vec<Frame>> {
    let bad = || damaged("its seek table is damaged");
    let entries = table.get(SKIPPABLE_BYTES..table.len().saturating_sub(FOOTER_BYTES)).ok_or_else(bad)?;
    let is_table = number(&table[0..4]) == u64::from(TABLE_MAGIC)
        && number(&table[4..8]) == (table.len() - SKIPPABLE_BYTES) as u64;
    let (entries, rest) = entries.as_chunks::<ENTRY_BYTES>();
    let (first, entries) = entries.split_first().ok_or_else(bad)?;
    let begins = number(&first[0..4]) == HEAD_BYTES as u64 && number(&first[4..8]) == 0;
    if !is_table || !rest.is_empty() || !begins || entries.len() as u64 != head.frames() {
        return Err(bad());
    }
    let (mut at, mut frames) = (HEAD_BYTES as u64, Vec::with_capacity(entries.len()));
    for (frame, entry) in (0..).zip(entries) {
        let (packed, unpacked) = (number(&entry[0..4]) as u32, number(&entry[4..8]) as u32);
        let plain = head.plain_in(frame) as u32;
        let fits = match head.coding {
            Coding::Bytes => unpacked == plain,
            // Columns that would not be smaller are left out for the records, behind one byte.
            Coding::Records => (1..=plain + 1).contains(&unpacked),
        };
        // What zstd makes of noise, and more: nothing larger is ever read at once.
        if !fits || packed == 0 || packed > unpacked + unpacked / 128 + 1024 {
            return Err(bad());
        }
        frames.push(Frame { at, packed, unpacked });
        at += u64::from(packed);
    }
    if at + table.len() as u64 != file_bytes {
        return Err(bad());
    }
    Ok(frames)
}

fn number(bytes: &[u8]) -> u64 {
    let mut le = [0; 8];
    le[..bytes.len()].copy_from_slice(bytes);
    u64::from_le_bytes(le)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn head() -> Head {
        Head { coding: Coding::Bytes, frame_bytes: 100, plain_bytes: 250, sha256: [7; 32] }
    }

    #[test]
    fn a_head_comes_back_and_a_damaged_one_does_not() {
        let bytes = head().write();
        assert_eq!(Head::read(&bytes).unwrap(), head());
        for bit in 0..HEAD_BYTES * 8 {
            let mut damaged = bytes;
            damaged[bit / 8] ^= 1 << (bit % 8);
            Head::read(&damaged).unwrap_err();
        }
    }

    #[test]
    fn a_table_comes_back_and_one_that_does_not_fit_its_file_is_refused() {
        let table = write_table(&[(90, 100), (80, 100), (40, 50)]);
        let file_bytes = HEAD_BYTES as u64 + 210 + table.len() as u64;
        let frames = read_table(&head(), &table, file_bytes).unwrap();
        assert_eq!(frames[1], Frame { at: HEAD_BYTES as u64 + 90, packed: 80, unpacked: 100 });
        let mut footer = [0; FOOTER_BYTES];
        footer.copy_from_slice(&table[table.len() - FOOTER_BYTES..]);
        assert_eq!(read_footer(&footer).unwrap(), 4);
        for other in [file_bytes - 1, file_bytes + 1, 0, u64::MAX] {
            read_table(&head(), &table, other).unwrap_err();
        }
        for cut in 0..table.len() {
            read_table(&head(), &table[..cut], file_bytes).unwrap_err();
        }
        // Frames that are not those of the plain file, and one that is much too large.
        for frames in [
            &[(90, 100), (80, 100)][..],
            &[(90, 100), (80, 99), (40, 51)],
            &[(90, 100), (2_000, 100), (40, 50)],
        ] {
            let table = write_table(frames);
            let packed: u32 = frames.iter().map(|(packed, _)| packed).sum();
            read_table(&head(), &table, HEAD_BYTES as u64 + u64::from(packed) + table.len() as u64)
                .unwrap_err();
        }
    }
}
