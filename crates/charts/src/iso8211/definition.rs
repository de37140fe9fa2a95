//! The data descriptive record: which subfields a field has and how they are written.

use super::error::{Iso8211Error, Iso8211Problem};
use super::record::Record;
use super::tag::Tag;
use super::{FIELD_TERMINATOR, UNIT_TERMINATOR};
use std::collections::BTreeMap;

/// No field of S-57 has more than 16 subfields; beyond this a description is hostile.
const MAX_SUBFIELDS: usize = 256;

/// How a subfield is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// `A`: text up to a unit terminator, or of a fixed number of characters.
    Text(Option<usize>),
    /// `I`: an integer in digits.
    Integer(Option<usize>),
    /// `R`, `S`: a real number in digits.
    Real(Option<usize>),
    /// `B(n)`: n/8 bytes taken as they are.
    Bits(usize),
    /// `b1n`: an unsigned integer of n bytes, least significant first.
    Unsigned(usize),
    /// `b2n`: an integer of n bytes in two's complement, least significant first.
    Signed(usize),
}

/// One subfield.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Subfield {
    /// Its name, such as `RCID`.
    pub label: String,
    /// How it is written.
    pub format: Format,
}

/// One field as the head of the file describes it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FieldDefinition {
    /// The field.
    pub tag: Tag,
    /// Its subfields in order.
    pub subfields: Vec<Subfield>,
    /// Whether the subfields repeat to the end of the field.
    pub repeats: bool,
}

impl FieldDefinition {
    /// The labels in order.
    pub fn labels(&self) -> impl Iterator<Item = &str> {
        self.subfields.iter().map(|subfield| subfield.label.as_str())
    }
}

/// All definitions of a data descriptive record.
pub(super) fn parse_definitions(
    record: &Record<'_>,
    control_length: usize,
) -> Result<BTreeMap<Tag, FieldDefinition>, Iso8211Error> {
    let mut definitions = BTreeMap::new();
    for field in &record.fields {
        // `0000` is the file's own title and tree; a reader of known fields has no use for it.
        if &field.tag.0 == b"0000" {
            continue;
        }
        let fail = |problem| Iso8211Error { record: 0, offset: field.offset, problem };
        let [body @ .., FIELD_TERMINATOR] = field.bytes else {
            return Err(fail(Iso8211Problem::Unterminated(field.tag)));
        };
        let text = body.get(control_length..).unwrap_or_default();
        let mut parts = units(text).skip(1);
        let labels = String::from_utf8_lossy(parts.next().unwrap_or_default()).into_owned();
        let formats = String::from_utf8_lossy(parts.next().unwrap_or_default()).into_owned();
        let described = |formats: &str| {
            fail(Iso8211Problem::Description { tag: field.tag, formats: formats.escape_debug().to_string() })
        };
        let parsed = parse_formats(&formats).ok_or_else(|| described(&formats))?;
        let repeats = labels.starts_with('*');
        let labels: Vec<&str> = labels.trim_start_matches('*').split('!').collect();
        if labels.len() != parsed.len() {
            return Err(described(&formats));
        }
        let named = |(label, format): (&&str, Format)| Subfield { label: (*label).to_owned(), format };
        let subfields = labels.iter().zip(parsed).map(named).collect();
        definitions.insert(field.tag, FieldDefinition { tag: field.tag, subfields, repeats });
    }
    Ok(definitions)
}

/// Splits at unit terminators; what follows the last one is the last part.
fn units(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    bytes.split(|byte| *byte == UNIT_TERMINATOR)
}

/// `(b11,2b12,A(8))` with its repetitions written out.
fn parse_formats(text: &str) -> Option<Vec<Format>> {
    let inner = text.trim().strip_prefix('(')?.strip_suffix(')')?;
    let mut formats = Vec::new();
    expand(inner, 0, &mut formats)?;
    (!formats.is_empty()).then_some(formats)
}

fn expand(text: &str, depth: usize, formats: &mut Vec<Format>) -> Option<()> {
    // S-57 nests nothing; three levels are generous.
    if depth > 3 {
        return None;
    }
    for item in split_top(text)? {
        let item = item.trim();
        let digits = item.len() - item.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        let (count, what) = item.split_at(digits);
        let count: usize = if count.is_empty() { 1 } else { count.parse().ok()? };
        if count == 0 || count > MAX_SUBFIELDS {
            return None;
        }
        let before = formats.len();
        if let Some(inner) = what.strip_prefix('(').and_then(|rest| rest.strip_suffix(')')) {
            expand(inner, depth + 1, formats)?;
        } else {
            formats.push(parse_format(what)?);
        }
        let group = formats.len() - before;
        if formats.len() + group * (count - 1) > MAX_SUBFIELDS {
            return None;
        }
        for _ in 1..count {
            formats.extend_from_within(before..before + group);
        }
    }
    Some(())
}

/// Splits at the commas that stand in no bracket.
fn split_top(text: &str) -> Option<Vec<&str>> {
    let (mut items, mut depth, mut from) = (Vec::new(), 0_usize, 0);
    for (at, byte) in text.bytes().enumerate() {
        match byte {
            b'(' => depth += 1,
            b')' => depth = depth.checked_sub(1)?,
            b',' if depth == 0 => {
                items.push(&text[from..at]);
                from = at + 1;
            }
            _ => {}
        }
    }
    items.push(&text[from..]);
    (depth == 0).then_some(items)
}

fn parse_format(text: &str) -> Option<Format> {
    let mut letters = text.chars();
    let kind = letters.next()?;
    let rest = letters.as_str();
    if kind == 'b' {
        let width = rest.get(1..)?.parse().ok().filter(|width| (1..=4).contains(width))?;
        return match rest.as_bytes().first()? {
            b'1' => Some(Format::Unsigned(width)),
            b'2' => Some(Format::Signed(width)),
            _ => None,
        };
    }
    let width: Option<usize> = match rest {
        "" => None,
        _ => Some(rest.strip_prefix('(')?.strip_suffix(')')?.parse().ok().filter(|width| *width > 0)?),
    };
    match kind {
        'A' => Some(Format::Text(width)),
        'I' => Some(Format::Integer(width)),
        'R' | 'S' => Some(Format::Real(width)),
        'B' => width.filter(|bits| bits % 8 == 0).map(|bits| Format::Bits(bits / 8)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn writes_repetitions_out() {
        let formats = parse_formats("(b11,b14,2b11,3A,A(8),R(4),B(40),2(b12,A))").unwrap();
        assert_eq!(formats.len(), 14);
        assert_eq!(formats[0], Format::Unsigned(1));
        assert_eq!(formats[7], Format::Text(Some(8)));
        assert_eq!(formats[9], Format::Bits(5));
        assert_eq!(formats[13], Format::Text(None));
    }

    #[test]
    fn refuses_what_is_no_format() {
        for text in ["", "()", "b11", "(b19)", "(A(0))", "(999999999b11)", "(99(99(99(A))))", "((((((A))))))"]
        {
            assert_eq!(parse_formats(text), None, "{text}");
        }
    }
}
