//! What must hold for any bytes that claim to come from the motors' CAN bus, through a log, a serial adapter or the motors'
//! own bus. The fuzz targets call these with bytes of their own making, and `make test` with the committed seeds and
//! everything that was ever found.

use devices::{candump, slcan, tq_bus};

/// The pieces that two cuts make of the bytes; where they are cut, the first two bytes say.
fn pieces(data: &[u8]) -> [&[u8]; 3] {
    let place = |at: usize| data.get(at).map_or(0, |byte| usize::from(*byte) * data.len() / 256);
    let (first, second) = (place(0).min(place(1)), place(0).max(place(1)));
    [&data[..first], &data[first..second], &data[second..]]
}

/// Lines of a candump log are the same in any pieces, and are read back as they were written.
pub(crate) fn candump(data: &[u8]) {
    let read = |pieces: &[&[u8]]| {
        let mut reader = candump::Reader::default();
        let mut found = Vec::new();
        for piece in pieces {
            reader.feed(piece, |at, entry| found.push((at, entry)));
        }
        reader.end(|at, entry| found.push((at, entry)));
        found
    };
    let found = read(&[data]);
    assert_eq!(found, read(&pieces(data)));
    for (_, entry) in found {
        let Ok(entry) = entry else { continue };
        assert_eq!(candump::Entry::parse(entry.to_string().as_bytes()), Ok(entry));
    }
}

/// Lines of a serial adapter are the same in any pieces, and frames are read back as they were written.
pub(crate) fn slcan(data: &[u8]) {
    let read = |pieces: &[&[u8]]| {
        let mut reader = slcan::Reader::default();
        let mut found = Vec::new();
        for piece in pieces {
            reader.feed(piece, |at, line| found.push((at, line)));
        }
        reader.end(|at, line| found.push((at, line)));
        found
    };
    let found = read(&[data]);
    assert_eq!(found, read(&pieces(data)));
    for (_, line) in found {
        let Ok(slcan::Line::Frame { frame, .. }) = line else { continue };
        let bytes = slcan::encode(&frame);
        let again = slcan::Line::parse(&bytes[..bytes.len() - 1]);
        assert_eq!(again, Ok(slcan::Line::Frame { frame, stamp_ms: None }));
    }
}

/// Frames of the motors' own bus are the same in any pieces, are read back as they were written, and whatever comes, the
/// frame after it is read.
pub(crate) fn tq_bus(data: &[u8]) {
    let read = |pieces: &[&[u8]]| {
        let mut deframer = tq_bus::Deframer::default();
        let mut found = Vec::new();
        let mut keep = |at, frame: tq_bus::Deframed<'_>| found.push((at, frame.map(<[u8]>::to_vec)));
        for piece in pieces {
            deframer.feed(piece, &mut keep);
        }
        deframer.end(&mut keep);
        found
    };
    let found = read(&[data]);
    assert_eq!(found, read(&pieces(data)));
    for payload in found.iter().filter_map(|(_, frame)| frame.as_ref().ok()) {
        let bytes = tq_bus::encode(payload).expect("it came in a frame");
        assert_eq!(read(&[&bytes]), [(0, Ok(payload.clone()))]);
        if let Some(state) = tq_bus::SystemState::decode(payload) {
            assert!(state.battery_voltage_v.is_finite());
        }
    }
    let answer = tq_bus::tiller_answer(500);
    assert!(read(&[data, &answer]).last().is_some_and(|(_, frame)| frame.is_ok()));
}
