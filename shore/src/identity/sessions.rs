//! Sessions of browsers, and the browsers that people are known to use.

use super::db::Fault;
use super::secret::Secret;
use api::Session;
use rusqlite::{Connection, params};
use std::time::Duration;
use units::UtcTime;

/// Sessions a person has at most; the one that rested longest ends.
const SESSIONS: i64 = 50;
/// Known browsers a person has at most.
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
    pub(crate) fn idle_us(self) -> i64 {
        i64::try_from(self.idle.as_micros()).unwrap_or(i64::MAX)
    }

    pub(crate) fn whole_us(self) -> i64 {
        i64::try_from(self.whole.as_micros()).unwrap_or(i64::MAX)
    }
}

/// Begins a session and forgets those that are over.
pub fn begin(
    db: &Connection,
    person: i64,
    address: &str,
    agent: &str,
    life: Lifetime,
    now: UtcTime,
) -> Result<Secret, Fault> {
    let secret = Secret::random();
    let now_us = now.micros();
    db.execute(
        "DELETE FROM session WHERE seen_us < ?1 OR created_us < ?2",
        [now_us - life.idle_us(), now_us - life.whole_us()],
    )?;
    let agent: String = agent.chars().filter(|letter| !letter.is_control()).take(200).collect();
    db.execute(
        "INSERT INTO session (hash, person, created_us, seen_us, address, agent) VALUES (?1, ?2, ?3, ?3, ?4, ?5)",
        params![secret.hash(), person, now_us, address, agent],
    )?;
    db.execute(
        "DELETE FROM session WHERE person = ?1 AND id NOT IN
         (SELECT id FROM session WHERE person = ?1 ORDER BY seen_us DESC, id DESC LIMIT ?2)",
        [person, SESSIONS],
    )?;
    Ok(secret)
}

/// Notes that a session was used.
pub fn touch(db: &Connection, id: i64, now: UtcTime) -> Result<(), Fault> {
    db.execute("UPDATE session SET seen_us = ?2 WHERE id = ?1", [id, now.micros()])?;
    Ok(())
}

/// Ends a session; of `person` only, when given.
///
/// # Errors
/// There is none such.
pub fn end(db: &Connection, id: i64, person: Option<i64>) -> Result<(), Fault> {
    let ended =
        db.execute("DELETE FROM session WHERE id = ?1 AND (?2 IS NULL OR person = ?2)", params![id, person])?;
    if ended == 0 { Err(Fault::Refused("There is no such session any more.".to_owned())) } else { Ok(()) }
}

/// Sessions, the last used first; of `person` only, when given.
pub fn list(db: &Connection, person: Option<i64>) -> Result<Vec<Session>, Fault> {
    let mut query = db.prepare(
        "SELECT session.id, name, session.created_us, seen_us, address, agent
         FROM session JOIN person ON person.id = session.person
         WHERE ?1 IS NULL OR person = ?1 ORDER BY seen_us DESC, session.id DESC LIMIT 1000",
    )?;
    let rows = query.query_map([person], |row| {
        Ok(Session {
            id: row.get(0)?,
            person: row.get(1)?,
            created_us: row.get(2)?,
            seen_us: row.get(3)?,
            address: row.get(4)?,
            agent: row.get(5)?,
        })
    })?;
    Ok(rows.collect::<Result<_, _>>()?)
}

/// Whether this person was logged in from the browser with this cookie before.
pub fn knows_device(db: &Connection, person: i64, secret: &Secret) -> Result<bool, Fault> {
    let sql = "SELECT 1 FROM device WHERE hash = ?1 AND person = ?2";
    Ok(db.prepare_cached(sql)?.exists(params![secret.hash(), person])?)
}

/// Notes a browser as one of this person's; those unused for longest are forgotten.
pub fn know_device(db: &Connection, person: i64, secret: &Secret, now: UtcTime) -> Result<(), Fault> {
    db.execute(
        "INSERT OR REPLACE INTO device (hash, person, used_us) VALUES (?1, ?2, ?3)",
        params![secret.hash(), person, now.micros()],
    )?;
    db.execute(
        "DELETE FROM device WHERE person = ?1 AND hash NOT IN
         (SELECT hash FROM device WHERE person = ?1 ORDER BY used_us DESC LIMIT ?2)",
        [person, DEVICES],
    )?;
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

    fn with_person() -> (Connection, i64) {
        let db = fresh();
        let person = persons::add(&db, "nils", "x", false, at(0)).unwrap();
        (db, person)
    }

    #[test]
    fn only_its_own_person_can_end_a_session() {
        let (db, person) = with_person();
        begin(&db, person, "127.0.0.1", "test", LIFE, at(0)).unwrap();
        let id = list(&db, Some(person)).unwrap()[0].id;
        assert!(end(&db, id, Some(person + 1)).is_err());
        end(&db, id, Some(person)).unwrap();
        assert!(end(&db, id, Some(person)).is_err());
    }

    #[test]
    fn sessions_and_devices_are_bounded() {
        let (db, person) = with_person();
        let first = Secret::random();
        know_device(&db, person, &first, at(0)).unwrap();
        for second in 1..=60 {
            begin(&db, person, "127.0.0.1", "test", LIFE, at(second)).unwrap();
            know_device(&db, person, &Secret::random(), at(second)).unwrap();
        }
        assert_eq!(list(&db, None).unwrap().len(), 50);
        assert!(!knows_device(&db, person, &first).unwrap());
    }

    #[test]
    fn what_is_kept_is_no_secret() {
        let (db, person) = with_person();
        let secret = begin(&db, person, "127.0.0.1", "test", LIFE, at(0)).unwrap();
        let kept: Vec<u8> = db.query_row("SELECT hash FROM session", [], |row| row.get(0)).unwrap();
        assert_ne!(super::super::secret::Secret::parse(&secret.text()).unwrap().text().into_bytes(), kept);
        assert_eq!(kept, secret.hash());
    }
}
