//! Random sequences of inputs: the invariants hold.

use super::*;
use crate::command::Drive;
use crate::event::{Medium, PathProgress, Reference, Sighting};
use crate::maneuver::{
    FollowPath, FollowReference, FollowSystem, FollowTrajectory, Late, Launch, Loiter, LoiterShape,
    ScheduledGoto, StationKeeping, TimedOffset,
};
use crate::place::Offset;
use crate::testing::{SPEED, goto, idle, place, progress};
use proptest::prelude::*;

fn maneuver(kind: u8) -> Maneuver<RawPlace> {
    let centre = RawPlace::from(place(30.0, 30.0));
    let duration = (kind.is_multiple_of(2)).then_some(Duration::from_secs(20));
    let offset = |north_m| Offset { north_m, east_m: 0.0 };
    let timed = |time_s| TimedOffset { offset: offset(time_s), time_s };
    match kind {
        0 => idle(5),
        1 => idle(0),
        2 => Maneuver::Launch(Launch { target: centre, speed: SPEED }),
        3 | 4 => Maneuver::StationKeeping(StationKeeping { centre, radius_m: 10.0, speed: SPEED, duration }),
        5 | 6 => {
            let shape = LoiterShape::Eight { length_m: 60.0, bearing_rad: 1.0 };
            Maneuver::Loiter(Loiter { centre, radius_m: 10.0, speed: SPEED, duration, shape })
        }
        7 => Maneuver::FollowPath(FollowPath { origin: centre, points: Vec::new(), speed: SPEED }),
        8 => {
            let points = vec![offset(0.0), offset(20.0)];
            Maneuver::FollowPath(FollowPath { origin: centre, points, speed: SPEED })
        }
        9 => {
            let points = vec![timed(0.0), timed(10.0), timed(25.0)];
            Maneuver::FollowTrajectory(FollowTrajectory { origin: centre, points, speed: SPEED })
        }
        10 | 11 => {
            let late = if kind == 10 { Late::Fail } else { Late::Resume };
            Maneuver::ScheduledGoto(ScheduledGoto { target: centre, arrival: at(40.0).utc, late })
        }
        12 => Maneuver::FollowReference(FollowReference {
            system: None,
            entity: None,
            timeout: Some(Duration::from_secs(10)),
            radius_m: None,
        }),
        13 => Maneuver::FollowSystem(FollowSystem {
            system: 3,
            speed: SPEED,
            ahead_m: 10.0,
            port_m: 20.0,
            duration,
        }),
        14 => teleoperation(),
        _ => goto(50.0, 0.0),
    }
}

fn reference() -> impl Strategy<Value = Reference> {
    let place = || prop::option::of((-99.0..99.0, -99.0..99.0).prop_map(|(n, e)| place(n, e)));
    let speed = prop::option::of(
        prop_oneof![Just(0.0), Just(f64::NAN), -2.0..9.0].prop_map(units::Speed::MetresPerSecond),
    );
    let flags = (any::<bool>(), prop::bool::weighted(0.1));
    (place(), place(), speed, prop::option::of(any::<f64>()), flags).prop_map(
        |(location, start_point, speed, radius_m, (direct, done))| Reference {
            system: 1,
            entity: 1,
            location,
            start_point,
            speed,
            radius_m,
            direct,
            done,
        },
    )
}

fn event() -> impl Strategy<Value = Event> {
    let path = (0..4_u32, any::<bool>(), any::<bool>(), any::<f64>());
    prop_oneof![
        4 => (-60.0..60.0, -60.0..60.0).prop_map(|(north_m, east_m)| Event::Fix(fix(north_m, east_m))),
        // The reference is relative to the latest path, see below.
        4 => path.prop_map(|(age, near, loitering, left_m)| {
            Event::Path(PathProgress { near, loitering, ..progress(age, left_m) })
        }),
        1 => (0..4_u32).prop_map(|path_ref| Event::PathFailed { path_ref, reason: "x".to_owned() }),
        3 => reference().prop_map(Event::Reference),
        2 => (0.0..99.0, 0.0..99.0)
            .prop_map(|(n, e)| Event::Sighting(Sighting { system: 3, place: place(n, e), afloat: true })),
        1 => prop_oneof![Just(Medium::Water), Just(Medium::Ground)].prop_map(Event::Medium),
        1 => (0..3_u16).prop_map(|from| Event::TeleoperationDone { from }),
    ]
}

#[derive(Debug, Clone)]
enum Act {
    Event(Event),
    Start(Vec<u8>, bool, bool),
    BadStart,
    Stop,
    Abort,
    Entities(bool, bool),
    Pass(f64),
}

fn act() -> impl Strategy<Value = Act> {
    prop_oneof![
        8 => event().prop_map(Act::Event),
        2 => (prop::collection::vec(0..16_u8, 1..4), any::<bool>(), any::<bool>())
            .prop_map(|(kinds, calibrate, ignore)| Act::Start(kinds, calibrate, ignore)),
        1 => Just(Act::BadStart),
        1 => Just(Act::Stop),
        1 => Just(Act::Abort),
        2 => (prop::bool::weighted(0.2), prop::bool::weighted(0.1)).prop_map(|(gps, motor)| Act::Entities(gps, motor)),
        4 => (0.0..15.0).prop_map(Act::Pass),
    ]
}

/// A model of what a listener believes, by outputs alone.
#[derive(Default)]
struct Listener {
    run: Option<RunId>,
    maneuver: Option<String>,
    drive: Drive,
    begun: u32,
    ended: u32,
    path_ref: u32,
}

impl Listener {
    fn hear(&mut self, output: &Output) {
        match output {
            Output::PlanBegins { run, .. } => {
                assert_eq!(self.run.replace(*run), None, "one plan at a time");
                self.begun += 1;
            }
            Output::PlanEnded { run, .. } => {
                assert_eq!(self.run.take(), Some(*run), "an end has a beginning");
                assert_eq!(self.maneuver, None, "maneuvers end before their plan");
                self.ended += 1;
            }
            Output::ManeuverBegins { run, id, .. } => {
                assert_eq!(self.run, Some(*run));
                assert_eq!(self.maneuver.replace(id.clone()), None, "one maneuver at a time");
            }
            Output::ManeuverEnded { run, id, .. } => {
                assert_eq!((self.run, self.maneuver.take().as_ref()), (Some(*run), Some(id)));
            }
            Output::Command(command) => {
                if let Command::Follow(path) = command {
                    assert!(path.path_ref > self.path_ref, "path numbers grow");
                    assert!(path.speed.value() > 0.0, "paths have a speed");
                    self.path_ref = path.path_ref;
                }
                if matches!(command, Command::ChangeSpeed(_)) {
                    assert_eq!(self.drive, Drive::Path, "only a path has a speed to change");
                }
                self.drive = command.drive(self.drive);
            }
            _ => {}
        }
    }
}

fn carry_out(bench: &mut Bench, act: Act) {
    match act {
        Act::Event(Event::Path(progress)) => {
            let path_ref = bench.engine.path_ref.saturating_sub(progress.path_ref / 3);
            bench.input(Input::Event(Event::Path(PathProgress { path_ref, ..progress })));
        }
        Act::Event(event) => bench.input(Input::Event(event)),
        Act::Start(kinds, calibrate, ignore_errors) => {
            let maneuvers = kinds.into_iter().map(maneuver).collect();
            bench.start_with("plan", maneuvers, StartOptions { calibrate, ignore_errors });
        }
        Act::BadStart => {
            let options = StartOptions::default();
            bench.ask("bad", RequestKind::Start { plan: Err(NoPlan::Undefined), options });
        }
        Act::Stop => {
            bench.ask("", RequestKind::Stop);
        }
        Act::Abort => bench.input(Input::Abort { by: 7 }),
        Act::Entities(gps, motor) => {
            let bad = [("gps", gps), ("motor", motor)].map(|(label, bad)| {
                (label, if bad { EntityCondition::Error } else { EntityCondition::Normal })
            });
            bench.entities(&bad);
        }
        Act::Pass(seconds) => bench.pass(bench.now_s + seconds),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn every_plan_ends_once_and_loops_go_off_with_it(acts in prop::collection::vec(act(), 0..80)) {
        let mut bench = Bench::new();
        let mut listener = Listener::default();
        for act in acts {
            let stops = matches!(act, Act::Stop | Act::Abort);
            carry_out(&mut bench, act);
            for output in std::mem::take(&mut bench.told) {
                listener.hear(&output);
            }
            let running = bench.engine.running().map(|(run, _)| run);
            prop_assert_eq!(listener.run, running);
            prop_assert_eq!(listener.begun, listener.ended + u32::from(running.is_some()));
            prop_assert_eq!(bench.engine.vehicle_state(at(bench.now_s)).drive, listener.drive);
            if stops {
                prop_assert_eq!(running, None);
            }
            if running.is_none() {
                prop_assert_eq!(listener.drive, Drive::Off);
                prop_assert_eq!(&listener.maneuver, &None);
            }
            let state = bench.engine.plan_state(at(bench.now_s));
            prop_assert!(state.progress.is_none_or(|progress| (0.0..=1.0).contains(&progress)));
            prop_assert!(state.plan_eta_s.is_none_or(|eta_s| eta_s.is_finite() && eta_s >= 0.0));
        }
    }
}
