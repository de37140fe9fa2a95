//! Follow reference: the maneuver in which another system commands the vessel place by place.
//!
//! Waits for a first reference, goes to its place, hovers (motors off) when near and goes again when the
//! place is farther than its radius plus a tolerance. A field that a reference leaves out keeps its value; at the
//! start these are: stay here, the default speed, the default radius. A speed of 0 stops. Sending the same reference
//! again restarts the timeout and changes nothing else. A place outside the area, or one that no safe way leads to,
//! is refused: the previous reference stays in force. While another vessel is announced close by, it hovers, and
//! continues when the other is gone or silent. A reference that only stops, or that only changes the speed on the way
//! to the same place, is never refused. Where routes can be searched for ([`FollowReferenceConfig::routes_around`]), a
//! place behind land is reached around it once a way is found ([`Detour`], [`Search`]); a search that is given up is
//! reported. Without a position it waits for one and checks the way then.

use super::behaviour::{Behaviour, Context, FailReason, Left, Signal};
use super::detour::Detour;
use super::goto::{distance_m, path_to};
use super::reference_state::{ReferencePhase, ReferenceState};
use super::reported::Reported;
use super::search::{Search, Standing};
use crate::checks::Checks;
use crate::command::{Command, Path, PathStart};
use crate::event::{Event, Fix, Reference, Sighting, Way};
use std::collections::BTreeMap;
use std::time::Duration;
use units::Speed;
use units::{LatLon, MonoTime, Now};

/// A vessel announced longer ago is no longer where it was.
const SIGHTING_MAX_AGE: Duration = Duration::from_secs(30);
/// A way that is refused while it hovers is checked again after this time: the vessel drifts.
const LOOK_AGAIN: Duration = Duration::from_secs(2);
/// Vessels kept in mind; of more the one heard longest ago is forgotten.
const MOST_OTHERS: usize = 64;

/// Do as a commander says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FollowReference {
    /// Address of the commander; `None` obeys any.
    pub system: Option<u16>,
    /// Entity of the commander; `None` obeys any.
    pub entity: Option<u8>,
    /// Silence of the commander for so long fails the maneuver; `None` waits for ever.
    pub timeout: Option<Duration>,
    /// Default radius (m); `None` takes the vessel's.
    pub radius_m: Option<f64>,
}

/// Parameters of the behaviour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FollowReferenceConfig {
    /// Hovering ends when the place is farther than the radius and this (m).
    pub tolerance_m: f64,
    /// Speed where no reference has named one.
    pub default_speed: Speed,
    /// Radius where neither the plan nor a reference has named one (m).
    pub default_radius_m: f64,
    /// The vessel hovers while another one is announced closer than this (m); 0 never does.
    pub separation_m: f64,
    /// Whether a way is searched for to a place that no safe straight way leads to.
    pub routes_around: bool,
}

impl Default for FollowReferenceConfig {
    /// As the Otters' configuration has it, other vessels left to the commander.
    fn default() -> Self {
        Self {
            tolerance_m: 30.0,
            default_speed: Speed::Percent(50.0),
            default_radius_m: 7.5,
            separation_m: 0.0,
            routes_around: false,
        }
    }
}

impl FollowReference {
    pub(crate) fn check(&self, checks: &mut Checks<'_>) {
        if let Some(radius_m) = self.radius_m {
            checks.finite("loiter radius", radius_m);
        }
    }
}

#[derive(Debug, Clone)]
pub(crate) struct Machine {
    follow: FollowReference,
    phase: ReferencePhase,
    /// The reference that is followed, with all fields filled in.
    reference: Option<Reference>,
    deadline: Option<MonoTime>,
    near: bool,
    /// Other vessels: when and where.
    others: BTreeMap<u16, (MonoTime, LatLon)>,
    /// It hovers because of them, or until its own position is known.
    held_off: bool,
    /// The search for a way to a place that no straight one leads to.
    search: Search,
    /// The way around that leads to what is followed.
    detour: Option<Detour>,
    /// Places that were refused, to which a way is searched for, and to which one was found.
    refused: Reported,
    looked_for: Reported,
    found: Reported,
    /// When a way that is refused while it hovers is checked again.
    next_look: MonoTime,
}

impl Machine {
    pub(super) fn new(follow: FollowReference) -> Self {
        Self {
            follow,
            phase: ReferencePhase::Wait,
            reference: None,
            deadline: None,
            near: false,
            others: BTreeMap::new(),
            held_off: false,
            search: Search::default(),
            detour: None,
            refused: Reported::default(),
            looked_for: Reported::default(),
            found: Reported::default(),
            next_look: MonoTime::default(),
        }
    }

    fn sighting(&mut self, cx: &Context<'_>, sighting: &Sighting) {
        self.others.insert(sighting.system, (cx.now.mono, sighting.place));
        if self.others.len() > MOST_OTHERS
            && let Some(oldest) = self.others.iter().min_by_key(|(_, (at, _))| *at).map(|(other, _)| *other)
        {
            self.others.remove(&oldest);
        }
    }

    /// Whether another vessel is too close for going on.
    fn is_crowded(&self, cx: &Context<'_>, fix: &Fix) -> bool {
        self.others.values().any(|(at, place)| {
            cx.now.mono.since(*at) <= SIGHTING_MAX_AGE
                && distance_m(fix.place, *place) < cx.config.reference.separation_m
        })
    }

    fn hears(&self, reference: &Reference) -> bool {
        self.follow.system.is_none_or(|system| system == reference.system)
            && self.follow.entity.is_none_or(|entity| entity == reference.entity)
    }

    fn wind(&mut self, cx: &Context<'_>) {
        self.deadline = self.follow.timeout.map(|timeout| cx.now.mono + timeout);
    }

    fn report(&self, cx: &mut Context<'_>) {
        let state = ReferenceState { phase: self.phase, reference: self.reference, near: self.near };
        cx.signals.push(Signal::Reference(state));
    }

    /// `new` over what was followed before, over the defaults.
    fn filled(&self, cx: &Context<'_>, new: &Reference) -> Reference {
        let config = &cx.config.reference;
        let before = self.reference.as_ref();
        let here = cx.fix.map(|fix| fix.place);
        let speed = new.speed.filter(|speed| speed.value().is_finite() && speed.value() >= 0.0);
        let speed = speed.map(|speed| cx.config.speed.clamp(speed));
        let radius_m = new.radius_m.filter(|radius_m| radius_m.is_finite()).map(f64::abs);
        let start_before = before.filter(|_| !new.direct).and_then(|before| before.start_point);
        Reference {
            location: new.location.or(before.and_then(|before| before.location)).or(here),
            start_point: new.start_point.or(start_before),
            speed: speed.or(before.and_then(|before| before.speed)).or(Some(config.default_speed)),
            radius_m: radius_m
                .or(before.and_then(|before| before.radius_m))
                .or(self.follow.radius_m.map(f64::abs))
                .or(Some(config.default_radius_m)),
            ..*new
        }
    }

    /// Whether a reference leads where the vessel may go; a refused one is reported once. Without a position only
    /// its place can be checked.
    fn may_go(&mut self, cx: &mut Context<'_>, next: &Reference) -> bool {
        let Some(goal) = next.location else { return true };
        if let Some(detour) = self.detour.take_if(|detour| detour.leads_to(goal))
            && next.start_point.is_none()
            && detour.check(cx).is_ok()
        {
            self.detour = Some(detour);
            return true;
        }
        // A way around that is refused from here is gone: what follows is the straight way, or another search.
        let allowed = match cx.fix {
            Some(fix) => {
                let start = next.start_point.unwrap_or(fix.place);
                let mut ways = [(fix.place, goal), (start, goal)].into_iter();
                ways.try_for_each(|(from, to)| cx.waters.way(from, to))
            }
            None => cx.waters.place(goal),
        };
        let Err(why) = allowed else { return true };
        match self.around(cx, next, &why) {
            Some(Standing::Known(detour)) => self.detour = Some(detour),
            Some(Standing::Looked) => return false,
            Some(Standing::Nothing) | None => {
                self.refuse(cx, goal, &why);
                return false;
            }
        }
        true
    }

    /// Reports once that a place is refused.
    fn refuse(&mut self, cx: &mut Context<'_>, goal: LatLon, why: &str) {
        if self.refused.is_new(goal, cx.now.mono) {
            let before = self.meanwhile();
            cx.warn(format!("a reference is refused, {before}: {why}"));
        }
    }

    fn meanwhile(&self) -> &'static str {
        match self.phase {
            ReferencePhase::Goto => "the one before goes on",
            ReferencePhase::Wait | ReferencePhase::Hover | ReferencePhase::Timeout => "it waits",
        }
    }

    /// The way around to the place of a reference, to which the straight way is refused: the one under way with another end,
    /// one that was found before, or one to be searched for. `None` where none can be searched for.
    fn around(&mut self, cx: &mut Context<'_>, next: &Reference, why: &str) -> Option<Standing> {
        let (Some(_), Some(goal), None) = (cx.fix, next.location, next.start_point) else { return None };
        // No way leads to a place that is closed itself.
        if !cx.config.reference.routes_around || cx.waters.way(goal, goal).is_err() {
            return None;
        }
        let on_it = self.phase == ReferencePhase::Goto;
        if let Some(bent) = self.detour.as_ref().and_then(|detour| detour.bent_to(cx, goal, on_it)) {
            return Some(Standing::Known(bent));
        }
        let newer_is_wanted = self.is_followed(goal) && self.search.wanted_by().is_some();
        let standing = if newer_is_wanted { Standing::Looked } else { self.look(cx, goal, next) };
        if matches!(standing, Standing::Looked) && self.looked_for.is_new(goal, cx.now.mono) {
            let text = format!("{}: {why}; a route around is looked for", self.meanwhile());
            cx.warn(format!("the place asked for cannot be reached straight, {text}"));
        }
        Some(standing)
    }

    fn look(&mut self, cx: &mut Context<'_>, goal: LatLon, next: &Reference) -> Standing {
        if self.search.wanted_by().is_some_and(|system| system != next.system) {
            self.give_up(cx, "another commander asks for another place");
        }
        self.search.want(cx, goal, *next)
    }

    fn is_followed(&self, goal: LatLon) -> bool {
        self.reference.is_some_and(|reference| reference.location == Some(goal))
    }

    /// Ends the search for a way; the system that asked for the place is informed.
    fn give_up(&mut self, cx: &mut Context<'_>, why: &str) {
        if let Some(wanted) = self.search.give_up() {
            let system = wanted.system;
            cx.warn(format!(
                "the place that {system:#06x} asked for, to which a route was looked for, is given up: {why}"
            ));
        }
    }

    /// The answer to a search.
    fn way(&mut self, cx: &mut Context<'_>, way: &Way) {
        match self.search.take(cx, way) {
            None => return,
            Some(Err((goal, why))) => self.refuse(cx, goal, &format!("no route leads there: {why}")),
            Some(Ok((wanted, detour))) => {
                if wanted.location.is_some_and(|goal| self.found.is_new(goal, cx.now.mono)) {
                    let text = "the place asked for is reached by a route around what lies between";
                    cx.warn(text.to_owned());
                }
                (self.reference, self.detour) = (Some(wanted), Some(detour));
                self.locate(cx, cx.fix.as_ref());
                self.go(cx);
            }
        }
        self.report(cx);
    }

    /// Whether a reference asks for no way that the vessel is not on already: to refuse it would only keep it from
    /// stopping or from slowing down.
    fn asks_no_new_way(&self, next: &Reference) -> bool {
        let on_its_way = self.phase == ReferencePhase::Goto
            && self.reference.is_some_and(|before| same_way(&before, next));
        on_its_way || next.speed.is_some_and(stands)
    }

    fn reference(&mut self, cx: &mut Context<'_>, new: &Reference) {
        self.wind(cx);
        let next = self.filled(cx, new);
        let corner = self.detour.as_ref().and_then(Detour::next);
        if !new.done && !self.asks_no_new_way(&next) && !self.may_go(cx, &next) {
            self.report(cx);
            return;
        }
        self.took(cx, new);
        let leads_there = |detour: &Detour| next.location.is_some_and(|goal| detour.leads_to(goal));
        self.detour = self.detour.take().filter(|detour| next.start_point.is_none() && leads_there(detour));
        let before = self.reference.replace(next);
        if new.done {
            self.report(cx);
            cx.done();
            return;
        }
        // Where only the end of a way around moved, the vessel continues to the same corner.
        let same_corner = corner.is_some() && self.detour.as_ref().and_then(Detour::next) == corner;
        let same_way = same_corner || before.is_some_and(|before| same_way(&before, &next));
        let speed_before = before.and_then(|before| before.speed);
        self.locate(cx, cx.fix.as_ref());
        match (next.location, next.speed) {
            (None, _) => {}
            (_, Some(speed)) if speed.value() <= 0.0 => self.hover(cx),
            (Some(_), _) if self.phase == ReferencePhase::Hover && speed_before.is_some_and(stands) => {
                self.go(cx);
            }
            (Some(_), Some(speed)) if self.phase == ReferencePhase::Goto && same_way => {
                if speed_before != Some(speed) {
                    cx.command(Command::ChangeSpeed(speed));
                }
            }
            (Some(_), _) if self.phase == ReferencePhase::Hover && self.near => {}
            (Some(_), _) => self.go(cx),
        }
        self.report(cx);
    }

    /// A reference is followed: an earlier search is of no use from here on.
    fn took(&mut self, cx: &mut Context<'_>, new: &Reference) {
        if new.done {
            self.give_up(cx, "the maneuver is over");
        } else if self.search.wanted_by() == Some(new.system) && new.location.is_some() {
            // A system that asks for another place knows.
            self.search.give_up();
        } else {
            self.give_up(cx, "another reference took its place");
        }
    }

    fn go(&mut self, cx: &mut Context<'_>) {
        self.held_off = cx.fix.is_none_or(|fix| self.is_crowded(cx, &fix));
        if self.held_off {
            self.hover(cx);
            return;
        }
        if let Some(Reference { location: Some(end), speed: Some(speed), start_point, .. }) = self.reference {
            self.phase = ReferencePhase::Goto;
            // One message that names a place both as start and as goal leaves no track but the straight one.
            let start = start_point.filter(|start| *start != end).map_or(PathStart::Here, PathStart::At);
            let next = self.detour.as_ref().and_then(Detour::next).unwrap_or(end);
            cx.follow(Path { start, ..path_to(next, speed) });
        }
    }

    /// At the place, or at a corner of the way around.
    fn arrived(&mut self, cx: &mut Context<'_>) {
        let speed = self.reference.and_then(|reference| reference.speed);
        let corner = self.detour.as_mut().and_then(Detour::pass);
        // The chart may have changed since the way was found, and the vessel is not quite at the corner.
        let refused = self.detour.as_ref().is_some_and(|detour| detour.check(cx).is_err());
        if let (Some(corner), Some(speed), false) = (corner, speed, refused) {
            cx.follow(path_to(corner, speed));
            return;
        }
        self.detour = None;
        self.hover(cx);
        self.report(cx);
    }

    fn hover(&mut self, cx: &mut Context<'_>) {
        if self.phase != ReferencePhase::Hover {
            self.phase = ReferencePhase::Hover;
            cx.drift();
        }
    }

    fn locate(&mut self, cx: &Context<'_>, fix: Option<&Fix>) {
        if let (Some(fix), Some(Reference { location: Some(place), radius_m, .. })) = (fix, &self.reference) {
            let near_m = radius_m.unwrap_or_default() + cx.config.reference.tolerance_m;
            self.near = distance_m(fix.place, *place) < near_m;
        }
    }

    fn fix(&mut self, cx: &mut Context<'_>, fix: &Fix) {
        self.locate(cx, Some(fix));
        self.search.look(cx);
        let stopped = self.reference.and_then(|reference| reference.speed).is_some_and(stands);
        let crowded = self.is_crowded(cx, fix);
        match self.phase {
            ReferencePhase::Goto if crowded => {
                self.held_off = true;
                self.hover(cx);
                self.report(cx);
            }
            ReferencePhase::Hover
                if !crowded && !stopped && (self.held_off || !self.near) && cx.now.mono >= self.next_look =>
            {
                if self.reference.is_none_or(|reference| self.may_go(cx, &reference)) {
                    self.go(cx);
                    self.report(cx);
                } else {
                    self.next_look = cx.now.mono + LOOK_AGAIN;
                }
            }
            ReferencePhase::Wait | ReferencePhase::Goto | ReferencePhase::Hover | ReferencePhase::Timeout => {
            }
        }
    }
}

/// Whether two references lead along the same way.
fn same_way(before: &Reference, next: &Reference) -> bool {
    before.location == next.location && before.start_point == next.start_point && before.direct == next.direct
}

/// Whether a speed means to stop.
fn stands(speed: Speed) -> bool {
    speed.value() <= 0.0
}

impl Behaviour for Machine {
    fn start(&mut self, cx: &mut Context<'_>) {
        self.wind(cx);
        cx.drift();
        self.report(cx);
    }

    fn event(&mut self, cx: &mut Context<'_>, event: &Event) {
        match event {
            Event::Fix(fix) => self.fix(cx, fix),
            Event::Path(progress) if progress.near && self.phase == ReferencePhase::Goto => self.arrived(cx),
            Event::PathFailed { reason, .. } => cx.fail(FailReason::Path(reason.clone())),
            Event::Way(way) => self.way(cx, way),
            Event::CommanderChanged => {
                self.give_up(cx, "control has changed hands");
                self.search = Search::default();
            }
            Event::Reference(reference) if self.hears(reference) => self.reference(cx, reference),
            Event::Sighting(sighting) if sighting.afloat => self.sighting(cx, sighting),
            Event::Path(_)
            | Event::Reference(_)
            | Event::Sighting(_)
            | Event::Medium(_)
            | Event::TeleoperationDone { .. } => {}
        }
    }

    fn timeout(&mut self, cx: &mut Context<'_>) {
        self.phase = ReferencePhase::Timeout;
        self.report(cx);
        cx.fail(FailReason::ReferenceTimeout);
    }

    fn deadline(&self) -> Option<MonoTime> {
        self.deadline
    }

    fn left(&self, _: Now) -> Option<Left> {
        None
    }
}
