//! Reading the rows of chunks, one after another.

use super::codec::{Body, Column, Damaged};
use super::{BEFORE, Declared, HEAD, Head, Key, SENT_AT, declared_in, layout, layout_copy, owner};
use crate::history::columns::SENT;
use crate::history::group::GroupKey;
use crate::history::order::Order;
use crate::range::TimeRange;
use rusqlite::types::ValueRef;
use rusqlite::{Connection, OptionalExtension as _};
use std::ops::Range;

/// A chunk's columns that were asked for, unpacked.
pub(crate) struct Open {
    chunk: i64,
    times: Vec<i64>,
    hashes: Vec<i64>,
    columns: Vec<Option<Column>>,
}

impl Open {
    /// Unpacks a chunk's columns at the places that `places` chooses by what the message has.
    pub(super) fn read(
        connection: &Connection,
        group: GroupKey,
        head: &Head,
        mut places: impl FnMut(&[Declared]) -> Vec<Option<usize>>,
    ) -> rusqlite::Result<Self> {
        let mut find = connection.prepare_cached("SELECT body FROM _chunk WHERE chunk=?1")?;
        let bytes: Option<Vec<u8>> = find.query_row([head.chunk], |row| row.get(0)).optional()?;
        let mut unpack = |layout: Option<String>| -> Result<Self, Damaged> {
            let bytes = bytes.as_deref().ok_or(Damaged::GONE)?;
            let layout = layout.ok_or(Damaged::LAYOUT)?;
            let body = Body::open(bytes, &owner(group, &layout))?;
            let times = integers(&body.column(0)?)?;
            let hashes = integers(&body.column(1)?)?;
            let keys = || times.iter().copied().zip(hashes.iter().copied());
            // What is searched must be in order, and what the head says must be so.
            let is_sound = keys().is_sorted_by(|one, other| one < other)
                && body.rows() == head.count
                && keys().next() == Some(head.first)
                && keys().next_back() == Some(head.last);
            if !is_sound {
                return Err(Damaged::ROWS);
            }
            let places = places(&declared_in(&layout)).into_iter();
            let columns =
                places.map(|at| at.map(|at| body.column(at)).transpose()).collect::<Result<_, _>>()?;
            Ok(Self { chunk: head.chunk, times, hashes, columns })
        };
        match unpack(layout(connection, head.layout)?) {
            Ok(open) => Ok(open),
            // The list of its columns may be damaged, and not the chunk.
            Err(why) => unpack(layout_copy(connection, head.layout)?).map_err(|_| head.damaged(group, why)),
        }
    }

    pub(super) fn rows(&self) -> usize {
        self.times.len()
    }

    /// How much memory it takes, about.
    fn bytes(&self) -> usize {
        let columns: usize = self.columns.iter().flatten().map(Column::bytes).sum();
        columns + 16 * self.rows()
    }

    pub(super) fn key(&self, row: usize) -> Key {
        (self.times[row], self.hashes[row])
    }

    /// The row with a key.
    pub(super) fn find(&self, key: Key) -> Option<usize> {
        let at = self.times.partition_point(|time_us| *time_us < key.0);
        (at..self.rows()).take_while(|row| self.times[*row] == key.0).find(|row| self.hashes[*row] == key.1)
    }

    /// When a row was said (µs since 1970-01-01 UTC).
    pub(crate) fn time_us(&self, row: usize) -> i64 {
        self.times[row]
    }

    /// The value of a row in a column that was asked for.
    pub(crate) fn value(&self, row: usize, at: usize) -> ValueRef<'_> {
        self.columns.get(at).and_then(Option::as_ref).map_or(ValueRef::Null, |column| column.value(row))
    }

    /// The rows of a part of the month.
    fn within(&self, part: TimeRange) -> Range<usize> {
        let at = |time_us: i64| self.times.partition_point(|one| *one < time_us);
        at(part.from_us)..at(part.to_us)
    }
}

fn integers(column: &Column) -> Result<Vec<i64>, Damaged> {
    column.integers().map(<[i64]>::to_vec).ok_or(Damaged::KEYS)
}

/// The chunks of a group, and a row of them.
pub(crate) struct Chunks<'c> {
    connection: &'c Connection,
    group: GroupKey,
    /// Names of the columns that are asked for.
    columns: Vec<String>,
    order: Order,
    /// The part that is read, the chunk of it that is next, and the rows of the open one that are left.
    part: TimeRange,
    next: Option<Head>,
    rows: Range<usize>,
    open: Option<Open>,
}

impl<'c> Chunks<'c> {
    /// For these columns; `None` when the group has no chunk.
    pub(crate) fn new(
        connection: &'c Connection,
        group: GroupKey,
        columns: &[&str],
        order: Order,
    ) -> rusqlite::Result<Option<Self>> {
        let has_some = connection
            .prepare_cached("SELECT 1 FROM _chunk WHERE id=?1 AND src=?2 AND src_ent=?3 LIMIT 1")?
            .exists((group.id, group.src, group.src_ent))?;
        let columns = columns.iter().map(|name| (*name).to_owned()).collect();
        let part = TimeRange { from_us: 0, to_us: 0 };
        let new = Self { connection, group, columns, order, part, next: None, rows: 0..0, open: None };
        Ok(has_some.then_some(new))
    }

    /// Begins with the first row of a part of the month.
    pub(crate) fn begin(&mut self, part: TimeRange) -> rusqlite::Result<()> {
        self.part = part;
        self.next = self.first()?;
        self.rows = 0..0;
        self.settle()
    }

    /// The row that it stands at: its key, and where it is.
    pub(crate) fn row(&self) -> Option<(Key, &Open, usize)> {
        let open = self.open.as_ref().filter(|_| !self.rows.is_empty())?;
        let row = if self.order == Order::Oldest { self.rows.start } else { self.rows.end - 1 };
        Some((open.key(row), open, row))
    }

    /// Goes on to the next row.
    pub(crate) fn advance(&mut self) -> rusqlite::Result<()> {
        match self.order {
            Order::Oldest => self.rows.start += 1,
            Order::Newest => self.rows.end -= 1,
        }
        self.settle()
    }

    /// How many rows there are in a part of the month.
    pub(crate) fn count(&mut self, part: TimeRange) -> rusqlite::Result<u64> {
        let mut count = 0;
        for head in self.heads(part)? {
            let is_whole = head.first.0 >= part.from_us && head.last.0 < part.to_us;
            count += if is_whole {
                head.count
            } else {
                Open::read(self.connection, self.group, &head, |_| Vec::new())?.within(part).len()
            };
        }
        Ok(count as u64)
    }

    /// Bytes of the chunk that is unpacked.
    pub(crate) fn open_bytes(&self) -> usize {
        self.open.as_ref().map_or(0, Open::bytes)
    }

    /// Gives up the chunk that is unpacked, between two parts; it is unpacked again when needed.
    pub(crate) fn release(&mut self) {
        (self.open, self.rows) = (None, 0..0);
    }

    /// Opens the next chunk with rows when the open one has no more.
    fn settle(&mut self) -> rusqlite::Result<()> {
        while self.rows.is_empty()
            && let Some(head) = self.next.take()
        {
            let open = match self.open.take().filter(|open| open.chunk == head.chunk) {
                Some(open) => open,
                None => Open::read(self.connection, self.group, &head, |declared| {
                    self.columns.iter().map(|name| place(name, declared)).collect()
                })?,
            };
            self.rows = open.within(self.part);
            self.open = Some(open);
            self.next = self.after(&head)?;
        }
        Ok(())
    }

    /// The first chunk of the part in the order of reading. They do not overlap: of those that begin before the part, only the last
    /// can reach into it.
    fn first(&self) -> rusqlite::Result<Option<Head>> {
        let TimeRange { from_us, to_us } = self.part;
        let last_before =
            |time_us| self.head("<(?4,?5) ORDER BY first_us DESC,first_hash DESC", (time_us, i64::MIN));
        let first = match self.order {
            Order::Newest => last_before(to_us)?,
            Order::Oldest => match last_before(from_us)?.filter(|head| head.last.0 >= from_us) {
                None => self.head(">=(?4,?5) ORDER BY first_us,first_hash", (from_us, i64::MIN))?,
                reaching => reaching,
            },
        };
        Ok(first.filter(|head| self.is_within(head)))
    }

    /// The chunk of the part after another.
    fn after(&self, head: &Head) -> rusqlite::Result<Option<Head>> {
        let after = match self.order {
            Order::Oldest => ">(?4,?5) ORDER BY first_us,first_hash",
            Order::Newest => "<(?4,?5) ORDER BY first_us DESC,first_hash DESC",
        };
        Ok(self.head(after, head.first)?.filter(|head| self.is_within(head)))
    }

    fn is_within(&self, head: &Head) -> bool {
        head.first.0 < self.part.to_us && head.last.0 >= self.part.from_us
    }

    /// The first head by a condition on where it begins, and an order.
    fn head(&self, condition: &str, key: Key) -> rusqlite::Result<Option<Head>> {
        let mut find = self.connection.prepare_cached(&format!(
            "SELECT {HEAD} FROM _chunk WHERE id=?1 AND src=?2 AND src_ent=?3 AND (first_us,first_hash){condition} LIMIT 1"
        ))?;
        let GroupKey { id, src, src_ent } = self.group;
        find.query_row((id, src, src_ent, key.0, key.1), Head::read).optional()
    }

    /// The chunks that may have rows in a part of the month, the oldest first.
    fn heads(&self, part: TimeRange) -> rusqlite::Result<Vec<Head>> {
        // They do not overlap: before the last one that begins before the part, all end before it.
        let mut statement = self.connection.prepare_cached(&format!(
            "SELECT {HEAD} FROM _chunk WHERE id=?1 AND src=?2 AND src_ent=?3 AND first_us<?5 AND last_us>=?4 AND first_us>=\
             coalesce((SELECT first_us FROM _chunk WHERE id=?1 AND src=?2 AND src_ent=?3 AND first_us<?4 \
             ORDER BY first_us DESC LIMIT 1),?4) ORDER BY first_us,first_hash"
        ))?;
        let GroupKey { id, src, src_ent } = self.group;
        statement.query_map((id, src, src_ent, part.from_us, part.to_us), Head::read)?.collect()
    }
}

/// Where a column that is asked for stands in a chunk.
fn place(name: &str, declared: &[Declared]) -> Option<usize> {
    const KEY: [&str; BEFORE] = ["time_us", "hash", "received_us", "dst", "dst_ent", SENT];
    const _: () = assert!(SENT_AT == KEY.len() - 1);
    let mut names = KEY.into_iter().chain(declared.iter().map(|column| column.name.as_str()));
    names.position(|one| one.eq_ignore_ascii_case(name))
}
