//! Datasets by the API: from a draft to a published version that never changes, its files, and permissions.

use super::history_tests::put;
use super::testing::FIRST;
use super::tests::{Answer, Shore, bearer};
use api::{Dataset, DatasetCheck, DatasetState, Role};
use axum::body::Body;
use axum::http::{Request, StatusCode};
use imc::messages::TBRFishTag;
use serde_json::{Value, json};
use sha2::{Digest as _, Sha256};
use std::path::Path;

/// 2024-11-21 08:00 UTC: in the past, as a dataset ends at the present.
pub(super) const START_US: i64 = 1_732_176_000_000_000;
const OTHER: u16 = FIRST + 1;

/// A detection of a tag at a place (deg).
pub(super) fn heard(id: u32, lat_deg: f64, lon_deg: f64) -> TBRFishTag {
    TBRFishTag {
        serial_no: 1_024,
        unix_timestamp: 1_732_176_000,
        millis: 7,
        trans_protocol: 6_u8.into(),
        trans_id: id,
        trans_data: 42,
        snr: 20,
        trans_freq: 69,
        lat: Some(lat_deg.to_radians()),
        lon: Some(lon_deg.to_radians()),
        ..TBRFishTag::default()
    }
}

/// Three detections of two tags.
pub(super) fn three(data: &Path) {
    let said = [(101, 63.432_123, 10.398_765), (102, 63.446_456, 10.412_345), (101, 63.452_789, 10.421_987)];
    let said = said
        .iter()
        .zip(1..)
        .map(|((id, lat, lon), at)| (2, START_US + at * 1_000_000, heard(*id, *lat, *lon).into()));
    put(data, &said.collect::<Vec<(u8, i64, imc::Message)>>());
}

pub(super) async fn say(shore: &Shore, method: &str, path: &str, token: &str, body: Value) -> Answer {
    let request = bearer(Request::builder().method(method).uri(format!("/api/v1{path}")), token);
    shore.send(request.header("content-type", "application/json"), Body::from(body.to_string())).await
}

pub(super) async fn done<T: serde::de::DeserializeOwned>(
    shore: &Shore,
    method: &str,
    path: &str,
    token: &str,
    body: Value,
) -> T {
    let answer = say(shore, method, path, token, body).await;
    assert_eq!(answer.status, StatusCode::OK, "{method} {path}: {}", answer.body);
    serde_json::from_str(&answer.body).unwrap()
}

/// A person of the register, who can be an author.
pub(super) async fn kari(shore: &Shore, token: &str) {
    let person = json!({"kind": "person", "name": "Nordmann, Kari", "orcid": "0000-0002-1825-0097", "affiliation": "NTNU"});
    let _: Value = done(shore, "POST", "/register", token, person).await;
}

/// A draft with everything that publication needs, and with the given changes.
pub(super) fn draft(change: &[(&str, Value)]) -> Value {
    let mut draft = json!({
        "title": "Salmon in the fjord", "description": "Heard by one boat.", "publisher": "NTNU",
        "authors": ["Nordmann, Kari"], "query": {"vessels": [FIRST]},
    });
    for (field, value) in change {
        draft[*field] = value.clone();
    }
    draft
}

/// A published dataset.
pub(super) async fn published(shore: &Shore, token: &str, change: &[(&str, Value)]) -> Dataset {
    let made: Dataset = done(shore, "POST", "/datasets", token, draft(change)).await;
    let path = format!("/datasets/{}/publish", made.id);
    done(shore, "POST", &path, token, json!({"revision": made.revision})).await
}

fn sha256(bytes: &[u8]) -> String {
    hex::encode(Sha256::digest(bytes))
}

#[tokio::test]
async fn a_published_version_never_changes_and_its_bytes_have_the_sha256_that_it_names() {
    let shore = Shore::with(three).await;
    let token = shore.token(None, Role::Researcher).await;
    kari(&shore, &token).await;
    let made: Dataset = done(&shore, "POST", "/datasets", &token, json!({"title": " Salmon "})).await;
    assert_eq!((made.state, made.revision, made.versions.len()), (DatasetState::Draft, 1, 0));
    let at = format!("/datasets/{}", made.id);
    let lacking = say(&shore, "POST", &format!("{at}/publish"), &token, json!({"revision": 1})).await;
    assert_eq!(lacking.status, StatusCode::BAD_REQUEST);
    assert!(lacking.body.contains("publisher: ") && lacking.body.contains("authors: "), "{}", lacking.body);
    let change = json!({"revision": 1, "draft": draft(&[("doi", json!("doi:10.5281/zenodo.1234"))])});
    let changed: Dataset = done(&shore, "PUT", &at, &token, change.clone()).await;
    assert_eq!(changed.draft.unwrap().doi, "10.5281/zenodo.1234");
    assert_eq!(say(&shore, "PUT", &at, &token, change).await.status, StatusCode::CONFLICT);

    let out: Dataset = done(&shore, "POST", &format!("{at}/publish"), &token, json!({"revision": 2})).await;
    let version = &out.versions[0];
    assert_eq!(
        (out.state, out.draft, version.number, version.content.rows),
        (DatasetState::Published, None, 1, 3)
    );
    assert_eq!(version.authors[0].orcid, "0000-0002-1825-0097");
    assert!(version.query.to_us.is_some_and(|to_us| to_us > START_US), "the open end is the publication");
    assert!(version.citation.starts_with("Nordmann, Kari (20"), "{}", version.citation);
    assert!(
        version.citation.ends_with(
            "): Salmon in the fjord. Version 1. NTNU. Dataset. https://doi.org/10.5281/zenodo.1234"
        )
    );
    let covered = version.content.covered;
    assert_eq!((covered.south_deg, covered.east_deg), (Some(63.432_123), Some(10.421_987)));
    let path = format!("/api/v1/datasets/{}/versions/1/detections.csv", made.id);
    let csv = shore.get(&path, &token).await;
    assert_eq!((csv.body.lines().count(), csv.bytes.len() as u64), (4, version.content.bytes));
    assert_eq!(sha256(&csv.bytes), version.content.sha256);
    let same = shore.get(&format!("/api/v1/detections.csv?vessel={FIRST}"), &token).await;
    assert_eq!(csv.body, same.body, "it is the canonical CSV");

    // A published version is not changed; a new one begins with the contents of the last.
    let late = say(&shore, "PUT", &at, &token, json!({"revision": out.revision, "draft": draft(&[])})).await;
    assert_eq!(late.status, StatusCode::UNPROCESSABLE_ENTITY);
    let next: Dataset =
        done(&shore, "POST", &format!("{at}/versions"), &token, json!({"revision": out.revision})).await;
    let begun = next.draft.clone().unwrap();
    assert_eq!((&*begun.title, &*begun.doi, begun.query), ("Salmon in the fjord", "", version.query.clone()));
    let one_tag = json!({"vessels": [FIRST], "tags": ["S256-102"]});
    let change = json!({"revision": next.revision, "draft": draft(&[("query", one_tag)])});
    let changed: Dataset = done(&shore, "PUT", &at, &token, change).await;
    let second: Dataset =
        done(&shore, "POST", &format!("{at}/publish"), &token, json!({"revision": changed.revision})).await;
    let numbers: Vec<(u32, u64)> =
        second.versions.iter().map(|version| (version.number, version.content.rows)).collect();
    assert_eq!(numbers, [(2, 1), (1, 3)]);
    assert_eq!(second.versions[1], *version, "the first one is as it was");
    assert_eq!(shore.get(&path, &token).await.bytes, csv.bytes);

    let audit = shore.audit().await;
    for action in ["dataset.create", "dataset.change", "dataset.publish", "dataset.version"] {
        assert!(audit.iter().any(|entry| entry.action == action), "{action}");
    }
}

#[tokio::test]
async fn a_version_is_told_for_registries_search_engines_and_notebooks_in_every_format() {
    let shore = Shore::with(three).await;
    let token = shore.token(None, Role::Researcher).await;
    kari(&shore, &token).await;
    let dataset = published(&shore, &token, &[]).await;
    let content = &dataset.versions[0].content;
    let base = format!("/api/v1/datasets/{}/versions/1", dataset.id);
    let told = async |file: &str| {
        let answer = shore.get(&format!("{base}/{file}"), &token).await;
        assert_eq!(answer.status, StatusCode::OK, "{file}: {}", answer.body);
        answer.body
    };
    let json = async |file: &str| serde_json::from_str::<Value>(&told(file).await).unwrap();
    assert_eq!(json("datacite.json").await["schemaVersion"], "http://datacite.org/schema/kernel-4");
    let package = json("datapackage.json").await;
    assert_eq!(package["resources"][0]["hash"], format!("sha256:{}", content.sha256));
    assert_eq!(package["query"]["vessels"], json!([FIRST]));
    assert_eq!(json("schema.jsonld").await["@type"], "Dataset");
    for file in ["notebook.py", "notebook.R"] {
        let lines = told(file).await;
        assert!(
            lines.contains(&content.sha256) && lines.contains(&format!("{base}/detections.csv")),
            "{lines}"
        );
    }
    for format in research::FORMATS {
        let answer = shore.get(&format!("{base}/detections.csv?format={}", format.name), &token).await;
        if format.is_of_detections() {
            assert_eq!(answer.status, StatusCode::OK, "{}: {}", format.name, answer.body);
            assert!(answer.body.starts_with(format.header));
        } else {
            assert_eq!(answer.status, StatusCode::BAD_REQUEST, "{}", format.name);
            assert!(answer.body.contains("of the whole register"), "{}", answer.body);
        }
    }
    let wrong = shore.get(&format!("{base}/detections.csv?tag=102"), &token).await;
    assert_eq!(wrong.status, StatusCode::BAD_REQUEST, "a version is asked for as a whole");
}

#[tokio::test]
async fn what_has_changed_since_is_told_plainly() {
    let (clock, hand) = shore::clock::Clock::with_hand();
    let moved = Shore::by(clock, three).await;
    let token = moved.token(None, Role::Researcher).await;
    kari(&moved, &token).await;
    let dataset = published(&moved, &token, &[]).await;
    let path = format!("/datasets/{}/versions/1/check", dataset.id);
    let check: DatasetCheck = done(&moved, "GET", &path, &token, json!({})).await;
    assert!(check.is_same, "{check:?}");
    let tag = json!({"kind": "tag", "protocol": "S256", "tag_id": 101});
    let _: Value = done(&moved, "POST", "/register", &token, tag).await;
    // The register now names a tag: other bytes in as many rows. An older check is no longer valid.
    let held: DatasetCheck = done(&moved, "GET", &path, &token, json!({})).await;
    assert_eq!(held, check, "within some minutes it is not computed again");
    hand.advance(std::time::Duration::from_mins(11));
    let changed: DatasetCheck = done(&moved, "GET", &path, &token, json!({})).await;
    assert!(!changed.is_same && changed.sha256_now != dataset.versions[0].content.sha256);
    assert_eq!(
        changed.text,
        "The archive or the register has changed since: 3 rows then and now, but other bytes."
    );
}

#[tokio::test]
async fn a_dataset_is_seen_and_changed_by_the_roles_on_its_vessels() {
    let shore = Shore::with(three).await;
    let all = shore.token(None, Role::Researcher).await;
    let own = shore.token(Some(FIRST), Role::Researcher).await;
    let other = shore.token(Some(OTHER), Role::Researcher).await;
    let viewer = shore.token(Some(FIRST), Role::Viewer).await;
    kari(&shore, &all).await;
    let whole = say(&shore, "POST", "/datasets", &own, draft(&[("query", json!({}))])).await;
    assert_eq!(whole.status, StatusCode::FORBIDDEN);
    assert!(whole.body.contains("name those of which you are researcher"), "{}", whole.body);
    assert_eq!(say(&shore, "POST", "/datasets", &other, draft(&[])).await.status, StatusCode::FORBIDDEN);
    let made: Dataset = done(&shore, "POST", "/datasets", &own, draft(&[])).await;
    let at = format!("/datasets/{}", made.id);
    for token in [&other, &viewer] {
        assert_eq!(say(&shore, "GET", &at, token, json!({})).await.status, StatusCode::NOT_FOUND, "a draft");
    }
    let out: Dataset = done(&shore, "POST", &format!("{at}/publish"), &own, json!({"revision": 1})).await;
    let seen: Dataset = done(&shore, "GET", &at, &viewer, json!({})).await;
    assert!(!seen.may_change && seen.versions.len() == 1);
    assert_eq!(say(&shore, "GET", &at, &other, json!({})).await.status, StatusCode::NOT_FOUND);
    let seen: Vec<Dataset> = done(&shore, "GET", "/datasets", &other, json!({})).await;
    assert_eq!(seen, []);
    let file = format!("{at}/versions/1/detections.csv");
    for (token, status) in
        [(&viewer, StatusCode::FORBIDDEN), (&other, StatusCode::NOT_FOUND), (&all, StatusCode::OK)]
    {
        assert_eq!(say(&shore, "GET", &file, token, json!({})).await.status, status);
    }
    // A draft must not include vessels on which its author has no role.
    let next: Dataset =
        done(&shore, "POST", &format!("{at}/versions"), &own, json!({"revision": out.revision})).await;
    let more =
        json!({"revision": next.revision, "draft": draft(&[("query", json!({"vessels": [FIRST, OTHER]}))])});
    assert_eq!(say(&shore, "PUT", &at, &own, more).await.status, StatusCode::FORBIDDEN);

    // Once withdrawn, it is listed with its reason, without data.
    let step = json!({"revision": next.revision, "reason": " "});
    let empty = say(&shore, "POST", &format!("{at}/withdraw"), &own, step).await;
    assert!(empty.status == StatusCode::BAD_REQUEST && empty.body.contains("reason: "), "{}", empty.body);
    let step = json!({"revision": next.revision, "reason": "A clock was wrong."});
    let gone: Dataset = done(&shore, "POST", &format!("{at}/withdraw"), &own, step).await;
    assert_eq!(
        (gone.state, &*gone.withdrawn.unwrap().reason),
        (DatasetState::Withdrawn, "A clock was wrong.")
    );
    for name in [
        "",
        "/check",
        "/detections.csv",
        "/datacite.json",
        "/datapackage.json",
        "/schema.jsonld",
        "/notebook.py",
        "/notebook.R",
    ] {
        let of = say(&shore, "GET", &format!("{at}/versions/1{name}"), &all, json!({})).await;
        assert_eq!(of.status, StatusCode::GONE, "{name}");
        for told in ["A clock was wrong.", "Salmon in the fjord", &*out.versions[0].citation] {
            assert!(of.body.contains(told), "{name}: {}", of.body);
        }
        assert!(!of.body.contains(&out.versions[0].content.sha256), "{name}");
    }
    let seen = say(&shore, "GET", &at, &viewer, json!({})).await;
    assert!(
        seen.body.contains("A clock was wrong.") && seen.body.contains(&out.versions[0].citation),
        "{}",
        seen.body
    );
    assert!(
        !seen.body.contains(&out.versions[0].content.sha256) && !seen.body.contains("63.43"),
        "{}",
        seen.body
    );
    let again = json!({"revision": gone.revision});
    assert_eq!(say(&shore, "POST", &format!("{at}/publish"), &own, again).await.status, StatusCode::GONE);
}

#[tokio::test]
async fn a_question_that_finds_nothing_or_names_nothing_known_is_refused_at_its_field() {
    let shore = Shore::with(three).await;
    let token = shore.token(None, Role::Researcher).await;
    kari(&shore, &token).await;
    for (query, named) in [
        (json!({"tags": ["fish"]}), "tags: `fish`"),
        (json!({"projects": ["Trout"]}), "projects: the register has no project `Trout`"),
        (json!({"area": "63,10;64,11;64,10;63,11"}), "area: the sides from corner 1"),
        (json!({"from_us": 9, "to_us": 9}), "to_us: "),
        (json!({"without": ["bad"]}), "without[0]: `bad` is not one of unconfirmed"),
    ] {
        let answer = say(&shore, "POST", "/datasets", &token, draft(&[("query", query.clone())])).await;
        assert!(answer.status.is_client_error() && answer.body.contains(named), "{query}: {}", answer.body);
    }
    let none = json!({"vessels": [FIRST], "tags": ["S256-999"]});
    let made: Dataset = done(&shore, "POST", "/datasets", &token, draft(&[("query", none)])).await;
    let path = format!("/datasets/{}/publish", made.id);
    let empty = say(&shore, "POST", &path, &token, json!({"revision": 1})).await;
    assert!(
        empty.status == StatusCode::UNPROCESSABLE_ENTITY && empty.body.contains("no detections"),
        "{}",
        empty.body
    );
    // Flags exclude detections that have them: here no receiver's clock was lost, and no ping interval is known.
    let clocks =
        published(&shore, &token, &[("query", json!({"without": ["clock_not_set", "unconfirmed"]}))]).await;
    assert_eq!(clocks.versions[0].content.rows, 3);
    let off = published(
        &shore,
        &token,
        &[("query", json!({"area": "63.43,10.3;63.44,10.3;63.44,10.5;63.43,10.5"}))],
    )
    .await;
    assert_eq!(off.versions[0].content.rows, 1);
}

/// Tag 101 after 1 and 3 s, and tag 102 after 2 s; with `later` both again a minute after that. Their clocks agree with the
/// vessel's.
fn two_tags(data: &Path, later: bool) {
    let tell = |(id, at_s): (u32, u32)| {
        let time = START_US + i64::from(at_s) * 1_000_000;
        let heard = TBRFishTag { unix_timestamp: 1_732_176_000 + at_s, ..heard(id, 63.432, 10.398) };
        (2, time, heard.into())
    };
    let mut said = vec![(101, 1), (102, 2), (101, 3)];
    said.extend(later.then_some([(101, 63), (102, 64)]).into_iter().flatten());
    put(data, &said.into_iter().map(tell).collect::<Vec<(u8, i64, imc::Message)>>());
}

#[tokio::test]
async fn what_is_heard_after_the_end_of_a_version_or_outside_a_link_changes_no_byte_of_it() {
    let mut files = Vec::new();
    for later in [false, true] {
        let shore = Shore::with(|data| two_tags(data, later)).await;
        let token = shore.token(None, Role::Researcher).await;
        kari(&shore, &token).await;
        for id in [101, 102] {
            let tag = json!({"kind": "tag", "protocol": "S256", "tag_id": id, "interval_min_s": 60, "interval_max_s": 60});
            let _: Value = done(&shore, "POST", "/register", &token, tag).await;
        }
        let end = json!(START_US + 10_000_000);
        let of = async |query: Value| published(&shore, &token, &[("query", query)]).await;
        let all = of(json!({"vessels": [FIRST], "to_us": end})).await;
        let sure = of(json!({"vessels": [FIRST], "to_us": end, "without": ["unconfirmed"]})).await;
        let open = of(json!({"vessels": [FIRST], "without": ["unconfirmed"]})).await;
        assert_eq!(all.versions[0].content.rows, 3);
        assert_eq!(sure.versions[0].content.rows, 2, "nothing of the version confirms tag 102");
        assert_eq!(open.versions[0].content.rows, if later { 5 } else { 2 });
        let asked = json!({"label": "Ola", "days": 30, "to_us": end});
        let shares = format!("/datasets/{}/shares", open.id);
        let link: api::DatasetShareMade = done(&shore, "POST", &shares, &token, asked).await;
        let csv = shore.get(&format!("{}/detections.csv", link.path), "").await;
        files.push([
            all.versions[0].content.sha256.clone(),
            sure.versions[0].content.sha256.clone(),
            sha256(&csv.bytes),
        ]);
    }
    assert_eq!(files[0], files[1]);
}
