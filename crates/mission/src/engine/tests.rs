//! Tests of the engine.

mod modes;
mod plans;
mod random;

use super::*;
use crate::maneuver::{Maneuver, Teleoperation};
use crate::place::RawPlace;
use crate::testing::{at, fix, near, plan};

/// An engine, its clock, and everything it has put out since last asked.
struct Bench {
    engine: Engine,
    now_s: f64,
    told: Vec<Output>,
    requests: u16,
}

impl Bench {
    /// A vehicle in service.
    fn new() -> Self {
        let config = EngineConfig { vital: BTreeSet::from(["motor".to_owned()]), ..EngineConfig::default() };
        let mut bench = Self { engine: Engine::new(config), now_s: 0.0, told: Vec::new(), requests: 0 };
        bench.entities(&[]);
        bench.input(Input::Event(Event::Fix(fix(0.0, 0.0))));
        bench.told.clear();
        bench
    }

    fn input(&mut self, input: Input) {
        self.engine.handle_input(at(self.now_s), input);
        self.told.extend(std::iter::from_fn(|| self.engine.poll_output()));
    }

    fn ask(&mut self, plan_id: &str, ask: RequestKind) -> Origin {
        self.requests += 1;
        let origin = Origin { system: 0x4001, entity: 9, request: self.requests };
        self.input(Input::Request(Request { origin, plan_id: plan_id.to_owned(), ask }));
        origin
    }

    fn start(&mut self, plan_id: &str, maneuvers: Vec<Maneuver<RawPlace>>) -> Origin {
        self.start_with(plan_id, maneuvers, StartOptions::default())
    }

    fn start_with(
        &mut self,
        plan_id: &str,
        maneuvers: Vec<Maneuver<RawPlace>>,
        options: StartOptions,
    ) -> Origin {
        self.ask(plan_id, RequestKind::Start { plan: Ok(Box::new(plan(maneuvers))), options })
    }

    /// The path under way comes near.
    fn near(&mut self) {
        let path_ref = self.engine.path_ref;
        self.input(Input::Event(near(path_ref)));
    }

    fn entities(&mut self, bad: &[(&str, EntityCondition)]) {
        let mut conditions: BTreeMap<String, EntityCondition> =
            ["motor", "gps"].map(|label| (label.to_owned(), EntityCondition::Normal)).into();
        conditions.extend(bad.iter().map(|(label, condition)| ((*label).to_owned(), *condition)));
        self.input(Input::Entities(conditions));
    }

    fn pass(&mut self, seconds: f64) {
        while let Some(deadline) = self.engine.poll_timeout().filter(|at_| *at_ <= at(seconds).mono) {
            self.now_s = self.now_s.max(deadline.micros() as f64 / 1e6);
            self.engine.handle_timeout(at(self.now_s));
            self.told.extend(std::iter::from_fn(|| self.engine.poll_output()));
        }
        self.now_s = seconds;
    }

    /// Texts of the replies since last asked, with the number of their request.
    fn replies(&mut self) -> Vec<(u16, bool, String)> {
        let told = std::mem::take(&mut self.told);
        told.into_iter()
            .filter_map(|output| match output {
                Output::Reply(reply) => Some((
                    reply.origin.request,
                    reply.result.is_ok(),
                    reply.result.map_or_else(|failure| failure.to_string(), |success| success.to_string()),
                )),
                _ => None,
            })
            .collect()
    }

    fn last_command(&self) -> Option<Command> {
        self.told.iter().rev().find_map(|output| match output {
            Output::Command(command) => Some(*command),
            _ => None,
        })
    }

    fn phase(&mut self) -> PlanPhase {
        self.engine.plan_state(at(self.now_s)).phase
    }

    fn outcome(&mut self) -> LastOutcome {
        self.engine.plan_state(at(self.now_s)).last_outcome
    }

    fn mode(&mut self) -> Mode {
        self.engine.vehicle_state(at(self.now_s)).mode
    }
}

fn teleoperation() -> Maneuver<RawPlace> {
    Maneuver::Teleoperation(Teleoperation { operator: crate::command::Operator::Anyone })
}
