//! How much memory bytes from outside can make us take. Alone in its process, because it counts every
//! allocation.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

use imc::{Body, ByteOrder, Deframer, Frame, Header, Packet, PacketView, ShortPayload, json, reflect};
use peak_alloc::PeakAlloc;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

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
        assert!(held < 1_024, "{held} bytes held for message {id}");
    }
}

/// The walk, and so reflection, costs nothing; bytes and text cost what they are.
fn flat_packets_cost_twice_their_size_at_most() {
    for id in [274, 273] {
        let payload = [&60_000_u16.to_le_bytes()[..], &vec![b'x'; 60_000]].concat();
        let bytes = packet(id, payload);
        let held = peak(|| Packet::decode(&bytes).unwrap());
        assert!(held <= 2 * bytes.len(), "{held} bytes held for {}", bytes.len());
    }
}

/// Lists of small messages are the worst: an element of 4 bytes costs 16 in the list and its own box. So a
/// packet of 64 KiB costs 0.75 MiB at most, whatever is in it.
fn nested_packets_cost_a_bounded_multiple() {
    let mut worst = 0;
    let nulls = [&32_766_u16.to_le_bytes()[..], &[0xFF].repeat(65_532)].concat();
    let mut payloads = vec![nulls];
    for message in imc::catalogue::MESSAGES {
        // The least that a list can hold of this message: all zeros, and nothing where messages go.
        let mut element = message.id.to_le_bytes().to_vec();
        for field in message.fields {
            match field.kind {
                imc::catalogue::FieldKind::Message => element.extend_from_slice(&[0xFF, 0xFF]),
                kind => element.extend(std::iter::repeat_n(0, kind.width().unwrap_or(2))),
            }
        }
        let count = 65_533 / element.len();
        payloads.push([&(count as u16).to_le_bytes()[..], &element.repeat(count)].concat());
    }
    for payload in payloads {
        let bytes = packet(20, payload);
        let held = peak(|| Packet::decode(&bytes).unwrap());
        worst = worst.max(held);
        // The walk over the same packet holds nothing at all.
        let view = PacketView::new(&bytes).unwrap();
        let held = peak(|| reflect::check(&view).unwrap().unwrap());
        assert_eq!(held, 0);
    }
    println!("at most {worst} bytes for a packet");
    assert!(worst <= 780_000, "{worst}");
}

/// Decoding any rubbish costs little; JSON of it costs what it prints.
fn rubbish_costs_little() {
    let mut seed = 0x2545_F491_4F6C_DD1D_u64;
    let mut random = || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        seed
    };
    for message in imc::catalogue::MESSAGES {
        for _ in 0..4 {
            let length = (random() % 3_000) as usize;
            let payload: Vec<u8> = (0..length).map(|_| random() as u8).collect();
            let mut bytes = packet(message.id, payload);
            let packet =
                Packet { order: ByteOrder::Big, ..Packet::new(Header::default(), imc::messages::Abort) };
            bytes.extend_from_slice(&packet.encode().unwrap());
            let view = PacketView::new(&bytes).unwrap();
            let held = peak(|| Packet::from_view(&view, ShortPayload::AnyBoundary).is_ok());
            assert!(held <= 2 * bytes.len() + 4_096, "{held} bytes held for {}", message.abbrev);
            let mut text = Vec::new();
            peak(|| json::write_packet(&mut text, &view, ShortPayload::AnyBoundary).is_ok());
        }
    }
}

#[test]
fn memory_follows_the_bytes_that_came() {
    streams_are_not_held();
    claims_are_not_believed();
    flat_packets_cost_twice_their_size_at_most();
    nested_packets_cost_a_bounded_multiple();
    rubbish_costs_little();
}
