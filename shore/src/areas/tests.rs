use super::rows::{CLOSED, Change, Closed, Create, Lifted, One, Row};
use crate::identity::{Fault, Request as _, migrated};
use api::NoGoAreaRequest;
use units::UtcTime;

fn area(name: &str) -> NoGoAreaRequest {
    let corners = vec![[63.0, 10.0], [63.1, 10.0], [63.0, 10.1]];
    NoGoAreaRequest { name: name.to_owned(), reason: String::new(), corners }
}

fn create(name: &str) -> Create {
    Create { areas: vec![area(name)], by: "nils".to_owned(), now: UtcTime::from_micros(1) }
}

fn names(rows: Vec<Row>) -> Vec<String> {
    rows.into_iter().map(|row| row.area.unwrap().name).collect()
}

#[tokio::test]
async fn an_area_is_changed_lifted_and_closed_again_and_what_it_was_is_kept() {
    let mut db = migrated().await;
    let db = &mut db;
    let id = create("farm").run(db).await.unwrap();
    create("rock").run(db).await.unwrap();
    let change = |revision, name: &str, closed, us| Change {
        id,
        revision,
        area: area(name),
        closed,
        by: "anna".to_owned(),
        now: UtcTime::from_micros(us),
    };
    change(1, "fish farm", true, 2).run(db).await.unwrap();
    let late = change(1, "late", true, 2).run(db).await.unwrap_err();
    assert!(matches!(&late, Fault::Refused(text) if text.contains("meanwhile")), "{late}");
    change(2, "fish farm", false, 3).run(db).await.unwrap();
    assert_eq!(names(Closed.run(db).await.unwrap()), ["rock"]);
    let lifted = Lifted.run(db).await.unwrap();
    assert_eq!((lifted[0].changed.1, lifted[0].lifted.1, lifted[0].revision), (Some(2), Some(3), 3));
    change(3, "fish farm", true, 4).run(db).await.unwrap();
    assert!(Lifted.run(db).await.unwrap().is_empty());
    let row = One(id).run(db).await.unwrap().unwrap();
    assert_eq!((row.lifted, row.changed), ((None, None), (Some("anna".to_owned()), Some(4))));
    let sql = "SELECT by, written_us FROM no_go_area_before WHERE area = ?1 ORDER BY revision";
    let before: Vec<(String, i64)> = sqlx::query_as(sql).bind(id).fetch_all(&mut *db).await.unwrap();
    let word = |by: &str, us| (by.to_owned(), us);
    assert_eq!(before, [word("nils", 1), word("anna", 2), word("anna", 3)]);
}

#[tokio::test]
async fn so_many_are_closed_at_a_time_and_no_more() {
    let mut db = migrated().await;
    let db = &mut db;
    let mut last = 0;
    for _ in 0..CLOSED {
        last = create("one").run(db).await.unwrap();
    }
    let refused =
        |fault: &Fault| matches!(fault, Fault::Refused(text) if text.contains("200 areas are closed"));
    assert!(refused(&create("more").run(db).await.unwrap_err()));
    let change = |id, revision, closed| Change {
        id,
        revision,
        area: area("one"),
        closed,
        by: "anna".to_owned(),
        now: UtcTime::from_micros(2),
    };
    change(last, 1, false).run(db).await.unwrap();
    create("in its place").run(db).await.unwrap();
    assert!(refused(&change(last, 2, true).run(db).await.unwrap_err()));
    // Closed areas can still be changed.
    change(1, 1, true).run(db).await.unwrap();
}
