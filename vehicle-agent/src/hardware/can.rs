//! The motors' driver on a byte port: CAN frames over an slcan adapter, or over the system's sockets.

use super::wire::{OnWire, Wire};
use control::MotorPair;
use devices::Pair;
use drivers::motors::{Motors, MotorsOutput};
use drivers::{Driver, Input, Note, Output, State};
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use units::{MonoTime, Now};

/// An adapter answers the initial commands within this time.
const ANSWERS: Duration = Duration::from_secs(1);
/// Interval of repeated initial commands to an adapter that is silent or refuses.
const GREET_AGAIN: Duration = Duration::from_secs(3);
/// How often in a row the log reports the repetition.
const MOST_TOLD: u32 = 3;
/// An adapter on a TCP stream that is silent for this long counts as dead.
const LONGEST_SILENCE: Duration = Duration::from_secs(10);

/// Orders that the card's driver has not taken yet: the last command to the motors with its time, and the last order of
/// each power channel. There are only the configured channels.
#[derive(Debug, Default)]
pub(crate) struct Orders(Mutex<Waiting>);

#[derive(Debug, Default)]
struct Waiting {
    motors: Option<(MonoTime, MotorPair)>,
    channels: BTreeMap<String, bool>,
}

impl Orders {
    /// Stores a command given at this time, replacing one that was not taken yet. Its life counts from then, not from when
    /// the port's thread, which may be delayed, takes it.
    pub(crate) fn put(&self, at: MonoTime, motors: MotorPair) {
        self.lock().motors = Some((at, motors));
    }

    /// Stores an order to switch a power channel, replacing one that was not taken yet.
    pub(crate) fn switch(&self, channel: &str, on: bool) {
        self.lock().channels.insert(channel.to_owned(), on);
    }

    fn take(&self) -> Waiting {
        std::mem::take(&mut *self.lock())
    }

    fn lock(&self) -> MutexGuard<'_, Waiting> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The driver of the motors on a byte port.
pub(crate) struct CanMotors {
    motors: Motors,
    wire: Wire,
    adapter: Adapter,
    orders: Arc<Orders>,
    outputs: VecDeque<Output>,
    /// The last command was a stop.
    stopped: bool,
    /// State of card and motors, from their driver.
    card: State,
    /// The last reported state.
    said: Option<State>,
}

impl CanMotors {
    /// Frames are written as `wire` has them; commands come through `orders`, whose owner wakes the port's thread.
    pub(crate) fn new(motors: Motors, wire: Wire, orders: Arc<Orders>) -> Self {
        let adapter = Adapter::default();
        let (outputs, card) = (VecDeque::new(), State::Starting);
        Self { motors, wire, adapter, orders, outputs, stopped: true, card, said: None }
    }

    fn obey(&mut self, now: Now, given: MonoTime, order: MotorPair) {
        let stop = order == MotorPair::STOPPED;
        // A stop goes ahead of the queue; repeated, it is refreshed like any command.
        if stop && !self.stopped {
            self.motors.stop(now);
        } else {
            self.motors.command_of(now, given, Pair::new(order.port, order.starboard));
        }
        self.stopped = stop;
    }

    /// Takes the driver's outputs; frames as bytes.
    fn collect(&mut self, now: Now) {
        while let Some(output) = self.motors.poll_output() {
            self.outputs.push_back(match output {
                MotorsOutput::Throttle { frame, until } => {
                    Output::Newest { bytes: self.wire.encode(&frame), until }
                }
                MotorsOutput::Frame(frame) => send(self.wire.encode(&frame), now.mono),
                MotorsOutput::Reading { at, reading } => Output::Reading { at, reading },
                MotorsOutput::State(state) => {
                    self.card = state;
                    continue;
                }
                MotorsOutput::Note(note) => Output::Note(note),
            });
        }
        let state = if self.adapter.refuses { refusing() } else { self.card.clone() };
        if self.said.as_ref() != Some(&state) {
            self.said = Some(state.clone());
            self.outputs.push_back(Output::State(state));
        }
    }

    /// Sends the adapter its initial commands, at the start and again if it may have lost them: after a short power loss it
    /// is closed although no cable was unplugged.
    fn greet(&mut self, now: MonoTime) {
        let Some(greeting) = self.wire.greeting() else { return };
        self.outputs.push_back(send(greeting, now));
        let text = match self.adapter.greeted {
            None => "the CAN adapter was told the bus' speed and to take part",
            Some(_) => {
                "the CAN adapter is told the bus' speed and to take part again: nothing comes of it, or it refuses"
            }
        };
        if self.adapter.times < MOST_TOLD {
            self.outputs.push_back(Output::Note(Note { warning: false, text: text.to_owned() }));
        }
        self.adapter.greet(now);
    }

    fn bytes(&mut self, now: Now, bytes: &[u8]) {
        let Self { motors, wire, adapter, .. } = self;
        wire.feed(bytes, |heard| match heard {
            OnWire::Frame(frame) => {
                adapter.heard(now.mono);
                motors.handle(now, &frame);
            }
            OnWire::Taken => adapter.took(now.mono),
            OnWire::Refused => adapter.refused(now.mono),
        });
    }
}

/// State of the adapter.
#[derive(Debug, Default)]
struct Adapter {
    /// When the initial commands were sent last, and how often since the last frame.
    greeted: Option<MonoTime>,
    times: u32,
    /// When a frame of the bus came.
    heard: Option<MonoTime>,
    /// It has refused a frame since it last accepted one, and how often the initial commands were repeated since.
    refused: bool,
    told: u32,
    /// It still refuses after the initial commands were repeated.
    refuses: bool,
}

impl Adapter {
    fn greet(&mut self, now: MonoTime) {
        self.greeted = Some(now);
        self.times += 1;
        self.told += u32::from(self.refused);
    }

    fn heard(&mut self, now: MonoTime) {
        self.heard = Some(now);
        self.times = 0;
    }

    /// Whether its message may be an answer to the initial commands. A closed adapter refuses to be closed, and some refuse
    /// empty lines: that says nothing about frames.
    fn answers(&self, now: MonoTime) -> bool {
        self.greeted.is_some_and(|at| now.since(at) < ANSWERS)
    }

    fn took(&mut self, now: MonoTime) {
        if !self.answers(now) {
            (self.refused, self.told, self.refuses) = (false, 0, false);
        }
    }

    fn refused(&mut self, now: MonoTime) {
        if !self.answers(now) {
            self.refused = true;
            self.refuses |= self.told > 1;
        }
    }

    /// When to send the initial commands again.
    fn again_at(&self) -> Option<MonoTime> {
        let greeted = self.greeted?;
        let heard = self.heard.filter(|_| !self.refused).unwrap_or(greeted);
        Some(heard.max(greeted) + GREET_AGAIN)
    }
}

fn refusing() -> State {
    let text = "the CAN adapter refuses what it is to send, although it is told the bus' speed and to take part every few \
                seconds: look at the CAN cable (without another device on the bus nothing can be sent) and at `CAN Port - Bit Rate`; \
                else unplug the adapter and plug it in again";
    State::Failing(text.to_owned())
}

fn send(bytes: Vec<u8>, at: MonoTime) -> Output {
    Output::Send { bytes, at, pace: Duration::ZERO }
}

impl Driver for CanMotors {
    fn handle(&mut self, now: Now, input: Input<'_>) {
        match input {
            Input::Opened => {
                self.wire.reset();
                self.adapter = Adapter::default();
                self.greet(now.mono);
                self.motors.opened(now);
            }
            Input::Bytes(bytes) => self.bytes(now, bytes),
            Input::Lost => {
                self.adapter = Adapter::default();
                self.motors.lost(now);
            }
            Input::Time => {}
        }
        let Waiting { motors, channels } = self.orders.take();
        // Motors first: a stop waits for nothing.
        if let Some((given, order)) = motors {
            self.obey(now, given, order);
        }
        for (channel, on) in channels {
            if let Err(unknown) = self.motors.switch(now, &channel, on) {
                self.outputs.push_back(Output::Note(Note { warning: true, text: unknown.to_string() }));
            }
        }
        if self.adapter.again_at().is_some_and(|at| at <= now.mono) {
            self.greet(now.mono);
        }
        self.motors.tick(now);
        self.collect(now);
    }

    fn poll_output(&mut self) -> Option<Output> {
        self.outputs.pop_front()
    }

    fn poll_timeout(&self) -> Option<MonoTime> {
        self.motors.poll_timeout().into_iter().chain(self.adapter.again_at()).min()
    }

    fn longest_silence(&self) -> Option<Duration> {
        Some(LONGEST_SILENCE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use devices::slcan::{Bitrate, encode};
    use devices::torqeedo::{CardCommand, CardReport};
    use drivers::motors::{ChannelConfig, MotorsConfig};
    use units::UtcTime;

    fn at(ms: u64) -> Now {
        Now { mono: MonoTime::from_micros(ms * 1000), utc: UtcTime::default() }
    }

    fn frame_of(bytes: &[u8]) -> Option<devices::can::CanFrame> {
        let mut found = None;
        Wire::slcan(Bitrate::K500).feed(bytes, |heard| {
            if let OnWire::Frame(frame) = heard {
                found = Some(frame);
            }
        });
        found
    }

    /// Outputs of a driver, from a time on.
    #[derive(Debug, Default)]
    struct Wanted {
        throttles: Vec<Pair<i16>>,
        greetings: usize,
        power: Vec<(u8, u8, bool)>,
        states: Vec<State>,
        warnings: Vec<String>,
    }

    fn wanted(driver: &mut CanMotors) -> Wanted {
        let mut all = Wanted::default();
        while let Some(output) = driver.poll_output() {
            match output {
                Output::Newest { bytes, .. } => {
                    let Some(Ok(CardCommand::MotorSet(set))) =
                        frame_of(&bytes).map(|frame| CardCommand::parse(&frame))
                    else {
                        panic!("{bytes:?}")
                    };
                    all.throttles.push(set);
                }
                Output::Send { bytes, .. } if bytes == GREETING => all.greetings += 1,
                Output::Send { bytes, .. } => {
                    match frame_of(&bytes).map(|frame| CardCommand::parse(&frame)) {
                        Some(Ok(CardCommand::OutputSet { rail, channel, on })) => {
                            all.power.push((rail, channel, on));
                        }
                        other => panic!("{other:?}"),
                    }
                }
                Output::State(state) => all.states.push(state),
                Output::Note(note) if note.warning => all.warnings.push(note.text),
                Output::Note(_) | Output::Reading { .. } | Output::Speed { .. } => {}
            }
        }
        all
    }

    const GREETING: &[u8] = b"\r\r\rC\rS6\rO\r";
    const AHEAD: MotorPair = MotorPair { port: 0.5, starboard: -0.25 };

    fn driver(config: MotorsConfig) -> (CanMotors, Arc<Orders>) {
        let orders = Arc::new(Orders::default());
        let wire = Wire::slcan(Bitrate::K500);
        (CanMotors::new(Motors::new(config).unwrap(), wire, Arc::clone(&orders)), orders)
    }

    #[test]
    fn orders_reach_the_bus_and_end_by_themselves() {
        let (mut driver, orders) = driver(MotorsConfig::default());
        driver.handle(at(0), Input::Opened);
        assert_eq!(wanted(&mut driver).greetings, 1);
        // The loop commands for a second, and then hangs.
        let mut sent = Vec::new();
        for ms in (0..2000).step_by(50) {
            if ms < 1000 {
                orders.put(at(ms).mono, AHEAD);
            }
            driver.handle(at(ms), Input::Time);
            sent.extend(wanted(&mut driver).throttles.into_iter().map(|set| (ms, set)));
        }
        let moving = Pair::new(500, -250);
        assert!(sent.iter().filter(|(_, set)| *set == moving).count() >= 4, "{sent:?}");
        let last = sent.iter().rfind(|(_, set)| *set != Pair::default()).unwrap().0;
        assert!((950..1500).contains(&last), "{sent:?}");
        assert_eq!(sent.last().unwrap().1, Pair::default());
    }

    #[test]
    fn an_order_that_waited_for_the_port_to_open_is_as_old_as_it_is() {
        let (mut driver, orders) = driver(MotorsConfig::default());
        // The thread was blocked in opening its port for two seconds.
        orders.put(at(1000).mono, AHEAD);
        driver.handle(at(3000), Input::Opened);
        let mut sent = wanted(&mut driver).throttles;
        for ms in (3000..4000).step_by(50) {
            driver.handle(at(ms), Input::Time);
            sent.extend(wanted(&mut driver).throttles);
        }
        assert!(sent.len() >= 4 && sent.iter().all(|set| *set == Pair::default()), "{sent:?}");
    }

    #[test]
    fn a_stop_goes_out_at_once() {
        let (mut driver, orders) = driver(MotorsConfig::default());
        driver.handle(at(0), Input::Opened);
        orders.put(at(250).mono, MotorPair { port: 1.0, starboard: 1.0 });
        driver.handle(at(250), Input::Time);
        wanted(&mut driver);
        orders.put(at(251).mono, MotorPair::STOPPED);
        driver.handle(at(251), Input::Time);
        assert_eq!(wanted(&mut driver).throttles, [Pair::default()]);
    }

    #[test]
    fn an_adapter_of_which_nothing_comes_is_told_again_every_few_seconds() {
        let (mut driver, _orders) = driver(MotorsConfig::default());
        driver.handle(at(0), Input::Opened);
        let report = CardReport::Outputs { rail: 0, channels: 1 };
        let mut greeted = Vec::new();
        for ms in (0..20_000).step_by(100) {
            // It works, restarts after six seconds, and delivers frames again after the initial commands.
            let works = ms < 6000 || greeted.iter().any(|at| *at >= 12_000);
            if works && ms % 500 == 0 {
                driver.handle(at(ms), Input::Bytes(&encode(&report.frame())));
            }
            driver.handle(at(ms), Input::Time);
            assert!(driver.poll_timeout().unwrap() > at(ms).mono);
            greeted.extend((0..wanted(&mut driver).greetings).map(|_| ms));
        }
        assert_eq!(greeted, [0, 8500, 11_500, 14_500]);
    }

    #[test]
    fn an_adapter_that_refuses_is_told_again_and_if_that_does_not_help_its_state_says_so() {
        let (mut driver, _orders) = driver(MotorsConfig::default());
        driver.handle(at(0), Input::Opened);
        let report = CardReport::Outputs { rail: 0, channels: 1 };
        let (mut greeted, mut states) = (Vec::new(), Vec::new());
        for ms in (0..16_000).step_by(100) {
            // A closed adapter refuses each frame and to be closed; from ten seconds on it takes them.
            let answer: &[u8] = if ms == 0 || (2000..10_000).contains(&ms) { b"\x07" } else { b"Z\r" };
            driver.handle(at(ms), Input::Bytes(answer));
            driver.handle(at(ms), Input::Bytes(&encode(&report.frame())));
            let wanted = wanted(&mut driver);
            greeted.extend((0..wanted.greetings).map(|_| ms));
            states.extend(wanted.states.into_iter().map(|state| (ms, state)));
        }
        assert_eq!(greeted, [0, 3000, 6000, 9000]);
        let refuses = |state: &State| matches!(state, State::Failing(why) if why.contains("adapter refuses") && why.contains("Bit Rate"));
        let refusing: Vec<u64> =
            states.iter().filter(|(_, state)| refuses(state)).map(|(ms, _)| *ms).collect();
        assert_eq!(refusing, [7000], "{states:?}");
        let after = states.iter().find(|(ms, _)| *ms > 7000).unwrap();
        assert!(after.0 == 10_000 && !refuses(&after.1), "{states:?}");
    }

    #[test]
    fn a_power_channel_is_switched_on_the_bus_by_its_name() {
        let modem = ChannelConfig { name: "Modem".to_owned(), rail: 3, channel: 4, on: false };
        let (mut driver, orders) = driver(MotorsConfig { channels: vec![modem], ..MotorsConfig::default() });
        driver.handle(at(0), Input::Opened);
        wanted(&mut driver);
        orders.switch("Modem", false);
        orders.switch("Modem", true);
        orders.switch("Sonar", true);
        driver.handle(at(10), Input::Time);
        let Wanted { power, warnings, .. } = wanted(&mut driver);
        assert_eq!(power, [(3, 4, true)], "of two orders the last");
        assert!(
            matches!(&warnings[..], [note] if note.contains("`Sonar`") && note.contains("Modem")),
            "{warnings:?}"
        );
    }
}
