//! `chart depth` and `chart corridor`.

use crate::cli::say::{complain, say};
use anyhow::ensure;
use charts::depth_index::{ChartTrust, Demand, DepthAnswer, DepthIndex, Leg, Water};
use clap::Args;
use serde_json::{Value, json};
use std::path::Path;
use units::LatLon;

/// What the vessel needs.
#[derive(Debug, Args)]
struct Needs {
    /// Depth that the vessel needs (m): draught, squat and water under the keel.
    #[arg(long = "needs", value_name = "M", default_value_t = 1.0, value_parser = metres, allow_negative_numbers = true)]
    depth_m: f64,
    /// Height of the water above chart datum (m).
    #[arg(long, value_name = "M", default_value_t = 0.0, value_parser = water_level, allow_negative_numbers = true)]
    water_level: f64,
    /// How far the vessel may be from where it believes to be (m).
    #[arg(long, value_name = "M", default_value_t = 0.0, value_parser = metres, allow_negative_numbers = true)]
    position: f64,
    /// Height above the water (m), for bridges and cables.
    #[arg(long, value_name = "M", value_parser = metres, allow_negative_numbers = true)]
    air_draught: Option<f64>,
    /// Allow for the errors that the chart gives for its depths and positions (CATZOC).
    #[arg(long)]
    errors: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:
  lutra-server chart depth --at 63.4517,10.3834 --radius 20

It ends with a failure (exit code 1) when the place is not navigable with these needs.")]
pub(super) struct DepthArguments {
    /// The place in degrees.
    #[arg(long, value_name = "LAT,LON", value_parser = place, allow_hyphen_values = true)]
    at: LatLon,
    /// The worst within this distance of it (m), so that single rocks count.
    #[arg(long, value_name = "M", default_value_t = 0.0, value_parser = metres, allow_negative_numbers = true)]
    radius: f64,
    #[command(flatten)]
    needs: Needs,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:
  lutra-server chart corridor --from 63.44,10.38 --to 63.46,10.42 --half-width 25

It ends with a failure (exit code 1) when the way is not navigable with these needs.")]
pub(super) struct CorridorArguments {
    /// Start in degrees.
    #[arg(long, value_name = "LAT,LON", value_parser = place, allow_hyphen_values = true)]
    from: LatLon,
    /// End in degrees.
    #[arg(long, value_name = "LAT,LON", value_parser = place, allow_hyphen_values = true)]
    to: LatLon,
    /// Half the width that is looked at (m).
    #[arg(long, value_name = "M", default_value_t = 20.0, value_parser = metres, allow_negative_numbers = true)]
    half_width: f64,
    #[command(flatten)]
    needs: Needs,
}

/// A place like `63.45,10.38`.
pub(in crate::cli) fn place(text: &str) -> Result<LatLon, String> {
    let (lat, lon) = text.split_once(',').ok_or("write LAT,LON in degrees, like 63.4517,10.3834")?;
    let number =
        |text: &str| text.trim().parse::<f64>().map_err(|_| format!("{text:?} is not a number of degrees"));
    LatLon::from_deg(number(lat)?, number(lon)?).map_err(|error| error.to_string())
}

/// Most metres that a question may have, and how far water can stand above or below chart datum (m).
pub(super) const MOST_M: f64 = 10_000.0;
const TIDE_M: f64 = 20.0;

pub(super) fn within(text: &str, least: f64, most: f64) -> Result<f64, String> {
    let metres: f64 = text.parse().map_err(|_| "this is not a number of metres".to_owned())?;
    if (least..=most).contains(&metres) { Ok(metres) } else { Err(format!("{least} to {most} m")) }
}

fn metres(text: &str) -> Result<f64, String> {
    within(text, 0.0, MOST_M)
}

fn water_level(text: &str) -> Result<f64, String> {
    within(text, -TIDE_M, TIDE_M)
}

impl Needs {
    fn demand(&self) -> Demand {
        Demand {
            water_level_m: self.water_level,
            air_draught_m: self.air_draught,
            position_m: self.position,
            trust: if self.errors {
                ChartTrust::AllErrors(ChartTrust::STANDARD)
            } else {
                ChartTrust::AsCharted
            },
            ..Demand::least_depth(self.depth_m)
        }
    }
}

pub(in crate::cli) fn index(db: &Path) -> anyhow::Result<DepthIndex> {
    let loaded = chartdb::load_index(db)?;
    if let Some(why) = loaded.rebuilt {
        complain!("{why}; made again from the charts");
    }
    Ok(loaded.sealed.index)
}

/// Reports charts that could not be read for an answer.
fn tell_damage(index: &DepthIndex, db: &Path) {
    for what in index.unreadable() {
        let file = chartdb::index_path(db);
        complain!(
            "{what}; it counts as a danger. Remove {}: it is made again from the charts",
            file.display()
        );
    }
}

pub(super) fn depth(db: &Path, json: bool, arguments: &DepthArguments) -> anyhow::Result<()> {
    let index = index(db)?;
    let demand = arguments.needs.demand();
    // A place without any size can still be uncertain.
    let answer = if arguments.radius > 0.0 || demand.position_m > 0.0 || arguments.needs.errors {
        index.shallowest_within(arguments.at, arguments.radius, &demand)
    } else {
        complain!("rocks, wrecks and soundings beside the place are not looked at; --radius M does");
        index.depth_at(arguments.at, &demand)
    };
    tell_damage(&index, db);
    if json {
        say!("{}", described(&index, &answer));
    } else {
        say!("{}", words(&index, &answer));
    }
    ensure!(answer.navigable, "the place is not navigable with these needs");
    Ok(())
}

pub(super) fn corridor(db: &Path, json: bool, arguments: &CorridorArguments) -> anyhow::Result<()> {
    let index = index(db)?;
    let demand = arguments.needs.demand();
    let leg = Leg { from: arguments.from, to: arguments.to };
    let worst = index.shallowest_along(leg, arguments.half_width, &demand);
    let first = index.first_danger_along(leg, arguments.half_width, &demand);
    tell_damage(&index, db);
    if json {
        let mut value = described(&index, &worst);
        value["first_danger"] = first.as_ref().map_or(Value::Null, |first| described(&index, first));
        say!("{value}");
    } else {
        say!("{}", words(&index, &worst));
        match &first {
            Some(first) => say!("first danger: {}", words(&index, first)),
            None => say!("nothing on the way is too shallow"),
        }
    }
    ensure!(first.is_none(), "the way is not navigable with these needs");
    Ok(())
}

fn kind(water: Water) -> &'static str {
    match water {
        Water::Land => "land",
        Water::Obstacle => "obstacle",
        Water::UnknownDepth => "unknown depth",
        Water::NoData => "no data",
        Water::TooLow { .. } => "too low overhead",
        Water::Depth { least_m, .. } if least_m < 0.0 => "intertidal",
        Water::Depth { .. } => "water",
    }
}

fn words(index: &DepthIndex, answer: &DepthAnswer) -> String {
    let depth = match answer.water {
        Water::Depth { least_m, greatest_m: Some(greatest_m) } => format!(" {least_m} m to {greatest_m} m"),
        Water::Depth { least_m, greatest_m: None } => format!(" {least_m} m"),
        _ => String::new(),
    };
    let object = answer.object.and_then(|object| index.object(object)).map_or(String::new(), |object| {
        let source = index.source(&object);
        let (class, record, name) = (object.class, object.record, &source.name);
        if source.scale == 0 {
            return format!(" ({class} {record} of {name})");
        }
        let (edition, update, scale) = (&source.edition, &source.update, source.scale);
        format!(" ({class} {record} of {name}, edition {edition} update {update}, 1:{scale})")
    });
    let (lat, lon) = (answer.at.lat_deg(), answer.at.lon_deg());
    let way = if answer.along_m > 0.0 || answer.off_m > 0.0 {
        format!(", {:.1} m along and {:.1} m off", answer.along_m, answer.off_m)
    } else {
        String::new()
    };
    let margin = answer.margin_m.map_or(String::new(), |margin_m| format!("; margin {margin_m:.2} m"));
    let verdict = if answer.navigable { "navigable" } else { "NOT navigable" };
    format!("{}{depth}{object} at {lat:.6},{lon:.6}{way}{margin}; {verdict}", kind(answer.water))
}

fn described(index: &DepthIndex, answer: &DepthAnswer) -> Value {
    let (least, greatest) = match answer.water {
        Water::Depth { least_m, greatest_m } => (Some(least_m), greatest_m),
        _ => (None, None),
    };
    let clearance = if let Water::TooLow { clearance_m } = answer.water { clearance_m } else { None };
    let object = answer.object.and_then(|object| index.object(object)).map(|object| {
        let source = index.source(&object);
        json!({"class": object.class.to_string(), "record": object.record, "name": object.name,
               "chart": source.name, "edition": source.edition, "update": source.update,
               "scale": source.scale, "band": source.band, "sounding_datum": source.sounding_datum})
    });
    json!({"water": kind(answer.water), "least_m": least, "greatest_m": greatest, "clearance_m": clearance,
           "navigable": answer.navigable, "margin_m": answer.margin_m, "depth_error_m": answer.depth_error_m,
           "zone": answer.zone, "lat_deg": answer.at.lat_deg(), "lon_deg": answer.at.lon_deg(),
           "along_m": answer.along_m, "off_m": answer.off_m, "half_width_m": answer.half_width_m,
           "object": object})
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_length_that_cannot_be_is_refused_with_what_can() {
        assert_eq!((metres("0"), water_level("-1.5")), (Ok(0.0), Ok(-1.5)));
        for text in ["-5", "nan", "inf", "10001"] {
            assert_eq!(metres(text), Err("0 to 10000 m".to_owned()), "{text}");
        }
        assert_eq!(water_level("500"), Err("-20 to 20 m".to_owned()));
        assert!(metres("deep").unwrap_err().contains("metres"));
    }
}
