//! The golden vectors: packets written by other implementations, and packets that are damaged.

use imc::{Body, ByteOrder, DecodeError, Packet, PacketView, ShortPayload, json};
use serde_json::Value;
use sha2::{Digest as _, Sha256};

fn vectors() -> Option<Value> {
    let text = std::fs::read_to_string(testkit::shared("imc/vectors.json")?).unwrap();
    Some(serde_json::from_str(&text).unwrap())
}

fn to_json(bytes: &[u8]) -> Value {
    let mut out = Vec::new();
    json::write_packet(&mut out, &PacketView::new(bytes).unwrap(), ShortPayload::default()).unwrap();
    serde_json::from_slice(&out).unwrap()
}

#[test]
fn every_vector_decodes_to_its_values_and_back_in_both_orders() {
    let Some(vectors) = vectors() else { return };
    for vector in vectors["vectors"].as_array().unwrap() {
        let name = &vector["name"];
        for (form, order) in [("packet_le", ByteOrder::Little), ("packet_be", ByteOrder::Big)] {
            let bytes = hex::decode(vector[form].as_str().unwrap()).unwrap();
            // By the generated structs.
            let packet = Packet::decode(&bytes).unwrap();
            assert_eq!(packet.order, order, "{name}");
            assert_eq!(packet.encode().unwrap(), bytes, "{name} {form}");
            // By the walk over the catalogue.
            let shown = to_json(&bytes);
            assert_eq!(shown["abbrev"], vector["abbrev"], "{name}");
            assert_eq!(shown["id"], vector["id"], "{name}");
            assert_eq!(shown["header"], vector["header"], "{name}");
            assert_eq!(shown["fields"], vector["fields"], "{name}");
            // And from the vector's values alone.
            let mut told = serde_json::Map::new();
            for key in ["abbrev", "header", "fields"] {
                told.insert(key.to_owned(), vector[key].clone());
            }
            let defaults = json::ReadDefaults { order: Some(order), ..Default::default() };
            let made = json::read_packet(&Value::Object(told), &defaults).unwrap();
            assert_eq!(made.encode().unwrap(), bytes, "{name} {form}");
        }
    }
}

#[test]
fn both_orders_say_the_same() {
    let Some(vectors) = vectors() else { return };
    for vector in vectors["vectors"].as_array().unwrap() {
        let little = Packet::decode(&hex::decode(vector["packet_le"].as_str().unwrap()).unwrap()).unwrap();
        let big = Packet::decode(&hex::decode(vector["packet_be"].as_str().unwrap()).unwrap()).unwrap();
        // Debug, because NaN is not equal to itself.
        assert_eq!(format!("{:?}", little.body), format!("{:?}", big.body));
        assert_eq!(Packet { order: ByteOrder::Big, ..little }.encode(), big.encode());
    }
}

#[test]
fn large_packets_match_their_digests() {
    let Some(vectors) = vectors() else { return };
    for (vector, (step, start)) in
        vectors["generated_large"].as_array().unwrap().iter().zip([(1, 0), (3, 7), (3, 7), (3, 7)])
    {
        let rule = format!("byte i = (i*{step}+{start}) mod 256");
        assert_eq!(vector["value_rule"], rule.as_str());
        let length = vector["value_length"].as_u64().unwrap();
        let value: Vec<u8> = (0..length).map(|i| ((i * step + start) % 256) as u8).collect();
        let header = imc::Header {
            timestamp: vector["header"]["timestamp"].as_f64().unwrap(),
            src: imc::Address(10256),
            src_ent: 1,
            ..Default::default()
        };
        for (order, form) in [(ByteOrder::Little, "le"), (ByteOrder::Big, "be")] {
            let message = imc::messages::DevDataBinary { value: value.clone() };
            let packet = Packet { order, ..Packet::new(header, message) };
            let bytes = packet.encode().unwrap();
            assert_eq!(bytes.len() as u64, vector[format!("packet_{form}_bytes")]);
            let digest = hex::encode(Sha256::digest(&bytes));
            assert_eq!(digest, vector[format!("packet_{form}_sha256")].as_str().unwrap());
            assert_eq!(Packet::decode(&bytes).unwrap(), packet);
        }
    }
}

#[test]
fn damaged_packets_give_the_stated_error() {
    let Some(vectors) = vectors() else { return };
    let all = vectors["malformed"].as_array().unwrap();
    assert_eq!(all.len(), 25);
    for vector in all {
        let bytes = hex::decode(vector["packet"].as_str().unwrap()).unwrap();
        let class = match Packet::decode(&bytes) {
            Ok(Packet { body: Body::Unknown { .. }, .. }) => "unknown_id",
            Ok(packet) => {
                // Trailing bytes and elements of another type are kept: the design decision left open.
                assert_eq!(packet.encode().unwrap(), bytes);
                "implementation_choice"
            }
            Err(error) => error.class(),
        };
        assert_eq!(class, vector["expected_error"].as_str().unwrap(), "{}", vector["name"]);
    }
}

#[test]
fn damage_is_placed_by_field_and_byte() {
    let Some(vectors) = vectors() else { return };
    let error = |name: &str| {
        let all = vectors["malformed"].as_array().unwrap();
        let vector = all.iter().find(|vector| vector["name"] == name).unwrap();
        Packet::decode(&hex::decode(vector["packet"].as_str().unwrap()).unwrap()).unwrap_err()
    };
    assert_eq!(
        error("bad_17_nested_unknown_id").to_string(),
        "EntityParameters (802): params[1] at byte 33 of the packet: \
         the nested message has the unknown id 2009"
    );
    assert_eq!(
        error("bad_18_nested_unknown_id").to_string(),
        "FollowRefState (480): reference.speed at byte 26 of the packet: \
         the nested message has the unknown id 3999"
    );
    assert_eq!(
        error("bad_22_payload_too_short").to_string(),
        "GpsFix (253): vacc at byte 72 of the packet: the field reaches past the end of the payload"
    );
    assert!(matches!(error("bad_04_bad_crc"), DecodeError::Frame(_)));
}

#[test]
fn the_digest_of_a_plan_is_the_same_from_either_byte_order() {
    let Some(vectors) = vectors() else { return };
    let all = vectors["vectors"].as_array().unwrap();
    let vector = all.iter().find(|vector| vector["name"] == "v038_PlanSpecification").unwrap();
    for form in ["packet_le", "packet_be"] {
        let packet = Packet::decode(&hex::decode(vector[form].as_str().unwrap()).unwrap()).unwrap();
        let md5 = imc::plan_digest::plan_md5(packet.get().unwrap()).unwrap();
        assert_eq!(hex::encode(md5), "53c394e9f01240ef7cfe470f49449959");
    }
}
