//! The UDP and TCP doors against nodes that behave as DUNE does.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

mod support;

use imc::messages::{self, Announce, Payload as _, SystemType};
use imc::{Address, PacketView};
use std::net::SocketAddr;
use support::{CONSOLE, Client, OTTER, PATIENCE, Shore, packet};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::{TcpListener, TcpStream, UdpSocket};

/// The next datagram of a message that is awaited.
async fn datagram(socket: &UdpSocket, id: u16) -> (Vec<u8>, SocketAddr) {
    let next = async {
        let mut buffer = vec![0; 65_536];
        loop {
            let (length, from) = socket.recv_from(&mut buffer).await.unwrap();
            if PacketView::new(&buffer[..length]).is_ok_and(|view| view.id() == id) {
                return (buffer[..length].to_vec(), from);
            }
        }
    };
    tokio::time::timeout(PATIENCE, next).await.unwrap()
}

fn announce(name: &str, kind: SystemType, at: SocketAddr) -> Announce {
    let services = format!("dune://0.0.0.0/uid/1;imc+udp://{at}/");
    Announce {
        sys_name: name.into(),
        sys_type: kind,
        services: services.as_str().into(),
        ..Announce::default()
    }
}

#[tokio::test]
async fn a_vehicle_on_the_network_streams_and_obeys() {
    let vehicle = UdpSocket::bind("127.0.0.1:0").await.unwrap();
    let at = vehicle.local_addr().unwrap();
    let shore = Shore::start(|config| {
        config.imc.active = true;
        config.doors.udp.listen = "127.0.0.1:0".to_owned().try_into().unwrap();
        // The vehicle's own socket stands for a discovery port, so that it hears the server's announcement.
        config.doors.udp.announce_ports = vec![0, at.port()];
    })
    .await;
    let mut console = Client::connect(shore.proxy()).await;
    let (announced, from) = datagram(&vehicle, Announce::ID).await;
    let ours = imc::decode::<Announce>(&PacketView::new(&announced).unwrap()).unwrap().unwrap();
    let services = ours.services.to_str_lossy().into_owned();
    assert_eq!(services, format!("imc+udp://{from}/"));
    assert_eq!(Some(from), shore.serving.doors.udp);

    // Telemetry of who did not announce itself goes nowhere; afterwards it does.
    let voltage = |time| packet(OTTER, Address::NULL, time, messages::Voltage { value: 12.0 });
    vehicle.send_to(&voltage(1.0), from).await.unwrap();
    let hello = packet(OTTER, Address::ANNOUNCE, 2.0, announce("otter-1", SystemType::Usv, at));
    vehicle.send_to(&hello, from).await.unwrap();
    vehicle.send_to(&voltage(3.0), from).await.unwrap();
    let mut heard = Vec::new();
    while heard.last() != Some(&voltage(3.0)) {
        heard.push(console.hear().await);
    }
    assert!(heard.contains(&hello) && !heard.contains(&voltage(1.0)));

    // It is kept sending, is asked for its entities and gets what is for it.
    datagram(&vehicle, messages::Heartbeat::ID).await;
    datagram(&vehicle, messages::EntityList::ID).await;
    let abort = packet(CONSOLE, OTTER, 4.0, messages::Abort);
    console.say(&abort).await;
    assert_eq!(datagram(&vehicle, messages::Abort::ID).await.0, abort);

    // It speaks for itself only.
    let forged = packet(Address(0x2811), Address::NULL, 5.0, messages::Voltage { value: 1.0 });
    vehicle.send_to(&forged, from).await.unwrap();
    vehicle.send_to(&voltage(6.0), from).await.unwrap();
    loop {
        let packet = console.hear().await;
        assert_ne!(packet, forged);
        if packet == voltage(6.0) {
            break;
        }
    }
    shore.serving.stop().await;
}

/// A stream is taken as it comes, cut anywhere, with rubbish between packets; commands go back by it; a node that
/// ends it is connected to anew.
#[tokio::test]
async fn a_stream_survives_cuts_and_rubbish() {
    let node = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let at = node.local_addr().unwrap().to_string();
    let shore = Shore::start(|config| config.doors.tcp.connect = vec![at]).await;
    let mut console = Client::connect(shore.proxy()).await;
    let voltage = |time| packet(OTTER, Address::NULL, time, messages::Voltage { value: 12.0 });
    for round in 0..2 {
        let mut stream: TcpStream = tokio::time::timeout(PATIENCE, node.accept()).await.unwrap().unwrap().0;
        let base = f64::from(round) * 100.0;
        let mut bytes = Vec::new();
        for n in 0..20 {
            bytes.extend_from_slice(&voltage(base + f64::from(n) + 1.0));
            // Once a false start, which claims a packet of 64 KiB that never comes.
            let rubbish: &[u8] = if n == 9 { &[0x54, 0xFE, 0xFB, 0, 0xFF] } else { &[1, 2, 3, 0x54] };
            bytes.extend_from_slice(rubbish);
        }
        for piece in bytes.chunks(7) {
            stream.write_all(piece).await.unwrap();
        }
        for n in 0..20 {
            assert_eq!(console.hear().await, voltage(base + f64::from(n) + 1.0));
        }
        let abort = packet(CONSOLE, OTTER, base + 50.0, messages::Abort);
        console.say(&abort).await;
        let mut back = vec![0; abort.len()];
        tokio::time::timeout(PATIENCE, stream.read_exact(&mut back)).await.unwrap().unwrap();
        assert_eq!(back, abort);
    }
    shore.serving.stop().await;
}
