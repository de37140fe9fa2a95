//! `lutra-server archive`: compress days to which nothing is added.

use super::data::{Progress, folder};
use super::say::{complain, counted, say};
use super::{Common, compress};
use anyhow::{bail, ensure};
use clap::{Args, Subcommand};
use std::path::Path;
use store::{Packable, Packing, Store, plan_packing};

/// Bytes of plain files between two reports of progress.
const TURN_BYTES: u64 = 8 << 20;

#[derive(Debug, Subcommand)]
pub(super) enum ArchiveCommand {
    /// Compress days to which nothing is added, as a running server does by itself. The server must not run.
    ///
    /// A day is compressed beside the plain files, read back against them byte by byte, and only then takes their place.
    /// `zstd -dc Data.lsf.zst > ELSEWHERE/Data.lsf` makes the plain log. Earlier versions of Lutra refuse to open the archive from
    /// then on.
    Compress(CompressArguments),
}

#[derive(Debug, Args)]
pub(super) struct CompressArguments {
    /// Days that ended so many days ago or before [default: archive.compress_after_days of the configuration]. The newest
    /// day stays plain.
    #[arg(long, value_name = "DAYS")]
    after_days: Option<u16>,
    /// Only print which days would be compressed. The server may run.
    #[arg(long)]
    dry_run: bool,
}

/// Runs the command.
pub(super) fn archive(common: &Common, command: &ArchiveCommand) -> anyhow::Result<()> {
    let ArchiveCommand::Compress(arguments) = command;
    let data = folder(common)?;
    let configured = common.load(Vec::new())?.archive.compress_after_days;
    let (after_days, now) =
        compress::when(arguments.after_days, ("archive.compress_after_days", configured), "day")?;
    if arguments.dry_run {
        let days = plan_packing(&data, after_days, now)?;
        for day in &days {
            say!("would compress archive/{} ({} KiB)", day.key.name(), day.plain_bytes >> 10);
        }
        let bytes: u64 = days.iter().map(|day| day.plain_bytes).sum();
        say!("would compress {}, {} MiB; nothing was changed", counted(days.len(), "day"), bytes >> 20);
        return Ok(());
    }
    let mut store = Store::open(&data)?;
    let (mut done, mut plain_bytes, mut packed_bytes, mut failed) = (0, 0, 0, 0);
    for day in plan_packing(&data, after_days, now)? {
        match one(&mut store, &data, &day) {
            Ok((plain, packed)) => {
                (done, plain_bytes, packed_bytes) = (done + 1, plain_bytes + plain, packed_bytes + packed);
                say!("archive/{}: {} KiB, compressed {} KiB", day.key.name(), plain >> 10, packed >> 10);
            }
            Err(error) => {
                failed += 1;
                complain!("archive/{} stays as it is: {}", day.key.name(), super::told(&error));
            }
        }
    }
    store.close()?;
    let days = counted(done, "day");
    say!("{days} compressed: {} MiB, now {} MiB", plain_bytes >> 20, packed_bytes >> 20);
    ensure!(failed == 0, "{} could not be compressed", counted(failed, "day"));
    Ok(())
}

/// Compresses a day; its bytes before and after.
fn one(store: &mut Store, data: &Path, day: &Packable) -> anyhow::Result<(u64, u64)> {
    let mut progress = Progress::new();
    let mut packing = Packing::begin(data, day)?;
    // The plain files are read twice: to compress them, and to hold the compressed ones against them.
    let mut bytes = 0;
    while packing.work(TURN_BYTES)? {
        bytes += TURN_BYTES;
        progress.tell(|| {
            format!("archive/{}: {} of {} MiB", day.key.name(), (bytes / 2) >> 20, day.plain_bytes >> 20)
        });
    }
    match store.adopt(&mut packing)? {
        Some(done) => Ok((done.plain_bytes, done.packed_bytes)),
        None => bail!("its files changed meanwhile"),
    }
}
