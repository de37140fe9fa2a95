//! One connection to a broker: a task that polls rumqttc's event loop, and what it says of it.
//!
//! rumqttc would connect again by itself and send again what it holds. Here a connection that is lost is given up instead, with
//! all that waits in it: the carrier sends the batch again from the archive, so nothing is held in two places.

use super::under_way::{Ended, Refusal, UnderWay};
use anyhow::{Context as _, anyhow, bail, ensure};
use rumqttc::Outgoing;
use rumqttc::v5::mqttbytes::v5::{
    ConnectReturnCode, DisconnectReasonCode, Packet, PubAckReason, SubscribeReasonCode,
};
use rumqttc::v5::mqttbytes::{self, QoS};
use rumqttc::v5::{AsyncClient, ConnectionError, Event, EventLoop, MqttOptions, StateError};
use std::collections::VecDeque;
use std::time::Duration;
use tokio::sync::mpsc;
use tokio::task::JoinHandle;

/// A broker that says nothing for so long, while it has something to answer, is taken to be gone.
const PATIENCE: Duration = Duration::from_secs(30);
/// MQTT 5, 2.4: the reason code *packet too large*.
const PACKET_TOO_LARGE: u8 = 0x95;
/// Messages that wait to be sent, beside those that wait for their confirmation.
const WAITING: usize = 64;
/// What was said and waits to be heard; the task waits where there is no room.
const UNHEARD: usize = 256;

/// What a connection says.
#[derive(Debug)]
pub(super) enum Said {
    /// The broker let us in; the largest packet that it takes, and whether it retains.
    Connected(Option<u32>, bool),
    /// A message went out under this number, so another one may wait.
    Sent(u16),
    /// The broker took the message of this number, or says why not.
    Confirmed(u16, PubAckReason),
    /// The broker holds this value.
    Held(String, Vec<u8>),
    /// It shows what it holds, or not.
    Subscribed(bool),
    /// It has shown all.
    Unsubscribed,
    Lost(ConnectionError),
}

/// A connection that was opened. Dropped, it is cut.
pub(super) struct Connection {
    client: AsyncClient,
    said: mpsc::Receiver<Said>,
    task: JoinHandle<()>,
    /// The largest packet that the broker takes, bytes.
    pub(super) largest_bytes: usize,
    /// It keeps the newest value of a topic.
    pub(super) retains: bool,
}

impl Drop for Connection {
    fn drop(&mut self) {
        self.task.abort();
    }
}

impl Connection {
    /// Connects.
    ///
    /// # Errors
    /// The broker is not there, or does not let us in.
    pub(super) async fn open(options: MqttOptions) -> anyhow::Result<Self> {
        let (client, events) = AsyncClient::new(options, WAITING);
        let (says, said) = mpsc::channel(UNHEARD);
        let task = tokio::spawn(poll(events, says));
        let mut connection = Self { client, said, task, largest_bytes: usize::MAX, retains: true };
        match connection.next().await? {
            Said::Connected(largest, retains) => {
                connection.largest_bytes = largest.map_or(usize::MAX, |bytes| bytes as usize);
                connection.retains = retains;
                Ok(connection)
            }
            other => bail!("it answers a connection by {other:?}"),
        }
    }

    /// Whether it was lost while nothing was sent.
    ///
    /// # Errors
    /// It was; why.
    pub(super) fn check(&mut self) -> anyhow::Result<()> {
        match self.said.try_recv() {
            Ok(Said::Lost(error)) => Err(why(&error)),
            Err(mpsc::error::TryRecvError::Disconnected) => bail!("the connection is lost"),
            _ => Ok(()),
        }
    }

    /// What it says next.
    ///
    /// # Errors
    /// It is lost, or says nothing for too long.
    async fn next(&mut self) -> anyhow::Result<Said> {
        match self.hear().await? {
            Said::Lost(error) => Err(why(&error)),
            said => Ok(said),
        }
    }

    async fn hear(&mut self) -> anyhow::Result<Said> {
        let said = tokio::time::timeout(PATIENCE, self.said.recv()).await.context("it does not answer")?;
        said.context("the connection is lost")
    }

    /// Waits for what it says next of what is under way. Answers how the connection ended, where that may be over one of the
    /// messages.
    ///
    /// # Errors
    /// The broker ends it for another reason, says nothing for too long, or takes nothing now.
    pub(super) async fn listen(&mut self, under_way: &mut UnderWay) -> anyhow::Result<Option<Ended>> {
        match self.hear().await? {
            Said::Sent(packet) => under_way.sent(packet),
            Said::Confirmed(packet, reason) => under_way.confirmed(packet, reason)?,
            Said::Lost(error) => return ended(&error).map(Some).ok_or_else(|| why(&error)),
            _ => {}
        }
        Ok(None)
    }

    /// Has a message sent; false while others wait to be sent.
    pub(super) fn publish(&self, topic: &str, retain: bool, payload: &str) -> bool {
        let payload = payload.as_bytes().to_vec();
        self.client.try_publish(topic, QoS::AtLeastOnce, retain, payload).is_ok()
    }

    /// Reads what the broker holds below a topic, before anything is published.
    ///
    /// # Errors
    /// The connection is lost.
    pub(super) async fn held(
        &mut self,
        below: &str,
        mut each: impl FnMut(&str, &[u8]),
    ) -> anyhow::Result<bool> {
        let filter = format!("{below}/#");
        let asked = self.client.try_subscribe(&filter, QoS::AtMostOnce);
        ensure!(asked.is_ok(), "the connection is busy");
        let mut may_read = true;
        loop {
            match self.next().await? {
                Said::Held(topic, payload) => each(&topic, &payload),
                Said::Subscribed(allowed) => {
                    may_read = allowed;
                    // What it holds comes before its answer to this.
                    ensure!(self.client.try_unsubscribe(&filter).is_ok(), "the connection is busy");
                }
                Said::Unsubscribed => return Ok(may_read),
                _ => {}
            }
        }
    }
}

/// Polls until the connection is lost or nobody listens.
async fn poll(mut events: EventLoop, says: mpsc::Sender<Said>) {
    loop {
        // What came in one read with the end waits there, and would be handed out with another connection only.
        let (all, lost) = match events.poll().await {
            Ok(event) => (VecDeque::from([event]), None),
            Err(error) => (std::mem::take(&mut events.state.events), Some(error)),
        };
        let is_lost = lost.is_some();
        for said in all.into_iter().filter_map(heard).chain(lost.map(Said::Lost)) {
            if says.send(said).await.is_err() {
                return;
            }
        }
        if is_lost {
            return;
        }
    }
}

/// What an event says, if anything.
fn heard(event: Event) -> Option<Said> {
    let packet = match event {
        Event::Outgoing(Outgoing::Publish(packet)) => return Some(Said::Sent(packet)),
        Event::Outgoing(_) => return None,
        Event::Incoming(packet) => packet,
    };
    Some(match packet {
        Packet::ConnAck(answer) => {
            let properties = answer.properties.as_ref();
            let retains = properties.and_then(|properties| properties.retain_available) != Some(0);
            Said::Connected(properties.and_then(|properties| properties.max_packet_size), retains)
        }
        Packet::PubAck(answer) => Said::Confirmed(answer.pkid, answer.reason),
        Packet::Publish(held) if held.retain => {
            Said::Held(String::from_utf8_lossy(&held.topic).into_owned(), held.payload.to_vec())
        }
        Packet::SubAck(answer) => Said::Subscribed(
            answer.return_codes.iter().all(|code| matches!(code, SubscribeReasonCode::Success(_))),
        ),
        Packet::UnsubAck(_) => Said::Unsubscribed,
        _ => return None,
    })
}

/// How the end of a connection concerns the messages under way; `None` where the broker gives another reason. Of *packet too
/// large* in its answer to a message (Mosquitto's `message_size_limit`, which is of payloads) rumqttc knows nothing: it gives the
/// connection up, and speaks of a code of *connect*.
fn ended(error: &ConnectionError) -> Option<Ended> {
    use DisconnectReasonCode::{NotAuthorized, PacketTooLarge, PayloadFormatInvalid, TopicNameInvalid};
    let refusal = match error {
        ConnectionError::MqttState(StateError::Deserialization(
            mqttbytes::Error::InvalidConnectReturnCode(PACKET_TOO_LARGE),
        )) => Refusal::TooLarge,
        ConnectionError::MqttState(StateError::ServerDisconnect { reason_code, .. }) => match reason_code {
            PacketTooLarge => Refusal::PacketTooLarge,
            NotAuthorized => Refusal::Denied,
            TopicNameInvalid | PayloadFormatInvalid => Refusal::Invalid(format!("{reason_code:?}")),
            _ => return None,
        },
        _ => return Some(Ended::Lost(why(error))),
    };
    Some(Ended::Refused(refusal))
}

/// An error of a connection, with what to do about it where that is known.
fn why(error: &ConnectionError) -> anyhow::Error {
    use ConnectReturnCode::{BadUserNamePassword, NotAuthorized, UnsupportedProtocolVersion};
    let code = match error {
        ConnectionError::ConnectionRefused(code)
        | ConnectionError::MqttState(StateError::ConnFail { reason: code }) => Some(*code),
        _ => None,
    };
    match code {
        Some(BadUserNamePassword | NotAuthorized) => {
            anyhow!("it does not let the server in; look at sinks.mqtt.user and password_file")
        }
        Some(UnsupportedProtocolVersion) => anyhow!("it does not speak MQTT 5; take a broker that does"),
        Some(code) => anyhow!("it refuses the connection: {code:?}"),
        None => anyhow!("{error}"),
    }
}
