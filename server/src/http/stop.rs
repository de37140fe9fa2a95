//! STOP: the one place that accepts it, by whatever way it comes.
//!
//! Who stops a vessel sends it by every way there is, and again until it is answered. All that comes with one key from
//! one person for one vessel is one stop: the first is carried out, by a task that goes on when its sender is gone, and
//! all get its answer. A stop that failed here is forgotten, so that the next try is carried out.

use super::error::ApiError;
use super::orders::{self, Issuer};
use crate::people::Line;
use crate::shore::AppState;
use api::Ordered;
use hub::{Dispatched, Hub, Order};
use imc::Address;
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::sync::watch;
use units::MonoTime;

/// How long a stop is known by its key.
const KNOWN_FOR: Duration = Duration::from_mins(10);
/// Stops that are known at most. Beyond it the oldest is forgotten; should it come again, its vessel is stopped again.
const KNOWN: usize = 4_096;
/// Bytes of a key and of a window's name at most.
const KEY_BYTES: usize = 64;

type Outcome = Result<Ordered, ApiError>;
/// Person, vessel, key.
type Name = (i64, u16, String);

/// The stops of the last minutes, by their keys; cheap to clone.
#[derive(Clone, Default)]
pub(crate) struct Stops(Arc<Mutex<Known>>);

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
pub(crate) struct Stop(watch::Receiver<Option<Outcome>>);

impl Stop {
    /// What became of it.
    ///
    /// # Errors
    /// It could not be carried out.
    pub(crate) async fn outcome(mut self) -> Outcome {
        let ended = self.0.wait_for(Option::is_some).await;
        let outcome = ended.ok().and_then(|outcome| outcome.clone());
        outcome.unwrap_or_else(|| Err(ApiError::internal(&"a stop ended without a word")))
    }
}

/// Stops a vessel, and tells what became of it.
///
/// # Errors
/// The key is too long, or the server could not carry it out.
pub(crate) async fn stop(state: &AppState, vessel: Address, by: Issuer, key: &str) -> Outcome {
    begin(state, vessel, by, key)?.outcome().await
}

/// Begins to stop a vessel, at once and without waiting, or finds the stop that this one repeats.
///
/// # Errors
/// The key is too long.
pub(crate) fn begin(state: &AppState, vessel: Address, by: Issuer, key: &str) -> Result<Stop, ApiError> {
    if key.len() > KEY_BYTES || by.window.len() > KEY_BYTES {
        return Err(ApiError::bad_request(format!("key and window have {KEY_BYTES} bytes at most")));
    }
    let (told, stop) = match state.stops.note(vessel, &by, key, state.clock.mono()) {
        Noted::Repeated(stop) => return Ok(stop),
        Noted::New { told, stop } => (told, stop),
    };
    let state = state.clone();
    state.tasks.clone().spawn(async move {
        let outcome = carry_out(&state, vessel, &by).await;
        told.send_replace(Some(outcome));
    });
    Ok(stop)
}

enum Noted {
    Repeated(Stop),
    New { told: watch::Sender<Option<Outcome>>, stop: Stop },
}

impl Stops {
    fn note(&self, vessel: Address, by: &Issuer, key: &str, now: MonoTime) -> Noted {
        // What a panic left behind is still a list of stops.
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
            // One that failed was tried again under the same name.
            if self.by_name.get(&name).is_some_and(|(known, _)| *known == id) {
                self.by_name.remove(&name);
            }
        }
    }
}

/// Has the vessel stopped by the one way down, as soon as the hub is free. That it was asked for, and how far it gets,
/// is written into the audit log afterwards, whenever the disk takes it.
async fn carry_out(state: &AppState, vessel: Address, by: &Issuer) -> Outcome {
    let asked = by.asked();
    let give = move |hub: &mut Hub, now| -> Result<Ordered, String> {
        let id = hub.commands_mut().begin(now, vessel, &asked, 0, Order::Stop)?;
        let (reached, waits) = match orders::dispatch(hub, now, id, vessel, None) {
            Some(Dispatched::Sent(_)) => (true, false),
            Some(Dispatched::Waits(doors)) => (!doors.is_empty(), true),
            Some(Dispatched::Refused(_)) | None => (false, false),
        };
        Ok(Ordered { id: id.0, time_us: now.utc.micros(), reached, waits })
    };
    state.people.note(Line {
        actor: by.who.actor(),
        address: by.from.clone(),
        action: Order::Stop.verb(),
        subject: vessel.to_string(),
        outcome: "asked".to_owned(),
    });
    let given = state.relay.look_first(give).await.map_err(|_| ApiError::stopping())?;
    let (reached, waits) = given.as_ref().map_or((false, false), |ordered| (ordered.reached, ordered.waits));
    tracing::warn!(%vessel, person = by.who.name, reached, waits, "stop");
    given.map_err(orders::unprocessable)
}
