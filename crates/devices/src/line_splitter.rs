//! Lines of text in bytes that come in pieces, where the end byte matters and an empty line means something, as in the
//! protocol of serial CAN adapters. Memory is bounded: a line that is too long comes out once, when it becomes so, and the
//! rest of it is skipped.

/// One line without its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Line<'a> {
    /// Where it begins: bytes since the first that was fed.
    pub offset: u64,
    /// Its bytes. Of a line that is too long, those that fit.
    pub bytes: &'a [u8],
    /// The byte that ended it; `None` where nothing more came, and of a line that is too long.
    pub end: Option<u8>,
    /// Whether it has more bytes than are kept.
    pub too_long: bool,
}

/// Splits bytes at any of a few end bytes. It keeps no more than its limit.
#[derive(Debug, Clone)]
pub struct LineSplitter {
    ends: &'static [u8],
    limit: usize,
    held: Vec<u8>,
    /// The line at hand is too long, which has been given already.
    skipping: bool,
    /// Where the line at hand begins.
    begin: u64,
    taken: u64,
}

impl LineSplitter {
    /// Splits at each of `ends`; a line keeps `limit` bytes at most.
    pub fn new(ends: &'static [u8], limit: usize) -> Self {
        Self { ends, limit, held: Vec::new(), skipping: false, begin: 0, taken: 0 }
    }

    /// Takes the next bytes and gives every line that ends in them to `found`, empty ones too.
    pub fn feed(&mut self, bytes: &[u8], mut found: impl FnMut(Line<'_>)) {
        for &byte in bytes {
            self.taken += 1;
            if self.ends.contains(&byte) {
                if !self.skipping {
                    found(self.line(Some(byte), false));
                }
                self.forget();
            } else if self.held.len() < self.limit {
                self.held.push(byte);
            } else if !self.skipping {
                self.skipping = true;
                found(self.line(None, true));
            }
        }
    }

    /// No more bytes will come: an incomplete line is given as far as it goes.
    pub fn end(&mut self, mut found: impl FnMut(Line<'_>)) {
        if !self.held.is_empty() && !self.skipping {
            found(self.line(None, false));
        }
        self.forget();
    }

    fn line(&self, end: Option<u8>, too_long: bool) -> Line<'_> {
        Line { offset: self.begin, bytes: &self.held, end, too_long }
    }

    fn forget(&mut self) {
        self.held.clear();
        (self.skipping, self.begin) = (false, self.taken);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Owned = (u64, Vec<u8>, Option<u8>, bool);

    fn lines(pieces: &[&[u8]]) -> Vec<Owned> {
        let mut splitter = LineSplitter::new(b"\r\n", 4);
        let mut all = Vec::new();
        for piece in pieces {
            splitter.feed(piece, |l| all.push((l.offset, l.bytes.to_vec(), l.end, l.too_long)));
        }
        splitter.end(|l| all.push((l.offset, l.bytes.to_vec(), l.end, l.too_long)));
        all
    }

    #[test]
    fn lines_have_their_place_and_never_more_than_the_limit() {
        let text = b"ab\r\nlonger\ncd";
        let expected: Vec<Owned> = vec![
            (0, b"ab".to_vec(), Some(b'\r'), false),
            (3, Vec::new(), Some(b'\n'), false),
            (4, b"long".to_vec(), None, true),
            (11, b"cd".to_vec(), None, false),
        ];
        assert_eq!(lines(&[text]), expected);
        for cut in 0..text.len() {
            assert_eq!(lines(&[&text[..cut], &text[cut..]]), expected, "cut at {cut}");
        }
    }
}
