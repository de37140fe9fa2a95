//! `lutra-server doctor`: looks whether all is well, and says what to do where it is not.

use super::say::say;
use super::{Common, files};
use crate::config::Config;
use crate::people::{self, persons};
use crate::{clock, tls};
use anyhow::bail;
use api::Role;
use clap::Args;
use store::{Check, Health};
use units::UtcTime;

/// Before this the clock cannot be right: 2024-01-01.
const EARLIEST: UtcTime = UtcTime::from_micros(1_704_067_200_000_000);

#[derive(Debug, Args)]
pub(super) struct DoctorArguments {
    /// Read the whole archive and every page of the history, too. Takes long.
    #[arg(long)]
    thorough: bool,
}

/// Prints a line for each thing looked at.
///
/// # Errors
/// Something is not well.
pub(super) fn doctor(common: &Common, arguments: &DoctorArguments) -> anyhow::Result<()> {
    let mut bad = 0;
    let mut tell = |name: &str, outcome: Result<String, String>| match outcome {
        Ok(text) => say!("ok    {name}: {text}"),
        Err(text) => {
            bad += 1;
            say!("BAD   {name}: {text}");
        }
    };
    let config = match common.load(Vec::new()) {
        Ok(config) => config,
        Err(error) => {
            tell("configuration", Err(format!("{error:#}")));
            bail!("1 thing is not well");
        }
    };
    tell("configuration", Ok("understood".to_owned()));
    tell("clock", clock_is_right());
    tell("people", people_are_well(&config));
    tell("encryption", encryption(&config));
    tell("address", address(&config));
    tell("pages", pages());
    tell("open files", files::raise(&config));
    if !config.data.exists() {
        tell("data folder", Ok(no_folder(&config)));
    }
    for check in recordings(&config, arguments.thorough) {
        let found =
            if check.remedy.is_empty() { check.found } else { format!("{}: {}", check.found, check.remedy) };
        match check.health {
            Health::Good => tell(check.name, Ok(found)),
            Health::Warning => say!("WARN  {}: {found}", check.name),
            Health::Problem => tell(check.name, Err(found)),
        }
    }
    match bad {
        0 => Ok(()),
        1 => bail!("1 thing is not well"),
        more => bail!("{more} things are not well"),
    }
}

/// The archive and the history.
fn recordings(config: &Config, thorough: bool) -> Vec<Check> {
    if !config.data.exists() {
        return Vec::new();
    }
    store::doctor(&config.data, clock::now(), thorough, &mut |_| true).unwrap_or_else(|error| {
        let remedy = "look whether the folder can be read".to_owned();
        vec![Check { name: "recordings", health: Health::Problem, found: error.to_string(), remedy }]
    })
}

/// Not bad before the first start, and a slip of the finger after it.
fn no_folder(config: &Config) -> String {
    let folder = config.data.display();
    format!(
        "there is no {folder} yet: the first start makes it; if there should be one, look at --data or `data`"
    )
}

fn clock_is_right() -> Result<String, String> {
    let now = clock::now();
    if now < EARLIEST {
        return Err(format!(
            "{} cannot be: set it, or let chrony or systemd-timesyncd do so",
            clock::written(now)
        ));
    }
    Ok(clock::written(now))
}

fn people_are_well(config: &Config) -> Result<String, String> {
    if !config.data.join("app.db").exists() {
        return Ok(format!("none yet; the first start makes an admin in {}", config.data.display()));
    }
    let db = people::open(&config.data).map_err(|error| error.to_string())?;
    let verdict: String = db
        .query_row("PRAGMA quick_check", [], |row| row.get(0))
        .map_err(|error| format!("app.db: {error}"))?;
    if verdict != "ok" {
        return Err(format!("app.db is damaged ({verdict}): stop the server and put a backup in its place"));
    }
    let people = persons::list(&db).map_err(|error| error.to_string())?;
    let waiting = people.iter().filter(|person| person.must_change_password).count();
    let admin = |person: &&api::Person| {
        person.permissions.iter().any(|given| given.vessel.is_none() && given.role == Role::Admin)
    };
    let admins = people.iter().filter(admin).count();
    Ok(format!("{} accounts, {admins} of them admins, {waiting} with a one-time password", people.len()))
}

fn encryption(config: &Config) -> Result<String, String> {
    if !config.tls.is_given() {
        return Ok("none; the server serves loopback or a VPN".to_owned());
    }
    tls::acceptor(&config.tls).map_err(|error| format!("{error:#}"))?;
    Ok(format!("{} and its key fit", config.tls.certificate.display()))
}

fn address(config: &Config) -> Result<String, String> {
    let listen = config.http.listen;
    match std::net::TcpListener::bind(listen) {
        Ok(_) => Ok(format!("{listen} is free")),
        Err(error) if error.kind() == std::io::ErrorKind::AddrInUse => {
            Ok(format!("{listen} is in use, as it is while a server runs"))
        }
        Err(error) => Err(format!("{listen}: {error}; choose another by http.listen")),
    }
}

fn pages() -> Result<String, String> {
    if crate::http::asset_path("main.css").is_empty() {
        return Err(
            "this program was built without scripts and styles: run `make web` and build it again".to_owned()
        );
    }
    Ok("scripts and styles are there".to_owned())
}
