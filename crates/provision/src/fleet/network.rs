//! An IPv4 network such as 10.8.0.0/24.

use std::fmt;
use std::net::Ipv4Addr;

/// A network in which vessels and server have addresses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Network {
    base: Ipv4Addr,
    bits: u8,
}

impl Network {
    /// Reads `10.8.0.0/24`.
    ///
    /// # Errors
    /// In words: what is wrong and what to write.
    pub fn parse(text: &str) -> Result<Self, String> {
        let wrong = || "write an IPv4 network, like 10.8.0.0/24".to_owned();
        let (base, bits) = text.split_once('/').ok_or_else(wrong)?;
        let base: Ipv4Addr = base.parse().map_err(|_| wrong())?;
        let bits: u8 = bits.parse().map_err(|_| wrong())?;
        if !(8..=30).contains(&bits) {
            return Err("take 8 to 30 bits, like 10.8.0.0/24".to_owned());
        }
        let network = Self { base: Ipv4Addr::from(u32::from(base) & mask(bits)), bits };
        if network.base != base {
            return Err(format!("that is an address in it: write {network}"));
        }
        if !(base.is_private() || is_shared(base)) {
            return Err("take a private one, like 10.8.0.0/24".to_owned());
        }
        Ok(network)
    }

    /// Whether a host in it can have this address: the first (network) and last (broadcast) are reserved.
    pub fn has_host(self, address: Ipv4Addr) -> bool {
        let (address, base) = (u32::from(address), u32::from(self.base));
        address > base && address < base | !mask(self.bits)
    }

    /// The bits that all its addresses share, as a mask such as 255.255.255.0.
    pub fn mask(self) -> Ipv4Addr {
        mask(self.bits).into()
    }

    /// Bits that all its addresses share.
    pub const fn bits(self) -> u8 {
        self.bits
    }
}

impl fmt::Display for Network {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.base, self.bits)
    }
}

const fn mask(bits: u8) -> u32 {
    u32::MAX << (32 - bits as u32)
}

/// 100.64.0.0/10, which providers share among their customers (RFC 6598).
const fn is_shared(address: Ipv4Addr) -> bool {
    let [first, second, ..] = address.octets();
    first == 100 && second & 0xC0 == 64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_network_knows_its_addresses() {
        let network = Network::parse("10.8.0.0/24").unwrap();
        for (address, inside) in
            [([10, 8, 0, 0], false), ([10, 8, 0, 1], true), ([10, 8, 0, 254], true), ([10, 8, 0, 255], false)]
        {
            assert_eq!(network.has_host(address.into()), inside, "{address:?}");
        }
        assert!(!network.has_host([10, 9, 0, 1].into()));
        assert_eq!(network.to_string(), "10.8.0.0/24");
    }

    #[test]
    fn what_is_no_network_is_told_with_the_remedy() {
        for (text, told) in [
            ("10.8.0.1/24", "write 10.8.0.0/24"),
            ("10.8.0.0", "like 10.8.0.0/24"),
            ("10.8.0.0/31", "8 to 30"),
            ("8.8.8.0/24", "take a private one"),
            ("boat/24", "IPv4 network"),
        ] {
            let error = Network::parse(text).unwrap_err();
            assert!(error.contains(told), "{text}: {error}");
        }
    }
}
