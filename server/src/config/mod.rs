//! The server's configuration: types, defaults and validation.
//!
//! Every key is in `etc/server.toml` with its default, which is also what `lutra-server config` prints; a test keeps both
//! in agreement. [`load`] reads the file and applies `LUTRA_*` variables and flags.

mod load;
mod transports;

pub use load::{ConfigError, Overrides, load};
pub use transports::{Imc, Imcproxy, Listen, Tcp, Transports, Udp, parse_network};

use serde::{Deserialize, Serialize};
use shore::{Settings, charts, identity, notices, sinks};
use std::net::{IpAddr, SocketAddr};
use std::path::{Path, PathBuf};

/// The documented configuration file with every key at its default.
pub const DOCUMENTED: &str = include_str!("../../etc/server.toml");

/// Where the packages expect the second disk.
const BACKUP: &str = "/var/backups/lutra-server";
/// Least number of days with recordings that automatic removal must keep: a typo must not delete a season.
const LEAST_ARCHIVE_DAYS: u16 = 90;

/// The whole configuration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// The folder of archive, history and people.
    pub data: PathBuf,
    /// The web server.
    pub http: Http,
    /// Encryption.
    pub tls: Tls,
    /// Passwords and sessions.
    pub people: identity::Settings,
    /// The server as a system on the IMC network.
    pub imc: Imc,
    /// Transports for IMC besides the vessel link.
    pub transports: Transports,
    /// Other stores that also get all data.
    pub sinks: sinks::Settings,
    /// Messages about alarms to people who have no page open.
    pub notices: notices::Settings,
    /// The sea chart.
    pub charts: charts::Settings,
    /// The backup.
    pub backup: Backup,
    /// How the archive is kept.
    pub archive: Archive,
    /// How the history is kept.
    pub history: History,
    /// How long recordings are kept.
    pub retention: Keep,
    /// The server's log.
    pub log: Log,
}

/// The web server.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Http {
    /// Address and port to listen on.
    pub listen: SocketAddr,
    /// Whether unencrypted HTTP may be served beyond loopback.
    pub plain_beyond_loopback: bool,
    /// Addresses of reverse proxies whose `X-Forwarded-For` is believed.
    pub trusted_proxies: Vec<IpAddr>,
    /// Origins (`https://name`) under which browsers reach the server through such proxies.
    pub origins: Vec<String>,
    /// Origins of other web pages, such as notebooks, that may read the API with a token; `*` alone for all. Never with a session.
    pub cors_origins: Vec<String>,
    /// Connections open at once, WebSockets too, a quarter of them from one address; more wait in the kernel.
    pub max_connections: usize,
    /// MiB of an uploaded log at most.
    pub max_upload_mib: u64,
    /// MiB of it at most when it is unpacked.
    pub max_unpacked_mib: u64,
}

/// Encryption. Both files or neither.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Tls {
    /// Certificate chain in PEM; empty for none.
    pub certificate: PathBuf,
    /// Its private key in PEM; empty for none.
    pub key: PathBuf,
}

/// The default target of `lutra-server backup`; automatic removal of recordings depends on it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Backup {
    /// Its folder, on another disk; empty: none.
    pub folder: PathBuf,
    /// Whether it may lie on the disk of the data, or on the root disk where the data has another one.
    pub on_any_disk: bool,
    /// Hours after the last backup at which the next is due. A timer makes it; the doctor and `/metrics` use this value.
    pub every_h: u16,
}

impl Default for Backup {
    fn default() -> Self {
        Self { folder: PathBuf::from(BACKUP), on_any_disk: false, every_h: 24 }
    }
}

/// How the archive is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Archive {
    /// So many days after its end a day is compressed; 0 leaves all days as they are.
    pub compress_after_days: u16,
}

impl Default for Archive {
    fn default() -> Self {
        Self { compress_after_days: 3 }
    }
}

/// How the history is kept.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct History {
    /// So many days after its end a month is compressed; 0 leaves all months as they are.
    pub compress_after_days: u16,
}

/// How much of the recordings is kept; 0 for ever. Used by `lutra-server prune --as-configured`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Keep {
    /// So many days with recordings stay in the history, by whole months of 31. The archive can bring others back.
    pub history_days: u16,
    /// So many days with recordings stay in the archive; others go for ever.
    pub archive_days: u16,
}

/// The server's log.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Log {
    /// Lines for people or one JSON object a line for machines.
    pub format: LogFormat,
    /// Directives of `tracing`: a level, or `target=level` separated by commas.
    pub level: String,
}

/// How log lines look.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LogFormat {
    /// Lines for people.
    Human,
    /// One JSON object a line.
    Json,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            data: PathBuf::from("lutra-data"),
            http: Http::default(),
            tls: Tls::default(),
            people: identity::Settings::default(),
            imc: Imc::default(),
            transports: Transports::default(),
            sinks: sinks::Settings::default(),
            notices: notices::Settings::default(),
            charts: charts::Settings::default(),
            backup: Backup::default(),
            archive: Archive::default(),
            history: History::default(),
            retention: Keep::default(),
            log: Log::default(),
        }
    }
}

impl Default for Http {
    fn default() -> Self {
        Self {
            listen: SocketAddr::from(([127, 0, 0, 1], 8080)),
            plain_beyond_loopback: false,
            trusted_proxies: Vec::new(),
            origins: Vec::new(),
            cors_origins: Vec::new(),
            max_connections: 1024,
            max_upload_mib: 2048,
            max_unpacked_mib: 16_384,
        }
    }
}

impl Default for Log {
    fn default() -> Self {
        Self { format: LogFormat::Human, level: "info".to_owned() }
    }
}

impl Tls {
    /// Whether certificate and key are given.
    pub fn is_given(&self) -> bool {
        !self.certificate.as_os_str().is_empty()
    }
}

impl Config {
    /// The files that it names, with the configuration file itself: a backup must include them.
    pub(crate) fn files(&self, read_from: Option<&Path>) -> Vec<PathBuf> {
        let set = self.chart_set();
        let index = chartdb::index_path(&set);
        let tls = [&self.tls.certificate, &self.tls.key];
        let named = tls.into_iter().chain(self.sinks.files()).chain([&self.notices.mail.password_file]);
        let named = named.cloned().chain(read_from.map(Path::to_owned));
        [set, index].into_iter().chain(named).collect()
    }

    /// The file of the chart set.
    pub fn chart_set(&self) -> PathBuf {
        self.shore().chart_set()
    }

    /// Settings of the shore's services.
    pub fn shore(&self) -> Settings {
        Settings {
            data: self.data.clone(),
            hub: self.imc.settings(),
            trusted: self.transports.trusted(),
            people: self.people.clone(),
            charts: self.charts.clone(),
            sinks: self.sinks.clone(),
            notices: self.notices.clone(),
            compress_after_days: self.archive.compress_after_days,
            compress_months_after_days: self.history.compress_after_days,
            most_unpacked_bytes: self.http.max_unpacked_mib << 20,
        }
    }

    /// Values that are well-formed but not consistent, each with its key and remedy.
    pub fn problems(&self) -> Vec<String> {
        let mut problems = Vec::new();
        let mut check = |good: bool, text: &str| {
            if !good {
                problems.push(text.to_owned());
            }
        };
        check(
            !self.data.as_os_str().is_empty(),
            "data is empty: name the folder of archive, history and people, like lutra-data",
        );
        check(self.http.max_upload_mib > 0, "http.max_upload_mib must be 1 or more");
        check(
            (1..=1 << 40).contains(&self.http.max_unpacked_mib),
            "http.max_unpacked_mib must be 1 or more, and a size that disks have",
        );
        check(
            self.tls.certificate.as_os_str().is_empty() == self.tls.key.as_os_str().is_empty(),
            "tls.certificate and tls.key belong together: give both or neither (`lutra-server tls init` makes a pair)",
        );
        check(
            self.tls.is_given() || self.http.listen.ip().is_loopback() || self.http.plain_beyond_loopback,
            "http.listen is beyond loopback without TLS, so passwords would travel readably: run `lutra-server tls \
             init` and set tls.certificate and tls.key, or set http.plain_beyond_loopback = true behind a VPN",
        );
        check(
            (8..=256).contains(&self.people.password_length),
            "people.password_length must be 8 to 256 characters",
        );
        check(
            (1..=24 * 365).contains(&self.people.session_idle_h),
            "people.session_idle_h must be 1 hour to a year",
        );
        check((1..=365).contains(&self.people.session_days), "people.session_days must be 1 to 365");
        check((8..=65_536).contains(&self.http.max_connections), "http.max_connections must be 8 to 65536");
        for (key, depth_m) in
            [("navigable_m", self.charts.navigable_m), ("autonomous_m", self.charts.autonomous_m)]
        {
            check((0.1..=100.0).contains(&depth_m), &format!("charts.{key} must be 0.1 to 100 m"));
        }
        check(
            self.charts.navigable_m <= self.charts.autonomous_m,
            "charts.navigable_m must not be more than charts.autonomous_m",
        );
        check((0.0..=100.0).contains(&self.charts.air_draught_m), "charts.air_draught_m must be 0 to 100 m");
        check((1..=4096).contains(&self.charts.tiles_mib), "charts.tiles_mib must be 1 to 4096 MiB");
        check((1..=24 * 365).contains(&self.backup.every_h), "backup.every_h must be 1 hour to a year");
        let Keep { history_days, archive_days } = self.retention;
        check(
            archive_days == 0 || archive_days >= LEAST_ARCHIVE_DAYS,
            &format!(
                "retention.archive_days is {archive_days}: it must be 0 (keep for ever) or {LEAST_ARCHIVE_DAYS} and more; it counts \
                 days with recordings, and what goes is lost. Who wants less does it by hand: lutra-server prune --archive-before \
                 DATE"
            ),
        );
        check(
            history_days == 0 || history_days >= store::DAYS_A_MONTH,
            &format!(
                "retention.history_days is {history_days}: it must be 0 (keep for ever) or {} and more; it counts days with \
                 recordings, by whole months",
                store::DAYS_A_MONTH
            ),
        );
        check(
            self.log.level.parse::<tracing_subscriber::filter::Targets>().is_ok(),
            "log.level is neither a level (error, warn, info, debug, trace) nor a list like info,server=debug",
        );
        for origin in &self.http.origins {
            check(
                is_origin(origin),
                &format!(
                    "http.origins: {origin:?} is not an origin; write https://name or https://name:port"
                ),
            );
        }
        let all_may = self.http.cors_origins.iter().any(|origin| origin == "*");
        for origin in self.http.cors_origins.iter().filter(|origin| *origin != "*") {
            check(
                is_origin(origin),
                &format!(
                    "http.cors_origins: {origin:?} is not an origin; write https://name or https://name:port, or `*` alone for all pages"
                ),
            );
        }
        check(
            !all_may || self.http.cors_origins.len() == 1,
            "http.cors_origins: `*` stands for all pages; remove it, or the origins beside it",
        );
        problems.extend(self.imc.problems());
        problems.extend(self.transports.problems());
        problems.extend(self.sinks.problems());
        problems.extend(self.notices.problems());
        problems
    }
}

/// Whether a text is the origin of a web page as browsers send it: scheme, name and port.
fn is_origin(text: &str) -> bool {
    let authority = text.strip_prefix("https://").or_else(|| text.strip_prefix("http://"));
    authority.is_some_and(|rest| !rest.is_empty() && !rest.contains(['/', '*', ' ']))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_documented_file_holds_every_key_at_its_default() {
        let documented: toml::Table = DOCUMENTED.parse().unwrap();
        let defaults = toml::Table::try_from(Config::default()).unwrap();
        assert_eq!(documented, defaults);
    }

    #[test]
    fn the_defaults_make_sense() {
        assert_eq!(Config::default().problems(), Vec::<String>::new());
    }

    #[test]
    fn plain_http_beyond_loopback_must_be_asked_for() {
        let mut config = Config::default();
        config.http.listen = "0.0.0.0:8080".parse().unwrap();
        assert!(config.problems()[0].starts_with("http.listen is beyond loopback"));
        config.http.plain_beyond_loopback = true;
        assert!(config.problems().is_empty());
    }

    #[test]
    fn a_slip_of_the_finger_lets_no_season_go() {
        let mut config = Config::default();
        (config.retention.archive_days, config.retention.history_days) = (36, 3);
        let problems = config.problems();
        assert!(
            problems[0].contains("archive_days is 36") && problems[0].contains("90 and more"),
            "{problems:?}"
        );
        assert!(
            problems[1].contains("history_days is 3") && problems[1].contains("31 and more"),
            "{problems:?}"
        );
        (config.retention.archive_days, config.retention.history_days) = (90, 31);
        assert_eq!(config.problems(), Vec::<String>::new());
    }

    #[test]
    fn topics_and_names_that_a_broker_would_refuse_are_said_with_their_key() {
        for topic in ["", "a//b", "a/#", "+", "$SYS/x", "/a"] {
            let mut config = Config::default();
            config.sinks.mqtt.topic = topic.to_owned();
            assert!(config.problems()[0].starts_with("sinks.mqtt.topic"), "{topic}");
        }
        let mut config = Config::default();
        (config.sinks.mqtt.client_id, config.sinks.mqtt.user) = (" x".to_owned(), "nils".to_owned());
        let problems = config.problems();
        assert!(problems[0].starts_with("sinks.mqtt.client_id") && problems[1].contains("belong together"));
        (config.sinks.mqtt.client_id, config.sinks.mqtt.topic) =
            ("shore-2".to_owned(), "boats/lutra".to_owned());
        config.sinks.mqtt.password_file = PathBuf::from("secret");
        assert_eq!(config.problems(), Vec::<String>::new());
    }

    #[test]
    fn pages_that_may_read_the_api_are_origins_or_all() {
        let problems = |origins: &[&str]| {
            let mut config = Config::default();
            config.http.cors_origins = origins.iter().map(|origin| (*origin).to_owned()).collect();
            config.problems()
        };
        for good in [&[][..], &["*"], &["http://localhost:8888", "https://notebooks.example.org"]] {
            assert_eq!(problems(good), Vec::<String>::new(), "{good:?}");
        }
        for bad in ["null", "localhost:8888", "https://", "https://x.org/", "https://*.example.org"] {
            assert!(problems(&[bad])[0].starts_with("http.cors_origins: "), "{bad}");
        }
        assert!(problems(&["*", "https://x.org"])[0].contains("stands for all pages"));
    }

    #[test]
    fn every_problem_is_told_at_once() {
        let mut config = Config::default();
        config.tls.key = PathBuf::from("key.pem");
        (config.data, config.http.max_upload_mib) = (PathBuf::new(), 0);
        config.people.password_length = 3;
        config.http.origins = vec!["lutra.example.org".to_owned()];
        assert_eq!(config.problems().len(), 5);
    }
}
