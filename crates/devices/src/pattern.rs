//! Receivers whose lines a pattern declares: text that must stand there, and fields in braces, as in
//! `{serial},{counter},{utc},{protocol},{id},{data?},#{sum8}`.
//!
//! A field ends where the text behind it begins; `?` lets it be empty, and then it is not reported. Fields: `serial`,
//! `counter`, `protocol`, `id`, `data`, `snr_db`, and `skip` for what is of no use; the time as `unix_s` (with `ms`),
//! `unix_ms` or `utc` (ISO 8601, with a blank for the T if it likes); the carrier as `khz` or `hz`. Checksums are two
//! hexadecimal digits over the line before the text in front of them, without a leading `$`: `sum8`, the low byte of the
//! sum, or `xor8`. A pattern must name an `id` and a time.

use crate::reading::TagReading;
use units::UtcTime;

/// The longest pattern (bytes).
pub const LONGEST_PATTERN: usize = 256;
/// The longest line worth reading (bytes).
pub const LONGEST: usize = 512;

/// The kind of a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Name {
    Serial,
    Counter,
    Protocol,
    Id,
    Data,
    SnrDb,
    Skip,
    UnixS,
    UnixMs,
    Ms,
    Utc,
    Khz,
    Hz,
    Sum8,
    Xor8,
}

const NAMES: [(&str, Name); 15] = [
    ("serial", Name::Serial),
    ("counter", Name::Counter),
    ("protocol", Name::Protocol),
    ("id", Name::Id),
    ("data", Name::Data),
    ("snr_db", Name::SnrDb),
    ("skip", Name::Skip),
    ("unix_s", Name::UnixS),
    ("unix_ms", Name::UnixMs),
    ("ms", Name::Ms),
    ("utc", Name::Utc),
    ("khz", Name::Khz),
    ("hz", Name::Hz),
    ("sum8", Name::Sum8),
    ("xor8", Name::Xor8),
];

#[derive(Debug, Clone, PartialEq, Eq)]
enum Token {
    Text(String),
    Field { name: Name, may_be_empty: bool },
}

/// A declared line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pattern {
    tokens: Vec<Token>,
}

/// The pattern declares no line.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NoPattern {
    /// It is longer than [`LONGEST_PATTERN`].
    #[error("the pattern is longer than 256 bytes")]
    TooLong,
    /// A brace has no other.
    #[error("a brace of the pattern is not closed, or closes nothing")]
    Brace,
    /// A field is not known.
    #[error(
        "'{0}' is not a field of a pattern: serial, counter, protocol, id, data, snr_db, skip, unix_s, unix_ms, ms, utc, khz, hz, sum8 and xor8 are"
    )]
    Unknown(String),
    /// There is no text between two fields.
    #[error("two fields of the pattern touch: put between them what stands there")]
    Touching,
    /// A field comes twice.
    #[error("a field of the pattern comes twice: only skip may")]
    Twice,
    /// It names no id or no time.
    #[error("the pattern must name {{id}} and a time: {{unix_s}}, {{unix_ms}} or {{utc}}")]
    Lacking,
}

/// Why a line is not the declared one.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NoMatch {
    /// A byte is not a printable character.
    #[error("bytes that are not text: the baud rate may be wrong")]
    NotText,
    /// Text of the pattern is missing.
    #[error("'{0}' does not stand where the pattern has it")]
    Text(String),
    /// A field is not valid.
    #[error("{name} is not valid: '{text}'")]
    Field {
        /// The field's name.
        name: &'static str,
        /// The text found.
        text: String,
    },
    /// The checksum is another.
    #[error("checksum {stands}, computed {computed:02X}")]
    Checksum {
        /// The text found.
        stands: String,
        /// The checksum of the bytes.
        computed: u8,
    },
    /// Text follows after the end of the pattern.
    #[error("the line goes on behind the pattern")]
    Longer,
}

impl Pattern {
    /// Reads a pattern.
    ///
    /// # Errors
    /// When it is not a pattern, or a reading could not be made of its fields.
    pub fn parse(text: &str) -> Result<Self, NoPattern> {
        if text.len() > LONGEST_PATTERN {
            return Err(NoPattern::TooLong);
        }
        let mut tokens = Vec::new();
        let mut rest = text;
        while !rest.is_empty() {
            let literal = rest.find(['{', '}']).unwrap_or(rest.len());
            if literal > 0 {
                tokens.push(Token::Text(rest[..literal].to_owned()));
            }
            rest = &rest[literal..];
            if rest.is_empty() {
                break;
            }
            let inner = rest.strip_prefix('{').ok_or(NoPattern::Brace)?;
            let (name, behind) = inner.split_once('}').ok_or(NoPattern::Brace)?;
            tokens.push(field(name)?);
            rest = behind;
        }
        let pattern = Self { tokens };
        pattern.check()?;
        Ok(pattern)
    }

    /// Whether the pattern has a field of this name: what it has not is 0 or empty in every reading, and not reported.
    pub fn declares(&self, name: &str) -> bool {
        self.names().any(|own| own.text() == name)
    }

    fn names(&self) -> impl Iterator<Item = Name> + '_ {
        let name = |token: &Token| if let Token::Field { name, .. } = token { Some(*name) } else { None };
        self.tokens.iter().filter_map(name)
    }

    fn check(&self) -> Result<(), NoPattern> {
        let is_field = |token: &Token| matches!(token, Token::Field { .. });
        if self.tokens.windows(2).any(|two| two.iter().all(is_field)) {
            return Err(NoPattern::Touching);
        }
        let times = |wanted: Name| self.names().filter(|name| *name == wanted).count();
        if NAMES.iter().any(|(_, name)| *name != Name::Skip && times(*name) > 1) {
            return Err(NoPattern::Twice);
        }
        let clocks = times(Name::UnixS) + times(Name::UnixMs) + times(Name::Utc);
        if times(Name::Id) == 0 || clocks != 1 {
            return Err(NoPattern::Lacking);
        }
        Ok(())
    }

    /// Reads a line, without its end. What the pattern does not declare is 0 or empty in the reading; the raw line is kept.
    ///
    /// # Errors
    /// When the line is not as declared.
    pub fn read(&self, line: &[u8]) -> Result<TagReading, NoMatch> {
        let line = line.trim_ascii();
        if !line.iter().all(|byte| (b' '..=b'~').contains(byte)) {
            return Err(NoMatch::NotText);
        }
        let line = std::str::from_utf8(line).map_err(|_| NoMatch::NotText)?;
        let mut reading = TagReading { raw: Some(line.to_owned()), ..TagReading::default() };
        let (mut rest, mut before) = (line, 0);
        for (index, token) in self.tokens.iter().enumerate() {
            match token {
                Token::Text(text) => {
                    before = line.len() - rest.len();
                    rest = rest.strip_prefix(text.as_str()).ok_or_else(|| NoMatch::Text(text.clone()))?;
                }
                Token::Field { name, may_be_empty } => {
                    let end = match self.tokens.get(index + 1) {
                        Some(Token::Text(text)) => {
                            rest.find(text.as_str()).ok_or_else(|| NoMatch::Text(text.clone()))?
                        }
                        Some(Token::Field { .. }) | None => rest.len(),
                    };
                    let (value, behind) = rest.split_at(end);
                    rest = behind;
                    if !(value.is_empty() && *may_be_empty) {
                        name.take(value.trim(), &line[..before], &mut reading)?;
                    }
                }
            }
        }
        if rest.is_empty() { Ok(reading) } else { Err(NoMatch::Longer) }
    }
}

fn field(text: &str) -> Result<Token, NoPattern> {
    let (name, may_be_empty) = text.strip_suffix('?').map_or((text, false), |name| (name, true));
    let known = NAMES.iter().find(|(known, _)| *known == name);
    let (_, name) = known.ok_or_else(|| NoPattern::Unknown(text.to_owned()))?;
    Ok(Token::Field { name: *name, may_be_empty })
}

impl Name {
    fn text(self) -> &'static str {
        NAMES.iter().find(|(_, name)| *name == self).map_or("", |(text, _)| text)
    }

    fn wrong(self, text: &str) -> NoMatch {
        NoMatch::Field { name: self.text(), text: text.chars().take(40).collect() }
    }

    fn number<T: TryFrom<u64>>(self, text: &str) -> Result<T, NoMatch> {
        let digits = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
        let value = digits.then(|| text.parse::<u64>().ok()).flatten();
        value.and_then(|value| T::try_from(value).ok()).ok_or_else(|| self.wrong(text))
    }

    /// Puts a field's value into the reading. `before` is the line up to the text in front of the field.
    fn take(self, text: &str, before: &str, reading: &mut TagReading) -> Result<(), NoMatch> {
        match self {
            Self::Serial => reading.serial = self.number(text)?,
            Self::Counter => reading.counter = self.number(text)?,
            Self::Protocol if text.is_empty() || text.len() > 16 => return Err(self.wrong(text)),
            Self::Protocol => text.clone_into(&mut reading.protocol),
            Self::Id => reading.tag_id = self.number(text)?,
            Self::Data => reading.data = Some(self.number(text)?),
            Self::SnrDb => reading.snr_db = self.number(text)?,
            Self::Skip => {}
            Self::UnixS => reading.clock_s = self.number(text)?,
            Self::UnixMs => self.set_clock(self.number(text)?, text, reading)?,
            Self::Ms => {
                let millis = Some(self.number(text)?).filter(|&millis| millis < 1000);
                reading.millis = millis.ok_or_else(|| self.wrong(text))?;
            }
            Self::Utc => {
                let utc: UtcTime = text.parse().map_err(|_| self.wrong(text))?;
                let millis = u64::try_from(utc.micros() / 1000).map_err(|_| self.wrong(text))?;
                self.set_clock(millis, text, reading)?;
            }
            Self::Khz => reading.frequency_khz = self.number(text)?,
            Self::Hz => {
                let hz: u64 = self.number(text)?;
                // Half a kilohertz counts as the next one.
                let khz = (hz.saturating_add(500)) / 1000;
                reading.frequency_khz = u8::try_from(khz).map_err(|_| self.wrong(text))?;
            }
            Self::Sum8 => checksum(text, before, u8::wrapping_add)?,
            Self::Xor8 => checksum(text, before, |sum, byte| sum ^ byte)?,
        }
        Ok(())
    }

    fn set_clock(self, millis: u64, text: &str, reading: &mut TagReading) -> Result<(), NoMatch> {
        reading.clock_s = u32::try_from(millis / 1000).map_err(|_| self.wrong(text))?;
        // A remainder below a thousand.
        reading.millis = (millis % 1000) as u16;
        Ok(())
    }
}

fn checksum(text: &str, before: &str, add: impl Fn(u8, u8) -> u8) -> Result<(), NoMatch> {
    let computed = before.strip_prefix('$').unwrap_or(before).bytes().fold(0, add);
    let two_digits = text.len() == 2 && text.bytes().all(|byte| byte.is_ascii_hexdigit());
    if two_digits && u8::from_str_radix(text, 16) == Ok(computed) {
        Ok(())
    } else {
        Err(NoMatch::Checksum { stands: text.chars().take(8).collect(), computed })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(pattern: &str, line: &str) -> Result<TagReading, NoMatch> {
        Pattern::parse(pattern).unwrap().read(line.as_bytes())
    }

    #[test]
    fn a_pattern_reads_what_the_receivers_own_codec_reads() {
        let line = "450123,017,2026-09-21 12:43:17,A69-1303,12345,#D0";
        let found = read("{serial},{counter},{utc},{protocol},{id},#{sum8}", line).unwrap();
        let Ok(crate::vr2c::Line::Tag(own)) = crate::vr2c::parse(line.as_bytes()) else { panic!("no tag") };
        assert_eq!(TagReading { frequency_khz: 69, ..found }, own.tag);
        let line = "$001129,1551087572,897,OPs,15,,33,69";
        let found = read("${serial},{unix_s},{ms},{protocol},{id},{data?},{snr_db},{khz}", line).unwrap();
        let own = crate::tbr::parse(line.as_bytes()).unwrap();
        assert_eq!(crate::tbr::Line::Tag(found), own.line);
    }

    #[test]
    fn units_are_converted_and_checksums_checked() {
        let body = "TAG 12 @ 1551087572897 f=69500";
        let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
        let pattern = "$TAG {id} @ {unix_ms} f={hz}*{xor8}";
        let found = read(pattern, &format!("${body}*{sum:02x}")).unwrap();
        assert_eq!((found.tag_id, found.clock_s, found.millis), (12, 1_551_087_572, 897));
        assert_eq!((found.frequency_khz, found.data), (70, None));
        let wrong = read(pattern, &format!("${body}*{:02X}", sum ^ 1));
        assert_eq!(wrong, Err(NoMatch::Checksum { stands: format!("{:02X}", sum ^ 1), computed: sum }));
    }

    #[test]
    fn lines_that_are_not_declared_are_refused() {
        let pattern = "{id},{unix_s}";
        for line in ["", "1", "x,1", "1,", "1,-2", "1,2,3", ",2", "1,99999999999"] {
            assert!(read(pattern, line).is_err(), "{line}");
        }
        assert_eq!(read("{id},{unix_s};", "1,2;3"), Err(NoMatch::Longer));
        assert_eq!(read(pattern, "1,é"), Err(NoMatch::NotText));
    }

    #[test]
    fn patterns_that_make_no_reading_are_refused() {
        for (pattern, expected) in [
            ("{id}{unix_s}", NoPattern::Touching),
            ("{id},{unix_s}}", NoPattern::Brace),
            ("{id},{unix_s", NoPattern::Brace),
            ("{id},{time}", NoPattern::Unknown("time".to_owned())),
            ("{id},{id},{utc}", NoPattern::Twice),
            ("{id}", NoPattern::Lacking),
            ("{utc}", NoPattern::Lacking),
            ("{id},{utc},{unix_s}", NoPattern::Lacking),
        ] {
            assert_eq!(Pattern::parse(pattern), Err(expected), "{pattern}");
        }
        assert_eq!(Pattern::parse(&"x".repeat(300)), Err(NoPattern::TooLong));
    }
}
