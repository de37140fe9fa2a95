//! One number tells the whole story of a command in the logs of a real server and a real Otter: from the request to what it
//! led to aboard, and back.

use crate::support::ashore::archived_bytes;
use crate::support::browser::post;
use crate::support::program::{
    Agent, Server, add_admin, agent_program, link_token, logged, script_token, until,
};
use imc::PacketView;
use imc::messages::{LogBookEntry, Payload as _};
use serde_json::{Value, json};
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

/// Lines of a log with this number, and this text.
fn has(log: &str, number: u64, words: &str) -> bool {
    let number = number.to_string();
    log.lines().any(|line| line.contains(&number) && line.contains(words))
}

/// The audit log, as it is kept.
fn audited(data: &Path) -> String {
    let database = rusqlite::Connection::open(data.join("app.db")).unwrap();
    let mut lines = database.prepare("SELECT action || ' ' || subject || ' ' || outcome FROM audit").unwrap();
    let lines = lines.query_map([], |row| row.get::<_, String>(0)).unwrap();
    lines.map(|line| line.unwrap() + "\n").collect()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn one_number_tells_what_became_of_a_command_ashore_and_aboard() {
    let Some(program) = agent_program() else { return };
    let (shore, aboard) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let data = shore.path().join("data");
    let mut server = Server::start(&data);
    add_admin(&data, "nils", "seven small boats");
    let script = script_token(&data);
    let token = link_token(&data, "otter-1", "0x2810");
    let mut command = Command::new(&program);
    command.env("LUTRA_LOG", "info");
    let mut agent = Agent::start_by(command, aboard.path(), server.web, &token);
    until("sailing", || (archived_bytes(&data) > 20_000).then_some(())).await;

    let say = |path: &str, body: Value| post(server.web, &format!("/vessels/10256/{path}"), &script, &body);
    say("lease", json!({"action": "request"}));
    let order = json!({"kind": "goto", "lat_deg": 63.4420, "lon_deg": 10.3800, "speed_mps": 1.0});
    let started = say("commands", json!({"order": order}))["id"].as_u64().unwrap();
    until("begun", || has(&server.log(), started, "effect seen").then_some(())).await;
    let stopped = post(server.web, "/vessels/10256/abort", &script, &json!({}))["id"].as_u64().unwrap();
    until("stopped", || has(&server.log(), stopped, "effect seen").then_some(())).await;
    agent.process.terminate();
    server.process.terminate();

    let (ashore, by_agent, audit) = (server.log(), agent.errors(), audited(&data));
    for (number, issued, verb, led_to) in [
        (started, "a command is issued", "goto", "plan initializing"),
        (stopped, "stop", "vessel.abort", "stopped by"),
    ] {
        for words in [issued, "sent on the link", "the vessel has it", "stage=\"sent\"", "stage=\"received\""]
        {
            assert!(has(&ashore, number, words), "{words} of {number}:\n{ashore}");
        }
        for words in ["a command came", "a command is answered", "outcome=\"received\"", led_to] {
            assert!(has(&by_agent, number, words), "{words} of {number}:\n{by_agent}");
        }
        for words in ["asked", "sent", "received"] {
            assert!(
                has(&audit, number, &format!("{verb} ")) && has(&audit, number, words),
                "{words}: {audit}"
            );
        }
        let entries = logged(aboard.path()).into_iter().filter_map(|packet| {
            let view = PacketView::new(&packet).ok().filter(|view| view.id() == LogBookEntry::ID)?;
            let entry = imc::decode::<LogBookEntry>(&view).ok()??;
            let text = entry.text.to_str_lossy().into_owned();
            let (text, named) = imc::logbook::split_command(&text);
            (named == Some(number)).then(|| text.to_owned())
        });
        let entries: Vec<String> = entries.collect();
        assert!(entries.iter().any(|text| text.contains(led_to)), "{entries:?}");
    }
    assert!(!has(&ashore, stopped + 1, "") && !has(&by_agent, stopped + 1, ""));
}
