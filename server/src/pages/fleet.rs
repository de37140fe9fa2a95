//! The first page: the fleet on a map and in a list, alive.

use super::frame::{Frame, PageError, html};
use super::names_for;
use crate::AppState;
use crate::web::Who;
use askama::Template;
use axum::extract::State;
use axum::response::Response;

#[derive(Template)]
#[template(path = "fleet.html")]
struct FleetPage {
    frame: Frame,
    /// Names that people gave to the vessels that this one may see, as JSON by address, for the script.
    names: String,
}

/// `GET /`.
pub(super) async fn page(
    State(state): State<AppState>,
    Who(who): Who,
    frame: Frame,
) -> Result<Response, PageError> {
    let names = names_for(&state, &who);
    Ok(html(&FleetPage { frame, names: serde_json::to_string(&names).unwrap_or_default() }))
}
