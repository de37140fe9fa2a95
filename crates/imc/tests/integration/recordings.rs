//! Recorded traffic and logs of a real DUNE vehicle.

use imc::lsf::{Index, LogItem, LogReader};
use imc::messages::{EntityInfo, EstimatedState, SetThrusterActuation};
use imc::{Frame, Frames, Packet, PacketView, ShortPayload, json, position};
use std::collections::BTreeMap;
use std::io::Read as _;
use std::path::Path;

fn unpacked(path: &Path) -> Vec<u8> {
    let mut bytes = Vec::new();
    let file = std::fs::File::open(path).unwrap();
    flate2::read::MultiGzDecoder::new(file).read_to_end(&mut bytes).unwrap();
    bytes
}

/// Every packet by its struct and by JSON, back to its bytes; counts by message.
fn check(bytes: &[u8]) -> BTreeMap<&'static str, usize> {
    let mut counts = BTreeMap::new();
    for frame in Frames::new(bytes) {
        let Frame::Packet { view, .. } = frame else { panic!("damage: {frame:?}") };
        let packet = Packet::from_view(&view, ShortPayload::default()).unwrap();
        assert_eq!(packet.encode().unwrap(), view.bytes());
        assert!(packet.trailing.is_empty());
        *counts.entry(packet.message().unwrap().abbrev()).or_insert(0) += 1;
    }
    counts
}

#[test]
fn captured_traffic_decodes_without_damage_and_returns_to_its_bytes() {
    for (file, packets, size) in [
        ("data/imc/dune_capture_a.imc.gz", 74_372, 3_628_637),
        ("data/imc/dune_capture_a_udp.imc.gz", 39_526, 1_969_715),
        ("data/imc/dune_log_a/Data.lsf.gz", 58_072, 2_783_539),
    ] {
        let Some(path) = testkit::shared(file) else { return };
        let bytes = unpacked(&path);
        assert_eq!(bytes.len(), size);
        let counts = check(&bytes);
        assert_eq!(counts.values().sum::<usize>(), packets);
        if file.contains("capture_a.imc") {
            // As the notes of the recording have them.
            for (message, count) in [
                ("EstimatedState", 2_600),
                ("GpsFix", 2_600),
                ("Rpm", 10_400),
                ("SetThrusterActuation", 4_030),
                ("EulerAngles", 9_101),
                ("AngularVelocity", 6_501),
                ("CpuUsage", 10_669),
                ("EntityState", 10_283),
                ("ManeuverControlState", 1_061),
                ("RemoteActions", 150),
            ] {
                assert_eq!(counts[message], count, "{message}");
            }
        }
    }
}

#[test]
fn captured_traffic_goes_through_json_and_back() {
    let Some(path) = testkit::shared("data/imc/dune_capture_a_udp.imc.gz") else { return };
    let bytes = unpacked(&path);
    let mut text = Vec::new();
    // One in eleven: every message is among them and the test stays quick.
    for frame in Frames::new(&bytes).step_by(11) {
        let Frame::Packet { view, .. } = frame else { panic!("damage: {frame:?}") };
        text.clear();
        json::write_packet(&mut text, &view, ShortPayload::default()).unwrap();
        let value = serde_json::from_slice(&text).unwrap();
        let back = json::read_packet(&value, &json::ReadDefaults::default()).unwrap();
        assert_eq!(back.encode().unwrap(), view.bytes());
    }
}

#[test]
fn a_compressed_log_reads_as_a_stream() {
    let Some(path) = testkit::shared("data/imc/dune_log_a/Data.lsf.gz") else { return };
    let mut reader = LogReader::open(&path).unwrap();
    let (mut packets, mut entities, mut index) = (0, 0, Index::default());
    while let Some(item) = reader.next_item().unwrap() {
        let LogItem::Packet { offset, view } = item else { panic!("{item:?}") };
        packets += 1;
        entities += usize::from(imc::decode::<EntityInfo>(&view).unwrap().is_some());
        index.add(&Frame::Packet { offset, view });
    }
    assert_eq!((packets, entities, reader.unpacked_bytes()), (58_072, 132, 2_783_539));

    // The index leads to every packet of ten seconds.
    let (_, latest) = index.span_s().unwrap();
    let (from, to) = (latest - 60.0, latest - 50.0);
    let bytes = unpacked(&path);
    let range = index.bytes_between(from, to);
    let inside = |bytes: &[u8]| {
        let wanted = |frame: &Frame<'_>| match frame {
            Frame::Packet { view, .. } => (from..=to).contains(&view.timestamp()),
            Frame::Damage(_) => false,
        };
        Frames::new(bytes).filter(wanted).count()
    };
    let part = &bytes[usize::try_from(range.start).unwrap()..usize::try_from(range.end).unwrap()];
    assert_eq!(inside(part), inside(&bytes));
    assert!(inside(part) > 2_000, "{}", inside(part));
    assert!(part.len() < bytes.len() / 5, "{} of {}", part.len(), bytes.len());
}

#[test]
fn the_vehicle_is_at_its_reference_displaced() {
    let Some(path) = testkit::shared("data/imc/dune_capture_a.imc.gz") else { return };
    let bytes = unpacked(&path);
    let state = |view: &PacketView<'_>| imc::decode::<EstimatedState>(view).unwrap();
    let mut furthest = 0.0_f64;
    for frame in Frames::new(&bytes) {
        let Frame::Packet { view, .. } = frame else { panic!("damage: {frame:?}") };
        let Some(state) = state(&view) else { continue };
        let place = position::place(&state).unwrap();
        let frame = units::LocalFrame::new(units::LatLon::from_rad(state.lat, state.lon).unwrap());
        let local = frame.to_local(place);
        // 3 mm a metre for the geocentric angle, which only tilts the offset.
        assert!((local.north_m - f64::from(state.x)).abs() < 0.01, "{local:?} {state:?}");
        assert!((local.east_m - f64::from(state.y)).abs() < 0.01, "{local:?} {state:?}");
        furthest = furthest.max(local.north_m.hypot(local.east_m));
    }
    // The plan's legs are some forty metres.
    assert!(furthest > 20.0, "{furthest}");
}

#[test]
fn both_thrusters_speak_in_the_same_millisecond() {
    let Some(path) = testkit::shared("data/imc/dune_capture_a.imc.gz") else { return };
    let bytes = unpacked(&path);
    let mut by_millisecond = BTreeMap::<(u8, i64), Vec<u8>>::new();
    for frame in Frames::new(&bytes) {
        let Frame::Packet { view, .. } = frame else { panic!("damage: {frame:?}") };
        if let Some(thrust) = imc::decode::<SetThrusterActuation>(&view).unwrap() {
            let millisecond = (view.timestamp() * 1e3).floor() as i64;
            by_millisecond.entry((view.src_ent(), millisecond)).or_default().push(thrust.id);
        }
    }
    assert_eq!(by_millisecond.len(), 2_022);
    assert!(by_millisecond.values().filter(|ids| ids.len() > 1).count() > 1_900);
}
