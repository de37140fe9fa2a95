//! Routes on the sea chart.

use crate::GuardReason;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// From where to where, and how deep and how far off.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SeaRouteRequest {
    /// Latitude and longitude (°) of the start, of places to pass in this order, and of the goal; 2 to 50.
    pub points: Vec<[f64; 2]>,
    /// IMC address of the vessel whose limits hold; null for those of the server.
    #[serde(default)]
    pub vessel: Option<u16>,
    /// Least depth (m); null for what the guard demands.
    #[serde(default)]
    pub least_depth_m: Option<f64>,
    /// How far to keep from all that is not deep enough (m), 0 to 500; null for what the guard demands.
    #[serde(default)]
    pub clearance_m: Option<f64>,
    /// Turning radius of the vessel (m), 0 to 2000: turns keep to the asked water too, or their leg says that they do not;
    /// null where it is not known.
    #[serde(default)]
    pub turn_radius_m: Option<f64>,
    /// How far the vessel may be off its track before its path monitor ends the plan (m), 0 to 500: the route says where danger
    /// is nearer than that. Null for 25, as the Otters have it.
    #[serde(default)]
    pub stray_m: Option<f64>,
    /// What the route is good for.
    #[serde(default)]
    pub objective: SeaRouteObjective,
    /// Water shallower than this (m) costs more, so that a route keeps to deeper water where that is worth the way;
    /// null for no such preference.
    #[serde(default)]
    pub prefer_depth_m: Option<f64>,
    /// Water nearer than this (m), 0 to 500, to land, dangers and water that is not deep enough costs more; null for no such
    /// preference.
    #[serde(default)]
    pub prefer_off_m: Option<f64>,
    /// How many times as much such water costs, 1 to 100; null for 3. In water that is both, the two surcharges add.
    #[serde(default)]
    pub prefer_factor: Option<f64>,
    /// How many times as much a metre costs in traffic lanes, separation zones and deep-water routes of the chart, 1 to 100; the
    /// surcharge is twice as large straight against the direction of a lane. The route keeps out of them where the way round is
    /// not far. 1 does not mind them; null for 3.
    #[serde(default)]
    pub traffic_factor: Option<f64>,
    /// Speed through the water that time and energy are reckoned with (m/s); null for 1.5. For the least energy the greatest
    /// one.
    #[serde(default)]
    pub speed_mps: Option<f64>,
    /// Areas to avoid, to stay within, or with a speed limit; up to 50, of which one may be to stay within, with 1000 corners
    /// and 2000 km of borders in all.
    #[serde(default)]
    pub zones: Vec<SeaRouteZone>,
    /// The current that time and energy are reckoned in; null for none.
    #[serde(default)]
    pub current: Option<SeaRouteCurrent>,
    /// A current that changes from place to place, in place of a steady one; null for none.
    #[serde(default)]
    pub current_grid: Option<SeaRouteCurrentGrid>,
    /// When the route begins, µs since 1970 UTC: which of the grid's times count. Null for now.
    #[serde(default)]
    #[cfg_attr(test, ts(type = "number | null"))]
    pub depart_us: Option<i64>,
    /// How many other routes to look for, 0 to 3, that pass islands and shoals on the other side; they are not looked for
    /// where there are places to pass.
    #[serde(default)]
    pub alternatives: u8,
    /// If no route exists, look for a smaller depth and clearance that give one, and for what is in the way; it can take some
    /// seconds.
    #[serde(default)]
    pub explain: bool,
    /// A name for this question, 8 to 64 letters, digits and hyphens that no other question has: as long as it is worked on,
    /// `GET /api/v1/chart/route/{name}` says how far it has come. Null for none.
    #[serde(default)]
    pub progress: Option<String>,
}

/// How far a question for a route has come.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SeaRouteProgress {
    /// Other routes are planned before it.
    pub waiting: bool,
    /// Tiles of the chart that were searched for it; 0 as long as it is not known to be a long way.
    pub tiles: usize,
    /// The search stops after so many; 0 as long as it is not known to be a long way. Most ways are found long before.
    pub most_tiles: usize,
    /// Time since it was asked (s).
    pub spent_s: f64,
    /// Planning stops after so long (s), without the time that it waited.
    pub most_s: f64,
}

/// What a route is good for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum SeaRouteObjective {
    /// The least length.
    #[default]
    Shortest,
    /// The least time at the speed through the water.
    Fastest,
    /// The least energy, at the speed through the water or a slower one: `speed_mps` of the route says which.
    LeastEnergy,
}

/// Currents at the crossings of latitudes and longitudes, at one or more times; linear between them, not known beyond them.
/// A grid of one time holds at any time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SeaRouteCurrentGrid {
    /// Times, rising, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "Array<number>"))]
    pub times_us: Vec<i64>,
    /// Latitudes (°), rising, two or more.
    pub lats_deg: Vec<f64>,
    /// Longitudes (°), rising, two or more; also beyond 180.
    pub lons_deg: Vec<f64>,
    /// Current to the true east (m/s) by time, then latitude, then longitude, 100000 values at most; null where not known.
    pub east_mps: Vec<Option<f32>>,
    /// Current to the true north (m/s), as to the east.
    pub north_mps: Vec<Option<f32>>,
}

/// An area that routes avoid or stay within, or where they are slow.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SeaRouteZone {
    /// What it is for.
    pub kind: SeaRouteZoneKind,
    /// Latitude and longitude (°) of its corners, 3 to 200; the last joins the first, and its sides do not cross.
    pub corners: Vec<[f64; 2]>,
    /// Greatest speed through the water (m/s) in an area of the kind `limit`; null in others.
    #[serde(default)]
    pub most_mps: Option<f64>,
}

/// What an area of a route is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum SeaRouteZoneKind {
    /// Routes do not enter it.
    Avoid,
    /// Routes do not leave it.
    Within,
    /// In it a vessel is no faster than a limit, which counts for time and energy.
    Limit,
}

/// A steady current.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SeaRouteCurrent {
    /// Where it flows to (°), clockwise from true north.
    pub set_deg: f64,
    /// How fast (m/s), 0 to 10.
    pub drift_mps: f64,
}

/// The answer: either a route, or the reason that no route exists. The other is null.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SeaRouteAnswer {
    /// Least depth that was asked for (m).
    pub asked_depth_m: f64,
    /// Clearance that was asked for (m).
    pub asked_clearance_m: f64,
    /// The route.
    pub route: Option<SeaRoute>,
    /// The shortest route, to compare with; null where the route is the shortest one itself.
    pub shortest: Option<SeaRoute>,
    /// Other routes, as far as they were asked for and differ from this one and each other: the shortest first.
    pub alternatives: Vec<SeaRoute>,
    /// The reason that no route exists.
    pub refusal: Option<SeaRouteRefusal>,
    /// Duration of the planning (ms).
    pub took_ms: f64,
}

/// A route whose every leg the chart confirms.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SeaRoute {
    /// Latitude and longitude (°) of its corners, start and goal included.
    pub points: Vec<[f64; 2]>,
    /// From each point to the next.
    pub legs: Vec<SeaRouteLeg>,
    /// Length (m).
    pub length_m: f64,
    /// The speed through the water that time and energy are reckoned with (m/s).
    pub speed_mps: f64,
    /// Length on which the current is not known (m): beyond the grid or its times, and after such water where the current
    /// changes with time. Time and energy are null then. A route by time or energy has no more of it than the shortest one.
    pub current_unknown_m: f64,
    /// Whether the current is too strong somewhere. Time and energy are null then.
    pub current_too_strong: bool,
    /// How long it takes at the speed through the water (s); null where the current is too strong or not known.
    pub duration_s: Option<f64>,
    /// Energy from the battery (Wh), by a rough model of an Otter; null where the current is too strong or not known, and at
    /// speeds that the model does not know.
    pub energy_wh: Option<f64>,
    /// Least charted depth within the clearance (m).
    pub least_depth_m: Option<f64>,
    /// Distance to the nearest danger, land or shallow water (m); null beyond 5 km.
    pub least_clearance_m: Option<f64>,
    /// Ends and places to pass too near land, shallow water or a danger, which were moved to the nearest open water.
    pub moved: Vec<SeaRouteMoved>,
    /// Whether the guard lets a vessel sail every leg autonomously.
    pub guarded: bool,
    /// The first leg that it refuses, by its number, and why; null where it refuses none.
    pub guard: Option<GuardReason>,
    /// Legs where danger is nearer than the vessel may be off its track; null where there is room everywhere.
    pub narrow: Option<SeaRouteNarrow>,
    /// Whether only part of the water was looked at in full, as the charts hold too much of it: other water may hold a shorter
    /// route. Its legs are checked like those of any route.
    pub part_only: bool,
}

/// Ordered traffic on a leg.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SeaRouteTraffic {
    /// `lane`, `separation_zone`, `junction` or `deep_water`.
    pub kind: String,
    /// Whether the leg leads against the direction of the lane.
    pub against: bool,
}

/// Legs of a route on which danger is nearer than the vessel may be off its track before its path monitor ends the plan.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SeaRouteNarrow {
    /// Distance that leaves room (m): how far the vessel may be off its track, its hull, and the uncertainty of its position.
    pub needed_m: f64,
    /// The narrowest leg, by its number from 0.
    pub leg: usize,
    /// Its distance to the nearest danger, land or shallow water (m).
    pub least_m: f64,
    /// How many legs they are.
    pub legs: usize,
    /// How long they are together (m).
    pub length_m: f64,
}

/// A leg of a route.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SeaRouteLeg {
    /// Length (m).
    pub length_m: f64,
    /// Course over ground at its start (°), clockwise from true north.
    pub course_deg: f64,
    /// How long it takes (s); null where the current is too strong or not known.
    pub duration_s: Option<f64>,
    /// The slowest speed limit (m/s) of the areas that the leg enters or touches, where it is slower than the route's speed;
    /// null where no limit is. A plan with one speed for the route does not keep it.
    pub limit_mps: Option<f64>,
    /// The ordered traffic that the leg enters or touches, where it is minded; null for none.
    pub traffic: Option<SeaRouteTraffic>,
    /// Energy from the battery (Wh); null where the current is too strong or not known.
    pub energy_wh: Option<f64>,
    /// Least charted depth within the clearance (m).
    pub least_depth_m: Option<f64>,
    /// Where that is: latitude and longitude (°).
    pub least_depth_at: [f64; 2],
    /// Distance to the nearest danger, land or shallow water (m); null beyond 5 km.
    pub clearance_m: Option<f64>,
    /// Why a vessel of the asked turning radius leaves the asked water in the turn at the end of this leg, for people; null
    /// if it does not, and where no radius was asked for.
    pub turn_text: Option<String>,
}

/// An end of a route, or a place to pass, that was moved.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SeaRouteMoved {
    /// `start`, `via` for a place to pass, or `goal`.
    pub end: String,
    /// Number of the place to pass, from 1; null at an end.
    pub via: Option<usize>,
    /// How far (m).
    pub distance_m: f64,
    /// Why, for people.
    pub text: String,
}

/// Why no route exists.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SeaRouteRefusal {
    /// For programs: `closed_start`, `closed_via` (at a place to pass), `closed_goal`, `no_way`, `not_found` (not all water was
    /// looked at), `gave_up` (the search for a long way was stopped), `too_far`, `not_confirmed` or `failed`.
    pub code: String,
    /// For people: what is in the way, and what to do.
    pub text: String,
    /// Which stretch between two of the asked points, from 0.
    pub stretch: usize,
    /// The nearest place that can be reached: latitude and longitude (°).
    pub nearest: Option<[f64; 2]>,
    /// How far open water, or that place, is from where it was asked for (m).
    pub gap_m: Option<f64>,
    /// The obstacle at a closed end; null for another reason.
    pub closed: Option<SeaRouteClosed>,
    /// How far start and goal are apart, and how far they may be (m); null for another reason.
    pub apart_m: Option<[f64; 2]>,
    /// How far from the start it was looked, where not all water was looked at (m); null for another reason.
    pub looked_m: Option<f64>,
    /// What a search that was stopped had come to; null for another reason.
    pub gave_up: Option<SeaRouteGaveUp>,
    /// Number of the place to pass that is closed, from 1; null for another reason.
    pub via: Option<usize>,
    /// Where start and goal are too far apart: places on a way between them, if one is known. Routes by way of them have shorter stretches.
    pub by: Vec<[f64; 2]>,
    /// Changes that would give a route; null where that was not asked for.
    pub passable: Option<SeaRoutePassable>,
}

/// What a search that was stopped had come to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SeaRouteGaveUp {
    /// So many tiles of the chart were searched.
    pub tiles: usize,
    /// Whether its time was used up; else it may search no more of the chart.
    pub out_of_time: bool,
}

/// The obstacle at an end of a route that is closed to the vessel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SeaRouteClosed {
    /// As the code of a [`GuardReason`], or `zone` in an area to avoid or outside of one to stay within; `too-shallow` also where it is deep enough and a danger is too near.
    pub code: String,
    /// Least charted depth there (m); null where it is not water of known depth.
    pub depth_m: Option<f64>,
    /// How far the end may be moved (m).
    pub may_move_m: f64,
}

/// Smaller demands that give a route, where the ones asked for give no route.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SeaRoutePassable {
    /// The greatest least depth (m) that gives one with this clearance; null if none was found.
    pub depth_m: Option<f64>,
    /// Where that one is shallowest: latitude and longitude (°).
    pub shallowest_at: Option<[f64; 2]>,
    /// The greatest clearance (m) that gives one of this depth; null if none was found.
    pub clearance_m: Option<f64>,
    /// Where the gap is that allows no more clearance: latitude and longitude (°) of its middle.
    pub gap_at: Option<[f64; 2]>,
    /// How wide that gap is (m).
    pub gap_width_m: Option<f64>,
    /// Whether there is one without the areas where entry is prohibited or restricted.
    pub by_rule_alone: bool,
    /// Whether there is one without the areas that the request itself avoids or keeps within.
    pub by_zones_alone: bool,
}
