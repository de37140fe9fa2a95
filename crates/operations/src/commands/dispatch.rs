//! Queries and reports of the hub's downlink about orders.

use super::{Commands, Effect, Stage, Step};
use hub::{CommandId, Dispatched, OrderLog, Transport};
use imc::PacketView;
use units::Now;

impl OrderLog for Commands {
    fn heard(&mut self, now: Now, view: &PacketView<'_>) {
        self.evidence(now, view);
    }

    fn dispatched(&mut self, now: Now, id: CommandId, dispatched: &Dispatched) {
        match dispatched {
            Dispatched::Sent(transports) => self.sent(now, id, &by(transports)),
            Dispatched::Waits(transports) => {
                let text = match &**transports {
                    [] => "no way leads to the vessel; it is sent as soon as the vessel is heard".to_owned(),
                    transports => {
                        let by = by(transports);
                        format!(
                            "sent {by}, where the vessel was not heard lately; again as soon as it is heard"
                        )
                    }
                };
                self.advance(now, id, Stage::Waiting, text);
                if let Some(command) = self.all.get_mut(&id).filter(|_| !transports.is_empty()) {
                    // It did perhaps arrive: what the vessel says from here on may be its effect.
                    command.sent = Some(now.mono);
                }
            }
            Dispatched::Refused(why) => self.refused(now, id, (*why).to_owned()),
        }
    }

    fn sent_again(&mut self, now: Now, id: CommandId, transports: &[Transport]) {
        if let Some(command) = self.all.get_mut(&id) {
            // The vessel's messages from here on are evidence as after the first time.
            command.timed_out = None;
            self.step(now, id, Stage::Sent, format!("again {}", by(transports)));
        }
    }

    fn overtaken(&mut self, now: Now, id: CommandId) {
        let text = "something was started after it: it is not given again";
        self.advance(now, id, Stage::TimedOut, text.to_owned());
    }

    fn is_unconfirmed(&self, id: CommandId) -> bool {
        let shown =
            |step: &Step| matches!(step.stage, Stage::Received | Stage::Executing | Stage::EffectSeen);
        self.all.get(&id).is_some_and(|command| !command.steps.iter().any(shown))
    }

    fn is_void(&self, id: CommandId) -> bool {
        self.all.get(&id).is_some_and(|command| matches!(command.stage(), Stage::Refused | Stage::Expired))
    }

    fn starts(&self, id: CommandId) -> bool {
        self.all.get(&id).is_some_and(|command| matches!(command.effect, Effect::Runs(_)))
    }

    fn refused(&mut self, now: Now, id: CommandId, why: &str) {
        Self::refused(self, now, id, why.to_owned());
    }

    fn expired(&mut self, now: Now, id: CommandId) {
        let text = "no way led to the vessel in time; it will not get it any more".to_owned();
        self.advance(now, id, Stage::Expired, text);
    }
}

impl Commands {
    /// It is on its way.
    pub fn sent(&mut self, now: Now, id: CommandId, by: &str) {
        self.advance(now, id, Stage::Sent, by.to_owned());
    }
}

/// By which transports an order went, in words.
fn by(transports: &[Transport]) -> String {
    let names: Vec<&str> = transports.iter().map(|transport| transport.name()).collect();
    format!("by {}", names.join(" and "))
}
