//! Tokens of scripts and of vessels' links.

use super::db::Fault;
use super::persons;
use super::secret::Secret;
use api::{NewToken, Token, TokenMade};
use rusqlite::{Connection, OptionalExtension as _, params};
use units::UtcTime;

/// How `token.vessel` says "all vessels".
const ALL: i64 = -1;
/// The longest that a script's token may last, days.
pub const MAX_DAYS: u32 = 730;
/// Tokens kept at most.
const TOKENS: i64 = 10_000;
const DAY_US: i64 = 86_400_000_000;
/// By which a script's token is recognised, also by programs that look for secrets in public code.
pub(crate) const API_PREFIX: &str = "lutra_api_";
/// By which a link's token is recognised.
pub(crate) const LINK_PREFIX: &str = "lutra_link_";

/// A vessel's link token to be made.
#[derive(Debug)]
pub struct NewLink<'a> {
    pub label: &'a str,
    pub vessel: u16,
    /// Days until it ends; `None`: never.
    pub days: Option<u32>,
}

/// Makes a token that acts for `person`.
///
/// # Errors
/// No label, no sensible time, too many tokens.
pub fn make(db: &Connection, person: i64, new: &NewToken, now: UtcTime) -> Result<TokenMade, Fault> {
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
pub fn make_link(db: &Connection, new: &NewLink<'_>, now: UtcTime) -> Result<TokenMade, Fault> {
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

/// Notes that a token was used.
pub fn touch(db: &Connection, id: i64, now: UtcTime) -> Result<(), Fault> {
    db.execute("UPDATE token SET used_us = ?2 WHERE id = ?1", [id, now.micros()])?;
    Ok(())
}

/// Revokes a token; of `person` only, when given. Returns what it was for.
///
/// # Errors
/// There is none such.
pub fn revoke(db: &Connection, id: i64, person: Option<i64>) -> Result<String, Fault> {
    let sql = "DELETE FROM token WHERE id = ?1 AND (?2 IS NULL OR person = ?2) RETURNING label";
    let label = db.query_row(sql, params![id, person], |row| row.get(0)).optional()?;
    label.ok_or_else(|| Fault::Refused("There is no such token any more.".to_owned()))
}

/// Tokens, the newest first; of `person` only, when given.
pub fn list(db: &Connection, person: Option<i64>) -> Result<Vec<Token>, Fault> {
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

    #[test]
    fn a_revoked_token_is_gone_and_only_its_own_person_can_revoke_it() {
        let db = fresh();
        let nils = persons::add(&db, "nils", "x", false, NOW).unwrap();
        let new = NewToken { label: "grafana".to_owned(), role: Role::Viewer, vessel: None, days: 1 };
        let made = make(&db, nils, &new, NOW).unwrap();
        assert!(revoke(&db, made.id, Some(nils + 1)).is_err());
        assert_eq!(revoke(&db, made.id, Some(nils)).unwrap(), "grafana");
        assert!(list(&db, None).unwrap().is_empty());
    }

    #[test]
    fn a_token_needs_a_label_and_an_end() {
        let db = fresh();
        let nils = persons::add(&db, "nils", "x", false, NOW).unwrap();
        let new =
            |label: &str, days| NewToken { label: label.to_owned(), role: Role::Viewer, vessel: None, days };
        for (label, days) in [("", 1), ("a\nb", 1), ("grafana", 0), ("grafana", MAX_DAYS + 1)] {
            assert!(make(&db, nils, &new(label, days), NOW).is_err(), "{label} {days}");
        }
    }
}
