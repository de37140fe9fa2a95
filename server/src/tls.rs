//! Encryption: serving with a certificate, and a small authority of one's own that makes one.
//!
//! A browser or vessel that trusts the authority's `ca.pem` once accepts every certificate made with it.

use crate::config::Tls;
use anyhow::{Context as _, bail, ensure};
use rcgen::{
    BasicConstraints, CertificateParams, DnType, ExtendedKeyUsagePurpose, IsCa, Issuer, KeyPair,
    KeyUsagePurpose,
};
use rustls::ServerConfig;
use rustls::pki_types::pem::PemObject as _;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use shore::clock;
use std::fs;
use std::io::Write as _;
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tokio_rustls::TlsAcceptor;
use units::UtcTime;

/// How long the authority lasts, days.
const AUTHORITY_DAYS: i64 = 3_650;
/// How long a server's certificate lasts, days; browsers accept at most 825.
const SERVER_DAYS: i64 = 820;
const DAY_US: i64 = 86_400_000_000;

/// Reads certificate and key as configured.
///
/// # Errors
/// A file cannot be read or used; the error names it.
pub(crate) fn acceptor(tls: &Tls) -> anyhow::Result<TlsAcceptor> {
    let remedy = "; `lutra-server tls init` makes certificate and key";
    let wrong = |key: &str, path: &Path| format!("tls.{key} {}{remedy}", path.display());
    let chain: Vec<CertificateDer<'static>> = CertificateDer::pem_file_iter(&tls.certificate)
        .and_then(Iterator::collect)
        .with_context(|| wrong("certificate", &tls.certificate))?;
    ensure!(!chain.is_empty(), "{} holds no certificate in PEM", wrong("certificate", &tls.certificate));
    let key = PrivateKeyDer::from_pem_file(&tls.key).with_context(|| wrong("key", &tls.key))?;
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let mut config = ServerConfig::builder_with_provider(provider)
        .with_safe_default_protocol_versions()?
        .with_no_client_auth()
        .with_single_cert(chain, key)
        .context("tls.certificate and tls.key do not belong together")?;
    config.alpn_protocols = vec![b"http/1.1".to_vec()];
    Ok(TlsAcceptor::from(Arc::new(config)))
}

/// What `lutra-server tls init` made.
pub(crate) struct Made {
    /// For browsers and vessels to trust.
    pub(crate) authority: PathBuf,
    pub(crate) certificate: PathBuf,
    pub(crate) key: PathBuf,
    pub(crate) until: UtcTime,
}

/// Makes a certificate for `names` in `folder`, with the authority that is there or a new one.
///
/// # Errors
/// There is a certificate and `renew` is not asked for; a name is not valid; a file cannot be written.
pub(crate) fn make(folder: &Path, names: &[String], renew: bool) -> anyhow::Result<Made> {
    let file = |name: &str| folder.join(name);
    let (authority, authority_key) = (file("ca.pem"), file("ca-key.pem"));
    let (certificate, key) = (file("server.pem"), file("server-key.pem"));
    if certificate.exists() && !renew {
        bail!("{} exists: --renew replaces it, with the same authority", certificate.display());
    }
    fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let now = clock::now();
    let issuer_key = if authority_key.exists() {
        let text = fs::read_to_string(&authority_key)
            .with_context(|| format!("cannot read {}", authority_key.display()))?;
        KeyPair::from_pem(&text).with_context(|| format!("{} is no key", authority_key.display()))?
    } else {
        let made = KeyPair::generate()?;
        let text = authority_parameters(now)?.self_signed(&made)?.pem();
        write(&authority_key, &made.serialize_pem(), 0o600)?;
        write(&authority, &text, 0o644)?;
        made
    };
    let issuer = Issuer::new(authority_parameters(now)?, issuer_key);
    let mut parameters = CertificateParams::new(names)
        .with_context(|| format!("{} cannot be in a certificate", names.join(", ")))?;
    let until = UtcTime::from_micros(now.micros() + SERVER_DAYS * DAY_US);
    lasts(&mut parameters, now, until);
    parameters.distinguished_name.remove(DnType::CommonName);
    parameters.distinguished_name.push(DnType::CommonName, names.first().map_or("lutra", String::as_str));
    parameters.key_usages = vec![KeyUsagePurpose::DigitalSignature];
    parameters.extended_key_usages = vec![ExtendedKeyUsagePurpose::ServerAuth];
    parameters.use_authority_key_identifier_extension = true;
    let own = KeyPair::generate()?;
    let signed = parameters.signed_by(&own, &issuer)?;
    write(&key, &own.serialize_pem(), 0o600)?;
    write(&certificate, &signed.pem(), 0o644)?;
    Ok(Made { authority, certificate, key, until })
}

/// The same for the same key, so that what it signed later still leads to it.
fn authority_parameters(now: UtcTime) -> anyhow::Result<CertificateParams> {
    let mut parameters = CertificateParams::new(Vec::new())?;
    lasts(&mut parameters, now, UtcTime::from_micros(now.micros() + AUTHORITY_DAYS * DAY_US));
    parameters.distinguished_name.remove(DnType::CommonName);
    parameters.distinguished_name.push(DnType::CommonName, "Lutra shore authority");
    parameters.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
    parameters.key_usages = vec![KeyUsagePurpose::KeyCertSign, KeyUsagePurpose::CrlSign];
    Ok(parameters)
}

/// From yesterday, as clocks differ, until the day of `until`.
fn lasts(parameters: &mut CertificateParams, now: UtcTime, until: UtcTime) {
    let day = |time: UtcTime| {
        let civil = time.civil();
        rcgen::date_time_ymd(civil.year as i32, civil.month, civil.day)
    };
    parameters.not_before = day(UtcTime::from_micros(now.micros() - DAY_US));
    parameters.not_after = day(until);
}

/// Writes a file whole or not at all.
fn write(path: &Path, text: &str, mode: u32) -> anyhow::Result<()> {
    let partial = path.with_extension("new");
    let written = || -> std::io::Result<()> {
        fs::remove_file(&partial).or_else(|error| match error.kind() {
            std::io::ErrorKind::NotFound => Ok(()),
            _ => Err(error),
        })?;
        let mut file = fs::OpenOptions::new().write(true).create_new(true).mode(mode).open(&partial)?;
        file.write_all(text.as_bytes())?;
        file.sync_all()?;
        fs::rename(&partial, path)
    };
    written().with_context(|| format!("cannot write {}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(names: &[&str]) -> Vec<String> {
        names.iter().map(|name| (*name).to_owned()).collect()
    }

    #[test]
    fn what_is_made_can_be_served_with_and_secrets_are_kept() {
        use std::os::unix::fs::PermissionsExt as _;
        let folder = tempfile::tempdir().unwrap();
        let made = make(folder.path(), &names(&["localhost", "127.0.0.1"]), false).unwrap();
        acceptor(&Tls { certificate: made.certificate.clone(), key: made.key.clone() }).unwrap();
        for secret in ["ca-key.pem", "server-key.pem"] {
            let mode = fs::metadata(folder.path().join(secret)).unwrap().permissions().mode();
            assert_eq!(mode & 0o077, 0, "{secret}");
        }
        let refused = make(folder.path(), &names(&["localhost"]), false).err().unwrap();
        assert!(refused.to_string().contains("--renew"), "{refused}");
        let authority = fs::read(&made.authority).unwrap();
        make(folder.path(), &names(&["localhost"]), true).unwrap();
        assert_eq!(fs::read(&made.authority).unwrap(), authority, "the authority stays");
    }

    #[test]
    fn what_cannot_be_used_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let (certificate, key) = (folder.path().join("a.pem"), folder.path().join("b.pem"));
        let told = |tls: &Tls| format!("{:#}", acceptor(tls).err().unwrap());
        let tls = Tls { certificate, key };
        assert!(told(&tls).contains("a.pem"));
        fs::write(&tls.certificate, "no certificate").unwrap();
        assert!(told(&tls).contains("holds no certificate"));
        let made = make(folder.path(), &names(&["localhost"]), false).unwrap();
        let other = Tls { certificate: made.certificate, key: folder.path().join("ca-key.pem") };
        assert!(told(&other).contains("do not belong together"));
    }
}
