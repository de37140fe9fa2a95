//! The supervisor's machine: from a survey of the water ahead to the action.

use super::exemption::{Answer, Exemption};
use super::settings::{Chart, ChartFile, GroundingAction, GroundingSettings};
use crate::navigation::Estimate;
use crate::pilot::Gate;
use charts::depth_index::{DepthIndex, Water};
use control::MotorPair;
use guard::{Ahead, Refuge, WaterAround};
use mission::RunId;
use std::time::Duration;
use units::MonoTime;

/// A slower vessel counts as not moving towards danger (m/s).
const LEAST_MPS: f64 = 0.1;
/// Danger within stopping distance and the way of this time slows the vessel down (s).
const SLOW_S: f64 = 4.0;
/// How slow (m/s).
const SLOW_MPS: f64 = 0.7;
/// From the decision to turn back until way is made away from danger (s): an Otter turns on the spot by 180° in
/// 10 s, and needs some to gather way.
const TURN_S: f64 = 15.0;
/// Slower lies, and what carries it is too slow for a course to be known (m/s).
const LYING_MPS: f64 = 0.2;
/// An operator's vessel that is braked is slow from here on (m/s).
const SLOWED_MPS: f64 = 1.0;
/// A vessel that lies close to danger and comes so much closer drifts in (m).
const CREEP_M: f64 = 1.0;
/// A vessel makes way ahead or astern when so much of its speed is along the hull: its course is within 25° of that.
const UNDER_WAY: f64 = 0.9;
/// Way beyond danger within stopping distance that does not matter (m).
const SLACK_M: f64 = 0.5;

/// The controller that moves the vessel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Doing {
    /// Nothing.
    Rest,
    /// A plan.
    Plan,
    /// An operator.
    Operator,
    /// Another supervisor's remedy.
    Remedy,
    /// This supervisor's remedy.
    Own,
}

/// How near danger is, as it is reported; later is worse.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Stage {
    /// None within the warning's time and distance.
    Clear,
    /// On the course.
    Ahead,
    /// Soon within stopping distance.
    Near,
    /// Within stopping distance, or being drifted into.
    Close,
    /// Hull or position uncertainty touches it.
    Within,
}

/// The supervisor's demand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Advice {
    /// A line for the log book: a state got worse, or is good again.
    Tell(Stage),
    /// Back to deep water.
    DeepWater,
    /// Stop and drift.
    Stop,
    /// Stop for good: the vessel lies in danger with its motors running.
    Abort,
    /// The operator's exemption is over.
    ExemptionOver,
}

/// The result of an operator's steering.
#[derive(Debug, Default)]
struct Steering {
    /// Hull and position uncertainty were clear of danger at some time of it.
    was_clear: bool,
    /// Since when the vessel is carried in, and whether slowly.
    carried_since: Option<(MonoTime, bool)>,
}

/// The machine.
#[derive(Debug, Default)]
pub(crate) struct Grounding {
    pub(crate) exemption: Exemption,
    stage: Option<Stage>,
    ahead: Option<Ahead>,
    speed_mps: f64,
    /// A demand is open that no operator has settled.
    asked: bool,
    /// Whether the rest began in water deep enough for autonomous sailing.
    rest_was_deep: Option<bool>,
    /// Whether another supervisor's remedy began in such water: it must stay there.
    remedy_was_deep: Option<bool>,
    within_since: Option<MonoTime>,
    steering: Steering,
    /// The most room beyond hull and uncertainty while it lies close to danger (m).
    lay_m: Option<f64>,
    /// It lies close to danger and comes closer.
    creeps: bool,
    gate: Gate,
    slows: bool,
    /// A chart that came and is not in force yet, and why.
    pub(crate) waiting_chart: Option<(ChartFile, String)>,
    /// A plan under way that the chart in force would refuse, in words.
    refused_plan: Option<(RunId, String)>,
}

impl Grounding {
    /// An operator decides from here on.
    pub(crate) fn stepped_in(&mut self) {
        self.asked = false;
        self.within_since = None;
        self.rest_was_deep = None;
        self.lay_m = None;
        self.steering = Steering::default();
    }

    /// Another chart is in force, and would refuse the plan under way so.
    pub(crate) fn charted(&mut self, refused_plan: Option<(RunId, String)>) {
        self.refused_plan = refused_plan;
        self.waiting_chart = None;
        self.rest_was_deep = None;
    }

    /// Which chart came and is not in force yet, and why.
    pub(crate) fn waiting_text(&self) -> Option<String> {
        let (chart, why) = self.waiting_chart.as_ref()?;
        Some(format!("the chart {} waits: {why}", chart.edition()))
    }

    /// Why the run would be refused by the chart that came during it.
    pub(crate) fn refused(&self, run: Option<RunId>) -> Option<&str> {
        self.refused_plan.as_ref().filter(|(of, _)| Some(*of) == run).map(|(_, why)| &why[..])
    }

    /// The limits of manual control.
    pub(crate) fn gate(&self) -> Gate {
        self.gate
    }

    /// The greatest speed of a path now (m/s), if any.
    pub(crate) fn speed_limit_mps(&self) -> Option<f64> {
        self.slows.then_some(SLOW_MPS)
    }

    pub(crate) fn stage(&self) -> Stage {
        self.stage.unwrap_or(Stage::Clear)
    }

    pub(crate) fn has_asked(&self) -> bool {
        self.asked
    }

    pub(crate) fn is_blocking(&self) -> bool {
        self.gate.ahead || self.gate.astern
    }

    /// Where to turn back to from here.
    pub(crate) fn refuge(settings: &GroundingSettings, estimate: &Estimate, radius_m: f64) -> Option<Refuge> {
        let index = settings.chart.index()?;
        let survey = water_around(index, settings, estimate, settings.limits.navigable_m);
        survey.refuge(&settings.limits, radius_m)
    }

    /// Looks at the water with a new estimate; `motors` is what they are commanded.
    pub(crate) fn see(
        &mut self,
        now: MonoTime,
        settings: &GroundingSettings,
        estimate: &Estimate,
        doing: Doing,
        motors: MotorPair,
    ) -> Vec<Advice> {
        let mut advice = Vec::new();
        let (exempt, answer) = self.exemption.check(now);
        if answer == Answer::Ended {
            advice.push(Advice::ExemptionOver);
        }
        let Some(index) = settings.chart.index() else {
            let waiting_chart = self.waiting_chart.take();
            *self = Self { exemption: self.exemption, waiting_chart, ..Self::default() };
            return advice;
        };
        if doing != Doing::Rest {
            self.rest_was_deep = None;
        }
        let (alone_m, steered_m) = (settings.limits.autonomous_m, settings.limits.navigable_m);
        if doing == Doing::Remedy {
            let is_deep = || water_around(index, settings, estimate, alone_m).is_clear();
            self.remedy_was_deep.get_or_insert_with(is_deep);
        } else {
            self.remedy_was_deep = None;
        }
        let least_m = match doing {
            Doing::Plan => alone_m,
            Doing::Remedy if self.remedy_was_deep == Some(true) => alone_m,
            Doing::Rest | Doing::Operator | Doing::Remedy | Doing::Own => steered_m,
        };
        let survey = water_around(index, settings, estimate, least_m);
        let motion = &estimate.motion;
        let course_rad = motion.east_mps.atan2(motion.north_mps);
        self.speed_mps = motion.speed_over_ground_mps();
        let stage = self.judge(&survey, settings, course_rad);
        let exempt = exempt && doing == Doing::Operator;
        if exempt || doing != Doing::Operator {
            self.steering = Steering::default();
        }
        let lies = matches!(doing, Doing::Rest | Doing::Operator) && !exempt;
        self.creeps = lies && self.creeps_in(&survey, settings);
        if !lies {
            self.lay_m = None;
        }
        self.gate = if doing == Doing::Operator && !exempt {
            gate(&survey, settings, estimate)
        } else {
            Gate::default()
        };
        self.slows = stage >= Stage::Near
            && matches!(doing, Doing::Plan | Doing::Remedy)
            && settings.action >= GroundingAction::Slow;
        if !exempt {
            self.act(now, settings, &survey, index, (doing, stage), course_rad, motors, &mut advice);
        }
        let running = motors != MotorPair::STOPPED;
        self.abort(now, settings, stage, running && !exempt, &mut advice);
        if self.stage != Some(stage) {
            let before = self.stage.replace(stage).unwrap_or(Stage::Clear);
            if stage > before || stage == Stage::Clear {
                advice.push(Advice::Tell(stage));
            }
        }
        advice
    }

    fn judge(&mut self, survey: &WaterAround<'_>, settings: &GroundingSettings, course_rad: f64) -> Stage {
        let stopping_m = settings.stopping_m(self.speed_mps);
        let slowing_m = stopping_m + SLOW_S * self.speed_mps;
        let warning_m = (settings.warning_time_s * self.speed_mps).max(settings.warning_distance_m);
        let moves = self.speed_mps > LEAST_MPS;
        let length_m = warning_m.max(slowing_m).max(1.0);
        self.ahead = moves.then(|| survey.ahead(course_rad, length_m)).flatten();
        if !survey.is_clear() {
            return Stage::Within;
        }
        match &self.ahead {
            Some(ahead) if ahead.distance_m <= stopping_m + SLACK_M => Stage::Close,
            Some(ahead) if ahead.distance_m <= slowing_m => Stage::Near,
            Some(_) => Stage::Ahead,
            None => Stage::Clear,
        }
    }

    #[expect(clippy::too_many_arguments, reason = "one survey at the vessel, told apart")]
    fn act(
        &mut self,
        now: MonoTime,
        settings: &GroundingSettings,
        survey: &WaterAround<'_>,
        index: &DepthIndex,
        (doing, stage): (Doing, Stage),
        course_rad: f64,
        motors: MotorPair,
        advice: &mut Vec<Advice>,
    ) {
        let wanted = match doing {
            Doing::Own => false,
            Doing::Plan | Doing::Remedy => stage >= Stage::Close,
            Doing::Operator => {
                self.operator_needs_help(now, survey, settings, course_rad, motors) || self.creeps
            }
            Doing::Rest => {
                let was_deep = *self.rest_was_deep.get_or_insert_with(|| {
                    let alone_m = settings.limits.autonomous_m;
                    WaterAround::new(index, &settings.limits, (survey.place(), 0.0), alone_m).is_clear()
                });
                was_deep
                    && (stage == Stage::Within || self.creeps || self.drifts_in(survey, settings, course_rad))
            }
        };
        if !wanted || self.asked {
            return;
        }
        match settings.action {
            GroundingAction::Warn | GroundingAction::Slow => {}
            GroundingAction::Stop => {
                self.asked = true;
                advice.push(Advice::Stop);
            }
            GroundingAction::DeepWater => {
                self.asked = true;
                advice.push(Advice::DeepWater);
            }
        }
    }

    /// Danger comes within what turning back takes, by the way the vessel drifts.
    fn drifts_in(&self, survey: &WaterAround<'_>, settings: &GroundingSettings, course_rad: f64) -> bool {
        let way_m = TURN_S * self.speed_mps + settings.reserve_m / 2.0;
        self.speed_mps > LEAST_MPS / 2.0 && survey.ahead(course_rad, way_m).is_some()
    }

    /// It lies close to danger and comes closer, however slowly: what began clear ends before the uncertainty of the
    /// position is used up.
    fn creeps_in(&mut self, survey: &WaterAround<'_>, settings: &GroundingSettings) -> bool {
        let own_m = survey.reach_m();
        let close_m = settings.reserve_m / 2.0;
        let lies = self.speed_mps < LYING_MPS;
        let room_m = lies.then(|| survey.clear_radius_m(survey.place(), own_m + close_m) - own_m);
        let Some(room_m) = room_m.filter(|room_m| *room_m < close_m) else {
            self.lay_m = None;
            return false;
        };
        let lay_m = self.lay_m.unwrap_or(room_m).max(room_m);
        self.lay_m = Some(lay_m);
        lay_m > 0.0 && room_m <= (lay_m - CREEP_M).max(0.0)
    }

    /// The vessel goes in, and not by the operator's thrust: that is blocked, or goes elsewhere.
    ///
    /// A vessel that begins in danger, such as at a quay, may leave it: one that was never clear is not moved on its own.
    fn operator_needs_help(
        &mut self,
        now: MonoTime,
        survey: &WaterAround<'_>,
        settings: &GroundingSettings,
        course_rad: f64,
        motors: MotorPair,
    ) -> bool {
        self.steering.was_clear |= survey.is_clear();
        let surge_mps = self.gate.surge_mps;
        let drives = f64::midpoint(motors.port, motors.starboard) * surge_mps > 0.0;
        let under_way = drives && surge_mps.abs() > UNDER_WAY * self.speed_mps && !self.is_blocking();
        if !self.steering.was_clear || under_way || !self.drifts_in(survey, settings, course_rad) {
            self.steering.carried_since = None;
            return false;
        }
        // A fast vessel is the operator's until its motors had the time to brake.
        let slow = self.speed_mps < SLOWED_MPS;
        let patience_s = if slow { settings.reaction_s } else { 2.0 * settings.reaction_s };
        let before = self.steering.carried_since.filter(|(_, before)| *before == slow);
        let (since, _) = *self.steering.carried_since.insert(before.unwrap_or((now, slow)));
        now.since(since) >= Duration::from_secs_f64(patience_s) || self.stage == Some(Stage::Within)
    }

    fn abort(
        &mut self,
        now: MonoTime,
        settings: &GroundingSettings,
        stage: Stage,
        running: bool,
        advice: &mut Vec<Advice>,
    ) {
        if stage != Stage::Within || !running || settings.abort_after_s <= 0.0 {
            self.within_since = None;
            return;
        }
        let since = *self.within_since.get_or_insert(now);
        if now.since(since).as_secs_f64() >= settings.abort_after_s {
            self.within_since = None;
            advice.push(Advice::Abort);
        }
    }

    /// The danger ahead, in words.
    pub(crate) fn text(&self, settings: &GroundingSettings) -> String {
        let Some(index) = settings.chart.index() else { return String::new() };
        let Some(ahead) = &self.ahead else {
            return match self.stage() {
                Stage::Within => "hull or position uncertainty touches danger".to_owned(),
                _ if self.creeps => "it lies close to danger and drifts closer".to_owned(),
                _ if self.gate.ahead && self.gate.astern => "danger is near ahead and astern".to_owned(),
                _ if self.gate.ahead => "danger is near ahead; astern is free".to_owned(),
                _ if self.gate.astern => "danger is near astern; ahead is free".to_owned(),
                _ => "the water ahead is deep enough".to_owned(),
            };
        };
        let what = match ahead.answer.water {
            Water::Land => "land".to_owned(),
            Water::Obstacle => "an obstacle".to_owned(),
            Water::UnknownDepth => "unknown depth".to_owned(),
            Water::NoData => "uncharted water".to_owned(),
            Water::TooLow { .. } => "something too low".to_owned(),
            Water::Depth { least_m, .. } => format!("water of {least_m:.1} m"),
        };
        let object = ahead.answer.object.and_then(|id| index.object(id));
        let name = object.as_ref().and_then(|object| object.class.acronym());
        let cell = object.as_ref().map(|object| index.source(object).name.as_str()).unwrap_or_default();
        let of = name.filter(|_| ahead.answer.water != Water::NoData);
        let of = of.map_or_else(String::new, |name| format!(" ({name} of {cell})"));
        let time_s = ahead.distance_m / self.speed_mps.max(LEAST_MPS);
        let at = ahead.answer.at;
        format!(
            "{what}{of} {:.0} m ahead, in {time_s:.0} s, at {:.5}, {:.5}",
            ahead.distance_m,
            at.lat_deg(),
            at.lon_deg()
        )
    }

    /// The chart's state in words, and whether it is good.
    pub(crate) fn chart_text(chart: &Chart) -> Result<String, String> {
        match chart {
            Chart::Off => {
                Ok("off: no chart is configured; neither plans nor the water ahead are checked".to_owned())
            }
            Chart::Unreadable { reason } => Err(format!("the chart cannot be read: {reason}")),
            Chart::Loaded(file) => Ok(format!("by chart {file}")),
        }
    }
}

/// The water around an estimate, needing `least_m`.
fn water_around<'a>(
    index: &'a DepthIndex,
    settings: &GroundingSettings,
    estimate: &Estimate,
    least_m: f64,
) -> WaterAround<'a> {
    WaterAround::new(index, &settings.limits, (estimate.place, estimate.sigma_m), least_m)
}

/// In which directions an operator's thrust is blocked.
fn gate(survey: &WaterAround<'_>, settings: &GroundingSettings, estimate: &Estimate) -> Gate {
    let motion = &estimate.motion;
    let (sin, cos) = motion.heading_rad.sin_cos();
    let surge_mps = motion.north_mps * cos + motion.east_mps * sin;
    let blocked = |direction_rad: f64, mps: f64| {
        let length_m = settings.stopping_m(mps.max(0.0)) + settings.reserve_m;
        survey.ahead(direction_rad, length_m).is_some()
    };
    // Already within the reserve on both sides, the roomier one stays open: there must be a way out.
    let mut gate = Gate {
        ahead: blocked(motion.heading_rad, surge_mps),
        astern: blocked(motion.heading_rad + std::f64::consts::PI, -surge_mps),
        surge_mps,
    };
    if gate.ahead && gate.astern {
        let room_m = |direction_rad: f64| {
            let frame = units::LocalFrame::new(survey.place());
            let there = units::LocalPoint::default().displaced(direction_rad, settings.limits.hull_m + 2.0);
            survey.clear_radius_m(frame.to_place(there), 100.0)
        };
        let ahead_m = room_m(motion.heading_rad);
        let astern_m = room_m(motion.heading_rad + std::f64::consts::PI);
        let here_m = survey.clear_radius_m(survey.place(), 100.0);
        gate.ahead = ahead_m <= here_m;
        gate.astern = astern_m <= here_m;
    }
    gate
}

#[cfg(test)]
mod tests {
    use super::*;
    use control::Motion;
    use testkit::sea::{Ground, Sea};
    use units::{LatLon, LocalPoint};

    /// 20 m of water with a bank of 3 m, 100 m north of the middle.
    fn bank() -> (Sea, GroundingSettings) {
        let middle = LatLon::from_deg(63.33, 10.0833).unwrap();
        let north = LocalPoint { north_m: 100.0, east_m: 0.0 };
        let sea = Sea::new(middle, 500.0, 20.0).with(Ground::Depth(3.0), north, 40.0, 12);
        let chart = Chart::of("bank", sea.index());
        (sea, GroundingSettings { chart, ..GroundingSettings::default() })
    }

    /// What is wanted of a vessel that goes north at 1.5 m/s from one place to another.
    fn north(doing: Doing, from_m: f64, to_m: f64) -> Vec<Advice> {
        let (sea, settings) = bank();
        let mut grounding = Grounding::default();
        let mut advice = Vec::new();
        for second in 0..=((to_m - from_m) / 1.5) as u32 {
            let offset = LocalPoint { north_m: from_m + 1.5 * f64::from(second), east_m: 0.0 };
            let estimate = Estimate {
                place: sea.frame().to_place(offset),
                origin: sea.frame().origin(),
                offset,
                height_m: 0.0,
                motion: Motion::from_course(0.0, None, 0.0, 1.5),
                sigma_m: 0.5,
                age: Duration::ZERO,
                lag: Duration::ZERO,
                heading_age: Duration::ZERO,
            };
            let now = MonoTime::from_micros(u64::from(second) * 1_000_000);
            let motors = MotorPair { port: 0.5, starboard: 0.5 };
            advice.extend(grounding.see(now, &settings, &estimate, doing, motors));
        }
        advice
    }

    #[test]
    fn what_began_in_deep_water_stays_there_by_whomever_it_was_asked() {
        assert!(north(Doing::Plan, 0.0, 90.0).contains(&Advice::DeepWater));
        assert!(north(Doing::Remedy, 0.0, 90.0).contains(&Advice::DeepWater), "3 m is not deep enough alone");
        // One that an operator took over the bank is brought home from there.
        assert!(!north(Doing::Remedy, 90.0, 130.0).contains(&Advice::DeepWater));
        assert!(!north(Doing::Operator, 0.0, 130.0).contains(&Advice::DeepWater));
    }
}
