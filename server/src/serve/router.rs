//! The table of all routes, and the router made from it.

use crate::AppState;
use crate::web::guard::{RouteContext, guard};
use crate::web::peer::Peer;
use crate::web::{
    ApiError, BodyLimit, Kind, Need, Remote, Route, cors, headers, identify, language, measure, slow_bodies,
};
use crate::{http, pages, transports};
use api::say;
use axum::body::HttpBody as _;
use axum::extract::{DefaultBodyLimit, Request, State};
use axum::http::StatusCode;
use axum::http::request::Parts;
use axum::middleware::Next;
use axum::response::{IntoResponse as _, Response};
use axum::{Extension, Router};
use shore::identity::Language;
use std::any::Any;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use std::time::Duration;
use tower_http::catch_panic::CatchPanicLayer;
use tower_http::compression::CompressionLayer;
use tower_http::compression::predicate::{DefaultPredicate, NotForContentType, Predicate as _};
use tower_http::timeout::RequestBodyTimeoutLayer;

/// Most bytes of a request's body unless a route allows more.
const BODY_BYTES: usize = 64 * 1024;
/// How long a body may pause.
const BODY_PAUSE: Duration = Duration::from_secs(30);

/// All routes.
pub(crate) fn table() -> Vec<Route> {
    let mut table = http::routes::table();
    table.push(Route::socket("/link", Need::Link, "A vessel's link: a WebSocket.", transports::open_link));
    table.extend(pages::routes());
    table
}

/// The whole web server.
pub(crate) fn router(state: AppState) -> Router {
    let mut router = Router::new();
    for route in table() {
        let post = RouteContext {
            state: state.clone(),
            need: route.need,
            kind: route.kind,
            to_unknown: route.to_unknown,
            refusal: pages::refusal,
        };
        // A gzip file is not compressed again.
        let unpacked = DefaultPredicate::new().and(NotForContentType::const_new("application/gzip"));
        let pack = CompressionLayer::new().compress_when(unpacked);
        let handler = if route.packed { route.handler.layer(pack) } else { route.handler };
        let guarded = handler.route_layer(axum::middleware::from_fn_with_state(post, guard));
        let guarded = if route.paces {
            guarded
        } else {
            guarded.route_layer(axum::middleware::from_fn(slow_bodies::keep))
        };
        router = router.route(route.path, guarded);
    }
    router
        .fallback(nowhere)
        .layer(axum::middleware::from_fn(wrong_method))
        .layer(axum::middleware::from_fn_with_state(Arc::<AtomicU64>::default(), measure::measure))
        .layer(DefaultBodyLimit::max(BODY_BYTES))
        .layer(Extension(BodyLimit(BODY_BYTES)))
        .layer(RequestBodyTimeoutLayer::new(BODY_PAUSE))
        .layer(axum::middleware::from_fn_with_state(Arc::clone(&state.config), cors::answer))
        .layer(axum::middleware::from_fn(headers::add))
        .layer(CatchPanicLayer::custom(panicked))
        .with_state(state)
}

/// The kind of client that probably asks for an address that has no route.
fn kind_of(path: &str) -> Kind {
    if path.starts_with("/api/") { Kind::Api } else { Kind::Page }
}

/// Puts words into the refusal of a method that an address does not have: the router makes it without any. Which methods the address
/// has stands in the header `Allow`, which the router adds to the answer.
async fn wrong_method(request: Request, next: Next) -> Response {
    let (method, kind) = (request.method().clone(), kind_of(request.uri().path()));
    let language = language::asked(request.headers());
    let response = next.run(request).await;
    let is_empty = response.body().size_hint().exact() == Some(0);
    if response.status() != StatusCode::METHOD_NOT_ALLOWED || !is_empty {
        return response;
    }
    let text =
        say("{method} is not possible at this address; the header Allow says what is").with("method", method);
    let error = ApiError::new(StatusCode::METHOD_NOT_ALLOWED, "wrong_method", text);
    language::within(language, async { pages::refusal(kind, None, error) }).await
}

/// The answer of a handler that panicked; the panic itself is logged.
fn panicked(_: Box<dyn Any + Send>) -> Response {
    ApiError::internal(&"a handler panicked").into_response()
}

async fn nowhere(State(state): State<AppState>, request: Request) -> Response {
    let (parts, _) = request.into_parts();
    let kind = kind_of(parts.uri.path());
    let error = ApiError::not_found(say("There is nothing here. The fleet is at /."));
    let language = reads(&state, &parts).await;
    language::within(language, async { pages::refusal(kind, None, error) }).await
}

/// The reader's language, where no guard stands.
async fn reads(state: &AppState, parts: &Parts) -> Language {
    let Some(peer) = parts.extensions.get::<Peer>().copied() else { return language::asked(&parts.headers) };
    let remote = Remote::of(peer, &parts.headers, &state.config.http);
    let who = identify(state, &parts.headers, remote).await.ok().flatten();
    language::of(&parts.headers, who.as_ref())
}
