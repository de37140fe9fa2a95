//! Compresses months of the history that are over, while the server records: slowly, with a rest after each some thousand messages
//! that is four times as long. Only making a month ready, by small steps, and giving its new file the name are the recorder's. While
//! something reads the month, the latter is tried again.

use crate::clock::{self, Clock};
use crate::packing::{Failed, blocking};
use crate::recorder::Recorder;
use std::path::PathBuf;
use std::time::{Duration, Instant};
use store::{Adopted, CompressedMonth, MonthKey, PackableMonth, PackedMonth, Readiness, Store, plan_months};
use tokio_util::sync::CancellationToken;

/// When the first look is, after the start, and how long after each look the next one.
const FIRST_LOOK: Duration = Duration::from_mins(10);
const LOOK_EVERY: Duration = Duration::from_hours(1);
/// How much longer than a turn the rest after it is, and how long it is at most.
const REST: u32 = 4;
const LONGEST_REST: Duration = Duration::from_millis(500);
/// How long after the first try to replace a month that something reads the next one is, at most how long after a later one, and for how
/// long it is tried: longer than an export over a slow line.
const FIRST_WAIT: Duration = Duration::from_secs(1);
const LONGEST_WAIT: Duration = Duration::from_mins(1);
const LONGEST_BUSY: Duration = Duration::from_hours(6);

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
        let (mut told, mut announced): (Option<String>, usize) = (None, 0);
        let mut wait = FIRST_LOOK;
        while stop.run_until_cancelled(tokio::time::sleep(wait)).await.is_some() {
            announced = self.announce(announced).await;
            let trouble = self.compress(REST, &stop).await.err().filter(|_| !stop.is_cancelled());
            metrics::gauge!("lutra_month_compression_trouble").set(f64::from(u8::from(trouble.is_some())));
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

    /// Says how many months are due where those are more than were `announced`, as after an upgrade; how many that is.
    async fn announce(&self, announced: usize) -> usize {
        let Ok(months) = self.due().await else { return announced };
        if months.len() > announced {
            tracing::info!(
                months = months.len(),
                mib = months.iter().map(|month| month.bytes).sum::<u64>() >> 20,
                oldest = months[0].key.file_name(),
                "months of the history that are over will be compressed, one after the other, slowly, while the server records; \
                 SQL cannot read their messages then, and earlier versions leave the history alone \
                 (history.compress_after_days = 0 keeps months as they are)"
            );
        }
        months.len()
    }

    async fn due(&self) -> Result<Vec<PackableMonth>, Failed> {
        let now = self.clock.utc();
        clock::check(now).map_err(Failed::new)?;
        let (data, after_days) = (self.data.clone(), self.after_days);
        blocking(move || plan_months(&data, after_days, now)).await
    }

    /// Compresses the months that are due, the oldest first.
    ///
    /// # Errors
    /// The first thing that went wrong. The month stays as it was; others are compressed all the same.
    async fn compress(&self, rest: u32, stop: &CancellationToken) -> Result<Vec<CompressedMonth>, Failed> {
        let months = self.due().await?;
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
                // Something came for it meanwhile, or the server ends.
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
        if !self.ready(month.key, rest, stop).await? {
            return Ok(None);
        }
        let (data, stopped) = (self.data.clone(), stop.clone());
        let make = move || {
            let mut began = Instant::now();
            let made = PackedMonth::make(&data, &month, &mut |_| {
                // This thread is for nothing else.
                std::thread::sleep((began.elapsed() * rest).min(LONGEST_REST));
                began = Instant::now();
                !stopped.is_cancelled()
            });
            Ok(made)
        };
        match blocking(make).await? {
            Ok(packed) => self.adopt(packed, stop).await,
            Err(error) => {
                let failed = Failed::new(error.to_string());
                // A chunk that is damaged is moved out of the way; the next look goes on without it.
                let mend = move |store: &mut Store| store.mend(&error);
                let is_mended = self.recorder.with_store(mend).await.transpose()?.unwrap_or(false);
                if is_mended {
                    tracing::warn!(reason = failed.text, "a damaged part of the history is set aside");
                }
                Err(failed)
            }
        }
    }

    /// Makes a month ready, and lets the recorder record between the steps; false when the server ends.
    async fn ready(&self, key: MonthKey, rest: u32, stop: &CancellationToken) -> Result<bool, Failed> {
        let mut longest = Duration::ZERO;
        loop {
            let step = move |store: &mut Store| {
                let began = Instant::now();
                store.ready_month_some(key).map(|ready| (ready, began.elapsed()))
            };
            let Some(stepped) = self.recorder.with_store(step).await else { return Ok(false) };
            let (ready, took) = stepped?;
            longest = longest.max(took);
            match ready {
                Readiness::Ready => {
                    tracing::debug!(month = key.file_name(), longest_hold = ?longest, "a month is ready");
                    return Ok(true);
                }
                Readiness::Unfinished => {}
                Readiness::Behind => {
                    let text =
                        "the history lacks packets of the archive; months are compressed when it has them";
                    return Err(Failed::new(text.to_owned()));
                }
            }
            let pause = tokio::time::sleep((took * rest).min(LONGEST_REST));
            if stop.run_until_cancelled(pause).await.is_none() {
                return Ok(false);
            }
        }
    }

    /// Gives a compressed month its name, as soon as nothing reads the month.
    async fn adopt(
        &self,
        mut packed: PackedMonth,
        stop: &CancellationToken,
    ) -> Result<Option<CompressedMonth>, Failed> {
        let name = packed.key().file_name();
        let (mut wait, mut waited) = (FIRST_WAIT, Duration::ZERO);
        loop {
            let adopt = move |store: &mut Store| {
                let began = Instant::now();
                store.adopt_month(packed).map(|adopted| (adopted, began.elapsed()))
            };
            let Some(adopted) = self.recorder.with_store(adopt).await else { return Ok(None) };
            let (adopted, hold) = adopted?;
            tracing::debug!(month = name, ?hold, "a compressed month was to get its name");
            packed = match adopted {
                Adopted::Done(month, replaced) => {
                    tokio::task::spawn_blocking(move || drop(replaced)).await.ok();
                    return Ok(Some(month));
                }
                Adopted::Changed => {
                    tracing::info!(
                        month = name,
                        "something came for a month while it was compressed; it stays as it is"
                    );
                    return Ok(None);
                }
                Adopted::Busy(packed) => packed,
            };
            if waited >= LONGEST_BUSY {
                let text =
                    format!("something has read history/{name} for {} hours", waited.as_secs() / 3_600);
                return Err(Failed::new(text));
            }
            if waited.is_zero() {
                tracing::info!(month = name, "a month is compressed and waits until nothing reads it");
            }
            if stop.run_until_cancelled(tokio::time::sleep(wait)).await.is_none() {
                return Ok(None);
            }
            waited += wait;
            wait = (wait * 2).min(LONGEST_WAIT);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::owners::Owners;
    use store::{Reader, Transport};
    use units::UtcTime;

    const DAY_US: i64 = 86_400_000_000;

    /// A folder with a month that is over and one that is not, and a recorder that writes to it.
    struct Recording {
        compression: MonthCompression,
        thread: std::thread::JoinHandle<()>,
        _folder: tempfile::TempDir,
    }

    fn recording() -> Recording {
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
        let compression = MonthCompression { data, after_days: 31, recorder, clock };
        Recording { compression, thread, _folder: folder }
    }

    #[tokio::test]
    async fn months_that_are_over_are_compressed_while_the_recorder_records() {
        let Recording { compression, thread, _folder } = recording();
        let stop = CancellationToken::new();
        let done = compression.compress(0, &stop).await.unwrap();
        assert_eq!((done.len(), done[0].rows), (1, 200), "the month that is not over stays: {done:?}");
        assert_eq!(compression.compress(0, &stop).await.unwrap(), []);
        let series = Reader::open(&compression.data).unwrap().series(None).unwrap();
        assert_eq!(series[0].extent.count, 400);
        compression.recorder.close();
        thread.join().unwrap();
    }

    // A second: that is how long after the first try the second one is.
    #[tokio::test]
    async fn a_month_that_is_read_is_replaced_when_the_reader_is_done() {
        let Recording { compression, thread, _folder } = recording();
        let stop = CancellationToken::new();
        let data = compression.data.clone();
        let month = plan_months(&data, 31, compression.clock.utc()).unwrap()[0];
        assert!(compression.ready(month.key, 0, &stop).await.unwrap());
        let packed = PackedMonth::make(&data, &month, &mut |_| true).unwrap();
        let mut reader = Reader::open(&data).unwrap();
        let source =
            store::Source { system: imc::Address(0x2810), entity: 255, message: "Temperature".to_owned() };
        reader.samples(&source, &["value"], store::TimeRange::ALL, 10).unwrap();
        let try_once = move |store: &mut Store| store.adopt_month(packed);
        let tried = compression.recorder.with_store(try_once).await.unwrap().unwrap();
        let Adopted::Busy(packed) = tried else { panic!("something reads it: {tried:?}") };
        let end_reading = async {
            // It comes to the recorder after the first try.
            compression.recorder.with_store(|_| ()).await;
            drop(reader);
        };
        let (adopted, ()) = tokio::join!(compression.adopt(packed, &stop), end_reading);
        assert_eq!(adopted.unwrap().map(|month| month.rows), Some(200));
        assert_eq!(plan_months(&data, 31, compression.clock.utc()).unwrap(), []);
        compression.recorder.close();
        thread.join().unwrap();
    }
}
