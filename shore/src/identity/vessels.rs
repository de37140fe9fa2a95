//! Vessels that people have named. Their live state belongs to the hub.

use super::fault::Fault;
use super::request::Request;
use api::{Vessel, say};
use sqlx::SqliteConnection;
use units::UtcTime;

/// Names a vessel.
#[derive(Debug)]
pub struct Add {
    /// The IMC address.
    pub address: u16,
    /// The name.
    pub name: String,
    /// Time of the request.
    pub now: UtcTime,
}

impl Request for Add {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        add(db, self.address, &self.name, self.now).await
    }
}

/// Forgets the name of the vessel with this address and revokes its link tokens. Archive and history stay.
#[derive(Debug)]
pub struct Remove(pub u16);

impl Request for Remove {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        remove(db, self.0).await
    }
}

/// All by name.
#[derive(Debug)]
pub struct List;

impl Request for List {
    type Answer = Vec<Vessel>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Vec<Vessel>, Fault> {
        list(db).await
    }
}

/// Names a vessel.
///
/// # Errors
/// Name or address is taken or not valid.
async fn add(db: &mut SqliteConnection, address: u16, name: &str, now: UtcTime) -> Result<(), Fault> {
    let good = |letter: char| letter.is_alphanumeric() || "._-".contains(letter);
    if !(1..=64).contains(&name.chars().count()) || !name.chars().all(good) {
        return Err(Fault::refused(say("A vessel's name has 1 to 64 letters, digits and . _ - in it.")));
    }
    if self::address(name).is_ok() {
        return Err(Fault::refused(say(
            "{name} is an address, which could be that of another vessel: choose a name with a letter, like otter-1.",
        )
        .with("name", name)));
    }
    if matches!(address, 0 | 0xFFFF) {
        return Err(Fault::refused(say("0 and 0xFFFF cannot be a vessel's address.")));
    }
    let sql = "SELECT name FROM vessel WHERE address = ?1 OR name = ?2";
    let query = sqlx::query_scalar(sql).bind(address).bind(name);
    let taken: Option<String> = query.fetch_optional(&mut *db).await?;
    if let Some(taken) = taken {
        return Err(Fault::refused(say("Name or address is taken by {name}.").with("name", taken)));
    }
    let sql = "INSERT INTO vessel VALUES (?1, ?2, ?3)";
    sqlx::query(sql).bind(address).bind(name).bind(now.micros()).execute(db).await?;
    Ok(())
}

/// Forgets a vessel's name and revokes its link tokens. Archive and history stay.
///
/// # Errors
/// There is no such vessel.
async fn remove(db: &mut SqliteConnection, address: u16) -> Result<(), Fault> {
    let sql = "DELETE FROM vessel WHERE address = ?1";
    if sqlx::query(sql).bind(address).execute(&mut *db).await?.rows_affected() == 0 {
        return Err(Fault::refused(say("There is no such vessel.")));
    }
    let sql = "DELETE FROM token WHERE person IS NULL AND vessel = ?1";
    sqlx::query(sql).bind(address).execute(db).await?;
    Ok(())
}

/// All by name.
pub(super) async fn list(db: &mut SqliteConnection) -> Result<Vec<Vessel>, Fault> {
    let rows = sqlx::query_as("SELECT address, name FROM vessel ORDER BY name").fetch_all(db).await?;
    Ok(rows.into_iter().map(|(address, name)| Vessel { address, name }).collect())
}

/// The vessel whose address `text` is (`2068` or `0x0814`), or that it names. An address goes first: an app.db of an earlier version may
/// have a vessel whose name is another's address.
///
/// # Errors
/// Neither.
pub async fn named(db: &mut SqliteConnection, text: &str) -> Result<u16, Fault> {
    if let Ok(address) = address(text) {
        return Ok(address);
    }
    let named = list(db).await?.into_iter().find(|vessel| vessel.name.eq_ignore_ascii_case(text));
    named.map(|vessel| vessel.address).ok_or_else(|| {
        Fault::refused(
            say("There is no vessel {text}; see `lutra-server vessel list`, or give its address.")
                .with("text", text),
        )
    })
}

/// Reads an IMC address, decimal or with `0x`.
///
/// # Errors
/// It is not valid.
pub fn address(text: &str) -> Result<u16, String> {
    let read = match text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
        Some(digits) => u16::from_str_radix(digits, 16),
        None => text.parse(),
    };
    read.map_err(|_| format!("{text:?} is not an IMC address, like 2068 or 0x0814"))
}

#[cfg(test)]
mod tests {
    use super::super::db::tests::fresh;
    use super::*;

    #[tokio::test]
    async fn a_vessel_is_found_by_name_and_by_address() {
        let mut db = fresh().await;
        add(&mut db, 0x0814, "ntnu-otter-01", UtcTime::default()).await.unwrap();
        for text in ["NTNU-otter-01", "2068", "0x0814"] {
            assert_eq!(named(&mut db, text).await.unwrap(), 0x0814);
        }
        assert!(named(&mut db, "otter").await.is_err());
        assert!(
            add(&mut db, 0x0814, "other", UtcTime::default()).await.unwrap_err().to_string().contains("ntnu")
        );
        assert!(add(&mut db, 9, "<b>", UtcTime::default()).await.is_err());
        assert!(add(&mut db, 0xFFFF, "all", UtcTime::default()).await.is_err());
    }

    #[tokio::test]
    async fn a_name_is_never_taken_for_another_vessels_address() {
        let mut db = fresh().await;
        for name in ["0x1113", "4371"] {
            let refused = add(&mut db, 0x1234, name, UtcTime::default()).await.unwrap_err().to_string();
            assert!(refused.contains("is an address") && refused.contains("otter-1"), "{refused}");
        }
        // As an earlier version took it.
        let sql = "INSERT INTO vessel VALUES (0x1234, '0x1113', 0)";
        sqlx::query(sql).execute(&mut db).await.unwrap();
        assert_eq!(named(&mut db, "0x1113").await.unwrap(), 0x1113);
    }

    #[tokio::test]
    async fn a_removed_vessel_takes_its_link_tokens_along() {
        use super::super::tokens::{self, MakeLink};
        let mut db = fresh().await;
        add(&mut db, 7, "otter", UtcTime::default()).await.unwrap();
        let link = MakeLink { label: "x".to_owned(), vessel: 7, days: None, now: UtcTime::default() };
        link.run(&mut db).await.unwrap();
        remove(&mut db, 7).await.unwrap();
        assert!(tokens::list(&mut db, None).await.unwrap().is_empty());
        assert!(remove(&mut db, 7).await.is_err());
    }
}
