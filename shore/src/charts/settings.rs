//! Settings of the sea chart.

use charts::depth_index::{EntryRule, EntryRules};
use guard::GuardLimits;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// The sea chart, and the demands of the grounding guard.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// The chart set; empty for `charts/chart.gpkg` in the folder of data.
    pub set: PathBuf,
    /// Least depth in which a vessel may be driven, by hand too (m).
    pub navigable_m: f64,
    /// Least depth in which it may go autonomously (m).
    pub autonomous_m: f64,
    /// Height above the water of a vessel that has not reported its own (m); 0 passes under everything.
    pub air_draught_m: f64,
    /// How plans into areas whose entry is prohibited are treated.
    pub entry_prohibited: EntryWord,
    /// How plans into areas whose entry is restricted, or that are to be avoided, are treated.
    pub entry_restricted: EntryWord,
    /// MiB of drawn tiles that are kept in memory.
    pub tiles_mib: u64,
}

/// A rule of entry as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum EntryWord {
    /// Plans into such areas are refused.
    Refuse,
    /// They cause a warning.
    Warn,
    /// They are accepted silently.
    Ignore,
}

impl EntryWord {
    fn rule(self) -> EntryRule {
        match self {
            Self::Refuse => EntryRule::Refuse,
            Self::Warn => EntryRule::Warn,
            Self::Ignore => EntryRule::Ignore,
        }
    }
}

impl Settings {
    /// The guard's limits for a vessel that has not reported its own.
    pub fn limits(&self) -> GuardLimits {
        GuardLimits {
            navigable_m: self.navigable_m,
            autonomous_m: self.autonomous_m,
            air_draught_m: Some(self.air_draught_m).filter(|height_m| *height_m > 0.0),
            entry: EntryRules {
                prohibited: self.entry_prohibited.rule(),
                restricted: self.entry_restricted.rule(),
            },
            ..GuardLimits::default()
        }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            set: PathBuf::new(),
            navigable_m: 1.0,
            autonomous_m: 5.0,
            air_draught_m: 2.0,
            entry_prohibited: EntryWord::Refuse,
            entry_restricted: EntryWord::Warn,
            tiles_mib: 64,
        }
    }
}
