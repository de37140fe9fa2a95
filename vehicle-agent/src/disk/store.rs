//! Plans on disk: one file for each plan with a whole IMC packet, written under another name and renamed.
//!
//! The packet is the PlanDB message that would set the plan: its header has the time and system of the last
//! change, its `info` the system's name. After a crash there is either the old file or the new one, never a partial one,
//! and all plans or none if all are being deleted: their folder is renamed atomically and emptied afterwards. Who deleted
//! plans last, and when, is stored beside the folder as the PlanDB message that requested it.

use anyhow::Context as _;
use imc::messages::{PlanDB, PlanDBOp, PlanDBType, PlanSpecification};
use imc::{Address, FOOTER_BYTES, HEADER_BYTES, Header, Packet, PacketView, plan_digest};
use mission::{Change, Effect, Kept, Record};
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};

/// The folder of plans.
#[derive(Debug)]
pub(crate) struct Store {
    folder: PathBuf,
}

impl Store {
    /// Opens a folder, making it if needed, and reads its plans. Unreadable files are left in place and reported.
    pub(crate) fn open(folder: &Path) -> anyhow::Result<(Self, Kept, Vec<String>)> {
        fs::create_dir_all(folder).with_context(|| format!("making {}", folder.display()))?;
        let store = Self { folder: folder.to_owned() };
        store.empty_forgotten()?;
        let (mut plans, mut unreadable) = (Vec::new(), Vec::new());
        let entries = fs::read_dir(folder).with_context(|| format!("reading {}", folder.display()))?;
        let mut paths: Vec<PathBuf> =
            entries.filter_map(|entry| entry.ok().map(|entry| entry.path())).collect();
        paths.sort();
        for path in paths {
            match path.extension().and_then(|extension| extension.to_str()) {
                Some("plan") => {}
                Some("part") => {
                    // A write that was never renamed.
                    fs::remove_file(&path).ok();
                    continue;
                }
                _ => continue,
            }
            match fs::read(&path).ok().and_then(|bytes| record(&bytes)) {
                Some(record) => plans.push(record),
                None => unreadable.push(path.display().to_string()),
            }
        }
        let forgotten = match fs::read(store.last_change()) {
            Err(error) if error.kind() == ErrorKind::NotFound => None,
            read => {
                let change = read.ok().and_then(|bytes| change(&Packet::decode(&bytes).ok()?));
                if change.is_none() {
                    unreadable.push(store.last_change().display().to_string());
                }
                change
            }
        };
        let under_way = match fs::read(store.under_way()) {
            Err(error) if error.kind() == ErrorKind::NotFound => None,
            read => {
                if read.is_err() {
                    unreadable.push(store.under_way().display().to_string());
                }
                read.ok()
            }
        };
        Ok((store, Kept { plans, forgotten, under_way }, unreadable))
    }

    /// Stores the task under way beside the plans, or that there is none.
    ///
    /// # Errors
    /// When writing fails. The earlier file is kept only if it is about the same task: the next start must not resume what
    /// was stopped.
    pub(crate) fn keep_under_way(&self, packet: Option<&[u8]>) -> anyhow::Result<()> {
        let path = self.under_way();
        match packet {
            Some(packet) => {
                if let Err(error) = write_bytes(&path, packet) {
                    let is_same = fs::read(&path).is_ok_and(|held| payload(&held) == payload(packet));
                    if !is_same {
                        self.keep_under_way(None).with_context(|| format!("{error:#}"))?;
                    }
                    return Err(error);
                }
            }
            None => match fs::remove_file(&path) {
                Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
                outcome => outcome.with_context(|| format!("removing {}", path.display()))?,
            },
        }
        self.folder.parent().map_or(Ok(()), sync)
    }

    fn under_way(&self) -> PathBuf {
        self.folder.with_file_name("under-way.imc")
    }

    /// Carries a change out; when this returns, it is on the disk.
    ///
    /// # Errors
    /// When it could not be carried out: then nothing has changed.
    pub(crate) fn carry_out(&self, effect: &Effect) -> anyhow::Result<()> {
        match effect {
            Effect::Store { record, .. } => self.write(record)?,
            Effect::Remove { plan_id, change, .. } => {
                let path = self.path(plan_id);
                match fs::remove_file(&path) {
                    // The file was removed by someone else already.
                    Err(error) if error.kind() == ErrorKind::NotFound => {}
                    outcome => outcome.with_context(|| format!("removing {}", path.display()))?,
                }
                sync(&self.folder)?;
                self.remember(change, PlanDBOp::Del, plan_id);
                return Ok(());
            }
            Effect::RemoveAll { change, .. } => {
                self.forget_all()?;
                self.remember(change, PlanDBOp::Clear, "");
                return Ok(());
            }
        }
        sync(&self.folder)
    }

    /// Stores who deleted plans. They are deleted whether this succeeds or not.
    fn remember(&self, change: &Change, op: PlanDBOp, plan_id: &str) {
        let message = PlanDB {
            r#type: PlanDBType::Request,
            op,
            plan_id: plan_id.into(),
            info: change.name.as_str().into(),
            ..PlanDB::default()
        };
        let written = write(&self.last_change(), change, message)
            .and_then(|()| self.folder.parent().map_or(Ok(()), sync));
        if let Err(error) = written {
            tracing::warn!("who forgot plans last will not be known at the next start: {error:#}");
        }
    }

    /// The file that names who deleted plans last.
    fn last_change(&self) -> PathBuf {
        self.folder.with_extension("change")
    }

    /// Deletes all plans: from the renaming on they are gone, also after a crash.
    fn forget_all(&self) -> anyhow::Result<()> {
        self.empty_forgotten()?;
        let forgotten = self.forgotten();
        fs::rename(&self.folder, &forgotten)
            .with_context(|| format!("renaming {}", self.folder.display()))?;
        let begun = fs::create_dir(&self.folder)
            .with_context(|| format!("making {}", self.folder.display()))
            .and_then(|()| self.folder.parent().map_or(Ok(()), sync));
        if begun.is_err() {
            fs::remove_dir(&self.folder).ok();
            fs::rename(&forgotten, &self.folder).with_context(|| {
                format!("the plans are in {} and could not be brought back", forgotten.display())
            })?;
            return begun;
        }
        if let Err(error) = self.empty_forgotten() {
            tracing::warn!("plans that were forgotten still take room, until the next start: {error:#}");
        }
        Ok(())
    }

    /// The folder of deleted plans until they are removed.
    fn forgotten(&self) -> PathBuf {
        self.folder.with_extension("forgotten")
    }

    /// Removes deleted plans, and moves back other files that were in the folder.
    fn empty_forgotten(&self) -> anyhow::Result<()> {
        let forgotten = self.forgotten();
        let entries = match fs::read_dir(&forgotten) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
            entries => entries.with_context(|| format!("reading {}", forgotten.display()))?,
        };
        for entry in entries {
            let path = entry?.path();
            let ours = path.extension().is_some_and(|extension| extension == "plan" || extension == "part");
            match path.file_name().filter(|_| !ours) {
                Some(name) => fs::rename(&path, self.folder.join(name)),
                None => fs::remove_file(&path),
            }
            .with_context(|| format!("emptying {}", forgotten.display()))?;
        }
        fs::remove_dir(&forgotten).with_context(|| format!("removing {}", forgotten.display()))
    }

    fn write(&self, record: &Record) -> anyhow::Result<()> {
        let plan: PlanSpecification = imc::decode(&PacketView::new(&record.bytes)?)?.context("no plan")?;
        let message = PlanDB {
            r#type: PlanDBType::Request,
            op: PlanDBOp::Set,
            request_id: 0,
            plan_id: record.plan_id.as_str().into(),
            arg: plan.into(),
            info: record.change.name.as_str().into(),
        };
        write(&self.path(&record.plan_id), &record.change, message)
    }

    /// File name of any plan: letters, digits and `-` are kept, all else becomes hexadecimal bytes.
    fn path(&self, plan_id: &str) -> PathBuf {
        let mut name = String::new();
        for byte in plan_id.bytes() {
            if byte.is_ascii_alphanumeric() || byte == b'-' {
                name.push(char::from(byte));
            } else {
                // Writing to a string cannot fail.
                write!(name, "_{byte:02x}").ok();
            }
        }
        self.folder.join(name + ".plan")
    }
}

/// Writes a message atomically: the header has the time and system of the change.
fn write(path: &Path, change: &Change, message: PlanDB) -> anyhow::Result<()> {
    let header = Header { timestamp: change.at.seconds(), src: Address(change.system), ..Header::default() };
    write_bytes(path, &Packet::new(header, message).encode()?)
}

/// Writes bytes under another name and renames the file.
fn write_bytes(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    let part = path.with_extension("part");
    let written = File::create(&part).and_then(|mut file| {
        file.write_all(bytes)?;
        file.sync_all()
    });
    if written.is_err() {
        // A partial file on a full disk would only take space.
        fs::remove_file(&part).ok();
    }
    written.with_context(|| format!("writing {}", part.display()))?;
    fs::rename(&part, path).with_context(|| format!("renaming {}", part.display()))
}

/// A packet without its header, which has the time.
fn payload(packet: &[u8]) -> Option<&[u8]> {
    packet.get(HEADER_BYTES..packet.len().checked_sub(FOOTER_BYTES)?)
}

/// Waits until the names in a folder are on the disk.
fn sync(folder: &Path) -> anyhow::Result<()> {
    let synced = File::open(folder).and_then(|folder| folder.sync_all());
    synced.with_context(|| format!("syncing {}", folder.display()))
}

fn record(bytes: &[u8]) -> Option<Record> {
    let packet = Packet::decode(bytes).ok()?;
    let message: &PlanDB = packet.get()?;
    let plan: PlanSpecification = message.arg.of()?;
    let mut packed = Vec::new();
    imc::encode_into(&mut packed, &Header::default(), &plan).ok()?;
    let digest = plan_digest::payload_md5(packed.get(HEADER_BYTES..packed.len() - FOOTER_BYTES)?);
    Some(Record {
        plan_id: plan.plan_id.as_str()?.to_owned(),
        bytes: packed,
        digest,
        change: change(&packet)?,
    })
}

/// Who made a change, and when.
fn change(packet: &Packet) -> Option<Change> {
    let message: &PlanDB = packet.get()?;
    Some(Change {
        at: packet.header.time()?,
        system: packet.header.src.0,
        name: message.info.to_str_lossy().into_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use mission::Ticket;
    use units::UtcTime;

    fn example(id: &str) -> Record {
        let plan = PlanSpecification { plan_id: id.into(), description: "æ".into(), ..Default::default() };
        let mut bytes = Vec::new();
        imc::encode_into(&mut bytes, &Header::default(), &plan).unwrap();
        let digest = plan_digest::payload_md5(&bytes[HEADER_BYTES..bytes.len() - FOOTER_BYTES]);
        let at = UtcTime::from_micros(1_790_000_000_123_456);
        Record {
            plan_id: id.to_owned(),
            bytes,
            digest,
            change: Change { at, system: 0x4001, name: "console".to_owned() },
        }
    }

    #[test]
    fn plans_return_after_a_restart_and_damage_is_named() {
        let data = tempfile::tempdir().unwrap();
        let folder = data.path().join("plans");
        let (store, none, _) = Store::open(&folder).unwrap();
        assert_eq!(none, Kept::default());
        for id in ["a", "../evil", "Ø plan"] {
            store.carry_out(&Effect::Store { ticket: Ticket(1), record: example(id) }).unwrap();
        }
        fs::write(folder.join("half.part"), b"x").unwrap();
        fs::write(folder.join("junk.plan"), b"x").unwrap();
        let (store, Kept { mut plans, .. }, unreadable) = Store::open(&folder).unwrap();
        plans.sort_by(|a, b| a.plan_id.cmp(&b.plan_id));
        assert_eq!(plans, [example("../evil"), example("a"), example("Ø plan")]);
        assert_eq!(unreadable.len(), 1);
        assert!(!folder.join("half.part").exists());
        let change = plans[0].change.clone();
        let gone = Effect::Remove { ticket: Ticket(2), plan_id: "a".to_owned(), change: change.clone() };
        store.carry_out(&gone).unwrap();
        let (_, kept, _) = Store::open(&folder).unwrap();
        assert_eq!((kept.plans.len(), kept.forgotten), (2, Some(change)));
        store.carry_out(&gone).unwrap();
        fs::write(data.path().join("plans.change"), b"x").unwrap();
        let (_, kept, unreadable) = Store::open(&folder).unwrap();
        assert_eq!((kept.forgotten, unreadable.len()), (None, 2));
    }

    #[test]
    fn what_is_under_way_is_the_last_that_was_kept() {
        let data = tempfile::tempdir().unwrap();
        let (store, ..) = Store::open(&data.path().join("plans")).unwrap();
        let kept = || Store::open(&data.path().join("plans")).unwrap().1.under_way;
        store.keep_under_way(None).unwrap();
        assert_eq!(kept(), None);
        for packet in [b"first".as_slice(), b"second"] {
            store.keep_under_way(Some(packet)).unwrap();
            assert_eq!(kept().as_deref(), Some(packet));
        }
        // A write that did not come to its rename changes nothing.
        fs::write(data.path().join("under-way.part"), b"half").unwrap();
        assert_eq!(kept().as_deref(), Some(b"second".as_slice()));
        store.keep_under_way(None).unwrap();
        assert_eq!(kept(), None);
    }

    fn forget_all() -> Effect {
        Effect::RemoveAll { ticket: Ticket(3), change: example("a").change }
    }

    #[test]
    fn all_plans_go_at_once_or_not_at_all() {
        let data = tempfile::tempdir().unwrap();
        let folder = data.path().join("plans");
        let (store, ..) = Store::open(&folder).unwrap();
        for id in ["a", "b", "c"] {
            store.carry_out(&Effect::Store { ticket: Ticket(1), record: example(id) }).unwrap();
        }
        fs::write(folder.join("notes.txt"), b"mine").unwrap();
        // The target of the renaming cannot be emptied: no plan is lost.
        let forgotten = data.path().join("plans.forgotten");
        fs::write(&forgotten, b"in the way").unwrap();
        assert!(store.carry_out(&forget_all()).is_err());
        fs::remove_file(&forgotten).unwrap();
        assert_eq!(Store::open(&folder).unwrap().1.plans.len(), 3);

        // The power fails right after the renaming, or half-way through the removal: all plans are gone.
        fs::rename(&folder, &forgotten).unwrap();
        fs::remove_file(forgotten.join("b.plan")).unwrap();
        let (store, kept, unreadable) = Store::open(&folder).unwrap();
        assert!(kept == Kept::default() && unreadable.is_empty());
        assert_eq!(fs::read(folder.join("notes.txt")).unwrap(), b"mine");

        store.carry_out(&Effect::Store { ticket: Ticket(1), record: example("d") }).unwrap();
        store.carry_out(&forget_all()).unwrap();
        let (_, kept, _) = Store::open(&folder).unwrap();
        assert_eq!(kept, Kept { forgotten: Some(example("a").change), ..Kept::default() });
        assert!(folder.join("notes.txt").exists() && !forgotten.exists());
    }
}
