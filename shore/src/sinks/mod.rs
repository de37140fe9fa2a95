//! Other stores that follow the archive, beside the history. Each remembers how far it got, so that one that is
//! away, slow or new gets everything once it is there, and none of them holds up recording.
//!
//! `carrier` reads along, tries again and moves the cursor; a store is a `carrier::Sink`: `influx` and `mqtt`.

mod carrier;
mod influx;
mod mqtt;
mod point;
mod settings;

pub use settings::{Influx, Mqtt, Sinks as Settings};

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
        let influx = influx.map(|sink| Carrier::new(sink, data, recorder.clone(), clock.clone()));
        let mqtt = mqtt.map(|sink| Carrier::new(sink, data, recorder.clone(), clock.clone()));
        Ok(Self { influx: influx.transpose()?.map(Box::new), mqtt: mqtt.transpose()?.map(Box::new) })
    }

    /// How each gets on.
    pub(crate) fn states(&self) -> Vec<watch::Receiver<SinkState>> {
        let influx = self.influx.iter().map(|sink| sink.state());
        influx.chain(self.mqtt.iter().map(|sink| sink.state())).collect()
    }

    /// Lets each carry until `stop`.
    pub(crate) fn run(self, tasks: &TaskTracker, stop: &CancellationToken) {
        if let Some(sink) = self.influx {
            tasks.spawn(sink.run(stop.clone()));
        }
        if let Some(sink) = self.mqtt {
            tasks.spawn(sink.run(stop.clone()));
        }
    }
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
