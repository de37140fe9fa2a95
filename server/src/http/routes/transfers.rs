//! Routes of exports and imports.

use crate::http::{export, imports};
use crate::web::{Need, Route};
use api::{ExportQuery, ExportSize, Import, ImportQuery, LogQuery, Role};

/// Exports and imports.
pub(super) fn transfers() -> Vec<Route> {
    let researcher = Need::Somewhere(Role::Researcher);
    let operator = Need::Everywhere(Role::Operator);
    vec![
        Route::get(
            "/api/v1/export.csv",
            researcher,
            "CSV of messages. An answer that ends without an error is whole.",
            export::csv,
        )
        .query::<ExportQuery>()
        .media("text/csv")
        .packed(),
        Route::get(
            "/api/v1/export.parquet",
            researcher,
            "The same table as Parquet, with types. A file without its end is refused by readers.",
            export::parquet,
        )
        .query::<ExportQuery>()
        .media("application/vnd.apache.parquet")
        .packed(),
        Route::get("/api/v1/export.json", researcher, "What stands in its columns.", export::description)
            .query::<ExportQuery>(),
        Route::get("/api/v1/export/size", researcher, "How large the CSV will be.", export::size)
            .query::<ExportQuery>()
            .gives::<ExportSize>(),
        Route::get("/api/v1/export.lsf", researcher, "Packets as a log, as they came.", export::lsf)
            .query::<LogQuery>()
            .media("application/octet-stream"),
        Route::post("/api/v1/import", operator, "Import a log: the body is the file.", imports::upload)
            .query::<ImportQuery>()
            .takes_file()
            .paces()
            .gives::<Import>(),
        Route::get("/api/v1/import", operator, "Logs uploaded, the newest first.", imports::list)
            .gives::<Vec<Import>>(),
        Route::get("/api/v1/import/{id}", operator, "How far an import is.", imports::one).gives::<Import>(),
        Route::post(
            "/api/v1/import/{id}/cancel",
            operator,
            "End an import; what was read stays.",
            imports::cancel,
        )
        .gives::<Import>(),
    ]
}
