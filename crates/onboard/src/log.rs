//! The log that is open, and requests for another.

use crate::bus::{Asker, Bus};
use crate::discovery;
use crate::entity::{Entity, Labels};
use crate::output::{Level, Output};
use crate::states::{Condition, States};
use imc::messages::{LoggingControl, LoggingControlOp};

/// The open log.
#[derive(Debug, Default)]
pub(crate) struct Log {
    name: String,
}

impl Log {
    /// Another log on request, or the name of the open one.
    pub(crate) fn request(&self, bus: &mut Bus, asker: Asker, request: &LoggingControl) {
        match request.op {
            LoggingControlOp::RequestStart => {
                let (label, utc) = (request.name.to_str_lossy().into_owned(), bus.utc());
                bus.put(Output::OpenLog { label, utc });
            }
            LoggingControlOp::RequestCurrentName => {
                let name = self.name.as_str().into();
                let reply = LoggingControl { op: LoggingControlOp::CurrentName, name };
                bus.send_to(Entity::Logger, asker, &reply);
            }
            _ => {}
        }
    }

    /// A log was opened under this name, or could not be.
    pub(crate) fn opened(
        &mut self,
        bus: &mut Bus,
        states: &mut States,
        labels: &Labels,
        outcome: Result<String, String>,
    ) {
        match outcome {
            Ok(name) => {
                // A log explains itself: whose numbers are whose.
                let own = Asker { system: bus.address(), entity: Entity::Logger.number() };
                discovery::entity_list(bus, own, labels);
                discovery::all_entities(bus, own, labels);
                states.set(bus, Entity::Logger, Condition::Normal, name.clone());
                self.name = name;
            }
            Err(reason) => {
                let text = format!("no log is written: {reason}");
                bus.console(Level::Error, text.clone());
                states.set(bus, Entity::Logger, Condition::Error, text);
            }
        }
    }
}
