//! Routes of plans ashore.

use crate::http::plans;
use crate::web::{Need, Route};
use api::{
    Command, ImportedPlan, PlanChange, PlanCheck, PlanDocument, PlanExportQuery, PlanImportQuery, PlanQuery,
    PlanRevision, PlanSummary, PlanUploadRequest, Role, StoredPlan,
};

/// Bytes of a plan, and of a file that holds one.
const PLAN_BYTES: usize = 4 << 20;

/// Plans ashore. Who may see and change one depends on its vessel.
pub(super) fn plans() -> Vec<Route> {
    let viewer = Need::Somewhere(Role::Viewer);
    let operator = Need::Somewhere(Role::Operator);
    vec![
        Route::get("/api/v1/plans", viewer, "Plans, by name.", plans::list).gives::<Vec<PlanSummary>>(),
        Route::post(
            "/api/v1/plans",
            operator,
            "Keep a new plan, as a draft. It gets another name if its own is taken.",
            plans::create,
        )
        .takes::<PlanDocument>()
        .gives::<StoredPlan>()
        .body_bytes(PLAN_BYTES),
        Route::post(
            "/api/v1/plans/check",
            viewer,
            "What a plan would take and what is wrong with it; nothing is kept.",
            plans::check,
        )
        .takes::<PlanDocument>()
        .gives::<PlanCheck>()
        .body_bytes(PLAN_BYTES),
        Route::post(
            "/api/v1/plans/import",
            operator,
            "Keep a new plan from a file: GPX, GeoJSON, or JSON of an IMC PlanSpecification. The body is the file.",
            plans::import,
        )
        .query::<PlanImportQuery>()
        .takes_file()
        .gives::<ImportedPlan>()
        .body_bytes(PLAN_BYTES),
        Route::get("/api/v1/plans/{id}", viewer, "A plan.", plans::read)
            .query::<PlanQuery>()
            .gives::<StoredPlan>(),
        Route::put(
            "/api/v1/plans/{id}",
            operator,
            "Change a plan. 409 with the newer one when somebody else changed it meanwhile.",
            plans::save,
        )
        .takes::<PlanChange>()
        .gives::<StoredPlan>()
        .body_bytes(PLAN_BYTES),
        Route::delete("/api/v1/plans/{id}", operator, "Delete a plan; it can be restored.", plans::delete),
        Route::post("/api/v1/plans/{id}/restore", operator, "Take a deletion back.", plans::restore)
            .gives::<StoredPlan>(),
        Route::post("/api/v1/plans/{id}/duplicate", operator, "Copy a plan.", plans::duplicate)
            .gives::<StoredPlan>(),
        Route::post(
            "/api/v1/plans/{id}/upload",
            operator,
            "Bring a saved plan aboard a vessel; takes the control of it. The effect is seen when the vessel's digest is ours.",
            plans::upload,
        )
        .takes::<PlanUploadRequest>()
        .gives::<Command>(),
        Route::get("/api/v1/plans/{id}/revisions", viewer, "The states that a plan had.", plans::revisions)
            .gives::<Vec<PlanRevision>>(),
        Route::get("/api/v1/plans/{id}/export", viewer, "A plan as a file.", plans::export)
            .query::<PlanExportQuery>()
            .media("application/octet-stream"),
    ]
}
