//! Checks that a bundle is for this computer, and valid now.

use super::place::{BASE, OVERLAY, RECORD};
use crate::setup;
use anyhow::{Context as _, bail, ensure};
use config::{Config, Disk, FileSource};
use provision::{Bundle, Manifest, Part, authority_validity};
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use units::{Civil, UtcTime};

/// Clocks of shore and boat may differ by so much (µs).
const CLOCKS_DIFFER_US: i64 = 3_600_000_000;

/// Checks that the bundle is not from the future, and that its authority is valid now.
pub(super) fn in_time(bundle: &Bundle, now: UtcTime) -> anyhow::Result<()> {
    let made = UtcTime::from_micros(bundle.manifest.made_us);
    if made - now > CLOCKS_DIFFER_US {
        bail!(
            "this computer's clock says {}, and the bundle was made {}: set the clock (`sudo date -u -s '2026-11-25 12:00'` \
             with the right time), then try again. With a wrong clock neither certificates nor the VPN work",
            written(now),
            written(made)
        );
    }
    let Some(pem) = bundle.file(Part::Authority) else { return Ok(()) };
    let validity = std::str::from_utf8(pem).ok().and_then(authority_validity);
    let validity = validity.context("the certificate in the bundle cannot be read: make another bundle")?;
    ensure!(
        validity.until > now,
        "the certificate in the bundle was good until {}: make a new authority ashore (`lutra-server tls init`), then another \
         bundle",
        written(validity.until)
    );
    ensure!(
        validity.from - now <= CLOCKS_DIFFER_US,
        "the certificate in the bundle is good from {} on, and this computer's clock says {}: set the clock",
        written(validity.from),
        written(now)
    );
    Ok(())
}

/// Checks that the package is installed, and that this computer is not another vessel's and has no newer bundle.
pub(super) fn computer(bundle: &Bundle, root: &Path, replace: bool) -> anyhow::Result<()> {
    let base = root.join(BASE);
    ensure!(base.is_file(), "{} is not there: install the package lutra-agent first", base.display());
    let path = root.join(RECORD);
    let bytes = match fs::read(&path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(error).with_context(|| format!("cannot read {}", path.display())),
    };
    if replace {
        return Ok(());
    }
    let there: Manifest = serde_json::from_slice(&bytes)
        .with_context(|| format!("{} is damaged: --replace takes no notice of it", path.display()))?;
    let (name, own) = (&bundle.manifest.vessel, &there.vessel);
    ensure!(
        (name, bundle.manifest.imc_address) == (own, there.imc_address),
        "the bundle is for {name} (0x{:04X}), and this computer is {own} (0x{:04X}): take the bundle of {own}, or say \
         --replace if this computer goes into the other boat",
        bundle.manifest.imc_address,
        there.imc_address
    );
    ensure!(
        bundle.manifest.made_us >= there.made_us,
        "this computer has a newer bundle, of {}; the secrets in this one ({}) may be good no more: take the newest, or say \
         --replace",
        written(UtcTime::from_micros(there.made_us)),
        written(UtcTime::from_micros(bundle.manifest.made_us))
    );
    Ok(())
}

/// Checks that the agent aboard accepts the overlay.
pub(super) fn configuration(bundle: &Bundle, root: &Path) -> anyhow::Result<()> {
    let overlay =
        Overlaid { path: root.join(OVERLAY), bytes: bundle.file(Part::Overlay).unwrap_or_default() };
    let config = Config::load(&overlay, &overlay.path, &[&bundle.manifest.profile]);
    let wrong = "this agent refuses the vessel's configuration: mend the fleet file ashore, or update lutra-agent; nothing was \
                 changed";
    ensure!(!config.report().has_errors(), "{wrong}\n{}", config.report());
    setup::settings(&config, 0).context(wrong)?;
    ensure!(
        (config.vehicle(), config.address()) == (&bundle.manifest.vessel, Some(bundle.manifest.imc_address)),
        "{wrong}: it says {} and 0x{:04X}",
        config.vehicle(),
        config.address().unwrap_or_default()
    );
    Ok(())
}

/// The file system with one file replaced by the bundle's.
struct Overlaid<'a> {
    path: PathBuf,
    bytes: &'a [u8],
}

impl FileSource for Overlaid<'_> {
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        if path == self.path { Ok(self.bytes.to_vec()) } else { Disk.read(path) }
    }
}

/// A time to the minute, UTC.
fn written(time: UtcTime) -> String {
    let Civil { year, month, day, hour, minute, .. } = time.civil();
    format!("{year:04}-{month:02}-{day:02} {hour:02}:{minute:02} UTC")
}
