//! The parameters that can be read and changed while the vessel runs, under the names of the files.
//!
//! One table serves consoles (Query-, Set- and SaveEntityParameters) and the reader of the configuration: a
//! name, a range, and where the value lives in [`Settings`]. Values are texts on the wire; angles are in
//! degrees there and radians here. A value out of range, or one that a controller refuses, changes nothing.

use crate::entity::Entity;
use crate::settings::Settings;
use control::{CourseTracking, Drive, FeedForward, Law, PidConfig};
use std::ops::RangeInclusive;
use std::time::Duration;

/// A parameter.
#[derive(Clone)]
pub struct Parameter {
    /// Whose it is.
    pub entity: Entity,
    /// Its name.
    pub name: &'static str,
    place: Place,
}

/// Where a value lives.
#[derive(Clone)]
enum Place {
    /// A number: the value times the factor is what is kept.
    Number(fn(&mut Settings) -> Option<&mut f64>, f64, RangeInclusive<f64>),
    /// Seconds.
    Span(fn(&mut Settings) -> Option<&mut Duration>, RangeInclusive<f64>),
    /// Proportional, integral and derivative gain.
    Gains(fn(&mut Settings) -> Option<&mut PidConfig>),
    /// A limit that 0 or a value below switches off.
    Limit(fn(&mut Settings) -> Option<&mut Option<f64>>, RangeInclusive<f64>),
}

/// Why a value was not taken.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ParameterError {
    /// There is none of this name, or not in this setup.
    #[error("there is no parameter '{0}'")]
    Unknown(String),
    /// It is no number.
    #[error("'{0}' is no number")]
    NoNumber(String),
    /// It is out of range.
    #[error("{value} is not within {least} to {most}")]
    Range {
        /// The value.
        value: f64,
        /// The least allowed.
        least: f64,
        /// The most allowed.
        most: f64,
    },
    /// Gains are three numbers.
    #[error("three numbers are needed")]
    Gains,
    /// A controller refuses it.
    #[error("{0}")]
    Refused(String),
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// All parameters.
pub fn all() -> Vec<Parameter> {
    [control_loops(), path_control(), navigation(), watching(), maneuvers()].concat()
}

fn number(
    entity: Entity,
    name: &'static str,
    at: fn(&mut Settings) -> Option<&mut f64>,
    factor: f64,
    range: RangeInclusive<f64>,
) -> Parameter {
    Parameter { entity, name, place: Place::Number(at, factor, range) }
}

fn span(
    entity: Entity,
    name: &'static str,
    at: fn(&mut Settings) -> Option<&mut Duration>,
    range: RangeInclusive<f64>,
) -> Parameter {
    Parameter { entity, name, place: Place::Span(at, range) }
}

fn gains(entity: Entity, name: &'static str, at: fn(&mut Settings) -> Option<&mut PidConfig>) -> Parameter {
    Parameter { entity, name, place: Place::Gains(at) }
}

fn limit(
    entity: Entity,
    name: &'static str,
    at: fn(&mut Settings) -> Option<&mut Option<f64>>,
    range: RangeInclusive<f64>,
) -> Parameter {
    Parameter { entity, name, place: Place::Limit(at, range) }
}

fn control_loops() -> Vec<Parameter> {
    const OF: Entity = Entity::Control;
    vec![
        gains(OF, "Yaw PID Gains", |s| Some(&mut s.control.yaw.pid)),
        gains(OF, "MPS PID Gains", |s| rpm(s).then_some(&mut s.control.speed.pid)),
        gains(OF, "MPS Force PID Gains", |s| (!rpm(s)).then_some(&mut s.control.speed.pid)),
        limit(
            OF,
            "MPS Integral Limit",
            |s| rpm(s).then_some(&mut s.control.speed.pid.integral_limit),
            0.0..=2000.0,
        ),
        limit(
            OF,
            "MPS Force Integral Limit",
            |s| (!rpm(s)).then_some(&mut s.control.speed.pid.integral_limit),
            0.0..=1000.0,
        ),
        limit(OF, "Yaw Integral Limit", |s| Some(&mut s.control.yaw.pid.integral_limit), 0.0..=500.0),
        limit(OF, "Ramp Actuation Limit", |s| Some(&mut s.control.output.ramp_per_s), 0.01..=100.0),
        number(OF, "MPS Feedforward Gain", feed_forward, 1.0, 0.0..=10_000.0),
        number(
            OF,
            "Maximum Heading Error to Thrust",
            |s| Some(&mut s.control.yaw.max_error_to_thrust_rad),
            DEGREE,
            5.0..=180.0,
        ),
        number(
            OF,
            "Maximum Thrust Actuation",
            |s| Some(&mut s.control.output.max_actuation),
            1.0,
            0.01..=1.0,
        ),
        number(OF, "Minimum speed to use course", course_speed, 1.0, 0.0..=5.0),
        number(
            Entity::Remote,
            "Connection Timeout",
            |s| Some(&mut s.remote.connection_timeout_s),
            1.0,
            0.2..=10.0,
        ),
        number(Entity::Remote, "Thrust Scale", |s| Some(&mut s.remote.thrust_scale), 1.0, 0.01..=1.0),
    ]
}

fn path_control() -> Vec<Parameter> {
    const OF: Entity = Entity::Path;
    vec![
        number(OF, "ILOS Lookahead Distance", |s| ilos(s).map(|ilos| &mut ilos.lookahead_m), 1.0, 1.0..=50.0),
        number(OF, "ILOS Integrator Gain", |s| ilos(s).map(|ilos| &mut ilos.integrator_gain), 1.0, 0.0..=4.0),
        number(OF, "Corridor -- Width", |s| ilos(s).map(|ilos| &mut ilos.corridor.width_m), 1.0, 1.0..=50.0),
        number(
            OF,
            "Corridor -- Entry Angle",
            |s| ilos(s).map(|ilos| &mut ilos.corridor.entry_angle_rad),
            DEGREE,
            2.0..=45.0,
        ),
        number(OF, "Time Of Arrival Factor", |s| Some(&mut s.path.time_of_arrival_factor_s), 1.0, 0.0..=30.0),
        number(OF, "ETA Minimum Speed", |s| Some(&mut s.path.eta_min_speed_mps), 1.0, 0.01..=5.0),
        number(OF, "New Reference Timeout", |s| Some(&mut s.path.new_path_timeout_s), 1.0, 3.0..=10.0),
        number(OF, "Position Jump Threshold", |s| Some(&mut s.path.jump.threshold_m), 1.0, 1.0..=100.0),
    ]
}

fn navigation() -> Vec<Parameter> {
    const OF: Entity = Entity::Navigation;
    vec![
        number(OF, "Maximum HDOP", |s| Some(&mut s.navigation.max_hdop), 1.0, 0.5..=100.0),
        number(OF, "Dead Reckoning Time", |s| Some(&mut s.navigation.reckoning_s), 1.0, 1.0..=60.0),
        number(
            OF,
            "Distance To Reset Origin",
            |s| Some(&mut s.navigation.origin_distance_m),
            1.0,
            500.0..=100_000.0,
        ),
        number(OF, "Position Jump Speed", |s| Some(&mut s.navigation.jump_speed_mps), 1.0, 1.0..=100.0),
    ]
}

fn watching() -> Vec<Parameter> {
    const FUEL: Entity = Entity::Fuel;
    vec![
        number(FUEL, "Warning Level", |s| Some(&mut s.watch.battery.low), 0.01, 0.0..=100.0),
        number(FUEL, "Reserve Level", |s| Some(&mut s.watch.battery.reserve), 0.01, 0.0..=100.0),
        number(FUEL, "Error Level", |s| Some(&mut s.watch.battery.critical), 0.01, 0.0..=100.0),
        limit(Entity::Limits, "Maximum Speed", |s| Some(&mut s.watch.limits.max_speed_mps), 0.1..=20.0),
        number(
            Entity::Clock,
            "Maximum Clock Offset",
            |s| Some(&mut s.watch.clock_offset_s),
            1.0,
            0.0..=86_400.0,
        ),
        number(
            Entity::Host,
            "Storage Warning Level",
            |s| Some(&mut s.watch.disk_free_percent),
            1.0,
            0.0..=100.0,
        ),
        span(Entity::Udp, "Contact Timeout", |s| Some(&mut s.node.contact_timeout), 1.0..=3600.0),
        span(
            Entity::Announcer,
            "Announcement Periodicity",
            |s| Some(&mut s.node.announce_period),
            1.0..=600.0,
        ),
    ]
}

fn maneuvers() -> Vec<Parameter> {
    const OF: Entity = Entity::Maneuver;
    vec![
        number(
            OF,
            "Loiter -- Minimum Radius",
            |s| Some(&mut s.mission.engine.maneuver.loiter_min_radius_m),
            1.0,
            1.0..=1000.0,
        ),
        number(
            OF,
            "StationKeeping -- Minimum Radius",
            |s| Some(&mut s.mission.engine.maneuver.station_min_radius_m),
            1.0,
            1.0..=1000.0,
        ),
        number(
            OF,
            "Horizontal Tolerance",
            |s| Some(&mut s.mission.engine.maneuver.reference.tolerance_m),
            1.0,
            1.0..=1000.0,
        ),
        number(OF, "Hold Radius", |s| Some(&mut s.mission.hold_radius_m), 1.0, 1.0..=1000.0),
    ]
}

fn rpm(settings: &Settings) -> bool {
    matches!(settings.control.drive, Drive::Rpm { .. })
}

fn ilos(settings: &mut Settings) -> Option<&mut control::IlosConfig> {
    match &mut settings.guidance.leg {
        Law::Ilos(ilos) => Some(ilos),
        Law::PurePursuit | Law::VectorField(_) => None,
    }
}

fn feed_forward(settings: &mut Settings) -> Option<&mut f64> {
    match &mut settings.control.speed.feed_forward {
        FeedForward::Gain(gain) => Some(gain),
        FeedForward::Table(_) => None,
    }
}

fn course_speed(settings: &mut Settings) -> Option<&mut f64> {
    match &mut settings.control.yaw.course_tracking {
        CourseTracking::Filtered { min_speed_mps, .. } => Some(min_speed_mps),
        CourseTracking::AsHeading => None,
    }
}

impl Parameter {
    /// The value as text; `None` where this setup has none.
    pub fn get(&self, settings: &Settings) -> Option<String> {
        // The places are given to be written; reading them is rare.
        let mut settings = settings.clone();
        Some(match &self.place {
            Place::Number(at, factor, _) => short(*at(&mut settings)? / factor),
            Place::Span(at, _) => short(at(&mut settings)?.as_secs_f64()),
            Place::Gains(at) => {
                let pid = at(&mut settings)?;
                format!("{}, {}, {}", short(pid.kp), short(pid.ki), short(pid.kd))
            }
            Place::Limit(at, _) => short(at(&mut settings)?.unwrap_or(-1.0)),
        })
    }

    /// Takes a value from text.
    ///
    /// # Errors
    /// When it is none that this parameter may have; the settings are then as they were.
    pub fn set(&self, settings: &mut Settings, text: &str) -> Result<(), ParameterError> {
        let missing = || ParameterError::Unknown(self.name.to_owned());
        match &self.place {
            Place::Number(at, factor, range) => {
                let value = within(parse(text)?, range)?;
                *at(settings).ok_or_else(missing)? = value * factor;
            }
            Place::Span(at, range) => {
                let value = within(parse(text)?, range)?;
                *at(settings).ok_or_else(missing)? = Duration::from_secs_f64(value);
            }
            Place::Gains(at) => {
                let values = text.split(',').map(parse).collect::<Result<Vec<_>, _>>()?;
                let [kp, ki, kd] = values[..] else { return Err(ParameterError::Gains) };
                for value in [kp, ki, kd] {
                    within(value, &(0.0..=100_000.0))?;
                }
                let pid = at(settings).ok_or_else(missing)?;
                (pid.kp, pid.ki, pid.kd) = (kp, ki, kd);
            }
            Place::Limit(at, range) => {
                let value = parse(text)?;
                let limit = if value <= 0.0 { None } else { Some(within(value, range)?) };
                *at(settings).ok_or_else(missing)? = limit;
            }
        }
        Ok(())
    }
}

fn parse(text: &str) -> Result<f64, ParameterError> {
    let value: f64 = text.trim().parse().map_err(|_| ParameterError::NoNumber(text.trim().to_owned()))?;
    if value.is_finite() { Ok(value) } else { Err(ParameterError::NoNumber(text.trim().to_owned())) }
}

fn within(value: f64, range: &RangeInclusive<f64>) -> Result<f64, ParameterError> {
    if range.contains(&value) {
        Ok(value)
    } else {
        Err(ParameterError::Range { value, least: *range.start(), most: *range.end() })
    }
}

/// A number without the noise of its last bits.
fn short(value: f64) -> String {
    let rounded = (value * 1e9).round() / 1e9;
    format!("{rounded}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use imc::Address;

    fn settings() -> Settings {
        Settings::otter("test", Address(0x2810))
    }

    #[test]
    fn every_value_in_use_is_allowed_and_returns_as_it_was() {
        let settings = settings();
        for parameter in all() {
            let Some(text) = parameter.get(&settings) else { continue };
            let mut again = settings.clone();
            assert_eq!(parameter.set(&mut again, &text), Ok(()), "{}", parameter.name);
            assert_eq!(parameter.get(&again), Some(text), "{}", parameter.name);
        }
    }

    #[test]
    fn refuses_what_is_no_number_or_out_of_range() {
        let mut settings = settings();
        let before = settings.clone();
        let all = all();
        let lookahead = all.iter().find(|parameter| parameter.name == "ILOS Lookahead Distance").unwrap();
        for bad in ["", "x", "NaN", "inf", "0", "51", "3 m"] {
            assert!(lookahead.set(&mut settings, bad).is_err(), "{bad}");
        }
        let yaw = all.iter().find(|parameter| parameter.name == "Yaw PID Gains").unwrap();
        for bad in ["1, 2", "1, 2, x", "1, 2, 3, 4", "-1, 0, 0"] {
            assert!(yaw.set(&mut settings, bad).is_err(), "{bad}");
        }
        assert_eq!(settings, before);
        lookahead.set(&mut settings, " 12.5 ").unwrap();
        assert_eq!(lookahead.get(&settings).unwrap(), "12.5");
    }
}
