//! The UDP and TCP transports against nodes that behave as DUNE does.

use crate::support::{CONSOLE, Client, OTTER, PATIENCE, Shore, archived_packets, packet};
use bytes::Bytes;
use imc::messages::{self, Announce, Payload as _, SystemType};
use imc::{Address, PacketView};
use std::net::SocketAddr;
use std::time::Duration;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::{TcpListener, TcpStream, UdpSocket};

/// The next datagram with an expected message.
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
        config.transports.udp.listen = "127.0.0.1:0".to_owned().try_into().unwrap();
        // The vehicle's own socket serves as a discovery port, so that it gets the server's announcement.
        config.transports.udp.announce_ports = vec![0, at.port()];
    })
    .await;
    let mut console = Client::connect(shore.proxy()).await;
    let (announced, from) = datagram(&vehicle, Announce::ID).await;
    let ours = imc::decode::<Announce>(&PacketView::new(&announced).unwrap()).unwrap().unwrap();
    let services = ours.services.to_str_lossy().into_owned();
    assert_eq!(services, format!("imc+udp://{from}/"));
    assert_eq!(Some(from), shore.serving.transports.udp);

    // Telemetry of a node that has not announced itself is dropped; afterwards it is relayed.
    vehicle.send_to(&voltage(1.0), from).await.unwrap();
    let hello = packet(OTTER, Address::ANNOUNCE, 2.0, announce("otter-1", SystemType::Usv, at));
    vehicle.send_to(&hello, from).await.unwrap();
    vehicle.send_to(&voltage(3.0), from).await.unwrap();
    let mut heard = Vec::new();
    while heard.last() != Some(&voltage(3.0)) {
        heard.push(console.hear().await);
    }
    assert!(heard.contains(&hello) && !heard.contains(&voltage(1.0)));

    // It gets heartbeats, is asked for its entities and gets packets addressed to it.
    datagram(&vehicle, messages::Heartbeat::ID).await;
    datagram(&vehicle, messages::EntityList::ID).await;
    let abort = packet(CONSOLE, OTTER, 4.0, messages::Abort);
    console.say(&abort).await;
    assert_eq!(datagram(&vehicle, messages::Abort::ID).await.0, abort);

    // It may send only for itself.
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

/// A server's UDP transport without discovery ports; the vehicle announces itself to the data port.
fn udp_transport(config: &mut server::config::Config, listen: &str) {
    config.transports.udp.listen = listen.to_owned().try_into().unwrap();
    config.transports.udp.announce_ports = vec![0];
}

fn voltage(time: f64) -> Bytes {
    packet(OTTER, Address::NULL, time, messages::Voltage { value: 12.0 })
}

async fn hear_until(console: &mut Client, last: &Bytes) -> Vec<Bytes> {
    let mut heard = Vec::new();
    while heard.last() != Some(last) {
        heard.push(console.hear().await);
    }
    heard
}

/// A DUNE forwards each client's packets to all its clients. It is connected by UDP and TCP, and another console uses it
/// from the same computer: each order reaches it once, and none is returned to it.
#[tokio::test]
async fn a_dune_that_echoes_gets_each_order_once() {
    const NEAR: Address = Address(0x4002);
    let request = |src, op, number| {
        let (r#type, request_id) = (messages::PlanControlType::Request, number);
        let message = messages::PlanControl { r#type, op, request_id, ..messages::PlanControl::default() };
        packet(src, OTTER, f64::from(number), message)
    };
    let (start, stop) = (messages::PlanControlOp::Start, messages::PlanControlOp::Stop);
    let node = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let (udp, near) =
        (UdpSocket::bind("127.0.0.1:0").await.unwrap(), UdpSocket::bind("127.0.0.1:0").await.unwrap());
    let tcp_at = node.local_addr().unwrap().to_string();
    let shore = Shore::start(|config| {
        udp_transport(config, "127.0.0.1:0");
        config.transports.tcp.connect = vec![tcp_at];
    })
    .await;
    let to = shore.serving.transports.udp.unwrap();
    let mut console = Client::connect(shore.proxy()).await;
    let (mut reader, mut tcp) = node.accept().await.unwrap().0.into_split();
    for (socket, system, kind) in [(&udp, OTTER, SystemType::Usv), (&near, NEAR, SystemType::Ccu)] {
        let told = announce("dune", kind, socket.local_addr().unwrap());
        socket.send_to(&packet(system, Address::ANNOUNCE, 1.0, told), to).await.unwrap();
    }
    udp.send_to(&voltage(2.0), to).await.unwrap();
    hear_until(&mut console, &voltage(2.0)).await;
    tcp.write_all(&voltage(3.0)).await.unwrap();
    hear_until(&mut console, &voltage(3.0)).await;

    // Packets that DUNE gets, and forwards to all its clients.
    let (mut got, mut deframer, mut datagram, mut bytes) =
        (Vec::new(), imc::Deframer::new(), vec![0; 65_536], vec![0; 65_536]);
    for number in 0..3_u16 {
        console.say(&request(CONSOLE, start, 2 * number + 10)).await;
        console.say(&request(CONSOLE, stop, 2 * number + 11)).await;
        for echo in [request(NEAR, start, 2 * number + 100), request(NEAR, stop, 2 * number + 101)] {
            udp.send_to(&echo, to).await.unwrap();
            tcp.write_all(&echo).await.unwrap();
        }
    }
    let mut marks = 0;
    let listen = async {
        while marks < 3 {
            let mut said = Vec::new();
            tokio::select! {
                length = udp.recv(&mut datagram) => said.push(Bytes::copy_from_slice(&datagram[..length.unwrap()])),
                length = reader.read(&mut bytes) => {
                    deframer.push(&bytes[..length.unwrap()]);
                    while let Some(frame) = deframer.next_frame() {
                        if let imc::Frame::Packet { view, .. } = frame {
                            said.push(Bytes::copy_from_slice(view.bytes()));
                        }
                    }
                }
            }
            for packet in said {
                let id = PacketView::new(&packet).unwrap().id();
                if id == messages::PlanControl::ID {
                    udp.send_to(&packet, to).await.unwrap();
                    tcp.write_all(&packet).await.unwrap();
                    got.push(packet);
                    if got.len() == 6 {
                        // After all echoes; the Abort that answers it follows their effects.
                        udp.send_to(&voltage(1_000.0), to).await.unwrap();
                        tcp.write_all(&voltage(1_001.0)).await.unwrap();
                        let mut ends = vec![voltage(1_000.0), voltage(1_001.0)];
                        while !ends.is_empty() {
                            let heard = console.hear().await;
                            ends.retain(|end| *end != heard);
                        }
                        console.say(&self::packet(CONSOLE, OTTER, 2_000.0, messages::Abort)).await;
                        marks = 1;
                    }
                } else if id == messages::Abort::ID {
                    marks += 1;
                }
            }
        }
    };
    tokio::time::timeout(PATIENCE, listen).await.unwrap();
    let expected: Vec<Bytes> = (0..3_u16)
        .flat_map(|number| {
            [request(CONSOLE, start, 2 * number + 10), request(CONSOLE, stop, 2 * number + 11)]
        })
        .collect();
    assert_eq!(got, expected);
    shore.serving.stop().await;
}

#[tokio::test]
async fn a_burst_of_datagrams_is_recorded_whole() {
    let vehicle = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
    let shore = Shore::start(|config| udp_transport(config, "127.0.0.1:0")).await;
    let to = shore.serving.transports.udp.unwrap();
    let mut console = Client::connect(shore.proxy()).await;
    let at = vehicle.local_addr().unwrap();
    vehicle
        .send_to(&packet(OTTER, Address::ANNOUNCE, 1.0, announce("otter", SystemType::Usv, at)), to)
        .unwrap();
    vehicle.send_to(&voltage(1.0), to).unwrap();
    hear_until(&mut console, &voltage(1.0)).await;
    let state =
        |n: u32| packet(OTTER, Address::NULL, f64::from(n) + 10.0, messages::EstimatedState::default());
    let burst: Vec<Bytes> = (0..500).map(state).collect();
    let (vehicle, sent) = tokio::task::spawn_blocking(move || {
        for packet in &burst {
            vehicle.send_to(packet, to).unwrap();
        }
        (vehicle, burst)
    })
    .await
    .unwrap();
    // The last packet may be lost, so it is repeated until it is heard.
    let mut said = Vec::new();
    loop {
        said.push(voltage(1_000.0 + said.len() as f64));
        vehicle.send_to(said.last().unwrap(), to).unwrap();
        let next = tokio::time::timeout(Duration::from_millis(200), async {
            while !said.contains(&console.hear().await) {}
        });
        if next.await.is_ok() {
            break;
        }
        assert!(said.len() < 100, "nothing comes any more");
    }
    let Shore { serving, data } = shore;
    serving.stop().await;
    let archived = archived_packets(data.path(), OTTER);
    let lost = sent.iter().filter(|packet| !archived.contains(packet)).count();
    assert_eq!(lost, 0, "of {}", sent.len());
}

#[tokio::test]
async fn a_vessel_that_streams_is_heard_at_once_after_a_restart() {
    let vehicle = UdpSocket::bind("127.0.0.1:0").await.unwrap();
    let at = vehicle.local_addr().unwrap();
    let Shore { serving, data } = Shore::start(|config| udp_transport(config, "127.0.0.1:0")).await;
    let (to, proxy) = (serving.transports.udp.unwrap(), serving.transports.imcproxy.unwrap());
    let mut console = Client::connect(proxy).await;
    vehicle
        .send_to(&packet(OTTER, Address::ANNOUNCE, 1.0, announce("otter", SystemType::Usv, at)), to)
        .await
        .unwrap();
    vehicle.send_to(&voltage(1.0), to).await.unwrap();
    hear_until(&mut console, &voltage(1.0)).await;
    serving.stop().await;
    let shore = Shore::start(|config| {
        config.data = data.path().to_owned();
        udp_transport(config, &to.to_string());
    })
    .await;
    assert_eq!(shore.serving.transports.udp, Some(to));
    let mut console = Client::connect(shore.proxy()).await;
    // From another port of the same computer it is not the vehicle.
    let other = UdpSocket::bind("127.0.0.1:0").await.unwrap();
    other.send_to(&voltage(2.0), to).await.unwrap();
    vehicle.send_to(&voltage(3.0), to).await.unwrap();
    assert_eq!(console.hear().await, voltage(3.0));
    shore.serving.stop().await;
}

/// A second system with the IMC address of an active one, on the same computer or another, is not taken for it.
#[tokio::test]
async fn a_second_system_of_the_same_address_takes_neither_the_place_nor_the_stop() {
    let first = UdpSocket::bind("127.0.0.1:0").await.unwrap();
    let second = UdpSocket::bind("127.0.0.1:0").await.unwrap();
    let third = UdpSocket::bind("127.0.0.2:0").await.unwrap();
    let shore = Shore::start(|config| udp_transport(config, "127.0.0.1:0")).await;
    let to = shore.serving.transports.udp.unwrap();
    let mut console = Client::connect(shore.proxy()).await;
    for (socket, time) in [(&first, 1.0), (&second, 2.0), (&third, 3.0)] {
        let told = announce("otter", SystemType::Usv, socket.local_addr().unwrap());
        socket.send_to(&packet(OTTER, Address::ANNOUNCE, time, told), to).await.unwrap();
        socket.send_to(&voltage(time), to).await.unwrap();
        first.send_to(&voltage(time + 0.5), to).await.unwrap();
        let heard = hear_until(&mut console, &voltage(time + 0.5)).await;
        assert_eq!(heard.contains(&voltage(time)), time < 2.0);
    }
    let abort = packet(CONSOLE, OTTER, 4.0, messages::Abort);
    console.say(&abort).await;
    assert_eq!(datagram(&first, messages::Abort::ID).await.0, abort);
    shore.serving.stop().await;
}

/// While either side stalls TCP keeps the bytes: the stream is not cut, and the packet in its middle is whole.
#[tokio::test]
async fn a_stream_outlives_a_stall_in_the_middle_of_a_packet() {
    let node = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let at = node.local_addr().unwrap().to_string();
    let shore = Shore::start(|config| config.transports.tcp.connect = vec![at]).await;
    let mut console = Client::connect(shore.proxy()).await;
    let mut stream = node.accept().await.unwrap().0;
    stream.write_all(&voltage(1.0)).await.unwrap();
    assert_eq!(console.hear().await, voltage(1.0));
    stream.write_all(&voltage(2.0)[..20]).await.unwrap();
    // Tests the silence: longer than the ten seconds after which it is reported.
    let again = tokio::time::timeout(Duration::from_secs(12), node.accept()).await;
    assert!(again.is_err(), "connected again");
    stream.write_all(&voltage(2.0)[20..]).await.unwrap();
    stream.write_all(&voltage(3.0)).await.unwrap();
    assert_eq!([console.hear().await, console.hear().await], [voltage(2.0), voltage(3.0)]);
    shore.serving.stop().await;
}

/// A stream is read in pieces cut anywhere, with garbage between packets; commands are sent back over it; if a node closes
/// it, it is connected again.
#[tokio::test]
async fn a_stream_survives_cuts_and_rubbish() {
    let node = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let at = node.local_addr().unwrap().to_string();
    let shore = Shore::start(|config| config.transports.tcp.connect = vec![at]).await;
    let mut console = Client::connect(shore.proxy()).await;
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
