//! Rows for Grafana and notebooks: what stands in them, who gets which, and where they end.

use super::tests::{Answer, Shore};
use api::{Buckets, Role, TableChoice, TableDetection, TableDetections, TableRow};
use axum::body::Body;
use axum::http::{Request, StatusCode, header};
use imc::messages::{EntityList, EntityListOp, EstimatedState, TBRFishTag, Voltage};
use imc::{Address, Header, Message, Packet};
use serde::de::DeserializeOwned;
use std::path::Path;
use store::{Accepted, Store, Transport};
use units::UtcTime;

/// 2026-11-21 08:00 UTC.
const START_US: i64 = 1_795_248_000_000_000;
const OTTER: u16 = 0x0814;
const OTHER: u16 = 0x0815;
/// A console.
const NEPTUS: u16 = 0x4001;
/// Ten minutes from the start on.
const SPAN: &str = "from=1795248000000&to=1795248600000";

fn psi(degrees: f64) -> Message {
    EstimatedState { psi: degrees.to_radians() as f32, ..EstimatedState::default() }.into()
}

fn tag(number: u32, place: Option<(f64, f64)>) -> Message {
    TBRFishTag {
        serial_no: 1_024,
        unix_timestamp: (START_US / 1_000_000) as u32 + number,
        millis: 7,
        trans_protocol: 6_u8.into(),
        trans_id: number,
        trans_data: 5,
        snr: 20,
        trans_freq: 69,
        lat: place.map(|(lat, _)| lat.to_radians()),
        lon: place.map(|(_, lon)| lon.to_radians()),
        ..TBRFishTag::default()
    }
    .into()
}

/// Two vessels and a console: voltages of two entities each second, headings about north, three tags.
fn recorded(data: &Path) {
    let mut store = Store::open(data).unwrap();
    let mut put = |src: u16, src_ent: u8, second: f64, message: Message| {
        let received = UtcTime::from_micros(START_US + (second * 1e6) as i64);
        let header =
            Header { timestamp: received.seconds(), src: Address(src), src_ent, ..Header::default() };
        let packet = Packet::new(header, message).encode().unwrap();
        store.accept(&Accepted { packet: &packet, received, transport: Transport::Tcp, link: None }).unwrap();
    };
    for vessel in [OTTER, OTHER] {
        let list =
            EntityList { op: EntityListOp::Report, list: "Battery=2;Motor, left=3;Navigation=39".into() };
        put(vessel, 255, 0.0, list.into());
        for second in 0..60_u8 {
            let at = f64::from(second);
            put(vessel, 2, at, Voltage { value: f32::from(second) }.into());
            put(vessel, 39, at, psi(if second % 2 == 0 { 350.0 } else { 10.0 }));
        }
    }
    for second in [0.0, 1.0] {
        put(OTTER, 3, second, Voltage { value: 12.5 }.into());
    }
    put(NEPTUS, 0, 1.0, Voltage { value: 5.0 }.into());
    put(OTTER, 9, 3.5, tag(101, Some((63.44, 10.4))));
    put(OTTER, 9, 4.0, tag(102, None));
    put(OTHER, 9, 5.0, tag(101, Some((63.45, 10.5))));
    store.close().unwrap();
}

async fn json<T: DeserializeOwned>(shore: &Shore, path: &str, token: &str) -> T {
    let answer = shore.get(path, token).await;
    assert_eq!(answer.status, StatusCode::OK, "{path}: {}", answer.body);
    serde_json::from_str(&answer.body).unwrap()
}

async fn rows(shore: &Shore, query: &str, token: &str) -> Vec<TableRow> {
    json(shore, &format!("/api/v1/table?{SPAN}&{query}"), token).await
}

#[tokio::test]
async fn rows_are_what_plots_draw() {
    let shore = Shore::with(recorded).await;
    let token = shore.token(None, Role::Viewer).await;
    let all = rows(&shore, "vessel=0x0814&series=Voltage.2.value&points=60", &token).await;
    let range = format!("from_us={START_US}&to_us={}", START_US + 600_000_000);
    let path =
        format!("/api/v1/vessels/{OTTER}/buckets?message=Voltage&entity=2&field=value&pixels=60&{range}");
    let plotted: Buckets = json(&shore, &path, &token).await;
    assert!(all.len() > 3 && all.len() == plotted.min.len(), "{}", all.len());
    assert!(all.iter().map(|row| (row.min, row.mean, row.max, row.count)).eq((0..all.len()).map(|at| (
        plotted.min[at],
        plotted.mean[at],
        plotted.max[at],
        plotted.count[at]
    ))));
    let first = &all[0];
    assert_eq!((&*first.series, &*first.entity, &*first.unit), ("Voltage.2.value", "Battery", "V"));
    assert_eq!((first.min, first.mean, first.max, first.count), (0.0, Some(4.5), 9.0, 10));
    assert_eq!(first.time, "2026-11-21T08:00:05.000Z", "the middle of ten seconds");
    // Where a stretch has one sample, the row has its time.
    let single = rows(&shore, "vessel=0x0814&series=Voltage.2.value&points=10000", &token).await;
    assert_eq!(single.len(), 60);
    assert_eq!((&*single[7].time, single[7].mean), ("2026-11-21T08:00:07.000Z", Some(7.0)));
}

#[tokio::test]
async fn several_series_of_several_vessels_come_in_order_of_time() {
    let shore = Shore::with(recorded).await;
    let token = shore.token(None, Role::Viewer).await;
    let all = rows(&shore, "series=Voltage.Battery.value,EstimatedState.psi&series=Voltage.3.value&vessel=0x0814&vessel=0x0815&points=60", &token).await;
    let keys: Vec<_> = all.iter().map(|row| (&row.time, &row.vessel, &row.series)).collect();
    assert!(keys.is_sorted());
    let kinds: std::collections::BTreeSet<_> = all.iter().map(|row| (&*row.vessel, &*row.series)).collect();
    assert_eq!(kinds.len(), 5, "the other vessel has no motor: {kinds:?}");
    let same =
        rows(&shore, "series=Voltage.2.value&series=voltage.battery.value&vessel=0x0814", &token).await;
    assert_eq!(same.iter().map(|row| row.count).sum::<u64>(), 60, "a series that is named twice comes once");
    // Without an entity the one that sent most.
    let most = rows(&shore, "series=Voltage.value&vessel=0x0814", &token).await;
    assert!(most.iter().all(|row| row.entity == "Battery"));
}

#[tokio::test]
async fn the_mean_of_headings_about_north_is_north() {
    let shore = Shore::with(recorded).await;
    let token = shore.token(None, Role::Viewer).await;
    let all = rows(&shore, "series=EstimatedState.39.psi&vessel=0x0814&points=60&angles=deg", &token).await;
    for row in &all {
        let off = (row.mean.unwrap() + 180.0).rem_euclid(360.0) - 180.0;
        assert!(off.abs() < 0.01 && row.unit == "°", "{row:?}");
        assert!((row.min - 10.0).abs() < 0.01 && (row.max - 350.0).abs() < 0.01, "{row:?}");
    }
    let radians = rows(&shore, "series=EstimatedState.39.psi&vessel=0x0814&points=60", &token).await;
    assert!(radians[0].unit == "rad" && (radians[0].max - 350_f64.to_radians()).abs() < 1e-5);
}

#[tokio::test]
async fn rows_come_as_csv_where_that_is_asked_for() {
    let shore = Shore::with(recorded).await;
    let token = shore.token(None, Role::Viewer).await;
    let path = format!("/api/v1/table?{SPAN}&series=Voltage.3.value&vessel=0x0814&points=10000");
    let csv = "time,vessel,series,entity,unit,min,mean,max,count\n\
               2026-11-21T08:00:00.000Z,0x0814,Voltage.3.value,\"Motor, left\",V,12.5,12.5,12.5,1\n\
               2026-11-21T08:00:01.000Z,0x0814,Voltage.3.value,\"Motor, left\",V,12.5,12.5,12.5,1\n";
    let asked = shore.get(&format!("{path}&format=csv"), &token).await;
    assert_eq!((asked.body.as_str(), asked.status), (csv, StatusCode::OK));
    assert_eq!(asked.headers[header::CONTENT_TYPE], "text/csv; charset=utf-8");
    let request = super::tests::bearer(Request::get(&path), &token).header(header::ACCEPT, "text/csv");
    assert_eq!(shore.send(request, Body::empty()).await.body, csv);
    let heard = shore.get(&format!("/api/v1/table/detections?{SPAN}&vessel=0x0814&format=csv"), &token).await;
    let lines: Vec<&str> = heard.body.lines().collect();
    assert_eq!(lines[0], "time,vessel,tag,data,latitude,longitude,snr_db");
    assert!(
        lines[1].starts_with("2026-11-21T08:00:03.500Z,0x0814,S256-101,5,63.4") && lines[1].ends_with(",20")
    );
    assert_eq!(lines[2], "2026-11-21T08:00:04.000Z,0x0814,S256-102,5,,,20");
}

#[tokio::test]
async fn a_person_gets_rows_of_the_vessels_that_they_may_see_alone() {
    let shore = Shore::with(recorded).await;
    let own = shore.token(Some(OTTER), Role::Viewer).await;
    let seen = rows(&shore, "series=Voltage.2.value", &own).await;
    assert!(!seen.is_empty() && seen.iter().all(|row| row.vessel == "0x0814"), "{seen:?}");
    let heard: TableDetections = json(&shore, &format!("/api/v1/table/detections?{SPAN}"), &own).await;
    assert_eq!(
        heard.rows.iter().map(|row| (&*row.vessel, &*row.tag)).collect::<Vec<_>>(),
        [("0x0814", "S256-101"), ("0x0814", "S256-102")]
    );
    let vessels: Vec<TableChoice> = json(&shore, "/api/v1/table/vessels", &own).await;
    assert_eq!(vessels.iter().map(|one| &*one.value).collect::<Vec<_>>(), ["0x0814"]);
    for path in [
        format!("/api/v1/table?{SPAN}&series=Voltage.2.value&vessel=0x0815"),
        format!("/api/v1/table/detections?{SPAN}&vessel=0x0815"),
        "/api/v1/table/series?vessel=0x0815".to_owned(),
    ] {
        let answer = shore.get(&path, &own).await;
        assert_eq!(answer.status, StatusCode::FORBIDDEN, "{path}: {}", answer.body);
        assert!(answer.body.contains("vessel: you may not see vessel 2069"), "{}", answer.body);
    }
}

#[tokio::test]
async fn what_can_be_chosen_can_be_asked_for() {
    let shore = Shore::with(recorded).await;
    let token = shore.token(None, Role::Viewer).await;
    let vessels: Vec<TableChoice> = json(&shore, "/api/v1/table/vessels", &token).await;
    let values: Vec<&str> = vessels.iter().map(|one| &*one.value).collect();
    assert_eq!(values, ["0x0814", "0x0815"], "a console is not a vessel");
    let series: Vec<TableChoice> = json(&shore, "/api/v1/table/series?vessel=0x0815", &token).await;
    let voltage = series.iter().find(|one| one.value == "Voltage.2.value").unwrap();
    assert_eq!(voltage.text, "Voltage Battery value [V]");
    assert!(series.iter().all(|one| one.value != "Voltage.3.value"), "of the other vessel alone");
    for chunk in series.chunks(20) {
        let names: Vec<&str> = chunk.iter().map(|one| &*one.value).collect();
        rows(&shore, &format!("vessel=0x0815&series={}&points=10", names.join(",")), &token).await;
    }
}

#[tokio::test]
async fn detections_that_do_not_fit_have_an_address() {
    let shore = Shore::with(recorded).await;
    let token = shore.token(None, Role::Viewer).await;
    let whole: TableDetections = json(&shore, &format!("/api/v1/table/detections?{SPAN}"), &token).await;
    assert_eq!((whole.rows.len(), whole.next), (3, None));
    let whole = whole.rows;
    for order in ["oldest", "newest"] {
        let asked = "vessel=0x0814,0x0815&tag=101,102&limit=1";
        let mut path = format!("/api/v1/table/detections?{SPAN}&{asked}&order={order}");
        let mut heard: Vec<TableDetection> = Vec::new();
        loop {
            let answer = shore.get(&path, &token).await;
            assert_eq!(answer.status, StatusCode::OK, "{path}: {}", answer.body);
            let page: TableDetections = serde_json::from_str(&answer.body).unwrap();
            heard.extend(page.rows);
            let link = answer.headers.get(header::LINK).map(|link| link.to_str().unwrap().to_owned());
            assert_eq!(link, page.next.as_ref().map(|next| format!("<{next}>; rel=\"next\"")));
            let Some(next) = page.next else { break };
            path = next;
            assert!(heard.len() < 10, "no end: {path}");
        }
        if order == "newest" {
            heard.reverse();
        }
        assert_eq!(heard, whole, "{order}");
    }
    assert!((whole[0].latitude.unwrap() - 63.44).abs() < 1e-6 && whole[1].longitude.is_none());
    assert!(whole[0].time == "2026-11-21T08:00:03.500Z" && whole[0].snr_db == Some(20));
    let one: TableDetections =
        json(&shore, &format!("/api/v1/table/detections?{SPAN}&tag=102"), &token).await;
    assert_eq!(one.rows.len(), 1);
    let cut =
        shore.get(&format!("/api/v1/table/detections?{SPAN}&limit=1&order=newest&format=csv"), &token).await;
    assert!(cut.headers.contains_key(header::LINK) && cut.body.lines().count() == 2, "{}", cut.body);
}

#[tokio::test]
async fn a_label_with_a_comma_can_be_asked_for() {
    let shore = Shore::with(recorded).await;
    let token = shore.token(None, Role::Viewer).await;
    for series in ["Voltage.Motor%5C,%20left.value", "Voltage.Motor%5C%2C%20left.value,Voltage.3.value"] {
        let motor = rows(&shore, &format!("vessel=0x0814&series={series}"), &token).await;
        assert!(motor.len() == 2 && motor.iter().all(|row| row.entity == "Motor, left"), "{motor:?}");
    }
}

#[tokio::test]
async fn more_series_than_are_read_at_once_are_refused() {
    let shore = Shore::with(|data| {
        let mut store = Store::open(data).unwrap();
        for number in 0..502_u16 {
            let received = UtcTime::from_micros(START_US + i64::from(number));
            let header = Header {
                timestamp: received.seconds(),
                src: Address(OTTER + number / 251),
                src_ent: (number % 251) as u8,
                ..Header::default()
            };
            let packet = Packet::new(header, Voltage { value: 1.0 }).encode().unwrap();
            let accepted = Accepted { packet: &packet, received, transport: Transport::Tcp, link: None };
            store.accept(&accepted).unwrap();
        }
        store.close().unwrap();
    })
    .await;
    let token = shore.token(None, Role::Viewer).await;
    let names: Vec<_> = (0..251).map(|entity| format!("Voltage.{entity}.value")).collect();
    let query = format!("/api/v1/table?{SPAN}&points=1&series={}", names.join(","));
    let answer = shore.get(&query, &token).await;
    assert_eq!(answer.status, StatusCode::BAD_REQUEST, "{}", answer.body);
    assert!(answer.body.contains("series: more than 500 series of these vessels"), "{}", answer.body);
    let one = shore.get(&format!("{query}&vessel=0x0814"), &token).await;
    assert_eq!(one.status, StatusCode::OK, "{}", one.body);
    let many: Vec<_> = (0..501).map(|at| format!("Voltage.{at}.value")).collect();
    let answer = shore.get(&format!("/api/v1/table?{SPAN}&series={}", many.join(",")), &token).await;
    assert!(answer.body.contains("series: more than 500 names"), "{}", answer.body);
}

#[tokio::test]
async fn what_cannot_be_asked_is_refused_with_what_to_write() {
    let shore = Shore::with(recorded).await;
    let token = shore.token(None, Role::Viewer).await;
    let ask = async |query: &str| -> Answer { shore.get(&format!("/api/v1/table?{query}"), &token).await };
    for (query, said) in [
        ("series=Voltage.2.value", "from: this is missing"),
        (SPAN, "series: this is missing"),
        (&format!("{SPAN}&series="), "series: name one, such as Voltage.2.value"),
        ("from=now-6h&to=now&series=Voltage.2.value", "from: `now-6h` is not a time"),
        (&format!("{SPAN}&series=Voltage.2.valu"), "did you mean `value`?"),
        (
            &format!("{SPAN}&series=EntityState.2.description"),
            "has no field `description` that holds numbers",
        ),
        (&format!("{SPAN}&series=Voltage.Batery.value"), "did you mean `Battery`?"),
        (&format!("{SPAN}&series=Voltage.2.value&vessel=hansen"), "vessel: nothing is recorded of `hansen`"),
        (&format!("{SPAN}&series=Voltage.2.value&points=0"), "points: 0 is not within 1 to 10000"),
        (&format!("{SPAN}&series=Voltage.2.value&angles=gon"), "angles: give `rad` or `deg`"),
        (&format!("{SPAN}&series=Voltage.2.value&format=xml"), "format: give `json` or `csv`"),
        (&format!("{SPAN}&series=Voltage.2.value&pixels=3"), "`pixels` is not known here"),
        (
            &format!(
                "{SPAN}&points=10000&series=Voltage.2.value,Voltage.3.value,EstimatedState.psi,EstimatedState.u"
            ),
            "7 series with 10000 points each are more than 50000 rows; ask for at most 7142 points",
        ),
    ] {
        let answer = ask(query).await;
        assert_eq!(answer.status, StatusCode::BAD_REQUEST, "{query}: {}", answer.body);
        assert!(answer.body.replace("\\\"", "\"").contains(said), "{query}: {}", answer.body);
    }
    let empty = rows(&shore, "series=Voltage.77.value", &token).await;
    assert!(empty.is_empty(), "an entity that sent nothing is not a mistake");
}
