//! A GNSS receiver behind gpsd, over TCP.
//!
//! gpsd is asked for the receiver's own sentences ([`Watch::Nmea`]), which [`Compass`] reads as from a port: nothing is lost
//! on the way, and epochs are the receiver's. For a receiver without NMEA, gpsd's own reports are used ([`Watch::Json`]):
//! each TPV is a reading, with the last SKY and ATT where they are fresh. The protocol is that of gpsd 3.20 and later
//! (gpsd_json(5)): commands and reports are lines; of an answer the longest line is kept.

mod report;

use crate::gnss::{Compass, CompassSettings};
use crate::outbox::Outbox;
use crate::{Driver, Input, Output, State};
use core::time::Duration;
use devices::Reading;
use devices::lines::{Lines, Piece};
use report::{Attitude, Report, Sky};
use units::{MonoTime, Now, wrap_two_pi};

/// The longest line kept (bytes): a SKY report of a hundred satellites.
pub const LONGEST: usize = 16_384;
/// A SKY report is good for so long; receivers send one each second or each five.
const SKY_FRESH: Duration = Duration::from_secs(10);
/// A heading is good for so long.
const HEADING_FRESH: Duration = Duration::from_millis(1500);

/// The reports requested from gpsd.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Watch {
    /// The receiver's sentences.
    #[default]
    Nmea,
    /// gpsd's own reports.
    Json,
}

impl Watch {
    const fn command(self) -> &'static str {
        match self {
            Self::Nmea => "?WATCH={\"enable\":true,\"nmea\":true}\r\n",
            Self::Json => "?WATCH={\"enable\":true,\"json\":true}\r\n",
        }
    }
}

/// The driver of a receiver behind gpsd. Its port is the connection.
#[derive(Debug, Clone)]
pub struct Gpsd {
    watch: Watch,
    heading_offset_rad: f64,
    input_timeout: Duration,
    lines: Lines,
    compass: Compass,
    sky: Option<(MonoTime, Sky)>,
    attitude: Option<(MonoTime, Attitude)>,
    /// By its own reports: when it fails unless one comes.
    deadline: Option<MonoTime>,
    /// Whether gpsd has said that it has no receiver.
    no_device: bool,
    outbox: Outbox,
}

impl Gpsd {
    /// A receiver behind a connection that is not open. `settings` hold for it as for a compass at a port, but for the
    /// initialisation strings: gpsd owns the receiver and sends its own.
    pub fn new(watch: Watch, settings: &CompassSettings) -> Self {
        let inner = CompassSettings { init: Vec::new(), ..settings.clone() };
        let mut outbox = Outbox::default();
        outbox.state(State::Starting);
        Self {
            watch,
            heading_offset_rad: settings.heading_offset_rad,
            input_timeout: settings.input_timeout,
            lines: Lines::new(None, LONGEST),
            compass: Compass::new(inner),
            sky: None,
            attitude: None,
            deadline: None,
            no_device: false,
            outbox,
        }
    }

    fn opened(&mut self, now: Now) {
        self.lines.clear();
        (self.sky, self.attitude, self.no_device) = (None, None, false);
        self.outbox.state(State::Starting);
        self.ask(now);
        match self.watch {
            Watch::Nmea => self.compass.handle(now, Input::Opened),
            Watch::Json => self.deadline = Some(now.mono + self.input_timeout),
        }
    }

    fn ask(&mut self, now: Now) {
        let bytes = self.watch.command().as_bytes().to_vec();
        self.outbox.push(Output::Send { bytes, at: now.mono, pace: Duration::ZERO });
    }

    fn bytes(&mut self, now: Now, bytes: &[u8]) {
        let mut found = Vec::new();
        self.lines.feed(bytes, |_, piece| {
            if let Piece::Line(line) = piece {
                found.push(line.to_vec());
            }
        });
        for mut line in found {
            if line.starts_with(b"{") {
                self.report(now, &line);
            } else if self.watch == Watch::Nmea {
                line.extend(b"\r\n");
                self.compass.handle(now, Input::Bytes(&line));
            }
        }
    }

    fn report(&mut self, now: Now, line: &[u8]) {
        match report::read(line) {
            Some(Report::Devices(count)) => self.no_device = count == 0,
            Some(Report::Error(text)) => self.outbox.note(true, format!("gpsd refuses: {text}")),
            // Both are asked for one at a time; what another client changed is not ours.
            Some(_) if self.watch == Watch::Nmea => {}
            Some(Report::Sky(sky)) => self.sky = Some((now.mono, sky)),
            Some(Report::Attitude(attitude)) => {
                let attitude = match self.attitude {
                    // Heading and rate of turn come by sentences of their own.
                    Some((then, known)) if now.mono.since(then) <= HEADING_FRESH => attitude.over(known),
                    _ => attitude,
                };
                self.attitude = Some((now.mono, attitude));
            }
            Some(Report::Position(position)) => {
                self.deadline = Some(now.mono + self.input_timeout);
                self.outbox.state(State::Working);
                let fresh = |then: MonoTime, limit| now.mono.since(then) <= limit;
                let sky = self.sky.filter(|(then, _)| fresh(*then, SKY_FRESH)).map(|(_, sky)| sky);
                let attitude =
                    self.attitude.filter(|(then, _)| fresh(*then, HEADING_FRESH)).map(|(_, one)| one);
                let mut reading = position.reading(sky, attitude);
                let offset_rad = self.heading_offset_rad;
                reading.heading_rad =
                    reading.heading_rad.map(|heading_rad| wrap_two_pi(heading_rad + offset_rad));
                self.outbox.push(Output::Reading { at: now, reading: Reading::Gnss(reading) });
            }
            None => {}
        }
    }

    /// Takes over the outputs of the inner compass; its remarks on cables are made about gpsd instead.
    fn relay(&mut self, now: Now) {
        while let Some(output) = self.compass.poll_output() {
            match output {
                Output::State(State::Failing(why)) => self.fail(now, &why),
                Output::State(state) => self.outbox.state(state),
                other => self.outbox.push(other),
            }
        }
    }

    fn fail(&mut self, now: Now, why: &str) {
        let text = if self.no_device {
            "gpsd has no receiver: check its cable, and the device that gpsd was started with".to_owned()
        } else {
            format!("gpsd gives no position: {why}; `gpsmon` shows what gpsd gets")
        };
        self.outbox.state(State::Failing(text));
        self.ask(now);
    }

    fn lost(&mut self, now: Now) {
        self.deadline = None;
        self.compass.handle(now, Input::Lost);
        // Its own text for that is about a cable.
        while let Some(output) = self.compass.poll_output() {
            if matches!(output, Output::Reading { .. }) {
                self.outbox.push(output);
            }
        }
        let why = "the connection to gpsd is gone: check that gpsd runs, at port 2947 as a rule";
        self.outbox.state(State::Failing(why.to_owned()));
    }

    fn time(&mut self, now: Now) {
        if self.compass.poll_timeout().is_some_and(|due| due <= now.mono) {
            self.compass.handle(now, Input::Time);
        }
        if self.deadline.is_some_and(|due| due <= now.mono) {
            self.deadline = Some(now.mono + self.input_timeout);
            self.fail(now, &format!("no report for {} s", self.input_timeout.as_secs_f64()));
        }
    }
}

impl Driver for Gpsd {
    fn longest_silence(&self) -> Option<Duration> {
        Some(2 * self.input_timeout)
    }

    fn handle(&mut self, now: Now, input: Input<'_>) {
        match input {
            Input::Opened => self.opened(now),
            Input::Bytes(bytes) => self.bytes(now, bytes),
            Input::Lost => self.lost(now),
            Input::Time => self.time(now),
        }
        self.relay(now);
    }

    fn poll_output(&mut self) -> Option<Output> {
        self.outbox.pop()
    }

    fn poll_timeout(&self) -> Option<MonoTime> {
        self.compass.poll_timeout().into_iter().chain(self.deadline).min()
    }
}

#[cfg(test)]
mod tests;
