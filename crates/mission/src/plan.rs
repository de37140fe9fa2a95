//! Plans: drafts as they arrive, and plans as checked values.
//!
//! A draft names its maneuvers and their order. [`Plan::build`] checks everything and reports all problems
//! at once; what it returns can be sailed. Only the first transition out of a maneuver counts, its conditions
//! do not ("when done" is the only one), and cycles are legal. Actions at the start and end of plans and
//! maneuvers are not kept here: the engine reports the place ([`ActionPoint`](crate::ActionPoint)), the caller
//! holds the actions, and reports by [`DraftNote`]s which of them, and of other parts of a plan that are not seen
//! here, cannot be carried out.

use crate::checks::Checks;
use crate::maneuver::{LoiterShape, Maneuver};
use crate::place::RawPlace;
use crate::plan_limits::PlanLimits;
use crate::problem::{PlanProblem, PlanProblems, PlanWarning, ProblemKind};
use std::collections::{BTreeMap, BTreeSet};

/// The destination of a transition that ends the plan.
pub const PLAN_END: &str = "_done_";

/// A plan as received.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlanDraft {
    /// Its name.
    pub id: String,
    /// Name of the first maneuver.
    pub start: String,
    /// The maneuvers.
    pub maneuvers: Vec<ManeuverDraft>,
    /// The transitions.
    pub transitions: Vec<TransitionDraft>,
    /// Notes of its maker about parts that a draft does not have.
    pub notes: Vec<DraftNote>,
}

/// A part of a plan that cannot be carried out, for its author.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DraftNote {
    /// Name of the maneuver; `None` for the plan itself.
    pub maneuver: Option<String>,
    /// Whether it makes the plan impossible rather than being left out with a warning.
    pub refuses: bool,
    /// What, and the remedy.
    pub text: String,
}

/// A maneuver of a draft.
#[derive(Debug, Clone, PartialEq)]
pub struct ManeuverDraft {
    /// Its name.
    pub id: String,
    /// How deep it wants to be (m), where it says so.
    pub depth_m: Option<f64>,
    /// What to do.
    pub body: DraftBody,
}

/// The contents of a draft's maneuver.
#[derive(Debug, Clone, PartialEq)]
pub enum DraftBody {
    /// A known maneuver.
    Maneuver(Maneuver<RawPlace>),
    /// Nothing.
    Missing,
    /// A maneuver of a kind that is not known here, by its name.
    Unsupported(String),
}

/// A transition of a draft.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TransitionDraft {
    /// Name of the maneuver that ends.
    pub from: String,
    /// Name of the maneuver that begins, or [`PLAN_END`].
    pub to: String,
}

/// A plan that can be sailed.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    id: String,
    nodes: Vec<Node>,
    start: usize,
    warnings: Vec<PlanWarning>,
}

/// A maneuver of a plan and what follows it.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    id: String,
    maneuver: Maneuver,
    next: Option<usize>,
}

impl Node {
    /// Its name.
    pub fn id(&self) -> &str {
        &self.id
    }

    /// What to do.
    pub fn maneuver(&self) -> &Maneuver {
        &self.maneuver
    }

    /// Index of the node that follows; `None` ends the plan.
    pub fn next(&self) -> Option<usize> {
        self.next
    }
}

impl Plan {
    /// Checks a draft.
    ///
    /// # Errors
    /// All that is wrong with it.
    pub fn build(draft: &PlanDraft, limits: &PlanLimits) -> Result<Self, PlanProblems> {
        let mut problems = Vec::new();
        let index = index(draft, limits, &mut problems);
        let start = index.get(draft.start.as_str()).copied();
        if start.is_none() && !draft.maneuvers.is_empty() {
            problems.push(PlanProblem::of_plan(ProblemKind::UnknownStart(draft.start.clone())));
        }
        let next = successors(draft, &index, &mut problems);
        check_entrances(draft, start, &mut problems);
        let maneuvers: Vec<Option<Maneuver>> =
            draft.maneuvers.iter().map(|maneuver| maneuver.check(limits, &mut problems)).collect();
        problems.extend(draft.notes.iter().filter(|note| note.refuses).map(|note| PlanProblem {
            maneuver: note.maneuver.clone(),
            kind: ProblemKind::Refused(note.text.clone()),
        }));
        let (Some(start), true) = (start, problems.is_empty()) else {
            return Err(PlanProblems(problems));
        };
        let nodes: Vec<Node> = draft
            .maneuvers
            .iter()
            .zip(maneuvers)
            .zip(next)
            .filter_map(|((draft, maneuver), next)| {
                Some(Node { id: draft.id.clone(), maneuver: maneuver?, next })
            })
            .collect();
        let mut plan = Self { id: draft.id.clone(), nodes, start, warnings: Vec::new() };
        plan.warnings = plan.find_warnings(draft);
        Ok(plan)
    }

    /// Its name.
    pub fn id(&self) -> &str {
        &self.id
    }

    /// All maneuvers, in the order of the draft.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The node at `index`.
    pub fn node(&self, index: usize) -> Option<&Node> {
        self.nodes.get(index)
    }

    /// Index of the first maneuver.
    pub fn start(&self) -> usize {
        self.start
    }

    /// Warnings for its author, though it can be sailed.
    pub fn warnings(&self) -> &[PlanWarning] {
        &self.warnings
    }

    /// Indices of the maneuvers in the order they are sailed, each once.
    pub fn order(&self) -> Vec<usize> {
        let mut seen = vec![false; self.nodes.len()];
        let mut order = Vec::new();
        let mut at = Some(self.start);
        while let Some(index) = at {
            match seen.get_mut(index) {
                Some(seen) if !*seen => *seen = true,
                _ => break,
            }
            order.push(index);
            at = self.nodes[index].next;
        }
        order
    }

    /// Whether it never ends on its own because its maneuvers follow each other in a circle.
    pub fn is_cyclic(&self) -> bool {
        self.order().last().is_some_and(|last| self.nodes[*last].next.is_some())
    }

    fn find_warnings(&self, draft: &PlanDraft) -> Vec<PlanWarning> {
        let order = self.order();
        let sailed: BTreeSet<usize> = order.iter().copied().collect();
        let mut warnings = Vec::new();
        if self.is_cyclic() {
            warnings.push(PlanWarning::Cycle);
        }
        let never = self.nodes.iter().enumerate().filter(|(index, _)| !sailed.contains(index));
        warnings.extend(never.map(|(_, node)| PlanWarning::NeverReached(node.id.clone())));
        let mut sources = BTreeSet::new();
        for transition in &draft.transitions {
            if !sources.insert(transition.from.as_str()) {
                warnings.push(PlanWarning::TransitionIgnored {
                    from: transition.from.clone(),
                    to: transition.to.clone(),
                });
            }
        }
        warnings.extend(
            draft.notes.iter().map(|note| PlanWarning::Unheeded {
                maneuver: note.maneuver.clone(),
                text: note.text.clone(),
            }),
        );
        for node in &self.nodes {
            match &node.maneuver {
                Maneuver::Loiter(loiter) if matches!(loiter.shape, LoiterShape::Other(_)) => {
                    warnings.push(PlanWarning::CircleInstead(node.id.clone()));
                }
                Maneuver::FollowPath(path) if path.points.is_empty() => {
                    warnings.push(PlanWarning::NoPoints(node.id.clone()));
                }
                Maneuver::FollowTrajectory(trajectory) if trajectory.points.is_empty() => {
                    warnings.push(PlanWarning::NoPoints(node.id.clone()));
                }
                _ => {}
            }
        }
        warnings
    }
}

/// The index of each name; reports what is wrong with the names.
fn index<'a>(
    draft: &'a PlanDraft,
    limits: &PlanLimits,
    problems: &mut Vec<PlanProblem>,
) -> BTreeMap<&'a str, usize> {
    if draft.id.is_empty() {
        problems.push(PlanProblem::of_plan(ProblemKind::NoPlanId));
    }
    if draft.maneuvers.is_empty() {
        problems.push(PlanProblem::of_plan(ProblemKind::Empty));
    }
    let (count, limit) = (draft.maneuvers.len(), limits.max_maneuvers);
    if count > limit {
        problems.push(PlanProblem::of_plan(ProblemKind::TooManyManeuvers { count, limit }));
    }
    let mut index = BTreeMap::new();
    for (at, maneuver) in draft.maneuvers.iter().enumerate() {
        if maneuver.id.is_empty() || maneuver.id == PLAN_END {
            problems.push(PlanProblem::of(&maneuver.id, ProblemKind::BadId));
        }
        if index.contains_key(maneuver.id.as_str()) {
            problems.push(PlanProblem::of(&maneuver.id, ProblemKind::DuplicateId));
        } else {
            index.insert(maneuver.id.as_str(), at);
        }
    }
    index
}

/// The successor of each maneuver: its first transition.
fn successors(
    draft: &PlanDraft,
    index: &BTreeMap<&str, usize>,
    problems: &mut Vec<PlanProblem>,
) -> Vec<Option<usize>> {
    let mut next = vec![None; draft.maneuvers.len()];
    let mut decided = vec![false; draft.maneuvers.len()];
    for transition in &draft.transitions {
        let from = index.get(transition.from.as_str()).copied();
        let to = index.get(transition.to.as_str()).copied();
        if from.is_none() {
            problems.push(PlanProblem::of_plan(ProblemKind::TransitionFrom(transition.from.clone())));
        }
        if to.is_none() && transition.to != PLAN_END {
            problems
                .push(PlanProblem::of(&transition.from, ProblemKind::TransitionTo(transition.to.clone())));
        }
        if let Some(from) = from
            && !decided[from]
        {
            decided[from] = true;
            next[from] = to;
        }
    }
    next
}

/// Every maneuver but the first must be where some transition leads.
fn check_entrances(draft: &PlanDraft, start: Option<usize>, problems: &mut Vec<PlanProblem>) {
    let entered: BTreeSet<&str> = draft.transitions.iter().map(|transition| transition.to.as_str()).collect();
    for (at, maneuver) in draft.maneuvers.iter().enumerate() {
        if Some(at) != start && !entered.contains(maneuver.id.as_str()) {
            problems.push(PlanProblem::of(&maneuver.id, ProblemKind::Unreachable));
        }
    }
}

impl ManeuverDraft {
    fn check(&self, limits: &PlanLimits, problems: &mut Vec<PlanProblem>) -> Option<Maneuver> {
        let mut checks = Checks::new(limits, &self.id, problems);
        if let Some(depth_m) = self.depth_m {
            checks.depth(depth_m);
        }
        match &self.body {
            DraftBody::Maneuver(maneuver) if limits.refused.contains(&maneuver.kind()) => {
                checks.problem(ProblemKind::Unsupported(maneuver.kind().to_string()));
                None
            }
            DraftBody::Maneuver(maneuver) => {
                let maneuver = maneuver.check(&mut checks)?;
                // Only the places of a good maneuver are few.
                if checks.are_passed() {
                    checks.area(&maneuver.places());
                }
                Some(maneuver)
            }
            DraftBody::Missing => {
                checks.problem(ProblemKind::NoManeuver);
                None
            }
            DraftBody::Unsupported(name) => {
                checks.problem(ProblemKind::Unsupported(name.clone()));
                None
            }
        }
    }
}

impl Maneuver<RawPlace> {
    fn check(&self, checks: &mut Checks<'_>) -> Option<Maneuver> {
        Some(match self {
            Self::Goto(goto) => Maneuver::Goto(goto.check(checks)?),
            Self::Launch(launch) => Maneuver::Launch(launch.check(checks)?),
            Self::Loiter(loiter) => Maneuver::Loiter(loiter.check(checks)?),
            Self::StationKeeping(station) => Maneuver::StationKeeping(station.check(checks)?),
            Self::FollowPath(path) => Maneuver::FollowPath(path.check(checks)?),
            Self::FollowTrajectory(trajectory) => Maneuver::FollowTrajectory(trajectory.check(checks)?),
            Self::Rows(rows) => Maneuver::Rows(rows.check(checks)?),
            Self::RowsCoverage(rows) => Maneuver::RowsCoverage(rows.check(checks)?),
            Self::Idle(idle) => Maneuver::Idle(*idle),
            Self::ScheduledGoto(goto) => Maneuver::ScheduledGoto(goto.check(checks)?),
            Self::FollowReference(follow) => {
                follow.check(checks);
                Maneuver::FollowReference(*follow)
            }
            Self::FollowSystem(follow) => {
                follow.check(checks);
                Maneuver::FollowSystem(*follow)
            }
            Self::Teleoperation(teleoperation) => Maneuver::Teleoperation(*teleoperation),
        })
    }
}

#[cfg(test)]
mod tests;
