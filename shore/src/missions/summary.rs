//! The summary of one vessel in a range of time, from the history.

use api::MissionVessel;
use imc::Address;
use imc::messages::PlanControlStateState;
use std::collections::BTreeSet;
use store::{Cell, DetectionsWanted, Order, Page, Reader, Samples, Source, TimeRange};
use units::{Ecef, Geodetic};

/// Positions are thinned to one in each such span (µs).
const STEP_US: i64 = 1_000_000;
/// More time than this between positions is a gap (µs).
const GAP_US: i64 = 60_000_000;
/// Samples of one series that are read at once: about two hours of positions.
const SAMPLES: usize = 72_000;
/// Detections, and states of plans, that are read at once.
const ROWS: Page = Page { skip: 0, rows: 5_000, bytes: 1 << 20 };
/// Plans that are named.
const PLANS: usize = 100;
/// Microseconds in an hour.
const HOUR_US: f64 = 3.6e9;

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
    told.energy_wh = energy_wh(reader, system, range)?;
    told.plans = plans(reader, system, range)?;
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
        let found = reader.samples(source, &["true_lat_deg", "true_lon_deg"], rest, SAMPLES)?;
        let [lat, lon] = &found.values[..] else { return Ok(way) };
        for ((time_us, lat), lon) in found.time_us.iter().zip(lat).zip(lon) {
            way.add(*time_us, (*lat, *lon));
        }
        let Some(last_us) = found.time_us.last().filter(|_| found.cut) else { return Ok(way) };
        // Other positions in the same microsecond would be thinned out anyway.
        rest.from_us = last_us + 1;
    }
}

/// Energy taken from all batteries (Wh). A battery is what reports charge, voltage and current.
fn energy_wh(reader: &mut Reader, system: Address, range: TimeRange) -> store::Result<Option<f64>> {
    let series = reader.series(Some(system))?;
    let reporting = |message: &str| -> BTreeSet<u8> {
        let of = series.iter().filter(|series| series.message == Some(message) && series.dated.count > 0);
        of.map(|series| series.group.src_ent).collect()
    };
    let [charge, voltage, current] = ["FuelLevel", "Voltage", "Current"].map(reporting);
    let mut sum = None;
    for entity in charge.into_iter().filter(|entity| voltage.contains(entity) && current.contains(entity)) {
        if let Some(wh) = drawn_wh(reader, system, entity, range)? {
            sum = Some(sum.unwrap_or(0.0) + wh);
        }
    }
    Ok(sum)
}

/// Energy taken from one battery (Wh); `None` where it did not report in the range.
fn drawn_wh(
    reader: &mut Reader,
    system: Address,
    entity: u8,
    range: TimeRange,
) -> store::Result<Option<f64>> {
    let of = |message: &str| Source { system, entity, message: message.to_owned() };
    let (voltage, current) = (of("Voltage"), of("Current"));
    let (mut drawn, mut rest) = (Drawn::default(), range);
    loop {
        let volts = reader.samples(&voltage, &["value"], rest, SAMPLES)?;
        let amps = reader.samples(&current, &["value"], rest, SAMPLES)?;
        // Where one of them is cut, both count up to there.
        let cut = [&volts, &amps].into_iter().filter(|of| of.cut).filter_map(|of| of.time_us.last()).min();
        drawn.add(&volts, &amps, cut.map_or(range.to_us, |last_us| last_us + 1));
        let Some(last_us) = cut else { return Ok(drawn.any.then_some(drawn.wh)) };
        rest.from_us = last_us + 1;
    }
}

/// The energy that flowed, by samples of voltage and current in order of time: the power of a sample holds until the next.
#[derive(Debug, Default)]
pub(super) struct Drawn {
    pub(super) wh: f64,
    /// Whether any power was known.
    pub(super) any: bool,
    volts: Option<f64>,
    /// Time and power (W) of the last sample of the current.
    before: Option<(i64, f64)>,
}

impl Drawn {
    /// Takes further samples, those before `until_us`.
    pub(super) fn add(&mut self, volts: &Samples, amps: &Samples, until_us: i64) {
        let pairs = |of: &Samples| -> Vec<(i64, f64)> {
            let values = of.values.first().into_iter().flatten().copied();
            let pairs = of.time_us.iter().copied().zip(values);
            pairs.filter(|(time_us, value)| *time_us < until_us && value.is_finite()).collect()
        };
        let mut volts = pairs(volts).into_iter().peekable();
        for (time_us, amps) in pairs(amps) {
            while let Some((_, value)) = volts.next_if(|(at_us, _)| *at_us <= time_us) {
                self.volts = Some(value);
            }
            if let Some((before_us, watts)) = self.before
                && time_us - before_us <= GAP_US
            {
                self.wh += watts * (time_us - before_us) as f64 / HOUR_US;
            }
            self.before = self.volts.map(|volts| (time_us, volts * amps));
            self.any |= self.before.is_some();
        }
        self.volts = volts.last().map(|(_, value)| value).or(self.volts);
    }
}

/// Names of the plans that were sailed, in the order in which they were begun first.
fn plans(reader: &mut Reader, system: Address, range: TimeRange) -> store::Result<Vec<String>> {
    let mut names = Vec::new();
    let Some(source) = most_said(reader, system, "PlanControlState", |_| true)? else { return Ok(names) };
    let sails = Cell::Integer(i64::from(PlanControlStateState::Executing.value()));
    let (mut rest, mut page) = (range, ROWS);
    loop {
        let found = reader.rows(&source, &["state", "plan_id"], rest, page)?;
        for row in &found.items {
            let [state, name] = &row.cells[..] else { continue };
            let name = name.as_text().unwrap_or_default();
            if *state == sails
                && !name.is_empty()
                && names.len() < PLANS
                && !names.iter().any(|known| known == name)
            {
                names.push(name.to_owned());
            }
        }
        let Some(next) = found.next else { return Ok(names) };
        rest.from_us = next.time_us;
        page.skip = next.skip;
    }
}

/// Number of detections and of tags.
fn heard(reader: &mut Reader, system: Address, range: TimeRange) -> store::Result<(u64, u64)> {
    let mut wanted =
        DetectionsWanted { systems: Some(vec![system]), range, came_from: None, tags: Vec::new() };
    let (mut count, mut tags, mut page) = (0, BTreeSet::new(), ROWS);
    loop {
        let found = reader.detections_of(&wanted, Order::Oldest, page)?;
        count += found.items.len() as u64;
        tags.extend(found.items.iter().map(detections::Detection::tag));
        let Some(next) = found.next else { return Ok((count, tags.len() as u64)) };
        wanted.range.from_us = next.time_us;
        page.skip = next.skip;
    }
}
