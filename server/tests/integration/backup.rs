//! The data folder of a real server: its permissions, a damaged history, and backup and restore.

use crate::disk_full::Disk;
use crate::support::browser::{Browser, ask};
use crate::support::program::{SERVER, Server, add_admin, run, until};
use imc::messages::Temperature;
use imc::{Address, Header};
use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use store::{Accepted, LinkSeq, Outcome, Store, Transport};
use units::UtcTime;

/// 2026-11-21T08:00:00Z.
const START_US: i64 = 1_795_248_000_000_000;
const STREAM: u64 = 7;

fn packet(seq: u64) -> Vec<u8> {
    let time = UtcTime::from_micros(START_US + seq as i64 * 1_000);
    let header = Header { timestamp: time.seconds(), src: Address(0x2810), src_ent: 5, ..Header::default() };
    let mut bytes = Vec::new();
    imc::encode_into(&mut bytes, &header, &Temperature { value: seq as f32 }).unwrap();
    bytes
}

/// Packets of a vessel by its link, over two days.
fn fill(data: &Path, numbers: std::ops::Range<u64>) {
    fs::create_dir_all(data).unwrap();
    let mut store = Store::open(data).unwrap();
    for seq in numbers {
        let received = UtcTime::from_micros(START_US + (seq % 2) as i64 * 86_400_000_000);
        let link = Some(LinkSeq { stream: STREAM, seq });
        store.accept(&Accepted { packet: &packet(seq), received, transport: Transport::Link, link }).unwrap();
    }
    store.close().unwrap();
}

fn command(data: &Path, arguments: &[&str]) -> Output {
    Command::new(SERVER).args(arguments).arg("--data").arg(data).output().unwrap()
}

fn refused(data: &Path, arguments: &[&str]) -> String {
    let output = command(data, arguments);
    assert!(!output.status.success(), "{arguments:?} succeeds");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Everything below a folder with its permissions.
fn rights(folder: &Path) -> Vec<(PathBuf, u32)> {
    let mut found = vec![(folder.to_owned(), fs::metadata(folder).unwrap().permissions().mode() & 0o777)];
    for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if path.is_dir() {
            found.extend(rights(&path));
        } else {
            let mode = fs::metadata(&path).unwrap().permissions().mode() & 0o777;
            found.push((path, mode));
        }
    }
    found
}

fn others_reach(folder: &Path) -> Vec<(PathBuf, u32)> {
    rights(folder).into_iter().filter(|(_, mode)| mode & 0o077 != 0).collect()
}

#[test]
fn others_on_the_machine_reach_nothing() {
    let scratch = tempfile::tempdir().unwrap();
    let data = scratch.path().join("data");
    let cells = scratch.path().join("cells");
    fs::create_dir(&cells).unwrap();
    for cell in charts::demo::archipelago().unwrap() {
        fs::write(cells.join(cell.name), cell.bytes).unwrap();
    }
    run(&data, &["chart", "import", cells.to_str().unwrap()]);
    run(&data, &["tls", "init", "--name", "localhost"]);
    let log: Vec<u8> = (0..100).flat_map(packet).collect();
    fs::write(scratch.path().join("Data.lsf"), log).unwrap();
    run(&data, &["import", scratch.path().join("Data.lsf").to_str().unwrap()]);
    let mut server = Server::start(&data);
    server.process.terminate();
    assert_eq!(others_reach(&data), []);
    // A folder of an earlier version.
    for (path, _) in rights(&data) {
        let mode = if path.is_dir() { 0o755 } else { 0o644 };
        fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
    }
    let told = String::from_utf8_lossy(&command(&data, &["doctor"]).stdout).into_owned();
    assert!(told.contains("WARN  rights: "), "{told}");
    let mut server = Server::start(&data);
    assert_eq!(others_reach(&data), []);
    server.process.terminate();
    let mut server = Server::start(&data);
    server.process.terminate();
    let count = server.log().matches("could be reached by other users").count();
    assert_eq!(count, 1, "{}", server.log());
    // Exported files keep the user's own permissions.
    let out = scratch.path().join("out.csv");
    let program = format!("umask 022; exec {SERVER} export -o {} --data {}", out.display(), data.display());
    assert!(Command::new("sh").args(["-c", &program]).status().unwrap().success());
    assert_eq!(fs::metadata(out).unwrap().permissions().mode() & 0o777, 0o644);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_server_starts_on_a_damaged_history_says_so_and_makes_it_again() {
    const PACKETS: u64 = 100_000;
    let scratch = tempfile::tempdir().unwrap();
    let data = scratch.path().join("data");
    fill(&data, 0..PACKETS);
    let before = run(&data, &["export", "--message", "Temperature"]);
    add_admin(&data, "nils", "seven small boats");
    fs::write(data.join("history/2026-11.sqlite"), "no database").unwrap();
    let told = command(&data, &["doctor"]);
    let told = String::from_utf8_lossy(&told.stdout).into_owned();
    assert!(told.contains("BAD   history: history/2026-11.sqlite") && told.contains("restart"), "{told}");

    // It is killed in the middle, and continues.
    let mut server = Server::start(&data);
    server.process.kill();
    let mut server = Server::start(&data);
    let mut person = Browser::log_in(&server.web.to_string(), "nils", "seven small boats");
    assert_eq!(ask(server.web, "/healthz").0, 200, "it records");
    assert!(server.log().contains("history/2026-11.sqlite is damaged"), "{}", server.log());
    until("whole", || person.get("/api/v1/recording").contains("\"history_behind\":null").then_some(()))
        .await;
    let page = person.get("/admin/storage");
    assert!(page.contains("history.aside"), "the page does not tell what lies aside");
    server.process.terminate();
    assert!(run(&data, &["export", "--message", "Temperature"]) == before, "the history is another one");
    let told = command(&data, &["doctor", "--thorough", "--set", "http.listen=127.0.0.1:0"]);
    let told = String::from_utf8_lossy(&told.stdout).into_owned();
    let is_bad = |line: &str| line.starts_with("BAD   history") || line.starts_with("BAD   archive");
    assert!(!told.lines().any(is_bad), "{told}");
}

/// Path of a file in a backup: rewritten files alternate between two places.
fn lies(backup: &Path, file: &str) -> PathBuf {
    let other = backup.join("alternate").join(file);
    if other.exists() { other } else { backup.join(file) }
}

#[test]
fn a_backup_of_a_running_server_comes_back_whole_or_not_at_all() {
    let scratch = tempfile::tempdir().unwrap();
    let at = |name: &str| scratch.path().join(name);
    let (data, backup, back) = (at("data"), at("backup"), at("back"));
    let to = backup.to_str().unwrap();
    fill(&data, 0..500);
    add_admin(&data, "nils", "seven small boats");
    run(&data, &["vessel", "add", "otter-1", "0x2810"]);
    run(&data, &["tls", "init", "--name", "localhost"]);
    fs::create_dir_all(data.join("charts")).unwrap();
    fs::write(data.join("charts/aboard.json"), "{}").unwrap();
    fs::create_dir_all(data.join("logbook")).unwrap();
    fs::write(data.join("logbook/1"), "a photo").unwrap();
    let config = at("server.toml");
    fs::write(&config, "[imc]\nname = \"shore\"\n").unwrap();
    let mut server = Server::start(&data);
    for _ in 0..2 {
        run(&data, &["--config", config.to_str().unwrap(), "backup", to]);
    }
    server.process.terminate();

    run(&back, &["restore", to]);
    assert_eq!(others_reach(&back), []);
    for question in [&["export"] as &[&str], &["vessel", "list"], &["user", "list"], &["token", "list"]] {
        assert!(run(&back, question) == run(&data, question), "{question:?} has another answer");
    }
    for file in ["tls/ca.pem", "tls/ca-key.pem", "tls/server.pem", "charts/aboard.json", "logbook/1"] {
        assert_eq!(fs::read(back.join(file)).unwrap(), fs::read(data.join(file)).unwrap(), "{file}");
    }
    assert!(back.join("archive/0x2810/20261121/IMC.xml.gz").exists(), "the definitions are not there");
    assert!(back.join("outside/1-server.toml").exists());
    let durable = |folder: &Path| Store::open(folder).unwrap().durable(STREAM);
    assert_eq!((durable(&back), durable(&data)), (Some(499), Some(499)));
    let mut again = Server::start(&back);
    assert_eq!(ask(again.web, "/healthz").0, 200);
    again.process.terminate();

    // A folder that is not empty is not touched.
    let text = refused(&back, &["restore", to]);
    assert!(text.contains("is not empty"), "{text}");
    // One damaged byte, one missing file, no manifest: nothing appears.
    let key = lies(&backup, "tls/ca-key.pem");
    let whole = fs::read(&key).unwrap();
    let mut damaged = whole.clone();
    damaged[40] ^= 1;
    let nothing = at("nothing");
    let nothing_appears = |named: &str| {
        let text = refused(&nothing, &["restore", to]);
        assert!(text.contains(named), "{text}");
        assert!(!nothing.exists() && !at("nothing.restoring").exists());
    };
    fs::write(&key, damaged).unwrap();
    nothing_appears("tls/ca-key.pem: holds other bytes");
    fs::remove_file(&key).unwrap();
    nothing_appears("tls/ca-key.pem: is not there");
    fs::write(&key, whole).unwrap();
    let manifest = fs::read_to_string(backup.join("backup.json")).unwrap();
    fs::write(backup.join("backup.json"), manifest.replace("tls/ca-key.pem", "../ca-key.pem")).unwrap();
    nothing_appears("leads out of the backup");
    fs::remove_file(backup.join("backup.json")).unwrap();
    nothing_appears("is not a whole backup");
    // The history is derived: a damaged file of it is rebuilt.
    fs::write(backup.join("backup.json"), manifest).unwrap();
    fs::write(lies(&backup, "history/2026-11.sqlite"), "no database").unwrap();
    run(&nothing, &["restore", to]);
    let mut server = Server::start(&nothing);
    server.process.terminate();
    assert!(run(&nothing, &["export"]) == run(&data, &["export"]));
}

#[test]
fn after_an_older_backup_vessels_go_on_where_they_are_and_the_old_archive_fills_the_rest() {
    let scratch = tempfile::tempdir().unwrap();
    let (data, backup, back) =
        (scratch.path().join("data"), scratch.path().join("backup"), scratch.path().join("back"));
    fill(&data, 0..100);
    run(&data, &["backup", backup.to_str().unwrap()]);
    // The vessel continues, is acknowledged and deletes its packets; then this shore is lost.
    fill(&data, 100..200);
    run(&back, &["restore", backup.to_str().unwrap()]);
    let mut store = Store::open(&back).unwrap();
    assert_eq!(store.durable(STREAM), Some(99), "what was linked grew on, and is not part of the backup");
    // The vessel declares 100 to 199 as acknowledged before, and sends the following ones.
    let (after, received) = (packet(200), UtcTime::from_micros(START_US + 3 * 86_400_000_000));
    let accepted = Accepted {
        packet: &after,
        received,
        transport: Transport::Link,
        link: Some(LinkSeq { stream: STREAM, seq: 200 }),
    };
    assert_eq!(store.accept(&accepted).unwrap(), Outcome::Recorded);
    assert_eq!(store.commit().unwrap().durable, [LinkSeq { stream: STREAM, seq: 200 }]);
    store.close().unwrap();
    let samples = |folder: &Path| run(folder, &["export", "--message", "Temperature"]).lines().count() - 1;
    assert_eq!(samples(&back), 101);
    // An import of the lost shore's readable files adds them, none twice.
    let text = run(&back, &["import", data.join("archive").to_str().unwrap()]);
    assert!(text.contains("200 packets, 100 new"), "{text}");
    assert_eq!(samples(&back), 201);
    assert_eq!(Store::open(&back).unwrap().durable(STREAM), Some(200));
}

#[test]
fn the_home_of_somebody_is_no_data_folder_and_is_left_as_it_is() {
    let scratch = tempfile::tempdir().unwrap();
    let home = scratch.path().join("home");
    fs::create_dir_all(home.join("sub")).unwrap();
    for (name, mode) in [("letter.txt", 0o644), ("sub/script.sh", 0o755)] {
        fs::write(home.join(name), "x").unwrap();
        fs::set_permissions(home.join(name), fs::Permissions::from_mode(mode)).unwrap();
    }
    // Our names are also used by others.
    fs::create_dir(home.join("archive")).unwrap();
    fs::create_dir(home.join("tls")).unwrap();
    fs::write(home.join("archive/old.txt"), "x").unwrap();
    let before = rights(&home);
    let log = scratch.path().join("Data.lsf");
    fs::write(&log, packet(0)).unwrap();
    for arguments in [
        &["serve", "--listen", "127.0.0.1:0"] as &[&str],
        &["user", "add", "nils"],
        &["token", "list"],
        &["vessel", "list"],
        &["tls", "init"],
        &["import", log.to_str().unwrap()],
        &["reindex"],
        &["export"],
        &["backup", "elsewhere"],
        &["prune", "--archive-before", "2020-01-01", "--yes"],
        &["chart", "import", log.to_str().unwrap()],
    ] {
        let told = refused(&home, arguments);
        assert!(
            told.contains(&format!("{} is not a folder of Lutra's", home.display())),
            "{arguments:?}: {told}"
        );
        assert!(told.contains("choose an empty or a new folder, or that of a server"), "{told}");
    }
    let told = command(&home, &["doctor"]);
    let told = String::from_utf8_lossy(&told.stdout).into_owned();
    assert!(told.contains("BAD   data folder: ") && told.contains("is not a folder of Lutra's"), "{told}");
    // Nor does a backup go there.
    let data = scratch.path().join("data");
    fill(&data, 0..10);
    let told = refused(&data, &["backup", home.to_str().unwrap()]);
    assert!(told.contains("is not a folder of Lutra's"), "{told}");
    assert!(rights(&home) == before, "{:?}", rights(&home));
}

#[test]
fn what_cannot_be_backed_up_or_restored_is_named_and_leaves_nothing() {
    let scratch = tempfile::tempdir().unwrap();
    let at = |name: &str| scratch.path().join(name);
    let (data, backup) = (at("data"), at("backup"));
    fill(&data, 0..10);
    let told = run(&data, &["backup", backup.to_str().unwrap()]);
    assert!(told.contains("into a folder that is empty or not there yet"), "{told}");
    let way = format!("lutra-server restore {} --data DIR", backup.display());
    assert!(told.contains(&way) && !told.contains(&format!("--data {}", data.display())), "{told}");
    for inside in ["data/inside", "data/in/side", "backup/../data/inside"] {
        let told = refused(&data, &["backup", at(inside).to_str().unwrap()]);
        assert!(told.contains("must go to another folder"), "{inside}: {told}");
    }
    assert!(!data.join("inside").exists() && !data.join("in").exists());
    fs::write(at("file"), "x").unwrap();
    for impossible in ["file/new", "/proc/nowhere/new"] {
        let path = at(impossible);
        let told = refused(&path, &["restore", backup.to_str().unwrap()]);
        assert!(told.contains(path.to_str().unwrap()), "{told}");
    }
    let told = refused(&data, &["serve", "--listen", "8080"]);
    assert!(told.contains("like 127.0.0.1:8080"), "{told}");
}

#[test]
fn a_disk_that_is_mounted_already_takes_a_restore() {
    let Some(disk) = Disk::mount() else { return };
    let scratch = tempfile::tempdir().unwrap();
    let (data, backup) = (scratch.path().join("data"), scratch.path().join("backup"));
    fill(&data, 0..50);
    run(&data, &["backup", backup.to_str().unwrap()]);
    fs::create_dir(disk.data().join("lost+found")).unwrap();
    let told = run(&disk.data(), &["restore", backup.to_str().unwrap()]);
    assert!(told.contains("recorded from"), "{told}");
    assert_eq!(Store::open(&disk.data()).unwrap().durable(STREAM), Some(49));
    assert!(run(&disk.data(), &["export"]) == run(&data, &["export"]));
}
