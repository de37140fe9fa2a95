//! The state of the server itself: connections, links and recording.

use crate::ChartDifference;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// A connection by which IMC comes in and goes out.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct TransportPeer {
    /// Its number, never used twice while the server runs.
    pub id: u32,
    /// The transport: `link`, `imcproxy`, `tcp` or `udp`.
    pub transport: String,
    /// An address and port, or another name.
    pub name: String,
    /// When it came, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub since_us: i64,
    /// IMC addresses heard there that the caller may see, the most recent last.
    pub systems: Vec<u16>,
    /// Packets that came from it.
    #[cfg_attr(test, ts(type = "number"))]
    pub received: u64,
    /// Those of them that it may not send, or that are not packets.
    #[cfg_attr(test, ts(type = "number"))]
    pub refused: u64,
    /// Packets for it.
    #[cfg_attr(test, ts(type = "number"))]
    pub delivered: u64,
    /// Those of them that were dropped because it does not read.
    #[cfg_attr(test, ts(type = "number"))]
    pub dropped: u64,
}

/// How the link of a vessel is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct LinkStatus {
    /// IMC address of the vessel.
    pub vessel: u16,
    /// Whether the link is open.
    pub up: bool,
    /// Records that wait aboard to be delivered.
    #[cfg_attr(test, ts(type = "number"))]
    pub backlog_records: u64,
    /// Age of the oldest of them, seconds.
    pub backlog_age_s: f64,
    /// From sending a record to the vessel knowing that it is kept, the last time, seconds.
    pub keeping_s: f64,
    /// The last round trip, seconds; null before the first.
    pub round_trip_s: Option<f64>,
    /// The vessel's clock minus the server's, seconds; null while unknown.
    pub clock_ahead_s: Option<f64>,
    /// That estimate is wrong by at most this, seconds.
    pub clock_uncertainty_s: Option<f64>,
    /// From recording aboard to receiving here, mean of the records of the last second, seconds; null without any.
    pub transit_s: Option<f64>,
    /// Bytes received over all connections.
    #[cfg_attr(test, ts(type = "number"))]
    pub received_bytes: u64,
    /// Records that came again after they were received.
    #[cfg_attr(test, ts(type = "number"))]
    pub repeated: u64,
    /// Connections opened so far.
    #[cfg_attr(test, ts(type = "number"))]
    pub connections: u64,
    /// The sea chart aboard.
    pub chart: VesselChart,
    /// The ways of a vessel that has several; null for one that has one.
    pub ways: Option<LinkWays>,
}

/// The ways of one vessel to this server, as last reported.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct LinkWays {
    /// Place of the way that carries live values and commands; null for none.
    pub live: Option<u8>,
    /// Why: `only` one that stood, `better`, `cheaper`, `failover` from one that did not answer, `budget` of another used
    /// up, or `none`.
    pub live_why: String,
    /// Place of the way that carries records; null while they wait aboard.
    pub records: Option<u8>,
    /// Why, in the same words.
    pub records_why: String,
    /// All ways, in the order of their places.
    pub ways: Vec<LinkWay>,
}

/// One way of a vessel to this server.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct LinkWay {
    /// Its name aboard.
    pub name: String,
    /// Its bytes cost.
    pub metered: bool,
    /// `up`, `suspect` while it does not answer in time, or `down`.
    pub state: String,
    /// From sending a message to knowing that it arrived, ms; null while unknown.
    pub round_trip_ms: Option<u32>,
    /// Of the last messages so many in a thousand were late by a packet that was lost.
    pub late_per_mille: u16,
    /// The fastest that it lately carried, B/s; null while unknown.
    pub rate_bytes_per_s: Option<u32>,
    /// Bytes of the day (UTC), both directions.
    #[cfg_attr(test, ts(type = "number"))]
    pub today_bytes: u64,
    /// Bytes that it may carry in a day; null for no bound.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub daily_bytes: Option<u64>,
    /// What it leaves out to save data: `nothing`, `records`, `most`, or `all_but_last`.
    pub thinning: String,
    /// How often it broke or stopped answering since the start of the vessel's program.
    pub failures: u32,
}

/// Which sea chart a vessel holds, as last reported.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct VesselChart {
    /// `same` as ashore, `fetching` the shore's, `waiting` until the vessel rests, `failed` to take it, `declined` by
    /// the vessel's configuration, `other` than ashore, `none`, or `unknown`.
    pub state: String,
    /// The same in words, with the reason where it could not be taken.
    pub text: String,
    /// Contents of the chart in force aboard; null for none.
    pub edition: Option<String>,
    /// SHA-256 of its file in hexadecimal digits; null for none.
    pub digest: Option<String>,
    /// How it differs from the shore's, and the state of the transfer; null where it is the same, or not known.
    pub difference: Option<ChartDifference>,
    /// When the vessel reported it, µs since 1970 UTC; null while unknown.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub told_us: Option<i64>,
}

/// How recording goes.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Recording {
    /// Why nothing can be recorded at the moment, and what to do; null while all is well.
    pub trouble: Option<String>,
    /// Why the history does not hold all that is archived; null while it does.
    pub history_behind: Option<String>,
    /// Packets recorded since the server started.
    #[cfg_attr(test, ts(type = "number"))]
    pub recorded: u64,
    /// Packets that could not wait for the disk any longer and are not recorded.
    #[cfg_attr(test, ts(type = "number"))]
    pub not_recorded: u64,
    /// Bytes that wait for the disk.
    #[cfg_attr(test, ts(type = "number"))]
    pub waiting_bytes: u64,
    /// Bytes of other transports than the link that may wait; what comes beyond is not recorded.
    #[cfg_attr(test, ts(type = "number"))]
    pub waiting_bytes_most: u64,
}
