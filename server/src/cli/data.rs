//! Work on a data folder without a running server: import, export, reindex, backup, restore.

use super::Common;
use super::say::{complain, counted, say};
use crate::backups::{self, Place};
use crate::config::Config;
use anyhow::{Context as _, bail, ensure};
use clap::{Args, ValueEnum};
use flate2::Compression;
use flate2::write::GzEncoder;
use imc::Address;
use shore::backup::Aside;
use shore::clock;
use shore::folder::is_there;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, BufWriter, IsTerminal as _, Write};
use std::num::NonZeroI64;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};
use store::{Angles, Covered, CsvOptions, Exported, Reader, Selection, Shape, Store, TimeRange};
use tables::Dialect;
use units::UtcTime;

#[derive(Debug, Args)]
pub(super) struct ImportArguments {
    /// Logs: Data.lsf, Data.lsf.gz or Data.lsf.zst, or folders of them.
    #[arg(required = true, value_name = "LSF")]
    logs: Vec<PathBuf>,
    /// Make the data folder where there is none.
    #[arg(long)]
    new: bool,
}

#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
#[expect(clippy::struct_excessive_bools, reason = "each is a flag of its own")]
pub(super) struct ExportArguments {
    /// Messages by name or number, like EstimatedState or 0x15e; may be repeated. Without it: all that the catalogue
    /// defines; the number of others is reported. `_raw` alone, as CSV: messages that it does not define, with id and
    /// payload.
    #[arg(long = "message", value_name = "NAME")]
    messages: Vec<String>,
    /// Vessels by name or address, like 0x2810; may be repeated. Without it: all.
    #[arg(long = "vessel", value_name = "VESSEL")]
    vessels: Vec<String>,
    /// Entities by number, or by label: their messages while they had it; may be repeated. Without it: all.
    #[arg(long = "entity", value_name = "ENTITY")]
    entities: Vec<String>,
    /// Fields by name, like psi or EulerAngles.psi; may be repeated. Without it: all.
    #[arg(long = "field", value_name = "FIELD")]
    fields: Vec<String>,
    /// From this time on, ISO 8601, UTC unless it has an offset like +02:00, by the vessels' clocks.
    #[arg(long, value_name = "TIME")]
    from: Option<UtcTime>,
    /// Before this time, likewise.
    #[arg(long, value_name = "TIME")]
    to: Option<UtcTime>,
    /// What to write.
    #[arg(long, value_enum, default_value_t = Format::Csv)]
    format: Format,
    /// A row for each value instead of one for each message.
    #[arg(long)]
    long: bool,
    /// Angles in degrees instead of radians.
    #[arg(long)]
    degrees: bool,
    /// Enumerated values by name instead of number.
    #[arg(long)]
    labels: bool,
    /// Also when each message was first received ashore.
    #[arg(long)]
    received: bool,
    /// For a spreadsheet: a byte order mark, and its decimal sign; with `comma` cells are separated by semicolons.
    #[arg(long, value_enum, value_name = "SIGN")]
    spreadsheet: Option<Spreadsheet>,
    /// Of each series only the first row in each span of so many seconds.
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    every_s: Option<f64>,
    /// The file to write; - or nothing for the standard output.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds: f64 = text.parse().map_err(|_| "no number of seconds".to_owned())?;
    if (0.001..=86_400.0).contains(&seconds) { Ok(seconds) } else { Err("0.001 to 86400 seconds".to_owned()) }
}

/// The decimal sign of a spreadsheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Spreadsheet {
    /// As in most of Europe.
    Comma,
    /// As in English.
    Point,
}

impl From<Spreadsheet> for Dialect {
    fn from(sign: Spreadsheet) -> Self {
        match sign {
            Spreadsheet::Comma => Self::SpreadsheetComma,
            Spreadsheet::Point => Self::SpreadsheetPoint,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// A table, units in its header.
    Csv,
    /// The same, compressed.
    #[value(name = "csv.gz")]
    CsvGz,
    /// The same columns with their types, for pandas, polars, DuckDB and R's arrow.
    Parquet,
    /// The packets as they came, for Neptus and other readers of IMC logs.
    Lsf,
}

#[derive(Debug, Args)]
pub(super) struct ReindexArguments {
    /// Continue although days were removed from the archive that the history still holds; they are lost.
    #[arg(long)]
    accept_loss: bool,
}

#[derive(Debug, Args)]
pub(super) struct BackupArguments {
    /// The folder to copy into; it may hold an earlier backup, of which only what changed is copied again. Until the new one is
    /// whole the earlier one stays as it was. Without it: backup.folder of the configuration.
    #[arg(value_name = "DIR")]
    to: Option<PathBuf>,
    /// Do not read again what the earlier backup has: faster, and damage to it is not noticed.
    #[arg(long)]
    quick: bool,
    /// For a timer: only end with 0 if backup.folder exists on its own disk, with 1 if no backup was set up, with 255 if a
    /// person must look, for example if the disk is not mounted.
    #[arg(long, conflicts_with_all = ["to", "quick"])]
    check: bool,
}

#[derive(Debug, Args)]
pub(super) struct RestoreArguments {
    /// The backup. The data folder (--data) must be absent or empty.
    #[arg(value_name = "BACKUP")]
    from: PathBuf,
}

/// Rewrites one line on a terminal, not more than ten times a second; prints nothing elsewhere.
pub(super) struct Progress {
    last: Option<Instant>,
    shown: bool,
}

impl Progress {
    pub(super) fn new() -> Self {
        Self { last: None, shown: io::stderr().is_terminal() }
    }

    pub(super) fn tell(&mut self, text: impl FnOnce() -> String) {
        if self.shown && self.last.is_none_or(|last| last.elapsed() >= Duration::from_millis(100)) {
            self.last = Some(Instant::now());
            write!(io::stderr(), "\r\x1b[K{}", text()).ok();
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if self.last.is_some() {
            write!(io::stderr(), "\r\x1b[K").ok();
        }
    }
}

/// The data folder, which must be one: a typo must not look like an empty history.
pub(super) fn folder(common: &Common) -> anyhow::Result<PathBuf> {
    let data = common.load_to_write()?.data;
    ensure!(
        data.join("archive").is_dir() || data.join("history").is_dir(),
        "{} is not a data folder: name the one that the server writes to by --data DIR",
        data.display()
    );
    Ok(data)
}

/// `lutra-server import`.
pub(super) fn import(common: &Common, arguments: &ImportArguments) -> anyhow::Result<()> {
    let config = common.load_to_write()?;
    ensure!(
        arguments.new || is_there(&config.data),
        "{} is not a data folder, and nothing was imported: name the one that the server writes to by --data DIR, or make this one \
         by --new",
        config.data.display()
    );
    let mut store = Store::open(&config.data)?;
    let mut progress = Progress::new();
    let done = store.import(&arguments.logs, clock::now(), &mut |at| {
        progress.tell(|| {
            let (mib, file) = (at.bytes >> 20, at.file.display());
            format!(
                "log {} of {}: {mib} MiB, {} packets, {} new: {file}",
                at.number, at.files, at.packets, at.added
            )
        });
        true
    })?;
    drop(progress);
    store.close()?;
    say!("{}, {}, {} new", counted(done.files, "log"), counted(done.packets, "packet"), done.added);
    if done.damaged_bytes > 0 {
        complain!("passed over what is no packet: {}", counted(done.damaged_bytes, "byte"));
    }
    for problem in &done.problems {
        complain!("{problem}");
    }
    ensure!(done.problems.is_empty(), "not everything could be imported");
    Ok(())
}

/// `lutra-server export`.
pub(super) fn export(common: &Common, arguments: &ExportArguments) -> anyhow::Result<()> {
    let data = folder(common)?;
    if let (Some(from), Some(to)) = (arguments.from, arguments.to) {
        ensure!(from <= to, "--to {to} is before --from {from}");
    }
    let is_raw = arguments.messages.iter().any(|name| name == store::RAW);
    ensure!(
        arguments.format != Format::Lsf || !is_raw,
        "a log has all packets as they came, also those of `_raw`: leave --message out, or write CSV"
    );
    if arguments.format == Format::Lsf {
        refuse_table_options(arguments)?;
    }
    let selection = Selection {
        messages: arguments.messages.clone(),
        systems: vessels(&data, &arguments.vessels)?,
        entities: arguments.entities.clone(),
        fields: arguments.fields.clone(),
        range: TimeRange::new(arguments.from, arguments.to),
    };
    if arguments.format != Format::Lsf && arguments.messages != [store::RAW] {
        tell_left_out(&data, &selection)?;
    }
    if arguments.format == Format::Parquet {
        store::check_parquet(&arguments.messages, &csv_options(arguments))?;
    }
    let is_text = arguments.format == Format::Csv;
    to_output(arguments.output.as_deref(), is_text, &mut |out| write(&data, &selection, arguments, out))
}

/// Refuses options of tables: a log has the packets as they came.
fn refuse_table_options(arguments: &ExportArguments) -> anyhow::Result<()> {
    let given = [
        ("--field", !arguments.fields.is_empty()),
        ("--long", arguments.long),
        ("--degrees", arguments.degrees),
        ("--labels", arguments.labels),
        ("--received", arguments.received),
        ("--spreadsheet", arguments.spreadsheet.is_some()),
        ("--every-s", arguments.every_s.is_some()),
    ];
    let given: Vec<&str> =
        given.into_iter().filter(|(_, is_given)| *is_given).map(|(name, _)| name).collect();
    ensure!(
        given.is_empty(),
        "a log has the packets as they came: leave {} out, or write another --format",
        given.join(", ")
    );
    Ok(())
}

/// Writes to a file, or to the standard output; `is_text` if a terminal can show it.
pub(super) fn to_output(
    output: Option<&Path>,
    is_text: bool,
    write: &mut dyn FnMut(&mut dyn Write) -> anyhow::Result<Exported>,
) -> anyhow::Result<()> {
    let Some(path) = output.filter(|path| path.as_os_str() != "-") else {
        ensure!(
            is_text || !io::stdout().is_terminal(),
            "this format is not for a terminal; give a file by --output"
        );
        return match write(&mut io::stdout().lock()) {
            Err(error) if is_broken_pipe(&error) => Ok(()),
            outcome => outcome.map(drop),
        };
    };
    // Written under another name until complete: an existing file is never a partial export.
    let mut part = path.to_owned().into_os_string();
    part.push(".part");
    let part = PathBuf::from(part);
    let file = File::create(&part).with_context(|| part.display().to_string())?;
    let mut file = BufWriter::new(file);
    let outcome = write(&mut file).and_then(|exported| {
        file.into_inner()?.sync_all()?;
        fs::rename(&part, path).with_context(|| path.display().to_string())?;
        Ok(exported)
    });
    if outcome.is_err() {
        fs::remove_file(&part).ok();
    }
    let exported = outcome?;
    let (rows, bytes) = (counted(exported.rows, "row"), counted(exported.bytes, "byte"));
    complain!("{}: {rows}, {bytes} before compression", path.display());
    Ok(())
}

/// Reports how many messages have no row in a table.
fn tell_left_out(data: &Path, selection: &Selection) -> anyhow::Result<()> {
    let count = store::unexplained(&mut Reader::open(data)?, selection)?;
    if count > 0 {
        complain!(
            "left out, as the catalogue does not explain it: {}; --message _raw has it",
            counted(count, "message")
        );
    }
    Ok(())
}

fn csv_options(arguments: &ExportArguments) -> CsvOptions {
    CsvOptions {
        shape: if arguments.long { Shape::Long } else { Shape::Wide },
        angles: if arguments.degrees { Angles::Degrees } else { Angles::Radians },
        labels: arguments.labels,
        received: arguments.received,
        dialect: arguments.spreadsheet.map(Dialect::from).unwrap_or_default(),
        every_us: arguments.every_s.and_then(|seconds| NonZeroI64::new((seconds * 1e6).round() as i64)),
        ..CsvOptions::default()
    }
}

fn write(
    data: &Path,
    selection: &Selection,
    arguments: &ExportArguments,
    out: &mut dyn Write,
) -> anyhow::Result<Exported> {
    let options = csv_options(arguments);
    Ok(match arguments.format {
        Format::Csv => store::export_csv(data, selection, &options, out)?,
        Format::Lsf => store::export_lsf(data, selection, out)?,
        Format::CsvGz => {
            let mut packed = GzEncoder::new(out, Compression::default());
            let exported = store::export_csv(data, selection, &options, &mut packed)?;
            packed.finish()?;
            exported
        }
        Format::Parquet => store::export_parquet(data, selection, &options, out)?,
    })
}

/// Addresses of vessels given by name or address.
pub(super) fn vessels(data: &Path, given: &[String]) -> anyhow::Result<Vec<Address>> {
    if given.is_empty() {
        return Ok(Vec::new());
    }
    let names = |system: store::System| {
        let registered = system.address.name().map(str::to_owned);
        (system.address, std::iter::once(system.name).chain(registered).collect())
    };
    let known: BTreeMap<Address, Vec<String>> =
        Reader::open(data)?.systems()?.into_iter().map(names).collect();
    Ok(given.iter().map(|text| store::system(&known, text)).collect::<store::Result<_>>()?)
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| {
        cause.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
    })
}

/// `lutra-server reindex`.
pub(super) fn reindex(common: &Common, arguments: &ReindexArguments) -> anyhow::Result<()> {
    let data = folder(common)?;
    let mut progress = Progress::new();
    let done = store::reindex(&data, arguments.accept_loss, &mut |packets| {
        progress.tell(|| format!("{packets} packets"));
        true
    })?;
    drop(progress);
    let (packets, samples) = (counted(done.packets, "packet"), counted(done.samples, "sample"));
    say!("{packets} read, {samples} (before: {})", done.before);
    Ok(())
}

/// `lutra-server backup`.
pub(super) fn backup(common: &Common, arguments: &BackupArguments) -> ExitCode {
    let outcome =
        if arguments.check { may_back_up(common) } else { back_up(common, arguments).map(|()| true) };
    match outcome {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            complain!("lutra-server: {}", super::told(&error));
            ExitCode::from(if arguments.check { super::LOOK } else { 1 })
        }
    }
}

/// Whether a backup is configured and possible. Without one a timer skips it; a disk that is not mounted is an error.
fn may_back_up(common: &Common) -> anyhow::Result<bool> {
    folder(common)?;
    let config = common.load(Vec::new())?;
    let why = match backups::place(&config) {
        Place::Usable => return Ok(true),
        Place::Refused(why) => bail!("no backup is made: {why}"),
        Place::Off => "backup.folder is empty".to_owned(),
        Place::NotSetUp => format!("backup.folder {} is not there", config.backup.folder.display()),
    };
    complain!("no backup is configured: {why}");
    Ok(false)
}

fn back_up(common: &Common, arguments: &BackupArguments) -> anyhow::Result<()> {
    let data = folder(common)?;
    let config = common.load(Vec::new())?;
    let to = match &arguments.to {
        Some(to) => to,
        None => configured(&config)?,
    };
    // Everything recorded before this point is in the backup.
    let covered = store::covered(&data)?;
    let mut progress = Progress::new();
    let done = shore::backup::make(
        &config.data,
        &config.files(common.config.as_deref()),
        to,
        !arguments.quick,
        &mut |what| {
            progress.tell(|| what.to_owned());
        },
    )?;
    drop(progress);
    say!(
        "{}: {} copied, {} grown, {} linked, {} replaced by compressed ones, {} were there; {} KiB written",
        to.display(),
        counted(done.copied, "file"),
        done.grown,
        done.linked,
        done.replaced,
        done.kept,
        done.bytes >> 10
    );
    tell_covered(covered);
    for path in &done.damaged {
        complain!(
            "{} of the earlier backup was damaged and is copied again: look at the backup's disk",
            path.display()
        );
    }
    say!(
        "back again, into a folder that is empty or not there yet, and not into {}: lutra-server restore {} --data DIR",
        data.display(),
        to.display()
    );
    tell_aside(&done.aside, to);
    for path in &done.lost {
        complain!(
            "{} is gone from the backup and from the server: check the backup's disk, and look for another copy",
            path.display()
        );
    }
    let asides = shore::backup::asides(to)?;
    ensure!(
        asides.is_empty() && done.lost.is_empty(),
        "the backup is made, and a person must look{}",
        asides.first().map_or_else(String::new, |aside| {
            format!(" at {}, and then remove what is in {}", aside.display(), to.join("aside").display())
        })
    );
    Ok(())
}

/// The configured folder, if it is suitable for a backup.
fn configured(config: &Config) -> anyhow::Result<&PathBuf> {
    let folder = &config.backup.folder;
    match backups::place(config) {
        Place::Usable => Ok(folder),
        Place::Refused(why) => bail!("no backup is made: {why}"),
        Place::Off => bail!("say where to: lutra-server backup DIR, or backup.folder in the configuration"),
        Place::NotSetUp => bail!(
            "backup.folder {} is not there: mount a second disk there, or say where to: lutra-server backup DIR",
            folder.display()
        ),
    }
}

/// Reports what was set aside this time.
fn tell_aside(aside: &[Aside], to: &Path) {
    for Aside { path, at, good } in aside {
        let (path, at) = (path.display(), to.join(at));
        let at = at.display();
        if *good {
            complain!(
                "{path} of the server is not what it was: the backup has it as it is, and the copy of before is kept as {at}. Look \
                 at the disk of the data; if it is damaged, put that copy in its place while the server is stopped"
            );
        } else {
            complain!(
                "the backup's {path} is damaged, and the server has it no more, or another one: it is kept as {at}. Look at the \
                 backup's disk, and for another copy"
            );
        }
    }
}

/// `lutra-server restore`.
pub(super) fn restore(common: &Common, arguments: &RestoreArguments) -> anyhow::Result<()> {
    let data = common.load(Vec::new())?.data;
    let mut progress = Progress::new();
    let done = shore::backup::restore(&arguments.from, &data, &mut |what| progress.tell(|| what.to_owned()))?;
    drop(progress);
    let made = clock::written(UtcTime::from_micros(done.made_us));
    say!("{}: {}, {} MiB, as of {made}", data.display(), counted(done.files, "file"), done.bytes >> 20);
    tell_covered(store::covered(&data)?);
    say!(
        "what came after that is not in it: vessels send what they still have, and `import` takes the rest from the old archive"
    );
    complain!(
        "access that was taken after that time is good again: before the server starts, revoke the tokens of people that were \
         revoked since (`lutra-server token list`)"
    );
    if data.join("fleet").is_dir() {
        complain!(
            "and for each boat that was lost, stolen or rotated since: `lutra-server fleet revoke NAME`, then put the files of the \
             VPN into force as it says"
        );
    }
    for path in &done.made_again {
        complain!("{} was damaged: the server makes it again from the archive", path.display());
    }
    for (was, now) in &done.outside {
        say!("{} is now {}: put it where the configuration names it", was.display(), now.display());
    }
    Ok(())
}

/// Reports the time that recordings cover, by vessel.
fn tell_covered(covered: Vec<Covered>) {
    for Covered { system, from, to, days } in covered {
        let (from, to) = (clock::written(from), clock::written(to));
        say!("{system}: recorded from {from} to {to}, on {}", counted(days, "day"));
    }
}
