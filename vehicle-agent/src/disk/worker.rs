//! The disk's thread: carries out work in order.

use super::host::Host;
use super::journal::Journal;
use super::recording::Recorder;
use super::store::Store;
use super::{Done, Lost, Work};
use crate::setup;
use anyhow::Context as _;
use config::Config;
use std::io;
use std::path::PathBuf;
use std::time::Duration;
use units::{MonoTime, UtcTime};

/// Logs that may be opened in a row: a plan needs one at its start and one at its end.
pub(super) const ROTATIONS: u32 = 8;
/// Beyond that, one may be opened after this time.
pub(super) const ROTATION_PAUSE: Duration = Duration::from_secs(5);

/// Everything on disk.
#[derive(Debug)]
pub(crate) struct Tools {
    /// The log; none where the configuration has it off.
    pub(crate) journal: Option<Journal>,
    /// Plans.
    pub(crate) store: Store,
    /// The requested recording.
    pub(crate) recorder: Option<Recorder>,
    /// The configuration, beside which changed parameters are saved.
    pub(crate) config: Config,
    /// The folder whose free space is reported.
    pub(crate) logs: PathBuf,
}

/// The thread's state.
#[derive(Debug)]
pub(crate) struct Worker {
    tools: Tools,
    host: Host,
    rotations: Rotations,
    asked: Option<String>,
    /// Work that came while no log was open.
    missed: Lost,
    /// The task under way, if it could not be stored: tried again once a second until it is.
    refused_under_way: Option<UnderWay>,
}

/// The task under way for the next start: a packet, or `None` if there is none.
#[derive(Debug)]
struct UnderWay(Option<Vec<u8>>);

/// How many logs may be opened: some at once, and one more from time to time.
#[derive(Debug)]
struct Rotations {
    left: u32,
    next: MonoTime,
}

impl Rotations {
    fn allow(&mut self, now: MonoTime) -> bool {
        while self.left < ROTATIONS && now >= self.next {
            self.left += 1;
            self.next = self.next + ROTATION_PAUSE;
        }
        if self.left == ROTATIONS {
            self.next = now + ROTATION_PAUSE;
        }
        let allowed = self.left > 0;
        self.left = self.left.saturating_sub(1);
        allowed
    }
}

impl Worker {
    pub(crate) fn new(tools: Tools) -> Self {
        let rotations = Rotations { left: ROTATIONS, next: MonoTime::default() };
        Self {
            tools,
            host: Host::new(),
            rotations,
            asked: None,
            missed: Lost::default(),
            refused_under_way: None,
        }
    }

    pub(crate) fn is_recording(&self) -> bool {
        self.tools.recorder.is_some()
    }

    pub(crate) fn carry_out(&mut self, work: Work, answer: &impl Fn(Done)) {
        match work {
            Work::Packet(now, bytes) => {
                let Some(journal) = &mut self.tools.journal else { return };
                let written = journal.write(now, &bytes);
                if !matches!(written, Ok(true)) {
                    self.missed.count(&bytes);
                }
                if let Err(error) = written {
                    answer(Done::LogOpened(Err(error.to_string())));
                }
            }
            Work::Line(now, text) => {
                if let Some(Err(error)) = self.tools.journal.as_mut().map(|log| log.line(now, &text)) {
                    answer(Done::LogOpened(Err(error.to_string())));
                }
            }
            Work::Open(now, utc, label) => {
                self.asked = Some(label);
                self.rotate(now, utc, answer);
            }
            Work::Close(utc) => {
                if let Some(Err(error)) = self.tools.journal.as_mut().map(|log| log.close(utc)) {
                    tracing::error!("the end of the log is not written: {error}");
                }
            }
            Work::Plans(effect) => {
                let outcome = self.tools.store.carry_out(&effect).map_err(|error| format!("{error:#}"));
                answer(Done::Stored(effect.ticket(), outcome));
            }
            Work::UnderWay(packet) => {
                // A failure after an earlier one is not reported again.
                let is_news = self.refused_under_way.is_none();
                if let Err(error) = self.keep_under_way(UnderWay(packet))
                    && is_news
                {
                    let text =
                        "the plan under way, which the next start needs; it is tried again once a second";
                    answer(Done::NotKept(format!("{text}: {error:#}")));
                }
            }
            Work::Parameters(label, values) => {
                let outcome = self.save(&label, &values).map_err(|error| format!("{error:#}"));
                answer(Done::ParametersKept(label, outcome));
            }
            Work::Record(kind, bytes) => {
                let outcome = self.tools.recorder.as_mut().map(|recorder| recorder.put(kind, &bytes));
                if let Some(Err(error)) = outcome {
                    self.end_recording(&error.to_string(), answer);
                }
            }
            Work::EndRecording => self.end_recording("the disk is too slow for it", answer),
            Work::Tick(now, utc) => self.tick(now, utc, answer),
        }
    }

    /// Opens the requested log, when another may be opened.
    fn rotate(&mut self, now: MonoTime, utc: UtcTime, answer: &impl Fn(Done)) {
        let Some(journal) = &mut self.tools.journal else { return };
        if self.asked.is_none() || !self.rotations.allow(now) {
            return;
        }
        if let Some(label) = self.asked.take() {
            let outcome = journal.open(now, utc, &label);
            self.opened(outcome, answer);
        }
    }

    /// Reports that a log was opened, or not, and what the previous ones lack.
    fn opened(&mut self, outcome: io::Result<String>, answer: &impl Fn(Done)) {
        let well = outcome.is_ok();
        answer(Done::LogOpened(outcome.map_err(|error| error.to_string())));
        if well && !self.missed.is_none() {
            let missed = std::mem::take(&mut self.missed);
            answer(Done::NotKept(format!("while no log could be written: {missed}")));
        }
    }

    fn keep_under_way(&mut self, under_way: UnderWay) -> anyhow::Result<()> {
        let outcome = self.tools.store.keep_under_way(under_way.0.as_deref());
        self.refused_under_way = outcome.is_err().then_some(under_way);
        outcome
    }

    fn tick(&mut self, now: MonoTime, utc: UtcTime, answer: &impl Fn(Done)) {
        if let Some(packet) = self.refused_under_way.take()
            && self.keep_under_way(packet).is_ok()
        {
            tracing::info!("what is under way is kept again");
        }
        self.rotate(now, utc, answer);
        match self.tools.journal.as_mut().map(|log| log.tick(now, utc)) {
            None | Some(Ok(None)) => {}
            Some(Ok(Some(outcome))) => self.opened(outcome, answer),
            Some(Err(error)) => answer(Done::LogOpened(Err(error.to_string()))),
        }
        let flushed = self.tools.recorder.as_mut().map(Recorder::flush);
        if let Some(Err(error)) = flushed {
            self.end_recording(&error.to_string(), answer);
        }
        answer(Done::Host(self.host.read(&self.tools.logs)));
    }

    fn end_recording(&mut self, why: &str, answer: &impl Fn(Done)) {
        if self.tools.recorder.take().is_some() {
            answer(Done::NotKept(format!("the recording ends: {why}")));
        }
    }

    /// Writes changed parameters to the data folder, to be read after all others at the next start.
    fn save(&mut self, label: &str, values: &[(String, String)]) -> anyhow::Result<()> {
        let config = &self.tools.config;
        let path = config.saved_path().context("the vehicle has no name for a file")?;
        // Includes values that an earlier version saved beside the configuration.
        let beside = config.saved_beside().filter(|_| !path.exists());
        let (ini, _) = config::Ini::read(&config::Disk, beside.as_deref().unwrap_or(&path));
        let mut saved = config::Saved::from_ini(&ini);
        setup::save(config, &mut saved, label, values)?;
        let text = saved.to_text().map_err(|error| anyhow::anyhow!("{error}"))?;
        config::write_atomically(&path, &text).with_context(|| format!("writing {}", path.display()))
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        if let Some(Err(error)) = self.tools.recorder.as_mut().map(Recorder::flush) {
            tracing::error!("the recording lacks its end: {error}");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use imc::messages::{Abort, Heartbeat, Message, PlanControl};
    use imc::{Address, Header, Packet};
    use std::cell::RefCell;
    use std::path::Path;

    fn worker(folder: &Path) -> Worker {
        let (store, ..) = Store::open(&folder.join("plans")).unwrap();
        let logs = folder.join("logs");
        let journal = Some(Journal::new(&logs, Address(0x2810), 1, String::new()));
        let config = Config::load(&config::InMemory::new(), "none.ini".as_ref(), &[]);
        Worker::new(Tools { journal, store, recorder: None, config, logs })
    }

    #[test]
    fn what_came_while_no_log_could_be_written_is_told_when_one_can() {
        let folder = tempfile::tempdir().unwrap();
        let mut worker = worker(folder.path());
        std::fs::write(folder.path().join("logs"), "in the way").unwrap();
        let told = RefCell::new(Vec::new());
        let answer = |done| told.borrow_mut().push(done);
        let (utc, at) = (UtcTime::from_micros(1_790_000_000_000_000), MonoTime::from_micros);
        let packet =
            |message: Message| Work::Packet(at(0), Packet::new(Header::default(), message).encode().unwrap());
        worker.carry_out(Work::Open(at(0), utc, String::new()), &answer);
        for message in [Abort.into(), Heartbeat.into(), Heartbeat.into()] {
            worker.carry_out(packet(message), &answer);
        }
        assert!(matches!(told.borrow()[..], [Done::LogOpened(Err(_))]), "{told:?}");
        std::fs::remove_file(folder.path().join("logs")).unwrap();
        worker.carry_out(Work::Tick(at(40_000_000), utc), &answer);
        let told = told.borrow();
        let [_, Done::LogOpened(Ok(_)), Done::NotKept(missed), Done::Host(_)] = &told[..] else {
            panic!("{told:?}")
        };
        assert!(missed.contains("1 detections") && missed.contains("2 other"), "{missed}");
    }

    /// The task under way, as the brain gives it.
    fn under_way(seconds: f64, info: &str) -> Vec<u8> {
        let header = Header { timestamp: seconds, ..Header::default() };
        let control = PlanControl { info: info.into(), ..PlanControl::default() };
        Packet::new(header, control).encode().unwrap()
    }

    #[test]
    fn a_stop_that_the_disk_refuses_leaves_no_plan_for_the_next_start() {
        let folder = tempfile::tempdir().unwrap();
        let (file, part) = (folder.path().join("under-way.imc"), folder.path().join("under-way.part"));
        let mut worker = worker(folder.path());
        let told = RefCell::new(0);
        let answer = |done| *told.borrow_mut() += u32::from(matches!(done, Done::NotKept(_)));
        let tick = || Work::Tick(MonoTime::default(), UtcTime::default());
        let (plan, drift) = (under_way(1.0, "plan go"), under_way(3.0, "drift "));

        // Nothing can be written: a refresh leaves the plan as it is, a stop does not.
        worker.carry_out(Work::UnderWay(Some(plan.clone())), &answer);
        std::fs::create_dir(&part).unwrap();
        worker.carry_out(Work::UnderWay(Some(under_way(2.0, "plan go"))), &answer);
        assert_eq!((std::fs::read(&file).unwrap(), *told.borrow()), (plan.clone(), 1));
        worker.carry_out(Work::UnderWay(Some(drift.clone())), &answer);
        assert!(!file.exists());
        std::fs::remove_dir(&part).unwrap();
        worker.carry_out(tick(), &answer);
        assert_eq!(std::fs::read(&file).unwrap(), drift);

        // Removing fails: an abort is tried again until the file is gone.
        std::fs::remove_file(&file).unwrap();
        std::fs::create_dir(&file).unwrap();
        worker.carry_out(Work::UnderWay(None), &answer);
        assert_eq!(*told.borrow(), 2);
        worker.carry_out(tick(), &answer);
        std::fs::remove_dir(&file).unwrap();
        std::fs::write(&file, &plan).unwrap();
        worker.carry_out(tick(), &answer);
        assert!(!file.exists());
        assert_eq!(*told.borrow(), 2, "told once");
    }

    #[test]
    fn a_console_that_asks_for_logs_without_end_gets_some_and_the_last() {
        let folder = tempfile::tempdir().unwrap();
        let mut worker = worker(folder.path());
        let names = RefCell::new(Vec::new());
        let answer = |done| {
            if let Done::LogOpened(Ok(name)) = done {
                names.borrow_mut().push(name);
            }
        };
        let at = |seconds| MonoTime::default() + Duration::from_secs(seconds);
        let utc = UtcTime::from_micros(1_790_000_000_000_000);
        for number in 0..200 {
            worker.carry_out(Work::Open(at(1), utc, format!("{number}")), &answer);
        }
        assert_eq!(names.borrow().len(), ROTATIONS as usize);
        worker.carry_out(Work::Tick(at(5), utc), &answer);
        assert_eq!(names.borrow().len(), ROTATIONS as usize);
        worker.carry_out(Work::Tick(at(6), utc), &answer);
        worker.carry_out(Work::Tick(at(60), utc), &answer);
        assert_eq!(names.borrow().len(), ROTATIONS as usize + 1);
        assert!(names.borrow().last().unwrap().ends_with("_199"), "{names:?}");
        // After a rest there is room for a whole plan again.
        for number in 0..20 {
            worker.carry_out(Work::Open(at(90), utc, format!("{number}")), &answer);
        }
        assert!(names.borrow().len() > ROTATIONS as usize + 4);
    }
}
