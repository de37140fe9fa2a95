//! Updates: inserting, deleting and changing records and the lists in them.
//!
//! S-57 part 3, 8.4. Updates of one edition are numbered without gaps; each is applied whole or not at all.
//! An index in a list counts from 1; inserting puts items before it, so that length + 1 appends.

use super::error::{S57Error, S57Problem};
use super::feature::Attribute;
use super::fields::FileReader;
use super::records::{
    Control, DataRecord, DatasetId, Edits, FeatureRecord, Instruction, Pointer, VectorRecord,
};
use super::store::{Notice, Store, StoredFeature, StoredVector, Tally, at};

/// Deletes an attribute when it stands alone as its value (S-57 part 3, 8.4.2.2.b and 8.4.2.3).
const DELETED: &str = "\u{7F}";

impl Store {
    /// Applies one update file.
    ///
    /// Returns false, having done nothing, where the base is a re-issue that contains the update already.
    pub(super) fn apply(&mut self, file: &str, bytes: &[u8]) -> Result<bool, S57Error> {
        let mut reader = FileReader::new(file, bytes)?;
        let fail = |problem| S57Error { file: file.to_owned(), place: None, problem };
        let Some((place, DataRecord::Id(id, structure))) = reader.next_record()? else {
            return Err(fail(S57Problem::NoIdentification));
        };
        if !self.admits(&id).map_err(|problem| at(file, place, problem))? {
            return Ok(false);
        }
        // Half an update is worse than none: work on a copy.
        let mut next = self.clone();
        let mut tally = Tally::default();
        while let Some((place, record)) = reader.next_record()? {
            tally.add(&record);
            let done = match record {
                DataRecord::Feature(record) => next.apply_feature(file, record),
                DataRecord::Vector(record) => next.apply_vector(file, record),
                DataRecord::Id(..) | DataRecord::Parameters(_) | DataRecord::Other => Ok(()),
            };
            done.map_err(|problem| at(file, place, problem))?;
        }
        let texts = tally.compare(&structure.unwrap_or_default()).map_err(fail)?;
        next.note(file, texts);
        next.id.update = id.update;
        next.id.issue_date = id.issue_date;
        next.bytes = next.bytes.saturating_add(bytes.len());
        *self = next;
        Ok(true)
    }

    /// Whether the update is the next one; false where it is contained already.
    fn admits(&self, id: &DatasetId) -> Result<bool, S57Problem> {
        if id.purpose != 2 {
            return Err(S57Problem::NotAnUpdate);
        }
        let stem = |name: &str| name.split('.').next().unwrap_or_default().to_ascii_uppercase();
        if stem(&id.name) != stem(&self.id.name) {
            return Err(S57Problem::OtherCell { expected: self.id.name.clone(), found: id.name.clone() });
        }
        if id.edition == "0" {
            return Err(S57Problem::Cancelled);
        }
        if id.edition != self.id.edition {
            let (expected, found) = (self.id.edition.clone(), id.edition.clone());
            return Err(S57Problem::OtherEdition { expected, found });
        }
        let number = |text: &str| {
            let range = S57Problem::Range { what: "the update number (UPDN)" };
            text.parse::<u32>().map_err(|_| range)
        };
        let applied = if self.id.update.is_empty() { 0 } else { number(&self.id.update)? };
        let found = number(&id.update)?;
        if found <= self.reissue {
            return Ok(false);
        }
        let expected = applied.saturating_add(1);
        if found == expected { Ok(true) } else { Err(S57Problem::OutOfOrder { expected, found }) }
    }

    fn apply_feature(&mut self, file: &str, record: FeatureRecord) -> Result<(), S57Problem> {
        let id = record.id;
        let fail = |what| S57Problem::Record { kind: "feature", id, what };
        if record.instruction == Instruction::Insert {
            let feature = StoredFeature::from_record(record)?;
            let before = self.features.insert(id, feature);
            return before.map_or(Ok(()), |_| Err(fail("to be inserted, but there already")));
        }
        let Some(target) = self.features.get_mut(&id) else {
            return Err(fail("to be changed or deleted, but not there"));
        };
        if record.object.is_some_and(|object| object != target.object) {
            return Err(fail("another object than the update means"));
        }
        if record.version != target.version.wrapping_add(1) {
            let text = format!("feature {id} goes from version {} to {}", target.version, record.version);
            self.notices.push(Notice { file: file.to_owned(), feature: Some(id), text });
        }
        if record.instruction == Instruction::Delete {
            self.features.remove(&id);
            return Ok(());
        }
        target.version = record.version;
        merge(&mut target.attributes, record.attributes);
        merge(&mut target.national, record.national);
        edit(&mut target.links, record.links).map_err(fail)?;
        let before = target.pointers.clone();
        edit(&mut target.pointers, record.pointers).map_err(fail)?;
        let held = |one: &Pointer| target.pointers.iter().any(|now| now.name == one.name);
        if !before.iter().all(held) {
            target.last_pointers = before;
        }
        Ok(())
    }

    fn apply_vector(&mut self, file: &str, record: VectorRecord) -> Result<(), S57Problem> {
        let name = record.name;
        let fail = |what| S57Problem::Record { kind: "vector record", id: name.id, what };
        if record.instruction == Instruction::Insert {
            let vector = StoredVector::from_record(record)?;
            let before = self.vectors.insert(name, vector);
            return before.map_or(Ok(()), |_| Err(fail("to be inserted, but there already")));
        }
        let Some(target) = self.vectors.get_mut(&name) else {
            return Err(fail("to be changed or deleted, but not there"));
        };
        if record.version != target.version.wrapping_add(1) {
            let text =
                format!("vector {} goes from version {} to {}", name.id, target.version, record.version);
            self.notices.push(Notice { file: file.to_owned(), feature: None, text });
        }
        if record.instruction == Instruction::Delete {
            self.lost.extend(self.vectors.remove(&name).map(|vector| (name, vector)));
            return Ok(());
        }
        target.version = record.version;
        merge(&mut target.attributes, record.attributes);
        let before = target.clone();
        edit(&mut target.pointers, record.pointers).map_err(fail)?;
        // An edge that had no vertices between its nodes gets them without a control.
        let plain = matches!(record.coordinates.as_slice(), [(None, _)]);
        if plain && !target.coordinates.is_empty() {
            return Err(fail("given coordinates without saying where they go (no SGCC)"));
        }
        let positions = record.coordinates.iter().any(|(_, items)| !items.is_empty());
        if positions && !target.coordinates.is_empty() && record.has_depths != target.has_depths {
            // A missing depth would be read as 0 m, and a depth among vertices be lost.
            return Err(fail(if record.has_depths {
                "given soundings among positions without depths"
            } else {
                "given positions without depths among soundings"
            }));
        }
        target.has_depths |= record.has_depths;
        edit(&mut target.coordinates, record.coordinates).map_err(fail)?;
        let emptied = target.coordinates.is_empty() && !before.coordinates.is_empty();
        if emptied || target.pointers.len() < before.pointers.len() {
            self.lost.insert(name, before);
        }
        Ok(())
    }
}

/// Replaces, adds and deletes attributes.
fn merge(attributes: &mut Vec<Attribute>, changes: Vec<Attribute>) {
    for change in changes {
        let at = attributes.iter().position(|one| one.code == change.code);
        match at {
            Some(at) if change.value == DELETED => {
                attributes.remove(at);
            }
            Some(at) => attributes[at] = change,
            None if change.value == DELETED => {}
            None => attributes.push(change),
        }
    }
}

/// Works off the edits of one list in their order.
fn edit<T>(list: &mut Vec<T>, edits: Edits<T>) -> Result<(), &'static str> {
    for (control, items) in edits {
        let Some(Control { instruction, index, count }) = control else {
            list.extend(items);
            continue;
        };
        let from = index.checked_sub(1).ok_or("changed at index 0 of a list")?;
        let to = from.checked_add(count).ok_or("changed beyond the end of a list")?;
        let items_expected = if instruction == Instruction::Delete { 0 } else { count };
        if items.len() != items_expected {
            return Err("changed by another number of items than announced");
        }
        match instruction {
            Instruction::Insert if from <= list.len() => {
                list.splice(from..from, items);
            }
            Instruction::Delete if to <= list.len() => {
                list.drain(from..to);
            }
            Instruction::Modify if to <= list.len() => {
                list.splice(from..to, items);
            }
            Instruction::Insert | Instruction::Delete | Instruction::Modify => {
                return Err("changed beyond the end of a list");
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::s57::AttributeCode;

    fn control(instruction: Instruction, index: usize, count: usize) -> Control {
        Control { instruction, index, count }
    }

    #[test]
    fn lists_are_edited_in_order() {
        let mut list = vec![1, 2, 3, 4];
        let edits = vec![
            (Some(control(Instruction::Insert, 5, 1)), vec![5]),
            (Some(control(Instruction::Delete, 1, 2)), vec![]),
            (Some(control(Instruction::Modify, 1, 1)), vec![30]),
            (Some(control(Instruction::Insert, 1, 2)), vec![10, 20]),
        ];
        edit(&mut list, edits).unwrap();
        assert_eq!(list, [10, 20, 30, 4, 5]);
    }

    #[test]
    fn refuses_edits_beyond_a_list() {
        for (instruction, index, count, items) in [
            (Instruction::Insert, 3, 1, vec![9]),
            (Instruction::Insert, 0, 1, vec![9]),
            (Instruction::Delete, 1, 2, vec![]),
            (Instruction::Modify, 1, 2, vec![8, 9]),
            (Instruction::Modify, 1, 1, vec![]),
            (Instruction::Delete, usize::MAX, usize::MAX, vec![]),
        ] {
            assert!(edit(&mut vec![1], vec![(Some(control(instruction, index, count)), items)]).is_err());
        }
    }

    #[test]
    fn a_delete_marker_removes_an_attribute() {
        let attribute = |code, value: &str| Attribute { code: AttributeCode(code), value: value.to_owned() };
        let mut attributes = vec![attribute(87, "5"), attribute(88, "10")];
        merge(&mut attributes, vec![attribute(87, "\u{7F}"), attribute(88, "9"), attribute(116, "X")]);
        assert_eq!(attributes, [attribute(88, "9"), attribute(116, "X")]);
    }
}
