//! Which messages are due: a function of the rules, the active alarms and the messages sent before.

use super::content::{Content, What};
use super::rule::Rule;
use crate::identity::Grants;
use operations::alarms::Priority;
use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;
use units::UtcTime;

/// A rule with its owner's permissions.
#[derive(Debug, Clone)]
pub(super) struct Held {
    pub(super) rule: Rule,
    pub(super) grants: Grants,
}

/// A recurring alarm is reported again after this time at the earliest, if it is active then.
const AGAIN: Duration = Duration::from_mins(10);

/// Messages and alarms reported so far.
#[derive(Debug, Clone, Default)]
pub(super) struct Notified {
    /// By rule and alarm.
    messages: BTreeSet<(i64, u64, What)>,
    /// When a rule last reported such an alarm (by vessel, kind and part), µs since 1970 UTC.
    latest: BTreeMap<(i64, Option<u16>, String, String), i64>,
    /// Reported alarms, in their last known state.
    alarms: BTreeMap<u64, api::Alarm>,
}

impl Notified {
    /// Notes a message that has been stored.
    pub(super) fn keep(&mut self, rule: i64, content: &Content) {
        let Some(alarm) = &content.alarm else { return };
        self.messages.insert((rule, alarm.id, content.event));
        let latest = self.latest.entry(like(rule, alarm)).or_default();
        *latest = content.time_us.max(*latest);
        self.alarms.insert(alarm.id, alarm.clone());
    }

    /// Forgets alarms that are over and have no more messages due.
    pub(super) fn forget(&mut self, rules: &[Held], standing: &[api::Alarm], now: UtcTime) {
        let kept = |rule: i64| rules.iter().find(|held| held.rule.id == rule);
        let open = |alarm: u64| standing.iter().any(|one| one.id == alarm);
        let ended: BTreeSet<(i64, u64)> = self
            .messages
            .iter()
            .filter(|(rule, alarm, _)| {
                let waits = kept(*rule).is_some_and(|held| {
                    held.rule.ask.also_over && !self.messages.contains(&(*rule, *alarm, What::Over))
                });
                !open(*alarm) && !waits
            })
            .map(|(rule, alarm, _)| (*rule, *alarm))
            .collect();
        self.messages.retain(|(rule, alarm, _)| !ended.contains(&(*rule, *alarm)));
        self.alarms.retain(|id, _| self.messages.iter().any(|(_, alarm, _)| alarm == id));
        self.latest.retain(|(rule, ..), at_us| kept(*rule).is_some() && recent(*at_us, now));
    }

    fn is_told(&self, rule: i64, alarm: u64, what: What) -> bool {
        self.messages.contains(&(rule, alarm, what))
    }
}

fn like(rule: i64, alarm: &api::Alarm) -> (i64, Option<u16>, String, String) {
    (rule, alarm.vessel, alarm.kind.clone(), alarm.part.clone())
}

fn recent(at_us: i64, now: UtcTime) -> bool {
    u128::try_from(now.micros().saturating_sub(at_us)).is_ok_and(|since_us| since_us < AGAIN.as_micros())
}

/// A message that is to be sent.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Draft {
    pub(super) rule: i64,
    pub(super) alarm: Option<u64>,
    pub(super) content: Content,
}

/// The messages that are due now. A message counts as sent once it is stored.
pub(super) fn due(rules: &[Held], standing: &[api::Alarm], told: &Notified, now: UtcTime) -> Vec<Draft> {
    let mut drafts = Vec::new();
    for held in rules {
        let draft = |alarm: &api::Alarm, event| Draft {
            rule: held.rule.id,
            alarm: Some(alarm.id),
            content: Content {
                event,
                time_us: now.micros(),
                alarm: Some(alarm.clone()),
                last_for_an_hour: false,
            },
        };
        let rule = held.rule.id;
        let raised = standing.iter().filter(|alarm| {
            let again = told.latest.get(&like(rule, alarm)).is_some_and(|at_us| recent(*at_us, now));
            !told.is_told(rule, alarm.id, What::Raised) && !again && wants(held, alarm, now)
        });
        drafts.extend(raised.map(|alarm| draft(alarm, What::Raised)));
        if !held.rule.ask.also_over {
            continue;
        }
        let over = told.alarms.values().filter_map(|alarm| {
            let open =
                told.is_told(rule, alarm.id, What::Raised) && !told.is_told(rule, alarm.id, What::Over);
            let newest = standing.iter().find(|one| one.id == alarm.id);
            let over = newest.is_none_or(|one| one.over_us.is_some());
            (open && over).then(|| newest.unwrap_or(alarm))
        });
        drafts.extend(over.map(|alarm| draft(alarm, What::Over)));
    }
    drafts
}

/// Whether an alarm matches a rule and is not acknowledged.
fn wants(Held { rule, grants }: &Held, alarm: &api::Alarm, now: UtcTime) -> bool {
    let ask = &rule.ask;
    let sees = alarm.vessel.is_none_or(|vessel| grants.on(vessel).is_some()) && grants.somewhere().is_some();
    let about = ask.vessel.is_none() || ask.vessel == alarm.vessel;
    let urgent = Priority::named(&alarm.priority).is_some_and(|priority| priority >= ask.least);
    let unknown = alarm.acknowledged.is_none() && alarm.shelved.is_none() && alarm.collapsed.is_none();
    let stands = alarm.over_us.is_none() && alarm.since_us >= rule.made_us;
    let waited_us = now.micros().saturating_sub(alarm.since_us);
    let waited = u128::try_from(waited_us).is_ok_and(|waited_us| waited_us >= ask.after.as_micros());
    sees && about && urgent && unknown && stands && waited
}
