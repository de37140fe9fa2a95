//! A vessel with several ways in a bad world: whichever dies, the reader ashore has each value once, in order and in time.

use crate::world::chance::Chance;
use crate::world::network::Path;
use crate::world::{Event, Fault, SECOND, World};
use link::{Outcome, Thinning, WaySettings, WayState, Why};
use proptest::prelude::*;
use testkit::so_many;

const MINUTE: u64 = 60 * SECOND;
const HOUR: u64 = 60 * MINUTE;
const RADIO: usize = 0;
const MOBILE: usize = 1;

fn way(name: &str, metered: bool, daily_bytes: Option<u64>) -> WaySettings {
    WaySettings { name: name.to_owned(), metered, daily_bytes, ..WaySettings::default() }
}

fn path(delay_us: u64, bytes_per_s: u64) -> Path {
    let mut path = Path::default();
    (path.delay_us, path.bytes_per_s) = (delay_us, bytes_per_s);
    path
}

/// A radio that is fast and free, and 4G that is neither. A packet each 50 ms, a command each second.
fn world(seed: u64, daily_bytes: Option<u64>) -> World {
    World::new(seed, SECOND / 20, None).with_ways(ways(daily_bytes), paths()).with_commands(SECOND)
}

fn ways(daily_bytes: Option<u64>) -> Vec<WaySettings> {
    vec![way("radio", false, None), way("4g", true, daily_bytes)]
}

fn paths() -> Vec<Path> {
    vec![path(3_000, 500_000), path(40_000, 120_000)]
}

fn complete(mut world: World) -> World {
    world.stop_saying();
    world.run_to(10 * MINUTE, "complete", |world| world.missing() == 0);
    world.check_everything_arrived();
    world.check_commands();
    world
}

/// One way after the other is cut without a close, at random moments, and comes back.
#[test]
fn values_pause_for_less_than_two_seconds_in_each_of_many_cuts() {
    let (mut longest, mut overtaken) = (0, 0);
    let seeds = so_many(3, 30);
    for seed in 1..=seeds {
        let (mut world, mut chance) = (world(seed, None), Chance::new(seed));
        world.run(30 * SECOND);
        (world.shore.longest_gap_us, world.shore.overtaken) = (0, 0);
        for cut in 0..20 {
            world.at(0, Event::Fault(Fault::CutWay(cut % 2, chance.between(SECOND, 12 * SECOND))));
            world.run(chance.between(15 * SECOND, 25 * SECOND));
        }
        let took = world.shore.longest_gap_us;
        assert!(took <= 2 * SECOND, "seed {seed}: no value for {took} us");
        overtaken += world.shore.overtaken;
        longest = longest.max(took);
        let failovers = world.vessel.switches.iter().filter(|(_, now)| now.live_why == Why::Failover).count();
        assert!(failovers >= 10, "seed {seed}: {failovers}");
        let world = complete(world);
        let said = world.vessel.delivered.len() as u64;
        assert!(said * 10 > world.shore.commands * 9, "{said} of {} commands", world.shore.commands);
    }
    println!(
        "no value for {longest} us at most; {overtaken} records came after a newer live value in {} cuts",
        seeds * 20
    );
    // Where a way is given up only after a second, records have lagged by then, and the newest values went before them.
    assert!(overtaken <= seeds * 20 / 100);
}

#[test]
fn each_lane_goes_by_its_way_and_the_shore_hears_which() {
    let mut world = world(7, None);
    world.run(MINUTE);
    let report = world.shore.ways.clone().unwrap();
    assert_eq!((report.live, report.records), (Some(RADIO as u8), Some(RADIO as u8)));
    let told: Vec<(&str, bool, WayState)> =
        report.ways.iter().map(|way| (&way.name[..], way.metered, way.state)).collect();
    assert_eq!(told, [("radio", false, WayState::Up), ("4g", true, WayState::Up)]);
    assert!((6_000..20_000).contains(&report.ways[RADIO].round_trip_us), "{report:?}");
    assert!((80_000..140_000).contains(&report.ways[MOBILE].round_trip_us), "{report:?}");
    // A radio at the end of its reach: live values take 4G, records stay where they cost nothing.
    world.at(0, Event::Fault(Fault::Delay(RADIO, 150_000)));
    world.run(MINUTE);
    let report = world.shore.ways.clone().unwrap();
    assert_eq!((report.live, report.live_why), (Some(MOBILE as u8), Why::Better), "{report:?}");
    assert_eq!(report.records, Some(RADIO as u8));
    complete(world);
}

#[test]
fn a_program_that_stalls_blames_no_way() {
    let mut chance = Chance::new(31);
    let mut world = world(31, None);
    world.run(MINUTE);
    let before = world.vessel.switches.len();
    let stall = |world: &mut World, chance: &mut Chance, least_us, most_us| {
        world.at(chance.below(SECOND), Event::Fault(Fault::Stall(chance.between(least_us, most_us))));
        world.run(chance.between(10 * SECOND, 20 * SECOND));
        let report = world.shore.ways.clone().unwrap();
        (report.ways.iter().map(|way| way.failures).sum::<u32>(), report.ways[RADIO].late_per_mille)
    };
    for _ in 0..so_many(30, 300) {
        assert_eq!(stall(&mut world, &mut chance, SECOND / 2, 2 * SECOND), (0, 0));
    }
    assert_eq!(world.vessel.switches.len(), before);
    // The shore gives a way up that is silent for longer than 3 s: one that is blamed all the same would be waited for.
    for _ in 0..6 {
        assert_eq!(stall(&mut world, &mut chance, 3 * SECOND, 9 * SECOND).0, 0);
    }
    complete(world);
}

#[test]
fn a_program_that_is_always_late_still_leaves_a_way_that_died() {
    let mut world = World::new(32, 3 * SECOND, None).with_ways(ways(None), paths());
    world.vessel.late_us = 350_000;
    world.run(MINUTE);
    world.at(0, Event::Fault(Fault::CutWay(RADIO, 30 * SECOND)));
    world.run(10 * SECOND);
    let (_, last) = world.vessel.switches.last().unwrap();
    assert_eq!((last.live, last.live_why), (Some(MOBILE as u8), Why::Failover));
    complete(world);
}

/// The receipt of a command is answered at once like all else, though no beat falls due.
#[test]
fn commands_between_the_beats_make_no_way_suspect() {
    for say_every_us in [SECOND / 20, 3 * SECOND] {
        let world = World::new(12, say_every_us, None).with_ways(ways(None), paths());
        let mut world = world.with_commands(7_370_000);
        world.at(0, Event::Fault(Fault::Delay(RADIO, 150_000)));
        world.run(MINUTE);
        let report = world.shore.ways.clone().unwrap();
        assert_eq!((report.live, report.records), (Some(MOBILE as u8), Some(RADIO as u8)), "{report:?}");
        let before = world.vessel.switches.len();
        world.run(10 * MINUTE);
        let report = world.shore.ways.clone().unwrap();
        let failures: Vec<u32> = report.ways.iter().map(|way| way.failures).collect();
        assert_eq!((failures, world.vessel.switches.len() - before), (vec![0, 0], 0));
        complete(world);
    }
}

/// Whatever way dies under a receipt, it comes by another while the shore still waits for it.
#[test]
fn what_the_vessel_obeyed_is_answered_while_one_way_stands() {
    for seed in 1..=so_many(4, 40) {
        let (world, mut chance) = (World::new(seed, SECOND / 5, None), Chance::new(seed));
        let mut world = world.with_ways(ways(None), paths()).with_commands(SECOND / 7);
        world.run(30 * SECOND);
        for _ in 0..12 {
            world.at(chance.below(SECOND), Event::Fault(Fault::CutWay(RADIO, 25 * SECOND)));
            world.run(chance.between(35 * SECOND, 70 * SECOND));
        }
        world.run(30 * SECOND);
        let outcome = |id: u64| world.shore.asked[&id].2.clone();
        let delivered = world.vessel.delivered.iter().map(|(id, _)| *id);
        let lost: Vec<u64> = delivered.filter(|id| outcome(*id) == Some(Outcome::Unanswered)).collect();
        assert!(lost.is_empty(), "seed {seed}: {lost:?} of {}", world.vessel.delivered.len());
        complete(world);
    }
}

#[test]
fn a_way_that_comes_and_goes_is_not_gone_back_to_each_time() {
    let mut world = world(8, None);
    world.run(MINUTE);
    let before = world.vessel.switches.len();
    for _ in 0..60 {
        world.at(0, Event::Fault(Fault::CutWay(RADIO, 2 * SECOND)));
        world.run(10 * SECOND);
    }
    let switches = world.vessel.switches.len() - before;
    assert!(switches <= 16, "{switches} in ten minutes");
    // It is, once it has done well for long.
    world.run(6 * MINUTE);
    assert_eq!(world.shore.ways.as_ref().unwrap().live, Some(RADIO as u8));
    complete(world);
}

#[test]
fn a_metered_way_alone_keeps_to_its_day() {
    let daily = 2_000_000;
    let mut world = World::new(9, SECOND / 20, None).with_ways(ways(Some(daily)), paths());
    world.run(10 * SECOND);
    world.at(0, Event::Fault(Fault::CutWay(RADIO, 60 * MINUTE)));
    let mut seen = Vec::new();
    for _ in 0..60 {
        world.run(MINUTE);
        let used = world.vessel.machine.as_ref().unwrap().used()[MOBILE];
        seen.push((used.bytes, world.shore.ways.as_ref().unwrap().ways[MOBILE].thinning));
    }
    let levels = [Thinning::Nothing, Thinning::Records, Thinning::Most, Thinning::AllButLast];
    let first = levels.map(|level| seen.iter().position(|(_, now)| *now == level).unwrap());
    assert!(first.is_sorted(), "{seen:?}");
    // The rest are heartbeats and the messages left out last: 7 MB in a whole day.
    let (beyond, minutes) = (seen[59].0 - seen[first[3]].0, 59 - first[3] as u64);
    println!("{} B a minute beyond the budget, which {} minutes used up", beyond / minutes, first[3]);
    assert!(beyond / minutes < 5_500, "{seen:?}");
    assert!(world.missing() > 10_000, "records wait for the radio");
    let old_us = world.now_us - world.shore.newest_us;
    assert!(old_us < 2 * MINUTE, "position comes to the last, {old_us} us old");
    complete(world);
}

#[test]
fn what_the_day_has_used_is_known_after_a_start() {
    let mut world = world(10, Some(50_000_000));
    world.at(MINUTE, Event::Fault(Fault::CutWay(RADIO, MINUTE)));
    world.run(90 * SECOND);
    let used = |world: &World| world.vessel.machine.as_ref().unwrap().used()[MOBILE].bytes;
    let before = used(&world);
    assert!(before > 50_000, "{before}");
    world.at(0, Event::Fault(Fault::KillVessel(SECOND)));
    world.run(5 * SECOND);
    assert!(used(&world) >= before / 2, "what was on the disk: {} of {before}", used(&world));
    complete(world);
}

fn random_fault(chance: &mut Chance) -> Fault {
    let short = chance.between(SECOND / 10, 12 * SECOND);
    let way = chance.below(2) as usize;
    match chance.below(14) {
        0 | 1 => Fault::CutWay(way, short),
        2 => Fault::CutWay(way, chance.between(MINUTE, 3 * MINUTE)),
        3 => Fault::CutWayUp(way, short),
        4 => Fault::CutWayDown(way, short),
        5 => Fault::Cut(short),
        6 => Fault::KillVessel(chance.between(SECOND, 30 * SECOND)),
        7 => Fault::KillShore(chance.between(SECOND / 5, 60 * SECOND)),
        8 => Fault::Reset,
        9 => Fault::DiskFull(chance.between(SECOND, MINUTE)),
        10 => Fault::Slow(chance.between(4_000, 30_000), chance.between(SECOND, MINUTE)),
        11 => Fault::Delay(way, chance.between(1_000, 400_000)),
        12 => Fault::Duplicate,
        _ => Fault::Swap,
    }
}

fn fault() -> impl Strategy<Value = (u64, Fault)> {
    (0..3 * MINUTE, any::<u64>()).prop_map(|(at, seed)| (at, random_fault(&mut Chance::new(seed))))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(so_many(8, 200) as u32))]
    /// The world itself looks at each record, live value and command: once, and in order.
    #[test]
    fn any_faults_of_any_way_lose_double_and_mix_nothing(
        seed: u64,
        faults in proptest::collection::vec(fault(), 0..30),
        every in 20_000..200_000_u64,
        budget in proptest::option::of(50_000..5_000_000_u64),
    ) {
        let mut world = World::new(seed, every, None).with_ways(ways(budget), paths()).with_commands(SECOND / 2);
        for (at, fault) in faults {
            world.at(at, Event::Fault(fault));
        }
        world.run(8 * MINUTE);
        complete(world);
    }

    /// A shore that knows nothing of ways takes one connection at a time.
    #[test]
    fn any_faults_before_an_older_shore_lose_and_double_nothing(
        seed: u64,
        faults in proptest::collection::vec(fault(), 0..20),
    ) {
        let mut world = world(seed, None);
        world.shore.is_older = true;
        for (at, fault) in faults {
            world.at(at, Event::Fault(fault));
        }
        world.run(8 * MINUTE);
        let world = complete(world);
        prop_assert!(world.shore.ways.is_none());
    }
}

#[test]
fn before_an_older_shore_a_way_that_dies_is_left_for_the_next() {
    let mut world = world(11, None);
    world.shore.is_older = true;
    world.run(20 * SECOND);
    world.shore.longest_gap_us = 0;
    for cut in 0..6 {
        world.at(0, Event::Fault(Fault::CutWay(cut % 2, 20 * SECOND)));
        world.run(40 * SECOND);
    }
    assert!(world.shore.longest_gap_us < 6 * SECOND, "{}", world.shore.longest_gap_us);
    complete(world);
}

#[test]
fn before_an_older_shore_the_unmetered_way_is_gone_back_to_without_a_break() {
    let mut world = world(13, None);
    world.shore.is_older = true;
    world.run(20 * SECOND);
    let live = |world: &World| world.vessel.switches.last().unwrap().1.live;
    assert_eq!(live(&world), Some(RADIO as u8));
    world.at(0, Event::Fault(Fault::CutWay(RADIO, 3 * MINUTE)));
    world.run(MINUTE);
    assert_eq!(live(&world), Some(MOBILE as u8));
    world.shore.longest_gap_us = 0;
    world.run(5 * MINUTE);
    assert_eq!(live(&world), Some(RADIO as u8));
    assert!(world.shore.longest_gap_us < SECOND, "{}", world.shore.longest_gap_us);
    // A way that comes and goes is not used again each time.
    let before = world.vessel.switches.len();
    for _ in 0..60 {
        world.at(0, Event::Fault(Fault::CutWay(RADIO, 2 * SECOND)));
        world.run(10 * SECOND);
    }
    let switches = world.vessel.switches.len() - before;
    assert!(switches <= 40, "{switches} in ten minutes");
    complete(world);
}

#[test]
fn before_an_older_shore_a_way_that_only_connects_is_tried_ever_later() {
    let slow = World::new(17, 5 * SECOND, None).with_ways(ways(None), paths());
    let mut world = slow.with_commands(MINUTE);
    world.shore.is_older = true;
    world.run(20 * SECOND);
    world.at(0, Event::Fault(Fault::CutWay(RADIO, 20 * SECOND)));
    world.at(0, Event::Fault(Fault::MuteWay(RADIO, 2 * HOUR)));
    world.run(MINUTE);
    // Each try takes the connection that stands from a shore that keeps one.
    let tries = |world: &mut World| {
        let before = world.network.paths[RADIO].connections;
        world.run(10 * MINUTE);
        world.network.paths[RADIO].connections - before
    };
    let soon = tries(&mut world);
    world.run(70 * MINUTE);
    let late = tries(&mut world);
    assert!((2..=8).contains(&soon) && late <= 1, "{soon} tries in ten minutes, then {late}");
    assert_eq!(world.vessel.switches.last().unwrap().1.live, Some(MOBILE as u8));
    // Once it carries again it is gone back to.
    world.run(90 * MINUTE);
    assert_eq!(world.vessel.switches.last().unwrap().1.live, Some(RADIO as u8));
    complete(world);
}
