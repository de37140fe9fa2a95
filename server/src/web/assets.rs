//! Scripts, styles and pictures that `make web` bundles into `web/dist`, within the program itself.
//!
//! Their names contain a hash of their content, so browsers cache them for ever. A debug build reads the folder, so that a
//! change is visible without compiling.

use super::error::ApiError;
use api::say;
use axum::extract::Path;
use axum::http::{HeaderMap, header};
use axum::response::{IntoResponse, Response};
use rust_embed::RustEmbed;
use serde_json::json;
use std::borrow::Cow;
use std::collections::BTreeMap;

#[derive(RustEmbed)]
#[folder = "../web/dist"]
#[allow_missing = true]
struct Dist;

/// Path of the bundle with this plain name (`main.js`); empty if there is none.
pub(crate) fn path(name: &str) -> String {
    let manifest: Option<BTreeMap<String, String>> =
        Dist::get("manifest.json").and_then(|file| serde_json::from_slice(&file.data).ok());
    let hashed = manifest.and_then(|mut manifest| manifest.remove(name));
    hashed.map(|hashed| format!("/static/{hashed}")).unwrap_or_default()
}

/// `GET /static/{name}`.
pub(crate) async fn serve(Path(name): Path<String>, headers: HeaderMap) -> Result<Response, ApiError> {
    let kind = match name.rsplit('.').next() {
        Some("js") => "text/javascript; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("svg") => "image/svg+xml",
        Some("png") => "image/png",
        Some("woff2") => "font/woff2",
        Some("json") => "application/json",
        Some("txt") => "text/plain; charset=utf-8",
        _ => return Err(ApiError::not_found(say("There is no such file."))),
    };
    let accepted = headers.get(header::ACCEPT_ENCODING).and_then(|value| value.to_str().ok()).unwrap_or("");
    // The smaller one first; browsers accept Brotli only over TLS and from localhost.
    let packed = [("br", "br"), ("gzip", "gz")]
        .into_iter()
        .filter(|(coding, _)| {
            accepted.split(',').any(|one| one.split(';').next().map(str::trim) == Some(coding))
        })
        .find_map(|(coding, suffix)| Some((Dist::get(&format!("{name}.{suffix}"))?, Some(coding))));
    let whole = || Dist::get(&name).map(|file| (file, None));
    let (file, coding) =
        packed.or_else(whole).ok_or_else(|| ApiError::not_found(say("There is no such file.")))?;
    let body = match file.data {
        Cow::Borrowed(bytes) => axum::body::Body::from(bytes),
        Cow::Owned(bytes) => axum::body::Body::from(bytes),
    };
    let mut response = (
        [
            (header::CONTENT_TYPE, kind),
            (header::CACHE_CONTROL, "public, max-age=31536000, immutable"),
            (header::VARY, "accept-encoding"),
        ],
        body,
    )
        .into_response();
    if let Some(coding) = coding {
        response.headers_mut().insert(header::CONTENT_ENCODING, header::HeaderValue::from_static(coding));
    }
    Ok(response)
}

/// `GET /worker.js`: its name is fixed, so that browsers check for a new version.
pub(crate) async fn worker() -> Result<Response, ApiError> {
    let file = Dist::get("worker.js").ok_or_else(|| ApiError::not_found(say("There is no such file.")))?;
    let kind =
        [(header::CONTENT_TYPE, "text/javascript; charset=utf-8"), (header::CACHE_CONTROL, "no-cache")];
    Ok((kind, file.data.into_owned()).into_response())
}

/// `GET /manifest.webmanifest`, by which the pages can be put on a home screen.
pub(crate) async fn web_manifest() -> Response {
    let icon = |size: u32| {
        let size = size.to_string();
        json!({
            "src": format!("/static/icon-{size}.png"), "sizes": format!("{size}x{size}"),
            "type": "image/png", "purpose": "any maskable",
        })
    };
    let manifest = json!({
        "name": "Lutra", "short_name": "Lutra", "id": "/", "start_url": "/", "display": "standalone",
        "background_color": "#0b3c5d", "theme_color": "#0b3c5d", "icons": [icon(192), icon(512)],
    });
    ([(header::CONTENT_TYPE, "application/manifest+json")], manifest.to_string()).into_response()
}

/// `GET /favicon.ico`, the otter's head.
pub(crate) async fn favicon() -> Response {
    let kind = [(header::CONTENT_TYPE, "image/svg+xml"), (header::CACHE_CONTROL, "public, max-age=86400")];
    (kind, include_str!("../../../web/favicon.svg")).into_response()
}
