//! `lutra-server chart` as an operator runs it.

use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Output};

fn chart(data: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lutra-server"));
    command.arg("chart").args(arguments).arg("--data").arg(data).output().unwrap()
}

fn json(data: &Path, arguments: &[&str]) -> Value {
    let output = chart(data, &[arguments, &["--json"]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn a_cell_is_imported_asked_exported_and_removed() {
    let Some(cell) = testkit::shared("data/charts/GB5X01NW.000") else { return };
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path();
    let none = chart(data, &["list"]);
    assert!(!none.status.success());
    assert!(String::from_utf8_lossy(&none.stderr).contains("make one by `lutra-server chart import`"));

    let done = json(data, &["import", cell.to_str().unwrap()]);
    assert_eq!(done["charts"][0]["outcome"]["outcome"], "added", "{done}");
    assert_eq!(done["charts"][0]["skin"]["holds"], true);
    assert!(data.join("charts/chart.gpkg").exists() && data.join("charts/chart.lutra-index").exists());
    assert_eq!(json(data, &["list"])["digest"], done["digest"]);
    // The census of data/charts/README.md.
    assert_eq!(json(data, &["info", "gb5x01nw"])["charts"][0]["classes"]["DEPARE"], 54);
    // What is not navigable is an answer, and a failure for scripts.
    let unknown = chart(data, &["depth", "--at", "-32.0,60.9", "--json"]);
    let told: Value = serde_json::from_slice(&unknown.stdout).unwrap();
    assert_eq!((&told["water"], &told["navigable"]), (&"no data".into(), &false.into()), "{told}");
    assert_eq!(unknown.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&unknown.stderr).contains("the place is not navigable with these needs"));
    let point = chart(data, &["depth", "--at", "-32.47,60.9"]);
    assert!(String::from_utf8_lossy(&point.stderr).contains("--radius M"), "single rocks are not looked at");
    let around = chart(data, &["depth", "--at", "-32.47,60.9", "--radius", "10"]);
    assert!(!String::from_utf8_lossy(&around.stderr).contains("--radius M"));
    let corridor = chart(data, &["corridor", "--from", "-32.49,60.88", "--to", "-32.46,60.95", "--json"]);
    let is_navigable = corridor.status.success();
    let corridor: Value = serde_json::from_slice(&corridor.stdout).unwrap();
    assert_eq!(is_navigable, corridor["first_danger"].is_null(), "{corridor}");
    assert_eq!(corridor["object"]["chart"], "GB5X01NW", "{corridor}");

    let csv = data.join("grid.csv");
    let corners = ["export-grid", "--from", "-32.50,60.87", "--to", "-32.45,60.96", "--spacing", "100"];
    let rows = json(data, &[&corners[..], &["-o", csv.to_str().unwrap()]].concat())["rows"].clone();
    let text = std::fs::read_to_string(&csv).unwrap();
    assert_eq!(rows, text.lines().count() - 1);
    let table = data.join("grid.db");
    let adapt = ["--deep", "10", "--coarsest", "1600", "-o", table.to_str().unwrap()];
    let few = json(data, &[&corners[..], &adapt[..]].concat())["rows"].as_u64().unwrap();
    assert!(few > 0 && few < rows.as_u64().unwrap(), "{few} of {rows}");
    let vertices = data.join("contours.csv");
    assert!(
        json(data, &["export-vertices", "-o", vertices.to_str().unwrap()])["rows"].as_u64().unwrap() > 1000
    );

    json(data, &["remove", "GB5X01NW"]);
    assert_eq!(json(data, &["list"])["charts"], serde_json::json!([]));
}

#[test]
fn a_plan_is_checked_and_the_exit_code_tells_whether_it_may_be_sailed() {
    let folder = tempfile::tempdir().unwrap();
    let (data, cells) = (folder.path().join("data"), folder.path().join("cells"));
    std::fs::create_dir(&cells).unwrap();
    for file in charts::demo::archipelago().unwrap() {
        std::fs::write(cells.join(file.name), file.bytes).unwrap();
    }
    let plan = |name: &str, places: [[f64; 2]; 2]| {
        let path = folder.path().join(name);
        let line = places.map(|[lat, lon]| format!("[{lon},{lat}]")).join(",");
        let geometry = format!(r#"{{"type":"LineString","coordinates":[{line}]}}"#);
        let feature = format!(r#"{{"type":"Feature","properties":{{}},"geometry":{geometry}}}"#);
        std::fs::write(&path, feature).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let open = plan("open.geojson", [[63.4465, 10.3500], [63.4485, 10.3530]]);
    let shoal = plan("shoal.geojson", [[63.4460, 10.3516], [63.4424, 10.3516]]);
    // Without a chart nothing is reported as safe.
    let none = chart(&data, &["check", &open]);
    assert!(!none.status.success() && none.stdout.is_empty());
    json(&data, &["import", cells.to_str().unwrap()]);

    let told = json(&data, &["check", &open]);
    assert!(told["outcome"] != "refused" && told["reasons"] == serde_json::json!([]), "{told}");
    let output = chart(&data, &["check", &shoal, "--json"]);
    assert_eq!(output.status.code(), Some(1));
    let told: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(told["outcome"], "refused");
    let reason = told["reasons"][0]["text"].as_str().unwrap();
    assert!(reason.contains("XX5LUTRA"), "{told}");
    let complaint = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(complaint.contains("shoal.geojson: the chart shows danger"), "{complaint}");
    // In words, the same reason.
    let words = chart(&data, &["check", &shoal]);
    assert!(String::from_utf8_lossy(&words.stdout).contains(&format!("refused: {reason}")));
    // The transit to the first waypoint is checked if the start is known.
    let output = chart(&data, &["check", &open, "--from", "63.4424,10.3516"]);
    assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stdout));
    for (plan, why) in [
        ("nowhere.json", "there is no such file, and it is not a number of a plan"),
        ("7", "keeps no plan 7"),
    ] {
        let output = chart(&data, &["check", plan]);
        let complaint = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && complaint.contains(why), "{complaint}");
    }
    let text = plan("text.json", [[0.0, 0.0]; 2]);
    std::fs::write(&text, "no plan at all").unwrap();
    let output = chart(&data, &["check", &text]);
    assert!(String::from_utf8_lossy(&output.stderr).contains("text.json"), "{output:?}");
    assert!(!output.status.success());
}

fn plan_route(data: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lutra-server"));
    command.args(["plan", "route"]).args(arguments).arg("--data").arg(data).output().unwrap()
}

/// The grid search of the thesis beside the exact route, in words and in JSON, and what it refuses.
fn beside_the_classic_grid(data: &Path, ends: &[&str]) {
    let asked = |more: &[&str]| plan_route(data, &[ends, &["--clearance", "0", "--classic"], more].concat());
    let words = asked(&["--resolution", "20"]);
    assert!(words.status.success(), "{words:?}");
    let words = String::from_utf8(words.stdout).unwrap();
    for part in ["legs refused", "exact route ", "grid of 20 m ", "grid of 20 to "] {
        assert!(words.contains(part), "{part}: {words}");
    }
    let rows = |more: &[&str]| {
        let output = asked(&[more, &["--json"]].concat());
        assert!(output.status.success(), "{output:?}");
        let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
        answer["classic"].as_array().unwrap().clone()
    };
    let [eight, sixteen, dijkstra] = [&[][..], &["--neighbours", "16"], &["--weight", "0"]]
        .map(|more| rows(&[&["--resolution", "20"], more].concat()));
    let number = |rows: &[Value], row: usize, name: &str| rows[row][name].as_f64().unwrap();
    let exact_m = number(&eight, 0, "length_m");
    assert_eq!(eight[0]["legs_refused"], 0, "{eight:?}");
    assert!(exact_m < number(&eight, 1, "length_m"), "{eight:?}");
    assert!(number(&sixteen, 1, "length_m") < number(&eight, 1, "length_m"), "{sixteen:?} {eight:?}");
    assert!(number(&eight, 1, "closed") < number(&dijkstra, 1, "closed"), "{eight:?} {dijkstra:?}");
    assert!((number(&eight, 1, "length_m") - number(&dijkstra, 1, "length_m")).abs() < 0.1);
    assert!(number(&eight, 2, "cells") < number(&eight, 1, "cells") / 2.0, "{eight:?}");
    assert_eq!(rows(&[])[1]["search"], "grid of 5 m", "the finest of a million cells");
    for (wrong, remedy) in [
        (&["--resolution", "0.2"][..], "give a resolution of 1 m or more"),
        (&["--resolution", "-3"], "--resolution: give a size above 0 m"),
        (&["--resolution", "5000"], "give a finer --resolution"),
        (&["--weight", "nan"], "--weight: give a weight of 0 to 100"),
        (&["--neighbours", "4"], "give 8 or 16"),
        (&["--via", "63.44,10.33"], "cannot be used with"),
    ] {
        let output = asked(wrong);
        let complaint = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && complaint.contains(remedy), "{wrong:?}: {complaint}");
    }
}

/// One route as text, as GPX and as a plan that passes the chart's check; many from a file, with an answer for each line.
#[test]
fn routes_are_planned_by_the_command_line() {
    let folder = tempfile::tempdir().unwrap();
    let (data, cells) = (folder.path().join("data"), folder.path().join("cells"));
    std::fs::create_dir(&cells).unwrap();
    for cell in charts::demo::archipelago().unwrap() {
        std::fs::write(cells.join(cell.name), cell.bytes).unwrap();
    }
    json(&data, &["import", cells.to_str().unwrap()]);
    let (east, west) = ("63.4455,10.352", "63.4455,10.314");
    let ends = ["--from", east, "--to", west];
    let words = plan_route(&data, &ends);
    assert!(words.status.success(), "{}", String::from_utf8_lossy(&words.stderr));
    assert!(String::from_utf8_lossy(&words.stdout).contains("least depth 5.0 m"));
    let warned = |output: &Output| String::from_utf8_lossy(&output.stderr).contains("vessel off its track");
    assert!(warned(&words), "as the Otters' path monitor is set: {words:?}");
    assert!(!warned(&plan_route(&data, &[&ends[..], &["--stray", "4"]].concat())));
    let plan = folder.path().join("route.json");
    let gpx = folder.path().join("route.gpx");
    for file in [&plan, &gpx] {
        let out = ["--out", file.to_str().unwrap()];
        assert!(plan_route(&data, &[&ends[..], &out[..]].concat()).status.success());
        let checked = chart(&data, &["check", file.to_str().unwrap(), "--from", east]);
        assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stdout));
    }
    let wrong = plan_route(&data, &[&ends[..], &["--out", "route.kml"]].concat());
    assert!(String::from_utf8_lossy(&wrong.stderr).contains(".geojson, .gpx or .json"));

    let field = folder.path().join("tide.csv");
    let mut tide = "time,lat,lon,east_mps,north_mps\n".to_owned();
    for (lat, east_mps) in [(63.43, 1.2), (63.444, 1.2), (63.446, 0.1), (63.47, 0.1)] {
        for lon in [10.29, 10.37] {
            writeln!(tide, "2026-11-21T06:00:00Z,{lat},{lon},{east_mps},0").unwrap();
        }
    }
    std::fs::write(&field, &tide).unwrap();
    let weighed = |more: &[&str]| {
        let output = plan_route(&data, &[&ends[..], more].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice::<Value>(&output.stdout).unwrap()
    };
    let tide = ["--current-field", field.to_str().unwrap(), "--depart", "2026-11-21T06:00Z", "--json"];
    let fastest = weighed(&[&["--objective", "fastest"], &tide[..]].concat());
    assert!(fastest["duration_s"].as_f64().unwrap() > 0.0, "{fastest}");
    assert!(fastest["length_m"].as_f64() > fastest["shortest"]["length_m"].as_f64(), "{fastest}");
    let thrifty = weighed(&["--objective", "least-energy", "--json"]);
    assert!(thrifty["speed_mps"].as_f64().unwrap() < 1.0 && thrifty["shortest"].is_null(), "{thrifty}");
    let words = plan_route(&data, &[&ends[..], &["--prefer-depth", "20", "--prefer-factor", "10"]].concat());
    let words = String::from_utf8(words.stdout).unwrap();
    assert!(words.contains("the shortest route, ") && words.contains(" m shorter:"), "{words}");
    let area = folder.path().join("slow.geojson");
    let ring = "[[10.318, 63.4], [10.2, 63.4], [10.2, 63.5], [10.318, 63.5], [10.318, 63.4]]";
    std::fs::write(&area, format!(r#"{{"type": "Polygon", "coordinates": [{ring}]}}"#)).unwrap();
    let limit = format!("0.5,{}", area.display());
    let slow = folder.path().join("slow-route.geojson");
    let limited = ["--limit", &limit, "--out", slow.to_str().unwrap()];
    let limited = plan_route(&data, &[&ends[..], &limited[..]].concat());
    assert!(limited.status.success(), "{limited:?}");
    assert!(
        String::from_utf8_lossy(&limited.stderr).contains("area with a speed limit keep it"),
        "{limited:?}"
    );
    // The maneuvers in the area keep its limit, the first one beside it the asked speed.
    let written = std::fs::read_to_string(&slow).unwrap();
    let plain: String = written.chars().filter(|letter| !letter.is_whitespace()).collect();
    for speed in [r#""value":0.5"#, r#""value":1.5"#, "Route2"] {
        assert!(plain.contains(speed), "{speed}: {written}");
    }
    std::fs::write(&field, "time,lat,lon,east_mps,north_mps\nnow,63,10,0,0\n").unwrap();
    let refused = plan_route(&data, &[&ends[..], &tide[..]].concat());
    assert!(
        String::from_utf8_lossy(&refused.stderr).contains("line 2: time: now is not a time"),
        "{refused:?}"
    );

    beside_the_classic_grid(&data, &ends);

    let pairs = folder.path().join("pairs.jsonl");
    let lines = [
        r#"{"id": 1, "from": [63.4455, 10.352], "to": [63.4455, 10.314], "min_depth": 5, "clearance": 20}"#,
        r#"{"id": "far", "from": [63.4455, 10.352], "to": [0, 0], "min_depth": 5, "clearance": 20}"#,
        r#"{"id": 3, "from": [63.4455, 10.352], "to": [163.4455, 10.314]}"#,
    ];
    std::fs::write(&pairs, lines.join("\n")).unwrap();
    let many = plan_route(&data, &["--pairs", pairs.to_str().unwrap()]);
    assert!(!many.status.success(), "a line made no sense");
    let answers: Vec<Value> = String::from_utf8(many.stdout)
        .unwrap()
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let [first, far, nonsense] = answers.as_slice() else { panic!("{answers:?}") };
    assert_eq!((first["ok"].as_bool(), first["id"].as_u64()), (Some(true), Some(1)), "{first}");
    assert!(first["length_m"].as_f64().unwrap() > 2_500.0 && first["time_us"].as_u64().unwrap() > 0);
    assert!(
        first["min_depth_m"].as_f64().unwrap() >= 5.0 && first["min_clearance_m"].as_f64().unwrap() >= 20.0
    );
    assert_eq!(first["points"].as_array().unwrap().len(), first["legs"].as_array().unwrap().len() + 1);
    assert_eq!(
        (far["ok"].as_bool(), far["code"].as_str(), far["id"].as_str()),
        (Some(false), Some("closed_goal"), Some("far"))
    );
    assert!(nonsense["reason"].as_str().unwrap().starts_with("line 3: to: 163.4455"), "{nonsense}");
}
