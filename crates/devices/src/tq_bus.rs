//! Frames of the Torqeedo's own bus (TQ bus, RS-485 at 19200 baud), for work at the bench without the interface card.
//!
//! A frame is 0xAC, the payload, the payload's CRC-8/Maxim, 0xAD. Within it the bytes 0xAC, 0xAD and 0xAE are sent as 0xAE
//! and the byte with its highest bit turned over. The payload begins with the address of the device and the number of the
//! message; numbers are big endian. Layout: github.com/nikkone/dune-otter, `Actuators/TQreader`, which follows ArduPilot's
//! Torqeedo driver. An answer is due within 25 ms of its request.

use thiserror::Error;

/// The most bytes of a frame between its ends, before stuffing: payload and CRC.
pub const MOST_BYTES: usize = 35;

/// So many bytes outside of any frame, as at a wrong speed, are reported without waiting for the next frame.
const MOST_OUTSIDE: u64 = 256;

const BEGIN: u8 = 0xAC;
const END: u8 = 0xAD;
const ESCAPE: u8 = 0xAE;
const TURNED: u8 = 0x80;

/// The computer that asks.
pub const MASTER: u8 = 0x00;
/// The remote throttle (tiller).
pub const REMOTE: u8 = 0x14;
/// The display.
pub const DISPLAY: u8 = 0x20;
/// The motor.
pub const MOTOR: u8 = 0x30;
/// The battery.
pub const BATTERY: u8 = 0x80;

/// Number of the display's report of the whole system.
const SYSTEM_STATE: u8 = 0x41;

/// CRC-8/Maxim (polynomial 0x31, both ways reflected, begun at zero), bit by bit: a frame has few bytes.
fn crc8_maxim(bytes: &[u8]) -> u8 {
    bytes.iter().fold(0, |crc, byte| {
        (0..8).fold(crc ^ byte, |crc: u8, _| if crc & 1 == 0 { crc >> 1 } else { crc >> 1 ^ 0x8C })
    })
}

/// The bytes of a payload on the bus; `None` of one that is too long.
pub fn encode(payload: &[u8]) -> Option<Vec<u8>> {
    (payload.len() < MOST_BYTES).then(|| framed(payload))
}

/// The answer of a tiller to the motor's question: the throttle in per mille, -1000 to 1000, beyond which it is held.
pub fn tiller_answer(per_mille: i16) -> Vec<u8> {
    let [high, low] = per_mille.clamp(-1000, 1000).to_be_bytes();
    framed(&[MASTER, 0, 5, 0, high, low])
}

/// The payload with its checksum, stuffed, between the ends of a frame.
fn framed(payload: &[u8]) -> Vec<u8> {
    let mut bytes = vec![BEGIN];
    for byte in payload.iter().copied().chain([crc8_maxim(payload)]) {
        if matches!(byte, BEGIN | END | ESCAPE) {
            bytes.extend([ESCAPE, byte ^ TURNED]);
        } else {
            bytes.push(byte);
        }
    }
    bytes.push(END);
    bytes
}

/// Whether a payload asks the tiller for its throttle.
pub fn asks_tiller(payload: &[u8]) -> bool {
    payload == [REMOTE, 1]
}

/// Why bytes of the bus are not a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum FrameError {
    /// The checksum is another.
    #[error("a frame of {len} bytes has the checksum {found:02X} and needs {computed:02X}")]
    Checksum {
        /// Bytes of payload.
        len: usize,
        /// The one sent.
        found: u8,
        /// The one of its payload.
        computed: u8,
    },
    /// Nothing between the ends but perhaps a checksum.
    #[error("a frame has no payload")]
    Empty,
    /// More bytes than a frame holds.
    #[error("more than {MOST_BYTES} bytes without the end of a frame")]
    TooLong,
    /// A frame began before the one before it ended.
    #[error("a frame of {len} bytes is cut off by the next")]
    Cut {
        /// Bytes received of it.
        len: usize,
    },
    /// Bytes outside of any frame.
    #[error("{len} bytes are outside of any frame")]
    Outside {
        /// How many.
        len: u64,
    },
}

/// The payload without its checksum, or what is wrong with the bytes.
pub type Deframed<'a> = Result<&'a [u8], FrameError>;

/// Finds frames in the bytes of the bus, in whatever pieces they come. It keeps [`MOST_BYTES`] at most.
#[derive(Debug, Clone, Default)]
pub struct Deframer {
    bytes: Vec<u8>,
    inside: bool,
    escaped: bool,
    /// Bytes taken so far.
    taken: u64,
    /// Where the frame, or what is outside of one, began.
    begin: u64,
}

impl Deframer {
    /// Takes the next bytes and gives every frame or error to `found`, with the offset of its first byte.
    pub fn feed(&mut self, bytes: &[u8], mut found: impl FnMut(u64, Deframed<'_>)) {
        for &byte in bytes {
            self.take(byte, &mut found);
            self.taken += 1;
        }
    }

    /// No more bytes will come: what has begun is cut off.
    pub fn end(&mut self, mut found: impl FnMut(u64, Deframed<'_>)) {
        self.cut(&mut found);
        *self = Self { taken: self.taken, begin: self.taken, ..Self::default() };
    }

    fn take(&mut self, byte: u8, found: &mut impl FnMut(u64, Deframed<'_>)) {
        match byte {
            BEGIN => {
                self.cut(found);
                self.bytes.clear();
                (self.inside, self.escaped, self.begin) = (true, false, self.taken);
            }
            _ if !self.inside => self.report_outside(MOST_OUTSIDE, self.taken + 1, found),
            END => {
                found(self.begin, payload(&self.bytes));
                (self.inside, self.begin) = (false, self.taken + 1);
            }
            ESCAPE => self.escaped = true,
            _ if self.bytes.len() == MOST_BYTES => {
                found(self.begin, Err(FrameError::TooLong));
                // What follows up to the next frame is of the same fault and not reported again.
                (self.inside, self.begin) = (false, u64::MAX);
            }
            _ => {
                self.bytes.push(if self.escaped { byte ^ TURNED } else { byte });
                self.escaped = false;
            }
        }
    }

    /// Reports a frame that did not end, or bytes that were outside of any.
    fn cut(&mut self, found: &mut impl FnMut(u64, Deframed<'_>)) {
        if self.inside {
            found(self.begin, Err(FrameError::Cut { len: self.bytes.len() }));
        } else {
            self.report_outside(1, self.taken, found);
        }
    }

    /// Reports the bytes up to `end` that were outside of any frame, where they are so many.
    fn report_outside(&mut self, fewest: u64, end: u64, found: &mut impl FnMut(u64, Deframed<'_>)) {
        let len = end.saturating_sub(self.begin);
        if len >= fewest {
            found(self.begin, Err(FrameError::Outside { len }));
            self.begin = end;
        }
    }
}

/// The payload of the bytes between the ends of a frame.
fn payload(bytes: &[u8]) -> Deframed<'_> {
    let Some((&found, payload)) = bytes.split_last().filter(|(_, payload)| !payload.is_empty()) else {
        return Err(FrameError::Empty);
    };
    let computed = crc8_maxim(payload);
    if found == computed {
        Ok(payload)
    } else {
        Err(FrameError::Checksum { len: payload.len(), found, computed })
    }
}

/// The display's report of motor and battery.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SystemState {
    /// Flags of the set-up, bit by bit.
    pub flags: u16,
    /// State of the master.
    pub master_state: u8,
    /// Error of the master; 0 for none.
    pub master_error: u8,
    /// Voltage at the motor (V).
    pub motor_voltage_v: f64,
    /// Current of the motor (A).
    pub motor_current_a: f64,
    /// Power of the motor (W).
    pub motor_power_w: f64,
    /// Speed of the motor (rpm).
    pub motor_rpm: i16,
    /// Temperature of the motor's electronics (°C).
    pub board_temperature_c: u8,
    /// Temperature of the motor's stator (°C).
    pub stator_temperature_c: u8,
    /// Charge of the battery (%).
    pub charge_percent: u8,
    /// Voltage of the battery (V).
    pub battery_voltage_v: f64,
    /// Current of the battery (A).
    pub battery_current_a: f64,
}

impl SystemState {
    /// Reads the display's message 0x41; `None` of another message, and of one with fewer bytes than these fields take.
    /// The bytes behind them no document explains with certainty.
    pub fn decode(payload: &[u8]) -> Option<Self> {
        let Some(([DISPLAY, SYSTEM_STATE], fields)) = payload.split_first_chunk() else { return None };
        let fields: &[u8; 19] = fields.first_chunk()?;
        let u16_at = |at: usize| u16::from_be_bytes([fields[at], fields[at + 1]]);
        Some(Self {
            flags: u16_at(0),
            master_state: fields[2],
            master_error: fields[3],
            motor_voltage_v: f64::from(u16_at(4)) / 100.0,
            motor_current_a: f64::from(u16_at(6)) / 10.0,
            motor_power_w: f64::from(u16_at(8)),
            motor_rpm: u16_at(10).cast_signed(),
            board_temperature_c: fields[12],
            stator_temperature_c: fields[13],
            charge_percent: fields[14],
            battery_voltage_v: f64::from(u16_at(15)) / 100.0,
            battery_current_a: f64::from(u16_at(17)) / 10.0,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    type Owned = Vec<(u64, Result<Vec<u8>, FrameError>)>;

    fn deframe(pieces: &[&[u8]]) -> Owned {
        let mut deframer = Deframer::default();
        let mut all = Vec::new();
        for piece in pieces {
            deframer.feed(piece, |at, frame| all.push((at, frame.map(<[u8]>::to_vec))));
            assert!(deframer.bytes.len() <= MOST_BYTES);
        }
        deframer.end(|at, frame| all.push((at, frame.map(<[u8]>::to_vec))));
        all
    }

    #[test]
    fn every_recorded_frame_is_read_and_written_alike() {
        let Some(path) = testkit::shared("data/onboard/torqeedo_tqbus_frames.csv") else { return };
        let text = std::fs::read_to_string(path).unwrap();
        let mut count = 0;
        for line in text.lines().skip(1) {
            let fields: Vec<&str> = line.split(',').collect();
            let byte = |i| u8::from_str_radix(&fields[0][2 * i..2 * i + 2], 16).unwrap();
            let bytes: Vec<u8> = (0..fields[0].len() / 2).map(byte).collect();
            let frames = deframe(&[&bytes]);
            let [(0, Ok(payload))] = &frames[..] else { panic!("{line}: {frames:?}") };
            assert_eq!(payload.len(), fields[1].parse::<usize>().unwrap(), "{line}");
            assert_eq!(crc8_maxim(payload), u8::from_str_radix(fields[3], 16).unwrap(), "{line}");
            assert_eq!(encode(payload).as_deref(), Some(&bytes[..]), "{line}");
            count += 1;
            if count == 1 {
                let state = SystemState::decode(payload).unwrap();
                assert_eq!((state.charge_percent, state.battery_voltage_v), (94, 32.66));
                assert_eq!((state.flags, state.master_state, state.motor_rpm), (0x0312, 3, 1));
                assert_eq!(SystemState::decode(&payload[..20]), None, "short");
            }
        }
        assert_eq!(count, 4);
    }

    #[test]
    fn a_tiller_answers_in_big_endian_and_within_full_speed() {
        assert!(asks_tiller(&[REMOTE, 1]) && !asks_tiller(&[REMOTE, 1, 0]));
        let payload = |answer: Vec<u8>| deframe(&[&answer])[0].1.clone().unwrap();
        assert_eq!(payload(tiller_answer(-1000)), [0, 0, 5, 0, 0xFC, 0x18]);
        assert_eq!(payload(tiller_answer(i16::MAX)), [0, 0, 5, 0, 0x03, 0xE8]);
    }

    #[test]
    fn damage_is_reported_where_it_is_and_what_follows_is_read() {
        let good = encode(&[DISPLAY, 0xAC, 0xAD, 0xAE]).unwrap();
        assert_eq!(good[2..8], [0xAE, 0x2C, 0xAE, 0x2D, 0xAE, 0x2E], "stuffed");
        let mut broken = good.clone();
        broken[1] ^= 1;
        let long = [&[BEGIN][..], &[1; 100], &[END]].concat();
        let bytes = [&[9, 9][..], &good, &broken, &good[..4], &long, &[BEGIN, END], &good].concat();
        let found = deframe(&[&bytes]);
        let errors: Vec<_> =
            found.iter().filter_map(|(at, frame)| Some((*at, *frame.as_ref().err()?))).collect();
        let n = good.len() as u64;
        let FrameError::Checksum { len: 4, .. } = errors[1].1 else { panic!("{errors:?}") };
        assert_eq!(errors[0], (0, FrameError::Outside { len: 2 }));
        assert_eq!(errors[1].0, 2 + n);
        assert_eq!(errors[2], (2 + 2 * n, FrameError::Cut { len: 2 }));
        assert_eq!(errors[3], (6 + 2 * n, FrameError::TooLong));
        assert_eq!(errors[4].1, FrameError::Empty);
        assert_eq!(errors.len(), 5);
        assert!(found[1].1.is_ok() && found.last().unwrap().1.is_ok());
    }

    #[test]
    fn a_stream_without_frames_is_reported_as_it_goes() {
        let mut deframer = Deframer::default();
        let mut errors = Vec::new();
        deframer.feed(&[0x55; 600], |at, frame| errors.push((at, frame.unwrap_err())));
        let outside = FrameError::Outside { len: 256 };
        assert_eq!(errors, [(0, outside), (256, outside)]);
    }

    proptest! {
        #[test]
        fn any_split_gives_the_same(bytes in proptest::collection::vec(
            prop_oneof![Just(BEGIN), Just(END), Just(ESCAPE), any::<u8>()], 0..300), cut in 0_usize..300) {
            let (head, tail) = bytes.split_at(cut.min(bytes.len()));
            prop_assert_eq!(deframe(&[head, tail]), deframe(&[&bytes]));
        }

        #[test]
        fn a_payload_survives_the_bus_after_any_noise(
            noise in proptest::collection::vec(any::<u8>(), 0..200),
            payload in proptest::collection::vec(any::<u8>(), 1..MOST_BYTES),
        ) {
            let bytes = [noise, encode(&payload).unwrap()].concat();
            let found = deframe(&[&bytes]);
            prop_assert_eq!(&found.last().unwrap().1, &Ok(payload));
        }
    }
}
