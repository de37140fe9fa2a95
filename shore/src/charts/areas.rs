//! The no-go areas that the chart set should hold, and their insertion into it.

use chartdb::{Chart, ChartDbError, NoGoArea, no_go_digest, no_go_digest_of, put_no_go_areas};
use std::path::Path;
use std::sync::{PoisonError, RwLock};
use units::UtcTime;

/// The closed areas.
#[derive(Debug, Clone, Default)]
pub struct NoGo {
    /// The areas.
    pub areas: Vec<NoGoArea>,
    /// When they last changed.
    pub at: UtcTime,
    /// Which closed area cannot be read any more, and what to do.
    pub lost: Option<String>,
}

/// The wanted areas, and why they could not be applied, if so.
#[derive(Debug, Default)]
pub(super) struct Areas {
    /// `None` until [`super::Charts::close`] was called.
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

    /// Whether a set of these charts must not be offered to vessels, because a closed area is or may be missing.
    pub(super) fn are_lacking(&self, held: &[Chart]) -> bool {
        self.differ(held) || self.wanted().is_some_and(|wanted| wanted.lost.is_some())
    }

    /// Whether these charts hold other areas than they should.
    pub(super) fn differ(&self, held: &[Chart]) -> bool {
        self.wanted().is_some_and(|wanted| no_go_digest(&wanted.areas) != no_go_digest_of(held))
    }

    /// Whether any area is closed.
    pub(super) fn are_some(&self) -> bool {
        self.wanted().is_some_and(|wanted| !wanted.areas.is_empty() || wanted.lost.is_some())
    }

    /// Writes them into the set at a path; a failure is logged once, and must be tried again. While an area is lost, the
    /// set is not changed: it may hold the only copy of that area.
    pub(super) fn bring_into(&self, path: &Path) {
        let Some(NoGo { areas, at, lost: None }) = self.wanted() else { return };
        let trouble = match put_no_go_areas(path, &areas, at) {
            // Without a set no vessel uses one; an invalid file is reported where it is read.
            Ok(())
            | Err(
                ChartDbError::Absent(_)
                | ChartDbError::Foreign(_)
                | ChartDbError::Newer(_)
                | ChartDbError::Older(_),
            ) => None,
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
