//! A real server and a real Otter that are killed repeatedly at random points: spooled packets are ashore once, others are
//! declared as gaps.

use crate::support::OTTER;
use crate::support::ashore::{
    SAID_BEFORE_S, all_that_was_logged_is_ashore, archived_bytes, every_number_came_once, newest_s, now_s,
};
use crate::support::program::{Agent, Line, Server, agent_program, link_token, until};
use std::path::Path;
use store::{Gap, GapKind, Reader, TimeRange};
use tempfile::TempDir;

/// How often each of the two is killed.
const ROUNDS: usize = 5;
const SEED: u64 = 0x1234_5678_9ABC_DEF1;

/// Random numbers, the same in every run.
struct Chance(u64);

impl Chance {
    /// Up to `most`.
    fn next(&mut self, most: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % most
    }
}

/// Bytes of the spool: they grow although no shore is there.
fn spooled_bytes(aboard: &Path) -> u64 {
    let entries =
        std::fs::read_dir(aboard.join("spool")).into_iter().flatten().map(|entry| entry.unwrap().path());
    let of = |path: &Path| -> u64 {
        let files = std::fs::read_dir(path).into_iter().flatten();
        files.filter_map(|file| file.ok()?.metadata().ok().map(|meta| meta.len())).sum()
    };
    entries.map(|path| of(&path)).sum()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn killed_in_turn_at_any_point_what_was_spooled_is_ashore_once_and_the_rest_is_declared() {
    let Some(program) = agent_program() else { return };
    let (shore, aboard) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let data = shore.path().join("data");
    let token = link_token(&data, "otter-1", "0x2810");
    let mut server = Server::start(&data);
    let line = Line::to(server.web).await;
    let mut agent = Agent::start(&program, aboard.path(), line.address, &token);
    let mut chance = Chance(SEED);
    let mut kills = Vec::new();
    for _ in 0..ROUNDS {
        // The server dies after a random amount of further data; it may be in the middle of anything.
        let more = archived_bytes(&data) + chance.next(60_000);
        until("more ashore", || (archived_bytes(&data) > more).then_some(())).await;
        server.process.kill();

        // The vessel dies with so much more in its spool, randomly before the server is back or after.
        let back_before = chance.next(2) == 0;
        let more = spooled_bytes(aboard.path()) + chance.next(60_000);
        if back_before {
            server = Server::start(&data);
            line.passes(server.web);
            let more = archived_bytes(&data) + chance.next(30_000);
            until("more ashore", || (archived_bytes(&data) > more).then_some(())).await;
        } else {
            until("more spooled", || (spooled_bytes(aboard.path()) > more).then_some(())).await;
        }
        agent.process.kill();
        kills.push(now_s());
        if !back_before {
            server = Server::start(&data);
            line.passes(server.web);
        }
        agent = Agent::start(&program, aboard.path(), line.address, &token);
    }

    // It ends in order; its last packets arrive after its next start.
    let ended_s = now_s();
    agent.process.terminate();
    drop(agent);
    let mut agent = Agent::start(&program, aboard.path(), line.address, &token);
    until("complete", || (newest_s(&data) > ended_s + 1.0).then_some(())).await;
    agent.process.terminate();
    server.process.terminate();

    // One number for each kill of the vessel represents the packets not spooled; every other came once.
    every_number_came_once(&data, ROUNDS as u64);
    let gaps = Reader::open(&data).unwrap().gaps(Some(OTTER), TimeRange::ALL).unwrap();
    assert!(
        gaps.iter().all(|gap| gap.kind == GapKind::NotRecorded && gap.reason.contains("killed")),
        "{gaps:?}"
    );
    let covers =
        |gap: &Gap, at_s: f64| (gap.from.seconds() - SAID_BEFORE_S..gap.to.seconds()).contains(&at_s);
    assert_eq!(gaps.len(), ROUNDS);
    for killed_s in &kills {
        assert!(gaps.iter().any(|gap| covers(gap, *killed_s)), "{killed_s} in {gaps:?}");
    }
    // Each begins in the run that was killed, not before.
    for (gap, before_s) in gaps[1..].iter().zip(&kills) {
        assert!(gap.from.seconds() > *before_s, "{before_s} in {gaps:?}");
    }
    let declared_s: f64 = gaps.iter().map(|gap| gap.to.seconds() - gap.from.seconds()).sum();

    let exempt = |said_s: f64| said_s >= ended_s || gaps.iter().any(|gap| covers(gap, said_s));
    let compared = all_that_was_logged_is_ashore(&data, aboard.path(), exempt);
    assert!(compared > 1_000, "{compared}");
    println!(
        "{ROUNDS} kills of each: {compared} packets of the vessel's logs are ashore once; declared missing {declared_s:.2} s in {} gaps",
        gaps.len()
    );
}
