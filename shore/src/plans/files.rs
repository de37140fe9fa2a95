//! Plans as files: IMC's JSON, GeoJSON with everything in its properties, GPX with only the places.

use super::check::{places, told};
use super::translate::{document, specification};
use super::trouble::said;
use super::unread::{left_out, no_geojson, no_gpx};
use api::{PlanDocument, PlanPlace, PlanSpeed, PlanStep, PlanTask, Said, SpeedUnit, say};
use geofile::geojson::GeoJsonError;
use geofile::{Geometry, Position, Shape, Shapes, geojson, gpx};
use imc::messages::Message;
use onboard::LONGEST_PLAN_NAME;
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;

/// Problems of a plan that are named.
const PROBLEMS: usize = 10;
/// Speed if a file does not give one (m/s).
const SPEED_MPS: f64 = 1.5;

/// File format of a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// A PlanSpecification in IMC's JSON, as Neptus reads it.
    Imc,
    /// Places and tracks in GeoJSON.
    GeoJson,
    /// A route in GPX.
    Gpx,
}

impl Format {
    /// By its name in the API.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "imc" => Some(Self::Imc),
            "geojson" => Some(Self::GeoJson),
            "gpx" => Some(Self::Gpx),
            _ => None,
        }
    }

    /// Media type, and file extension.
    pub fn kind(self) -> (&'static str, &'static str) {
        match self {
            Self::Imc => ("application/json", "imc.json"),
            Self::GeoJson => ("application/geo+json", "geojson"),
            Self::Gpx => ("application/gpx+xml", "gpx"),
        }
    }
}

/// Writes a plan.
///
/// # Errors
/// It cannot be written as IMC, or is too long for it.
pub fn write(plan: &PlanDocument, format: Format) -> Result<String, Said> {
    match format {
        Format::Imc => {
            let plan = specification(plan).map_err(|troubles| lines(troubles.iter().map(said).collect()))?;
            imc::json::message_to_string(&plan.into()).map_err(|error| Said::as_is(error.to_string()))
        }
        Format::GeoJson => Ok(geojson::write(&shapes(plan))),
        Format::Gpx => Ok(gpx::write(&shapes(plan))),
    }
}

/// Reads a plan in any of the formats; `file` is the file's name. Returns the plan, what was left out of it and what is odd.
///
/// # Errors
/// It is not valid; the error gives the position.
pub fn read(bytes: &[u8], file: &str) -> Result<(PlanDocument, Vec<Said>), Said> {
    let start = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes).trim_ascii_start();
    let (mut plan, notes) = match start.first() {
        Some(b'<') => gpx::read(bytes).map_err(no_gpx).and_then(from_shapes)?,
        Some(b'{') => from_json(start)?,
        _ => return Err(say("it is neither GPX nor GeoJSON nor JSON of an IMC PlanSpecification").into()),
    };
    let stem = file.split('.').next().unwrap_or_default();
    let given = [plan.name.as_str(), stem, "Plan"].map(name);
    plan.name = given.into_iter().find(|name| !name.is_empty()).unwrap_or_default();
    name_steps(&mut plan);
    Ok((plan, notes))
}

fn from_json(bytes: &[u8]) -> Result<(PlanDocument, Vec<Said>), Said> {
    let mut value: Value =
        serde_json::from_slice(bytes).map_err(|error| no_geojson(GeoJsonError::Json(error.to_string())))?;
    let Some(object) = value.as_object_mut().filter(|object| object.contains_key("abbrev")) else {
        return geojson::read(bytes).map_err(no_geojson).and_then(from_shapes);
    };
    // The header of a whole packet.
    object.retain(|key, _| !matches!(key.as_str(), "header" | "endian"));
    match imc::json::message_from_value(&value).map_err(|error| Said::as_is(error.to_string()))? {
        Message::PlanSpecification(plan) => {
            let (document, mut notes) = document(&plan).map_err(lines)?;
            notes.extend(told(&plan));
            Ok((document, notes))
        }
        other => Err(say("it holds a {found}, not a PlanSpecification").with("found", other.abbrev()).into()),
    }
}

/// A feature for each maneuver; everything but its places is in the properties.
fn shapes(plan: &PlanDocument) -> Shapes {
    let position = |place: &PlanPlace| Position { lat_deg: place.lat_deg, lon_deg: place.lon_deg };
    let shape = |step: &PlanStep| {
        let drawn = places(&step.task);
        let geometry = match (&step.task, drawn) {
            (PlanTask::FollowPath { .. }, points) => Geometry::Line(points.iter().map(position).collect()),
            (_, [at, ..]) => Geometry::Point(position(at)),
            (_, []) => Geometry::Line(Vec::new()),
        };
        let mut properties = match serde_json::to_value(&step.task) {
            Ok(Value::Object(task)) => task,
            _ => Map::new(),
        };
        properties.retain(|key, _| key != "at" && key != "points");
        properties.insert("speed".to_owned(), json!(step.speed));
        Shape { name: step.id.clone(), geometry, properties }
    };
    let own = json!({ "description": plan.description, "repeat": plan.repeat });
    Shapes {
        name: plan.name.clone(),
        properties: own.as_object().cloned().unwrap_or_default(),
        shapes: plan.maneuvers.iter().map(shape).collect(),
        notes: Vec::new(),
    }
}

fn from_shapes(file: Shapes) -> Result<(PlanDocument, Vec<Said>), Said> {
    let mut maneuvers = Vec::with_capacity(file.shapes.len());
    for (shape, number) in file.shapes.into_iter().zip(1..) {
        let step = step(shape)
            .map_err(|why| say("feature {number}: {why}").with("number", number).with("why", why))?;
        maneuvers.push(step);
    }
    if maneuvers.is_empty() {
        return Err(say("it has no points or lines").into());
    }
    let text = file.properties.get("description").and_then(Value::as_str).unwrap_or_default();
    let plan = PlanDocument {
        name: file.name,
        description: text.to_owned(),
        vessel: None,
        repeat: file.properties.get("repeat").and_then(Value::as_bool).unwrap_or_default(),
        maneuvers,
    };
    Ok((plan, file.notes.iter().map(left_out).collect()))
}

/// A maneuver; of foreign features a point becomes a Goto and a line a FollowPath.
fn step(shape: Shape) -> Result<PlanStep, String> {
    let Shape { name: id, geometry, mut properties } = shape;
    let place = |at: &Position| PlanPlace { lat_deg: at.lat_deg, lon_deg: at.lon_deg };
    let speed = match properties.remove("speed") {
        Some(speed) if properties.contains_key("kind") => {
            serde_json::from_value(speed).map_err(|error| format!("its speed: {error}"))?
        }
        _ => PlanSpeed { value: SPEED_MPS, unit: SpeedUnit::Mps },
    };
    let task = match (properties.get("kind"), &geometry) {
        (None, Geometry::Point(at)) => PlanTask::Goto { at: place(at) },
        (None, Geometry::Line(points)) => PlanTask::FollowPath { points: points.iter().map(place).collect() },
        (Some(_), geometry) => {
            let (key, value) = match geometry {
                Geometry::Point(at) => ("at", json!(place(at))),
                Geometry::Line(points) => ("points", points.iter().map(|at| json!(place(at))).collect()),
            };
            properties.insert(key.to_owned(), value);
            serde_json::from_value(Value::Object(properties)).map_err(|error| error.to_string())?
        }
    };
    Ok(PlanStep { id, speed, task })
}

/// Gives every maneuver a unique name.
fn name_steps(plan: &mut PlanDocument) {
    let mut taken = BTreeSet::new();
    for (step, number) in plan.maneuvers.iter_mut().zip(1..) {
        let kind = match &step.task {
            PlanTask::Goto { .. } => "Goto",
            PlanTask::FollowPath { .. } => "Path",
            PlanTask::StationKeeping { .. } => "Station",
            PlanTask::Loiter { .. } => "Loiter",
            PlanTask::Rows { .. } => "Rows",
        };
        let wanted = name(&step.id);
        let wanted = if wanted.is_empty() { format!("{kind} {number}") } else { wanted };
        step.id = free(&wanted, |name| taken.contains(name));
        taken.insert(step.id.clone());
    }
}

/// `wanted`, or `wanted` with a number appended, such that it is not taken.
pub(crate) fn free(wanted: &str, taken: impl Fn(&str) -> bool) -> String {
    let numbered = |number: u32| {
        let tail = format!(" ({number})");
        format!("{}{tail}", cut(wanted, LONGEST_PLAN_NAME - tail.len()).trim_end())
    };
    let all = std::iter::once(wanted.to_owned()).chain((2..).map(numbered));
    all.into_iter().find(|name| !taken(name)).unwrap_or_default()
}

/// Turns a text into a valid name.
fn name(text: &str) -> String {
    let seen: String = text.chars().map(|letter| if letter.is_control() { ' ' } else { letter }).collect();
    cut(seen.trim(), LONGEST_PLAN_NAME).trim_end().to_owned()
}

/// The beginning of a text, at most so many bytes.
fn cut(text: &str, bytes: usize) -> &str {
    let end =
        text.char_indices().map(|(at, letter)| at + letter.len_utf8()).take_while(|end| *end <= bytes).last();
    &text[..end.unwrap_or(0)]
}

/// Problems, each on a line.
fn lines(troubles: Vec<Said>) -> Said {
    let more = troubles.len().saturating_sub(PROBLEMS);
    let more = (more > 0).then(|| say("and {more} more").with("more", more).into());
    Said::lines(troubles.into_iter().take(PROBLEMS).chain(more))
}
