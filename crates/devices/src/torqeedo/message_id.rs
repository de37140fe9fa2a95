//! Which messages the bus knows, by number and by name.

/// The number of a message, 9 bits of the identifier. (The DUNE task reads eight of them, and so takes 256 for 0.)
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct MessageId(pub(super) u16);

impl MessageId {
    /// Text for a person who looks for faults.
    pub const TEXT: Self = Self(0);
    /// State of a power rail.
    pub const RAIL: Self = Self(3);
    /// Which channels of a rail are on.
    pub const OUTPUTS: Self = Self(8);
    /// Switches a channel.
    pub const OUTPUT_SET: Self = Self(9);
    /// How long the card has been on.
    pub const UPTIME: Self = Self(10);
    /// A motor's speed, power and temperature.
    pub const MOTOR_DRIVE: Self = Self(12);
    /// Throttles of both motors.
    pub const MOTOR_SET: Self = Self(13);
    /// A battery's state.
    pub const BATTERY_STATUS: Self = Self(14);
    /// A battery's controller.
    pub const BATTERY_CONTROL: Self = Self(15);
    /// A motor's errors and status.
    pub const MOTOR_STATUS: Self = Self(16);
    /// Who made the card, and which it is.
    pub const ID_V2: Self = Self(21);

    /// The number.
    pub const fn number(self) -> u16 {
        self.0
    }

    /// Its name in the card's documents; `None` of a number they do not list.
    pub const fn name(self) -> Option<&'static str> {
        Some(match self.0 {
            0 => "TEXT",
            1 => "CAP_AMP",
            2 => "CAP_WATT",
            3 => "RAIL",
            4 => "HOUSEKEEPING",
            5 => "TEMPERATURE",
            6 => "ID",
            7 => "BATCELLS",
            8 => "OUTPUTS",
            9 => "OUTPUT_SET",
            10 => "UPTIME",
            11 => "BOOTLOADER",
            12 => "TQ_MOTOR_DRIVE",
            13 => "TQ_MOTOR_SET",
            14 => "TQ_BAT_STATUS",
            15 => "TQ_BATCTL",
            16 => "TQ_MOTOR_STATUS_BITS",
            17 => "RESET",
            18 => "WINCH_TELEMETRY",
            19 => "WINCH_COMMAND",
            20 => "WINCH_MOVING",
            21 => "ID_V2",
            _ => return None,
        })
    }
}

impl std::fmt::Display for MessageId {
    /// Name and number, as `RAIL (3)`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.name() {
            Some(name) => write!(f, "{name} ({})", self.0),
            None => write!(f, "message {}", self.0),
        }
    }
}
