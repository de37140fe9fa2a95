//! `lutra-server doctor`: checks the server and its data, and prints remedies.

use super::say::{complain, say};
use super::{Common, files};
use crate::backups;
use crate::config::Config;
use crate::doctor::{check, look};
use clap::Args;
use service::report::{Finding, Status, to_json, worst};
use shore::clock;
use std::process::ExitCode;
use store::{Check, Health};

#[derive(Debug, Args)]
pub(super) struct DoctorArguments {
    /// Read the whole archive and every page of the history, too. Takes long.
    #[arg(long)]
    thorough: bool,
    /// Print JSON for monitoring, and end with 0 when all is well, 1 for a warning, 2 when something must be fixed. Without
    /// it: 1 when something must be fixed, else 0.
    #[arg(long)]
    json: bool,
}

/// Prints a line for each check, or JSON.
pub(super) fn doctor(common: &Common, arguments: &DoctorArguments) -> ExitCode {
    let checks = match common.load(Vec::new()) {
        Ok(config) => {
            let mut checks = vec![check("configuration", Ok("understood".to_owned()))];
            checks.push(check("address", address(&config)));
            checks.push(check("open files", files::raise(&config)));
            let backup = |config: &Config| backups::checks(config, clock::now());
            checks.extend(look(&config, arguments.thorough, backup));
            checks
        }
        Err(error) => vec![check("configuration", Err(format!("{error:#}")))],
    };
    let findings: Vec<Finding> = checks.into_iter().map(finding).collect();
    if arguments.json {
        let now = clock::written(clock::now());
        say!("{}", to_json("lutra-server", env!("CARGO_PKG_VERSION"), &now, &findings));
        return ExitCode::from(worst(&findings).exit_code());
    }
    for Finding { part, status, text, remedy } in &findings {
        let text = if remedy.is_empty() { text.clone() } else { format!("{text}: {remedy}") };
        say!("{:<5} {part}: {text}", word(*status));
    }
    match findings.iter().filter(|one| one.status == Status::Fail).count() {
        0 => return ExitCode::SUCCESS,
        1 => complain!("lutra-server: 1 thing is not well"),
        more => complain!("lutra-server: {more} things are not well"),
    }
    ExitCode::FAILURE
}

fn finding(Check { name, health, found, remedy }: Check) -> Finding {
    let status = match health {
        Health::Good => Status::Ok,
        Health::Warning => Status::Warn,
        Health::Problem => Status::Fail,
    };
    Finding { part: name, status, text: found, remedy }
}

/// The word for people.
const fn word(status: Status) -> &'static str {
    match status {
        Status::Ok => "ok",
        Status::Warn => "WARN",
        Status::Fail => "BAD",
    }
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
