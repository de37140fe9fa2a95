//! MQTT: everything that is recorded is published too, for dashboards and programs that subscribe.
//!
//! Messages go out with quality of service 1: a batch is done once the broker has confirmed each of them. The newest value of
//! each topic is retained, so that who subscribes has it at once; see [`retained`]. Before the first message of a vessel since the
//! start, what the broker holds of it is read, so that a restart takes nothing back.

mod access;
#[cfg(test)]
mod broker;
mod connection;
mod largest;
mod message;
mod options;
mod retained;
#[cfg(test)]
mod tests;
mod under_way;

use super::carrier::{Refused, Sink};
use super::settings;
use access::Access;
use anyhow::bail;
use connection::Connection;
use imc::PacketView;
use largest::Largest;
use message::Message;
use options::options;
use retained::Retained;
use rumqttc::v5::MqttOptions;
use std::collections::BTreeSet;
use under_way::{Ended, Refusal, UnderWay};
use units::UtcTime;

/// What a packet has beside topic and payload, bytes, generously.
const AROUND_BYTES: usize = 32;

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
    access: Access,
    /// As was shown since it was last out of reach.
    largest: Largest,
    said: Said,
}

/// What the broker said of a batch.
#[derive(Debug, Default)]
struct Answers<'b> {
    /// It took some of it.
    takes: bool,
    refused: Vec<(&'b Message, Refusal)>,
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
            access: Access::default(),
            largest: Largest::default(),
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

    /// Publishes messages, the newest of a topic retained where that is wanted, and waits for the answer to each. Answers how the
    /// connection ended, too, where that may be over one of them.
    ///
    /// # Errors
    /// The connection is lost otherwise, or the broker takes nothing now. It is not used again then.
    async fn publish(
        &mut self,
        part: &[&Message],
        retain: bool,
    ) -> anyhow::Result<(UnderWay, Option<Ended>)> {
        let mut connection = self.connect().await?;
        for vessel in part.iter().map(|message| message.vessel()).collect::<BTreeSet<_>>() {
            self.learn(&mut connection, vessel).await?;
        }
        let mut under_way = UnderWay::default();
        let ended = self.hand_over(&mut connection, part, retain, &mut under_way).await?;
        if ended.is_none() {
            self.connection = Some(connection);
        }
        Ok((under_way, ended))
    }

    async fn hand_over(
        &mut self,
        connection: &mut Connection,
        part: &[&Message],
        retain: bool,
        under_way: &mut UnderWay,
    ) -> anyhow::Result<Option<Ended>> {
        for (place, message) in part.iter().enumerate() {
            let topic = self.topic(message);
            if topic.len() + message.payload.len() + AROUND_BYTES > connection.largest_bytes {
                under_way.refused.push((place, Refusal::PacketTooLarge));
                continue;
            }
            if let Some(refusal) = self.largest.refusal(topic.len(), message.payload.len()) {
                under_way.refused.push((place, refusal));
                continue;
            }
            let retain = retain && connection.retains && self.retained.take(message);
            under_way.queue(place);
            while !connection.publish(&topic, retain, &message.payload) {
                if let Some(ended) = connection.listen(under_way).await? {
                    return Ok(Some(ended));
                }
            }
        }
        while !under_way.is_empty() {
            if let Some(ended) = connection.listen(under_way).await? {
                return Ok(Some(ended));
            }
        }
        Ok(None)
    }

    fn topic(&self, message: &Message) -> String {
        format!("{}/{}", self.prefix, message.topic)
    }

    /// Publishes a part of a batch, and takes over what the broker says of it. Answers what is to be published again, in parts,
    /// where the connection ended before that was answered.
    ///
    /// # Errors
    /// As [`Mqtt::publish`], and where the connection is lost without a reason while one message alone was under way.
    async fn part<'b>(
        &mut self,
        part: &[&'b Message],
        answers: &mut Answers<'b>,
    ) -> anyhow::Result<[Vec<&'b Message>; 2]> {
        let (under_way, ended) = self.publish(part, true).await?;
        let open: Vec<_> = under_way.unanswered(part.len()).into_iter().map(|place| part[place]).collect();
        let taken: Vec<_> = under_way.taken.iter().map(|place| part[*place]).collect();
        answers.takes |= !taken.is_empty();
        self.access.take(&taken);
        answers.refused.extend(under_way.refused.into_iter().map(|(place, refusal)| (part[place], refusal)));
        match (ended, &open[..]) {
            (Some(Ended::Lost(error)), [_]) if part.len() == 1 => return Err(error),
            (Some(Ended::Refused(refusal)), [message]) => {
                let topic_bytes = self.topic(message).len();
                self.largest.note(&refusal, topic_bytes, message.payload.len());
                answers.refused.push((*message, refusal));
                return Ok([Vec::new(), Vec::new()]);
            }
            _ => {}
        }
        let (first, second) = open.split_at(open.len() / 2);
        Ok([second.to_vec(), first.to_vec()])
    }

    /// Publishes a batch. Messages over which the connection ends are found by halving what was not answered, each time over a new
    /// connection.
    async fn batch(&mut self, batch: &[Message]) -> anyhow::Result<()> {
        let mut answers = Answers::default();
        let mut parts = vec![batch.iter().collect::<Vec<_>>()];
        while let Some(part) = parts.pop() {
            if !part.is_empty() {
                parts.extend(self.part(&part, &mut answers).await?);
            }
        }
        let is_new = |(message, refusal): &(&Message, Refusal)| {
            *refusal == Refusal::Denied && !self.access.denies(&message.topic)
        };
        if !answers.takes && answers.refused.iter().any(is_new) {
            self.prove().await?;
        }
        for (message, refusal) in &answers.refused {
            self.refuse(message, refusal);
        }
        Ok(())
    }

    /// Sends again what the broker took before, one after the other, until it takes one: so it does not deny everything.
    ///
    /// # Errors
    /// It denies that too, or never took anything: then everything waits until that is mended.
    async fn prove(&mut self) -> anyhow::Result<()> {
        for message in self.access.taken() {
            let (under_way, ended) = self.publish(&[&message], false).await?;
            if !under_way.taken.is_empty() {
                return Ok(());
            }
            if let Some(Ended::Lost(error)) = ended {
                return Err(error);
            }
        }
        bail!(
            "it does not let the server publish to {}/#: allow it to the user of sinks.mqtt.user, or choose another \
             sinks.mqtt.topic",
            self.prefix
        )
    }

    /// Passes a message over that the broker will never take.
    fn refuse(&mut self, message: &Message, refusal: &Refusal) {
        if *refusal == Refusal::Denied {
            self.access.deny(&message.topic);
        }
        let bytes = message.payload.len();
        let reason = || format!("{refusal} ({}/{}, {bytes} bytes)", self.prefix, message.topic);
        if self.said.refused.len() < MOST_SAID && self.said.refused.insert(message.topic.clone()) {
            tracing::warn!(to = self.target, "MQTT: a message is passed over: {}", reason());
        }
        self.refused.add(reason);
    }

    /// After an error the broker may be another one, with other limits.
    fn after<T>(&mut self, outcome: anyhow::Result<T>) -> anyhow::Result<T> {
        if outcome.is_err() {
            self.largest = Largest::default();
        }
        outcome
    }
}

impl Sink for Mqtt {
    type Item = Message;
    const NAME: &'static str = "mqtt";
    const TITLE: &'static str = "MQTT";
    // A message over which the broker ends the connection is looked for by halving what was not answered.
    const BATCH_ITEMS: usize = 500;

    fn target(&self) -> String {
        self.target.clone()
    }

    /// A broker that moved goes on where it was.
    fn cursor(&self) -> String {
        self.cursor.clone()
    }

    fn note(&self) -> String {
        self.access.note()
    }

    fn resume(&mut self, note: &str) {
        self.access.resume(note);
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
        let outcome = self.connect().await;
        self.connection = Some(self.after(outcome)?);
        Ok(())
    }

    async fn write(&mut self, batch: &[Message]) -> anyhow::Result<()> {
        let outcome = self.batch(batch).await;
        self.after(outcome)
    }

    /// Each message was answered already.
    async fn flush(&mut self) -> anyhow::Result<Refused> {
        Ok(std::mem::take(&mut self.refused))
    }
}
