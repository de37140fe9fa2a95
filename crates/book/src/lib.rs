//! The manual: chapters in Markdown, in the layout of mdBook, made into HTML with contents, anchors and a search.
//!
//! Text comes in by a function, so that a program can carry the book within itself. [`Book::read`] always gives a book: what is
//! wrong with it (a link that leads nowhere, a file that is missing) stands in [`Book::problems`], for tests to fail on.
//! [`commands()`] finds the commands that a chapter tells people to type.

mod commands;
mod render;
mod search;
mod summary;

pub use commands::{Command, commands};
pub use search::Found;

use render::{Link, Rendered, Target};
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

/// The files that [`Book::read`] asks for, by their path below `src` of the book, such as `alarms.md`.
pub trait Files {
    /// The bytes of a file; `None` if it does not exist.
    fn read(&self, path: &str) -> Option<Cow<'static, [u8]>>;
}

impl<F: Fn(&str) -> Option<Cow<'static, [u8]>>> Files for F {
    fn read(&self, path: &str) -> Option<Cow<'static, [u8]>> {
        self(path)
    }
}

/// All chapters in their order.
#[derive(Debug, Clone, Default)]
pub struct Book {
    chapters: Vec<Chapter>,
    problems: Vec<String>,
}

/// One chapter.
#[derive(Debug, Clone)]
pub struct Chapter {
    /// Its name in addresses: the file's, without `.md`.
    pub name: String,
    /// As the contents call it.
    pub title: String,
    /// The part of the book that begins with it; empty for none.
    pub part: String,
    /// The chapter as HTML.
    pub html: String,
    /// Its sections, the one before the first heading first.
    pub sections: Vec<Section>,
}

/// A heading with the text below it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Section {
    /// Where a link leads to.
    pub anchor: String,
    /// 1 for the chapter's title.
    pub level: u8,
    /// The heading.
    pub heading: String,
    /// The text as plain words.
    pub text: String,
}

impl Book {
    /// Reads `SUMMARY.md` and the chapters that it names. Links to chapters and pictures become addresses below `base`.
    pub fn read(files: &impl Files, base: &str) -> Self {
        let mut book = Self::default();
        let Some(summary) = text(files, "SUMMARY.md") else {
            book.problems.push("SUMMARY.md is missing, or is not UTF-8".to_owned());
            return book;
        };
        let (entries, wrong) = summary::read(&summary);
        book.problems.extend(wrong);
        let named: BTreeMap<_, _> = entries.iter().map(|entry| (entry.file.clone(), entry.name())).collect();
        let mut links = Vec::new();
        for entry in entries {
            let Some(source) = source(files, &entry.file) else {
                book.problems.push(format!("SUMMARY.md names {}, which is missing", entry.file));
                continue;
            };
            let Rendered { html, sections, links: found, problems } =
                render::chapter(&source.text, |target| address(base, &named, source.is_included, target));
            book.problems.extend(problems.into_iter().map(|problem| format!("{}: {problem}", entry.file)));
            links.extend(found.into_iter().map(|link| (entry.file.clone(), source.is_included, link)));
            book.chapters.push(Chapter {
                name: entry.name(),
                title: entry.title,
                part: entry.part,
                html,
                sections,
            });
        }
        book.judge(files, &named, &links);
        book
    }

    /// All chapters in their order.
    pub fn chapters(&self) -> &[Chapter] {
        &self.chapters
    }

    /// What is wrong with the book.
    pub fn problems(&self) -> &[String] {
        &self.problems
    }

    /// The number of a chapter by its name.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.chapters.iter().position(|chapter| chapter.name == name)
    }

    /// Whether there is a chapter `name` with this anchor; an empty anchor is the chapter's beginning.
    pub fn leads(&self, name: &str, anchor: &str) -> bool {
        let chapter = self.chapters.iter().find(|chapter| chapter.name == name);
        chapter.is_some_and(|chapter| {
            anchor.is_empty() || chapter.sections.iter().any(|section| section.anchor == anchor)
        })
    }

    /// Sections with all words of `wanted`, those first whose heading has them.
    pub fn search(&self, wanted: &str) -> Vec<Found<'_>> {
        search::search(&self.chapters, wanted)
    }

    /// Notes links that lead nowhere and names that are there twice.
    fn judge(
        &mut self,
        files: &impl Files,
        named: &BTreeMap<String, String>,
        links: &[(String, bool, Link)],
    ) {
        let mut names = BTreeSet::new();
        let mut wrong = Vec::new();
        for chapter in &self.chapters {
            if !names.insert(&chapter.name) {
                wrong.push(format!("two chapters are called {}", chapter.name));
            }
            let mut anchors = BTreeSet::new();
            for section in &chapter.sections {
                if !anchors.insert(&section.anchor) {
                    wrong.push(format!("{}: two headings have the anchor {}", chapter.name, section.anchor));
                }
            }
        }
        for (file, is_included, link) in links {
            let leads = match &link.target {
                Target::Outside(_) => true,
                Target::Here(anchor) => named.get(file).is_some_and(|name| self.leads(name, anchor)),
                Target::File { path, .. } if link.is_picture => files.read(path).is_some(),
                Target::File { path, anchor } => match named.get(within(path, *is_included)) {
                    Some(name) => self.leads(name, anchor),
                    // An included text may name files that the book lacks; they are not made links.
                    None => *is_included,
                },
            };
            if !leads {
                wrong.push(format!("{file}: the link to {} leads nowhere", link.target));
            }
        }
        self.problems.extend(wrong);
    }
}

/// A chapter's text, and whether it stands elsewhere and is taken in by `{{#include PATH}}`, as mdBook has it.
struct Source {
    text: String,
    is_included: bool,
}

fn source(files: &impl Files, file: &str) -> Option<Source> {
    let own = text(files, file)?;
    let included = own.trim().strip_prefix("{{#include ").and_then(|rest| rest.strip_suffix("}}"));
    match included {
        Some(path) => Some(Source { text: text(files, path.trim())?, is_included: true }),
        None => Some(Source { text: own, is_included: false }),
    }
}

fn text(files: &impl Files, path: &str) -> Option<String> {
    String::from_utf8(files.read(path)?.into_owned()).ok()
}

/// The name of a chapter's file in a path: what is taken in from another folder says `book/src/alarms.md` or `mqtt.md`.
fn within(path: &str, is_included: bool) -> &str {
    if is_included { path.strip_prefix("book/src/").unwrap_or(path) } else { path }
}

/// The address of a link in a browser; `None` if the target is not part of the book.
fn address(
    base: &str,
    named: &BTreeMap<String, String>,
    is_included: bool,
    target: &Target,
) -> Option<String> {
    match target {
        Target::Outside(address) => Some(address.clone()),
        Target::Here(anchor) => Some(format!("#{anchor}")),
        Target::File { path, anchor } => match named.get(within(path, is_included)) {
            Some(name) if anchor.is_empty() => Some(format!("{base}/{name}")),
            Some(name) => Some(format!("{base}/{name}#{anchor}")),
            None if path.starts_with("pictures/") => Some(format!("{base}/{path}")),
            None => None,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn book(files: &'static [(&'static str, &'static str)]) -> Book {
        let read = move |path: &str| {
            let found = files.iter().find(|(name, _)| *name == path);
            found.map(|(_, text)| Cow::Borrowed(text.as_bytes()))
        };
        Book::read(&read, "/help")
    }

    #[test]
    fn chapters_come_in_the_order_of_the_summary_with_their_parts() {
        let book = book(&[
            ("SUMMARY.md", "# Summary\n\n[Welcome](welcome.md)\n\n# At sea\n\n- [Alarms](alarms.md)\n"),
            (
                "welcome.md",
                "# Welcome\n\nSee [the battery](alarms.md#battery) and ![a boat](pictures/boat.webp).",
            ),
            ("alarms.md", "# Alarms\n\n## Battery low {#battery}\n\nBring it home. [Top](#alarms)"),
            ("pictures/boat.webp", "RIFF"),
        ]);
        assert_eq!(book.problems(), &[] as &[String]);
        let names: Vec<_> = book.chapters().iter().map(|one| (&*one.name, &*one.part)).collect();
        assert_eq!(names, [("welcome", ""), ("alarms", "At sea")]);
        assert!(book.chapters()[0].html.contains(r#"<a href="/help/alarms#battery">the battery</a>"#));
        assert!(book.chapters()[0].html.contains(r#"<img src="/help/pictures/boat.webp" alt="a boat" />"#));
        assert!(
            book.leads("alarms", "battery") && book.leads("alarms", "") && !book.leads("alarms", "motor")
        );
        assert_eq!(book.position("alarms"), Some(1));
    }

    #[test]
    fn links_that_lead_nowhere_are_named() {
        let book = book(&[
            ("SUMMARY.md", "- [A](a.md)\n- [B](b.md)\n- [C](c.md)\n"),
            (
                "a.md",
                "# A\n\n[x](b.md#none) [y](none.md) [z](#none) ![p](pictures/none.png) [ok](https://x.org)",
            ),
            ("b.md", "# B\n\n## Twice\n\n## Twice\n"),
        ]);
        let said = book.problems().join("\n");
        for wrong in [
            "b.md#none",
            "none.md",
            "#none",
            "pictures/none.png",
            "c.md, which is missing",
            "the anchor twice",
        ] {
            assert!(said.contains(wrong), "{wrong} in\n{said}");
        }
        assert_eq!(book.problems().len(), 6, "{said}");
    }

    #[test]
    fn a_text_that_stands_elsewhere_is_taken_in_and_what_the_book_lacks_is_no_link() {
        let book = book(&[
            ("SUMMARY.md", "- [Topics](topics.md)\n- [Alarms](alarms.md)\n"),
            ("topics.md", "{{#include ../../topics.md}}\n"),
            (
                "../../topics.md",
                "# Topics\n\n[code](../server/README.md), [alarms](book/src/alarms.md#alarms)",
            ),
            ("alarms.md", "# Alarms\n"),
        ]);
        assert_eq!(book.problems(), &[] as &[String]);
        let html = &book.chapters()[0].html;
        assert!(html.contains("code, <a href=\"/help/alarms#alarms\">alarms</a>"), "{html}");
    }
}
