//! Extractors for path and query, with validation: every refusal is JSON that names the parameter.

use super::error::ApiError;
use super::wrong::Wrong;
use super::{json, query};
use api::{Said, say};
use axum::extract::path::ErrorKind;
use axum::extract::rejection::PathRejection;
use axum::extract::{FromRequest, FromRequestParts, Path, Request};
use axum::http::request::Parts;
use axum::http::{HeaderMap, StatusCode, header};
use bytes::Bytes;
use imc::Address;
use serde::de::DeserializeOwned;
use shore::Shore;
use shore::identity::Principal;
use std::ops::RangeInclusive;
use store::{Order, TimeRange};

/// Times that JavaScript represents exactly (µs since 1970 UTC): from 1970 until 2255.
const TIMES_US: RangeInclusive<i64> = 0..=LAST_US;
/// The last of them.
pub(crate) const LAST_US: i64 = 9_007_199_254_740_991;
/// Most rows or events of one answer.
const ROWS: RangeInclusive<u32> = 1..=10_000;
/// Default number of rows of an answer.
const ROWS_UNASKED: u32 = 1_000;
/// Most rows that may be skipped.
const SKIP: RangeInclusive<u32> = 0..=100_000;

/// The query.
#[derive(Debug)]
pub(crate) struct QueryParams<T>(pub(crate) T);

impl<S: Send + Sync, T: DeserializeOwned> FromRequestParts<S> for QueryParams<T> {
    type Rejection = ApiError;
    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, ApiError> {
        let read = query::read(parts.uri.query().unwrap_or_default()).map(Self);
        read.map_err(|wrong| ApiError::bad_request(listed(wrong.said())))
    }
}

/// The path parameters.
#[derive(Debug)]
pub(crate) struct InPath<T>(pub(crate) T);

impl<S: Send + Sync, T: DeserializeOwned + Send> FromRequestParts<S> for InPath<T> {
    type Rejection = ApiError;
    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, ApiError> {
        let path = Path::<T>::from_request_parts(parts, state).await;
        path.map(|Path(path)| Self(path)).map_err(|error: PathRejection| match error {
            PathRejection::FailedToDeserializePathParams(error) => in_path(error.into_kind()),
            error => ApiError::internal(&error),
        })
    }
}

/// The refusal of what stands in a path.
fn in_path(kind: ErrorKind) -> ApiError {
    let wrong = match kind {
        ErrorKind::ParseErrorAtKey { key, value, expected_type } => {
            Wrong::value(&value, expected_type).below(&key)
        }
        ErrorKind::ParseErrorAtIndex { value, expected_type, .. }
        | ErrorKind::ParseError { value, expected_type } => Wrong::value(&value, expected_type),
        ErrorKind::DeserializeError { key, message, .. } => Wrong::new(Said::as_is(message)).below(&key),
        ErrorKind::InvalidUtf8InPathParam { key } => Wrong::new(say("this is not UTF-8")).below(&key),
        other => return ApiError::internal(&other),
    };
    ApiError::bad_request(say("in the address: {error}").with_said("error", wrong.said()))
}

/// A refusal with where all parameters stand.
fn listed(wrong: Said) -> Said {
    say("{error}; /api/v1/openapi.json lists all parameters").with_said("error", wrong).into()
}

/// The known vessel that a parameter names, by name or address, of those that `who` may see.
///
/// # Errors
/// It is not known, or `who` may not see it. The error names the parameter.
pub(crate) async fn vessel(
    shore: &Shore,
    who: &Principal,
    (name, text): (&str, Option<&str>),
) -> Result<Option<Address>, ApiError> {
    let Some(text) = text.map(str::trim).filter(|text| !text.is_empty()) else { return Ok(None) };
    let found = shore.vessel(text, &|vessel| who.grants.on(vessel).is_some()).await;
    found.map(Some).map_err(|error| {
        let error = ApiError::from(error);
        ApiError { text: error.text.of_field(name), ..error }
    })
}

/// A time.
///
/// # Errors
/// It is not valid.
pub(crate) fn time(name: &str, time_us: i64) -> Result<i64, ApiError> {
    if TIMES_US.contains(&time_us) {
        return Ok(time_us);
    }
    let (first, last) = TIMES_US.into_inner();
    Err(ApiError::bad_request(
        say("{name}: {time_us} is not a time: give µs since 1970 UTC, {first} to {last}")
            .with("name", name)
            .with("time_us", time_us)
            .with("first", first)
            .with("last", last),
    ))
}

/// A range of time.
///
/// # Errors
/// A time is not valid, or it ends before it begins.
pub(crate) fn range(from_us: i64, to_us: i64) -> Result<TimeRange, ApiError> {
    for (name, time_us) in [("from_us", from_us), ("to_us", to_us)] {
        time(name, time_us)?;
    }
    if to_us < from_us {
        return Err(ApiError::bad_request(say("to_us: is before from_us")));
    }
    Ok(TimeRange { from_us, to_us })
}

/// Turns a name into one that is valid in file names on any system.
pub(crate) fn file_name(name: &str) -> String {
    let plain = |letter: char| letter.is_ascii_alphanumeric() || "-_".contains(letter);
    name.chars().map(|letter| if plain(letter) { letter } else { '_' }).collect()
}

/// A number within bounds.
///
/// # Errors
/// It is not.
pub(crate) fn number(
    name: &str,
    asked: Option<u32>,
    unasked: u32,
    bounds: RangeInclusive<u32>,
) -> Result<usize, ApiError> {
    let number = asked.unwrap_or(unasked);
    if bounds.contains(&number) {
        return Ok(number as usize);
    }
    let (first, last) = bounds.into_inner();
    Err(ApiError::bad_request(
        say("{name}: {number} is not within {first} to {last}")
            .with("name", name)
            .with("number", number)
            .with("first", first)
            .with("last", last),
    ))
}

/// Order of an answer in time.
///
/// # Errors
/// It is neither.
pub(crate) fn order(order: Option<&str>) -> Result<Order, ApiError> {
    match order {
        None | Some("oldest") => Ok(Order::Oldest),
        Some("newest") => Ok(Order::Newest),
        Some(_) => Err(ApiError::bad_request(say("order: give `oldest` or `newest`, which comes first"))),
    }
}

/// A page of an answer.
///
/// # Errors
/// A number is not within its bounds.
pub(crate) fn page(limit: Option<u32>, skip: Option<u32>) -> Result<store::Page, ApiError> {
    let rows = number("limit", limit, ROWS_UNASKED, ROWS)?;
    Ok(shore::history::page(rows, number("skip", skip, 0, SKIP)?))
}

/// Most bytes of a request's body, as its route has it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BodyLimit(pub(crate) usize);

/// The whole body.
pub(crate) struct WholeBody(pub(crate) Bytes);

impl<S: Send + Sync> FromRequest<S> for WholeBody {
    type Rejection = ApiError;
    async fn from_request(request: Request, state: &S) -> Result<Self, ApiError> {
        let limit = request.extensions().get::<BodyLimit>().copied();
        let body = Bytes::from_request(request, state).await;
        body.map(Self).map_err(|error| match (error.status(), limit) {
            (StatusCode::PAYLOAD_TOO_LARGE, Some(BodyLimit(most))) => ApiError::malformed(
                StatusCode::PAYLOAD_TOO_LARGE,
                say("The body has more than {most} bytes, which is the most that is taken here; send less at a time")
                    .with("most", most),
            ),
            (status, _) => {
                ApiError::malformed(status, say("The body did not come whole; send the request once more"))
            }
        })
    }
}

/// JSON in the body; a refusal says what is wrong with it.
pub(crate) struct InBody<T>(pub(crate) T);

impl<S: Send + Sync, T: DeserializeOwned> FromRequest<S> for InBody<T> {
    type Rejection = ApiError;
    async fn from_request(request: Request, state: &S) -> Result<Self, ApiError> {
        if !is_json(request.headers()) {
            return Err(ApiError::malformed(
                StatusCode::UNSUPPORTED_MEDIA_TYPE,
                say("The body must be JSON; send the header Content-Type: application/json"),
            ));
        }
        let WholeBody(body) = WholeBody::from_request(request, state).await?;
        json::read(&body).map(Self).map_err(|wrong| ApiError::bad_request(listed(wrong)))
    }
}

/// Whether a body says that it is JSON (RFC 8259 and, with a suffix, RFC 6839).
fn is_json(headers: &HeaderMap) -> bool {
    let media = headers.get(header::CONTENT_TYPE).and_then(|media| media.to_str().ok()).unwrap_or_default();
    let media = media.split(';').next().unwrap_or_default().trim().to_ascii_lowercase();
    media == "application/json" || (media.starts_with("application/") && media.ends_with("+json"))
}
