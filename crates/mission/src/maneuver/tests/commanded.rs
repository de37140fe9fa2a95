//! Maneuvers that follow a clock, a commander or another system.

use super::{Bench, path};
use crate::command::{Command, PathStart};
use crate::event::{Event, Reference, Sighting, Way};
use crate::maneuver::{
    FailReason, FollowReference, FollowSystem, Late, Maneuver, Outcome, ReferencePhase, ScheduledGoto,
    Signal, distance_m,
};
use crate::testing::{SPEED, at, fix, frame, place};
use guard::Area;
use guard::Waters;
use std::time::Duration;
use units::Speed;

fn scheduled(arrival_s: f64, late: Late) -> Bench {
    let target = place(100.0, 0.0).into();
    let mut bench =
        Bench::new(Maneuver::ScheduledGoto(ScheduledGoto { target, arrival: at(arrival_s).utc, late }));
    bench.fix = Some(fix(0.0, 0.0));
    bench
}

#[test]
fn scheduled_goto_starts_when_it_needs_its_least_speed() {
    let mut bench = scheduled(200.0, Late::Fail);
    assert_eq!(bench.start(), [Command::Drift]);
    assert_eq!(bench.pass(56.0), []);
    let commands = bench.pass(60.0);
    let Some(Command::Follow(path)) = commands.first() else { panic!("{commands:?}") };
    let Speed::MetresPerSecond(mps) = path.speed else { panic!("not m/s") };
    assert!((0.7..0.73).contains(&mps), "{mps}");
    bench.fix = Some(fix(40.0, 0.0));
    let commands = bench.pass(130.0);
    assert!(matches!(commands.last(), Some(Command::ChangeSpeed(_))), "{commands:?}");
    assert_eq!(bench.near(), [Command::Drift], "early");
    bench.fix = Some(fix(99.0, 0.0));
    bench.pass(199.0);
    assert!(!bench.is_done());
    bench.pass(202.0);
    assert!(bench.is_done());
}

#[test]
fn scheduled_goto_goes_on_skips_or_fails_when_late() {
    let cases = [
        (Late::Resume, None),
        (Late::Skip, Some(Outcome::Done)),
        (Late::Fail, Some(Outcome::Failed(FailReason::Late))),
    ];
    for (late, outcome) in cases {
        let mut bench = scheduled(50.0, late);
        bench.start();
        bench.pass(52.0);
        assert_eq!(bench.outcome, outcome);
        if late == Late::Resume {
            assert_eq!(bench.near(), []);
            assert!(bench.is_done());
        }
    }
}

fn reference(north_m: f64) -> Reference {
    Reference {
        system: 0x4001,
        entity: 1,
        location: Some(place(north_m, 0.0)),
        start_point: None,
        speed: Some(SPEED),
        radius_m: Some(5.0),
        direct: false,
        done: false,
    }
}

fn following() -> Bench {
    let timeout = Some(Duration::from_secs(10));
    let follow = FollowReference { system: Some(0x4001), entity: None, timeout, radius_m: None };
    let mut bench = Bench::new(Maneuver::FollowReference(follow));
    bench.fix = Some(fix(0.0, 0.0));
    assert_eq!(bench.start(), [Command::Drift]);
    assert_eq!(phase(&bench), Some(ReferencePhase::Wait));
    bench
}

fn phase(bench: &Bench) -> Option<ReferencePhase> {
    bench.signals.iter().rev().find_map(|signal| match signal {
        Signal::Reference(state) => Some(state.phase),
        Signal::Command(_) | Signal::Way(..) | Signal::Warning(_) => None,
    })
}

#[test]
fn follow_reference_goes_hovers_and_goes_again() {
    let mut bench = following();
    let out = path(&bench.event(&Event::Reference(reference(100.0))));
    assert_eq!((out.start, out.speed), (PathStart::Here, SPEED));
    assert_eq!(bench.event(&Event::Reference(reference(100.0))), [], "the same again changes nothing");
    assert_eq!(bench.near(), [Command::Drift]);
    assert_eq!(phase(&bench), Some(ReferencePhase::Hover));
    assert_eq!(bench.fix(fix(66.0, 0.0)), [], "within radius and tolerance");
    path(&bench.fix(fix(64.0, 0.0)));
    assert_eq!(phase(&bench), Some(ReferencePhase::Goto));
    let faster = Reference { speed: Some(Speed::MetresPerSecond(2.0)), ..reference(100.0) };
    assert_eq!(bench.event(&Event::Reference(faster)), [Command::ChangeSpeed(Speed::MetresPerSecond(2.0))]);
    path(&bench.event(&Event::Reference(reference(200.0))));
}

#[test]
fn follow_reference_stops_at_speed_zero_and_ends_when_told() {
    let mut bench = following();
    path(&bench.event(&Event::Reference(reference(100.0))));
    let stop = Reference { speed: Some(Speed::MetresPerSecond(0.0)), ..reference(100.0) };
    assert_eq!(bench.event(&Event::Reference(stop)), [Command::Drift]);
    assert_eq!(bench.fix(fix(0.0, 0.0)), [], "it stays stopped");
    path(&bench.event(&Event::Reference(reference(100.0))));
    bench.event(&Event::Reference(Reference { done: true, ..reference(100.0) }));
    assert!(bench.is_done());
}

#[test]
fn follow_reference_obeys_its_commander_only_and_times_out() {
    let mut bench = following();
    let stranger = Reference { system: 0x4002, ..reference(100.0) };
    bench.now_s = 9.0;
    assert_eq!(bench.event(&Event::Reference(stranger)), []);
    bench.event(&Event::Reference(reference(100.0)));
    bench.pass(18.9);
    assert_eq!(bench.outcome, None);
    bench.pass(19.0);
    assert_eq!(bench.outcome, Some(Outcome::Failed(FailReason::ReferenceTimeout)));
    assert_eq!(phase(&bench), Some(ReferencePhase::Timeout));
}

#[test]
fn follow_reference_fills_in_what_is_absent() {
    let mut bench = following();
    let bare = Reference { location: None, speed: None, radius_m: None, ..reference(0.0) };
    let here = path(&bench.event(&Event::Reference(bare)));
    assert!(distance_m(here.end, place(0.0, 0.0)) < 1e-6, "stay here");
    assert_eq!(here.speed, Speed::Percent(50.0));
    let start = Some(place(50.0, 50.0));
    let track = Reference { start_point: start, ..reference(100.0) };
    assert_eq!(path(&bench.event(&Event::Reference(track))).start, PathStart::At(place(50.0, 50.0)));
    let further = path(&bench.event(&Event::Reference(reference(150.0))));
    assert_eq!(further.start, PathStart::At(place(50.0, 50.0)), "the start is kept");
    let direct = Reference { direct: true, ..reference(150.0) };
    assert_eq!(path(&bench.event(&Event::Reference(direct))).start, PathStart::Here);
}

#[test]
fn follow_reference_tames_speeds() {
    for (asked, given) in [
        (Speed::MetresPerSecond(50.0), Speed::MetresPerSecond(3.09)),
        (Speed::MetresPerSecond(f64::NAN), Speed::Percent(50.0)),
        (Speed::MetresPerSecond(-1.0), Speed::Percent(50.0)),
    ] {
        let mut bench = following();
        let wild = Reference { speed: Some(asked), ..reference(100.0) };
        assert_eq!(path(&bench.event(&Event::Reference(wild))).speed, given);
    }
}

fn sighting(north_m: f64, east_m: f64) -> Event {
    Event::Sighting(Sighting { system: 0x2811, place: place(north_m, east_m), afloat: true })
}

fn beside(duration: Option<Duration>) -> Bench {
    let follow = FollowSystem { system: 0x2811, speed: SPEED, ahead_m: -20.0, port_m: 30.0, duration };
    let mut bench = Bench::new(Maneuver::FollowSystem(follow));
    bench.fix = Some(fix(0.0, 0.0));
    assert_eq!(bench.start(), [Command::Drift]);
    bench
}

#[test]
fn follow_system_keeps_its_slot_beside_the_other() {
    let mut bench = beside(None);
    path(&bench.event(&sighting(100.0, 0.0)));
    // The other goes east: 20 m behind it is west, 30 m to port is north.
    let slot = frame().to_local(path(&bench.event(&sighting(100.0, 10.0))).end);
    assert!((slot.north_m - 130.0).abs() < 0.1 && (slot.east_m + 10.0).abs() < 0.1, "{slot:?}");
    assert_eq!(bench.fix(fix(50.0, 0.0)), [], "on the way");
    assert_eq!(bench.near(), [Command::Drift]);
    assert_eq!(bench.fix(fix(130.0, -5.0)), [], "close enough");
    path(&bench.fix(fix(130.0, -30.0)));
    assert_eq!(bench.fix(fix(100.0, 0.0)), [Command::Drift], "too close to the other");
}

#[test]
fn follow_system_ends_by_time_or_by_silence() {
    let mut bench = beside(Some(Duration::from_secs(50)));
    bench.pass(50.0);
    assert!(bench.is_done());
    let mut bench = beside(None);
    bench.now_s = 30.0;
    bench.event(&sighting(100.0, 0.0));
    bench.pass(89.9);
    assert_eq!(bench.outcome, None);
    bench.pass(90.0);
    assert_eq!(bench.outcome, Some(Outcome::Failed(FailReason::SystemSilent(0x2811))));
}

#[test]
fn follow_reference_hovers_while_another_vessel_is_close() {
    let mut bench = following();
    bench.config.reference.separation_m = 15.0;
    bench.event(&Event::Reference(reference(100.0)));
    let console = Sighting { system: 0x4002, place: place(5.0, 0.0), afloat: false };
    bench.event(&Event::Sighting(console));
    assert_eq!(bench.fix(fix(5.0, 0.0)), [], "consoles ashore are in nobody's way");
    bench.event(&sighting(30.0, 0.0));
    assert_eq!(bench.fix(fix(10.0, 0.0)), []);
    assert_eq!(bench.fix(fix(16.0, 0.0)), [Command::Drift]);
    assert_eq!(phase(&bench), Some(ReferencePhase::Hover));
    bench.now_s = 5.0;
    assert_eq!(bench.event(&Event::Reference(reference(200.0))), [], "also a new goal waits");
    bench.event(&sighting(60.0, 0.0));
    path(&bench.fix(fix(16.0, 0.0)));
    bench.event(&sighting(20.0, 0.0));
    assert_eq!(bench.fix(fix(16.0, 0.0)), [Command::Drift]);
    bench.now_s = 35.0;
    assert_eq!(bench.fix(fix(16.0, 0.0)), []);
    bench.now_s = 35.1;
    path(&bench.fix(fix(16.0, 0.0)));
    // Without a separation no vessel is too close.
    bench.config.reference.separation_m = 0.0;
    bench.event(&sighting(16.0, 0.0));
    assert_eq!(bench.fix(fix(16.0, 0.0)), []);
}

/// 100 m to all sides of the middle.
fn square() -> Waters {
    let corners = [(-100.0, -100.0), (100.0, -100.0), (100.0, 100.0), (-100.0, 100.0)];
    let area = Some(Area::new(&corners.map(|(n, e)| place(n, e))).unwrap());
    Waters { area, ..Waters::default() }
}

fn warnings(bench: &Bench) -> usize {
    bench.signals.iter().filter(|signal| matches!(signal, Signal::Warning(_))).count()
}

#[test]
fn a_reference_outside_the_area_is_refused_and_the_one_before_goes_on() {
    let mut bench = following();
    bench.waters = square();
    assert_eq!(path(&bench.event(&Event::Reference(reference(80.0)))).end, place(80.0, 0.0));
    assert_eq!(bench.event(&Event::Reference(reference(130.0))), [], "it keeps its way");
    assert_eq!((phase(&bench), warnings(&bench)), (Some(ReferencePhase::Goto), 1));
    assert_eq!(bench.event(&Event::Reference(reference(130.0))), []);
    assert_eq!(warnings(&bench), 0, "the same is told once");
    // Its commander is alive all the same.
    bench.pass(9.0);
    bench.event(&Event::Reference(reference(130.0)));
    bench.pass(18.0);
    assert_eq!(bench.outcome, None);
    assert_eq!(path(&bench.event(&Event::Reference(reference(90.0)))).end, place(90.0, 0.0));
}

/// A bay reaches from the east into the square, between 20 m and 60 m north.
fn bay() -> Waters {
    let corners = [
        (-100.0, -100.0),
        (-100.0, 100.0),
        (20.0, 100.0),
        (40.0, 10.0),
        (60.0, 100.0),
        (100.0, 100.0),
        (100.0, -100.0),
    ];
    let area = Some(Area::new(&corners.map(|(n, e)| place(n, e))).unwrap());
    Waters { area, ..Waters::default() }
}

#[test]
fn a_reference_that_stops_or_slows_down_is_obeyed_where_the_way_would_be_refused() {
    let mut bench = following();
    bench.waters = bay();
    path(&bench.event(&Event::Reference(reference(80.0))));
    // A stream sets the vessel east: the straight way now leads over the bay.
    bench.fix(fix(0.0, 30.0));
    let only =
        |speed| Reference { location: None, speed: Some(Speed::MetresPerSecond(speed)), ..reference(0.0) };
    let slower = bench.event(&Event::Reference(only(0.5)));
    assert_eq!(slower, [Command::ChangeSpeed(Speed::MetresPerSecond(0.5))]);
    assert_eq!(bench.event(&Event::Reference(only(0.0))), [Command::Drift]);
    assert_eq!(phase(&bench), Some(ReferencePhase::Hover));
    // Continuing from here is another matter.
    assert_eq!(bench.event(&Event::Reference(only(1.0))), []);
    assert_eq!((phase(&bench), warnings(&bench)), (Some(ReferencePhase::Hover), 1));
}

#[test]
fn a_reference_without_a_position_is_judged_once_there_is_one() {
    let mut bench = following();
    bench.waters = bay();
    bench.fix = None;
    assert_eq!(bench.event(&Event::Reference(reference(130.0))), []);
    assert_eq!(warnings(&bench), 1, "outside is outside from wherever it comes");
    bench.event(&Event::Reference(reference(80.0)));
    assert_eq!(phase(&bench), Some(ReferencePhase::Hover), "it waits for a position");
    assert_eq!(bench.fix(fix(0.0, 60.0)), []);
    assert_eq!(warnings(&bench), 1, "the way from here leads over the bay");
    bench.now_s = 5.0;
    assert_eq!(path(&bench.fix(fix(0.0, -20.0))).end, place(80.0, 0.0));
}

#[test]
fn a_system_that_leaves_the_area_is_waited_for_inside() {
    let follow = FollowSystem { system: 0x2811, speed: SPEED, ahead_m: 0.0, port_m: 0.0, duration: None };
    let mut bench = Bench::new(Maneuver::FollowSystem(follow));
    bench.waters = square();
    bench.fix = Some(fix(0.0, 0.0));
    bench.start();
    let seen = |bench: &mut Bench, north_m: f64| {
        bench.event(&Event::Sighting(Sighting { system: 0x2811, place: place(north_m, 0.0), afloat: true }))
    };
    assert_eq!(path(&seen(&mut bench, 60.0)).end, place(60.0, 0.0));
    bench.fix = Some(fix(40.0, 0.0));
    assert_eq!(seen(&mut bench, 140.0), [Command::Drift], "it does not go there");
    assert_eq!(warnings(&bench), 1);
    // Carried away it comes back to where it waits, and not to the other.
    bench.fix = Some(fix(40.0, 30.0));
    let commands = bench.event(&Event::Fix(fix(40.0, 30.0)));
    assert_eq!(path(&commands).end, place(40.0, 0.0));
    assert_eq!(path(&seen(&mut bench, 90.0)).end, place(90.0, 0.0), "the other is back");
}

/// Following in the square with the bay, south of which the vessel lies; ways around are searched for.
fn beside_the_bay() -> Bench {
    let mut bench = following();
    bench.config.reference.routes_around = true;
    bench.waters = bay();
    bench.fix(fix(0.0, 60.0));
    bench
}

/// To the place behind the bay.
fn behind() -> Event {
    Event::Reference(Reference { location: Some(place(80.0, 60.0)), ..reference(0.0) })
}

fn way(corners: &[(f64, f64)]) -> Event {
    let places = corners.iter().map(|(north_m, east_m)| place(*north_m, *east_m)).collect();
    Event::Way(Way { to: place(80.0, 60.0), places: Ok(places) })
}

fn asks(bench: &Bench) -> bool {
    bench.signals.iter().any(|signal| matches!(signal, Signal::Way(..)))
}

#[test]
fn a_reference_behind_the_border_is_followed_corner_by_corner() {
    let mut bench = beside_the_bay();
    assert_eq!(bench.event(&behind()), []);
    assert!(asks(&bench) && warnings(&bench) == 1);
    assert_eq!(bench.event(&behind()), []);
    assert!(!asks(&bench) && warnings(&bench) == 0, "it is asked for once");
    let around = way(&[(0.0, 60.0), (40.0, -10.0), (80.0, 60.0)]);
    assert_eq!(path(&bench.event(&around)).end, place(40.0, -10.0));
    assert_eq!(phase(&bench), Some(ReferencePhase::Goto));
    assert_eq!(bench.event(&behind()), [], "the same again changes nothing");
    bench.fix = Some(fix(40.0, -10.0));
    assert_eq!(path(&bench.near()).end, place(80.0, 60.0));
    assert_eq!(bench.near(), [Command::Drift]);
    assert_eq!(phase(&bench), Some(ReferencePhase::Hover));
}

/// It was carried past the border while it stood: its place is in sight, and the corner of the way around is not.
#[test]
fn a_corner_that_is_refused_from_where_the_vessel_is_is_not_gone_to() {
    let mut bench = beside_the_bay();
    bench.event(&behind());
    let around = way(&[(0.0, 60.0), (0.0, -10.0), (40.0, -10.0), (80.0, 60.0)]);
    assert_eq!(path(&bench.event(&around)).end, place(0.0, -10.0));
    let stop = Reference { speed: Some(Speed::MetresPerSecond(0.0)), ..reference(0.0) };
    assert_eq!(bench.event(&Event::Reference(stop)), [Command::Drift]);
    bench.fix = Some(fix(75.0, 40.0));
    assert_eq!(path(&bench.event(&behind())).end, place(80.0, 60.0));
}

#[test]
fn a_way_that_is_not_wanted_any_more_or_leads_elsewhere_is_not_followed() {
    let around = way(&[(0.0, 60.0), (40.0, -10.0), (80.0, 60.0)]);
    let mut bench = beside_the_bay();
    assert_eq!(bench.event(&around), [], "nobody asked");
    bench.event(&behind());
    // It stops meanwhile, or goes elsewhere.
    let stop = Reference { speed: Some(Speed::MetresPerSecond(0.0)), ..reference(0.0) };
    bench.event(&Event::Reference(stop));
    assert_eq!(bench.event(&around), []);
    let refused = [way(&[(0.0, 60.0), (80.0, 60.0)]), way(&[(0.0, 60.0), (0.0, 0.0)]), way(&[])];
    for answer in refused {
        let mut bench = beside_the_bay();
        bench.event(&behind());
        assert_eq!(bench.event(&answer), []);
        assert_eq!((phase(&bench), warnings(&bench)), (Some(ReferencePhase::Wait), 1));
        bench.event(&behind());
        assert!(!asks(&bench), "not at once again");
        bench.now_s = 61.0;
        bench.event(&behind());
        assert!(asks(&bench));
    }
}

/// A place behind the bay, some metres on.
fn moved(north_m: f64) -> Event {
    Event::Reference(Reference { location: Some(place(north_m, 60.0)), ..reference(0.0) })
}

/// The corner is at (40, -10), and each answer comes two references late.
#[test]
fn a_place_that_moves_behind_the_border_is_followed_by_one_way_and_told_of_once() {
    let mut bench = beside_the_bay();
    let (mut asked, mut warned) = (0, 0);
    let mut ends = Vec::new();
    for second in 0..20 {
        bench.now_s = f64::from(second);
        let north_m = 80.0 + 0.5 * f64::from(second);
        ends.extend(bench.event(&moved(north_m)));
        (asked, warned) = (asked + usize::from(asks(&bench)), warned + warnings(&bench));
        if second == 2 {
            ends.extend(bench.event(&way(&[(0.0, 60.0), (40.0, -10.0), (80.0, 60.0)])));
            warned += warnings(&bench);
        }
    }
    assert_eq!((asked, warned), (1, 2), "looked for once and found once");
    let ends: Vec<_> = ends.iter().map(|command| path(std::slice::from_ref(command)).end).collect();
    assert_eq!(ends, [place(40.0, -10.0)], "its track is not begun anew");
    bench.fix = Some(fix(40.0, -10.0));
    assert_eq!(path(&bench.near()).end, place(89.5, 60.0), "it leads to where the place is by then");
}

#[test]
fn places_that_alternate_behind_the_border_do_not_keep_the_vessel_from_sailing() {
    let mut bench = beside_the_bay();
    let (mut asked, mut warned, mut sailed) = (0, 0, 0);
    let mut answers = std::collections::VecDeque::new();
    for second in 0..60 {
        bench.now_s = f64::from(second);
        let goal = if second % 2 == 0 { place(80.0, 60.0) } else { place(-20.0, -500.0) };
        let to = Reference { location: Some(goal), ..reference(0.0) };
        let far = Reference { location: Some(place(80.0, 0.0)), ..to };
        sailed += bench.event(&Event::Reference(if second % 2 == 0 { to } else { far })).len();
        warned += warnings(&bench);
        let to = bench.signals.iter().find_map(|signal| match signal {
            Signal::Way(_, to) => Some(*to),
            Signal::Command(_) | Signal::Reference(_) | Signal::Warning(_) => None,
        });
        if let Some(to) = to {
            asked += 1;
            answers.push_back((second + 1, to));
        }
        if let Some((_, to)) = answers.pop_front_if(|(due, _)| *due <= second) {
            let places = Ok(vec![place(0.0, 60.0), place(40.0, -10.0), to]);
            sailed += bench.event(&Event::Way(Way { to, places })).len();
            warned += warnings(&bench);
        }
    }
    assert!(sailed > 0, "it sails");
    assert!(asked <= 12, "asked {asked} times in a minute");
    assert!(warned <= 4, "told {warned} times");
}

#[test]
fn a_place_that_is_given_up_before_a_way_is_found_is_told() {
    let around = way(&[(0.0, 60.0), (40.0, -10.0), (80.0, 60.0)]);
    let mut bench = beside_the_bay();
    bench.event(&behind());
    assert_eq!(bench.event(&Event::CommanderChanged), []);
    assert_eq!(warnings(&bench), 1, "control has changed hands");
    assert_eq!(bench.event(&around), [], "the answer is dropped");
    bench.now_s = 6.0;
    bench.event(&behind());
    let stop = Reference { location: None, speed: Some(Speed::MetresPerSecond(0.0)), ..reference(0.0) };
    bench.event(&Event::Reference(stop));
    assert_eq!(warnings(&bench), 1, "a stop took its place");
    bench.event(&behind());
    bench.event(&Event::Reference(Reference { done: true, ..stop }));
    assert_eq!(warnings(&bench), 1, "the maneuver is over");
}
