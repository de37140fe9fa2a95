//! The chart through the API, with the fictitious archipelago.

use super::tests::{Shore, bearer};
use api::{ChartCorridor, ChartNear, ChartSet, Role, SeaRouteAnswer, SeaRouteCurrentGrid, SeaRouteProgress};
use axum::body::Body;
use axum::http::{Request, StatusCode, header};
use chartdb::{ImportOptions, import};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::task::{Context, Waker};
use units::UtcTime;

/// Brings the archipelago into a folder of data.
pub(super) fn archipelago(data: &Path) {
    let folder = data.join("cells");
    fs::create_dir_all(&folder).unwrap();
    fs::create_dir_all(data.join("charts")).unwrap();
    for file in charts::demo::archipelago().unwrap() {
        fs::write(folder.join(file.name), file.bytes).unwrap();
    }
    let options = ImportOptions::new(UtcTime::from_micros(1_790_000_000_000_000));
    let report = import(&data.join("charts/chart.gpkg"), &[folder], &options, &mut |_| true).unwrap();
    assert!(report.applied);
}

#[tokio::test]
async fn without_a_chart_everything_says_so_and_a_new_one_is_taken_while_running() {
    let shore = Shore::with(|_| ()).await;
    let token = shore.token(Some(7), Role::Viewer).await;
    let answer = shore.get("/api/v1/chart", &token).await;
    let set: ChartSet = serde_json::from_str(&answer.body).unwrap();
    assert_eq!((set.set, set.trouble, set.bounds, set.cells.len()), (None, None, None, 0));
    assert_eq!((set.navigable_m, set.autonomous_m), (1.0, 5.0));
    for path in ["/api/v1/chart/tiles/0/0/0", "/api/v1/chart/at?lat_deg=63&lon_deg=10"] {
        let answer = shore.get(path, &token).await;
        assert_eq!(answer.status, StatusCode::NOT_FOUND, "{path}");
        assert!(answer.body.contains("no_chart"), "{}", answer.body);
    }
    archipelago(shore.data());
    shore.state.shore.charts.look();
    let answer = shore.get("/api/v1/chart", &token).await;
    let set: ChartSet = serde_json::from_str(&answer.body).unwrap();
    assert!(set.set.is_some() && set.not_for_navigation);
    let names: Vec<&str> = set.cells.iter().map(|cell| &*cell.name).collect();
    assert_eq!(names, ["XX4LUTRA", "XX5LUTRA"]);
    assert!(set.cells.iter().all(|cell| cell.whole == Some(true)));
    let bounds = set.bounds.unwrap();
    assert!(bounds.south_deg < 63.446 && 63.446 < bounds.north_deg && bounds.west_deg < 10.345);
    fs::write(shore.data().join("charts/chart.gpkg"), "no database").unwrap();
    shore.state.shore.charts.look();
    let answer = shore.get("/api/v1/chart", &token).await;
    let set: ChartSet = serde_json::from_str(&answer.body).unwrap();
    assert!(set.set.is_none() && set.trouble.unwrap().contains("not a chart set of Lutra"));
    let answer = shore.get("/api/v1/chart/at?lat_deg=63&lon_deg=10", &token).await;
    assert_eq!(answer.status, StatusCode::SERVICE_UNAVAILABLE, "{}", answer.body);
}

#[tokio::test]
async fn depths_and_objects_are_told() {
    let shore = Shore::with(archipelago).await;
    let token = shore.token(Some(7), Role::Viewer).await;
    let answer = shore.get("/api/v1/chart/at?lat_deg=63.446&lon_deg=10.345&within_m=500", &token).await;
    assert_eq!(answer.status, StatusCode::OK, "{}", answer.body);
    let near: ChartNear = serde_json::from_str(&answer.body).unwrap();
    assert_eq!((near.depth.kind.as_str(), near.depth.cell.as_deref()), ("water", Some("XX5LUTRA")));
    assert!(near.depth.autonomous && near.depth.least_m.unwrap() >= 5.0, "{:?}", near.depth);
    let area = near.objects.iter().find(|one| Some(one.id) == near.depth.object).expect("the deciding area");
    assert_eq!((area.class.as_str(), area.words.as_str(), area.distance_m), ("DEPARE", "depth area", 0.0));
    let drval1 = area.attributes.iter().find(|one| one.name == "DRVAL1").unwrap();
    assert_eq!(drval1.text, format!("{} m", drval1.value));
    assert!(near.objects.iter().any(|one| one.geometry == "sounding" && one.depth_m.is_some()));
    assert!(near.objects.iter().all(|one| one.cell == "XX5LUTRA"), "the finer chart hides the coarser");
    let far: ChartNear =
        serde_json::from_str(&shore.get("/api/v1/chart/at?lat_deg=0&lon_deg=0", &token).await.body).unwrap();
    assert_eq!((far.depth.kind.as_str(), far.depth.object, far.objects.len()), ("no-data", None, 0));
    for bad in
        ["lat_deg=91&lon_deg=0", "lat_deg=0&lon_deg=0&within_m=2001", "lat_deg=NaN&lon_deg=0", "lat_deg=0"]
    {
        let answer = shore.get(&format!("/api/v1/chart/at?{bad}"), &token).await;
        assert_eq!(answer.status, StatusCode::BAD_REQUEST, "{bad}: {}", answer.body);
    }
}

async fn corridor(shore: &Shore, token: &str, ask: &Value) -> (StatusCode, String) {
    let request = Request::post("/api/v1/chart/corridor").header(header::CONTENT_TYPE, "application/json");
    let answer = shore.send(bearer(request, token), Body::from(ask.to_string())).await;
    (answer.status, answer.body)
}

#[tokio::test]
async fn a_corridor_tells_its_worst_spots_and_a_profile() {
    let shore = Shore::with(archipelago).await;
    let token = shore.token(Some(7), Role::Viewer).await;
    let ask = json!({"points": [[63.446, 10.345], [63.447, 10.345], [63.446, 11.0]], "half_width_m": 20});
    let (status, body) = corridor(&shore, &token, &ask).await;
    assert_eq!(status, StatusCode::OK, "{body}");
    let told: ChartCorridor = serde_json::from_str(&body).unwrap();
    let [near, far] = told.pieces.as_slice() else { panic!("{body}") };
    assert!((near.length_m - 111.46).abs() < 0.1 && (far.from_m - near.length_m).abs() < 1e-9);
    assert!(near.worst.autonomous && near.worst.navigable);
    // Land, or beyond the chart: neither is navigable.
    assert!(!far.worst.autonomous && far.along_m >= far.from_m && far.along_m <= told.length_m);
    let profile = &told.profile;
    assert!(profile.windows(2).all(|pair| pair[0].along_m <= pair[1].along_m));
    assert!(profile[0].along_m.abs() < 1e-9);
    assert!((profile.last().unwrap().along_m - told.length_m).abs() < 1e-6);
    assert_eq!((profile.last().unwrap().kind.as_str(), profile.last().unwrap().depth_m), ("no-data", None));
    assert!(profile[0].depth_m.is_some() && (400..600).contains(&profile.len()), "{}", profile.len());
    for (bad, why) in [
        (json!({"points": [[63.4, 10.3]], "half_width_m": 1}), "points"),
        (
            json!({"points": [[63.4, 10.3], [95, 10.3]], "half_width_m": 1}),
            "points[1]: 95, 10.3 is not a place",
        ),
        (json!({"points": [[63.4, 10.3], [63.5, 10.3]], "half_width_m": -1}), "half_width_m"),
        (json!({"points": [[-80, 10.3], [63.5, 100]], "half_width_m": 1}), "longer than"),
    ] {
        let (status, body) = corridor(&shore, &token, &bad).await;
        assert_eq!(status, StatusCode::BAD_REQUEST, "{bad}");
        assert!(body.contains(why), "{body}");
    }
}

async fn route(shore: &Shore, token: &str, ask: &Value) -> (StatusCode, String) {
    let request = Request::post("/api/v1/chart/route").header(header::CONTENT_TYPE, "application/json");
    let answer = shore.send(bearer(request, token), Body::from(ask.to_string())).await;
    (answer.status, answer.body)
}

#[tokio::test]
async fn a_route_leads_around_an_island_and_the_guard_takes_it() {
    let shore = Shore::with(archipelago).await;
    let token = shore.token(Some(7), Role::Viewer).await;
    let (east, west) = ([63.4455, 10.352], [63.4455, 10.314]);
    let (status, body) = route(&shore, &token, &json!({"points": [east, west]})).await;
    assert_eq!(status, StatusCode::OK, "{body}");
    let answer: SeaRouteAnswer = serde_json::from_str(&body).unwrap();
    let found = answer.route.expect("a route");
    assert!((2_500.0..3_200.0).contains(&found.length_m), "{}", found.length_m);
    assert!(found.guarded && found.guard.is_none(), "{:?}", found.guard);
    assert_eq!((answer.asked_depth_m, found.points.len()), (5.0, found.legs.len() + 1));
    assert!(found.least_depth_m.unwrap() >= 5.0 && found.least_clearance_m.unwrap() >= 11.2);
    assert!((found.duration_s.unwrap() - found.length_m / 1.5).abs() < 1e-6);
    // As the Otters' path monitor is set there is no room in the narrows; with a strict one there is.
    let narrow = found.narrow.expect("there are 11.2 m alone");
    let near = found.legs[narrow.leg].clearance_m.unwrap();
    assert!((narrow.needed_m - 29.2).abs() < 1e-9 && (near - narrow.least_m).abs() < 1e-9 && near < 29.2);
    assert_eq!(found.least_clearance_m, Some(narrow.least_m));
    let strict = json!({"points": [east, west], "stray_m": 4});
    let strict: SeaRouteAnswer = serde_json::from_str(&route(&shore, &token, &strict).await.1).unwrap();
    assert!(strict.route.unwrap().narrow.is_none());
    let (status, body) = route(&shore, &token, &json!({"points": [east, west], "stray_m": -1})).await;
    assert!(
        status == StatusCode::BAD_REQUEST && body.contains("stray_m: -1 is not within 0 to 500 m"),
        "{body}"
    );
    // Through a distant place it is longer; less depth than the guard demands is accepted with a warning.
    let by = json!({"points": [east, [63.4552, 10.3600], west]});
    let by: SeaRouteAnswer = serde_json::from_str(&route(&shore, &token, &by).await.1).unwrap();
    assert!(by.route.unwrap().length_m > found.length_m + 500.0);
    let shoal = json!({"points": [east, west], "least_depth_m": 0.5, "clearance_m": 2});
    let shoal: SeaRouteAnswer = serde_json::from_str(&route(&shore, &token, &shoal).await.1).unwrap();
    let shoal = shoal.route.unwrap();
    assert!(shoal.length_m < found.length_m && !shoal.guarded);
    let guard = shoal.guard.unwrap();
    assert!(guard.code.starts_with("too-shallow") && (guard.number as usize) < shoal.legs.len(), "{guard:?}");
}

#[tokio::test]
async fn a_question_says_how_far_it_has_come_and_ends_when_its_client_goes() {
    let shore = Shore::with(archipelago).await;
    let token = shore.token(Some(7), Role::Viewer).await;
    let set = shore.state.shore.charts.set().unwrap();
    let progress = async |name: &str| shore.get(&format!("/api/v1/chart/route/{name}"), &token).await;
    assert_eq!(progress("question-0").await.status, StatusCode::NOT_FOUND);
    let mut called_off = 0;
    // Each needs water of its own, which takes a tenth of a second and is kept once it is prepared. On a busy computer it may
    // be ready before the client has gone: not five times.
    for number in 1..=5 {
        let (name, kept) = (format!("question-{number}"), set.router.kept().0);
        let ask = json!({"points": [[63.4455, 10.352], [63.4455, 10.314]], "clearance_m": 100 + number, "progress": name});
        let mut asked = Box::pin(route(&shore, &token, &ask));
        let told = loop {
            // A request gets as far as its planner by several steps.
            let polled = asked.as_mut().poll(&mut Context::from_waker(Waker::noop()));
            assert!(polled.is_pending(), "it is answered already");
            let answer = progress(&name).await;
            let told = serde_json::from_str::<SeaRouteProgress>(&answer.body);
            match told {
                Ok(told) if !told.waiting => break told,
                _ => tokio::task::yield_now().await,
            }
        };
        drop(asked);
        assert_eq!((told.tiles, told.most_s as u32), (0, 90));
        while progress(&name).await.status == StatusCode::OK {
            tokio::task::yield_now().await;
        }
        called_off += usize::from(set.router.kept().0 == kept);
    }
    assert!(called_off > 0, "planning goes on for clients that have gone");
    let bad = json!({"points": [[63.4455, 10.352], [63.4455, 10.314]], "progress": "a b"});
    let (status, body) = route(&shore, &token, &bad).await;
    assert!(status == StatusCode::BAD_REQUEST && body.contains("progress: give a name"), "{body}");
}

#[tokio::test]
async fn a_route_says_which_traffic_it_meets_unless_that_is_not_minded() {
    let shore = Shore::with(|data| {
        archipelago(data);
        // All of the detailed chart becomes a lane to the west. What keeps the boxes of areas in step needs functions that
        // SQLite by itself does not have, and the boxes stay as they are.
        let db = rusqlite::Connection::open(data.join("charts/chart.gpkg")).unwrap();
        let mut triggers = db
            .prepare("SELECT name FROM sqlite_master WHERE type = 'trigger' AND tbl_name = 'areas' AND sql LIKE '%ST_%'")
            .unwrap();
        let names: Vec<String> =
            triggers.query_map([], |row| row.get(0)).unwrap().collect::<Result<_, _>>().unwrap();
        for name in names {
            db.execute(&format!("DROP TRIGGER {name}"), []).unwrap();
        }
        let lane = "UPDATE areas SET class = 'TSSLPT', class_code = 148, attributes = '{\"ORIENT\":\"270\"}' \
                    WHERE class = 'M_QUAL' AND source = (SELECT id FROM cells WHERE name = 'XX5LUTRA')";
        assert!(db.execute(lane, []).unwrap() > 0);
    })
    .await;
    let token = shore.token(Some(7), Role::Viewer).await;
    let found = async |ask: Value| {
        let (status, body) = route(&shore, &token, &ask).await;
        assert_eq!(status, StatusCode::OK, "{body}");
        serde_json::from_str::<SeaRouteAnswer>(&body).unwrap().route.unwrap()
    };
    let (east, west) = ([63.4455, 10.352], [63.4455, 10.314]);
    let with = found(json!({"points": [east, west]})).await;
    let met = |route: &api::SeaRoute, against: bool| {
        let traffic = route.legs.iter().filter_map(|leg| leg.traffic.as_ref());
        traffic.filter(|one| one.kind == "lane" && one.against == against).count()
    };
    assert!(met(&with, false) > 0 && met(&with, true) == 0, "{:?}", with.legs);
    // The other way round it goes against the lane, or farther so as not to.
    let back = found(json!({"points": [west, east]})).await;
    assert!(
        met(&back, true) > 0 || back.length_m > with.length_m + 10.0,
        "{} {}",
        back.length_m,
        with.length_m
    );
    let careless = found(json!({"points": [east, west], "traffic_factor": 1})).await;
    assert!(careless.legs.iter().all(|leg| leg.traffic.is_none()));
    let bad = json!({"points": [east, west], "traffic_factor": 0.5});
    let (status, body) = route(&shore, &token, &bad).await;
    assert!(status == StatusCode::BAD_REQUEST && body.contains("factor of traffic"), "{body}");
}

#[tokio::test]
async fn after_a_change_of_the_chart_the_water_that_was_asked_for_is_prepared_again() {
    let shore = Shore::with(archipelago).await;
    let token = shore.token(Some(7), Role::Viewer).await;
    let set = || shore.state.shore.charts.set().unwrap();
    let ask = |clearance_m: f64| json!({"points": [[63.4455, 10.352], [63.4455, 10.314]], "clearance_m": clearance_m});
    for clearance_m in [20.0, 30.0] {
        assert_eq!(route(&shore, &token, &ask(clearance_m)).await.0, StatusCode::OK);
    }
    let before = set();
    let asked = before.router.prepared();
    assert_eq!(asked.len(), 2);
    let (db, other) = (shore.data().join("charts/chart.gpkg"), shore.data().join("charts/other.gpkg"));
    fs::copy(&db, &other).unwrap();
    chartdb::remove(&other, &["XX4LUTRA".to_owned()], UtcTime::from_micros(0)).unwrap();
    fs::rename(&other, &db).unwrap();
    let (routing, charts) = (shore.state.shore.routing.clone(), shore.state.shore.charts.clone());
    tokio::spawn(routing.keep_prepared(charts, shore.state.shore.stop.clone()));
    shore.state.shore.charts.look();
    assert_ne!(set().digest, before.digest);
    // No route is asked for meanwhile. What is ready beforehand goes first where there is too much.
    while set().router.kept().0 < 2 {
        tokio::task::yield_now().await;
    }
    let again = set().router.prepared();
    assert!(asked.iter().all(|one| again.contains(one)) && again.len() == 2, "{again:?}");
}

#[tokio::test]
async fn a_route_for_a_turning_radius_says_which_turns_leave_the_water() {
    let shore = Shore::with(archipelago).await;
    let token = shore.token(Some(7), Role::Viewer).await;
    let (east, west) = ([63.4455, 10.352], [63.4455, 10.314]);
    let ask = json!({"points": [east, west, east], "turn_radius_m": 12});
    let (status, body) = route(&shore, &token, &ask).await;
    assert_eq!(status, StatusCode::OK, "{body}");
    let answer: SeaRouteAnswer = serde_json::from_str(&body).unwrap();
    let found = answer.route.expect("a route");
    assert!(found.guarded, "{:?}", found.guard);
    let texts: Vec<&String> = found.legs.iter().filter_map(|leg| leg.turn_text.as_ref()).collect();
    // It doubles back at the place in the west.
    assert!(texts.iter().any(|text| text.starts_with("The legs are too short for a turn")), "{texts:?}");
    assert!(texts.len() < found.legs.len() / 2, "{texts:?}");
    let bad = json!({"points": [east, west], "turn_radius_m": -1});
    let (status, body) = route(&shore, &token, &bad).await;
    assert!(status == StatusCode::BAD_REQUEST && body.contains("turning radius"), "{body}");
}

#[tokio::test]
async fn a_route_keeps_out_of_areas_and_says_when_they_are_in_the_way() {
    let shore = Shore::with(archipelago).await;
    let token = shore.token(Some(7), Role::Viewer).await;
    let (east, west) = ([63.4455, 10.352], [63.4455, 10.314]);
    let ask = |zones: Value| json!({"points": [east, west], "zones": zones, "explain": true});
    let plain: SeaRouteAnswer =
        serde_json::from_str(&route(&shore, &token, &ask(json!([]))).await.1).unwrap();
    let plain = plain.route.unwrap();
    let [lat, lon] = plain.points[plain.points.len() / 2];
    let around = |lat: f64, lon: f64, by: f64| {
        json!([
            [lat - by, lon - 2.0 * by],
            [lat - by, lon + 2.0 * by],
            [lat + by, lon + 2.0 * by],
            [lat + by, lon - 2.0 * by]
        ])
    };
    let avoid = ask(json!([{"kind": "avoid", "corners": around(lat, lon, 0.0008)}]));
    let (status, body) = route(&shore, &token, &avoid).await;
    assert_eq!(status, StatusCode::OK, "{body}");
    let avoided = serde_json::from_str::<SeaRouteAnswer>(&body).unwrap().route.unwrap();
    assert!(avoided.length_m > plain.length_m + 10.0, "{} {}", avoided.length_m, plain.length_m);
    let inside = |[a, b]: [f64; 2]| (a - lat).abs() < 0.0008 && (b - lon).abs() < 0.0016;
    assert!(!avoided.points.iter().any(|point| inside(*point)), "{:?}", avoided.points);
    // Only the area blocks the way across the chart; a route cannot begin or end outside of an allowed area.
    let wall = json!([[63.2, 10.332], [63.2, 10.334], [63.7, 10.334], [63.7, 10.332]]);
    let wall = ask(json!([{"kind": "avoid", "corners": wall}]));
    let answer: SeaRouteAnswer = serde_json::from_str(&route(&shore, &token, &wall).await.1).unwrap();
    let refusal = answer.refusal.unwrap();
    assert!(
        refusal.passable.unwrap().by_zones_alone && refusal.text.contains("areas to avoid"),
        "{}",
        refusal.text
    );
    let within = ask(json!([{"kind": "within", "corners": around(63.4455, 10.352, 0.002)}]));
    let answer: SeaRouteAnswer = serde_json::from_str(&route(&shore, &token, &within).await.1).unwrap();
    let refusal = answer.refusal.unwrap();
    assert_eq!((&*refusal.code, &*refusal.closed.unwrap().code), ("closed_goal", "zone"));
    for (bad, why) in [
        (json!([{"kind": "avoid", "corners": [[63.4, 10.3], [63.5, 10.3]]}]), "zones[0]: it has 2 corners"),
        (
            json!([{"kind": "avoid", "corners": [[63.4, 10.3], [93.5, 10.3], [63.4, 10.4]]}]),
            "93.5, 10.3 is not a place",
        ),
        (
            json!([{"kind": "avoid", "corners": [[63.4, 10.3], [63.5, 10.4], [63.5, 10.3], [63.4, 10.4]]}]),
            "cross or touch near 63.45",
        ),
        (json!([{"kind": "around", "corners": []}]), "around"),
    ] {
        let (status, body) = route(&shore, &token, &ask(bad)).await;
        assert!(status.is_client_error() && body.contains(why), "{body}");
    }
}

#[tokio::test]
async fn a_current_changes_time_and_energy_and_one_that_is_too_strong_leaves_them_out() {
    let shore = Shore::with(archipelago).await;
    let token = shore.token(Some(7), Role::Viewer).await;
    let ask = |drift_mps: f64| json!({"points": [[63.4455, 10.352], [63.4455, 10.314]], "current": {"set_deg": 270, "drift_mps": drift_mps}});
    let mut found = Vec::new();
    for drift_mps in [0.0, 0.5, 2.0] {
        let (status, body) = route(&shore, &token, &ask(drift_mps)).await;
        assert_eq!(status, StatusCode::OK, "{body}");
        found.push(serde_json::from_str::<SeaRouteAnswer>(&body).unwrap().route.unwrap());
    }
    let [still, with, strong] = &found[..] else { panic!("three") };
    assert!(with.duration_s.unwrap() < 0.85 * still.duration_s.unwrap());
    assert!(with.energy_wh.unwrap() < 0.85 * still.energy_wh.unwrap());
    let legs_s: f64 = with.legs.iter().map(|leg| leg.duration_s.unwrap()).sum();
    assert!((legs_s - with.duration_s.unwrap()).abs() < 1e-6);
    // Some legs lead across a current that is faster than the vessel.
    assert!(strong.duration_s.is_none() && strong.energy_wh.is_none());
    assert!((strong.length_m - still.length_m).abs() < 1e-6);
    let (status, body) = route(&shore, &token, &ask(-1.0)).await;
    assert!(status == StatusCode::BAD_REQUEST && body.contains("current"), "{body}");
}

/// Between the two ends a current to the east, which is strong in the south.
fn stream() -> Value {
    let (lats, lons): (Vec<f64>, Vec<f64>) =
        ((0..9).map(|n| 63.43 + 0.004 * f64::from(n)).collect(), vec![10.29, 10.37]);
    let east: Vec<f64> = lats.iter().flat_map(|lat| [if *lat < 63.445 { 1.2 } else { 0.1 }; 2]).collect();
    let north = vec![0.0; east.len()];
    json!({"times_us": [0], "lats_deg": lats, "lons_deg": lons, "east_mps": east, "north_mps": north})
}

#[tokio::test]
async fn a_file_of_currents_becomes_the_grid_that_a_route_is_asked_for_in() {
    let shore = Shore::with(archipelago).await;
    let token = shore.token(Some(7), Role::Viewer).await;
    let send = async |file: Vec<u8>| {
        let request =
            Request::post("/api/v1/chart/currents").header(header::CONTENT_TYPE, "application/octet-stream");
        let answer = shore.send(bearer(request, &token), Body::from(file)).await;
        (answer.status, answer.body)
    };
    let seed = |name: &str| {
        fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/seeds/geofile").join(name)).unwrap()
    };
    let (status, body) = send(seed("currents.csv")).await;
    assert_eq!(status, StatusCode::OK, "{body}");
    let csv: SeaRouteCurrentGrid = serde_json::from_str(&body).unwrap();
    assert_eq!((csv.lats_deg, csv.lons_deg), (vec![63.0, 63.1], vec![10.0, 10.2]));
    assert_eq!(csv.times_us, [1_795_240_800_000_000, 1_795_244_400_000_000]);
    assert_eq!(csv.east_mps[3..5], [None, Some(0.5)]);
    // NetCDF-3 of a wide water, in which a route is asked for.
    let (status, body) = send(seed("currents.nc")).await;
    assert_eq!(status, StatusCode::OK, "{body}");
    let mut ask = json!({"points": [[63.4455, 10.352], [63.4455, 10.314]], "objective": "fastest"});
    ask["current_grid"] = serde_json::from_str(&body).unwrap();
    let (status, body) = route(&shore, &token, &ask).await;
    assert_eq!(status, StatusCode::OK, "{body}");
    for (bad, why) in [
        (b"time,lat,lon,u,v".to_vec(), "Line 1: there is no column east_mps"),
        (b"CDF\x01".to_vec(), "NetCDF: "),
        (vec![0xff, 0xfe], "neither NetCDF nor text"),
    ] {
        let (status, body) = send(bad).await;
        assert!(status == StatusCode::BAD_REQUEST && body.contains(why), "{status} {body}");
    }
    let (status, body) = send(vec![b'x'; (8 << 20) + 1]).await;
    assert!(status == StatusCode::PAYLOAD_TOO_LARGE && body.contains("larger than 8 MB"), "{status} {body}");
}

#[tokio::test]
async fn a_route_by_an_objective_stands_beside_the_shortest_and_costs_no_more() {
    let shore = Shore::with(archipelago).await;
    let token = shore.token(Some(7), Role::Viewer).await;
    let ask = |more: Value| {
        let mut ask = json!({"points": [[63.4455, 10.352], [63.4455, 10.314]]});
        ask.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        ask
    };
    let found = |body: String| serde_json::from_str::<SeaRouteAnswer>(&body).unwrap();
    let plain = found(route(&shore, &token, &ask(json!({}))).await.1);
    let (shortest, none) = (plain.route.unwrap(), plain.shortest);
    assert!(none.is_none() && (shortest.speed_mps - 1.5).abs() < 1e-9 && shortest.current_unknown_m < 1e-9);
    // The least energy goes slower, by the model's curve.
    let thrifty =
        found(route(&shore, &token, &ask(json!({"objective": "least_energy"}))).await.1).route.unwrap();
    assert!((0.45..1.0).contains(&thrifty.speed_mps), "{}", thrifty.speed_mps);
    assert!(thrifty.energy_wh.unwrap() < 0.6 * shortest.energy_wh.unwrap());
    assert!((thrifty.duration_s.unwrap() - thrifty.length_m / thrifty.speed_mps).abs() < 1.0);
    // Against a stream that is strong in the south the fastest way keeps north.
    let fastest = ask(json!({"objective": "fastest", "current_grid": stream()}));
    let fastest = found(route(&shore, &token, &fastest).await.1);
    let (best, direct) = (fastest.route.unwrap(), fastest.shortest.expect("another one than the shortest"));
    assert!(best.guarded && best.length_m > direct.length_m);
    match (best.duration_s, direct.duration_s) {
        (Some(best_s), direct_s) => assert!(direct_s.is_none_or(|direct_s| best_s < direct_s)),
        (None, direct_s) => panic!("{direct_s:?}"),
    }
    // Deeper water, and distance.
    let deeper = ask(json!({"prefer_depth_m": 20, "prefer_off_m": 60, "prefer_factor": 10}));
    let deeper = found(route(&shore, &token, &deeper).await.1);
    assert!(deeper.route.unwrap().length_m > deeper.shortest.expect("the shortest too").length_m);
    // Beyond the grid nothing is known, and so no time.
    let mut far = stream();
    far["lons_deg"] = json!([11.0, 11.1]);
    let unknown = found(route(&shore, &token, &ask(json!({"current_grid": far}))).await.1).route.unwrap();
    assert!(unknown.duration_s.is_none() && unknown.energy_wh.is_none());
    assert!((unknown.current_unknown_m - unknown.length_m).abs() < 1e-6);
    // A speed limit counts for the time.
    let all = json!([[63.4, 10.2], [63.5, 10.2], [63.5, 10.5], [63.4, 10.5]]);
    let slow = ask(json!({"zones": [{"kind": "limit", "corners": all, "most_mps": 1.0}]}));
    let slow = found(route(&shore, &token, &slow).await.1).route.unwrap();
    assert!(
        (slow.duration_s.unwrap() - slow.length_m).abs() < 1.0
            && (slow.length_m - shortest.length_m).abs() < 1e-6
    );
    assert!(slow.legs.iter().all(|leg| leg.limit_mps == Some(1.0)), "each leg says the limit");
    assert!(shortest.legs.iter().all(|leg| leg.limit_mps.is_none()) && !shortest.current_too_strong);
    let mut wrong = stream();
    wrong["east_mps"] = json!([0.1]);
    for (bad, why) in [
        (json!({"objective": "cheapest"}), "cheapest"),
        (json!({"prefer_depth_m": -1}), "preferred depth"),
        (json!({"prefer_off_m": 501}), "prefer_off_m: 501 is more than 500 m"),
        (
            json!({"zones": vec![json!({"kind": "limit", "corners": [[63.4, 10.2]], "most_mps": 1}); 51]}),
            "there are 51",
        ),
        (json!({"prefer_factor": 0.5}), "factor of preferences"),
        (json!({"current_grid": wrong}), "current_grid: to the east: there are 1 values"),
        (json!({"current_grid": stream(), "current": {"set_deg": 0, "drift_mps": 1}}), "not both"),
        (json!({"zones": [{"kind": "limit", "corners": all}]}), "zones[0]: most_mps is missing"),
        (
            json!({"zones": [{"kind": "avoid", "corners": all, "most_mps": 1}]}),
            "zones[0]: most_mps belongs to areas",
        ),
    ] {
        let (status, body) = route(&shore, &token, &ask(bad)).await;
        assert!(status.is_client_error() && body.contains(why), "{status} {body}");
    }
}

#[tokio::test]
async fn that_there_is_no_route_is_an_answer_and_nonsense_is_refused_by_name() {
    let shore = Shore::with(archipelago).await;
    let token = shore.token(Some(7), Role::Viewer).await;
    // A goal on land is moved to the water beside it.
    let ask = json!({"points": [[63.4455, 10.352], [63.45, 10.322]]});
    let answer: SeaRouteAnswer = serde_json::from_str(&route(&shore, &token, &ask).await.1).unwrap();
    let moved = answer.route.unwrap().moved;
    assert_eq!(moved.iter().map(|one| one.end.as_str()).collect::<Vec<_>>(), ["goal"]);
    let far = json!({"points": [[63.4455, 10.352], [60.0, 5.0]]});
    let answer: SeaRouteAnswer = serde_json::from_str(&route(&shore, &token, &far).await.1).unwrap();
    let refusal = answer.refusal.unwrap();
    let closed = refusal.closed.unwrap();
    assert_eq!((&*refusal.code, &*closed.code, closed.depth_m), ("closed_goal", "no-data", None));
    // Too narrow: the proposed clearance is really sufficient.
    let wide = |clearance_m: f64| json!({"points": [[63.4455, 10.352], [63.4455, 10.314]], "clearance_m": clearance_m, "explain": true});
    let answer: SeaRouteAnswer = serde_json::from_str(&route(&shore, &token, &wide(190.0)).await.1).unwrap();
    let refusal = answer.refusal.unwrap();
    assert_eq!(refusal.code, "no_way");
    assert!(
        refusal.gap_m.unwrap() > 1_000.0 && refusal.text.contains("There is one with"),
        "{}",
        refusal.text
    );
    let passable = refusal.passable.unwrap();
    assert!(!passable.by_rule_alone);
    let passable_m = passable.clearance_m.unwrap();
    assert!((120.0..190.0).contains(&passable_m), "{passable_m}");
    let answer: SeaRouteAnswer =
        serde_json::from_str(&route(&shore, &token, &wide(passable_m)).await.1).unwrap();
    assert!(answer.route.unwrap().least_clearance_m.unwrap() >= passable_m);
    for (bad, why) in [
        (json!({"points": [[63.4, 10.3]]}), "points"),
        (json!({"points": [[63.4, 10.3], [63.4, 10.4], [95, 10.3]]}), "points[2]: 95, 10.3 is not a place"),
        (json!({"points": [[63.4, 181], [63.4, 10.4]]}), "points[0]: 63.4, 181 is not a place"),
        (json!({"points": [[63.4, 10.3], [63.5, 10.3]], "clearance_m": -1}), "clearance"),
        (json!({"points": [[63.4, 10.3], [63.5, 10.3]], "least_depth_m": 1e9}), "least depth"),
        (json!({"points": [[63.4, 10.3], [63.5, 10.3]], "speed_mps": 0}), "speed_mps"),
    ] {
        let (status, body) = route(&shore, &token, &bad).await;
        assert_eq!(status, StatusCode::BAD_REQUEST, "{bad}");
        assert!(body.contains(why), "{body}");
    }
    let bare = Shore::with(|_| ()).await;
    let token = bare.token(Some(7), Role::Viewer).await;
    let (status, body) = route(&bare, &token, &ask).await;
    assert_eq!(status, StatusCode::NOT_FOUND, "{body}");
}

#[tokio::test]
async fn tiles_are_kept_by_their_set_and_hostile_ones_refused() {
    let shore = Shore::with(archipelago).await;
    let token = shore.token(Some(7), Role::Viewer).await;
    let set = shore.state.shore.charts.set().unwrap().digest.clone();
    // Zoom 13 at 63.446° N, 10.345° E.
    let path = "/api/v1/chart/tiles/13/4331/2213";
    let plain = shore.get(path, &token).await;
    assert_eq!(plain.status, StatusCode::OK, "{}", plain.body);
    assert_eq!(plain.headers[header::CONTENT_TYPE], "application/vnd.mapbox-vector-tile");
    assert_eq!(plain.headers[header::CACHE_CONTROL], "private, no-cache");
    assert!(plain.headers.get(header::CONTENT_ENCODING).is_none());
    assert!(plain.bytes.windows(6).any(|bytes| bytes == b"DEPARE"));
    let kept = format!("{path}?set={set}");
    let request = |tag: Option<&str>| {
        let request = bearer(Request::get(&kept), &token).header(header::ACCEPT_ENCODING, "gzip, br");
        match tag {
            Some(tag) => request.header(header::IF_NONE_MATCH, tag),
            None => request,
        }
    };
    let packed = shore.send(request(None), Body::empty()).await;
    assert_eq!(packed.headers[header::CONTENT_ENCODING], "gzip");
    assert!(packed.headers[header::CACHE_CONTROL].to_str().unwrap().ends_with("immutable"));
    assert!(packed.bytes.len() < plain.bytes.len());
    let tag = packed.headers[header::ETAG].to_str().unwrap();
    let again = shore.send(request(Some(tag)), Body::empty()).await;
    assert_eq!((again.status, again.bytes.len()), (StatusCode::NOT_MODIFIED, 0));
    let other = shore.get(&format!("{path}?set=0"), &token).await;
    assert_eq!(other.status, StatusCode::GONE);
    for hostile in ["19/0/0", "3/8/0", "3/0/8", "18/4294967295/0"] {
        let answer = shore.get(&format!("/api/v1/chart/tiles/{hostile}"), &token).await;
        assert_eq!(answer.status, StatusCode::NOT_FOUND, "{hostile}: {}", answer.body);
    }
    for hostile in ["300/0/0", "-1/0/0", "1/0/0.5", "x/y/z", "5/4294967296/0"] {
        let answer = shore.get(&format!("/api/v1/chart/tiles/{hostile}"), &token).await;
        assert_eq!(answer.status, StatusCode::BAD_REQUEST, "{hostile}: {}", answer.body);
    }
}
