//! The downlink: orders of people and programs go to their vessel by the transport that leads there.
//!
//! Every order has a number, the epoch of the lease that it is given under, an end of its life, and an urgency. It goes by
//! the vessel's link while that is open, else by the best of the other ways. Without a way it waits here until its life
//! ends, and is sent when the vessel is heard again.
//!
//! A stop is sent by every way, ahead of everything that waits, and cancels earlier orders that are not sent yet: a start
//! that arrives after the stop that was meant to end it would be worse than none. Sent does not mean arrived. So until
//! the vessel shows that it has the stop, it is kept and sent again when the vessel is heard: after a silence, when a
//! connection that took it has ended, when the link is open again, and from time to time. A start after the stop ends
//! this, unless the start is not carried out. What an operator starts by a radio of their own is not known here.
//!
//! | urgency | without a way | life |
//! |---|---|---|
//! | stop | waits | [`STOP_LIFE`] |
//! | command | waits if the vessel has a link, else it is refused | [`TIME_TO_LIVE`] |
//! | sticks | is dropped: newer ones follow | as long as the operator's sample is valid |

use crate::delivery::{CommandId, Delivery, Tag, Urgency};
use crate::{Hub, PeerId, Transport};
use bytes::Bytes;
use imc::messages::{
    Payload as _, PlanControl, PlanControlOp, PlanControlType, VehicleCommand, VehicleCommandCommand,
    VehicleCommandType,
};
use imc::{Address, PacketView};
use std::collections::BTreeMap;
use std::time::Duration;
use units::{MonoTime, Now};

/// A packet that is not delivered within this is not delivered at all.
pub const TIME_TO_LIVE: Duration = Duration::from_secs(10);
/// Why an order is not sent after a stop.
pub const CALLED_OFF: &str = "a stop was ordered before it could be sent";
/// A stop is worth delivering for as long as this.
pub const STOP_LIFE: Duration = Duration::from_mins(10);
/// A copy of a stop that was passed to a connection lives as long as any order: a later copy could end what an operator
/// started after the stop. The stop itself is kept here and sent again.
const COPY_LIFE: Duration = TIME_TO_LIVE;
/// Orders that may wait for one vessel; one more is refused, except a stop, which cancels all others.
const WAITING: usize = 20;
/// Vessels for which orders may wait, and of which a stop is kept.
const VESSELS: usize = 1_024;
/// A vessel that is heard after this long may have missed what was sent meanwhile: vessels send each second.
/// One that is heard all the time without evidence of the stop gets it again after as long, then after twice that.
const SILENCE: Duration = Duration::from_secs(3);

/// An order for a vessel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Telecommand {
    /// To whom.
    pub vessel: Address,
    /// Its data as an order.
    pub tag: Tag,
    /// The packet.
    pub packet: Bytes,
}

/// The result of giving an order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Dispatched {
    /// It is on its way by these transports.
    Sent(Vec<Transport>),
    /// It waits until its vessel is heard or its life ends. It was given to these transports all the same, where the vessel
    /// was not heard lately.
    Waits(Vec<Transport>),
    /// There is no way, for this reason.
    Refused(&'static str),
}

/// Where orders are followed to their end. The downlink asks it what is known of an order, and reports its progress on
/// the way down.
pub trait OrderLog {
    /// A live packet came from a vessel, before the downlink acts on it: it may be evidence.
    fn heard(&mut self, now: Now, view: &PacketView<'_>);
    /// Whether there is no evidence yet that the vessel has it.
    fn is_unconfirmed(&self, id: CommandId) -> bool;
    /// Whether the vessel did not carry it out and will not.
    fn is_void(&self, id: CommandId) -> bool;
    /// Whether it has the vessel begin something.
    fn starts(&self, id: CommandId) -> bool;
    /// The result of giving it to the transports.
    fn dispatched(&mut self, now: Now, id: CommandId, dispatched: &Dispatched);
    /// It was sent again, for lack of evidence that the vessel has it.
    fn sent_again(&mut self, now: Now, id: CommandId, transports: &[Transport]);
    /// It is not sent.
    fn refused(&mut self, now: Now, id: CommandId, why: &'static str);
    /// A start was ordered after a stop that waited.
    fn overtaken(&mut self, now: Now, id: CommandId);
    /// It found no way within its life.
    fn expired(&mut self, now: Now, id: CommandId);
}

/// No log of orders: for a hub that only routes.
impl OrderLog for () {
    fn heard(&mut self, _: Now, _: &PacketView<'_>) {}
    fn is_unconfirmed(&self, _: CommandId) -> bool {
        true
    }
    fn is_void(&self, _: CommandId) -> bool {
        false
    }
    fn starts(&self, _: CommandId) -> bool {
        false
    }
    fn dispatched(&mut self, _: Now, _: CommandId, _: &Dispatched) {}
    fn sent_again(&mut self, _: Now, _: CommandId, _: &[Transport]) {}
    fn refused(&mut self, _: Now, _: CommandId, _: &'static str) {}
    fn overtaken(&mut self, _: Now, _: CommandId) {}
    fn expired(&mut self, _: Now, _: CommandId) {}
}

/// Orders that wait for a way, by vessel, in the order in which they were given.
#[derive(Debug, Default)]
pub(crate) struct Waiting(BTreeMap<Address, Vec<Telecommand>>);

/// The last stop sent to each vessel, while there is no evidence that the vessel has it.
#[derive(Debug, Default)]
pub(crate) struct PendingStops(BTreeMap<Address, PendingStop>);

#[derive(Debug)]
struct PendingStop {
    stop: Telecommand,
    /// The peers that took it.
    takers: Vec<PeerId>,
    /// One of them is gone, perhaps with the stop.
    lost: bool,
    /// When the vessel was heard last; before that, when the stop was sent.
    heard: MonoTime,
    /// When it was given last, and how long after that it is given again.
    given: MonoTime,
    pause: Duration,
    /// The start that was ordered after it.
    overtaken_by: Vec<CommandId>,
}

impl PendingStops {
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// A stop was sent, for the first time or again.
    fn put(&mut self, now: MonoTime, stop: Telecommand, takers: Vec<PeerId>) {
        if self.0.len() >= VESSELS && !self.0.contains_key(&stop.vessel) {
            return;
        }
        let before = self.0.get(&stop.vessel).filter(|stood| stood.stop.tag.id == stop.tag.id);
        let pause = before.map_or(SILENCE, |stood| 2 * stood.pause);
        let vessel = stop.vessel;
        let stood = PendingStop {
            stop,
            takers,
            lost: false,
            heard: now,
            given: now,
            pause,
            overtaken_by: Vec::new(),
        };
        self.0.insert(vessel, stood);
    }

    fn of(&self, vessel: Address) -> Option<CommandId> {
        self.0.get(&vessel).and_then(|stood| stood.stop.tag.id)
    }

    /// A peer is gone: the orders it took may not have arrived.
    pub(crate) fn lost(&mut self, peer: PeerId) {
        for stood in self.0.values_mut().filter(|stood| stood.takers.contains(&peer)) {
            stood.lost = true;
        }
    }

    /// The vessel is heard: the stop, if it must be sent again.
    fn heard(&mut self, now: MonoTime, vessel: Address) -> Option<Telecommand> {
        let stood = self.0.get_mut(&vessel)?;
        let was_silent = now.since(stood.heard) > SILENCE;
        stood.heard = now;
        let is_due = now.since(stood.given) > stood.pause;
        (was_silent || is_due || stood.lost).then(|| stood.stop.clone())
    }

    fn end(&mut self, vessel: Address) {
        self.0.remove(&vessel);
    }
}

impl Waiting {
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    fn has(&self, vessel: Address) -> bool {
        self.0.contains_key(&vessel)
    }

    /// Lets an order wait.
    fn put(&mut self, order: Telecommand) -> Result<(), &'static str> {
        let vessel = order.vessel;
        if self.0.len() >= VESSELS && !self.has(vessel) {
            return Err("orders wait for too many vessels");
        }
        let waiting = self.0.entry(vessel).or_default();
        if waiting.len() >= WAITING {
            return Err("too many orders wait for this vessel");
        }
        waiting.push(order);
        Ok(())
    }

    fn take(&mut self, vessel: Address) -> Vec<Telecommand> {
        self.0.remove(&vessel).unwrap_or_default()
    }

    fn has_stop(&self, vessel: Address) -> bool {
        self.0.get(&vessel).is_some_and(|all| all.iter().any(|one| one.tag.urgency == Urgency::Stop))
    }

    fn take_stops(&mut self, vessel: Address) -> Vec<CommandId> {
        let mut stops = Vec::new();
        self.retain(vessel, |one| {
            let is_stop = one.tag.urgency == Urgency::Stop;
            stops.extend(one.tag.id.filter(|_| is_stop));
            !is_stop
        });
        stops
    }

    fn retain(&mut self, vessel: Address, keep: impl FnMut(&Telecommand) -> bool) {
        if let Some(waiting) = self.0.get_mut(&vessel) {
            waiting.retain(keep);
            if waiting.is_empty() {
                self.0.remove(&vessel);
            }
        }
    }

    /// Removes orders whose life has ended.
    fn expired(&mut self, now: MonoTime) -> Vec<Telecommand> {
        let mut over = Vec::new();
        self.0.retain(|_, waiting| {
            over.extend(waiting.extract_if(.., |one| one.tag.expires <= now));
            !waiting.is_empty()
        });
        over
    }
}

/// A connection to a vessel, other than its link.
#[derive(Debug, Clone, Copy)]
struct Way {
    peer: PeerId,
    /// Whether the vessel was heard there in the last seconds.
    alive: bool,
}

impl<O: OrderLog> Hub<O> {
    /// Gives an order to its vessel. It is recorded at once.
    pub fn dispatch(&mut self, now: Now, order: Telecommand) -> Dispatched {
        self.record_own(now, &order.packet);
        self.send_down(now, order)
    }

    /// Whether a vessel's link is open, as its peer reports. Waiting orders are sent when it is.
    pub fn link_stands(&mut self, now: Now, peer: PeerId, stands: bool) {
        let Some(slot) = self.peers.get_mut(&peer) else { return };
        slot.stands = stands;
        let vessels = slot.own_vessels();
        if stands {
            for vessel in vessels {
                if let Some(stood) = self.standing.0.get_mut(&vessel) {
                    stood.lost = true;
                }
                self.flush(now, vessel);
                self.stop_again(now, vessel);
            }
        }
    }

    /// Whether an order to a vessel would go by its link: it is open, or it is the only way.
    pub fn goes_by_link(&self, now: MonoTime, vessel: Address) -> bool {
        let links = || self.peers.values().filter(|slot| slot.is_link_of(vessel));
        links().any(|slot| slot.stands)
            || (links().next().is_some() && self.other_ways(now, vessel).is_empty())
    }

    /// A way to a vessel may be open again: its waiting orders are sent.
    pub(crate) fn flush(&mut self, now: Now, vessel: Address) {
        for order in self.waiting.take(vessel) {
            self.give(now, order);
        }
    }

    /// Orders that a lost peer did not take go by another way, if they are still valid.
    pub fn give_again(&mut self, now: Now, order: Telecommand) {
        if order.tag.urgency == Urgency::Stop {
            // A stop is kept here until it is confirmed.
            return self.stop_again(now, order.vessel);
        }
        self.give(now, order);
    }

    fn give(&mut self, now: Now, order: Telecommand) {
        let id = order.tag.id;
        let dispatched = self.send_down(now, order);
        if let Some(id) = id.filter(|_| !matches!(dispatched, Dispatched::Waits(_))) {
            self.orders.dispatched(now, id, &dispatched);
        }
    }

    /// Expires orders that waited too long.
    pub(crate) fn expire_waiting(&mut self, now: Now) {
        for order in self.waiting.expired(now.mono) {
            if let Some(id) = order.tag.id {
                self.orders.expired(now, id);
            }
        }
        self.standing.0.retain(|_, stood| now.mono < stood.stop.tag.expires);
    }

    /// Sends a stop again that the vessel may not have.
    fn stop_again(&mut self, now: Now, vessel: Address) {
        let Some(stop) = self.standing.heard(now.mono, vessel) else { return };
        let is_heard = self.reaches_alive(now.mono, vessel);
        let Some(id) = stop.tag.id.filter(|id| self.orders.is_unconfirmed(*id)) else {
            return self.standing.end(vessel);
        };
        let Some(stood) = self.standing.0.get_mut(&vessel) else { return };
        if !is_heard {
            stood.lost = true;
            return;
        }
        if !stood.overtaken_by.iter().all(|later| self.orders.is_void(*later)) {
            return;
        }
        if let Dispatched::Sent(transports) = self.send_down(now, stop) {
            self.orders.sent_again(now, id, &transports);
        }
    }

    /// Another controller starts something aboard: an earlier stop must not end it.
    pub(crate) fn another_starts(&mut self, now: Now, view: &PacketView<'_>) {
        let is_kept = !self.standing.is_empty() || !self.waiting.is_empty();
        if is_kept && starts(view) && self.reaches_alive(now.mono, view.dst()) {
            self.standing.end(view.dst());
            self.give_up_waiting(now, view.dst());
        }
    }

    /// A start is ordered after the stops that wait for a vessel.
    fn give_up_waiting(&mut self, now: Now, vessel: Address) {
        for id in self.waiting.take_stops(vessel) {
            self.orders.overtaken(now, id);
        }
    }

    /// Whether a stop is kept for a vessel that may not have it.
    fn keeps_stop(&self, vessel: Address) -> bool {
        let stood = self.standing.of(vessel).is_some_and(|id| self.orders.is_unconfirmed(id));
        stood || self.waiting.has_stop(vessel)
    }

    fn send_down(&mut self, now: Now, order: Telecommand) -> Dispatched {
        let Telecommand { vessel, tag, ref packet } = order;
        if tag.expires <= now.mono {
            return Dispatched::Refused("it came too late");
        }
        let stop = tag.urgency == Urgency::Stop;
        let again = stop && self.standing.of(vessel) == tag.id;
        if stop && !again {
            self.call_off(now, vessel);
        }
        let starts = tag.id.filter(|id| self.orders.starts(*id));
        let (link, others) = (self.standing_link(vessel), self.other_ways(now.mono, vessel));
        let one_is_alive = others.iter().any(|way| way.alive);
        let has_link = self.peers.values().any(|slot| slot.is_link_of(vessel));
        if starts.is_some() && link.is_none() && !one_is_alive && self.keeps_stop(vessel) {
            if !has_link {
                return Dispatched::Refused(
                    "the vessel is silent and has perhaps not heard the stop before it",
                );
            }
            return self.wait(order);
        }
        let (mut transports, mut takers) = (Vec::new(), Vec::new());
        let copy = if stop { Tag { expires: tag.expires.min(now.mono + COPY_LIFE), ..tag } } else { tag };
        if let Some(link) = link {
            transports.extend(self.hand(link, packet, copy));
            takers.push(link);
        }
        if stop && !again {
            // A link that is down may still hold a start that was ordered before: the stop cancels it there.
            for down in self.links_that_are_down(vessel) {
                self.hand(down, packet, Tag { is_copy: true, ..copy });
            }
        }
        if transports.is_empty() || stop {
            let count = if stop { others.len() } else { 1 };
            for way in others.into_iter().take(count) {
                transports.extend(self.hand(way.peer, packet, copy));
                takers.push(way.peer);
            }
        }
        // A way on which the vessel was not heard lately may lead nowhere: a stop waits all the same, until it is heard.
        if !transports.is_empty() && (link.is_some() || one_is_alive || !stop) {
            if stop {
                self.standing.put(now.mono, order, takers);
            } else if starts.is_some() {
                self.give_up_waiting(now, vessel);
                if let Some(stood) = self.standing.0.get_mut(&vessel) {
                    stood.overtaken_by.extend(starts);
                }
            }
            return Dispatched::Sent(transports);
        }
        match tag.urgency {
            Urgency::Sticks => return Dispatched::Refused("no connection to the vessel now"),
            Urgency::Command if !has_link => {
                return Dispatched::Refused("no connection to the vessel now");
            }
            Urgency::Command | Urgency::Stop => {}
        }
        if stop {
            // The newest counts for all.
            self.standing.end(vessel);
        }
        match self.wait(order) {
            Dispatched::Waits(_) => Dispatched::Waits(transports),
            refused => refused,
        }
    }

    /// Lets an order wait until its vessel is heard.
    fn wait(&mut self, order: Telecommand) -> Dispatched {
        match self.waiting.put(order) {
            Ok(()) => Dispatched::Waits(Vec::new()),
            Err(why) => Dispatched::Refused(why),
        }
    }

    /// Cancels the orders that wait for a vessel.
    fn call_off(&mut self, now: Now, vessel: Address) {
        for id in self.waiting.take(vessel).into_iter().filter_map(|order| order.tag.id) {
            self.orders.refused(now, id, CALLED_OFF);
        }
    }

    fn links_that_are_down(&self, vessel: Address) -> Vec<PeerId> {
        let links = self.peers.iter().filter(|(_, slot)| slot.is_link_of(vessel) && !slot.stands);
        links.map(|(id, _)| *id).collect()
    }

    fn hand(&mut self, peer: PeerId, packet: &Bytes, tag: Tag) -> Option<Transport> {
        let slot = self.peers.get_mut(&peer)?;
        slot.delivered += 1;
        slot.out.push(Delivery { packet: packet.clone(), tag: Some(tag) });
        let transport = slot.peer.transport;
        self.counters.delivered += 1;
        Some(transport)
    }

    fn standing_link(&self, vessel: Address) -> Option<PeerId> {
        let stands = |(_, slot): &(&PeerId, &crate::slot::Slot)| slot.stands && slot.is_link_of(vessel);
        self.peers.iter().find(stands).map(|(id, _)| *id)
    }

    /// The ways to a vessel but for its link, the best one first.
    fn other_ways(&self, now: MonoTime, vessel: Address) -> Vec<Way> {
        let ways = self.peers.iter().filter(|(_, slot)| !slot.is_link_of(vessel));
        let mut ways: Vec<_> =
            ways.filter_map(|(id, slot)| slot.way_to(vessel, now).map(|way| (way, *id))).collect();
        ways.sort_unstable();
        ways.into_iter().rev().map(|((alive, ..), peer)| Way { peer, alive }).collect()
    }

    /// A live packet came from a vessel: a way leads there.
    pub(crate) fn way_back(&mut self, now: Now, view: &PacketView<'_>) {
        let vessel = view.src();
        if !self.waiting.is_empty() && self.waiting.has(vessel) {
            // One that was given to a way that seemed dead may have arrived.
            let orders = &self.orders;
            self.waiting.retain(vessel, |one| {
                one.tag.urgency != Urgency::Stop || one.tag.id.is_none_or(|id| orders.is_unconfirmed(id))
            });
            if self.reaches_alive(now.mono, vessel) {
                self.flush(now, vessel);
            }
        }
        if !self.standing.is_empty() {
            self.stop_again(now, vessel);
        }
    }

    /// Whether there is a way to the vessel by which it was just heard and whose peer reads its packets.
    fn reaches_alive(&self, now: MonoTime, vessel: Address) -> bool {
        self.standing_link(vessel).is_some() || self.other_ways(now, vessel).iter().any(|way| way.alive)
    }
}

/// Whether a packet orders a vessel to start something.
fn starts(view: &PacketView<'_>) -> bool {
    match view.id() {
        PlanControl::ID => imc::decode::<PlanControl>(view).is_ok_and(|control| {
            control.is_some_and(|control| {
                control.r#type == PlanControlType::Request && control.op == PlanControlOp::Start
            })
        }),
        VehicleCommand::ID => imc::decode::<VehicleCommand>(view).is_ok_and(|command| {
            command.is_some_and(|command| {
                command.r#type == VehicleCommandType::Request
                    && command.command == VehicleCommandCommand::ExecManeuver
            })
        }),
        _ => false,
    }
}
