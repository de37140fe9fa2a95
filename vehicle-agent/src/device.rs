//! The devices that have drivers: their names for people, for the log book and as entities.

use onboard::Entity;

/// A device with a driver of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Device {
    /// The GNSS compass.
    Compass,
    /// The card with motors, batteries and power channels.
    Motors,
    /// The receiver of fish tags.
    Hydrophone,
    /// The watchdog of the computer's board.
    Watchdog,
    /// The signal light.
    Light,
    /// The receiver's pulse per second, and chrony, which sets the computer's clock.
    Pulse,
}

impl Device {
    /// As people and the log call it.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Compass => "compass",
            Self::Motors => "motors",
            Self::Hydrophone => "hydrophone",
            Self::Watchdog => "watchdog",
            Self::Light => "signal light",
            Self::Pulse => "satellites' time",
        }
    }

    /// The entity of its warnings in the log book. The motor card has no entity of its own.
    pub(crate) const fn book(self) -> Entity {
        match self {
            Self::Compass => Entity::Gps,
            Self::Motors => Entity::Daemon,
            Self::Hydrophone => Entity::Hydrophone,
            Self::Watchdog => Entity::Watchdog,
            Self::Light => Entity::Light,
            Self::Pulse => Entity::Clock,
        }
    }

    /// The entities whose state depends on it.
    pub(crate) const fn entities(self) -> &'static [Entity] {
        match self {
            Self::Compass => &[Entity::Gps],
            Self::Motors => &[Entity::MotorPort, Entity::MotorStarboard],
            Self::Hydrophone => &[Entity::Hydrophone],
            Self::Watchdog => &[Entity::Watchdog],
            Self::Light => &[Entity::Light],
            Self::Pulse => &[Entity::Clock],
        }
    }
}
