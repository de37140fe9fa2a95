//! The text protocol of serial CAN adapters (slcan, after Lawicel's CAN232).
//!
//! A frame is `T` and eight digits of an extended identifier, or `t` and three of a standard one, then its length as one
//! digit and its data in hexadecimal; `R` and `r` are requests, without data. While time stamps are on, four more digits
//! count milliseconds up to a minute. Every line ends in a carriage return. The adapter answers a command with a carriage
//! return alone, or with BELL where it refuses, and a frame to be sent with `z` or `Z` before it.

use crate::can::{CanFrame, CanId, Hex, frame_of_hex, hex_number};
use crate::line_splitter::{Line as RawLine, LineSplitter};
use thiserror::Error;

/// The most bytes of a line; a frame with its time has 30.
pub const MOST_LINE: usize = 64;
/// A time stamp counts to a minute (ms).
const MINUTE_MS: u32 = 60_000;
const BELL: u8 = 7;

/// The speed of the bus, by the digit of the command `S`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bitrate {
    /// 10 kbit/s.
    K10,
    /// 20 kbit/s.
    K20,
    /// 50 kbit/s.
    K50,
    /// 100 kbit/s.
    K100,
    /// 125 kbit/s.
    K125,
    /// 250 kbit/s.
    K250,
    /// 500 kbit/s.
    K500,
    /// 800 kbit/s.
    K800,
    /// 1 Mbit/s.
    M1,
}

impl Bitrate {
    /// All, at the place of their digit, with the bits in a second.
    const ALL: [(Self, u32); 9] = [
        (Self::K10, 10_000),
        (Self::K20, 20_000),
        (Self::K50, 50_000),
        (Self::K100, 100_000),
        (Self::K125, 125_000),
        (Self::K250, 250_000),
        (Self::K500, 500_000),
        (Self::K800, 800_000),
        (Self::M1, 1_000_000),
    ];

    /// The one with so many bits in a second.
    pub fn of_bits(bits_per_s: u32) -> Option<Self> {
        Self::ALL.iter().find(|(_, bits)| *bits == bits_per_s).map(|(rate, _)| *rate)
    }

    /// The one of a command's digit.
    fn of_digit(digit: u8) -> Option<Self> {
        Self::ALL.get(usize::from(digit.checked_sub(b'0')?)).map(|(rate, _)| *rate)
    }

    fn digit(self) -> char {
        // The variants stand in the order of their digits, which are below ten.
        char::from(b'0' + self as u8)
    }
}

/// Commands of the computer to the adapter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Command {
    /// Leave the bus.
    Close,
    /// Take part in the bus.
    Open,
    /// Listen to the bus, and send not even acknowledgements.
    Listen,
    /// The speed of the bus; only while the adapter is closed.
    Bitrate(Bitrate),
    /// Ask for the flags of errors.
    Status,
    /// Ask for the version of hardware and firmware.
    Version,
    /// Ask for the serial number.
    Serial,
    /// Time stamps on or off; only while the adapter is closed.
    Timestamps(bool),
}

impl std::fmt::Display for Command {
    /// The line without its carriage return.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Close => f.write_str("C"),
            Self::Open => f.write_str("O"),
            Self::Listen => f.write_str("L"),
            Self::Bitrate(rate) => write!(f, "S{}", rate.digit()),
            Self::Status => f.write_str("F"),
            Self::Version => f.write_str("V"),
            Self::Serial => f.write_str("N"),
            Self::Timestamps(on) => write!(f, "Z{}", u8::from(*on)),
        }
    }
}

impl Command {
    /// The bytes for the adapter.
    pub fn encode(self) -> Vec<u8> {
        format!("{self}\r").into_bytes()
    }

    fn parse(line: &[u8]) -> Option<Self> {
        Some(match line {
            b"C" => Self::Close,
            b"O" => Self::Open,
            b"L" => Self::Listen,
            b"F" => Self::Status,
            b"V" => Self::Version,
            b"N" => Self::Serial,
            [b'S', digit] => Self::Bitrate(Bitrate::of_digit(*digit)?),
            [b'Z', on @ (b'0' | b'1')] => Self::Timestamps(*on == b'1'),
            _ => return None,
        })
    }
}

/// A line, of the adapter or to it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Line {
    /// A frame.
    Frame {
        /// The frame.
        frame: CanFrame,
        /// The adapter's time, where it gives one: milliseconds, which begin again after a minute.
        stamp_ms: Option<u16>,
    },
    /// The adapter has carried a command out.
    Done,
    /// The adapter has taken a frame to be sent.
    Sent,
    /// The adapter refuses a command or a frame.
    Refused,
    /// The adapter's flags of errors, bit by bit: 0 receive queue full, 1 send queue full, 2 warning, 3 overrun,
    /// 5 passive, 6 arbitration lost, 7 error on the bus.
    Status(u8),
    /// The adapter's version, as it writes it.
    Version(String),
    /// The adapter's serial number, as it writes it.
    Serial(String),
    /// A command to the adapter.
    Command(Command),
}

/// Why a line is nothing of the protocol.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum LineError {
    /// It begins like nothing known.
    #[error("`{0}` is neither a frame nor an answer or command of a serial CAN adapter")]
    Unknown(String),
    /// It begins like a frame and is not one.
    #[error(
        "`{0}` is not a whole frame: identifier, length and so many bytes in hexadecimal, perhaps a time below EA60"
    )]
    Frame(String),
    /// Longer than any line may be.
    #[error("the line has more than {MOST_LINE} bytes")]
    TooLong,
}

/// The bytes that have the adapter send a frame.
pub fn encode(frame: &CanFrame) -> Vec<u8> {
    let letter = match (frame.full_id(), frame.is_request()) {
        (CanId::Standard(_), false) => 't',
        (CanId::Standard(_), true) => 'r',
        (CanId::Extended(_), false) => 'T',
        (CanId::Extended(_), true) => 'R',
    };
    format!("{letter}{}{}{}\r", frame.full_id(), frame.stated_len(), Hex(frame.data())).into_bytes()
}

impl Line {
    /// Reads a line without its carriage return.
    ///
    /// # Errors
    /// When it is nothing of the protocol.
    pub fn parse(line: &[u8]) -> Result<Self, LineError> {
        let text = |bytes| String::from_utf8_lossy(bytes).into_owned();
        if let Some(command) = Command::parse(line) {
            return Ok(Self::Command(command));
        }
        let unknown = || LineError::Unknown(text(line));
        Ok(match line {
            [] => Self::Done,
            b"z" | b"Z" => Self::Sent,
            [b't' | b'T' | b'r' | b'R', ..] => frame(line).ok_or_else(|| LineError::Frame(text(line)))?,
            // Two digits are one byte.
            [b'F', flags @ ..] if flags.len() == 2 => {
                Self::Status(hex_number(flags).ok_or_else(unknown)? as u8)
            }
            [b'V', version @ ..] if version.is_ascii() => Self::Version(text(version)),
            [b'N', serial @ ..] if serial.is_ascii() => Self::Serial(text(serial)),
            _ => return Err(unknown()),
        })
    }
}

/// A frame with its letter.
fn frame(line: &[u8]) -> Option<Line> {
    let (&letter, rest) = line.split_first()?;
    let (id, rest) = rest.split_at_checked(if letter.is_ascii_uppercase() { 8 } else { 3 })?;
    let number = hex_number(id)?;
    // Three digits are twelve bits.
    let id = if id.len() == 3 { CanId::Standard(number as u16) } else { CanId::Extended(number) };
    let (&len, rest) = rest.split_first()?;
    let len = len.checked_sub(b'0').filter(|len| *len <= 8)?;
    let (frame, rest) = if letter.eq_ignore_ascii_case(&b'r') {
        (CanFrame::request(id, len)?, rest)
    } else {
        let (data, rest) = rest.split_at_checked(2 * usize::from(len))?;
        (frame_of_hex(id, data)?, rest)
    };
    let stamp_ms = match rest.len() {
        0 => None,
        // Below a minute, which 16 bits hold.
        4 => Some(hex_number(rest).filter(|ms| *ms < MINUTE_MS)? as u16),
        _ => return None,
    };
    Some(Line::Frame { frame, stamp_ms })
}

/// Reads what an adapter sends, in whatever pieces it comes; it keeps [`MOST_LINE`] bytes at most.
#[derive(Debug, Clone)]
pub struct Reader {
    lines: LineSplitter,
}

impl Default for Reader {
    fn default() -> Self {
        Self { lines: LineSplitter::new(&[b'\r', BELL], MOST_LINE) }
    }
}

impl Reader {
    /// Takes the next bytes and gives every line or error to `found`, with its offset.
    pub fn feed(&mut self, bytes: &[u8], mut found: impl FnMut(u64, Result<Line, LineError>)) {
        self.lines.feed(bytes, |line| read_line(line, &mut found));
    }

    /// No more bytes will come: an incomplete line is read as far as it goes.
    pub fn end(&mut self, mut found: impl FnMut(u64, Result<Line, LineError>)) {
        self.lines.end(|line| read_line(line, &mut found));
    }
}

fn read_line(line: RawLine<'_>, found: &mut impl FnMut(u64, Result<Line, LineError>)) {
    let refused = line.end == Some(BELL);
    // A line feed after the carriage return is not of the protocol, but recordings have it.
    let bytes = line.bytes.trim_ascii();
    if line.too_long {
        found(line.offset, Err(LineError::TooLong));
    } else if !bytes.is_empty() || (line.bytes.is_empty() && !refused) {
        found(line.offset, Line::parse(bytes));
    }
    if refused {
        found(line.offset + line.bytes.len() as u64, Ok(Line::Refused));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::can::strategy::any_frame;
    use proptest::prelude::*;

    fn read(pieces: &[&[u8]]) -> Vec<(u64, Result<Line, LineError>)> {
        let mut reader = Reader::default();
        let mut all = Vec::new();
        for piece in pieces {
            reader.feed(piece, |at, line| all.push((at, line)));
        }
        reader.end(|at, line| all.push((at, line)));
        all
    }

    #[test]
    fn frames_of_all_four_kinds_are_read_with_and_without_time() {
        let data = CanFrame::new(0x00D0_FEAB, &[1, 2]).unwrap();
        assert_eq!(encode(&data), b"T00D0FEAB20102\r");
        let frame = |frame, stamp_ms| Ok(Line::Frame { frame, stamp_ms });
        assert_eq!(Line::parse(b"T00D0FEAB20102"), frame(data, None));
        assert_eq!(Line::parse(b"T00d0feab20102EA5f"), frame(data, Some(59_999)));
        let standard = CanId::Standard(0x123);
        assert_eq!(Line::parse(b"t1230"), frame(CanFrame::with_id(standard, &[]).unwrap(), None));
        assert_eq!(Line::parse(b"r1238"), frame(CanFrame::request(standard, 8).unwrap(), None));
        let extended = CanId::Extended(0x1FFF_FFFF);
        assert_eq!(Line::parse(b"R1FFFFFFF00001"), frame(CanFrame::request(extended, 0).unwrap(), Some(1)));
    }

    #[test]
    fn answers_and_commands_are_told_apart() {
        let bytes = b"\r\x07z\rZ\rV1013\rNA123\rF80\rV\r";
        let found: Vec<_> = read(&[bytes]).into_iter().map(|(_, line)| line.unwrap()).collect();
        let expected = [
            Line::Done,
            Line::Refused,
            Line::Sent,
            Line::Sent,
            Line::Version("1013".into()),
            Line::Serial("A123".into()),
            Line::Status(0x80),
            Line::Command(Command::Version),
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn commands_are_those_of_the_protocol_and_are_read_back() {
        let rates = Bitrate::ALL.map(|(rate, _)| Command::Bitrate(rate));
        let others = [
            Command::Close,
            Command::Open,
            Command::Listen,
            Command::Status,
            Command::Version,
            Command::Serial,
            Command::Timestamps(true),
            Command::Timestamps(false),
        ];
        for command in rates.into_iter().chain(others) {
            assert_eq!(Line::parse(command.to_string().as_bytes()), Ok(Line::Command(command)));
        }
        assert_eq!(Command::Bitrate(Bitrate::of_bits(500_000).unwrap()).encode(), b"S6\r");
        assert_eq!(Command::Timestamps(true).encode(), b"Z1\r");
        assert_eq!(Bitrate::of_bits(33_333), None);
    }

    #[test]
    fn what_is_not_of_the_protocol_is_an_error() {
        for text in
            ["T00D0FEAB201", "T00D0FEAB2010203", "t8000", "T200000000", "t1239", "t123", "T00D0FEAB0EA60"]
        {
            assert_eq!(Line::parse(text.as_bytes()), Err(LineError::Frame(text.into())), "{text}");
        }
        for text in ["x", "S9", "Z2", "F123", "FXY", "C1"] {
            assert_eq!(Line::parse(text.as_bytes()), Err(LineError::Unknown(text.into())), "{text}");
        }
        let long = [&[b'T'; 900][..], b"\rz\r"].concat();
        assert_eq!(read(&[&long]), [(0, Err(LineError::TooLong)), (901, Ok(Line::Sent))]);
    }

    #[test]
    fn recordings_with_line_feeds_and_refusals_within_a_line_are_read() {
        let found = read(&[b"z\r\nt1230\r\nT00\x07"]);
        assert_eq!(found[0], (0, Ok(Line::Sent)));
        assert!(matches!(found[1], (2, Ok(Line::Frame { .. }))));
        assert_eq!(found[2], (9, Err(LineError::Frame("T00".into()))));
        assert_eq!(found[3], (13, Ok(Line::Refused)));
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_back_however_it_is_cut(
            frames in proptest::collection::vec(any_frame(), 1..20),
            cut in 0_usize..400,
        ) {
            let bytes: Vec<u8> = frames.iter().flat_map(encode).collect();
            let (head, tail) = bytes.split_at(cut.min(bytes.len()));
            let expected: Vec<_> = frames.into_iter().map(|frame| Ok(Line::Frame { frame, stamp_ms: None })).collect();
            let found: Vec<_> = read(&[head, tail]).into_iter().map(|(_, line)| line).collect();
            prop_assert_eq!(found, expected);
        }

        #[test]
        fn noise_hides_nothing_behind_it(noise in proptest::collection::vec(any::<u8>(), 0..400)) {
            let bytes = [&noise[..], b"\rT00D0FEAB20102\r"].concat();
            let found = read(&[&bytes]);
            let is_frame = matches!(found.last().unwrap().1, Ok(Line::Frame { .. }));
            prop_assert!(is_frame);
            prop_assert_eq!(found, read(&bytes.chunks(1).collect::<Vec<_>>()));
        }
    }
}
