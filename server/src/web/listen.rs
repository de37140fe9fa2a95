//! Accepts connections, encrypted or not, and serves HTTP/1.1 on them until stopped. HTTP/2 is deliberately absent: by it a
//! browser puts all requests on one connection, and STOP waits behind downloads or hangs with them; by HTTP/1.1 the pages keep
//! a connection for STOP.
//!
//! The number of open connections is limited ([`super::connections`]); further ones wait in the kernel's queue. A peer that
//! does not complete its TLS handshake or its request's head in ten seconds is dropped.

use super::connections::{Placed, Places};
use super::error::ApiError;
use super::peer::Peer;
use api::say;
use axum::Router;
use axum::body::Body;
use axum::http::{Request, StatusCode};
use axum::response::{IntoResponse as _, Response};
use hyper::body::Incoming;
use hyper_util::rt::{TokioIo, TokioTimer};
use std::net::{IpAddr, SocketAddr};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpListener, TcpStream};
use tokio_rustls::TlsAcceptor;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;
use tower::ServiceExt as _;

/// Most bytes of a request's head: beyond these it is refused in words, and beyond the buffer, which `hyper` watches, without.
const HEAD_BYTES: usize = 32 * 1024;
const BUFFER_BYTES: usize = 48 * 1024;
/// How long a peer may take for its handshake, and again for a request's head.
const HEAD_TIMEOUT: Duration = Duration::from_secs(10);
/// How long requests that are being answered may take to end once the server stops.
const DRAIN: Duration = Duration::from_secs(8);

/// The listener and its settings.
pub(crate) struct Web {
    pub(crate) listener: TcpListener,
    pub(crate) tls: Option<TlsAcceptor>,
    pub(crate) router: Router,
    pub(crate) max_connections: usize,
    /// Proxies, whose addresses many clients share.
    pub(crate) proxies: Vec<IpAddr>,
}

impl Web {
    /// Serves until `stop`, then lets running requests end.
    pub(crate) async fn run(self, stop: CancellationToken) {
        let places = Places::new(self.max_connections, &self.proxies);
        let open = TaskTracker::new();
        loop {
            let next = async {
                let permit = places.free().await;
                (permit, self.listener.accept().await)
            };
            let (permit, accepted) = tokio::select! {
                next = next => next,
                () = stop.cancelled() => break,
            };
            let (stream, address) = match accepted {
                Ok(accepted) => accepted,
                Err(error) => {
                    // Most likely out of file handles: only waiting helps.
                    tracing::warn!(%error, "cannot accept a connection");
                    tokio::time::sleep(Duration::from_millis(100)).await;
                    continue;
                }
            };
            let Some(place) = permit.and_then(|permit| places.take(permit, address.ip())) else {
                tracing::debug!(%address, "refused: this address has its share of all connections");
                metrics::counter!("lutra_http_refused_connections_total").increment(1);
                continue;
            };
            stream.set_nodelay(true).ok();
            let stream = Placed::new(stream, place);
            let (tls, router, stop) = (self.tls.clone(), self.router.clone(), stop.clone());
            open.spawn(async move {
                match tls {
                    None => {
                        let peer = Peer { address, encrypted: false };
                        converse(stream, peer, router, stop).await;
                    }
                    Some(tls) => shake_hands(tls, stream, address, router, stop).await,
                }
            });
        }
        drop(self.listener);
        open.close();
        if tokio::time::timeout(DRAIN, open.wait()).await.is_err() {
            tracing::warn!("requests were cut off after {} s", DRAIN.as_secs());
        }
    }
}

async fn shake_hands(
    tls: TlsAcceptor,
    stream: Placed<TcpStream>,
    address: SocketAddr,
    router: Router,
    stop: CancellationToken,
) {
    match tokio::time::timeout(HEAD_TIMEOUT, tls.accept(stream)).await {
        Ok(Ok(stream)) => {
            let peer = Peer { address, encrypted: true };
            converse(stream, peer, router, stop).await;
        }
        Ok(Err(error)) => tracing::debug!(%address, %error, "no TLS handshake"),
        Err(_) => tracing::debug!(%address, "TLS handshake took too long"),
    }
}

/// About how many bytes the head of a request had.
fn head_bytes(request: &Request<Incoming>) -> usize {
    let target = request.uri().path_and_query().map_or(0, |target| target.as_str().len());
    let headers = request.headers().iter().map(|(name, value)| name.as_str().len() + value.len() + 4);
    target + headers.sum::<usize>()
}

fn head_too_large() -> Response {
    let text =
        say("Address and headers have more than {most} bytes, which is the most; ask for less at a time")
            .with("most", HEAD_BYTES);
    ApiError::new(StatusCode::REQUEST_HEADER_FIELDS_TOO_LARGE, "head_too_large", text).into_response()
}

async fn converse<S>(stream: S, peer: Peer, router: Router, stop: CancellationToken)
where
    S: AsyncRead + AsyncWrite + Unpin + Send + 'static,
{
    let service = hyper::service::service_fn(move |mut request: Request<Incoming>| {
        request.extensions_mut().insert(peer);
        let router = router.clone();
        async move {
            if head_bytes(&request) > HEAD_BYTES {
                return Ok(head_too_large());
            }
            router.oneshot(request.map(Body::new)).await
        }
    });
    let connection = hyper::server::conn::http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEAD_TIMEOUT)
        .max_buf_size(BUFFER_BYTES)
        .serve_connection(TokioIo::new(stream), service)
        .with_upgrades();
    let mut connection = std::pin::pin!(connection);
    let outcome = tokio::select! {
        outcome = connection.as_mut() => outcome,
        () = stop.cancelled() => {
            connection.as_mut().graceful_shutdown();
            connection.await
        }
    };
    if let Err(error) = outcome {
        tracing::debug!(address = %peer.address, %error, "connection ended");
    }
}
