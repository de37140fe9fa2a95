//! Two ends of the link in a bad world, by a virtual clock: what is recorded arrives once, whatever breaks.

use crate::world::chance::Chance;
use crate::world::{Event, Fault, SECOND, World};
use link::ChartStage;
use proptest::prelude::*;
use testkit::so_many;

const MINUTE: u64 = 60 * SECOND;
const HOUR: u64 = 60 * MINUTE;

fn random_fault(chance: &mut Chance) -> Fault {
    let short = chance.between(SECOND / 10, 12 * SECOND);
    match chance.below(13) {
        0 | 1 => Fault::Cut(short),
        2 => Fault::Cut(chance.between(MINUTE, 10 * MINUTE)),
        3 => Fault::CutUp(short),
        4 => Fault::CutDown(short),
        5 => Fault::KillVessel(chance.between(SECOND, 30 * SECOND)),
        6 => Fault::KillShore(chance.between(SECOND / 5, 60 * SECOND)),
        7 => Fault::Reset,
        8 => Fault::DiskFull(chance.between(SECOND, 2 * MINUTE)),
        9 => Fault::Slow(chance.between(2_000, 30_000), chance.between(SECOND, 5 * MINUTE)),
        10 => Fault::StepClock(chance.between(0, 20 * SECOND) as i64 - 10 * SECOND as i64),
        11 => Fault::Duplicate,
        _ => Fault::Swap,
    }
}

/// Four hours of it; a day by `make test-long`.
#[test]
fn a_day_of_faults_loses_and_doubles_nothing() {
    let hours = so_many(4, 24);
    let seed = 20_261_121;
    println!("seed {seed}");
    let mut chance = Chance::new(seed);
    let mut world = World::new(seed, SECOND / 4, Some(100_000)).with_commands(3 * SECOND);
    let (mut at, mut faults) = (0, 0);
    while at < hours * HOUR {
        at += chance.between(SECOND, 100 * SECOND);
        world.at(at, Event::Fault(random_fault(&mut chance)));
        faults += 1;
    }
    world.run(hours * HOUR + 11 * MINUTE);
    world.stop_saying();
    world.run_to(10 * MINUTE, "complete", |world| world.missing() == 0);
    world.check_everything_arrived();
    world.check_commands();
    let delivered = world.vessel.delivered.len();
    println!(
        "{} packets once each; {faults} faults, {} connections, {} packets came again; {delivered} of {} commands",
        world.said, world.shore.ups, world.shore.repeated, world.shore.commands
    );
    assert!(world.said > hours * 12_500 && world.shore.ups > hours * 20, "the world was too kind");
    assert!(world.shore.repeated > hours * 4 && delivered as u64 * 2 > world.shore.commands);
}

/// 640 kbit/s up and 80 ms there and back: a 4G link at the edge of its cell.
#[test]
fn after_ten_minutes_without_a_link_it_is_live_in_2_s_and_complete_in_60_s() {
    let (mut slowest_live, mut slowest_whole) = (0, 0);
    for seed in 1..=so_many(2, 10) {
        let mut world = World::new(seed, SECOND / 100, None);
        world.network.paths[0].bytes_per_s = 80_000;
        world.run(30 * SECOND + seed * 77_000);
        world.at(0, Event::Fault(Fault::Cut(10 * MINUTE)));
        world.run(10 * MINUTE);
        assert!(world.missing() >= 59_000);
        let backlog = world.said;
        let live = world.run_to(5 * SECOND, "live", |world| world.now_us < world.shore.newest_us + SECOND);
        let rest = world.run_to(2 * MINUTE, "complete", |world| world.shore.kept.len() as u64 >= backlog);
        slowest_live = slowest_live.max(live);
        slowest_whole = slowest_whole.max(live + rest);
        world.stop_saying();
        world.run_to(MINUTE, "empty", |world| world.missing() == 0);
        world.check_everything_arrived();
    }
    println!("live after {slowest_live} us, complete after {slowest_whole} us at most");
    assert!(slowest_live <= 2 * SECOND && slowest_whole <= 60 * SECOND, "{slowest_live} {slowest_whole}");
}

/// The map stays current while a backlog goes over a link that can hardly carry it.
#[test]
fn live_values_do_not_queue_behind_a_backlog() {
    let mut world = World::new(3, SECOND / 50, Some(15_000));
    world.network.paths[0].bytes_per_s = 16_000;
    world.run(10 * SECOND);
    world.at(0, Event::Fault(Fault::Cut(10 * MINUTE)));
    world.run(10 * MINUTE);
    world.run_to(5 * SECOND, "live", |world| world.now_us < world.shore.newest_us + SECOND);
    let mut oldest = 0;
    for _ in 0..600 {
        world.run(SECOND / 10);
        oldest = oldest.max(world.now_us - world.shore.newest_us);
    }
    assert!(world.missing() > 1000, "still behind");
    println!("age of the newest value on the map: {oldest} us at most");
    assert!(oldest <= 2 * SECOND, "{oldest}");
}

#[test]
fn a_budget_is_not_exceeded_over_time() {
    let mut world = World::new(5, SECOND / 100, Some(4_000));
    world.run(10 * MINUTE);
    let rate = world.network.paths[0].carried_bytes / (10 * 60);
    // Both ways: the budget, and what comes down.
    assert!(rate < 5_000, "{rate} B/s");
    assert!(world.missing() > 1000);
}

/// The worst of ten minutes on a link: age of the newest value on the map, a command's way, a packet's way to the
/// shore's disk (all µs); and how long the chart took, if there is one.
fn worst(bytes_per_s: u64, chart: Option<u64>) -> ([u64; 3], Option<u64>) {
    let mut world = World::new(8, SECOND / 20, None).with_commands(SECOND / 3);
    world.network.paths[0].bytes_per_s = bytes_per_s;
    world.run(20 * SECOND);
    let (from_us, first) = (world.now_us, world.shore.commands);
    if let Some(bytes) = chart {
        world.publish(bytes);
    }
    let (mut oldest, mut behind, mut aboard) = (0, 0, None);
    for _ in 0..6_000 {
        world.run(SECOND / 10);
        oldest = oldest.max(world.now_us - world.shore.newest_us);
        behind = behind.max(world.missing() * (SECOND / 20));
        if chart.is_some() && aboard.is_none() && world.chart_is_aboard() {
            aboard = Some(world.now_us - from_us);
        }
    }
    let late = |(id, at): &(u64, u64)| (*id > first).then(|| at - world.shore.asked[id].0);
    let slowest = world.vessel.delivered.iter().filter_map(late).max().unwrap();
    assert!(world.vessel.delivered.len() > 1_000);
    world.check_commands();
    ([oldest, slowest, behind], aboard)
}

/// A chart comes down with what the link has to spare.
#[test]
fn a_chart_on_its_way_delays_neither_live_values_nor_commands_nor_records() {
    for (bytes_per_s, chart) in [(16_000, 300_000), (80_000, 2_000_000), (1_000_000, 6_000_000)] {
        let (without, _) = worst(bytes_per_s, None);
        let (with, took) = worst(bytes_per_s, Some(chart));
        let took = took.expect("aboard within ten minutes");
        let share = (chart * SECOND) as f64 / took as f64 / bytes_per_s as f64;
        println!(
            "{bytes_per_s} B/s: {without:?} us without, {with:?} us with a chart of {chart} B in {took} us ({share:.2})"
        );
        for (without, with) in without.into_iter().zip(with) {
            assert!(with <= without + 150_000, "{with} instead of {without} us");
        }
    }
}

#[test]
fn a_chart_goes_on_where_it_was_after_cuts_and_restarts_of_both() {
    let mut world = World::new(11, SECOND, None);
    world.network.paths[0].bytes_per_s = 80_000;
    let whole = 5_000_000;
    world.publish(whole);
    let faults = [Fault::Cut(20 * SECOND), Fault::KillVessel(SECOND), Fault::KillShore(SECOND), Fault::Reset];
    for (at, fault) in (1_usize..).zip(faults) {
        world.run_to(5 * MINUTE, "further", |world| world.chart_bytes_aboard() >= at * 200_000);
        let before = world.chart_bytes_aboard();
        world.at(0, Event::Fault(fault));
        world.run(30 * SECOND);
        assert!(world.chart_bytes_aboard() >= before, "nothing is fetched twice");
    }
    world.run_to(5 * MINUTE, "aboard", World::chart_is_aboard);
    world.run(2 * SECOND);
    // Each program that dies may take a part along that was under way, and nothing else.
    assert_eq!((world.vessel.chart.came, world.vessel.chart.used), (whole, whole));
    let report = world.shore.chart.report.clone().unwrap();
    assert_eq!((report.stage, report.have, report.of), (ChartStage::Settled, 0, 0), "{report:?}");
}

#[test]
fn a_chart_that_came_damaged_is_refused_told_and_fetched_again_later_and_later() {
    let mut world = World::new(12, SECOND, None);
    world.publish(100_000);
    let mut pauses = Vec::new();
    for round in 1..=3 {
        world.at(0, Event::Fault(Fault::CorruptChart));
        world.run_to(2 * MINUTE, "refused", |world| world.vessel.chart.refused == round);
        world.run(SECOND);
        let report = world.shore.chart.report.clone().unwrap();
        assert_eq!((report.stage, &report.text[..]), (ChartStage::Failed, "not what its digest says"));
        pauses.push(world.run_to(2 * MINUTE, "begun again", |world| world.chart_bytes_aboard() > 0));
    }
    assert!(pauses.windows(2).all(|two| two[1] > two[0] * 3 / 2), "{pauses:?}");
    world.run_to(MINUTE, "aboard", World::chart_is_aboard);
}

fn fault() -> impl Strategy<Value = (u64, Fault)> {
    (0..3 * MINUTE, any::<u64>()).prop_map(|(at, seed)| (at, random_fault(&mut Chance::new(seed))))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(so_many(6, 96)))]
    #[test]
    fn any_faults_lose_and_double_nothing(
        seed: u64,
        faults in proptest::collection::vec(fault(), 0..25),
        every in 20_000..200_000_u64,
    ) {
        let mut world = World::new(seed, every, None).with_commands(SECOND);
        for (at, fault) in faults {
            world.at(at, Event::Fault(fault));
        }
        world.run(14 * MINUTE);
        world.stop_saying();
        world.run_to(10 * MINUTE, "complete", |world| world.missing() == 0);
        world.check_everything_arrived();
        world.check_commands();
    }

    #[test]
    fn any_faults_bring_the_last_chart_aboard(
        seed: u64,
        faults in proptest::collection::vec(fault(), 0..12),
        charts in proptest::collection::vec((0..3 * MINUTE, 1_000..600_000_u64), 1..4),
        corrupted in proptest::collection::vec(0..3 * MINUTE, 0..4),
    ) {
        let mut world = World::new(seed, SECOND, None);
        world.network.paths[0].bytes_per_s = 60_000;
        for (at, fault) in faults {
            world.at(at, Event::Fault(fault));
        }
        for (at, bytes) in charts {
            world.at(at, Event::Fault(Fault::NewChart(bytes)));
        }
        for at in corrupted {
            world.at(at, Event::Fault(Fault::CorruptChart));
        }
        world.run(14 * MINUTE);
        world.run_to(15 * MINUTE, "aboard", World::chart_is_aboard);
        world.stop_saying();
        world.run_to(10 * MINUTE, "complete", |world| world.missing() == 0);
        world.check_everything_arrived();
    }
}
