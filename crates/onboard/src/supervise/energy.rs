//! Whether the charge that is left reaches along a way home by a route.
//!
//! The battery's levels are set so that they leave enough for a straight way home. A route may be many times longer, and
//! was not considered then. One that would take the batteries below the critical level, at which the vessel keeps its
//! station, is not sailed: the vessel holds in deep water where it is, which is reported with the figures, and the
//! remaining charge keeps it there, in contact and out of danger, until it is fetched. Sailing until empty would leave it
//! adrift at an arbitrary place. The energy is computed again with each search, once a minute, so that a way that turns
//! out to be in reach is sailed. It is the plan's own estimate ([`mission::PlanStatistics`]): straight legs at the
//! planned speed by the vessel's table of speeds and power, without wind and current.

/// Figures are reported in steps of this size (Wh), so that they do not change for some minutes.
const STEP_WH: f64 = 10.0;

/// The energy of the batteries above the reserve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct EnergyLeft {
    /// Charge of the emptiest battery (%).
    pub(super) percent: f64,
    /// The share of the charge that is kept.
    pub(super) kept: f64,
    /// Energy above that (Wh).
    pub(super) wh: f64,
}

impl EnergyLeft {
    /// Whether it is enough for a way that takes so much (Wh).
    ///
    /// # Errors
    /// Why not, with the figures.
    pub(super) fn reaches(&self, needed_wh: f64) -> Result<(), String> {
        if needed_wh <= self.wh {
            return Ok(());
        }
        let needed_wh = (needed_wh / STEP_WH).ceil() * STEP_WH;
        let left_wh = (self.wh / STEP_WH).floor() * STEP_WH;
        Err(format!(
            "it takes about {needed_wh:.0} Wh; the battery is at {:.0} %, and {left_wh:.0} Wh may be used ({:.0} % are kept in reserve)",
            self.percent.floor(),
            100.0 * self.kept
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_way_that_takes_more_than_is_left_above_the_reserve_is_refused_with_figures() {
        let left = EnergyLeft { percent: 14.6, kept: 0.1, wh: 168.0 };
        assert_eq!(left.reaches(168.0), Ok(()));
        let why = left.reaches(168.1).unwrap_err();
        let told = "it takes about 170 Wh; the battery is at 14 %, and 160 Wh may be used (10 % are kept in reserve)";
        assert_eq!(why, told);
    }
}
