//! From IMC's plans, maneuvers and references to the mission's, and back to numbers IMC knows.
//!
//! Nothing is checked here: all of a plan is translated, and [`mission::Plan::build`] finds all that
//! is wrong with it. Surface vessels have no use for depths but to refuse them.

use imc::messages::{
    DesiredSpeed, FollowReference, FollowSystem, Loiter, LoiterDirection, LoiterType, Message, PathPoint,
    PlanManeuver, PlanSpecification, PlanTransition, Reference, ReferenceFlags, Rows, RowsCoverage,
    RowsCoverageFlags, RowsFlags, ScheduledGotoDelayed, SpeedUnits, Teleoperation, TrajectoryPoint, ZUnits,
};
use imc::tuples;
use mission::{
    DraftBody, Late, LoiterShape, Maneuver, ManeuverDraft, ManeuverKind, Offset, Operator, PlanDraft,
    RawPlace, Swath, TimedOffset, TransitionDraft,
};
use std::time::Duration;
use units::{LatLon, Speed, Turn, UtcTime};

/// No maneuver, in `VehicleState` and `PlanControlState`.
pub(crate) const NO_MANEUVER: u16 = 0xFFFF;
const ANY_SYSTEM: u16 = 0xFFFF;
const ANY_ENTITY: u8 = 0xFF;
/// Silence of a commander that ends the maneuver where the plan names none.
const REFERENCE_SILENCE: Duration = Duration::from_secs(30);
/// Longest time a single-precision number of seconds may mean here.
const LONGEST_S: f32 = 1e6;

/// A whole plan.
pub(crate) fn draft(plan: &PlanSpecification) -> PlanDraft {
    PlanDraft {
        id: plan.plan_id.to_str_lossy().into_owned(),
        start: plan.start_man_id.to_str_lossy().into_owned(),
        maneuvers: plan.maneuvers.of::<PlanManeuver>().map(|maneuver| node(&maneuver)).collect(),
        transitions: plan
            .transitions
            .of::<PlanTransition>()
            .map(|transition| TransitionDraft {
                from: transition.source_man.to_str_lossy().into_owned(),
                to: transition.dest_man.to_str_lossy().into_owned(),
            })
            .collect(),
        notes: Vec::new(),
    }
}

/// A plan of one maneuver, as a console asks for it without a plan around it.
pub(crate) fn quick_plan(plan_id: &str, maneuver: Message) -> PlanSpecification {
    let name = maneuver.abbrev();
    let only = PlanManeuver { maneuver_id: name.into(), data: maneuver.into(), ..PlanManeuver::default() };
    PlanSpecification {
        plan_id: plan_id.into(),
        start_man_id: name.into(),
        maneuvers: [only].into_iter().collect(),
        ..PlanSpecification::default()
    }
}

fn node(node: &PlanManeuver) -> ManeuverDraft {
    let (depth_m, body) = match node.data.get() {
        Some(message) => (depth_m(&message), body(&message)),
        None => (None, DraftBody::Missing),
    };
    ManeuverDraft { id: node.maneuver_id.to_str_lossy().into_owned(), depth_m, body }
}

fn depth_m(message: &Message) -> Option<f64> {
    let (z, units) = match message {
        Message::Goto(m) => (m.z, m.z_units),
        Message::Launch(m) => (m.z, m.z_units),
        Message::Loiter(m) => (m.z, m.z_units),
        Message::StationKeeping(m) => (m.z, m.z_units),
        Message::FollowPath(m) => (deepest(m.z, m.points.of::<PathPoint>().map(|point| point.z)), m.z_units),
        Message::FollowTrajectory(m) => {
            (deepest(m.z, m.points.of::<TrajectoryPoint>().map(|point| point.z)), m.z_units)
        }
        Message::Rows(m) => (m.z, m.z_units),
        Message::RowsCoverage(m) => (m.z, m.z_units),
        Message::ScheduledGoto(m) => (m.z, m.z_units),
        Message::FollowSystem(m) => (m.z, m.z_units),
        _ => return None,
    };
    (units == ZUnits::Depth).then_some(f64::from(z))
}

/// The deepest of points that are offset down from `z`; NaN if one of them is NaN.
fn deepest(z: f32, offsets: impl Iterator<Item = f32>) -> f32 {
    let deeper = |most: f32, z: f32| if most.is_nan() || z.is_nan() { f32::NAN } else { most.max(z) };
    offsets.map(|offset| z + offset).fold(z, deeper)
}

fn body(message: &Message) -> DraftBody {
    let known = match message {
        Message::Goto(m) => {
            Maneuver::Goto(mission::Goto { target: raw(m.lat, m.lon), speed: speed(m.speed, m.speed_units) })
        }
        Message::Launch(m) => Maneuver::Launch(mission::Launch {
            target: raw(m.lat, m.lon),
            speed: speed(m.speed, m.speed_units),
        }),
        Message::Loiter(m) => Maneuver::Loiter(loiter(m)),
        Message::StationKeeping(m) => Maneuver::StationKeeping(mission::StationKeeping {
            centre: raw(m.lat, m.lon),
            radius_m: f64::from(m.radius),
            speed: speed(m.speed, m.speed_units),
            duration: seconds(m.duration),
        }),
        Message::FollowPath(m) => Maneuver::FollowPath(mission::FollowPath {
            origin: raw(m.lat, m.lon),
            points: m.points.of::<PathPoint>().map(|point| offset(point.x, point.y)).collect(),
            speed: speed(m.speed, m.speed_units),
        }),
        Message::FollowTrajectory(m) => Maneuver::FollowTrajectory(mission::FollowTrajectory {
            origin: raw(m.lat, m.lon),
            points: m
                .points
                .of::<TrajectoryPoint>()
                .map(|point| TimedOffset { offset: offset(point.x, point.y), time_s: f64::from(point.t) })
                .collect(),
            speed: speed(m.speed, m.speed_units),
        }),
        Message::Rows(m) => Maneuver::Rows(rows(m)),
        Message::RowsCoverage(m) => Maneuver::RowsCoverage(rows_coverage(m)),
        Message::IdleManeuver(m) => Maneuver::Idle(mission::Idle { duration: seconds(m.duration) }),
        Message::ScheduledGoto(m) => Maneuver::ScheduledGoto(mission::ScheduledGoto {
            target: raw(m.lat, m.lon),
            // A time that is not valid lies in the past, so that the maneuver is late rather than waiting for ever.
            arrival: UtcTime::from_seconds(m.arrival_time).unwrap_or_default(),
            late: match m.delayed {
                ScheduledGotoDelayed::Resume => Late::Resume,
                ScheduledGotoDelayed::Skip => Late::Skip,
                ScheduledGotoDelayed::Fail | ScheduledGotoDelayed::Unlisted(_) => Late::Fail,
            },
        }),
        Message::FollowReference(m) => Maneuver::FollowReference(follow_reference(m)),
        Message::FollowSystem(m) => Maneuver::FollowSystem(follow_system(m)),
        Message::Teleoperation(m) => {
            Maneuver::Teleoperation(mission::Teleoperation { operator: operator(m) })
        }
        other => return DraftBody::Unsupported(other.abbrev().to_owned()),
    };
    DraftBody::Maneuver(known)
}

fn loiter(m: &Loiter) -> mission::Loiter<RawPlace> {
    let turn = match m.direction {
        LoiterDirection::Cclockw => Turn::CounterClockwise,
        LoiterDirection::Vdep
        | LoiterDirection::Clockw
        | LoiterDirection::Iwindcurr
        | LoiterDirection::Unlisted(_) => Turn::Clockwise,
    };
    let shape = match m.r#type {
        LoiterType::Default | LoiterType::Circular => LoiterShape::Circle(turn),
        LoiterType::Eight => LoiterShape::Eight { length_m: f64::from(m.length), bearing_rad: m.bearing },
        LoiterType::Racetrack | LoiterType::Hover | LoiterType::Unlisted(_) => LoiterShape::Other(turn),
    };
    mission::Loiter {
        centre: raw(m.lat, m.lon),
        radius_m: f64::from(m.radius),
        speed: speed(m.speed, m.speed_units),
        duration: seconds(m.duration),
        shape,
    }
}

fn rows(m: &Rows) -> mission::Rows<RawPlace> {
    mission::Rows {
        origin: raw(m.lat, m.lon),
        speed: speed(m.speed, m.speed_units),
        bearing_rad: m.bearing,
        cross_angle_rad: m.cross_angle,
        width_m: f64::from(m.width),
        length_m: f64::from(m.length),
        step_m: f64::from(m.hstep),
        curve_offset_m: f64::from(m.coff),
        alternation: f64::from(m.alternation) / 100.0,
        square_curve: m.flags.contains(RowsFlags::SQUARE_CURVE),
        curve_right: m.flags.contains(RowsFlags::CURVE_RIGHT),
    }
}

fn rows_coverage(m: &RowsCoverage) -> mission::RowsCoverage<RawPlace> {
    mission::RowsCoverage {
        origin: raw(m.lat, m.lon),
        speed: speed(m.speed, m.speed_units),
        bearing_rad: m.bearing,
        cross_angle_rad: m.cross_angle,
        width_m: f64::from(m.width),
        length_m: f64::from(m.length),
        curve_offset_m: f64::from(m.coff),
        swath: Swath {
            range_m: f64::from(m.range),
            aperture_rad: f64::from(m.ang_aperture),
            overlap: f64::from(m.overlap) / 100.0,
        },
        square_curve: m.flags.contains(RowsCoverageFlags::SQUARE_CURVE),
        curve_right: m.flags.contains(RowsCoverageFlags::CURVE_RIGHT),
    }
}

fn follow_reference(m: &FollowReference) -> mission::FollowReference {
    mission::FollowReference {
        system: (m.control_src != ANY_SYSTEM).then_some(m.control_src),
        entity: (m.control_ent != ANY_ENTITY).then_some(m.control_ent),
        // Without a timeout a vessel whose controller fell silent would never be at rest again.
        timeout: Some(float_seconds(m.timeout).unwrap_or(REFERENCE_SILENCE)),
        radius_m: (m.loiter_radius > 0.0).then_some(f64::from(m.loiter_radius)),
    }
}

fn follow_system(m: &FollowSystem) -> mission::FollowSystem {
    mission::FollowSystem {
        system: m.system,
        speed: speed(m.speed, m.speed_units),
        ahead_m: f64::from(m.x),
        port_m: f64::from(m.y),
        duration: seconds(m.duration),
    }
}

/// Who may steer: `src=<address>` of the custom settings; 0 or absent is anyone.
fn operator(m: &Teleoperation) -> Operator {
    let custom = m.custom.to_str_lossy();
    match tuples::get(&custom, "src").and_then(|text| text.parse::<imc::Address>().ok()) {
        None | Some(imc::Address(0)) => Operator::Anyone,
        Some(address) => Operator::System(address.0),
    }
}

/// A commander's reference.
pub(crate) fn reference(system: u16, entity: u8, m: &Reference) -> mission::Reference {
    let has = |flag| m.flags.contains(flag);
    let place = LatLon::from_rad(m.lat, m.lon).ok();
    let start = has(ReferenceFlags::START_POINT);
    mission::Reference {
        system,
        entity,
        location: place.filter(|_| has(ReferenceFlags::LOCATION)),
        start_point: place.filter(|_| start),
        speed: match m.speed.of::<DesiredSpeed>() {
            Some(desired) if has(ReferenceFlags::SPEED) => Some(speed64(desired.value, desired.speed_units)),
            _ => None,
        },
        radius_m: has(ReferenceFlags::RADIUS).then_some(f64::from(m.radius)),
        direct: has(ReferenceFlags::DIRECT),
        done: has(ReferenceFlags::MANDONE),
    }
}

fn raw(lat_rad: f64, lon_rad: f64) -> RawPlace {
    RawPlace { lat_rad, lon_rad }
}

fn offset(x: f32, y: f32) -> Offset {
    Offset { north_m: f64::from(x), east_m: f64::from(y) }
}

fn seconds(seconds: u16) -> Option<Duration> {
    (seconds > 0).then(|| Duration::from_secs(seconds.into()))
}

fn float_seconds(seconds: f32) -> Option<Duration> {
    (seconds > 0.0).then(|| Duration::from_secs_f32(seconds.min(LONGEST_S)))
}

fn speed(value: f32, units: SpeedUnits) -> Speed {
    speed64(f64::from(value), units)
}

/// A speed; of an unknown unit it is not a number, which no plan may have.
pub(crate) fn speed64(value: f64, units: SpeedUnits) -> Speed {
    match units {
        SpeedUnits::MetersPs => Speed::MetresPerSecond(value),
        SpeedUnits::Rpm => Speed::Rpm(value),
        SpeedUnits::Percentage => Speed::Percent(value),
        SpeedUnits::Unlisted(_) => Speed::MetresPerSecond(f64::NAN),
    }
}

/// IMC's number of a maneuver.
pub(crate) fn number(kind: ManeuverKind) -> u16 {
    match kind {
        ManeuverKind::Goto => 450,
        ManeuverKind::Teleoperation => 452,
        ManeuverKind::Loiter => 453,
        ManeuverKind::Idle => 454,
        ManeuverKind::Launch => 485,
        ManeuverKind::Rows => 456,
        ManeuverKind::FollowPath => 457,
        ManeuverKind::StationKeeping => 461,
        ManeuverKind::FollowTrajectory => 463,
        ManeuverKind::FollowSystem => 471,
        ManeuverKind::FollowReference => 478,
        ManeuverKind::ScheduledGoto => 487,
        ManeuverKind::RowsCoverage => 488,
    }
}

/// Whether a message is a maneuver that can be run on its own.
pub(crate) fn is_maneuver(message: &Message) -> bool {
    matches!(body(message), DraftBody::Maneuver(_))
}

#[cfg(test)]
mod tests {
    use super::*;
    use imc::Payload;
    use imc::messages as m;

    #[test]
    fn numbers_are_those_of_the_catalogue() {
        for (kind, id) in [
            (ManeuverKind::Goto, m::Goto::ID),
            (ManeuverKind::Teleoperation, m::Teleoperation::ID),
            (ManeuverKind::Loiter, m::Loiter::ID),
            (ManeuverKind::Idle, m::IdleManeuver::ID),
            (ManeuverKind::Launch, m::Launch::ID),
            (ManeuverKind::Rows, m::Rows::ID),
            (ManeuverKind::FollowPath, m::FollowPath::ID),
            (ManeuverKind::StationKeeping, m::StationKeeping::ID),
            (ManeuverKind::FollowTrajectory, m::FollowTrajectory::ID),
            (ManeuverKind::FollowSystem, m::FollowSystem::ID),
            (ManeuverKind::FollowReference, m::FollowReference::ID),
            (ManeuverKind::ScheduledGoto, m::ScheduledGoto::ID),
            (ManeuverKind::RowsCoverage, m::RowsCoverage::ID),
        ] {
            assert_eq!(number(kind), id, "{kind}");
        }
    }

    #[test]
    fn the_operator_is_named_in_decimal_or_is_anyone() {
        let named = |custom: &str| operator(&Teleoperation { custom: custom.into() });
        assert_eq!(named("src=16385"), Operator::System(0x4001));
        assert_eq!(named("src=0"), Operator::Anyone);
        assert_eq!(named(""), Operator::Anyone);
    }

    #[test]
    fn a_speed_of_an_unknown_unit_is_no_speed() {
        assert!(speed(1.0, SpeedUnits::Unlisted(9)).value().is_nan());
    }

    #[test]
    fn what_is_no_maneuver_is_unsupported_by_name() {
        let plan = quick_plan("x", m::Heartbeat.into());
        let draft = draft(&plan);
        assert_eq!(draft.maneuvers[0].body, DraftBody::Unsupported("Heartbeat".into()));
        assert!(is_maneuver(&m::Goto::default().into()) && !is_maneuver(&m::Abort.into()));
    }
}
