//! Messages that each matter: tags that were heard, and what the log book says.

use super::page::Pager;
use super::samples::read_row;
use super::{Cell, Order, Page, Paged, Reader, Row, has_group, select_list};
use crate::error::Result;
use crate::history::GroupKey;
use crate::range::TimeRange;
use imc::Address;
use rusqlite::{Connection, Rows, Statement};
use std::cmp::Ordering;
use std::ops::ControlFlow;
use units::UtcTime;

const DETECTION_FIELDS: [&str; 11] = [
    "serial_no",
    "unix_timestamp",
    "millis",
    "trans_protocol",
    "trans_id",
    "trans_data",
    "SNR",
    "trans_freq",
    "recv_mem_addr",
    "lat",
    "lon",
];
const LOG_FIELDS: [&str; 4] = ["type", "htime", "context", "text"];

/// A tag that a receiver heard.
#[derive(Debug, Clone, PartialEq)]
pub struct Detection {
    /// The vessel that carried the receiver.
    pub system: Address,
    /// The entity that reported it.
    pub entity: u8,
    /// When the vessel reported it.
    pub reported: UtcTime,
    /// When the receiver heard it, by the receiver's clock, to the millisecond.
    pub heard: UtcTime,
    /// When it first came ashore.
    pub received: UtcTime,
    /// Serial number of the receiver.
    pub serial_no: i64,
    /// Number of the protocol, by IMC's enumeration.
    pub protocol: i64,
    /// Name of the protocol, such as `R64K`.
    pub protocol_name: Option<String>,
    /// The tag's number.
    pub tag_id: i64,
    /// The tag's measurement as it was sent.
    pub data: i64,
    /// Signal to noise ratio (dB).
    pub snr_db: i64,
    /// Frequency (kHz).
    pub frequency_khz: i64,
    /// Place in the receiver's memory.
    pub memory_address: i64,
    /// Where the vessel was (degrees); `None` for messages of 2019, which have no position.
    pub place_deg: Option<(f64, f64)>,
}

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
    /// A page of the tags heard in a range, by when they were reported; of one system or of all.
    ///
    /// # Errors
    /// When the history cannot be read.
    pub fn detections(
        &mut self,
        system: Option<Address>,
        range: TimeRange,
        order: Order,
        page: Page,
    ) -> Result<Paged<Detection>> {
        let protocols = imc::catalogue::by_abbrev("TBRFishTag").and_then(|desc| desc.field("trans_protocol"));
        let detection = |group: GroupKey, row: Row| {
            let integer = |at: usize| match row.cells[at] {
                Cell::Integer(value) => value,
                _ => 0,
            };
            let degrees = |at: usize| row.cells[at].as_f64().map(f64::to_degrees);
            Detection {
                system: Address(group.src),
                entity: group.src_ent,
                reported: row.time,
                heard: UtcTime::from_micros(integer(1) * 1_000_000 + integer(2) * 1_000),
                received: row.received,
                serial_no: integer(0),
                protocol: integer(3),
                protocol_name: protocols.and_then(|field| field.label(integer(3))),
                tag_id: integer(4),
                data: integer(5),
                snr_db: integer(6),
                frequency_khz: integer(7),
                memory_address: integer(8),
                place_deg: degrees(9).zip(degrees(10)),
            }
        };
        let question = Question { message: "TBRFishTag", fields: &DETECTION_FIELDS, system, range, order };
        self.events(&question, page, detection)
    }

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
        let kinds = imc::catalogue::by_abbrev("LogBookEntry").and_then(|desc| desc.field("type"));
        let entry = |group: GroupKey, row: Row| {
            let kind = row.cells[0].as_f64().unwrap_or_default() as i64;
            let text = |at: usize| match &row.cells[at] {
                Cell::Text(text) => text.clone(),
                Cell::Raw(bytes) => String::from_utf8_lossy(bytes).into_owned(),
                Cell::Nothing | Cell::Integer(_) | Cell::Real(_) => String::new(),
            };
            LogEntry {
                system: Address(group.src),
                entity: group.src_ent,
                sent: row.time,
                written: row.cells[1].as_f64().and_then(UtcTime::from_seconds),
                kind,
                kind_name: kinds.and_then(|field| field.label(kind)),
                context: text(2),
                text: text(3),
            }
        };
        let question = Question { message: "LogBookEntry", fields: &LOG_FIELDS, system, range, order };
        self.events(&question, page, entry)
    }

    /// A page of the messages of a kind from all entities, by time, system and entity.
    fn events<T>(
        &mut self,
        &Question { message, fields, system, range, order }: &Question<'_>,
        page: Page,
        make: impl Fn(GroupKey, Row) -> T,
    ) -> Result<Paged<T>> {
        let id = self.table(message)?.desc.id;
        let wanted = |src: u16| system.is_none_or(|system| system.0 == src);
        let groups: Vec<GroupKey> =
            self.extents()?.into_keys().filter(|key| key.id == id && wanted(key.src)).collect();
        let mut found = Vec::new();
        let mut pager = Pager::new(page);
        let mut parts = self.parts(range)?;
        let mut down = "";
        if order == Order::Newest {
            parts.reverse();
            down = " DESC";
        }
        for (key, part) in parts {
            let (connection, table) = (self.month(key)?, self.table(message)?);
            let mut read = || -> rusqlite::Result<ControlFlow<()>> {
                let sql = format!(
                    "SELECT time_us,received_us{} FROM \"{}\" WHERE src=?1 AND src_ent=?2 AND time_us>=?3 \
                     AND time_us<?4 ORDER BY time_us{down},hash{down}",
                    select_list(connection, table, fields)?,
                    table.desc.abbrev
                );
                let mut statements = prepare(connection, &groups, &sql)?;
                let mut heads = Vec::with_capacity(statements.len());
                for (group, statement) in &mut statements {
                    let rows = statement.query((group.src, group.src_ent, part.from_us, part.to_us))?;
                    heads.push(Head { group: *group, rows, ahead: None }.advanced(fields.len())?);
                }
                while let Some(head) = next_of(&mut heads, order) {
                    let Some(row) = head.take(fields.len())? else { break };
                    let step = pager.step(row.time.micros(), || {
                        let bytes = row.bytes();
                        found.push(make(head.group, row));
                        Ok(bytes)
                    });
                    if step?.is_break() {
                        return Ok(ControlFlow::Break(()));
                    }
                }
                Ok(ControlFlow::Continue(()))
            };
            if self.named(key, read())?.is_break() {
                break;
            }
        }
        Ok(pager.end(found))
    }
}

/// Which messages, and from which end.
struct Question<'q> {
    message: &'q str,
    fields: &'q [&'q str],
    system: Option<Address>,
    range: TimeRange,
    order: Order,
}

/// A question for each group that the month has.
fn prepare<'c>(
    connection: &'c Connection,
    groups: &[GroupKey],
    sql: &str,
) -> rusqlite::Result<Vec<(GroupKey, Statement<'c>)>> {
    let mut statements = Vec::new();
    for group in groups {
        if has_group(connection, *group)? {
            statements.push((*group, connection.prepare(sql)?));
        }
    }
    Ok(statements)
}

/// One entity's messages, the next of them read.
struct Head<'s> {
    group: GroupKey,
    rows: Rows<'s>,
    ahead: Option<Row>,
}

/// The entity whose next message is the earliest of all, or the latest.
fn next_of<'h, 's>(heads: &'h mut [Head<'s>], order: Order) -> Option<&'h mut Head<'s>> {
    let by = |one: &Head<'_>, other: &Head<'_>| -> Ordering {
        let key = |head: &Head<'_>| (head.ahead.as_ref().map(|row| row.time), head.group);
        match order {
            Order::Oldest => key(one).cmp(&key(other)),
            Order::Newest => key(other).cmp(&key(one)),
        }
    };
    heads.iter_mut().filter(|head| head.ahead.is_some()).min_by(|one, other| by(one, other))
}

impl Head<'_> {
    fn advanced(mut self, fields: usize) -> rusqlite::Result<Self> {
        self.take(fields)?;
        Ok(self)
    }

    /// The message that was read; reads the next.
    fn take(&mut self, fields: usize) -> rusqlite::Result<Option<Row>> {
        let next = self.rows.next()?.map(|row| read_row(row, fields)).transpose()?;
        Ok(std::mem::replace(&mut self.ahead, next))
    }
}
