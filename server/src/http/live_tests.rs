//! The live socket over real connections.

use super::testing::{Boats, FIRST, boat, event, voltage};
use crate::config::Config;
use crate::serve::{Serving, serve};
use api::{LiveFrame, Role};
use futures_util::{SinkExt as _, StreamExt as _};
use imc::messages::LogBookEntry;
use shore::clock;
use shore::identity::{sessions, testing, vessels};
use std::time::Duration;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::tungstenite::client::IntoClientRequest as _;
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream, connect_async};
use units::UtcTime;

/// A generous time limit.
pub(super) const DEADLINE: Duration = Duration::from_secs(20);

pub(super) struct Shore {
    pub(super) serving: Serving,
    pub(super) boats: Boats,
    folder: tempfile::TempDir,
}

pub(super) type Socket = WebSocketStream<MaybeTlsStream<TcpStream>>;

impl Shore {
    pub(super) async fn start() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let mut config = Config { data: folder.path().to_owned(), ..Config::default() };
        config.http.listen = "127.0.0.1:0".parse().unwrap();
        config.imc.active = false;
        let serving = serve(config).await.unwrap();
        let boats = Boats::join(&serving.state.shore.router).await;
        Self { serving, boats, folder }
    }

    /// A token for a new person.
    pub(super) async fn token(&self, vessel: Option<u16>, role: Role) -> String {
        testing::script(self.folder.path(), &format!("p{}", role as u8), vessel, role).await.1
    }

    /// A token for the link of a vessel.
    pub(super) async fn link_token(&self, vessel: u16) -> String {
        testing::link(self.folder.path(), vessel).await
    }

    pub(super) async fn connect(&self, header: &str, value: &str, origin: &str) -> Result<Socket, String> {
        let mut request = format!("ws://{}/api/live", self.serving.address).into_client_request().unwrap();
        request.headers_mut().insert("origin", origin.parse().unwrap());
        let name: axum::http::HeaderName = header.parse().unwrap();
        request.headers_mut().insert(name, value.parse().unwrap());
        connect_async(request).await.map(|(socket, _)| socket).map_err(|error| error.to_string())
    }

    async fn subscribed(&self, token: &str, subscription: &str) -> Socket {
        let bearer = format!("Bearer {token}");
        let mut socket = self.connect("authorization", &bearer, "http://anything").await.unwrap();
        subscribe(&mut socket, subscription).await;
        socket
    }
}

async fn subscribe(socket: &mut Socket, subscription: &str) {
    let text = format!("{{\"subscribe\":{subscription}}}");
    socket.send(Message::Text(text.into())).await.unwrap();
}

async fn frame(socket: &mut Socket) -> Option<LiveFrame> {
    loop {
        match tokio::time::timeout(DEADLINE, socket.next()).await.unwrap() {
            Some(Ok(Message::Text(text))) => return Some(serde_json::from_str(&text).unwrap()),
            Some(Ok(Message::Ping(_))) => {}
            _ => return None,
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_snapshot_comes_first_and_then_what_changes() {
    let shore = Shore::start().await;
    let token = shore.token(None, Role::Viewer).await;
    shore.boats.say(boat(0, clock::now())).await;
    let mut socket = shore.subscribed(&token, "{\"messages\":[\"Voltage\"],\"every_ms\":5}").await;
    let first = frame(&mut socket).await.unwrap();
    assert!(first.snapshot && first.systems.len() == 1 && first.values.len() == 2, "{first:?}");
    let system = &first.systems[0];
    assert_eq!((system.address, system.name.as_deref()), (FIRST, Some("otter-0")));
    assert!(system.fix.is_some_and(|fix| (fix.speed_mps.unwrap() - 1.5).abs() < 1e-3));
    shore.boats.say(boat(0, clock::now())[2..4].to_vec()).await;
    let mut next = frame(&mut socket).await.unwrap();
    while next.values.is_empty() {
        next = frame(&mut socket).await.unwrap();
    }
    assert_eq!((next.snapshot, next.values[0].abbrev.as_str(), next.values.len()), (false, "Voltage", 1));
}

#[tokio::test(flavor = "multi_thread")]
async fn an_alarm_calls_its_vessel_by_the_name_that_people_gave_it() {
    let shore = Shore::start().await;
    let token = shore.token(None, Role::Viewer).await;
    let named = vessels::Add { address: FIRST, name: "northern-otter".to_owned(), now: clock::now() };
    shore.serving.state.shore.people.change(named).await.unwrap();
    shore.boats.say(boat(0, clock::now())).await;
    let mut socket = shore.subscribed(&token, "{\"messages\":[],\"every_ms\":5}").await;
    let silent = |operations: &mut operations::Operations, now: units::Now| {
        operations.watch(
            units::Now { mono: now.mono + Duration::from_secs(20), ..now },
            &operations::alarms::ShoreState::default(),
        );
    };
    shore.serving.state.shore.router.inspect(silent).await.unwrap();
    let alarm = loop {
        let alarms = frame(&mut socket).await.unwrap().alarms;
        if let Some(alarm) = alarms.into_iter().find(|alarm| alarm.vessel == Some(FIRST)) {
            break alarm;
        }
    };
    assert_eq!(alarm.vessel_name.as_deref(), Some("northern-otter"), "{alarm:?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn what_was_replaced_is_counted_and_events_all_come() {
    let shore = Shore::start().await;
    let token = shore.token(None, Role::Viewer).await;
    let now = clock::now().micros();
    let at = |index: i64| UtcTime::from_micros(now + index * 1_000);
    let both = |index| vec![voltage(0, at(index)), event(0, at(index), LogBookEntry::default())];
    shore.boats.say(both(0)).await;
    let wanted = "{\"every_ms\":1000,\"messages\":[\"Voltage\",\"LogBookEntry\"]}";
    let mut socket = shore.subscribed(&token, wanted).await;
    let first = frame(&mut socket).await.unwrap();
    assert!(first.snapshot && first.values.len() == 2);
    let (mut skipped, mut values, mut events) = (0, 0, first.events.len());
    for index in 1..=500 {
        shore.boats.say(both(index)).await;
    }
    while events < 501 {
        let frame = frame(&mut socket).await.unwrap();
        skipped += frame.skipped;
        values += frame.values.len() as u64;
        events += frame.events.len();
    }
    assert_eq!((skipped + values, events), (1_000, 501));
    assert!(skipped > 800, "a frame a second carries the latest only, but {values} came");
}

/// A client that answers pings on request.
pub(super) struct Raw(pub(super) TcpStream);

impl Raw {
    pub(super) async fn connect(shore: &Shore, token: &str) -> Self {
        Self::to(shore, "/api/live", token).await
    }

    /// A socket of any path.
    pub(super) async fn to(shore: &Shore, path: &str, token: &str) -> Self {
        let mut stream = TcpStream::connect(shore.serving.address).await.unwrap();
        let request = format!(
            "GET {path} HTTP/1.1\r\nhost: x\r\nauthorization: Bearer {token}\r\nupgrade: websocket\r\n\
             connection: upgrade\r\nsec-websocket-key: dGhlIHNhbXBsZSBub25jZQ==\r\nsec-websocket-version: 13\r\n\r\n"
        );
        stream.write_all(request.as_bytes()).await.unwrap();
        let mut head = Vec::new();
        while !head.ends_with(b"\r\n\r\n") {
            head.push(stream.read_u8().await.unwrap());
        }
        Self(stream)
    }

    async fn subscribed(shore: &Shore, token: &str, subscription: &str) -> Self {
        let mut raw = Self::connect(shore, token).await;
        raw.say(1, format!("{{\"subscribe\":{subscription}}}").as_bytes()).await;
        raw
    }

    /// A frame of a client; the mask is zero, which leaves the bytes as they are.
    pub(super) async fn say(&mut self, opcode: u8, payload: &[u8]) {
        let mut bytes = vec![0x80 | opcode, 0x80 | u8::try_from(payload.len()).unwrap(), 0, 0, 0, 0];
        bytes.extend_from_slice(payload);
        self.0.write_all(&bytes).await.unwrap();
    }

    /// The server's next frame, with the ping after it.
    async fn frame(&mut self) -> (LiveFrame, Vec<u8>) {
        let mut said = Vec::new();
        for opcode in [1, 9] {
            assert_eq!(self.0.read_u8().await.unwrap(), 0x80 | opcode);
            let length = match self.0.read_u8().await.unwrap() {
                126 => u64::from(self.0.read_u16().await.unwrap()),
                127 => self.0.read_u64().await.unwrap(),
                short => u64::from(short),
            };
            let mut payload = vec![0; usize::try_from(length).unwrap()];
            self.0.read_exact(&mut payload).await.unwrap();
            said.push(payload);
        }
        (serde_json::from_slice(&said[0]).unwrap(), said.remove(1))
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_client_behind_a_slow_way_gets_what_is_and_no_queue_of_what_was() {
    let shore = Shore::start().await;
    let token = shore.token(None, Role::Viewer).await;
    let now = clock::now().micros();
    let at = |index: i64| UtcTime::from_micros(now + index * 1_000);
    shore.boats.say(vec![voltage(0, at(0))]).await;
    let wanted = "{\"every_ms\":2,\"messages\":[\"Voltage\"]}";
    let work = async {
        let mut client = Raw::subscribed(&shore, &token, wanted).await;
        // No ping is answered, as if nothing had arrived yet.
        let mut ping = Vec::new();
        for _ in 0..4 {
            ping = client.frame().await.1;
        }
        for index in 1..=20 {
            shore.boats.say(vec![voltage(0, at(index))]).await;
        }
        client.say(10, b"nonsense").await;
        client.say(10, &99_u64.to_be_bytes()).await;
        client.say(10, &ping).await;
        let (frame, _) = client.frame().await;
        assert_eq!((frame.values.len(), frame.skipped), (1, 19), "{frame:?}");
        assert_eq!(frame.values[0].time_us, at(20).micros());
    };
    tokio::time::timeout(DEADLINE, work).await.unwrap();
}

#[tokio::test(flavor = "multi_thread")]
async fn nobody_sees_more_than_they_may() {
    let shore = Shore::start().await;
    for number in 0..3 {
        shore.boats.say(boat(number, clock::now())).await;
    }
    let token = shore.token(Some(0x0815), Role::Viewer).await;
    let mut socket = shore.subscribed(&token, "{}").await;
    let first = frame(&mut socket).await.unwrap();
    let seen: Vec<u16> = first.systems.iter().map(|system| system.address).collect();
    assert_eq!(seen, [0x0815]);
    assert!(first.values.iter().all(|update| update.system == 0x0815) && first.values.len() > 3);
    assert!(first.events.iter().all(|event| event.system == 0x0815) && first.events.len() == 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_socket_ends_with_its_session_and_foreign_pages_get_none() {
    let shore = Shore::start().await;
    let folder = shore.folder.path();
    let (person, _) = testing::script(folder, "nils", None, Role::Viewer).await;
    let session = testing::session(folder, person).await;
    let cookie = format!("lutra_session={}", session.text());
    let own = format!("http://{}", shore.serving.address);
    assert!(shore.connect("cookie", &cookie, "http://evil.example").await.unwrap_err().contains("403"));
    assert!(shore.connect("cookie", "a=b", &own).await.unwrap_err().contains("401"));
    let mut socket = shore.connect("cookie", &cookie, &own).await.unwrap();
    subscribe(&mut socket, "{}").await;
    assert!(frame(&mut socket).await.is_some());
    // Through the server, as on the page: ended from a second session.
    let second = testing::session(folder, person).await;
    let sessions = shore.serving.state.shore.people.ask(sessions::List(Some(person))).await.unwrap();
    let first_id = sessions.iter().map(|session| session.id).min().unwrap();
    let request = format!(
        "DELETE /api/v1/sessions/{first_id} HTTP/1.1\r\nhost: {0}\r\norigin: {own}\r\nconnection: close\r\n\
         cookie: lutra_session={1}\r\nx-csrf-token: {2}\r\n\r\n",
        shore.serving.address,
        second.text(),
        second.derived("csrf"),
    );
    assert!(exchange(&shore, &request).await.starts_with("HTTP/1.1 200"));
    while frame(&mut socket).await.is_some() {}
}

#[tokio::test(flavor = "multi_thread")]
async fn what_is_not_understood_is_answered_with_the_reason() {
    let shore = Shore::start().await;
    let token = shore.token(None, Role::Viewer).await;
    for request in ["{", "{\"subscribe\":{\"system\":1}}", "{\"unsubscribe\":{}}", "null"] {
        let mut socket =
            shore.connect("authorization", &format!("Bearer {token}"), "http://a").await.unwrap();
        socket.send(Message::Text(request.into())).await.unwrap();
        let Some(Ok(Message::Close(Some(close)))) =
            tokio::time::timeout(DEADLINE, socket.next()).await.unwrap()
        else {
            panic!("{request}");
        };
        assert!(close.reason.contains("not understood"), "{request}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_request_that_is_too_large_is_told_so_by_code_and_words() {
    let shore = Shore::start().await;
    let token = shore.token(None, Role::Viewer).await;
    for message in [Message::Text(" ".repeat(64 * 1024 + 1).into()), Message::Binary(vec![0; 100_000].into())]
    {
        let mut socket =
            shore.connect("authorization", &format!("Bearer {token}"), "http://a").await.unwrap();
        socket.send(message).await.unwrap();
        let answer = tokio::time::timeout(DEADLINE, socket.next()).await.unwrap();
        let Some(Ok(Message::Close(Some(close)))) = answer else { panic!("{answer:?}") };
        assert_eq!(u16::from(close.code), 1009);
        assert!(close.reason.contains("65536 bytes at most"), "{}", close.reason);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn sockets_are_closed_when_the_server_stops() {
    let shore = Shore::start().await;
    let token = shore.token(None, Role::Viewer).await;
    let mut socket = shore.subscribed(&token, "{}").await;
    assert!(frame(&mut socket).await.is_some());
    let stopping = tokio::spawn(shore.serving.stop());
    while frame(&mut socket).await.is_some() {}
    tokio::time::timeout(DEADLINE, stopping).await.unwrap().unwrap();
}

pub(super) async fn exchange(shore: &Shore, request: &str) -> String {
    let mut stream = TcpStream::connect(shore.serving.address).await.unwrap();
    stream.write_all(request.as_bytes()).await.unwrap();
    let mut answer = Vec::new();
    tokio::time::timeout(DEADLINE, stream.read_to_end(&mut answer)).await.unwrap().unwrap();
    String::from_utf8_lossy(&answer).into_owned()
}

/// Undoes the compact form of a connection.
struct Inflate(flate2::Decompress);

impl Inflate {
    fn new() -> Self {
        Self(flate2::Decompress::new(false))
    }

    /// The frame of a message, and all of it.
    fn frame(&mut self, message: &[u8]) -> LiveFrame {
        let mut text = Vec::with_capacity(4 << 20);
        let before = self.0.total_in();
        self.0.decompress_vec(message, &mut text, flate2::FlushDecompress::Sync).unwrap();
        assert_eq!(usize::try_from(self.0.total_in() - before).unwrap(), message.len());
        assert_eq!(text.pop(), Some(b'\n'), "a message holds one whole frame");
        serde_json::from_slice(&text).unwrap()
    }

    async fn next(&mut self, socket: &mut Socket) -> LiveFrame {
        loop {
            match tokio::time::timeout(DEADLINE, socket.next()).await.unwrap() {
                Some(Ok(Message::Binary(bytes))) => return self.frame(&bytes),
                Some(Ok(Message::Ping(_))) => {}
                other => panic!("{other:?}"),
            }
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn the_compact_form_says_the_same_and_names_a_series_once() {
    let shore = Shore::start().await;
    let token = shore.token(None, Role::Viewer).await;
    shore.boats.say(boat(0, clock::now())).await;
    let mut plain = shore.subscribed(&token, "{\"every_ms\":5}").await;
    let mut compact = shore.subscribed(&token, "{\"every_ms\":5,\"compact\":true}").await;
    let mut inflate = Inflate::new();
    let (whole, short) = (frame(&mut plain).await.unwrap(), inflate.next(&mut compact).await);
    assert!(short.snapshot && short.values.is_empty() && short.series.len() == whole.values.len());
    for (value, (series, sample)) in whole.values.iter().zip(short.series.iter().zip(&short.samples)) {
        assert_eq!((series.series, series.abbrev.as_str()), (sample.series, value.abbrev.as_str()));
        assert_eq!(
            (series.system, series.entity, series.instance),
            (value.system, value.entity, value.instance)
        );
        assert_eq!(
            (sample.time_us, sample.received_us, sample.count),
            (value.time_us, value.received_us, value.count)
        );
        let fields = series.names.iter().zip(&series.units).zip(&sample.values);
        let fields: Vec<_> = fields.map(|((name, unit), value)| (name, unit, value)).collect();
        let wanted: Vec<_> =
            value.fields.iter().map(|field| (&field.name, &field.unit, &field.value)).collect();
        assert_eq!(fields, wanted);
        let meanings: Vec<_> = value.fields.iter().map(|field| field.meaning.clone()).collect();
        assert!(
            sample.meanings == meanings
                || (sample.meanings.is_empty() && meanings.iter().all(Option::is_none))
        );
    }
    // Known series are not described again, until everything starts over.
    shore.boats.say(boat(0, clock::now())[2..4].to_vec()).await;
    let mut next = inflate.next(&mut compact).await;
    while next.samples.is_empty() {
        next = inflate.next(&mut compact).await;
    }
    assert!(next.series.is_empty(), "{:?}", next.series);
    let of = |sample: &api::LiveSample| short.series[sample.series as usize].abbrev.as_str();
    assert!(next.samples.iter().all(|one| ["EstimatedState", "Voltage"].contains(&of(one))), "{next:?}");
    subscribe(&mut compact, "{\"every_ms\":5,\"compact\":true,\"messages\":[\"Voltage\"]}").await;
    let mut again = inflate.next(&mut compact).await;
    while !again.snapshot {
        again = inflate.next(&mut compact).await;
    }
    assert!(again.series.len() == again.samples.len() && !again.series.is_empty(), "{again:?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn of_systems_that_are_not_listed_only_what_is_asked_for_comes() {
    let shore = Shore::start().await;
    let token = shore.token(None, Role::Viewer).await;
    for index in [0, 1] {
        shore.boats.say(boat(index, clock::now())).await;
    }
    let asked = format!("{{\"systems\":[{FIRST}],\"of_others\":[\"Voltage\"],\"every_ms\":5}}");
    let mut socket = shore.subscribed(&token, &asked).await;
    let first = frame(&mut socket).await.unwrap();
    let of = |address: u16| {
        let values = first.values.iter().filter(move |value| value.system == address);
        values.map(|value| value.abbrev.as_str()).collect::<std::collections::BTreeSet<_>>()
    };
    assert_eq!(first.systems.len(), 2);
    assert!(of(FIRST).len() > 1, "{:?}", of(FIRST));
    assert_eq!(of(FIRST + 1), ["Voltage"].into());
}
