//! HTTP/2 on an encrypted connection: its limits, and requests as the rest of the server knows them from HTTP/1.1.
//!
//! One connection carries many requests. Bounds: [`STREAMS`] at once, and the client waits with more; a client that takes back
//! [`RESETS`] requests before they are begun is sent away (rapid reset, CVE-2023-44487); heads of [`super::exchange::HEAD_BYTES`];
//! a little buffer for each answer. A client may also stop reading an answer by its window alone, while its socket is
//! drained, which [`super::connections`] cannot see: [`Streams`] does. A connection with such an answer, or without requests for a
//! while, takes no more requests, and is cut when those that it has had their time.
//!
//! WebSockets stay with HTTP/1.1: extended CONNECT (RFC 8441) is not offered, so browsers open a connection of their own for
//! the live socket, which the other requests then cannot delay.

use super::exchange::{HEAD_BYTES, Peer, answer};
use axum::Router;
use axum::body::{Body, Bytes};
use axum::http::{HeaderValue, Request, Uri, header};
use hyper::body::{Body as HttpBody, Frame, Incoming, SizeHint};
use hyper_util::rt::{TokioExecutor, TokioIo, TokioTimer};
use std::collections::BTreeMap;
use std::convert::Infallible;
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::time::Instant;
use tokio_util::sync::CancellationToken;

/// The protocol's name in a TLS handshake.
pub(crate) const ALPN: &[u8] = b"h2";
/// Requests of a connection that are answered at once.
const STREAMS: u32 = 64;
/// Requests that were taken back before they were begun.
const RESETS: usize = 20;
/// Answers that were reset because the client broke the protocol.
const ERRORS: usize = 64;
/// What a client may send ahead: of one request's body, and of all together.
const STREAM_WINDOW_BYTES: u32 = 256 * 1024;
const CONNECTION_WINDOW_BYTES: u32 = 1024 * 1024;
/// What waits for the client's window, for each answer.
const SEND_BYTES: usize = 64 * 1024;
/// A client is asked for a sign of life so often, and must give it within the same time.
const PING: Duration = Duration::from_secs(20);

/// How long a client may let a connection wait.
#[derive(Debug, Clone, Copy)]
struct Patience {
    /// A connection without requests ends after this.
    idle: Duration,
    /// An answer of which the client takes nothing for this long ends its connection.
    stalled: Duration,
    /// How long other requests may then take to end.
    drain: Duration,
    /// How often idle connections and stalled answers are looked for.
    look: Duration,
}

const PATIENCE: Patience = Patience {
    idle: Duration::from_mins(1),
    stalled: Duration::from_mins(1),
    drain: Duration::from_secs(8),
    look: Duration::from_secs(5),
};

/// Serves a connection until it ends, or `stop` and its requests are answered.
pub(super) async fn converse<S>(
    stream: S,
    peer: Peer,
    router: Router,
    stop: CancellationToken,
) -> hyper::Result<()>
where
    S: AsyncRead + AsyncWrite + Unpin + Send + 'static,
{
    converse_within(PATIENCE, stream, peer, router, stop).await
}

async fn converse_within<S>(
    patience: Patience,
    stream: S,
    peer: Peer,
    router: Router,
    stop: CancellationToken,
) -> hyper::Result<()>
where
    S: AsyncRead + AsyncWrite + Unpin + Send + 'static,
{
    let streams = Streams::new();
    let open = streams.clone();
    let service = hyper::service::service_fn(move |request: Request<Incoming>| {
        let (stream, router) = (open.open(), router.clone());
        async move {
            let mut request = as_before(request);
            request.extensions_mut().insert(peer);
            let response = answer(router, request.map(Body::new)).await;
            // Its body is not asked for before the client's window has room.
            stream.is_waiting(Some(Instant::now()));
            Ok::<_, Infallible>(response.map(|body| Watched { body, stream }))
        }
    });
    let connection = hyper::server::conn::http2::Builder::new(TokioExecutor::new())
        .timer(TokioTimer::new())
        .max_concurrent_streams(STREAMS)
        .max_pending_accept_reset_streams(RESETS)
        .max_local_error_reset_streams(ERRORS)
        .max_header_list_size(HEAD_BYTES as u32)
        .initial_stream_window_size(STREAM_WINDOW_BYTES)
        .initial_connection_window_size(CONNECTION_WINDOW_BYTES)
        .max_send_buf_size(SEND_BYTES)
        .keep_alive_interval(PING)
        .keep_alive_timeout(PING)
        .serve_connection(TokioIo::new(stream), service);
    let mut connection = std::pin::pin!(connection);
    tokio::select! {
        outcome = connection.as_mut() => return outcome,
        () = stop.cancelled() => {
            connection.as_mut().graceful_shutdown();
            // The listener bounds the time.
            return connection.await;
        }
        () = streams.are_over(patience) => connection.as_mut().graceful_shutdown(),
    }
    // When the time is over it is dropped, and with it whatever the client does not take.
    tokio::time::timeout(patience.drain, connection).await.unwrap_or(Ok(()))
}

/// A request in the form of HTTP/1.1: the host in its header, its address without it, and one header of cookies, which
/// clients may divide (RFC 9113, 8.2.3).
fn as_before(mut request: Request<Incoming>) -> Request<Incoming> {
    let uri = request.uri();
    let host = uri.authority().and_then(|authority| HeaderValue::from_str(authority.as_str()).ok());
    let address = uri.path_and_query().cloned().map(Uri::from);
    if let Some(address) = address {
        *request.uri_mut() = address;
    }
    let headers = request.headers_mut();
    if let Some(host) = host {
        headers.insert(header::HOST, host);
    }
    let cookies: Vec<&[u8]> = headers.get_all(header::COOKIE).iter().map(HeaderValue::as_bytes).collect();
    if cookies.len() > 1
        && let Ok(joined) = HeaderValue::from_bytes(&cookies.join(&b"; "[..]))
    {
        headers.insert(header::COOKIE, joined);
    }
    request
}

/// The requests of a connection.
#[derive(Debug, Clone)]
struct Streams(Arc<Mutex<Open>>);

#[derive(Debug)]
struct Open {
    next: u64,
    /// Requests by number: since when the client has not asked for more of the answer. `None` while the server works.
    waiting: BTreeMap<u64, Option<Instant>>,
    /// When the last of them ended.
    quiet: Instant,
}

impl Streams {
    fn new() -> Self {
        Self(Arc::new(Mutex::new(Open { next: 0, waiting: BTreeMap::new(), quiet: Instant::now() })))
    }

    fn lock(&self) -> MutexGuard<'_, Open> {
        // Changes under this lock are atomic.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn open(&self) -> Stream {
        let mut open = self.lock();
        let number = open.next;
        open.next += 1;
        open.waiting.insert(number, None);
        Stream { of: self.clone(), number }
    }

    /// Waits until the connection has had no request for long, or an answer is not taken.
    async fn are_over(&self, patience: Patience) {
        let mut every = tokio::time::interval(patience.look);
        while !self.lock().is_over(Instant::now(), patience) {
            every.tick().await;
        }
    }
}

impl Open {
    fn is_over(&self, now: Instant, patience: Patience) -> bool {
        let is_stalled = |since: &Option<Instant>| since.is_some_and(|since| now - since >= patience.stalled);
        self.waiting.values().any(is_stalled) || self.waiting.is_empty() && now - self.quiet >= patience.idle
    }
}

/// One request, until it is dropped.
#[derive(Debug)]
struct Stream {
    of: Streams,
    number: u64,
}

impl Stream {
    fn is_waiting(&self, since: Option<Instant>) {
        self.of.lock().waiting.insert(self.number, since);
    }
}

impl Drop for Stream {
    fn drop(&mut self) {
        let mut open = self.of.lock();
        open.waiting.remove(&self.number);
        open.quiet = Instant::now();
    }
}

/// An answer's body. It is asked for its next part once the client's window has room for it.
struct Watched {
    body: Body,
    stream: Stream,
}

impl HttpBody for Watched {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        let this = self.get_mut();
        let frame = Pin::new(&mut this.body).poll_frame(context);
        this.stream.is_waiting(frame.is_ready().then(Instant::now));
        frame
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::routing::get;
    use http_body_util::{BodyExt as _, Empty};
    use hyper::client::conn::http2::SendRequest;
    use std::net::SocketAddr;
    use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _, DuplexStream};
    use tokio::task::JoinHandle;

    fn router() -> Router {
        let told = async |request: Request<Body>| {
            let text = |name| request.headers().get(name).map_or("", |value| value.to_str().unwrap());
            format!("{} {} {}", request.uri(), text(header::HOST), text(header::COOKIE))
        };
        let large = async || Body::from(vec![7; 8 << 20]);
        // Never says more, as a live answer without news.
        let quiet = async || {
            use futures_util::StreamExt as _;
            let first = futures_util::stream::iter([Ok::<_, Infallible>("first")]);
            Body::from_stream(first.chain(futures_util::stream::pending()))
        };
        Router::new().route("/told", get(told)).route("/large", get(large)).route("/quiet", get(quiet))
    }

    type Serving = JoinHandle<hyper::Result<()>>;

    /// A short patience, so that tests wait for its end.
    const SHORT: Patience = Patience {
        idle: Duration::from_millis(100),
        stalled: Duration::from_millis(100),
        drain: Duration::from_millis(50),
        look: Duration::from_millis(10),
    };

    /// The client's end of a connection, and its server.
    fn serve(patience: Patience, stop: &CancellationToken) -> (DuplexStream, Serving) {
        let (ours, theirs) = tokio::io::duplex(1 << 20);
        let address: SocketAddr = "192.0.2.9:1".parse().unwrap();
        let peer = Peer { address, encrypted: true };
        (ours, tokio::spawn(converse_within(patience, theirs, peer, router(), stop.clone())))
    }

    async fn client(patience: Patience, stop: &CancellationToken) -> (SendRequest<Empty<Bytes>>, Serving) {
        client_with(patience, stop, 1 << 20).await
    }

    /// A client whose window for each answer is so wide.
    async fn client_with(
        patience: Patience,
        stop: &CancellationToken,
        window_bytes: u32,
    ) -> (SendRequest<Empty<Bytes>>, Serving) {
        let (stream, serving) = serve(patience, stop);
        let made = hyper::client::conn::http2::Builder::new(TokioExecutor::new())
            .timer(TokioTimer::new())
            .initial_stream_window_size(window_bytes)
            .handshake(TokioIo::new(stream));
        let (sender, connection) = made.await.unwrap();
        tokio::spawn(connection);
        (sender, serving)
    }

    fn ask(path: &str) -> Request<Empty<Bytes>> {
        Request::get(format!("https://boat:8443{path}")).body(Empty::new()).unwrap()
    }

    #[tokio::test]
    async fn handlers_see_a_request_as_by_http1() {
        let (mut client, _serving) = client(PATIENCE, &CancellationToken::new()).await;
        let mut request = ask("/told?a=1");
        for crumb in ["session=x", "lang=nb"] {
            request.headers_mut().append(header::COOKIE, HeaderValue::from_static(crumb));
        }
        let response = client.send_request(request).await.unwrap();
        assert_eq!(response.version(), axum::http::Version::HTTP_2);
        let body = response.into_body().collect().await.unwrap().to_bytes();
        assert_eq!(body, "/told?a=1 boat:8443 session=x; lang=nb");
    }

    #[test]
    fn a_live_answer_without_news_is_no_stalled_client() {
        let streams = Streams::new();
        let began = Instant::now();
        let over = |s: u64| streams.lock().is_over(began + Duration::from_secs(s), PATIENCE);
        assert!(!over(59) && over(62), "without a request");
        let stream = streams.open();
        assert!(!over(3_600), "the server works, or has no news yet");
        stream.is_waiting(Some(began));
        assert!(!over(59) && over(60), "the client has not asked for the next part");
        stream.is_waiting(None);
        assert!(!over(3_600), "it asked, and the server has nothing");
        drop(stream);
        assert!(over(3_600));
    }

    #[tokio::test]
    async fn a_connection_without_requests_ends_and_one_with_a_live_answer_stays() {
        let (mut client, serving) = client(SHORT, &CancellationToken::new()).await;
        let mut response = client.send_request(ask("/quiet")).await.unwrap();
        let first = response.frame().await.unwrap().unwrap().into_data().unwrap();
        assert_eq!(first, "first");
        let next = tokio::time::timeout(SHORT.idle * 5, response.frame()).await;
        assert!(next.is_err() && !serving.is_finished(), "it has no news, and is not cut");
        drop(response);
        serving.await.unwrap().ok();
    }

    #[tokio::test]
    async fn an_answer_that_is_not_taken_ends_its_connection_and_is_not_complete() {
        // A client that takes some of it, and one whose window is closed from the beginning.
        for window_bytes in [1 << 20, 0] {
            let (mut client, serving) = client_with(SHORT, &CancellationToken::new(), window_bytes).await;
            let stalled = client.send_request(ask("/large")).await.unwrap();
            serving.await.unwrap().ok();
            assert!(stalled.into_body().collect().await.is_err(), "{window_bytes}");
        }
    }

    #[tokio::test]
    async fn a_stop_lets_answers_end() {
        let stop = CancellationToken::new();
        let (mut client, serving) = client(PATIENCE, &stop).await;
        let response = client.send_request(ask("/large")).await.unwrap();
        stop.cancel();
        let body = response.into_body().collect().await.unwrap().to_bytes();
        assert_eq!(body.len(), 8 << 20, "longer than every window");
        serving.await.unwrap().unwrap();
    }

    /// Requests that are taken back at once, as in the attack of 2023: frames by hand, for no client sends them so.
    #[tokio::test]
    async fn who_takes_requests_back_at_once_is_sent_away() {
        let (mut stream, serving) = serve(PATIENCE, &CancellationToken::new());
        let frame = |kind: u8, flags: u8, number: u32, payload: &[u8]| {
            let length = (payload.len() as u32).to_be_bytes();
            [&length[1..], &[kind, flags], &number.to_be_bytes(), payload].concat()
        };
        let mut bytes = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n".to_vec();
        bytes.extend(frame(4, 0, 0, &[]));
        // GET https://boat/told in HPACK, then RST_STREAM with CANCEL.
        let head = [&[0x82, 0x87, 0x04, 5][..], b"/told", &[0x01, 4], b"boat"].concat();
        for request in 0..500 {
            bytes.extend(frame(1, 5, request * 2 + 1, &head));
            bytes.extend(frame(3, 0, request * 2 + 1, &8_u32.to_be_bytes()));
        }
        stream.write_all(&bytes).await.unwrap();
        let mut answered = Vec::new();
        stream.read_to_end(&mut answered).await.unwrap();
        // The last frame is GOAWAY with ENHANCE_YOUR_CALM.
        let is_calm = answered.windows(9).any(|head| head[3] == 7)
            && answered.windows(4).any(|code| code == 11_u32.to_be_bytes());
        assert!(is_calm, "{answered:?}");
        assert!(serving.await.unwrap().is_err());
    }
}
