//! Imports a file of entries directly, for the command line.

use super::import::look;
use super::rows::{All, Write};
use super::service::Called;
use crate::identity::{Fault, Request, vessels};
use crate::logbook::NEWER;
use api::{RegisterImport, RegisterKind};
use sqlx::SqliteConnection;
use units::UtcTime;

/// Determines what a file of entries would change, and applies it if requested and nothing is wrong.
#[derive(Debug)]
pub struct TakeFile {
    /// Kind of its entries.
    pub kind: RegisterKind,
    /// The file.
    pub bytes: Vec<u8>,
    /// The register's version at the preview, if the file is to be applied.
    pub apply: Option<i64>,
    /// On whose behalf.
    pub by: String,
    /// Time of the request.
    pub now: UtcTime,
}

impl Request for TakeFile {
    type Answer = RegisterImport;

    async fn run(self, db: &mut SqliteConnection) -> Result<RegisterImport, Fault> {
        let (version, rows) = All.run(&mut *db).await?;
        let named = vessels::List.run(&mut *db).await?;
        let (mut answer, steps) = {
            let called = Called::new(&named);
            look(self.kind, &self.bytes, (version, &rows), &called.names(), &|_| None, &|_| true)
        };
        if self.apply.is_some_and(|seen| seen != version) {
            return Err(Fault::refused(NEWER));
        }
        if self.apply.is_some() && answer.problems.is_empty() {
            if !steps.is_empty() {
                Write { steps, version: self.apply, by: self.by, now: self.now, asked: None }.run(db).await?;
                answer.version += 1;
            }
            answer.applied = true;
        }
        Ok(answer)
    }
}
