//! Accounts in the database.

use super::db::Fault;
use super::roles::Grants;
use api::{Permission, Person, Role};
use rusqlite::{Connection, OptionalExtension as _, params};
use units::UtcTime;

/// How `permission.vessel` says "all vessels".
const ALL: i64 = -1;

/// What a login needs to know of a person.
#[derive(Debug)]
pub struct Account {
    pub id: i64,
    pub name: String,
    /// The password as it is kept.
    pub password: String,
    pub must_change: bool,
}

/// Adds a person without any permission.
///
/// # Errors
/// The name is taken or no name.
pub fn add(
    db: &Connection,
    name: &str,
    password_hash: &str,
    must_change: bool,
    now: UtcTime,
) -> Result<i64, Fault> {
    check_name(name)?;
    if find(db, name)?.is_some() {
        return Err(Fault::Refused(format!("There is a person {name} already.")));
    }
    db.execute(
        "INSERT INTO person (name, password, must_change, created_us) VALUES (?1, ?2, ?3, ?4)",
        params![name, password_hash, must_change, now.micros()],
    )?;
    Ok(db.last_insert_rowid())
}

/// The person of this name, capitals or not.
pub fn find(db: &Connection, name: &str) -> Result<Option<Account>, Fault> {
    let read = |row: &rusqlite::Row<'_>| {
        Ok(Account { id: row.get(0)?, name: row.get(1)?, password: row.get(2)?, must_change: row.get(3)? })
    };
    let sql = "SELECT id, name, password, must_change FROM person WHERE name = ?1";
    Ok(db.prepare_cached(sql)?.query_row([name], read).optional()?)
}

/// The person of this name.
///
/// # Errors
/// There is none.
pub fn known(db: &Connection, name: &str) -> Result<Account, Fault> {
    find(db, name)?.ok_or_else(|| Fault::Refused(format!("There is no person {name}.")))
}

/// Removes a person with sessions and tokens.
///
/// # Errors
/// There is none of this name, or nobody would be left to manage the server.
pub fn remove(db: &Connection, name: &str) -> Result<(), Fault> {
    let account = known(db, name)?;
    db.execute("DELETE FROM person WHERE id = ?1", [account.id])?;
    somebody_manages(db)
}

/// Sets a password; all sessions of the person but `keep` end, and so do the tokens of their scripts: who knew the old
/// password may have made some. Those that were made beside a one-time password stay when that is changed.
pub fn set_password(
    db: &Connection,
    person: i64,
    password_hash: &str,
    must_change: bool,
    keep: Option<i64>,
) -> Result<(), Fault> {
    db.execute(
        "DELETE FROM token WHERE person = ?1 AND NOT (SELECT must_change FROM person WHERE id = ?1)",
        [person],
    )?;
    db.execute(
        "UPDATE person SET password = ?2, must_change = ?3 WHERE id = ?1",
        params![person, password_hash, must_change],
    )?;
    db.execute("DELETE FROM session WHERE person = ?1 AND id IS NOT ?2", params![person, keep])?;
    Ok(())
}

/// Gives or, with `None`, takes a role on a vessel (`None`: all vessels).
///
/// # Errors
/// Nobody would be left to manage the server.
pub fn set_permission(
    db: &Connection,
    person: i64,
    vessel: Option<u16>,
    role: Option<Role>,
) -> Result<(), Fault> {
    let vessel = vessel.map_or(ALL, i64::from);
    match role {
        None => db.execute("DELETE FROM permission WHERE person = ?1 AND vessel = ?2", [person, vessel])?,
        Some(role) => db.execute(
            "INSERT OR REPLACE INTO permission (person, vessel, role) VALUES (?1, ?2, ?3)",
            [person, vessel, number(role)],
        )?,
    };
    somebody_manages(db)
}

/// What a person may do where.
pub fn permissions(db: &Connection, person: i64) -> Result<Vec<Permission>, Fault> {
    let mut query =
        db.prepare_cached("SELECT vessel, role FROM permission WHERE person = ?1 ORDER BY vessel")?;
    let rows = query.query_map([person], |row| Ok((row.get::<_, i64>(0)?, row.get::<_, i64>(1)?)))?;
    let mut permissions = Vec::new();
    for row in rows {
        let (vessel, role_number) = row?;
        if let Some(role) = role(role_number) {
            permissions.push(Permission { vessel: u16::try_from(vessel).ok(), role });
        }
    }
    Ok(permissions)
}

/// As [`permissions`], to decide by.
pub fn grants(db: &Connection, person: i64) -> Result<Grants, Fault> {
    Ok(Grants::new(&permissions(db, person)?))
}

/// All people by name.
pub fn list(db: &Connection) -> Result<Vec<Person>, Fault> {
    let mut query = db.prepare("SELECT id, name, must_change, created_us FROM person ORDER BY name")?;
    let rows = query.query_map([], |row| {
        let person = Person {
            name: row.get(1)?,
            permissions: Vec::new(),
            must_change_password: row.get(2)?,
            created_us: row.get(3)?,
        };
        Ok((row.get::<_, i64>(0)?, person))
    })?;
    let mut people = Vec::new();
    for row in rows {
        let (id, person) = row?;
        people.push(Person { permissions: permissions(db, id)?, ..person });
    }
    Ok(people)
}

/// The number that stands for a role in the database.
pub fn number(role: Role) -> i64 {
    match role {
        Role::Viewer => 1,
        Role::Researcher => 2,
        Role::Operator => 3,
        Role::Admin => 4,
    }
}

/// The role behind a number.
pub fn role(written: i64) -> Option<Role> {
    Role::ALL.into_iter().find(|role| number(*role) == written)
}

/// Refuses, so that the transaction is undone, when no admin of all vessels is left.
fn somebody_manages(db: &Connection) -> Result<(), Fault> {
    let admins: i64 = db.query_row(
        "SELECT count(*) FROM permission WHERE vessel = ?1 AND role = ?2",
        [ALL, number(Role::Admin)],
        |row| row.get(0),
    )?;
    if admins == 0 {
        let text = "The server needs an admin: the first person is one, and the last admin stays until somebody else \
                    is one.";
        return Err(Fault::Refused(text.to_owned()));
    }
    Ok(())
}

fn check_name(name: &str) -> Result<(), Fault> {
    let good = |letter: char| letter.is_alphanumeric() || "._-@+".contains(letter);
    if (1..=64).contains(&name.chars().count()) && name.chars().all(good) {
        return Ok(());
    }
    Err(Fault::Refused("A name has 1 to 64 letters, digits and . _ - @ + in it.".to_owned()))
}

#[cfg(test)]
mod tests {
    use super::super::db::tests::fresh;
    use super::*;

    const NOW: UtcTime = UtcTime::from_micros(5);

    fn with_admin() -> (Connection, i64) {
        let db = fresh();
        let admin = add(&db, "admin", "hash", true, NOW).unwrap();
        set_permission(&db, admin, None, Some(Role::Admin)).unwrap();
        (db, admin)
    }

    #[test]
    fn a_person_is_found_by_name_in_any_case() {
        let (db, admin) = with_admin();
        let found = find(&db, "ADMIN").unwrap().unwrap();
        assert_eq!((found.id, found.name.as_str(), found.must_change), (admin, "admin", true));
        assert!(add(&db, "Admin", "x", false, NOW).unwrap_err().to_string().contains("already"));
        assert!(find(&db, "nobody").unwrap().is_none());
    }

    #[test]
    fn names_hold_nothing_that_could_be_code() {
        let (db, _) = with_admin();
        for name in ["", "a b", "<script>", "a\nb", "=1+1", "x'; --", &"n".repeat(65)] {
            assert!(add(&db, name, "x", false, NOW).is_err(), "{name:?}");
        }
        assert!(add(&db, "åse.næss-2@ntnu.no", "x", false, NOW).is_ok());
    }

    #[test]
    fn the_last_admin_stays() {
        let (db, admin) = with_admin();
        assert!(set_permission(&db, admin, None, Some(Role::Viewer)).is_err());
        let (db, _) = with_admin();
        assert!(remove(&db, "admin").unwrap_err().to_string().contains("last admin"));
    }

    #[test]
    fn permissions_are_listed_with_their_person() {
        let (db, _) = with_admin();
        let nils = add(&db, "nils", "x", false, NOW).unwrap();
        set_permission(&db, nils, Some(2068), Some(Role::Operator)).unwrap();
        set_permission(&db, nils, None, Some(Role::Viewer)).unwrap();
        let people = list(&db).unwrap();
        assert_eq!(people[1].permissions.len(), 2);
        assert_eq!(grants(&db, nils).unwrap().on(2068), Some(Role::Operator));
        set_permission(&db, nils, Some(2068), None).unwrap();
        assert_eq!(grants(&db, nils).unwrap().on(2068), Some(Role::Viewer));
    }
}
