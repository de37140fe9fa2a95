//! What a requested route is good for: reads objective, preferences, currents and speed limits.

use super::{MOST_CLEARANCE_M, wrong};
use api::{
    Said, SeaRouteCurrent, SeaRouteCurrentGrid, SeaRouteObjective, SeaRouteRequest, SeaRouteZone,
    SeaRouteZoneKind, say,
};
use mission::VehicleModel;
use planner::{Aim, CurrentGrid, Currents, Flow, Objective, Power, Preferences, SpeedLimit};
use units::UtcTime;

/// Speed where none is asked for (m/s).
const SPEED_MPS: f64 = 1.5;
/// Most crossings of a grid of currents in a request.
pub(super) const MOST_CROSSINGS: usize = 100_000;

/// The power of the vessel that plans are reckoned with.
pub fn power() -> Power {
    let model = VehicleModel::default();
    Power::new(move |mps| (mps <= model.fastest_mps()).then(|| model.power_w(mps)))
}

/// What is to be least, at a speed through the water (m/s) in still water; for the least energy, no faster than the power is
/// known for.
pub fn aimed(asked: SeaRouteObjective, speed_mps: f64) -> Objective {
    let (aim, speed_mps) = match asked {
        SeaRouteObjective::Shortest => (Aim::Length, speed_mps),
        SeaRouteObjective::Fastest => (Aim::Time, speed_mps),
        SeaRouteObjective::LeastEnergy => (Aim::Energy, speed_mps.min(VehicleModel::default().fastest_mps())),
    };
    Objective { aim, ..Objective::shortest(speed_mps, power()) }
}

/// The objective of a request that is planned now.
pub(super) fn objective(ask: &SeaRouteRequest, now: UtcTime) -> Result<Objective, Said> {
    let speed_mps = ask.speed_mps.unwrap_or(SPEED_MPS);
    if !(0.05..=20.0).contains(&speed_mps) {
        let text = say("speed_mps: {speed_mps} is not within 0.05 to 20 m/s").with("speed_mps", speed_mps);
        return Err(text.into());
    }
    let currents = match (&ask.current, &ask.current_grid) {
        (Some(_), Some(_)) => {
            return Err(say("current_grid: give a steady current or a grid, not both").into());
        }
        (steady, None) => Currents::Steady(steady.as_ref().map_or(Ok(Flow::default()), flow)?),
        (None, Some(of)) => Currents::Grid(grid(of).map_err(|text| text.of_field("current_grid"))?),
    };
    if ask.prefer_off_m.is_some_and(|off_m| off_m > MOST_CLEARANCE_M) {
        let text = say("prefer_off_m: {asked} is more than {most} m")
            .with("asked", ask.prefer_off_m.unwrap_or_default())
            .with("most", MOST_CLEARANCE_M);
        return Err(text.into());
    }
    let usual = Preferences::default();
    let preferences = Preferences {
        depth_m: ask.prefer_depth_m,
        off_m: ask.prefer_off_m,
        factor: ask.prefer_factor.unwrap_or(usual.factor),
    };
    let traffic_factor = ask.traffic_factor.unwrap_or(aimed(ask.objective, speed_mps).traffic_factor);
    let depart = ask.depart_us.map_or(now, UtcTime::from_micros);
    let limits = limits(&ask.zones)?;
    let aimed = aimed(ask.objective, speed_mps);
    let depart_s = depart.seconds();
    let objective = Objective { currents, preferences, limits, depart_s, traffic_factor, ..aimed };
    objective.validate().map_err(wrong::needs)?;
    Ok(objective)
}

fn flow(SeaRouteCurrent { set_deg, drift_mps }: &SeaRouteCurrent) -> Result<Flow, Said> {
    if !set_deg.is_finite() || !(0.0..=10.0).contains(drift_mps) {
        let text = say(
            "current: {set_deg}°, {drift_mps} m/s; give a direction in degrees and a speed of 0 to 10 m/s",
        );
        return Err(text.with("set_deg", set_deg).with("drift_mps", drift_mps).into());
    }
    Ok(Flow::set_and_drift(set_deg.to_radians(), *drift_mps))
}

pub(super) fn grid(of: &SeaRouteCurrentGrid) -> Result<CurrentGrid, Said> {
    if of.east_mps.len().max(of.north_mps.len()) > MOST_CROSSINGS {
        let text = say("there are more than {most} values; cut it to the area and the time of the route");
        return Err(text.with("most", MOST_CROSSINGS).into());
    }
    let times_s = of.times_us.iter().map(|time_us| UtcTime::from_micros(*time_us).seconds()).collect();
    let values =
        |values: &[Option<f32>]| values.iter().map(|mps| mps.unwrap_or(f32::NAN)).collect::<Vec<_>>();
    let (east_mps, north_mps) = (values(&of.east_mps), values(&of.north_mps));
    CurrentGrid::new(times_s, of.lats_deg.clone(), of.lons_deg.clone(), &east_mps, &north_mps)
        .map_err(|why| wrong::grid(&why))
}

/// The areas with speed limits; the others are read as zones.
fn limits(zones: &[SeaRouteZone]) -> Result<Vec<SpeedLimit>, Said> {
    let mut limits = Vec::new();
    for (number, asked) in zones.iter().enumerate() {
        let refused = |text: Said| text.of_field(&format!("zones[{number}]"));
        match (asked.kind, asked.most_mps) {
            (SeaRouteZoneKind::Limit, Some(most_mps)) => {
                let zone = super::zone(&asked.corners).map_err(refused)?;
                limits.push(SpeedLimit { zone, most_mps });
            }
            (SeaRouteZoneKind::Limit, None) => {
                return Err(refused(say("most_mps is missing: give the speed limit in m/s").into()));
            }
            (SeaRouteZoneKind::Avoid | SeaRouteZoneKind::Within, Some(_)) => {
                return Err(refused(say("most_mps belongs to areas of the kind limit; leave it out").into()));
            }
            (SeaRouteZoneKind::Avoid | SeaRouteZoneKind::Within, None) => {}
        }
    }
    Ok(limits)
}
