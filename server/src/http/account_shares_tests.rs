//! Links for one account: to whom they open, and what somebody without a role sees of the server.

use super::datasets_tests::{done, say};
use super::shares_tests::{Scene, reached, tells_nothing};
use super::tests::{Answer, Shore, bearer, request};
use crate::serve::router::table;
use crate::web::{Kind, Need};
use api::{DatasetShare, Role, SharedDataset};
use axum::body::Body;
use axum::http::{Request, StatusCode, header};
use serde_json::json;
use sha2::{Digest as _, Sha256};
use shore::clock::Clock;
use shore::identity::{password, persons};

const GUEST: &str = "Ola";
const PASSWORD: &str = "nine grey otters";

/// An account without a role, by its password.
async fn guest(shore: &Shore, must_change: bool) {
    let add = persons::Add {
        name: GUEST.to_owned(),
        password_hash: password::hash(PASSWORD),
        must_change,
        vessel: None,
        role: None,
        now: Clock::real().utc(),
    };
    shore.state.shore.people.change(add).await.unwrap();
}

async fn cookies(shore: &Shore) -> String {
    shore.login(GUEST, PASSWORD).await.cookies()
}

/// The token of a new account that has lost its role.
async fn token_without_role(shore: &Shore) -> (String, String) {
    let name = format!("person{}", shore.state.shore.people.ask(persons::List).await.unwrap().len());
    let token = shore.token(None, Role::Viewer).await;
    let none = persons::SetRole { name: name.clone(), vessel: None, role: None };
    shore.state.shore.people.change(none).await.unwrap();
    (name, token)
}

async fn shared(shore: &Shore, token: &str) -> Vec<SharedDataset> {
    done(shore, "GET", "/shared", token, json!({})).await
}

fn opens_to_nobody(answer: &Answer, path: &str, is_page: bool, sha256: &str) {
    let wanted = if is_page { StatusCode::SEE_OTHER } else { StatusCode::UNAUTHORIZED };
    assert_eq!(answer.status, wanted, "{path}: {}", answer.body);
    tells_nothing(answer, path, sha256);
    assert!(!answer.body.contains("Salmon in the fjord"), "{path} names the dataset");
}

#[tokio::test]
async fn a_link_for_an_account_opens_to_that_account_alone() {
    let scene = Scene::of(&[]).await;
    let sha256 = scene.dataset.versions[0].content.sha256.clone();
    guest(&scene.shore, false).await;
    let link = scene.link(json!({"person": "ola", "tags": ["S256-101"]})).await;
    assert_eq!(link.share.person.as_deref(), Some(GUEST), "the name as the account has it");
    let own = cookies(&scene.shore).await;
    let other = scene.shore.admin().await;
    for path in reached(&link.path) {
        let is_page = path == link.path;
        opens_to_nobody(&scene.stranger(&path).await, &path, is_page, &sha256);
        // Who made it, and an admin, have their own ways to the data.
        for answer in [scene.shore.get(&path, &scene.token).await, scene.shore.page(&path, &other).await] {
            assert_eq!(answer.status, StatusCode::NOT_FOUND, "{path}: {}", answer.body);
            tells_nothing(&answer, &path, &sha256);
        }
        // What is of the register and not of detections is refused to all.
        let wanted =
            if path.ends_with("actel-biometrics") { StatusCode::BAD_REQUEST } else { StatusCode::OK };
        assert_eq!(scene.shore.page(&path, &own).await.status, wanted, "{path}");
    }
    let login = scene.stranger(&link.path).await;
    let back = format!("/login?next={}", link.path);
    assert_eq!(login.headers[header::LOCATION], back.as_str());
    let csv = scene.shore.page(&format!("{}/detections.csv", link.path), &own).await;
    assert_eq!(
        hex::encode(Sha256::digest(&csv.bytes)),
        link.share.content.sha256,
        "the part that was shared"
    );
    assert!(csv.body.contains("S256-101") && !csv.body.contains("S256-102"), "{}", csv.body);
    let listed: Vec<DatasetShare> = done(&scene.shore, "GET", &scene.shares(), &scene.token, json!({})).await;
    assert!(listed[0].views == 1 && listed[0].downloads > 1, "its uses are listed: {listed:?}");
    assert_eq!(listed[0].person.as_deref(), Some(GUEST));
}

#[tokio::test]
async fn what_is_shared_with_an_account_is_on_its_page_until_it_is_revoked() {
    let scene = Scene::of(&[]).await;
    guest(&scene.shore, false).await;
    let (script, token) = token_without_role(&scene.shore).await;
    let own = cookies(&scene.shore).await;
    let first = scene.shore.page("/", &own).await;
    assert_eq!(
        (first.status, &first.headers[header::LOCATION]),
        (StatusCode::SEE_OTHER, &"/shared".parse().unwrap())
    );
    let page = scene.shore.page("/shared", &own).await;
    assert!(page.body.contains("No dataset is shared with you at present"), "{}", page.body);
    assert!(!page.body.contains("href=\"/plans\"") && !page.body.contains("href=\"/data\""), "{}", page.body);
    scene.link(json!({})).await;
    let link = scene.link(json!({"person": GUEST})).await;
    let by_script = scene.link(json!({"person": script})).await;
    let page = scene.shore.page("/shared", &own).await;
    let version = &scene.dataset.versions[0];
    assert!(page.body.contains(&link.path) && page.body.contains(&version.citation), "{}", page.body);
    assert!(!page.body.contains(&by_script.path), "what is for others is not shown");
    let listed = shared(&scene.shore, &token).await;
    assert_eq!(
        listed.iter().map(|one| (&*one.path, one.rows)).collect::<Vec<_>>(),
        [(&*by_script.path, version.content.rows)]
    );
    assert_eq!(
        scene.shore.get(&format!("{}/detections.csv", by_script.path), &token).await.status,
        StatusCode::OK
    );
    assert_eq!(shared(&scene.shore, &scene.token).await, [], "nor to who made them");
    scene.revoke(&by_script.share).await;
    assert_eq!(shared(&scene.shore, &token).await, []);
    let gone = scene.shore.get(&by_script.path, &token).await;
    assert!(gone.status == StatusCode::GONE && gone.body.contains("revoked"), "{}", gone.body);
}

#[tokio::test]
async fn a_link_for_an_account_ends_with_it_and_not_with_its_name_or_number() {
    let scene = Scene::of(&[]).await;
    guest(&scene.shore, false).await;
    let link = scene.link(json!({"person": GUEST})).await;
    scene.shore.state.shore.people.change(persons::Remove(GUEST.to_owned())).await.unwrap();
    // The next one gets the same name, and by SQLite's rule the same number.
    guest(&scene.shore, false).await;
    let own = cookies(&scene.shore).await;
    assert_eq!(scene.shore.page(&link.path, &own).await.status, StatusCode::NOT_FOUND);
    assert!(!scene.shore.page("/shared", &own).await.body.contains(&link.path));
    let listed: Vec<DatasetShare> = done(&scene.shore, "GET", &scene.shares(), &scene.token, json!({})).await;
    assert!(listed[0].revoked.is_some(), "{listed:?}");
}

#[tokio::test]
async fn a_one_time_password_opens_no_link_for_its_account() {
    let scene = Scene::of(&[]).await;
    let sha256 = scene.dataset.versions[0].content.sha256.clone();
    guest(&scene.shore, true).await;
    let link = scene.link(json!({"person": GUEST})).await;
    let own = cookies(&scene.shore).await;
    for path in reached(&link.path) {
        let answer = scene.shore.page(&path, &own).await;
        opens_to_nobody(&answer, &path, path == link.path, &sha256);
    }
    assert_eq!(scene.shore.page(&link.path, &own).await.headers[header::LOCATION], "/account");
}

#[tokio::test]
async fn a_link_for_an_account_that_is_not_there_or_with_a_password_is_refused_at_its_field() {
    let scene = Scene::of(&[]).await;
    guest(&scene.shore, false).await;
    for (more, field) in [
        (json!({"person": "nobody.here"}), "person: there is no account nobody.here"),
        (json!({"person": GUEST, "password": PASSWORD}), "password: a link for one account"),
    ] {
        let mut asked = json!({"label": "Ola", "days": 30});
        asked.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        let answer = say(&scene.shore, "POST", &scene.shares(), &scene.token, asked).await;
        assert!(answer.status == StatusCode::BAD_REQUEST && answer.body.contains(field), "{}", answer.body);
    }
    let blank = scene.link(json!({"person": " "})).await;
    assert!(blank.share.person.is_none() && !blank.path.contains("account"), "an empty field names nobody");
}

#[tokio::test]
async fn an_account_without_a_role_sees_nothing_else_of_the_server() {
    let scene = Scene::of(&[]).await;
    let (_, token) = token_without_role(&scene.shore).await;
    for route in table() {
        let answer = scene.shore.send(bearer(request(&route), &token), Body::empty()).await;
        // Tokens and sessions are changed by browsers alone, which the handlers see to.
        if route.need == Need::Account && !route.method.is_safe() {
            continue;
        }
        let may = matches!(route.need, Need::Anyone | Need::Account);
        // The first page leads to what is shared.
        let leads = route.path == "/" && answer.headers[header::LOCATION] == "/shared";
        assert_eq!(answer.is_refused() || leads, !may, "{} {}: {}", route.method, route.path, answer.body);
        if route.need != Need::Anyone {
            tells_nothing(&answer, route.path, "Salmon in the fjord");
        }
        if matches!(route.need, Need::Somewhere(_)) && route.kind == Kind::Api {
            assert!(
                answer.body.contains("\"code\":\"no_role\""),
                "{} {}: {}",
                route.method,
                route.path,
                answer.body
            );
        }
    }
    let anonymous = scene.shore.send(Request::get("/api/v1/shared"), Body::empty()).await;
    assert_eq!(anonymous.status, StatusCode::UNAUTHORIZED);
}
