//! `imc encode`: JSON to packets.

use crate::input::Input;
use crate::json_lines::{BadLine, JsonLines, packet};
use crate::outcome::Outcome;
use crate::output::Output;
use crate::report;
use imc::ByteOrder;
use imc::json::ReadDefaults;
use std::io::{self, IsTerminal as _, Write as _};
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  imc decode log.lsf | imc encode > copy.lsf         the same bytes again
  imc decode log.lsf | jq -c 'select(.abbrev == \"GpsFix\")' | imc encode > fixes.lsf
  echo '{\"abbrev\":\"Temperature\",\"fields\":{\"value\":7.5}}' | imc encode --hex
  echo '{\"abbrev\":\"PlanControl\",\"header\":{\"src\":\"0x4001\",\"dst\":\"ntnu-otter-01\"},
         \"fields\":{\"type\":\"REQUEST\",\"op\":\"STOP\"}}' | tr -d '\\n' | imc encode --hex

A line is what `imc decode` prints. Written by hand it may say less: missing fields hold their \
defaults, missing parts of the header mean \"from nobody to everybody in 1970\"; labels such as \
\"STOP\" stand for numbers, registered names and 0x... for addresses. `imc info MESSAGE` lists fields \
and labels.

Of the damage that decode prints, whole packets (those with `packet`) are written back byte for byte, \
also under --big-endian. A line that cannot be encoded is reported with its number and place, and left \
out.

Exit status: 0 all lines were encoded, 1 some were not, 2 misuse.";

/// Makes packets of JSON: the inverse of decode.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Encode {
    /// JSON, one packet a line
    #[arg(value_name = "FILE", default_value = "-")]
    file: PathBuf,
    /// Write hex text, one packet a line
    #[arg(long)]
    hex: bool,
    /// Write every packet big-endian, whatever its `endian` says
    #[arg(long)]
    big_endian: bool,
}

impl Encode {
    pub(crate) fn run(&self, out: &mut Output) -> anyhow::Result<Outcome> {
        if !self.hex && io::stdout().is_terminal() {
            anyhow::bail!("packets are not text for a terminal: add --hex, or `> FILE`");
        }
        let order = self.big_endian.then_some(ByteOrder::Big);
        let defaults = ReadDefaults { order, ..ReadDefaults::default() };
        let mut lines = JsonLines::new(Input::open(&self.file)?);
        let mut damaged = false;
        while let Some(result) = lines.next(|value| packet(value, &defaults))? {
            match result {
                Ok(bytes) if self.hex => writeln!(out, "{}", hex::encode(bytes))?,
                Ok(bytes) => out.write_all(&bytes)?,
                Err(BadLine(problem)) => {
                    damaged = true;
                    report::note(&problem);
                }
            }
            if !lines.is_ready() {
                out.flush()?;
            }
        }
        Ok(Outcome::damaged_if(damaged))
    }
}
