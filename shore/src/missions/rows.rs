//! Missions in app.db.

use crate::identity::{Fault, Request};
use crate::logbook::NEWER;
use api::{MissionRequest, say};
use sqlx::{QueryBuilder, Sqlite, SqliteConnection};
use units::UtcTime;

/// Missions that there may ever be.
const MISSIONS: i64 = 100_000;
/// Changes of one mission.
const CHANGES: u32 = 200;

/// A mission as it is kept.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Row {
    pub(super) id: i64,
    pub(super) revision: u32,
    pub(super) mission: MissionRequest,
    pub(super) by: String,
    pub(super) written_us: i64,
    pub(super) changed: (Option<String>, Option<i64>),
    pub(super) withdrawn: (Option<String>, Option<i64>),
}

/// The same as the question below asks for it.
type Found = (i64, u32, String, String, i64, Option<String>, Option<i64>, Option<String>, Option<i64>);

const COLUMNS: &str = "SELECT id, revision, body, by, written_us, changed_by, changed_us, withdrawn_by, withdrawn_us \
                       FROM mission WHERE ";

fn row(found: Found) -> Row {
    let (id, revision, body, by, written_us, changed_by, changed_us, withdrawn_by, withdrawn_us) = found;
    let mission = serde_json::from_str(&body).unwrap_or_else(|_| MissionRequest {
        name: "This mission cannot be read".to_owned(),
        ..MissionRequest::default()
    });
    let (changed, withdrawn) = ((changed_by, changed_us), (withdrawn_by, withdrawn_us));
    Row { id, revision, mission, by, written_us, changed, withdrawn }
}

/// Missions, those that began last first.
#[derive(Debug, Default)]
pub(super) struct List {
    /// Those with one of these vessels; `None` for all.
    pub(super) seen: Option<Vec<u16>>,
    pub(super) withdrawn: bool,
    /// Before the mission of this begin and number.
    pub(super) before: Option<(i64, i64)>,
    pub(super) count: u32,
}

impl Request for List {
    type Answer = Vec<Row>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Vec<Row>, Fault> {
        let mut sql: QueryBuilder<Sqlite> = QueryBuilder::new(COLUMNS);
        sql.push("1");
        if !self.withdrawn {
            sql.push(" AND withdrawn_us IS NULL");
        }
        if let Some(seen) = &self.seen {
            sql.push(" AND EXISTS (SELECT 1 FROM mission_vessel WHERE mission = id AND vessel IN (");
            let mut list = sql.separated(", ");
            for vessel in seen {
                list.push_bind(*vessel);
            }
            sql.push("))");
        }
        if let Some((from_us, id)) = self.before {
            sql.push(" AND (from_us, id) < (").push_bind(from_us).push(", ").push_bind(id).push(")");
        }
        sql.push(" ORDER BY from_us DESC, id DESC LIMIT ").push_bind(self.count);
        let found: Vec<Found> = sql.build_query_as().fetch_all(db).await?;
        Ok(found.into_iter().map(row).collect())
    }
}

/// The mission with this number.
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

/// Writes a mission down; its number.
#[derive(Debug)]
pub(super) struct Create {
    pub(super) mission: MissionRequest,
    pub(super) by: String,
    pub(super) now: UtcTime,
}

impl Request for Create {
    type Answer = i64;

    async fn run(self, db: &mut SqliteConnection) -> Result<i64, Fault> {
        let Self { mission, by, now } = self;
        let last: Option<i64> = sqlx::query_scalar("SELECT max(id) FROM mission").fetch_one(&mut *db).await?;
        if last >= Some(MISSIONS) {
            return Err(Fault::refused(
                say("There are {n} missions: no more can be kept.").with("n", MISSIONS),
            ));
        }
        let sql = "INSERT INTO mission (revision, from_us, to_us, body, by, written_us) VALUES (1, ?1, ?2, ?3, ?4, ?5)";
        let query = sqlx::query(sql).bind(mission.from_us).bind(mission.to_us).bind(body(&mission));
        let id = query.bind(by).bind(now.micros()).execute(&mut *db).await?.last_insert_rowid();
        put_vessels(db, id, &mission.vessels).await?;
        Ok(id)
    }
}

/// Changes a mission that is at this revision and not withdrawn.
#[derive(Debug)]
pub(super) struct Change {
    pub(super) id: i64,
    pub(super) revision: u32,
    pub(super) mission: MissionRequest,
    pub(super) by: String,
    pub(super) now: UtcTime,
}

impl Request for Change {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        let Self { id, revision, mission, by, now } = self;
        if revision > CHANGES {
            return Err(Fault::refused(
                say("This mission was changed {n} times: make a new one.").with("n", CHANGES),
            ));
        }
        let sql = "INSERT INTO mission_before
                   SELECT id, revision, body, coalesce(changed_by, by), coalesce(changed_us, written_us)
                   FROM mission WHERE id = ?1 AND revision = ?2 AND withdrawn_us IS NULL";
        let kept = sqlx::query(sql).bind(id).bind(revision).execute(&mut *db).await?;
        Fault::unless_changed(&kept, NEWER)?;
        let sql = "UPDATE mission SET revision = revision + 1, from_us = ?2, to_us = ?3, body = ?4, changed_by = ?5,
                          changed_us = ?6 WHERE id = ?1";
        let query = sqlx::query(sql).bind(id).bind(mission.from_us).bind(mission.to_us).bind(body(&mission));
        query.bind(by).bind(now.micros()).execute(&mut *db).await?;
        sqlx::query("DELETE FROM mission_vessel WHERE mission = ?1").bind(id).execute(&mut *db).await?;
        put_vessels(db, id, &mission.vessels).await
    }
}

/// Withdraws a mission that is at this revision.
#[derive(Debug)]
pub(super) struct Withdraw {
    pub(super) id: i64,
    pub(super) revision: u32,
    pub(super) by: String,
    pub(super) now: UtcTime,
}

impl Request for Withdraw {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        let sql = "UPDATE mission SET withdrawn_by = ?3, withdrawn_us = ?4
                   WHERE id = ?1 AND revision = ?2 AND withdrawn_us IS NULL";
        let query = sqlx::query(sql).bind(self.id).bind(self.revision).bind(self.by).bind(self.now.micros());
        Fault::unless_changed(&query.execute(db).await?, NEWER)
    }
}

fn body(mission: &MissionRequest) -> String {
    serde_json::to_string(mission).unwrap_or_default()
}

async fn put_vessels(db: &mut SqliteConnection, id: i64, vessels: &[u16]) -> Result<(), Fault> {
    for vessel in vessels {
        let sql = "INSERT INTO mission_vessel (mission, vessel) VALUES (?1, ?2)";
        sqlx::query(sql).bind(id).bind(*vessel).execute(&mut *db).await?;
    }
    Ok(())
}
