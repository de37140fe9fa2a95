//! The manual's `make` commands are targets of the Makefile.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

use std::process::Command;

/// `make -n` runs nothing: it fails where there is no such target.
fn has_target(words: &[String]) -> Result<(), String> {
    let output =
        Command::new("make").arg("-n").args(words).current_dir(testkit::repository()).output().unwrap();
    if output.status.success() { Ok(()) } else { Err(String::from_utf8_lossy(&output.stderr).into_owned()) }
}

#[test]
fn every_make_of_the_manual_has_a_target() {
    for said in testkit::manual::commands_of("make") {
        let judged = has_target(&said.words[1..]);
        assert_eq!(judged, Ok(()), "{}: {}", said.place, said.words.join(" "));
    }
    assert!(has_target(&["no-such-target".to_owned()]).is_err());
}
