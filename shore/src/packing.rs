//! Compresses days of the archive to which nothing is added, while the server records: slowly, a few MiB at a time, with a rest
//! after each that is four times as long. Only the last step, the new names, is the recorder's.

use crate::clock::{self, Clock};
use crate::recorder::Recorder;
use std::path::PathBuf;
use std::time::{Duration, Instant};
use store::{Packable, PackedDay, Packing, Store, StoreError, plan_packing};
use tokio::task::spawn_blocking;
use tokio_util::sync::CancellationToken;

/// When the first look is, after the start, and how long after each look the next one.
const FIRST_LOOK: Duration = Duration::from_mins(2);
const LOOK_EVERY: Duration = Duration::from_hours(1);
/// Bytes of the plain files on which it works at once: some 30 ms.
const TURN_BYTES: u64 = 2 << 20;
/// How much longer than a turn the rest after it is.
const REST: u32 = 4;

/// The service.
pub(crate) struct Compression {
    pub(crate) data: PathBuf,
    /// So many days after its end a day is compressed.
    pub(crate) after_days: u16,
    pub(crate) recorder: Recorder,
    pub(crate) clock: Clock,
}

impl Compression {
    /// Compresses what is due, now and then, until the server ends.
    pub(crate) async fn keep(self, stop: CancellationToken) {
        let mut told: Option<String> = None;
        let mut wait = FIRST_LOOK;
        while stop.run_until_cancelled(tokio::time::sleep(wait)).await.is_some() {
            let Some(outcome) = stop.run_until_cancelled(self.compress(REST)).await else { return };
            let trouble = outcome.err();
            metrics::gauge!("lutra_compression_trouble").set(f64::from(u8::from(trouble.is_some())));
            if let Some(trouble) = trouble.as_ref().filter(|trouble| Some(trouble.cause()) != told.as_deref())
            {
                tracing::warn!(
                    reason = trouble.text,
                    "days of the archive are not compressed; they stay as they are"
                );
            }
            told = trouble.map(|trouble| trouble.cause().to_owned());
            wait = LOOK_EVERY;
        }
    }

    /// Compresses the days that are due, the oldest first; each turn is followed by a rest that is so much longer.
    ///
    /// # Errors
    /// The first thing that went wrong. The day stays as it was; other days are compressed all the same, smaller ones also
    /// where the disk has no room for this one.
    async fn compress(&self, rest: u32) -> Result<Vec<PackedDay>, Failed> {
        let now = self.clock.utc();
        clock::check(now).map_err(Failed::new)?;
        let (data, after_days) = (self.data.clone(), self.after_days);
        let days = blocking(move || plan_packing(&data, after_days, now)).await?;
        let (mut packed, mut trouble) = (Vec::new(), None);
        for day in days {
            match self.one(day, rest).await {
                Ok(Some(day)) => {
                    tracing::info!(
                        day = day.key.name(),
                        mib = day.plain_bytes >> 20,
                        compressed_mib = day.packed_bytes >> 20,
                        "a day of the archive is compressed"
                    );
                    packed.push(day);
                }
                // Something came for it meanwhile, or the server ends.
                Ok(None) => {}
                Err(failed) => {
                    trouble.get_or_insert(failed);
                }
            }
        }
        trouble.map_or(Ok(packed), Err)
    }

    async fn one(&self, day: Packable, rest: u32) -> Result<Option<PackedDay>, Failed> {
        let data = self.data.clone();
        let mut packing = blocking(move || Packing::begin(&data, &day)).await?;
        loop {
            let turn = move || {
                let began = Instant::now();
                packing.work(TURN_BYTES).map(|more| (packing, more, began.elapsed()))
            };
            let (worked, more, took) = blocking(turn).await?;
            packing = worked;
            if !more {
                break;
            }
            tokio::time::sleep(took * rest).await;
        }
        let adopt = move |store: &mut Store| (store.adopt(&mut packing), packing);
        let Some((adopted, packing)) = self.recorder.with_store(adopt).await else { return Ok(None) };
        // The room of the plain files is freed here, and not while the recorder waits.
        blocking(move || {
            drop(packing);
            Ok(())
        })
        .await?;
        Ok(adopted?)
    }
}

/// Why a day or a month was not compressed.
#[derive(Debug)]
pub(crate) struct Failed {
    pub(crate) text: String,
    /// Whether the disk has no room; the figures of it change from look to look.
    is_full: bool,
}

impl Failed {
    pub(crate) fn new(text: String) -> Self {
        Self { text, is_full: false }
    }

    /// What is reported once as long as it stays the same.
    pub(crate) fn cause(&self) -> &str {
        if self.is_full { "no room" } else { &self.text }
    }
}

impl From<StoreError> for Failed {
    fn from(error: StoreError) -> Self {
        let is_full = error.is_disk_full() || matches!(error, StoreError::NoRoom { .. });
        Self { text: error.to_string(), is_full }
    }
}

pub(crate) async fn blocking<T: Send + 'static>(
    work: impl FnOnce() -> store::Result<T> + Send + 'static,
) -> Result<T, Failed> {
    match spawn_blocking(work).await {
        Ok(done) => Ok(done?),
        Err(fault) => Err(Failed::new(fault.to_string())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::owners::Owners;
    use hub::Record;
    use store::Transport;
    use units::UtcTime;

    const DAY_US: i64 = 86_400_000_000;

    fn temperature(received: UtcTime, value: f32) -> Vec<u8> {
        let header = imc::Header {
            timestamp: received.seconds(),
            src: imc::Address(0x2810),
            ..imc::Header::default()
        };
        let mut packet = Vec::new();
        imc::encode_into(&mut packet, &header, &imc::messages::Temperature { value }).unwrap();
        packet
    }

    #[tokio::test]
    async fn old_days_are_compressed_while_the_recorder_records() {
        let folder = tempfile::tempdir().unwrap();
        let data = folder.path().to_owned();
        let (clock, _hand) = Clock::with_hand();
        let now = clock.utc();
        let at = |days_ago: i64, number: i64| UtcTime::from_micros(now.micros() - days_ago * DAY_US + number);
        let mut store = Store::open(&data).unwrap();
        for days_ago in [9, 8, 0] {
            for number in 0..200 {
                let received = at(days_ago, number);
                let packet = temperature(received, number as f32);
                store
                    .accept(&store::Accepted {
                        packet: &packet,
                        received,
                        transport: Transport::Tcp,
                        link: None,
                    })
                    .unwrap();
            }
        }
        store.commit().unwrap();
        let owners = Owners::new(clock.clone());
        let (recorder, thread) = Recorder::start(store, &owners).unwrap();
        let compression = Compression {
            data: data.clone(),
            after_days: 3,
            recorder: recorder.clone(),
            clock: clock.clone(),
        };
        let packed = compression.compress(0).await.unwrap();
        assert_eq!(packed.len(), 2, "the newest day stays plain: {packed:?}");
        assert!(packed.iter().all(|day| day.packed_bytes < day.plain_bytes / 2), "{packed:?}");
        assert_eq!(compression.compress(0).await.unwrap(), []);
        // A clock that was put back: a packet for a day that is compressed.
        let late = at(9, 500);
        let packet = temperature(late, 500.0);
        recorder.submit(vec![Record {
            packet: packet.into(),
            received: late,
            transport: Transport::Tcp,
            link: None,
        }]);
        recorder.close();
        thread.join().unwrap();
        let mut store = Store::open(&data).unwrap();
        assert_eq!(store.repairs().notes, Vec::<String>::new());
        store.settle().unwrap();
        let series = store::Reader::open(&data).unwrap().series(None).unwrap();
        assert_eq!(series.iter().map(|one| one.extent.count).sum::<u64>(), 601);
    }
}
