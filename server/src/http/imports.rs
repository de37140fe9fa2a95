//! Uploads of logs, and of tables of detections, of which packets are made.
//!
//! A log may have data of any vessel, which stay in the archive: so it takes the role operator on all vessels. The body is
//! the file itself, plain or compressed by gzip, written to the disk as it arrives.

use crate::AppState;
use crate::web::{ApiError, InPath, QueryParams, Remote, Who};
use api::{Import, ImportQuery, Said, say};
use axum::Json;
use axum::body::Body;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, header};
use futures_util::StreamExt as _;
use research::Carriers;
use shore::history::heard;
use shore::history::imports::{RESERVED_BYTES, Upload};
use shore::identity::{ASK_PATIENCE, Line, Principal};
use shore::register::Called;
use std::io::ErrorKind;
use std::time::{Duration, Instant};
use store::Beginning;

/// Bytes that are written at once.
const BLOCK: usize = 1 << 20;
/// Characters of a name.
const NAME: std::ops::RangeInclusive<usize> = 1..=200;
/// An upload that is slower than this, bytes per second, is aborted after a minute, as others wait.
const SLOWEST: u64 = 4_096;

/// `GET /api/v1/import`.
pub(crate) async fn list(State(state): State<AppState>) -> Json<Vec<Import>> {
    Json(state.shore.imports.all())
}

/// `GET /api/v1/import/{id}`.
pub(crate) async fn one(
    State(state): State<AppState>,
    InPath(id): InPath<u32>,
) -> Result<Json<Import>, ApiError> {
    let import = state.shore.imports.get(id).map(Json);
    import.ok_or_else(|| ApiError::not_found(say("There is no such import; GET /api/v1/import lists them.")))
}

/// `POST /api/v1/import/{id}/cancel`.
pub(crate) async fn cancel(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    InPath(id): InPath<u32>,
) -> Result<Json<Import>, ApiError> {
    let missing = || ApiError::not_found(say("There is no such import; GET /api/v1/import lists them."));
    let import = state.shore.imports.get(id).ok_or_else(missing)?;
    let subject = format!("{} (import {id})", import.name);
    state.shore.people.record(vec![line(&who, remote, "log.import.cancel", subject)], ASK_PATIENCE).await?;
    if !state.shore.imports.cancel(id, who.name) {
        let text = say("This import is at its end: GET /api/v1/import tells how it went.");
        return Err(ApiError::new(StatusCode::CONFLICT, "import_ended", text));
    }
    state.shore.imports.get(id).map(Json).ok_or_else(missing)
}

/// `POST /api/v1/import`.
pub(crate) async fn upload(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    headers: HeaderMap,
    QueryParams(query): QueryParams<ImportQuery>,
    body: Body,
) -> Result<Json<Import>, ApiError> {
    let name = query.name;
    if !NAME.contains(&name.chars().count()) || name.chars().any(char::is_control) {
        let (least, most) = NAME.into_inner();
        return Err(ApiError::bad_request(
            say("name: give the file's name, {least} to {most} letters")
                .with("least", least)
                .with("most", most),
        ));
    }
    let most = state.config.http.max_upload_mib << 20;
    let announced = headers.get(header::CONTENT_LENGTH).and_then(|length| length.to_str().ok()?.parse().ok());
    if announced.is_some_and(|length: u64| length > most) {
        return Err(too_long(most));
    }
    let upload = state.shore.imports.upload().map_err(|error| ApiError::internal(&error))?;
    let Some(upload) = upload else {
        let text = say("Another log is being uploaded or imported: GET /api/v1/import shows how far it is.");
        return Err(ApiError::new(StatusCode::CONFLICT, "import_running", text));
    };
    let room = upload.room_bytes()?;
    if announced.is_some_and(|length| length > room) {
        return Err(no_room(room));
    }
    let upload = receive(upload, body, most).await?;
    let upload = if upload.is_table {
        packets(&state, upload, query.vessel).await?
    } else if query.vessel.is_some() {
        let text = say("vessel: a log says itself which vessels it is of; leave it out");
        return Err(ApiError::bad_request(text));
    } else {
        upload
    };
    let subject = format!("{name} ({} bytes)", upload.bytes);
    state.shore.people.record(vec![line(&who, remote, "log.import", subject)], ASK_PATIENCE).await?;
    let (recorder, stop) = (state.shore.recorder.clone(), state.shore.stop.clone());
    Ok(Json(state.shore.imports.begin(upload, name, who.name, recorder, &state.shore.tasks, stop)))
}

/// Makes packets of a table of detections: all of it, or nothing.
async fn packets(state: &AppState, mut upload: Upload, vessel: Option<String>) -> Result<Upload, ApiError> {
    let ((_, study), named) = (state.shore.register.study().await?, state.shore.people.vessels());
    let work = move || {
        let called = Called::new(&named);
        let address = |text: &str| called.carrier(text, &study);
        let system = vessel.as_deref().map(address).transpose();
        let system = system.map_err(|said| ApiError::bad_request(said.of_field("vessel")))?;
        let carriers = Carriers { system, address: &address, study: &study };
        let read = upload.replace(|file, out| heard::packets(file, &carriers, out));
        let read = read.map_err(|error| match error.kind() {
            ErrorKind::StorageFull | ErrorKind::QuotaExceeded => no_room(0),
            ErrorKind::InvalidData => unreadable(Said::as_is(error.to_string())),
            _ => ApiError::internal(&error),
        })?;
        heard::refusal(&read).map_or(Ok(upload), |why| Err(unreadable(why)))
    };
    tokio::task::spawn_blocking(work).await.map_err(|error| ApiError::internal(&error))?
}

fn unreadable(text: impl Into<Said>) -> ApiError {
    ApiError::new(StatusCode::UNPROCESSABLE_ENTITY, "bad_table", text)
}

/// The line in the audit log for this action of a user.
fn line(who: &Principal, remote: Remote, action: &'static str, subject: String) -> Line {
    let (address, outcome) = (remote.address.to_string(), "done".to_owned());
    Line { actor: who.actor(), address, action, subject, outcome }
}

/// Writes the body to the disk, and checks early whether it is a log at all.
async fn receive(mut upload: Upload, body: Body, most: u64) -> Result<Upload, ApiError> {
    let begun = Instant::now();
    let mut chunks = body.into_data_stream();
    let mut block = Vec::with_capacity(BLOCK);
    let mut looked_at = false;
    loop {
        let chunk = chunks.next().await;
        let ended = chunk.is_none();
        if let Some(chunk) = chunk {
            let cut = |_| {
                ApiError::bad_request(say("The upload was cut off; nothing was imported. Upload it again."))
            };
            block.extend_from_slice(&chunk.map_err(cut)?);
        }
        let bytes = upload.bytes + block.len() as u64;
        if bytes > most {
            return Err(too_long(most));
        }
        if begun.elapsed() > Duration::from_secs(60 + bytes / SLOWEST) {
            let text = say("The upload is too slow; import the file by `lutra-server import` on the server.");
            return Err(ApiError::new(StatusCode::REQUEST_TIMEOUT, "too_slow", text));
        }
        if block.len() >= BLOCK || ended {
            let look = !looked_at;
            looked_at = true;
            let written = std::mem::replace(&mut block, Vec::with_capacity(BLOCK));
            let work = move || write(upload, &written, look);
            upload =
                tokio::task::spawn_blocking(work).await.map_err(|error| ApiError::internal(&error))??;
        }
        if ended {
            return Ok(upload);
        }
    }
}

fn write(mut upload: Upload, block: &[u8], look: bool) -> Result<Upload, ApiError> {
    let room = upload.room_bytes()?;
    if block.len() as u64 > room {
        return Err(no_room(room));
    }
    upload.write(block).map_err(|error| match error.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => no_room(0),
        _ => ApiError::internal(&error),
    })?;
    if !look {
        return Ok(upload);
    }
    upload.is_table = research::is_detections(block).map_err(unreadable)?;
    if upload.is_table {
        return Ok(upload);
    }
    match upload.beginning()? {
        Beginning::Log => Ok(upload),
        Beginning::Cut { bytes } => Err(cut(bytes)),
        Beginning::Other => Err(no_log(block)),
    }
}

fn cut(bytes: u64) -> ApiError {
    let text = say(
        "There is no whole packet in the file: it ends at byte {bytes}, within its first packet or packed block. Nothing was imported. Copy the log from the vessel again.",
    );
    ApiError::new(StatusCode::UNSUPPORTED_MEDIA_TYPE, "no_packet", text.with("bytes", bytes))
}

fn no_log(start: &[u8]) -> ApiError {
    let what = match start {
        [] => say("The upload is empty."),
        [b'B', b'Z', b'h', ..] => say("This is packed by bzip2: unpack it with `bunzip2` first."),
        [b'P', b'K', 3, 4, ..] => {
            say("This is a zip archive: unpack it and upload the logs in it one by one.")
        }
        [0xFD, b'7', b'z', b'X', b'Z', ..] => say("This is packed by xz: unpack it with `unxz` first."),
        _ => say(
            "This is not an IMC log: there is no packet in its first MiB. Upload Data.lsf, Data.lsf.gz or Data.lsf.zst.",
        ),
    };
    ApiError::new(StatusCode::UNSUPPORTED_MEDIA_TYPE, "no_log", what)
}

fn too_long(most: u64) -> ApiError {
    let text = say("The upload is larger than {most} MiB (http.max_upload_mib); import it by `lutra-server import` on the server.").with("most", most >> 20);
    ApiError::new(StatusCode::PAYLOAD_TOO_LARGE, "too_large", text)
}

fn no_room(room: u64) -> ApiError {
    let text = say("The server's disk has room for {room} MiB of uploads; {reserve} MiB more are kept for recording. Make room first.").with("room", room >> 20).with("reserve", RESERVED_BYTES >> 20);
    ApiError::new(StatusCode::INSUFFICIENT_STORAGE, "no_room", text)
}
