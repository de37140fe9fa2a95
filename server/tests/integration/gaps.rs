//! A stolen link token declares everything missing: the vessel itself is still asked for all of it afterwards, and its
//! packets replace the false gap.

use crate::support::program::{Server, link_token, until};
use crate::support::{OTTER, PATIENCE, packet};
use futures_util::{SinkExt as _, StreamExt as _};
use imc::Address;
use imc::messages::Voltage;
use link::frame::{Ack, Frame, Heartbeat, Stamp, decode, message};
use link::{Capabilities, Gap, GapReason, Hello, Packer, VERSION};
use std::net::SocketAddr;
use store::{Reader, TimeRange};
use tokio::net::TcpStream;
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::tungstenite::client::IntoClientRequest as _;
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream, connect_async};
use units::UtcTime;

const STREAM: u64 = 77;

/// A client with the vessel's token.
struct Holder(WebSocketStream<MaybeTlsStream<TcpStream>>);

impl Holder {
    /// Says hello; returns the number from which the server requests records.
    async fn connect(server: SocketAddr, token: &str, attempt: u64) -> (Self, u64) {
        let mut request = format!("ws://{server}/link").into_client_request().unwrap();
        request.headers_mut().insert("authorization", format!("Bearer {token}").parse().unwrap());
        let mut holder = Self(connect_async(request).await.unwrap().0);
        let hello = Hello {
            version: VERSION,
            oldest_version: VERSION,
            capabilities: Capabilities::ALL,
            address: OTTER.0,
            incarnation: 1,
            attempt,
            stream: STREAM,
            first: 0,
            next: 100,
            stamp: Stamp::default(),
            name: "otter-1".to_owned(),
            software: "a test".to_owned(),
            way: None,
        };
        holder.say(&Frame::Hello(hello)).await;
        let resume = holder.hear(|frame| match frame {
            Frame::Welcome(welcome) => Some(welcome.resume),
            _ => None,
        });
        let resume = resume.await;
        (holder, resume)
    }

    async fn say(&mut self, frame: &Frame) {
        self.0.send(Message::Binary(message(frame))).await.unwrap();
    }

    async fn hear<T>(&mut self, wanted: impl Fn(Frame) -> Option<T>) -> T {
        let next = async {
            loop {
                let Message::Binary(bytes) = self.0.next().await.unwrap().unwrap() else { continue };
                for frame in decode(bytes).unwrap() {
                    if let Some(found) = wanted(frame.unwrap()) {
                        return found;
                    }
                }
            }
        };
        tokio::time::timeout(PATIENCE, next).await.unwrap()
    }

    /// Waits until everything below a number is acknowledged.
    async fn acknowledged(&mut self, below: u64) {
        loop {
            // Acknowledgements come in answer to frames.
            self.say(&Frame::Heartbeat(Heartbeat::default())).await;
            let durable = self.hear(|frame| match frame {
                Frame::Ack(Ack { durable, .. }) => Some(Some(durable)),
                Frame::Heartbeat(_) => Some(None),
                _ => None,
            });
            if durable.await.is_some_and(|durable| durable >= below) {
                return;
            }
        }
    }

    async fn records(&mut self, numbers: std::ops::Range<u64>) {
        let time = |seq: u64| UtcTime::from_seconds(1.8e9 + seq as f64).unwrap();
        let said = |seq| packet(OTTER, Address::NULL, time(seq).seconds(), Voltage { value: 24.0 });
        let packets: Vec<_> = numbers.clone().map(|seq| (time(seq), said(seq))).collect();
        let packets = packets.iter().map(|(time, packet)| (*time, packet.as_ref()));
        let batch = Packer::new(false).pack(numbers.start, packets);
        self.say(&Frame::Records(batch)).await;
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_a_token_declares_missing_is_asked_for_again_and_revoked_by_what_comes() {
    let scratch = tempfile::tempdir().unwrap();
    let data = scratch.path().join("data");
    let token = link_token(&data, "otter-1", "0x2810");
    let server = Server::start(&data);
    let (mut vessel, resume) = Holder::connect(server.web, &token, 1).await;
    assert_eq!(resume, 0);
    vessel.records(0..10).await;
    vessel.acknowledged(10).await;

    // The thief declares all numbers missing, under the vessel's stream.
    let (mut thief, resume) = Holder::connect(server.web, &token, 2).await;
    assert_eq!(resume, 10);
    let time = UtcTime::from_seconds(1.8e9).unwrap();
    let gap = Gap { from: 10, to: u64::MAX, since: time, until: time, reason: GapReason::Damaged };
    thief.say(&Frame::Gap(gap)).await;
    thief.acknowledged(u64::MAX).await;
    let gaps = || Reader::open(&data).unwrap().gaps(Some(OTTER), TimeRange::ALL).unwrap();
    assert_eq!(gaps().len(), 1);
    drop(thief);

    // If the vessel were told that all is ashore, it would delete its packets.
    let (mut vessel, resume) = Holder::connect(server.web, &token, 3).await;
    assert_eq!(resume, 10, "the vessel is told to forget what it has");
    vessel.records(10..20).await;
    vessel.acknowledged(20).await;
    until("revoked", || gaps().is_empty().then_some(())).await;
}
