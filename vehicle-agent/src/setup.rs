//! Converts configuration files to the settings of the brain and of the simulated vessel.

use crate::hardware::motors_config;
use anyhow::{Context as _, bail};
use config::schema::{control as loops, device, general, mission as plans, path, simulate, transport, watch};
use config::{Config, Section, SectionSpec};
use control::{CourseSpeedConfig, GuidanceConfig, Law, PathConfig, Sharing, VectorFieldConfig};
use imc::Address;
use mission::{BatteryConfig, LimitsConfig, LostCommsConfig, ModelPoint, Remedy, Step, VehicleModel};
use onboard::parameters::{self, Parameter};
use onboard::{
    AfterRestart, Chart, Entity, GroundingAction, HydrophoneSettings, LeverArm, PowerChannel, Settings,
};
use std::collections::BTreeSet;
use std::path::Path;
use std::time::Duration;
use units::{LatLon, UtcTime};

/// The entity of each task in the files.
const TASKS: [(&SectionSpec, Entity); 27] = [
    (&loops::course_speed::COURSE_SPEED, Entity::Control),
    (&loops::course_speed_force::COURSE_SPEED_FORCE, Entity::Control),
    (&path::ilos::ILOS, Entity::Path),
    (&path::PURE_PURSUIT, Entity::Path),
    (&path::vector_field::VECTOR_FIELD, Entity::Path),
    (&loops::remote::REMOTE, Entity::Remote),
    (&plans::navigation::NAVIGATION, Entity::Navigation),
    (&plans::plan::ENGINE, Entity::PlanEngine),
    (&plans::plan::DATABASE, Entity::PlanDatabase),
    (&plans::maneuver::MULTIPLEXER, Entity::Maneuver),
    (&watch::vehicle::VEHICLE, Entity::Supervisor),
    (&watch::lost_comms::LOST_COMMS, Entity::LostComms),
    (&watch::entities::ENTITIES, Entity::Monitor),
    (&watch::fuel::FUEL, Entity::Fuel),
    (&watch::limits::LIMITS, Entity::Limits),
    (&watch::grounding::GROUNDING, Entity::Grounding),
    (&watch::clock::CLOCK, Entity::Clock),
    (&watch::host::HOST, Entity::Host),
    (&transport::announce::ANNOUNCE, Entity::Announcer),
    (&transport::udp::UDP, Entity::Udp),
    (&transport::logging::LOGGING, Entity::Logger),
    (&device::compass::COMPASS, Entity::Gps),
    (&simulate::gps::GPS, Entity::Gps),
    (&device::hydrophone::HYDROPHONE, Entity::Hydrophone),
    (&device::line_receiver::LINE_RECEIVER, Entity::Hydrophone),
    (&device::board::WATCHDOG, Entity::Watchdog),
    (&device::board::LIGHTS, Entity::Light),
];

/// The batteries by their numbers on the bus.
const BATTERIES: [Entity; 4] = [Entity::Battery0, Entity::Battery1, Entity::Battery2, Entity::Battery3];
/// The power rails by their numbers.
const RAILS: [Entity; 5] = [Entity::Rail0, Entity::Rail1, Entity::Rail2, Entity::Rail3, Entity::Rail4];

/// The configuration, or all its errors.
pub(crate) fn load(path: &Path, profile: &str) -> anyhow::Result<Config> {
    usable(Config::load(&config::Disk, path, &[profile]), path)
}

/// The same, with the values that consoles saved in the data folder.
pub(crate) fn load_aboard(path: &Path, profile: &str, data: &Path) -> anyhow::Result<Config> {
    usable(Config::load_aboard(&config::Disk, path, &[profile], data), path)
}

fn usable(config: Config, path: &Path) -> anyhow::Result<Config> {
    if config.report().has_errors() {
        bail!("{}\n`lutra-agent check {}` tells more", config.report(), path.display());
    }
    Ok(config)
}

/// The brain's settings, and warnings about values that could not be applied.
pub(crate) fn settings(config: &Config, uid: u64) -> anyhow::Result<(Settings, Vec<String>)> {
    let address = config
        .address()
        .with_context(|| format!("[IMC Addresses] has no address for the vehicle `{}`", config.vehicle()))?;
    let mut settings = Settings::otter(config.vehicle(), Address(address));
    let mut doubts = Vec::new();
    settings.uid = uid;
    settings.names = config.addresses().into_iter().map(|(name, id)| (id, name.to_owned())).collect();
    base(config, &mut settings);
    crate::laws::adopt(config, &mut settings, &mut doubts);
    for (spec, entity) in TASKS {
        for section in config.running(spec) {
            if let Some(label) = section.label() {
                settings.labels.set(entity, label);
            }
        }
    }
    card_names(config, &mut settings);
    let general = config.general();
    match model(&general) {
        Some(model) => settings.mission.engine.model = model,
        None => {
            doubts.push(
                "[General] the speed conversion is not a rising table; the usual one is used".to_owned(),
            );
        }
    }
    settings.mission.limits.max_depth_m = general.get(&general::MAXIMUM_DEPTH);
    settings.mission.capacity_wh = general.get(&general::BATTERY_CAPACITY);
    settings.watch.cpu_percent = general.get(&general::CPU_MAXIMUM);
    settings.watch.pulse_expected = config
        .running(&watch::clock::CLOCK)
        .any(|section| !section.get(&watch::clock::PULSE_DEVICE).is_empty());
    hydrophone(config, &mut settings);
    monitored(config, &mut settings, &mut doubts);
    supervisors(config, &mut settings, &mut doubts);
    engine(config, &mut settings);
    grounding(config, &mut settings);
    crate::transports::adopt(config, &mut settings, &mut doubts);
    adopt(config, &mut settings, &mut doubts);
    Ok((settings, doubts))
}

/// Position of the hydrophone, and duration of transmissions.
fn hydrophone(config: &Config, settings: &mut Settings) {
    use device::{hydrophone as schema, line_receiver};
    for section in config.running(&schema::HYDROPHONE).chain(config.running(&line_receiver::LINE_RECEIVER)) {
        settings.hydrophone = HydrophoneSettings {
            transmission: Duration::from_secs_f64(section.get(&schema::TRANSMISSION_TIME)),
            arm: LeverArm {
                forward_m: section.get(&schema::ARM_FORWARD),
                starboard_m: section.get(&schema::ARM_STARBOARD),
                down_m: section.get(&schema::ARM_DOWN),
            },
        };
    }
}

/// Names from the motor card's section: motors, batteries, power rails and power channels.
fn card_names(config: &Config, settings: &mut Settings) {
    use device::torqeedo::{BATTERY_LABEL, MOTOR_LABEL, PORT_MOTOR, RAIL_LABEL, TORQEEDO};
    for section in config.running(&TORQEEDO) {
        // By the card's numbers; either may be the port motor.
        let mut motors = [Entity::MotorPort, Entity::MotorStarboard];
        if section.get(&PORT_MOTOR) == 1 {
            motors.reverse();
        }
        // An invalid section is refused where its driver is made.
        let channels = motors_config(section).map(|card| card.channels).unwrap_or_default();
        let named = channels.into_iter().map(|one| PowerChannel { name: one.name, rail: one.rail });
        settings.power.extend(named);
        let named = [(&MOTOR_LABEL, &motors[..]), (&BATTERY_LABEL, &BATTERIES), (&RAIL_LABEL, &RAILS)];
        for (param, parts) in named {
            for (number, label) in section.each(param) {
                let entity = number.parse().ok().and_then(|number: usize| parts.get(number));
                if let Some(entity) = entity.filter(|_| !label.is_empty()) {
                    settings.labels.set(*entity, &label);
                }
            }
        }
    }
}

/// Relation of percent, rpm and m/s, and an estimate of the power: the hotel load plus a term with the cube of speed.
fn model(general: &Section) -> Option<VehicleModel> {
    let actuation = general.get(&general::CONVERSION_ACTUATION);
    let rpm = general.get(&general::CONVERSION_RPM);
    let mps = general.get(&general::CONVERSION_MPS);
    if actuation.len() != rpm.len() || rpm.len() != mps.len() {
        return None;
    }
    let rows = actuation.iter().zip(&rpm).zip(&mps).map(|((share, rpm), mps)| ModelPoint {
        percent: 100.0 * share,
        rpm: *rpm,
        mps: *mps,
        power_w: 30.0 + 60.0 * mps.powi(3),
    });
    VehicleModel::new(rows.collect()).ok()
}

/// The enabled controllers, before their parameters are read.
fn base(config: &Config, settings: &mut Settings) {
    let runs = |spec| config.running(spec).next().is_some();
    if runs(&loops::course_speed::COURSE_SPEED) {
        settings.control = CourseSpeedConfig::fossen_rpm();
    }
    if runs(&loops::course_speed_force::COURSE_SPEED_FORCE) {
        settings.control = CourseSpeedConfig::fossen_force();
    }
    settings.path = PathConfig::default();
    settings.guidance = GuidanceConfig::default();
    if runs(&path::PURE_PURSUIT) {
        settings.guidance.leg = Law::PurePursuit;
    }
    if runs(&path::vector_field::VECTOR_FIELD) {
        settings.guidance.leg = Law::VectorField(VectorFieldConfig::otter());
    }
    for section in config.running(&loops::course_speed::COURSE_SPEED) {
        if !section.get(&loops::SHARE_SATURATION) {
            settings.control.output.sharing = Sharing::Independent;
        }
    }
}

/// The values of the brain's parameters, from the files or, by default, from the schema: so `check` prints the values in
/// force.
fn adopt(config: &Config, settings: &mut Settings, doubts: &mut Vec<String>) {
    let mut waiting = parameters::all();
    // Values that limit each other may need several rounds; each round applies at least one of them.
    loop {
        let before = waiting.len();
        let mut refused = Vec::new();
        waiting.retain(|parameter| {
            let Some((section, text)) = home(config, parameter) else { return false };
            if parameter.get(settings).is_none() {
                return false;
            }
            match parameter.set(settings, &text) {
                Ok(()) => false,
                Err(error) => {
                    refused.push((section, parameter.name, error));
                    true
                }
            }
        });
        if waiting.is_empty() || waiting.len() == before {
            doubts.extend(refused.into_iter().map(|(section, name, error)| {
                format!("[{section}] {name}: {error}; the usual value is used")
            }));
            return;
        }
    }
}

/// The active section of a parameter, and its value as text.
fn home(config: &Config, parameter: &Parameter) -> Option<(String, String)> {
    let general = std::ptr::eq(*parameter.homes.first()?, &raw const general::GENERAL);
    let section = if general {
        config.general()
    } else {
        parameter.homes.iter().find_map(|home| config.running(home).next())?.clone()
    };
    let value = section.parameter(parameter.name)?.value().to_string();
    Some((section.name().to_owned(), value))
}

/// Saves the values of an entity's parameters for the next start.
///
/// # Errors
/// When one has no active section in the files: it would not be read.
pub(crate) fn save(
    config: &Config,
    saved: &mut config::Saved,
    label: &str,
    values: &[(String, String)],
) -> anyhow::Result<()> {
    let (settings, _) = settings(config, 0)?;
    let entity = settings.labels.find(label).with_context(|| format!("nothing is called {label}"))?;
    let all = parameters::all();
    for (name, value) in values {
        let known =
            all.iter().find(|one| one.entity == entity && one.name == name && home(config, one).is_some());
        let parameter = known.with_context(|| format!("no section that runs has `{name}`"))?;
        let (section, _) = home(config, parameter).context("no section")?;
        saved.set(&section, name, value);
    }
    Ok(())
}

fn monitored(config: &Config, settings: &mut Settings, doubts: &mut Vec<String>) {
    let hardware = config.profiles().selected().iter().any(|profile| profile == "Hardware");
    for section in config.running(&watch::entities::ENTITIES) {
        let mut labels = section.get(&watch::entities::MONITORED);
        if hardware {
            labels.extend(section.get(&watch::entities::MONITORED_HARDWARE));
        }
        let motors = [Entity::MotorPort, Entity::MotorStarboard];
        // In order and once each; the vessel never sails without feedback of its motors.
        let known = parts(config, settings, section, &labels, doubts);
        let all: BTreeSet<Entity> = known.into_iter().chain(motors).collect();
        settings.watch.monitored = all.into_iter().collect();
        // Lutra's tasks are in one program: only devices can fall silent.
        let silence = Duration::from_secs_f64(section.get(&watch::entities::REPORT_TIMEOUT));
        settings.watch.gnss_timeout = settings.watch.gnss_timeout.min(silence);
        settings.watch.motor_timeout = settings.watch.motor_timeout.min(silence);
    }
    for section in config.running(&watch::vehicle::VEHICLE) {
        let labels = section.get(&watch::vehicle::VITAL_ENTITIES);
        let vital = parts(config, settings, section, &labels, doubts);
        if !vital.is_empty() {
            settings.watch.vital = vital;
        }
        settings.mission.supervisor_report_hz = section.get(&watch::vehicle::FREQUENCY);
        // A maneuver whose path control is silent for this long has failed; at least a second, for a compass with one
        // position a second.
        let answer_s = section.get(&watch::vehicle::HANDLING_TIMEOUT).max(1.0);
        settings.mission.engine.maneuver.path_silence = Duration::from_secs_f64(answer_s);
    }
}

/// The entities with these labels. The motor card's label means both motors; other tasks of the files that Lutra does not
/// watch are reported.
fn parts(
    config: &Config,
    settings: &Settings,
    section: &Section,
    labels: &[String],
    doubts: &mut Vec<String>,
) -> Vec<Entity> {
    let card = |label: &str| {
        let mut cards = config.sections().iter().filter(|section| section.is(&device::torqeedo::TORQEEDO));
        cards.any(|section| section.label() == Some(label))
    };
    let mut found = Vec::new();
    for label in labels {
        match settings.labels.find(label) {
            Some(entity) => found.push(entity),
            None if card(label) => found.extend([Entity::MotorPort, Entity::MotorStarboard]),
            None => doubts.push(format!("[{}] `{label}` is not a part that Lutra watches", section.name())),
        }
    }
    found
}

fn supervisors(config: &Config, settings: &mut Settings, doubts: &mut Vec<String>) {
    settings.watch.lost_comms = LostCommsConfig {
        idle: Vec::new(),
        plan: Vec::new(),
        teleoperation: Vec::new(),
        ..LostCommsConfig::default()
    };
    let home = home_plan(config);
    for section in config.running(&watch::lost_comms::LOST_COMMS) {
        let after = Duration::from_secs_f64(section.get(&watch::lost_comms::TIMEOUT));
        let ladder = |action: &str| match remedy(action, &home) {
            Some(remedy) => vec![Step { after, remedy }],
            None => Vec::new(),
        };
        settings.watch.lost_comms = LostCommsConfig {
            idle: ladder(section.get(&watch::lost_comms::WHEN_IDLE)),
            plan: ladder(section.get(&watch::lost_comms::DURING_PLAN)),
            teleoperation: ladder(section.get(&watch::lost_comms::DURING_TELEOPERATION)),
            before_first_contact: false,
            lost_after: after,
        };
    }
    let default = BatteryConfig::default();
    settings.watch.battery = BatteryConfig { reserve_remedy: None, critical_remedy: None, ..default };
    for section in config.running(&watch::fuel::FUEL) {
        let plan = section.get(&watch::fuel::RESERVE_PLAN);
        let action = section.get(&watch::fuel::RESERVE_ACTION);
        let remedy = remedy(action, if plan.is_empty() { &home } else { &plan });
        settings.watch.battery = BatteryConfig {
            low_v: Some(section.get(&watch::fuel::WARNING_VOLTAGE)).filter(|voltage_v| *voltage_v > 0.0),
            reserve_v: Some(section.get(&watch::fuel::ERROR_VOLTAGE)).filter(|voltage_v| *voltage_v > 0.0),
            critical_remedy: remedy.is_some().then_some(Remedy::Hold),
            reserve_remedy: remedy,
            ..BatteryConfig::default()
        };
    }
    for section in config.running(&watch::limits::LIMITS) {
        let corners = section.get(&watch::limits::AREA);
        let places = corners.chunks_exact(2).map(|pair| LatLon::from_deg(pair[0], pair[1]));
        let area = match places.collect::<Result<Vec<_>, _>>() {
            Ok(places) if places.is_empty() => None,
            Ok(places) => guard::Area::new(&places).map_err(|error| doubts.push(error.to_string())).ok(),
            Err(error) => {
                doubts.push(format!("[{}] Area: {error}", section.name()));
                None
            }
        };
        // Without an action they are only watched and reported.
        let remedy = remedy(section.get(&watch::limits::ACTION), &home);
        settings.mission.limits.area.clone_from(&area);
        settings.watch.limits = LimitsConfig {
            area,
            area_remedy: remedy.clone(),
            max_speed_mps: Some(section.get(&watch::limits::MAXIMUM_SPEED)),
            speed_remedy: remedy,
            ..LimitsConfig::default()
        };
    }
}

/// The grounding supervisor's text settings; its numbers are parameters like all others.
fn grounding(config: &Config, settings: &mut Settings) {
    use watch::grounding as schema;
    let Some(section) = config.running(&schema::GROUNDING).next() else { return };
    let grounding = &mut settings.grounding;
    let path = section.get(&schema::CHART);
    if !path.is_empty() {
        grounding.chart = match std::fs::read(&path) {
            Ok(bytes) => Chart::read(&path, &bytes),
            Err(error) => Chart::Unreadable { reason: format!("{path}: {error}") },
        };
    }
    grounding.routes.around = section.get(&schema::ROUTES);
    grounding.refuses_without = section.get(&schema::WITHOUT_CHART) == "refuse";
    grounding.action = match section.get(&schema::ACTION) {
        "warn" => GroundingAction::Warn,
        "slow" => GroundingAction::Slow,
        "stop" => GroundingAction::Stop,
        _ => GroundingAction::DeepWater,
    };
}

/// Whether the shore's chart takes the place of the configured one.
pub(crate) fn takes_chart(config: &Config) -> bool {
    use watch::grounding as schema;
    config.running(&schema::GROUNDING).next().is_some_and(|section| section.get(&schema::FROM_SHORE))
}

/// Name of the plan that brings the vessel home.
fn home_plan(config: &Config) -> String {
    let section = config.running(&watch::lost_comms::LOST_COMMS).next();
    section.map_or_else(|| "lost_comms".to_owned(), |section| section.get(&watch::lost_comms::PLAN))
}

fn remedy(action: &str, home: &str) -> Option<Remedy> {
    match action {
        "hold" => Some(Remedy::Hold),
        "return" => Some(Remedy::Run { plan_id: home.to_owned() }),
        _ => None,
    }
}

fn engine(config: &Config, settings: &mut Settings) {
    let mission = &mut settings.mission;
    for section in config.running(&plans::plan::ENGINE) {
        mission.engine_report_hz = section.get(&plans::plan::REPORT_FREQUENCY);
        // Whole seconds up to ten minutes.
        let calibration = section.get(&plans::plan::MINIMUM_CALIBRATION).clamp(0, 600) as u64;
        let wanted = section.get(&plans::plan::CALIBRATE);
        mission.engine.calibration = wanted.then_some(Duration::from_secs(calibration));
        mission.restart.action = match section.get(&plans::plan::AFTER_RESTART) {
            "drift" => AfterRestart::Drift,
            "resume" => AfterRestart::Resume,
            "return" => AfterRestart::Return(home_plan(config)),
            _ => AfterRestart::Hold,
        };
        mission.holds_after_failure = section.get(&plans::plan::AFTER_FAILURE) == "hold";
    }
}

/// The simulated vessel.
pub(crate) fn vessel(config: &Config, start: UtcTime, seed: u64) -> anyhow::Result<sim::VesselConfig> {
    let gps = config.running(&simulate::gps::GPS).next();
    let position = gps.map_or(vec![63.33, 10.083_333], |gps| gps.get(&simulate::gps::INITIAL_POSITION));
    let place = match position[..] {
        [lat_deg, lon_deg] => LatLon::from_deg(lat_deg, lon_deg).context("the initial position")?,
        _ => bail!("the initial position has two numbers"),
    };
    let mut vessel = sim::VesselConfig::at(place, start, seed);
    vessel.form = sim::OutputForm::Values;
    vessel.gnss.baud = 115_200;
    if let Some(gps) = gps {
        // The schema allows 1 to some tens; the compass needs whole microseconds between epochs.
        let rate = gps.get(&simulate::gps::FREQUENCY).round().clamp(1.0, 10.0) as u32;
        vessel.gnss.rate_hz = if 1_000_000_u32.is_multiple_of(rate) { rate } else { 5 };
    }
    if let Some(hull) = config.running(&simulate::hull::HULL).next() {
        vessel.payload_kg = hull.get(&simulate::hull::PAYLOAD);
    }
    if let Some(current) = config.running(&simulate::current::CURRENT).next() {
        let (north, east) = (current.get(&simulate::current::NORTH), current.get(&simulate::current::EAST));
        vessel.environment.current.speed_mps = north.hypot(east);
        vessel.environment.current.to_rad = east.atan2(north);
    }
    // Receivers of several simulated vessels are distinguished by their serial numbers, as real ones are.
    vessel.hydrophone.serial += u32::from(config.address().unwrap_or_default());
    vessel.fish =
        config.running(&simulate::fish::FISH).map(|fish| tagged(fish, start)).collect::<Result<_, _>>()?;
    Ok(vessel)
}

/// A simulated fish.
fn tagged(section: &Section, start: UtcTime) -> anyhow::Result<sim::FishConfig> {
    let about = || format!("[{}]", section.name());
    let (centre, interval) = (section.get(&simulate::fish::CENTRE), section.get(&simulate::fish::INTERVAL));
    let ([lat_deg, lon_deg], [shortest_s, longest_s]) = (&centre[..], &interval[..]) else {
        bail!("{} the centre and the interval have two numbers each", about());
    };
    let centre = LatLon::from_deg(*lat_deg, *lon_deg).with_context(about)?;
    let since = match section.get(&simulate::fish::BEGINNING) {
        0 => start,
        seconds => UtcTime::from_micros(seconds * 1_000_000),
    };
    // The schema keeps the number within 32 bits and the seconds within a day.
    let tag_id = section.get(&simulate::fish::TAG) as u32;
    let fish = sim::FishConfig {
        radius_m: section.get(&simulate::fish::RADIUS),
        speed_mps: section.get(&simulate::fish::SPEED),
        depth_m: section.get(&simulate::fish::DEPTH),
        interval_min_s: shortest_s.round() as u32,
        interval_max_s: longest_s.round() as u32,
        ..sim::FishConfig::near(centre, since, tag_id, u64::from(tag_id))
    };
    sim::Fish::new(&fish).with_context(about)?;
    Ok(fish)
}

#[cfg(test)]
mod tests;
