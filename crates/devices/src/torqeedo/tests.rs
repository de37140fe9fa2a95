//! The card's frames against the vectors made from its documents, and at their limits.

use super::report::{battery_status, motor_drive, rail};
use super::*;
use crate::can::CanId;
use crate::pair::Pair;
use crate::reading::{BatteryReading, RailReading};

fn set(id: u32, data: &[u8]) -> Result<CardCommand, CardError> {
    CardCommand::parse(&CanFrame::new(id, data).unwrap())
}

#[test]
fn obeys_only_whole_commands_for_the_card() {
    assert_eq!(set(0x00D0_FEAB, &[0xF4, 1, 6, 0xFF]), Ok(CardCommand::MotorSet(Pair::new(500, -250))));
    assert_eq!(set(0x00D0_FEAC, &[0; 4]), Err(CardError::Address(0x00D0_FEAC)));
    assert_eq!(set(0x00D1_FEAB, &[0; 4]), Err(CardError::Address(0x00D1_FEAB)));
    assert_eq!(set(0x00D0_FEAB, &[0; 3]), Err(CardError::Length { message: MessageId::MOTOR_SET, len: 3 }));
    assert_eq!(set(0x00D0_FEAB, &[0xE9, 3, 0, 0]), Err(CardError::Throttle(1001)));
    assert_eq!(set(0x00C0_FEAB, &[0; 4]), Err(CardError::Message(MessageId::MOTOR_DRIVE)));
}

#[test]
fn values_beyond_the_field_stop_at_its_ends() {
    assert_eq!(motor_drive(0, 1e9, -1e9, f64::NAN).data(), [0, 0xFF, 0xFF, 0, 0x80, 0, 0]);
    assert_eq!(battery_status(0, -5.0, 700.0, -1.0, 130.0, 0).data(), [0, 0, 0xFF, 0xFF, 0, 0, 100, 0]);
}

/// The number that follows `name` in the meaning of a vector.
fn number(meaning: &str, name: &str) -> f64 {
    let rest = meaning.split(&format!("\"\"{name}\"\": ")).nth(1).unwrap();
    rest.split([',', '}']).next().unwrap().parse().unwrap()
}

fn vector_frame(kind: &str, meaning: &str, sent: &CanFrame) -> Option<CanFrame> {
    let index = || number(meaning, "index") as u8;
    Some(match kind {
        "TQ_BAT_STATUS" => battery_status(
            index(),
            number(meaning, "temperature_c"),
            number(meaning, "voltage_v"),
            number(meaning, "current_a"),
            number(meaning, "soc_pct"),
            number(meaning, "error") as u8,
        ),
        "RAIL" => rail(
            index(),
            number(meaning, "voltage_v"),
            number(meaning, "current_a_signed24"),
            number(meaning, "fuse_a"),
            number(meaning, "flags") as u8,
        ),
        "TQ_MOTOR_DRIVE" => motor_drive(
            index(),
            number(meaning, "power_w"),
            number(meaning, "temperature_c"),
            number(meaning, "motor_rpm"),
        ),
        "TQ_MOTOR_SET(tx)" => {
            let set = Pair::new("port", "starboard").map(|side| per_mille(number(meaning, side)).unwrap());
            assert_eq!(CardCommand::parse(sent), Ok(CardCommand::MotorSet(set)));
            CardCommand::MotorSet(set).frame()
        }
        "OUTPUT_SET(tx)" => CardCommand::parse(sent).unwrap().frame(),
        _ => return None,
    })
}

#[test]
fn every_vector_of_the_bus_is_met() {
    let Some(path) = testkit::shared("data/onboard/torqeedo_can_vectors.csv") else { return };
    let text = std::fs::read_to_string(path).unwrap();
    let mut count = 0;
    for line in text.lines().skip(1) {
        let fields: Vec<&str> = line.splitn(4, ',').collect();
        let bytes: Vec<u8> = (0..fields[1].len() / 2)
            .map(|i| u8::from_str_radix(&fields[1][2 * i..2 * i + 2], 16).unwrap())
            .collect();
        let sent = CanFrame::new(u32::from_str_radix(fields[0], 16).unwrap(), &bytes).unwrap();
        assert_eq!(vector_frame(fields[2], fields[3], &sent), Some(sent), "{line}");
        assert_eq!(
            Received::decode(&sent).map(|read| read.message),
            Ok(vector_message(fields[2], fields[3])),
            "{line}"
        );
        count += 1;
    }
    assert!(count >= 20);
}

fn vector_message(kind: &str, meaning: &str) -> Message {
    let index = || number(meaning, "index") as u8;
    match kind {
        "TQ_BAT_STATUS" => Message::BatteryStatus(BatteryStatus {
            reading: BatteryReading {
                number: index(),
                voltage_v: number(meaning, "voltage_v"),
                current_a: number(meaning, "current_a"),
                charge_percent: number(meaning, "soc_pct"),
                temperature_c: number(meaning, "temperature_c"),
            },
            error: number(meaning, "error") as u8,
        }),
        "RAIL" => Message::Rail(RailReading {
            number: index(),
            voltage_v: number(meaning, "voltage_v"),
            current_a: number(meaning, "current_a_signed24"),
            fuse_a: number(meaning, "fuse_a"),
            flags: number(meaning, "flags") as u8,
        }),
        "TQ_MOTOR_DRIVE" => {
            let drive = MotorDrive {
                motor: index(),
                power_w: number(meaning, "power_w"),
                temperature_c: number(meaning, "temperature_c"),
                motor_rpm: number(meaning, "motor_rpm") as i16,
            };
            assert_eq!(i32::from(drive.propeller_rpm()), number(meaning, "propeller_rpm") as i32);
            Message::MotorDrive(drive)
        }
        "TQ_MOTOR_SET(tx)" => {
            Message::MotorSet(["port", "starboard"].map(|side| per_mille(number(meaning, side)).unwrap()))
        }
        "OUTPUT_SET(tx)" => {
            let (rail, channel) = match meaning.split("\"\"").nth(3) {
                Some("H_MOT0") => (0, 0),
                Some("H_AUX1") => (2, 1),
                Some("H_VR0") => (3, 3),
                other => panic!("{other:?} has no rail in this test"),
            };
            Message::OutputSet { rail, channel, on: meaning.contains("true") }
        }
        other => panic!("{other} has no message in this test"),
    }
}

fn decode(id: u32, data: &[u8]) -> Result<Message, DecodeError> {
    Received::decode(&CanFrame::new(id, data).unwrap()).map(|read| read.message)
}

#[test]
fn the_messages_without_vectors_are_read_as_documented() {
    let Ok(Message::Text(text)) = decode(0x0000_ABFF, b"boot\0\0") else { panic!("not a text") };
    assert_eq!(text.bytes(), b"boot");
    assert_eq!(
        decode(0x0080_ABFF, &[3, 0x1F, 0, 0, 0x80]),
        Ok(Message::Outputs { rail: 3, channels: 0x8000_001F })
    );
    assert_eq!(decode(0x00A0_ABFF, &[1, 2, 3, 9]), Ok(Message::Uptime { uptime_s: 197_121, reset_cause: 9 }));
    assert_eq!(
        decode(0x00F0_ABFF, &[0xF3, 1, 200, 7]),
        Ok(Message::BatteryControl { battery: 3, master_error: 1, error_count: 200, firmware: 7 })
    );
    assert_eq!(
        decode(0x0100_ABFF, &[1, 0x34, 0x12, 0xFF]),
        Ok(Message::MotorStatus { motor: 1, errors: 0x1234, status: 0xFF })
    );
    assert_eq!(
        decode(0x0150_ABFF, &[1, 0, 2, 0, 0xFF, 0xFF, 4, 1]),
        Ok(Message::Id { company: 1, product: 2, serial: 65_535, firmware: 260 })
    );
    for number in [1, 2, 4, 5, 6, 7, 11, 17, 18, 19, 20] {
        let Ok(Message::Other(id)) = decode(number << 20 | 0xABFF, &[1]) else { panic!("{number} is read") };
        assert!(id.name().is_some(), "{number} is known");
    }
}

#[test]
fn all_nine_bits_of_the_message_count() {
    // The DUNE task reads eight bits and would take this for a rail.
    let Ok(Message::Other(id)) = decode(0x1030_ABFF, &[0; 8]) else { panic!("259 is not a rail") };
    assert_eq!((id.number(), id.name(), id.to_string()), (259, None, "message 259".to_owned()));
}

#[test]
fn bytes_from_0x80_up_keep_their_value() {
    let Ok(Message::BatteryStatus(status)) =
        decode(0x00E0_ABFF, &[0, 0x80, 0xFF, 0xFF, 0x80, 0x80, 100, 0xFF])
    else {
        panic!("not a battery")
    };
    let BatteryReading { voltage_v, current_a, temperature_c, .. } = status.reading;
    assert_eq!((voltage_v, current_a, temperature_c, status.error), (655.35, 3289.6, 128.0, 255));
    let drive = MotorDrive { motor: 0, power_w: 0.0, temperature_c: 0.0, motor_rpm: -13 };
    assert_eq!(drive.propeller_rpm(), -1, "toward zero");
}

#[test]
fn short_frames_and_numbers_beyond_the_last_are_errors_that_name_them() {
    let needs = [(3, 8), (8, 5), (9, 3), (10, 4), (12, 7), (13, 4), (14, 8), (15, 4), (16, 4), (21, 8)];
    for (number, needs) in needs {
        for len in 0..needs {
            let error = decode(number << 20 | 0xABFF, &[0; 8][..usize::from(len)]).unwrap_err();
            assert!(matches!(error, DecodeError::Short { len: l, needs: n, .. } if l == len && n == needs));
            assert!(error.to_string().contains(&format!("({number}) has {len} bytes")), "{error}");
        }
        assert!(decode(number << 20 | 0xABFF, &[0; 8]).is_ok(), "longer ones are read");
    }
    for (number, count) in [(3, 5), (8, 5), (12, 2), (14, 4), (15, 4), (16, 2)] {
        let data = [count, 0, 0, 0, 0, 0, 0, 0];
        let error = decode(number << 20 | 0xABFF, &data).unwrap_err();
        assert!(matches!(error, DecodeError::Index { index, .. } if index == count), "{number}: {error}");
    }
}

#[test]
fn frames_of_other_protocols_are_refused() {
    assert_eq!(decode(0x0031_ABFF, &[0; 8]), Err(DecodeError::Foreign(0x0031_ABFF)));
    let standard = CanFrame::with_id(CanId::Standard(0x300), &[0; 8]).unwrap();
    assert_eq!(Received::decode(&standard), Err(DecodeError::Foreign(0x300)));
    let request = CanFrame::request(CanId::Extended(0x0030_ABFF), 8).unwrap();
    assert_eq!(Received::decode(&request), Err(DecodeError::Foreign(0x0030_ABFF)));
}

#[test]
fn a_rail_is_believed_only_from_the_card_to_all() {
    let believed = |id| Received::decode(&CanFrame::new(id, &[0; 8]).unwrap()).unwrap().concerns_computer();
    assert!(believed(0x0030_ABFF));
    assert!(!believed(0x0030_AAFF) && !believed(0x0030_ABFE));
    assert!(believed(0x00E0_ABFF) && believed(0x00E0_ACFF) && believed(0x00E0_ABFE));
    assert!(!believed(0x00E0_FEAB) && !believed(0x00D0_FEAB) && !believed(0x0090_FEAB));
    assert!(!believed(0x00E0_AB12), "for another");
}

#[test]
fn throttles_are_truncated_and_what_is_not_a_number_is_none() {
    assert_eq!(per_mille(f64::NAN), None);
    assert_eq!((per_mille(-0.0009), per_mille(-0.0019)), (Some(0), Some(-1)));
    assert_eq!((per_mille(7.0), per_mille(f64::NEG_INFINITY)), (Some(1000), Some(-1000)));
}
