//! Writes the stages of commands, and automatic changes of leases, into the audit log.

use super::Commands;
use crate::identity::Line;
use hub::CommandId;
use operations::{Change, CommandEvent, LeaseEvent, Operations};
use std::time::Duration;
use tokio_util::sync::CancellationToken;

/// Events are fetched at least this often, and at once when there are any.
const EVERY: Duration = Duration::from_secs(1);

impl Commands {
    /// Writes until the server ends.
    pub(crate) async fn keep_log(self, stop: CancellationToken) {
        let mut changed = self.router.revision();
        loop {
            let happened = async {
                // Without a hub there are no more events.
                if changed.changed().await.is_err() {
                    std::future::pending::<()>().await;
                }
            };
            let ends = tokio::select! {
                () = stop.cancelled() => true,
                () = happened => false,
                () = tokio::time::sleep(EVERY) => false,
            };
            let drain = |operations: &mut Operations, _| {
                (operations.leases_mut().drain(), operations.commands_mut().drain())
            };
            let Ok(((leases, leases_lost), (commands, commands_lost))) = self.router.ask(drain).await else {
                return;
            };
            if leases_lost + commands_lost > 0 {
                tracing::error!(leases_lost, commands_lost, "what happened is not all in the audit log");
            }
            for event in leases {
                tracing::info!(vessel = %event.vessel, change = event.change.name(), who = event.who, "control");
                if let Some(line) = of_lease(event) {
                    self.people.note(line);
                }
            }
            for event in commands {
                self.people.note(line_of(event));
            }
            if ends {
                return;
            }
        }
    }
}

/// Most characters of a subject before the number, which must not be cut off: the audit log takes 500 in all.
const SUBJECT: usize = 460;

/// The subject of a line about a command: the number is its end.
pub(super) fn of_command(subject: &str, id: CommandId) -> String {
    let shown: String = subject.trim_end().chars().take(SUBJECT).collect();
    format!("{shown} [command {id}]")
}

fn line_of(event: CommandEvent) -> Line {
    let CommandEvent { id, vessel, by, verb, subject, step } = event;
    let stage = step.stage.name();
    let text = step.in_full().to_string();
    tracing::info!(command = id.0, %vessel, actor = by.actor, verb, subject, stage, text, "command");
    let outcome = if text.is_empty() { stage.to_owned() } else { format!("{stage}: {text}") };
    let subject = of_command(&format!("{vessel} {subject}"), id);
    Line { actor: by.actor, address: by.from, action: verb, subject, outcome }
}

/// An automatic change of a lease; requested changes are logged where they are requested.
fn of_lease(event: LeaseEvent) -> Option<Line> {
    let action = match event.change {
        Change::Expired => "lease.expired",
        Change::Unanswered => "lease.unanswered",
        Change::Granted => "lease.granted",
        Change::Requested
        | Change::HandedOver
        | Change::Declined
        | Change::Withdrawn
        | Change::Released
        | Change::TakenOver => return None,
    };
    let (subject, outcome) = (event.vessel.to_string(), "done".to_owned());
    Some(Line { actor: event.who, address: String::new(), action, subject, outcome })
}
