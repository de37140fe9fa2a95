//! Reads a fleet file and checks it against the agent's parameters and the server's configuration.

use crate::cli::Common;
use crate::cli::say::{complain, say};
use crate::config::Config;
use anyhow::{Context as _, bail};
use provision::{BASE_FILE, Fleet, Vessel, overlay};
use std::path::Path;

/// Name of the overlay during the check.
const OVERLAY: &str = "vessel.ini";

/// `lutra-server fleet check`.
pub(super) fn check(common: &Common, file: &Path) -> anyhow::Result<()> {
    let (fleet, _) = read(file)?;
    for doubt in doubts(&fleet, &common.load(Vec::new())?) {
        complain!("note: {doubt}");
    }
    let count = fleet.vessels.len();
    let s = if count == 1 { "" } else { "s" };
    say!("{}: {count} vessel{s}, nothing wrong", file.display());
    for vessel in &fleet.vessels {
        say!("{}\t0x{:04X}\t{}", vessel.name, vessel.imc_address, vessel.vpn_address);
    }
    Ok(())
}

/// A fleet file and its text.
///
/// # Errors
/// Everything that is wrong with it.
pub(super) fn read(file: &Path) -> anyhow::Result<(Fleet, String)> {
    let size = std::fs::metadata(file).with_context(|| format!("cannot read {}", file.display()))?.len();
    if size > provision::MAX_FILE_BYTES as u64 {
        bail!("{} is too large for a fleet file ({size} bytes)", file.display());
    }
    let text = std::fs::read_to_string(file).with_context(|| format!("cannot read {}", file.display()))?;
    let problems = match Fleet::read(&text) {
        Ok(fleet) => {
            let problems: Vec<String> =
                fleet.vessels.iter().flat_map(|vessel| refused_aboard(&fleet, vessel)).collect();
            if problems.is_empty() {
                return Ok((fleet, text));
            }
            problems
        }
        Err(problems) => problems.iter().map(ToString::to_string).collect(),
    };
    for problem in &problems {
        complain!("{}: {problem}", file.display());
    }
    let s = if problems.len() == 1 { "" } else { "s" };
    bail!("{} problem{s} in {}; nothing was done", problems.len(), file.display())
}

/// Errors that the agent would report for a vessel's overlay.
fn refused_aboard(fleet: &Fleet, vessel: &Vessel) -> Vec<String> {
    let text = overlay(fleet, vessel, "lutra.token", fleet.server.encrypted.then_some("ca.pem"));
    let base = match config::documented_ini(&config::Vessel::default()) {
        Ok(base) => base,
        Err(error) => return vec![format!("{error}")],
    };
    let files = config::InMemory::new().with(BASE_FILE, base).with(OVERLAY, text);
    let read = config::Config::load(&files, Path::new(OVERLAY), &[vessel.profile.name()]);
    let name = &vessel.name;
    let problems = read.report().problems().iter().filter(|problem| is_refusal(problem));
    let mut told: Vec<String> =
        problems.map(|problem| format!("vessel {name}: its agent refuses this: {problem}")).collect();
    if (read.vehicle(), read.address()) != (name, Some(vessel.imc_address)) {
        told.push(format!("vessel {name}: its settings give it another name or address: take them out"));
    }
    told
}

/// An error, or a warning about the overlay itself: an unknown parameter has no effect aboard.
fn is_refusal(problem: &config::Problem) -> bool {
    let own = problem.place.as_ref().is_some_and(|place| &*place.file == OVERLAY);
    match problem.severity {
        config::Severity::Error => true,
        config::Severity::Warning => own,
        config::Severity::Note => false,
    }
}

/// Mismatches of file and server.
pub(super) fn doubts(fleet: &Fleet, config: &Config) -> Vec<String> {
    let mut doubts = Vec::new();
    let (listen, server) = (config.http.listen, &fleet.server);
    let inside = fleet.vpn.server_address;
    if config.tls.is_given() != server.encrypted {
        doubts.push(if server.encrypted {
            "the fleet file has server.encrypted = true, and this server has no certificate: `lutra-server tls init \
             --name` with the server's address in the VPN makes one"
                .to_owned()
        } else {
            "this server speaks TLS (tls.certificate): write server.encrypted = true in the fleet file".to_owned()
        });
    }
    let heard = listen.ip().is_unspecified() || listen.ip() == std::net::IpAddr::from(inside);
    if listen.port() != server.link_port || !heard {
        doubts.push(format!(
            "vessels will look for the link at {inside}:{}, and this server listens on {listen}: set http.listen, or \
             server.link_port in the fleet file",
            server.link_port
        ));
    }
    doubts
}
