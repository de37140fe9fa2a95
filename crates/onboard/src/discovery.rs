//! Discovery of this system and its parts: Announce, Heartbeat, the list of entities, the log
//! book on request.

use crate::bus::{Asker, Bus};
use crate::entity::{Entity, Labels};
use crate::input::Reachable;
use crate::output::Output;
use crate::settings::Settings;
use imc::messages::{
    Announce, EntityInfo, EntityList, EntityListOp, Heartbeat, LogBookControl, LogBookControlCommand,
    LogBookEntry, LogBookEntryType, Message, RemoteActionsRequest, RemoteActionsRequestOp, SystemType,
};
use imc::services::Service;
use imc::{ANY_ENTITY, Address};
use std::net::SocketAddrV4;
use std::time::Duration;
use units::{LatLon, MonoTime};

const HEARTBEAT: Duration = Duration::from_secs(1);
/// Entries of one answer, so that it fits a datagram.
const ENTRIES_ANSWERED: usize = 100;

/// Announcements and heartbeats.
#[derive(Debug, Clone)]
pub(crate) struct Discovery {
    reachable: Reachable,
    next_announce: MonoTime,
    next_heartbeat: MonoTime,
}

impl Discovery {
    pub(crate) fn new(now: MonoTime) -> Self {
        Self { reachable: Reachable::default(), next_announce: now, next_heartbeat: now }
    }

    /// Where this system is reached; it is announced at once.
    pub(crate) fn reachable(&mut self, now: MonoTime, reachable: Reachable) {
        self.reachable = reachable;
        self.next_announce = now;
    }

    pub(crate) fn poll_timeout(&self) -> MonoTime {
        self.next_announce.min(self.next_heartbeat)
    }

    pub(crate) fn tick(&mut self, bus: &mut Bus, settings: &Settings, place: Option<(LatLon, f64)>) {
        let now = bus.mono();
        if now >= self.next_heartbeat {
            self.next_heartbeat = now + HEARTBEAT;
            bus.send(Entity::Daemon, &Heartbeat);
        }
        if now < self.next_announce {
            return;
        }
        self.next_announce = now + settings.node.announce_period;
        let (lat, lon, height) =
            place.map_or((0.0, 0.0, 0.0), |(place, height_m)| (place.lat_rad(), place.lon_rad(), height_m));
        let announce = Announce {
            sys_name: settings.name.as_str().into(),
            sys_type: SystemType::Usv,
            owner: 0xFFFF,
            lat,
            lon,
            height: height as f32,
            services: services(settings, &self.reachable).into(),
        };
        let everyone = Asker { system: Address::ANNOUNCE, entity: imc::ANY_ENTITY };
        if let Some(bytes) = bus.packet(Entity::Announcer, everyone, &announce) {
            bus.put(Output::Announce(bytes.clone()));
            let to = bus.node.recipients(now, 151, Entity::Announcer.number(), Address::NULL);
            bus.pass_on(bytes, to);
        }
    }
}

fn services(settings: &Settings, reachable: &Reachable) -> String {
    let (uid, version) = (format!("uid/{}", settings.uid), format!("version/{}", settings.version));
    let imc_version = "version/5.4.31".to_owned();
    let fixed = [("dune", uid), ("dune", version), ("imc+info", imc_version)];
    let sockets = |scheme: &'static str, sockets: &[SocketAddrV4]| {
        sockets.iter().map(|at| (scheme, at.ip().to_string(), at.port())).collect::<Vec<_>>()
    };
    let mut open = sockets("imc+tcp", &reachable.tcp);
    open.extend(sockets("imc+udp", &reachable.udp));
    let fixed = fixed.iter().map(|(scheme, path)| Service { scheme, host: "0.0.0.0", port: None, path });
    let open = open.iter().map(|(scheme, host, port)| Service { scheme, host, port: Some(*port), path: "" });
    imc::services::build(fixed.chain(open))
}

/// Answers questions about this system from its fixed settings.
pub(crate) fn answer(bus: &mut Bus, settings: &Settings, asker: Asker, to_entity: u8, message: &Message) {
    match message {
        Message::EntityList(list) if list.op == EntityListOp::Query => {
            entity_list(bus, asker, &settings.labels);
        }
        Message::QueryEntityInfo(_) => match Entity::from_number(to_entity) {
            Some(entity) => entity_info(bus, asker, &settings.labels, entity),
            None if to_entity == ANY_ENTITY => all_entities(bus, asker, &settings.labels),
            None => {}
        },
        Message::LogBookControl(request) => log_book(bus, asker, request),
        Message::RemoteActionsRequest(request) if request.op == RemoteActionsRequestOp::Query => {
            let report = RemoteActionsRequest {
                op: RemoteActionsRequestOp::Report,
                actions: control::REMOTE_ACTIONS.into(),
            };
            bus.send(Entity::Remote, &report);
        }
        _ => {}
    }
}

/// The description of each part.
pub(crate) fn all_entities(bus: &mut Bus, to: Asker, labels: &Labels) {
    for entity in Entity::ALL {
        entity_info(bus, to, labels, entity);
    }
}

pub(crate) fn entity_list(bus: &mut Bus, to: Asker, labels: &Labels) {
    let list = imc::entities::build(Entity::ALL.map(|entity| (labels.of(entity), entity.number())));
    bus.send_to(Entity::Daemon, to, &EntityList { op: EntityListOp::Report, list: list.into() });
}

/// The description of one entity.
fn entity_info(bus: &mut Bus, to: Asker, labels: &Labels, entity: Entity) {
    let info = EntityInfo {
        id: entity.number(),
        label: labels.of(entity).into(),
        component: entity.label_and_task().1.into(),
        act_time: 0,
        deact_time: 0,
    };
    bus.send_to(entity, to, &info);
}

/// The log book as asked for.
fn log_book(bus: &mut Bus, to: Asker, request: &LogBookControl) {
    let since = if request.htime.is_finite() { request.htime } else { 0.0 };
    let wanted = |entry: &&LogBookEntry| match request.command {
        LogBookControlCommand::Get => entry.htime >= since,
        LogBookControlCommand::GetErr => {
            matches!(entry.r#type, LogBookEntryType::Error | LogBookEntryType::Critical)
        }
        LogBookControlCommand::Clear | LogBookControlCommand::Reply | LogBookControlCommand::Unlisted(_) => {
            false
        }
    };
    match request.command {
        LogBookControlCommand::Clear => bus.forget_entries(),
        LogBookControlCommand::Get | LogBookControlCommand::GetErr => {
            let mut entries: Vec<LogBookEntry> = bus.entries().filter(wanted).cloned().collect();
            let skipped = entries.len().saturating_sub(ENTRIES_ANSWERED);
            let reply = LogBookControl {
                command: LogBookControlCommand::Reply,
                htime: bus.seconds(),
                msg: entries.drain(skipped..).collect(),
            };
            bus.send_to(Entity::LogBook, to, &reply);
        }
        LogBookControlCommand::Reply | LogBookControlCommand::Unlisted(_) => {}
    }
}
