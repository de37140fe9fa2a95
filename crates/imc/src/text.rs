//! Text on the wire: bytes that are nearly always UTF-8.

use std::borrow::Cow;
use std::fmt;

/// The value of a `plaintext` field.
///
/// The definition says ASCII, Java senders write UTF-8, others pass any bytes through; embedded NULs are
/// legal. The bytes are kept as they came, so that a packet encodes to what it was decoded from.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Text(Vec<u8>);

impl Text {
    /// From any bytes.
    pub fn from_bytes(bytes: impl Into<Vec<u8>>) -> Self {
        Self(bytes.into())
    }

    /// The bytes on the wire, without their length.
    pub fn as_bytes(&self) -> &[u8] {
        &self.0
    }

    /// The text, when it is UTF-8.
    pub fn as_str(&self) -> Option<&str> {
        str::from_utf8(&self.0).ok()
    }

    /// The text for people: bytes that are not UTF-8 become U+FFFD.
    pub fn to_str_lossy(&self) -> Cow<'_, str> {
        String::from_utf8_lossy(&self.0)
    }

    /// The text with every byte, as files and APIs show it: see [`escape`].
    pub fn escaped(&self) -> Cow<'_, str> {
        escape(&self.0)
    }

    /// Whether there are no bytes.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// Bytes as text that [`unescape`] turns back: what is UTF-8 stays unchanged, any other byte and NUL become `\xNN`.
///
/// Tables and JSON hold text only, and most readers of CSV end a cell at NUL. So that nothing is lost, a text that holds such
/// bytes, or that itself spells `\xNN`, has its backslashes doubled; all other text, backslashes too, is unchanged. A reader
/// knows an escaped text by a `\xNN` in it. A fixed 8-bit encoding would be shorter, but would be a guess: senders mix them.
pub fn escape(bytes: &[u8]) -> Cow<'_, str> {
    plain(bytes).map_or_else(
        || {
            let mut text = String::new();
            escaped_parts(bytes, |part| text.push_str(part));
            Cow::Owned(text)
        },
        Cow::Borrowed,
    )
}

/// The text that needs no escape.
pub(crate) fn plain(bytes: &[u8]) -> Option<&str> {
    str::from_utf8(bytes).ok().filter(|text| !bytes.contains(&0) && !spells_byte(text))
}

/// Passes on the parts of an escaped text one by one, so that it is never in memory whole.
pub(crate) fn escaped_parts(bytes: &[u8], mut each: impl FnMut(&str)) {
    const DIGITS: &str = "0123456789abcdef";
    for chunk in bytes.utf8_chunks() {
        let mut rest = chunk.valid();
        while let Some(at) = rest.find(['\\', '\0']) {
            each(&rest[..at]);
            each(if rest[at..].starts_with('\0') { "\\x00" } else { "\\\\" });
            rest = &rest[at + 1..];
        }
        each(rest);
        for byte in chunk.invalid() {
            each("\\x");
            for digit in [byte >> 4, byte & 0xF].map(usize::from) {
                each(&DIGITS[digit..=digit]);
            }
        }
    }
}

/// The bytes that [`escape`] made a text of.
pub fn unescape(text: &str) -> Cow<'_, [u8]> {
    if !spells_byte(text) {
        return Cow::Borrowed(text.as_bytes());
    }
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((first, after)) = rest.split_first() {
        rest = after;
        match (first, after) {
            (b'\\', [b'\\', after @ ..]) => {
                bytes.push(b'\\');
                rest = after;
            }
            (b'\\', [b'x', high, low, after @ ..]) if is_hex(*high) && is_hex(*low) => {
                bytes.push(nibble(*high) << 4 | nibble(*low));
                rest = after;
            }
            (byte, _) => bytes.push(*byte),
        }
    }
    Cow::Owned(bytes)
}

/// Whether a text contains `\xNN`.
fn spells_byte(text: &str) -> bool {
    let is_byte = |four: &[u8]| matches!(four, [b'\\', b'x', high, low] if is_hex(*high) && is_hex(*low));
    text.contains("\\x") && text.as_bytes().windows(4).any(is_byte)
}

fn is_hex(digit: u8) -> bool {
    digit.is_ascii_hexdigit()
}

/// The value of a hexadecimal digit.
fn nibble(digit: u8) -> u8 {
    match digit {
        b'0'..=b'9' => digit - b'0',
        _ => (digit | 0x20) - b'a' + 10,
    }
}

impl fmt::Debug for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "\"{}\"", self.0.escape_ascii())
    }
}

impl fmt::Display for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&self.to_str_lossy())
    }
}

impl From<&str> for Text {
    fn from(text: &str) -> Self {
        Self(text.as_bytes().to_vec())
    }
}

impl From<String> for Text {
    fn from(text: String) -> Self {
        Self(text.into_bytes())
    }
}

impl PartialEq<str> for Text {
    fn eq(&self, other: &str) -> bool {
        self.0 == other.as_bytes()
    }
}

impl PartialEq<&str> for Text {
    fn eq(&self, other: &&str) -> bool {
        self.0 == other.as_bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn only_what_is_no_text_is_escaped() {
        for (bytes, text) in [
            (&b"C:\\logs\\new"[..], r"C:\logs\new"),
            ("Skjærgård".as_bytes(), "Skjærgård"),
            (b"Sk\xe6r\\g", r"Sk\xe6r\\g"),
            (b"a\0b", r"a\x00b"),
            (br"C:\x41", r"C:\\x41"),
            (br"\x4", r"\x4"),
        ] {
            assert_eq!(escape(bytes), text);
            assert_eq!(unescape(text), bytes);
        }
    }

    proptest! {
        #[test]
        fn every_byte_comes_back(pieces in proptest::collection::vec(
            prop_oneof![any::<u8>().prop_map(|byte| vec![byte]), Just(b"\\x4".to_vec()), Just(b"\\".to_vec()), Just("æ".into())], 0..40,
        )) {
            let bytes = pieces.concat();
            let text = escape(&bytes);
            prop_assert!(!text.contains('\0'));
            prop_assert_eq!(&*unescape(&text), &bytes[..]);
        }
    }
}
