//! Middleware before every route: authenticates the requester and checks permissions.

use super::csrf;
use super::error::ApiError;
use super::language;
use super::peer::Peer;
use super::remote::Remote;
use super::route::{Kind, Need};
use crate::AppState;
use api::{Role, say};
use axum::RequestExt as _;
use axum::extract::{FromRequestParts, RawPathParams, Request, State};
use axum::http::request::Parts;
use axum::http::{HeaderMap, StatusCode, header};
use axum::middleware::Next;
use axum::response::Response;
use imc::Address;
use shore::identity::{Principal, Secret, Via};

/// The cookie of a browser's session.
pub(crate) const SESSION_COOKIE: &str = "lutra_session";

/// The code of a refusal to somebody without any role, who sees only what is shared with them.
pub(crate) const NO_ROLE: &str = "no_role";

/// Makes the answer for a refusal: kind of route, where to continue after a login, and the error.
pub(crate) type Refusal = fn(Kind, Option<&str>, ApiError) -> Response;

/// The guard's data about its route.
#[derive(Clone)]
pub(crate) struct RouteContext {
    pub(crate) state: AppState,
    pub(crate) need: Need,
    pub(crate) kind: Kind,
    /// Whether the vessel in the path may be one that is not known.
    pub(crate) to_unknown: bool,
    /// Formats a refusal for the kind of client.
    pub(crate) refusal: Refusal,
}

/// The requester, for handlers of routes that need authentication.
#[derive(Debug, Clone)]
pub(crate) struct Who(pub(crate) Principal);

impl<S: Sync> FromRequestParts<S> for Who {
    type Rejection = ApiError;
    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, ApiError> {
        let who = parts.extensions.get::<Principal>().cloned();
        who.map(Self).ok_or_else(ApiError::not_logged_in)
    }
}

/// Who asks, for handlers of routes that anyone may use.
#[derive(Debug, Clone)]
pub(crate) struct MaybeWho(pub(crate) Option<Principal>);

impl<S: Sync> FromRequestParts<S> for MaybeWho {
    type Rejection = std::convert::Infallible;
    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Self::Rejection> {
        Ok(Self(parts.extensions.get::<Principal>().cloned()))
    }
}

/// The vessel in the path, for handlers behind [`Need::OnVessel`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct OfVessel(pub(crate) Address);

impl<S: Sync> FromRequestParts<S> for OfVessel {
    type Rejection = ApiError;
    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, ApiError> {
        let vessel = parts.extensions.get::<Self>().copied();
        vessel.ok_or_else(|| ApiError::internal(&"a handler for a vessel behind a route without one"))
    }
}

/// The vessel (IMC address) that opens its link, for the handler behind [`Need::Link`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct LinkOf(pub(crate) u16);

impl<S: Sync> FromRequestParts<S> for LinkOf {
    type Rejection = ApiError;
    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, ApiError> {
        parts.extensions.get::<Self>().copied().ok_or_else(ApiError::not_logged_in)
    }
}

/// The vessel of the link token in a request.
async fn link_of(state: &AppState, headers: &HeaderMap) -> Result<LinkOf, ApiError> {
    let given = headers.get(header::AUTHORIZATION).and_then(|given| given.to_str().ok());
    let token = given.and_then(|given| given.strip_prefix("Bearer ")).ok_or_else(ApiError::not_logged_in)?;
    let vessel = state.shore.people.by_link_token(token.trim()).await?;
    vessel.map(LinkOf).ok_or_else(ApiError::not_logged_in)
}

/// Passes a request on, or answers with a refusal in its reader's language.
pub(crate) async fn guard(State(post): State<RouteContext>, request: Request, next: Next) -> Response {
    let language = language::asked(request.headers());
    language::within(language, answer(post, request, next)).await
}

async fn answer(post: RouteContext, mut request: Request, next: Next) -> Response {
    let Some(peer) = request.extensions().get::<Peer>().copied() else {
        return refuse(&post, &request, ApiError::internal(&"a request without a connection"));
    };
    let remote = Remote::of(peer, request.headers(), &post.state.config.http);
    request.extensions_mut().insert(remote);
    if post.need == Need::Link {
        return match link_of(&post.state, request.headers()).await {
            Ok(link) => {
                request.extensions_mut().insert(link);
                next.run(request).await
            }
            Err(error) => {
                if error.status == StatusCode::UNAUTHORIZED {
                    let why = say("no token of a vessel's link, or one that does not hold any more");
                    post.state.shore.router.ledger().refused(hub::Transport::Link, remote.address, why);
                }
                refuse(&post, &request, error)
            }
        };
    }
    let who = match identify(&post.state, request.headers(), remote).await {
        Ok(who) => who,
        Err(error) => return refuse(&post, &request, error),
    };
    let language = language::of(request.headers(), who.as_ref());
    language::within(language, admit(post, request, remote, who, next)).await
}

/// Lets a request in where its sender may.
async fn admit(
    post: RouteContext,
    mut request: Request,
    remote: Remote,
    who: Option<Principal>,
    next: Next,
) -> Response {
    if let Err(error) = may(&post, &mut request, remote, who.as_ref()).await {
        return refuse(&post, &request, error);
    }
    let request = match comes_from_us(&post, request, who.as_ref()).await {
        Ok(request) => request,
        Err(response) => return *response,
    };
    let mut request = request;
    if let Some(who) = who {
        request.extensions_mut().insert(who);
    }
    next.run(request).await
}

/// Authenticates the requester: by token if there is one, else by session.
pub(crate) async fn identify(
    state: &AppState,
    headers: &HeaderMap,
    remote: Remote,
) -> Result<Option<Principal>, ApiError> {
    if let Some(given) = headers.get(header::AUTHORIZATION) {
        let token = given.to_str().ok().and_then(|given| given.strip_prefix("Bearer "));
        let Some(token) = token else { return Err(ApiError::not_logged_in()) };
        return match state.shore.people.by_token(token.trim()).await? {
            Some(who) => Ok(Some(who)),
            None => Err(ApiError::not_logged_in()),
        };
    }
    let Some(secret) = cookie(headers, &cookie_name(SESSION_COOKIE, remote)) else { return Ok(None) };
    Ok(state.shore.people.by_session(&secret).await?)
}

/// Whether `who` may use the route.
async fn may(
    post: &RouteContext,
    request: &mut Request,
    remote: Remote,
    who: Option<&Principal>,
) -> Result<(), ApiError> {
    if post.need == Need::Anyone || (post.need == Need::Figures && remote.here) {
        return Ok(());
    }
    let who = who.ok_or_else(ApiError::not_logged_in)?;
    if post.need == Need::Session {
        let browser = matches!(who.via, Via::Session { .. });
        return if browser {
            Ok(())
        } else {
            Err(ApiError::forbidden(say("This is for browsers, not for tokens.")))
        };
    }
    if let Via::Session { must_change_password: true, .. } = who.via {
        let text = say("Choose a password of your own first, at /account.");
        return Err(ApiError { code: "password_change_required", ..ApiError::forbidden(text) });
    }
    if post.need == Need::Account {
        return Ok(());
    }
    let (has, least, text) = match post.need {
        Need::Somewhere(least) => (
            who.grants.somewhere(),
            least,
            say("{name} may not do this: that needs the role {role} on at least one vessel. Ask an admin."),
        ),
        Need::OnVessel(least) => return may_on_vessel(post, request, who, least).await,
        Need::Everywhere(_) | Need::Figures => (
            who.grants.everywhere(),
            if let Need::Everywhere(least) = post.need { least } else { Role::Admin },
            say("{name} may not do this: that needs the role {role} on all vessels. Ask an admin."),
        ),
        Need::Anyone | Need::Session | Need::Account | Need::Link => return Ok(()),
    };
    if has >= Some(least) {
        return Ok(());
    }
    let refusal = ApiError::forbidden(text.with("name", &who.name).with("role", least));
    let code = if who.grants.somewhere().is_none() { NO_ROLE } else { refusal.code };
    Err(ApiError { code, ..refusal })
}

/// Whether `who` may use a route of the vessel in the path, which is given by name or address.
async fn may_on_vessel(
    post: &RouteContext,
    request: &mut Request,
    who: &Principal,
    least: Role,
) -> Result<(), ApiError> {
    let parameters =
        request.extract_parts::<RawPathParams>().await.map_err(|error| ApiError::internal(&error))?;
    let text = parameters.iter().find(|(name, _)| *name == "vessel").map(|(_, value)| value);
    let text = text.ok_or_else(|| ApiError::internal(&"a route for a vessel without {vessel}"))?;
    let shore = &post.state.shore;
    let sees = |vessel: u16| who.grants.on(vessel).is_some();
    let vessel = shore.address_of(text, &sees).await?;
    if who.grants.on(vessel.0) < Some(least) {
        let text =
            say("{name} may not do this: that needs the role {role} on vessel {vessel}. Ask an admin.");
        let text = text.with("vessel", vessel.0).with("name", &who.name).with("role", least);
        return Err(ApiError::forbidden(text));
    }
    if !post.to_unknown {
        shore.must_be_known(vessel, &sees).await?;
    }
    request.extensions_mut().insert(OfVessel(vessel));
    Ok(())
}

/// Refuses changes and sockets that another site's page requests with our cookie.
async fn comes_from_us(
    post: &RouteContext,
    request: Request,
    who: Option<&Principal>,
) -> Result<Request, Box<Response>> {
    let http = &post.state.config.http;
    let foreign = || {
        let text = say("This came from another web page.");
        ApiError { code: "foreign_origin", ..ApiError::forbidden(text) }
    };
    let by_cookie = who.is_none_or(|who| matches!(who.via, Via::Session { .. }));
    if post.kind == Kind::Socket && by_cookie && !csrf::same_origin(request.headers(), http) {
        return Err(Box::new(refuse(post, &request, foreign())));
    }
    if request.method().is_safe() || !by_cookie {
        return Ok(request);
    }
    if csrf::is_foreign(request.headers(), http) {
        return Err(Box::new(refuse(post, &request, foreign())));
    }
    // Without a session (the login) the handler checks its own token.
    let Some(who) = who else { return Ok(request) };
    csrf::check(request, who.csrf()).await.map_err(|csrf::BadToken| {
        let text = say("This page was too old: go back, reload it and try again.");
        let error = ApiError { code: "bad_csrf_token", ..ApiError::forbidden(text) };
        Box::new((post.refusal)(post.kind, None, error))
    })
}

fn refuse(post: &RouteContext, request: &Request, error: ApiError) -> Response {
    let next =
        (request.method() == axum::http::Method::GET).then(|| request.uri().path_and_query()).flatten();
    (post.refusal)(post.kind, next.map(axum::http::uri::PathAndQuery::as_str), error)
}

/// The secret in a cookie.
pub(crate) fn cookie(headers: &HeaderMap, name: &str) -> Option<Secret> {
    Secret::parse(plain_cookie(headers, name)?)
}

/// The text in a cookie.
pub(crate) fn plain_cookie<'a>(headers: &'a HeaderMap, name: &str) -> Option<&'a str> {
    let all = headers.get_all(header::COOKIE).iter().filter_map(|value| value.to_str().ok());
    let mut pairs = all.flat_map(|value| value.split(';')).filter_map(|pair| pair.trim().split_once('='));
    pairs.find(|(found, _)| *found == name).map(|(_, value)| value)
}

/// Encrypted connections use a name prefix that browsers accept from this host only.
pub(crate) fn cookie_name(name: &str, remote: Remote) -> String {
    if remote.encrypted { format!("__Host-{name}") } else { name.to_owned() }
}
