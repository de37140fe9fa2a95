//! Grafana's dashboard of `docker/` uses only metrics of a real server, with existing labels.

use crate::support::browser::ask;
use crate::support::program::{Agent, Server, agent_program, link_token, until};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::process::Command;

/// Metrics that appear only after a fault or with a certain configuration: checked only against the source.
const RARE: [&str; 11] = [
    "lutra_audit_lost_total",
    "lutra_certificate_expiry_seconds",
    "lutra_certificate_trouble",
    "lutra_damaged_bytes_total",
    "lutra_http_refused_connections_total",
    "lutra_link_commands_total",
    "lutra_live_clients",
    "lutra_not_recorded_total",
    "lutra_notices_total",
    "lutra_refused_total",
    "lutra_relay_dropped_total",
];
/// As [`RARE`], of transports and sinks that must be configured.
const CONFIGURED: [&str; 4] = [
    "lutra_sink_failures_total",
    "lutra_sink_lines_total",
    "lutra_sink_waiting_bytes",
    "lutra_udp_lost_total",
];

/// The words of a text that are names of metrics.
fn names(text: &str) -> BTreeSet<String> {
    let words = text.split(|sign: char| !sign.is_ascii_alphanumeric() && sign != '_');
    words.filter(|word| word.starts_with("lutra_")).map(str::to_owned).collect()
}

/// Metrics of the dashboard, each with its labels.
fn asked() -> BTreeMap<String, BTreeSet<String>> {
    let file = testkit::repository().join("docker/grafana/dashboards/lutra.json");
    let dashboard: serde_json::Value = serde_json::from_slice(&fs::read(file).unwrap()).unwrap();
    let mut asked: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for target in dashboard["panels"].as_array().unwrap().iter().filter_map(|panel| panel.get("targets")) {
        for target in target.as_array().unwrap() {
            let (question, legend) =
                (target["expr"].as_str().unwrap(), target["legendFormat"].as_str().unwrap());
            let grouped = question.split("by (").skip(1).filter_map(|rest| rest.split(')').next());
            let shown = legend.split("{{").skip(1).filter_map(|rest| rest.split("}}").next());
            let labels = grouped.flat_map(|labels| labels.split(", ")).chain(shown).map(str::to_owned);
            let labels: BTreeSet<String> = labels.collect();
            let names = names(question);
            assert!(!names.is_empty(), "{question} asks for no figure of Lutra's");
            for name in names {
                asked.entry(name).or_default().extend(labels.iter().cloned());
            }
        }
    }
    asked
}

/// Metrics of the source with their labels.
fn written(folder: &Path, found: &mut BTreeMap<String, BTreeSet<String>>) {
    for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if path.is_dir() {
            written(&path, found);
        } else if path.extension().is_some_and(|end| end == "rs") {
            let text = fs::read_to_string(&path).unwrap();
            for rest in text.split("!(\"lutra_").skip(1) {
                let arguments = rest.split(");").next().unwrap().split("\n        .").next().unwrap();
                let mut parts = arguments.split('"');
                let name = format!("lutra_{}", parts.next().unwrap());
                let labels = arguments.rsplit("\" =>").skip(1).filter_map(|text| text.rsplit('"').next());
                found.entry(name).or_default().extend(labels.map(str::to_owned));
            }
        }
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_dashboard_asks_for_figures_that_the_server_tells() {
    let mut source = BTreeMap::new();
    for folder in ["server/src", "shore/src"] {
        written(&testkit::repository().join(folder), &mut source);
    }
    let asked = asked();
    assert!(asked.len() > 20, "{asked:?}");
    let known = |name: &str, has: &BTreeSet<String>, labels: &BTreeSet<String>| {
        assert!(labels.is_subset(has), "{name} has the labels {has:?}, the dashboard wants {labels:?}");
    };
    for (name, labels) in &asked {
        match source.get(name) {
            Some(has) => known(name, has, labels),
            None => assert!(name.starts_with("lutra_way_"), "nobody tells {name}"),
        }
    }
    let Some(program) = agent_program() else { return };
    let scratch = tempfile::tempdir().unwrap();
    let (data, aboard) = (scratch.path().join("data"), scratch.path().join("aboard"));
    fs::create_dir(&aboard).unwrap();
    let token = link_token(&data, "otter-1", "0x2810");
    let mut server = Server::start(&data);
    // A vessel with several ways: each has its figures, whose labels are looked for in what the server tells.
    let way = |name: &str| {
        let section = format!("\n[Transports.LutraWay/{name}]\nEnabled = Always\nEntity Label = {name}\n");
        format!("{section}URL = ws://{}/link\n", server.web)
    };
    let ways = way("radio") + &way("4G");
    let command = Command::new(&program);
    let _agent = Agent::start_with(command, &aboard, server.web, &token, &ways);
    let usual =
        asked.keys().filter(|name| !RARE.contains(&name.as_str()) && !CONFIGURED.contains(&name.as_str()));
    let usual: BTreeSet<String> = usual.cloned().collect();
    assert!(usual.len() >= 10, "{usual:?}");
    let missing = || {
        let (status, figures) = ask(server.web, "/metrics");
        assert_eq!(status, 200, "{figures}");
        usual.difference(&names(&figures)).cloned().collect::<Vec<_>>()
    };
    let mut lacked = Vec::new();
    until("all usual figures are told: the last of these lists is missing", || {
        let lacks = missing();
        if lacks != lacked {
            eprintln!("not told yet: {lacks:?}");
            lacked.clone_from(&lacks);
        }
        lacks.is_empty().then_some(())
    })
    .await;
    let (_, figures) = ask(server.web, "/metrics");
    for quantile in ["lutra_http_request_seconds{route=", "lutra_commit_packets{quantile=\"0.99\"}"] {
        assert!(figures.contains(quantile), "{quantile} is not in\n{figures}");
    }
    for (name, labels) in asked.iter().filter(|(name, _)| name.starts_with("lutra_way_")) {
        for way in ["radio", "4G"] {
            let ours = |line: &&str| {
                line.starts_with(&format!("{name}{{")) && line.contains(&format!("way=\"{way}\""))
            };
            let line = figures.lines().find(ours).unwrap_or_else(|| panic!("no {name} of {way}"));
            let (_, rest) = line.split_once('{').unwrap();
            let (told, _) = rest.split_once('}').unwrap();
            let has = told.split(',').map(|label| label.split('=').next().unwrap().to_owned()).collect();
            known(name, &has, labels);
        }
    }
    server.process.terminate();
}
