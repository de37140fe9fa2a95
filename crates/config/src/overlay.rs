//! Values saved while the vessel ran, laid over those of the other files.
//!
//! A vessel must start with its configuration whatever lies in its `-saved.ini`: that file is written by the
//! program, over years of versions, and may be cut or damaged. So it is read separately, its mistakes are
//! warnings, and a value that the schema refuses, or that contradicts another, is left out and named. What
//! the other files say then stays in force.

use std::path::Path;

use crate::config::Config;
use crate::ini::Setting;
use crate::problem::{Problem, ProblemKind, Severity};
use crate::resolve::{Read, resolve};

/// More saved values than this are not checked one by one when there is an error among them.
const MOST_VALUES: usize = 1000;

/// A configuration, and what it was made from.
pub(crate) struct Overlay<'a> {
    pub(crate) base: Config,
    pub(crate) read: Read,
    pub(crate) selected: &'a [&'a str],
    pub(crate) main: &'a Path,
}

/// A saved value.
struct Saved<'a> {
    section: &'a str,
    key: &'a str,
    setting: &'a Setting,
}

impl Overlay<'_> {
    /// The configuration with what is good of the saved file at `path`.
    pub(crate) fn with(mut self, path: &Path, (ini, report, files): Read) -> Config {
        let what = format!("`{}` overrides the other files", path.display());
        let remedy = "remove that file to return to the values of the others";
        self.read.1.add(Problem::note(ProblemKind::Saved, None, what).remedy(remedy));
        for problem in report.problems().iter().filter(|problem| problem.severity != Severity::Note) {
            let Problem { place, what, .. } = problem;
            let what = format!("in the saved values: {what}");
            self.read.1.add(Problem::warning(ProblemKind::Saved, place.as_ref(), what).remedy(remedy));
        }
        self.read.2.extend(files);
        let mut values = Vec::new();
        for (section, settings) in ini.sections() {
            for (key, setting) in settings.settings() {
                let saved = Saved { section, key, setting };
                if self.read.0.section(section).is_some() {
                    values.push(saved);
                } else {
                    self.drop(&saved, "the other files have no such section");
                }
            }
        }
        let all = self.laid(&values);
        if !self.is_worse(&all) {
            return all;
        }
        if values.len() > MOST_VALUES {
            let what =
                format!("`{}`: something is wrong with its many values; they are not used", path.display());
            self.read.1.add(Problem::warning(ProblemKind::Saved, None, what).remedy(remedy));
            return self.laid(&[]);
        }
        let mut good = Vec::new();
        for saved in values {
            good.push(saved);
            let config = self.laid(&good);
            if self.is_worse(&config)
                && let Some(saved) = good.pop()
            {
                let reason = self.reason(&config);
                self.drop(&saved, &reason);
            }
        }
        self.laid(&good)
    }

    /// The configuration with these values on top.
    fn laid(&self, values: &[Saved<'_>]) -> Config {
        let (mut ini, report, files) = self.read.clone();
        for saved in values {
            ini.overlay(saved.section, saved.key, saved.setting);
        }
        resolve((ini, report, files), self.selected, self.main)
    }

    fn is_worse(&self, config: &Config) -> bool {
        config.report().counts().errors > self.base.report().counts().errors
    }

    /// The first error of `config` that the configuration does not have without the saved values.
    fn reason(&self, config: &Config) -> String {
        let known = self.base.report().problems();
        let new = |problem: &&Problem| problem.severity == Severity::Error && !known.contains(problem);
        let found = config.report().problems().iter().find(new);
        found.map_or_else(String::new, |problem| {
            if problem.remedy.is_empty() {
                problem.what.clone()
            } else {
                format!("{}; {}", problem.what, problem.remedy)
            }
        })
    }

    fn drop(&mut self, saved: &Saved<'_>, reason: &str) {
        let Saved { section, key, setting } = saved;
        let what = format!("the saved value of `{key}` in [{section}] is DROPPED: {reason}");
        let remedy = "the value of the other files is in force; take the line out of the saved file";
        self.read.1.add(Problem::warning(ProblemKind::Saved, setting.place(), what).remedy(remedy));
    }
}
