//! CRC-16/ARC, which IMC calls CRC-16-IBM: polynomial 0x8005 reflected, initial value 0, no final xor.
//!
//! The check value of `123456789` is 0xBB3D. Because nothing is added at the start or the end, the CRC is
//! linear: the CRC of a piece follows from the CRCs of two prefixes. [`PrefixCrc`] uses this, so that a
//! stream full of false packet starts costs no more than one pass.

const POLYNOMIAL: u16 = 0xA001;
/// Bytes taken per step: one table each.
const SLICES: usize = 16;

/// `TABLES[k][b]`: the CRC of byte `b` followed by `k` zero bytes.
static TABLES: [[u16; 256]; SLICES] = tables();

const fn tables() -> [[u16; 256]; SLICES] {
    let mut tables = [[0_u16; 256]; SLICES];
    let mut byte = 0;
    while byte < 256 {
        let mut crc = byte as u16;
        let mut bit = 0;
        while bit < 8 {
            crc = if crc & 1 == 1 { (crc >> 1) ^ POLYNOMIAL } else { crc >> 1 };
            bit += 1;
        }
        tables[0][byte] = crc;
        byte += 1;
    }
    let mut slice = 1;
    while slice < SLICES {
        let mut byte = 0;
        while byte < 256 {
            let crc = tables[slice - 1][byte];
            tables[slice][byte] = (crc >> 8) ^ tables[0][(crc & 0xFF) as usize];
            byte += 1;
        }
        slice += 1;
    }
    tables
}

/// The CRC of `bytes`.
pub fn crc16(bytes: &[u8]) -> u16 {
    update(0, bytes)
}

/// The CRC of everything hashed into `crc` followed by `bytes`.
pub(crate) fn update(mut crc: u16, bytes: &[u8]) -> u16 {
    let (blocks, rest) = bytes.as_chunks::<SLICES>();
    for block in blocks {
        let mut next = TABLES[SLICES - 1][usize::from(block[0] ^ crc as u8)]
            ^ TABLES[SLICES - 2][usize::from(block[1] ^ (crc >> 8) as u8)];
        for at in 2..SLICES {
            next ^= TABLES[SLICES - 1 - at][usize::from(block[at])];
        }
        crc = next;
    }
    for &byte in rest {
        crc = (crc >> 8) ^ TABLES[0][usize::from(byte ^ crc as u8)];
    }
    crc
}

/// `ZEROS[k][i]`: what bit `i` of a CRC becomes after 2^k zero bytes.
static ZEROS: [[u16; 16]; 20] = zeros();

const fn zeros() -> [[u16; 16]; 20] {
    let mut zeros = [[0_u16; 16]; 20];
    let table = tables();
    let mut bit = 0;
    while bit < 16 {
        let crc = 1_u16 << bit;
        zeros[0][bit] = (crc >> 8) ^ table[0][(crc & 0xFF) as usize];
        bit += 1;
    }
    let mut power = 1;
    while power < 20 {
        let mut bit = 0;
        while bit < 16 {
            zeros[power][bit] = apply(&zeros[power - 1], zeros[power - 1][bit]);
            bit += 1;
        }
        power += 1;
    }
    zeros
}

const fn apply(matrix: &[u16; 16], crc: u16) -> u16 {
    let mut result = 0;
    let mut bit = 0;
    while bit < 16 {
        if crc >> bit & 1 == 1 {
            result ^= matrix[bit];
        }
        bit += 1;
    }
    result
}

/// `crc` after `count` (below 2^20) zero bytes.
fn append_zeros(mut crc: u16, count: usize) -> u16 {
    for (power, matrix) in ZEROS.iter().enumerate() {
        if count >> power & 1 == 1 {
            crc = apply(matrix, crc);
        }
    }
    crc
}

/// CRCs of any piece of a buffer, after one pass over it.
///
/// Holds one CRC per 64 bytes: a piece costs at most 128 bytes of hashing, however long it is. The buffer may
/// grow at its end at any time and be consumed from its start by [`Self::consume`].
#[derive(Debug)]
pub(crate) struct PrefixCrc {
    /// CRCs from an origin up to each multiple of the stride after it.
    marks: Vec<u16>,
    /// Where the buffer starts, counted from the first mark.
    shift: usize,
    /// The CRC from the origin to the buffer's start.
    start: u16,
}

impl Default for PrefixCrc {
    fn default() -> Self {
        Self { marks: vec![0], shift: 0, start: 0 }
    }
}

impl PrefixCrc {
    const STRIDE: usize = 64;
    /// Marks that are kept before the buffer's start until they are dropped together.
    const STALE_MARKS: usize = 1 << 10;

    /// Forgets the buffer; the next one may be another.
    pub(crate) fn clear(&mut self) {
        self.marks.truncate(1);
        self.marks[0] = 0;
        self.shift = 0;
        self.start = 0;
    }

    /// The CRC of `buffer[from..to]`.
    pub(crate) fn range(&mut self, buffer: &[u8], from: usize, to: usize) -> u16 {
        self.prefix(buffer, to) ^ append_zeros(self.prefix(buffer, from), to - from)
    }

    /// Says that the next buffer is this one without its first `count` bytes.
    pub(crate) fn consume(&mut self, buffer: &[u8], count: usize) {
        self.start = self.prefix(buffer, count);
        self.shift += count;
        let stale = self.shift / Self::STRIDE;
        if stale >= Self::STALE_MARKS {
            self.marks.drain(..stale);
            self.shift -= stale * Self::STRIDE;
        }
    }

    /// The CRC from the origin to `buffer[to]`.
    fn prefix(&mut self, buffer: &[u8], to: usize) -> u16 {
        let mark = (self.shift + to) / Self::STRIDE;
        while self.marks.len() <= mark {
            let last = self.marks.len() - 1;
            let next = self.after_mark(last, buffer, (last + 1) * Self::STRIDE - self.shift);
            self.marks.push(next);
        }
        self.after_mark(mark, buffer, to)
    }

    /// As [`Self::prefix`], hashing from the mark or, if that was consumed, from the buffer's start.
    fn after_mark(&self, mark: usize, buffer: &[u8], to: usize) -> u16 {
        match (mark * Self::STRIDE).checked_sub(self.shift) {
            Some(at) => update(self.marks[mark], &buffer[at..to]),
            None => update(self.start, &buffer[..to]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn bitwise(bytes: &[u8]) -> u16 {
        bytes.iter().fold(0, |mut crc, &byte| {
            crc ^= u16::from(byte);
            for _ in 0..8 {
                crc = if crc & 1 == 1 { (crc >> 1) ^ POLYNOMIAL } else { crc >> 1 };
            }
            crc
        })
    }

    #[test]
    fn known_values_hold() {
        assert_eq!(crc16(b""), 0);
        assert_eq!(crc16(b"A"), 0x30C0);
        assert_eq!(crc16(b"123456789"), 0xBB3D);
        assert_eq!(crc16(b"The quick brown fox jumps over the lazy dog"), 0xFCDF);
    }

    proptest! {
        #[test]
        fn equals_the_bitwise_definition(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
            prop_assert_eq!(crc16(&bytes), bitwise(&bytes));
        }

        #[test]
        fn any_piece_follows_from_its_prefixes(
            bytes in proptest::collection::vec(any::<u8>(), 1..2_000),
            cuts in proptest::collection::vec((any::<prop::sample::Index>(), any::<prop::sample::Index>()), 1..8),
        ) {
            let mut prefixes = PrefixCrc::default();
            for (a, b) in cuts {
                let (a, b) = (a.index(bytes.len() + 1), b.index(bytes.len() + 1));
                let (from, to) = (a.min(b), a.max(b));
                prop_assert_eq!(prefixes.range(&bytes, from, to), crc16(&bytes[from..to]));
            }
        }

        #[test]
        fn pieces_follow_also_when_the_start_was_consumed(
            bytes in proptest::collection::vec(any::<u8>(), 1..500),
            bites in proptest::collection::vec(any::<prop::sample::Index>(), 1..20),
        ) {
            let (mut prefixes, mut at) = (PrefixCrc::default(), 0);
            for bite in bites {
                let rest = &bytes[at..];
                let to = bite.index(rest.len() + 1);
                prop_assert_eq!(prefixes.range(rest, to / 2, to), crc16(&rest[to / 2..to]));
                prefixes.consume(rest, to / 3);
                at += to / 3;
            }
        }
    }
}
