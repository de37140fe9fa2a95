//! Datasets. Lists and forms are drawn by the script.

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
#[template(path = "datasets.html")]
struct DatasetsPage {
    frame: Frame,
    /// Names that people gave to the vessels that this one may see, as JSON by address, for the script.
    names: String,
    /// Whether the person may make one.
    researcher: bool,
}

#[derive(Template)]
#[template(path = "dataset.html")]
struct DatasetPage {
    frame: Frame,
    id: i64,
    title: String,
    /// As in [`DatasetsPage`].
    names: String,
}

/// `GET /datasets`.
pub(super) async fn list(
    State(state): State<AppState>,
    Who(who): Who,
    frame: Frame,
) -> Result<Response, PageError> {
    let names = serde_json::to_string(&names_for(&state, &who)).unwrap_or_default();
    let researcher = who.grants.somewhere() >= Some(Role::Researcher);
    Ok(html(&DatasetsPage { frame, names, researcher }))
}

/// `GET /datasets/{id}`.
pub(super) async fn one(
    State(state): State<AppState>,
    Who(who): Who,
    Numbered(id): Numbered,
    frame: Frame,
) -> Result<Response, PageError> {
    let dataset = state.shore.datasets.one(&who, id).await?;
    let title = dataset.versions.first().map(|version| version.title.clone());
    let title = title.or(dataset.draft.map(|draft| draft.title)).filter(|title| !title.is_empty());
    let title = title.unwrap_or_else(|| frame.t("Dataset without a title").to_string());
    let names = serde_json::to_string(&names_for(&state, &who)).unwrap_or_default();
    Ok(html(&DatasetPage { frame, id, title, names }))
}
