//! State of app.db and of the fleet's folder, before anything is changed.

use super::files::Files;
use anyhow::{Context as _, bail};
use api::Vessel;
use provision::Fleet;
use shore::identity::{Fault, Line, Request as _, audit, links, vessels, with};
use std::path::Path;
use units::UtcTime;

/// The action of the audit log with which a vessel's secrets leave the server.
pub(super) const BUNDLE: &str = "fleet.bundle";

/// What app.db has.
#[derive(Debug, Default)]
pub(super) struct Known {
    /// Vessels that have names.
    pub(super) vessels: Vec<Vessel>,
    /// Vessels (IMC addresses) that have a valid token.
    pub(super) open: Vec<u16>,
    /// Vessels of the fleet, by name, whose stored token is valid.
    pub(super) good: Vec<String>,
    /// Whether a bundle was ever made here.
    pub(super) bundled: bool,
}

impl Known {
    /// Reads the state; does not create app.db.
    pub(super) fn look(data: &Path, files: &Files, fleet: &Fleet, now: UtcTime) -> anyhow::Result<Self> {
        let mut kept = Vec::new();
        for vessel in &fleet.vessels {
            if let Some(secret) = files.token(&vessel.name)? {
                kept.push((vessel.name.clone(), links::Opens { secret, vessel: vessel.imc_address, now }));
            }
        }
        if !data.join("app.db").exists() {
            return Ok(Self::default());
        }
        Ok(with(data, async |db| {
            let mut good = Vec::new();
            for (name, opens) in kept {
                if opens.run(db).await?.is_some() {
                    good.push(name);
                }
            }
            let made =
                audit::Entries { count: 1, action: Some(BUNDLE.to_owned()), ..audit::Entries::default() };
            let bundled = !made.run(db).await?.is_empty();
            Ok(Self {
                vessels: vessels::List.run(db).await?,
                open: links::Open(now).run(db).await?,
                good,
                bundled,
            })
        })?)
    }
}

/// The fleet file that was applied last.
///
/// # Errors
/// No fleet file was applied yet, or it cannot be read.
pub(super) fn applied(files: &Files) -> anyhow::Result<Fleet> {
    let path = files.applied();
    let text = super::files::read(&path)?
        .context("no fleet file was applied: `lutra-server fleet apply FILE` first")?;
    match Fleet::read(&text) {
        Ok(fleet) => Ok(fleet),
        Err(problems) => {
            let first = problems.first().map(ToString::to_string).unwrap_or_default();
            bail!("{} cannot be read ({first}): apply the fleet file again", path.display())
        }
    }
}

/// A line of the audit log.
pub(super) fn line(action: &'static str, subject: &str) -> Line {
    let by = || "command line".to_owned();
    Line { actor: by(), address: by(), action, subject: subject.to_owned(), outcome: "done".to_owned() }
}

/// Random bytes.
///
/// # Errors
/// The kernel gives no random bytes.
pub(super) fn random<const BYTES: usize>() -> anyhow::Result<[u8; BYTES]> {
    let mut bytes = [0; BYTES];
    getrandom::fill(&mut bytes).context("the kernel gives no randomness")?;
    Ok(bytes)
}

/// What to say where a key of the VPN is absent.
pub(super) fn no_key(name: &str) -> String {
    format!("{name} has no VPN key that is good: `lutra-server fleet apply` makes another")
}

/// A file error within a change of app.db, which rolls the change back.
pub(super) fn refused(error: &anyhow::Error) -> Fault {
    let with_causes = format!("{error:#}");
    Fault::refused(api::Said::as_is(with_causes))
}
