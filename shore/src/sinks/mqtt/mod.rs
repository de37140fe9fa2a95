//! MQTT: everything that is recorded is published too, for dashboards and programs that subscribe.
//!
//! Messages go out with quality of service 1: a batch is done once the broker has confirmed each of them. The newest value of
//! each topic is retained, so that who subscribes has it at once; see [`retained`]. Before the first message of a vessel since the
//! start, what the broker holds of it is read, so that a restart takes nothing back.

mod connection;
mod message;
mod options;
mod retained;
mod under_way;

use super::carrier::{Refused, Sink};
use super::settings;
use anyhow::ensure;
use connection::Connection;
use imc::PacketView;
use message::Message;
use options::options;
use retained::Retained;
use rumqttc::v5::MqttOptions;
use std::collections::BTreeSet;
use under_way::{Refusal, UnderWay};
use units::UtcTime;

/// What a packet has beside topic and payload, bytes, generously.
const AROUND_BYTES: usize = 32;

/// Topics of which it is remembered that the broker took a message.
const MOST_TAKEN: usize = 100_000;
/// Topics of which it is said that the broker refuses them.
const MOST_SAID: usize = 100;

/// A broker that is published to.
pub(crate) struct Mqtt {
    options: MqttOptions,
    target: String,
    cursor: String,
    prefix: String,
    wants_the_past: bool,
    /// One that stands, with nothing under way.
    connection: Option<Connection>,
    refused: Refused,
    retained: Retained,
    /// Vessels of which it is known what the broker holds.
    known: BTreeSet<String>,
    /// Topics to which it could publish since the start.
    taken: BTreeSet<String>,
    /// A message of this batch was taken.
    takes: bool,
    /// Larger payloads were refused since it was last out of reach, bytes.
    largest_payload_bytes: usize,
    said: Said,
}

/// What was said once.
#[derive(Debug, Default)]
struct Said {
    /// What the broker holds cannot be read.
    unread: bool,
    /// The broker retains nothing.
    unretained: bool,
    /// Topics with a message that is refused.
    refused: BTreeSet<String>,
}

impl Mqtt {
    /// As it is configured; `None` when it is not.
    ///
    /// # Errors
    /// What is configured cannot be used; the error names the key.
    pub(crate) fn new(settings: &settings::Mqtt) -> anyhow::Result<Option<Self>> {
        if settings.url.is_empty() {
            return Ok(None);
        }
        let prefix = settings.topic.clone();
        Ok(Some(Self {
            options: options(settings)?,
            target: format!("{} topic {prefix}", settings.url),
            cursor: format!("topic {prefix} client {}", settings.client_id),
            prefix,
            wants_the_past: settings.from_beginning,
            connection: None,
            refused: Refused::default(),
            retained: Retained::default(),
            known: BTreeSet::new(),
            taken: BTreeSet::new(),
            takes: false,
            largest_payload_bytes: usize::MAX,
            said: Said::default(),
        }))
    }

    /// The connection that stands, or a new one.
    async fn connect(&mut self) -> anyhow::Result<Connection> {
        if let Some(mut connection) = self.connection.take() {
            connection.check()?;
            return Ok(connection);
        }
        let connection = Connection::open(self.options.clone()).await?;
        if !connection.retains && !self.said.unretained {
            self.said.unretained = true;
            tracing::warn!(
                to = self.target,
                "MQTT: the broker retains nothing (retain_available), so who subscribes waits for the next value of each topic"
            );
        }
        Ok(connection)
    }

    /// Reads what the broker holds of a vessel, if that is not known.
    async fn learn(&mut self, connection: &mut Connection, vessel: &str) -> anyhow::Result<()> {
        if self.known.contains(vessel) || !connection.retains {
            return Ok(());
        }
        let (prefix, retained) = (format!("{}/", self.prefix), &mut self.retained);
        let below = format!("{prefix}{vessel}");
        let may_read = connection.held(&below, |topic, payload| {
            if let (Some(topic), Some(order_us)) = (topic.strip_prefix(&prefix), message::order_of(payload)) {
                retained.note(topic, order_us);
            }
        });
        if !may_read.await? && !self.said.unread {
            self.said.unread = true;
            tracing::warn!(
                to = self.target,
                "MQTT: the broker lets the server not read below its topic, so after a restart an older value may be retained; \
                 allow it"
            );
        }
        self.known.insert(vessel.to_owned());
        Ok(())
    }

    /// Publishes messages and waits for the answer to each. Answers why the broker ended the connection over one of them, if it
    /// did: it does not say over which.
    ///
    /// # Errors
    /// The connection is lost, or the broker takes nothing now. It is not used again then.
    async fn publish(&mut self, part: &[Message]) -> anyhow::Result<Option<Refusal>> {
        let mut connection = self.connect().await?;
        for vessel in part.iter().map(Message::vessel).collect::<BTreeSet<_>>() {
            self.learn(&mut connection, vessel).await?;
        }
        let mut under_way = UnderWay::default();
        for (place, message) in part.iter().enumerate() {
            let topic = format!("{}/{}", self.prefix, message.topic);
            let bytes = topic.len() + message.payload.len() + AROUND_BYTES;
            if bytes > connection.largest_bytes || message.payload.len() > self.largest_payload_bytes {
                under_way.refused.push((place, Refusal::TooLarge));
                continue;
            }
            let retain = connection.retains && self.retained.take(message);
            under_way.queue(place);
            while !connection.publish(&topic, retain, &message.payload) {
                if let Some(refusal) = connection.listen(&mut under_way).await? {
                    return Ok(Some(refusal));
                }
            }
        }
        while !under_way.is_empty() {
            if let Some(refusal) = connection.listen(&mut under_way).await? {
                return Ok(Some(refusal));
            }
        }
        self.settle(part, under_way)?;
        self.connection = Some(connection);
        Ok(None)
    }

    /// Takes over what the broker said of each message.
    fn settle(&mut self, part: &[Message], under_way: UnderWay) -> anyhow::Result<()> {
        for place in under_way.taken {
            self.takes = true;
            if self.taken.len() < MOST_TAKEN && !self.taken.contains(&part[place].topic) {
                self.taken.insert(part[place].topic.clone());
            }
        }
        for (place, refusal) in under_way.refused {
            self.refuse(&part[place], &refusal)?;
        }
        Ok(())
    }

    /// Passes a message over that the broker will never take.
    ///
    /// # Errors
    /// It lets the server publish nothing at all: then everything waits until that is mended.
    fn refuse(&mut self, message: &Message, refusal: &Refusal) -> anyhow::Result<()> {
        // What it took before, or nothing ever: then it is not this topic alone.
        let may_be_all = self.taken.is_empty() || self.taken.contains(&message.topic);
        ensure!(
            *refusal != Refusal::Denied || self.takes || !may_be_all,
            "it does not let the server publish to {}/#: allow it to the user of sinks.mqtt.user, or choose another \
             sinks.mqtt.topic",
            self.prefix
        );
        let bytes = message.payload.len();
        let reason = || format!("{refusal} ({}/{}, {bytes} bytes)", self.prefix, message.topic);
        if self.said.refused.len() < MOST_SAID && self.said.refused.insert(message.topic.clone()) {
            tracing::warn!(to = self.target, "MQTT: a message is passed over: {}", reason());
        }
        self.refused.add(reason);
        Ok(())
    }
}

impl Sink for Mqtt {
    type Item = Message;
    const NAME: &'static str = "mqtt";
    const TITLE: &'static str = "MQTT";
    // A message over which the broker ends the connection is looked for by sending the halves again.
    const BATCH_ITEMS: usize = 500;

    fn target(&self) -> String {
        self.target.clone()
    }

    /// A broker that moved goes on where it was.
    fn cursor(&self) -> String {
        self.cursor.clone()
    }

    fn wants_the_past(&self) -> bool {
        self.wants_the_past
    }

    fn item(view: &PacketView<'_>, received: UtcTime) -> (Message, usize) {
        let message = Message::of(view, received);
        let bytes = message.topic.len() + message.payload.len();
        (message, bytes)
    }

    async fn open(&mut self) -> anyhow::Result<()> {
        self.refused = Refused::default();
        if self.connection.is_none() {
            // Its limits may be others by now.
            self.largest_payload_bytes = usize::MAX;
        }
        self.connection = Some(self.connect().await?);
        Ok(())
    }

    /// Those messages over which the broker ends the connection are found by halving the batch, each time over a new one.
    async fn write(&mut self, batch: &[Message]) -> anyhow::Result<()> {
        self.takes = false;
        let mut parts = vec![batch];
        while let Some(part) = parts.pop().filter(|part| !part.is_empty()) {
            let Some(refusal) = self.publish(part).await? else { continue };
            let [message] = part else {
                let (first, second) = part.split_at(part.len() / 2);
                parts.extend([second, first]);
                continue;
            };
            if refusal == Refusal::TooLarge {
                // What is as large is not tried any more: each trial costs a connection.
                let least = message.payload.len();
                self.largest_payload_bytes = self.largest_payload_bytes.min(least.saturating_sub(1));
            }
            self.refuse(message, &refusal)?;
        }
        Ok(())
    }

    /// Each message was answered already.
    async fn flush(&mut self) -> anyhow::Result<Refused> {
        Ok(std::mem::take(&mut self.refused))
    }
}
