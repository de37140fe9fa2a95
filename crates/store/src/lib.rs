//! Storage of all packets on disk, and queries to them.
//!
//! - [`Store`] is the one writer of a data folder. It [accepts](Store::accept) packets, and a
//!   [commit](Store::commit) puts them into the *archive*: a log per system and UTC day of arrival, byte for byte,
//!   synced before anything is acknowledged. The *history* follows: SQLite, a file per month of the samples' own
//!   time, one wide table per message, with roll-ups. It can be made again from the archive at any time.
//! - [`Reader`] answers queries to the history, with or without a writer beside it: systems, series, samples,
//!   [`Buckets`] for plots of any range, tracks, detections, log books, gaps.
//! - [`export_csv`], [`export_parquet`] and [`export_lsf`] export data; [`Store::import`] imports logs.
//! - [`reindex`], [`Store::retain`], [`plan_unattended`], [`plan_packing`], [`backup_files`] and [`doctor()`] maintain it. A fault of the
//!   history stops nothing: [`Store::index`] makes it again from the archive ([`Store::behind`]), slice by slice.
//!
//! ```
//! use store::{Accepted, Transport, Reader, Source, Store, TimeRange};
//! use units::UtcTime;
//!
//! let folder = tempfile::tempdir()?;
//! let mut store = Store::open(folder.path())?;
//! let header = imc::Header { timestamp: 1.8e9, src: imc::Address(0x2810), src_ent: 5, ..imc::Header::default() };
//! let mut packet = Vec::new();
//! imc::encode_into(&mut packet, &header, &imc::messages::Temperature { value: 8.5 })?;
//! let received = UtcTime::from_micros(1_800_000_000_500_000);
//! store.accept(&Accepted { packet: &packet, received, transport: Transport::Tcp, link: None })?;
//! store.commit()?;
//!
//! let source = Source { system: header.src, entity: 5, message: "Temperature".to_owned() };
//! let samples = Reader::open(folder.path())?.samples(&source, &["value"], TimeRange::ALL, 100)?;
//! assert_eq!((samples.time_us[0], samples.values[0][0]), (1_800_000_000_000_000, 8.5));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # On disk
//! ```text
//! DATA/lock                               held by the writer
//! DATA/archive/0x2810/20261121/Data.lsf   packets as they came; opens in Neptus MRA
//!                              IMC.xml.gz the message definitions
//!                              Arrivals.idx when and how each came, and its number in a record lane
//!                              Data.lsf.zst, Arrivals.zst: both, compressed, some days later
//! DATA/archive/0x2810/20261121-2/         what still came for a day that was compressed already
//! DATA/archive/packing/                   files that are being compressed
//! DATA/archive/format.json                the format of these files
//! DATA/archive/gaps.jsonl                 gaps that vessels declared
//!              shortened.jsonl            days that held more once; reported until removed
//! DATA/history/2026-11.sqlite             samples of that month, roll-ups, series
//!                                      compressed, if it is over and that is wanted
//!              packing.sqlite          a month that is being compressed
//!              undated.sqlite             samples whose stated time is before 2000 or after 2099, or none
//!              catalogue.sqlite           systems, entities, what fields and numbers mean, progress, months
//! DATA/history.aside/                     files of the history that were damaged; nothing reads them
//! ```
//!
//! # Invariants
//! 1. What a commit has reported as durable survives `kill -9` and power loss.
//! 2. A message is in the history once, however often and through whichever transports it came: the key is message,
//!    system, entity, stated time and a fingerprint of the payload. The earliest arrival
//!    counts, in whatever order the archive is read.
//! 3. Everything in the history is a function of the archive.
//! 4. Nothing is lost silently: what cannot be read as its id says, and ids that are not known, are kept raw.
//!
//! It knows IMC and the disk, and nothing of people, networks or live state. Time comes with the packets.

mod archive;
mod aside;
mod backup;
mod doctor;
mod error;
mod export;
#[cfg(test)]
mod faults;
mod fingerprint;
mod follow;
mod gaps;
mod history;
mod import;
mod layout;
mod lock;
mod months;
mod opening;
mod overdue;
mod packet;
mod packing;
#[cfg(test)]
mod packing_tests;
mod range;
mod reader;
mod reindex;
mod retention;
mod store;
mod tail;
mod unattended;
mod usage;

pub use archive::{Archived, Arrival, DayKey, DayReader, Packed};
pub use backup::{BackupFile, Changes, Covered, backup_files, copy_database, covered, is_packed, other_form};
pub use doctor::{Check, Health, doctor};
pub use error::{Result, StoreError};
pub use export::{
    Angles, CsvOptions, Exported, RAW, Selection, Shape, acoustic_version, check_parquet, describe_csv,
    each_detection, export_csv, export_lsf, export_parquet, log_version, measure_csv, months, system,
    table_version, unexplained,
};
pub use gaps::{Gap, GapKind, Numbers};
pub use history::{Column, ColumnKind, Extent, GroupKey, MonthKey, Table, row_key};
pub use import::{Beginning, ImportProgress, Imported, LogImport, beginning};
pub use layout::free_bytes;
pub use link::{LinkSeq, Transport};
pub use months::{
    Adopted, CompressedMonth, MonthStep, PackableMonth, PackedMonth, Readiness, Replaced, plan_months,
};
pub use overdue::{check_compression, check_month_compression};
pub use packet::{Accepted, Committed, Outcome, Repairs};
pub use packing::{PackStep, Packable, PackedDay, Packing, plan_packing};
pub use range::{NO_TIME_US, TimeRange};
pub use reader::{
    Acoustic, Bucket, Buckets, Cell, DetectionsWanted, EntityName, Last, LogEntry, Next, Order, Page, Paged,
    Reader, RecordedDay, Row, Samples, Series, Snapshot, Source, System, Track, TrackPoint,
};
pub use reindex::{Reindexed, reindex};
pub use retention::{Removal, Retention, plan_retention};
pub use store::Store;
pub use tail::{Marks, Place, Tail};
pub use unattended::{DAYS_A_MONTH, Keeping, Share, Unattended, plan_unattended};
pub use usage::{Archives, Usage, usage};

/// Refuses a data folder whose archive a later version wrote, whose files this one would cut off as damaged. Writes nothing.
///
/// # Errors
/// [`StoreError::NewerArchive`], or the folder cannot be read.
pub fn refuse_newer(data: &std::path::Path) -> Result<()> {
    archive::format::refuse_newer(&data.join(layout::ARCHIVE))
}
