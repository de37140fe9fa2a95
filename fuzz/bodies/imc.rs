//! What must hold for any bytes. The fuzz targets call these with bytes of their own making, and
//! `make test` with the committed seeds and everything that was ever found.

#![allow(dead_code, reason = "each fuzz target calls one of these")]

use imc::lsf::{Index, LogItem, LogReader};
use imc::{
    Body, ByteOrder, Deframer, Frame, Frames, Header, Packet, PacketView, ShortPayload, json, messages,
    reflect,
};

/// A packet as it is; and the bytes as order, id and payload of one, so that the checksum is no obstacle.
pub(crate) fn packet(data: &[u8]) {
    if let Ok(packet) = Packet::decode(data) {
        let bytes = packet.encode().expect("what was decoded fits");
        assert_eq!(bytes, data[..bytes.len()]);
    }
    if let [order, low, high, payload @ ..] = data {
        let payload = payload[..payload.len().min(imc::MAX_PAYLOAD_BYTES)].to_vec();
        let packet = Packet {
            order: if order & 1 == 0 { ByteOrder::Little } else { ByteOrder::Big },
            body: Body::Unknown { id: u16::from_le_bytes([*low, *high]), payload },
            ..Packet::new(Header::default(), messages::Heartbeat)
        };
        check_packet(&packet.encode().expect("the payload fits"));
    }
}

fn check_packet(bytes: &[u8]) {
    let view = PacketView::new(bytes).expect("made whole");
    let strict = Packet::from_view(&view, ShortPayload::KnownLayouts);
    if let Some(walked) = reflect::fields(&view) {
        assert_eq!(walked.is_ok(), strict.is_ok());
    }
    for short in [ShortPayload::KnownLayouts, ShortPayload::AnyBoundary] {
        let mut text = Vec::new();
        let shown = json::write_packet(&mut text, &view, short).is_ok();
        match Packet::from_view(&view, short) {
            Ok(packet) => {
                assert_eq!(packet.encode().expect("what was decoded fits"), bytes);
                assert_eq!(shown, packet.message().is_some());
                check_values(&packet, bytes, short);
            }
            Err(error) => {
                assert!(!shown);
                assert!(!error.to_string().is_empty() && !error.class().is_empty());
            }
        }
        if shown {
            let value = serde_json::from_slice(&text).expect("JSON is JSON");
            let back = json::read_packet(&value, &json::ReadDefaults::default()).expect("it was written");
            assert_eq!(back.encode().expect("it fitted"), bytes);
        }
    }
}

/// Nested messages, which are decoded when they are asked for, are the same whichever byte order they came in,
/// and the same when they are packed again.
fn check_values(packet: &Packet, bytes: &[u8], short: ShortPayload) {
    let other = match packet.order {
        ByteOrder::Little => ByteOrder::Big,
        ByteOrder::Big => ByteOrder::Little,
    };
    // What is unknown cannot be turned around.
    let Some(message) = packet.message() else { return };
    let turned = Packet { order: other, ..packet.clone() }.encode().expect("what was decoded fits");
    let back = Packet::from_view(&PacketView::new(&turned).expect("made whole"), short).expect("made whole");
    let values = format!("{message:?}");
    assert_eq!(Some(&values), back.message().map(|message| format!("{message:?}")).as_ref());
    assert_eq!(Packet { order: packet.order, ..back }.encode().expect("it fitted"), bytes);
    let around = messages::PlanDB { arg: message.clone().into(), ..messages::PlanDB::default() };
    // Nested too deep, it is not packed; a tag without a position has NaN for one in there.
    if let Some(inner) = around.arg.get()
        && packet.get::<messages::TBRFishTag>().is_none()
    {
        assert_eq!(format!("{inner:?}"), values);
    }
}

/// A stream gives the same whole or in pieces, and every byte of it is accounted for.
pub(crate) fn deframer(data: &[u8]) {
    let [piece, data @ ..] = data else { return };
    let (mut deframer, mut counted) = (Deframer::new(), 0);
    let mut whole = Frames::new(data);
    let mut take = |deframer: &mut Deframer| {
        while let Some(frame) = deframer.next_frame() {
            let (offset, bytes) = match &frame {
                Frame::Packet { offset, view } => (*offset, view.bytes().len() as u64),
                Frame::Damage(damage) => (damage.offset, damage.bytes),
            };
            assert_eq!(offset, counted);
            assert!(bytes > 0);
            counted += bytes;
            // A run of damage beyond 64 KiB comes in pieces, and only then do the two differ.
            if data.len() < imc::MAX_PACKET_BYTES {
                assert_eq!(Some(frame), whole.next());
            }
        }
    };
    for piece in data.chunks(usize::from(*piece) + 1) {
        deframer.push(piece);
        take(&mut deframer);
    }
    deframer.finish();
    take(&mut deframer);
    assert_eq!(counted, data.len() as u64);
}

/// JSON that is read gives a packet that is written as JSON that reads the same.
pub(crate) fn json(data: &[u8]) {
    let Ok(value) = serde_json::from_slice(data) else { return };
    let Ok(packet) = json::read_packet(&value, &json::ReadDefaults::default()) else { return };
    let Ok(bytes) = packet.encode() else { return };
    check_packet(&bytes);
    if let Ok(message) = json::message_from_value(&value) {
        let text = json::message_to_string(&message).expect("it fitted");
        let again = serde_json::from_str(&text).expect("JSON is JSON");
        let again = json::message_from_value(&again).expect("it was written");
        assert_eq!(json::message_to_string(&again).as_ref(), Ok(&text));
    }
}

/// A log reads to its end whatever it is, compressed or not.
pub(crate) fn lsf(data: &[u8]) {
    let mut reader = LogReader::detect(std::io::Cursor::new(data.to_vec())).expect("memory can be read");
    let (mut index, mut end) = (Index::new(64), 0);
    while let Some(item) = reader.next_item().expect("memory can be read") {
        match item {
            LogItem::Packet { offset, view } => {
                assert_eq!(offset, end);
                end += view.bytes().len() as u64;
                index.add(&Frame::Packet { offset, view });
            }
            LogItem::Damage(damage) => {
                assert_eq!(damage.offset, end);
                end += damage.bytes;
                index.add(&Frame::Damage(damage));
            }
            // What was unpacked before may be waiting for the rest of its packet.
            LogItem::Cut { offset, .. } => assert!(offset >= end),
        }
        // A few kilobytes of gzip can hold gigabytes; the reader would go on in constant memory.
        if end > 16 << 20 {
            return;
        }
    }
    assert_eq!(end, reader.unpacked_bytes());
    if let Some((from, to)) = index.span_s() {
        assert!(!index.bytes_between(from, to).is_empty());
    }
}
