//! A server whose owners panic, or hang.

use super::{Serving, serve, serve_by};
use crate::config::{Config, Tls};
use crate::http::health;
use crate::http::testing::{Boats, FIRST, boat};
use http_body_util::BodyExt as _;
use hyper_util::rt::TokioIo;
use shore::clock::{self, Clock};
use std::path::Path;
use std::time::Duration;

async fn start(folder: &Path) -> Serving {
    let mut config = Config { data: folder.to_owned(), ..Config::default() };
    config.http.listen = "127.0.0.1:0".parse().unwrap();
    config.imc.active = false;
    config.transports.udp.listen = "127.0.0.1:0".to_owned().try_into().unwrap();
    config.transports.imcproxy.listen = "127.0.0.1:0".to_owned().try_into().unwrap();
    // No program listens there; the transport keeps trying.
    config.transports.tcp.connect = vec!["127.0.0.1:9".to_owned()];
    serve(config).await.unwrap()
}

async fn get(serving: &Serving, path: &str) -> (u16, String) {
    let stream = tokio::net::TcpStream::connect(serving.address).await.unwrap();
    let (mut sender, connection) = hyper::client::conn::http1::handshake(TokioIo::new(stream)).await.unwrap();
    tokio::spawn(connection);
    let request = hyper::Request::get(path).header("host", "boat").body(String::new()).unwrap();
    let response = sender.send_request(request).await.unwrap();
    let status = response.status().as_u16();
    let body = response.into_body().collect().await.unwrap().to_bytes();
    (status, String::from_utf8_lossy(&body).into_owned())
}

/// Makes the owner of this name panic, as a bug would.
async fn lose(serving: &Serving, owner: &str) {
    let state = serving.state.clone();
    match owner {
        "the hub" => {
            let lost = state.shore.router.inspect(|_, _| -> () { panic!("a fault in the hub") }).await;
            assert!(lost.is_err());
        }
        "the recorder" => {
            let lost = state.shore.recorder.with_store(|_| -> () { panic!("a fault in the recorder") }).await;
            assert!(lost.is_none(), "who asks gets an answer all the same");
        }
        "app.db" => {
            assert!(state.shore.people.lose_writer().await.is_err(), "who asks gets an answer all the same");
        }
        "the hashing of passwords" => state.shore.people.lose_hashing(),
        watched => assert!(serving.state.shore.owners.lose(watched), "{watched}"),
    }
}

/// Number of the boat's packets in the archive.
fn kept(folder: &Path) -> usize {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let count = |path: &Path| {
        let mut deframer = imc::Deframer::new();
        deframer.push(&std::fs::read(path).unwrap());
        let mut count = 0;
        while let Some(frame) = deframer.next_frame() {
            count += usize::from(matches!(frame, imc::Frame::Packet { view, .. } if view.src().0 == FIRST));
        }
        count
    };
    entries
        .map(|path| match path.file_name().and_then(|name| name.to_str()) {
            _ if path.is_dir() => kept(&path),
            Some("Data.lsf") => count(&path),
            _ => 0,
        })
        .sum()
}

#[tokio::test(flavor = "multi_thread")]
async fn an_owner_lost_to_a_fault_ends_the_server_and_what_was_heard_is_kept() {
    for owner in [
        "the hub",
        "the recorder",
        "app.db",
        "the hashing of passwords",
        "the audit log",
        "the log of orders",
    ] {
        let folder = tempfile::tempdir().unwrap();
        let serving = start(folder.path()).await;
        assert_eq!(get(&serving, "/healthz").await.0, 200);
        assert_eq!(get(&serving, "/readyz").await.0, 200);
        let boats = Boats::join(&serving.state.shore.router).await;
        let said = boat(0, clock::now());
        boats.say(said.clone()).await;
        // The hub works in order, and passes records on before it takes requests that follow its answer: after the second
        // answer the recorder has the packets.
        for _ in 0..2 {
            serving.state.shore.router.inspect(|_, _| ()).await.unwrap();
        }
        lose(&serving, owner).await;
        assert_eq!(serving.failed().await, owner);
        let (status, body) = get(&serving, "/healthz").await;
        assert!(status == 503 && body.contains(&format!("{owner} was lost to a fault")), "{status} {body}");
        assert_eq!(get(&serving, "/readyz").await.0, 503);
        serving.stop().await;
        assert_eq!(kept(folder.path()), said.len(), "{owner}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn whatever_the_server_cannot_do_without_is_watched() {
    for owner in [
        "the web server",
        "the log of orders",
        "the audit log",
        "the look for changes of app.db",
        "the watch for alarms",
        "the messages about alarms",
        "the list of alarms",
        "the UDP transport",
        "the UDP reader",
        "the IMCProxy transport",
        "the TCP transport",
    ] {
        let folder = tempfile::tempdir().unwrap();
        let serving = start(folder.path()).await;
        let lost = async {
            // Some begin a moment later.
            while !serving.state.shore.owners.lose(owner) {
                tokio::time::sleep(std::time::Duration::from_millis(5)).await;
            }
            serving.failed().await
        };
        let lost = tokio::time::timeout(std::time::Duration::from_secs(20), lost).await;
        assert_eq!(lost.expect(owner), owner);
        let trouble = serving.state.shore.owners.trouble().unwrap();
        assert!(trouble.contains(&format!("{owner} was lost to a fault")), "{trouble}");
        serving.stop().await;
    }
}

/// The alarm of the certificate, once it has this priority.
async fn certificate_alarm(serving: &Serving, priority: &str) -> api::Alarm {
    let look = async {
        loop {
            let all = serving.state.shore.alarms.list(shore::Wanted::default()).await.unwrap().standing;
            let found = all.into_iter().find(|one| one.kind == "certificate" && one.priority == priority);
            if let Some(found) = found {
                return found;
            }
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    };
    let found = tokio::time::timeout(Duration::from_secs(30), look).await;
    found.unwrap_or_else(|_| panic!("no {priority} of the certificate"))
}

#[tokio::test(flavor = "multi_thread")]
async fn a_certificate_that_ends_is_an_alarm_a_check_and_a_figure() {
    let folder = tempfile::tempdir().unwrap();
    let made = crate::tls::authority::make(
        &folder.path().join("tls"),
        &["localhost".to_owned()],
        false,
        shore::clock::now(),
    )
    .unwrap();
    let mut config = Config { data: folder.path().to_owned(), ..Config::default() };
    config.http.listen = "127.0.0.1:0".parse().unwrap();
    config.imc.active = false;
    config.tls = Tls { certificate: made.certificate.clone(), key: made.key };
    let (clock, hand) = Clock::with_hand();
    let serving = serve_by(clock, config).await.unwrap();
    let all = serving.state.shore.alarms.list(shore::Wanted::default()).await.unwrap().standing;
    assert!(all.iter().all(|one| one.kind != "certificate"), "{all:?}");
    // 820 days after it was made it ends.
    for (days, priority) in [(796, "caution"), (21, "warning"), (5, "alarm")] {
        hand.advance(Duration::from_secs(days * 86_400));
        let told = certificate_alarm(&serving, priority).await;
        assert!(told.text.contains(&made.certificate.display().to_string()), "{}", told.text);
        assert!(told.action.contains("lutra-server tls renew"), "{}", told.action);
    }
    let answer = health::metrics(axum::extract::State(serving.state.clone())).await;
    let text = answer.into_body().collect().await.unwrap().to_bytes();
    let text = String::from_utf8_lossy(&text).into_owned();
    let figure = |name: &str| -> f64 {
        let line = text.lines().find_map(|line| line.strip_prefix(name)?.trim().parse().ok());
        line.unwrap_or_else(|| panic!("{name} is not in\n{text}"))
    };
    let left_days = figure("lutra_certificate_expiry_seconds ") / 86_400.0;
    assert!((-3.0..=-1.0).contains(&left_days), "{left_days}");
    assert!(figure("lutra_certificate_trouble ") < 0.5);
    serving.stop().await;
}

#[tokio::test]
async fn a_backup_disk_that_is_away_is_a_figure_and_a_check() {
    let folder = tempfile::tempdir().unwrap();
    let mut config = Config { data: folder.path().join("data"), ..Config::default() };
    config.http.listen = "127.0.0.1:0".parse().unwrap();
    config.imc.active = false;
    config.backup.folder = folder.path().join("backup");
    let serving = serve_by(Clock::real(), config).await.unwrap();
    let mut looked = None;
    for _ in 0..3_000 {
        looked = serving.state.backup.state();
        if looked.is_some() {
            break;
        }
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    let trouble = looked.unwrap().trouble.unwrap();
    assert!(trouble.contains("is its own disk mounted?"), "{trouble}");
    let answer = health::metrics(axum::extract::State(serving.state.clone())).await;
    let text = answer.into_body().collect().await.unwrap().to_bytes();
    assert!(String::from_utf8_lossy(&text).contains("lutra_backup_trouble 1"));
    serving.stop().await;
}
