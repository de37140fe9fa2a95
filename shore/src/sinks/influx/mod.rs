//! InfluxDB as a second history: everything in the archive goes there too, as lines that Grafana can draw.
//!
//! One task reads what is durable, sends it and moves on when it arrived. While the database is away the archive
//! waits for it, so nothing is lost and nothing grows in memory. Lines carry all that tells them apart, so that
//! one that is sent twice is there once.

mod client;
mod line;

use super::Influx;
use super::SinkState;
use crate::clock::Clock;
use crate::recorder::Recorder;
use anyhow::Context as _;
use base64ct::{Base64, Encoding as _};
use client::{Answer, Client};
use hyper::header::HeaderValue;
use std::path::Path;
use std::time::Duration;
use store::{Marks, Place, Tail};
use tokio::sync::watch;
use tokio_util::sync::CancellationToken;

/// How often it is looked for something new.
const LOOK_EVERY: Duration = Duration::from_millis(500);
/// Lines sent at once, and their bytes.
const BATCH_LINES: usize = 5_000;
const BATCH_BYTES: usize = 2 << 20;
/// After a failure it is tried again after the first, and at last as often as the second.
const AGAIN: (Duration, Duration) = (Duration::from_secs(1), Duration::from_mins(1));

/// Carries the archive to an InfluxDB.
pub(crate) struct Sink {
    client: Client,
    tail: Tail,
    recorder: Recorder,
    address: String,
    /// How long to wait after a failure; `None` while all is well.
    again: Option<Duration>,
    told_refused: bool,
    clock: Clock,
    state: watch::Sender<SinkState>,
}

/// Lines that belong together, and where reading goes on behind them.
struct Batch {
    lines: Vec<String>,
    place: Place,
}

impl Sink {
    /// As it is configured; `None` when it is not.
    ///
    /// # Errors
    /// What is configured cannot be used; the error names the key.
    pub(crate) fn new(
        settings: &Influx,
        data: &Path,
        recorder: Recorder,
        clock: Clock,
    ) -> anyhow::Result<Option<Self>> {
        if settings.url.is_empty() {
            return Ok(None);
        }
        let client =
            Client::new(&settings.url, &settings.database, authorization(settings)?, &settings.ca_file)?;
        let address = format!("{} database {}", settings.url, settings.database);
        let tail = Tail::open(data, "influx", &address)?;
        let state = watch::Sender::new(SinkState { target: address.clone(), ..SinkState::default() });
        Ok(Some(Self { client, tail, recorder, address, again: None, told_refused: false, clock, state }))
    }

    /// How it gets on.
    pub(crate) fn state(&self) -> watch::Receiver<SinkState> {
        self.state.subscribe()
    }

    /// Carries until the server ends.
    pub(crate) async fn run(mut self, stop: CancellationToken) {
        loop {
            let wait = match self.carry(&stop).await {
                Ok(()) => {
                    self.state.send_modify(|state| state.trouble = None);
                    if self.again.take().is_some() {
                        tracing::info!(database = self.address, "InfluxDB takes lines again");
                    }
                    LOOK_EVERY
                }
                Err(error) => self.trouble(&error),
            };
            if stop.run_until_cancelled(tokio::time::sleep(wait)).await.is_none() {
                return;
            }
        }
    }

    fn trouble(&mut self, error: &anyhow::Error) -> Duration {
        metrics::counter!("lutra_sink_failures_total", "sink" => "influx").increment(1);
        self.state.send_modify(|state| state.trouble = Some(format!("{error:#}")));
        if self.again.is_none() {
            tracing::error!(database = self.address, "InfluxDB: {error:#}; the archive waits for it");
        }
        let wait = self.again.map_or(AGAIN.0, |before| (before * 2).min(AGAIN.1));
        self.again = Some(wait);
        wait
    }

    /// Carries everything that is durable now.
    async fn carry(&mut self, stop: &CancellationToken) -> anyhow::Result<()> {
        let Some(marks) = self.recorder.with_store(|store| store.marks()).await else { return Ok(()) };
        loop {
            let behind = self.tail.behind(&marks);
            metrics::gauge!("lutra_sink_waiting_bytes", "sink" => "influx").set(behind as f64);
            self.state.send_modify(|state| state.behind_bytes = Some(behind));
            if stop.is_cancelled() {
                return Ok(());
            }
            let (tail, until) = (self.tail.clone(), marks.clone());
            let batch = tokio::task::spawn_blocking(move || read(&tail, &until)).await??;
            let Some(batch) = batch else { return Ok(()) };
            let refused = self.send(&batch.lines).await?;
            let kept = batch.lines.len() as u64 - refused.min(batch.lines.len() as u64);
            metrics::counter!("lutra_sink_lines_total", "sink" => "influx", "what" => "kept").increment(kept);
            metrics::counter!("lutra_sink_lines_total", "sink" => "influx", "what" => "refused")
                .increment(refused);
            let now = self.clock.utc();
            self.state.send_modify(|state| {
                state.kept += kept;
                state.refused += refused;
                state.last = Some(now);
            });
            self.tail.carried(batch.place, &marks)?;
        }
    }

    /// Sends lines; how many were refused for good. Those that spoil a batch are found by halving it.
    async fn send(&mut self, lines: &[String]) -> anyhow::Result<u64> {
        let (mut parts, mut refused) = (vec![lines], 0);
        while let Some(part) = parts.pop().filter(|part| !part.is_empty()) {
            match self.client.write(&part.concat()).await? {
                Answer::Kept => {}
                Answer::Refused(_) if part.len() > 1 => {
                    let (first, second) = part.split_at(part.len() / 2);
                    parts.extend([second, first]);
                }
                Answer::Partly(reason) | Answer::Refused(reason) => {
                    refused += 1;
                    if !self.told_refused {
                        self.told_refused = true;
                        tracing::warn!(
                            database = self.address,
                            reason,
                            "InfluxDB refuses lines; the archive has them"
                        );
                    }
                }
            }
        }
        Ok(refused)
    }
}

/// The next lines.
fn read(tail: &Tail, marks: &Marks) -> anyhow::Result<Option<Batch>> {
    let (mut lines, mut bytes) = (Vec::new(), 0);
    let place = tail.read(marks, |archived| {
        let mut text = String::new();
        line::write(&mut text, &archived.view, archived.arrival.received);
        bytes += text.len();
        lines.push(text);
        lines.len() < BATCH_LINES && bytes < BATCH_BYTES
    })?;
    Ok(place.map(|place| Batch { lines, place }))
}

/// What the server shows to be let in: a token, or name and password, or nothing.
fn authorization(settings: &Influx) -> anyhow::Result<Option<HeaderValue>> {
    let secret = |key: &str, path: &Path| {
        let text = std::fs::read_to_string(path);
        text.with_context(|| format!("sinks.influx.{key} {}", path.display()))
            .map(|text| text.trim().to_owned())
    };
    let text = if !settings.token_file.as_os_str().is_empty() {
        format!("Token {}", secret("token_file", &settings.token_file)?)
    } else if !settings.user.is_empty() {
        let both = format!("{}:{}", settings.user, secret("password_file", &settings.password_file)?);
        format!("Basic {}", Base64::encode_string(both.as_bytes()))
    } else {
        return Ok(None);
    };
    let mut value = HeaderValue::from_str(&text)
        .context("the secret of sinks.influx has characters that cannot be sent")?;
    value.set_sensitive(true);
    Ok(Some(value))
}
