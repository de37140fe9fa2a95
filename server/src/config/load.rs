//! Reads the configuration: defaults, then the file, then `LUTRA_*` variables, then flags.
//!
//! Implemented here and not with figment: it reports file and key of an error, but neither line nor column, and accepts any
//! variable with the prefix, misspelt ones too.

use super::Config;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// The variable that names the file.
const FILE_VARIABLE: &str = "LUTRA_CONFIG";

/// Why there is no configuration.
#[derive(Debug, Error)]
pub enum ConfigError {
    /// The file cannot be read.
    #[error("configuration {path}: {source}; check the path given by --config or LUTRA_CONFIG")]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        #[source]
        source: std::io::Error,
    },
    /// The file is not TOML, or has an unknown key.
    #[error("configuration {path}: {text}\nEvery key with its meaning: lutra-server config")]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Line, key and what is wrong with it.
        text: String,
    },
    /// A variable or flag names no key, or a value that the key cannot take.
    #[error("{place}: {text}")]
    Override {
        /// Variable or flag.
        place: String,
        /// What is wrong with it.
        text: String,
    },
    /// The values are well-formed but not consistent.
    #[error("the configuration cannot be used:\n  {}", .0.join("\n  "))]
    Senseless(Vec<String>),
}

/// Values from flags and environment that override the file.
#[derive(Debug, Default)]
pub struct Overrides {
    /// `LUTRA_*` variables of the environment.
    pub variables: BTreeMap<String, String>,
    /// `key=value` by flags, the last wins.
    pub flags: Vec<(String, String)>,
}

impl Overrides {
    /// The process's own `LUTRA_*` variables.
    pub fn from_environment() -> Self {
        let ours = |(name, value): (std::ffi::OsString, std::ffi::OsString)| {
            let name = name.into_string().ok()?;
            name.starts_with("LUTRA_").then_some((name, value.into_string().ok()?))
        };
        Self { variables: std::env::vars_os().filter_map(ours).collect(), flags: Vec::new() }
    }
}

/// Reads `file`, if any, lays `overrides` over it and checks the whole.
///
/// # Errors
/// [`ConfigError`], naming file and line, variable or flag, and what to do.
pub fn load(file: Option<&Path>, overrides: &Overrides) -> Result<Config, ConfigError> {
    let mut table = toml::Table::new();
    if let Some(path) = file {
        let text = std::fs::read_to_string(path)
            .map_err(|source| ConfigError::Unreadable { path: path.to_owned(), source })?;
        let malformed = |error: toml::de::Error| ConfigError::Malformed {
            path: path.to_owned(),
            text: error.to_string().trim_end().to_owned(),
        };
        // Parsing into the type gives line and column of an error; the untyped table can be overridden.
        toml::from_str::<Config>(&text).map_err(malformed)?;
        table = text.parse().map_err(malformed)?;
    }
    let keys = keys();
    for (key, default) in &keys {
        let name = variable(key);
        if let Some(value) = overrides.variables.get(&name) {
            lay(&mut table, key, default, value, &name)?;
        }
    }
    misspelt(overrides, &keys)?;
    for (key, value) in &overrides.flags {
        let place = format!("--set {key}={value}");
        let Some((key, default)) = keys.iter().find(|(known, _)| known == key) else {
            return Err(ConfigError::Override { place, text: unknown(key, &keys) });
        };
        lay(&mut table, key, default, value, &place)?;
    }
    let config: Config = table.try_into().map_err(|error: toml::de::Error| ConfigError::Override {
        place: "flags and LUTRA_ variables".to_owned(),
        text: error.to_string(),
    })?;
    let problems = config.problems();
    if problems.is_empty() { Ok(config) } else { Err(ConfigError::Senseless(problems)) }
}

/// Every key as `section.key` or `section.part.key` with its default.
fn keys() -> Vec<(String, toml::Value)> {
    let defaults = toml::Table::try_from(Config::default()).expect("invariant: the defaults are TOML");
    leaves(defaults, "")
}

fn leaves(table: toml::Table, prefix: &str) -> Vec<(String, toml::Value)> {
    let mut keys = Vec::new();
    for (name, value) in table {
        match value {
            toml::Value::Table(section) => keys.extend(leaves(section, &format!("{prefix}{name}."))),
            value => keys.push((format!("{prefix}{name}"), value)),
        }
    }
    keys
}

fn variable(key: &str) -> String {
    format!("LUTRA_{}", key.replace('.', "_").to_uppercase())
}

/// Refuses a variable that is nearly one of ours. Unknown ones may belong to other programs.
fn misspelt(overrides: &Overrides, keys: &[(String, toml::Value)]) -> Result<(), ConfigError> {
    let known: Vec<String> =
        keys.iter().map(|(key, _)| variable(key)).chain([FILE_VARIABLE.to_owned()]).collect();
    for name in overrides.variables.keys().filter(|name| !known.contains(name)) {
        if let Some(near) = known.iter().find(|known| suggest::distance(known, name) <= 2) {
            let text = format!("there is no such variable; is {near} meant?");
            return Err(ConfigError::Override { place: name.clone(), text });
        }
    }
    Ok(())
}

fn unknown(key: &str, keys: &[(String, toml::Value)]) -> String {
    let near = keys.iter().min_by_key(|(known, _)| suggest::distance(known, key));
    let near = near.map(|(known, _)| known.as_str()).unwrap_or_default();
    format!("there is no key {key}; the nearest is {near} (all: lutra-server config)")
}

/// Puts `text` at `key`, read as the type of its default.
fn lay(
    table: &mut toml::Table,
    key: &str,
    default: &toml::Value,
    text: &str,
    place: &str,
) -> Result<(), ConfigError> {
    let wrong = |expected: &str| ConfigError::Override {
        place: place.to_owned(),
        text: format!("{text:?} is not {expected}"),
    };
    let value = match default {
        toml::Value::Integer(_) => toml::Value::Integer(text.parse().map_err(|_| wrong("a whole number"))?),
        toml::Value::Boolean(_) => toml::Value::Boolean(text.parse().map_err(|_| wrong("true or false"))?),
        toml::Value::Array(list) => {
            let parts = text.split(',').map(str::trim).filter(|part| !part.is_empty());
            let numbers = matches!(list.first(), Some(toml::Value::Integer(_)));
            let item = |part: &str| match part.parse() {
                Ok(number) if numbers => Ok(toml::Value::Integer(number)),
                Err(_) if numbers => Err(wrong("a list of whole numbers")),
                _ => Ok(toml::Value::String(part.to_owned())),
            };
            toml::Value::Array(parts.map(item).collect::<Result<_, _>>()?)
        }
        _ => toml::Value::String(text.to_owned()),
    };
    let mut alone = toml::Table::new();
    insert(&mut alone, key, value.clone());
    // Read alone first, so that an error can name this variable or flag.
    alone.try_into::<Config>().map_err(|error: toml::de::Error| ConfigError::Override {
        place: place.to_owned(),
        text: format!("{key}: {}", error.message()),
    })?;
    insert(table, key, value);
    Ok(())
}

fn insert(table: &mut toml::Table, key: &str, value: toml::Value) {
    let Some((section, rest)) = key.split_once('.') else {
        table.insert(key.to_owned(), value);
        return;
    };
    let section = table.entry(section).or_insert_with(|| toml::Value::Table(toml::Table::new()));
    if let toml::Value::Table(section) = section {
        insert(section, rest, value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(text: &str) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("server.toml");
        std::fs::write(&path, text).unwrap();
        (folder, path)
    }

    fn flags(flags: &[(&str, &str)]) -> Overrides {
        let owned = flags.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned()));
        Overrides { variables: BTreeMap::new(), flags: owned.collect() }
    }

    #[test]
    fn flags_win_over_variables_over_the_file() {
        let (_folder, path) = file("[http]\nlisten = '127.0.0.1:1'\nmax_connections = 100\n");
        let mut overrides = flags(&[("http.listen", "127.0.0.1:3")]);
        overrides.variables.insert("LUTRA_HTTP_LISTEN".to_owned(), "127.0.0.1:2".to_owned());
        overrides.variables.insert("LUTRA_DATA".to_owned(), "/srv/lutra".to_owned());
        let config = load(Some(&path), &overrides).unwrap();
        assert_eq!(config.http.listen.port(), 3);
        assert_eq!(config.http.max_connections, 100);
        assert_eq!(config.data, PathBuf::from("/srv/lutra"));
    }

    #[test]
    fn keys_of_parts_and_lists_of_numbers_are_laid_over() {
        let overrides = flags(&[
            ("transports.imcproxy.listen", "127.0.0.1:9090"),
            ("transports.udp.announce_ports", "1, 2"),
        ]);
        let config = load(None, &overrides).unwrap();
        assert_eq!(config.transports.imcproxy.listen.get().unwrap().port(), 9090);
        assert_eq!(config.transports.udp.announce_ports, [1, 2]);
        let text = load(None, &flags(&[("transports.udp.announce_ports", "1,x")])).unwrap_err().to_string();
        assert!(text.contains("a list of whole numbers"), "{text}");
    }

    #[test]
    fn an_unknown_key_names_file_line_and_what_is_known() {
        let (_folder, path) = file("[http]\nlisten = '127.0.0.1:1'\nlistn = 3\n");
        let text = load(Some(&path), &Overrides::default()).unwrap_err().to_string();
        assert!(text.contains("server.toml") && text.contains("line 3") && text.contains("listn"), "{text}");
        assert!(text.contains("`listen`"), "{text}");
    }

    #[test]
    fn a_wrong_value_names_its_flag() {
        let text = load(None, &flags(&[("http.listen", "everywhere")])).unwrap_err().to_string();
        assert!(text.contains("--set http.listen=everywhere"), "{text}");
        let text = load(None, &flags(&[("people.session_days", "some")])).unwrap_err().to_string();
        assert!(text.contains("whole number"), "{text}");
        let text = load(None, &flags(&[("http.listn", "x")])).unwrap_err().to_string();
        assert!(text.contains("nearest is http.listen"), "{text}");
    }

    #[test]
    fn a_misspelt_variable_is_told() {
        let with = |name: &str| {
            let variables = [(name.to_owned(), "x".to_owned())].into();
            load(None, &Overrides { variables, flags: Vec::new() })
        };
        assert!(with("LUTRA_HTTP_LISTN").unwrap_err().to_string().contains("LUTRA_HTTP_LISTEN meant"));
        assert!(with("LUTRA_CONFIG").is_ok() && with("LUTRA_ANYTHING_ELSE").is_ok());
    }

    #[test]
    fn lists_are_separated_by_commas() {
        let config = load(None, &flags(&[("http.trusted_proxies", "127.0.0.1, ::1")])).unwrap();
        assert_eq!(config.http.trusted_proxies.len(), 2);
    }
}
