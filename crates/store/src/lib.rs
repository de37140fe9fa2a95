//! Every packet on disk, and everything that is asked of them.
mod archive;
mod error;
mod fingerprint;
mod gaps;
mod history;
mod lock;
mod packet;
mod store;

pub use archive::{Archived, Arrival, DayKey, DayReader};
pub use error::{Result, StoreError};
pub use gaps::{Gap, GapKind};
pub use history::{Column, ColumnKind, Extent, GroupKey, MonthKey, Table};
pub use packet::{Accepted, Committed, Door, LinkSeq, Outcome, Repairs};
pub use store::Store;
