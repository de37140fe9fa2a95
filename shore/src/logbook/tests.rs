use super::photos::{self, PHOTO_BYTES};
use super::rows::{AddPhoto, Correct, Earlier, One, PhotoBytes, Said, Withdraw, Write};
use super::{CSV_HEAD, Filter, Logbook, Notes, csv_row};
use crate::clock::Clock;
use crate::error::ErrorKind;
use crate::identity::{Fault, Grants, People, Principal, Request, Settings, Via, migrated};
use crate::owners::Owners;
use api::{LogNote, LogNoteQuery, LogNoteRequest, LogWord, Permission, Role};
use sqlx::SqliteConnection;
use units::UtcTime;

fn said(time_us: i64, vessel: Option<u16>, text: &str) -> Said {
    Said { time_us, vessel, place: None, text: text.to_owned() }
}

async fn write(db: &mut SqliteConnection, said: Said) -> i64 {
    let write = Write { said, person: 7, by: "nils".to_owned(), now: UtcTime::from_micros(90) };
    write.run(db).await.unwrap()
}

async fn texts(db: &mut SqliteConnection, filter: Filter) -> Vec<String> {
    let found = Notes { filter, before: None, count: 10 }.run(db).await.unwrap();
    found.into_iter().map(|row| row.text).collect()
}

#[tokio::test]
async fn notes_are_found_by_vessel_time_and_text_the_newest_first() {
    let mut db = migrated().await;
    let db = &mut db;
    for note in [
        said(30, Some(5), "Mooring at Østmarka"),
        said(10, Some(6), "first"),
        said(20, None, "everybody"),
        said(30, Some(6), "last"),
    ] {
        write(db, note).await;
    }
    let any = Filter::default;
    assert_eq!(texts(db, any()).await, ["last", "Mooring at Østmarka", "everybody", "first"]);
    assert_eq!(
        texts(db, Filter { seen: Some(vec![5]), ..any() }).await,
        ["Mooring at Østmarka", "everybody"]
    );
    assert_eq!(texts(db, Filter { seen: Some(vec![]), ..any() }).await, ["everybody"]);
    assert_eq!(texts(db, Filter { vessels: vec![6], ..any() }).await, ["last", "first"]);
    let general = Filter { vessels: vec![6], general: true, ..any() };
    assert_eq!(texts(db, general).await, ["last", "everybody", "first"]);
    let hidden = Filter { seen: Some(vec![5]), vessels: vec![6], ..any() };
    assert!(texts(db, hidden).await.is_empty());
    assert_eq!(texts(db, Filter { from_us: Some(20), to_us: Some(30), ..any() }).await, ["everybody"]);
    assert_eq!(texts(db, Filter { text: "ØSTMARKA".to_owned(), ..any() }).await, ["Mooring at Østmarka"]);
    let page = Notes { filter: any(), before: None, count: 2 }.run(db).await.unwrap();
    let before = page.last().map(|row| (row.time_us, row.id));
    let rest = Notes { filter: any(), before, count: 2 }.run(db).await.unwrap();
    assert_eq!(rest.iter().map(|row| &*row.text).collect::<Vec<_>>(), ["everybody", "first"]);
}

#[tokio::test]
async fn what_is_corrected_or_withdrawn_is_kept() {
    let mut db = migrated().await;
    let db = &mut db;
    let id = write(db, said(10, Some(5), "wind 3 m/s")).await;
    let correct = |revision, text: &str| Correct {
        id,
        revision,
        said: Said { place: Some((63.4, 10.4)), ..said(11, Some(5), text) },
        by: "anna".to_owned(),
        now: UtcTime::from_micros(100),
    };
    correct(1, "wind 8 m/s").run(db).await.unwrap();
    let late = correct(1, "wind 9 m/s").run(db).await.unwrap_err();
    assert!(matches!(&late, Fault::Refused(text) if text.contains("meanwhile")), "{late}");
    let row = One(id).run(db).await.unwrap().unwrap();
    assert_eq!((row.revision, &*row.text, row.lat_deg), (2, "wind 8 m/s", Some(63.4)));
    assert_eq!(
        (row.corrected_by.as_deref(), row.corrected_us, row.written_us),
        (Some("anna"), Some(100), 90)
    );
    let earlier = Earlier(id).run(db).await.unwrap();
    assert_eq!((earlier.len(), &*earlier[0].text, earlier[0].lat_deg), (1, "wind 3 m/s", None));
    assert_eq!(earlier[0].written, LogWord { by: "nils".to_owned(), time_us: 90 });
    assert!(texts(db, Filter { text: "3 m/s".to_owned(), ..Filter::default() }).await.is_empty());

    let withdraw =
        |revision| Withdraw { id, revision, by: "anna".to_owned(), now: UtcTime::from_micros(110) };
    withdraw(1).run(db).await.unwrap_err();
    withdraw(2).run(db).await.unwrap();
    withdraw(2).run(db).await.unwrap_err();
    correct(2, "again").run(db).await.unwrap_err();
    assert!(texts(db, Filter::default()).await.is_empty());
    assert_eq!(texts(db, Filter { withdrawn: true, ..Filter::default() }).await, ["wind 8 m/s"]);
}

#[tokio::test]
async fn a_note_has_one_photo_and_all_are_counted() {
    let mut db = migrated().await;
    let db = &mut db;
    let ids = [write(db, said(1, None, "a")).await, write(db, said(2, None, "b")).await];
    for id in ids {
        AddPhoto { id, media: "image/png", bytes: 1_000 }.run(db).await.unwrap();
    }
    AddPhoto { id: ids[0], media: "image/png", bytes: 1_000 }.run(db).await.unwrap_err();
    assert_eq!(PhotoBytes.run(db).await.unwrap(), 2_000);
    assert_eq!(One(ids[1]).run(db).await.unwrap().unwrap().photo.as_deref(), Some("image/png"));
}

#[test]
fn a_photo_is_known_by_its_first_bytes() {
    assert_eq!(photos::check(b"\xFF\xD8\xFF\xE0rest").unwrap(), "image/jpeg");
    assert_eq!(photos::check(b"\x89PNG\r\n\x1A\nrest").unwrap(), "image/png");
    assert_eq!(photos::check(b"RIFF\x10\0\0\0WEBPVP8 ").unwrap(), "image/webp");
    for none in [&b""[..], b"<svg>", b"GIF89a", b"RIFF\x10\0\0\0WAVE", b"\xFF\xD8"] {
        assert!(photos::check(none).unwrap_err().text.contains("not a JPEG, PNG or WebP"));
    }
    let mut large = b"\xFF\xD8\xFF".to_vec();
    large.resize(PHOTO_BYTES + 1, 0);
    assert!(photos::check(&large).unwrap_err().text.contains("more than 4 MiB"));
}

#[test]
fn the_file_quotes_text_and_keeps_it_from_being_a_formula() {
    let note = LogNote {
        id: 3,
        revision: 1,
        time_us: 1_772_368_496_000_000,
        vessel: Some(0x0814),
        vessel_name: None,
        lat_deg: Some(-63.4),
        lon_deg: Some(10.4),
        text: "=1+1, \"so\"\nand on".to_owned(),
        by: "nils".to_owned(),
        written_us: 1_772_368_497_500_000,
        corrected: None,
        withdrawn: Some(LogWord { by: "anna".to_owned(), time_us: 1_772_368_498_000_000 }),
        photo: None,
        may_change: true,
    };
    let mut out = Vec::new();
    csv_row(&mut out, &note);
    let row = String::from_utf8(out).unwrap();
    assert_eq!(
        row,
        "2026-03-01T12:34:56.000000Z,0x0814,-63.40000000,10.40000000,\"'=1+1, \"\"so\"\"\nand on\",nils,\
         2026-03-01T12:34:57.500000Z,,,2026-03-01T12:34:58.000000Z,anna,,3\n"
    );
    assert_eq!(CSV_HEAD.split(',').count(), 13);
}

fn operator() -> Principal {
    let grants = Grants::new(&[Permission { vessel: None, role: Role::Operator }]);
    let via = Via::Token { id: 1, label: "test".to_owned() };
    Principal { person: 7, name: "nils".to_owned(), grants, language: None, via }
}

/// Marks a note as having a photo as large as the total limit.
struct Fill(i64);

impl Request for Fill {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        let sql = "UPDATE log_note SET photo = 'image/png', photo_bytes = ?2 WHERE id = ?1";
        sqlx::query(sql).bind(self.0).bind(photos::ALL_BYTES.cast_signed()).execute(db).await?;
        Ok(())
    }
}

#[tokio::test]
async fn photos_together_keep_within_their_bound_and_the_note_stays() {
    let folder = tempfile::tempdir().unwrap();
    let clock = Clock::real();
    let owners = Owners::new(clock.clone());
    let people = People::start(folder.path(), &Settings::default(), &owners, clock.clone()).await.unwrap().0;
    let logbook = Logbook::new(people.clone(), clock, folder.path());
    let who = operator();
    let here = || "::1".to_owned();
    let mut ids = Vec::new();
    for text in ["full", "one more"] {
        let ask = LogNoteRequest { text: text.to_owned(), ..LogNoteRequest::default() };
        ids.push(logbook.write(&who, here(), ask, LogNoteQuery::default()).await.unwrap().id);
    }
    let photo = b"\x89PNG\r\n\x1A\nrest".to_vec();
    people.change(Fill(ids[0])).await.unwrap();
    let told = logbook.add_photo(&who, here(), ids[1], photo.clone()).await.unwrap_err();
    assert!(told.kind == ErrorKind::Refused && told.text.contains("2 GiB of photos"), "{told}");
    assert!(!folder.path().join("logbook").exists(), "nothing was written");
    let notes = logbook.page(&who, Filter::default(), None, 10).await.unwrap().notes;
    assert_eq!((notes.len(), notes[0].photo.as_deref()), (2, None), "the note is kept");
}

#[tokio::test]
async fn a_note_without_a_time_is_about_the_moment_it_was_sent_first() {
    let folder = tempfile::tempdir().unwrap();
    let clock = Clock::real();
    let owners = Owners::new(clock.clone());
    let people = People::start(folder.path(), &Settings::default(), &owners, clock.clone()).await.unwrap().0;
    let logbook = Logbook::new(people, clock.clone(), folder.path());
    let who = operator();
    let send = |time_us, waited_ms| {
        let ask = LogNoteRequest { text: "swell".to_owned(), time_us, ..LogNoteRequest::default() };
        logbook.write(&who, "::1".to_owned(), ask, LogNoteQuery { key: None, waited_ms })
    };
    let now_us = clock.utc().micros();
    let late_us = send(None, Some(90_000)).await.unwrap().time_us - now_us;
    assert!((-90_000_000..-60_000_000).contains(&late_us), "{late_us}");
    assert_eq!(send(Some(5), Some(90_000)).await.unwrap().time_us, 5, "its own time stays");
    let told = send(None, Some(3_600_001)).await.unwrap_err();
    assert!(told.text.starts_with("waited_ms"), "{told}");
}
