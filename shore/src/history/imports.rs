//! Uploaded logs: kept in `DATA/uploads` until they are read, one at a time, in slices between which the recorder stores
//! live packets.
//!
//! The list of imports survives a restart; an unfinished one says so. Imported data are in the archive.

use crate::clock::Clock;
use crate::recorder::Recorder;
use api::{Fixed, Import, ImportNote, ImportState, Said, fixed, say};
use std::collections::{BTreeMap, VecDeque};
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use store::{LogImport, StoreError};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

/// Imports that are remembered.
const REMEMBERED: usize = 50;
/// Packets and unpacked bytes that are read at once: live packets wait meanwhile, for some 20 ms.
const SLICE_PACKETS: u64 = 2_000;
const SLICE_BYTES: u64 = 1 << 20;
/// Bytes that are not packets, after which a log is given up: a small compressed file can unpack to very much garbage.
const GARBAGE_BYTES: u64 = 256 << 20;
/// How long an import waits before it checks again whether the history is complete.
const AGAIN: Duration = Duration::from_millis(500);
/// Status while it waits.
const WAITS: Fixed = fixed("waits until the history is made again from the archive");
/// Free disk space that uploads must leave for recording.
pub const RESERVED_BYTES: u64 = 512 << 20;

/// All imports; cheap to clone.
#[derive(Clone)]
pub struct Imports {
    shared: Arc<Shared>,
}

struct Shared {
    folder: PathBuf,
    /// Where the list is kept.
    kept: PathBuf,
    /// Bytes that a log may have, unpacked.
    most_bytes: u64,
    place: Arc<Semaphore>,
    list: Mutex<List>,
    clock: Clock,
}

#[derive(Default)]
struct List {
    last: u32,
    imports: VecDeque<Import>,
    /// Running imports, to cancel them.
    running: BTreeMap<u32, Running>,
}

/// A running import that can be cancelled.
#[derive(Debug, Default)]
struct Running {
    cancel: CancellationToken,
    /// Who cancelled it.
    by: Option<String>,
}

/// Why an import ended before the end of its log.
enum Broken {
    /// An error, or the server ends.
    Off(Said),
    /// A user cancelled it.
    Cancelled,
}

/// The only upload that may be in progress. Dropping it removes its file.
pub struct Upload {
    path: PathBuf,
    file: File,
    /// Bytes written.
    pub bytes: u64,
    /// Whether it is a table of detections, of which packets are made before it is read.
    pub is_table: bool,
    _place: OwnedSemaphorePermit,
}

impl Upload {
    /// Appends.
    ///
    /// # Errors
    /// The disk is full or fails.
    pub fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.file.write_all(bytes)?;
        self.bytes += bytes.len() as u64;
        Ok(())
    }

    /// What the bytes so far are the beginning of.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn beginning(&self) -> store::Result<store::Beginning> {
        store::beginning(&self.path)
    }

    /// Puts in the place of the file what `make` writes of it, as far as there is room.
    ///
    /// # Errors
    /// There is no room on the disk, or `make` fails: the file is as it was then.
    pub fn replace<T>(&mut self, make: impl FnOnce(&Path, &mut dyn Write) -> io::Result<T>) -> io::Result<T> {
        let new = self.path.with_extension("new");
        let left = self.room_bytes().map_err(io::Error::other)?;
        let made = File::create(&new).and_then(|file| {
            let mut out = BufWriter::new(Bounded { file, left });
            let made = make(&self.path, &mut out)?;
            out.flush()?;
            fs::rename(&new, &self.path)?;
            Ok(made)
        });
        if made.is_err() {
            fs::remove_file(&new).ok();
        }
        made
    }

    /// Bytes that the disk has left for uploads.
    ///
    /// # Errors
    /// The file system cannot be queried.
    pub fn room_bytes(&self) -> store::Result<u64> {
        let folder = self.path.parent().unwrap_or(Path::new("."));
        Ok(store::free_bytes(folder)?.saturating_sub(RESERVED_BYTES))
    }
}

/// A file that may have only so many bytes more.
struct Bounded {
    file: File,
    left: u64,
}

impl Write for Bounded {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = bytes.len() as u64;
        self.left = self.left.checked_sub(written).ok_or(io::ErrorKind::StorageFull)?;
        self.file.write_all(bytes)?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Drop for Upload {
    fn drop(&mut self) {
        if let Err(error) = fs::remove_file(&self.path) {
            tracing::warn!(path = %self.path.display(), %error, "an upload is left over");
        }
    }
}

impl Imports {
    /// For a data folder. Uploads that an earlier run left there are removed; its imports are listed.
    pub fn new(settings: &crate::Settings, clock: Clock) -> Self {
        let data = &settings.data;
        let (folder, kept) = (data.join("uploads"), data.join("imports.json"));
        match fs::remove_dir_all(&folder) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                tracing::warn!(path = %folder.display(), %error, "uploads of an earlier run are left over");
            }
            _ => {}
        }
        let place = Arc::new(Semaphore::new(1));
        let imports = read_list(&kept);
        let last = imports.iter().map(|import| import.id).max().unwrap_or_default();
        let list = Mutex::new(List { last, imports, running: BTreeMap::new() });
        let most_bytes = settings.most_unpacked_bytes;
        Self { shared: Arc::new(Shared { folder, kept, most_bytes, place, list, clock }) }
    }

    /// Saves the list. If that fails, only the list is lost at the next start.
    fn keep(&self) {
        let imports = self.list().imports.clone();
        let new = self.shared.kept.with_extension("json.new");
        let write = || -> io::Result<()> {
            let mut file = File::create(&new)?;
            file.write_all(&serde_json::to_vec(&imports)?)?;
            file.sync_data()?;
            fs::rename(&new, &self.shared.kept)
        };
        if let Err(error) = write() {
            tracing::warn!(%error, "the list of imports will not be known after a restart");
        }
    }

    /// Cancels an import; returns whether it was running.
    pub fn cancel(&self, id: u32, by: String) -> bool {
        let mut list = self.list();
        let Some(running) = list.running.get_mut(&id) else { return false };
        running.by.get_or_insert(by);
        running.cancel.cancel();
        true
    }

    fn list(&self) -> MutexGuard<'_, List> {
        self.shared.list.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// All remembered imports, the newest first.
    pub fn all(&self) -> Vec<Import> {
        self.list().imports.iter().rev().cloned().collect()
    }

    /// One of them.
    pub fn get(&self, id: u32) -> Option<Import> {
        self.list().imports.iter().find(|import| import.id == id).cloned()
    }

    /// Begins an upload; `None` while there is another, or one is being read.
    ///
    /// # Errors
    /// The folder of uploads cannot be written.
    pub fn upload(&self) -> io::Result<Option<Upload>> {
        let Ok(place) = Arc::clone(&self.shared.place).try_acquire_owned() else { return Ok(None) };
        fs::create_dir_all(&self.shared.folder)?;
        let path = self.shared.folder.join("upload.lsf");
        let file = OpenOptions::new().write(true).create(true).truncate(true).open(&path)?;
        Ok(Some(Upload { path, file, bytes: 0, is_table: false, _place: place }))
    }

    /// A file of this computer as an upload; `None` while there is another or one is being read.
    ///
    /// # Errors
    /// The file cannot be read, or there is no room for a copy of it.
    pub fn take(&self, file: &Path) -> io::Result<Option<Upload>> {
        let Some(mut upload) = self.upload()? else { return Ok(None) };
        upload.bytes = io::copy(&mut File::open(file)?, &mut upload.file)?;
        Ok(Some(upload))
    }

    /// Begins to read an upload.
    pub fn begin(
        &self,
        upload: Upload,
        name: String,
        person: String,
        recorder: Recorder,
        tasks: &TaskTracker,
        stop: CancellationToken,
    ) -> Import {
        let import = {
            let mut list = self.list();
            list.last += 1;
            let import = Import {
                id: list.last,
                name,
                person,
                since_us: self.shared.clock.utc().micros(),
                state: ImportState::Running,
                upload_bytes: upload.bytes,
                read_bytes: 0,
                packets: 0,
                added: 0,
                damaged_bytes: 0,
                problems: Vec::new(),
            };
            if list.imports.len() == REMEMBERED {
                list.imports.pop_front();
            }
            list.imports.push_back(import.clone());
            list.running.insert(import.id, Running::default());
            import
        };
        let cancel = self.list().running.get(&import.id).map(|running| running.cancel.clone());
        let job = Job {
            imports: self.clone(),
            id: import.id,
            name: import.name.clone(),
            upload,
            cancel: cancel.unwrap_or_default(),
        };
        tasks.spawn(job.run(recorder, stop));
        import
    }

    fn change(&self, id: u32, change: impl FnOnce(&mut Import)) {
        if let Some(import) = self.list().imports.iter_mut().find(|import| import.id == id) {
            change(import);
        }
    }
}

struct Job {
    imports: Imports,
    id: u32,
    name: String,
    upload: Upload,
    cancel: CancellationToken,
}

impl Job {
    async fn run(self, recorder: Recorder, stop: CancellationToken) {
        // A restart must see that it had begun.
        let imports = self.imports.clone();
        tokio::task::spawn_blocking(move || imports.keep()).await.ok();
        let outcome = self.read(&recorder, &stop).await;
        let state = match outcome {
            Ok(()) => ImportState::Done,
            Err(Broken::Off(_)) => ImportState::Failed,
            Err(Broken::Cancelled) => ImportState::Cancelled,
        };
        tracing::info!(name = %self.name, ?state, "an upload was imported");
        // The next upload is possible as soon as this one is reported as finished.
        let Self { imports, id, upload, .. } = self;
        drop(upload);
        let by = imports.list().running.remove(&id).and_then(|running| running.by);
        imports.change(id, |import| {
            import.problems.retain(|problem| problem.text != *WAITS);
            let ended = match outcome {
                Ok(()) => None,
                Err(Broken::Off(error)) => Some(error),
                Err(Broken::Cancelled) => {
                    Some(say("cancelled by {name}").with("name", by.unwrap_or_default()).into())
                }
            };
            import.problems.extend(ended.map(with_rest));
            import.state = state;
        });
        tokio::task::spawn_blocking(move || imports.keep()).await.ok();
    }

    /// Slice after slice.
    async fn read(&self, recorder: &Recorder, stop: &CancellationToken) -> Result<(), Broken> {
        let stopping = || Broken::Off(say("the server was stopped").into());
        let mut log = loop {
            let path = self.upload.path.clone();
            let now = self.imports.shared.clock.utc();
            let begin = recorder.with_store(move |store| LogImport::begin(store, &path, now));
            match begin.await.ok_or_else(stopping)? {
                Ok(log) => break log,
                Err(StoreError::Behind(_)) => self.wait(stop).await?,
                Err(error) => return Err(Broken::Off(self.told(&error))),
            }
        };
        loop {
            self.may_go_on(stop)?;
            let slice = recorder.with_store(move |store| {
                let more = log.read_some(store, SLICE_PACKETS, SLICE_BYTES);
                (log, more)
            });
            let (back, more) = slice.await.ok_or_else(stopping)?;
            log = back;
            self.tell(&log);
            match more {
                Ok(true) => self.bounded(&log)?,
                Ok(false) => return self.bounded(&log),
                Err(StoreError::Behind(_)) => self.wait(stop).await?,
                Err(error) => return Err(Broken::Off(self.told(&error))),
            }
        }
    }

    fn may_go_on(&self, stop: &CancellationToken) -> Result<(), Broken> {
        if stop.is_cancelled() {
            return Err(Broken::Off(say("the server was stopped").into()));
        }
        if self.cancel.is_cancelled() { Err(Broken::Cancelled) } else { Ok(()) }
    }

    /// Waits until the history is complete: duplicates are detected by it.
    async fn wait(&self, stop: &CancellationToken) -> Result<(), Broken> {
        self.imports.change(self.id, |import| {
            if !import.problems.iter().any(|problem| problem.text == *WAITS) {
                import.problems.push(Said::from(WAITS).into());
            }
        });
        tokio::select! {
            () = tokio::time::sleep(AGAIN) => {}
            () = stop.cancelled() => {}
            () = self.cancel.cancelled() => {}
        }
        self.may_go_on(stop)
    }

    /// Limits the unpacked size: a small compressed file can unpack to very much.
    fn bounded(&self, log: &LogImport) -> Result<(), Broken> {
        let off = |text: Said| Err(Broken::Off(text));
        if log.imported().damaged_bytes > GARBAGE_BYTES {
            let most = GARBAGE_BYTES >> 20;
            let text = say(
                "more than {most} MiB of it are not packets; `lutra-server import` takes it nevertheless",
            );
            return off(text.with("most", most).into());
        }
        let most = self.imports.shared.most_bytes;
        if log.read_bytes() > most {
            let text = say(
                "it unpacks to more than {most} MiB (http.max_unpacked_mib); `lutra-server import` takes it nevertheless",
            );
            return off(text.with("most", most >> 20).into());
        }
        match self.upload.room_bytes() {
            Ok(0) => off(say("the disk is full up to the {most} MiB that are kept for recording")
                .with("most", RESERVED_BYTES >> 20)
                .into()),
            Ok(_) => Ok(()),
            Err(error) => off(self.told(&error)),
        }
    }

    fn tell(&self, log: &LogImport) {
        let imported = log.imported();
        self.imports.change(self.id, |import| {
            import.read_bytes = log.read_bytes();
            import.packets = imported.packets;
            import.added = imported.added;
            import.damaged_bytes = imported.damaged_bytes;
            import.problems = imported.problems.iter().map(|text| self.named(text).into()).collect();
        });
    }

    fn told(&self, error: &StoreError) -> Said {
        let error_is = self.named(&error.to_string());
        if error.is_disk_full() {
            let text = say("the disk is full: make room, or remove old history ({error})");
            return text.with_said("error", error_is).into();
        }
        error_is
    }

    /// What the store says, with the name that the user gave in place of the path on the server.
    fn named(&self, text: &str) -> Said {
        Said::as_is(text.replace(&self.upload.path.display().to_string(), &self.name))
    }
}

/// Why a log was not read to its end, with the remedy.
fn with_rest(why: Said) -> ImportNote {
    let text = say("{why}; what was read before stays; upload it again for the rest, nothing is added twice");
    Said::from(text.with_said("why", why)).into()
}

/// The list of an earlier run; imports that ran then are marked as interrupted.
fn read_list(path: &Path) -> VecDeque<Import> {
    let text = match fs::read(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return VecDeque::new(),
        other => other,
    };
    let read = text.and_then(|text| Ok(serde_json::from_slice::<VecDeque<Import>>(&text)?));
    let mut imports = read.unwrap_or_else(|error| {
        tracing::warn!(path = %path.display(), %error, "the list of earlier imports cannot be read");
        VecDeque::new()
    });
    for import in imports.iter_mut().filter(|import| import.state == ImportState::Running) {
        import.problems.retain(|problem| problem.text != *WAITS);
        import.problems.push(with_rest(say("the server ended meanwhile").into()));
        import.state = ImportState::Failed;
    }
    imports
}
