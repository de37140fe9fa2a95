//! Compresses months of the history that are over, while the server records: slowly, with a rest after each some thousand messages
//! that is four times as long. Only making a month ready and giving its new file the name are the recorder's.

use crate::clock::{self, Clock};
use crate::packing::{Failed, blocking};
use crate::recorder::Recorder;
use std::path::PathBuf;
use std::time::{Duration, Instant};
use store::{CompressedMonth, PackableMonth, PackedMonth, Store, plan_months};
use tokio_util::sync::CancellationToken;

/// When the first look is, after the start, and how long after each look the next one.
const FIRST_LOOK: Duration = Duration::from_mins(10);
const LOOK_EVERY: Duration = Duration::from_hours(1);
/// How much longer than a turn the rest after it is, and how long it is at most.
const REST: u32 = 4;
const LONGEST_REST: Duration = Duration::from_millis(500);

/// The service.
pub(crate) struct MonthCompression {
    pub(crate) data: PathBuf,
    /// So many days after its end a month is compressed.
    pub(crate) after_days: u16,
    pub(crate) recorder: Recorder,
    pub(crate) clock: Clock,
}

impl MonthCompression {
    /// Compresses what is due, now and then, until the server ends.
    pub(crate) async fn keep(self, stop: CancellationToken) {
        let mut told: Option<String> = None;
        let mut wait = FIRST_LOOK;
        while stop.run_until_cancelled(tokio::time::sleep(wait)).await.is_some() {
            let trouble = self.compress(REST, &stop).await.err().filter(|_| !stop.is_cancelled());
            if let Some(trouble) = trouble.as_ref().filter(|trouble| Some(trouble.cause()) != told.as_deref())
            {
                tracing::warn!(
                    reason = trouble.text,
                    "months of the history are not compressed; they stay as they are"
                );
            }
            told = trouble.map(|trouble| trouble.cause().to_owned());
            wait = LOOK_EVERY;
        }
    }

    /// Compresses the months that are due, the oldest first.
    ///
    /// # Errors
    /// The first thing that went wrong. The month stays as it was; others are compressed all the same.
    async fn compress(&self, rest: u32, stop: &CancellationToken) -> Result<Vec<CompressedMonth>, Failed> {
        let now = self.clock.utc();
        clock::check(now).map_err(Failed::new)?;
        let (data, after_days) = (self.data.clone(), self.after_days);
        let months = blocking(move || plan_months(&data, after_days, now)).await?;
        let (mut compressed, mut trouble) = (Vec::new(), None);
        for month in months {
            match self.one(month, rest, stop).await {
                Ok(Some(month)) => {
                    tracing::info!(
                        month = month.key.file_name(),
                        mib = month.bytes >> 20,
                        compressed_mib = month.packed_bytes >> 20,
                        "a month of the history is compressed"
                    );
                    compressed.push(month);
                }
                // Something came for it or read it meanwhile, the history lacks something, or the server ends.
                Ok(None) => {}
                Err(failed) => {
                    trouble.get_or_insert(failed);
                }
            }
        }
        trouble.map_or(Ok(compressed), Err)
    }

    async fn one(
        &self,
        month: PackableMonth,
        rest: u32,
        stop: &CancellationToken,
    ) -> Result<Option<CompressedMonth>, Failed> {
        let ready = move |store: &mut Store| store.ready_month(month.key);
        if !self.recorder.with_store(ready).await.transpose()?.unwrap_or(false) {
            return Ok(None);
        }
        let (data, stop) = (self.data.clone(), stop.clone());
        let make = move || {
            let mut began = Instant::now();
            PackedMonth::make(&data, &month, &mut |_| {
                // This thread is for nothing else.
                std::thread::sleep((began.elapsed() * rest).min(LONGEST_REST));
                began = Instant::now();
                !stop.is_cancelled()
            })
        };
        let packed = blocking(make).await?;
        let adopt = move |store: &mut Store| store.adopt_month(packed);
        Ok(self.recorder.with_store(adopt).await.transpose()?.flatten())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::owners::Owners;
    use store::{Reader, Transport};
    use units::UtcTime;

    const DAY_US: i64 = 86_400_000_000;

    #[tokio::test]
    async fn months_that_are_over_are_compressed_while_the_recorder_records() {
        let folder = tempfile::tempdir().unwrap();
        let data = folder.path().to_owned();
        let (clock, _hand) = Clock::with_hand();
        let mut store = Store::open(&data).unwrap();
        for days_ago in [100, 0] {
            for number in 0..200 {
                let received = UtcTime::from_micros(clock.utc().micros() - days_ago * DAY_US + number);
                let header = imc::Header {
                    timestamp: received.seconds(),
                    src: imc::Address(0x2810),
                    ..imc::Header::default()
                };
                let mut packet = Vec::new();
                imc::encode_into(&mut packet, &header, &imc::messages::Temperature { value: 1.0 }).unwrap();
                let (transport, link) = (Transport::Tcp, None);
                store.accept(&store::Accepted { packet: &packet, received, transport, link }).unwrap();
            }
        }
        store.commit().unwrap();
        let (recorder, thread) = Recorder::start(store, &Owners::new(clock.clone())).unwrap();
        let compression =
            MonthCompression { data: data.clone(), after_days: 31, recorder: recorder.clone(), clock };
        let stop = CancellationToken::new();
        let done = compression.compress(0, &stop).await.unwrap();
        assert_eq!((done.len(), done[0].rows), (1, 200), "the month that is not over stays: {done:?}");
        assert_eq!(compression.compress(0, &stop).await.unwrap(), []);
        let series = Reader::open(&data).unwrap().series(None).unwrap();
        assert_eq!(series[0].extent.count, 400);
        recorder.close();
        thread.join().unwrap();
    }
}
