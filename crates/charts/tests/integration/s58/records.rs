//! Records that are there twice, are not there, or say what cannot be.

use super::chart::{Chart, MIDDLE, at};
use super::{Must, Row};
use charts::s57::ObjectClass as Class;
use charts::s57::Sounding;
use charts::s57::write::FeatureDraft;

fn twice(tag: &'static str) -> Chart {
    let mut chart = Chart::deep();
    chart.rock(&[]);
    chart.repeated = Some(tag);
    chart
}

/// With other factors for coordinates and depths than those by which the file is written.
fn factors(coordinate: u32, sounding: u32) -> Chart {
    let mut chart = Chart::deep();
    let node = chart.cell.records.soundings(&[Sounding { at: at(MIDDLE), depth_m: 1.0 }]);
    chart.add(FeatureDraft::point(Class::SOUNDG, node));
    let said = |coordinate: u32, sounding: u32| [coordinate.to_le_bytes(), sounding.to_le_bytes()].concat();
    chart.patches.push((said(10_000_000, 10), said(coordinate, sounding)));
    chart
}

/// With a head that says something else of the counts of records: features, isolated nodes, connected nodes, edges.
fn more_announced(at: usize) -> Chart {
    let mut chart = Chart::deep();
    chart.rock(&[]);
    // M_COVR; DEPARE and the rock; no collection; one isolated node, four connected ones, four edges; no faces.
    let counts = [1_u32, 0, 2, 0, 1, 4, 4, 0];
    let bytes = |counts: [u32; 8]| counts.iter().flat_map(|count| count.to_le_bytes()).collect::<Vec<u8>>();
    let mut more = counts;
    more[at] += 1;
    chart.patches.push((bytes(counts), bytes(more)));
    chart
}

pub(super) const ROWS: &[Row] = &[
    ("an object that is there twice", || twice("FRID"), Must::Refuse("feature 3 is there twice")),
    ("a node or edge that is there twice", || twice("VRID"), Must::Refuse("vector record 1 is there twice")),
    (
        "two sets of parameters",
        || twice("DSPM"),
        Must::Refuse("set of parameters (field DSPM) is there twice"),
    ),
    ("two identifications", || twice("DSID"), Must::Refuse("identification (field DSID) is there twice")),
    ("a coordinate factor of zero", || factors(0, 10), Must::Refuse("the factor COMF")),
    ("a depth factor of zero", || factors(10_000_000, 0), Must::Refuse("the factor SOMF")),
    (
        "a coordinate factor that leads off the globe",
        || factors(1_000_000, 10),
        Must::Refuse("a position is out of range"),
    ),
    (
        "an object fewer than announced",
        || more_announced(2),
        Must::Refuse("announces 4 features, but it has only 3"),
    ),
    ("a meta object fewer than announced", || more_announced(0), Must::Refuse("announces 4 features")),
    ("a collection fewer than announced", || more_announced(3), Must::Refuse("announces 4 features")),
    (
        "an isolated node fewer than announced",
        || more_announced(4),
        Must::Refuse("announces 2 isolated nodes"),
    ),
    (
        "a connected node fewer than announced",
        || more_announced(5),
        Must::Refuse("announces 5 connected nodes"),
    ),
    ("an edge fewer than announced", || more_announced(6), Must::Refuse("announces 5 edges")),
];
