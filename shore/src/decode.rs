//! Decodes packets for browsers and scripts: fields by name with units and meanings, nested messages as objects.

use api::{ReceiverClock, Update};
use detections::{ClockState, Detection};
use hub::{Series, SeriesKey};
use imc::PacketView;
use imc::catalogue::{self, FieldDesc, MessageDesc};
use imc::reflect::{self, Value, Visitor};
use serde_json::{Map, Value as Json, json};
use units::UtcTime;

/// The latest of a series.
pub(crate) fn series(key: SeriesKey, series: &Series) -> Option<Update> {
    let period_s = series.period_s().map(shortened);
    let update = packet(series.packet(), key.instance, series.received(), period_s)?;
    Some(Update { count: series.count(), ..update })
}

/// A mean with three significant digits: more would change with each packet.
fn shortened(mean: f32) -> f64 {
    format!("{mean:.2e}").parse().unwrap_or(f64::from(mean))
}

/// One packet. `None` for bytes that are not a packet; such are not kept.
pub(crate) fn packet(
    bytes: &[u8],
    instance: Option<u8>,
    received: UtcTime,
    period_s: Option<f64>,
) -> Option<Update> {
    let view = PacketView::unchecked(bytes).ok()?;
    Some(Update {
        system: view.src().0,
        id: view.id(),
        abbrev: abbrev(view.id()),
        entity: view.src_ent(),
        instance,
        time_us: view.header().time().unwrap_or(received).micros(),
        received_us: received.micros(),
        count: 0,
        period_s,
        fields: fields(&view),
    })
}

/// A message's abbreviation, or its number where the catalogue has none.
pub(crate) fn abbrev(id: u16) -> String {
    catalogue::by_id(id).map_or_else(|| id.to_string(), |desc| desc.abbrev.to_owned())
}

/// The fields that a packet holds; of a damaged or short one, those before the damage.
fn fields(view: &PacketView<'_>) -> Vec<api::Field> {
    let mut collect = Collect { fields: Vec::new(), open: Vec::new() };
    match reflect::walk(view, &mut collect) {
        Some(_) => collect.fields,
        // Its fields are unknown; its bytes are shown.
        None => vec![api::Field {
            name: "payload".to_owned(),
            value: hex::encode(view.payload()).into(),
            unit: String::new(),
            meaning: None,
        }],
    }
}

/// A detection.
pub(crate) fn detection(one: Detection) -> api::Detection {
    let id = one.id();
    let Detection { origin, clock, protocol, pose, effort, .. } = one;
    api::Detection {
        entity: origin.entity,
        time_us: origin.reported.micros(),
        heard_us: clock.utc().map(UtcTime::micros),
        received_us: origin.received.unwrap_or(origin.reported).micros(),
        serial_no: one.receiver.into(),
        maker: one.maker.map(|maker| maker.word().to_owned()),
        protocol: protocol.number().map(i64::from),
        protocol_name: protocol.name().map(str::to_owned),
        tag_id: one.tag_id.into(),
        data: one.data.map(i64::from),
        snr_db: one.snr_db.map(i64::from),
        frequency_khz: one.frequency_khz.map(i64::from),
        memory_address: one.line.into(),
        lat_deg: pose.map(|pose| pose.place.lat_deg()),
        lon_deg: pose.map(|pose| pose.place.lon_deg()),
        id,
        system: origin.system.0,
        clock: match clock.state {
            ClockState::Set => ReceiverClock::Set,
            ClockState::NotSet => ReceiverClock::NotSet,
            ClockState::Disciplined => ReceiverClock::Disciplined,
            ClockState::Lost => ReceiverClock::Lost,
        },
        clock_us: clock.micros(),
        pose_age_s: pose.and_then(|pose| pose.age_s),
        pose_sigma_m: pose.and_then(|pose| pose.sigma_m),
        lines_lost: effort.lines_lost,
        noise_average: effort.noise.map(|noise| noise.average),
        noise_peak: effort.noise.map(|noise| noise.peak),
        noise_age_s: effort.noise.map(|noise| noise.age_s),
        propeller_rpm: effort.propeller_rpm,
        raw: one.raw,
        min_lag_s: None,
        flags: None,
    }
}

/// The containers that are being built around the current field.
enum Open {
    Message(&'static FieldDesc, Map<String, Json>),
    List(&'static FieldDesc, Vec<Json>),
}

struct Collect {
    fields: Vec<api::Field>,
    open: Vec<Open>,
}

impl Collect {
    fn put(&mut self, desc: &'static FieldDesc, value: Json, meaning: Option<String>) {
        match self.open.last_mut() {
            None => self.fields.push(api::Field {
                name: desc.abbrev.to_owned(),
                value,
                unit: unit(desc),
                meaning,
            }),
            Some(Open::Message(_, map)) => {
                map.insert(desc.abbrev.to_owned(), value);
            }
            Some(Open::List(_, list)) => list.push(value),
        }
    }

    fn close(&mut self) {
        match self.open.pop() {
            Some(Open::Message(desc, map)) => self.put(desc, Json::Object(map), None),
            Some(Open::List(desc, list)) => self.put(desc, Json::Array(list), None),
            None => {}
        }
    }
}

impl Visitor<'_> for Collect {
    fn value(&mut self, desc: &'static FieldDesc, value: Value<'_>) {
        let (json, meaning) = match value {
            Value::Integer(number) => (number.into(), desc.label(number)),
            // The shortest decimal that is this single, not the double's many digits.
            Value::Single(number) => (number.to_string().parse::<f64>().map_or(Json::Null, Json::from), None),
            Value::Double(number) => (Json::from(number), None),
            Value::Text(text) => (String::from_utf8_lossy(text).into(), None),
            Value::Raw(bytes) => (hex::encode(bytes).into(), None),
        };
        self.put(desc, json, meaning);
    }

    fn null(&mut self, desc: &'static FieldDesc) {
        self.put(desc, Json::Null, None);
    }

    fn enter_message(&mut self, desc: &'static FieldDesc, message: &'static MessageDesc) {
        let map = Map::from_iter([("abbrev".to_owned(), json!(message.abbrev))]);
        self.open.push(Open::Message(desc, map));
    }

    fn leave_message(&mut self) {
        self.close();
    }

    fn enter_list(&mut self, desc: &'static FieldDesc, _: usize) {
        self.open.push(Open::List(desc, Vec::new()));
    }

    fn leave_list(&mut self) {
        self.close();
    }
}

/// The unit as it is written; empty for numbers that only name things.
fn unit(desc: &FieldDesc) -> String {
    match desc.unit {
        Some("Enumerated" | "Bitfield" | "List" | "TupleList") | None => String::new(),
        Some(unit) => unit.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use imc::messages::{self, Goto, LogBookEntry, LogBookEntryType, PlanManeuver, PlanSpecification};
    use imc::{Address, Body, Header, Packet};

    fn update(message: impl Into<imc::Message>) -> Update {
        let header = Header { timestamp: 2.5, src: Address(0x2810), src_ent: 7, ..Header::default() };
        let bytes = Packet::new(header, message).encode().unwrap();
        packet(&bytes, None, UtcTime::from_micros(9), Some(1.0)).unwrap()
    }

    fn field<'a>(update: &'a Update, name: &str) -> &'a api::Field {
        update.fields.iter().find(|field| field.name == name).unwrap()
    }

    #[test]
    fn fields_have_units_and_meanings() {
        let voltage = update(messages::Voltage { value: 12.1 });
        assert_eq!((voltage.system, voltage.entity, voltage.time_us), (0x2810, 7, 2_500_000));
        let value = field(&voltage, "value");
        assert_eq!((value.value.clone(), value.unit.as_str()), (json!(12.1), "V"));
        let entry = update(LogBookEntry { r#type: LogBookEntryType::Error, ..LogBookEntry::default() });
        let kind = field(&entry, "type");
        assert_eq!((kind.value.clone(), kind.unit.as_str()), (json!(2), ""));
        assert!(
            kind.meaning.as_ref().is_some_and(|meaning| meaning.eq_ignore_ascii_case("error")),
            "{kind:?}"
        );
    }

    #[test]
    fn what_is_no_number_is_null() {
        let state =
            update(messages::EstimatedState { x: f32::NAN, lat: f64::INFINITY, ..Default::default() });
        assert_eq!((&field(&state, "x").value, &field(&state, "lat").value), (&Json::Null, &Json::Null));
    }

    #[test]
    fn nested_messages_are_objects() {
        let goto = Goto { speed: 1.5, ..Goto::default() };
        let maneuver = PlanManeuver { maneuver_id: "a".into(), data: goto.into(), ..Default::default() };
        let plan = PlanSpecification { maneuvers: [maneuver].into_iter().collect(), ..Default::default() };
        let plan = update(plan);
        let maneuvers = &field(&plan, "maneuvers").value;
        assert_eq!(maneuvers[0]["data"]["abbrev"], "Goto");
        assert_eq!(maneuvers[0]["data"]["speed"], 1.5);
    }

    #[test]
    fn an_unknown_message_shows_its_bytes() {
        let known = Packet::new(Header::default(), messages::Heartbeat);
        let bytes =
            Packet { body: Body::Unknown { id: 60_001, payload: vec![1, 255] }, ..known }.encode().unwrap();
        let update = packet(&bytes, None, UtcTime::from_micros(9), None).unwrap();
        assert_eq!((update.abbrev.as_str(), &update.fields[0].value), ("60001", &json!("01ff")));
    }
}
