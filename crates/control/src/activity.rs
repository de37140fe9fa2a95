//! How much the motor commands vary: the figure that shows an oscillating control loop.
//!
//! A loop can keep its track while both motors swing back and forth; that costs energy, gearboxes and top speed, and is
//! seen neither in the cross-track error nor in the speed.

use crate::thrust::MotorPair;
use units::MonoTime;

/// Motor activity: the mean of |da/dt| over both motors and over time (1/s, as a share of full throttle).
///
/// 0 while the motors hold what they do; 0.4 where each goes up and down by a fifth of full throttle in a second.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MotorActivity {
    last: Option<(MonoTime, MotorPair)>,
    changed: f64,
    lasted_s: f64,
}

impl MotorActivity {
    /// The motors were commanded, at `now`; a repeated command may be passed again or not.
    pub fn see(&mut self, now: MonoTime, motors: MotorPair) {
        if let Some((then, before)) = self.last.replace((now, motors)) {
            let change = before.zip(motors, |before, after| (after - before).abs());
            self.changed += change.common();
            self.lasted_s += now.since(then).as_secs_f64();
        }
    }

    /// A gap follows: the time between the last observation and the next does not count.
    pub fn pause(&mut self) {
        self.last = None;
    }

    /// The figure (1/s); `None` before any time has passed.
    pub fn per_s(&self) -> Option<f64> {
        (self.lasted_s > 0.0).then(|| self.changed / self.lasted_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(seconds: f64) -> MonoTime {
        MonoTime::from_micros((seconds * 1e6).round() as u64)
    }

    #[test]
    fn is_the_mean_change_of_both_motors_in_a_second() {
        let mut activity = MotorActivity::default();
        assert_eq!(activity.per_s(), None);
        for (seconds, port, starboard) in [(0.0, 0.5, 0.5), (1.0, 0.9, 0.5), (2.0, 0.5, 0.5), (4.0, 0.5, 0.5)]
        {
            activity.see(at(seconds), MotorPair { port, starboard });
        }
        // Port moves by 0.4 twice, starboard never, in 4 s.
        assert!((activity.per_s().unwrap() - 0.8 / 2.0 / 4.0).abs() < 1e-12, "{activity:?}");
    }

    #[test]
    fn does_not_depend_on_how_often_a_command_is_repeated() {
        let (mut seldom, mut often) = (MotorActivity::default(), MotorActivity::default());
        for second in 0..10_u32 {
            let motors = MotorPair { port: f64::from(second % 3) / 3.0, starboard: 0.2 };
            seldom.see(at(f64::from(second)), motors);
            for part in 0..4 {
                often.see(at(f64::from(second) + 0.25 * f64::from(part)), motors);
            }
        }
        seldom.see(at(9.75), MotorPair { port: 0.0, starboard: 0.2 });
        assert!((seldom.per_s().unwrap() - often.per_s().unwrap()).abs() < 1e-12, "{seldom:?} {often:?}");
    }

    #[test]
    fn leaves_pauses_out() {
        let mut activity = MotorActivity::default();
        activity.see(at(0.0), MotorPair::STOPPED);
        activity.see(at(1.0), MotorPair { port: 0.1, starboard: 0.1 });
        activity.pause();
        activity.see(at(100.0), MotorPair { port: 0.9, starboard: 0.9 });
        assert!((activity.per_s().unwrap() - 0.1).abs() < 1e-12, "{activity:?}");
    }
}
