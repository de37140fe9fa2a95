//! Only one of Lutra's programs may use a CAN bus.
//!
//! The system lets any number of programs send on a CAN interface. Two that command the motors, each with its own data
//! folder, would command them in turns. So a program first binds a name that the system gives to one process at a time, in
//! the same namespace as the interface, and releases when the process ends in any way.

use super::open_error::OpenError;
use std::io::ErrorKind;
use std::os::linux::net::SocketAddrExt as _;
use std::os::unix::net::{SocketAddr, UnixDatagram};

/// The lock of an interface, as long as this lives.
#[derive(Debug)]
pub(super) struct BusLock(#[expect(dead_code, reason = "it is held, not asked")] UnixDatagram);

impl BusLock {
    /// Locks an interface.
    ///
    /// # Errors
    /// When another program has it.
    pub(super) fn take(interface: &str) -> Result<Self, OpenError> {
        let name = format!("lutra-agent/can/{interface}");
        let socket =
            SocketAddr::from_abstract_name(&name).and_then(|address| UnixDatagram::bind_addr(&address));
        socket.map(Self).map_err(|error| {
            OpenError(if error.kind() == ErrorKind::AddrInUse {
                format!(
                    "CAN interface {interface}: another lutra-agent commands this bus; `pgrep -a lutra-agent` shows it, end one \
                     of both"
                )
            } else {
                format!("CAN interface {interface}: its name cannot be taken: {error}")
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bus_has_one_program_at_a_time() {
        let interface = format!("test{}", std::process::id());
        let first = BusLock::take(&interface).unwrap();
        let refused = BusLock::take(&interface).unwrap_err().to_string();
        assert!(refused.contains(&interface) && refused.contains("pgrep"), "{refused}");
        drop(first);
        BusLock::take(&interface).unwrap();
    }
}
