//! Currents in CSV: a line for each crossing of the grid.

use super::{COLUMNS, CurrentField, CurrentsError, LineTrouble, MOST_CROSSINGS};
use std::collections::BTreeSet;
use units::UtcTime;

/// Most lines of a file.
const MOST_LINES: usize = 2_000_000;
/// Of the crossings of a grid at least one in so many has a line: scattered points are not a grid.
const SPARSEST: usize = 8;

struct Row {
    line: usize,
    time_us: i64,
    lat_deg: f64,
    lon_deg: f64,
    flow_mps: [f32; 2],
}

pub(super) fn read(text: &str) -> Result<CurrentField, CurrentsError> {
    let mut lines = (1..).zip(text.lines()).filter(|(_, line)| !line.trim().is_empty());
    let heading = lines.next().map_or("", |(_, heading)| heading);
    let columns = columns(heading)?;
    let mut rows = Vec::new();
    for (line, text) in lines {
        if rows.len() == MOST_LINES {
            return Err(wrong(line, LineTrouble::TooMany { most: MOST_LINES }));
        }
        rows.push(row(line, text, columns)?);
    }
    field(&rows)
}

fn wrong(line: usize, trouble: LineTrouble) -> CurrentsError {
    CurrentsError::Line { line, trouble }
}

/// In which column each value stands.
fn columns(heading: &str) -> Result<[usize; 5], CurrentsError> {
    let names: Vec<String> = heading.split(',').map(|name| name.trim().to_ascii_lowercase()).collect();
    let mut found = [0; 5];
    for (at, name) in found.iter_mut().zip(COLUMNS) {
        let column = names.iter().position(|one| one == name);
        *at = column.ok_or_else(|| wrong(1, LineTrouble::NoColumn { name }))?;
    }
    Ok(found)
}

fn row(line: usize, text: &str, columns: [usize; 5]) -> Result<Row, CurrentsError> {
    let cells: Vec<&str> = text.split(',').map(str::trim).collect();
    let mut values = [""; 5];
    for ((value, column), name) in values.iter_mut().zip(columns).zip(COLUMNS) {
        let short = || wrong(line, LineTrouble::Short { name, columns: cells.len() });
        *value = cells.get(column).ok_or_else(short)?;
    }
    let [time, lat, lon, east, north] = values;
    let time_us =
        time.parse::<UtcTime>().map_err(|_| wrong(line, LineTrouble::NoTime { text: short(time) }))?;
    let degrees = |name: &'static str, text: &str, least: i16, most: i16| {
        let within = f64::from(least)..=f64::from(most);
        let number = text.parse().ok().filter(|degrees| within.contains(degrees));
        number.ok_or_else(|| wrong(line, LineTrouble::NoDegrees { name, text: short(text), least, most }))
    };
    let speed = |name: &'static str, text: &str| {
        if text.is_empty() || text.eq_ignore_ascii_case("nan") {
            return Ok(f32::NAN);
        }
        let number = text.parse().ok().filter(|mps: &f32| mps.is_finite());
        number.ok_or_else(|| wrong(line, LineTrouble::NoSpeed { name, text: short(text) }))
    };
    Ok(Row {
        line,
        time_us: time_us.micros(),
        lat_deg: degrees(COLUMNS[1], lat, -90, 90)?,
        lon_deg: degrees(COLUMNS[2], lon, -180, 360)?,
        flow_mps: [speed(COLUMNS[3], east)?, speed(COLUMNS[4], north)?],
    })
}

/// What is shown of a text that is wrong.
fn short(text: &str) -> String {
    text.chars().take(40).collect()
}

fn field(rows: &[Row]) -> Result<CurrentField, CurrentsError> {
    let times: Vec<i64> = rows.iter().map(|row| row.time_us).collect::<BTreeSet<_>>().into_iter().collect();
    let (lats_deg, lons_deg) =
        (axis(rows.iter().map(|row| row.lat_deg)), axis(rows.iter().map(|row| row.lon_deg)));
    let (rows_of, columns) = (lats_deg.len(), lons_deg.len());
    let crossings = times.len().saturating_mul(rows_of).saturating_mul(columns);
    if rows_of < 2 || columns < 2 {
        return Err(CurrentsError::TooFew { lats: rows_of, lons: columns });
    }
    if crossings > MOST_CROSSINGS || crossings > rows.len().saturating_mul(SPARSEST) {
        let (times, lines) = (times.len(), rows.len());
        return Err(CurrentsError::Scattered { times, lats: rows_of, lons: columns, crossings, lines });
    }
    let mut first_line = vec![0_usize; crossings];
    let mut flows = vec![[f32::NAN; 2]; crossings];
    let place = |axis: &[f64], at: f64| axis.partition_point(|value| *value < at);
    for row in rows {
        let time = times.partition_point(|time| *time < row.time_us);
        let at = (time * rows_of + place(&lats_deg, row.lat_deg)) * columns + place(&lons_deg, row.lon_deg);
        if first_line[at] != 0 {
            return Err(wrong(row.line, LineTrouble::Twice { first: first_line[at] }));
        }
        (first_line[at], flows[at]) = (row.line, row.flow_mps);
    }
    Ok(CurrentField {
        times_s: times.iter().map(|time_us| UtcTime::from_micros(*time_us).seconds()).collect(),
        lats_deg,
        lons_deg,
        east_mps: flows.iter().map(|flow| flow[0]).collect(),
        north_mps: flows.iter().map(|flow| flow[1]).collect(),
    })
}

/// Each value once, rising.
fn axis(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}
