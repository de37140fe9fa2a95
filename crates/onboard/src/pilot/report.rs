//! The condition of path control and manual control, as their entities' states.

use super::Pilot;
use crate::bus::Bus;
use crate::entity::Entity;
use crate::states::{Condition, States};
use mission::Drive;

impl Pilot {
    /// Sets the states of path control and manual control; an operator's messages may be `silence_s` apart.
    pub(crate) fn report(&self, bus: &mut Bus, states: &mut States, silence_s: f64) {
        let (condition, text) = match (self.fault(), self.strays_until()) {
            (Some(fault), _) => (Condition::Error, fault.to_string()),
            (None, Some(until)) => {
                let left_s = until.since(bus.mono()).as_secs();
                (Condition::Fault, format!("too far from the track; steers back, fails in {left_s} s"))
            }
            (None, None) => (Condition::Normal, "active".to_owned()),
        };
        states.set(bus, Entity::Path, condition, text);
        let text = match (self.drive(), self.is_connected()) {
            (Drive::Teleoperation(_), true) => {
                format!("an operator steers; motors stop {silence_s:.1} s after the last message")
            }
            (Drive::Teleoperation(_), false) => "waiting for the operator; motors stopped".to_owned(),
            (Drive::Off | Drive::Path, _) => "inactive".to_owned(),
        };
        states.set(bus, Entity::Remote, Condition::Normal, text);
    }
}
