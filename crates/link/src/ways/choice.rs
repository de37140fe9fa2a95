//! Which way carries which lane. Pure: what is known of the ways goes in, a place comes out.

use super::{Thinning, Why};
use std::time::Duration;

/// A better way has to answer for this long without a break before a lane goes back to it.
const FIRST_HOLD: Duration = Duration::from_secs(5);
/// With each break that is doubled, up to this.
const GREATEST_HOLD: Duration = Duration::from_mins(5);
/// Better means cheaper in time by this share and by so many milliseconds: the way that carries more is a little slower by that.
const BETTER_SHARE: (u32, u32) = (7, 10);
const BETTER_MS: u32 = 50;

/// How long a way has to answer before a lane comes back to it after so many breaks in a row.
pub(crate) fn hold(breaks: u32) -> Duration {
    (FIRST_HOLD * 2_u32.pow(breaks.saturating_sub(1).min(10))).min(GREATEST_HOLD)
}

/// A way, as far as it matters for the choice.
#[derive(Debug, Clone, Copy)]
#[expect(clippy::struct_excessive_bools, reason = "each is known by itself, and any may go with any")]
pub(crate) struct Candidate {
    /// A connection is open.
    pub(crate) stands: bool,
    /// It answers in time.
    pub(crate) answers: bool,
    /// It has answered for as long as it has to, for a lane to come back to it.
    pub(crate) is_proven: bool,
    pub(crate) metered: bool,
    pub(crate) thinning: Thinning,
    pub(crate) is_good: bool,
    pub(crate) cost_ms: u32,
}

/// The criteria of a lane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Lane {
    /// The best.
    Live,
    /// The cheapest good one.
    Records,
}

/// The criteria before the time that a way costs; less is better.
fn class(lane: Lane, one: &Candidate) -> (Thinning, bool, bool) {
    match lane {
        Lane::Live => (one.thinning, false, false),
        Lane::Records => (Thinning::Nothing, !one.is_good, one.metered),
    }
}

fn may(lane: Lane, one: &Candidate) -> bool {
    one.stands && (lane == Lane::Live || one.thinning == Thinning::Nothing)
}

/// The way for a lane that is on `current`, and why where that changes.
pub(crate) fn choose(lane: Lane, current: Option<usize>, ways: &[Candidate]) -> (Option<usize>, Option<Why>) {
    let rank = |one: &Candidate| (!one.answers, class(lane, one), one.cost_ms);
    let best = |wanted: &dyn Fn(usize, &Candidate) -> bool| {
        let fit = ways.iter().enumerate().filter(|(place, one)| may(lane, one) && wanted(*place, one));
        fit.min_by_key(|(_, one)| rank(one)).map(|(place, _)| place)
    };
    let now = current.and_then(|place| ways.get(place).map(|one| (place, one)));
    let Some((place, one)) = now.filter(|(_, one)| may(lane, one)) else {
        let why = match now {
            Some((_, one)) if one.stands => Why::Budget,
            Some(_) => Why::Failover,
            None => Why::Only,
        };
        let found = best(&|_, _| true);
        let changed = found.is_some() || current.is_some();
        return (found, changed.then_some(found.map_or(Why::None, |_| why)));
    };
    if !one.answers {
        // Where no way answers, a change gains nothing.
        return match best(&|other, candidate| other != place && candidate.answers) {
            Some(other) => (Some(other), Some(Why::Failover)),
            None => (current, None),
        };
    }
    let Some(other) = best(&|other, candidate| other != place && candidate.answers && candidate.is_proven)
    else {
        return (current, None);
    };
    let (ours, theirs) = (class(lane, one), class(lane, &ways[other]));
    let (share, of) = BETTER_SHARE;
    let is_faster = ways[other].cost_ms + BETTER_MS < one.cost_ms
        && ways[other].cost_ms.saturating_mul(of) < one.cost_ms.saturating_mul(share);
    let why = match lane {
        _ if theirs > ours => None,
        Lane::Live if theirs < ours => Some(Why::Budget),
        Lane::Records if (theirs.1, theirs.2) < (ours.1, ours.2) => {
            Some(if theirs.1 == ours.1 { Why::Cheaper } else { Why::Better })
        }
        _ => is_faster.then_some(Why::Better),
    };
    if why.is_some() { (Some(other), why) } else { (current, None) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn way(cost_ms: u32, metered: bool) -> Candidate {
        Candidate {
            stands: true,
            answers: true,
            is_proven: true,
            metered,
            thinning: Thinning::Nothing,
            is_good: true,
            cost_ms,
        }
    }

    #[test]
    fn live_takes_the_fastest_and_records_the_cheapest() {
        let ways = [way(50, true), way(150, false)];
        assert_eq!(choose(Lane::Live, None, &ways), (Some(0), Some(Why::Only)));
        assert_eq!(choose(Lane::Live, Some(1), &ways), (Some(0), Some(Why::Better)));
        assert_eq!(choose(Lane::Records, Some(0), &ways), (Some(1), Some(Why::Cheaper)));
        assert_eq!(choose(Lane::Records, Some(1), &ways), (Some(1), None));
    }

    #[test]
    fn a_silent_way_is_left_at_once_and_a_proven_one_alone_is_gone_back_to() {
        let silent = Candidate { answers: false, ..way(5, false) };
        let ways = [silent, way(80, true)];
        for lane in [Lane::Live, Lane::Records] {
            assert_eq!(choose(lane, Some(0), &ways), (Some(1), Some(Why::Failover)));
        }
        let back = Candidate { is_proven: false, ..way(5, false) };
        assert_eq!(choose(Lane::Live, Some(1), &[back, way(80, true)]), (Some(1), None));
        assert_eq!(choose(Lane::Live, Some(0), &[silent, silent]), (Some(0), None), "nowhere better");
        let down = Candidate { stands: false, answers: false, ..silent };
        assert_eq!(choose(Lane::Live, Some(0), &[down, silent]), (Some(1), Some(Why::Failover)));
        assert_eq!(choose(Lane::Live, Some(0), &[down, down]), (None, Some(Why::None)));
    }

    #[test]
    fn a_thinned_way_carries_no_records_and_live_values_where_there_is_no_other() {
        let thinned = Candidate { thinning: Thinning::Most, ..way(10, true) };
        assert_eq!(choose(Lane::Records, Some(0), &[thinned]), (None, Some(Why::None)));
        assert_eq!(choose(Lane::Live, Some(0), &[thinned]), (Some(0), None));
        assert_eq!(choose(Lane::Live, Some(0), &[thinned, way(400, false)]), (Some(1), Some(Why::Budget)));
        assert_eq!(choose(Lane::Records, Some(0), &[thinned, way(400, false)]), (Some(1), Some(Why::Budget)));
    }

    fn candidate() -> impl Strategy<Value = Candidate> {
        (any::<[bool; 5]>(), 0_u8..4, 0_u32..2000).prop_map(|(flags, thinning, cost_ms)| {
            let [stands, answers, is_proven, metered, is_good] = flags;
            let thinning = Thinning::from_code(thinning);
            Candidate { stands, answers: answers && stands, is_proven, metered, thinning, is_good, cost_ms }
        })
    }

    proptest! {
        /// While nothing changes a lane stays on its way: two ways are never each better than the other.
        #[test]
        fn a_choice_rests(ways in proptest::collection::vec(candidate(), 1..5), current in 0_usize..5, live: bool) {
            let lane = if live { Lane::Live } else { Lane::Records };
            let mut at = Some(current);
            for _ in 0..=ways.len() {
                at = choose(lane, at, &ways).0;
            }
            prop_assert_eq!(choose(lane, at, &ways), (at, None));
            let answering = ways.iter().any(|one| one.answers && may(lane, one));
            if answering {
                prop_assert!(ways[at.unwrap()].answers);
            }
        }
    }

    #[test]
    fn breaks_make_a_way_wait_longer_up_to_five_minutes() {
        let holds: Vec<u64> = [0, 1, 2, 3, 6, 7, 40].map(|breaks| hold(breaks).as_secs()).to_vec();
        assert_eq!(holds, [5, 5, 10, 20, 160, 300, 300]);
    }
}
