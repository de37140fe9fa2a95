//! `imc lsf cut`: part of a log as a log.

use super::scan::{Printing, log_file, scan};
use super::select::Select;
use crate::outcome::Outcome;
use crate::output::Output;
use crate::report::{self, counted};
use anyhow::{Context as _, bail};
use flate2::{Compression, write::GzEncoder};
use imc::lsf::LogItem;
use std::fs::File;
use std::io::{self, BufWriter, IsTerminal as _, Write};
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Examples:
  imc lsf cut Data.lsf.gz --from +30 --to +60 -o part.lsf
  imc lsf cut Data.lsf.gz -m EstimatedState -m GpsFix --keep-names -o track.lsf.gz
  imc lsf cut a/Data.lsf.gz b/Data.lsf.gz -o both.lsf      logs joined, damage left out
  imc lsf cut Data.lsf.gz -s ntnu-otter-01 | imc decode

The packets are written byte for byte as they are. Neptus MRA opens a folder that holds the result as \
Data.lsf beside the original's IMC.xml.gz.";

/// Writes the chosen packets, byte for byte, to a new log.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Cut {
    /// Logs, or their folders
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    #[command(flatten)]
    select: Select,
    /// New log to write, gzip'd if its name ends in .gz; standard output unless given
    #[arg(long, short, value_name = "FILE.lsf")]
    output: Option<PathBuf>,
    /// Keep all packets with names of entities and systems too, so that the new log has all names
    #[arg(long)]
    keep_names: bool,
}

impl Cut {
    pub(crate) fn run(&self, out: &mut Output) -> anyhow::Result<Outcome> {
        // Before the new file is made, so that an error leaves no file.
        let files = self.files.iter().map(|file| log_file(file)).collect::<anyhow::Result<Vec<_>>>()?;
        let selections =
            files.iter().map(|path| self.select.on(path, false)).collect::<anyhow::Result<Vec<_>>>()?;
        let (mut target, printing) = self.target(out)?;
        let (mut packets, mut bytes, mut damaged) = (0_u64, 0_u64, false);
        for (path, selection) in files.iter().zip(selections) {
            scan(path, printing, |item| {
                let LogItem::Packet { view, .. } = item else {
                    damaged = true;
                    return Ok(());
                };
                if selection.admits(view) || self.keep_names && imc::names::are_in(view.id()) {
                    packets += 1;
                    bytes += view.bytes().len() as u64;
                    target.write_all(view.bytes())?;
                }
                Ok(())
            })?;
        }
        target.finish()?;
        if let Some(path) = &self.output {
            let (packets, bytes) = (counted(packets, "packet"), counted(bytes, "byte"));
            report::note(&format!("{packets}, {bytes} written to {}", path.display()));
        }
        if damaged {
            report::note("damage in the input was left out; `imc lsf info` tells more");
        }
        Ok(Outcome::damaged_if(damaged))
    }

    fn target<'o>(&self, out: &'o mut Output) -> anyhow::Result<(Target<'o>, Printing)> {
        let Some(path) = &self.output else {
            if io::stdout().is_terminal() {
                bail!("packets are not text for a terminal: add -o FILE.lsf");
            }
            return Ok((Target::Standard(out), Printing::Meanwhile));
        };
        let place = || format!("cannot make {} (a file that exists is never overwritten)", path.display());
        let file = BufWriter::new(File::create_new(path).with_context(place)?);
        let packed = path.extension().is_some_and(|extension| extension == "gz");
        let target = if packed {
            Target::Packed(path.clone(), Box::new(GzEncoder::new(file, Compression::default())))
        } else {
            Target::Plain(path.clone(), file)
        };
        Ok((target, Printing::AtTheEnd))
    }
}

enum Target<'o> {
    Standard(&'o mut Output),
    Plain(PathBuf, BufWriter<File>),
    Packed(PathBuf, Box<GzEncoder<BufWriter<File>>>),
}

impl Target<'_> {
    fn write_all(&mut self, bytes: &[u8]) -> anyhow::Result<()> {
        match self {
            Self::Standard(out) => Ok(out.write_all(bytes)?),
            Self::Plain(path, file) => file.write_all(bytes).with_context(|| failed(path)),
            Self::Packed(path, file) => file.write_all(bytes).with_context(|| failed(path)),
        }
    }

    fn finish(self) -> anyhow::Result<()> {
        match self {
            Self::Standard(_) => Ok(()),
            Self::Plain(path, mut file) => file.flush().with_context(|| failed(&path)),
            Self::Packed(path, file) => {
                file.finish().and_then(|mut file| file.flush()).with_context(|| failed(&path))
            }
        }
    }
}

fn failed(path: &Path) -> String {
    format!("cannot write {}", path.display())
}
