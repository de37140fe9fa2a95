//! A request and its answer, whatever version of HTTP carries them.

use axum::Router;
use axum::body::Body;
use axum::http::Request;
use axum::response::Response;
use std::net::SocketAddr;
use tower::ServiceExt as _;

/// Most bytes of a request's head.
pub(super) const HEAD_BYTES: usize = 32 * 1024;

/// The other end of a connection.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Peer {
    /// Its address, or that of the last proxy before us.
    pub(crate) address: SocketAddr,
    /// Whether the connection is encrypted up to this process.
    pub(crate) encrypted: bool,
}

pub(super) async fn answer(router: Router, request: Request<Body>) -> Response {
    match router.oneshot(request).await {
        Ok(response) => response,
        Err(never) => match never {},
    }
}
