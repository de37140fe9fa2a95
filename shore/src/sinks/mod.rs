//! Other stores that follow the archive, beside the history. Each remembers how far it got, so that one that is
//! away, slow or new gets everything once it is there, and none of them holds up recording.

mod influx;
mod settings;

pub use settings::{Influx, Sinks as Settings};

use crate::clock::Clock;
use crate::recorder::Recorder;
use std::path::Path;
use tokio::sync::watch;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;
use units::UtcTime;

/// The sinks that are configured, before they carry anything.
pub(crate) struct Sinks {
    influx: Option<Box<influx::Sink>>,
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
        let influx = influx::Sink::new(&settings.influx, data, recorder.clone(), clock.clone())?;
        Ok(Self { influx: influx.map(Box::new) })
    }

    /// How each gets on.
    pub(crate) fn states(&self) -> Vec<watch::Receiver<SinkState>> {
        self.influx.iter().map(|sink| sink.state()).collect()
    }

    /// Lets each carry until `stop`.
    pub(crate) fn run(self, tasks: &TaskTracker, stop: &CancellationToken) {
        if let Some(sink) = self.influx {
            tasks.spawn(sink.run(stop.clone()));
        }
    }
}

/// How a sink gets on, for people.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct SinkState {
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
