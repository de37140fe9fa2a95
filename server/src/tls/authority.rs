//! A small private certificate authority: makes and renews the server's certificate.
//!
//! A renewed certificate keeps its key, so that one file changes, atomically. If the key changes too, the new certificate
//! is stored beside the old one until the key is in place: a kill at any moment leaves a matching pair, which [`Pair`]
//! finds and the next command moves into place. Vessels and browsers trust `ca.pem`, which stays.

use super::x509::{Facts, first_in};
use super::{DAY_US, day, days_left, pair};
use crate::config::Tls;
use anyhow::{Context as _, bail, ensure};
use rcgen::{
    BasicConstraints, CertificateParams, DnType, ExtendedKeyUsagePurpose, IsCa, Issuer, KeyPair,
    KeyUsagePurpose,
};
use rustls::RootCertStore;
use rustls::client::WebPkiServerVerifier;
use rustls::client::danger::ServerCertVerifier as _;
use rustls::pki_types::{CertificateDer, ServerName, UnixTime};
use shore::clock;
use std::fs;
use std::io::Write as _;
use std::net::IpAddr;
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;
use units::UtcTime;

/// How long the authority lasts, days.
const AUTHORITY_DAYS: i64 = 3_650;
/// How long a server's certificate lasts, days; browsers accept at most 825.
const SERVER_DAYS: i64 = 820;

/// Held while certificates are made. Backups omit files with this extension.
const LOCK: &str = "making.lock";

/// Result of `lutra-server tls init`.
pub(crate) struct Made {
    /// The authority's certificate, which browsers and vessels must trust.
    pub(crate) authority: PathBuf,
    pub(crate) certificate: PathBuf,
    pub(crate) key: PathBuf,
    pub(crate) until: UtcTime,
}

/// Makes a certificate for `names` in `folder`, with the existing authority or a new one.
///
/// # Errors
/// The clock cannot be right; there is a certificate and `renew` is not asked for; a name is not valid; a file cannot be written.
pub(crate) fn make(folder: &Path, names: &[String], renew: bool, now: UtcTime) -> anyhow::Result<Made> {
    refuse_clock(now)?;
    let file = |name: &str| folder.join(name);
    let (authority, authority_key) = (file("ca.pem"), file("ca-key.pem"));
    let (certificate, key) = (file("server.pem"), file("server-key.pem"));
    refuse_replacing(&certificate, renew)?;
    fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let _lock = lock(folder)?;
    // Checked again under the lock.
    refuse_replacing(&certificate, renew)?;
    let tls = Tls { certificate, key };
    pair::finish(&tls)?;
    let issuer_key = authority_in(&authority, &authority_key, now)?;
    let own = KeyPair::generate()?;
    let signed = sign(&authority, issuer_key, &own, names, now)?;
    let waits = pair::waiting(&tls.certificate);
    write(&waits, &signed.pem, 0o644)?;
    write(&tls.key, &own.serialize_pem(), 0o600)?;
    pair::finish(&tls)?;
    let Tls { certificate, key } = tls;
    Ok(Made { authority, certificate, key, until: signed.until })
}

fn refuse_replacing(certificate: &Path, renew: bool) -> anyhow::Result<()> {
    ensure!(
        renew || !certificate.exists(),
        "{} exists: --renew replaces it, with the same authority",
        certificate.display()
    );
    Ok(())
}

/// Locks the folder of the authority until the file is dropped, so that two commands do not write certificates and keys
/// there at once. The file has the process that holds it.
fn lock(folder: &Path) -> anyhow::Result<fs::File> {
    let path = folder.join(LOCK);
    let named = || format!("cannot write {}", path.display());
    let mut options = fs::OpenOptions::new();
    options.create(true).truncate(false).write(true).mode(0o600);
    let mut file = options.open(&path).with_context(named)?;
    if file.try_lock().is_err() {
        let holder = fs::read_to_string(&path).unwrap_or_default();
        let holder = holder.trim();
        let holder = if holder.is_empty() { String::new() } else { format!(" (process {holder})") };
        bail!(
            "another `lutra-server tls`{holder} is making certificates in {}: wait until it is done, then look whether this is \
             still to be done",
            folder.display()
        );
    }
    file.set_len(0).and_then(|()| writeln!(file, "{}", std::process::id())).with_context(named)?;
    Ok(file)
}

/// A certificate made with a wrong clock is refused by all clients once the clock is right, or begins years later.
fn refuse_clock(now: UtcTime) -> anyhow::Result<()> {
    clock::check(now).map_err(|why| anyhow::anyhow!("no certificate is made: {why}, then do this again"))
}

/// The key of the authority, which is made if there is none. If its certificate is missing, as after a kill between the two
/// files, another is made: clients that trust the earlier one accept what the same key signs.
fn authority_in(authority: &Path, authority_key: &Path, now: UtcTime) -> anyhow::Result<KeyPair> {
    ensure!(
        authority_key.exists() || !authority.exists(),
        "{} is there without its key {}, and boats may trust it: bring the key back, or move {} away to begin with a new \
         authority, which boats and browsers must then be given",
        authority.display(),
        authority_key.display(),
        authority.display()
    );
    let key = if authority_key.exists() {
        read_key(authority_key)?
    } else {
        let made = KeyPair::generate()?;
        write(authority_key, &made.serialize_pem(), 0o600)?;
        made
    };
    if !authority.exists() {
        write(authority, &authority_parameters(now)?.self_signed(&key)?.pem(), 0o644)?;
    }
    Ok(key)
}

fn read_key(path: &Path) -> anyhow::Result<KeyPair> {
    let text = fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    KeyPair::from_pem(&text).with_context(|| format!("{} is not a key", path.display()))
}

/// Result of `lutra-server tls renew`.
#[derive(Debug)]
pub(crate) enum Renewal {
    /// The certificate was renewed.
    Renewed {
        /// For these names and addresses.
        names: Vec<String>,
        /// Until then.
        until: UtcTime,
    },
    /// It lasts long enough.
    NotDue {
        /// Until then.
        until: UtcTime,
    },
}

/// Whether [`renew`] has something to do: the authority in `folder` made the certificate, it ends within so many days, and
/// the authority's key is there. Certificates of other authorities are not renewed here.
///
/// # Errors
/// The clock cannot be right, or a file cannot be read.
pub(crate) fn is_due(folder: &Path, tls: &Tls, within_days: u32, now: UtcTime) -> anyhow::Result<bool> {
    refuse_clock(now)?;
    let authority = folder.join("ca.pem");
    if !tls.certificate.exists() || !authority.exists() || !folder.join("ca-key.pem").exists() {
        return Ok(false);
    }
    let (der, facts) = first_in(&tls.certificate)?;
    let (trusted, _) = first_in(&authority)?;
    let is_ours = made_by(&trusted, &der, &facts).is_ok();
    Ok(is_ours && (is_out(&facts, within_days, now) || pair::is_unfinished(tls)))
}

/// Whether a certificate ends within so many days, or is not valid yet: then it was made while the clock was ahead, and browsers
/// and boats refuse it.
fn is_out(facts: &Facts, within_days: u32, now: UtcTime) -> bool {
    days_left(facts.until, now) < i64::from(within_days) || facts.from > now
}

/// Renews the certificate of `tls` with its key and the authority in `folder` that made it; for its own names, unless
/// others are given, and only if it ends within the given number of days, if any.
///
/// # Errors
/// The certificate is of another authority, or the authority's key is not here; a file cannot be read or written.
pub(crate) fn renew(
    folder: &Path,
    tls: &Tls,
    names: Vec<String>,
    within_days: Option<u32>,
    now: UtcTime,
) -> anyhow::Result<Renewal> {
    let file = tls.certificate.display();
    refuse_clock(now)?;
    // Without a folder there is no authority, which is reported below.
    let _lock = folder.is_dir().then(|| lock(folder)).transpose()?;
    pair::finish(tls)?;
    let (der, facts) = first_in(&tls.certificate).context("`lutra-server tls init` makes a certificate")?;
    if within_days.is_some_and(|days| !is_out(&facts, days, now)) {
        return Ok(Renewal::NotDue { until: facts.until });
    }
    let (authority, authority_key) = (folder.join("ca.pem"), folder.join("ca-key.pem"));
    ensure!(
        authority_key.exists(),
        "{file} cannot be renewed here: the authority's key {} is not there. Renew it where it was made; the server takes \
         the new file by itself",
        authority_key.display()
    );
    let (trusted, _) = first_in(&authority)
        .context("`lutra-server tls init --renew` makes the authority's certificate again, of its key")?;
    if let Err(why) = made_by(&trusted, &der, &facts) {
        bail!(
            "{file} was not made by {} ({why}): renew it where it was made; the server takes the new file by itself",
            authority.display()
        );
    }
    let (issuer_key, own) = (read_key(&authority_key)?, read_key(&tls.key)?);
    let names = if names.is_empty() { facts.names } else { names };
    let signed = sign(&authority, issuer_key, &own, &names, now)?;
    write(&tls.certificate, &signed.pem, 0o644)?;
    Ok(Renewal::Renewed { names, until: signed.until })
}

/// Whether a certificate was made by an authority, by the time at which it began.
fn made_by(authority: &CertificateDer<'_>, der: &CertificateDer<'_>, facts: &Facts) -> anyhow::Result<()> {
    let mut roots = RootCertStore::empty();
    roots.add(authority.clone().into_owned())?;
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let verifier = WebPkiServerVerifier::builder_with_provider(Arc::new(roots), provider).build()?;
    let name = facts.names.first().context("it names nothing")?;
    let began = Duration::from_micros(u64::try_from(facts.from.micros())?);
    let name = ServerName::try_from(name.as_str())?;
    verifier.verify_server_cert(der, &[], &name, &[], UnixTime::since_unix_epoch(began))?;
    Ok(())
}

/// A certificate that an authority made.
struct Signed {
    pem: String,
    until: UtcTime,
}

fn sign(
    authority: &Path,
    issuer_key: KeyPair,
    own: &KeyPair,
    names: &[String],
    now: UtcTime,
) -> anyhow::Result<Signed> {
    let (_, facts) = first_in(authority)?;
    ensure!(
        days_left(facts.until, now) > 0,
        "the authority {} ended on {}: move the folder {} away, run `lutra-server tls init`, and bring the new ca.pem to \
         all boats and browsers (`lutra-server fleet bundle`)",
        authority.display(),
        clock::written(facts.until),
        authority.parent().unwrap_or(authority).display()
    );
    let issuer = Issuer::new(authority_parameters(now)?, issuer_key);
    if let Some(wrong) = names.iter().find(|name| !is_host(name)) {
        bail!(
            "--name `{wrong}` is neither a host name nor an IP address; write it like shore.example.org or 10.8.0.1"
        );
    }
    let mut parameters = CertificateParams::new(names)
        .with_context(|| format!("{} cannot be in a certificate", names.join(", ")))?;
    // A certificate must not outlast its authority.
    let until = UtcTime::from_micros(now.micros() + SERVER_DAYS * DAY_US).min(facts.until);
    lasts(&mut parameters, now, until);
    parameters.distinguished_name.remove(DnType::CommonName);
    parameters.distinguished_name.push(DnType::CommonName, names.first().map_or("lutra", String::as_str));
    parameters.key_usages = vec![KeyUsagePurpose::DigitalSignature];
    parameters.extended_key_usages = vec![ExtendedKeyUsagePurpose::ServerAuth];
    parameters.use_authority_key_identifier_extension = true;
    let signed = parameters.signed_by(own, &issuer)?;
    // Certificates end at midnight: read the actual end from it.
    let made = Facts::of(signed.der()).context("the certificate that was made cannot be read")?;
    Ok(Signed { pem: signed.pem(), until: made.until })
}

/// Whether a text can be the name of a computer (RFC 1123; a first label `*` stands for any) or is an address.
fn is_host(name: &str) -> bool {
    let is_label = |label: &str| {
        (1..=63).contains(&label.len())
            && label.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'-')
            && !label.starts_with('-')
            && !label.ends_with('-')
    };
    // What ends in a number is an address, or nothing.
    let is_number = |label: &str| label.bytes().all(|byte| byte.is_ascii_digit());
    if name.parse::<IpAddr>().is_ok() {
        return true;
    }
    let labels = name.strip_prefix("*.").unwrap_or(name);
    name.len() <= 253 && labels.split('.').all(is_label) && !labels.rsplit('.').next().is_some_and(is_number)
}

/// The same parameters for the same key, so that certificates signed later still chain to it.
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
pub(crate) fn lasts(parameters: &mut CertificateParams, now: UtcTime, until: UtcTime) {
    parameters.not_before = day(UtcTime::from_micros(now.micros() - DAY_US), rcgen::date_time_ymd);
    parameters.not_after = day(until, rcgen::date_time_ymd);
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
        fs::rename(&partial, path)?;
        path.parent().map_or(Ok(()), |folder| fs::File::open(folder)?.sync_all())
    };
    written().with_context(|| format!("cannot write {}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::super::Pair;
    use super::*;

    fn names(names: &[&str]) -> Vec<String> {
        names.iter().map(|name| (*name).to_owned()).collect()
    }

    #[test]
    fn a_certificate_is_for_names_and_addresses_alone() {
        for name in ["shore", "shore.example.org", "*.example.org", "10.8.0.1", "fd00::1", "a-1.b2"] {
            assert!(is_host(name), "{name}");
        }
        for name in ["", "bad name", "10.8.0.999", "bad_name", "a..b", "-a", "a-", "a.*", &"x".repeat(64)] {
            assert!(!is_host(name), "{name}");
        }
    }

    fn configured(made: &Made) -> Tls {
        Tls { certificate: made.certificate.clone(), key: made.key.clone() }
    }

    #[test]
    fn what_is_made_can_be_served_with_and_secrets_are_kept() {
        use std::os::unix::fs::PermissionsExt as _;
        let folder = tempfile::tempdir().unwrap();
        let made = make(folder.path(), &names(&["localhost", "127.0.0.1"]), false, clock::now()).unwrap();
        Pair::read(&configured(&made)).unwrap();
        for secret in ["ca-key.pem", "server-key.pem"] {
            let mode = fs::metadata(folder.path().join(secret)).unwrap().permissions().mode();
            assert_eq!(mode & 0o077, 0, "{secret}");
        }
        let refused = make(folder.path(), &names(&["localhost"]), false, clock::now()).err().unwrap();
        assert!(refused.to_string().contains("--renew"), "{refused}");
        let authority = fs::read(&made.authority).unwrap();
        make(folder.path(), &names(&["localhost"]), true, clock::now()).unwrap();
        assert_eq!(fs::read(&made.authority).unwrap(), authority, "the authority stays");
    }

    #[test]
    fn a_renewed_certificate_keeps_key_and_names_and_a_foreign_one_is_not_renewed() {
        let (folder, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let given = names(&["boats.example.no", "10.8.0.1"]);
        let made = make(folder.path(), &given, false, clock::now()).unwrap();
        let tls = configured(&made);
        let read = || (fs::read(&tls.certificate).unwrap(), fs::read(&tls.key).unwrap());
        let before = read();
        let not_due = renew(folder.path(), &tls, Vec::new(), Some(60), clock::now()).unwrap();
        assert!(matches!(not_due, Renewal::NotDue { .. }) && read() == before);
        let Renewal::Renewed { names, until } =
            renew(folder.path(), &tls, Vec::new(), Some(900), clock::now()).unwrap()
        else {
            panic!("it ends within 900 days");
        };
        assert_eq!(names, given);
        let after = read();
        assert!(after.0 != before.0 && after.1 == before.1);
        let (trusted, _) = first_in(&made.authority).unwrap();
        let (der, facts) = first_in(&tls.certificate).unwrap();
        made_by(&trusted, &der, &facts).unwrap();
        assert_eq!((facts.until, made.until), (until, until), "the end that is told is that of the file");
        Pair::read(&tls).unwrap();

        let due = |tls: &Tls, days| is_due(folder.path(), tls, days, clock::now()).unwrap();
        assert!(due(&tls, 900) && !due(&tls, 60));
        let foreign = configured(&make(other.path(), &given, false, clock::now()).unwrap());
        let kept = fs::read(&foreign.certificate).unwrap();
        let not_due = renew(folder.path(), &foreign, Vec::new(), Some(30), clock::now()).unwrap();
        assert!(
            !due(&foreign, 900) && matches!(not_due, Renewal::NotDue { .. }),
            "a timer has nothing to say of it yet"
        );
        let why = renew(folder.path(), &foreign, Vec::new(), None, clock::now()).unwrap_err().to_string();
        assert!(why.contains("was not made by") && why.contains("renew it where it was made"), "{why}");
        fs::remove_file(folder.path().join("ca-key.pem")).unwrap();
        let why = renew(folder.path(), &tls, Vec::new(), None, clock::now()).unwrap_err().to_string();
        assert!(why.contains("ca-key.pem is not there") && !due(&tls, 900), "{why}");
        assert_eq!(fs::read(&foreign.certificate).unwrap(), kept);
    }

    #[test]
    fn an_init_that_was_killed_between_two_files_is_finished_by_the_next() {
        let folder = tempfile::tempdir().unwrap();
        let (at, given) = (|name: &str| folder.path().join(name), names(&["localhost"]));
        make(folder.path(), &given, false, clock::now()).unwrap();
        let key = fs::read(at("ca-key.pem")).unwrap();
        let (trusted, _) = first_in(&at("ca.pem")).unwrap();
        for missing in [
            &["ca.pem", "server-key.pem", "server.pem"] as &[&str],
            &["server-key.pem", "server.pem"],
            &["server.pem"],
        ] {
            for file in missing {
                fs::remove_file(at(file)).unwrap();
            }
            let made = make(folder.path(), &given, false, clock::now()).unwrap();
            Pair::read(&configured(&made)).unwrap();
            assert_eq!(fs::read(at("ca-key.pem")).unwrap(), key, "{missing:?}");
            // Clients that trust the earlier certificate accept it, too.
            for authority in [&trusted, &first_in(&made.authority).unwrap().0] {
                let (der, facts) = first_in(&made.certificate).unwrap();
                made_by(authority, &der, &facts).unwrap();
            }
        }
        fs::remove_file(at("ca.pem")).unwrap();
        let tls = Tls { certificate: at("server.pem"), key: at("server-key.pem") };
        let why = format!("{:#}", renew(folder.path(), &tls, Vec::new(), None, clock::now()).unwrap_err());
        assert!(why.contains("tls init --renew") && why.contains("ca.pem"), "{why}");
        make(folder.path(), &given, true, clock::now()).unwrap();
        renew(folder.path(), &tls, Vec::new(), None, clock::now()).unwrap();
        // The key of an authority that boats trust is not silently replaced.
        fs::remove_file(at("ca-key.pem")).unwrap();
        let authority = fs::read(at("ca.pem")).unwrap();
        let why = make(folder.path(), &given, true, clock::now()).err().unwrap().to_string();
        assert!(why.contains("without its key") && why.contains("bring the key back"), "{why}");
        assert!(fs::read(at("ca.pem")).unwrap() == authority && !at("ca-key.pem").exists());
    }

    #[test]
    fn a_certificate_of_a_clock_that_led_is_renewed_once_the_clock_is_right() {
        let folder = tempfile::tempdir().unwrap();
        let tls = configured(&make(folder.path(), &names(&["localhost"]), false, clock::now()).unwrap());
        let ahead = UtcTime::from_micros(clock::now().micros() + 400 * DAY_US);
        renew(folder.path(), &tls, Vec::new(), Some(900), ahead).unwrap();
        assert!(first_in(&tls.certificate).unwrap().1.from > clock::now());
        assert!(is_due(folder.path(), &tls, 32, clock::now()).unwrap());
        let renewed = renew(folder.path(), &tls, Vec::new(), Some(32), clock::now()).unwrap();
        assert!(matches!(renewed, Renewal::Renewed { .. }));
        assert!(first_in(&tls.certificate).unwrap().1.from <= clock::now());
        assert!(!is_due(folder.path(), &tls, 32, clock::now()).unwrap());
    }

    #[test]
    fn a_new_key_that_was_broken_off_anywhere_leaves_a_pair_that_fits() {
        let folder = tempfile::tempdir().unwrap();
        let (at, given) = (|name: &str| folder.path().join(name), names(&["localhost"]));
        let tls = configured(&make(folder.path(), &given, false, clock::now()).unwrap());
        let keep = |from: &Path, to: &str| assert!(fs::copy(from, at(to)).unwrap() > 0);
        let facts = |path: &Path| first_in(path).unwrap().0.into_owned();
        for file in ["server.pem", "server-key.pem"] {
            keep(&at(file), &format!("{file}.old"));
        }
        // The key cannot be written: the earlier pair stays, and the new certificate waits.
        fs::create_dir_all(at("server-key.new/full")).unwrap();
        make(folder.path(), &given, true, clock::now()).err().unwrap();
        fs::remove_dir_all(at("server-key.new")).unwrap();
        let first = facts(&tls.certificate);
        assert_eq!(Pair::read(&tls).unwrap().certified.cert[0], first);
        assert!(pair::waiting(&tls.certificate).exists());
        make(folder.path(), &given, true, clock::now()).unwrap();
        let second = facts(&tls.certificate);
        for file in ["server.pem", "server-key.pem"] {
            keep(&at(file), &format!("{file}.new"));
        }
        assert!(first != second && !pair::waiting(&tls.certificate).exists());
        // The state after a kill: which key is in place, and which certificate is read.
        for (key, read) in [("old", &first), ("new", &second)] {
            keep(&at("server.pem.old"), "server.pem");
            keep(&at("server.pem.new"), "server.pem.next");
            keep(&at(&format!("server-key.pem.{key}")), "server-key.pem");
            assert_eq!(Pair::read(&tls).unwrap().certified.cert[0], *read, "{key}");
            // A timer that has nothing to renew still completes the change.
            assert_eq!(is_due(folder.path(), &tls, 30, clock::now()).unwrap(), key == "new");
            renew(folder.path(), &tls, Vec::new(), Some(30), clock::now()).unwrap();
            assert_eq!(facts(&tls.certificate), *read, "{key}");
        }
        // A pending certificate that does not match the key is not used.
        keep(&at("ca-key.pem"), "server-key.pem");
        keep(&at("server.pem.old"), "server.pem.next");
        let why = Pair::read(&tls).err().unwrap().to_string();
        assert!(why.contains("do not belong together"), "{why}");
    }

    #[test]
    fn a_clock_that_cannot_be_right_makes_no_certificate() {
        let folder = tempfile::tempdir().unwrap();
        let (given, at_1970) = (names(&["localhost"]), UtcTime::from_micros(1_000_000));
        let why = make(folder.path(), &given, false, at_1970).err().unwrap().to_string();
        assert!(
            why.contains("1970-01-01") && why.contains("chrony") && why.contains("do this again"),
            "{why}"
        );
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
        let tls = configured(&make(folder.path(), &given, false, clock::now()).unwrap());
        let before = fs::read(&tls.certificate).unwrap();
        renew(folder.path(), &tls, Vec::new(), None, at_1970).unwrap_err();
        assert_eq!(fs::read(&tls.certificate).unwrap(), before);
    }
}
