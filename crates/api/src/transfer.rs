//! Taking data out and bringing it in: exports and imports.

use crate::{Said, Wording};
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

/// What to export as CSV, and how it is written. Lists are separated by commas.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct ExportQuery {
    /// Messages by name or number, like `EstimatedState,0x15e`; `*` for all; `_raw` alone for those that the
    /// catalogue does not explain, with id and payload.
    pub message: String,
    /// Vessels by name or IMC address (`2068`, `0x0814`); all that one may export when left out or empty.
    pub vessel: Option<String>,
    /// Entities by number, or by label: their messages while they had it; all when left out or empty.
    pub entity: Option<String>,
    /// Fields, of all messages that have them (`psi`) or of one (`EulerAngles.psi`); all when left out or empty.
    pub field: Option<String>,
    /// From this time on, ISO 8601, UTC unless it has an offset (`+02:00`); from the beginning when left out or empty.
    pub from: Option<String>,
    /// Before this time, ISO 8601, UTC unless it has an offset; to the end when left out or empty.
    pub to: Option<String>,
    /// `rad` or `deg` for angles; `rad` when left out.
    pub angles: Option<String>,
    /// `wide`: a row for each message, a column for each field. `long`: a row for each value. `wide` when left out.
    pub shape: Option<String>,
    /// Whether a wide table's header gives units, as in `psi [rad]`; true when left out.
    pub units: Option<bool>,
    /// Whether numbers with a label are written as that; false when left out.
    pub labels: Option<bool>,
    /// Whether text that a spreadsheet would take for a formula gets an apostrophe before it; true when left out.
    pub guard: Option<bool>,
    /// Whether each row also gives the time at which its message first came ashore; false when left out.
    pub received: Option<bool>,
    /// For spreadsheets: `comma` (byte order mark, semicolons, decimal commas) or `point` (mark, commas, decimal points);
    /// for programs, without a mark, when left out.
    pub spreadsheet: Option<String>,
    /// Of each series only the first row in each span of so many seconds, 0.001 to 86400; every row when left out.
    pub every_s: Option<f64>,
    /// Whether the file is packed by gzip; false when left out.
    pub gzip: Option<bool>,
}

/// What to export as a log. Lists are separated by commas.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct LogQuery {
    /// Messages by name or number; all when left out, empty or `*`.
    pub message: Option<String>,
    /// Vessels by name or IMC address (`2068`, `0x0814`); all that one may export when left out or empty.
    pub vessel: Option<String>,
    /// Entities by number, or by label: their messages while they had it; all when left out or empty.
    pub entity: Option<String>,
    /// From this time on, ISO 8601, UTC unless it has an offset (`+02:00`); from the beginning when left out or empty.
    pub from: Option<String>,
    /// Before this time, ISO 8601, UTC unless it has an offset; to the end when left out or empty.
    pub to: Option<String>,
    /// Whether the file is packed by gzip; false when left out.
    pub gzip: Option<bool>,
}

/// What is uploaded.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct ImportQuery {
    /// The file's name, to recognise it by; 1 to 200 letters.
    pub name: String,
    /// Of a table of detections: the vessel or fixed station, by name or address, that all of it is of. Without it the table's own
    /// names of vessels decide, else the register's deployments of the receivers.
    pub vessel: Option<String>,
}

/// A log that was uploaded, and how far its import is.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Import {
    /// Its number, growing.
    pub id: u32,
    /// The file's name.
    pub name: String,
    /// Who uploaded it.
    pub person: String,
    /// When it was uploaded, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub since_us: i64,
    /// Its state.
    pub state: ImportState,
    /// Bytes of the upload.
    #[cfg_attr(test, ts(type = "number"))]
    pub upload_bytes: u64,
    /// Bytes of the log read so far, unpacked.
    #[cfg_attr(test, ts(type = "number"))]
    pub read_bytes: u64,
    /// Packets found so far.
    #[cfg_attr(test, ts(type = "number"))]
    pub packets: u64,
    /// Those of them that were new.
    #[cfg_attr(test, ts(type = "number"))]
    pub added: u64,
    /// Bytes that are not packets.
    #[cfg_attr(test, ts(type = "number"))]
    pub damaged_bytes: u64,
    /// What is wrong with the log, and what to do about it.
    pub problems: Vec<ImportNote>,
}

/// Something about an imported file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(from = "Kept")]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ImportNote {
    /// What, in English.
    pub text: String,
    /// Of what pages make `text` in their reader's language; absent where it is English only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, ts(optional))]
    pub says: Option<Wording>,
}

impl From<Said> for ImportNote {
    fn from(said: Said) -> Self {
        let (text, says) = said.into_parts();
        Self { text, says }
    }
}

/// As lists of imports keep it, those of earlier versions too.
#[derive(Deserialize)]
#[serde(untagged)]
enum Kept {
    /// By an earlier version.
    Text(String),
    /// With its wording.
    Said {
        text: String,
        #[serde(default)]
        says: Option<Wording>,
    },
}

impl From<Kept> for ImportNote {
    fn from(kept: Kept) -> Self {
        match kept {
            Kept::Text(text) => Self { text, says: None },
            Kept::Said { text, says } => Self { text, says },
        }
    }
}

/// The state of an import.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum ImportState {
    /// It is being read.
    Running,
    /// It was read to its end.
    Done,
    /// It stopped early; what was read stays, and uploading it again adds only the rest.
    Failed,
    /// A user cancelled it; what was read stays, and uploading it again adds only the rest.
    Cancelled,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::say;

    #[test]
    fn notes_that_an_earlier_version_kept_are_read_too() {
        let old: ImportNote = serde_json::from_str(r#""the disk is full""#).unwrap();
        assert_eq!(old, ImportNote { text: "the disk is full".to_owned(), says: None });
        let note = ImportNote::from(Said::from(say("cancelled by {name}").with("name", "nils")));
        let kept = serde_json::to_string(&note).unwrap();
        assert_eq!(serde_json::from_str::<ImportNote>(&kept).unwrap(), note);
    }
}
