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
    /// Number of the one account that can open it.
    pub(super) person: Option<i64>,
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
        let sql = "INSERT INTO dataset_share (dataset, hash, password, expires_us, body, person) VALUES (?1, ?2, ?3, ?4, ?5, ?6)";
        let query = sqlx::query(sql).bind(self.dataset).bind(self.hash.to_vec()).bind(self.password);
        let query = query.bind(self.share.expires_us).bind(written(&self.share)?).bind(self.person);
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

#[derive(sqlx::FromRow)]
struct Found {
    id: i64,
    dataset: i64,
    password: Option<String>,
    expires_us: i64,
    body: String,
    views: i64,
    downloads: i64,
    used_us: Option<i64>,
    revoked_by: Option<String>,
    revoked_us: Option<i64>,
    person: Option<i64>,
}

const COLUMNS: &str =
    "SELECT id, dataset, password, expires_us, body, views, downloads, used_us, revoked_by, revoked_us, person
                       FROM dataset_share WHERE ";

/// What the row says of the link.
fn share(found: Found) -> Result<DatasetShare, Fault> {
    let Found {
        id,
        dataset,
        password,
        expires_us,
        body,
        views,
        downloads,
        used_us,
        revoked_by,
        revoked_us,
        ..
    } = found;
    let kept: DatasetShare = read(&body, dataset)?;
    let revoked = revoked_us.map(|time_us| LogWord { by: revoked_by.unwrap_or_default(), time_us });
    let has_password = password.is_some();
    Ok(DatasetShare { id, has_password, expires_us, views, downloads, used_us, revoked, ..kept })
}

/// Links of a dataset, the newest first.
#[derive(Debug)]
pub(super) struct Of(pub(super) i64);

impl Request for Of {
    type Answer = Vec<DatasetShare>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Vec<DatasetShare>, Fault> {
        let sql = sqlx::AssertSqlSafe(format!("{COLUMNS} dataset = ?1 ORDER BY id DESC"));
        let found: Vec<Found> = sqlx::query_as(sql).bind(self.0).fetch_all(db).await?;
        found.into_iter().map(share).collect()
    }
}

/// A link that was looked up.
pub(super) struct Led {
    pub(super) share: DatasetShare,
    /// The password's hash.
    pub(super) password: Option<String>,
    /// Number of the one account that can open it.
    pub(super) person: Option<i64>,
    pub(super) dataset: Row,
}

/// The link of an address, and its dataset, in one transaction.
pub(super) enum By {
    /// With a secret of this SHA-256; not one that is for an account.
    Secret([u8; 32]),
    /// With this number, which is for an account.
    Number(i64),
}

impl Request for By {
    type Answer = Option<Led>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Option<Led>, Fault> {
        let which = match self {
            Self::Secret(_) => "hash = ?1 AND person IS NULL",
            Self::Number(_) => "id = ?1 AND person IS NOT NULL",
        };
        let query = sqlx::query_as(sqlx::AssertSqlSafe(format!("{COLUMNS} {which}")));
        let query = match self {
            Self::Secret(hash) => query.bind(hash.to_vec()),
            Self::Number(number) => query.bind(number),
        };
        let Some(found): Option<Found> = query.fetch_optional(&mut *db).await? else { return Ok(None) };
        led(db, found).await
    }
}

/// The link of a row with its dataset.
async fn led(db: &mut SqliteConnection, found: Found) -> Result<Option<Led>, Fault> {
    let (id, password, person) = (found.dataset, found.password.clone(), found.person);
    let share = share(found)?;
    let dataset = Listed(Some(id)).run(db).await?.into_iter().next();
    Ok(dataset.map(|dataset| Led { share, password, person, dataset }))
}

/// Links for one account that are open, the newest first.
#[derive(Debug)]
pub(super) struct ForPerson {
    pub(super) person: i64,
    pub(super) now: UtcTime,
}

impl Request for ForPerson {
    type Answer = Vec<Led>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Vec<Led>, Fault> {
        let sql = sqlx::AssertSqlSafe(format!(
            "{COLUMNS} person = ?1 AND revoked_us IS NULL AND expires_us > ?2 ORDER BY id DESC LIMIT ?3"
        ));
        let query = sqlx::query_as(sql).bind(self.person).bind(self.now.micros()).bind(LISTED);
        let mut open = Vec::new();
        for found in query.fetch_all(&mut *db).await? {
            open.extend(led(db, found).await?);
        }
        Ok(open)
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
