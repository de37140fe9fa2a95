//! Reads the archive as it grows, to carry it into another store.
//!
//! A [`Tail`] remembers, in a small file of its own, how far each day was carried. It reads up to what the writer
//! says is durable ([`crate::Store::marks`]), so that it never carries what a crash could take back, and moves on
//! only when notified that a batch arrived: everything is carried at least once, in the order of arrival within a day.

use crate::archive::{Archived, DayKey, DayReader, Lengths};
use crate::error::{Named as _, Result, StoreError};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Up to where each day of the archive is durable.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Marks(pub(crate) BTreeMap<DayKey, Lengths>);

/// A place in the archive: everything before it was read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    key: DayKey,
    end: Lengths,
}

/// A reader that follows the archive.
#[derive(Debug, Clone)]
pub struct Tail {
    archive: PathBuf,
    file: PathBuf,
    target: String,
    carried: BTreeMap<DayKey, Lengths>,
    note: String,
    is_new: bool,
}

impl Tail {
    /// Follows the archive of a data folder under a name of its own, for what `target` names. With another target
    /// than at last it starts over.
    ///
    /// # Errors
    /// When its file cannot be read or holds something else; removing it makes the tail start over.
    pub fn open(folder: &Path, name: &str, target: &str) -> Result<Self> {
        let file = folder.join("sinks").join(format!("{name}.json"));
        let mut tail = Self {
            archive: folder.join("archive"),
            file,
            target: target.to_owned(),
            carried: BTreeMap::new(),
            note: String::new(),
            is_new: true,
        };
        let text = match fs::read(&tail.file) {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(tail),
            other => other.named(&tail.file)?,
        };
        let damaged = || StoreError::Place { path: tail.file.clone() };
        let saved: Value = serde_json::from_slice(&text).map_err(|_| damaged())?;
        if saved.get("target").and_then(Value::as_str) == Some(target) {
            let days = saved.get("days").and_then(Value::as_object).ok_or_else(damaged)?;
            tail.carried = days.iter().map(day).collect::<Option<_>>().ok_or_else(damaged)?;
            saved.get("note").and_then(Value::as_str).unwrap_or_default().clone_into(&mut tail.note);
            tail.is_new = false;
        }
        Ok(tail)
    }

    /// The noted position for this target; empty where there is none.
    pub fn note(&self) -> &str {
        &self.note
    }

    /// Notes something for this target. It is written with the next place that was carried.
    pub fn set_note(&mut self, note: String) {
        self.note = note;
    }

    /// Whether it has neither carried nor passed over anything for this target yet.
    pub fn is_new(&self) -> bool {
        self.is_new
    }

    /// Begins with what comes after `marks`: all before counts as carried.
    ///
    /// # Errors
    /// As [`Tail::carried`].
    pub fn pass_over(&mut self, marks: &Marks) -> Result<()> {
        self.carried.clone_from(&marks.0);
        self.write()
    }

    /// Counts nothing as carried. It is written down with the next place that was carried.
    pub fn start_over(&mut self) {
        self.carried.clear();
        self.note.clear();
    }

    /// Bytes of packets that wait to be carried.
    pub fn behind(&self, marks: &Marks) -> u64 {
        let carried = |key| self.carried.get(key).map_or(0, |lengths| lengths.data);
        marks.0.iter().map(|(key, lengths)| lengths.data.saturating_sub(carried(key))).sum()
    }

    /// Shows packets of one day that were not carried yet, as long as `each` answers true; where that ends, or
    /// `None` when everything was carried. Oldest days come first.
    ///
    /// # Errors
    /// When the archive cannot be read.
    pub fn read(&self, marks: &Marks, mut each: impl FnMut(&Archived<'_>) -> bool) -> Result<Option<Place>> {
        let mut days: Vec<_> = marks.0.iter().collect();
        days.sort_by_key(|(key, _)| (key.day, key.part, key.src));
        for (key, durable) in days {
            let mut at = self.carried.get(key).copied().unwrap_or_default();
            if at.data > durable.data {
                // The day is not the one that was carried: it was removed, and came again.
                at = Lengths::default();
            }
            if at.data >= durable.data {
                continue;
            }
            let mut day = DayReader::open(&self.archive, *key, at.data, at.arrivals)?;
            let mut end = None;
            while let Some(archived) = day.next_packet()? {
                if archived.end.data > durable.data {
                    break;
                }
                end = Some(archived.end);
                if !each(&archived) {
                    return Ok(end.map(|end| Place { key: *key, end }));
                }
            }
            // The bytes after the last packet are not a packet; they are not read again.
            let end = Lengths { data: durable.data, ..end.unwrap_or(at) };
            return Ok(Some(Place { key: *key, end }));
        }
        Ok(None)
    }

    /// Everything up to `place` has arrived.
    ///
    /// # Errors
    /// When that cannot be written down; then it is carried again after a restart.
    pub fn carried(&mut self, place: Place, marks: &Marks) -> Result<()> {
        self.carried.insert(place.key, place.end);
        self.carried.retain(|key, _| marks.0.contains_key(key));
        self.write()
    }

    fn write(&mut self) -> Result<()> {
        self.is_new = false;
        let days: Map<String, Value> =
            self.carried.iter().map(|(key, at)| (key.name(), json!([at.data, at.arrivals]))).collect();
        let text = json!({ "target": self.target, "days": days, "note": self.note }).to_string();
        let write = || {
            let new = self.file.with_extension("json.new");
            fs::create_dir_all(self.file.parent().unwrap_or(&self.file))?;
            let mut file = File::create(&new)?;
            file.write_all(text.as_bytes())?;
            file.sync_data()?;
            fs::rename(&new, &self.file)
        };
        write().named(&self.file)
    }
}

/// A day as written in the file.
fn day((name, lengths): (&String, &Value)) -> Option<(DayKey, Lengths)> {
    let (src, day) = name.split_once('/')?;
    let src = u16::from_str_radix(src.strip_prefix("0x")?, 16).ok()?;
    let [data, arrivals] = lengths.as_array()?.as_slice() else { return None };
    let key = DayKey::of_folder(imc::Address(src), day)?;
    Some((key, Lengths { data: data.as_u64()?, arrivals: arrivals.as_u64()? }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Accepted, Store, Transport};
    use imc::messages::Temperature;
    use imc::{Address, Header};
    use units::UtcTime;

    fn accept(store: &mut Store, src: u16, number: u32) {
        let header = Header { timestamp: 1.8e9 + f64::from(number), src: Address(src), ..Header::default() };
        let mut packet = Vec::new();
        imc::encode_into(&mut packet, &header, &Temperature { value: number as f32 }).unwrap();
        let received = UtcTime::from_micros(1_800_000_000_000_000 + i64::from(number) * 3_600_000_000);
        store.accept(&Accepted { packet: &packet, received, transport: Transport::Tcp, link: None }).unwrap();
    }

    /// Carries at most `most` packets at once until nothing is left; the values in order.
    fn carry(tail: &mut Tail, marks: &Marks, most: usize) -> Vec<f32> {
        let mut values = Vec::new();
        loop {
            let mut count = 0;
            let place = tail
                .read(marks, |archived| {
                    values.push(imc::decode::<Temperature>(&archived.view).unwrap().unwrap().value);
                    count += 1;
                    count < most
                })
                .unwrap();
            let Some(place) = place else { return values };
            tail.carried(place, marks).unwrap();
        }
    }

    #[test]
    fn everything_is_carried_once_however_often_it_stops_and_starts() {
        let folder = tempfile::tempdir().unwrap();
        let mut store = Store::open(folder.path()).unwrap();
        let mut heard = Vec::new();
        for number in 0..40 {
            accept(&mut store, 0x2810, number);
            accept(&mut store, 0x2811, number);
            store.sync().unwrap();
            let mut tail = Tail::open(folder.path(), "test", "there").unwrap();
            heard.extend(carry(&mut tail, &store.marks(), 1 + number as usize % 3));
            assert_eq!(tail.behind(&store.marks()), 0);
        }
        let mut expected: Vec<f32> = (0..40).flat_map(|number| [number as f32; 2]).collect();
        heard.sort_by(f32::total_cmp);
        expected.sort_by(f32::total_cmp);
        assert_eq!(heard, expected);
    }

    #[test]
    fn what_is_not_durable_is_not_carried_and_what_did_not_arrive_is_carried_again() {
        let folder = tempfile::tempdir().unwrap();
        let mut store = Store::open(folder.path()).unwrap();
        accept(&mut store, 0x2810, 1);
        let mut tail = Tail::open(folder.path(), "test", "there").unwrap();
        assert_eq!(carry(&mut tail, &store.marks(), 9), [0.0; 0]);
        store.sync().unwrap();
        let marks = store.marks();
        for _ in 0..2 {
            let mut count = 0;
            let place = tail.read(&marks, |_| {
                count += 1;
                true
            });
            assert!(place.unwrap().is_some() && count == 1);
        }
        assert_eq!(carry(&mut tail, &marks, 9), [1.0]);
        // Another target has got nothing yet.
        let mut other = Tail::open(folder.path(), "test", "elsewhere").unwrap();
        assert_eq!(carry(&mut other, &marks, 9), [1.0]);
    }

    #[test]
    fn the_past_can_be_passed_over_once() {
        let folder = tempfile::tempdir().unwrap();
        let mut store = Store::open(folder.path()).unwrap();
        let open = || Tail::open(folder.path(), "test", "there").unwrap();
        accept(&mut store, 0x2810, 1);
        store.sync().unwrap();
        let mut tail = open();
        assert!(tail.is_new());
        tail.pass_over(&store.marks()).unwrap();
        accept(&mut store, 0x2810, 2);
        accept(&mut store, 0x2811, 3);
        store.sync().unwrap();
        let mut tail = open();
        assert!(!tail.is_new());
        assert_eq!(carry(&mut tail, &store.marks(), 9), [2.0, 3.0]);
    }

    #[test]
    fn a_note_stays_with_the_place_of_its_target() {
        let folder = tempfile::tempdir().unwrap();
        let mut store = Store::open(folder.path()).unwrap();
        accept(&mut store, 0x2810, 1);
        store.sync().unwrap();
        let mut tail = Tail::open(folder.path(), "test", "there").unwrap();
        assert_eq!(tail.note(), "");
        tail.set_note("it took \"a\"".to_owned());
        carry(&mut tail, &store.marks(), 9);
        assert_eq!(Tail::open(folder.path(), "test", "there").unwrap().note(), "it took \"a\"");
        assert_eq!(Tail::open(folder.path(), "test", "elsewhere").unwrap().note(), "");
    }

    #[test]
    fn all_is_carried_again_where_it_was_lost() {
        let folder = tempfile::tempdir().unwrap();
        let mut store = Store::open(folder.path()).unwrap();
        accept(&mut store, 0x2810, 1);
        accept(&mut store, 0x2811, 2);
        store.sync().unwrap();
        let mut tail = Tail::open(folder.path(), "test", "there").unwrap();
        assert_eq!(carry(&mut tail, &store.marks(), 9), [1.0, 2.0]);
        tail.start_over();
        assert_eq!(carry(&mut tail, &store.marks(), 1), [1.0, 2.0]);
        assert_eq!(Tail::open(folder.path(), "test", "there").unwrap().behind(&store.marks()), 0);
    }

    #[test]
    fn a_file_that_is_something_else_is_named() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("sinks")).unwrap();
        fs::write(folder.path().join("sinks/test.json"), r#"{"target":"there","days":{"x":[1]}}"#).unwrap();
        let error = Tail::open(folder.path(), "test", "there").unwrap_err().to_string();
        assert!(error.contains("test.json"), "{error}");
    }
}
