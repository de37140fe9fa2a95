//! `imc lsf` on a recorded log and on logs made for the purpose.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod harness;

use harness::{gunzip, gzip, heartbeat, run};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The log of a real DUNE's plan run, where it is at hand.
fn recorded() -> Option<PathBuf> {
    testkit::shared("data/imc/dune_log_a/Data.lsf.gz")
}

/// A new log in its own folder.
struct Made {
    folder: tempfile::TempDir,
    file: PathBuf,
}

impl Made {
    fn of(bytes: &[u8]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("Data.lsf");
        std::fs::write(&file, bytes).unwrap();
        Self { folder, file }
    }

    fn of_lines(lines: &[&str]) -> Self {
        Self::of(&run(&["encode"], lines.join("\n").as_bytes()).expect(0).stdout)
    }

    fn name(&self) -> &str {
        self.file.to_str().unwrap()
    }
}

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap()
}

#[test]
fn info_counts_what_decode_shows() {
    let Some(log) = recorded() else { return };
    let info = &run(&["lsf", "info", "--json", log.to_str().unwrap()], b"").expect(0).lines()[0];
    assert_eq!(info["packets"], 58_072);
    assert_eq!(info["bytes"], 2_783_539);
    assert!((info["span_s"].as_f64().unwrap() - 184.2).abs() < 0.1);
    assert_eq!(info["damage"]["runs"], 0);
    let shown = run(&["decode", log.to_str().unwrap()], b"").expect(0);
    let mut counts = std::collections::BTreeMap::new();
    for line in shown.lines() {
        *counts.entry(line["id"].as_u64().unwrap()).or_insert(0) += 1;
    }
    let messages = info["messages"].as_array().unwrap();
    assert_eq!(messages.len(), counts.len());
    for message in messages {
        assert_eq!(message["packets"], counts[&message["id"].as_u64().unwrap()]);
        let entities = message["entities"].as_array().unwrap();
        let sum: u64 = entities.iter().map(|entity| entity["packets"].as_u64().unwrap()).sum();
        assert_eq!(message["packets"], sum);
    }
    let state = messages.iter().find(|message| message["abbrev"] == "EstimatedState").unwrap();
    assert_eq!(state["entities"][0]["entity"], "Navigation");
    assert!((state["rate_hz"].as_f64().unwrap() - 10.0).abs() < 0.1);
}

#[test]
fn info_is_for_people_too_and_takes_a_folder() {
    let Some(log) = recorded() else { return };
    let folder = log.parent().unwrap().to_str().unwrap();
    let text = run(&["lsf", "info", folder, "--entities"], b"").expect(0).text().to_owned();
    for part in
        ["58072 packets", "2026-11-21T07:43:27", "ntnu-otter-01", "ntnu-otter-01/Motor - Port", "remembered"]
    {
        assert!(text.contains(part), "{part}\n{text}");
    }
}

#[test]
fn info_tells_damage() {
    let good = heartbeat(10.0);
    let unknown = hex::decode("54fe9f0f0900000020fae5b2d741102805ffffff000102030405060708ed47").unwrap();
    let bytes = [&good[..], b"salmon", &unknown, &good[..9]].concat();
    let made = Made::of(&bytes);
    let info = &run(&["lsf", "info", "--json", made.name()], b"").expect(1).lines()[0];
    assert_eq!(info["packets"], 2);
    let damage = &info["damage"];
    assert_eq!(
        (&damage["runs"], &damage["bytes"], &damage["first_offset"]),
        (&2.into(), &15.into(), &22.into())
    );
    assert_eq!(damage["undecodable"]["unknown_id"], 1);
    let text = run(&["lsf", "info", made.name()], b"").expect(1).text().to_owned();
    assert!(text.contains("15 bytes in 2 places are not packets, the first at byte 22"), "{text}");
    let packed = gzip(&good.repeat(2_000));
    let cut = Made::of(&packed[..packed.len() - 10]);
    let text = run(&["lsf", "info", cut.name()], b"").expect(1).text().to_owned();
    assert!(text.contains("packed data ends early"), "{text}");
    assert!(run(&["lsf", "info", Made::of(b"").name()], b"").expect(0).text().contains("0 packets"));
}

/// A compressed day of a server's archive, which zstd packed.
#[test]
fn a_log_that_zstd_packed_is_read_and_its_cut_is_said() {
    let plain = [heartbeat(10.0), heartbeat(11.0)].concat().repeat(20_000);
    let packed = zstd::encode_all(&plain[..], 1).unwrap();
    let made = Made::of(&packed);
    let folder = made.folder.path().join("day");
    std::fs::create_dir(&folder).unwrap();
    std::fs::rename(&made.file, folder.join("Data.lsf.zst")).unwrap();
    let info = &run(&["lsf", "info", "--json", folder.to_str().unwrap()], b"").expect(0).lines()[0];
    assert_eq!((&info["packets"], &info["damage"]["runs"]), (&40_000.into(), &0.into()));
    let part = run(&["lsf", "cut", folder.to_str().unwrap(), "--from", "+1"], b"").expect(0).stdout;
    assert!(part == heartbeat(11.0).repeat(20_000));
    let cut = Made::of(&packed[..packed.len() - 5]);
    let text = run(&["lsf", "info", cut.name()], b"").expect(1).text().to_owned();
    assert!(text.contains("the file ends inside a zstd frame"), "{text}");
}

#[test]
fn json_is_decode_with_a_choice() {
    let Some(log) = recorded() else { return };
    let log = log.to_str().unwrap();
    let all = run(&["lsf", "json", log], b"").expect(0).stdout;
    assert!(all == run(&["decode", log], b"").expect(0).stdout);
    let count = |arguments: &[&str]| -> usize {
        let chosen = run(&[&["lsf", "json", log], arguments].concat(), b"").expect(0);
        chosen.text().lines().count()
    };
    assert_eq!(count(&["-m", "EstimatedState"]), 1_843);
    assert_eq!(count(&["-m", "350", "-m", "gpsfix"]), 1_843 + 1_844);
    assert_eq!(
        count(&["-m", "Heartbeat", "-s", "0x4001"]) + count(&["-m", "Heartbeat", "-s", "ntnu-otter-01"]),
        368
    );
    assert_eq!(count(&["-m", "Rpm", "-e", "motor - port"]) + count(&["-m", "Rpm", "-e", "49"]), 7_370);
    assert_eq!(count(&["-m", "EstimatedState", "--from", "+10", "--to", "+19.99"]), 100);
    let iso = ["--from", "2026-11-21T07:43:37.979Z", "--to", "2026-11-21T07:43:47.969Z"];
    assert_eq!(count(&[&["-m", "EstimatedState"][..], &iso].concat()), 100);
    let modes: Vec<usize> = ["op_mode=MANEUVER", "op_mode!=MANEUVER"]
        .iter()
        .map(|mode| count(&["-m", "VehicleState", "-w", mode]))
        .collect();
    assert!(modes[0] > 100 && modes[0] + modes[1] == 513, "{modes:?}");
    assert_eq!(count(&["-w", "lat>63.4deg", "-w", "lat<63.5deg", "-m", "GpsFix"]), 1_844);
    assert_eq!(count(&["-w", "arg.plan_id=lutra_tri"]), 2);
}

#[test]
fn grep_finds_what_is_said_and_by_whom() {
    let Some(log) = recorded() else { return };
    let log = log.to_str().unwrap();
    let found = run(&["lsf", "grep", "PLAN COMPLETED", log, "-m", "PlanControl"], b"").expect(0);
    let line = found.text();
    assert_eq!(line.lines().count(), 1);
    assert!(line.starts_with(
        "2026-11-21T07:46:32.214438Z ntnu-otter-01/Plan Engine PlanControl type=SUCCESS op=START"
    ));
    assert_eq!(run(&["lsf", "grep", "", "-c", log], b"").expect(0).text().trim(), "58072");
    let json =
        run(&["lsf", "grep", "plan completed", "-m", "PlanControl", "--json", log], b"").expect(0).lines();
    assert_eq!(json[0]["fields"]["info"], "plan completed");
    run(&["lsf", "grep", "no such words", log], b"").expect(1);
}

#[test]
fn csv_has_units_labels_and_a_choice_of_degrees() {
    let Some(log) = recorded() else { return };
    let log = log.to_str().unwrap();
    let table = run(&["lsf", "csv", log, "-m", "GpsFix", "--degrees", "-e", "GPS"], b"").expect(0);
    let mut lines = table.text().lines();
    let header = lines.next().unwrap();
    let start = "time,unix_s,system,system_id,entity,entity_id,dst,dst_ent,validity,type,utc_year";
    assert!(header.starts_with(start), "{header}");
    assert!(header.contains(",lat [deg],lon [deg],height [m],"), "{header}");
    let first: Vec<&str> = lines.next().unwrap().split(',').collect();
    assert_eq!((first[2], first[3], first[4]), ("ntnu-otter-01", "0x2810", "GPS"));
    let lat = header.split(',').position(|name| name == "lat [deg]").unwrap();
    assert!(first[lat].starts_with("63.44"), "{first:?}");
    let plain = run(&["lsf", "csv", log, "-m", "VehicleState"], b"").expect(0);
    assert!(plain.text().lines().nth(1).unwrap().split(',').nth(8).unwrap().parse::<u8>().is_ok());
    let labelled = run(&["lsf", "csv", log, "-m", "VehicleState", "--labels"], b"").expect(0);
    assert!(labelled.text().contains(",MANEUVER,"));
}

#[test]
fn csv_writes_every_message_to_a_file_of_its_own() {
    let Some(log) = recorded() else { return };
    let folder = tempfile::tempdir().unwrap();
    let tables = folder.path().join("tables");
    let arguments = ["lsf", "csv", log.to_str().unwrap(), "-o", tables.to_str().unwrap()];
    run(&arguments, b"").expect(0);
    assert_eq!(std::fs::read_dir(&tables).unwrap().count(), 37);
    assert_eq!(text(&tables.join("EstimatedState.csv")).lines().count(), 1_844);
    assert!(run(&arguments, b"").expect(2).stderr.contains("--force"));
    run(&[&arguments[..], &["--force"]].concat(), b"").expect(0);
}

#[test]
fn csv_text_is_safe_in_spreadsheets_unless_wanted_raw() {
    let made = Made::of_lines(&[
        r#"{"abbrev":"EntityInfo","header":{"src":"0x2a10"},"fields":{"id":7,"label":"@logger"}}"#,
        r#"{"abbrev":"LogBookEntry","header":{"timestamp":1.5,"src":"0x2a10","src_ent":7},
            "fields":{"htime":"NaN","context":"=1+1","text":"a \"b\", c"}}"#
            .replace('\n', "")
            .as_str(),
    ]);
    let table = run(&["lsf", "csv", made.name(), "-m", "LogBookEntry"], b"").expect(0);
    let line = "1970-01-01T00:00:01.500000Z,1.500000,0x2a10,0x2a10,'@logger,7,0xffff,255,0,NaN,'=1+1,\
                \"a \"\"b\"\", c\"";
    assert_eq!(table.text().lines().nth(1).unwrap(), line);
    let raw = run(&["lsf", "csv", made.name(), "-m", "LogBookEntry", "--raw-text"], b"").expect(0);
    assert!(raw.text().contains(",@logger,7,0xffff,255,0,NaN,=1+1,"));
}

#[test]
fn csv_leaves_empty_what_an_older_sender_left_out_and_shows_nested_messages() {
    let made = Made::of_lines(&[
        r#"{"abbrev":"TBRFishTag","fields":{"serial_no":7}}"#,
        r#"{"abbrev":"TBRFishTag","fields":{"serial_no":8,"lat":1,"lon":0.5}}"#,
        r#"{"abbrev":"PlanControl","fields":{"arg":{"abbrev":"Temperature","fields":{"value":1.5}}}}"#,
        r#"{"abbrev":"PlanControl"}"#,
    ]);
    let tags = run(&["lsf", "csv", made.name(), "-m", "TBRFishTag"], b"").expect(0);
    let lines: Vec<&str> = tags.text().lines().collect();
    assert!(
        lines[0].ends_with(",lat [rad],lon [rad]")
            && lines[1].ends_with(",0,,")
            && lines[2].ends_with(",1.0,0.5")
    );
    assert!(lines.iter().all(|line| line.matches(',').count() == lines[0].matches(',').count()));
    let plans = run(&["lsf", "csv", made.name(), "-m", "PlanControl"], b"").expect(0);
    let nested = r#","{""abbrev"":""Temperature"",""fields"":{""value"":1.5}}","#;
    assert!(plans.text().contains(nested), "{}", plans.text());
    assert!(plans.text().lines().nth(2).unwrap().ends_with(",0,,0,,"));
}

#[test]
fn cut_keeps_the_original_bytes() {
    let Some(log) = recorded() else { return };
    let log_name = log.to_str().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let part = folder.path().join("part.lsf.gz");
    let part_name = part.to_str().unwrap();
    let whole = run(&["lsf", "cut", log_name], b"").expect(0).stdout;
    assert!(whole == gunzip(&log));
    run(&["lsf", "cut", log_name, "--from", "+30", "--to", "+60", "-o", part_name], b"").expect(0);
    let shown = run(&["lsf", "json", log_name, "--from", "+30", "--to", "+60"], b"").expect(0).stdout;
    assert!(gunzip(&part) == run(&["encode"], &shown).expect(0).stdout);
    let again = run(&["lsf", "cut", log_name, "-o", part_name], b"").expect(2);
    assert!(again.stderr.contains("never overwritten"), "{}", again.stderr);
    let named = run(&["lsf", "cut", log_name, "-m", "Abort", "--keep-names"], b"").expect(0).stdout;
    assert_eq!(run(&["decode"], &named).expect(0).text().lines().count(), 132 + 6 + 55);
}

#[test]
fn logs_are_joined_and_damage_left_out() {
    let first = Made::of(&[&heartbeat(1.0)[..], b"salmon"].concat());
    let second = Made::of(&gzip(&heartbeat(2.0)));
    let joined = run(&["lsf", "cut", first.name(), second.name()], b"").expect(1);
    assert_eq!(joined.stdout, [heartbeat(1.0), heartbeat(2.0)].concat());
    assert!(joined.stderr.contains("left out"));
    let shown = run(&["lsf", "json", first.name(), second.name()], b"").expect(1).lines();
    let errors: Vec<&Value> = shown.iter().map(|line| &line["error"]).collect();
    assert_eq!(errors, [&Value::Null, &"bad_sync".into(), &Value::Null]);
}

#[test]
fn misuse_of_logs_is_told() {
    let made = Made::of(&heartbeat(1.0));
    let folder = made.folder.path().join("empty");
    std::fs::create_dir(&folder).unwrap();
    for (arguments, told) in [
        (&["info", "/no/such/log"][..], "cannot open /no/such/log"),
        (&["info", folder.to_str().unwrap()], "holds no Data.lsf, Data.lsf.gz or Data.lsf.zst"),
        (&["csv", made.name()], "choose one with -m MESSAGE"),
        (&["csv", made.name(), "-m", "GpsFixx"], "did you mean `GpsFix`"),
        (&["csv", made.name(), "-m", "GpsFix", "-s", "ntnu-oter-01"], "did you mean ntnu-otter-01"),
        (
            &["json", made.name(), "--entity", "Navigator"],
            "no entity is called `Navigator`; it tells no labels",
        ),
        (&["json", made.name(), "--from", "yesterday"], "seconds since 1970"),
        (&["json", made.name(), "--where", "sog"], "expected FIELD OP VALUE"),
        (&["json", made.name(), "--where", "sogg>1"], "did you mean sog"),
        (&["json", "-"], "use `imc decode`"),
        (&["json"], "required"),
    ] {
        let done = run(&[&["lsf"], arguments].concat(), b"").expect(2);
        assert!(done.stderr.contains(told), "{}", done.stderr);
    }
}

#[test]
fn rubbish_logs_never_panic() {
    let bytes: Vec<u8> = (0..40_000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    let made = Made::of(&[&bytes[..], &heartbeat(f64::from(u32::MAX)), &bytes].concat());
    for arguments in [&["info"][..], &["json"], &["cut"], &["grep", ""], &["csv", "-m", "Heartbeat"]] {
        run(&[&["lsf"], arguments, &[made.name()]].concat(), b"").expect(1);
    }
}

/// After a restart the numbers are reassigned: a label selects the packets of the entity that had it then.
#[test]
fn a_label_is_that_of_whoever_had_it_then() {
    let list = |time: u32, text: &str| {
        format!(
            r#"{{"abbrev":"EntityList","header":{{"timestamp":{time},"src":"0x2a10"}},"fields":{{"op":"REPORT","list":"{text}"}}}}"#
        )
    };
    let rpm = |time: u32, entity: u8, value: i16| {
        format!(
            r#"{{"abbrev":"Rpm","header":{{"timestamp":{time},"src":"0x2a10","src_ent":{entity}}},"fields":{{"value":{value}}}}}"#
        )
    };
    let lines = [
        list(1, "Motor - Port=48;Motor - Starboard=49"),
        rpm(2, 48, 100),
        rpm(2, 49, 200),
        list(10, "Motor - Starboard=48;Motor - Port=49"),
        rpm(11, 48, 201),
        rpm(11, 49, 101),
    ];
    let made = Made::of_lines(&lines.iter().map(String::as_str).collect::<Vec<_>>());
    let table = run(&["lsf", "csv", made.name(), "-m", "Rpm", "-e", "motor - port"], b"").expect(0);
    let rows: Vec<&str> = table.text().lines().skip(1).collect();
    assert_eq!(rows.len(), 2);
    assert!(rows[0].contains(",Motor - Port,48,") && rows[0].ends_with(",100"), "{rows:?}");
    assert!(rows[1].contains(",Motor - Port,49,") && rows[1].ends_with(",101"), "{rows:?}");
    let found = run(&["lsf", "grep", "Motor - Starboard", "-m", "Rpm", made.name()], b"").expect(0);
    assert!(found.text().contains("value=200") && found.text().contains("value=201"), "{}", found.text());
}

#[test]
fn bytes_that_are_no_text_come_back() {
    let log = Made::of_lines(&[
        r#"{"abbrev":"LogBookEntry","header":{"timestamp":1.5},"fields":{"text":"Sk\\xe6r, C:\\\\x"}}"#,
    ]);
    let bytes = std::fs::read(&log.file).unwrap();
    assert!(bytes.windows(9).any(|part| part == b"Sk\xE6r, C:\\"), "one byte and one backslash");
    let shown = run(&["decode", log.name()], b"").expect(0);
    assert_eq!(shown.lines()[0]["fields"]["text"], r"Sk\xe6r, C:\\x");
    assert_eq!(run(&["encode"], &shown.stdout).expect(0).stdout, bytes);
    let table = run(&["lsf", "csv", log.name(), "-m", "LogBookEntry"], b"").expect(0);
    assert!(table.text().ends_with(",\"Sk\\xe6r, C:\\\\x\"\n"), "{}", table.text());
    // In the format of earlier versions.
    let old = br#"{"abbrev":"LogBookEntry","header":{"timestamp":1.5},"fields":{"text":{"bytes":"536be6722c20433a5c78"}}}"#;
    assert_eq!(run(&["encode"], old).expect(0).stdout, bytes);
}

#[test]
fn a_table_for_a_spreadsheet_has_a_mark_and_decimal_commas() {
    let made = Made::of_lines(&[
        r#"{"abbrev":"Voltage","header":{"timestamp":1.5,"src":"0x2a10","src_ent":0},"fields":{"value":24.5}}"#,
    ]);
    let table = run(&["lsf", "csv", made.name(), "-m", "0xfb", "--spreadsheet", "comma"], b"").expect(0);
    let text = "\u{FEFF}time;unix_s;system;system_id;entity;entity_id;dst;dst_ent;value [V]\n\
                1970-01-01T00:00:01.500000Z;1,500000;0x2a10;0x2a10;;0;0xffff;255;24,5\n";
    assert_eq!(table.text(), text);
}
