//! The guard against a reference that samples every way each 0.1 m and looks at every polygon of the chart;
//! and an index that was made against the same from bytes.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

use charts::depth_index::DepthIndex;
use guard::{GuardLimits, Outcome};
use mission::{
    DraftBody, FollowPath, Goto, Idle, Loiter, LoiterShape, Maneuver, ManeuverDraft, Plan, PlanDraft,
    PlanLimits, RawPlace, Rows, StationKeeping, TransitionDraft, check_plan,
};
use std::f64::consts::TAU;
use std::time::Duration;
use testkit::Numbers;
use testkit::sea::{Ground, Sea};
use units::{LatLon, LocalPoint, Speed, Turn};

const SPEED: Speed = Speed::MetresPerSecond(1.5);
/// Step of the reference (m).
const STEP_M: f64 = 0.1;
/// Vertices of an index are rounded to 1e-7 degrees, 0.8 cm in both directions.
const ROUNDED_M: f64 = 0.02;

fn sea(numbers: &mut Numbers) -> Sea {
    let mut sea = Sea::new(LatLon::from_deg(63.44, 10.35).unwrap(), 600.0, 12.0);
    for n in 0..12 {
        let ground = match n % 4 {
            0 => Ground::Land,
            1 => Ground::Depth(numbers.within(-1.0, 4.9)),
            2 => Ground::Depth(numbers.within(5.0, 9.0)),
            _ => Ground::Danger,
        };
        let (at, radius_m) = (numbers.point(550.0), numbers.within(2.0, 60.0));
        sea = sea.with(ground, at, radius_m, 3 + n % 6);
    }
    sea
}

fn build(maneuvers: Vec<Maneuver<RawPlace>>) -> Plan {
    let id = |n: usize| format!("m{n}");
    let transitions = (1..maneuvers.len()).map(|n| TransitionDraft { from: id(n - 1), to: id(n) }).collect();
    let named = maneuvers.into_iter().enumerate().map(|(n, maneuver)| ManeuverDraft {
        id: id(n),
        depth_m: None,
        body: DraftBody::Maneuver(maneuver),
    });
    let draft = PlanDraft {
        id: "p".to_owned(),
        start: id(0),
        maneuvers: named.collect(),
        transitions,
        notes: vec![],
    };
    Plan::build(&draft, &PlanLimits::default()).unwrap()
}

fn turn(numbers: &mut Numbers) -> Turn {
    if numbers.share() < 0.5 { Turn::Clockwise } else { Turn::CounterClockwise }
}

fn maneuver(sea: &Sea, numbers: &mut Numbers, span_m: f64) -> Maneuver<RawPlace> {
    let frame = sea.frame();
    let at = numbers.point(span_m);
    let centre = RawPlace::from(frame.to_place(at));
    let duration = Some(Duration::from_mins(1));
    match (numbers.share() * 6.0) as u32 {
        0 | 1 => Maneuver::Goto(Goto { target: centre, speed: SPEED }),
        2 => {
            let shape = if numbers.share() < 0.7 {
                LoiterShape::Circle(turn(numbers))
            } else {
                LoiterShape::Eight {
                    length_m: numbers.within(0.0, 200.0),
                    bearing_rad: numbers.within(0.0, TAU),
                }
            };
            let radius_m = numbers.within(5.0, 80.0);
            Maneuver::Loiter(Loiter { centre, radius_m, speed: SPEED, duration, shape })
        }
        3 => {
            let radius_m = numbers.within(5.0, 80.0);
            Maneuver::StationKeeping(StationKeeping { centre, radius_m, speed: SPEED, duration })
        }
        4 => {
            let points = (0..4).map(|_| numbers.point(100.0)).collect();
            Maneuver::FollowPath(FollowPath { origin: centre, points, speed: SPEED })
        }
        _ if numbers.share() < 0.3 => Maneuver::Idle(Idle { duration }),
        _ => Maneuver::Rows(Rows {
            origin: centre,
            speed: SPEED,
            bearing_rad: numbers.within(0.0, TAU),
            cross_angle_rad: 0.0,
            width_m: numbers.within(20.0, 80.0),
            length_m: numbers.within(20.0, 150.0),
            step_m: 20.0,
            curve_offset_m: 5.0,
            alternation: 1.0,
            square_curve: numbers.share() < 0.5,
            curve_right: numbers.share() < 0.5,
        }),
    }
}

/// One way that a plan may take, point by point, and how far from each it may stray: circles are left at any
/// place, stations from any place inside.
struct Sampler<'a> {
    sea: &'a Sea,
    limits: &'a GuardLimits,
    here: LocalPoint,
    safe: bool,
}

impl Sampler<'_> {
    fn look(&mut self, at: LocalPoint, radius_m: f64) {
        let reach_m = radius_m + self.limits.position_m - ROUNDED_M;
        self.safe = self.safe && self.sea.is_deep_within(at, reach_m, self.limits.autonomous_m);
    }

    fn go(&mut self, to: LocalPoint) {
        let (from, wide_m) = (self.here, self.limits.half_width_m());
        let steps = (from.distance_m(to) / STEP_M).ceil().max(1.0);
        for n in 0..=steps as u32 {
            if !self.safe {
                return;
            }
            let t = f64::from(n) / steps;
            let at = LocalPoint {
                north_m: from.north_m + t * (to.north_m - from.north_m),
                east_m: from.east_m + t * (to.east_m - from.east_m),
            };
            self.look(at, wide_m);
        }
        self.here = to;
    }

    fn round(&mut self, centre: LocalPoint, radius_m: f64) {
        let wide_m = self.limits.half_width_m();
        let steps = (TAU * radius_m / STEP_M).ceil();
        for n in 0..steps as u32 {
            if !self.safe {
                return;
            }
            self.look(centre.displaced(TAU * f64::from(n) / steps, radius_m), wide_m);
        }
    }

    fn sail(&mut self, maneuver: &Maneuver, numbers: &mut Numbers) {
        let frame = self.sea.frame();
        let places = maneuver.places();
        match maneuver {
            Maneuver::Loiter(loiter) => {
                let centre = frame.to_local(loiter.centre);
                let radius_m = loiter.radius_m;
                let bearings_rad = [0; 4].map(|_| numbers.within(0.0, TAU));
                let circle = |sampler: &mut Self, centre: LocalPoint, left_rad: f64| {
                    sampler.round(centre, radius_m);
                    sampler.here = centre.displaced(left_rad, radius_m);
                };
                match loiter.shape {
                    LoiterShape::Circle(turn) | LoiterShape::Other(turn) => {
                        let ahead_rad = self.here.bearing_rad(centre);
                        let port_rad = if turn == Turn::Clockwise { -TAU / 4.0 } else { TAU / 4.0 };
                        self.go(centre.displaced(ahead_rad + port_rad, radius_m));
                        circle(self, centre, bearings_rad[0]);
                    }
                    LoiterShape::Eight { length_m, bearing_rad } => {
                        let half_m = length_m.max(2.0 * radius_m) / 2.0;
                        let ends = [half_m, -half_m].map(|half_m| centre.displaced(bearing_rad, half_m));
                        self.go(ends[1].displaced(bearings_rad[0], radius_m));
                        circle(self, ends[1], bearings_rad[1]);
                        self.go(ends[0].displaced(bearings_rad[2], radius_m));
                        circle(self, ends[0], bearings_rad[3]);
                    }
                }
            }
            Maneuver::StationKeeping(station) => {
                let centre = frame.to_local(station.centre);
                self.go(centre);
                self.look(centre, station.radius_m + self.limits.hull_m);
                let share = numbers.share();
                self.here = centre.displaced(numbers.within(0.0, TAU), share * station.radius_m);
            }
            Maneuver::Idle(idle) => {
                let drift_m = self.limits.drift_mps * idle.duration.unwrap().as_secs_f64();
                self.look(self.here, drift_m + self.limits.hull_m);
                self.here = self.here.displaced(numbers.within(0.0, TAU), drift_m);
            }
            _ => places.iter().for_each(|place| self.go(frame.to_local(*place))),
        }
    }
}

#[test]
fn nothing_is_accepted_that_the_reference_finds_unsafe() {
    let limits = GuardLimits { cross_track_m: 4.0, position_m: 2.0, ..GuardLimits::default() };
    let mut numbers = Numbers(0x9E37_79B9_7F4A_7C15);
    let (mut accepted, mut refused, mut refused_safe) = (0, 0, 0);
    for _ in 0..testkit::so_many(8, 24) {
        let sea = sea(&mut numbers);
        let index = sea.index();
        for _ in 0..25 {
            let start = numbers.point(500.0);
            let count = 1 + (numbers.share() * 2.0) as usize;
            let plan = build((0..count).map(|_| maneuver(&sea, &mut numbers, 450.0)).collect());
            let verdict = check_plan(&plan, Some(sea.frame().to_place(start)), &index, &limits);
            let mut sampler = Sampler { sea: &sea, limits: &limits, here: start, safe: true };
            plan.nodes().iter().for_each(|node| sampler.sail(node.maneuver(), &mut numbers));
            if verdict.is_refused() {
                refused += 1;
                refused_safe += u32::from(sampler.safe);
                let leg = verdict.refused().next().unwrap();
                let at = sea.frame().to_local(leg.spot.at);
                assert!(!sea.is_deep_within(at, 0.05, limits.autonomous_m), "{leg}");
            } else {
                assert!(sampler.safe, "accepted: {plan:?} from {start:?}");
                accepted += 1;
            }
        }
    }
    println!(
        "{accepted} plans accepted, {refused} refused; one way sampled in each refused plan was safe in {refused_safe}"
    );
    assert!(accepted > 30 && refused > 30, "{accepted} and {refused}");
}

/// The vessel's index comes as bytes. Both whole ways of a plan are compared in the server's tests.
#[test]
fn an_index_from_bytes_judges_as_the_one_that_was_made() {
    let mut numbers = Numbers(77);
    let limits = GuardLimits::default();
    let mut outcomes = [0_u32; 3];
    for _ in 0..20 {
        let sea = sea(&mut numbers);
        let ashore = sea.index();
        let aboard = DepthIndex::from_bytes(&sea.index().to_bytes()).unwrap();
        for _ in 0..100 {
            let start = sea.frame().to_place(numbers.point(500.0));
            let from = (numbers.share() < 0.9).then_some(start);
            let count = 1 + (numbers.share() * 3.0) as usize;
            let plan = build((0..count).map(|_| maneuver(&sea, &mut numbers, 450.0)).collect());
            let verdict = check_plan(&plan, from, &ashore, &limits);
            assert_eq!(verdict, check_plan(&plan, from, &aboard, &limits));
            outcomes[match verdict.outcome() {
                Outcome::Ok => 0,
                Outcome::Warnings => 1,
                Outcome::Refused => 2,
            }] += 1;
        }
    }
    println!("ok, warnings, refused: {outcomes:?}");
    assert!(outcomes.iter().all(|count| *count > 50), "{outcomes:?}");
}

/// Plans over a real harbour: what is accepted has no spot that the index itself calls dangerous each metre.
#[test]
fn real_cells_give_reasons() {
    let names: Vec<String> = (0..=4).map(|update| format!("US5WA22M.{update:03}")).collect();
    let Some(files) = names
        .iter()
        .map(|name| Some(std::fs::read(testkit::shared(&format!("data/charts/{name}"))?).unwrap()))
        .collect::<Option<Vec<_>>>()
    else {
        return;
    };
    let named: Vec<_> =
        names.iter().zip(&files).map(|(name, bytes)| charts::s57::NamedBytes { name, bytes }).collect();
    let cell = charts::s57::Cell::read(named[0], &named[1..]).unwrap();
    let mut builder = charts::depth_index::IndexBuilder::new();
    builder.add_cell(&cell).unwrap();
    let index = builder.build().unwrap();
    let bay = LatLon::from_deg(47.287, -122.45).unwrap();
    let limits = GuardLimits::default();
    let demand = limits.demand(limits.autonomous_m);
    let frame = units::LocalFrame::new(bay);
    let mut numbers = Numbers(5);
    let mut outcomes = [0_u32; 2];
    for _ in 0..200 {
        let (from, to) = (numbers.point(2500.0), numbers.point(2500.0));
        let target = RawPlace::from(frame.to_place(to));
        let plan = build(vec![Maneuver::Goto(Goto { target, speed: SPEED })]);
        let verdict = check_plan(&plan, Some(frame.to_place(from)), &index, &limits);
        outcomes[usize::from(verdict.is_refused())] += 1;
        if verdict.is_refused() {
            assert!(
                verdict.refused().all(|leg| leg.spot.cell.as_deref().is_none_or(|cell| cell == "US5WA22M"))
            );
            continue;
        }
        let steps = from.distance_m(to).ceil();
        for n in 0..=steps as u32 {
            let t = f64::from(n) / steps;
            let at = LocalPoint {
                north_m: from.north_m + t * (to.north_m - from.north_m),
                east_m: from.east_m + t * (to.east_m - from.east_m),
            };
            assert!(index.depth_at(frame.to_place(at), &demand).navigable, "{at:?}");
        }
    }
    println!("accepted, refused: {outcomes:?}");
    assert!(outcomes.iter().all(|count| *count > 5), "{outcomes:?}");
}
