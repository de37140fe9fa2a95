//! `imc lsf grep`: finds packets by their text.

use super::scan::{Printing, log_file, scan};
use super::select::Select;
use super::{json, shown};
use crate::outcome::Outcome;
use crate::output::Output;
use crate::report;
use crate::style::Paint;
use imc::lsf::LogItem;
use std::io::Write as _;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  imc lsf grep \"plan loaded\" Data.lsf.gz
  imc lsf grep error logs/*/Data.lsf.gz -m LogBookEntry -m EntityState
  imc lsf grep \"\" Data.lsf.gz --where 'op_mode=MANEUVER' --from +30    every packet chosen
  imc lsf grep ntnu-otter-02 Data.lsf.gz --json | imc encode > about.lsf

A packet is shown as one line: time, source/entity, message, fields with the names of their values. TEXT is \
looked for in that line; case does not matter. Exit status 1 when nothing is found or a log is damaged.";

/// Shows the packets that speak of something, one line each.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Grep {
    /// What to look for
    #[arg(value_name = "TEXT")]
    text: String,
    /// Logs, or their folders
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    #[command(flatten)]
    select: Select,
    /// Only print how many packets are found in each file
    #[arg(long, short, conflicts_with = "json")]
    count: bool,
    /// Print the packets as JSON lines
    #[arg(long)]
    json: bool,
}

impl Grep {
    pub(crate) fn run(&self, out: &mut Output) -> anyhow::Result<Outcome> {
        let (mut found, mut damaged) = (0, false);
        for file in &self.files {
            let path = log_file(file)?;
            let prefix = if self.files.len() > 1 { format!("{}: ", path.display()) } else { String::new() };
            let before = found;
            let (found_here, damaged_here) = self.search(&path, &prefix, out)?;
            found += found_here;
            damaged |= damaged_here;
            if damaged_here {
                report::note(&format!("{}: damaged; `imc lsf info` tells more", path.display()));
            }
            if self.count {
                writeln!(out, "{prefix}{}", found - before)?;
            }
        }
        Ok(Outcome::damaged_if(found == 0 || damaged))
    }

    fn search(&self, path: &std::path::Path, prefix: &str, out: &mut Output) -> anyhow::Result<(u64, bool)> {
        let paint = Paint::stdout();
        let wanted = self.text.to_lowercase();
        let selection = self.select.on(path, true)?;
        let (mut found, mut damaged) = (0, false);
        scan(path, Printing::Meanwhile, |item| {
            let LogItem::Packet { view, .. } = item else {
                damaged = true;
                return Ok(());
            };
            if !selection.admits(view) {
                return Ok(());
            }
            let line = shown::line(view, &selection.names);
            let Some(at) = find(&line, &wanted) else { return Ok(()) };
            found += 1;
            if self.json {
                let mut bytes = Vec::new();
                json::append(&mut bytes, item);
                out.write_all(&bytes)?;
            } else if !self.count {
                let (before, rest) = line.split_at(at.start);
                let (hit, after) = rest.split_at(at.len());
                writeln!(out, "{prefix}{before}{}{after}", paint.alert(hit))?;
            }
            Ok(())
        })?;
        Ok((found, damaged))
    }
}

/// Position of a text in a line, ignoring case.
fn find(line: &str, wanted: &str) -> Option<std::ops::Range<usize>> {
    let lower = line.to_lowercase();
    let start = lower.find(wanted)?;
    let end = start + wanted.len();
    // Lower case may be longer or shorter than the text itself: then nothing is marked.
    let same = lower.len() == line.len() && line.is_char_boundary(start) && line.is_char_boundary(end);
    Some(if same { start..end } else { 0..0 })
}
