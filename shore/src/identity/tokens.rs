//! Tokens of scripts and of vessels' links.

use super::fault::Fault;
use super::persons;
use super::request::Request;
use super::secret::Secret;
use api::{NewToken, Token, TokenMade, say};
use sqlx::SqliteConnection;
use units::UtcTime;

/// Value of `token.vessel` for "all vessels".
const ALL: i64 = -1;
/// Longest life of a script's token, days.
pub const MAX_DAYS: u32 = 730;
/// Tokens kept at most.
const TOKENS: i64 = 10_000;
const DAY_US: i64 = 86_400_000_000;
/// Prefix of a script's token, also for programs that scan public code for secrets.
pub(super) const API_PREFIX: &str = "lutra_api_";
/// Prefix of a link's token.
pub(super) const LINK_PREFIX: &str = "lutra_link_";

/// Makes a token for a vessel's link.
#[derive(Debug)]
pub struct MakeLink {
    /// What it is for.
    pub label: String,
    /// The vessel (IMC address).
    pub vessel: u16,
    /// Days until it ends; `None`: never.
    pub days: Option<u32>,
    /// Time of the request.
    pub now: UtcTime,
}

impl Request for MakeLink {
    type Answer = TokenMade;

    async fn run(self, db: &mut SqliteConnection) -> Result<TokenMade, Fault> {
        let expires_us = self.days.map(|days| self.now.micros() + i64::from(days) * DAY_US);
        let opens = (None, i64::from(self.vessel), None);
        insert(db, LINK_PREFIX, &self.label, opens, self.now, expires_us).await
    }
}

/// Makes a token that acts for a person.
#[derive(Debug)]
pub struct Make {
    /// For whom it acts.
    pub person: i64,
    /// What it is for and may do.
    pub new: NewToken,
    /// Time of the request.
    pub now: UtcTime,
}

impl Request for Make {
    type Answer = TokenMade;

    async fn run(self, db: &mut SqliteConnection) -> Result<TokenMade, Fault> {
        make(db, self.person, &self.new, self.now).await
    }
}

/// Revokes a token; of `person` only, when given. Returns what it was for.
#[derive(Debug)]
pub struct Revoke {
    /// The number.
    pub id: i64,
    /// Only if it is this person's.
    pub person: Option<i64>,
}

impl Request for Revoke {
    type Answer = String;

    async fn run(self, db: &mut SqliteConnection) -> Result<String, Fault> {
        revoke(db, self.id, self.person).await
    }
}

/// Tokens, the newest first; of this person only, when given.
#[derive(Debug)]
pub struct List(pub Option<i64>);

impl Request for List {
    type Answer = Vec<Token>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Vec<Token>, Fault> {
        list(db, self.0).await
    }
}

/// Makes a token that acts for `person`.
///
/// # Errors
/// No label, an invalid life, or too many tokens.
async fn make(
    db: &mut SqliteConnection,
    person: i64,
    new: &NewToken,
    now: UtcTime,
) -> Result<TokenMade, Fault> {
    if !(1..=MAX_DAYS).contains(&new.days) {
        return Err(Fault::refused(say("A token lasts 1 to {most} days.").with("most", MAX_DAYS)));
    }
    let expires_us = now.micros() + i64::from(new.days) * DAY_US;
    let vessel = new.vessel.map_or(ALL, i64::from);
    let role = Some(persons::number(new.role));
    insert(db, API_PREFIX, &new.label, (Some(person), vessel, role), now, Some(expires_us)).await
}

async fn insert(
    db: &mut SqliteConnection,
    prefix: &str,
    label: &str,
    (person, vessel, role): (Option<i64>, i64, Option<i64>),
    now: UtcTime,
    expires_us: Option<i64>,
) -> Result<TokenMade, Fault> {
    let label = label.trim();
    if !(1..=100).contains(&label.chars().count()) || label.chars().any(char::is_control) {
        return Err(Fault::refused(say("A token needs a label of 1 to 100 characters: what is it for?")));
    }
    let count: i64 = sqlx::query_scalar("SELECT count(*) FROM token").fetch_one(&mut *db).await?;
    if count >= TOKENS {
        return Err(Fault::refused(say("There are {n} tokens: revoke some first.").with("n", TOKENS)));
    }
    let secret = Secret::random();
    let sql = "INSERT INTO token (hash, label, person, vessel, role, created_us, expires_us)
               VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)";
    let query = sqlx::query(sql).bind(secret.hash().to_vec()).bind(label).bind(person);
    let query = query.bind(vessel).bind(role).bind(now.micros()).bind(expires_us);
    let id = query.execute(db).await?.last_insert_rowid();
    Ok(TokenMade { id, secret: format!("{prefix}{}", secret.text()) })
}

/// Notes that a token was used.
pub(super) async fn touch(db: &mut SqliteConnection, id: i64, now: UtcTime) -> Result<(), Fault> {
    let sql = "UPDATE token SET used_us = ?2 WHERE id = ?1";
    sqlx::query(sql).bind(id).bind(now.micros()).execute(db).await?;
    Ok(())
}

/// Revokes a token; of `person` only, when given. Returns what it was for.
///
/// # Errors
/// There is no such token.
async fn revoke(db: &mut SqliteConnection, id: i64, person: Option<i64>) -> Result<String, Fault> {
    let sql = "DELETE FROM token WHERE id = ?1 AND (?2 IS NULL OR person = ?2) RETURNING label";
    let label: Option<String> = sqlx::query_scalar(sql).bind(id).bind(person).fetch_optional(db).await?;
    label.ok_or_else(|| Fault::refused(say("There is no such token any more.")))
}

/// Tokens, the newest first; of `person` only, when given.
pub(super) async fn list(db: &mut SqliteConnection, person: Option<i64>) -> Result<Vec<Token>, Fault> {
    let sql = "SELECT token.id, label, name, vessel, role, token.created_us, expires_us, used_us
               FROM token LEFT JOIN person ON person.id = token.person
               WHERE ?1 IS NULL OR person = ?1 ORDER BY token.id DESC";
    let rows = sqlx::query_as(sql).bind(person).fetch_all(db).await?;
    Ok(rows.into_iter().map(token).collect())
}

/// A row of [`list`].
type Row = (i64, String, Option<String>, i64, Option<i64>, i64, Option<i64>, Option<i64>);

fn token((id, label, person, vessel, role, created_us, expires_us, used_us): Row) -> Token {
    let (vessel, role) = (u16::try_from(vessel).ok(), role.and_then(persons::role));
    Token { id, label, person, vessel, role, created_us, expires_us, used_us }
}

#[cfg(test)]
mod tests {
    use super::super::db::tests::fresh;
    use super::*;
    use api::Role;

    const NOW: UtcTime = UtcTime::from_micros(1_000);

    #[tokio::test]
    async fn a_revoked_token_is_gone_and_only_its_own_person_can_revoke_it() {
        let mut db = fresh().await;
        let nils = persons::add(&mut db, "nils", "x", false, NOW).await.unwrap();
        let new = NewToken { label: "grafana".to_owned(), role: Role::Viewer, vessel: None, days: 1 };
        let made = make(&mut db, nils, &new, NOW).await.unwrap();
        assert!(revoke(&mut db, made.id, Some(nils + 1)).await.is_err());
        assert_eq!(revoke(&mut db, made.id, Some(nils)).await.unwrap(), "grafana");
        assert!(list(&mut db, None).await.unwrap().is_empty());
    }

    #[tokio::test]
    async fn a_token_needs_a_label_and_an_end() {
        let mut db = fresh().await;
        let nils = persons::add(&mut db, "nils", "x", false, NOW).await.unwrap();
        let new =
            |label: &str, days| NewToken { label: label.to_owned(), role: Role::Viewer, vessel: None, days };
        for (label, days) in [("", 1), ("a\nb", 1), ("grafana", 0), ("grafana", MAX_DAYS + 1)] {
            assert!(make(&mut db, nils, &new(label, days), NOW).await.is_err(), "{label} {days}");
        }
    }
}
