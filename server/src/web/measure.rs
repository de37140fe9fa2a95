//! Numbers, counts and times requests: by route and not by path, and by known methods, so that a stranger cannot create new
//! series.
//!
//! A request's number is in every line that is logged while it is answered, and in the answer's `X-Request-Id`. It counts
//! from the start of the server: tower-http's layer would take a random one, and with it one more dependency.

use axum::extract::{MatchedPath, Request, State};
use axum::http::{HeaderName, HeaderValue, Method};
use axum::middleware::Next;
use axum::response::Response;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;
use tracing::Instrument as _;

/// Header with the number of a request in the log.
const REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");

/// Measures one request, and counts it in `requests`.
pub(crate) async fn measure(
    State(requests): State<Arc<AtomicU64>>,
    request: Request,
    next: Next,
) -> Response {
    let begun = Instant::now();
    let route = request.extensions().get::<MatchedPath>().map_or("none", MatchedPath::as_str).to_owned();
    let method = known(request.method());
    let id = requests.fetch_add(1, Ordering::Relaxed) + 1;
    let span = tracing::info_span!("request", id, %method, %route);
    let mut response = next.run(request).instrument(span.clone()).await;
    response.headers_mut().insert(REQUEST_ID, HeaderValue::from(id));
    let status = response.status().as_u16().to_string();
    let took = begun.elapsed();
    tracing::debug!(parent: &span, %status, took_ms = took.as_secs_f64() * 1e3, "answered");
    metrics::counter!("lutra_http_requests_total", "route" => route.clone(), "method" => method, "status" => status)
        .increment(1);
    metrics::histogram!("lutra_http_request_seconds", "route" => route).record(took.as_secs_f64());
    response
}

/// A method's name; a request may claim any.
fn known(method: &Method) -> &'static str {
    match *method {
        Method::GET => "GET",
        Method::HEAD => "HEAD",
        Method::POST => "POST",
        Method::PUT => "PUT",
        Method::DELETE => "DELETE",
        Method::OPTIONS => "OPTIONS",
        Method::PATCH => "PATCH",
        _ => "other",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_method_that_a_stranger_makes_up_is_no_series_of_its_own() {
        let made_up = Method::from_bytes(b"X1234").unwrap();
        assert_eq!((known(&made_up), known(&Method::DELETE)), ("other", "DELETE"));
    }
}
