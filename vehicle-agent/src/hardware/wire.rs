//! Byte formats of CAN frames: lines of a serial adapter, or the kernel's socket format.

use devices::can::{CanFrame, CanId};
use devices::slcan::{Bitrate, Command, Line, Reader, encode};

/// Bytes of a frame of the kernel: `struct can_frame` in linux/can.h.
const KERNEL_FRAME: usize = 16;
/// Flags beside the identifier there: extended, request, error of the bus.
const EXTENDED: u32 = 1 << 31;
const REQUEST: u32 = 1 << 30;
const BUS_ERROR: u32 = 1 << 29;

/// An event from the bus or its adapter.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum OnWire {
    /// A frame.
    Frame(CanFrame),
    /// The adapter has accepted a frame or a command.
    Taken,
    /// The adapter refuses.
    Refused,
}

/// Byte format of frames.
#[derive(Debug)]
pub(crate) enum Wire {
    /// Lines of a serial adapter, and the bus speed to set.
    Slcan(Bitrate, Reader),
    /// The kernel's frames; with the received part of one.
    Kernel(Vec<u8>),
}

impl Wire {
    /// An adapter on a bus of this speed.
    pub(crate) fn slcan(bitrate: Bitrate) -> Self {
        Self::Slcan(bitrate, Reader::default())
    }

    /// What to send when the port has been opened.
    pub(super) fn greeting(&self) -> Option<Vec<u8>> {
        let Self::Slcan(bitrate, _) = self else { return None };
        // Empty lines terminate a partial command in the adapter; the speed can be set only while it is closed.
        let commands = [Command::Close, Command::Bitrate(*bitrate), Command::Open].map(Command::encode);
        Some([b"\r\r\r".to_vec(), commands.concat()].concat())
    }

    /// Discards the part of a frame.
    pub(super) fn reset(&mut self) {
        match self {
            Self::Slcan(_, reader) => *reader = Reader::default(),
            Self::Kernel(begun) => begun.clear(),
        }
    }

    /// The bytes of a frame.
    pub(crate) fn encode(&self, frame: &CanFrame) -> Vec<u8> {
        match self {
            Self::Slcan(..) => encode(frame),
            Self::Kernel(_) => kernel_bytes(frame),
        }
    }

    /// Calls `found` for what these bytes complete.
    pub(crate) fn feed(&mut self, bytes: &[u8], mut found: impl FnMut(OnWire)) {
        match self {
            Self::Slcan(_, reader) => reader.feed(bytes, |_, line| {
                // Other answers and damaged lines are ignored: the card's silence shows a fault as well.
                match line {
                    Ok(Line::Frame { frame, .. }) => found(OnWire::Frame(frame)),
                    Ok(Line::Sent | Line::Done) => found(OnWire::Taken),
                    Ok(Line::Refused) => found(OnWire::Refused),
                    _ => {}
                }
            }),
            Self::Kernel(begun) => {
                begun.extend(bytes);
                let whole = begun.len() - begun.len() % KERNEL_FRAME;
                let frames = begun[..whole].chunks_exact(KERNEL_FRAME).filter_map(kernel_frame);
                frames.map(OnWire::Frame).for_each(found);
                begun.drain(..whole);
            }
        }
    }
}

fn kernel_bytes(frame: &CanFrame) -> Vec<u8> {
    let extended = match frame.full_id() {
        CanId::Standard(_) => 0,
        CanId::Extended(_) => EXTENDED,
    };
    let request = if frame.is_request() { REQUEST } else { 0 };
    let mut bytes = vec![0; KERNEL_FRAME];
    bytes[..4].copy_from_slice(&(frame.id() | extended | request).to_ne_bytes());
    bytes[4] = frame.stated_len();
    bytes[8..8 + frame.data().len()].copy_from_slice(frame.data());
    bytes
}

fn kernel_frame(bytes: &[u8]) -> Option<CanFrame> {
    let word = u32::from_ne_bytes(*bytes.first_chunk()?);
    if word & BUS_ERROR != 0 {
        return None;
    }
    let number = word & !(EXTENDED | REQUEST);
    // Standard identifiers have 11 bits.
    let id = if word & EXTENDED == 0 { CanId::Standard(number as u16) } else { CanId::Extended(number) };
    let len = bytes[4];
    if word & REQUEST != 0 {
        return CanFrame::request(id, len);
    }
    CanFrame::with_id(id, bytes[8..].get(..usize::from(len))?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frames() -> Vec<CanFrame> {
        vec![
            CanFrame::new(0x00D0_FEAB, &[1, 2, 3, 4]).unwrap(),
            CanFrame::with_id(CanId::Standard(0x7FF), &[]).unwrap(),
            CanFrame::request(CanId::Extended(0x1FFF_FFFF), 8).unwrap(),
            CanFrame::new(0x0030_ABFF, &[0xFF; 8]).unwrap(),
        ]
    }

    #[test]
    fn frames_come_back_from_both_wires_however_their_bytes_are_split() {
        for mut wire in [Wire::slcan(Bitrate::K500), Wire::Kernel(Vec::new())] {
            let bytes: Vec<u8> = frames().iter().flat_map(|frame| wire.encode(frame)).collect();
            for size in 1..=bytes.len() {
                let mut found = Vec::new();
                bytes.chunks(size).for_each(|piece| wire.feed(piece, |heard| found.push(heard)));
                let expected: Vec<OnWire> = frames().into_iter().map(OnWire::Frame).collect();
                assert_eq!(found, expected, "pieces of {size}");
            }
        }
    }

    #[test]
    fn frames_of_the_kernel_are_those_of_its_header_file() {
        let bytes = kernel_bytes(&frames()[0]);
        let id = 0x80D0_FEAB_u32.to_ne_bytes();
        assert_eq!(bytes, [&id[..], &[4, 0, 0, 0, 1, 2, 3, 4, 0, 0, 0, 0]].concat());
        let error = [&(BUS_ERROR | 4).to_ne_bytes()[..], &[8; 12]].concat();
        assert_eq!(kernel_frame(&error), None, "an error of the bus is not a frame");
        let long = [&EXTENDED.to_ne_bytes()[..], &[9; 12]].concat();
        assert_eq!(kernel_frame(&long), None, "a length beyond eight");
    }

    /// Each vector of the card, as the kernel's structure of an independent crate has it.
    #[test]
    fn the_card_s_frames_have_the_layout_of_the_kernel_s_structure() {
        use socketcan::{CanDataFrame, EmbeddedFrame as _, ExtendedId};
        let Some(vectors) = testkit::shared("data/onboard/torqeedo_can_vectors.csv") else { return };
        let text = std::fs::read_to_string(vectors).unwrap();
        let mut seen = 0;
        for line in text.lines().skip(1) {
            let mut fields = line.split(',');
            let id = u32::from_str_radix(fields.next().unwrap(), 16).unwrap();
            let hex = fields.next().unwrap();
            let byte = |at: usize| u8::from_str_radix(&hex[2 * at..2 * at + 2], 16).unwrap();
            let data: Vec<u8> = (0..hex.len() / 2).map(byte).collect();
            let theirs = CanDataFrame::new(ExtendedId::new(id).unwrap(), &data).unwrap();
            let structure = theirs.as_ref();
            let mut expected = structure.can_id.to_ne_bytes().to_vec();
            expected.extend([structure.can_dlc, 0, 0, 0]);
            expected.extend(structure.data);
            let frame = CanFrame::new(id, &data).unwrap();
            assert_eq!(kernel_bytes(&frame), expected, "{line}");
            // As a candump of a little-endian computer, the Pi among them, has the first word.
            #[cfg(target_endian = "little")]
            assert_eq!(expected[..4], (id | 0x8000_0000).to_le_bytes());
            assert_eq!(kernel_frame(&expected), Some(frame));
            seen += 1;
        }
        assert!(seen >= 24, "{seen}");
    }
}
