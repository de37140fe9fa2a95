//! Counts and times requests, by route and not by path, so that no stranger can make new series.

use axum::extract::{MatchedPath, Request};
use axum::middleware::Next;
use axum::response::Response;
use std::time::Instant;

/// Measures one request.
pub(crate) async fn measure(request: Request, next: Next) -> Response {
    let begun = Instant::now();
    let route = request.extensions().get::<MatchedPath>().map_or("none", MatchedPath::as_str).to_owned();
    let method = request.method().as_str().to_owned();
    let response = next.run(request).await;
    let status = response.status().as_u16().to_string();
    let took = begun.elapsed();
    tracing::debug!(%method, %route, %status, took_ms = took.as_secs_f64() * 1e3, "answered");
    metrics::counter!("lutra_http_requests_total", "route" => route.clone(), "method" => method, "status" => status)
        .increment(1);
    metrics::histogram!("lutra_http_request_seconds", "route" => route).record(took.as_secs_f64());
    response
}
