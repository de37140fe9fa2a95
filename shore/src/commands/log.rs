//! Writes into the audit log how far commands get, and what happens to leases by itself.

use super::Commands;
use crate::identity::Line;
use operations::{Change, CommandEvent, LeaseEvent, Operations};
use std::time::Duration;
use tokio_util::sync::CancellationToken;

/// What happened is fetched at least so often; at once, when something did.
const EVERY: Duration = Duration::from_secs(1);

impl Commands {
    /// Writes until the server ends.
    pub(crate) async fn keep_log(self, stop: CancellationToken) {
        let mut changed = self.router.revision();
        loop {
            let happened = async {
                // Without a hub nothing happens any more.
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
                self.people.note(of_command(event));
            }
            if ends {
                return;
            }
        }
    }
}

fn of_command(event: CommandEvent) -> Line {
    let CommandEvent { vessel, by, verb, subject, step } = event;
    let stage = step.stage.name();
    let text = step.in_full();
    tracing::info!(%vessel, actor = by.actor, verb, subject, stage, text, "command");
    let outcome = if text.is_empty() { stage.to_owned() } else { format!("{stage}: {text}") };
    let subject = format!("{vessel} {subject}");
    Line { actor: by.actor, address: by.from, action: verb, subject, outcome }
}

/// What happened to a lease by itself; what somebody asked for is written down where they ask.
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
