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
    /// A steady current that time and energy are reckoned in: where it flows to (degrees), and how fast (m/s).
    #[arg(long, value_name = "DEG,MPS", value_parser = current)]
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
    let numbers = text.split_once(',').map(|(set, drift)| (set.trim().parse(), drift.trim().parse()));
    match numbers {
        Some((Ok(set_deg), Ok(drift_mps)))
            if f64::is_finite(set_deg) && (0.0..=10.0).contains(&drift_mps) =>
        {
            Ok(Flow::set_and_drift(set_deg.to_radians(), drift_mps))
        }
        _ => Err("give where it flows to in degrees and how fast, 0 to 10 m/s, such as 250,0.4".to_owned()),
    }
}
