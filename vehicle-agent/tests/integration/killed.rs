//! The real program is killed, as by the computer's watchdog, and restarted on the same folder.

use crate::common::{Agent, Console, far_plan, ini};
use imc::messages::*;
use std::path::Path;
use tempfile::TempDir;

/// What the vessel does when the program is killed.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Doing {
    Plan,
    Teleoperation,
    Adrift,
    Aborted,
    AtRest,
}

fn start(folder: &Path) -> (Agent, Console) {
    let agent = Agent::start(folder, &[]);
    let console = Console::connect(&agent);
    (agent, console)
}

/// Starts it, and waits until the disk has what the next start needs.
fn begin(console: &mut Console, doing: Doing) {
    console.ready();
    match doing {
        Doing::Teleoperation => {
            console.start("steer", Some(Teleoperation { custom: "src=16385".into() }.into()));
        }
        Doing::Plan | Doing::Adrift | Doing::Aborted => {
            console.start("far", Some(far_plan().into()));
            console.wait_for::<EstimatedState>("way on", |state| state.u > 0.3);
        }
        Doing::AtRest => {}
    }
    match doing {
        Doing::Adrift => {
            console.ask(PlanControlOp::Stop, "", None);
            console
                .wait_for::<PlanControlState>("stopped", |state| state.state == PlanControlStateState::Ready);
        }
        Doing::Aborted => {
            console.send(Abort);
            console.wait_for::<Aborted>("aborted", |_| true);
        }
        Doing::Plan | Doing::Teleoperation | Doing::AtRest => {}
    }
}

/// Waits until the stored task under way begins with this word; `None` for no task.
fn kept(folder: &Path, console: &mut Console, word: Option<&str>) {
    let holds = || {
        let bytes = std::fs::read(folder.join("under-way.imc")).ok();
        let packet = bytes.map(|bytes| imc::Packet::decode(&bytes).unwrap());
        let info = packet.and_then(|packet| Some(packet.get::<PlanControl>()?.info.to_string()));
        info.as_deref().map(|info| info.split(' ').next().unwrap().to_owned()).as_deref() == word
    };
    console.wait("what is under way on the disk", |_| holds().then_some(()));
}

#[test]
fn after_a_kill_in_every_state_it_tells_and_does_what_the_files_say() {
    for doing in [Doing::Plan, Doing::Teleoperation, Doing::Adrift, Doing::Aborted, Doing::AtRest] {
        let folder = TempDir::new().unwrap();
        let (agent, mut console) = start(folder.path());
        begin(&mut console, doing);
        let word = match doing {
            Doing::Plan => Some("plan"),
            Doing::Teleoperation => Some("teleoperation"),
            Doing::Adrift => Some("drift"),
            Doing::Aborted | Doing::AtRest => None,
        };
        kept(folder.path(), &mut console, word);
        agent.signal("KILL");
        drop((agent, console));

        let (agent, mut console) = start(folder.path());
        let told = match doing {
            Doing::Plan => "plan 'far' was under way at maneuver 'go'",
            Doing::Teleoperation => "an operator was steering",
            Doing::Adrift => "the vessel was adrift on purpose",
            Doing::Aborted | Doing::AtRest => {
                console.ready();
                let moves = console.seen.iter().any(|packet| {
                    packet.get::<SetThrusterActuation>().is_some_and(|set| set.value.abs() > 0.0)
                });
                assert!(!moves, "{doing:?}");
                continue;
            }
        };
        let full = format!("{told} when the program ended");
        console.wait_for::<LogBookEntry>(&full, |entry| entry.text.to_str_lossy().contains(&full));
        if doing != Doing::Adrift {
            console.wait_for::<PlanControlState>("holding", |state| {
                state.state == PlanControlStateState::Executing && state.plan_id == "hold"
            });
            kept(folder.path(), &mut console, Some("remedy"));
        }
        drop(agent);
    }
}

#[test]
fn a_plan_that_was_killed_resumes_after_the_count_down() {
    let folder = TempDir::new().unwrap();
    let text = std::fs::read_to_string(ini()).unwrap();
    let text = text
        .replace("Action After Restart = hold", "Action After Restart = resume")
        .replace("Resume Countdown = 30", "Resume Countdown = 2");
    std::fs::write(folder.path().join("otter.ini"), text).unwrap();
    let (agent, mut console) = start(folder.path());
    begin(&mut console, Doing::Plan);
    kept(folder.path(), &mut console, Some("plan"));
    agent.signal("KILL");
    drop((agent, console));

    let (_agent, mut console) = start(folder.path());
    console.wait_for::<LogBookEntry>("the count-down", |entry| {
        entry.text.to_str_lossy().contains("'far' resumes at ")
    });
    console.wait_for::<PlanControlState>("resumed", |state| {
        state.state == PlanControlStateState::Executing && state.plan_id == "far"
    });
    console.wait_for::<EstimatedState>("way on", |state| state.u > 0.3);
}
