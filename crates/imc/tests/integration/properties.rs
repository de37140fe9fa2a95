//! Properties of all messages, all streams and all bytes.

use crate::support::Entropy;
use imc::catalogue::{MESSAGES, Meaning};
use imc::reflect::Value;
use imc::{
    Body, ByteOrder, Damage, Deframer, Frame, Frames, Packet, PacketView, ShortPayload, json, reflect,
};
use proptest::prelude::*;

fn entropy() -> impl Strategy<Value = Vec<u8>> {
    proptest::collection::vec(any::<u8>(), 0..600)
}

fn through_json(view: &PacketView<'_>) -> Vec<u8> {
    let mut text = Vec::new();
    json::write_packet(&mut text, view, ShortPayload::default()).unwrap();
    let value = serde_json::from_slice(&text).unwrap();
    json::read_packet(&value, &json::ReadDefaults::default()).unwrap().encode().unwrap()
}

/// Packets and damage, packets by their bytes.
#[derive(Debug, PartialEq)]
enum Seen {
    Packet(u64, Vec<u8>),
    Damage(Damage),
}

fn seen(frame: Frame<'_>) -> Seen {
    match frame {
        Frame::Packet { offset, view } => Seen::Packet(offset, view.bytes().to_vec()),
        Frame::Damage(damage) => Seen::Damage(damage),
    }
}

fn in_pieces(bytes: &[u8], cuts: &[prop::sample::Index]) -> Vec<Seen> {
    let mut cuts: Vec<usize> = cuts.iter().map(|cut| cut.index(bytes.len() + 1)).collect();
    cuts.sort_unstable();
    let mut deframer = Deframer::new();
    let mut all = Vec::new();
    let mut from = 0;
    for to in cuts.into_iter().chain([bytes.len()]) {
        deframer.push(&bytes[from..to]);
        while let Some(frame) = deframer.next_frame() {
            all.push(seen(frame));
        }
        from = to;
    }
    deframer.finish();
    while let Some(frame) = deframer.next_frame() {
        all.push(seen(frame));
    }
    all
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn every_message_survives_every_way_round(bytes in entropy()) {
        for desc in MESSAGES {
            let wire = crate::support::packet(desc, &mut Entropy(&bytes)).encode().unwrap();
            let packet = Packet::decode(&wire).unwrap();
            prop_assert_eq!(packet.message().map(imc::Message::id), Some(desc.id));
            prop_assert!(packet.trailing.is_empty());
            prop_assert_eq!(&packet.encode().unwrap(), &wire, "{}", desc.abbrev);
            // In the other byte order it is the same message.
            let big = Packet { order: ByteOrder::Big, ..packet.clone() }.encode().unwrap();
            let back = Packet::decode(&big).unwrap();
            // By Debug, because NaN is not equal to itself.
            prop_assert_eq!(format!("{:?}", back.body), format!("{:?}", packet.body));
            prop_assert_eq!(&Packet { order: ByteOrder::Little, ..back }.encode().unwrap(), &wire);
            // And so it is as JSON.
            prop_assert_eq!(&through_json(&PacketView::new(&wire).unwrap()), &wire, "{}", desc.abbrev);
            prop_assert_eq!(&through_json(&PacketView::new(&big).unwrap()), &big, "{}", desc.abbrev);
        }
    }

    #[test]
    fn messages_without_nan_are_equal_to_what_they_decode_to(bytes in entropy()) {
        for desc in MESSAGES {
            let wire = crate::support::packet(desc, &mut Entropy(&bytes)).encode().unwrap();
            let packet = Packet::decode(&wire).unwrap();
            if !format!("{packet:?}").contains("NaN") {
                prop_assert_eq!(Packet::decode(&packet.encode().unwrap()).unwrap(), packet);
            }
        }
    }

    #[test]
    fn the_walk_and_the_structs_see_the_same_values(bytes in proptest::collection::vec(any::<u8>(), 300..600)) {
        for desc in MESSAGES {
            let wire = crate::support::packet(desc, &mut Entropy(&bytes)).encode().unwrap();
            let told = format!("{:?}", Packet::decode(&wire).unwrap().message().unwrap());
            // Fields in their order, so that two that were exchanged are noticed.
            let mut rest = told.as_str();
            for field in reflect::fields(&PacketView::new(&wire).unwrap()).unwrap().unwrap() {
                let plain = field.desc.meaning == Meaning::Plain && !field.path.contains(['.', '[']);
                let value = match field.value {
                    Value::Integer(value) if plain => value.to_string(),
                    Value::Single(value) if plain => format!("{value:?}"),
                    Value::Double(value) if plain && field.desc.appended => format!("Some({value:?})"),
                    Value::Double(value) if plain => format!("{value:?}"),
                    _ => continue,
                };
                let wanted = format!("{}: {value}", crate::support::snake(field.desc.abbrev));
                let at = rest.find(&wanted);
                prop_assert!(at.is_some(), "{wanted} is not in {rest}");
                rest = &rest[at.unwrap_or(0) + wanted.len()..];
            }
        }
    }

    #[test]
    fn a_stream_gives_the_same_packets_however_it_is_cut(
        pieces in proptest::collection::vec((0..4_u8, 0..MESSAGES.len(), entropy()), 0..8),
        cuts in proptest::collection::vec(any::<prop::sample::Index>(), 0..12),
    ) {
        let mut stream = Vec::new();
        let mut sent = Vec::new();
        for (kind, at, bytes) in pieces {
            let mut wire = crate::support::packet(MESSAGES[at], &mut Entropy(&bytes)).encode().unwrap();
            match kind {
                0 => wire = bytes[..bytes.len().min(90)].to_vec(),
                // A damaged packet, and one of the bytes that could start the next.
                1 => {
                    wire[6] ^= 1;
                    wire.push(0x54);
                }
                _ => sent.push(Seen::Packet(stream.len() as u64, wire.clone())),
            }
            stream.extend_from_slice(&wire);
        }
        let whole: Vec<Seen> = Frames::new(&stream).map(seen).collect();
        prop_assert_eq!(&in_pieces(&stream, &cuts), &whole);
        // Nothing sent is lost, and every byte is accounted for.
        for packet in &sent {
            prop_assert!(whole.contains(packet));
        }
        let counted: u64 = whole.iter().map(|seen| match seen {
            Seen::Packet(_, bytes) => bytes.len() as u64,
            Seen::Damage(damage) => damage.bytes,
        }).sum();
        prop_assert_eq!(counted, stream.len() as u64);
    }

    #[test]
    fn any_flipped_bit_is_noticed(at in 0..MESSAGES.len(), bytes in entropy(), bit in any::<prop::sample::Index>()) {
        let wire = crate::support::packet(MESSAGES[at], &mut Entropy(&bytes)).encode().unwrap();
        let mut damaged = wire.clone();
        let bit = bit.index(wire.len() * 8);
        damaged[bit / 8] ^= 1 << (bit % 8);
        prop_assert!(Packet::decode(&damaged).is_err());
    }

    #[test]
    fn arbitrary_payloads_never_panic(
        at in 0..MESSAGES.len(),
        payload in proptest::collection::vec(any::<u8>(), 0..400),
        big in any::<bool>(),
    ) {
        let order = if big { ByteOrder::Big } else { ByteOrder::Little };
        let desc = MESSAGES[at];
        let packet = Packet {
            order,
            body: Body::Unknown { id: desc.id, payload: payload.clone() },
            ..crate::support::packet(desc, &mut Entropy(&[]))
        };
        let wire = packet.encode().unwrap();
        let view = PacketView::new(&wire).unwrap();
        let strict = Packet::from_view(&view, ShortPayload::KnownLayouts);
        let checked = reflect::check(&view);
        prop_assert_eq!(checked.is_none(), view.desc().is_none());
        prop_assert_eq!(strict.is_ok(), checked.is_none_or(|fits| fits.is_ok()));
        for decoded in [strict, Packet::from_view(&view, ShortPayload::AnyBoundary)].into_iter().flatten() {
            prop_assert_eq!(&decoded.encode().unwrap(), &wire);
        }
        let mut text = Vec::new();
        if json::write_packet(&mut text, &view, ShortPayload::AnyBoundary).is_ok() {
            let value = serde_json::from_slice(&text).unwrap();
            let back = json::read_packet(&value, &json::ReadDefaults::default()).unwrap();
            prop_assert_eq!(&back.encode().unwrap(), &wire);
        } else {
            prop_assert!(text.is_empty());
        }
    }

    #[test]
    fn a_payload_cut_between_two_fields_is_an_older_sender(at in 0..MESSAGES.len(), bytes in entropy(), cut in any::<prop::sample::Index>()) {
        let desc = MESSAGES[at];
        let mut packet = crate::support::packet(desc, &mut Entropy(&bytes));
        let Body::Unknown { payload, .. } = &mut packet.body else { unreachable!() };
        payload.truncate(cut.index(payload.len() + 1));
        let wire = packet.encode().unwrap();
        let view = PacketView::new(&wire).unwrap();
        if let Ok(decoded) = Packet::from_view(&view, ShortPayload::AnyBoundary) {
            prop_assert_eq!(&decoded.encode().unwrap(), &wire);
            // Of a fixed size, which a cut one has not.
            prop_assume!(view.desc().is_some());
            let mut text = Vec::new();
            json::write_packet(&mut text, &view, ShortPayload::AnyBoundary).unwrap();
            let value: serde_json::Value = serde_json::from_slice(&text).unwrap();
            let fields = value["fields"].as_object().unwrap().len();
            let absent = value["absent"].as_array().map_or(0, Vec::len);
            prop_assert_eq!(fields + absent, desc.fields.len());
            let back = json::read_packet(&value, &json::ReadDefaults::default()).unwrap();
            prop_assert_eq!(&back.encode().unwrap(), &wire);
        }
    }
}
