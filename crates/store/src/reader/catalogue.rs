//! What there is: systems, their entities, and series of samples.

use super::Reader;
use crate::archive::DayKey;
use crate::error::Result;
use crate::history::{Extent, GroupKey, MonthKey, Progress, Table, load_progress};
use imc::Address;
use rusqlite::Connection;
use std::collections::BTreeMap;
use units::UtcTime;

/// A system that said something.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct System {
    /// Its address.
    pub address: Address,
    /// The name it announced last, or else the registered one, or else the address.
    pub name: String,
    /// What it announced to be, by IMC's enumeration `SystemType`.
    pub kind: Option<u8>,
    /// First and last sample that have a believable time, if any has, and how many there are.
    pub extent: Extent,
}

/// A label of an entity, and from when to when it was heard.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EntityName {
    /// The system.
    pub system: Address,
    /// The entity's number.
    pub entity: u8,
    /// The label.
    pub label: String,
    /// When it was first heard.
    pub from: UtcTime,
    /// When it was last heard.
    pub last: UtcTime,
}

/// What came ashore from a system on one day.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RecordedDay {
    /// The system.
    pub system: Address,
    /// Midnight of the UTC day on which it came: live, late or by an import.
    pub day: UtcTime,
    /// First and last time by the sender's clock, and how many packets.
    pub extent: Extent,
    /// Bytes of its packets in the archive; 0 for a day that was removed there, of which months still have messages.
    pub bytes: u64,
}

/// The samples of one message of one entity.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Series {
    /// What it is known by.
    pub group: GroupKey,
    /// The message's name; `None` when the catalogue has no message with its id.
    pub message: Option<&'static str>,
    /// The entity's last label.
    pub label: Option<String>,
    /// First and last sample, and how many.
    pub extent: Extent,
    /// The same of those that have a believable time.
    pub dated: Extent,
}

impl Series {
    /// Mean time between samples that have a believable time (s); `None` for fewer than two.
    pub fn period_s(&self) -> Option<f64> {
        let Extent { first_us, last_us, count } = self.dated;
        (count > 1).then(|| (last_us - first_us) as f64 / 1e6 / (count - 1) as f64)
    }
}

/// The extents of all that each system said.
fn by_system(extents: BTreeMap<GroupKey, Extent>) -> BTreeMap<u16, Extent> {
    let mut systems: BTreeMap<u16, Extent> = BTreeMap::new();
    for (group, extent) in extents {
        systems.entry(group.src).or_insert(Extent::NONE).merge(extent);
    }
    systems
}

impl Reader {
    /// Every system, by address.
    ///
    /// # Errors
    /// When a file of the history cannot be read.
    pub fn systems(&mut self) -> Result<Vec<System>> {
        let names = self.names()?;
        // When it was heard is told by stamps that can be believed, as long as there are any.
        let (all, dated) = self.extents_and_dated()?;
        let (all, dated) = (by_system(all), by_system(dated));
        let told = |(address, all): (u16, Extent)| {
            let believed = dated.get(&address).copied().unwrap_or(all);
            (address, Extent { count: all.count, ..believed })
        };
        let system = |(address, extent): (u16, Extent)| System {
            address: Address(address),
            name: names.system(Address(address)),
            kind: names.systems.get(&address).and_then(|runs| runs.latest()).map(|name| name.kind),
            extent,
        };
        Ok(all.into_iter().map(told).map(system).collect())
    }

    /// All that was recorded, by the day on which it came and by system, the newest day first.
    ///
    /// # Errors
    /// When the catalogue cannot be read.
    pub fn recorded_days(&self) -> Result<Vec<RecordedDay>> {
        let read = self.ask_catalogue(load_progress)?.unwrap_or_default();
        let recorded = |(key, progress): (DayKey, Progress)| {
            let Progress { lengths, extent } = progress;
            let day = key.start()?;
            (extent.count > 0).then_some(RecordedDay { system: key.src, day, extent, bytes: lengths.data })
        };
        let mut found: Vec<RecordedDay> = read.into_iter().filter_map(recorded).collect();
        found.sort_by_key(|one| (std::cmp::Reverse(one.day), one.system));
        // Parts of a day are one day.
        found.dedup_by(|part, day| {
            let same = (part.system, part.day) == (day.system, day.day);
            if same {
                day.extent.merge(part.extent);
                day.bytes += part.bytes;
            }
            same
        });
        Ok(found)
    }

    /// Every label that the entities of a system had.
    ///
    /// # Errors
    /// When the catalogue cannot be read.
    pub fn entities(&self, system: Address) -> Result<Vec<EntityName>> {
        let names = self.names()?;
        let mut found = Vec::new();
        for ((_, entity), runs) in names.entities.range((system.0, 0)..=(system.0, u8::MAX)) {
            found.extend(runs.runs.iter().map(|(from_us, run)| EntityName {
                system,
                entity: *entity,
                label: run.name.clone(),
                from: UtcTime::from_micros(*from_us),
                last: UtcTime::from_micros(run.last_us),
            }));
        }
        Ok(found)
    }

    /// Every series, of one system or of all.
    ///
    /// # Errors
    /// When a file of the history cannot be read.
    pub fn series(&mut self, system: Option<Address>) -> Result<Vec<Series>> {
        let names = self.names()?;
        let (extents, dated) = self.extents_and_dated()?;
        let wanted = |group: &GroupKey| system.is_none_or(|system| system.0 == group.src);
        let series = |(group, extent): (GroupKey, Extent)| Series {
            group,
            message: self.schema.table(group.id).map(|table| table.desc.abbrev),
            label: names.entities.get(&(group.src, group.src_ent)).and_then(|runs| runs.latest()).cloned(),
            extent,
            dated: dated.get(&group).copied().unwrap_or(Extent::NONE),
        };
        Ok(extents.into_iter().filter(|(group, _)| wanted(group)).map(series).collect())
    }

    /// The table behind a series; `None` when the catalogue lacks its message.
    pub fn table_of(&self, group: GroupKey) -> Option<&Table> {
        self.schema.table(group.id)
    }

    /// How much there is of each group, over all months.
    pub(crate) fn extents(&self) -> Result<BTreeMap<GroupKey, Extent>> {
        self.months_extents(|_| true)
    }

    /// How much there is of each group, and how much of that has a believable time.
    fn extents_and_dated(&self) -> Result<(BTreeMap<GroupKey, Extent>, BTreeMap<GroupKey, Extent>)> {
        let dated = self.months_extents(|key| key != MonthKey::Undated)?;
        let mut all = self.months_extents(|key| key == MonthKey::Undated)?;
        for (group, extent) in &dated {
            all.entry(*group).or_insert(Extent::NONE).merge(*extent);
        }
        Ok((all, dated))
    }

    /// The same over the months that are `wanted`.
    pub(super) fn months_extents(
        &self,
        wanted: impl Fn(MonthKey) -> bool,
    ) -> Result<BTreeMap<GroupKey, Extent>> {
        let mut extents: BTreeMap<GroupKey, Extent> = BTreeMap::new();
        for key in self.keys()?.into_iter().filter(|key| wanted(*key)) {
            let read = |connection: &Connection| {
                let mut statement =
                    connection.prepare_cached("SELECT id,src,src_ent,first_us,last_us,count FROM _group")?;
                let mut rows = statement.query(())?;
                while let Some(row) = rows.next()? {
                    let group = GroupKey { id: row.get(0)?, src: row.get(1)?, src_ent: row.get(2)? };
                    let count: i64 = row.get(5)?;
                    let extent =
                        Extent { first_us: row.get(3)?, last_us: row.get(4)?, count: count.cast_unsigned() };
                    extents.entry(group).or_insert(Extent::NONE).merge(extent);
                }
                Ok(())
            };
            self.ask_month(key, read)?;
        }
        Ok(extents)
    }
}
