//! The manual's commands of `lutra-server` that are quick and harm nothing, run as they stand there, on a data folder of their own.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use testkit::manual::commands_of;

/// What is run, by how it begins, in this order. The rest is held against the command line alone (`cli/mod.rs`): it needs charts,
/// recordings or a boat.
const RUN: [&[&str]; 7] = [
    &["user", "passwd"],
    &["config"],
    &["token", "create"],
    &["tls", "init"],
    &["tls", "renew"],
    &["register"],
    &["fleet", "check"],
];

/// Runs it where `/etc/lutra` of the manual is the folder's own.
fn run(words: &[String], folder: &Path) -> Output {
    let etc = folder.join("etc").display().to_string();
    let placed = words.iter().map(|word| word.replace("/etc/lutra", &etc));
    let mut command = Command::new(env!("CARGO_BIN_EXE_lutra-server"));
    command.args(placed).current_dir(folder).env("LUTRA_DATA", folder.join("data"));
    command.output().unwrap()
}

fn words(line: &str) -> Vec<String> {
    line.split(' ').map(str::to_owned).collect()
}

#[test]
fn what_the_manual_tells_people_to_type_works() {
    let folder = tempfile::tempdir().unwrap();
    let etc = folder.path().join("etc");
    fs::create_dir(&etc).unwrap();
    fs::write(etc.join("server.toml"), "").unwrap();
    fs::copy(testkit::repository().join("deploy/fleet.example.toml"), etc.join("fleet.toml")).unwrap();
    // The accounts that a first start and *Admin, People* make.
    for line in ["user add admin --role admin", "user add anna --role researcher"] {
        let made = run(&words(line), folder.path());
        assert!(made.status.success(), "{line}: {}", String::from_utf8_lossy(&made.stderr));
    }
    let all = commands_of("lutra-server");
    for begin in RUN {
        let meant = |words: &[String]| {
            words.len() > begin.len() && words[1..].iter().zip(begin).all(|(one, two)| one == two)
        };
        let meant: Vec<_> = all.iter().filter(|said| said.is_whole && meant(&said.words)).collect();
        assert!(!meant.is_empty(), "the manual has no {begin:?} any more: take it from the list");
        for said in meant {
            let output = run(&said.words[1..], folder.path());
            let text = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{}: {}\n{text}", said.place, said.words.join(" "));
        }
    }
}
