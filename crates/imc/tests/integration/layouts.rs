//! Layouts of older senders, bounds on nesting and what people write in JSON.

use imc::messages::{FollowRefState, MsgList, PlanControl, PlanDB, Reference, TBRFishTag, TextMessage};
use imc::{EncodeError, Header, Message, MessageList, Packet, PacketView, ShortPayload, json, reflect};
use serde_json::{Value, json};

fn tag() -> TBRFishTag {
    TBRFishTag {
        serial_no: 45,
        unix_timestamp: 1_571_652_000,
        millis: 123,
        trans_id: 1023,
        ..Default::default()
    }
}

fn to_json(bytes: &[u8]) -> Value {
    let mut out = Vec::new();
    json::write_packet(&mut out, &PacketView::new(bytes).unwrap(), ShortPayload::AnyBoundary).unwrap();
    serde_json::from_slice(&out).unwrap()
}

fn read(value: &Value) -> Result<Packet, json::ReadError> {
    json::read_packet(value, &json::ReadDefaults::default())
}

#[test]
fn the_fish_tag_of_2019_has_no_position() {
    let old = Packet::new(Header::default(), tag()).encode().unwrap();
    assert_eq!(old.len(), 22 + 21);
    let packet = Packet::decode(&old).unwrap();
    assert_eq!(packet.get::<TBRFishTag>(), Some(&tag()));
    assert_eq!(packet.encode().unwrap(), old);
    let shown = to_json(&old);
    assert_eq!(shown["absent"], json!(["lat", "lon"]));
    assert_eq!(shown["fields"].get("lat"), None);
    assert_eq!(read(&shown).unwrap().encode().unwrap(), old);

    let new = TBRFishTag { lat: Some(1.1), lon: Some(0.18), ..tag() };
    let bytes = Packet::new(Header::default(), new.clone()).encode().unwrap();
    assert_eq!(bytes.len(), 22 + 37);
    assert_eq!(Packet::decode(&bytes).unwrap().get::<TBRFishTag>(), Some(&new));
}

/// Newer DUNE says ValidatePlan by the same id: its type, and a plan within.
#[test]
fn what_has_not_the_size_of_a_tag_is_none_however_it_is_read() {
    for bytes in [3, 22, 36, 38, 300] {
        let body = imc::Body::Unknown { id: 2007, payload: vec![0; bytes] };
        let packet = Packet { body, ..Packet::new(Header::default(), tag()) }.encode().unwrap();
        let view = PacketView::new(&packet).unwrap();
        assert_eq!(imc::decode::<TBRFishTag>(&view), Ok(None), "{bytes} bytes");
        let decoded = Packet::decode(&packet).unwrap();
        assert_eq!((decoded.get::<TBRFishTag>(), decoded.encode().unwrap()), (None, packet), "{bytes} bytes");
    }
}

#[test]
fn inside_another_message_a_tag_without_position_says_nan() {
    let list = MsgList { msgs: [tag()].into_iter().collect() };
    let bytes = Packet::new(Header::default(), list).encode().unwrap();
    let packet = Packet::decode(&bytes).unwrap();
    let inner = packet.get::<MsgList>().unwrap().msgs.of::<TBRFishTag>().next().unwrap();
    assert!(inner.lat.unwrap().is_nan() && inner.lon.unwrap().is_nan());
}

#[test]
fn a_short_payload_is_damage_unless_asked_for() {
    let whole = Packet::new(Header::default(), TextMessage { origin: "a".into(), text: "b".into() });
    let body = imc::Body::Unknown { id: 160, payload: vec![1, 0, b'a'] };
    let short = Packet { body, ..whole }.encode().unwrap();
    assert_eq!(Packet::decode(&short).unwrap_err().class(), "field_overrun");
    let packet = Packet::from_view(&PacketView::new(&short).unwrap(), ShortPayload::AnyBoundary).unwrap();
    assert_eq!(packet.fields_sent, Some(1));
    assert_eq!(packet.get::<TextMessage>().unwrap().origin, "a");
    assert_eq!(packet.encode().unwrap(), short);
}

fn nested(depth: usize) -> Message {
    (0..depth).fold(PlanControl::default().into(), |inner: Message, _| {
        PlanDB { arg: inner.into(), ..PlanDB::default() }.into()
    })
}

#[test]
fn nesting_is_bounded_both_ways() {
    let deepest = Packet::new(Header::default(), nested(16)).encode().unwrap();
    assert!(Packet::decode(&deepest).is_ok());
    let error = Packet::new(Header::default(), nested(17)).encode().unwrap_err();
    assert_eq!(error, EncodeError::Depth { message: "PlanDB" });
    // A list counts as the message it is in.
    let list =
        |inner: Message| Packet::new(Header::default(), MsgList { msgs: [inner].into_iter().collect() });
    let deepest = Packet { order: imc::ByteOrder::Big, ..list(nested(15)) };
    assert_eq!(Packet::decode(&deepest.encode().unwrap()).unwrap(), deepest);
    assert_eq!(list(nested(16)).encode().unwrap_err(), EncodeError::Depth { message: "MsgList" });

    // 60 nested packets by hand: 8 bytes before each argument, 2 after.
    let mut payload = Vec::new();
    for _ in 0..60 {
        payload.extend_from_slice(&[0, 0, 0, 0, 0, 0]);
        payload.extend_from_slice(&556_u16.to_le_bytes());
    }
    let body = imc::Body::Unknown { id: 556, payload };
    let packet = Packet { body, ..Packet::new(Header::default(), nested(0)) };
    let bytes = packet.encode().unwrap();
    assert_eq!(Packet::decode(&bytes).unwrap_err().class(), "nested_too_deep");
    assert!(reflect::fields(&PacketView::new(&bytes).unwrap()).unwrap().is_err());
}

#[test]
fn what_does_not_fit_is_refused_and_leaves_nothing() {
    let long = TextMessage { origin: "x".into(), text: "y".repeat(65_536).into() };
    let mut out = vec![1, 2, 3];
    let packet = Packet::new(Header::default(), long);
    let error = packet.encode_into(&mut out).unwrap_err();
    assert_eq!(error.to_string(), "TextMessage: a value of 65536 bytes; a field holds at most 65535");
    assert_eq!(out, [1, 2, 3]);

    let two = TextMessage { origin: "x".repeat(40_000).into(), text: "y".repeat(40_000).into() };
    let error = Packet::new(Header::default(), two).encode().unwrap_err();
    assert_eq!(error, EncodeError::Payload { message: "TextMessage", bytes: 80_004 });

    let nulls = MessageList::from(vec![None; 65_536]);
    let error = Packet::new(Header::default(), MsgList { msgs: nulls }).encode().unwrap_err();
    assert_eq!(error, EncodeError::List { message: "MsgList", count: 65_536 });
}

#[test]
fn reflection_names_places_units_and_labels() {
    let state = FollowRefState {
        reference: Reference {
            speed: imc::messages::DesiredSpeed { value: 1.5, ..Default::default() }.into(),
            lat: 1.1,
            ..Reference::default()
        }
        .into(),
        state: imc::messages::FollowRefStateState::Loiter,
        ..FollowRefState::default()
    };
    let bytes = Packet::new(Header::default(), state).encode().unwrap();
    let view = PacketView::new(&bytes).unwrap();
    let fields = reflect::fields(&view).unwrap().unwrap();
    let find = |path: &str| fields.iter().find(|field| field.path == path).unwrap();
    assert_eq!(find("reference.speed.value").value, reflect::Value::Double(1.5));
    assert_eq!(find("reference.speed.speed_units").label().unwrap(), "METERS_PS");
    assert_eq!(find("reference.lat").value, reflect::Value::Double(1.1));
    assert_eq!(find("state").label().unwrap(), "LOITER");
    assert!(fields.iter().all(|field| field.path != "reference.z"));

    let bytes = Packet::new(Header::default(), imc::messages::EulerAngles::default()).encode().unwrap();
    let fields = reflect::fields(&PacketView::new(&bytes).unwrap()).unwrap().unwrap();
    assert!(fields.iter().any(|field| field.path == "psi" && field.desc.unit == Some("rad")));
}

#[test]
fn people_may_write_labels_names_and_little_else() {
    let packet = read(&json!({
        "abbrev": "PlanControl",
        "header": {"src": "0x4001", "dst": "ntnu-otter-01", "timestamp": 1.5},
        "fields": {"type": "request", "op": "STOP", "flags": "CALIBRATE|IGNORE_ERRORS"},
    }))
    .unwrap();
    assert_eq!(packet.header.dst, imc::Address(0x2810));
    let packet = Packet::decode(&packet.encode().unwrap()).unwrap();
    let control = packet.get::<PlanControl>().unwrap();
    assert_eq!(control.op, imc::messages::PlanControlOp::Stop);
    assert_eq!(control.flags.bits(), 3);
    assert!(control.arg.is_none());
}

#[test]
fn wrong_json_is_refused_by_place() {
    for (value, error) in [
        (json!([]), "packet: expected a JSON object"),
        (json!({"id": 3999}), "id: no message has the id 3999"),
        (json!({"abbrev": "Nonsense"}), "abbrev: no message is called `Nonsense`"),
        (json!({"abbrev": "Heartbeat", "id": 1}), "id: Heartbeat has the id 150, not 1"),
        (
            json!({"abbrev": "Rpm", "fields": {"value": 40_000}}),
            "fields.value: 40000 is not an integer from -32768 to 32767",
        ),
        (json!({"abbrev": "Rpm", "fields": {"valu": 4}}), "fields: Rpm has no field `valu`; it has value"),
        (
            json!({"abbrev": "Temperature", "fields": {"value": 1e300}}),
            "fields.value: 1e+300 is not a number that fits fp32_t (or NaN, Infinity)",
        ),
        (
            json!({"abbrev": "Rpm", "header": {"src": "nobody"}}),
            "header.src: \"nobody\" is neither a registered system nor a number from 0 to 65535",
        ),
        (
            json!({"abbrev": "Rpm", "trailing": "abc"}),
            "trailing: expected bytes as pairs of hexadecimal digits",
        ),
        (
            json!({"abbrev": "GpsFix", "absent": ["lat"]}),
            "absent: only the last fields of GpsFix can be absent, in their order",
        ),
        (
            json!({"abbrev": "PlanControl", "fields": {"arg": {"abbrev": "Goto", "fields": {"lat": "x"}}}}),
            "fields.arg.fields.lat: \"x\" is not a number (or NaN, Infinity)",
        ),
        (
            json!({"abbrev": "EntityParameters", "fields": {"params": [null, {"abbrev": "Nix"}]}}),
            "fields.params[1].abbrev: no message is called `Nix`",
        ),
    ] {
        assert_eq!(read(&value).unwrap_err().to_string(), error, "{value}");
    }
}

#[test]
fn a_message_alone_goes_through_json() {
    let message: Message = tag().into();
    let text = json::message_to_string(&message).unwrap();
    assert_eq!(json::message_from_value(&serde_json::from_str(&text).unwrap()).unwrap(), message);
    assert!(json::message_from_value(&json!({"abbrev": "Goto", "fields": {"lat": []}})).is_err());
}

#[test]
fn a_relay_readdresses_without_decoding() {
    let text = TextMessage { origin: "a".into(), text: "b".into() };
    let packet = Packet { trailing: vec![7], ..Packet::new(Header::default(), text) };
    let big = Packet { order: imc::ByteOrder::Big, ..packet };
    let header = Header { dst: imc::Address(0x4001), timestamp: 2.5, ..Header::default() };
    let mut out = Vec::new();
    imc::readdress_into(&mut out, &PacketView::new(&big.encode().unwrap()).unwrap(), &header);
    assert_eq!(Packet::decode(&out).unwrap(), Packet { header, ..big });
}

#[test]
fn lists_keep_what_they_were_given() {
    let text = || TextMessage { origin: "a".into(), text: "b".into() };
    let zero = |lat| imc::messages::Goto { lat, ..Default::default() };
    let mut list = MessageList::from(vec![Some(text().into()), None]);
    list.push(zero(f64::NAN));
    assert_eq!((list.len(), list.is_empty()), (3, false));
    assert_eq!(list.of::<TextMessage>().collect::<Vec<_>>(), [text()]);
    assert_eq!(list.of::<imc::messages::Goto>().count(), 1);
    assert_eq!(list.of::<PlanDB>().count(), 0);
    let kinds: Vec<_> = list.iter().map(|message| message.map(|message| message.abbrev())).collect();
    assert_eq!(kinds, [Some("TextMessage"), None, Some("Goto")]);
    // Equal by their bytes.
    assert_eq!(list, list.clone());
    assert_ne!(MessageList::from_iter([zero(0.0)]), MessageList::from_iter([zero(-0.0)]));
    let told = format!("{:?}", MessageList::from(vec![Some(text().into()), None]));
    assert_eq!(told, r#"MessageList([Some(TextMessage(TextMessage { origin: "a", text: "b" })), None])"#);

    let list = MsgList { msgs: list };
    for order in [imc::ByteOrder::Little, imc::ByteOrder::Big] {
        let bytes = Packet { order, ..Packet::new(Header::default(), list.clone()) }.encode().unwrap();
        assert_eq!(Packet::decode(&bytes).unwrap().get(), Some(&list));
    }
}

#[test]
fn what_cannot_be_packed_is_not_lost_in_silence() {
    let long = TextMessage { origin: "x".into(), text: "y".repeat(65_536).into() };
    let fault = EncodeError::Value { message: "MsgList", bytes: 65_536 };
    let mut msgs = MessageList::from_iter([PlanControl::default()]);
    msgs.push(long.clone());
    msgs.push(PlanControl::default());
    // Left out, and reported.
    assert_eq!((msgs.len(), msgs.iter().flatten().count()), (2, 2));
    assert!(format!("{msgs:?}").contains("65536"));
    let list = MsgList { msgs };
    assert_eq!(Packet::new(Header::default(), list.clone()).encode(), Err(fault.clone()));
    // Also from deeper down, and in a single place.
    let around = MsgList { msgs: [list].into_iter().collect() };
    assert_eq!(Packet::new(Header::default(), around).encode(), Err(fault));
    let single = PlanDB { arg: long.into(), ..PlanDB::default() };
    assert!(single.arg.get().is_none() && format!("{:?}", single.arg).contains("65536"));
    let fault = EncodeError::Value { message: "PlanDB", bytes: 65_536 };
    assert_eq!(Packet::new(Header::default(), single).encode(), Err(fault));
}

#[test]
fn json_of_more_than_a_packet_holds_is_refused() {
    let elements = vec![json!({"abbrev": "EstimatedState"}); 1_000];
    let error = read(&json!({"abbrev": "MsgList", "fields": {"msgs": elements}})).unwrap_err();
    let bytes = 2 + 1_000 * 90;
    assert_eq!(
        error.to_string(),
        format!("MsgList: the payload has {bytes} bytes; a packet holds at most 65535")
    );
    let elements = vec![json!({"abbrev": "EstimatedState"}); 1_000];
    assert!(json::message_from_value(&json!({"abbrev": "MsgList", "fields": {"msgs": elements}})).is_err());
}
