//! Unpacking gzip (RFC 1952) without losing data before, between or behind damage.
//!
//! A vehicle that loses its power leaves a log whose last block is cut, or followed by zeros. General readers
//! throw away what they unpacked in the same call as they met the error; this one hands out every byte first,
//! reports the damage and continues at the next member.

use flate2::{Crc, Decompress, FlushDecompress, Status};
use std::io::{self, Read};

/// The first bytes of a member: magic and the only method there is (RFC 1952, 2.3.1).
pub(super) const MAGIC: [u8; 3] = [0x1F, 0x8B, 8];
/// Bytes that are read at once.
const INPUT_BYTES: usize = 1 << 16;
/// Longest header that is taken for one; names and comments have no bound of their own.
const MAX_HEADER_BYTES: usize = 1 << 16;
/// Bytes of a member's checksum and size.
const TRAILER_BYTES: usize = 8;

/// The result of a read.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Unpacked {
    /// So many bytes.
    Bytes(usize),
    /// Data is missing here.
    Damage(&'static str),
    /// The end.
    End,
}

/// A source of gzip being unpacked.
#[derive(Debug)]
pub(super) struct Gunzip<R> {
    source: R,
    input: Vec<u8>,
    at: usize,
    ended: bool,
    state: State,
    inflate: Decompress,
    crc: Crc,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// Before the first member.
    First,
    /// After a whole member: another one, zeros for padding or the end may follow.
    Between,
    /// Inside a member.
    Inflating,
    /// Before a member's checksum and size.
    Trailer,
    /// At damage inside a member.
    Damaged,
    /// After damage, looking for the next member.
    Lost,
}

impl<R: Read> Gunzip<R> {
    pub(super) fn new(source: R) -> Self {
        Self {
            source,
            input: Vec::new(),
            at: 0,
            ended: false,
            state: State::First,
            inflate: Decompress::new(false),
            crc: Crc::new(),
        }
    }

    /// Unpacks into `out`, which must not be empty.
    pub(super) fn read(&mut self, out: &mut [u8]) -> io::Result<Unpacked> {
        loop {
            let step = match self.state {
                State::First | State::Between => self.header()?,
                State::Inflating => self.inflate(out)?,
                State::Trailer => self.trailer()?,
                State::Damaged => Some(self.damage("the compressed bytes are damaged")),
                State::Lost => self.find_member()?,
            };
            if let Some(step) = step {
                return Ok(step);
            }
        }
    }

    fn rest(&self) -> &[u8] {
        &self.input[self.at..]
    }

    /// Reads more input behind what is left; false at the end of the source.
    fn fill(&mut self) -> io::Result<bool> {
        self.input.drain(..self.at);
        self.at = 0;
        let held = self.input.len();
        self.input.resize(held + INPUT_BYTES, 0);
        let count = loop {
            match self.source.read(&mut self.input[held..]) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                other => break other,
            }
        };
        self.input.truncate(held + *count.as_ref().unwrap_or(&0));
        self.ended = count? == 0;
        Ok(!self.ended)
    }

    fn damage(&mut self, what: &'static str) -> Unpacked {
        self.state = State::Lost;
        Unpacked::Damage(what)
    }

    /// The start of a member, or padding, or the end.
    fn header(&mut self) -> io::Result<Option<Unpacked>> {
        if self.state == State::Between {
            // `tar` and block devices pad with zeros.
            self.at += self.rest().iter().take_while(|byte| **byte == 0).count();
        }
        if self.rest().is_empty() {
            return Ok(if self.fill()? { None } else { Some(Unpacked::End) });
        }
        match header_bytes(self.rest()) {
            Some(Header::Whole(count)) => {
                self.at += count;
                self.inflate.reset(false);
                self.crc = Crc::new();
                self.state = State::Inflating;
                Ok(None)
            }
            Some(Header::Cut) if self.rest().len() < MAX_HEADER_BYTES => {
                if self.fill()? {
                    return Ok(None);
                }
                self.at = self.input.len();
                Ok(Some(self.damage("the file ends inside the header of a gzip member")))
            }
            _ => {
                // What only looks like one must not be found again.
                self.at += 1;
                Ok(Some(self.damage("what follows is not gzip member")))
            }
        }
    }

    fn inflate(&mut self, out: &mut [u8]) -> io::Result<Option<Unpacked>> {
        if self.rest().is_empty() && !self.ended {
            self.fill()?;
        }
        let flush = if self.ended { FlushDecompress::Finish } else { FlushDecompress::None };
        let (before_in, before_out) = (self.inflate.total_in(), self.inflate.total_out());
        let status = self.inflate.decompress(&self.input[self.at..], out, flush);
        // Both fit: they are at most the lengths of the two slices.
        let count = (self.inflate.total_out() - before_out) as usize;
        self.at += (self.inflate.total_in() - before_in) as usize;
        self.crc.update(&out[..count]);
        let stuck = count == 0 && self.inflate.total_in() == before_in;
        match status {
            Ok(Status::StreamEnd) => self.state = State::Trailer,
            Ok(Status::Ok | Status::BufError) if stuck && self.ended && self.rest().is_empty() => {
                return Ok(Some(self.damage("the file ends inside a gzip member")));
            }
            Ok(Status::Ok | Status::BufError) if !stuck || self.rest().is_empty() => {}
            _ => self.state = State::Damaged,
        }
        // First what was unpacked before the damage, then the damage.
        Ok((count > 0).then_some(Unpacked::Bytes(count)))
    }

    fn trailer(&mut self) -> io::Result<Option<Unpacked>> {
        let Some(trailer) = self.rest().first_chunk::<TRAILER_BYTES>() else {
            if self.fill()? {
                return Ok(None);
            }
            self.at = self.input.len();
            return Ok(Some(self.damage("the file ends before the checksum of a gzip member")));
        };
        let [a, b, c, d, e, f, g, h] = *trailer;
        let stated = (u32::from_le_bytes([a, b, c, d]), u32::from_le_bytes([e, f, g, h]));
        self.at += TRAILER_BYTES;
        self.state = State::Between;
        let whole = stated == (self.crc.sum(), self.crc.amount());
        Ok((!whole).then_some(Unpacked::Damage("a gzip member does not match its checksum")))
    }

    /// Goes to the next place where a member may start.
    fn find_member(&mut self) -> io::Result<Option<Unpacked>> {
        let found = self.rest().windows(MAGIC.len()).position(|window| window == MAGIC);
        if let Some(found) = found {
            self.at += found;
            self.state = State::Between;
            return Ok(None);
        }
        // The last two bytes may be the start of one.
        self.at = self.at.max((self.input.len() + 1).saturating_sub(MAGIC.len()));
        if self.fill()? { Ok(None) } else { Ok(Some(Unpacked::End)) }
    }
}

enum Header {
    Whole(usize),
    Cut,
}

/// How long the header of the member that `bytes` start with is; `None` when they start none.
fn header_bytes(bytes: &[u8]) -> Option<Header> {
    const FIXED_BYTES: usize = 10;
    let known = bytes.len().min(MAGIC.len());
    if bytes[..known] != MAGIC[..known] {
        return None;
    }
    let Some(fixed) = bytes.first_chunk::<FIXED_BYTES>() else { return Some(Header::Cut) };
    let flags = fixed[3];
    let [check, extra, name, comment] = [1, 2, 3, 4].map(|bit| flags >> bit & 1 == 1);
    if flags >> 5 != 0 {
        return None;
    }
    let mut at = FIXED_BYTES;
    if extra {
        let Some([low, high]) = bytes[at..].first_chunk::<2>() else { return Some(Header::Cut) };
        at += 2 + usize::from(u16::from_le_bytes([*low, *high]));
    }
    for _ in 0..usize::from(name) + usize::from(comment) {
        let rest = bytes.get(at..).unwrap_or_default();
        let Some(end) = rest.iter().position(|byte| *byte == 0) else { return Some(Header::Cut) };
        at += end + 1;
    }
    at += if check { 2 } else { 0 };
    Some(if at <= bytes.len() { Header::Whole(at) } else { Header::Cut })
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::{Compression, GzBuilder, write::GzEncoder};
    use std::io::Write as _;

    fn member(content: &[u8]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
        encoder.write_all(content).unwrap();
        encoder.finish().unwrap()
    }

    /// Everything, with damage in its place.
    fn all(bytes: &[u8]) -> (Vec<u8>, Vec<(usize, &'static str)>) {
        // One byte at a time, so that every state meets the end of its input.
        let mut gunzip = Gunzip::new(OneByOne(bytes));
        let (mut out, mut damage, mut chunk) = (Vec::new(), Vec::new(), [0; 7]);
        loop {
            match gunzip.read(&mut chunk).unwrap() {
                Unpacked::Bytes(count) => out.extend_from_slice(&chunk[..count]),
                Unpacked::Damage(what) => damage.push((out.len(), what)),
                Unpacked::End => return (out, damage),
            }
        }
    }

    struct OneByOne<'a>(&'a [u8]);

    impl Read for OneByOne<'_> {
        fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
            let count = self.0.len().min(1);
            out[..count].copy_from_slice(&self.0[..count]);
            self.0 = &self.0[count..];
            Ok(count)
        }
    }

    #[test]
    fn members_padding_and_all_header_fields_are_read() {
        let builder = GzBuilder::new().filename("Data.lsf").comment("a log").extra(vec![1, 2, 3]);
        let mut encoder = builder.write(Vec::new(), Compression::best());
        encoder.write_all(b"two").unwrap();
        let second = encoder.finish().unwrap();
        let bytes =
            [&member(b"one")[..], &second, &[0; 40], &member(b""), &member(b"three"), &[0; 9]].concat();
        assert_eq!(all(&bytes), (b"onetwothree".to_vec(), vec![]));
        assert_eq!(all(b""), (vec![], vec![]));
    }

    #[test]
    fn a_cut_gives_all_that_the_bytes_hold() {
        let content: Vec<u8> = (0..80_u32).flat_map(|n| (n * n).to_le_bytes()).collect();
        let whole = member(&content);
        let mut longest = 0;
        for cut in 1..whole.len() {
            let (out, damage) = all(&whole[..cut]);
            assert_eq!(out, content[..out.len()]);
            assert_eq!(damage.len(), 1, "cut at {cut}");
            assert!(out.len() >= longest, "cut at {cut}");
            longest = out.len();
        }
        assert_eq!(longest, content.len());
    }

    #[test]
    fn what_was_flushed_is_read_whatever_follows() {
        let content: Vec<u8> = (0..500_u32).flat_map(u32::to_le_bytes).collect();
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(&content).unwrap();
        encoder.flush().unwrap();
        let flushed = encoder.get_ref().clone();
        for tail in [&[0_u8; 5][..], &[0; 4_096], &[0xFF; 100], b"rubbish", b""] {
            let (out, damage) = all(&[&flushed[..], tail].concat());
            assert!(out.starts_with(&content), "{} of {}", out.len(), content.len());
            assert!(!damage.is_empty());
        }
    }

    #[test]
    fn members_behind_damage_are_found() {
        let (one, two) = (member(b"first member"), member(b"second member"));
        let mut bad_crc = one.clone();
        let last = bad_crc.len() - 5;
        bad_crc[last] ^= 1;
        let (out, damage) = all(&[&bad_crc[..], &two].concat());
        assert_eq!((out, damage.len()), (b"first membersecond member".to_vec(), 1));
        let (out, damage) = all(&[&one[..], b"\x1f\x8b\x1f rubbish", &two].concat());
        assert_eq!((out, damage.len()), (b"first membersecond member".to_vec(), 1));
        let (out, damage) = all(&[&one[..one.len() - 9], b"\x1f\x8b\x08\xff", &two].concat());
        assert!(out.ends_with(b"second member") && !damage.is_empty(), "{damage:?}");
    }
}
