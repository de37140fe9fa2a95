//! `imc lsf`: inspects, searches, exports and cuts logs.

mod condition;
mod csv;
mod cut;
mod grep;
mod info;
mod json;
mod moment;
mod names;
mod scan;
mod select;
mod shown;
mod tally;
mod zstd;

use crate::outcome::Outcome;
use crate::output::Output;

const EXAMPLES: &str = "\
Examples:
  imc lsf info Data.lsf.gz                         what is in a log
  imc lsf csv -m EstimatedState --degrees Data.lsf.gz > track.csv
  imc lsf grep \"plan loaded\" logs/*/Data.lsf.gz     who said that, and when
  imc lsf cut --from +30 --to +60 -o part.lsf Data.lsf.gz

FILE is a log (Data.lsf, Data.lsf.gz, Data.lsf.zst, or any run of packets) or its folder. All subcommands choose packets by \
the same flags:
  --from, --to    2026-11-21T07:43:27Z, 2026-11-21T09:43:27+02:00,
                  1795247007.5 (seconds since 1970), or +30 (after the log's first packet)
  -m, -s          message, source: by name or number, decimal or 0x...
  --entity        by number, or by label: of the entity that had it then;
                  labels are those that the log itself tells
  --where         FIELD OP VALUE with =, !=, <, <=, >, >= or ~ (contains), such as
                  'op_mode=MANEUVER', 'sog>0.5', 'lat>63.4deg', 'description~fail'

Damage never stops anything: it is counted, or shown in its place, and makes the exit status 1.";

/// Looks into logs: summary, JSON, CSV, cut, search.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Lsf {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    Info(info::Info),
    Json(json::Json),
    Csv(csv::Csv),
    Cut(cut::Cut),
    Grep(grep::Grep),
}

impl Lsf {
    pub(crate) fn run(&self, out: &mut Output) -> anyhow::Result<Outcome> {
        match &self.command {
            Command::Info(info) => info.run(out),
            Command::Json(json) => json.run(out),
            Command::Csv(csv) => csv.run(out),
            Command::Cut(cut) => cut.run(out),
            Command::Grep(grep) => grep.run(out),
        }
    }
}
