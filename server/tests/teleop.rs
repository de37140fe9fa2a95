//! Steering by hand with the real server, a real agent and a real browser: however it fails, the vessel's own log tells
//! that its motors stood still within 0.75 s of the last fresh sample of the person's hands, and stayed so until the
//! sticks had passed neutral.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

mod support;

use imc::PacketView;
use imc::messages::SetThrusterActuation;
use std::path::Path;
use support::ashore::now_s;
use support::program::{Agent, Line, Server, add_admin, agent_program, link_token, logged};
use tempfile::TempDir;

/// From the last fresh sample to zero thrust.
const BOUND_S: f64 = 0.75;

/// What the browser's script tells.
#[derive(Debug)]
enum Told {
    /// The last fresh sample before a fault, UTC s.
    Fault(String, f64),
    /// From here on thrust may be seen again.
    May(f64),
}

/// What the vessel gave its motors: time (s), motor, actuation.
fn thrust(aboard: &Path) -> Vec<(f64, u8, f32)> {
    let mut all: Vec<(f64, u8, f32)> = Vec::new();
    for packet in logged(aboard) {
        let view = PacketView::new(&packet).unwrap();
        if let Ok(Some(motor)) = imc::decode::<SetThrusterActuation>(&view) {
            all.push((view.timestamp(), motor.id, motor.value));
        }
    }
    all.sort_by(|one, other| one.0.total_cmp(&other.0));
    all
}

/// When both motors were told to stand still after `from_s`, for good as far as `until_s`; nothing when they were not
/// running at `from_s`.
fn still_s(thrust: &[(f64, u8, f32)], from_s: f64, until_s: f64) -> Option<f64> {
    let moved = |one: &&(f64, u8, f32)| one.2 != 0.0;
    thrust.iter().filter(|one| (from_s - 1.0..from_s).contains(&one.0)).find(moved)?;
    let last = thrust.iter().filter(|one| one.0 < until_s).rfind(moved)?;
    let zero = |motor| thrust.iter().find(|one| one.0 >= last.0 && one.1 == motor && one.2 == 0.0);
    Some(zero(0)?.0.max(zero(1)?.0))
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn however_steering_by_hand_fails_the_motors_stand_still_in_time() {
    let Some(program) = agent_program() else { return };
    if !testkit::browser::is_there() {
        return;
    }
    let (shore, aboard) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let data = shore.path().join("data");
    let mut server = Server::start(&data);
    let token = link_token(&data, "otter-1", "0x2810");
    let password = "seven small boats at sea";
    for person in ["anna", "bert"] {
        add_admin(&data, person, password);
    }
    let (to_vessel, to_browser) = (Line::to(server.web).await, Line::to(server.web).await);
    let mut agent = Agent::start(&program, aboard.path(), to_vessel.address, &token);
    let url = format!("http://{}", to_browser.address);

    let mut told = Vec::new();
    tokio::task::block_in_place(|| {
        testkit::browser::run("teleop.mjs", &[&url, password], |line| {
            let words: Vec<&str> = line.split(' ').collect();
            match words[..] {
                ["fault", name, ms] => {
                    told.push(Told::Fault(name.to_owned(), ms.parse::<f64>().unwrap() / 1e3));
                }
                ["may", ms] => told.push(Told::May(ms.parse::<f64>().unwrap() / 1e3)),
                ["silence", way] => {
                    told.push(Told::Fault(format!("network-dropped-{way}"), now_s()));
                    if way == "vessel" { &to_vessel } else { &to_browser }.silent();
                }
                ["passes", way] => {
                    if way == "vessel" { &to_vessel } else { &to_browser }.passes(server.web);
                }
                ["kill", "server"] => {
                    told.push(Told::Fault("server-killed".to_owned(), now_s()));
                    server.process.kill();
                    server = Server::start(&data);
                    to_vessel.passes(server.web);
                    to_browser.passes(server.web);
                }
                _ => {}
            }
        });
    });
    // The vessel's own clock goes on: what was commanded after the last fault is in the log.
    let end_s = now_s() + 2.0;
    support::program::until("two seconds of the log after the last fault", || {
        (now_s() > end_s).then_some(())
    })
    .await;
    agent.process.terminate();

    let thrust = thrust(aboard.path());
    let mut faults = 0;
    for (n, one) in told.iter().enumerate() {
        let Told::Fault(name, fault_s) = one else { continue };
        let later = told[n + 1..].iter().find_map(|one| match one {
            Told::May(may_s) => Some(*may_s),
            Told::Fault(..) => None,
        });
        let still_s = still_s(&thrust, *fault_s, later.unwrap_or(end_s));
        let still_s = still_s.unwrap_or_else(|| panic!("{name}: the motors did not run, or did not stop"));
        let took_s = still_s - fault_s;
        println!("{name}: zero thrust {:.0} ms after the last fresh sample", took_s * 1e3);
        assert!(took_s <= BOUND_S, "{name}: {took_s} s");
        faults += 1;
    }
    assert_eq!(faults, 9, "{told:?}");
}
