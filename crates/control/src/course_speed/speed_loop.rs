//! The speed half: desired speed to demand (rpm or newtons), demand to common effort.

use super::config::{Drive, FeedForward, Governor, SpeedConfig};
use crate::pid::{Pid, PidTerms, Saturation};
use crate::ramp;
use crate::thrust::EffortLimits;
use units::Speed;

/// Memory of the speed and rpm loops.
#[derive(Debug, Clone)]
pub(super) struct SpeedLoop {
    pid: Pid,
    governor: Option<Pid>,
    demand: f64,
}

/// The loop's input in one step.
pub(super) struct SpeedInput {
    pub(super) target: Speed,
    pub(super) surge_mps: f64,
    pub(super) measured_rpm: Option<f64>,
    pub(super) max_actuation: f64,
    pub(super) dt_s: f64,
}

/// The loop's output in one step.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SpeedStep {
    pub(super) effort: f64,
    pub(super) speed_terms: PidTerms,
    pub(super) rpm_terms: PidTerms,
}

impl SpeedLoop {
    pub(super) fn new(config: &SpeedConfig, drive: &Drive) -> Self {
        Self { pid: Pid::new(config.pid), governor: governor_pid(drive), demand: 0.0 }
    }

    pub(super) fn reconfigure(&mut self, config: &SpeedConfig, drive: &Drive) {
        self.pid.reconfigure(config.pid);
        match (&mut self.governor, governor_pid(drive)) {
            (Some(old), Some(_)) => {
                if let Drive::Rpm { governor: Governor::Software { pid, .. }, .. } = drive {
                    old.reconfigure(*pid);
                }
            }
            (old, new) => *old = new,
        }
    }

    /// Starts with the demand that gives `actuation` of both motors.
    pub(super) fn start_at(&mut self, actuation: f64, drive: &Drive) {
        self.pid.reset();
        if let Some(governor) = &mut self.governor {
            governor.reset();
        }
        self.demand = demand_at(drive, actuation);
    }

    /// No thrust ahead for now: the integral waits, the demand starts again from zero.
    pub(super) fn pause(&mut self) {
        self.demand = 0.0;
    }

    /// Reports that the motors were saturated.
    pub(super) fn saturated(&mut self, saturation: Saturation) {
        self.pid.saturated(saturation);
        if let Some(governor) = &mut self.governor {
            governor.saturated(saturation);
        }
    }

    pub(super) fn update(&mut self, config: &SpeedConfig, drive: &Drive, input: &SpeedInput) -> SpeedStep {
        let mut step = SpeedStep::default();
        let (wanted, least, most) = match input.target {
            Speed::MetresPerSecond(mps) if mps < config.stop_below_mps => {
                self.stop();
                return step;
            }
            Speed::MetresPerSecond(mps) => {
                step.speed_terms = self.pid.update(mps - input.surge_mps, input.dt_s).1;
                step.speed_terms.feed_forward = match &config.feed_forward {
                    FeedForward::Gain(gain) => gain * mps,
                    FeedForward::Table(table) => table.rpm_for_mps(mps),
                };
                (step.speed_terms.sum(), config.min_demand, config.max_demand)
            }
            Speed::Rpm(_) | Speed::Percent(_) => {
                self.pid.reset();
                let demand = demand_at(drive, direct_actuation(drive, input.target));
                (demand, -config.max_demand, config.max_demand)
            }
        };
        let max_change = config.max_demand_rate_per_s * input.dt_s;
        let demand = ramp::toward(self.demand, wanted, max_change).clamp(least, most);
        self.pid.saturated(Saturation::between(wanted, demand));
        self.demand = demand;
        self.drive_effort(drive, input, &mut step);
        step
    }

    fn stop(&mut self) {
        self.demand = 0.0;
        self.pid.reset();
        if let Some(governor) = &mut self.governor {
            governor.reset();
        }
    }

    fn drive_effort(&mut self, drive: &Drive, input: &SpeedInput, step: &mut SpeedStep) {
        step.effort = match drive {
            Drive::Force { .. } => self.demand,
            Drive::Rpm { rpm_at_max_thrust, governor } => match (governor, &mut self.governor) {
                (Governor::Software { feed_forward, .. }, Some(pid)) => {
                    if let Some(measured_rpm) = input.measured_rpm {
                        step.rpm_terms = pid.update(self.demand - measured_rpm, input.dt_s).1;
                    }
                    step.rpm_terms.feed_forward = feed_forward * self.demand;
                    let wanted = step.rpm_terms.sum();
                    let got = wanted.clamp(-input.max_actuation, input.max_actuation);
                    pid.saturated(Saturation::between(wanted, got));
                    got
                }
                _ => self.demand / rpm_at_max_thrust,
            },
        };
    }
}

/// The effort one motor can give.
pub(super) fn effort_limits(drive: &Drive, max_actuation: f64) -> EffortLimits {
    match drive {
        Drive::Rpm { .. } => EffortLimits { astern: -max_actuation, ahead: max_actuation },
        Drive::Force { map, .. } => {
            EffortLimits { astern: map.force_at(-max_actuation), ahead: map.force_at(max_actuation) }
        }
    }
}

/// Effort of a motor to its actuation.
pub(super) fn actuation_for(drive: &Drive, effort: f64) -> f64 {
    match drive {
        Drive::Rpm { .. } => effort,
        Drive::Force { map, .. } => map.actuation_for(effort),
    }
}

fn governor_pid(drive: &Drive) -> Option<Pid> {
    match drive {
        Drive::Rpm { governor: Governor::Software { pid, .. }, .. } => Some(Pid::new(*pid)),
        Drive::Rpm { governor: Governor::Hardware, .. } | Drive::Force { .. } => None,
    }
}

fn demand_at(drive: &Drive, actuation: f64) -> f64 {
    match drive {
        Drive::Rpm { rpm_at_max_thrust, .. } => actuation * rpm_at_max_thrust,
        Drive::Force { map, .. } => map.force_at(actuation),
    }
}

fn direct_actuation(drive: &Drive, target: Speed) -> f64 {
    let (Drive::Rpm { rpm_at_max_thrust, .. } | Drive::Force { rpm_at_max_thrust, .. }) = drive;
    let actuation = match target {
        Speed::Rpm(rpm) => rpm / rpm_at_max_thrust,
        Speed::Percent(percent) => percent / 100.0,
        Speed::MetresPerSecond(_) => 0.0,
    };
    actuation.clamp(-1.0, 1.0)
}
