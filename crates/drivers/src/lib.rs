//! Drivers of the devices aboard: machines between the bytes of a port and [`Reading`]s.
//!
//! Each driver is one state machine without input, output, threads or clock: the owner of its port hands it what came
//! ([`Input`]) with the time, sends what it wants sent, and calls again when [`Driver::poll_timeout`] is due. So a test
//! sails an hour of a device's life in milliseconds, and the same machine serves a serial port, a socket and a recording.
//!
//! The bytes themselves are the codecs of [`devices`]; opening ports, hot-plugging and pacing are in
//! `vehicle-agent/src/io`. The crate knows `devices` and `units`, and nothing of IMC or of the vessel's brain.

pub mod gnss;
pub mod gpsd;
pub mod health;
pub mod hydrophone;
pub mod light;
pub mod line_receiver;
pub mod motors;
mod outbox;
pub mod watchdog;

use devices::Reading;
use units::{MonoTime, Now};

/// An event at a driver's port.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Input<'a> {
    /// The port is open, for the first time or again: the driver sends its settings and begins to listen.
    Opened,
    /// Bytes came, in pieces as the port gave them.
    Bytes(&'a [u8]),
    /// The port is gone, as when a cable was pulled.
    Lost,
    /// A deadline of [`Driver::poll_timeout`] is due.
    Time,
}

/// An output of a driver: a command for its port, or a result.
#[derive(Debug, Clone, PartialEq)]
pub enum Output {
    /// The device has read something. `at` is when the reading was taken aboard, as well as the driver knows.
    Reading {
        /// Time of the reading.
        at: Now,
        /// The reading.
        reading: Reading,
    },
    /// Bytes for the device, in their order; `pace` between two of them where the device takes no more.
    Send {
        /// The bytes to send.
        bytes: Vec<u8>,
        /// When the first byte is to leave; at once if that is past.
        at: MonoTime,
        /// Time from one byte to the next; zero sends all at once.
        pace: core::time::Duration,
    },
    /// Bytes for the device that go ahead of all that waits to be sent, in place of earlier ones of this kind that wait still.
    Newest {
        /// The bytes to send.
        bytes: Vec<u8>,
        /// From then on they must not begin to leave; `None` where they are always right.
        until: Option<MonoTime>,
    },
    /// The line goes over to another speed, once all that was to be sent before has left. A port without one ignores it.
    Speed {
        /// Which (bit/s).
        baud: u32,
        /// When at the earliest.
        at: MonoTime,
    },
    /// The state of the device is another.
    State(State),
    /// An entry for the log.
    Note(Note),
}

/// How a device is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum State {
    /// Its port is not open, or it has not answered yet.
    Starting,
    /// It works.
    Working,
    /// It does not do what it is for: why, and what to do, in one sentence.
    Failing(String),
}

/// A line for the log.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Note {
    /// Whether a person should look at it.
    pub warning: bool,
    /// The event.
    pub text: String,
}

/// A driver.
pub trait Driver {
    /// Takes in what happened. Times never go back.
    fn handle(&mut self, now: Now, input: Input<'_>);

    /// The next output; `None` when there is no more.
    fn poll_output(&mut self) -> Option<Output>;

    /// When to call [`handle`](Self::handle) with [`Input::Time`] at the latest; `None` while it waits for bytes alone.
    fn poll_timeout(&self) -> Option<MonoTime>;

    /// A stream that brings nothing for so long is dead, whatever the system says of it: it is opened again. `None` for a device
    /// that may rightly say nothing.
    fn longest_silence(&self) -> Option<core::time::Duration> {
        None
    }
}
