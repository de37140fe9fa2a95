//! Packets from others: who sent them, how many are logged, and whether they are obeyed.
//!
//! A packet is decoded here, once; all later steps get the decoded one.

use crate::bus::{Asker, Bus};
use crate::entity::Entity;
use crate::intake::Intake;
use crate::lease::{Lease, LeaseGate, NotObeyed};
use crate::node::Contact;
use crate::operator::{Keys, Operators, Unfit};
use crate::output::Level;
use crate::peer::Peer;
use crate::pilot::Pilot;
use control::RemoteActions;
use imc::messages::{Announce, Message, PlanControl, PlanControlType, PlanDB, PlanDBType};
use imc::{Address, Nested, Packet, Payload as _};
use mission::Drive;
use std::time::Duration;
use units::MonoTime;

/// The state of the systems that send packets.
#[derive(Debug)]
pub(crate) struct Reception {
    operators: Operators,
    intake: Intake,
    lease: LeaseGate,
}

impl Reception {
    pub(crate) fn new(now: MonoTime) -> Self {
        Self { operators: Operators::default(), intake: Intake::new(now), lease: LeaseGate::default() }
    }

    /// Decodes a packet as it came, notes who sent it, and logs it; `None` when there is nothing to act upon.
    pub(crate) fn receive(&mut self, bus: &mut Bus, from: Peer, bytes: Vec<u8>) -> Option<Packet> {
        let now = bus.mono();
        let packet = match Packet::decode(&bytes) {
            Ok(packet) => packet,
            Err(error) => {
                if self.intake.admits(now, Address::NULL, bytes.len()) {
                    bus.console(Level::Debug, format!("a packet is refused: {error}"));
                }
                return None;
            }
        };
        let header = packet.header;
        let known = header.src != bus.address() && !header.src.is_everyone();
        let message = packet.message().filter(|_| known)?;
        let contact = match message {
            Message::Announce(announce) => bus.node.announced(now, header.src, from, announce),
            _ => bus.node.heard(now, header.src, from),
        };
        if let Contact::New(name) = contact {
            bus.entry(Entity::Udp, Level::Info, format!("{name} ({}) is in contact", header.src));
        }
        self.operators.heard(now, header.src, header.timestamp);
        // Messages of others are logged; announcements also go to peers that only listen by TCP.
        if self.intake.admits(now, header.src, bytes.len()) {
            let passed = match message {
                Message::Announce(_) => bus.node.tcp_but(from, Announce::ID),
                _ => Vec::new(),
            };
            bus.pass_on(bytes, passed);
        }
        Some(packet)
    }

    /// Whether a message that came under a lease (0 for none) is acted upon; an order to this vessel that is not is
    /// answered.
    pub(crate) fn obeys(
        &mut self,
        bus: &mut Bus,
        asker: Asker,
        to: Address,
        lease: u64,
        message: &Message,
    ) -> bool {
        let refused = self.lease.admit(bus.mono(), lease, message).err();
        if let Some(why) = &refused
            && may_stop(bus, to)
        {
            self.refuse(bus, asker, message, why);
        }
        refused.is_none()
    }

    /// The shore reports who commands; returns whether that is another than before.
    pub(crate) fn leased(&mut self, bus: &mut Bus, lease: &Lease) -> bool {
        let now = bus.mono();
        let changed = self.lease.told(now, lease);
        if changed {
            let text = match self.lease.holder(now) {
                Some(holder) => format!("{holder} has control from ashore"),
                None => "nobody has control from ashore".to_owned(),
            };
            bus.entry(Entity::Supervisor, Level::Info, text);
        }
        changed
    }

    /// A plan begins that this system started from there.
    pub(crate) fn started(&mut self, system: Address, from: Peer) {
        self.operators.started(system, from);
    }

    /// How many packets were not logged, when it is time to say so.
    pub(crate) fn left_out(&mut self, now: MonoTime) -> Option<u64> {
        self.intake.declare(now)
    }

    /// Answers an order of a system that is not in command.
    fn refuse(&mut self, bus: &mut Bus, asker: Asker, message: &Message, why: &NotObeyed) {
        if self.lease.is_news(bus.mono()) {
            let text = format!("{} of {} is {why}", message.abbrev(), asker.system);
            bus.entry(Entity::Supervisor, Level::Warning, text);
        }
        let info = why.to_string();
        match message {
            Message::PlanControl(request) => {
                let reply = PlanControl {
                    r#type: PlanControlType::Failure,
                    arg: Nested::none(),
                    info: info.as_str().into(),
                    ..(**request).clone()
                };
                bus.send_to(Entity::PlanEngine, asker, &reply);
            }
            Message::PlanDB(request) => {
                let reply = PlanDB {
                    r#type: PlanDBType::Failure,
                    arg: Nested::none(),
                    info: info.as_str().into(),
                    ..(**request).clone()
                };
                bus.send_to(Entity::PlanDatabase, asker, &reply);
            }
            _ => {}
        }
    }

    /// Keys of an operator, if they may still act.
    pub(crate) fn keys(
        &mut self,
        bus: &mut Bus,
        pilot: &mut Pilot,
        longest_age: Duration,
        from: Peer,
        packet: &Packet,
        text: &str,
    ) {
        let (system, sent_s) = (packet.header.src, packet.header.timestamp);
        let Drive::Teleoperation(operator) = pilot.drive() else { return };
        if !operator.admits(system.0) {
            return;
        }
        let host = bus.node.host_of(system);
        let keys = Keys { system, from, sent_s, operator };
        let (actions, ignored) = RemoteActions::parse(text);
        if !ignored.is_empty() {
            bus.console(Level::Debug, format!("remote actions without effect: {}", ignored.join(", ")));
        }
        // Keys whose life was used up on the way have no effect.
        let bound = actions.life.map_or(longest_age, |life| life.min(longest_age));
        match self.operators.admit(bus.mono(), bound, &keys, host) {
            Ok(late) => {
                let life = actions.life.map(|life| life.saturating_sub(late));
                pilot.keys(bus, system.0, &RemoteActions { life, ..actions });
            }
            Err(unfit) => {
                if self.operators.is_news() {
                    bus.entry(Entity::Remote, Level::Warning, unfit.to_string());
                }
                // Stopping is never too late.
                let RemoteActions { exit, stop, .. } = actions;
                if matches!(unfit, Unfit::Late(_)) && (exit || stop) {
                    let stop = RemoteActions { exit, stop, ..RemoteActions::default() };
                    pilot.keys(bus, system.0, &stop);
                }
            }
        }
    }
}

/// Whether what goes to this address may stop the vessel: it names the vessel, or is broadcast on purpose.
/// Stopping too many vessels does less harm than starting too many, so an order that sets one in motion must name it.
pub(crate) fn may_stop(bus: &Bus, to: Address) -> bool {
    to == bus.address() || to == Address::BROADCAST
}
