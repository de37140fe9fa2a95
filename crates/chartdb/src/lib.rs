//! Charts on disk: one GeoPackage for each chart set, and the depth index beside it.
//!
//! It reads and writes files and SQLite databases; what they mean it leaves to `charts` and, of land masks, to
//! `geofile`. It knows nothing of vessels, plans or HTTP.
//!
//! - [`import()`] brings S-57 cells with their updates, soundings, land masks and lakes into a set and gives an
//!   [`ImportReport`]; [`remove`] takes them out; [`put_no_go_areas`] brings in what people drew. All change all or nothing.
//! - [`ChartDb`] reads a set: what it holds ([`Chart`]), and every feature as it was imported. [`Snapshot`] reads it over
//!   hours, and notices when it changed; [`Overviews`] keeps what a server made of its charts.
//! - [`load_index`] gives the [`charts::depth_index::DepthIndex`], which is made from the database alone. [`export`]
//!   writes grids and contours for other programs.
//!
//! On disk, for a set `chart.gpkg`:
//! - `chart.gpkg`: an OGC GeoPackage 1.3, which QGIS opens directly (its tables: `schema.rs`);
//! - `chart.lutra-index`: the depth index under the digest of the set, a piece for each chart; a change makes the pieces
//!   of the charts that it touches, and takes the others over;
//! - `chart.lutra-changes`: of a large index, the pieces that changed since that file was written;
//! - `chart.gpkg.part`: the charts of a change under way, or what an import that did not end leaves for the next of the
//!   same charts;
//! - `chart.gpkg.lock`: locked by the one process that changes the set.

mod areas;
mod blob;
mod cells;
mod contents;
mod error;
pub mod export;
mod files;
mod import;
mod index_file;
mod lakes;
mod locate;
mod merge;
mod overviews;
mod part_file;
mod read;
mod report;
mod row;
mod schema;
mod snapshot;
mod stage;
mod supplements;
mod write;

pub use areas::{NO_GO_AREAS, NoGoArea, no_go_digest, no_go_digest_of, put_no_go_areas};
pub use error::{ChartDbError, Result};
pub use import::{import, remove};
pub use index_file::{LoadedIndex, files, index_path, load_index, remake_index};
pub use overviews::Overviews;
pub use read::{Chart, ChartDb, LogEntry, copy};
pub use report::{ImportFailure, ImportOptions, ImportProgress, ImportReport, Imported, Outcome};
pub use snapshot::Snapshot;
