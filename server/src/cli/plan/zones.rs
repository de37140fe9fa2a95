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

/// The areas of some files; `None` if no file is given.
pub(super) fn read(avoid: &[PathBuf], within: Option<&Path>, margin_m: f64) -> anyhow::Result<Option<Zones>> {
    if avoid.is_empty() && within.is_none() {
        return Ok(None);
    }
    let mut forbidden = Vec::new();
    for file in avoid {
        forbidden.extend(polygons(file)?);
    }
    let allowed = within.map(polygons).transpose()?;
    let mut allowed = allowed.unwrap_or_default();
    if let (true, Some(file)) = (allowed.len() > 1, within) {
        bail!("{}: there are {} polygons; one can be stayed within", file.display(), allowed.len());
    }
    Ok(Some(Zones::new(allowed.pop(), forbidden, margin_m)?))
}

fn polygons(file: &Path) -> anyhow::Result<Vec<Zone>> {
    let name = || file.display().to_string();
    let size = fs::metadata(file).with_context(name)?.len();
    ensure!(size <= LARGEST, "{}: larger than {} MB", name(), LARGEST >> 20);
    let text = fs::read_to_string(file).with_context(name)?;
    let value: Value = serde_json::from_str(&text).with_context(name)?;
    let mut rings = Vec::new();
    collect(&value, &mut rings);
    ensure!(!rings.is_empty(), "{}: there is no Polygon or MultiPolygon", name());
    let corners: usize = rings.iter().filter_map(|ring| ring.as_array()).map(Vec::len).sum();
    ensure!(corners <= MOST_CORNERS, "{}: {corners} corners; at most {MOST_CORNERS} are read", name());
    let zones = rings.into_iter().zip(1..);
    zones.map(|(ring, number)| zone(ring).with_context(|| format!("{}: polygon {number}", name()))).collect()
}

/// The outer rings of all polygons; one that has a hole counts as a whole.
fn collect<'a>(value: &'a Value, rings: &mut Vec<&'a Value>) {
    let parts = |value: &'a Value| value.as_array().into_iter().flatten();
    match value["type"].as_str() {
        Some("FeatureCollection") => parts(&value["features"]).for_each(|one| collect(one, rings)),
        Some("GeometryCollection") => parts(&value["geometries"]).for_each(|one| collect(one, rings)),
        Some("Feature") => collect(&value["geometry"], rings),
        Some("Polygon") => rings.extend(value["coordinates"].get(0)),
        Some("MultiPolygon") => rings.extend(parts(&value["coordinates"]).filter_map(|one| one.get(0))),
        _ => {}
    }
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
    fn polygons_are_found_wherever_they_stand_and_bad_ones_are_named() {
        let square = json!([[[10.0, 63.0], [10.1, 63.0], [10.1, 63.1], [10.0, 63.1], [10.0, 63.0]]]);
        let feature =
            json!({"type": "Feature", "geometry": {"type": "MultiPolygon", "coordinates": [square, square]}});
        let all = json!({"type": "FeatureCollection", "features": [feature, {"type": "Polygon", "coordinates": square}]});
        let mut rings = Vec::new();
        collect(&all, &mut rings);
        assert_eq!(rings.len(), 3);
        assert!(zone(rings[0]).unwrap().holds(LatLon::from_deg(63.05, 10.05).unwrap()));
        for (bad, why) in [
            (json!([[10.0, 63.0], [10.1, 63.0]]), "three corners"),
            (json!([[10.0, 163.0], [10.1, 63.0], [10.1, 63.1]]), "163, 10 is not a place"),
            (json!([[10.0, 63.0], ["x", 63.0], [10.1, 63.1]]), "is not a longitude"),
            (json!([[10.0, 63.0], [10.2, 63.1], [10.0, 63.1], [10.2, 63.0]]), "cross near 63.05"),
        ] {
            let error = zone(&bad).unwrap_err().to_string();
            assert!(error.contains(why), "{error}");
        }
    }
}
