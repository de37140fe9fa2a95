//! `lutra-server detections`: files of detections in and out, without a running server.

use super::Common;
use super::Partial;
use super::data::{Spreadsheet, folder, to_output, vessels};
use super::people::existing;
use super::say::{complain, counted, say};
use anyhow::{Context as _, bail};
use clap::{Args, Subcommand};
use detections::TagFilter;
use research::{Carriers, FORMATS, Narrowed, ReadDetections};
use shore::clock;
use shore::history::heard::{self, HeardFile};
use shore::identity::{Request as _, vessels as named, with};
use shore::register::{All, Called, study};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{BufWriter, IntoInnerError};
use std::path::{Path, PathBuf};
use store::{DetectionsWanted, Imported, Store, TimeRange};
use tables::Dialect;
use units::UtcTime;

#[derive(Debug, Subcommand)]
pub(super) enum DetectionsCommand {
    /// Write detections as a file, with what the register knows of tags, animals and receivers.
    Export(Box<ExportArguments>),
    /// Take a table of detections into the archive. One bad row refuses the whole file; what is there already is not added twice.
    ///
    /// An import that is broken off is finished by the next one. Ends with 3 where only a part came into the archive.
    ///
    /// Tables of Lutra (CSV, Parquet), and of the programs of receivers and portals: ComPort of Thelma, VUE, Fathom, ETN, OTN.
    Import(ImportArguments),
    /// List the formats of files, and the programs that read them.
    Formats,
}

#[derive(Debug, Args)]
pub(super) struct ImportArguments {
    /// The table.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// The vessel or fixed station that all of it is of, by name or address. Without it: by the table's names of vessels, else
    /// by the register's deployments of the receivers.
    #[arg(long, value_name = "VESSEL")]
    vessel: Option<String>,
}

fn tag(text: &str) -> Result<TagFilter, api::Said> {
    Ok(research::tag(text)?)
}

#[derive(Debug, Args)]
pub(super) struct ExportArguments {
    /// The format; `lutra-server detections formats` lists them.
    #[arg(long, default_value = "lutra", value_parser = research::format, value_name = "FORMAT")]
    format: research::Format,
    /// Vessels by name or address, like 0x2810; may be repeated. Without it: all.
    #[arg(long = "vessel", value_name = "VESSEL")]
    vessels: Vec<String>,
    /// Tags by protocol and number, like S256-101, or by number; may be repeated. Without it: all.
    #[arg(long = "tag", value_parser = tag, value_name = "TAG")]
    tags: Vec<TagFilter>,
    /// Projects of the register by name: of the tag, or of the animal that carried it; may be repeated. Without it: all.
    #[arg(long = "project", value_name = "PROJECT")]
    projects: Vec<String>,
    /// Only detections within an area: its corners, 3 to 100, as "LAT,LON;LAT,LON;..." in degrees, in order around it.
    /// Detections without a known position are left out then. Without it: everywhere.
    #[arg(long, value_name = "CORNERS", allow_hyphen_values = true)]
    area: Option<String>,
    /// Reported from this time on, ISO 8601, UTC unless it has an offset like +02:00, by the vessels' clocks.
    #[arg(long, value_name = "TIME")]
    from: Option<UtcTime>,
    /// Reported before this time, likewise.
    #[arg(long, value_name = "TIME")]
    to: Option<UtcTime>,
    /// For a spreadsheet, in the format `lutra`: a byte order mark, and its decimal sign.
    #[arg(long, value_enum, value_name = "SIGN")]
    spreadsheet: Option<Spreadsheet>,
    /// The file to write; - or nothing for the standard output.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// `lutra-server detections`.
pub(super) fn detections(common: &Common, command: &DetectionsCommand) -> anyhow::Result<()> {
    match command {
        DetectionsCommand::Export(arguments) => export(common, arguments),
        DetectionsCommand::Import(arguments) => import(common, arguments),
        DetectionsCommand::Formats => {
            for format in FORMATS {
                say!("{:16} {}", format.name, format.about);
            }
            Ok(())
        }
    }
}

fn export(common: &Common, arguments: &ExportArguments) -> anyhow::Result<()> {
    let data = folder(common)?;
    let file = HeardFile::of(arguments.format, arguments.spreadsheet.map(Dialect::from).unwrap_or_default())?;
    let systems = Some(vessels(&data, &arguments.vessels)?).filter(|systems| !systems.is_empty());
    let range = TimeRange::new(arguments.from, arguments.to);
    let wanted = DetectionsWanted { systems, range, came_from: None, tags: arguments.tags.clone() };
    let ((_, rows), vessels) = with(&data, async |db| (All, named::List).run(db).await)?;
    let (study, names): (_, BTreeMap<u16, String>) =
        (study(rows), vessels.into_iter().map(|vessel| (vessel.address, vessel.name)).collect());
    let projects = arguments.projects.iter().map(String::as_str);
    let narrowed = Narrowed::of(projects, arguments.area.as_deref(), &study).map_err(anyhow::Error::msg)?;
    let file = HeardFile { narrowed, ..file };
    to_output(arguments.output.as_deref(), true, &mut |out| {
        Ok(heard::write(&data, &wanted, &names, &study, &file, out)?)
    })
}

fn import(common: &Common, arguments: &ImportArguments) -> anyhow::Result<()> {
    let data = existing(common)?.data;
    let file = &arguments.file;
    let mut store = Store::open(&data)?;
    let ((_, rows), named) = with(&data, async |db| (All, named::List).run(db).await)?;
    let (study, called) = (study(rows), Called::new(&named));
    let address = |text: &str| called.carrier(text, &study);
    let system = arguments.vessel.as_deref().map(address).transpose().map_err(anyhow::Error::msg)?;
    let carriers = Carriers { system, address: &address, study: &study };
    let staged = Staged::of(&data);
    let taken = staged.finish_earlier(&mut store).and_then(|earlier| {
        let read = staged.stage(file, &carriers)?;
        Ok((earlier, read, staged.take(&mut store)?))
    });
    let closed = store.close();
    let (earlier, read, done) = taken?;
    closed?;
    let left_out = counted(read.left_out, "row");
    say!("{}, {} new; {left_out} of other kinds left out", counted(read.rows, "detection"), done.added);
    whole(&done, read.rows, &staged.whole, file)?;
    earlier.map_or(Ok(()), |partial| Err(partial.into()))
}

/// Whether all of a table came into the archive.
///
/// # Errors
/// It did not: [`Partial`].
fn whole(done: &Imported, rows: u64, staged: &Path, file: &Path) -> anyhow::Result<()> {
    for problem in &done.problems {
        let staged = staged.display().to_string();
        complain!("{}", problem.replace(&staged, &file.display().to_string()));
    }
    if done.problems.is_empty() && done.packets == rows {
        return Ok(());
    }
    // One packet is one detection, in the order of the lines.
    let text = format!(
        "{} of {rows} detections of {} came into the archive, in the order of its lines; mend what is said above and import the file \
         again: nothing is added twice",
        done.packets,
        file.display()
    );
    Err(Partial(text).into())
}

/// The packets of a table: first all of them in a file, then all into the archive. A command that ends in between leaves the
/// file, and the next one takes it first.
struct Staged {
    /// Being written: not worth anything after a break.
    partial: PathBuf,
    /// Whole.
    whole: PathBuf,
}

impl Staged {
    /// In the data folder, which has the room for it or for nothing.
    fn of(data: &Path) -> Self {
        Self { partial: data.join("detections.lsf.new"), whole: data.join("detections.lsf") }
    }

    /// Takes what an import before this one left. Returns what of that could not be taken.
    fn finish_earlier(&self, store: &mut Store) -> anyhow::Result<Option<Partial>> {
        if !self.whole.exists() {
            return Ok(None);
        }
        let done = self.take(store)?;
        let (found, added) = (done.packets, done.added);
        if done.problems.is_empty() {
            complain!(
                "an import that was broken off before is finished: {found} detections, {added} of them new"
            );
            return Ok(None);
        }
        done.problems.iter().for_each(|problem| complain!("{problem}"));
        let text = format!(
            "of an import that was broken off before {found} detections could be taken, {added} of them new: import its table again, nothing \
             is added twice"
        );
        Ok(Some(Partial(text)))
    }

    /// Makes packets of a table.
    fn stage(&self, file: &Path, carriers: &Carriers<'_>) -> anyhow::Result<ReadDetections> {
        let staged = File::create(&self.partial).map_err(anyhow::Error::from).and_then(|made| {
            let mut out = BufWriter::new(made);
            let read =
                heard::packets(file, carriers, &mut out).with_context(|| file.display().to_string())?;
            out.into_inner().map_err(IntoInnerError::into_error)?.sync_all()?;
            if let Some(why) = heard::refusal(&read) {
                bail!("{}: {why}", file.display());
            }
            fs::rename(&self.partial, &self.whole)?;
            Ok(read)
        });
        if staged.is_err() {
            fs::remove_file(&self.partial).ok();
        }
        staged
    }

    /// Takes the packets into the archive. Those that are there already are not added twice.
    fn take(&self, store: &mut Store) -> anyhow::Result<Imported> {
        let done = store.import(std::slice::from_ref(&self.whole), clock::now(), &mut |_| true)?;
        fs::remove_file(&self.whole).with_context(|| format!("cannot remove {}", self.whole.display()))?;
        Ok(done)
    }
}
