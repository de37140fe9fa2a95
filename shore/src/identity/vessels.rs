//! Vessels that people have named. Their live state belongs to the hub.

use super::db::Fault;
use api::Vessel;
use rusqlite::{Connection, OptionalExtension as _, params};
use units::UtcTime;

/// Names a vessel.
///
/// # Errors
/// Name or address is taken or cannot be one.
pub fn add(db: &Connection, address: u16, name: &str, now: UtcTime) -> Result<(), Fault> {
    let good = |letter: char| letter.is_alphanumeric() || "._-".contains(letter);
    if !(1..=64).contains(&name.chars().count()) || !name.chars().all(good) {
        return Err(Fault::Refused(
            "A vessel's name has 1 to 64 letters, digits and . _ - in it.".to_owned(),
        ));
    }
    if matches!(address, 0 | 0xFFFF) {
        return Err(Fault::Refused("0 and 0xFFFF are no vessel's address.".to_owned()));
    }
    let taken: Option<String> = db
        .query_row("SELECT name FROM vessel WHERE address = ?1 OR name = ?2", params![address, name], |row| {
            row.get(0)
        })
        .optional()?;
    if let Some(taken) = taken {
        return Err(Fault::Refused(format!("Name or address is taken by {taken}.")));
    }
    db.execute("INSERT INTO vessel VALUES (?1, ?2, ?3)", params![address, name, now.micros()])?;
    Ok(())
}

/// Forgets a vessel's name and revokes its link tokens. Archive and history stay.
///
/// # Errors
/// There is none such.
pub fn remove(db: &Connection, address: u16) -> Result<(), Fault> {
    if db.execute("DELETE FROM vessel WHERE address = ?1", [address])? == 0 {
        return Err(Fault::Refused("There is no such vessel.".to_owned()));
    }
    db.execute("DELETE FROM token WHERE person IS NULL AND vessel = ?1", [address])?;
    Ok(())
}

/// All by name.
pub fn list(db: &Connection) -> Result<Vec<Vessel>, Fault> {
    let mut query = db.prepare_cached("SELECT address, name FROM vessel ORDER BY name")?;
    let rows = query.query_map([], |row| Ok(Vessel { address: row.get(0)?, name: row.get(1)? }))?;
    Ok(rows.collect::<Result<_, _>>()?)
}

/// The vessel that `text` names, or whose address it is (`2068` or `0x0814`).
///
/// # Errors
/// Neither.
pub fn named(db: &Connection, text: &str) -> Result<u16, Fault> {
    if let Some(vessel) = list(db)?.into_iter().find(|vessel| vessel.name.eq_ignore_ascii_case(text)) {
        return Ok(vessel.address);
    }
    address(text).map_err(|_| {
        Fault::Refused(format!(
            "There is no vessel {text}; see `lutra-server vessel list`, or give its address."
        ))
    })
}

/// Reads an IMC address, decimal or with `0x`.
///
/// # Errors
/// It is none.
pub fn address(text: &str) -> Result<u16, String> {
    let read = match text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
        Some(digits) => u16::from_str_radix(digits, 16),
        None => text.parse(),
    };
    read.map_err(|_| format!("{text:?} is no IMC address, like 2068 or 0x0814"))
}

#[cfg(test)]
mod tests {
    use super::super::db::tests::fresh;
    use super::*;

    #[test]
    fn a_vessel_is_found_by_name_and_by_address() {
        let db = fresh();
        add(&db, 0x0814, "ntnu-otter-01", UtcTime::default()).unwrap();
        for text in ["NTNU-otter-01", "2068", "0x0814"] {
            assert_eq!(named(&db, text).unwrap(), 0x0814);
        }
        assert!(named(&db, "otter").is_err());
        assert!(add(&db, 0x0814, "other", UtcTime::default()).unwrap_err().to_string().contains("ntnu"));
        assert!(add(&db, 9, "<b>", UtcTime::default()).is_err());
        assert!(add(&db, 0xFFFF, "all", UtcTime::default()).is_err());
    }

    #[test]
    fn a_removed_vessel_takes_its_link_tokens_along() {
        use super::super::tokens::{self, NewLink, make_link};
        let db = fresh();
        add(&db, 7, "otter", UtcTime::default()).unwrap();
        let link = NewLink { label: "x", vessel: 7, days: None };
        make_link(&db, &link, UtcTime::default()).unwrap();
        remove(&db, 7).unwrap();
        assert!(tokens::list(&db, None).unwrap().is_empty());
        assert!(remove(&db, 7).is_err());
    }
}
