//! Plans as files: IMC JSON, GeoJSON lines, GPX routes.

use crate::say::say;
use anyhow::{Context as _, bail};
use clap::{Subcommand, ValueEnum};
use imc::messages::{
    Goto, Message, PlanManeuver, PlanSpecification, PlanTransition, SpeedUnits, StationKeeping, ZUnits,
};
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use units::{LatLon, LocalFrame, LocalPoint};

#[derive(Debug, Subcommand)]
pub(crate) enum PlanCommand {
    /// Make a plan of waypoints (IMC JSON) from a GeoJSON LineString or a GPX route.
    Import {
        /// The file; `.gpx` is read as GPX, anything else as GeoJSON or IMC JSON.
        file: PathBuf,
        /// Name of the plan.
        #[arg(long)]
        id: String,
        /// Speed (m/s).
        #[arg(long, default_value_t = 1.5)]
        speed: f32,
    },
    /// Print the waypoints of a plan (IMC JSON) in another form.
    Export {
        /// The plan.
        file: PathBuf,
        /// The form.
        #[arg(long, value_enum, default_value = "geojson")]
        form: Form,
    },
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum Form {
    /// A LineString.
    Geojson,
    /// A route.
    Gpx,
    /// IMC JSON.
    Imc,
}

pub(crate) fn plan(command: &PlanCommand) -> anyhow::Result<()> {
    match command {
        PlanCommand::Import { file, id, speed } => {
            let text = fs::read_to_string(file).with_context(|| format!("reading {}", file.display()))?;
            let gpx = file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("gpx"));
            let places = if gpx { gpx_route(&text)? } else { geojson_line(&serde_json::from_str(&text)?)? };
            let points = places.into_iter().map(|place| goto(place, *speed).into()).collect();
            say!("{}", to_json(sequence(id, points))?);
        }
        PlanCommand::Export { file, form } => {
            let plan = read(file)?;
            let places = waypoints(&plan);
            match form {
                Form::Imc => say!("{}", to_json(plan)?),
                Form::Geojson => {
                    let line: Vec<[f64; 2]> = places.iter().map(|p| [p.lon_deg(), p.lat_deg()]).collect();
                    let name = plan.plan_id.to_str_lossy();
                    say!(
                        "{}",
                        json!({"type": "Feature", "properties": {"name": name},
                               "geometry": {"type": "LineString", "coordinates": line}})
                    );
                }
                Form::Gpx => {
                    say!("<?xml version=\"1.0\"?><gpx version=\"1.1\" creator=\"lutra-agent\"><rte>");
                    for place in places {
                        say!("<rtept lat=\"{:.8}\" lon=\"{:.8}\"/>", place.lat_deg(), place.lon_deg());
                    }
                    say!("</rte></gpx>");
                }
            }
        }
    }
    Ok(())
}

/// A plan from IMC JSON.
pub(crate) fn read(path: &Path) -> anyhow::Result<PlanSpecification> {
    let text = fs::read_to_string(path).with_context(|| format!("reading {}", path.display()))?;
    let value: Value = serde_json::from_str(&text).with_context(|| path.display().to_string())?;
    match imc::json::message_from_value(&value).with_context(|| path.display().to_string())? {
        Message::PlanSpecification(plan) => Ok(*plan),
        other => bail!("{} holds a {}, not a PlanSpecification", path.display(), other.abbrev()),
    }
}

/// A short plan around a place: a square of 80 m, then two minutes of station keeping.
pub(crate) fn demonstration(start: LatLon) -> PlanSpecification {
    let frame = LocalFrame::new(start);
    let at = |north_m, east_m| frame.to_place(LocalPoint { north_m, east_m });
    let corners = [at(80.0, 0.0), at(80.0, 80.0), at(0.0, 80.0), at(0.0, 0.0)];
    let mut maneuvers: Vec<Message> = corners.into_iter().map(|place| goto(place, 1.5).into()).collect();
    let station = StationKeeping {
        lat: start.lat_rad(),
        lon: start.lon_rad(),
        z_units: ZUnits::Depth,
        radius: 10.0,
        duration: 60,
        speed: 1.0,
        speed_units: SpeedUnits::MetersPs,
        ..StationKeeping::default()
    };
    maneuvers.push(station.into());
    sequence("demonstration", maneuvers)
}

pub(crate) fn goto(place: LatLon, speed: f32) -> Goto {
    Goto {
        lat: place.lat_rad(),
        lon: place.lon_rad(),
        z_units: ZUnits::Depth,
        speed,
        speed_units: SpeedUnits::MetersPs,
        ..Goto::default()
    }
}

/// Maneuvers one after the other.
pub(crate) fn sequence(id: &str, maneuvers: Vec<Message>) -> PlanSpecification {
    let name = |number: usize| format!("{number}");
    let count = maneuvers.len();
    PlanSpecification {
        plan_id: id.into(),
        start_man_id: name(1).into(),
        maneuvers: (1..)
            .zip(maneuvers)
            .map(|(number, data)| PlanManeuver {
                maneuver_id: name(number).into(),
                data: data.into(),
                ..PlanManeuver::default()
            })
            .collect(),
        transitions: (1..count)
            .map(|number| PlanTransition {
                source_man: name(number).into(),
                dest_man: name(number + 1).into(),
                conditions: "ManeuverIsDone".into(),
                ..PlanTransition::default()
            })
            .collect(),
        ..PlanSpecification::default()
    }
}

fn to_json(plan: PlanSpecification) -> anyhow::Result<String> {
    Ok(imc::json::message_to_string(&plan.into())?)
}

fn waypoints(plan: &PlanSpecification) -> Vec<LatLon> {
    let nodes = plan.maneuvers.of::<PlanManeuver>();
    nodes
        .filter_map(|node| match node.data.get()? {
            Message::Goto(m) => LatLon::from_rad(m.lat, m.lon).ok(),
            Message::StationKeeping(m) => LatLon::from_rad(m.lat, m.lon).ok(),
            Message::Loiter(m) => LatLon::from_rad(m.lat, m.lon).ok(),
            _ => None,
        })
        .collect()
}

fn geojson_line(value: &Value) -> anyhow::Result<Vec<LatLon>> {
    let geometry = match value["type"].as_str() {
        Some("FeatureCollection") => &value["features"][0]["geometry"],
        Some("Feature") => &value["geometry"],
        _ => value,
    };
    if geometry["type"] != "LineString" {
        bail!("the file holds no LineString");
    }
    let line = geometry["coordinates"].as_array().context("a LineString without coordinates")?;
    let place = |point: &Value| {
        let (lon, lat) = (point[0].as_f64(), point[1].as_f64());
        let (lon, lat) = lon.zip(lat).context("a coordinate is no pair of numbers")?;
        Ok(LatLon::from_deg(lat, lon)?)
    };
    line.iter().map(place).collect()
}

/// The points of a route; only what is needed of XML.
fn gpx_route(text: &str) -> anyhow::Result<Vec<LatLon>> {
    let mut places = Vec::new();
    for tag in text.split('<').filter(|tag| tag.starts_with("rtept") || tag.starts_with("wpt")) {
        let number = |name: &str| -> anyhow::Result<f64> {
            let (_, rest) = tag.split_once(&format!("{name}=")).with_context(|| format!("no {name}"))?;
            let quote =
                rest.chars().next().filter(|quote| matches!(quote, '"' | '\'')).context("no quote")?;
            let value = rest[1..].split(quote).next().unwrap_or_default();
            Ok(value.parse()?)
        };
        places.push(LatLon::from_deg(number("lat")?, number("lon")?)?);
    }
    if places.is_empty() {
        bail!("the file holds no route points");
    }
    Ok(places)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_and_routes_become_waypoints() {
        let line = json!({"type": "LineString", "coordinates": [[10.0, 63.0], [10.1, 63.1]]});
        let places = geojson_line(&line).unwrap();
        let gpx =
            "<gpx><rte><rtept lat=\"63.0\" lon=\"10.0\"/><rtept lon='10.1' lat='63.1'></rtept></rte></gpx>";
        assert_eq!(gpx_route(gpx).unwrap(), places);
        let plan = sequence("x", places.iter().map(|place| goto(*place, 1.0).into()).collect());
        assert_eq!(waypoints(&plan), places);
        assert!(geojson_line(&json!({"type": "Point"})).is_err());
        assert!(gpx_route("<gpx/>").is_err());
    }

    #[test]
    fn json_returns() {
        let plan = demonstration(LatLon::from_deg(63.0, 10.0).unwrap());
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plan.json");
        fs::write(&path, to_json(plan.clone()).unwrap()).unwrap();
        assert_eq!(read(&path).unwrap(), plan);
    }
}
