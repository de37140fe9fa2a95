//! The two ends from which rows can be read.

/// From which end messages are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// The oldest first.
    Oldest,
    /// The newest first: all the same the other way round.
    Newest,
}
