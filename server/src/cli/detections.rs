//! `lutra-server detections`: files of detections in and out, without a running server.

use super::Common;
use super::data::{Spreadsheet, folder, to_output, vessels};
use super::say::say;
use anyhow::{Context as _, bail};
use clap::{Args, Subcommand};
use detections::TagFilter;
use research::{Carriers, FORMATS, Narrowed};
use shore::clock;
use shore::history::heard::{self, HeardFile};
use shore::identity::{Request as _, vessels as named, with};
use shore::register::{All, Called, study};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{BufWriter, Write as _};
use std::path::PathBuf;
use store::{DetectionsWanted, Store, TimeRange};
use tables::Dialect;
use units::UtcTime;

#[derive(Debug, Subcommand)]
pub(super) enum DetectionsCommand {
    /// Write detections as a file, with what the register knows of tags, animals and receivers.
    Export(Box<ExportArguments>),
    /// Take a table of detections into the archive. One bad row refuses the whole file; what is there already is not added twice.
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
    let data = common.load_to_write()?.data;
    let file = &arguments.file;
    let mut store = Store::open(&data)?;
    let ((_, rows), named) = with(&data, async |db| (All, named::List).run(db).await)?;
    let (study, called) = (study(rows), Called::new(&named));
    let names = called.names();
    let system = arguments.vessel.as_deref().map(names.address).transpose().map_err(anyhow::Error::msg)?;
    let carriers = Carriers { system, address: names.address, study: &study };
    // Packets wait in the data folder, which has the room for them or for nothing.
    let waiting = data.join("detections.lsf.new");
    let taken = File::create(&waiting).map_err(anyhow::Error::from).and_then(|made| {
        let mut out = BufWriter::new(made);
        let read = heard::packets(file, &carriers, &mut out).with_context(|| file.display().to_string())?;
        out.flush()?;
        if let Some(why) = heard::refusal(&read) {
            bail!("{}: {why}", file.display());
        }
        let done = store.import(std::slice::from_ref(&waiting), clock::now(), &mut |_| true)?;
        Ok((read, done))
    });
    fs::remove_file(&waiting).ok();
    let closed = store.close();
    let (read, done) = taken?;
    closed?;
    say!("{} detections, {} new; {} rows of other kinds left out", read.rows, done.added, read.left_out);
    Ok(())
}
