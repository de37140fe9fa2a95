//! From a path or an operator's keys to thruster commands: the control loops and who runs them.
//!
//! One of three drives is on at a time: none (the vessel drifts), a path, or manual control. Changing the
//! drive says so on the bus as DUNE does: all loops off, then the new ones on, with a scope reference that
//! only grows. The loops run at the rate of the estimates; without an estimate, or when a controller cannot
//! make sense of one, nothing is sent and the authority's half second stops the motors.

mod report;

use crate::authority::{Authority, Owner};
use crate::bus::Bus;
use crate::entity::Entity;
pub(crate) use crate::gate::Gate;
use crate::navigation::Estimate;
use crate::output::{Level, Output};
use crate::path_wire::{desired_path, desired_speed, path_state};
use crate::settings::Settings;
use crate::stray::Stray;
use control::{
    CourseSpeed, Fix, Guidance, MotorPair, PathCommand, PathError, PathFault, PathStatus, PathTracker,
    Remote, RemoteActions, RemoteCommand, RemoteReply, Setpoint, YawTarget,
};
use devices::{Pair, Side};
use imc::messages::{
    CLoopsMask, ControlLoops, ControlLoopsEnable, DesiredHeading, DesiredZ, SetThrusterActuation, ZUnits,
};
use mission::{Drive, Operator};
use std::collections::VecDeque;
use std::time::Duration;
use units::{MonoTime, Speed};

const PATH_LOOPS: CLoopsMask =
    CLoopsMask::PATH.union(CLoopsMask::DEPTH).union(CLoopsMask::YAW).union(CLoopsMask::SPEED);
/// Enabled beside TELEOPERATION while an operator gives heading and speed rather than thrust.
const AUTOPILOT_LOOPS: CLoopsMask = CLoopsMask::YAW.union(CLoopsMask::SPEED);

/// An event of steering.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum PilotEvent {
    /// How the path goes, after every estimate.
    Path(PathStatus),
    /// The path cannot be followed, or no longer.
    Failed { path_ref: u32, reason: String },
    /// The operator pressed Exit.
    Exit { from: u16 },
}

/// Steers.
#[derive(Debug)]
pub(crate) struct Pilot {
    pub(crate) authority: Authority,
    tracker: PathTracker,
    guidance: Guidance,
    control: CourseSpeed,
    remote: Remote,
    path_report: Duration,
    drive: Drive,
    mask: CLoopsMask,
    scope_ref: u32,
    speed: Option<Speed>,
    following: Option<Following>,
    /// The setpoint of a remote autopilot.
    held: Option<Setpoint>,
    rpm: Pair<Option<(MonoTime, f64)>>,
    estimate: Option<Estimate>,
    events: VecDeque<PilotEvent>,
    fault: Option<PathFault>,
    gate: Gate,
    most_mps: Option<f64>,
    /// Greatest speed while the position is only reckoned (m/s).
    reckoning_mps: f64,
    /// The vessel does not know where it is: the path waits.
    waits: bool,
    stray: Stray,
}

#[derive(Debug, Clone, Copy)]
struct Following {
    path_ref: u32,
    reported: Option<MonoTime>,
    heading_sent: Option<f64>,
    failed: bool,
}

impl Pilot {
    /// A pilot at rest. Parameters out of range fall back to the usual ones; the settings were validated.
    pub(crate) fn new(settings: &Settings) -> Result<Self, control::InvalidConfig> {
        Ok(Self {
            authority: Authority::default(),
            tracker: PathTracker::new(settings.path)?,
            guidance: Guidance::new(settings.guidance)?,
            control: CourseSpeed::new(settings.control)?,
            remote: Remote::new(settings.remote)?,
            path_report: settings.path_report,
            drive: Drive::Off,
            mask: CLoopsMask::empty(),
            scope_ref: 0,
            speed: None,
            following: None,
            held: None,
            rpm: Pair::default(),
            estimate: None,
            events: VecDeque::new(),
            fault: None,
            gate: Gate::default(),
            most_mps: None,
            reckoning_mps: settings.navigation.reckoning_mps,
            waits: false,
            stray: Stray::new(settings),
        })
    }

    /// Other parameters, from here on.
    pub(crate) fn reconfigure(&mut self, settings: &Settings) -> Result<(), control::InvalidConfig> {
        self.path_report = settings.path_report;
        self.reckoning_mps = settings.navigation.reckoning_mps;
        self.stray.reconfigure(settings);
        self.tracker.reconfigure(settings.path)?;
        self.guidance.reconfigure(settings.guidance)?;
        self.control.reconfigure(settings.control)?;
        self.remote.reconfigure(settings.remote)
    }

    pub(crate) fn loops(&self) -> CLoopsMask {
        self.mask
    }

    pub(crate) fn drive(&self) -> Drive {
        self.drive
    }

    /// Sets the limits of manual control, and the greatest speed of a path.
    pub(crate) fn guard(&mut self, gate: Gate, most_mps: Option<f64>) {
        (self.gate, self.most_mps) = (gate, most_mps);
    }

    /// Where the vessel is, if it knows.
    pub(crate) fn place(&self) -> Option<units::LatLon> {
        self.estimate.map(|estimate| estimate.place)
    }

    /// The motors' commands.
    pub(crate) fn motors(&self) -> MotorPair {
        self.authority.motors()
    }

    /// The fault of the path under way.
    pub(crate) fn fault(&self) -> Option<PathFault> {
        self.fault
    }

    /// How long the vessel may still steer back to a track that it was too far from.
    pub(crate) fn strays_until(&self) -> Option<MonoTime> {
        self.stray.until()
    }

    /// Lets the path wait, motors stopped, or continue.
    pub(crate) fn wait(&mut self, waits: bool) {
        if self.waits && !waits {
            self.tracker.watch_anew();
        }
        self.waits = waits;
    }

    /// Whether an operator's messages come.
    pub(crate) fn is_connected(&self) -> bool {
        self.remote.is_connected()
    }

    pub(crate) fn poll_event(&mut self) -> Option<PilotEvent> {
        self.events.pop_front()
    }

    /// A motor's measured speed.
    pub(crate) fn measured(&mut self, now: MonoTime, side: Side, rpm: f64) {
        if rpm.is_finite() {
            *self.rpm.of_mut(side) = Some((now, rpm));
        }
    }

    /// Lets the vessel drift.
    pub(crate) fn drift(&mut self, bus: &mut Bus) {
        self.switch(bus, Drive::Off);
    }

    /// Stops for good: nothing goes to the motors any more but a stop.
    pub(crate) fn inhibit(&mut self, bus: &mut Bus) {
        self.switch(bus, Drive::Off);
        self.authority.inhibit();
    }

    /// Follows a path at a speed.
    ///
    /// # Errors
    /// When there is no position or the path is not possible; the previous path stays in force.
    pub(crate) fn follow(
        &mut self,
        bus: &mut Bus,
        command: &PathCommand,
        speed: Speed,
    ) -> Result<(), PathFailure> {
        let now = bus.mono();
        let estimate = self.estimate.ok_or(PathFailure::NoPosition)?;
        if self.drive != Drive::Path {
            self.switch(bus, Drive::Path);
        }
        let status = self.tracker.start(now, command, &fix_of(&estimate))?;
        self.guidance.new_path();
        self.following = Some(Following {
            path_ref: command.path_ref,
            reported: Some(now),
            heading_sent: None,
            failed: false,
        });
        self.fault = None;
        self.stray.forget();
        self.speed = Some(speed);
        bus.send(Entity::Maneuver, &desired_path(command, &status, speed));
        bus.send(Entity::Path, &DesiredZ { value: 0.0, z_units: ZUnits::Depth });
        bus.send(Entity::Path, &desired_speed(speed));
        bus.send(Entity::Path, &path_state(&status));
        Ok(())
    }

    /// Another speed on the same path.
    pub(crate) fn change_speed(&mut self, bus: &mut Bus, speed: Speed) {
        if self.drive == Drive::Path && self.speed != Some(speed) {
            self.speed = Some(speed);
            bus.send(Entity::Path, &desired_speed(speed));
        }
    }

    /// Gives the vessel to an operator.
    pub(crate) fn teleoperate(&mut self, bus: &mut Bus, operator: Operator) {
        self.switch(bus, Drive::Teleoperation(operator));
    }

    fn switch(&mut self, bus: &mut Bus, drive: Drive) {
        if self.drive == drive {
            return;
        }
        let now = bus.mono();
        match self.drive {
            Drive::Off => {}
            Drive::Path => self.tracker.stop(now),
            Drive::Teleoperation(_) => {
                self.remote.deactivate(now);
                // The stop that deactivation asks for is the authority's, below.
                while self.remote.poll(now).is_some() {}
            }
        }
        self.control.disable();
        self.authority.revoke();
        self.following = None;
        self.held = None;
        self.speed = None;
        self.fault = None;
        self.stray.forget();
        self.drive = drive;
        self.loops_off(bus);
        match drive {
            Drive::Off => {}
            Drive::Path => {
                self.authority.grant(Owner::Autopilot);
                self.control.enable(MotorPair::STOPPED);
                self.loops_on(bus, Entity::Maneuver, CLoopsMask::PATH);
                self.loops_on(bus, Entity::Path, PATH_LOOPS.difference(CLoopsMask::PATH));
            }
            Drive::Teleoperation(_) => {
                self.authority.grant(Owner::Remote);
                self.remote.activate(now);
                self.loops_on(bus, Entity::Maneuver, CLoopsMask::TELEOPERATION);
            }
        }
    }

    fn loops_off(&mut self, bus: &mut Bus) {
        self.scope_ref += 1;
        self.mask = CLoopsMask::empty();
        let off = ControlLoops {
            enable: ControlLoopsEnable::Disable,
            mask: CLoopsMask::ALL,
            scope_ref: self.scope_ref,
        };
        bus.send(Entity::Maneuver, &off);
    }

    fn loops_on(&mut self, bus: &mut Bus, from: Entity, mask: CLoopsMask) {
        self.scope_ref += 1;
        self.mask |= mask;
        bus.send(from, &ControlLoops { enable: ControlLoopsEnable::Enable, mask, scope_ref: self.scope_ref });
    }

    fn some_loops_off(&mut self, bus: &mut Bus, from: Entity, mask: CLoopsMask) {
        self.scope_ref += 1;
        self.mask = self.mask.difference(mask);
        let off = ControlLoops { enable: ControlLoopsEnable::Disable, mask, scope_ref: self.scope_ref };
        bus.send(from, &off);
    }

    /// Course and speed control does what an operator's autopilot wants, from the next estimate on.
    fn hold_for_operator(&mut self, bus: &mut Bus, setpoint: Setpoint) {
        if self.held == Some(setpoint) {
            return;
        }
        if self.held.replace(setpoint).is_none() {
            self.loops_on(bus, Entity::Remote, AUTOPILOT_LOOPS);
        }
        if let Some(YawTarget::Heading(heading_rad)) = setpoint.yaw {
            bus.send(Entity::Remote, &DesiredHeading { value: heading_rad });
        }
        if let Some(speed) = setpoint.speed {
            bus.send(Entity::Remote, &desired_speed(speed));
        }
    }

    /// Takes in an estimate without steering by it yet.
    pub(crate) fn see(&mut self, estimate: &Estimate) {
        self.estimate = Some(*estimate);
    }

    /// Steers by a new estimate, or by its absence.
    pub(crate) fn steer(&mut self, bus: &mut Bus, estimate: Option<&Estimate>) {
        self.estimate = estimate.copied();
        let Some(estimate) = estimate else { return };
        match self.drive {
            Drive::Off => {}
            Drive::Path => self.steer_path(bus, estimate),
            Drive::Teleoperation(_) => {
                if let Some(setpoint) = self.held {
                    self.control.enable(MotorPair::STOPPED);
                    self.hold(bus, estimate, &setpoint, Owner::Remote);
                }
            }
        }
    }

    fn steer_path(&mut self, bus: &mut Bus, estimate: &Estimate) {
        if self.waits {
            return;
        }
        let now = bus.mono();
        let Some(mut following) = self.following else { return };
        let Ok(status) = self.tracker.update(now, &fix_of(estimate), false) else { return };
        let due = following.reported.is_none_or(|at| now.since(at) >= self.path_report);
        if due || status.event.is_some() {
            following.reported = Some(now);
            bus.send(Entity::Path, &path_state(&status));
        }
        let steering = self.guidance.steer(now, &status, &estimate.motion);
        if following.heading_sent != Some(steering.course_rad) {
            following.heading_sent = Some(steering.course_rad);
            bus.send(Entity::Path, &DesiredHeading { value: steering.course_rad });
        }
        let (course_rad, turn_rate_rad_s) = (steering.course_rad, steering.turn_rate_rad_s);
        // A heading that is only assumed would be steered by for ever: straight on is the better guess.
        let yaw = (!estimate.is_heading_old()).then_some(YawTarget::Course { course_rad, turn_rate_rad_s });
        let speed = self.limited(self.speed, estimate);
        let setpoint = Setpoint { yaw, speed };
        self.hold(bus, estimate, &setpoint, Owner::Autopilot);
        self.fault = self.stray.judge(bus, &status);
        if status.fault.is_some() && self.fault.is_none() {
            self.tracker.watch_anew();
        }
        if let Some(fault) = self.fault.filter(|_| !following.failed) {
            following.failed = true;
            self.events
                .push_back(PilotEvent::Failed { path_ref: following.path_ref, reason: fault.to_string() });
        }
        self.following = Some(following);
        self.events.push_back(PilotEvent::Path(status));
    }

    /// A speed under the limits of the guard and of a position that is only reckoned. What is not a speed in m/s is
    /// replaced while the vessel is faster.
    fn limited(&self, speed: Option<Speed>, estimate: &Estimate) -> Option<Speed> {
        let reckoning_mps = estimate.is_reckoned().then_some(self.reckoning_mps);
        let most_mps = [self.most_mps, reckoning_mps].into_iter().flatten().min_by(f64::total_cmp);
        let (Some(most_mps), Some(speed)) = (most_mps, speed) else { return speed };
        let made_mps = estimate.motion.speed_over_ground_mps();
        Some(match speed {
            Speed::MetresPerSecond(mps) => Speed::MetresPerSecond(mps.min(most_mps)),
            Speed::Rpm(_) | Speed::Percent(_) if made_mps > most_mps => Speed::MetresPerSecond(most_mps),
            other => other,
        })
    }

    fn hold(&mut self, bus: &mut Bus, estimate: &Estimate, setpoint: &Setpoint, owner: Owner) {
        let now = bus.mono();
        let fresh = |slot: Option<(MonoTime, f64)>| {
            slot.filter(|(at, _)| now.since(*at) < Duration::from_secs(2)).map(|(_, rpm)| rpm)
        };
        let mean_rpm = match (fresh(self.rpm.port), fresh(self.rpm.starboard)) {
            (Some(port), Some(starboard)) => Some(f64::midpoint(port, starboard)),
            (one, other) => one.or(other),
        };
        // On an error nothing is sent: the authority stops the motors when the last command runs out.
        let Ok(output) = self.control.update(now, &estimate.motion, setpoint, mean_rpm) else { return };
        let motors = if owner == Owner::Remote { self.gate.pass(output.motors) } else { output.motors };
        if output.restarted {
            bus.entry(Entity::Control, Level::Warning, "a long pause between two states; restarting");
        }
        if let Err(refusal) = self.authority.command(now, owner, motors) {
            bus.console(Level::Debug, format!("thrusters: {refusal}"));
        }
    }

    /// A message of an operator's keys.
    pub(crate) fn keys(&mut self, bus: &mut Bus, from: u16, actions: &RemoteActions) {
        let Drive::Teleoperation(operator) = self.drive else { return };
        let heading_rad = self.estimate.map_or(0.0, |estimate| estimate.motion.heading_rad);
        let in_control = operator.admits(from);
        let was_connected = self.remote.is_connected();
        match self.remote.handle(bus.mono(), actions, heading_rad, in_control) {
            RemoteReply::Taken if !was_connected => {
                bus.entry(Entity::Remote, Level::Info, format!("the operator at {from:#06x} steers"));
            }
            RemoteReply::Exit => self.events.push_back(PilotEvent::Exit { from }),
            RemoteReply::Taken | RemoteReply::NotInControl | RemoteReply::Inactive => {}
        }
    }

    /// Whatever falls due: commands of the operator's session, and what goes to the motors.
    pub(crate) fn tick(&mut self, bus: &mut Bus) {
        let now = bus.mono();
        let was_connected = self.remote.is_connected();
        while let Some(command) = self.remote.poll(now) {
            match command {
                RemoteCommand::Motors(motors) => {
                    if self.held.take().is_some() {
                        self.control.disable();
                        self.some_loops_off(bus, Entity::Remote, AUTOPILOT_LOOPS);
                    }
                    if let Err(refusal) = self.authority.command(now, Owner::Remote, self.gate.pass(motors)) {
                        bus.console(Level::Debug, format!("thrusters: {refusal}"));
                    }
                }
                RemoteCommand::Autopilot(setpoint) => self.hold_for_operator(bus, setpoint),
            }
        }
        if was_connected && !self.remote.is_connected() {
            bus.entry(Entity::Remote, Level::Warning, "the operator fell silent; motors stopped");
        }
        let entity = match self.authority.owner() {
            Some(Owner::Autopilot) => Entity::Control,
            Some(Owner::Remote) => Entity::Remote,
            None => Entity::Authority,
        };
        let before = self.authority.motors();
        if let Some(motors) = self.authority.poll(now) {
            bus.put(Output::Motors(motors));
            if self.authority.owner().is_some() || motors != before {
                for (id, value) in [(0, motors.port), (1, motors.starboard)] {
                    bus.send(entity, &SetThrusterActuation { id, value: value as f32 });
                }
            }
        }
    }

    /// When [`Pilot::tick`] must be called next.
    pub(crate) fn poll_timeout(&self) -> MonoTime {
        let authority = self.authority.poll_timeout();
        self.remote.poll_timeout().map_or(authority, |remote| remote.min(authority))
    }
}

/// Why a path is not followed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub(crate) enum PathFailure {
    /// The vessel does not know where it is.
    #[error("the vessel does not know where it is")]
    NoPosition,
    /// The path is not possible.
    #[error(transparent)]
    Path(#[from] PathError),
}

fn fix_of(estimate: &Estimate) -> Fix {
    Fix {
        place: estimate.place,
        motion: estimate.motion,
        variance_m2: Some(estimate.sigma_m * estimate.sigma_m),
    }
}
