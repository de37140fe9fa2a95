//! Lines in a stream of bytes, for the devices that send text.
//!
//! A line ends at CR, LF or both. A start byte, `$` for most devices, begins a line wherever it stands: what stood before
//! it, noise or a line that lost its end, comes out as a piece of its own, so one lost byte costs one line. Memory is
//! bounded by the limit: a line that grows beyond it comes out once as [`Piece::TooLong`], and all up to the next start
//! or end is skipped.

/// A piece of the stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Piece<'a> {
    /// A line with its end, which is left out; never empty.
    Line(&'a [u8]),
    /// Bytes that another line's start, or the end of the stream, cut short; never empty.
    Cut(&'a [u8]),
    /// A line longer than the limit.
    TooLong,
}

/// Splits a stream into lines.
#[derive(Debug, Clone)]
pub struct Lines {
    start_byte: Option<u8>,
    limit: usize,
    text: Vec<u8>,
    /// Whether the line at hand is beyond the limit and skipped.
    skipping: bool,
    /// Offset in the stream of the next byte.
    offset: u64,
    /// Offset of the first byte of the line at hand.
    begun: u64,
}

impl Lines {
    /// Splits lines of at most `limit` bytes. `start_byte` begins a line wherever it stands.
    pub const fn new(start_byte: Option<u8>, limit: usize) -> Self {
        Self { start_byte, limit, text: Vec::new(), skipping: false, offset: 0, begun: 0 }
    }

    /// Takes the next bytes and hands out what is complete, each with the offset of its first byte in the stream.
    pub fn feed(&mut self, bytes: &[u8], mut take: impl FnMut(u64, Piece<'_>)) {
        for &byte in bytes {
            let ends = matches!(byte, b'\r' | b'\n');
            if ends || Some(byte) == self.start_byte {
                let piece = if ends { Piece::Line(&self.text) } else { Piece::Cut(&self.text) };
                if !self.text.is_empty() {
                    take(self.begun, piece);
                }
                self.text.clear();
                self.skipping = false;
            }
            if !ends && !self.skipping {
                if self.text.is_empty() {
                    self.begun = self.offset;
                }
                if self.text.len() < self.limit {
                    self.text.push(byte);
                } else {
                    take(self.begun, Piece::TooLong);
                    self.text.clear();
                    self.skipping = true;
                }
            }
            self.offset += 1;
        }
    }

    /// The stream is over: hands out what has no end. Further bytes begin a line.
    pub fn end(&mut self, mut take: impl FnMut(u64, Piece<'_>)) {
        if !self.text.is_empty() {
            take(self.begun, Piece::Cut(&self.text));
        }
        self.text.clear();
        self.skipping = false;
    }

    /// Forgets the line at hand, as when a port was opened again.
    pub fn clear(&mut self) {
        self.text.clear();
        self.skipping = false;
    }

    /// How many bytes of an unfinished line are kept; never more than the limit.
    pub fn kept(&self) -> usize {
        self.text.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pieces(chunks: &[&[u8]]) -> Vec<(u64, String)> {
        let mut lines = Lines::new(Some(b'$'), 8);
        let mut found = Vec::new();
        let mut take = |offset, piece: Piece<'_>| {
            let text = match piece {
                Piece::Line(text) => format!("line {}", String::from_utf8_lossy(text)),
                Piece::Cut(text) => format!("cut {}", String::from_utf8_lossy(text)),
                Piece::TooLong => "too long".to_owned(),
            };
            found.push((offset, text));
        };
        for chunk in chunks {
            lines.feed(chunk, &mut take);
        }
        lines.end(&mut take);
        found
    }

    #[test]
    fn lines_end_at_cr_lf_or_both_and_begin_at_the_start_byte() {
        let found = pieces(&[b"$a\r$b\n$c\r\n\r\nxx$d$e\r$f"]);
        let expected = [
            (0, "line $a"),
            (3, "line $b"),
            (6, "line $c"),
            (12, "cut xx"),
            (14, "cut $d"),
            (16, "line $e"),
            (19, "cut $f"),
        ];
        assert_eq!(found, expected.map(|(offset, text)| (offset, text.to_owned())));
    }

    #[test]
    fn a_line_beyond_the_limit_comes_out_once_and_the_next_is_read() {
        let found = pieces(&[b"$12345678", b"9999999999999$abcdefg\n123456789\n$z\n"]);
        let expected = [(0, "too long"), (22, "line $abcdefg"), (31, "too long"), (41, "line $z")];
        assert_eq!(found, expected.map(|(offset, text)| (offset, text.to_owned())));
    }
}
