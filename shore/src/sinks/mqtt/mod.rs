//! MQTT: everything that is recorded is published too, for dashboards and programs that subscribe.
//!
//! Messages go out with quality of service 1: a batch is done once the broker has confirmed each of them. The newest value of
//! each topic is retained, so that who subscribes has it at once; see [`retained`]. Before the first message of a vessel since the
//! start, what the broker holds of it is read, so that a restart takes nothing back.

mod connection;
mod message;
mod retained;

use super::carrier::{Refused, Sink};
use super::{secret, settings};
use crate::tls::trusting;
use anyhow::{Context as _, bail, ensure};
use connection::{Connection, Said};
use hyper::Uri;
use imc::PacketView;
use message::Message;
use retained::Retained;
use rumqttc::v5::MqttOptions;
use rumqttc::v5::mqttbytes::v5::PubAckReason;
use rumqttc::{TlsConfiguration, Transport};
use std::collections::BTreeSet;
use std::time::Duration;
use units::UtcTime;

/// How often a connection on which nothing else goes is tried.
const KEEP_ALIVE: Duration = Duration::from_secs(15);
/// How long a broker may take to let us in.
const CONNECT_S: u64 = 10;
/// Messages that wait for their confirmation at once; a broker may want fewer.
const IN_FLIGHT: u16 = 256;
/// The largest value of a broker's that is read.
const LARGEST_HELD_BYTES: u32 = 1 << 20;
/// What a packet has beside topic and payload, bytes, generously.
const AROUND_BYTES: usize = 32;

/// A broker that is published to.
pub(crate) struct Mqtt {
    options: MqttOptions,
    target: String,
    prefix: String,
    wants_the_past: bool,
    connection: Option<Connection>,
    /// Messages that were handed over and are not confirmed.
    unconfirmed: u64,
    refused: Refused,
    retained: Retained,
    /// Vessels of which it is known what the broker holds.
    known: BTreeSet<String>,
    has_said_unread: bool,
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
            prefix,
            wants_the_past: settings.from_beginning,
            connection: None,
            unconfirmed: 0,
            refused: Refused::default(),
            retained: Retained::default(),
            known: BTreeSet::new(),
            has_said_unread: false,
        }))
    }

    /// Reads what the broker holds of a vessel, if that is not known.
    async fn learn(&mut self, vessel: &str) -> anyhow::Result<()> {
        if self.known.contains(vessel) {
            return Ok(());
        }
        let connection = self.connection.as_mut().context("the connection is lost")?;
        let (prefix, retained) = (format!("{}/", self.prefix), &mut self.retained);
        let below = format!("{prefix}{vessel}");
        let may_read = connection.held(&below, |topic, payload| {
            if let (Some(topic), Some(order_us)) = (topic.strip_prefix(&prefix), message::order_of(payload)) {
                retained.note(topic, order_us);
            }
        });
        if !may_read.await? && !self.has_said_unread {
            self.has_said_unread = true;
            tracing::warn!(
                to = self.target,
                "MQTT: the broker lets the server not read below its topic, so after a restart an older value may be retained; \
                 allow it"
            );
        }
        self.known.insert(vessel.to_owned());
        Ok(())
    }

    /// Waits for what the broker says next.
    async fn listen(&mut self) -> anyhow::Result<()> {
        let connection = self.connection.as_mut().context("the connection is lost")?;
        let Said::Confirmed(reason) = connection.next().await? else { return Ok(()) };
        self.unconfirmed = self.unconfirmed.saturating_sub(1);
        match reason {
            PubAckReason::Success | PubAckReason::NoMatchingSubscribers => {}
            PubAckReason::NotAuthorized => bail!(
                "it does not let the server publish to {}/#: allow it to the user of sinks.mqtt.user, or choose another \
                 sinks.mqtt.topic",
                self.prefix
            ),
            PubAckReason::TopicNameInvalid | PubAckReason::PayloadFormatInvalid => {
                self.refused.add(|| format!("{reason:?}"));
            }
            _ => bail!("it does not take messages now: {reason:?}"),
        }
        Ok(())
    }
}

impl Sink for Mqtt {
    type Item = Message;
    const NAME: &'static str = "mqtt";
    const TITLE: &'static str = "MQTT";

    fn target(&self) -> String {
        self.target.clone()
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
        if self.unconfirmed > 0 {
            // The last batch failed: it comes again, on another connection.
            self.connection = None;
        }
        (self.unconfirmed, self.refused) = (0, Refused::default());
        if let Some(mut connection) = self.connection.take() {
            connection.check()?;
            self.connection = Some(connection);
            return Ok(());
        }
        self.connection = Some(Connection::open(self.options.clone()).await?);
        Ok(())
    }

    async fn write(&mut self, batch: &[Message]) -> anyhow::Result<()> {
        let vessels: BTreeSet<&str> = batch.iter().map(Message::vessel).collect();
        // Whatever breaks off below, the connection is not used again.
        self.unconfirmed += 1;
        for vessel in vessels {
            self.learn(vessel).await?;
        }
        self.unconfirmed -= 1;
        for message in batch {
            let topic = format!("{}/{}", self.prefix, message.topic);
            let bytes = topic.len() + message.payload.len() + AROUND_BYTES;
            let largest_bytes = self.connection.as_ref().map_or(usize::MAX, |one| one.largest_bytes);
            if bytes > largest_bytes {
                self.refused.add(|| format!("{bytes} bytes are more than the broker takes: {topic}"));
                continue;
            }
            let retain = self.retained.take(message);
            self.unconfirmed += 1;
            while !self.connection.as_ref().is_some_and(|one| one.publish(&topic, retain, &message.payload)) {
                self.listen().await?;
            }
        }
        Ok(())
    }

    async fn flush(&mut self) -> anyhow::Result<Refused> {
        while self.unconfirmed > 0 {
            self.listen().await?;
        }
        Ok(std::mem::take(&mut self.refused))
    }
}

fn options(settings: &settings::Mqtt) -> anyhow::Result<MqttOptions> {
    let url = &settings.url;
    // No error shows the address: a password may stand in it, also where it does not look like one.
    ensure!(
        !url.contains(['@', '#']) && !url.contains(char::is_whitespace),
        "sinks.mqtt.url must be like mqtt://host:1883, without @, # and spaces; user and password are named by sinks.mqtt.user and \
         password_file"
    );
    let uri: Uri = url.parse().context("sinks.mqtt.url is no address; it must be like mqtt://host:1883")?;
    let host = uri.host().context("sinks.mqtt.url names no host; it must be like mqtt://host:1883")?;
    let has_port = uri.authority().is_some_and(|authority| authority.as_str().len() > host.len());
    ensure!(
        !has_port || uri.port_u16().is_some_and(|port| port > 0),
        "sinks.mqtt.url: the port behind the host must be a number from 1 to 65535"
    );
    ensure!(
        matches!(uri.path(), "" | "/") && uri.query().is_none(),
        "sinks.mqtt.url must end behind host and port; topics are named by sinks.mqtt.topic"
    );
    let tls = match uri.scheme_str() {
        Some("mqtt") => None,
        Some("mqtts") => {
            ensure!(
                !settings.ca_file.as_os_str().is_empty(),
                "sinks.mqtt.url is mqtts: name the authority that signed its certificate by sinks.mqtt.ca_file"
            );
            ensure!(
                !host.starts_with('['),
                "sinks.mqtt.url is encrypted and names an address of IPv6: name the host as its certificate does"
            );
            Some(trusting("sinks.mqtt.ca_file", &settings.ca_file)?)
        }
        _ => bail!("sinks.mqtt.url must begin with mqtt:// or mqtts://"),
    };
    let port = uri.port_u16().unwrap_or(if tls.is_some() { 8883 } else { 1883 });
    let mut options = MqttOptions::new(settings.client_id.clone(), host, port);
    options.set_keep_alive(KEEP_ALIVE).set_clean_start(true).set_connection_timeout(CONNECT_S);
    options.set_outgoing_inflight_upper_limit(IN_FLIGHT);
    options.set_max_packet_size(Some(LARGEST_HELD_BYTES));
    if let Some(tls) = tls {
        options.set_transport(Transport::Tls(TlsConfiguration::Rustls(tls.config().clone())));
    }
    if !settings.user.is_empty() {
        let password = secret("sinks.mqtt.password_file", &settings.password_file)?;
        options.set_credentials(settings.user.clone(), password);
    }
    Ok(options)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_that_cannot_be_used_are_said_with_their_key() {
        let made = |url: &str, ca: &str| {
            let (url, ca_file) = (url.to_owned(), ca.into());
            options(&settings::Mqtt { url, ca_file, ..settings::Mqtt::default() })
        };
        for (url, port) in [("mqtt://broker", 1883), ("mqtt://[::1]:99/", 99)] {
            assert_eq!(made(url, "").unwrap().broker_address().1, port);
        }
        for (url, ca, why) in [
            ("http://there", "", "must begin with mqtt://"),
            ("mqtt://", "", "sinks.mqtt.url"),
            ("mqtt://me:hush@there", "", "without @"),
            ("mqtt://me:hu#sh@there", "", "without @"),
            ("mqtt://me:hu/sh@there", "", "without @"),
            ("mqtt://there#hush", "", "without @"),
            ("mqtt://me:hush there", "", "without @"),
            ("mqtt://there:hush", "", "sinks.mqtt.url"),
            ("mqtt://there:99999", "", "from 1 to 65535"),
            ("mqtt://there:0", "", "from 1 to 65535"),
            ("mqtt://there:", "", "from 1 to 65535"),
            ("mqtt://there/hush?hush", "", "must end behind"),
            ("mqtt://there/lutra", "", "must end behind host and port"),
            ("mqtts://there", "", "sinks.mqtt.ca_file"),
            ("mqtts://there", "/none", "sinks.mqtt.ca_file /none"),
            ("mqtts://[::1]", "/none", "as its certificate does"),
        ] {
            let error = made(url, ca).err().map(|error| format!("{error:#}")).unwrap_or_default();
            assert!(error.contains(why), "{url}: {error}");
            assert!(!error.contains("hu"), "{url}: a password may be in it: {error}");
        }
    }
}
