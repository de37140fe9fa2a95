//! Alarms: what is wrong, since when, who acknowledged it, and when it sounds again.
//!
//! Once a second [`Alarms::watch`] derives what holds from the fleet's live state (`derive`) and gives it to this
//! machine, which has one entry for each vessel, kind and part:
//!
//! | state | meaning | leaves it by |
//! |---|---|---|
//! | normal | nothing is wrong | trouble that lasts for the kind's delay: unacknowledged (a caution: acknowledged, as it needs no one) |
//! | unacknowledged | wrong, and not acknowledged | a person: acknowledged; the trouble's end: returned |
//! | acknowledged | wrong, and known | the trouble's end: normal; a higher priority: unacknowledged |
//! | returned | was wrong, and not acknowledged | a person: normal; new trouble that is more than a caution: unacknowledged |
//!
//! Against chattering, a trouble must last for a while before it raises an alarm and be gone for a while before the alarm
//! returns; one that came [`CHATTERS_FROM`] times within a minute is held until a whole minute was quiet. One situation is
//! one alert: alarms that follow from a vessel's silence or its lost position are collapsed into that one. A warning not
//! acknowledged within [`ESCALATES_AFTER`] becomes an alarm if its kind says so; the others sound again at their
//! priority's interval.
//!
//! [`ALARMS_KEPT`] are kept. When there are more, a new one replaces one of lower priority; those that find no place are
//! counted and reported by an alarm of their own.

mod derive;
mod kind;
mod part;
mod record;
#[cfg(test)]
mod tests;

pub use derive::{CertificateState, LinkClock, OtherChart, ShoreState};
pub use kind::{Advice, Kind, Priority};
pub use record::{
    Alarm, AlarmId, AlarmRefused, Key, Note, Saved, Shelving, Signature, State, Trouble, day_and_time,
};

use api::AlarmSaying;
use hub::Fleet;
use imc::Address;
use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;
use units::{Now, UtcTime};

/// Alarms that are kept at once, besides those of the server itself.
pub const ALARMS_KEPT: usize = 1_000;
/// Changes that are remembered; the oldest goes first.
pub const NOTES_KEPT: usize = 500;
/// From so many times within a minute on, an alarm chatters and is held.
pub const CHATTERS_FROM: usize = 3;
/// A warning of some kinds that is not acknowledged becomes an alarm after this.
pub const ESCALATES_AFTER: Duration = Duration::from_mins(1);
/// An alarm cannot be shelved for longer.
pub const LONGEST_SHELF: Duration = Duration::from_hours(12);
/// Most characters of an alarm's words, of a part's name and of a reason.
const TEXT_CHARS: usize = 300;
const CHATTER_WINDOW: Duration = Duration::from_mins(1);

/// All alarms.
#[derive(Debug, Default)]
pub struct Alarms {
    all: BTreeMap<Key, Alarm>,
    notes: VecDeque<Note>,
    last_id: u64,
    revision: u64,
    /// Trouble that had no place at the last observation.
    untold: usize,
    observer: derive::Observer,
    /// Those that gave up their place, as normal, for readers that still know them.
    evicted: VecDeque<Alarm>,
}

impl Alarms {
    /// Takes the state of the fleet and of the server. To be called once a second.
    pub fn watch(&mut self, now: Now, fleet: &Fleet, shore: &ShoreState) {
        let mut seen = self.observer.observe(now, fleet, shore);
        // A silence that was an alarm when the server ended continues as that alarm, with its time.
        let stands = |vessel| {
            self.all.iter().any(|(key, one)| {
                let holds = matches!(one.state, State::Unacknowledged | State::Acknowledged);
                (key.vessel, key.kind) == (vessel, Kind::NotHeard) && holds
            })
        };
        seen.troubles.retain(|one| one.key.kind != Kind::NeverHeard || !stands(one.key.vessel));
        if self.untold > 0 {
            seen.troubles.push(Trouble {
                key: Key { vessel: None, kind: Kind::TooMany, part: String::new() },
                priority: Priority::Alarm,
                says: vec![AlarmSaying::TooMany { count: self.untold as u64, most: ALARMS_KEPT as u64 }],
            });
        }
        let troubles = std::mem::take(&mut seen.troubles);
        self.update(now, troubles, |key| seen.unknown(key));
    }

    /// Takes the troubles that hold now. Where `unknown` says that this cannot be determined, an alarm is left unchanged.
    fn update(&mut self, now: Now, troubles: Vec<Trouble>, unknown: impl Fn(&Key) -> bool) {
        let mut holding = BTreeMap::new();
        for mut trouble in troubles {
            shorten(&mut trouble.key.part);
            let worst =
                holding.get(&trouble.key).is_none_or(|known: &Trouble| known.priority < trouble.priority);
            if worst {
                holding.insert(trouble.key.clone(), trouble);
            }
        }
        self.untold = 0;
        for trouble in holding.values() {
            if !self.all.contains_key(&trouble.key) && !self.make_room(trouble) {
                self.untold += 1;
                continue;
            }
            self.see(now, trouble);
        }
        let gone: Vec<Key> = self.all.keys().filter(|key| !holding.contains_key(key)).cloned().collect();
        for key in gone {
            if !unknown(&key) {
                self.see_gone(now, &key);
            }
        }
        self.collapse(now);
        self.pass(now);
        self.forget(now);
    }

    fn make_room(&mut self, trouble: &Trouble) -> bool {
        if trouble.key.vessel.is_none() || self.all.len() < ALARMS_KEPT {
            return true;
        }
        let weaker = self.all.values().filter(|alarm| {
            alarm.key.vessel.is_some()
                && (alarm.state == State::Normal && !alarm.holds || alarm.priority < trouble.priority)
        });
        let weakest = weaker.min_by_key(|alarm| (alarm.state != State::Normal, alarm.priority, alarm.id));
        let Some(key) = weakest.map(|alarm| alarm.key.clone()) else { return false };
        if let Some(mut alarm) = self.all.remove(&key).filter(|alarm| alarm.id.0 > 0) {
            self.revision += 1;
            (alarm.state, alarm.shelved, alarm.revision) = (State::Normal, None, self.revision);
            self.evicted.push_back(alarm);
            if self.evicted.len() > ALARMS_KEPT {
                self.evicted.pop_front();
            }
        }
        true
    }

    /// Trouble that holds.
    fn see(&mut self, now: Now, trouble: &Trouble) {
        let (Trouble { key, priority, says }, text) = (trouble, &trouble.text());
        let alarm = self.all.entry(key.clone()).or_insert_with(|| Alarm {
            id: AlarmId(0),
            key: key.clone(),
            state: State::Normal,
            priority: *priority,
            says: Vec::new(),
            text: String::new(),
            since: now.utc,
            over: None,
            count: 0,
            acknowledged: None,
            escalated: false,
            chatters: false,
            shelved: None,
            collapsed: None,
            sounded: 0,
            revision: 0,
            raised: now.mono,
            sounds_next: now.mono,
            holds: false,
            turned: now.mono,
            raises: VecDeque::new(),
        });
        if !alarm.holds {
            (alarm.holds, alarm.turned) = (true, now.mono);
        }
        match alarm.state {
            State::Normal | State::Returned if now.mono.since(alarm.turned) < key.kind.delay() => {}
            // A caution needs no acknowledgement: it does not raise again an alarm that was more urgent.
            State::Returned if *priority == Priority::Caution => {}
            State::Normal | State::Returned => self.raise(now, trouble),
            State::Unacknowledged | State::Acknowledged => {
                let more = *priority > alarm.priority;
                // An alarm that is not acknowledged does not become less urgent on its own.
                let less = *priority < alarm.priority && alarm.state == State::Acknowledged;
                // Figures that change by less than the words show change nothing.
                let told = alarm.text != *text;
                if more || less || told {
                    (alarm.says, alarm.text) = (says.clone(), text.clone());
                    self.revision += 1;
                    alarm.revision = self.revision;
                }
                if more || less {
                    alarm.priority = *priority;
                }
                if more {
                    alarm.state = state_of(*priority);
                    (alarm.acknowledged, alarm.raised) = (None, now.mono);
                    let id = alarm.id;
                    self.sound(now, key);
                    self.note(now, id, key, "more urgent", "", text);
                }
            }
        }
    }

    fn raise(&mut self, now: Now, trouble: &Trouble) {
        let (Trouble { key, priority, says }, text) = (trouble, &trouble.text());
        let Some(alarm) = self.all.get_mut(key) else { return };
        let again = alarm.state == State::Returned;
        if again {
            alarm.count += 1;
        } else {
            self.last_id += 1;
            (alarm.id, alarm.count, alarm.sounded) = (AlarmId(self.last_id), 1, 0);
        }
        (alarm.priority, alarm.escalated) = (*priority, false);
        alarm.state = state_of(alarm.priority);
        alarm.says.clone_from(says);
        alarm.text.clone_from(text);
        (alarm.since, alarm.over, alarm.raised, alarm.acknowledged) = (now.utc, None, now.mono, None);
        alarm.raises.push_back(now.mono);
        while alarm.raises.len() > CHATTERS_FROM {
            alarm.raises.pop_front();
        }
        let recent = alarm.raises.iter().filter(|at| now.mono.since(**at) < CHATTER_WINDOW).count();
        alarm.chatters = recent >= CHATTERS_FROM;
        let id = alarm.id;
        self.sound(now, key);
        self.note(now, id, key, if again { "again" } else { "raised" }, "", text);
    }

    /// Trouble that does not hold.
    fn see_gone(&mut self, now: Now, key: &Key) {
        let Some(alarm) = self.all.get_mut(key) else { return };
        if alarm.holds {
            (alarm.holds, alarm.turned) = (false, now.mono);
        }
        let rest = if alarm.chatters { CHATTER_WINDOW } else { key.kind.rest() };
        if now.mono.since(alarm.turned) < rest {
            return;
        }
        let (id, text) = (alarm.id, alarm.text.clone());
        let ago_us = now.mono.since(alarm.turned).as_micros() as i64;
        match alarm.state {
            State::Unacknowledged => {
                (alarm.state, alarm.chatters) = (State::Returned, false);
                alarm.over = Some(UtcTime::from_micros(now.utc.micros().saturating_sub(ago_us)));
                self.note(now, id, key, "returned", "", &text);
            }
            State::Acknowledged => {
                // Kept for as long as readers need to learn of it.
                (alarm.state, alarm.chatters, alarm.turned) = (State::Normal, false, now.mono);
                self.note(now, id, key, "over", "", &text);
            }
            State::Normal | State::Returned => {}
        }
    }

    /// Alarms that follow from a vessel's silence or its lost position are not reported themselves.
    fn collapse(&mut self, now: Now) {
        let stands = |all: &BTreeMap<Key, Alarm>, vessel, kind| {
            let key = Key { vessel, kind, part: String::new() };
            all.get(&key).is_some_and(|one| matches!(one.state, State::Unacknowledged | State::Acknowledged))
        };
        let vessels: std::collections::BTreeSet<Address> =
            self.all.keys().filter_map(|key| key.vessel).collect();
        let silent: Vec<Address> =
            vessels.iter().copied().filter(|one| stands(&self.all, Some(*one), Kind::NotHeard)).collect();
        let lost: Vec<Address> =
            vessels.into_iter().filter(|one| stands(&self.all, Some(*one), Kind::Position)).collect();
        let mut turned = Vec::new();
        for alarm in self.all.values_mut() {
            let Some(vessel) = alarm.key.vessel else { continue };
            let within = if alarm.key.kind.outlives_silence() {
                None
            } else if silent.contains(&vessel) {
                Some(Kind::NotHeard)
            } else if lost.contains(&vessel) && self.observer.is_of_position(&alarm.key) {
                Some(Kind::Position)
            } else {
                None
            };
            if alarm.collapsed != within {
                let back = within.is_none() && alarm.state == State::Unacknowledged;
                alarm.collapsed = within;
                self.revision += 1;
                alarm.revision = self.revision;
                if back {
                    alarm.raised = now.mono;
                    turned.push(alarm.key.clone());
                }
            }
        }
        for key in turned {
            self.sound(now, &key);
        }
    }

    /// Changes by time: shelves that end, warnings that become alarms, repeated sounds.
    fn pass(&mut self, now: Now) {
        let due: Vec<Key> = self.all.keys().cloned().collect();
        for key in due {
            let Some(alarm) = self.all.get_mut(&key) else { continue };
            let id = alarm.id;
            let over = alarm.shelved.as_ref().is_some_and(|shelf| shelf.ends <= now.mono);
            if over || alarm.shelved.is_some() && alarm.priority == Priority::Emergency {
                alarm.shelved = None;
                if alarm.state == State::Acknowledged && alarm.priority > Priority::Caution {
                    // Shelving was not an acknowledgement: an operator who logs in now sees the alarm.
                    (alarm.state, alarm.acknowledged) = (State::Unacknowledged, None);
                }
                alarm.raised = now.mono;
                if !alarm.holds {
                    alarm.turned = now.mono;
                }
                self.sound(now, &key);
                self.note(now, id, &key, "off the shelf", "", "");
            }
            let Some(alarm) = self.all.get_mut(&key) else { continue };
            if !(alarm.state == State::Unacknowledged && alarm.is_told()) {
                continue;
            }
            let waited = now.mono.since(alarm.raised) >= ESCALATES_AFTER;
            if alarm.priority == Priority::Warning && key.kind.escalates() && waited {
                (alarm.priority, alarm.escalated) = (Priority::Alarm, true);
                let text = alarm.text.clone();
                self.sound(now, &key);
                self.note(now, id, &key, "escalated", "", &text);
            } else if alarm.sounds_next <= now.mono {
                self.sound(now, &key);
            }
        }
    }

    /// Lets it sound, and sets when it does again.
    fn sound(&mut self, now: Now, key: &Key) {
        let Some(alarm) = self.all.get_mut(key) else { return };
        self.revision += 1;
        alarm.revision = self.revision;
        if let Some(every) = alarm.priority.repeats()
            && alarm.shelved.is_none()
            && alarm.collapsed.is_none()
            && alarm.state == State::Unacknowledged
        {
            alarm.sounded = alarm.sounded.wrapping_add(1);
            alarm.sounds_next = now.mono + every;
        }
    }

    /// Drops what is normal and was for a while.
    fn forget(&mut self, now: Now) {
        self.all.retain(|_, alarm| {
            alarm.state != State::Normal
                || alarm.shelved.is_some()
                || alarm.holds
                || now.mono.since(alarm.turned) < CHATTER_WINDOW
        });
    }

    fn note(&mut self, now: Now, id: AlarmId, key: &Key, what: &'static str, by: &str, text: &str) {
        self.revision += 1;
        if let Some(alarm) = self.all.get_mut(key) {
            alarm.revision = self.revision;
        }
        let priority = self.all.get(key).map_or(Priority::Caution, |alarm| alarm.priority);
        // A person's words need no code.
        let own = self.all.get(key).filter(|alarm| alarm.text == text);
        let says = own.map(|alarm| alarm.says.clone()).unwrap_or_default();
        let (key, by, text) = (key.clone(), by.to_owned(), text.to_owned());
        self.notes.push_back(Note {
            revision: self.revision,
            at: now.utc,
            id,
            key,
            priority,
            what,
            by,
            says,
            text,
        });
        while self.notes.len() > NOTES_KEPT {
            self.notes.pop_front();
        }
    }

    fn key_of(&self, id: AlarmId) -> Result<Key, AlarmRefused> {
        let found = self.all.values().find(|alarm| alarm.id == id && id.0 > 0);
        found.map(|alarm| alarm.key.clone()).ok_or(AlarmRefused::Gone)
    }

    /// A person acknowledges an alarm.
    ///
    /// # Errors
    /// There is no such alarm, or it needs no acknowledgement.
    pub fn acknowledge(&mut self, now: Now, id: AlarmId, by: &str) -> Result<(), AlarmRefused> {
        let key = self.key_of(id)?;
        let Some(alarm) = self.all.get_mut(&key) else { return Err(AlarmRefused::Gone) };
        alarm.state = match alarm.state {
            State::Unacknowledged => State::Acknowledged,
            State::Returned => State::Normal,
            State::Acknowledged => return Err(AlarmRefused::Known),
            State::Normal => return Err(AlarmRefused::Gone),
        };
        alarm.acknowledged = Some(Signature { by: by.to_owned(), at: now.utc });
        if !alarm.holds {
            // Kept for as long as readers need to learn of it.
            alarm.turned = now.mono;
        }
        let text = alarm.text.clone();
        self.note(now, id, &key, "acknowledged", by, &text);
        Ok(())
    }

    /// A person puts an alarm aside for a time.
    ///
    /// # Errors
    /// There is no such alarm, it is an emergency, or the time or the reason is missing.
    pub fn shelve(
        &mut self,
        now: Now,
        id: AlarmId,
        by: &str,
        span: Duration,
        reason: &str,
    ) -> Result<(), AlarmRefused> {
        let key = self.key_of(id)?;
        let Some(alarm) = self.all.get_mut(&key) else { return Err(AlarmRefused::Gone) };
        if alarm.state == State::Normal {
            return Err(AlarmRefused::Gone);
        }
        if alarm.priority == Priority::Emergency {
            return Err(AlarmRefused::Emergency);
        }
        if span < Duration::from_mins(1) || span > LONGEST_SHELF {
            return Err(AlarmRefused::Time);
        }
        if reason.trim().is_empty() || reason.chars().count() > TEXT_CHARS {
            return Err(AlarmRefused::Reason);
        }
        let until = UtcTime::from_micros(now.utc.micros().saturating_add(span.as_micros() as i64));
        let said = Signature { by: by.to_owned(), at: now.utc };
        alarm.shelved = Some(Shelving { said, until, reason: reason.to_owned(), ends: now.mono + span });
        self.note(now, id, &key, "shelved", by, reason);
        Ok(())
    }

    /// An alarm by its number.
    pub fn get(&self, id: AlarmId) -> Option<&Alarm> {
        self.all.values().find(|alarm| alarm.id == id && id.0 > 0)
    }

    /// Alarms that are not normal, and shelved ones.
    pub fn standing(&self) -> impl Iterator<Item = &Alarm> {
        self.all
            .values()
            .filter(|alarm| alarm.id.0 > 0 && (alarm.state != State::Normal || alarm.shelved.is_some()))
    }

    /// Changes after `revision`; a reader that starts from nothing (0) does not get normal alarms.
    pub fn changed(&self, revision: u64) -> impl Iterator<Item = &Alarm> {
        let news = move |alarm: &&Alarm| {
            let stands = alarm.state != State::Normal || alarm.shelved.is_some();
            alarm.id.0 > 0 && alarm.revision > revision && (revision > 0 || stands)
        };
        self.evicted.iter().chain(self.all.values()).filter(news)
    }

    /// The latest events, the oldest first.
    pub fn notes(&self) -> impl DoubleEndedIterator<Item = &Note> {
        self.notes.iter()
    }

    /// Counts changes.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Takes over an alarm from before a restart. It stays as it was until its vessel is heard again.
    pub fn restore(&mut self, now: Now, saved: Saved) {
        let Saved {
            id,
            key,
            state,
            priority,
            says,
            text,
            since,
            over,
            count,
            acknowledged,
            escalated,
            shelved,
        } = saved;
        if state == State::Normal || self.all.contains_key(&key) || self.all.len() >= ALARMS_KEPT {
            return;
        }
        self.last_id = self.last_id.max(id.0);
        self.revision += 1;
        let shelved = shelved.map(|(said, until, reason)| {
            let left = Duration::from_micros(u64::try_from(until - now.utc).unwrap_or_default());
            Shelving { said, until, reason, ends: now.mono + left.min(LONGEST_SHELF) }
        });
        let alarm = Alarm {
            id,
            key: key.clone(),
            state,
            priority,
            says,
            text,
            since,
            over,
            count,
            acknowledged,
            escalated,
            chatters: false,
            shelved,
            collapsed: None,
            sounded: 0,
            revision: self.revision,
            raised: now.mono,
            sounds_next: now.mono,
            holds: state != State::Returned,
            turned: now.mono,
            raises: VecDeque::new(),
        };
        self.all.insert(key, alarm);
    }
}

/// The state of what has just come.
fn state_of(priority: Priority) -> State {
    if priority == Priority::Caution { State::Acknowledged } else { State::Unacknowledged }
}

fn shorten(text: &mut String) {
    if let Some((end, _)) = text.char_indices().nth(TEXT_CHARS) {
        text.truncate(end);
    }
}
