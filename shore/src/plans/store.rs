//! Plans in app.db. A change names the revision that it was made from and is refused when there is a newer one, so that no
//! person's work is silently overwritten.

use super::files::free;
use crate::identity::{Fault, Request};
use api::{PlanDocument, PlanRevision, Said, say};
use sqlx::SqliteConnection;
use units::UtcTime;

/// Most plans, without deleted ones.
const PLANS: u32 = 2_000;
/// Most deleted plans that can be restored.
const DELETED: u32 = 200;
/// Most revisions that are kept of a plan.
const REVISIONS: u32 = 200;

/// A stored plan.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Its number.
    pub id: i64,
    /// Grows with each change.
    pub revision: u32,
    /// Whether it is a draft, which may have problems and cannot be uploaded.
    pub draft: bool,
    /// Who saved this revision.
    pub author: String,
    /// Time of the last change.
    pub updated: UtcTime,
    /// The plan.
    pub plan: PlanDocument,
    /// Whether it is deleted, and can be restored.
    pub deleted: bool,
}

/// Author and time of a change.
#[derive(Debug, Clone)]
pub struct Change {
    /// The person who writes it.
    pub author: String,
    /// Time of the request.
    pub now: UtcTime,
    /// Whether it is saved as a draft.
    pub draft: bool,
}

/// A query for rows as [`row`] reads them.
macro_rules! columns {
    ($rest:literal) => {
        concat!(
            "SELECT plan.id, r.revision, r.draft, r.author, r.saved_us, r.body, plan.deleted_us FROM plan \
             JOIN plan_revision r ON r.plan = plan.id ",
            $rest
        )
    };
}
/// All plans that are not deleted, by name.
#[derive(Debug)]
pub struct List;

impl Request for List {
    type Answer = Vec<Row>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Vec<Row>, Fault> {
        let sql = columns!("AND r.revision = plan.revision WHERE plan.deleted_us IS NULL ORDER BY plan.name");
        let rows: Vec<Columns> = sqlx::query_as(sql).fetch_all(db).await?;
        rows.into_iter().map(row).collect()
    }
}

/// A plan, deleted or not: its latest revision, or an older one.
#[derive(Debug)]
pub struct Load {
    /// Its number.
    pub id: i64,
    /// The revision; `None`: the latest.
    pub revision: Option<u32>,
}

impl Request for Load {
    type Answer = Option<Row>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Option<Row>, Fault> {
        let sql = columns!("WHERE plan.id = ?1 AND r.revision = coalesce(?2, plan.revision)");
        let found = sqlx::query_as(sql).bind(self.id).bind(self.revision).fetch_optional(db).await?;
        found.map(row).transpose()
    }
}

/// Revisions of the plan of this number, the newest first.
#[derive(Debug)]
pub struct Revisions(pub i64);

impl Request for Revisions {
    type Answer = Vec<PlanRevision>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Vec<PlanRevision>, Fault> {
        let sql = "SELECT revision, author, saved_us, draft FROM plan_revision WHERE plan = ?1 ORDER BY revision DESC";
        let rows = sqlx::query_as(sql).bind(self.0).fetch_all(db).await?;
        let revision =
            |(revision, author, saved_us, draft)| PlanRevision { revision, author, saved_us, draft };
        Ok(rows.into_iter().map(revision).collect())
    }
}

/// Stores a new plan under a free name; returns its number.
#[derive(Debug)]
pub struct Create {
    /// The plan.
    pub plan: PlanDocument,
    /// Author and time.
    pub change: Change,
}

impl Request for Create {
    type Answer = i64;

    async fn run(self, db: &mut SqliteConnection) -> Result<i64, Fault> {
        create(db, self.plan, &self.change).await
    }
}

/// Saves a change that was made from revision `from`.
#[derive(Debug)]
pub struct Save {
    /// Its number.
    pub id: i64,
    /// The revision that the change was made from.
    pub from: u32,
    /// The plan as it is now.
    pub plan: PlanDocument,
    /// Author and time.
    pub change: Change,
}

impl Request for Save {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        save(db, self.id, self.from, &self.plan, &self.change).await
    }
}

/// Deletes a plan.
#[derive(Debug)]
pub struct Delete {
    /// Its number.
    pub id: i64,
    /// Time of the request.
    pub now: UtcTime,
}

impl Request for Delete {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        delete(db, self.id, self.now).await
    }
}

/// Restores a deleted plan.
#[derive(Debug)]
pub struct Restore {
    /// Its number.
    pub id: i64,
    /// Author and time.
    pub change: Change,
}

impl Request for Restore {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        restore(db, self.id, self.change).await
    }
}

type Columns = (i64, u32, bool, String, i64, String, Option<i64>);

fn row((id, revision, draft, author, saved_us, body, deleted_us): Columns) -> Result<Row, Fault> {
    let plan = serde_json::from_str(&body).map_err(|error| sqlx::Error::Decode(error.into()))?;
    let (updated, deleted) = (UtcTime::from_micros(saved_us), deleted_us.is_some());
    Ok(Row { id, revision, draft, author, updated, plan, deleted })
}

/// Stores a new plan under a free name.
///
/// # Errors
/// There are too many.
async fn create(db: &mut SqliteConnection, mut plan: PlanDocument, change: &Change) -> Result<i64, Fault> {
    let sql = "SELECT count(*) FROM plan WHERE deleted_us IS NULL";
    let count: u32 = sqlx::query_scalar(sql).fetch_one(&mut *db).await?;
    if count >= PLANS {
        return Err(Fault::refused(
            say("There are {n} plans, the most that are kept: delete some first.").with("n", count),
        ));
    }
    plan.name = free_name(db, &plan.name).await?;
    let sql = "INSERT INTO plan (name, vessel, revision) VALUES (?1, ?2, 1)";
    let query = sqlx::query(sql).bind(&plan.name).bind(plan.vessel);
    let id = query.execute(&mut *db).await?.last_insert_rowid();
    insert(db, id, 1, &plan, change).await?;
    Ok(id)
}

/// Saves a change that was made from revision `from`. A draft replaces the same person's previous draft.
///
/// # Errors
/// There is a newer revision, the plan is gone, or its name is taken.
async fn save(
    db: &mut SqliteConnection,
    id: i64,
    from: u32,
    plan: &PlanDocument,
    change: &Change,
) -> Result<(), Fault> {
    let Some(old) = Load { id, revision: None }.run(db).await?.filter(|old| !old.deleted) else {
        return Err(Fault::refused(say("The plan was deleted. Restore it, or keep yours as a new plan.")));
    };
    if old.revision != from {
        let text = say("{name} changed the plan meanwhile: it is at revision {now}, yours began at {from}.");
        let text = text.with("name", old.author).with("now", old.revision).with("from", from);
        return Err(Fault::refused(text));
    }
    if name_of_other(db, &plan.name, id).await? {
        return Err(Fault::refused(
            say("Another plan is called {name}; choose another name.").with("name", &plan.name),
        ));
    }
    let revision = from + 1;
    let sql = "UPDATE plan SET name = ?2, vessel = ?3, revision = ?4 WHERE id = ?1";
    let query = sqlx::query(sql).bind(id).bind(&plan.name).bind(plan.vessel).bind(revision);
    query.execute(&mut *db).await?;
    if change.draft && old.draft && old.author == change.author {
        let sql = "DELETE FROM plan_revision WHERE plan = ?1 AND revision = ?2";
        sqlx::query(sql).bind(id).bind(from).execute(&mut *db).await?;
    }
    insert(db, id, revision, plan, change).await?;
    let sql = "DELETE FROM plan_revision WHERE plan = ?1 AND revision NOT IN
               (SELECT revision FROM plan_revision WHERE plan = ?1 ORDER BY revision DESC LIMIT ?2)";
    sqlx::query(sql).bind(id).bind(REVISIONS).execute(db).await?;
    Ok(())
}

/// Deletes a plan. Beyond the limit the oldest deleted plans are removed for good.
///
/// # Errors
/// There is no such plan.
async fn delete(db: &mut SqliteConnection, id: i64, now: UtcTime) -> Result<(), Fault> {
    let sql = "UPDATE plan SET deleted_us = ?2 WHERE id = ?1 AND deleted_us IS NULL";
    if sqlx::query(sql).bind(id).bind(now.micros()).execute(&mut *db).await?.rows_affected() == 0 {
        return Err(Fault::refused(say("There is no such plan any more.")));
    }
    let sql = "DELETE FROM plan WHERE deleted_us IS NOT NULL AND id NOT IN
               (SELECT id FROM plan WHERE deleted_us IS NOT NULL ORDER BY deleted_us DESC LIMIT ?1)";
    sqlx::query(sql).bind(DELETED).execute(db).await?;
    Ok(())
}

/// Restores a deleted plan; it gets another name if its own was taken meanwhile.
///
/// # Errors
/// It was not deleted.
async fn restore(db: &mut SqliteConnection, id: i64, change: Change) -> Result<(), Fault> {
    let Some(old) = Load { id, revision: None }.run(db).await?.filter(|old| old.deleted) else {
        return Err(Fault::refused(say("The plan is not among the deleted ones.")));
    };
    let name = free_name(db, &old.plan.name).await?;
    let sql = "UPDATE plan SET deleted_us = NULL, name = ?2 WHERE id = ?1";
    sqlx::query(sql).bind(id).bind(&name).execute(&mut *db).await?;
    if name == old.plan.name {
        return Ok(());
    }
    let change = Change { draft: old.draft, ..change };
    save(db, id, old.revision, &PlanDocument { name, ..old.plan }, &change).await
}

async fn insert(
    db: &mut SqliteConnection,
    id: i64,
    revision: u32,
    plan: &PlanDocument,
    change: &Change,
) -> Result<(), Fault> {
    let body = serde_json::to_string(plan).map_err(|error| Fault::refused(Said::as_is(error.to_string())))?;
    let query = sqlx::query("INSERT INTO plan_revision VALUES (?1, ?2, ?3, ?4, ?5, ?6)");
    let query = query.bind(id).bind(revision).bind(&change.author).bind(change.now.micros());
    query.bind(change.draft).bind(body).execute(db).await?;
    Ok(())
}

async fn name_of_other(db: &mut SqliteConnection, name: &str, id: i64) -> Result<bool, Fault> {
    let sql = "SELECT count(*) FROM plan WHERE name = ?1 AND id != ?2 AND deleted_us IS NULL";
    let count: i64 = sqlx::query_scalar(sql).bind(name).bind(id).fetch_one(db).await?;
    Ok(count > 0)
}

async fn free_name(db: &mut SqliteConnection, wanted: &str) -> Result<String, Fault> {
    let sql = "SELECT name FROM plan WHERE deleted_us IS NULL";
    let names: Vec<String> = sqlx::query_scalar(sql).fetch_all(db).await?;
    // SQLite's NOCASE folds ASCII alone.
    let taken: std::collections::BTreeSet<String> =
        names.into_iter().map(|name| name.to_ascii_lowercase()).collect();
    Ok(free(wanted, |name| taken.contains(&name.to_ascii_lowercase())))
}
