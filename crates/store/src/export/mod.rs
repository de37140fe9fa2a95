//! Out of the store: tables as CSV from the history, packets as LSF from the archive.

mod cell;
mod csv;
mod detections;
mod lsf;
mod number;
mod plan;
mod raw;
mod size;

pub use cell::text as csv_text;
pub use csv::{Exported, export_csv};
pub use detections::{DETECTION_COLUMNS, export_detections};
pub use lsf::export_lsf;
pub use plan::{Angles, CsvOptions, Selection, Shape, describe_csv};
pub use size::measure_csv;
