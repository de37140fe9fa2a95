//! `lutra-server prune`: removes old recordings.

use super::Common;
use super::data::folder;
use super::say::{complain, say};
use crate::retention::{self, Next, Verdict};
use anyhow::bail;
use clap::Args;
use shore::clock;
use std::process::ExitCode;
use store::{Removal, Retention, Store};
use units::UtcTime;

#[derive(Debug, Args)]
#[command(
    after_help = "Ends with 0 if something went or would go (without --check also if there was nothing to do), with 1 if \
                        --check finds nothing to do, and with 255 if a person must look."
)]
pub(super) struct PruneArguments {
    /// Remove months of the history that ended before this day.
    #[arg(long, value_name = "DATE")]
    history_before: Option<UtcTime>,
    /// Remove days of the archive that ended before this day. Data that are only there are lost for ever.
    #[arg(long, value_name = "DATE")]
    archive_before: Option<UtcTime>,
    /// Remove what exceeds `[retention]` of the configuration: for a timer. Removes only what the backup holds.
    #[arg(long, conflicts_with_all = ["history_before", "archive_before"])]
    as_configured: bool,
    /// Only end with 0 if something would be removed, with 1 if nothing, with 255 if a person must look. The server may
    /// run.
    #[arg(long, conflicts_with = "yes")]
    check: bool,
    /// Do it. Without this, only print what would be removed.
    #[arg(long)]
    yes: bool,
}

/// Runs the command.
pub(super) fn prune(common: &Common, arguments: &PruneArguments) -> ExitCode {
    let outcome =
        if arguments.as_configured { unattended(common, arguments) } else { by_date(common, arguments) };
    match outcome {
        Ok(false) if arguments.check => ExitCode::FAILURE,
        Ok(_) => ExitCode::SUCCESS,
        Err(error) => {
            complain!("lutra-server: {}", super::told(&error));
            ExitCode::from(super::LOOK)
        }
    }
}

/// Returns whether anything was removed, or would be.
fn by_date(common: &Common, arguments: &PruneArguments) -> anyhow::Result<bool> {
    let data = folder(common)?;
    let PruneArguments { history_before, archive_before, yes, .. } = *arguments;
    let retention = Retention { history_before, archive_before };
    if retention == Retention::default() {
        bail!(
            "say what may go: --history-before DATE, --archive-before DATE or both; or --as-configured, with history_days or \
             archive_days in [retention] of the configuration"
        );
    }
    let removals =
        if yes { Store::open(&data)?.retain(&retention)? } else { store::plan_retention(&data, &retention)? };
    tell(&removals, arguments);
    Ok(!removals.is_empty())
}

fn unattended(common: &Common, arguments: &PruneArguments) -> anyhow::Result<bool> {
    folder(common)?;
    let config = common.load(Vec::new())?;
    // Opened before the check, so that no other program writes meanwhile.
    let mut store = if arguments.yes { Some(Store::open(&config.data)?) } else { None };
    let Next { verdict, notes } = retention::next(&config, clock::now(), true)?;
    for note in notes {
        complain!("note: {note}");
    }
    let removals = match verdict {
        Verdict::Off => {
            complain!(
                "all is kept: [retention] of the configuration has neither history_days nor archive_days"
            );
            return Ok(false);
        }
        Verdict::Nothing => {
            complain!("no recordings are old enough to be deleted");
            return Ok(false);
        }
        Verdict::Refused(why) => bail!("nothing was removed: {why}"),
        Verdict::Goes(removals) => removals,
    };
    if let Some(store) = &mut store {
        store.remove(&removals)?;
    }
    tell(&removals, arguments);
    Ok(true)
}

fn tell(removals: &[Removal], arguments: &PruneArguments) {
    let word = if arguments.yes { "removed" } else { "would remove" };
    for removal in removals {
        say!("{word} {} ({} MiB)", removal.path.display(), removal.bytes >> 20);
    }
    let bytes: u64 = removals.iter().map(|removal| removal.bytes).sum();
    say!("{word} {} items, {} MiB", removals.len(), bytes >> 20);
    if !arguments.yes && !removals.is_empty() {
        say!("nothing was removed; add --yes to do it");
    }
}
