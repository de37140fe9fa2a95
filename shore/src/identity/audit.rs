//! The log of what people did and tried.

use super::db::Fault;
use api::AuditEntry;
use rusqlite::{Connection, params};
use units::UtcTime;

/// Entries that are kept; older ones go.
const ENTRIES: i64 = 1_000_000;

/// Something somebody does.
#[derive(Debug, Clone, Copy)]
pub struct Act<'a> {
    pub actor: &'a str,
    pub address: &'a str,
    /// Like `user.add`.
    pub action: &'a str,
    pub subject: &'a str,
    /// `done`, or why not.
    pub outcome: &'a str,
}

/// Writes it down.
pub fn record(db: &Connection, act: Act<'_>, now: UtcTime) -> Result<(), Fault> {
    let short = |text: &str| text.chars().take(200).collect::<String>();
    // A parameter with its value before and after.
    let subject: String = act.subject.chars().take(500).collect();
    db.prepare_cached(
        "INSERT INTO audit (time_us, actor, address, action, subject, outcome) VALUES (?1, ?2, ?3, ?4, ?5, ?6)",
    )?
    .execute(params![
        now.micros(),
        short(act.actor),
        short(act.address),
        act.action,
        subject,
        short(act.outcome)
    ])?;
    let oldest = db.last_insert_rowid() - ENTRIES;
    db.prepare_cached("DELETE FROM audit WHERE id <= ?1")?.execute([oldest])?;
    Ok(())
}

/// Up to `count` entries before the entry `before`, the newest first.
pub fn entries(db: &Connection, before: Option<i64>, count: u32) -> Result<Vec<AuditEntry>, Fault> {
    let mut query = db.prepare_cached(
        "SELECT id, time_us, actor, address, action, subject, outcome FROM audit
         WHERE id < ?1 ORDER BY id DESC LIMIT ?2",
    )?;
    let rows = query.query_map(params![before.unwrap_or(i64::MAX), count], |row| {
        Ok(AuditEntry {
            id: row.get(0)?,
            time_us: row.get(1)?,
            actor: row.get(2)?,
            address: row.get(3)?,
            action: row.get(4)?,
            subject: row.get(5)?,
            outcome: row.get(6)?,
        })
    })?;
    Ok(rows.collect::<Result<_, _>>()?)
}

/// Entries that are looked through for steering by hand that has no end.
const LOOKED_THROUGH: i64 = 10_000;

/// Writes an end behind every steering by hand that has none: the server that was to write it was killed. How many.
pub fn close_open(db: &Connection, now: UtcTime) -> Result<usize, Fault> {
    let mut query = db.prepare(
        "SELECT actor, subject FROM audit AS begun
         WHERE id > (SELECT max(id) FROM audit) - ?1 AND action = 'teleop.begin' AND outcome IN ('asked', 'done')
         AND NOT EXISTS (SELECT 1 FROM audit AS later WHERE later.id > begun.id
             AND (later.action = 'teleop.end' OR later.action = 'teleop.begin' AND (later.outcome IN ('asked', 'done')
                 OR later.outcome LIKE 'refused%' OR later.outcome LIKE 'expired%'))
             AND later.actor = begun.actor
             AND substr(later.subject, 1, length(begun.subject)) = begun.subject)",
    )?;
    let open: Vec<(String, String)> =
        query.query_map([LOOKED_THROUGH], |row| Ok((row.get(0)?, row.get(1)?)))?.collect::<Result<_, _>>()?;
    for (actor, subject) in &open {
        let subject = format!("{} the server was killed or lost its power", subject.trim());
        let act = Act { actor, address: "", action: "teleop.end", subject: &subject, outcome: "done" };
        record(db, act, now)?;
    }
    Ok(open.len())
}

#[cfg(test)]
mod tests {
    use super::super::db::tests::fresh;
    use super::*;

    #[test]
    fn entries_come_newest_first_and_in_pages() {
        let db = fresh();
        for subject in ["a", "b", "c"] {
            let act = Act { actor: "nils", address: "::1", action: "user.add", subject, outcome: "done" };
            record(&db, act, UtcTime::from_micros(1)).unwrap();
        }
        let first = entries(&db, None, 2).unwrap();
        let subjects: Vec<&str> = first.iter().map(|entry| entry.subject.as_str()).collect();
        assert_eq!(subjects, ["c", "b"]);
        assert_eq!(entries(&db, Some(first[1].id), 2).unwrap()[0].subject, "a");
    }

    #[test]
    fn steering_that_has_no_end_gets_one_once() {
        let db = fresh();
        let says = |actor, action, subject, outcome| {
            record(&db, Act { actor, address: "", action, subject, outcome }, UtcTime::from_micros(1))
                .unwrap();
        };
        says("anna", "teleop.begin", "otter-1 ", "done");
        says("anna", "teleop.end", "otter-1 the person ended it", "done");
        says("anna", "teleop.begin", "otter-2 ", "you do not have control of this vessel");
        says("bert", "teleop.begin", "otter-3 ", "asked");
        says("bert", "teleop.begin", "otter-3 ", "sent: by link");
        says("bert", "teleop.begin", "otter-3 ", "effect seen: executing teleoperation-mode");
        says("cora", "teleop.begin", "otter-4 ", "asked");
        says("cora", "teleop.begin", "otter-4 ", "refused: no plan");
        assert_eq!(close_open(&db, UtcTime::from_micros(2)).unwrap(), 1);
        let last = entries(&db, None, 1).unwrap().remove(0);
        assert_eq!((last.actor.as_str(), last.action.as_str()), ("bert", "teleop.end"));
        assert_eq!(last.subject, "otter-3 the server was killed or lost its power");
        assert_eq!(close_open(&db, UtcTime::from_micros(3)).unwrap(), 0);
    }
}
