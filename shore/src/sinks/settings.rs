//! Other stores that get everything the archive has.

use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Stores beside the history.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Sinks {
    /// An InfluxDB.
    pub influx: Influx,
    /// A broker of MQTT.
    pub mqtt: Mqtt,
    /// A PostgreSQL.
    pub postgres: Postgres,
}

impl Sinks {
    /// What makes no sense.
    pub fn problems(&self) -> Vec<String> {
        [self.influx.problems(), self.mqtt.problems(), self.postgres.problems()].concat()
    }

    /// Files that are named; some hold secrets.
    pub fn files(&self) -> [&PathBuf; 7] {
        let (influx, mqtt, postgres) = (&self.influx, &self.mqtt, &self.postgres);
        [
            &influx.token_file,
            &influx.password_file,
            &influx.ca_file,
            &mqtt.password_file,
            &mqtt.ca_file,
            &postgres.password_file,
            &postgres.ca_file,
        ]
    }
}

/// A database of PostgreSQL 12 or later.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Postgres {
    /// `postgres://host:port/database`; empty for none.
    pub url: String,
    /// The schema that holds the tables.
    pub schema: String,
    /// The role that owns them; empty for the account that the server runs under.
    pub user: String,
    /// A file with that role's password.
    pub password_file: PathBuf,
    /// Authorities in PEM that may have signed its certificate; empty: the connection is not encrypted.
    pub ca_file: PathBuf,
}

impl Default for Postgres {
    fn default() -> Self {
        Self {
            url: String::new(),
            schema: "lutra".to_owned(),
            user: String::new(),
            password_file: PathBuf::new(),
            ca_file: PathBuf::new(),
        }
    }
}

impl Postgres {
    /// The longest name that PostgreSQL does not cut off.
    const LONGEST_NAME: usize = 63;

    fn problems(&self) -> Vec<String> {
        let mut problems = Vec::new();
        let is_name = |sign: char| sign.is_ascii_lowercase() || sign.is_ascii_digit() || sign == '_';
        let schema = &self.schema;
        if !(1..=Self::LONGEST_NAME).contains(&schema.len())
            || !schema.chars().all(is_name)
            || schema.starts_with(|sign: char| sign.is_ascii_digit())
            || schema.starts_with("pg_")
        {
            problems.push(
                "sinks.postgres.schema must be a name like lutra: 1 to 63 of a to z, digits and _, no digit and no pg_ before"
                    .to_owned(),
            );
        }
        if self.user.is_empty() && !self.password_file.as_os_str().is_empty() {
            problems.push(
                "sinks.postgres.password_file is set and user is not: name the role whose password it is"
                    .to_owned(),
            );
        }
        problems
    }
}

/// A broker of MQTT 5.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Mqtt {
    /// `mqtt://host:port` or `mqtts://host:port`; empty for none.
    pub url: String,
    /// The first levels of all topics.
    pub topic: String,
    /// How the server calls itself there; no other client may be called so.
    pub client_id: String,
    /// The user; empty for none.
    pub user: String,
    /// A file with that user's password.
    pub password_file: PathBuf,
    /// Authorities in PEM that are trusted when the URL is `mqtts`.
    pub ca_file: PathBuf,
    /// Whether what was recorded before is published too.
    pub from_beginning: bool,
}

impl Default for Mqtt {
    fn default() -> Self {
        Self {
            url: String::new(),
            topic: "lutra".to_owned(),
            client_id: "lutra-server".to_owned(),
            user: String::new(),
            password_file: PathBuf::new(),
            ca_file: PathBuf::new(),
            from_beginning: false,
        }
    }
}

impl Mqtt {
    fn problems(&self) -> Vec<String> {
        let mut problems = Vec::new();
        let mut check = |good: bool, text: &str| {
            if !good {
                problems.push(text.to_owned());
            }
        };
        let level = |level: &str| !level.is_empty() && !level.contains(['+', '#', '\0']);
        check(
            self.topic.split('/').all(level) && !self.topic.starts_with('$') && self.topic.len() <= 1_000,
            "sinks.mqtt.topic must be a topic like lutra or boats/lutra: no empty level, no + and #, no $ before it",
        );
        let is_name = |sign: char| sign.is_ascii_alphanumeric() || "-_.".contains(sign);
        check(
            (1..=64).contains(&self.client_id.len()) && self.client_id.chars().all(is_name),
            "sinks.mqtt.client_id must be 1 to 64 letters, digits, -, _ and .",
        );
        check(
            self.user.is_empty() == self.password_file.as_os_str().is_empty(),
            "sinks.mqtt.user and password_file belong together: give both or neither",
        );
        problems
    }
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
    fn problems(&self) -> Vec<String> {
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
