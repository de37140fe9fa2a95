//! Addresses of systems: sixteen bits that say what kind of system it is.

use crate::catalogue::ADDRESSES;
use crate::crc;
use std::fmt;

/// A system's address.
///
/// Bits 15 to 13 select a group and for vehicles bits 12 to 10 the kind (LSTS IMC addressing scheme 1.1.0).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Address(pub u16);

impl Default for Address {
    fn default() -> Self {
        Self::NULL
    }
}

/// The group and kind that an address stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AddressKind {
    /// The destination of announcements.
    Announce,
    /// Autonomous underwater vehicle.
    Auv,
    /// Remotely operated vehicle.
    Rov,
    /// Autonomous surface vehicle.
    Asv,
    /// Unmanned air vehicle.
    Uav,
    /// A vehicle of a kind that the scheme does not name.
    Vehicle,
    /// Control unit: a console or server.
    Ccu,
    /// Payload sensor or module of a vehicle.
    Payload,
    /// Standalone sensor or gateway.
    Sensor,
    /// Reserved; DUNE gives unlisted names addresses here.
    Reserved,
    /// Every system.
    Broadcast,
    /// "Unset" as a source, "everyone" as a destination.
    Null,
}

impl Address {
    /// The destination of announcements.
    pub const ANNOUNCE: Self = Self(0);
    /// Every system.
    pub const BROADCAST: Self = Self(0xFFF0);
    /// "Unset" as a source, "everyone" as a destination.
    pub const NULL: Self = Self(0xFFFF);

    /// What kind of system has this address.
    pub fn kind(self) -> AddressKind {
        match (self, self.0 >> 13) {
            (Self::ANNOUNCE, _) => AddressKind::Announce,
            (Self::BROADCAST, _) => AddressKind::Broadcast,
            (Self::NULL, _) => AddressKind::Null,
            (_, 0 | 1) => match self.0 >> 10 & 0b111 {
                0 => AddressKind::Auv,
                1 => AddressKind::Rov,
                2 => AddressKind::Asv,
                3 => AddressKind::Uav,
                _ => AddressKind::Vehicle,
            },
            (_, 2) => AddressKind::Ccu,
            (_, 3) => AddressKind::Payload,
            (_, 4) => AddressKind::Sensor,
            _ => AddressKind::Reserved,
        }
    }

    /// Whether the address is of those that LSTS keeps for its own vehicles, payloads and sensors (`true`) or of
    /// those for everyone else's; `None` where the scheme does not say, as for control units.
    pub fn is_lsts(self) -> Option<bool> {
        match self.kind() {
            AddressKind::Auv
            | AddressKind::Rov
            | AddressKind::Asv
            | AddressKind::Uav
            | AddressKind::Vehicle => Some(self.0 < 0x2000),
            AddressKind::Payload => Some(self.0 < 0x7000),
            AddressKind::Sensor => Some(self.0 < 0x9000),
            AddressKind::Announce
            | AddressKind::Ccu
            | AddressKind::Reserved
            | AddressKind::Broadcast
            | AddressKind::Null => None,
        }
    }

    /// Whether a console or server has this address: its heartbeats keep telemetry flowing and vehicles
    /// from giving up the link.
    pub fn is_ccu(self) -> bool {
        self.kind() == AddressKind::Ccu
    }

    /// Whether this destination means every system.
    pub fn is_everyone(self) -> bool {
        matches!(self, Self::NULL | Self::BROADCAST | Self::ANNOUNCE)
    }

    /// The registered name, if any; the first in alphabetical order when there are several.
    pub fn name(self) -> Option<&'static str> {
        let first = ADDRESSES.partition_point(|(_, address)| *address < self.0);
        ADDRESSES.get(first).filter(|(_, address)| *address == self.0).map(|(name, _)| *name)
    }

    /// The address registered for `name`.
    pub fn of_name(name: &str) -> Option<Self> {
        ADDRESSES.iter().find(|(listed, _)| *listed == name).map(|(_, address)| Self(*address))
    }

    /// The address that DUNE gives a system whose name is not registered: 0xA000 plus the low 13 bits of
    /// the name's CRC-16 (LSTS DUNE, `IMC::AddressResolver`).
    pub fn for_unlisted_name(name: &str) -> Self {
        Self(0xA000 | crc::crc16(name.as_bytes()) & 0x1FFF)
    }

    /// The console address that Neptus makes from its IPv4 address: 0x4000 plus the low 13 bits of the last
    /// two octets.
    pub fn for_console(ip: std::net::Ipv4Addr) -> Self {
        let [_, _, third, fourth] = ip.octets();
        Self(0x4000 | u16::from_be_bytes([third, fourth]) & 0x1FFF)
    }
}

impl fmt::Display for Address {
    /// The registered name, else four hexadecimal digits.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.name() {
            Some(name) => f.pad(name),
            None => f.pad(&format!("{:#06x}", self.0)),
        }
    }
}

impl fmt::Display for AddressKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Announce => "destination of announcements",
            Self::Auv => "autonomous underwater vehicle",
            Self::Rov => "remotely operated vehicle",
            Self::Asv => "autonomous surface vehicle",
            Self::Uav => "unmanned air vehicle",
            Self::Vehicle => "vehicle",
            Self::Ccu => "control unit",
            Self::Payload => "payload sensor or module",
            Self::Sensor => "standalone sensor or gateway",
            Self::Reserved => "reserved",
            Self::Broadcast => "every system",
            Self::Null => "unset, or everyone",
        })
    }
}

/// Why text is not an address.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is neither a registered system nor a number from 0 to 65535 (0x...)")]
pub struct AddressError(String);

impl std::str::FromStr for Address {
    type Err = AddressError;

    /// A registered name, a decimal number or a hexadecimal one after `0x`.
    fn from_str(text: &str) -> Result<Self, AddressError> {
        let number = match text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
            Some(digits) => u16::from_str_radix(digits, 16).ok(),
            None => text.parse().ok(),
        };
        number.map(Self).or_else(|| Self::of_name(text)).ok_or_else(|| AddressError(text.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_otter_is_another_institutes_surface_vehicle() {
        let otter: Address = "ntnu-otter-01".parse().unwrap();
        assert_eq!(otter, Address(0x2810));
        assert_eq!(otter.kind(), AddressKind::Asv);
        assert_eq!(otter.is_lsts(), Some(false));
        assert_eq!(otter.to_string(), "ntnu-otter-01");
    }

    #[test]
    fn kinds_follow_the_bits() {
        for (address, kind, lsts) in [
            (0x0000, AddressKind::Announce, None),
            (0x0015, AddressKind::Auv, Some(true)),
            (0x0401, AddressKind::Rov, Some(true)),
            (0x0803, AddressKind::Asv, Some(true)),
            (0x0C01, AddressKind::Uav, Some(true)),
            (0x1C01, AddressKind::Vehicle, Some(true)),
            (0x2810, AddressKind::Asv, Some(false)),
            (0x4001, AddressKind::Ccu, None),
            (0x5FFF, AddressKind::Ccu, None),
            (0x6006, AddressKind::Payload, Some(true)),
            (0x7006, AddressKind::Payload, Some(false)),
            (0x8001, AddressKind::Sensor, Some(true)),
            (0x9001, AddressKind::Sensor, Some(false)),
            (0xA123, AddressKind::Reserved, None),
            (0xFFF0, AddressKind::Broadcast, None),
            (0xFFFF, AddressKind::Null, None),
        ] {
            let address = Address(address);
            assert_eq!((address.kind(), address.is_lsts()), (kind, lsts), "{address}");
        }
    }

    #[test]
    fn reads_numbers_and_names() {
        assert_eq!("0x4001".parse(), Ok(Address(0x4001)));
        assert_eq!("16385".parse(), Ok(Address(0x4001)));
        assert!("65536".parse::<Address>().is_err());
        assert!(
            "nobody"
                .parse::<Address>()
                .unwrap_err()
                .to_string()
                .starts_with("`nobody` is neither a registered")
        );
    }

    #[test]
    fn makes_addresses_as_others_do() {
        assert_eq!(Address::for_console([10, 0, 2, 15].into()), Address(0x420F));
        // The CRC of `123456789` is 0xBB3D.
        assert_eq!(Address::for_unlisted_name("123456789"), Address(0xBB3D));
        assert_eq!(Address::for_unlisted_name("A"), Address(0xB0C0));
    }
}
