//! Whose orders the vessel obeys.
//!
//! Ashore one person at a time commands a vessel, by a lease with an epoch that grows with every grant. While the
//! vessel knows of a valid lease, it obeys orders that carry this epoch and refuses all others, by whatever
//! transport and from whatever console they come; so an order of a former holder is void however late it arrives. An
//! Abort is never refused. A lease expires when the shore has not renewed it within its time to live: then consoles
//! command as if there were no shore.

use imc::messages::{Message, PlanControlOp, PlanControlType, PlanDBOp, PlanDBType, VehicleCommandType};
use std::time::Duration;
use units::MonoTime;

/// No lease is valid longer than this without renewal.
const LONGEST: Duration = Duration::from_mins(5);
/// Refusals that follow each other within this are one burst.
const BURST: Duration = Duration::from_secs(10);

/// Under what a packet of the shore comes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Mandate {
    /// The epoch of the lease; 0 for none.
    pub lease: u64,
    /// The number of the command ashore, by which logs name it; 0 for none.
    pub command: u64,
}

/// Who commands the vessel, as reported by the shore.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Lease {
    /// Grows with every grant.
    pub epoch: u64,
    /// How long it is valid unless it is repeated; zero ends it.
    pub lasts: Duration,
    /// The holder's name.
    pub holder: String,
}

/// Why an order is refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NotObeyed {
    /// The lease is held, and not by the sender.
    #[error("refused: {0} has control of this vessel from ashore; ask there, or abort")]
    Another(String),
    /// It was given under a lease that has ended.
    #[error("refused: this order was given under a lease that has ended; take control again")]
    Ended,
}

/// The lease as the vessel knows it.
#[derive(Debug, Clone, Default)]
pub struct LeaseGate {
    /// The greatest epoch heard of.
    newest: u64,
    holder: String,
    /// When the newest dies; none when it was ended.
    until: Option<MonoTime>,
    refused: Option<MonoTime>,
}

impl LeaseGate {
    /// The shore reports who commands. Returns whether that is another than before; an older lease than the newest is
    /// ignored.
    pub fn told(&mut self, now: MonoTime, lease: &Lease) -> bool {
        if lease.epoch < self.newest {
            return false;
        }
        let before = self.holder(now).map(str::to_owned);
        self.newest = lease.epoch;
        self.holder = lease.holder.chars().take(100).collect();
        self.until = (!lease.lasts.is_zero()).then(|| now + lease.lasts.min(LONGEST));
        before.as_deref() != self.holder(now)
    }

    /// Who commands; `None` when the lease is not held.
    pub fn holder(&self, now: MonoTime) -> Option<&str> {
        self.until.is_some_and(|until| now < until).then_some(self.holder.as_str())
    }

    /// Whether a message that came under a lease (0 for none) may be acted upon.
    ///
    /// # Errors
    /// Why not.
    pub fn admit(&self, now: MonoTime, lease: u64, message: &Message) -> Result<(), NotObeyed> {
        if !is_order(message) {
            return Ok(());
        }
        match self.holder(now) {
            Some(_) if lease == self.newest => Ok(()),
            None if lease == 0 => Ok(()),
            Some(holder) if lease == 0 => Err(NotObeyed::Another(holder.to_owned())),
            Some(_) | None => Err(NotObeyed::Ended),
        }
    }

    /// Notes a refusal; answers whether it is the first of a burst, and so worth a line.
    pub(crate) fn is_news(&mut self, now: MonoTime) -> bool {
        let last = self.refused.replace(now);
        last.is_none_or(|last| now.since(last) >= BURST)
    }
}

/// Whether a message commands the vessel that it is addressed to. An Abort is not an order in this sense: any user may
/// stop a vessel.
pub fn is_order(message: &Message) -> bool {
    match message {
        Message::PlanControl(request) => {
            request.r#type == PlanControlType::Request && request.op != PlanControlOp::Get
        }
        Message::PlanDB(request) => {
            let writes =
                matches!(request.op, PlanDBOp::Set | PlanDBOp::Del | PlanDBOp::Clear | PlanDBOp::Boot);
            request.r#type == PlanDBType::Request && writes
        }
        Message::VehicleCommand(command) => command.r#type == VehicleCommandType::Request,
        Message::RemoteActions(_)
        | Message::TeleoperationDone(_)
        | Message::StopManeuver(_)
        | Message::Reference(_)
        | Message::SetEntityParameters(_)
        | Message::SaveEntityParameters(_)
        | Message::PushEntityParameters(_)
        | Message::PopEntityParameters(_)
        | Message::ControlLoops(_)
        | Message::DesiredHeading(_)
        | Message::DesiredZ(_)
        | Message::DesiredSpeed(_)
        | Message::DesiredRoll(_)
        | Message::DesiredPitch(_)
        | Message::DesiredVerticalRate(_)
        | Message::DesiredPath(_)
        | Message::DesiredControl(_)
        | Message::DesiredHeadingRate(_)
        | Message::DesiredVelocity(_)
        | Message::DesiredLinearState(_)
        | Message::DesiredThrottle(_)
        | Message::SetThrusterActuation(_)
        | Message::SetServoPosition(_)
        | Message::SetControlSurfaceDeflection(_)
        | Message::PowerChannelControl(_)
        | Message::RestartSystem(_) => true,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use imc::messages::{Abort, PlanControl, PlanDB};

    fn at(seconds: u64) -> MonoTime {
        MonoTime::from_micros(seconds * 1_000_000)
    }

    fn lease(epoch: u64, seconds: u64) -> Lease {
        Lease { epoch, lasts: Duration::from_secs(seconds), holder: format!("holder {epoch}") }
    }

    fn start() -> Message {
        PlanControl { r#type: PlanControlType::Request, ..PlanControl::default() }.into()
    }

    #[test]
    fn while_a_lease_lives_only_its_orders_are_obeyed() {
        let mut gate = LeaseGate::default();
        assert_eq!(gate.admit(at(0), 0, &start()), Ok(()));
        assert_eq!(gate.admit(at(0), 5, &start()), Err(NotObeyed::Ended), "it was never told of this one");
        assert!(gate.told(at(0), &lease(7, 30)));
        assert!(!gate.told(at(10), &lease(7, 30)));
        assert_eq!(gate.admit(at(39), 7, &start()), Ok(()));
        assert_eq!(gate.admit(at(39), 0, &start()), Err(NotObeyed::Another("holder 7".to_owned())));
        assert_eq!(gate.admit(at(39), 6, &start()), Err(NotObeyed::Ended));
        assert_eq!(gate.admit(at(39), 0, &Abort.into()), Ok(()));
        let list = PlanDB { r#type: PlanDBType::Request, op: PlanDBOp::GetState, ..PlanDB::default() };
        assert_eq!(gate.admit(at(39), 0, &list.into()), Ok(()), "who only asks is answered");
        // The shore is silent: the lease dies, and so do orders under it.
        assert_eq!(gate.admit(at(40), 0, &start()), Ok(()));
        assert_eq!(gate.admit(at(40), 7, &start()), Err(NotObeyed::Ended));
    }

    #[test]
    fn an_older_lease_does_not_come_back() {
        let mut gate = LeaseGate::default();
        gate.told(at(0), &lease(7, 30));
        assert!(gate.told(at(1), &lease(8, 30)));
        assert!(!gate.told(at(2), &lease(7, 30)));
        assert_eq!(gate.admit(at(2), 7, &start()), Err(NotObeyed::Ended));
        // Its end is reported: orders that were on their way are void at once.
        assert!(gate.told(at(3), &lease(8, 0)));
        assert_eq!(gate.admit(at(3), 8, &start()), Err(NotObeyed::Ended));
        assert_eq!((gate.holder(at(3)), gate.admit(at(3), 0, &start())), (None, Ok(())));
    }

    #[test]
    fn a_burst_of_refusals_is_one_piece_of_news() {
        let mut gate = LeaseGate::default();
        let told: Vec<u64> = [0, 1, 9, 18, 40, 41].into_iter().filter(|s| gate.is_news(at(*s))).collect();
        assert_eq!(told, [0, 40]);
    }
}
