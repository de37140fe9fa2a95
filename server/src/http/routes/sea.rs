//! Routes of the sea chart, and of no-go areas.

use crate::http::{areas, charts};
use crate::web::{Need, Route};
use api::{
    ChartAtQuery, ChartCorridor, ChartCorridorRequest, ChartNear, ChartSet, ChartTileQuery, NoGoArea,
    NoGoAreaChange, NoGoAreaQuery, NoGoAreaRequest, NoGoAreas, NoGoAreasQuery, NoGoAreasRequest, Role,
    SeaRouteAnswer, SeaRouteCurrentGrid, SeaRouteProgress, SeaRouteRequest,
};

/// Large enough for the most areas with the most corners, as JSON with all decimals.
const AREAS_BYTES: usize = 4 << 20;

/// A grid of currents of the most values, as JSON.
const ROUTE_BYTES: usize = 4 << 20;

/// No-go areas.
pub(super) fn no_go_areas() -> Vec<Route> {
    let (viewer, operator) = (Need::Somewhere(Role::Viewer), Need::Everywhere(Role::Operator));
    vec![
        Route::get("/api/v1/no-go-areas", viewer, "Areas that are closed to all vessels.", areas::list)
            .query::<NoGoAreasQuery>()
            .gives::<NoGoAreas>(),
        Route::post(
            "/api/v1/no-go-areas",
            operator,
            "Close an area: plans, routes and vessels keep out of it.",
            areas::create,
        )
        .query::<NoGoAreaQuery>()
        .takes::<NoGoAreaRequest>()
        .gives::<NoGoArea>(),
        Route::post(
            "/api/v1/no-go-areas/batch",
            operator,
            "Close several areas, all together or not at all, by one change of the chart.",
            areas::create_all,
        )
        .query::<NoGoAreaQuery>()
        .body_bytes(AREAS_BYTES)
        .takes::<NoGoAreasRequest>()
        .gives::<NoGoAreas>(),
        Route::patch(
            "/api/v1/no-go-areas/{id}",
            operator,
            "Change an area, lift it, or close it again; what it was is kept. 409 when it was changed meanwhile.",
            areas::change,
        )
        .takes::<NoGoAreaChange>()
        .gives::<NoGoArea>(),
    ]
}

/// The sea chart.
pub(super) fn chart() -> Vec<Route> {
    let viewer = Need::Somewhere(Role::Viewer);
    vec![
        Route::get("/api/v1/chart", viewer, "The chart set of the server.", charts::set)
            .gives::<ChartSet>()
            .packed(),
        Route::get(
            "/api/v1/chart/tiles/{z}/{x}/{y}",
            viewer,
            "A Mapbox vector tile of the chart, packed by gzip.",
            charts::tile,
        )
        .query::<ChartTileQuery>()
        .media("application/vnd.mapbox-vector-tile"),
        Route::get("/api/v1/chart/at", viewer, "How deep it is at a place, and what is near.", charts::at)
            .query::<ChartAtQuery>()
            .gives::<ChartNear>()
            .packed(),
        Route::post("/api/v1/chart/corridor", viewer, "How deep it is along a way.", charts::corridor)
            .takes::<ChartCorridorRequest>()
            .gives::<ChartCorridor>()
            .packed(),
        Route::post(
            "/api/v1/chart/route",
            viewer,
            "A route through deep water, clear of dangers: the shortest, the fastest, or the one of the least energy.",
            charts::route,
        )
        .body_bytes(ROUTE_BYTES)
        .takes::<SeaRouteRequest>()
        .gives::<SeaRouteAnswer>()
        .packed(),
        Route::get(
            "/api/v1/chart/route/{name}",
            viewer,
            "How far a question for a route has come, by the name that it was asked with.",
            charts::progress,
        )
        .gives::<SeaRouteProgress>(),
        Route::post(
            "/api/v1/chart/currents",
            viewer,
            "The grid of currents in a file, for routes: CSV or NetCDF-3. The body is the file.",
            charts::currents,
        )
        .takes_file()
        .body_bytes(charts::CURRENTS_BYTES)
        .gives::<SeaRouteCurrentGrid>()
        .packed(),
    ]
}
