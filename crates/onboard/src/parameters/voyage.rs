//! Navigation and the plan engine: what happens to a plan after a lost position, a lost track, or a restart of the program.

use super::{Homes, PERCENT, Parameter, Place};
use crate::entity::Entity;
use config::schema::mission::{navigation as gnss, plan};

const NAVIGATION: Homes = &[&gnss::NAVIGATION];
const ENGINE: Homes = &[&plan::ENGINE];

pub(super) fn navigation() -> Vec<Parameter> {
    let share =
        |spec, at, factor| Parameter::new(Entity::Navigation, NAVIGATION, spec, Place::Number(at, factor));
    let of = |spec, at| share(spec, at, 1.0);
    vec![
        of(gnss::MAXIMUM_HDOP.spec, |s| Some(&mut s.navigation.max_hdop)).file_only(),
        of(gnss::ASSUMED_HDOP.spec, |s| Some(&mut s.navigation.assumed_hdop)).file_only(),
        of(gnss::DEAD_RECKONING.spec, |s| Some(&mut s.navigation.reckoning_s)).file_only(),
        of(gnss::RECKONING_UNCERTAINTY.spec, |s| Some(&mut s.navigation.most_sigma_m)).file_only(),
        of(gnss::RECKONING_SPEED.spec, |s| Some(&mut s.navigation.reckoning_mps)).file_only(),
        of(gnss::RECKONING_DRIFT.spec, |s| Some(&mut s.navigation.drift_mps)).file_only(),
        share(gnss::RECKONING_ERROR.spec, |s| Some(&mut s.navigation.speed_error), PERCENT).file_only(),
        of(gnss::RECOVERY_TIME.spec, |s| Some(&mut s.navigation.recovery_s)).file_only(),
        of(gnss::JUMP_SPEED.spec, |s| Some(&mut s.navigation.jump_speed_mps)).file_only(),
        of(gnss::ORIGIN_DISTANCE.spec, |s| Some(&mut s.navigation.origin_distance_m)),
    ]
}

pub(super) fn engine() -> Vec<Parameter> {
    let of = |spec, at| Parameter::new(Entity::PlanEngine, ENGINE, spec, Place::Span(at)).file_only();
    vec![
        of(plan::POSITION_GAP.spec, |s| Some(&mut s.mission.engine.position_patience)),
        of(plan::TRACK_RECOVERY.spec, |s| Some(&mut s.mission.track_recovery)),
        of(plan::COUNTDOWN.spec, |s| Some(&mut s.mission.restart.countdown)),
        of(plan::RESTART_MEMORY.spec, |s| Some(&mut s.mission.restart.memory)),
    ]
}
