//! Ports: byte streams to and from the devices.
//!
//! A [`Place`] names one, a `port::Port` is an open one, and a [`Station`] is the thread that serves it: it opens the port,
//! passes received bytes with their time to a [`drivers::Driver`], sends the driver's output, and reopens the port when it
//! was lost. [`Pty`] is the other end of a port, for simulated devices. This module does not interpret any device's
//! protocol.

mod backoff;
mod bus_lock;
mod open_error;
mod outbox;
mod place;
mod port;
mod pty;
mod serial;
mod station;
mod wake;

pub(crate) use place::Place;
pub(crate) use pty::Pty;
pub(crate) use serial::Serial;
pub(crate) use station::{Report, Station};
pub(crate) use wake::Wake;
