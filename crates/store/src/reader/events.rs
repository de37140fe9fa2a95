//! Messages that each matter, in order of time: what the log book says. Detections: [`super::detections`].

use super::page::Pager;
use super::samples::read_row;
use super::{Cell, Order, Page, Paged, Reader, Row};
use crate::error::Result;
use crate::history::GroupKey;
use crate::history::rows::Rows;
use crate::range::TimeRange;
use imc::Address;
use std::cmp::Ordering;
use std::ops::ControlFlow;
use units::UtcTime;

const LOG_FIELDS: [&str; 4] = ["type", "htime", "context", "text"];

/// An entry of a vessel's log book.
#[derive(Debug, Clone, PartialEq)]
pub struct LogEntry {
    /// The vessel.
    pub system: Address,
    /// The entity that wrote it.
    pub entity: u8,
    /// When it was sent.
    pub sent: UtcTime,
    /// When it was written.
    pub written: Option<UtcTime>,
    /// How serious it is, by IMC's enumeration: 0 information, 1 warning, 2 error, 3 critical, 4 debug.
    pub kind: i64,
    /// The name of that.
    pub kind_name: Option<String>,
    /// The part of the vessel's program.
    pub context: String,
    /// What it says.
    pub text: String,
}

impl Reader {
    /// A page of the log books' entries in a range, by when they were sent; of one system or of all.
    ///
    /// # Errors
    /// When the history cannot be read.
    pub fn log_book(
        &mut self,
        system: Option<Address>,
        range: TimeRange,
        order: Order,
        page: Page,
    ) -> Result<Paged<LogEntry>> {
        let systems = system.as_ref().map(std::slice::from_ref);
        self.events(&Question { systems, range, order }, page, |_: &LogEntry| true)
    }

    /// A page of what messages of some kinds tell, of all entities: by time, and within a time as [`EventRow`] has it.
    pub(super) fn events<T: EventRow>(
        &mut self,
        &Question { systems, range, order }: &Question<'_>,
        page: Page,
        wanted: impl Fn(&T) -> bool,
    ) -> Result<Paged<T>> {
        let mut kinds = Vec::with_capacity(T::MESSAGES.len());
        for (message, fields) in T::MESSAGES {
            kinds.push((self.table(message)?.desc.id, *fields));
        }
        let mine = |key: &GroupKey| {
            systems.is_none_or(|systems| systems.contains(&Address(key.src)))
                && kinds.iter().any(|(id, _)| *id == key.id)
        };
        let groups: Vec<GroupKey> = self.extents()?.into_keys().filter(mine).collect();
        let mut answer =
            Answer { order, wanted, pager: Pager::new(page), found: Vec::new(), moment: None, read: 0 };
        let mut parts = self.parts(range)?;
        if order == Order::Newest {
            parts.reverse();
        }
        for (key, part) in parts {
            let mut read = || -> rusqlite::Result<ControlFlow<()>> {
                let _moment = self.moment(key)?;
                let mut questions = Vec::new();
                for group in &groups {
                    let fields =
                        kinds.iter().find(|(id, _)| *id == group.id).map_or(&[][..], |(_, fields)| *fields);
                    if let Some(question) = self.question(key, *group, fields, order)? {
                        questions.push((*group, vec![None; fields.len()], question));
                    }
                }
                let mut heads = Vec::with_capacity(questions.len());
                for (group, reals, question) in &mut questions {
                    heads.push(
                        Head { group: *group, reals, rows: question.rows(part)?, ahead: None }.advanced()?,
                    );
                }
                while let Some(head) = next_of(&mut heads, order) {
                    let group = head.group;
                    let Some(row) = head.take()? else { break };
                    let time_us = row.time.micros();
                    if answer.read(time_us)?.is_break() {
                        return Ok(ControlFlow::Break(()));
                    }
                    if let Some(item) = T::read(group, row)
                        && answer.put(time_us, item)?.is_break()
                    {
                        return Ok(ControlFlow::Break(()));
                    }
                }
                answer.end_moment()
            };
            if self.named(key, read())?.is_break() {
                break;
            }
        }
        Ok(answer.pager.end(answer.found))
    }
}

/// Something that messages tell.
pub(super) trait EventRow: Sized {
    /// Messages by name, with the fields that are read of each, in this order.
    const MESSAGES: &'static [(&'static str, &'static [&'static str])];
    /// How many of one time are looked at together.
    const TOGETHER: usize;

    /// What a message tells; `None` when it is about something else.
    fn read(group: GroupKey, row: Row) -> Option<Self>;

    /// Of what messages of one time tell, one for each thing, in an order that does not depend on theirs.
    fn fused(moment: Vec<Self>) -> Vec<Self>;

    /// Bytes of its texts and raw data.
    fn bytes(&self) -> usize;
}

/// Messages that are read for one page, so that a question for what is seldom does not read a season at once: the page ends
/// early then, and says where to go on.
const READ_MOST: usize = 200_000;

/// Whose, when, and from which end.
pub(super) struct Question<'q> {
    /// All where absent.
    pub(super) systems: Option<&'q [Address]>,
    pub(super) range: TimeRange,
    pub(super) order: Order,
}

/// A page that is being filled.
struct Answer<T, W> {
    order: Order,
    wanted: W,
    pager: Pager,
    found: Vec<T>,
    /// What messages of one time told so far (µs).
    moment: Option<(i64, Vec<T>)>,
    /// Messages that were read, wanted or not.
    read: usize,
}

impl<T: EventRow, W: Fn(&T) -> bool> Answer<T, W> {
    /// Counts a message that is read; whether the page goes on to it.
    fn read(&mut self, time_us: i64) -> rusqlite::Result<ControlFlow<()>> {
        self.read += 1;
        if self.read <= READ_MOST || self.moment.as_ref().is_some_and(|(at, _)| *at == time_us) {
            return Ok(ControlFlow::Continue(()));
        }
        if self.end_moment()?.is_continue() {
            self.pager.stop(time_us);
        }
        Ok(ControlFlow::Break(()))
    }

    /// Takes the next; whether the page goes on.
    fn put(&mut self, time_us: i64, item: T) -> rusqlite::Result<ControlFlow<()>> {
        let goes_on = |(at, items): &(i64, Vec<T>)| *at == time_us && items.len() < T::TOGETHER;
        if let Some((_, items)) = self.moment.as_mut().filter(|moment| goes_on(moment)) {
            items.push(item);
            return Ok(ControlFlow::Continue(()));
        }
        let before = self.end_moment()?;
        self.moment = Some((time_us, vec![item]));
        Ok(before)
    }

    /// Nothing more comes of the time that was read last.
    fn end_moment(&mut self) -> rusqlite::Result<ControlFlow<()>> {
        let Some((time_us, items)) = self.moment.take() else { return Ok(ControlFlow::Continue(())) };
        let mut items = T::fused(items);
        items.retain(&self.wanted);
        if self.order == Order::Newest {
            items.reverse();
        }
        for item in items {
            let step = self.pager.step(time_us, || {
                let bytes = item.bytes();
                self.found.push(item);
                Ok(bytes)
            })?;
            if step.is_break() {
                return Ok(step);
            }
        }
        Ok(ControlFlow::Continue(()))
    }
}

impl EventRow for LogEntry {
    const MESSAGES: &'static [(&'static str, &'static [&'static str])] = &[("LogBookEntry", &LOG_FIELDS)];
    // Each stands for itself, in the order in which the history keeps them.
    const TOGETHER: usize = 1;

    fn read(group: GroupKey, row: Row) -> Option<Self> {
        let kinds = imc::catalogue::by_abbrev("LogBookEntry").and_then(|desc| desc.field("type"));
        let kind = row.cells[0].as_f64().unwrap_or_default() as i64;
        let text = |at: usize| match &row.cells[at] {
            Cell::Text(text) => text.clone(),
            Cell::Raw(bytes) => String::from_utf8_lossy(bytes).into_owned(),
            Cell::Nothing | Cell::Integer(_) | Cell::Real(_) => String::new(),
        };
        Some(Self {
            system: Address(group.src),
            entity: group.src_ent,
            sent: row.time,
            written: row.cells[1].as_f64().and_then(UtcTime::from_seconds),
            kind,
            kind_name: kinds.and_then(|field| field.label(kind)),
            context: text(2),
            text: text(3),
        })
    }

    fn fused(moment: Vec<Self>) -> Vec<Self> {
        moment
    }

    fn bytes(&self) -> usize {
        self.context.len() + self.text.len()
    }
}

/// One entity's messages, the next of them read.
struct Head<'s, 'c> {
    group: GroupKey,
    /// A NaN tells nothing here: none of the fields is looked at as a real.
    reals: &'s [Option<usize>],
    rows: Rows<'s, 'c>,
    ahead: Option<Row>,
}

/// The entity whose next message is the earliest of all, or the latest.
fn next_of<'h, 's, 'c>(heads: &'h mut [Head<'s, 'c>], order: Order) -> Option<&'h mut Head<'s, 'c>> {
    let by = |one: &Head<'_, '_>, other: &Head<'_, '_>| -> Ordering {
        let key = |head: &Head<'_, '_>| (head.ahead.as_ref().map(|row| row.time), head.group);
        match order {
            Order::Oldest => key(one).cmp(&key(other)),
            Order::Newest => key(other).cmp(&key(one)),
        }
    };
    heads.iter_mut().filter(|head| head.ahead.is_some()).min_by(|one, other| by(one, other))
}

impl Head<'_, '_> {
    fn advanced(mut self) -> rusqlite::Result<Self> {
        self.take()?;
        Ok(self)
    }

    /// The message that was read; reads the next.
    fn take(&mut self) -> rusqlite::Result<Option<Row>> {
        let next = self.rows.next()?.map(|row| read_row(row, self.reals)).transpose()?;
        Ok(std::mem::replace(&mut self.ahead, next))
    }
}

#[cfg(test)]
mod tests {
    use super::super::Next;
    use super::*;

    #[test]
    fn a_page_ends_where_much_was_read_for_nothing() {
        let (found, moment) = (Vec::new(), None);
        let pager = Pager::new(Page::first(10));
        let mut answer =
            Answer { order: Order::Oldest, wanted: |_: &LogEntry| false, pager, found, moment, read: 0 };
        let mut time_us = 0;
        while answer.read(time_us).unwrap().is_continue() {
            let entry = LogEntry {
                system: Address(1),
                entity: 1,
                sent: UtcTime::from_micros(time_us),
                written: None,
                kind: 0,
                kind_name: None,
                context: String::new(),
                text: String::new(),
            };
            assert!(answer.put(time_us, entry).unwrap().is_continue());
            time_us += 1;
        }
        assert_eq!(usize::try_from(time_us).unwrap(), READ_MOST);
        assert_eq!(answer.pager.end(answer.found).next, Some(Next { time_us, skip: 0 }));
    }
}
