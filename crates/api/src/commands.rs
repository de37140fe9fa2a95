//! What people order vessels to do.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// An order that the server has written into the audit log and handed on. Whether the vessel obeys is told by the
/// vessel alone: by what it says afterwards.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Ordered {
    /// When it was handed on, by the server's clock, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub time_us: i64,
    /// Whether a door leads to the vessel at present, so that the order is on its way; else nobody heard it.
    pub reached: bool,
    /// Whether the audit log holds it. A stop goes out all the same.
    pub audited: bool,
}
