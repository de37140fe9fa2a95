//! Operational limits: the vessel stays in its area and below its top speed.

use super::alarm::{Alarm, Condition};
use super::{Outlook, Remedy};
use crate::event::Fix;
use guard::Area;
use std::collections::VecDeque;
use std::time::Duration;
use units::MonoTime;

/// The speed counts as good again below this part of its limit.
const SPEED_RELEASE: f64 = 0.9;

/// Parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct LimitsConfig {
    /// Where the vessel may be; anywhere without.
    pub area: Option<Area>,
    /// How far inside it must be for the area to count as kept again (m).
    pub area_margin_m: f64,
    /// How long it may be outside.
    pub area_lasting: Duration,
    /// What to do then; without it only a report.
    pub area_remedy: Option<Remedy>,
    /// Greatest speed over ground (m/s); any without.
    pub max_speed_mps: Option<f64>,
    /// How long it may be faster.
    pub speed_lasting: Duration,
    /// What to do then; without it only a report.
    pub speed_remedy: Option<Remedy>,
}

impl Default for LimitsConfig {
    /// No limits; once set, five seconds of grace, then a stop.
    fn default() -> Self {
        Self {
            area: None,
            area_margin_m: 5.0,
            area_lasting: Duration::from_secs(5),
            area_remedy: Some(Remedy::Stop),
            max_speed_mps: None,
            speed_lasting: Duration::from_secs(5),
            speed_remedy: Some(Remedy::Stop),
        }
    }
}

/// Which limit is not kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Violation {
    /// The vessel is outside its area.
    Area,
    /// It is too fast.
    Speed,
}

/// The machine's output.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LimitsOutput {
    /// A limit has not been kept for too long: do this, if anything.
    Passed(Violation, Option<Remedy>),
    /// It is kept again.
    Kept(Violation),
}

/// The machine.
#[derive(Debug, Clone)]
pub struct OperationalLimits {
    config: LimitsConfig,
    area: Alarm,
    speed: Alarm,
    /// Distance to the border at the last fix (m), positive inside.
    depth_m: Option<f64>,
    outputs: VecDeque<LimitsOutput>,
}

impl OperationalLimits {
    /// A machine that has seen no fix.
    pub fn new(config: LimitsConfig) -> Self {
        Self {
            config,
            area: Alarm::default(),
            speed: Alarm::default(),
            depth_m: None,
            outputs: VecDeque::new(),
        }
    }

    /// New parameters.
    pub fn reconfigure(&mut self, config: LimitsConfig) {
        self.config = config;
    }

    /// Takes a fix.
    pub fn handle_fix(&mut self, now: MonoTime, fix: &Fix) {
        self.depth_m = self.config.area.as_ref().map(|area| area.depth_m(fix.place));
        let area = match self.depth_m {
            Some(depth_m) if depth_m < 0.0 => Condition::Bad,
            Some(depth_m) if depth_m < self.config.area_margin_m => Condition::Between,
            Some(_) | None => Condition::Good,
        };
        let speed = match self.config.max_speed_mps {
            Some(limit_mps) if fix.speed_mps > limit_mps => Condition::Bad,
            Some(limit_mps) if fix.speed_mps > SPEED_RELEASE * limit_mps => Condition::Between,
            Some(_) | None => Condition::Good,
        };
        if self.area.update(now, area, self.config.area_lasting) {
            self.tell(Violation::Area, self.area, self.config.area_remedy.clone());
        }
        if self.speed.update(now, speed, self.config.speed_lasting) {
            self.tell(Violation::Speed, self.speed, self.config.speed_remedy.clone());
        }
    }

    /// The next output.
    pub fn poll_output(&mut self) -> Option<LimitsOutput> {
        self.outputs.pop_front()
    }

    /// Distance to the border of the area at the last fix (m), positive inside.
    pub fn depth_m(&self) -> Option<f64> {
        self.depth_m
    }

    /// Which limits have not been kept for too long.
    pub fn passed(&self) -> impl Iterator<Item = Violation> {
        let alarms = [(Violation::Area, self.area), (Violation::Speed, self.speed)];
        alarms.into_iter().filter(|(_, alarm)| alarm.is_on()).map(|(violation, _)| violation)
    }

    /// What it will do if the limit not kept at the last fix stays so.
    pub fn outlook(&self) -> Option<Outlook> {
        let area = self.area.due(self.config.area_lasting).map(|at| (at, &self.config.area_remedy));
        let speed = self.speed.due(self.config.speed_lasting).map(|at| (at, &self.config.speed_remedy));
        let (at, remedy) = area.into_iter().chain(speed).min_by_key(|(at, _)| *at)?;
        Some(Outlook { remedy: remedy.clone()?, at: Some(at) })
    }

    fn tell(&mut self, violation: Violation, alarm: Alarm, remedy: Option<Remedy>) {
        self.outputs.push_back(if alarm.is_on() {
            LimitsOutput::Passed(violation, remedy)
        } else {
            LimitsOutput::Kept(violation)
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use units::{LatLon, LocalFrame, LocalPoint};

    fn at(seconds: u64) -> MonoTime {
        MonoTime::from_micros(seconds * 1_000_000)
    }

    fn machine() -> (OperationalLimits, impl Fn(f64, f64) -> Fix) {
        let frame = LocalFrame::new(LatLon::from_deg(63.44, 10.35).unwrap());
        let corner = move |north_m, east_m| frame.to_place(LocalPoint { north_m, east_m });
        let corners = [corner(0.0, 0.0), corner(100.0, 0.0), corner(100.0, 100.0), corner(0.0, 100.0)];
        let area = Some(Area::new(&corners).unwrap());
        let config = LimitsConfig { area, max_speed_mps: Some(2.0), ..LimitsConfig::default() };
        let fix = move |east_m, speed_mps| Fix {
            place: corner(50.0, east_m),
            heading_rad: 0.0,
            speed_mps,
            sigma_m: 0.0,
            water_below_m: None,
        };
        (OperationalLimits::new(config), fix)
    }

    #[test]
    fn acts_once_when_the_area_is_left_for_too_long() {
        let (mut limits, fix) = machine();
        limits.handle_fix(at(0), &fix(50.0, 1.0));
        limits.handle_fix(at(1), &fix(101.0, 1.0));
        assert_eq!(limits.outlook(), Some(Outlook { remedy: Remedy::Stop, at: Some(at(6)) }));
        for second in 2..20 {
            limits.handle_fix(at(second), &fix(101.0, 1.0));
        }
        assert_eq!(limits.poll_output(), Some(LimitsOutput::Passed(Violation::Area, Some(Remedy::Stop))));
        for second in 20..30 {
            limits.handle_fix(at(second), &fix(97.0, 1.0));
        }
        assert_eq!(limits.poll_output(), None, "3 m inside are not enough");
        for second in 30..40 {
            limits.handle_fix(at(second), &fix(90.0, 1.0));
        }
        assert_eq!(limits.poll_output(), Some(LimitsOutput::Kept(Violation::Area)));
    }

    #[test]
    fn a_gust_of_speed_is_forgiven_and_a_lasting_one_is_not() {
        let (mut limits, fix) = machine();
        for (second, speed_mps) in [(0, 2.1), (3, 1.9), (4, 2.1), (8, 2.1)] {
            limits.handle_fix(at(second), &fix(50.0, speed_mps));
        }
        assert_eq!(limits.poll_output(), None);
        limits.handle_fix(at(9), &fix(50.0, 2.1));
        assert!(limits.passed().eq([Violation::Speed]));
        assert_eq!(limits.poll_output(), Some(LimitsOutput::Passed(Violation::Speed, Some(Remedy::Stop))));
    }
}
