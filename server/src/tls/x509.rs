//! Reads validity and names of a certificate (RFC 5280, section 4.1).
//!
//! Signatures are checked by rustls; this reads two fields of the configured file. Lengths are checked against the
//! available bytes, and anything not understood gives `None`.

use anyhow::{Context as _, ensure};
use rustls::pki_types::CertificateDer;
use rustls::pki_types::pem::PemObject as _;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr};
use std::path::Path;
use units::{Civil, UtcTime};

const INTEGER: u8 = 0x02;
const OCTETS: u8 = 0x04;
const SEQUENCE: u8 = 0x30;
const UTC_TIME: u8 = 0x17;
const GENERALIZED_TIME: u8 = 0x18;
/// The version of a certificate, `[0]`, and its extensions, `[3]`.
const VERSION: u8 = 0xA0;
const EXTENSIONS: u8 = 0xA3;
/// A name of the domain name system, and an address, among the alternative names.
const DNS_NAME: u8 = 0x82;
const IP_ADDRESS: u8 = 0x87;
/// 2.5.29.17, the subject's alternative names.
const ALTERNATIVE_NAMES: &[u8] = &[0x06, 3, 0x55, 0x1D, 0x11];

/// The data read from a certificate.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Facts {
    /// Begin of validity.
    pub(crate) from: UtcTime,
    /// End of validity.
    pub(crate) until: UtcTime,
    /// Its names and addresses.
    pub(crate) names: Vec<String>,
}

impl Facts {
    /// Reads them; `None` if the bytes are not a certificate.
    pub(crate) fn of(der: &[u8]) -> Option<Self> {
        let mut whole = Fields(der);
        let mut certificate = Fields(whole.take(SEQUENCE)?);
        let mut signed = Fields(certificate.take(SEQUENCE)?);
        signed.skip(VERSION);
        signed.take(INTEGER)?;
        // The algorithm and the issuer.
        signed.take(SEQUENCE)?;
        signed.take(SEQUENCE)?;
        let mut validity = Fields(signed.take(SEQUENCE)?);
        let (from, until) = (validity.time()?, validity.time()?);
        // The subject and its key.
        signed.take(SEQUENCE)?;
        signed.take(SEQUENCE)?;
        let names = extensions(signed).and_then(alternative_names).unwrap_or_default();
        Some(Self { from, until, names })
    }
}

/// The first certificate of a PEM file.
///
/// # Errors
/// The file cannot be read, or holds none; the error names it.
pub(crate) fn first_in(path: &Path) -> anyhow::Result<(CertificateDer<'static>, Facts)> {
    let told = || path.display().to_string();
    let first = CertificateDer::pem_file_iter(path).with_context(told)?.next();
    ensure!(first.is_some(), "{} holds no certificate in PEM", path.display());
    let der = first.transpose().with_context(told)?.with_context(told)?;
    let facts =
        Facts::of(&der).with_context(|| format!("{} holds no certificate of X.509", path.display()))?;
    Ok((der, facts))
}

/// The extensions are the last signed field; unique identifiers may precede them.
fn extensions(mut signed: Fields<'_>) -> Option<&[u8]> {
    while let Some((tag, value)) = signed.next() {
        if tag == EXTENSIONS {
            return Fields(value).take(SEQUENCE);
        }
    }
    None
}

fn alternative_names(extensions: &[u8]) -> Option<Vec<String>> {
    let mut extensions = Fields(extensions);
    while let Some((SEQUENCE, extension)) = extensions.next() {
        let Some(rest) = extension.strip_prefix(ALTERNATIVE_NAMES) else { continue };
        // The critical flag may precede the value.
        let mut fields = Fields(rest);
        let value = std::iter::from_fn(|| fields.next()).find(|(tag, _)| *tag == OCTETS)?.1;
        let mut names = Fields(Fields(value).take(SEQUENCE)?);
        return Some(
            std::iter::from_fn(|| names.next()).filter_map(|(tag, name)| named(tag, name)).collect(),
        );
    }
    None
}

fn named(tag: u8, name: &[u8]) -> Option<String> {
    match (tag, name.len()) {
        (DNS_NAME, _) => std::str::from_utf8(name).ok().map(str::to_owned),
        (IP_ADDRESS, 4) => Some(IpAddr::from(Ipv4Addr::from(<[u8; 4]>::try_from(name).ok()?)).to_string()),
        (IP_ADDRESS, 16) => Some(IpAddr::from(Ipv6Addr::from(<[u8; 16]>::try_from(name).ok()?)).to_string()),
        _ => None,
    }
}

/// A sequence of DER values.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    /// The next value and its tag.
    fn next(&mut self) -> Option<(u8, &'a [u8])> {
        let (&[tag, first], mut rest) = self.0.split_first_chunk()?;
        let mut length = usize::from(first);
        if first & 0x80 != 0 {
            let (digits, after) =
                rest.split_at_checked(usize::from(first & 0x7F)).filter(|(it, _)| it.len() <= 4)?;
            length = digits
                .iter()
                .try_fold(0_usize, |sum, digit| sum.checked_mul(256)?.checked_add((*digit).into()))?;
            rest = after;
        }
        let (value, after) = rest.split_at_checked(length)?;
        self.0 = after;
        Some((tag, value))
    }

    /// The next value, which must have this tag.
    fn take(&mut self, tag: u8) -> Option<&'a [u8]> {
        self.next().filter(|(found, _)| *found == tag).map(|(_, value)| value)
    }

    /// Skips the next value if it has this tag.
    fn skip(&mut self, tag: u8) {
        if self.0.first() == Some(&tag) {
            self.next();
        }
    }

    fn time(&mut self) -> Option<UtcTime> {
        let (tag, text) = self.next()?;
        let digits = text.strip_suffix(b"Z")?;
        if !digits.iter().all(u8::is_ascii_digit) {
            return None;
        }
        let two = |at: usize| digits.get(at..at + 2).map(|two| (two[0] - b'0') * 10 + two[1] - b'0');
        let (year, at) = match (tag, digits.len()) {
            // Two-digit years mean 1950 to 2049.
            (UTC_TIME, 12) => (if two(0)? < 50 { 2000 } else { 1900 } + i64::from(two(0)?), 2),
            (GENERALIZED_TIME, 14) => (i64::from(two(0)?) * 100 + i64::from(two(2)?), 4),
            _ => return None,
        };
        UtcTime::from_civil(Civil {
            year,
            month: two(at)?,
            day: two(at + 2)?,
            hour: two(at + 4)?,
            minute: two(at + 6)?,
            second: two(at + 8)?,
            microsecond: 0,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rcgen::{CertificateParams, KeyPair};

    fn made(names: &[&str], until: (i32, u8, u8)) -> Vec<u8> {
        let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
        let mut parameters = CertificateParams::new(names).unwrap();
        parameters.not_before = rcgen::date_time_ymd(2026, 3, 1);
        parameters.not_after = rcgen::date_time_ymd(until.0, until.1, until.2);
        parameters.self_signed(&KeyPair::generate().unwrap()).unwrap().der().to_vec()
    }

    #[test]
    fn end_and_names_are_those_that_were_asked_for() {
        let names = ["boats.example.no", "10.8.0.1", "::1"];
        for (until, written) in [((2028, 2, 29), "2028-02-29"), ((2061, 7, 4), "2061-07-04")] {
            let facts = Facts::of(&made(&names, until)).unwrap();
            assert_eq!(shore::clock::written(facts.from), "2026-03-01 00:00:00Z");
            assert_eq!(shore::clock::written(facts.until), format!("{written} 00:00:00Z"));
            assert_eq!(facts.names, names);
        }
        assert_eq!(Facts::of(&made(&[], (2030, 1, 1))).unwrap().names, [""; 0]);
    }

    proptest! {
        #[test]
        fn no_bytes_make_it_panic(mut bytes in prop::collection::vec(any::<u8>(), 0..300), at in 0_usize..600, to in any::<u8>()) {
            Facts::of(&bytes);
            bytes.splice(0..0, [SEQUENCE, 0x84, 0xFF, 0xFF, 0xFF, 0xFF]);
            prop_assert_eq!(Facts::of(&bytes), None);
            let mut near = made(&["localhost"], (2030, 1, 1));
            let length = near.len();
            near[at % length] = to;
            Facts::of(&near);
            prop_assert_eq!(Facts::of(&near[..at % length]), None);
        }
    }
}
