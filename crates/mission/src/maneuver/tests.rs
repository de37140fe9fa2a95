//! Tests of the maneuvers, each alone on a bench.

mod commanded;
mod pointwise;
mod stationary;

use super::{Context, Left, Maneuver, ManeuverConfig, Outcome, Running, Signal};
use crate::command::{Command, Path};
use crate::event::{Event, Fix, Medium, PathProgress};
use crate::place::RawPlace;
use crate::testing::{at, plan};
use guard::Waters;

/// A maneuver, its clock and the commands it gives.
struct Bench {
    running: Running,
    config: ManeuverConfig,
    waters: Waters,
    now_s: f64,
    fix: Option<Fix>,
    path_ref: u32,
    signals: Vec<Signal>,
    outcome: Option<Outcome>,
}

impl Bench {
    fn new(maneuver: Maneuver<RawPlace>) -> Self {
        let plan = plan(vec![maneuver]);
        Self {
            running: Running::new(plan.nodes()[0].maneuver()),
            config: ManeuverConfig::default(),
            waters: Waters::default(),
            now_s: 0.0,
            fix: None,
            path_ref: 0,
            signals: Vec::new(),
            outcome: None,
        }
    }

    fn with(&mut self, act: impl FnOnce(&mut Running, &mut Context<'_>)) -> Vec<Command> {
        let mut signals = Vec::new();
        let mut cx = Context {
            now: at(self.now_s),
            config: &self.config,
            fix: self.fix,
            medium: Medium::Unknown,
            waters: &self.waters,
            signals: &mut signals,
            path_ref: &mut self.path_ref,
            outcome: None,
        };
        act(&mut self.running, &mut cx);
        if let Some(outcome) = cx.outcome {
            assert_eq!(self.outcome.replace(outcome), None, "a maneuver ends once");
        }
        self.signals.clone_from(&signals);
        let command = |signal| if let Signal::Command(command) = signal { Some(command) } else { None };
        signals.into_iter().filter_map(command).collect()
    }

    fn start(&mut self) -> Vec<Command> {
        self.with(Running::start)
    }

    fn event(&mut self, event: &Event) -> Vec<Command> {
        self.with(|running, cx| running.event(cx, event))
    }

    fn fix(&mut self, fix: Fix) -> Vec<Command> {
        self.fix = Some(fix);
        self.event(&Event::Fix(fix))
    }

    fn near(&mut self) -> Vec<Command> {
        self.event(&crate::testing::near(self.path_ref))
    }

    fn loitering(&mut self) -> Vec<Command> {
        let progress = crate::testing::progress(self.path_ref, 0.0);
        self.event(&Event::Path(PathProgress { loitering: true, ..progress }))
    }

    /// Lets time pass to `seconds`, waking the maneuver as it wants.
    fn pass(&mut self, seconds: f64) -> Vec<Command> {
        let mut commands = Vec::new();
        while self.outcome.is_none() {
            match self.running.deadline() {
                Some(deadline) if deadline <= at(seconds).mono => {
                    self.now_s = self.now_s.max(deadline.micros() as f64 / 1e6);
                    commands.extend(self.with(Running::timeout));
                }
                _ => break,
            }
        }
        self.now_s = seconds;
        commands
    }

    fn left(&self) -> Option<Left> {
        self.running.left(at(self.now_s))
    }

    fn is_done(&self) -> bool {
        self.outcome == Some(Outcome::Done)
    }
}

/// The only command, which must be a path.
#[track_caller]
fn path(commands: &[Command]) -> Path {
    match commands {
        [Command::Follow(path)] => *path,
        other => panic!("one path expected, not {other:?}"),
    }
}
