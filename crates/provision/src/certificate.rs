//! How long a certificate lasts, read from its PEM text.
//!
//! Only the validity of RFC 5280 (section 4.1.2.5) is read, so that a boat can say "expired" or "my clock is wrong" before
//! it tries to connect; whether the certificate is valid is decided by rustls. A parser of all of X.509 would weigh
//! more than the rest of provisioning.

use base64ct::{Base64, Encoding as _};
use units::{Civil, UtcTime};

/// From when until when a certificate is good.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Validity {
    /// Not before.
    pub from: UtcTime,
    /// Not after.
    pub until: UtcTime,
}

const BEGIN: &str = "-----BEGIN CERTIFICATE-----";
const END: &str = "-----END CERTIFICATE-----";
/// Certificates of a file that are read.
const MOST: usize = 50;

const SEQUENCE: u8 = 0x30;
const INTEGER: u8 = 0x02;
const VERSION: u8 = 0xA0;
const UTC_TIME: u8 = 0x17;
const GENERALIZED_TIME: u8 = 0x18;

/// When the certificate in a PEM text is valid; if there are several, the one that expires last. `None` if no certificate can be
/// read.
pub fn authority_validity(pem: &str) -> Option<Validity> {
    let blocks = pem.split(BEGIN).skip(1).take(MOST);
    let bodies = blocks.filter_map(|block| block.split_once(END).map(|(body, _)| body));
    let read = |body: &str| {
        let body: String = body.chars().filter(|letter| !letter.is_ascii_whitespace()).collect();
        validity(&Base64::decode_vec(&body).ok()?)
    };
    bodies.filter_map(read).max_by_key(|validity| validity.until)
}

fn validity(der: &[u8]) -> Option<Validity> {
    let (certificate, _) = expect(der, SEQUENCE)?;
    let (mut inside, _) = expect(certificate, SEQUENCE)?;
    if let Some((_, rest)) = expect(inside, VERSION) {
        inside = rest;
    }
    // Serial number, algorithm, issuer.
    for tag in [INTEGER, SEQUENCE, SEQUENCE] {
        inside = expect(inside, tag)?.1;
    }
    let (validity, _) = expect(inside, SEQUENCE)?;
    let (from, rest) = time(validity)?;
    let (until, _) = time(rest)?;
    Some(Validity { from, until })
}

/// The content of the element that `bytes` begin with, if it has this tag, and what comes after it.
fn expect(bytes: &[u8], tag: u8) -> Option<(&[u8], &[u8])> {
    let (found, content, rest) = element(bytes)?;
    (found == tag).then_some((content, rest))
}

/// Tag, content and what comes after the element that `bytes` begin with.
fn element(bytes: &[u8]) -> Option<(u8, &[u8], &[u8])> {
    let (&[tag, first], rest) = bytes.split_first_chunk()?;
    let (length, rest) = if first < 0x80 {
        (usize::from(first), rest)
    } else {
        let count = usize::from(first & 0x7F);
        if !(1..=3).contains(&count) || rest.len() < count {
            return None;
        }
        let (digits, rest) = rest.split_at(count);
        (digits.iter().fold(0, |sum, digit| sum << 8 | usize::from(*digit)), rest)
    };
    (length <= rest.len()).then(|| (tag, &rest[..length], &rest[length..]))
}

fn time(bytes: &[u8]) -> Option<(UtcTime, &[u8])> {
    let (tag, content, rest) = element(bytes)?;
    let text = std::str::from_utf8(content).ok()?.strip_suffix('Z')?;
    if !text.bytes().all(|byte| byte.is_ascii_digit()) {
        return None;
    }
    let (year, text) = match (tag, text.len()) {
        (GENERALIZED_TIME, 14) => (text[..4].parse().ok()?, &text[4..]),
        (UTC_TIME, 12) => {
            let year: i64 = text[..2].parse().ok()?;
            (if year < 50 { 2000 + year } else { 1900 + year }, &text[2..])
        }
        _ => return None,
    };
    let part = |at: usize| text[at..at + 2].parse::<u8>().ok();
    let civil = Civil {
        year,
        month: part(0)?,
        day: part(2)?,
        hour: part(4)?,
        minute: part(6)?,
        second: part(8)?,
        microsecond: 0,
    };
    UtcTime::from_civil(civil).map(|time| (time, rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 3650 -subj /CN=shore`
    const AUTHORITY: &str = include_str!("../tests/authority.pem");

    #[test]
    fn the_validity_is_what_openssl_says() {
        let found = authority_validity(AUTHORITY).unwrap();
        let civil =
            Civil { year: 2026, month: 11, day: 25, hour: 20, minute: 41, second: 44, microsecond: 0 };
        assert_eq!(Some(found.from), UtcTime::from_civil(civil));
        assert_eq!(found.until.micros() - found.from.micros(), 3_650 * 86_400_000_000);
        let several = format!("{AUTHORITY}\nsome words\n{AUTHORITY}");
        assert_eq!(authority_validity(&several), Some(found));
    }

    #[test]
    fn what_is_no_certificate_has_none() {
        for text in ["", "words", BEGIN, &format!("{BEGIN}\nMIIB\n{END}"), &AUTHORITY.replace('M', "!")] {
            assert_eq!(authority_validity(text), None, "{text}");
        }
        let whole = validity_bytes();
        for cut in 0..100 {
            assert_eq!(validity(&whole[..cut]), None, "{cut}");
        }
    }

    fn validity_bytes() -> Vec<u8> {
        let body = AUTHORITY.split_once(BEGIN).unwrap().1.split_once(END).unwrap().0;
        Base64::decode_vec(&body.replace('\n', "")).unwrap()
    }
}
