//! A certificate with its key, as read from the files that the configuration names.

use super::x509::Facts;
use crate::config::Tls;
use anyhow::{Context as _, ensure};
use rustls::crypto::ring;
use rustls::pki_types::pem::PemObject as _;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use rustls::sign::CertifiedKey;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A certificate and the key that belongs to it.
#[derive(Debug, Clone)]
pub(crate) struct Pair {
    pub(crate) certified: Arc<CertifiedKey>,
    pub(crate) facts: Facts,
}

impl Pair {
    /// Reads certificate and key as configured. If a change of both was interrupted, the new certificate beside the earlier
    /// one ([`waiting`]) is read instead.
    ///
    /// # Errors
    /// A file cannot be read or used, or they do not belong together; the error names file and remedy.
    pub(crate) fn read(tls: &Tls) -> anyhow::Result<Self> {
        Self::of_files(tls).or_else(|error| {
            let waits = Tls { certificate: waiting(&tls.certificate), key: tls.key.clone() };
            Self::of_files(&waits).map_err(|_| error)
        })
    }

    fn of_files(tls: &Tls) -> anyhow::Result<Self> {
        let remedy = "; `lutra-server tls init` makes certificate and key";
        let wrong = |key: &str, path: &Path| format!("tls.{key} {}{remedy}", path.display());
        let chain: Vec<CertificateDer<'static>> = CertificateDer::pem_file_iter(&tls.certificate)
            .and_then(Iterator::collect)
            .with_context(|| wrong("certificate", &tls.certificate))?;
        let first = chain.first();
        ensure!(first.is_some(), "{} holds no certificate in PEM", wrong("certificate", &tls.certificate));
        let facts = first.and_then(|first| Facts::of(first));
        let facts = facts.with_context(|| {
            format!("{} is not a certificate of X.509", wrong("certificate", &tls.certificate))
        })?;
        let key = PrivateKeyDer::from_pem_file(&tls.key).with_context(|| wrong("key", &tls.key))?;
        let certified = CertifiedKey::from_der(chain, key, &ring::default_provider()).with_context(|| {
            let (certificate, key) = (tls.certificate.display(), tls.key.display());
            format!(
                "tls.certificate {certificate} and tls.key {key} do not belong together: put both of one certificate there"
            )
        })?;
        Ok(Self { certified: Arc::new(certified), facts })
    }
}

/// Path of a new certificate while its key is moved into place: two files cannot be changed atomically.
pub(super) fn waiting(certificate: &Path) -> PathBuf {
    let mut name = certificate.to_owned().into_os_string();
    name.push(".next");
    PathBuf::from(name)
}

/// Whether a change was interrupted between key and certificate.
pub(super) fn is_unfinished(tls: &Tls) -> bool {
    let waits = waiting(&tls.certificate);
    let next = Tls { certificate: waits.clone(), key: tls.key.clone() };
    waits.exists() && Pair::of_files(tls).is_err() && Pair::of_files(&next).is_ok()
}

/// Moves a certificate into place that was left by an interrupted change, if it matches the key.
///
/// # Errors
/// It cannot be moved.
pub(super) fn finish(tls: &Tls) -> anyhow::Result<()> {
    if !is_unfinished(tls) {
        return Ok(());
    }
    let waits = waiting(&tls.certificate);
    let moved = || -> std::io::Result<()> {
        std::fs::rename(&waits, &tls.certificate)?;
        tls.certificate.parent().map_or(Ok(()), |folder| std::fs::File::open(folder)?.sync_all())
    };
    moved().with_context(|| format!("cannot move {} to {}", waits.display(), tls.certificate.display()))
}

#[cfg(test)]
mod tests {
    use super::super::authority;
    use super::*;

    #[test]
    fn what_cannot_be_used_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let (certificate, key) = (folder.path().join("a.pem"), folder.path().join("b.pem"));
        let told = |tls: &Tls| format!("{:#}", Pair::read(tls).err().unwrap());
        let tls = Tls { certificate, key };
        assert!(told(&tls).contains("a.pem"));
        std::fs::write(&tls.certificate, "no certificate").unwrap();
        assert!(told(&tls).contains("holds no certificate"));
        std::fs::write(&tls.certificate, "-----BEGIN CERTIFICATE-----\nYWJj\n-----END CERTIFICATE-----\n")
            .unwrap();
        assert!(told(&tls).contains("is not a certificate of X.509"));
        let made =
            authority::make(folder.path(), &["localhost".to_owned()], false, shore::clock::now()).unwrap();
        let other = Tls { certificate: made.certificate, key: folder.path().join("ca-key.pem") };
        assert!(told(&other).contains("do not belong together"));
    }
}
