//! The devices aboard: one thread for each port, readings in order of time, and the motors behind the watchdog.
//!
//! A command goes from the loop to the [`MotorGate`], from there to the motors' driver by [`Orders`], and from its thread
//! to the card. Each stops the motors on its own: the gate when the loop stalls, the driver when it gets no commands, the
//! card when it gets no frames. A device that is absent, silent or lost is in error; the program continues.

#[cfg(test)]
mod accuracy;
mod can;
mod configured;
mod listening;
mod queues;
mod wire;

pub(crate) use can::{CanMotors, Orders};
pub(crate) use configured::{ConfiguredDevice, configured_devices, motors_config, motors_place};
pub(crate) use listening::listening;
#[cfg(test)]
pub(crate) use wire::Wire as MotorsWire;

use crate::board::Board;
use crate::clock::Clock;
use crate::device::Device;
use crate::hull::Hull;
use crate::io::{Report, Station, Wake};
use crate::motor_gate::MotorGate;
use config::Config;
use control::MotorPair;
use drivers::State;
use onboard::{Brain, Condition, Input};
use queues::DeviceQueues;
use std::sync::Arc;
use std::time::Duration;
use units::MonoTime;

/// How long the end waits for the last commands to the devices.
const END: Duration = Duration::from_secs(1);

/// The devices aboard.
#[derive(Debug)]
pub(crate) struct Hardware {
    queues: Arc<DeviceQueues>,
    gate: Arc<MotorGate>,
    stations: Vec<(Device, Station)>,
    board: Board,
    orders: Arc<Orders>,
    motors_wake: Arc<Wake>,
}

impl Hardware {
    /// Starts the configured devices. `bell` wakes the loop when one has a reading.
    ///
    /// # Errors
    /// When the configuration has no device, or an invalid one; never because a device is missing.
    pub(crate) fn start(
        config: &Config,
        clock: &Clock,
        bell: impl Fn() + Send + Sync + 'static,
    ) -> anyhow::Result<(Self, Arc<MotorGate>)> {
        let queues = Arc::new(DeviceQueues::new(bell));
        let orders = Arc::new(Orders::default());
        let motors_wake = Arc::new(Wake::new()?);
        let gate = MotorGate::start(to_motors(clock.clone(), Arc::clone(&orders), Arc::clone(&motors_wake)))?;
        let mut stations = Vec::new();
        for ConfiguredDevice { device, driver, place } in configured_devices(config, &orders)? {
            let wake =
                if device == Device::Motors { Arc::clone(&motors_wake) } else { Arc::new(Wake::new()?) };
            tracing::info!(device = device.name(), %place, "port opened by a thread of its own");
            let sink = to_queues(device, Arc::clone(&queues));
            stations.push((device, Station::start(device.name(), driver, place, clock.clone(), wake, sink)?));
        }
        let of_board = Arc::clone(&queues);
        let board =
            Board::start(config, clock.clone(), move |device| to_queues(device, Arc::clone(&of_board)))?;
        Ok((Self { queues, gate: Arc::clone(&gate), stations, board, orders, motors_wake }, gate))
    }
}

/// Passes commands from the watchdog to the motors' thread; never waits.
fn to_motors(clock: Clock, orders: Arc<Orders>, wake: Arc<Wake>) -> impl FnMut(MotorPair) + Send + 'static {
    move |motors| {
        orders.put(clock.now().mono, motors);
        wake.ring();
    }
}

/// Distributes the reports of a device's driver.
fn to_queues(device: Device, queues: Arc<DeviceQueues>) -> impl Fn(Report) + Send + 'static {
    let name = device.name();
    move |report| match report {
        Report::Reading(at, reading) => queues.reading(device, at, reading),
        Report::State(State::Starting) => {
            tracing::info!(device = name, "its port is open; waiting for its answer");
            queues.state(device, Condition::Boot, "waiting for its answer");
        }
        Report::State(State::Working) => {
            tracing::info!(device = name, "works");
            queues.state(device, Condition::Normal, "");
        }
        Report::State(State::Failing(why)) => {
            // The vessel reports it, in its log and to the operator.
            tracing::debug!(device = name, "{why}");
            queues.state(device, Condition::Error, &why);
        }
        Report::Note(note) if note.warning => {
            // Those that the vessel writes into its log book are warnings here too.
            tracing::info!(device = name, "{}", note.text);
            queues.warning(device, note.text);
        }
        Report::Note(note) => tracing::info!(device = name, "{}", note.text),
    }
}

impl Hull for Hardware {
    fn poll(&mut self, until: MonoTime) -> Option<Input> {
        let input = self.queues.take(until);
        if input.is_none() {
            for (device, readings) in self.queues.take_dropped() {
                tracing::error!(device = device.name(), readings, "were dropped: the loop was held up");
            }
        }
        input
    }

    fn poll_timeout(&self) -> Option<MonoTime> {
        self.queues.first()
    }

    fn command(&mut self, motors: MotorPair) {
        self.gate.command(motors);
    }

    fn switch(&mut self, channel: &str, on: bool) {
        self.orders.switch(channel, on);
        self.motors_wake.ring();
    }

    fn attend(&mut self, brain: &Brain) {
        self.board.attend(brain);
    }

    fn end(&mut self, clean: bool) -> bool {
        // A clean end switches the watchdog off before anything that may be slow.
        self.board.end(clean);
        self.stations.iter().for_each(|(_, station)| station.end());
        let mut all = true;
        for (device, station) in &self.stations {
            let over = station.is_over_within(END);
            all &= over || *device != Device::Motors;
        }
        all
    }
}
