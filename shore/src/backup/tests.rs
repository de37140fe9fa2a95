//! A backup that is interrupted at any step leaves the earlier one intact.

use super::restore::restore_around;
use super::{Aside, Held, asides, make, restore};
use crate::{folder, identity};
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};
use store::{Accepted, LinkSeq, Store, Transport};
use units::UtcTime;

/// 2026-11-21T08:00:00Z.
const START_US: i64 = 1_795_248_000_000_000;
const DAY_US: i64 = 86_400_000_000;

fn fill(data: &Path, numbers: std::ops::Range<u64>, day: i64) {
    let mut store = Store::open(data).unwrap();
    for seq in numbers {
        let at = UtcTime::from_micros(START_US + day * DAY_US + seq as i64 * 1_000);
        let header = imc::Header {
            timestamp: at.seconds(),
            src: imc::Address(0x2810),
            src_ent: 5,
            ..imc::Header::default()
        };
        let mut packet = Vec::new();
        imc::encode_into(&mut packet, &header, &imc::messages::Temperature { value: seq as f32 }).unwrap();
        let link = Some(LinkSeq { stream: 7, seq });
        store.accept(&Accepted { packet: &packet, received: at, transport: Transport::Link, link }).unwrap();
    }
    store.close().unwrap();
}

/// A data folder with two days, people, and a photo.
fn data_in(folder: &Path) -> PathBuf {
    let data = folder.join("data");
    fs::create_dir_all(data.join("logbook")).unwrap();
    fill(&data, 0..500, 0);
    fill(&data, 500..600, 1);
    identity::with(&data, async |_| Ok(())).unwrap();
    fs::write(data.join("logbook/1"), "a photo").unwrap();
    settle(&data);
    data
}

/// Sets the modification times to the past.
fn settle(folder: &Path) {
    for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if path.is_dir() {
            settle(&path);
        } else {
            let file = fs::File::options().append(true).open(&path).unwrap();
            file.set_modified(SystemTime::now() - Duration::from_mins(1)).unwrap();
        }
    }
}

/// The files of a restored folder, without those that differ in each copy.
fn restored(backup: &Path, to: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    fs::remove_dir_all(to).ok();
    restore(backup, to, &mut |_| ()).unwrap();
    let mut found = Vec::new();
    gather(to, to, &mut found);
    found.sort();
    found
}

fn gather(root: &Path, folder: &Path, found: &mut Vec<(PathBuf, Vec<u8>)>) {
    for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if path.is_dir() {
            gather(root, &path, found);
        } else {
            found.push((path.strip_prefix(root).unwrap().to_owned(), fs::read(&path).unwrap()));
        }
    }
}

fn back_up(data: &Path, to: &Path) -> super::BackedUp {
    make(data, &[], to, true, &mut |_| ()).unwrap()
}

#[test]
fn a_second_backup_writes_only_what_is_new_and_a_third_nothing() {
    let scratch = tempfile::tempdir().unwrap();
    let (data, to) = (data_in(scratch.path()), scratch.path().join("backup"));
    let first = back_up(&data, &to);
    let second = back_up(&data, &to);
    assert_eq!((second.copied, second.grown, second.linked, second.bytes), (0, 0, 0, 0), "{second:?}");
    assert_eq!(second.kept, first.copied + first.linked);
    // The day grows, and so do the databases of its month.
    fill(&data, 600..650, 1);
    let bytes = |name: &str| fs::metadata(data.join("archive/0x2810/20261122").join(name)).unwrap().len();
    let third = back_up(&data, &to);
    assert_eq!(third.grown, 2, "packets and their records: {third:?}");
    assert!(third.kept >= 4 && bytes("Data.lsf") > 0, "{third:?}");
    assert_eq!(third.damaged, Vec::<PathBuf>::new());
    let back = scratch.path().join("back");
    restored(&to, &back);
    let store = Store::open(&back).unwrap();
    assert_eq!(store.durable(7), Some(649));
    // The old databases are removed, as no manifest names them.
    let in_place = to.join("history/catalogue.sqlite").exists();
    let alternate = to.join("alternate/history/catalogue.sqlite").exists();
    assert!(in_place != alternate, "{in_place} {alternate}");
}

#[test]
fn broken_off_anywhere_the_earlier_backup_is_restored_as_it_was_and_the_next_one_is_whole() {
    let scratch = tempfile::tempdir().unwrap();
    let (data, back) = (data_in(scratch.path()), scratch.path().join("back"));
    let to = scratch.path().join("backup");
    back_up(&data, &to);
    let before = restored(&to, &back);
    fill(&data, 600..700, 1);
    fill(&data, 700..720, 2);
    fs::write(data.join("logbook/1"), "another photo").unwrap();
    fs::write(data.join("logbook/2"), "a second photo").unwrap();
    // It is killed at the begin of each step in turn.
    let mut steps = 0;
    loop {
        let mut left = steps;
        let dies = catch_unwind(AssertUnwindSafe(|| {
            make(&data, &[], &to, true, &mut |_| {
                assert!(left > 0, "killed");
                left -= 1;
            })
        }));
        if dies.is_ok() {
            break;
        }
        steps += 1;
        // The last step begins after the new manifest is written.
        let now = restored(&to, &back);
        let is_new = now.iter().any(|(path, _)| path == Path::new("logbook/2"));
        assert!(is_new || now == before, "step {steps}: the earlier backup is another one");
    }
    assert!(steps > 10, "{steps}");
    restored(&to, &back);
    assert_eq!(Store::open(&back).unwrap().durable(7), Some(719));
    assert_eq!(fs::read(back.join("logbook/1")).unwrap(), b"another photo");
}

#[test]
fn half_of_what_was_appended_and_damage_are_noticed_and_mended() {
    let scratch = tempfile::tempdir().unwrap();
    let (data, to, back) =
        (data_in(scratch.path()), scratch.path().join("backup"), scratch.path().join("back"));
    back_up(&data, &to);
    let before = restored(&to, &back);
    // Power was lost while the newest day was appended to: there is garbage after the bytes in the manifest.
    let day = to.join("archive/0x2810/20261122/Data.lsf");
    let mut bytes = fs::read(&day).unwrap();
    bytes.extend([0xEE; 300]);
    fs::write(&day, &bytes).unwrap();
    assert!(restored(&to, &back) == before);
    fill(&data, 600..650, 1);
    let done = back_up(&data, &to);
    assert_eq!(done.damaged, Vec::<PathBuf>::new());
    let archive = "archive/0x2810/20261122/Data.lsf";
    let whole = |back: &Path| fs::read(back.join(archive)).unwrap() == fs::read(data.join(archive)).unwrap();
    restored(&to, &back);
    assert!(whole(&back));
    // A bit flips on the backup's disk.
    let mut bytes = fs::read(&day).unwrap();
    bytes[100] ^= 1;
    fs::write(&day, &bytes).unwrap();
    let quick = make(&data, &[], &to, false, &mut |_| ()).unwrap();
    assert_eq!(quick.damaged, Vec::<PathBuf>::new(), "it was not read");
    let done = back_up(&data, &to);
    assert_eq!(done.damaged, [PathBuf::from(archive)]);
    restored(&to, &back);
    assert!(whole(&back));
    // Files that the server no longer has stay in the backup.
    fs::remove_dir_all(data.join("archive/0x2810/20261121")).unwrap();
    back_up(&data, &to);
    assert!(
        restored(&to, &back).iter().any(|(path, _)| path == Path::new("archive/0x2810/20261121/Data.lsf"))
    );
}

#[test]
fn what_a_crash_cut_off_and_wrote_again_is_not_appended_to() {
    let scratch = tempfile::tempdir().unwrap();
    let (data, to, back) =
        (data_in(scratch.path()), scratch.path().join("backup"), scratch.path().join("back"));
    back_up(&data, &to);
    // The same length and more, but other bytes.
    let day = data.join("archive/0x2810/20261122/Data.lsf");
    let mut bytes = fs::read(&day).unwrap();
    let last = bytes.len() - 3;
    bytes[last] ^= 1;
    bytes.extend([7; 40]);
    fs::write(&day, &bytes).unwrap();
    let done = back_up(&data, &to);
    assert_eq!((done.grown, done.damaged.len()), (0, 0), "{done:?}");
    restored(&to, &back);
    assert_eq!(fs::read(back.join("archive/0x2810/20261122/Data.lsf")).unwrap(), bytes);
}

#[test]
fn a_quick_backup_does_not_make_damage_valid_by_appending_to_it() {
    let scratch = tempfile::tempdir().unwrap();
    let (data, to, back) =
        (data_in(scratch.path()), scratch.path().join("backup"), scratch.path().join("back"));
    let archive = Path::new("archive/0x2810/20261122/Data.lsf");
    back_up(&data, &to);
    let mut bytes = fs::read(to.join(archive)).unwrap();
    bytes[100] ^= 1;
    // By a rename, as the first backup may have linked the server's own file.
    fs::write(to.join("turned"), &bytes).unwrap();
    fs::rename(to.join("turned"), to.join(archive)).unwrap();
    fill(&data, 600..650, 1);
    let quick = make(&data, &[], &to, false, &mut |_| ()).unwrap();
    assert_eq!(quick.damaged, [archive.to_owned()]);
    restored(&to, &back);
    assert!(fs::read(back.join(archive)).unwrap() == fs::read(data.join(archive)).unwrap());
}

#[test]
fn halves_that_a_kill_left_are_removed_and_a_damaged_manifest_tells_what_to_do() {
    let scratch = tempfile::tempdir().unwrap();
    let (data, to) = (data_in(scratch.path()), scratch.path().join("backup"));
    back_up(&data, &to);
    let halves = ["logbook/1.part", "alternate/app.db.part-wal"].map(|path| to.join(path));
    fs::create_dir_all(to.join("alternate")).unwrap();
    for path in &halves {
        fs::write(path, "half").unwrap();
    }
    fs::write(to.join("film.part"), "not ours").unwrap();
    back_up(&data, &to);
    assert!(!halves.iter().any(|path| path.exists()) && to.join("film.part").exists());
    fs::write(to.join("backup.json"), "{").unwrap();
    let error = make(&data, &[], &to, true, &mut |_| ()).unwrap_err();
    assert!(format!("{error:#}").contains("choose another folder"), "{error:#}");
}

#[test]
fn a_folder_that_is_there_is_filled_in_place_and_is_no_data_folder_until_it_is_whole() {
    let scratch = tempfile::tempdir().unwrap();
    let at = |name: &str| scratch.path().join(name);
    let (data, to, back) = (data_in(scratch.path()), at("backup"), at("back"));
    back_up(&data, &to);
    let (expected, whole) = (restored(&to, &at("absent")), |folder: &Path| {
        let mut found = Vec::new();
        gather(folder, folder, &mut found);
        found.sort();
        found
    });
    // A mounted disk: the folder itself is kept, and `lost+found` does not matter.
    fs::create_dir_all(back.join("lost+found")).unwrap();
    let inode = |path: &Path| std::os::unix::fs::MetadataExt::ino(&fs::metadata(path).unwrap());
    let before = inode(&back);
    restore(&to, &back, &mut |_| ()).unwrap();
    assert!(whole(&back) == expected && inode(&back) == before);
    assert!(!back.join(".restoring").exists() && back.join("lost+found").exists());
    folder::check(&back).unwrap();

    // Killed while the copied files were moved: no program accepts it as a data folder, and the next restore completes it.
    fs::create_dir(back.join(".restoring")).unwrap();
    fs::rename(back.join("app.db"), back.join(".restoring/app.db")).unwrap();
    let told = folder::check(&back).unwrap_err().to_string();
    assert!(told.contains("was broken off") && told.contains("lutra-server restore"), "{told}");
    fs::write(back.join("letter.txt"), "x").unwrap();
    let told = restore(&to, &back, &mut |_| ()).unwrap_err().to_string();
    assert!(
        told.contains("letter.txt there is not of this backup") && back.join("logbook/1").exists(),
        "{told}"
    );
    fs::remove_file(back.join("letter.txt")).unwrap();
    restore(&to, &back, &mut |_| ()).unwrap();
    assert!(whole(&back) == expected);
    // Without that mark the files there are foreign.
    restore(&to, &back, &mut |_| ()).unwrap_err();

    // A damaged backup leaves the folder empty, as it was.
    let empty = at("empty");
    fs::create_dir(&empty).unwrap();
    fs::write(to.join("logbook/1"), "a prank").unwrap();
    let told = restore(&to, &empty, &mut |_| ()).unwrap_err().to_string();
    assert!(told.contains("logbook/1: holds other bytes"), "{told}");
    assert_eq!(fs::read_dir(&empty).unwrap().count(), 0);
}

fn turn_a_bit(path: &Path) {
    let mut bytes = fs::read(path).unwrap();
    bytes[100] ^= 1;
    // By a rename, as a first backup on the same disk links the server's own files.
    let turned = path.with_extension("turned");
    fs::write(&turned, &bytes).unwrap();
    fs::rename(turned, path).unwrap();
}

#[test]
fn a_file_that_turns_bad_at_the_server_does_not_take_the_good_copy_along() {
    let scratch = tempfile::tempdir().unwrap();
    let (data, to, back) =
        (data_in(scratch.path()), scratch.path().join("backup"), scratch.path().join("back"));
    let archive = Path::new("archive/0x2810/20261121/Data.lsf");
    back_up(&data, &to);
    let good = fs::read(to.join(archive)).unwrap();
    turn_a_bit(&data.join(archive));
    let done = back_up(&data, &to);
    let [Aside { path, at, good: true }] = &done.aside[..] else { panic!("{done:?}") };
    assert!(path == archive && fs::read(to.join(at)).unwrap() == good, "{at:?}");
    // The backup matches the server, and the copy is kept in later ones.
    restored(&to, &back);
    assert_eq!(fs::read(back.join(archive)).unwrap(), fs::read(data.join(archive)).unwrap());
    assert!(back_up(&data, &to).aside.is_empty() && fs::read(to.join(at)).unwrap() == good);
    fs::copy(to.join(at), data.join(archive)).unwrap();
    assert_eq!(back_up(&data, &to).aside.len(), 1, "what was mended is another one, too");
    restored(&to, &back);
    assert_eq!(fs::read(back.join(archive)).unwrap(), good);
}

#[test]
fn access_that_was_ended_does_not_come_back_by_a_later_backup() {
    let scratch = tempfile::tempdir().unwrap();
    let (data, to) = (data_in(scratch.path()), scratch.path().join("backup"));
    let ended = [
        "fleet/otter-1.token",
        "fleet/otter-1.ovpn",
        "fleet/otter-1.vpn",
        "vpn/openvpn/lutra.ccd/otter-1.0f",
    ];
    let kept =
        ["fleet/fleet.toml", "fleet/openvpn.key", "fleet/otter-2.ovpn", "vpn/openvpn/lutra.ccd/otter-2.0e"];
    for path in ended.iter().chain(&kept) {
        let path = data.join(path);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, "a secret").unwrap();
    }
    let there = |path: &&str| scratch.path().join("back").join(path).exists();
    back_up(&data, &to);
    restored(&to, &scratch.path().join("back"));
    assert!(ended.iter().chain(&kept).all(&there), "all of it while it is good");
    for path in ended {
        fs::remove_file(data.join(path)).unwrap();
    }
    // The server's own key was lost, which is no end of access.
    fs::remove_file(data.join("fleet/openvpn.key")).unwrap();
    back_up(&data, &to);
    restored(&to, &scratch.path().join("back"));
    assert!(!ended.iter().any(&there), "a vessel's that was ended");
    assert!(kept.iter().all(&there), "what is good, and the server's own");
    // Where the whole folder was lost, its copies are all that there is.
    fs::remove_dir_all(data.join("fleet")).unwrap();
    back_up(&data, &to);
    restored(&to, &scratch.path().join("back"));
    assert!(kept.iter().all(there));
}

#[test]
fn what_only_the_backup_has_is_kept_although_it_is_damaged() {
    let scratch = tempfile::tempdir().unwrap();
    let (data, to, back) =
        (data_in(scratch.path()), scratch.path().join("backup"), scratch.path().join("back"));
    let archive = Path::new("archive/0x2810/20261121/Data.lsf");
    back_up(&data, &to);
    fs::remove_dir_all(data.join("archive/0x2810/20261121")).unwrap();
    turn_a_bit(&to.join(archive));
    let bytes = fs::read(to.join(archive)).unwrap();
    let done = back_up(&data, &to);
    let [Aside { path, at, good: false }] = &done.aside[..] else { panic!("{done:?}") };
    assert!(path == archive && !to.join(archive).exists());
    assert!(fs::read(to.join(at)).unwrap() == bytes, "all but one bit of it is still worth something");
    // A restore is not stopped by it, and later backups leave it where it is.
    restored(&to, &back);
    assert!(back_up(&data, &to).aside.is_empty() && to.join(at).exists());
    assert_eq!(
        asides(&to).unwrap(),
        [to.join(at.iter().take(2).collect::<PathBuf>())],
        "for a person, each time"
    );
}

#[test]
fn a_day_that_only_the_backup_had_and_that_is_gone_is_called_lost() {
    let scratch = tempfile::tempdir().unwrap();
    let (data, to) = (data_in(scratch.path()), scratch.path().join("backup"));
    let archive = Path::new("archive/0x2810/20261121/Data.lsf");
    back_up(&data, &to);
    fs::remove_file(to.join(archive)).unwrap();
    let done = back_up(&data, &to);
    assert_eq!(
        (&done.damaged[..], &done.lost[..]),
        (&[archive.to_owned()][..], &[][..]),
        "the server has it"
    );
    fs::remove_dir_all(data.join("archive/0x2810/20261121")).unwrap();
    let again = to.join("alternate").join(archive);
    for path in [to.join(archive), again] {
        fs::remove_file(path).ok();
    }
    let done = back_up(&data, &to);
    assert_eq!((&done.damaged[..], &done.lost[..]), (&[][..], &[archive.to_owned()][..]));
}

#[test]
fn what_has_a_copy_aside_is_not_held() {
    let scratch = tempfile::tempdir().unwrap();
    let (data, to) = (data_in(scratch.path()), scratch.path().join("backup"));
    let day = Path::new("archive/0x2810/20261121");
    back_up(&data, &to);
    turn_a_bit(&data.join(day).join("Data.lsf"));
    let done = back_up(&data, &to);
    assert_eq!(done.aside.len(), 1, "{done:?}");
    let lacks = || Held::read(&to).unwrap().lacks(&data, day, true).unwrap();
    assert!(lacks().unwrap().contains("a person must look at"));
    fs::remove_dir_all(to.join("aside")).unwrap();
    assert_eq!(lacks(), None);
}

#[test]
fn a_backup_says_whether_it_holds_something_as_it_is() {
    let scratch = tempfile::tempdir().unwrap();
    let (data, to) = (data_in(scratch.path()), scratch.path().join("backup"));
    let told = Held::read(&to).unwrap_err().to_string();
    assert!(told.contains("no whole backup") && told.contains("lutra-server backup"), "{told}");
    back_up(&data, &to);
    let lacks =
        |path: &str, reads: bool| Held::read(&to).unwrap().lacks(&data, Path::new(path), reads).unwrap();
    let (day, month) = ("archive/0x2810/20261121", "history/2026-11.sqlite");
    for path in [day, month] {
        assert_eq!(lacks(path, true), None);
    }
    // Only reading finds a flipped bit, in any file.
    let file = Path::new(day).join("Data.lsf");
    for at in [&data, &to] {
        turn_a_bit(&at.join(&file));
        assert_eq!(lacks(day, false), None);
        let why = lacks(day, true).unwrap();
        assert!(
            why.contains("Data.lsf is damaged in it") || why.contains("Data.lsf differs from"),
            "{at:?} {why}"
        );
        turn_a_bit(&at.join(&file));
        assert_eq!(lacks(day, true), None);
    }
    fill(&data, 600..610, 1);
    assert!(lacks(month, true).unwrap().contains("differs from the copy in it"), "the month went on");
    assert!(lacks("archive/0x2810/20261122", false).unwrap().contains("differs from the copy in it"));
    fs::write(data.join(day).join("note.txt"), "x").unwrap();
    assert!(lacks(day, false).unwrap().contains("note.txt is not in it"));
    fs::remove_file(to.join(&file)).unwrap();
    assert!(lacks(day, false).unwrap().contains("is named in it and not there"));
}

#[test]
fn two_restores_at_once_do_not_meet() {
    let scratch = tempfile::tempdir().unwrap();
    let at = |name: &str| scratch.path().join(name);
    let (data, to) = (data_in(scratch.path()), at("backup"));
    back_up(&data, &to);
    fs::create_dir(at("there")).unwrap();
    for name in ["absent", "there"] {
        let back = at(name);
        let mut refused = 0;
        restore(&to, &back, &mut |_| {
            let told = restore(&to, &back, &mut |_| ()).unwrap_err().to_string();
            assert!(told.contains("another restore into") && told.contains("is under way"), "{told}");
            refused += 1;
        })
        .unwrap();
        assert!(refused > 5, "{refused}");
        assert_eq!(Store::open(&back).unwrap().durable(7), Some(599));
        assert!(!back.join(".restoring").exists() && !at("absent.restoring").exists());
    }
    // A restore that checked before the first one finished touches nothing of its result.
    let whole = at("there");
    let mark = whole.join(".restoring");
    assert!(restore(&to, &whole, &mut |_| ()).unwrap_err().to_string().contains("is not empty"));
    assert!(!mark.exists() && whole.join("app.db").exists());
}

#[test]
fn a_restore_that_another_one_overtook_between_look_and_lock_takes_nothing_of_it() {
    let scratch = tempfile::tempdir().unwrap();
    let at = |name: &str| scratch.path().join(name);
    let (data, to) = (data_in(scratch.path()), at("backup"));
    back_up(&data, &to);
    fs::create_dir(at("there")).unwrap();
    for name in ["absent", "there"] {
        let back = at(name);
        let mut whole = || drop(restore(&to, &back, &mut |_| ()).unwrap());
        let told = restore_around(&to, &back, &mut |_| panic!("it copies"), &mut whole).unwrap_err();
        assert!(told.to_string().contains("is not empty"), "{name}: {told:#}");
        assert_eq!(Store::open(&back).unwrap().durable(7), Some(599), "{name}");
        assert!(!back.join(".restoring").exists() && !at("absent.restoring").exists());
    }
    // An empty folder that was made meanwhile: the working folder beside it cannot be renamed to it.
    let late = at("late");
    let mut made = || fs::create_dir(&late).unwrap();
    let told = restore_around(&to, &late, &mut |_| panic!("it copies"), &mut made).unwrap_err();
    assert!(told.to_string().contains("appeared meanwhile"), "{told:#}");
    assert!(fs::read_dir(&late).unwrap().next().is_none() && !at("late.restoring").exists());
    // While the other one is running, the lock refuses.
    let mut held = None;
    let mut hold = || {
        fs::create_dir_all(at("held.restoring")).unwrap();
        let folder = fs::File::open(at("held.restoring")).unwrap();
        folder.try_lock().unwrap();
        held = Some(folder);
    };
    let told = restore_around(&to, &at("held"), &mut |_| panic!("it copies"), &mut hold).unwrap_err();
    assert!(told.to_string().contains("is under way"), "{told:#}");
    assert!(held.is_some() && !at("held").exists() && at("held.restoring").exists());
}

#[test]
fn a_restore_that_was_broken_off_is_not_gone_on_with_by_another_backup() {
    let scratch = tempfile::tempdir().unwrap();
    let at = |name: &str| scratch.path().join(name);
    let (data, back) = (data_in(scratch.path()), at("back"));
    back_up(&data, &at("first"));
    fs::create_dir(data.join("sinks")).unwrap();
    fs::write(data.join("sinks/influx"), "x").unwrap();
    back_up(&data, &at("second"));
    fs::create_dir_all(back.join(".restoring")).unwrap();
    fs::create_dir(back.join("sinks")).unwrap();
    let told = restore(&at("first"), &back, &mut |_| ()).unwrap_err().to_string();
    assert!(
        told.contains("sinks there is not of this backup") && told.contains("the backup of before"),
        "{told}"
    );
    assert!(back.join("sinks").exists() && back.join(".restoring").exists());
    restore(&at("second"), &back, &mut |_| ()).unwrap();
    assert_eq!(fs::read(back.join("sinks/influx")).unwrap(), b"x");
}

/// Compresses the first day, as a server does once some days have passed.
fn compress(data: &Path) {
    let now = UtcTime::from_micros(START_US + 30 * DAY_US);
    let mut store = Store::open(data).unwrap();
    for day in store::plan_packing(data, 3, now).unwrap() {
        let mut packing = store::Packing::begin(data, &day).unwrap();
        while packing.work(1 << 20).unwrap() {}
        store.adopt(&mut packing).unwrap().unwrap();
    }
    store.close().unwrap();
    settle(data);
}

const DAY: &str = "archive/0x2810/20261121";

#[test]
fn a_day_that_was_compressed_since_takes_the_place_of_its_plain_copy() {
    let scratch = tempfile::tempdir().unwrap();
    let (data, to, back) =
        (data_in(scratch.path()), scratch.path().join("backup"), scratch.path().join("back"));
    back_up(&data, &to);
    let plain = fs::read(data.join(DAY).join("Data.lsf")).unwrap();
    compress(&data);
    assert!(!data.join(DAY).join("Data.lsf").exists());
    // Before the next backup the plain copy counts.
    let held = Held::read(&to).unwrap();
    assert_eq!(held.lacks(&data, Path::new(DAY), true).unwrap(), None);
    let second = back_up(&data, &to);
    assert_eq!(
        (second.replaced, second.damaged.len(), second.aside.len(), second.lost.len()),
        (2, 0, 0, 0),
        "{second:?}"
    );
    for (name, is_there) in
        [("Data.lsf", false), ("Arrivals.idx", false), ("Data.lsf.zst", true), ("Arrivals.zst", true)]
    {
        assert_eq!(to.join(DAY).join(name).exists(), is_there, "{name}");
    }
    let held = Held::read(&to).unwrap();
    assert_eq!(held.lacks(&data, Path::new(DAY), true).unwrap(), None);
    let third = back_up(&data, &to);
    assert_eq!(
        (third.copied, third.grown, third.linked, third.replaced, third.bytes),
        (0, 0, 0, 0, 0),
        "{third:?}"
    );
    // Restored it is the same log.
    restored(&to, &back);
    let store = Store::open(&back).unwrap();
    assert_eq!((store.durable(7), store.repairs().notes.len()), (Some(599), 0));
    let mut unpacked = Vec::new();
    let mut packed = store::Packed::open(&back.join(DAY).join("Data.lsf.zst")).unwrap();
    std::io::Read::read_to_end(&mut packed, &mut unpacked).unwrap();
    assert_eq!(unpacked, plain);
    // A server that was set back to its plain days: the compressed copy goes for them, when they are the same.
    fs::remove_file(data.join(DAY).join("Data.lsf.zst")).unwrap();
    fs::write(data.join(DAY).join("Data.lsf"), &plain).unwrap();
    settle(&data);
    let held = Held::read(&to).unwrap();
    assert_eq!(held.lacks(&data, Path::new(DAY), true).unwrap(), None);
    let fourth = back_up(&data, &to);
    assert_eq!((fourth.replaced, fourth.aside.len()), (1, 0), "{fourth:?}");
    assert!(to.join(DAY).join("Data.lsf").exists() && !to.join(DAY).join("Data.lsf.zst").exists());
    // Both in the forms that the server has them: packets plain, records compressed.
    restored(&to, &back);
    assert_eq!(Store::open(&back).unwrap().durable(7), Some(599));
}

#[test]
fn plain_copies_that_a_kill_left_behind_go_with_the_next_backup_unless_they_hold_more() {
    let scratch = tempfile::tempdir().unwrap();
    let (data, to) = (data_in(scratch.path()), scratch.path().join("backup"));
    back_up(&data, &to);
    let plain = fs::read(to.join(DAY).join("Data.lsf")).unwrap();
    compress(&data);
    back_up(&data, &to);
    // As a kill between the manifest and the end of the sweep leaves it.
    for below in [to.join(DAY), to.join("alternate").join(DAY)] {
        fs::create_dir_all(&below).unwrap();
        fs::write(below.join("Data.lsf"), &plain).unwrap();
    }
    back_up(&data, &to);
    assert!(!to.join(DAY).join("Data.lsf").exists());
    assert!(!to.join("alternate").join(DAY).join("Data.lsf").exists());
    let longer = [plain.as_slice(), b"more"].concat();
    fs::write(to.join(DAY).join("Data.lsf"), &longer).unwrap();
    back_up(&data, &to);
    assert_eq!(fs::read(to.join(DAY).join("Data.lsf")).unwrap(), longer);
}

#[test]
fn a_compressed_day_that_lacks_what_the_backup_has_leaves_both_to_a_person() {
    let scratch = tempfile::tempdir().unwrap();
    let (data, to) = (data_in(scratch.path()), scratch.path().join("backup"));
    back_up(&data, &to);
    // The server lost the end of the day, and compressed what was left.
    let whole = fs::read(data.join(DAY).join("Data.lsf")).unwrap();
    // Files of their own, as on another disk: those in the backup are links to the server's.
    for (name, part) in [("Data.lsf", 2), ("Arrivals.idx", 1)] {
        let path = data.join(DAY).join(name);
        let bytes = fs::read(&path).unwrap();
        fs::remove_file(&path).unwrap();
        fs::write(&path, &bytes[..bytes.len() / part]).unwrap();
    }
    compress(&data);
    let held = Held::read(&to).unwrap();
    let why = held.lacks(&data, Path::new(DAY), true).unwrap().unwrap();
    assert!(why.contains("differs from the copy in it"), "{why}");
    let second = back_up(&data, &to);
    assert_eq!(second.replaced, 0, "{second:?}");
    let kept = second.aside.iter().find(|aside| aside.path.ends_with("Data.lsf")).unwrap();
    assert!(kept.good && fs::read(to.join(&kept.at)).unwrap() == whole, "{kept:?}");
    // Nothing of the day may go until a person has looked.
    let held = Held::read(&to).unwrap();
    let why = held.lacks(&data, Path::new(DAY), true).unwrap().unwrap();
    assert!(why.contains("which a person must look at"), "{why}");
}

#[test]
fn a_day_that_is_compressed_while_it_is_copied_is_in_the_backup_all_the_same() {
    let scratch = tempfile::tempdir().unwrap();
    let (data, to, back) =
        (data_in(scratch.path()), scratch.path().join("backup"), scratch.path().join("back"));
    for moment in ["Data.lsf", "Arrivals.idx"] {
        let (data, to) = (data.with_extension(moment), to.with_extension(moment));
        let copy = data_in(&data);
        let mut once = false;
        make(&copy, &[], &to, true, &mut |what| {
            if !once && what == format!("{DAY}/{moment}") {
                once = true;
                compress(&copy);
            }
        })
        .unwrap();
        assert!(once, "{moment}");
        restored(&to, &back);
        let store = Store::open(&back).unwrap();
        assert_eq!(store.durable(7), Some(599), "{moment}");
        drop(store);
        // The next backup has one form alone.
        back_up(&copy, &to);
        assert!(!to.join(DAY).join("Data.lsf").exists() && to.join(DAY).join("Data.lsf.zst").exists());
    }
}
