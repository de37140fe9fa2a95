//! Links: what they give, when they give nothing, and that they open nothing else. Generated from the table of routes.

use super::datasets_tests::{START_US, done, draft, kari, published, say, three};
use super::testing::FIRST;
use super::tests::{Answer, Shore, request};
use crate::serve::router::table;
use crate::web::{Need, Route};
use api::{Dataset, DatasetShare, DatasetShareMade, Role, ShareVisit, ShareVisitKind};
use axum::body::Body;
use axum::http::{Method, Request, StatusCode, header};
use serde_json::{Value, json};
use sha2::{Digest as _, Sha256};
use shore::clock::{Clock, ClockHand};
use std::time::Duration;

const PASSWORD: &str = "nine grey otters";
/// Marks of the data: a tag, and digits of positions.
const MARKS: [&str; 4] = ["S256-101", "63.432", "10.398", "63.446"];

/// A shore with a published dataset, and its researcher.
pub(super) struct Scene {
    pub(super) shore: Shore,
    pub(super) token: String,
    pub(super) dataset: Dataset,
    hand: ClockHand,
}

impl Scene {
    pub(super) async fn of(change: &[(&str, Value)]) -> Self {
        let (clock, hand) = Clock::with_hand();
        let shore = Shore::by(clock, three).await;
        let token = shore.token(None, Role::Researcher).await;
        kari(&shore, &token).await;
        let dataset = published(&shore, &token, change).await;
        Self { shore, token, dataset, hand }
    }

    pub(super) fn shares(&self) -> String {
        format!("/datasets/{}/shares", self.dataset.id)
    }

    /// Makes a link, with further options.
    pub(super) async fn link(&self, more: Value) -> DatasetShareMade {
        let mut asked = json!({"label": "Ola", "days": 30});
        for (field, value) in more.as_object().unwrap() {
            asked[field] = value.clone();
        }
        done(&self.shore, "POST", &self.shares(), &self.token, asked).await
    }

    /// The answer to a client that has nothing but the path.
    pub(super) async fn stranger(&self, path: &str) -> Answer {
        self.shore.get(path, "").await
    }

    pub(super) async fn revoke(&self, share: &DatasetShare) {
        let path = format!("{}/{}", self.shares(), share.id);
        assert_eq!(say(&self.shore, "DELETE", &path, &self.token, json!({})).await.status, StatusCode::OK);
    }

    async fn visits(&self, share: &DatasetShare) -> Vec<ShareVisit> {
        let path = format!("{}/{}/visits", self.shares(), share.id);
        done(&self.shore, "GET", &path, &self.token, json!({})).await
    }

    /// The answer to the password form.
    async fn form(&self, path: &str, password: &str) -> Answer {
        let body = form_urlencoded::Serializer::new(String::new()).append_pair("password", password).finish();
        let request = Request::post(path)
            .header(header::CONTENT_TYPE, "application/x-www-form-urlencoded")
            .header(header::HOST, "boat:8080")
            .header(header::ORIGIN, "http://boat:8080");
        self.shore.send(request, Body::from(body)).await
    }
}

/// The paths that a link gives access to, from the table of routes; each format of a file separately.
pub(super) fn reached(path: &str) -> Vec<String> {
    let of_link = |route: &Route| route.path.starts_with("/s/") && route.method == Method::GET;
    let mut paths: Vec<String> = table()
        .iter()
        .filter(|route| of_link(route))
        .map(|route| route.path.replace("/s/{token}", path))
        .collect();
    assert_eq!(paths.len(), 5, "a route more of a link is looked at here too: {paths:?}");
    let formats =
        research::FORMATS.iter().map(|format| format!("{path}/detections.csv?format={}", format.name));
    paths.extend(formats);
    paths
}

/// Checks that the answer has nothing of the data.
pub(super) fn tells_nothing(answer: &Answer, path: &str, sha256: &str) {
    for mark in MARKS.into_iter().chain([sha256]) {
        assert!(!answer.body.contains(mark), "{path} tells {mark}: {}", answer.body);
    }
}

#[tokio::test]
async fn every_route_of_a_link_refuses_no_link_an_ended_one_a_revoked_one_and_a_wrong_password() {
    let scene = Scene::of(&[]).await;
    let sha256 = scene.dataset.versions[0].content.sha256.clone();
    let revoked = scene.link(json!({})).await;
    scene.revoke(&revoked.share).await;
    let locked = scene.link(json!({"password": PASSWORD, "days": 60})).await;
    let ended = scene.link(json!({"days": 1})).await;
    scene.hand.advance(Duration::from_hours(25));
    let unknown = format!("/s/{}", "0".repeat(64));
    for (link, status, said) in [
        (&*unknown, StatusCode::NOT_FOUND, "There is no link with this address."),
        ("/s/short", StatusCode::NOT_FOUND, "There is no link with this address."),
        (&*revoked.path, StatusCode::GONE, "revoked"),
        (&*ended.path, StatusCode::GONE, "ended"),
    ] {
        for path in reached(link) {
            let answer = scene.stranger(&path).await;
            assert_eq!(answer.status, status, "{path}: {}", answer.body);
            assert!(answer.body.contains(said), "{path}: {}", answer.body);
            assert!(!answer.body.contains("Salmon in the fjord"), "{path} names the dataset");
            tells_nothing(&answer, &path, &sha256);
        }
    }
    for path in reached(&locked.path) {
        let is_page = path == locked.path;
        let open = scene.stranger(&path).await;
        assert_eq!(open.status, if is_page { StatusCode::OK } else { StatusCode::FORBIDDEN }, "{path}");
        tells_nothing(&open, &path, &sha256);
        assert!(!open.body.contains("Salmon in the fjord"), "{path} names the dataset");
        // A cookie of another link, and a forged one, open nothing.
        for cookie in ["0.0", "99999999999999999.00", "x"] {
            let forged = Request::get(&path)
                .header(header::COOKIE, format!("lutra_link_{}={cookie}", locked.share.id));
            let forged = scene.shore.send(forged, Body::empty()).await;
            tells_nothing(&forged, &path, &sha256);
            assert_eq!(forged.status, open.status, "{path}");
        }
    }
    let file = format!("{}/detections.csv", locked.path);
    let wrong = Request::get(&file).header("lutra-link-password", "guess");
    let wrong = scene.shore.send(wrong, Body::empty()).await;
    assert!(wrong.status == StatusCode::FORBIDDEN && wrong.body.contains("wrong_password"), "{}", wrong.body);
    tells_nothing(&wrong, &file, &sha256);
}

#[tokio::test]
async fn the_links_of_a_withdrawn_dataset_end_with_the_reason() {
    let scene = Scene::of(&[]).await;
    let sha256 = scene.dataset.versions[0].content.sha256.clone();
    let link = scene.link(json!({})).await;
    let locked = scene.link(json!({"password": PASSWORD})).await;
    let step = json!({"revision": scene.dataset.revision, "reason": "A clock was wrong."});
    let path = format!("/datasets/{}/withdraw", scene.dataset.id);
    let _: Dataset = done(&scene.shore, "POST", &path, &scene.token, step).await;
    for path in reached(&link.path) {
        let answer = scene.stranger(&path).await;
        assert!(answer.status == StatusCode::GONE && answer.body.contains("A clock was wrong."), "{path}");
        tells_nothing(&answer, &path, &sha256);
    }
    for path in reached(&locked.path) {
        let answer = scene.stranger(&path).await;
        assert!(answer.status == StatusCode::GONE && !answer.body.contains("A clock was wrong."), "{path}");
        tells_nothing(&answer, &path, &sha256);
    }
}

#[tokio::test]
async fn under_embargo_no_route_of_a_link_gives_data() {
    let scene = Scene::of(&[("embargo_until", json!("2099-01-01"))]).await;
    let sha256 = scene.dataset.versions[0].content.sha256.clone();
    for more in [json!({}), json!({"precision_m": 1_000})] {
        let link = scene.link(more).await;
        for path in reached(&link.path) {
            let answer = scene.stranger(&path).await;
            tells_nothing(&answer, &path, &sha256);
            assert!(
                !answer.body.contains("Heard by one boat."),
                "{path} gives the description: {}",
                answer.body
            );
            assert!(answer.body.contains("2099-01-01"), "{path}: {}", answer.body);
            if path == link.path {
                assert!(answer.body.contains("Salmon in the fjord") && answer.body.contains("under embargo"));
                assert!(!answer.body.contains("ld+json") && answer.body.contains("noindex"));
            } else {
                assert_eq!(answer.status, StatusCode::FORBIDDEN, "{path}");
            }
        }
    }
    // A user with the role can download the data anyway.
    let own = format!("/api/v1/datasets/{}/versions/1/detections.csv", scene.dataset.id);
    assert_eq!(scene.shore.get(&own, &scene.token).await.status, StatusCode::OK);
}

#[tokio::test]
async fn an_embargo_that_is_over_gives_the_data() {
    let scene = Scene::of(&[("embargo_until", json!("2020-01-01"))]).await;
    let link = scene.link(json!({})).await;
    let page = scene.stranger(&link.path).await;
    assert!(page.body.contains(&scene.dataset.versions[0].content.sha256), "{}", page.body);
    assert!(page.body.contains("Heard by one boat."), "{}", page.body);
    assert!(
        !page.body.contains("ld+json"),
        "JSON-LD names what it describes to search engines: {}",
        page.body
    );
}

#[tokio::test]
async fn a_link_gives_its_bytes_and_tells_its_owner_of_each_use() {
    let scene = Scene::of(&[]).await;
    let version = &scene.dataset.versions[0];
    let link = scene.link(json!({})).await;
    assert_eq!(link.share.content, version.content, "the whole of it is the version itself");
    let page = scene.stranger(&link.path).await;
    assert_eq!(page.status, StatusCode::OK, "{}", page.body);
    assert!(!page.body.contains("ld+json") && page.body.contains("noindex"), "{}", page.body);
    let secret = link.path.trim_start_matches("/s/");
    assert!(page.body.contains("the archive gives exactly these bytes"), "{}", page.body);
    assert!(page.body.contains(&version.content.sha256) && page.body.contains(&version.citation));
    let csv = scene.stranger(&format!("{}/detections.csv", link.path)).await;
    assert_eq!(hex::encode(Sha256::digest(&csv.bytes)), version.content.sha256);
    let vue = scene.stranger(&format!("{}/detections.csv?format=vue", link.path)).await;
    assert!(vue.status == StatusCode::OK && vue.body.contains("A69-1105-101"), "{}", vue.body);
    for query in ["tag=102", "area=63,10;64,10;64,11", "from_us=0", "vessel=2069", "precision_m=1"] {
        let asked = scene.stranger(&format!("{}/detections.csv?{query}", link.path)).await;
        assert_eq!(asked.status, StatusCode::BAD_REQUEST, "{query}: a link takes no question");
    }
    let uses: Vec<(ShareVisitKind, String, String)> =
        scene.visits(&link.share).await.into_iter().map(|one| (one.what, one.file, one.address)).collect();
    let from = "198.51.100.9".to_owned();
    assert_eq!(
        uses,
        [
            (ShareVisitKind::Download, "detections-vue.csv".to_owned(), from.clone()),
            (ShareVisitKind::Download, "detections.csv".to_owned(), from.clone()),
            (ShareVisitKind::View, String::new(), from),
        ]
    );
    let listed: Vec<DatasetShare> = done(&scene.shore, "GET", &scene.shares(), &scene.token, json!({})).await;
    assert_eq!((listed[0].views, listed[0].downloads), (1, 2));
    // Other users cannot see them, and the address itself is stored nowhere.
    let viewer = scene.shore.token(None, Role::Viewer).await;
    assert_eq!(
        scene.shore.get(&format!("/api/v1{}", scene.shares()), &viewer).await.status,
        StatusCode::FORBIDDEN
    );
    let other = scene.shore.token(Some(FIRST + 1), Role::Researcher).await;
    assert_eq!(
        scene.shore.get(&format!("/api/v1{}", scene.shares()), &other).await.status,
        StatusCode::NOT_FOUND
    );
    assert!(!serde_json::to_string(&listed).unwrap().contains(secret));
    let app_db = std::fs::read(scene.shore.data().join("app.db")).unwrap();
    let log = std::fs::read(scene.shore.data().join("app.db-wal")).unwrap_or_default();
    let held = |bytes: &[u8]| bytes.windows(secret.len()).any(|part| part == secret.as_bytes());
    assert!(!held(&app_db) && !held(&log), "app.db keeps its hash alone");
    for path in reached(&link.path) {
        let answer = scene.stranger(&path).await;
        assert_eq!(answer.headers["x-robots-tag"], "noindex, nofollow", "{path}");
        assert!(path == link.path || !answer.body.contains(secret), "{path} has the address of the link");
    }
}

#[tokio::test]
async fn a_password_opens_a_link_in_one_browser_and_is_guessed_no_more_often_than_a_login() {
    let scene = Scene::of(&[]).await;
    let link = scene.link(json!({"password": PASSWORD})).await;
    let short = json!({"label": "x", "days": 1, "password": "short"});
    let short = say(&scene.shore, "POST", &scene.shares(), &scene.token, short).await;
    assert!(short.status == StatusCode::BAD_REQUEST && short.body.contains("password: "), "{}", short.body);
    let wrong = scene.form(&link.path, "guess").await;
    assert!(
        wrong.status == StatusCode::FORBIDDEN && wrong.body.contains("The password is wrong."),
        "{}",
        wrong.body
    );
    let right = scene.form(&link.path, PASSWORD).await;
    assert_eq!(
        (right.status, &right.headers[header::LOCATION]),
        (StatusCode::SEE_OTHER, &link.path.parse().unwrap())
    );
    let cookie = right.headers[header::SET_COOKIE].to_str().unwrap();
    assert!(cookie.contains("HttpOnly") && cookie.contains("Max-Age=43200"), "{cookie}");
    let cookie = cookie.split(';').next().unwrap().to_owned();
    let with = async |path: &str, cookie: &str| {
        scene.shore.send(Request::get(path).header(header::COOKIE, cookie), Body::empty()).await
    };
    let page = with(&link.path, &cookie).await;
    assert!(page.body.contains("Salmon in the fjord"), "{}", page.body);
    assert!(
        !page.body.contains("ld+json") && page.body.contains("noindex"),
        "a link with a password is for nobody else"
    );
    let file = format!("{}/detections.csv", link.path);
    assert_eq!(with(&file, &cookie).await.status, StatusCode::OK);
    let header = Request::get(&file).header("lutra-link-password", PASSWORD);
    assert_eq!(scene.shore.send(header, Body::empty()).await.status, StatusCode::OK, "a script gives it so");
    // It opens only this link, for half a day.
    let other = scene.link(json!({"password": "ten grey otters"})).await;
    let borrowed = cookie.replace(&format!("link_{}", link.share.id), &format!("link_{}", other.share.id));
    assert_eq!(
        with(&format!("{}/detections.csv", other.path), &borrowed).await.status,
        StatusCode::FORBIDDEN
    );
    scene.hand.advance(Duration::from_hours(13));
    assert_eq!(with(&file, &cookie).await.status, StatusCode::FORBIDDEN);
    let mut last = scene.form(&link.path, "guess").await;
    for _ in 0..7 {
        last = scene.form(&link.path, "guess").await;
    }
    assert_eq!(last.status, StatusCode::TOO_MANY_REQUESTS);
    assert!(
        last.headers.contains_key(header::RETRY_AFTER) && last.body.contains("Too many attempts"),
        "{}",
        last.body
    );
    assert_eq!(
        scene.form(&link.path, PASSWORD).await.status,
        StatusCode::TOO_MANY_REQUESTS,
        "nor by guessing right"
    );
    let guesses = scene.visits(&link.share).await;
    let guesses = guesses.iter().filter(|one| one.what == ShareVisitKind::WrongPassword).count();
    assert_eq!(guesses, 7, "those that were looked at");
}

#[tokio::test]
async fn a_link_gives_no_more_than_its_part_and_no_place_finer_than_its_cells() {
    let scene = Scene::of(&[]).await;
    let tag = json!({"kind": "animal", "name": "Fish", "release_place": "Munkholmen", "release_lat_deg": 63.4511, "release_lon_deg": 10.3833});
    let _: Value = done(&scene.shore, "POST", "/register", &scene.token, tag).await;
    let tag =
        json!({"kind": "tag", "protocol": "S256", "tag_id": 101, "animal": "Fish", "sensor_type": "depth"});
    let _: Value = done(&scene.shore, "POST", "/register", &scene.token, tag).await;
    let exact = ["63.43212300", "63.44645600", "63.45278900", "10.39876500", "10.41234500", "10.42198700"];
    let coarse = scene.link(json!({"precision_m": 1_000})).await;
    let covered = coarse.share.content.covered;
    assert_eq!((covered.south_deg, covered.north_deg), (Some(63.435), Some(63.455)));
    for path in reached(&coarse.path) {
        let answer = scene.stranger(&path).await;
        for place in exact.iter().map(|place| &place[..7]).chain(["Munkholmen", "63.4511", "10.3833", ",42,"])
        {
            assert!(!answer.body.contains(place), "{path} tells {place}: {}", answer.body);
        }
    }
    let csv = scene.stranger(&format!("{}/detections.csv", coarse.path)).await;
    assert!(csv.body.contains(",63.43500000,10.39000000,,,"), "{}", csv.body);
    assert_eq!(hex::encode(Sha256::digest(&csv.bytes)), coarse.share.content.sha256);
    // Another link with the same cells gives the same places, so that many links reveal no more than one.
    let again =
        scene.link(json!({"precision_m": 1_000, "area": "63.4,10.3;63.45,10.3;63.45,10.6;63.4,10.6"})).await;
    let part = scene.stranger(&format!("{}/detections.csv", again.path)).await;
    let places = |body: &str| -> Vec<String> {
        body.lines()
            .skip(1)
            .map(|line| line.split(',').skip(4).take(2).collect::<Vec<_>>().join(","))
            .collect()
    };
    assert_eq!(places(&part.body), places(&csv.body)[..2], "the middle of the third cell lies outside");

    let tags = scene.link(json!({"tags": ["S256-102"]})).await;
    for path in reached(&tags.path) {
        let answer = scene.stranger(&path).await;
        for mark in ["S256-101", "63.432", "63.452"] {
            assert!(!answer.body.contains(mark), "{path} tells {mark}: {}", answer.body);
        }
    }
    let package = scene.stranger(&format!("{}/datapackage.json", tags.path)).await;
    let package: Value = serde_json::from_str(&package.body).unwrap();
    assert_eq!(
        (&package["query"]["tags"], &package["resources"][0]["rows"]),
        (&json!(["S256-102"]), &json!(1))
    );
    let time = scene.link(json!({"from_us": START_US + 2_000_000, "to_us": START_US + 3_000_000})).await;
    let csv = scene.stranger(&format!("{}/detections.csv", time.path)).await;
    assert!(csv.body.lines().count() == 2 && csv.body.contains("S256-102"), "{}", csv.body);
    for (asked, named) in [
        (json!({"label": "x", "days": 1, "tags": ["S256-999"]}), "no detections"),
        (json!({"label": "x", "days": 1, "precision_m": 5}), "precision_m: "),
        (json!({"label": "x", "days": 0}), "days: "),
        (json!({"label": " ", "days": 1}), "label: "),
        (json!({"label": "x", "days": 1, "area": "1,2"}), "area: "),
        (json!({"label": "x", "days": 1, "version": 7}), "no such version"),
        (json!({"label": "x", "days": 1, "from_us": 9, "to_us": 3}), "to_us: "),
    ] {
        let answer = say(&scene.shore, "POST", &scene.shares(), &scene.token, asked.clone()).await;
        assert!(answer.status.is_client_error() && answer.body.contains(named), "{asked}: {}", answer.body);
    }
}

#[tokio::test]
async fn a_link_says_where_the_archive_had_changed_before_it_was_made_and_since() {
    let scene = Scene::of(&[]).await;
    let before = scene.link(json!({"tags": ["S256-101"]})).await;
    assert!(!before.share.had_changed);
    let page = scene.stranger(&before.path).await;
    assert!(page.body.contains("the same bytes as when this link was made"), "{}", page.body);
    assert!(
        page.body.contains("changed since this link was made, or another"),
        "the notebook: {}",
        page.body
    );
    let tag = json!({"kind": "tag", "protocol": "S256", "tag_id": 101, "serial": "77"});
    let _: Value = done(&scene.shore, "POST", "/register", &scene.token, tag).await;
    let after = scene.link(json!({"tags": ["S256-102"]})).await;
    assert!(after.share.had_changed, "{:?}", after.share);
    let page = scene.stranger(&after.path).await;
    assert!(page.body.contains("other bytes than were published"), "{}", page.body);
    assert!(page.body.contains("the same bytes as when this link was made"), "{}", page.body);
    scene.hand.advance(Duration::from_mins(11));
    let page = scene.stranger(&before.path).await;
    assert!(page.body.contains("has changed since this link was made: 2 rows then and now"), "{}", page.body);
}

#[tokio::test]
async fn places_of_a_version_with_an_area_are_not_coarsened() {
    let area = json!({"vessels": [FIRST], "area": "63.43,10.3;63.46,10.3;63.46,10.5;63.43,10.5"});
    let scene = Scene::of(&[("query", area)]).await;
    let asked = json!({"label": "x", "days": 1, "precision_m": 1_000});
    let answer = say(&scene.shore, "POST", &scene.shares(), &scene.token, asked).await;
    assert!(
        answer.status == StatusCode::BAD_REQUEST && answer.body.contains("precision_m: "),
        "{}",
        answer.body
    );
    scene.link(json!({})).await;
}

#[tokio::test]
async fn links_are_opened_no_more_often_than_their_budget_and_download_in_places_of_their_own() {
    let scene = Scene::of(&[]).await;
    let link = scene.link(json!({})).await;
    let _taken: Vec<_> = (0..4)
        .map(|_| std::sync::Arc::clone(&scene.shore.state.shore.history.exports).try_acquire_owned().unwrap())
        .collect();
    let file = format!("{}/detections.csv", link.path);
    assert_eq!(
        scene.stranger(&file).await.status,
        StatusCode::OK,
        "exports of people take no place of links"
    );
    let open = scene.shore.state.shore.datasets.open(
        link.path.trim_start_matches("/s/"),
        [198, 51, 100, 7].into(),
        None,
    );
    let held = scene.shore.state.shore.datasets.place(&open.await.unwrap().unwrap()).unwrap();
    let busy = scene.stranger(&file).await;
    assert!(busy.status == StatusCode::SERVICE_UNAVAILABLE && busy.headers.contains_key(header::RETRY_AFTER));
    drop(held);
    let unknown = format!("/s/{}", "0".repeat(64));
    for _ in 0..300 {
        scene.stranger(&format!("{unknown}/datacite.json")).await;
    }
    for path in [&*unknown, &*link.path, &*file] {
        let answer = scene.stranger(path).await;
        assert_eq!(answer.status, StatusCode::TOO_MANY_REQUESTS, "{path}");
        assert!(answer.headers.contains_key(header::RETRY_AFTER), "{path}");
    }
    scene.hand.advance(Duration::from_mins(2));
    assert_eq!(scene.stranger(&file).await.status, StatusCode::OK);
}

#[tokio::test]
async fn a_check_is_computed_once_for_all_who_ask_and_its_answer_waits_for_no_place() {
    let scene = Scene::of(&[]).await;
    let datasets = &scene.shore.state.shore.datasets;
    let mut opened = Vec::new();
    for tag in ["S256-101", "S256-102", "S256-102"] {
        let link = scene.link(json!({"tags": [tag]})).await;
        let secret = link.path.trim_start_matches("/s/").to_owned();
        opened.push(datasets.open(&secret, [198, 51, 100, 7].into(), None).await.unwrap().unwrap());
    }
    let (one, other) = tokio::join!(datasets.shared_check(&opened[0]), datasets.shared_check(&opened[0]));
    let (one, other) = (one.unwrap(), other.unwrap());
    assert!(one == other && one.is_same, "{one:?}");
    let _held = (datasets.place(&opened[1]).unwrap(), datasets.place(&opened[2]).unwrap());
    assert!(datasets.place(&opened[0]).is_err(), "all places are taken");
    assert_eq!(datasets.shared_check(&opened[0]).await.unwrap(), one, "what is known needs none");
}

#[tokio::test]
async fn a_link_opens_nothing_else_of_the_server() {
    let scene = Scene::of(&[]).await;
    let link = scene.link(json!({"password": PASSWORD})).await;
    let secret = link.path.trim_start_matches("/s/");
    let kept = scene.form(&link.path, PASSWORD).await;
    let kept = kept.headers[header::SET_COOKIE].to_str().unwrap().split(';').next().unwrap().to_owned();
    let with: [(&str, String); 7] = [
        ("authorization", format!("Bearer {secret}")),
        ("authorization", format!("Bearer lutra_api_{secret}")),
        ("authorization", format!("Bearer lutra_link_{secret}")),
        ("cookie", format!("lutra_session={secret}")),
        ("cookie", format!("{kept}; lutra_session={secret}; lutra_device={secret}")),
        ("lutra-link-password", PASSWORD.to_owned()),
        ("referer", format!("http://boat:8080{}", link.path)),
    ];
    for route in table().iter().filter(|route| !route.path.starts_with("/s/")) {
        for (name, value) in &with {
            let answer = scene.shore.send(request(route).header(*name, value), Body::empty()).await;
            let may = route.need == Need::Anyone && *name != "authorization";
            assert_eq!(answer.is_refused(), !may, "{} {} with {name}", route.method, route.path);
            tells_nothing(&answer, route.path, "Salmon in the fjord");
        }
    }
    // Nor do a person's roles make a link give more.
    let locked = format!("{}/detections.csv", link.path);
    assert_eq!(scene.shore.get(&locked, &scene.token).await.status, StatusCode::FORBIDDEN);
    let draft = draft(&[("title", json!("A secret draft"))]);
    let hidden: Dataset = done(&scene.shore, "POST", "/datasets", &scene.token, draft).await;
    let page = scene.shore.send(Request::get(&link.path).header("cookie", &kept), Body::empty()).await;
    assert!(
        page.body.contains("Salmon in the fjord") && !page.body.contains("A secret draft"),
        "{}",
        hidden.id
    );
}

/// With whole questions, which the server would answer to those who may ask them.
#[tokio::test]
async fn rows_of_tables_are_given_to_no_link_to_no_stranger_and_of_no_other_vessel() {
    let scene = Scene::of(&[]).await;
    let link = scene.link(json!({"precision_m": 1_000})).await;
    let secret = link.path.trim_start_matches("/s/");
    let elsewhere = scene.shore.token(Some(FIRST + 7), Role::Admin).await;
    let span = format!("from={}&to={}", START_US / 1_000, START_US / 1_000 + 60_000);
    let routes: Vec<Route> =
        table().into_iter().filter(|route| route.path.starts_with("/api/v1/table")).collect();
    assert_eq!(routes.len(), 4, "a route more of rows is looked at here too");
    for route in routes {
        // What the answer holds of the vessel.
        let (query, mark) = match route.path {
            "/api/v1/table" => (format!("{span}&series=TBRFishTag.SNR"), "TBRFishTag"),
            "/api/v1/table/detections" => (span.clone(), "S256-101"),
            "/api/v1/table/series" => (String::new(), "TBRFishTag"),
            _ => (String::new(), "\"value\":"),
        };
        for query in [query.clone(), format!("{query}&vessel={FIRST:#06x}")] {
            let is_for_vessel = query.contains("vessel=");
            if route.path.ends_with("/vessels") && is_for_vessel {
                continue;
            }
            let path = format!("{}?{}", route.path, query.trim_start_matches('&'));
            let own = scene.shore.get(&path, &scene.token).await;
            assert!(own.status == StatusCode::OK && own.body.contains(mark), "{path}: {}", own.body);
            for token in ["", secret, &format!("lutra_api_{secret}"), &format!("lutra_link_{secret}")] {
                let answer = scene.shore.get(&path, token).await;
                assert_eq!(answer.status, StatusCode::UNAUTHORIZED, "{path} with {token}");
                assert!(!answer.body.contains(mark), "{path}: {}", answer.body);
            }
            let other = scene.shore.get(&path, &elsewhere).await;
            let status = if is_for_vessel { StatusCode::FORBIDDEN } else { StatusCode::OK };
            assert_eq!(other.status, status, "{path}: {}", other.body);
            assert!(!other.body.contains(mark), "{path} as of another vessel: {}", other.body);
        }
    }
}
