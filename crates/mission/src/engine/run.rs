//! The life of a started plan: begin, maneuver after maneuver, one end.

use super::{
    ActionPoint, EndReason, Engine, Failure, ManeuverEnd, Mode, NoPlan, NoteLevel, Operation, Origin, Output,
    Reply, Request, RequestKind, RunId, StartOptions, Success,
};
use crate::command::{Command, Drive};
use crate::maneuver::{Outcome, Running};
use crate::plan::{Node, Plan};
use crate::statistics::{Progress, Standing};
use units::{MonoTime, Now, UtcTime};

/// Warnings of a plan that are reported one by one; the others are counted.
const WARNINGS_TOLD: usize = 20;

#[derive(Debug, Clone)]
pub(super) struct Run {
    pub(super) id: RunId,
    pub(super) plan_id: String,
    origin: Origin,
    pub(super) options: StartOptions,
    pub(super) plan: Plan,
    /// Index of the maneuver under way, and its machine; none while calibrating.
    node: Option<usize>,
    pub(super) running: Option<Running>,
    /// How the maneuver under way ended.
    pub(super) outcome: Option<Outcome>,
    pub(super) maneuver_began: Option<UtcTime>,
    pub(super) calibrating_until: Option<MonoTime>,
    /// When path control last spoke of the path under way.
    pub(super) path_heard: Option<MonoTime>,
    progress: Progress,
}

impl Run {
    pub(super) fn maneuver(&self) -> Option<&Node> {
        self.plan.node(self.node?)
    }

    pub(super) fn maneuver_deadline(&self) -> Option<MonoTime> {
        self.running.as_ref()?.deadline()
    }

    pub(super) fn standing(&mut self, now: Now) -> Standing {
        let left = self.running.as_ref().and_then(|running| running.left(now));
        self.progress.standing(now, left)
    }
}

impl Engine {
    pub(super) fn request(&mut self, now: Now, request: Request) {
        let Request { origin, plan_id, ask } = request;
        let (operation, result) = match ask {
            RequestKind::Start { plan, options } => {
                let result = self.start(now, origin, &plan_id, plan, options);
                let Err(failure) = result else { return };
                self.note(NoteLevel::Error, format!("{plan_id}: {failure}"));
                (Operation::Start, Err(failure))
            }
            RequestKind::Stop if self.run.is_some() => {
                self.reply(origin, Operation::Stop, &plan_id, Ok(Success::Stopped));
                self.end_run(now, EndReason::Stopped);
                return;
            }
            RequestKind::Stop => (Operation::Stop, Err(Failure::NothingToStop)),
            RequestKind::Load { .. } if self.run.is_some() => (Operation::Load, Err(Failure::Busy)),
            RequestKind::Load { plan: Ok(plan) } => {
                self.warn(&plan_id, &plan);
                (Operation::Load, Ok(Success::Loaded(Box::new(self.statistics(now, &plan)))))
            }
            RequestKind::Load { plan: Err(no_plan) } => (Operation::Load, Err(no_plan.into())),
            RequestKind::Get => {
                let run = self.run.as_ref().map(|run| (run.id, run.plan_id.clone()));
                let Some((run, running_id)) = run else {
                    self.reply(origin, Operation::Get, &plan_id, Err(Failure::NothingRuns));
                    return;
                };
                self.reply(origin, Operation::Get, &running_id, Ok(Success::Running(run)));
                return;
            }
        };
        self.reply(origin, operation, &plan_id, result);
    }

    fn reply(
        &mut self,
        origin: Origin,
        operation: Operation,
        plan_id: &str,
        result: Result<Success, Failure>,
    ) {
        let plan_id = plan_id.to_owned();
        self.outputs.push_back(Output::Reply(Reply { origin, operation, plan_id, result }));
    }

    fn start(
        &mut self,
        now: Now,
        origin: Origin,
        plan_id: &str,
        plan: Result<Box<Plan>, NoPlan>,
        options: StartOptions,
    ) -> Result<(), Failure> {
        let plan = match plan {
            Ok(plan) => *plan,
            Err(no_plan) => {
                if self.run.is_none() {
                    self.last_outcome = super::LastOutcome::Failure;
                    self.tell_plan(now);
                }
                return Err(no_plan.into());
            }
        };
        if let Some(why) = self.vehicle.blocks(options.ignore_errors) {
            return Err(Failure::Blocked(why));
        }
        self.note(NoteLevel::Info, format!("{plan_id}: plan initializing"));
        if self.run.is_some() {
            self.end_run(now, EndReason::Replaced);
        }
        self.initializing = true;
        self.tell_plan(now);
        self.initializing = false;
        let statistics = Box::new(self.statistics(now, &plan));
        self.reply(origin, Operation::Start, plan_id, Ok(Success::Loaded(statistics)));
        self.begin_run(now, origin, plan_id, plan, options);
        Ok(())
    }

    fn begin_run(&mut self, now: Now, origin: Origin, plan_id: &str, plan: Plan, options: StartOptions) {
        self.last_run = RunId(self.last_run.0.wrapping_add(1));
        let run = self.last_run;
        self.warn(plan_id, &plan);
        let calibration = self.config.calibration.filter(|_| options.calibrate);
        let here = self.fix.map(|(_, fix)| fix.place);
        self.vehicle.set_last_error(None);
        self.run = Some(Run {
            id: run,
            plan_id: plan_id.to_owned(),
            origin,
            options,
            progress: Progress::new(&plan, here, now, &self.config.model),
            plan,
            node: None,
            running: None,
            outcome: None,
            maneuver_began: None,
            calibrating_until: calibration.map(|calibration| now.mono + calibration),
            path_heard: None,
        });
        self.outputs.push_back(Output::PlanBegins { run, plan_id: plan_id.to_owned() });
        self.outputs.push_back(Output::Actions { run, point: ActionPoint::PlanStart });
        if let Some(calibration) = calibration {
            if self.drive != Drive::Off {
                self.command(now, Command::Drift);
            }
            self.vehicle.set_mode(Mode::Calibration);
            self.outputs.push_back(Output::Calibrate(calibration));
            self.tell_vehicle(now);
            self.tell_plan(now);
        } else {
            self.begin_first(now);
            if let Some(maneuver) = self.run.as_ref().and_then(Run::maneuver).map(|node| node.id().to_owned())
            {
                self.reply(origin, Operation::Start, plan_id, Ok(Success::Executing { maneuver }));
            }
            self.go_on(now);
        }
    }

    /// Reports what the author of a plan may not have meant.
    fn warn(&mut self, plan_id: &str, plan: &Plan) {
        for warning in plan.warnings().iter().take(WARNINGS_TOLD) {
            self.note(NoteLevel::Warning, format!("{plan_id}: {warning}"));
        }
        let more = plan.warnings().len().saturating_sub(WARNINGS_TOLD);
        if more > 0 {
            self.note(NoteLevel::Warning, format!("{plan_id}: and {more} warnings more"));
        }
    }

    pub(super) fn calibrated(&mut self, now: Now) {
        if let Some(run) = &mut self.run {
            run.calibrating_until = None;
        }
        self.begin_first(now);
        self.go_on(now);
    }

    fn begin_first(&mut self, now: Now) {
        if let Some(first) = self.run.as_ref().map(|run| run.plan.start()) {
            self.begin_maneuver(now, first);
        }
    }

    fn begin_maneuver(&mut self, now: Now, index: usize) {
        let Some(run) = &mut self.run else { return };
        let Some(node) = run.plan.node(index) else { return };
        let (id, kind) = (node.id().to_owned(), node.maneuver().kind());
        run.running = Some(Running::new(node.maneuver()));
        (run.node, run.outcome, run.maneuver_began) = (Some(index), None, Some(now.utc));
        run.progress.begin(index);
        let run = run.id;
        self.vehicle.set_mode(Mode::Maneuver);
        self.outputs.push_back(Output::Actions { run, point: ActionPoint::ManeuverStart(id.clone()) });
        self.outputs.push_back(Output::ManeuverBegins { run, id, kind });
        self.with_maneuver(now, Running::start);
        self.tell_vehicle(now);
        self.tell_plan(now);
    }

    /// As long as the active maneuver has ended, begins the next or ends the plan.
    pub(super) fn go_on(&mut self, now: Now) {
        let mut at_once = 0;
        while let Some(run) = &self.run {
            let Some(outcome) = &run.outcome else { return };
            if let Outcome::Failed(reason) = outcome {
                let maneuver = run.maneuver().map_or_else(String::new, |node| node.id().to_owned());
                let reason = reason.clone();
                self.end_run(now, EndReason::Maneuver { maneuver, reason });
                return;
            }
            // More ends in a row than there are maneuvers: a circle of maneuvers that take no time.
            if at_once > run.plan.nodes().len() {
                self.end_run(now, EndReason::EmptyCycle);
                return;
            }
            at_once += 1;
            self.follow_on(now);
        }
    }

    /// The active maneuver is done: what follows it.
    fn follow_on(&mut self, now: Now) {
        let Some(run) = &self.run else { return };
        let id = run.id;
        let Some(node) = run.maneuver() else { return };
        let from = node.id().to_owned();
        let next = node.next().and_then(|next| Some((next, run.plan.node(next)?.id().to_owned())));
        match next {
            Some((next, to)) => {
                self.tell_vehicle(now);
                self.leave_maneuver(ManeuverEnd::Done);
                let point = ActionPoint::Transition { from, to };
                self.outputs.push_back(Output::Actions { run: id, point });
                self.begin_maneuver(now, next);
            }
            None => self.end_run(now, EndReason::Completed),
        }
    }

    fn leave_maneuver(&mut self, end: ManeuverEnd) {
        let Some(run) = &mut self.run else { return };
        run.running = None;
        let Some(id) = run.maneuver().map(|node| node.id().to_owned()) else { return };
        let run = run.id;
        self.outputs.push_back(Output::ManeuverEnded { run, id: id.clone(), end });
        self.outputs.push_back(Output::Actions { run, point: ActionPoint::ManeuverEnd(id) });
    }

    /// Ends the running plan; loops go off, unless another plan takes them over.
    pub(super) fn end_run(&mut self, now: Now, reason: EndReason) {
        self.leave_maneuver(match &reason {
            EndReason::Completed | EndReason::EmptyCycle => ManeuverEnd::Done,
            EndReason::Maneuver { reason, .. } => ManeuverEnd::Failed(reason.to_string()),
            EndReason::Stopped
            | EndReason::Replaced
            | EndReason::Entities(_)
            | EndReason::PositionLost
            | EndReason::Aborted(_) => ManeuverEnd::Stopped,
        });
        let Some(run) = self.run.take() else { return };
        if reason != EndReason::Replaced {
            self.command(now, Command::Drift);
        }
        self.outputs.push_back(Output::Actions { run: run.id, point: ActionPoint::PlanEnd });
        self.last_outcome = reason.outcome();
        self.last_plan_id.clone_from(&run.plan_id);
        if let (EndReason::Maneuver { reason, .. }, Some(node)) = (&reason, run.maneuver()) {
            let text = format!("{} maneuver error: {reason}", node.maneuver().kind());
            self.vehicle.set_last_error(Some((text, now.utc)));
        }
        self.vehicle.set_mode(self.vehicle.rest_mode());
        let level = if reason == EndReason::Completed { NoteLevel::Info } else { NoteLevel::Warning };
        self.note(level, format!("{}: {reason}", run.plan_id));
        self.outputs.push_back(Output::PlanEnded {
            run: run.id,
            plan_id: run.plan_id.clone(),
            reason: reason.clone(),
        });
        // A replaced plan leaves no gap to report: the next one follows at once.
        let over = reason != EndReason::Replaced;
        match reason {
            EndReason::Stopped | EndReason::Replaced => {}
            EndReason::Completed => {
                self.reply(run.origin, Operation::Start, &run.plan_id, Ok(Success::Completed));
            }
            reason => self.reply(run.origin, Operation::Start, &run.plan_id, Err(Failure::Ended(reason))),
        }
        if over {
            self.tell_vehicle(now);
            self.tell_plan(now);
        }
    }
}
