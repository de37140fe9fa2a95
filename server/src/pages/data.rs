//! What was recorded, and files of it. The form works without the script, which then draws a better one.

use super::frame::{Frame, PageError, html};
use super::names_for;
use crate::AppState;
use crate::web::Who;
use api::Role;
use askama::Template;
use axum::extract::State;
use axum::response::Response;
use std::collections::BTreeMap;

#[derive(Template)]
#[template(path = "data.html")]
struct DataPage {
    frame: Frame,
    /// Names that people gave to the vessels that this one may see, as JSON by address, for the script.
    names: String,
    /// The same for the form.
    vessels: BTreeMap<u16, String>,
    /// Whether the person may export data.
    researcher: bool,
}

/// `GET /data`.
pub(super) async fn page(
    State(state): State<AppState>,
    Who(who): Who,
    frame: Frame,
) -> Result<Response, PageError> {
    let vessels = names_for(&state, &who);
    let names = serde_json::to_string(&vessels).unwrap_or_default();
    let researcher = who.grants.somewhere() >= Some(Role::Researcher);
    Ok(html(&DataPage { frame, names, vessels, researcher }))
}
