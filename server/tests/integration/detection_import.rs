//! Tables of detections by the command line: all of a table, also where a command is killed in between.

use crate::support::program::SERVER;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

const HEAD: &str = "Date and Time (UTC),Receiver,Transmitter\n";

fn run(data: &Path, arguments: &[&str]) -> Output {
    Command::new(SERVER).args(arguments).arg("--data").arg(data).output().unwrap()
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&[output.stdout.as_slice(), &output.stderr].concat()).into_owned()
}

/// A data folder with a vessel, and a table of so many detections beside it.
fn table(folder: &TempDir, name: &str, rows: u32) -> PathBuf {
    let mut table = HEAD.to_owned();
    for row in 0..rows {
        let (minute, second) = (row / 60 % 60, row % 60);
        writeln!(table, "2026-11-21 {:02}:{minute:02}:{second:02},VR2W-{},A69-1303-{row}", row / 3_600, rows)
            .unwrap();
    }
    let path = folder.path().join(name);
    fs::write(&path, table).unwrap();
    path
}

fn rows(data: &Path) -> usize {
    let exported = run(data, &["detections", "export"]);
    assert!(exported.status.success(), "{}", text(&exported));
    String::from_utf8_lossy(&exported.stdout).lines().count() - 1
}

#[test]
fn an_import_that_was_killed_is_finished_by_the_next_and_adds_nothing_twice() {
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("data");
    assert!(run(&data, &["vessel", "add", "pier", "0x1C01"]).status.success());
    let (large, small) = (table(&folder, "large.csv", 6_000), table(&folder, "small.csv", 3));
    let mut command = Command::new(SERVER);
    command.args(["detections", "import", "--vessel", "pier"]).arg(&large).arg("--data").arg(&data);
    let mut killed = command.spawn().unwrap();
    // Its packets are whole, and on their way into the archive.
    let staged = data.join("detections.lsf");
    while !staged.exists() && killed.try_wait().unwrap().is_none() {
        std::thread::yield_now();
    }
    killed.kill().unwrap();
    killed.wait().unwrap();
    assert!(staged.exists(), "it was killed before its end");
    let next = run(&data, &["detections", "import", "--vessel", "pier", small.to_str().unwrap()]);
    assert!(next.status.success(), "{}", text(&next));
    assert!(text(&next).contains("broken off before is finished: 6000 detections"), "{}", text(&next));
    assert!(text(&next).contains("3 detections, 3 new"), "{}", text(&next));
    assert_eq!((rows(&data), staged.exists()), (6_003, false));
    let again = run(&data, &["detections", "import", "--vessel", "pier", large.to_str().unwrap()]);
    assert!(text(&again).contains("6000 detections, 0 new"), "{}", text(&again));
}

#[test]
fn a_part_of_a_table_in_the_archive_is_told_and_has_an_exit_code_of_its_own() {
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("data");
    assert!(run(&data, &["vessel", "add", "pier", "0x1C01"]).status.success());
    let (first, small) = (table(&folder, "first.csv", 50), table(&folder, "small.csv", 3));
    let import =
        |file: &Path| run(&data, &["detections", "import", "--vessel", "pier", file.to_str().unwrap()]);
    assert!(import(&first).status.success());
    // What an import left, of which the disk has lost the end.
    let packets = folder.path().join("packets.lsf");
    let exported = run(&data, &["export", "--format", "lsf", "-o", packets.to_str().unwrap()]);
    assert!(exported.status.success(), "{}", text(&exported));
    let whole = fs::read(&packets).unwrap();
    fs::write(data.join("detections.lsf"), &whole[..whole.len() - 9]).unwrap();
    let told = import(&small);
    assert_eq!(told.status.code(), Some(3), "{}", text(&told));
    assert!(
        text(&told).contains("damaged from byte") && text(&told).contains("49 detections could be taken"),
        "{}",
        text(&told)
    );
    assert!(text(&told).contains("3 detections, 3 new") && rows(&data) == 53, "{}", text(&told));
    for (vessel, why) in [
        ("7", "no vessel or station here has the address 0x0007"),
        ("0xFFFF", "cannot be a vessel's address"),
    ] {
        let refused = run(&data, &["detections", "import", "--vessel", vessel, small.to_str().unwrap()]);
        assert!(refused.status.code() == Some(1) && text(&refused).contains(why), "{}", text(&refused));
    }
}
