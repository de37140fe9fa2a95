//! Rebuilding, retention, backup and checks of a store.

use crate::support::{OTTER, START_US, accept, accept_link, archived, dump, packet, state, temperature, utc};
use store::{
    BackupFile, Changes, Gap, GapKind, Health, Numbers, Outcome, Reader, Retention, Source, Store,
    StoreError, TimeRange, Transport, backup_files, copy_database, covered, doctor, reindex,
};

const DAY_US: i64 = 86_400_000_000;

/// Three days of two months, with resends and late data, some of it through the record lane.
fn fill(store: &mut Store, samples: i64) {
    for at in 0..samples {
        let time_us = START_US - at * 40 * DAY_US / samples;
        let received_us = START_US + at % 3 * DAY_US;
        accept(store, &temperature(time_us, at as f32), received_us, Transport::Tcp);
        accept_link(store, &packet(time_us, 39, &state(at as f32)), received_us, at as u64);
        if at % 100 == 7 {
            accept(store, &temperature(time_us, at as f32), received_us, Transport::Udp);
            store.commit().unwrap();
        }
    }
    store.commit().unwrap();
}

#[test]
fn rebuilding_gives_the_same_history() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    fill(&mut store, 1_000);
    assert!(matches!(reindex(folder.path(), false, &mut |_| true), Err(StoreError::Locked { .. })));
    store.settle().unwrap();
    store.close().unwrap();
    let before = dump(folder.path());
    assert!(before.len() > 2_000);
    let rebuilt = reindex(folder.path(), false, &mut |_| true).unwrap();
    assert_eq!((rebuilt.samples, rebuilt.before), (2_000, 2_000));
    assert!(dump(folder.path()) == before, "the rebuilt history differs");
    let store = Store::open(folder.path()).unwrap();
    assert_eq!((store.durable(7), store.repairs().replayed), (Some(999), 0));
}

#[test]
fn a_rebuild_that_was_stopped_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    fill(&mut store, 300);
    store.settle().unwrap();
    store.close().unwrap();
    let before = dump(folder.path());
    assert!(matches!(reindex(folder.path(), false, &mut |_| false), Err(StoreError::Cancelled)));
    assert!(dump(folder.path()) == before, "the history that is asked changed");
    let checks = doctor(folder.path(), utc(START_US), false, &mut |_| true).unwrap();
    assert!(checks.iter().any(|check| check.name == "reindex" && check.health == Health::Warning));
    reindex(folder.path(), false, &mut |_| true).unwrap();
    assert!(dump(folder.path()) == before);
}

#[test]
fn what_only_the_history_holds_is_not_given_up_by_accident() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    fill(&mut store, 300);
    let gone = store
        .retain(&Retention { archive_before: Some(utc(START_US + DAY_US)), ..Retention::default() })
        .unwrap();
    assert_eq!(gone.len(), 1, "{gone:?}");
    assert!(gone[0].bytes > 0 && !gone[0].path.exists());
    store.close().unwrap();
    let refused = reindex(folder.path(), false, &mut |_| true).unwrap_err().to_string();
    assert!(refused.contains("days were removed"), "{refused}");
    let rebuilt = reindex(folder.path(), true, &mut |_| true).unwrap();
    assert!(rebuilt.samples < rebuilt.before && rebuilt.samples > 0);
}

#[test]
fn a_record_lane_goes_on_after_its_first_day_was_given_up() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    for at in 0..30_i64 {
        let time_us = START_US + at * DAY_US / 10;
        accept_link(&mut store, &temperature(time_us, 1.0), time_us, at as u64);
        store.commit().unwrap();
    }
    let gone = store
        .retain(&Retention { archive_before: Some(utc(START_US + DAY_US)), ..Retention::default() })
        .unwrap();
    assert_eq!(gone.len(), 1);
    // The shore's clock steps back into the day that is gone.
    accept_link(&mut store, &temperature(START_US + 7, 1.0), START_US + 7, 30);
    store.commit().unwrap();
    assert!(archived(folder.path(), OTTER).starts_with(&temperature(START_US + 7, 1.0)));
    store.close().unwrap();
    assert_eq!(Store::open(folder.path()).unwrap().repairs().notes, Vec::<String>::new());
    reindex(folder.path(), true, &mut |_| true).unwrap();
    let store = Store::open(folder.path()).unwrap();
    assert_eq!(store.durable(7), Some(30), "the vessel would send what it no longer has");
}

#[test]
fn old_months_go_and_can_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    fill(&mut store, 300);
    let before = dump(folder.path());
    // 2026-11-01.
    let november = utc(1_793_491_200_000_000);
    let gone = store.retain(&Retention { history_before: Some(november), ..Retention::default() }).unwrap();
    assert_eq!(gone.iter().filter(|one| one.path.ends_with("2026-10.sqlite")).count(), 1);
    let mut reader = Reader::open(folder.path()).unwrap();
    let source = Source { system: OTTER, entity: 5, message: "Temperature".to_owned() };
    let left = reader.samples(&source, &["value"], TimeRange::ALL, 1_000).unwrap().time_us;
    assert!(left.iter().all(|time_us| *time_us >= november.micros()) && left.len() > 50);
    // It continues to work, and the archive restores them.
    accept(&mut store, &temperature(START_US + 5, 1.0), START_US, Transport::Tcp);
    store.commit().unwrap();
    store.close().unwrap();
    reindex(folder.path(), false, &mut |_| true).unwrap();
    assert!(dump(folder.path()).len() > before.len());
}

#[test]
fn a_backup_opens_as_a_store_while_the_writer_goes_on() {
    let (folder, copy) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let mut store = Store::open(folder.path()).unwrap();
    fill(&mut store, 300);
    let files = backup_files(folder.path()).unwrap();
    assert!(files.iter().filter(|file| file.changes == Changes::Database).count() >= 3, "{files:?}");
    assert!(files.iter().any(|file| file.changes == Changes::Grows { now: true }), "{files:?}");
    for BackupFile { path, changes } in files {
        let (from, to) = (folder.path().join(&path), copy.path().join(&path));
        std::fs::create_dir_all(to.parent().unwrap()).unwrap();
        match changes {
            Changes::Database => copy_database(&from, &to, &mut || true).unwrap(),
            Changes::Grows { .. } | Changes::Whole => drop(std::fs::copy(from, to).unwrap()),
        }
    }
    let covered = covered(copy.path()).unwrap();
    assert!(
        covered.iter().any(|one| one.system == OTTER && one.from < one.to && one.days > 1),
        "{covered:?}"
    );
    let archive = archived(folder.path(), OTTER);
    // Packets after the copy are not part of it.
    accept(&mut store, &temperature(START_US + 77, 5.0), START_US + 2 * DAY_US, Transport::Tcp);
    store.commit().unwrap();
    let mut restored = Store::open(copy.path()).unwrap();
    restored.settle().unwrap();
    assert!(archived(copy.path(), OTTER) == archive);
    let samples = |data| {
        let mut reader = Reader::open(data).unwrap();
        reader.series(None).unwrap().iter().map(|series| series.extent.count).sum::<u64>()
    };
    assert_eq!((samples(copy.path()), samples(folder.path())), (600, 601));
}

#[test]
fn the_doctor_finds_what_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    fill(&mut store, 300);
    accept(&mut store, &temperature(1_000, 1.0), START_US, Transport::Tcp);
    store.close().unwrap();
    let look = |now_us| doctor(folder.path(), utc(now_us), true, &mut |_| true).unwrap();
    let found = |name: &str, text: &str| {
        let checks = look(START_US);
        let check = checks.iter().find(|check| check.name == name && check.found.contains(text));
        check.unwrap_or_else(|| panic!("{checks:#?}")).health
    };
    assert_eq!(found("clocks", "no believable time"), Health::Warning);
    assert_eq!(found("writer", "no process"), Health::Good);
    assert!(look(START_US).iter().all(|check| check.health < Health::Problem));
    assert!(look(START_US - DAY_US).iter().any(|check| check.found.contains("ahead of this clock")));
    // A flipped bit inside the archive, and a file that is not a database.
    let data = folder.path().join("archive/0x2810/20261121/Data.lsf");
    let mut bytes = std::fs::read(&data).unwrap();
    bytes[100] ^= 1;
    std::fs::write(&data, bytes).unwrap();
    std::fs::write(folder.path().join("history/2026-10.sqlite"), "no database").unwrap();
    assert_eq!(found("archive", "are damaged"), Health::Problem);
    assert_eq!(found("history", "2026-10.sqlite"), Health::Problem);
}

#[test]
fn a_history_that_cannot_be_written_costs_nothing_but_time() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    let obstacle = folder.path().join("history/2026-11.sqlite");
    std::fs::create_dir(&obstacle).unwrap();
    for at in 0..50 {
        accept_link(&mut store, &temperature(START_US + at, 1.0), START_US, at as u64);
        let committed = store.commit().unwrap();
        assert_eq!(committed.durable.first().map(|link| link.seq), Some(at as u64), "it is in the archive");
        assert!(committed.history_behind.unwrap().contains("2026-11.sqlite"));
    }
    std::fs::remove_dir(&obstacle).unwrap();
    accept_link(&mut store, &temperature(START_US + 50, 1.0), START_US, 50);
    let committed = store.commit().unwrap();
    assert_eq!((committed.packets, committed.rows, committed.history_behind), (1, 51, None));
    accept_link(&mut store, &temperature(START_US + 51, 1.0), START_US, 51);
    assert_eq!(store.commit().unwrap().rows, 1);
}

#[test]
fn the_documented_questions_have_answers() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    for at in 0..20 {
        let time_us = START_US + at * 1_000_000;
        accept(&mut store, &temperature(time_us, at as f32), time_us, Transport::Tcp);
        accept(&mut store, &packet(time_us, 39, &state(at as f32)), time_us, Transport::Tcp);
    }
    store.commit().unwrap();
    store.settle().unwrap();
    let history = folder.path().join("history");
    let connection = rusqlite::Connection::open(history.join("2026-11.sqlite")).unwrap();
    let catalogue = history.join("catalogue.sqlite");
    connection.execute("ATTACH ?1 AS catalogue", [catalogue.to_str().unwrap()]).unwrap();
    let text = std::fs::read_to_string(testkit::repository().join("docs/history.md")).unwrap();
    let questions: Vec<&str> =
        text.split("```sql").skip(1).map(|rest| rest.split("```").next().unwrap()).collect();
    let answers: Vec<usize> = questions
        .iter()
        .map(|sql| connection.prepare(sql).unwrap().query_map((), |_| Ok(())).unwrap().count())
        .collect();
    assert_eq!(answers, [20, 2, 1], "{questions:#?}");
}

#[test]
fn declared_gaps_are_told_and_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    let gap = Gap {
        system: OTTER,
        from: utc(START_US),
        to: utc(START_US + 60_000_000),
        kind: GapKind::NotDelivered,
        reason: "out of \"range\"".to_owned(),
        packets: None,
        numbers: None,
        declared: utc(START_US + 61_000_000),
    };
    store.declare_gap(&gap).unwrap();
    let lost = Gap { kind: GapKind::Lost, declared: utc(START_US + 99_000_000), ..gap.clone() };
    store.declare_gap(&lost).unwrap();
    let backwards = Gap { from: gap.to, to: gap.from, ..gap };
    assert!(store.declare_gap(&backwards).is_err());
    let reader = Reader::open(folder.path()).unwrap();
    assert_eq!(reader.gaps(Some(OTTER), TimeRange::ALL).unwrap(), [lost]);
    let later = TimeRange::new(Some(utc(START_US + DAY_US)), None);
    assert_eq!(reader.gaps(None, later).unwrap(), []);
}

/// A declaration over the record lane: the numbers of stream 7 from `from` up to `to`, at a time of day.
fn lost(from: u64, to: u64, at_us: i64) -> Gap {
    Gap {
        system: OTTER,
        from: utc(at_us),
        to: utc(at_us + 1_000),
        kind: GapKind::Lost,
        reason: "the spool was full".to_owned(),
        packets: Some(to - from),
        numbers: Some(Numbers { stream: 7, from, to }),
        declared: utc(START_US),
    }
}

fn gaps(folder: &std::path::Path) -> Vec<Gap> {
    Reader::open(folder).unwrap().gaps(Some(OTTER), TimeRange::ALL).unwrap()
}

#[test]
fn a_gap_that_is_declared_after_a_crash_in_the_middle_of_another_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let first = lost(0, 1, START_US);
    Store::open(folder.path()).unwrap().declare_gap(&first).unwrap();
    let path = folder.path().join("archive/gaps.jsonl");
    let whole = std::fs::read(&path).unwrap();
    for half in [1, whole.len() / 2, whole.len() - 1] {
        std::fs::write(&path, [&whole, &whole[..half]].concat()).unwrap();
        let later = lost(10, 11, START_US + 3_600_000_000);
        Store::open(folder.path()).unwrap().declare_gap(&later).unwrap();
        assert_eq!(gaps(folder.path()), [first.clone(), later], "half a line of {half} bytes");
    }
}

#[test]
fn neighbouring_gaps_are_one_and_a_day_has_only_so_many() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    // Number after number, as a stolen token or a broken vessel would.
    for number in 0..50 {
        store.declare_gap(&lost(number, number + 1, START_US + number as i64 * 10)).unwrap();
    }
    let one = gaps(folder.path());
    assert_eq!(one.len(), 1, "{one:?}");
    assert_eq!((one[0].packets, one[0].numbers.unwrap().to, one[0].from), (Some(50), 50, utc(START_US)));
    // With holes between them.
    for number in 0..250 {
        let from = 1_000 + number * 10;
        store.declare_gap(&lost(from, from + 1, START_US - number as i64 * 1_000_000)).unwrap();
    }
    let many = gaps(folder.path());
    assert_eq!(many.len(), 100);
    let last = START_US - 249 * 1_000_000;
    assert!(
        many.iter().any(|gap| gap.from <= utc(last) && gap.to > utc(last)),
        "the last is not reported at all"
    );
    let bytes = std::fs::metadata(folder.path().join("archive/gaps.jsonl")).unwrap().len();
    assert!(bytes < 100 * 400, "{bytes} bytes");
    // Another day and another system have their own.
    let next = Gap { declared: utc(START_US + DAY_US), ..lost(1 << 40, (1 << 40) + 1, START_US + DAY_US) };
    store.declare_gap(&next).unwrap();
    assert_eq!(gaps(folder.path()).len(), 101);
    drop(store);
    assert_eq!(gaps(folder.path()).len(), 101);
}

#[test]
fn a_gap_is_no_longer_than_time_and_ends_where_a_record_comes() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    accept_link(&mut store, &temperature(START_US, 0.0), START_US, 9);
    store.commit().unwrap();
    let endless = Gap { from: utc(i64::MIN), to: utc(i64::MAX), ..lost(10, u64::MAX, START_US) };
    store.declare_gap(&endless).unwrap();
    let told = &gaps(folder.path())[0];
    assert!(told.from.micros() >= 946_684_800_000_000 && told.to.micros() <= START_US + DAY_US, "{told:?}");
    // It was not true: the vessel has them all.
    for seq in 10..15 {
        let time_us = START_US + seq as i64 * 1_000;
        assert_eq!(accept_link(&mut store, &temperature(time_us, 1.0), time_us, seq), Outcome::Recorded);
    }
    store.commit().unwrap();
    assert_eq!((store.durable(7), gaps(folder.path())), (Some(14), vec![]));
    // Half of one was true.
    store.declare_gap(&lost(20, 40, START_US + 1)).unwrap();
    accept_link(&mut store, &temperature(START_US + 30, 1.0), START_US + 30, 30);
    store.commit().unwrap();
    drop(store);
    let left = gaps(folder.path());
    assert_eq!((left.len(), left[0].packets, left[0].numbers.unwrap().to), (1, Some(10), 30));
    assert_eq!(left[0].told(), "10 packets: the spool was full");
    // Where the vessel knows no time, the time of its declaration counts.
    let mut store = Store::open(folder.path()).unwrap();
    let unknown = Gap { from: utc(0), to: utc(0), ..lost(100, 110, 0) };
    store.declare_gap(&unknown).unwrap();
    assert!(gaps(folder.path()).iter().any(|gap| gap.from == utc(START_US) && gap.to == utc(START_US)));
}

/// Headings about south: half of them are a little less than half a turn to starboard, half to port.
#[test]
fn headings_about_south_are_south_on_average_also_in_a_history_of_before() {
    use std::f64::consts::PI;
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    for at in 0..3_600_i64 {
        let psi = if at % 2 == 0 { PI - 0.02 } else { 0.02 - PI };
        let angles = imc::messages::EulerAngles { psi, ..imc::messages::EulerAngles::default() };
        let time_us = START_US + at * 1_000_000;
        accept(&mut store, &packet(time_us, 1, &angles), time_us, Transport::Tcp);
    }
    store.commit().unwrap();
    store.settle().unwrap();
    let source = Source { system: OTTER, entity: 1, message: "EulerAngles".to_owned() };
    let means = || {
        let mut reader = Reader::open(folder.path()).unwrap();
        let found =
            [6, 60, 3_600].map(|count| reader.buckets(&source, "psi", TimeRange::ALL, count).unwrap());
        found.map(|found| found.buckets.iter().map(|bucket| (bucket.count, bucket.mean)).collect::<Vec<_>>())
    };
    let [hour, minutes, seconds] = means();
    for (_, mean) in hour.iter().chain(&minutes) {
        assert!((mean.abs() - PI).abs() < 1e-9, "{mean} is not south");
    }
    assert!(hour.len() >= 6 && minutes.len() >= 60 && seconds.iter().all(|(_, mean)| mean.abs() > 3.0));
    store.close().unwrap();
    // Version 0.1.0 kept no directions: there the samples are asked.
    let month = folder.path().join("history/2026-11.sqlite");
    for sql in [
        "DELETE FROM _direction WHERE cell % 3 = 0",
        "UPDATE _direction SET count=1",
        "DROP TABLE _direction",
    ] {
        rusqlite::Connection::open(&month).unwrap().execute_batch(sql).unwrap();
        for (before, after) in [&hour, &minutes, &seconds].into_iter().zip(&means()) {
            let same = |(one, other): (&(u64, f64), &(u64, f64))| {
                one.0 == other.0 && (one.1.abs() - other.1.abs()).abs() < 1e-9
            };
            assert!(
                before.len() == after.len() && before.iter().zip(after).all(same),
                "{sql}: {before:?} {after:?}"
            );
        }
    }
}
