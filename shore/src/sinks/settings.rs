//! Other stores that get everything the archive has.

use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Stores beside the history.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Sinks {
    /// An InfluxDB.
    pub influx: Influx,
}

/// An InfluxDB, or what speaks its version 1 API.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Influx {
    /// `http://host:port`; empty for none.
    pub url: String,
    /// The database; of version 2, the bucket that its mapping gives.
    pub database: String,
    /// A file with a token; empty for none.
    pub token_file: PathBuf,
    /// The user of version 1; empty for none.
    pub user: String,
    /// A file with that user's password.
    pub password_file: PathBuf,
    /// Authorities in PEM that are trusted when the URL is `https`.
    pub ca_file: PathBuf,
}

impl Default for Influx {
    fn default() -> Self {
        Self {
            url: String::new(),
            database: "lutra".to_owned(),
            token_file: PathBuf::new(),
            user: String::new(),
            password_file: PathBuf::new(),
            ca_file: PathBuf::new(),
        }
    }
}

impl Influx {
    /// What makes no sense.
    pub fn problems(&self) -> Vec<String> {
        let mut problems = Vec::new();
        if !self.url.is_empty() && self.database.is_empty() {
            problems
                .push("sinks.influx.database is empty: name the database that takes the lines".to_owned());
        }
        if self.user.is_empty() != self.password_file.as_os_str().is_empty() {
            problems
                .push("sinks.influx.user and password_file belong together: give both or neither".to_owned());
        }
        if !self.user.is_empty() && !self.token_file.as_os_str().is_empty() {
            problems.push("sinks.influx has a token_file and a user: give one of them".to_owned());
        }
        problems
    }
}
