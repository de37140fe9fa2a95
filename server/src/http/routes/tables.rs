//! Routes of rows for Grafana, notebooks and spreadsheets.

use crate::http::table;
use crate::web::{Need, Route};
use api::{Role, TableChoice, TableDetections, TableDetectionsQuery, TableQuery, TableRow, TableSeriesQuery};

/// Tables whose rows all have the same columns, as JSON or CSV.
pub(super) fn tables() -> Vec<Route> {
    let viewer = Need::Somewhere(Role::Viewer);
    vec![
        Route::get(
            "/api/v1/table",
            viewer,
            "Least, mean and greatest values of series as rows with a time, for Grafana, notebooks and spreadsheets: JSON or CSV.",
            table::rows,
        )
        .query::<TableQuery>()
        .gives::<Vec<TableRow>>()
        .packed(),
        Route::get(
            "/api/v1/table/vessels",
            viewer,
            "Vessels to choose from, for a variable of a dashboard.",
            table::vessels,
        )
        .gives::<Vec<TableChoice>>(),
        Route::get(
            "/api/v1/table/series",
            viewer,
            "Series to choose from, for a variable of a dashboard.",
            table::series,
        )
        .query::<TableSeriesQuery>()
        .gives::<Vec<TableChoice>>()
        .packed(),
        Route::get(
            "/api/v1/table/detections",
            viewer,
            "Tags heard as rows with a time and a place, by time of report: JSON with the address of the rows that did not fit, or CSV.",
            table::detections,
        )
        .query::<TableDetectionsQuery>()
        .gives::<TableDetections>()
        .packed(),
    ]
}
