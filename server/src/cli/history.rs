//! `lutra-server history`: compress months that are over.

use super::data::{Progress, folder};
use super::say::{complain, say};
use super::{Common, compress};
use anyhow::{Context as _, ensure};
use clap::{Args, Subcommand};
use std::path::Path;
use store::{CompressedMonth, PackableMonth, PackedMonth, Store, plan_months};

#[derive(Debug, Subcommand)]
pub(super) enum HistoryCommand {
    /// Compress months that are over. The server must not run.
    ///
    /// A month is compressed into a new file, read back against the old one message by message, and only then takes its place. Pages,
    /// exports and backups read either; by SQL the messages of a compressed month cannot be read. Earlier versions of Lutra leave a
    /// history with such a month alone.
    Compress(CompressArguments),
}

#[derive(Debug, Args)]
pub(super) struct CompressArguments {
    /// Months that ended so many days ago or before [default: history.compress_after_days of the configuration].
    #[arg(long, value_name = "DAYS")]
    after_days: Option<u16>,
    /// Only print which months would be compressed. The server may run.
    #[arg(long)]
    dry_run: bool,
}

/// Runs the command.
pub(super) fn history(common: &Common, command: &HistoryCommand) -> anyhow::Result<()> {
    let HistoryCommand::Compress(arguments) = command;
    let data = folder(common)?;
    let configured = common.load(Vec::new())?.history.compress_after_days;
    let (after_days, now) =
        compress::when(arguments.after_days, ("history.compress_after_days", configured), "month")?;
    if arguments.dry_run {
        let months = plan_months(&data, after_days, now)?;
        for month in &months {
            say!("would compress history/{} ({} MiB)", month.key.file_name(), month.bytes >> 20);
        }
        say!("would compress {} months; nothing was changed", months.len());
        return Ok(());
    }
    let mut store = Store::open(&data)?;
    let (mut done, mut bytes, mut packed_bytes, mut failed) = (0, 0, 0, 0);
    for month in plan_months(&data, after_days, now)? {
        let name = month.key.file_name();
        match one(&mut store, &data, &month) {
            Ok(one) => {
                (done, bytes, packed_bytes) = (done + 1, bytes + one.bytes, packed_bytes + one.packed_bytes);
                say!("history/{name}: {} KiB, compressed {} KiB", one.bytes >> 10, one.packed_bytes >> 10);
            }
            Err(error) => {
                failed += 1;
                complain!("history/{name} stays as it is: {}", super::told(&error));
            }
        }
    }
    store.close()?;
    say!("{done} months compressed: {} MiB, now {} MiB", bytes >> 20, packed_bytes >> 20);
    ensure!(failed == 0, "{failed} months could not be compressed");
    Ok(())
}

fn one(store: &mut Store, data: &Path, month: &PackableMonth) -> anyhow::Result<CompressedMonth> {
    ensure!(
        store.ready_month(month.key)?,
        "the history lacks packets of the archive: start the server, which reads them, and compress it later"
    );
    let mut progress = Progress::new();
    let name = month.key.file_name();
    let packed = PackedMonth::make(data, month, &mut |rows| {
        // They are written, and then compared.
        progress.tell(|| format!("history/{name}: {rows} messages written and compared"));
        true
    })?;
    store.adopt_month(packed)?.done().context("another program reads it: end that first")
}
