//! Grafana's dashboard over the API's rows: each of its questions is asked of a real server, and only data sources that are configured are
//! provided. Grafana itself is not run: neither Debian nor a registry of libraries has it.

use crate::support::program::{Server, add_admin, run};
use imc::messages::{EntityList, EntityListOp, EstimatedState, TBRFishTag, Voltage};
use imc::{Address, Header, Message, Packet};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::io::{Read as _, Write as _};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::process::Command;
use store::{Accepted, Store, Transport};
use units::UtcTime;

/// 2024-11-21 08:00 UTC.
const START_US: i64 = 1_732_176_000_000_000;

/// A minute of two boats with all that the dashboard draws.
fn fill(data: &Path) {
    let mut store = Store::open(data).unwrap();
    let mut put = |src: u16, src_ent: u8, second: i64, message: Message| {
        let received = UtcTime::from_micros(START_US + second * 1_000_000);
        let header =
            Header { timestamp: received.seconds(), src: Address(src), src_ent, ..Header::default() };
        let packet = Packet::new(header, message).encode().unwrap();
        store.accept(&Accepted { packet: &packet, received, transport: Transport::Tcp, link: None }).unwrap();
    };
    for vessel in [0x0814, 0x0815] {
        let list = EntityList { op: EntityListOp::Report, list: "Battery=2;Navigation=39".into() };
        put(vessel, 255, 0, list.into());
        for second in 0..60 {
            put(vessel, 2, second, Voltage { value: 24.0 }.into());
            put(vessel, 39, second, EstimatedState { u: 1.5, ..EstimatedState::default() }.into());
        }
        let tag = TBRFishTag {
            serial_no: 1_024,
            unix_timestamp: 1_732_176_000,
            millis: 7,
            trans_protocol: 6_u8.into(),
            trans_id: 101,
            trans_data: 5,
            snr: 20,
            lat: Some(1.107),
            lon: Some(0.181),
            ..TBRFishTag::default()
        };
        put(vessel, 9, 5, tag.into());
    }
    store.close().unwrap();
}

/// The JSON that a path gives to a token.
fn json(server: SocketAddr, path: &str, token: &str) -> Value {
    let mut stream = TcpStream::connect(server).unwrap();
    write!(stream, "GET {path} HTTP/1.0\r\nhost: {server}\r\nauthorization: Bearer {token}\r\n\r\n").unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    assert!(head.contains(" 200 "), "{path}: {head}\n{body}");
    serde_json::from_str(body).unwrap()
}

/// The address of a question of the plugin Infinity, with the dashboard's variables filled in.
fn address(query: &Value, variables: &BTreeMap<&str, String>) -> String {
    let mut address = form_urlencoded::Serializer::new(String::new());
    for parameter in query["url_options"]["params"].as_array().unwrap() {
        let mut value = parameter["value"].as_str().unwrap().to_owned();
        for (name, meaning) in variables {
            value = value.replace(name, meaning);
        }
        assert!(!value.contains('$'), "a variable that is not known here: {value}");
        address.append_pair(parameter["key"].as_str().unwrap(), &value);
    }
    assert_eq!((&query["source"], &query["url_options"]["method"]), (&"url".into(), &"GET".into()));
    format!("{}?{}", query["url"].as_str().unwrap(), address.finish())
}

/// Asks a question of the dashboard; its rows have all columns that the dashboard takes.
fn asked(server: SocketAddr, token: &str, query: &Value, variables: &BTreeMap<&str, String>) -> Vec<Value> {
    let path = address(query, variables);
    let answer = json(server, &path, token);
    let listed = match query["root_selector"].as_str() {
        Some("") | None => &answer,
        Some(selector) => &answer[selector],
    };
    let rows = listed.as_array().unwrap_or_else(|| panic!("{path} gives no list: {answer}")).clone();
    let first = rows.first().unwrap_or_else(|| panic!("{path} gives no rows"));
    for column in query["columns"].as_array().unwrap() {
        let value = &first[column["selector"].as_str().unwrap()];
        let is_right = match column["type"].as_str().unwrap() {
            "number" => value.is_number(),
            "string" => value.is_string(),
            "timestamp" => value.as_str().is_some_and(|time| time.parse::<UtcTime>().is_ok()),
            other => panic!("{other}"),
        };
        assert!(is_right, "{path}: {column} is {value}");
    }
    if query["format"] == "timeseries" {
        // The plugin makes lines only of rows that are in order of time.
        assert!(rows.is_sorted_by_key(|row| row["time"].as_str().unwrap().to_owned()), "{path}");
    }
    rows
}

/// It takes some seconds, as a server starts as a program.
#[test]
fn the_dashboard_of_rows_is_answered_in_all_its_panels() {
    let file = testkit::repository().join("docker/grafana/dashboards/rows.json");
    let dashboard: Value = serde_json::from_slice(&fs::read(file).unwrap()).unwrap();
    let data = tempfile::tempdir().unwrap();
    fill(data.path());
    add_admin(data.path(), "kari", "nine grey otters");
    let token = run(data.path(), &["token", "create", "--person", "kari", "--role", "viewer"]);
    let (token, mut server) = (token.trim(), Server::start(data.path()));
    let mut variables = BTreeMap::from([
        ("${__from}", (START_US / 1_000).to_string()),
        ("${__to}", (START_US / 1_000 + 60_000).to_string()),
        ("${tag}", "101".to_owned()),
    ]);
    for variable in dashboard["templating"]["list"].as_array().unwrap() {
        let query = &variable["query"]["infinityQuery"];
        if query.is_null() {
            continue;
        }
        let choices = asked(server.web, token, query, &variables);
        let values: Vec<&str> = choices.iter().map(|one| one["value"].as_str().unwrap()).collect();
        match variable["name"].as_str().unwrap() {
            "vessel" => {
                assert_eq!(values, ["0x0814", "0x0815"]);
                variables.insert("${vessel:csv}", values.join(","));
            }
            "series" => {
                assert!(values.contains(&"EstimatedState.39.psi"), "{values:?}");
                variables.insert("${series:csv}", "EstimatedState.39.psi,Voltage.2.value".to_owned());
            }
            other => panic!("{other}"),
        }
    }
    let panels = dashboard["panels"].as_array().unwrap();
    assert!(panels.len() > 5);
    for panel in panels {
        let rows = asked(server.web, token, &panel["targets"][0], &variables);
        for vessel in ["0x0814", "0x0815"] {
            let has = rows.iter().any(|row| row["vessel"] == vessel);
            assert!(has, "{} shows nothing of {vessel}", panel["title"]);
        }
    }
    server.process.terminate();
}

/// What `docker/grafana/start` provides where these variables are set.
fn provided(variables: &[(&str, &str)]) -> BTreeMap<String, String> {
    let folder = tempfile::tempdir().unwrap();
    let grafana = testkit::repository().join("docker/grafana");
    let to = folder.path().join("made");
    let mut command = Command::new("sh");
    command.arg(grafana.join("start")).args(["sh", "-c", "echo $LUTRA_GRAFANA_URL"]);
    command.env_clear().env("PATH", std::env::var_os("PATH").unwrap());
    command.env("LUTRA_GRAFANA_FROM", &grafana).env("LUTRA_GRAFANA_TO", &to);
    let output = command.envs(variables.iter().copied()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut files = BTreeMap::from([
        ("said".to_owned(), String::from_utf8(output.stdout).unwrap()),
        ("warned".to_owned(), String::from_utf8(output.stderr).unwrap()),
    ]);
    for part in ["provisioning/datasources", "provisioning/dashboards", "dashboards"] {
        for entry in fs::read_dir(to.join(part)).unwrap().map(Result::unwrap) {
            let name = format!("{part}/{}", entry.file_name().into_string().unwrap());
            files.insert(name, fs::read_to_string(entry.path()).unwrap());
        }
    }
    files
}

#[test]
fn a_data_source_is_provided_where_it_is_configured_alone() {
    let names = |files: &BTreeMap<String, String>, prefix: &str| {
        let names = files.keys().filter_map(|name| name.strip_prefix(prefix).map(str::to_owned));
        names.collect::<Vec<_>>()
    };
    // As the compose file hands them over where nothing is set.
    let empty = [("LUTRA_INFLUX_URL", ""), ("LUTRA_POSTGRES_HOST", ""), ("LUTRA_GRAFANA_TOKEN", "")];
    let usual = provided(&empty);
    assert_eq!(
        names(&usual, "provisioning/datasources/"),
        ["figures.yaml", "no-influx.yaml", "no-postgres.yaml", "no-rows.yaml"]
    );
    assert_eq!(names(&usual, "dashboards/"), ["lutra.json"]);
    let removed = &usual["provisioning/datasources/no-postgres.yaml"];
    assert!(removed.contains("deleteDatasources:") && removed.contains("- name: Lutra tables"), "{removed}");
    assert!(usual["provisioning/dashboards/lutra.yaml"].contains("path: /tmp/lutra/dashboards"));

    let ca = tempfile::NamedTempFile::new().unwrap();
    fs::write(ca.path(), "-----BEGIN CERTIFICATE-----").unwrap();
    let ca = ("LUTRA_GRAFANA_CA", ca.path().to_str().unwrap());
    let plugin = ("GF_INSTALL_PLUGINS", "yesoreyeram-infinity-datasource");
    let token = ("LUTRA_GRAFANA_TOKEN", "lutra_api_x");
    let full =
        provided(&[token, plugin, ca, ("LUTRA_POSTGRES_HOST", "db:5432"), ("LUTRA_INFLUX_URL", "http://i")]);
    assert_eq!(
        names(&full, "provisioning/datasources/"),
        ["figures.yaml", "influx.yaml", "postgres.yaml", "rows.yaml"]
    );
    assert_eq!(names(&full, "dashboards/"), ["lutra.json", "postgres.json", "rows.json"]);
    assert_eq!((&*full["said"], &*full["warned"]), ("https://server:8443\n", ""));
    let rows = &full["provisioning/datasources/rows.yaml"];
    assert!(rows.contains("serverName: localhost") && rows.contains("$__file{/etc/lutra/ca.pem}"), "{rows}");
    assert!(
        !full.values().any(|text| text.contains("lutra_api_x")),
        "the token stands in the environment alone"
    );

    let elsewhere = provided(&[token, ca, ("LUTRA_GRAFANA_URL", "https://boats.example.no")]);
    let rows = &elsewhere["provisioning/datasources/rows.yaml"];
    assert!(!rows.contains("serverName") && rows.contains("tlsAuthWithCACert"), "{rows}");
    assert!(elsewhere["warned"].contains("LUTRA_GRAFANA_PLUGINS does not name"), "{}", elsewhere["warned"]);
    let trusted = provided(&[token, plugin, ("LUTRA_GRAFANA_CA", "/dev/null")]);
    assert!(!trusted["provisioning/datasources/rows.yaml"].contains("tls"));
}

#[test]
fn every_source_that_a_dashboard_draws_from_is_provided() {
    let grafana = testkit::repository().join("docker/grafana");
    let read = |folder: &str| {
        let entries = fs::read_dir(grafana.join(folder)).unwrap().map(|entry| entry.unwrap().path());
        entries.map(|path| fs::read_to_string(path).unwrap()).collect::<Vec<_>>()
    };
    let sources = read("provisioning/datasources").concat();
    let dashboards = read("dashboards");
    assert_eq!(dashboards.len(), 3);
    for text in dashboards {
        let dashboard: Value = serde_json::from_str(&text).unwrap();
        for panel in dashboard["panels"].as_array().unwrap() {
            let Some(uid) = panel["datasource"]["uid"].as_str() else { continue };
            assert!(sources.contains(&format!("uid: {uid}\n")), "{uid}");
        }
    }
}
