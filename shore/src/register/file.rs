//! A file of entries taken where no server runs, by the command line.

use super::import::look;
use super::rows::{All, Write};
use super::service::Called;
use crate::identity::{Fault, Request, vessels};
use api::{RegisterImport, RegisterKind};
use sqlx::SqliteConnection;
use units::UtcTime;

/// Looks what a file of entries would change, and, where that is wanted and nothing is wrong, changes it.
#[derive(Debug)]
pub struct TakeFile {
    /// What its lines are.
    pub kind: RegisterKind,
    /// The file.
    pub bytes: Vec<u8>,
    /// Whether it is taken.
    pub apply: bool,
    /// In whose name.
    pub by: String,
    /// When.
    pub now: UtcTime,
}

impl Request for TakeFile {
    type Answer = RegisterImport;

    async fn run(self, db: &mut SqliteConnection) -> Result<RegisterImport, Fault> {
        let (version, rows) = All.run(&mut *db).await?;
        let named = vessels::List.run(&mut *db).await?;
        let (mut answer, steps) = {
            let called = Called::new(&named);
            look(self.kind, &self.bytes, (version, &rows), &called.names(), &|_| None)
        };
        if self.apply && answer.problems.is_empty() {
            if !steps.is_empty() {
                Write { steps, version: None, by: self.by, now: self.now }.run(db).await?;
                answer.version += 1;
            }
            answer.applied = true;
        }
        Ok(answer)
    }
}
