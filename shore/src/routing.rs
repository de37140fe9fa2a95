//! Routes on the sea chart for people and programs.
//!
//! Planning takes a processor for some milliseconds, for up to a second where water must be prepared first, and for tens of seconds or
//! minutes where a way is long. So requests have turns, planning gives way to live values and commands, and it ends when the client
//! goes away.

mod currents;
mod objective;
mod progress;
mod turns;
mod wrong;

pub use currents::currents_of_file;
pub use objective::{aimed, power};

use crate::charts::verdict::reason;
use crate::charts::{Charts, Set};
use crate::error::{Error, ErrorKind, Result};
use crate::leisure::{self, at_leisure};
use api::{
    Said, SeaRoute, SeaRouteAnswer, SeaRouteClosed, SeaRouteGaveUp, SeaRouteLeg, SeaRouteMoved,
    SeaRouteNarrow, SeaRoutePassable, SeaRouteProgress, SeaRouteRefusal, SeaRouteRequest, SeaRouteTraffic,
    SeaRouteZone, SeaRouteZoneKind, Wording, say,
};
use charts::depth_index::{Restriction, Water};
use guard::{GuardLimits, LegCheck, Reason, check_way};
use planner::{
    Cancel, End, InTraffic, LegCost, Moved, Narrow, Needs, Objective, Passable, PlanError, Progress, Refusal,
    Request, Route, RouteLeg, Router, Spent, TrafficKind, Zone, Zones,
};
use progress::{Asked, UnderWay};
use std::ops::RangeInclusive;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use tokio_util::sync::CancellationToken;
use turns::Turns;
use units::{LatLon, LocalFrame, LocalPoint, UtcTime, wrap_two_pi};

/// Start, places to pass and goal.
const POINTS: RangeInclusive<usize> = 2..=50;
/// Areas of a request, corners of one and of all, and how long all their borders are (km).
const ZONES: usize = 50;
const CORNERS: RangeInclusive<usize> = 3..=200;
const ALL_CORNERS: usize = 1_000;
const ALL_BORDERS_KM: f64 = 2_000.0;
/// Most other routes that a request may ask for.
const ALTERNATIVES: u8 = 3;
/// Farthest that a request may ask to keep clear (m): what is cut out grows with it, and so does the time that takes.
const MOST_CLEARANCE_M: f64 = 500.0;

/// How far an Otter may be off its track before its path monitor ends the plan (m), where a request does not say so, and the
/// most that one may say.
pub const STRAY_M: f64 = 25.0;
const MOST_STRAY_M: f64 = 500.0;

/// For so long a route is looked for: the longest ways of a coast take half of it the first time.
const MOST_TIME: Duration = Duration::from_secs(90);

/// Longest that the server works ahead of the next route at a time.
const SPARE: Duration = Duration::from_secs(30);

/// Plans routes; cheap to clone.
#[derive(Clone, Default)]
pub struct Routing {
    turns: Turns,
    under_way: UnderWay,
}

/// Says, when it is dropped, that the client has gone.
struct Waiting(Arc<AtomicBool>);

impl Drop for Waiting {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Relaxed);
    }
}

impl Routing {
    /// The route that is asked for, in water that is deep enough, by these limits and from this time on where the question
    /// leaves them open.
    ///
    /// # Errors
    /// The question is malformed, or too many wait. That no route exists is an answer, not an error.
    pub async fn route(
        &self,
        set: Arc<Set>,
        ask: SeaRouteRequest,
        limits: GuardLimits,
        now: UtcTime,
    ) -> Result<SeaRouteAnswer> {
        let question = Question::new(&ask, limits, now)?;
        let asked = Arc::new(self.under_way.begin(ask.progress.as_deref())?);
        // It may hold a large grid, and waiting may take long.
        drop(ask);
        let question = Arc::new(question);
        let is_long = question.is_long(&set);
        let answer = self.plan(Arc::clone(&set), (Arc::clone(&question), &asked), is_long).await?;
        // Ends near each other may be joined by a long way only: that is looked for in a turn of its own.
        if !is_long && answer.refusal.as_ref().is_some_and(|refusal| refusal.code == NOT_FOUND) {
            return self.plan(set, (question, &asked), true).await;
        }
        Ok(answer)
    }

    /// How far the question that has this name has come ([`SeaRouteRequest::progress`]).
    ///
    /// # Errors
    /// No question of this name is worked on.
    pub fn progress(&self, name: &str) -> Result<SeaRouteProgress> {
        self.under_way.of(name)
    }

    async fn plan(
        &self,
        set: Arc<Set>,
        (question, asked): (Arc<Question>, &Arc<Asked>),
        is_long: bool,
    ) -> Result<SeaRouteAnswer> {
        let taken = self.turns.take(is_long).await?;
        asked.begun();
        let waiting = Waiting(Arc::new(AtomicBool::new(true)));
        let wanted = Arc::clone(&waiting.0);
        // After its client has gone, a planner runs for another moment: until then its turn is taken.
        let (its_set, asked) = (Arc::clone(&set), Arc::clone(asked));
        let answer = at_leisure(move || {
            let _taken = taken;
            let (wanted, report) =
                (|| wanted.load(Ordering::Relaxed), |progress: Progress| asked.report(progress));
            question.answer(&its_set, &Cancel::unless(&wanted).reporting(&report), is_long)
        })
        .await;
        self.use_spare_time(set);
        answer
    }

    /// Prepares water again whenever another set is in force from now on, until the server ends.
    pub fn keep_prepared(self, charts: Charts, stop: CancellationToken) -> impl Future<Output = ()> + Send {
        let mut changes = charts.changes();
        async move {
            while matches!(stop.run_until_cancelled(changes.changed()).await, Some(Ok(()))) {
                if let Some(set) = charts.set() {
                    self.use_spare_time(set);
                }
            }
        }
    }

    /// Makes the next routes quicker, while no route is asked for: prepares the water that was asked for before the chart
    /// changed, and learns where a search was long.
    fn use_spare_time(&self, set: Arc<Set>) {
        let Some(spare) = self.turns.spare() else { return };
        // Called off, it goes on after the next route.
        let work = move || {
            let began = Instant::now();
            let (is_spare, spent) = (|| spare.is_spare(), || began.elapsed());
            let cancel = Cancel::unless(&is_spare).within(SPARE, &spent);
            let done = set.prepare_water(&cancel).and_then(|()| set.router.learn(&cancel));
            match done {
                Ok(_) | Err(PlanError::Cancelled) => {}
                Err(error) => {
                    tracing::warn!("routes: the water was not made ready before the next route: {error}");
                }
            }
        };
        if let Err(error) = leisure::start(work) {
            tracing::warn!("routes: the water is not made ready before the next route: {error}");
        }
    }
}

/// A question that was read and is in range.
pub struct Question {
    places: Vec<LatLon>,
    needs: Needs,
    request: Request,
    limits: GuardLimits,
    zones: Option<Zones>,
    objective: Objective,
    stray_m: f64,
    explain: bool,
}

impl Question {
    /// Reads what was asked.
    ///
    /// # Errors
    /// Which part is malformed.
    pub fn new(ask: &SeaRouteRequest, limits: GuardLimits, now: UtcTime) -> Result<Self> {
        if !POINTS.contains(&ask.points.len()) {
            let (least, most) = POINTS.into_inner();
            return Err(malformed(
                say("points: there are {n}; give {least} to {most}")
                    .with("n", ask.points.len())
                    .with("least", least)
                    .with("most", most),
            ));
        }
        let place = |(number, [lat, lon]): (usize, [f64; 2])| {
            let place = LatLon::from_deg(lat, lon);
            let named = |text: Wording| Said::from(text).of_field(&format!("points[{number}]"));
            place.map_err(|error| malformed(named(not_a_place(lat, lon, error))))
        };
        let needs = needs(&limits, ask.least_depth_m, ask.clearance_m);
        needs.validate().map_err(|error| malformed(wrong::needs(error)))?;
        if needs.clearance_m > MOST_CLEARANCE_M {
            return Err(malformed(say("clearance_m: {asked} is more than {most} m; draw an area to avoid around what is to be kept away from").with("asked", needs.clearance_m).with("most", MOST_CLEARANCE_M)));
        }
        let margin_m = needs.clearance_m.min(limits.half_width_m());
        // First of all it counts them.
        let zones = zones(&ask.zones, margin_m).map_err(malformed)?;
        let objective = objective::objective(ask, now).map_err(malformed)?;
        let places: Vec<LatLon> = ask.points.iter().copied().enumerate().map(place).collect::<Result<_>>()?;
        let ends = Request::new(places[0], places[places.len() - 1]);
        if ask.alternatives > ALTERNATIVES {
            return Err(malformed(
                say("alternatives: {asked}; ask for 0 to {most}")
                    .with("asked", ask.alternatives)
                    .with("most", ALTERNATIVES),
            ));
        }
        let alternatives = usize::from(ask.alternatives);
        let request = Request { turn_radius_m: ask.turn_radius_m, alternatives, ..ends };
        request.validate().map_err(|error| malformed(wrong::needs(error)))?;
        let stray_m = ask.stray_m.unwrap_or(STRAY_M);
        if !(0.0..=MOST_STRAY_M).contains(&stray_m) {
            let text = say("stray_m: {asked} is not within 0 to {most} m");
            return Err(malformed(text.with("asked", stray_m).with("most", MOST_STRAY_M)));
        }
        let explain = ask.explain;
        Ok(Self { places, needs, request, limits, zones, objective, stray_m, explain })
    }

    /// Whether planning can take tens of seconds.
    fn is_long(&self, set: &Set) -> bool {
        set.router.is_long(&self.places, &self.needs)
    }

    /// Plans; `cancel` says whether the client still waits, and `is_long` whether a long way may be looked for.
    fn answer(&self, set: &Set, cancel: &Cancel<'_>, is_long: bool) -> SeaRouteAnswer {
        let began = Instant::now();
        let spent = || began.elapsed();
        let cancel = cancel.within(MOST_TIME, &spent);
        let request = self.request;
        let zoned = self.zones.clone().map(|zones| set.router.in_zones(zones));
        let router = zoned.as_ref().unwrap_or(&set.router);
        let short = (!is_long).then(|| router.without_long());
        let router = short.as_ref().unwrap_or(router);
        // Out of range it would have been refused.
        let objective = self.objective_in(set);
        let weighing = router.by_objective(objective.clone()).ok();
        let planned =
            weighing.as_ref().unwrap_or(router).route_by(&self.places, &request, &self.needs, &cancel);
        let (mut alternatives, mut shortest) = (Vec::new(), None);
        let (route, refusal) = match planned {
            Ok(route) => {
                let described = |route: &Route| self.described(route, set, &objective);
                shortest = route.shortest.as_deref().map(described);
                alternatives.extend(route.alternatives.iter().map(described));
                (Some(described(&route)), None)
            }
            Err((stretch, refusal)) => {
                let mut refused = refused(stretch, &refusal);
                if self.explain && matches!(refusal, Refusal::NoWay { .. }) {
                    let ends =
                        Request { from: self.places[stretch], to: self.places[stretch + 1], ..request };
                    self.explain(router, &ends, &cancel, &mut refused);
                }
                (None, Some(refused))
            }
        };
        SeaRouteAnswer {
            asked_depth_m: self.needs.demand.needed_m(),
            asked_clearance_m: self.needs.clearance_m,
            route,
            shortest,
            alternatives,
            refusal,
            took_ms: began.elapsed().as_secs_f64() * 1e3,
        }
    }

    fn explain(&self, router: &Router, ends: &Request, cancel: &Cancel<'_>, refused: &mut SeaRouteRefusal) {
        let mut passable = match router.passable(ends, &self.needs, cancel) {
            Ok(passable) => passable,
            Err(PlanError::OutOfTime) => {
                let text = "Smaller depths and clearances were not looked for to the end: the time for planning is used up.";
                refused.text = format!("{} {text}", refused.text);
                return;
            }
            // Cancelled: the client has gone.
            Err(_) => return,
        };
        if passable.not_looked {
            let text = "Smaller depths and clearances were not looked for: the charts around are too detailed for that.";
            refused.text = format!("{} {text}", refused.text);
            return;
        }
        // In water less deep than that it does not float, whatever is asked.
        if passable.depth_m.is_some_and(|depth_m| depth_m < self.limits.needed_m(0.0)) {
            (passable.depth_m, passable.shallowest) = (None, None);
        }
        refused.text = format!("{} {}", refused.text, passable_text(&passable));
        let Passable { depth_m, shallowest, clearance_m, gap, by_rule_alone, by_zones_alone, .. } = passable;
        refused.passable = Some(SeaRoutePassable {
            depth_m,
            shallowest_at: shallowest.map(degrees),
            clearance_m,
            gap_at: gap.map(|gap| degrees(gap.at)),
            gap_width_m: gap.map(|gap| gap.width_m),
            by_rule_alone,
            by_zones_alone,
        });
    }

    /// Where the water has no room for a vessel that is off its track.
    fn narrow(&self, route: &Route) -> Option<SeaRouteNarrow> {
        let needed_m = self.limits.room_m(self.stray_m);
        let Narrow { leg, least_m, legs, length_m } = route.narrow(needed_m)?;
        Some(SeaRouteNarrow { needed_m, leg, least_m, legs, length_m })
    }

    /// The objective, with the traffic of a chart set where it is minded.
    fn objective_in(&self, set: &Set) -> Objective {
        let minded = self.objective.traffic_factor > 1.0;
        let traffic = if minded { set.traffic.near(&self.places) } else { Vec::new() };
        Objective { traffic, ..self.objective.clone() }
    }

    fn described(&self, route: &Route, set: &Set, objective: &Objective) -> SeaRoute {
        let dangers =
            route.legs.iter().map(|leg| check_way("leg", leg.from, leg.to, &set.index, &self.limits));
        let guard = dangers.zip(0..).find_map(|(check, number)| reason(&LegCheck { number, ..check }));
        let via = route.moved_via.iter().map(|(number, moved)| (End::Via(*number), *moved));
        let start = route.moved_start.map(|moved| (End::Start, moved));
        let goal = route.moved_goal.map(|moved| (End::Goal, moved));
        let moved = start.into_iter().chain(via).chain(goal);
        let costs = route.reckon(objective);
        let current_unknown_m = costs.iter().map(|cost| cost.unknown_m).sum();
        let current_too_strong = costs.iter().any(|cost| cost.too_strong);
        let legs: Vec<SeaRouteLeg> =
            route.legs.iter().zip(costs).map(|(leg, cost)| described_leg(leg, cost)).collect();
        SeaRoute {
            points: route.places().map(degrees).collect(),
            length_m: route.length_m,
            speed_mps: route.speed_mps(objective),
            current_unknown_m,
            current_too_strong,
            duration_s: legs.iter().map(|leg| leg.duration_s).sum(),
            energy_wh: legs.iter().map(|leg| leg.energy_wh).sum(),
            legs,
            least_depth_m: route.least_depth_m(),
            least_clearance_m: route.least_clearance_m(),
            moved: moved.map(described_move).collect(),
            guarded: guard.is_none(),
            guard,
            narrow: self.narrow(route),
            part_only: route.of_part,
        }
    }
}

fn described_leg(leg: &RouteLeg, cost: LegCost) -> SeaRouteLeg {
    SeaRouteLeg {
        length_m: leg.length_m,
        course_deg: course_rad(leg).to_degrees(),
        duration_s: cost.duration_s,
        limit_mps: cost.limit_mps,
        traffic: cost.traffic.map(|InTraffic { kind, against }| SeaRouteTraffic {
            kind: traffic_code(kind).to_owned(),
            against,
        }),
        energy_wh: cost.energy_j.map(|energy_j| energy_j / 3_600.0),
        least_depth_m: leg.worst.water.least_m(),
        least_depth_at: degrees(leg.worst.at),
        clearance_m: leg.clearance_m,
        turn_text: leg.turn.and_then(|turn| turn.trouble).map(|trouble| sentence(&trouble.to_string())),
    }
}

fn traffic_code(kind: TrafficKind) -> &'static str {
    match kind {
        TrafficKind::Lane => "lane",
        TrafficKind::SeparationZone => "separation_zone",
        TrafficKind::Junction => "junction",
        TrafficKind::DeepWater => "deep_water",
    }
}

fn course_rad(leg: &RouteLeg) -> f64 {
    wrap_two_pi(LocalPoint::default().bearing_rad(LocalFrame::new(leg.from).to_local(leg.to)))
}

/// Reads the areas of a request that routes avoid or stay within; `None` if it has none of these.
fn zones(asked: &[SeaRouteZone], margin_m: f64) -> std::result::Result<Option<Zones>, Said> {
    if asked.is_empty() {
        return Ok(None);
    }
    if asked.len() > ZONES {
        return Err(say("zones: there are {n}; give up to {most}")
            .with("n", asked.len())
            .with("most", ZONES)
            .into());
    }
    let all: usize = asked.iter().map(|zone| zone.corners.len()).sum();
    if all > ALL_CORNERS {
        return Err(say("zones: they have {n} corners; give up to {most} in all")
            .with("n", all)
            .with("most", ALL_CORNERS)
            .into());
    }
    let (mut within, mut avoid, mut borders_km) = (None, Vec::new(), 0.0);
    for (number, SeaRouteZone { kind, corners, .. }) in asked.iter().enumerate() {
        let zone = zone(corners).map_err(|text| text.of_field(&format!("zones[{number}]")))?;
        borders_km += zone.border_m() / 1e3;
        match kind {
            SeaRouteZoneKind::Avoid => avoid.push(zone),
            SeaRouteZoneKind::Within if within.is_none() => within = Some(zone),
            // Read with the objective.
            SeaRouteZoneKind::Limit => {}
            SeaRouteZoneKind::Within => {
                return Err(say("zones[{number}]: only one area can be to stay within")
                    .with("number", number)
                    .into());
            }
        }
    }
    if borders_km > ALL_BORDERS_KM {
        return Err(say("zones: their borders are {km} km long; give up to {most_km} km in all")
            .with("km", format!("{borders_km:.0}"))
            .with("most_km", format!("{ALL_BORDERS_KM:.0}"))
            .into());
    }
    if within.is_none() && avoid.is_empty() {
        return Ok(None);
    }
    Zones::new(within, avoid, margin_m).map(Some).map_err(|error| wrong::zone(error).of_field("zones"))
}

fn zone(corners: &[[f64; 2]]) -> std::result::Result<Zone, Said> {
    if !CORNERS.contains(&corners.len()) {
        let (least, most) = CORNERS.into_inner();
        return Err(say("it has {n} corners; give {least} to {most}")
            .with("n", corners.len())
            .with("least", least)
            .with("most", most)
            .into());
    }
    let place = |[lat, lon]: [f64; 2]| {
        LatLon::from_deg(lat, lon).map_err(|error| Said::from(not_a_place(lat, lon, error)))
    };
    let corners = corners.iter().copied().map(place).collect::<std::result::Result<Vec<_>, _>>()?;
    Zone::drawn(corners).map_err(wrong::zone)
}

fn malformed(text: impl Into<Said>) -> Error {
    Error::new(ErrorKind::Malformed, text)
}

fn not_a_place(lat: f64, lon: f64, error: impl std::fmt::Display) -> Wording {
    say("{lat}, {lon} is not a place: {error}").with("lat", lat).with("lon", lon).with("error", error)
}

/// What a way needs: what is asked for, else what the guard demands.
pub fn needs(limits: &GuardLimits, least_depth_m: Option<f64>, clearance_m: Option<f64>) -> Needs {
    let demand = limits.demand(least_depth_m.unwrap_or(limits.autonomous_m));
    Needs { demand, clearance_m: clearance_m.unwrap_or_else(|| limits.half_width_m()) }
}

fn degrees(place: LatLon) -> [f64; 2] {
    [place.lat_deg(), place.lon_deg()]
}

fn described_move((end, Moved { distance_m, .. }): (End, Moved)) -> SeaRouteMoved {
    let (code, via) = match end {
        End::Start => ("start", None),
        End::Via(number) => ("via", Some(number)),
        End::Goal => ("goal", None),
    };
    let text = format!(
        "{end} lies too near land, shallow water, a danger or an area to avoid; it was moved by {distance_m:.0} m"
    );
    SeaRouteMoved { end: code.to_owned(), via, distance_m, text: sentence(&text) }
}

/// The code of a refusal where not all water was looked at.
const NOT_FOUND: &str = "not_found";

fn refused(stretch: usize, refusal: &Refusal) -> SeaRouteRefusal {
    let code = match refusal {
        Refusal::Closed { end: End::Start, .. } => "closed_start",
        Refusal::Closed { end: End::Via(_), .. } => "closed_via",
        Refusal::Closed { end: End::Goal, .. } => "closed_goal",
        Refusal::NoWay { .. } => "no_way",
        Refusal::TooFar { .. } | Refusal::TooLong { .. } => "too_far",
        Refusal::Unknown { .. } => NOT_FOUND,
        Refusal::GaveUp { .. } => "gave_up",
        Refusal::NotConfirmed { .. } => "not_confirmed",
        Refusal::Needs(_) | Refusal::Plan(_) => "failed",
    };
    let mut told = SeaRouteRefusal {
        code: code.to_owned(),
        text: sentence(&refusal.to_string()),
        stretch,
        nearest: None,
        gap_m: None,
        closed: None,
        apart_m: None,
        looked_m: None,
        gave_up: None,
        via: None,
        by: Vec::new(),
        passable: None,
    };
    match refusal {
        Refusal::Closed { end, water, refused, zoned, nearest_m, allowed_m } => {
            told.via = match end {
                End::Via(number) => Some(*number),
                End::Start | End::Goal => None,
            };
            told.gap_m = *nearest_m;
            let code = if *zoned { "zone" } else { water_code(*water, *refused) }.to_owned();
            told.closed = Some(SeaRouteClosed { code, depth_m: water.least_m(), may_move_m: *allowed_m });
        }
        Refusal::NoWay { nearest, gap_m, looked_km } => {
            (told.nearest, told.gap_m) = (Some(degrees(*nearest)), Some(*gap_m));
            told.looked_m = looked_km.map(|km| km * 1e3);
        }
        Refusal::GaveUp { tiles, looked_km, spent } => {
            told.looked_m = Some(looked_km * 1e3);
            told.gave_up = Some(SeaRouteGaveUp { tiles: *tiles, out_of_time: *spent == Spent::Time });
        }
        Refusal::Unknown { looked_km, nearest, gap_m } => {
            (told.nearest, told.gap_m) = (Some(degrees(*nearest)), Some(*gap_m));
            told.looked_m = Some(looked_km * 1e3);
        }
        Refusal::TooFar { straight_km, most_km, by } => {
            told.apart_m = Some([straight_km * 1e3, most_km * 1e3]);
            told.by = by.iter().copied().map(degrees).collect();
        }
        Refusal::TooLong { .. } | Refusal::NotConfirmed { .. } | Refusal::Needs(_) | Refusal::Plan(_) => {}
    }
    told
}

/// What closes a place, as a code of the guard.
fn water_code(water: Water, refused: Option<Restriction>) -> &'static str {
    let reason = match (water, refused) {
        (Water::Depth { .. }, Some(restriction)) => Reason::Entry(restriction),
        (Water::Depth { .. }, None) => Reason::TooShallow,
        (Water::Land, _) => Reason::Land,
        (Water::Obstacle, _) => Reason::Obstacle,
        (Water::UnknownDepth, _) => Reason::UnknownDepth,
        (Water::NoData, _) => Reason::NoData,
        (Water::TooLow { .. }, _) => Reason::TooLow,
    };
    reason.code()
}

fn passable_text(passable: &Passable) -> String {
    let mut would_do = Vec::new();
    if let Some(depth_m) = passable.depth_m {
        would_do.push(format!("a least depth of {depth_m} m"));
    }
    if let Some(clearance_m) = passable.clearance_m {
        would_do.push(format!("a clearance of {clearance_m} m"));
    }
    let text = match &would_do[..] {
        [] => "No smaller depth or clearance was found that gives one.".to_owned(),
        some => format!("There is one with {}.", some.join(", or with ")),
    };
    let gap = passable.gap.map_or_else(String::new, |gap| {
        let (lat_deg, lon_deg) = (gap.at.lat_deg(), gap.at.lon_deg());
        format!(" The narrowest gap is {:.0} m wide, at {lat_deg:.5}, {lon_deg:.5}.", gap.width_m)
    });
    let rule = if passable.by_rule_alone {
        " Areas where entry is prohibited or restricted are in the way; without them there is a route."
    } else {
        ""
    };
    let zones = if passable.by_zones_alone {
        " The areas to avoid or to stay within are in the way; without them there is a route."
    } else {
        ""
    };
    format!("{text}{gap}{rule}{zones}")
}

/// With a capital letter and a full stop.
fn sentence(text: &str) -> String {
    text[..1].to_uppercase() + &text[1..] + "."
}
