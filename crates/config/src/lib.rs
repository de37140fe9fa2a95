//! Typed configuration of the vessel's agent, read from DUNE's `.ini` files.
//!
//! It knows no other crate of Lutra: no IMC, no units, no device. What a parameter does is left to its user.
//!
//! Reading has three steps. [`Ini`] is what a tree of files says: sections of texts, each with the line it
//! comes from and everything it overrides. The [`schema`] says what Lutra understands: for every section the
//! parameters with type, unit, range and default. [`Config`] is both together for the selected profiles:
//! typed values and a [`Report`] of everything that is wrong, doubtful or without effect.
//!
//! ```
//! use config::{Config, InMemory, schema::path::ilos};
//!
//! let files = InMemory::new().with("otter.ini", "[Control.Path.ILOS]\nEnabled = Always\n");
//! let config = Config::load(&files, "otter.ini".as_ref(), &["Simulation"]);
//! let controller = config.running(&ilos::ILOS).next().expect("it is enabled above");
//! let lookahead_m: f64 = controller.get(&ilos::LOOKAHEAD);
//! assert_eq!(lookahead_m, 10.0);
//! assert!(config.report().has_errors(), "the vessel has no name and the task no label");
//! ```
//!
//! Invariants: reading never panics, never stops at the first mistake and keeps a bounded amount of memory
//! whatever the files hold. Angles are in degrees as in the files; programs convert them where they use them.
//!
//! Source of the dialect: DUNE's `src/DUNE/Parsers/Config.cpp`.

mod check;
mod config;
mod edit;
mod ini;
mod line;
mod load;
mod overlay;
mod parser;
mod print;
mod problem;
mod profile;
mod read;
mod render;
mod resolve;
mod saved;
pub mod schema;
mod section;
mod source;
mod spec;
mod typed;
mod value;

pub use config::Config;
pub use edit::MAX_VALUE_BYTES;
pub use ini::{Action, Change, Ini, IniSection, Setting, Unwritable};
pub use line::MAX_LINE_BYTES;
pub use parser::{MAX_DEPTH, MAX_FILES, MAX_LINES, MAX_TOTAL_BYTES};
pub use problem::{Counts, MAX_PROBLEMS_OF_A_KIND, Place, Problem, ProblemKind, Report, Severity};
pub use profile::{ALWAYS, BUILT_IN, Enabled, NEVER, Profiles};
pub use render::{Vessel, documented_ini};
pub use saved::{Saved, write_atomically};
pub use section::{FromValue, Parameter, Section};
pub use source::{Disk, FileSource, InMemory, MAX_FILE_BYTES};
pub use spec::{Form, Kind, Length, Param, ParamSpec, SectionSpec, Unit};
pub use value::{Integer, Value, ValueError, parse_bool, parse_float, parse_int, split_list, unescape};
