//! Determines due messages once a second, and sends the queued ones.

use super::content::{Content, What};
use super::judge::{Draft, Held, Notified, due};
use super::mail::{self, Letter};
use super::rows::{self, Delivery, Due, Put, ReadTold, Rules, Settle, Waiting};
use super::rule::{Rule, RuleChange, RuleRequest, SigningKey, Way};
use super::settings::Settings;
use super::webhook::{self, Post};
use crate::alarms::Alarms;
use crate::clock::Clock;
use crate::error::{Error, Result};
use crate::identity::{People, Principal, Secret};
use api::say;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;
use tokio::task::{self, JoinSet};
use tokio_util::sync::CancellationToken;
use units::UtcTime;

/// How often due messages are determined.
const EVERY: Duration = Duration::from_secs(1);
/// Most messages that are sent concurrently.
const AT_ONCE: usize = 4;
/// An attempt that takes longer counts as failed.
const PATIENCE: Duration = Duration::from_secs(30);
/// Delays before the next attempt, after the first, the second and so on; the last one repeats.
pub(super) const AGAIN: [Duration; 5] = [
    Duration::from_secs(10),
    Duration::from_mins(1),
    Duration::from_mins(5),
    Duration::from_mins(15),
    Duration::from_mins(30),
];
/// A message that was not accepted for this long is given up.
const GIVEN_UP: Duration = Duration::from_hours(24);
/// Most messages that are shown to a person.
const SHOWN: u32 = 20;

/// Handle of the notices; cheap to clone.
#[derive(Clone)]
pub struct Notices {
    people: People,
    clock: Clock,
    settings: Arc<Settings>,
}

/// A rule that was made.
#[derive(Clone, PartialEq, Eq)]
pub struct Made {
    /// Its number.
    pub id: i64,
    /// Key that signs a webhook's messages, shown only now; empty for mail.
    pub secret: String,
}

/// The rules of a person, and their messages.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mine {
    /// The rules, by number.
    pub rules: Vec<Rule>,
    /// The newest messages first.
    pub messages: Vec<Delivery>,
}

/// Messages being sent, each once.
#[derive(Default)]
struct Sending {
    attempts: JoinSet<()>,
    /// Message of each task: a task that panics gives no answer, and its message is tried again.
    messages: BTreeMap<task::Id, i64>,
}

impl Sending {
    fn begin(&mut self, notices: &Notices, waiting: Waiting) {
        let message = waiting.id;
        if self.messages.len() < AT_ONCE && self.messages.values().all(|id| *id != message) {
            let notices = notices.clone();
            let attempt = self.attempts.spawn(async move { notices.deliver(waiting).await });
            self.messages.insert(attempt.id(), message);
        }
    }

    /// Forgets the attempts that are over.
    fn settle(&mut self) {
        while let Some(done) = self.attempts.try_join_next_with_id() {
            let task = done.map_or_else(|fault| fault.id(), |(task, ())| task);
            self.messages.remove(&task);
        }
    }
}

impl Notices {
    pub(crate) fn new(people: People, clock: Clock, settings: Settings) -> Self {
        Self { people, clock, settings: Arc::new(settings) }
    }

    /// How messages leave the server.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The rules and messages of a person.
    ///
    /// # Errors
    /// app.db cannot be read.
    pub async fn mine(&self, who: &Principal) -> Result<Mine> {
        let (rules, messages) = self.people.ask(rows::Mine { person: who.person, messages: SHOWN }).await?;
        Ok(Mine { rules, messages })
    }

    /// Makes a rule for a person.
    ///
    /// # Errors
    /// This server does not support the rule, the person may not see the vessel, or has the most rules allowed.
    pub async fn add(&self, who: &Principal, from: String, ask: RuleRequest) -> Result<Made> {
        self.check(who, &ask)?;
        let secret = match ask.way {
            Way::Webhook => Secret::random().text(),
            Way::Mail => String::new(),
        };
        let subject = format!("{} to {}", ask.way.name(), ask.shown_target());
        let add =
            rows::Add { person: who.person, ask, key: SigningKey(secret.clone()), now: self.clock.utc() };
        let id = self.people.act(who, from, "notice.rule.make", subject, add).await?;
        Ok(Made { id, secret })
    }

    /// Changes a rule of a person; its way stays.
    ///
    /// # Errors
    /// The person has no such rule, this server does not support it, or the person may not see the vessel.
    pub async fn change(&self, who: &Principal, from: String, id: i64, change: RuleChange) -> Result<()> {
        let mine = self.mine(who).await?;
        let known = mine.rules.into_iter().find(|rule| rule.id == id);
        let known = known.ok_or_else(|| Error::refused(rows::NO_RULE))?;
        let ask = change.of(known.ask.way);
        self.check(who, &ask)?;
        let subject = format!("{id}: {} to {}", ask.way.name(), ask.shown_target());
        let change = rows::Change { person: who.person, id, ask };
        Ok(self.people.act(who, from, "notice.rule.change", subject, change).await?)
    }

    /// Checks that a person may have this rule.
    fn check(&self, who: &Principal, ask: &RuleRequest) -> Result<()> {
        ask.check(&self.settings).map_err(Error::refused)?;
        if ask.vessel.is_some_and(|vessel| who.grants.on(vessel).is_none()) {
            return Err(Error::refused(say("You may not see that vessel.")));
        }
        Ok(())
    }

    /// Removes a rule of a person; its queued messages are not sent.
    ///
    /// # Errors
    /// The person has no such rule.
    pub async fn remove(&self, who: &Principal, from: String, id: i64) -> Result<()> {
        let remove = rows::Remove { person: who.person, id };
        Ok(self.people.act(who, from, "notice.rule.remove", id.to_string(), remove).await?)
    }

    /// Sends a test message of a rule, and waits for its outcome.
    ///
    /// # Errors
    /// The person has no such rule, or app.db cannot be written.
    pub async fn test(&self, who: &Principal, id: i64) -> Result<Delivery> {
        let mine = self.mine(who).await?;
        if !mine.rules.iter().any(|rule| rule.id == id) {
            return Err(Error::refused(rows::NO_RULE));
        }
        let now = self.clock.utc();
        let content =
            Content { event: What::Test, time_us: now.micros(), alarm: None, last_for_an_hour: false };
        // Due later, so that the service does not send it in parallel, but does if this attempt was killed.
        let due = UtcTime::from_micros(now.micros() + i64::try_from(PATIENCE.as_micros() * 2).unwrap_or(0));
        let put = Put { drafts: vec![Draft { rule: id, alarm: None, content }], now, due };
        let message = self.people.change(put).await?;
        let waiting = self.people.ask(Due { now, id: Some(message) }).await?;
        for one in waiting {
            self.deliver(one).await;
        }
        let mine = self.mine(who).await?;
        let newest = mine.messages.into_iter().find(|one| one.rule == id);
        newest.ok_or_else(|| Error::refused(say("The rule was removed meanwhile.")))
    }

    /// Sends messages about active alarms until the server ends.
    pub(crate) async fn keep(self, alarms: Alarms, stop: CancellationToken) {
        let (mut told, mut waits) = (None, false);
        let mut sending = Sending::default();
        loop {
            sending.settle();
            let looked = self.look(&alarms, &mut told).await;
            if let Err(error) = &looked
                && !waits
            {
                tracing::warn!(%error, "messages about alarms wait");
            }
            waits = looked.is_err();
            if let Ok(waiting) = self.people.ask(Due { now: self.clock.utc(), id: None }).await {
                for one in waiting {
                    sending.begin(&self, one);
                }
            }
            let next = self.clock.mono() + EVERY;
            if stop.run_until_cancelled(self.clock.sleep_until(next)).await.is_none() {
                return;
            }
        }
    }

    async fn look(&self, alarms: &Alarms, known: &mut Option<Notified>) -> Result<()> {
        let rules = self.people.ask(Rules).await?;
        let told = match known {
            Some(told) => told,
            None => known.insert(self.people.ask(ReadTold(self.clock.utc())).await?),
        };
        if rules.is_empty() {
            return Ok(());
        }
        self.tell(&rules, &alarms.standing().await?, told).await
    }

    /// Compares the active alarms with the rules, and stores due messages.
    pub(super) async fn tell(
        &self,
        rules: &[Held],
        standing: &[api::Alarm],
        told: &mut Notified,
    ) -> Result<()> {
        let now = self.clock.utc();
        let drafts = due(rules, standing, told, now);
        if !drafts.is_empty() {
            self.people.change(Put { drafts: drafts.clone(), now, due: now }).await?;
            for draft in drafts {
                told.keep(draft.rule, &draft.content);
            }
        }
        told.forget(rules, standing, now);
        Ok(())
    }

    /// Makes one attempt, and stores its outcome.
    pub(super) async fn deliver(&self, waiting: Waiting) {
        let attempt = tokio::time::timeout(PATIENCE, self.attempt(&waiting)).await;
        let answer = attempt.unwrap_or_else(|_| Err(anyhow::anyhow!("it does not answer")));
        let now = self.clock.utc();
        let late = u128::try_from(now.micros() - waiting.made_us).is_ok_and(|us| us >= GIVEN_UP.as_micros());
        let (outcome, words) = match answer {
            Ok(None) => (Ok("delivered"), String::new()),
            Ok(Some(refused)) => (Ok("refused"), refused),
            Err(error) if late => (Ok("given up"), format!("{error:#}")),
            Err(error) => {
                let wait = AGAIN[usize::try_from(waiting.tries).unwrap_or(AGAIN.len()).min(AGAIN.len() - 1)];
                let again = now.micros() + i64::try_from(wait.as_micros()).unwrap_or(0);
                (Err(UtcTime::from_micros(again)), format!("{error:#}"))
            }
        };
        let way = waiting.rule.ask.way.name();
        metrics::counter!("lutra_notices_total", "way" => way, "outcome" => outcome.unwrap_or("tried again"))
            .increment(1);
        if let Ok("refused" | "given up") = outcome {
            tracing::warn!(message = waiting.id, way, %words, "a message about an alarm was not taken");
        }
        let settle = Settle { id: waiting.id, words, outcome, now };
        if let Err(error) = self.people.change(settle).await {
            // It will be sent again: the receiver can recognise it by its number.
            tracing::warn!(message = waiting.id, %error, "what became of a message is not written down");
        }
    }

    /// Sends a message: `None` if it was accepted, else why it was refused permanently.
    async fn attempt(
        &self,
        Waiting { id, rule, content, language, .. }: &Waiting,
    ) -> anyhow::Result<Option<String>> {
        let (settings, target) = (&*self.settings, rule.ask.target.as_str());
        match rule.ask.way {
            Way::Mail => {
                let host = settings.mail.from.rsplit('@').next().unwrap_or("lutra").trim_end_matches('>');
                let letter = Letter {
                    to: target,
                    id: format!("<lutra-{id}-{}@{host}>", content.time_us),
                    subject: content.subject(*language),
                    text: content.text(*language, settings),
                };
                Ok(match mail::send(settings, letter).await? {
                    mail::Answer::Taken => None,
                    mail::Answer::Refused(words) => Some(words),
                })
            }
            Way::Webhook => {
                let now_s = self.clock.utc().micros() / 1_000_000;
                let body = serde_json::to_string(&content.posted(*language))?;
                let post = Post { url: target, secret: &rule.key.0, delivery: *id, now_s, body };
                Ok(match webhook::post(settings, post).await? {
                    webhook::Answer::Taken => None,
                    webhook::Answer::Refused(words) => Some(words),
                })
            }
        }
    }
}
