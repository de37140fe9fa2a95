//! Data of earlier versions are opened, and data of later ones are left as they are.

use crate::support::OTTER;
use crate::support::archived_packets;
use crate::support::ashore::{every_number_came_once, link_numbers};
use crate::support::browser::ask;
use crate::support::program::{Agent, SERVER, Server, add_admin, agent_program, run, until};
use charts::demo::SeaFloor;
use charts::s57::GeoPoint;
use flate2::read::GzDecoder;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;
use store::Store;

/// The versions of which data are kept: `cargo xtask fixtures` makes them.
fn versions() -> Vec<PathBuf> {
    let folder = testkit::repository().join("server/tests/fixtures");
    let mut found: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    found.sort();
    found
}

fn unpack(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for path in fs::read_dir(from).unwrap().map(|entry| entry.unwrap().path()) {
        let target = to.join(path.file_name().unwrap());
        if path.is_dir() {
            unpack(&path, &target);
        } else {
            let mut file = File::create(target.with_extension("")).unwrap();
            std::io::copy(&mut GzDecoder::new(File::open(&path).unwrap()), &mut file).unwrap();
        }
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn data_of_every_version_are_opened_and_what_waits_aboard_comes_ashore() {
    let Some(program) = agent_program() else { return };
    let versions = versions();
    assert!(!versions.is_empty(), "no version's data are kept");
    for version in versions {
        let scratch = tempfile::tempdir().unwrap();
        unpack(&version, scratch.path());
        let (data, aboard) = (scratch.path().join("shore"), scratch.path().join("aboard"));
        let people = run(&data, &["user", "list"]);
        assert!(people.contains("nils"), "{people}");
        assert!(run(&data, &["vessel", "list"]).contains("otter-1"));
        assert!(run(&data, &["export", "--message", "EstimatedState"]).lines().count() > 10);
        chart_is_opened(&data);
        let before = archived_packets(&data, OTTER).len();
        let streams = link_numbers(&data);
        let (stream, numbers) = streams.iter().next().unwrap();
        let (stream, last) = (*stream, *numbers.iter().max().unwrap());
        assert_eq!(Store::open(&data).unwrap().durable(stream), Some(last));
        let mut server = Server::start(&data);
        assert_eq!(ask(server.web, "/healthz").0, 200);
        let token = fs::read_to_string(aboard.join("lutra.token")).unwrap();
        let mut agent = Agent::start(&program, &aboard, server.web, &token);
        // Packets from the spool, and new ones, have the next numbers of the same stream.
        let goes_on = || link_numbers(&data).get(&stream).is_some_and(|all| all.len() > numbers.len() + 200);
        until("what waited is ashore", || goes_on().then_some(())).await;
        agent.process.terminate();
        server.process.terminate();
        assert!(archived_packets(&data, OTTER).len() > before + 200, "{}", version.display());
        every_number_came_once(&data, 0);
    }
}

/// The chart set is read and gives depths, by its index, or by one that is made again of it.
fn chart_is_opened(data: &Path) {
    let listed = run(data, &["chart", "list", "--json"]);
    let listed: serde_json::Value = serde_json::from_str(&listed).unwrap();
    assert_eq!(listed["charts"].as_array().map(Vec::len), Some(1), "{listed}");
    let told = |at: GeoPoint| {
        let at = format!("{},{}", at.lat_deg, at.lon_deg);
        let asked = ["chart", "depth", "--at", &at, "--radius", "20", "--json"];
        serde_json::from_str::<serde_json::Value>(&run(data, &asked)).unwrap()
    };
    let start = told(SeaFloor::ORIGIN);
    assert!(
        start["water"] != "no data" && start["least_m"].as_f64().is_some_and(|deep| deep > 0.0),
        "{start}"
    );
}

#[test]
fn a_chart_set_of_another_form_is_left_as_it_is_and_what_to_do_is_said() {
    let scratch = tempfile::tempdir().unwrap();
    unpack(versions().first().unwrap(), scratch.path());
    let data = scratch.path().join("shore");
    let set = data.join("charts/chart.gpkg");
    for (schema, words) in [("900", "written by a later version"), ("0", "written by an earlier version")] {
        let sets = "UPDATE chart_set SET value = ?1 WHERE key = 'schema'";
        assert_eq!(rusqlite::Connection::open(&set).unwrap().execute(sets, [schema]).unwrap(), 1);
        let before = fs::read(&set).unwrap();
        let asked = ["chart", "list", "--data", data.to_str().unwrap()];
        let output = Command::new(SERVER).args(asked).output().unwrap();
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(
            !output.status.success() && told.contains(words) && told.contains("import the charts"),
            "{told}"
        );
        assert!(fs::read(&set).unwrap() == before, "the chart set was written to");
    }
}

/// Every file with its bytes.
fn contents(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found = Vec::new();
    for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if path.is_dir() {
            found.extend(contents(&path));
        } else {
            found.push((path.clone(), fs::read(path).unwrap()));
        }
    }
    found.sort();
    found
}

#[test]
fn an_older_program_writes_nothing_to_newer_data_and_says_what_to_do() {
    let scratch = tempfile::tempdir().unwrap();
    let data = scratch.path().join("data");
    add_admin(&data, "nils", "seven small boats");
    let mut server = Server::start(&data);
    server.process.terminate();
    let refused = |arguments: &[&str]| {
        let output = Command::new(SERVER).args(arguments).arg("--data").arg(&data).output().unwrap();
        assert!(!output.status.success(), "{arguments:?}");
        let told = [output.stdout, output.stderr].concat();
        String::from_utf8_lossy(&told).into_owned()
    };
    let log = scratch.path().join("Data.lsf");
    fs::write(&log, "").unwrap();
    let commands: [&[&str]; 6] = [
        &["serve", "--listen", "127.0.0.1:0"],
        &["user", "list"],
        &["vessel", "add", "otter-2", "0x2811"],
        &["import", log.to_str().unwrap()],
        &["reindex"],
        &["doctor", "--set", "http.listen=127.0.0.1:0"],
    ];
    let is_left_alone = |what: &str| {
        let before = contents(&data);
        for command in commands {
            let told = refused(command);
            assert!(
                told.contains(what) && told.contains("Install that version again"),
                "{command:?}: {told}"
            );
            assert!(contents(&data) == before, "{command:?} wrote something");
        }
    };
    // A later app.db: its number is raised as a later program's migration would.
    let db = data.join("app.db");
    let whole = fs::read(&db).unwrap();
    let raise = |path: &Path, version: u32| {
        let mut bytes = fs::read(path).unwrap();
        bytes[60..64].copy_from_slice(&version.to_be_bytes());
        fs::write(path, bytes).unwrap();
    };
    raise(&db, 900);
    is_left_alone("app.db was written by a newer lutra-server (schema 900");
    fs::write(&db, whole).unwrap();
    // A later archive.
    let format = data.join("archive/format.json");
    let kept = fs::read(&format).unwrap();
    fs::write(&format, r#"{"format":3,"program":"9.9.9"}"#).unwrap();
    is_left_alone("was written by Lutra 9.9.9 (form 3, this program knows 2)");
    fs::write(&format, kept).unwrap();
    // A later history blocks nothing: recording to the archive continues, and the history is left alone.
    let catalogue = data.join("history/catalogue.sqlite");
    raise(&catalogue, 900);
    let before = fs::read(&catalogue).unwrap();
    let told = refused(&["doctor", "--set", "http.listen=127.0.0.1:0"]);
    assert!(
        told.contains("BAD   history: history/catalogue.sqlite was written by a later version"),
        "{told}"
    );
    let mut server = Server::start(&data);
    assert_eq!(ask(server.web, "/healthz").0, 200);
    server.process.terminate();
    assert!(fs::read(&catalogue).unwrap() == before, "the later history was written to");
}
