//! Datasets and links in app.db.

use super::links::{Add, By, Of, Revoke, Visit, Visits};
use super::rows::{Create, Listed, Publish, SetDraft, Withdraw};
use crate::identity::{Fault, Request, Secret, migrated, within_transaction};
use api::{
    DatasetContent, DatasetDraft, DatasetQuery, DatasetShare, DatasetVersion, LogWord, ShareVisit,
    ShareVisitKind,
};
use sqlx::SqliteConnection;
use units::UtcTime;

const NOW: UtcTime = UtcTime::from_micros(5);

async fn done<R: Request>(db: &mut SqliteConnection, request: R) -> R::Answer {
    within_transaction(db, request).await.unwrap()
}

fn draft(title: &str) -> DatasetDraft {
    DatasetDraft { title: title.to_owned(), ..DatasetDraft::default() }
}

fn version(number: u32) -> DatasetVersion {
    DatasetVersion {
        number,
        title: "Salmon".to_owned(),
        description: String::new(),
        publisher: String::new(),
        authors: Vec::new(),
        licence: String::new(),
        embargo_until: String::new(),
        doi: String::new(),
        query: DatasetQuery::default(),
        vessels: Vec::new(),
        content: DatasetContent { rows: 3, ..DatasetContent::default() },
        published: LogWord { by: "kari".to_owned(), time_us: 5 },
        citation: String::new(),
    }
}

fn share() -> DatasetShare {
    DatasetShare {
        person: None,
        id: 0,
        version: 1,
        label: "Ola".to_owned(),
        has_password: false,
        expires_us: 9,
        from_us: None,
        to_us: None,
        tags: vec!["S256-101".to_owned()],
        area: String::new(),
        precision_m: Some(100),
        content: DatasetContent::default(),
        had_changed: false,
        made: LogWord { by: "kari".to_owned(), time_us: 5 },
        revoked: None,
        views: 0,
        downloads: 0,
        used_us: None,
    }
}

/// Makes a dataset with one version; returns its number.
async fn published(db: &mut SqliteConnection) -> i64 {
    let id = done(db, Create { draft: draft("Salmon"), by: "kari".to_owned(), now: NOW }).await;
    done(db, Publish { id, revision: 1, version: version(1) }).await;
    id
}

#[tokio::test]
async fn a_dataset_changes_only_from_the_revision_that_was_looked_at() {
    let mut db = migrated().await;
    let db = &mut db;
    let id = published(db).await;
    let late = SetDraft { id, revision: 1, draft: draft("late") };
    assert!(matches!(within_transaction(db, late).await, Err(Fault::Refused(_))));
    done(db, SetDraft { id, revision: 2, draft: draft("next") }).await;
    let twice = Publish { id, revision: 3, version: version(1) };
    assert!(within_transaction(db, twice).await.is_err(), "a version is written once");
    let row = done(db, Listed(Some(id))).await.remove(0);
    assert_eq!((row.revision, row.draft.unwrap().title), (3, "next".to_owned()), "all of it or nothing");
    assert_eq!(row.versions, [version(1)]);
    done(db, Publish { id, revision: 3, version: version(2) }).await;
    let withdraw =
        |revision| Withdraw { id, revision, by: "kari".to_owned(), reason: "r".to_owned(), now: NOW };
    done(db, withdraw(4)).await;
    assert!(within_transaction(db, withdraw(5)).await.is_err(), "once");
    let other = published(db).await;
    let all = done(db, Listed(None)).await;
    assert_eq!(all.iter().map(|row| row.id).collect::<Vec<_>>(), [other, id]);
    assert_eq!(all[1].versions.iter().map(|version| version.number).collect::<Vec<_>>(), [2, 1]);
    assert_eq!(all[1].withdrawn, Some(("kari".to_owned(), 5, "r".to_owned())));
}

#[tokio::test]
async fn a_link_is_found_by_the_hash_of_its_secret_and_counts_its_uses() {
    let mut db = migrated().await;
    let db = &mut db;
    let (id, other) = (published(db).await, published(db).await);
    let secret = Secret::random();
    let add = Add {
        dataset: id,
        hash: secret.hash(),
        password: Some("phc".to_owned()),
        person: None,
        share: share(),
    };
    let number = done(db, add).await;
    let led = done(db, By::Secret(secret.hash())).await.unwrap();
    assert_eq!((led.dataset.id, led.password.as_deref(), led.share.has_password), (id, Some("phc"), true));
    assert_eq!((&led.share.tags, led.share.precision_m, led.share.id), (&share().tags, Some(100), number));
    assert!(done(db, By::Secret(Secret::random().hash())).await.is_none());
    for (time_us, what) in
        [(6, ShareVisitKind::View), (7, ShareVisitKind::Download), (8, ShareVisitKind::WrongPassword)]
    {
        let visit = ShareVisit { time_us, address: "::1".to_owned(), what, file: String::new() };
        done(db, Visit { share: number, visit }).await;
    }
    let listed = done(db, Of(id)).await.remove(0);
    assert_eq!((listed.views, listed.downloads, listed.used_us), (1, 1, Some(7)), "a guess is no use");
    let visits = done(db, Visits { dataset: id, share: number }).await;
    assert_eq!(visits.iter().map(|visit| visit.time_us).collect::<Vec<_>>(), [8, 7, 6]);
    assert_eq!(done(db, Visits { dataset: other, share: number }).await, [], "of its own dataset alone");
    let revoke = |dataset| Revoke { dataset, share: number, by: "kari".to_owned(), now: NOW };
    assert!(within_transaction(db, revoke(other)).await.is_err());
    done(db, revoke(id)).await;
    assert!(within_transaction(db, revoke(id)).await.is_err());
    assert!(done(db, By::Secret(secret.hash())).await.unwrap().share.revoked.is_some());
}

#[tokio::test]
async fn of_the_uses_of_a_link_the_newest_are_kept() {
    let mut db = migrated().await;
    let id = published(&mut db).await;
    let add =
        Add { dataset: id, hash: Secret::random().hash(), password: None, person: None, share: share() };
    let number = done(&mut db, add).await;
    // One more than there may be, written at once.
    let sql = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 10000)
               INSERT INTO dataset_visit (share, time_us, address, what, file) SELECT ?1, i, '::1', 'view', '' FROM n";
    sqlx::query(sql).bind(number).execute(&mut db).await.unwrap();
    sqlx::query("INSERT INTO dataset_visit (share, time_us, address, what, file) VALUES (?1, 0, '::1', 'download', 'x')")
        .bind(number)
        .execute(&mut db)
        .await
        .unwrap();
    let visit = ShareVisit {
        time_us: 20_000,
        address: "::1".to_owned(),
        what: ShareVisitKind::View,
        file: String::new(),
    };
    done(&mut db, Visit { share: number, visit }).await;
    let of = "SELECT count(*), min(time_us) FROM dataset_visit WHERE what = 'view'";
    let (count, first): (i64, i64) = sqlx::query_as(of).fetch_one(&mut db).await.unwrap();
    assert_eq!((count, first), (10_000, 2));
    let of = "SELECT count(*) FROM dataset_visit WHERE what = 'download'";
    let downloads: i64 = sqlx::query_scalar(of).fetch_one(&mut db).await.unwrap();
    assert_eq!(downloads, 1, "views forget no download");
}

#[tokio::test]
async fn a_published_version_cannot_be_changed_in_the_database() {
    let mut db = migrated().await;
    let id = published(&mut db).await;
    for sql in ["UPDATE dataset_version SET body = '{}'", "DELETE FROM dataset_version"] {
        let error = sqlx::query(sql).execute(&mut db).await.unwrap_err();
        assert!(error.to_string().contains("a published version of a dataset"), "{error}");
    }
    assert_eq!(done(&mut db, Listed(Some(id))).await.remove(0).versions, [version(1)]);
}

#[tokio::test]
async fn links_that_are_revoked_or_have_ended_make_room_for_others() {
    let mut db = migrated().await;
    let db = &mut db;
    let id = published(db).await;
    let add = |time_us, expires_us| {
        let made = LogWord { by: "kari".to_owned(), time_us };
        Add {
            dataset: id,
            hash: Secret::random().hash(),
            password: None,
            person: None,
            share: DatasetShare { made, expires_us, ..share() },
        }
    };
    let first = done(db, add(5, 9)).await;
    for _ in 1..200 {
        done(db, add(5, 9)).await;
    }
    assert!(matches!(within_transaction(db, add(5, 9)).await, Err(Fault::Refused(_))));
    done(db, Revoke { dataset: id, share: first, by: "kari".to_owned(), now: NOW }).await;
    done(db, add(5, 9)).await;
    assert!(within_transaction(db, add(5, 9)).await.is_err());
    done(db, add(9, 20)).await;
}

#[tokio::test]
async fn of_links_that_do_not_open_any_more_the_newest_thousand_are_kept() {
    let mut db = migrated().await;
    let db = &mut db;
    let (id, other) = (published(db).await, published(db).await);
    let add = |dataset, expires_us| {
        let secret = Secret::random();
        let share = DatasetShare { expires_us, ..share() };
        (secret.hash(), Add { dataset, hash: secret.hash(), password: None, person: None, share })
    };
    // One that opens, one that ended before it is made, one of another dataset, and a use of the one that ended.
    let (open, first) = add(id, i64::MAX);
    done(db, first).await;
    let (ended, second) = add(id, 5);
    let number = done(db, second).await;
    let visit =
        ShareVisit { time_us: 4, address: "::1".to_owned(), what: ShareVisitKind::View, file: String::new() };
    done(db, Visit { share: number, visit }).await;
    let (elsewhere, third) = add(other, 5);
    done(db, third).await;
    let sql = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 999)
               INSERT INTO dataset_share (dataset, hash, expires_us, body, revoked_by, revoked_us)
               SELECT dataset, randomblob(32), expires_us, body, 'kari', 5 FROM dataset_share, n WHERE id = ?1";
    sqlx::query(sql).bind(number).execute(&mut *db).await.unwrap();
    assert_eq!(done(db, Of(id)).await.len(), 1_001, "one opens, a thousand do not");
    let (_, next) = add(id, i64::MAX);
    let share = done(db, next).await;
    done(db, Revoke { dataset: id, share, by: "kari".to_owned(), now: NOW }).await;
    let (_, last) = add(id, i64::MAX);
    done(db, last).await;
    assert!(done(db, By::Secret(ended)).await.is_none(), "the oldest that does not open is gone");
    assert_eq!(done(db, Visits { dataset: id, share: number }).await, []);
    assert!(done(db, By::Secret(open)).await.is_some() && done(db, By::Secret(elsewhere)).await.is_some());
    assert_eq!(done(db, Of(id)).await.len(), 1_002, "two open, a thousand do not");
}

#[tokio::test]
async fn a_link_that_was_open_for_long_is_kept_by_when_it_was_closed() {
    let mut db = migrated().await;
    let db = &mut db;
    let id = published(db).await;
    let add = |expires_us| Add {
        dataset: id,
        hash: Secret::random().hash(),
        password: None,
        person: None,
        share: DatasetShare { expires_us, ..share() },
    };
    let first = done(db, add(i64::MAX)).await;
    let visit = ShareVisit {
        time_us: 8,
        address: "::1".to_owned(),
        what: ShareVisitKind::Download,
        file: "x".to_owned(),
    };
    done(db, Visit { share: first, visit: visit.clone() }).await;
    // A thousand that were made later, and ended before it was revoked.
    let sql = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 1000)
               INSERT INTO dataset_share (dataset, hash, expires_us, body)
               SELECT dataset, randomblob(32), 4, body FROM dataset_share, n WHERE id = ?1";
    sqlx::query(sql).bind(first).execute(&mut *db).await.unwrap();
    let now = UtcTime::from_micros(9);
    done(db, Revoke { dataset: id, share: first, by: "kari".to_owned(), now }).await;
    done(db, add(i64::MAX)).await;
    assert_eq!(done(db, Visits { dataset: id, share: first }).await, [visit], "who loaded it can be seen");
    assert_eq!(done(db, Of(id)).await.len(), 1_001, "one opens, a thousand do not");
}
