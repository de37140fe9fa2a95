//! One row of the table of routes: the source of the router, the OpenAPI document and the test of permissions.

use super::extract::BodyLimit;
use crate::AppState;
use api::Role;
use axum::Extension;
use axum::extract::DefaultBodyLimit;
use axum::handler::Handler;
use axum::http::Method;
use axum::routing::{MethodFilter, MethodRouter, on};
use std::convert::Infallible;
use utoipa::openapi::path::Parameter;
use utoipa::openapi::{RefOr, Schema};
use utoipa::{IntoParams, PartialSchema, ToSchema};

/// The permission that a route needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Need {
    /// Nothing.
    Anyone,
    /// Logged in with a browser, even while a one-time password must be changed.
    Session,
    /// Logged in, whatever their roles, also with none; the handler shows what is the person's own.
    Account,
    /// This role on some vessel; the handler shows no more than what the person may see.
    Somewhere(Role),
    /// This role on the vessel in the path, `{vessel}`.
    OnVessel(Role),
    /// This role on all vessels.
    Everywhere(Role),
    /// On this machine, or admin.
    Figures,
    /// A vessel with the token of its link.
    Link,
}

/// The kind of client of a route, which determines the form of a refusal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// People: a refusal is a page, or leads to the login.
    Page,
    /// Programs: a refusal is JSON.
    Api,
    /// A WebSocket, which browsers open for any page that asks: its origin is checked too.
    Socket,
}

/// Schema of a body in the OpenAPI document.
pub(crate) type Shape = (String, RefOr<Schema>, Vec<(String, RefOr<Schema>)>);

/// One row.
#[expect(clippy::struct_excessive_bools, reason = "each is a property of its own")]
pub(crate) struct Route {
    pub(crate) method: Method,
    pub(crate) path: &'static str,
    pub(crate) need: Need,
    pub(crate) kind: Kind,
    /// What it does, for the OpenAPI document.
    pub(crate) about: &'static str,
    pub(crate) handler: MethodRouter<AppState>,
    pub(crate) takes: Option<Shape>,
    /// Whether it takes a file as its body.
    pub(crate) takes_file: bool,
    pub(crate) gives: Option<Shape>,
    /// Media type of the answer where it is not JSON.
    pub(crate) media: Option<&'static str>,
    pub(crate) query: Vec<Parameter>,
    /// Whether the answer is compressed for clients that accept it. Never if an answer contains both a secret and text that
    /// a client sent: its length would reveal the secret.
    pub(crate) packed: bool,
    /// Whether it limits the pace of its body itself.
    pub(crate) paces: bool,
    /// Whether the vessel in its path may be one that is not known.
    pub(crate) to_unknown: bool,
}

impl Route {
    /// A page for people.
    pub(crate) fn page<H, T>(path: &'static str, need: Need, about: &'static str, handler: H) -> Self
    where
        H: Handler<T, AppState>,
        T: 'static,
    {
        Self::new(Method::GET, path, Kind::Page, need, about, on(MethodFilter::GET, handler))
    }

    /// A form that people send.
    pub(crate) fn form<H, T>(path: &'static str, need: Need, about: &'static str, handler: H) -> Self
    where
        H: Handler<T, AppState>,
        T: 'static,
    {
        Self::new(Method::POST, path, Kind::Page, need, about, on(MethodFilter::POST, handler))
    }

    /// A GET route of the API.
    pub(crate) fn get<H, T>(path: &'static str, need: Need, about: &'static str, handler: H) -> Self
    where
        H: Handler<T, AppState>,
        T: 'static,
    {
        Self::new(Method::GET, path, Kind::Api, need, about, on(MethodFilter::GET, handler))
    }

    /// A POST route of the API.
    pub(crate) fn post<H, T>(path: &'static str, need: Need, about: &'static str, handler: H) -> Self
    where
        H: Handler<T, AppState>,
        T: 'static,
    {
        Self::new(Method::POST, path, Kind::Api, need, about, on(MethodFilter::POST, handler))
    }

    /// A PUT route of the API.
    pub(crate) fn put<H, T>(path: &'static str, need: Need, about: &'static str, handler: H) -> Self
    where
        H: Handler<T, AppState>,
        T: 'static,
    {
        Self::new(Method::PUT, path, Kind::Api, need, about, on(MethodFilter::PUT, handler))
    }

    /// A PATCH route of the API.
    pub(crate) fn patch<H, T>(path: &'static str, need: Need, about: &'static str, handler: H) -> Self
    where
        H: Handler<T, AppState>,
        T: 'static,
    {
        Self::new(Method::PATCH, path, Kind::Api, need, about, on(MethodFilter::PATCH, handler))
    }

    /// A DELETE route of the API.
    pub(crate) fn delete<H, T>(path: &'static str, need: Need, about: &'static str, handler: H) -> Self
    where
        H: Handler<T, AppState>,
        T: 'static,
    {
        Self::new(Method::DELETE, path, Kind::Api, need, about, on(MethodFilter::DELETE, handler))
    }

    /// A WebSocket.
    pub(crate) fn socket<H, T>(path: &'static str, need: Need, about: &'static str, handler: H) -> Self
    where
        H: Handler<T, AppState>,
        T: 'static,
    {
        Self::new(Method::GET, path, Kind::Socket, need, about, on(MethodFilter::GET, handler))
    }

    fn new(
        method: Method,
        path: &'static str,
        kind: Kind,
        need: Need,
        about: &'static str,
        handler: MethodRouter<AppState>,
    ) -> Self {
        Self {
            method,
            path,
            need,
            kind,
            about,
            handler,
            takes: None,
            takes_file: false,
            gives: None,
            media: None,
            query: Vec::new(),
            packed: false,
            paces: false,
            to_unknown: kind == Kind::Page,
        }
    }

    /// It answers with JSON of this type.
    pub(crate) fn gives<T: ToSchema>(mut self) -> Self {
        self.gives = Some(shape::<T>());
        self
    }

    /// It takes JSON of this type.
    pub(crate) fn takes<T: ToSchema>(mut self) -> Self {
        self.takes = Some(shape::<T>());
        self
    }

    /// It takes a file.
    pub(crate) fn takes_file(mut self) -> Self {
        self.takes_file = true;
        self
    }

    /// It limits the pace of its body itself.
    pub(crate) fn paces(mut self) -> Self {
        self.paces = true;
        self
    }

    /// Its vessel may be one that is not known: STOP is sent in any case.
    pub(crate) fn reaches_unknown(mut self) -> Self {
        self.to_unknown = true;
        self
    }

    /// Its body may have so many bytes.
    pub(crate) fn body_bytes(mut self, most: usize) -> Self {
        let limited = self.handler.layer::<_, Infallible>(DefaultBodyLimit::max(most));
        self.handler = limited.layer(Extension(BodyLimit(most)));
        self
    }

    /// It takes these parameters in the query.
    pub(crate) fn query<T: IntoParams>(mut self) -> Self {
        self.query = T::into_params(|| Some(utoipa::openapi::path::ParameterIn::Query));
        self
    }

    /// Its answer is compressed; it holds data of vessels only.
    pub(crate) fn packed(mut self) -> Self {
        self.packed = true;
        self
    }

    /// It answers with another media type than JSON.
    pub(crate) fn media(mut self, media: &'static str) -> Self {
        self.media = Some(media);
        self
    }
}

fn shape<T: ToSchema>() -> Shape {
    let mut parts = Vec::new();
    T::schemas(&mut parts);
    (T::name().into_owned(), <T as PartialSchema>::schema(), parts)
}
