//! Detections counted, for plots.

use crate::AppState;
use crate::web::{ApiError, QueryParams, Who, extract};
use api::{DetectionsFileQuery, DetectionsSummary, DetectionsSummaryQuery, ExportSize};
use axum::Json;
use axum::extract::State;
use research::{Narrowed, Question, Study};
use shore::history::heard::{self, HeardFile, SampleBounds};
use shore::history::{History, explore, export};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};
use store::{DetectionsWanted, Reader, StoreError, TimeRange};

/// So much of a file is written to learn how long its rows are, bytes.
const SAMPLE_BYTES: u64 = 1 << 17;
/// So many detections are read for that at most.
const SAMPLE_READ: u64 = 50_000;
/// So long that may take.
const SAMPLE_TIME: Duration = Duration::from_secs(1);
/// So long may be waited for what is not read yet.
const PATIENCE: Duration = Duration::from_secs(2);

/// `GET /api/v1/detections/summary`.
pub(crate) async fn summary(
    State(state): State<AppState>,
    Who(who): Who,
    QueryParams(query): QueryParams<DetectionsSummaryQuery>,
) -> Result<Json<DetectionsSummary>, ApiError> {
    extract::range(query.from_us.unwrap_or(0), query.to_us.unwrap_or(extract::LAST_US))?;
    let vessels = export::list(query.vessel.as_deref());
    let may = move |vessel: u16| who.grants.on(vessel).is_some();
    if let Some(vessel) = export::addresses(&vessels).find(|vessel| !may(*vessel)) {
        return Err(ApiError::forbidden(format!("vessel: you may not see vessel {vessel}. Ask an admin.")));
    }
    let named = state.shore.people.vessels();
    let (_, study) = state.shore.register.study().await?;
    let explorer = state.shore.history.explorer.clone();
    let ask = move |reader: &mut Reader| {
        let systems = export::systems(reader, &vessels, &named, &may)?;
        explorer.summary(reader, &explore::question(&query, &systems, &study)?, &study)
    };
    Ok(Json(state.shore.history.ask(ask).await?))
}

/// `GET /api/v1/detections/size`.
pub(crate) async fn size(
    State(state): State<AppState>,
    Who(who): Who,
    QueryParams(query): QueryParams<DetectionsFileQuery>,
) -> Result<Json<ExportSize>, ApiError> {
    extract::range(query.from_us.unwrap_or(0), query.to_us.unwrap_or(extract::LAST_US))?;
    let vessels = export::list(query.vessel.as_deref());
    let may = super::export::may(who, &vessels)?;
    let named = state.shore.people.vessels();
    let (_, study) = state.shore.register.study().await?;
    let file = HeardFile::new(query.format.as_deref(), query.spreadsheet.as_deref())?;
    let asked = DetectionsSummaryQuery {
        from_us: query.from_us,
        to_us: query.to_us,
        vessel: None,
        tag: query.tag,
        project: query.project,
        area: query.area,
        whole_axis: None,
    };
    // It is as much work as a small export.
    let Ok(place) = Arc::clone(&state.shore.history.exports).try_acquire_owned() else {
        return Err(ApiError::busy("As many exports as may are running; try again in a moment."));
    };
    let history = state.shore.history.clone();
    let ask = move |reader: &mut Reader| {
        let _place = place;
        let systems = export::systems(reader, &vessels, &named, &may)?;
        let question = explore::question(&asked, &systems, &study)?;
        let names = named.iter().map(|vessel| (vessel.address, vessel.name.clone())).collect();
        let file = HeardFile { narrowed: question.narrowed.clone(), ..file };
        measured(&history, reader, &question, systems, &names, &study, &file)
    };
    match state.shore.history.ask(ask).await? {
        Some(size) => Ok(Json(size)),
        None => Err(ApiError::busy("The server still reads these detections; try again in a moment.")),
    }
}

/// How large a file will be; `None` where the server still counts. Its detections are counted by the explorer, and how long their
/// rows are is learnt from the first ones.
fn measured(
    history: &History,
    reader: &mut Reader,
    question: &Question,
    systems: Vec<imc::Address>,
    names: &BTreeMap<u16, String>,
    study: &Study,
    file: &HeardFile,
) -> store::Result<Option<ExportSize>> {
    let counted = history.explorer.summary_within(reader, question, study, PATIENCE)?;
    if counted.left_out_before_us.is_some() {
        let text = "there are more detections than the server counts beforehand; choose a shorter time, or \
                    download without knowing the size";
        return Err(StoreError::Query(text.into()));
    }
    if counted.read_from_us.is_some() {
        return Ok(None);
    }
    let range = TimeRange { from_us: question.from_us, to_us: question.to_us };
    let wanted =
        DetectionsWanted { systems: Some(systems), range, came_from: None, tags: question.tags.clone() };
    let sample = |wanted: &DetectionsWanted, file: &HeardFile| {
        let until = Instant::now() + SAMPLE_TIME;
        let bounds = SampleBounds { detections: SAMPLE_READ, bytes: SAMPLE_BYTES, until };
        heard::sample(history.data(), wanted, names, study, file, bounds)
    };
    let mut found = sample(&wanted, file)?;
    if found.is_whole {
        return Ok(Some(ExportSize { rows: found.begin.rows, bytes: found.begin.bytes }));
    }
    if found.wanted == 0 {
        // The first ones are not among those that are wanted; rows of others are about as long.
        let all = HeardFile { narrowed: Narrowed::default(), ..file.clone() };
        found = sample(&DetectionsWanted { tags: Vec::new(), ..wanted }, &all)?;
    }
    let of_wanted = |part: u64| (counted.detections as f64 * part as f64 / found.wanted.max(1) as f64) as u64;
    Ok(Some(ExportSize { rows: of_wanted(found.begin.rows), bytes: of_wanted(found.begin.bytes) }))
}
