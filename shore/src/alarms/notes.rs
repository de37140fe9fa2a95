//! The log of alarm changes in app.db, read page by page.

use crate::identity::{Fault, Request};
use api::AlarmNote;
use sqlx::{QueryBuilder, Sqlite, SqliteConnection};

/// Changes that are kept; older ones go.
const KEPT: i64 = 100_000;

/// Writes changes down, in their order.
#[derive(Debug)]
pub(super) struct WriteNotes(pub(super) Vec<AlarmNote>);

impl Request for WriteNotes {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        let mut last = 0;
        for note in self.0 {
            let sql =
                "INSERT INTO alarm_note (time_us, alarm, vessel, vessel_name, kind, priority, what, by, text, says)
                       VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10)";
            let query = sqlx::query(sql).bind(note.time_us).bind(i64::try_from(note.id).unwrap_or(i64::MAX));
            let query = query
                .bind(note.vessel)
                .bind(note.vessel_name)
                .bind(note.kind)
                .bind(note.priority)
                .bind(note.what);
            let says = serde_json::to_string(&note.says).unwrap_or_default();
            last =
                query.bind(note.by).bind(note.text).bind(says).execute(&mut *db).await?.last_insert_rowid();
        }
        sqlx::query("DELETE FROM alarm_note WHERE id <= ?1").bind(last - KEPT).execute(db).await?;
        Ok(())
    }
}

/// A row as the question below asks for it.
type Row =
    (i64, i64, i64, Option<u16>, Option<String>, String, String, String, String, String, Option<String>);

/// Changes of alarms, the newest first.
#[derive(Debug, Clone, Default)]
pub struct Notes {
    /// Those of these vessels and of the server itself; `None` for all.
    pub vessels: Option<Vec<u16>>,
    /// Of this vessel alone.
    pub vessel: Option<u16>,
    /// Of this priority alone.
    pub priority: Option<String>,
    /// From this time on (µs since 1970 UTC).
    pub from_us: Option<i64>,
    /// Before this time (µs since 1970 UTC).
    pub to_us: Option<i64>,
    /// Before the change with this number.
    pub before: Option<i64>,
    /// At most this many.
    pub count: u32,
}

impl Request for Notes {
    type Answer = Vec<(i64, AlarmNote)>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Self::Answer, Fault> {
        let mut sql: QueryBuilder<Sqlite> = QueryBuilder::new(
            "SELECT id, time_us, alarm, vessel, vessel_name, kind, priority, what, by, text, says FROM alarm_note WHERE 1",
        );
        if let Some(vessels) = &self.vessels {
            sql.push(" AND (vessel IS NULL OR vessel IN (");
            let mut list = sql.separated(", ");
            for vessel in vessels {
                list.push_bind(*vessel);
            }
            sql.push("))");
        }
        if let Some(vessel) = self.vessel {
            sql.push(" AND vessel = ").push_bind(vessel);
        }
        if let Some(priority) = self.priority {
            sql.push(" AND priority = ").push_bind(priority);
        }
        for (compared, value) in
            [("time_us >= ", self.from_us), ("time_us < ", self.to_us), ("id < ", self.before)]
        {
            if let Some(value) = value {
                sql.push(" AND ").push(compared).push_bind(value);
            }
        }
        sql.push(" ORDER BY id DESC LIMIT ").push_bind(self.count);
        let rows: Vec<Row> = sql.build_query_as().fetch_all(db).await?;
        let note = |(number, time_us, id, vessel, vessel_name, kind, priority, what, by, text, says): Row| {
            let says = says.and_then(|says| serde_json::from_str(&says).ok()).unwrap_or_default();
            (
                number,
                AlarmNote {
                    time_us,
                    id: id.cast_unsigned(),
                    vessel,
                    vessel_name,
                    kind,
                    priority,
                    what,
                    by,
                    says,
                    text,
                },
            )
        };
        Ok(rows.into_iter().map(note).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identity::migrated as fresh;

    fn note(time_us: i64, vessel: Option<u16>, priority: &str) -> AlarmNote {
        AlarmNote {
            time_us,
            id: 7,
            vessel,
            vessel_name: vessel.map(|vessel| format!("otter-{vessel}")),
            kind: "link-lost".to_owned(),
            priority: priority.to_owned(),
            what: "raised".to_owned(),
            by: String::new(),
            says: vec![api::AlarmSaying::NotHeard { since_us: time_us }],
            text: "the link is lost".to_owned(),
        }
    }

    async fn times(db: &mut SqliteConnection, wanted: Notes) -> Vec<i64> {
        let found = Notes { count: 10, ..wanted }.run(db).await.unwrap();
        found.into_iter().map(|(_, note)| note.time_us).collect()
    }

    #[tokio::test]
    async fn changes_are_found_by_vessel_priority_and_time() {
        let mut db = fresh().await;
        let all =
            [(1, Some(5), "alarm"), (2, Some(6), "warning"), (3, None, "alarm"), (4, Some(5), "warning")];
        let notes = all.map(|(time_us, vessel, priority)| note(time_us, vessel, priority));
        WriteNotes(notes.to_vec()).run(&mut db).await.unwrap();
        let db = &mut db;
        let any = Notes::default;
        assert_eq!(times(db, any()).await, [4, 3, 2, 1]);
        assert_eq!(times(db, Notes { vessel: Some(5), ..any() }).await, [4, 1]);
        assert_eq!(
            times(db, Notes { vessels: Some(vec![6]), ..any() }).await,
            [3, 2],
            "and the server's own"
        );
        assert_eq!(times(db, Notes { vessels: Some(Vec::new()), ..any() }).await, [3]);
        assert_eq!(times(db, Notes { vessels: Some(vec![6]), vessel: Some(5), ..any() }).await, [0_i64; 0]);
        assert_eq!(times(db, Notes { priority: Some("alarm".to_owned()), ..any() }).await, [3, 1]);
        assert_eq!(times(db, Notes { from_us: Some(2), to_us: Some(4), ..any() }).await, [3, 2]);
        let first = Notes { count: 2, ..any() }.run(db).await.unwrap();
        assert_eq!(first[1].1, note(3, None, "alarm"));
        assert_eq!(times(db, Notes { before: Some(first[1].0), ..any() }).await, [2, 1]);
    }
}
