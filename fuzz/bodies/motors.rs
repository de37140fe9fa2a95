//! What must hold for the driver of the motor card, whatever comes over the bus and whatever is commanded: no throttle outlives its
//! command, and what waits is bounded. The fuzz target calls this with bytes of its own making, and `make test` with the
//! committed seeds and everything that was ever found.

use devices::Pair;
use devices::torqeedo::{CanFrame, CardCommand};
use drivers::motors::{ChannelConfig, Motors, MotorsConfig, MotorsOutput};
use std::time::Duration;
use units::{MonoTime, Now, UtcTime};

/// More than any outcome of one event: throttle, power channels, state, notes and readings.
const MOST_WAITING: usize = 1 + 96 + 1 + 32 + 256;
const NAMES: [&str; 3] = ["motor", "lamp", "unknown"];

struct Bench {
    motors: Motors,
    ms: u64,
    given_ms: Option<u64>,
}

impl Bench {
    fn now(&self) -> Now {
        Now { mono: MonoTime::from_micros(self.ms * 1000), utc: UtcTime::from_micros(self.ms as i64 * 1000) }
    }

    /// One event by its number, with what it takes of the rest.
    fn event(&mut self, kind: u8, rest: &[u8]) -> usize {
        let byte = |at: usize| rest.get(at).copied().unwrap_or(0);
        let now = self.now();
        match kind % 8 {
            0 | 1 => {
                self.ms += u64::from(byte(0)) * 4;
                self.motors.tick(self.now());
                1
            }
            2 => {
                let value = f64::from(i16::from_le_bytes([byte(0), byte(1)])) / 1000.0;
                let throttle = if byte(0) == 0xFF { f64::NAN } else { value };
                self.given_ms = Some(self.ms);
                self.motors.command(now, Pair::new(value, throttle));
                2
            }
            3 => {
                self.motors.switch(now, NAMES[usize::from(byte(0)) % NAMES.len()], byte(1) & 1 == 1).ok();
                2
            }
            4 if byte(0) & 1 == 0 => {
                self.motors.opened(now);
                1
            }
            4 => {
                self.motors.lost(now);
                1
            }
            kind => {
                // The card's own messages, or any identifier.
                let any = u32::from_le_bytes([byte(0), byte(1), byte(2), byte(3)]) & 0x1FFF_FFFF;
                let id = if kind == 5 { any } else { u32::from(byte(0) & 0x1F) << 20 | 0xABFF };
                let data = rest.get(4..).unwrap_or_default();
                let data = &data[..data.len().min(usize::from(byte(1) % 9))];
                self.motors.handle(now, &CanFrame::new(id, data).expect("29 bits and eight bytes at most"));
                4 + data.len()
            }
        }
    }

    fn poll(&mut self) {
        for waiting in 0.. {
            let Some(output) = self.motors.poll_output() else { return };
            assert!(waiting < MOST_WAITING);
            let (MotorsOutput::Throttle { frame, .. } | MotorsOutput::Frame(frame)) = output else {
                continue;
            };
            let CardCommand::MotorSet(set) = CardCommand::parse(&frame).expect("the card obeys it") else {
                continue;
            };
            let alive = self.given_ms.is_some_and(|given| self.ms < given + 500);
            assert!(alive || set == Pair::new(0, 0), "{set:?} without a command");
        }
    }
}

/// Runs the driver by events that the bytes stand for.
pub(crate) fn motor_card(data: &[u8]) {
    let channel = |name: &str, rail| ChannelConfig { name: name.to_owned(), rail, channel: 0, on: true };
    let config = MotorsConfig {
        command_timeout: Duration::from_millis(500),
        channels: vec![channel(NAMES[0], 0), channel(NAMES[1], 3)],
        ..MotorsConfig::default()
    };
    let motors = Motors::new(config).expect("two channels on two rails");
    let mut bench = Bench { motors, ms: 0, given_ms: None };
    bench.motors.opened(bench.now());
    let mut rest = data;
    while let Some((kind, after)) = rest.split_first() {
        let taken = bench.event(*kind, after);
        rest = after.get(taken..).unwrap_or_default();
        bench.poll();
    }
}
