//! The vessel's bus: every outgoing message gets its header here and goes to the log and to the receivers that the node
//! chooses.

use crate::entity::Entity;
use crate::node::Node;
use crate::output::{Level, Output};
use crate::peer::Peer;
use crate::routing::RouteRequest;
use crate::settings::Settings;
use imc::messages::{LogBookEntry, LogBookEntryType};
use imc::{ANY_ENTITY, Address, Header, Payload};
use std::collections::VecDeque;
use units::{MonoTime, Now, UtcTime};

/// Entries kept for consoles that ask for the log book.
const ENTRIES_KEPT: usize = 500;

/// The requester, for the answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Asker {
    pub(crate) system: Address,
    pub(crate) entity: u8,
}

impl Asker {
    /// All systems: for messages without a requester.
    pub(crate) const EVERYONE: Self = Self { system: Address::NULL, entity: ANY_ENTITY };
}

/// The way out.
#[derive(Debug)]
pub(crate) struct Bus {
    pub(crate) node: Node,
    address: Address,
    now: Now,
    out: VecDeque<Output>,
    entries: VecDeque<LogBookEntry>,
    /// The number ashore of the command that is being carried out; 0 for none.
    command: u64,
    lost: u64,
    /// Routes asked for since the start.
    routes: u32,
}

impl Bus {
    pub(crate) fn new(settings: &Settings, now: Now) -> Self {
        Self {
            node: Node::new(settings.node.clone()),
            address: settings.address,
            now,
            out: VecDeque::new(),
            entries: VecDeque::new(),
            command: 0,
            lost: 0,
            routes: 0,
        }
    }

    /// Sets the time of all messages from here on.
    pub(crate) fn begin(&mut self, now: Now) {
        self.now = now;
    }

    /// A command of the shore is carried out, or 0: entries of the log book say which until then.
    pub(crate) fn carries_out(&mut self, command: u64) {
        self.command = command;
    }

    pub(crate) fn now(&self) -> Now {
        self.now
    }

    pub(crate) fn mono(&self) -> MonoTime {
        self.now.mono
    }

    pub(crate) fn utc(&self) -> UtcTime {
        self.now.utc
    }

    /// An earlier moment by the present clock.
    pub(crate) fn utc_of(&self, at: MonoTime) -> UtcTime {
        // A gap of days fits 63 bits of microseconds.
        UtcTime::from_micros(self.now.utc.micros() - self.now.mono.since(at).as_micros() as i64)
    }

    pub(crate) fn seconds(&self) -> f64 {
        self.now.utc.seconds()
    }

    pub(crate) fn address(&self) -> Address {
        self.address
    }

    pub(crate) fn poll(&mut self) -> Option<Output> {
        self.out.pop_front()
    }

    pub(crate) fn put(&mut self, output: Output) {
        self.out.push_back(output);
    }

    /// Asks for a route, in place of the previous one; answers its number.
    pub(crate) fn ask_route(&mut self, mut request: RouteRequest) -> u32 {
        self.routes = self.routes.wrapping_add(1);
        request.number = self.routes;
        self.put(Output::Route(Some(Box::new(request))));
        self.routes
    }

    /// A route is not wanted any more, unless another took its place since.
    pub(crate) fn give_up_route(&mut self, number: u32) {
        if number == self.routes {
            self.put(Output::Route(None));
        }
    }

    /// To all listeners.
    pub(crate) fn send<T: Payload>(&mut self, from: Entity, message: &T) {
        self.send_to(from, Asker::EVERYONE, message);
    }

    /// To the requester.
    pub(crate) fn send_to<T: Payload>(&mut self, from: Entity, to: Asker, message: &T) {
        let Some(bytes) = self.packet(from, to, message) else { return };
        let to = self.node.recipients(self.now.mono, T::ID, from.number(), to.system);
        self.out.push_back(Output::Packet { bytes, to });
    }

    /// The bytes of a packet; a message too large for one is dropped, and that is reported.
    pub(crate) fn packet<T: Payload>(&mut self, from: Entity, to: Asker, message: &T) -> Option<Vec<u8>> {
        let header = Header {
            timestamp: self.now.utc.seconds(),
            src: self.address,
            src_ent: from.number(),
            dst: to.system,
            dst_ent: to.entity,
        };
        let mut bytes = Vec::with_capacity(128);
        match imc::encode_into(&mut bytes, &header, message) {
            Ok(()) => Some(bytes),
            Err(error) => {
                self.lost += 1;
                self.console(Level::Error, format!("a message is lost: {error}"));
                None
            }
        }
    }

    /// A packet from outside, for the log and for `to`.
    pub(crate) fn pass_on(&mut self, bytes: Vec<u8>, to: Vec<Peer>) {
        self.out.push_back(Output::Packet { bytes, to });
    }

    /// A line for the console.
    pub(crate) fn console(&mut self, level: Level, text: String) {
        self.out.push_back(Output::Console(level, text));
    }

    /// An entry of the log book, which also goes to the console.
    pub(crate) fn entry(&mut self, from: Entity, level: Level, text: impl Into<String>) {
        self.entry_to(from, Asker::EVERYONE, level, text);
    }

    /// The same, to the requester.
    pub(crate) fn entry_to(&mut self, from: Entity, to: Asker, level: Level, text: impl Into<String>) {
        let mut text = text.into();
        if self.command > 0 {
            text.push_str(&imc::logbook::of_command(self.command));
        }
        let (context, _) = from.label_and_task();
        let kind = match level {
            Level::Debug => LogBookEntryType::Debug,
            Level::Info => LogBookEntryType::Info,
            Level::Warning => LogBookEntryType::Warning,
            Level::Error => LogBookEntryType::Error,
        };
        let entry = LogBookEntry {
            r#type: kind,
            htime: self.seconds(),
            context: context.into(),
            text: text.as_str().into(),
        };
        self.send_to(from, to, &entry);
        if self.entries.len() >= ENTRIES_KEPT {
            self.entries.pop_front();
        }
        self.entries.push_back(entry);
        self.console(level, format!("{context}: {text}"));
    }

    /// The entries kept, oldest first.
    pub(crate) fn entries(&self) -> impl Iterator<Item = &LogBookEntry> {
        self.entries.iter()
    }

    pub(crate) fn forget_entries(&mut self) {
        self.entries.clear();
    }
}
