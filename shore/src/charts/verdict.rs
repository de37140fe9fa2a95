//! The guard's verdict, as the API reports it.

use api::{Guard, GuardReason, GuardWarning, PlanPlace};
use guard::{GuardLimits, LegCheck, Outcome, Reason, ReportedLeg, Verdict, Warning};
use units::LatLon;

/// Most reasons and warnings that are reported.
const MOST: usize = 100;

/// The limits by which a plan is judged.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// The demands on depth, air draught and areas.
    pub demanded: GuardLimits,
    /// Whether the vessel reported it.
    pub of_vessel: bool,
}

/// Converts a verdict for the API.
pub fn told(verdict: &Verdict, limits: &Limits) -> Guard {
    Guard {
        autonomous_m: limits.demanded.autonomous_m,
        of_vessel: limits.of_vessel,
        outcome: verdict.outcome().code().to_owned(),
        cause: verdict.too_much.then(|| "too-large".to_owned()),
        text: verdict.summary(),
        reasons: verdict.refused().filter_map(reason).take(MOST).collect(),
        warnings: verdict.warnings.iter().take(MOST).map(warning).collect(),
    }
}

/// The verdict while the chart cannot be read: no place is known to be deep enough.
pub(crate) fn without(trouble: &str, limits: &Limits) -> Guard {
    let text = format!("the chart cannot be read, so nothing is known to be deep enough: {trouble}");
    refused("chart-unreadable", text, limits)
}

/// The verdict while the chart lacks no-go areas: a plan may lead into one.
pub(crate) fn not_closed(trouble: &str, limits: &Limits) -> Guard {
    let text = format!("the no-go areas are not in the chart, so a plan may lead into one: {trouble}");
    refused("no-go-areas", text, limits)
}

fn refused(cause: &str, text: String, limits: &Limits) -> Guard {
    Guard {
        autonomous_m: limits.demanded.autonomous_m,
        of_vessel: limits.of_vessel,
        outcome: Outcome::Refused.code().to_owned(),
        cause: Some(cause.to_owned()),
        text,
        reasons: Vec::new(),
        warnings: Vec::new(),
    }
}

/// Why a leg is refused, if it is.
pub(crate) fn reason(leg: &LegCheck) -> Option<GuardReason> {
    let (spot, why) = (&leg.spot, leg.reason?);
    let entered = leg.area.as_ref().filter(|_| matches!(why, Reason::Entry(_)));
    Some(GuardReason {
        maneuver: leg.label.clone(),
        part: leg.part.code().to_owned(),
        from: Some(place(leg.from)),
        to: Some(place(leg.to)),
        number: leg.number,
        code: why.code().to_owned(),
        text: leg.to_string(),
        lat_deg: spot.at.lat_deg(),
        lon_deg: spot.at.lon_deg(),
        depth_m: spot.least_m,
        object: spot.class.map(str::to_owned),
        area: entered.and_then(|entered| entered.spot.name.clone()),
        cell: spot.cell.clone(),
        scale: spot.scale,
        margin_m: spot.margin_m,
    })
}

/// Parses the leg from a vessel's refusal text.
pub(crate) fn of_words(text: &str) -> Option<GuardReason> {
    let leg = ReportedLeg::find(text)?;
    Some(GuardReason {
        maneuver: leg.label,
        part: leg.part.code().to_owned(),
        from: None,
        to: None,
        number: leg.number,
        code: leg.reason.code().to_owned(),
        text: text.to_owned(),
        lat_deg: leg.at.lat_deg(),
        lon_deg: leg.at.lon_deg(),
        depth_m: leg.least_m,
        object: leg.class,
        area: leg.area,
        cell: leg.cell,
        scale: None,
        margin_m: leg.least_m.zip(leg.needed_m).map(|(least_m, needed_m)| least_m - needed_m),
    })
}

fn place(at: LatLon) -> PlanPlace {
    PlanPlace { lat_deg: at.lat_deg(), lon_deg: at.lon_deg() }
}

fn warning(warning: &Warning) -> GuardWarning {
    let about = match warning {
        Warning::StartUnknown { .. } | Warning::DriftsOn { .. } => None,
        Warning::Unchecked { kind, .. } => Some(kind.clone()),
        Warning::PoorChart { cell, .. } => cell.clone(),
        Warning::Entry { area, .. } => Some(area.clone()),
    };
    GuardWarning {
        maneuver: Some(warning.label().to_owned()),
        code: warning.code().to_owned(),
        about,
        text: warning.to_string(),
    }
}
