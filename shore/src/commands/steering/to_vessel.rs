//! Messages to a vessel that is steered by hand, and their transport.

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

/// Sends stick positions, or the end of teleoperation, by the route to the vessel: within `life`, or never.
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
    let tag = Tag { id: None, is_copy: false, epoch, expires: now.mono + life, urgency: Urgency::Sticks };
    // Without a route it is dropped: it would be stale a moment later.
    operations.hub_mut().dispatch(now, Telecommand { vessel, tag, packet: packet.into() });
}

/// Releases a vessel of which control was lost. A vessel that is not reached over its link does not know of leases and
/// would continue with the last stick position: it is stopped. Both are sent the end of teleoperation in the name of the
/// new controller. A vessel that does something else by now is left alone.
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
