//! The memory of a real server that is attacked: floods of logins, sockets that ping and are never read, texts and names
//! as long as packets may be. It stays within 100 MB of its value at rest.

use crate::support::program::{Server, add_admin, link_token, run};
use futures_util::SinkExt as _;
use imc::messages::{Announce, LogBookEntry, Message};
use imc::{Address, Header, Packet};
use std::io::{Read as _, Write as _};
use std::net::{Ipv4Addr, SocketAddr, TcpStream};
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use tempfile::TempDir;
use tokio_tungstenite::tungstenite::Message as Frame;

/// Most memory that an attack may cost.
const MOST_BYTES: u64 = 100 << 20;
/// How long a write to a peer that does not read may take.
const PATIENCE: Duration = Duration::from_secs(2);

/// A socket that pings and reads no answer until the server stops reading, or `most_bytes` are sent.
fn ping_without_reading(server: SocketAddr, path: &str, token: &str, most_bytes: usize) -> TcpStream {
    let mut stream = TcpStream::connect(server).unwrap();
    stream.set_write_timeout(Some(PATIENCE)).unwrap();
    write!(
        stream,
        "GET {path} HTTP/1.1\r\nHost: boat\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nAuthorization: Bearer {token}\r\n\
         Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
    )
    .unwrap();
    let pings = [&[0x89, 0xFD, 0, 0, 0, 0][..], &[7; 125]].concat().repeat(500);
    let mut sent = 0;
    while sent < most_bytes && stream.write_all(&pings).is_ok() {
        sent += pings.len();
    }
    stream
}

/// A login with a wrong password, from an address and to an account that no limit knows.
fn login(server: SocketAddr, cookie: &str, csrf: &str, number: u32) -> TcpStream {
    let socket = socket2::Socket::new(socket2::Domain::IPV4, socket2::Type::STREAM, None).unwrap();
    socket.bind(&SocketAddr::from((Ipv4Addr::from_bits(0x7F02_0000 + number), 0)).into()).unwrap();
    socket.connect(&server.into()).unwrap();
    let mut stream = TcpStream::from(socket);
    let body = format!("name=person{number}&password=seven+large+boats&csrf={csrf}&next=");
    write!(
        stream,
        "POST /login HTTP/1.0\r\nhost: {server}\r\norigin: http://{server}\r\ncookie: lutra_login={cookie}\r\n\
         content-type: application/x-www-form-urlencoded\r\ncontent-length: {}\r\n\r\n{body}",
        body.len()
    )
    .unwrap();
    stream
}

/// The cookie and the token of the login's form.
fn form(server: SocketAddr) -> (String, String) {
    let mut page = TcpStream::connect(server).unwrap();
    write!(page, "GET /login HTTP/1.0\r\nhost: {server}\r\n\r\n").unwrap();
    let mut text = String::new();
    page.read_to_string(&mut text).unwrap();
    let cut = |from: &str, to: char| text.split_once(from).unwrap().1.split(to).next().unwrap().to_owned();
    (cut("lutra_login=", ';'), cut("name=\"csrf\" value=\"", '"'))
}

/// A packet of a made-up system. Each comes once, and as if from now.
fn packet(number: u32, message: impl Into<Message>) -> Frame {
    let src = Address(0x3000 + (number % 5_000) as u16);
    let timestamp = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_secs_f64();
    let header = Header { timestamp, src, ..Header::default() };
    Frame::Binary(Packet::new(header, message.into()).encode().unwrap().into())
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_attack_takes_no_more_than_a_hundred_megabytes() {
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("data");
    add_admin(&data, "nils", "seven small boats");
    let link = link_token(&data, "otter-1", "0x2810");
    let operator =
        run(&data, &["token", "create", "--person", "nils", "--role", "operator"]).trim().to_owned();
    let server = Server::start(&data);
    let (cookie, csrf) = form(server.web);
    let idle = server.process.resident_bytes();
    let most = |what: &str| {
        let now = server.process.resident_bytes();
        println!("{what}: {} MB at rest, {} MB now", idle >> 20, now >> 20);
        assert!(now < idle + MOST_BYTES, "{what}: {idle} bytes at rest, {now} now");
    };

    // Each is answered before the next hundred: this measures memory that is retained, and memory held at once.
    for hundred in 0..2 {
        let guesses: Vec<TcpStream> =
            (0..100).map(|n| login(server.web, &cookie, &csrf, hundred * 100 + n)).collect();
        most("with logins under way");
        for mut guess in guesses {
            guess.set_read_timeout(Some(crate::support::PATIENCE)).unwrap();
            guess.read_to_end(&mut Vec::new()).unwrap();
        }
    }
    most("after 200 wrong logins");

    let steering = "/api/v1/vessels/2049/teleop";
    let sockets: Vec<TcpStream> = [("/api/live", &operator), (steering, &operator), ("/link", &link)]
        .into_iter()
        .flat_map(|(path, token)| (0..3).map(move |_| (path, token)))
        .map(|(path, token)| ping_without_reading(server.web, path, token, 48 << 20))
        .collect();
    most("beside sockets that ping and are not read");

    drop(sockets);

    let (mut peer, _) = tokio_tungstenite::connect_async(format!("ws://{}", server.proxy)).await.unwrap();
    let long = "t".repeat(60_000);
    for number in 0..1_000 {
        let entry = LogBookEntry { text: long.as_str().into(), ..LogBookEntry::default() };
        peer.send(packet(number, entry)).await.unwrap();
        if number % 250 == 249 {
            most(&format!("after {} MB of texts", (number + 1) * 60 / 1_000));
        }
    }
    let name = "n".repeat(10_000);
    for number in 0..5_000 {
        let announce = Announce { sys_name: name.as_str().into(), ..Announce::default() };
        peer.send(packet(number, announce)).await.unwrap();
    }
    most("after 5 000 systems with names of 10 kB");
}
