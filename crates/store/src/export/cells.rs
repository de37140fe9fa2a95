//! The output of tables, and the cells that all of them have.

use super::options::CsvOptions;
use crate::error::{Result, StoreError};
use crate::range::NO_TIME_US;
use std::io::Write;
use tables::{FIXED, Format, IsoTime};

/// Bytes that are passed on at once.
pub(super) const CHUNK_BYTES: usize = 1 << 16;

/// The result of an export.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Exported {
    /// Rows of a table, or packets of a log.
    pub rows: u64,
    /// Bytes.
    pub bytes: u64,
}

/// Where a table goes, and how much of it there was.
pub(super) struct Writer<'o> {
    pub(super) out: &'o mut dyn Write,
    pub(super) buffer: Vec<u8>,
    pub(super) exported: Exported,
}

impl<'o> Writer<'o> {
    pub(super) fn new(out: &'o mut dyn Write) -> Self {
        Self { out, buffer: Vec::with_capacity(2 * CHUNK_BYTES), exported: Exported::default() }
    }

    /// Hands everything on.
    pub(super) fn flush(&mut self) -> Result<()> {
        self.out.write_all(&self.buffer).and_then(|()| self.out.flush()).map_err(unwritable)?;
        self.exported.bytes += self.buffer.len() as u64;
        self.buffer.clear();
        Ok(())
    }

    /// Hands everything on once it is much.
    pub(super) fn flush_full(&mut self) -> Result<()> {
        if self.buffer.len() >= CHUNK_BYTES { self.flush() } else { Ok(()) }
    }
}

pub(super) fn unwritable(source: std::io::Error) -> StoreError {
    StoreError::Io { path: "the export".into(), source }
}

/// The names of the columns that every table begins with.
pub(super) fn header_start(out: &mut Vec<u8>, options: CsvOptions) {
    let received = options.received.then_some(["received", "received_unix_s"]);
    for (at, name) in FIXED.iter().map(|(name, ..)| *name).chain(received.into_iter().flatten()).enumerate() {
        if at > 0 {
            options.format().next(out);
        }
        out.extend_from_slice(name.as_bytes());
    }
}

/// Writes the columns of an arrival; empty for rows of a history that did not know it.
pub(super) fn arrival(out: &mut Vec<u8>, iso: &mut IsoTime, received_us: Option<i64>, format: Format) {
    format.next(out);
    tables::stamp(out, iso, received_us, format.dialect);
}

/// A time of the history, unless it is [`NO_TIME_US`].
pub(super) fn believed(time_us: i64) -> Option<i64> {
    (time_us != NO_TIME_US).then_some(time_us)
}

/// Writes the destination of a message; empty where the history does not have it.
pub(super) fn receiver(out: &mut Vec<u8>, dst: Option<u16>, dst_ent: Option<u8>, format: Format) {
    format.next(out);
    if let Some(dst) = dst {
        out.extend_from_slice(format!("{dst:#06x}").as_bytes());
    }
    format.next(out);
    if let Some(dst_ent) = dst_ent {
        tables::integer(out, dst_ent.into());
    }
}
