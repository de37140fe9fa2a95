//! The bytes of a chunk: rows of a table as columns, each by itself, so that a question for one field unpacks only that.
//!
//! ```text
//! 1, count of rows, count of columns, bytes of each column    numbers as LEB128
//! the columns
//! CRC-32 of what the chunk belongs to and of all that, little endian
//! ```
//! What it belongs to is not written again: its group and the text of its layout, which are read with it. A fault there is seen too.
//! //! A column is `0` and its bytes, or `1`, their length and zstd of them. The bytes begin with the kind that all values have, or
//! with [`MIXED`] and the kind of each. Then come the integers, the reals, and the lengths and the bytes of texts and blobs, each
//! part only where there are values of that kind. Numbers are written in whichever way takes the least room: as differences, as
//! differences of differences, or with their first bytes side by side, then their second ones, and so on. Reals that came as
//! single precision have four bytes. What comes back is to the bit what went in.

use flate2::Crc;
use rusqlite::types::ValueRef;

/// Most rows of a chunk.
pub(crate) const ROWS: usize = 1_024;
/// A chunk is full when its texts and blobs have so many bytes.
pub(crate) const FULL_BYTES: usize = 1 << 20;
/// Most columns of a table: SQLite allows no more.
const MOST_COLUMNS: usize = 2_000;
/// Most bytes of a column. A packet has 64 KiB at most, also when its nested messages are written as text some MiB.
const MOST_BYTES: usize = 16 << 20;
const VERSION: u8 = 2;
const LEVEL: i32 = 9;
/// The level by which the ways of writing numbers are compared: much quicker, and it nearly always chooses the same.
const CHOICE_LEVEL: i32 = 1;

const NULL: u8 = 0;
const INTEGER: u8 = 1;
const REAL: u8 = 2;
const TEXT: u8 = 3;
const BLOB: u8 = 4;
const MIXED: u8 = 5;
/// Added to the code of numbers that are single precision.
const SINGLE: u8 = 100;

/// Why bytes are not a chunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub(crate) struct Damaged(&'static str);

impl Damaged {
    pub(crate) const GONE: Self = Self("it is gone");
    pub(crate) const LAYOUT: Self = Self("the list of its columns is gone");
    pub(crate) const KEYS: Self = Self("its times are not times");
    pub(crate) const ROWS: Self = Self("its rows are not those that it says it has");
}

/// A column on its way into a chunk, or out of it.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Column {
    kinds: Kinds,
    integers: Vec<i64>,
    reals: Vec<f64>,
    /// Where each text or blob ends in `bytes`.
    ends: Vec<u32>,
    bytes: Vec<u8>,
}

/// The kinds of a column's values. Most columns have one, and need no list.
#[derive(Debug, Clone, PartialEq)]
enum Kinds {
    /// So many values of one kind.
    All(u8, usize),
    /// Of each value its kind, and its place among those that stand with it.
    Each(Vec<u8>, Vec<u32>),
}

impl Default for Kinds {
    fn default() -> Self {
        Self::All(NULL, 0)
    }
}

impl Kinds {
    fn len(&self) -> usize {
        match self {
            Self::All(_, count) => *count,
            Self::Each(kinds, _) => kinds.len(),
        }
    }

    fn push(&mut self, kind: u8, place: usize) {
        match self {
            Self::All(all, count) if *count == 0 || *all == kind => {
                *all = kind;
                *count += 1;
            }
            Self::All(all, count) => {
                let place_of = |row: usize| if *all == NULL { 0 } else { row as u32 };
                let mut places: Vec<u32> = (0..*count).map(place_of).collect();
                let mut kinds = vec![*all; *count];
                kinds.push(kind);
                places.push(place as u32);
                *self = Self::Each(kinds, places);
            }
            Self::Each(kinds, places) => {
                kinds.push(kind);
                places.push(place as u32);
            }
        }
    }

    /// The kind of a value, and its place.
    fn at(&self, row: usize) -> Option<(u8, usize)> {
        match self {
            Self::All(kind, count) => (row < *count).then_some((*kind, row)),
            Self::Each(kinds, places) => {
                kinds.get(row).zip(places.get(row)).map(|(kind, place)| (*kind, *place as usize))
            }
        }
    }

    /// How much memory it takes, about.
    fn bytes(&self) -> usize {
        match self {
            Self::All(..) => 0,
            Self::Each(kinds, places) => kinds.len() + 4 * places.len(),
        }
    }
}

impl Column {
    /// Adds a value.
    pub(crate) fn push(&mut self, value: ValueRef<'_>) {
        let (kind, place) = match value {
            ValueRef::Null => (NULL, 0),
            ValueRef::Integer(value) => {
                self.integers.push(value);
                (INTEGER, self.integers.len() - 1)
            }
            ValueRef::Real(value) => {
                self.reals.push(value);
                (REAL, self.reals.len() - 1)
            }
            ValueRef::Text(bytes) | ValueRef::Blob(bytes) => {
                self.bytes.extend_from_slice(bytes);
                self.ends.push(self.bytes.len() as u32);
                (if matches!(value, ValueRef::Text(_)) { TEXT } else { BLOB }, self.ends.len() - 1)
            }
        };
        self.kinds.push(kind, place);
    }

    /// The value of a row.
    pub(crate) fn value(&self, row: usize) -> ValueRef<'_> {
        let Some((kind, place)) = self.kinds.at(row) else {
            return ValueRef::Null;
        };
        match kind {
            INTEGER => ValueRef::Integer(self.integers[place]),
            REAL => ValueRef::Real(self.reals[place]),
            kind @ (TEXT | BLOB) => {
                let start = if place == 0 { 0 } else { self.ends[place - 1] as usize };
                let bytes = &self.bytes[start..self.ends[place] as usize];
                if kind == TEXT { ValueRef::Text(bytes) } else { ValueRef::Blob(bytes) }
            }
            _ => ValueRef::Null,
        }
    }

    /// All values, if all are integers.
    pub(crate) fn integers(&self) -> Option<&[i64]> {
        (self.integers.len() == self.kinds.len()).then_some(&self.integers)
    }

    /// How much memory it takes, about.
    pub(crate) fn bytes(&self) -> usize {
        let numbers = 8 * (self.integers.len() + self.reals.len());
        self.kinds.bytes() + 4 * self.ends.len() + numbers + self.bytes.len()
    }

    /// Bytes of texts and blobs.
    pub(crate) fn long_bytes(&self) -> usize {
        self.bytes.len()
    }

    fn encode(&self) -> Vec<u8> {
        let mut plain = Vec::new();
        match &self.kinds {
            Kinds::All(kind, _) => plain.push(*kind),
            Kinds::Each(kinds, _) => {
                plain.push(MIXED);
                plain.extend_from_slice(kinds);
            }
        }
        if !self.integers.is_empty() {
            plain.extend(least(Numbers::ALL.map(|numbers| numbers.of_integers(&self.integers))));
        }
        if !self.reals.is_empty() {
            plain.extend(least(Numbers::ALL.map(|numbers| numbers.of_reals(&self.reals))));
        }
        let mut start = 0;
        for end in &self.ends {
            write_varint(u64::from(end - start), &mut plain);
            start = *end;
        }
        plain.extend_from_slice(&self.bytes);
        squeezed(&plain, LEVEL)
    }

    fn decode(body: &[u8], rows: usize) -> Result<Self, Damaged> {
        let (how, rest) = body.split_first().ok_or(Damaged("a column is empty"))?;
        let unpacked;
        let mut rest = match *how {
            0 => rest,
            1 => {
                let mut rest = rest;
                let length = read_length(&mut rest, MOST_BYTES)?;
                unpacked = zstd::bulk::decompress(rest, length)
                    .map_err(|_| Damaged("a column cannot be unpacked"))?;
                if unpacked.len() != length {
                    return Err(Damaged("a column is not as long as it says"));
                }
                &unpacked
            }
            _ => return Err(Damaged("a column is of no kind")),
        };
        let (kind, after) = rest.split_first().ok_or(Damaged("a column is empty"))?;
        rest = after;
        let (kinds, counts) = match *kind {
            MIXED => kinds_of_each(take(&mut rest, rows)?)?,
            kind => {
                let mut counts: Counts = [0; MIXED as usize];
                *counts.get_mut(row_of(kind)).ok_or(NO_KIND)? = rows;
                (Kinds::All(kind, rows), counts)
            }
        };
        let count = |kind: u8| counts[usize::from(kind)];
        let integers = read_integers(&mut rest, count(INTEGER))?;
        let reals = read_reals(&mut rest, count(REAL))?;
        let mut ends = Vec::with_capacity(count(TEXT));
        let mut end = 0;
        for _ in 0..count(TEXT) {
            end += read_length(&mut rest, MOST_BYTES - end)?;
            ends.push(end as u32);
        }
        if rest.len() != end {
            return Err(Damaged("texts are not as long as they say"));
        }
        Ok(Self { kinds, integers, reals, ends, bytes: rest.to_vec() })
    }
}

/// How many values there are of each kind; texts and blobs stand in one row, and count as texts.
type Counts = [usize; MIXED as usize];

const NO_KIND: Damaged = Damaged("a value is of no kind");

fn row_of(kind: u8) -> usize {
    usize::from(if kind == BLOB { TEXT } else { kind })
}

fn kinds_of_each(kinds: &[u8]) -> Result<(Kinds, Counts), Damaged> {
    let mut counts: Counts = [0; MIXED as usize];
    let mut places = Vec::with_capacity(kinds.len());
    for kind in kinds {
        let count = counts.get_mut(row_of(*kind)).ok_or(NO_KIND)?;
        places.push(*count as u32);
        *count += usize::from(*kind != NULL);
    }
    Ok((Kinds::Each(kinds.to_vec(), places), counts))
}

/// Columns of equally many rows as a chunk of what `owner` says.
pub(crate) fn encode(columns: &[Column], owner: &str) -> Result<Vec<u8>, Damaged> {
    let rows = columns.first().map_or(0, |column| column.kinds.len());
    if columns.iter().any(|column| column.kinds.len() != rows || column.bytes.len() > MOST_BYTES / 2) {
        return Err(Damaged("a value is too long for a chunk"));
    }
    let mut out = vec![VERSION];
    write_varint(rows as u64, &mut out);
    write_varint(columns.len() as u64, &mut out);
    let bodies: Vec<Vec<u8>> = columns.iter().map(Column::encode).collect();
    for body in &bodies {
        write_varint(body.len() as u64, &mut out);
    }
    out.extend(bodies.concat());
    let sum = sum_of(owner, &out);
    out.extend_from_slice(&sum.to_le_bytes());
    Ok(out)
}

fn sum_of(owner: &str, bytes: &[u8]) -> u32 {
    let mut sum = Crc::new();
    sum.update(owner.as_bytes());
    sum.update(bytes);
    sum.sum()
}

/// A chunk whose sum was checked.
#[derive(Debug)]
pub(crate) struct Body<'b> {
    rows: usize,
    columns: Vec<&'b [u8]>,
}

impl<'b> Body<'b> {
    /// Checks the sum, and finds the columns. It must be a chunk of the very `owner`.
    pub(crate) fn open(bytes: &'b [u8], owner: &str) -> Result<Self, Damaged> {
        let (said, sum) = bytes.split_last_chunk().ok_or(Damaged("it is too short"))?;
        if sum_of(owner, said) != u32::from_le_bytes(*sum) {
            return Err(Damaged("its sum is wrong"));
        }
        let mut rest = said.strip_prefix(&[VERSION]).ok_or(Damaged("it is of an unknown form"))?;
        let rows = read_length(&mut rest, ROWS)?;
        let count = read_length(&mut rest, MOST_COLUMNS)?;
        let mut lengths = Vec::with_capacity(count);
        for _ in 0..count {
            lengths.push(read_length(&mut rest, MOST_BYTES)?);
        }
        let columns = lengths.into_iter().map(|length| take(&mut rest, length)).collect::<Result<_, _>>()?;
        if !rest.is_empty() {
            return Err(Damaged("it is longer than it says"));
        }
        Ok(Self { rows, columns })
    }

    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    /// Unpacks a column.
    pub(crate) fn column(&self, at: usize) -> Result<Column, Damaged> {
        let body = self.columns.get(at).ok_or(Damaged("it has too few columns"))?;
        Column::decode(body, self.rows)
    }
}

/// How numbers are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Numbers {
    /// Once, for all are the same.
    Same,
    /// As differences, LEB128.
    Differences,
    /// As differences of differences, LEB128.
    Slopes,
    /// With equal bytes side by side.
    Planes,
    /// As that, of differences.
    DifferencePlanes,
    /// As that, of what changes bit by bit.
    ChangePlanes,
}

impl Numbers {
    const ALL: [Self; 6] = [
        Self::Same,
        Self::Differences,
        Self::Slopes,
        Self::Planes,
        Self::DifferencePlanes,
        Self::ChangePlanes,
    ];

    fn code(self) -> u8 {
        Self::ALL.iter().position(|one| *one == self).unwrap_or(0) as u8
    }

    fn of_code(code: u8) -> Result<Self, Damaged> {
        Self::ALL.get(usize::from(code)).copied().ok_or(Damaged("numbers are of no kind"))
    }

    fn of_integers(self, values: &[i64]) -> Option<Vec<u8>> {
        let words: Vec<u64> = values.iter().map(|value| value.cast_unsigned()).collect();
        let mut out = vec![self.code()];
        self.write::<8>(&words, &mut out)?;
        Some(out)
    }

    /// Reals that are single precision to the bit have four bytes.
    fn of_reals(self, values: &[f64]) -> Option<Vec<u8>> {
        let is_single = |value: &f64| f64::from(*value as f32).to_bits() == value.to_bits();
        let mut out = Vec::new();
        if values.iter().all(is_single) {
            out.push(self.code() + SINGLE);
            let words: Vec<u64> = values.iter().map(|value| u64::from((*value as f32).to_bits())).collect();
            self.write::<4>(&words, &mut out)?;
        } else {
            out.push(self.code());
            let words: Vec<u64> = values.iter().map(|value| value.to_bits()).collect();
            self.write::<8>(&words, &mut out)?;
        }
        Some(out)
    }

    /// Writes numbers of so many bytes; nothing where this way is not for them.
    fn write<const WIDTH: usize>(self, words: &[u64], out: &mut Vec<u8>) -> Option<()> {
        match self {
            Self::Same => {
                let first = words.first().filter(|first| words.iter().all(|word| word == *first))?;
                write_varint(zigzag(*first), out);
            }
            Self::Differences => differences(words).for_each(|word| write_varint(zigzag(word), out)),
            Self::Slopes => {
                let first: Vec<u64> = differences(words).collect();
                differences(&first).for_each(|word| write_varint(zigzag(word), out));
            }
            Self::Planes => planes::<WIDTH>(words, out),
            Self::DifferencePlanes => planes::<WIDTH>(&differences(words).collect::<Vec<_>>(), out),
            Self::ChangePlanes => planes::<WIDTH>(&changes(words), out),
        }
        Some(())
    }

    fn read<const WIDTH: usize>(self, from: &mut &[u8], count: usize) -> Result<Vec<u64>, Damaged> {
        let mut words = match self {
            Self::Same => {
                let word = unzigzag(read_varint(from)?);
                return Ok(vec![word; count]);
            }
            Self::Differences | Self::Slopes => {
                let mut words = Vec::with_capacity(count);
                for _ in 0..count {
                    words.push(unzigzag(read_varint(from)?));
                }
                words
            }
            Self::Planes | Self::DifferencePlanes | Self::ChangePlanes => {
                let bytes = take(from, count * WIDTH)?;
                let word = |row: usize| {
                    let mut le = [0; 8];
                    (0..WIDTH).for_each(|plane| le[plane] = bytes[plane * count + row]);
                    u64::from_le_bytes(le)
                };
                (0..count).map(word).collect()
            }
        };
        match self {
            Self::Same | Self::Planes => {}
            Self::Differences | Self::DifferencePlanes => sums(&mut words),
            Self::Slopes => {
                sums(&mut words);
                sums(&mut words);
            }
            Self::ChangePlanes => {
                let mut before = 0;
                for word in &mut words {
                    *word ^= before;
                    before = *word;
                }
            }
        }
        Ok(words)
    }
}

fn read_integers(from: &mut &[u8], count: usize) -> Result<Vec<i64>, Damaged> {
    if count == 0 {
        return Ok(Vec::new());
    }
    let numbers = Numbers::of_code(take(from, 1)?[0])?;
    Ok(numbers.read::<8>(from, count)?.into_iter().map(u64::cast_signed).collect())
}

fn read_reals(from: &mut &[u8], count: usize) -> Result<Vec<f64>, Damaged> {
    if count == 0 {
        return Ok(Vec::new());
    }
    let code = take(from, 1)?[0];
    if let Some(code) = code.checked_sub(SINGLE) {
        let words = Numbers::of_code(code)?.read::<4>(from, count)?;
        return Ok(words.into_iter().map(|word| f64::from(f32::from_bits(word as u32))).collect());
    }
    let words = Numbers::of_code(code)?.read::<8>(from, count)?;
    Ok(words.into_iter().map(f64::from_bits).collect())
}

/// The way of writing that takes the least room.
fn least<const WAYS: usize>(ways: [Option<Vec<u8>>; WAYS]) -> Vec<u8> {
    ways.into_iter().flatten().min_by_key(|way| squeezed(way, CHOICE_LEVEL).len()).unwrap_or_default()
}

/// Bytes as a column: packed if that makes them shorter.
fn squeezed(plain: &[u8], level: i32) -> Vec<u8> {
    let mut out = vec![1];
    write_varint(plain.len() as u64, &mut out);
    match zstd::bulk::compress(plain, level) {
        Ok(packed) if packed.len() + out.len() <= plain.len() => out.extend(packed),
        _ => {
            out.clear();
            out.push(0);
            out.extend_from_slice(plain);
        }
    }
    out
}

fn differences(words: &[u64]) -> impl Iterator<Item = u64> {
    let before = std::iter::once(&0).chain(words);
    words.iter().zip(before).map(|(word, before)| word.wrapping_sub(*before))
}

fn changes(words: &[u64]) -> Vec<u64> {
    let before = std::iter::once(&0).chain(words);
    words.iter().zip(before).map(|(word, before)| word ^ before).collect()
}

fn sums(words: &mut [u64]) {
    let mut sum = 0_u64;
    for word in words {
        sum = sum.wrapping_add(*word);
        *word = sum;
    }
}

fn planes<const WIDTH: usize>(words: &[u64], out: &mut Vec<u8>) {
    for plane in 0..WIDTH {
        out.extend(words.iter().map(|word| word.to_le_bytes()[plane]));
    }
}

/// Small for what is near 0 on either side.
fn zigzag(word: u64) -> u64 {
    let value = word.cast_signed();
    ((value << 1) ^ (value >> 63)).cast_unsigned()
}

fn unzigzag(word: u64) -> u64 {
    (word >> 1) ^ (word & 1).wrapping_neg()
}

fn write_varint(mut value: u64, out: &mut Vec<u8>) {
    while value >= 0x80 {
        out.push(value as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

fn read_varint(from: &mut &[u8]) -> Result<u64, Damaged> {
    let mut value = 0;
    for shift in (0..64).step_by(7) {
        let byte = take(from, 1)?[0];
        value |= u64::from(byte & 0x7F) << shift;
        if byte & 0x80 == 0 {
            return Ok(value);
        }
    }
    Err(Damaged("a number is too long"))
}

fn read_length(from: &mut &[u8], most: usize) -> Result<usize, Damaged> {
    let length = read_varint(from)?;
    usize::try_from(length).ok().filter(|length| *length <= most).ok_or(Damaged("a length is too great"))
}

fn take<'b>(from: &mut &'b [u8], length: usize) -> Result<&'b [u8], Damaged> {
    let (head, rest) = from.split_at_checked(length).ok_or(Damaged("it is cut"))?;
    *from = rest;
    Ok(head)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rusqlite::types::Value;

    const OWNER: &str = "149 10256 5\nvalue REAL";

    fn columns(values: &[Vec<Value>]) -> Vec<Column> {
        let column = |values: &Vec<Value>| {
            let mut column = Column::default();
            for value in values {
                column.push(ValueRef::from(value));
            }
            column
        };
        values.iter().map(column).collect()
    }

    fn back(bytes: &[u8]) -> Vec<Column> {
        let body = Body::open(bytes, OWNER).unwrap();
        (0..body.columns.len()).map(|at| body.column(at).unwrap()).collect()
    }

    /// To the bit: a NaN and the sign of zero too.
    fn same(one: ValueRef<'_>, other: ValueRef<'_>) -> bool {
        match (one, other) {
            (ValueRef::Real(one), ValueRef::Real(other)) => one.to_bits() == other.to_bits(),
            (one, other) => one == other,
        }
    }

    fn mended(mut bytes: Vec<u8>) -> Vec<u8> {
        let sum = sum_of(OWNER, &bytes);
        bytes.extend_from_slice(&sum.to_le_bytes());
        bytes
    }

    #[test]
    fn what_a_vessel_says_takes_few_bytes() {
        let rows = || 0..ROWS as i64;
        let values = [
            rows().map(|row| Value::Integer(1_795_248_000_000_000 + row * 100_000 + row % 3)).collect(),
            rows().map(|_| Value::Integer(0xFFFF)).collect(),
            rows().map(|row| Value::Real(f64::from(20.0 + row as f32 * 0.01))).collect(),
            rows().map(|_| Value::Null).collect(),
            rows().map(|_| Value::Text("sonar".to_owned())).collect::<Vec<_>>(),
        ];
        let columns = columns(&values);
        let bytes = encode(&columns, OWNER).unwrap();
        assert_eq!(back(&bytes), columns);
        assert!(bytes.len() < 3 * ROWS, "{} bytes", bytes.len());
    }

    #[test]
    fn a_chunk_of_another_series_or_with_other_columns_is_refused() {
        let bytes = encode(&columns(&[vec![Value::Integer(5)]]), OWNER).unwrap();
        assert!(Body::open(&bytes, OWNER).is_ok());
        for other in ["149 10257 5\nvalue REAL", "149 10256 5\nvalve REAL", ""] {
            assert_eq!(Body::open(&bytes, other).unwrap_err(), Damaged("its sum is wrong"), "{other}");
        }
    }

    #[test]
    fn infinities_and_least_and_greatest_numbers_come_back() {
        let reals =
            [f64::INFINITY, f64::NEG_INFINITY, -0.0, f64::NAN, f64::MAX, f64::MIN_POSITIVE, 5e-324, 0.1];
        let integers = [i64::MIN, i64::MAX, 0, -1, 1, i64::MIN, i64::MIN, i64::MAX];
        let values = [reals.map(Value::Real).to_vec(), integers.map(Value::Integer).to_vec()];
        let columns = columns(&values);
        let back = back(&encode(&columns, OWNER).unwrap());
        for (column, own) in back.iter().zip(&columns) {
            assert!((0..8).all(|row| same(column.value(row), own.value(row))), "{column:?}");
        }
    }

    #[test]
    fn a_length_that_is_a_lie_takes_no_memory() {
        let mut column = vec![1];
        write_varint(1 << 40, &mut column);
        let mut bytes = vec![VERSION, 1, 1, column.len() as u8];
        bytes.extend(column);
        assert_eq!(
            Body::open(&mended(bytes), OWNER).unwrap().column(0),
            Err(Damaged("a length is too great"))
        );
        let mut bytes = vec![VERSION];
        write_varint(1 << 50, &mut bytes);
        assert_eq!(Body::open(&mended(bytes), OWNER).unwrap_err(), Damaged("a length is too great"));
    }

    fn value() -> impl Strategy<Value = Value> {
        prop_oneof![
            Just(Value::Null),
            any::<i64>().prop_map(Value::Integer),
            (-300_i64..300).prop_map(Value::Integer),
            any::<u64>().prop_map(|bits| Value::Real(f64::from_bits(bits))),
            any::<u32>().prop_map(|bits| Value::Real(f64::from(f32::from_bits(bits)))),
            ".{0,9}".prop_map(Value::Text),
            prop::collection::vec(any::<u8>(), 0..9).prop_map(Value::Blob),
        ]
    }

    /// Columns of one length; of one kind, or of all.
    fn tables() -> impl Strategy<Value = Vec<Vec<Value>>> {
        let one_kind = |rows| {
            prop_oneof![
                prop::collection::vec(any::<i64>().prop_map(Value::Integer), rows),
                prop::collection::vec(any::<f32>().prop_map(|value| Value::Real(value.into())), rows),
                prop::collection::vec(any::<f64>().prop_map(Value::Real), rows),
                prop::collection::vec(value(), rows),
            ]
        };
        (0_usize..40).prop_flat_map(move |rows| prop::collection::vec(one_kind(rows), 1..5))
    }

    proptest! {
        #[test]
        fn whatever_a_table_holds_comes_back(values in tables()) {
            let columns = columns(&values);
            let back = back(&encode(&columns, OWNER).unwrap());
            for (column, values) in back.iter().zip(&values) {
                for (row, value) in values.iter().enumerate() {
                    prop_assert!(same(column.value(row), ValueRef::from(value)), "{row}: {value:?}");
                }
            }
        }

        #[test]
        fn one_damaged_byte_is_seen(values in tables(), at in any::<prop::sample::Index>(), bit in 0_u8..8) {
            let mut bytes = encode(&columns(&values), OWNER).unwrap();
            let at = at.index(bytes.len());
            bytes[at] ^= 1 << bit;
            prop_assert!(Body::open(&bytes, OWNER).is_err());
        }

        #[test]
        fn whatever_stands_in_a_chunk_nothing_panics(
            values in tables(),
            at in any::<prop::sample::Index>(),
            with in prop::collection::vec(any::<u8>(), 0..20),
        ) {
            let mut bytes = encode(&columns(&values), OWNER).unwrap();
            bytes.truncate(bytes.len() - 4);
            let at = at.index(bytes.len());
            let end = bytes.len().min(at + with.len());
            bytes[at..end].copy_from_slice(&with[..end - at]);
            if let Ok(body) = Body::open(&mended(bytes), OWNER) {
                for at in 0..body.columns.len() {
                    if let Ok(column) = body.column(at) {
                        for row in 0..body.rows {
                            let _ = column.value(row);
                        }
                    }
                }
            }
        }
    }
}
