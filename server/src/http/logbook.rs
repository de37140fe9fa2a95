//! The log book, for programs and its page.

use crate::AppState;
use crate::web::{ApiError, InBody, InPath, QueryParams, Remote, Who, WholeBody, extract};
use api::{
    LogNote, LogNoteChange, LogNoteQuery, LogNoteRequest, LogNoteRevision, LogNotes, LogNotesFileQuery,
    LogNotesQuery, Role, say,
};
use axum::Json;
use axum::body::{Body, Bytes};
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use futures_util::stream;
use serde::Deserialize;
use shore::Shore;
use shore::history::export;
use shore::identity::Principal;
use shore::logbook::{CSV_HEAD, Cursor, Filter, Logbook};

/// Notes that are read at once for a file.
const FILE_PAGE: u32 = 500;
/// Most characters of a search text.
const SEARCH: usize = 200;

/// `GET /api/v1/logbook`.
pub(crate) async fn list(
    State(state): State<AppState>,
    Who(who): Who,
    QueryParams(query): QueryParams<LogNotesQuery>,
) -> Result<Json<LogNotes>, ApiError> {
    let count = extract::number("limit", query.limit, 100, 1..=500)? as u32;
    let before = query.before.as_deref().map(Logbook::cursor).transpose()?;
    let LogNotesQuery { vessel, general, from_us, to_us, text, withdrawn, .. } = query;
    let file = LogNotesFileQuery { vessel, general, from_us, to_us, text, withdrawn };
    let filter = filter(&state.shore, &who, Role::Viewer, file).await?;
    Ok(Json(state.shore.logbook.page(&who, filter, before, count).await?))
}

/// `GET /api/v1/logbook.csv`.
pub(crate) async fn csv(
    State(state): State<AppState>,
    Who(who): Who,
    QueryParams(query): QueryParams<LogNotesFileQuery>,
) -> Result<Response, ApiError> {
    let filter = filter(&state.shore, &who, Role::Researcher, query).await?;
    let logbook = state.shore.logbook.clone();
    // A failure before the first byte is an ordinary error with its reason.
    let first = file_page(&logbook, &who, &filter, None).await?;
    let rest = stream::try_unfold(Some(first), move |page| {
        let (logbook, who, filter) = (logbook.clone(), who.clone(), filter.clone());
        async move {
            let Some((bytes, next)) = page else { return Ok(None) };
            let after = match next {
                Some(before) => Some(file_page(&logbook, &who, &filter, Some(before)).await.map_err(cut)?),
                None => None,
            };
            Ok::<_, std::io::Error>(Some((Bytes::from(bytes), after)))
        }
    });
    let headers = [
        (header::CONTENT_TYPE, "text/csv; charset=utf-8"),
        (header::CONTENT_DISPOSITION, "attachment; filename=\"logbook.csv\""),
    ];
    Ok((headers, Body::from_stream(futures_util::StreamExt::fuse(rest))).into_response())
}

/// Ends the connection without the end mark of a complete answer, so that no client takes it for one.
fn cut(error: shore::Error) -> std::io::Error {
    tracing::info!(%error, "a file of the log book was cut");
    std::io::Error::other(error)
}

/// A page of the file, the first with its header, and where the next begins.
async fn file_page(
    logbook: &Logbook,
    who: &Principal,
    filter: &Filter,
    before: Option<Cursor>,
) -> shore::Result<(Vec<u8>, Option<Cursor>)> {
    let mut bytes = if before.is_none() { CSV_HEAD.as_bytes().to_vec() } else { Vec::new() };
    let LogNotes { notes, next } = logbook.page(who, filter.clone(), before, FILE_PAGE).await?;
    for note in &notes {
        shore::logbook::csv_row(&mut bytes, note);
    }
    Ok((bytes, next.as_deref().map(Logbook::cursor).transpose()?))
}

/// The requested filter, limited to vessels on which `who` has the role `least`.
async fn filter(
    shore: &Shore,
    who: &Principal,
    least: Role,
    query: LogNotesFileQuery,
) -> Result<Filter, ApiError> {
    let LogNotesFileQuery { vessel, general, from_us, to_us, text, withdrawn } = query;
    let mut vessels = Vec::new();
    for text in export::list(vessel.as_deref()) {
        vessels.extend(extract::vessel(shore, who, ("vessel", Some(&text))).await?.map(|vessel| vessel.0));
    }
    if let Some(vessel) = vessels.iter().find(|vessel| who.grants.on(**vessel) < Some(least)) {
        let text = say("vessel: this takes the role {least} on vessel {vessel}. Ask an admin.")
            .with("least", least)
            .with("vessel", vessel);
        return Err(ApiError::forbidden(text));
    }
    let (from_us, to_us) = match (from_us, to_us) {
        (None, None) => (None, None),
        (from_us, to_us) => {
            extract::range(from_us.unwrap_or(0), to_us.unwrap_or(extract::LAST_US))?;
            (from_us, to_us)
        }
    };
    let text = text.unwrap_or_default().trim().to_owned();
    if text.chars().count() > SEARCH {
        return Err(ApiError::bad_request(
            say("text: search for {most} characters at most").with("most", SEARCH),
        ));
    }
    let all = who.grants.everywhere() >= Some(least);
    let seen = (!all).then(|| who.grants.vessels_with(least).collect());
    let (general, withdrawn) = (general.unwrap_or(false), withdrawn.unwrap_or(false));
    Ok(Filter { seen, vessels, general, from_us, to_us, text, withdrawn })
}

/// `POST /api/v1/logbook`.
pub(crate) async fn write(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    QueryParams(sent): QueryParams<LogNoteQuery>,
    InBody(ask): InBody<LogNoteRequest>,
) -> Result<Json<LogNote>, ApiError> {
    Ok(Json(state.shore.logbook.write(&who, remote.address.to_string(), ask, sent).await?))
}

/// Path parameters of one note.
#[derive(Debug, Clone, Copy, Deserialize)]
pub(crate) struct OneNote {
    id: i64,
}

/// `PATCH /api/v1/logbook/{id}`.
pub(crate) async fn correct(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    InPath(OneNote { id }): InPath<OneNote>,
    InBody(change): InBody<LogNoteChange>,
) -> Result<Json<LogNote>, ApiError> {
    Ok(Json(state.shore.logbook.correct(&who, remote.address.to_string(), id, change).await?))
}

/// `DELETE /api/v1/logbook/{id}`.
pub(crate) async fn withdraw(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    InPath(OneNote { id }): InPath<OneNote>,
) -> Result<Json<LogNote>, ApiError> {
    Ok(Json(state.shore.logbook.withdraw(&who, remote.address.to_string(), id).await?))
}

/// `GET /api/v1/logbook/{id}/earlier`.
pub(crate) async fn earlier(
    State(state): State<AppState>,
    Who(who): Who,
    InPath(OneNote { id }): InPath<OneNote>,
) -> Result<Json<Vec<LogNoteRevision>>, ApiError> {
    Ok(Json(state.shore.logbook.earlier(&who, id).await?))
}

/// `PUT /api/v1/logbook/{id}/photo`: the body is the file.
pub(crate) async fn add_photo(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    InPath(OneNote { id }): InPath<OneNote>,
    body: Result<WholeBody, ApiError>,
) -> Result<Json<LogNote>, ApiError> {
    let WholeBody(bytes) = body.map_err(|error| match error.status {
        StatusCode::PAYLOAD_TOO_LARGE => ApiError::malformed(
            StatusCode::PAYLOAD_TOO_LARGE,
            say("photo: it has more than 4 MiB. Make it smaller and send it again."),
        ),
        _ => error,
    })?;
    let from = remote.address.to_string();
    Ok(Json(state.shore.logbook.add_photo(&who, from, id, bytes.into()).await?))
}

/// `GET /api/v1/logbook/{id}/photo`.
pub(crate) async fn photo(
    State(state): State<AppState>,
    Who(who): Who,
    InPath(OneNote { id }): InPath<OneNote>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let photo = state.shore.logbook.photo(&who, id).await?;
    // A photo never changes, and its access is checked each time: with the tag it is transferred only once.
    let tag = format!("\"{id}\"");
    let kept = [(header::CACHE_CONTROL, "private, no-cache".to_owned()), (header::ETAG, tag.clone())];
    if headers.get(header::IF_NONE_MATCH).is_some_and(|known| known.as_bytes() == tag.as_bytes()) {
        return Ok((StatusCode::NOT_MODIFIED, kept).into_response());
    }
    Ok((kept, [(header::CONTENT_TYPE, photo.media)], photo.bytes).into_response())
}
