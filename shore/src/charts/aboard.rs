//! Which chart each vessel holds, as last reported. Kept in a file for restarts, and for `lutra-server chart sync` while no
//! server runs.

use api::{ChartDifference, VesselChart};
use imc::Address;
use link::{ChartDigest, ChartReport, ChartStage};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use units::UtcTime;

/// The last report of a vessel.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Reported {
    /// SHA-256 of the file in force, in hexadecimal digits; null for none.
    held: Option<String>,
    edition: String,
    stage: Stage,
    have: u64,
    of: u64,
    text: String,
    at_us: i64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Stage {
    Settled,
    Fetching,
    Waiting,
    Failed,
    Declined,
}

impl Reported {
    fn of(report: ChartReport, at_us: i64) -> Self {
        Self {
            held: (report.held != [0; 32]).then(|| hex::encode(report.held)),
            edition: report.edition,
            stage: match report.stage {
                ChartStage::Settled | ChartStage::Other(_) => Stage::Settled,
                ChartStage::Fetching => Stage::Fetching,
                ChartStage::Waiting => Stage::Waiting,
                ChartStage::Failed => Stage::Failed,
                ChartStage::Declined => Stage::Declined,
            },
            have: report.have,
            of: report.of,
            text: report.text,
            at_us,
        }
    }

    /// How the vessel's chart differs from the one ashore, if there is one.
    fn difference(&self, ashore: bool) -> ChartDifference {
        match self.stage {
            _ if !ashore => ChartDifference::NoneAshore,
            Stage::Settled => ChartDifference::Other,
            Stage::Fetching => ChartDifference::Fetching {
                percent: (self.have.saturating_mul(100) / self.of.max(1)).min(100) as u8,
            },
            Stage::Waiting => ChartDifference::Waiting { why: self.text.clone() },
            Stage::Failed => ChartDifference::Failed { why: self.text.clone() },
            Stage::Declined => ChartDifference::Declined,
        }
    }
}

/// All vessels; cheap to clone.
#[derive(Debug, Clone)]
pub struct ChartsAboard(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    path: PathBuf,
    told: Mutex<BTreeMap<u16, Reported>>,
    /// Held while the file is written.
    saving: Mutex<()>,
}

impl ChartsAboard {
    /// Reads the file in a data folder. An unreadable file counts as absent: vessels report again.
    pub fn open(data: &Path) -> Self {
        let path = data.join("charts/aboard.json");
        let told = read(&path).unwrap_or_else(|error| {
            tracing::warn!(%error, "which charts are aboard is known when the vessels say it again");
            BTreeMap::new()
        });
        Self(Arc::new(Shared { path, told: Mutex::new(told), saving: Mutex::default() }))
    }

    /// Stores a vessel's report.
    pub fn tell(&self, vessel: Address, report: ChartReport, at: UtcTime) {
        let mut told = self.0.told.lock().unwrap_or_else(PoisonError::into_inner);
        told.insert(vessel.0, Reported::of(report, at.micros()));
    }

    /// Writes the file.
    pub fn save(&self) {
        let _saving = self.0.saving.lock().unwrap_or_else(PoisonError::into_inner);
        let told = self.0.told.lock().unwrap_or_else(PoisonError::into_inner).clone();
        if let Err(error) = write(&self.0.path, &told) {
            tracing::warn!(%error, "which charts are aboard will not be known after a restart");
        }
    }

    /// The vessels that have reported.
    pub fn vessels(&self) -> Vec<u16> {
        self.0.told.lock().unwrap_or_else(PoisonError::into_inner).keys().copied().collect()
    }

    /// A vessel's chart compared with the one ashore.
    pub fn chart(&self, vessel: Address, ashore: Option<ChartDigest>) -> VesselChart {
        let told = self.0.told.lock().unwrap_or_else(PoisonError::into_inner);
        compared(told.get(&vessel.0), ashore)
    }
}

fn read(path: &Path) -> io::Result<BTreeMap<u16, Reported>> {
    match fs::read(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(BTreeMap::new()),
        Err(error) => Err(error),
        Ok(bytes) => Ok(serde_json::from_slice(&bytes)?),
    }
}

fn write(path: &Path, told: &BTreeMap<u16, Reported>) -> io::Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let part = path.with_extension("json.part");
    fs::write(&part, serde_json::to_vec(told)?)?;
    fs::rename(&part, path)
}

/// The comparison, with a text.
fn compared(told: Option<&Reported>, ashore: Option<ChartDigest>) -> VesselChart {
    let Some(told) = told else {
        let text = "not known: the vessel has not reported since it was set up, or its program is too old";
        return VesselChart { state: "unknown".to_owned(), text: text.to_owned(), ..VesselChart::default() };
    };
    let ashore = ashore.map(hex::encode);
    let held = told.held.is_some();
    let difference = (told.held != ashore || !held).then(|| told.difference(ashore.is_some()));
    let state = match &difference {
        None => "same",
        Some(ChartDifference::NoneAshore) if !held => "none",
        Some(ChartDifference::NoneAshore | ChartDifference::Other) => "other",
        Some(ChartDifference::Fetching { .. }) => "fetching",
        Some(ChartDifference::Waiting { .. }) => "waiting",
        Some(ChartDifference::Failed { .. }) => "failed",
        Some(ChartDifference::Declined) => "declined",
    };
    VesselChart {
        state: state.to_owned(),
        text: difference.as_ref().map_or_else(|| "up to date".to_owned(), |one| one.english(held)),
        edition: held.then(|| told.edition.clone()),
        digest: told.held.clone(),
        difference,
        told_us: Some(told.at_us),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_vessels_hold_is_known_over_restarts_and_compared_with_the_shore() {
        let data = tempfile::tempdir().unwrap();
        let otter = Address(0x2810);
        let aboard = ChartsAboard::open(data.path());
        assert_eq!(aboard.chart(otter, Some([7; 32])).state, "unknown");
        let report =
            ChartReport { held: [6; 32], edition: "sea edition 2".to_owned(), ..ChartReport::default() };
        let state = |report: &ChartReport, ashore| {
            aboard.tell(otter, report.clone(), UtcTime::from_micros(1));
            aboard.save();
            let chart = ChartsAboard::open(data.path()).chart(otter, ashore);
            (chart.state, chart.text)
        };
        let told = |state: &str, text: &str| (state.to_owned(), text.to_owned());
        assert_eq!(state(&report, Some([6; 32])), told("same", "up to date"));
        assert_eq!(state(&report, Some([7; 32])), told("other", "another sea chart than ashore"));
        assert_eq!(
            state(&report, None),
            told("other", "there is no sea chart ashore to compare the vessel's with")
        );
        let fetching = ChartReport { stage: ChartStage::Fetching, have: 43, of: 100, ..report.clone() };
        assert_eq!(
            state(&fetching, Some([7; 32])),
            told("fetching", "another sea chart than ashore; 43 % of the shore's is transferred")
        );
        let none = ChartReport { held: [0; 32], ..fetching };
        assert_eq!(
            state(&none, Some([7; 32])),
            told("fetching", "no sea chart aboard; 43 % of the shore's is transferred")
        );
        let failed = ChartReport { stage: ChartStage::Failed, text: "disk full".to_owned(), ..report };
        assert_eq!(
            state(&failed, Some([7; 32])),
            told(
                "failed",
                "another sea chart than ashore; the chart from shore could not be used: disk full"
            )
        );
        assert_eq!(aboard.vessels(), [0x2810]);

        // An unreadable file counts as absent.
        fs::write(data.path().join("charts/aboard.json"), b"{").unwrap();
        assert_eq!(ChartsAboard::open(data.path()).chart(otter, None).state, "unknown");
    }
}
