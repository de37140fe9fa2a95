//! Scripts of other web pages: what they may read with a token, and that a session opens nothing to them.

use super::tests::{Answer, Shore, bearer};
use api::Role;
use axum::body::Body;
use axum::http::request::Builder;
use axum::http::{Method, Request, StatusCode, header};

const NOTEBOOK: &str = "http://localhost:8888";
const ME: &str = "/api/v1/me";

async fn shore(origins: &[&str]) -> Shore {
    let origins = origins.iter().map(|origin| (*origin).to_owned()).collect();
    Shore::changed(|config| config.http.cors_origins = origins).await
}

async fn send(shore: &Shore, request: Builder) -> Answer {
    shore.send(request, Body::empty()).await
}

fn get(path: &str, origin: &str) -> Builder {
    Request::get(path).header(header::ORIGIN, origin)
}

/// A browser's question before a request.
fn preflight(origin: &str, method: &str, headers: &str) -> Builder {
    Request::builder()
        .method(Method::OPTIONS)
        .uri(ME)
        .header(header::ORIGIN, origin)
        .header(header::ACCESS_CONTROL_REQUEST_METHOD, method)
        .header(header::ACCESS_CONTROL_REQUEST_HEADERS, headers)
}

/// The page that may read an answer.
fn reader(answer: &Answer) -> Option<&str> {
    assert!(!answer.headers.contains_key(header::ACCESS_CONTROL_ALLOW_CREDENTIALS));
    answer.headers.get(header::ACCESS_CONTROL_ALLOW_ORIGIN).map(|origin| origin.to_str().unwrap())
}

fn varies(answer: &Answer) -> bool {
    answer.headers.get_all(header::VARY).iter().any(|name| name == "origin")
}

#[tokio::test]
async fn a_listed_page_reads_with_a_token_and_other_pages_do_not() {
    let shore = shore(&[NOTEBOOK]).await;
    let token = shore.token(None, Role::Viewer).await;
    let answer = send(&shore, bearer(get(ME, NOTEBOOK), &token)).await;
    assert_eq!((answer.status, reader(&answer)), (StatusCode::OK, Some(NOTEBOOK)), "{}", answer.body);
    assert!(varies(&answer));
    let read = answer.headers[header::ACCESS_CONTROL_EXPOSE_HEADERS].to_str().unwrap();
    assert!(read.contains("link") && read.contains("retry-after"), "{read}");
    for origin in ["http://localhost:8889", "https://localhost:8888", "null", "http://localhost"] {
        let answer = send(&shore, bearer(get(ME, origin), &token)).await;
        assert_eq!((answer.status, reader(&answer)), (StatusCode::OK, None), "{origin}");
        assert!(varies(&answer), "a cache would give it to the listed page");
    }
    let refused = send(&shore, bearer(get(ME, NOTEBOOK), &format!("lutra_api_{}", "0".repeat(64)))).await;
    assert_eq!(
        (refused.status, reader(&refused)),
        (StatusCode::UNAUTHORIZED, Some(NOTEBOOK)),
        "the reason is read"
    );
    let page = send(&shore, bearer(get("/", NOTEBOOK), &token)).await;
    assert_eq!(reader(&page), None, "pages are no part of it");
}

#[tokio::test]
async fn no_session_is_opened_to_a_listed_page() {
    for origins in [&[NOTEBOOK][..], &["*"]] {
        let shore = shore(origins).await;
        let token = shore.token(None, Role::Viewer).await;
        let cookies = shore.admin().await;
        let answer = send(&shore, get(ME, NOTEBOOK).header(header::COOKIE, &cookies)).await;
        assert_eq!((answer.status, reader(&answer)), (StatusCode::OK, None), "{origins:?}");
        let both = bearer(get(ME, NOTEBOOK), &token).header(header::COOKIE, &cookies);
        assert_eq!(reader(&send(&shore, both).await), None, "{origins:?}");
        let nothing = send(&shore, get(ME, NOTEBOOK)).await;
        assert_eq!((nothing.status, reader(&nothing)), (StatusCode::UNAUTHORIZED, None), "{origins:?}");
    }
}

#[tokio::test]
async fn a_browser_is_told_beforehand_that_a_page_may_only_read() {
    let shore = shore(&[NOTEBOOK]).await;
    let answer = send(&shore, preflight(NOTEBOOK, "GET", "authorization, range")).await;
    assert_eq!((answer.status, reader(&answer)), (StatusCode::NO_CONTENT, Some(NOTEBOOK)));
    assert_eq!(answer.headers[header::ACCESS_CONTROL_ALLOW_METHODS], "GET, HEAD");
    assert_eq!(answer.headers[header::ACCESS_CONTROL_MAX_AGE], "600");
    let names = answer.headers[header::ACCESS_CONTROL_ALLOW_HEADERS].to_str().unwrap();
    assert!(names.contains("authorization") && varies(&answer), "{names}");
    for (origin, method, headers) in [
        (NOTEBOOK, "POST", "authorization"),
        (NOTEBOOK, "DELETE", ""),
        (NOTEBOOK, "GET", "authorization, x-csrf-token"),
        ("https://evil.example.org", "GET", "authorization"),
    ] {
        let answer = send(&shore, preflight(origin, method, headers)).await;
        assert_eq!(
            (answer.status, reader(&answer)),
            (StatusCode::METHOD_NOT_ALLOWED, None),
            "{origin} {method} {headers}"
        );
        assert!(!answer.headers.contains_key(header::ACCESS_CONTROL_ALLOW_METHODS));
    }
}

#[tokio::test]
async fn all_pages_may_be_listed_and_none_is_by_default() {
    let all = shore(&["*"]).await;
    let token = all.token(None, Role::Viewer).await;
    for origin in [NOTEBOOK, "https://observable.example.org"] {
        assert_eq!(reader(&send(&all, bearer(get(ME, origin), &token)).await), Some("*"));
    }
    let usual = Shore::changed(|_| ()).await;
    let token = usual.token(None, Role::Viewer).await;
    let answer = send(&usual, bearer(get(ME, NOTEBOOK), &token)).await;
    assert_eq!((answer.status, reader(&answer)), (StatusCode::OK, None));
    let answer = send(&usual, preflight(NOTEBOOK, "GET", "authorization")).await;
    assert_eq!((answer.status, reader(&answer)), (StatusCode::METHOD_NOT_ALLOWED, None));
}
