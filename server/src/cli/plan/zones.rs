//! Areas that routes avoid or stay within, from GeoJSON files.

use anyhow::{Context as _, anyhow, bail, ensure};
use planner::{Zone, Zones};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use units::LatLon;

/// Larger files are refused (bytes), and more corners in one call.
const LARGEST: u64 = 4 << 20;
const MOST_CORNERS: usize = 10_000;

/// The areas of some files; `None` if no file is given. Holes in an area to avoid are avoided too; an area to stay within
/// must have none, as their meaning would be a guess.
pub(super) fn read(avoid: &[PathBuf], within: Option<&Path>, margin_m: f64) -> anyhow::Result<Option<Zones>> {
    if avoid.is_empty() && within.is_none() {
        return Ok(None);
    }
    let mut forbidden = Vec::new();
    for file in avoid {
        forbidden.extend(read_all(file)?);
    }
    let mut allowed = None;
    if let Some(file) = within {
        let value = parsed(file)?;
        let [polygon] = polygons(&value, file)?[..] else {
            bail!("{}: there is more than one polygon; one can be stayed within", file.display());
        };
        let holes = polygon.as_array().map_or(0, |rings| rings.len().saturating_sub(1));
        ensure!(holes == 0, "{}: the polygon has holes; give them by --avoid", file.display());
        allowed = zones(file, &[polygon])?.pop();
    }
    Ok(Some(Zones::new(allowed, forbidden, margin_m)?))
}

/// All areas of a file.
pub(super) fn read_all(file: &Path) -> anyhow::Result<Vec<Zone>> {
    zones(file, &polygons(&parsed(file)?, file)?)
}

fn parsed(file: &Path) -> anyhow::Result<Value> {
    let name = || file.display().to_string();
    let size = fs::metadata(file).with_context(name)?.len();
    ensure!(size <= LARGEST, "{}: larger than {} MB", name(), LARGEST >> 20);
    let text = fs::read_to_string(file).with_context(name)?;
    serde_json::from_str(&text).with_context(name)
}

/// The polygons of a file, each with all its rings.
fn polygons<'a>(value: &'a Value, file: &Path) -> anyhow::Result<Vec<&'a Value>> {
    let mut found = Vec::new();
    collect(value, &mut found).with_context(|| file.display().to_string())?;
    ensure!(!found.is_empty(), "{}: there is no Polygon or MultiPolygon", file.display());
    Ok(found)
}

/// The areas of polygons by their outer rings.
fn zones(file: &Path, polygons: &[&Value]) -> anyhow::Result<Vec<Zone>> {
    let name = || file.display().to_string();
    let corners: usize = polygons.iter().filter_map(|rings| rings[0].as_array()).map(Vec::len).sum();
    ensure!(corners <= MOST_CORNERS, "{}: {corners} corners; at most {MOST_CORNERS} are read", name());
    let numbered = polygons.iter().zip(1..);
    numbered
        .map(|(rings, number)| zone(&rings[0]).with_context(|| format!("{}: polygon {number}", name())))
        .collect()
}

/// All polygons of a piece of GeoJSON. Anything but areas is refused: leaving it out would make the avoided area too small.
fn collect<'a>(value: &'a Value, polygons: &mut Vec<&'a Value>) -> anyhow::Result<()> {
    let parts = |value: &'a Value| value.as_array().into_iter().flatten();
    match value["type"].as_str() {
        Some("FeatureCollection") => {
            parts(&value["features"]).try_for_each(|one| collect(one, polygons))?;
        }
        Some("GeometryCollection") => {
            parts(&value["geometries"]).try_for_each(|one| collect(one, polygons))?;
        }
        Some("Feature") => collect(&value["geometry"], polygons)?,
        Some("Polygon") => polygons.push(&value["coordinates"]),
        Some("MultiPolygon") => polygons.extend(parts(&value["coordinates"])),
        Some(other) => bail!("a {other} is not an area: give Polygons and MultiPolygons"),
        None => bail!("something in it has no type of GeoJSON"),
    }
    Ok(())
}

fn zone(ring: &Value) -> anyhow::Result<Zone> {
    let mut corners = Vec::new();
    for corner in ring.as_array().into_iter().flatten() {
        let (Some(lon), Some(lat)) = (corner[0].as_f64(), corner[1].as_f64()) else {
            bail!("{corner} is not a longitude and a latitude");
        };
        let place =
            LatLon::from_deg(lat, lon).map_err(|error| anyhow!("{lat}, {lon} is not a place: {error}"))?;
        corners.push(place);
    }
    if corners.len() > 1 && corners.first() == corners.last() {
        corners.pop();
    }
    Ok(Zone::drawn(corners)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn an_area_to_stay_within_with_a_hole_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("within.geojson");
        let (outer, hole) = (
            json!([[10.0, 63.0], [10.1, 63.0], [10.1, 63.1], [10.0, 63.0]]),
            json!([[10.05, 63.01], [10.06, 63.01], [10.06, 63.02], [10.05, 63.01]]),
        );
        for (rings, good) in [(json!([outer]), true), (json!([outer, hole]), false)] {
            fs::write(&file, json!({"type": "Polygon", "coordinates": rings}).to_string()).unwrap();
            let read = read(&[], Some(&file), 10.0);
            assert_eq!(read.is_ok(), good, "{read:?}");
        }
    }

    #[test]
    fn polygons_are_found_wherever_they_stand_and_bad_ones_are_named() {
        let square = json!([[[10.0, 63.0], [10.1, 63.0], [10.1, 63.1], [10.0, 63.1], [10.0, 63.0]]]);
        let feature =
            json!({"type": "Feature", "geometry": {"type": "MultiPolygon", "coordinates": [square, square]}});
        let all = json!({"type": "FeatureCollection", "features": [feature, {"type": "Polygon", "coordinates": square}]});
        let mut found = Vec::new();
        collect(&all, &mut found).unwrap();
        assert_eq!(found.len(), 3);
        let line = json!({"type": "Feature", "geometry": {"type": "LineString", "coordinates": [[10.0, 63.0], [10.1, 63.0]]}});
        assert!(collect(&line, &mut found).unwrap_err().to_string().contains("LineString is not an area"));
        assert!(zone(&found[0][0]).unwrap().holds(LatLon::from_deg(63.05, 10.05).unwrap()));
        for (bad, why) in [
            (json!([[10.0, 63.0], [10.1, 63.0]]), "three corners"),
            (json!([[10.0, 163.0], [10.1, 63.0], [10.1, 63.1]]), "163, 10 is not a place"),
            (json!([[10.0, 63.0], ["x", 63.0], [10.1, 63.1]]), "is not a longitude"),
            (json!([[10.0, 63.0], [10.2, 63.1], [10.0, 63.1], [10.2, 63.0]]), "cross or touch near 63.05"),
        ] {
            let error = zone(&bad).unwrap_err().to_string();
            assert!(error.contains(why), "{error}");
        }
    }
}
