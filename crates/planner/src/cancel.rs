//! Whether an answer is still wanted, for how long it is looked for, and how far the search has come.

use crate::room::PlanError;
use std::time::Duration;

/// Asked by long work from time to time.
#[derive(Clone, Copy)]
pub struct Cancel<'a> {
    wanted: &'a dyn Fn() -> bool,
    /// Time spent so far, and the most that may be spent.
    budget: Option<(&'a dyn Fn() -> Duration, Duration)>,
    report: Option<&'a dyn Fn(Progress)>,
}

/// How far the search for a long way has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// Tiles of the chart that were searched for this request.
    pub tiles: usize,
    /// The search stops after so many.
    pub most_tiles: usize,
}

impl<'a> Cancel<'a> {
    /// By a function that says whether the answer is still wanted.
    pub fn unless(wanted: &'a dyn Fn() -> bool) -> Self {
        Self { wanted, budget: None, report: None }
    }

    /// The answer is wanted whatever it takes.
    pub fn never() -> Self {
        Self::unless(&|| true)
    }

    /// Stops the work when its time is used up, by a clock that gives the time spent so far.
    #[must_use]
    pub fn within(self, most: Duration, spent: &'a dyn Fn() -> Duration) -> Self {
        Self { budget: Some((spent, most)), ..self }
    }

    /// Calls a function for each tile that the search for a long way has prepared.
    #[must_use]
    pub fn reporting(self, report: &'a dyn Fn(Progress)) -> Self {
        Self { report: Some(report), ..self }
    }

    pub(crate) fn check(&self) -> Result<(), PlanError> {
        if !(self.wanted)() {
            return Err(PlanError::Cancelled);
        }
        match self.budget {
            Some((spent, most)) if spent() > most => Err(PlanError::OutOfTime),
            _ => Ok(()),
        }
    }

    pub(crate) fn report(&self, progress: Progress) {
        if let Some(report) = self.report {
            report(progress);
        }
    }
}

impl std::fmt::Debug for Cancel<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Cancel")
    }
}
