//! Refusals of malformed requests: in the API's own form and words, with the place and what to do.

use super::tests::{Answer, Shore, bearer};
use api::{Refusal, Role};
use axum::body::Body;
use axum::http::{Method, Request, StatusCode, header};

/// Words of the libraries that read requests, which mean nothing to a reader.
const OF_LIBRARIES: [&str; 7] =
    ["deserialize", "Failed to", "expected", "invalid type", "struct", "u16", "length limit"];

async fn ask(
    shore: &Shore,
    token: &str,
    (method, path): (Method, &str),
    media: &str,
    body: Vec<u8>,
) -> Answer {
    let request = Request::builder().method(method).uri(format!("/api/{path}"));
    let request = bearer(request, token).header(header::CONTENT_TYPE, media);
    shore.send(request, Body::from(body)).await
}

#[tokio::test]
async fn what_cannot_be_read_is_refused_in_plain_words_with_its_place() {
    let shore = Shore::with(|_| ()).await;
    let token = shore.token(None, Role::Admin).await;
    let json = "application/json";
    let listed = "; /api/v1/openapi.json lists all parameters";
    let draft = |body: &str| ((Method::POST, "v1/datasets"), json, body.as_bytes().to_vec(), 400);
    for ((route, media, body, status), said) in [
        (draft("[]"), format!("give a JSON object, not a JSON list{listed}")),
        (draft(""), format!("The body is empty; send a JSON object{listed}")),
        (draft("{\"title\": }"), format!("The body is not JSON; look at line 1, column 11{listed}")),
        (draft("{\"title\": 7}"), format!("title: give a text, not 7{listed}")),
        (
            ((Method::POST, "v1/datasets"), "text/plain", b"{}".to_vec(), 415),
            "The body must be JSON; send the header Content-Type: application/json".to_owned(),
        ),
        (
            ((Method::POST, "v1/datasets"), json, vec![b' '; 70_000], 413),
            "The body has more than 65536 bytes, which is the most that is taken here; send less at a time"
                .to_owned(),
        ),
        (
            ((Method::GET, "v1/plans/abc"), json, Vec::new(), 400),
            "in the address: give a whole number, not `abc`".to_owned(),
        ),
        (
            ((Method::GET, "v1/alarms/history?limit=x"), json, Vec::new(), 400),
            format!("limit: give a whole number, 0 to 4294967295, not `x`{listed}"),
        ),
        (
            ((Method::DELETE, "v1/me"), json, Vec::new(), 405),
            "DELETE is not possible at this address; the header Allow says what is".to_owned(),
        ),
        (
            ((Method::GET, "live"), json, Vec::new(), 400),
            "This address is a WebSocket: connect to it by ws:// or wss://".to_owned(),
        ),
    ] {
        let what = format!("{route:?}");
        let answer = ask(&shore, &token, route, media, body).await;
        let refusal: Refusal =
            serde_json::from_str(&answer.body).unwrap_or_else(|_| panic!("{what}: {answer:?}"));
        assert_eq!((answer.status.as_u16(), refusal.error.text), (status, said), "{what}");
        assert!(refusal.error.says.is_some(), "{what} has words in other languages");
        let of_libraries = OF_LIBRARIES.iter().find(|words| answer.body.contains(**words));
        assert_eq!(of_libraries, None, "{what}: {}", answer.body);
    }
}

#[tokio::test]
async fn a_page_says_which_method_it_has_too() {
    let shore = Shore::with(|_| ()).await;
    let answer = shore.send(Request::delete("/login"), Body::empty()).await;
    assert_eq!(answer.status, StatusCode::METHOD_NOT_ALLOWED);
    assert!(answer.body.contains("DELETE is not possible at this address"), "{}", answer.body);
    assert!(answer.headers[header::ALLOW].to_str().unwrap().contains("GET"), "{:?}", answer.headers);
}
