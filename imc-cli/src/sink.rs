//! Destination of a link's packets: the selected ones go to standard output as JSON and to a log unchanged.

use crate::outcome::Outcome;
use crate::output::Output;
use crate::pick::Pick;
use crate::record::{self, Place};
use anyhow::Context as _;
use imc::{Frame, Frames, ShortPayload};
use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Whether reading of a link continues.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Flow {
    /// Go on.
    More,
    /// The wanted number of packets has come.
    Done,
    /// The other side has closed the link, for this reason.
    Closed(String),
}

/// Shows packets and counts them.
pub(crate) struct Sink<'o> {
    out: &'o mut Output,
    pick: &'o Pick,
    /// How many more packets are wanted.
    left: Option<u64>,
    save: Option<(PathBuf, File)>,
    damaged: bool,
    line: Vec<u8>,
}

impl<'o> Sink<'o> {
    /// Shows what `pick` admits, `count` packets if that is given.
    pub(crate) fn new(out: &'o mut Output, pick: &'o Pick, count: Option<u64>) -> Self {
        Self { out, pick, left: count, save: None, damaged: false, line: Vec::new() }
    }

    /// Also writes the packets' own bytes to a new log.
    ///
    /// # Errors
    /// When the file exists or cannot be made.
    pub(crate) fn save_to(&mut self, path: &Path) -> anyhow::Result<()> {
        let place = || format!("cannot save to {} (a file that exists is never overwritten)", path.display());
        let file = File::create_new(path).with_context(place)?;
        self.save = Some((path.to_owned(), file));
        Ok(())
    }

    /// Processes a datagram or message.
    ///
    /// # Errors
    /// When standard output or the log cannot be written.
    pub(crate) fn datagram(&mut self, bytes: &[u8], from: &str) -> anyhow::Result<Flow> {
        for frame in Frames::new(bytes) {
            if self.frame(&frame, from)? == Flow::Done {
                return Ok(Flow::Done);
            }
        }
        Ok(Flow::More)
    }

    /// Processes a packet, or damage, which is always shown.
    ///
    /// # Errors
    /// When standard output or the log cannot be written.
    pub(crate) fn frame(&mut self, frame: &Frame<'_>, from: &str) -> anyhow::Result<Flow> {
        let mut wanted = None;
        if let Frame::Packet { view, .. } = frame {
            if !self.pick.admits(view) {
                return Ok(Flow::More);
            }
            wanted = Some(view);
        }
        if let (Some(view), Some((path, file))) = (wanted, &mut self.save) {
            // Unbuffered: nothing is lost when the command is interrupted.
            file.write_all(view.bytes()).with_context(|| format!("cannot write {}", path.display()))?;
        }
        self.line.clear();
        let place = Place { from: Some(from), ..Place::default() };
        self.damaged |= !record::frame(&mut self.line, frame, place, ShortPayload::default());
        self.out.write_all(&self.line)?;
        if let (Some(_), Some(left)) = (wanted, &mut self.left) {
            *left = left.saturating_sub(1);
        }
        Ok(if self.left == Some(0) { Flow::Done } else { Flow::More })
    }

    /// Flushes standard output.
    ///
    /// # Errors
    /// When standard output cannot be written.
    pub(crate) fn flush(&mut self) -> anyhow::Result<()> {
        Ok(self.out.flush()?)
    }

    /// Whether all was sound so far.
    pub(crate) fn outcome(&self) -> Outcome {
        Outcome::damaged_if(self.damaged)
    }
}
