//! The no-go areas that the chart set should hold, and how they come into it.

use chartdb::{Chart, ChartDbError, NoGoArea, no_go_digest, no_go_digest_of, put_no_go_areas};
use std::path::Path;
use std::sync::{PoisonError, RwLock};
use units::UtcTime;

/// What people have closed.
#[derive(Debug, Clone, Default)]
pub struct NoGo {
    /// The areas.
    pub areas: Vec<NoGoArea>,
    /// When that changed last.
    pub at: UtcTime,
    /// Which of what is closed is not known any more, and what to do.
    pub lost: Option<String>,
}

/// What is wanted, and why it could not be done, if so.
#[derive(Debug, Default)]
pub(super) struct Areas {
    /// `None` until somebody said.
    wanted: RwLock<Option<NoGo>>,
    trouble: RwLock<Option<String>>,
}

impl Areas {
    pub(super) fn want(&self, areas: NoGo) {
        *self.wanted.write().unwrap_or_else(PoisonError::into_inner) = Some(areas);
    }

    fn wanted(&self) -> Option<NoGo> {
        self.wanted.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Whether a set of these charts must not go to vessels: it lacks something that is closed, or may.
    pub(super) fn are_lacking(&self, held: &[Chart]) -> bool {
        self.differ(held) || self.wanted().is_some_and(|wanted| wanted.lost.is_some())
    }

    /// Whether these charts hold other areas than they should.
    pub(super) fn differ(&self, held: &[Chart]) -> bool {
        self.wanted().is_some_and(|wanted| no_go_digest(&wanted.areas) != no_go_digest_of(held))
    }

    /// Whether some area is closed.
    pub(super) fn are_some(&self) -> bool {
        self.wanted().is_some_and(|wanted| !wanted.areas.is_empty() || wanted.lost.is_some())
    }

    /// Brings them into the set at a path; where that cannot be done it is said once, and is to be tried again. While one
    /// of them is lost the set stays as it is: it may be the only place that still knows where that one lies.
    pub(super) fn bring_into(&self, path: &Path) {
        let Some(NoGo { areas, at, lost: None }) = self.wanted() else { return };
        let trouble = match put_no_go_areas(path, &areas, at) {
            // Without a set nothing sails by one; what is no set is said by who reads it.
            Ok(()) | Err(ChartDbError::Absent(_) | ChartDbError::Foreign(_) | ChartDbError::Newer(_)) => None,
            Err(error) => Some(error.to_string()),
        };
        let mut before = self.trouble.write().unwrap_or_else(PoisonError::into_inner);
        if *before != trouble {
            if let Some(trouble) = &trouble {
                tracing::error!(trouble, "no-go areas cannot be brought into the chart set");
            } else {
                tracing::info!("the chart set takes no-go areas again");
            }
        }
        *before = trouble;
    }

    /// Why these charts, if there are any, do not hold these areas, or those that they should; `None` where they do.
    pub(super) fn missing(
        &self,
        held: Option<&[Chart]>,
        areas: Option<&NoGo>,
        of_set: Option<String>,
    ) -> Option<String> {
        let wanted = areas.cloned().or_else(|| self.wanted())?;
        if wanted.lost.is_some() {
            return wanted.lost;
        }
        if no_go_digest(&wanted.areas) == no_go_digest_of(held.unwrap_or_default()) {
            return None;
        }
        let trouble = self.trouble.read().unwrap_or_else(PoisonError::into_inner).clone();
        Some(trouble.or(of_set).unwrap_or_else(|| match held {
            None => {
                "there is no sea chart to hold them: import one by `lutra-server chart import`".to_owned()
            }
            Some(_) => "the sea chart is about to take them".to_owned(),
        }))
    }
}
