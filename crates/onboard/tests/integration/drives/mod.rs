//! Random drives: the hull never comes where it is too shallow, and what is safe is not stopped.
//!
//! Plans with legs over shoals, operators who steer for land or fall silent, references to anywhere; a current,
//! and a position that is off by up to what is stated. They go over made-up seas (`made_up`) and over the fictitious
//! archipelago of the demonstration (`archipelago`). Each is the same in every run, by its seed. `make test` runs
//! some, all 500 of each by `cargo test --release -p onboard --test integration drives -- --ignored --nocapture`, which
//! `make bench` does.

mod archipelago;
mod made_up;
mod routes;

use crate::common::*;
use archipelago::Archipelago;
use imc::messages::*;
use made_up::MadeUp;
use onboard::{Chart, Entity, GroundingSettings, Settings};
use std::f64::consts::TAU;
use std::ops::Range;
use testkit::Numbers;
use units::{LatLon, LocalFrame, LocalPoint, wrap_pi};

/// Half of the hull's diagonal (m).
const HULL_M: f64 = 1.14;
const HOME: LocalPoint = LocalPoint { north_m: 0.0, east_m: 0.0 };
/// A track with so much room on both sides is a safe one (m).
const ROOM_M: f64 = 30.0;

/// The sea of a drive, in metres around its start.
trait Waters {
    /// The water of a drive.
    fn of(numbers: &mut Numbers) -> Self;
    /// The chart aboard.
    fn chart(&self) -> Chart;
    /// The start.
    fn frame(&self) -> LocalFrame;
    /// Somewhere that is too shallow.
    fn danger(&self, numbers: &mut Numbers, least_m: f64) -> LocalPoint;
    /// Where a plan may lead.
    fn goals(&self, numbers: &mut Numbers) -> Vec<LocalPoint>;
    /// Whether a straight track keeps so much room everywhere.
    fn has_room(&self, from: LocalPoint, to: LocalPoint, room_m: f64, least_m: f64) -> bool;
    /// Whether the hull may be where it is.
    fn is_afloat(&self, at: LocalPoint, least_m: f64) -> bool;
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Plan,
    Reference,
    Operator,
    Silence,
}

/// The result of a drive.
#[derive(Debug)]
struct Drive {
    kind: Kind,
    /// The plan was refused at its start.
    refused: bool,
    /// The order keeps well clear of danger.
    safe: bool,
    /// The supervisor blocked thrust, or took over.
    stopped: bool,
    /// The hull was where it is too shallow.
    grounded: Option<LocalPoint>,
}

fn drive<W: Waters>(seed: u64) -> Drive {
    let mut numbers = Numbers(0x9E37_79B9_7F4A_7C15 ^ (seed + 1).wrapping_mul(0x2545_F491_4F6C_DD1D));
    // The first numbers of near seeds are near.
    for _ in 0..8 {
        numbers.within(0.0, 1.0);
    }
    let waters = W::of(&mut numbers);
    let grounding = GroundingSettings { chart: waters.chart(), ..GroundingSettings::default() };
    let stated_m = grounding.limits.position_m;
    // The vessel believes to be where the simulation has it; the ground lies elsewhere by as much.
    let off = HOME.displaced(numbers.within(0.0, TAU), numbers.within(0.0, stated_m));
    let kind = [Kind::Plan, Kind::Operator, Kind::Plan, Kind::Reference, Kind::Operator, Kind::Silence]
        [(seed % 6) as usize];
    // Half of those who steer, and of the currents, go for what is too shallow.
    let aims_at_danger = kind != Kind::Plan && numbers.within(0.0, 1.0) < 0.5;
    let least_m = if matches!(kind, Kind::Plan | Kind::Reference) { 5.0 } else { 1.0 };
    let danger = waters.danger(&mut numbers, least_m);
    let towards_rad = match kind {
        Kind::Silence if aims_at_danger => HOME.bearing_rad(danger),
        _ => numbers.within(0.0, TAU),
    };
    let current = (numbers.within(0.0, 0.3), towards_rad);
    let mut sea = Sea::with(Settings { grounding, ..settings() }, |vessel| {
        vessel.start_place = waters.frame().origin();
        (vessel.environment.current.speed_mps, vessel.environment.current.to_rad) = current;
    })
    .ready();
    let mut goals = waters.goals(&mut numbers);
    if aims_at_danger {
        goals[0] = danger;
    }
    let mut drive = Drive { kind, refused: false, safe: false, stopped: false, grounded: None };
    begin(&mut sea, &mut drive, &waters, (&goals, current), least_m);
    let seconds = if drive.refused { 5.0 } else { 400.0 };
    let goal = (goals[0], waters.frame().to_place(goals[0]));
    sail(&mut sea, &mut drive, seconds, goal, |at| {
        let true_at = LocalPoint { north_m: at.north_m + off.north_m, east_m: at.east_m + off.east_m };
        waters.is_afloat(true_at, least_m)
    });
    drive
}

/// Orders the drive, and returns whether it is safe.
fn begin<W: Waters>(
    sea: &mut Sea,
    drive: &mut Drive,
    waters: &W,
    (goals, current): (&[LocalPoint], (f64, f64)),
    least_m: f64,
) {
    let start = sea.position();
    match drive.kind {
        Kind::Plan => {
            let legs = goals.iter().enumerate();
            let legs = legs.map(|(n, at)| {
                let target = waters.frame().to_place(*at);
                let to = Goto { lat: target.lat_rad(), lon: target.lon_rad(), ..goto(0.0, 0.0, 1.5) };
                (format!("wp{n}"), to.into())
            });
            let request = sea.ask(PlanControlOp::Start, "legs", Some(plan("legs", legs.collect()).into()));
            sea.run(0.5);
            let replies = sea.replies(request);
            drive.refused = replies.iter().any(|reply| reply.r#type == PlanControlType::Failure);
            drive.safe = !drive.refused;
        }
        Kind::Reference => {
            let control = FollowReference {
                control_src: 0xFFFF,
                control_ent: 0xFF,
                timeout: 60.0,
                ..Default::default()
            };
            sea.ask(PlanControlOp::Start, "follow", Some(control.into()));
            drive.safe = waters.has_room(start, goals[0], ROOM_M, least_m);
        }
        Kind::Operator => {
            sea.ask(PlanControlOp::Start, "hand", Some(Teleoperation::default().into()));
            drive.safe = waters.has_room(start, goals[0], ROOM_M, least_m);
        }
        Kind::Silence => {
            sea.ask(PlanControlOp::Start, "hand", Some(Teleoperation::default().into()));
            let end = start.displaced(current.1, current.0 * 400.0);
            drive.safe = waters.has_room(start, end, ROOM_M, least_m);
        }
    }
}

/// Lets the console do its part until the end, or until the vessel is there.
fn sail(
    sea: &mut Sea,
    drive: &mut Drive,
    seconds: f64,
    (goal, target): (LocalPoint, LatLon),
    is_deep: impl Fn(LocalPoint) -> bool,
) {
    let step_s = 0.25;
    for n in 0..(seconds / step_s) as u32 {
        let at = sea.position();
        let there = at.distance_m(goal) < 15.0;
        match drive.kind {
            Kind::Operator if there => return,
            Kind::Operator => {
                let heading_rad = sea.vehicle.hull.vessel.truth().state.psi_rad;
                let error_rad = wrap_pi(at.bearing_rad(goal) - heading_rad);
                let (turn, thrust) =
                    ((80.0 * error_rad).clamp(-60.0, 60.0), if error_rad.abs() < 0.6 { 100 } else { 20 });
                let keys = format!("Throttle={thrust};Heading={turn:.0}");
                sea.send(RemoteActions { actions: keys.into() });
            }
            Kind::Reference if n % 4 == 0 => {
                sea.send(Reference {
                    flags: ReferenceFlags::LOCATION | ReferenceFlags::SPEED,
                    lat: target.lat_rad(),
                    lon: target.lon_rad(),
                    speed: DesiredSpeed { value: 1.5, speed_units: SpeedUnits::MetersPs }.into(),
                    ..Reference::default()
                });
            }
            Kind::Reference if there => return,
            Kind::Plan | Kind::Silence | Kind::Reference => {}
        }
        sea.run(step_s);
        if drive.grounded.is_none() && !is_deep(sea.position()) {
            drive.grounded = Some(sea.position());
        }
        if n % 20 == 19 {
            drive.stopped |= interfered(sea);
            if drive.kind == Kind::Plan && sea.plan_state().state == PlanControlStateState::Ready {
                return;
            }
            sea.forget();
        }
    }
    drive.stopped |= interfered(sea);
}

/// Whether the supervisor did more than warn.
fn interfered(sea: &Sea) -> bool {
    let own = sea.said.iter().filter(|(_, packet)| packet.header.src_ent == Entity::Grounding.number());
    own.clone()
        .filter_map(|(_, packet)| packet.get::<EntityState>())
        .any(|state| state.description.to_str_lossy().contains("blocked"))
        || own
            .filter_map(|(_, packet)| packet.get::<LogBookEntry>())
            .any(|entry| entry.text.to_str_lossy().ends_with("back to deep water"))
}

fn drives<W: Waters>(seeds: Range<u64>) {
    let count = seeds.end - seeds.start;
    let all: Vec<(u64, Drive)> = seeds.map(|seed| (seed, drive::<W>(seed))).collect();
    let number = |wanted: &dyn Fn(&Drive) -> bool| all.iter().filter(|(_, drive)| wanted(drive)).count();
    let (safe, stopped) = (number(&|d| d.safe), number(&|d| d.safe && d.stopped));
    println!(
        "{count} drives over {}: {} plans refused, {safe} safe ones of which {stopped} were stopped, {} others stopped, {} grounded",
        std::any::type_name::<W>().rsplit(':').next().unwrap_or_default(),
        number(&|d| d.refused),
        number(&|d| !d.safe && d.stopped),
        number(&|d| d.grounded.is_some()),
    );
    for (seed, drive) in all.iter().filter(|(_, d)| d.grounded.is_some() || d.safe && d.stopped) {
        println!("  drive {seed}: {drive:?}");
    }
    assert_eq!(number(&|d| d.grounded.is_some()), 0);
    // 2 %, of few drives at most one.
    assert!(stopped * 50 <= safe.max(50), "{stopped} of {safe} safe drives were stopped");
    assert!(number(&|d| !d.safe && (d.stopped || d.refused)) * 10 >= all.len() * 3, "there is danger");
}

#[test]
fn some_random_drives_over_made_up_seas_keep_off_the_ground() {
    drives::<MadeUp>(120..144);
}

#[test]
fn some_random_drives_in_the_archipelago_keep_off_the_ground() {
    // 313 drifts in slowly with its motors blocked.
    drives::<Archipelago>(300..324);
}

#[test]
#[ignore = "minutes; run it optimised as the head of this file says"]
fn five_hundred_random_drives_over_made_up_seas_keep_off_the_ground() {
    drives::<MadeUp>(0..500);
}

#[test]
#[ignore = "minutes; run it optimised as the head of this file says"]
fn five_hundred_random_drives_in_the_archipelago_keep_off_the_ground() {
    drives::<Archipelago>(0..500);
}
