//! Lost communications: what the vessel does when no console ashore has been heard for a while.
//!
//! It acts whatever the vessel is doing, plans and teleoperation included: for each activity there is a ladder
//! of steps, each at a time after the last contact. An empty ladder means to carry on. A step that has been
//! taken stays in force until an operator steps in; renewed contact only resets the ladder.
//! DUNE's supervisor acts only on an idle vessel whose last plan failed; these preconditions are left out.

use super::{Outlook, Remedy};
use std::collections::VecDeque;
use std::time::Duration;
use units::MonoTime;

/// A step of a ladder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Step {
    /// How long after the last contact.
    pub after: Duration,
    /// What to do.
    pub remedy: Remedy,
}

/// Parameters: one ladder per activity, in any order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LostCommsConfig {
    /// While nothing runs.
    pub idle: Vec<Step>,
    /// While a plan runs.
    pub plan: Vec<Step>,
    /// While an operator steers.
    pub teleoperation: Vec<Step>,
    /// Whether to act even before the first contact, the time then counting from the start: right for a
    /// vessel that may restart at sea, wrong on the quay.
    pub before_first_contact: bool,
    /// Silence after which communications count as lost, also where the ladder is empty.
    pub lost_after: Duration,
}

impl Default for LostCommsConfig {
    /// Plans carry on; an idle or steered vessel holds station after 30 s and comes home after 5 min.
    fn default() -> Self {
        let ladder = vec![
            Step { after: Duration::from_secs(30), remedy: Remedy::Hold },
            Step { after: Duration::from_mins(5), remedy: Remedy::Run { plan_id: "lost_comms".to_owned() } },
        ];
        Self {
            idle: ladder.clone(),
            plan: Vec::new(),
            teleoperation: ladder,
            before_first_contact: false,
            lost_after: Duration::from_mins(5),
        }
    }
}

/// The vessel's activity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum Activity {
    /// Nothing.
    #[default]
    Idle,
    /// An operator's plan.
    Plan,
    /// Follow an operator.
    Teleoperation,
    /// Carry out a remedy, of this or another supervisor.
    Remedy,
}

/// The machine's input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LostCommsInput {
    /// A console was heard.
    Contact,
    /// The vessel's activity changed.
    Activity(Activity),
}

/// The machine's output.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LostCommsOutput {
    /// Communications are lost: do this.
    Act(Remedy),
    /// Contact is back after a remedy.
    Regained,
}

/// The machine.
#[derive(Debug, Clone)]
pub struct LostComms {
    config: LostCommsConfig,
    /// The activity whose ladder counts: the last one that was not a remedy.
    activity: Activity,
    /// Last contact, or the start.
    since: MonoTime,
    heard: bool,
    /// It acts also before the first contact.
    armed: bool,
    /// Steps up to this are taken.
    taken: Option<Duration>,
    outputs: VecDeque<LostCommsOutput>,
}

impl LostComms {
    /// A machine that starts at `now`.
    pub fn new(now: MonoTime, config: LostCommsConfig) -> Self {
        Self {
            config,
            activity: Activity::Idle,
            since: now,
            heard: false,
            armed: false,
            taken: None,
            outputs: VecDeque::new(),
        }
    }

    /// New parameters.
    pub fn reconfigure(&mut self, config: LostCommsConfig) {
        self.config = config;
    }

    /// Acts from here on even before the first contact, the time counting from the start: the vessel is at sea.
    pub fn arm(&mut self) {
        self.armed = true;
    }

    /// Takes an input.
    pub fn handle_input(&mut self, now: MonoTime, input: LostCommsInput) {
        match input {
            LostCommsInput::Contact => {
                if self.taken.take().is_some() {
                    self.outputs.push_back(LostCommsOutput::Regained);
                }
                (self.since, self.heard) = (now, true);
            }
            LostCommsInput::Activity(Activity::Remedy) => {}
            LostCommsInput::Activity(activity) => self.activity = activity,
        }
        self.handle_timeout(now);
    }

    /// The time of [`LostComms::poll_timeout`] came.
    pub fn handle_timeout(&mut self, now: MonoTime) {
        let silent = now.since(self.since);
        let due = self.pending().filter(|step| step.after <= silent).max_by_key(|step| step.after).cloned();
        if let Some(step) = due {
            self.taken = Some(step.after);
            self.outputs.push_back(LostCommsOutput::Act(step.remedy));
        }
    }

    /// The next output.
    pub fn poll_output(&mut self) -> Option<LostCommsOutput> {
        self.outputs.pop_front()
    }

    /// When the machine wants to be woken.
    pub fn poll_timeout(&self) -> Option<MonoTime> {
        self.next().map(|step| self.since + step.after)
    }

    /// Whether a step has been taken, without contact since.
    pub fn is_lost(&self) -> bool {
        self.taken.is_some()
    }

    /// Time since the last contact; where it acts before the first contact, time since the start.
    pub fn silence(&self, now: MonoTime) -> Option<Duration> {
        self.acts().then(|| now.since(self.since))
    }

    /// Whether there was contact since the start.
    pub fn has_heard(&self) -> bool {
        self.heard
    }

    /// Whether the silence is too long, whether a step follows from it or not.
    pub fn is_silent(&self, now: MonoTime) -> bool {
        self.silence(now).is_some_and(|silence| silence >= self.config.lost_after)
    }

    /// What it will do next if the silence continues.
    pub fn outlook(&self) -> Option<Outlook> {
        let step = self.next()?;
        Some(Outlook { remedy: step.remedy.clone(), at: Some(self.since + step.after) })
    }

    fn acts(&self) -> bool {
        self.heard || self.armed || self.config.before_first_contact
    }

    fn next(&self) -> Option<&Step> {
        self.pending().min_by_key(|step| step.after)
    }

    fn pending(&self) -> impl Iterator<Item = &Step> {
        let ladder = match self.activity {
            Activity::Plan => &self.config.plan,
            Activity::Teleoperation => &self.config.teleoperation,
            Activity::Idle | Activity::Remedy => &self.config.idle,
        };
        let acts = self.acts();
        ladder.iter().filter(move |step| acts && self.taken.is_none_or(|taken| step.after > taken))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(seconds: u64) -> MonoTime {
        MonoTime::from_micros(seconds * 1_000_000)
    }

    fn home() -> Remedy {
        Remedy::Run { plan_id: "lost_comms".to_owned() }
    }

    fn heard_at_100(activity: Activity) -> LostComms {
        let mut machine = LostComms::new(at(0), LostCommsConfig::default());
        machine.handle_input(at(100), LostCommsInput::Contact);
        machine.handle_input(at(100), LostCommsInput::Activity(activity));
        machine
    }

    #[test]
    fn climbs_the_ladder_while_nobody_is_heard() {
        let mut machine = heard_at_100(Activity::Teleoperation);
        assert_eq!(machine.outlook(), Some(Outlook { remedy: Remedy::Hold, at: Some(at(130)) }));
        machine.handle_timeout(at(129));
        assert_eq!(machine.poll_output(), None);
        machine.handle_timeout(at(130));
        assert_eq!(machine.poll_output(), Some(LostCommsOutput::Act(Remedy::Hold)));
        machine.handle_input(at(131), LostCommsInput::Activity(Activity::Remedy));
        assert_eq!(machine.outlook(), Some(Outlook { remedy: home(), at: Some(at(400)) }));
        machine.handle_timeout(at(400));
        assert_eq!(machine.poll_output(), Some(LostCommsOutput::Act(home())));
        assert_eq!((machine.poll_timeout(), machine.is_lost()), (None, true));
    }

    #[test]
    fn a_long_silence_is_one_although_nothing_is_done_about_it() {
        let mut machine = heard_at_100(Activity::Plan);
        machine.handle_timeout(at(399));
        assert!(!machine.is_silent(at(399)) && machine.is_silent(at(400)) && !machine.is_lost());
        machine.handle_input(at(401), LostCommsInput::Contact);
        assert_eq!(
            (machine.silence(at(403)), machine.is_silent(at(403))),
            (Some(Duration::from_secs(2)), false)
        );
    }

    #[test]
    fn carries_on_with_a_plan_and_acts_when_it_is_over() {
        let mut machine = heard_at_100(Activity::Plan);
        machine.handle_timeout(at(5_000));
        assert_eq!((machine.poll_output(), machine.outlook()), (None, None));
        machine.handle_input(at(5_001), LostCommsInput::Activity(Activity::Idle));
        assert_eq!(machine.poll_output(), Some(LostCommsOutput::Act(home())));
        assert_eq!(machine.poll_output(), None);
    }

    #[test]
    fn winds_back_when_somebody_is_heard() {
        let mut machine = heard_at_100(Activity::Idle);
        machine.handle_timeout(at(131));
        machine.handle_input(at(140), LostCommsInput::Contact);
        assert_eq!(machine.poll_output(), Some(LostCommsOutput::Act(Remedy::Hold)));
        assert_eq!(machine.poll_output(), Some(LostCommsOutput::Regained));
        assert_eq!(machine.poll_timeout(), Some(at(170)));
    }

    #[test]
    fn does_nothing_before_the_first_contact_unless_told_so() {
        let mut machine = LostComms::new(at(0), LostCommsConfig::default());
        machine.handle_timeout(at(10_000));
        assert_eq!((machine.poll_output(), machine.poll_timeout()), (None, None));
        let config = LostCommsConfig { before_first_contact: true, ..LostCommsConfig::default() };
        machine.reconfigure(config);
        machine.handle_timeout(at(10_001));
        assert_eq!(machine.poll_output(), Some(LostCommsOutput::Act(home())));
    }
}
