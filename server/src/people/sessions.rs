//! Sessions of browsers, and the browsers that people are known to use.

use super::db::Fault;
use super::persons;
use super::roles::{Principal, Via};
use super::secret::Secret;
use api::Session;
use rusqlite::{Connection, OptionalExtension as _, params};
use std::time::Duration;
use units::UtcTime;

/// Sessions a person has at most; the one that rested longest ends.
const SESSIONS: i64 = 50;
/// Known browsers a person has at most.
const DEVICES: i64 = 20;
/// `seen_us` is written anew only when it is older than this, µs.
const SEEN_EVERY_US: i64 = 60_000_000;

/// How long sessions last.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lifetime {
    /// Without a request.
    pub(crate) idle: Duration,
    /// However busy.
    pub(crate) whole: Duration,
}

impl Lifetime {
    fn idle_us(self) -> i64 {
        i64::try_from(self.idle.as_micros()).unwrap_or(i64::MAX)
    }

    fn whole_us(self) -> i64 {
        i64::try_from(self.whole.as_micros()).unwrap_or(i64::MAX)
    }
}

/// What a session's cookie stands for.
#[derive(Debug)]
pub(crate) struct Found {
    pub(crate) principal: Principal,
    /// Whether [`touch`] is due.
    pub(crate) stale: bool,
}

/// Begins a session and forgets those that are over.
pub(crate) fn begin(
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

/// Who is behind `secret`, unless the session is over.
pub(crate) fn find(
    db: &Connection,
    secret: &Secret,
    life: Lifetime,
    now: UtcTime,
) -> Result<Option<Found>, Fault> {
    let sql = "SELECT session.id, person.id, person.name, person.must_change, session.seen_us
               FROM session JOIN person ON person.id = session.person
               WHERE hash = ?1 AND seen_us >= ?2 AND session.created_us >= ?3";
    let now_us = now.micros();
    let row = db
        .prepare_cached(sql)?
        .query_row(params![secret.hash(), now_us - life.idle_us(), now_us - life.whole_us()], |row| {
            let names = (row.get::<_, i64>(0)?, row.get::<_, i64>(1)?, row.get::<_, String>(2)?);
            Ok((names, row.get::<_, bool>(3)?, row.get::<_, i64>(4)?))
        })
        .optional()?;
    let Some(((id, person, name), must_change_password, seen_us)) = row else { return Ok(None) };
    let via = Via::Session { id, csrf: secret.derived("csrf"), must_change_password };
    let principal = Principal { person, name, grants: persons::grants(db, person)?, via };
    Ok(Some(Found { principal, stale: now_us - seen_us >= SEEN_EVERY_US }))
}

/// Notes that a session was used.
pub(crate) fn touch(db: &Connection, id: i64, now: UtcTime) -> Result<(), Fault> {
    db.execute("UPDATE session SET seen_us = ?2 WHERE id = ?1", [id, now.micros()])?;
    Ok(())
}

/// Ends a session; of `person` only, when given.
///
/// # Errors
/// There is none such.
pub(crate) fn end(db: &Connection, id: i64, person: Option<i64>) -> Result<(), Fault> {
    let ended =
        db.execute("DELETE FROM session WHERE id = ?1 AND (?2 IS NULL OR person = ?2)", params![id, person])?;
    if ended == 0 { Err(Fault::Refused("There is no such session any more.".to_owned())) } else { Ok(()) }
}

/// Sessions, the last used first; of `person` only, when given.
pub(crate) fn list(db: &Connection, person: Option<i64>) -> Result<Vec<Session>, Fault> {
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
pub(crate) fn knows_device(db: &Connection, person: i64, secret: &Secret) -> Result<bool, Fault> {
    let sql = "SELECT 1 FROM device WHERE hash = ?1 AND person = ?2";
    Ok(db.prepare_cached(sql)?.exists(params![secret.hash(), person])?)
}

/// Notes a browser as one of this person's; those unused for longest are forgotten.
pub(crate) fn know_device(db: &Connection, person: i64, secret: &Secret, now: UtcTime) -> Result<(), Fault> {
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
    fn a_session_ends_when_it_rests_and_at_last() {
        let (db, person) = with_person();
        let secret = begin(&db, person, "127.0.0.1", "test", LIFE, at(0)).unwrap();
        let found = find(&db, &secret, LIFE, at(61)).unwrap().unwrap();
        assert!(found.stale && found.principal.name == "nils");
        let Via::Session { id, .. } = found.principal.via else { panic!("{found:?}") };
        assert!(find(&db, &secret, LIFE, at(101)).unwrap().is_none());
        for second in (0..=1_000).step_by(50) {
            touch(&db, id, at(second)).unwrap();
        }
        assert!(find(&db, &secret, LIFE, at(1_000)).unwrap().is_some());
        assert!(find(&db, &secret, LIFE, at(1_001)).unwrap().is_none());
    }

    #[test]
    fn a_revoked_session_is_over_and_only_its_own_can_be_revoked() {
        let (db, person) = with_person();
        let secret = begin(&db, person, "127.0.0.1", "test", LIFE, at(0)).unwrap();
        let id = list(&db, Some(person)).unwrap()[0].id;
        assert!(end(&db, id, Some(person + 1)).is_err());
        end(&db, id, Some(person)).unwrap();
        assert!(find(&db, &secret, LIFE, at(1)).unwrap().is_none());
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
