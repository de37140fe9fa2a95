//! The only entry for orders to vessels: from pages, programs, the demo and tests.
//!
//! An order is checked for role (by the caller), grounding and lease, written into the audit log, and sent by the hub's
//! downlink. Each order is carried out by a task of the shore, so that it is completed even if the requester disconnects.
//! The audit log has the request before it is sent; its progress (sent, received, effect, or failure) is written as it
//! happens (`log`), and so are automatic changes of control.

pub mod grounding;
mod helms;
mod log;
pub mod steering;
mod stop;
pub mod view;

pub use grounding::Grounding;
pub use helms::{Helm, Helms};
pub use stop::{Stop, Stops};

use crate::error::{Error, Result};
use crate::identity::{Fault, Line, People, Principal};
use crate::known::one_vessel;
use crate::router::Router;
use api::{Command, Lease, PlansAboard, say};
use hub::CommandId;
use imc::Address;
use operations::{Holder, LeaseRefused, LeaseRequest, Operations, Order};
use std::time::Duration;
use tokio::sync::oneshot;
use tokio_util::task::TaskTracker;

/// How long an order other than a stop waits for the audit log.
const AUDIT_PATIENCE: Duration = Duration::from_secs(5);
/// Most commands of a vessel in one answer.
const LATEST: usize = 100;

/// Who gives an order, and from where.
#[derive(Debug, Clone)]
pub struct Issuer {
    /// The person.
    pub who: Principal,
    /// The network address, for the audit log.
    pub from: String,
    /// Which of the person's windows.
    pub window: String,
}

impl Issuer {
    /// As commands record the issuer.
    pub fn ordered_by(&self) -> operations::OrderedBy {
        operations::OrderedBy {
            name: self.who.name.clone(),
            actor: self.who.actor(),
            from: self.from.clone(),
        }
    }

    /// As leases record the holder.
    pub fn holder(&self) -> Holder {
        Holder { person: self.who.person, name: self.who.name.clone(), key: self.window.clone() }
    }
}

/// The command service; cheap to clone.
#[derive(Clone)]
pub struct Commands {
    router: Router,
    people: People,
    grounding: Grounding,
    stops: Stops,
    tasks: TaskTracker,
}

impl Commands {
    pub(crate) fn new(router: Router, people: People, grounding: Grounding, tasks: TaskTracker) -> Self {
        Self { router, people, grounding, stops: Stops::default(), tasks }
    }

    /// The lease of a vessel.
    ///
    /// # Errors
    /// The server is stopping.
    pub async fn lease(&self, vessel: Address) -> Result<Lease> {
        let ask = move |operations: &mut Operations, _| view::lease(vessel, operations.leases().of(vessel));
        Ok(self.router.ask(ask).await?)
    }

    /// Takes, releases or transfers control. The lease is in memory and logged afterwards, so that control can be taken
    /// even while the disk hangs.
    ///
    /// # Errors
    /// Another user has control, or the address is not that of one vessel.
    pub async fn ask_lease(
        &self,
        vessel: Address,
        by: Issuer,
        ask: LeaseRequest,
        reason: &str,
    ) -> Result<Lease> {
        one_vessel(vessel)?;
        let subject = if reason.is_empty() { vessel.to_string() } else { format!("{vessel}: {reason}") };
        let action = match ask {
            LeaseRequest::Request(_) => Some("lease.request"),
            LeaseRequest::Grant => Some("lease.grant"),
            LeaseRequest::Decline => Some("lease.decline"),
            LeaseRequest::Release => Some("lease.release"),
            // A renewal by an open page is not a user action.
            LeaseRequest::Renew => None,
            LeaseRequest::Take(_) => Some("lease.take"),
        };
        let holder = by.holder();
        let change = move |operations: &mut Operations, now| {
            operations.leases_mut().ask(now, vessel, &holder, ask)?;
            Ok::<_, LeaseRefused>(view::lease(vessel, operations.leases().of(vessel)))
        };
        let changed = self.router.ask(change).await?;
        if let Some(action) = action {
            let outcome = changed.as_ref().map_or_else(ToString::to_string, |_| "done".to_owned());
            self.people.note(Line { actor: by.who.actor(), address: by.from, action, subject, outcome });
        }
        Ok(changed?)
    }

    /// The latest commands of a vessel, the newest first.
    ///
    /// # Errors
    /// The server is stopping.
    pub async fn latest(&self, vessel: Address) -> Result<Vec<Command>> {
        let ask = move |operations: &mut Operations, _| {
            operations.commands().of(vessel).take(LATEST).map(view::command).collect()
        };
        Ok(self.router.ask(ask).await?)
    }

    /// One command of a vessel, with what the vessel answered; `None` when it is not known any more.
    ///
    /// # Errors
    /// The server is stopping.
    pub async fn one(&self, vessel: Address, id: u64) -> Result<Option<Command>> {
        let ask = move |operations: &mut Operations, _| {
            operations.commands().get(CommandId(id)).filter(|one| one.vessel == vessel).map(view::whole)
        };
        Ok(self.router.ask(ask).await?)
    }

    /// The plans that a vessel stores, as far as it reported them.
    ///
    /// # Errors
    /// The server is stopping.
    pub async fn plans_aboard(&self, vessel: Address) -> Result<PlansAboard> {
        let ask = move |operations: &mut Operations, _| view::aboard(operations.commands().aboard(vessel));
        Ok(self.router.ask(ask).await?)
    }

    /// Gives a vessel an order: refused where the chart shows danger and without the lease, written into the audit log,
    /// sent by the route to the vessel. It is carried out even if the requester does not wait; its later stages report the
    /// outcome.
    ///
    /// # Errors
    /// The order is not valid, another user has control, or the audit log cannot be written.
    pub async fn issue(&self, vessel: Address, by: &Issuer, order: Order) -> Result<Command> {
        let (told, outcome) = oneshot::channel();
        let (service, by) = (self.clone(), by.clone());
        self.tasks.spawn(async move {
            // The requester may be gone.
            told.send(service.carry_out(vessel, &by, order).await).ok();
        });
        outcome.await.unwrap_or_else(|_| Err(Error::internal(&"an order ended without a word")))
    }

    async fn carry_out(&self, vessel: Address, by: &Issuer, order: Order) -> Result<Command> {
        let verb = order.verb();
        let stops = self.router.ask(move |operations, _| operations.commands().stops(vessel)).await?;
        let subjects = self.subjects(vessel, &order).await?;
        if let Some(danger) = self.grounding.danger(vessel, &order).await? {
            self.note_refused(by, verb, &subjects, &danger.text);
            return Err(danger);
        }
        let (holder, asked) = (by.holder(), by.ordered_by());
        let begin = move |operations: &mut Operations, now| {
            operations.begin(now, vessel, (&asked, &holder), order, stops)
        };
        let id = match self.router.ask(begin).await? {
            Ok(id) => id,
            Err(why) => {
                self.note_refused(by, verb, &subjects, &why.to_string());
                return Err(why.into());
            }
        };
        tracing::info!(command = id.0, %vessel, actor = by.who.actor(), verb, subjects = ?subjects, "a command is issued");
        let named: Vec<String> = subjects.iter().map(|subject| log::of_command(subject, id)).collect();
        if let Err(fault) = self.write_asked(by, verb, &named).await {
            tracing::error!(command = id.0, %vessel, verb, %fault, "an order is not sent: the audit log cannot be written");
            let why = say("NOT SENT: the audit log cannot be written");
            let refuse = move |operations: &mut Operations, now| {
                operations.commands_mut().refused(now, id, why);
            };
            self.router.ask(refuse).await?;
            let text = say(
                "NOT SENT: the audit log cannot be written, and nothing is ordered without it. Try again; STOP works.",
            );
            return Err(Error { text: text.into(), ..Error::from(fault) });
        }
        let holder = by.holder();
        let send = move |operations: &mut Operations, now| {
            operations.dispatch(now, id, Some(&holder));
            operations.commands().get(id).map(view::command)
        };
        let command = self.router.ask(send).await?;
        command.ok_or_else(|| Error::internal(&"a command was forgotten while it was open"))
    }

    /// The subjects of an order for the audit log: one for each parameter, with its previous value.
    async fn subjects(&self, vessel: Address, order: &Order) -> Result<Vec<String>> {
        let subjects = if let Order::SetParameters { .. } = order {
            let order = order.clone();
            let ask = move |operations: &mut Operations, _| operations.commands().subjects(vessel, &order);
            self.router.ask(ask).await?
        } else {
            vec![order.subject()]
        };
        Ok(subjects.into_iter().map(|subject| format!("{vessel} {subject}")).collect())
    }

    fn note_refused(&self, by: &Issuer, action: &'static str, subjects: &[String], why: &str) {
        for subject in subjects {
            let (actor, address) = (by.who.actor(), by.from.clone());
            let (subject, outcome) = (subject.clone(), why.to_owned());
            self.people.note(Line { actor, address, action, subject, outcome });
        }
    }

    /// Writes into the audit log that an order was asked for.
    async fn write_asked(
        &self,
        by: &Issuer,
        action: &'static str,
        subjects: &[String],
    ) -> std::result::Result<(), Fault> {
        let line = |subject: &String| {
            let (actor, address) = (by.who.actor(), by.from.clone());
            Line { actor, address, action, subject: subject.clone(), outcome: "asked".to_owned() }
        };
        self.people.record(subjects.iter().map(line).collect(), AUDIT_PATIENCE).await
    }
}
