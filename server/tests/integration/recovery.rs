//! A shore is lost in the middle of a backup: a new one is restored from the backup, and the vessel continues.

use crate::support::ashore::{all_that_was_logged_is_ashore, archived_bytes, link_numbers, newest_s, now_s};
use crate::support::program::{Agent, Line, Process, SERVER, Server, agent_program, link_token, run, until};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use store::Store;
use tempfile::TempDir;

const SEED: u64 = 0x5EED_0018;

/// A random number below `most`, the same in every run.
fn chance(state: &mut u64, most: u64) -> u64 {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    *state % most
}

fn begin_backup(data: &Path, to: &Path) -> Process {
    let mut command = Command::new(SERVER);
    command.arg("backup").arg(to).arg("--data").arg(data).stdout(Stdio::null()).stderr(Stdio::null());
    Process(command.spawn().unwrap())
}

/// Restores into a new folder; returns the last number of the vessel's stream that is there.
fn restored(from: &Path, to: &Path) -> u64 {
    let told = run(to, &["restore", from.to_str().unwrap()]);
    assert!(
        told.contains(": recorded from ") && told.contains("what came after that is not in it"),
        "{told}"
    );
    let streams = link_numbers(to);
    let (stream, _) = streams.iter().next().expect("records of the vessel");
    Store::open(to).unwrap().durable(*stream).unwrap()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn killed_while_it_backs_up_a_shore_is_restored_elsewhere_and_its_vessel_goes_on() {
    let Some(program) = agent_program() else { return };
    let (shore, aboard) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let at = |name: &str| shore.path().join(name);
    let (data, backup) = (at("data"), at("backup"));
    let token = link_token(&data, "otter-1", "0x2810");
    let mut server = Server::start(&data);
    let line = Line::to(server.web).await;
    let mut agent = Agent::start(&program, aboard.path(), line.address, &token);
    let more_ashore = async || {
        let more = archived_bytes(&data) + 10_000;
        until("more ashore", || (archived_bytes(&data) > more).then_some(())).await;
    };
    more_ashore().await;
    let began = Instant::now();
    run(&data, &["backup", backup.to_str().unwrap()]);
    let (took, mut seed) = (began.elapsed(), SEED);
    let mut durable = restored(&backup, &at("first"));
    // How often a backup is killed.
    let rounds = testkit::so_many(3, 12);
    for round in 0..rounds {
        more_ashore().await;
        let mut backing_up = begin_backup(&data, &backup);
        let us = chance(&mut seed, u64::try_from(took.as_micros()).unwrap());
        tokio::time::sleep(Duration::from_micros(us)).await;
        backing_up.kill();
        let now = restored(&backup, &at(&format!("round-{round}")));
        assert!(now >= durable, "round {round}: {now} after {durable}");
        durable = now;
    }
    // The computer is lost in the middle of one more.
    more_ashore().await;
    let mut backing_up = begin_backup(&data, &backup);
    tokio::time::sleep(took / 2).await;
    backing_up.kill();
    server.process.kill();

    let back = at("back");
    assert!(restored(&backup, &back) >= durable);
    let mut server = Server::start(&back);
    let moved_s = now_s();
    line.passes(server.web);
    until("live again", || (newest_s(&back) > moved_s + 1.0).then_some(())).await;
    // It ends in order; its last packets arrive after its next start.
    let ended_s = now_s();
    agent.process.terminate();
    drop(agent);
    let mut agent = Agent::start(&program, aboard.path(), line.address, &token);
    until("complete", || (newest_s(&back) > ended_s + 1.0).then_some(())).await;
    agent.process.terminate();
    server.process.terminate();
    for (stream, mut numbers) in link_numbers(&back) {
        let came = numbers.len();
        numbers.sort_unstable();
        numbers.dedup();
        assert_eq!(came, numbers.len(), "numbers of {stream:#x} came twice");
    }
    // Records that the lost shore acknowledged after the backup are in its archive, if its disk can be read.
    run(&back, &["import", data.join("archive").to_str().unwrap()]);
    let compared = all_that_was_logged_is_ashore(&back, aboard.path(), |said_s| said_s >= ended_s);
    assert!(compared > 300, "{compared}");
    println!("{rounds} backups killed, {compared} packets of the vessel's logs are ashore once");
}
