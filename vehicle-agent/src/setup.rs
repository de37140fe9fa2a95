//! From configuration files to the settings of the brain and of the simulated vessel.

use anyhow::{Context as _, bail};
use config::schema::{control as loops, general, mission as plans, path, simulate, transport, watch};
use config::{Config, Section, SectionSpec};
use control::{CourseSpeedConfig, FeedForward, GuidanceConfig, Law, PathConfig, Sharing, VectorFieldConfig};
use imc::Address;
use mission::{
    BatteryConfig, LimitsConfig, LostCommsConfig, ModelPoint, Remedy, Step, TrajectoryConfig, VehicleModel,
};
use onboard::{Entity, Settings, parameters};
use std::collections::BTreeSet;
use std::path::Path;
use std::time::Duration;
use units::{LatLon, UtcTime};

/// Which part of the vessel a task of the files is.
const TASKS: [(&SectionSpec, Entity); 20] = [
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
    (&watch::clock::CLOCK, Entity::Clock),
    (&watch::host::HOST, Entity::Host),
    (&transport::announce::ANNOUNCE, Entity::Announcer),
    (&transport::udp::UDP, Entity::Udp),
    (&transport::logging::LOGGING, Entity::Logger),
];

/// Announcements have ports of their own.
const ANNOUNCE: u16 = 151;

/// The configuration, or all that is wrong with it.
pub(crate) fn load(path: &Path, profile: &str) -> anyhow::Result<Config> {
    let config = Config::load(&config::Disk, path, &[profile]);
    if config.report().has_errors() {
        bail!("{}\n`lutra-agent check {}` tells more", config.report(), path.display());
    }
    Ok(config)
}

/// The section of the file that holds the parameters of an entity.
pub(crate) fn section_of<'a>(config: &'a Config, label: &str) -> Option<&'a Section> {
    config.by_label(label)
}

/// The brain's settings, and what of the files could not be followed.
pub(crate) fn settings(config: &Config, uid: u64) -> anyhow::Result<(Settings, Vec<String>)> {
    let address = config
        .address()
        .with_context(|| format!("[IMC Addresses] has no address for the vehicle `{}`", config.vehicle()))?;
    let mut settings = Settings::otter(config.vehicle(), Address(address));
    let mut doubts = Vec::new();
    settings.uid = uid;
    settings.names = config.addresses().into_iter().map(|(name, id)| (id, name.to_owned())).collect();
    base(config, &mut settings);
    for (spec, entity) in TASKS {
        for section in config.running(spec) {
            if let Some(label) = section.label() {
                settings.labels.set(entity, label);
            }
            adopt(section, entity, &mut settings, &mut doubts);
        }
    }
    let general = config.general();
    settings.path.time_of_arrival_factor_s = general.get(&general::TIME_OF_ARRIVAL_FACTOR);
    match model(&general) {
        Some(model) => settings.mission.engine.model = model,
        None => {
            doubts
                .push("[General] the speed conversion is no rising table; the usual one is used".to_owned());
        }
    }
    settings.mission.capacity_wh = general.get(&general::BATTERY_CAPACITY);
    settings.watch.cpu_percent = general.get(&general::CPU_MAXIMUM);
    monitored(config, &mut settings);
    supervisors(config, &mut settings, &mut doubts);
    maneuvers(config, &mut settings);
    transports(config, &mut settings, &mut doubts);
    crate::transports::adopt(config, &mut settings, &mut doubts);
    Ok((settings, doubts))
}

/// What percent, rpm and m/s mean to each other, and a guess of the power they take: the hotel load and what
/// grows with the cube of speed.
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

/// The controllers that run, before their parameters are looked at.
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
        // Without a gain of its own the speed table says what a speed needs.
        let gain = section.get(&loops::course_speed::SPEED_FEEDFORWARD);
        if gain > 0.0 {
            settings.control.speed.feed_forward = FeedForward::Gain(gain);
        }
        if !section.get(&loops::SHARE_SATURATION) {
            settings.control.output.sharing = Sharing::Independent;
        }
    }
}

/// What the files say of the parameters that the brain knows; what they do not say stays as it is.
fn adopt(section: &Section, entity: Entity, settings: &mut Settings, doubts: &mut Vec<String>) {
    for parameter in parameters::all().iter().filter(|parameter| parameter.entity == entity) {
        let given = section.parameter(parameter.name).filter(|given| given.setting().is_some());
        let Some(given) = given.filter(|_| parameter.get(settings).is_some()) else { continue };
        if let Err(error) = parameter.set(settings, &given.value().to_string()) {
            doubts.push(format!("[{}] {}: {error}; the usual value is used", section.name(), parameter.name));
        }
    }
}

fn monitored(config: &Config, settings: &mut Settings) {
    for section in config.running(&watch::entities::ENTITIES) {
        let known: Vec<Entity> = section
            .get(&watch::entities::MONITORED)
            .iter()
            .filter_map(|label| settings.labels.find(label))
            .collect();
        let motors = [Entity::MotorPort, Entity::MotorStarboard];
        // In order and once each; the vessel never sails without its motors' feedback.
        let all: BTreeSet<Entity> = known.into_iter().chain(motors).collect();
        settings.watch.monitored = all.into_iter().collect();
    }
    for section in config.running(&watch::vehicle::VEHICLE) {
        let labels = section.get(&watch::vehicle::VITAL_ENTITIES);
        let vital: Vec<Entity> = labels.iter().filter_map(|label| settings.labels.find(label)).collect();
        if !vital.is_empty() {
            settings.watch.vital = vital;
        }
        settings.mission.supervisor_report_hz = section.get(&watch::vehicle::FREQUENCY);
    }
}

fn supervisors(config: &Config, settings: &mut Settings, doubts: &mut Vec<String>) {
    settings.watch.lost_comms = LostCommsConfig {
        idle: Vec::new(),
        plan: Vec::new(),
        teleoperation: Vec::new(),
        before_first_contact: false,
    };
    let mut home = "lost_comms".to_owned();
    for section in config.running(&watch::lost_comms::LOST_COMMS) {
        home = section.get(&watch::lost_comms::PLAN);
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
        };
        settings.mission.hold_radius_m = section.get(&watch::lost_comms::HOLD_RADIUS);
    }
    let default = BatteryConfig::default();
    settings.watch.battery = BatteryConfig { reserve_remedy: None, critical_remedy: None, ..default };
    for section in config.running(&watch::fuel::FUEL) {
        let reserve = section.get(&watch::fuel::ERROR_LEVEL) / 100.0;
        let plan = section.get(&watch::fuel::RESERVE_PLAN);
        let action = section.get(&watch::fuel::RESERVE_ACTION);
        let remedy = remedy(action, if plan.is_empty() { &home } else { &plan });
        settings.watch.battery = BatteryConfig {
            low: section.get(&watch::fuel::WARNING_LEVEL) / 100.0,
            reserve,
            critical: reserve / 2.0,
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
            Ok(places) => mission::Area::new(&places).map_err(|error| doubts.push(error.to_string())).ok(),
            Err(error) => {
                doubts.push(format!("[{}] Area: {error}", section.name()));
                None
            }
        };
        let Some(remedy) = remedy(section.get(&watch::limits::ACTION), &home) else {
            doubts.push(format!("[{}] limits that only warn are not watched", section.name()));
            continue;
        };
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

fn remedy(action: &str, home: &str) -> Option<Remedy> {
    match action {
        "hold" => Some(Remedy::Hold),
        "return" => Some(Remedy::Run { plan_id: home.to_owned() }),
        _ => None,
    }
}

fn maneuvers(config: &Config, settings: &mut Settings) {
    let mission = &mut settings.mission;
    for section in config.running(&plans::plan::ENGINE) {
        mission.engine_report_hz = section.get(&plans::plan::REPORT_FREQUENCY);
        // Whole seconds up to ten minutes.
        let calibration = section.get(&plans::plan::MINIMUM_CALIBRATION).clamp(0, 600) as u64;
        let wanted = section.get(&plans::plan::CALIBRATE);
        mission.engine.calibration = wanted.then_some(Duration::from_secs(calibration));
    }
    for section in config.running(&plans::maneuver::FOLLOW_TRAJECTORY) {
        mission.engine.maneuver.trajectory = TrajectoryConfig {
            tolerance_s: section.get(&plans::maneuver::TRAJECTORY_DELAY),
            corrected_min_mps: section.get(&plans::maneuver::TRAJECTORY_MINIMUM),
            corrected_max_mps: section.get(&plans::maneuver::TRAJECTORY_MAXIMUM),
        };
    }
    for section in config.running(&plans::maneuver::FOLLOW_REFERENCE) {
        let reference = &mut mission.engine.maneuver.reference;
        reference.tolerance_m = section.get(&plans::maneuver::HORIZONTAL_TOLERANCE);
        reference.default_radius_m = section.get(&plans::maneuver::FOLLOW_RADIUS);
    }
}

fn transports(config: &Config, settings: &mut Settings, doubts: &mut Vec<String>) {
    for section in config.running(&transport::udp::UDP) {
        settings.node.udp.most_per_s.clear();
        for (name, rate) in section.get(&transport::udp::RATES) {
            match imc::catalogue::by_abbrev(&name) {
                Some(message) => {
                    settings.node.udp.most_per_s.insert(message.id, rate);
                }
                None => doubts.push(format!("[{}] Rate Limiters: no message `{name}`", section.name())),
            }
        }
        // What the files list is carried; what they do not say is as DUNE's stock setup has it.
        if section
            .parameter(transport::udp::MESSAGES.spec.name)
            .is_some_and(|given| given.setting().is_some())
        {
            let listed = section.get(&transport::udp::MESSAGES);
            let carried =
                |id: u16| imc::catalogue::by_id(id).is_some_and(|m| listed.iter().any(|l| l == m.abbrev));
            settings.node.udp.left_out =
                (0..u16::MAX).filter(|id| !carried(*id) || *id == ANNOUNCE).collect();
        }
        for (host, port) in section.get(&transport::udp::STATIC_DESTINATIONS) {
            match format!("{host}:{port}").parse() {
                Ok(socket) => settings.node.static_destinations.push(socket),
                Err(_) => doubts.push(format!("[{}] `{host}:{port}` is no address", section.name())),
            }
        }
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
    // Receivers of several simulated vessels are told apart by their numbers, as real ones are.
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
mod tests {
    use super::*;

    const START: UtcTime = UtcTime::from_micros(1_790_000_100_000_000);

    /// The simulated vessel of the shipped configuration with lines after it.
    fn vessel_with(more: &str) -> anyhow::Result<sim::VesselConfig> {
        let files = config::InMemory::new().with("otter.ini", format!("{}\n{more}", crate::OTTER_INI));
        let config = Config::load(&files, "otter.ini".as_ref(), &["Simulation"]);
        assert!(!config.report().has_errors(), "{}", config.report());
        vessel(&config, START, 1)
    }

    #[test]
    fn fish_swim_where_the_configuration_has_them() {
        assert!(vessel_with("").unwrap().fish.is_empty());
        let fish = |number: u32, beginning_s: i64| {
            format!(
                "[Simulators.Fish/{number}]\nEnabled = Simulation\nEntity Label = Fish {number}\nTag Number = \
                 {number}\nBeginning = {beginning_s}\nArea -- Centre = 63.44, 10.35\n"
            )
        };
        let found = vessel_with(&(fish(7, 1_790_000_000) + &fish(8, 0))).unwrap();
        assert_eq!(found.fish.iter().map(|fish| fish.tag_id).collect::<Vec<_>>(), [7, 8]);
        assert_eq!(found.fish[0].since.micros(), 1_790_000_000_000_000);
        assert_eq!(found.fish[1].since, START);
        sim::Vessel::new(&found).unwrap();
        // Another vessel hears the same fish with a receiver of another number.
        let other = "[General]\nVehicle = other\n[IMC Addresses]\nother = 0x28D1\n";
        let other = vessel_with(&(fish(7, 1_790_000_000) + other)).unwrap();
        assert_eq!(other.fish[0], found.fish[0]);
        assert_ne!(other.hydrophone.serial, found.hydrophone.serial);
    }

    #[test]
    fn a_fish_that_cannot_be_names_its_section() {
        let wrong =
            "[Simulators.Fish/odd]\nEnabled = Simulation\nEntity Label = Odd\nTag Interval = 90, 30\n";
        let told = format!("{:#}", vessel_with(wrong).unwrap_err());
        assert!(told.contains("[Simulators.Fish/odd]") && told.contains("longest tag interval"), "{told}");
    }
}
