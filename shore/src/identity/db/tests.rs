use super::super::request::Request as _;
use super::super::{audit, persons, sessions, tokens, vessels};
use super::*;
use units::UtcTime;

/// A fresh database in memory.
pub(crate) async fn fresh() -> SqliteConnection {
    let options = SqliteConnectOptions::new().in_memory(true).foreign_keys(true);
    let mut db = options.connect().await.unwrap();
    migrate(&mut db).await.unwrap();
    db
}

/// The migrations from the time when only `user_version` counted them.
const BY_NUMBER: [&str; 4] = [
    include_str!("../../../../migrations/0001_people.sql"),
    include_str!("../../../../migrations/0002_plans.sql"),
    include_str!("../../../../migrations/0003_alarms.sql"),
    include_str!("../../../../migrations/0004_register.sql"),
];

/// The numbers of all migrations; some numbers were never used.
fn all() -> Vec<i64> {
    MIGRATIONS.iter().map(|one| one.version).collect()
}

/// The newest.
fn latest() -> i64 {
    all().into_iter().max().unwrap()
}

/// A row in every table of the second migration.
const FILLED: &str = "
    INSERT INTO person VALUES (7, 'nils', 'hash', 0, 5);
    INSERT INTO permission VALUES (7, -1, 4), (7, 2068, 3);
    INSERT INTO session VALUES (3, zeroblob(32), 7, 5, 6, '::1', 'a browser');
    INSERT INTO device VALUES (zeroblob(32), 7, 6);
    INSERT INTO vessel VALUES (2068, 'otter', 5);
    INSERT INTO token VALUES (9, zeroblob(32), 'link', NULL, 2068, NULL, 5, NULL, 6);
    INSERT INTO audit VALUES (41, 5, 'nils', '::1', 'login', 'nils', 'done');
    INSERT INTO plan VALUES (11, 'north', 2068, 2, NULL);
    INSERT INTO plan_revision VALUES (11, 2, 'nils', 5, 0, '{}');";

/// Makes app.db like programs without checksums: by rusqlite, with the number of migrations as its version.
fn made_by_number(folder: &Path, seen: usize) {
    let mut old = rusqlite::Connection::open(folder.join("app.db")).unwrap();
    old.pragma_update(None, "journal_mode", "WAL").unwrap();
    old.pragma_update(None, "synchronous", "FULL").unwrap();
    old.pragma_update(None, "foreign_keys", true).unwrap();
    let transaction = old.transaction().unwrap();
    for migration in &BY_NUMBER[..seen] {
        transaction.execute_batch(migration).unwrap();
    }
    transaction.pragma_update(None, "user_version", seen as u32).unwrap();
    transaction.commit().unwrap();
    old.execute_batch(FILLED).unwrap();
}

async fn noted(db: &mut SqliteConnection) -> Vec<(i64, bool)> {
    let sql = "SELECT version, length(checksum) = 48 FROM _sqlx_migrations ORDER BY version";
    sqlx::query_as(sql).fetch_all(db).await.unwrap()
}

async fn version(db: &mut SqliteConnection) -> i64 {
    sqlx::query_scalar("PRAGMA user_version").fetch_one(db).await.unwrap()
}

#[tokio::test]
async fn a_file_of_programs_without_checksums_is_taken_over_with_all_that_is_in_it() {
    for seen in 2..=4 {
        let folder = tempfile::tempdir().unwrap();
        made_by_number(folder.path(), seen);
        for _ in 0..2 {
            let mut db = open(folder.path()).await.unwrap();
            let all: Vec<(i64, bool)> = all().into_iter().map(|number| (number, true)).collect();
            assert_eq!((noted(&mut db).await, version(&mut db).await), (all, latest()), "{seen}");
            let people = persons::List.run(&mut db).await.unwrap();
            assert_eq!((people[0].name.as_str(), people[0].permissions.len()), ("nils", 2));
            assert_eq!(vessels::List.run(&mut db).await.unwrap()[0].name, "otter");
            assert_eq!(tokens::List(None).run(&mut db).await.unwrap()[0].id, 9);
            assert_eq!(sessions::List(Some(7)).run(&mut db).await.unwrap()[0].agent, "a browser");
            let entries = audit::Entries { count: 9, ..Default::default() }.run(&mut db).await.unwrap();
            assert_eq!((entries.len(), entries[0].id), (1, 41));
            let sql = "SELECT count(*) FROM plan JOIN plan_revision ON plan.id = plan JOIN device";
            let rows: i64 = sqlx::query_scalar(sql).fetch_one(&mut db).await.unwrap();
            assert_eq!(rows, 1);
        }
    }
}

#[tokio::test]
async fn a_file_that_cannot_be_taken_over_stays_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    made_by_number(folder.path(), 2);
    // The third migration makes a table of this name.
    let old = rusqlite::Connection::open(folder.path().join("app.db")).unwrap();
    old.execute_batch("CREATE TABLE alarm (mine TEXT)").unwrap();
    let told = open(folder.path()).await.unwrap_err().to_string();
    assert!(
        told.contains("app.db cannot be brought up to date") && told.contains("Nothing was changed"),
        "{told}"
    );
    let sql = "SELECT count(*) FROM sqlite_schema WHERE name IN ('_sqlx_migrations', 'register')";
    assert_eq!(old.query_row(sql, [], |row| row.get::<_, i64>(0)).unwrap(), 0);
    let version: i64 = old.pragma_query_value(None, "user_version", |row| row.get(0)).unwrap();
    assert_eq!(version, 2);
}

#[tokio::test]
async fn migrating_twice_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    drop(open(folder.path()).await.unwrap());
    let mut db = open(folder.path()).await.unwrap();
    let sql = "SELECT count(*) FROM sqlite_schema WHERE type = 'table'";
    let tables: i64 = sqlx::query_scalar(sql).fetch_one(&mut db).await.unwrap();
    assert!(tables >= 7);
    assert_eq!(noted(&mut db).await.len(), all().len());
}

#[tokio::test(flavor = "multi_thread")]
async fn programs_that_open_it_at_once_bring_it_up_to_date_once() {
    let folder = tempfile::tempdir().unwrap();
    made_by_number(folder.path(), 2);
    let path = folder.path().to_owned();
    let opened: Vec<_> = (0..8)
        .map(|_| {
            let path = path.clone();
            tokio::spawn(async move { open(&path).await.map(drop) })
        })
        .collect();
    for one in opened {
        one.await.unwrap().unwrap();
    }
    assert_eq!(noted(&mut open(&path).await.unwrap()).await.len(), all().len());
}

#[tokio::test]
async fn a_newer_file_is_refused_with_the_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let mut db = open(folder.path()).await.unwrap();
    sqlx::query("PRAGMA user_version = 99").execute(&mut db).await.unwrap();
    assert!(open(folder.path()).await.unwrap_err().to_string().contains("Install that version again"));
    let latest = latest();
    sqlx::query(AssertSqlSafe(format!("PRAGMA user_version = {latest}"))).execute(&mut db).await.unwrap();
    let sql = "INSERT INTO _sqlx_migrations (version, description, success, checksum, execution_time)
               VALUES (?1, 'later', TRUE, x'00', 1)";
    sqlx::query(sql).bind(latest + 1).execute(&mut db).await.unwrap();
    let told = open(folder.path()).await.unwrap_err().to_string();
    assert!(
        told.contains("app.db") && told.contains(&format!("schema {}, this one knows {latest}", latest + 1)),
        "{told}"
    );
}

#[tokio::test]
async fn a_file_of_other_migrations_is_refused_with_the_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let mut db = open(folder.path()).await.unwrap();
    let sql = "UPDATE _sqlx_migrations SET checksum = x'00' WHERE version = 3";
    sqlx::query(sql).execute(&mut db).await.unwrap();
    let told = open(folder.path()).await.unwrap_err().to_string();
    assert!(told.contains("app.db") && told.contains("put a backup in its place"), "{told}");
}

#[tokio::test]
async fn strangers_on_the_machine_cannot_read_it() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = tempfile::tempdir().unwrap();
    let _db = open(folder.path()).await.unwrap();
    for name in ["app.db", "app.db-wal"] {
        let mode = std::fs::metadata(folder.path().join(name)).unwrap().permissions().mode();
        assert_eq!(mode & 0o077, 0, "{name}");
    }
}

#[tokio::test]
async fn a_copy_is_whole_while_others_write() {
    let (folder, to) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let mut db = open(folder.path()).await.unwrap();
    vessels::Add { address: 7, name: "otter".to_owned(), now: UtcTime::default() }
        .run(&mut db)
        .await
        .unwrap();
    let mut writing = db.begin_with("BEGIN IMMEDIATE").await.unwrap();
    let hidden = vessels::Add { address: 8, name: "not-yet".to_owned(), now: UtcTime::default() };
    hidden.run(&mut writing).await.unwrap();
    backup(folder.path(), &to.path().join("app.db")).await.unwrap();
    writing.rollback().await.unwrap();
    let copied = vessels::List.run(&mut open(to.path()).await.unwrap()).await.unwrap();
    assert_eq!(copied.len(), 1);
}
