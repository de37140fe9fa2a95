//! Which peers get which packet.
//!
//! | packet | goes to |
//! |---|---|
//! | from an IMCProxy client | every other IMCProxy client, whatever its destination, as that protocol has it |
//! | for one system | the peers behind which that system was heard last; a command by the best way alone, an Abort by all |
//! | for everyone, from a vessel | every console |
//! | for everyone, from a console | every console and every vessel |
//! | for this server | no peer: it goes to the fleet's state and the record |
//!
//! Never back to where it came from, never towards a peer behind which its own source lives, and a packet that came
//! before by another transport is not routed: so two relays, or a vessel that is reached twice, make no loop.
//!
//! A DUNE forwards to all its clients what each of them sent. So what comes from a peer behind which its destination lives
//! is an echo: the vessel has it, and gets it by no transport. And a vessel does not recognise copies, so a command takes
//! only one of several ways: the one that is alive, TCP before UDP. An Abort does no harm twice.

use crate::downlink::OrderLog;
use crate::exchange::is_command;
use crate::hub::Hub;
use crate::peer::{PeerId, Role};
use bytes::Bytes;
use imc::messages::{Abort, Payload as _};
use imc::{Address, PacketView};
use link::Transport;
use units::MonoTime;

impl<O: OrderLog> Hub<O> {
    pub(crate) fn route(
        &mut self,
        now: MonoTime,
        from: PeerId,
        transport: Transport,
        view: &PacketView<'_>,
        packet: &Bytes,
    ) {
        let (source, to) = (view.src(), view.dst());
        let for_us = to == self.address();
        let for_all = to.is_everyone();
        let from_console = source.is_ccu();
        let is_echo = self.is_echo(now, from, to);
        let one_way = !for_all && !to.is_ccu() && view.id() != Abort::ID && is_command(view);
        let way = if one_way && !is_echo { self.best_way(now, from, transport, to) } else { None };
        let neighbours = if for_all && from_console { self.behind(now, from) } else { Vec::new() };
        let mut count = 0;
        for (id, slot) in &mut self.peers {
            if *id == from {
                continue;
            }
            let is_home = slot.is_home_of(to, now);
            let may_have = !is_home || !is_echo && way.is_none_or(|way| way == *id);
            let wanted = if transport == Transport::Proxy && slot.peer.transport == Transport::Proxy {
                may_have
            } else if for_us || slot.is_home_of(source, now) {
                false
            } else if for_all {
                let mut there = slot.homes(now).peekable();
                // All peers there got it where it comes from.
                let heard = there.peek().is_some() && there.all(|system| neighbours.contains(&system));
                (slot.peer.role == Role::Console || from_console) && !heard
            } else {
                is_home && may_have
            };
            if wanted {
                count += 1;
                slot.delivered += 1;
                slot.out.push(packet.clone().into());
            }
        }
        self.counters.delivered += count;
        if count == 0 && !for_all && !for_us && !is_echo {
            self.counters.unroutable += 1;
        }
    }

    /// Whether a packet comes from where its destination lives, which therefore has it. A console is never meant:
    /// an answer sent twice does no harm, a missing one does.
    pub(crate) fn is_echo(&self, now: MonoTime, from: PeerId, to: Address) -> bool {
        !to.is_ccu()
            && !to.is_everyone()
            && self.peers.get(&from).is_some_and(|slot| slot.is_home_of(to, now))
    }

    /// The peer by which a vessel gets a command. What comes by the IMCProxy transport goes to all others there, so that of
    /// ways that are alive one there comes first.
    fn best_way(&self, now: MonoTime, from: PeerId, transport: Transport, to: Address) -> Option<PeerId> {
        let ways = self.peers.iter().filter(|(id, _)| **id != from).filter_map(|(id, slot)| {
            let (alive, by_transport, heard) = slot.way_to(to, now)?;
            let passes = transport == Transport::Proxy && slot.peer.transport == Transport::Proxy;
            Some(((alive, passes, by_transport, heard), *id))
        });
        ways.max().map(|(_, id)| id)
    }

    fn behind(&self, now: MonoTime, from: PeerId) -> Vec<Address> {
        self.peers.get(&from).map(|slot| slot.homes(now).collect()).unwrap_or_default()
    }
}
