//! Whether a subcommand's input was sound.

use std::process::ExitCode;

/// How a subcommand that could do its work ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// All input was sound.
    Sound,
    /// Some input was damaged (and shown as such), or nothing was found.
    Damaged,
}

impl Outcome {
    /// Damaged when `damaged`.
    pub(crate) fn damaged_if(damaged: bool) -> Self {
        if damaged { Self::Damaged } else { Self::Sound }
    }
}

impl From<Outcome> for ExitCode {
    fn from(outcome: Outcome) -> Self {
        match outcome {
            Outcome::Sound => Self::SUCCESS,
            Outcome::Damaged => Self::from(1),
        }
    }
}
