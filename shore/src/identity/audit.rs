//! The audit log: what people did and tried.

use super::fault::Fault;
use super::request::Request;
use api::AuditEntry;
use sqlx::SqliteConnection;
use units::UtcTime;

/// An entry of the audit log.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Line {
    /// Who did it.
    pub actor: String,
    /// From which network address; empty for automatic events.
    pub address: String,
    /// Like `plan.start`.
    pub action: &'static str,
    /// What it was done to.
    pub subject: String,
    /// The stage reached, or why it failed.
    pub outcome: String,
}

/// Entries that are kept; older ones go.
const ENTRIES: i64 = 1_000_000;

/// Prefixes, before a colon, of outcomes that are neither a refusal nor a failure: stages of an order.
const FINE: [&str; 8] =
    ["done", "asked", "accepted", "waiting", "sent", "received", "executing", "effect seen"];

/// Whether an outcome is a refusal or a failure.
pub fn is_bad(outcome: &str) -> bool {
    !FINE.contains(&outcome.split(':').next().unwrap_or_default())
}

/// An act of a user.
#[derive(Debug, Clone, Copy)]
pub(super) struct Act<'a> {
    pub(super) actor: &'a str,
    pub(super) address: &'a str,
    /// Like `user.add`.
    pub(super) action: &'a str,
    pub(super) subject: &'a str,
    /// `done`, or why not.
    pub(super) outcome: &'a str,
}

/// Writes lines, each with the time at which it happened.
#[derive(Debug)]
pub struct Record(pub Vec<(UtcTime, Line)>);

impl Request for Record {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        for (at, Line { actor, address, action, subject, outcome }) in &self.0 {
            record(db, Act { actor, address, action, subject, outcome }, *at).await?;
        }
        Ok(())
    }
}

/// A request with its line in the audit log, both or neither.
#[derive(Debug)]
pub struct Acted<R> {
    /// What is done.
    pub request: R,
    /// Its line in the log.
    pub line: Line,
    /// Time of the action.
    pub now: UtcTime,
}

impl<R: Request> Request for Acted<R> {
    type Answer = R::Answer;

    async fn run(self, db: &mut SqliteConnection) -> Result<R::Answer, Fault> {
        let done = self.request.run(db).await?;
        Record(vec![(self.now, self.line)]).run(db).await?;
        Ok(done)
    }
}

/// Up to `count` entries before the entry `before`, the newest first.
#[derive(Debug, Default)]
pub struct Entries {
    /// Entries with lower numbers only.
    pub before: Option<i64>,
    /// At most this many.
    pub count: u32,
    /// Of this person or program alone.
    pub actor: Option<String>,
    /// Of this action alone.
    pub action: Option<String>,
    /// Only what was refused or failed.
    pub failed: bool,
}

/// All actors in the log, by name.
#[derive(Debug)]
pub struct Actors;

impl Request for Actors {
    type Answer = Vec<String>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Vec<String>, Fault> {
        let sql = "SELECT DISTINCT actor FROM audit ORDER BY actor LIMIT 500";
        Ok(sqlx::query_scalar(sql).fetch_all(db).await?)
    }
}

impl Request for Entries {
    type Answer = Vec<AuditEntry>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Vec<AuditEntry>, Fault> {
        entries(db, self).await
    }
}

/// Writes it down.
pub(super) async fn record(db: &mut SqliteConnection, act: Act<'_>, now: UtcTime) -> Result<(), Fault> {
    let short = |text: &str| text.chars().take(200).collect::<String>();
    // Long enough for a parameter with its value before and after.
    let subject: String = act.subject.chars().take(500).collect();
    let sql = "INSERT INTO audit (time_us, actor, address, action, subject, outcome) VALUES (?1, ?2, ?3, ?4, ?5, ?6)";
    let query = sqlx::query(sql).bind(now.micros()).bind(short(act.actor)).bind(short(act.address));
    let query = query.bind(act.action).bind(subject).bind(short(act.outcome));
    let oldest = query.execute(&mut *db).await?.last_insert_rowid() - ENTRIES;
    sqlx::query("DELETE FROM audit WHERE id <= ?1").bind(oldest).execute(db).await?;
    Ok(())
}

/// Up to `count` entries before the entry `before`, the newest first.
async fn entries(db: &mut SqliteConnection, wanted: Entries) -> Result<Vec<AuditEntry>, Fault> {
    let sql = "SELECT id, time_us, actor, address, action, subject, outcome FROM audit
               WHERE id < ?1 AND (?3 IS NULL OR actor = ?3) AND (?4 IS NULL OR action = ?4)
               AND (NOT ?5 OR CASE instr(outcome, ':') WHEN 0 THEN outcome ELSE substr(outcome, 1, instr(outcome, ':') - 1) END
                   NOT IN (SELECT value FROM json_each(?6))) ORDER BY id DESC LIMIT ?2";
    let query = sqlx::query_as(sql).bind(wanted.before.unwrap_or(i64::MAX)).bind(wanted.count);
    let fine = serde_json::to_string(&FINE).unwrap_or_default();
    let query = query.bind(wanted.actor).bind(wanted.action).bind(wanted.failed).bind(fine);
    let rows = query.fetch_all(db).await?;
    let entry = |(id, time_us, actor, address, action, subject, outcome)| AuditEntry {
        id,
        time_us,
        actor,
        address,
        action,
        subject,
        outcome,
    };
    Ok(rows.into_iter().map(entry).collect())
}

/// Entries that are searched for teleoperation without an end.
const LOOKED_THROUGH: i64 = 10_000;

/// Writes an end for every teleoperation without one, because the server was killed before it wrote it. Returns how many.
pub(super) async fn close_open(db: &mut SqliteConnection, now: UtcTime) -> Result<usize, Fault> {
    // The vessel stands before the number of the command, with a space after it.
    let sql = "WITH begun AS (SELECT id, actor, action, outcome, CASE instr(subject, ' [command ') WHEN 0 THEN subject
             ELSE substr(subject, 1, instr(subject, ' [command ')) END AS vessel FROM audit)
         SELECT actor, vessel FROM begun
         WHERE id > (SELECT max(id) FROM audit) - ?1 AND action = 'teleop.begin' AND outcome IN ('asked', 'done')
         AND NOT EXISTS (SELECT 1 FROM audit AS later WHERE later.id > begun.id
             AND (later.action = 'teleop.end' OR later.action = 'teleop.begin' AND (later.outcome IN ('asked', 'done')
                 OR later.outcome LIKE 'refused%' OR later.outcome LIKE 'expired%'))
             AND later.actor = begun.actor
             AND substr(later.subject, 1, length(begun.vessel)) = begun.vessel)";
    let open: Vec<(String, String)> = sqlx::query_as(sql).bind(LOOKED_THROUGH).fetch_all(&mut *db).await?;
    for (actor, vessel) in &open {
        let subject = format!("{} the server was killed or lost its power", vessel.trim());
        let act = Act { actor, address: "", action: "teleop.end", subject: &subject, outcome: "done" };
        record(db, act, now).await?;
    }
    Ok(open.len())
}

#[cfg(test)]
mod tests {
    use super::super::db::tests::fresh;
    use super::*;

    fn newest(before: Option<i64>, count: u32) -> Entries {
        Entries { before, count, ..Entries::default() }
    }

    #[tokio::test]
    async fn entries_come_newest_first_and_in_pages() {
        let mut db = fresh().await;
        for subject in ["a", "b", "c"] {
            let act = Act { actor: "nils", address: "::1", action: "user.add", subject, outcome: "done" };
            record(&mut db, act, UtcTime::from_micros(1)).await.unwrap();
        }
        let first = entries(&mut db, newest(None, 2)).await.unwrap();
        let subjects: Vec<&str> = first.iter().map(|entry| entry.subject.as_str()).collect();
        assert_eq!(subjects, ["c", "b"]);
        assert_eq!(entries(&mut db, newest(Some(first[1].id), 2)).await.unwrap()[0].subject, "a");
    }

    #[tokio::test]
    async fn steering_that_has_no_end_gets_one_once() {
        let mut db = fresh().await;
        for (actor, action, subject, outcome) in [
            ("anna", "teleop.begin", "otter-1 ", "done"),
            ("anna", "teleop.end", "otter-1 the person ended it", "done"),
            ("anna", "teleop.begin", "otter-2 ", "You do not have control of this vessel"),
            ("bert", "teleop.begin", "otter-3 ", "asked"),
            ("bert", "teleop.begin", "otter-3 ", "sent: by link"),
            ("bert", "teleop.begin", "otter-3 ", "effect seen: executing teleoperation-mode"),
            ("cora", "teleop.begin", "otter-4 ", "asked"),
            ("cora", "teleop.begin", "otter-4 ", "refused: no plan"),
            ("dag", "teleop.begin", "otter-1 [command 7]", "asked"),
            ("dag", "teleop.end", "otter-1 the window was closed [command 8]", "done"),
            ("dag", "teleop.begin", "otter-10 [command 9]", "refused: no plan"),
            ("bert", "teleop.begin", "otter-3 [command 10]", "asked"),
        ] {
            let act = Act { actor, address: "", action, subject, outcome };
            record(&mut db, act, UtcTime::from_micros(1)).await.unwrap();
        }
        assert_eq!(close_open(&mut db, UtcTime::from_micros(2)).await.unwrap(), 1);
        let last = entries(&mut db, newest(None, 1)).await.unwrap().remove(0);
        assert_eq!((last.actor.as_str(), last.action.as_str()), ("bert", "teleop.end"));
        assert_eq!(last.subject, "otter-3 the server was killed or lost its power");
        assert_eq!(close_open(&mut db, UtcTime::from_micros(3)).await.unwrap(), 0);
    }

    #[tokio::test]
    async fn the_log_is_filtered_by_person_action_and_outcome() {
        let mut db = fresh().await;
        for (actor, action, outcome) in [
            ("kari", "plan.start", "sent: by link"),
            ("nils", "plan.start", "no link"),
            ("nils", "login", "done"),
        ] {
            let act = Act { actor, address: "::1", action, subject: "x", outcome };
            record(&mut db, act, UtcTime::from_micros(1)).await.unwrap();
        }
        let some = |text: &str| Some(text.to_owned());
        for (actor, action, failed, found) in [
            (None, None, false, 3),
            (some("nils"), None, false, 2),
            (None, some("plan.start"), false, 2),
            (some("nils"), some("plan.start"), false, 1),
            (None, None, true, 1),
            (some("kari"), None, true, 0),
        ] {
            let wanted = Entries { before: None, count: 9, actor, action, failed };
            assert_eq!(entries(&mut db, wanted).await.unwrap().len(), found);
        }
        assert_eq!(Actors.run(&mut db).await.unwrap(), ["kari", "nils"]);
    }
}
