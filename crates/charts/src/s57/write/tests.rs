//! Real cells and updates, record by record written again: they must read as before.

use super::*;
use crate::s57::fields::FileReader;
use crate::s57::{Cell, NamedBytes};

/// All records of a file, written by this module in the file's own lexical levels.
fn rewritten(name: &str, bytes: &[u8]) -> Vec<u8> {
    let mut reader = FileReader::new(name, bytes).unwrap();
    let (mut head, mut list) = (None, Vec::new());
    let mut parameters = None;
    while let Some((_, record)) = reader.next_record().unwrap() {
        match record {
            DataRecord::Id(id, structure) => head = Some((id, structure.unwrap_or_default())),
            DataRecord::Parameters(found) => parameters = Some(found),
            DataRecord::Feature(_) | DataRecord::Vector(_) => list.push(record),
            DataRecord::Other => {}
        }
    }
    let (id, structure) = head.unwrap();
    let style = Style {
        attributes: structure.attribute_level,
        national: structure.national_level,
        entries: EntryMap::Fixed { length: 6, position: 6 },
    };
    let units = MeasureUnits::default();
    let parameters = parameters.map(|found| vec![encode::parameters(&found, units).unwrap()]);
    file(&id, style, parameters, &Records::of(list)).unwrap()
}

#[test]
fn real_cells_written_again_read_as_before() {
    let cells = [
        ("US5WA22M", 4),
        ("US4MD81M", 3),
        ("US5MD1MC", 0),
        ("US1BS01M", 0),
        ("GB4X0000", 0),
        ("GB5X01NE", 0),
        ("GB5X01SE", 0),
    ];
    for (cell, updates) in cells {
        let names: Vec<String> = (0..=updates).map(|number| format!("{cell}.{number:03}")).collect();
        let shared = |name: &String| testkit::shared(&format!("data/charts/{name}"));
        let Some(paths) = names.iter().map(shared).collect::<Option<Vec<_>>>() else { return };
        let files: Vec<Vec<u8>> = paths.iter().map(|path| std::fs::read(path).unwrap()).collect();
        let again: Vec<Vec<u8>> =
            names.iter().zip(&files).map(|(name, bytes)| rewritten(name, bytes)).collect();
        let read = |files: &[Vec<u8>]| {
            let named: Vec<_> =
                names.iter().zip(files).map(|(name, bytes)| NamedBytes { name, bytes }).collect();
            Cell::read(named[0], &named[1..]).unwrap()
        };
        let (before, after) = (read(&files), read(&again));
        assert_eq!((&after.id, &after.parameters), (&before.id, &before.parameters));
        assert_eq!(after.notices, before.notices, "{cell}");
        assert!(after.features == before.features, "{cell} differs");
    }
}
