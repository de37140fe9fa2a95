//! Packets from others: who sent them, whom they concern, what they ask.

use crate::brain::Brain;
use crate::bus::Asker;
use crate::discovery;
use crate::entity::Entity;
use crate::input::Peer;
use crate::node::Contact;
use crate::output::{Level, Output};
use imc::messages::{
    EntityListOp, LoggingControl, LoggingControlOp, Message, RemoteActionsRequest, RemoteActionsRequestOp,
};
use imc::{ANY_ENTITY, Address, Packet};
use mission::{Event, Sighting};
use units::LatLon;

impl Brain {
    /// A packet as it came.
    pub(crate) fn packet(&mut self, from: Peer, bytes: Vec<u8>) {
        let packet = match Packet::decode(&bytes) {
            Ok(packet) => packet,
            Err(error) => {
                self.bus.console(Level::Debug, format!("a packet is refused: {error}"));
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
        if header.src.is_ccu() {
            self.supervise.contact(now);
        }
        // What others say is logged; announcements also reach those who only listen by TCP.
        let passed = match message {
            Message::Announce(_) => self.bus.node.tcp_but(from),
            _ => Vec::new(),
        };
        self.bus.pass_on(bytes, passed);
        let asker = Asker { system: header.src, entity: header.src_ent };
        self.message(asker, header.dst, header.dst_ent, message);
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
        // What changes the vessel's ways must name it, or broadcast on purpose.
        let commands = for_us || to == Address::BROADCAST;
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
            Message::LoggingControl(request) if commands => self.logging(asker, request),
            Message::LogBookControl(request) => discovery::log_book(&mut self.bus, asker, request),
            Message::RemoteActionsRequest(request) if request.op == RemoteActionsRequestOp::Query => {
                let report = RemoteActionsRequest {
                    op: RemoteActionsRequestOp::Report,
                    actions: control::REMOTE_ACTIONS.into(),
                };
                self.bus.send(Entity::Remote, &report);
            }
            Message::QueryEntityParameters(query) => self.query_parameters(asker, query),
            Message::SetEntityParameters(set) if commands => self.set_parameters(asker, set),
            Message::SaveEntityParameters(save) if commands => {
                let label = save.name.to_str_lossy().into_owned();
                self.save_parameters(&label);
            }
            Message::PlanDB(request) if commands => {
                let name = self.name_of(asker.system);
                self.plans.database(&mut self.bus, asker, &name, request);
            }
            Message::PlanControl(request) if commands => {
                let name = self.name_of(asker.system);
                self.plans.control(&mut self.bus, &mut self.pilot, asker, &name, request);
            }
            Message::Abort(_) if commands => {
                self.supervise.aborted();
                let abort = mission::Input::Abort { by: asker.system.0 };
                self.plans.tell(&mut self.bus, &mut self.pilot, abort);
                self.hold_conditions();
            }
            Message::TeleoperationDone(_) if commands => {
                let done = Event::TeleoperationDone { from: asker.system.0 };
                self.plans.tell(&mut self.bus, &mut self.pilot, mission::Input::Event(done));
            }
            Message::Reference(reference) if commands => {
                self.plans.reference(&mut self.bus, &mut self.pilot, asker, reference);
            }
            Message::Announce(announce) => {
                if let Ok(place) = LatLon::from_rad(announce.lat, announce.lon) {
                    let seen = Event::Sighting(Sighting { system: asker.system.0, place });
                    self.plans.tell(&mut self.bus, &mut self.pilot, mission::Input::Event(seen));
                }
            }
            Message::RemoteActions(keys) if commands => {
                let keys = keys.actions.to_str_lossy().into_owned();
                self.pilot.keys(&mut self.bus, asker.system.0, &keys);
            }
            _ => {}
        }
    }
}
