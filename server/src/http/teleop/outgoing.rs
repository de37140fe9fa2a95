//! What goes to a vessel that is steered by hand, and by which door.

use crate::http::control::running;
use hub::{Door, Hub, Outgoing, Sticks, TELEOPERATION_PLAN};
use imc::messages::{Message, RemoteActions, TeleoperationDone};
use imc::{Address, Header, Packet};

/// Stick positions as a vessel understands them.
pub(super) fn keys(sticks: &Sticks) -> Message {
    RemoteActions { actions: sticks.actions().as_str().into() }.into()
}

/// Sends something by the door that leads to the vessel. What has to go by the link is given back.
pub(super) fn dispatch(
    hub: &mut Hub,
    now: hub::Now,
    (vessel, epoch): (Address, u64),
    message: Message,
    sent_s: f64,
    link: Option<bool>,
) -> Option<Outgoing> {
    let header =
        Header { timestamp: sent_s, src: hub.address(), src_ent: u8::MAX, dst: vessel, dst_ent: u8::MAX };
    let packet = Packet::new(header, message).encode().ok()?.into();
    if by_link(hub, now, vessel, link) {
        hub.record_own(now, &packet);
        return Some(Outgoing { epoch, packet });
    }
    hub.send(now, &packet);
    None
}

/// Lets go a vessel of which control was lost. One that is reached by another way than its link knows of no control and
/// goes on with the last stick position: it is stopped. Each is told that it is not steered by hand any more, in the name
/// of whoever has control now. One that does something else by now is left alone.
pub(super) fn release(
    hub: &mut Hub,
    now: hub::Now,
    vessel: Address,
    stop: Option<&Sticks>,
    link: Option<bool>,
) -> Option<Outgoing> {
    running(hub, vessel).filter(|plan| plan == TELEOPERATION_PLAN)?;
    if let Some(stop) = stop.filter(|_| !by_link(hub, now, vessel, link)) {
        dispatch(hub, now, (vessel, 0), keys(stop), now.utc.seconds(), link);
    }
    let epoch = hub.leases().of(vessel).held.as_ref().map_or(0, |held| held.epoch);
    dispatch(hub, now, (vessel, epoch), TeleoperationDone.into(), now.utc.seconds(), link)
}

/// Whether what a vessel gets goes by its link.
fn by_link(hub: &Hub, now: hub::Now, vessel: Address, link: Option<bool>) -> bool {
    let elsewhere = hub.doors_to(now.mono, vessel).any(|door| door != Door::Link);
    link == Some(true) || (link.is_some() && !elsewhere)
}
