//! Exports, and who may have them.

use super::download::Download;
use crate::AppState;
use crate::web::{ApiError, QueryParams, Who, extract};
use api::{DetectionsFileQuery, ExportQuery, ExportSize, LogQuery, Role, say};
use axum::Json;
use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::Response;
use serde_json::Value;
use shore::history::explore;
use shore::history::export::{self, Export};
use shore::history::heard::{self, HeardFile};
use shore::identity::Principal;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;
use store::{DetectionsWanted, Exported, Reader, Selection};

const CSV: &str = "text/csv; charset=utf-8";

/// `GET /api/v1/export.csv`.
pub(crate) async fn csv(
    State(state): State<AppState>,
    Who(who): Who,
    asked: HeaderMap,
    QueryParams(query): QueryParams<ExportQuery>,
) -> Result<Response, ApiError> {
    let export = Export::csv(&query)?;
    let options = export.options;
    let written = Written {
        ending: "csv",
        media: CSV,
        write: Box::new(move |data, selection, out| store::export_csv(data, selection, &options, out)),
        version: |data, selection| store::table_version(&mut Reader::open(data)?, selection),
    };
    send(&state, who, export, &asked, written).await
}

/// `GET /api/v1/export.parquet`.
pub(crate) async fn parquet(
    State(state): State<AppState>,
    Who(who): Who,
    asked: HeaderMap,
    QueryParams(query): QueryParams<ExportQuery>,
) -> Result<Response, ApiError> {
    let export = Export::parquet(&query)?;
    let options = export.options;
    let written = Written {
        ending: "parquet",
        media: "application/vnd.apache.parquet",
        write: Box::new(move |data, selection, out| store::export_parquet(data, selection, &options, out)),
        version: |data, selection| store::table_version(&mut Reader::open(data)?, selection),
    };
    send(&state, who, export, &asked, written).await
}

/// `GET /api/v1/export.lsf`.
pub(crate) async fn lsf(
    State(state): State<AppState>,
    Who(who): Who,
    asked: HeaderMap,
    QueryParams(query): QueryParams<LogQuery>,
) -> Result<Response, ApiError> {
    let export = Export::log(&query)?;
    let written = Written {
        ending: "lsf",
        media: "application/octet-stream",
        write: Box::new(store::export_lsf),
        version: store::log_version,
    };
    send(&state, who, export, &asked, written).await
}

/// `GET /api/v1/detections.csv`.
pub(crate) async fn detections(
    State(state): State<AppState>,
    Who(who): Who,
    asked: HeaderMap,
    QueryParams(query): QueryParams<DetectionsFileQuery>,
) -> Result<Response, ApiError> {
    let range = match (query.from_us, query.to_us) {
        (None, None) => store::TimeRange::ALL,
        (from_us, to_us) => extract::range(from_us.unwrap_or(0), to_us.unwrap_or(extract::LAST_US))?,
    };
    let tags = export::tags(query.tag.as_deref())?;
    let file = HeardFile::new(query.format.as_deref(), query.spreadsheet.as_deref())?;
    let vessels = export::list(query.vessel.as_deref());
    let named = state.shore.people.vessels();
    let names: BTreeMap<u16, String> =
        named.iter().map(|vessel| (vessel.address, vessel.name.clone())).collect();
    let may = may(who, &vessels)?;
    let gzip = query.gzip.unwrap_or(false);
    let name = format!("{}{}", file.name(), if gzip { ".gz" } else { "" });
    let (register, study) = state.shore.register.study().await?;
    let narrowed = explore::narrowed(&query.project, query.area.as_deref(), &study)?;
    let file = HeardFile { narrowed, ..file };
    let find = move |reader: &mut Reader| export::systems(reader, &vessels, &named, &may);
    let systems = state.shore.history.ask(find).await?;
    // Any change of what it is made of may change the file; a vessel that said nothing yet has none.
    let carriers =
        Selection { messages: file.messages(), range: file.read_range(range), ..Selection::default() };
    let wanted = DetectionsWanted { systems: Some(systems), range, came_from: None, tags };
    let download = Download {
        question: format!(
            "{name} {} {wanted:?} {names:?} {:?} {:?} {register}",
            file.format.name, file.dialect, file.narrowed
        ),
        name,
        media: file.format.media(),
        gzip,
        write: Arc::new(move |data, out| heard::write(data, &wanted, &names, &study, &file, out).map(drop)),
        version: Arc::new(move |data| store::table_version(&mut Reader::open(data)?, &carriers)),
    };
    download.answer(&state, &asked).await
}

/// `GET /api/v1/export.json`: describes the columns of the CSV.
pub(crate) async fn description(
    State(state): State<AppState>,
    Who(who): Who,
    QueryParams(query): QueryParams<ExportQuery>,
) -> Result<Json<Value>, ApiError> {
    let export = Export::csv(&query)?;
    let may = may(who, &export.vessels)?;
    let named = state.shore.people.vessels();
    let describe = move |reader: &mut Reader| {
        let options = export.options;
        let selection = export.selection(reader, &named, &may)?;
        store::describe_csv(reader, &selection, &options)
    };
    Ok(Json(state.shore.history.ask(describe).await?))
}

/// `GET /api/v1/export/size`: how large the CSV will be.
pub(crate) async fn size(
    State(state): State<AppState>,
    Who(who): Who,
    QueryParams(query): QueryParams<ExportQuery>,
) -> Result<Json<ExportSize>, ApiError> {
    let export = Export::csv(&query)?;
    let may = may(who, &export.vessels)?;
    let (history, named) = (state.shore.history.clone(), state.shore.people.vessels());
    let measure = move |reader: &mut Reader| {
        let options = export.options;
        let selection = export.selection(reader, &named, &may)?;
        store::measure_csv(history.data(), &selection, &options)
    };
    let Exported { rows, bytes } = state.shore.history.ask(measure).await?;
    Ok(Json(ExportSize { rows, bytes, estimated: true }))
}

/// Vessels whose data the person may export.
pub(super) fn may(
    who: Principal,
    vessels: &[String],
) -> Result<impl Fn(u16) -> bool + Send + 'static, ApiError> {
    let may = move |vessel: u16| who.grants.on(vessel) >= Some(Role::Researcher);
    match export::addresses(vessels).find(|vessel| !may(*vessel)) {
        None => Ok(may),
        Some(vessel) => Err(ApiError::forbidden(
            say("vessel: exporting data of vessel {vessel} takes the role researcher there. Ask an admin.")
                .with("vessel", vessel),
        )),
    }
}

/// Writes a selection from a data folder.
type WriteSelection = dyn Fn(&Path, &Selection, &mut dyn Write) -> store::Result<Exported> + Send + Sync;

/// How a selection is written, and the version of its data.
struct Written {
    ending: &'static str,
    media: &'static str,
    write: Box<WriteSelection>,
    version: fn(&Path, &Selection) -> store::Result<u64>,
}

async fn send(
    state: &AppState,
    who: Principal,
    export: Export,
    asked: &HeaderMap,
    written: Written,
) -> Result<Response, ApiError> {
    let may = may(who, &export.vessels)?;
    let (gzip, named, options) = (export.gzip, state.shore.people.vessels(), export.options);
    let name = format!("{}.{}{}", export.file_name(), written.ending, if gzip { ".gz" } else { "" });
    let find = move |reader: &mut Reader| export.selection(reader, &named, &may)?.known(reader);
    let selection = Arc::new(state.shore.history.ask(find).await?);
    let Written { media, write, version, .. } = written;
    let (of_write, of_version) = (Arc::clone(&selection), Arc::clone(&selection));
    let download = Download {
        question: format!("{name} {selection:?} {options:?}"),
        name,
        media,
        gzip,
        write: Arc::new(move |data, out| write(data, &of_write, out).map(drop)),
        version: Arc::new(move |data| version(data, &of_version)),
    };
    download.answer(state, asked).await
}
