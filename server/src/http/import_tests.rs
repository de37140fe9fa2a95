//! Uploads: what is accepted, what is refused, and that other users are not affected.

use super::tests::{Answer, Shore, bearer};
use api::{Import, ImportState, Role};
use axum::body::{Body, Bytes};
use axum::http::{Request, StatusCode, header};
use flate2::Compression;
use flate2::write::GzEncoder;
use futures_util::stream;
use imc::messages::Temperature;
use imc::{Address, Header, Packet};
use shore::history::Imports;
use std::io::Write as _;
use std::time::Duration;
use store::Reader;
use tokio::sync::oneshot;

/// Longer than anything here takes on a loaded machine.
const DEADLINE: Duration = Duration::from_mins(2);
/// 2026-11-21 08:00 UTC.
const START_S: f64 = 1_795_248_000.0;

fn log(packets: u32) -> Vec<u8> {
    let packet = |number: u32| {
        let timestamp = START_S + f64::from(number);
        let header = Header { timestamp, src: Address(0x0814), src_ent: 3, ..Header::default() };
        Packet::new(header, Temperature { value: number as f32 }).encode().unwrap()
    };
    (0..packets).flat_map(packet).collect()
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut packed = GzEncoder::new(Vec::new(), Compression::fast());
    packed.write_all(bytes).unwrap();
    packed.finish().unwrap()
}

async fn upload(shore: &Shore, token: &str, name: &str, body: impl Into<Body>) -> Answer {
    let request = Request::post(format!("/api/v1/import?name={name}"));
    shore.send(bearer(request, token), body.into()).await
}

/// Waits for the end of an import.
async fn ended(shore: &Shore, token: &str, answer: &Answer) -> Import {
    assert_eq!(answer.status, StatusCode::OK, "{}", answer.body);
    let begun: Import = serde_json::from_str(&answer.body).unwrap();
    let wait = async {
        loop {
            let answer = shore.get(&format!("/api/v1/import/{}", begun.id), token).await;
            let import: Import = serde_json::from_str(&answer.body).unwrap();
            if import.state != ImportState::Running {
                return import;
            }
            tokio::task::yield_now().await;
        }
    };
    tokio::time::timeout(DEADLINE, wait).await.unwrap()
}

fn samples(shore: &Shore) -> u64 {
    let series = Reader::open(shore.data()).unwrap().series(None).unwrap();
    series.iter().map(|one| one.extent.count).sum()
}

fn is_clean(shore: &Shore) -> bool {
    let left = std::fs::read_dir(shore.data().join("uploads"));
    left.is_ok_and(|mut files| files.next().is_none())
}

#[tokio::test]
async fn a_log_is_imported_once_however_often_it_comes() {
    let shore = Shore::with(|_| ()).await;
    let token = shore.token(None, Role::Operator).await;
    let plain = log(5_000);
    let first = ended(&shore, &token, &upload(&shore, &token, "Data.lsf", plain.clone()).await).await;
    assert_eq!((first.state, first.packets, first.added), (ImportState::Done, 5_000, 5_000), "{first:?}");
    assert_eq!((first.upload_bytes, first.read_bytes), (plain.len() as u64, plain.len() as u64));
    assert_eq!((first.name.as_str(), first.problems.len(), samples(&shore)), ("Data.lsf", 0, 5_000));
    let again = ended(&shore, &token, &upload(&shore, &token, "Data.lsf.gz", gzip(&plain)).await).await;
    assert_eq!((again.packets, again.added, samples(&shore)), (5_000, 0, 5_000));
    let all: Vec<Import> = serde_json::from_str(&shore.get("/api/v1/import", &token).await.body).unwrap();
    assert_eq!(all, [again, first]);
    assert!(is_clean(&shore));
}

#[tokio::test]
async fn a_recording_of_dune_comes_in_by_upload() {
    let Some(recording) = testkit::shared("data/imc/dune_log_a/Data.lsf.gz") else { return };
    let shore = Shore::with(|_| ()).await;
    let token = shore.token(None, Role::Admin).await;
    let bytes = std::fs::read(recording).unwrap();
    let import = ended(&shore, &token, &upload(&shore, &token, "Data.lsf.gz", bytes).await).await;
    assert_eq!((import.state, import.added), (ImportState::Done, import.packets), "{import:?}");
    assert!(import.packets > 10_000 && import.damaged_bytes == 0);
}

#[tokio::test]
async fn what_is_no_log_is_refused_with_the_remedy() {
    let shore = Shore::with(|_| ()).await;
    let token = shore.token(None, Role::Operator).await;
    let garbage: Vec<u8> =
        (0..3_000_000_u32).map(|at| (at.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    for (body, remedy) in [
        (b"%PDF-1.7 no log".to_vec(), "not an IMC log"),
        (b"PK\x03\x04zip".to_vec(), "zip archive"),
        (b"BZh91AY".to_vec(), "bunzip2"),
        (Vec::new(), "empty"),
        (gzip(b"<html>no log</html>"), "not an IMC log"),
        (gzip(&vec![0; 30 << 20]), "not an IMC log"),
        (vec![0x1F, 0x8B, 8, 0, 1, 2, 3], "no whole packet in the file: it ends at byte 7"),
        (log(1)[..15].to_vec(), "no whole packet in the file: it ends at byte 15"),
        (garbage, "not an IMC log"),
    ] {
        let answer = upload(&shore, &token, "x", body).await;
        assert_eq!(answer.status, StatusCode::UNSUPPORTED_MEDIA_TYPE, "{remedy}: {}", answer.body);
        assert!(answer.body.contains(remedy), "{}", answer.body);
        assert!(is_clean(&shore));
    }
    let wrong = upload(&shore, &token, "", log(1)).await;
    assert_eq!(wrong.status, StatusCode::BAD_REQUEST, "{}", wrong.body);
    let wrong = upload(&shore, &token, "a%0Ab", log(1)).await;
    assert_eq!(wrong.status, StatusCode::BAD_REQUEST, "{}", wrong.body);
    let long = bearer(Request::post("/api/v1/import?name=x"), &token)
        .header(header::CONTENT_LENGTH, (5_000_u64 << 20).to_string());
    let answer = shore.send(long, Body::empty()).await;
    assert_eq!(answer.status, StatusCode::PAYLOAD_TOO_LARGE);
    assert!(answer.body.contains("max_upload_mib"), "{}", answer.body);
    assert_eq!(samples(&shore), 0);
    assert_eq!(shore.get("/api/v1/import/7", &token).await.status, StatusCode::NOT_FOUND);
}

#[tokio::test]
async fn a_damaged_log_gives_what_it_has_and_says_what_is_wrong() {
    let shore = Shore::with(|_| ()).await;
    let token = shore.token(None, Role::Operator).await;
    let mut damaged = log(100);
    damaged[30] ^= 0xFF;
    damaged.truncate(damaged.len() - 5);
    let import = ended(&shore, &token, &upload(&shore, &token, "%3Cb%3E.lsf", damaged).await).await;
    assert_eq!((import.state, import.added), (ImportState::Done, 98), "{import:?}");
    assert!(import.problems[0].text.starts_with("<b>.lsf: damaged"), "{import:?}");
    let cut = gzip(&log(50_000));
    let import =
        ended(&shore, &token, &upload(&shore, &token, "c.gz", cut[..cut.len() / 2].to_vec()).await).await;
    assert!(
        import.added > 1_000 && import.problems.iter().any(|one| one.text.starts_with("c.gz: ")),
        "{import:?}"
    );
}

#[tokio::test]
async fn one_at_a_time_and_a_cut_upload_leaves_nothing() {
    let shore = Shore::with(|_| ()).await;
    let token = shore.token(None, Role::Operator).await;
    let (begun, begins) = oneshot::channel();
    let (cut, hold) = oneshot::channel::<()>();
    // An endless body, until it is cut off; it is read once the upload has its place.
    let start = stream::once(async {
        begun.send(()).ok();
        Ok::<_, std::io::Error>(Bytes::from(log(10)))
    });
    let rest = stream::once(async move {
        hold.await.ok();
        Err(std::io::Error::other("the connection broke"))
    });
    let endless = Body::from_stream(futures_util::StreamExt::chain(start, rest));
    let first = upload(&shore, &token, "first", endless);
    let second = async {
        begins.await.unwrap();
        let busy = upload(&shore, &token, "second", Vec::new()).await;
        assert_eq!(busy.status, StatusCode::CONFLICT, "{}", busy.body);
        assert!(busy.body.contains("import_running"), "{}", busy.body);
        cut.send(()).unwrap();
    };
    let (answer, ()) = tokio::join!(first, second);
    assert_eq!(answer.status, StatusCode::BAD_REQUEST, "{}", answer.body);
    assert!(answer.body.contains("cut off") && is_clean(&shore));
    assert_eq!(samples(&shore), 0);
    let after = ended(&shore, &token, &upload(&shore, &token, "third", log(3)).await).await;
    assert_eq!(after.added, 3);
}

/// One packet repeated until the log has `bytes` bytes: compressed it is tiny.
fn repeated(bytes: usize) -> Vec<u8> {
    let one = log(1);
    one.iter().copied().cycle().take(bytes / one.len() * one.len()).collect()
}

#[tokio::test]
async fn a_small_upload_that_unpacks_to_too_much_is_given_up_in_time() {
    let shore = Shore::changed(|config| config.http.max_unpacked_mib = 1).await;
    let token = shore.token(None, Role::Operator).await;
    let bomb = gzip(&repeated(20 << 20));
    assert!(bomb.len() < 1 << 20, "{} bytes", bomb.len());
    let import = ended(&shore, &token, &upload(&shore, &token, "bomb.lsf.gz", bomb).await).await;
    assert_eq!(import.state, ImportState::Failed);
    assert!(import.problems[0].text.contains("max_unpacked_mib"), "{import:?}");
    assert!(import.read_bytes < 3 << 20, "{import:?}");
    assert!(is_clean(&shore));
}

#[tokio::test]
async fn an_import_is_cancelled_and_the_list_outlives_the_server() {
    let shore = Shore::with(|_| ()).await;
    let token = shore.token(None, Role::Operator).await;
    let answer = upload(&shore, &token, "long.lsf", repeated(40 << 20)).await;
    let begun: Import = serde_json::from_str(&answer.body).unwrap();
    let cancel = format!("/api/v1/import/{}/cancel", begun.id);
    let viewer = shore.token(None, Role::Viewer).await;
    let refused = shore.send(bearer(Request::post(&cancel), &viewer), Body::empty()).await;
    assert_eq!(refused.status, StatusCode::FORBIDDEN);
    let cancelled = shore.send(bearer(Request::post(&cancel), &token), Body::empty()).await;
    assert_eq!(cancelled.status, StatusCode::OK, "{}", cancelled.body);
    let import = ended(&shore, &token, &answer).await;
    assert_eq!(import.state, ImportState::Cancelled, "{import:?}");
    assert!(import.problems[0].text.starts_with("cancelled by person"), "{import:?}");
    assert!(import.read_bytes < 40 << 20 && is_clean(&shore));
    let late = shore.send(bearer(Request::post(&cancel), &token), Body::empty()).await;
    assert_eq!((late.status, late.body.contains("import_ended")), (StatusCode::CONFLICT, true));
    let none = shore.send(bearer(Request::post("/api/v1/import/99/cancel"), &token), Body::empty()).await;
    assert_eq!(none.status, StatusCode::NOT_FOUND);
    let after = ended(&shore, &token, &upload(&shore, &token, "short.lsf", log(5)).await).await;
    assert_eq!(after.state, ImportState::Done);

    // State at a later start: these two, and one that is marked as interrupted.
    let path = shore.data().join("imports.json");
    let listed = || serde_json::from_slice::<Vec<Import>>(&std::fs::read(&path).unwrap()).unwrap();
    let wait = async {
        while listed().last().is_none_or(|last| last.state != ImportState::Done) {
            tokio::task::yield_now().await;
        }
    };
    tokio::time::timeout(DEADLINE, wait).await.unwrap();
    let mut list = listed();
    assert_eq!(list, [import.clone(), after.clone()]);
    list[1].state = ImportState::Running;
    std::fs::write(&path, serde_json::to_vec(&list).unwrap()).unwrap();
    let again = Imports::new(&shore.state.config.shore(), shore.state.shore.clock.clone()).all();
    assert_eq!((again[1].clone(), again[0].state), (import, ImportState::Failed));
    assert!(again[0].problems[0].text.contains("the server ended meanwhile"), "{again:?}");
}

#[tokio::test]
async fn an_import_waits_for_a_history_that_is_made_again() {
    let shore = Shore::with(|data| {
        let mut store = store::Store::open(data).unwrap();
        for packet in log(60_000).chunks(log(1).len()) {
            let received = units::UtcTime::from_micros(1_795_248_000_000_000);
            store
                .accept(&store::Accepted { packet, received, transport: store::Transport::Tcp, link: None })
                .unwrap();
        }
        store.close().unwrap();
        std::fs::write(data.join("history/2026-11.sqlite"), "no database").unwrap();
    })
    .await;
    let token = shore.token(None, Role::Operator).await;
    let import = ended(&shore, &token, &upload(&shore, &token, "Data.lsf", log(60_001)).await).await;
    assert_eq!((import.state, import.added, import.problems.len()), (ImportState::Done, 1, 0), "{import:?}");
    assert_eq!(samples(&shore), 60_001);
    let mut recorder = shore.state.shore.recorder.state();
    let whole = recorder.wait_for(|state| state.history_behind.is_none());
    tokio::time::timeout(DEADLINE, whole).await.unwrap().unwrap();
}

#[tokio::test]
async fn a_table_of_a_fixed_receiver_becomes_detections_by_the_register() {
    const VUE: &str = "Date and Time (UTC),Receiver,Transmitter,Transmitter Name,Transmitter Serial,Sensor Value,Sensor Unit,Station Name,Latitude,Longitude\n\
        2026-11-21 08:00:01.250,VR2W-109924,A69-1303-63366,,,,,Pier,,\n\
        2026-11-21 08:01:02.500,VR2W-109924,A69-1303-63366,,,,,Pier,,\n";
    const STATION: u16 = 0x1C01;
    let shore = Shore::with(|_| ()).await;
    let (operator, researcher) =
        (shore.token(None, Role::Operator).await, shore.token(None, Role::Researcher).await);
    let unknown = upload(&shore, &operator, "pier.csv", VUE).await;
    assert_eq!(unknown.status, StatusCode::UNPROCESSABLE_ENTITY, "{}", unknown.body);
    for told in
        ["line 2, receiver: the register does not say where the receiver VR2W-109924 was", "2 problems"]
    {
        assert!(unknown.body.contains(told), "{}", unknown.body);
    }
    assert!(is_clean(&shore));
    for entry in [
        serde_json::json!({"kind": "receiver", "serial": 109_924, "model": "VR2W"}),
        serde_json::json!({"kind": "deployment", "receiver": "VR2W-109924", "vessel": STATION,
            "from_us": 1_795_000_000_000_000_i64, "lat_deg": 63.44, "lon_deg": 10.4}),
    ] {
        let request = Request::post("/api/v1/register").header(header::CONTENT_TYPE, "application/json");
        let answer = shore.send(bearer(request, &researcher), Body::from(entry.to_string())).await;
        assert!(answer.status.is_success(), "{}", answer.body);
    }
    // A bad row behind good ones: nothing of the file is taken, and no import begins.
    let bad = format!("{VUE}2026-11-21 08:02,VR2W-109924,A69-1303-63366,,,,,Pier,,\n");
    let refused = upload(&shore, &operator, "pier.csv", bad).await;
    assert_eq!(refused.status, StatusCode::UNPROCESSABLE_ENTITY, "{}", refused.body);
    assert!(refused.body.contains("which has 1 problem:\\nline 4, "), "{}", refused.body);
    assert_eq!(shore.get("/api/v1/import", &operator).await.body, "[]");
    let first = ended(&shore, &operator, &upload(&shore, &operator, "pier.csv", VUE).await).await;
    assert_eq!((first.added, first.problems.len()), (2, 0), "both rows are new: {first:?}");
    assert_eq!((first.state, first.added, first.problems.len()), (ImportState::Done, 2, 0), "{first:?}");
    let again = ended(&shore, &operator, &upload(&shore, &operator, "pier.csv", VUE).await).await;
    assert_eq!(again.added, 0, "once, however often it comes");
    let found = shore.get("/api/v1/detections.csv?format=vue&vessel=0x1C01", &researcher).await;
    let rows: Vec<&str> = found.body.lines().skip(1).collect();
    assert_eq!(rows.len(), 2, "{}", found.body);
    assert!(rows[0].starts_with("2026-11-21 08:00:01.250,VR2W-109924,A69-1303-63366,"), "{}", rows[0]);
    assert!(rows[0].ends_with(",63.44000000,10.40000000"), "{}", rows[0]);
    for (vessel, told) in [
        ("0x1C02", "give it a name first (`lutra-server vessel add NAME 0x1C02`)"),
        ("7", "no vessel or station here has the address 0x0007"),
        ("0", "0 and 0xFFFF cannot be a vessel's address"),
        ("0xFFFF", "0 and 0xFFFF cannot be a vessel's address"),
    ] {
        let unknown = upload(&shore, &operator, &format!("x.csv&vessel={vessel}"), VUE).await;
        assert!(
            unknown.status == StatusCode::BAD_REQUEST && unknown.body.contains(told),
            "{vessel}: {}",
            unknown.body
        );
    }
    for entry in [
        serde_json::json!({"kind": "receiver", "serial": 5, "model": "VR2W"}),
        serde_json::json!({"kind": "deployment", "receiver": "VR2W-5", "vessel": 0x1C02,
            "from_us": 1_795_000_000_000_000_i64}),
    ] {
        let request = Request::post("/api/v1/register").header(header::CONTENT_TYPE, "application/json");
        let answer = shore.send(bearer(request, &researcher), Body::from(entry.to_string())).await;
        assert!(answer.status.is_success(), "{}", answer.body);
    }
    let other = upload(&shore, &operator, "x.csv&vessel=0x1C02", VUE).await;
    assert_eq!(ended(&shore, &operator, &other).await.added, 2, "of the vessel that the question names");
    let refused = upload(&shore, &operator, "x.csv", "a,b\n1,2\n").await;
    assert_eq!(refused.status, StatusCode::UNPROCESSABLE_ENTITY, "{}", refused.body);
    assert!(refused.body.contains("not the columns of a table of detections"), "{}", refused.body);
    let log_of = upload(&shore, &operator, "x.lsf&vessel=0x1C02", log(1)).await;
    assert!(
        log_of.status == StatusCode::BAD_REQUEST && log_of.body.contains("leave it out"),
        "{}",
        log_of.body
    );
    assert!(is_clean(&shore));
}
