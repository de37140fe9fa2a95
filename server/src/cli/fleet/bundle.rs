//! `lutra-server fleet bundle`: everything that one boat needs, in one sealed file.

use super::files::{self, Files};
use super::lock::FleetLock;
use super::state::{self, Known};
use super::{BundleArguments, look, vpn};
use crate::cli::Common;
use crate::cli::say::{complain, say};
use crate::config::Config;
use anyhow::{Context as _, bail, ensure};
use provision::{
    Bundle, FORMAT, Fleet, MAX_BUNDLE_BYTES, Manifest, Part, Port, Randomness, Vessel, authority_validity,
    overlay, passphrase_in, passphrase_is_good,
};
use shore::clock;
use shore::identity::audit::Record;
use shore::identity::{one_time_password, with, within_transaction};
use std::fs;
use std::path::{Path, PathBuf};

/// Most bytes of a bundle besides the chart.
const OTHER_BYTES: u64 = 1 << 20;
/// The largest passphrase or authority that is read.
const SMALL_FILE_BYTES: u64 = 1 << 20;

/// `lutra-server fleet bundle`.
pub(super) fn bundle(common: &Common, arguments: &BundleArguments) -> anyhow::Result<()> {
    let config = common.load_to_write()?;
    // Before the lock: a pipe that gives it late must not hold up a revocation.
    let (passphrase, made) = passphrase(arguments.passphrase_file.as_deref())?;
    let _lock = FleetLock::take(&config.data, "fleet bundle")?;
    let files = Files::of(&config, &arguments.place)?;
    let fleet = state::applied(&files)?;
    let vessel = fleet
        .vessel(&arguments.name)
        .with_context(|| format!("the fleet file that was applied last has no vessel {}", arguments.name))?;
    let tunnel = vpn::of(fleet.vpn.kind, &files);
    vpn::require_server_key(&*tunnel, &files)?;
    if vpn::differs(&*tunnel, &fleet)? {
        complain!(
            "note: the files of the VPN in {} are not as the fleet file that was applied last says: `lutra-server fleet apply` writes \
             them and prints how root puts them into force",
            tunnel.folder().display()
        );
    }
    for doubt in look::doubts(&fleet, &config).into_iter().chain(tunnel.doubts(clock::now())?) {
        complain!("note: {doubt}");
    }
    let name = vessel.name.as_str();
    let parts = parts(&config, arguments, &files, &fleet, vessel)?;
    let bundle = Bundle::new(manifest(vessel), parts);
    let mut random = [0; 28];
    getrandom::fill(&mut random).context("the kernel gives no randomness")?;
    let sealed = bundle.seal(&passphrase, Randomness(random))?;
    let output = arguments.output.clone().unwrap_or_else(|| PathBuf::from(format!("{name}.bundle")));
    // Logged before the secrets of a vessel leave the server.
    let lines = Record(vec![(clock::now(), state::line(state::BUNDLE, name))]);
    with(&config.data, async |db| within_transaction(db, lines).await)?;
    files::write(&output, &sealed)?;
    for item in &bundle.manifest.files {
        complain!("{}\t{} bytes", item.name, item.bytes);
    }
    complain!("{} is for {name} alone. Aboard: sudo lutra-agent provision {name}.bundle", output.display());
    if made {
        complain!("its passphrase, shown this once; carry it another way than the file:");
        say!("{passphrase}");
    }
    Ok(())
}

fn manifest(vessel: &Vessel) -> Manifest {
    let port = |(device, port): &(provision::Device, String)| Port {
        device: device.name().to_owned(),
        port: port.clone(),
    };
    Manifest {
        format: FORMAT,
        vessel: vessel.name.clone(),
        imc_address: vessel.imc_address,
        profile: vessel.profile.name().to_owned(),
        made_us: clock::now().micros(),
        made_by: env!("CARGO_PKG_VERSION").to_owned(),
        devices: vessel.devices.iter().map(port).collect(),
        files: Vec::new(),
    }
}

/// The files of the bundle.
fn parts(
    config: &Config,
    arguments: &BundleArguments,
    files: &Files,
    fleet: &Fleet,
    vessel: &Vessel,
) -> anyhow::Result<Vec<(Part, Vec<u8>)>> {
    let name = vessel.name.as_str();
    let apply = "`lutra-server fleet apply` makes another";
    let known = Known::look(&config.data, files, fleet, clock::now())?;
    let token = files.token(name)?.filter(|_| known.good.contains(&vessel.name));
    let token = token.with_context(|| format!("{name} has no link token that is good: {apply}"))?;
    let authority = if fleet.server.encrypted { Some(authority(config, arguments)?) } else { None };
    let overlay =
        overlay(fleet, vessel, Part::Token.name(), authority.is_some().then_some(Part::Authority.name()));
    let (vpn, configuration) = vpn::of(fleet.vpn.kind, files).aboard(fleet, vessel)?;
    let mut parts = vec![
        (Part::Overlay, overlay.into_bytes()),
        (Part::Token, token.into_bytes()),
        (vpn, configuration.into_bytes()),
    ];
    parts.extend(authority.map(|pem| (Part::Authority, pem.into_bytes())));
    parts.extend(chart(config, arguments)?.map(|bytes| (Part::Chart, bytes)));
    Ok(parts)
}

/// The certificate by which the boat knows the server.
fn authority(config: &Config, arguments: &BundleArguments) -> anyhow::Result<String> {
    let own = config.data.join("tls").join("ca.pem");
    let path = arguments.authority.clone().unwrap_or(own);
    let pem = small(&path).with_context(|| {
        "the link is encrypted, so the boat needs the certificate of the authority: `lutra-server tls init` makes one, \
         --authority FILE names another"
    })?;
    let validity = authority_validity(&pem)
        .with_context(|| format!("{} holds no certificate in PEM", path.display()))?;
    let (until, now) = (clock::written(validity.until), clock::now());
    ensure!(validity.until > now, "{} was good until {until}: make another", path.display());
    Ok(pem)
}

/// The index of the chart set, if there is one.
fn chart(config: &Config, arguments: &BundleArguments) -> anyhow::Result<Option<Vec<u8>>> {
    let path = chartdb::index_path(&config.chart_set());
    if arguments.no_chart || !path.exists() {
        return Ok(None);
    }
    let size = fs::metadata(&path).with_context(|| path.display().to_string())?.len();
    if size > MAX_BUNDLE_BYTES - OTHER_BYTES {
        complain!("note: the sea chart is left out, it has {} MiB; it comes by the link", size >> 20);
        return Ok(None);
    }
    fs::read(&path)
        .map(Some)
        .with_context(|| format!("cannot read {}; --no-chart leaves it out", path.display()))
}

/// The passphrase, and whether it was made here.
fn passphrase(file: Option<&Path>) -> anyhow::Result<(String, bool)> {
    let Some(file) = file else { return Ok((one_time_password(), true)) };
    let text = small(file)?;
    let text = passphrase_in(&text)
        .with_context(|| format!("{}: give the passphrase in one line", file.display()))?
        .to_owned();
    ensure!(passphrase_is_good(&text), "{}: take a passphrase of 12 characters or more", file.display());
    Ok((text, false))
}

/// A small file's text.
fn small(path: &Path) -> anyhow::Result<String> {
    let wrong = || format!("cannot read {}", path.display());
    if fs::metadata(path).with_context(wrong)?.len() > SMALL_FILE_BYTES {
        bail!("{} is too large for what it should be", path.display());
    }
    fs::read_to_string(path).with_context(wrong)
}
