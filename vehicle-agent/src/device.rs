//! The devices that have drivers: what people, the log book and the parts of the vessel call them.

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

    /// The part that its warnings are of in the log book. The card of the motors has no part of its own.
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

    /// The parts of the vessel whose state it is.
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
