//! Dependencies between crates point to lower layers, and cores stay free of sockets, threads and clocks.
//!
//! ARCHITECTURE.md draws the layers; this test enforces them.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

#[path = "architecture/circles.rs"]
mod circles;

use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

/// Each crate's layer. A crate depends on lower layers only.
const LAYERS: [(u8, &[&str]); 8] = [
    (0, &["book", "manual", "parquetfile", "service", "suggest", "units"]),
    (1, &["charts", "devices", "geofile", "imc", "provision"]),
    (2, &["detections", "guard", "tiles"]),
    (3, &["acoustics", "config", "control", "drivers", "link", "mission", "planner", "tables"]),
    (4, &["api", "chartdb", "hub", "onboard", "sim", "store"]),
    (5, &["operations", "research"]),
    (6, &["shore"]),
    (7, &["imc-cli", "lutra-tests", "server", "vehicle-agent", "xtask"]),
];

/// Number of modules of each crate in dependency cycles. There may be fewer, never more: after breaking one, lower the
/// number.
const IN_CIRCLES: [(&str, usize); 2] = [("charts", 10), ("imc", 5)];

/// `onboard` and `shore` translate between IMC and these.
const NEVER_KNOW_IMC: [&str; 6] = ["charts", "control", "guard", "mission", "planner", "tiles"];

/// Crates that a core must not use: runtimes, sockets, clocks, randomness.
const NOT_IN_CORES: [&str; 12] = [
    "async-std",
    "axum",
    "chrono",
    "hyper",
    "mio",
    "rand",
    "reqwest",
    "socket2",
    "time",
    "tokio",
    "tungstenite",
    "ureq",
];

/// Crates in `crates/` that are allowed to do input and output.
const SHELLS_IN_CRATES: [&str; 3] = ["chartdb", "config", "store"];

struct Package {
    name: String,
    folder: String,
    /// Normal and build dependencies by name.
    uses: Vec<String>,
}

fn packages() -> Vec<Package> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--no-deps", "--offline", "--format-version", "1"])
        .current_dir(testkit::repository())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    let package = |package: &Value| {
        let depended = package["dependencies"].as_array().unwrap().iter();
        Package {
            name: text(&package["name"]),
            folder: text(&package["manifest_path"]),
            uses: depended.filter(|one| one["kind"] != "dev").map(|one| text(&one["name"])).collect(),
        }
    };
    metadata["packages"].as_array().unwrap().iter().map(package).collect()
}

fn layers() -> BTreeMap<&'static str, u8> {
    LAYERS.iter().flat_map(|(layer, names)| names.iter().map(|name| (*name, *layer))).collect()
}

#[test]
fn every_crate_has_a_layer() {
    let layers = layers();
    for package in packages() {
        let known = layers.contains_key(package.name.as_str()) || package.name == "testkit";
        assert!(known, "{} stands in no layer of tests/tests/architecture.rs", package.name);
    }
}

#[test]
fn arrows_point_down() {
    let layers = layers();
    for package in packages().iter().filter(|package| package.name != "testkit") {
        for used in &package.uses {
            assert_ne!(used, "testkit", "{} uses testkit outside its tests", package.name);
            if let Some(layer) = layers.get(used.as_str()) {
                assert!(*layer < layers[package.name.as_str()], "{} -> {used} points up", package.name);
            }
        }
    }
}

#[test]
fn only_translators_know_both_imc_and_the_cores() {
    for package in packages() {
        let forbidden = NEVER_KNOW_IMC.contains(&package.name.as_str());
        assert!(!(forbidden && package.uses.iter().any(|used| used == "imc")), "{} knows imc", package.name);
    }
}

#[test]
fn cores_are_pure() {
    for package in packages() {
        let core = package.folder.contains("/crates/") && !SHELLS_IN_CRATES.contains(&package.name.as_str());
        for used in package.uses.iter().filter(|_| core) {
            assert!(!NOT_IN_CORES.contains(&used.as_str()), "{} uses {used}", package.name);
        }
    }
}

/// Files and folders that the developer documents name, recognised by backticks and a slash.
#[test]
fn what_the_documents_name_is_there() {
    for document in ["ARCHITECTURE.md", "CONTRIBUTING.md", "docs/extending.md"] {
        let text = std::fs::read_to_string(testkit::repository().join(document)).unwrap();
        let named = text.split('`').skip(1).step_by(2).filter(|name| {
            let path = |letter: char| letter.is_ascii_alphanumeric() || "/._-".contains(letter);
            // Absolute paths are on other computers; paths outside of the checkout are ignored.
            name.contains('/')
                && !name.starts_with("target/")
                && name.starts_with(|first: char| first.is_ascii_lowercase())
                && name.chars().all(path)
        });
        let mut paths = 0;
        for name in named {
            assert!(testkit::repository().join(name).exists(), "{document} names {name}, which is not there");
            paths += 1;
        }
        assert!(document != "docs/extending.md" || paths > 60, "{document} names {paths} files only");
    }
}

#[test]
fn circles_of_modules_become_fewer_and_never_more() {
    let known = BTreeMap::from(IN_CIRCLES);
    let mut wrong = Vec::new();
    for package in packages() {
        let circular = circles::in_circles(&Path::new(&package.folder).with_file_name("src"));
        let known = known.get(package.name.as_str()).copied().unwrap_or_default();
        if circular.len() != known {
            wrong.push(format!(
                "{}: {known} are known, these are {}: {circular:?}",
                package.name,
                circular.len()
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
