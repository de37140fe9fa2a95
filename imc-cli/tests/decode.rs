//! `imc decode` and `imc encode` on golden, damaged, recorded and random bytes.

mod harness;

use harness::{Running, golden, gunzip, gzip, heartbeat, run, vectors};
use serde_json::Value;
use std::fmt::Write as _;
use std::io::Write as _;
use std::process::Stdio;

#[test]
fn golden_vectors_decode_to_their_values() {
    let Some(vectors) = vectors() else { return };
    for form in ["packet_le", "packet_be"] {
        let text = golden(&vectors, form).join("\n");
        let shown = run(&["decode"], text.as_bytes()).expect(0).lines();
        let all = vectors["vectors"].as_array().unwrap();
        assert_eq!(shown.len(), all.len());
        for (shown, vector) in shown.iter().zip(all) {
            for key in ["abbrev", "id", "header", "fields"] {
                assert_eq!(shown[key], vector[key], "{}", vector["name"]);
            }
        }
    }
}

#[test]
fn decode_and_encode_are_inverse_on_golden_vectors_in_both_orders() {
    let Some(vectors) = vectors() else { return };
    for form in ["packet_le", "packet_be"] {
        let text = golden(&vectors, form).join("\n") + "\n";
        let bytes = hex::decode(text.replace('\n', "")).unwrap();
        let from_text = run(&["decode"], text.as_bytes()).expect(0);
        let from_bytes = run(&["decode", "-"], &bytes).expect(0);
        assert_eq!(from_text.text(), from_bytes.text());
        assert_eq!(run(&["encode"], &from_text.stdout).expect(0).stdout, bytes);
        assert_eq!(run(&["encode", "--hex"], &from_text.stdout).expect(0).text(), text);
    }
}

#[test]
fn big_endian_can_be_forced() {
    let Some(vectors) = vectors() else { return };
    let little = golden(&vectors, "packet_le").join("\n");
    let big = golden(&vectors, "packet_be").join("\n") + "\n";
    let shown = run(&["decode"], little.as_bytes()).expect(0);
    assert_eq!(run(&["encode", "--hex", "--big-endian"], &shown.stdout).expect(0).text(), big);
}

#[test]
fn large_packets_survive() {
    for bytes in [4_096_usize, 65_513, 65_533] {
        let value = "5a".repeat(bytes);
        let line = format!(r#"{{"abbrev":"DevDataBinary","fields":{{"value":"{value}"}}}}"#);
        let packet = run(&["encode"], line.as_bytes()).expect(0).stdout;
        assert_eq!(packet.len(), bytes + 24);
        let shown = run(&["decode"], &packet).expect(0);
        assert_eq!(shown.lines()[0]["fields"]["value"], value);
        assert_eq!(run(&["encode"], &shown.stdout).expect(0).stdout, packet);
    }
}

#[test]
fn recordings_decode_without_damage_and_back_to_their_bytes() {
    for name in ["dune_capture_a.imc.gz", "dune_capture_a_udp.imc.gz", "dune_log_a/Data.lsf.gz"] {
        let Some(path) = testkit::shared(&format!("data/imc/{name}")) else { return };
        let shown = run(&["decode", path.to_str().unwrap()], b"").expect(0);
        let made = run(&["encode"], &shown.stdout).expect(0).stdout;
        assert!(made == gunzip(&path), "{name}");
    }
}

#[test]
fn malformed_packets_give_their_class_one_line_each() {
    let Some(vectors) = vectors() else { return };
    let all = vectors["malformed"].as_array().unwrap();
    let text: String = all.iter().fold(String::new(), |mut text, vector| {
        writeln!(text, "{}", vector["packet"].as_str().unwrap()).unwrap();
        text
    });
    let shown = run(&["decode", "--hex"], text.as_bytes()).expect(1).lines();
    assert_eq!(shown.len(), all.len());
    for (number, (shown, vector)) in shown.iter().zip(all).enumerate() {
        let name = &vector["name"];
        match vector["expected_error"].as_str().unwrap() {
            "implementation_choice" => assert!(shown.get("abbrev").is_some(), "{name}"),
            class => {
                assert_eq!(shown["error"], class, "{name}");
                assert_eq!(shown["line"], number + 1, "{name}");
                assert!(shown["message"].as_str().unwrap().len() > 10, "{name}");
                let kept = !["bad_sync", "bad_crc", "truncated"].contains(&class);
                assert_eq!(shown.get("packet"), kept.then_some(&vector["packet"]), "{name}");
                assert_eq!(shown.get("header").is_some(), kept, "{name}");
            }
        }
    }
}

#[test]
fn malformed_packets_give_their_class_as_raw_bytes() {
    let Some(vectors) = vectors() else { return };
    for vector in vectors["malformed"].as_array().unwrap() {
        let bytes = hex::decode(vector["packet"].as_str().unwrap()).unwrap();
        let class = vector["expected_error"].as_str().unwrap();
        let status = i32::from(class != "implementation_choice");
        let shown = run(&["decode", "--raw"], &bytes).expect(status).lines();
        if status == 1 {
            assert_eq!(shown[0]["error"], class, "{}", vector["name"]);
            assert_eq!(shown[0]["offset"], 0);
            let damaged: u64 = shown.iter().map(|line| line["bytes"].as_u64().unwrap()).sum();
            assert_eq!(damaged, bytes.len() as u64, "{}", vector["name"]);
        }
    }
}

#[test]
fn every_hex_line_gives_one_line() {
    let good = heartbeat(1.0).iter().map(|byte| format!("{byte:02X}")).collect::<Vec<_>>().join(" ");
    let text =
        format!("{good}\r\n\n54fe0\n{good}{good}\nsalmon\n{good} 00\n{}\n{good}", "ab".repeat(200_000));
    let shown = run(&["decode", "--hex"], text.as_bytes()).expect(1).lines();
    let classes: Vec<&str> = shown.iter().map(|line| line["error"].as_str().unwrap_or("")).collect();
    let expected = ["", "truncated", "bad_hex", "excess_bytes", "bad_hex", "excess_bytes", "bad_sync", ""];
    assert_eq!(classes, expected);
    assert_eq!(shown[2]["offset"], 2);
    assert_eq!((&shown[3]["offset"], &shown[3]["bytes"]), (&Value::from(22), &Value::from(22)));
    assert_eq!(shown[4]["message"], "`s` in column 1 is not a hexadecimal digit");
    assert_eq!(shown[6]["bytes"], 200_000);
    // Nothing of the excess is lost.
    let back = run(&["encode", "--hex"], shown[3].to_string().as_bytes()).expect(0);
    assert_eq!(back.text().trim(), (good.clone() + &good).replace(' ', "").to_lowercase());
}

#[test]
fn hex_text_is_detected() {
    let hex: String = heartbeat(1.0).iter().fold(String::new(), |text, byte| text + &format!("{byte:02x}"));
    for text in [hex.clone(), format!("\n  {hex}\n"), hex.to_uppercase(), format!("{hex}\nrubbish")] {
        let shown = run(&["decode"], text.as_bytes());
        assert!(shown.text().contains("Heartbeat"), "{text}");
    }
    // Raw packets never look like text, and text can be forced to be raw.
    assert_eq!(run(&["decode"], &heartbeat(1.0)).expect(0).lines()[0]["abbrev"], "Heartbeat");
    assert_eq!(run(&["decode", "--raw"], hex.as_bytes()).expect(1).lines()[0]["error"], "bad_sync");
}

#[test]
fn damage_stands_in_its_place() {
    let (first, second) = (heartbeat(1.0), heartbeat(2.0));
    let bytes = [&first[..], b"salmon", &second, &first[..20]].concat();
    let shown = run(&["decode"], &bytes).expect(1).lines();
    assert_eq!(shown.len(), 4);
    assert_eq!(
        (&shown[1]["error"], &shown[1]["offset"], &shown[1]["bytes"]),
        (&"bad_sync".into(), &22.into(), &6.into())
    );
    assert_eq!(shown[2]["header"]["timestamp"], 2.0);
    assert_eq!(
        (&shown[3]["error"], &shown[3]["offset"], &shown[3]["bytes"]),
        (&"truncated".into(), &50.into(), &20.into())
    );
}

#[test]
fn lenient_accepts_payloads_that_end_early() {
    let Some(vectors) = vectors() else { return };
    let all = vectors["malformed"].as_array().unwrap();
    let short = all.iter().find(|vector| vector["name"] == "bad_22_payload_too_short").unwrap();
    let text = short["packet"].as_str().unwrap();
    assert_eq!(run(&["decode", "--hex"], text.as_bytes()).expect(1).lines()[0]["error"], "field_overrun");
    let shown = run(&["decode", "--hex", "--lenient"], text.as_bytes()).expect(0);
    assert_eq!(shown.lines()[0]["absent"], serde_json::json!(["vacc"]));
    assert_eq!(run(&["encode", "--hex"], &shown.stdout).expect(0).text().trim(), text);
}

#[test]
fn gzip_is_unpacked_and_its_damage_told() {
    let (first, second) = (heartbeat(1.0), heartbeat(2.0));
    let members = [gzip(&first), gzip(&second)].concat();
    assert_eq!(run(&["decode"], &members).expect(0).lines().len(), 2);
    let cut = run(&["decode"], &members[..members.len() - 9]).expect(1).lines();
    assert_eq!(cut.last().unwrap()["error"], "bad_gzip");
    assert_eq!(cut[0]["header"]["timestamp"], 1.0);
    let rubbish = run(&["decode"], &[&members[..], b"rubbish"].concat()).expect(1).lines();
    assert_eq!((rubbish.len(), &rubbish[2]["error"]), (3, &"bad_gzip".into()));
    let text = gzip(b"54fe\n54fe\n");
    assert_eq!(run(&["decode"], &text).expect(1).lines().len(), 2);
}

#[test]
fn the_first_packet_shows_before_the_rest_arrives() {
    let (first, second) = (heartbeat(1.0), heartbeat(2.0));
    let mut decode = Running::start(&["decode"]);
    let stdin = decode.stdin.as_mut().unwrap();
    stdin.write_all(&[&first[..], &second[..5]].concat()).unwrap();
    stdin.flush().unwrap();
    assert_eq!(decode.json()["header"]["timestamp"], 1.0);
    decode.stdin.as_mut().unwrap().write_all(&second[5..]).unwrap();
    assert_eq!(decode.json()["header"]["timestamp"], 2.0);
    assert_eq!(decode.finish(), (0, Vec::new()));
}

#[test]
fn encode_answers_line_by_line() {
    let mut encode = Running::start(&["encode", "--hex"]);
    for _ in 0..2 {
        encode.stdin.as_mut().unwrap().write_all(b"{\"abbrev\":\"Heartbeat\"}\n").unwrap();
        assert!(encode.line().starts_with("54fe9600"));
    }
    assert_eq!(encode.finish(), (0, Vec::new()));
}

#[test]
fn encode_names_the_line_and_the_place_of_each_mistake() {
    let lines = [
        r#"{"abbrev":"Temperature","fields":{"value":7.5}}"#,
        r#"{"abbrev":"PlanControl","fields":{"arg":{"abbrev":"Goto","fields":{"lat":"north"}}}}"#,
        "{\"abbrev\":",
        "",
        r#"{"error":"bad_crc","offset":0,"bytes":22,"message":"..."}"#,
        r#"{"abbrev":"Temprature"}"#,
        r#"{"error":"unknown_id","packet":"xy"}"#,
        r#"{"abbrev":"Heartbeat"}"#,
    ];
    let made = run(&["encode", "--hex"], lines.join("\n").as_bytes()).expect(1);
    assert_eq!(made.text().lines().count(), 2);
    for part in [
        "standard input:2: fields.arg.fields.lat: \"north\" is not a number",
        "standard input:3: no JSON from column 10",
        "standard input:5: error: decode found bad_crc here",
        "standard input:6: abbrev: no message is called `Temprature`; did you mean Temperature",
        "standard input:7: packet: expected bytes as pairs",
    ] {
        assert!(made.stderr.contains(part), "{part}\n{}", made.stderr);
    }
    assert_eq!(made.stderr.lines().count(), 5);
}

#[test]
fn undecodable_packets_are_written_back_verbatim() {
    let Some(vectors) = vectors() else { return };
    let all = vectors["malformed"].as_array().unwrap();
    let whole: Vec<&str> = all
        .iter()
        .filter(|vector| {
            !["bad_sync", "bad_crc", "truncated"].contains(&vector["expected_error"].as_str().unwrap())
        })
        .map(|vector| vector["packet"].as_str().unwrap())
        .collect();
    assert_eq!(whole.len(), 14);
    let bytes = hex::decode(whole.concat()).unwrap();
    let shown = run(&["decode"], &bytes).expect(1);
    assert_eq!(run(&["encode"], &shown.stdout).expect(0).stdout, bytes);
}

#[test]
fn a_closed_pipe_is_silent() {
    let bytes: Vec<u8> = heartbeat(1.0).repeat(100_000);
    let mut child = harness::command(&["decode"]).spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    drop(child.stdout.take());
    let feeder = std::thread::spawn(move || drop(stdin.write_all(&bytes)));
    let output = child.wait_with_output().unwrap();
    feeder.join().unwrap();
    assert_eq!((output.status.code(), output.stderr.as_slice()), (Some(0), &b""[..]));
}

#[test]
fn a_full_disk_is_told() {
    let Ok(full) = std::fs::File::create("/dev/full") else { return };
    let mut child = harness::command(&["decode"]).stdout(Stdio::from(full)).spawn().unwrap();
    child.stdin.take().unwrap().write_all(&heartbeat(1.0)).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("writing to standard output"));
}

#[test]
fn misuse_has_a_status_of_its_own() {
    for arguments in [
        &["decode", "/no/such/file"][..],
        &["decode", "/"],
        &["decode", "--hex", "--raw"],
        &["decode", "--sideways"],
        &["encode", "/no/such/file"],
        &["info", "Salmon"],
        &["info", "3999"],
        &["address", "70000"],
        &["address", "0xsalmon"],
        &["salmon"],
        &[],
    ] {
        let done = run(arguments, b"").expect(2);
        assert!(done.stdout.is_empty() && !done.stderr.is_empty(), "{arguments:?}");
    }
    assert!(run(&["decode", "/no/such/file"], b"").stderr.contains("/no/such/file: No such file"));
}

#[test]
fn rubbish_never_panics() {
    // A fixed sequence (xorshift), the sync number strewn in.
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    for round in 0..24 {
        let mut bytes: Vec<u8> = (0..4_000)
            .map(|_| {
                state ^= state << 13;
                state ^= state >> 7;
                state ^= state << 17;
                state as u8
            })
            .collect();
        for at in (0..bytes.len() - 2).step_by(97 + round) {
            bytes[at..at + 2].copy_from_slice(&[0x54, 0xFE]);
        }
        for arguments in
            [&["decode"][..], &["decode", "--hex"], &["decode", "--lenient"], &["encode", "--hex"]]
        {
            let done = run(arguments, &bytes);
            assert!([0, 1].contains(&done.status), "{}", done.stderr);
            assert!(!done.stderr.contains("panicked"), "{}", done.stderr);
        }
    }
}

#[test]
#[cfg(target_os = "linux")]
fn memory_stays_bounded_whatever_comes() {
    let block = vec![b'a'; 1 << 20];
    for (arguments, most_kib) in [
        (&["decode", "--hex"][..], 16 << 10),
        (&["decode", "--raw"], 16 << 10),
        // A line of JSON may be long, but not unlimited.
        (&["encode", "--hex"], 64 << 10),
    ] {
        let mut running = Running::start(arguments);
        for _ in 0..24 {
            running.stdin.as_mut().unwrap().write_all(&block).unwrap();
        }
        let peak = running.peak_kib();
        assert!(peak < most_kib, "{arguments:?}: {peak} KiB");
        assert_eq!(running.finish().0, 1);
    }
}

#[test]
fn nothing_in_gives_nothing_out() {
    for arguments in [&["decode"][..], &["decode", "--hex"], &["encode"]] {
        assert!(run(arguments, b"").expect(0).stdout.is_empty());
    }
}
