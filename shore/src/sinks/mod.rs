//! Other stores that follow the archive, beside the history. Each remembers how far it got, so that one that is
//! away, slow or new gets everything once it is there, and none of them holds up recording.

pub(crate) mod influx;

use units::UtcTime;

/// How a sink gets on, for people.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct SinkState {
    /// What it carries to.
    pub(crate) target: String,
    /// Bytes of packets that wait to be carried; `None` before it has looked.
    pub(crate) behind_bytes: Option<u64>,
    /// Packets that it carried since the start, and those that were refused for good.
    pub(crate) kept: u64,
    pub(crate) refused: u64,
    /// When something arrived last.
    pub(crate) last: Option<UtcTime>,
    /// Why nothing arrives; `None` while all is well.
    pub(crate) trouble: Option<String>,
}
