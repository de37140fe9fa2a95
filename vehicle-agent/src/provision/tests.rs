//! Bundles installed on a root file system like the package's, and refused ones.

use super::*;
use crate::doctor::Status;
use provision::{FORMAT, Fleet, Manifest, Part, Port, VpnKey, overlay, wireguard};
use std::os::unix::fs::PermissionsExt as _;
use tempfile::TempDir;

const EXAMPLE: &str = include_str!("../../../deploy/fleet.example.toml");
const MADE: UtcTime = UtcTime::from_micros(1_795_700_000_000_000);

/// A root on which the package is installed.
fn installed() -> TempDir {
    let root = tempfile::tempdir().unwrap();
    fs::create_dir_all(root.path().join("etc/lutra")).unwrap();
    fs::write(root.path().join("etc/lutra/agent.ini"), crate::OTTER_INI).unwrap();
    let own = rustix::process::geteuid().as_raw();
    let group = rustix::process::getegid().as_raw();
    fs::write(root.path().join("etc/passwd"), format!("lutra-agent:x:{own}:{group}:::\n")).unwrap();
    root
}

fn bundle_of(name: &str, made: UtcTime, more: Vec<(Part, Vec<u8>)>) -> Bundle {
    let fleet = Fleet::read(EXAMPLE).unwrap();
    let vessel = fleet.vessel(name).unwrap();
    let port = |(device, port): &(provision::Device, String)| Port {
        device: device.name().into(),
        port: port.clone(),
    };
    let manifest = Manifest {
        format: FORMAT,
        vessel: name.to_owned(),
        imc_address: vessel.imc_address,
        profile: vessel.profile.name().to_owned(),
        made_us: made.micros(),
        made_by: "0.1.0".to_owned(),
        devices: vessel.devices.iter().map(port).collect(),
        files: Vec::new(),
    };
    let key = VpnKey::from_random([5; 32]);
    let mut files = vec![
        (Part::Overlay, overlay(&fleet, vessel, Part::Token.name(), None).into_bytes()),
        (Part::Token, b"lutra_link_00\n".to_vec()),
        (Part::Vpn, wireguard::aboard(&fleet, vessel, &key, &key.public()).into_bytes()),
    ];
    files.extend(more);
    Bundle::new(manifest, files)
}

/// As the command does after opening the bundle; returns the number of files written.
fn bring(bundle: &Bundle, root: &Path, now: UtcTime, replace: bool) -> anyhow::Result<usize> {
    verify::in_time(bundle, now)?;
    verify::computer(bundle, root, replace)?;
    verify::configuration(bundle, root)?;
    let due = stage::due(place::destinations(bundle, root)?)?;
    stage::put(&due)?;
    Ok(due.len())
}

fn told<T>(outcome: anyhow::Result<T>) -> String {
    format!("{:#}", outcome.err().unwrap())
}

#[test]
fn a_bundle_is_brought_aboard_once_and_a_second_time_changes_nothing() {
    let root = installed();
    let bundle = bundle_of("ntnu-otter-03", MADE, vec![(Part::Chart, b"chart".to_vec())]);
    assert_eq!(bring(&bundle, root.path(), MADE, false).unwrap(), 6);
    for (place, mode) in [
        ("etc/lutra/vessel.ini", 0o640),
        ("etc/lutra/lutra.token", 0o640),
        ("etc/wireguard/lutra.conf", 0o600),
        ("etc/wireguard", 0o700),
        ("var/lib/lutra-agent/chart/chart.lutra-index", 0o640),
        ("etc/systemd/system/lutra-agent.service.d/vessel.conf", 0o644),
    ] {
        let about = fs::metadata(root.path().join(place)).unwrap();
        assert_eq!(about.permissions().mode() & 0o777, mode, "{place}");
    }
    let path = root.path().join("etc/lutra/vessel.ini");
    let config = config::Config::load(&config::Disk, &path, &["Hardware"]);
    assert_eq!((config.vehicle(), config.address()), ("ntnu-otter-03", Some(0x2812)), "{}", config.report());
    // The shore sent another chart meanwhile.
    fs::write(root.path().join("var/lib/lutra-agent/chart/chart.lutra-index"), "newer").unwrap();
    assert_eq!(bring(&bundle, root.path(), MADE, false).unwrap(), 0);
    let chart = fs::read(root.path().join("var/lib/lutra-agent/chart/chart.lutra-index")).unwrap();
    assert_eq!(chart, b"newer");
    assert!(
        !fs::read_to_string(root.path().join("etc/lutra/provisioned.json")).unwrap().contains("lutra_link")
    );
}

#[test]
fn another_vessels_bundle_and_an_older_one_are_refused_unless_they_are_to_replace() {
    let root = installed();
    let later = UtcTime::from_micros(MADE.micros() + 1);
    bring(&bundle_of("ntnu-otter-01", later, Vec::new()), root.path(), later, false).unwrap();
    let (other, older) =
        (bundle_of("ntnu-otter-02", later, Vec::new()), bundle_of("ntnu-otter-01", MADE, Vec::new()));
    let error = told(bring(&other, root.path(), later, false));
    assert!(error.contains("is for ntnu-otter-02 (0x2811), and this computer is ntnu-otter-01"), "{error}");
    assert!(told(bring(&older, root.path(), later, false)).contains("has a newer bundle"));
    assert!(bring(&other, root.path(), later, true).unwrap() > 0);
}

#[test]
fn a_wrong_clock_and_an_expired_authority_are_told_with_the_remedy() {
    let root = installed();
    let bundle = bundle_of("ntnu-otter-01", MADE, Vec::new());
    let error = told(bring(&bundle, root.path(), UtcTime::from_micros(0), false));
    assert!(error.contains("clock says 1970-01-01 00:00 UTC") && error.contains("set the clock"), "{error}");
    let pem = include_bytes!("../../../crates/provision/tests/authority.pem").to_vec();
    let bundle = bundle_of("ntnu-otter-01", MADE, vec![(Part::Authority, pem)]);
    assert!(verify::in_time(&bundle, MADE).is_ok());
    let late = UtcTime::from_micros(MADE.micros() + 4_000 * 86_400_000_000);
    let error = told(bring(&bundle, root.path(), late, false));
    assert!(error.contains("was good until 2036-11-22 20:41 UTC"), "{error}");
    let damaged = bundle_of("ntnu-otter-01", MADE, vec![(Part::Authority, b"words".to_vec())]);
    assert!(told(verify::in_time(&damaged, MADE)).contains("cannot be read"));
    assert!(!root.path().join("etc/wireguard").exists(), "nothing was written");
}

#[test]
fn nothing_is_written_where_the_package_is_not_installed_or_a_link_leads_elsewhere() {
    let (root, elsewhere) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let bundle = bundle_of("ntnu-otter-01", MADE, Vec::new());
    assert!(told(bring(&bundle, root.path(), MADE, false)).contains("install the package"));
    let root = installed();
    std::os::unix::fs::symlink(elsewhere.path(), root.path().join("etc/wireguard")).unwrap();
    assert!(told(bring(&bundle, root.path(), MADE, false)).contains("is a symbolic link"));
    assert_eq!(fs::read_dir(elsewhere.path()).unwrap().count(), 0);
    assert!(!root.path().join("etc/lutra/vessel.ini").exists());
}

#[test]
fn an_overlay_that_this_agent_refuses_is_not_written() {
    let root = installed();
    let good = bundle_of("ntnu-otter-01", MADE, Vec::new());
    let overlay = String::from_utf8(good.file(Part::Overlay).unwrap().to_vec()).unwrap();
    let bad = overlay.replace("Maximum Speed = 2.5", "Maximum Speed = fast");
    assert_ne!(bad, overlay);
    let files = vec![(Part::Overlay, bad.into_bytes()), (Part::Token, b"x".to_vec())];
    let error = told(bring(&Bundle::new(good.manifest, files), root.path(), MADE, false));
    assert!(error.contains("Maximum Speed") && error.contains("nothing was changed"), "{error}");
}

#[test]
fn a_half_copied_file_is_refused_before_the_passphrase_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.bundle");
    fs::write(&path, "no bundle").unwrap();
    assert!(told(read(&path)).contains("this file is not a bundle"));
    assert!(told(read(folder.path())).contains("is not a file"));
    let sealed = bundle_of("ntnu-otter-01", MADE, Vec::new());
    let sealed = sealed.seal("kelp-otter-skerry", provision::Randomness([1; 28])).unwrap();
    fs::write(&path, &sealed).unwrap();
    assert_eq!(read(&path).unwrap(), sealed);
    fs::write(&path, &sealed[..sealed.len() / 2]).unwrap();
    assert!(told(read(&path)).contains("is cut short"));
}

#[test]
fn what_the_boat_lacks_is_told() {
    let root = installed();
    fs::create_dir_all(root.path().join("dev/lutra")).unwrap();
    fs::write(root.path().join("dev/lutra/compass"), "").unwrap();
    let bundle = bundle_of("ntnu-otter-01", MADE, Vec::new());
    let findings = missing::look(&bundle, root.path());
    let bad: Vec<&str> =
        findings.iter().filter(|one| one.status != Status::Ok).map(|one| one.text.as_str()).collect();
    assert_eq!(bad.len(), 5, "{bad:?}");
    assert!(bad.iter().any(|text| text.contains("hydrophone at /dev/lutra/hydrophone is not there")));
    assert!(!bad.iter().any(|text| text.contains("compass")), "{bad:?}");
}

#[test]
fn a_bundle_for_openvpn_goes_where_its_unit_looks_and_lacks_openvpn() {
    let root = installed();
    let wireguard_bundle = bundle_of("ntnu-otter-01", MADE, Vec::new());
    let files = vec![
        (Part::Overlay, wireguard_bundle.file(Part::Overlay).unwrap().to_vec()),
        (Part::Token, b"lutra_link_00\n".to_vec()),
        (Part::OpenVpn, b"client\n".to_vec()),
    ];
    let bundle = Bundle::new(wireguard_bundle.manifest.clone(), files);
    bring(&bundle, root.path(), MADE, false).unwrap();
    let path = root.path().join("etc/openvpn/client/lutra.conf");
    assert_eq!(fs::read(&path).unwrap(), b"client\n");
    assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o600);
    assert!(!root.path().join("etc/wireguard").exists());
    let vpn = |bundle: &Bundle| missing::look(bundle, root.path()).remove(0);
    let is_told = |bundle: &Bundle, what: &str| format!("{:?}", vpn(bundle)).contains(what);
    assert!(vpn(&bundle).status == Status::Warn && is_told(&bundle, "apt install openvpn"));
    fs::create_dir_all(root.path().join("usr/sbin")).unwrap();
    fs::write(root.path().join("usr/sbin/openvpn"), "").unwrap();
    assert_eq!(vpn(&bundle).status, Status::Ok);
    assert!(is_told(&wireguard_bundle, "apt install wireguard-tools"), "the other VPN is not missed");
}
