//! Cost and problems of a plan, checked as vessels check it.

use super::translate::{degrees_of, place, specification};
use super::trouble::{of_problem, of_warning, said, too_long, too_many_row_points};
use api::{Guard, PlanCheck, PlanCost, PlanDocument, PlanLeg, PlanPlace, PlanTask, PlanTrouble, Said, say};
use imc::Address;
use imc::messages::PlanSpecification;
use mission::{Cost, Maneuver, Plan, PlanStatistics, PlanWarning, VehicleModel};
use onboard::{LONGEST_PLAN, LONGEST_PLAN_NAME, Settings};
use std::collections::BTreeMap;
use units::{LatLon, MonoTime, Now, UtcTime};

/// Most maneuvers of a plan, and most points of all its paths.
const MANEUVERS: usize = 500;
const POINTS: usize = 5_000;
/// Most characters of a description.
const DESCRIPTION: usize = 500;
/// Most points of all its rows together, and most places that are returned for drawing; maneuvers beyond that have none.
const PLACES: usize = 50_000;

/// Checks that a plan can be stored, at least as a draft.
///
/// # Errors
/// A limit is exceeded, or the plan has no name.
pub fn limits(plan: &PlanDocument) -> Result<(), Said> {
    let good = |name: &str| {
        (1..=LONGEST_PLAN_NAME).contains(&name.len())
            && name.trim() == name
            && !name.chars().any(char::is_control)
    };
    let rule = say("1 to {most} bytes, without blanks around it").with("most", LONGEST_PLAN_NAME);
    if !good(&plan.name) {
        return Err(say("A plan's name has {rule}.").with_said("rule", rule).into());
    }
    if plan.description.chars().count() > DESCRIPTION {
        return Err(say("A plan's description has up to {most} letters.").with("most", DESCRIPTION).into());
    }
    if matches!(plan.vessel, Some(0 | 0xFFFF)) {
        return Err(say("0 and 0xFFFF cannot be a vessel's address.").into());
    }
    let count = plan.maneuvers.len();
    if count > MANEUVERS {
        let text = say("The plan has {count} maneuvers; {most} are the most. Divide it.");
        return Err(text.with("count", count).with("most", MANEUVERS).into());
    }
    if let Some(step) = plan.maneuvers.iter().find(|step| !good(&step.id)) {
        let name: String = step.id.chars().take(30).collect();
        let text = say("`{name}` cannot be a maneuver's name: it has {rule}.");
        return Err(text.with("name", name).with_said("rule", rule).into());
    }
    let points: usize = plan.maneuvers.iter().map(|step| places(&step.task).len()).sum();
    if points > POINTS {
        let text = say("The plan has {count} points; {most} are the most. Divide it.");
        return Err(text.with("count", points).with("most", POINTS).into());
    }
    Ok(())
}

/// Checks a plan that is within its [`limits`].
pub fn check(plan: &PlanDocument, now: UtcTime) -> PlanCheck {
    check_with(plan, now, |_| None)
}

/// The plan as its vessel interprets it.
///
/// # Errors
/// It has problems, so that it cannot be laid out on the chart; the error is the first of them.
pub fn understood(specification: &PlanSpecification) -> Result<Plan, Said> {
    let settings = Settings::otter("shore", Address(0));
    onboard::checked_plan(specification, &settings).map_err(|problems| {
        let first = problems.0.first().map(|one| of_problem(one, &settings.mission.limits.speed));
        first.map(|trouble| said(&trouble)).unwrap_or_default()
    })
}

/// Checks a plan that is within its [`limits`], also against the chart.
pub fn check_with(
    plan: &PlanDocument,
    now: UtcTime,
    guard: impl FnOnce(&Plan) -> Option<Guard>,
) -> PlanCheck {
    let laid_out: f64 = plan.maneuvers.iter().map(|step| row_points(&step.task)).sum();
    // NaN for a width of 0/0, which the vessel's own checks report.
    if laid_out > PLACES as f64 {
        return PlanCheck { problems: vec![too_many_row_points(PLACES)], ..PlanCheck::default() };
    }
    let specification = match specification(plan) {
        Ok(specification) => specification,
        Err(problems) => return PlanCheck { problems, ..PlanCheck::default() },
    };
    let digest = match digest(&specification) {
        Ok(digest) => digest,
        Err(text) => return PlanCheck { problems: vec![too_long(text)], ..PlanCheck::default() },
    };
    let settings = Settings::otter("shore", Address(0));
    match onboard::checked_plan(&specification, &settings) {
        Ok(checked) => {
            let wanted = |warning: &&PlanWarning| !(plan.repeat && matches!(warning, PlanWarning::Cycle));
            PlanCheck {
                warnings: checked.warnings().iter().filter(wanted).map(of_warning).collect(),
                digest: Some(digest),
                guard: guard(&checked),
                ..costs(plan, &checked, now)
            }
        }
        Err(problems) => {
            let problems =
                problems.0.iter().map(|one| of_problem(one, &settings.mission.limits.speed)).collect();
            PlanCheck { problems, ..PlanCheck::default() }
        }
    }
}

/// The plan to be sent to a vessel; it must have no problems.
///
/// # Errors
/// It has problems; the error is the first of them.
pub fn aboard(plan: &PlanDocument, now: UtcTime) -> Result<PlanSpecification, Said> {
    let first = |problems: &[PlanTrouble]| problems.first().map(said).unwrap_or_default();
    match check(plan, now).problems.as_slice() {
        [] => specification(plan).map_err(|problems| first(&problems)),
        problems => Err(first(problems)),
    }
}

/// Problems and warnings of an imported plan, as text.
pub(crate) fn told(plan: &PlanSpecification) -> Vec<Said> {
    let settings = Settings::otter("shore", Address(0));
    match onboard::checked_plan(plan, &settings) {
        Ok(checked) => {
            let odd = checked.warnings().iter().filter(|warning| **warning != PlanWarning::Cycle);
            odd.map(|warning| said(&of_warning(warning))).collect()
        }
        Err(problems) => {
            let speed = &settings.mission.limits.speed;
            problems.0.iter().map(|problem| said(&of_problem(problem, speed))).collect()
        }
    }
}

/// MD5 digest as the vessel computes it.
fn digest(plan: &PlanSpecification) -> Result<String, String> {
    let long = |what: String| format!("the plan is too long for one message ({what}); divide it");
    let mut bytes = Vec::new();
    imc::encode_into(&mut bytes, &imc::Header::default(), plan).map_err(|error| long(error.to_string()))?;
    if bytes.len() > LONGEST_PLAN {
        return Err(long(format!("{} bytes, {LONGEST_PLAN} fit", bytes.len())));
    }
    let digest = imc::plan_digest::plan_md5(plan).map_err(|error| long(error.to_string()))?;
    Ok(hex::encode(digest))
}

/// The cost of a plan from its first waypoint on; if it repeats, from the end of a round.
fn costs(document: &PlanDocument, plan: &Plan, now: UtcTime) -> PlanCheck {
    let first = document.maneuvers.first().and_then(|step| places(&step.task).first());
    let end = plan.nodes().last().and_then(|node| match node.maneuver() {
        Maneuver::Loiter(loiter) => Some(loiter.centre),
        other => other.places().last().copied(),
    });
    let from: Option<LatLon> = if document.repeat { end } else { first.and_then(place) };
    let now = Now { mono: MonoTime::from_micros(0), utc: now };
    let statistics = PlanStatistics::of(plan, from, now, &VehicleModel::default());
    let costs: BTreeMap<&str, Cost> =
        statistics.maneuvers.iter().map(|(id, cost)| (id.as_str(), *cost)).collect();
    let mut room = PLACES;
    let leg = |node: &mission::Node| {
        let places = node.maneuver().places();
        let shown = if places.len() <= room { places } else { Vec::new() };
        room -= shown.len();
        PlanLeg {
            id: node.id().to_owned(),
            cost: cost(costs.get(node.id()).copied().unwrap_or_default()),
            places: shown.into_iter().map(degrees_of).collect(),
        }
    };
    let maneuvers: Vec<PlanLeg> = plan.nodes().iter().map(leg).collect();
    // A repeating plan has no total: the cost is that of one round.
    let sum = |value: fn(&PlanCost) -> Option<f64>| maneuvers.iter().map(|leg| value(&leg.cost)).sum();
    let total = PlanCost {
        length_m: sum(|cost| cost.length_m),
        duration_s: sum(|cost| cost.duration_s),
        energy_j: sum(|cost| cost.energy_j),
    };
    PlanCheck { total, maneuvers, ..PlanCheck::default() }
}

fn cost(cost: Cost) -> PlanCost {
    let Cost { length_m, duration_s, energy_j } = cost;
    PlanCost { length_m, duration_s, energy_j }
}

/// Approximate number of points of rows: three for each row, as of a square curve.
fn row_points(task: &PlanTask) -> f64 {
    match task {
        PlanTask::Rows { width_m, step_m, .. } => 3.0 * (width_m / step_m + 2.0),
        _ => 0.0,
    }
}

/// The drawn places of a task.
pub(crate) fn places(task: &PlanTask) -> &[PlanPlace] {
    match task {
        PlanTask::FollowPath { points } => points,
        PlanTask::Goto { at }
        | PlanTask::StationKeeping { at, .. }
        | PlanTask::Loiter { at, .. }
        | PlanTask::Rows { at, .. } => std::slice::from_ref(at),
    }
}
