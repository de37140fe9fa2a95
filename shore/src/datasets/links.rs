//! Links to datasets in app.db, and their uses.

use super::rows::{Listed, Row, read, written};
use crate::identity::{Fault, Request};
use api::{DatasetShare, LogWord, ShareVisit, ShareVisitKind, say};
use sqlx::SqliteConnection;
use units::UtcTime;

/// Most valid links of one dataset.
const SHARES: i64 = 200;
/// Most links of one dataset that are kept after they were revoked or ended, those that did so last: making and revoking links again and again must not fill
/// the disk. The audit log keeps who made and revoked the others.
const CLOSED: i64 = 1_000;
/// Most uses of one link that are kept, by kind, the newest: many views do not push out downloads.
const VISITS: i64 = 10_000;
/// Most uses that are listed.
const LISTED: i64 = 500;

/// Makes a link; its number.
pub(super) struct Add {
    pub(super) dataset: i64,
    /// SHA-256 of the secret in its address.
    pub(super) hash: [u8; 32],
    /// The password's hash.
    pub(super) password: Option<String>,
    pub(super) share: DatasetShare,
}

impl Request for Add {
    type Answer = i64;

    async fn run(self, db: &mut SqliteConnection) -> Result<i64, Fault> {
        let sql = "SELECT count(*) FROM dataset_share WHERE dataset = ?1 AND revoked_us IS NULL AND expires_us > ?2";
        let query = sqlx::query_scalar(sql).bind(self.dataset).bind(self.share.made.time_us);
        let count: i64 = query.fetch_one(&mut *db).await?;
        if count >= SHARES {
            return Err(Fault::refused(say("{n} links to the dataset are open, which is the most. Revoke one that is not needed any more.").with("n", SHARES)));
        }
        let sql = "INSERT INTO dataset_share (dataset, hash, password, expires_us, body) VALUES (?1, ?2, ?3, ?4, ?5)";
        let query = sqlx::query(sql).bind(self.dataset).bind(self.hash.to_vec()).bind(self.password);
        let query = query.bind(self.share.expires_us).bind(written(&self.share)?);
        let made = query.execute(&mut *db).await?.last_insert_rowid();
        forget_closed(db, self.dataset, self.share.made.time_us).await?;
        Ok(made)
    }
}

/// Removes links of a dataset that do not open any more, with their uses, but for the [`CLOSED`] that were revoked or ended last: one that
/// was open for years has its uses yesterday. Of what still opens nothing is removed.
async fn forget_closed(db: &mut SqliteConnection, dataset: i64, now_us: i64) -> Result<(), Fault> {
    const OLD: &str =
        "SELECT id FROM dataset_share WHERE dataset = ?1 AND (revoked_us IS NOT NULL OR expires_us <= ?2)
                       ORDER BY min(coalesce(revoked_us, expires_us), expires_us) DESC, id DESC LIMIT -1 OFFSET ?3";
    for (table, column) in [("dataset_visit", "share"), ("dataset_share", "id")] {
        let sql = sqlx::AssertSqlSafe(format!("DELETE FROM {table} WHERE {column} IN ({OLD})"));
        sqlx::query(sql).bind(dataset).bind(now_us).bind(CLOSED).execute(&mut *db).await?;
    }
    Ok(())
}

type Found = (i64, i64, Option<String>, i64, String, i64, i64, Option<i64>, Option<String>, Option<i64>);

const COLUMNS: &str =
    "SELECT id, dataset, password, expires_us, body, views, downloads, used_us, revoked_by, revoked_us
                       FROM dataset_share WHERE ";

/// A link with the number of its dataset and its password's hash.
fn share(found: Found) -> Result<(DatasetShare, i64, Option<String>), Fault> {
    let (id, dataset, password, expires_us, body, views, downloads, used_us, revoked_by, revoked_us) = found;
    let kept: DatasetShare = read(&body, dataset)?;
    let revoked = revoked_us.map(|time_us| LogWord { by: revoked_by.unwrap_or_default(), time_us });
    let has_password = password.is_some();
    let share = DatasetShare { id, has_password, expires_us, views, downloads, used_us, revoked, ..kept };
    Ok((share, dataset, password))
}

/// Links of a dataset, the newest first.
#[derive(Debug)]
pub(super) struct Of(pub(super) i64);

impl Request for Of {
    type Answer = Vec<DatasetShare>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Vec<DatasetShare>, Fault> {
        let sql = sqlx::AssertSqlSafe(format!("{COLUMNS} dataset = ?1 ORDER BY id DESC"));
        let found: Vec<Found> = sqlx::query_as(sql).bind(self.0).fetch_all(db).await?;
        found.into_iter().map(|one| Ok(share(one)?.0)).collect()
    }
}

/// The result of looking up a link's secret.
pub(super) struct Led {
    pub(super) share: DatasetShare,
    pub(super) password: Option<String>,
    pub(super) dataset: Row,
}

/// The link with a secret of this SHA-256, and its dataset, in one transaction.
pub(super) struct By(pub(super) [u8; 32]);

impl Request for By {
    type Answer = Option<Led>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Option<Led>, Fault> {
        let sql = sqlx::AssertSqlSafe(format!("{COLUMNS} hash = ?1"));
        let found: Option<Found> = sqlx::query_as(sql).bind(self.0.to_vec()).fetch_optional(&mut *db).await?;
        let Some((share, dataset, password)) = found.map(share).transpose()? else { return Ok(None) };
        let dataset = Listed(Some(dataset)).run(db).await?.into_iter().next();
        Ok(dataset.map(|dataset| Led { share, password, dataset }))
    }
}

/// Revokes a link of a dataset.
#[derive(Debug)]
pub(super) struct Revoke {
    pub(super) dataset: i64,
    pub(super) share: i64,
    pub(super) by: String,
    pub(super) now: UtcTime,
}

impl Request for Revoke {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        let sql = "UPDATE dataset_share SET revoked_by = ?3, revoked_us = ?4
                   WHERE id = ?2 AND dataset = ?1 AND revoked_us IS NULL";
        let query = sqlx::query(sql).bind(self.dataset).bind(self.share).bind(self.by);
        let done = query.bind(self.now.micros()).execute(db).await?;
        Fault::unless_changed(&done, say("There is no such link any more, or it is revoked already."))
    }
}

/// Records the use of a link.
#[derive(Debug)]
pub(super) struct Visit {
    pub(super) share: i64,
    pub(super) visit: ShareVisit,
}

impl Request for Visit {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        let Self { share, visit: ShareVisit { time_us, address, what, file } } = self;
        let sql =
            "INSERT INTO dataset_visit (share, time_us, address, what, file) VALUES (?1, ?2, ?3, ?4, ?5)";
        let query = sqlx::query(sql).bind(share).bind(time_us).bind(address).bind(word(what)).bind(file);
        query.execute(&mut *db).await?;
        let sql = "DELETE FROM dataset_visit WHERE share = ?1 AND what = ?3 AND id <=
                   (SELECT id FROM dataset_visit WHERE share = ?1 AND what = ?3 ORDER BY id DESC LIMIT 1 OFFSET ?2)";
        sqlx::query(sql).bind(share).bind(VISITS).bind(word(what)).execute(&mut *db).await?;
        let (view, download) = (what == ShareVisitKind::View, what == ShareVisitKind::Download);
        let sql = "UPDATE dataset_share SET views = views + ?2, downloads = downloads + ?3,
                   used_us = CASE WHEN ?2 OR ?3 THEN ?4 ELSE used_us END WHERE id = ?1";
        sqlx::query(sql).bind(share).bind(view).bind(download).bind(time_us).execute(db).await?;
        Ok(())
    }
}

const fn word(what: ShareVisitKind) -> &'static str {
    match what {
        ShareVisitKind::View => "view",
        ShareVisitKind::Download => "download",
        ShareVisitKind::WrongPassword => "wrong_password",
    }
}

/// How a link of a dataset was used, the newest first; 500 at most.
#[derive(Debug)]
pub(super) struct Visits {
    pub(super) dataset: i64,
    pub(super) share: i64,
}

impl Request for Visits {
    type Answer = Vec<ShareVisit>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Vec<ShareVisit>, Fault> {
        let sql = "SELECT time_us, address, what, file FROM dataset_visit
                   WHERE share = ?2 AND share IN (SELECT id FROM dataset_share WHERE dataset = ?1) ORDER BY id DESC LIMIT ?3";
        let query = sqlx::query_as(sql).bind(self.dataset).bind(self.share).bind(LISTED);
        let found: Vec<(i64, String, String, String)> = query.fetch_all(db).await?;
        let visit = |(time_us, address, what, file): (i64, String, String, String)| {
            let what = match &*what {
                "download" => ShareVisitKind::Download,
                "wrong_password" => ShareVisitKind::WrongPassword,
                _ => ShareVisitKind::View,
            };
            ShareVisit { time_us, address, what, file }
        };
        Ok(found.into_iter().map(visit).collect())
    }
}
