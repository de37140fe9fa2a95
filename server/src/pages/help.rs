//! The manual at `/help`: `docs/book` within the program, as pages with contents, a search, and its pictures.
//!
//! The text is English. Where the reader chose another language the page says so once, and marks the text as English.

use super::frame::{Frame, PageError, html};
use crate::AppState;
use crate::web::ApiError;
use api::say;
use askama::Template;
use axum::extract::{Path, Query, State};
use axum::http::header;
use axum::response::{IntoResponse, Response};
use book::{Book, Section};
use rust_embed::RustEmbed;
use serde::Deserialize;
use shore::identity::Language;
use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

/// Where the pages of the manual are.
const BASE: &str = "/help";
/// Letters of a search that count.
const MOST_ASKED: usize = 100;

/// All of `docs`: the book takes chapters in that stand beside it. Only what its summary names is shown. A debug build reads the
/// folder, so that a change shows after a restart.
#[derive(RustEmbed)]
#[folder = "../docs"]
struct Docs;

/// The manual, made of its text when somebody asks for it first.
#[derive(Clone, Default)]
pub(crate) struct Manual(Arc<OnceLock<Book>>);

impl Manual {
    /// The book.
    pub(crate) fn book(&self) -> &Book {
        self.0.get_or_init(|| Book::read(&file, BASE))
    }
}

/// A file of the book by its path below `docs/book/src`; `../../mqtt.md` stands in `docs`.
fn file(path: &str) -> Option<Cow<'static, [u8]>> {
    let within = path.strip_prefix("../../").map_or_else(|| format!("book/src/{path}"), str::to_owned);
    Docs::get(&within).map(|file| file.data)
}

/// A chapter in the contents.
struct Entry<'a> {
    part: &'a str,
    name: &'a str,
    title: &'a str,
    is_current: bool,
    /// The headings below the title, of the chapter that is shown.
    sections: Vec<&'a Section>,
}

/// The contents, with the sections of the chapter at `current`.
fn contents(book: &Book, current: Option<usize>) -> Vec<Entry<'_>> {
    let chapters = book.chapters().iter().enumerate();
    let shown = chapters.map(|(at, chapter)| {
        let is_current = Some(at) == current;
        let below = |section: &&Section| is_current && section.level == 2;
        let sections = chapter.sections.iter().filter(below).collect();
        Entry { part: &chapter.part, name: &chapter.name, title: &chapter.title, is_current, sections }
    });
    shown.collect()
}

#[derive(Template)]
#[template(path = "help.html")]
struct ChapterPage<'a> {
    frame: Frame,
    contents: Vec<Entry<'a>>,
    wanted: &'a str,
    chapter: &'a book::Chapter,
    before: Option<&'a book::Chapter>,
    after: Option<&'a book::Chapter>,
}

#[derive(Template)]
#[template(path = "help_search.html")]
struct SearchPage<'a> {
    frame: Frame,
    contents: Vec<Entry<'a>>,
    wanted: &'a str,
    found: Vec<book::Found<'a>>,
}

/// What is searched for.
#[derive(Debug, Default, Deserialize)]
pub(super) struct Wanted {
    #[serde(default)]
    q: String,
}

/// `GET /help`: the first chapter, or what a search finds.
pub(super) async fn first(
    State(state): State<AppState>,
    frame: Frame,
    Query(wanted): Query<Wanted>,
) -> Result<Response, PageError> {
    let book = state.manual.book();
    let wanted: String = wanted.q.trim().chars().take(MOST_ASKED).collect();
    if wanted.is_empty() {
        return show(book, frame, 0);
    }
    let found = book.search(&wanted);
    Ok(html(&SearchPage { frame, contents: contents(book, None), wanted: &wanted, found }))
}

/// `GET /help/{chapter}`.
pub(super) async fn chapter(
    State(state): State<AppState>,
    frame: Frame,
    Path(name): Path<String>,
) -> Result<Response, PageError> {
    let book = state.manual.book();
    let at = book.position(&name).ok_or_else(no_chapter)?;
    show(book, frame, at)
}

/// `GET /help/pictures/{name}`.
pub(super) async fn picture(Path(name): Path<String>) -> Result<Response, PageError> {
    let kind = match name.rsplit_once('.') {
        Some((_, "webp")) => "image/webp",
        Some((_, "png")) => "image/png",
        Some((_, "svg")) => "image/svg+xml",
        _ => return Err(no_picture().into()),
    };
    let picture = file(&format!("pictures/{name}")).ok_or_else(no_picture)?;
    // The same for all, and it changes with the program only.
    let headers = [(header::CONTENT_TYPE, kind), (header::CACHE_CONTROL, "public, max-age=3600")];
    Ok((headers, picture.into_owned()).into_response())
}

fn show(book: &Book, frame: Frame, at: usize) -> Result<Response, PageError> {
    let chapter = book.chapters().get(at).ok_or_else(no_chapter)?;
    let beside = |at: Option<usize>| at.and_then(|at| book.chapters().get(at));
    Ok(html(&ChapterPage {
        frame,
        contents: contents(book, Some(at)),
        wanted: "",
        chapter,
        before: beside(at.checked_sub(1)),
        after: beside(at.checked_add(1)),
    }))
}

fn no_chapter() -> ApiError {
    ApiError::not_found(say("The manual has no such chapter. Its contents are at /help."))
}

fn no_picture() -> ApiError {
    ApiError::not_found(say("The manual has no such picture."))
}

#[cfg(test)]
mod tests {
    use super::*;
    use operations::alarms::Kind;
    use std::fs;
    use std::path::{Path as FilePath, PathBuf};

    fn book() -> Book {
        Book::read(&file, BASE)
    }

    #[test]
    fn the_book_has_no_links_that_lead_nowhere() {
        let book = book();
        assert!(book.problems().is_empty(), "{}", book.problems().join("\n"));
        assert!(book.chapters().len() > 10);
    }

    #[test]
    fn every_alarm_has_a_section() {
        let book = book();
        let lacking = Kind::ALL.into_iter().filter(|kind| !book.leads("alarms", kind.name()));
        let names: Vec<_> = lacking.map(Kind::name).collect();
        assert!(names.is_empty(), "docs/book/src/alarms.md has no `## … {{#KIND}}` for {names:?}");
    }

    /// The files below `folder` with these endings.
    fn files(folder: &FilePath, endings: &[&str]) -> Vec<PathBuf> {
        let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        let within = entries.flat_map(|path| if path.is_dir() { files(&path, endings) } else { vec![path] });
        let fits =
            |path: &PathBuf| path.extension().is_some_and(|one| endings.iter().any(|ending| one == *ending));
        within.filter(fits).collect()
    }

    #[test]
    fn pages_link_to_what_the_book_has() {
        let (book, root) = (book(), testkit::repository());
        let mut links = 0;
        for path in
            [files(&root.join("web/src"), &["ts", "tsx"]), files(&root.join("server/templates"), &["html"])]
                .concat()
        {
            let text = fs::read_to_string(&path).unwrap();
            for rest in text.split("/help/").skip(1) {
                let address: String = rest.chars().take_while(|one| !"\"'`?<> ".contains(*one)).collect();
                let (name, anchor) = address.split_once('#').unwrap_or((&address, ""));
                // `${…}` and `{{ … }}` stand for what other tests look at: each kind of alarm, each chapter.
                if name.starts_with(['{', '$']) || name == "pictures" {
                    continue;
                }
                let anchor = if anchor.starts_with(['{', '$']) { "" } else { anchor };
                assert!(
                    book.leads(name, anchor),
                    "{} links to /help/{address}, which is not there",
                    path.display()
                );
                links += 1;
            }
        }
        assert!(links > 5, "{links} links only");
    }
}
