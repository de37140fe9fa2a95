//! What a link to a dataset shows to those whom it is for, and the list of what is shared with an account: made on the server, for
//! readers without a role and without scripts.

use super::form::Sent;
use super::frame::{Frame, PageError, html, set_cookie};
use super::words::{word, worded};
use crate::AppState;
use crate::web::{ApiError, InPath, MaybeWho, Remote, Who, cookie_name, plain_cookie};
use api::{DatasetCheck, DatasetContent, DatasetVersion, ShareVisitKind, SharedDataset};
use askama::Template;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse as _, Redirect, Response};
use research::Access;
use serde::Deserialize;
use shore::datasets::{OpenShare, ShareClosed};
use std::time::Duration;
use units::UtcTime;

/// How long a page waits to learn whether the archive has changed since.
const PATIENCE: Duration = Duration::from_secs(10);
/// How long a browser keeps what opens a link, seconds; the server holds it to the same.
const KEPT_S: u32 = 43_200;

/// Formats besides the canonical one, and what they are called on all pages.
const FORMATS: [(&str, &str); 18] = [
    ("vue", "VUE (Innovasea)"),
    ("fathom", "Fathom (Innovasea)"),
    ("thelma", "Thelma Biotel ComPort"),
    ("thelma-old", word("Thelma Biotel ComPort, earlier")),
    ("otn", "Ocean Tracking Network"),
    ("etn", "European Tracking Network"),
    ("glatos", "GLATOS 1.4"),
    ("actel", word("actel, detections")),
    ("yaps", "yaps"),
    ("movebank", "Movebank"),
    ("darwin-core", word("Darwin Core (OBIS, GBIF), occurrences")),
    ("dwca", word("Darwin Core archive, first of each hour")),
    ("dwca-all", word("Darwin Core archive, every detection")),
    ("geojson", word("GeoJSON, for maps")),
    ("kml", word("KML, for Google Earth")),
    ("geopackage", word("GeoPackage, for maps")),
    ("parquet", word("Parquet, for programs")),
    ("netcdf", word("NetCDF (CF), for oceanographers")),
];

/// Why a link shows nothing, in plain words.
#[derive(Template)]
#[template(path = "share_closed.html")]
struct ClosedPage {
    frame: Frame,
    title: String,
    text: String,
}

/// The question for the password.
#[derive(Template)]
#[template(path = "share_password.html")]
struct PasswordPage {
    frame: Frame,
    problem: String,
}

/// What a link gives.
#[derive(Template)]
#[template(path = "share.html")]
struct SharePage {
    frame: Frame,
    version: DatasetVersion,
    /// The name and page of the licence.
    licence: String,
    licence_page: &'static str,
    ends: String,
    /// About how large a cell is; empty where places are given as they are.
    cell: String,
    /// Whether the link gives a part of the dataset.
    is_part: bool,
    /// Whether the archive had changed before the link was made.
    had_changed: bool,
    /// Absent while an embargo stands.
    data: Option<Data>,
}

/// What the page says of the data.
struct Data {
    rows: u64,
    sha256: String,
    bytes: String,
    time: String,
    place: String,
    formats: [(&'static str, &'static str); 18],
    check: Option<DatasetCheck>,
    /// Whether a check runs that took longer than the page waits.
    is_being_checked: bool,
    /// Whether what the link gives is compared with its making: the version has other bytes.
    is_own: bool,
    python: String,
    r: String,
}

/// `GET /s/{token}`.
pub(super) async fn page(
    State(state): State<AppState>,
    frame: Frame,
    remote: Remote,
    MaybeWho(who): MaybeWho,
    headers: HeaderMap,
    InPath(token): InPath<String>,
) -> Result<Response, PageError> {
    let datasets = &state.shore.datasets;
    let open = match datasets.open(&token, remote.address, who.as_ref()).await? {
        Ok(open) => open,
        // Who is logged in has a one-time password to change first.
        Err(ShareClosed::LogIn) if who.is_some() => return Ok(Redirect::to("/account").into_response()),
        Err(ShareClosed::LogIn) => {
            return Ok(Redirect::to(&format!("/login?next=/s/{token}")).into_response());
        }
        Err(closed) => return Ok(closed_page(frame, &closed)),
    };
    let kept = cookie_name(&open.cookie_name(), remote);
    if !datasets.is_unlocked(&open, plain_cookie(&headers, &kept)) {
        return Ok(password_page(frame, String::new(), StatusCode::OK));
    }
    datasets.note(&open, ShareVisitKind::View, remote.address, "").await?;
    let base = format!("{}/s/{token}", remote.origin(&headers));
    let data = if open.embargo_us.is_some() { None } else { Some(data(&state, &frame, &open, &base).await) };
    Ok(html(&share_page(frame, &open, data)))
}

/// What is shared with the account that is logged in.
#[derive(Template)]
#[template(path = "shared.html")]
struct SharedPage {
    frame: Frame,
    shared: Vec<Shared>,
}

/// A row of that list.
struct Shared {
    dataset: SharedDataset,
    ends: String,
}

/// `GET /shared`.
pub(super) async fn shared(
    State(state): State<AppState>,
    Who(who): Who,
    frame: Frame,
) -> Result<Response, PageError> {
    let shared = state.shore.datasets.shared_with(&who).await?;
    let shared = shared.into_iter().map(|dataset| Shared { ends: minute(dataset.expires_us), dataset });
    Ok(html(&SharedPage { shared: shared.collect(), frame }))
}

/// A password as it is given.
#[derive(Debug, Deserialize)]
pub(super) struct Given {
    password: String,
}

/// `POST /s/{token}`.
pub(super) async fn unlock(
    State(state): State<AppState>,
    frame: Frame,
    remote: Remote,
    MaybeWho(who): MaybeWho,
    InPath(token): InPath<String>,
    Sent(given): Sent<Given>,
) -> Result<Response, PageError> {
    let datasets = &state.shore.datasets;
    let open = match datasets.open(&token, remote.address, who.as_ref()).await? {
        Ok(open) => open,
        Err(closed) => return Ok(closed_page(frame, &closed)),
    };
    match datasets.unlock(&open, given.password, remote.address).await {
        Ok(kept) => {
            let cookie = set_cookie(&cookie_name(&open.cookie_name(), remote), &kept, KEPT_S, remote);
            Ok(([(header::SET_COOKIE, cookie)], Redirect::to(&format!("/s/{token}"))).into_response())
        }
        Err(shore::identity::Refused::Fault(fault)) => Err(fault.into()),
        Err(refused) => {
            let error = ApiError::from(refused);
            let problem = worded(frame.language, &error.text);
            let mut response = password_page(frame, problem, error.status);
            if let Some(wait_s) = error.wait_s {
                response.headers_mut().insert(header::RETRY_AFTER, wait_s.into());
            }
            Ok(response)
        }
    }
}

fn closed_page(frame: Frame, closed: &ShareClosed) -> Response {
    let (status, title, text) = match closed {
        ShareClosed::Unknown => (
            StatusCode::NOT_FOUND,
            frame.t("There is no such link"),
            frame.t(
                "There is no link with this address. Check that all of it was copied, or ask for a new one.",
            ),
        ),
        ShareClosed::Revoked => (
            StatusCode::GONE,
            frame.t("This link was revoked"),
            frame.t("Those who made this link have taken it back. Ask them for a new one."),
        ),
        ShareClosed::Expired => (
            StatusCode::GONE,
            frame.t("This link has ended"),
            frame.t("The time of this link is over. Ask those who made it for a new one."),
        ),
        ShareClosed::Withdrawn(reason) => (
            StatusCode::GONE,
            frame.t("The dataset was withdrawn"),
            frame.t("Its data are no longer available. Reason: {reason}").with("reason", reason),
        ),
        ShareClosed::WithdrawnUntold => (
            StatusCode::GONE,
            frame.t("The dataset was withdrawn"),
            frame.t("Its data are no longer available. Ask those who sent you this link why."),
        ),
        ShareClosed::LogIn => (
            StatusCode::UNAUTHORIZED,
            frame.t("This link is for one account"),
            frame.t("This link is for one account: log in."),
        ),
        ShareClosed::Wait(wait) => (
            StatusCode::TOO_MANY_REQUESTS,
            frame.t("Wait a moment"),
            frame.t("Too many attempts. Try again in {n} s.").with("n", wait.as_secs() + 1),
        ),
    };
    let page = ClosedPage { title: title.to_string(), text: text.to_string(), frame };
    let mut response = with_status(html(&page), status);
    if let ShareClosed::Wait(wait) = closed {
        response.headers_mut().insert(header::RETRY_AFTER, (wait.as_secs() + 1).into());
    }
    response
}

fn password_page(frame: Frame, problem: String, status: StatusCode) -> Response {
    with_status(html(&PasswordPage { frame, problem }), status)
}

fn with_status(mut response: Response, status: StatusCode) -> Response {
    *response.status_mut() = status;
    response
}

fn share_page(frame: Frame, open: &OpenShare, data: Option<Data>) -> SharePage {
    let OpenShare { share, version, .. } = open;
    let is_part =
        share.from_us.is_some() || share.to_us.is_some() || !share.tags.is_empty() || !share.area.is_empty();
    SharePage {
        licence: research::licence_name(&version.licence).to_owned(),
        licence_page: research::licence_page(&version.licence).unwrap_or_default(),
        ends: minute(share.expires_us),
        cell: share.precision_m.map(|size_m| size_m.to_string()).unwrap_or_default(),
        is_part,
        had_changed: share.had_changed,
        version: version.clone(),
        data,
        frame,
    }
}

async fn data(state: &AppState, frame: &Frame, open: &OpenShare, base: &str) -> Data {
    let OpenShare { share, version, .. } = open;
    let content = &share.content;
    let access = match &share.person {
        Some(_) => Access::Token,
        None if share.has_password => Access::Password,
        None => Access::Address,
    };
    let file = format!("{base}/detections.csv");
    // Where that fails, the page says nothing of it; where it takes longer, it goes on without the page.
    let check = tokio::time::timeout(PATIENCE, state.shore.datasets.shared_check(open)).await;
    Data {
        rows: content.rows,
        sha256: content.sha256.clone(),
        bytes: bytes(content.bytes),
        time: time(frame, content),
        place: place(frame, content),
        formats: FORMATS,
        is_being_checked: check.is_err(),
        check: check.ok().and_then(Result::ok),
        is_own: content.sha256 != version.content.sha256,
        python: research::python(version, content, &file, access),
        r: research::r(version, content, &file, access),
    }
}

fn minute(us: i64) -> String {
    let text = UtcTime::from_micros(us).to_string();
    format!("{} {} UTC", &text[..10], &text[11..16])
}

fn time(frame: &Frame, content: &DatasetContent) -> String {
    match (content.covered.first_us, content.covered.last_us) {
        (Some(first), Some(last)) => {
            let words = frame.t("{from} to {to}");
            words.with("from", minute(first)).with("to", minute(last)).to_string()
        }
        _ => frame.t("not known").to_string(),
    }
}

/// The extent in words.
fn place(frame: &Frame, content: &DatasetContent) -> String {
    let covered = content.covered;
    let (Some(south), Some(north), Some(west), Some(east)) =
        (covered.south_deg, covered.north_deg, covered.west_deg, covered.east_deg)
    else {
        return frame.t("No place is known.").to_string();
    };
    let lat = |degrees: f64| {
        let side = if degrees < 0.0 { frame.t("{n}° S") } else { frame.t("{n}° N") };
        side.with("n", format!("{:.4}", degrees.abs())).to_string()
    };
    let lon = |degrees: f64| {
        let side = if degrees < 0.0 { frame.t("{n}° W") } else { frame.t("{n}° E") };
        side.with("n", format!("{:.4}", degrees.abs())).to_string()
    };
    let words = frame.t("From {south} to {north}, and from {west} to {east}.");
    let words = words.with("south", lat(south)).with("north", lat(north));
    words.with("west", lon(west)).with("east", lon(east)).to_string()
}

fn bytes(bytes: u64) -> String {
    match bytes {
        0..1_000 => format!("{bytes} B"),
        1_000..1_000_000 => format!("{:.1} kB", bytes as f64 / 1e3),
        1_000_000..1_000_000_000 => format!("{:.1} MB", bytes as f64 / 1e6),
        _ => format!("{:.1} GB", bytes as f64 / 1e9),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_formats_of_detections_are_offered() {
        let of_detections = research::FORMATS.into_iter().filter(research::Format::is_of_detections);
        let names: Vec<&str> =
            of_detections.map(|format| format.name).filter(|name| *name != "lutra").collect();
        assert_eq!(names, FORMATS.map(|(name, _)| name));
    }

    #[test]
    fn sizes_and_times_are_said_as_people_say_them() {
        assert_eq!((&*bytes(999), &*bytes(1_500), &*bytes(2_500_000)), ("999 B", "1.5 kB", "2.5 MB"));
        assert_eq!(minute(1_795_248_000_007_000), "2026-11-21 08:00 UTC");
    }
}
