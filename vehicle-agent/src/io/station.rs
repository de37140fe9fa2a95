//! The thread that serves one port: it opens and reopens it, and runs its driver with the clock.
//!
//! The driver never blocks: its output goes through an [`Outbox`], its reports to a [`Sink`]. A port that cannot be opened
//! is tried again after waits that double from half a second to ten seconds.

use super::backoff::Backoff;
use super::outbox::Outbox;
use super::place::Place;
use super::port::{Got, Port};
use super::wake::Wake;
use crate::clock::Clock;
use anyhow::Context as _;
use devices::Reading;
use drivers::{Driver, Input, Note, Output, State};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver};
use std::time::Duration;
use units::{MonoTime, Now};

/// Bytes read at once.
const BUFFER: usize = 4096;
/// Reads before the driver's deadlines are checked again, so that a babbling device cannot delay them.
const READS_AT_ONCE: usize = 16;
/// The longest wait before the clock is read again: recordings are timed by it.
const LONGEST_WAIT: Duration = Duration::from_millis(500);
/// How often recordings are read.
const RECORDING_WAIT: Duration = Duration::from_millis(20);
/// Pause after a write that the port did not accept: a CAN socket reports that it is writable while its queue is full, as
/// it is without a device that acknowledges.
const TOOK_NOTHING: Duration = Duration::from_millis(10);
/// How long the end waits for the last bytes.
const LAST_BYTES: Duration = Duration::from_millis(300);

/// A report of a driver.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Report {
    /// The device has read something, at this moment.
    Reading(Now, Reading),
    /// The state of the device has changed.
    State(State),
    /// Something for the log.
    Note(Note),
}

/// Receives a driver's reports. It must not wait.
pub(crate) trait Sink: Send {
    /// Takes one report.
    fn take(&self, report: Report);
}

impl<F: Fn(Report) + Send> Sink for F {
    fn take(&self, report: Report) {
        self(report);
    }
}

/// A port with its own thread.
#[derive(Debug)]
pub(crate) struct Station {
    wake: Arc<Wake>,
    ended: Receiver<()>,
}

impl Station {
    /// Starts to serve a port. `wake` is the thread's bell: other threads ring it after giving the driver new orders, and
    /// the driver gets [`Input::Time`].
    ///
    /// # Errors
    /// When no thread can be started.
    pub(crate) fn start(
        name: &str,
        driver: Box<dyn Driver + Send>,
        place: Place,
        clock: Clock,
        wake: Arc<Wake>,
        sink: impl Sink + 'static,
    ) -> anyhow::Result<Self> {
        let (end, ended) = mpsc::channel();
        let attendant = Attendant::new(driver, place, clock, Arc::clone(&wake), Box::new(sink));
        let attend = move || {
            attendant.attend();
            end.send(()).ok();
        };
        std::thread::Builder::new().name(name.to_owned()).spawn(attend).context("a thread for a port")?;
        Ok(Self { wake, ended })
    }

    /// Ends the thread, after the driver's last output.
    pub(crate) fn end(&self) {
        self.wake.end();
    }

    /// Waits for the end of the thread; returns whether it came in time.
    pub(crate) fn is_over_within(&self, longest: Duration) -> bool {
        self.ended.recv_timeout(longest) != Err(mpsc::RecvTimeoutError::Timeout)
    }
}

/// State of the thread.
struct Attendant {
    driver: Box<dyn Driver + Send>,
    place: Place,
    clock: Clock,
    wake: Arc<Wake>,
    sink: Box<dyn Sink>,
    port: Option<Port>,
    outbox: Outbox,
    backoff: Backoff,
    /// When to open the port, while it is not open.
    open_at: MonoTime,
    /// When to offer the port bytes again, after it took none.
    write_at: MonoTime,
    /// When the port was opened, or data came last.
    heard: MonoTime,
    /// A recording has ended, and is not played again.
    over: bool,
    state: Option<State>,
    /// Whether the outbox was full at the last check.
    full: bool,
}

impl Attendant {
    fn new(
        driver: Box<dyn Driver + Send>,
        place: Place,
        clock: Clock,
        wake: Arc<Wake>,
        sink: Box<dyn Sink>,
    ) -> Self {
        Self {
            driver,
            place,
            clock,
            wake,
            sink,
            port: None,
            outbox: Outbox::default(),
            backoff: Backoff::new(),
            open_at: MonoTime::default(),
            write_at: MonoTime::default(),
            heard: MonoTime::default(),
            over: false,
            state: None,
            full: false,
        }
    }

    fn attend(mut self) {
        let mut buffer = vec![0; BUFFER];
        while !self.wake.is_ending() {
            self.open();
            self.tick();
            self.write();
            self.wait();
            if self.wake.was_rung() {
                self.tell(Input::Time);
            }
            self.read(&mut buffer);
        }
        self.last_bytes();
    }

    /// Opens the port if it is closed and it is time to.
    fn open(&mut self) {
        if self.port.is_some() || self.over || self.clock.now().mono < self.open_at {
            return;
        }
        match Port::open(&self.place) {
            Ok(port) => {
                self.port = Some(port);
                self.heard = self.clock.now().mono;
                self.tell(Input::Opened);
            }
            Err(error) => {
                self.open_at = self.clock.now().mono + self.backoff.failed();
                self.say(State::Failing(error.to_string()));
            }
        }
    }

    /// The driver's deadline, when it is due.
    fn tick(&mut self) {
        let now = self.clock.now().mono;
        if self.driver.poll_timeout().is_some_and(|due| due <= now) {
            self.tell(Input::Time);
        }
        let dead = self.driver.longest_silence().filter(|longest| now.since(self.heard) >= *longest);
        if let (Some(Port::Tcp(_)), Some(longest)) = (&self.port, dead) {
            self.lost(&format!("nothing came for {} s", longest.as_secs_f64()));
        }
    }

    /// Passes an input to the driver and takes its outputs.
    fn tell(&mut self, input: Input<'_>) {
        let now = self.clock.now();
        self.driver.handle(now, input);
        while let Some(output) = self.driver.poll_output() {
            match output {
                Output::Reading { at, reading } => self.sink.take(Report::Reading(at, reading)),
                Output::Send { bytes, at, pace } => {
                    let fits = self.port.is_none() || self.outbox.put(bytes, at, pace);
                    self.told_whether_it_fits(fits);
                }
                Output::Speed { baud, at } => {
                    let fits = self.port.is_none() || self.outbox.put_speed(baud, at);
                    self.told_whether_it_fits(fits);
                }
                Output::Newest { bytes, until } if self.port.is_some() => {
                    self.outbox.put_newest(bytes, until);
                }
                // Why a port is not open is known better here.
                Output::State(state) if self.port.is_some() => self.say(state),
                Output::State(_) | Output::Newest { .. } => {}
                Output::Note(note) => self.sink.take(Report::Note(note)),
            }
        }
    }

    /// Reports once that the outbox is full.
    fn told_whether_it_fits(&mut self, fits: bool) {
        if !fits && !self.full {
            let text = format!("{} takes nothing: what was to be sent is left out", self.place);
            self.sink.take(Report::Note(Note { warning: true, text }));
        }
        self.full = !fits;
    }

    /// Reports the state of the device, when it has changed.
    fn say(&mut self, state: State) {
        if self.state.as_ref() != Some(&state) {
            self.state = Some(state.clone());
            self.sink.take(Report::State(state));
        }
    }

    /// Writes due bytes, as many as the port accepts.
    fn write(&mut self) {
        loop {
            let now = self.clock.now().mono;
            if now < self.write_at {
                return;
            }
            let Some(port) = &mut self.port else { return };
            if let Some(baud) = self.outbox.speed_due(now) {
                // A port without this speed keeps its own; a lost one fails at the next write.
                if let Err(error) = port.set_speed(baud) {
                    tracing::warn!(%error, baud, "the port does not take this speed");
                }
                continue;
            }
            let Some(bytes) = self.outbox.due(now) else { return };
            match port.write(bytes) {
                Ok(0) => {
                    self.write_at = now + TOOK_NOTHING;
                    return;
                }
                Ok(count) => self.outbox.sent(now, count),
                Err(error) => return self.lost(&error.to_string()),
            }
        }
    }

    /// Passes received bytes to the driver.
    fn read(&mut self, buffer: &mut [u8]) {
        for _ in 0..READS_AT_ONCE {
            let Some(port) = &mut self.port else { return };
            match port.read(buffer) {
                Ok(Got::Bytes(count)) => {
                    self.backoff.worked();
                    self.heard = self.clock.now().mono;
                    self.tell(Input::Bytes(&buffer[..count]));
                }
                Ok(Got::Nothing) => return,
                Ok(Got::Ended) if matches!(port, Port::Recording(_)) => {
                    self.over = true;
                    return self.lost("the recording is over");
                }
                Ok(Got::Ended) => return self.lost("the other end hung up"),
                Err(error) => return self.lost(&error.to_string()),
            }
        }
    }

    /// The port is gone.
    fn lost(&mut self, why: &str) {
        self.port = None;
        self.outbox.clear();
        self.full = false;
        self.write_at = MonoTime::default();
        self.open_at = self.clock.now().mono + self.backoff.failed();
        self.tell(Input::Lost);
        let remedy =
            if self.over { "" } else { ": is the cable in? It is opened again as soon as it is there" };
        self.say(State::Failing(format!("{} was lost ({why}){remedy}", self.place)));
    }

    /// How long to wait at most.
    fn longest_wait(&self, now: MonoTime) -> Duration {
        let due = self.outbox.next_due().map(|due| due.max(self.write_at));
        let open_at = (self.port.is_none() && !self.over).then_some(self.open_at);
        let deadlines = [self.driver.poll_timeout(), due, open_at].into_iter().flatten();
        let longest = match &self.port {
            Some(Port::Recording(_)) => RECORDING_WAIT,
            _ => LONGEST_WAIT,
        };
        deadlines.map(|due| due.since(now)).fold(longest, Duration::min)
    }

    /// Waits for the port, the bell or the next deadline.
    fn wait(&self) {
        let wait = self.longest_wait(self.clock.now().mono);
        let timeout = Timespec { tv_sec: 0, tv_nsec: i64::from(wait.subsec_nanos()) };
        let bell = PollFd::new(&*self.wake, PollFlags::IN);
        // An interrupted wait is only shorter.
        match self.port.as_ref().and_then(Port::waits_at) {
            Some(fd) => poll(&mut [bell, PollFd::from_borrowed_fd(fd, PollFlags::IN)], Some(&timeout)).ok(),
            None => poll(&mut [bell], Some(&timeout)).ok(),
        };
    }

    /// Sends the driver's last output, within a short time limit.
    fn last_bytes(&mut self) {
        self.tell(Input::Time);
        let until = self.clock.now().mono + LAST_BYTES;
        while self.port.is_some() && self.outbox.next_due().is_some_and(|due| due <= until) {
            self.write();
            if self.clock.now().mono >= until {
                return;
            }
            self.wait();
            self.wake.was_rung();
        }
    }
}

#[cfg(test)]
mod tests;
