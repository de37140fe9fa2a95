//! Frames of a CAN bus, as every adapter carries them: classic frames of at most eight bytes, with identifiers of
//! 11 bits (standard) or 29 bits (extended), and requests for a frame (remote frames), which have a length and no data.

/// The most data bytes of a classic frame.
pub const MOST_DATA: usize = 8;

/// The identifier of a frame. The same number as a standard and as an extended one are two identifiers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum CanId {
    /// 11 bits.
    Standard(u16),
    /// 29 bits.
    Extended(u32),
}

impl CanId {
    /// The number, whatever its width.
    pub const fn number(self) -> u32 {
        match self {
            Self::Standard(id) => id as u32,
            Self::Extended(id) => id,
        }
    }

    /// Whether the number keeps within the bits it has.
    pub const fn is_valid(self) -> bool {
        match self {
            Self::Standard(id) => id < 1 << 11,
            Self::Extended(id) => id < 1 << 29,
        }
    }
}

/// One frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CanFrame {
    id: CanId,
    remote: bool,
    len: u8,
    data: [u8; MOST_DATA],
}

impl CanFrame {
    /// An extended frame with data; `None` for an identifier beyond 29 bits or more than eight bytes.
    pub fn new(id: u32, data: &[u8]) -> Option<Self> {
        Self::with_id(CanId::Extended(id), data)
    }

    /// A frame with data; `None` for an identifier beyond its bits or more than eight bytes.
    pub fn with_id(id: CanId, data: &[u8]) -> Option<Self> {
        if !id.is_valid() || data.len() > MOST_DATA {
            return None;
        }
        let mut bytes = [0; MOST_DATA];
        bytes[..data.len()].copy_from_slice(data);
        Some(Self { id, remote: false, len: data.len() as u8, data: bytes })
    }

    /// A request for a frame of `len` bytes; `None` for an identifier beyond its bits or a length beyond eight.
    pub fn request(id: CanId, len: u8) -> Option<Self> {
        let valid = id.is_valid() && usize::from(len) <= MOST_DATA;
        valid.then_some(Self { id, remote: true, len, data: [0; MOST_DATA] })
    }

    /// The number of the identifier.
    pub fn id(&self) -> u32 {
        self.id.number()
    }

    /// The identifier with its width.
    pub fn full_id(&self) -> CanId {
        self.id
    }

    /// Whether this is a request, which has no data.
    pub fn is_request(&self) -> bool {
        self.remote
    }

    /// The length that the frame states: that of its data, or of the data it asks for.
    pub fn stated_len(&self) -> u8 {
        self.len
    }

    /// The bytes, at most eight; none of a request.
    pub fn data(&self) -> &[u8] {
        let len = if self.remote { 0 } else { usize::from(self.len) };
        &self.data[..len]
    }
}

/// The number that one to eight hexadecimal digits write.
pub(crate) fn hex_number(digits: &[u8]) -> Option<u32> {
    if digits.is_empty() || digits.len() > 8 {
        return None;
    }
    digits.iter().try_fold(0, |number, digit| Some(number << 4 | char::from(*digit).to_digit(16)?))
}

/// The frame with these data, written as two hexadecimal digits a byte.
pub(crate) fn frame_of_hex(id: CanId, digits: &[u8]) -> Option<CanFrame> {
    if !digits.len().is_multiple_of(2) || digits.len() > 2 * MOST_DATA {
        return None;
    }
    let mut data = [0; MOST_DATA];
    for (byte, pair) in data.iter_mut().zip(digits.chunks_exact(2)) {
        // Two digits are one byte.
        *byte = hex_number(pair)? as u8;
    }
    CanFrame::with_id(id, &data[..digits.len() / 2])
}

/// The identifier in upper-case hexadecimal: three digits of a standard one, eight of an extended one.
impl std::fmt::Display for CanId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Standard(id) => write!(f, "{id:03X}"),
            Self::Extended(id) => write!(f, "{id:08X}"),
        }
    }
}

/// Bytes in upper-case hexadecimal.
pub(crate) struct Hex<'a>(pub(crate) &'a [u8]);

impl std::fmt::Display for Hex<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02X}"))
    }
}

/// Frames for tests of every codec.
#[cfg(test)]
pub(crate) mod strategy {
    use super::*;
    use proptest::prelude::*;

    pub(crate) fn any_frame() -> impl Strategy<Value = CanFrame> {
        let id = prop_oneof![
            (0_u16..1 << 11).prop_map(CanId::Standard),
            (0_u32..1 << 29).prop_map(CanId::Extended),
        ];
        let data = proptest::collection::vec(any::<u8>(), 0..=MOST_DATA);
        (id, data, proptest::bool::weighted(0.2)).prop_map(|(id, data, request)| {
            let frame =
                if request { CanFrame::request(id, data.len() as u8) } else { CanFrame::with_id(id, &data) };
            frame.unwrap()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_holds_eight_bytes_and_the_bits_of_its_identifier() {
        assert!(CanFrame::new(1 << 29, &[]).is_none());
        assert!(CanFrame::new(1, &[0; 9]).is_none());
        assert!(CanFrame::with_id(CanId::Standard(0x800), &[]).is_none());
        assert!(CanFrame::request(CanId::Extended(1), 9).is_none());
        assert_eq!(CanFrame::new(1, &[7, 8]).unwrap().data(), [7, 8]);
        assert_ne!(CanFrame::new(1, &[]), CanFrame::with_id(CanId::Standard(1), &[]));
    }

    #[test]
    fn a_request_states_a_length_and_has_no_data() {
        let request = CanFrame::request(CanId::Standard(0x7FF), 5).unwrap();
        assert_eq!((request.is_request(), request.stated_len(), request.data()), (true, 5, &[][..]));
    }
}
