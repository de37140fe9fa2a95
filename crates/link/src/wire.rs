//! Numbers and texts in frames: little-endian, bounded, never trusted before their bytes are there.

use bytes::Bytes;

/// What is wrong with a message of the link.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum DecodeError {
    /// The bytes end inside something.
    #[error("the bytes end inside {what}; the peer's encoder or the transport is broken")]
    Truncated {
        /// Inside what.
        what: &'static str,
    },
    /// A length is beyond its bound.
    #[error("{what} has {have} bytes, {most} are allowed; the peer must send it in parts")]
    TooLong {
        /// The field that was read.
        what: &'static str,
        /// Its bytes.
        have: u64,
        /// The bound.
        most: u64,
    },
    /// A greeting does not begin as one.
    #[error("the greeting does not begin with LLNK; the peer is not a Lutra")]
    NoLink,
    /// A value has no meaning.
    #[error("{what} cannot be {value}; the peer's encoder is broken")]
    BadValue {
        /// The field that was read.
        what: &'static str,
        /// Its value.
        value: u64,
    },
    /// Compressed data does not give what was stated.
    #[error("compressed records do not unpack to the stated {stated} bytes; the message is damaged")]
    BadCompression {
        /// Bytes stated.
        stated: u32,
    },
}

/// Takes fields from the front of a message. What it gives out shares the message's memory.
#[derive(Debug)]
pub(crate) struct Reader {
    bytes: Bytes,
}

impl Reader {
    pub(crate) fn new(bytes: Bytes) -> Self {
        Self { bytes }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    /// Everything that is left.
    pub(crate) fn rest(self) -> Bytes {
        self.bytes
    }

    /// The next `count` bytes of something whose length was checked against its own bound.
    pub(crate) fn take(&mut self, count: usize, what: &'static str) -> Result<Bytes, DecodeError> {
        if count > self.bytes.len() {
            return Err(DecodeError::Truncated { what });
        }
        Ok(self.bytes.split_to(count))
    }

    pub(crate) fn array<const N: usize>(&mut self, what: &'static str) -> Result<[u8; N], DecodeError> {
        let taken = self.take(N, what)?;
        let mut array = [0; N];
        array.copy_from_slice(&taken);
        Ok(array)
    }

    pub(crate) fn u8(&mut self, what: &'static str) -> Result<u8, DecodeError> {
        self.array::<1>(what).map(|[byte]| byte)
    }

    pub(crate) fn u16(&mut self, what: &'static str) -> Result<u16, DecodeError> {
        self.array(what).map(u16::from_le_bytes)
    }

    pub(crate) fn u32(&mut self, what: &'static str) -> Result<u32, DecodeError> {
        self.array(what).map(u32::from_le_bytes)
    }

    pub(crate) fn u64(&mut self, what: &'static str) -> Result<u64, DecodeError> {
        self.array(what).map(u64::from_le_bytes)
    }

    pub(crate) fn i64(&mut self, what: &'static str) -> Result<i64, DecodeError> {
        self.array(what).map(i64::from_le_bytes)
    }

    /// A number in groups of seven bits, lowest first.
    pub(crate) fn varint(&mut self, what: &'static str) -> Result<u64, DecodeError> {
        let mut value = 0_u64;
        for shift in (0..64).step_by(7) {
            let byte = self.u8(what)?;
            let bits = u64::from(byte & 0x7F);
            if shift == 63 && bits > 1 {
                return Err(DecodeError::BadValue { what, value: bits });
            }
            value |= bits << shift;
            if byte & 0x80 == 0 {
                return Ok(value);
            }
        }
        Err(DecodeError::BadValue { what, value })
    }

    /// A text of at most `most` bytes behind its length; what is not UTF-8 in it is replaced.
    pub(crate) fn text(&mut self, most: usize, what: &'static str) -> Result<String, DecodeError> {
        let length = usize::from(self.u16(what)?);
        if length > most {
            return Err(DecodeError::TooLong { what, have: length as u64, most: most as u64 });
        }
        Ok(String::from_utf8_lossy(&self.take(length, what)?).into_owned())
    }
}

pub(crate) fn put_varint(out: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        out.push(value as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

/// Signed numbers near zero as unsigned ones near zero.
pub(crate) fn zigzag(value: i64) -> u64 {
    (value.wrapping_shl(1) ^ (value >> 63)) as u64
}

pub(crate) fn unzigzag(value: u64) -> i64 {
    (value >> 1) as i64 ^ -((value & 1) as i64)
}

/// A text behind its length, cut at a character to at most `most` bytes.
pub(crate) fn put_text(out: &mut Vec<u8>, text: &str, most: usize) {
    let mut end = text.len().min(most);
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    out.extend_from_slice(&(end as u16).to_le_bytes());
    out.extend_from_slice(&text.as_bytes()[..end]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn numbers_return(value: u64, signed: i64) {
            let mut out = Vec::new();
            put_varint(&mut out, value);
            let mut reader = Reader::new(out.into());
            prop_assert_eq!(reader.varint("n"), Ok(value));
            prop_assert!(reader.is_empty());
            prop_assert_eq!(unzigzag(zigzag(signed)), signed);
        }
    }

    #[test]
    fn a_number_too_long_for_64_bits_is_refused() {
        let mut reader = Reader::new(Bytes::from_static(&[0xFF; 12]));
        assert!(matches!(reader.varint("n"), Err(DecodeError::BadValue { .. })));
    }

    #[test]
    fn texts_are_cut_at_a_character() {
        let mut out = Vec::new();
        put_text(&mut out, "på", 2);
        assert_eq!(Reader::new(out.into()).text(2, "t").unwrap(), "p");
    }
}
