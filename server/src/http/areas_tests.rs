//! No-go areas: permissions, and that plans, routes and the chart for the vessels have them at once.

use super::charts_tests::archipelago;
use super::tests::{Answer, Shore, bearer};
use api::{ChartSet, NoGoArea, NoGoAreas, Role, SeaRouteAnswer};
use axum::body::Body;
use axum::http::{Request, StatusCode};
use serde_json::{Value, json};

async fn say(shore: &Shore, method: &str, path: &str, token: &str, body: &Value) -> Answer {
    let request = bearer(Request::builder().method(method).uri(path), token);
    shore.send(request.header("content-type", "application/json"), Body::from(body.to_string())).await
}

/// A square of some hundred metres around a place of deep water.
fn farm() -> Value {
    json!({
        "name": "Salmon farm", "reason": "moorings",
        "corners": [[63.4455, 10.344], [63.4455, 10.346], [63.4465, 10.346], [63.4465, 10.344]],
    })
}

async fn list(shore: &Shore, token: &str) -> NoGoAreas {
    let answer = shore.get("/api/v1/no-go-areas?lifted=true", token).await;
    serde_json::from_str(&answer.body).unwrap()
}

async fn route(shore: &Shore, token: &str, to: [f64; 2]) -> SeaRouteAnswer {
    let ask = json!({"points": [[63.4460, 10.3425], to], "least_depth_m": 5.0, "clearance_m": 20.0});
    let answer = say(shore, "POST", "/api/v1/chart/route", token, &ask).await;
    assert_eq!(answer.status, StatusCode::OK, "{}", answer.body);
    serde_json::from_str(&answer.body).unwrap()
}

#[tokio::test]
async fn what_is_closed_is_gone_around_from_then_on_until_it_is_lifted() {
    let shore = Shore::with(archipelago).await;
    let operator = shore.token(None, Role::Operator).await;
    let viewer = shore.token(Some(7), Role::Viewer).await;
    let chart = async || {
        let answer = shore.get("/api/v1/chart", &viewer).await;
        serde_json::from_str::<ChartSet>(&answer.body).unwrap()
    };
    let offered = || shore.state.shore.charts.offered().borrow().as_ref().unwrap().digest();
    // A server answers before it has read the package for vessels.
    shore.state.shore.charts.look();
    let (before, aboard_before) = (chart().await, offered());
    let (beyond, inside) = ([63.4460, 10.3475], [63.4460, 10.3450]);
    let straight_m = route(&shore, &viewer, beyond).await.route.unwrap().length_m;

    let answer = say(&shore, "POST", "/api/v1/no-go-areas?key=a", &operator, &farm()).await;
    assert_eq!(answer.status, StatusCode::OK, "{}", answer.body);
    let made: NoGoArea = serde_json::from_str(&answer.body).unwrap();
    let again = say(&shore, "POST", "/api/v1/no-go-areas?key=a", &operator, &farm()).await;
    assert_eq!(serde_json::from_str::<NoGoArea>(&again.body).unwrap().id, made.id, "it is closed once");
    let listed = list(&shore, &viewer).await;
    assert_eq!((listed.areas.len(), listed.in_force, listed.may_change), (1, true, false));
    let with = chart().await;
    assert_ne!(with.set, before.set);
    assert_eq!(with.cells, before.cells, "it is not a chart");
    assert_ne!(offered(), aboard_before, "vessels get it too");

    let around = route(&shore, &viewer, beyond).await.route.unwrap();
    assert!(around.length_m > straight_m + 20.0, "{} m in place of {straight_m} m", around.length_m);
    assert_eq!(around.guard, None);
    let near = shore.get("/api/v1/chart/at?lat_deg=63.446&lon_deg=10.345", &viewer).await;
    assert!(near.body.contains("Salmon farm"), "{}", near.body);
    let moved = route(&shore, &viewer, inside).await.route.unwrap().moved;
    assert_eq!((moved.len(), &*moved[0].end), (1, "goal"));

    // Lifted and closed again.
    let path = format!("/api/v1/no-go-areas/{}", made.id);
    let change =
        |revision: u32, closed: bool| json!({"revision": revision, "area": farm(), "closed": closed});
    let lifted = say(&shore, "PATCH", &path, &operator, &change(1, false)).await;
    assert_eq!(lifted.status, StatusCode::OK, "{}", lifted.body);
    assert_eq!(say(&shore, "PATCH", &path, &operator, &change(1, true)).await.status, StatusCode::CONFLICT);
    assert_eq!((chart().await.set, offered()), (before.set, aboard_before));
    let listed = list(&shore, &viewer).await;
    assert!(listed.in_force && listed.areas[0].lifted.is_some());
    assert_eq!(say(&shore, "PATCH", &path, &operator, &change(2, true)).await.status, StatusCode::OK);
    assert_eq!(chart().await.set, with.set);
    let acts: Vec<String> = shore.audit().await.into_iter().rev().map(|entry| entry.action).collect();
    let acts: Vec<&str> = acts.iter().map(|one| &**one).filter(|one| one.starts_with("area.")).collect();
    assert_eq!(acts, ["area.close", "area.lift", "area.close"]);
}

/// A plan of two places, from south of the farm to north of it.
fn through() -> Value {
    let goto = |id: &str, lat_deg: f64| json!({"id": id, "speed": {"value": 1.5, "unit": "mps"}, "task": {"kind": "goto", "at": {"lat_deg": lat_deg, "lon_deg": 10.345}}});
    json!({"name": "a", "description": "", "vessel": null, "repeat": false, "maneuvers": [goto("a", 63.4452), goto("b", 63.4468)]})
}

/// The guard's verdict on a plan.
async fn guard(shore: &Shore, token: &str, plan: &Value) -> Value {
    let answer = say(shore, "POST", "/api/v1/plans/check", token, plan).await;
    assert_eq!(answer.status, StatusCode::OK, "{}", answer.body);
    serde_json::from_str::<Value>(&answer.body).unwrap()["guard"].clone()
}

#[tokio::test]
async fn nothing_is_closed_without_a_chart_and_a_chart_that_is_made_anew_has_what_is_closed() {
    let shore = Shore::with(|_| ()).await;
    let operator = shore.token(None, Role::Operator).await;
    let answer = say(&shore, "POST", "/api/v1/no-go-areas", &operator, &farm()).await;
    assert_eq!(answer.status, StatusCode::UNPROCESSABLE_ENTITY, "{}", answer.body);
    assert!(answer.body.contains("no sea chart"), "{}", answer.body);
    assert_eq!(guard(&shore, &operator, &through()).await, Value::Null);

    let charts = &shore.state.shore.charts;
    archipelago(shore.data());
    charts.look();
    assert_ne!(guard(&shore, &operator, &through()).await["outcome"], "refused");
    assert_eq!(say(&shore, "POST", "/api/v1/no-go-areas", &operator, &farm()).await.status, StatusCode::OK);
    let refused = guard(&shore, &operator, &through()).await;
    assert_eq!(refused["reasons"][0]["area"], "Salmon farm", "{refused}");
    // Without the file no area is known to be safe; once made again, it has the area.
    std::fs::remove_file(shore.data().join("charts/chart.gpkg")).unwrap();
    charts.look();
    assert!(list(&shore, &operator).await.trouble.unwrap().contains("there is no sea chart"));
    assert_eq!(guard(&shore, &operator, &through()).await["cause"], "no-go-areas");
    archipelago(shore.data());
    charts.look();
    assert!(list(&shore, &operator).await.in_force);
    assert_eq!(guard(&shore, &operator, &through()).await["reasons"][0]["area"], "Salmon farm");
}

#[tokio::test]
async fn an_area_is_in_the_chart_although_who_closed_it_did_not_wait() {
    let shore = Shore::with(archipelago).await;
    let operator = shore.token(None, Role::Operator).await;
    let (body, path) = (farm(), "/api/v1/no-go-areas?key=a");
    let asked = say(&shore, "POST", path, &operator, &body);
    // The connection breaks as soon as it is kept.
    let kept = async {
        while list(&shore, &operator).await.areas.is_empty() {
            tokio::task::yield_now().await;
        }
    };
    tokio::select! { _ = asked => {}, () = kept => {} }
    // Once the page has the answer to its repeated request, the chart holds it.
    let again = say(&shore, "POST", path, &operator, &body).await;
    assert_eq!(again.status, StatusCode::OK, "{}", again.body);
    let listed = list(&shore, &operator).await;
    assert_eq!((listed.areas.len(), listed.in_force), (1, true));
    assert_eq!(guard(&shore, &operator, &through()).await["reasons"][0]["area"], "Salmon farm");
}

#[tokio::test]
async fn a_chart_that_cannot_take_an_area_lets_no_plan_pass_until_it_does() {
    let shore = Shore::with(archipelago).await;
    let operator = shore.token(None, Role::Operator).await;
    // Charts are being imported at this moment.
    let lock = std::fs::File::create(shore.data().join("charts/chart.gpkg.lock")).unwrap();
    lock.lock().unwrap();
    let answer = say(&shore, "POST", "/api/v1/no-go-areas", &operator, &farm()).await;
    assert_eq!(answer.status, StatusCode::OK, "it is kept: {}", answer.body);
    let listed = list(&shore, &operator).await;
    assert!(listed.trouble.unwrap().contains("being changed by another process"));
    assert_eq!(guard(&shore, &operator, &through()).await["cause"], "no-go-areas");
    let ask = json!({"points": [[63.4452, 10.345], [63.4468, 10.345]]});
    let route = say(&shore, "POST", "/api/v1/chart/route", &operator, &ask).await;
    assert_eq!(route.status, StatusCode::SERVICE_UNAVAILABLE, "{}", route.body);
    // A set that arrives meanwhile is not offered to vessels either.
    let offered = || shore.state.shore.charts.offered().borrow().as_ref().unwrap().digest();
    let before = offered();
    let db = shore.data().join("charts/chart.gpkg");
    let other = shore.data().join("charts/other.gpkg");
    std::fs::copy(&db, &other).unwrap();
    chartdb::remove(&other, &["XX5LUTRA".to_owned()], units::UtcTime::from_micros(0)).unwrap();
    std::fs::rename(&other, &db).unwrap();
    shore.state.shore.charts.look();
    assert_eq!(offered(), before);
    drop(lock);
    shore.state.shore.charts.look();
    assert!(list(&shore, &operator).await.in_force);
    assert_ne!(offered(), before);
    assert_eq!(guard(&shore, &operator, &through()).await["cause"], Value::Null);
}

#[tokio::test]
async fn only_operators_of_all_vessels_close_and_what_cannot_be_an_area_is_refused_at_its_field() {
    let shore = Shore::with(|_| ()).await;
    let operator = shore.token(None, Role::Operator).await;
    let of_one = shore.token(Some(7), Role::Operator).await;
    let refused = say(&shore, "POST", "/api/v1/no-go-areas", &of_one, &farm()).await;
    assert_eq!(refused.status, StatusCode::FORBIDDEN, "{}", refused.body);
    let many: Vec<[f64; 2]> = (0..201).map(|n| [63.0, 10.0 + f64::from(n) * 1e-4]).collect();
    for (field, value, told) in [
        ("name", json!(""), "name: empty"),
        ("name", json!("a\nb"), "name: has several lines"),
        ("reason", json!("x".repeat(501)), "reason: has 501"),
        ("corners", json!([[63.0, 10.0], [63.1, 10.0]]), "corners: there are 2; give 3 to 200"),
        ("corners", json!(many), "corners: there are 201"),
        ("corners", json!([[63.0, 10.0], [91.0, 10.0], [63.0, 10.1]]), "corners: 91, 10 is not a place"),
        ("corners", json!([[63.0, 10.0], [63.1, 10.1], [63.1, 10.0], [63.0, 10.1]]), "cross or touch near"),
        ("corners", json!([[63.0, 10.0], [64.0, 10.0], [64.0, 12.0]]), "at most 200 km"),
        ("corners", json!([[63.0, 179.9], [63.1, 179.9], [63.0, -179.9]]), "the date line"),
        ("corners", json!([[60.0, -179.99], [60.05, -179.99], [60.0, -180.0]]), "the date line"),
        // Twice round, its inside would be outside.
        (
            "corners",
            json!([[63.0, 10.0], [63.1, 10.0], [63.0, 10.1], [63.0, 10.0], [63.1, 10.0], [63.0, 10.1]]),
            "cross or touch",
        ),
        ("corners", json!([[63.0, 10.0], [63.1, 10.0], [63.05, 10.0], [63.05, 10.1]]), "cross or touch"),
        ("colour", json!(1), "colour"),
    ] {
        let mut body = farm();
        body[field] = value;
        let answer = say(&shore, "POST", "/api/v1/no-go-areas", &operator, &body).await;
        assert!(answer.status.is_client_error() && answer.body.contains(told), "{told}: {}", answer.body);
    }
    let nothing = json!({"revision": 1, "area": farm(), "closed": false});
    let answer = say(&shore, "PATCH", "/api/v1/no-go-areas/9", &operator, &nothing).await;
    assert_eq!(answer.status, StatusCode::NOT_FOUND, "{}", answer.body);
}

/// Closes areas together.
async fn batch(shore: &Shore, token: &str, areas: Value) -> Answer {
    say(shore, "POST", "/api/v1/no-go-areas/batch?key=b", token, &json!({ "areas": areas })).await
}

/// The farm under another name, so many tens of metres farther north.
fn northwards(name: &str, tens: u32) -> Value {
    let mut area = farm();
    let shift_deg = f64::from(tens) * 1e-4;
    for corner in area["corners"].as_array_mut().unwrap() {
        corner[0] = json!(corner[0].as_f64().unwrap() + shift_deg);
    }
    area["name"] = json!(name);
    area
}

#[tokio::test]
async fn areas_of_a_file_are_closed_together_or_not_at_all() {
    let shore = Shore::with(archipelago).await;
    let operator = shore.token(None, Role::Operator).await;
    let mut bad = farm();
    bad["corners"] = json!([[63.0, 10.0]]);
    let refused = batch(&shore, &operator, json!([farm(), bad])).await;
    assert_eq!(refused.status, StatusCode::BAD_REQUEST, "{}", refused.body);
    assert!(refused.body.contains("area 2, corners: there are 1"), "{}", refused.body);
    for wrong in [json!([]), json!(vec![farm(); 201])] {
        let refused = batch(&shore, &operator, wrong).await;
        assert!(refused.body.contains("give 1 to 200"), "{}", refused.body);
    }
    assert!(list(&shore, &operator).await.areas.is_empty());

    let areas = json!([northwards("a net", 0), northwards("a rock", 5), northwards("a wreck", 10)]);
    for _ in 0..2 {
        // Also when it is sent again, as the page does without an answer.
        let closed = batch(&shore, &operator, areas.clone()).await;
        assert_eq!(closed.status, StatusCode::OK, "{}", closed.body);
        let closed: NoGoAreas = serde_json::from_str(&closed.body).unwrap();
        let names: Vec<&str> = closed.areas.iter().map(|one| &*one.area.name).collect();
        assert_eq!((names, closed.in_force), (vec!["a net", "a rock", "a wreck"], true));
    }
    assert_eq!(guard(&shore, &operator, &through()).await["outcome"], "refused");
    let acts =
        shore.audit().await.into_iter().filter(|one| one.action == "area.close" && one.outcome == "done");
    let subjects: Vec<String> = acts.map(|one| one.subject).collect();
    assert_eq!(subjects, ["3 areas, the first one a net"]);
    // A file that does not fit as a whole is not taken in part.
    let many: Vec<Value> = (0..198).map(|_| farm()).collect();
    let full = say(&shore, "POST", "/api/v1/no-go-areas/batch", &operator, &json!({ "areas": many })).await;
    assert!(full.body.contains("3 areas are closed; 198 more would be above 200"), "{}", full.body);
    assert_eq!(list(&shore, &operator).await.areas.len(), 3);
}

#[tokio::test]
async fn as_many_areas_as_are_taken_with_as_many_corners_as_each_may_have_are_one_request() {
    let shore = Shore::with(archipelago).await;
    let operator = shore.token(None, Role::Operator).await;
    let round = |number: u32| {
        let corners = (0..200).map(|step| {
            let angle = f64::from(step) * std::f64::consts::TAU / 200.0;
            let east_deg = 10.344 + f64::from(number) * 1e-3;
            [63.4455 + 1e-4 * angle.sin(), east_deg + 2e-4 * angle.cos()]
        });
        json!({"name": format!("cage {number}"), "reason": "x".repeat(500), "corners": corners.collect::<Vec<_>>()})
    };
    let closed = batch(&shore, &operator, (0..200).map(round).collect()).await;
    assert_eq!(closed.status, StatusCode::OK, "{}", closed.body);
    assert_eq!(list(&shore, &operator).await.areas.len(), 200);
}

#[tokio::test]
async fn while_an_area_cannot_be_read_no_plan_passes_and_vessels_keep_the_chart_that_they_have() {
    let shore = Shore::with(archipelago).await;
    let operator = shore.token(None, Role::Operator).await;
    let closed = say(&shore, "POST", "/api/v1/no-go-areas", &operator, &farm()).await;
    let first: NoGoArea = serde_json::from_str(&closed.body).unwrap();
    let offered = || shore.state.shore.charts.offered().borrow().as_ref().unwrap().digest();
    let before = offered();
    let db = rusqlite::Connection::open(shore.data().join("app.db")).unwrap();
    db.execute("UPDATE no_go_area SET body = '{}' WHERE id = ?1", [first.id]).unwrap();
    // The next change gives the chart all closed areas.
    let wreck = northwards("a wreck", 20);
    assert_eq!(say(&shore, "POST", "/api/v1/no-go-areas", &operator, &wreck).await.status, StatusCode::OK);
    let listed = list(&shore, &operator).await;
    let trouble = listed.trouble.unwrap();
    assert!(trouble.contains(&format!("area {} cannot be read", first.id)), "{trouble}");
    assert_eq!(guard(&shore, &operator, &through()).await["cause"], "no-go-areas");
    assert_eq!(offered(), before, "that one has the area which is lost here");
    let near = shore.get("/api/v1/chart/at?lat_deg=63.446&lon_deg=10.345", &operator).await;
    assert!(near.body.contains("Salmon farm"), "the chart is the last to know where it lies: {}", near.body);
    // Lifted, as the message says.
    let unreadable = listed.areas.iter().find(|one| one.id == first.id).unwrap();
    let lift = json!({"revision": unreadable.revision, "area": unreadable.area, "closed": false});
    let path = format!("/api/v1/no-go-areas/{}", first.id);
    let lifted = say(&shore, "PATCH", &path, &operator, &lift).await;
    assert_eq!(lifted.status, StatusCode::OK, "{}", lifted.body);
    assert!(list(&shore, &operator).await.in_force);
    assert_ne!(guard(&shore, &operator, &through()).await["cause"], "no-go-areas");
    assert_ne!(offered(), before);
}
