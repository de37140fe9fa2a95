//! Out of the store: tables as CSV and Parquet from the history, packets as LSF from the archive.

mod cells;
mod columns;
mod csv;
mod describe;
mod detections;
mod lsf;
mod options;
mod parquet;
mod plan;
mod raw;
mod rows;
mod select;
mod size;
mod version;

pub use cells::Exported;
pub use csv::export_csv;
pub use describe::describe_csv;
pub use detections::{acoustic_version, each_detection, months};
pub use lsf::export_lsf;
pub use options::{Angles, CsvOptions, Shape};
pub use parquet::{check_parquet, export_parquet};
pub use raw::unexplained;
pub use select::{RAW, Selection, system};
pub use size::measure_csv;
pub use version::{log_version, table_version};
