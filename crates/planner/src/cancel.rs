//! Whether an answer is still wanted.

use crate::room::PlanError;

/// Asked by long work from time to time.
#[derive(Clone, Copy)]
pub struct Cancel<'a> {
    wanted: &'a dyn Fn() -> bool,
}

impl<'a> Cancel<'a> {
    /// By a function that says whether the answer is still wanted.
    pub fn unless(wanted: &'a dyn Fn() -> bool) -> Self {
        Self { wanted }
    }

    /// The answer is wanted whatever it takes.
    pub fn never() -> Self {
        Self { wanted: &|| true }
    }

    pub(crate) fn check(&self) -> Result<(), PlanError> {
        if (self.wanted)() { Ok(()) } else { Err(PlanError::Cancelled) }
    }
}

impl std::fmt::Debug for Cancel<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Cancel")
    }
}
