//! The summary of one vessel in a range of time, from the history.

use api::MissionVessel;
use imc::Address;
use std::collections::BTreeSet;
use store::{DetectionsWanted, Order, Page, Reader, Source, TimeRange};
use units::{Ecef, Geodetic};

/// Positions are thinned to one in each such span (µs).
const STEP_US: i64 = 1_000_000;
/// More time than this between positions is a gap (µs).
const GAP_US: i64 = 60_000_000;
/// Positions that are read at once: about two hours of them.
const POSITIONS: usize = 72_000;
/// Detections that are read at once.
const DETECTIONS: Page = Page { skip: 0, rows: 5_000, bytes: 1 << 20 };

/// The summary of a vessel.
///
/// # Errors
/// The history cannot be read.
pub(super) fn of_vessel(reader: &mut Reader, vessel: u16, range: TimeRange) -> store::Result<MissionVessel> {
    let system = Address(vessel);
    let mut told = MissionVessel { vessel, ..MissionVessel::default() };
    if let Some(source) = most_said(reader, system, "EstimatedState", |_| true)? {
        let way = way(reader, &source, range)?;
        (told.first_us, told.last_us) = (way.first_us, way.last.map(|(time_us, _)| time_us));
        (told.distance_m, told.recorded_s) = (way.distance_m, way.recorded_us as f64 / 1e6);
    }
    // A boat may report the charge of several batteries: the label of its own contains "fuel".
    let fuel = |label: &str| label.to_lowercase().contains("fuel");
    let battery = match most_said(reader, system, "FuelLevel", fuel)? {
        Some(named) => Some(named),
        None => most_said(reader, system, "FuelLevel", |_| true)?,
    };
    if let Some(source) = battery {
        let levels = reader.buckets(&source, "value", range, 1)?.buckets;
        told.battery_first_percent = levels.first().map(|level| level.first);
        told.battery_last_percent = levels.last().map(|level| level.last);
    }
    (told.detections, told.tags) = heard(reader, system, range)?;
    Ok(told)
}

/// The entity with the most `message`s, among those whose label is wanted.
fn most_said(
    reader: &mut Reader,
    system: Address,
    message: &str,
    wanted: impl Fn(&str) -> bool,
) -> store::Result<Option<Source>> {
    let all = reader.series(Some(system))?;
    let of = all.into_iter().filter(|series| series.message == Some(message) && series.dated.count > 0);
    let of = of.filter(|series| wanted(series.label.as_deref().unwrap_or_default()));
    let most = of.max_by_key(|series| series.dated.count);
    Ok(most.map(|series| Source { system, entity: series.group.src_ent, message: message.to_owned() }))
}

/// The distance over ground of positions in order of time.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Way {
    pub(super) first_us: Option<i64>,
    /// Time and place (degrees) of the last position that counted.
    pub(super) last: Option<(i64, (f64, f64))>,
    pub(super) distance_m: f64,
    pub(super) recorded_us: i64,
}

impl Way {
    /// Takes the next position, if it is not too near in time to the last.
    pub(super) fn add(&mut self, time_us: i64, place: (f64, f64)) {
        if !place.0.is_finite() || !place.1.is_finite() {
            return;
        }
        let Some((before_us, from)) = self.last else {
            (self.first_us, self.last) = (Some(time_us), Some((time_us, place)));
            return;
        };
        let step_us = time_us - before_us;
        if step_us < STEP_US {
            return;
        }
        self.distance_m += distance_m(from, place);
        self.recorded_us += if step_us <= GAP_US { step_us } else { 0 };
        self.last = Some((time_us, place));
    }
}

/// The chord between two places on the ellipsoid (m). It is shorter than the geodesic by d³/24R²: 1 mm at 10 km.
pub(super) fn distance_m(from: (f64, f64), to: (f64, f64)) -> f64 {
    let at = |(lat_deg, lon_deg): (f64, f64)| -> Ecef {
        Geodetic { lat_rad: lat_deg.to_radians(), lon_rad: lon_deg.to_radians(), height_m: 0.0 }.to_ecef()
    };
    let (from, to) = (at(from), at(to));
    (to.x_m - from.x_m).hypot(to.y_m - from.y_m).hypot(to.z_m - from.z_m)
}

fn way(reader: &mut Reader, source: &Source, range: TimeRange) -> store::Result<Way> {
    let (mut way, mut rest) = (Way::default(), range);
    loop {
        let found = reader.samples(source, &["true_lat_deg", "true_lon_deg"], rest, POSITIONS)?;
        let [lat, lon] = &found.values[..] else { return Ok(way) };
        for ((time_us, lat), lon) in found.time_us.iter().zip(lat).zip(lon) {
            way.add(*time_us, (*lat, *lon));
        }
        let Some(last_us) = found.time_us.last().filter(|_| found.cut) else { return Ok(way) };
        // Other positions in the same microsecond would be thinned out anyway.
        rest.from_us = last_us + 1;
    }
}

/// Number of detections and of tags.
fn heard(reader: &mut Reader, system: Address, range: TimeRange) -> store::Result<(u64, u64)> {
    let mut wanted =
        DetectionsWanted { systems: Some(vec![system]), range, came_from: None, tags: Vec::new() };
    let (mut count, mut tags, mut page) = (0, BTreeSet::new(), DETECTIONS);
    loop {
        let found = reader.detections_of(&wanted, Order::Oldest, page)?;
        count += found.items.len() as u64;
        tags.extend(found.items.iter().map(detections::Detection::tag));
        let Some(next) = found.next else { return Ok((count, tags.len() as u64)) };
        wanted.range.from_us = next.time_us;
        page.skip = next.skip;
    }
}
