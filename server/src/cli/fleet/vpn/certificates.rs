//! Certificates of OpenVPN: an authority for the VPN alone, and what it signs.
//!
//! All last as long as the authority: a boat that is at sea when its certificate ends is off the VPN. A certificate that was
//! replaced or taken is refused because OpenVPN lets in only those that have a file in `lutra.ccd`.

use crate::tls::DAY_US;
use crate::tls::authority::lasts;
use anyhow::{Context as _, ensure};
use provision::authority_validity;
use provision::openvpn::Identity;
use rcgen::{
    BasicConstraints, CertificateParams, DnType, ExtendedKeyUsagePurpose, IsCa, Issuer, KeyPair,
    KeyUsagePurpose, SerialNumber,
};
use shore::clock;
use units::UtcTime;

/// How long the authority lasts, days.
const AUTHORITY_DAYS: i64 = 3_650;

/// The number of a certificate.
pub(super) type Serial = [u8; 8];

/// The end of the tunnel that a certificate is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Purpose {
    Server,
    Vessel,
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
    parameters.serial_number = Some(SerialNumber::from_slice(&serial));
    parameters.key_usages = vec![KeyUsagePurpose::DigitalSignature];
    parameters.extended_key_usages = vec![match purpose {
        Purpose::Server => ExtendedKeyUsagePurpose::ServerAuth,
        Purpose::Vessel => ExtendedKeyUsagePurpose::ClientAuth,
    }];
    parameters.use_authority_key_identifier_extension = true;
    let certificate = parameters.signed_by(&key, &issuer)?.pem();
    Ok(Identity { certificate, key: key.serialize_pem() })
}

/// The authority as one that signs, and its end.
fn issuer(authority: &Identity, now: UtcTime) -> anyhow::Result<(Issuer<'static, KeyPair>, UtcTime)> {
    let validity =
        authority_validity(&authority.certificate).context("the VPN's authority cannot be read")?;
    ensure!(
        validity.until > now,
        "the VPN's authority ended on {}: remove openvpn.key in the folder of the fleet, apply the fleet file with --new-server-key and \
         bring every boat a new bundle",
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
    parameters.key_usages = vec![KeyUsagePurpose::KeyCertSign];
    Ok(parameters)
}

fn call(parameters: &mut CertificateParams, name: &str) {
    parameters.distinguished_name.remove(DnType::CommonName);
    parameters.distinguished_name.push(DnType::CommonName, name);
}
