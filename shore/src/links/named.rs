//! Which ways (network paths) of a vessel have figures.
//!
//! Names of ways are a vessel's own, and each makes series that last as long as the server: of one vessel the first
//! [`MOST_NAMES`] have figures, and the rest are shown on pages and by the API alone.

use std::collections::BTreeSet;

/// Names that have figures, as many as a vessel can have ways.
const MOST_NAMES: usize = link::MOST_WAYS;

/// The names of a vessel's ways that have figures.
#[derive(Debug, Default)]
pub(super) struct Named {
    names: BTreeSet<String>,
    /// Whether the limit was logged.
    said: bool,
}

impl Named {
    pub(super) fn names(&self) -> impl Iterator<Item = &String> {
        self.names.iter()
    }

    /// Whether the way of this name has figures.
    pub(super) fn has(&mut self, vessel: &str, name: &str) -> bool {
        if self.names.contains(name) {
            return true;
        }
        if self.names.len() < MOST_NAMES {
            return self.names.insert(name.to_owned());
        }
        if !std::mem::replace(&mut self.said, true) {
            tracing::warn!(
                %vessel, way = name,
                "the vessel has named more than {MOST_NAMES} ways since the server started: this and further ones have no \
                 figures at /metrics until it is started again"
            );
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_a_vessel_makes_up_have_no_figures_beyond_the_eighth() {
        let mut named = Named::default();
        let mut has = |number: usize| named.has("otter", &format!("way {number}"));
        assert!((0..8).all(&mut has) && (0..8).all(&mut has));
        assert!(!has(8) && !has(9));
        assert_eq!(named.names.len(), 8);
    }
}
