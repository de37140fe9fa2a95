//! Converts plan documents to IMC's PlanSpecification and back.
//!
//! Degrees are rounded to 1e-10 (0.01 mm) and offsets of paths to 1/128 m, which single precision represents exactly up to
//! 131 km: so a plan has the same bytes, and the same digest, after a conversion there and back.

use super::trouble::trouble;
use api::{PlanDocument, PlanPlace, PlanSpeed, PlanStep, PlanTask, PlanTrouble, Said, SpeedUnit, say};
use imc::messages::{
    FollowPath, Goto, Loiter, LoiterDirection, LoiterType, Message, PathPoint, PlanManeuver,
    PlanSpecification, PlanTransition, Rows, RowsFlags, SpeedUnits, StationKeeping, ZUnits,
};
use mission::PLAN_END;
use std::collections::BTreeSet;
use units::{LatLon, LocalFrame, LocalPoint};

/// Resolution of angles, parts of a degree.
const PER_DEGREE: f64 = 1e10;
/// Resolution of offsets of paths, parts of a metre.
const PER_METRE: f64 = 128.0;
/// Condition of every transition.
const WHEN_DONE: &str = "ManeuverIsDone";

/// The plan for a vessel.
///
/// # Errors
/// Points of paths that are not valid positions: only these cannot be represented.
pub fn specification(plan: &PlanDocument) -> Result<PlanSpecification, Vec<PlanTrouble>> {
    let mut troubles = Vec::new();
    let mut maneuvers = Vec::with_capacity(plan.maneuvers.len());
    for step in &plan.maneuvers {
        match message(step) {
            Ok(data) => maneuvers.push(PlanManeuver {
                maneuver_id: step.id.as_str().into(),
                data: data.into(),
                ..PlanManeuver::default()
            }),
            Err(text) => troubles.push(trouble(Some(&step.id), text)),
        }
    }
    if !troubles.is_empty() {
        return Err(troubles);
    }
    let pairs = plan.maneuvers.windows(2).map(|pair| (&pair[0], &pair[1]));
    let back = plan.maneuvers.last().zip(plan.maneuvers.first()).filter(|_| plan.repeat);
    let transition = |(from, to): (&PlanStep, &PlanStep)| PlanTransition {
        source_man: from.id.as_str().into(),
        dest_man: to.id.as_str().into(),
        conditions: WHEN_DONE.into(),
        ..PlanTransition::default()
    };
    Ok(PlanSpecification {
        plan_id: plan.name.as_str().into(),
        description: plan.description.as_str().into(),
        start_man_id: plan.maneuvers.first().map_or("", |first| first.id.as_str()).into(),
        transitions: pairs.chain(back).map(transition).collect(),
        maneuvers: maneuvers.into_iter().collect(),
        ..PlanSpecification::default()
    })
}

fn message(step: &PlanStep) -> Result<Message, String> {
    let speed_units = match step.speed.unit {
        SpeedUnit::Mps => SpeedUnits::MetersPs,
        SpeedUnit::Rpm => SpeedUnits::Rpm,
        SpeedUnit::Percent => SpeedUnits::Percentage,
    };
    let (speed, z_units) = (step.speed.value as f32, ZUnits::Depth);
    Ok(match &step.task {
        PlanTask::Goto { at } => {
            let (lat, lon) = radians(at);
            Goto { lat, lon, z_units, speed, speed_units, ..Goto::default() }.into()
        }
        PlanTask::FollowPath { points } => {
            let first = points.first().ok_or("a path needs at least one point")?;
            let (lat, lon) = radians(first);
            let frame = LocalFrame::new(place(first).ok_or("point 1 is not a place on earth")?);
            let mut offsets = Vec::with_capacity(points.len());
            for (point, number) in points.iter().zip(1..) {
                let place = place(point).ok_or_else(|| format!("point {number} is not a place on earth"))?;
                let local = frame.to_local(place);
                offsets.push(PathPoint { x: offset(local.north_m), y: offset(local.east_m), z: 0.0 });
            }
            let points = offsets.into_iter().collect();
            FollowPath { lat, lon, z_units, speed, speed_units, points, ..FollowPath::default() }.into()
        }
        &PlanTask::StationKeeping { ref at, radius_m, duration_s } => {
            let (lat, lon) = radians(at);
            let (radius, duration) = (radius_m as f32, duration_s);
            let base = StationKeeping::default();
            StationKeeping { lat, lon, z_units, radius, duration, speed, speed_units, ..base }.into()
        }
        &PlanTask::Loiter { ref at, radius_m, duration_s, clockwise } => {
            let (lat, lon) = radians(at);
            let direction = if clockwise { LoiterDirection::Clockw } else { LoiterDirection::Cclockw };
            Loiter {
                lat,
                lon,
                z_units,
                speed,
                speed_units,
                direction,
                duration: duration_s,
                radius: radius_m as f32,
                r#type: LoiterType::Circular,
                ..Loiter::default()
            }
            .into()
        }
        PlanTask::Rows { .. } => rows(step, speed, speed_units),
    })
}

fn rows(step: &PlanStep, speed: f32, speed_units: SpeedUnits) -> Message {
    let &PlanTask::Rows {
        ref at,
        bearing_deg,
        cross_angle_deg,
        width_m,
        length_m,
        step_m,
        curve_offset_m,
        alternation_percent,
        square_curve,
        curve_right,
    } = &step.task
    else {
        return Rows::default().into();
    };
    let (lat, lon) = radians(at);
    let flag = |on: bool, flag: RowsFlags| if on { flag } else { RowsFlags::empty() };
    Rows {
        lat,
        lon,
        z_units: ZUnits::Depth,
        speed,
        speed_units,
        bearing: fine(bearing_deg).to_radians(),
        cross_angle: fine(cross_angle_deg).to_radians(),
        width: width_m as f32,
        length: length_m as f32,
        hstep: step_m as f32,
        coff: curve_offset_m,
        alternation: alternation_percent,
        flags: flag(square_curve, RowsFlags::SQUARE_CURVE) | flag(curve_right, RowsFlags::CURVE_RIGHT),
        ..Rows::default()
    }
    .into()
}

/// An imported plan in the form that people edit.
///
/// # Errors
/// It has parts that cannot be represented, and that would change the plan if left out.
pub fn document(plan: &PlanSpecification) -> Result<(PlanDocument, Vec<Said>), Vec<Said>> {
    let mut troubles = Vec::new();
    if !plan.start_actions.is_empty() || !plan.end_actions.is_empty() {
        troubles.push(actions());
    }
    let nodes: Vec<PlanManeuver> = plan.maneuvers.of().collect();
    let transitions: Vec<PlanTransition> = plan.transitions.of().collect();
    if transitions.iter().any(|transition| !transition.actions.is_empty()) {
        troubles.push(say("transitions have actions, which are not edited here: take them out").into());
    }
    let (order, repeat) = order(plan, &nodes, &transitions).map_err(|text| vec![text])?;
    let mut notes = Vec::new();
    for (_, node) in nodes.iter().enumerate().filter(|(index, _)| !order.contains(index)) {
        notes.push(
            Said::from(say("never reached in the plan, left out")).of_field(&node.maneuver_id.to_str_lossy()),
        );
    }
    let mut maneuvers = Vec::with_capacity(order.len());
    for node in order.iter().filter_map(|index| nodes.get(*index)) {
        let id = node.maneuver_id.to_str_lossy().into_owned();
        if !node.start_actions.is_empty() || !node.end_actions.is_empty() {
            troubles.push(actions().of_field(&id));
        }
        match step(&id, node.data.get()) {
            Ok(step) => maneuvers.push(step),
            Err(text) => troubles.push(text.of_field(&id)),
        }
    }
    if !troubles.is_empty() {
        return Err(troubles);
    }
    let document = PlanDocument {
        name: plan.plan_id.to_str_lossy().into_owned(),
        description: plan.description.to_str_lossy().into_owned(),
        vessel: None,
        repeat,
        maneuvers,
    };
    Ok((document, notes))
}

fn actions() -> Said {
    say("it has actions, which are not edited here: take them out of the file").into()
}

/// The maneuvers in order of execution, and whether they repeat. The first transition of each is taken.
fn order(
    plan: &PlanSpecification,
    nodes: &[PlanManeuver],
    transitions: &[PlanTransition],
) -> Result<(Vec<usize>, bool), Said> {
    let find = |id: &imc::Text| nodes.iter().position(|node| node.maneuver_id == *id);
    let mut at = find(&plan.start_man_id).ok_or_else(|| {
        say("the first maneuver, '{name}', does not exist").with("name", &plan.start_man_id)
    })?;
    let (mut order, mut seen) = (vec![at], BTreeSet::from([at]));
    loop {
        let from = &nodes[at].maneuver_id;
        let next = transitions.iter().find(|transition| transition.source_man == *from);
        let Some(to) = next.map(|next| &next.dest_man).filter(|to| **to != *PLAN_END) else {
            return Ok((order, false));
        };
        at = find(to)
            .ok_or_else(|| say("a transition leads to '{name}', which does not exist").with("name", to))?;
        if order.first() == Some(&at) {
            return Ok((order, true));
        }
        if !seen.insert(at) {
            return Err(say("it goes back to '{name}'; only whole plans repeat here")
                .with("name", to)
                .into());
        }
        order.push(at);
    }
}

fn step(id: &str, data: Option<Message>) -> Result<PlanStep, Said> {
    let (speed, task) = match data {
        None => return Err(say("it holds no maneuver").into()),
        Some(Message::Goto(m)) => {
            (speed(m.speed, m.speed_units)?, PlanTask::Goto { at: degrees(m.lat, m.lon)? })
        }
        Some(Message::FollowPath(m)) => {
            let start = LatLon::from_rad(m.lat, m.lon).map_err(|error| Said::as_is(error.to_string()))?;
            let frame = LocalFrame::new(start);
            let point = |point: PathPoint| {
                let local = LocalPoint { north_m: point.x.into(), east_m: point.y.into() };
                let place = frame.to_place(local);
                degrees(place.lat_rad(), place.lon_rad())
            };
            let points = m.points.of::<PathPoint>().map(point).collect::<Result<_, _>>()?;
            (speed(m.speed, m.speed_units)?, PlanTask::FollowPath { points })
        }
        Some(Message::StationKeeping(m)) => {
            let (at, radius_m) = (degrees(m.lat, m.lon)?, decimal(m.radius)?);
            let task = PlanTask::StationKeeping { at, radius_m, duration_s: m.duration };
            (speed(m.speed, m.speed_units)?, task)
        }
        Some(Message::Loiter(m)) => {
            if !matches!(m.r#type, LoiterType::Default | LoiterType::Circular) {
                return Err(say("a loiter other than a circle is not edited here").into());
            }
            let task = PlanTask::Loiter {
                at: degrees(m.lat, m.lon)?,
                radius_m: decimal(m.radius)?,
                duration_s: m.duration,
                clockwise: m.direction != LoiterDirection::Cclockw,
            };
            (speed(m.speed, m.speed_units)?, task)
        }
        Some(Message::Rows(m)) => {
            let task = PlanTask::Rows {
                at: degrees(m.lat, m.lon)?,
                bearing_deg: angle(m.bearing)?,
                cross_angle_deg: angle(m.cross_angle)?,
                width_m: decimal(m.width)?,
                length_m: decimal(m.length)?,
                step_m: decimal(m.hstep)?,
                curve_offset_m: m.coff,
                alternation_percent: m.alternation,
                square_curve: m.flags.contains(RowsFlags::SQUARE_CURVE),
                curve_right: m.flags.contains(RowsFlags::CURVE_RIGHT),
            };
            (speed(m.speed, m.speed_units)?, task)
        }
        Some(other) => {
            let text =
                say("a {kind} is not edited here; Goto, FollowPath, StationKeeping, Loiter and Rows are");
            return Err(text.with("kind", other.abbrev()).into());
        }
    };
    Ok(PlanStep { id: id.to_owned(), speed, task })
}

fn speed(value: f32, units: SpeedUnits) -> Result<PlanSpeed, Said> {
    let unit = match units {
        SpeedUnits::MetersPs => SpeedUnit::Mps,
        SpeedUnits::Rpm => SpeedUnit::Rpm,
        SpeedUnits::Percentage => SpeedUnit::Percent,
        SpeedUnits::Unlisted(number) => {
            return Err(say("its speed has the unknown unit {number}").with("number", number).into());
        }
    };
    Ok(PlanSpeed { value: decimal(value)?, unit })
}

/// The position, if it is valid.
pub(crate) fn place(place: &PlanPlace) -> Option<LatLon> {
    LatLon::from_deg(fine(place.lat_deg), fine(place.lon_deg)).ok()
}

/// A position in degrees, for drawing.
pub(crate) fn degrees_of(place: LatLon) -> PlanPlace {
    PlanPlace { lat_deg: fine(place.lat_deg()), lon_deg: fine(place.lon_deg()) }
}

fn radians(place: &PlanPlace) -> (f64, f64) {
    (fine(place.lat_deg).to_radians(), fine(place.lon_deg).to_radians())
}

fn degrees(lat_rad: f64, lon_rad: f64) -> Result<PlanPlace, Said> {
    let place = LatLon::from_rad(lat_rad, lon_rad).map_err(|error| Said::as_is(error.to_string()))?;
    Ok(PlanPlace { lat_deg: fine(place.lat_deg()), lon_deg: fine(place.lon_deg()) })
}

fn angle(rad: f64) -> Result<f64, Said> {
    let deg = fine(rad.to_degrees());
    if deg.is_finite() { Ok(deg) } else { Err(say("an angle is not a number").into()) }
}

/// Rounds degrees to their resolution.
fn fine(deg: f64) -> f64 {
    (deg * PER_DEGREE).round() / PER_DEGREE
}

/// Rounds metres to their resolution.
fn offset(metres: f64) -> f32 {
    ((metres * PER_METRE).round() / PER_METRE) as f32
}

/// The shortest decimal that is this number, so that 0.1 stays 0.1.
fn decimal(value: f32) -> Result<f64, Said> {
    let read = value.to_string().parse().ok().filter(|value: &f64| value.is_finite());
    read.ok_or_else(|| say("{value} is not a number").with("value", value).into())
}
