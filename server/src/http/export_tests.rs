//! Exports: contents, refusals, and that a truncated one is never taken for complete.

use super::history_tests::put;
use super::testing::FIRST;
use super::tests::{Answer, Shore, bearer};
use crate::config::Config;
use crate::serve::serve;
use api::Role;
use axum::body::Body;
use axum::http::{Request, StatusCode, header};
use flate2::read::MultiGzDecoder;
use imc::lsf::{LogItem, LogReader};
use imc::messages::{
    EntityList, EntityListOp, LogBookEntry, LogBookEntryType, TBRFishTag, Temperature, Voltage,
};
use shore::clock;
use shore::identity::testing;
use std::io::{Read as _, Seek as _, SeekFrom, Write as _};
use std::path::Path;
use std::time::Duration;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;

/// 2026-11-21 08:00 UTC.
const START_US: i64 = 1_795_248_000_000_000;
const DEADLINE: Duration = Duration::from_secs(20);

fn made_up(data: &Path) {
    let list = EntityList { op: EntityListOp::Report, list: "=Battery=2;Motor=3".into() };
    let warning = LogBookEntry {
        r#type: LogBookEntryType::Warning,
        text: "=cmd|' /C calc'!A0".into(),
        ..LogBookEntry::default()
    };
    put(
        data,
        &[
            (255, START_US, list.into()),
            (2, START_US + 1_000_000, Voltage { value: 24.5 }.into()),
            (3, START_US + 2_000_000, Temperature { value: 8.25 }.into()),
            (3, START_US + 3_000_000, warning.into()),
        ],
    );
}

#[tokio::test]
async fn a_table_is_there_as_parquet_where_that_can_have_it() {
    let shore = Shore::with(made_up).await;
    let token = shore.token(None, Role::Researcher).await;
    let ask = async |query: &str| shore.get(&format!("/api/v1/export.parquet?{query}"), &token).await;
    let file = ask("message=Voltage,Temperature&angles=deg").await;
    assert_eq!(file.status, StatusCode::OK, "{}", file.body);
    assert_eq!(file.headers[header::CONTENT_TYPE], "application/vnd.apache.parquet");
    assert_eq!(file.headers[header::CONTENT_DISPOSITION], "attachment; filename=\"lutra.parquet\"");
    assert!(file.body.starts_with("PAR1") && file.body.ends_with("PAR1"), "{}", file.body);
    assert!(file.headers.contains_key(header::ETAG));
    for (query, remedy) in [
        ("message=Voltage&shape=long", "shape: Parquet has a column for each field"),
        ("message=Voltage&spreadsheet=comma", "spreadsheet: Parquet has numbers"),
        ("message=_raw", "message: `_raw` is there as CSV"),
        ("message=Voltag", "did you mean `Voltage`"),
    ] {
        let refused = ask(query).await;
        assert_eq!(refused.status, StatusCode::BAD_REQUEST, "{query}");
        assert!(refused.body.contains(remedy), "{query}: {}", refused.body);
    }
    let viewer = shore.token(None, Role::Viewer).await;
    assert_eq!(
        shore.get("/api/v1/export.parquet?message=Voltage", &viewer).await.status,
        StatusCode::FORBIDDEN
    );
}

#[tokio::test]
async fn a_table_holds_what_was_asked_for() {
    let shore = Shore::with(made_up).await;
    let token = shore.token(None, Role::Researcher).await;
    let csv = async |query: &str| {
        let answer = shore.get(&format!("/api/v1/export.csv?{query}"), &token).await;
        assert_eq!(answer.status, StatusCode::OK, "{query}: {}", answer.body);
        answer
    };
    let wide = csv("message=Voltage,Temperature").await;
    let lines: Vec<&str> = wide.body.lines().collect();
    assert_eq!(lines.len(), 3, "{}", wide.body);
    assert!(lines[0].contains("Voltage.value [V]") && lines[0].contains("Temperature.value ["));
    assert_eq!(wide.headers[header::CONTENT_DISPOSITION], "attachment; filename=\"lutra.csv\"");
    let long = csv("message=Voltage,Temperature&shape=long&entity=Motor").await;
    assert_eq!(long.body.lines().count(), 2);
    assert!(long.body.lines().nth(1).unwrap().contains(",Temperature,value,8.25,"), "{}", long.body);
    let book = csv("message=LogBookEntry&field=type,text&labels=true&vessel=0x0814").await;
    assert!(book.body.contains(",WARNING,'=cmd|' /C calc'!A0\n"), "{}", book.body);
    let bare = csv("message=LogBookEntry&field=text&guard=false").await;
    assert!(bare.body.contains(",=cmd|"), "{}", bare.body);
    let range = csv("message=*&from=2026-11-21T08:00:01Z&to=2026-11-21T08:00:02Z&units=false").await;
    assert!(range.body.contains("24.5") && !range.body.contains("8.25") && !range.body.contains("[V]"));

    let arrived = csv("message=Voltage&received=true").await;
    assert!(arrived.body.lines().next().unwrap().contains(",received,received_unix_s,"), "{}", arrived.body);
    let raw = csv("message=_raw").await;
    assert!(raw.body.ends_with("entity_id,dst,dst_ent,id,payload,problem\n"), "{}", raw.body);

    let packed = csv("message=Voltage&gzip=true").await;
    assert_eq!(packed.headers[header::CONTENT_TYPE], "application/gzip");
    assert_eq!(packed.headers[header::CONTENT_DISPOSITION], "attachment; filename=\"Voltage.csv.gz\"");
    let mut unpacked = String::new();
    MultiGzDecoder::new(&packed.bytes[..]).read_to_string(&mut unpacked).unwrap();
    assert_eq!(unpacked, csv("message=Voltage").await.body);

    let about = shore.get("/api/v1/export.json?message=Voltage&angles=deg", &token).await;
    let about: serde_json::Value = serde_json::from_str(&about.body).unwrap();
    let columns = about["columns"].as_array().unwrap();
    let header: Vec<String> = lines[0].split(',').map(str::to_owned).collect();
    assert_eq!((columns.last().unwrap()["unit"].as_str(), header[0].as_str()), (Some("V"), "time"));
}

#[tokio::test]
async fn detections_are_counted_for_whom_may_see_them_and_for_nobody_else() {
    let tag = |id: u32, lat_deg: f64| TBRFishTag {
        serial_no: 1_024,
        unix_timestamp: 1_795_248_000,
        trans_protocol: 6_u8.into(),
        trans_id: id,
        lat: Some(lat_deg.to_radians()),
        lon: Some(0.2),
        ..TBRFishTag::default()
    };
    let shore = Shore::with(|data| {
        let said = [(101, 63.0), (102, 63.5), (101, 64.0)].iter().zip(1..);
        let said = said.map(|((id, lat), at)| (2, START_US + at * 1_000_000, tag(*id, *lat).into()));
        put(data, &said.collect::<Vec<(u8, i64, imc::Message)>>());
    })
    .await;
    let token = shore.token(None, Role::Researcher).await;
    let own = shore.token(Some(FIRST + 1), Role::Researcher).await;
    let counted = async |query: &str, token: &str| {
        let answer = shore.get(&format!("/api/v1/detections/summary?{query}"), token).await;
        assert_eq!(answer.status, StatusCode::OK, "{query}: {}", answer.body);
        serde_json::from_str::<api::DetectionsSummary>(&answer.body).unwrap()
    };
    let all = counted("", &token).await;
    assert_eq!((all.detections, all.tags_all, all.read_from_us), (3, 2, None));
    assert_eq!((&*all.tags[0].tag, all.tags[0].detections), ("S256-101", 2));
    // File and list agree with the plots.
    let area = "area=62.9,11;63.6,11;63.6,12;62.9,12";
    assert_eq!(counted(area, &token).await.detections, 2);
    let file = shore.get(&format!("/api/v1/detections.csv?{area}"), &token).await;
    assert_eq!(file.body.lines().count(), 3, "{}", file.body);
    let size = shore.get(&format!("/api/v1/detections/size?{area}"), &token).await;
    let size: api::ExportSize = serde_json::from_str(&size.body).unwrap();
    assert_eq!((size.rows, size.bytes), (2, file.body.len() as u64));
    assert!(!size.estimated);
    // Exports do not use its places.
    let exports = &shore.state.shore.history.exports;
    let taken = exports.acquire_many(exports.available_permits() as u32).await.unwrap();
    let beside = shore.get(&format!("/api/v1/detections/size?{area}"), &token).await;
    assert_eq!(beside.status, StatusCode::OK, "{}", beside.body);
    drop(taken);
    let path = format!("/api/v1/detections?from_us=0&to_us={}&flags=true&{area}", START_US * 2);
    let list: api::Detections = serde_json::from_str(&shore.get(&path, &token).await.body).unwrap();
    assert_eq!(list.detections.len(), 2);
    assert_eq!(list.detections[0].min_lag_s, Some(0.0), "the other one of the tag lies outside the area");
    assert_eq!(list.detections[0].flags, Some(Vec::new()));
    for (query, named) in [
        ("tag=fish", "tag:"),
        (&*format!("tag={}", vec!["101"; 201].join(",")), "tag: 201 tags are more than 200"),
        ("project=Trout", "project:"),
        ("area=1,2", "area:"),
        ("area=63,10;64,11;64,10;63,11", "area: the sides from corner 1"),
        ("from_us=9&to_us=1", "to_us:"),
    ] {
        let answer = shore.get(&format!("/api/v1/detections/summary?{query}"), &token).await;
        assert_eq!(answer.status, StatusCode::BAD_REQUEST, "{query}");
        assert!(answer.body.contains(named), "{query}: {}", answer.body);
    }
    assert_eq!(counted("", &own).await.detections, 0, "others' are not counted");
    for path in ["summary", "size"] {
        let path = format!("/api/v1/detections/{path}?vessel=2068");
        assert_eq!(shore.get(&path, &own).await.status, StatusCode::FORBIDDEN);
    }
}

#[tokio::test]
async fn detections_are_one_file_for_exactly_what_is_asked() {
    let tag = |id: u32, place: Option<f64>| TBRFishTag {
        serial_no: 1_024,
        unix_timestamp: 1_795_248_000,
        millis: 7,
        trans_protocol: 6_u8.into(),
        trans_id: id,
        snr: 20,
        lat: place,
        lon: place.map(|_| 0.2),
        ..TBRFishTag::default()
    };
    let shore = Shore::with(|data| {
        // That of 2019 has no position.
        let said = [(101, Some(1.1)), (102, Some(1.1)), (101, None)];
        let said = said
            .iter()
            .zip(1..)
            .map(|((id, place), at)| (2, START_US + at * 1_000_000, tag(*id, *place).into()));
        put(data, &said.collect::<Vec<(u8, i64, imc::Message)>>());
    })
    .await;
    let token = shore.token(None, Role::Researcher).await;
    let csv = async |query: &str| {
        let answer = shore.get(&format!("/api/v1/detections.csv?{query}"), &token).await;
        assert_eq!(answer.status, StatusCode::OK, "{query}: {}", answer.body);
        answer.body
    };
    let all = csv("").await;
    let lines: Vec<&str> = all.lines().collect();
    assert_eq!(lines.len(), 4, "{all}");
    assert!(lines[0].starts_with("heard_utc,tag,receiver,vessel,latitude [deg],longitude [deg],"), "{all}");
    assert!(lines[1].starts_with("2026-11-21T08:00:00.007Z,S256-101,1024,"), "{all}");
    assert!(lines[1].contains(",63.02535746,11.45915590,,,20,"), "{all}");
    assert!(lines[3].contains(",,,,,20,"), "absent is empty: {all}");
    assert_eq!(csv("tag=S256-101").await.lines().count(), 3);
    assert_eq!(csv("tag=s256-102,7&vessel=0x0814").await.lines().count(), 2);
    assert_eq!(csv("tag=R64K-101").await.lines().count(), 1);
    let (from, to) = (START_US + 2_000_000, START_US + 3_000_000);
    let part = csv(&format!("from_us={from}&to_us={to}")).await;
    assert!(part.lines().count() == 2 && part.contains("S256-102"), "{part}");
    let json = shore.get(&format!("/api/v1/detections?from_us={from}&to_us={to}&tag=102"), &token).await;
    let json: api::Detections = serde_json::from_str(&json.body).unwrap();
    assert_eq!(json.detections.iter().map(|one| one.tag_id).collect::<Vec<_>>(), [102]);
    for (query, named) in [("tag=fish", "tag:"), ("vessel=otter", "vessel:"), ("from_us=9&to_us=1", "to_us:")]
    {
        let answer = shore.get(&format!("/api/v1/detections.csv?{query}"), &token).await;
        assert_eq!(answer.status, StatusCode::BAD_REQUEST, "{query}");
        assert!(answer.body.contains(named), "{query}: {}", answer.body);
    }
    let own = shore.token(Some(FIRST + 1), Role::Researcher).await;
    assert_eq!(shore.get("/api/v1/detections.csv?vessel=2068", &own).await.status, StatusCode::FORBIDDEN);
    assert_eq!(
        shore.get("/api/v1/detections?from_us=0&to_us=9&vessel=2068", &own).await.status,
        StatusCode::FORBIDDEN
    );
    assert_eq!(
        shore.get("/api/v1/detections.csv", &own).await.body.lines().count(),
        1,
        "others' are not in it"
    );
}

#[tokio::test]
async fn a_log_holds_the_very_packets() {
    let Some(recording) = testkit::shared("data/imc/dune_log_a/Data.lsf.gz") else { return };
    let shore = Shore::with(|data| {
        let mut store = store::Store::open(data).unwrap();
        let now = units::UtcTime::from_micros(START_US);
        store.import(std::slice::from_ref(&recording), now, &mut |_| true).unwrap();
        store.close().unwrap();
    })
    .await;
    let token = shore.token(None, Role::Researcher).await;
    let wanted = packets(LogReader::open(&recording).unwrap());
    let all = shore.get("/api/v1/export.lsf", &token).await;
    let mut got = packets(LogReader::detect(&all.bytes[..]).unwrap());
    assert_eq!(got.len(), wanted.len());
    let sorted = |mut list: Vec<Vec<u8>>| {
        list.sort();
        list
    };
    got = sorted(got);
    assert!(got == sorted(wanted), "the same packets, byte for byte");
    let some = shore.get("/api/v1/export.lsf?message=EstimatedState&gzip=true", &token).await;
    assert_eq!(some.headers[header::CONTENT_DISPOSITION], "attachment; filename=\"EstimatedState.lsf.gz\"");
    let some = packets(LogReader::detect(&some.bytes[..]).unwrap());
    let states = got.iter().filter(|packet| imc::PacketView::new(packet).unwrap().id() == 350);
    assert!(!some.is_empty() && some.len() == states.count());
}

fn packets<R: std::io::Read>(mut log: LogReader<R>) -> Vec<Vec<u8>> {
    let mut found = Vec::new();
    while let Some(item) = log.next_item().unwrap() {
        match item {
            LogItem::Packet { view, .. } => found.push(view.bytes().to_vec()),
            other => panic!("{other:?}"),
        }
    }
    found
}

#[tokio::test]
async fn what_cannot_be_exported_is_refused_before_the_first_byte() {
    let shore = Shore::with(made_up).await;
    let token = shore.token(None, Role::Researcher).await;
    for (query, named) in [
        ("message=Voltag", "message: IMC has no message `Voltag`; did you mean `Voltage`"),
        ("message=", "message:"),
        ("", "message"),
        ("mesage=Voltage", "mesage"),
        ("message=Voltage&vessel=otter", "vessel: nothing is recorded of `otter`"),
        ("message=Voltage&entity=Nobody", "entity:"),
        ("message=Voltage&field=volts", "field:"),
        ("message=Voltage&field=Temperature.value", "field:"),
        ("message=Voltage&from=yesterday", "from:"),
        ("message=Voltage&from=2026-11-22T00:00:00Z&to=2026-11-21T00:00:00Z", "to:"),
        ("message=Voltage&angles=grad", "angles:"),
        ("message=Voltage&shape=tall", "shape:"),
        ("message=Voltage&gzip=maybe", "gzip"),
    ] {
        for format in ["csv", "json"] {
            let answer = shore.get(&format!("/api/v1/export.{format}?{query}"), &token).await;
            assert_eq!(answer.status, StatusCode::BAD_REQUEST, "{query}: {}", answer.body);
            let said: serde_json::Value = serde_json::from_str(&answer.body).unwrap();
            let text = said["error"]["text"].as_str().unwrap();
            assert!(text.contains(named), "{query}: {text}");
        }
    }
    let own = shore.token(Some(FIRST + 1), Role::Researcher).await;
    for format in ["csv?message=Voltage&vessel=2068", "lsf?vessel=2068", "json?message=Voltage&vessel=2068"] {
        let answer = shore.get(&format!("/api/v1/export.{format}"), &own).await;
        assert_eq!(answer.status, StatusCode::FORBIDDEN, "{}", answer.body);
    }
    let nothing = shore.get("/api/v1/export.csv?message=Voltage", &own).await;
    assert!(nothing.body.contains("nothing is recorded that you may export"), "{}", nothing.body);
}

/// Takes 10 s: a query waits 5 s for its turn, twice.
#[tokio::test]
async fn questions_beyond_the_places_are_asked_to_come_again() {
    let shore = Shore::with(made_up).await;
    let token = shore.token(None, Role::Researcher).await;
    let history = &shore.state.shore.history;
    for (places, path) in [(&history.counts, "summary"), (&history.sizes, "size")] {
        let path = format!("/api/v1/detections/{path}");
        let taken = [places.take().await.unwrap(), places.take().await.unwrap()];
        let busy = shore.get(&path, &token).await;
        assert_eq!(busy.status, StatusCode::SERVICE_UNAVAILABLE, "{path}: {}", busy.body);
        assert_eq!(busy.headers.get(header::RETRY_AFTER).map(|wait| wait.to_str().unwrap()), Some("2"));
        drop(taken);
        assert_eq!(shore.get(&path, &token).await.status, StatusCode::OK, "{path}");
    }
}

#[tokio::test]
async fn exports_beyond_the_places_are_told_to_wait() {
    let shore = Shore::with(made_up).await;
    let token = shore.token(None, Role::Researcher).await;
    let places = shore.state.shore.history.exports.available_permits();
    let taken = shore.state.shore.history.exports.acquire_many(places as u32).await.unwrap();
    let busy = shore.get("/api/v1/export.csv?message=Voltage", &token).await;
    assert_eq!(busy.status, StatusCode::SERVICE_UNAVAILABLE);
    assert!(busy.headers.contains_key(header::RETRY_AFTER));
    drop(taken);
    assert_eq!(shore.get("/api/v1/export.csv?message=Voltage", &token).await.status, StatusCode::OK);
    assert_eq!(shore.state.shore.history.exports.available_permits(), places, "the place is free again");
}

/// End of a complete chunked answer.
const WHOLE: &[u8] = b"0\r\n\r\n";

/// Over a real connection, where the end mark of an answer is visible.
#[tokio::test(flavor = "multi_thread")]
async fn an_export_that_meets_a_broken_disk_does_not_end_as_a_whole_one() {
    let folder = tempfile::tempdir().unwrap();
    let now = clock::now();
    let begun_us = now.micros() - 30_000_000;
    let many: Vec<_> =
        (0..30_000).map(|step| (2, begun_us + step * 1_000, Voltage { value: step as f32 }.into())).collect();
    put(folder.path(), &many);
    let mut config = Config { data: folder.path().to_owned(), ..Config::default() };
    config.http.listen = "127.0.0.1:0".parse().unwrap();
    config.imc.active = false;
    let serving = serve(config).await.unwrap();
    let (_, token) = testing::script(folder.path(), "p", None, Role::Researcher).await;
    let export = async |more: &str| {
        let request = format!(
            "GET /api/v1/export.csv?message=Voltage&entity=2&vessel={FIRST}{more} HTTP/1.1\r\nhost: a\r\n\
             connection: close\r\nauthorization: Bearer {token}\r\n\r\n"
        );
        let mut stream = TcpStream::connect(serving.address).await.unwrap();
        stream.write_all(request.as_bytes()).await.unwrap();
        let mut answer = Vec::new();
        tokio::time::timeout(DEADLINE, stream.read_to_end(&mut answer)).await.unwrap().unwrap();
        answer
    };
    let whole = export("").await;
    assert!(whole.starts_with(b"HTTP/1.1 200") && whole.ends_with(WHOLE));
    assert!(String::from_utf8_lossy(&whole).lines().count() > 30_000);
    spoil(folder.path());
    for more in ["", "&gzip=true"] {
        let cut = export(more).await;
        assert!(cut.starts_with(b"HTTP/1.1 200"), "{}", String::from_utf8_lossy(&cut));
        assert!(!cut.ends_with(WHOLE) && cut.len() < whole.len());
    }
    serving.stop().await;
}

/// Overwrites pages of the largest month that hold samples near the end of the table.
fn spoil(data: &Path) {
    let months = std::fs::read_dir(data.join("history")).unwrap().map(|entry| entry.unwrap().path());
    let largest = months
        .filter(|path| path.extension().is_some_and(|end| end == "sqlite"))
        .max_by_key(|path| path.metadata().unwrap().len())
        .unwrap();
    let length = largest.metadata().unwrap().len();
    let mut file = std::fs::OpenOptions::new().write(true).open(&largest).unwrap();
    file.seek(SeekFrom::Start(length / 8 * 5)).unwrap();
    file.write_all(&vec![0xA5; (length / 8) as usize]).unwrap();
}

async fn get_with(
    shore: &Shore,
    path: &str,
    token: &str,
    headers: &[(header::HeaderName, String)],
) -> Answer {
    let mut request = bearer(Request::get(path), token);
    for (name, text) in headers {
        request = request.header(name, text);
    }
    shore.send(request, Body::empty()).await
}

/// An interrupted download is resumed with the same bytes, after a restart of the server too, but not from another version.
#[tokio::test]
async fn a_download_that_broke_off_goes_on_to_the_same_bytes() {
    let shore = Shore::with(|data| {
        let many: Vec<_> = (0..3_000)
            .map(|step| (2, START_US + step * 1_000_000, Voltage { value: step as f32 }.into()))
            .collect();
        put(data, &many);
    })
    .await;
    let token = shore.token(None, Role::Researcher).await;
    for path in [
        "/api/v1/export.csv?message=Voltage",
        "/api/v1/export.csv?message=Voltage&gzip=true",
        "/api/v1/export.parquet?message=Voltage",
        "/api/v1/export.lsf?message=Voltage",
        "/api/v1/detections.csv?",
    ] {
        let whole = shore.get(path, &token).await;
        assert_eq!(whole.status, StatusCode::OK, "{path}: {}", whole.body);
        assert_eq!(whole.headers[header::ACCEPT_RANGES], "bytes", "{path}");
        let tag = whole.headers[header::ETAG].to_str().unwrap().to_owned();
        let total = whole.bytes.len();
        let had = total / 3;
        let more = [(header::RANGE, format!("bytes={had}-")), (header::IF_RANGE, tag.clone())];
        let rest = get_with(&shore, path, &token, &more).await;
        assert_eq!(rest.status, StatusCode::PARTIAL_CONTENT, "{path}: {}", rest.body);
        assert_eq!(
            rest.headers[header::CONTENT_RANGE],
            format!("bytes {had}-{}/{total}", total - 1),
            "{path}"
        );
        assert!([&whole.bytes[..had], &rest.bytes[..]].concat() == whole.bytes, "{path}");
        let beyond = get_with(&shore, path, &token, &[(header::RANGE, format!("bytes={total}-"))]).await;
        assert_eq!(beyond.status, StatusCode::RANGE_NOT_SATISFIABLE, "{path}");
        let same = get_with(&shore, path, &token, &[(header::IF_NONE_MATCH, tag.clone())]).await;
        assert_eq!((same.status, same.bytes.len()), (StatusCode::NOT_MODIFIED, 0), "{path}");
    }
    // For another version the whole new file is sent, not a part.
    let path = "/api/v1/export.csv?message=Voltage";
    let before = shore.get(path, &token).await;
    let tag = before.headers[header::ETAG].to_str().unwrap().to_owned();
    assert_ne!(tag, shore.get(&format!("{path}&angles=deg"), &token).await.headers[header::ETAG]);
    let packet = imc::Packet::new(
        imc::Header {
            timestamp: START_US as f64 / 1e6,
            src: imc::Address(FIRST),
            src_ent: 3,
            ..imc::Header::default()
        },
        Voltage { value: 1.0 },
    );
    let bytes = packet.encode().unwrap();
    shore
        .state
        .shore
        .recorder
        .with_store(move |store| {
            let received = units::UtcTime::from_micros(START_US);
            let accepted =
                store::Accepted { packet: &bytes, received, transport: store::Transport::Tcp, link: None };
            store.accept(&accepted).unwrap();
            store.commit().unwrap();
        })
        .await
        .unwrap();
    let more = [(header::RANGE, "bytes=100-".to_owned()), (header::IF_RANGE, tag)];
    let after = get_with(&shore, path, &token, &more).await;
    assert_eq!(after.status, StatusCode::OK);
    assert!(after.bytes.len() > before.bytes.len());
}

#[tokio::test]
async fn vessels_have_names_and_times_offsets() {
    let shore = Shore::with(made_up).await;
    let token = shore.token(None, Role::Researcher).await;
    let csv = async |query: &str| shore.get(&format!("/api/v1/export.csv?{query}"), &token).await;
    let whole = csv("message=voltage&vessel=0x0814").await.body;
    assert_eq!(whole.lines().count(), 2, "{whole}");
    let name = whole.lines().nth(1).unwrap().split(',').nth(2).unwrap().to_uppercase();
    for query in [
        format!("message=0x{:x}&vessel={name}", imc::catalogue::by_abbrev("Voltage").unwrap().id),
        "message=Voltage&vessel=2068&from=2026-11-21T10:00:00%2B02:00".to_owned(),
        // With a plus, as in a page's address.
        "message=Voltage&to=2026-11-21T10:00:02+02:00".to_owned(),
    ] {
        assert_eq!(csv(&query).await.body, whole, "{query}");
    }
    let later = csv("message=Voltage&from=2026-11-21T10:00:02%2B02:00").await.body;
    assert_eq!(later.lines().count(), 1, "{later}");
    for (query, told) in [
        ("message=Voltage&vessel=2069", "vessel: nothing is recorded of `2069`; there are "),
        ("message=Voltage&vessel=ottr", "vessel: nothing is recorded of `ottr`"),
        ("message=Voltage&entity=Moter", "entity: no entity is called `Moter`; did you mean `Motor`?"),
        ("message=Voltage&field=vlaue", "field: Voltage has no field `vlaue`; did you mean `value`?"),
        ("message=Voltage&spreadsheet=dot", "spreadsheet: `dot` is neither `comma` nor `point`"),
    ] {
        let answer = csv(query).await;
        assert_eq!(answer.status, StatusCode::BAD_REQUEST, "{query}: {}", answer.body);
        assert!(answer.body.contains(told), "{query}: {}", answer.body);
    }
    let sheet = csv("message=Voltage&spreadsheet=comma").await.body;
    assert!(sheet.starts_with("\u{FEFF}time;unix_s;") && sheet.contains(";24,5\n"), "{sheet}");
}
