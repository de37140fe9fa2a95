//! A Darwin Core archive: occurrences, what was measured of them, and files that describe both, in a zip file.
//!
//! Occurrences go out as they come. Measurements wait until the last occurrence is there, as a zip file has one file after another.

use super::super::about::{About, Covered};
use super::super::waiting::{Spool, Waiting};
use super::super::zip::Zip;
use super::hours::{Hours, Row};
use super::{after, before, cells, eml, facts, generalization, is_occurrence, meta};
use crate::study::Heard;
use std::collections::BTreeSet;
use std::io::{self, BufRead as _, Write};

pub(super) const OCCURRENCES: &str = "occurrence.csv";
pub(super) const FACTS: &str = "extendedmeasurementorfact.csv";
pub(super) const DESCRIPTION: &str = "eml.xml";

/// Which detections become occurrences.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in super::super) enum Keep {
    /// Of each animal, vessel and hour the one that was heard first.
    FirstOfHour,
    Every,
}

/// An archive on its way.
#[derive(Debug)]
pub(in super::super) struct Archive {
    keep: Keep,
    zip: Zip,
    hours: Hours,
    facts: Waiting,
    /// Animals whose length and weight stand there already.
    measured: BTreeSet<String>,
    covered: Covered,
}

/// The row of a detection, with the length and weight of its animal where those stand with it.
fn row(heard: &Heard<'_>, has_animal: bool) -> Row {
    let (heard_us, cell_m) = (heard.time_us, heard.cell_m);
    let mut row = Row { of: 1, heard_us, has_animal, cell_m, ..Row::default() };
    before(&mut cells(&mut row.before, false), heard);
    after(&mut cells(&mut row.after, true), heard);
    facts::write(&mut row.facts, heard, has_animal);
    row
}

impl Archive {
    /// With the begin of its table of occurrences.
    ///
    /// # Errors
    /// There is no place where measurements can wait.
    pub(in super::super) fn new(
        keep: Keep,
        spool: Option<Box<dyn Spool>>,
        out: &mut Vec<u8>,
    ) -> io::Result<Self> {
        let mut zip = Zip::default();
        zip.begin(out, OCCURRENCES)?;
        zip.push(out, super::FORMAT.header.as_bytes())?;
        Ok(Self {
            keep,
            zip,
            hours: Hours::default(),
            facts: Waiting::new(spool)?,
            measured: BTreeSet::new(),
            covered: Covered::default(),
        })
    }

    /// Takes a detection; `false` where it becomes no row of its own.
    ///
    /// # Errors
    /// Where measurements wait is full, or the archive is too long.
    pub(in super::super) fn row(&mut self, out: &mut Vec<u8>, heard: &Heard<'_>) -> io::Result<bool> {
        let (true, Some(animal)) = (is_occurrence(heard), heard.animal) else { return Ok(false) };
        while let Some(row) = self.hours.next(Some(heard)) {
            self.write(out, &row)?;
        }
        let is_hourly = self.keep == Keep::FirstOfHour;
        if is_hourly && let Some(waiting) = self.hours.count(heard) {
            // Reported later, heard earlier: from a receiver's memory, or after a gap.
            if heard.time_us < waiting.heard_us {
                *waiting = Row { of: waiting.of, ..row(heard, waiting.has_animal) };
                self.covered.take(heard);
            }
            return Ok(false);
        }
        self.covered.take(heard);
        let row = row(heard, self.measured.insert(animal.name.clone()));
        if is_hourly {
            self.hours.open(heard, row);
        } else {
            self.write(out, &row)?;
        }
        Ok(true)
    }

    fn write(&mut self, out: &mut dyn Write, row: &Row) -> io::Result<()> {
        let mut line = row.before.clone();
        let of = (self.keep == Keep::FirstOfHour).then_some(row.of);
        cells(&mut line, true).text(&generalization(of, row.cell_m));
        line.extend_from_slice(&row.after);
        line.push(b'\n');
        self.zip.push(out, &line)?;
        self.facts.push(&row.facts)
    }

    /// Writes what still waits, and the files that describe the tables.
    ///
    /// # Errors
    /// As [`Self::row()`], or `out` cannot be written.
    pub(in super::super) fn end(mut self, out: &mut dyn Write, about: &About) -> io::Result<()> {
        while let Some(row) = self.hours.next(None) {
            self.write(out, &row)?;
        }
        let Self { mut zip, facts: waiting, covered, keep, .. } = self;
        zip.begin(out, FACTS)?;
        zip.push(out, facts::HEADER.as_bytes())?;
        let mut waiting = waiting.read()?;
        loop {
            let chunk = waiting.fill_buf()?;
            let bytes = chunk.len();
            if bytes == 0 {
                break;
            }
            zip.push(out, chunk)?;
            waiting.consume(bytes);
        }
        zip.begin(out, "meta.xml")?;
        zip.push(out, meta::meta().as_bytes())?;
        zip.begin(out, DESCRIPTION)?;
        zip.push(out, eml::eml(about, &covered, keep).as_bytes())?;
        zip.end(out)
    }
}
