//! STOP: the only place that accepts it, from every transport.
//!
//! A client sends a stop over every available connection, and repeats it until it is answered. All requests with one key
//! from one person for one vessel are one stop: the first is carried out by a task that continues if the sender
//! disconnects, and all get its answer. A stop that failed here is forgotten, so that the next try is carried out.

use super::log::of_command;
use super::{Commands, Issuer};
use crate::error::{Error, ErrorKind, Result};
use crate::identity::Line;
use crate::known::one_vessel;
use api::{Ordered, say};
use hub::Dispatched;
use imc::Address;
use operations::{Operations, Order};
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::sync::watch;
use units::{MonoTime, Now};

/// How long a stop is known by its key.
const KNOWN_FOR: Duration = Duration::from_mins(10);
/// Stops that are known at most. Beyond it the oldest is forgotten; should it come again, its vessel is stopped again.
const KNOWN: usize = 4_096;
/// Bytes of a key and of a window's name at most.
const KEY_BYTES: usize = 64;

type Outcome = Result<Ordered>;
/// Person, vessel, key.
type Name = (i64, u16, String);

/// The stops of the last minutes, by their keys; cheap to clone.
#[derive(Clone, Default)]
pub struct Stops(Arc<Mutex<Known>>);

#[derive(Default)]
struct Known {
    /// Stops since the server started.
    count: u64,
    by_name: BTreeMap<Name, (u64, watch::Receiver<Option<Outcome>>)>,
    /// When each came, the oldest first.
    order: VecDeque<(MonoTime, u64, Name)>,
}

/// A stop that is being carried out, or was.
#[derive(Debug)]
pub struct Stop(watch::Receiver<Option<Outcome>>);

impl Stop {
    /// The outcome.
    ///
    /// # Errors
    /// It could not be carried out.
    pub async fn outcome(mut self) -> Outcome {
        let ended = self.0.wait_for(Option::is_some).await;
        let outcome = ended.ok().and_then(|outcome| outcome.clone());
        outcome.unwrap_or_else(|| Err(Error::internal(&"a stop ended without a word")))
    }
}

impl Commands {
    /// Stops a vessel, and waits for the outcome.
    ///
    /// # Errors
    /// The key is too long, the address is not that of one vessel, or the server could not carry it out.
    pub async fn stop(&self, vessel: Address, by: Issuer, key: &str) -> Outcome {
        self.begin_stop(vessel, by, key)?.outcome().await
    }

    /// Begins to stop a vessel, at once and without waiting, or finds the stop that this one repeats.
    ///
    /// # Errors
    /// The key is too long, or the address is not that of one vessel.
    pub fn begin_stop(&self, vessel: Address, by: Issuer, key: &str) -> Result<Stop> {
        one_vessel(vessel)?;
        if key.len() > KEY_BYTES || by.window.len() > KEY_BYTES {
            let text = say("key and window have {most} bytes at most").with("most", KEY_BYTES);
            return Err(Error::new(ErrorKind::Malformed, text));
        }
        let (told, stop) = match self.stops.note(vessel, &by, key, self.router.clock().mono()) {
            Noted::Repeated(stop) => return Ok(stop),
            Noted::New { told, stop } => (told, stop),
        };
        let service = self.clone();
        self.tasks.spawn(async move {
            let outcome = service.carry_out_stop(vessel, &by).await;
            told.send_replace(Some(outcome));
        });
        Ok(stop)
    }

    /// Sends the stop over the hub's downlink as soon as the hub is free. The request and its progress are written into the
    /// audit log afterwards, so that a slow disk does not delay the stop. For the same reason a vessel of which only the history
    /// knows counts as unknown: it is stopped all the same.
    async fn carry_out_stop(&self, vessel: Address, by: &Issuer) -> Outcome {
        // Whatever becomes of it, that it was asked for is known.
        tracing::warn!(%vessel, person = by.who.name, "a stop is asked for");
        let (asked, people) = (by.ordered_by(), self.people.clone());
        let named = people.is_named(vessel);
        let give = move |operations: &mut Operations, now: Now| {
            let known = named || operations.fleet().system(vessel).is_some();
            let stopped = operations.stop(now, vessel, &asked);
            let subject = vessel.to_string();
            people.note(Line {
                actor: asked.actor,
                address: asked.from,
                action: Order::Stop.verb(),
                subject: stopped.as_ref().map_or(subject.clone(), |(id, _)| of_command(&subject, *id)),
                outcome: "asked".to_owned(),
            });
            let (id, dispatched) = stopped?;
            let (reached, waits) = match dispatched {
                Some(Dispatched::Sent(_)) => (true, false),
                Some(Dispatched::Waits(transports)) => (!transports.is_empty(), true),
                Some(Dispatched::Refused(_)) | None => (false, false),
            };
            Ok::<_, api::Said>(Ordered { id: id.0, time_us: now.utc.micros(), reached, waits, known })
        };
        let given = self.router.ask_first(give).await.inspect_err(|stopped| {
            let asked = by.ordered_by();
            tracing::error!(%vessel, person = by.who.name, error = %stopped, "a stop was not given");
            self.people.note(Line {
                actor: asked.actor,
                address: asked.from,
                action: Order::Stop.verb(),
                subject: vessel.to_string(),
                outcome: format!("not given: {stopped}"),
            });
        })?;
        match &given {
            Ok(Ordered { id: command, reached, waits, known, .. }) => {
                tracing::warn!(command, %vessel, person = by.who.name, reached, waits, known, "stop");
            }
            Err(why) => tracing::error!(%vessel, person = by.who.name, %why, "a stop was not given"),
        }
        given.map_err(Error::refused)
    }
}

enum Noted {
    Repeated(Stop),
    New { told: watch::Sender<Option<Outcome>>, stop: Stop },
}

impl Stops {
    fn note(&self, vessel: Address, by: &Issuer, key: &str, now: MonoTime) -> Noted {
        // The list is valid even after a panic.
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        known.forget(now);
        let name = (by.who.person, vessel.0, key.to_owned());
        if let Some((_, stop)) = known.by_name.get(&name)
            && repeats(stop)
        {
            return Noted::Repeated(Stop(stop.clone()));
        }
        known.count += 1;
        let id = known.count;
        let (told, stop) = watch::channel(None);
        if !key.is_empty() {
            known.by_name.insert(name.clone(), (id, stop.clone()));
            known.order.push_back((now, id, name));
        }
        Noted::New { told, stop: Stop(stop) }
    }
}

/// Whether a stop is under way or was carried out, so that it need not be again.
fn repeats(stop: &watch::Receiver<Option<Outcome>>) -> bool {
    match &*stop.borrow() {
        Some(outcome) => outcome.is_ok(),
        None => stop.has_changed().is_ok(),
    }
}

impl Known {
    fn forget(&mut self, now: MonoTime) {
        while let Some((since, ..)) = self.order.front()
            && (now.since(*since) > KNOWN_FOR || self.order.len() >= KNOWN)
            && let Some((_, id, name)) = self.order.pop_front()
        {
            // A stop that failed may have been repeated under the same key: do not remove the newer one.
            if self.by_name.get(&name).is_some_and(|(known, _)| *known == id) {
                self.by_name.remove(&name);
            }
        }
    }
}
