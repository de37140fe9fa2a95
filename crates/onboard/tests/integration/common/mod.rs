//! A console beside a simulated vessel, under a virtual clock.

#[allow(dead_code, reason = "the program uses all of it")]
#[path = "../../../../../vehicle-agent/src/hull/mod.rs"]
pub(crate) mod hull;
#[allow(dead_code, reason = "the program uses all of it")]
#[path = "../../../../../vehicle-agent/src/vehicle.rs"]
pub(crate) mod vehicle;

use hull::Simulated;
use imc::messages::*;
use imc::{Address, Header, Packet, Payload};
use mission::{Effect, Kept};
use onboard::{Brain, Input, Keep, Output, Peer, Settings};
use sim::{GnssConfig, OutputForm, Vessel, VesselConfig};
use std::time::Duration;
use units::{LatLon, LocalFrame, LocalPoint, MonoTime, Now, UtcTime};
use vehicle::{BrainEvent, Vehicle};

pub(crate) const OTTER: Address = Address(0x2810);
pub(crate) const CONSOLE: Address = Address(0x4001);
pub(crate) const PEER: Peer = Peer::Tcp(1);

pub(crate) fn start() -> UtcTime {
    UtcTime::from_seconds(1_790_000_000.0).unwrap()
}

pub(crate) fn frame() -> LocalFrame {
    LocalFrame::new(LatLon::from_deg(63.33, 10.0833).unwrap())
}

/// Vessel, console, and all messages sent.
pub(crate) struct Sea {
    pub(crate) vehicle: Vehicle<Simulated>,
    pub(crate) said: Vec<(Now, Packet)>,
    pub(crate) outputs: Vec<(Now, Output)>,
    pub(crate) motors: Vec<(Now, control::MotorPair)>,
    /// The contents of the disk.
    pub(crate) disk: Kept,
    /// Whether the console sends heartbeats.
    pub(crate) heartbeats: bool,
    next_heartbeat: MonoTime,
    request: u16,
}

pub(crate) fn settings() -> Settings {
    Settings::otter("ntnu-otter-01", OTTER)
}

impl Sea {
    pub(crate) fn new() -> Self {
        Self::with(settings(), |_| {})
    }

    pub(crate) fn with(settings: Settings, change: impl FnOnce(&mut VesselConfig)) -> Self {
        let mut config = VesselConfig::at(frame().origin(), start(), 7);
        config.form = OutputForm::Values;
        config.gnss = GnssConfig { rate_hz: 5, ..GnssConfig::default() }.perfect();
        config.gnss.baud = 115_200;
        change(&mut config);
        let vessel = Vessel::new(&config).unwrap();
        let now = Now { mono: vessel.now(), utc: vessel.utc() };
        let brain = Brain::new(settings, now, mission::Kept::default()).unwrap();
        let mut sea = Self {
            vehicle: Vehicle::new(Simulated::new(vessel), brain, now),
            said: Vec::new(),
            outputs: Vec::new(),
            motors: Vec::new(),
            disk: Kept::default(),
            heartbeats: true,
            next_heartbeat: MonoTime::default(),
            request: 0,
        };
        sea.tell(Input::Connected(PEER));
        sea
    }

    pub(crate) fn tell(&mut self, input: Input) {
        let mut notes = Notes::of(&mut self.said, &mut self.outputs, &mut self.motors, &mut self.disk);
        self.vehicle.tell(input, &mut |now, event| notes.take(now, event));
    }

    /// Gives it a reading of this moment.
    pub(crate) fn read(&mut self, reading: devices::Reading) {
        let at = self.vehicle.now.mono;
        self.tell(Input::Reading(at, reading));
    }

    /// The program is killed; so much later another begins with what the disk holds. The motors stop meanwhile.
    pub(crate) fn kill(&mut self, settings: Settings, away_s: f64) {
        self.vehicle.hull.vessel.command(0.0, 0.0).unwrap();
        self.hang(away_s);
        while self.vehicle.hull.vessel.poll_output().is_some() {}
        let now = self.vehicle.now;
        self.vehicle.brain = Brain::new(settings, now, self.disk.clone()).unwrap();
        self.forget();
        self.tell(Input::Connected(PEER));
    }

    /// Time passes for the hull while the program neither polls nor steers.
    pub(crate) fn hang(&mut self, seconds: f64) {
        let span = Duration::from_secs_f64(seconds);
        self.vehicle.hull.vessel.step(span);
        let Now { mono, utc } = self.vehicle.now;
        let utc = UtcTime::from_micros(utc.micros() + span.as_micros() as i64);
        self.vehicle.now = Now { mono: mono + span, utc };
    }

    /// Sets the computer's clock so much ahead of the true time (µs).
    pub(crate) fn set_clock_ahead(&mut self, ahead_us: i64) {
        self.vehicle.now.utc = UtcTime::from_micros(self.vehicle.hull.vessel.utc().micros() + ahead_us);
    }

    /// Sends a message as the console.
    pub(crate) fn send(&mut self, message: impl Into<Message>) {
        self.send_as(CONSOLE, OTTER, message);
    }

    pub(crate) fn send_as(&mut self, src: Address, dst: Address, message: impl Into<Message>) {
        let header = Header { timestamp: self.vehicle.now.utc.seconds(), src, dst, ..Header::default() };
        let bytes = Packet::new(header, message).encode().unwrap();
        self.tell(Input::Packet(PEER, bytes));
    }

    /// Lets `seconds` pass.
    pub(crate) fn run(&mut self, seconds: f64) {
        let until = self.vehicle.now.mono + Duration::from_secs_f64(seconds);
        while self.vehicle.now.mono < until {
            self.advance(until);
        }
    }

    /// Lets time pass until a condition holds; answers whether it did within `seconds`.
    pub(crate) fn run_until(&mut self, seconds: f64, mut done: impl FnMut(&Self) -> bool) -> bool {
        let until = self.vehicle.now.mono + Duration::from_secs_f64(seconds);
        while self.vehicle.now.mono < until {
            if done(self) {
                return true;
            }
            self.advance(until);
        }
        done(self)
    }

    fn advance(&mut self, until: MonoTime) {
        if self.heartbeats && self.vehicle.now.mono >= self.next_heartbeat {
            self.next_heartbeat = self.vehicle.now.mono + Duration::from_secs(1);
            self.send(Heartbeat);
        }
        let mut notes = Notes::of(&mut self.said, &mut self.outputs, &mut self.motors, &mut self.disk);
        self.vehicle.advance(until, &mut |now, event| notes.take(now, event));
    }

    /// All messages of a type that the vessel sent.
    pub(crate) fn all<T: Payload + Clone>(&self) -> Vec<(Now, T)> {
        let own = self.said.iter().filter(|(_, packet)| packet.header.src == OTTER);
        own.filter_map(|(now, packet)| packet.get::<T>().map(|message| (*now, message.clone()))).collect()
    }

    pub(crate) fn last<T: Payload + Clone>(&self) -> Option<T> {
        let mut own = self.said.iter().rev().filter(|(_, packet)| packet.header.src == OTTER);
        own.find_map(|(_, packet)| packet.get::<T>().cloned())
    }

    pub(crate) fn plan_state(&self) -> PlanControlState {
        self.last().unwrap_or_default()
    }

    pub(crate) fn mode(&self) -> VehicleStateOpMode {
        self.last::<VehicleState>().unwrap_or_default().op_mode
    }

    /// Forgets the messages so far.
    pub(crate) fn forget(&mut self) {
        self.said.clear();
        self.outputs.clear();
        self.motors.clear();
    }

    /// A person says why the motors are to be armed all the same.
    pub(crate) fn override_preflight(&mut self, reason: &str) {
        let value = EntityParameter { name: "Override".into(), value: reason.into() };
        let params = [value].into_iter().collect();
        self.send(SetEntityParameters { name: "Preflight".into(), params });
    }

    /// A boat that is ready.
    pub(crate) fn ready(mut self) -> Self {
        assert!(self.run_until(20.0, |sea| sea.mode() == VehicleStateOpMode::Service), "{:?}", self.mode());
        self
    }

    /// Asks the plan engine; answers the request's number.
    pub(crate) fn ask(&mut self, op: PlanControlOp, plan_id: &str, arg: Option<Message>) -> u16 {
        self.request += 1;
        let request = PlanControl {
            r#type: PlanControlType::Request,
            op,
            request_id: self.request,
            plan_id: plan_id.into(),
            arg: arg.into(),
            ..PlanControl::default()
        };
        self.send(request);
        self.request
    }

    /// Replies of the plan engine to a request.
    pub(crate) fn replies(&self, request: u16) -> Vec<PlanControl> {
        self.all::<PlanControl>()
            .into_iter()
            .map(|(_, reply)| reply)
            .filter(|reply| reply.request_id == request && reply.r#type != PlanControlType::Request)
            .collect()
    }

    /// Puts a plan into the database.
    pub(crate) fn upload(&mut self, plan: &PlanSpecification) {
        self.request += 1;
        let request = PlanDB {
            r#type: PlanDBType::Request,
            op: PlanDBOp::Set,
            request_id: self.request,
            plan_id: plan.plan_id.clone(),
            arg: plan.clone().into(),
            ..PlanDB::default()
        };
        self.send(request);
    }

    pub(crate) fn position(&self) -> LocalPoint {
        self.vehicle.hull.vessel.truth().state.position
    }
}

/// The outputs of the brain are noted here.
struct Notes<'a> {
    said: &'a mut Vec<(Now, Packet)>,
    outputs: &'a mut Vec<(Now, Output)>,
    motors: &'a mut Vec<(Now, control::MotorPair)>,
    disk: &'a mut Kept,
}

impl<'a> Notes<'a> {
    fn of(
        said: &'a mut Vec<(Now, Packet)>,
        outputs: &'a mut Vec<(Now, Output)>,
        motors: &'a mut Vec<(Now, control::MotorPair)>,
        disk: &'a mut Kept,
    ) -> Self {
        Self { said, outputs, motors, disk }
    }

    fn take(&mut self, now: Now, event: BrainEvent<'_>) {
        let BrainEvent::Output(output) = event else { return };
        match &output {
            Output::Packet { bytes, .. } => self.said.push((now, Packet::decode(bytes).unwrap())),
            Output::Motors(pair) => self.motors.push((now, *pair)),
            Output::Keep(Keep::UnderWay(packet)) => self.disk.under_way.clone_from(packet),
            Output::Keep(Keep::Plans(Effect::Store { record, .. })) => {
                self.disk.plans.retain(|kept| kept.plan_id != record.plan_id);
                self.disk.plans.push(record.clone());
            }
            _ => {}
        }
        self.outputs.push((now, output));
    }
}

/// A place north and east of the start.
pub(crate) fn place(north_m: f64, east_m: f64) -> LatLon {
    frame().to_place(LocalPoint { north_m, east_m })
}

pub(crate) fn goto(north_m: f64, east_m: f64, speed: f32) -> Goto {
    let target = place(north_m, east_m);
    Goto { lat: target.lat_rad(), lon: target.lon_rad(), z_units: ZUnits::Depth, speed, ..Goto::default() }
}

/// A plan of maneuvers one after the other.
pub(crate) fn plan(id: &str, maneuvers: Vec<(String, Message)>) -> PlanSpecification {
    let ids: Vec<String> = maneuvers.iter().map(|(id, _)| id.clone()).collect();
    PlanSpecification {
        plan_id: id.into(),
        start_man_id: ids.first().map_or("", String::as_str).into(),
        maneuvers: maneuvers
            .into_iter()
            .map(|(id, data)| PlanManeuver {
                maneuver_id: id.into(),
                data: data.into(),
                ..PlanManeuver::default()
            })
            .collect(),
        transitions: ids
            .windows(2)
            .map(|pair| PlanTransition {
                source_man: pair[0].as_str().into(),
                dest_man: pair[1].as_str().into(),
                conditions: "ManeuverIsDone".into(),
                ..PlanTransition::default()
            })
            .collect(),
        ..PlanSpecification::default()
    }
}

/// Three waypoints around the start.
pub(crate) fn triangle() -> PlanSpecification {
    let points = [(0.0, 60.0), (50.0, 60.0), (50.0, 0.0)];
    let goto = |(n, (north_m, east_m)): (usize, (f64, f64))| {
        (format!("wp{}", n + 1), Message::from(goto(north_m, east_m, 1.5)))
    };
    plan("triangle", points.into_iter().enumerate().map(goto).collect())
}
