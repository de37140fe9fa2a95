//! The history's routes on a store with a recording of DUNE and made-up packets, and hostile questions to all.

use super::testing::{FIRST, an_hour};
use super::tests::Shore;
use crate::serve::router;
use crate::web::{Kind, Need};
use api::{
    At, Buckets, Detections, Entity, Gap, GapKind, LogBook, Role, SampleRow, Samples, Series, TrackPoint,
};
use axum::http::{Method, StatusCode, header};
use imc::messages::{EstimatedState, LogBookEntry, TBRFishTag};
use imc::{Address, Header, Message, Packet};
use serde::de::DeserializeOwned;
use shore::clock;
use std::path::Path;
use store::{Accepted, GapKind as Missing, Reader, Store, TimeRange, Transport};
use units::UtcTime;

/// 2026-11-21 08:00 UTC.
const START_US: i64 = 1_795_248_000_000_000;
const OTTER: u16 = 0x0814;

/// Stores packets of an Otter in a folder, each with entity and time.
pub(super) fn put(data: &Path, packets: &[(u8, i64, Message)]) {
    let mut store = Store::open(data).unwrap();
    for (src_ent, time_us, message) in packets {
        let timestamp = UtcTime::from_micros(*time_us).seconds();
        let header = Header { timestamp, src: Address(OTTER), src_ent: *src_ent, ..Header::default() };
        let packet = Packet::new(header, message.clone()).encode().unwrap();
        let received = UtcTime::from_micros(START_US);
        store.accept(&Accepted { packet: &packet, received, transport: Transport::Tcp, link: None }).unwrap();
    }
    store.close().unwrap();
}

async fn json<T: DeserializeOwned>(shore: &Shore, path: &str, token: &str) -> T {
    let answer = shore.get(path, token).await;
    assert_eq!(answer.status, StatusCode::OK, "{path}: {}", answer.body);
    serde_json::from_str(&answer.body).unwrap()
}

#[tokio::test]
async fn a_recording_of_dune_is_whole_in_plots_and_tables() {
    let Some(recording) = testkit::shared("data/imc/dune_log_a/Data.lsf.gz") else { return };
    let shore = Shore::with(|data| {
        let mut store = Store::open(data).unwrap();
        store.import(&[recording], UtcTime::from_micros(START_US), &mut |_| true).unwrap();
        store.close().unwrap();
    })
    .await;
    let token = shore.token(None, Role::Viewer).await;
    let all: Vec<Series> = json(&shore, "/api/v1/series", &token).await;
    let mut reader = Reader::open(shore.data()).unwrap();
    let kept = reader.series(None).unwrap();
    assert_eq!(all.len(), kept.len());
    assert_eq!(
        all.iter().map(|one| one.count).sum::<u64>(),
        kept.iter().map(|one| one.extent.count).sum::<u64>()
    );
    let state = all.iter().find(|one| one.message == "EstimatedState").unwrap();
    let psi = state.fields.iter().find(|field| field.name == "psi").unwrap();
    assert_eq!((psi.unit.as_str(), psi.kind, state.undated), ("rad", api::ValueKind::Real, 0));
    let (vessel, entity, count) = (state.system, state.entity, state.count);
    assert!(count > 100, "{count}");
    let one: Vec<Series> = json(&shore, &format!("/api/v1/series?system={vessel}"), &token).await;
    assert_eq!(one.len(), all.iter().filter(|one| one.system == vessel).count());

    let (from_us, to_us) = (state.first_us.unwrap(), state.last_us.unwrap() + 1);
    let of = |what: &str| format!("/api/v1/vessels/{vessel}/{what}from_us={from_us}&to_us={to_us}");
    let question = format!("buckets?message=EstimatedState&entity={entity}&field=psi&pixels=40&");
    let buckets: Buckets = json(&shore, &of(&question), &token).await;
    assert_eq!((buckets.count.iter().sum::<u64>(), buckets.unit.as_str()), (count, "rad"));
    assert!(buckets.start_us.len() <= 41 && buckets.start_us.is_sorted());
    for at in 0..buckets.start_us.len() {
        let mean = buckets.mean[at].unwrap();
        assert!(buckets.min[at] <= mean + 1e-9 && mean <= buckets.max[at] + 1e-9, "{at}");
    }

    // Page by page, all samples and each once.
    let mut rows: Vec<SampleRow> = Vec::new();
    let (mut from, mut skip) = (from_us, 0);
    loop {
        let question = format!(
            "/api/v1/vessels/{vessel}/samples?message=EstimatedState&entity={entity}&fields=psi,true_lat_deg\
             &limit=97&from_us={from}&to_us={to_us}&skip={skip}"
        );
        let page: Samples = json(&shore, &question, &token).await;
        assert_eq!(page.fields[1].unit, "°");
        rows.extend(page.rows);
        let Some(next) = page.next else { break };
        (from, skip) = (next.from_us, next.skip);
    }
    assert_eq!(rows.len() as u64, count);
    let source = store::Source { system: Address(vessel), entity, message: "EstimatedState".to_owned() };
    let samples = reader.samples(&source, &["psi"], TimeRange::ALL, usize::MAX).unwrap();
    assert!(rows.iter().map(|row| row.time_us).eq(samples.time_us.iter().copied()));
    assert!(
        rows.iter()
            .zip(&samples.values[0])
            .all(|(row, psi)| { (row.values[0].as_f64().unwrap() - psi).abs() < 1e-6 })
    );

    let entities: Vec<Entity> = json(&shore, &format!("/api/v1/vessels/{vessel}/entities"), &token).await;
    assert!(entities.iter().any(|one| one.entity == entity && Some(&one.label) == state.label.as_ref()));
    let track: Vec<TrackPoint> = json(&shore, &of("track?"), &token).await;
    assert!(track.len() > 10 && track.iter().all(|point| (point.lat_deg - 41.0).abs() < 30.0), "{track:?}");
    let book: LogBook = json(&shore, &of("logbook?"), &token).await;
    assert_eq!(book.next, None);
}

#[tokio::test]
async fn a_track_is_a_gpx_file_with_a_segment_for_each_part_between_breaks() {
    let at = |s: i64, lat_deg: f64| {
        let state = EstimatedState {
            lat: lat_deg.to_radians(),
            lon: 10.4_f64.to_radians(),
            ..EstimatedState::default()
        };
        (2, START_US + s * 1_000_000, state.into())
    };
    let shore = Shore::with(|data| put(data, &[at(0, 63.44), at(1, 63.45), at(900, 63.46)])).await;
    let token = shore.token(None, Role::Viewer).await;
    let (from_us, to_us) = (START_US, START_US + 1_000_000_000);
    let path = format!("/api/v1/vessels/{OTTER}/track.gpx?from_us={from_us}&to_us={to_us}");
    let answer = shore.get(&path, &token).await;
    assert_eq!(answer.headers[header::CONTENT_TYPE], "application/gpx+xml");
    assert_eq!(answer.headers[header::CONTENT_DISPOSITION], "attachment; filename=\"0x0814-track.gpx\"");
    let parts: Vec<&str> = answer.body.split("<trkseg>").collect();
    assert_eq!(parts.len(), 3, "{}", answer.body);
    assert_eq!(parts[1].matches("<trkpt").count(), 2);
    let first =
        "<trkpt lat=\"63.44000000\" lon=\"10.40000000\"><time>2026-11-21T08:00:00.000000Z</time></trkpt>";
    assert!(parts[1].contains(first), "{}", answer.body);
    let shapes = geofile::gpx::read(answer.body.as_bytes()).unwrap();
    assert_eq!(shapes.shapes.len(), 2, "what it writes it reads");
}

#[tokio::test]
async fn how_a_vessel_was_is_told_by_the_last_of_every_series() {
    let second = |at: i64| START_US + at * 1_000_000;
    let voltage = |value| imc::messages::Voltage { value };
    let shore = Shore::with(|data| {
        let state = imc::messages::VehicleState {
            op_mode: imc::messages::VehicleStateOpMode::Maneuver,
            ..Default::default()
        };
        let mut packets: Vec<(u8, i64, Message)> =
            (0..10).map(|at| (3, second(at), voltage(20.0 + at as f32).into())).collect();
        packets.push((4, second(2), voltage(f32::NAN).into()));
        packets.push((9, second(5), state.into()));
        packets.push((8, second(-40 * 86_400), voltage(1.0).into()));
        put(data, &packets);
    })
    .await;
    let token = shore.token(None, Role::Viewer).await;
    let at = async |time_us: i64| -> At {
        json(&shore, &format!("/api/v1/vessels/{OTTER}/at?time_us={time_us}"), &token).await
    };
    let told = |at: &At| -> Vec<(String, u8, i64)> {
        at.values.iter().map(|one| (one.abbrev.clone(), one.entity, one.time_us)).collect()
    };
    // Nothing before the first; and nothing after it that is older than a month.
    assert_eq!(at(second(-1)).await, At { time_us: second(-1), values: vec![], cut: false });
    assert_eq!(told(&at(second(0)).await), [("Voltage".to_owned(), 3, second(0))], "at the time itself");
    let now = at(second(6) - 1).await;
    assert_eq!(
        told(&now),
        [
            ("VehicleState".to_owned(), 9, second(5)),
            ("Voltage".to_owned(), 3, second(5)),
            ("Voltage".to_owned(), 4, second(2))
        ]
    );
    let mode = now.values[0].fields.iter().find(|field| field.name == "op_mode").unwrap();
    assert_eq!(mode.meaning.as_deref(), Some("MANEUVER"), "as what is live says it");
    let volts = |at: usize| &now.values[at].fields[0];
    assert_eq!((volts(1).value.clone(), volts(1).unit.as_str()), (serde_json::json!(25.0), "V"));
    assert!(volts(2).value.is_null(), "what is not a number");
    assert_eq!((now.values[1].period_s, now.values[2].period_s), (Some(1.0), None));
    let late = at(second(86_400)).await;
    assert_eq!(late.values.len(), 3, "the last stays, with its age");
}

#[tokio::test]
async fn silence_is_told_where_nothing_is_declared() {
    let second = |at: i64| START_US + at * 1_000_000;
    let shore = Shore::with(|data| {
        let heard = (0..5).chain(20..25).chain(60..65);
        let packets: Vec<_> =
            heard.map(|at| (3, second(at), imc::messages::Voltage { value: 24.0 }.into())).collect();
        put(data, &packets);
        let mut store = Store::open(data).unwrap();
        let at = UtcTime::from_micros;
        // The vessel's declared gap takes precedence, although it begins a moment after the last packet.
        let (from, to, declared) = (at(second(4) + 300_000), at(second(20)), at(second(21)));
        let reason = "a test".to_owned();
        let gap = store::Gap {
            system: Address(OTTER),
            from,
            to,
            kind: Missing::Lost,
            reason,
            packets: None,
            numbers: None,
            declared,
        };
        store.declare_gap(&gap).unwrap();
        store.close().unwrap();
    })
    .await;
    let token = shore.token(Some(OTTER), Role::Viewer).await;
    let question = format!("/api/v1/vessels/{OTTER}/gaps?from_us={START_US}&to_us={}", second(100));
    let gaps: Vec<Gap> = json(&shore, &question, &token).await;
    let told: Vec<_> = gaps.iter().map(|gap| (gap.kind, gap.from_us, gap.to_us)).collect();
    assert_eq!(
        told,
        [(GapKind::Lost, second(4) + 300_000, second(20)), (GapKind::NotRecorded, second(24), second(60))]
    );
    assert_eq!(gaps[1].reason, "nothing was heard for 36 s");
}

#[tokio::test]
async fn tags_entries_and_gaps_are_told() {
    let tag = |lat, lon| TBRFishTag {
        serial_no: 1_024,
        unix_timestamp: (START_US / 1_000_000) as u32,
        millis: 250,
        trans_id: 77,
        trans_protocol: imc::messages::TBRFishTagTransProtocol::R64K,
        snr: 30,
        lat,
        lon,
        ..TBRFishTag::default()
    };
    let evil = "=HYPERLINK(\"http://evil\")<img src=x onerror=alert(1)>'; DROP TABLE LogBookEntry;--";
    let entry = |text: &str| LogBookEntry { text: text.into(), ..LogBookEntry::default() };
    let shore = Shore::with(|data| {
        put(
            data,
            &[
                (9, START_US, tag(Some(1.1), Some(0.18)).into()),
                (9, START_US + 1, tag(Some(0.0), Some(0.0)).into()),
                (10, START_US + 1, tag(None, None).into()),
                (3, START_US, entry(evil).into()),
            ],
        );
        let mut store = Store::open(data).unwrap();
        let at = UtcTime::from_micros;
        let (from, to, declared) = (at(START_US), at(START_US + 5), at(START_US + 9));
        let reason = "a test".to_owned();
        let gap = store::Gap {
            system: Address(OTTER),
            from,
            to,
            kind: Missing::Lost,
            reason,
            packets: None,
            numbers: None,
            declared,
        };
        store.declare_gap(&gap).unwrap();
        store.close().unwrap();
    })
    .await;
    let token = shore.token(Some(OTTER), Role::Viewer).await;
    let of =
        |what: &str, to_us: i64| format!("/api/v1/vessels/{OTTER}/{what}from_us={START_US}&to_us={to_us}");
    let heard: Detections = json(&shore, &of("detections?", START_US + 10), &token).await;
    let places: Vec<_> = heard.detections.iter().map(|one| one.lat_deg.zip(one.lon_deg)).collect();
    assert_eq!(places, [Some((1.1_f64.to_degrees(), 0.18_f64.to_degrees())), None, None]);
    let first = &heard.detections[0];
    assert_eq!((first.tag_id, first.snr_db, first.heard_us), (77, Some(30), Some(START_US + 250_000)));
    assert_eq!(first.protocol_name.as_deref(), Some("R64K"));
    let page: Detections = json(&shore, &of("detections?limit=2&", START_US + 10), &token).await;
    let next = page.next.unwrap();
    assert_eq!((page.detections.len(), next.from_us, next.skip), (2, START_US + 1, 1));
    assert_eq!(next.to_us, START_US + 10);
    let last: Detections = json(&shore, &of("detections?order=newest&limit=2&", START_US + 10), &token).await;
    let rest = last.next.unwrap();
    assert_eq!((rest.from_us, rest.to_us, rest.skip), (START_US, START_US + 1, 0));
    let path = format!(
        "/api/v1/vessels/{OTTER}/detections?order=newest&limit=2&from_us={}&to_us={}&skip={}",
        rest.from_us, rest.to_us, rest.skip
    );
    let first: Detections = json(&shore, &path, &token).await;
    assert_eq!(first.next, None);
    let back: Vec<_> = last.detections.into_iter().chain(first.detections).rev().collect();
    assert_eq!(back, heard.detections, "the newest first is the same the other way round");

    let book = shore.get(&of("logbook?", START_US + 10), &token).await;
    assert!(book.headers["content-type"].to_str().unwrap().starts_with("application/json"));
    let book: LogBook = serde_json::from_str(&book.body).unwrap();
    assert_eq!(book.entries[0].text, evil, "text comes as it was said; who shows it escapes it");
    let gaps: Vec<Gap> = json(&shore, &of("gaps?", START_US + 10), &token).await;
    assert_eq!((gaps.len(), gaps[0].kind, gaps[0].to_us), (1, GapKind::Lost, START_US + 5));
    assert!(
        json::<Vec<Gap>>(&shore, &format!("/api/v1/vessels/{OTTER}/gaps?from_us=0&to_us=9"), &token)
            .await
            .is_empty()
    );
    // By name of the address, as people write it.
    assert_eq!(shore.get("/api/v1/vessels/0x0814/entities", &token).await.status, StatusCode::OK);
}

#[tokio::test]
async fn nobody_is_told_of_what_they_may_not_see() {
    let now = clock::now();
    let shore = Shore::with(|data| an_hour(data, now)).await;
    let token = shore.token(Some(FIRST + 1), Role::Viewer).await;
    let all: Vec<Series> = json(&shore, "/api/v1/series", &token).await;
    assert!(!all.is_empty() && all.iter().all(|one| one.system == FIRST + 1));
    let other = shore.get(&format!("/api/v1/series?system={FIRST}"), &token).await;
    assert_eq!(other.status, StatusCode::FORBIDDEN, "{}", other.body);
    let reading = |route: &&crate::web::route::Route| route.method == axum::http::Method::GET;
    let reading: Vec<_> = router::table().iter().filter(reading).map(|route| route.path).collect();
    for path in reading.into_iter().filter(|path| path.contains("{vessel}")) {
        let path = path.replace("{vessel}", &FIRST.to_string());
        assert_eq!(shore.get(&path, &token).await.status, StatusCode::FORBIDDEN, "{path}");
    }
}

/// Queries that are refused.
const WRONG: [(&str, &str); 25] = [
    ("at?time_us=-1", "time_us"),
    ("at?time_us=noon", "time_us"),
    ("at", "time_us"),
    ("track?from_us=-1&to_us=5", "from_us"),
    ("track?from_us=0&to_us=99999999999999999999", "to_us"),
    ("track?from_us=5&to_us=4", "to_us"),
    ("track?from_us=NaN&to_us=4", "from_us"),
    ("track?from_us=0&to_us=4&points=0", "points"),
    ("track?from_us=0&to_us=4&points=4000000000", "points"),
    ("track?from_us=0", "to_us"),
    ("track?from_us=0&to_us=4&from_us=1", "from_us"),
    ("gaps?from_us=0&to_us=9223372036854775807", "to_us"),
    ("logbook?from_us=0&to_us=4&limit=0", "limit"),
    ("logbook?from_us=0&to_us=4&limit=10001", "limit"),
    ("detections?from_us=0&to_us=4&skip=100001", "skip"),
    ("logbook?from_us=0&to_us=4&order=down", "order"),
    ("detections?from_us=0&to_us=4&lmit=5", "lmit"),
    ("buckets?message=Voltag&entity=2&field=value&from_us=0&to_us=4", "did you mean `Voltage`"),
    ("buckets?message=Voltage&entity=256&field=value&from_us=0&to_us=4", "entity"),
    ("buckets?message=Voltage&entity=2&field=value&from_us=0&to_us=4&pixels=10001", "pixels"),
    ("buckets?message=Voltage&entity=2&field=volts&from_us=0&to_us=4", "no field `volts`"),
    ("buckets?message=LogBookEntry&entity=2&field=text&from_us=0&to_us=4", "holds numbers"),
    (
        "buckets?message=Voltage%22%3B%20DROP%20TABLE%20Voltage%3B--&entity=2&field=value&from_us=0&to_us=4",
        "no message",
    ),
    ("samples?message=Voltage&entity=2&fields=value,src%22%20FROM%20_group--&from_us=0&to_us=4", "no field"),
    ("samples?message=Voltage&entity=2&fields=%00%ff&from_us=0&to_us=4", "no field"),
];

#[tokio::test]
async fn what_makes_no_sense_is_refused_with_its_name() {
    let shore = Shore::with(|data| an_hour(data, clock::now())).await;
    let token = shore.token(None, Role::Admin).await;
    for (question, named) in WRONG {
        let answer = shore.get(&format!("/api/v1/vessels/{FIRST}/{question}"), &token).await;
        assert_eq!(answer.status, StatusCode::BAD_REQUEST, "{question}: {}", answer.body);
        let said: serde_json::Value = serde_json::from_str(&answer.body).unwrap();
        let text = said["error"]["text"].as_str().unwrap();
        assert!(text.contains(named), "{question}: {text}");
    }
    for vessel in ["70000", "-1", "otter", "0x", "%00", "1e3", "9999999999999999999999"] {
        let path = format!("/api/v1/vessels/{vessel}/entities");
        let answer = shore.get(&path, &token).await;
        assert_eq!(answer.status, StatusCode::NOT_FOUND, "{path}: {}", answer.body);
        assert!(answer.body.contains("There is no vessel "), "{path}: {}", answer.body);
    }
}

/// Values that break programs.
const HOSTILE: [&str; 16] = [
    "",
    "-1",
    "0",
    "1e308",
    "NaN",
    "inf",
    "18446744073709551616",
    "-9223372036854775808",
    "9007199254740991",
    "%00",
    "%ff%fe",
    "'%20OR%201=1--",
    "%3Cscript%3E",
    "..%2f..%2fetc%2fpasswd",
    "*",
    "true",
];

#[tokio::test]
async fn no_question_makes_the_server_fail() {
    let shore = Shore::with(|data| an_hour(data, clock::now())).await;
    let token = shore.token(None, Role::Admin).await;
    let good = |name: &str| match name {
        "message" => "Voltage",
        "entity" => "2",
        "field" | "fields" => "value",
        "from_us" | "time_us" => "0",
        "to_us" => "9007199254740991",
        _ => "",
    };
    let mut asked = 0;
    for route in router::table()
        .iter()
        .filter(|route| route.kind == Kind::Api && route.method == Method::GET && route.need != Need::Anyone)
    {
        let path = route.path.replace("{vessel}", &FIRST.to_string());
        let names: Vec<&str> = route.query.iter().map(|parameter| parameter.name.as_str()).collect();
        for attacked in names.iter().copied().chain(["no_such"]) {
            for value in HOSTILE {
                let pairs = names.iter().filter(|name| **name != attacked && !good(name).is_empty());
                let mut query: Vec<String> = pairs.map(|name| format!("{name}={}", good(name))).collect();
                query.push(format!("{attacked}={value}"));
                let answer = shore.get(&format!("{path}?{}", query.join("&")), &token).await;
                assert!(!answer.status.is_server_error(), "{path} {query:?}: {}", answer.body);
                if attacked == "no_such" && !names.is_empty() {
                    assert_eq!(answer.status, StatusCode::BAD_REQUEST, "{path} {query:?}");
                }
                if answer.status.is_client_error() {
                    assert!(answer.body.contains("\"code\""), "{path} {query:?}: {}", answer.body);
                    assert!(
                        !answer.body.contains("<script>")
                            || answer.headers["content-type"] == "application/json"
                    );
                }
                asked += 1;
            }
        }
    }
    assert!(asked > 500, "{asked}");
}
