//! A file of entries taken where no server runs, by the command line.

use super::import::look;
use super::rows::{All, Write};
use super::service::Called;
use crate::identity::{Fault, Request, vessels};
use crate::logbook::NEWER;
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
    /// The version of the register that was looked at, where it is taken.
    pub apply: Option<i64>,
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
            look(self.kind, &self.bytes, (version, &rows), &called.names(), &|_| None, &|_| true)
        };
        if self.apply.is_some_and(|seen| seen != version) {
            return Err(Fault::refused(NEWER.to_owned()));
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
