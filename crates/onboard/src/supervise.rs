//! The supervisors that step in by themselves: lost communications, battery reserve, operational limits.
//!
//! The mission's machines decide; here they are told what happens, and their remedies become plans that the
//! engine runs. Each says in its entity's state what it will do next, and when.

use crate::bus::Bus;
use crate::entity::Entity;
use crate::navigation::Estimate;
use crate::output::Level;
use crate::pilot::{Drive, Pilot};
use crate::plans::Plans;
use crate::sensors::Sensors;
use crate::settings::Settings;
use crate::states::{Condition, States};
use imc::messages::{FuelLevel, Message, SpeedUnits, StationKeeping, ZUnits};
use mission::{
    Activity, BatteryOutput, BatteryReserve, BatteryStage, LimitsOutput, LostComms, LostCommsInput,
    LostCommsOutput, OperationalLimits, Outlook, PlanPhase, Remedy,
};
use std::time::Duration;
use units::MonoTime;

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
    /// The plan that carries out a remedy.
    remedy: Option<String>,
    /// An operator has set the vessel in motion and nobody has aborted since. Until then no supervisor starts
    /// the motors: the vessel may lie on its trailer or at the quay.
    under_way: bool,
    heard: bool,
    violated: bool,
    next_fuel: MonoTime,
}

/// Who wants a remedy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum By {
    LostComms,
    Battery,
    Limits,
}

impl Supervise {
    pub(crate) fn new(settings: &Settings, now: MonoTime) -> Self {
        Self {
            lost_comms: LostComms::new(now, settings.watch.lost_comms.clone()),
            battery: BatteryReserve::new(settings.watch.battery.clone()),
            limits: OperationalLimits::new(settings.watch.limits.clone()),
            remedy: None,
            under_way: false,
            heard: false,
            violated: false,
            next_fuel: now,
        }
    }

    pub(crate) fn reconfigure(&mut self, settings: &Settings) {
        self.lost_comms.reconfigure(settings.watch.lost_comms.clone());
        self.battery.reconfigure(settings.watch.battery.clone());
        self.limits.reconfigure(settings.watch.limits.clone());
    }

    /// Somebody aborted: the motors stay still until an operator starts something again.
    pub(crate) fn aborted(&mut self) {
        self.under_way = false;
    }

    /// A console was heard.
    pub(crate) fn contact(&mut self, now: MonoTime) {
        self.heard = true;
        self.lost_comms.handle_input(now, LostCommsInput::Contact);
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
        if let Some(estimate) = desk.estimate {
            self.limits.handle_fix(now, &estimate.fix());
        }
        self.drain(desk);
        self.tell(desk, sensors);
    }

    /// Only what is due by the clock.
    pub(crate) fn tick(&mut self, desk: &mut Desk<'_>) {
        let now = desk.bus.mono();
        if self.lost_comms.poll_timeout().is_some_and(|due| due <= now) {
            let activity = self.activity(desk);
            self.lost_comms.handle_input(now, LostCommsInput::Activity(activity));
            self.lost_comms.handle_timeout(now);
            self.drain(desk);
        }
    }

    fn activity(&mut self, desk: &Desk<'_>) -> Activity {
        let state = desk.plans.plan_state();
        let runs = matches!(state.phase, PlanPhase::Initializing | PlanPhase::Executing);
        if !runs || self.remedy.as_ref().is_some_and(|plan_id| *plan_id != state.plan_id) {
            self.remedy = None;
        }
        let activity = match (runs, &self.remedy, desk.pilot.drive()) {
            (false, ..) => Activity::Idle,
            (true, Some(_), _) => Activity::Remedy,
            (true, None, Drive::Remote(_)) => Activity::Teleoperation,
            (true, None, Drive::Off | Drive::Path) => Activity::Plan,
        };
        self.under_way |= matches!(activity, Activity::Plan | Activity::Teleoperation);
        activity
    }

    fn drain(&mut self, desk: &mut Desk<'_>) {
        while let Some(output) = self.lost_comms.poll_output() {
            match output {
                LostCommsOutput::Regained => {
                    desk.bus.entry(Entity::LostComms, Level::Info, "a console is heard again");
                }
                LostCommsOutput::Act(remedy) => {
                    let text = format!("no console is heard: {remedy}");
                    desk.bus.entry(Entity::LostComms, Level::Warning, text);
                    if !self.act(desk, By::LostComms, &remedy) {
                        self.lost_comms.handle_input(desk.bus.mono(), LostCommsInput::RemedyFailed);
                    }
                }
            }
        }
        while let Some(output) = self.battery.poll_output() {
            match output {
                BatteryOutput::Stage(stage) => {
                    let level = if stage == BatteryStage::Normal { Level::Info } else { Level::Warning };
                    desk.bus.entry(Entity::Fuel, level, format!("battery: {}", stage_text(stage)));
                }
                BatteryOutput::Act(remedy) => {
                    if !self.act(desk, By::Battery, &remedy) {
                        self.battery.remedy_failed();
                    }
                }
            }
        }
        while let Some(output) = self.limits.poll_output() {
            match output {
                LimitsOutput::Kept(violation) => {
                    self.violated = false;
                    desk.bus.entry(Entity::Limits, Level::Info, format!("{violation:?}: kept again"));
                }
                LimitsOutput::Act(violation, remedy) => {
                    self.violated = true;
                    let text = format!("{violation:?}: limit passed: {remedy}");
                    desk.bus.entry(Entity::Limits, Level::Error, text);
                    if !self.act(desk, By::Limits, &remedy) {
                        desk.plans.stop_own(desk.bus, desk.pilot);
                    }
                }
            }
        }
    }

    /// Carries a remedy out; answers whether that was possible.
    fn act(&mut self, desk: &mut Desk<'_>, by: By, remedy: &Remedy) -> bool {
        let by = match by {
            By::LostComms => Entity::LostComms,
            By::Battery => Entity::Fuel,
            By::Limits => Entity::Limits,
        };
        let (plan_id, maneuver) = match remedy {
            Remedy::Stop => {
                desk.plans.stop_own(desk.bus, desk.pilot);
                return true;
            }
            Remedy::Run { .. } | Remedy::Hold if !self.under_way => {
                let text = format!("no operator has set the vessel in motion: '{remedy}' is not carried out");
                desk.bus.entry(by, Level::Warning, text);
                return false;
            }
            Remedy::Run { plan_id } if desk.plans.has(plan_id) => (plan_id.clone(), None),
            Remedy::Run { plan_id } => {
                let text = format!("there is no plan '{plan_id}'; holding instead");
                desk.bus.entry(by, Level::Error, text);
                return false;
            }
            Remedy::Hold => {
                let Some(maneuver) = desk.hold() else {
                    desk.bus.entry(by, Level::Error, "cannot hold a position that is not known; stopping");
                    return false;
                };
                (HOLD_PLAN.to_owned(), Some(maneuver))
            }
        };
        desk.plans.start_own(desk.bus, desk.pilot, &plan_id, maneuver);
        let state = desk.plans.plan_state();
        let runs = matches!(state.phase, PlanPhase::Initializing | PlanPhase::Executing);
        let started = runs && state.plan_id == plan_id;
        if started {
            self.remedy = Some(plan_id);
        }
        started
    }

    /// What each will do next, and when.
    fn tell(&mut self, desk: &mut Desk<'_>, sensors: &Sensors) {
        let next = |bus: &Bus, outlook: Option<Outlook>| outlook.map(|outlook| outlook_text(bus, &outlook));
        let outlook = next(desk.bus, self.lost_comms.outlook());
        let (condition, text) = match (self.lost_comms.is_lost(), self.heard, outlook) {
            (true, _, Some(next)) => (Condition::Fault, format!("no console is heard; next: {next}")),
            (true, _, None) => {
                (Condition::Fault, "no console is heard; nothing further is planned".to_owned())
            }
            (false, false, _) => (Condition::Normal, "no console was ever heard".to_owned()),
            (false, true, Some(next)) => (Condition::Normal, format!("in contact; without: {next}")),
            (false, true, None) => (Condition::Normal, "in contact; without: carry on".to_owned()),
        };
        desk.states.set(desk.bus, Entity::LostComms, condition, text);
        self.tell_battery(desk, sensors);
        let (condition, text) = match (self.violated, next(desk.bus, self.limits.outlook())) {
            (true, _) => (Condition::Error, "a limit is not kept".to_owned()),
            (false, Some(next)) => (Condition::Fault, format!("a limit is passed; next: {next}")),
            (false, None) => match self.limits.depth_m() {
                Some(depth_m) => (Condition::Normal, format!("{depth_m:.0} m inside the area")),
                None => (Condition::Normal, "kept".to_owned()),
            },
        };
        desk.states.set(desk.bus, Entity::Limits, condition, text);
    }

    fn tell_battery(&mut self, desk: &mut Desk<'_>, sensors: &Sensors) {
        let Some(percent) = sensors.charge_percent() else {
            desk.states.set(desk.bus, Entity::Fuel, Condition::Normal, "no battery reports");
            return;
        };
        let (power_w, used_wh) = sensors.power_w();
        let left_wh = desk.capacity_wh * percent / 100.0;
        let hours = (power_w > 1.0).then(|| left_wh / power_w);
        let next = self
            .battery
            .outlook()
            .map_or("nothing further".to_owned(), |outlook| outlook_text(desk.bus, &outlook));
        let text = format!("{percent:.0} %, {power_w:.0} W, {used_wh:.0} Wh used; next: {next}");
        let condition = match self.battery.stage() {
            BatteryStage::Normal => Condition::Normal,
            BatteryStage::Low => Condition::Fault,
            BatteryStage::Reserve | BatteryStage::Critical => Condition::Error,
        };
        desk.states.set(desk.bus, Entity::Fuel, condition, text);
        if desk.bus.mono() >= self.next_fuel {
            self.next_fuel = desk.bus.mono() + FUEL_REPORT;
            let opmodes = hours.map_or_else(String::new, |hours| format!("Present={hours:.1}"));
            let level = FuelLevel { value: percent as f32, confidence: 100.0, opmodes: opmodes.into() };
            desk.bus.send(Entity::Fuel, &level);
        }
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
}

impl Desk<'_> {
    /// Keeping station where the vessel is.
    fn hold(&self) -> Option<Message> {
        let estimate = self.estimate.filter(|estimate| estimate.age < REASON_KEPT)?;
        let station = StationKeeping {
            lat: estimate.place.lat_rad(),
            lon: estimate.place.lon_rad(),
            z_units: ZUnits::Depth,
            radius: self.hold_radius_m as f32,
            speed: self.hold_speed_mps as f32,
            speed_units: SpeedUnits::MetersPs,
            ..StationKeeping::default()
        };
        Some(station.into())
    }
}

fn outlook_text(bus: &Bus, outlook: &Outlook) -> String {
    let Some(at) = outlook.at else { return outlook.remedy.to_string() };
    let left = at.since(bus.mono());
    // Deadlines lie within days.
    let utc = units::UtcTime::from_micros(bus.utc().micros().saturating_add(left.as_micros() as i64)).civil();
    format!("{} at {:02}:{:02}:{:02} UTC", outlook.remedy, utc.hour, utc.minute, utc.second)
}

fn stage_text(stage: BatteryStage) -> &'static str {
    match stage {
        BatteryStage::Normal => "enough",
        BatteryStage::Low => "low",
        BatteryStage::Reserve => "down to the reserve",
        BatteryStage::Critical => "nearly empty",
    }
}
