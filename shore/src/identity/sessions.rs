//! Sessions of browsers, and the browsers that people are known to use.

use super::fault::Fault;
use super::request::Request;
use super::secret::Secret;
use api::{Session, say};
use sqlx::SqliteConnection;
use std::time::Duration;
use units::UtcTime;

/// Most sessions of a person; the one idle for longest ends.
const SESSIONS: i64 = 50;
/// Most known browsers of a person.
const DEVICES: i64 = 20;

/// How long sessions last.
#[derive(Debug, Clone, Copy)]
pub struct Lifetime {
    /// Without a request.
    pub idle: Duration,
    /// However busy.
    pub whole: Duration,
}

impl Lifetime {
    pub(super) fn idle_us(self) -> i64 {
        i64::try_from(self.idle.as_micros()).unwrap_or(i64::MAX)
    }

    pub(super) fn whole_us(self) -> i64 {
        i64::try_from(self.whole.as_micros()).unwrap_or(i64::MAX)
    }
}

/// Ends a session; of `person` only, when given.
#[derive(Debug)]
pub struct End {
    /// The number.
    pub id: i64,
    /// Only if it is this person's.
    pub person: Option<i64>,
}

impl Request for End {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        end(db, self.id, self.person).await
    }
}

/// Sessions, the last used first; of this person only, when given.
#[derive(Debug)]
pub struct List(pub Option<i64>);

impl Request for List {
    type Answer = Vec<Session>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Vec<Session>, Fault> {
        list(db, self.0).await
    }
}

/// Begins a session and forgets those that are over.
pub(super) async fn begin(
    db: &mut SqliteConnection,
    person: i64,
    address: &str,
    agent: &str,
    life: Lifetime,
    now: UtcTime,
) -> Result<Secret, Fault> {
    let secret = Secret::random();
    let now_us = now.micros();
    sqlx::query("DELETE FROM session WHERE seen_us < ?1 OR created_us < ?2")
        .bind(now_us - life.idle_us())
        .bind(now_us - life.whole_us())
        .execute(&mut *db)
        .await?;
    let agent: String = agent.chars().filter(|letter| !letter.is_control()).take(200).collect();
    let sql = "INSERT INTO session (hash, person, created_us, seen_us, address, agent) VALUES (?1, ?2, ?3, ?3, ?4, ?5)";
    let query = sqlx::query(sql).bind(secret.hash().to_vec()).bind(person).bind(now_us);
    query.bind(address).bind(agent).execute(&mut *db).await?;
    let sql = "DELETE FROM session WHERE person = ?1 AND id NOT IN
               (SELECT id FROM session WHERE person = ?1 ORDER BY seen_us DESC, id DESC LIMIT ?2)";
    sqlx::query(sql).bind(person).bind(SESSIONS).execute(db).await?;
    Ok(secret)
}

/// Notes that a session was used.
pub(super) async fn touch(db: &mut SqliteConnection, id: i64, now: UtcTime) -> Result<(), Fault> {
    let sql = "UPDATE session SET seen_us = ?2 WHERE id = ?1";
    sqlx::query(sql).bind(id).bind(now.micros()).execute(db).await?;
    Ok(())
}

/// Ends a session; of `person` only, when given.
///
/// # Errors
/// There is no such session.
pub(super) async fn end(db: &mut SqliteConnection, id: i64, person: Option<i64>) -> Result<(), Fault> {
    let sql = "DELETE FROM session WHERE id = ?1 AND (?2 IS NULL OR person = ?2)";
    let ended = sqlx::query(sql).bind(id).bind(person).execute(db).await?;
    if ended.rows_affected() == 0 {
        Err(Fault::refused(say("There is no such session any more.")))
    } else {
        Ok(())
    }
}

/// Sessions, the last used first; of `person` only, when given.
pub(super) async fn list(db: &mut SqliteConnection, person: Option<i64>) -> Result<Vec<Session>, Fault> {
    let sql = "SELECT session.id, name, session.created_us, seen_us, address, agent
               FROM session JOIN person ON person.id = session.person
               WHERE ?1 IS NULL OR person = ?1 ORDER BY seen_us DESC, session.id DESC LIMIT 1000";
    let rows = sqlx::query_as(sql).bind(person).fetch_all(db).await?;
    let session = |(id, person, created_us, seen_us, address, agent)| Session {
        id,
        person,
        created_us,
        seen_us,
        address,
        agent,
    };
    Ok(rows.into_iter().map(session).collect())
}

/// Whether this person was logged in from the browser with this cookie before.
pub(super) async fn knows_device(
    db: &mut SqliteConnection,
    person: i64,
    secret: &Secret,
) -> Result<bool, Fault> {
    let sql = "SELECT count(*) FROM device WHERE hash = ?1 AND person = ?2";
    let count: i64 = sqlx::query_scalar(sql).bind(secret.hash().to_vec()).bind(person).fetch_one(db).await?;
    Ok(count > 0)
}

/// Notes a browser as one of this person's; those unused for longest are forgotten.
pub(super) async fn know_device(
    db: &mut SqliteConnection,
    person: i64,
    secret: &Secret,
    now: UtcTime,
) -> Result<(), Fault> {
    let sql = "INSERT OR REPLACE INTO device (hash, person, used_us) VALUES (?1, ?2, ?3)";
    let query = sqlx::query(sql).bind(secret.hash().to_vec()).bind(person).bind(now.micros());
    query.execute(&mut *db).await?;
    let sql = "DELETE FROM device WHERE person = ?1 AND hash NOT IN
               (SELECT hash FROM device WHERE person = ?1 ORDER BY used_us DESC LIMIT ?2)";
    sqlx::query(sql).bind(person).bind(DEVICES).execute(db).await?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::db::tests::fresh;
    use super::super::persons;
    use super::*;

    const LIFE: Lifetime = Lifetime { idle: Duration::from_secs(100), whole: Duration::from_secs(1_000) };

    fn at(seconds: i64) -> UtcTime {
        UtcTime::from_micros(seconds * 1_000_000)
    }

    async fn with_person() -> (SqliteConnection, i64) {
        let mut db = fresh().await;
        let person = persons::add(&mut db, "nils", "x", false, at(0)).await.unwrap();
        (db, person)
    }

    #[tokio::test]
    async fn only_its_own_person_can_end_a_session() {
        let (mut db, person) = with_person().await;
        begin(&mut db, person, "127.0.0.1", "test", LIFE, at(0)).await.unwrap();
        let id = list(&mut db, Some(person)).await.unwrap()[0].id;
        assert!(end(&mut db, id, Some(person + 1)).await.is_err());
        end(&mut db, id, Some(person)).await.unwrap();
        assert!(end(&mut db, id, Some(person)).await.is_err());
    }

    #[tokio::test]
    async fn sessions_and_devices_are_bounded() {
        let (mut db, person) = with_person().await;
        let first = Secret::random();
        know_device(&mut db, person, &first, at(0)).await.unwrap();
        for second in 1..=60 {
            begin(&mut db, person, "127.0.0.1", "test", LIFE, at(second)).await.unwrap();
            know_device(&mut db, person, &Secret::random(), at(second)).await.unwrap();
        }
        assert_eq!(list(&mut db, None).await.unwrap().len(), 50);
        assert!(!knows_device(&mut db, person, &first).await.unwrap());
    }

    #[tokio::test]
    async fn what_is_kept_is_no_secret() {
        let (mut db, person) = with_person().await;
        let secret = begin(&mut db, person, "127.0.0.1", "test", LIFE, at(0)).await.unwrap();
        let kept: Vec<u8> = sqlx::query_scalar("SELECT hash FROM session").fetch_one(&mut db).await.unwrap();
        assert_ne!(super::super::secret::Secret::parse(&secret.text()).unwrap().text().into_bytes(), kept);
        assert_eq!(kept, secret.hash());
    }
}
