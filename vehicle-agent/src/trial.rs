//! A trial of the configured course and speed controller on the model of the hull, before it steers a boat.
//!
//! Gains that are too high for the delays between compass and propellers make both motors oscillate permanently, even in a
//! flat calm; that wears the drives and costs energy and top speed, without a visible cross-track error. Here the
//! controller holds a course from rest, then turns by a step, at three speeds, in still water with a compass without
//! errors: any motion at the end of a stretch is caused by the controller.

use crate::setup;
use config::Config;
use config::schema::control::{SHARE_SATURATION, course_speed, course_speed_force};
use config::schema::simulate::gps;
use control::{
    CourseSpeed, CourseSpeedConfig, Drive, MotorActivity, MotorPair, PidConfig, Setpoint, Sharing, YawTarget,
};
use devices::{Reading, Side};
use onboard::{Entity, Navigation, Settings};
use sim::{EnvironmentConfig, Otter, OutputForm, Vessel, VesselConfig};
use std::f64::consts::FRAC_PI_3;
use std::ops::Range;
use std::time::Duration;
use units::{MonoTime, Speed, UtcTime, wrap_pi};

/// The step of the wanted course (rad): a usual corner of a plan, beyond what most files let turn under way.
const STEP_RAD: f64 = FRAC_PI_3;
/// When it comes (s); until then the vessel gathers way and settles.
const STEP_AT_S: f64 = 60.0;
const END_S: f64 = 120.0;
/// Time before the step and before the end in which the vessel counts as settled (s): several periods of any oscillation.
const SETTLED_S: f64 = 20.0;
/// The greatest speed asked for, as a share of what the hull makes at the greatest actuation allowed: the rest
/// is what turning takes.
const TOP_SHARE: f64 = 0.97;
/// Parts of that speed which are tried.
const PARTS: [f64; 3] = [1.0 / 3.0, 2.0 / 3.0, 1.0];
/// A settled controller moves its motors by less than 0.01 of full throttle a second, one that oscillates by far
/// more (1/s).
const MOST_ACTIVITY_PER_S: f64 = 0.03;
/// Nor does the bow of a settled vessel swing (rad).
const MOST_SWING_RAD: f64 = 0.02;
/// Acceptable speed deficit, as a share of the requested speed.
const MOST_MISSING: f64 = 0.05;
/// Position rate of a compass without a configured one (Hz): that of the Otters.
const USUAL_RATE_HZ: u32 = 5;

/// Result of the controller at one speed.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Trial {
    /// Speed asked for (m/s).
    asked_mps: f64,
    /// Mean speed when settled (m/s).
    made_mps: f64,
    /// Motor activity when settled, the larger of both stretches (1/s).
    activity_per_s: f64,
    /// Half of what the bow swings when settled, the larger of both stretches (rad).
    swing_rad: f64,
}

impl Trial {
    /// Whether the controller moves the motors without a reason.
    fn oscillates(&self) -> bool {
        self.activity_per_s > MOST_ACTIVITY_PER_S
    }

    /// Whether the bow still swings though the motors hardly move: the gains are too low to settle.
    fn is_unsettled(&self) -> bool {
        !self.oscillates() && self.swing_rad > MOST_SWING_RAD
    }

    /// Whether the vessel does not reach the requested speed.
    fn is_slow(&self) -> bool {
        self.made_mps < (1.0 - MOST_MISSING) * self.asked_mps
    }
}

/// Faults of the configured controller on the model of the hull, each in a line with figures and remedy; none for a sound
/// one.
pub(crate) fn doubts(config: &Config, settings: &Settings) -> Vec<String> {
    let tried = hull(config).and_then(|hull| {
        let trials = trials(settings, &hull)?;
        let Some(faults) = faults(&trials) else { return Ok(Vec::new()) };
        Ok(vec![format!("{} {faults}. {}", section(config, settings), remedy(settings, &hull)?)])
    });
    tried.unwrap_or_else(|error| {
        vec![format!("the controller was not tried on the model of the hull: {error:#}")]
    })
}

/// The simulated vessel of the files; in a profile without one, the usual hull and compass.
fn hull(config: &Config) -> anyhow::Result<VesselConfig> {
    let mut hull = setup::vessel(config, UtcTime::default(), 1)?;
    if config.running(&gps::GPS).next().is_none() {
        hull.gnss.rate_hz = USUAL_RATE_HZ;
    }
    Ok(hull)
}

/// The section of the gains.
fn section(config: &Config, settings: &Settings) -> String {
    let specs = [&course_speed::COURSE_SPEED, &course_speed_force::COURSE_SPEED_FORCE];
    let running = specs.into_iter().find_map(|spec| config.running(spec).next());
    let name = running.map_or_else(|| settings.labels.of(Entity::Control), |section| section.name());
    format!("[{name}]")
}

/// The faults, by the worst trial of each kind.
fn faults(trials: &[Trial]) -> Option<String> {
    let by =
        |figure: fn(&Trial) -> f64| move |one: &&Trial, other: &&Trial| figure(one).total_cmp(&figure(other));
    let mut faults = Vec::new();
    if let Some(worst) =
        trials.iter().filter(|trial| trial.oscillates()).max_by(by(|trial| trial.activity_per_s))
    {
        faults.push(format!(
            "it oscillates: at {:.1} m/s each motor changes by {:.2} of full throttle a second for ever, and the \
             heading swings by {:.1}° to each side",
            worst.asked_mps,
            worst.activity_per_s,
            worst.swing_rad.to_degrees()
        ));
    }
    if let Some(worst) =
        trials.iter().filter(|trial| trial.is_unsettled()).max_by(by(|trial| trial.swing_rad))
    {
        faults.push(format!(
            "it does not settle: at {:.1} m/s the heading still moves by {:.1}° {:.0} s after a turn",
            worst.asked_mps,
            2.0 * worst.swing_rad.to_degrees(),
            END_S - STEP_AT_S - SETTLED_S
        ));
    }
    if let Some(worst) = trials.iter().filter(|trial| trial.is_slow()).max_by(by(|trial| trial.asked_mps)) {
        faults.push(format!("asked for {:.1} m/s it makes {:.1} m/s", worst.asked_mps, worst.made_mps));
    }
    (!faults.is_empty()).then(|| format!("on the model of the hull in a flat calm {}", faults.join("; ")))
}

/// The default gains if they help, with priority for turning if needed; else a general remedy.
fn remedy(settings: &Settings, hull: &VesselConfig) -> anyhow::Result<String> {
    let (usual, speed) = match settings.control.drive {
        Drive::Rpm { .. } => (CourseSpeedConfig::fossen_rpm(), course_speed::SPEED_GAINS.spec.name),
        Drive::Force { .. } => (CourseSpeedConfig::fossen_force(), course_speed_force::SPEED_GAINS.spec.name),
    };
    let mut mended = settings.clone();
    let gains = |pid: &mut PidConfig, usual: &PidConfig| {
        (pid.kp, pid.ki, pid.kd) = (usual.kp, usual.ki, usual.kd);
        format!("{}, {}, {}", pid.kp, pid.ki, pid.kd)
    };
    let yaw_gains = gains(&mut mended.control.yaw.pid, &usual.yaw.pid);
    let speed_gains = gains(&mut mended.control.speed.pid, &usual.speed.pid);
    let usual_gains =
        format!("`{} = {yaw_gains}` and `{speed} = {speed_gains}`", course_speed::YAW_GAINS.spec.name);
    if faults(&trials(&mended, hull)?).is_none() {
        return Ok(format!("{usual_gains} mend it"));
    }
    mended.control.output.sharing = Sharing::TurnFirst;
    if faults(&trials(&mended, hull)?).is_none() {
        return Ok(format!("{usual_gains} with `{} = true` mend it", SHARE_SATURATION.spec.name));
    }
    let rate_hz = hull.gnss.rate_hz;
    Ok(if rate_hz < USUAL_RATE_HZ {
        format!(
            "The compass gives {rate_hz} Hz: {usual_gains} need {USUAL_RATE_HZ} Hz, less asks for weaker ones"
        )
    } else {
        format!("{usual_gains} do not suffice: a limit or the ramp of this section is too tight")
    })
}

/// Tries the controller at three speeds up to the greatest that hull, actuation and limits allow.
fn trials(settings: &Settings, vessel: &VesselConfig) -> anyhow::Result<Vec<Trial>> {
    let mut calm =
        VesselConfig { environment: EnvironmentConfig::default(), heading_rad: 0.0, ..vessel.clone() };
    calm.gnss = calm.gnss.perfect();
    calm.form = OutputForm::Values;
    calm.fish.clear();
    let reach_mps = Otter::new(calm.payload_kg)?.steady_speed_mps(settings.control.output.max_actuation);
    let limit_mps = settings.watch.limits.max_speed_mps.unwrap_or(f64::INFINITY);
    let top_mps = limit_mps.min(TOP_SHARE * reach_mps);
    PARTS.into_iter().map(|part| sail(settings, &calm, part * top_mps)).collect()
}

/// A vessel under trial.
struct Sailing {
    vessel: Vessel,
    navigation: Navigation,
    control: CourseSpeed,
    asked_mps: f64,
}

/// A stretch on which the vessel should have settled.
#[derive(Default)]
struct Settled {
    activity: MotorActivity,
    /// Least and greatest deviation of the heading from the wanted course (rad).
    deviation_rad: Option<(f64, f64)>,
    speeds_mps: Vec<f64>,
}

fn sail(settings: &Settings, vessel: &VesselConfig, asked_mps: f64) -> anyhow::Result<Trial> {
    let mut control = CourseSpeed::new(settings.control)?;
    control.enable(MotorPair::STOPPED);
    let navigation = Navigation::new(settings.navigation);
    let mut sailing = Sailing { vessel: Vessel::new(vessel)?, navigation, control, asked_mps };
    let period = Duration::from_secs_f64(1.0 / settings.navigation.rate_hz.clamp(2.5, 25.0));
    let ahead = sailing.settle(period, 0.0, STEP_AT_S - SETTLED_S..STEP_AT_S);
    let turned = sailing.settle(period, STEP_RAD, END_S - SETTLED_S..END_S);
    let both = [&ahead, &turned];
    let speeds = both.iter().flat_map(|settled| &settled.speeds_mps);
    let count = both.iter().map(|settled| settled.speeds_mps.len()).sum::<usize>().max(1);
    Ok(Trial {
        asked_mps,
        made_mps: speeds.sum::<f64>() / count as f64,
        activity_per_s: both.iter().filter_map(|settled| settled.activity.per_s()).fold(0.0, f64::max),
        swing_rad: both.iter().map(|settled| settled.swing_rad()).fold(0.0, f64::max),
    })
}

impl Sailing {
    /// Holds a course until the end of a stretch, and returns its figures.
    fn settle(&mut self, period: Duration, course_rad: f64, stretch_s: Range<f64>) -> Settled {
        let wanted = Setpoint {
            yaw: Some(YawTarget::Course { course_rad, turn_rate_rad_s: 0.0 }),
            speed: Some(Speed::MetresPerSecond(self.asked_mps)),
        };
        let mut settled = Settled::default();
        loop {
            self.vessel.step(period);
            let now = self.vessel.now();
            let now_s = now.since(MonoTime::default()).as_secs_f64();
            if now_s > stretch_s.end {
                return settled;
            }
            let motors = self.steer(&wanted);
            if now_s >= stretch_s.start {
                settled.activity.see(now, motors);
                let truth = self.vessel.truth();
                settled.see(wrap_pi(truth.heading_rad - course_rad), truth.speed_mps);
            }
        }
    }

    /// One step of navigation and controller, as aboard.
    fn steer(&mut self, wanted: &Setpoint) -> MotorPair {
        while let Some(timed) = self.vessel.poll_output() {
            if let sim::Output::Reading(Reading::Gnss(reading)) = timed.output {
                // A position that navigation rejects is bridged by dead reckoning.
                self.navigation.read(timed.at, &reading).ok();
            }
        }
        let now = self.vessel.now();
        let [port_rpm, starboard_rpm] = Side::BOTH.map(|side| self.vessel.motor(side).propeller_rpm);
        let mean_rpm = f64::midpoint(port_rpm, starboard_rpm);
        let output = self
            .navigation
            .estimate(now)
            .and_then(|estimate| self.control.update(now, &estimate.motion, wanted, Some(mean_rpm)).ok());
        let motors = output.map_or(MotorPair::STOPPED, |output| output.motors);
        // The controller keeps its motors within -1 to 1.
        self.vessel.command(motors.port, motors.starboard).ok();
        motors
    }
}

impl Settled {
    fn see(&mut self, deviation_rad: f64, speed_mps: f64) {
        let (least, most) = self.deviation_rad.unwrap_or((deviation_rad, deviation_rad));
        self.deviation_rad = Some((least.min(deviation_rad), most.max(deviation_rad)));
        self.speeds_mps.push(speed_mps);
    }

    fn swing_rad(&self) -> f64 {
        self.deviation_rad.map_or(0.0, |(least, most)| (most - least) / 2.0)
    }
}

#[cfg(test)]
mod tests;
