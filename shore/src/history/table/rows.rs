//! Rows of series and of detections.

use super::{Found, SeriesName, called, found, wrong};
use crate::history;
use api::{Buckets, TableDetection, TableRow, Vessel};
use detections::Detection;
use imc::Address;
use std::collections::BTreeMap;
use store::{DetectionsWanted, Order, Page, Reader, TimeRange};
use tables::IsoTime;
use tokio_util::sync::CancellationToken;

/// About so many rows at most.
const ROWS: usize = 50_000;

/// A validated question for rows of series.
#[derive(Debug, Clone)]
pub struct Asked {
    /// The series of each vessel.
    pub series: Vec<SeriesName>,
    /// From when to when.
    pub range: TimeRange,
    /// About how many rows of each series of a vessel.
    pub points: usize,
    /// Angles in degrees instead of radians.
    pub degrees: bool,
}

impl Asked {
    /// The rows of these vessels, in order of time, then of vessel and series. Memory and time are bounded by the number of rows and series;
    /// it ends between two series where it is not waited for any more.
    ///
    /// # Errors
    /// A series cannot be, there would be too many rows, the question was given up, or the history cannot be read.
    pub fn rows(
        &self,
        reader: &mut Reader,
        vessels: &[Address],
        named: &[Vessel],
        given_up: &CancellationToken,
    ) -> store::Result<Vec<TableRow>> {
        let names = called(reader, named)?;
        let series = found(reader, &self.series, vessels, given_up)?;
        self.check_size(series.len())?;
        let mut rows: Vec<(i64, TableRow)> = Vec::new();
        for one in series {
            history::goes_on(given_up)?;
            let buckets = history::buckets(reader, &one.source, &one.field, self.range, self.points)?;
            let vessel = called_or_address(&names, one.source.system);
            rows.extend(self.of_series(&buckets, &one, &vessel));
        }
        rows.sort_by(|(at_us, a), (other_us, b)| {
            (at_us, &a.vessel, &a.series).cmp(&(other_us, &b.vessel, &b.series))
        });
        Ok(rows.into_iter().map(|(_, row)| row).collect())
    }

    fn check_size(&self, series: usize) -> store::Result<()> {
        if series * self.points > ROWS {
            let text = format_args!(
                "{series} series with {} points each are more than {ROWS} rows; ask for at most {} points, or for fewer series or vessels",
                self.points,
                ROWS / series
            );
            return Err(wrong("points", text));
        }
        Ok(())
    }

    fn of_series<'b>(
        &'b self,
        buckets: &'b Buckets,
        one: &'b Found,
        vessel: &'b str,
    ) -> impl Iterator<Item = (i64, TableRow)> + 'b {
        let is_angle = buckets.unit == "rad" || buckets.unit.starts_with("rad/");
        let turned = self.degrees && is_angle;
        let unit = if turned { buckets.unit.replacen("rad", "°", 1) } else { buckets.unit.clone() };
        // A value beyond all sense must stay a number.
        let shown =
            move |value: f64| if turned { value.to_degrees().clamp(f64::MIN, f64::MAX) } else { value };
        let mut iso = IsoTime::new();
        (0..buckets.start_us.len()).map(move |at| {
            let (first_us, count) = (buckets.first_us[at], buckets.count[at]);
            // As plots draw it: a single sample where it is, several in the middle of their stretch.
            let middle_us = buckets.start_us[at].saturating_add(buckets.width_us / 2);
            let within = middle_us.min(self.range.to_us.saturating_sub(1)).max(first_us);
            let time_us = if count == 1 { first_us } else { within };
            let row = TableRow {
                time: moment(&mut iso, time_us),
                vessel: vessel.to_owned(),
                series: one.to_string(),
                entity: one.entity.clone(),
                unit: unit.clone(),
                min: shown(buckets.min[at]),
                mean: buckets.mean[at].map(shown),
                max: shown(buckets.max[at]),
                count,
            };
            (time_us, row)
        })
    }
}

/// A page of what is seldom is looked for in so many parts of the history (200,000 messages each); then it ends early.
const MOST_PARTS: usize = 32;

/// A page of the detections that are wanted, the oldest or the newest report first, and where the rest begins.
///
/// # Errors
/// The question was given up, or the history cannot be read.
pub fn detections(
    reader: &mut Reader,
    wanted: &DetectionsWanted,
    (order, page): (Order, Page),
    given_up: &CancellationToken,
    named: &[Vessel],
) -> store::Result<(Vec<TableDetection>, Option<api::Next>)> {
    let names = called(reader, named)?;
    let (mut found, mut rest) = (Vec::new(), None);
    let (mut wanted, mut part) = (wanted.clone(), page);
    for _ in 0..MOST_PARTS {
        history::goes_on(given_up)?;
        let paged = reader.detections_of(&wanted, order, part)?;
        found.extend(paged.items);
        rest = paged.next.map(|next| history::next(next, wanted.range, order));
        let Some(next) = rest.filter(|_| found.len() < page.rows) else { break };
        wanted.range = TimeRange { from_us: next.from_us, to_us: next.to_us };
        // Of further parts less text, so that the whole is bounded too.
        part = Page { skip: next.skip as usize, rows: page.rows - found.len(), bytes: page.bytes / 8 };
    }
    let mut iso = IsoTime::new();
    let row = |one: Detection| {
        let place = one.pose.map(|pose| pose.place);
        TableDetection {
            time: moment(&mut iso, one.origin.reported.micros()),
            vessel: called_or_address(&names, one.origin.system),
            tag: one.tag(),
            data: one.data,
            latitude: place.map(units::LatLon::lat_deg),
            longitude: place.map(units::LatLon::lon_deg),
            snr_db: one.snr_db,
        }
    };
    Ok((found.into_iter().map(row).collect(), rest))
}

fn called_or_address(names: &BTreeMap<Address, String>, vessel: Address) -> String {
    names.get(&vessel).cloned().unwrap_or_else(|| vessel.to_string())
}

/// ISO 8601 UTC with milliseconds.
fn moment(iso: &mut IsoTime, time_us: i64) -> String {
    let mut out = Vec::with_capacity(24);
    iso.write_ms(&mut out, time_us);
    String::from_utf8_lossy(&out).into_owned()
}
