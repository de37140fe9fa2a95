//! What is wrong with a configuration, where, and what to do about it.
//!
//! Reading never stops at the first mistake: everything found goes into one [`Report`], which a person can
//! work through from top to bottom. The report keeps a bounded number of problems, so that a hostile file
//! cannot fill the memory; what was found beyond that is still counted.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

/// How many problems of each kind a report keeps; more are counted only.
pub const MAX_PROBLEMS_OF_A_KIND: usize = 100;

/// How bad a problem is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The program must not start with this configuration.
    Error,
    /// Probably not what was meant; the program can start.
    Warning,
    /// Worth knowing, nothing to repair.
    Note,
}

impl Severity {
    /// The word printed in front of a problem.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Warning => "warning",
            Self::Note => "note",
        }
    }
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

/// A line of a configuration file.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    /// The file, as reached from the path that was asked for.
    pub file: Arc<str>,
    /// The line, counted from 1.
    pub line: u32,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.file, self.line)
    }
}

/// What sort of mistake a problem is, for programs; people read [`Problem::what`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ProblemKind {
    /// A file that was asked for is absent or cannot be read.
    FileMissing,
    /// A file requires or includes itself, directly or through others.
    IncludeCycle,
    /// A limit on sizes or counts was exceeded; the rest was left out.
    Limit,
    /// A line exceeds what DUNE reads at once.
    LongLine,
    /// Bytes that are not text.
    NotText,
    /// A line that fits no form of the dialect.
    Syntax,
    /// `[Require ..]` or `[Include ..]` misspelt, so that nothing is loaded.
    MisspeltKeyword,
    /// Options that follow a `[Require ..]` or `[Include ..]` without a section of their own.
    StraySection,
    /// A comment character inside an option's name.
    CommentInName,
    /// A comment character cut a value where none was meant.
    ValueCut,
    /// `name+`, `name-` or their continuation lines do not do what they seem to.
    ListEdit,
    /// Braces after a name that hold something unknown.
    Attribute,
    /// `$(Section, Option)` that cannot be replaced.
    Reference,
    /// An option is assigned twice in one file.
    Repeated,
    /// A value does not have the type of its parameter.
    WrongType,
    /// A value lies outside the allowed range.
    OutOfRange,
    /// A list has the wrong number of items.
    WrongLength,
    /// A number is read as octal because of a leading zero.
    Octal,
    /// A list holds an empty item.
    EmptyItem,
    /// A section that neither Lutra nor its list of DUNE tasks knows.
    UnknownSection,
    /// A key that its section does not have.
    UnknownKey,
    /// A section or key that DUNE knows and Lutra has no use for.
    Unused,
    /// An entity label is missing or given twice.
    Label,
    /// A profile is not declared, or a task can never run.
    Profile,
    /// A setting without effect in Lutra.
    NotHonoured,
    /// Two values, each good in itself, contradict each other.
    Contradiction,
    /// The vessel's own name or address is missing or unusable.
    Identity,
    /// Values from a `-saved.ini` file are in force.
    Saved,
}

impl ProblemKind {
    /// A stable name, as used in the JSON form.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::FileMissing => "file-missing",
            Self::IncludeCycle => "include-cycle",
            Self::Limit => "limit",
            Self::LongLine => "long-line",
            Self::NotText => "not-text",
            Self::Syntax => "syntax",
            Self::MisspeltKeyword => "misspelt-keyword",
            Self::StraySection => "stray-section",
            Self::CommentInName => "comment-in-name",
            Self::ValueCut => "value-cut",
            Self::ListEdit => "list-edit",
            Self::Attribute => "attribute",
            Self::Reference => "reference",
            Self::Repeated => "repeated",
            Self::WrongType => "wrong-type",
            Self::OutOfRange => "out-of-range",
            Self::WrongLength => "wrong-length",
            Self::Octal => "octal",
            Self::EmptyItem => "empty-item",
            Self::UnknownSection => "unknown-section",
            Self::UnknownKey => "unknown-key",
            Self::Unused => "unused",
            Self::Label => "label",
            Self::Profile => "profile",
            Self::NotHonoured => "not-honoured",
            Self::Contradiction => "contradiction",
            Self::Identity => "identity",
            Self::Saved => "saved",
        }
    }
}

/// One error, warning or note.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// How bad it is.
    pub severity: Severity,
    /// What sort of mistake it is.
    pub kind: ProblemKind,
    /// Where it is; `None` when it concerns no line, such as a profile chosen on the command line.
    pub place: Option<Place>,
    /// What is wrong.
    pub what: String,
    /// What to do about it; empty when nothing is to be done.
    pub remedy: String,
}

impl Problem {
    /// An error at `place`.
    pub fn error(kind: ProblemKind, place: Option<&Place>, what: impl Into<String>) -> Self {
        Self::new(Severity::Error, kind, place, what)
    }

    /// A warning at `place`.
    pub fn warning(kind: ProblemKind, place: Option<&Place>, what: impl Into<String>) -> Self {
        Self::new(Severity::Warning, kind, place, what)
    }

    /// A note at `place`.
    pub fn note(kind: ProblemKind, place: Option<&Place>, what: impl Into<String>) -> Self {
        Self::new(Severity::Note, kind, place, what)
    }

    /// A problem of the given severity at `place`.
    pub fn new(
        severity: Severity,
        kind: ProblemKind,
        place: Option<&Place>,
        what: impl Into<String>,
    ) -> Self {
        Self { severity, kind, place: place.cloned(), what: what.into(), remedy: String::new() }
    }

    /// The same problem with its remedy.
    #[must_use]
    pub fn remedy(mut self, remedy: impl Into<String>) -> Self {
        self.remedy = remedy.into();
        self
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.severity)?;
        if let Some(place) = &self.place {
            write!(f, " {place}")?;
        }
        write!(f, ": {}", self.what)?;
        if !self.remedy.is_empty() {
            write!(f, "\n    -> {}", self.remedy)?;
        }
        Ok(())
    }
}

/// How many problems of each severity a report holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Errors.
    pub errors: usize,
    /// Warnings.
    pub warnings: usize,
    /// Notes.
    pub notes: usize,
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { errors, warnings, notes } = self;
        let counted =
            |number: usize, thing: &str| format!("{number} {thing}{}", if number == 1 { "" } else { "s" });
        let (errors, warnings) = (counted(*errors, "error"), counted(*warnings, "warning"));
        write!(f, "{errors}, {warnings}, {}", counted(*notes, "note"))
    }
}

/// Everything found while reading a configuration.
#[derive(Clone, Debug, Default)]
pub struct Report {
    problems: Vec<Problem>,
    kept: BTreeMap<ProblemKind, usize>,
    counts: Counts,
}

impl Report {
    /// Adds a problem; beyond [`MAX_PROBLEMS_OF_A_KIND`] it is only counted.
    pub fn add(&mut self, problem: Problem) {
        match problem.severity {
            Severity::Error => self.counts.errors += 1,
            Severity::Warning => self.counts.warnings += 1,
            Severity::Note => self.counts.notes += 1,
        }
        if !self.is_full_of(problem.kind) {
            *self.kept.entry(problem.kind).or_default() += 1;
            self.problems.push(problem);
        }
    }

    /// Whether further problems of this kind will only be counted.
    pub fn is_full_of(&self, kind: ProblemKind) -> bool {
        self.kept.get(&kind).is_some_and(|kept| *kept >= MAX_PROBLEMS_OF_A_KIND)
    }

    /// The problems kept, in the order in which they were found.
    pub fn problems(&self) -> &[Problem] {
        &self.problems
    }

    /// How many were found, including those not kept.
    pub const fn counts(&self) -> Counts {
        self.counts
    }

    /// Whether the program must refuse to start.
    pub const fn has_errors(&self) -> bool {
        self.counts.errors > 0
    }

    /// The problems with the worst first, otherwise in the order in which they were found.
    pub fn by_severity(&self) -> Vec<&Problem> {
        let mut sorted: Vec<&Problem> = self.problems.iter().collect();
        sorted.sort_by_key(|problem| problem.severity);
        sorted
    }

    /// How many were found beyond those kept.
    pub fn left_out(&self) -> usize {
        let Counts { errors, warnings, notes } = self.counts;
        errors + warnings + notes - self.problems.len()
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for problem in self.by_severity() {
            writeln!(f, "{problem}")?;
        }
        if self.left_out() > 0 {
            writeln!(f, "... and {} more, not shown", self.left_out())?;
        }
        write!(f, "{}", self.counts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_a_bounded_number_of_each_kind_but_counts_all() {
        let mut report = Report::default();
        for _ in 0..MAX_PROBLEMS_OF_A_KIND + 5 {
            report.add(Problem::warning(ProblemKind::Syntax, None, "w"));
        }
        report.add(Problem::warning(ProblemKind::Limit, None, "l"));
        assert_eq!(report.problems().len(), MAX_PROBLEMS_OF_A_KIND + 1);
        assert_eq!(report.counts().warnings, MAX_PROBLEMS_OF_A_KIND + 6);
        assert_eq!(report.left_out(), 5);
        assert!(report.to_string().contains("and 5 more"));
    }

    #[test]
    fn prints_the_worst_first_with_place_and_remedy() {
        let place = Place { file: "a.ini".into(), line: 7 };
        let mut report = Report::default();
        report.add(Problem::note(ProblemKind::Unused, None, "n"));
        report.add(Problem::error(ProblemKind::Syntax, Some(&place), "e").remedy("r"));
        assert_eq!(report.to_string(), "error a.ini:7: e\n    -> r\nnote: n\n1 error, 0 warnings, 1 note");
        assert!(report.has_errors());
    }
}
