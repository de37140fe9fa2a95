//! CSRF protection: changes are accepted only from our own pages.
//!
//! Every browser states the origin of a request (`Sec-Fetch-Site`, `Origin`); requests of other sites are refused. In
//! addition, every change repeats a token that only our pages have: in the header `X-CSRF-Token` or in the form's field
//! `csrf`.

use crate::config::Http;
use axum::body::{Body, to_bytes};
use axum::extract::Request;
use axum::http::{HeaderMap, header};
use shore::identity::same;

/// The header that scripts of our pages send.
pub(crate) const HEADER: &str = "x-csrf-token";
/// Bytes of a form that are read to find its token.
const FORM_BYTES: usize = 64 * 1024;

/// The change does not come from one of our pages.
#[derive(Debug)]
pub(crate) struct BadToken;

/// Whether the browser says that the request comes from one of our own pages. `false` if it does not say.
pub(crate) fn same_origin(headers: &HeaderMap, http: &Http) -> bool {
    let text = |name: &str| headers.get(name).and_then(|value| value.to_str().ok());
    match text("sec-fetch-site") {
        Some("same-origin") => return true,
        // A page of another service on our host or domain is not ours either. Typed addresses make no changes.
        Some(_) => return is_listed(text("origin"), http),
        None => {}
    }
    let Some(origin) = text("origin") else { return false };
    let host = text(header::HOST.as_str()).unwrap_or_default();
    let authority = origin.split_once("://").map_or("", |(_, authority)| authority);
    (!host.is_empty() && authority.eq_ignore_ascii_case(host)) || is_listed(Some(origin), http)
}

/// Whether the browser says that the request comes from another site. `false` if it does not say.
pub(crate) fn is_foreign(headers: &HeaderMap, http: &Http) -> bool {
    let spoke = headers.contains_key("sec-fetch-site") || headers.contains_key(header::ORIGIN);
    spoke && !same_origin(headers, http)
}

fn is_listed(origin: Option<&str>, http: &Http) -> bool {
    origin.is_some_and(|origin| http.origins.iter().any(|listed| listed.eq_ignore_ascii_case(origin)))
}

/// Looks for `token` in header or form and returns the request unchanged.
///
/// # Errors
/// It is missing or wrong.
pub(crate) async fn check(request: Request, token: &str) -> Result<Request, BadToken> {
    if let Some(sent) = request.headers().get(HEADER) {
        let right = sent.to_str().is_ok_and(|sent| same(sent, token));
        return if right { Ok(request) } else { Err(BadToken) };
    }
    let kind = request.headers().get(header::CONTENT_TYPE).and_then(|kind| kind.to_str().ok());
    if !kind.is_some_and(|kind| kind.starts_with("application/x-www-form-urlencoded")) {
        return Err(BadToken);
    }
    let (parts, body) = request.into_parts();
    let bytes = to_bytes(body, FORM_BYTES).await.map_err(|_| BadToken)?;
    let sent =
        form_urlencoded::parse(&bytes).find(|(name, _)| name == "csrf").map(|(_, sent)| sent.into_owned());
    if !sent.is_some_and(|sent| same(&sent, token)) {
        return Err(BadToken);
    }
    Ok(Request::from_parts(parts, Body::from(bytes)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(pairs: &[(&'static str, &str)]) -> HeaderMap {
        pairs
            .iter()
            .map(|(name, value)| (name.parse().unwrap(), value.parse().unwrap()))
            .collect::<HeaderMap>()
    }

    #[test]
    fn only_our_own_pages_are_ours() {
        let http = Http { origins: vec!["https://lutra.example.org".to_owned()], ..Http::default() };
        let cases: [(&[(&'static str, &str)], bool); 8] = [
            (&[("sec-fetch-site", "same-origin")], true),
            (&[("sec-fetch-site", "same-site")], false),
            (&[("sec-fetch-site", "none")], false),
            (&[("origin", "http://boat:8080"), ("host", "boat:8080")], true),
            (&[("origin", "http://boat:9090"), ("host", "boat:8080")], false),
            (&[("origin", "null"), ("host", "boat:8080")], false),
            (&[("origin", "https://lutra.example.org"), ("host", "127.0.0.1:8080")], true),
            (&[("host", "boat:8080")], false),
        ];
        for (pairs, ours) in cases {
            assert_eq!(same_origin(&headers(pairs), &http), ours, "{pairs:?}");
        }
        assert!(!is_foreign(&headers(&[("host", "boat:8080")]), &http));
        assert!(is_foreign(&headers(&[("sec-fetch-site", "cross-site")]), &http));
    }

    #[tokio::test]
    async fn the_token_is_found_in_header_and_form() {
        let form = |body: &str| {
            let request = Request::builder().header("content-type", "application/x-www-form-urlencoded");
            request.body(Body::from(body.to_owned())).unwrap()
        };
        let kept = check(form("a=1&csrf=right"), "right").await.unwrap();
        assert_eq!(to_bytes(kept.into_body(), 100).await.unwrap(), "a=1&csrf=right");
        for wrong in ["a=1", "csrf=wrong", "csrf=", "csrf=wrong&csrf=right"] {
            assert!(check(form(wrong), "right").await.is_err(), "{wrong}");
        }
        let header = |value: &str| Request::builder().header(HEADER, value).body(Body::empty()).unwrap();
        assert!(check(header("right"), "right").await.is_ok());
        assert!(check(header("wrong"), "right").await.is_err());
        let json = Request::builder().header("content-type", "application/json").body(Body::empty()).unwrap();
        assert!(check(json, "right").await.is_err());
    }
}
