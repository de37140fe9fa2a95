//! A store whose process is killed in the middle of its work, again and again, or may write no more.

use crate::support::{OTTER, START_US, accept_link, archived, temperature};
use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use store::{
    MonthStep, PackStep, PackedMonth, Packing, Reader, Source, Store, TimeRange, plan_months, plan_packing,
};
use units::UtcTime;

/// Where the child writes; set only for it.
const FOLDER: &str = "LUTRA_STORE_KILL_TEST";
const STREAM: u64 = 7;
/// The same for the child that meets a limit.
const LIMITED: &str = "LUTRA_STORE_LIMIT_TEST";
const KILLS: u64 = 6;
/// The same for the child that makes a history again, and for the one that has no room for it.
const REBUILDING: &str = "LUTRA_STORE_REBUILD_TEST";
const CRAMPED: &str = "LUTRA_STORE_CRAMPED_TEST";
/// The same for the child that compresses a day and stops at the step of this name.
const COMPRESSING: &str = "LUTRA_STORE_COMPRESS_TEST";
const STOP_AT: &str = "LUTRA_STORE_STOP_AT";
/// The same for the child that compresses a month.
const SEALING: &str = "LUTRA_STORE_MONTH_TEST";
/// Acknowledgements before the process is killed: somewhere within the next commit.
const ACKNOWLEDGED: usize = 12;

fn sample(seq: u64) -> Vec<u8> {
    temperature(START_US + seq as i64 * 1_000, seq as f32)
}

/// The child: a vessel's packets without end, an acknowledgement on standard output for each commit.
#[test]
fn child() {
    let Some(folder) = std::env::var_os(FOLDER) else { return };
    let mut store = Store::open(Path::new(&folder)).unwrap();
    let mut seq = store.durable(STREAM).map_or(0, |seq| seq + 1);
    loop {
        for _ in 0..500 {
            accept_link(&mut store, &sample(seq), START_US, seq);
            seq += 1;
        }
        let committed = store.sync().unwrap();
        println!("durable {}", committed.durable[0].seq);
        store.index().unwrap();
    }
}

#[test]
fn loses_nothing_acknowledged_and_opens_clean() {
    let folder = tempfile::tempdir().unwrap();
    let mut acknowledged = 0;
    for _ in 0..KILLS {
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "kill::child", "--nocapture"])
            .env(FOLDER, folder.path())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let numbers = lines.filter_map(|line| line.unwrap().strip_prefix("durable ")?.parse::<u64>().ok());
        acknowledged = numbers.take(ACKNOWLEDGED).last().unwrap();
        child.kill().unwrap();
        child.wait().unwrap();
    }
    let store = Store::open(folder.path()).unwrap();
    let durable = store.durable(STREAM).unwrap();
    assert!(durable >= acknowledged, "{durable} < {acknowledged}");
    let expected: Vec<u8> = (0..=durable).flat_map(sample).collect();
    let found = archived(folder.path(), OTTER);
    if found != expected {
        let length = sample(0).len();
        let at = found.iter().zip(&expected).take_while(|(one, other)| one == other).count();
        panic!(
            "the archive is not every packet once, in order: {} bytes for {} packets of {length} bytes; the first difference is at byte {at}, \
             in packet {}",
            found.len(),
            durable + 1,
            at / length
        );
    }
    let source = Source { system: OTTER, entity: 5, message: "Temperature".to_owned() };
    let samples = Reader::open(folder.path())
        .unwrap()
        .samples(&source, &["value"], TimeRange::ALL, usize::MAX)
        .unwrap();
    assert_eq!(samples.values[0].len() as u64, durable + 1);
    assert!(samples.values[0].iter().enumerate().all(|(at, value)| *value as usize == at));
}

/// The child under a limit on the size of files: continues until the archive cannot grow, and once more.
#[test]
fn limited_child() {
    let Some(folder) = std::env::var_os(LIMITED) else { return };
    let mut store = Store::open(Path::new(&folder)).unwrap();
    let mut seq = store.durable(STREAM).map_or(0, |seq| seq + 1);
    let mut behind = false;
    loop {
        for _ in 0..2_000 {
            accept_link(&mut store, &sample(seq), START_US, seq);
            seq += 1;
        }
        match store.commit() {
            Ok(committed) => behind |= committed.history_behind.is_some(),
            Err(error) => {
                assert!(error.is_disk_full(), "{error}");
                assert!(store.commit().is_err());
                println!("full {} {behind}", store.durable(STREAM).unwrap());
                return;
            }
        }
    }
}

#[test]
fn goes_on_where_a_limit_on_files_stopped_it() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    accept_link(&mut store, &sample(0), START_US, 0);
    store.commit().unwrap();
    store.close().unwrap();
    // 2 MiB in blocks of 512 bytes. The signal that comes with the limit is ignored, as services do.
    let output = Command::new("sh")
        .args(["-c", "trap '' XFSZ; ulimit -f 4096; exec \"$0\" --exact kill::limited_child --nocapture"])
        .arg(std::env::current_exe().unwrap())
        .env(LIMITED, folder.path())
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let told = text.lines().find_map(|line| line.strip_prefix("full "));
    let told = told.unwrap_or_else(|| panic!("{text}\n{}", String::from_utf8_lossy(&output.stderr)));
    let (durable, behind) = told.split_once(' ').unwrap();
    let durable: u64 = durable.parse().unwrap();
    assert!(durable > 10_000, "{told}");
    assert_eq!(behind, "true", "the history met the limit before the archive and said so");
    let store = Store::open(folder.path()).unwrap();
    assert_eq!(store.durable(STREAM), Some(durable));
    assert!(archived(folder.path(), OTTER) == (0..=durable).flat_map(sample).collect::<Vec<u8>>());
    let series = Reader::open(folder.path()).unwrap().series(Some(OTTER)).unwrap();
    assert_eq!(series[0].extent.count, durable + 1);
}

/// The child that makes a damaged month again while a vessel sends, until it is killed.
#[test]
fn rebuilding_child() {
    let Some(folder) = std::env::var_os(REBUILDING) else { return };
    let mut store = Store::open_at_once(Path::new(&folder)).unwrap();
    let mut seq = store.durable(STREAM).unwrap() + 1;
    loop {
        accept_link(&mut store, &sample(seq), START_US, seq);
        seq += 1;
        let committed = store.sync().unwrap();
        println!("durable {}", committed.durable[0].seq);
        store.index().unwrap();
        if store.behind().is_none() {
            println!("whole");
            return;
        }
    }
}

#[test]
fn a_rebuild_that_is_killed_again_and_again_ends_whole() {
    const PACKETS: u64 = 60_000;
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    for seq in 0..PACKETS {
        accept_link(&mut store, &sample(seq), START_US, seq);
    }
    store.close().unwrap();
    std::fs::write(folder.path().join("history/2026-11.sqlite"), "no database").unwrap();
    let mut acknowledged = PACKETS - 1;
    let mut killed = 0;
    loop {
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "kill::rebuilding_child", "--nocapture"])
            .env(REBUILDING, folder.path())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines().map(Result::unwrap);
        // Its second acknowledgement comes before its second slice.
        let mut told = lines.by_ref().filter_map(|line| line.strip_prefix("durable ")?.parse::<u64>().ok());
        if killed < KILLS {
            acknowledged = acknowledged.max(told.nth(1).unwrap_or(acknowledged));
            child.kill().unwrap();
            child.wait().unwrap();
            killed += 1;
        } else {
            acknowledged = acknowledged.max(told.last().unwrap());
            assert!(child.wait().unwrap().success());
            break;
        }
    }
    let store = Store::open_at_once(folder.path()).unwrap();
    assert_eq!((store.behind(), store.durable(STREAM)), (None, Some(acknowledged)));
    let series = Reader::open(folder.path()).unwrap().series(Some(OTTER)).unwrap();
    assert_eq!(series[0].extent.count, acknowledged + 1);
    assert!(folder.path().join("history.aside/2026-11.sqlite").exists());
}

/// The child whose disk has no room for the history that it makes again.
#[test]
fn cramped_child() {
    let Some(folder) = std::env::var_os(CRAMPED) else { return };
    let mut store = Store::open_at_once(Path::new(&folder)).unwrap();
    let first = store.durable(STREAM).unwrap() + 1;
    let mut told = String::new();
    for seq in first..first + 200 {
        accept_link(&mut store, &sample(seq), START_US, seq);
        let committed = store.commit().unwrap();
        assert_eq!(committed.durable[0].seq, seq, "recording waits for the history");
        told = committed.history_behind.unwrap_or_default();
    }
    println!("cramped {told}");
}

#[test]
fn a_rebuild_without_room_stops_no_recording_and_goes_on_with_room() {
    const PACKETS: u64 = 40_000;
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    for seq in 0..PACKETS {
        accept_link(&mut store, &sample(seq), START_US, seq);
    }
    store.close().unwrap();
    std::fs::write(folder.path().join("history/2026-11.sqlite"), "no database").unwrap();
    // 2 MiB for a file: the archive has room to grow, the history has not.
    let output = Command::new("sh")
        .args(["-c", "trap '' XFSZ; ulimit -f 4096; exec \"$0\" --exact kill::cramped_child --nocapture"])
        .arg(std::env::current_exe().unwrap())
        .env(CRAMPED, folder.path())
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let told = text.lines().find_map(|line| line.strip_prefix("cramped "));
    let told = told.unwrap_or_else(|| panic!("{text}\n{}", String::from_utf8_lossy(&output.stderr)));
    assert!(!told.is_empty(), "the history says that it is whole");
    let mut store = Store::open_at_once(folder.path()).unwrap();
    assert_eq!(store.durable(STREAM), Some(PACKETS + 199));
    store.settle().unwrap();
    let series = Reader::open(folder.path()).unwrap().series(Some(OTTER)).unwrap();
    assert_eq!((store.behind(), series[0].extent.count), (None, PACKETS + 200));
}

/// The child that compresses a day, and stands still at one step until it is killed.
#[test]
fn compressing_child() {
    let Some(folder) = std::env::var_os(COMPRESSING) else { return };
    let (folder, stop_at) = (Path::new(&folder).to_owned(), std::env::var(STOP_AT).unwrap());
    let mut store = Store::open(&folder).unwrap();
    let day = plan_packing(&folder, 3, later()).unwrap()[0];
    let steps = move |step: PackStep| {
        if format!("{step:?}") == stop_at {
            println!("stands at {step:?}");
            loop {
                std::thread::park();
            }
        }
    };
    let mut packing = Packing::begin_watched(&folder, &day, Box::new(steps)).unwrap();
    while packing.work(1 << 20).unwrap() {}
    store.adopt(&mut packing).unwrap().unwrap();
}

/// Runs a child of these tests, by the test that it is and the variable that names its folder, and kills it at a step.
fn kill_at(child: (&str, &str), folder: &Path, step: &str) {
    let mut child = stand_at(child, folder, step);
    child.kill().unwrap();
    child.wait().unwrap();
}

fn later() -> UtcTime {
    UtcTime::from_micros(START_US + 30 * 86_400_000_000)
}

#[test]
fn a_server_that_is_killed_while_it_compresses_a_day_has_all_of_it() {
    const PACKETS: u64 = 5_000;
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    for seq in 0..PACKETS {
        accept_link(&mut store, &sample(seq), START_US, seq);
    }
    accept_link(&mut store, &sample(PACKETS), START_US + 86_400_000_000, PACKETS);
    store.close().unwrap();
    // One folder goes through all steps: each run goes on with what the one before left.
    for step in PackStep::ALL {
        kill_at(("kill::compressing_child", COMPRESSING), folder.path(), &format!("{step:?}"));
        let mut log = Vec::new();
        store::export_lsf(folder.path(), &store::Selection::default(), &mut log).unwrap();
        assert!(log == (0..=PACKETS).flat_map(sample).collect::<Vec<u8>>(), "{step:?}");
        let store = Store::open(folder.path()).unwrap();
        assert_eq!((store.durable(STREAM), &store.repairs().notes), (Some(PACKETS), &Vec::new()), "{step:?}");
    }
    let day = folder.path().join("archive/0x2810/20261121");
    assert!(!day.join("Data.lsf").exists() && day.join("Data.lsf.zst").exists());
}

/// The child that compresses a month, and stands still at one step until it is killed.
#[test]
fn month_child() {
    let Some(folder) = std::env::var_os(SEALING) else { return };
    let (folder, stop_at) = (Path::new(&folder).to_owned(), std::env::var(STOP_AT).unwrap());
    let mut step = move |step: MonthStep| {
        if format!("{step:?}") == stop_at {
            println!("stands at {step:?}");
            loop {
                std::thread::park();
            }
        }
    };
    let mut store = Store::open(&folder).unwrap();
    let month = plan_months(&folder, 3, UtcTime::from_micros(START_US + 60 * 86_400_000_000)).unwrap()[0];
    assert!(store.ready_month(month.key).unwrap());
    let packed = PackedMonth::make(&folder, &month, &mut |_| {
        step(MonthStep::Begun);
        true
    });
    let packed = packed.unwrap();
    step(MonthStep::Made);
    store.adopt_month_watched(packed, &mut step).unwrap().done().unwrap();
}

/// Starts a child of these tests and waits until it stands at a step.
fn stand_at((child, variable): (&str, &str), folder: &Path, step: &str) -> std::process::Child {
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", child, "--nocapture"])
        .env(variable, folder)
        .env(STOP_AT, step)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines().map(Result::unwrap);
    assert!(lines.any(|line| line.contains("stands at")), "the child did not come to {step}");
    child
}

#[test]
fn readers_that_open_a_month_while_it_is_replaced_have_all_of_it_whether_or_not_the_server_is_killed() {
    const PACKETS: u64 = 5_000;
    let source = Source { system: OTTER, entity: 5, message: "Temperature".to_owned() };
    let count = |reader: &mut Reader| {
        let samples = reader.samples(&source, &["value"], TimeRange::ALL, 9_999).unwrap();
        assert!(samples.values[0].iter().enumerate().all(|(at, value)| *value as usize == at));
        samples.values[0].len() as u64
    };
    for step in MonthStep::ALL {
        let folder = tempfile::tempdir().unwrap();
        let mut store = Store::open(folder.path()).unwrap();
        for seq in 0..PACKETS {
            accept_link(&mut store, &sample(seq), START_US, seq);
        }
        store.close().unwrap();
        let mut child = stand_at(("kill::month_child", SEALING), folder.path(), &format!("{step:?}"));
        // At one step the month is locked: this waits then, and goes on when the process is gone.
        let reading = std::thread::scope(|scope| {
            let reading = scope.spawn(|| {
                let mut reader = Reader::open(folder.path()).unwrap();
                assert_eq!(count(&mut reader), PACKETS, "{step:?}");
                reader
            });
            child.kill().unwrap();
            child.wait().unwrap();
            reading.join().unwrap()
        });
        let mut reader = reading;
        // It stays open while the next server starts and compresses the month after all.
        let mut store = Store::open(folder.path()).unwrap();
        assert_eq!((store.behind(), &store.repairs().notes), (None, &Vec::new()), "{step:?}");
        let due =
            plan_months(folder.path(), 3, UtcTime::from_micros(START_US + 60 * 86_400_000_000)).unwrap();
        assert_eq!(due.len(), usize::from(step != MonthStep::Named), "{step:?}");
        for month in due {
            assert!(store.ready_month(month.key).unwrap());
            let packed = PackedMonth::make(folder.path(), &month, &mut |_| true).unwrap();
            let busy = store.adopt_month(packed).unwrap();
            assert!(
                matches!(busy, store::Adopted::Busy(_)),
                "{step:?}: it is replaced below a reader: {busy:?}"
            );
            assert_eq!(count(&mut reader), PACKETS, "{step:?}");
            drop(reader);
            let store::Adopted::Busy(packed) = busy else { panic!("it was busy") };
            assert!(store.adopt_month(packed).unwrap().done().is_some(), "{step:?}");
            reader = Reader::open(folder.path()).unwrap();
        }
        assert_eq!(count(&mut reader), PACKETS, "{step:?}");
    }
}

#[test]
fn a_server_that_is_killed_while_it_compresses_a_month_has_all_of_it() {
    const PACKETS: u64 = 5_000;
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    for seq in 0..PACKETS {
        accept_link(&mut store, &sample(seq), START_US, seq);
    }
    store.close().unwrap();
    let source = Source { system: OTTER, entity: 5, message: "Temperature".to_owned() };
    let month = folder.path().join("history/2026-11.sqlite");
    let is_packed = || {
        let connection = rusqlite::Connection::open(&month).unwrap();
        connection.query_row("PRAGMA user_version", (), |row| row.get::<_, i64>(0)).unwrap() == 3
    };
    for step in MonthStep::ALL {
        kill_at(("kill::month_child", SEALING), folder.path(), &format!("{step:?}"));
        let samples =
            || Reader::open(folder.path()).unwrap().samples(&source, &["value"], TimeRange::ALL, 9_999);
        assert_eq!(samples().unwrap().values[0].len() as u64, PACKETS, "{step:?}");
        assert_eq!(is_packed(), step == MonthStep::Named, "{step:?}");
        let store = Store::open(folder.path()).unwrap();
        assert_eq!((store.behind(), &store.repairs().notes), (None, &Vec::new()), "{step:?}");
        let connection = rusqlite::Connection::open(&month).unwrap();
        let form: String = connection.query_row("PRAGMA journal_mode", (), |row| row.get(0)).unwrap();
        assert_eq!(form, "wal", "{step:?}: it could be replaced below its readers");
        drop(connection);
        assert_eq!(samples().unwrap().values[0].len() as u64, PACKETS, "{step:?}");
        let litter: Vec<_> = std::fs::read_dir(folder.path().join("history"))
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .filter(|name| name.contains("packing") || name.contains("journal"))
            .collect();
        assert_eq!(litter, Vec::<String>::new(), "{step:?}");
    }
}
