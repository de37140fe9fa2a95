//! Exports: streamed as they are written, in constant memory, whole or visibly cut.

use crate::AppState;
use crate::web::{ApiError, QueryParams, Who, extract};
use api::{DetectionsFileQuery, ExportQuery, ExportSize, LogQuery, Role};
use axum::Json;
use axum::body::{Body, Bytes};
use axum::extract::State;
use axum::http::header;
use axum::response::{IntoResponse, Response};
use flate2::Compression;
use flate2::write::GzEncoder;
use futures_util::StreamExt as _;
use serde_json::Value;
use shore::history::export::{self, Export};
use shore::identity::Principal;
use std::io::{self, Write};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use store::{DetectionsWanted, Exported, Reader, Selection, StoreError};
use tokio::runtime::Handle;
use tokio::sync::mpsc;

/// Bytes that are handed to the connection at once.
const CHUNK: usize = 64 * 1024;
/// Chunks that may wait for a slow reader; the export waits with them.
const CHUNKS: usize = 4;
/// A reader that takes nothing for so long is let go: an export holds a place and a view of the database.
const PATIENCE: Duration = Duration::from_mins(1);

/// `GET /api/v1/export.csv`.
pub(crate) async fn csv(
    State(state): State<AppState>,
    Who(who): Who,
    QueryParams(query): QueryParams<ExportQuery>,
) -> Result<Response, ApiError> {
    let export = Export::csv(&query)?;
    let options = export.options;
    let write = move |data: &Path, selection: &Selection, out: &mut dyn Write| {
        store::export_csv(data, selection, &options, out)
    };
    stream(&state, who, export, ("csv", "text/csv; charset=utf-8"), write).await
}

/// `GET /api/v1/export.lsf`.
pub(crate) async fn lsf(
    State(state): State<AppState>,
    Who(who): Who,
    QueryParams(query): QueryParams<LogQuery>,
) -> Result<Response, ApiError> {
    let export = Export::log(&query)?;
    stream(&state, who, export, ("lsf", "application/octet-stream"), store::export_lsf).await
}

/// `GET /api/v1/detections.csv`.
pub(crate) async fn detections(
    State(state): State<AppState>,
    Who(who): Who,
    QueryParams(query): QueryParams<DetectionsFileQuery>,
) -> Result<Response, ApiError> {
    let range = match (query.from_us, query.to_us) {
        (None, None) => store::TimeRange::ALL,
        (from_us, to_us) => extract::range(from_us.unwrap_or(0), to_us.unwrap_or(extract::LAST_US))?,
    };
    let (vessels, tags) = (export::vessels(query.vessel.as_deref())?, export::tags(query.tag.as_deref())?);
    let named = state.shore.people.vessels();
    let names = named.iter().map(|vessel| (vessel.address, vessel.name.clone())).collect();
    let may = may(who, &vessels)?;
    let gzip = query.gzip.unwrap_or(false);
    let name = format!("detections.csv{}", if gzip { ".gz" } else { "" });
    let write = move |data: &Path, out: &mut dyn Write| {
        let systems = systems(&mut Reader::open(data)?, &vessels, &may)?;
        let wanted = DetectionsWanted { systems: Some(systems), range, came_from: None, tags };
        store::export_detections(data, &wanted, &names, out)
    };
    send(&state, name, gzip, "text/csv; charset=utf-8", write).await
}

/// The vessels that are asked for, or all that `may` admits.
pub(super) fn systems(
    reader: &mut Reader,
    vessels: &[u16],
    may: &dyn Fn(u16) -> bool,
) -> store::Result<Vec<imc::Address>> {
    if !vessels.is_empty() {
        return Ok(vessels.iter().copied().map(imc::Address).collect());
    }
    let known = reader.systems()?.into_iter().map(|system| system.address);
    Ok(known.filter(|address| may(address.0)).collect())
}

/// `GET /api/v1/export.json`: what stands in the columns of the CSV.
pub(crate) async fn description(
    State(state): State<AppState>,
    Who(who): Who,
    QueryParams(query): QueryParams<ExportQuery>,
) -> Result<Json<Value>, ApiError> {
    let export = Export::csv(&query)?;
    let may = may(who, &export.vessels)?;
    let describe = move |reader: &mut Reader| {
        let options = export.options;
        let selection = export.selection(reader, &may)?;
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
    let history = state.shore.history.clone();
    let measure = move |reader: &mut Reader| {
        let options = export.options;
        let selection = export.selection(reader, &may)?;
        store::measure_csv(history.data(), &selection, &options)
    };
    let Exported { rows, bytes } = state.shore.history.ask(measure).await?;
    Ok(Json(ExportSize { rows, bytes }))
}

/// Whose data the person may take out.
fn may(who: Principal, vessels: &[u16]) -> Result<impl Fn(u16) -> bool + Send + 'static, ApiError> {
    let may = move |vessel: u16| who.grants.on(vessel) >= Some(Role::Researcher);
    match vessels.iter().find(|vessel| !may(**vessel)) {
        None => Ok(may),
        Some(vessel) => Err(ApiError::forbidden(format!(
            "vessel: exporting data of vessel {vessel} takes the role researcher there. Ask an admin."
        ))),
    }
}

async fn stream(
    state: &AppState,
    who: Principal,
    export: Export,
    (ending, media): (&str, &'static str),
    write: impl FnOnce(&Path, &Selection, &mut dyn Write) -> store::Result<Exported> + Send + 'static,
) -> Result<Response, ApiError> {
    let may = may(who, &export.vessels)?;
    let gzip = export.gzip;
    let name = format!("{}.{ending}{}", export.file_name(), if gzip { ".gz" } else { "" });
    let write = move |data: &Path, out: &mut dyn Write| {
        let selection = export.selection(&mut Reader::open(data)?, &may)?;
        write(data, &selection, out)
    };
    send(state, name, gzip, media, write).await
}

/// Sends what `write` writes as a file, while it writes.
async fn send(
    state: &AppState,
    name: String,
    gzip: bool,
    media: &'static str,
    write: impl FnOnce(&Path, &mut dyn Write) -> store::Result<Exported> + Send + 'static,
) -> Result<Response, ApiError> {
    let Ok(place) = Arc::clone(&state.shore.history.exports).try_acquire_owned() else {
        return Err(ApiError::busy("As many exports as may are running; try again in a moment."));
    };
    let history = state.shore.history.clone();
    let (chunks, taken) = mpsc::channel(CHUNKS);
    let runtime = Handle::current();
    tokio::task::spawn_blocking(move || {
        let _place = place;
        let out = Chunks {
            buffer: Vec::with_capacity(CHUNK),
            sender: chunks.clone(),
            runtime: runtime.clone(),
            is_cut: false,
        };
        if let Err(error) = finish(out, gzip, |out| write(history.data(), out).map(drop)) {
            tracing::info!(%error, "an export was cut or refused");
            // Ends the connection without the mark of a whole answer, so that nobody takes it for one.
            runtime.block_on(tokio::time::timeout(PATIENCE, chunks.send(Err(error)))).ok();
        }
    });
    let body = first_then_rest(taken).await?;
    let media = if gzip { "application/gzip" } else { media };
    let headers = [
        (header::CONTENT_TYPE, media.to_owned()),
        (header::CONTENT_DISPOSITION, format!("attachment; filename=\"{name}\"")),
    ];
    Ok((headers, body).into_response())
}

/// Writes, packed if wanted. What was cut gets no ending, by which programs that unpack notice.
fn finish(
    mut out: Chunks,
    gzip: bool,
    write: impl FnOnce(&mut dyn Write) -> store::Result<()>,
) -> store::Result<()> {
    let unwritable = |source| StoreError::Io { path: "the export".into(), source };
    if !gzip {
        let written = write(&mut out);
        let flushed = out.flush().map_err(unwritable);
        return written.and(flushed);
    }
    // The quickest: the link is seldom as slow as a better one would be.
    let mut packed = GzEncoder::new(out, Compression::fast());
    if let Err(error) = write(&mut packed) {
        packed.flush().ok();
        // The encoder ends the file when it is dropped.
        packed.get_mut().is_cut = true;
        return Err(error);
    }
    packed.finish().and_then(|mut out| out.flush()).map_err(unwritable)
}

type Chunk = Result<Bytes, StoreError>;

/// An export that fails before its first byte is an ordinary error with its reason.
async fn first_then_rest(mut taken: mpsc::Receiver<Chunk>) -> Result<Body, ApiError> {
    let first = match taken.recv().await {
        Some(Err(error)) => return Err(error.into()),
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
    sender: mpsc::Sender<Chunk>,
    runtime: Handle,
    /// Whether nothing may follow.
    is_cut: bool,
}

impl Write for Chunks {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.is_cut {
            return Err(io::ErrorKind::BrokenPipe.into());
        }
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
        let sending = tokio::time::timeout(PATIENCE, self.sender.send(Ok(full.into())));
        match self.runtime.block_on(sending) {
            Ok(Ok(())) => Ok(()),
            Ok(Err(_)) => Err(io::Error::new(io::ErrorKind::BrokenPipe, "nobody reads the export any more")),
            Err(_) => Err(io::Error::new(io::ErrorKind::TimedOut, "nobody read the export for a minute")),
        }
    }
}
