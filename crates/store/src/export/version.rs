//! The version of the data of an export: while it is the same, the same query gives the same bytes.

use super::select::Selection;
use crate::archive;
use crate::error::Result;
use crate::history::{GroupKey, Names};
use crate::range::TimeRange;
use crate::reader::Reader;
use imc::Address;
use siphasher::sip::SipHasher13;
use std::hash::{Hash as _, Hasher as _};
use std::path::Path;

/// Counts up when the same question to the same data would give other bytes than an earlier version of Lutra gave.
const LAYOUT: u32 = 1;

/// A number for the source data of a table of this selection: how many messages of each series its months have, and the
/// names of systems and entities. It is made from the months' own counts, as the first byte must not wait until a season
/// was counted; so messages of the same series and month beyond the selection change it too.
///
/// # Errors
/// When the selection names what does not exist or the history cannot be read.
pub fn table_version(reader: &mut Reader, selection: &Selection) -> Result<u64> {
    let selection = selection.known(reader)?;
    let names = reader.names()?;
    let mut version = SipHasher13::new();
    LAYOUT.hash(&mut version);
    for (key, part) in reader.parts(selection.range)? {
        let connection = reader.month(key)?;
        let mut ask = || -> rusqlite::Result<()> {
            let mut tallies =
                connection.prepare_cached("SELECT id,src,src_ent,first_us,last_us,count FROM _group")?;
            let mut rows = tallies.query(())?;
            while let Some(row) = rows.next()? {
                let group = GroupKey { id: row.get(0)?, src: row.get(1)?, src_ent: row.get(2)? };
                let (first_us, last_us, count): (i64, i64, i64) = (row.get(3)?, row.get(4)?, row.get(5)?);
                let there = part.within(TimeRange { from_us: first_us, to_us: last_us.saturating_add(1) });
                if !there.is_empty() && selection.has_series(&names, group) {
                    (key, group, first_us, last_us, count).hash(&mut version);
                    hash_names(&names, group.src, Some(group.src_ent), &mut version);
                }
            }
            if selection.is_raw() {
                let count = "SELECT count(*) FROM _raw";
                connection.query_row(count, (), |row| row.get::<_, i64>(0))?.hash(&mut version);
                names.systems.keys().for_each(|system| hash_names(&names, *system, None, &mut version));
            }
            Ok(())
        };
        let asked = ask();
        reader.named(key, asked)?;
    }
    Ok(version.finish())
}

/// The names of a system and its entities, or of one of them, over time.
fn hash_names(names: &Names, system: u16, entity: Option<u8>, version: &mut SipHasher13) {
    names.system(Address(system)).hash(version);
    let entities = entity.map_or(0..=u8::MAX, |entity| entity..=entity);
    let (first, last) = ((system, *entities.start()), (system, *entities.end()));
    for (key, runs) in names.entities.range(first..=last) {
        for (from_us, run) in &runs.runs {
            (key, from_us, &run.name).hash(version);
        }
    }
}

/// The same for a log: which days of the archive have packets of the selection's time, and how long they are.
///
/// # Errors
/// When the selection names what does not exist or the archive cannot be read.
pub fn log_version(data: &Path, selection: &Selection) -> Result<u64> {
    let mut reader = Reader::open(data)?;
    let selection = selection.known(&mut reader)?;
    let mut version = SipHasher13::new();
    LAYOUT.hash(&mut version);
    let root = data.join("archive");
    for key in super::lsf::days(&reader, &root, &selection)? {
        let bytes = archive::bytes::readable_bytes(&key.folder(&root), archive::DATA);
        (key.name(), bytes).hash(&mut version);
    }
    Ok(version.finish())
}
