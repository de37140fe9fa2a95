//! Packets from others: who sent them, whom they concern, what they ask.

use crate::brain::Brain;
use crate::bus::Asker;
use crate::discovery;
use crate::entity::Entity;
use crate::input::Peer;
use crate::lease::NotObeyed;
use crate::node::Contact;
use crate::operator::{Keys, Unfit};
use crate::output::{Level, Output};
use crate::pilot::Drive;
use control::RemoteActions;
use imc::messages::{
    Announce, EntityListOp, LoggingControl, LoggingControlOp, Message, PlanControl, PlanControlOp,
    PlanControlType, PlanDB, PlanDBOp, PlanDBType, RemoteActionsRequest, RemoteActionsRequestOp,
};
use imc::{ANY_ENTITY, Address, Nested, Packet, Payload as _};
use mission::{Event, Sighting};
use units::LatLon;

impl Brain {
    /// A packet as it came, under a lease (0 for none).
    pub(crate) fn packet(&mut self, from: Peer, lease: u64, bytes: Vec<u8>) {
        let packet = match Packet::decode(&bytes) {
            Ok(packet) => packet,
            Err(error) => {
                if self.intake.admits(self.bus.mono(), Address::NULL, bytes.len()) {
                    self.bus.console(Level::Debug, format!("a packet is refused: {error}"));
                }
                return;
            }
        };
        let header = packet.header;
        let known = header.src != self.bus.address() && !header.src.is_everyone();
        let Some(message) = packet.message().filter(|_| known) else { return };
        let now = self.bus.mono();
        let contact = match message {
            Message::Announce(announce) => self.bus.node.announced(now, header.src, from, announce),
            _ => self.bus.node.heard(now, header.src, from),
        };
        if let Contact::New(name) = contact {
            self.bus.entry(Entity::Udp, Level::Info, format!("{name} ({}) is in contact", header.src));
        }
        self.operators.heard(now, header.src, header.timestamp);
        if header.src.is_ccu() {
            self.supervise.contact(now);
        }
        // What others say is logged; announcements also reach those who only listen by TCP.
        if self.intake.admits(now, header.src, bytes.len()) {
            let passed = match message {
                Message::Announce(_) => self.bus.node.tcp_but(from, Announce::ID),
                _ => Vec::new(),
            };
            self.bus.pass_on(bytes, passed);
        }
        let asker = Asker { system: header.src, entity: header.src_ent };
        if let Err(why) = self.lease.admit(now, lease, message) {
            if self.may_stop(header.dst) {
                self.refuse(asker, message, &why);
            }
            return;
        }
        if let Message::RemoteActions(keys) = message {
            if header.dst == self.bus.address() {
                self.keys(from, header.src, header.timestamp, &keys.actions.to_str_lossy());
            }
            return;
        }
        let before = self.plans.plan_state().run;
        // What an operator now decides settles a failure that nobody has looked at yet.
        let earlier =
            if matches!(message, Message::PlanControl(_)) { self.plans.take_failed() } else { None };
        let mut steps_in = false;
        self.message(asker, header.dst, header.dst_ent, message);
        if let Message::PlanControl(request) = message {
            let run = self.plans.plan_state().run;
            let stops = request.op == PlanControlOp::Stop && request.r#type == PlanControlType::Request;
            steps_in = run != before || (stops && self.may_stop(header.dst));
            if steps_in {
                self.supervise.stepped_in();
            }
            if run.is_some() && run != before {
                self.operators.started(header.src, from);
            }
        }
        if let Some(earlier) = earlier.filter(|_| !steps_in) {
            self.plans.failed_before(earlier);
        }
    }

    /// Answers an order of somebody who does not command.
    fn refuse(&mut self, asker: Asker, message: &Message, why: &NotObeyed) {
        if self.lease.is_news(self.bus.mono()) {
            let text = format!("{} of {} is {why}", message.abbrev(), asker.system);
            self.bus.entry(Entity::Supervisor, Level::Warning, text);
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
                self.bus.send_to(Entity::PlanEngine, asker, &reply);
            }
            Message::PlanDB(request) => {
                let reply = PlanDB {
                    r#type: PlanDBType::Failure,
                    arg: Nested::none(),
                    info: info.as_str().into(),
                    ..(**request).clone()
                };
                self.bus.send_to(Entity::PlanDatabase, asker, &reply);
            }
            _ => {}
        }
    }

    /// Keys of an operator, if they may still act.
    fn keys(&mut self, from: Peer, system: Address, sent_s: f64, text: &str) {
        let Drive::Remote(operator) = self.pilot.drive() else { return };
        let operator = operator.map(Address);
        if operator.is_some_and(|operator| operator != system) {
            return;
        }
        let host = self.bus.node.host_of(system);
        let keys = Keys { system, from, sent_s, operator };
        let (actions, ignored) = RemoteActions::parse(text);
        if !ignored.is_empty() {
            self.bus.console(Level::Debug, format!("remote actions without effect: {}", ignored.join(", ")));
        }
        // What has used up its life on the way is not worth anything any more.
        let bound = self.settings.longest_key_age;
        let bound = actions.life.map_or(bound, |life| life.min(bound));
        match self.operators.admit(self.bus.mono(), bound, &keys, host) {
            Ok(late) => {
                let life = actions.life.map(|life| life.saturating_sub(late));
                self.pilot.keys(&mut self.bus, system.0, &RemoteActions { life, ..actions });
            }
            Err(unfit) => {
                if self.operators.is_news() {
                    self.bus.entry(Entity::Remote, Level::Warning, unfit.to_string());
                }
                // Stopping is never too late.
                let RemoteActions { exit, stop, .. } = actions;
                if matches!(unfit, Unfit::Late(_)) && (exit || stop) {
                    let stop = RemoteActions { exit, stop, ..RemoteActions::default() };
                    self.pilot.keys(&mut self.bus, system.0, &stop);
                }
            }
        }
    }

    /// Whether what goes to this address may stop the vessel: it names the vessel, or is broadcast on purpose.
    /// To stop too many vessels does less harm than to start too many, so what sets one in motion must name it.
    fn may_stop(&self, to: Address) -> bool {
        to == self.bus.address() || to == Address::BROADCAST
    }

    /// The name of a system: as announced, else as configured.
    fn name_of(&self, system: Address) -> String {
        let configured = || self.settings.names.get(&system.0).map(String::as_str);
        self.bus.node.name_of(system).or_else(configured).unwrap_or_default().to_owned()
    }

    /// Another log on request, or the name of the open one.
    fn logging(&mut self, asker: Asker, request: &LoggingControl) {
        match request.op {
            LoggingControlOp::RequestStart => {
                let (label, utc) = (request.name.to_str_lossy().into_owned(), self.bus.utc());
                self.bus.put(Output::OpenLog { label, utc });
            }
            LoggingControlOp::RequestCurrentName => {
                let name = self.log_name.as_str().into();
                let reply = LoggingControl { op: LoggingControlOp::CurrentName, name };
                self.bus.send_to(Entity::Logger, asker, &reply);
            }
            _ => {}
        }
    }

    pub(crate) fn message(&mut self, asker: Asker, to: Address, to_entity: u8, message: &Message) {
        let for_us = to == self.bus.address();
        let for_all = to.is_everyone();
        let may_stop = self.may_stop(to);
        if !(for_us || for_all) {
            return;
        }
        match message {
            Message::EntityList(list) if list.op == EntityListOp::Query => {
                discovery::entity_list(&mut self.bus, asker, &self.settings.labels);
            }
            Message::QueryEntityInfo(_) => match Entity::from_number(to_entity) {
                Some(entity) => {
                    discovery::entity_info(&mut self.bus, asker, &self.settings.labels, entity);
                }
                None if to_entity == ANY_ENTITY => {
                    for entity in Entity::ALL {
                        discovery::entity_info(&mut self.bus, asker, &self.settings.labels, entity);
                    }
                }
                None => {}
            },
            Message::LoggingControl(request) if for_us => self.logging(asker, request),
            Message::LogBookControl(request) => discovery::log_book(&mut self.bus, asker, request),
            Message::RemoteActionsRequest(request) if request.op == RemoteActionsRequestOp::Query => {
                let report = RemoteActionsRequest {
                    op: RemoteActionsRequestOp::Report,
                    actions: control::REMOTE_ACTIONS.into(),
                };
                self.bus.send(Entity::Remote, &report);
            }
            Message::QueryEntityParameters(query) => self.query_parameters(asker, query),
            Message::SetEntityParameters(set) if for_us => self.set_parameters(asker, set),
            Message::SaveEntityParameters(save) if for_us => {
                let label = save.name.to_str_lossy().into_owned();
                self.save_parameters(&label);
            }
            Message::PushEntityParameters(push) if for_us => {
                self.push_parameters(&push.name.to_str_lossy());
            }
            Message::PopEntityParameters(pop) if for_us => {
                self.pop_parameters(asker, &pop.name.to_str_lossy());
            }
            Message::PlanDB(request) if for_us || (may_stop && reads(request.op)) => {
                let name = self.name_of(asker.system);
                self.plans.database(&mut self.bus, asker, &name, request);
            }
            Message::PlanControl(request) if for_us || (may_stop && request.op == PlanControlOp::Stop) => {
                let name = self.name_of(asker.system);
                self.plans.control(&mut self.bus, &mut self.pilot, asker, &name, request);
            }
            Message::Abort(_) if may_stop => {
                self.supervise.aborted();
                let abort = mission::Input::Abort { by: asker.system.0 };
                self.plans.tell(&mut self.bus, &mut self.pilot, abort);
                self.hold_conditions();
            }
            Message::TeleoperationDone(_) if may_stop => {
                let done = Event::TeleoperationDone { from: asker.system.0 };
                self.plans.tell(&mut self.bus, &mut self.pilot, mission::Input::Event(done));
            }
            Message::Reference(reference) if for_us => {
                self.plans.reference(&mut self.bus, &mut self.pilot, asker, reference);
            }
            Message::Announce(announce) => {
                if let Ok(place) = LatLon::from_rad(announce.lat, announce.lon) {
                    let afloat = !asker.system.is_ccu();
                    let seen = Event::Sighting(Sighting { system: asker.system.0, place, afloat });
                    self.plans.tell(&mut self.bus, &mut self.pilot, mission::Input::Event(seen));
                }
            }
            _ => {}
        }
    }
}

/// Whether an operation on the plan database changes nothing.
fn reads(op: PlanDBOp) -> bool {
    matches!(op, PlanDBOp::Get | PlanDBOp::GetInfo | PlanDBOp::GetState | PlanDBOp::GetDstate)
}
