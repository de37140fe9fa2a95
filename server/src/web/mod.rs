//! Middleware around every answer: authentication and permissions, parsing of requests, refusals and headers, limits of
//! connections.
//!
//! Handlers are in [`crate::http`] (for programs) and [`crate::pages`] (for people); this module does not use them.

pub(crate) mod assets;
pub(crate) mod connections;
pub(crate) mod cors;
pub(crate) mod csrf;
pub(crate) mod error;
pub(crate) mod extract;
pub(crate) mod guard;
pub(crate) mod headers;
mod json;
pub(crate) mod language;
pub(crate) mod listen;
pub(crate) mod measure;
pub(crate) mod outgoing;
pub(crate) mod peer;
pub(crate) mod query;
pub(crate) mod remote;
pub(crate) mod route;
pub(crate) mod slow_bodies;
mod wrong;

pub(crate) use assets::path as asset_path;
pub(crate) use error::ApiError;
pub(crate) use extract::{BodyLimit, InBody, InPath, QueryParams, WholeBody};
pub(crate) use guard::{
    LinkOf, MaybeWho, NO_ROLE, OfVessel, SESSION_COOKIE, Who, cookie, cookie_name, identify, plain_cookie,
};
pub(crate) use remote::Remote;
pub(crate) use route::{Kind, Need, Route};
