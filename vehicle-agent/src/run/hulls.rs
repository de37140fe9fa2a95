//! The hulls that the loop can steer, each with the watchdog of its motors.

use crate::clock::Clock;
use crate::hardware::Hardware;
use crate::hull::Simulated;
use crate::motor_gate::MotorGate;
use crate::net::Inbox;
use crate::setup;
use config::Config;
use sim::Vessel;
use std::sync::Arc;
use std::sync::mpsc::channel;
use units::UtcTime;

/// Inputs for making a hull.
pub(super) struct HullContext<'a> {
    pub(super) config: &'a Config,
    pub(super) clock: &'a Clock,
    /// The start by the computer's clock.
    pub(super) utc: UtcTime,
    pub(super) seed: u64,
    pub(super) inbox: Arc<Inbox>,
}

/// A simulated hull whose commands pass the watchdog.
pub(super) fn simulated(context: &HullContext<'_>) -> anyhow::Result<(Simulated, Arc<MotorGate>)> {
    let vessel = Vessel::new(&setup::vessel(context.config, context.utc, context.seed)?)?;
    let (device, passed) = channel();
    let gate = MotorGate::start(move |motors| {
        // At the end of the program the watchdog outlives the simulation: then there is no receiver.
        device.send(motors).ok();
    })?;
    let watchdog = Arc::clone(&gate);
    Ok((Simulated::watched(vessel, move |motors| watchdog.command(motors), passed), gate))
}

/// The devices aboard; each wakes the loop when it has read something.
pub(super) fn hardware(context: &HullContext<'_>) -> anyhow::Result<(Hardware, Arc<MotorGate>)> {
    let inbox = Arc::clone(&context.inbox);
    Hardware::start(context.config, context.clock, move || inbox.wake())
}
