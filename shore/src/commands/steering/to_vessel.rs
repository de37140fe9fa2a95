//! What goes to a vessel that is steered by hand, and by which transport.

use super::STOP_LASTS;
use hub::{Tag, Telecommand, Urgency};
use imc::messages::{Message, RemoteActions, TeleoperationDone};
use imc::{Address, Header, Packet};
use operations::{Operations, Sticks, TELEOPERATION_PLAN};
use std::time::Duration;
use units::Now;

/// Stick positions as a vessel understands them.
pub(super) fn keys(sticks: &Sticks) -> Message {
    RemoteActions { actions: sticks.actions().as_str().into() }.into()
}

/// Sends stick positions, or the word that steering by hand is over, by the way that leads to the vessel. Within
/// `life`, or never.
pub(super) fn dispatch(
    operations: &mut Operations,
    now: Now,
    (vessel, epoch): (Address, u64),
    message: Message,
    sent_s: f64,
    life: Duration,
) {
    let header = Header {
        timestamp: sent_s,
        src: operations.hub().address(),
        src_ent: u8::MAX,
        dst: vessel,
        dst_ent: u8::MAX,
    };
    let Ok(packet) = Packet::new(header, message).encode() else { return };
    let tag = Tag { id: None, epoch, expires: now.mono + life, urgency: Urgency::Sticks };
    // What finds no way is worth nothing a moment later.
    operations.hub_mut().dispatch(now, Telecommand { vessel, tag, packet: packet.into() });
}

/// Lets go a vessel of which control was lost. One that is reached by another way than its link knows of no control and
/// goes on with the last stick position: it is stopped. Each is told that it is not steered by hand any more, in the name
/// of whoever has control now. One that does something else by now is left alone.
pub(super) fn release(operations: &mut Operations, now: Now, vessel: Address, stop: Option<&Sticks>) {
    if operations.running(vessel).is_none_or(|plan| plan != TELEOPERATION_PLAN) {
        return;
    }
    if let Some(stop) = stop.filter(|_| !operations.hub().goes_by_link(now.mono, vessel)) {
        dispatch(operations, now, (vessel, 0), keys(stop), now.utc.seconds(), STOP_LASTS);
    }
    let epoch = operations.leases().of(vessel).held.as_ref().map_or(0, |held| held.epoch);
    dispatch(operations, now, (vessel, epoch), TeleoperationDone.into(), now.utc.seconds(), STOP_LASTS);
}
