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
    since: Option<MonoTime>,
}

impl Stray {
    pub(crate) fn new(settings: &Settings) -> Self {
        let mut stray = Self { patience: Duration::ZERO, limit_m: 0.0, since: None };
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
        self.since = None;
    }

    /// When it gives up, if it is on its way back.
    pub(crate) fn until(&self) -> Option<MonoTime> {
        self.since.map(|since| since + self.patience)
    }

    /// What is wrong with the path, as far as the plan is concerned.
    pub(crate) fn judge(&mut self, bus: &mut Bus, status: &PathStatus) -> Option<PathFault> {
        let now = bus.mono();
        let is_off = status.fault == Some(PathFault::OffTrack);
        if self.since.is_some() && status.geometry.cross_m().abs() <= self.limit_m {
            self.since = None;
            bus.entry(Entity::Path, Level::Info, "back on the track");
        } else if self.since.is_none() && is_off && !self.patience.is_zero() {
            self.since = Some(now);
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
