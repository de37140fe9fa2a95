//! Plans through the API: permissions, conflicts, files.

use super::tests::{Shore, bearer};
use api::Role;
use axum::body::Body;
use axum::http::{Request, StatusCode, header};
use serde_json::{Value, json};

fn document(name: &str, vessel: Option<u16>) -> Value {
    let goto = |id: &str, lat_deg: f64| json!({"id": id, "speed": {"value": 1.5, "unit": "mps"}, "task": {"kind": "goto", "at": {"lat_deg": lat_deg, "lon_deg": 10.4}}});
    json!({"name": name, "description": "", "vessel": vessel, "repeat": false, "maneuvers": [goto("a", 63.44), goto("b", 63.45)]})
}

struct Person<'a> {
    shore: &'a Shore,
    token: String,
}

impl Person<'_> {
    async fn ask(&self, method: &str, path: &str, body: &Value) -> (StatusCode, Value) {
        let request =
            Request::builder().method(method).uri(path).header(header::CONTENT_TYPE, "application/json");
        let answer = self.shore.send(bearer(request, &self.token), Body::from(body.to_string())).await;
        (answer.status, serde_json::from_str(&answer.body).unwrap_or_default())
    }

    async fn get(&self, path: &str) -> (StatusCode, Value) {
        let answer = self.shore.get(path, &self.token).await;
        (answer.status, serde_json::from_str(&answer.body).unwrap_or_default())
    }
}

#[tokio::test]
async fn a_change_of_an_older_revision_gets_the_newer_plan() {
    let shore = Shore::with(|_| ()).await;
    let one = Person { shore: &shore, token: shore.token(None, Role::Operator).await };
    let other = Person { shore: &shore, token: shore.token(None, Role::Operator).await };
    let (status, made) = one.ask("POST", "/api/v1/plans", &document("survey", None)).await;
    assert_eq!(
        (status, &made["revision"], &made["draft"]),
        (StatusCode::OK, &json!(1), &json!(true)),
        "{made}"
    );
    let path = format!("/api/v1/plans/{}", made["id"]);
    let change =
        |draft: bool, name: &str| json!({"revision": 1, "draft": draft, "plan": document(name, None)});
    let (status, saved) = one.ask("PUT", &path, &change(false, "survey")).await;
    assert_eq!((status, &saved["revision"], &saved["draft"]), (StatusCode::OK, &json!(2), &json!(false)));
    for draft in [true, false] {
        let (status, refused) = other.ask("PUT", &path, &change(draft, "mine")).await;
        assert_eq!(status, StatusCode::CONFLICT);
        assert_eq!(refused["error"]["code"], "newer_revision");
        let says = &refused["error"]["says"];
        assert_eq!(
            says["template"],
            "{name} changed the plan meanwhile: it is at revision {now}, yours began at {from}."
        );
        assert_eq!((&says["values"]["now"], &says["values"]["from"]), (&json!("2"), &json!("1")));
        assert_eq!(
            (&refused["newer"]["revision"], &refused["newer"]["plan"]["name"]),
            (&json!(2), &json!("survey"))
        );
    }
    let (_, list) = other.get("/api/v1/plans").await;
    assert_eq!((&list[0]["digest"], &list[0]["problems"]), (&saved["check"]["digest"], &json!(0)), "{list}");
    assert!(list[0]["total"]["length_m"].as_f64().unwrap() > 1_000.0);
    let (_, old) = other.get(&format!("{path}?revision=1")).await;
    assert_eq!(old["draft"], true);
}

#[tokio::test]
async fn a_plan_with_problems_is_kept_but_not_saved() {
    let shore = Shore::with(|_| ()).await;
    let one = Person { shore: &shore, token: shore.token(None, Role::Operator).await };
    let (_, made) = one.ask("POST", "/api/v1/plans", &document("survey", None)).await;
    let path = format!("/api/v1/plans/{}", made["id"]);
    let mut bad = document("survey", None);
    bad["maneuvers"][1]["speed"]["value"] = json!(99);
    let (status, refused) = one.ask("PUT", &path, &json!({"revision": 1, "draft": false, "plan": bad})).await;
    assert_eq!(status, StatusCode::UNPROCESSABLE_ENTITY);
    assert!(
        refused["error"]["text"].as_str().unwrap().contains("b: This speed is not possible."),
        "{refused}"
    );
    let first = &refused["error"]["says"]["parts"]["first"][0];
    let template = first["parts"]["text"][0]["template"].as_str().unwrap();
    assert!(template.starts_with("This speed is not possible. Choose one above 0"), "{refused}");
    let (status, kept) = one.ask("PUT", &path, &json!({"revision": 1, "draft": true, "plan": bad})).await;
    assert_eq!((status, &kept["check"]["problems"][0]["maneuver"]), (StatusCode::OK, &json!("b")));
    let (status, check) = one.ask("POST", "/api/v1/plans/check", &bad).await;
    assert_eq!((status, &check["problems"]), (StatusCode::OK, &kept["check"]["problems"]));
}

#[tokio::test]
async fn a_vessels_plans_are_for_those_who_may_see_it_and_changed_by_its_operators() {
    let shore = Shore::with(|_| ()).await;
    let own = Person { shore: &shore, token: shore.token(Some(7), Role::Operator).await };
    let elsewhere = Person { shore: &shore, token: shore.token(Some(8), Role::Operator).await };
    let viewer = Person { shore: &shore, token: shore.token(Some(7), Role::Viewer).await };
    let (_, made) = own.ask("POST", "/api/v1/plans", &document("of seven", Some(7))).await;
    let path = format!("/api/v1/plans/{}", made["id"]);
    let change = |vessel| json!({"revision": 1, "draft": true, "plan": document("of seven", vessel)});
    assert_eq!(elsewhere.get(&path).await.0, StatusCode::NOT_FOUND);
    assert_eq!(elsewhere.get("/api/v1/plans").await.1, json!([]));
    assert_eq!(elsewhere.ask("PUT", &path, &change(None)).await.0, StatusCode::NOT_FOUND);
    assert_eq!(
        elsewhere.ask("POST", "/api/v1/plans", &document("x", Some(7))).await.0,
        StatusCode::FORBIDDEN
    );
    assert_eq!(viewer.get(&path).await.0, StatusCode::OK);
    assert_eq!(viewer.ask("DELETE", &path, &Value::Null).await.0, StatusCode::FORBIDDEN);
    assert_eq!(own.ask("PUT", &path, &change(Some(8))).await.0, StatusCode::FORBIDDEN, "nor given away");
    assert_eq!(own.ask("PUT", &path, &change(None)).await.0, StatusCode::OK);
    assert_eq!(elsewhere.get(&path).await.0, StatusCode::OK);
}

#[tokio::test]
async fn a_deleted_plan_is_gone_until_it_is_restored() {
    let shore = Shore::with(|_| ()).await;
    let one = Person { shore: &shore, token: shore.token(None, Role::Operator).await };
    let admin = Person { shore: &shore, token: shore.token(None, Role::Admin).await };
    let (_, made) = one.ask("POST", "/api/v1/plans", &document("survey", None)).await;
    let path = format!("/api/v1/plans/{}", made["id"]);
    assert_eq!(one.ask("DELETE", &path, &Value::Null).await.0, StatusCode::OK);
    assert_eq!(one.get(&path).await.0, StatusCode::NOT_FOUND);
    let (status, back) = one.ask("POST", &format!("{path}/restore"), &Value::Null).await;
    assert_eq!((status, &back["plan"]), (StatusCode::OK, &made["plan"]));
    let (_, copy) = one.ask("POST", &format!("{path}/duplicate"), &Value::Null).await;
    assert_eq!(copy["plan"]["name"], "survey (2)");
    let (_, audit) = admin.get("/api/v1/audit").await;
    let actions: Vec<&str> =
        audit.as_array().unwrap().iter().filter_map(|one| one["action"].as_str()).collect();
    assert_eq!(actions, ["plan.duplicate", "plan.restore", "plan.delete", "plan.create"]);
}

#[tokio::test]
async fn plans_go_out_and_come_in_as_files() {
    let shore = Shore::with(|_| ()).await;
    let one = Person { shore: &shore, token: shore.token(None, Role::Operator).await };
    let hostile = "<b>\"; rm -rf /æ";
    let (_, made) = one.ask("POST", "/api/v1/plans", &document(hostile, None)).await;
    for (format, ending) in [("imc", "imc.json"), ("geojson", "geojson"), ("gpx", "gpx")] {
        let path = format!("/api/v1/plans/{}/export?format={format}", made["id"]);
        let file = shore.get(&path, &one.token).await;
        let named = file.headers[header::CONTENT_DISPOSITION].to_str().unwrap().to_owned();
        assert_eq!(named, format!("attachment; filename=\"_b____rm_-rf___.{ending}\""));
        let request = Request::post("/api/v1/plans/import?name=a%20file");
        let answer = shore.send(bearer(request, &one.token), Body::from(file.body)).await;
        let read: Value = serde_json::from_str(&answer.body).unwrap();
        assert_eq!(read["stored"]["plan"]["maneuvers"].as_array().unwrap().len(), 2, "{read}");
        assert!(read["stored"]["plan"]["name"].as_str().unwrap().starts_with(hostile), "{read}");
    }
    let bad = shore
        .send(bearer(Request::post("/api/v1/plans/import?name=x.gpx"), &one.token), Body::from("<kml/>"))
        .await;
    assert_eq!(bad.status, StatusCode::UNPROCESSABLE_ENTITY);
    assert!(bad.body.contains("x.gpx was not imported: the file holds <kml>"), "{}", bad.body);
    let huge = Body::from(vec![b' '; 5 << 20]);
    let huge = shore.send(bearer(Request::post("/api/v1/plans/import?name=x"), &one.token), huge).await;
    assert_eq!(huge.status, StatusCode::PAYLOAD_TOO_LARGE);
    let wrong = shore.get(&format!("/api/v1/plans/{}/export?format=kml", made["id"]), &one.token).await;
    assert_eq!(wrong.status, StatusCode::BAD_REQUEST);
}
