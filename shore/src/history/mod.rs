//! The recorded history: the store's reader, as the API reports it.
//!
//! Each query opens its own reader, which is cheap and shares nothing, so that a long export does not block pages. More
//! than `QUESTIONS` queries at once are queued.

pub mod explore;
pub mod export;
pub mod heard;
pub mod imports;
mod places;
mod shelf;
pub mod size;
pub mod table;

pub use imports::Imports;
pub use places::Places;

use crate::decode;
use api::{Recorded, RecordedDay, ValueKind};
use imc::Address;
use imc::catalogue::Meaning;
use serde_json::Value as Json;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use store::{Cell, Column, ColumnKind, Order, Page, Reader, Source, StoreError, TimeRange};
use tokio::sync::Semaphore;
use tokio_util::sync::CancellationToken;
use units::UtcTime;

/// Queries that are answered at the same time: more would only wait for the disk.
const QUESTIONS: usize = 16;
/// Most exports at the same time.
const EXPORTS: usize = 4;
/// Most summaries of detections that are counted at the same time: each takes up to some 140 MB, if it covers all that the
/// explorer holds.
const COUNTS: usize = 2;
/// Most files of detections whose size is estimated at the same time.
const SIZES: usize = 2;
/// How long a request waits for a place of either kind.
const PATIENCE: Duration = Duration::from_secs(5);
/// Tolerance between the ends of a declared gap and the samples around it (µs).
const MOMENT_US: i64 = 1_000_000;
/// Bytes of text and raw data in one answer.
const ANSWER_BYTES: usize = 8 << 20;
/// Most series in the state of one vessel.
const SERIES: usize = 5_000;

/// The history of a data folder; cheap to clone.
#[derive(Clone)]
pub struct History {
    data: Arc<Path>,
    questions: Arc<Semaphore>,
    /// Places for exports.
    pub exports: Arc<Semaphore>,
    /// Places to count detections.
    pub counts: Places,
    /// Places to estimate the size of a file of detections.
    pub sizes: Places,
    /// Detections in memory, for plots.
    pub explorer: explore::Explorer,
}

impl History {
    /// Of this data folder.
    pub fn new(data: &Path) -> Self {
        Self {
            data: data.into(),
            questions: Arc::new(Semaphore::new(QUESTIONS)),
            exports: Arc::new(Semaphore::new(EXPORTS)),
            counts: Places::new(COUNTS, PATIENCE),
            sizes: Places::new(SIZES, PATIENCE),
            explorer: explore::Explorer::new(data),
        }
    }

    /// The folder.
    pub fn data(&self) -> &Path {
        &self.data
    }

    /// Runs a query on a thread for blocking work.
    ///
    /// # Errors
    /// As the query; [`StoreError::Cancelled`] when the server ends.
    pub async fn ask<R: Send + 'static>(
        &self,
        question: impl FnOnce(&mut Reader) -> store::Result<R> + Send + 'static,
    ) -> store::Result<R> {
        let place = Arc::clone(&self.questions).acquire_owned().await.map_err(|_| StoreError::Cancelled)?;
        let data = Arc::clone(&self.data);
        let answer = tokio::task::spawn_blocking(move || {
            let _place = place;
            question(&mut Reader::open(&data)?)
        });
        answer.await.map_err(|_| StoreError::Cancelled)?
    }
}

/// The recorded messages, by system.
///
/// # Errors
/// The store cannot be read.
pub fn recorded(reader: &mut Reader) -> store::Result<Vec<Recorded>> {
    let mut all = BTreeMap::<(u16, String), Recorded>::new();
    for series in reader.series(None)? {
        let abbrev = series.message.map_or_else(|| series.group.id.to_string(), str::to_owned);
        let timed = if series.dated.count > 0 { series.dated } else { series.extent };
        let (first_us, last_us) = (stated(timed.first_us, 0), stated(timed.last_us, 0));
        let system = series.group.src;
        let entry = all.entry((system, abbrev.clone()));
        let known = entry.or_insert_with(|| Recorded { system, abbrev, count: 0, first_us, last_us });
        known.count += series.extent.count;
        known.first_us = known.first_us.min(first_us);
        known.last_us = known.last_us.max(last_us);
    }
    Ok(all.into_values().collect())
}

/// The sender's time, or the alternative if it is not a valid time.
fn stated(time_us: i64, otherwise_us: i64) -> i64 {
    if time_us == store::NO_TIME_US { otherwise_us } else { time_us }
}

/// What was received on which day, of the systems that `may` admits, the newest day first.
///
/// # Errors
/// The store cannot be read.
pub fn recorded_days(reader: &mut Reader, may: impl Fn(u16) -> bool) -> store::Result<Vec<RecordedDay>> {
    let names: BTreeMap<u16, String> =
        reader.systems()?.into_iter().map(|system| (system.address.0, system.name)).collect();
    let day = |one: store::RecordedDay| RecordedDay {
        system: one.system.0,
        name: names.get(&one.system.0).cloned().unwrap_or_else(|| one.system.to_string()),
        day_us: one.day.micros(),
        first_us: stated(one.extent.first_us, one.day.micros()),
        last_us: stated(one.extent.last_us, one.day.micros()),
        packets: one.extent.count,
        bytes: one.bytes,
    };
    Ok(reader.recorded_days()?.into_iter().filter(|one| may(one.system.0)).map(day).collect())
}

/// Every series of the systems that `may` admits.
///
/// # Errors
/// The store cannot be read.
pub fn series(reader: &mut Reader, may: impl Fn(u16) -> bool) -> store::Result<Vec<api::Series>> {
    let all = reader.series(None)?;
    let describe = |series: store::Series| {
        let period_s = series.period_s();
        let dated = (series.dated.count > 0).then_some(series.dated);
        let columns = reader.table_of(series.group).map_or_else(Vec::new, |table| fields(&table.columns));
        api::Series {
            system: series.group.src,
            message: series.message.map_or_else(|| series.group.id.to_string(), str::to_owned),
            id: series.group.id,
            entity: series.group.src_ent,
            label: series.label,
            fields: columns,
            count: series.extent.count,
            undated: series.extent.count - series.dated.count,
            first_us: dated.map(|extent| extent.first_us),
            last_us: dated.map(|extent| extent.last_us),
            period_s,
        }
    };
    let mut found: Vec<_> = all.into_iter().filter(|one| may(one.group.src)).map(describe).collect();
    found.sort_by(|a, b| (a.system, &a.message, a.entity).cmp(&(b.system, &b.message, b.entity)));
    Ok(found)
}

fn fields<'c>(columns: impl IntoIterator<Item = &'c Column>) -> Vec<api::SeriesField> {
    columns.into_iter().map(field).collect()
}

fn field(column: &Column) -> api::SeriesField {
    let meaning = column.desc.map_or(Meaning::Plain, |desc| desc.meaning);
    let (kind, values) = match (column.kind, meaning) {
        (ColumnKind::Integer, Meaning::Enumeration(desc)) => (ValueKind::Enumeration, desc.values),
        (ColumnKind::Integer, Meaning::Bitfield(desc)) => (ValueKind::Bits, desc.values),
        (ColumnKind::Integer, Meaning::Plain) => (ValueKind::Integer, &[][..]),
        (ColumnKind::Single | ColumnKind::Double, _) => (ValueKind::Real, &[][..]),
        (ColumnKind::Text, _) => (ValueKind::Text, &[][..]),
        (ColumnKind::Raw, _) => (ValueKind::Raw, &[][..]),
        (ColumnKind::Nested, _) => (ValueKind::Nested, &[][..]),
    };
    let label =
        |label: &imc::catalogue::Label| api::Label { value: label.value, name: label.abbrev.to_owned() };
    api::SeriesField {
        name: column.name.to_owned(),
        title: column.desc.map_or("computed from the message", |desc| desc.name).to_owned(),
        unit: column.unit.unwrap_or_default().to_owned(),
        kind,
        labels: values.iter().map(label).collect(),
    }
}

/// A field as about `pixels` buckets.
///
/// # Errors
/// There is no such field, or the store cannot be read.
pub fn buckets(
    reader: &mut Reader,
    source: &Source,
    name: &str,
    range: TimeRange,
    pixels: usize,
) -> store::Result<api::Buckets> {
    let found = reader.buckets(source, name, range, pixels)?;
    let unit = reader.table(&source.message)?.column(name).and_then(|column| column.unit);
    let mut buckets = api::Buckets {
        unit: unit.unwrap_or_default().to_owned(),
        width_us: found.width_us,
        ..api::Buckets::default()
    };
    for bucket in found.buckets {
        buckets.start_us.push(bucket.start_us);
        buckets.first_us.push(bucket.first_us);
        buckets.count.push(bucket.count);
        buckets.min.push(bucket.min);
        buckets.max.push(bucket.max);
        buckets.mean.push(Some(bucket.mean).filter(|mean| mean.is_finite()));
        buckets.first.push(bucket.first);
        buckets.last.push(bucket.last);
    }
    Ok(buckets)
}

/// Raw samples; all fields if none are named.
///
/// # Errors
/// There is no such field, the answer would be too large, or the store cannot be read.
pub fn samples(
    reader: &mut Reader,
    source: &Source,
    names: &[String],
    range: TimeRange,
    page: Page,
) -> store::Result<api::Samples> {
    let table = reader.table(&source.message)?;
    let columns: Vec<Column> = if names.is_empty() {
        table.columns.clone()
    } else {
        // Invalid names are skipped here and refused below, where all names are checked.
        names.iter().filter_map(|name| table.column(name)).cloned().collect()
    };
    let asked: Vec<&str> = if names.is_empty() {
        columns.iter().map(|column| column.name).collect()
    } else {
        names.iter().map(String::as_str).collect()
    };
    let found = reader.rows(source, &asked, range, page)?;
    let row = |row: store::Row| api::SampleRow {
        time_us: row.time.micros(),
        received_us: row.received.micros(),
        values: row.cells.into_iter().zip(&columns).map(|(cell, column)| value(cell, column.kind)).collect(),
    };
    Ok(api::Samples {
        fields: fields(&columns),
        rows: found.items.into_iter().map(row).collect(),
        next: found.next.map(|rest| next(rest, range, Order::Oldest)),
    })
}

fn value(cell: Cell, kind: ColumnKind) -> Json {
    match cell {
        Cell::Nothing => Json::Null,
        Cell::Integer(number) => number.into(),
        // JSON has no numbers for these; the words are those of `imc::json`.
        Cell::Real(number) if number.is_nan() => "NaN".into(),
        Cell::Real(f64::INFINITY) => "Infinity".into(),
        Cell::Real(f64::NEG_INFINITY) => "-Infinity".into(),
        // The shortest decimal of this single, not the many digits of its double.
        Cell::Real(number) if kind == ColumnKind::Single => {
            (number as f32).to_string().parse::<f64>().map_or(Json::Null, Json::from)
        }
        Cell::Real(number) => number.into(),
        Cell::Text(text) if kind == ColumnKind::Nested => {
            serde_json::from_str(&text).unwrap_or_else(|_| Json::from(text))
        }
        Cell::Text(text) => imc::text::escape(text.as_bytes()).into(),
        Cell::Raw(bytes) if kind == ColumnKind::Text => imc::text::escape(&bytes).into(),
        Cell::Raw(bytes) => hex::encode(bytes).into(),
    }
}

/// State of a vessel at a time.
///
/// # Errors
/// The store cannot be read.
pub fn at(reader: &mut Reader, vessel: Address, time_us: i64) -> store::Result<api::At> {
    let then = reader.then(vessel, time_us, SERIES, ANSWER_BYTES)?;
    let update = |last: store::Last| {
        let columns = reader.table_of(last.group).map_or(&[][..], |table| &table.columns);
        let fields = last.row.cells.into_iter().zip(columns).map(|(cell, column)| cell_of(cell, column));
        api::Update {
            system: last.group.src,
            id: last.group.id,
            abbrev: last.message.to_owned(),
            entity: last.group.src_ent,
            instance: None,
            time_us: last.row.time.micros(),
            received_us: last.row.received.micros(),
            count: 0,
            period_s: last.period_s,
            fields: fields.collect(),
        }
    };
    let mut values: Vec<api::Update> = then.last.into_iter().map(update).collect();
    values.sort_by(|a, b| (&a.abbrev, a.entity).cmp(&(&b.abbrev, b.entity)));
    Ok(api::At { time_us, values, cut: then.cut })
}

/// A cell in the form of live values.
fn cell_of(cell: Cell, column: &Column) -> api::Field {
    let meaning = match (&cell, column.desc) {
        (Cell::Integer(number), Some(desc)) => desc.label(*number),
        _ => None,
    };
    api::Field {
        name: column.name.to_owned(),
        // As with live values: a page draws nothing for a value that is not a number.
        value: match cell {
            Cell::Real(number) if !number.is_finite() => Json::Null,
            cell => value(cell, column.kind),
        },
        unit: column.unit.unwrap_or_default().to_owned(),
        meaning,
    }
}

/// A page of at most so many rows and `ANSWER_BYTES`.
pub fn page(rows: usize, skip: usize) -> Page {
    Page { skip, rows, bytes: ANSWER_BYTES }
}

/// Ends work whose answer is not waited for any more.
fn goes_on(given_up: &CancellationToken) -> store::Result<()> {
    if given_up.is_cancelled() { Err(StoreError::Cancelled) } else { Ok(()) }
}

fn next(next: store::Next, range: TimeRange, order: Order) -> api::Next {
    let range = match order {
        Order::Oldest => TimeRange { from_us: next.time_us, ..range },
        Order::Newest => TimeRange { to_us: next.time_us.saturating_add(1), ..range },
    };
    let skip = u32::try_from(next.skip).unwrap_or(u32::MAX);
    api::Next { from_us: range.from_us, to_us: range.to_us, skip }
}

/// A track of about `points` points at most, and the longest time between two of them without a gap (µs).
///
/// # Errors
/// The store cannot be read.
pub fn track(
    reader: &mut Reader,
    vessel: Address,
    range: TimeRange,
    points: usize,
) -> store::Result<(Vec<api::TrackPoint>, i64)> {
    track_while(reader, vessel, (range, points), &mut || Ok(()))
}

/// The same; `goes_on` is asked again and again, and its error ends it.
///
/// # Errors
/// That of `goes_on`, or the store cannot be read.
fn track_while(
    reader: &mut Reader,
    vessel: Address,
    (range, points): (TimeRange, usize),
    goes_on: &mut dyn FnMut() -> store::Result<()>,
) -> store::Result<(Vec<api::TrackPoint>, i64)> {
    let track = reader.track_while(vessel, (range, points), 0.0, goes_on)?;
    let point = |point: &store::TrackPoint| api::TrackPoint {
        time_us: point.time.micros(),
        lat_deg: point.place.lat_deg(),
        lon_deg: point.place.lon_deg(),
    };
    Ok((track.points.iter().map(point).collect(), track.step_us))
}

/// Longest time between two positions that a line may join (µs), where positions are not thinned further apart than a third of that.
const UNBROKEN_US: i64 = 300_000_000;

/// The parts of a track between breaks: no line is drawn over a time from which nothing is known.
pub fn unbroken(points: &[api::TrackPoint], step_us: i64) -> impl Iterator<Item = &[api::TrackPoint]> {
    let longest_us = UNBROKEN_US.max(step_us.saturating_mul(3));
    points.chunk_by(move |one, next| next.time_us.saturating_sub(one.time_us) <= longest_us)
}

/// All labels that a vessel's entities had.
///
/// # Errors
/// The store cannot be read.
pub fn entities(reader: &mut Reader, vessel: Address) -> store::Result<Vec<api::Entity>> {
    let entity = |name: store::EntityName| api::Entity {
        entity: name.entity,
        label: name.label,
        from_us: name.from.micros(),
        last_us: name.last.micros(),
    };
    Ok(reader.entities(vessel)?.into_iter().map(entity).collect())
}

/// Detections of a vessel; with `came_from` only those received at or after that time.
///
/// # Errors
/// The store cannot be read.
pub fn detections(
    reader: &mut Reader,
    vessel: Address,
    range: TimeRange,
    came_from: Option<UtcTime>,
    order: Order,
    page: Page,
) -> store::Result<api::Detections> {
    let found = reader.detections(Some(vessel), range, came_from, order, page)?;
    let detections = found.items.into_iter().map(decode::detection).collect();
    Ok(api::Detections { detections, next: found.next.map(|rest| next(rest, range, order)) })
}

/// A vessel's log book.
///
/// # Errors
/// The store cannot be read.
pub fn log_book(
    reader: &mut Reader,
    vessel: Address,
    range: TimeRange,
    order: Order,
    page: Page,
) -> store::Result<api::LogBook> {
    let entry = |one: store::LogEntry| api::LogBookEntry {
        entity: one.entity,
        time_us: one.sent.micros(),
        written_us: one.written.map(UtcTime::micros),
        kind: one.kind,
        kind_name: one.kind_name,
        context: one.context,
        text: one.text,
    };
    let found = reader.log_book(Some(vessel), range, order, page)?;
    let entries = found.items.into_iter().map(entry).collect();
    Ok(api::LogBook { entries, next: found.next.map(|rest| next(rest, range, order)) })
}

/// Gaps that a vessel declared, and times of silence, in order of time. A declared gap has more information: a silence
/// within one is not reported again.
///
/// # Errors
/// The store cannot be read.
pub fn gaps(reader: &mut Reader, vessel: Address, range: TimeRange) -> store::Result<Vec<api::Gap>> {
    let gap = |gap: store::Gap| api::Gap {
        from_us: gap.from.micros(),
        to_us: gap.to.micros(),
        kind: match gap.kind {
            store::GapKind::NotRecorded => api::GapKind::NotRecorded,
            store::GapKind::NotDelivered => api::GapKind::NotDelivered,
            store::GapKind::Lost => api::GapKind::Lost,
        },
        reason: gap.told(),
        declared_us: gap.declared.micros(),
    };
    let mut gaps: Vec<api::Gap> = reader.gaps(Some(vessel), range)?.into_iter().map(gap).collect();
    let mut silences = reader.silences(vessel, range)?;
    silences.retain(|silence| {
        // The ends of a silence were heard; a declared gap begins and ends within moments of them.
        let within = |gap: &api::Gap| {
            gap.from_us - MOMENT_US <= silence.from_us && silence.to_us <= gap.to_us + MOMENT_US
        };
        !gaps.iter().any(within)
    });
    gaps.extend(silences.into_iter().map(|silence| api::Gap {
        from_us: silence.from_us,
        to_us: silence.to_us,
        kind: api::GapKind::NotRecorded,
        reason: format!("nothing was heard for {:.0} s", (silence.to_us - silence.from_us) as f64 / 1e6),
        declared_us: silence.to_us,
    }));
    gaps.sort_by_key(|gap| (gap.from_us, gap.to_us));
    Ok(gaps)
}
