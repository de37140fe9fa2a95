//! The routes of the API and what belongs to it. Each area has its own list in a submodule.

mod alarms;
mod datasets;
mod people;
mod plans;
mod research;
mod sea;
mod tables;
mod transfers;
mod vessels;

use crate::http::{self, health, history, live, openapi, transports};
use crate::web::{Need, Route, assets};
use api::{
    AuditEntry, LinkStatus, LiveFrame, LiveRequest, Me, NewToken, Person, Recorded, RecordedDay, Recording,
    Role, Series, SeriesQuery, Session, System, Token, TokenMade, TransportPeer,
};
use axum::Json;
use utoipa::openapi::OpenApi;

/// All routes for programs, and the static assets of pages.
pub(crate) fn table() -> Vec<Route> {
    let viewer = Need::Somewhere(Role::Viewer);
    let admin = Need::Everywhere(Role::Admin);
    let own = Need::Account;
    let mut table = vec![
        Route::get(
            "/healthz",
            Need::Anyone,
            "Whether the server does its work: 503 while nothing can be recorded.",
            health::healthz,
        ),
        Route::get(
            "/readyz",
            Need::Anyone,
            "Whether the server takes requests: 503 while it ends.",
            health::readyz,
        ),
        Route::get("/metrics", Need::Figures, "Figures for Prometheus.", health::metrics).media("text/plain"),
        Route::get("/static/{name}", Need::Anyone, "Scripts and styles.", assets::serve),
        Route::get(
            "/worker.js",
            Need::Anyone,
            "What answers while the server is not reached.",
            assets::worker,
        ),
        Route::get("/manifest.webmanifest", Need::Anyone, "To install the pages.", assets::web_manifest),
        Route::get("/favicon.ico", Need::Anyone, "The picture in the tab.", assets::favicon),
        Route::get("/api/v1/openapi.json", viewer, "This document.", document).packed(),
        Route::get("/api/v1/me", own, "Who asks.", http::people::me).gives::<Me>(),
        Route::get("/api/v1/people", admin, "Accounts.", http::people::list).gives::<Vec<Person>>(),
        Route::get("/api/v1/tokens", own, "One's own tokens; for an admin all.", http::people::token_list)
            .gives::<Vec<Token>>(),
        Route::post("/api/v1/tokens", own, "Make a token. Only for browsers.", http::people::token_make)
            .takes::<NewToken>()
            .gives::<TokenMade>(),
        Route::delete("/api/v1/tokens/{id}", own, "Revoke a token.", http::people::token_revoke),
        Route::get(
            "/api/v1/sessions",
            own,
            "One's own sessions; for an admin all.",
            http::people::session_list,
        )
        .gives::<Vec<Session>>(),
        Route::delete("/api/v1/sessions/{id}", own, "End a session.", http::people::session_end),
        Route::get("/api/v1/audit", admin, "Audit log, the newest first.", http::people::audit_list)
            .query::<http::people::AuditQuery>()
            .gives::<Vec<AuditEntry>>(),
        Route::get("/api/v1/vessels", viewer, "The fleet as it is.", history::vessels).gives::<Vec<System>>(),
        Route::socket("/api/live", viewer, "The fleet as it changes: a WebSocket.", live::socket)
            .takes::<LiveRequest>()
            .gives::<LiveFrame>(),
        Route::get("/api/v1/recorded", viewer, "What the history holds.", history::recorded)
            .gives::<Vec<Recorded>>(),
        Route::get(
            "/api/v1/recorded/days",
            viewer,
            "What came ashore on which day, the newest first.",
            history::recorded_days,
        )
        .gives::<Vec<RecordedDay>>(),
        Route::get("/api/v1/series", viewer, "Series of samples, with fields and units.", history::series)
            .query::<SeriesQuery>()
            .gives::<Vec<Series>>()
            .packed(),
        Route::get(
            "/api/v1/connections",
            viewer,
            "Who is connected by which transport.",
            transports::transports,
        )
        .gives::<Vec<TransportPeer>>(),
        Route::get("/api/v1/links", viewer, "How the vessels' links are.", transports::links)
            .gives::<Vec<LinkStatus>>(),
        Route::get("/api/v1/recording", viewer, "How recording goes.", transports::recording)
            .gives::<Recording>(),
    ];
    table.extend(vessels::of_vessels());
    table.extend(vessels::orders());
    table.extend(vessels::told_by_vessels());
    table.extend(alarms::alarms_table());
    table.extend(people::log_book());
    table.extend(people::missions_table());
    table.extend(research::detections());
    table.extend(research::register_table());
    table.extend(datasets::datasets_table());
    table.extend(datasets::links());
    table.extend(sea::no_go_areas());
    table.extend(tables::tables());
    table.extend(transfers::transfers());
    table.extend(plans::plans());
    table.extend(sea::chart());
    table
}

/// `GET /api/v1/openapi.json`.
async fn document() -> Json<OpenApi> {
    Json(openapi::describe(&table()))
}
