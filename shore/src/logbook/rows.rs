//! Notes in app.db.

use crate::identity::{Fault, Request};
use api::{Fixed, LogNoteRevision, LogWord, fixed, say};
use sqlx::{QueryBuilder, Sqlite, SqliteConnection};
use units::UtcTime;

/// Notes that there may ever be: some decades of a busy crew.
const NOTES: i64 = 1_000_000;
/// Corrections of one note.
const CORRECTIONS: u32 = 100;

/// Why a change that comes too late is refused.
pub(crate) const NEWER: Fixed = fixed("Somebody changed this meanwhile: load it again, then change it.");
/// Why a photo is refused that a note cannot have.
pub(super) const HAS_PHOTO: Fixed =
    fixed("photo: this note has a photo, or was withdrawn. Write a new note for another photo.");

/// The content of a note.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Said {
    pub(super) time_us: i64,
    pub(super) vessel: Option<u16>,
    /// Latitude and longitude (degrees).
    pub(super) place: Option<(f64, f64)>,
    pub(super) text: String,
}

/// A stored note.
#[derive(Debug, Clone, PartialEq, sqlx::FromRow)]
pub struct Row {
    /// Its number.
    pub id: i64,
    pub(super) revision: u32,
    pub(super) time_us: i64,
    pub(super) vessel: Option<u16>,
    pub(super) lat_deg: Option<f64>,
    pub(super) lon_deg: Option<f64>,
    pub(super) text: String,
    pub(super) person: i64,
    pub(super) by: String,
    pub(super) written_us: i64,
    pub(super) corrected_by: Option<String>,
    pub(super) corrected_us: Option<i64>,
    pub(super) withdrawn_by: Option<String>,
    pub(super) withdrawn_us: Option<i64>,
    pub(super) photo: Option<String>,
}

/// The columns of [`Row`].
const COLUMNS: &str = "SELECT id, revision, time_us, vessel, lat_deg, lon_deg, text, person, by, written_us, corrected_by, \
                       corrected_us, withdrawn_by, withdrawn_us, photo FROM log_note WHERE ";

/// Which notes.
#[derive(Debug, Clone, Default)]
pub struct Filter {
    /// What the user may see: notes on these vessels and on none; `None` for all.
    pub seen: Option<Vec<u16>>,
    /// On these vessels; empty for all.
    pub vessels: Vec<u16>,
    /// Beside those on `vessels` also notes on no vessel.
    pub general: bool,
    /// About this time or later (µs since 1970 UTC).
    pub from_us: Option<i64>,
    /// About a time before this (µs since 1970 UTC).
    pub to_us: Option<i64>,
    /// With this in the text; empty for all.
    pub text: String,
    /// Also those that were withdrawn.
    pub withdrawn: bool,
}

/// Notes, the newest first by the time they are about.
#[derive(Debug, Clone, Default)]
pub struct Notes {
    /// Which notes.
    pub filter: Filter,
    /// Before the note of this time and number.
    pub before: Option<(i64, i64)>,
    /// At most this many.
    pub count: u32,
}

impl Request for Notes {
    type Answer = Vec<Row>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Vec<Row>, Fault> {
        let Filter { seen, vessels, general, from_us, to_us, text, withdrawn } = self.filter;
        let mut sql: QueryBuilder<Sqlite> = QueryBuilder::new(COLUMNS);
        sql.push("1");
        if !withdrawn {
            sql.push(" AND withdrawn_us IS NULL");
        }
        if let Some(seen) = &seen {
            on(&mut sql, seen, true);
        }
        if !vessels.is_empty() {
            on(&mut sql, &vessels, general);
        }
        for (compared, value) in [("time_us >= ", from_us), ("time_us < ", to_us)] {
            if let Some(value) = value {
                sql.push(" AND ").push(compared).push_bind(value);
            }
        }
        if !text.is_empty() {
            sql.push(" AND instr(folded, ").push_bind(text.to_lowercase()).push(") > 0");
        }
        if let Some((time_us, id)) = self.before {
            sql.push(" AND (time_us, id) < (").push_bind(time_us).push(", ").push_bind(id).push(")");
        }
        sql.push(" ORDER BY time_us DESC, id DESC LIMIT ").push_bind(self.count);
        Ok(sql.build_query_as().fetch_all(db).await?)
    }
}

/// Adds the condition for notes on these vessels; with `general` also those on none.
fn on(sql: &mut QueryBuilder<Sqlite>, vessels: &[u16], general: bool) {
    sql.push(if general { " AND (vessel IS NULL OR vessel IN (" } else { " AND (vessel IN (" });
    let mut list = sql.separated(", ");
    for vessel in vessels {
        list.push_bind(*vessel);
    }
    sql.push("))");
}

/// The note with this number.
#[derive(Debug)]
pub(super) struct One(pub(super) i64);

impl Request for One {
    type Answer = Option<Row>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Option<Row>, Fault> {
        let mut sql: QueryBuilder<Sqlite> = QueryBuilder::new(COLUMNS);
        sql.push("id = ").push_bind(self.0);
        Ok(sql.build_query_as().fetch_optional(db).await?)
    }
}

/// Earlier revisions of a note, the newest first.
#[derive(Debug)]
pub(super) struct Earlier(pub(super) i64);

/// A row of the query below.
type EarlierRow = (u32, i64, Option<u16>, Option<f64>, Option<f64>, String, String, i64);

impl Request for Earlier {
    type Answer = Vec<LogNoteRevision>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Vec<LogNoteRevision>, Fault> {
        let sql =
            "SELECT revision, time_us, vessel, lat_deg, lon_deg, text, by, written_us FROM log_note_before
                   WHERE note = ?1 ORDER BY revision DESC";
        let rows: Vec<EarlierRow> = sqlx::query_as(sql).bind(self.0).fetch_all(db).await?;
        let one = |(revision, time_us, vessel, lat_deg, lon_deg, text, by, written_us): EarlierRow| {
            let written = LogWord { by, time_us: written_us };
            LogNoteRevision { revision, time_us, vessel, lat_deg, lon_deg, text, written }
        };
        Ok(rows.into_iter().map(one).collect())
    }
}

/// Writes a note; its number.
#[derive(Debug)]
pub(super) struct Write {
    pub(super) said: Said,
    pub(super) person: i64,
    pub(super) by: String,
    pub(super) now: UtcTime,
}

impl Request for Write {
    type Answer = i64;

    async fn run(self, db: &mut SqliteConnection) -> Result<i64, Fault> {
        let Self { said, person, by, now } = self;
        let last: Option<i64> =
            sqlx::query_scalar("SELECT max(id) FROM log_note").fetch_one(&mut *db).await?;
        if last >= Some(NOTES) {
            return Err(Fault::refused(say("The log book is full: it holds {n} notes.").with("n", NOTES)));
        }
        let sql = "INSERT INTO log_note (revision, time_us, vessel, lat_deg, lon_deg, text, folded, person, by, written_us)
                   VALUES (1, ?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9)";
        let query = sqlx::query(sql).bind(said.time_us).bind(said.vessel);
        let query = query.bind(said.place.map(|place| place.0)).bind(said.place.map(|place| place.1));
        let query = query.bind(&said.text).bind(said.text.to_lowercase());
        let query = query.bind(person).bind(by).bind(now.micros());
        Ok(query.execute(db).await?.last_insert_rowid())
    }
}

/// Corrects a note that is at this revision and not withdrawn.
#[derive(Debug)]
pub(super) struct Correct {
    pub(super) id: i64,
    pub(super) revision: u32,
    pub(super) said: Said,
    pub(super) by: String,
    pub(super) now: UtcTime,
}

impl Request for Correct {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        let Self { id, revision, said, by, now } = self;
        if revision > CORRECTIONS {
            let text = say("This note was corrected {n} times: write a new one.").with("n", CORRECTIONS);
            return Err(Fault::refused(text));
        }
        let sql = "INSERT INTO log_note_before
                   SELECT id, revision, time_us, vessel, lat_deg, lon_deg, text, coalesce(corrected_by, by),
                          coalesce(corrected_us, written_us)
                   FROM log_note WHERE id = ?1 AND revision = ?2 AND withdrawn_us IS NULL";
        let kept = sqlx::query(sql).bind(id).bind(revision).execute(&mut *db).await?;
        Fault::unless_changed(&kept, NEWER)?;
        let sql = "UPDATE log_note SET revision = revision + 1, time_us = ?2, vessel = ?3, lat_deg = ?4, lon_deg = ?5,
                          text = ?6, folded = ?7, corrected_by = ?8, corrected_us = ?9 WHERE id = ?1";
        let query = sqlx::query(sql).bind(id).bind(said.time_us).bind(said.vessel);
        let query = query.bind(said.place.map(|place| place.0)).bind(said.place.map(|place| place.1));
        let query = query.bind(&said.text).bind(said.text.to_lowercase());
        query.bind(by).bind(now.micros()).execute(db).await?;
        Ok(())
    }
}

/// Withdraws a note that is at this revision.
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
        let sql = "UPDATE log_note SET withdrawn_by = ?3, withdrawn_us = ?4
                   WHERE id = ?1 AND revision = ?2 AND withdrawn_us IS NULL";
        let query = sqlx::query(sql).bind(self.id).bind(self.revision).bind(self.by).bind(self.now.micros());
        Fault::unless_changed(&query.execute(db).await?, NEWER)
    }
}

/// Bytes of all photos.
#[derive(Debug)]
pub(super) struct PhotoBytes;

impl Request for PhotoBytes {
    type Answer = u64;

    async fn run(self, db: &mut SqliteConnection) -> Result<u64, Fault> {
        let sql = "SELECT coalesce(sum(photo_bytes), 0) FROM log_note WHERE photo_bytes > 0";
        let bytes: i64 = sqlx::query_scalar(sql).fetch_one(db).await?;
        Ok(bytes.unsigned_abs())
    }
}

/// Marks a note as having a photo, if it has none and is not withdrawn.
#[derive(Debug)]
pub(super) struct AddPhoto {
    pub(super) id: i64,
    pub(super) media: &'static str,
    pub(super) bytes: usize,
}

impl Request for AddPhoto {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        let sql = "UPDATE log_note SET photo = ?2, photo_bytes = ?3
                   WHERE id = ?1 AND photo IS NULL AND withdrawn_us IS NULL";
        let bytes = i64::try_from(self.bytes).unwrap_or(i64::MAX);
        let query = sqlx::query(sql).bind(self.id).bind(self.media).bind(bytes);
        Fault::unless_changed(&query.execute(db).await?, HAS_PHOTO)
    }
}
