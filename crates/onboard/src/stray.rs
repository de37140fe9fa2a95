//! A vessel that is too far from its track: it steers back for a while before its plan fails.

use crate::bus::Bus;
use crate::entity::Entity;
use crate::output::Level;
use crate::settings::Settings;
use control::{CrossTrackConfig, PathFault, PathStatus};
use std::time::Duration;
use units::MonoTime;

/// The way back to a track.
#[derive(Debug, Clone)]
pub(crate) struct Stray {
    /// How long it may take; zero fails at once.
    patience: Duration,
    limit_m: f64,
    back: Option<Back>,
}

/// A way back that is under way.
#[derive(Debug, Clone)]
struct Back {
    /// How long it may still take.
    left: Duration,
    /// When that was reckoned.
    at: MonoTime,
}

/// The longest time between two steps of a vessel that steers; what is longer it waited, for a position or an operator.
const STEP: Duration = Duration::from_secs(1);

impl Stray {
    pub(crate) fn new(settings: &Settings) -> Self {
        let mut stray = Self { patience: Duration::ZERO, limit_m: 0.0, back: None };
        stray.reconfigure(settings);
        stray
    }

    pub(crate) fn reconfigure(&mut self, settings: &Settings) {
        self.patience = settings.mission.track_recovery;
        self.limit_m =
            settings.path.cross_track.map_or(f64::INFINITY, |CrossTrackConfig { limit_m, .. }| limit_m);
    }

    /// Another path, or none.
    pub(crate) fn forget(&mut self) {
        self.back = None;
    }

    /// When it gives up, if it is on its way back and steers all the time.
    pub(crate) fn until(&self) -> Option<MonoTime> {
        self.back.as_ref().map(|back| back.at + back.left)
    }

    /// The fault of the path, as far as it concerns the plan.
    pub(crate) fn judge(&mut self, bus: &mut Bus, status: &PathStatus) -> Option<PathFault> {
        let now = bus.mono();
        let is_off = status.fault == Some(PathFault::OffTrack);
        if let Some(back) = &mut self.back {
            back.left = back.left.saturating_sub(now.since(back.at).min(STEP));
            back.at = now;
        }
        if self.back.is_some() && status.geometry.cross_m().abs() <= self.limit_m {
            self.back = None;
            bus.entry(Entity::Path, Level::Info, "back on the track");
        } else if self.back.is_none() && is_off && !self.patience.is_zero() {
            self.back = Some(Back { left: self.patience, at: now });
            let patience_s = self.patience.as_secs();
            let text = format!(
                "too far from the track; it steers back, and fails if that takes more than {patience_s} s"
            );
            bus.entry(Entity::Path, Level::Warning, text);
        }
        match self.until() {
            Some(until) if now >= until => Some(PathFault::OffTrack),
            // On the way back there may be no progress along the track.
            Some(_) => status.fault.filter(|fault| *fault == PathFault::NoNewPath),
            None => status.fault,
        }
    }
}
