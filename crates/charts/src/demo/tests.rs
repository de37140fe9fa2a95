//! The archipelago against its own sea floor, and against what the demonstration needs of it.

use super::cell::stand;
use super::objects::{MARKS, PONTOONS};
use super::sea::{OPEN, SOUND, Sea};
use super::*;
use crate::depth_index::{Demand, DepthIndex, IndexBuilder, Leg, Water};
use crate::s57::{AttributeCode, Cell, NamedBytes, ObjectClass};
use std::collections::BTreeSet;
use std::sync::OnceLock;

fn files() -> &'static [DemoFile] {
    static FILES: OnceLock<Vec<DemoFile>> = OnceLock::new();
    FILES.get_or_init(|| archipelago().unwrap())
}

fn cells() -> &'static [Cell] {
    static CELLS: OnceLock<Vec<Cell>> = OnceLock::new();
    let read = |file: &DemoFile| Cell::read(NamedBytes { name: file.name, bytes: &file.bytes }, &[]).unwrap();
    CELLS.get_or_init(|| files().iter().map(read).collect())
}

fn index(cells: &[Cell]) -> DepthIndex {
    let mut builder = IndexBuilder::new();
    for cell in cells {
        builder.add_cell(cell).unwrap();
    }
    builder.build().unwrap()
}

fn place(at: [f64; 2]) -> LatLon {
    degrees(at).place().unwrap()
}

#[test]
fn cells_are_watertight_complete_and_marked() {
    let [approach, harbour] = cells() else { panic!("two cells") };
    for cell in [approach, harbour] {
        assert!(cell.notices.is_empty(), "{:?}", cell.notices);
        assert!(cell.skin_check().holds(), "{:?}", cell.skin_check());
        assert_eq!((cell.id.comment.as_str(), cell.id.standard.as_str()), (NOT_FOR_NAVIGATION, "03.1"));
        assert_eq!(cell.parameters.comment, NOT_FOR_NAVIGATION);
        let cover = cell.of_class(ObjectClass::M_COVR).next().unwrap();
        assert_eq!(cover.text(AttributeCode(102)), Some(NOT_FOR_NAVIGATION));
    }
    let classes: BTreeSet<_> = harbour.features.iter().map(|feature| feature.class.to_string()).collect();
    for class in [
        "ACHARE", "BCNLAT", "BCNSPP", "BOYCAR", "BOYISD", "BOYLAT", "BOYSPP", "BRIDGE", "CBLSUB", "COALNE",
        "DEPARE", "DEPCNT", "DRGARE", "LIGHTS", "LNDARE", "LNDMRK", "LNDRGN", "MARCUL", "M_COVR", "M_NSYS",
        "M_QUAL", "OBSTRN", "PILPNT", "PONTON", "SEAARE", "SLCONS", "SOUNDG", "UWTROC", "WRECKS",
    ] {
        assert!(classes.contains(class), "no {class}");
    }
    assert_eq!((approach.id.band, harbour.id.band), (4, 5));
    let name = |feature: &crate::s57::Feature| feature.text(AttributeCode::NOBJNM) == Some("Røyskattøya");
    assert!(harbour.features.iter().any(name));
    let lit = harbour.of_class(ObjectClass::BOYLAT).find(|buoy| !buoy.links.is_empty()).unwrap();
    let light = harbour.of_class(ObjectClass::LIGHTS).find(|light| light.object == lit.links[0].to).unwrap();
    assert_eq!(light.geometry, lit.geometry);
}

#[test]
fn every_run_gives_the_same_bytes() {
    assert_eq!(archipelago().unwrap(), files());
}

/// At every fifth point of the grid the chart says what the sea floor is.
#[test]
fn the_chart_agrees_with_the_sea_floor() {
    let (sea, all) = (Sea::new(), cells());
    for (extent, cell) in [&APPROACH, &HARBOUR].into_iter().zip(all) {
        let index = index(std::slice::from_ref(cell));
        let (mut land, mut water) = (0, 0);
        for j in (1..extent.size[1] - 1).step_by(5) {
            for i in (1..extent.size[0] - 1).step_by(5) {
                let along =
                    |axis: usize, count: usize| extent.south_west[axis] + extent.step_m * count as f64;
                let at = [along(0, i), along(1, j)];
                let depth = -sea.height_m(at);
                match index.depth_at(place(at), &Demand::default()).water {
                    Water::Land => {
                        land += 1;
                        let pontoon = |[west, south, east, north]: [f64; 4]| {
                            sea::Box { west, south, east, north }.distance(at) < 1.0
                        };
                        let dry = !extent.fine()
                            || depth < cell::COAST_M + 0.1
                            || PONTOONS.into_iter().any(pontoon);
                        assert!(dry, "{at:?}: land, but {depth} m deep");
                    }
                    Water::Depth { least_m, greatest_m } => {
                        water += 1;
                        // The coarse cell is on the shallow side; the samples keep off the contours.
                        assert!(least_m <= depth + 0.1, "{at:?}: {least_m} m, but {depth} m deep");
                        let deepest = greatest_m.unwrap_or(f64::INFINITY);
                        assert!(!extent.fine() || depth <= deepest + 0.1, "{at:?}: {deepest} m, but {depth}");
                    }
                    // A rock or an aid stands just there.
                    Water::Obstacle | Water::UnknownDepth => {}
                    other => panic!("{at:?}: {other:?}"),
                }
            }
        }
        assert!(land > 100 && water > 900, "{}: {land} {water}", extent.name);
    }
}

#[test]
fn the_otters_sail_in_safe_water_with_dangers_close_by() {
    let index = index(cells());
    let demand = Demand::least_depth(5.0);
    for step in 0..=(OPEN.north - OPEN.south) as i64 / 20 {
        let north_m = OPEN.south + 20.0 * step as f64;
        let leg = Leg { from: place([OPEN.west, north_m]), to: place([OPEN.east, north_m]) };
        let answer = index.shallowest_along(leg, 12.0, &demand);
        assert!(answer.navigable && answer.water.least_m() >= Some(10.0), "{north_m}: {answer:?}");
    }
    for at in [[0.0, 0.0], [0.0, 250.0], [750.0, 250.0]] {
        let danger = index.distance_to_shallower(place(at), 5.0, 500.0).unwrap();
        assert!((60.0..300.0).contains(&danger.distance_m), "{at:?}: {danger:?}");
    }
    // From the open water into the harbour, and not over the shoal beside the way.
    let harbour = Leg { from: place([470.0, -100.0]), to: place([470.0, -1_080.0]) };
    assert!(index.shallowest_along(harbour, 8.0, &Demand::least_depth(3.0)).navigable);
    let shoal = Leg { from: place([330.0, 0.0]), to: place([330.0, -400.0]) };
    assert!(!index.shallowest_along(shoal, 8.0, &Demand::least_depth(5.0)).navigable);
    for pair in SOUND.windows(2) {
        let leg = Leg { from: place(pair[0]), to: place(pair[1]) };
        assert!(index.shallowest_along(leg, 5.0, &Demand::least_depth(3.0)).navigable, "{pair:?}");
    }
    // It is narrow: the shores are close on both sides under the bridge.
    let across = Leg { from: place([1_400.0, 440.0]), to: place([1_640.0, 425.0]) };
    assert_eq!(index.shallowest_along(across, 1.0, &demand).water, Water::Land);
    assert!(!index.depth_at(place([-4_100.0, 0.0]), &demand).navigable, "beyond the cells is not data");
}

#[test]
fn marks_stand_on_land_and_float_in_water() {
    let sea = Sea::new();
    for mark in MARKS {
        let depth = -sea.height_m(stand(mark, &sea));
        let wet =
            mark.class.starts_with("BOY") || ["WRECKS", "OBSTRN", "SEAARE", "PILPNT"].contains(&mark.class);
        let dry = mark.perched || ["BCNLAT", "LNDRGN"].contains(&mark.class);
        assert!(!wet || depth > 1.5, "{} {:?}: {depth} m deep", mark.class, mark.at);
        assert!(!dry || depth < cell::COAST_M, "{} {:?}: {depth} m deep", mark.class, mark.at);
        let value = mark.attributes.iter().find(|(acronym, _)| *acronym == "VALSOU");
        let value: Option<f64> = value.map(|(_, value)| value.parse().unwrap());
        assert!(value.is_none_or(|value| value < depth), "{} {:?}: {depth} m deep", mark.class, mark.at);
    }
}
