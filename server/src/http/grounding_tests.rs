//! The grounding guard before an order is given, with the fictitious archipelago.

use super::charts_tests::archipelago;
use super::testing::{Boats, FIRST, boat, packet};
use super::tests::{Shore, bearer};
use api::{PlanDocument, Role};
use axum::body::Body;
use axum::http::{Request, StatusCode};
use imc::messages::{
    EntityParameter, EntityParameters, EstimatedState, Message, Payload as _, PlanControl, PlanControlType,
    PlanDB, PlanDBInformation, PlanDBOp, PlanDBState, PlanDBType, PlanSpecification,
};
use imc::{Address, Header, Packet, PacketView};
use serde_json::{Value, json};
use shore::{clock, plans};

/// Open water where the demonstration's Otters sail, and a way over the shoal south of it.
const OPEN: [[f64; 2]; 2] = [[63.4465, 10.3500], [63.4485, 10.3530]];
const SHOAL: [[f64; 2]; 2] = [[63.4460, 10.3516], [63.4424, 10.3516]];

/// A shore with the chart, a boat at the start of the demonstration and an operator who has control of it.
struct Scene {
    shore: Shore,
    boats: Boats,
    token: String,
}

impl Scene {
    async fn start(fill: impl FnOnce(&std::path::Path)) -> Self {
        let shore = Shore::with(fill).await;
        let token = shore.token(Some(FIRST), Role::Operator).await;
        let boats = Boats::join(&shore.state.shore.router).await;
        let now = clock::now();
        boats.say(boat(0, now)).await;
        let (lat, lon) = (63.446_f64.to_radians(), 10.345_f64.to_radians());
        boats.say(vec![packet(0, 1, now, EstimatedState { lat, lon, ..EstimatedState::default() })]).await;
        let scene = Self { shore, boats, token };
        let lease = json!({"action": "request", "window": "a"});
        assert_eq!(scene.post("vessels/2068/lease", &lease).await.0, StatusCode::OK);
        scene
    }

    async fn ask(&self, method: &str, path: &str, body: &Value) -> (StatusCode, Value) {
        let request = Request::builder().method(method).uri(format!("/api/v1/{path}"));
        let request = bearer(request, &self.token).header("content-type", "application/json");
        let answer = self.shore.send(request, Body::from(body.to_string())).await;
        (answer.status, serde_json::from_str(&answer.body).unwrap_or_default())
    }

    async fn post(&self, path: &str, body: &Value) -> (StatusCode, Value) {
        self.ask("POST", path, body).await
    }

    async fn order(&self, order: Value) -> (StatusCode, Value) {
        self.post("vessels/2068/commands", &json!({"order": order, "window": "a"})).await
    }

    /// Saves a plan; returns its number and document.
    async fn plan(&self, name: &str, places: [[f64; 2]; 2]) -> (i64, Value) {
        let goto = |(n, [lat_deg, lon_deg]): (usize, [f64; 2])| {
            let task = json!({"kind": "goto", "at": {"lat_deg": lat_deg, "lon_deg": lon_deg}});
            json!({"id": format!("P{n}"), "speed": {"value": 1.5, "unit": "mps"}, "task": task})
        };
        let maneuvers: Vec<Value> = places.into_iter().enumerate().map(goto).collect();
        let plan =
            json!({"name": name, "description": "", "vessel": null, "repeat": false, "maneuvers": maneuvers});
        let (status, made) = self.post("plans", &plan).await;
        assert_eq!(status, StatusCode::OK, "{made}");
        let id = made["id"].as_i64().unwrap();
        let saved = json!({"revision": 1, "draft": false, "plan": plan});
        let (status, saved) = self.ask("PUT", &format!("plans/{id}"), &saved).await;
        assert_eq!(status, StatusCode::OK, "{saved}");
        let refused = saved["check"]["guard"]["outcome"] == "refused";
        assert_eq!(refused, name == "shoal", "{saved}");
        (id, plan)
    }

    async fn upload(&self, id: i64) -> (StatusCode, Value) {
        self.post(&format!("plans/{id}/upload"), &json!({"vessel": FIRST, "revision": 2, "window": "a"}))
            .await
    }
}

fn is_refused((status, answer): &(StatusCode, Value)) {
    assert_eq!(*status, StatusCode::UNPROCESSABLE_ENTITY, "{answer}");
    assert_eq!(answer["error"]["code"], "grounding", "{answer}");
    let text = answer["error"]["text"].as_str().unwrap();
    assert!(text.starts_with("The chart shows danger: ") && text.contains("XX5LUTRA"), "{text}");
    // The parameters for a page's own text, with the place.
    let guard: api::Guard = serde_json::from_value(answer["error"]["guard"].clone()).unwrap();
    let leg = &guard.reasons[0];
    assert!(guard.outcome == "refused" && leg.from.is_some() && leg.to.is_some(), "{answer}");
    assert!((leg.lat_deg - 63.445).abs() < 0.01 && (10.31..10.36).contains(&leg.lon_deg), "{answer}");
    assert!(!leg.code.is_empty() && leg.cell.as_deref() == Some("XX5LUTRA"), "{answer}");
}

#[tokio::test]
async fn what_a_vessel_refuses_in_words_is_handed_on_with_leg_reason_and_place() {
    let scene = Scene::start(archipelago).await;
    let (status, given) = scene.order(json!({"kind": "plan.start", "plan_id": "foreign"})).await;
    assert_eq!(status, StatusCode::ACCEPTED, "{given}");
    let packet = scene.boats.heard(PlanControl::ID).await;
    let request: PlanControl = imc::decode(&PacketView::new(&packet).unwrap()).unwrap().unwrap();
    let sentence = "'Bird's nest' (track 2): 2.5 m deep; needs 5.0 m at 63.44416, 10.35160 (DEPARE of XX5LUTRA) (and 3 more legs)";
    let (info, none) = (sentence.into(), None::<Message>.into());
    let refused = PlanControl { r#type: PlanControlType::Failure, info, arg: none, ..request };
    let header = Header {
        src: Address(FIRST),
        dst: scene.shore.state.shore.router.address(),
        timestamp: clock::now().seconds(),
        ..Header::default()
    };
    scene.boats.say(vec![Packet::new(header, refused).encode().unwrap().into()]).await;
    let path = format!("vessels/2068/commands/{}", given["id"]);
    let (_, command) = scene.ask("GET", &path, &Value::Null).await;
    let command: api::Command = serde_json::from_value(command).unwrap();
    let last = command.steps.last().unwrap();
    assert_eq!((&last.stage[..], &last.text[..]), ("refused", sentence));
    let leg = last.leg.as_ref().unwrap();
    assert_eq!((&leg.maneuver[..], &leg.part[..], leg.number), ("Bird's nest", "track", 1));
    assert_eq!((&leg.code[..], leg.depth_m, leg.margin_m), ("too-shallow", Some(2.5), Some(-2.5)));
    assert!((leg.lat_deg - 63.444_16).abs() < 1e-9 && (leg.lon_deg - 10.3516).abs() < 1e-9);
    assert!(command.steps.iter().rev().skip(1).all(|step| step.leg.is_none()));
}

#[tokio::test]
async fn who_has_no_control_is_told_why_by_a_code() {
    let scene = Scene::start(|_| ()).await;
    let order = json!({"order": {"kind": "plan.stop"}, "window": "another"});
    let (status, answer) = scene.post("vessels/2068/commands", &order).await;
    assert_eq!((status, &answer["error"]["code"]), (StatusCode::CONFLICT, &json!("no_control")));
    assert_eq!(answer["error"]["control"], json!({"why": "other_window"}), "{answer}");
    let (lease, free) = ("vessels/2068/lease", json!({"why": "free"}));
    let (_, answer) = scene.post(lease, &json!({"action": "release", "window": "a"})).await;
    assert_eq!(answer["holder"], Value::Null, "{answer}");
    let (_, answer) = scene.order(json!({"kind": "plan.stop"})).await;
    assert_eq!(answer["error"]["control"], free, "{answer}");
    let (_, answer) = scene.post(lease, &json!({"action": "grant", "window": "a"})).await;
    assert_eq!(answer["error"]["control"], free, "{answer}");
}

#[tokio::test]
async fn a_plan_over_a_shoal_goes_aboard_of_no_vessel() {
    let scene = Scene::start(archipelago).await;
    let (shoal, _) = scene.plan("shoal", SHOAL).await;
    is_refused(&scene.upload(shoal).await);
    // The first plan that reaches the vessel is the one in deep water.
    let (open, _) = scene.plan("open", OPEN).await;
    assert_eq!(scene.upload(open).await.0, StatusCode::ACCEPTED);
    let packet = scene.boats.heard(PlanDB::ID).await;
    let sent: PlanDB = imc::decode(&PacketView::new(&packet).unwrap()).unwrap().unwrap();
    assert_eq!((sent.op, sent.plan_id.as_str()), (PlanDBOp::Set, Some("open")));
}

/// The guard's verdict while drawing a single waypoint, for a vessel or none.
async fn drawn(scene: &Scene, [lat_deg, lon_deg]: [f64; 2], vessel: Option<u16>) -> Value {
    let task = json!({"kind": "goto", "at": {"lat_deg": lat_deg, "lon_deg": lon_deg}});
    let step = json!({"id": "P1", "speed": {"value": 1.5, "unit": "mps"}, "task": task});
    let plan =
        json!({"name": "p", "description": "", "vessel": vessel, "repeat": false, "maneuvers": [step]});
    let (status, check) = scene.post("plans/check", &plan).await;
    assert_eq!(status, StatusCode::OK, "{check}");
    check["guard"].clone()
}

fn warnings(guard: &Value) -> Vec<&str> {
    guard["warnings"].as_array().unwrap().iter().map(|one| one["code"].as_str().unwrap()).collect()
}

#[tokio::test]
async fn a_drawing_counts_from_where_its_vessel_floats_by_what_the_vessel_told() {
    let scene = Scene::start(archipelago).await;
    // Beyond an island from where the boat is: only the way there is in danger.
    let beyond = [63.4500, 10.3180];
    let guard = drawn(&scene, beyond, Some(FIRST)).await;
    assert_eq!((&guard["outcome"], &guard["reasons"][0]["part"]), (&json!("refused"), &json!("transit")));
    let from = &guard["reasons"][0]["from"];
    assert!((from["lat_deg"].as_f64().unwrap() - 63.446).abs() < 1e-6, "{guard}");
    let nobodys = drawn(&scene, beyond, None).await;
    assert_eq!((&nobodys["outcome"], warnings(&nobodys)), (&json!("warnings"), vec!["start-unknown"]));
    assert_eq!((&nobodys["autonomous_m"], &nobodys["of_vessel"]), (&json!(5.0), &json!(false)));
    // The check must not reveal a vessel's position to users who may not see it.
    let stranger = scene.shore.token(Some(FIRST + 1), Role::Operator).await;
    let other = Scene { token: stranger, ..scene };
    assert_eq!(warnings(&drawn(&other, beyond, Some(FIRST)).await), ["start-unknown"]);
    let scene = Scene { token: other.shore.token(Some(FIRST), Role::Viewer).await, ..other };
    // The vessel's own limits apply, where the server's are not stricter.
    let tell = async |told: &[(&str, &str)]| {
        let one =
            |(name, value): &(&str, &str)| EntityParameter { name: (*name).into(), value: (*value).into() };
        let name = "Grounding Supervisor".into();
        let parameters = EntityParameters { name, params: told.iter().map(one).collect() };
        scene.boats.say(vec![packet(0, 9, clock::now(), parameters)]).await;
        let guard = drawn(&scene, OPEN[0], Some(FIRST)).await;
        (guard["autonomous_m"].as_f64().unwrap(), guard["of_vessel"].as_bool().unwrap())
    };
    // Another program's parameters of the same name, and values that are not numbers, are ignored.
    assert_eq!(tell(&[("Navigable Depth", "1"), ("Autonomous Depth", "9")]).await, (5.0, false));
    let saved = ("Autonomous Depth - Saved", "9");
    assert_eq!(tell(&[saved, ("Navigable Depth", "1"), ("Autonomous Depth", "x")]).await, (5.0, false));
    assert_eq!(tell(&[saved, ("Navigable Depth", "1"), ("Autonomous Depth", "9")]).await, (9.0, true));
    assert_eq!(tell(&[("Autonomous Depth", "2"), ("Water Level", "20")]).await, (5.0, false));
    assert_eq!(tell(&[("Navigable Depth", "20"), ("Autonomous Depth", "99")]).await, (99.0, true));
    let at = |vessel: &str| format!("chart/at?lat_deg={}&lon_deg={}{vessel}", OPEN[0][0], OPEN[0][1]);
    let (status, of_others) = scene.ask("GET", &at("&vessel=2069"), &Value::Null).await;
    assert_eq!(status, StatusCode::FORBIDDEN, "{of_others}");
    for (vessel, autonomous) in [("", true), ("&vessel=2068", false), ("&vessel=0x0814", false)] {
        let (status, near) = scene.ask("GET", &at(vessel), &Value::Null).await;
        assert_eq!((status, &near["depth"]["autonomous"]), (StatusCode::OK, &json!(autonomous)), "{near}");
    }
    let shoal = drawn(&scene, [63.44416, 10.3516], Some(FIRST)).await;
    assert_eq!(shoal["outcome"], "refused", "no tide that a vessel tells makes a shoal deep: {shoal}");
    // On a trailer, on the island.
    let (lat, lon) = (63.4490_f64.to_radians(), 10.3250_f64.to_radians());
    let ashore = EstimatedState { lat, lon, ..EstimatedState::default() };
    scene.boats.say(vec![packet(0, 1, clock::now(), ashore)]).await;
    assert_eq!(warnings(&drawn(&scene, beyond, Some(FIRST)).await), ["start-unknown"]);
}

#[tokio::test]
async fn nobody_is_sent_to_a_place_in_danger_nor_over_one() {
    let scene = Scene::start(archipelago).await;
    let goto = |[lat_deg, lon_deg]: [f64; 2]| json!({"kind": "goto", "lat_deg": lat_deg, "lon_deg": lon_deg, "speed_mps": 1.5});
    // On the shoal; and beyond an island, in deep water.
    for danger in [[63.44416, 10.3516], [63.4500, 10.3250]] {
        is_refused(&scene.order(goto(danger)).await);
    }
    // What the guard cannot lay out is not passed as safe: a vessel with DUNE has no guard of its own.
    let mut too_fast = goto([63.44416, 10.3516]);
    too_fast["speed_mps"] = json!(4.0);
    for (unjudged, said) in [
        (too_fast, "It cannot be checked against the chart and was not sent: "),
        (goto([10.35, 63.44]), "The place is "),
    ] {
        let (status, answer) = scene.order(unjudged).await;
        assert_eq!(status, StatusCode::UNPROCESSABLE_ENTITY, "{answer}");
        let text = answer["error"]["text"].as_str().unwrap();
        assert!(text.starts_with(said), "{text}");
    }
    assert_eq!(scene.order(goto(OPEN[0])).await.0, StatusCode::ACCEPTED);
}

#[tokio::test]
async fn a_start_of_a_plan_that_was_drawn_here_is_refused_over_a_shoal() {
    let scene = Scene::start(archipelago).await;
    let (mut aboard, mut over_a_shoal) = (Vec::new(), PlanSpecification::default());
    for (name, places) in [("shoal", SHOAL), ("open", OPEN)] {
        let (_, plan) = scene.plan(name, places).await;
        let document: PlanDocument = serde_json::from_value(plan).unwrap();
        let specification = plans::specification(&document).unwrap();
        let md5 = imc::plan_digest::plan_md5(&specification).unwrap();
        if name == "shoal" {
            over_a_shoal = specification;
        }
        let plan_id = name.into();
        aboard.push(PlanDBInformation { plan_id, md5: md5.into(), ..PlanDBInformation::default() });
    }
    // A plan that the vessel reported, although none was drawn here under this name.
    let told = PlanSpecification { plan_id: "told".into(), ..over_a_shoal };
    let md5 = imc::plan_digest::plan_md5(&told).unwrap();
    let plan_id = "told".into();
    aboard.push(PlanDBInformation { plan_id, md5: md5.into(), ..PlanDBInformation::default() });
    scene.boats.say(vec![packet(0, 1, clock::now(), told)]).await;
    // A plan that was neither drawn here nor reported is judged by the vessel alone.
    aboard.push(PlanDBInformation { plan_id: "foreign".into(), ..PlanDBInformation::default() });
    let state = PlanDBState { plans_info: aboard.into_iter().collect(), ..PlanDBState::default() };
    let reply = PlanDB {
        r#type: PlanDBType::Success,
        op: PlanDBOp::GetState,
        arg: Some(Message::from(state)).into(),
        ..PlanDB::default()
    };
    scene.boats.say(vec![packet(0, 1, clock::now(), reply)]).await;
    let start = |name: &str| json!({"kind": "plan.start", "plan_id": name});
    for name in ["shoal", "told"] {
        is_refused(&scene.order(start(name)).await);
    }
    for name in ["open", "foreign"] {
        let (status, answer) = scene.order(start(name)).await;
        assert_eq!(status, StatusCode::ACCEPTED, "{name}: {answer}");
        let packet = scene.boats.heard(PlanControl::ID).await;
        let sent: PlanControl = imc::decode(&PacketView::new(&packet).unwrap()).unwrap().unwrap();
        assert_eq!(sent.plan_id.as_str(), Some(name));
    }
}

#[tokio::test]
async fn a_chart_that_cannot_be_read_refuses_every_plan_and_says_why() {
    let scene = Scene::start(|data| {
        std::fs::create_dir_all(data.join("charts")).unwrap();
        std::fs::write(data.join("charts/chart.gpkg"), "no database").unwrap();
    })
    .await;
    let goto = json!({"kind": "goto", "lat_deg": OPEN[0][0], "lon_deg": OPEN[0][1], "speed_mps": 1.5});
    let (status, answer) = scene.order(goto).await;
    assert_eq!((status, &answer["error"]["code"]), (StatusCode::UNPROCESSABLE_ENTITY, &json!("grounding")));
    assert!(answer["error"]["text"].as_str().unwrap().contains("not a chart set of Lutra"), "{answer}");
    assert_eq!(answer["error"]["guard"]["cause"], "chart-unreadable", "{answer}");
}
