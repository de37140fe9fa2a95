//! Which scripts of other web pages may read the API (CORS, by the Fetch standard): those of `http.cors_origins`, with a token.
//!
//! The threat is a page that a person opens beside Lutra's and that reads their fleet with their session. So a session never opens this
//! door: an answer gets the header that lets a foreign script read it only where the request has `Authorization: Bearer` and no cookie,
//! and `Access-Control-Allow-Credentials` is never sent, so that browsers keep answers to requests with cookies from the script whatever
//! else they hold. A token gives a script what a person pasted it for, no more than `curl` could have with it, also where all origins are
//! allowed. Only GET and HEAD are allowed: an order to a vessel has to come from Lutra's own pages or from a program. WebSockets and the
//! pages are not part of it. `Cross-Origin-Resource-Policy: same-origin` on all answers stays: it bars embedding, not such requests.

use crate::config::Config;
use axum::extract::{Request, State};
use axum::http::header::{
    ACCESS_CONTROL_ALLOW_HEADERS, ACCESS_CONTROL_ALLOW_METHODS, ACCESS_CONTROL_ALLOW_ORIGIN,
    ACCESS_CONTROL_EXPOSE_HEADERS, ACCESS_CONTROL_MAX_AGE, ACCESS_CONTROL_REQUEST_HEADERS,
    ACCESS_CONTROL_REQUEST_METHOD, AUTHORIZATION, COOKIE, ORIGIN, VARY,
};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode};
use axum::middleware::Next;
use axum::response::{IntoResponse as _, Response};
use std::sync::Arc;

/// Headers that a script may send. Browsers ask for those that are not harmless by themselves.
const SENT: [&str; 6] = ["authorization", "accept", "if-none-match", "if-range", "range", "accept-language"];
/// Headers of answers that a script may read, beside the few that it always may.
const READ: &str = "content-disposition, content-range, etag, link, retry-after, x-request-id";
/// How long a browser may keep the answer to a preflight request (s): short, so that a page that is no longer allowed is soon refused.
const AGAIN_S: &str = "600";

/// Answers a browser's question whether a script may ask, and marks answers that a script may read.
pub(crate) async fn answer(State(config): State<Arc<Config>>, request: Request, next: Next) -> Response {
    let allowed = &config.http.cors_origins;
    if allowed.is_empty() || !request.uri().path().starts_with("/api/v1/") {
        return next.run(request).await;
    }
    let (method, asked) = (request.method().clone(), request.headers().clone());
    let origin = allowed_origin(allowed, &asked);
    let is_preflight = origin.is_some() && is_allowed_preflight(&method, &asked);
    let mut response = if is_preflight { preflight() } else { next.run(request).await };
    let headers = response.headers_mut();
    // Caches must not give one page the answer that another was allowed to read.
    headers.append(VARY, ORIGIN.into());
    if method == Method::OPTIONS {
        headers.append(VARY, ACCESS_CONTROL_REQUEST_METHOD.into());
        headers.append(VARY, ACCESS_CONTROL_REQUEST_HEADERS.into());
    }
    if let Some(origin) = origin.filter(|_| is_preflight || is_read_by_token(&method, &asked)) {
        headers.insert(ACCESS_CONTROL_ALLOW_ORIGIN, origin);
        headers.insert(ACCESS_CONTROL_EXPOSE_HEADERS, HeaderValue::from_static(READ));
    }
    response
}

/// What names the page that asks, where it is allowed.
fn allowed_origin(allowed: &[String], asked: &HeaderMap) -> Option<HeaderValue> {
    let origin = asked.get(ORIGIN)?;
    if allowed.iter().any(|one| one == "*") {
        return Some(HeaderValue::from_static("*"));
    }
    let text = origin.to_str().ok()?;
    allowed.iter().any(|one| one.eq_ignore_ascii_case(text)).then(|| origin.clone())
}

/// Whether a browser asks before a request that is allowed.
fn is_allowed_preflight(method: &Method, asked: &HeaderMap) -> bool {
    let text = |name: HeaderName| asked.get(name).map(|value| value.to_str().unwrap_or("?"));
    let wanted = text(ACCESS_CONTROL_REQUEST_METHOD);
    let headers = text(ACCESS_CONTROL_REQUEST_HEADERS).unwrap_or_default();
    let mut names = headers.split(',').map(str::trim).filter(|name| !name.is_empty());
    method == Method::OPTIONS
        && matches!(wanted, Some("GET" | "HEAD"))
        && names.all(|name| SENT.iter().any(|sent| sent.eq_ignore_ascii_case(name)))
}

fn preflight() -> Response {
    let headers = [
        (ACCESS_CONTROL_ALLOW_METHODS, "GET, HEAD".to_owned()),
        (ACCESS_CONTROL_ALLOW_HEADERS, SENT.join(", ")),
        (ACCESS_CONTROL_MAX_AGE, AGAIN_S.to_owned()),
    ];
    (StatusCode::NO_CONTENT, headers).into_response()
}

/// Whether a request reads with a token, and without any cookie.
fn is_read_by_token(method: &Method, asked: &HeaderMap) -> bool {
    let token = asked.get(AUTHORIZATION).and_then(|value| value.to_str().ok());
    matches!(*method, Method::GET | Method::HEAD)
        && token.is_some_and(|token| token.starts_with("Bearer "))
        && !asked.contains_key(COOKIE)
}
