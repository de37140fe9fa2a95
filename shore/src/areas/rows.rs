//! No-go areas in app.db.

use crate::identity::{Fault, Request};
use crate::logbook::NEWER;
use api::{NoGoAreaRequest, say};
use sqlx::{QueryBuilder, Sqlite, SqliteConnection};
use units::UtcTime;

/// Areas that there may ever be.
const AREAS: i64 = 100_000;
/// Areas that are closed at a time: vessels hold all of them.
pub(super) const CLOSED: i64 = 200;
/// Changes of one area.
const CHANGES: u32 = 200;
/// Of those that were lifted, so many are listed.
const LIFTED: u32 = 100;

/// An area as it is kept.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Row {
    pub(super) id: i64,
    pub(super) revision: u32,
    /// `None` where it cannot be read.
    pub(super) area: Option<NoGoAreaRequest>,
    pub(super) by: String,
    pub(super) written_us: i64,
    pub(super) changed: (Option<String>, Option<i64>),
    pub(super) lifted: (Option<String>, Option<i64>),
}

/// The same as the question below asks for it.
type Found = (i64, u32, String, String, i64, Option<String>, Option<i64>, Option<String>, Option<i64>);

const COLUMNS: &str = "SELECT id, revision, body, by, written_us, changed_by, changed_us, lifted_by, lifted_us FROM no_go_area WHERE ";

fn row(found: Found) -> Row {
    let (id, revision, body, by, written_us, changed_by, changed_us, lifted_by, lifted_us) = found;
    let area = serde_json::from_str(&body).ok();
    Row {
        id,
        revision,
        area,
        by,
        written_us,
        changed: (changed_by, changed_us),
        lifted: (lifted_by, lifted_us),
    }
}

/// All that are closed, the oldest first.
#[derive(Debug)]
pub(super) struct Closed;

impl Request for Closed {
    type Answer = Vec<Row>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Vec<Row>, Fault> {
        let mut sql: QueryBuilder<Sqlite> = QueryBuilder::new(COLUMNS);
        sql.push("lifted_us IS NULL ORDER BY id");
        let found: Vec<Found> = sql.build_query_as().fetch_all(db).await?;
        Ok(found.into_iter().map(row).collect())
    }
}

/// Those that were lifted last, newest first.
#[derive(Debug)]
pub(super) struct Lifted;

impl Request for Lifted {
    type Answer = Vec<Row>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Vec<Row>, Fault> {
        let mut sql: QueryBuilder<Sqlite> = QueryBuilder::new(COLUMNS);
        sql.push("lifted_us IS NOT NULL ORDER BY lifted_us DESC, id DESC LIMIT ").push_bind(LIFTED);
        let found: Vec<Found> = sql.build_query_as().fetch_all(db).await?;
        Ok(found.into_iter().map(row).collect())
    }
}

/// The area with this number.
#[derive(Debug)]
pub(super) struct One(pub(super) i64);

impl Request for One {
    type Answer = Option<Row>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Option<Row>, Fault> {
        let mut sql: QueryBuilder<Sqlite> = QueryBuilder::new(COLUMNS);
        sql.push("id = ").push_bind(self.0);
        let found: Option<Found> = sql.build_query_as().fetch_optional(db).await?;
        Ok(found.map(row))
    }
}

/// Closes areas, one or more; the number of the first.
#[derive(Debug)]
pub(super) struct Create {
    pub(super) areas: Vec<NoGoAreaRequest>,
    pub(super) by: String,
    pub(super) now: UtcTime,
}

impl Request for Create {
    type Answer = i64;

    async fn run(self, db: &mut SqliteConnection) -> Result<i64, Fault> {
        let Self { areas, by, now } = self;
        let more = i64::try_from(areas.len()).unwrap_or(i64::MAX);
        let last: Option<i64> =
            sqlx::query_scalar("SELECT max(id) FROM no_go_area").fetch_one(&mut *db).await?;
        if last.unwrap_or_default().saturating_add(more) > AREAS {
            return Err(Fault::refused(
                say("There were {n} no-go areas: no more can be kept.").with("n", AREAS),
            ));
        }
        has_room(db, more).await?;
        let sql = "INSERT INTO no_go_area (revision, body, by, written_us) VALUES (1, ?1, ?2, ?3)";
        let mut first = None;
        for area in &areas {
            let query = sqlx::query(sql).bind(body(area)).bind(&by).bind(now.micros());
            let id = query.execute(&mut *db).await?.last_insert_rowid();
            first.get_or_insert(id);
        }
        Ok(first.unwrap_or_default())
    }
}

/// Changes an area that is at this revision.
#[derive(Debug)]
pub(super) struct Change {
    pub(super) id: i64,
    pub(super) revision: u32,
    pub(super) area: NoGoAreaRequest,
    pub(super) closed: bool,
    pub(super) by: String,
    pub(super) now: UtcTime,
}

impl Request for Change {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        let Self { id, revision, area, closed, by, now } = self;
        // Lifting is never refused for having been changed too often.
        if closed && revision > CHANGES {
            return Err(Fault::refused(
                say("This area was changed {n} times: close a new one.").with("n", CHANGES),
            ));
        }
        let sql = "SELECT lifted_us IS NOT NULL FROM no_go_area WHERE id = ?1";
        let was_lifted: Option<bool> = sqlx::query_scalar(sql).bind(id).fetch_optional(&mut *db).await?;
        if closed && was_lifted == Some(true) {
            has_room(db, 1).await?;
        }
        let sql = "INSERT INTO no_go_area_before
                   SELECT id, revision, body, coalesce(lifted_by, changed_by, by),
                          coalesce(lifted_us, changed_us, written_us)
                   FROM no_go_area WHERE id = ?1 AND revision = ?2";
        let kept = sqlx::query(sql).bind(id).bind(revision).execute(&mut *db).await?;
        Fault::unless_changed(&kept, NEWER)?;
        let sql = "UPDATE no_go_area SET revision = revision + 1, body = ?2,
                          changed_by = iif(?3, ?4, changed_by), changed_us = iif(?3, ?5, changed_us),
                          lifted_by = iif(?3, NULL, ?4), lifted_us = iif(?3, NULL, ?5) WHERE id = ?1";
        let query = sqlx::query(sql).bind(id).bind(body(&area)).bind(closed).bind(by).bind(now.micros());
        query.execute(db).await?;
        Ok(())
    }
}

/// Whether so many more areas can be closed.
async fn has_room(db: &mut SqliteConnection, more: i64) -> Result<(), Fault> {
    let sql = "SELECT count(*) FROM no_go_area WHERE lifted_us IS NULL";
    let closed: i64 = sqlx::query_scalar(sql).fetch_one(db).await?;
    if closed.saturating_add(more) > CLOSED {
        let text = say(
            "{n} areas are closed; {more} more would be above {most}, which is the most: lift one that is not \
                        needed any more.",
        );
        return Err(Fault::refused(text.with("n", closed).with("more", more).with("most", CLOSED)));
    }
    Ok(())
}

fn body(area: &NoGoAreaRequest) -> String {
    serde_json::to_string(area).unwrap_or_default()
}
