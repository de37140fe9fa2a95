//! Equal inputs give equal outputs, to the last bit.

use crate::common::*;
use imc::messages::*;
use onboard::Brain;
use onboard::record::{read_input, write_input, write_output};
use units::{MonoTime, Now};
use vehicle::BrainEvent;

type Recorded = Vec<(bool, Vec<u8>)>;

/// An hour of plans with noise, recorded: inputs (true) and outputs (false).
fn hour() -> (Recorded, Now) {
    let mut sea = Sea::with(settings(), |vessel| {
        vessel.gnss = sim::GnssConfig { baud: 115_200, ..sim::GnssConfig::default() }
    });
    let begun = Now { mono: MonoTime::default(), utc: start() };
    let mut all = Vec::new();
    let mut sink = |now: Now, event: BrainEvent<'_>| {
        let mut bytes = Vec::new();
        match &event {
            BrainEvent::Input(input) => {
                write_input(&mut bytes, now, input);
                all.push((true, bytes));
            }
            BrainEvent::Output(output) => {
                write_output(&mut bytes, output);
                all.push((false, bytes));
            }
        }
    };
    let start_plan = |seconds: u64| {
        let request = PlanControl {
            r#type: PlanControlType::Request,
            op: PlanControlOp::Start,
            plan_id: "triangle".into(),
            arg: triangle().into(),
            request_id: seconds as u16,
            ..PlanControl::default()
        };
        let header = imc::Header { src: CONSOLE, dst: OTTER, ..imc::Header::default() };
        onboard::Input::Packet(PEER, imc::Packet::new(header, request).encode().unwrap())
    };
    for seconds in (10..=3600).step_by(10) {
        let until = MonoTime::from_micros(seconds * 1_000_000);
        while sea.vehicle.now.mono < until {
            sea.vehicle.advance(until, &mut sink);
        }
        if seconds % 300 == 20 {
            sea.vehicle.tell(start_plan(seconds), &mut sink);
        }
    }
    (all, begun)
}

#[test]
fn two_hours_alike_and_their_replay_give_identical_bytes() {
    let (first, begun) = hour();
    let (second, _) = hour();
    assert!(first == second, "two simulations of an hour differ");
    assert!(first.len() > 100_000, "{}", first.len());

    let mut brain = Brain::new(settings(), begun, mission::Kept::default()).unwrap();
    // The connection that the harness makes before recording.
    brain.handle(begun, onboard::Input::Connected(PEER));
    while brain.poll_output().is_some() {}
    let mut outputs = Vec::new().into_iter();
    for (is_input, bytes) in &first {
        if *is_input {
            assert_eq!(outputs.next(), None, "an output that was not recorded");
            let (now, input) = read_input(bytes).unwrap();
            brain.handle(now, input);
            let mut got = Vec::new();
            while let Some(output) = brain.poll_output() {
                let mut bytes = Vec::new();
                write_output(&mut bytes, &output);
                got.push(bytes);
            }
            outputs = got.into_iter();
        } else {
            assert_eq!(outputs.next().as_ref(), Some(bytes), "a replayed output differs");
        }
    }
}
