//! What vessels' spools took, by their own files: a witness that is independent of the archive.
//!
//! Spool files go once the shore has them. A thread keeps each file open from its first moment on and reads it for the
//! last time after it went: so it has all that was ever written, and holds room on the disk for a moment only.

use bytes::Bytes;
use std::collections::BTreeMap;
use std::fs::File;
use std::os::unix::fs::{FileExt as _, MetadataExt as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

const LOOK_EVERY: Duration = Duration::from_millis(5);
/// As `vehicle-agent`'s `segment` describes the files.
const HEADER_BYTES: usize = 32;
const FRAME_BYTES: usize = 8;

/// What a spool took and gave up.
#[derive(Debug, Default)]
pub(crate) struct Spooled {
    /// Packets by their numbers.
    pub(crate) packets: BTreeMap<u64, Bytes>,
    /// Runs of numbers (the end is not in them) that the vessel declared that it does not have.
    pub(crate) declared: Vec<(u64, u64)>,
}

impl Spooled {
    /// Adds a file of the spool; one that was thinned out has fewer packets than before.
    fn add(&mut self, file: &[u8]) {
        let Some(mut rest) = file.get(HEADER_BYTES..).filter(|_| file.starts_with(b"LUSPOOL1")) else {
            return;
        };
        let word = |bytes: &[u8], at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
        while let Some(frame) = rest.get(..FRAME_BYTES) {
            let length = u32::from_le_bytes(frame[..4].try_into().unwrap()) as usize;
            let Some(body) = rest.get(FRAME_BYTES..FRAME_BYTES + length) else { return };
            let number = word(body, 1);
            match body[0] {
                2 => self.declared.push((number, word(body, 9))),
                _ => drop(self.packets.insert(number, Bytes::copy_from_slice(&body[17..]))),
            }
            rest = &rest[FRAME_BYTES + length..];
        }
    }

    fn is_declared(&self, number: u64) -> bool {
        self.declared.iter().any(|(from, to)| (*from..*to).contains(&number))
    }

    /// Packets that it took and did not give up, with their numbers, in order.
    pub(crate) fn kept(&self) -> impl Iterator<Item = (u64, &Bytes)> {
        let kept = self.packets.iter().filter(|(number, _)| !self.is_declared(**number));
        kept.map(|(number, packet)| (*number, packet))
    }

    /// Numbers between the first and the last of which the witness saw nothing.
    pub(crate) fn unseen(&self) -> Vec<u64> {
        let (Some((first, _)), Some((last, _))) =
            (self.packets.first_key_value(), self.packets.last_key_value())
        else {
            return Vec::new();
        };
        (*first..*last)
            .filter(|number| !self.packets.contains_key(number) && !self.is_declared(*number))
            .collect()
    }
}

/// Watches a spool until it is asked.
pub(crate) struct Witness {
    done: Arc<AtomicBool>,
    thread: JoinHandle<Spooled>,
}

impl Witness {
    /// Of the spools in the data folder of an agent, which may not be there yet.
    pub(crate) fn of(data: &Path) -> Self {
        let (folder, done) = (data.join("spool"), Arc::new(AtomicBool::new(false)));
        let is_done = Arc::clone(&done);
        let thread = std::thread::spawn(move || {
            let (mut open, mut spooled) = (BTreeMap::new(), Spooled::default());
            while !is_done.load(Ordering::Relaxed) {
                look(&folder, &mut open);
                open.retain(|_, file: &mut File| {
                    let is_gone = file.metadata().unwrap().nlink() == 0;
                    if is_gone {
                        spooled.add(&whole(file));
                    }
                    !is_gone
                });
                std::thread::sleep(LOOK_EVERY);
            }
            look(&folder, &mut open);
            for file in open.values() {
                spooled.add(&whole(file));
            }
            spooled
        });
        Self { done, thread }
    }

    /// All that the spool took, after the agent has ended.
    pub(crate) fn tells(self) -> Spooled {
        self.done.store(true, Ordering::Relaxed);
        self.thread.join().unwrap()
    }
}

/// Opens the files of spools that are not open yet. Files that go meanwhile were opened before.
fn look(folder: &Path, open: &mut BTreeMap<u64, File>) {
    let entries = |folder: &Path| -> Vec<PathBuf> {
        std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect()
    };
    for path in entries(folder).iter().flat_map(|spool| entries(spool)) {
        if path.extension().is_some_and(|end| end == "spool")
            && let Ok(file) = File::open(&path)
        {
            open.entry(file.metadata().unwrap().ino()).or_insert(file);
        }
    }
}

fn whole(file: &File) -> Vec<u8> {
    let mut bytes = vec![0; file.metadata().unwrap().len() as usize];
    file.read_exact_at(&mut bytes, 0).unwrap();
    bytes
}

#[test]
fn the_witness_has_files_that_went_and_knows_what_it_did_not_see() {
    let entry = |kind: u8, number: u64, rest: &[u8]| {
        let body = [&[kind], &number.to_le_bytes()[..], rest].concat();
        [&(body.len() as u32).to_le_bytes()[..], &[0; 4], &body].concat()
    };
    let packet = |number: u64| entry(1, number, b"12345678packet");
    let head = [&b"LUSPOOL1"[..], &[0; 24]].concat();
    let mut spooled = Spooled::default();
    let gap = entry(2, 3, &[&5_u64.to_le_bytes()[..], &[0; 17]].concat());
    spooled
        .add(&[&head[..], &packet(1), &packet(2), &packet(4), &gap, &packet(7), &packet(8)[..20]].concat());
    assert_eq!((spooled.kept().count(), spooled.unseen()), (3, vec![5, 6]));
    assert_eq!(spooled.packets[&2], "packet");

    let data = tempfile::tempdir().unwrap();
    let file = data.path().join("spool/otter-1/00000000000000000001.spool");
    std::fs::create_dir_all(file.parent().unwrap()).unwrap();
    let mut open = BTreeMap::new();
    std::fs::write(&file, &head).unwrap();
    look(&data.path().join("spool"), &mut open);
    std::fs::File::options()
        .append(true)
        .open(&file)
        .map(|mut file| std::io::Write::write_all(&mut file, &packet(1)))
        .unwrap()
        .unwrap();
    std::fs::remove_file(&file).unwrap();
    let file = open.into_values().next().unwrap();
    assert_eq!((file.metadata().unwrap().nlink(), whole(&file).len()), (0, head.len() + packet(1).len()));
}
