//! From a place on a path to a desired course, by the law that the configuration names.
//!
//! All laws answer a *course*, the direction to go over ground. How the crab angle between bow and course is
//! found is left to the yaw loop ([`CourseTracking`](crate::CourseTracking)).

use crate::circle::CircleConfig;
use crate::ilos::{Ilos, IlosConfig};
use crate::motion::Motion;
use crate::path::{Geometry, PathStatus};
use crate::pure_pursuit;
use crate::range::{InvalidConfig, RangeCheck};
use crate::steering::Steering;
use crate::vector_field::VectorFieldConfig;
use units::MonoTime;

/// Integrators take no step longer than this (s); a longer pause says nothing about the error within.
const LONGEST_STEP_S: f64 = 2.0;
/// Integrators wait below this speed over ground (m/s): a vessel that does not move learns nothing.
const LEAST_SPEED_MPS: f64 = 0.1;

/// Law on straight legs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Law {
    /// Integral line of sight.
    Ilos(IlosConfig),
    /// Straight for the end.
    PurePursuit,
    /// Vector field.
    VectorField(VectorFieldConfig),
}

/// Laws on legs and circles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GuidanceConfig {
    /// Straight legs.
    pub leg: Law,
    /// Circles.
    pub circle: CircleConfig,
}

impl Default for GuidanceConfig {
    /// Integral line of sight, tuned on Fossen's Otter.
    fn default() -> Self {
        Self { leg: Law::Ilos(IlosConfig::otter()), circle: CircleConfig::otter() }
    }
}

impl GuidanceConfig {
    /// Whether every value is within its range.
    ///
    /// # Errors
    /// Names every value that is not.
    pub fn validate(&self) -> Result<(), InvalidConfig> {
        let mut check = RangeCheck::default();
        match &self.leg {
            Law::Ilos(config) => check.within("ilos", |check| config.check(check)),
            Law::VectorField(config) => check.within("vector_field", |check| config.check(check)),
            Law::PurePursuit => {}
        }
        check.within("circle", |check| self.circle.check(check));
        check.finish()
    }
}

/// A guidance law with its memory.
#[derive(Debug, Clone)]
pub struct Guidance {
    config: GuidanceConfig,
    leg: Ilos,
    circle: Ilos,
    last: Option<MonoTime>,
}

impl Guidance {
    /// A law at rest.
    ///
    /// # Errors
    /// When values of `config` are out of range.
    pub fn new(config: GuidanceConfig) -> Result<Self, InvalidConfig> {
        config.validate()?;
        let leg = match &config.leg {
            Law::Ilos(ilos) => Ilos::starting(ilos),
            Law::PurePursuit | Law::VectorField(_) => Ilos::default(),
        };
        Ok(Self { config, leg, circle: Ilos::default(), last: None })
    }

    /// The parameters in use.
    pub fn config(&self) -> &GuidanceConfig {
        &self.config
    }

    /// New parameters; the integrators start again only when the law is another.
    ///
    /// # Errors
    /// When values of `config` are out of range; the old ones then stay in use.
    pub fn reconfigure(&mut self, config: GuidanceConfig) -> Result<(), InvalidConfig> {
        if std::mem::discriminant(&config.leg) == std::mem::discriminant(&self.config.leg) {
            config.validate()?;
            self.config = config;
        } else {
            *self = Self::new(config)?;
        }
        Ok(())
    }

    /// Another path begins: integrators start again where so configured.
    pub fn new_path(&mut self) {
        self.circle.clear();
        match &self.config.leg {
            Law::Ilos(config) if !config.reset_on_new_path => {}
            Law::Ilos(config) => self.leg = Ilos::starting(config),
            Law::PurePursuit | Law::VectorField(_) => {}
        }
    }

    /// The cross-track integrator on legs (m s); 0 for laws without one.
    pub fn integral(&self) -> f64 {
        self.leg.integral()
    }

    /// Where to go at `now`, for a vessel that moves as `motion` and is on its path as `status` says.
    pub fn steer(&mut self, now: MonoTime, status: &PathStatus, motion: &Motion) -> Steering {
        let elapsed_s = self.last.map_or(0.0, |last| now.since(last).as_secs_f64());
        self.last = Some(now);
        let learns = elapsed_s <= LONGEST_STEP_S && motion.speed_over_ground_mps() >= LEAST_SPEED_MPS;
        let dt_s = if learns { elapsed_s } else { 0.0 };
        match &status.geometry {
            Geometry::Circle(circle) => self.config.circle.steer(&mut self.circle, circle, motion, dt_s),
            Geometry::Leg(leg) => {
                let course_rad = match &self.config.leg {
                    Law::Ilos(config) => self.leg.course_rad(config, leg, dt_s),
                    Law::PurePursuit => pure_pursuit::course_rad(leg),
                    Law::VectorField(config) => config.course_rad(leg, motion),
                };
                Steering { course_rad, turn_rate_rad_s: 0.0 }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::{Fix, PathCommand, PathConfig, PathEnd, PathStart, PathTracker};
    use units::LatLon;

    fn status(east_deg: f64) -> PathStatus {
        let place = |lat_deg, lon_deg| LatLon::from_deg(lat_deg, lon_deg).unwrap();
        let motion = Motion::from_course(0.0, None, 0.0, 1.0);
        let command = PathCommand {
            path_ref: 1,
            start: PathStart::At(place(63.33, 10.0)),
            end: PathEnd::At(place(63.34, 10.0)),
            loiter: None,
        };
        let fix = Fix { place: place(63.331, 10.0 + east_deg), motion, variance_m2: None };
        let mut tracker = PathTracker::new(PathConfig::default()).unwrap();
        tracker.start(MonoTime::from_micros(0), &command, &fix).unwrap()
    }

    fn moving(speed_mps: f64) -> Motion {
        Motion::from_course(0.0, None, 0.0, speed_mps)
    }

    #[test]
    fn every_law_steers_back_from_starboard_to_the_track() {
        for leg in [
            Law::Ilos(IlosConfig::otter()),
            Law::Ilos(IlosConfig::thesis()),
            Law::Ilos(IlosConfig::ntnu()),
            Law::PurePursuit,
            Law::VectorField(VectorFieldConfig::otter()),
        ] {
            let mut guidance = Guidance::new(GuidanceConfig { leg, ..GuidanceConfig::default() }).unwrap();
            let got = guidance.steer(MonoTime::from_micros(0), &status(5e-5), &moving(1.0));
            assert!(got.course_rad < 0.0 && got.course_rad > -1.5, "{leg:?}: {got:?}");
        }
    }

    #[test]
    fn integrator_waits_for_time_and_speed_and_starts_anew_on_a_path() {
        let mut guidance = Guidance::new(GuidanceConfig::default()).unwrap();
        let near = status(1e-5);
        for (t_ms, speed_mps, grows) in
            [(0, 1.0, false), (100, 1.0, true), (200, 0.05, false), (300, 1.0, true), (9_000, 1.0, false)]
        {
            let before = guidance.integral();
            guidance.steer(MonoTime::from_micros(t_ms * 1000), &near, &moving(speed_mps));
            assert_eq!(guidance.integral() > before, grows, "{t_ms} ms");
        }
        let mut kept = guidance.clone();
        kept.reconfigure(GuidanceConfig { leg: Law::Ilos(IlosConfig::thesis()), ..*kept.config() }).unwrap();
        kept.new_path();
        assert!(kept.integral() > 0.0);
        guidance.new_path();
        assert!(guidance.integral().abs() < 1e-12);
    }

    #[test]
    fn refuses_values_out_of_range() {
        let mut config = GuidanceConfig::default();
        config.circle.corridor.width_m = 0.0;
        config.leg = Law::Ilos(IlosConfig { lookahead_m: f64::NAN, ..IlosConfig::otter() });
        let problems = Guidance::new(config).unwrap_err().problems;
        let names: Vec<_> = problems.iter().map(|problem| problem.parameter.as_str()).collect();
        assert_eq!(names, ["ilos.lookahead", "circle.corridor.width"]);
    }
}
