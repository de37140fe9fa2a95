//! Routes of datasets, and of the links by which they are shared.

use crate::http::{datasets, shares};
use crate::web::{Need, Route};
use api::{
    Dataset, DatasetChange, DatasetCheck, DatasetDraft, DatasetFileQuery, DatasetShare, DatasetShareMade,
    DatasetShareRequest, DatasetStep, DatasetVersion, DatasetWithdrawal, Role, ShareVisit, SharedDataset,
};

/// Datasets. Who may see and change one depends on its vessels.
pub(super) fn datasets_table() -> Vec<Route> {
    let (viewer, researcher) = (Need::Somewhere(Role::Viewer), Need::Somewhere(Role::Researcher));
    vec![
        Route::get("/api/v1/datasets", viewer, "Datasets, those that were made last first.", datasets::list)
            .gives::<Vec<Dataset>>(),
        Route::post("/api/v1/datasets", researcher, "Make a dataset, as a draft.", datasets::create)
            .takes::<DatasetDraft>()
            .gives::<Dataset>(),
        Route::get("/api/v1/datasets/{id}", viewer, "A dataset.", datasets::one).gives::<Dataset>(),
        Route::put(
            "/api/v1/datasets/{id}",
            researcher,
            "Change the draft of a dataset. 409 when it was changed meanwhile.",
            datasets::change,
        )
        .takes::<DatasetChange>()
        .gives::<Dataset>(),
        Route::post(
            "/api/v1/datasets/{id}/publish",
            researcher,
            "Publish the draft: its question, its count of rows and the SHA-256 of its canonical CSV never change again.",
            datasets::publish,
        )
        .takes::<DatasetStep>()
        .gives::<Dataset>(),
        Route::post(
            "/api/v1/datasets/{id}/versions",
            researcher,
            "Make a draft of the newest version, for the next one.",
            datasets::new_version,
        )
        .takes::<DatasetStep>()
        .gives::<Dataset>(),
        Route::post(
            "/api/v1/datasets/{id}/withdraw",
            researcher,
            "Withdraw a dataset: it stays and is named, its links end, and its data are no longer available.",
            datasets::withdraw,
        )
        .takes::<DatasetWithdrawal>()
        .gives::<Dataset>(),
    ]
    .into_iter()
    .chain(versions_table())
    .chain(descriptions_table())
    .chain(shares_table())
    .collect()
}

/// Versions, and their files.
fn versions_table() -> Vec<Route> {
    let (viewer, researcher) = (Need::Somewhere(Role::Viewer), Need::Somewhere(Role::Researcher));
    vec![
        Route::get(
            "/api/v1/datasets/{id}/versions/{number}",
            viewer,
            "A published version.",
            datasets::version,
        )
        .gives::<DatasetVersion>(),
        Route::get(
            "/api/v1/datasets/{id}/versions/{number}/check",
            researcher,
            "Whether the archive still gives the bytes that were published.",
            datasets::check,
        )
        .gives::<DatasetCheck>(),
        Route::get(
            "/api/v1/datasets/{id}/versions/{number}/detections.csv",
            researcher,
            "The detections of a version: the canonical CSV, or the format of a portal.",
            datasets::detections,
        )
        .query::<DatasetFileQuery>()
        .media("text/csv")
        .packed(),
    ]
}

/// Machine-readable metadata of versions.
fn descriptions_table() -> Vec<Route> {
    let viewer = Need::Somewhere(Role::Viewer);
    vec![
        Route::get(
            "/api/v1/datasets/{id}/versions/{number}/datacite.json",
            viewer,
            "A version as DataCite's schema 4.5 has it.",
            datasets::datacite,
        )
        .media("application/json"),
        Route::get(
            "/api/v1/datasets/{id}/versions/{number}/datapackage.json",
            viewer,
            "A version as a Frictionless package: columns, SHA-256, question.",
            datasets::datapackage,
        )
        .media("application/json"),
        Route::get(
            "/api/v1/datasets/{id}/versions/{number}/schema.jsonld",
            viewer,
            "A version as JSON-LD of schema.org.",
            datasets::json_ld,
        )
        .media("application/ld+json"),
        Route::get(
            "/api/v1/datasets/{id}/versions/{number}/notebook.py",
            viewer,
            "Lines of Python that fetch exactly this version.",
            datasets::python,
        )
        .media("text/plain"),
        Route::get(
            "/api/v1/datasets/{id}/versions/{number}/notebook.R",
            viewer,
            "Lines of R that fetch exactly this version.",
            datasets::r,
        )
        .media("text/plain"),
    ]
}

/// Links, for those who make them.
fn shares_table() -> Vec<Route> {
    let researcher = Need::Somewhere(Role::Researcher);
    vec![
        Route::get(
            "/api/v1/datasets/{id}/shares",
            researcher,
            "Links to a dataset, the newest first.",
            datasets::shares,
        )
        .gives::<Vec<DatasetShare>>(),
        Route::post(
            "/api/v1/datasets/{id}/shares",
            researcher,
            "Make a link by which somebody without an account, or one account, gets a version, or a part of it.",
            datasets::share,
        )
        .takes::<DatasetShareRequest>()
        .gives::<DatasetShareMade>(),
        Route::delete("/api/v1/datasets/{id}/shares/{share}", researcher, "Revoke a link.", datasets::revoke),
        Route::get(
            "/api/v1/datasets/{id}/shares/{share}/visits",
            researcher,
            "How a link was used, the newest first; 500 at most.",
            datasets::visits,
        )
        .gives::<Vec<ShareVisit>>(),
    ]
}

/// Data for clients that have the address of a link. Each of these routes checks the link itself.
pub(super) fn links() -> Vec<Route> {
    vec![
        Route::get("/api/v1/shared", Need::Account, "What is shared with one's own account.", shares::mine)
            .gives::<Vec<SharedDataset>>(),
        Route::get(
            "/s/{token}/detections.csv",
            Need::Anyone,
            "The detections that a link gives.",
            shares::detections,
        )
        .query::<DatasetFileQuery>()
        .media("text/csv")
        .packed(),
        Route::get("/s/{token}/datacite.json", Need::Anyone, "Them for DataCite.", shares::datacite)
            .media("application/json"),
        Route::get("/s/{token}/datapackage.json", Need::Anyone, "Them as a package.", shares::datapackage)
            .media("application/json"),
        Route::get("/s/{token}/schema.jsonld", Need::Anyone, "Them for search engines.", shares::json_ld)
            .media("application/ld+json"),
    ]
}
