//! Logs that people upload: kept in `DATA/uploads` until they are read, one at a time, in slices between which
//! the recorder takes what vessels say.
//!
//! The list of imports is of this run of the server; what was imported stands in the archive.

use crate::clock;
use crate::relay::Recorder;
use api::{Import, ImportState};
use std::collections::VecDeque;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use store::{LogImport, StoreError};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

/// Imports that are remembered.
const REMEMBERED: usize = 50;
/// Packets and unpacked bytes that are read at once: vessels are not heard meanwhile, for some 20 ms.
const SLICE_PACKETS: u64 = 2_000;
const SLICE_BYTES: u64 = 1 << 20;
/// Bytes that are no packets after which a log is given up: little packed garbage can unpack to very much.
const GARBAGE_BYTES: u64 = 256 << 20;
/// Bytes on the disk that uploads leave to recording.
pub(crate) const RESERVED_BYTES: u64 = 512 << 20;

/// All imports; cheap to clone.
#[derive(Clone)]
pub(crate) struct Imports {
    shared: Arc<Shared>,
}

struct Shared {
    folder: PathBuf,
    place: Arc<Semaphore>,
    list: Mutex<List>,
}

#[derive(Default)]
struct List {
    last: u32,
    imports: VecDeque<Import>,
}

/// The one upload that may be on its way. Its file is removed with it.
pub(crate) struct Upload {
    path: PathBuf,
    file: File,
    /// Bytes written.
    pub(crate) bytes: u64,
    _place: OwnedSemaphorePermit,
}

impl Upload {
    /// Appends.
    pub(crate) fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.file.write_all(bytes)?;
        self.bytes += bytes.len() as u64;
        Ok(())
    }

    /// Whether what was written so far begins as a log does.
    pub(crate) fn begins_as_log(&self) -> store::Result<bool> {
        store::begins_as_log(&self.path)
    }

    /// What its disk has left for uploads, bytes.
    pub(crate) fn room_bytes(&self) -> store::Result<u64> {
        let folder = self.path.parent().unwrap_or(Path::new("."));
        Ok(store::free_bytes(folder)?.saturating_sub(RESERVED_BYTES))
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
    /// Into a data folder. Uploads that an earlier run left there are removed.
    pub(crate) fn new(data: &Path) -> Self {
        let folder = data.join("uploads");
        match fs::remove_dir_all(&folder) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                tracing::warn!(path = %folder.display(), %error, "uploads of an earlier run are left over");
            }
            _ => {}
        }
        let place = Arc::new(Semaphore::new(1));
        Self { shared: Arc::new(Shared { folder, place, list: Mutex::default() }) }
    }

    fn list(&self) -> MutexGuard<'_, List> {
        self.shared.list.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// All that are remembered, the newest first.
    pub(crate) fn all(&self) -> Vec<Import> {
        self.list().imports.iter().rev().cloned().collect()
    }

    /// One of them.
    pub(crate) fn get(&self, id: u32) -> Option<Import> {
        self.list().imports.iter().find(|import| import.id == id).cloned()
    }

    /// Room for an upload; `None` while there is another or one is being read.
    pub(crate) fn upload(&self) -> io::Result<Option<Upload>> {
        let Ok(place) = Arc::clone(&self.shared.place).try_acquire_owned() else { return Ok(None) };
        fs::create_dir_all(&self.shared.folder)?;
        let path = self.shared.folder.join("upload.lsf");
        let file = OpenOptions::new().write(true).create(true).truncate(true).open(&path)?;
        Ok(Some(Upload { path, file, bytes: 0, _place: place }))
    }

    /// A file of this computer as an upload; `None` while there is another or one is being read.
    pub(crate) fn take(&self, file: &Path) -> io::Result<Option<Upload>> {
        let Some(mut upload) = self.upload()? else { return Ok(None) };
        upload.bytes = io::copy(&mut File::open(file)?, &mut upload.file)?;
        Ok(Some(upload))
    }

    /// Begins to read an upload.
    pub(crate) fn begin(
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
                since_us: clock::now().micros(),
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
            import
        };
        let job = Job { imports: self.clone(), id: import.id, name: import.name.clone(), upload };
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
}

impl Job {
    async fn run(self, recorder: Recorder, stop: CancellationToken) {
        let outcome = self.read(&recorder, &stop).await;
        let state = if outcome.is_ok() { ImportState::Done } else { ImportState::Failed };
        tracing::info!(name = %self.name, ?state, "an upload was imported");
        // Another can be uploaded as soon as this one is told to be at its end.
        let Self { imports, id, name, upload } = self;
        let path = upload.path.display().to_string();
        drop(upload);
        imports.change(id, |import| {
            if let Err(error) = outcome {
                let more = "what was read before stays; upload it again for the rest";
                import.problems.push(format!("{}; {more}", error.replace(&path, &name)));
            }
            import.state = state;
        });
    }

    /// Slice after slice.
    async fn read(&self, recorder: &Recorder, stop: &CancellationToken) -> Result<(), String> {
        let stopping = || "the server was stopped".to_owned();
        let path = self.upload.path.clone();
        let begin = recorder.with_store(move |store| LogImport::begin(store, &path, clock::now()));
        let mut log = begin.await.ok_or_else(stopping)?.map_err(|error| told(&error))?;
        loop {
            if stop.is_cancelled() {
                return Err(stopping());
            }
            let slice = recorder.with_store(move |store| {
                let more = log.read_some(store, SLICE_PACKETS, SLICE_BYTES);
                (log, more)
            });
            let (back, more) = slice.await.ok_or_else(stopping)?;
            log = back;
            self.tell(&log);
            if !more.map_err(|error| told(&error))? {
                return Ok(());
            }
            if log.imported().damaged_bytes > GARBAGE_BYTES {
                let most = GARBAGE_BYTES >> 20;
                return Err(format!(
                    "more than {most} MiB of it are no packets; `lutra-server import` takes it nevertheless"
                ));
            }
        }
    }

    fn tell(&self, log: &LogImport) {
        let imported = log.imported();
        let path = self.upload.path.display().to_string();
        self.imports.change(self.id, |import| {
            import.read_bytes = log.read_bytes();
            import.packets = imported.packets;
            import.added = imported.added;
            import.damaged_bytes = imported.damaged_bytes;
            // People know it by the name that they gave.
            import.problems = imported.problems.iter().map(|text| text.replace(&path, &self.name)).collect();
        });
    }
}

fn told(error: &StoreError) -> String {
    if error.is_disk_full() {
        return format!("the disk is full: make room, or remove old history ({error})");
    }
    error.to_string()
}
