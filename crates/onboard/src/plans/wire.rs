//! States and statistics of the mission as IMC has them.

use crate::plans::translate::{NO_MANEUVER, number};
use imc::messages::{
    CLoopsMask, FollowRefState, FollowRefStateProximity, FollowRefStateState, Message, PlanControlState,
    PlanControlStateLastOutcome, PlanControlStateState, PlanStatistics, PlanStatisticsProperties,
    PlanStatisticsType, VehicleState, VehicleStateFlags, VehicleStateOpMode,
};
use mission::{LastOutcome, Mode, PlanPhase, PlanState, ReferencePhase, ReferenceState};

/// Unknown time to arrival, where it has 16 bits.
const NO_ETA: u16 = 0xFFFF;

pub(crate) fn plan_state(state: &PlanState) -> PlanControlState {
    let eta = |seconds: Option<f64>| seconds.map_or(-1, |seconds| seconds.clamp(0.0, 1e9) as i32);
    PlanControlState {
        state: match state.phase {
            PlanPhase::Blocked => PlanControlStateState::Blocked,
            PlanPhase::Ready => PlanControlStateState::Ready,
            PlanPhase::Initializing => PlanControlStateState::Initializing,
            PlanPhase::Executing => PlanControlStateState::Executing,
        },
        plan_id: state.plan_id.as_str().into(),
        plan_eta: eta(state.plan_eta_s),
        plan_progress: state.progress.map_or(-1.0, |progress| (100.0 * progress) as f32),
        man_id: state.maneuver.as_ref().map_or("", |(id, _)| id.as_str()).into(),
        man_type: state.maneuver.as_ref().map_or(NO_MANEUVER, |(_, kind)| number(*kind)),
        man_eta: eta(state.maneuver_eta_s),
        last_outcome: match state.last_outcome {
            LastOutcome::None => PlanControlStateLastOutcome::None,
            LastOutcome::Success => PlanControlStateLastOutcome::Success,
            LastOutcome::Failure => PlanControlStateLastOutcome::Failure,
        },
    }
}

pub(crate) fn vehicle_state(state: &mission::VehicleState, loops: CLoopsMask) -> VehicleState {
    let mut flags = VehicleStateFlags::empty();
    flags.set(VehicleStateFlags::MANEUVER_DONE, state.maneuver_done);
    let (last_error, last_error_time) =
        state.last_error.as_ref().map_or(("", -1.0), |(text, at)| (text.as_str(), at.seconds()));
    VehicleState {
        op_mode: match state.mode {
            Mode::Boot => VehicleStateOpMode::Boot,
            Mode::Service => VehicleStateOpMode::Service,
            Mode::Calibration => VehicleStateOpMode::Calibration,
            Mode::Error => VehicleStateOpMode::Error,
            Mode::Maneuver => VehicleStateOpMode::Maneuver,
        },
        error_count: state.errors.len().min(255) as u8,
        error_ents: state.errors.join(",").into(),
        maneuver_type: state.maneuver.map_or(NO_MANEUVER, number),
        maneuver_stime: state.maneuver_began.map_or(-1.0, units::UtcTime::seconds),
        maneuver_eta: state.maneuver_eta_s.map_or(NO_ETA, |eta_s| eta_s.clamp(0.0, 65_534.0) as u16),
        control_loops: loops,
        flags,
        last_error: last_error.into(),
        last_error_time,
    }
}

/// Statistics before a start: durations and distances by maneuver, energy as share of the batteries.
pub(crate) fn statistics(statistics: &mission::PlanStatistics, capacity_wh: f64) -> PlanStatistics {
    let list = |value: &dyn Fn(&mission::Cost) -> Option<f64>| {
        let total = ("Total".to_owned(), value(&statistics.total));
        let each = statistics.maneuvers.iter().map(|(id, cost)| (format!("Maneuver {id}"), value(cost)));
        let known = std::iter::once(total).chain(each);
        // As DUNE writes it: commas between, -1 for what is not known.
        let texts = known.map(|(name, value)| format!("{name}={:.1}", value.unwrap_or(-1.0)));
        texts.collect::<Vec<_>>().join(",")
    };
    let fuel = statistics.total.energy_j.map_or_else(String::new, |joule| {
        let watt_hours = joule / 3600.0;
        format!("Total={:.2},Energy={watt_hours:.1}", 100.0 * watt_hours / capacity_wh.max(1.0))
    });
    let mut properties = PlanStatisticsProperties::BASIC;
    if statistics.total.duration_s.is_none() {
        properties |= PlanStatisticsProperties::INFINITE;
    }
    PlanStatistics {
        plan_id: statistics.plan_id.as_str().into(),
        r#type: PlanStatisticsType::Preplan,
        properties,
        durations: list(&|cost| cost.duration_s).into(),
        distances: list(&|cost| cost.length_m).into(),
        actions: "".into(),
        fuel: fuel.into(),
    }
}

/// The state of FollowReference, for its commander. `reference` is the message last heard.
pub(crate) fn reference_state(
    state: &ReferenceState,
    source: (u16, u8),
    reference: Option<Message>,
) -> FollowRefState {
    FollowRefState {
        control_src: source.0,
        control_ent: source.1,
        reference: reference.into(),
        state: match state.phase {
            ReferencePhase::Wait => FollowRefStateState::Wait,
            ReferencePhase::Goto => FollowRefStateState::Goto,
            ReferencePhase::Hover => FollowRefStateState::Hover,
            ReferencePhase::Timeout => FollowRefStateState::Timeout,
        },
        proximity: if state.near { FollowRefStateProximity::XY_NEAR } else { FollowRefStateProximity::FAR },
    }
}
