//! What must hold for any bytes that claim to be a message of the vessel link. The fuzz target calls this with
//! bytes of its own making, and `make test` with the committed seeds and everything that was ever found.

use bytes::Bytes;
use link::frame::{self, Frame, Welcome};
use link::{
    Capabilities, ChartAboard, ChartOffer, ConnectionId, MAX_BATCH_RAW_BYTES, Shore, ShoreInput, ShoreOutput,
    ShoreSettings, SpoolState, Vessel, VesselInput, VesselOutput, VesselSettings, WaySettings, unpack,
};

const ONE: ConnectionId = ConnectionId(1);

/// Every frame returns from its own bytes, what unpacks is within its bound, and both ends of a link take the
/// message at any stage without harm.
pub(crate) fn message(data: &[u8]) {
    let bytes = Bytes::copy_from_slice(data);
    if let Ok(frames) = frame::decode(bytes.clone()) {
        for one in frames.map_while(Result::ok) {
            let again: Vec<_> = frame::decode(frame::message(&one)).expect("short").collect();
            assert_eq!(again, [Ok(one.clone())]);
            if let Frame::Records(batch) | Frame::Live(batch) = &one
                && let Ok(records) = unpack(batch)
            {
                assert_eq!(records.len(), batch.count as usize);
                let bytes: usize = records.iter().map(|record| record.packet.len()).sum();
                assert!(bytes <= MAX_BATCH_RAW_BYTES);
            }
        }
    }
    for (welcomed, several) in [(false, false), (false, true), (true, false), (true, true)] {
        to_vessel(&bytes, welcomed, several);
        to_shore(&bytes, welcomed, several);
    }
}

fn vessel(several: bool) -> Vessel {
    let ways = ["4g", "radio"].map(|name| WaySettings { name: name.to_owned(), ..WaySettings::default() });
    let ways = if several { ways.to_vec() } else { Vec::new() };
    let settings = VesselSettings {
        address: 0x2810,
        name: "fuzzed".to_owned(),
        software: String::new(),
        incarnation: 1,
        seed: 1,
        budget_bytes_per_s: None,
        spool: SpoolState { stream: 7, first: 0, next: 1 << 40 },
        ways,
    };
    let mut vessel = Vessel::new(units::Now::default(), settings);
    vessel.handle(units::Now::default(), VesselInput::Timer);
    vessel.handle(units::Now::default(), VesselInput::Opened(ONE));
    vessel
}

/// A chart of the shore's.
fn offer() -> ChartOffer {
    let mut digest = [0; 32];
    digest.iter_mut().zip(0..).for_each(|(byte, value)| *byte = value);
    ChartOffer { digest, bytes: 5000, edition: String::new() }
}

fn to_vessel(bytes: &Bytes, welcomed: bool, several: bool) {
    let mut vessel = vessel(several);
    if welcomed {
        let welcome = Welcome {
            version: frame::VERSION,
            capabilities: Capabilities::ALL,
            resume: 5,
            window_bytes: 1 << 20,
            stamp: frame::Stamp::default(),
            run: several.then_some(9),
        };
        let message = frame::message(&Frame::Welcome(welcome));
        vessel.handle(units::Now::default(), VesselInput::Message(ONE, message));
        let aboard = ChartAboard { takes: true, ..ChartAboard::default() };
        vessel.handle(units::Now::default(), VesselInput::ChartAboard(aboard));
        vessel
            .handle(units::Now::default(), VesselInput::Message(ONE, frame::message(&Frame::Chart(offer()))));
        vessel.handle(units::Now::default(), VesselInput::ChartGoOn(offer().digest, 4096));
    }
    vessel.handle(units::Now::default(), VesselInput::Message(ONE, bytes.clone()));
    vessel.poll_timeout(units::Now::default());
    vessel.status(units::Now::default());
    while let Some(output) = vessel.poll_output() {
        if let VesselOutput::ChartPart { digest, offset, bytes } = output {
            assert_eq!((digest, offset), (offer().digest, 4096), "only what was asked for");
            assert!(offset + bytes.len() as u64 <= offer().bytes);
        }
    }
}

fn to_shore(bytes: &Bytes, welcomed: bool, several: bool) {
    let mut shore = Shore::new(ShoreSettings::default());
    shore.handle(units::Now::default(), ShoreInput::Opened(ONE));
    if welcomed {
        let mut vessel = vessel(several);
        while let Some(output) = vessel.poll_output() {
            if let VesselOutput::Send(_, bytes) = output {
                shore.handle(units::Now::default(), ShoreInput::Message(ONE, bytes));
            }
        }
        shore.handle(units::Now::default(), ShoreInput::Resume(ONE, None));
        shore.handle(units::Now::default(), ShoreInput::Chart(Some(offer())));
    }
    shore.handle(units::Now::default(), ShoreInput::Message(ONE, bytes.clone()));
    shore.poll_timeout(units::Now::default());
    shore.status(units::Now::default());
    let mut expected = 0;
    while let Some(output) = shore.poll_output() {
        match output {
            ShoreOutput::Records { records, .. } => {
                for record in records {
                    assert_eq!(record.seq, expected, "records are given in order and once");
                    expected += 1;
                }
            }
            ShoreOutput::Gap { gap, .. } => {
                assert_eq!(gap.from, expected);
                expected = gap.to;
            }
            ShoreOutput::ChartPart(_, ask) => {
                assert_eq!(ask.digest, offer().digest);
                assert!(ask.offset + u64::from(ask.length) <= offer().bytes, "only what there is");
            }
            _ => {}
        }
    }
}
