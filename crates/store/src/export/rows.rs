//! The rows of a table in order of time, in constant memory, whatever they are written as.
//!
//! A single series is streamed. Several are read in slices of time that hold about a megabyte of written rows; the rows of a slice
//! are sorted and passed on. Of a compressed month each series keeps the chunk that it stands in, as long as all of them together have no
//! more than [`MOST_HELD_BYTES`]; beyond that a series unpacks its chunk again for each slice. Rows of one time are in the order of message, system and entity. The same question to the
//! same history gives the same rows.

use super::cells::CHUNK_BYTES;
use super::columns::columns;
use super::options::CsvOptions;
use super::plan::{Message, Plan};
use crate::error::Result;
use crate::history::Order;
use crate::history::rows::{Question, Row};
use crate::history::{ColumnKind, GroupKey, Table};
use crate::range::TimeRange;
use crate::reader::Reader;
use imc::Address;
use rusqlite::Connection;
use tables::Field;

/// Most bytes of a slice, unless all of it is of one microsecond.
const SLICE_BYTES: usize = 1 << 20;
/// Most bytes of chunks that stay unpacked; the one that is read comes on top.
const MOST_HELD_BYTES: usize = 64 << 20;
/// The first slice, and the longest (µs).
const FIRST_SLICE_US: i64 = 60_000_000;
const LONGEST_SLICE_US: i64 = 86_400_000_000;

/// How rows are written.
pub(super) trait Encode {
    /// What all rows of a series have in common: `label` is that of its entity, if it never changed.
    fn head(&self, group: GroupKey, system: &str, label: Option<&str>) -> Vec<u8>;

    /// Appends a message; how many rows that makes.
    fn write(
        &mut self,
        out: &mut Vec<u8>,
        line: &Line<'_>,
        time_us: i64,
        row: Row<'_>,
    ) -> rusqlite::Result<u64>;

    /// Passes written rows on in their order, and clears them.
    fn pass_on(&mut self, rows: &mut Vec<u8>) -> Result<()>;
}

/// Rows on their way out.
struct Output<'e> {
    encode: &'e mut dyn Encode,
    /// Written rows that were not passed on yet.
    buffer: Vec<u8>,
    rows: u64,
}

impl Output<'_> {
    fn pass_on_full(&mut self) -> Result<()> {
        if self.buffer.len() >= CHUNK_BYTES { self.encode.pass_on(&mut self.buffer) } else { Ok(()) }
    }
}

/// The chunks that series keep unpacked.
#[derive(Debug)]
struct Held {
    bytes: usize,
    most: usize,
}

impl Held {
    /// Counts what a series, which had `before`, keeps now, and has it given up where that is too much; what it keeps then.
    fn settle(&mut self, before: usize, question: &mut Question<'_>) -> usize {
        let now = question.held_bytes();
        self.bytes -= before;
        if self.bytes + now > self.most {
            question.release();
            return 0;
        }
        self.bytes += now;
        now
    }
}

/// One series of a month.
struct Series<'p, 'c> {
    group: GroupKey,
    /// When it is asked for.
    part: TimeRange,
    message: &'p Message,
    question: Question<'c>,
    /// Bytes of it in [`Held`].
    held: usize,
    /// Of each field its place among the columns that are asked for.
    places: Vec<usize>,
    /// What all rows have in common.
    head: Vec<u8>,
    /// Whether the label changed, so that it is not in `head`.
    changes: bool,
    /// Time of the next row to be read; `None` after the last.
    next_us: Option<i64>,
    /// The span of the last row that was written, where only the first of each span is.
    span: Option<i64>,
}

/// What is known of all rows of a series.
pub(super) struct Line<'s> {
    pub(super) group: GroupKey,
    pub(super) message: &'s Message,
    /// Of each field its place among the columns of a [`Row`].
    pub(super) places: &'s [usize],
    /// By [`Encode::head()`].
    pub(super) head: &'s [u8],
    /// Whether the label changed, so that it is not in `head`.
    pub(super) changes: bool,
}

/// Whether the row of this time is written; `span` is that of the row before.
fn takes(options: CsvOptions, span: &mut Option<i64>, time_us: i64) -> bool {
    let Some(every_us) = options.every_us else { return true };
    let here = time_us.div_euclid(every_us.get());
    span.replace(here) != Some(here)
}

/// Writes all rows; how many there are.
pub(super) fn write(
    reader: &mut Reader,
    plan: &Plan,
    options: CsvOptions,
    range: TimeRange,
    encode: &mut dyn Encode,
) -> Result<u64> {
    write_holding(MOST_HELD_BYTES, reader, plan, options, range, encode)
}

fn write_holding(
    most: usize,
    reader: &mut Reader,
    plan: &Plan,
    options: CsvOptions,
    range: TimeRange,
    encode: &mut dyn Encode,
) -> Result<u64> {
    let mut output = Output { encode, buffer: Vec::with_capacity(2 * CHUNK_BYTES), rows: 0 };
    for (key, part) in reader.parts(range)? {
        let connection = reader.month(key)?;
        connection.set_prepared_statement_cache_capacity(512);
        // All of a month is of one moment, however long the export takes.
        let snapshot = reader.named(key, connection.unchecked_transaction())?;
        let mut held = Held { bytes: 0, most };
        let mut there = Vec::new();
        for group in &plan.groups {
            let message = &plan.messages[group.message];
            let Some(table) = reader.schema.table(group.key.id) else { continue };
            for span in group.spans.iter().map(|span| span.within(part)).filter(|span| !span.is_empty()) {
                let series =
                    series(connection, plan, options, group.key, (message, table), span, output.encode);
                let mut series = reader.named(key, series)?;
                if let Some(series) = &mut series {
                    series.held = held.settle(0, &mut series.question);
                }
                there.extend(series);
            }
        }
        if let [one] = there.as_mut_slice() {
            stream(reader, key, one, options, &mut output)?;
        } else {
            slices(reader, key, &mut there, (part.to_us, &mut held), options, &mut output)?;
        }
        drop(there);
        reader.named(key, snapshot.finish())?;
    }
    let Output { encode, mut buffer, rows } = output;
    encode.pass_on(&mut buffer)?;
    Ok(rows)
}

fn series<'p, 'c>(
    connection: &'c Connection,
    plan: &Plan,
    options: CsvOptions,
    group: GroupKey,
    (message, table): (&'p Message, &Table),
    part: TimeRange,
    encode: &dyn Encode,
) -> rusqlite::Result<Option<Series<'p, 'c>>> {
    let (columns, places) = columns(message, options);
    let Some(question) = Question::new(connection, table, group, &columns, Order::Oldest)? else {
        return Ok(None);
    };
    let runs = plan.names.entities.get(&(group.src, group.src_ent));
    let changes = runs.is_some_and(|runs| runs.runs.len() > 1);
    let label = runs.and_then(|runs| runs.latest()).map_or("", String::as_str);
    let system = plan.names.system(Address(group.src));
    let head = encode.head(group, &system, (!changes).then_some(label));
    let mut series =
        Series { group, part, message, question, held: 0, places, head, changes, next_us: None, span: None };
    series.next_us = series.question.rows(part)?.next()?.map(Row::time_us).transpose()?;
    Ok(series.next_us.is_some().then_some(series))
}

/// One series: streamed.
fn stream(
    reader: &Reader,
    key: crate::MonthKey,
    series: &mut Series<'_, '_>,
    options: CsvOptions,
    output: &mut Output<'_>,
) -> Result<()> {
    let Series { group, part, message, question, places, head, changes, span, .. } = series;
    let line = Line { group: *group, message, places, head, changes: *changes };
    let mut rows = reader.named(key, question.rows(*part))?;
    while let Some(row) = reader.named(key, rows.next())? {
        let time_us = reader.named(key, row.time_us())?;
        if !takes(options, span, time_us) {
            continue;
        }
        output.rows += reader.named(key, output.encode.write(&mut output.buffer, &line, time_us, row))?;
        output.pass_on_full()?;
    }
    Ok(())
}

/// Several series: a slice of time after the other.
fn slices(
    reader: &Reader,
    key: crate::MonthKey,
    there: &mut [Series<'_, '_>],
    (to_us, held): (i64, &mut Held),
    options: CsvOptions,
    output: &mut Output<'_>,
) -> Result<()> {
    let mut slice = Slice::default();
    let mut width_us = FIRST_SLICE_US;
    while let Some(start_us) = there.iter().filter_map(|series| series.next_us).min() {
        let end_us = start_us.saturating_add(width_us).min(to_us);
        let bounded = width_us > 1;
        let whole = slice.read(there, held, (end_us, bounded), options, output.encode);
        let whole = reader.named(key, whole)?;
        if !whole {
            // Too much: the same again, shorter.
            width_us = (width_us / 4).max(1);
            continue;
        }
        slice.order.sort_unstable_by_key(|line| (line.time_us, line.series, line.start));
        for line in &slice.order {
            output.buffer.extend_from_slice(&slice.bytes[line.start..line.end]);
            output.pass_on_full()?;
        }
        output.rows += slice.rows;
        for ((series, next_us), span) in there.iter_mut().zip(&slice.next_us).zip(&slice.spans) {
            (series.next_us, series.span) = (*next_us, *span);
        }
        if slice.bytes.len() < SLICE_BYTES / 4 {
            width_us = (width_us * 2).min(LONGEST_SLICE_US);
        }
    }
    Ok(())
}

#[derive(Default)]
struct Slice {
    bytes: Vec<u8>,
    order: Vec<Written>,
    next_us: Vec<Option<i64>>,
    spans: Vec<Option<i64>>,
    rows: u64,
}

/// Where a message stands in a slice.
struct Written {
    time_us: i64,
    series: usize,
    start: usize,
    end: usize,
}

impl Slice {
    /// Reads all series up to a time; false when that is too much for one slice.
    fn read(
        &mut self,
        there: &mut [Series<'_, '_>],
        held: &mut Held,
        (end_us, bounded): (i64, bool),
        options: CsvOptions,
        encode: &mut dyn Encode,
    ) -> rusqlite::Result<bool> {
        self.bytes.clear();
        self.order.clear();
        self.rows = 0;
        self.next_us.clear();
        self.next_us.extend(there.iter().map(|series| series.next_us));
        self.spans.clear();
        self.spans.extend(there.iter().map(|series| series.span));
        for (at, one) in there.iter_mut().enumerate() {
            let Some(next_us) = one.next_us.filter(|next_us| *next_us < end_us) else { continue };
            let whole = self.read_one((at, one), (next_us, end_us, bounded), options, encode)?;
            one.held = held.settle(one.held, &mut one.question);
            if !whole {
                return Ok(false);
            }
        }
        Ok(true)
    }

    fn read_one(
        &mut self,
        (at, one): (usize, &mut Series<'_, '_>),
        (next_us, end_us, bounded): (i64, i64, bool),
        options: CsvOptions,
        encode: &mut dyn Encode,
    ) -> rusqlite::Result<bool> {
        let Series { group, part, message, question, places, head, changes, .. } = one;
        let line = Line { group: *group, message, places, head, changes: *changes };
        let mut rows = question.rows(TimeRange { from_us: next_us, to_us: part.to_us })?;
        self.next_us[at] = None;
        while let Some(row) = rows.next()? {
            let time_us = row.time_us()?;
            if time_us >= end_us {
                self.next_us[at] = Some(time_us);
                break;
            }
            if !takes(options, &mut self.spans[at], time_us) {
                continue;
            }
            let start = self.bytes.len();
            self.rows += encode.write(&mut self.bytes, &line, time_us, row)?;
            self.order.push(Written { time_us, series: at, start, end: self.bytes.len() });
            if bounded && self.bytes.len() > SLICE_BYTES {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

/// How many fields a message had.
pub(super) fn sent(row: Row<'_>) -> rusqlite::Result<usize> {
    Ok(row.get::<Option<u32>>(0)?.map_or(usize::MAX, |fields| fields as usize))
}

/// Whether a NULL is a NaN: of a real that was sent.
pub(super) fn is_nan(field: &Field, sent: usize) -> bool {
    matches!(field.kind, ColumnKind::Single | ColumnKind::Double) && field.at.is_some_and(|at| at < sent)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::Selection;
    use crate::{Accepted, PackedMonth, Store, Transport};
    use units::UtcTime;

    const START_US: i64 = 1_795_248_000_000_000;

    /// Writes times and entities.
    #[derive(Default)]
    struct Times(Vec<u8>);

    impl Encode for Times {
        fn head(&self, _: GroupKey, _: &str, _: Option<&str>) -> Vec<u8> {
            Vec::new()
        }

        fn write(
            &mut self,
            out: &mut Vec<u8>,
            line: &Line<'_>,
            time_us: i64,
            _: Row<'_>,
        ) -> rusqlite::Result<u64> {
            out.extend(format!("{time_us} {}\n", line.group.src_ent).bytes());
            Ok(1)
        }

        fn pass_on(&mut self, rows: &mut Vec<u8>) -> Result<()> {
            self.0.append(rows);
            Ok(())
        }
    }

    #[test]
    fn series_keep_no_more_chunks_than_they_may_and_the_rows_are_the_same() {
        const ENTITIES: i64 = 12;
        let folder = tempfile::tempdir().unwrap();
        let data = folder.path();
        let mut store = Store::open(data).unwrap();
        for at in 0..ENTITIES * 1_200 {
            let received = UtcTime::from_micros(START_US + at * 200_000);
            let header = imc::Header {
                timestamp: received.seconds(),
                src: imc::Address(0x2810),
                src_ent: (at % ENTITIES) as u8,
                ..imc::Header::default()
            };
            let mut packet = Vec::new();
            imc::encode_into(&mut packet, &header, &imc::messages::Temperature { value: 1.0 }).unwrap();
            let (transport, link) = (Transport::Tcp, None);
            store.accept(&Accepted { packet: &packet, received, transport, link }).unwrap();
        }
        store.commit().unwrap();
        store.settle().unwrap();
        let later = UtcTime::from_micros(START_US + 90 * LONGEST_SLICE_US);
        for month in crate::plan_months(data, 1, later).unwrap() {
            assert!(store.ready_month(month.key).unwrap());
            let packed = PackedMonth::make(data, &month, &mut |_| true).unwrap();
            assert!(store.adopt_month(packed).unwrap().done().is_some());
        }
        let options = CsvOptions::default();
        let written = |most| {
            let mut reader = Reader::open(data).unwrap();
            let selection = Selection::default().known(&mut reader).unwrap();
            let plan = Plan::new(&mut reader, &selection, options).unwrap();
            let mut times = Times::default();
            let rows = write_holding(most, &mut reader, &plan, options, TimeRange::ALL, &mut times).unwrap();
            (rows, times.0)
        };
        let all = written(usize::MAX);
        assert_eq!(all.0, ENTITIES.cast_unsigned() * 1_200);
        assert!(all == written(0), "none may be kept");
        assert!(all == written(100_000), "some may be kept");
    }
}
