//! Checks all that a vessel sweeps against the chart, leg by leg.
//!
//! Legs (ways, tracks, circles, places, drifting) are covered by corridors, and the
//! [depth index](charts::depth_index) is asked for the worst in each. Corridors are swept exactly; where a shape is no
//! corridor (an arc, the fan of ways out of a circle) it is covered by wider ones, so that something may be refused
//! for what lies just outside, never accepted over something inside.

use crate::limits::GuardLimits;
use crate::sweep::{Corridor, Disc, circle, displaced, distance_m, hull};
use crate::verdict::{Entered, LegCheck, Part, Reason, Spot, Verdict, Warning};
use charts::depth_index::{DepthAnswer, DepthIndex, Leg, Restricted, Restriction, Water};
use std::f64::consts::FRAC_PI_2;
use std::time::Duration;
use units::{LatLon, LocalFrame, LocalPoint};

/// Most corridors that are checked together. More would hold the vessel's loop up.
pub const MOST_CORRIDORS: usize = 20_000;
/// Longest way that is checked, all corridors together (m).
pub const LONGEST_WAY_M: f64 = 1e6;
/// A circle is approached along the leg to the point abeam of its centre from at least so many radii.
const OUTSIDE: f64 = 1.25;

/// Whether the straight way between two places keeps to deep water, wherever the vessel strays from it.
pub fn check_way(
    label: &str,
    from: LatLon,
    to: LatLon,
    index: &DepthIndex,
    limits: &GuardLimits,
) -> LegCheck {
    let corridor = Corridor { from, to, half_width_m: limits.half_width_m() };
    let leg = NamedLeg { label, part: Part::Transit, number: 0 };
    leg.told(&worst(corridor, index, limits), (from, to), index, limits)
}

/// A check of all that a vessel will sweep, given in the order in which it is sailed.
///
/// Each leg has a label that says whose it is, such as the name of a maneuver; it is in the answer. What comes
/// after more than is checked together ([`MOST_CORRIDORS`], [`LONGEST_WAY_M`]) is not checked.
#[derive(Debug)]
pub struct Check<'a> {
    index: &'a DepthIndex,
    limits: &'a GuardLimits,
    /// Where the vessel may be by now; `None` where that is unknown.
    here: Option<Disc>,
    legs: Vec<LegCheck>,
    warnings: Vec<Warning>,
    corridors: usize,
    way_m: f64,
}

impl<'a> Check<'a> {
    /// A check that begins where the vessel is. Without a position the way to the first place is reported as unchecked.
    pub fn new(from: Option<LatLon>, index: &'a DepthIndex, limits: &'a GuardLimits) -> Self {
        let here = from.map(Disc::at);
        Self { index, limits, here, legs: Vec::new(), warnings: Vec::new(), corridors: 0, way_m: 0.0 }
    }

    /// The verdict on all that was given.
    pub fn verdict(self) -> Verdict {
        let too_much = self.is_over();
        let mut warnings = self.warnings;
        warnings.extend(self.legs.iter().filter_map(Warning::of_quality));
        warnings.extend(self.legs.iter().filter_map(Warning::of_area));
        warnings.dedup();
        Verdict { legs: self.legs, warnings, too_much }
    }

    /// Whether there was more than is checked together.
    pub fn is_over(&self) -> bool {
        self.corridors > MOST_CORRIDORS || self.way_m > LONGEST_WAY_M
    }

    /// Where the vessel may be after all that was given; `None` where that is unknown.
    pub fn here(&self) -> Option<Disc> {
        self.here
    }

    /// Notes what cannot be checked.
    pub fn warn(&mut self, warning: Warning) {
        if !self.is_over() {
            self.warnings.push(warning);
        }
    }

    /// From where the vessel may be to anywhere in a disc.
    pub fn transit(&mut self, label: &str, to: Disc) {
        let half_width_m = self.limits.half_width_m();
        let corridors = if let Some(here) = self.here {
            hull(here, to, half_width_m)
        } else {
            self.warn(Warning::StartUnknown { label: label.to_owned() });
            vec![Corridor::around(to.centre, half_width_m + to.radius_m)]
        };
        self.here = Some(to);
        self.leg(label, Part::Transit, 0, &corridors);
    }

    /// Along places, from the first one, where the vessel is. The corridor is wider by so much (m) than the limits ask.
    pub fn track(&mut self, label: &str, places: &[LatLon], wider_m: f64) {
        let half_width_m = self.limits.half_width_m() + wider_m;
        for (number, leg) in (0_u32..).zip(places.windows(2)) {
            self.leg(label, Part::Track, number, &[Corridor { from: leg[0], to: leg[1], half_width_m }]);
            if self.is_over() {
                return;
            }
        }
        self.here = places.last().copied().map(Disc::at).or(self.here);
    }

    /// Keeping station in a disc.
    pub fn station(&mut self, label: &str, disc: Disc) {
        self.stay(label, Part::Station, disc);
    }

    /// Drifting with the motors off for a time.
    pub fn drift(&mut self, label: &str, duration: Option<Duration>) {
        let (Some(here), Some(duration)) = (self.here, duration) else {
            return self.warn(Warning::DriftsOn { label: label.to_owned() });
        };
        let radius_m = here.radius_m + self.limits.drift_mps * duration.as_secs_f64();
        self.stay(label, Part::Drift, Disc { radius_m, ..here });
    }

    /// The way to a circle that is sailed clockwise or the other way round; and the vessel is anywhere on it.
    pub fn approach(&mut self, label: &str, disc: Disc, clockwise: bool) {
        if self.here.is_none() {
            // From anywhere; where the circle is met is not known.
            self.warn(Warning::StartUnknown { label: label.to_owned() });
        } else {
            self.transit(label, self.abeam(disc, clockwise).unwrap_or(disc));
        }
        self.here = Some(disc);
    }

    /// A circle.
    pub fn circle(&mut self, label: &str, disc: Disc) {
        self.here = Some(disc);
        self.leg(label, Part::Circle, 0, &circle(disc, self.limits.half_width_m()));
    }

    /// An eight of two circles of this radius (m) round these places, with the ways across.
    pub fn eight(&mut self, label: &str, ends: [LatLon; 2], radius_m: f64) {
        let half_width_m = self.limits.half_width_m() + radius_m;
        let [from, to] = ends;
        self.leg(label, Part::Circle, 0, &[Corridor { from, to, half_width_m }]);
    }

    /// From here on the vessel may be anywhere in a disc, without a leg.
    pub fn be_within(&mut self, disc: Disc) {
        self.here = Some(disc);
    }

    /// From here on the vessel's position is unknown.
    pub fn be_anywhere(&mut self) {
        self.here = None;
    }

    fn stay(&mut self, label: &str, part: Part, disc: Disc) {
        self.here = Some(disc);
        let reach_m = disc.radius_m + self.limits.hull_m;
        self.leg(label, part, 0, &[Corridor::around(disc.centre, reach_m)]);
    }

    /// Where the approach to a circle ends, when the vessel comes from one place well outside: abeam of the centre, on
    /// the side from which the circle is met along its sense.
    fn abeam(&self, disc: Disc, clockwise: bool) -> Option<Disc> {
        let here = self.here.filter(|here| here.radius_m <= 0.0)?;
        if distance_m(here.centre, disc.centre) < OUTSIDE * disc.radius_m + self.limits.half_width_m() {
            return None;
        }
        let side_rad = if clockwise { -FRAC_PI_2 } else { FRAC_PI_2 };
        let frame = LocalFrame::new(disc.centre);
        let ahead_rad = frame.to_local(here.centre).bearing_rad(LocalPoint::default());
        Some(Disc::at(displaced(disc.centre, ahead_rad + side_rad, disc.radius_m)))
    }

    fn leg(&mut self, label: &str, part: Part, number: u32, corridors: &[Corridor]) {
        if self.is_over() {
            return;
        }
        self.corridors += corridors.len();
        self.way_m += corridors.iter().map(|one| distance_m(one.from, one.to)).sum::<f64>();
        if !self.is_over() {
            let leg = NamedLeg { label, part, number };
            self.legs.extend(leg.check(corridors, self.index, self.limits));
        }
    }
}

/// Whose leg it is, and which.
struct NamedLeg<'a> {
    label: &'a str,
    part: Part,
    number: u32,
}

impl NamedLeg<'_> {
    /// The worst of its corridors; `None` without any.
    fn check(self, corridors: &[Corridor], index: &DepthIndex, limits: &GuardLimits) -> Option<LegCheck> {
        let mut area = None;
        let answers = corridors.iter().map(|corridor| {
            let answer = worst(*corridor, index, limits);
            area = Restricted::worse(area, answer.area);
            answer
        });
        let answer =
            answers.reduce(|worst, one| if gravity(&worst) <= gravity(&one) { worst } else { one })?;
        let ends = (corridors.first()?.from, corridors.last()?.to);
        Some(self.told(&answer.within(area), ends, index, limits))
    }

    fn told(
        self,
        answer: &DepthAnswer,
        (from, to): (LatLon, LatLon),
        index: &DepthIndex,
        limits: &GuardLimits,
    ) -> LegCheck {
        let reason = reason(answer, limits);
        let area = answer.area.map(|area| Entered::of(&area, answer, index));
        let of_area = area.as_ref().filter(|_| matches!(reason, Some(Reason::Entry(_))));
        LegCheck {
            label: self.label.to_owned(),
            part: self.part,
            number: self.number,
            from,
            to,
            half_width_m: answer.half_width_m,
            reason,
            spot: of_area.map_or_else(|| Spot::of(answer, index), |area| area.spot.clone()),
            area,
        }
    }
}

/// The worst that the chart has in a corridor, for autonomous sailing.
fn worst(corridor: Corridor, index: &DepthIndex, limits: &GuardLimits) -> DepthAnswer {
    let leg = Leg { from: corridor.from, to: corridor.to };
    index.shallowest_along(leg, corridor.half_width_m, &limits.demand(limits.autonomous_m))
}

/// Less is worse.
fn gravity(answer: &DepthAnswer) -> f64 {
    const NO_WATER: f64 = -1e9;
    match answer.water {
        Water::Land => NO_WATER,
        Water::Obstacle => NO_WATER + 1.0,
        Water::UnknownDepth => NO_WATER + 2.0,
        Water::NoData => NO_WATER + 3.0,
        Water::TooLow { .. } => NO_WATER + 4.0,
        Water::Depth { .. } => answer.margin_m.unwrap_or(NO_WATER),
    }
}

/// Why the vessel may not sail there autonomously, if so: first for the depth, then for a rule.
fn reason(answer: &DepthAnswer, limits: &GuardLimits) -> Option<Reason> {
    if answer.navigable {
        return None;
    }
    let refused: Option<Restriction> =
        answer.area.filter(Restricted::is_refused).map(|area| area.restriction);
    if let Some(restriction) = refused
        && answer.margin_m.is_some_and(|margin_m| margin_m >= 0.0)
    {
        return Some(Reason::Entry(restriction));
    }
    Some(match answer.water {
        Water::Land => Reason::Land,
        Water::Obstacle => Reason::Obstacle,
        Water::UnknownDepth => Reason::UnknownDepth,
        Water::NoData => Reason::NoData,
        Water::TooLow { .. } => Reason::TooLow,
        Water::Depth { .. } => {
            let relief_m = limits.needed_m(limits.autonomous_m) - limits.needed_m(limits.navigable_m);
            match answer.margin_m {
                Some(margin_m) if margin_m + relief_m >= 0.0 => Reason::TooShallowAlone,
                _ => Reason::TooShallow,
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use charts::depth_index::{EntryRule, EntryRules};
    use testkit::sea::{Ground, Sea};

    fn frame() -> LocalFrame {
        LocalFrame::new(LatLon::from_deg(63.44, 10.35).unwrap())
    }

    fn place(north_m: f64, east_m: f64) -> LatLon {
        frame().to_place(LocalPoint { north_m, east_m })
    }

    /// 20 m deep, 4 km wide, with an islet of 100 m at the middle.
    fn islet() -> DepthIndex {
        let sea = Sea::new(frame().origin(), 2000.0, 20.0);
        sea.with(Ground::Land, LocalPoint::default(), 100.0, 24).index()
    }

    #[test]
    fn a_leg_bears_its_label_and_the_worst_of_its_corridors() {
        let (index, limits) = (islet(), GuardLimits::default());
        let mut check = Check::new(Some(place(-500.0, 0.0)), &index, &limits);
        check.transit("to the islet", Disc { centre: place(500.0, 0.0), radius_m: 40.0 });
        let verdict = check.verdict();
        let leg = &verdict.legs[0];
        assert_eq!((leg.label.as_str(), leg.reason), ("to the islet", Some(Reason::Land)));
        assert_eq!((leg.from, leg.to), (place(-500.0, 0.0), place(500.0, 0.0)), "the whole way is told");
        let way = check_way("a way", place(-500.0, 300.0), place(500.0, 300.0), &index, &limits);
        assert_eq!((way.reason, way.spot.margin_m), (None, Some(15.0)));
    }

    #[test]
    fn an_area_that_is_refused_is_a_reason_and_one_that_is_warned_of_a_warning() {
        let sea = Sea::new(frame().origin(), 2000.0, 20.0);
        let closed = sea.clone().with(Ground::Entry(7), LocalPoint::default(), 100.0, 24).index();
        let avoided = sea.with(Ground::Entry(14), LocalPoint::default(), 100.0, 24).index();
        let ways = |index: &DepthIndex, entry: EntryRules| {
            let limits = GuardLimits { entry, ..GuardLimits::default() };
            let mut check = Check::new(Some(place(-500.0, 0.0)), index, &limits);
            check.transit("across", Disc::at(place(500.0, 0.0)));
            check.transit("on", Disc::at(place(500.0, 500.0)));
            check.verdict()
        };
        let usual = EntryRules::default();
        let refused = ways(&closed, usual);
        let leg = &refused.legs[0];
        assert_eq!(leg.reason, Some(Reason::Entry(Restriction::EntryProhibited)));
        assert_eq!((refused.legs[1].reason, refused.warnings.len()), (None, 0));
        let text =
            "'across' (transit 1): enters an area where entry is prohibited: no name (XX5SEA01) at 63.4";
        assert!(leg.to_string().starts_with(text), "{leg}");
        assert_eq!((leg.spot.class, leg.spot.least_m), (Some("RESARE"), Some(20.0)));
        let warned = ways(&avoided, usual);
        assert!(!warned.is_refused());
        let codes: Vec<_> = warned.warnings.iter().map(|one| (one.label(), one.code())).collect();
        assert_eq!(codes, [("across", "entry-restricted")]);
        let lenient = EntryRules { prohibited: EntryRule::Warn, ..usual };
        assert_eq!(ways(&closed, lenient).warnings[0].code(), "entry-prohibited");
        assert_eq!(ways(&closed, lenient.at_least(usual)), refused, "a vessel weakens no rule of the shore");
        assert_eq!(ways(&closed, EntryRules::IGNORE).warnings, []);
        // A vessel inside one must be able to steer out of it.
        let around = crate::WaterAround::new(&closed, &GuardLimits::default(), (place(0.0, 0.0), 1.0), 5.0);
        assert!(around.is_clear() && around.ahead(0.0, 300.0).is_none());
    }

    #[test]
    fn land_is_the_reason_before_a_rule_and_the_area_is_told_all_the_same() {
        let sea = Sea::new(frame().origin(), 2000.0, 20.0);
        let sea = sea.with(Ground::Land, LocalPoint::default(), 100.0, 24);
        let index = sea.with(Ground::Entry(7), LocalPoint::default(), 200.0, 24).index();
        let limits = GuardLimits::default();
        let mut check = Check::new(Some(place(-500.0, 0.0)), &index, &limits);
        check.transit("across", Disc::at(place(500.0, 0.0)));
        let verdict = check.verdict();
        assert_eq!(verdict.legs[0].reason, Some(Reason::Land));
        assert_eq!(verdict.warnings[0].code(), "entry-prohibited");
    }

    #[test]
    fn nothing_is_looked_at_beyond_what_is_checked_together() {
        let (index, limits) = (islet(), GuardLimits::default());
        let mut check = Check::new(Some(place(300.0, 0.0)), &index, &limits);
        let there_and_back: Vec<LatLon> =
            (0..9_999).map(|n| place(300.0, if n % 2 == 0 { 0.0 } else { 200.0 })).collect();
        check.track("long", &there_and_back, 0.0);
        let legs = check.legs.len();
        check.drift("after", None);
        check.transit("after", Disc::at(place(-300.0, 0.0)));
        let verdict = check.verdict();
        assert_eq!((verdict.too_much, verdict.legs.len(), verdict.warnings.len()), (true, legs, 0));
    }
}
