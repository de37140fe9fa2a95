//! Logs that zstd packed, such as `Data.lsf.zst` of compressed days in a server's archive.
//!
//! What was unpacked before a cut or damage is read as of a whole log; the problem is kept and reported at the end.

use ::zstd::stream::read::Decoder;
use std::io::{self, BufReader, Read};

/// Memory that a file can ask for: 8 MiB (a power of two), as the format recommends for those who decode, and as the server's import allows.
const WINDOW_LOG: u32 = 23;
/// The magic numbers of a frame, and of a skippable one, whose last four bits are free (RFC 8878, 3.1).
const MAGIC: u32 = 0xFD2F_B528;
const SKIPPABLE: u32 = 0x184D_2A50;

pub(super) const MAGIC_BYTES: u64 = 4;

/// Whether zstd packed a file that starts with these bytes.
pub(super) fn is_packed(start: &[u8]) -> bool {
    let magic = start.first_chunk().copied().map_or(0, u32::from_le_bytes);
    magic == MAGIC || magic & !0xF == SKIPPABLE
}

/// The unpacked bytes of a source, up to its first damage.
pub(super) struct Unpacked<R: Read> {
    decoder: Decoder<'static, BufReader<R>>,
    problem: Option<&'static str>,
}

impl<R: Read> Unpacked<R> {
    pub(super) fn new(source: R) -> io::Result<Self> {
        let mut decoder = Decoder::new(source)?;
        decoder.window_log_max(WINDOW_LOG)?;
        Ok(Self { decoder, problem: None })
    }

    /// Why it ended before the end of the file.
    pub(super) fn problem(&self) -> Option<&'static str> {
        self.problem
    }
}

impl<R: Read> Read for Unpacked<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        if self.problem.is_some() {
            return Ok(0);
        }
        let error = match self.decoder.read(into) {
            // Errors of the system have its number, those of zstd have not.
            Err(error) if error.raw_os_error().is_none() && error.kind() != io::ErrorKind::Interrupted => {
                error
            }
            other => return other,
        };
        if error.to_string().contains("too much memory") {
            return Err(io::Error::other(
                "it was packed with a window of more than 8 MiB; unpack it first: zstd -d --long=31 FILE",
            ));
        }
        self.problem = Some(if error.kind() == io::ErrorKind::UnexpectedEof {
            "the file ends inside a zstd frame"
        } else {
            "a zstd frame is damaged, and what follows is not read"
        });
        Ok(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::zstd::{Encoder, encode_all};

    fn all(bytes: &[u8]) -> io::Result<(Vec<u8>, Option<&'static str>)> {
        let (mut source, mut out) = (Unpacked::new(bytes)?, Vec::new());
        source.read_to_end(&mut out)?;
        Ok((out, source.problem()))
    }

    #[test]
    fn what_comes_before_a_cut_or_damage_is_read() {
        let plain: Vec<u8> =
            (0..300_000_u32).flat_map(|n| (n.wrapping_mul(2_654_435_761)).to_le_bytes()).collect();
        let packed = encode_all(&plain[..], 1).unwrap();
        let skippable = [&[0x50, 0x2A, 0x4D, 0x18, 3, 0, 0, 0][..], b"abc", &packed, &packed].concat();
        assert!(is_packed(&packed) && is_packed(&skippable) && !is_packed(b"\x54\xFE") && !is_packed(b""));
        assert_eq!(all(&skippable).unwrap(), (plain.repeat(2), None));
        let (out, problem) = all(&packed[..packed.len() - 9]).unwrap();
        assert_eq!(problem, Some("the file ends inside a zstd frame"));
        assert!(out.len() > plain.len() / 2 && plain.starts_with(&out), "{}", out.len());
        let mut broken = skippable.clone();
        let middle = 11 + packed.len() + 2;
        broken[middle..middle + 4].fill(0xFF);
        let (out, problem) = all(&broken).unwrap();
        assert_eq!((out, problem.is_some()), (plain, true));
    }

    #[test]
    fn a_file_that_asks_for_much_memory_is_refused() {
        let mut encoder = Encoder::new(Vec::new(), 1).unwrap();
        encoder.window_log(25).unwrap();
        io::Write::write_all(&mut encoder, &[7; 100]).unwrap();
        let packed = encoder.finish().unwrap();
        let error = all(&packed).unwrap_err().to_string();
        assert!(error.contains("zstd -d --long=31"), "{error}");
    }
}
