//! Summaries of many detections, for plots.

use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

/// Which detections are counted. Lists are separated by commas.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct DetectionsSummaryQuery {
    /// Reported from this time on, µs since 1970 UTC; from the beginning when left out.
    pub from_us: Option<i64>,
    /// Reported before this time, µs since 1970 UTC; to the end when left out.
    pub to_us: Option<i64>,
    /// Vessels by name or IMC address; all that one may see when left out or empty.
    pub vessel: Option<String>,
    /// Tags as protocol and number (`S256-101`) or as number alone (`101`); all when left out or empty.
    pub tag: Option<String>,
    /// Projects of the register by name, of the tag, or of the animal that carried it: the parameter once for each. A name that the register
    /// does not have is read as several with `;` between them. All when left out or empty.
    #[serde(default)]
    #[param(required = false)]
    pub project: Vec<String>,
    /// Corners of an area on the chart, 3 to 100, as `lat,lon;lat,lon;…` in degrees; detections without a position are left
    /// out then. Everywhere when left out or empty.
    pub area: Option<String>,
    /// Whether the plots reach to all times, also to a few by clocks that are wrong and far from all others; no when left out.
    /// `outside` and `listened_outside_s` say how many those are.
    pub whole_axis: Option<bool>,
}

/// Why a detection is doubtful.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum FlagCode {
    /// No other detection of the tag by the receiver within 30 of its ping intervals: perhaps a false one.
    Unconfirmed,
    /// The receiver's clock was never set: the time is the vessel's, when the line came.
    ClockNotSet,
    /// The receiver's clock was lost, likewise.
    ClockLost,
    /// The receiver's clock is more than an hour off the vessel's.
    ClockOff,
    /// The vessel did not know where it was.
    NoPlace,
    /// The nearest measured position is more than 10 s away.
    OldPlace,
    /// Lines of the receiver were lost right before.
    LinesLost,
}

/// A flag with its reason.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct DetectionFlag {
    /// What it is.
    pub code: FlagCode,
    /// Why, with the figures.
    pub reason: String,
    /// The figure of the reason, in the unit that the code has: s, or lines; null where it has none.
    pub figure: Option<f64>,
}

/// Detections counted, with all that plots of them need. It is as large for a million as for a thousand.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct DetectionsSummary {
    /// How many there are.
    #[cfg_attr(test, ts(type = "number"))]
    pub detections: u64,
    /// Begin of the plots, µs since 1970 UTC; null without detections.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub from_us: Option<i64>,
    /// Their end.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub to_us: Option<i64>,
    /// How long a step of `tags[].marks` is, µs; the first begins at `from_us`.
    #[cfg_attr(test, ts(type = "number"))]
    pub step_us: i64,
    /// Tags, the one that was heard most first; at most 100.
    pub tags: Vec<SummaryTag>,
    /// How many tags there are, listed or not.
    pub tags_all: u32,
    /// How long a bar is, µs; an hour or more.
    #[cfg_attr(test, ts(type = "number"))]
    pub bar_us: i64,
    /// Detections and effort by time, in order; empty bars are left out.
    pub bars: Vec<SummaryBar>,
    /// Where, in squares; empty ones are left out.
    pub squares: Vec<SummarySquare>,
    /// How long the side of a square is, m.
    pub square_m: f64,
    /// By vessel.
    pub vessels: Vec<SummaryVessel>,
    /// How many have which flag; flags that none has are left out.
    pub flags: Vec<SummaryFlag>,
    /// Detections whose times lie outside the plots: few, far from all others, and of receivers whose clock was not set, lost, or far
    /// from the vessel's. They are counted in everything else; `whole_axis=true` shows them.
    #[cfg_attr(test, ts(type = "number"))]
    pub outside: u64,
    /// How long receivers listened outside the plots, all together, s: likewise.
    pub listened_outside_s: f64,
    /// Detections reported before this are left out, as more than the server holds in memory are asked for, µs since 1970 UTC;
    /// null where none are.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub left_out_before_us: Option<i64>,
    /// Of detections reported before this it is not known whether something confirms them, as not all of the day before them is
    /// counted: none of them is called unconfirmed. µs since 1970 UTC; null where it is known of all.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub confirmed_from_us: Option<i64>,
    /// The server still reads: so far is counted what was reported from this time on, µs since 1970 UTC. Ask again soon. Null when
    /// everything is counted.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub read_from_us: Option<i64>,
}

/// A tag that was heard. A code that was given to several tags in turn is one for each, and one more for the time that no animal carried
/// it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SummaryTag {
    /// Protocol and number, `S256-101`.
    pub tag: String,
    /// The number.
    #[cfg_attr(test, ts(type = "number"))]
    pub tag_id: u32,
    /// What the register calls it; empty where it does not know it.
    pub name: String,
    /// The animal that carried it; empty where the register does not say.
    pub animal: String,
    /// The project; likewise.
    pub project: String,
    /// How often it was heard.
    #[cfg_attr(test, ts(type = "number"))]
    pub detections: u64,
    /// How many of those nothing confirms.
    #[cfg_attr(test, ts(type = "number"))]
    pub unconfirmed: u64,
    /// When first, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub first_us: i64,
    /// When last.
    #[cfg_attr(test, ts(type = "number"))]
    pub last_us: i64,
    /// Steps in which it was heard: number of the step, detections, and how many of those nothing confirms.
    pub marks: Vec<[u32; 3]>,
}

/// Detections within a stretch of time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SummaryBar {
    /// Where it begins, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub from_us: i64,
    /// Detections.
    #[cfg_attr(test, ts(type = "number"))]
    pub detections: u64,
    /// How many of those nothing confirms.
    #[cfg_attr(test, ts(type = "number"))]
    pub unconfirmed: u64,
    /// How long receivers listened in it, all together, s; null where no receiver reported it, and where an area is chosen.
    pub listened_s: Option<f64>,
}

/// Detections near a place.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SummarySquare {
    /// WGS-84 latitude of their middle, degrees, north positive.
    pub lat_deg: f64,
    /// WGS-84 longitude of their middle, degrees, east positive.
    pub lon_deg: f64,
    /// How many.
    #[cfg_attr(test, ts(type = "number"))]
    pub detections: u64,
}

/// What a vessel heard.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SummaryVessel {
    /// IMC address.
    pub system: u16,
    /// Detections.
    #[cfg_attr(test, ts(type = "number"))]
    pub detections: u64,
    /// How long its receivers listened, all together, s; null where it did not report it, and where an area is chosen.
    pub listened_s: Option<f64>,
}

/// How many detections have a flag.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SummaryFlag {
    /// The flag.
    pub code: FlagCode,
    /// How many.
    #[cfg_attr(test, ts(type = "number"))]
    pub detections: u64,
}
