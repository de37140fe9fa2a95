//! The parts of the vessel that have a name and a state on the bus.
//!
//! Numbers are positions in [`Entity::ALL`]; consoles must map by label, and labels can be configured.

use std::collections::BTreeMap;

/// A part of the vessel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Entity {
    /// The whole.
    Daemon,
    /// Course and speed controller.
    Control,
    /// Thruster authority.
    Authority,
    /// Manual control.
    Remote,
    /// Path controller.
    Path,
    /// Maneuvers.
    Maneuver,
    /// Navigation.
    Navigation,
    /// Plan database.
    PlanDatabase,
    /// Plan engine.
    PlanEngine,
    /// GNSS compass.
    Gps,
    /// Port motor.
    MotorPort,
    /// Starboard motor.
    MotorStarboard,
    /// Vehicle supervisor.
    Supervisor,
    /// Entity monitor.
    Monitor,
    /// Lost communications.
    LostComms,
    /// Battery reserve.
    Fuel,
    /// Operational limits.
    Limits,
    /// Clock.
    Clock,
    /// Computer.
    Host,
    /// Log.
    Logger,
    /// Log book.
    LogBook,
    /// Announcements.
    Announcer,
    /// UDP.
    Udp,
    /// TCP.
    Tcp,
    /// Hydrophone.
    Hydrophone,
    /// First battery.
    Battery0,
    /// Second battery.
    Battery1,
    /// Third battery.
    Battery2,
    /// Fourth battery.
    Battery3,
    /// Grounding supervisor.
    Grounding,
    /// First power rail.
    Rail0,
    /// Second power rail.
    Rail1,
    /// Third power rail.
    Rail2,
    /// Fourth power rail.
    Rail3,
    /// Fifth power rail.
    Rail4,
    /// Watchdog of the computer's board.
    Watchdog,
    /// Signal light.
    Light,
    /// The parts that must be good before motors are armed.
    Preflight,
}

impl Entity {
    /// All, in the order of their numbers.
    pub const ALL: [Self; 38] = [
        Self::Daemon,
        Self::Control,
        Self::Authority,
        Self::Remote,
        Self::Path,
        Self::Maneuver,
        Self::Navigation,
        Self::PlanDatabase,
        Self::PlanEngine,
        Self::Gps,
        Self::MotorPort,
        Self::MotorStarboard,
        Self::Supervisor,
        Self::Monitor,
        Self::LostComms,
        Self::Fuel,
        Self::Limits,
        Self::Clock,
        Self::Host,
        Self::Logger,
        Self::LogBook,
        Self::Announcer,
        Self::Udp,
        Self::Tcp,
        Self::Hydrophone,
        Self::Battery0,
        Self::Battery1,
        Self::Battery2,
        Self::Battery3,
        Self::Grounding,
        Self::Rail0,
        Self::Rail1,
        Self::Rail2,
        Self::Rail3,
        Self::Rail4,
        Self::Watchdog,
        Self::Light,
        Self::Preflight,
    ];

    /// The number on the bus.
    pub const fn number(self) -> u8 {
        self as u8
    }

    /// The entity with this number.
    pub fn from_number(number: u8) -> Option<Self> {
        Self::ALL.get(usize::from(number)).copied()
    }

    /// The battery with this number, from 0.
    pub(crate) fn battery(number: u8) -> Option<Self> {
        [Self::Battery0, Self::Battery1, Self::Battery2, Self::Battery3].get(usize::from(number)).copied()
    }

    /// The power rail with this number, from 0.
    pub(crate) fn rail(number: u8) -> Option<Self> {
        [Self::Rail0, Self::Rail1, Self::Rail2, Self::Rail3, Self::Rail4].get(usize::from(number)).copied()
    }

    /// The usual label and the name of the task, as DUNE has them.
    pub const fn label_and_task(self) -> (&'static str, &'static str) {
        match self {
            Self::Daemon => ("Daemon", "Daemon"),
            Self::Control => ("Heading & Speed Controller", "Control.ASV.HeadingAndSpeed"),
            Self::Authority => ("Thruster Authority", "Control.Authority"),
            Self::Remote => ("Remote Control", "Control.ASV.RemoteOperation"),
            Self::Path => ("Path Control", "Control.Path.ILOS"),
            Self::Maneuver => ("Maneuver", "Maneuver.Multiplexer"),
            Self::Navigation => ("Navigation", "Navigation.General.GPSNavigation"),
            Self::PlanDatabase => ("Plan Database", "Plan.DB"),
            Self::PlanEngine => ("Plan Engine", "Plan.Engine"),
            Self::Gps => ("GPS", "Sensors.GPS"),
            Self::MotorPort => ("Motor Port", "Actuators.Torqeedo"),
            Self::MotorStarboard => ("Motor Starboard", "Actuators.Torqeedo"),
            Self::Supervisor => ("Vehicle Supervisor", "Supervisors.Vehicle"),
            Self::Monitor => ("Entity Monitor", "Monitors.Entities"),
            Self::LostComms => ("Lost Communications", "Supervisors.ASV.LostComms"),
            Self::Fuel => ("Fuel Monitor", "Monitors.FuelLevel"),
            Self::Limits => ("Operational Limits", "Supervisors.OperationalLimits"),
            Self::Clock => ("Clock Monitor", "Monitors.Clock"),
            Self::Host => ("Host Monitor", "Monitors.HostResources"),
            Self::Logger => ("Logger", "Transports.Logging"),
            Self::LogBook => ("Log Book", "Transports.LogBook"),
            Self::Announcer => ("Service Announcer", "Transports.Announce"),
            Self::Udp => ("UDP", "Transports.UDP"),
            Self::Tcp => ("TCP", "Transports.TCP.Server"),
            Self::Hydrophone => ("Hydrophone", "Sensors.ThelmaHydrophone"),
            Self::Battery0 => ("Battery 0", "Actuators.Torqeedo"),
            Self::Battery1 => ("Battery 1", "Actuators.Torqeedo"),
            Self::Battery2 => ("Battery 2", "Actuators.Torqeedo"),
            Self::Battery3 => ("Battery 3", "Actuators.Torqeedo"),
            Self::Grounding => ("Grounding Supervisor", "Supervisors.Grounding"),
            Self::Rail0 => ("Rail 0", "Actuators.Torqeedo"),
            Self::Rail1 => ("Rail 1", "Actuators.Torqeedo"),
            Self::Rail2 => ("Rail 2", "Actuators.Torqeedo"),
            Self::Rail3 => ("Rail 3", "Actuators.Torqeedo"),
            Self::Rail4 => ("Rail 4", "Actuators.Torqeedo"),
            Self::Watchdog => ("Watchdog", "Safety.StratoPIWatchdog"),
            Self::Light => ("Signal Light", "UserInterfaces.LEDs"),
            Self::Preflight => ("Preflight", "Supervisors.Preflight"),
        }
    }
}

/// The labels in use.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Labels {
    changed: BTreeMap<Entity, String>,
}

impl Labels {
    /// Gives an entity another label than its usual one.
    pub fn set(&mut self, entity: Entity, label: &str) {
        self.changed.insert(entity, label.to_owned());
    }

    /// The label of an entity.
    pub fn of(&self, entity: Entity) -> &str {
        self.changed.get(&entity).map_or(entity.label_and_task().0, String::as_str)
    }

    /// The entity with this label; of two with the same, the first.
    pub fn find(&self, label: &str) -> Option<Entity> {
        Entity::ALL.into_iter().find(|entity| self.of(*entity) == label)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_positions_and_labels_are_found() {
        for (position, entity) in Entity::ALL.into_iter().enumerate() {
            assert_eq!(usize::from(entity.number()), position);
            assert_eq!(Entity::from_number(entity.number()), Some(entity));
        }
        assert_eq!(Entity::from_number(Entity::ALL.len() as u8), None);
        let mut labels = Labels::default();
        labels.set(Entity::MotorPort, "Torqeedo - Motor 0");
        assert_eq!(labels.find("Torqeedo - Motor 0"), Some(Entity::MotorPort));
        assert_eq!(labels.find("Motor Port"), None);
        assert_eq!(labels.find("Daemon"), Some(Entity::Daemon));
    }
}
