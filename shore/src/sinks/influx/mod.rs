//! InfluxDB as a second history: everything in the archive goes there too, as lines that Grafana can draw.
//!
//! Lines carry all that tells them apart, so that one that is sent twice is there once.

mod client;
mod line;

use super::carrier::{Refused, Sink};
use super::{secret, settings};
use anyhow::Context as _;
use base64ct::{Base64, Encoding as _};
use client::{Answer, Client};
use hyper::header::HeaderValue;
use imc::PacketView;
use units::UtcTime;

/// An InfluxDB that is written to.
pub(crate) struct Influx {
    client: Client,
    target: String,
    refused: Refused,
}

impl Influx {
    /// As it is configured; `None` when it is not.
    ///
    /// # Errors
    /// What is configured cannot be used; the error names the key.
    pub(crate) fn new(settings: &settings::Influx) -> anyhow::Result<Option<Self>> {
        if settings.url.is_empty() {
            return Ok(None);
        }
        let client =
            Client::new(&settings.url, &settings.database, authorization(settings)?, &settings.ca_file)?;
        let target = format!("{} database {}", settings.url, settings.database);
        Ok(Some(Self { client, target, refused: Refused::default() }))
    }
}

impl Sink for Influx {
    type Item = String;
    const NAME: &'static str = "influx";
    const TITLE: &'static str = "InfluxDB";
    const BATCH_ITEMS: usize = 5_000;

    fn target(&self) -> String {
        self.target.clone()
    }

    fn wants_the_past(&self) -> bool {
        true
    }

    fn item(view: &PacketView<'_>, received: UtcTime) -> (String, usize) {
        let mut text = String::new();
        line::write(&mut text, view, received);
        let bytes = text.len();
        (text, bytes)
    }

    /// The client makes a connection for the first request that needs one.
    async fn open(&mut self) -> anyhow::Result<()> {
        self.refused = Refused::default();
        Ok(())
    }

    /// Those lines that spoil a batch are found by halving it.
    async fn write(&mut self, lines: &[String]) -> anyhow::Result<()> {
        let mut parts = vec![lines];
        while let Some(part) = parts.pop().filter(|part| !part.is_empty()) {
            match self.client.write(&part.concat()).await? {
                Answer::Kept => {}
                Answer::Refused(_) if part.len() > 1 => {
                    let (first, second) = part.split_at(part.len() / 2);
                    parts.extend([second, first]);
                }
                Answer::Partly(reason) | Answer::Refused(reason) => self.refused.add(|| reason),
            }
        }
        Ok(())
    }

    /// Each request was answered already.
    async fn flush(&mut self) -> anyhow::Result<Refused> {
        Ok(std::mem::take(&mut self.refused))
    }
}

/// What the server shows to be let in: a token, or name and password, or nothing.
fn authorization(settings: &settings::Influx) -> anyhow::Result<Option<HeaderValue>> {
    let text = if !settings.token_file.as_os_str().is_empty() {
        format!("Token {}", secret("sinks.influx.token_file", &settings.token_file)?)
    } else if !settings.user.is_empty() {
        let password = secret("sinks.influx.password_file", &settings.password_file)?;
        format!("Basic {}", Base64::encode_string(format!("{}:{password}", settings.user).as_bytes()))
    } else {
        return Ok(None);
    };
    let mut value = HeaderValue::from_str(&text)
        .context("the secret of sinks.influx has characters that cannot be sent")?;
    value.set_sensitive(true);
    Ok(Some(value))
}
