//! The explorer of detections. All of it is drawn by the script.

use super::frame::{Frame, PageError, html};
use super::names_for;
use crate::AppState;
use crate::web::Who;
use api::Role;
use askama::Template;
use axum::extract::State;
use axum::response::Response;

#[derive(Template)]
#[template(path = "explore.html")]
struct ExplorePage {
    frame: Frame,
    /// Names that people gave to the vessels that this one may see, as JSON by address, for the script.
    names: String,
    /// Whether the person may export data.
    researcher: bool,
}

/// `GET /explore`.
pub(super) async fn page(
    State(state): State<AppState>,
    Who(who): Who,
    frame: Frame,
) -> Result<Response, PageError> {
    let names = serde_json::to_string(&names_for(&state, &who)).unwrap_or_default();
    let researcher = who.grants.somewhere() >= Some(Role::Researcher);
    Ok(html(&ExplorePage { frame, names, researcher }))
}
