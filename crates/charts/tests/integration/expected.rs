//! Every shared cell, with its updates, against what GDAL 3.6.2 read from it (`expected.json`), and against
//! the invariant that needs no other reader.

use charts::s57::{AttributeCode, Cell, Feature, Geometry, NamedBytes, ObjectClass};
use serde_json::Value;
use std::collections::BTreeMap;

/// `US5WA22M+3` is the base with its updates 1 to 3.
fn read(key: &str) -> Option<Cell> {
    let (name, updates) = key.split_once('+').unwrap_or((key, "0"));
    let updates: usize = updates.parse().unwrap();
    let names: Vec<String> = (0..=updates).map(|number| format!("{name}.{number:03}")).collect();
    let mut files = Vec::new();
    for name in &names {
        files.push(std::fs::read(testkit::shared(&format!("data/charts/{name}"))?).unwrap());
    }
    let named: Vec<NamedBytes<'_>> =
        names.iter().zip(&files).map(|(name, bytes)| NamedBytes { name, bytes }).collect();
    Some(Cell::read(named[0], &named[1..]).unwrap_or_else(|error| panic!("{error}")))
}

fn expected() -> Option<Value> {
    let path = testkit::shared("data/charts/expected.json")?;
    Some(serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap())
}

fn close(found: f64, expected: f64, tolerance: f64, what: &str, differences: &mut Vec<String>) {
    if (found - expected).abs() > tolerance {
        differences.push(format!("{what}: {found} instead of {expected}"));
    }
}

fn kind(geometry: &Geometry) -> &'static str {
    match geometry {
        Geometry::None => "None",
        Geometry::Point(_) => "Point",
        Geometry::Soundings(_) => "MultiPoint",
        Geometry::Lines(paths) if paths.len() == 1 => "LineString",
        Geometry::Lines(_) => "MultiLineString",
        Geometry::Area(_) => "Polygon",
        Geometry::Unreadable { .. } => "Unreadable",
    }
}

fn compare_numbers(what: &str, list: &Value, values: &[f64], differences: &mut Vec<String>) {
    let list: Vec<f64> = list.as_array().unwrap().iter().map(|one| one.as_f64().unwrap()).collect();
    let sum: f64 = values.iter().sum();
    let min = values.iter().copied().fold(f64::INFINITY, f64::min);
    let max = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let found = if values.is_empty() {
        vec![0.0]
    } else if what.ends_with("VALDCO") {
        let mut found = values.to_vec();
        found.sort_by(f64::total_cmp);
        found.dedup();
        found
    } else if what.ends_with("VALSOU") {
        vec![values.len() as f64, min, max]
    } else if what.ends_with("depth_min_max_sum") {
        vec![min, max, sum]
    } else {
        vec![values.len() as f64, min, max, sum]
    };
    assert_eq!(found.len(), list.len(), "{what}: {found:?} {list:?}");
    for (found, list) in found.iter().zip(&list) {
        close(*found, *list, 1e-6, what, differences);
    }
}

fn compare_class(key: &str, class: &str, expected: &Value, features: &[&Feature]) -> Vec<String> {
    let mut differences = Vec::new();
    let numbers = |code| -> Vec<f64> { features.iter().filter_map(|one| one.number(code)).collect() };
    let soundings: Vec<_> = features
        .iter()
        .filter_map(|one| if let Geometry::Soundings(list) = &one.geometry { Some(list) } else { None })
        .flatten()
        .collect();
    let areas: Vec<_> = features
        .iter()
        .filter_map(|one| if let Geometry::Area(area) = &one.geometry { Some(area) } else { None })
        .collect();
    for (field, value) in expected.as_object().unwrap() {
        let what = format!("{key} {class} {field}");
        let mut count = |found: usize| {
            close(found as f64, value.as_f64().unwrap(), 0.0, &what, &mut differences);
        };
        match field.as_str() {
            "count" => count(features.len()),
            "points" => count(soundings.len()),
            "holes" => count(areas.iter().map(|area| area.holes.len()).sum()),
            "vertices" => {
                count(areas.iter().flat_map(|area| area.rings()).map(|ring| ring.points.len()).sum());
            }
            "geometry" => {
                let mut kinds: BTreeMap<&str, u64> = BTreeMap::new();
                for feature in features {
                    *kinds.entry(kind(&feature.geometry)).or_default() += 1;
                }
                let same = value.as_object().unwrap().len() == kinds.len()
                    && kinds.iter().all(|(kind, count)| value[*kind] == *count);
                if !same {
                    differences.push(format!("{what}: {kinds:?} instead of {value}"));
                }
            }
            "area_deg2" => {
                let sum = areas.iter().map(|area| area.area_deg2()).sum();
                close(sum, value.as_f64().unwrap(), 1e-9, &what, &mut differences);
            }
            "lon_sum" => {
                let sum = soundings.iter().map(|one| one.at.lon_deg).sum();
                close(sum, value.as_f64().unwrap(), 1e-6, &what, &mut differences);
            }
            "lat_sum" => {
                let sum = soundings.iter().map(|one| one.at.lat_deg).sum();
                close(sum, value.as_f64().unwrap(), 1e-6, &what, &mut differences);
            }
            "depth_min_max_sum" => {
                let depths: Vec<f64> = soundings.iter().map(|one| one.depth_m).collect();
                compare_numbers(&what, value, &depths, &mut differences);
            }
            "DRVAL1" | "DRVAL2" | "VALSOU" | "VALDCO" => {
                let code = AttributeCode::from_acronym(field).unwrap();
                compare_numbers(&what, value, &numbers(code), &mut differences);
            }
            "WATLEV" => {
                for (code, number) in value.as_object().unwrap() {
                    let has = |one: &&&Feature| one.text(AttributeCode::WATLEV) == Some(code.as_str());
                    let found = features.iter().filter(has).count();
                    close(found as f64, number.as_f64().unwrap(), 0.0, &what, &mut differences);
                }
            }
            "OBJNAM" => {
                let names: Vec<&str> =
                    features.iter().filter_map(|one| one.text(AttributeCode::OBJNAM)).collect();
                let mut sorted = names.clone();
                sorted.sort_unstable();
                let first = value[1].as_str().unwrap();
                if names.len() as u64 != value[0]
                    || (names.first() != Some(&first) && sorted.first() != Some(&first))
                {
                    differences.push(format!(
                        "{what}: {} {:?} instead of {value}",
                        names.len(),
                        names.first()
                    ));
                }
            }
            other => panic!("{key} {class} has {other}, which this test does not compare"),
        }
    }
    differences
}

fn compare_identity(key: &str, expected: &Value, cell: &Cell) -> Vec<String> {
    let level = |level| level as u8;
    let found = serde_json::json!({
        "DSNM": cell.id.name, "EDTN": cell.id.edition, "UPDN": cell.id.update, "UADT": cell.id.update_date,
        "ISDT": cell.id.issue_date, "INTU": cell.id.band, "AGEN": cell.id.agency,
        "CSCL": cell.parameters.scale, "COMF": cell.parameters.coordinate_factor,
        "SOMF": cell.parameters.sounding_factor, "VDAT": cell.parameters.vertical_datum,
        "SDAT": cell.parameters.sounding_datum, "HDAT": cell.parameters.horizontal_datum,
        "AALL": level(cell.structure.attribute_level), "NALL": level(cell.structure.national_level),
        "NOGR": cell.structure.geo_features, "NOIN": cell.structure.isolated_nodes,
        "NOCN": cell.structure.connected_nodes, "NOED": cell.structure.edges,
    });
    let differs = |(field, value): (&String, &Value)| {
        (found[field] != *value).then(|| format!("{key} {field}: {} instead of {value}", found[field]))
    };
    expected.as_object().unwrap().iter().filter_map(differs).collect()
}

#[test]
fn every_shared_cell_equals_what_gdal_read() {
    let Some(expected) = expected() else { return };
    let mut differences = Vec::new();
    let mut compared = 0;
    for (key, expected) in expected.as_object().unwrap() {
        let cell = read(key).unwrap();
        differences.extend(compare_identity(key, &expected["dsid"], &cell));
        for (class, expected) in expected["classes"].as_object().unwrap() {
            let code = ObjectClass::from_acronym(class).unwrap();
            let features: Vec<&Feature> = cell.of_class(code).collect();
            compared += expected.as_object().unwrap().len();
            differences.extend(compare_class(key, class, expected, &features));
        }
    }
    println!("{compared} values of {} cells compared", expected.as_object().unwrap().len());
    assert!(differences.is_empty(), "{} differences:\n{}", differences.len(), differences.join("\n"));
}

#[test]
fn the_skin_of_every_shared_cell_covers_what_it_says() {
    let Some(expected) = expected() else { return };
    for key in expected.as_object().unwrap().keys() {
        let cell = read(key).unwrap();
        let check = cell.skin_check();
        assert!(check.holds(), "{key}: {check:?}");
        assert!(cell.notices.is_empty(), "{key}: {:?}", cell.notices);
    }
}

#[test]
fn features_with_links_are_as_many_as_another_reader_found() {
    let Some(cell) = read("US4MD81M") else { return };
    let linked = cell.features.iter().filter(|one| !one.links.is_empty()).count();
    assert_eq!(linked, 268);
}
