//! `imc listen` and `imc send` with real sockets on loopback, ports chosen by the system.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod harness;

use harness::{PATIENCE, Running, heartbeat, run};
use imc::messages::{Announce, EntityList, EntityListOp};
use imc::{Address, Header, Packet};
use std::io::{Read as _, Write as _};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream, UdpSocket};

fn udp() -> (UdpSocket, u16) {
    let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    socket.set_read_timeout(Some(PATIENCE)).unwrap();
    let port = socket.local_addr().unwrap().port();
    (socket, port)
}

fn received(socket: &UdpSocket) -> (Packet, SocketAddr) {
    let mut buffer = [0; 2048];
    let (count, from) = socket.recv_from(&mut buffer).unwrap();
    (Packet::decode(&buffer[..count]).unwrap(), from)
}

fn tcp() -> (TcpListener, String) {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    let address = listener.local_addr().unwrap().to_string();
    (listener, address)
}

fn entity_list(list: &str) -> Vec<u8> {
    let header = Header { timestamp: 5.0, src: Address(0x2810), src_ent: 0, ..Header::default() };
    Packet::new(header, EntityList { op: EntityListOp::Report, list: list.into() }).encode().unwrap()
}

/// The ports of `listening on 127.0.0.1:6001, announcements on port 30100; known as 0x4001`.
fn ports(remark: &str) -> (u16, u16) {
    let number = |after: &str| {
        let digits = remark.split_once(after).unwrap().1;
        digits.split(|letter: char| !letter.is_ascii_digit()).next().unwrap().parse().unwrap()
    };
    (number("127.0.0.1:"), number("announcements on port "))
}

const OWN_PORTS: [&str; 4] = ["--port", "0", "--announce-port", "0"];

#[test]
fn listen_udp_announces_itself_and_shows_what_a_vehicle_sends() {
    let (vehicle, port) = udp();
    let to = format!("127.0.0.1:{port}");
    let arguments =
        [&["listen", "udp", "--to", &to, "--name", "shore", "--count", "2"], &OWN_PORTS[..]].concat();
    let listen = Running::start(&arguments);
    let (announce, from) = received(&vehicle);
    assert_eq!(announce.header.src, Address(0x4001));
    let announce = announce.get::<Announce>().unwrap();
    assert_eq!(announce.sys_name, "shore");
    let service =
        imc::services::udp_socket(announce.services.as_str().unwrap(), std::net::Ipv4Addr::LOCALHOST)
            .unwrap();
    assert_eq!(SocketAddr::from(service), from);
    assert_eq!(received(&vehicle).0.id(), 150);
    vehicle.send_to(&heartbeat(7.0), from).unwrap();
    assert_eq!(listen.json()["header"]["timestamp"], 7.0);
    // The next heartbeat comes automatically.
    assert_eq!(received(&vehicle).0.id(), 150);
    vehicle.send_to(&entity_list("Daemon=0"), from).unwrap();
    assert_eq!(listen.json()["fields"]["list"], "Daemon=0");
    assert_eq!(listen.finish(), (0, Vec::new()));
}

#[test]
fn listen_udp_learns_the_data_port_from_the_vehicles_announcement() {
    let (vehicle, port) = udp();
    let listen = Running::start(&[&["listen", "udp", "--to", "127.0.0.1"], &OWN_PORTS[..]].concat());
    let (_, discovery) = ports(&listen.remark("listening on"));
    let announce = Announce {
        sys_name: "ntnu-otter-01".into(),
        services: format!("imc+udp://127.0.0.1:{port}/").into(),
        ..Announce::default()
    };
    let header = Header { timestamp: 1.0, src: Address(0x2810), dst: Address::ANNOUNCE, ..Header::default() };
    let packet = Packet::new(header, announce).encode().unwrap();
    vehicle.send_to(&packet, (Ipv4Addr::LOCALHOST, discovery)).unwrap();
    assert_eq!(listen.json()["abbrev"], "Announce");
    assert_eq!(received(&vehicle).0.id(), 150);
}

#[test]
fn listen_udp_tells_damage_with_its_sender_and_sends_nothing_unasked() {
    let (vehicle, port) = udp();
    let listen =
        Running::start(&[&["listen", "udp", "-m", "EntityList", "-n", "1"], &OWN_PORTS[..]].concat());
    let (data, _) = ports(&listen.remark("listening on"));
    listen.remark("this console announces itself to no one");
    let mut broken = entity_list("a=1");
    broken[24] ^= 1;
    for datagram in [&broken, &heartbeat(1.0), &entity_list("b=2")] {
        vehicle.send_to(datagram, (Ipv4Addr::LOCALHOST, data)).unwrap();
    }
    let damage = listen.json();
    assert_eq!((&damage["error"], &damage["from"]), (&"bad_crc".into(), &format!("127.0.0.1:{port}").into()));
    assert_eq!(listen.json()["fields"]["list"], "b=2");
    assert_eq!(listen.finish(), (1, Vec::new()));
    vehicle.set_nonblocking(true).unwrap();
    assert!(vehicle.recv(&mut [0; 64]).is_err());
}

#[test]
fn listen_tcp_shows_packets_however_they_are_cut_and_ends_when_told() {
    let (listener, address) = tcp();
    let listen = Running::start(&["listen", "tcp", &address, "--once"]);
    let (mut server, _) = listener.accept().unwrap();
    let (first, second) = (heartbeat(1.0), heartbeat(2.0));
    server.write_all(&[&first[..], b"salmon", &second[..9]].concat()).unwrap();
    assert_eq!(listen.json()["header"]["timestamp"], 1.0);
    server.write_all(&second[9..]).unwrap();
    let damage = listen.json();
    assert_eq!(
        (&damage["error"], &damage["offset"], &damage["from"]),
        (&"bad_sync".into(), &22.into(), &address.as_str().into())
    );
    assert_eq!(listen.json()["header"]["timestamp"], 2.0);
    drop(server);
    assert_eq!(listen.finish(), (1, Vec::new()));
}

#[test]
fn listen_tcp_connects_again_when_the_link_is_lost() {
    let (listener, address) = tcp();
    let listen = Running::start(&["listen", "tcp", &address, "--count", "2"]);
    for time in [1.0, 2.0] {
        let (mut server, _) = listener.accept().unwrap();
        server.write_all(&heartbeat(time)).unwrap();
        assert_eq!(listen.json()["header"]["timestamp"], time);
    }
    listen.remark("trying again in");
    assert_eq!(listen.finish(), (0, Vec::new()));
}

#[test]
fn listen_filters_and_saves_the_bytes_as_they_came() {
    let (listener, address) = tcp();
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("run.lsf");
    let log_name = log.to_str().unwrap();
    let arguments =
        ["listen", "tcp", &address, "-m", "entitylist", "-s", "0x2810", "-n", "2", "--save", log_name];
    let listen = Running::start(&arguments);
    let (mut server, _) = listener.accept().unwrap();
    let (first, second) = (entity_list("a=1"), entity_list("b=2"));
    server.write_all(&[&first[..], &heartbeat(1.0), &second].concat()).unwrap();
    assert_eq!(listen.json()["fields"]["list"], "a=1");
    assert_eq!(listen.json()["fields"]["list"], "b=2");
    assert_eq!(listen.finish(), (0, Vec::new()));
    assert_eq!(std::fs::read(&log).unwrap(), [first, second].concat());
    // A recording is never overwritten.
    let again = run(&arguments, b"").expect(2);
    assert!(again.stderr.contains("never overwritten"), "{}", again.stderr);
}

#[test]
fn listen_stops_in_time() {
    let (_listener, address) = tcp();
    assert!(run(&["listen", "tcp", &address, "--for", "0.2"], b"").expect(0).stdout.is_empty());
    let quiet = [&["listen", "udp", "--for", "0.2"], &OWN_PORTS[..]].concat();
    assert!(run(&quiet, b"").expect(0).stdout.is_empty());
}

#[test]
fn links_that_cannot_be_made_are_told() {
    let (listener, address) = tcp();
    drop(listener);
    for arguments in [
        &["listen", "tcp", &address, "--once"][..],
        &["listen", "ws", &format!("ws://{address}"), "--once"],
        &["send", "tcp", &address, "--message", "Abort"],
    ] {
        let done = run(arguments, b"").expect(2);
        assert!(done.stderr.contains(&format!("cannot connect to {address}")), "{}", done.stderr);
    }
}

#[test]
fn listen_ws_shows_messages_from_a_proxy() {
    let (listener, address) = tcp();
    let listen = Running::start(&["listen", "ws", &format!("ws://{address}/any?x=1"), "--once"]);
    let (stream, _) = listener.accept().unwrap();
    let mut server = tungstenite::accept(stream).unwrap();
    server.send(heartbeat(1.0).into()).unwrap();
    server.send("no packet".into()).unwrap();
    server.send(heartbeat(2.0).into()).unwrap();
    assert_eq!(listen.json()["header"]["timestamp"], 1.0);
    assert_eq!(listen.json()["header"]["timestamp"], 2.0);
    listen.remark("text messages");
    server.close(None).unwrap();
    while server.read().is_ok() {}
    assert_eq!(listen.finish(), (0, Vec::new()));
}

#[test]
fn send_udp_reaches_this_computer_only_unless_told() {
    let (vehicle, port) = udp();
    let to = format!("127.0.0.1:{port}");
    let sent = [
        "send",
        "udp",
        "--to",
        &to,
        "--dst",
        "ntnu-otter-01",
        "--message",
        "plancontrol",
        "op=STOP",
        "request_id=7",
    ];
    run(&sent, b"").expect(0);
    let (packet, _) = received(&vehicle);
    assert_eq!((packet.header.src, packet.header.dst), (Address(0x4001), Address(0x2810)));
    assert!(packet.header.timestamp > 1.7e9);
    let control = packet.get::<imc::messages::PlanControl>().unwrap();
    assert_eq!(control.request_id, 7);
    for (to, hint) in
        [("255.255.255.255", "--broadcast"), ("224.0.75.69", "--broadcast"), ("192.0.2.1", "--bind 0.0.0.0")]
    {
        let refused = run(&["send", "udp", "--to", to, "--message", "Abort"], b"").expect(2);
        assert!(refused.stderr.contains(hint), "{}", refused.stderr);
        let refused = run(&[&["listen", "udp", "--to", to], &OWN_PORTS[..]].concat(), b"").expect(2);
        assert!(refused.stderr.contains(hint), "{}", refused.stderr);
    }
}

#[test]
fn send_udp_announces_and_prints_the_replies_that_were_asked_for() {
    let (vehicle, port) = udp();
    let to = format!("127.0.0.1:{port}");
    let send = Running::start(&[
        "send",
        "udp",
        "--to",
        &to,
        "--announce",
        "--message",
        "EntityList",
        "op=QUERY",
        "--wait",
        "0.5",
        "--reply",
        "EntityList",
    ]);
    assert_eq!(received(&vehicle).0.id(), 151);
    let (query, from) = received(&vehicle);
    assert_eq!(query.get::<EntityList>().unwrap().op, EntityListOp::Query);
    vehicle.send_to(&heartbeat(1.0), from).unwrap();
    vehicle.send_to(&entity_list("a=1"), from).unwrap();
    assert_eq!(send.json()["fields"]["list"], "a=1");
    assert_eq!(send.finish(), (0, Vec::new()));
}

#[test]
fn send_tcp_takes_lines_fills_what_they_leave_out_and_reports_bad_ones() {
    let (listener, address) = tcp();
    let server = std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        // A server that sends all the time must not cause the loss of the client's last bytes.
        stream.write_all(&heartbeat(1.0).repeat(100)).unwrap();
        let mut bytes = Vec::new();
        stream.read_to_end(&mut bytes).unwrap();
        bytes
    });
    let lines = "{\"abbrev\":\"Abort\"}\n{\"abbrev\":\"Abortion\"}\n\
        {\"abbrev\":\"Abort\",\"header\":{\"timestamp\":3,\"src\":\"0x4002\",\"dst\":5}}\n";
    let done =
        run(&["send", "tcp", &address, "--src", "0x4003", "--dst-ent", "9"], lines.as_bytes()).expect(1);
    assert!(
        done.stderr.contains("standard input:2: abbrev") && done.stderr.contains("(not sent)"),
        "{}",
        done.stderr
    );
    let bytes = server.join().unwrap();
    let shown = run(&["decode"], &bytes).expect(0).lines();
    assert_eq!(shown.len(), 2);
    assert_eq!((&shown[0]["header"]["src"], &shown[0]["header"]["dst_ent"]), (&0x4003.into(), &9.into()));
    assert_eq!((&shown[1]["header"]["timestamp"], &shown[1]["header"]["src"]), (&3.0.into(), &0x4002.into()));
}

#[test]
fn send_ws_sends_one_packet_a_message() {
    let (listener, address) = tcp();
    let server = std::thread::spawn(move || {
        let (stream, _): (TcpStream, _) = listener.accept().unwrap();
        let mut socket = tungstenite::accept(stream).unwrap();
        let packet = socket.read().unwrap().into_data();
        socket.send(packet.clone().into()).unwrap();
        while socket.read().is_ok() {}
        packet
    });
    let url = format!("ws://{address}");
    let done =
        run(&["send", "ws", &url, "--message", "Temperature", "value=NaN", "--wait", "0.5"], b"").expect(0);
    assert_eq!(done.lines()[0]["fields"]["value"], "NaN");
    assert_eq!(Packet::decode(&server.join().unwrap()).unwrap().id(), 263);
}

#[test]
fn mistakes_in_a_message_are_told_before_anybody_is_called() {
    for (fields, told) in [
        (&["PlanControll"][..], "did you mean `PlanControl`"),
        (&["PlanControl", "operation=STOP"], "has no field `operation`; it has type, op"),
        (&["PlanControl", "op=WAIT"], "none of START, STOP, LOAD, GET"),
        (&["PlanControl", "op"], "expected FIELD=VALUE"),
        (&["PlanControl", "arg=salmon"], "expected JSON"),
        (&["PlanControl", "op=STOP", "op=STOP"], "given twice"),
        (&["Abort", "now=1"], "has no fields"),
    ] {
        let done = run(&[&["send", "tcp", "127.0.0.1:1", "--message"], fields].concat(), b"").expect(2);
        assert!(done.stderr.contains(told), "{}", done.stderr);
    }
    for arguments in [
        &["listen", "ws", "wss://127.0.0.1:1", "--once"][..],
        &["listen", "ws", "127.0.0.1:1", "--once"],
        &["listen", "tcp", "127.0.0.1", "--once"],
        &["listen", "tcp", "127.0.0.1:1", "--for", "-1"],
        &["listen", "tcp", "127.0.0.1:1", "--count", "0"],
        &["listen", "udp", "--to", "host:port"],
        &["listen", "udp", "--message", "Salmon"],
        &["listen"],
        &["send", "udp", "/no/such/file"],
    ] {
        run(arguments, b"").expect(2);
    }
}
