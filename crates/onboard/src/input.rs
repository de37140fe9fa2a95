//! The inputs of the brain: readings of the devices, the health of its computer, packets, and the passing of time.
//!
//! Readings are as the devices gave them, invalid ones included. [`Navigation`](crate::Navigation) and the other parts
//! that use them refuse those. SI units and radians.

use crate::entity::Entity;
use crate::grounding::ChartFile;
use crate::lease::{Lease, Mandate};
use crate::peer::Peer;
use crate::routing::RouteAnswer;
use crate::states::Condition;
use devices::Reading;
use mission::Ticket;
use std::net::SocketAddrV4;
use units::MonoTime;

/// An input of the brain.
#[derive(Debug, Clone, PartialEq)]
pub enum Input {
    /// Only time has passed.
    Timer,
    /// A device has read something, at this moment: a line of a slow port has been under way for a while, and a loop that was
    /// held up takes it later still.
    Reading(MonoTime, Reading),
    /// How the device behind a part of the vessel is, as its driver knows it.
    Device(DeviceState),
    /// A driver warns of something about a part that is not the state of it.
    Warning(Entity, String),
    /// The computer's own state.
    Host(HostReading),
    /// Bytes of one packet from a peer.
    Packet(Peer, Vec<u8>),
    /// Bytes of one packet from the shore, and under what it comes.
    Order(Peer, Mandate, Vec<u8>),
    /// The shore reports who commands the vessel.
    Lease(Lease),
    /// Another sea chart came, to take the place of the one in force as soon as that is safe.
    Chart(ChartFile),
    /// The result of a search for a route.
    Route(RouteAnswer),
    /// A peer connected by TCP.
    Connected(Peer),
    /// A peer is gone.
    Disconnected(Peer),
    /// Addresses at which this system can be reached.
    Reachable(Reachable),
    /// A log was opened under this name, or could not be.
    LogOpened(Result<String, String>),
    /// A change of the plans is on the disk, or could not be brought there.
    Stored(Ticket, Result<(), String>),
    /// The parameters of the entity with this label are on the disk for the next start, or could not be brought
    /// there.
    ParametersKept(String, Result<(), String>),
    /// Another write to disk failed.
    NotKept(String),
    /// The program is about to end: motors first.
    Shutdown,
}

/// How the device behind a part of the vessel is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DeviceState {
    /// The part.
    pub entity: Entity,
    /// How it is: [`Condition::Boot`] until it has answered.
    pub condition: Condition,
    /// Its fault and the remedy, in one sentence; empty if it has no fault.
    pub text: String,
}

/// Where this system listens.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Reachable {
    /// Sockets of UDP.
    pub udp: Vec<SocketAddrV4>,
    /// Sockets of TCP.
    pub tcp: Vec<SocketAddrV4>,
}

/// The state of the computer.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct HostReading {
    /// Load of the processor by this program; 100 is one of the processors (%).
    pub cpu_percent: f64,
    /// Load of all processors by all programs, where known (%).
    pub computer_cpu_percent: Option<f64>,
    /// Memory that programs can still have, as share of the whole, where known (%).
    pub memory_free_percent: Option<f64>,
    /// Free space where logs are kept (MiB).
    pub disk_free_mib: f64,
    /// The same as share of the whole (%).
    pub disk_free_percent: f64,
    /// Memory in use by this program (MiB).
    pub memory_mib: f64,
    /// Temperature of the processor (°C), where known.
    pub temperature_c: Option<f64>,
}
