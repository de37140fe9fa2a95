//! Headers of every answer: what a browser may do with it, and that it must not be cached.
//!
//! Scripts, styles, images and sockets are allowed from this server only and never inline, so that text from a vessel or a
//! person that reaches a page unescaped by mistake is not executed. One function adds them all: tower-http needs a layer
//! for each and has none for those that depend on the request.

use super::peer::Peer;
use axum::extract::Request;
use axum::http::{HeaderMap, HeaderName, HeaderValue, header};
use axum::middleware::Next;
use axum::response::Response;

/// `same-origin` as referrer keeps the `Origin` of posted forms, which `no-referrer` would turn to `null`.
const ALWAYS: [(HeaderName, &str); 8] = [
    (
        header::CONTENT_SECURITY_POLICY,
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; font-src 'self'; \
         connect-src 'self'; manifest-src 'self'; form-action 'self'; base-uri 'none'; frame-ancestors 'none'",
    ),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::X_FRAME_OPTIONS, "DENY"),
    (header::REFERRER_POLICY, "same-origin"),
    (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
    (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    (HeaderName::from_static("x-permitted-cross-domain-policies"), "none"),
    (
        HeaderName::from_static("permissions-policy"),
        "gamepad=(self), geolocation=(self), camera=(), microphone=(), payment=(), usb=()",
    ),
];

/// Adds the headers; `Cache-Control: no-store` unless the handler said otherwise.
pub(crate) async fn add(request: Request, next: Next) -> Response {
    let encrypted = request.extensions().get::<Peer>().is_some_and(|peer| peer.encrypted);
    let by_name = is_by_name(request.headers());
    let is_link = request.uri().path().starts_with("/s/");
    let mut response = next.run(request).await;
    let headers = response.headers_mut();
    for (name, value) in ALWAYS {
        headers.insert(name, HeaderValue::from_static(value));
    }
    if is_link {
        // The address of a link gives access to its data: no answer to it may be indexed by search engines.
        headers
            .insert(HeaderName::from_static("x-robots-tag"), HeaderValue::from_static("noindex, nofollow"));
    }
    headers.entry(header::CACHE_CONTROL).or_insert(HeaderValue::from_static("no-store"));
    if encrypted && by_name {
        headers.insert(header::STRICT_TRANSPORT_SECURITY, HeaderValue::from_static("max-age=31536000"));
    }
    response
}

/// Whether the request uses the server's own host name: `localhost` is shared with other programs, and browsers would block
/// plain HTTP for these too.
fn is_by_name(headers: &HeaderMap) -> bool {
    let host = headers.get(header::HOST).and_then(|host| host.to_str().ok()).unwrap_or_default();
    host.split(':').next() != Some("localhost")
}
