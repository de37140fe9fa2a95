//! Bundles that are opened, and those that are refused.

use super::*;
use crate::bundle::seal::passphrase_is_good;

const PASSPHRASE: &str = "kelp-otter-skerry-42";
const RANDOM: Randomness = Randomness([9; 28]);

fn manifest() -> Manifest {
    Manifest {
        format: FORMAT,
        vessel: "otter-01".to_owned(),
        imc_address: 0x2810,
        profile: "Hardware".to_owned(),
        made_us: 1_795_000_000_000_000,
        made_by: "0.1.0".to_owned(),
        devices: vec![Port { device: "compass".to_owned(), port: "/dev/lutra/compass".to_owned() }],
        files: Vec::new(),
    }
}

fn bundle() -> Bundle {
    let files = vec![
        (Part::Overlay, b"[Require agent.ini]\n".to_vec()),
        (Part::Token, b"lutra_link_secret\n".to_vec()),
        (Part::Chart, vec![0; 3_000]),
    ];
    Bundle::new(manifest(), files)
}

/// The plain form with other words of the same length in its manifest.
fn packed_with(old: &str, new: &str) -> Vec<u8> {
    let manifest = serde_json::to_string(&bundle().manifest).unwrap();
    assert!(manifest.contains(old), "{old} in {manifest}");
    let manifest = manifest.replacen(old, new, 1);
    let mut bytes = u32::try_from(manifest.len()).unwrap().to_le_bytes().to_vec();
    bytes.extend_from_slice(manifest.as_bytes());
    for part in [Part::Overlay, Part::Token, Part::Chart] {
        bytes.extend_from_slice(bundle().file(part).unwrap());
    }
    bytes
}

#[test]
fn a_bundle_opens_as_it_was_sealed_and_shows_no_secret() {
    let sealed = bundle().seal(PASSPHRASE, RANDOM).unwrap();
    assert_eq!(sealed_bytes(&sealed[..64]), Ok(sealed.len() as u64));
    assert_eq!(Bundle::open(sealed.clone(), PASSPHRASE), Ok(bundle()));
    assert!(!format!("{:?}{RANDOM:?}", bundle()).contains("lutra_link"));
    let text = String::from_utf8_lossy(&sealed);
    assert!(!text.contains("lutra_link") && !text.contains("otter-01"), "nothing of it is readable");
}

#[test]
fn a_wrong_passphrase_a_damaged_and_a_cut_copy_are_told_apart() {
    let sealed = bundle().seal(PASSPHRASE, RANDOM).unwrap();
    assert_eq!(Bundle::open(sealed.clone(), "kelp-otter-skerry-43"), Err(BundleError::WrongPassphrase));
    for at in (18..sealed.len()).step_by(97) {
        let mut damaged = sealed.clone();
        damaged[at] ^= 1;
        assert_eq!(Bundle::open(damaged, PASSPHRASE), Err(BundleError::Damaged), "{at}");
    }
    for cut in [20, 100, sealed.len() / 2, sealed.len() - 1] {
        let error = Bundle::open(sealed[..cut].to_vec(), PASSPHRASE).unwrap_err();
        assert_eq!(error, BundleError::CutShort { have: cut as u64, whole: sealed.len() as u64 });
    }
    let longer = [&sealed[..], b"more"].concat();
    assert_eq!(Bundle::open(longer, PASSPHRASE), Err(BundleError::TooLong(4)));
}

#[test]
fn other_files_newer_formats_and_huge_ones_are_refused_by_their_first_bytes() {
    assert_eq!(sealed_bytes(b"PK\x03\x04"), Err(BundleError::NotABundle));
    assert_eq!(sealed_bytes(b""), Err(BundleError::NotABundle));
    assert_eq!(sealed_bytes(b"LUTRABDL\x03\x00"), Err(BundleError::NewerFormat(3)));
    let huge = [&b"LUTRABDL\x01\x00"[..], &[0xFF; 8]].concat();
    assert_eq!(sealed_bytes(&huge), Err(BundleError::TooLarge(u64::MAX)));
    assert!(matches!(sealed_bytes(b"LUTRABDL\x01\x00\x05"), Err(BundleError::CutShort { .. })));
}

#[test]
fn a_short_passphrase_seals_nothing() {
    assert!(!passphrase_is_good("otter"));
    assert_eq!(bundle().seal("otter", RANDOM), Err(BundleError::WeakPassphrase));
}

#[test]
fn names_lengths_and_digests_that_no_bundle_has_are_refused() {
    assert_eq!(Bundle::unpack(&packed_with("otter-01", "otter-01")), Ok(bundle()));
    for (old, new, told) in [
        ("\"name\":\"chart.lutra-index\"", "\"name\":\"../../etc/passwd\"", "../../etc/passwd"),
        ("\"name\":\"chart.lutra-index\"", "\"name\":\"/etc/shadow\"", "/etc/shadow"),
        ("\"name\":\"chart.lutra-index\"", "\"name\":\"lutra.token\"", "twice"),
        ("\"name\":\"lutra.token\"", "\"name\":\"ca.pem\"", "no lutra.token"),
        ("\"bytes\":3000", "\"bytes\":18446744073709551615", "longer than the bundle"),
        ("\"bytes\":3000", "\"bytes\":2999", "another digest"),
        ("\"bytes\":3000", "\"bytes\":-1", "manifest"),
        ("\"vessel\":\"otter-01\"", "\"vessel\":\"a\\nb\"", "cannot be"),
        ("\"profile\":\"Hardware\"", "\"profile\":\"; rm\"", "cannot be"),
        ("\"files\":", "\"links\":[],\"files\":", "unknown field"),
    ] {
        let error = Bundle::unpack(&packed_with(old, new)).unwrap_err().to_string();
        assert!(error.contains(told), "{new}: {error}");
    }
    assert_eq!(
        Bundle::unpack(&packed_with("\"format\":1", "\"format\":9")),
        Err(BundleError::NewerFormat(9))
    );
    let whole = packed_with("otter-01", "otter-01");
    for cut in 0..whole.len() {
        assert!(Bundle::unpack(&whole[..cut]).is_err(), "{cut}");
    }
    assert!(Bundle::unpack(&[&whole[..], b"x"].concat()).is_err());
}

#[test]
fn only_a_bundle_for_openvpn_needs_an_agent_that_knows_it() {
    let format = |sealed: &[u8]| u16::from_le_bytes([sealed[8], sealed[9]]);
    let first = bundle().seal(PASSPHRASE, RANDOM).unwrap();
    assert_eq!((format(&first), bundle().manifest.format), (1, 1));
    let files = vec![
        (Part::Overlay, b"[Require agent.ini]\n".to_vec()),
        (Part::Token, b"lutra_link_secret\n".to_vec()),
        (Part::OpenVpn, b"client\n".to_vec()),
    ];
    let openvpn = Bundle::new(manifest(), files);
    let sealed = openvpn.seal(PASSPHRASE, RANDOM).unwrap();
    assert_eq!((format(&sealed), openvpn.manifest.format), (2, 2));
    assert_eq!(Bundle::open(sealed, PASSPHRASE), Ok(openvpn));
}
