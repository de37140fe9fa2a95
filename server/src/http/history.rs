//! The present state and the history of the fleet, for programs.

use crate::AppState;
use crate::web::{ApiError, OfVessel, QueryParams, Who, extract};
use api::{
    At, AtQuery, Buckets, BucketsQuery, Detections, DetectionsQuery, Entity, EventsQuery,
    FleetDetectionsQuery, Gap, GapsQuery, LogBook, Recorded, RecordedDay, Samples, SamplesQuery, Series,
    SeriesQuery, System, TrackPoint, TrackQuery, say,
};
use axum::Json;
use axum::extract::State;
use axum::http::header;
use axum::response::{IntoResponse as _, Response};
use geofile::Position;
use imc::Address;
use research::TrackOf;
use shore::Wanted;
use shore::history::{self, export};
use std::sync::Arc;
use store::Source;
use units::UtcTime;

/// Most fields of one query.
const FIELDS: usize = 200;

/// `GET /api/v1/vessels`.
pub(crate) async fn vessels(
    State(state): State<AppState>,
    Who(who): Who,
) -> Result<Json<Vec<System>>, ApiError> {
    let wanted = Arc::new(Wanted { grants: who.grants, ..Wanted::default() });
    let mut systems = state.shore.fleet.systems(wanted).await.ok_or_else(ApiError::stopping)?;
    // Systems heard only from the server itself are not vessels.
    let shore = hub::Transport::Shore.name();
    systems.retain(|system| system.transports.iter().any(|transport| transport != shore));
    Ok(Json(systems))
}

/// `GET /api/v1/recorded`.
pub(crate) async fn recorded(
    State(state): State<AppState>,
    Who(who): Who,
) -> Result<Json<Vec<Recorded>>, ApiError> {
    let mut recorded = state.shore.history.ask(history::recorded).await?;
    recorded.retain(|series| who.grants.on(series.system).is_some());
    Ok(Json(recorded))
}

/// `GET /api/v1/recorded/days`.
pub(crate) async fn recorded_days(
    State(state): State<AppState>,
    Who(who): Who,
) -> Result<Json<Vec<RecordedDay>>, ApiError> {
    let may = move |system: u16| who.grants.on(system).is_some();
    Ok(Json(state.shore.history.ask(move |reader| history::recorded_days(reader, may)).await?))
}

/// `GET /api/v1/series`.
pub(crate) async fn series(
    State(state): State<AppState>,
    Who(who): Who,
    QueryParams(query): QueryParams<SeriesQuery>,
) -> Result<Json<Vec<Series>>, ApiError> {
    let wanted = extract::vessel(&state.shore, &who, ("system", query.system.as_deref())).await?;
    let may =
        move |system: u16| who.grants.on(system).is_some() && wanted.is_none_or(|wanted| wanted.0 == system);
    Ok(Json(state.shore.history.ask(move |reader| history::series(reader, may)).await?))
}

/// `GET /api/v1/vessels/{vessel}/buckets`.
pub(crate) async fn buckets(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
    QueryParams(query): QueryParams<BucketsQuery>,
) -> Result<Json<Buckets>, ApiError> {
    let range = extract::range(query.from_us, query.to_us)?;
    let pixels = extract::number("pixels", query.pixels, 1_000, 1..=10_000)?;
    let source = source(vessel, query.entity, &query.message)?;
    let ask =
        move |reader: &mut store::Reader| history::buckets(reader, &source, &query.field, range, pixels);
    Ok(Json(state.shore.history.ask(ask).await?))
}

/// `GET /api/v1/vessels/{vessel}/samples`.
pub(crate) async fn samples(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
    QueryParams(query): QueryParams<SamplesQuery>,
) -> Result<Json<Samples>, ApiError> {
    let range = extract::range(query.from_us, query.to_us)?;
    let page = extract::page(query.limit, query.skip)?;
    let source = source(vessel, query.entity, &query.message)?;
    let fields = export::list(query.fields.as_deref());
    if fields.len() > FIELDS {
        return Err(ApiError::bad_request(
            say("fields: more than {most}; ask for fewer").with("most", FIELDS),
        ));
    }
    let ask = move |reader: &mut store::Reader| history::samples(reader, &source, &fields, range, page);
    Ok(Json(state.shore.history.ask(ask).await?))
}

fn source(vessel: Address, entity: u8, message: &str) -> Result<Source, ApiError> {
    Ok(Source { system: vessel, entity, message: export::message(message)?.to_owned() })
}

/// `GET /api/v1/vessels/{vessel}/track`.
pub(crate) async fn track(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
    QueryParams(query): QueryParams<TrackQuery>,
) -> Result<Json<Vec<TrackPoint>>, ApiError> {
    let range = extract::range(query.from_us, query.to_us)?;
    let points = extract::number("points", query.points, 2_000, 2..=20_000)?;
    Ok(Json(state.shore.history.ask(move |reader| history::track(reader, vessel, range, points)).await?.0))
}

/// `GET /api/v1/vessels/{vessel}/track.gpx`.
pub(crate) async fn track_gpx(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
    QueryParams(query): QueryParams<TrackQuery>,
) -> Result<Response, ApiError> {
    let (name, track) = whole_track(&state, vessel, &query).await?;
    let text = geofile::gpx::write_track(&name, &segments(&track));
    Ok(track_file(&name, ("gpx", "application/gpx+xml"), text.into_bytes()))
}

/// `GET /api/v1/vessels/{vessel}/track.nc`.
pub(crate) async fn track_netcdf(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
    QueryParams(query): QueryParams<TrackQuery>,
) -> Result<Response, ApiError> {
    let (name, (points, step_us)) = whole_track(&state, vessel, &query).await?;
    let file = research::write_track(&TrackOf { vessel: &name, points: &points, step_us });
    Ok(track_file(&name, ("nc", "application/x-netcdf"), file))
}

/// What people call a vessel, and its track as a file has it.
async fn whole_track(
    state: &AppState,
    vessel: Address,
    query: &TrackQuery,
) -> Result<(String, (Vec<TrackPoint>, i64)), ApiError> {
    let range = extract::range(query.from_us, query.to_us)?;
    let most = extract::number("points", query.points, 20_000, 2..=20_000)?;
    let track = state.shore.history.ask(move |reader| history::track(reader, vessel, range, most)).await?;
    let named = state.shore.people.vessels();
    let name = named.iter().find(|one| one.address == vessel.0).map(|one| one.name.clone());
    Ok((name.filter(|name| !name.is_empty()).unwrap_or_else(|| vessel.to_string()), track))
}

fn track_file(name: &str, (ending, media): (&str, &'static str), bytes: Vec<u8>) -> Response {
    let disposition = format!("attachment; filename=\"{}-track.{ending}\"", extract::file_name(name));
    ([(header::CONTENT_TYPE, media.to_owned()), (header::CONTENT_DISPOSITION, disposition)], bytes)
        .into_response()
}

/// The parts of a track between breaks.
fn segments((points, step_us): &(Vec<TrackPoint>, i64)) -> Vec<Vec<(Position, String)>> {
    let placed = |point: &TrackPoint| {
        let at = Position::new(point.lat_deg, point.lon_deg)?;
        Some((at, UtcTime::from_micros(point.time_us).to_string()))
    };
    history::unbroken(points, *step_us).map(|part| part.iter().filter_map(placed).collect()).collect()
}

/// `GET /api/v1/vessels/{vessel}/at`.
pub(crate) async fn at(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
    QueryParams(query): QueryParams<AtQuery>,
) -> Result<Json<At>, ApiError> {
    let time_us = extract::time("time_us", query.time_us)?;
    Ok(Json(state.shore.history.ask(move |reader| history::at(reader, vessel, time_us)).await?))
}

/// `GET /api/v1/vessels/{vessel}/entities`.
pub(crate) async fn entities(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
) -> Result<Json<Vec<Entity>>, ApiError> {
    Ok(Json(state.shore.history.ask(move |reader| history::entities(reader, vessel)).await?))
}

/// `GET /api/v1/vessels/{vessel}/detections`.
pub(crate) async fn detections(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
    QueryParams(query): QueryParams<DetectionsQuery>,
) -> Result<Json<Detections>, ApiError> {
    let range = extract::range(query.from_us, query.to_us)?;
    let came_from = query.received_since_us.map(|us| extract::time("received_since_us", us)).transpose()?;
    let came_from = came_from.map(UtcTime::from_micros);
    let (order, page) = (extract::order(query.order.as_deref())?, extract::page(query.limit, query.skip)?);
    let ask =
        move |reader: &mut store::Reader| history::detections(reader, vessel, range, came_from, order, page);
    Ok(Json(state.shore.history.ask(ask).await?))
}

/// `GET /api/v1/detections`.
pub(crate) async fn fleet_detections(
    State(state): State<AppState>,
    Who(who): Who,
    QueryParams(query): QueryParams<FleetDetectionsQuery>,
) -> Result<Json<Detections>, ApiError> {
    let range = extract::range(query.from_us, query.to_us)?;
    let came_from = query.received_since_us.map(|us| extract::time("received_since_us", us)).transpose()?;
    let came_from = came_from.map(UtcTime::from_micros);
    let (order, page) = (extract::order(query.order.as_deref())?, extract::page(query.limit, query.skip)?);
    let (vessels, tags) = (export::list(query.vessel.as_deref()), export::tags(query.tag.as_deref())?);
    let may = move |vessel: u16| who.grants.on(vessel).is_some();
    let named = state.shore.people.vessels();
    if let Some(vessel) = export::addresses(&vessels).find(|vessel| !may(*vessel)) {
        return Err(ApiError::forbidden(
            say("vessel: you may not see vessel {vessel}. Ask an admin.").with("vessel", vessel),
        ));
    }
    let (_, study) = state.shore.register.study().await?;
    let narrowed = history::explore::narrowed(&query.project, query.area.as_deref(), &study)?;
    let (data, flags) = (state.shore.history.data().to_owned(), query.flags.unwrap_or(false));
    let ask = move |reader: &mut store::Reader| {
        let systems = Some(export::systems(reader, &vessels, &named, &may)?);
        let wanted = store::DetectionsWanted { systems, range, came_from, tags };
        history::heard::page(&data, reader, &wanted, (order, page), &study, (&narrowed, flags))
    };
    Ok(Json(state.shore.history.ask(ask).await?))
}

/// `GET /api/v1/vessels/{vessel}/logbook`.
pub(crate) async fn log_book(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
    QueryParams(query): QueryParams<EventsQuery>,
) -> Result<Json<LogBook>, ApiError> {
    let range = extract::range(query.from_us, query.to_us)?;
    let (order, page) = (extract::order(query.order.as_deref())?, extract::page(query.limit, query.skip)?);
    let ask = move |reader: &mut store::Reader| history::log_book(reader, vessel, range, order, page);
    Ok(Json(state.shore.history.ask(ask).await?))
}

/// `GET /api/v1/vessels/{vessel}/gaps`.
pub(crate) async fn gaps(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
    QueryParams(query): QueryParams<GapsQuery>,
) -> Result<Json<Vec<Gap>>, ApiError> {
    let range = extract::range(query.from_us, query.to_us)?;
    Ok(Json(state.shore.history.ask(move |reader| history::gaps(reader, vessel, range)).await?))
}
