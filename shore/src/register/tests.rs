use super::file::TakeFile;
use super::import::look;
use super::rows::{All, Row, Step, Write, study};
use super::service::Called;
use crate::identity::{Fault, Request as _, migrated, within_transaction};
use api::{RegisterAnimal, RegisterKind, RegisterRecord, RegisterTag, Vessel};
use sqlx::SqliteConnection;
use units::UtcTime;

fn animal(name: &str) -> RegisterRecord {
    RegisterRecord::Animal(RegisterAnimal { name: name.to_owned(), ..RegisterAnimal::default() })
}

fn tag(name: &str, id: i64, animal: &str) -> RegisterRecord {
    let (name, animal, protocol) = (name.to_owned(), animal.to_owned(), "R64K".to_owned());
    RegisterRecord::Tag(RegisterTag { name, protocol, tag_id: Some(id), animal, ..RegisterTag::default() })
}

fn write(steps: Vec<Step>) -> Write {
    Write { steps, version: None, by: "kari".to_owned(), now: UtcTime::from_micros(5), asked: None }
}

async fn rows(db: &mut SqliteConnection) -> (i64, Vec<Row>) {
    All.run(db).await.unwrap()
}

/// In a transaction, as the writer of app.db does: a refused change leaves nothing behind.
async fn done(db: &mut SqliteConnection, write: Write) -> Result<i64, Fault> {
    within_transaction(db, write).await
}

fn refusal(done: Result<i64, Fault>) -> String {
    match done {
        Err(Fault::Refused(text)) => text.into(),
        other => panic!("{other:?}"),
    }
}

#[tokio::test]
async fn entries_are_kept_with_what_they_said_before() {
    let mut db = migrated().await;
    let db = &mut db;
    let fish = done(db, write(vec![Step::Add(animal("Fish"))])).await.unwrap();
    let code = done(db, write(vec![Step::Add(tag("T", 7, "fish"))])).await.unwrap();
    let (version, all) = rows(db).await;
    assert_eq!((version, all.iter().map(|row| row.id).collect::<Vec<_>>()), (2, vec![fish, code]));

    // A missing reference, a duplicate name, a code used twice at a time, an older revision: nothing is changed.
    for (steps, told) in [
        (
            vec![Step::Add(tag("U", 8, "Fisk"))],
            "animal: tag `U`: no animal is called `Fisk`; did you mean `Fish`?",
        ),
        (vec![Step::Add(animal("FISH"))], "name: another animal is called `Fish`; choose another name"),
        (
            vec![Step::Add(tag("U", 7, ""))],
            "from_time: tag `U`: the tag `T` has this protocol and number (7)",
        ),
        (
            vec![Step::Delete(fish, 1)],
            "animal: tag `T`: no animal is called `fish`; register the animal first",
        ),
        (vec![Step::Change(fish, 1, animal("Fisk"))], "animal: tag `T`: no animal is called `fish`"),
        (vec![Step::Delete(code, 2)], "meanwhile"),
    ] {
        let text = refusal(done(db, write(steps)).await);
        assert!(text.contains(told), "{told}: {text}");
    }
    assert_eq!(rows(db).await, (version, all));
}

#[tokio::test]
async fn a_change_of_many_is_done_whole_and_keeps_what_was() {
    let mut db = migrated().await;
    let db = &mut db;
    let fish = done(db, write(vec![Step::Add(animal("Fish"))])).await.unwrap();
    let steps = vec![Step::Change(fish, 1, animal("Fisk")), Step::Add(tag("T", 7, "Fisk"))];
    done(db, write(steps)).await.unwrap();
    let sql = "SELECT body, by, ended_by, ended_us FROM study_entry_before WHERE entry = ?1";
    let (body, by, ended_by, ended_us): (String, String, String, i64) =
        sqlx::query_as(sql).bind(fish).fetch_one(&mut *db).await.unwrap();
    assert_eq!(serde_json::from_str::<RegisterRecord>(&body).unwrap(), animal("Fish"));
    assert_eq!((&*by, &*ended_by, ended_us), ("kari", "kari", 5));
    let late = Write { version: Some(1), ..write(vec![Step::Add(animal("Other"))]) };
    assert!(refusal(done(db, late).await).contains("meanwhile"));
    let (version, all) = rows(db).await;
    assert_eq!((version, all.len(), all[0].revision), (2, 2, 2));
    // A number is never used again.
    let code = all[1].id;
    done(db, write(vec![Step::Delete(code, 1)])).await.unwrap();
    assert!(done(db, write(vec![Step::Add(animal("Other"))])).await.unwrap() > code);
    drop(study(rows(db).await.1));
}

#[tokio::test]
async fn a_file_is_looked_at_before_it_is_taken() {
    let mut db = migrated().await;
    let db = &mut db;
    done(db, write(vec![Step::Add(animal("Fish")), Step::Add(tag("T", 7, "Fish"))])).await.unwrap();
    let (version, all) = rows(db).await;
    let called = Called::new(&[Vessel { address: 7, name: "otter".to_owned() }]);
    let looked = |text: &str| {
        look(RegisterKind::Tag, text.as_bytes(), (version, &all), &called.names(), &|_| None, &|_| true)
    };
    let (answer, steps) = looked("name,protocol,tag_id,serial\nT,R64K,7,99\n,S256,8,\n");
    assert_eq!((answer.added, answer.changed, answer.same, answer.problems.len()), (1, 1, 0, 0));
    assert_eq!(answer.changes[0].fields.iter().map(|one| &*one.column).collect::<Vec<_>>(), ["serial"]);
    assert!(answer.changes[1].is_new && answer.changes[1].name == "S256-8" && !answer.applied);
    done(db, write(steps)).await.unwrap();
    let (_, after) = rows(db).await;
    let RegisterRecord::Tag(tag) = &after[2].record else { panic!("tags come after animals") };
    assert_eq!((&*tag.animal, &*tag.serial), ("Fish", "99"), "what the table has no column for stays");

    let (answer, _) = looked("name,protocol,tag_id,animal\nT,R64K,7,Fish\nU,R64K,7,Fisk\n");
    assert_eq!((answer.same, answer.added), (1, 1));
    let told: Vec<String> =
        answer.problems.iter().map(|one| format!("{:?} {}: {}", one.line, one.column, one.text)).collect();
    assert!(told[0].starts_with("Some(3) animal: no animal is called `Fisk`"), "{told:?}");
    assert!(told[1].starts_with("Some(3) from_time: the tag `T` has"), "{told:?}");
}

#[tokio::test]
async fn a_file_is_taken_only_of_the_register_that_was_looked_at() {
    let mut db = migrated().await;
    let db = &mut db;
    let file = |apply| TakeFile {
        kind: RegisterKind::Animal,
        bytes: b"name,notes\nFish,old\n".to_vec(),
        apply,
        by: "cli".to_owned(),
        now: UtcTime::from_micros(6),
    };
    let looked = within_transaction(db, file(None)).await.unwrap();
    assert_eq!((looked.version, looked.added, looked.applied), (0, 1, false));
    done(db, write(vec![Step::Add(animal("Fish"))])).await.unwrap();
    let late = within_transaction(db, file(Some(looked.version))).await;
    assert!(matches!(&late, Err(Fault::Refused(text)) if text.contains("meanwhile")), "{late:?}");
    let taken = within_transaction(db, file(Some(1))).await.unwrap();
    assert_eq!((taken.version, taken.changed, taken.applied), (2, 1, true));
}
