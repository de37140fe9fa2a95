//! The error of a port that cannot be opened.

/// Why a port cannot be opened, where, and what to do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct OpenError(pub(super) String);

impl std::fmt::Display for OpenError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for OpenError {}
