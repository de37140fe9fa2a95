//! A history that is damaged, missing or of a later version: it never stops the store, and is made again from the
//! archive while packets keep coming in.

use crate::support::{OTTER, START_US, accept, accept_link, dump, packet, state, temperature, utc};
use std::fs;
use std::path::Path;
use store::{
    Committed, Health, Reader, Retention, Source, Store, StoreError, TimeRange, Transport, doctor, reindex,
};

const DAY_US: i64 = 86_400_000_000;
/// Commits after which a history must be whole again.
const COMMITS: usize = 1_000;

/// Samples of October and November that came on three days, the same message on two of them.
fn fill(folder: &Path) -> Vec<String> {
    let mut store = Store::open(folder).unwrap();
    for at in 0..600_i64 {
        let (time_us, received_us) = (START_US - at * DAY_US / 15, START_US + at % 3 * DAY_US);
        accept(&mut store, &temperature(time_us, at as f32), received_us, Transport::Tcp);
        accept_link(&mut store, &packet(time_us, 39, &state(at as f32)), received_us, at as u64);
        if at % 50 == 0 {
            accept(&mut store, &temperature(time_us, at as f32), received_us + DAY_US, Transport::Tcp);
        }
    }
    store.commit().unwrap();
    store.settle().unwrap();
    store.close().unwrap();
    dump(folder)
}

/// Commits until the history has all of the archive; returns the reports meanwhile.
fn until_whole(store: &mut Store) -> Vec<String> {
    let mut told = Vec::new();
    for _ in 0..COMMITS {
        let Committed { history_behind: Some(text), .. } = store.commit().unwrap() else { return told };
        told.push(text);
    }
    panic!("still behind after {COMMITS} commits: {:?}", told.last());
}

/// Damages a filled folder, opens it, lets a vessel continue to send, and compares the history with what it was.
fn made_again(damage: impl Fn(&Path), named: &str) {
    let folder = tempfile::tempdir().unwrap();
    let before = fill(folder.path());
    damage(&folder.path().join("history"));
    let mut store = Store::open_at_once(folder.path()).unwrap();
    assert_eq!(store.durable(7), Some(599));
    let notes = store.repairs().notes.join("; ");
    assert!(notes.contains(named), "{named} is not reported: {notes:?}");
    // A repeat of what came first; it is in the archive already.
    accept(&mut store, &temperature(START_US, 0.0), START_US + 3 * DAY_US, Transport::Tcp);
    let told = until_whole(&mut store);
    assert!(told.iter().all(|text| text.contains("made again from the archive")), "{told:?}");
    store.settle().unwrap();
    assert!(dump(folder.path()) == before, "the history differs after {named}");
    store.close().unwrap();
    let store = Store::open_at_once(folder.path()).unwrap();
    assert_eq!((store.behind(), &store.repairs().notes), (None, &Vec::new()));
}

/// The databases that lie aside.
fn kept_aside(folder: &Path) -> Vec<String> {
    let Ok(entries) = fs::read_dir(folder.join("history.aside")) else { return Vec::new() };
    let mut names: Vec<String> = entries.map(|one| one.unwrap().file_name().into_string().unwrap()).collect();
    names.retain(|name| name.ends_with(".sqlite"));
    names
}

#[test]
fn a_month_that_is_no_database_is_made_again() {
    made_again(
        |history| fs::write(history.join("2026-10.sqlite"), vec![7; 50_000]).unwrap(),
        "2026-10.sqlite",
    );
}

#[test]
fn a_month_that_was_cut_off_is_made_again() {
    let cut = |history: &Path| {
        let file = fs::File::options().write(true).open(history.join("2026-11.sqlite")).unwrap();
        file.set_len(file.metadata().unwrap().len() / 2).unwrap();
    };
    made_again(cut, "2026-11.sqlite");
    made_again(|history| fs::write(history.join("2026-11.sqlite"), []).unwrap(), "2026-11.sqlite");
}

#[test]
fn a_month_that_is_gone_is_made_again() {
    made_again(|history| fs::remove_file(history.join("2026-10.sqlite")).unwrap(), "2026-10.sqlite");
}

#[test]
fn a_catalogue_that_is_damaged_or_gone_is_made_again() {
    made_again(
        |history| fs::write(history.join("catalogue.sqlite"), "no database").unwrap(),
        "catalogue.sqlite",
    );
    made_again(|history| fs::remove_file(history.join("catalogue.sqlite")).unwrap(), "catalogue.sqlite");
    made_again(|history| fs::remove_dir_all(history).unwrap(), "history");
}

#[test]
fn damage_that_is_met_while_writing_is_mended_without_a_restart() {
    let folder = tempfile::tempdir().unwrap();
    let before = fill(folder.path());
    let month = folder.path().join("history/2026-11.sqlite");
    // All but the first page, which the look at the start reads.
    let mut bytes = fs::read(&month).unwrap();
    bytes[8192..].fill(0xA5);
    fs::write(&month, bytes).unwrap();
    let mut store = Store::open_at_once(folder.path()).unwrap();
    accept(&mut store, &temperature(START_US, 0.0), START_US + 3 * DAY_US, Transport::Tcp);
    until_whole(&mut store);
    store.settle().unwrap();
    assert!(dump(folder.path()) == before);
    assert_eq!(kept_aside(folder.path()), ["2026-11.sqlite"]);
}

#[test]
fn what_comes_meanwhile_is_acknowledged_and_the_newest_day_comes_first() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    for at in 0..40_000_i64 {
        let time_us = START_US + at % 2 * DAY_US + at * 1_000;
        accept_link(&mut store, &temperature(time_us, at as f32), time_us, at as u64);
    }
    store.commit().unwrap();
    store.close().unwrap();
    fs::write(folder.path().join("history/2026-11.sqlite"), "no database").unwrap();
    let mut store = Store::open_at_once(folder.path()).unwrap();
    let newest_us = START_US + DAY_US;
    let mut newest = None;
    for seq in 40_000..u64::MAX {
        let time_us = START_US + DAY_US + seq as i64 * 1_000;
        accept_link(&mut store, &temperature(time_us, 1.0), time_us, seq);
        let committed = store.commit().unwrap();
        assert_eq!(committed.durable.last().unwrap().seq, seq, "it is not acknowledged at once");
        let count = |range| {
            let source = Source { system: OTTER, entity: 5, message: "Temperature".to_owned() };
            let mut reader = Reader::open(folder.path()).unwrap();
            reader.samples(&source, &["value"], range, usize::MAX).unwrap().time_us.len() as u64
        };
        let today = count(TimeRange::new(Some(utc(newest_us)), None));
        let all = count(TimeRange::ALL);
        if today == 20_000 + seq - 39_999 && all < seq {
            newest = Some(seq);
        }
        if committed.history_behind.is_none() {
            assert_eq!(all, seq + 1);
            break;
        }
    }
    assert!(newest.is_some(), "today is not there before yesterday");
}

#[test]
fn a_later_history_is_not_written_and_stops_nothing() {
    for file in ["2026-10.sqlite", "catalogue.sqlite"] {
        let folder = tempfile::tempdir().unwrap();
        fill(folder.path());
        let path = folder.path().join("history").join(file);
        rusqlite::Connection::open(&path).unwrap().pragma_update(None, "user_version", 99).unwrap();
        let bytes = || {
            let mut names: Vec<_> = fs::read_dir(folder.path().join("history"))
                .unwrap()
                .map(|entry| entry.unwrap().path())
                .filter(|path| path.extension().is_some_and(|end| end == "sqlite"))
                .collect();
            names.sort();
            names.iter().map(|path| fs::read(path).unwrap()).collect::<Vec<_>>()
        };
        let before = bytes();
        let mut store = Store::open_at_once(folder.path()).unwrap();
        assert_eq!(store.durable(7), Some(599));
        accept_link(&mut store, &temperature(START_US + 7, 1.0), START_US + 7, 600);
        let committed = store.commit().unwrap();
        assert_eq!(committed.durable[0].seq, 600, "the archive takes it all the same");
        let told = committed.history_behind.unwrap();
        assert!(told.contains("later version") && told.contains("reindex"), "{told}");
        assert!(matches!(store.retain(&Retention::default()), Err(StoreError::Newer { .. })));
        store.close().unwrap();
        assert!(bytes() == before, "{file} of a later version was written to");
        let answer = Reader::open(folder.path()).unwrap().systems().unwrap_err().to_string();
        assert!(answer.contains("later version"), "{answer}");
        let checks = doctor(folder.path(), utc(START_US), false, &mut |_| true).unwrap();
        let check = checks.iter().find(|check| check.name == "history" && check.health == Health::Problem);
        assert!(check.unwrap().remedy.contains("reindex"), "{checks:#?}");
        // The named remedy works: a history of this version, with all packets; the later one is kept.
        reindex(folder.path(), false, &mut |_| true).unwrap();
        assert_eq!(Store::open_at_once(folder.path()).unwrap().behind(), None);
        assert!(kept_aside(folder.path()).iter().any(|name| *name == file), "{file}");
    }
}

#[test]
fn reindex_does_what_the_doctor_says_it_does() {
    for file in ["2026-10.sqlite", "catalogue.sqlite"] {
        let folder = tempfile::tempdir().unwrap();
        let before = fill(folder.path());
        fs::write(folder.path().join("history").join(file), "no database").unwrap();
        let checks = doctor(folder.path(), utc(START_US), true, &mut |_| true).unwrap();
        let check = checks.iter().find(|check| check.name == "history" && check.found.contains(file));
        assert!(check.unwrap().remedy.contains("reindex"), "{checks:#?}");
        reindex(folder.path(), false, &mut |_| true).unwrap();
        assert!(dump(folder.path()) == before);
        assert_eq!(kept_aside(folder.path()), [file]);
        let checks = doctor(folder.path(), utc(START_US), true, &mut |_| true).unwrap();
        assert!(checks.iter().all(|check| check.health < Health::Problem), "{checks:#?}");
        assert!(checks.iter().any(|check| check.found.contains("history.aside")), "{checks:#?}");
    }
}

#[test]
fn a_damaged_month_of_which_the_archive_was_given_up_is_not_replaced_unasked() {
    let folder = tempfile::tempdir().unwrap();
    fill(folder.path());
    let mut store = Store::open(folder.path()).unwrap();
    let before = Retention { archive_before: Some(utc(START_US + DAY_US)), ..Retention::default() };
    store.retain(&before).unwrap();
    store.close().unwrap();
    fs::write(folder.path().join("history/2026-10.sqlite"), "no database").unwrap();
    let refused = reindex(folder.path(), false, &mut |_| true).unwrap_err().to_string();
    assert!(refused.contains("days were removed"), "{refused}");
    reindex(folder.path(), true, &mut |_| true).unwrap();
    assert_eq!(kept_aside(folder.path()), ["2026-10.sqlite"]);
}

#[test]
fn an_archive_that_became_shorter_stays_told() {
    let folder = tempfile::tempdir().unwrap();
    fill(folder.path());
    let day = folder.path().join("archive/0x2810/20261121");
    let file = fs::File::options().write(true).open(day.join("Data.lsf")).unwrap();
    let length = file.metadata().unwrap().len();
    file.set_len(length / 2).unwrap();
    fs::remove_dir_all(folder.path().join("archive/0x2810/20261122")).unwrap();
    // Before anything was written down.
    let checks = doctor(folder.path(), utc(START_US), false, &mut |_| true).unwrap();
    let told = checks.iter().filter(|check| check.found.contains("once on the disk")).count();
    assert_eq!(told, 2, "{checks:#?}");
    for start in 0..3 {
        let store = Store::open(folder.path()).unwrap();
        let notes = store.repairs().notes.join("; ");
        for lost in ["0x2810/20261121", "0x2810/20261122"] {
            assert!(notes.contains(lost), "start {start} does not tell {lost}: {notes}");
        }
        store.close().unwrap();
        let checks = doctor(folder.path(), utc(START_US), false, &mut |_| true).unwrap();
        let told: Vec<_> = checks
            .iter()
            .filter(|check| check.health == Health::Problem && check.found.contains("once on the disk"))
            .collect();
        assert_eq!(told.len(), 2, "{checks:#?}");
        assert!(told.iter().all(|check| check.remedy.contains("shortened.jsonl")));
    }
    // An operator confirms by the named remedy.
    fs::remove_file(folder.path().join("archive/shortened.jsonl")).unwrap();
    let checks = doctor(folder.path(), utc(START_US), false, &mut |_| true).unwrap();
    assert!(checks.iter().all(|check| check.health < Health::Problem), "{checks:#?}");
}

#[test]
fn a_reindex_that_would_lose_says_what_and_how_to_go_on_and_the_doctor_says_the_same() {
    for starts in [0, 1] {
        let folder = tempfile::tempdir().unwrap();
        let before = fill(folder.path());
        let path = folder.path().join("archive/0x2810/20261121/Data.lsf");
        let was = fs::metadata(&path).unwrap().len();
        fs::File::options().write(true).open(&path).unwrap().set_len(was / 2).unwrap();
        for _ in 0..starts {
            Store::open(folder.path()).unwrap().close().unwrap();
        }
        let refuse = || reindex(folder.path(), false, &mut |_| true).unwrap_err().to_string();
        for told in [refuse(), refuse()] {
            for word in ["0x2810", "on 2026-11-21", "bytes are gone", "`lutra-server reindex --accept-loss`"]
            {
                assert!(told.contains(word), "{word} is not in: {told}");
            }
            assert!(told.contains(&format!("of {was} bytes")), "{told}");
        }
        assert!(dump(folder.path()) == before, "the history is as it was");
        let checks = doctor(folder.path(), utc(START_US), false, &mut |_| true).unwrap();
        let check = checks.iter().find(|check| check.name == "reindex").unwrap();
        assert!(
            check.found.contains("bytes are gone") && check.remedy.contains("--accept-loss"),
            "{check:?}"
        );
        assert!(!check.remedy.contains("which goes on there"), "{check:?}");
        let done = reindex(folder.path(), true, &mut |_| true).unwrap();
        assert!(done.samples < done.before);
        // The rebuild is over; what the archive lost is still reported.
        let checks = doctor(folder.path(), utc(START_US), false, &mut |_| true).unwrap();
        assert!(checks.iter().all(|check| check.name != "reindex"), "{checks:#?}");
        let is_told =
            |check: &store::Check| check.found.contains("0x2810/20261121") && check.found.contains("once on");
        assert!(checks.iter().any(is_told), "{checks:#?}");
        assert!(!folder.path().join("history/refused").exists());
    }
}

/// What the list of recorded days says: the day, how many packets came on it, and how many bytes of them the archive has.
fn listed(folder: &Path) -> Vec<(i64, u64, u64)> {
    let days = Reader::open(folder).unwrap().recorded_days().unwrap();
    days.iter().map(|day| (day.day.micros(), day.extent.count, day.bytes)).collect()
}

#[test]
fn a_day_and_a_month_that_are_lost_at_once_are_both_reported() {
    let folder = tempfile::tempdir().unwrap();
    fill(folder.path());
    let before = listed(folder.path());
    fs::remove_dir_all(folder.path().join("archive/0x2810/20261121")).unwrap();
    let cut = folder.path().join("archive/0x2810/20261122/Data.lsf");
    let cut = fs::File::options().write(true).open(cut).unwrap();
    cut.set_len(cut.metadata().unwrap().len() / 2).unwrap();
    for month in ["2026-10.sqlite", "2026-11.sqlite"] {
        fs::write(folder.path().join("history").join(month), "no database").unwrap();
    }
    let mut store = Store::open_at_once(folder.path()).unwrap();
    let notes = store.repairs().notes.join("; ");
    for lost in ["archive/0x2810/20261121: of ", "archive/0x2810/20261122: of "] {
        assert!(notes.contains(lost), "{lost} is not reported: {notes}");
    }
    until_whole(&mut store);
    store.close().unwrap();
    let after = listed(folder.path());
    assert_eq!(after.len(), before.len(), "what came on the day stays listed: {after:?}");
    let oldest = after.last().unwrap();
    assert_eq!((oldest.0, oldest.1, oldest.2), (before.last().unwrap().0, before.last().unwrap().1, 0));
}

#[test]
fn a_pruned_day_stays_listed_while_a_month_has_it_and_is_read_when_it_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    fill(folder.path());
    let (before, samples) = (listed(folder.path()), dump(folder.path()));
    let (day, kept) = (folder.path().join("archive/0x2810/20261121"), folder.path().join("kept"));
    fs::create_dir(&kept).unwrap();
    for name in ["Data.lsf", "Arrivals.idx"] {
        fs::copy(day.join(name), kept.join(name)).unwrap();
    }
    let mut store = Store::open(folder.path()).unwrap();
    let pruning = Retention { archive_before: Some(utc(START_US + DAY_US)), ..Retention::default() };
    assert_eq!(store.retain(&pruning).unwrap().len(), 1);
    store.close().unwrap();
    let mut pruned = before.clone();
    pruned.last_mut().unwrap().2 = 0;
    assert_eq!(listed(folder.path()), pruned);
    fs::write(folder.path().join("history/2026-10.sqlite"), "no database").unwrap();
    let mut store = Store::open_at_once(folder.path()).unwrap();
    until_whole(&mut store);
    store.close().unwrap();
    assert_eq!(listed(folder.path()), pruned, "a month was made again from the days that are left");
    fs::rename(&kept, &day).unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    store.settle().unwrap();
    assert_eq!(listed(folder.path()), before, "the day came back from a backup");
    assert!(dump(folder.path()) == samples);
    let later = Some(utc(START_US + 60 * DAY_US));
    store.retain(&Retention { archive_before: later, history_before: later }).unwrap();
    assert_eq!(listed(folder.path()), [], "nothing of it is left");
}
