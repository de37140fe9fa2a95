//! The settings of the grounding supervisor, and its chart.

use crate::routing::RouteSettings;
use charts::depth_index::{DepthIndex, IndexError, SealedIndex};
use guard::GuardLimits;
use sha2::{Digest as _, Sha256};
use std::fmt;
use std::sync::Arc;

/// The grounding supervisor. All of it is set in the files alone, but the two words of the exemption.
#[derive(Debug, Clone, PartialEq)]
pub struct GroundingSettings {
    /// The chart it uses.
    pub chart: Chart,
    /// Whether plans are refused while the chart cannot be read.
    pub refuses_without: bool,
    /// The limits of the guard.
    pub limits: GuardLimits,
    /// Danger on the course within this time is warned of (s).
    pub warning_time_s: f64,
    /// Danger on the course within this distance is warned of (m).
    pub warning_distance_m: f64,
    /// Time at full way before braking works (s).
    pub reaction_s: f64,
    /// Braking that can be relied upon (m/s²).
    pub deceleration_mps2: f64,
    /// Distance kept from danger under manual control beyond stopping (m).
    pub reserve_m: f64,
    /// What to do in a plan within stopping distance of danger.
    pub action: GroundingAction,
    /// Time in danger with the motors running after which they stop for good (s); 0 never.
    pub abort_after_s: f64,
    /// An operator asks to steer unguarded for so long (s).
    pub override_request_s: f64,
    /// The same again.
    pub override_confirm_s: f64,
    /// Routes around what the chart refuses.
    pub routes: RouteSettings,
}

impl Default for GroundingSettings {
    fn default() -> Self {
        Self {
            chart: Chart::Off,
            refuses_without: true,
            limits: GuardLimits::default(),
            warning_time_s: 30.0,
            warning_distance_m: 20.0,
            reaction_s: 3.0,
            deceleration_mps2: 0.3,
            reserve_m: 5.0,
            action: GroundingAction::DeepWater,
            abort_after_s: 60.0,
            override_request_s: 0.0,
            override_confirm_s: 0.0,
            routes: RouteSettings::default(),
        }
    }
}

impl GroundingSettings {
    /// Way from seeing danger to lying still (m), at this speed.
    pub(crate) fn stopping_m(&self, speed_mps: f64) -> f64 {
        speed_mps * self.reaction_s + speed_mps * speed_mps / (2.0 * self.deceleration_mps2)
    }
}

/// What to do in a plan within stopping distance of danger.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum GroundingAction {
    /// Report it.
    Warn,
    /// And slow down.
    Slow,
    /// End the plan and drift.
    Stop,
    /// Turn back to deep water and keep station there.
    DeepWater,
}

/// The chart aboard.
#[derive(Debug, Clone, PartialEq)]
pub enum Chart {
    /// None is configured: nothing is checked.
    Off,
    /// One is configured and cannot be read.
    Unreadable {
        /// Why, and what to do.
        reason: String,
    },
    /// It is there.
    Loaded(ChartFile),
}

/// A depth index and where it came from.
#[derive(Clone, PartialEq)]
pub struct ChartFile {
    name: String,
    digest: [u8; 32],
    index: Arc<DepthIndex>,
}

impl Chart {
    /// The chart in the bytes of a file, a depth index from beside a chart set or a separate one; `name` is what
    /// it is called.
    pub fn read(name: &str, bytes: &[u8]) -> Self {
        match ChartFile::read(name, bytes) {
            Ok(file) => Self::Loaded(file),
            Err(error) => Self::Unreadable { reason: format!("{name}: {error}") },
        }
    }

    /// A chart that was made already.
    pub fn of(name: &str, index: DepthIndex) -> Self {
        let digest = Sha256::digest(index.to_bytes()).into();
        Self::Loaded(ChartFile { name: name.to_owned(), digest, index: Arc::new(index) })
    }

    /// Digest of the file; `None` without a chart.
    pub fn digest(&self) -> Option<[u8; 32]> {
        match self {
            Self::Loaded(file) => Some(file.digest),
            Self::Off | Self::Unreadable { .. } => None,
        }
    }

    pub(crate) fn index(&self) -> Option<&DepthIndex> {
        match self {
            Self::Loaded(file) => Some(&file.index),
            Self::Off | Self::Unreadable { .. } => None,
        }
    }
}

impl ChartFile {
    /// As [`Chart::read`].
    ///
    /// # Errors
    /// When the bytes are not a depth index, of another version, or damaged.
    pub fn read(name: &str, bytes: &[u8]) -> Result<Self, IndexError> {
        let index = match SealedIndex::digest_of(bytes) {
            Some(_) => SealedIndex::from_bytes(bytes)?.index,
            None => DepthIndex::from_bytes(bytes)?,
        };
        Ok(Self { name: name.to_owned(), digest: Sha256::digest(bytes).into(), index: Arc::new(index) })
    }

    /// As it was when it was taken apart.
    pub(crate) fn whole(name: String, digest: [u8; 32], index: DepthIndex) -> Self {
        Self { name, digest, index: Arc::new(index) }
    }

    /// Its index, for storing it.
    pub(crate) fn shared_index(&self) -> Arc<DepthIndex> {
        Arc::clone(&self.index)
    }

    /// Its name.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// SHA-256 of the file's bytes.
    pub fn digest(&self) -> [u8; 32] {
        self.digest
    }

    /// Its contents, for people.
    pub fn edition(&self) -> String {
        self.index.edition()
    }

    pub(crate) fn index(&self) -> &DepthIndex {
        &self.index
    }
}

impl fmt::Display for ChartFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The shore does not need to know where the file lies aboard.
        let name = self.name.rsplit('/').next().unwrap_or(&self.name);
        match self.index.sources() {
            [one] => write!(f, "{} (edition {}, update {})", one.name, one.edition, one.update),
            all => write!(f, "{name} ({} cells)", all.len()),
        }
    }
}

impl fmt::Debug for ChartFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // A chart has millions of numbers.
        write!(f, "ChartFile({self}, {} vertices)", self.index.vertex_count())
    }
}
