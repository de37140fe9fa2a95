//! Other stores that follow the archive, beside the history. Each remembers how far it got, so that one that is
//! away, slow or new gets everything once it is there, and none of them holds up recording.

pub mod influx;
mod settings;

pub use settings::{Influx, Sinks as Settings};

use units::UtcTime;

/// How a sink gets on, for people.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct SinkState {
    /// What it carries to.
    pub target: String,
    /// Bytes of packets that wait to be carried; `None` before it has looked.
    pub behind_bytes: Option<u64>,
    /// Packets that it carried since the start, and those that were refused for good.
    pub kept: u64,
    pub refused: u64,
    /// When something arrived last.
    pub last: Option<UtcTime>,
    /// Why nothing arrives; `None` while all is well.
    pub trouble: Option<String>,
}
