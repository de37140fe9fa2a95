//! Routes for researchers: detections, and the register of studies.

use crate::http::{explore, export, history, register};
use crate::web::{Need, Route};
use api::{
    Detections, DetectionsFileQuery, DetectionsSummary, DetectionsSummaryQuery, ExportSize,
    FleetDetectionsQuery, RegisterAnswer, RegisterChange, RegisterDeleteQuery, RegisterEntry, RegisterImport,
    RegisterImportQuery, RegisterQuery, RegisterRecord, Role,
};
use shore::register::FILE_BYTES;

/// Detections: pages of them, summaries, and files.
pub(super) fn detections() -> Vec<Route> {
    let (viewer, researcher) = (Need::Somewhere(Role::Viewer), Need::Somewhere(Role::Researcher));
    vec![
        Route::get("/api/v1/detections", viewer, "Tags heard by all vessels.", history::fleet_detections)
            .query::<FleetDetectionsQuery>()
            .gives::<Detections>()
            .packed(),
        Route::get(
            "/api/v1/detections/summary",
            viewer,
            "Detections counted by tag, time, place and flag, for plots of any number of them.",
            explore::summary,
        )
        .query::<DetectionsSummaryQuery>()
        .gives::<DetectionsSummary>()
        .packed(),
        Route::get(
            "/api/v1/detections/size",
            researcher,
            "How many detections a file has, and about how many bytes.",
            explore::size,
        )
        .query::<DetectionsFileQuery>()
        .gives::<ExportSize>(),
        Route::get(
            "/api/v1/detections.csv",
            researcher,
            "Detections as a file, in the format of a portal if that is asked for, the oldest report first. An answer that ends \
             without an error is whole.",
            export::detections,
        )
        .query::<DetectionsFileQuery>()
        .media("text/csv")
        .packed(),
    ]
}

/// The register of studies. Who may change an entry depends on its kind and vessel.
pub(super) fn register_table() -> Vec<Route> {
    let viewer = Need::Somewhere(Role::Viewer);
    let researcher = Need::Somewhere(Role::Researcher);
    vec![
        Route::get(
            "/api/v1/register",
            viewer,
            "The register: projects, people, animals, tags, receivers and their deployments, by kind and name.",
            register::list,
        )
        .query::<RegisterQuery>()
        .gives::<RegisterAnswer>()
        .packed(),
        Route::post("/api/v1/register", researcher, "Register something.", register::create)
            .takes::<RegisterRecord>()
            .gives::<RegisterEntry>(),
        Route::put(
            "/api/v1/register/{id}",
            researcher,
            "Change an entry; what it said is kept. 409 when it was changed meanwhile.",
            register::change,
        )
        .takes::<RegisterChange>()
        .gives::<RegisterEntry>(),
        Route::delete(
            "/api/v1/register/{id}",
            researcher,
            "Delete an entry that no other names; what it said is kept.",
            register::delete,
        )
        .query::<RegisterDeleteQuery>(),
        Route::get(
            "/api/v1/register.csv",
            viewer,
            "A table of the register, of one kind; without entries it is the template of a file to import.",
            register::csv,
        )
        .query::<RegisterQuery>()
        .media("text/csv")
        .packed(),
        Route::post(
            "/api/v1/register/import",
            researcher,
            "What a table would change in the register, with all of its problems; with `apply` it is taken, whole or not at \
             all. The body is the file.",
            register::import,
        )
        .query::<RegisterImportQuery>()
        .takes_file()
        .gives::<RegisterImport>()
        .body_bytes(FILE_BYTES),
    ]
}
