//! From the text of a value to numbers, truth values and lists, as DUNE casts them, but strictly.
//!
//! DUNE ignores what follows a number, so `10 m` is 10 and `1O` is 1; here that is an error. Whole numbers
//! have the bases of C: `0x10` is 16 and `010` is 8, which is almost never meant and therefore reported.

use std::fmt;
use std::net::Ipv4Addr;

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// `true` or `false`.
    Bool(bool),
    /// A whole number.
    Int(i64),
    /// A finite number.
    Float(f64),
    /// Text, unchanged.
    Text(String),
    /// Text with its escapes (`\r`, `\n`, ...) replaced.
    Bytes(Vec<u8>),
    /// One of the words that the parameter allows.
    Choice(&'static str),
    /// An internet address.
    Address(Ipv4Addr),
    /// A list of numbers.
    Floats(Vec<f64>),
    /// A list of whole numbers.
    Ints(Vec<i64>),
    /// A list of texts.
    Texts(Vec<String>),
    /// A list of `name:number`.
    Rates(Vec<(String, f64)>),
    /// A list of `name:text`.
    Pairs(Vec<(String, String)>),
}

/// Why a text is not a value of the wanted type.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ValueError {
    /// Not one of DUNE's six words for truth.
    #[error("`{0}` is neither true nor false")]
    NotBool(String),
    /// Not a whole number.
    #[error("`{0}` is not a whole number")]
    NotInt(String),
    /// A whole number with something behind it, which DUNE would drop.
    #[error("`{junk}` behind the number `{number}` would be dropped by DUNE")]
    Junk {
        /// The part that is a number.
        number: String,
        /// What follows it.
        junk: String,
    },
    /// Not a number.
    #[error("`{0}` is not a number")]
    NotFloat(String),
    /// A number that does not fit.
    #[error("`{0}` is too large a number")]
    TooLarge(String),
    /// A backslash with something unknown behind it.
    #[error("`\\{0}` is not an escape")]
    Escape(String),
    /// Not an IPv4 address.
    #[error("`{0}` is not an IPv4 address")]
    NotAddress(String),
    /// Not `name:value`.
    #[error("`{0}` is not of the form name:value")]
    NotPair(String),
}

impl ValueError {
    /// What to write instead.
    pub const fn remedy(&self) -> &'static str {
        match self {
            Self::NotBool(_) => "one of true, True, 1, false, False, 0",
            Self::NotInt(_) => "a whole number, such as 10 or 0x0a",
            Self::Junk { .. } => "take it out; units stand in the documentation, not behind the number",
            Self::NotFloat(_) => "a number with a decimal point, such as 2.5 or 1e-3",
            Self::TooLarge(_) => "a smaller number",
            Self::Escape(_) => r"one of \r \n \t \0 \\ or \xHH",
            Self::NotAddress(_) => "four numbers of 0 to 255 with points between",
            Self::NotPair(_) => "name:value, with a comma between pairs",
        }
    }
}

/// Reads a truth value: exactly `true True 1 false False 0`.
///
/// # Errors
/// For everything else.
pub fn parse_bool(text: &str) -> Result<bool, ValueError> {
    match text {
        "true" | "True" | "1" => Ok(true),
        "false" | "False" | "0" => Ok(false),
        _ => Err(ValueError::NotBool(text.to_owned())),
    }
}

/// A whole number and the base it was written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Integer {
    /// The number.
    pub value: i64,
    /// Whether a leading zero made it octal although digits follow.
    pub octal: bool,
}

/// Reads a whole number with the bases of C: `0x` hexadecimal, a leading 0 octal, otherwise decimal.
///
/// # Errors
/// When `text` is not such a number, something follows it, or it does not fit 64 bits.
pub fn parse_int(text: &str) -> Result<Integer, ValueError> {
    let not_int = || ValueError::NotInt(text.to_owned());
    let (negative, unsigned) = match text.as_bytes().first() {
        Some(b'-') => (true, &text[1..]),
        Some(b'+') => (false, &text[1..]),
        _ => (false, text),
    };
    let (base, digits) = if let Some(digits) = unsigned.strip_prefix("0x").or(unsigned.strip_prefix("0X")) {
        (16, digits)
    } else if unsigned.len() > 1 && unsigned.starts_with('0') {
        (8, unsigned)
    } else {
        (10, unsigned)
    };
    let count = digits.chars().take_while(|digit| digit.is_digit(base)).count();
    let (digits, junk) = digits.split_at(count);
    if digits.is_empty() {
        return Err(not_int());
    }
    if !junk.is_empty() {
        let number = text[..text.len() - junk.len()].to_owned();
        return Err(ValueError::Junk { number, junk: junk.to_owned() });
    }
    let magnitude = i64::from_str_radix(digits, base).map_err(|_| ValueError::TooLarge(text.to_owned()))?;
    let octal = base == 8 && digits.bytes().any(|digit| digit != b'0');
    Ok(Integer { value: if negative { -magnitude } else { magnitude }, octal })
}

/// Reads a finite decimal number.
///
/// # Errors
/// When `text` is not such a number, something follows it, or it is infinite.
pub fn parse_float(text: &str) -> Result<f64, ValueError> {
    let end = float_length(text);
    let (number, junk) = text.split_at(end);
    if number.is_empty() {
        return Err(ValueError::NotFloat(text.to_owned()));
    }
    if !junk.is_empty() {
        return Err(ValueError::Junk { number: number.to_owned(), junk: junk.to_owned() });
    }
    let value: f64 = number.parse().map_err(|_| ValueError::NotFloat(text.to_owned()))?;
    if value.is_finite() { Ok(value) } else { Err(ValueError::TooLarge(text.to_owned())) }
}

/// How many bytes at the beginning of `text` are a decimal number.
fn float_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits = |from: usize| bytes[from..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    let sign = |at: usize| usize::from(matches!(bytes.get(at), Some(b'+' | b'-')));
    let start = sign(0);
    let whole = digits(start);
    let mut end = start + whole;
    let mut fraction = 0;
    if bytes.get(end) == Some(&b'.') {
        fraction = digits(end + 1);
        end += 1 + fraction;
    }
    if whole + fraction == 0 {
        return 0;
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let exponent = end + 1 + sign(end + 1);
        let length = digits(exponent.min(bytes.len()));
        if length > 0 {
            end = exponent + length;
        }
    }
    end
}

/// Splits a list at its commas and trims each item; an empty text is an empty list.
pub fn split_list(text: &str) -> Vec<&str> {
    if text.is_empty() { Vec::new() } else { text.split(',').map(crate::line::trim).collect() }
}

/// Replaces the escapes in `text`: `\r \n \t \0 \\ \" \'` and `\xHH`.
///
/// # Errors
/// For any other character behind a backslash.
pub fn unescape(text: &str) -> Result<Vec<u8>, ValueError> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text;
    while let Some((before, after)) = rest.split_once('\\') {
        bytes.extend_from_slice(before.as_bytes());
        let bad = || ValueError::Escape(after.chars().take(1).collect());
        let code = after.chars().next().ok_or_else(bad)?;
        let mut length = code.len_utf8();
        bytes.push(match code {
            'r' => b'\r',
            'n' => b'\n',
            't' => b'\t',
            '0' => 0,
            '\\' => b'\\',
            '"' => b'"',
            '\'' => b'\'',
            'x' => {
                length = 3;
                let digits = after.get(1..3).filter(|digits| digits.bytes().all(|d| d.is_ascii_hexdigit()));
                u8::from_str_radix(digits.ok_or_else(bad)?, 16).map_err(|_| bad())?
            }
            _ => return Err(bad()),
        });
        rest = &after[length..];
    }
    bytes.extend_from_slice(rest.as_bytes());
    Ok(bytes)
}

/// Splits `name:value`.
pub(crate) fn parse_pair(text: &str) -> Result<(&str, &str), ValueError> {
    let (name, value) = text.split_once(':').ok_or_else(|| ValueError::NotPair(text.to_owned()))?;
    let (name, value) = (crate::line::trim(name), crate::line::trim(value));
    if name.is_empty() || value.is_empty() {
        return Err(ValueError::NotPair(text.to_owned()));
    }
    Ok((name, value))
}

/// The value as written in a file.
impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fn list<T>(
            f: &mut fmt::Formatter<'_>,
            items: &[T],
            mut item: impl FnMut(&mut fmt::Formatter<'_>, &T) -> fmt::Result,
        ) -> fmt::Result {
            for (index, each) in items.iter().enumerate() {
                if index > 0 {
                    f.write_str(", ")?;
                }
                item(f, each)?;
            }
            Ok(())
        }
        match self {
            Self::Bool(value) => write!(f, "{value}"),
            Self::Int(value) => write!(f, "{value}"),
            Self::Float(value) => write!(f, "{value}"),
            Self::Text(text) => f.write_str(text),
            Self::Bytes(bytes) => write!(f, "{}", bytes.escape_ascii()),
            Self::Choice(word) => f.write_str(word),
            Self::Address(address) => write!(f, "{address}"),
            Self::Floats(values) => list(f, values, |f, value| write!(f, "{value}")),
            Self::Ints(values) => list(f, values, |f, value| write!(f, "{value}")),
            Self::Texts(texts) => list(f, texts, |f, text| f.write_str(text)),
            Self::Rates(rates) => list(f, rates, |f, (name, rate)| write!(f, "{name}:{rate}")),
            Self::Pairs(pairs) => list(f, pairs, |f, (name, text)| write!(f, "{name}:{text}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_six_words_are_truth_values() {
        for (text, value) in [("true", true), ("True", true), ("1", true), ("false", false), ("0", false)] {
            assert_eq!(parse_bool(text), Ok(value));
        }
        for text in ["TRUE", "yes", "on", "01", " true", ""] {
            assert!(parse_bool(text).is_err(), "{text}");
        }
    }

    #[test]
    fn whole_numbers_have_the_bases_of_c() {
        for (text, value, octal) in [
            ("0x2810", 0x2810, false),
            ("-0XfF", -255, false),
            ("010", 8, true),
            ("-017", -15, true),
            ("00", 0, false),
            ("0", 0, false),
            ("+42", 42, false),
        ] {
            assert_eq!(parse_int(text), Ok(Integer { value, octal }), "{text}");
        }
    }

    #[test]
    fn what_follows_a_whole_number_is_an_error() {
        for text in ["10 m", "08", "1.5", "0x1g", "12a"] {
            assert!(matches!(parse_int(text), Err(ValueError::Junk { .. })), "{text}");
        }
        for text in ["", "-", "x", "0x", "--1"] {
            assert!(matches!(parse_int(text), Err(ValueError::NotInt(_))), "{text}");
        }
        assert!(matches!(parse_int("99999999999999999999"), Err(ValueError::TooLarge(_))));
    }

    #[test]
    fn numbers_are_decimal_and_finite() {
        for (text, value) in
            [("29.0e-6", 29e-6), (".5", 0.5), ("5.", 5.0), ("-1", -1.0), ("+2E3", 2000.0), ("010", 10.0)]
        {
            assert_eq!(parse_float(text), Ok(value), "{text}");
        }
        for text in ["", ".", "e5", "nan", "inf", "-", "text"] {
            assert!(matches!(parse_float(text), Err(ValueError::NotFloat(_))), "{text}");
        }
        for text in ["1.0f", "3 kn", "1e", "1.2.3", "0x10", "5e+"] {
            assert!(matches!(parse_float(text), Err(ValueError::Junk { .. })), "{text}");
        }
        assert!(matches!(parse_float("1e999"), Err(ValueError::TooLarge(_))));
    }

    #[test]
    fn lists_are_split_at_commas_and_trimmed() {
        assert!(split_list("").is_empty());
        assert_eq!(split_list("a"), ["a"]);
        assert_eq!(split_list(" a ,b c,, d "), ["a", "b c", "", "d"]);
        assert_eq!(split_list("a,"), ["a", ""]);
    }

    #[test]
    fn escapes_become_bytes() {
        assert_eq!(unescape(r"$JASC,GPGGA,5\r\n").unwrap(), b"$JASC,GPGGA,5\r\n");
        assert_eq!(unescape(r"\x41\\\t").unwrap(), b"A\\\t");
        for text in [r"\q", r"end\", r"\x4", r"\xé1"] {
            assert!(unescape(text).is_err(), "{text}");
        }
    }
}
