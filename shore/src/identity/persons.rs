//! Accounts in the database.

use super::fault::Fault;
use super::request::Request;
use super::roles::Grants;
use api::{Permission, Person, Role, say};
use sqlx::SqliteConnection;
use units::UtcTime;

/// Value of `permission.vessel` for "all vessels".
const ALL: i64 = -1;

/// What a login needs to know of a person.
#[derive(Debug)]
pub struct Account {
    /// The number.
    pub id: i64,
    /// The name.
    pub name: String,
    /// The password's hash.
    pub password: String,
    /// Whether the password must be changed first.
    pub must_change: bool,
}

/// Adds a person, with a role on a vessel (`None`: all vessels) or without any: then they see what is shared with them alone.
#[derive(Debug)]
pub struct Add {
    /// The name.
    pub name: String,
    /// The password, as argon2id keeps it.
    pub password_hash: String,
    /// Whether it is good for one login only.
    pub must_change: bool,
    /// The vessel of the role (`None`: all).
    pub vessel: Option<u16>,
    /// The role, if they get one.
    pub role: Option<Role>,
    /// Time of the request.
    pub now: UtcTime,
}

impl Request for Add {
    /// The person's number.
    type Answer = i64;

    async fn run(self, db: &mut SqliteConnection) -> Result<i64, Fault> {
        let id = add(db, &self.name, &self.password_hash, self.must_change, self.now).await?;
        match self.role {
            Some(_) => set_permission(db, id, self.vessel, self.role).await?,
            // The first person must be an admin, or nobody could ever manage the server.
            None => somebody_manages(db).await?,
        }
        Ok(id)
    }
}

/// Gives a person a role on a vessel (`None`: all vessels), or takes it.
#[derive(Debug)]
pub struct SetRole {
    /// Name of the person.
    pub name: String,
    /// On which vessel (`None`: all).
    pub vessel: Option<u16>,
    /// The role; `None` takes it away.
    pub role: Option<Role>,
}

impl Request for SetRole {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        let person = known(db, &self.name).await?.id;
        set_permission(db, person, self.vessel, self.role).await
    }
}

/// Sets a password; all sessions of the person but `keep` end.
#[derive(Debug)]
pub struct SetPassword {
    /// Name of the person.
    pub name: String,
    /// The password, as argon2id keeps it.
    pub password_hash: String,
    /// Whether it is good for one login only.
    pub must_change: bool,
    /// The session that is kept; all others end.
    pub keep: Option<i64>,
}

impl Request for SetPassword {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        let person = known(db, &self.name).await?.id;
        set_password(db, person, &self.password_hash, self.must_change, self.keep).await
    }
}

/// Removes the person of this name, with sessions and tokens.
#[derive(Debug)]
pub struct Remove(pub String);

impl Request for Remove {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        remove(db, &self.0).await
    }
}

/// The number of the person of this name, and the name as it was given when the account was made.
#[derive(Debug)]
pub struct Named(pub String);

impl Request for Named {
    type Answer = (i64, String);

    async fn run(self, db: &mut SqliteConnection) -> Result<(i64, String), Fault> {
        let Account { id, name, .. } = known(db, &self.0).await?;
        Ok((id, name))
    }
}

/// All people by name.
#[derive(Debug)]
pub struct List;

impl Request for List {
    type Answer = Vec<Person>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Vec<Person>, Fault> {
        list(db).await
    }
}

/// Permissions of the person of this number.
#[derive(Debug)]
pub struct Permissions(pub i64);

impl Request for Permissions {
    type Answer = Vec<Permission>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Vec<Permission>, Fault> {
        permissions(db, self.0).await
    }
}

/// Adds a person without any permission.
///
/// # Errors
/// The name is taken or not valid.
pub(super) async fn add(
    db: &mut SqliteConnection,
    name: &str,
    password_hash: &str,
    must_change: bool,
    now: UtcTime,
) -> Result<i64, Fault> {
    check_name(name)?;
    if find(db, name).await?.is_some() {
        return Err(Fault::refused(say("There is a person {name} already.").with("name", name)));
    }
    let sql = "INSERT INTO person (name, password, must_change, created_us) VALUES (?1, ?2, ?3, ?4)";
    let query = sqlx::query(sql).bind(name).bind(password_hash).bind(must_change).bind(now.micros());
    Ok(query.execute(db).await?.last_insert_rowid())
}

/// The person of this name, ignoring case.
pub(super) async fn find(db: &mut SqliteConnection, name: &str) -> Result<Option<Account>, Fault> {
    let sql = "SELECT id, name, password, must_change FROM person WHERE name = ?1";
    let row = sqlx::query_as(sql).bind(name).fetch_optional(db).await?;
    Ok(row.map(|(id, name, password, must_change)| Account { id, name, password, must_change }))
}

/// The person of this name.
///
/// # Errors
/// There is none.
pub(super) async fn known(db: &mut SqliteConnection, name: &str) -> Result<Account, Fault> {
    find(db, name).await?.ok_or_else(|| unknown(name))
}

/// The error that there is no person of this name.
pub(super) fn unknown(name: &str) -> Fault {
    Fault::refused(say("There is no person {name}.").with("name", name))
}

/// Removes a person with sessions and tokens.
///
/// # Errors
/// There is no such person, or no admin would be left.
pub(super) async fn remove(db: &mut SqliteConnection, name: &str) -> Result<(), Fault> {
    let account = known(db, name).await?;
    sqlx::query("DELETE FROM person WHERE id = ?1").bind(account.id).execute(&mut *db).await?;
    somebody_manages(db).await
}

/// Sets a password; all sessions of the person but `keep` end, and so do the tokens of their scripts: someone who knew the
/// old password may have made some. Tokens made while a one-time password was set stay when that is changed.
pub(super) async fn set_password(
    db: &mut SqliteConnection,
    person: i64,
    password_hash: &str,
    must_change: bool,
    keep: Option<i64>,
) -> Result<(), Fault> {
    let sql = "DELETE FROM token WHERE person = ?1 AND NOT (SELECT must_change FROM person WHERE id = ?1)";
    sqlx::query(sql).bind(person).execute(&mut *db).await?;
    let sql = "UPDATE person SET password = ?2, must_change = ?3 WHERE id = ?1";
    sqlx::query(sql).bind(person).bind(password_hash).bind(must_change).execute(&mut *db).await?;
    let sql = "DELETE FROM session WHERE person = ?1 AND id IS NOT ?2";
    sqlx::query(sql).bind(person).bind(keep).execute(db).await?;
    Ok(())
}

/// Gives or, with `None`, takes a role on a vessel (`None`: all vessels).
///
/// # Errors
/// No admin would be left, or there is no such role to take: who takes it would believe that access has ended.
pub(super) async fn set_permission(
    db: &mut SqliteConnection,
    person: i64,
    vessel: Option<u16>,
    role: Option<Role>,
) -> Result<(), Fault> {
    let of_all = vessel.is_none();
    let vessel = vessel.map_or(ALL, i64::from);
    let query = match role {
        None => sqlx::query("DELETE FROM permission WHERE person = ?1 AND vessel = ?2"),
        Some(_) => {
            sqlx::query("INSERT OR REPLACE INTO permission (person, vessel, role) VALUES (?1, ?2, ?3)")
        }
    };
    let query = query.bind(person).bind(vessel);
    let query = if let Some(role) = role { query.bind(number(role)) } else { query };
    if query.execute(&mut *db).await?.rows_affected() == 0 {
        return Err(Fault::refused(if of_all {
            say("This person has no role on all vessels. Roles on single vessels are taken one by one.")
        } else {
            say(
                "This person has no role on this vessel alone. A role on all vessels includes it: take that one.",
            )
        }));
    }
    somebody_manages(db).await
}

/// Permissions of a person.
async fn permissions(db: &mut SqliteConnection, person: i64) -> Result<Vec<Permission>, Fault> {
    let sql = "SELECT vessel, role FROM permission WHERE person = ?1 ORDER BY vessel";
    let rows: Vec<(i64, i64)> = sqlx::query_as(sql).bind(person).fetch_all(db).await?;
    let given = rows.into_iter().filter_map(|(vessel, number)| {
        Some(Permission { vessel: u16::try_from(vessel).ok(), role: role(number)? })
    });
    Ok(given.collect())
}

/// As [`permissions`], in the form for access checks.
pub(crate) async fn grants(db: &mut SqliteConnection, person: i64) -> Result<Grants, Fault> {
    Ok(Grants::new(&permissions(db, person).await?))
}

/// All people by name.
async fn list(db: &mut SqliteConnection) -> Result<Vec<Person>, Fault> {
    let sql = "SELECT id, name, must_change, created_us FROM person ORDER BY name";
    let rows: Vec<(i64, String, bool, i64)> = sqlx::query_as(sql).fetch_all(&mut *db).await?;
    let mut people = Vec::new();
    for (id, name, must_change_password, created_us) in rows {
        let permissions = permissions(db, id).await?;
        people.push(Person { name, permissions, must_change_password, created_us });
    }
    Ok(people)
}

/// The number of a role in the database.
pub fn number(role: Role) -> i64 {
    match role {
        Role::Viewer => 1,
        Role::Researcher => 2,
        Role::Operator => 3,
        Role::Admin => 4,
    }
}

/// The role with this number.
pub fn role(written: i64) -> Option<Role> {
    Role::ALL.into_iter().find(|role| number(*role) == written)
}

/// Refuses, so that the transaction is undone, when no admin of all vessels is left.
async fn somebody_manages(db: &mut SqliteConnection) -> Result<(), Fault> {
    let sql = "SELECT count(*) FROM permission WHERE vessel = ?1 AND role = ?2";
    let admins: i64 = sqlx::query_scalar(sql).bind(ALL).bind(number(Role::Admin)).fetch_one(db).await?;
    if admins == 0 {
        return Err(Fault::refused(say(
            "The server needs an admin: the first person is one, and the last admin stays until another person is one.",
        )));
    }
    Ok(())
}

fn check_name(name: &str) -> Result<(), Fault> {
    let good = |letter: char| letter.is_alphanumeric() || "._-@+".contains(letter);
    if (1..=64).contains(&name.chars().count()) && name.chars().all(good) {
        return Ok(());
    }
    Err(Fault::refused(say("A name has 1 to 64 letters, digits and . _ - @ + in it.")))
}

#[cfg(test)]
mod tests {
    use super::super::db::tests::fresh;
    use super::*;

    const NOW: UtcTime = UtcTime::from_micros(5);

    async fn with_admin() -> (SqliteConnection, i64) {
        let mut db = fresh().await;
        let admin = add(&mut db, "admin", "hash", true, NOW).await.unwrap();
        set_permission(&mut db, admin, None, Some(Role::Admin)).await.unwrap();
        (db, admin)
    }

    #[tokio::test]
    async fn a_person_is_found_by_name_in_any_case() {
        let (mut db, admin) = with_admin().await;
        let found = find(&mut db, "ADMIN").await.unwrap().unwrap();
        assert_eq!((found.id, found.name.as_str(), found.must_change), (admin, "admin", true));
        assert!(add(&mut db, "Admin", "x", false, NOW).await.unwrap_err().to_string().contains("already"));
        assert!(find(&mut db, "nobody").await.unwrap().is_none());
    }

    #[tokio::test]
    async fn names_hold_nothing_that_could_be_code() {
        let (mut db, _) = with_admin().await;
        for name in ["", "a b", "<script>", "a\nb", "=1+1", "x'; --", &"n".repeat(65)] {
            assert!(add(&mut db, name, "x", false, NOW).await.is_err(), "{name:?}");
        }
        assert!(add(&mut db, "åse.næss-2@ntnu.no", "x", false, NOW).await.is_ok());
    }

    #[tokio::test]
    async fn the_first_person_is_an_admin_and_a_later_one_may_have_no_role() {
        let add = |name: &str, role| Add {
            name: name.to_owned(),
            password_hash: "x".to_owned(),
            must_change: false,
            vessel: None,
            role,
            now: NOW,
        };
        for role in [None, Some(Role::Viewer)] {
            let refused = add("ola", role).run(&mut fresh().await).await.unwrap_err();
            assert!(refused.to_string().contains("needs an admin"), "{role:?}: {refused}");
        }
        let (mut db, _) = with_admin().await;
        let ola = add("ola", None).run(&mut db).await.unwrap();
        assert_eq!(permissions(&mut db, ola).await.unwrap(), []);
    }

    #[tokio::test]
    async fn the_last_admin_stays() {
        let (mut db, admin) = with_admin().await;
        assert!(set_permission(&mut db, admin, None, Some(Role::Viewer)).await.is_err());
        let (mut db, _) = with_admin().await;
        assert!(remove(&mut db, "admin").await.unwrap_err().to_string().contains("last admin"));
    }

    #[tokio::test]
    async fn permissions_are_listed_with_their_person() {
        let (mut db, _) = with_admin().await;
        let nils = add(&mut db, "nils", "x", false, NOW).await.unwrap();
        set_permission(&mut db, nils, Some(2068), Some(Role::Operator)).await.unwrap();
        set_permission(&mut db, nils, None, Some(Role::Viewer)).await.unwrap();
        let people = list(&mut db).await.unwrap();
        assert_eq!(people[1].permissions.len(), 2);
        assert_eq!(grants(&mut db, nils).await.unwrap().on(2068), Some(Role::Operator));
        set_permission(&mut db, nils, Some(2068), None).await.unwrap();
        let refused = set_permission(&mut db, nils, Some(2068), None).await.unwrap_err().to_string();
        assert!(refused.contains("A role on all vessels includes it"), "{refused}");
        assert_eq!(grants(&mut db, nils).await.unwrap().on(2068), Some(Role::Viewer));
    }
}
