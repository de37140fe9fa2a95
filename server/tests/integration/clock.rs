//! A real server whose wall clock jumps by hours and days: nothing is disturbed. Links use a monotonic clock, people stay
//! logged in, and packets are stored once, in the folder of the day by the shore's clock.
//!
//! Needs libfaketime (`make test` installs it); prints a note where it is absent.

use crate::support::ashore::{
    all_that_was_logged_is_ashore, archived_bytes, arrivals_s, every_number_came_once, newest_s, now_s,
};
use crate::support::browser::Browser;
use crate::support::program::{Agent, Line, SERVER, Server, add_admin, agent_program, link_token, until};
use crate::support::{OTTER, archive_of};
use std::path::{Path, PathBuf};
use std::process::Command;
use store::{Reader, TimeRange};
use tempfile::TempDir;

/// The library that gives a program another time.
fn faketime() -> Option<PathBuf> {
    let found = std::fs::read_dir("/usr/lib").into_iter().flatten().filter_map(|entry| {
        let library = entry.ok()?.path().join("faketime/libfaketimeMT.so.1");
        library.exists().then_some(library)
    });
    let library = found.min();
    if library.is_none() {
        testkit::absent(testkit::Need::Faketime, "apt-get install libfaketime");
    }
    library
}

/// Sets the offset of the server's clock from the computer's.
fn set(clock: &Path, ahead: &str) {
    let beside = clock.with_extension("new");
    std::fs::write(&beside, ahead).unwrap();
    std::fs::rename(beside, clock).unwrap();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_shore_whose_clock_jumps_disturbs_nobody() {
    let Some(program) = agent_program() else { return };
    let Some(library) = faketime() else { return };
    let (shore, aboard) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let (data, clock) = (shore.path().join("data"), shore.path().join("clock"));
    let token = link_token(&data, "otter-1", "0x2810");
    add_admin(&data, "nils", "seven small boats");
    set(&clock, "+0");
    let mut command = Command::new(SERVER);
    command.env("LD_PRELOAD", library).env("FAKETIME_TIMESTAMP_FILE", &clock);
    command.env("FAKETIME_NO_CACHE", "1").env("FAKETIME_DONT_FAKE_MONOTONIC", "1");
    let mut server = Server::start_by(command, &data, "127.0.0.1:0", &[]);
    let mut person = Browser::log_in(&server.web.to_string(), "nils", "seven small boats");
    let line = Line::to(server.web).await;
    let mut agent = Agent::start(&program, aboard.path(), line.address, &token);
    until("begun", || (archived_bytes(&data) > 20_000).then_some(())).await;
    let stood = server.log().matches("the link stands").count();

    // Jumps of hours and days in both directions, as by a wrong GNSS, a flat battery or a person.
    for hours in [5, -6, 30, -30, 0] {
        set(&clock, &format!("{hours:+}h"));
        until("heard at another time", || {
            let expected_s = now_s() + f64::from(hours) * 3600.0;
            arrivals_s(&data).iter().any(|at_s| (at_s - expected_s).abs() < 60.0).then_some(())
        })
        .await;
        // Thirty hours without a request rightly end a session of twelve.
        if hours < 12 {
            assert!(person.get("/api/v1/me").contains("nils"), "logged out by {hours} h");
        }
        let before = archived_bytes(&data);
        until("on with another time", || (archived_bytes(&data) > before + 20_000).then_some(())).await;
    }
    assert_eq!(server.log().matches("the link stands").count(), stood, "the link was disturbed");
    assert!(!server.log().contains("the link is down"));
    let days = archive_of(&data, OTTER).len();
    assert!((3..=4).contains(&days), "{days} days: the real one, one after and one before");

    // The vessel ends in order; its last packets arrive after its next start.
    let ended_s = now_s();
    agent.process.terminate();
    drop(agent);
    let mut agent = Agent::start(&program, aboard.path(), line.address, &token);
    until("complete", || (newest_s(&data) > ended_s + 1.0).then_some(())).await;
    agent.process.terminate();
    server.process.terminate();

    every_number_came_once(&data, 0);
    assert_eq!(Reader::open(&data).unwrap().gaps(None, TimeRange::ALL).unwrap(), []);
    let compared = all_that_was_logged_is_ashore(&data, aboard.path(), |said_s| said_s >= ended_s);
    assert!(compared > 1_000, "{compared}");
    println!("{compared} packets of the vessel's logs are ashore once, in {days} folders of days");
}
