//! The list of plans and the editor of one. The scripts ask the API for everything that changes.

use super::form::Numbered;
use super::frame::{Frame, PageError, html};
use super::names_for;
use crate::AppState;
use crate::http::seen_plan;
use crate::web::Who;
use api::Role;
use askama::Template;
use axum::extract::State;
use axum::response::Response;
use shore::identity::Principal;

#[derive(Template)]
#[template(path = "plans.html")]
struct PlansPage {
    frame: Frame,
    /// Names of vessels that people gave, as JSON by address, for the script.
    vessels: String,
    /// Whether the person may make plans.
    operator: bool,
}

#[derive(Template)]
#[template(path = "plan.html")]
struct PlanPage {
    frame: Frame,
    id: i64,
    name: String,
    /// As in [`PlansPage`].
    vessels: String,
    /// Whether the person may change this plan.
    operator: bool,
}

/// `GET /plans`.
pub(super) async fn list(
    State(state): State<AppState>,
    Who(who): Who,
    frame: Frame,
) -> Result<Response, PageError> {
    let operator = who.grants.somewhere() >= Some(Role::Operator);
    Ok(html(&PlansPage { frame, vessels: names(&state, &who), operator }))
}

/// `GET /plans/{id}`.
pub(super) async fn editor(
    State(state): State<AppState>,
    Who(who): Who,
    Numbered(id): Numbered,
    frame: Frame,
) -> Result<Response, PageError> {
    let (name, operator) = seen_plan(&state, &who, id).await?;
    Ok(html(&PlanPage { frame, id, name, vessels: names(&state, &who), operator }))
}

/// The vessels that the person may see.
fn names(state: &AppState, who: &Principal) -> String {
    serde_json::to_string(&names_for(state, who)).unwrap_or_default()
}
