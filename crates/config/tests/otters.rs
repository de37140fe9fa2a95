//! The Otters' own files load as they are, and the report of what Lutra does not know is pinned.

use std::path::PathBuf;

use config::{Config, Disk};

fn load(vessel: &str, profile: &str) -> Option<Config> {
    let folder: PathBuf = testkit::shared("data/onboard/ini/user/etc")?;
    Some(Config::load(&Disk, &folder.join(format!("{vessel}.ini")), &[profile]))
}

#[test]
fn every_vessel_loads_in_both_profiles_with_a_known_report() {
    for (vessel, profile, errors, warnings, notes) in [
        ("ntnu-otter-01", "Simulation", 0, 0, 0),
        ("ntnu-otter-01", "Hardware", 0, 0, 0),
        ("ntnu-otter-02", "Simulation", 0, 0, 0),
        ("ntnu-otter-02", "Hardware", 0, 0, 0),
        ("ntnu-otter-03", "Simulation", 0, 0, 0),
        ("ntnu-otter-03", "Hardware", 0, 0, 0),
    ] {
        let Some(config) = load(vessel, profile) else { return };
        let counts = config.report().counts();
        let found = (counts.errors, counts.warnings, counts.notes);
        assert_eq!(found, (errors, warnings, notes), "{vessel} {profile}\n{}", config.report());
    }
}
