//! The supervisors that step in by themselves: lost communications, battery reserve, operational limits,
//! grounding.
//!
//! The mission's machines decide; here they are told what happens, the [arbiter](crate::arbiter) weighs what
//! they ask, and remedies become plans that the engine runs. Each says in its entity's state what it does,
//! what it will do next, and when.

mod grounding;

use crate::arbiter::{Arbiter, Picture, Source, Standing};
use crate::bus::Bus;
use crate::entity::Entity;
use crate::grounding::{DEEP_WATER, Exempted, Grounding, GroundingSettings};
use crate::navigation::Estimate;
use crate::output::Level;
use crate::pilot::{Drive, Pilot};
use crate::plans::Plans;
use crate::sensors::Sensors;
use crate::settings::{Settings, WatchSettings};
use crate::states::{Condition, States};
use imc::messages::{FuelLevel, Message, SpeedUnits, StationKeeping, ZUnits};
use mission::{
    Activity, BatteryOutput, BatteryReserve, BatteryStage, LastOutcome, LimitsConfig, LimitsOutput,
    LostComms, LostCommsInput, LostCommsOutput, OperationalLimits, Outlook, Remedy, RunId, Violation,
};
use std::time::Duration;
use units::{LatLon, MonoTime};

/// Name of the plan that keeps the vessel where it is.
const HOLD_PLAN: &str = "hold";
const FUEL_REPORT: Duration = Duration::from_secs(10);
const REASON_KEPT: Duration = Duration::from_secs(2);

/// The supervisors.
#[derive(Debug)]
pub(crate) struct Supervise {
    lost_comms: LostComms,
    battery: BatteryReserve,
    limits: OperationalLimits,
    pub(crate) grounding: Grounding,
    arbiter: Arbiter,
    config: WatchSettings,
    /// An operator has set the vessel in motion and nobody has aborted since. Until then no supervisor starts
    /// the motors: the vessel may lie on its trailer or at the quay.
    under_way: bool,
    heard: bool,
    /// What stands in the way of a remedy, as told last.
    obstacle: Option<String>,
    next_fuel: MonoTime,
}

impl Supervise {
    pub(crate) fn new(settings: &Settings, now: MonoTime) -> Self {
        Self {
            lost_comms: LostComms::new(now, settings.watch.lost_comms.clone()),
            battery: BatteryReserve::new(settings.watch.battery.clone()),
            limits: OperationalLimits::new(settings.watch.limits.clone()),
            grounding: Grounding::default(),
            arbiter: Arbiter::default(),
            config: settings.watch.clone(),
            under_way: false,
            heard: false,
            obstacle: None,
            next_fuel: now,
        }
    }

    pub(crate) fn reconfigure(&mut self, settings: &Settings) {
        self.lost_comms.reconfigure(settings.watch.lost_comms.clone());
        self.battery.reconfigure(settings.watch.battery.clone());
        self.limits.reconfigure(settings.watch.limits.clone());
        self.config = settings.watch.clone();
    }

    /// Somebody aborted: the motors stay still until an operator starts something again.
    pub(crate) fn aborted(&mut self) {
        self.under_way = false;
        self.grounding.stepped_in();
        self.arbiter.stepped_in();
    }

    /// An operator started or stopped something: what was asked before is settled.
    pub(crate) fn stepped_in(&mut self) {
        self.grounding.stepped_in();
        self.arbiter.stepped_in();
    }

    /// Somebody else commands from ashore; whether an exemption of the one before ends by that.
    pub(crate) fn commander_changed(&mut self, now: MonoTime) -> bool {
        self.grounding.exemption.request(now, 0.0) == Exempted::Ended
    }

    /// A console was heard.
    pub(crate) fn contact(&mut self, now: MonoTime) {
        self.heard = true;
        self.lost_comms.handle_input(now, LostCommsInput::Contact);
    }

    /// The run of a remedy, if one runs.
    pub(crate) fn remedy_run(&self) -> Option<RunId> {
        self.arbiter.run()
    }

    pub(crate) fn poll_timeout(&self) -> Option<MonoTime> {
        self.lost_comms.poll_timeout()
    }

    /// Looks at everything, and does what falls due.
    pub(crate) fn watch(&mut self, desk: &mut Desk<'_>, sensors: &Sensors) {
        let now = desk.bus.mono();
        let activity = self.activity(desk);
        self.lost_comms.handle_input(now, LostCommsInput::Activity(activity));
        if let Some(percent) = sensors.charge_percent() {
            self.battery.handle_charge(now, percent / 100.0);
        }
        if let Some(voltage_v) = sensors.voltage_v() {
            self.battery.handle_voltage(now, voltage_v);
        }
        if let Some(estimate) = desk.estimate {
            self.limits.handle_fix(now, &estimate.fix());
        }
        self.drain(desk);
        self.carry_out(desk);
        self.tell(desk);
        self.tell_battery(desk, sensors);
    }

    /// Only what is due by the clock.
    pub(crate) fn tick(&mut self, desk: &mut Desk<'_>) {
        let now = desk.bus.mono();
        if self.lost_comms.poll_timeout().is_some_and(|due| due <= now) {
            let activity = self.activity(desk);
            self.lost_comms.handle_input(now, LostCommsInput::Activity(activity));
            self.lost_comms.handle_timeout(now);
            self.drain(desk);
            self.carry_out(desk);
        }
    }

    fn activity(&mut self, desk: &Desk<'_>) -> Activity {
        let run = desk.plans.plan_state().run;
        let activity = match (run, desk.pilot.drive()) {
            (None, _) => Activity::Idle,
            (Some(_), _) if run == self.arbiter.run() => Activity::Remedy,
            (Some(_), Drive::Remote(_)) => Activity::Teleoperation,
            (Some(_), Drive::Off | Drive::Path) => Activity::Plan,
        };
        self.under_way |= matches!(activity, Activity::Plan | Activity::Teleoperation);
        activity
    }

    fn drain(&mut self, desk: &mut Desk<'_>) {
        let now = desk.bus.mono();
        while let Some(output) = self.lost_comms.poll_output() {
            match output {
                LostCommsOutput::Regained => {
                    self.arbiter.withdraw(Source::LostComms);
                    desk.bus.entry(Entity::LostComms, Level::Info, "a console is heard again");
                }
                LostCommsOutput::Act(remedy) => {
                    let text = format!("no console is heard: {remedy}");
                    desk.bus.entry(Entity::LostComms, Level::Warning, text);
                    self.arbiter.ask(now, Source::LostComms, remedy);
                }
            }
        }
        while let Some(output) = self.battery.poll_output() {
            match output {
                BatteryOutput::Stage(stage) => {
                    if stage < BatteryStage::Reserve {
                        self.arbiter.withdraw(Source::Battery);
                    }
                    let level = if stage == BatteryStage::Normal { Level::Info } else { Level::Warning };
                    desk.bus.entry(Entity::Fuel, level, format!("battery: {}", stage_text(stage)));
                }
                BatteryOutput::Act(remedy) => self.arbiter.ask(now, Source::Battery, remedy),
            }
        }
        while let Some(output) = self.limits.poll_output() {
            match output {
                LimitsOutput::Kept(violation) => {
                    if self.limits.passed().next().is_none() {
                        self.arbiter.withdraw(Source::Limits);
                    }
                    let text = format!("{} again", kept_text(violation));
                    desk.bus.entry(Entity::Limits, Level::Info, text);
                }
                LimitsOutput::Passed(violation, remedy) => {
                    let done = remedy.as_ref().map_or("only told".to_owned(), Remedy::to_string);
                    let text = format!("{}: {done}", passed_text(violation));
                    desk.bus.entry(Entity::Limits, Level::Error, text);
                    if let Some(remedy) = remedy {
                        self.arbiter.ask(now, Source::Limits, remedy);
                    }
                }
            }
        }
    }

    /// Does what the arbiter decides.
    fn carry_out(&mut self, desk: &mut Desk<'_>) {
        let state = desk.plans.plan_state();
        let ended_well = state.last_outcome == LastOutcome::Success;
        let picture = Picture { run: state.run, ended_well, under_way: self.under_way };
        let Some((source, wanted)) = self.arbiter.decide(desk.bus.mono(), picture) else { return };
        let mut obstacle = None;
        // The next weaker stands in for what is not possible, at last the stop.
        for remedy in stand_ins(&wanted) {
            if remedy != wanted && self.arbiter.carries(&remedy) {
                break;
            }
            match desk.start(&remedy) {
                Ok(Some(run)) => self.arbiter.began(run, source, remedy),
                Ok(None) => {}
                Err(reason) => {
                    obstacle.get_or_insert(reason);
                    continue;
                }
            }
            break;
        }
        if obstacle != self.obstacle
            && let Some(reason) = &obstacle
        {
            let text = format!("'{wanted}' is not possible: {reason}; it is tried again and again");
            desk.bus.entry(entity_of(source), Level::Error, text);
        }
        self.obstacle = obstacle;
    }

    /// What became of what a supervisor asked for.
    fn standing(&self, bus: &Bus, source: Source) -> Option<String> {
        let (remedy, standing) = self.arbiter.standing(source)?;
        Some(match (standing, &self.obstacle) {
            (Standing::Holds, _) => format!("{remedy}: in force"),
            (Standing::Waits(at), Some(why)) => {
                format!("{remedy}: not possible ({why}); next try at {}", clock_text(bus, at))
            }
            (Standing::Waits(at), None) => format!("{remedy}: next try at {}", clock_text(bus, at)),
            (Standing::AtRest, _) => {
                format!("{remedy}: not before an operator has set the vessel in motion")
            }
            (Standing::Settled, _) => format!("{remedy}: done, or an operator decided otherwise"),
        })
    }

    /// What each does, will do next, and when.
    fn tell(&self, desk: &mut Desk<'_>) {
        let outlook = self.lost_comms.outlook().map(|outlook| outlook_text(desk.bus, &outlook));
        let next = outlook.clone().unwrap_or_else(|| "carry on".to_owned());
        let (condition, text) = if self.lost_comms.is_lost() {
            let now =
                self.standing(desk.bus, Source::LostComms).unwrap_or_else(|| "nothing asked".to_owned());
            let next = outlook.unwrap_or_else(|| "nothing further".to_owned());
            (Condition::Fault, format!("no console is heard; {now}; next: {next}"))
        } else if self.heard {
            (Condition::Normal, format!("in contact; without: {next}"))
        } else {
            (Condition::Normal, "no console was ever heard; acts once one was".to_owned())
        };
        desk.states.set(desk.bus, Entity::LostComms, condition, text);
        self.tell_limits(desk);
        self.tell_grounding(desk);
    }

    fn tell_limits(&self, desk: &mut Desk<'_>) {
        let LimitsConfig { area, area_remedy, max_speed_mps, speed_remedy, .. } = &self.config.limits;
        let what = |remedy: &Option<Remedy>| remedy.as_ref().map_or("tell".to_owned(), Remedy::to_string);
        let mut watched = Vec::new();
        if area.is_some() {
            watched.push(format!("outside the area: {}", what(area_remedy)));
        }
        if let Some(limit_mps) = max_speed_mps {
            watched.push(format!("above {limit_mps:.1} m/s: {}", what(speed_remedy)));
        }
        let passed: Vec<_> = self.limits.passed().map(passed_text).collect();
        let (condition, text) = if !passed.is_empty() {
            let done = self.standing(desk.bus, Source::Limits).unwrap_or_else(|| "only told".to_owned());
            (Condition::Error, format!("{}; {done}", passed.join(", ")))
        } else if let Some(next) = self.limits.outlook() {
            (Condition::Fault, format!("a limit is passed; next: {}", outlook_text(desk.bus, &next)))
        } else if watched.is_empty() {
            (Condition::Normal, "no limits are set".to_owned())
        } else {
            let depth = self.limits.depth_m().map(|depth_m| format!("{depth_m:.0} m inside the area; "));
            let kept = depth.unwrap_or_else(|| "kept; ".to_owned());
            (Condition::Normal, format!("{kept}next: {}", watched.join(", ")))
        };
        desk.states.set(desk.bus, Entity::Limits, condition, text);
    }

    fn tell_battery(&mut self, desk: &mut Desk<'_>, sensors: &Sensors) {
        let silent = sensors.silent_batteries();
        let Some(percent) = sensors.charge_percent() else {
            let (condition, text) = if silent.is_empty() {
                (Condition::Normal, "no battery reports; nothing is watched until one does".to_owned())
            } else {
                let text = format!("{} no longer reports; what was last asked stays", silent.join(", "));
                (Condition::Fault, text)
            };
            desk.states.set(desk.bus, Entity::Fuel, condition, text);
            return;
        };
        let (power_w, used_wh) = sensors.power_w();
        let left_wh = desk.capacity_wh * percent / 100.0;
        let hours = (power_w > 1.0).then(|| left_wh / power_w);
        let next = match (self.battery.outlook(), self.battery.next_warning()) {
            (Some(outlook), _) => outlook_text(desk.bus, &outlook),
            (None, Some((charge, at))) => {
                let at = at.map_or_else(String::new, |at| format!(" at {}", clock_text(desk.bus, at)));
                format!("a warning below {:.0} %{at}", 100.0 * charge)
            }
            (None, None) => "nothing further".to_owned(),
        };
        let mut parts = vec![format!("{percent:.0} %, {power_w:.0} W, {used_wh:.0} Wh used")];
        if !silent.is_empty() {
            parts.push(format!("{} does not report", silent.join(", ")));
        }
        parts.extend(self.standing(desk.bus, Source::Battery));
        parts.push(format!("next: {next}"));
        let condition = match self.battery.stage() {
            BatteryStage::Normal if silent.is_empty() => Condition::Normal,
            BatteryStage::Normal | BatteryStage::Low => Condition::Fault,
            BatteryStage::Reserve | BatteryStage::Critical => Condition::Error,
        };
        desk.states.set(desk.bus, Entity::Fuel, condition, parts.join("; "));
        if desk.bus.mono() >= self.next_fuel {
            self.next_fuel = desk.bus.mono() + FUEL_REPORT;
            let opmodes = hours.map_or_else(String::new, |hours| format!("Present={hours:.1}"));
            let level = FuelLevel { value: percent as f32, confidence: 100.0, opmodes: opmodes.into() };
            desk.bus.send(Entity::Fuel, &level);
        }
    }
}

/// A remedy and what stands in for it where it is not possible, in this order.
fn stand_ins(remedy: &Remedy) -> Vec<Remedy> {
    match remedy {
        Remedy::Run { .. } => vec![remedy.clone(), Remedy::Hold, Remedy::Stop],
        Remedy::Hold => vec![Remedy::Hold, Remedy::Stop],
        Remedy::Stop => vec![Remedy::Stop],
    }
}

fn entity_of(source: Source) -> Entity {
    match source {
        Source::LostComms => Entity::LostComms,
        Source::Battery => Entity::Fuel,
        Source::Limits => Entity::Limits,
        Source::Grounding => Entity::Grounding,
    }
}

/// What the supervisors work with.
pub(crate) struct Desk<'a> {
    pub(crate) bus: &'a mut Bus,
    pub(crate) states: &'a mut States,
    pub(crate) plans: &'a mut Plans,
    pub(crate) pilot: &'a mut Pilot,
    pub(crate) estimate: Option<&'a Estimate>,
    pub(crate) hold_radius_m: f64,
    pub(crate) hold_speed_mps: f64,
    pub(crate) capacity_wh: f64,
    pub(crate) grounding: &'a GroundingSettings,
}

impl Desk<'_> {
    /// Carries a remedy out; answers its run, none where it needs none, or why it is not possible now.
    fn start(&mut self, remedy: &Remedy) -> Result<Option<RunId>, String> {
        let (plan_id, maneuver) = match remedy {
            Remedy::Stop => {
                self.plans.stop_own(self.bus, self.pilot);
                return Ok(None);
            }
            Remedy::Run { plan_id } if plan_id == DEEP_WATER => (
                DEEP_WATER,
                Some(self.deep_water().ok_or("no deep water is known that a straight way leads to")?),
            ),
            Remedy::Run { plan_id } if self.plans.has(plan_id) => (plan_id.as_str(), None),
            Remedy::Run { plan_id } => return Err(format!("there is no plan '{plan_id}'")),
            Remedy::Hold => (HOLD_PLAN, Some(self.hold().ok_or("the position is not known")?)),
        };
        let before = self.plans.plan_state().run;
        self.plans.start_own(self.bus, self.pilot, plan_id, maneuver);
        let run = self.plans.plan_state().run.filter(|run| Some(*run) != before);
        run.map(Some).ok_or_else(|| "the plan engine refuses".to_owned())
    }

    /// Keeping station where the vessel is.
    fn hold(&self) -> Option<Message> {
        let estimate = self.estimate.filter(|estimate| estimate.age < REASON_KEPT)?;
        Some(self.station(estimate.place, self.hold_radius_m))
    }

    /// Keeping station where it is deep.
    fn deep_water(&self) -> Option<Message> {
        let estimate = self.estimate.filter(|estimate| estimate.age < REASON_KEPT)?;
        let refuge = Grounding::refuge(self.grounding, estimate, self.hold_radius_m)?;
        Some(self.station(refuge.place, refuge.radius_m))
    }

    fn station(&self, place: LatLon, radius_m: f64) -> Message {
        let station = StationKeeping {
            lat: place.lat_rad(),
            lon: place.lon_rad(),
            z_units: ZUnits::Depth,
            radius: radius_m as f32,
            speed: self.hold_speed_mps as f32,
            speed_units: SpeedUnits::MetersPs,
            ..StationKeeping::default()
        };
        station.into()
    }
}

fn outlook_text(bus: &Bus, outlook: &Outlook) -> String {
    let Some(at) = outlook.at else { return outlook.remedy.to_string() };
    format!("{} at {}", outlook.remedy, clock_text(bus, at))
}

/// A deadline by the clock.
fn clock_text(bus: &Bus, at: MonoTime) -> String {
    let left = at.since(bus.mono());
    // Deadlines lie within days.
    let utc = units::UtcTime::from_micros(bus.utc().micros().saturating_add(left.as_micros() as i64)).civil();
    format!("{:02}:{:02}:{:02} UTC", utc.hour, utc.minute, utc.second)
}

fn passed_text(violation: Violation) -> &'static str {
    match violation {
        Violation::Area => "outside the area",
        Violation::Speed => "faster than allowed",
    }
}

fn kept_text(violation: Violation) -> &'static str {
    match violation {
        Violation::Area => "inside the area",
        Violation::Speed => "as slow as allowed",
    }
}

fn stage_text(stage: BatteryStage) -> &'static str {
    match stage {
        BatteryStage::Normal => "enough",
        BatteryStage::Low => "low",
        BatteryStage::Reserve => "down to the reserve",
        BatteryStage::Critical => "nearly empty",
    }
}
