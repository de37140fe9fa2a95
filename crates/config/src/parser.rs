//! Reads a file of the DUNE `.ini` dialect and everything it requires or includes.
//!
//! The forms of a line are those of DUNE's `Parsers/Config.cpp`. Where a form does
//! something else than it seems to, what DUNE does is done, so that a file means the same on both, and the
//! report says so. Nothing here grows faster than its input: files, lines, values and nesting have limits.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::edit::{Cursor, Edits};
use crate::ini::Ini;
use crate::line::{Header, Line, Lines, MAX_LINE_BYTES, RawLine, classify, is_misspelt_keyword, trim};
use crate::problem::{Place, Problem, ProblemKind, Report};
use crate::source::{FileSource, normalised};

/// How many files one configuration may be made of, repetitions counted.
pub const MAX_FILES: usize = 256;
/// How deep files may require each other.
pub const MAX_DEPTH: usize = 16;
/// How many bytes all files together may have.
pub const MAX_TOTAL_BYTES: usize = 4 << 20;
/// How many lines that say something all files together may have.
pub const MAX_LINES: usize = 50_000;

/// Reads files into an [`Ini`], collecting problems.
#[derive(Debug)]
pub(crate) struct Parser<'s, S> {
    source: &'s S,
    edits: Edits,
    open: Vec<PathBuf>,
    seen: BTreeSet<PathBuf>,
    files: Vec<Arc<str>>,
    total_bytes: usize,
    total_lines: usize,
}

/// How a missing file is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Need {
    /// `[Require ..]`, or the file asked for.
    Required,
    /// `[Include ..]`.
    Optional,
}

/// The state of reading one file.
#[derive(Debug)]
struct FileState {
    name: Arc<str>,
    cursor: Option<Cursor>,
    /// The directive in place of a section, until a real section follows.
    after_directive: Option<Place>,
}

impl<'s, S: FileSource> Parser<'s, S> {
    pub(crate) fn new(source: &'s S) -> Self {
        Self {
            source,
            edits: Edits::default(),
            open: Vec::new(),
            seen: BTreeSet::new(),
            files: Vec::new(),
            total_bytes: 0,
            total_lines: 0,
        }
    }

    /// The settings read, the problems found and the files read, in this order.
    pub(crate) fn finish(self) -> (Ini, Report, Vec<Arc<str>>) {
        (self.edits.ini, self.edits.report, self.files)
    }

    /// Where problems go.
    pub(crate) const fn report(&mut self) -> &mut Report {
        &mut self.edits.report
    }

    /// Reads `path` unless it does not exist; returns whether it does.
    pub(crate) fn file_if_present(&mut self, path: &Path) -> bool {
        let path = normalised(path);
        match self.source.read(&path) {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => false,
            Ok(_) | Err(_) => {
                self.file(&path, None, Need::Required);
                true
            }
        }
    }

    /// Reads `path`, asked for by the line `asked_at`.
    pub(crate) fn file(&mut self, path: &Path, asked_at: Option<&Place>, need: Need) {
        let path = normalised(path);
        if !self.may_open(&path, asked_at) {
            return;
        }
        let bytes = match self.source.read(&path) {
            Ok(bytes) => bytes,
            Err(error) => return self.unreadable(&path, asked_at, need, &error),
        };
        self.total_bytes += bytes.len();
        if self.total_bytes > MAX_TOTAL_BYTES {
            let what = format!("all files together exceed {MAX_TOTAL_BYTES} bytes; the rest is left out");
            return self.limit(asked_at, what);
        }
        if !self.seen.insert(path.clone()) {
            let what = format!("`{}` is read once more; its values override again", path.display());
            self.report().add(Problem::note(ProblemKind::Repeated, asked_at, what));
        }
        let name: Arc<str> = path.display().to_string().into();
        self.files.push(Arc::clone(&name));
        self.open.push(path);
        self.lines(name, &bytes);
        self.open.pop();
    }

    fn may_open(&mut self, path: &Path, asked_at: Option<&Place>) -> bool {
        if let Some(at) = self.open.iter().position(|open| open == path) {
            let chain: Vec<String> =
                self.open[at..].iter().map(PathBuf::as_path).chain([path]).map(display).collect();
            let what = format!("files require each other in a circle: {}", chain.join(" -> "));
            self.report().add(
                Problem::error(ProblemKind::IncludeCycle, asked_at, what)
                    .remedy("take one of these [Require] or [Include] lines out"),
            );
            return false;
        }
        if self.open.len() >= MAX_DEPTH {
            self.limit(asked_at, format!("files require each other more than {MAX_DEPTH} deep"));
            return false;
        }
        if self.files.len() >= MAX_FILES {
            self.limit(asked_at, format!("more than {MAX_FILES} files; `{}` is left out", path.display()));
            return false;
        }
        true
    }

    fn unreadable(&mut self, path: &Path, asked_at: Option<&Place>, need: Need, error: &std::io::Error) {
        let what = format!("cannot read `{}`: {error}", path.display());
        let problem = match need {
            Need::Required => Problem::error(ProblemKind::FileMissing, asked_at, what)
                .remedy("mend the path; it is relative to the folder of the file that names it"),
            Need::Optional => Problem::warning(ProblemKind::FileMissing, asked_at, what)
                .remedy("nothing if it is meant to be absent: [Include] goes on without it"),
        };
        self.report().add(problem);
    }

    fn limit(&mut self, place: Option<&Place>, what: String) {
        let remedy = "split or shorten the configuration";
        self.report().add(Problem::error(ProblemKind::Limit, place, what).remedy(remedy));
    }

    fn lines(&mut self, name: Arc<str>, bytes: &[u8]) {
        let mut state = FileState { name, cursor: None, after_directive: None };
        let text = match bytes.strip_prefix(b"\xef\xbb\xbf") {
            Some(rest) => {
                let place = Place { file: Arc::clone(&state.name), line: 1 };
                let what = "the file begins with a byte order mark, which DUNE takes for text";
                let remedy = "save the file as UTF-8 without a byte order mark";
                self.report().add(Problem::error(ProblemKind::NotText, Some(&place), what).remedy(remedy));
                rest
            }
            None => bytes,
        };
        for raw in Lines::new(text) {
            let place = Place { file: Arc::clone(&state.name), line: raw.number };
            self.total_lines += 1;
            if self.total_lines > MAX_LINES {
                return self
                    .limit(Some(&place), format!("more than {MAX_LINES} lines; the rest is left out"));
            }
            let line = self.text(&raw, &place);
            self.line(&mut state, &line, &place);
        }
    }

    /// The text of a line, reporting what is not a text.
    fn text<'a>(&mut self, raw: &RawLine<'a>, place: &Place) -> std::borrow::Cow<'a, str> {
        if raw.cut {
            let what = format!("the line is longer than {MAX_LINE_BYTES} bytes; the rest is read as another");
            let remedy = "break the line; a list may go on in the next one";
            self.report().add(Problem::error(ProblemKind::LongLine, Some(place), what).remedy(remedy));
        }
        let end = raw.bytes.iter().position(|byte| *byte == 0).unwrap_or(raw.bytes.len());
        let comment = matches!(raw.bytes.first(), Some(b'#' | b';'));
        let text = String::from_utf8_lossy(&raw.bytes[..end]);
        let damaged = matches!(text, std::borrow::Cow::Owned(_)) && !raw.cut;
        if end < raw.bytes.len() || (damaged && !comment) {
            let what = "the line holds bytes that are not text (UTF-8)";
            let remedy = "save the file as UTF-8";
            self.report().add(Problem::error(ProblemKind::NotText, Some(place), what).remedy(remedy));
        }
        text
    }

    fn line(&mut self, state: &mut FileState, line: &str, place: &Place) {
        let line = trim(line);
        if line.is_empty() {
            return;
        }
        match classify(line) {
            Line::Comment => {}
            Line::Bad(why) => {
                let remedy = "put `#` in front if it is a comment";
                self.report().add(Problem::error(ProblemKind::Syntax, Some(place), why).remedy(remedy));
            }
            Line::Section(header) => self.section(state, &header, place),
            other => self.body(state, other, place),
        }
    }

    fn section(&mut self, state: &mut FileState, header: &Header<'_>, place: &Place) {
        if !header.closed {
            let what = format!("`[{}` lacks its `]`", header.name);
            let remedy = "write [Name] on one line";
            self.report().add(Problem::error(ProblemKind::Syntax, Some(place), what).remedy(remedy));
        }
        if !header.ignored.is_empty() {
            let what = format!("`{}` after the `]` is ignored", header.ignored);
            let remedy = "put it on a line of its own, or behind `#`";
            self.report().add(Problem::warning(ProblemKind::Syntax, Some(place), what).remedy(remedy));
        }
        let directive = [("Require ", Need::Required), ("Include ", Need::Optional)]
            .into_iter()
            .find_map(|(keyword, need)| Some((header.name.strip_prefix(keyword)?, need)));
        if let Some((path, need)) = directive {
            state.after_directive = Some(place.clone());
            self.directive(state, trim(path), need, place);
        } else {
            state.after_directive = None;
            self.misspelt(header.name, place);
            self.edits.ini.open(header.name, place);
        }
        state.cursor = Some(Cursor::new(header.name));
    }

    fn directive(&mut self, state: &FileState, path: &str, need: Need, place: &Place) {
        let folder = Path::new(&*state.name).parent().unwrap_or(Path::new(""));
        self.file(&folder.join(path), Some(place), need);
    }

    /// Reports a section name that was probably meant as a directive or without its leading blank.
    fn misspelt(&mut self, name: &str, place: &Place) {
        if is_misspelt_keyword(name) {
            let what = format!("`[{name}]` loads nothing: it is read as an ordinary section");
            let remedy = "write [Require path] or [Include path], exactly so and with one blank";
            let problem = Problem::error(ProblemKind::MisspeltKeyword, Some(place), what).remedy(remedy);
            self.report().add(problem);
        } else if trim(name) != name {
            let what = format!("the section name `{name}` begins with a blank, which is part of it");
            let remedy = "take the blank after `[` out";
            self.report().add(Problem::error(ProblemKind::Syntax, Some(place), what).remedy(remedy));
        }
    }

    /// A line that belongs to a section.
    fn body(&mut self, state: &mut FileState, line: Line<'_>, place: &Place) {
        let Some(cursor) = &mut state.cursor else {
            let what = "text before the first section";
            let remedy = "put a [Section] line above it";
            self.report().add(Problem::error(ProblemKind::Syntax, Some(place), what).remedy(remedy));
            return;
        };
        if let Some(directive) = state.after_directive.take() {
            let what = format!("this and what follows belongs to a section named `{}`", cursor.section());
            let remedy = format!("put a [Section] line between it and line {}", directive.line);
            self.edits
                .report
                .add(Problem::error(ProblemKind::StraySection, Some(place), what).remedy(remedy));
        }
        match line {
            Line::Option(option) => self.edits.option(cursor, &option, place),
            Line::Attributes { name, attributes } => self.edits.attributes(cursor, name, attributes, place),
            Line::More(text) => self.edits.more(cursor, &text, place),
            Line::Comment | Line::Section(_) | Line::Bad(_) => {}
        }
    }
}

fn display(path: &Path) -> String {
    path.display().to_string()
}
