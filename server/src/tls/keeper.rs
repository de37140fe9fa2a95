//! Serves a certificate and reloads it when its files change, without a restart and without cutting a connection.
//!
//! The files are checked every two seconds, and at once on request (SIGHUP). A renewal program writes certificate and key
//! one after the other; so a mismatch is reported only after it has lasted for [`SETTLES`]. Until there is a complete pair
//! that is valid now, the earlier one is served.

use super::pair::Pair;
use crate::config::Tls;
use anyhow::bail;
use operations::alarms::CertificateState;
use rustls::ServerConfig;
use rustls::server::{ClientHello, ResolvesServerCert};
use rustls::sign::CertifiedKey;
use shore::alarms::Alarms;
use shore::clock::{self, Clock};
use std::os::unix::fs::MetadataExt as _;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio_rustls::TlsAcceptor;
use tokio_util::sync::CancellationToken;
use units::{MonoTime, Now};

/// How often the files are checked.
const EVERY: Duration = Duration::from_secs(2);
/// How long the files may mismatch before that is reported.
const SETTLES: Duration = Duration::from_secs(10);

/// Holds the certificate that the server uses.
#[derive(Debug)]
pub(crate) struct Keeper {
    tls: Tls,
    held: Mutex<Held>,
}

/// The pair in use, and the state of the files.
#[derive(Debug)]
struct Held {
    pair: Pair,
    /// Stamps of the files at the last reading.
    seen: [Option<Stamp>; 2],
    /// Since when they cannot be used, and why.
    failing: Option<(MonoTime, String)>,
    /// Whether that was reported.
    told: bool,
}

/// Identifies one version of a file.
type Stamp = (u64, u64, i64, i64, u64);

impl Keeper {
    /// Reads the configured pair.
    ///
    /// # Errors
    /// As [`Pair::read`].
    pub(crate) fn open(tls: &Tls) -> anyhow::Result<Arc<Self>> {
        // Taken before reading: a change meanwhile then causes another reading.
        let seen = stamps(tls);
        let pair = Pair::read(tls)?;
        let held = Held { pair, seen, failing: None, told: false };
        Ok(Arc::new(Self { tls: tls.clone(), held: Mutex::new(held) }))
    }

    /// The TLS acceptor, which uses the current pair for each connection.
    ///
    /// # Errors
    /// Never with the versions of TLS that rustls has.
    pub(crate) fn acceptor(self: &Arc<Self>) -> anyhow::Result<TlsAcceptor> {
        let provider = Arc::new(rustls::crypto::ring::default_provider());
        let mut config = ServerConfig::builder_with_provider(provider)
            .with_safe_default_protocol_versions()?
            .with_no_client_auth()
            .with_cert_resolver(self.clone());
        config.alpn_protocols = vec![b"http/1.1".to_vec()];
        Ok(TlsAcceptor::from(Arc::new(config)))
    }

    /// Checks the files until the server ends, and reports the certificate's state to the alarms.
    pub(crate) async fn keep(self: Arc<Self>, clock: Clock, alarms: Alarms, stop: CancellationToken) {
        let mut every = tokio::time::interval(EVERY);
        while stop.run_until_cancelled(every.tick()).await.is_some() {
            let (keeper, now) = (self.clone(), clock.now());
            // In a blocking thread, so that a disk that hangs delays no other task.
            if tokio::task::spawn_blocking(move || keeper.look(now)).await.is_err() {
                tracing::error!("the files of the certificate could not be looked at");
            }
            alarms.certificate(self.state());
        }
    }

    /// Reads the files again on request, and logs the result.
    pub(crate) fn reload(&self, now: Now) {
        let seen = stamps(&self.tls);
        let read = self.usable(now);
        self.take(now, seen, read, Duration::ZERO);
        let held = self.held();
        if held.failing.is_none() {
            let until = clock::written(held.pair.facts.until);
            tracing::info!(file = %self.tls.certificate.display(), until, "certificate and key were read again");
        }
    }

    /// Takes over what changed.
    fn look(&self, now: Now) {
        let seen = stamps(&self.tls);
        let is_known = {
            let held = self.held();
            held.seen == seen && held.failing.is_none()
        };
        if !is_known {
            let read = self.usable(now);
            self.take(now, seen, read, SETTLES);
        }
    }

    /// The pair in the files, if it is usable now.
    fn usable(&self, now: Now) -> anyhow::Result<Pair> {
        let pair = Pair::read(&self.tls)?;
        let file = self.tls.certificate.display();
        if pair.facts.until <= now.utc {
            bail!(
                "tls.certificate {file} ended on {}: put a renewed one there",
                clock::written(pair.facts.until)
            );
        }
        if pair.facts.from > now.utc {
            let (from, present) = (clock::written(pair.facts.from), clock::written(now.utc));
            bail!("tls.certificate {file} holds from {from} on, and it is {present}: look at the clock");
        }
        Ok(pair)
    }

    fn take(&self, now: Now, seen: [Option<Stamp>; 2], read: anyhow::Result<Pair>, patience: Duration) {
        let mut held = self.held();
        held.seen = seen;
        match read {
            Ok(pair) => {
                (held.failing, held.told) = (None, false);
                if pair.certified.cert != held.pair.certified.cert {
                    let (until, names) = (clock::written(pair.facts.until), pair.facts.names.join(", "));
                    let file = self.tls.certificate.display();
                    tracing::info!(%file, until, names, "a new certificate is used from now on");
                }
                held.pair = pair;
            }
            Err(error) => {
                let why = format!("{error:#}");
                let since = held.failing.as_ref().map_or(now.mono, |(since, _)| *since);
                if !held.told && now.mono.since(since) >= patience {
                    held.told = true;
                    let until = clock::written(held.pair.facts.until);
                    tracing::warn!(
                        until,
                        "a new certificate cannot be used, the earlier one still is: {why}"
                    );
                }
                held.failing = Some((since, why));
            }
        }
    }

    /// State of the certificate, for the alarms.
    pub(crate) fn state(&self) -> CertificateState {
        let held = self.held();
        CertificateState {
            file: self.tls.certificate.display().to_string(),
            until: held.pair.facts.until,
            refused: held.failing.as_ref().filter(|_| held.told).map(|(_, why)| why.clone()),
        }
    }

    fn held(&self) -> MutexGuard<'_, Held> {
        // Changes under this lock are atomic.
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl ResolvesServerCert for Keeper {
    fn resolve(&self, _: ClientHello<'_>) -> Option<Arc<CertifiedKey>> {
        Some(self.held().pair.certified.clone())
    }
}

fn stamps(tls: &Tls) -> [Option<Stamp>; 2] {
    let stamp = |path: &Path| {
        let about = std::fs::metadata(path).ok()?;
        Some((about.dev(), about.ino(), about.mtime(), about.mtime_nsec(), about.len()))
    };
    [stamp(&tls.certificate), stamp(&tls.key)]
}

#[cfg(test)]
mod tests {
    use super::super::authority;
    use super::*;
    use std::fs;
    use units::UtcTime;

    fn at(s: u64) -> Now {
        let utc = UtcTime::from_micros(clock::now().micros() + s as i64 * 1_000_000);
        Now { mono: MonoTime::from_micros(s * 1_000_000), utc }
    }

    #[test]
    fn a_whole_new_pair_is_taken_over_and_half_a_one_is_told_after_a_while() {
        let folder = tempfile::tempdir().unwrap();
        let names = ["localhost".to_owned()];
        let made = authority::make(folder.path(), &names, false, clock::now()).unwrap();
        let tls = Tls { certificate: made.certificate, key: made.key };
        let keeper = Keeper::open(&tls).unwrap();
        let served = || keeper.held().pair.certified.cert.clone();
        let first = served();
        // The next key is written first, its certificate some seconds later.
        let old_key = fs::read(&tls.key).unwrap();
        authority::make(folder.path(), &names, true, clock::now()).unwrap();
        let (next, next_key) = (fs::read(&tls.certificate).unwrap(), fs::read(&tls.key).unwrap());
        fs::write(&tls.certificate, rustls_pem(&first[0])).unwrap();
        keeper.look(at(0));
        keeper.look(at(9));
        assert_eq!((served(), keeper.state().refused), (first.clone(), None), "it may be under way");
        fs::write(&tls.certificate, &next).unwrap();
        keeper.look(at(10));
        assert_ne!(served(), first);
        assert_eq!(keeper.held().failing, None);
        // A lasting mismatch is reported, with file and remedy, and cleared once fixed.
        let second = served();
        fs::write(&tls.key, old_key).unwrap();
        keeper.look(at(20));
        keeper.look(at(30));
        let why = keeper.state().refused.unwrap();
        assert!(why.contains("server-key.pem do not belong together: put both"), "{why}");
        assert_eq!(served(), second);
        fs::write(&tls.key, next_key).unwrap();
        keeper.look(at(31));
        assert_eq!(keeper.state().refused, None);
        // A request is answered at once.
        fs::remove_file(&tls.certificate).unwrap();
        keeper.reload(at(32));
        assert!(keeper.state().refused.unwrap().contains("server.pem"));
        assert_eq!(served(), second);
    }

    #[test]
    fn what_has_ended_or_has_not_begun_replaces_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let names = ["localhost".to_owned()];
        let made = authority::make(folder.path(), &names, false, clock::now()).unwrap();
        let keeper = Keeper::open(&Tls { certificate: made.certificate, key: made.key }).unwrap();
        authority::make(folder.path(), &names, true, clock::now()).unwrap();
        let first = keeper.held().pair.certified.cert.clone();
        for (days, told) in [(2_000_i64, "ended on"), (-400, "look at the clock")] {
            let utc = UtcTime::from_micros(clock::now().micros() + days * super::super::DAY_US);
            keeper.reload(Now { mono: MonoTime::from_micros(1), utc });
            assert!(keeper.state().refused.unwrap().contains(told), "{told}");
            assert_eq!(keeper.held().pair.certified.cert, first);
        }
    }

    fn rustls_pem(der: &[u8]) -> String {
        use base64ct::{Base64, Encoding as _};
        format!("-----BEGIN CERTIFICATE-----\n{}\n-----END CERTIFICATE-----\n", Base64::encode_string(der))
    }
}
