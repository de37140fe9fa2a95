//! Encryption towards other servers: which authorities are trusted.

use anyhow::{Context as _, ensure};
use rustls::pki_types::CertificateDer;
use rustls::pki_types::pem::PemObject as _;
use rustls::{ClientConfig, RootCertStore};
use std::path::Path;
use std::sync::Arc;
use tokio_rustls::TlsConnector;

/// A connector that trusts the authorities of a PEM file; `key` is the setting that names it.
///
/// # Errors
/// The file cannot be read, holds no certificate, or none that can be used. An unusable certificate among usable ones is
/// skipped: system bundles contain such.
pub(crate) fn trusting(key: &str, file: &Path) -> anyhow::Result<TlsConnector> {
    let wrong = || format!("{key} {}", file.display());
    let mut roots = RootCertStore::empty();
    let mut refused = None;
    for certificate in CertificateDer::pem_file_iter(file).with_context(wrong)? {
        if let Err(error) = roots.add(certificate.with_context(wrong)?) {
            refused = Some(error);
        }
    }
    if let Some(error) = refused.filter(|_| roots.is_empty()) {
        return Err(error).with_context(wrong);
    }
    ensure!(!roots.is_empty(), "{} holds no certificate in PEM", wrong());
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let config = ClientConfig::builder_with_provider(provider)
        .with_safe_default_protocol_versions()?
        .with_root_certificates(roots)
        .with_no_client_auth();
    Ok(TlsConnector::from(Arc::new(config)))
}
