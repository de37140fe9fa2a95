//! Reads a log from end to end, with a progress bar.

use super::zstd::{self, Unpacked};
use anyhow::{Context as _, bail};
use imc::lsf::{LogItem, LogReader};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::fs::File;
use std::io::{self, Chain, Cursor, IsTerminal as _, Read};
use std::path::{Path, PathBuf};

/// Files from which on progress is shown.
const LONG_BYTES: u64 = 32 << 20;

/// Whether lines go to standard output while a log is read; a bar would disturb them on a terminal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Printing {
    /// During the reading.
    Meanwhile,
    /// Only at the end, or not at all.
    AtTheEnd,
}

/// The log that a name stands for: a file, or the data in a log's folder.
///
/// # Errors
/// When a folder holds no log, or it is standard input.
pub(crate) fn log_file(path: &Path) -> anyhow::Result<PathBuf> {
    if path == Path::new("-") {
        bail!(
            "logs are read more than once, so standard input will not do: name a file, or use `imc decode`"
        );
    }
    if !path.is_dir() {
        return Ok(path.to_owned());
    }
    let candidates = ["Data.lsf", "Data.lsf.gz", "Data.lsf.zst"].map(|name| path.join(name));
    let found = candidates.into_iter().find(|file| file.is_file());
    found.with_context(|| format!("{} holds no Data.lsf, Data.lsf.gz or Data.lsf.zst", path.display()))
}

/// Passes everything in a log to `visit`, in order.
///
/// # Errors
/// When the file cannot be read, or `visit` fails.
pub(crate) fn scan(
    path: &Path,
    printing: Printing,
    mut visit: impl FnMut(&LogItem<'_>) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let file = File::open(path).with_context(|| format!("cannot open {}", path.display()))?;
    let bar = bar(path, &file, printing);
    let place = || format!("cannot read {}", path.display());
    let (is_packed, source) = looked_at(bar.wrap_read(file)).with_context(place)?;
    if is_packed {
        let mut source = Unpacked::new(source).with_context(place)?;
        let offset = items(&mut source, path, &mut visit)?;
        if let Some(problem) = source.problem() {
            visit(&LogItem::Cut { offset, problem })?;
        }
    } else {
        items(source, path, &mut visit)?;
    }
    bar.finish_and_clear();
    Ok(())
}

/// A source whose first bytes were read.
type FromStart<R> = Chain<Cursor<Vec<u8>>, R>;

/// Whether zstd packed a source, and the source from its start on. A pipe cannot be rewound, and may give its first bytes one by one.
fn looked_at<R: Read>(mut source: R) -> io::Result<(bool, FromStart<R>)> {
    let mut start = Vec::new();
    source.by_ref().take(zstd::MAGIC_BYTES).read_to_end(&mut start)?;
    Ok((zstd::is_packed(&start), Cursor::new(start).chain(source)))
}

/// Passes everything in a source to `visit`, in order; how many bytes it unpacks to.
fn items(
    source: impl Read,
    path: &Path,
    visit: &mut impl FnMut(&LogItem<'_>) -> anyhow::Result<()>,
) -> anyhow::Result<u64> {
    let place = || format!("cannot read {}", path.display());
    let mut reader = LogReader::detect(source).with_context(place)?;
    loop {
        match reader.next_item() {
            Ok(Some(item)) => visit(&item)?,
            Ok(None) => return Ok(reader.unpacked_bytes()),
            Err(error) => {
                let at = reader.unpacked_bytes();
                return Err(error).with_context(|| format!("{} after byte {at}", place()));
            }
        }
    }
}

/// The first packet's time, from which relative times count; 0 for a log without packets.
///
/// # Errors
/// When the file cannot be read.
pub(crate) fn start_s(path: &Path) -> anyhow::Result<f64> {
    let file = File::open(path).with_context(|| format!("cannot open {}", path.display()))?;
    let first =
        looked_at(file).and_then(
            |(is_packed, source)| {
                if is_packed { first_s(Unpacked::new(source)?) } else { first_s(source) }
            },
        );
    first.with_context(|| format!("cannot read {}", path.display()))
}

fn first_s(source: impl Read) -> io::Result<f64> {
    let mut reader = LogReader::detect(source)?;
    while let Some(item) = reader.next_item()? {
        if let LogItem::Packet { view, .. } = item
            && view.timestamp().is_finite()
        {
            return Ok(view.timestamp());
        }
    }
    Ok(0.0)
}

fn bar(path: &Path, file: &File, printing: Printing) -> ProgressBar {
    let size = file.metadata().map_or(0, |metadata| metadata.len());
    let seen = io::stderr().is_terminal()
        && (printing == Printing::AtTheEnd || !io::stdout().is_terminal())
        && size >= LONG_BYTES;
    if !seen {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{msg} {bar:30} {bytes}/{total_bytes} {eta}");
    let bar = ProgressBar::with_draw_target(Some(size), ProgressDrawTarget::stderr());
    let name = path.display().to_string();
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar())).with_message(name)
}
