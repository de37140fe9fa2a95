//! `lutra-server chart` as an operator runs it.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

use serde_json::Value;
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
    assert_eq!(json(data, &["depth", "--at", "-32.0,60.9"])["water"], "no data");
    let corridor = json(data, &["corridor", "--from", "-32.49,60.88", "--to", "-32.46,60.95"]);
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
