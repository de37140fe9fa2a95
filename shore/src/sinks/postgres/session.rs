//! One connection to PostgreSQL, with what is known of the schema there.
//!
//! A session is given up after any error but one that a row causes; the next one looks at everything anew. A row of
//! [`STATE`] counts the batches in the transaction of each, so that a database that was emptied or set back is known as such.

mod view;

use super::layout::{self, Table, TableId};
use super::trouble::altered;
use sqlx::postgres::{PgConnectOptions, PgConnection};
use sqlx::{AssertSqlSafe, ConnectOptions as _, Executor as _};
use std::collections::BTreeMap;
use std::time::Duration;

/// A server that does not let us in for so long is taken to be gone.
const CONNECT: Duration = Duration::from_secs(15);
/// One that does not answer for so long, likewise: rows of a whole batch are checked meanwhile.
const PATIENCE: Duration = Duration::from_mins(5);
/// Bytes that are sent at once.
const CHUNK: usize = 64 * 1024;
/// The first version that has computed columns.
const OLDEST: i32 = 120_000;
/// The form of the tables.
const LAYOUT: i32 = 1;
/// What says how far the server is.
pub(super) const STATE: &str = "_lutra";

/// Why something did not work.
#[derive(Debug)]
pub(super) enum Trouble {
    Sql(sqlx::Error),
    /// In words.
    Said(String),
}

impl From<sqlx::Error> for Trouble {
    fn from(error: sqlx::Error) -> Self {
        Self::Sql(error)
    }
}

/// A connection that stands.
pub(super) struct Session {
    connection: PgConnection,
    pub(super) schema: String,
    /// Tables that are as they must be.
    tables: BTreeMap<TableId, Table>,
    /// What there was in the schema when it was opened.
    there: Columns,
    /// The schema of TimescaleDB, where it is installed.
    timescale: Option<String>,
    /// Which filling of the schema this is.
    pub(super) id: String,
    /// Batches that it got.
    pub(super) batch: i64,
}

/// Columns that are there, by their table.
type Columns = BTreeMap<String, BTreeMap<String, There>>;

/// A column that is there.
#[derive(Debug)]
struct There {
    kind: String,
    /// A row must give it a value.
    must: bool,
}

/// What a server says of itself.
#[derive(Debug, sqlx::FromRow)]
struct About {
    version: i32,
    encoding: String,
    commits: String,
    has_schema: bool,
    postgis: Option<String>,
    timescale: Option<String>,
}

impl Session {
    /// Connects, and makes what is missing but the messages' tables.
    ///
    /// # Errors
    /// The server is not there or not as it must be.
    pub(super) async fn open(options: &PgConnectOptions, schema: &str) -> Result<Self, Trouble> {
        let connection = tokio::time::timeout(CONNECT, options.connect()).await;
        let connection = connection
            .map_err(|_| Trouble::Said(format!("no connection within {} s", CONNECT.as_secs())))??;
        let mut session = Self {
            connection,
            schema: schema.to_owned(),
            tables: BTreeMap::new(),
            there: Columns::new(),
            timescale: None,
            id: String::new(),
            batch: 0,
        };
        session
            .run("SET client_min_messages = error; SET standard_conforming_strings = on".to_owned())
            .await?;
        let about = session.about().await?;
        session.check(&about).await?;
        session.timescale = about.timescale;
        if !about.has_schema {
            session.run(format!("CREATE SCHEMA \"{schema}\"")).await?;
        }
        session.there = session.columns(None).await?;
        session.begin_state().await?;
        session.make_vessels(about.postgis.as_deref()).await?;
        Ok(session)
    }

    async fn about(&mut self) -> Result<About, Trouble> {
        const ABOUT: &str = "SELECT current_setting('server_version_num')::int AS version, \
             current_setting('server_encoding') AS encoding, current_setting('synchronous_commit') AS commits, \
             EXISTS (SELECT FROM pg_namespace WHERE nspname = $1) AS has_schema, \
             (SELECT n.nspname::text FROM pg_extension e JOIN pg_namespace n ON n.oid = e.extnamespace \
              WHERE e.extname = 'postgis') AS postgis, \
             (SELECT n.nspname::text FROM pg_extension e JOIN pg_namespace n ON n.oid = e.extnamespace \
              WHERE e.extname = 'timescaledb') AS timescale";
        let asked = sqlx::query_as(ABOUT).bind(&self.schema).fetch_one(&mut self.connection);
        patiently(asked).await
    }

    async fn check(&mut self, about: &About) -> Result<(), Trouble> {
        if about.version < OLDEST {
            return Err(Trouble::Said(format!(
                "PostgreSQL {} is too old; Lutra needs 12 or later",
                about.version / 10_000
            )));
        }
        if about.encoding != "UTF8" {
            return Err(Trouble::Said(format!(
                "its database holds {} and not UTF8, so it cannot hold all text; make another (createdb -E UTF8 -T template0 NAME)",
                about.encoding
            )));
        }
        if about.commits == "off" {
            // What was committed is not carried again, so it must be on the disk.
            self.run("SET synchronous_commit = on".to_owned()).await?;
        }
        Ok(())
    }

    /// What there is in the schema, or of some of its tables.
    async fn columns(&mut self, tables: Option<Vec<String>>) -> Result<Columns, Trouble> {
        const COLUMNS: &str = "SELECT c.relname::text, a.attname::text, format_type(a.atttypid, a.atttypmod), \
             a.attnotnull AND NOT a.atthasdef AND a.attidentity = '' \
             FROM pg_attribute a JOIN pg_class c ON c.oid = a.attrelid JOIN pg_namespace n ON n.oid = c.relnamespace \
             WHERE n.nspname = $1 AND c.relkind IN ('r', 'p', 'v', 'm', 'f') AND a.attnum > 0 AND NOT a.attisdropped \
             AND ($2::text[] IS NULL OR c.relname::text = ANY ($2::text[]))";
        let asked = sqlx::query_as(COLUMNS).bind(&self.schema).bind(tables).fetch_all(&mut self.connection);
        let columns: Vec<(String, String, String, bool)> = patiently(asked).await?;
        let mut there = Columns::new();
        for (table, column, kind, must) in columns {
            there.entry(table).or_default().insert(column, There { kind, must });
        }
        Ok(there)
    }

    /// Keeps tables from being altered until the transaction ends, and sees that none was since they were needed first.
    pub(super) async fn hold(&mut self, ids: &[TableId]) -> Result<(), Trouble> {
        let (mut names, mut locked) = (Vec::new(), Vec::new());
        for table in ids.iter().filter_map(|id| self.tables.get(id)) {
            names.push(table.name.clone());
            locked.push(format!("ONLY {}", table.full_name(&self.schema)));
        }
        if names.is_empty() {
            return Ok(());
        }
        self.run(format!("LOCK TABLE {} IN ROW EXCLUSIVE MODE", locked.join(", "))).await?;
        let there = self.columns(Some(names)).await?;
        for table in ids.iter().filter_map(|id| self.tables.get(id)) {
            if let Some(columns) = there.get(&table.name) {
                unaltered(table, columns, &self.schema)?;
            }
        }
        Ok(())
    }

    async fn begin_state(&mut self) -> Result<(), Trouble> {
        let table = format!("\"{}\".{STATE}", self.schema);
        if !self.there.contains_key(STATE) {
            self.run(format!(
                "CREATE TABLE IF NOT EXISTS {table} (one boolean PRIMARY KEY DEFAULT true CHECK (one), id text NOT NULL, \
                 batch bigint NOT NULL, layout integer NOT NULL); \
                 COMMENT ON TABLE {table} IS 'How far the server is; do not change it'"
            ))
            .await?;
        }
        self.run(format!(
            "INSERT INTO {table} (id, batch, layout) VALUES (md5(random()::text || clock_timestamp()), 0, {LAYOUT}) \
             ON CONFLICT DO NOTHING"
        ))
        .await?;
        let sql = AssertSqlSafe(format!("SELECT id, batch, layout FROM {table}"));
        let (id, batch, layout): (String, i64, i32) =
            patiently(sqlx::query_as(sql).fetch_one(&mut self.connection)).await?;
        if layout > LAYOUT {
            return Err(Trouble::Said(format!(
                "a later version of Lutra made the schema {} (form {layout}); update this server or name another schema",
                self.schema
            )));
        }
        (self.id, self.batch) = (id, batch);
        Ok(())
    }

    /// Makes the table of vessels, and the view of detections with what it is made of.
    async fn make_vessels(&mut self, postgis: Option<&str>) -> Result<(), Trouble> {
        let schema = self.schema.clone();
        if !self.there.contains_key("vessels") {
            self.run(format!(
                "CREATE TABLE \"{schema}\".vessels (src integer PRIMARY KEY, \
                 address text GENERATED ALWAYS AS ('0x' || lpad(to_hex(src), 4, '0')) STORED, name text, kind smallint, \
                 named timestamp with time zone); \
                 COMMENT ON TABLE \"{schema}\".vessels IS 'Every system that spoke, by the newest name that it gave itself'; \
                 COMMENT ON COLUMN \"{schema}\".vessels.kind IS 'IMC SystemType'; \
                 COMMENT ON COLUMN \"{schema}\".vessels.named IS 'when it last said that name'"
            ))
            .await?;
        }
        self.need(TableId::Detections).await?;
        self.make_view(postgis).await
    }

    /// Makes a table, or sees that it is as it must be, and makes what is copied to.
    pub(super) async fn need(&mut self, id: TableId) -> Result<(), Trouble> {
        if self.tables.contains_key(&id) {
            return Ok(());
        }
        let table = Table::new(id);
        match self.there.get(&table.name) {
            None => self.make(&table).await?,
            Some(there) => {
                unaltered(&table, there, &self.schema)?;
                for (column, sql) in table.add_missing(&self.schema, |name| !there.contains_key(name)) {
                    self.run(sql).await?;
                    tracing::warn!(
                        table = table.name,
                        column,
                        "PostgreSQL: a column that was missing is added"
                    );
                }
            }
        }
        self.run(table.create_incoming()).await?;
        self.tables.insert(id, table);
        Ok(())
    }

    /// Makes a table with what belongs to it, all or nothing.
    async fn make(&mut self, table: &Table) -> Result<(), Trouble> {
        let schema = self.schema.clone();
        self.run(format!("BEGIN; {}; {}", table.create(&schema), table.comments(&schema))).await?;
        if !self.make_hypertable(table).await? {
            self.run(table.index_time(&schema)).await?;
        }
        self.run("COMMIT".to_owned()).await
    }

    /// Has TimescaleDB divide a new table, where it is installed; whether it does.
    async fn make_hypertable(&mut self, table: &Table) -> Result<bool, Trouble> {
        let Some(timescale) = &self.timescale else { return Ok(false) };
        let name = layout::quoted(&table.full_name(&self.schema));
        let sql = format!(
            "SAVEPOINT plain; SELECT \"{timescale}\".create_hypertable({name}::regclass, 'time'::name, \
             chunk_time_interval => interval '7 days', if_not_exists => true)"
        );
        match self.run(sql).await {
            Ok(()) => Ok(true),
            Err(Trouble::Sql(error)) if error.as_database_error().is_some() => {
                tracing::warn!(table = table.name, "PostgreSQL: TimescaleDB makes no hypertable: {error}");
                self.run("ROLLBACK TO SAVEPOINT plain".to_owned()).await?;
                Ok(false)
            }
            Err(error) => Err(error),
        }
    }

    /// Statements that answer nothing.
    pub(super) async fn run(&mut self, sql: String) -> Result<(), Trouble> {
        patiently(self.connection.execute(sqlx::raw_sql(AssertSqlSafe(sql)))).await.map(drop)
    }

    /// Copies rows and takes them over into their table, whether they are there or not.
    pub(super) async fn put(&mut self, id: TableId, data: &[u8]) -> Result<(), Trouble> {
        let Some(table) = self.tables.get(&id) else { return Ok(()) };
        let (copy, merge) = (table.copy(), table.merge(&self.schema));
        self.copy_in(&copy, data).await?;
        self.run(merge).await
    }

    /// Copies rows that are not there yet; where one is, or the table takes no COPY, none of them and `false`.
    pub(super) async fn put_new(&mut self, id: TableId, data: &[u8]) -> Result<bool, Trouble> {
        let Some(table) = self.tables.get(&id) else { return Ok(true) };
        let copy = table.copy_new(&self.schema);
        self.run("SAVEPOINT new".to_owned()).await?;
        match self.copy_in(&copy, data).await {
            Ok(()) => self.run("RELEASE SAVEPOINT new".to_owned()).await.map(|()| true),
            Err(Trouble::Sql(error)) if error.as_database_error().is_some() => {
                self.run("ROLLBACK TO SAVEPOINT new; RELEASE SAVEPOINT new".to_owned()).await?;
                Ok(false)
            }
            Err(error) => Err(error),
        }
    }

    async fn copy_in(&mut self, copy: &str, data: &[u8]) -> Result<(), Trouble> {
        let mut copying = patiently(self.connection.copy_in_raw(copy)).await?;
        for chunk in data.chunks(CHUNK) {
            patiently(copying.send(chunk)).await?;
        }
        patiently(copying.finish()).await.map(drop)
    }

    /// Empties what rows of a table are copied to.
    pub(super) async fn empty_incoming(&mut self, id: TableId) -> Result<(), Trouble> {
        let Some(table) = self.tables.get(&id) else { return Ok(()) };
        let sql = table.empty_incoming();
        self.run(sql).await
    }

    /// Notes a vessel, and its name where that is not older than the one that is there.
    pub(super) async fn vessel(&mut self, src: u16, name: Option<(i64, &str, u8)>) -> Result<(), Trouble> {
        let table = format!("\"{}\".vessels", self.schema);
        let sql = match name {
            None => format!("INSERT INTO {table} (src) VALUES ({src}) ON CONFLICT DO NOTHING"),
            Some((time, name, kind)) => format!(
                "INSERT INTO {table} AS there (src, name, kind, named) VALUES ({src}, {}, {kind}, {}) ON CONFLICT (src) DO UPDATE \
                 SET name = EXCLUDED.name, kind = EXCLUDED.kind, named = EXCLUDED.named \
                 WHERE there.named IS NULL OR there.named <= EXCLUDED.named",
                layout::quoted(name),
                layout::time(time)
            ),
        };
        self.run(sql).await
    }

    /// Counts the batch, as part of its transaction.
    pub(super) async fn count(&mut self) -> Result<i64, Trouble> {
        let sql = format!("UPDATE \"{}\".{STATE} SET batch = batch + 1 RETURNING batch", self.schema);
        let asked = sqlx::query_scalar(AssertSqlSafe(sql)).fetch_optional(&mut self.connection);
        patiently(asked).await?.ok_or_else(|| {
            Trouble::Said(format!("the row of {}.{STATE} is gone: everything is carried again", self.schema))
        })
    }
}

/// Sees that a table is as it must be.
fn unaltered(table: &Table, there: &BTreeMap<String, There>, schema: &str) -> Result<(), Trouble> {
    match difference(table, there) {
        None => Ok(()),
        Some(what) => Err(Trouble::Said(altered(&format!("table {} {what}", table.name), schema))),
    }
}

/// How a table is not as it must be; `None` where it is, or lacks columns alone.
fn difference(table: &Table, there: &BTreeMap<String, There>) -> Option<String> {
    for (at, column) in table.columns.iter().enumerate() {
        match there.get(&column.name) {
            None if at < layout::KEY.len() => return Some(format!("has no column {}", column.name)),
            Some(There { kind, .. }) if kind != column.kind.name() => {
                return Some(format!("holds {kind} in {}, not {}", column.name, column.kind.name()));
            }
            _ => {}
        }
    }
    let own = |name: &str| table.columns.iter().any(|column| column.name == name);
    let foreign = there.iter().find(|(name, column)| column.must && !own(name));
    foreign.map(|(name, _)| format!("wants a value for {name} in each row, which no message has"))
}

/// Waits for an answer, but not for ever.
async fn patiently<T>(asked: impl Future<Output = Result<T, sqlx::Error>>) -> Result<T, Trouble> {
    match tokio::time::timeout(PATIENCE, asked).await {
        Ok(answer) => answer.map_err(Trouble::Sql),
        Err(_) => Err(Trouble::Said(format!("it has not answered for {} s", PATIENCE.as_secs()))),
    }
}
