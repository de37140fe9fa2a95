//! What a broker refuses, and what it takes meanwhile.

use super::broker::{Answer, Broker, PACKET_TOO_LARGE};
use super::*;

fn sink(broker: &Broker) -> Mqtt {
    let url = format!("mqtt://{}", broker.address);
    Mqtt::new(&settings::Mqtt { url, ..settings::Mqtt::default() }).unwrap().unwrap()
}

fn message(topic: &str, payload: impl Into<String>) -> Message {
    Message { topic: topic.to_owned(), payload: payload.into(), order_us: 1 }
}

/// So many messages of one vessel, with their numbers as payload.
fn numbered(count: usize) -> Vec<Message> {
    (0..count).map(|number| message(&format!("0x2810/A/{number}"), number.to_string())).collect()
}

/// Carries a batch as the carrier does; how many were refused.
async fn carry(sink: &mut Mqtt, batch: &[Message]) -> anyhow::Result<u64> {
    sink.open().await?;
    sink.write(batch).await?;
    Ok(sink.flush().await?.count)
}

fn payloads(broker: &Broker) -> Vec<String> {
    broker.taken().into_iter().map(|taken| taken.payload).collect()
}

fn numbers(count: usize) -> Vec<String> {
    (0..count).map(|number| number.to_string()).collect()
}

fn denies(vessel: &'static str) -> impl FnMut(&str, &str) -> Answer + Send {
    move |topic, _| if topic.contains(vessel) { Answer::Deny } else { Answer::Take }
}

#[tokio::test]
async fn a_vessel_that_is_denied_holds_up_nothing_after_a_restart() {
    let broker = Broker::start(denies("0x2810")).await;
    let mut before = sink(&broker);
    let (lower, higher) = ([message("0x2810/A/1", "a")], [message("0x2811/A/1", "b")]);
    assert_eq!(carry(&mut before, &higher).await.unwrap(), 0);
    assert_eq!(carry(&mut before, &lower).await.unwrap(), 1);
    broker.taken();
    let mut after = sink(&broker);
    after.resume(&before.note());
    // By a message that it takes again it shows that it does not deny everything, once for a topic.
    for _ in 0..3 {
        assert_eq!(carry(&mut after, &lower).await.unwrap(), 1);
    }
    let taken = broker.taken();
    assert_eq!(taken.len(), 1, "{taken:?}");
    assert!(taken[0].topic == "lutra/0x2811/A/1" && taken[0].payload == "b" && !taken[0].retain);
    assert_eq!(carry(&mut after, &higher).await.unwrap(), 0);
}

#[tokio::test]
async fn where_a_broker_suddenly_denies_everything_all_waits() {
    let broker = Broker::start(|_, _| Answer::Take).await;
    let mut sink = sink(&broker);
    assert_eq!(carry(&mut sink, &numbered(3)).await.unwrap(), 0);
    broker.answers(|_, _| Answer::Deny);
    broker.taken();
    let others = [message("0x2811/B/1", "new"), message("0x2811/B/2", "new")];
    for _ in 0..2 {
        let why = carry(&mut sink, &others).await.unwrap_err().to_string();
        assert!(why.contains("it does not let the server publish to lutra/#"), "{why}");
    }
    broker.answers(|_, _| Answer::Take);
    assert_eq!(carry(&mut sink, &others).await.unwrap(), 0);
    assert_eq!(payloads(&broker), ["new", "new"]);
}

#[tokio::test]
async fn what_was_confirmed_before_a_refusal_is_not_published_again() {
    let broker =
        Broker::start(
            |_, payload| {
                if payload.len() > 100 { Answer::Disconnect(PACKET_TOO_LARGE) } else { Answer::Take }
            },
        )
        .await;
    let mut batch = numbered(64);
    for number in [40, 50] {
        batch[number].payload = "x".repeat(101);
    }
    let mut sink = sink(&broker);
    assert_eq!(carry(&mut sink, &batch).await.unwrap(), 2);
    let expected: Vec<_> = numbers(64).into_iter().filter(|text| text != "40" && text != "50").collect();
    assert_eq!(payloads(&broker), expected, "each once");
}

#[tokio::test]
async fn a_limit_of_packets_concerns_topic_and_payload_and_is_found_once() {
    let broker = Broker::start(|topic, payload| {
        let is_large = topic.len() + payload.len() > 200;
        if is_large { Answer::Disconnect(PACKET_TOO_LARGE) } else { Answer::Take }
    })
    .await;
    let mut sink = sink(&broker);
    let long = format!("0x2810/{}", "t".repeat(150));
    let large = message(&long, "l".repeat(100));
    assert_eq!(carry(&mut sink, std::slice::from_ref(&large)).await.unwrap(), 1);
    // Its payload is larger, and the packet is not.
    assert_eq!(carry(&mut sink, &[message("0x2810/A", "p".repeat(150))]).await.unwrap(), 0);
    assert_eq!(broker.taken().len(), 1);
    let connections = broker.connections();
    for _ in 0..3 {
        assert_eq!(carry(&mut sink, std::slice::from_ref(&large)).await.unwrap(), 1);
    }
    assert_eq!(broker.connections(), connections, "no connection is spent on what is known");
}

#[tokio::test]
async fn a_connection_that_is_lost_under_way_costs_no_message() {
    let mut is_cut = false;
    let broker = Broker::start(move |_, payload| {
        let cuts = payload == "5" && !is_cut;
        is_cut |= cuts;
        if cuts { Answer::Cut } else { Answer::Take }
    })
    .await;
    let mut sink = sink(&broker);
    assert_eq!(carry(&mut sink, &numbered(10)).await.unwrap(), 0);
    assert_eq!(payloads(&broker), numbers(10), "each once");
}

#[tokio::test]
async fn a_message_over_which_the_connection_is_always_lost_is_not_refused() {
    let broker = Broker::start(|_, payload| if payload == "5" { Answer::Cut } else { Answer::Take }).await;
    let mut sink = sink(&broker);
    assert!(carry(&mut sink, &numbered(10)).await.is_err());
    assert_eq!(sink.flush().await.unwrap().count, 0);
    broker.taken();
    broker.answers(|_, _| Answer::Take);
    assert_eq!(carry(&mut sink, &numbered(10)).await.unwrap(), 0);
    assert_eq!(payloads(&broker), numbers(10));
}
