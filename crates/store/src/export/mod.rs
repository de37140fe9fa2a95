//! Out of the store: tables as CSV from the history, packets as LSF from the archive.

mod csv;
mod detections;
mod lsf;
mod plan;
mod raw;
mod select;
mod size;
mod version;

pub use csv::{Exported, export_csv};
pub use detections::{acoustic_version, each_detection, months};
pub use lsf::export_lsf;
pub use plan::{Angles, CsvOptions, Shape, describe_csv};
pub use raw::unexplained;
pub use select::{RAW, Selection, system};
pub use size::measure_csv;
pub use version::{log_version, table_version};
