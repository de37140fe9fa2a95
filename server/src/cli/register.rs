//! `lutra-server register`: tables of the register in and out, also while no server runs.

use super::Common;
use super::data::to_output;
use super::people::{ACTOR, act, existing};
use super::say::{complain, counted, say};
use anyhow::{Context as _, bail, ensure};
use api::{RegisterImport, RegisterKind};
use clap::Subcommand;
use research::{kind_of, kind_word, template, write_csv};
use shore::clock;
use shore::identity::{Request as _, vessels, with};
use shore::register::{All, Called, FILE_BYTES, Register, TakeFile};
use std::fs;
use std::path::{Path, PathBuf};
use store::Exported;

#[derive(Debug, Subcommand)]
pub(super) enum RegisterCommand {
    /// Write a table of the register as CSV; without entries it is the template of a file to import.
    Export {
        /// person, project, animal, tag, receiver or deployment.
        #[arg(value_parser = kind)]
        kind: RegisterKind,
        /// The file to write; - or nothing for the standard output.
        #[arg(short, long, value_name = "FILE")]
        output: Option<PathBuf>,
    },
    /// Take a table as CSV into the register: whole, or not at all. Without --yes only the changes are printed.
    ///
    /// A line changes the entry of its name, or adds one. Columns that the table does not have stay as they are.
    Import {
        /// person, project, animal, tag, receiver or deployment.
        #[arg(value_parser = kind)]
        kind: RegisterKind,
        /// The table.
        #[arg(value_name = "CSV")]
        file: PathBuf,
        /// Do it.
        #[arg(long)]
        yes: bool,
    },
    /// List the columns of a table, and their meaning.
    Columns {
        /// person, project, animal, tag, receiver or deployment.
        #[arg(value_parser = kind)]
        kind: RegisterKind,
    },
}

fn kind(text: &str) -> Result<RegisterKind, String> {
    Register::kind(text).map_err(|error| error.text.into())
}

/// `lutra-server register`.
pub(super) fn register(common: &Common, command: &RegisterCommand) -> anyhow::Result<()> {
    match command {
        RegisterCommand::Export { kind, output } => export(common, *kind, output.as_deref()),
        RegisterCommand::Import { kind, file, yes } => import(common, *kind, file, *yes),
        RegisterCommand::Columns { kind } => {
            for (name, about) in template(*kind).1 {
                say!("{name:24} {about}");
            }
            Ok(())
        }
    }
}

fn export(common: &Common, wanted: RegisterKind, output: Option<&Path>) -> anyhow::Result<()> {
    let data = existing(common)?.data;
    let ((_, rows), named) = with(&data, async |db| (All, vessels::List).run(db).await)?;
    let records: Vec<_> =
        rows.iter().map(|row| &row.record).filter(|record| kind_of(record) == wanted).collect();
    let bytes = write_csv(wanted, records.iter().copied(), &Called::new(&named).names());
    to_output(output, true, &mut |out| {
        out.write_all(&bytes)?;
        Ok(Exported { rows: records.len() as u64, bytes: bytes.len() as u64 })
    })
}

fn import(common: &Common, kind: RegisterKind, file: &Path, apply: bool) -> anyhow::Result<()> {
    let data = existing(common)?.data;
    let bytes = fs::read(file).with_context(|| file.display().to_string())?;
    ensure!(
        bytes.len() <= FILE_BYTES,
        "{}: has more than {} MiB; divide it",
        file.display(),
        FILE_BYTES >> 20
    );
    let take = TakeFile { kind, bytes, apply: None, by: ACTOR.to_owned(), now: clock::now() };
    let looked = TakeFile { bytes: take.bytes.clone(), by: take.by.clone(), ..take };
    let told = with(&data, async |db| looked.run(db).await)?;
    tell(&told);
    let count = told.problems.len();
    if count > 0 {
        bail!("{}: nothing was taken: {}", file.display(), counted(count, "problem"));
    }
    let word = kind_word(kind);
    if !apply {
        say!(
            "{} new, {} changed, {} as they are; nothing was done: add --yes to do it",
            told.added,
            told.changed,
            told.same
        );
        return Ok(());
    }
    let subject = format!("{word}: {} new, {} changed, by a file", told.added, told.changed);
    let take = TakeFile { apply: Some(told.version), ..take };
    let done = with(&data, async |db| act(db, "register.import", &subject, take).await)?;
    ensure!(done.applied, "{}: the register was changed meanwhile: look again", file.display());
    say!("{} new, {} changed, {} as they were", done.added, done.changed, done.same);
    Ok(())
}

/// Prints the changes and problems.
fn tell(told: &RegisterImport) {
    for change in &told.changes {
        let what = if change.is_new { "new" } else { "changed" };
        let fields =
            change.fields.iter().map(|one| format!("{} `{}` → `{}`", one.column, one.before, one.after));
        let fields = if change.is_new {
            String::new()
        } else {
            format!(": {}", fields.collect::<Vec<_>>().join(", "))
        };
        say!("line {}: {what} {}{fields}", change.line, change.name);
    }
    for problem in &told.problems {
        let line = problem.line.map_or_else(|| "the register".to_owned(), |line| format!("line {line}"));
        let column = if problem.column.is_empty() { String::new() } else { format!(", {}", problem.column) };
        complain!("{line}{column}: {}", problem.text);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mistyped_folder_is_told_and_nothing_is_made_of_it() {
        let scratch = tempfile::tempdir().unwrap();
        let data = scratch.path().join("mistyped");
        let common = Common { config: None, data: Some(data.clone()), set: Vec::new() };
        let file = scratch.path().join("animals.csv");
        fs::write(&file, "name\nA\n").unwrap();
        let output = scratch.path().join("out.csv");
        for done in [
            import(&common, RegisterKind::Animal, &file, true),
            export(&common, RegisterKind::Animal, Some(&output)),
        ] {
            let error = done.unwrap_err();
            assert!(format!("{error:#}").contains("mistyped has no app.db: give --data"), "{error:#}");
        }
        assert!(!data.exists() && !output.exists());
    }
}
