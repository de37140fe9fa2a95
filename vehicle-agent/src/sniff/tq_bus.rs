//! The motors' own bus (TQ bus, RS-485) as lines, for work at the bench without the interface card.
//!
//! Every frame is one [`Found`] with `what`, `address` and `message` (both in hexadecimal); the display's report of the whole
//! system has its values in SI units, the tiller's answer its throttle, and other messages their data in hexadecimal.

use super::{Decoder, Found};
use devices::tq_bus::{
    self, BATTERY, DISPLAY, Deframed, Deframer, FrameError, MASTER, MOTOR, REMOTE, SystemState,
};
use serde_json::{Value, json};

/// Reads the bus. It keeps one frame, of [`tq_bus::MOST_BYTES`] at most.
#[derive(Debug, Default)]
pub(crate) struct TqBus {
    deframer: Deframer,
}

impl TqBus {
    /// A new decoder.
    pub(crate) fn new() -> Self {
        Self::default()
    }
}

impl Decoder for TqBus {
    fn feed(&mut self, bytes: &[u8], found: &mut Vec<Found>) {
        self.deframer.feed(bytes, |offset, frame| found.push(line(offset, frame)));
    }

    fn end(&mut self, found: &mut Vec<Found>) {
        self.deframer.end(|offset, frame| found.push(line(offset, frame)));
    }
}

fn line(offset: u64, frame: Deframed<'_>) -> Found {
    match frame {
        Ok(payload) => shown(payload),
        Err(error) => damaged(offset, error),
    }
}

fn damaged(offset: u64, error: FrameError) -> Found {
    let error = error.to_string();
    Found { text: format!("byte {offset}: {error}"), json: json!({ "error": error, "offset": offset }) }
}

fn shown(payload: &[u8]) -> Found {
    let (&address, rest) = payload.split_first().unwrap_or((&MASTER, &[]));
    let (what, mut json) = if let Some(state) = SystemState::decode(payload) {
        ("system_state", system_state(&state))
    } else if tq_bus::asks_tiller(payload) {
        ("throttle_request", json!({}))
    } else if let [MASTER, 0, 5, 0, high, low] = *payload {
        let per_mille = i16::from_be_bytes([high, low]);
        ("throttle", json!({ "throttle": f64::from(per_mille) / 1000.0 }))
    } else {
        ("other", json!({ "data": hex::encode_upper(rest.get(1..).unwrap_or_default()) }))
    };
    let fields: Vec<String> =
        json.as_object().into_iter().flatten().map(|(key, value)| format!("{key} {value}")).collect();
    let text = format!("{} {what} {}", name(address), fields.join(", "));
    json["what"] = json!(what);
    json["address"] = json!(format!("0x{address:02X}"));
    if let Some(message) = rest.first() {
        json["message"] = json!(format!("0x{message:02X}"));
    }
    Found { json, text: text.trim_end().to_owned() }
}

/// Name of the device with this address.
fn name(address: u8) -> String {
    match address {
        MASTER => "master".to_owned(),
        REMOTE => "remote".to_owned(),
        DISPLAY => "display".to_owned(),
        MOTOR => "motor".to_owned(),
        BATTERY => "battery".to_owned(),
        other => format!("0x{other:02X}"),
    }
}

fn system_state(state: &SystemState) -> Value {
    json!({
        "flags": state.flags,
        "master_state": state.master_state,
        "master_error": state.master_error,
        "motor_voltage_v": state.motor_voltage_v,
        "motor_current_a": state.motor_current_a,
        "motor_power_w": state.motor_power_w,
        "motor_rpm": state.motor_rpm,
        "board_temperature_c": state.board_temperature_c,
        "stator_temperature_c": state.stator_temperature_c,
        "charge_percent": state.charge_percent,
        "battery_voltage_v": state.battery_voltage_v,
        "battery_current_a": state.battery_current_a,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sniff(bytes: &[u8]) -> Vec<Found> {
        let mut decoder = TqBus::new();
        let mut found = Vec::new();
        bytes.chunks(3).for_each(|piece| decoder.feed(piece, &mut found));
        decoder.end(&mut found);
        found
    }

    #[test]
    fn recorded_frames_are_read_one_after_the_other() {
        let Some(path) = testkit::shared("data/onboard/torqeedo_tqbus_frames.csv") else { return };
        let text = std::fs::read_to_string(path).unwrap();
        let frames = text.lines().skip(1).map(|line| hex::decode(line.split(',').next().unwrap()).unwrap());
        let found = sniff(&frames.flatten().collect::<Vec<u8>>());
        let whats: Vec<_> = found.iter().map(|found| found.json["what"].as_str().unwrap()).collect();
        assert_eq!(whats, ["system_state", "other", "throttle_request", "other"]);
        let state = &found[0].json;
        assert_eq!((&state["charge_percent"], &state["battery_voltage_v"]), (&json!(94), &json!(32.66)));
        assert_eq!((&state["address"], &state["message"]), (&json!("0x20"), &json!("0x41")));
        assert_eq!(found[1].json["data"], "01064050001C00012113");
        assert_eq!(found[2].text, "remote throttle_request");
    }

    #[test]
    fn a_throttle_is_read_and_damage_stands_in_its_place() {
        let answer = tq_bus::tiller_answer(-250);
        let mut broken = answer.clone();
        broken[2] ^= 0x10;
        let found = sniff(&[&answer[..], &[1, 2], &broken].concat());
        assert_eq!(found[0].json["throttle"], -0.25);
        let offsets: Vec<_> = found[1..].iter().map(|found| found.json["offset"].clone()).collect();
        assert_eq!(offsets, [json!(answer.len()), json!(answer.len() + 2)]);
    }
}
