//! What a route is good for, from the command line.

use super::zones;
use anyhow::{Context as _, ensure};
use api::SeaRouteObjective;
use clap::{Args, ValueEnum};
use geofile::currents::{self, CurrentField};
use planner::{CurrentGrid, Currents, Flow, Objective, Preferences, SpeedLimit};
use shore::clock::Clock;
use std::fs;
use std::path::{Path, PathBuf};
use units::UtcTime;

/// Larger files of currents are refused (bytes).
const LARGEST_FIELD: u64 = 256 << 20;

#[derive(Debug, Args)]
pub(super) struct ObjectiveArguments {
    /// What the route is good for.
    #[arg(long, value_enum, default_value_t = Best::Shortest)]
    objective: Best,
    /// Water shallower than this at the water level (--water-level) costs more (m).
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    prefer_depth: Option<f64>,
    /// Water nearer than this to land, dangers and water that is not deep enough costs more (m).
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    prefer_off: Option<f64>,
    /// How many times as much water costs that is not preferred.
    #[arg(long, value_name = "N", default_value_t = 3.0, allow_negative_numbers = true)]
    prefer_factor: f64,
    /// How many times as much a metre costs in traffic lanes, separation zones and deep-water routes of the chart; the surcharge
    /// is twice as large against a lane. 1 does not mind them.
    #[arg(long, value_name = "N", default_value_t = 3.0, allow_negative_numbers = true)]
    traffic_factor: f64,
    /// A speed limit (m/s) in the polygons of a GeoJSON file; may be repeated.
    #[arg(long, value_name = "MPS,FILE", value_parser = limit)]
    limit: Vec<(f64, PathBuf)>,
    /// A steady current that time and energy are reckoned in: how fast it flows (m/s), and where to (degrees), like 0.4@250.
    #[arg(long, value_name = "MPS@DEG", value_parser = current)]
    current: Option<Flow>,
    /// A current that changes with place and time, from a file.
    #[arg(long, value_name = "FILE", conflicts_with = "current")]
    current_field: Option<PathBuf>,
    /// When the route begins: which times of the current field count [default: now].
    #[arg(long, value_name = "TIME")]
    depart: Option<UtcTime>,
}

/// What a route is good for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Best {
    /// The least length.
    Shortest,
    /// The least time.
    Fastest,
    /// The least energy, at --speed or slower.
    LeastEnergy,
}

impl ObjectiveArguments {
    /// The objective at a speed through the water (m/s), with its files read.
    pub(super) fn read(&self, speed_mps: f64) -> anyhow::Result<Objective> {
        let best = match self.objective {
            Best::Shortest => SeaRouteObjective::Shortest,
            Best::Fastest => SeaRouteObjective::Fastest,
            Best::LeastEnergy => SeaRouteObjective::LeastEnergy,
        };
        let currents = match &self.current_field {
            Some(file) => Currents::Grid(current_field(file).with_context(|| file.display().to_string())?),
            None => Currents::Steady(self.current.unwrap_or_default()),
        };
        let mut limits = Vec::new();
        for (most_mps, file) in &self.limit {
            let all = zones::read_all(file)?;
            limits.extend(all.into_iter().map(|zone| SpeedLimit { zone, most_mps: *most_mps }));
        }
        let Self { prefer_depth: depth_m, prefer_off: off_m, prefer_factor: factor, .. } = *self;
        Ok(Objective {
            currents,
            preferences: Preferences { depth_m, off_m, factor },
            limits,
            traffic_factor: self.traffic_factor,
            depart_s: self.depart.unwrap_or_else(|| Clock::real().utc()).seconds(),
            ..shore::routing::aimed(best, speed_mps)
        })
    }
}

fn current_field(file: &Path) -> anyhow::Result<CurrentGrid> {
    let size = fs::metadata(file)?.len();
    ensure!(
        size <= LARGEST_FIELD,
        "it is larger than {} MB; cut it to the area and the time of the route",
        LARGEST_FIELD >> 20
    );
    let CurrentField { times_s, lats_deg, lons_deg, east_mps, north_mps } = currents::read(&fs::read(file)?)?;
    Ok(CurrentGrid::new(times_s, lats_deg, lons_deg, &east_mps, &north_mps)?)
}

fn limit(text: &str) -> Result<(f64, PathBuf), String> {
    let parts = text.split_once(',').and_then(|(mps, file)| Some((mps.trim().parse().ok()?, file.into())));
    parts.ok_or_else(|| "give a speed in m/s and a GeoJSON file, such as 2.5,harbour.geojson".to_owned())
}

fn current(text: &str) -> Result<Flow, String> {
    // With a comma the direction once stood first, which nothing can tell from a speed.
    if text.contains(',') {
        return Err("write how fast it flows before where to, with an @ between, like 0.4@250".to_owned());
    }
    let numbers = text.split_once('@').map(|(drift, set)| (drift.trim().parse(), set.trim().parse()));
    match numbers {
        Some((Ok(drift_mps), Ok(set_deg)))
            if (-360.0..=360.0).contains(&set_deg) && (0.0..=10.0).contains(&drift_mps) =>
        {
            Ok(Flow::set_and_drift(f64::to_radians(set_deg), drift_mps))
        }
        _ => Err("give how fast it flows, 0 to 10 m/s, and where to in degrees, like 0.4@250".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_current_says_which_number_is_its_speed() {
        assert_eq!(current("0.4@250"), Ok(Flow::set_and_drift(250.0_f64.to_radians(), 0.4)));
        assert_eq!(current("1 @ -90"), Ok(Flow::set_and_drift(-90.0_f64.to_radians(), 1.0)));
        for ambiguous in ["250,0.4", "1,2"] {
            assert!(current(ambiguous).unwrap_err().contains("like 0.4@250"), "{ambiguous}");
        }
        for wrong in ["250@0.4", "0.4", "nan@1", "0.4@inf", "0.4@400"] {
            assert!(current(wrong).unwrap_err().contains("0 to 10 m/s"), "{wrong}");
        }
    }
}
