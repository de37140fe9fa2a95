//! Plans as files: IMC JSON, GeoJSON lines, GPX routes.

use crate::say::{complain, say};
use anyhow::{Context as _, bail};
use clap::{Subcommand, ValueEnum};
use geofile::{Geometry, Position, Shape, Shapes, geojson, gpx};
use imc::messages::{
    Goto, Message, PlanManeuver, PlanSpecification, PlanTransition, SpeedUnits, StationKeeping, ZUnits,
};
use serde_json::{Map, Value};
use std::fs;
use std::path::{Path, PathBuf};
use units::{LatLon, LocalFrame, LocalPoint};

#[derive(Debug, Subcommand)]
pub(crate) enum PlanCommand {
    /// Make a plan of waypoints (IMC JSON) from the points or the line of a GeoJSON or GPX file.
    Import {
        /// The file; `.gpx` is read as GPX, anything else as GeoJSON.
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
        #[arg(long, alias = "form", value_enum, default_value = "geojson")]
        format: Form,
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
            let bytes = text.as_bytes();
            let shapes = if gpx { gpx::read(bytes)? } else { geojson::read(bytes)? };
            for note in &shapes.notes {
                complain!("{}: {note}", file.display());
            }
            let places = places(&shapes).with_context(|| file.display().to_string())?;
            let points = places.into_iter().map(|place| goto(place, *speed).into()).collect();
            say!("{}", to_json(sequence(id, points))?);
        }
        PlanCommand::Export { file, format } => {
            let plan = read(file)?;
            let places = waypoints(&plan);
            match format {
                Form::Imc => say!("{}", to_json(plan)?),
                Form::Geojson => say!("{}", geojson::write(&shapes(&plan, &places))),
                Form::Gpx => say!("{}", gpx::write(&shapes(&plan, &places))),
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

/// The places of a file: its points, or its one line.
fn places(shapes: &Shapes) -> anyhow::Result<Vec<LatLon>> {
    let (mut points, mut lines) = (Vec::new(), Vec::new());
    for shape in &shapes.shapes {
        match &shape.geometry {
            Geometry::Point(at) => points.push(*at),
            Geometry::Line(line) => lines.push((&shape.name, line)),
        }
    }
    match (&points[..], &lines[..]) {
        ([], []) => bail!("the file holds no line, route or point"),
        (points, []) => located(points),
        ([], [(_, line)]) => located(line),
        ([], lines) => {
            let names: Vec<&str> = lines.iter().map(|(name, _)| name.as_str()).collect();
            bail!("the file holds {} lines ({}): leave one of them in it", lines.len(), names.join(", "))
        }
        _ => bail!("the file holds points and lines: leave the points or one line in it"),
    }
}

fn located(line: &[Position]) -> anyhow::Result<Vec<LatLon>> {
    line.iter().map(|at| Ok(LatLon::from_deg(at.lat_deg, at.lon_deg)?)).collect()
}

/// The waypoints of a plan as one line that has its name.
fn shapes(plan: &PlanSpecification, places: &[LatLon]) -> Shapes {
    let name = plan.plan_id.to_str_lossy().into_owned();
    let position = |place: &LatLon| Position { lat_deg: place.lat_deg(), lon_deg: place.lon_deg() };
    let geometry = Geometry::Line(places.iter().map(position).collect());
    let line = Shape { name: name.clone(), geometry, properties: Map::new() };
    Shapes { name, shapes: vec![line], ..Shapes::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_and_routes_become_waypoints_and_come_back() {
        let line = br#"{"type": "LineString", "coordinates": [[10.0, 63.0], [10.1, 63.1]]}"#;
        let way = places(&geojson::read(line).unwrap()).unwrap();
        let route =
            b"<gpx><rte><rtept lat=\"63.0\" lon=\"10.0\"/><rtept lon='10.1' lat='63.1'></rtept></rte></gpx>";
        assert_eq!(places(&gpx::read(route).unwrap()).unwrap(), way);
        let plan = sequence("x", way.iter().map(|place| goto(*place, 1.0).into()).collect());
        assert_eq!(waypoints(&plan), way);
        let out = shapes(&plan, &way);
        assert_eq!(places(&geojson::read(geojson::write(&out).as_bytes()).unwrap()).unwrap(), way);
        assert_eq!(places(&gpx::read(gpx::write(&out).as_bytes()).unwrap()).unwrap(), way);
        assert!(places(&Shapes::default()).unwrap_err().to_string().contains("no line"));
        let mixed = br#"{"type": "FeatureCollection", "features": [
            {"type": "Feature", "properties": {}, "geometry": {"type": "Point", "coordinates": [10.0, 63.0]}},
            {"type": "Feature", "properties": {"name": "a"}, "geometry":
                {"type": "LineString", "coordinates": [[10.0, 63.0], [10.1, 63.1]]}}]}"#;
        let mut mixed = geojson::read(mixed).unwrap();
        assert!(places(&mixed).unwrap_err().to_string().contains("points and lines"));
        mixed.shapes[0] = mixed.shapes[1].clone();
        assert!(places(&mixed).unwrap_err().to_string().contains("2 lines (a, a)"));
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
