//! `imc info`, `imc list` and `imc address`.

mod harness;

use harness::run;
use serde_json::Value;

#[test]
fn info_shows_fields_with_units_and_labels() {
    let text = run(&["info", "vehiclestate"], b"").expect(0).text().to_owned();
    for part in [
        "VehicleState 500",
        "op_mode",
        "MANEUVER",
        "control_loops",
        "0x40000000",
        "last_error_time",
        "fp64_t",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    assert!(run(&["info", "EstimatedState"], b"").expect(0).text().contains("-π/2 to π/2"));
    assert!(run(&["info", "Heartbeat"], b"").expect(0).text().contains("No fields"));
}

#[test]
fn info_takes_names_in_any_case_and_ids() {
    let shown: Vec<String> = ["TBRFishTag", "tbrfishtag", "2007", "0x7d7"]
        .iter()
        .map(|name| run(&["info", name], b"").expect(0).text().to_owned())
        .collect();
    assert!(shown.iter().all(|text| *text == shown[0]));
    assert!(shown[0].contains("older senders leave it out"));
    assert!(run(&["info", "maneuver"], b"").expect(0).text().contains("FollowPath"));
}

#[test]
fn info_asks_what_was_meant() {
    let stderr = run(&["info", "EstimatdState"], b"").expect(2).stderr;
    assert!(stderr.contains("did you mean `EstimatedState`"), "{stderr}");
}

#[test]
fn info_gives_json() {
    let shown = &run(&["info", "PlanControl", "--json"], b"").expect(0).lines()[0];
    assert_eq!(shown["id"], 559);
    let op = &shown["fields"][1];
    assert_eq!((&op["abbrev"], &op["type"]), (&"op".into(), &"uint8_t".into()));
    assert_eq!(op["enumeration"][1]["abbrev"], "STOP");
}

#[test]
fn list_searches_names_summaries_fields_and_units() {
    assert_eq!(run(&["list", "--json"], b"").expect(0).lines().len(), 351);
    let names = |words: &[&str]| -> Vec<String> {
        let arguments = [&["list", "--json"], words].concat();
        let found = run(&arguments, b"").expect(0).lines();
        found.iter().map(|line| line["abbrev"].as_str().unwrap().to_owned()).collect()
    };
    assert!(names(&["fish"]).contains(&"TBRFishTag".to_owned()));
    assert!(names(&["150"]).contains(&"Heartbeat".to_owned()));
    assert!(names(&["PSU"]).contains(&"Salinity".to_owned()));
    assert!(names(&["trans_freq"]).contains(&"TBRFishTag".to_owned()));
    assert_eq!(names(&["lat", "trans_freq"]), ["TBRFishTag"]);
    run(&["list", "no such thing at all"], b"").expect(1);
}

#[test]
fn addresses_translate_both_ways() {
    let shown =
        |system: &str| -> Value { run(&["address", system, "--json"], b"").expect(0).lines()[0].clone() };
    for system in ["ntnu-otter-01", "NTNU-Otter-01", "0x2810", "10256"] {
        let found = shown(system);
        assert_eq!(
            (&found["name"], &found["id"], &found["hex"]),
            (&"ntnu-otter-01".into(), &10256.into(), &"0x2810".into())
        );
        assert_eq!(found["kind"], "autonomous surface vehicle");
        assert_eq!(found["lsts"], false);
    }
    let unlisted = shown("my-boat");
    assert_eq!(unlisted["registered"], false);
    assert_eq!(unlisted["id"].as_u64().unwrap() & 0xE000, 0xA000);
    assert_eq!(shown("0x4001")["kind"], "control unit");
    let told = |system| run(&["address", system], b"").expect(0).text().trim_end().to_owned();
    let otter = "ntnu-otter-01  0x2810 (10256)  autonomous surface vehicle of another institute than LSTS";
    assert_eq!(told("0x2810"), otter);
    assert!(told("0x4001").ends_with("control unit"));
}

#[test]
fn colour_is_refused_by_no_color() {
    let coloured = |variables: &[(&str, &str)]| {
        let mut command = harness::command(&["info", "GpsFix"]);
        let output = command.envs(variables.iter().copied()).output().unwrap();
        output.stdout.contains(&0x1B)
    };
    assert!(!coloured(&[]));
    assert!(coloured(&[("CLICOLOR_FORCE", "1")]));
    assert!(!coloured(&[("CLICOLOR_FORCE", "1"), ("NO_COLOR", "1")]));
}

#[test]
fn pipes_get_no_colour_and_help_is_worth_reading() {
    assert!(!run(&["info", "GpsFix"], b"").expect(0).text().contains('\x1b'));
    for subcommand in ["decode", "encode", "info", "list", "address", "listen", "send", "lsf"] {
        let help = run(&[subcommand, "--help"], b"").expect(0).text().to_owned();
        assert!(help.contains("Examples:") && !help.contains('\x1b'), "{subcommand}");
    }
}

/// The manual's own questions about messages and systems, asked as they stand there.
#[test]
fn what_the_manual_asks_is_answered() {
    let mut asked = 0;
    for said in testkit::manual::commands_of("imc").into_iter().filter(|said| said.is_whole) {
        let words: Vec<&str> = said.words[1..].iter().map(String::as_str).collect();
        if ["info", "list", "address"].contains(&words[0]) {
            let finished = run(&words, b"");
            assert_eq!(finished.status, 0, "{}: {words:?}\n{}", said.place, finished.stderr);
            asked += 1;
        }
    }
    assert!(asked >= 2, "{asked} questions");
}
