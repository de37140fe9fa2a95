//! The package for Python and the script for R against a running server: rows with their types, downloads (in Python also cut ones that
//! go on), and a link with a password.

use crate::support::browser::post;
use crate::support::program::{Server, add_admin, run};
use imc::messages::{EstimatedState, TBRFishTag};
use imc::{Address, Header, Message, Packet};
use serde_json::{Value, json};
use std::path::Path;
use std::process::Command;
use store::{Accepted, Store, Transport};
use units::UtcTime;

/// 2024-11-21 08:00 UTC: in the past, as a dataset ends at the present.
const START_US: i64 = 1_732_176_000_000_000;
const BOAT: u16 = 0x0814;
/// Enough for files that can be cut in their middle.
const DETECTIONS: u32 = 600;
const PASSWORD: &str = "nine grey otters";

fn fill(data: &Path) {
    let mut store = Store::open(data).unwrap();
    let mut put = |time_us: i64, message: Message| {
        let received = UtcTime::from_micros(time_us);
        let header =
            Header { timestamp: received.seconds(), src: Address(BOAT), src_ent: 2, ..Header::default() };
        let packet = Packet::new(header, message).encode().unwrap();
        store.accept(&Accepted { packet: &packet, received, transport: Transport::Tcp, link: None }).unwrap();
    };
    for at in 0..DETECTIONS {
        let tag = TBRFishTag {
            serial_no: 1_024,
            unix_timestamp: 1_732_176_000 + at,
            millis: 7,
            trans_protocol: 6_u8.into(),
            trans_id: 101 + at % 2,
            snr: 20,
            trans_freq: 69,
            lat: Some(1.107),
            lon: Some(0.181),
            ..TBRFishTag::default()
        };
        put(START_US + i64::from(at) * 1_000_000, tag.into());
    }
    for at in 0..3 {
        let state = EstimatedState {
            lat: 63.44_f64.to_radians(),
            lon: 10.4_f64.to_radians(),
            ..EstimatedState::default()
        };
        put(START_US + at * 1_000_000, state.into());
    }
    store.close().unwrap();
}

/// A server with detections, a published dataset and a link to it with a password.
struct Shared {
    token: String,
    url: String,
    link: String,
    /// A link for the account of the token alone.
    for_account: String,
    dataset: String,
    _server: Server,
    _data: tempfile::TempDir,
}

impl Shared {
    fn start() -> Self {
        let data = tempfile::tempdir().unwrap();
        fill(data.path());
        add_admin(data.path(), "kari", PASSWORD);
        let token = run(data.path(), &["token", "create", "--person", "kari", "--role", "researcher"]);
        let token = token.trim().to_owned();
        let server = Server::start(data.path());
        let say = |path: &str, body: Value| post(server.web, path, &token, &body);
        say("/register", json!({"kind": "person", "name": "Nordmann, Kari", "affiliation": "NTNU"}));
        let draft = json!({
            "title": "Salmon in the fjord", "description": "Heard by one boat.", "publisher": "NTNU",
            "authors": ["Nordmann, Kari"], "query": {"vessels": [BOAT]},
        });
        let made = say("/datasets", draft);
        let dataset = made["id"].to_string();
        say(&format!("/datasets/{dataset}/publish"), json!({"revision": made["revision"]}));
        let url = format!("http://{}", server.web);
        let link = |asked: Value| {
            let made = say(&format!("/datasets/{dataset}/shares"), asked);
            format!("{url}{}", made["path"].as_str().unwrap())
        };
        let for_account = link(json!({"label": "Kari", "days": 30, "person": "kari"}));
        let link = link(json!({"label": "Ola", "days": 30, "password": PASSWORD}));
        Self { token, url, link, for_account, dataset, _server: server, _data: data }
    }

    /// Runs a script, which says at its end that all is as it should be.
    fn is_right_by(&self, script: &mut Command) {
        let output = script
            .args([&self.url, &self.link, PASSWORD, &self.dataset])
            .arg(DETECTIONS.to_string())
            .env("LUTRA_TOKEN", &self.token)
            .env("LUTRA_ACCOUNT_LINK", &self.for_account)
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success(), "{said}\n{}", String::from_utf8_lossy(&output.stderr));
        assert_eq!(said.trim(), "all as it should be");
    }
}

fn is_there(program: &str) -> bool {
    Command::new(program).arg("--version").output().is_ok()
}

/// It takes some seconds, as a server starts as a program, and Python some times.
#[test]
fn the_package_for_python_reads_everything_and_goes_on_with_what_was_cut() {
    if !is_there("python3") {
        testkit::absent(testkit::Need::Python, "apt-get install python3");
        return;
    }
    let script = testkit::repository().join("clients/python/tests/against_server.py");
    Shared::start().is_right_by(Command::new("python3").arg(script).env("PYTHONDONTWRITEBYTECODE", "1"));
}

/// It takes some seconds, as a server starts as a program, and R.
#[test]
fn the_script_for_r_reads_tables_files_datasets_and_links() {
    if !is_there("Rscript") {
        testkit::absent(testkit::Need::R, "apt-get install r-base-core");
        return;
    }
    let folder = testkit::repository().join("clients/R");
    let mut script = Command::new("Rscript");
    Shared::start().is_right_by(
        script.arg("--vanilla").arg(folder.join("tests/against_server.R")).arg(folder.join("lutra.R")),
    );
}
