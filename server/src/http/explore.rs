//! Detections counted, for plots.
//!
//! Counting takes memory for each detection, so `shore` limits the number of concurrent counts. Further requests wait in a
//! queue; after too long they are answered with 503 and `Retry-After`. The page repeats them automatically.

use crate::AppState;
use crate::web::{ApiError, QueryParams, Who, extract};
use api::{DetectionsFileQuery, DetectionsSummary, DetectionsSummaryQuery, ExportSize, Wording, say};
use axum::Json;
use axum::extract::State;
use shore::history::explore::{self, FoundRanks, Prepared};
use shore::history::heard::HeardFile;
use shore::history::size::{self, Measured};
use shore::history::{Places, export};
use std::collections::BTreeMap;
use std::time::Duration;
use store::{DetectionsWanted, Reader, StoreError, TimeRange};
use tokio::sync::OwnedSemaphorePermit;

/// How long a size waits for data that are not read yet, before the client must ask again.
const PATIENCE: Duration = Duration::from_secs(2);
/// `Retry-After` (s).
const AGAIN_S: u64 = 2;

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
        return Err(ApiError::forbidden(
            say("vessel: you may not see vessel {vessel}. Ask an admin.").with("vessel", vessel),
        ));
    }
    let named = state.shore.people.vessels();
    let (_, study) = state.shore.register.study().await?;
    let history = &state.shore.history;
    let explorer = history.explorer.clone();
    let prepare = move |reader: &mut Reader| {
        let systems = export::systems(reader, &vessels, &named, &may)?;
        let question = explore::question(&query, &systems, &study)?;
        Ok((explorer.prepare(reader, question, explore::PATIENCE)?, study))
    };
    let (prepared, study) = history.ask(prepare).await?;
    let explorer = history.explorer.clone();
    counted(&history.counts, move || explorer.summary(&prepared, &study)).await.map(Json)
}

/// Counts on a thread for blocking work, in its turn.
async fn counted<R: Send + 'static>(
    counts: &Places,
    count: impl FnOnce() -> R + Send + 'static,
) -> Result<R, ApiError> {
    let place =
        place(counts, say("Too many people are counting detections now; try again in a moment.")).await?;
    let count = move || {
        let _place = place;
        count()
    };
    Ok(tokio::task::spawn_blocking(count).await.map_err(|_| StoreError::Cancelled)?)
}

async fn place(places: &Places, busy: Wording) -> Result<OwnedSemaphorePermit, ApiError> {
    places.take().await.ok_or_else(|| ApiError::busy_for(AGAIN_S, busy))
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
    let names: BTreeMap<u16, String> =
        named.iter().map(|vessel| (vessel.address, vessel.name.clone())).collect();
    let (_, study) = state.shore.register.study().await?;
    let file = HeardFile::new(query.format.as_deref(), query.spreadsheet.as_deref())?;
    let asked = summary_of(query);
    let history = state.shore.history.clone();
    let place =
        place(&history.sizes, say("Too many sizes are being worked out; try again in a moment.")).await?;
    let explorer = history.explorer.clone();
    let prepare = move |reader: &mut Reader| {
        let systems = export::systems(reader, &vessels, &named, &may)?;
        let question = explore::question(&asked, &systems, &study)?;
        Ok((explorer.prepare(reader, question, PATIENCE)?, systems, study))
    };
    let (prepared, systems, study) = history.ask(prepare).await?;
    let explorer = history.explorer.clone();
    let count = move || (explorer.ranks(&prepared, &study, size::PARTS), prepared, study);
    let (found, Prepared { question, .. }, study) = counted(&history.counts, count).await?;
    let ranks = match found {
        FoundRanks::Whole(ranks) => ranks,
        FoundRanks::Reading => return Err(still_reads()),
        FoundRanks::TooMany => {
            return Err(ApiError::bad_request(say(
                "there are more detections than the server counts beforehand; choose a shorter time, or download \
                 without knowing the size",
            )));
        }
    };
    let range = TimeRange { from_us: question.from_us, to_us: question.to_us };
    let wanted = DetectionsWanted { systems: Some(systems), range, came_from: None, tags: question.tags };
    let file = HeardFile { narrowed: question.narrowed, ..file };
    let data = history.data().to_owned();
    let measure = move |_: &mut Reader| {
        let _place = place;
        Measured { wanted: &wanted, names: &names, study: &study, file: &file }.size(&data, &ranks)
    };
    history.ask(measure).await?.map(Json).ok_or_else(still_reads)
}

fn still_reads() -> ApiError {
    ApiError::busy_for(AGAIN_S, say("The server still reads these detections; try again in a moment."))
}

/// The query that counts the detections of a file.
fn summary_of(query: DetectionsFileQuery) -> DetectionsSummaryQuery {
    DetectionsSummaryQuery {
        from_us: query.from_us,
        to_us: query.to_us,
        vessel: None,
        tag: query.tag,
        project: query.project,
        area: query.area,
        whole_axis: None,
    }
}
