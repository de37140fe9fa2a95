//! Tokens of vessels' links, for provisioning: whether a secret is still valid, and when a vessel's older tokens end.

use super::fault::Fault;
use super::request::Request;
use super::secret::Secret;
use super::tokens::LINK_PREFIX;
use sqlx::SqliteConnection;
use units::UtcTime;

/// The number of the token with this secret, if it opens the link of this vessel at this time.
pub struct Opens {
    /// As the token was shown when it was made.
    pub secret: String,
    /// The vessel (IMC address).
    pub vessel: u16,
    /// Time of the request.
    pub now: UtcTime,
}

impl std::fmt::Debug for Opens {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Opens").field("vessel", &self.vessel).finish_non_exhaustive()
    }
}

impl Request for Opens {
    type Answer = Option<i64>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Option<i64>, Fault> {
        let Some(secret) = self.secret.trim().strip_prefix(LINK_PREFIX).and_then(Secret::parse) else {
            return Ok(None);
        };
        let sql = "SELECT id FROM token WHERE hash = ?1 AND person IS NULL AND vessel = ?2
                   AND (expires_us IS NULL OR expires_us > ?3)";
        let query = sqlx::query_scalar(sql).bind(secret.hash().to_vec()).bind(self.vessel);
        Ok(query.bind(self.now.micros()).fetch_optional(db).await?)
    }
}

/// Ends a vessel's link tokens. How many.
#[derive(Debug)]
pub struct End {
    /// The vessel (IMC address).
    pub vessel: u16,
    /// The token that stays valid.
    pub but: Option<i64>,
    /// Only those with this label; `None`: all.
    pub label: Option<String>,
    /// When the others end; those that end earlier still do. `None`: at once.
    pub at: Option<UtcTime>,
}

impl Request for End {
    type Answer = u64;

    async fn run(self, db: &mut SqliteConnection) -> Result<u64, Fault> {
        let Self { vessel, but, label, at } = self;
        let done = match at {
            None => {
                let sql = "DELETE FROM token WHERE person IS NULL AND vessel = ?1 AND id IS NOT ?2
                           AND (?3 IS NULL OR label = ?3)";
                sqlx::query(sql).bind(vessel).bind(but).bind(label).execute(db).await?
            }
            Some(at) => {
                let sql =
                    "UPDATE token SET expires_us = ?3 WHERE person IS NULL AND vessel = ?1 AND id IS NOT ?2
                           AND (expires_us IS NULL OR expires_us > ?3) AND (?4 IS NULL OR label = ?4)";
                sqlx::query(sql).bind(vessel).bind(but).bind(at.micros()).bind(label).execute(db).await?
            }
        };
        Ok(done.rows_affected())
    }
}

/// Vessels (IMC addresses) whose link some token opens at this time.
#[derive(Debug)]
pub struct Open(pub UtcTime);

impl Request for Open {
    type Answer = Vec<u16>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Vec<u16>, Fault> {
        let sql = "SELECT DISTINCT vessel FROM token WHERE person IS NULL AND (expires_us IS NULL OR expires_us > ?1)
                   ORDER BY vessel";
        let found: Vec<i64> = sqlx::query_scalar(sql).bind(self.0.micros()).fetch_all(db).await?;
        Ok(found.into_iter().filter_map(|vessel| u16::try_from(vessel).ok()).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::super::db::tests::fresh;
    use super::super::tokens::MakeLink;
    use super::*;

    const NOW: UtcTime = UtcTime::from_micros(1_000);
    const LATER: UtcTime = UtcTime::from_micros(2_000);

    fn make(vessel: u16) -> MakeLink {
        MakeLink { label: "fleet".to_owned(), vessel, days: None, now: NOW }
    }

    fn opens(made: &api::TokenMade, vessel: u16, now: UtcTime) -> Opens {
        Opens { secret: format!("{}\n", made.secret), vessel, now }
    }

    #[tokio::test]
    async fn an_older_token_opens_until_its_end_and_another_vessels_never() {
        let mut db = fresh().await;
        let (old, new) = (make(7).run(&mut db).await.unwrap(), make(7).run(&mut db).await.unwrap());
        let other = make(8).run(&mut db).await.unwrap();
        let end = End { vessel: 7, but: Some(new.id), label: None, at: Some(LATER) };
        assert_eq!(end.run(&mut db).await.unwrap(), 1);
        for (token, vessel, now, good) in [
            (&old, 7, NOW, true),
            (&old, 7, LATER, false),
            (&new, 7, LATER, true),
            (&old, 8, NOW, false),
            (&other, 8, LATER, true),
        ] {
            assert_eq!(
                opens(token, vessel, now).run(&mut db).await.unwrap().is_some(),
                good,
                "{} {vessel}",
                token.id
            );
        }
        assert!(!format!("{:?}", opens(&old, 7, NOW)).contains("lutra_link"));
    }

    #[tokio::test]
    async fn revoking_takes_all_links_of_one_vessel() {
        let mut db = fresh().await;
        for vessel in [7, 7, 8] {
            make(vessel).run(&mut db).await.unwrap();
        }
        assert_eq!(Open(NOW).run(&mut db).await.unwrap(), [7, 8]);
        assert_eq!(End { vessel: 7, but: None, label: None, at: None }.run(&mut db).await.unwrap(), 2);
        assert_eq!(Open(NOW).run(&mut db).await.unwrap(), [8]);
    }
}
