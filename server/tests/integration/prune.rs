//! Automatic removal of old recordings: only what the backup holds, and no season by a wrong clock. Each of a shore's more
//! than hundred days is synced separately as it is recorded, which takes some seconds.

use crate::support::program::{SERVER, Server, run};
use imc::messages::Temperature;
use imc::{Address, Header};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use store::{Accepted, LinkSeq, Store, Transport};
use units::UtcTime;

const DAY_US: i64 = 86_400_000_000;
/// 1970-01-02, in days before 2026-11-21; and a clock that is five years ahead.
const AT_1970: i64 = 20_777;
const FIVE_YEARS_AHEAD: i64 = -5 * 365;

/// A shore with a day of recordings for each of these, and a configured backup.
struct Shore {
    scratch: tempfile::TempDir,
}

impl Shore {
    fn with_days_ago(days_ago: impl IntoIterator<Item = i64>) -> Self {
        let shore = Self { scratch: tempfile::tempdir().unwrap() };
        let mut store = Store::open(&shore.data()).unwrap();
        let now = shore::clock::now().micros();
        for (seq, days_ago) in (0..).zip(days_ago) {
            let received = UtcTime::from_micros(now - days_ago * DAY_US);
            let header = Header {
                timestamp: received.seconds(),
                src: Address(0x2810),
                src_ent: 5,
                ..Header::default()
            };
            let mut packet = Vec::new();
            imc::encode_into(&mut packet, &header, &Temperature { value: seq as f32 }).unwrap();
            let link = Some(LinkSeq { stream: 7, seq });
            store.accept(&Accepted { packet: &packet, received, transport: Transport::Link, link }).unwrap();
        }
        store.close().unwrap();
        shore.configure("archive_days = 100");
        shore
    }

    fn at(&self, name: &str) -> PathBuf {
        self.scratch.path().join(name)
    }

    fn data(&self) -> PathBuf {
        self.at("data")
    }

    fn configure(&self, keep: &str) {
        let text = format!(
            "[backup]\nfolder = '{}'\non_any_disk = true\n[retention]\n{keep}\n",
            self.at("backup").display()
        );
        fs::write(self.at("server.toml"), text).unwrap();
    }

    fn back_up(&self) {
        run(&self.data(), &["backup", "--config", self.at("server.toml").to_str().unwrap()]);
    }

    fn prune(&self, more: &str) -> Output {
        let mut command = Command::new(SERVER);
        command.args(["prune", "--as-configured", more, "--config"]).arg(self.at("server.toml"));
        command.arg("--data").arg(self.data()).output().unwrap()
    }

    /// Exit code and output of the timer's command.
    fn pruned(&self, more: &str) -> (Option<i32>, String) {
        let output = self.prune(more);
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    }

    fn days(&self) -> Vec<String> {
        let entries = fs::read_dir(self.data().join("archive/0x2810")).unwrap();
        let mut days: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        days.sort();
        days
    }
}

#[test]
fn what_the_backup_holds_goes_and_a_timer_is_told_all_else_by_its_code() {
    let shore = Shore::with_days_ago((0..60).chain(300..360));
    shore.configure("");
    let (code, told) = shore.pruned("--check");
    assert!(code == Some(1) && told.contains("[retention]"), "{code:?} {told}");
    shore.configure("archive_days = 120");
    let (code, told) = shore.pruned("--check");
    assert!(code == Some(1) && told.contains("no recordings are old enough"), "{code:?} {told}");
    // An invalid configuration must not count as "nothing to do".
    shore.configure("archive_days = 36");
    let (code, told) = shore.pruned("--check");
    assert!(code == Some(255) && told.contains("90 and more"), "{code:?} {told}");
    shore.configure("archive_days = 100");
    for more in ["--check", "--yes"] {
        let (code, told) = shore.pruned(more);
        assert!(
            code == Some(255) && told.contains("no recordings are deleted without a backup"),
            "{code:?} {told}"
        );
    }
    shore.back_up();
    let mut server = Server::start(&shore.data());
    assert_eq!(shore.pruned("--check").0, Some(0));
    let (code, told) = shore.pruned("--yes");
    assert!(code == Some(255) && shore.days().len() == 120, "beside a running server: {told}");
    server.process.terminate();

    // The backup has different bytes of one day.
    let file = shore.at("backup/archive/0x2810").join(&shore.days()[3]).join("Data.lsf");
    let whole = fs::read(&file).unwrap();
    fs::remove_file(&file).unwrap();
    fs::write(&file, vec![0; whole.len()]).unwrap();
    for more in ["--check", "--yes"] {
        let (code, told) = shore.pruned(more);
        assert!(code == Some(255) && told.contains("Data.lsf is damaged in it"), "{code:?} {told}");
    }
    fs::write(&file, whole).unwrap();
    let stay = shore.days().split_off(20);
    assert_eq!(shore.pruned("--yes").0, Some(0));
    assert_eq!(shore.days(), stay);
    assert_eq!((shore.pruned("--check").0, shore.pruned("--yes").0), (Some(1), Some(0)));
    // It comes back.
    let back = shore.at("back");
    shore.back_up();
    run(&back, &["restore", shore.at("backup").to_str().unwrap()]);
    assert_eq!(fs::read_dir(back.join("archive/0x2810")).unwrap().count(), 120);
}

#[test]
fn a_folder_is_no_backup_of_itself() {
    let shore = Shore::with_days_ago(0..110);
    shore.back_up();
    // As if the backup were used as the data folder: each file would be held by itself.
    fs::copy(shore.at("backup/backup.json"), shore.data().join("backup.json")).unwrap();
    fs::remove_dir_all(shore.at("backup")).unwrap();
    std::os::unix::fs::symlink(shore.data(), shore.at("backup")).unwrap();
    let (code, told) = shore.pruned("--yes");
    assert!(code == Some(255) && told.contains("no second copy"), "{code:?} {told}");
    assert_eq!(shore.days().len(), 110);
}

#[test]
fn no_wrong_clock_takes_a_season() {
    let shore = Shore::with_days_ago((0..110).chain([FIVE_YEARS_AHEAD, AT_1970]));
    shore.back_up();
    let (code, told) = shore.pruned("--yes");
    assert_eq!(code, Some(0), "{told}");
    let days = shore.days();
    assert_eq!(days.len(), 102, "a hundred and the two that cannot be");
    let (first, last) = (&days[0], &days[101]);
    assert!(first.starts_with("1970") && told.contains(first) && told.contains(last), "{told}");
    assert!(told.contains("these dates cannot be right"), "{told}");
}

#[test]
fn more_than_waiting_explains_needs_a_person_whom_the_doctor_tells_before() {
    let shore = Shore::with_days_ago((0..140).map(|ago| ago * 2));
    shore.back_up();
    shore.configure("archive_days = 90");
    let (code, told) = shore.pruned("--yes");
    assert!(code == Some(255) && told.contains("50 of 140 days of the archive would go"), "{code:?} {told}");
    assert!(told.contains("no more than 46") && told.contains("--archive-before 20"), "{told}");
    assert_eq!(shore.days().len(), 140);
    let config = shore.at("server.toml");
    let doctor = |data: &Path| {
        let output =
            Command::new(SERVER).args(["doctor", "--config"]).arg(&config).arg("--data").arg(data).output();
        let text = String::from_utf8_lossy(&output.unwrap().stdout).into_owned();
        text.lines().find(|line| line.contains("retention")).unwrap().to_owned()
    };
    let told = doctor(&shore.data());
    assert!(told.starts_with("WARN") && told.contains("50 of 140"), "{told}");
    // By hand, with the date that it printed.
    let date = told.split("--archive-before ").nth(1).unwrap().split(' ').next().unwrap().to_owned();
    run(&shore.data(), &["prune", "--archive-before", &date, "--yes"]);
    assert_eq!(shore.days().len(), 90);
    shore.configure("archive_days = 0");
    assert!(doctor(&shore.data()).contains("all recordings are kept"));
    shore.configure("archive_days = 90");
    assert!(doctor(&shore.data()).contains("no recordings are old enough"));
}

#[test]
fn months_of_the_history_go_likewise_and_come_back_from_the_archive() {
    let shore = Shore::with_days_ago((0..160).step_by(4));
    shore.back_up();
    let months = || {
        let entries = fs::read_dir(shore.data().join("history")).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.retain(|name| name.starts_with("20") && name.ends_with(".sqlite"));
        names.sort();
        names
    };
    let before = months();
    // All but the oldest; the newest is incomplete and does not count.
    shore.configure(&format!("history_days = {}", (before.len() - 2) * 31));
    // Files written within two seconds before a backup may have changed unnoticed.
    let settled = fs::read_dir(shore.data().join("history")).unwrap().map(|entry| entry.unwrap().path());
    for path in settled {
        let file = fs::File::options().append(true).open(&path).unwrap();
        file.set_modified(std::time::SystemTime::now() - std::time::Duration::from_mins(1)).unwrap();
    }
    shore.back_up();
    let (code, told) = shore.pruned("--yes");
    assert_eq!(code, Some(0), "{told}");
    assert_eq!(months(), before[1..]);
    run(&shore.data(), &["reindex"]);
    assert_eq!(months(), before);
}

#[test]
fn days_that_were_compressed_after_the_backup_are_held_by_it_and_go() {
    let shore = Shore::with_days_ago(0..93);
    shore.configure("archive_days = 90");
    shore.back_up();
    let compress = |more: &[&str]| {
        let mut command = Command::new(SERVER);
        command.args(["archive", "compress"]).args(more).arg("--data").arg(shore.data());
        let output = command.output().unwrap();
        let told =
            [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()).concat();
        (output.status.success(), told)
    };
    let day = shore.data().join("archive/0x2810").join(&shore.days()[0]);
    let (good, told) = compress(&["--dry-run", "--after-days", "85"]);
    assert!(good && told.contains("would compress 7 days"), "{told}");
    assert!(day.join("Data.lsf").exists() && !shore.data().join("archive/packing").exists());
    let mut server = Server::start(&shore.data());
    let (good, told) = compress(&["--after-days", "85"]);
    assert!(!good && told.contains("in use by another process"), "{told}");
    server.process.terminate();
    let (good, told) = compress(&["--after-days", "85"]);
    assert!(good && told.contains("7 days compressed"), "{told}");
    assert!(!day.join("Data.lsf").exists() && day.join("Data.lsf.zst").exists());
    let (good, told) = compress(&["--dry-run", "--after-days", "85"]);
    assert!(good && told.contains("would compress 0 days"), "{told}");
    // The plain copies in the backup hold what the compressed files hold.
    let (code, told) = shore.pruned("--yes");
    assert!(code == Some(0) && shore.days().len() == 90, "{code:?} {told}");
    // The next backup takes the compressed form of the other four, and keeps the three that are gone.
    shore.back_up();
    let kept = |name: &str| {
        let days = fs::read_dir(shore.at("backup/archive/0x2810")).unwrap();
        days.filter(|entry| entry.as_ref().unwrap().path().join(name).exists()).count()
    };
    assert_eq!((kept("Data.lsf"), kept("Data.lsf.zst")), (89, 4));
    let back = shore.at("back");
    run(&back, &["restore", shore.at("backup").to_str().unwrap()]);
    assert_eq!(Store::open(&back).unwrap().durable(7), Some(92));
}
