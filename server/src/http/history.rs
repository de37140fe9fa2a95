//! The fleet as it is and as it was, for programs.

use super::error::ApiError;
use super::guard::Who;
use crate::shore::{AppState, History, Wanted};
use api::{ExportQuery, Recorded, Role, System, TrackPoint, TrackQuery};
use axum::Json;
use axum::body::{Body, Bytes};
use axum::extract::rejection::QueryRejection;
use axum::extract::{Path, Query, State};
use axum::http::header;
use axum::response::{IntoResponse, Response};
use futures_util::StreamExt as _;
use std::io::{self, Write};
use std::sync::Arc;
use tokio::sync::mpsc;

/// Bytes that are handed to the connection at once.
const CHUNK: usize = 64 * 1024;
/// Chunks that may wait for a slow reader; the export waits with them.
const CHUNKS: usize = 4;

/// `GET /api/v1/vessels`.
pub(crate) async fn vessels(
    State(state): State<AppState>,
    Who(who): Who,
) -> Result<Json<Vec<System>>, ApiError> {
    let wanted = Arc::new(Wanted { grants: who.grants, ..Wanted::default() });
    let systems = state.fleet.systems(wanted).await;
    systems.map(Json).ok_or_else(|| ApiError::unavailable("The server is stopping."))
}

/// `GET /api/v1/recorded`.
pub(crate) async fn recorded(
    State(state): State<AppState>,
    Who(who): Who,
) -> Result<Json<Vec<Recorded>>, ApiError> {
    let history = history(&state)?;
    let mut recorded = slow(move || history.recorded()).await?;
    recorded.retain(|series| who.grants.on(series.system).is_some());
    Ok(Json(recorded))
}

/// `GET /api/v1/vessels/{vessel}/track`.
pub(crate) async fn track(
    State(state): State<AppState>,
    Path(vessel): Path<u16>,
    query: Result<Query<TrackQuery>, QueryRejection>,
) -> Result<Json<Vec<TrackPoint>>, ApiError> {
    let Query(mut query) = query.map_err(|error| ApiError::bad_request(error.body_text()))?;
    if query.to_us < query.from_us {
        return Err(ApiError::bad_request("to_us is before from_us."));
    }
    query.points = Some(query.points.unwrap_or(2_000).clamp(2, 20_000));
    let history = history(&state)?;
    Ok(Json(slow(move || history.track(vessel, &query)).await?))
}

/// `GET /api/v1/export.csv`.
pub(crate) async fn export(
    State(state): State<AppState>,
    Who(who): Who,
    query: Result<Query<ExportQuery>, QueryRejection>,
) -> Result<Response, ApiError> {
    let Query(query) = query.map_err(|error| ApiError::bad_request(error.body_text()))?;
    let may = move |vessel: u16| who.grants.on(vessel) >= Some(Role::Researcher);
    if let Some(vessel) = query.vessel.filter(|vessel| !may(*vessel)) {
        return Err(ApiError::forbidden(format!(
            "Exporting data of vessel {vessel} takes the role researcher."
        )));
    }
    let letters = |letter: &char| letter.is_ascii_alphanumeric();
    let name: String = query.message.chars().filter(letters).take(40).collect();
    let history = history(&state)?;
    let (chunks, taken) = mpsc::channel(CHUNKS);
    tokio::task::spawn_blocking(move || {
        let mut out = Chunks { buffer: Vec::with_capacity(CHUNK), chunks: chunks.clone() };
        let outcome = history.export(&query, &may, &mut out).and_then(|()| Ok(out.flush()?));
        if let Err(error) = outcome {
            tracing::warn!(%error, "an export was cut");
            // Ends the connection without the mark of a whole answer, so that nobody takes it for one.
            chunks.blocking_send(Err(io::Error::other(error.to_string()))).ok();
        }
    });
    let body = first_then_rest(taken).await?;
    let headers = [
        (header::CONTENT_TYPE, "text/csv; charset=utf-8".to_owned()),
        (header::CONTENT_DISPOSITION, format!("attachment; filename=\"{name}.csv\"")),
    ];
    Ok((headers, body).into_response())
}

type Chunk = Result<Bytes, io::Error>;

/// An export that fails before its first byte is an ordinary error with its reason.
async fn first_then_rest(mut taken: mpsc::Receiver<Chunk>) -> Result<Body, ApiError> {
    let first = match taken.recv().await {
        Some(Err(error)) => return Err(ApiError::bad_request(error.to_string())),
        first => first,
    };
    let rest = futures_util::stream::unfold((first, taken), |(first, mut taken)| async move {
        let chunk = match first {
            Some(chunk) => chunk,
            None => taken.recv().await?,
        };
        Some((chunk, (None, taken)))
    });
    // The compression asks again after the end.
    Ok(Body::from_stream(rest.fuse()))
}

/// Writes into the channel, and waits while it is full.
struct Chunks {
    buffer: Vec<u8>,
    chunks: mpsc::Sender<Chunk>,
}

impl Write for Chunks {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.buffer.extend_from_slice(bytes);
        if self.buffer.len() >= CHUNK {
            self.flush()?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.buffer.is_empty() {
            return Ok(());
        }
        let full = std::mem::replace(&mut self.buffer, Vec::with_capacity(CHUNK));
        let nobody = |_| io::Error::new(io::ErrorKind::BrokenPipe, "nobody reads the export any more");
        self.chunks.blocking_send(Ok(full.into())).map_err(nobody)
    }
}

fn history(state: &AppState) -> Result<Arc<dyn History>, ApiError> {
    state.history.clone().ok_or_else(|| ApiError::unavailable("This server keeps no history."))
}

/// Runs what takes long where that is allowed.
async fn slow<R: Send + 'static>(
    work: impl FnOnce() -> anyhow::Result<R> + Send + 'static,
) -> Result<R, ApiError> {
    let done = tokio::task::spawn_blocking(work).await.map_err(|error| ApiError::internal(&error))?;
    done.map_err(|error| ApiError::internal(&format!("{error:#}")))
}
