use super::*;
use crate::fields::KINDS;
use api::{RegisterAnimal, RegisterTag};
use proptest::prelude::*;

fn address(text: &str) -> Result<u16, Said> {
    if text == "otter-1" {
        Ok(0x0814)
    } else {
        text.parse().map_err(|_| Said::as_is(format!("no vessel is called `{text}`")))
    }
}

fn name(address: u16) -> String {
    if address == 0x0814 { "otter-1".to_owned() } else { address.to_string() }
}

const NAMES: Names<'static> = Names { address: &address, name: &name };

fn read(kind: RegisterKind, text: &str) -> Read {
    read_csv(kind, text.as_bytes(), &[], &NAMES)
}

fn wrong(kind: RegisterKind, text: &str) -> Vec<String> {
    let told = |one: WrongCell| format!("{} {}: {}", one.line, one.column, one.text);
    read(kind, text).wrong.into_iter().map(told).collect()
}

fn animals(text: &str) -> Vec<RegisterAnimal> {
    let read = read(RegisterKind::Animal, text);
    assert_eq!(read.wrong, []);
    let animal = |row: ReadRow| match row.record {
        RegisterRecord::Animal(animal) => animal,
        other => panic!("{other:?}"),
    };
    read.rows.into_iter().map(animal).collect()
}

#[test]
fn tables_of_spreadsheets_are_read() {
    let plain = animals(
        "name,length_mm,release_time,notes\nA,512.5,2026-11-20 08:00,\"a, \"\"b\"\"\nc\"\n\n,,,\nB,,,\n",
    );
    assert_eq!((plain.len(), plain[0].length_mm, &*plain[0].notes), (2, Some(512.5), "a, \"b\"\nc"));
    assert_eq!(plain[0].release_us, Some(1_795_161_600_000_000));
    let european = animals("\u{FEFF}Name;Length_mm;release_time\r\nA;512,5;2026-11-20T10:00+02:00\r\n");
    assert_eq!((european[0].length_mm, european[0].release_us), (Some(512.5), Some(1_795_161_600_000_000)));
    let tabs = animals("name\tlength_mm\nA\t512.5\n");
    assert_eq!(tabs[0].length_mm, Some(512.5));
    assert_eq!(animals("name,aphia_id\nA,NA\n'=B,127186")[1].name, "=B", "the guard is taken off");
}

#[test]
fn every_problem_is_told_at_once_with_line_column_and_remedy() {
    let text = "name,length_mm,sex,release_time,colour\n\
                A,51 cm,F,20.11.2026,\n\
                ,\"12,5\",x,2026-11-20,\n\
                A,12,,,\n\
                B,1\n\
                C,12,,,red";
    let told = wrong(RegisterKind::Animal, text).join("\n");
    for part in [
        "1 colour: is not a column of this table",
        "2 length_mm: `51 cm` is not a number; write digits",
        "2 release_time: `20.11.2026`: no time in ISO 8601",
        "3 name: empty",
        "3 length_mm: `12,5` is not a number here: write a decimal point",
        "3 sex: `x` is not one of F, M, U",
        "4 name: `A` stands in line 2 too",
        "5 : has 2 cells, the header 5",
    ] {
        assert!(told.contains(part), "{part}\n{told}");
    }
    assert_eq!(told.lines().count(), 8, "{told}");
}

#[test]
fn a_file_that_is_no_table_is_told_so() {
    for (bytes, part) in [
        (&b""[..], "1 : the file is empty"),
        (b"name\nB\xf8rge", "2 : is not UTF-8 from here on"),
        (b"PK\x03\x04\0\0", "1 : this is not text"),
        (b"name\nA\n\"B\nC\n", "3 : a quote that opens here is never closed"),
        (b"nam,sexx\nA,F", "1 nam: is not a column of this table; did you mean `name`"),
        (b"sex\nF", "1 name: the header lacks this column"),
        (b"name,Name\nA,B", "1 Name: stands in the header twice"),
    ] {
        let told = read_csv(RegisterKind::Animal, bytes, &[], &NAMES).wrong;
        let told: Vec<String> =
            told.iter().map(|one| format!("{} {}: {}", one.line, one.column, one.text)).collect();
        assert!(told.iter().any(|text| text.starts_with(part)), "{part}: {told:?}");
    }
    let many = format!("name\n{}", "A\n".repeat(ROWS + 1));
    assert!(wrong(RegisterKind::Animal, &many)[0].contains("more than 10000 lines"));
    // The text after it is not even read.
    let endless = format!("{many}{}", "A\n\"".repeat(3));
    assert!(wrong(RegisterKind::Animal, &endless)[0].contains("more than 10000 lines"));
    for wide in [format!("name{}\nA", ",x".repeat(64)), format!("\"na\nme\"{}\nA", ",x".repeat(64))] {
        let told = wrong(RegisterKind::Animal, &wide);
        assert_eq!(told.len(), 1, "{told:?}");
        assert!(told[0].starts_with("1 : the header has 65 cells"), "{told:?}");
    }
}

#[test]
fn a_point_that_can_stand_between_thousands_is_no_decimal_point() {
    let told =
        wrong(RegisterKind::Animal, "name;weight_g\nA;1.340\nB;-1.234.567\nC;1.34\nD;1,340\nE;1340.5\n");
    assert_eq!(told.len(), 2, "{told:?}");
    assert_eq!(told[0], "2 weight_g: `1.340` can be 1340 or 1,340 here: write one of these");
    assert_eq!(animals("name,weight_g\nA,1.340\n")[0].weight_g, Some(1.34));
}

#[test]
fn what_r_writes_for_nothing_is_nothing_but_in_a_name() {
    let all = animals("name,sex,notes\nNA,NA,NA\nB,F,'NA\n");
    assert_eq!((&*all[0].name, &*all[0].sex, &*all[0].notes, &*all[1].notes), ("NA", "", "", "NA"));
    let records = all.iter().cloned().map(RegisterRecord::Animal).collect::<Vec<_>>();
    let written = write_csv(RegisterKind::Animal, &records, &NAMES);
    assert_eq!(animals(std::str::from_utf8(&written).unwrap()), all);
}

#[test]
fn a_line_changes_the_entry_of_its_name_and_leaves_what_the_table_has_no_column_for() {
    let known = RegisterRecord::Tag(RegisterTag {
        name: "R64K-7".to_owned(),
        protocol: "R64K".to_owned(),
        tag_id: Some(7),
        serial: "12".to_owned(),
        sensor_unit: "m".to_owned(),
        ..RegisterTag::default()
    });
    let text = "protocol,tag_id,sensor_unit,animal\nr64k,7,,\nOPs,8,,";
    let read = read_csv(RegisterKind::Tag, text.as_bytes(), &[&known], &NAMES);
    assert_eq!(read.wrong, []);
    assert_eq!(
        read.rows.iter().map(|row| (row.line, row.known)).collect::<Vec<_>>(),
        [(2, Some(0)), (3, None)]
    );
    let RegisterRecord::Tag(tag) = &read.rows[0].record else { panic!("a tag") };
    assert_eq!((&*tag.serial, &*tag.sensor_unit, &*tag.protocol), ("12", "", "r64k"));
    let changed = differences(&known, &read.rows[0].record, &NAMES);
    let changed: Vec<(&str, &str, &str)> =
        changed.iter().map(|one| (one.column, &*one.before, &*one.after)).collect();
    assert_eq!(changed, [("protocol", "R64K", "r64k"), ("sensor_unit", "m", "")]);
}

#[test]
fn vessels_are_named() {
    let text = "receiver,vessel,from_time\nr,otter-1,2026-05-01\nr,7,2026-05-02\nr,boat,2026-05-03";
    let read = read(RegisterKind::Deployment, text);
    assert_eq!(read.wrong.len(), 1);
    assert!(read.wrong[0].line == 4 && read.wrong[0].text.to_string().contains("boat"), "{:?}", read.wrong);
    let records: Vec<RegisterRecord> = read.rows.into_iter().map(|row| row.record).collect();
    let written = String::from_utf8(write_csv(RegisterKind::Deployment, &records, &NAMES)).unwrap();
    assert!(written.contains("r 2026-05-01T00:00Z,r,otter-1,,2026-05-01T00:00:00Z,,,,,\n"), "{written}");
}

proptest! {
    #[test]
    fn any_bytes_are_read_or_refused(bytes: Vec<u8>) {
        for kind in KINDS {
            read_csv(kind, &bytes, &[], &NAMES);
        }
    }

    #[test]
    fn any_table_is_read_or_refused(text in "[a-z,;\t\"'\r\n=0-9.]{0,200}") {
        read_csv(RegisterKind::Animal, format!("name,length_mm,notes\n{text}").as_bytes(), &[], &NAMES);
    }

    #[test]
    fn what_is_written_is_read_back(
        name in "[A-Za-zæøå =+@'-]{0,20}[a-z]",
        notes in "([ -~æøå\n]{0,40}[a-z])?",
        length_mm in proptest::option::of(1.0..40_000.0),
        release_us in proptest::option::of(0..4_000_000_000_000_000_i64),
    ) {
        let name = name.trim().to_owned();
        let one = RegisterAnimal { name, notes: notes.trim().to_owned(), length_mm, release_us, ..RegisterAnimal::default() };
        let bytes = write_csv(RegisterKind::Animal, [&RegisterRecord::Animal(one.clone())], &NAMES);
        let read = animals(std::str::from_utf8(&bytes).unwrap());
        prop_assert_eq!(read, [one]);
    }
}
