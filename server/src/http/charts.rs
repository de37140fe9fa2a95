//! The sea chart for maps and programs.

use crate::AppState;
use crate::web::{ApiError, InBody, InPath, QueryParams, Who, WholeBody, extract};
use api::{
    ChartAtQuery, ChartCorridor, ChartCorridorRequest, ChartNear, ChartSet, ChartTileQuery, SeaRouteAnswer,
    SeaRouteCurrentGrid, SeaRouteProgress, SeaRouteRequest, say,
};
use axum::Json;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse as _, Response};
use bytes::Bytes;
use flate2::read::GzDecoder;
use shore::charts::{self, Set, TileError};
use std::io::Read as _;
use std::sync::Arc;
use units::LatLon;

/// Default distance within which objects are reported (m), and its maximum.
const WITHIN_M: f64 = 25.0;
const MOST_WITHIN_M: f64 = 2_000.0;
/// Points of a way, half its width (m) and its length (m).
const POINTS: std::ops::RangeInclusive<usize> = 2..=500;
const MOST_HALF_WIDTH_M: f64 = 1_000.0;
const LONGEST_M: f64 = 1e6;
/// Largest file of currents (bytes).
pub(crate) const CURRENTS_BYTES: usize = 8 << 20;
/// Media type of a tile.
const TILE: &str = "application/vnd.mapbox-vector-tile";

/// `GET /api/v1/chart`.
pub(crate) async fn set(State(state): State<AppState>) -> Json<ChartSet> {
    Json(charts::described(&state.shore.charts))
}

/// `GET /api/v1/chart/tiles/{z}/{x}/{y}`.
pub(crate) async fn tile(
    State(state): State<AppState>,
    InPath((z, x, y)): InPath<(u8, u32, u32)>,
    QueryParams(query): QueryParams<ChartTileQuery>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let set = there(&state)?;
    if query.set.as_ref().is_some_and(|wanted| *wanted != set.digest) {
        let text = say("That chart set is no longer in force; GET /api/v1/chart names the one that is.");
        return Err(ApiError::new(StatusCode::GONE, "another_set", text));
    }
    // Cached for ever if the address names the set; else to be revalidated.
    let kept = if query.set.is_some() { "private, max-age=31536000, immutable" } else { "private, no-cache" };
    let tag = format!("\"{}-{z}-{x}-{y}\"", &set.digest[..16]);
    let text = |name| headers.get(name).and_then(|value| value.to_str().ok()).unwrap_or_default();
    let (had, accepted) = (text(header::IF_NONE_MATCH), text(header::ACCEPT_ENCODING));
    let common = [
        (header::CACHE_CONTROL, kept.to_owned()),
        (header::ETAG, tag.clone()),
        (header::VARY, "accept-encoding".to_owned()),
    ];
    if had.split(',').any(|one| one.trim().trim_start_matches("W/") == tag) {
        return Ok((StatusCode::NOT_MODIFIED, common).into_response());
    }
    let packed = accepted.contains("gzip");
    let tile = slow(move || drawn(&set, (z, x, y), packed)).await??;
    let mut response = (common, [(header::CONTENT_TYPE, TILE)], tile).into_response();
    if packed {
        response.headers_mut().insert(header::CONTENT_ENCODING, header::HeaderValue::from_static("gzip"));
    }
    Ok(response)
}

fn drawn(set: &Set, (z, x, y): (u8, u32, u32), packed: bool) -> Result<Bytes, ApiError> {
    let tile = set.tile(z, x, y).map_err(|undrawn| match undrawn {
        TileError::None(why) => ApiError::not_found(say("There is no such tile: {why}.").with("why", why)),
        TileError::Charts(why) => unreadable(&why),
    })?;
    if packed {
        return Ok(tile);
    }
    let mut plain = Vec::new();
    GzDecoder::new(tile.as_ref()).read_to_end(&mut plain).map_err(|error| ApiError::internal(&error))?;
    Ok(plain.into())
}

/// `GET /api/v1/chart/at`.
pub(crate) async fn at(
    State(state): State<AppState>,
    Who(who): Who,
    QueryParams(query): QueryParams<ChartAtQuery>,
) -> Result<Json<ChartNear>, ApiError> {
    let place = place(query.lat_deg, query.lon_deg)?;
    let within_m = length("within_m", query.within_m.unwrap_or(WITHIN_M), MOST_WITHIN_M)?;
    let set = there(&state)?;
    let vessel = extract::vessel(&state.shore, &who, ("vessel", query.vessel.as_deref())).await?;
    let limits = state.shore.grounding.limits(&who, vessel.map(|vessel| vessel.0)).await;
    let near = slow(move || charts::at(&set, &limits, place, within_m)).await?;
    near.map(Json).map_err(|why| unreadable(&why))
}

/// `POST /api/v1/chart/corridor`.
pub(crate) async fn corridor(
    State(state): State<AppState>,
    InBody(ChartCorridorRequest { points, half_width_m }): InBody<ChartCorridorRequest>,
) -> Result<Json<ChartCorridor>, ApiError> {
    if !POINTS.contains(&points.len()) {
        let (least, most) = POINTS.into_inner();
        let text = say("points: there are {n}; give {least} to {most}")
            .with("n", points.len())
            .with("least", least)
            .with("most", most);
        return Err(ApiError::bad_request(text));
    }
    let point = |(number, [lat, lon]): (usize, [f64; 2])| {
        place(lat, lon)
            .map_err(|error| ApiError { text: error.text.of_field(&format!("points[{number}]")), ..error })
    };
    let points: Vec<LatLon> = points.into_iter().enumerate().map(point).collect::<Result<_, _>>()?;
    let half_width_m = length("half_width_m", half_width_m, MOST_HALF_WIDTH_M)?;
    let (set, limits) = (there(&state)?, *state.shore.charts.limits());
    let work = move || {
        if charts::way_m(&points) > LONGEST_M {
            let km = LONGEST_M / 1e3;
            return Err(ApiError::bad_request(
                say("points: the way is longer than {km} km; divide it").with("km", km),
            ));
        }
        charts::corridor(&set, &limits, &points, half_width_m).map_err(|why| unreadable(&why))
    };
    slow(work).await?.map(Json)
}

/// `POST /api/v1/chart/route`.
pub(crate) async fn route(
    State(state): State<AppState>,
    Who(who): Who,
    InBody(ask): InBody<SeaRouteRequest>,
) -> Result<Json<SeaRouteAnswer>, ApiError> {
    let set = there(&state)?;
    if let Some(missing) = state.shore.charts.not_closed() {
        let text = say("No route is planned, for the no-go areas are not in the chart: {missing}")
            .with("missing", missing);
        return Err(ApiError::unavailable(text));
    }
    let limits = state.shore.charts.strict(state.shore.grounding.limits(&who, ask.vessel).await);
    let now = state.shore.clock.utc();
    Ok(Json(state.shore.routing.route(set, ask, limits, now).await?))
}

/// `GET /api/v1/chart/route/{name}`.
pub(crate) async fn progress(
    State(state): State<AppState>,
    InPath(name): InPath<String>,
) -> Result<Json<SeaRouteProgress>, ApiError> {
    Ok(Json(state.shore.routing.progress(&name)?))
}

/// `POST /api/v1/chart/currents`.
pub(crate) async fn currents(
    file: Result<WholeBody, ApiError>,
) -> Result<Json<SeaRouteCurrentGrid>, ApiError> {
    let WholeBody(file) = file.map_err(|error| match error.status {
        StatusCode::PAYLOAD_TOO_LARGE => ApiError::malformed(
            StatusCode::PAYLOAD_TOO_LARGE,
            say("The file is larger than {most} MB: take out what is not needed.")
                .with("most", CURRENTS_BYTES >> 20),
        ),
        _ => error,
    })?;
    Ok(Json(shore::routing::currents_of_file(file.to_vec()).await?))
}

fn there(state: &AppState) -> Result<Arc<Set>, ApiError> {
    state.shore.charts.set().ok_or_else(|| match state.shore.charts.trouble() {
        Some(trouble) => unreadable(&trouble),
        None => ApiError::new(
            StatusCode::NOT_FOUND,
            "no_chart",
            say("There is no chart yet; `lutra-server chart import` brings one in."),
        ),
    })
}

fn unreadable(why: &str) -> ApiError {
    ApiError::unavailable(say("The chart cannot be read: {why}").with("why", why))
}

fn place(lat_deg: f64, lon_deg: f64) -> Result<LatLon, ApiError> {
    LatLon::from_deg(lat_deg, lon_deg).map_err(|error| {
        ApiError::bad_request(
            say("{lat_deg}, {lon_deg} is not a place: {error}")
                .with("lat_deg", lat_deg)
                .with("lon_deg", lon_deg)
                .with("error", error),
        )
    })
}

fn length(name: &str, value_m: f64, most_m: f64) -> Result<f64, ApiError> {
    if (0.0..=most_m).contains(&value_m) {
        return Ok(value_m);
    }
    Err(ApiError::bad_request(
        say("{name}: {value_m} is not within 0 to {most_m} m")
            .with("name", name)
            .with("value_m", value_m)
            .with("most_m", most_m),
    ))
}

/// Runs work of some milliseconds, which must not block other tasks.
async fn slow<R: Send + 'static>(work: impl FnOnce() -> R + Send + 'static) -> Result<R, ApiError> {
    tokio::task::spawn_blocking(work).await.map_err(|error| ApiError::internal(&error))
}
