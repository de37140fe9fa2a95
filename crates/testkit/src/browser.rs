//! Runs the scripts of `tests/browser` in headless Chromium.

use crate::{Need, absent, repository};
use std::io::{BufRead as _, BufReader};
use std::path::PathBuf;
use std::process::{Command, Stdio};

/// Whether Node, Chromium and the bundle are there; says what is missing if not.
///
/// # Panics
/// When something is missing that must be there: see [`absent`].
pub fn is_there() -> bool {
    let browser = ["/usr/bin/chromium-headless-shell", "/usr/bin/chromium"].map(PathBuf::from);
    let needed = [
        (&browser[..], "make chromium"),
        (&[repository().join("web/node_modules/playwright-core")], "make web"),
        (&[repository().join("web/dist/manifest.json")], "make web"),
    ];
    let missing = needed.iter().find(|(paths, _)| !paths.iter().any(|path| path.exists()));
    let Some((paths, remedy)) = missing else { return true };
    absent(Need::Browser, &format!("{} is absent ({remedy})", paths[0].display()));
    false
}

/// Runs `tests/browser/SCRIPT` with `arguments`; `told` hears each line that it prints.
///
/// # Panics
/// When it cannot be run or fails.
pub fn run(script: &str, arguments: &[&str], mut told: impl FnMut(&str)) {
    let path = repository().join("tests/browser").join(script);
    let mut child =
        Command::new("node").arg(path).args(arguments).stdout(Stdio::piped()).spawn().expect("node runs");
    let lines = BufReader::new(child.stdout.take().expect("its output is piped")).lines();
    for line in lines.map_while(Result::ok) {
        println!("{line}");
        told(&line);
    }
    assert!(child.wait().expect("it was started").success(), "tests/browser/{script} failed");
}
