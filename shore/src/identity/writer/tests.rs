use super::super::audit::Line;
use super::super::audit::{Entries, Record};
use super::super::{db, vessels};
use super::*;
use std::time::Instant;
use units::UtcTime;

/// The handle of a database, with its temporary folder.
pub(crate) async fn started(owners: &Owners) -> (Db, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let connection = db::open(folder.path()).await.unwrap();
    let db = Db::start(connection, folder.path(), Arc::default(), owners).unwrap();
    (db, folder)
}

fn otter() -> vessels::Add {
    vessels::Add { address: 7, name: "otter".to_owned(), now: UtcTime::default() }
}

/// Does its work, and then fails.
#[derive(Debug)]
struct Fails<R>(R);

impl<R: Request> Request for Fails<R> {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        self.0.run(db).await?;
        Err(Fault::refused(api::Said::as_is("no")))
    }
}

#[tokio::test]
async fn failed_work_leaves_nothing_behind() {
    let (db, _folder) = started(&Owners::new(crate::clock::Clock::real())).await;
    assert!(db.change(Fails(otter())).await.is_err());
    assert!(db.ask(vessels::List).await.unwrap().is_empty());
    db.change(otter()).await.unwrap();
    assert_eq!(db.ask(vessels::List).await.unwrap().len(), 1, "what was answered is seen by who asks next");
}

/// Limits the file to so many pages.
#[derive(Debug)]
struct MostPages(i64);

impl Request for MostPages {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        let pragma = sqlx::AssertSqlSafe(format!("PRAGMA max_page_count = {}", self.0));
        sqlx::query(pragma).execute(db).await?;
        Ok(())
    }
}

/// More lines than fit.
fn many_lines() -> Record {
    let text = || "x".repeat(200);
    let line = |_| Line { actor: text(), address: text(), action: "test", subject: text(), outcome: text() };
    Record((0..500).map(line).map(|line| (UtcTime::default(), line)).collect())
}

#[tokio::test]
async fn after_a_full_disk_it_writes_again_once_there_is_room() {
    let (db, _folder) = started(&Owners::new(crate::clock::Clock::real())).await;
    for _ in 0..3 {
        // Only for this connection, which is the one that is discarded.
        db.change(MostPages(1)).await.unwrap();
        let told = db.change(many_lines()).await.unwrap_err().to_string();
        assert!(told.contains("full"), "{told}");
        assert!(
            db.ask(Entries { count: 10, ..Default::default() }).await.unwrap().is_empty(),
            "all or nothing"
        );
    }
    db.change(otter()).await.unwrap();
    assert_eq!(db.ask(vessels::List).await.unwrap().len(), 1);
}

#[tokio::test]
async fn a_question_changes_nothing() {
    let (db, _folder) = started(&Owners::new(crate::clock::Clock::real())).await;
    let told = db.ask(otter()).await.unwrap_err().to_string();
    assert!(told.contains("readonly"), "{told}");
}

#[tokio::test]
async fn who_asks_waits_for_nobody_who_writes() {
    let (db, folder) = started(&Owners::new(crate::clock::Clock::real())).await;
    // Another program holds the file for writing, so that this one's writer waits.
    let mut other = db::open(folder.path()).await.unwrap();
    let held = other.begin_with("BEGIN IMMEDIATE").await.unwrap();
    let writing = tokio::spawn({
        let db = db.clone();
        async move { db.change(otter()).await }
    });
    tokio::task::yield_now().await;
    for _ in 0..20 {
        let asked = tokio::time::timeout(Duration::from_secs(2), db.ask(vessels::List)).await;
        assert!(asked.unwrap().unwrap().is_empty());
        tokio::time::timeout(Duration::from_secs(2), db.catch_up()).await.unwrap().unwrap();
    }
    assert!(!writing.is_finished());
    held.rollback().await.unwrap();
    writing.await.unwrap().unwrap();
}

#[tokio::test]
async fn a_queue_that_is_full_makes_who_asks_wait_and_loses_nothing() {
    let (db, folder) = started(&Owners::new(crate::clock::Clock::real())).await;
    let mut other = db::open(folder.path()).await.unwrap();
    let held = other.begin_with("BEGIN IMMEDIATE").await.unwrap();
    let all: Vec<_> = (0..WAITING + 50)
        .map(|number| {
            let db = db.clone();
            tokio::spawn(async move { db.change(Record(vec![(UtcTime::default(), line(number))])).await })
        })
        .collect();
    while db.jobs.capacity() > 0 {
        tokio::task::yield_now().await;
    }
    held.rollback().await.unwrap();
    for one in all {
        one.await.unwrap().unwrap();
    }
    let written = db.ask(Entries { count: 1_000, ..Default::default() }).await.unwrap();
    assert_eq!(written.len(), WAITING + 50);
}

#[tokio::test]
async fn the_thread_ends_with_the_last_way_to_it() {
    let owners = Owners::new(crate::clock::Clock::real());
    let (db, folder) = started(&owners).await;
    db.change(otter()).await.unwrap();
    drop(db);
    let end = Instant::now() + Duration::from_secs(10);
    // SQLite removes its log when the last connection is closed.
    while folder.path().join("app.db-wal").exists() {
        assert!(Instant::now() < end);
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    assert!(owners.are_there());
}

fn line(number: usize) -> Line {
    let (actor, address) = ("anna".to_owned(), "::1".to_owned());
    Line { actor, address, action: "stop", subject: number.to_string(), outcome: "done".to_owned() }
}
