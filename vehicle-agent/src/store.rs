//! Plans on the disk: one file a plan, each a whole IMC packet, written beside and renamed.
//!
//! The packet is the PlanDB message that would set the plan: its header has the time and system of the last
//! change, its `info` the system's name. A crash leaves the old file or the new one, never half of either.

use anyhow::Context as _;
use imc::messages::{PlanDB, PlanDBOp, PlanDBType, PlanSpecification};
use imc::{Address, FOOTER_BYTES, HEADER_BYTES, Header, Packet, PacketView, plan_digest};
use mission::{Change, Effect, Record};
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// The folder of plans.
#[derive(Debug)]
pub(crate) struct Store {
    folder: PathBuf,
}

impl Store {
    /// Opens a folder, making it if need be, and reads its plans. What cannot be read stays where it is and
    /// is named.
    pub(crate) fn open(folder: &Path) -> anyhow::Result<(Self, Vec<Record>, Vec<String>)> {
        fs::create_dir_all(folder).with_context(|| format!("making {}", folder.display()))?;
        let (mut records, mut unreadable) = (Vec::new(), Vec::new());
        let entries = fs::read_dir(folder).with_context(|| format!("reading {}", folder.display()))?;
        let mut paths: Vec<PathBuf> =
            entries.filter_map(|entry| entry.ok().map(|entry| entry.path())).collect();
        paths.sort();
        for path in paths {
            match path.extension().and_then(|extension| extension.to_str()) {
                Some("plan") => {}
                Some("part") => {
                    // A write that never came to its rename.
                    fs::remove_file(&path).ok();
                    continue;
                }
                _ => continue,
            }
            match fs::read(&path).ok().and_then(|bytes| record(&bytes)) {
                Some(record) => records.push(record),
                None => unreadable.push(path.display().to_string()),
            }
        }
        Ok((Self { folder: folder.to_owned() }, records, unreadable))
    }

    /// Carries a change out; when this answers, it is on the disk.
    pub(crate) fn carry_out(&self, effect: &Effect) -> anyhow::Result<()> {
        match effect {
            Effect::Store { record, .. } => self.write(record)?,
            Effect::Remove { plan_id, .. } => fs::remove_file(self.path(plan_id))?,
            Effect::RemoveAll { .. } => {
                for entry in fs::read_dir(&self.folder)? {
                    let path = entry?.path();
                    if path.extension().is_some_and(|extension| extension == "plan") {
                        fs::remove_file(path)?;
                    }
                }
            }
        }
        File::open(&self.folder)?.sync_all()?;
        Ok(())
    }

    fn write(&self, record: &Record) -> anyhow::Result<()> {
        let plan: PlanSpecification = imc::decode(&PacketView::new(&record.bytes)?)?.context("no plan")?;
        let header = Header {
            timestamp: record.change.at.seconds(),
            src: Address(record.change.system),
            ..Header::default()
        };
        let message = PlanDB {
            r#type: PlanDBType::Request,
            op: PlanDBOp::Set,
            request_id: 0,
            plan_id: record.plan_id.as_str().into(),
            arg: plan.into(),
            info: record.change.name.as_str().into(),
        };
        let path = self.path(&record.plan_id);
        let part = path.with_extension("part");
        let mut file = File::create(&part)?;
        file.write_all(&Packet::new(header, message).encode()?)?;
        file.sync_all()?;
        fs::rename(&part, &path)?;
        Ok(())
    }

    /// A name for any plan: letters, digits and `-` as they are, all else as hexadecimal bytes.
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
        change: Change {
            at: packet.header.time()?,
            system: packet.header.src.0,
            name: message.info.to_str_lossy().into_owned(),
        },
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
        let folder = tempfile::tempdir().unwrap();
        let (store, none, _) = Store::open(folder.path()).unwrap();
        assert!(none.is_empty());
        for id in ["a", "../evil", "Ø plan"] {
            store.carry_out(&Effect::Store { ticket: Ticket(1), record: example(id) }).unwrap();
        }
        fs::write(folder.path().join("half.part"), b"x").unwrap();
        fs::write(folder.path().join("junk.plan"), b"x").unwrap();
        let (store, mut plans, unreadable) = Store::open(folder.path()).unwrap();
        plans.sort_by(|a, b| a.plan_id.cmp(&b.plan_id));
        assert_eq!(plans, [example("../evil"), example("a"), example("Ø plan")]);
        assert_eq!(unreadable.len(), 1);
        assert!(!folder.path().join("half.part").exists());
        let change = plans[0].change.clone();
        let gone = Effect::Remove { ticket: Ticket(2), plan_id: "a".to_owned(), change: change.clone() };
        store.carry_out(&gone).unwrap();
        assert_eq!(Store::open(folder.path()).unwrap().1.len(), 2);
        assert!(store.carry_out(&gone).is_err());
        store.carry_out(&Effect::RemoveAll { ticket: Ticket(3), change }).unwrap();
        assert!(Store::open(folder.path()).unwrap().1.is_empty());
    }
}
