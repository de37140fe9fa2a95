//! The IMCProxy transport with real sockets.

use crate::support::{CONSOLE, Client, OTTER, PATIENCE, Shore, odd_packets, packet};
use futures_util::{SinkExt as _, StreamExt as _};
use imc::Address;
use imc::messages;
use tokio_tungstenite::tungstenite::Message as Frame;
use tokio_tungstenite::tungstenite::protocol::frame::coding::CloseCode;

#[tokio::test]
async fn original_bytes_go_to_all_others_and_never_back() {
    let shore = Shore::start(|_| {}).await;
    let mut vessel = Client::connect(shore.proxy()).await;
    let mut consoles = [Client::connect(shore.proxy()).await, Client::connect(shore.proxy()).await];
    let said = odd_packets(5.0);
    vessel.0.send(Frame::text("ignored, as ever")).await.unwrap();
    for packet in &said {
        vessel.say(packet).await;
    }
    for console in &mut consoles {
        for packet in &said {
            assert_eq!(console.hear().await, packet);
        }
    }
    // The first packet that the vessel gets is the console's, so its own were not echoed.
    let abort = packet(CONSOLE, OTTER, 1.0, messages::Abort);
    consoles[0].say(&abort).await;
    assert_eq!(vessel.hear().await, abort);
    assert_eq!(consoles[1].hear().await, abort);
    shore.serving.stop().await;
}

#[tokio::test]
async fn rubbish_harms_its_sender_alone() {
    let shore = Shore::start(|_| {}).await;
    let mut listener = Client::connect(shore.proxy()).await;
    let mut sender = Client::connect(shore.proxy()).await;
    for rubbish in [&b""[..], b"hello", &[0xFE; 500], &[0x54, 0xFE, 1, 2]] {
        sender.say(rubbish).await;
    }
    let good = packet(OTTER, Address::NULL, 1.0, messages::Voltage { value: 12.0 });
    sender.say(&good).await;
    assert_eq!(listener.hear().await, good);
    // One byte more than a message may have.
    sender.say(&vec![0; 65_537]).await;
    let closed = async {
        while let Some(frame) = sender.0.next().await {
            if let Ok(Frame::Close(Some(frame))) = frame {
                return Some(frame.code);
            }
        }
        None
    };
    let code = tokio::time::timeout(PATIENCE, closed).await.unwrap();
    assert!(matches!(code, None | Some(CloseCode::Size)), "{code:?}");
    let mut another = Client::connect(shore.proxy()).await;
    let next = packet(OTTER, Address::NULL, 2.0, messages::Voltage { value: 12.0 });
    another.say(&next).await;
    assert_eq!(listener.hear().await, next);
    shore.serving.stop().await;
}

#[tokio::test]
async fn who_does_not_read_holds_nobody_up() {
    let shore = Shore::start(|_| {}).await;
    let mut vessel = Client::connect(shore.proxy()).await;
    let _deaf = Client::connect(shore.proxy()).await;
    let mut console = Client::connect(shore.proxy()).await;
    // More than the kernel and the outbox hold for the client that does not read.
    let state = messages::EstimatedState::default();
    for n in 0..100_000_u32 {
        vessel
            .0
            .feed(Frame::Binary(packet(OTTER, Address::NULL, f64::from(n), state.clone())))
            .await
            .unwrap();
        if n % 100 == 99 {
            vessel.0.flush().await.unwrap();
            for _ in 0..100 {
                console.hear().await;
            }
        }
    }
    shore.serving.stop().await;
}

#[tokio::test]
async fn the_transport_admits_declared_addresses_and_so_many() {
    let shore =
        Shore::start(|config| config.transports.imcproxy.allow = vec!["192.0.2.0/24".to_owned()]).await;
    assert!(tokio_tungstenite::connect_async(format!("ws://{}", shore.proxy())).await.is_err());
    shore.serving.stop().await;
    let shore = Shore::start(|config| config.transports.imcproxy.max_peers = 1).await;
    let _first = Client::connect(shore.proxy()).await;
    assert!(tokio_tungstenite::connect_async(format!("ws://{}", shore.proxy())).await.is_err());
    shore.serving.stop().await;
}
