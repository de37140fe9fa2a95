//! The settings of the brain. The shell makes them from the configuration files.

use crate::entity::{Entity, Labels};
use crate::grounding::GroundingSettings;
use crate::navigation::NavigationSettings;
use crate::poses::LeverArm;
use control::{CourseSpeedConfig, GuidanceConfig, PathConfig, RemoteConfig};
use guard::GuardLimits;
use imc::Address;
use mission::{BatteryConfig, EngineConfig, LimitsConfig, LostCommsConfig, PlanLimits};
use std::collections::{BTreeMap, BTreeSet};
use std::net::SocketAddrV4;
use std::time::Duration;

/// Everything.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// The vessel's name.
    pub name: String,
    /// The vessel's address.
    pub address: Address,
    /// A number that differs at every start.
    pub uid: u64,
    /// The program's version, as announced.
    pub version: String,
    /// Labels of entities that differ from the usual.
    pub labels: Labels,
    /// Navigation.
    pub navigation: NavigationSettings,
    /// Course and speed controller.
    pub control: CourseSpeedConfig,
    /// Guidance law.
    pub guidance: GuidanceConfig,
    /// Path tracker.
    pub path: PathConfig,
    /// Time between two reports of the state on the path.
    pub path_report: Duration,
    /// Manual control.
    pub remote: RemoteConfig,
    /// Keys of an operator that took longer than this beyond the fastest packet have no effect.
    pub longest_key_age: Duration,
    /// Discovery and transports.
    pub node: NodeSettings,
    /// Names of other systems, by address.
    pub names: BTreeMap<u16, String>,
    /// Watching over parts.
    pub watch: WatchSettings,
    /// Plans and maneuvers.
    pub mission: MissionSettings,
    /// Grounding supervisor.
    pub grounding: GroundingSettings,
    /// Power channels with names.
    pub power: Vec<PowerChannel>,
    /// The hydrophone.
    pub hydrophone: HydrophoneSettings,
}

/// The hydrophone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HydrophoneSettings {
    /// Length of a tag's transmission, at whose end the receiver stamps it.
    pub transmission: Duration,
    /// From the antenna to it.
    pub arm: LeverArm,
}

impl Default for HydrophoneSettings {
    /// 3 s, and right below the antenna.
    fn default() -> Self {
        Self { transmission: Duration::from_secs(3), arm: LeverArm::default() }
    }
}

/// Discovery and transports.
#[derive(Debug, Clone, PartialEq)]
pub struct NodeSettings {
    /// Time between announcements.
    pub announce_period: Duration,
    /// Silence after which a contact is no more.
    pub contact_timeout: Duration,
    /// Whether systems that announce themselves are sent to by UDP.
    pub dynamic_contacts: bool,
    /// Sockets that always receive.
    pub static_destinations: Vec<SocketAddrV4>,
    /// Messages that go by UDP.
    pub udp: TransportSettings,
    /// The messages that each TCP server carries, by its number ([`Peer::server`](crate::Peer::server)); one that is
    /// not here carries everything.
    pub tcp: Vec<TransportSettings>,
}

/// The messages that a transport carries.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TransportSettings {
    /// Messages that stay aboard.
    pub left_out: BTreeSet<u16>,
    /// Largest rates (Hz) by message, for each entity.
    pub most_per_s: BTreeMap<u16, f64>,
    /// Entities of which alone a message is carried.
    pub only_of: BTreeMap<u16, BTreeSet<Entity>>,
}

/// Watching over parts.
#[derive(Debug, Clone, PartialEq)]
pub struct WatchSettings {
    /// Entities whose errors stop the vessel.
    pub monitored: Vec<Entity>,
    /// Those that count also for a plan that ignores errors.
    pub vital: Vec<Entity>,
    /// Silence of the compass that is an error.
    pub gnss_timeout: Duration,
    /// Silence of a motor's feedback that is an error.
    pub motor_timeout: Duration,
    /// Silence of the batteries that is a fault.
    pub battery_timeout: Duration,
    /// Battery reserve.
    pub battery: BatteryConfig,
    /// Lost communications.
    pub lost_comms: LostCommsConfig,
    /// Operational limits.
    pub limits: LimitsConfig,
    /// Load of the processor by this program (%) that is an error when held for ten seconds.
    pub cpu_percent: f64,
    /// Free disk (%) below which a fault is reported.
    pub disk_free_percent: f64,
    /// Free disk (%) below which it is an error.
    pub disk_error_percent: f64,
    /// Free memory of the computer (%) below which a fault is reported.
    pub memory_free_percent: f64,
    /// Memory of this program (MiB) above which a fault is reported.
    pub memory_mib: f64,
    /// Difference between the computer's clock and the satellites' that is a fault (s).
    pub clock_offset_s: f64,
    /// The same where a pulse says it (s).
    pub pulse_offset_s: f64,
    /// The receiver's pulse is wired to the computer: its silence is a fault.
    pub pulse_expected: bool,
}

/// Plans and maneuvers.
#[derive(Debug, Clone, PartialEq)]
pub struct MissionSettings {
    /// Reports of the plan engine a second.
    pub engine_report_hz: f64,
    /// Reports of the supervisor a second.
    pub supervisor_report_hz: f64,
    /// The engine and its maneuvers.
    pub engine: EngineConfig,
    /// The limits of plans.
    pub limits: PlanLimits,
    /// Energy of full batteries (Wh).
    pub capacity_wh: f64,
    /// Radius of holding a position (m).
    pub hold_radius_m: f64,
    /// Speed while holding (m/s).
    pub hold_speed_mps: f64,
    /// How long a vessel that is too far from its track steers back before its plan fails; zero fails at once.
    pub track_recovery: Duration,
    /// The action when the program starts again after it ended under way.
    pub restart: RestartSettings,
    /// Whether the vessel holds its station after a plan that failed under way, rather than drift.
    pub holds_after_failure: bool,
}

/// The program starts again after it ended under way.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RestartSettings {
    /// What to do.
    pub action: AfterRestart,
    /// How long the vessel holds before a plan resumes.
    pub countdown: Duration,
    /// What was under way longer ago is only reported.
    pub memory: Duration,
}

/// The action of a vessel that was under way when the program ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum AfterRestart {
    /// Hold its station.
    Hold,
    /// Hold its station, and resume the plan after a count-down that an operator can stop.
    Resume,
    /// Run the plan of this name.
    Return(String),
    /// Drift; the supervisors watch it.
    Drift,
}

impl Default for RestartSettings {
    fn default() -> Self {
        Self {
            action: AfterRestart::Hold,
            countdown: Duration::from_secs(30),
            memory: Duration::from_mins(10),
        }
    }
}

impl Default for NodeSettings {
    fn default() -> Self {
        let rates = [
            (350, 2.0),
            (1, 1.0),
            (250, 1.0),
            (50, 0.5),
            (7, 0.2),
            (279, 0.1),
            (263, 0.1),
            (251, 0.1),
            (252, 0.1),
            (100, 0.05),
        ];
        Self {
            announce_period: Duration::from_secs(10),
            contact_timeout: Duration::from_secs(30),
            dynamic_contacts: true,
            static_destinations: Vec::new(),
            udp: TransportSettings {
                // Announce has ports of its own; the rest DUNE does not carry by default.
                left_out: [470, 406, 507, 501, 102, 151, 3, 8].into(),
                most_per_s: rates.into(),
                only_of: BTreeMap::new(),
            },
            tcp: Vec::new(),
        }
    }
}

impl Default for WatchSettings {
    fn default() -> Self {
        use Entity::{Daemon, Gps, MotorPort, MotorStarboard, Navigation, Path};
        Self {
            monitored: vec![Daemon, Gps, Navigation, Path, MotorPort, MotorStarboard],
            vital: vec![Navigation],
            gnss_timeout: Duration::from_secs(4),
            motor_timeout: Duration::from_secs(2),
            battery_timeout: Duration::from_secs(10),
            battery: BatteryConfig::default(),
            lost_comms: LostCommsConfig::default(),
            limits: LimitsConfig::default(),
            cpu_percent: 90.0,
            disk_free_percent: 5.0,
            disk_error_percent: 2.0,
            memory_free_percent: 10.0,
            memory_mib: 200.0,
            clock_offset_s: 2.0,
            pulse_offset_s: 0.001,
            pulse_expected: false,
        }
    }
}

impl Default for MissionSettings {
    fn default() -> Self {
        Self {
            engine_report_hz: 2.5,
            supervisor_report_hz: 2.0,
            engine: EngineConfig::default(),
            limits: PlanLimits::default(),
            capacity_wh: 3660.0,
            hold_radius_m: 15.0,
            hold_speed_mps: 1.0,
            track_recovery: Duration::from_mins(2),
            restart: RestartSettings::default(),
            holds_after_failure: true,
        }
    }
}

impl Settings {
    /// Whether every part takes its values and none contradicts another.
    ///
    /// # Errors
    /// Says what is wrong.
    pub fn validate(&self) -> Result<(), String> {
        let text = |error: control::InvalidConfig| error.to_string();
        self.control.validate().map_err(text)?;
        self.guidance.validate().map_err(text)?;
        self.path.validate().map_err(text)?;
        self.remote.validate().map_err(text)?;
        let BatteryConfig { low, reserve, critical, .. } = self.watch.battery;
        if critical > reserve || reserve > low {
            return Err("the levels of the battery must fall from warning to reserve to error".to_owned());
        }
        if self.watch.disk_error_percent > self.watch.disk_free_percent {
            return Err("the disk's warning level must not be below its error level".to_owned());
        }
        self.grounding.limits.validate().map_err(|error| error.to_string())
    }

    /// Limits by which plans are checked against the chart: the smallest circles that are really sailed count too.
    pub fn guard_limits(&self) -> GuardLimits {
        let maneuver = &self.mission.engine.maneuver;
        GuardLimits {
            least_loiter_m: maneuver.loiter_min_radius_m,
            least_station_m: maneuver.station_min_radius_m,
            ..self.grounding.limits
        }
    }

    /// An Otter with this name and address, everything else as usual.
    pub fn otter(name: &str, address: Address) -> Self {
        Self {
            name: name.to_owned(),
            address,
            uid: 1,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            labels: Labels::default(),
            navigation: NavigationSettings::default(),
            control: CourseSpeedConfig::default(),
            guidance: GuidanceConfig::default(),
            path: PathConfig::default(),
            path_report: Duration::from_secs(1),
            remote: RemoteConfig::default(),
            longest_key_age: Duration::from_secs(1),
            node: NodeSettings::default(),
            names: BTreeMap::new(),
            watch: WatchSettings::default(),
            mission: MissionSettings::default(),
            grounding: GroundingSettings::default(),
            power: Vec::new(),
            hydrophone: HydrophoneSettings::default(),
        }
    }
}

/// A power channel of the configuration.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PowerChannel {
    /// Its name, as consoles use it.
    pub name: String,
    /// The power rail that it hangs on, from 0.
    pub rail: u8,
}
