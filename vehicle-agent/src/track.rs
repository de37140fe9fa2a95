//! The true track of a simulated vessel while its plan ran, compared with the plan.
//!
//! A leg begins at the planned end of the previous maneuver; the first one at the vessel's position when the plan began.
//! Cross-track errors are positive to starboard of the leg. A vessel counts as settled from 40 m after the beginning of a
//! leg up to 15 m before its end.

use crate::plot::{Curve, Plot, Point};
use control::MotorPair;
use imc::messages::{Goto, Message, PlanManeuver, PlanSpecification, SpeedUnits, StationKeeping};
use units::{LatLon, LocalFrame, LocalPoint};

/// Time between two samples (s).
const PERIOD_S: f64 = 0.5;
/// A leg counts from here (m).
const SETTLED_AFTER_M: f64 = 40.0;
/// A leg counts until so long before its end (m).
const SETTLED_BEFORE_M: f64 = 15.0;
/// Least course change that makes a vessel swing out (rad).
const TURN_RAD: f64 = 0.3;

/// The reference of a maneuver.
#[derive(Debug, Clone, Copy)]
enum Want {
    Leg { to: LocalPoint, speed_mps: Option<f64> },
    Station { centre: LocalPoint, radius_m: f64 },
    Other,
}

#[derive(Debug, Clone, Copy)]
struct Sample {
    time_s: f64,
    at: LocalPoint,
    speed_mps: f64,
    /// Index of the maneuver.
    stage: usize,
    /// The motor command.
    motors: MotorPair,
    /// Whether a motor was commanded to turn since the previous sample.
    turning: bool,
}

/// A straight leg.
#[derive(Debug, Clone, Copy)]
struct Leg {
    from: LocalPoint,
    to: LocalPoint,
}

/// The true track of a run.
#[derive(Debug)]
pub(crate) struct Track {
    name: String,
    stages: Vec<(String, Want)>,
    samples: Vec<Sample>,
    begun_s: Option<f64>,
    motors: MotorPair,
    turned_since: bool,
}

impl Track {
    /// An empty track.
    pub(crate) fn new(plan: &PlanSpecification, frame: &LocalFrame) -> Self {
        let stages = plan.maneuvers.of::<PlanManeuver>().map(|node| {
            let want = node.data.get().map_or(Want::Other, |data| want(&data, frame));
            (node.maneuver_id.to_str_lossy().into_owned(), want)
        });
        Self {
            name: plan.plan_id.to_str_lossy().into_owned(),
            stages: stages.collect(),
            samples: Vec::new(),
            begun_s: None,
            motors: MotorPair::STOPPED,
            turned_since: false,
        }
    }

    /// Sets the motor command from here on.
    pub(crate) fn command(&mut self, motors: MotorPair) {
        self.motors = motors;
        self.turned_since |= motors != MotorPair::STOPPED;
    }

    /// Adds a sample: the maneuver of a running plan, true position and speed.
    pub(crate) fn see(&mut self, now_s: f64, maneuver: Option<&str>, at: LocalPoint, speed_mps: f64) {
        let Some(stage) = maneuver.and_then(|id| self.stages.iter().position(|(name, _)| name == id)) else {
            return;
        };
        let time_s = now_s - *self.begun_s.get_or_insert(now_s);
        if self.samples.last().is_some_and(|last| time_s < last.time_s + PERIOD_S) {
            return;
        }
        let on = self.motors != MotorPair::STOPPED;
        let turning = std::mem::replace(&mut self.turned_since, on) || on;
        self.samples.push(Sample { time_s, at, speed_mps, stage, motors: self.motors, turning });
    }

    /// The plot of the run; the line of conditions is shown below the figures. `activity_per_s` is the motor
    /// activity ([`control::MotorActivity`]) while the plan ran.
    pub(crate) fn plot(&self, conditions: &str, activity_per_s: Option<f64>) -> Plot {
        let point = |at: LocalPoint| (at.east_m, at.north_m);
        let stations = self.stages.iter().filter_map(|(_, want)| match want {
            Want::Station { centre, radius_m } => Some((point(*centre), *radius_m)),
            Want::Leg { .. } | Want::Other => None,
        });
        let on_station = self.stages.iter().all(|(_, want)| matches!(want, Want::Station { .. }));
        let first = self.samples.first().map(|sample| sample.at).filter(|_| !on_station);
        let ends = (0..self.stages.len()).filter_map(|stage| self.end(stage));
        let duration_s = self.samples.last().map_or(0.0, |last| last.time_s);
        Plot {
            title: format!("Plan \"{}\", {}", self.name, spoken(duration_s)),
            notes: vec![self.figures(), self.effort(activity_per_s), conditions.to_owned()],
            track: self.samples.iter().map(|sample| point(sample.at)).collect(),
            plan: first.into_iter().chain(ends).map(point).collect(),
            circles: stations.collect(),
            curves: vec![
                if on_station { self.distance() } else { self.error() },
                self.speed(on_station),
                self.actuation(),
            ],
        }
    }

    /// The figures of a run, in one line.
    fn figures(&self) -> String {
        let mut parts = Vec::new();
        let settled: Vec<f64> = self.samples.iter().filter_map(|sample| self.settled(sample)).collect();
        if !settled.is_empty() {
            let rms_m = (settled.iter().map(|m| m * m).sum::<f64>() / settled.len() as f64).sqrt();
            let worst_m = settled.iter().fold(0.0, |worst: f64, m| worst.max(m.abs()));
            parts.push(format!(
                "True cross-track error after settling: RMS {rms_m:.2} m, largest {worst_m:.2} m"
            ));
        }
        let swings = self.samples.iter().filter_map(|sample| self.swing_m(sample));
        if let Some(most_m) = swings.reduce(f64::max) {
            parts.push(format!("farthest outside a turn {:.2} m", most_m.max(0.0)));
        }
        let ranges: Vec<(f64, f64, bool)> =
            self.samples.iter().filter_map(|sample| self.range_m(sample)).collect();
        if !ranges.is_empty() {
            let share = |count: usize| 100.0 * count as f64 / ranges.len() as f64;
            let inside = share(ranges.iter().filter(|(range_m, radius_m, _)| range_m <= radius_m).count());
            let turning = share(ranges.iter().filter(|(_, _, motors)| *motors).count());
            let most_m = ranges.iter().fold(0.0, |most: f64, (range_m, ..)| most.max(*range_m));
            parts.push(format!(
                "True distance from the station: largest {most_m:.2} m, inside {inside:.1} % of the time, \
                 motors on {turning:.1} %"
            ));
        }
        parts.join("; ")
    }

    /// The motor effort of a run, in one line.
    fn effort(&self, activity_per_s: Option<f64>) -> String {
        let mut parts = Vec::new();
        if let Some((made_mps, planned_mps)) = self.mean_speed_mps() {
            parts
                .push(format!("Mean speed after settling {made_mps:.2} m/s of {planned_mps:.2} m/s planned"));
        }
        if let Some(activity_per_s) = activity_per_s {
            parts.push(activity(activity_per_s));
        }
        parts.join("; ")
    }

    /// The mean true speed of settled legs, and the mean of what was planned there (m/s).
    pub(crate) fn mean_speed_mps(&self) -> Option<(f64, f64)> {
        let settled = self.samples.iter().filter(|sample| self.settled(sample).is_some());
        let speeds: Vec<(f64, f64)> =
            settled.filter_map(|sample| Some((sample.speed_mps, self.planned_mps(sample)?))).collect();
        let count = speeds.len() as f64;
        let mean = |part: fn(&(f64, f64)) -> f64| speeds.iter().map(part).sum::<f64>() / count;
        (count > 0.0).then(|| (mean(|both| both.0), mean(|both| both.1)))
    }

    /// The speed of a leg (m/s).
    fn planned_mps(&self, sample: &Sample) -> Option<f64> {
        match self.stages.get(sample.stage)?.1 {
            Want::Leg { speed_mps, .. } => speed_mps,
            Want::Station { .. } | Want::Other => None,
        }
    }

    /// Where a maneuver ends.
    fn end(&self, stage: usize) -> Option<LocalPoint> {
        match self.stages.get(stage)?.1 {
            Want::Leg { to, .. } => Some(to),
            Want::Station { centre, .. } => Some(centre),
            Want::Other => None,
        }
    }

    fn leg(&self, stage: usize) -> Option<Leg> {
        let Want::Leg { to, .. } = self.stages.get(stage)?.1 else { return None };
        let from = match stage.checked_sub(1) {
            Some(before) => self.end(before)?,
            None => self.samples.first()?.at,
        };
        (from.distance_m(to) > 0.1).then_some(Leg { from, to })
    }

    /// The cross-track error where the vessel counts as settled.
    fn settled(&self, sample: &Sample) -> Option<f64> {
        let leg = self.leg(sample.stage)?;
        let (along_m, cross_m) = leg.measure(sample.at);
        let counts = along_m > SETTLED_AFTER_M && along_m < leg.length_m() - SETTLED_BEFORE_M;
        counts.then_some(cross_m)
    }

    /// How far it is on the outer side of a leg that began with a turn.
    fn swing_m(&self, sample: &Sample) -> Option<f64> {
        let (before, leg) = (self.leg(sample.stage.checked_sub(1)?)?, self.leg(sample.stage)?);
        let turn_rad = units::wrap_pi(leg.course_rad() - before.course_rad());
        let (_, cross_m) = leg.measure(sample.at);
        (turn_rad.abs() > TURN_RAD).then_some(-cross_m * turn_rad.signum())
    }

    /// Distance from the station, its radius, and whether the motors were on.
    fn range_m(&self, sample: &Sample) -> Option<(f64, f64, bool)> {
        let Want::Station { centre, radius_m } = self.stages.get(sample.stage)?.1 else { return None };
        Some((sample.at.distance_m(centre), radius_m, sample.turning))
    }

    fn error(&self) -> Curve {
        let cross_m = |sample: &Sample| Some(self.leg(sample.stage)?.measure(sample.at).1);
        Curve {
            title: "True cross-track error, + = starboard".to_owned(),
            unit: "error (m)".to_owned(),
            pieces: self.pieces(cross_m),
            shades: self.spans(|sample| self.settled(sample).is_some()),
            shade_title: "settled".to_owned(),
            ..Curve::default()
        }
    }

    fn distance(&self) -> Curve {
        Curve {
            title: "True distance from the station".to_owned(),
            unit: "distance (m)".to_owned(),
            pieces: self.pieces(|sample| Some(self.range_m(sample)?.0)),
            wanted: self.pieces(|sample| Some(self.range_m(sample)?.1)),
            wanted_title: "radius".to_owned(),
            ..Curve::default()
        }
    }

    fn speed(&self, on_station: bool) -> Curve {
        let turning = |sample: &Sample| on_station && sample.turning;
        Curve {
            title: "True speed over ground".to_owned(),
            unit: "speed (m/s)".to_owned(),
            pieces: self.pieces(|sample| Some(sample.speed_mps)),
            wanted: self.pieces(|sample| self.planned_mps(sample)),
            wanted_title: "planned".to_owned(),
            shades: self.spans(turning),
            shade_title: "motors on".to_owned(),
            ..Curve::default()
        }
    }

    fn actuation(&self) -> Curve {
        Curve {
            title: "Motor commands: port".to_owned(),
            unit: "full = 1".to_owned(),
            pieces: self.pieces(|sample| Some(sample.motors.port)),
            second: self.pieces(|sample| Some(sample.motors.starboard)),
            second_title: "starboard".to_owned(),
            ..Curve::default()
        }
    }

    /// A value over time, in a new piece after each gap and at each maneuver.
    fn pieces(&self, value: impl Fn(&Sample) -> Option<f64>) -> Vec<Vec<Point>> {
        let mut pieces: Vec<Vec<Point>> = Vec::new();
        let mut before = None;
        for sample in &self.samples {
            let found = value(sample);
            if let Some(value) = found {
                match pieces.last_mut().filter(|_| before == Some(sample.stage)) {
                    Some(piece) => piece.push((sample.time_s, value)),
                    None => pieces.push(vec![(sample.time_s, value)]),
                }
            }
            before = found.map(|_| sample.stage);
        }
        pieces
    }

    /// Times at which a condition holds.
    fn spans(&self, holds: impl Fn(&Sample) -> bool) -> Vec<Point> {
        let mut spans: Vec<Point> = Vec::new();
        let mut open = false;
        for sample in &self.samples {
            let held = holds(sample);
            match spans.last_mut().filter(|_| open) {
                Some(span) => span.1 = sample.time_s,
                None if held => spans.push((sample.time_s, sample.time_s + PERIOD_S)),
                None => {}
            }
            open = held;
        }
        spans
    }
}

impl Leg {
    fn length_m(self) -> f64 {
        self.from.distance_m(self.to)
    }

    fn course_rad(self) -> f64 {
        self.from.bearing_rad(self.to)
    }

    /// Metres along the leg, and to starboard of it.
    fn measure(self, at: LocalPoint) -> (f64, f64) {
        let (sin, cos) = self.course_rad().sin_cos();
        let (north_m, east_m) = (at.north_m - self.from.north_m, at.east_m - self.from.east_m);
        (north_m * cos + east_m * sin, east_m * cos - north_m * sin)
    }
}

fn want(data: &Message, frame: &LocalFrame) -> Want {
    let local = |lat, lon| LatLon::from_rad(lat, lon).ok().map(|place| frame.to_local(place));
    match data {
        Message::Goto(goto) => {
            let Goto { lat, lon, speed, speed_units, .. } = **goto;
            let speed_mps = (speed_units == SpeedUnits::MetersPs).then_some(f64::from(speed));
            local(lat, lon).map_or(Want::Other, |to| Want::Leg { to, speed_mps })
        }
        Message::StationKeeping(station) => {
            let StationKeeping { lat, lon, radius, .. } = **station;
            let radius_m = f64::from(radius);
            local(lat, lon).map_or(Want::Other, |centre| Want::Station { centre, radius_m })
        }
        _ => Want::Other,
    }
}

/// The motor activity in words.
pub(crate) fn activity(per_s: f64) -> String {
    format!("motor activity {per_s:.3} of full throttle a second")
}

/// A duration in words.
fn spoken(duration_s: f64) -> String {
    // At most a few days.
    let seconds = duration_s.round() as u64;
    match (seconds / 60, seconds % 60) {
        (0, seconds) => format!("{seconds} s"),
        (minutes, seconds) => format!("{minutes} min {seconds} s"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn at(north_m: f64, east_m: f64) -> LocalPoint {
        LocalPoint { north_m, east_m }
    }

    fn track(wants: &[Want]) -> Track {
        let stages = wants.iter().zip(1..).map(|(want, number)| (format!("{number}"), *want)).collect();
        Track {
            name: "test".to_owned(),
            stages,
            samples: Vec::new(),
            begun_s: None,
            motors: MotorPair::STOPPED,
            turned_since: false,
        }
    }

    #[test]
    fn errors_count_after_settling_and_swings_outside_turns() {
        let leg = |to| Want::Leg { to, speed_mps: Some(1.5) };
        let mut track = track(&[leg(at(100.0, 0.0)), leg(at(100.0, 100.0))]);
        for metre in 0..=100 {
            let cross_m = if metre <= 40 { 5.0 } else { 0.5 };
            let start = if metre == 0 { at(0.0, 0.0) } else { at(f64::from(metre), cross_m) };
            track.see(f64::from(metre), Some("1"), start, 1.0);
        }
        for metre in 0..=100 {
            // A turn to starboard swings out to the north, which is port of a leg to the east.
            let north_m = if metre == 10 { 103.0 } else { 99.5 };
            track.see(f64::from(101 + metre), Some("2"), at(north_m, f64::from(metre)), 1.0);
        }
        track.see(500.0, None, at(0.0, 0.0), 0.0);
        let figures = track.figures();
        assert!(figures.contains("RMS 0.50 m, largest 0.50 m"), "{figures}");
        assert!(figures.contains("outside a turn 3.00 m"), "{figures}");
        let plot = track.plot("calm", Some(0.4321));
        assert_eq!((plot.track.len(), plot.plan.len(), plot.curves[0].pieces.len()), (202, 3, 2));
        let effort = "Mean speed after settling 1.00 m/s of 1.50 m/s planned; motor activity 0.432 of full throttle a second";
        assert_eq!(plot.notes[1..], [effort, "calm"]);
        assert_eq!(plot.title, "Plan \"test\", 3 min 21 s");
        assert!(plot.to_svg().contains("RMS 0.50 m"));
    }

    #[test]
    fn stations_tell_distance_and_motors() {
        let mut track = track(&[Want::Station { centre: at(0.0, 0.0), radius_m: 10.0 }]);
        for second in 0..100 {
            let port = if second % 4 == 0 { 0.3 } else { 0.0 };
            track.command(MotorPair { port, starboard: -port });
            track.see(f64::from(second), Some("1"), at(0.0, if second < 25 { 11.0 } else { 9.0 }), 0.0);
        }
        let figures = track.figures();
        assert!(figures.contains("largest 11.00 m, inside 75.0 %"), "{figures}");
        // A motor that was on at the end of a period stays on in the next one until commanded otherwise.
        assert!(figures.contains("motors on 50.0 %"), "{figures}");
        let plot = track.plot("", None);
        assert_eq!((plot.curves[2].pieces[0][4].1, plot.curves[2].second[0][4].1), (0.3, -0.3));
        assert_eq!(plot.circles, [((0.0, 0.0), 10.0)]);
    }
}
