//! The tags that all vessels heard. Table and filter are drawn by the script.

use super::frame::{Frame, PageError, html};
use super::names_for;
use crate::AppState;
use crate::web::Who;
use api::Role;
use askama::Template;
use axum::extract::State;
use axum::response::Response;

#[derive(Template)]
#[template(path = "detections.html")]
struct DetectionsPage {
    frame: Frame,
    /// Names that people gave to the vessels that this one may see, as JSON by address, for the script.
    names: String,
    /// Whether the person may export data.
    researcher: bool,
    /// The columns of the file, each with what it tells.
    columns: &'static [research::DetectionColumn],
}

/// `GET /detections`.
pub(super) async fn page(
    State(state): State<AppState>,
    Who(who): Who,
    frame: Frame,
) -> Result<Response, PageError> {
    let names = names_for(&state, &who);
    Ok(html(&DetectionsPage {
        frame,
        names: serde_json::to_string(&names).unwrap_or_default(),
        researcher: who.grants.somewhere() >= Some(Role::Researcher),
        columns: &research::LUTRA_COLUMNS,
    }))
}
