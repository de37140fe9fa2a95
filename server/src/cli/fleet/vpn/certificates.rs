//! Certificates of OpenVPN: an authority for the VPN alone, what it signs, and its list of revoked certificates.
//!
//! All last as long as the authority: a boat that is at sea when its certificate ends is off the VPN, and a stolen one is
//! revoked by the list. The list lasts as long, because OpenVPN lets nobody in once it has ended.

use crate::tls::authority::lasts;
use crate::tls::{DAY_US, day};
use anyhow::{Context as _, ensure};
use provision::authority_validity;
use provision::openvpn::Identity;
use rcgen::{
    BasicConstraints, CertificateParams, CertificateRevocationListParams, DnType, ExtendedKeyUsagePurpose,
    IsCa, Issuer, KeyIdMethod, KeyPair, KeyUsagePurpose, RevokedCertParams, SerialNumber,
};
use shore::clock;
use std::fmt;
use units::UtcTime;

/// How long the authority lasts, days.
const AUTHORITY_DAYS: i64 = 3_650;

/// The number of a certificate, by which it is revoked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Serial(pub(super) [u8; 16]);

impl Serial {
    /// Reads what `Display` wrote.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let mut bytes = [0; 16];
        hex::decode_to_slice(text.trim(), &mut bytes).ok()?;
        Some(Self(bytes))
    }

    fn number(self) -> SerialNumber {
        SerialNumber::from_slice(&self.0)
    }
}

impl fmt::Display for Serial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&hex::encode(self.0))
    }
}

/// A certificate that is good no more.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Revoked {
    pub(super) serial: Serial,
    pub(super) at: UtcTime,
    /// The vessel's name, for people.
    pub(super) name: String,
}

impl Revoked {
    /// Reads what `Display` wrote.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let mut words = text.split_ascii_whitespace();
        let serial = Serial::parse(words.next()?)?;
        let at = UtcTime::from_micros(words.next()?.parse().ok()?);
        Some(Self { serial, at, name: words.next()?.to_owned() })
    }
}

impl fmt::Display for Revoked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {} {}", self.serial, self.at.micros(), self.name)
    }
}

/// The end of the tunnel that a certificate is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Purpose {
    Server,
    Vessel,
}

impl Purpose {
    /// Reads what `Display` wrote.
    pub(super) fn parse(text: &str) -> Option<Self> {
        [Self::Server, Self::Vessel].into_iter().find(|purpose| purpose.to_string() == text)
    }
}

impl fmt::Display for Purpose {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Server => "server",
            Self::Vessel => "vessel",
        })
    }
}

/// A new authority.
pub(super) fn authority(now: UtcTime) -> anyhow::Result<Identity> {
    let key = KeyPair::generate()?;
    let until = UtcTime::from_micros(now.micros() + AUTHORITY_DAYS * DAY_US);
    let certificate = authority_parameters(now, until)?.self_signed(&key)?.pem();
    Ok(Identity { certificate, key: key.serialize_pem() })
}

/// A certificate for a new key.
///
/// # Errors
/// The authority has ended or cannot be read.
pub(super) fn sign(
    authority: &Identity,
    name: &str,
    purpose: Purpose,
    serial: Serial,
    now: UtcTime,
) -> anyhow::Result<Identity> {
    let (issuer, until) = issuer(authority, now)?;
    let key = KeyPair::generate()?;
    let mut parameters = CertificateParams::new(Vec::new())?;
    lasts(&mut parameters, now, until);
    call(&mut parameters, name);
    parameters.serial_number = Some(serial.number());
    parameters.key_usages = vec![KeyUsagePurpose::DigitalSignature];
    parameters.extended_key_usages = vec![match purpose {
        Purpose::Server => ExtendedKeyUsagePurpose::ServerAuth,
        Purpose::Vessel => ExtendedKeyUsagePurpose::ClientAuth,
    }];
    parameters.use_authority_key_identifier_extension = true;
    let certificate = parameters.signed_by(&key, &issuer)?.pem();
    Ok(Identity { certificate, key: key.serialize_pem() })
}

/// The list of revoked certificates in PEM, with the number of its entries as its own.
pub(super) fn list(authority: &Identity, revoked: &[Revoked], now: UtcTime) -> anyhow::Result<String> {
    let (issuer, until) = issuer(authority, now)?;
    let revoked_certs = revoked.iter().map(|one| RevokedCertParams {
        serial_number: one.serial.number(),
        revocation_time: day(one.at, rcgen::date_time_ymd),
        reason_code: None,
        invalidity_date: None,
    });
    let parameters = CertificateRevocationListParams {
        this_update: day(UtcTime::from_micros(now.micros() - DAY_US), rcgen::date_time_ymd),
        next_update: day(until, rcgen::date_time_ymd),
        crl_number: SerialNumber::from(revoked.len() as u64 + 1),
        issuing_distribution_point: None,
        revoked_certs: revoked_certs.collect(),
        key_identifier_method: KeyIdMethod::Sha256,
    };
    Ok(parameters.signed_by(&issuer)?.pem()?)
}

/// The authority as one that signs, and its end.
fn issuer(authority: &Identity, now: UtcTime) -> anyhow::Result<(Issuer<'static, KeyPair>, UtcTime)> {
    let validity =
        authority_validity(&authority.certificate).context("the VPN's authority cannot be read")?;
    ensure!(
        validity.until > now,
        "the VPN's authority ended on {}: remove openvpn.key in the folder of the fleet, apply the fleet file and bring every \
         boat a new bundle",
        clock::written(validity.until)
    );
    let key = KeyPair::from_pem(&authority.key).context("the key of the VPN's authority cannot be read")?;
    Ok((Issuer::new(authority_parameters(now, validity.until)?, key), validity.until))
}

/// The same name for the same key, so that what is signed later belongs to the authority.
fn authority_parameters(now: UtcTime, until: UtcTime) -> anyhow::Result<CertificateParams> {
    let mut parameters = CertificateParams::new(Vec::new())?;
    lasts(&mut parameters, now, until);
    call(&mut parameters, "Lutra VPN authority");
    parameters.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
    parameters.key_usages = vec![KeyUsagePurpose::KeyCertSign, KeyUsagePurpose::CrlSign];
    Ok(parameters)
}

fn call(parameters: &mut CertificateParams, name: &str) {
    parameters.distinguished_name.remove(DnType::CommonName);
    parameters.distinguished_name.push(DnType::CommonName, name);
}
