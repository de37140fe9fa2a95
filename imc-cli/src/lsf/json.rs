//! `imc lsf json`: packets of logs as JSON lines.

use super::scan::{Printing, log_file, scan};
use super::select::Select;
use crate::outcome::Outcome;
use crate::output::Output;
use crate::record::{self, Place};
use imc::lsf::LogItem;
use imc::{Frame, ShortPayload};
use std::io::Write as _;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  imc lsf json Data.lsf.gz -m LogBookEntry | jq -r .fields.text
  imc lsf json logs/*/Data.lsf.gz --entity GPS --where 'satellites<6'
  imc lsf json Data.lsf.gz --from +30 --to +60 -s ntnu-otter-01

Lines are as `imc decode` prints them; damage is always shown, in its place.";

/// Prints packets of logs as JSON lines.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Json {
    /// Logs, or their folders
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    #[command(flatten)]
    select: Select,
}

impl Json {
    pub(crate) fn run(&self, out: &mut Output) -> anyhow::Result<Outcome> {
        let mut damaged = false;
        let mut line = Vec::new();
        for file in &self.files {
            let path = log_file(file)?;
            let selection = self.select.on(&path, false)?;
            scan(&path, Printing::Meanwhile, |item| {
                line.clear();
                let sound = match item {
                    LogItem::Packet { view, .. } if !selection.admits(view) => return Ok(()),
                    _ => append(&mut line, item),
                };
                damaged |= !sound;
                Ok(out.write_all(&line)?)
            })?;
        }
        Ok(Outcome::damaged_if(damaged))
    }
}

/// Appends the line of an item. Returns whether it is a packet that could be decoded.
pub(super) fn append(line: &mut Vec<u8>, item: &LogItem<'_>) -> bool {
    let (place, short) = (Place::default(), ShortPayload::default());
    match item {
        LogItem::Packet { offset, view } => {
            record::frame(line, &Frame::Packet { offset: *offset, view: *view }, place, short)
        }
        LogItem::Damage(damage) => record::frame(line, &Frame::Damage(*damage), place, short),
        LogItem::Cut { offset, problem } => {
            record::bad_gzip(line, *offset, None, problem);
            false
        }
    }
}
