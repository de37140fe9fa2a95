//! Battery reserve: warns, brings the vessel home, holds it, by charge left and voltage, with hysteresis.

use super::alarm::{Alarm, Condition};
use super::{Outlook, Remedy};
use std::collections::VecDeque;
use std::time::Duration;
use units::MonoTime;

/// The drain is reckoned over at least and at most so long.
const LEAST_WINDOW: Duration = Duration::from_mins(1);
const WINDOW: Duration = Duration::from_mins(10);

/// A voltage counts as good again this much above its bound (V), as in DUNE.
const VOLTAGE_RELEASE_V: f64 = 0.2;

/// Parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct BatteryConfig {
    /// Below this part of the charge the stage is low: a warning.
    pub low: f64,
    /// Below this the stage is reserve.
    pub reserve: f64,
    /// Below this the stage is critical.
    pub critical: f64,
    /// Below this voltage (V) the stage is low whatever the charge.
    pub low_v: Option<f64>,
    /// Below this voltage (V) the stage is reserve whatever the charge.
    pub reserve_v: Option<f64>,
    /// A stage is left when the charge is this much above its bound.
    pub release: f64,
    /// How long a charge must last to count.
    pub lasting: Duration,
    /// What to do when the stage becomes reserve.
    pub reserve_remedy: Option<Remedy>,
    /// What to do when the stage becomes critical.
    pub critical_remedy: Option<Remedy>,
}

impl Default for BatteryConfig {
    /// Warn below 30 %, come home below 20 %, keep station below 10 %.
    fn default() -> Self {
        Self {
            low: 0.3,
            reserve: 0.2,
            critical: 0.1,
            low_v: None,
            reserve_v: None,
            release: 0.03,
            lasting: Duration::from_secs(10),
            reserve_remedy: Some(Remedy::Run { plan_id: "return".to_owned() }),
            critical_remedy: Some(Remedy::Hold),
        }
    }
}

/// The battery's stage.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum BatteryStage {
    /// Enough.
    #[default]
    Normal,
    /// Worth a warning.
    Low,
    /// Just enough to come home.
    Reserve,
    /// Not even that.
    Critical,
}

/// The machine's output.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum BatteryOutput {
    /// The stage changed to this.
    Stage(BatteryStage),
    /// Do this.
    Act(Remedy),
}

/// The machine.
#[derive(Debug, Clone)]
pub struct BatteryReserve {
    config: BatteryConfig,
    /// For low, reserve and critical.
    alarms: [Alarm; 3],
    stage: BatteryStage,
    last: Option<(MonoTime, f64)>,
    /// Where the drain is reckoned from.
    anchor: Option<(MonoTime, f64)>,
    /// Charge lost per second.
    drain_per_s: Option<f64>,
    /// For low and reserve by voltage.
    voltages: [Alarm; 2],
    outputs: VecDeque<BatteryOutput>,
}

impl BatteryReserve {
    /// A machine that knows nothing of the battery.
    pub fn new(config: BatteryConfig) -> Self {
        Self {
            config,
            alarms: [Alarm::default(); 3],
            stage: BatteryStage::Normal,
            last: None,
            anchor: None,
            drain_per_s: None,
            voltages: [Alarm::default(); 2],
            outputs: VecDeque::new(),
        }
    }

    /// New parameters.
    pub fn reconfigure(&mut self, config: BatteryConfig) {
        self.config = config;
    }

    /// Takes the charge left, 0 to 1. Values that are not a number are ignored.
    pub fn handle_charge(&mut self, now: MonoTime, charge: f64) {
        if !charge.is_finite() {
            return;
        }
        self.last = Some((now, charge));
        self.reckon_drain(now, charge);
        let bounds = [self.config.low, self.config.reserve, self.config.critical];
        for (alarm, bound) in self.alarms.iter_mut().zip(bounds) {
            let condition = if charge < bound {
                Condition::Bad
            } else if charge > bound + self.config.release {
                Condition::Good
            } else {
                Condition::Between
            };
            alarm.update(now, condition, self.config.lasting);
        }
        self.judge();
    }

    /// Takes the lowest voltage (V). Values that are not a number are ignored.
    pub fn handle_voltage(&mut self, now: MonoTime, voltage_v: f64) {
        if !voltage_v.is_finite() {
            return;
        }
        let bounds = [self.config.low_v, self.config.reserve_v];
        for (alarm, bound) in self.voltages.iter_mut().zip(bounds) {
            let condition = match bound {
                Some(bound_v) if voltage_v < bound_v => Condition::Bad,
                Some(bound_v) if voltage_v < bound_v + VOLTAGE_RELEASE_V => Condition::Between,
                Some(_) | None => Condition::Good,
            };
            alarm.update(now, condition, self.config.lasting);
        }
        self.judge();
    }

    /// The next output to report or carry out.
    pub fn poll_output(&mut self) -> Option<BatteryOutput> {
        self.outputs.pop_front()
    }

    /// The battery's stage.
    pub fn stage(&self) -> BatteryStage {
        self.stage
    }

    /// What it will do next, and when at the present drain.
    pub fn outlook(&self) -> Option<Outlook> {
        let (bound, remedy) = if self.stage < BatteryStage::Reserve && self.config.reserve_remedy.is_some() {
            (self.config.reserve, self.config.reserve_remedy.clone()?)
        } else if self.stage < BatteryStage::Critical {
            (self.config.critical, self.config.critical_remedy.clone()?)
        } else {
            return None;
        };
        Some(Outlook { remedy, at: self.reaches(bound) })
    }

    /// The charge below which it will next report a worse state, and when at the present drain.
    pub fn next_warning(&self) -> Option<(f64, Option<MonoTime>)> {
        let bound = match self.stage {
            BatteryStage::Normal => self.config.low,
            BatteryStage::Low => self.config.reserve,
            BatteryStage::Reserve => self.config.critical,
            BatteryStage::Critical => return None,
        };
        Some((bound, self.reaches(bound)))
    }

    /// When the charge will have been below `bound` for long enough.
    fn reaches(&self, bound: f64) -> Option<MonoTime> {
        let (at, charge) = self.last?;
        let drain = self.drain_per_s.filter(|drain| *drain > 0.0)?;
        let left = Duration::try_from_secs_f64(((charge - bound) / drain).max(0.0)).ok()?;
        Some(at + left + self.config.lasting)
    }

    /// The worse of what charge and voltage say.
    fn judge(&mut self) {
        let charge = match self.alarms.map(Alarm::is_on) {
            [_, _, true] => BatteryStage::Critical,
            [_, true, false] => BatteryStage::Reserve,
            [true, false, false] => BatteryStage::Low,
            [false, false, false] => BatteryStage::Normal,
        };
        let voltage = match self.voltages.map(Alarm::is_on) {
            [_, true] => BatteryStage::Reserve,
            [true, false] => BatteryStage::Low,
            [false, false] => BatteryStage::Normal,
        };
        self.enter(charge.max(voltage));
    }

    fn enter(&mut self, stage: BatteryStage) {
        if stage == self.stage {
            return;
        }
        let worse = stage > self.stage;
        self.stage = stage;
        self.outputs.push_back(BatteryOutput::Stage(stage));
        let remedy = match stage {
            BatteryStage::Critical => self.config.critical_remedy.clone(),
            BatteryStage::Reserve => self.config.reserve_remedy.clone(),
            BatteryStage::Normal | BatteryStage::Low => None,
        };
        if let Some(remedy) = remedy.filter(|_| worse) {
            self.outputs.push_back(BatteryOutput::Act(remedy));
        }
    }

    fn reckon_drain(&mut self, now: MonoTime, charge: f64) {
        let (since, before) = *self.anchor.get_or_insert((now, charge));
        let span = now.since(since);
        if span >= LEAST_WINDOW {
            self.drain_per_s = Some((before - charge) / span.as_secs_f64());
        }
        if span >= WINDOW {
            self.anchor = Some((now, charge));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(seconds: u64) -> MonoTime {
        MonoTime::from_micros(seconds * 1_000_000)
    }

    fn outputs(machine: &mut BatteryReserve) -> Vec<BatteryOutput> {
        std::iter::from_fn(|| machine.poll_output()).collect()
    }

    #[test]
    fn warns_returns_and_holds_as_the_charge_falls() {
        let mut machine = BatteryReserve::new(BatteryConfig::default());
        let home = Remedy::Run { plan_id: "return".to_owned() };
        let mut told = Vec::new();
        for second in 0..1_000_u32 {
            machine.handle_charge(at(second.into()), 1.0005 - f64::from(second) / 1_000.0);
            told.extend(outputs(&mut machine).into_iter().map(|output| (second, output)));
        }
        let expected = [
            (711, BatteryOutput::Stage(BatteryStage::Low)),
            (811, BatteryOutput::Stage(BatteryStage::Reserve)),
            (811, BatteryOutput::Act(home)),
            (911, BatteryOutput::Stage(BatteryStage::Critical)),
            (911, BatteryOutput::Act(Remedy::Hold)),
        ];
        assert_eq!(told, expected);
    }

    #[test]
    fn foresees_when_it_will_act() {
        let mut machine = BatteryReserve::new(BatteryConfig::default());
        assert_eq!(machine.outlook().and_then(|outlook| outlook.at), None);
        for second in 0..200_u32 {
            machine.handle_charge(at(second.into()), 1.0005 - f64::from(second) / 1_000.0);
        }
        let (bound, when) = machine.next_warning().unwrap();
        assert!(bound > machine.config.reserve && when.unwrap() < machine.outlook().unwrap().at.unwrap());
        let outlook = machine.outlook().unwrap();
        let foreseen_s = outlook.at.unwrap().micros() as f64 / 1e6;
        assert!((foreseen_s - 810.5).abs() < 1.0, "{foreseen_s}");
    }

    #[test]
    fn a_charge_that_wavers_at_a_bound_acts_once() {
        let mut machine = BatteryReserve::new(BatteryConfig::default());
        for second in 0..600 {
            let charge = if second / 20 % 2 == 0 { 0.19 } else { 0.21 };
            machine.handle_charge(at(second), charge);
        }
        let acts = outputs(&mut machine).iter().filter(|one| matches!(one, BatteryOutput::Act(_))).count();
        assert_eq!(acts, 1);
    }

    #[test]
    fn a_dip_and_a_value_that_is_no_number_do_nothing() {
        let mut machine = BatteryReserve::new(BatteryConfig::default());
        machine.handle_charge(at(0), 0.8);
        machine.handle_charge(at(1), 0.05);
        machine.handle_charge(at(5), f64::NAN);
        machine.handle_charge(at(9), 0.8);
        machine.handle_charge(at(20), 0.8);
        assert_eq!((outputs(&mut machine), machine.stage()), (Vec::new(), BatteryStage::Normal));
    }
}
