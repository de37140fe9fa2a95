//! The parameters that can be read and changed while the vessel runs, under the names of the files.
//!
//! Name, range and unit are those of [`config::schema`], which the files are read by as well: there is no
//! second definition. This table adds where a value lives in [`Settings`] and who may change it. Values are
//! texts on the wire; angles are in degrees there and radians here. A value out of range, or one that a
//! controller refuses, changes nothing.
//!
//! Parameters that keep the vessel safe (speed limit, battery levels, gates of the navigation) are
//! [file-only](Access::FileOnly): any host that can send a packet can change a parameter, but none can send a file.

mod saving;
mod service;
mod stack;
mod voyage;

pub(crate) use service::{Live, ParameterService};

use crate::entity::Entity;
use crate::settings::Settings;
use charts::depth_index::{ChartTrust, EntryRule, EntryRules};
use config::schema::{
    common, control as loops, control::course_speed, control::course_speed_force, control::remote, general,
    mission::maneuver, path, path::ilos, path::vector_field, transport, watch,
};
use config::{ParamSpec, SectionSpec};
use control::{CourseTracking, Drive, FeedForward, Law, PidConfig, SpeedTable};
use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

/// A parameter.
#[derive(Clone)]
pub struct Parameter {
    /// Its entity.
    pub entity: Entity,
    /// Its name.
    pub name: &'static str,
    /// The sections of the files that may have it.
    pub homes: &'static [&'static SectionSpec],
    /// Who may change it.
    pub access: Access,
    spec: ParamSpec,
    place: Place,
}

/// Who may change a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// Consoles and plans, at any time.
    Live,
    /// The files, at the next start.
    FileOnly,
}

/// Where a value lives.
#[derive(Clone)]
enum Place {
    /// A number: the value times the factor is what is kept.
    Number(fn(&mut Settings) -> Option<&mut f64>, f64),
    /// Seconds.
    Span(fn(&mut Settings) -> Option<&mut Duration>),
    /// Proportional, integral and derivative gain.
    Gains(fn(&mut Settings) -> Option<&mut PidConfig>),
    /// A limit that this value or one below switches off.
    Limit(fn(&mut Settings) -> Option<&mut Option<f64>>, f64),
    /// A number that decides more than a number.
    Choice(fn(&Settings) -> Option<f64>, fn(&mut Settings, f64)),
    /// One of the schema's words.
    Word(fn(&Settings) -> &'static str, fn(&mut Settings, &str)),
}

/// Why a value was not taken.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ParameterError {
    /// There is no parameter of this name, or not in this setup.
    #[error("there is no parameter '{0}'")]
    Unknown(String),
    /// It cannot be changed while the vessel runs.
    #[error("'{0}' is set in the configuration file only; change it there and start again")]
    FileOnly(String),
    /// The schema has no such value.
    #[error("{0}")]
    Value(String),
    /// A controller or another parameter forbids it.
    #[error("{0}")]
    Refused(String),
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;
const PERCENT: f64 = 0.01;
/// Below this speed a course over ground is noise (m/s); the least that the controller takes.
const LEAST_COURSE_SPEED_MPS: f64 = 0.05;
const COURSE_FILTER_S: f64 = 3.0;

type Homes = &'static [&'static SectionSpec];
const CONTROL: Homes = &[&course_speed::COURSE_SPEED, &course_speed_force::COURSE_SPEED_FORCE];
const RPM: Homes = &[&course_speed::COURSE_SPEED];
const FORCE: Homes = &[&course_speed_force::COURSE_SPEED_FORCE];
const REMOTE: Homes = &[&remote::REMOTE];
const PATHS: Homes = &[&ilos::ILOS, &path::PURE_PURSUIT, &vector_field::VECTOR_FIELD];
const ILOS: Homes = &[&ilos::ILOS];
const CORRIDORS: Homes = &[&ilos::ILOS, &vector_field::VECTOR_FIELD];
const GENERAL: Homes = &[&general::GENERAL];
const FUEL: Homes = &[&watch::fuel::FUEL];
const LIMITS: Homes = &[&watch::limits::LIMITS];
const GROUNDING: Homes = &[&watch::grounding::GROUNDING];
const LOST_COMMS: Homes = &[&watch::lost_comms::LOST_COMMS];
const CLOCK: Homes = &[&watch::clock::CLOCK];
const HOST: Homes = &[&watch::host::HOST];
const UDP: Homes = &[&transport::udp::UDP];
const ANNOUNCE: Homes = &[&transport::announce::ANNOUNCE];
const MULTIPLEXER: Homes = &[&maneuver::MULTIPLEXER];
const FOLLOW_REFERENCE: Homes = &[&maneuver::FOLLOW_REFERENCE];

/// All parameters.
pub fn all() -> Vec<Parameter> {
    [
        control_loops(),
        path_control(),
        voyage::navigation(),
        voyage::engine(),
        watching(),
        grounding(),
        maneuvers(),
    ]
    .concat()
}

/// Takes the parameters that a vessel reported for a part into settings that represent it, and returns the names of those
/// that were taken. A name that is unknown here, or a value that the schema refuses, changes nothing: a vessel of another
/// version may have others.
pub fn take_told<'a>(
    settings: &mut Settings,
    entity: Entity,
    told: impl Iterator<Item = (&'a str, &'a str)>,
) -> BTreeSet<&'static str> {
    let known: BTreeMap<&str, Parameter> =
        all().into_iter().filter(|one| one.entity == entity).map(|one| (one.name, one)).collect();
    let take = |(name, text): (&str, &str)| {
        let parameter = known.get(name)?;
        parameter.set(settings, text).ok().map(|()| parameter.name)
    };
    told.filter_map(take).collect()
}

impl Parameter {
    /// Why a change deserves a second look: what it does at once to a vessel that is under way.
    pub fn caution(&self) -> Option<&'static str> {
        match self.entity {
            Entity::Control | Entity::Remote | Entity::Path => {
                Some("it changes at once how the vessel steers")
            }
            Entity::Maneuver => Some("it changes at once where the vessel keeps itself"),
            Entity::Grounding => Some("it lets the vessel be steered where the chart shows danger"),
            _ => None,
        }
    }

    fn new(entity: Entity, homes: Homes, spec: ParamSpec, place: Place) -> Self {
        Self { entity, name: spec.name, homes, access: Access::Live, spec, place }
    }

    fn file_only(self) -> Self {
        Self { access: Access::FileOnly, ..self }
    }
}

fn control_loops() -> Vec<Parameter> {
    use Place::{Choice, Gains, Limit, Number};
    let of = |homes, spec, place| Parameter::new(Entity::Control, homes, spec, place);
    let remote = |spec, place| Parameter::new(Entity::Remote, REMOTE, spec, place);
    vec![
        of(CONTROL, course_speed::YAW_GAINS.spec, Gains(|s| Some(&mut s.control.yaw.pid))),
        of(RPM, course_speed::SPEED_GAINS.spec, Gains(|s| rpm(s).then_some(&mut s.control.speed.pid))),
        of(
            FORCE,
            course_speed_force::SPEED_GAINS.spec,
            Gains(|s| (!rpm(s)).then_some(&mut s.control.speed.pid)),
        ),
        of(
            RPM,
            course_speed::SPEED_INTEGRAL_LIMIT.spec,
            Limit(|s| rpm(s).then_some(&mut s.control.speed.pid.integral_limit), -1.0),
        ),
        of(
            FORCE,
            course_speed_force::SPEED_INTEGRAL_LIMIT.spec,
            Limit(|s| (!rpm(s)).then_some(&mut s.control.speed.pid.integral_limit), -1.0),
        ),
        of(
            RPM,
            course_speed::YAW_INTEGRAL_LIMIT.spec,
            Limit(|s| rpm(s).then_some(&mut s.control.yaw.pid.integral_limit), -1.0),
        ),
        of(CONTROL, loops::RAMP_LIMIT.spec, Limit(|s| Some(&mut s.control.output.ramp_per_s), 0.0)),
        of(RPM, course_speed::SPEED_FEEDFORWARD.spec, Choice(rpm_for_speed, set_rpm_for_speed)),
        of(FORCE, course_speed_force::SPEED_FEEDFORWARD.spec, Number(force_for_speed, 1.0)),
        of(
            CONTROL,
            loops::MAXIMUM_HEADING_ERROR.spec,
            Number(|s| Some(&mut s.control.yaw.max_error_to_thrust_rad), DEGREE),
        ),
        of(
            CONTROL,
            loops::MAXIMUM_ACTUATION.spec,
            Number(|s| Some(&mut s.control.output.max_actuation), 1.0),
        ),
        of(FORCE, course_speed_force::MINIMUM_COURSE_SPEED.spec, Choice(course_speed, set_course_speed)),
        remote(remote::CONNECTION_TIMEOUT.spec, Number(|s| Some(&mut s.remote.connection_timeout_s), 1.0)),
        remote(remote::LONGEST_AGE.spec, Place::Span(|s| Some(&mut s.longest_key_age))).file_only(),
        remote(remote::THRUST_SCALE.spec, Number(|s| Some(&mut s.remote.thrust_scale), 1.0)),
    ]
}

fn path_control() -> Vec<Parameter> {
    let of = |homes, spec, at, factor| Parameter::new(Entity::Path, homes, spec, Place::Number(at, factor));
    vec![
        of(ILOS, ilos::LOOKAHEAD.spec, |s| ilos_of(s).map(|ilos| &mut ilos.lookahead_m), 1.0),
        of(ILOS, ilos::INTEGRATOR_GAIN.spec, |s| ilos_of(s).map(|ilos| &mut ilos.integrator_gain), 1.0),
        of(CORRIDORS, path::CORRIDOR_WIDTH.spec, |s| corridor(s).map(|corridor| &mut corridor.width_m), 1.0),
        of(
            CORRIDORS,
            path::ENTRY_ANGLE.spec,
            |s| corridor(s).map(|corridor| &mut corridor.entry_angle_rad),
            DEGREE,
        ),
        of(
            GENERAL,
            general::TIME_OF_ARRIVAL_FACTOR.spec,
            |s| Some(&mut s.path.time_of_arrival_factor_s),
            1.0,
        ),
        of(PATHS, path::ETA_MINIMUM_SPEED.spec, |s| Some(&mut s.path.eta_min_speed_mps), 1.0),
        of(PATHS, path::NEW_REFERENCE_TIMEOUT.spec, |s| Some(&mut s.path.new_path_timeout_s), 1.0),
        of(PATHS, path::JUMP_THRESHOLD.spec, |s| Some(&mut s.path.jump.threshold_m), 1.0),
    ]
}

fn watching() -> Vec<Parameter> {
    use Place::{Number, Span};
    let of = Parameter::new;
    let charge = |spec, at| of(Entity::Fuel, FUEL, spec, Number(at, PERCENT)).file_only();
    vec![
        charge(watch::fuel::WARNING_LEVEL.spec, |s| Some(&mut s.watch.battery.low)),
        charge(watch::fuel::RESERVE_LEVEL.spec, |s| Some(&mut s.watch.battery.reserve)),
        charge(watch::fuel::ERROR_LEVEL.spec, |s| Some(&mut s.watch.battery.critical)),
        of(
            Entity::Limits,
            LIMITS,
            watch::limits::MAXIMUM_SPEED.spec,
            Number(|s| s.watch.limits.max_speed_mps.as_mut(), 1.0),
        )
        .file_only(),
        of(
            Entity::LostComms,
            LOST_COMMS,
            watch::lost_comms::HOLD_RADIUS.spec,
            Number(|s| Some(&mut s.mission.hold_radius_m), 1.0),
        ),
        of(
            Entity::Clock,
            CLOCK,
            watch::clock::MAXIMUM_OFFSET.spec,
            Number(|s| Some(&mut s.watch.clock_offset_s), 1.0),
        ),
        of(
            Entity::Clock,
            CLOCK,
            watch::clock::MAXIMUM_PULSE_OFFSET.spec,
            Number(|s| Some(&mut s.watch.pulse_offset_s), 1.0),
        ),
        of(
            Entity::Host,
            HOST,
            watch::host::DISK_WARNING.spec,
            Number(|s| Some(&mut s.watch.disk_free_percent), 1.0),
        ),
        of(
            Entity::Host,
            HOST,
            watch::host::DISK_ERROR.spec,
            Number(|s| Some(&mut s.watch.disk_error_percent), 1.0),
        ),
        of(
            Entity::Host,
            HOST,
            watch::host::MEMORY_WARNING.spec,
            Number(|s| Some(&mut s.watch.memory_free_percent), 1.0),
        ),
        of(
            Entity::Udp,
            UDP,
            transport::udp::CONTACT_TIMEOUT.spec,
            Span(|s| Some(&mut s.node.contact_timeout)),
        ),
        of(
            Entity::Announcer,
            ANNOUNCE,
            transport::announce::PERIOD.spec,
            Span(|s| Some(&mut s.node.announce_period)),
        ),
    ]
}

fn grounding() -> Vec<Parameter> {
    use watch::grounding as schema;
    let new = |spec, place| Parameter::new(Entity::Grounding, GROUNDING, spec, place);
    let of = |spec, at| new(spec, Place::Number(at, 1.0));
    vec![
        of(schema::NAVIGABLE.spec, |s| Some(&mut s.grounding.limits.navigable_m)).file_only(),
        of(schema::AUTONOMOUS.spec, |s| Some(&mut s.grounding.limits.autonomous_m)).file_only(),
        of(schema::DRAUGHT.spec, |s| Some(&mut s.grounding.limits.draught_m)).file_only(),
        of(schema::SQUAT.spec, |s| Some(&mut s.grounding.limits.squat_m)).file_only(),
        new(schema::AIR_DRAUGHT.spec, Place::Limit(|s| Some(&mut s.grounding.limits.air_draught_m), 0.0))
            .file_only(),
        new(schema::TRUST.spec, Place::Word(trust, set_trust)).file_only(),
        new(schema::ENTRY.spec, Place::Word(entry, set_entry)).file_only(),
        of(schema::WATER_LEVEL.spec, |s| Some(&mut s.grounding.limits.water_level_m)).file_only(),
        of(schema::POSITION.spec, |s| Some(&mut s.grounding.limits.position_m)).file_only(),
        of(schema::CROSS_TRACK.spec, |s| Some(&mut s.grounding.limits.cross_track_m)).file_only(),
        of(schema::DRIFT.spec, |s| Some(&mut s.grounding.limits.drift_mps)).file_only(),
        of(schema::WARNING_TIME.spec, |s| Some(&mut s.grounding.warning_time_s)).file_only(),
        of(schema::WARNING_DISTANCE.spec, |s| Some(&mut s.grounding.warning_distance_m)).file_only(),
        of(schema::REACTION.spec, |s| Some(&mut s.grounding.reaction_s)).file_only(),
        of(schema::DECELERATION.spec, |s| Some(&mut s.grounding.deceleration_mps2)).file_only(),
        of(schema::RESERVE.spec, |s| Some(&mut s.grounding.reserve_m)).file_only(),
        of(schema::ABORT_AFTER.spec, |s| Some(&mut s.grounding.abort_after_s)).file_only(),
        of(schema::OVERRIDE.spec, |s| Some(&mut s.grounding.override_request_s)),
        of(schema::CONFIRM.spec, |s| Some(&mut s.grounding.override_confirm_s)),
        of(schema::ROUTE_CLEARANCE.spec, |s| Some(&mut s.grounding.routes.clearance_m)).file_only(),
        of(schema::LONGEST_ROUTE.spec, |s| Some(&mut s.grounding.routes.longest_m)).file_only(),
    ]
}

fn maneuvers() -> Vec<Parameter> {
    let of = |homes, spec, at| Parameter::new(Entity::Maneuver, homes, spec, Place::Number(at, 1.0));
    vec![
        of(MULTIPLEXER, maneuver::LOITER_RADIUS.spec, |s| {
            Some(&mut s.mission.engine.maneuver.loiter_min_radius_m)
        }),
        of(MULTIPLEXER, maneuver::STATION_RADIUS.spec, |s| {
            Some(&mut s.mission.engine.maneuver.station_min_radius_m)
        }),
        of(FOLLOW_REFERENCE, maneuver::HORIZONTAL_TOLERANCE.spec, |s| {
            Some(&mut s.mission.engine.maneuver.reference.tolerance_m)
        }),
    ]
}

fn rpm(settings: &Settings) -> bool {
    matches!(settings.control.drive, Drive::Rpm { .. })
}

fn ilos_of(settings: &mut Settings) -> Option<&mut control::IlosConfig> {
    match &mut settings.guidance.leg {
        Law::Ilos(ilos) => Some(ilos),
        Law::PurePursuit | Law::VectorField(_) => None,
    }
}

fn corridor(settings: &mut Settings) -> Option<&mut control::Corridor> {
    match &mut settings.guidance.leg {
        Law::Ilos(ilos) => Some(&mut ilos.corridor),
        Law::VectorField(field) => Some(&mut field.corridor),
        Law::PurePursuit => None,
    }
}

fn trust(settings: &Settings) -> &'static str {
    match settings.grounding.limits.trust {
        ChartTrust::AsCharted => "as charted",
        ChartTrust::DepthErrors(_) => "depth errors",
        ChartTrust::AllErrors(_) => "all errors",
    }
}

fn entry(settings: &Settings) -> &'static str {
    let EntryRules { prohibited, restricted } = settings.grounding.limits.entry;
    match (prohibited, restricted) {
        (_, EntryRule::Refuse) => "refuse all",
        (EntryRule::Refuse, _) => "refuse prohibited",
        (EntryRule::Warn, _) | (_, EntryRule::Warn) => "warn",
        (EntryRule::Ignore, EntryRule::Ignore) => "ignore",
    }
}

fn set_entry(settings: &mut Settings, word: &str) {
    let both = |rule| EntryRules { prohibited: rule, restricted: rule };
    settings.grounding.limits.entry = match word {
        "refuse all" => both(EntryRule::Refuse),
        "warn" => both(EntryRule::Warn),
        "ignore" => both(EntryRule::Ignore),
        _ => EntryRules::default(),
    };
}

fn set_trust(settings: &mut Settings, word: &str) {
    settings.grounding.limits.trust = match word {
        "all errors" => ChartTrust::AllErrors(ChartTrust::STANDARD),
        "depth errors" => ChartTrust::DepthErrors(ChartTrust::STANDARD),
        _ => ChartTrust::AsCharted,
    };
}

/// 0 leaves it to the table of the hull.
fn rpm_for_speed(settings: &Settings) -> Option<f64> {
    rpm(settings).then_some(match settings.control.speed.feed_forward {
        FeedForward::Gain(gain) => gain,
        FeedForward::Table(_) => 0.0,
    })
}

fn set_rpm_for_speed(settings: &mut Settings, gain: f64) {
    settings.control.speed.feed_forward =
        if gain > 0.0 { FeedForward::Gain(gain) } else { FeedForward::Table(SpeedTable::FOSSEN_OTTER) };
}

fn force_for_speed(settings: &mut Settings) -> Option<&mut f64> {
    match &mut settings.control.speed.feed_forward {
        FeedForward::Gain(gain) if matches!(settings.control.drive, Drive::Force { .. }) => Some(gain),
        FeedForward::Gain(_) | FeedForward::Table(_) => None,
    }
}

fn course_speed(settings: &Settings) -> Option<f64> {
    (!rpm(settings)).then_some(match settings.control.yaw.course_tracking {
        CourseTracking::Filtered { min_speed_mps, .. } => min_speed_mps,
        CourseTracking::AsHeading => -1.0,
    })
}

fn set_course_speed(settings: &mut Settings, speed_mps: f64) {
    let time_constant_s = match settings.control.yaw.course_tracking {
        CourseTracking::Filtered { time_constant_s, .. } => time_constant_s,
        CourseTracking::AsHeading => COURSE_FILTER_S,
    };
    settings.control.yaw.course_tracking = if speed_mps < LEAST_COURSE_SPEED_MPS {
        CourseTracking::AsHeading
    } else {
        CourseTracking::Filtered { min_speed_mps: speed_mps, time_constant_s }
    };
}

impl Parameter {
    /// The value as text; `None` where this setup has none.
    pub fn get(&self, settings: &Settings) -> Option<String> {
        // The places are given to be written; reading them is rare.
        let mut copy = settings.clone();
        Some(match &self.place {
            Place::Number(at, factor) => short(*at(&mut copy)? / factor),
            Place::Span(at) => short(at(&mut copy)?.as_secs_f64()),
            Place::Gains(at) => {
                let pid = at(&mut copy)?;
                format!("{}, {}, {}", short(pid.kp), short(pid.ki), short(pid.kd))
            }
            Place::Limit(at, off) => short(at(&mut copy)?.unwrap_or(*off)),
            Place::Choice(get, _) => short(get(settings)?),
            Place::Word(get, _) => get(settings).to_owned(),
        })
    }

    /// Takes a value from text, without regard to who may change it.
    ///
    /// # Errors
    /// When it is not one that this parameter may have; the settings are then as they were.
    pub fn set(&self, settings: &mut Settings, text: &str) -> Result<(), ParameterError> {
        let mut changed = settings.clone();
        if self.get(settings).is_none() || !self.put(&mut changed, text)? {
            return Err(ParameterError::Unknown(self.name.to_owned()));
        }
        changed.validate().map_err(ParameterError::Refused)?;
        *settings = changed;
        Ok(())
    }

    /// The settings with a value that a system requests over the bus.
    ///
    /// # Errors
    /// When the value is not one that this parameter may have, or the files alone may set it.
    pub(crate) fn try_live(&self, settings: &Settings, text: &str) -> Result<Settings, ParameterError> {
        if self.access == Access::FileOnly {
            return Err(ParameterError::FileOnly(self.name.to_owned()));
        }
        let mut changed = settings.clone();
        self.set(&mut changed, text)?;
        Ok(changed)
    }

    /// Puts a value of the schema in its place; answers whether there is one in this setup.
    fn put(&self, settings: &mut Settings, text: &str) -> Result<bool, ParameterError> {
        use config::FromValue as _;
        let value = self.spec.value_of(text).map_err(ParameterError::Value)?;
        if let Place::Gains(at) = &self.place {
            let gains = Vec::<f64>::from_value(&value).unwrap_or_default();
            let (Some(pid), [kp, ki, kd]) = (at(settings), &gains[..]) else { return Ok(false) };
            (pid.kp, pid.ki, pid.kd) = (*kp, *ki, *kd);
            return Ok(true);
        }
        if let Place::Word(_, set) = &self.place {
            let Some(word) = <&'static str>::from_value(&value) else { return Ok(false) };
            set(settings, word);
            return Ok(true);
        }
        let Some(number) = f64::from_value(&value) else { return Ok(false) };
        match &self.place {
            Place::Gains(_) | Place::Word(..) => return Ok(false),
            Place::Number(at, factor) => match at(settings) {
                Some(place) => *place = number * factor,
                None => return Ok(false),
            },
            Place::Span(at) => match at(settings) {
                Some(place) => *place = Duration::from_secs_f64(number),
                None => return Ok(false),
            },
            Place::Limit(at, off) => match at(settings) {
                // Where -1 is off, so is all that is negative: no limit is below zero.
                Some(place) => *place = Some(number).filter(|number| *number > *off && *number >= 0.0),
                None => return Ok(false),
            },
            Place::Choice(_, set) => set(settings, number),
        }
        Ok(true)
    }
}

/// Whether the files know a parameter of this name for an entity, though it cannot be changed live. Those that
/// every task of DUNE has do not count: they are of tasks, which Lutra does not have.
pub(crate) fn in_files(entity: Entity, name: &str) -> bool {
    let of_tasks = |param: &ParamSpec| common::OF_EVERY_TASK.iter().any(|common| common.name == param.name);
    let task = config::schema::find(entity.label_and_task().1);
    task.is_some_and(|section| section.params().any(|param| param.matches(name) && !of_tasks(param)))
}

/// A number without the noise of its last bits.
fn short(value: f64) -> String {
    let rounded = (value * 1e9).round() / 1e9;
    format!("{rounded}")
}

#[cfg(test)]
mod tests;
