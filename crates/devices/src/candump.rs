//! CAN frames as lines of text, as `candump -L` of can-utils writes them: `(1436509052.249713) can0 00D0FEAB#0102`, and
//! the short form that `cansend` takes: `00D0FEAB#0102`. Eight digits are an extended identifier, three a standard one;
//! `R` in place of the data is a request, with the length it asks for.

use crate::can::{CanFrame, CanId, Hex, frame_of_hex, hex_number};
use crate::line_splitter::{Line, LineSplitter};
use thiserror::Error;
use units::UtcTime;

/// The most bytes of a line. The longest that is written has about 60.
pub const MOST_LINE: usize = 128;

/// A line of a log.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    /// When the frame came, where the line says it. (A log may also count from its start.)
    pub at: Option<UtcTime>,
    /// The interface it came by, where the line says it.
    pub interface: Option<String>,
    /// The frame.
    pub frame: CanFrame,
}

/// Why a line is not an entry.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum LineError {
    /// Neither form.
    #[error("the line is neither `(seconds) interface id#data` nor `id#data`")]
    Form,
    /// No time in brackets.
    #[error("`{0}` is not a time: seconds with up to nine decimals in brackets")]
    Time(String),
    /// No identifier.
    #[error("`{0}` is not an identifier: 3 hexadecimal digits up to 7FF, or 8 up to 1FFFFFFF")]
    Id(String),
    /// No data.
    #[error("`{0}` is not data: up to eight bytes of two hexadecimal digits, or R and a length up to 8")]
    Data(String),
    /// A frame of CAN FD, which the interface card does not support.
    #[error("`##` begins a CAN FD frame; only classic frames are read")]
    FlexibleDataRate,
    /// Longer than any line may be.
    #[error("the line has more than {MOST_LINE} bytes")]
    TooLong,
}

impl Entry {
    /// Reads one line without its end.
    ///
    /// # Errors
    /// When the line has neither form.
    pub fn parse(line: &[u8]) -> Result<Self, LineError> {
        let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        let first = words.next().ok_or(LineError::Form)?;
        let entry = if first.starts_with(b"(") {
            let (Some(interface), Some(frame)) = (words.next(), words.next()) else {
                return Err(LineError::Form);
            };
            let interface = Some(String::from_utf8_lossy(interface).into_owned());
            Self { at: Some(time(first)?), interface, frame: parse_frame(frame)? }
        } else {
            Self { at: None, interface: None, frame: parse_frame(first)? }
        };
        // `candump -x` adds whether the frame was received or sent by the computer.
        match words.next() {
            None | Some(b"R" | b"T") if words.next().is_none() => Ok(entry),
            _ => Err(LineError::Form),
        }
    }
}

impl std::fmt::Display for Entry {
    /// The line without its end: the long form where there is a time, else the short one.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some(at) = self.at {
            let (seconds, micros) = (at.micros().div_euclid(1_000_000), at.micros().rem_euclid(1_000_000));
            let interface = self.interface.as_deref().unwrap_or("can0");
            write!(f, "({seconds:010}.{micros:06}) {interface} ")?;
        }
        let frame = &self.frame;
        if frame.is_request() {
            write!(f, "{}#R{}", frame.full_id(), frame.stated_len())
        } else {
            write!(f, "{}#{}", frame.full_id(), Hex(frame.data()))
        }
    }
}

/// Reads lines in whatever pieces they come; it keeps [`MOST_LINE`] bytes at most.
#[derive(Debug, Clone)]
pub struct Reader {
    lines: LineSplitter,
}

impl Default for Reader {
    fn default() -> Self {
        Self { lines: LineSplitter::new(b"\r\n", MOST_LINE) }
    }
}

impl Reader {
    /// Takes the next bytes and gives every entry or error to `found`, with the offset of its line.
    pub fn feed(&mut self, bytes: &[u8], mut found: impl FnMut(u64, Result<Entry, LineError>)) {
        self.lines.feed(bytes, |line| read_line(line, &mut found));
    }

    /// No more bytes will come: an incomplete line is read as far as it goes.
    pub fn end(&mut self, mut found: impl FnMut(u64, Result<Entry, LineError>)) {
        self.lines.end(|line| read_line(line, &mut found));
    }
}

/// Reads a line that is not empty.
fn read_line(line: Line<'_>, found: &mut impl FnMut(u64, Result<Entry, LineError>)) {
    if line.too_long {
        found(line.offset, Err(LineError::TooLong));
    } else if !line.bytes.trim_ascii().is_empty() {
        found(line.offset, Entry::parse(line.bytes));
    }
}

/// `(seconds.decimals)`, to the microsecond; finer decimals are cut off.
fn time(word: &[u8]) -> Result<UtcTime, LineError> {
    let wrong = || LineError::Time(String::from_utf8_lossy(word).into_owned());
    let number = word.strip_prefix(b"(").and_then(|rest| rest.strip_suffix(b")")).ok_or_else(wrong)?;
    let point = number.iter().position(|byte| *byte == b'.').unwrap_or(number.len());
    let (seconds, decimals) = (&number[..point], number.get(point + 1..).unwrap_or_default());
    let digits = [seconds, decimals].into_iter().flatten().all(u8::is_ascii_digit);
    if seconds.is_empty() || seconds.len() > 11 || decimals.len() > 9 || !digits {
        return Err(wrong());
    }
    let value = |digits: &[u8]| digits.iter().fold(0_i64, |n, digit| n * 10 + i64::from(digit - b'0'));
    let mut micros = [b'0'; 6];
    micros.iter_mut().zip(decimals).for_each(|(place, digit)| *place = *digit);
    Ok(UtcTime::from_micros(value(seconds) * 1_000_000 + value(&micros)))
}

/// `id#data`.
fn parse_frame(word: &[u8]) -> Result<CanFrame, LineError> {
    let at = word.iter().position(|byte| *byte == b'#').ok_or(LineError::Form)?;
    let (id, data) = (&word[..at], &word[at + 1..]);
    let text = |bytes| String::from_utf8_lossy(bytes).into_owned();
    let number = hex_number(id).filter(|_| matches!(id.len(), 3 | 8));
    // Three digits are twelve bits.
    let full = number.map(|n| if id.len() == 3 { CanId::Standard(n as u16) } else { CanId::Extended(n) });
    let full = full.filter(|id| id.is_valid()).ok_or_else(|| LineError::Id(text(id)))?;
    let frame = match data {
        [b'#', ..] => return Err(LineError::FlexibleDataRate),
        [b'R' | b'r'] => CanFrame::request(full, 0),
        [b'R' | b'r', len @ b'0'..=b'8'] => CanFrame::request(full, len - b'0'),
        _ => frame_of_hex(full, data),
    };
    frame.ok_or_else(|| LineError::Data(text(data)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::can::strategy::any_frame;
    use proptest::prelude::*;

    fn read(pieces: &[&[u8]]) -> Vec<(u64, Result<Entry, LineError>)> {
        let mut reader = Reader::default();
        let mut all = Vec::new();
        for piece in pieces {
            reader.feed(piece, |at, entry| all.push((at, entry)));
        }
        reader.end(|at, entry| all.push((at, entry)));
        all
    }

    #[test]
    fn both_forms_are_read_and_written() {
        let text = "(1436509052.249713) can0 00D0FEAB#0102";
        let entry = Entry::parse(text.as_bytes()).unwrap();
        assert_eq!(entry.at, Some(UtcTime::from_micros(1_436_509_052_249_713)));
        assert_eq!(entry.interface.as_deref(), Some("can0"));
        assert_eq!(entry.frame, CanFrame::new(0x00D0_FEAB, &[1, 2]).unwrap());
        assert_eq!(entry.to_string(), text);
        let short = Entry::parse(b"00d0feab#e803E803").unwrap();
        assert_eq!(short.to_string(), "00D0FEAB#E803E803");
        assert_eq!(
            Entry::parse(b"7FF#R3").unwrap().frame,
            CanFrame::request(CanId::Standard(0x7FF), 3).unwrap()
        );
        assert_eq!(Entry::parse(b"(12.5) vcan1 123# R").unwrap().at, Some(UtcTime::from_micros(12_500_000)));
    }

    #[test]
    fn errors_say_what_is_wrong() {
        let wrong = |text: &str| Entry::parse(text.as_bytes()).unwrap_err();
        for (text, expected) in [
            ("", LineError::Form),
            ("hello", LineError::Form),
            ("(1.5) 123#00", LineError::Form),
            ("123#00 123#00", LineError::Form),
            ("(1.x) can0 123#00", LineError::Time("(1.x)".into())),
            ("(999999999999) can0 123#00", LineError::Time("(999999999999)".into())),
            ("1234#00", LineError::Id("1234".into())),
            ("800#00", LineError::Id("800".into())),
            ("20000000#00", LineError::Id("20000000".into())),
            ("123#0", LineError::Data("0".into())),
            ("123#+1", LineError::Data("+1".into())),
            ("123#001122334455667788", LineError::Data("001122334455667788".into())),
            ("123#R9", LineError::Data("R9".into())),
            ("123##1", LineError::FlexibleDataRate),
        ] {
            assert_eq!(wrong(text), expected, "{text}");
        }
    }

    #[test]
    fn an_endless_line_is_one_error_and_the_next_is_read() {
        let bytes = [&[b'A'; 5000][..], b"\n123#00\n"].concat();
        let found = read(&[&bytes]);
        assert_eq!(found[0], (0, Err(LineError::TooLong)));
        assert_eq!(found[1].0, 5001);
        assert!(found[1].1.is_ok() && found.len() == 2);
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_back_however_it_is_cut(
            frames in proptest::collection::vec((any_frame(), proptest::option::of(0_i64..1 << 56)), 1..20),
            cut in 0_usize..400,
        ) {
            let entries: Vec<Entry> = frames.into_iter().map(|(frame, at)| {
                let at = at.map(UtcTime::from_micros);
                Entry { at, interface: at.map(|_| "can0".to_owned()), frame }
            }).collect();
            let lines: Vec<String> = entries.iter().map(Entry::to_string).collect();
            let text = lines.join("\n");
            let (head, tail) = text.as_bytes().split_at(cut.min(text.len()));
            let found: Vec<Entry> = read(&[head, tail]).into_iter().map(|(_, entry)| entry.unwrap()).collect();
            prop_assert_eq!(found, entries);
        }

        #[test]
        fn noise_hides_nothing_behind_it(noise in proptest::collection::vec(any::<u8>(), 0..400)) {
            let bytes = [&noise[..], b"\n00D0FEAB#0102\n"].concat();
            let found = read(&[&bytes]);
            prop_assert!(found.last().unwrap().1.is_ok());
            prop_assert_eq!(found, read(&bytes.chunks(1).collect::<Vec<_>>()));
        }
    }
}
