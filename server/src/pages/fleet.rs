//! The first page: the fleet on a map and in a list, alive.

use super::frame::{Frame, PageError, html};
use crate::http::Who;
use crate::shore::AppState;
use api::Role;
use askama::Template;
use axum::extract::State;
use axum::response::Response;

#[derive(Template)]
#[template(path = "fleet.html")]
struct FleetPage {
    frame: Frame,
    /// Whether data may be exported.
    researcher: bool,
    /// Names that people gave, as JSON by address, for the script.
    names: String,
}

/// `GET /`.
pub(super) async fn page(
    State(state): State<AppState>,
    Who(who): Who,
    frame: Frame,
) -> Result<Response, PageError> {
    let vessels = state.people.ask(crate::people::vessels::list).await?;
    let names: std::collections::BTreeMap<u16, String> =
        vessels.into_iter().map(|vessel| (vessel.address, vessel.name)).collect();
    Ok(html(&FleetPage {
        frame,
        researcher: who.grants.somewhere() >= Some(Role::Researcher),
        names: serde_json::to_string(&names).unwrap_or_default(),
    }))
}
