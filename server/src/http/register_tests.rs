//! The register: permissions, import and export, and its use in files of detections.

use super::history_tests::put;
use super::testing::FIRST;
use super::tests::{Answer, Shore, bearer};
use api::{RegisterAnswer, RegisterEntry, RegisterImport, Role};
use axum::body::Body;
use axum::http::{Request, StatusCode, header};
use imc::messages::TBRFishTag;
use serde_json::{Value, json};

/// 2026-11-21 08:00 UTC.
const START_US: i64 = 1_795_248_000_000_000;
const OTHER: u16 = FIRST + 1;

async fn say(shore: &Shore, method: &str, path: &str, token: &str, body: Value) -> Answer {
    let request = bearer(Request::builder().method(method).uri(format!("/api/v1/register{path}")), token);
    shore.send(request.header("content-type", "application/json"), Body::from(body.to_string())).await
}

async fn upload(shore: &Shore, query: &str, token: &str, text: &str) -> Answer {
    let path = format!("/api/v1/register/import?{query}");
    let request = bearer(Request::builder().method("POST").uri(path), token);
    shore.send(request.header("content-type", "text/csv"), Body::from(text.to_owned())).await
}

async fn added(shore: &Shore, token: &str, record: Value) -> RegisterEntry {
    let answer = say(shore, "POST", "", token, record).await;
    assert_eq!(answer.status, StatusCode::OK, "{}", answer.body);
    serde_json::from_str(&answer.body).unwrap()
}

async fn listed(shore: &Shore, token: &str, query: &str) -> RegisterAnswer {
    let answer = shore.get(&format!("/api/v1/register{query}"), token).await;
    assert_eq!(answer.status, StatusCode::OK, "{}", answer.body);
    serde_json::from_str(&answer.body).unwrap()
}

fn tag() -> Value {
    json!({"kind": "tag", "protocol": "S256", "tag_id": 101, "animal": "Salmon 12", "sensor_slope": 0.2, "sensor_unit": "m"})
}

#[tokio::test]
async fn researchers_of_all_vessels_keep_the_register_and_those_of_one_its_deployments() {
    let shore = Shore::with(|_| ()).await;
    let all = shore.token(None, Role::Researcher).await;
    let own = shore.token(Some(FIRST), Role::Researcher).await;
    let viewer = shore.token(Some(OTHER), Role::Viewer).await;
    let animal =
        json!({"kind": "animal", "name": "Salmon 12", "scientific_name": "Salmo salar", "aphia_id": 127_186});
    assert_eq!(say(&shore, "POST", "", &own, animal.clone()).await.status, StatusCode::FORBIDDEN);
    assert_eq!(say(&shore, "POST", "", &viewer, animal.clone()).await.status, StatusCode::FORBIDDEN);
    let animal = added(&shore, &all, animal).await;
    let code = added(&shore, &all, tag()).await;
    added(&shore, &all, json!({"kind": "receiver", "serial": 1_024, "model": "TBR700"})).await;
    let deployed = |vessel: u16| json!({"kind": "deployment", "receiver": "TBR700-1024", "vessel": vessel, "from_us": START_US});
    assert_eq!(say(&shore, "POST", "", &own, deployed(OTHER)).await.status, StatusCode::FORBIDDEN);
    let deployment = added(&shore, &own, deployed(FIRST)).await;
    assert!(deployment.may_change);

    let seen = listed(&shore, &own, "").await;
    assert_eq!(seen.entries.iter().filter(|entry| entry.may_change).count(), 1);
    assert_eq!((seen.version, seen.entries.len()), (4, 4));
    assert_eq!(listed(&shore, &viewer, "").await.entries.len(), 3, "deployments of vessels that one may see");
    assert_eq!(listed(&shore, &viewer, "?kind=tag").await.entries[0].record, code.record);
    assert_eq!(shore.get("/api/v1/register?kind=fish", &viewer).await.status, StatusCode::BAD_REQUEST);

    // Another vessel's deployment is not revealed, and no user can move one to a vessel on which they have no role.
    let at = format!("/{}", deployment.id);
    let change = |revision: u32, record: Value| json!({"revision": revision, "record": record});
    let hidden = shore.token(Some(OTHER), Role::Researcher).await;
    assert_eq!(
        say(&shore, "PUT", &at, &hidden, change(1, deployed(OTHER))).await.status,
        StatusCode::NOT_FOUND
    );
    assert_eq!(say(&shore, "PUT", &at, &own, change(1, deployed(OTHER))).await.status, StatusCode::FORBIDDEN);
    let name = "TBR700-1024 2026-11-21";
    for lines in [
        format!("receiver,vessel,from_time,notes\nTBR700-1024,{OTHER},2026-11-21T08:00Z,mine\n"),
        format!("name,receiver,vessel,from_time\nx,TBR700-1024,{OTHER},2026-12-01\n"),
    ] {
        let answer = upload(&shore, "kind=deployment", &hidden, &lines).await;
        let told: RegisterImport = serde_json::from_str(&answer.body).unwrap();
        assert!((told.added, told.changed, told.same) == (1, 0, 0), "{}", answer.body);
        assert!(
            answer.body.contains("the receiver is deployed elsewhere at the same time"),
            "{}",
            answer.body
        );
        assert!(lines.contains("mine") || !answer.body.contains(name), "{}", answer.body);
        assert!(told.changes[0].fields.iter().all(|field| field.before.is_empty()), "{}", answer.body);
    }
    let beside = json!({"kind": "deployment", "name": "x", "receiver": "TBR700-1024", "vessel": OTHER, "from_us": START_US + 1});
    let beside = say(&shore, "POST", "", &hidden, beside).await;
    assert_eq!(beside.status, StatusCode::UNPROCESSABLE_ENTITY);
    assert!(beside.body.contains("deployed elsewhere") && !beside.body.contains(name), "{}", beside.body);
    let at = format!("/{}", animal.id);
    let longer = json!({"kind": "animal", "name": "Salmon 12", "length_mm": 512.0});
    assert_eq!(say(&shore, "PUT", &at, &own, change(1, longer.clone())).await.status, StatusCode::FORBIDDEN);
    assert_eq!(say(&shore, "PUT", &at, &all, change(1, longer.clone())).await.status, StatusCode::OK);
    assert_eq!(say(&shore, "PUT", &at, &all, change(1, longer)).await.status, StatusCode::CONFLICT);
    let other = say(&shore, "PUT", &at, &all, change(2, json!({"kind": "person", "name": "Kari"}))).await;
    assert!(
        other.status == StatusCode::BAD_REQUEST && other.body.contains("of the kind animal"),
        "{}",
        other.body
    );
    let named = say(&shore, "DELETE", &format!("{at}?revision=2"), &all, json!({})).await;
    assert_eq!(named.status, StatusCode::UNPROCESSABLE_ENTITY);
    assert!(named.body.contains("tag `S256-101`: no animal is called"), "{}", named.body);
    let code = format!("/{}?revision=1", code.id);
    assert_eq!(say(&shore, "DELETE", &code, &own, json!({})).await.status, StatusCode::FORBIDDEN);
    assert_eq!(say(&shore, "DELETE", &code, &all, json!({})).await.status, StatusCode::OK);
    assert_eq!(
        say(&shore, "DELETE", &format!("{at}?revision=2"), &all, json!({})).await.status,
        StatusCode::OK
    );

    let audit = shore.audit().await;
    let of = |action: &str| audit.iter().filter(|entry| entry.action == action).collect::<Vec<_>>();
    assert_eq!((of("register.create").len(), of("register.delete").len()), (5, 3), "refused ones too");
    assert!(of("register.change")[0].subject.contains("length_mm `` → `512`"), "{:?}", of("register.change"));
}

#[tokio::test]
async fn a_file_is_told_of_before_it_is_taken_whole() {
    let shore = Shore::with(|_| ()).await;
    let token = shore.token(None, Role::Researcher).await;
    let bad = upload(&shore, "kind=animal", &token, "name,sex\nA,F\nB,x\n,M\n").await;
    assert_eq!(bad.status, StatusCode::OK, "{}", bad.body);
    let told: RegisterImport = serde_json::from_str(&bad.body).unwrap();
    assert_eq!(told.problems.iter().map(|one| one.line).collect::<Vec<_>>(), [Some(3), Some(4)]);
    let blind = upload(&shore, "kind=animal&apply=true", &token, "name,sex\nA,F\n").await;
    assert!(
        blind.status == StatusCode::BAD_REQUEST && blind.body.contains("version: give"),
        "{}",
        blind.body
    );
    let refused = upload(&shore, "kind=animal&apply=true&version=0", &token, "name,sex\nA,F\nB,x\n").await;
    assert_eq!(refused.status, StatusCode::UNPROCESSABLE_ENTITY);
    assert!(refused.body.contains("line 3, sex: `x` is not one of F, M, U"), "{}", refused.body);
    assert!(listed(&shore, &token, "").await.entries.is_empty(), "nothing of it");

    let good = "name;length_mm;notes\nA;51,5;=1+1\nB;;\n";
    let told: RegisterImport =
        serde_json::from_str(&upload(&shore, "kind=animal", &token, good).await.body).unwrap();
    assert_eq!((told.added, told.applied, told.version), (2, false, 0));
    let done = upload(&shore, "kind=animal&apply=true&version=0", &token, good).await;
    let done: RegisterImport = serde_json::from_str(&done.body).unwrap();
    assert_eq!(
        (done.applied, done.version, listed(&shore, &token, "?kind=animal").await.version),
        (true, 1, 1)
    );
    let late = upload(&shore, "kind=animal&apply=true&version=0", &token, good).await;
    assert_eq!(late.status, StatusCode::CONFLICT, "the register was changed since");

    let csv = shore.get("/api/v1/register.csv?kind=animal", &token).await;
    assert_eq!(csv.headers[header::CONTENT_DISPOSITION], "attachment; filename=\"animals.csv\"");
    assert!(csv.body.contains("A,,,,,51.5,") && csv.body.contains(",'=1+1\n"), "{}", csv.body);
    let again: RegisterImport = serde_json::from_str(
        &upload(&shore, "kind=animal&apply=true&version=1", &token, &csv.body).await.body,
    )
    .unwrap();
    assert_eq!((again.same, again.changed, again.version), (2, 0, 1), "what it wrote changes nothing");
    let template = shore.get("/api/v1/register.csv?kind=deployment", &token).await;
    assert_eq!(
        template.body,
        "name,receiver,vessel,project,from_time,to_time,depth_m,lat_deg,lon_deg,notes\n"
    );
    // Deployments of other vessels are refused line by line.
    let own = shore.token(Some(FIRST), Role::Researcher).await;
    let lines = format!("receiver,vessel,from_time\nr,{FIRST},2026-01-01\nr,{OTHER},2027-01-01\n");
    let told: RegisterImport =
        serde_json::from_str(&upload(&shore, "kind=deployment", &own, &lines).await.body).unwrap();
    assert!(
        told.problems.iter().any(|one| one.line == Some(3) && one.text.contains("takes the role researcher"))
    );
    assert!(!told.problems.iter().any(|one| one.line == Some(2) && one.text.contains("takes the role")));
    let large = "x".repeat(shore::register::FILE_BYTES + 1);
    assert_eq!(upload(&shore, "kind=animal", &token, &large).await.status, StatusCode::PAYLOAD_TOO_LARGE);
}

#[tokio::test]
async fn detections_come_in_the_formats_of_portals_with_what_the_register_knows() {
    let heard = |id: u32| TBRFishTag {
        serial_no: 1_024,
        unix_timestamp: 1_795_248_000,
        millis: 7,
        trans_protocol: 6_u8.into(),
        trans_id: id,
        trans_data: 42,
        snr: 20,
        trans_freq: 69,
        lat: Some(1.1),
        lon: Some(0.2),
        ..TBRFishTag::default()
    };
    let shore = Shore::with(|data| {
        put(data, &[(2, START_US, heard(101).into()), (2, START_US + 1_000_000, heard(102).into())]);
    })
    .await;
    let token = shore.token(None, Role::Researcher).await;
    let file = async |query: &str| {
        let answer = shore.get(&format!("/api/v1/detections.csv?{query}"), &token).await;
        assert_eq!(answer.status, StatusCode::OK, "{query}: {}", answer.body);
        answer
    };
    let before = file("format=vue").await;
    assert_eq!(before.headers[header::CONTENT_DISPOSITION], "attachment; filename=\"detections-vue.csv\"");
    assert_eq!(
        before.body.lines().nth(1).unwrap(),
        "2026-11-21 08:00:00.007,TBR-1024,A69-1105-101,,,42,ADC,0x0814,63.02535746,11.45915590"
    );
    added(&shore, &token, json!({"kind": "animal", "name": "Salmon 12", "scientific_name": "Salmo salar"}))
        .await;
    added(&shore, &token, tag()).await;
    let after = file("format=vue").await;
    assert!(after.body.contains(",A69-1105-101,S256-101,,8.4,m,"), "{}", after.body);
    assert_ne!(
        before.headers[header::ETAG],
        after.headers[header::ETAG],
        "the register is part of what the bytes are of"
    );
    assert_eq!(after.body, file("format=vue").await.body, "the same question, the same bytes");
    for format in research::FORMATS {
        let answer = file(&format!("format={}", format.name)).await;
        let body = answer.body;
        assert!(body.starts_with(format.header), "{}", format.name);
        assert_eq!(answer.headers[header::CONTENT_TYPE], format.media());
        let disposition = answer.headers[header::CONTENT_DISPOSITION].to_str().unwrap();
        assert!(disposition.ends_with(&format!(".{}\"", format.ending())), "{disposition}");
        if !format.is_csv() {
            continue;
        }
        // One of both tags is that of an animal.
        let rows = if format.is_of_detections() && format.name != "darwin-core" { 2 } else { 1 };
        assert_eq!(
            body[format.header.len()..].lines().count(),
            rows + usize::from(format.name == "lutra"),
            "{body}"
        );
    }
    let own = file("").await.body;
    assert!(own.lines().nth(1).unwrap().ends_with(",S256-101,Salmon 12,Salmo salar,8.4,m,,"), "{own}");
    assert!(own.lines().nth(2).unwrap().ends_with(",,,,,,,"), "{own}");
    for (query, told) in [
        ("format=vemco", "format: `vemco` is not a format; there are lutra"),
        ("format=vue&spreadsheet=comma", "spreadsheet:"),
    ] {
        let answer = shore.get(&format!("/api/v1/detections.csv?{query}"), &token).await;
        assert!(
            answer.status == StatusCode::BAD_REQUEST && answer.body.contains(told),
            "{query}: {}",
            answer.body
        );
    }
}
