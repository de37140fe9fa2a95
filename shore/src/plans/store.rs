//! Plans in app.db. A change names the revision that it was made from and is refused when there is a newer one, so
//! that nobody's work is lost without a word.

use super::files::free;
use crate::identity::Fault;
use api::{PlanDocument, PlanRevision};
use rusqlite::{Connection, OptionalExtension as _, params};
use units::UtcTime;

/// Plans that are kept, without those that were deleted.
const PLANS: u32 = 2_000;
/// Deleted plans that can be restored.
const DELETED: u32 = 200;
/// Revisions that are kept of a plan.
const REVISIONS: u32 = 200;

/// A plan as it is kept.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    pub id: i64,
    pub revision: u32,
    pub draft: bool,
    pub author: String,
    pub updated: UtcTime,
    pub plan: PlanDocument,
    /// Whether it was deleted, and can be restored.
    pub deleted: bool,
}

/// Who changes something, when.
#[derive(Debug, Clone, Copy)]
pub struct Change<'a> {
    pub author: &'a str,
    pub now: UtcTime,
    pub draft: bool,
}

const COLUMNS: &str = "SELECT plan.id, r.revision, r.draft, r.author, r.saved_us, r.body, plan.name, plan.vessel, \
                       plan.deleted_us FROM plan JOIN plan_revision r ON r.plan = plan.id";

fn row(row: &rusqlite::Row<'_>) -> rusqlite::Result<Row> {
    let body: String = row.get(5)?;
    let wrong = |error: serde_json::Error| {
        rusqlite::Error::FromSqlConversionFailure(5, rusqlite::types::Type::Text, error.into())
    };
    let plan: PlanDocument = serde_json::from_str(&body).map_err(wrong)?;
    Ok(Row {
        id: row.get(0)?,
        revision: row.get(1)?,
        draft: row.get(2)?,
        author: row.get(3)?,
        updated: UtcTime::from_micros(row.get(4)?),
        plan,
        deleted: row.get::<_, Option<i64>>(8)?.is_some(),
    })
}

/// All plans that are not deleted, by name.
pub fn list(db: &Connection) -> Result<Vec<Row>, Fault> {
    let sql =
        format!("{COLUMNS} AND r.revision = plan.revision WHERE plan.deleted_us IS NULL ORDER BY plan.name");
    let mut query = db.prepare_cached(&sql)?;
    let rows = query.query_map([], row)?;
    Ok(rows.collect::<Result<_, _>>()?)
}

/// A plan, deleted or not: its latest revision, or an older one.
pub fn load(db: &Connection, id: i64, revision: Option<u32>) -> Result<Option<Row>, Fault> {
    let sql = format!("{COLUMNS} WHERE plan.id = ?1 AND r.revision = coalesce(?2, plan.revision)");
    Ok(db.prepare_cached(&sql)?.query_row(params![id, revision], row).optional()?)
}

/// The states that a plan had, the newest first.
pub fn revisions(db: &Connection, id: i64) -> Result<Vec<PlanRevision>, Fault> {
    let sql =
        "SELECT revision, author, saved_us, draft FROM plan_revision WHERE plan = ?1 ORDER BY revision DESC";
    let mut query = db.prepare_cached(sql)?;
    let rows = query.query_map([id], |row| {
        Ok(PlanRevision {
            revision: row.get(0)?,
            author: row.get(1)?,
            saved_us: row.get(2)?,
            draft: row.get(3)?,
        })
    })?;
    Ok(rows.collect::<Result<_, _>>()?)
}

/// Keeps a new plan, under a name that is free.
///
/// # Errors
/// There are too many.
pub fn create(db: &Connection, mut plan: PlanDocument, change: Change<'_>) -> Result<i64, Fault> {
    let count: u32 =
        db.query_row("SELECT count(*) FROM plan WHERE deleted_us IS NULL", [], |row| row.get(0))?;
    if count >= PLANS {
        return Err(Fault::Refused(format!(
            "There are {count} plans, the most that are kept: delete some first."
        )));
    }
    plan.name = free_name(db, &plan.name)?;
    db.execute(
        "INSERT INTO plan (name, vessel, revision) VALUES (?1, ?2, 1)",
        params![plan.name, plan.vessel],
    )?;
    let id = db.last_insert_rowid();
    insert(db, id, 1, &plan, change)?;
    Ok(id)
}

/// Keeps a change that was made from revision `from`. A draft takes the place of the same person's draft before it.
///
/// # Errors
/// There is another revision, the plan is gone, or its name is taken.
pub fn save(
    db: &Connection,
    id: i64,
    from: u32,
    plan: &PlanDocument,
    change: Change<'_>,
) -> Result<(), Fault> {
    let Some(old) = load(db, id, None)?.filter(|old| !old.deleted) else {
        return Err(Fault::Refused(
            "The plan was deleted. Restore it, or keep yours as a new plan.".to_owned(),
        ));
    };
    if old.revision != from {
        let text = format!(
            "{} changed the plan meanwhile: it is at revision {}, yours began at {from}.",
            old.author, old.revision
        );
        return Err(Fault::Refused(text));
    }
    if name_of_other(db, &plan.name, id)? {
        return Err(Fault::Refused(format!("Another plan is called {}; choose another name.", plan.name)));
    }
    let revision = from + 1;
    let sql = "UPDATE plan SET name = ?2, vessel = ?3, revision = ?4 WHERE id = ?1";
    db.execute(sql, params![id, plan.name, plan.vessel, revision])?;
    if change.draft && old.draft && old.author == change.author {
        db.execute("DELETE FROM plan_revision WHERE plan = ?1 AND revision = ?2", params![id, from])?;
    }
    insert(db, id, revision, plan, change)?;
    let sql = "DELETE FROM plan_revision WHERE plan = ?1 AND revision NOT IN
               (SELECT revision FROM plan_revision WHERE plan = ?1 ORDER BY revision DESC LIMIT ?2)";
    db.execute(sql, params![id, REVISIONS])?;
    Ok(())
}

/// Puts a plan away. The oldest of too many that were deleted are forgotten.
///
/// # Errors
/// There is none such.
pub fn delete(db: &Connection, id: i64, now: UtcTime) -> Result<(), Fault> {
    let sql = "UPDATE plan SET deleted_us = ?2 WHERE id = ?1 AND deleted_us IS NULL";
    if db.execute(sql, params![id, now.micros()])? == 0 {
        return Err(Fault::Refused("There is no such plan any more.".to_owned()));
    }
    let sql = "DELETE FROM plan WHERE deleted_us IS NOT NULL AND id NOT IN
               (SELECT id FROM plan WHERE deleted_us IS NOT NULL ORDER BY deleted_us DESC LIMIT ?1)";
    db.execute(sql, [DELETED])?;
    Ok(())
}

/// Takes a deletion back; the plan gets another name when its own was taken meanwhile.
///
/// # Errors
/// It was not deleted.
pub fn restore(db: &Connection, id: i64, change: Change<'_>) -> Result<(), Fault> {
    let Some(old) = load(db, id, None)?.filter(|old| old.deleted) else {
        return Err(Fault::Refused("The plan is not among the deleted ones.".to_owned()));
    };
    let name = free_name(db, &old.plan.name)?;
    db.execute("UPDATE plan SET deleted_us = NULL, name = ?2 WHERE id = ?1", params![id, name])?;
    if name == old.plan.name {
        return Ok(());
    }
    let change = Change { draft: old.draft, ..change };
    save(db, id, old.revision, &PlanDocument { name, ..old.plan }, change)
}

fn insert(
    db: &Connection,
    id: i64,
    revision: u32,
    plan: &PlanDocument,
    change: Change<'_>,
) -> Result<(), Fault> {
    let body = serde_json::to_string(plan).map_err(|error| Fault::Refused(error.to_string()))?;
    db.prepare_cached("INSERT INTO plan_revision VALUES (?1, ?2, ?3, ?4, ?5, ?6)")?.execute(params![
        id,
        revision,
        change.author,
        change.now.micros(),
        change.draft,
        body
    ])?;
    Ok(())
}

fn name_of_other(db: &Connection, name: &str, id: i64) -> Result<bool, Fault> {
    let sql = "SELECT count(*) FROM plan WHERE name = ?1 AND id != ?2 AND deleted_us IS NULL";
    let count: i64 = db.prepare_cached(sql)?.query_row(params![name, id], |row| row.get(0))?;
    Ok(count > 0)
}

fn free_name(db: &Connection, wanted: &str) -> Result<String, Fault> {
    let sql = "SELECT name FROM plan WHERE deleted_us IS NULL";
    let mut query = db.prepare_cached(sql)?;
    let names = query.query_map([], |row| row.get::<_, String>(0))?;
    // SQLite's NOCASE folds ASCII alone.
    let taken: std::collections::BTreeSet<String> =
        names.map(|name| name.map(|name| name.to_ascii_lowercase())).collect::<Result<_, _>>()?;
    Ok(free(wanted, |name| taken.contains(&name.to_ascii_lowercase())))
}
