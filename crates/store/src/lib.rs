//! Every packet on disk, and everything that is asked of them.
mod archive;
mod backup;
mod doctor;
mod error;
mod export;
#[cfg(test)]
mod faults;
mod fingerprint;
mod gaps;
mod history;
mod import;
mod lock;
mod packet;
mod range;
mod reader;
mod reindex;
mod retention;
mod store;

pub use archive::{Archived, Arrival, DayKey, DayReader};
pub use backup::{BackedUp, backup};
pub use doctor::{Check, Health, doctor};
pub use error::{Result, StoreError};
pub use export::{Angles, CsvOptions, Exported, Selection, Shape, describe_csv, export_csv, export_lsf};
pub use gaps::{Gap, GapKind};
pub use history::{Column, ColumnKind, Extent, GroupKey, MonthKey, Table};
pub use import::{ImportProgress, Imported};
pub use packet::{Accepted, Committed, Door, LinkSeq, Outcome, Repairs};
pub use range::TimeRange;
pub use reader::{
    Bucket, Buckets, Cell, Detection, EntityName, LogEntry, Reader, Row, Samples, Series, Source, System, Track,
    TrackPoint,
};
pub use reindex::{Reindexed, reindex};
pub use retention::{Removal, Retention, plan_retention};
pub use store::Store;
