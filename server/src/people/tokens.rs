//! Tokens of scripts and of vessels' links.

use super::db::Fault;
use super::persons;
use super::roles::{Principal, Via};
use super::secret::Secret;
use api::{NewToken, Token, TokenMade};
use rusqlite::{Connection, OptionalExtension as _, params};
use units::UtcTime;

/// How `token.vessel` says "all vessels".
const ALL: i64 = -1;
/// The longest that a script's token may last, days.
pub(crate) const MAX_DAYS: u32 = 730;
/// Tokens kept at most.
const TOKENS: i64 = 10_000;
/// `used_us` is written anew only when it is older than this, µs.
const USED_EVERY_US: i64 = 60_000_000;
const DAY_US: i64 = 86_400_000_000;
/// By which a script's token is recognised, also by programs that look for secrets in public code.
const API_PREFIX: &str = "lutra_api_";
/// By which a link's token is recognised.
const LINK_PREFIX: &str = "lutra_link_";

/// A vessel's link token to be made.
#[derive(Debug)]
pub(crate) struct NewLink<'a> {
    pub(crate) label: &'a str,
    pub(crate) vessel: u16,
    /// Days until it ends; `None`: never.
    pub(crate) days: Option<u32>,
}

/// What a token stands for.
#[derive(Debug)]
pub(crate) struct Found<T> {
    pub(crate) id: i64,
    pub(crate) who: T,
    /// Whether [`touch`] is due.
    pub(crate) stale: bool,
}

/// Makes a token that acts for `person`.
///
/// # Errors
/// No label, no sensible time, too many tokens.
pub(crate) fn make(db: &Connection, person: i64, new: &NewToken, now: UtcTime) -> Result<TokenMade, Fault> {
    if !(1..=MAX_DAYS).contains(&new.days) {
        return Err(Fault::Refused(format!("A token lasts 1 to {MAX_DAYS} days.")));
    }
    let expires_us = now.micros() + i64::from(new.days) * DAY_US;
    let vessel = new.vessel.map_or(ALL, i64::from);
    let role = Some(persons::number(new.role));
    insert(db, API_PREFIX, &new.label, (Some(person), vessel, role), now, Some(expires_us))
}

/// Makes a token by which a vessel's link comes in.
///
/// # Errors
/// No label, too many tokens.
pub(crate) fn make_link(db: &Connection, new: &NewLink<'_>, now: UtcTime) -> Result<TokenMade, Fault> {
    let expires_us = new.days.map(|days| now.micros() + i64::from(days) * DAY_US);
    insert(db, LINK_PREFIX, new.label, (None, i64::from(new.vessel), None), now, expires_us)
}

fn insert(
    db: &Connection,
    prefix: &str,
    label: &str,
    (person, vessel, role): (Option<i64>, i64, Option<i64>),
    now: UtcTime,
    expires_us: Option<i64>,
) -> Result<TokenMade, Fault> {
    let label = label.trim();
    if !(1..=100).contains(&label.chars().count()) || label.chars().any(char::is_control) {
        return Err(Fault::Refused(
            "A token needs a label of 1 to 100 characters: what is it for?".to_owned(),
        ));
    }
    let count: i64 = db.query_row("SELECT count(*) FROM token", [], |row| row.get(0))?;
    if count >= TOKENS {
        return Err(Fault::Refused(format!("There are {TOKENS} tokens: revoke some first.")));
    }
    let secret = Secret::random();
    db.execute(
        "INSERT INTO token (hash, label, person, vessel, role, created_us, expires_us)
         VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)",
        params![secret.hash(), label, person, vessel, role, now.micros(), expires_us],
    )?;
    Ok(TokenMade { id: db.last_insert_rowid(), secret: format!("{prefix}{}", secret.text()) })
}

/// For whom the script with this token acts.
pub(crate) fn find(db: &Connection, text: &str, now: UtcTime) -> Result<Option<Found<Principal>>, Fault> {
    let Some(secret) = text.strip_prefix(API_PREFIX).and_then(Secret::parse) else { return Ok(None) };
    let sql = "SELECT token.id, person.id, person.name, vessel, role, used_us
               FROM token JOIN person ON person.id = token.person
               WHERE hash = ?1 AND expires_us > ?2 AND NOT must_change";
    let row = db
        .prepare_cached(sql)?
        .query_row(params![secret.hash(), now.micros()], |row| {
            let names = (row.get::<_, i64>(0)?, row.get::<_, i64>(1)?, row.get::<_, String>(2)?);
            Ok((names, row.get::<_, i64>(3)?, row.get::<_, i64>(4)?, row.get::<_, Option<i64>>(5)?))
        })
        .optional()?;
    let Some(((id, person, name), vessel, role, used_us)) = row else { return Ok(None) };
    let Some(role) = persons::role(role) else { return Ok(None) };
    let grants = persons::grants(db, person)?.limited(u16::try_from(vessel).ok(), role);
    let who = Principal { person, name, grants, via: Via::Token };
    Ok(Some(Found { id, who, stale: is_stale(used_us, now) }))
}

/// The vessel (IMC address) whose link this token opens.
pub(crate) fn find_link(db: &Connection, text: &str, now: UtcTime) -> Result<Option<Found<u16>>, Fault> {
    let Some(secret) = text.strip_prefix(LINK_PREFIX).and_then(Secret::parse) else { return Ok(None) };
    let sql = "SELECT id, vessel, used_us FROM token
               WHERE hash = ?1 AND person IS NULL AND (expires_us IS NULL OR expires_us > ?2)";
    let row = db
        .prepare_cached(sql)?
        .query_row(params![secret.hash(), now.micros()], |row| {
            Ok(Found { id: row.get(0)?, who: row.get::<_, u16>(1)?, stale: is_stale(row.get(2)?, now) })
        })
        .optional()?;
    Ok(row)
}

/// Vessels whose link came in at some time, and for which it is open still.
pub(crate) fn linked(db: &Connection, now: UtcTime) -> Result<Vec<u16>, Fault> {
    let mut query = db.prepare_cached(
        "SELECT DISTINCT vessel FROM token WHERE person IS NULL AND used_us IS NOT NULL
         AND (expires_us IS NULL OR expires_us > ?1) ORDER BY vessel",
    )?;
    let rows = query.query_map([now.micros()], |row| row.get(0))?;
    Ok(rows.collect::<Result<_, _>>()?)
}

fn is_stale(used_us: Option<i64>, now: UtcTime) -> bool {
    used_us.is_none_or(|used_us| now.micros() - used_us >= USED_EVERY_US)
}

/// Notes that a token was used.
pub(crate) fn touch(db: &Connection, id: i64, now: UtcTime) -> Result<(), Fault> {
    db.execute("UPDATE token SET used_us = ?2 WHERE id = ?1", [id, now.micros()])?;
    Ok(())
}

/// Revokes a token; of `person` only, when given. Returns what it was for.
///
/// # Errors
/// There is none such.
pub(crate) fn revoke(db: &Connection, id: i64, person: Option<i64>) -> Result<String, Fault> {
    let sql = "DELETE FROM token WHERE id = ?1 AND (?2 IS NULL OR person = ?2) RETURNING label";
    let label = db.query_row(sql, params![id, person], |row| row.get(0)).optional()?;
    label.ok_or_else(|| Fault::Refused("There is no such token any more.".to_owned()))
}

/// Tokens, the newest first; of `person` only, when given.
pub(crate) fn list(db: &Connection, person: Option<i64>) -> Result<Vec<Token>, Fault> {
    let mut query = db.prepare(
        "SELECT token.id, label, name, vessel, role, token.created_us, expires_us, used_us
         FROM token LEFT JOIN person ON person.id = token.person
         WHERE ?1 IS NULL OR person = ?1 ORDER BY token.id DESC",
    )?;
    let rows = query.query_map([person], |row| {
        Ok(Token {
            id: row.get(0)?,
            label: row.get(1)?,
            person: row.get(2)?,
            vessel: u16::try_from(row.get::<_, i64>(3)?).ok(),
            role: row.get::<_, Option<i64>>(4)?.and_then(persons::role),
            created_us: row.get(5)?,
            expires_us: row.get(6)?,
            used_us: row.get(7)?,
        })
    })?;
    Ok(rows.collect::<Result<_, _>>()?)
}

#[cfg(test)]
mod tests {
    use super::super::db::tests::fresh;
    use super::*;
    use api::Role;

    const NOW: UtcTime = UtcTime::from_micros(1_000);

    fn with_operator() -> (Connection, i64) {
        let db = fresh();
        let admin = persons::add(&db, "admin", "x", false, NOW).unwrap();
        persons::set_permission(&db, admin, None, Some(Role::Admin)).unwrap();
        let nils = persons::add(&db, "nils", "x", false, NOW).unwrap();
        persons::set_permission(&db, nils, None, Some(Role::Operator)).unwrap();
        (db, nils)
    }

    fn new(role: Role, vessel: Option<u16>) -> NewToken {
        NewToken { label: "grafana".to_owned(), role, vessel, days: 1 }
    }

    #[test]
    fn a_token_acts_within_its_scope_until_it_ends() {
        let (db, nils) = with_operator();
        let made = make(&db, nils, &new(Role::Viewer, Some(7)), NOW).unwrap();
        let found = find(&db, &made.secret, NOW).unwrap().unwrap();
        assert_eq!(found.who.grants.on(7), Some(Role::Viewer));
        assert_eq!(found.who.grants.on(8), None);
        let later = UtcTime::from_micros(NOW.micros() + DAY_US);
        assert!(find(&db, &made.secret, later).unwrap().is_none());
        assert!(find(&db, "lutra_api_rubbish", NOW).unwrap().is_none());
    }

    #[test]
    fn a_token_loses_what_its_person_loses() {
        let (db, nils) = with_operator();
        let made = make(&db, nils, &new(Role::Admin, None), NOW).unwrap();
        let role = |db: &Connection| find(db, &made.secret, NOW).unwrap().unwrap().who.grants.everywhere();
        assert_eq!(role(&db), Some(Role::Operator));
        persons::set_permission(&db, nils, None, Some(Role::Viewer)).unwrap();
        assert_eq!(role(&db), Some(Role::Viewer));
        persons::remove(&db, "nils").unwrap();
        assert!(find(&db, &made.secret, NOW).unwrap().is_none());
    }

    #[test]
    fn a_vessel_is_expected_while_a_token_that_it_used_is_valid() {
        let (db, nils) = with_operator();
        make(&db, nils, &new(Role::Viewer, Some(9)), NOW).unwrap();
        let link = |vessel, days| make_link(&db, &NewLink { label: "link", vessel, days }, NOW).unwrap();
        let (_, ends, stays) = (link(6, None), link(7, Some(1)), link(8, None));
        assert!(linked(&db, NOW).unwrap().is_empty(), "none came in yet");
        for id in [ends.id, stays.id] {
            touch(&db, id, NOW).unwrap();
        }
        assert_eq!(linked(&db, NOW).unwrap(), [7, 8]);
        let later = UtcTime::from_micros(NOW.micros() + DAY_US);
        assert_eq!(linked(&db, later).unwrap(), [8]);
        revoke(&db, stays.id, None).unwrap();
        assert!(linked(&db, later).unwrap().is_empty());
    }

    #[test]
    fn link_and_api_tokens_do_not_open_each_others_door() {
        let (db, nils) = with_operator();
        let link = NewLink { label: "otter 1", vessel: 2068, days: None };
        let link = make_link(&db, &link, NOW).unwrap().secret;
        let script = make(&db, nils, &new(Role::Viewer, None), NOW).unwrap().secret;
        assert_eq!(find_link(&db, &link, NOW).unwrap().unwrap().who, 2068);
        assert!(find(&db, &link, NOW).unwrap().is_none() && find_link(&db, &script, NOW).unwrap().is_none());
        let disguised = link.replace(LINK_PREFIX, API_PREFIX);
        assert!(find(&db, &disguised, NOW).unwrap().is_none());
        let disguised = script.replace(API_PREFIX, LINK_PREFIX);
        assert!(find_link(&db, &disguised, NOW).unwrap().is_none());
    }

    #[test]
    fn a_revoked_token_opens_nothing() {
        let (db, nils) = with_operator();
        let made = make(&db, nils, &new(Role::Viewer, None), NOW).unwrap();
        assert!(revoke(&db, made.id, Some(nils + 1)).is_err());
        assert_eq!(revoke(&db, made.id, Some(nils)).unwrap(), "grafana");
        assert!(find(&db, &made.secret, NOW).unwrap().is_none());
        assert!(list(&db, None).unwrap().is_empty());
    }
}
