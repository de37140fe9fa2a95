//! How a system was at a time: the last sample of every series at or before it.

use super::{Reader, Row, Source};
use crate::error::Result;
use crate::history::{GroupKey, MonthKey};
use crate::range::TimeRange;
use imc::Address;

/// Older samples are not looked for, µs: so three months' files are opened at most, however much there is.
const BACK_US: i64 = 31 * 24 * 3_600_000_000;

/// The last sample of a series at a time.
#[derive(Debug, Clone, PartialEq)]
pub struct Last {
    /// What the series is known by.
    pub group: GroupKey,
    /// The message's name.
    pub message: &'static str,
    /// Mean time between samples in the months that were looked at (s); `None` for fewer than two.
    pub period_s: Option<f64>,
    /// The sample, with all fields of the message's table.
    pub row: Row,
}

/// How a system was.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Snapshot {
    /// By message and entity.
    pub last: Vec<Last>,
    /// Whether there is more than was asked for.
    pub cut: bool,
}

impl Reader {
    /// The last sample of every series of a system at or before a time, within 31 days before it: one look at the
    /// key for each series and month. At most `series` of them with about `bytes` bytes of text and raw data.
    /// Messages that the catalogue lacks and samples without a believable time are left out.
    ///
    /// # Errors
    /// When the history cannot be read.
    pub fn then(&mut self, system: Address, time_us: i64, series: usize, bytes: usize) -> Result<Snapshot> {
        let range = TimeRange { from_us: time_us.saturating_sub(BACK_US), to_us: time_us.saturating_add(1) };
        let parts = self.parts(range)?;
        let is_part = |key| key != MonthKey::Undated && parts.iter().any(|(part, _)| *part == key);
        let mut then = Snapshot::default();
        let mut taken = 0;
        for (group, extent) in self.months_extents(is_part)? {
            if group.src != system.0 || extent.first_us > time_us || extent.last_us < range.from_us {
                continue;
            }
            let Some(table) = self.table_of(group) else { continue };
            if then.last.len() >= series || taken > bytes {
                then.cut = true;
                break;
            }
            let message = table.desc.abbrev;
            let fields: Vec<&str> = table.columns.iter().map(|column| column.name).collect();
            let source = Source { system, entity: group.src_ent, message: message.to_owned() };
            let Some(row) = self.last_row(&source, &fields, range)? else { continue };
            taken += row.bytes();
            let period_s = (extent.count > 1)
                .then(|| (extent.last_us - extent.first_us) as f64 / 1e6 / (extent.count - 1) as f64);
            then.last.push(Last { group, message, period_s, row });
        }
        Ok(then)
    }
}
