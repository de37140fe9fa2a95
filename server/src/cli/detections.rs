//! `lutra-server detections`: files of detections without a running server.

use super::Common;
use super::data::{Spreadsheet, folder, to_output, vessels};
use super::say::say;
use clap::{Args, Subcommand};
use detections::TagFilter;
use research::{FORMATS, Narrowed};
use shore::history::heard::{self, HeardFile};
use shore::identity::{Request as _, vessels as named, with};
use shore::register::{All, study};
use std::collections::BTreeMap;
use std::path::PathBuf;
use store::{DetectionsWanted, TimeRange};
use tables::Dialect;
use units::UtcTime;

#[derive(Debug, Subcommand)]
pub(super) enum DetectionsCommand {
    /// Write detections as a file, with what the register knows of tags, animals and receivers.
    Export(Box<ExportArguments>),
    /// List the formats of files, and the programs that read them.
    Formats,
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
