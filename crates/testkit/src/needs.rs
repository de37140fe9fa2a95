//! Requirements of some tests on the computer, and how long they may take.
//!
//! A test that misses something passes and says why by [`absent`]. `LUTRA_REQUIRED` lists, with commas, what must be there:
//! a test that misses one of these fails. `LUTRA_SKIPPED` names a file that gathers the reasons, for nextest shows
//! nothing of tests that pass; `make test` prints it at its end.

use std::io::Write as _;

/// A requirement that not every computer meets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Need {
    /// The agent's program, beside the server's.
    Agent,
    /// `chronyd` and `chronyc`.
    Chrony,
    /// Chromium, Node and the pages' scripts.
    Browser,
    /// `libfaketime`.
    Faketime,
    /// `ogrinfo` of GDAL.
    Gdal,
    /// `gpsd` and `gpsdecode`.
    Gpsd,
    /// `influxd`.
    Influxd,
    /// `mosquitto`, `mosquitto_sub` and `mosquitto_passwd`.
    Mosquitto,
    /// The right to mount a disk.
    Mount,
    /// The processor that the program is for, and not one that is emulated.
    Native,
    /// The right to make a network namespace.
    Netns,
    /// `nft` of nftables.
    Nftables,
    /// `nginx`.
    Nginx,
    /// OpenVPN.
    Openvpn,
    /// PostGIS, beside PostgreSQL.
    Postgis,
    /// `initdb`, `pg_ctl` and `psql` of PostgreSQL, and `setpriv` where the tests run as root.
    Postgres,
    /// `python3`.
    Python,
    /// `Rscript`.
    R,
    /// The folder `shared` beside the checkout.
    Shared,
    /// WireGuard.
    Wireguard,
}

impl Need {
    /// As `LUTRA_REQUIRED` calls it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Agent => "agent",
            Self::Browser => "browser",
            Self::Chrony => "chrony",
            Self::Faketime => "faketime",
            Self::Gdal => "gdal",
            Self::Gpsd => "gpsd",
            Self::Influxd => "influxd",
            Self::Mosquitto => "mosquitto",
            Self::Mount => "mount",
            Self::Native => "native",
            Self::Netns => "netns",
            Self::Nftables => "nftables",
            Self::Nginx => "nginx",
            Self::Openvpn => "openvpn",
            Self::Postgis => "postgis",
            Self::Postgres => "postgres",
            Self::Python => "python",
            Self::R => "r",
            Self::Shared => "shared",
            Self::Wireguard => "wireguard",
        }
    }
}

/// Says that a test is skipped because something is absent, and why or what to do about it.
///
/// # Panics
/// When `LUTRA_REQUIRED` says that it must be there.
pub fn absent(need: Need, why: &str) {
    let name = need.name();
    let required = std::env::var("LUTRA_REQUIRED").unwrap_or_default();
    assert!(!required.split(',').any(|one| one.trim() == name), "{name} is required and absent: {why}");
    println!("skipped: {name}: {why}");
    let Some(path) = std::env::var_os("LUTRA_SKIPPED") else { return };
    let line = format!("{name}: {why}\n");
    let file = std::fs::OpenOptions::new().create(true).append(true).open(path);
    file.and_then(|mut file| file.write_all(line.as_bytes())).expect("what is skipped is written down");
}

/// Whether another processor is emulated, as by `make test-aarch64`: everything takes many times as long, and not all that a
/// kernel tells is there.
pub fn is_emulated() -> bool {
    std::env::var_os("LUTRA_EMULATED").is_some()
}

/// How much of something a test does: `short` in the gate, `long` with `LUTRA_LONG` set, as `make test-long` sets it.
pub fn so_many<T>(short: T, long: T) -> T {
    if std::env::var_os("LUTRA_LONG").is_some() { long } else { short }
}
