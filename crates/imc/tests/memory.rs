//! How much memory bytes from outside can make us take. Alone in its process and one test, because it counts
//! every allocation.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

#[path = "integration/support/mod.rs"]
mod support;

use imc::catalogue::{FieldKind, MESSAGES, MessageDesc};
use imc::messages::{Goto, MsgList, PlanDB, PlanManeuver, PlanSpecification, PlanTransition};
use imc::{
    Body, ByteOrder, Deframer, Frame, Header, MAX_PACKET_BYTES, MessageList, Nested, Packet, PacketView,
    ShortPayload, json, reflect,
};
use peak_alloc::PeakAlloc;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use support::Entropy;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// What a packet may cost whatever its size: its struct, of which `PlanSpecification` is the largest with some
/// 300 bytes, or the place that an error names, at most 16 fields deep.
const ANYWAY: usize = 1_024;

/// Most bytes held at once by `work`, beyond what was held before.
fn peak<T>(work: impl FnOnce() -> T) -> usize {
    let before = ALLOCATOR.current_usage();
    ALLOCATOR.reset_peak_usage();
    let result = work();
    let peak = ALLOCATOR.peak_usage() - before;
    drop(result);
    peak
}

fn stream(bytes: &[u8]) -> usize {
    let mut deframer = Deframer::new();
    let mut packets = 0;
    let mut take = |deframer: &mut Deframer| {
        while let Some(frame) = deframer.next_frame() {
            packets += usize::from(matches!(frame, Frame::Packet { .. }));
        }
    };
    for piece in bytes.chunks(1 << 16) {
        deframer.push(piece);
        take(&mut deframer);
    }
    deframer.finish();
    take(&mut deframer);
    packets
}

fn packet(id: u16, payload: Vec<u8>) -> Vec<u8> {
    let body = Body::Unknown { id, payload };
    let known = Packet::new(Header::default(), imc::messages::Heartbeat);
    Packet { body, ..known }.encode().unwrap()
}

/// A stream of 1 MiB costs less than its own size, however mean it is.
fn streams_are_not_held() {
    let heartbeats = packet(150, vec![]).repeat((1 << 20) / 22);
    let false_starts = [0x54, 0xFE].repeat(1 << 19);
    let half_packets = [&packet(150, vec![0; 60_000])[..59_000]; 16].concat();
    for bytes in [heartbeats, false_starts, half_packets] {
        let held = peak(|| stream(&bytes));
        assert!(held < 512 << 10, "{held} bytes held for a stream of {}", bytes.len());
    }
}

/// What a count or length claims costs nothing until the bytes are there.
fn claims_are_not_believed() {
    for (id, payload) in [
        (802, vec![0, 0, 0xFF, 0xFF]),    // EntityParameters: 65 535 parameters
        (274, vec![0xFF, 0xFF, 1, 2, 3]), // DevDataBinary: 65 535 bytes
        (20, [0xFF, 0xFF].repeat(20)),    // MsgList: lists of nothing
        (551, vec![0xFF; 9]),             // PlanSpecification
    ] {
        let bytes = packet(id, payload);
        let held = peak(|| Packet::decode(&bytes));
        assert!(held < ANYWAY, "{held} bytes held for message {id}");
    }
}

/// The bounds for one packet, decoded or refused, looked into, and written again; most that decoding took
/// beyond the packet's size.
fn check(bytes: &[u8]) -> usize {
    let view = PacketView::new(bytes).unwrap();
    let mut beyond = 0;
    for short in [ShortPayload::KnownLayouts, ShortPayload::AnyBoundary] {
        let held = peak(|| Packet::from_view(&view, short));
        // The goal is twice its size; once is what it takes.
        assert!(held <= bytes.len() + ANYWAY, "{held} bytes held for {}", bytes.len());
        beyond = beyond.max(held.saturating_sub(bytes.len()));
    }
    if let Ok(packet) = Packet::from_view(&view, ShortPayload::KnownLayouts) {
        // While its elements are looked at, one is held at a time.
        let held = peak(|| {
            let packet = Packet::from_view(&view, ShortPayload::KnownLayouts).unwrap();
            visit(&packet);
        });
        assert!(held <= 2 * bytes.len() + 2 * ANYWAY, "{held} bytes held to see {}", bytes.len());
        // A vector that grows is there twice for a moment.
        let held = peak(|| packet.encode().unwrap());
        assert!(held <= 3 * bytes.len() + ANYWAY, "{held} bytes held to write {}", bytes.len());
    }
    // The walk holds nothing at all, but for the place of an error.
    let held = peak(|| reflect::check(&view));
    assert!(held <= ANYWAY, "{held} bytes held to walk over {}", bytes.len());
    beyond
}

/// JSON costs what it prints, again with a vector twice for a moment; and reading it at most twice what it says.
fn check_json(bytes: &[u8]) {
    let view = PacketView::new(bytes).unwrap();
    let print = || {
        let mut text = Vec::new();
        json::write_packet(&mut text, &view, ShortPayload::AnyBoundary).map(|()| text)
    };
    let held = peak(print);
    let Ok(text) = print() else { return };
    assert!(held <= 3 * text.len() + ANYWAY, "{held} bytes held to print {}", text.len());
    let value = serde_json::from_slice(&text).unwrap();
    let held = peak(|| json::read_packet(&value, &json::ReadDefaults::default()).unwrap());
    assert!(held <= 2 * text.len() + ANYWAY, "{held} bytes held to read {}", text.len());
}

/// Looks at every message right inside the packet's, of the messages that nest most.
fn visit(packet: &Packet) {
    let look = |list: &MessageList| assert_eq!(list.iter().count(), list.len());
    let one = |nested: &Nested| assert_eq!(nested.get().is_none(), nested.is_none());
    if let Some(list) = packet.get::<MsgList>() {
        look(&list.msgs);
    } else if let Some(plan) = packet.get::<PlanSpecification>() {
        for list in [&plan.maneuvers, &plan.transitions, &plan.start_actions, &plan.end_actions] {
            look(list);
        }
    } else if let Some(request) = packet.get::<PlanDB>() {
        one(&request.arg);
    } else if let Some(reference) = packet.get::<imc::messages::Reference>() {
        one(&reference.speed);
        one(&reference.z);
    }
}

/// Bytes and text cost what they are.
fn flat_packets() {
    for id in [274, 273] {
        let bytes = packet(id, [&60_000_u16.to_le_bytes()[..], &vec![b'x'; 60_000]].concat());
        check(&bytes);
        check_json(&bytes);
    }
}

/// The least that a nested message of this kind takes: all zeros, and nothing where messages go.
fn least(message: &MessageDesc) -> Vec<u8> {
    let mut element = message.id.to_le_bytes().to_vec();
    for field in message.fields {
        match field.kind {
            FieldKind::Message => element.extend_from_slice(&[0xFF, 0xFF]),
            kind => element.extend(std::iter::repeat_n(0, kind.width().unwrap_or(2))),
        }
    }
    element
}

/// A tree of References, the one message that holds two, with these in its leaves.
fn tree(leaf: &[u8], height: u32) -> Vec<u8> {
    let Some(height) = height.checked_sub(1) else { return leaf.to_vec() };
    let inner = tree(leaf, height);
    let Some(reference) = imc::catalogue::by_abbrev("Reference") else { unreachable!() };
    let mut out = reference.id.to_le_bytes().to_vec();
    for field in reference.fields {
        match field.kind {
            FieldKind::Message => out.extend_from_slice(&inner),
            kind => out.extend(std::iter::repeat_n(0, kind.width().unwrap_or(2))),
        }
    }
    out
}

/// 64 KiB of any message inside others, as small and as many as can be: in a list, in lists of lists and in a
/// tree.
fn nested_packets() {
    let list = |element: &[u8], room: usize| {
        let count = room / element.len();
        [&(count as u16).to_le_bytes()[..], &element.repeat(count)].concat()
    };
    let mut payloads = vec![(20, list(&[0xFF, 0xFF], 65_533))];
    for message in MESSAGES {
        let element = least(message);
        payloads.push((20, list(&element, 65_533)));
        let inner = [&20_u16.to_le_bytes()[..], &list(&element, 40)].concat();
        payloads.push((20, list(&inner, 65_533)));
        let mut height = 1;
        while height < 16 && tree(&element, height + 1).len() < 65_500 {
            height += 1;
        }
        payloads.push((479, tree(&element, height)[2..].to_vec()));
    }
    let mut worst = 0;
    for (at, (id, payload)) in payloads.into_iter().enumerate() {
        let bytes = packet(id, payload);
        worst = worst.max(check(&bytes));
        // Megabytes of text, so not all of them.
        if at % 50 == 0 {
            check_json(&bytes);
        }
    }
    println!("64 KiB of nested messages: at most {worst} bytes beyond their size");
}

/// Plans as a console makes them.
fn plans() {
    for count in [120, 600] {
        let waypoint = |at: usize| PlanManeuver {
            maneuver_id: format!("wp{at}").as_str().into(),
            data: Goto { lat: 1.107, lon: 0.18, speed: 1.2, ..Goto::default() }.into(),
            ..PlanManeuver::default()
        };
        let transition = |at: usize| PlanTransition {
            source_man: format!("wp{at}").as_str().into(),
            dest_man: format!("wp{}", at + 1).as_str().into(),
            ..PlanTransition::default()
        };
        let plan = PlanSpecification {
            plan_id: "survey".into(),
            maneuvers: (0..count).map(waypoint).collect(),
            transitions: (1..count).map(transition).collect(),
            ..PlanSpecification::default()
        };
        for order in [ByteOrder::Little, ByteOrder::Big] {
            let request = PlanDB { arg: plan.clone().into(), ..PlanDB::default() };
            for message in [plan.clone().into(), imc::Message::from(request)] {
                let bytes = Packet { order, ..Packet::new(Header::default(), message) }.encode().unwrap();
                let beyond = check(&bytes);
                check_json(&bytes);
                println!("plan of {count} waypoints, {} bytes: {beyond} beyond its size", bytes.len());
            }
        }
    }
}

/// Any rubbish, with a right checksum around it.
fn rubbish() {
    let mut seed = 0x2545_F491_4F6C_DD1D_u64;
    let mut random = || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        seed
    };
    for message in MESSAGES {
        for _ in 0..4 {
            let length = (random() % 3_000) as usize;
            let payload: Vec<u8> = (0..length).map(|_| random() as u8).collect();
            let bytes = packet(message.id, payload);
            check(&bytes);
            check_json(&bytes);
        }
    }
}

/// Every message with any values, in either byte order, and a list filled up with it.
fn generated_packets() {
    let entropy = proptest::collection::vec(any::<u8>(), 0..2_000);
    let outcome =
        TestRunner::new(ProptestConfig { cases: 16, failure_persistence: None, ..ProptestConfig::default() })
            .run(&(entropy, any::<bool>()), |(entropy, big)| {
                let order = if big { ByteOrder::Big } else { ByteOrder::Little };
                for desc in MESSAGES {
                    let wire = support::packet(desc, &mut Entropy(&entropy)).encode().unwrap();
                    let message = Packet::decode(&wire).unwrap();
                    let bytes = Packet { order, ..message.clone() }.encode().unwrap();
                    check(&bytes);
                    check_json(&bytes);
                    let Some(element) = message.message() else { unreachable!() };
                    let count = (MAX_PACKET_BYTES - 30) / (wire.len() - 18).max(2);
                    let msgs = std::iter::repeat_n(element.clone(), count.min(200)).collect();
                    check(
                        &Packet { order, ..Packet::new(Header::default(), MsgList { msgs }) }
                            .encode()
                            .unwrap(),
                    );
                }
                Ok(())
            });
    outcome.unwrap();
}

/// A few bytes of JSON that ask for the defaults of large messages get no more than the longest packet, as a
/// vector that doubled, beside itself as a packet and that decoded.
fn short_json_of_much() {
    let elements = vec![serde_json::json!({"id": 551}); 60_000];
    for count in [10, 1_000, 3_000, 60_000] {
        let value = serde_json::json!({"id": 20, "fields": {"msgs": elements[..count]}});
        let held = peak(|| json::read_packet(&value, &json::ReadDefaults::default()).is_ok());
        assert!(held <= 4 * MAX_PACKET_BYTES, "{held} bytes held for {count} elements");
    }
}

#[test]
fn memory_follows_the_bytes_that_came() {
    streams_are_not_held();
    claims_are_not_believed();
    flat_packets();
    nested_packets();
    plans();
    rubbish();
    generated_packets();
    short_json_of_much();
}
