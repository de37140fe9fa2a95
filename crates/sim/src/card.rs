//! The interface card: what it makes of commands, and what it reports in which rhythm.
//!
//! The card stops a motor that is not commanded at least once a second (DUNE task `Actuators.Torqeedo`). Reports: each
//! motor five times, each battery, each rail and each rail's outputs once a second, one after the other; the rhythm is an
//! assumption that stays below the 36 frames a second the DUNE task reads. Rails: 0 and 1 feed the motors
//! and 2 auxiliaries at battery voltage, 3 is 12 V, 4 is 5 V. All outputs are on at power-up, and
//! the card knows no others; only those of the motors (channel 0 of rails 0 and 1) have an effect here. Which of the two is port is unsettled on the
//! boats; here rail 0 feeds motor 0, to port.

use crate::battery::BatteryBank;
use crate::motor::{Drive, Motor, ThrottleMap};
use devices::torqeedo::{CardCommand, CardReport, FULL_THROTTLE};
use devices::{MotorReading, Pair, RailReading, Side};
use std::time::Duration;
use units::MonoTime;

/// A slot is 20 ms long; fifty slots are one round of a second.
const SLOT_US: u64 = 20_000;
const SLOTS: u64 = 50;
/// The outputs that each rail has, bit by bit.
const RAIL_OUTPUTS: [u32; 5] = [0b1, 0b1, 0b11, 0b1_1111, 0b1];
const RAIL_FUSES_A: [f64; 5] = [25.0, 25.0, 10.0, 10.0, 5.0];

/// Motors and card.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CardConfig {
    /// How a throttle becomes a shaft speed.
    pub throttle_map: ThrottleMap,
    /// How long a command lasts.
    pub command_timeout: Duration,
}

impl Default for CardConfig {
    /// Throttle in proportion, commands last a second.
    fn default() -> Self {
        Self { throttle_map: ThrottleMap::Proportional, command_timeout: Duration::from_secs(1) }
    }
}

/// The card with both motors behind it.
#[derive(Debug, Clone)]
pub(crate) struct Card {
    config: CardConfig,
    drive: Pair<Drive>,
    commanded_at: Option<MonoTime>,
    /// The outputs that are on, by rail, bit by bit.
    outputs: [u32; 5],
    motors: Pair<Motor>,
    /// Slots since the start whose report has been made.
    slot: u64,
}

impl Card {
    /// The card, its motors in water of the given temperature (°C).
    pub(crate) fn new(config: &CardConfig, water_c: f64) -> Self {
        Self {
            config: *config,
            drive: Pair::new(Drive::Throttle(0.0), Drive::Throttle(0.0)),
            commanded_at: None,
            outputs: RAIL_OUTPUTS,
            motors: Pair::new(Motor::new(water_c), Motor::new(water_c)),
            slot: 0,
        }
    }

    /// Takes a command over, to last until the time-out.
    pub(crate) fn command(&mut self, now: MonoTime, drive: Pair<Drive>) {
        self.drive = drive;
        self.commanded_at = Some(now);
    }

    /// Takes a frame's command over.
    pub(crate) fn obey(&mut self, now: MonoTime, command: CardCommand) {
        match command {
            CardCommand::MotorSet(set) => {
                let full = f64::from(FULL_THROTTLE);
                self.command(now, set.map(|per_mille| Drive::Throttle(f64::from(per_mille) / full)));
            }
            CardCommand::OutputSet { rail, channel, on } => self.switch(rail, channel, on),
        }
    }

    /// Switches an output; one that the card does not have stays unchanged.
    fn switch(&mut self, rail: u8, channel: u8, on: bool) {
        let rail = usize::from(rail);
        let (Some(outputs), Some(known)) = (self.outputs.get_mut(rail), RAIL_OUTPUTS.get(rail)) else {
            return;
        };
        let bit = 1_u32.checked_shl(channel.into()).unwrap_or(0) & known;
        *outputs = if on { *outputs | bit } else { *outputs & !bit };
    }

    /// Whether a motor has power.
    fn powered(&self, side: Side) -> bool {
        self.outputs[usize::from(side.index())] & 1 == 1
    }

    /// Shaft speeds asked of the motors at this moment (rad/s).
    pub(crate) fn goal_radps(&self, now: MonoTime, energy_left: bool) -> Pair<f64> {
        let alive =
            self.commanded_at.is_some_and(|at| now.since(at) <= self.config.command_timeout) && energy_left;
        let goal = |side: Side| {
            if alive && self.powered(side) {
                self.drive.of(side).shaft_radps(self.config.throttle_map)
            } else {
                0.0
            }
        };
        Pair::new(goal(Side::Port), goal(Side::Starboard))
    }

    /// Runs both motors for `dt_s` and returns the power they draw (W).
    pub(crate) fn step(&mut self, shaft_radps: Pair<f64>, energy_left: bool, dt_s: f64) -> f64 {
        for side in Side::BOTH {
            let powered = self.powered(side) && energy_left;
            self.motors.of_mut(side).step(*shaft_radps.of(side), powered, dt_s);
        }
        self.motors.port.reading().power_w + self.motors.starboard.reading().power_w
    }

    /// The report of a motor.
    pub(crate) fn motor(&self, side: Side) -> MotorReading {
        self.motors.of(side).reading()
    }

    /// The reports that have come due by `now`, with their times.
    pub(crate) fn reports(
        &mut self,
        now: MonoTime,
        bank: &BatteryBank,
        out: &mut Vec<(MonoTime, CardReport)>,
    ) {
        while self.slot * SLOT_US <= now.micros() {
            let at = MonoTime::from_micros(self.slot * SLOT_US);
            if let Some(report) = self.report_of(self.slot % SLOTS, bank) {
                out.push((at, report));
            }
            self.slot += 1;
        }
    }

    fn report_of(&self, slot: u64, bank: &BatteryBank) -> Option<CardReport> {
        match (slot / 10, slot % 10) {
            (_, 0) => Some(CardReport::Motor(Side::Port, self.motor(Side::Port))),
            (_, 2) => Some(CardReport::Motor(Side::Starboard, self.motor(Side::Starboard))),
            (pack @ 0..4, 5) => Some(CardReport::Battery(bank.readings()[pack as usize])),
            // The casts keep a number below five.
            (rail, 7) => Some(self.rail(rail as u8, bank)),
            (rail, 9) => {
                Some(CardReport::Outputs { rail: rail as u8, channels: self.outputs[rail as usize] })
            }
            _ => None,
        }
    }

    fn rail(&self, rail: u8, bank: &BatteryBank) -> CardReport {
        let battery_v = bank.voltage_v();
        let motor_a = |side| self.motor(side).power_w / battery_v;
        let (voltage_v, current_a) = match rail {
            0 => (battery_v, motor_a(Side::Port)),
            1 => (battery_v, motor_a(Side::Starboard)),
            2 => (battery_v, 0.3),
            3 => (12.0, 2.2),
            _ => (5.0, 0.1),
        };
        let fuse_a = RAIL_FUSES_A[usize::from(rail.min(4))];
        CardReport::Rail(RailReading { number: rail, voltage_v, current_a, fuse_a, flags: 0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::battery::BatteryConfig;

    fn at(ms: u64) -> MonoTime {
        MonoTime::from_micros(ms * 1000)
    }

    fn card() -> Card {
        Card::new(&CardConfig::default(), 8.0)
    }

    #[test]
    fn a_command_lasts_one_second() {
        let mut card = card();
        assert_eq!(card.goal_radps(at(0), true), Pair::default());
        card.obey(at(500), CardCommand::MotorSet(Pair::new(1000, -1000)));
        let goal = card.goal_radps(at(1500), true);
        assert!(goal.port > 103.0 && goal.starboard < -101.0);
        assert_eq!(card.goal_radps(at(1501), true), Pair::default());
    }

    #[test]
    fn a_motor_without_power_stands_still() {
        let mut card = card();
        card.obey(at(0), CardCommand::MotorSet(Pair::new(500, 500)));
        card.obey(at(0), CardCommand::OutputSet { rail: 1, channel: 0, on: false });
        let goal = card.goal_radps(at(1), true);
        assert!(goal.port > 50.0 && goal.starboard == 0.0);
        assert_eq!(card.goal_radps(at(1), false), Pair::default());
    }

    #[test]
    fn every_motor_battery_and_rail_reports_in_its_rhythm() {
        let bank = BatteryBank::new(&BatteryConfig::default(), 8.0, 1).unwrap();
        let mut reports = Vec::new();
        card().reports(at(9_999), &bank, &mut reports);
        let count = |wanted: fn(&CardReport) -> bool| reports.iter().filter(|(_, r)| wanted(r)).count();
        assert_eq!(count(|r| matches!(r, CardReport::Motor(..))), 100);
        assert_eq!(count(|r| matches!(r, CardReport::Battery(r) if r.number == 3)), 10);
        assert_eq!(count(|r| matches!(r, CardReport::Rail(RailReading { number: 4, .. }))), 10);
        assert!(reports.windows(2).all(|w| w[0].0 < w[1].0));
    }
}
