//! The register in app.db.

use crate::identity::{Fault, Principal, Request};
use crate::logbook::NEWER;
use api::{RegisterKind, RegisterRecord, Said, say};
use research::{KINDS, Study, check_all, kind_of, kind_said, kind_word, name_of, name_taken};
use sqlx::SqliteConnection;
use units::UtcTime;

/// Most entries of one kind.
const ENTRIES: usize = 10_000;
/// Most faults of a change that are reported: more would not help.
const TOLD: usize = 5;

/// A stored entry.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Its number.
    pub id: i64,
    /// Grows with each change.
    pub revision: u32,
    /// Its content.
    pub record: RegisterRecord,
    /// Author of this revision.
    pub by: String,
    /// Time of the last change (µs of Unix time).
    pub written_us: i64,
}

/// All entries by kind and name, and the register's version.
#[derive(Debug)]
pub struct All;

impl Request for All {
    type Answer = (i64, Vec<Row>);

    async fn run(self, db: &mut SqliteConnection) -> Result<(i64, Vec<Row>), Fault> {
        let version = sqlx::query_scalar("SELECT changes FROM study_state").fetch_one(&mut *db).await?;
        let sql = "SELECT id, revision, body, by, written_us FROM study_entry ORDER BY kind, folded";
        let found: Vec<(i64, u32, String, String, i64)> = sqlx::query_as(sql).fetch_all(db).await?;
        let row = |(id, revision, body, by, written_us): (i64, u32, String, String, i64)| {
            let record = serde_json::from_str(&body).map_err(|error| {
                let text = format!("entry {id} of the register cannot be read: {error}");
                Fault::from(sqlx::Error::Decode(text.into()))
            })?;
            Ok(Row { id, revision, record, by, written_us })
        };
        Ok((version, found.into_iter().map(row).collect::<Result<_, Fault>>()?))
    }
}

/// Whether a user may see an entry.
pub(super) fn sees(who: &Principal, record: &RegisterRecord) -> bool {
    match record {
        RegisterRecord::Deployment(one) => one.vessel.is_none_or(|vessel| who.grants.on(vessel).is_some()),
        _ => true,
    }
}

/// A fault as reported to a user who may not see all entries.
pub(super) fn told_to(
    is_hidden: &dyn Fn(usize) -> bool,
    records: &[RegisterRecord],
    fault: &research::Fault,
    names_entry: bool,
) -> Option<Said> {
    let record = records.get(fault.entry)?;
    let text = if is_hidden(fault.entry) || fault.other.is_some_and(is_hidden) {
        say("the receiver is deployed elsewhere at the same time; choose another time, or ask an admin")
    } else {
        fault.text.clone()
    };
    if names_entry && !is_hidden(fault.entry) {
        return Some(
            say("{kind} `{name}`: {text}")
                .with_said("kind", kind_said(kind_of(record)))
                .with("name", name_of(record))
                .with_said("text", text)
                .into(),
        );
    }
    Some(text.into())
}

/// The register, for looking up detections.
pub fn study(rows: Vec<Row>) -> Study {
    Study::new(rows.into_iter().map(|row| row.record))
}

/// One step of a change.
#[derive(Debug, Clone)]
pub(super) enum Step {
    /// A new entry.
    Add(RegisterRecord),
    /// The entry of this number and revision is changed.
    Change(i64, u32, RegisterRecord),
    /// The entry of this number and revision is deleted.
    Delete(i64, u32),
}

/// Changes the register: all steps, or none if one is not possible or the resulting register would not be valid. The answer
/// is the number of the last entry that was added or changed.
#[derive(Debug)]
pub(super) struct Write {
    pub(super) steps: Vec<Step>,
    /// The register's version for which the steps were made; `None` for any.
    pub(super) version: Option<i64>,
    pub(super) by: String,
    pub(super) now: UtcTime,
    /// The requester, whose errors must not reveal entries that they may not see; `None` for no restriction.
    pub(super) asked: Option<Principal>,
}

impl Request for Write {
    type Answer = i64;

    async fn run(self, db: &mut SqliteConnection) -> Result<i64, Fault> {
        let (version, mut rows) = All.run(&mut *db).await?;
        if self.version.is_some_and(|wanted| wanted != version) {
            return Err(Fault::refused(NEWER));
        }
        let mut last = 0;
        for step in &self.steps {
            last = self.step(db, &mut rows, step).await?;
        }
        holds(&rows, &|record| self.asked.as_ref().is_none_or(|who| sees(who, record)))?;
        sqlx::query("UPDATE study_state SET changes = changes + 1").execute(db).await?;
        Ok(last)
    }
}

impl Write {
    async fn step(&self, db: &mut SqliteConnection, rows: &mut Vec<Row>, step: &Step) -> Result<i64, Fault> {
        let (by, written_us) = (self.by.clone(), self.now.micros());
        match step {
            Step::Add(record) => {
                let sql = "INSERT INTO study_entry (kind, folded, revision, body, by, written_us)
                           VALUES (?1, ?2, 1, ?3, ?4, ?5)";
                self.named_once(rows, None, record)?;
                let query = sqlx::query(sql).bind(kind_word(kind_of(record))).bind(folded(record));
                let query = query.bind(body(record)).bind(&by).bind(written_us);
                let id = query.execute(db).await?.last_insert_rowid();
                rows.push(Row { id, revision: 1, record: record.clone(), by, written_us });
                Ok(id)
            }
            Step::Change(id, revision, record) => {
                self.named_once(rows, Some(*id), record)?;
                let row = find(rows, *id, *revision)?;
                self.keep(db, row).await?;
                let sql = "UPDATE study_entry SET revision = revision + 1, folded = ?2, body = ?3, by = ?4, written_us = ?5
                           WHERE id = ?1";
                let query = sqlx::query(sql).bind(id).bind(folded(record)).bind(body(record));
                query.bind(&by).bind(written_us).execute(db).await?;
                *row = Row { id: *id, revision: revision + 1, record: record.clone(), by, written_us };
                Ok(*id)
            }
            Step::Delete(id, revision) => {
                let row = find(rows, *id, *revision)?;
                self.keep(db, row).await?;
                sqlx::query("DELETE FROM study_entry WHERE id = ?1").bind(id).execute(db).await?;
                rows.retain(|row| row.id != *id);
                Ok(*id)
            }
        }
    }

    /// Refuses a name that another entry of the kind has, with a better message than the table's constraint. For several
    /// steps, which come from a file, names were compared already.
    fn named_once(&self, rows: &[Row], id: Option<i64>, record: &RegisterRecord) -> Result<(), Fault> {
        let (kind, name) = (kind_of(record), folded(record));
        let is_other =
            |row: &&Row| Some(row.id) != id && kind_of(&row.record) == kind && folded(&row.record) == name;
        if self.steps.len() > 1 {
            return Ok(());
        }
        match rows.iter().find(is_other) {
            None => Ok(()),
            Some(other) => {
                Err(Fault::refused(Said::from(name_taken(kind, name_of(&other.record))).of_field("name")))
            }
        }
    }

    /// Stores the present version of an entry before it is changed or deleted.
    async fn keep(&self, db: &mut SqliteConnection, row: &Row) -> Result<(), Fault> {
        let sql = "INSERT INTO study_entry_before (entry, revision, body, by, written_us, ended_by, ended_us)
                   VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)";
        let query = sqlx::query(sql).bind(row.id).bind(row.revision).bind(body(&row.record));
        let query = query.bind(&row.by).bind(row.written_us).bind(&self.by).bind(self.now.micros());
        query.execute(db).await?;
        Ok(())
    }
}

fn find(rows: &mut [Row], id: i64, revision: u32) -> Result<&mut Row, Fault> {
    let row = rows.iter_mut().find(|row| row.id == id && row.revision == revision);
    row.ok_or_else(|| Fault::refused(NEWER))
}

/// Refuses a register that is not valid as a whole.
fn holds(rows: &[Row], sees: &dyn Fn(&RegisterRecord) -> bool) -> Result<(), Fault> {
    let records: Vec<RegisterRecord> = rows.iter().map(|row| row.record.clone()).collect();
    let count = |kind: RegisterKind| records.iter().filter(|record| kind_of(record) == kind).count();
    if let Some(kind) = KINDS.into_iter().find(|kind| count(*kind) > ENTRIES) {
        let text = say("There would be more than {most} entries of the kind {kind}.")
            .with("most", ENTRIES)
            .with_said("kind", kind_said(kind));
        return Err(Fault::refused(text));
    }
    let faults = check_all(&records);
    if faults.is_empty() {
        return Ok(());
    }
    let is_hidden = |at: usize| records.get(at).is_some_and(|record| !sees(record));
    let told = faults.iter().take(TOLD).filter_map(|fault| {
        told_to(&is_hidden, &records, fault, true).map(|text| text.of_field(fault.column))
    });
    Err(Fault::refused(Said::lines(told)))
}

fn folded(record: &RegisterRecord) -> String {
    name_of(record).to_lowercase()
}

fn body(record: &RegisterRecord) -> String {
    serde_json::to_string(record).unwrap_or_default()
}
