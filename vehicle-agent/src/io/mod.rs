//! Ports: where the bytes of the devices come from and go to.
//!
//! A [`Place`] names one, a `port::Port` is one that is open, and a [`Station`] is the thread that attends it: it opens the port,
//! hands what comes to a [`drivers::Driver`] with the time, sends what that wants sent, and opens the port again when it was
//! lost. [`Pty`] is the other end of a port, for simulated devices. Nothing here knows what a device says.

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
