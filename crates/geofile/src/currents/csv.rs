//! Currents in CSV: a line for each crossing of the grid.

use super::{CurrentField, CurrentsError, MOST_CROSSINGS};
use std::collections::BTreeSet;
use units::UtcTime;

const COLUMNS: [&str; 5] = ["time", "lat", "lon", "east_mps", "north_mps"];
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
            return Err(wrong(
                line,
                &format!("the file has more than {MOST_LINES} lines; cut it to the area and the time"),
            ));
        }
        rows.push(row(line, text, columns)?);
    }
    field(&rows)
}

fn wrong(line: usize, what: &str) -> CurrentsError {
    CurrentsError::Line { line, what: what.to_owned() }
}

/// In which column each value stands.
fn columns(heading: &str) -> Result<[usize; 5], CurrentsError> {
    let names: Vec<String> = heading.split(',').map(|name| name.trim().to_ascii_lowercase()).collect();
    let mut found = [0; 5];
    for (at, wanted) in found.iter_mut().zip(COLUMNS) {
        *at = names.iter().position(|name| name == wanted).ok_or_else(|| {
            wrong(
                1,
                &format!("the heading has no column {wanted}; begin the file with {}", COLUMNS.join(",")),
            )
        })?;
    }
    Ok(found)
}

fn row(line: usize, text: &str, columns: [usize; 5]) -> Result<Row, CurrentsError> {
    let cells: Vec<&str> = text.split(',').map(str::trim).collect();
    let mut values = [""; 5];
    for ((value, column), name) in values.iter_mut().zip(columns).zip(COLUMNS) {
        *value = cells.get(column).ok_or_else(|| {
            wrong(
                line,
                &format!(
                    "there is no {name}: it has {} columns; write one for each in the heading",
                    cells.len()
                ),
            )
        })?;
    }
    let [time, lat, lon, east, north] = values;
    let time_us = time.parse::<UtcTime>().map_err(|_| {
        wrong(line, &format!("time: {} is not a time such as 2026-11-21T07:00:00Z", short(time)))
    })?;
    let degrees = |name: &str, text: &str, least: f64, most: f64| {
        let number = text.parse().ok().filter(|degrees| (least..=most).contains(degrees));
        number.ok_or_else(|| {
            wrong(line, &format!("{name}: {} is not within {least} to {most} degrees", short(text)))
        })
    };
    let speed = |name: &str, text: &str| {
        if text.is_empty() || text.eq_ignore_ascii_case("nan") {
            return Ok(f32::NAN);
        }
        let number = text.parse().ok().filter(|mps: &f32| mps.is_finite());
        number.ok_or_else(|| {
            wrong(
                line,
                &format!(
                    "{name}: {} is not a speed in m/s; leave it empty where it is not known",
                    short(text)
                ),
            )
        })
    };
    Ok(Row {
        line,
        time_us: time_us.micros(),
        lat_deg: degrees("lat", lat, -90.0, 90.0)?,
        lon_deg: degrees("lon", lon, -180.0, 360.0)?,
        flow_mps: [speed("east_mps", east)?, speed("north_mps", north)?],
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
        return Err(CurrentsError::Grid(format!(
            "the file has {rows_of} latitudes and {columns} longitudes; a grid has two of each or more"
        )));
    }
    if crossings > MOST_CROSSINGS || crossings > rows.len().saturating_mul(SPARSEST) {
        return Err(CurrentsError::Grid(format!(
            "{} times, {rows_of} latitudes and {columns} longitudes make {crossings} crossings, and the file has {} lines: give \
             points on a grid of latitudes and longitudes, {MOST_CROSSINGS} at most",
            times.len(),
            rows.len()
        )));
    }
    let mut first_line = vec![0_usize; crossings];
    let mut flows = vec![[f32::NAN; 2]; crossings];
    let place = |axis: &[f64], at: f64| axis.partition_point(|value| *value < at);
    for row in rows {
        let time = times.partition_point(|time| *time < row.time_us);
        let at = (time * rows_of + place(&lats_deg, row.lat_deg)) * columns + place(&lons_deg, row.lon_deg);
        if first_line[at] != 0 {
            return Err(wrong(
                row.line,
                &format!("the same time and place as in line {}; remove one", first_line[at]),
            ));
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
