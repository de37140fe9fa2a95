//! What all sinks have in common: the archive is read along, handed over batch by batch, and a cursor moves on once a batch is kept.
//!
//! One task for each sink. In memory is one batch at a time, so a sink that is slow holds up itself alone: the archive waits for
//! it on the disk. What fails is tried again, ever more seldom, from where the cursor stands, so everything arrives at least
//! once. How it gets on is published ([`SinkState`]) and measured.

use super::SinkState;
use crate::clock::Clock;
use crate::recorder::Recorder;
use imc::PacketView;
use std::future::Future;
use std::path::Path;
use std::time::Duration;
use store::{Marks, Place, Tail};
use tokio::sync::watch;
use tokio_util::sync::CancellationToken;
use units::UtcTime;

/// How often it is looked for something new.
const LOOK_EVERY: Duration = Duration::from_millis(500);
/// After a failure it is tried again after the first, and at last as often as the second.
const AGAIN: (Duration, Duration) = (Duration::from_secs(1), Duration::from_mins(1));

/// A store or a service that gets what the archive has.
///
/// After an error, of whatever call, [`Sink::open`] is called anew, and the batch comes again.
pub(crate) trait Sink: Send + 'static {
    /// What goes there of a packet.
    type Item: Send + Sync + 'static;
    /// As figures and the file of the cursor call it.
    const NAME: &'static str;
    /// As people call it.
    const TITLE: &'static str;

    /// Items handed over at once.
    const BATCH_ITEMS: usize;
    /// Bytes of items handed over at once.
    const BATCH_BYTES: usize = 2 << 20;

    /// What it carries to, for people.
    fn target(&self) -> String;

    /// What the cursor belongs to: with another it starts over.
    fn cursor(&self) -> String {
        self.target()
    }

    /// What is kept beside the cursor, for [`Sink::resume`] after a restart; empty for nothing.
    fn note(&self) -> String {
        String::new()
    }

    /// What [`Sink::note`] said when the cursor was kept last; called once, at the start.
    fn resume(&mut self, _note: &str) {}

    /// Whether [`Sink::open`] found that what was carried before is no longer there: then everything is carried again.
    fn has_lost_all(&self) -> bool {
        false
    }

    /// Whether it gets what the archive had before it was configured.
    fn wants_the_past(&self) -> bool;

    /// What goes there of a packet that came at `received`, and how many bytes that takes.
    fn item(view: &PacketView<'_>, received: UtcTime) -> (Self::Item, usize);

    /// Makes the way there, if there is none; called before each look at the archive.
    fn open(&mut self) -> impl Future<Output = anyhow::Result<()>> + Send;

    /// Hands a batch over.
    fn write(&mut self, batch: &[Self::Item]) -> impl Future<Output = anyhow::Result<()>> + Send;

    /// Waits until everything that was handed over is kept there, or refused for good.
    fn flush(&mut self) -> impl Future<Output = anyhow::Result<Refused>> + Send;
}

/// What of a batch a sink will never take.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub(crate) struct Refused {
    pub(crate) count: u64,
    /// Why the first of them.
    pub(crate) reason: String,
}

impl Refused {
    /// One more is refused.
    pub(crate) fn add(&mut self, reason: impl FnOnce() -> String) {
        if self.count == 0 {
            self.reason = reason();
        }
        self.count += 1;
    }
}

/// Carries the archive to a sink.
pub(crate) struct Carrier<S> {
    sink: S,
    tail: Tail,
    recorder: Recorder,
    target: String,
    /// How long to wait after a failure; `None` while all is well.
    again: Option<Duration>,
    has_said_refused: bool,
    clock: Clock,
    state: watch::Sender<SinkState>,
}

/// Items that belong together, and where reading goes on behind them.
struct Batch<I> {
    items: Vec<I>,
    place: Place,
}

impl<S: Sink> Carrier<S> {
    /// For a data folder.
    ///
    /// # Errors
    /// The file of the cursor holds something else.
    pub(crate) fn new(mut sink: S, data: &Path, recorder: Recorder, clock: Clock) -> anyhow::Result<Self> {
        let target = sink.target();
        let tail = Tail::open(data, S::NAME, &sink.cursor())?;
        sink.resume(tail.note());
        let state = SinkState { kind: S::TITLE, target: target.clone(), ..SinkState::default() };
        let state = watch::Sender::new(state);
        Ok(Self { sink, tail, recorder, target, again: None, has_said_refused: false, clock, state })
    }

    /// How it gets on.
    pub(crate) fn state(&self) -> watch::Receiver<SinkState> {
        self.state.subscribe()
    }

    /// Carries until the server ends.
    pub(crate) async fn run(mut self, stop: CancellationToken) {
        loop {
            // A sink that hangs does not hold up the end: what it did not confirm comes again.
            let Some(outcome) = stop.run_until_cancelled(self.carry(&stop)).await else { return };
            let wait = match outcome {
                Ok(()) => {
                    self.state.send_modify(|state| state.trouble = None);
                    if self.again.take().is_some() {
                        tracing::info!(to = self.target, "{} takes packets again", S::TITLE);
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
        metrics::counter!("lutra_sink_failures_total", "sink" => S::NAME).increment(1);
        self.state.send_modify(|state| state.trouble = Some(format!("{error:#}")));
        if self.again.is_none() {
            tracing::error!(to = self.target, "{}: {error:#}; the archive waits for it", S::TITLE);
        }
        let wait = self.again.map_or(AGAIN.0, |before| (before * 2).min(AGAIN.1));
        self.again = Some(wait);
        wait
    }

    /// Carries everything that is durable now.
    async fn carry(&mut self, stop: &CancellationToken) -> anyhow::Result<()> {
        let Some(marks) = self.recorder.with_store(|store| store.marks()).await else { return Ok(()) };
        if self.tail.is_new() && !self.sink.wants_the_past() {
            let bytes = self.tail.behind(&marks);
            if bytes > 0 {
                tracing::warn!(
                    to = self.target,
                    bytes,
                    "{} begins with what comes from now on: what was recorded before is passed over",
                    S::TITLE
                );
            }
            self.tail.pass_over(&marks)?;
        }
        self.publish_behind(&marks);
        self.sink.open().await?;
        if self.sink.has_lost_all() {
            tracing::warn!(
                to = self.target,
                "{} no longer holds what was sent before; everything is sent again",
                S::TITLE
            );
            self.tail.start_over();
            self.publish_behind(&marks);
        }
        loop {
            if stop.is_cancelled() {
                return Ok(());
            }
            let (tail, until) = (self.tail.clone(), marks.clone());
            let batch = tokio::task::spawn_blocking(move || read::<S>(&tail, &until)).await??;
            let Some(batch) = batch else { return Ok(()) };
            self.sink.write(&batch.items).await?;
            let refused = self.sink.flush().await?;
            self.kept(batch.items.len() as u64, refused);
            self.tail.set_note(self.sink.note());
            self.tail.carried(batch.place, &marks)?;
            self.publish_behind(&marks);
        }
    }

    fn publish_behind(&self, marks: &Marks) {
        let behind = self.tail.behind(marks);
        metrics::gauge!("lutra_sink_waiting_bytes", "sink" => S::NAME).set(behind as f64);
        self.state.send_modify(|state| state.behind_bytes = Some(behind));
    }

    fn kept(&mut self, all: u64, Refused { count, reason }: Refused) {
        let (refused, kept) = (count.min(all), all.saturating_sub(count));
        metrics::counter!("lutra_sink_lines_total", "sink" => S::NAME, "what" => "kept").increment(kept);
        metrics::counter!("lutra_sink_lines_total", "sink" => S::NAME, "what" => "refused")
            .increment(refused);
        if refused > 0 && !self.has_said_refused {
            self.has_said_refused = true;
            tracing::warn!(to = self.target, reason, "{} refuses packets; the archive has them", S::TITLE);
        }
        let now = self.clock.utc();
        self.state.send_modify(|state| {
            state.kept += kept;
            state.refused += refused;
            state.last = Some(now);
        });
    }
}

/// The next items.
fn read<S: Sink>(tail: &Tail, marks: &Marks) -> anyhow::Result<Option<Batch<S::Item>>> {
    let (mut items, mut bytes) = (Vec::new(), 0);
    let place = tail.read(marks, |archived| {
        let (item, its_bytes) = S::item(&archived.view, archived.arrival.received);
        bytes += its_bytes;
        items.push(item);
        items.len() < S::BATCH_ITEMS && bytes < S::BATCH_BYTES
    })?;
    Ok(place.map(|place| Batch { items, place }))
}
