//! The list of missions and the page of one. The scripts ask the API for everything in them.

use super::form::Numbered;
use super::frame::{Frame, PageError, html};
use super::names_for;
use crate::AppState;
use crate::web::Who;
use api::Role;
use askama::Template;
use axum::extract::State;
use axum::response::Response;

#[derive(Template)]
#[template(path = "missions.html")]
struct MissionsPage {
    frame: Frame,
    /// Names that people gave to the vessels that this one may see, as JSON by address, for the script.
    names: String,
}

#[derive(Template)]
#[template(path = "mission.html")]
struct MissionPage {
    frame: Frame,
    id: i64,
    name: String,
    /// As in [`MissionsPage`].
    names: String,
    /// Whether the person may export data of all its vessels.
    researcher: bool,
}

/// `GET /missions`.
pub(super) async fn list(
    State(state): State<AppState>,
    Who(who): Who,
    frame: Frame,
) -> Result<Response, PageError> {
    let names = serde_json::to_string(&names_for(&state, &who)).unwrap_or_default();
    Ok(html(&MissionsPage { frame, names }))
}

/// `GET /missions/{id}`.
pub(super) async fn one(
    State(state): State<AppState>,
    Who(who): Who,
    Numbered(id): Numbered,
    frame: Frame,
) -> Result<Response, PageError> {
    let mission = state.shore.missions.one(&who, id).await?.mission;
    let names = serde_json::to_string(&names_for(&state, &who)).unwrap_or_default();
    let researcher = mission.vessels.iter().all(|vessel| who.grants.on(*vessel) >= Some(Role::Researcher));
    Ok(html(&MissionPage { frame, id, name: mission.name, names, researcher }))
}
