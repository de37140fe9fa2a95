//! Importing one S-57 cell with its updates.

use crate::error::{ChartDbError, Named as _, Result};
use crate::files::{self, Found};
use crate::locate::Zones;
use crate::read::Chart;
use crate::report::{ImportOptions, Imported, Outcome, outcome, unchanged};
use crate::stage::Stage;
use crate::write::{self, Entry, NewSource, Writer};
use charts::depth_index::unsafe_to_use;
use charts::s57::{Cell, NamedBytes, S57Error, S57Problem, SkinCheck};
use sha2::{Digest as _, Sha256};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Part of what names a cell's contents, changed when cells are read by other rules: one that was imported by older rules
/// may lack a danger, so it is read again when it is imported again.
const READING: &[u8] = b"lutra cell 3";

pub(crate) fn import(
    stage: &mut Stage,
    name: &str,
    paths: &BTreeMap<u16, PathBuf>,
    found: &Found,
    options: &ImportOptions,
) -> Result<Imported> {
    let mut named = Vec::new();
    let mut hash = Sha256::new_with_prefix(READING);
    for path in paths.values() {
        let bytes = files::read(path)?;
        found.verify(path, &bytes)?;
        hash.update((bytes.len() as u64).to_le_bytes());
        hash.update(&bytes);
        named.push((path.display().to_string(), bytes));
    }
    let sha256 = hex::encode(hash.finalize());
    let before = stage.chart(name)?;
    if let Some(chart) = before.as_ref().filter(|chart| chart.sha256 == sha256) {
        return Ok(unchanged(chart, "cell"));
    }
    let cell = match read(name, &named) {
        Err(S57Error { problem: S57Problem::Cancelled, file, .. }) => {
            return withdraw(stage, name, &file, options);
        }
        other => other?,
    };
    if let Some(chart) = &before {
        refuse_older(chart, &cell, &named[0].0)?;
    }
    let skin = accept(&cell, &named[0].0)?;
    let source = NewSource {
        name: name.to_owned(),
        kind: "cell",
        sha256,
        files: named.iter().map(|(name, _)| name.clone()).collect(),
        bytes: named.iter().map(|(_, bytes)| bytes.len() as u64).sum(),
        edition: cell.id.edition.clone(),
        update: cell.id.update.clone(),
        scale: cell.parameters.scale,
        band: cell.id.band,
        issued: cell.id.issue_date.clone(),
        updated: cell.id.update_date.clone(),
        standard: cell.id.standard.clone(),
        agency: cell.id.agency,
        datums: [
            cell.parameters.horizontal_datum,
            cell.parameters.vertical_datum,
            cell.parameters.sounding_datum,
        ],
        comment: cell.id.comment.clone(),
        skin: Some(skin),
        time: options.now.to_string(),
    };
    drop(named);
    let notices = notices(&cell, &skin, name);
    let features = stage.write(&source, before.as_ref(), notices.clone(), |writer| {
        let zones = Zones::of(&cell.features);
        cell.features.iter().try_for_each(|feature| writer.feature(feature, &zones))
    })?;
    Ok(Imported {
        name: name.to_owned(),
        kind: "cell",
        outcome: outcome(before.as_ref()),
        edition: source.edition,
        update: source.update,
        features,
        skin: Some(skin),
        notices: notices.into_iter().map(|(file, _, text)| format!("{file}: {text}")).collect(),
    })
}

fn read(name: &str, files: &[(String, Vec<u8>)]) -> Result<Cell, S57Error> {
    let all: Vec<NamedBytes<'_>> = files.iter().map(|(name, bytes)| NamedBytes { name, bytes }).collect();
    let fail = |problem| S57Error { file: files[0].0.clone(), place: None, problem };
    if !files[0].0.to_ascii_uppercase().ends_with(".000") {
        return Err(fail(S57Problem::NoBase));
    }
    let cell = Cell::read(all[0], &all[1..])?;
    let said = cell.id.name.split('.').next().unwrap_or_default();
    if said.eq_ignore_ascii_case(name) {
        Ok(cell)
    } else {
        let (expected, found) = (name.to_owned(), said.to_owned());
        Err(fail(S57Problem::OtherCell { expected, found }))
    }
}

/// A cell that does not say how deep it is, or where a danger lies, must not be used for navigation.
fn accept(cell: &Cell, file: &str) -> Result<SkinCheck, S57Error> {
    let skin = cell.skin_check();
    let refused = |problem| S57Error { file: file.to_owned(), place: None, problem };
    unsafe_to_use(cell, &skin).map_or(Ok(skin), |problem| Err(refused(problem)))
}

fn refuse_older(chart: &Chart, cell: &Cell, file: &str) -> Result<()> {
    let number = |text: &str| text.trim().parse::<u32>().unwrap_or(0);
    let held = (number(&chart.edition), number(&chart.update));
    let new = (number(&cell.id.edition), number(&cell.id.update));
    if new >= held {
        return Ok(());
    }
    let problem = format!(
        "edition {} with update {} is older than what the chart set holds (edition {}, update {}); fetch the \
         newest, or take the newer one out first by `lutra-server chart remove {}`",
        new.0, new.1, held.0, held.1, chart.name
    );
    Err(ChartDbError::file(file, problem))
}

/// File, record and text of what was dropped or repaired, the result of the acceptance check first.
fn notices(cell: &Cell, skin: &SkinCheck, name: &str) -> Vec<(String, Option<u32>, String)> {
    let mut notices = Vec::new();
    if !skin.holds() {
        let place = skin.amiss_at.map_or_else(String::new, |at| {
            format!(
                ", {:.9} are gaps or overlaps, most at {:.5}, {:.5}",
                skin.amiss_deg2, at.lat_deg, at.lon_deg
            )
        });
        let text = format!(
            "the depth areas and the land ({:.9} square degrees) do not tile what the cell covers ({:.9}){place}; \
             gaps count as no data, overlaps as the shallower; {} areas do not close",
            skin.skin_deg2, skin.coverage_deg2, skin.unreadable
        );
        notices.push((name.to_owned(), None, text));
    }
    notices.extend(cell.notices.iter().map(|one| (one.file.clone(), one.feature, one.text.clone())));
    notices
}

fn withdraw(stage: &mut Stage, name: &str, file: &str, options: &ImportOptions) -> Result<Imported> {
    let text = "cancelled by its producer";
    let entry = Entry { source: None, cell: name, file, record: None, what: "removed", text };
    stage.take_out(&options.now.to_string(), &entry)?;
    Ok(Imported {
        name: name.to_owned(),
        kind: "cell",
        outcome: Outcome::Withdrawn,
        edition: String::new(),
        update: String::new(),
        features: 0,
        skin: None,
        notices: vec![format!("{file}: the producer has cancelled this cell")],
    })
}

/// What is noted of a chart: file, record, text.
pub(crate) type Notices = Vec<(String, Option<u32>, String)>;

impl Stage {
    /// Writes a chart in place of the previous one, in one transaction.
    pub(crate) fn write(
        &mut self,
        source: &NewSource,
        before: Option<&Chart>,
        notices: Notices,
        fill: impl FnOnce(&mut Writer<'_>) -> Result<()>,
    ) -> Result<u64> {
        let mut notices = notices;
        self.write_noting(source, before, &mut notices, |writer, _| fill(writer))
    }

    /// The same, where the notes are found while writing.
    pub(crate) fn write_noting(
        &mut self,
        source: &NewSource,
        before: Option<&Chart>,
        notices: &mut Notices,
        fill: impl FnOnce(&mut Writer<'_>, &mut Notices) -> Result<()>,
    ) -> Result<u64> {
        let part = self.part().to_owned();
        let whole = self.connection().transaction().named(&part)?;
        write::remove(&whole, &source.name).named(&part)?;
        let mut writer = Writer::new(&whole, &part, source).named(&part)?;
        fill(&mut writer, notices)?;
        let id = Some(writer.id());
        let features = writer.finish().named(&part)?;
        let file = source.files.first().map_or("", String::as_str);
        let (what, text) = match outcome(before) {
            Outcome::Replaced { before } => ("replaced", before),
            _ => ("imported", format!("{features} features")),
        };
        let log = |file, record, what, text| {
            let entry = Entry { source: id, cell: &source.name, file, record, what, text };
            write::log(&whole, &source.time, &entry).named(&part)
        };
        log(file, None, what, &text)?;
        for (file, record, text) in notices.iter() {
            log(file, *record, "notice", text)?;
        }
        whole.commit().named(&part)?;
        Ok(features)
    }
}
