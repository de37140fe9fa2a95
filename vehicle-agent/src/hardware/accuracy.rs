//! Compares a plan sailed through the devices' protocols with the same plan on the ideal simulator, which passes values
//! directly: both with a virtual clock, the same weather and the same compass errors.

use crate::hull::{Hull, Simulated};
use crate::plan::{goto, sequence};
use crate::setup;
use crate::vehicle::{BrainEvent, Vehicle};
use config::{Config, InMemory};
use control::MotorPair;
use devices::{Pair, Reading};
use drivers::gnss::{Compass, CompassSettings};
use drivers::motors::{Motors, MotorsConfig, MotorsOutput};
use drivers::{Driver as _, Input as ToDriver, Output as OfDriver};
use imc::messages::{
    PlanControl, PlanControlOp, PlanControlState, PlanControlStateLastOutcome, PlanControlStateState,
    PlanControlType, PlanSpecification, VehicleState, VehicleStateOpMode,
};
use imc::{Address, Header, Packet, PacketView};
use onboard::{Brain, Input, Output, Peer};
use sim::{AtFirst, OutputForm, Port, Vessel};
use std::collections::VecDeque;
use std::time::Duration;
use units::{LocalPoint, MonoTime, Now, UtcTime};

/// The corners of the plan (m); it begins and ends at the first.
const CORNERS: [(f64, f64); 5] = [(0.0, 0.0), (150.0, 0.0), (150.0, 150.0), (0.0, 150.0), (0.0, 0.0)];
const START: UtcTime = UtcTime::from_micros(1_790_000_000_000_000);

/// A simulated hull behind the drivers of its compass and of its motors' card: bytes one way, frames the other.
struct Driven {
    vessel: Vessel,
    compass: Compass,
    motors: Motors,
    readings: VecDeque<(MonoTime, Reading)>,
}

impl Driven {
    fn new(vessel: Vessel) -> Self {
        let compass = Compass::new(CompassSettings::default());
        let motors = Motors::new(MotorsConfig::default()).unwrap();
        let mut hull = Self { vessel, compass, motors, readings: VecDeque::new() };
        let now = hull.now();
        hull.compass.handle(now, ToDriver::Opened);
        hull.motors.opened(now);
        hull.take();
        hull
    }

    fn now(&self) -> Now {
        let mono = self.vessel.now();
        // A simulation of days fits 63 bits of microseconds.
        Now { mono, utc: UtcTime::from_micros(START.micros() + mono.micros() as i64) }
    }

    /// Passes the drivers' outputs to the devices, and stores their readings.
    fn take(&mut self) {
        while let Some(output) = self.compass.poll_output() {
            match output {
                OfDriver::Reading { at, reading } => self.readings.push_back((at.mono, reading)),
                OfDriver::Send { bytes, .. } => self.vessel.receive_serial(Port::Gnss, &bytes),
                OfDriver::Newest { .. } | OfDriver::Speed { .. } | OfDriver::State(_) | OfDriver::Note(_) => {
                }
            }
        }
        while let Some(output) = self.motors.poll_output() {
            match output {
                MotorsOutput::Throttle { frame, .. } | MotorsOutput::Frame(frame) => {
                    self.vessel.receive_can(&frame).unwrap();
                }
                MotorsOutput::Reading { at, reading } => self.readings.push_back((at.mono, reading)),
                MotorsOutput::State(_) | MotorsOutput::Note(_) => {}
            }
        }
    }

    fn next(&self) -> MonoTime {
        let drivers = [self.compass.poll_timeout(), self.motors.poll_timeout()];
        drivers.into_iter().flatten().fold(self.vessel.poll_timeout(), MonoTime::min)
    }

    fn advance(&mut self, until: MonoTime) {
        while self.vessel.now() < until {
            let next = self.next().max(self.vessel.now() + Duration::from_micros(1)).min(until);
            self.vessel.step(next.since(self.vessel.now()));
            let now = self.now();
            while let Some(timed) = self.vessel.poll_output() {
                match timed.output {
                    sim::Output::Serial(Port::Gnss, bytes) => {
                        self.compass.handle(now, ToDriver::Bytes(&bytes));
                    }
                    sim::Output::Can(frame) => self.motors.handle(now, &frame),
                    sim::Output::Serial(Port::Hydrophone, _) | sim::Output::Reading(_) => {}
                }
            }
            if self.compass.poll_timeout().is_some_and(|due| due <= now.mono) {
                self.compass.handle(now, ToDriver::Time);
            }
            self.motors.tick(now);
            self.take();
        }
    }
}

impl Hull for Driven {
    fn poll(&mut self, until: MonoTime) -> Option<Input> {
        self.advance(until);
        self.readings.pop_front().map(|(at, reading)| Input::Reading(at, reading))
    }

    fn poll_timeout(&self) -> Option<MonoTime> {
        Some(self.readings.front().map_or_else(|| self.next(), |(at, _)| *at))
    }

    fn command(&mut self, motors: MotorPair) {
        let now = self.now();
        self.motors.command(now, Pair::new(motors.port, motors.starboard));
        self.take();
    }

    fn end(&mut self, _clean: bool) -> bool {
        true
    }
}

/// True distances of the vessel from the lines of its plan (m).
#[derive(Debug, Clone, Copy, Default)]
struct Errors {
    squares: f64,
    count: f64,
    worst_m: f64,
}

impl Errors {
    fn add(&mut self, error_m: f64) {
        self.squares += error_m * error_m;
        self.count += 1.0;
        self.worst_m = self.worst_m.max(error_m);
    }

    fn rms_m(&self) -> f64 {
        (self.squares / self.count).sqrt()
    }
}

/// Distance from the nearest line of the plan (m).
fn off_m(at: LocalPoint) -> f64 {
    let of_leg = |a: (f64, f64), b: (f64, f64)| {
        let (along_n, along_e) = (b.0 - a.0, b.1 - a.1);
        let (from_n, from_e) = (at.north_m - a.0, at.east_m - a.1);
        let part =
            ((from_n * along_n + from_e * along_e) / (along_n * along_n + along_e * along_e)).clamp(0.0, 1.0);
        (from_n - part * along_n).hypot(from_e - part * along_e)
    };
    CORNERS.windows(2).map(|two| of_leg(two[0], two[1])).fold(f64::MAX, f64::min)
}

fn plan(vessel: &Vessel) -> PlanSpecification {
    let place = |(north_m, east_m)| vessel.frame().to_place(LocalPoint { north_m, east_m });
    sequence("square", CORNERS[1..].iter().map(|corner| goto(place(*corner), 1.5).into()).collect())
}

/// Sails the plan; returns the true errors at each second.
fn sail<H: Hull>(hull: H, config: &Config, plan: &PlanSpecification, of: impl Fn(&H) -> &Vessel) -> Errors {
    let (settings, _) = setup::settings(config, 1).unwrap();
    let own = settings.address;
    let now = Now { mono: MonoTime::default(), utc: START };
    let brain = Brain::new(settings, now, mission::Kept::default()).unwrap();
    let mut vehicle = Vehicle::new(hull, brain, now);
    let (mut state, mut ready, mut started) = (PlanControlState::default(), false, false);
    let mut errors = Errors::default();
    vehicle.tell(Input::Connected(Peer::Tcp(1)), &mut |_, _| {});
    for second in 1..3600 {
        let until = MonoTime::from_micros(second * 1_000_000);
        while vehicle.now.mono < until {
            vehicle.advance(until, &mut |_, event| {
                let BrainEvent::Output(Output::Packet { bytes, .. }) = event else { return };
                let view = PacketView::new(&bytes).unwrap();
                if view.src() != own {
                } else if let Some(found) = imc::decode::<PlanControlState>(&view).unwrap() {
                    state = found;
                } else if let Some(found) = imc::decode::<VehicleState>(&view).unwrap() {
                    ready = found.op_mode == VehicleStateOpMode::Service;
                }
            });
        }
        let mut send = |message: imc::Message| {
            let header = Header {
                timestamp: vehicle.now.utc.seconds(),
                src: Address(0x4001),
                dst: own,
                ..Header::default()
            };
            let packet = Packet::new(header, message).encode().unwrap();
            vehicle.tell(Input::Packet(Peer::Tcp(1), packet), &mut |_, _| {});
        };
        send(imc::messages::Heartbeat.into());
        if ready && !started {
            started = true;
            let request = PlanControl {
                r#type: PlanControlType::Request,
                op: PlanControlOp::Start,
                request_id: 1,
                plan_id: plan.plan_id.clone(),
                arg: plan.clone().into(),
                ..PlanControl::default()
            };
            send(request.into());
        } else if started && state.state == PlanControlStateState::Executing {
            errors.add(off_m(of(&vehicle.hull).truth().state.position));
        } else if started && state.last_outcome == PlanControlStateLastOutcome::Success {
            return errors;
        }
    }
    panic!("the plan is not done after an hour: {state:?}");
}

#[test]
fn a_plan_by_the_devices_protocols_is_sailed_as_well_as_by_the_ideal_simulator_but_for_a_tenth() {
    let files = InMemory::new().with("otter.ini", crate::OTTER_INI);
    let config = Config::load(&files, "otter.ini".as_ref(), &["Simulation"]);
    let (mut ideal, mut driven) = (Errors::default(), Errors::default());
    let add = |all: &mut Errors, one: Errors| {
        (all.squares, all.count, all.worst_m) =
            (all.squares + one.squares, all.count + one.count, all.worst_m.max(one.worst_m));
    };
    for seed in 1..=3 {
        let vessel = |form| {
            let mut vessel = setup::vessel(&config, START, seed).unwrap();
            vessel.form = form;
            vessel.gnss.at_first = AtFirst::Nothing;
            vessel.environment.current.speed_mps = 0.2;
            vessel.environment.wind.speed_mps = 4.0;
            Vessel::new(&vessel).unwrap()
        };
        let (values, bytes) = (vessel(OutputForm::Values), vessel(OutputForm::Bytes));
        let plan = plan(&values);
        add(&mut ideal, sail(Simulated::new(values), &config, &plan, |hull| &hull.vessel));
        add(&mut driven, sail(Driven::new(bytes), &config, &plan, |hull| &hull.vessel));
    }
    let (of_ideal_m, of_driven_m) = (ideal.rms_m(), driven.rms_m());
    println!(
        "off the track, RMS and largest: ideal {of_ideal_m:.3} m, {:.2} m; by the devices {of_driven_m:.3} m, {:.2} m",
        ideal.worst_m, driven.worst_m
    );
    assert!(ideal.count > 900.0, "{ideal:?}");
    assert!(of_driven_m <= 1.1 * of_ideal_m, "{of_driven_m} m against {of_ideal_m} m");
}
