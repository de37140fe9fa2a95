//! Two ends of the link in a bad world, by a virtual clock: what is recorded arrives once, whatever breaks.

mod world;

use proptest::prelude::*;
use world::chance::Chance;
use world::{Event, Fault, SECOND, World};

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

#[test]
fn a_day_of_faults_loses_and_doubles_nothing() {
    let seed = 20_261_121;
    println!("seed {seed}");
    let mut chance = Chance::new(seed);
    let mut world = World::new(seed, SECOND / 4, Some(100_000)).with_commands(3 * SECOND);
    let (mut at, mut faults) = (0, 0);
    while at < 24 * HOUR {
        at += chance.between(SECOND, 100 * SECOND);
        world.at(at, Event::Fault(random_fault(&mut chance)));
        faults += 1;
    }
    world.run(24 * HOUR + 11 * MINUTE);
    world.stop_saying();
    world.run_to(10 * MINUTE, "complete", |world| world.missing() == 0);
    world.check_everything_arrived();
    world.check_commands();
    let delivered = world.vessel.delivered.len();
    println!(
        "{} packets once each; {faults} faults, {} connections, {} packets came again; {delivered} of {} commands",
        world.said, world.shore.ups, world.shore.repeated, world.shore.commands
    );
    assert!(world.said > 300_000 && world.shore.ups > 500, "the world was too kind");
    assert!(world.shore.repeated > 100 && delivered as u64 * 2 > world.shore.commands);
}

/// 640 kbit/s up and 80 ms there and back: a 4G link at the edge of its cell.
#[test]
fn after_ten_minutes_without_a_link_it_is_live_in_2_s_and_complete_in_60_s() {
    let (mut slowest_live, mut slowest_whole) = (0, 0);
    for seed in 1..=10 {
        let mut world = World::new(seed, SECOND / 100, None);
        world.network.bytes_per_s = 80_000;
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
    world.network.bytes_per_s = 16_000;
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
    let rate = world.network.carried_bytes / (10 * 60);
    // Both ways: the budget, and what comes down.
    assert!(rate < 5_000, "{rate} B/s");
    assert!(world.missing() > 1000);
}

fn fault() -> impl Strategy<Value = (u64, Fault)> {
    (0..3 * MINUTE, any::<u64>()).prop_map(|(at, seed)| (at, random_fault(&mut Chance::new(seed))))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
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
}
