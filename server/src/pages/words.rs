//! The words of pages in the reader's language: the catalogue is [`shore::words`].

pub(crate) use shore::words::{Text, alarm, said, t, worded};

/// Marks an English word that is chosen while the program runs and said by [`said`], so that the catalogue is held to have it.
pub(crate) const fn word(english: &'static str) -> &'static str {
    english
}
