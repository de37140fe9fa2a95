//! The one table of what is where.

use super::{headers, health, measure};
use crate::shore::AppState;
use axum::Router;
use axum::extract::DefaultBodyLimit;
use axum::routing::get;
use tower_http::catch_panic::CatchPanicLayer;

/// Bytes of a request's body that are read unless a route allows more.
const BODY_BYTES: usize = 64 * 1024;

/// The whole web server.
pub(crate) fn router(state: AppState) -> Router {
    Router::new()
        .route("/healthz", get(health::healthz))
        .route("/metrics", get(health::metrics))
        .layer(axum::middleware::from_fn(measure::measure))
        .layer(DefaultBodyLimit::max(BODY_BYTES))
        .layer(axum::middleware::from_fn(headers::add))
        .layer(CatchPanicLayer::new())
        .with_state(state)
}
