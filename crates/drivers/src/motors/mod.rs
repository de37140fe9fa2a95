//! The interface card of the Torqeedo motors, batteries and power channels on the CAN bus.
//!
//! Works on frames: the owner of the bus, by SocketCAN or through a serial adapter, gives what comes to
//! [`Motors::handle`], calls [`Motors::tick`] when [`Motors::poll_timeout`] is due and always before it polls, and sends
//! what [`Motors::poll_output`] gives. The card stops a motor that is not commanded for a second, so throttles go out
//! steadily, four times a second as from the DUNE task `Actuators.Torqeedo`; that task repeats the last throttle for ever,
//! this driver does not: a throttle lives for [`MotorsConfig::command_timeout`] and is zero from then on.

mod config;
mod outbox;
mod power;
mod text;
mod throttle;
mod trouble;
mod watch;

#[cfg(test)]
mod tests;

pub use config::{ChannelConfig, ConfigError, MotorAssignment, MotorsConfig, write_period};
pub use outbox::MotorsOutput;
pub use power::{ChannelTable, LABELS, UnknownChannel};

use crate::{Note, State};
use devices::torqeedo::{BatteryStatus, CARD, CanFrame, DecodeError, Message, MotorDrive, Received};
use devices::{Pair, Reading};
use outbox::Outbox;
use power::PowerChannels;
use text::CardText;
use throttle::Throttles;
use trouble::{Troubles, battery_is_plausible, motor_is_plausible, motor_name, rail_is_plausible};
use units::{MonoTime, Now};
use watch::Watch;

/// The driver of the card.
#[derive(Debug, Clone)]
pub struct Motors {
    config: MotorsConfig,
    throttles: Throttles,
    power: PowerChannels,
    watch: Watch,
    text: CardText,
    out: Outbox,
    open: bool,
    /// It commands nothing: no throttle and no power channel.
    only_listens: bool,
    troubles: Troubles,
}

impl Motors {
    /// A driver whose bus is not open yet.
    ///
    /// # Errors
    /// When the configuration contradicts itself or what the card can do.
    pub fn new(config: MotorsConfig) -> Result<Self, ConfigError> {
        config.check()?;
        Ok(Self {
            throttles: Throttles::new(&config),
            power: PowerChannels::new(&config.channels),
            watch: Watch::new(config.silence),
            text: CardText::default(),
            out: Outbox::default(),
            open: false,
            only_listens: false,
            troubles: Troubles::default(),
            config,
        })
    }

    /// The same, but it only listens: it sends no frame, so that another controller's commands stand.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn listening(config: MotorsConfig) -> Result<Self, ConfigError> {
        Ok(Self { only_listens: true, ..Self::new(config)? })
    }

    /// The bus is open, for the first time or again: the motors are stopped, and every named power channel is switched as
    /// it was asked last.
    pub fn opened(&mut self, now: Now) {
        self.open = true;
        self.throttles.stop(now.mono);
        if !self.only_listens {
            self.power.ask_all();
        }
        self.watch.opened(now.mono);
        self.out.state(State::Starting);
        self.tick(now);
    }

    /// The bus is gone. Nothing is sent until it opens again; the card stops the motors within a second.
    pub fn lost(&mut self, now: Now) {
        self.open = false;
        self.throttles.stop(now.mono);
        self.out.forget_frames();
        self.out.state(State::Starting);
    }

    /// Asks for a throttle of each side (-1 full astern, 1 full ahead), for as long as a command lives. Values beyond are
    /// held at full speed. What is not a number stops both motors at once.
    pub fn command(&mut self, now: Now, throttle: Pair<f64>) {
        self.command_of(now, now.mono, throttle);
    }

    /// The same for a command that was given at `given`, from when on it lives.
    pub fn command_of(&mut self, now: Now, given: MonoTime, throttle: Pair<f64>) {
        if self.throttles.command(now.mono, given, throttle).is_err() {
            let text = "a throttle is not a number: refused, both motors are stopped".to_owned();
            self.out.note(Note { warning: true, text });
        }
        self.tick(now);
    }

    /// Stops both motors at once, ahead of everything that waits to be sent.
    pub fn stop(&mut self, now: Now) {
        self.throttles.stop(now.mono);
        self.tick(now);
    }

    /// Switches a power channel by its configured name, once and again where the card does not follow.
    ///
    /// # Errors
    /// When no channel has this name.
    pub fn switch(&mut self, now: Now, name: &str, on: bool) -> Result<(), UnknownChannel> {
        self.power.switch(name, on)?;
        self.tick(now);
        Ok(())
    }

    /// Takes a frame of the bus.
    pub fn handle(&mut self, now: Now, frame: &CanFrame) {
        match Received::decode(frame) {
            Ok(received) => self.receive(now, &received),
            // Frames of other protocols are other devices' on the same bus, which is not a fault.
            Err(DecodeError::Foreign(_)) => {}
            Err(error) => self.watch.unread(now.mono, &error, &mut self.out),
        }
        self.tick(now);
    }

    /// Does what is due at `now`.
    pub fn tick(&mut self, now: Now) {
        if self.open && !self.only_listens {
            if let Some(throttle) = self.throttles.due(now.mono) {
                self.out.throttle(throttle);
            }
            self.power.due(now.mono, &mut self.out);
        }
        self.watch.tick(now.mono, self.open, self.config.sides, &mut self.out);
    }

    /// The next output; `None` when there is no more.
    pub fn poll_output(&mut self) -> Option<MotorsOutput> {
        self.out.poll()
    }

    /// When to call [`tick`](Self::tick) at the latest; `None` while the bus is not open.
    pub fn poll_timeout(&self) -> Option<MonoTime> {
        let throttles = (!self.only_listens).then(|| self.throttles.poll_timeout());
        self.watch.poll_timeout().into_iter().chain(throttles).min().filter(|_| self.open)
    }

    fn receive(&mut self, now: Now, received: &Received) {
        if !received.concerns_computer() {
            return;
        }
        self.watch.heard(now.mono, received.source == CARD);
        match received.message {
            Message::MotorDrive(drive) => self.motor(now, &drive),
            Message::BatteryStatus(status) => self.battery(now, &status),
            Message::Rail(rail) if rail_is_plausible(&rail) => self.out.reading(now, Reading::Rail(rail)),
            Message::Rail(rail) => self.nonsense(now, &format!("rail {}", rail.number)),
            Message::Outputs { rail, channels } => self.power.report(now, rail, channels, &mut self.out),
            Message::MotorStatus { motor, errors, status } => {
                if let Some((side, _)) = self.config.side_of(motor) {
                    self.troubles.motor(now, motor, side, errors, status, &mut self.out);
                }
            }
            Message::Text(text) => self.text.take(text.bytes(), &mut self.out),
            Message::OutputSet { .. }
            | Message::Uptime { .. }
            | Message::MotorSet(_)
            | Message::BatteryControl { .. }
            | Message::Id { .. }
            | Message::Other(_) => {}
        }
    }

    fn motor(&mut self, now: Now, drive: &MotorDrive) {
        let Some((side, assignment)) = self.config.side_of(drive.motor) else { return };
        let mut reading = drive.reading();
        if !motor_is_plausible(&reading) {
            // Not counted as feedback: the state of a motor that continues so is unknown.
            return self.nonsense(now, motor_name(side));
        }
        self.watch.feedback(now.mono, side);
        reading.propeller_rpm *= assignment.sign();
        self.out.reading(now, Reading::Motor(side, reading));
    }

    fn battery(&mut self, now: Now, status: &BatteryStatus) {
        let number = status.reading.number;
        if !battery_is_plausible(&status.reading) {
            return self.nonsense(now, &format!("battery {number}"));
        }
        self.troubles.battery(now, number, status.error, &mut self.out);
        self.out.reading(now, Reading::Battery(status.reading));
    }

    /// A part reports what cannot be.
    fn nonsense(&mut self, now: Now, name: &str) {
        let why =
            format!("{name} reports values that cannot be: look at its cable, and at the card's firmware");
        self.watch.unread(now.mono, &why, &mut self.out);
    }
}
