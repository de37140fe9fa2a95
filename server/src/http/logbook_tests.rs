//! The log book: permissions to read, write, correct and withdraw, and refusals with their texts.

use super::tests::{Answer, Shore, bearer};
use api::{LogNote, LogNoteRevision, LogNotes, Role};
use axum::body::Body;
use axum::http::{Request, StatusCode, header};
use serde_json::{Value, json};

const OWN: u16 = 7;
const PNG: &[u8] = b"\x89PNG\r\n\x1A\nand so on";

async fn say(shore: &Shore, method: &str, path: &str, token: &str, body: Value) -> Answer {
    let request = bearer(Request::builder().method(method).uri(format!("/api/v1/logbook{path}")), token);
    shore.send(request.header("content-type", "application/json"), Body::from(body.to_string())).await
}

async fn write(shore: &Shore, token: &str, body: Value) -> LogNote {
    let answer = say(shore, "POST", "", token, body).await;
    assert_eq!(answer.status, StatusCode::OK, "{}", answer.body);
    serde_json::from_str(&answer.body).unwrap()
}

async fn read(shore: &Shore, query: &str, token: &str) -> Vec<LogNote> {
    let answer = shore.get(&format!("/api/v1/logbook{query}"), token).await;
    assert_eq!(answer.status, StatusCode::OK, "{}", answer.body);
    serde_json::from_str::<LogNotes>(&answer.body).unwrap().notes
}

async fn texts(shore: &Shore, query: &str, token: &str) -> Vec<String> {
    read(shore, query, token).await.into_iter().map(|note| note.text).collect()
}

#[tokio::test]
async fn a_note_that_is_sent_again_by_its_key_is_one_note_and_has_the_first_answer() {
    let shore = Shore::with(|_| ()).await;
    let token = shore.token(Some(OWN), Role::Operator).await;
    let again = async |token: &str, key: &str, text: &str| -> LogNote {
        let answer =
            say(&shore, "POST", &format!("?key={key}"), token, json!({"text": text, "vessel": OWN})).await;
        assert_eq!(answer.status, StatusCode::OK, "{}", answer.body);
        serde_json::from_str(&answer.body).unwrap()
    };
    let first = again(&token, "k1", "swell").await;
    assert_eq!(again(&token, "k1", "swell").await, first);
    assert_eq!(again(&token, "k1", "other words").await, first, "the first note is the answer");
    assert_ne!(again(&token, "k2", "swell").await.id, first.id);
    let other = shore.token(Some(OWN), Role::Operator).await;
    assert_ne!(again(&other, "k1", "theirs").await.id, first.id, "a key is its person's");
    assert_eq!(texts(&shore, "", &token).await, ["theirs", "swell", "swell"]);
    // The audit log has each note once.
    let written = shore.audit().await.into_iter().filter(|entry| entry.action == "logbook.write");
    assert_eq!(written.count(), 3);
    let long = "k".repeat(65);
    for key in ["", &long] {
        let answer = say(&shore, "POST", &format!("?key={key}"), &token, json!({"text": "x"})).await;
        assert_eq!(answer.status, StatusCode::BAD_REQUEST, "{}", answer.body);
    }
}

#[tokio::test]
async fn operators_write_about_their_vessels_and_viewers_read() {
    let shore = Shore::with(|_| ()).await;
    let operator = shore.token(Some(OWN), Role::Operator).await;
    let other = shore.token(Some(OWN + 1), Role::Operator).await;
    let viewer = shore.token(Some(OWN), Role::Viewer).await;
    let note =
        write(&shore, &operator, json!({"text": " swell from west ", "vessel": OWN, "time_us": 5})).await;
    assert_eq!((&*note.text, note.time_us, note.may_change), ("swell from west", 5, true));
    write(&shore, &operator, json!({"text": "of no vessel"})).await;
    for (token, body) in [(&other, json!({"text": "x", "vessel": OWN})), (&viewer, json!({"text": "x"}))] {
        assert_eq!(say(&shore, "POST", "", token, body).await.status, StatusCode::FORBIDDEN);
    }
    assert_eq!(texts(&shore, "", &viewer).await, ["of no vessel", "swell from west"]);
    assert_eq!(texts(&shore, "?text=SWELL", &viewer).await, ["swell from west"]);
    assert_eq!(texts(&shore, "", &other).await, ["of no vessel"], "not theirs to see");
    assert!(read(&shore, "", &viewer).await.iter().all(|note| !note.may_change));
    let hidden = shore.get(&format!("/api/v1/logbook?vessel={OWN}"), &other).await;
    assert_eq!(hidden.status, StatusCode::FORBIDDEN);
    for path in ["photo", "earlier"] {
        let path = format!("/api/v1/logbook/{}/{path}", note.id);
        assert_eq!(shore.get(&path, &other).await.status, StatusCode::NOT_FOUND);
    }
    let first: LogNotes =
        serde_json::from_str(&shore.get("/api/v1/logbook?limit=1", &viewer).await.body).unwrap();
    let rest = format!("?limit=1&before={}", first.next.unwrap());
    assert_eq!(texts(&shore, &rest, &viewer).await, ["swell from west"]);
}

#[tokio::test]
async fn the_author_or_an_admin_corrects_and_withdraws_and_nothing_is_lost() {
    let shore = Shore::with(|_| ()).await;
    let author = shore.token(Some(OWN), Role::Operator).await;
    let colleague = shore.token(None, Role::Operator).await;
    let admin = shore.token(None, Role::Admin).await;
    let note = write(&shore, &author, json!({"text": "wind 3 m/s", "vessel": OWN})).await;
    let path = format!("/{}", note.id);
    let change =
        |revision: u32, text: &str| json!({"revision": revision, "note": {"text": text, "vessel": OWN}});
    let refused = say(&shore, "PATCH", &path, &colleague, change(1, "mine")).await;
    assert_eq!(refused.status, StatusCode::FORBIDDEN);
    assert!(refused.body.contains("its author"), "{}", refused.body);
    assert_eq!(say(&shore, "DELETE", &path, &colleague, json!({})).await.status, StatusCode::FORBIDDEN);
    let corrected = say(&shore, "PATCH", &path, &author, change(1, "wind 8 m/s")).await;
    let corrected: LogNote = serde_json::from_str(&corrected.body).unwrap();
    assert_eq!((corrected.revision, corrected.time_us), (2, note.time_us), "the time stays");
    assert_eq!(say(&shore, "PATCH", &path, &admin, change(1, "late")).await.status, StatusCode::CONFLICT);
    let earlier = shore.get(&format!("/api/v1/logbook{path}/earlier"), &author).await;
    let earlier: Vec<LogNoteRevision> = serde_json::from_str(&earlier.body).unwrap();
    assert_eq!((earlier.len(), &*earlier[0].text), (1, "wind 3 m/s"));
    // A user cannot move a note to a vessel on which they may not write.
    let away = json!({"revision": 2, "note": {"text": "x", "vessel": OWN + 1}});
    assert_eq!(say(&shore, "PATCH", &path, &author, away).await.status, StatusCode::FORBIDDEN);
    assert_eq!(say(&shore, "DELETE", &path, &admin, json!({})).await.status, StatusCode::OK);
    assert_eq!(
        say(&shore, "DELETE", &path, &admin, json!({})).await.status,
        StatusCode::UNPROCESSABLE_ENTITY
    );
    assert!(read(&shore, "", &author).await.is_empty());
    let kept = read(&shore, "?withdrawn=true", &author).await;
    assert!(kept[0].withdrawn.is_some() && !kept[0].may_change && kept[0].text == "wind 8 m/s");
    let acts: Vec<(String, String)> = shore
        .audit()
        .await
        .into_iter()
        .rev()
        .filter(|entry| entry.action.starts_with("logbook."))
        .map(|entry| (entry.action, entry.subject))
        .collect();
    let names: Vec<&str> = acts.iter().map(|(action, _)| &**action).collect();
    assert_eq!(names, ["logbook.write", "logbook.correct", "logbook.withdraw"]);
    assert!(acts[1].1.contains("wind 8 m/s") && acts[1].1.contains("before: wind 3 m/s"), "{}", acts[1].1);
}

#[tokio::test]
async fn what_cannot_be_is_refused_at_its_field() {
    let shore = Shore::with(|_| ()).await;
    let operator = shore.token(None, Role::Operator).await;
    for (body, told) in [
        (json!({"text": "  "}), "text: empty"),
        (json!({"text": "x".repeat(4_001)}), "text: has 4001 characters"),
        (json!({"text": "a\u{7}b"}), "text: has control characters"),
        (json!({"text": "x", "lat_deg": 91.0, "lon_deg": 0.0}), "lat_deg: this is not a place"),
        (json!({"text": "x", "lat_deg": 9.0}), "lon_deg: a place has a longitude"),
        (json!({"text": "x", "lon_deg": 9.0}), "lat_deg: a place has a latitude"),
        (json!({"text": "x", "time_us": -1}), "time_us: -1 is not a time"),
        (json!({"text": "x", "colour": 1}), "colour"),
        (json!([]), "text"),
    ] {
        let answer = say(&shore, "POST", "", &operator, body).await;
        assert!(answer.status.is_client_error() && answer.body.contains(told), "{told}: {}", answer.body);
    }
    write(&shore, &operator, json!({"text": "ø".repeat(4_000)})).await;
    for query in ["?limit=0", "?limit=501", "?before=x", "?vessel=otter!", "?from_us=9&to_us=1", "?what=1"] {
        let answer = shore.get(&format!("/api/v1/logbook{query}"), &operator).await;
        let unknown_vessel = query.contains("otter!");
        let expected = if unknown_vessel { StatusCode::NOT_FOUND } else { StatusCode::BAD_REQUEST };
        assert_eq!(answer.status, expected, "{query}: {}", answer.body);
    }
}

#[tokio::test]
async fn a_photo_is_kept_once_and_given_to_who_may_see_its_note() {
    let shore = Shore::with(|_| ()).await;
    let operator = shore.token(Some(OWN), Role::Operator).await;
    let viewer = shore.token(Some(OWN), Role::Viewer).await;
    let note = write(&shore, &operator, json!({"text": "a net", "vessel": OWN})).await;
    let path = format!("/api/v1/logbook/{}/photo", note.id);
    let put = async |token: &str, bytes: &[u8]| {
        shore.send(bearer(Request::put(&path), token), Body::from(bytes.to_vec())).await
    };
    assert_eq!(shore.get(&path, &viewer).await.status, StatusCode::NOT_FOUND);
    assert_eq!(put(&viewer, PNG).await.status, StatusCode::FORBIDDEN);
    let none = put(&operator, b"<svg onload=alert(1)>").await;
    assert!(none.status == StatusCode::BAD_REQUEST && none.body.contains("not a JPEG"), "{}", none.body);
    let large = put(&operator, &vec![0; (4 << 20) + 1]).await;
    assert!(large.status == StatusCode::PAYLOAD_TOO_LARGE && large.body.contains("4 MiB"), "{}", large.body);
    let kept = put(&operator, PNG).await;
    let kept: LogNote = serde_json::from_str(&kept.body).unwrap();
    assert_eq!(kept.photo.as_deref(), Some("image/png"));
    assert_eq!(put(&operator, PNG).await.status, StatusCode::UNPROCESSABLE_ENTITY, "one photo");
    let photo = shore.get(&path, &viewer).await;
    assert_eq!(
        (&photo.bytes[..], &photo.headers[header::CONTENT_TYPE]),
        (PNG, &"image/png".parse().unwrap())
    );
    assert_eq!(photo.headers[header::X_CONTENT_TYPE_OPTIONS], "nosniff");
    let again = bearer(Request::get(&path), &viewer).header("if-none-match", &photo.headers["etag"]);
    assert_eq!(shore.send(again, Body::empty()).await.status, StatusCode::NOT_MODIFIED);
    assert_eq!(std::fs::read(shore.data().join(format!("logbook/{}", note.id))).unwrap(), PNG);
    // A lost file is reported.
    std::fs::remove_file(shore.data().join(format!("logbook/{}", note.id))).unwrap();
    let lost = shore.get(&path, &viewer).await;
    assert!(lost.status == StatusCode::NOT_FOUND && lost.body.contains("backup"), "{}", lost.body);
}

#[tokio::test]
async fn the_file_has_all_notes_of_those_whose_data_one_may_take() {
    let shore = Shore::with(|_| ()).await;
    let operator = shore.token(None, Role::Operator).await;
    let researcher = shore.token(Some(OWN), Role::Researcher).await;
    let viewer = shore.token(None, Role::Viewer).await;
    for (text, vessel) in [("one", OWN), ("two, three", OWN), ("elsewhere", OWN + 1)] {
        write(&shore, &operator, json!({"text": text, "vessel": vessel, "time_us": 5})).await;
    }
    assert_eq!(shore.get("/api/v1/logbook.csv", &viewer).await.status, StatusCode::FORBIDDEN);
    let file = shore.get("/api/v1/logbook.csv", &researcher).await;
    assert!(file.headers[header::CONTENT_TYPE].to_str().unwrap().starts_with("text/csv"));
    let lines: Vec<&str> = file.body.lines().collect();
    assert_eq!(lines.len(), 3, "{}", file.body);
    assert!(lines[0].starts_with("time_utc,vessel,latitude [deg]"));
    assert!(
        lines[1].starts_with("1970-01-01T00:00:00.000005Z,0x0007,,,\"two, three\",person"),
        "{}",
        lines[1]
    );
    assert_eq!(shore.get("/api/v1/logbook.csv", &operator).await.body.lines().count(), 4);
}
