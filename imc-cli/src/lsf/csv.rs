//! `imc lsf csv`: one kind of message as a table.

use super::scan::{Printing, log_file, scan};
use super::select::{Select, Selection};
use crate::outcome::Outcome;
use crate::output::Output;
use crate::report;
use anyhow::{Context as _, bail};
use imc::PacketView;
use imc::catalogue::MessageDesc;
use imc::lsf::LogItem;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};
use tables::{Dialect, FIXED, Field, Format, PacketRow, Style};

const EXAMPLES: &str = "\
Examples:
  imc lsf csv Data.lsf.gz -m EstimatedState --degrees > track.csv
  imc lsf csv Data.lsf.gz -m Rpm --entity \"Motor - Port\" --from +60
  imc lsf csv logs/*/Data.lsf.gz -o tables          every message: tables/GpsFix.csv and so on
  imc lsf csv Data.lsf.gz -m VehicleState --labels   MANEUVER instead of 3

The tables are those of `lutra-server export`: time (ISO 8601, UTC) and unix_s (seconds since 1970), system, \
system_id, entity (the label that it had then), entity_id, dst, dst_ent, then what is computed (the vessel's place of \
EstimatedState, when a tag was heard) and the message's fields in their order with their units, such as `lat [rad]` or, \
with --degrees, `lat [deg]`. A nested message is one cell of JSON. Rows stand in the order of the log.

Reals are always written as such (8.0); NaN, inf and -inf are those. An empty cell is a field that an older sender \
left out; an empty time means that the stamp is not a time. Text that is not UTF-8 has its bytes as \\xNN and its backslashes \
doubled. Text that a spreadsheet would run as a formula (it starts with = + - @ ' or a control character) gets an \
apostrophe in front; --raw-text turns that off.";

/// How values are written.
#[derive(Debug, Clone, Copy, clap::Args)]
struct Cells {
    /// Angles in degrees instead of radians
    #[arg(long)]
    degrees: bool,
    /// Names of values, such as MANEUVER or PATH|SPEED, instead of their numbers
    #[arg(long)]
    labels: bool,
    /// Leave text that looks like a formula as it is
    #[arg(long)]
    raw_text: bool,
    /// For a spreadsheet: a byte order mark, and its decimal sign; with `comma` cells are separated by semicolons
    #[arg(long, value_enum, value_name = "SIGN")]
    spreadsheet: Option<Spreadsheet>,
}

/// The decimal sign of a spreadsheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Spreadsheet {
    /// As in most of Europe
    Comma,
    /// As in English
    Point,
}

impl Cells {
    fn format(self) -> Format {
        let dialect = match self.spreadsheet {
            None => Dialect::Plain,
            Some(Spreadsheet::Comma) => Dialect::SpreadsheetComma,
            Some(Spreadsheet::Point) => Dialect::SpreadsheetPoint,
        };
        Format { dialect, guard: !self.raw_text }
    }

    fn style(self) -> Style {
        Style { degrees: self.degrees, labels: self.labels }
    }
}

/// Writes one kind of message as CSV, or each kind to a file of its own.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Csv {
    /// Logs, or their folders
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    #[command(flatten)]
    select: Select,
    /// Write one file for each message, MESSAGE.csv, to this folder
    #[arg(long, short, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Overwrite files in that folder
    #[arg(long, requires = "output")]
    force: bool,
    #[command(flatten)]
    cells: Cells,
}

impl Csv {
    pub(crate) fn run(&self, out: &mut Output) -> anyhow::Result<Outcome> {
        if self.output.is_none() && self.select.pick.messages.len() != 1 {
            bail!(
                "one table is one kind of message: choose one with -m MESSAGE, or give a folder with -o DIR"
            );
        }
        if let Some(folder) = &self.output {
            std::fs::create_dir_all(folder)
                .with_context(|| format!("cannot make the folder {}", folder.display()))?;
        }
        let mut tables = Tables::new(self, out);
        let mut passed = Passed::default();
        for file in &self.files {
            let path = log_file(file)?;
            let selection = self.select.on(&path, true)?;
            let printing = if self.output.is_some() { Printing::AtTheEnd } else { Printing::Meanwhile };
            scan(&path, printing, |item| match item {
                LogItem::Packet { view, .. } if selection.admits(view) => {
                    tables.write(view, &selection, &mut passed)
                }
                LogItem::Packet { .. } => Ok(()),
                LogItem::Damage(_) | LogItem::Cut { .. } => {
                    passed.damaged += 1;
                    Ok(())
                }
            })?;
        }
        tables.finish()?;
        passed.tell();
        Ok(Outcome::damaged_if(passed != Passed::default()))
    }
}

/// Counts of what is in no table.
#[derive(Debug, Default, PartialEq, Eq)]
struct Passed {
    /// Pieces of logs that are not packets, and packets with invalid fields.
    damaged: u64,
    /// Packets that the catalogue does not define.
    unexplained: u64,
}

impl Passed {
    fn tell(&self) {
        if self.damaged > 0 {
            report::note(&format!(
                "{} damaged pieces were passed over; `imc lsf info` tells more",
                self.damaged
            ));
        }
        if self.unexplained > 0 {
            report::note(&format!(
                "{} packets are left out: the catalogue does not explain them; `imc lsf info` tells their ids",
                self.unexplained
            ));
        }
    }
}

/// One table: its message, its columns, and the file it goes to, if not standard output.
struct Table {
    desc: &'static MessageDesc,
    fields: Vec<Field>,
    file: Option<(PathBuf, BufWriter<File>)>,
}

/// The tables begun.
struct Tables<'o> {
    csv: &'o Csv,
    out: &'o mut Output,
    row: PacketRow,
    line: Vec<u8>,
    open: BTreeMap<u16, Table>,
}

impl<'o> Tables<'o> {
    fn new(csv: &'o Csv, out: &'o mut Output) -> Self {
        Self { csv, out, row: PacketRow::new(csv.cells.format()), line: Vec::new(), open: BTreeMap::new() }
    }

    fn write(
        &mut self,
        view: &PacketView<'_>,
        selection: &Selection<'_>,
        passed: &mut Passed,
    ) -> anyhow::Result<()> {
        let Some(desc) = view.desc() else {
            passed.unexplained += 1;
            return Ok(());
        };
        self.line.clear();
        if !self.open.contains_key(&desc.id) {
            let table = self.begin(desc)?;
            self.open.insert(desc.id, table);
        }
        let Some(table) = self.open.get_mut(&desc.id) else { return Ok(()) };
        if self.row.write(&mut self.line, view, (table.desc, &table.fields), &selection.names).is_err() {
            passed.damaged += 1;
        }
        table.append(&self.line, self.out)
    }

    /// Begins a table: its headings are put into `line`.
    fn begin(&mut self, desc: &'static MessageDesc) -> anyhow::Result<Table> {
        let file = self.csv.output.as_deref().map(|folder| self.create(folder, desc)).transpose()?;
        let (format, fields) = (self.csv.cells.format(), tables::fields(desc, self.csv.cells.style()));
        self.line.extend_from_slice(format.dialect.mark());
        let own = fields.iter().map(|field| tables::heading(desc.abbrev, field, false));
        for (at, name) in FIXED.iter().map(|(name, ..)| (*name).to_owned()).chain(own).enumerate() {
            if at > 0 {
                format.next(&mut self.line);
            }
            self.line.extend_from_slice(name.as_bytes());
        }
        self.line.push(b'\n');
        Ok(Table { desc, fields, file })
    }

    fn create(&self, folder: &Path, desc: &MessageDesc) -> anyhow::Result<(PathBuf, BufWriter<File>)> {
        let path = folder.join(format!("{}.csv", desc.abbrev));
        let file = if self.csv.force { File::create(&path) } else { File::create_new(&path) };
        let place = || format!("cannot make {} (--force overwrites files)", path.display());
        Ok((path.clone(), BufWriter::new(file.with_context(place)?)))
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        for (path, file) in self.open.values_mut().filter_map(|table| table.file.as_mut()) {
            file.flush().with_context(|| format!("cannot write {}", path.display()))?;
        }
        Ok(())
    }
}

impl Table {
    fn append(&mut self, line: &[u8], out: &mut Output) -> anyhow::Result<()> {
        match &mut self.file {
            None => Ok(out.write_all(line)?),
            Some((path, file)) => {
                file.write_all(line).with_context(|| format!("cannot write {}", path.display()))
            }
        }
    }
}
