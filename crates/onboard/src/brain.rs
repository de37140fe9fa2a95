//! The brain: the one state machine that takes all inputs and makes all decisions.
//!
//! [`Brain::handle`] takes an input and its time; [`Brain::poll_output`] gives the outputs until it answers `None`;
//! [`Brain::poll_timeout`] says when to come back with [`Input::Timer`] if nothing else happens before. Nothing here
//! reads a clock, waits, or uses chance: equal inputs give equal outputs.

use crate::authority::COMMAND_LIFE;
use crate::bus::{Asker, Bus};
use crate::clock::Clock;
use crate::conditions::Conditions;
use crate::discovery::{self, Discovery};
use crate::entity::Entity;
use crate::grounding::Chart;
use crate::health::Host;
use crate::hydrophone::Hydrophone;
use crate::input::{DeviceState, Input};
use crate::lease::Lease;
use crate::log::Log;
use crate::navigation::{Arrival, Estimate, Navigation};
use crate::output::{Level, Output};
use crate::parameters::{Live, ParameterService};
use crate::peer::Peer;
use crate::pilot::Pilot;
use crate::plans::{self, Plans};
use crate::power::Power;
use crate::preflight::Preflight;
use crate::reception::{Reception, may_stop};
use crate::sensors::{self, Sensors};
use crate::settings::Settings;
use crate::sight::Sight;
use crate::states::{Condition, States};
use crate::supervise::{Context, Restart, Supervise};
use crate::under_way::{Keeper, UnderWay};
use crate::vitals::{Vitals, powers_off};
use crate::warnings::Warnings;
use devices::Reading;
use imc::messages::{
    Message, PlanControl, PlanControlOp, PlanControlType, VehicleMedium, VehicleMediumMedium,
};
use imc::{Address, Packet};
use mission::{Event, Kept};
use std::time::Duration;
use units::{MonoTime, Now, UtcTime};

/// Slower watching happens once in this time.
const WATCH: Duration = Duration::from_millis(500);
/// Actions of a plan carried out at once.
const MOST_ACTIONS: usize = 100;
const SECOND: Duration = Duration::from_secs(1);

/// The brain of a vessel.
#[derive(Debug)]
pub struct Brain {
    settings: Settings,
    bus: Bus,
    states: States,
    navigation: Navigation,
    pilot: Pilot,
    plans: Plans,
    sensors: Sensors,
    discovery: Discovery,
    reception: Reception,
    supervise: Supervise,
    parameters: ParameterService,
    hydrophone: Hydrophone,
    power: Power,
    preflight: Preflight,
    warnings: Warnings,
    clock: Clock,
    host: Host,
    log: Log,
    conditions: Conditions,
    /// The activity as stored on disk.
    keeper: Keeper,
    estimate: Option<Estimate>,
    sight: Sight,
    step: Duration,
    next_step: MonoTime,
    next_watch: MonoTime,
    next_second: MonoTime,
    shut_down: bool,
    /// Count of position updates: advances while the brain steers.
    steps: u64,
    /// The computer's power is being turned off.
    powering_off: bool,
    afloat: bool,
    /// The time of the satellites at their last position.
    satellite_utc: Option<UtcTime>,
}

impl Brain {
    /// A brain that starts at `now` with the plans that were kept.
    ///
    /// # Errors
    /// When parameters of the controllers are out of range.
    pub fn new(settings: Settings, now: Now, kept: Kept) -> Result<Self, control::InvalidConfig> {
        let mut bus = Bus::new(&settings, now);
        let watch = &settings.watch;
        let states = States::new(watch.monitored.clone(), now.mono);
        let pilot = Pilot::new(&settings)?;
        bus.put(Output::OpenLog { label: String::new(), utc: now.utc });
        bus.console(Level::Info, format!("{} ({}) begins", settings.name, settings.address));
        let found = kept.under_way.as_deref().and_then(UnderWay::read);
        if found.is_none() && kept.under_way.is_some() {
            let text = "what was under way when the program ended cannot be read".to_owned();
            bus.entry(Entity::PlanEngine, Level::Error, text);
        }
        let keeper = Keeper::new(found.as_ref().map(|(_, under_way)| under_way.clone()));
        let plans = Plans::new(&settings, &mut bus, kept);
        let mut brain = Self {
            navigation: Navigation::new(settings.navigation),
            states,
            pilot,
            plans,
            log: Log::default(),
            conditions: Conditions::new(now.mono),
            keeper,
            satellite_utc: None,
            sensors: Sensors::default(),
            discovery: Discovery::new(now.mono),
            reception: Reception::new(now.mono),
            supervise: Supervise::new(&settings, now.mono, Restart::new(found)),
            parameters: ParameterService::new(&settings),
            hydrophone: Hydrophone::new(&settings.hydrophone),
            power: Power::new(&settings.power),
            preflight: Preflight::default(),
            warnings: Warnings::default(),
            clock: Clock::default(),
            host: Host::default(),
            estimate: None,
            sight: Sight::default(),
            step: Duration::from_secs_f64(1.0 / settings.navigation.rate_hz.clamp(2.5, 25.0)),
            next_step: now.mono,
            next_watch: now.mono,
            next_second: now.mono,
            shut_down: false,
            steps: 0,
            powering_off: false,
            afloat: false,
            bus,
            settings,
        };
        for entity in Entity::ALL {
            if !matches!(
                entity,
                Entity::Gps
                    | Entity::Navigation
                    | Entity::MotorPort
                    | Entity::MotorStarboard
                    | Entity::Hydrophone
                    | Entity::Preflight
            ) {
                brain.states.set(&mut brain.bus, entity, Condition::Normal, "active");
            }
        }
        Ok(brain)
    }

    /// Takes an input at `now`.
    pub fn handle(&mut self, now: Now, input: Input) {
        // Time that goes back is a fault of the shell; deadlines hold still until it has caught up.
        let now = Now { mono: now.mono.max(self.bus.mono()), utc: now.utc };
        let gap = now.mono.since(self.bus.mono());
        self.bus.begin(now);
        self.clock.check(&mut self.bus);
        if gap > COMMAND_LIFE {
            self.plans.held_up(&self.bus);
            self.sensors.held_up(gap);
        }
        if !self.shut_down {
            self.take(input);
            self.tick();
        }
        self.pilot.tick(&mut self.bus);
    }

    /// The next output.
    pub fn poll_output(&mut self) -> Option<Output> {
        self.bus.poll()
    }

    /// When to come back at the latest.
    pub fn poll_timeout(&self) -> Option<MonoTime> {
        let pilot = self.pilot.poll_timeout();
        if self.shut_down {
            return Some(pilot);
        }
        [self.next_step, self.next_watch, self.next_second, self.states.poll_timeout()]
            .into_iter()
            .chain([self.discovery.poll_timeout(), self.plans.poll_timeout(), pilot])
            .chain(self.supervise.poll_timeout())
            .min()
    }

    /// The estimate of the vessel's position and motion.
    pub fn estimate(&self) -> Option<&Estimate> {
        self.estimate.as_ref()
    }

    /// The chart in force.
    pub fn chart(&self) -> &Chart {
        &self.settings.grounding.chart
    }

    /// Why a chart that came is not in force yet.
    pub fn chart_waits(&self) -> Option<&str> {
        self.supervise.grounding.waiting_chart.as_ref().map(|(_, why)| &why[..])
    }

    /// Signs of life, and what people near the vessel are shown.
    pub fn vitals(&self) -> Vitals {
        Vitals {
            steps: self.steps,
            mode: self.plans.mode(),
            fuel_low: self.supervise.battery_is_low(),
            powering_off: self.powering_off,
            satellite_time: self.clock.latest(),
        }
    }

    /// Whether the part with this label is in error; an unknown label is not.
    pub fn in_error(&self, label: &str) -> bool {
        let part = self.settings.labels.find(label);
        part.is_some_and(|part| self.states.condition(part) >= Condition::Error)
    }

    fn take(&mut self, input: Input) {
        match input {
            Input::Timer => {}
            Input::Reading(at, reading) => self.read(at.min(self.bus.mono()), reading),
            Input::Device(state) => self.device(state),
            Input::Warning(part, text) => self.warnings.take(&mut self.bus, part, &text),
            Input::Host(reading) => self.host.read(&mut self.bus, &reading),
            Input::Packet(from, bytes) => self.packet(from, 0, bytes),
            Input::Order(from, mandate, bytes) => {
                self.bus.carries_out(mandate.command);
                self.packet(from, mandate.lease, bytes);
                self.bus.carries_out(0);
            }
            Input::Lease(lease) => self.leased(&lease),
            Input::Chart(chart) => {
                let (_, mut live, estimate) = self.live();
                live.chart_came(chart, estimate);
            }
            Input::Route(answer) => {
                self.plans.route_came(&mut self.bus, &mut self.pilot, &answer);
                self.with_supervisors(|supervise, context, _| supervise.route_came(context, &answer));
            }
            Input::Connected(peer) => self.bus.node.connected(peer),
            Input::Disconnected(peer) => self.bus.node.disconnected(peer),
            Input::Reachable(reachable) => self.discovery.reachable(self.bus.mono(), reachable),
            Input::LogOpened(outcome) => {
                let labels = &self.settings.labels;
                self.log.opened(&mut self.bus, &mut self.states, labels, outcome);
            }
            Input::Stored(ticket, outcome) => self.plans.stored(&mut self.bus, ticket, outcome),
            Input::ParametersKept(label, outcome) => {
                self.parameters.kept(&mut self.bus, &self.settings, &label, outcome);
            }
            Input::NotKept(what) => {
                self.bus.entry(Entity::PlanDatabase, Level::Error, format!("not kept on disk: {what}"));
            }
            Input::Shutdown => self.shut_down(),
        }
    }

    /// Takes a reading; its moment is not in the future.
    fn read(&mut self, at: MonoTime, reading: Reading) {
        match reading {
            Reading::Gnss(reading) => {
                self.clock.compare(&self.bus, at, &reading);
                if reading.fix.is_some() {
                    self.satellite_utc = reading.utc.or(self.satellite_utc);
                }
                let arrival = Arrival { at, lag: self.clock.lag(&self.bus, at, &reading) };
                self.sensors.gnss(&mut self.bus, &mut self.navigation, arrival, &reading);
            }
            Reading::Motor(side, reading) => {
                self.pilot.measured(at, side, reading.propeller_rpm);
                self.hydrophone.propeller(at, side, reading.propeller_rpm);
                self.sensors.motor(&mut self.bus, side, &reading);
            }
            Reading::Battery(reading) => self.sensors.battery(&mut self.bus, &reading),
            Reading::Rail(reading) => self.sensors.rail(&mut self.bus, &reading),
            Reading::Trouble(reading) => self.sensors.trouble(&reading),
            Reading::PowerChannel(reading) => self.power.reading(&mut self.bus, &reading),
            Reading::Pulse(reading) => self.clock.pulse(at, reading),
            Reading::Tag(reading) => self.hydrophone.tag(&mut self.bus, &mut self.states, at, reading),
            Reading::Water(reading) => self.hydrophone.water(&mut self.bus, &mut self.states, at, &reading),
            Reading::Receiver(reading) => self.hydrophone.receiver(&mut self.bus, &mut self.states, &reading),
        }
    }

    /// Takes the state of the device behind a part.
    fn device(&mut self, state: DeviceState) {
        self.sensors.device(&mut self.bus, &state);
        match state.entity {
            Entity::Hydrophone => self.hydrophone.device(&mut self.bus, &mut self.states, state),
            // These give no readings: their state is as their drivers report.
            Entity::Watchdog | Entity::Light => {
                self.states.set(&mut self.bus, state.entity, state.condition, state.text);
            }
            _ => {
                let watch = &self.settings.watch;
                self.sensors.watch(&mut self.bus, &mut self.states, &self.navigation, watch);
            }
        }
    }

    /// The shore reports who commands.
    fn leased(&mut self, lease: &Lease) {
        if !self.reception.leased(&mut self.bus, lease) {
            return;
        }
        self.plans.commander_changed(&mut self.bus, &mut self.pilot);
        if self.supervise.commander_changed(self.bus.mono()) {
            let text = "the operator changed: the grounding guard is on again".to_owned();
            self.bus.entry(Entity::Grounding, Level::Warning, text);
        }
    }

    /// A packet as it came, under a lease (0 for none).
    fn packet(&mut self, from: Peer, lease: u64, bytes: Vec<u8>) {
        let Some(packet) = self.reception.receive(&mut self.bus, from, bytes) else { return };
        let Some(message) = packet.message() else { return };
        let header = packet.header;
        if header.src.is_ccu() {
            self.supervise.contact(self.bus.mono());
        }
        let asker = Asker { system: header.src, entity: header.src_ent };
        if !self.reception.obeys(&mut self.bus, asker, header.dst, lease, message) {
            return;
        }
        match message {
            Message::RemoteActions(keys) => {
                if header.dst == self.bus.address() {
                    let text = keys.actions.to_str_lossy();
                    let longest_age = self.settings.longest_key_age;
                    let (bus, pilot) = (&mut self.bus, &mut self.pilot);
                    self.reception.keys(bus, pilot, longest_age, from, &packet, &text);
                }
            }
            Message::PlanControl(request) => self.plan_control(from, &packet, request),
            _ => self.message(asker, header.dst, header.dst_ent, message),
        }
    }

    /// A request of the plan engine, which may be an operator who steps in.
    fn plan_control(&mut self, from: Peer, packet: &Packet, request: &PlanControl) {
        let header = packet.header;
        let to_us = header.dst == self.bus.address();
        let may_stop = may_stop(&self.bus, header.dst);
        let before = self.plans.plan_state().run;
        // An operator's decision settles a failure that no supervisor has handled yet.
        let earlier = self.plans.take_failed();
        if to_us || (may_stop && request.op == PlanControlOp::Stop) {
            let asker = Asker { system: header.src, entity: header.src_ent };
            let name = self.name_of(header.src);
            self.preflight();
            self.plans.control(&mut self.bus, &mut self.pilot, asker, &name, request);
        }
        let run = self.plans.plan_state().run;
        let stops = request.op == PlanControlOp::Stop && request.r#type == PlanControlType::Request;
        let steps_in = run != before || (stops && may_stop);
        if steps_in {
            self.supervise.stepped_in();
        }
        if run.is_some() && run != before {
            self.reception.started(header.src, from);
        }
        if let Some(earlier) = earlier.filter(|_| !steps_in) {
            self.plans.failed_before(earlier);
        }
    }

    /// The name of a system: as announced, else as configured.
    fn name_of(&self, system: Address) -> String {
        let configured = || self.settings.names.get(&system.0).map(String::as_str);
        self.bus.node.name_of(system).or_else(configured).unwrap_or_default().to_owned()
    }

    fn message(&mut self, asker: Asker, to: Address, to_entity: u8, message: &Message) {
        let to_us = to == self.bus.address();
        let may_stop = may_stop(&self.bus, to);
        if !(to_us || to.is_everyone()) {
            return;
        }
        match message {
            Message::PowerOperation(power) => self.powering_off = powers_off(power.op, self.powering_off),
            Message::LoggingControl(request) if to_us => self.log.request(&mut self.bus, asker, request),
            Message::PowerChannelControl(request) if to_us => {
                let name = self.name_of(asker.system);
                let who = if name.is_empty() { asker.system.to_string() } else { name };
                self.power.control(&mut self.bus, asker, &who, request);
            }
            Message::QueryPowerChannelState(_) => self.power.answer(&mut self.bus, asker),
            Message::SetEntityParameters(set) if to_us && self.is_preflight(&set.name) => {
                let name = self.name_of(asker.system);
                self.preflight.set(&mut self.bus, asker, &name, set);
                self.preflight();
            }
            Message::QueryEntityParameters(query) if self.is_preflight(&query.name) => {
                self.preflight.answer(&mut self.bus, asker, &query.name);
            }
            Message::PlanDB(request) if to_us || (may_stop && plans::reads(request.op)) => {
                let name = self.name_of(asker.system);
                self.plans.database(&mut self.bus, asker, &name, request);
            }
            Message::Abort(_) if may_stop => {
                self.supervise.aborted();
                let abort = mission::Input::Abort { by: asker.system.0 };
                self.plans.tell(&mut self.bus, &mut self.pilot, abort);
                self.conditions.hold(self.bus.mono());
            }
            Message::TeleoperationDone(_) if may_stop => {
                let done = Event::TeleoperationDone { from: asker.system.0 };
                self.plans.tell(&mut self.bus, &mut self.pilot, mission::Input::Event(done));
            }
            Message::Reference(reference) if to_us => {
                self.plans.reference(&mut self.bus, &mut self.pilot, asker, reference);
            }
            Message::Announce(announce) => {
                self.plans.sighted(&mut self.bus, &mut self.pilot, asker, announce);
            }
            _ => {
                discovery::answer(&mut self.bus, &self.settings, asker, to_entity, message);
                let (parameters, mut live, _) = self.live();
                parameters.on_message(&mut live, asker, to_us, message);
            }
        }
    }

    /// The parts that a change of parameters or chart reaches.
    fn live(&mut self) -> (&mut ParameterService, Live<'_>, Option<&Estimate>) {
        let live = Live {
            bus: &mut self.bus,
            settings: &mut self.settings,
            pilot: &mut self.pilot,
            navigation: &mut self.navigation,
            supervise: &mut self.supervise,
            plans: &mut self.plans,
        };
        (&mut self.parameters, live, self.estimate.as_ref())
    }

    /// Motors first, then the log.
    fn shut_down(&mut self) {
        self.shut_down = true;
        self.pilot.inhibit(&mut self.bus);
        self.pilot.tick(&mut self.bus);
        self.bus.console(Level::Info, "motors stopped; ending".to_owned());
        self.bus.put(Output::CloseLog);
    }

    fn tick(&mut self) {
        let now = self.bus.mono();
        if now >= self.next_step {
            // Steps missed by more than one are not made up for. A step is far shorter than 64 bits of microseconds.
            let earlier = MonoTime::from_micros(now.micros().saturating_sub(self.step.as_micros() as u64));
            self.next_step = self.next_step.max(earlier) + self.step;
            self.navigate();
        } else if self.estimate.is_none() && self.navigation.estimate(now).is_some() {
            // In the step in which the other parts see the position: a plan that starts at once must be steered at once.
            self.navigate();
        }
        if now >= self.next_watch {
            self.next_watch = now + WATCH;
            self.watch();
        }
        if now >= self.next_second {
            self.next_second = now + SECOND;
            if let Some(estimate) = &self.estimate {
                self.bus.send(Entity::Navigation, &sensors::uncertainty(estimate));
            }
            self.hydrophone.tell(&mut self.bus, self.pilot.motors());
            if let Some(packets) = self.reception.left_out(now) {
                let text = format!("too much comes from others: {packets} of their packets are not logged");
                self.bus.entry(Entity::Logger, Level::Warning, text);
            }
        }
        let (watched, labels) = (&self.settings.watch.monitored, &self.settings.labels);
        if let Some(conditions) = self.conditions.due(now, watched, &self.states, labels) {
            self.plans.tell(&mut self.bus, &mut self.pilot, mission::Input::Entities(conditions));
        }
        self.plans.tick(&mut self.bus, &mut self.pilot);
        self.with_supervisors(|supervise, context, _| supervise.tick(context));
        self.act_for_plan();
        self.plans.follow_up(&mut self.bus, &mut self.pilot);
        self.keep_under_way();
        let place = self.estimate.map(|estimate| (estimate.place, estimate.height_m));
        self.discovery.tick(&mut self.bus, &self.settings, place);
        self.states.tick(&mut self.bus, &self.settings.labels);
    }

    /// The present activity is written to disk before the motors are commanded for it.
    fn keep_under_way(&mut self) {
        if self.supervise.restart.is_open() && self.plans.plan_state().run.is_none() {
            return;
        }
        let holds = self.settings.mission.holds_after_failure;
        let under_way = self.supervise.under_way(&self.plans, &self.pilot, holds);
        let timestamp_s = self.clock.satellite_seconds(&self.bus);
        self.keeper.keep(&mut self.bus, under_way, timestamp_s);
    }

    fn navigate(&mut self) {
        self.steps += 1;
        self.estimate = self.navigation.estimate(self.bus.mono());
        if let Some(estimate) = &self.estimate {
            self.bus.send(Entity::Navigation, &sensors::estimated_state(estimate));
            self.hydrophone.at(self.bus.mono(), estimate);
        }
        if let Some(estimate) = &self.estimate {
            let fix = estimate.fix();
            self.pilot.see(estimate);
            if !self.afloat {
                // A vessel that knows its position and has no other sensor for it is assumed to be in the water.
                self.afloat = true;
                let medium = VehicleMedium { medium: VehicleMediumMedium::Water };
                self.bus.send(Entity::Supervisor, &medium);
                let water = mission::Input::Event(Event::Medium(mission::Medium::Water));
                self.plans.tell(&mut self.bus, &mut self.pilot, water);
            }
            self.plans.tell(&mut self.bus, &mut self.pilot, mission::Input::Event(Event::Fix(fix)));
        }
        if self.afloat {
            let recovery = Duration::from_secs_f64(self.settings.navigation.recovery_s);
            let known = self.sight.see(self.bus.mono(), self.estimate.as_ref(), recovery);
            self.pilot.wait(!known);
            self.plans.tell(&mut self.bus, &mut self.pilot, mission::Input::Position { known });
        }
        self.with_supervisors(|supervise, context, _| supervise.see(context));
        self.pilot.steer(&mut self.bus, self.estimate.as_ref());
        self.plans.follow_up(&mut self.bus, &mut self.pilot);
    }

    /// Carries out the messages that a plan contains.
    fn act_for_plan(&mut self) {
        for _ in 0..MOST_ACTIONS {
            let Some(message) = self.plans.poll_action() else { break };
            let own = Asker { system: self.bus.address(), entity: Entity::PlanEngine.number() };
            match message {
                Message::SetEntityParameters(_)
                | Message::PushEntityParameters(_)
                | Message::PopEntityParameters(_) => {
                    let (parameters, mut live, _) = self.live();
                    parameters.on_message(&mut live, own, true, &message);
                }
                // Plans with other actions are refused; anything else could turn a plan on itself.
                other => {
                    let text = format!("an action of the plan is left out: {}", other.abbrev());
                    self.bus.entry(Entity::PlanEngine, Level::Warning, text);
                }
            }
        }
    }

    fn watch(&mut self) {
        let watch = &self.settings.watch;
        self.sensors.watch(&mut self.bus, &mut self.states, &self.navigation, watch);
        self.clock.watch(&mut self.bus, &mut self.states, watch);
        self.host.watch(&mut self.bus, &mut self.states, watch);
        self.pilot.report(&mut self.bus, &mut self.states, self.settings.remote.connection_timeout_s);
        self.power.watch(&mut self.bus);
        self.preflight();
        let (contacts, clients) = self.bus.node.counts(self.bus.mono());
        let parts =
            [(Entity::Udp, format!("{contacts} in contact")), (Entity::Tcp, format!("{clients} connected"))];
        for (entity, text) in parts {
            self.states.set(&mut self.bus, entity, Condition::Normal, text);
        }
        let (_, mut live, estimate) = self.live();
        live.retry_waiting_chart(estimate);
        self.with_supervisors(Supervise::watch);
    }

    /// Whether a message about parameters means the preflight.
    fn is_preflight(&self, label: &imc::Text) -> bool {
        label.to_str_lossy() == self.settings.labels.of(Entity::Preflight)
    }

    /// Checks what is missing before motors may be armed.
    fn preflight(&mut self) {
        let watch = &self.settings.watch;
        let mut missing = self.sensors.missing(self.bus.mono(), watch);
        missing.extend(self.clock.doubt(self.bus.mono(), watch));
        // A first epoch has a position and a heading, but no path is followed before navigation has an estimate.
        if missing.is_empty() && self.estimate.is_none() {
            missing.push("position (navigation has made no estimate of it yet)".to_owned());
        }
        let grounding = &self.settings.grounding;
        if let Chart::Unreadable { reason } = &grounding.chart
            && grounding.refuses_without
        {
            missing.push(format!("chart (cannot be read: {reason})"));
        }
        self.preflight.look(&mut self.bus, &mut self.states, missing);
        self.plans.unready = self.preflight.refusal(self.settings.labels.of(Entity::Preflight));
    }

    fn with_supervisors(&mut self, act: impl FnOnce(&mut Supervise, &mut Context<'_>, &Sensors)) {
        let mission = &self.settings.mission;
        let mut context = Context {
            bus: &mut self.bus,
            states: &mut self.states,
            plans: &mut self.plans,
            pilot: &mut self.pilot,
            estimate: self.estimate.as_ref(),
            hold_radius_m: mission.hold_radius_m,
            hold_speed_mps: mission.hold_speed_mps,
            capacity_wh: mission.capacity_wh,
            charge_percent: self.sensors.charge_percent(),
            grounding: &self.settings.grounding,
            holds_after_failure: mission.holds_after_failure,
            restart: &mission.restart,
            satellite_utc: self.satellite_utc,
            area: self.settings.watch.limits.area.as_ref(),
            guard: self.settings.guard_limits(),
        };
        act(&mut self.supervise, &mut context, &self.sensors);
    }
}
