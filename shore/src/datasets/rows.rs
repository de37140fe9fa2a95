//! Datasets in app.db.

use crate::identity::{Fault, Request};
use crate::logbook::NEWER;
use api::{DatasetDraft, DatasetVersion, say};
use serde::de::DeserializeOwned;
use sqlx::SqliteConnection;
use std::collections::BTreeMap;
use units::UtcTime;

/// Datasets that there may be.
const DATASETS: i64 = 2_000;
/// Versions of one.
const VERSIONS: usize = 200;

/// A dataset as it is kept.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Row {
    pub(super) id: i64,
    pub(super) revision: u32,
    pub(super) draft: Option<DatasetDraft>,
    pub(super) by: String,
    pub(super) made_us: i64,
    /// By whom, when, and why.
    pub(super) withdrawn: Option<(String, i64, String)>,
    /// The newest first.
    pub(super) versions: Vec<DatasetVersion>,
}

type Found = (i64, u32, Option<String>, String, i64, Option<String>, Option<i64>, Option<String>);

fn row(found: Found, versions: Vec<DatasetVersion>) -> Result<Row, Fault> {
    let (id, revision, draft, by, made_us, withdrawn_by, withdrawn_us, reason) = found;
    let draft = draft.map(|text| read(&text, id)).transpose()?;
    let withdrawn = withdrawn_us.map(|us| (withdrawn_by.unwrap_or_default(), us, reason.unwrap_or_default()));
    Ok(Row { id, revision, draft, by, made_us, withdrawn, versions })
}

/// Parses a part of a dataset that is stored as JSON.
pub(super) fn read<T: DeserializeOwned>(text: &str, id: i64) -> Result<T, Fault> {
    serde_json::from_str(text).map_err(|error| {
        let text = format!("dataset {id} cannot be read: {error}");
        Fault::from(sqlx::Error::Decode(text.into()))
    })
}

pub(super) fn written<T: serde::Serialize>(value: &T) -> Result<String, Fault> {
    serde_json::to_string(value).map_err(|error| Fault::from(sqlx::Error::Encode(error.into())))
}

const COLUMNS: &str =
    "SELECT id, revision, draft, by, made_us, withdrawn_by, withdrawn_us, reason FROM dataset";

/// All, the newest first; only that of this number, if given.
#[derive(Debug, Default)]
pub(super) struct Listed(pub(super) Option<i64>);

impl Request for Listed {
    type Answer = Vec<Row>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Vec<Row>, Fault> {
        let sql = format!("{COLUMNS} WHERE ?1 IS NULL OR id = ?1 ORDER BY id DESC");
        let found: Vec<Found> =
            sqlx::query_as(sqlx::AssertSqlSafe(sql)).bind(self.0).fetch_all(&mut *db).await?;
        let sql =
            "SELECT dataset, body FROM dataset_version WHERE ?1 IS NULL OR dataset = ?1 ORDER BY number DESC";
        let bodies: Vec<(i64, String)> = sqlx::query_as(sql).bind(self.0).fetch_all(db).await?;
        let mut versions: BTreeMap<i64, Vec<DatasetVersion>> = BTreeMap::new();
        for (id, body) in bodies {
            versions.entry(id).or_default().push(read(&body, id)?);
        }
        found.into_iter().map(|one| row(one.clone(), versions.remove(&one.0).unwrap_or_default())).collect()
    }
}

/// Makes a dataset; its number.
#[derive(Debug)]
pub(super) struct Create {
    pub(super) draft: DatasetDraft,
    pub(super) by: String,
    pub(super) now: UtcTime,
}

impl Request for Create {
    type Answer = i64;

    async fn run(self, db: &mut SqliteConnection) -> Result<i64, Fault> {
        let count: i64 = sqlx::query_scalar("SELECT count(*) FROM dataset").fetch_one(&mut *db).await?;
        if count >= DATASETS {
            return Err(Fault::refused(
                say("There are {n} datasets: no more can be kept.").with("n", DATASETS),
            ));
        }
        let sql = "INSERT INTO dataset (revision, draft, by, made_us) VALUES (1, ?1, ?2, ?3)";
        let query = sqlx::query(sql).bind(written(&self.draft)?).bind(self.by).bind(self.now.micros());
        Ok(query.execute(db).await?.last_insert_rowid())
    }
}

/// Replaces the draft of a dataset that is at this revision.
#[derive(Debug)]
pub(super) struct SetDraft {
    pub(super) id: i64,
    pub(super) revision: u32,
    pub(super) draft: DatasetDraft,
}

impl Request for SetDraft {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        let sql = "UPDATE dataset SET draft = ?3, revision = revision + 1
                   WHERE id = ?1 AND revision = ?2 AND withdrawn_us IS NULL";
        let query = sqlx::query(sql).bind(self.id).bind(self.revision).bind(written(&self.draft)?);
        Fault::unless_changed(&query.execute(db).await?, NEWER)
    }
}

/// Publishes the draft of a dataset that is at this revision as a version.
#[derive(Debug)]
pub(super) struct Publish {
    pub(super) id: i64,
    pub(super) revision: u32,
    pub(super) version: DatasetVersion,
}

impl Request for Publish {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        if self.version.number as usize > VERSIONS {
            let text = say("The dataset has {n} versions: make another dataset.").with("n", VERSIONS);
            return Err(Fault::refused(text));
        }
        let sql = "UPDATE dataset SET draft = NULL, revision = revision + 1
                   WHERE id = ?1 AND revision = ?2 AND withdrawn_us IS NULL";
        let query = sqlx::query(sql).bind(self.id).bind(self.revision);
        Fault::unless_changed(&query.execute(&mut *db).await?, NEWER)?;
        let sql = "INSERT INTO dataset_version (dataset, number, body) VALUES (?1, ?2, ?3)";
        let query = sqlx::query(sql).bind(self.id).bind(self.version.number).bind(written(&self.version)?);
        query.execute(db).await?;
        Ok(())
    }
}

/// Withdraws a dataset that is at this revision. Its versions stay listed.
#[derive(Debug)]
pub(super) struct Withdraw {
    pub(super) id: i64,
    pub(super) revision: u32,
    pub(super) by: String,
    pub(super) reason: String,
    pub(super) now: UtcTime,
}

impl Request for Withdraw {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        let sql =
            "UPDATE dataset SET withdrawn_by = ?3, withdrawn_us = ?4, reason = ?5, revision = revision + 1
                   WHERE id = ?1 AND revision = ?2 AND withdrawn_us IS NULL";
        let query = sqlx::query(sql).bind(self.id).bind(self.revision).bind(self.by);
        let query = query.bind(self.now.micros()).bind(self.reason);
        Fault::unless_changed(&query.execute(db).await?, NEWER)
    }
}
