//! Other stores that follow the archive, beside the history. Each remembers how far it got, so that one that is
//! away, slow or new gets everything once it is there, and none of them holds up recording.
//!
//! `carrier` reads along, tries again and moves the cursor; a store is a `carrier::Sink`: `influx`, `mqtt` and `postgres`.

mod carrier;
mod influx;
mod mqtt;
mod point;
mod postgres;
mod settings;

pub use settings::{Influx, Mqtt, Postgres, Sinks as Settings};

use crate::clock::Clock;
use crate::recorder::Recorder;
use anyhow::Context as _;
use carrier::Carrier;
use std::path::Path;
use tokio::sync::watch;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;
use units::UtcTime;

/// The sinks that are configured, before they carry anything.
pub(crate) struct Sinks {
    influx: Option<Box<Carrier<influx::Influx>>>,
    mqtt: Option<Box<Carrier<mqtt::Mqtt>>>,
    postgres: Option<Box<Carrier<postgres::Postgres>>>,
}

impl Sinks {
    /// As they are configured.
    ///
    /// # Errors
    /// What is configured cannot be used; the error names the key.
    pub(crate) fn open(
        settings: &Settings,
        data: &Path,
        recorder: &Recorder,
        clock: &Clock,
    ) -> anyhow::Result<Self> {
        let influx = influx::Influx::new(&settings.influx)?;
        let mqtt = mqtt::Mqtt::new(&settings.mqtt)?;
        let postgres = postgres::Postgres::new(&settings.postgres)?;
        Ok(Self {
            influx: carrier(influx, data, recorder, clock)?,
            mqtt: carrier(mqtt, data, recorder, clock)?,
            postgres: carrier(postgres, data, recorder, clock)?,
        })
    }

    /// How each gets on.
    pub(crate) fn states(&self) -> Vec<watch::Receiver<SinkState>> {
        let influx = self.influx.iter().map(|sink| sink.state());
        let mqtt = self.mqtt.iter().map(|sink| sink.state());
        influx.chain(mqtt).chain(self.postgres.iter().map(|sink| sink.state())).collect()
    }

    /// Lets each carry until `stop`.
    pub(crate) fn run(self, tasks: &TaskTracker, stop: &CancellationToken) {
        if let Some(sink) = self.influx {
            tasks.spawn(sink.run(stop.clone()));
        }
        if let Some(sink) = self.mqtt {
            tasks.spawn(sink.run(stop.clone()));
        }
        if let Some(sink) = self.postgres {
            tasks.spawn(sink.run(stop.clone()));
        }
    }
}

/// What carries to a sink that is configured.
fn carrier<S: carrier::Sink>(
    sink: Option<S>,
    data: &Path,
    recorder: &Recorder,
    clock: &Clock,
) -> anyhow::Result<Option<Box<Carrier<S>>>> {
    let carrier = sink.map(|sink| Carrier::new(sink, data, recorder.clone(), clock.clone()));
    Ok(carrier.transpose()?.map(Box::new))
}

/// How a sink gets on, for people.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct SinkState {
    /// What it is, like `InfluxDB`.
    pub kind: &'static str,
    /// What it carries to.
    pub target: String,
    /// Bytes of packets that wait to be carried; `None` before it has looked.
    pub behind_bytes: Option<u64>,
    /// Packets that it carried since the start.
    pub kept: u64,
    /// Packets that were refused for good.
    pub refused: u64,
    /// When something arrived last.
    pub last: Option<UtcTime>,
    /// Why nothing arrives; `None` while all is well.
    pub trouble: Option<String>,
}

/// A secret that stands in a file; `key` is the setting that names it.
fn secret(key: &str, path: &Path) -> anyhow::Result<String> {
    let text = std::fs::read_to_string(path);
    text.with_context(|| format!("{key} {}", path.display())).map(|text| text.trim().to_owned())
}
