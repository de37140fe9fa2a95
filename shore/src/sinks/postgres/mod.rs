//! PostgreSQL: everything that is recorded goes into tables there too, for those who outgrow one computer or join it with their own.
//!
//! Rows have the key of the history's, so that what is sent twice is there once: a batch that was committed and not noted comes
//! again and changes nothing. All rows of a batch are one transaction. Rows that PostgreSQL refuses are found by halving the
//! batch behind savepoints, and passed over.

mod batch;
mod layout;
mod options;
mod row;
mod session;
mod trouble;
mod views;

use super::carrier::{Refused, Sink};
use super::settings;
use anyhow::Context as _;
use batch::{Batch, copied};
use imc::PacketView;
use layout::TableId;
use options::options;
use row::{Item, Row};
use session::{Session, Trouble};
use sqlx::postgres::PgConnectOptions;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use trouble::{explained, is_of_a_row, reason, refuses_all};
use units::UtcTime;

/// Tables of which it is said that they refuse rows.
const MOST_SAID: usize = 100;
/// Rows of a batch that a table may refuse before it takes one.
const MOST_REFUSED: usize = 100;
/// Batches of a table that are merged after one of which a row was there: PostgreSQL's log has a line for each COPY that it refuses.
const MERGED: u8 = 20;

/// A PostgreSQL that is written to.
pub(crate) struct Postgres {
    settings: settings::Postgres,
    /// Of the settings, and of the files that they named when it was opened last.
    options: PgConnectOptions,
    target: String,
    schema: String,
    session: Option<Session>,
    /// What the database said of itself with the last batch that is known to be there: which filling, and how many batches.
    noted: Option<(String, i64)>,
    has_lost_all: bool,
    /// Those that are in the table of vessels.
    vessels: BTreeSet<u16>,
    refused: Refused,
    said: BTreeSet<TableId>,
    /// Tables of which rows may be there already, with how many batches are still merged: others are copied, which takes half the time.
    merged: BTreeMap<TableId, u8>,
}

/// Whether rows that are refused are looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Rows {
    All,
    AllThatAreTaken,
}

impl Postgres {
    /// As it is configured; `None` when it is not.
    ///
    /// # Errors
    /// What is configured cannot be used; the error names the key.
    pub(crate) fn new(settings: &settings::Postgres) -> anyhow::Result<Option<Self>> {
        if settings.url.is_empty() {
            return Ok(None);
        }
        let schema = settings.schema.clone();
        Ok(Some(Self {
            options: options(settings)?,
            settings: settings.clone(),
            target: format!("{} schema {schema}", settings.url),
            schema,
            session: None,
            noted: None,
            has_lost_all: false,
            vessels: BTreeSet::new(),
            refused: Refused::default(),
            said: BTreeSet::new(),
            merged: BTreeMap::new(),
        }))
    }

    fn explained(&self, trouble: Trouble) -> anyhow::Error {
        match trouble {
            Trouble::Sql(error) => explained(&error, self.options.get_username(), &self.schema),
            Trouble::Said(text) => anyhow::Error::msg(text),
        }
    }

    /// Writes a batch by one transaction.
    async fn put(&mut self, session: &mut Session, batch: &Batch<'_>) -> Result<(), Trouble> {
        for table in batch.rows.keys() {
            session.need(*table).await?;
        }
        match self.transaction(session, batch, Rows::All).await {
            Err(Trouble::Sql(error)) if is_of_a_row(&error) => {
                session.run("ROLLBACK".to_owned()).await?;
                self.transaction(session, batch, Rows::AllThatAreTaken).await
            }
            other => other,
        }
    }

    async fn transaction(
        &mut self,
        session: &mut Session,
        batch: &Batch<'_>,
        rows: Rows,
    ) -> Result<(), Trouble> {
        let mut refused = Vec::new();
        // A constraint that somebody deferred would speak at the end, when nobody knows of which row.
        session.run("BEGIN; SET CONSTRAINTS ALL IMMEDIATE".to_owned()).await?;
        let tables: Vec<TableId> = batch.rows.keys().copied().collect();
        session.hold(&tables).await?;
        for (table, its_rows) in &batch.rows {
            match rows {
                Rows::All => self.put_table(session, *table, &copied(its_rows)).await?,
                Rows::AllThatAreTaken => put_by_parts(session, *table, its_rows, &mut refused).await?,
            }
        }
        put_vessels(session, batch, &self.vessels).await?;
        let count = session.count().await?;
        session.run("COMMIT".to_owned()).await?;
        self.noted = Some((session.id.clone(), count));
        self.vessels.extend(batch.vessels.keys());
        for (row, reason) in refused {
            self.refuse(row, &reason);
        }
        Ok(())
    }

    /// Writes all rows of a table: copied where they are new, and merged where one is there.
    async fn put_table(&mut self, session: &mut Session, table: TableId, data: &[u8]) -> Result<(), Trouble> {
        let merged = self.merged.entry(table).or_insert(1);
        if *merged == 0 {
            if session.put_new(table, data).await? {
                return Ok(());
            }
            *merged = MERGED;
        }
        *merged -= 1;
        session.put(table, data).await
    }

    /// Passes a row over that PostgreSQL will never take.
    fn refuse(&mut self, row: &Row, why: &str) {
        let table = layout::Table::new(row.table).name;
        let reason = format!("table {}.{table}: {why}", self.schema);
        if self.said.len() < MOST_SAID && self.said.insert(row.table) {
            tracing::warn!(to = self.target, "PostgreSQL: a row is passed over: {reason}");
        }
        self.refused.add(|| reason);
    }
}

/// Notes vessels that are new, and of each that said its name when it did so last, so that an older log does not rename it.
async fn put_vessels(session: &mut Session, batch: &Batch<'_>, known: &BTreeSet<u16>) -> Result<(), Trouble> {
    for (src, name) in &batch.vessels {
        if name.is_none() && known.contains(src) {
            continue;
        }
        let name = name.map(|(time, name)| (time, imc::text::escape(name.name.as_bytes()), name.kind));
        let name = name.as_ref().map(|(time, name, kind)| (*time, &**name, *kind));
        session.vessel(*src, name).await?;
    }
    Ok(())
}

/// Writes the rows of a table that it takes; the others are found by halving. Where it takes none, it is not for the rows.
async fn put_by_parts<'i>(
    session: &mut Session,
    table: TableId,
    rows: &[&'i Row],
    refused: &mut Vec<(&'i Row, String)>,
) -> Result<(), Trouble> {
    let mut parts = VecDeque::from([rows]);
    let (mut refusals, mut takes, mut was_row) = (0, false, false);
    while let Some(part) = next(&mut parts, was_row) {
        was_row = false;
        let Some(why) = put_part(session, table, part).await? else {
            takes = true;
            continue;
        };
        if let [row] = part {
            (refusals, was_row) = (refusals + 1, true);
            if !takes && refusals >= MOST_REFUSED {
                let table = layout::Table::new(table).name;
                return Err(Trouble::Said(refuses_all(&format!("{}.{table}", session.schema), &why)));
            }
            refused.push((*row, why));
        } else {
            let (first, second) = part.split_at(part.len() / 2);
            parts.extend([second, first]);
        }
    }
    Ok(())
}

/// The part that is tried next: after a row that was refused that which waits longest, a large one, so that rows of all parts of
/// a batch are tried early.
fn next<T>(parts: &mut VecDeque<T>, was_row: bool) -> Option<T> {
    if was_row { parts.pop_front() } else { parts.pop_back() }
}

/// Writes rows of a table, or none of them: then why.
async fn put_part(session: &mut Session, table: TableId, part: &[&Row]) -> Result<Option<String>, Trouble> {
    session.run("SAVEPOINT part".to_owned()).await?;
    session.empty_incoming(table).await?;
    match session.put(table, &copied(part)).await {
        Ok(()) => {
            session.run("RELEASE SAVEPOINT part".to_owned()).await?;
            Ok(None)
        }
        Err(Trouble::Sql(error)) if is_of_a_row(&error) => {
            session.run("ROLLBACK TO SAVEPOINT part; RELEASE SAVEPOINT part".to_owned()).await?;
            Ok(Some(reason(&error)))
        }
        Err(error) => Err(error),
    }
}

impl Sink for Postgres {
    type Item = Item;
    const NAME: &'static str = "postgres";
    const TITLE: &'static str = "PostgreSQL";
    const BATCH_ITEMS: usize = 30_000;
    // A transaction's costs are shared by its rows.
    const BATCH_BYTES: usize = 8 << 20;

    fn target(&self) -> String {
        self.target.clone()
    }

    fn note(&self) -> String {
        self.noted.as_ref().map_or_else(String::new, |(id, batch)| format!("{id} {batch}"))
    }

    fn resume(&mut self, note: &str) {
        self.noted = note.split_once(' ').and_then(|(id, batch)| Some((id.to_owned(), batch.parse().ok()?)));
    }

    fn has_lost_all(&self) -> bool {
        self.has_lost_all
    }

    fn wants_the_past(&self) -> bool {
        true
    }

    fn item(view: &PacketView<'_>, received: UtcTime) -> (Item, usize) {
        let item = Item::of(view, received);
        let bytes = item.bytes();
        (item, bytes)
    }

    async fn open(&mut self) -> anyhow::Result<()> {
        self.refused = Refused::default();
        self.has_lost_all = false;
        if self.session.is_some() {
            return Ok(());
        }
        self.vessels.clear();
        // The batch whose commit was not heard of comes again.
        self.merged.clear();
        // A password or an authority that was wrong may be right by now.
        self.options = options(&self.settings)?;
        let session = Session::open(&self.options, &self.schema).await;
        let session = session.map_err(|trouble| self.explained(trouble))?;
        // One batch more is one whose commit was not heard of.
        self.has_lost_all =
            self.noted.as_ref().is_some_and(|(id, batch)| session.id != *id || session.batch < *batch);
        self.noted = Some((session.id.clone(), session.batch));
        self.session = Some(session);
        Ok(())
    }

    async fn write(&mut self, items: &[Item]) -> anyhow::Result<()> {
        // After an error it is opened anew before.
        let mut session = self.session.take().context("no connection is open")?;
        self.put(&mut session, &Batch::of(items)).await.map_err(|trouble| self.explained(trouble))?;
        self.session = Some(session);
        Ok(())
    }

    /// Each batch is committed before it is answered.
    async fn flush(&mut self) -> anyhow::Result<Refused> {
        Ok(std::mem::take(&mut self.refused))
    }
}
