//! The commands that the manual tells people to type, for each program to hold against its own command line.

use crate::repository;
use std::fs;
use std::path::PathBuf;

/// A command as a document has it.
#[derive(Debug, Clone)]
pub struct Said {
    /// File and line.
    pub place: String,
    /// The program and its arguments.
    pub words: Vec<String>,
    /// Whether all of it stands there; in running text it may leave things out.
    pub is_whole: bool,
}

/// The documents that people read to use the programs: the manual, what it takes in, and the first page.
fn documents() -> Vec<PathBuf> {
    let docs = repository().join("docs");
    let in_folder = |folder: PathBuf| {
        let entries = fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
        let paths = entries.map(|entry| entry.expect("an entry of the folder").path());
        let mut pages: Vec<_> =
            paths.filter(|path| path.extension().is_some_and(|one| one == "md")).collect();
        pages.sort();
        pages
    };
    let mut all = in_folder(docs.join("book/src"));
    all.extend(in_folder(docs));
    all.push(repository().join("README.md"));
    all
}

/// What the documents say of `program`.
///
/// # Panics
/// When a document cannot be read, or none says anything of the program: then the wrong files are looked at.
pub fn commands_of(program: &str) -> Vec<Said> {
    let mut all = Vec::new();
    for path in documents() {
        let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let file = path.strip_prefix(repository()).unwrap_or(&path).display();
        all.extend(book::commands(&text, &[program]).into_iter().map(|command| Said {
            place: format!("{file}:{}", command.line),
            words: command.words,
            is_whole: command.is_whole,
        }));
    }
    assert!(all.iter().any(|said| said.is_whole), "the manual has no command of {program}");
    all
}
