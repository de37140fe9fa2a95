//! Plans checked against the sea chart aboard.

use crate::bus::Bus;
use crate::entity::Entity;
use crate::grounding::Chart;
use crate::output::Level;
use crate::settings::Settings;
use guard::WaterChart;
use guard::{GuardLimits, Verdict, Warning};
use mission::check_plan;
use mission::{ManeuverKind, Plan};
use units::LatLon;

/// Warnings of a verdict that are reported one by one; of more their number.
const MOST_TOLD: usize = 5;

/// The waters against which maneuvers check goals that other systems set under way.
pub(super) fn of_waters(settings: &Settings) -> WaterChart {
    match &settings.grounding.chart {
        Chart::Loaded(file) => WaterChart::Loaded(file.shared_index(), Box::new(settings.guard_limits())),
        Chart::Unreadable { .. } if settings.grounding.refuses_without => WaterChart::Unreadable,
        Chart::Off | Chart::Unreadable { .. } => WaterChart::Off,
    }
}

/// Checks whether the chart has water for a plan by these limits, without any report.
///
/// # Errors
/// Why not.
pub(super) fn refusal(
    settings: &Settings,
    plan: &Plan,
    from: Option<LatLon>,
    limits: &GuardLimits,
) -> Result<(), String> {
    if matches!(of_waters(settings), WaterChart::Unreadable) {
        return Err("the chart that is configured cannot be read".to_owned());
    }
    let refused = verdict(settings, plan, from, limits).filter(Verdict::is_refused);
    refused.map_or(Ok(()), |verdict| Err(verdict.summary()))
}

/// The guard's answer about a plan by these limits, if there is a chart.
pub(super) fn verdict(
    settings: &Settings,
    plan: &Plan,
    from: Option<LatLon>,
    limits: &GuardLimits,
) -> Option<Verdict> {
    Some(check_plan(plan, from, settings.grounding.chart.index()?, limits))
}

/// Whether a plan that starts at `from`, if that is known, keeps to deep water; doubts go to the log book.
///
/// # Errors
/// Why not, with the place.
pub(super) fn check(
    settings: &Settings,
    bus: &mut Bus,
    plan: &Plan,
    from: Option<LatLon>,
) -> Result<(), String> {
    let grounding = &settings.grounding;
    let index = match &grounding.chart {
        Chart::Off => return Ok(()),
        Chart::Loaded(_) => grounding.chart.index(),
        Chart::Unreadable { .. } => None,
    };
    let Some(index) = index else {
        // An operator who steers sees where the vessel goes.
        let steered = plan.nodes().iter().all(|node| node.maneuver().kind() == ManeuverKind::Teleoperation);
        let text = "the chart that is configured cannot be read";
        if grounding.refuses_without && !steered {
            return Err(format!("{text}; send a whole one to the vessel, or steer by hand"));
        }
        let text = format!("'{}' is not held against the sea chart: {text}", plan.id());
        bus.entry(Entity::Grounding, Level::Warning, text);
        return Ok(());
    };
    let verdict = check_plan(plan, from, index, &settings.guard_limits());
    if verdict.is_refused() {
        return Err(verdict.summary());
    }
    // Where a plan that is only stored will start is unknown; the way to it is checked at the start.
    let told = |warning: &&Warning| from.is_some() || !matches!(warning, Warning::StartUnknown { .. });
    let warnings: Vec<&Warning> = verdict.warnings.iter().filter(told).collect();
    for warning in warnings.iter().take(MOST_TOLD) {
        bus.entry(Entity::Grounding, Level::Warning, warning.to_string());
    }
    if let Some(more) = warnings.len().checked_sub(MOST_TOLD).filter(|more| *more > 0) {
        bus.entry(Entity::Grounding, Level::Warning, format!("'{}': {more} more warnings", plan.id()));
    }
    Ok(())
}
