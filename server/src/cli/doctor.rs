//! `lutra-server doctor`: looks whether all is well, and says what to do where it is not.

use super::say::say;
use super::{Common, files};
use crate::config::Config;
use crate::doctor::{check, look};
use anyhow::bail;
use clap::Args;
use store::{Check, Health};

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
    let checks = match common.load(Vec::new()) {
        Ok(config) => {
            let mut checks = vec![check("configuration", Ok("understood".to_owned()))];
            checks.push(check("address", address(&config)));
            checks.push(check("open files", files::raise(&config)));
            checks.extend(look(&config, arguments.thorough));
            checks
        }
        Err(error) => vec![check("configuration", Err(format!("{error:#}")))],
    };
    let mut bad = 0;
    for Check { name, health, found, remedy } in checks {
        let found = if remedy.is_empty() { found } else { format!("{found}: {remedy}") };
        match health {
            Health::Good => say!("ok    {name}: {found}"),
            Health::Warning => say!("WARN  {name}: {found}"),
            Health::Problem => {
                bad += 1;
                say!("BAD   {name}: {found}");
            }
        }
    }
    match bad {
        0 => Ok(()),
        1 => bail!("1 thing is not well"),
        more => bail!("{more} things are not well"),
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
