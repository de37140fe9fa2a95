//! People for tests.

#![expect(clippy::unwrap_used, clippy::missing_panics_doc, reason = "for tests alone")]

use super::fault::Fault;
use super::request::Request;
use super::secret::Secret;
use super::sessions::{self, Lifetime};
use super::writer::within_transaction;
use super::{persons, tokens};
use crate::clock::Clock;
use api::{NewToken, Role};
use sqlx::SqliteConnection;
use std::path::Path;
use std::time::Duration;

/// Makes a person with a role on a vessel (`None`: all), and a token for their script.
pub struct NewScript {
    /// Their name.
    pub name: String,
    /// The vessel of the role.
    pub vessel: Option<u16>,
    /// The role.
    pub role: Role,
    /// The most that the script may do.
    pub most: Role,
}

impl Request for NewScript {
    /// The person's number and the token.
    type Answer = (i64, String);

    async fn run(self, db: &mut SqliteConnection) -> Result<(i64, String), Fault> {
        let now = Clock::real().utc();
        let person = persons::add(db, &self.name, "x", false, now).await?;
        persons::set_permission(db, person, self.vessel, Some(self.role)).await?;
        let new = NewToken { label: "test".to_owned(), role: self.most, vessel: None, days: 1 };
        Ok((person, tokens::Make { person, new, now }.run(db).await?.secret))
    }
}

/// As [`NewScript`], written into the database in `folder` as another program would.
pub async fn script(folder: &Path, name: &str, vessel: Option<u16>, role: Role) -> (i64, String) {
    let new = NewScript { name: name.to_owned(), vessel, role, most: role };
    within_transaction(&mut super::open(folder).await.unwrap(), new).await.unwrap()
}

/// As [`script`], a session of this person's in a browser.
pub async fn session(folder: &Path, person: i64) -> Secret {
    let hour = Duration::from_hours(1);
    let life = Lifetime { idle: hour, whole: hour };
    let mut db = super::open(folder).await.unwrap();
    sessions::begin(&mut db, person, "127.0.0.1", "test", life, Clock::real().utc()).await.unwrap()
}

/// As [`script`], a token for the link of `vessel`.
pub async fn link(folder: &Path, vessel: u16) -> String {
    let make = tokens::MakeLink { label: "link".to_owned(), vessel, days: None, now: Clock::real().utc() };
    within_transaction(&mut super::open(folder).await.unwrap(), make).await.unwrap().secret
}
