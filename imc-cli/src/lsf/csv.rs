//! `imc lsf csv`: one kind of message as a table.

use super::cell::{Row, Style};
use super::columns::{header, write_row};
use super::scan::{Printing, log_file, scan};
use super::select::Select;
use crate::outcome::Outcome;
use crate::output::Output;
use crate::report;
use anyhow::{Context as _, bail};
use imc::catalogue::MessageDesc;
use imc::lsf::LogItem;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Examples:
  imc lsf csv Data.lsf.gz -m EstimatedState --degrees > track.csv
  imc lsf csv Data.lsf.gz -m Rpm --entity \"Motor - Port\" --from +60
  imc lsf csv logs/*/Data.lsf.gz -o tables          every message: tables/GpsFix.csv and so on
  imc lsf csv Data.lsf.gz -m VehicleState --labels   MANEUVER instead of 3

Columns: time (ISO 8601, UTC), epoch [s] (seconds since 1970), src (name or number), src_ent (number), entity \
(label, as the log tells it), then the message's fields in their order with their units, such as `lat [rad]` \
or, with --degrees, `lat [°]`. A nested message is one cell of JSON.

NaN, and a field that an older sender leaves out, is an empty cell; infinities are inf and -inf. \
Text that a spreadsheet would run as a formula (it starts with = + - @ or a control character) gets an \
apostrophe in front; --raw-text turns that off.";

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
    style: Style,
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
        let style = self.style;
        let mut tables =
            Tables { folder: self.output.as_deref(), force: self.force, out, open: BTreeMap::new() };
        let mut passed = 0_u64;
        let mut row = Row::default();
        for file in &self.files {
            let path = log_file(file)?;
            let selection = self.select.on(&path, true)?;
            let printing = if self.output.is_some() { Printing::AtTheEnd } else { Printing::Meanwhile };
            scan(&path, printing, |item| {
                let LogItem::Packet { view, .. } = item else {
                    passed += 1;
                    return Ok(());
                };
                if !selection.admits(view) {
                    return Ok(());
                }
                let desc = view.desc();
                let Some(desc) = desc.filter(|desc| write_row(&mut row, desc, view, &selection.names, style))
                else {
                    passed += 1;
                    return Ok(());
                };
                tables.write(desc, row.finish(), style)
            })?;
        }
        tables.finish()?;
        if passed > 0 {
            report::note(&format!(
                "{passed} damaged or undecodable pieces were passed over; `imc lsf info` tells more"
            ));
        }
        Ok(Outcome::damaged_if(passed > 0))
    }
}

/// The tables begun.
struct Tables<'o> {
    folder: Option<&'o Path>,
    force: bool,
    out: &'o mut Output,
    open: BTreeMap<u16, Option<(PathBuf, BufWriter<File>)>>,
}

impl Tables<'_> {
    fn write(&mut self, desc: &MessageDesc, row: &str, style: Style) -> anyhow::Result<()> {
        if !self.open.contains_key(&desc.id) {
            let table = self.folder.map(|folder| self.create(folder, desc)).transpose()?;
            self.open.insert(desc.id, table);
            self.append(desc.id, &header(desc, style))?;
        }
        self.append(desc.id, row)
    }

    fn create(&self, folder: &Path, desc: &MessageDesc) -> anyhow::Result<(PathBuf, BufWriter<File>)> {
        let path = folder.join(format!("{}.csv", desc.abbrev));
        let file = if self.force { File::create(&path) } else { File::create_new(&path) };
        let place = || format!("cannot make {} (--force overwrites files)", path.display());
        Ok((path.clone(), BufWriter::new(file.with_context(place)?)))
    }

    fn append(&mut self, id: u16, line: &str) -> anyhow::Result<()> {
        match self.open.get_mut(&id).and_then(Option::as_mut) {
            None => Ok(self.out.write_all(line.as_bytes())?),
            Some((path, file)) => {
                file.write_all(line.as_bytes()).with_context(|| format!("cannot write {}", path.display()))
            }
        }
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        for (path, file) in self.open.values_mut().flatten() {
            file.flush().with_context(|| format!("cannot write {}", path.display()))?;
        }
        Ok(())
    }
}
