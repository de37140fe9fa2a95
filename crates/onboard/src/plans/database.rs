//! The plan database on the bus: IMC's PlanDB in front of the mission's database.
//!
//! A plan is kept as a whole little-endian packet, so that any tool that reads logs opens it; its digest and
//! size are those of the payload alone, as consoles reckon them.

use crate::bus::{Asker, Bus};
use crate::entity::Entity;
use crate::output::{Keep, Output};
use imc::messages::{
    Message, PlanDB, PlanDBInformation, PlanDBOp, PlanDBState, PlanDBType, PlanSpecification,
};
use imc::{ANY_ENTITY, Address, FOOTER_BYTES, HEADER_BYTES, Header, Nested, PacketView, plan_digest};
use mission::{
    Answer, DatabaseLimits, DatabaseQuery, DatabaseReply, DatabaseRequest, DatabaseState, Kept, Origin,
    Outgoing, PlanDatabase, PlanInfo, Ticket,
};
use std::collections::BTreeMap;

/// Header and footer around a payload.
const AROUND: usize = HEADER_BYTES + FOOTER_BYTES;
/// Longest plan (bytes of its packet), so that a reply around it still fits a packet.
pub const LONGEST_PLAN: usize = 65_000;
/// Plans kept: with the longest names the state of all, 36 bytes and both names for each, still fits a packet.
const PLANS_KEPT: usize = 400;
/// Longest name of a plan and of its last editor (bytes).
pub const LONGEST_NAME: usize = 60;

/// The plans, and the operations that must be answered.
#[derive(Debug)]
pub(crate) struct Database {
    plans: PlanDatabase,
    asked: BTreeMap<Origin, PlanDBOp>,
    own_request: u16,
}

impl Database {
    /// With the plans that were kept, and the names of those that cannot be read.
    pub(crate) fn new(kept: Kept) -> (Self, Vec<String>) {
        let (plans, bad): (Vec<_>, Vec<_>) =
            kept.plans.into_iter().partition(|record| read(&record.bytes).is_some());
        let limits = DatabaseLimits {
            max_plans: PLANS_KEPT,
            max_plan_bytes: LONGEST_PLAN,
            max_name_bytes: LONGEST_NAME,
            ..DatabaseLimits::default()
        };
        let plans = PlanDatabase::new(limits, Kept { plans, ..kept });
        let database = Self { plans, asked: BTreeMap::new(), own_request: 0 };
        (database, bad.into_iter().map(|record| record.plan_id).collect())
    }

    /// A plan by its name.
    pub(crate) fn plan(&self, id: &str) -> Option<PlanSpecification> {
        self.plans.get(id).and_then(|record| read(&record.bytes))
    }

    /// Takes a request.
    pub(crate) fn request(&mut self, bus: &mut Bus, asker: Asker, name: &str, request: &PlanDB) {
        if request.r#type != PlanDBType::Request {
            return;
        }
        let origin = Origin { system: asker.system.0, entity: asker.entity, request: request.request_id };
        let ask = match (request.op, request.arg.of::<PlanSpecification>()) {
            (PlanDBOp::Set, Some(plan)) => set(&plan),
            (PlanDBOp::Set, _) => Err("no plan specification given".to_owned()),
            (PlanDBOp::Del, _) => Ok(DatabaseQuery::Delete),
            (PlanDBOp::Get, _) => Ok(DatabaseQuery::Get),
            (PlanDBOp::GetInfo, _) => Ok(DatabaseQuery::GetInfo),
            (PlanDBOp::Clear, _) => Ok(DatabaseQuery::Clear),
            (PlanDBOp::GetState | PlanDBOp::GetDstate, _) => Ok(DatabaseQuery::GetState),
            (PlanDBOp::Boot | PlanDBOp::Unlisted(_), _) => Err("unknown operation".to_owned()),
        };
        let plan_id = request.plan_id.to_str_lossy().into_owned();
        match ask {
            Ok(ask) => {
                self.asked.insert(origin, request.op);
                let request = DatabaseRequest { origin, name: cut(name), plan_id, ask };
                self.plans.handle(bus.utc(), request);
            }
            Err(info) => self.refuse(bus, asker, request, info),
        }
        self.drain(bus);
    }

    /// Answers that a request is not possible.
    #[expect(clippy::unused_self, reason = "it is the database that answers")]
    pub(crate) fn refuse(&self, bus: &mut Bus, asker: Asker, request: &PlanDB, info: String) {
        let reply = PlanDB {
            r#type: PlanDBType::Failure,
            op: request.op,
            request_id: request.request_id,
            plan_id: request.plan_id.clone(),
            arg: Nested::none(),
            info: info.into(),
        };
        bus.send_to(Entity::PlanDatabase, asker, &reply);
    }

    /// Stores a plan that came with a start, and informs all systems.
    pub(crate) fn keep_started(&mut self, bus: &mut Bus, name: &str, plan: &PlanSpecification) {
        let plan_id = plan.plan_id.to_str_lossy().into_owned();
        if self.plan(&plan_id).as_ref() == Some(plan) {
            return;
        }
        let Ok(ask) = set(plan) else { return };
        self.own_request = self.own_request.wrapping_add(1);
        let origin = Origin {
            system: bus.address().0,
            entity: Entity::PlanDatabase.number(),
            request: self.own_request,
        };
        self.asked.insert(origin, PlanDBOp::Set);
        self.plans.handle(bus.utc(), DatabaseRequest { origin, name: cut(name), plan_id, ask });
        self.drain(bus);
    }

    /// A change is on the disk, or could not be brought there.
    pub(crate) fn stored(&mut self, bus: &mut Bus, ticket: Ticket, result: Result<(), String>) {
        self.plans.stored(ticket, result);
        self.drain(bus);
    }

    fn drain(&mut self, bus: &mut Bus) {
        while let Some(outgoing) = self.plans.poll_outgoing() {
            match outgoing {
                Outgoing::Effect(effect) => bus.put(Output::Keep(Keep::Plans(effect))),
                Outgoing::Reply(reply) => self.reply(bus, reply),
            }
        }
    }

    fn reply(&mut self, bus: &mut Bus, reply: DatabaseReply) {
        let DatabaseReply { origin, plan_id, result, operation: _ } = reply;
        let op = self.asked.get(&origin).copied().unwrap_or_default();
        let own = origin.system == bus.address().0;
        let (kind, arg, info) = match result {
            None if own => return,
            None => (PlanDBType::InProgress, None, "in progress".to_owned()),
            Some(result) => {
                self.asked.remove(&origin);
                match result {
                    Ok(answer) => {
                        let (arg, info) = answered(&answer);
                        match arg {
                            // Plans that an older version kept may be too many.
                            Some(arg) if !fits(&arg) => {
                                let info = "the answer does not fit a packet; delete some plans".to_owned();
                                (PlanDBType::Failure, None, info)
                            }
                            arg => (PlanDBType::Success, arg, info.to_owned()),
                        }
                    }
                    Err(error) => (PlanDBType::Failure, None, error.to_string()),
                }
            }
        };
        // A request about all plans names none.
        let for_all = matches!(op, PlanDBOp::Clear | PlanDBOp::GetState | PlanDBOp::GetDstate);
        let plan_id = if for_all { String::new() } else { plan_id };
        let asker = if own {
            Asker::EVERYONE
        } else {
            Asker { system: Address(origin.system), entity: origin.entity }
        };
        let message = PlanDB {
            r#type: kind,
            op,
            request_id: origin.request,
            plan_id: plan_id.into(),
            arg: arg.into(),
            info: info.into(),
        };
        bus.send_to(Entity::PlanDatabase, asker, &message);
    }
}

/// A name that fits the state of all plans.
fn cut(name: &str) -> String {
    name.chars()
        .scan(0, |bytes, c| {
            *bytes += c.len_utf8();
            (*bytes <= LONGEST_NAME).then_some(c)
        })
        .collect()
}

/// Whether a reply around this message fits a packet.
fn fits(arg: &Message) -> bool {
    let reply = PlanDB { arg: arg.clone().into(), info: "OK (new entry)".into(), ..PlanDB::default() };
    imc::encode_into(&mut Vec::new(), &Header::default(), &reply).is_ok()
}

fn set(plan: &PlanSpecification) -> Result<DatabaseQuery, String> {
    let named = plan.plan_id.as_str().ok_or("the plan's name is not a text")?.to_owned();
    let mut bytes = Vec::new();
    let header = Header { src_ent: ANY_ENTITY, ..Header::default() };
    imc::encode_into(&mut bytes, &header, plan).map_err(|error| error.to_string())?;
    let digest = plan_digest::payload_md5(payload(&bytes));
    Ok(DatabaseQuery::Set { bytes, digest, named })
}

fn answered(answer: &Answer) -> (Option<Message>, &'static str) {
    match answer {
        Answer::Stored { info, replaced } => {
            let text = if *replaced { "OK (updated)" } else { "OK (new entry)" };
            (Some(information(info).into()), text)
        }
        Answer::Removed => (None, "OK"),
        Answer::Plan(record) => (read(&record.bytes).map(Message::from), "OK"),
        Answer::Info(info) => (Some(information(info).into()), "OK"),
        Answer::State(state) => (Some(whole(state).into()), "OK"),
    }
}

fn whole(state: &DatabaseState) -> PlanDBState {
    let digests = state.plans.iter().map(|info| (info.plan_id.as_bytes(), info.digest));
    let change = state.last_change.clone().unwrap_or_default();
    PlanDBState {
        // Some hundreds of plans of at most 65 kB each.
        plan_count: state.plans.len() as u16,
        plan_size: state.plans.iter().map(|info| u32::from(size(info))).sum(),
        change_time: change.at.seconds(),
        change_sid: change.system,
        change_sname: change.name.into(),
        md5: plan_digest::database_md5(digests).to_vec(),
        plans_info: state.plans.iter().map(information).collect(),
    }
}

fn information(info: &PlanInfo) -> PlanDBInformation {
    PlanDBInformation {
        plan_id: info.plan_id.as_str().into(),
        plan_size: size(info),
        change_time: info.change.at.seconds(),
        change_sid: info.change.system,
        change_sname: info.change.name.as_str().into(),
        md5: info.digest.to_vec(),
    }
}

/// Size of a plan's payload, which has at most 65535 bytes.
fn size(info: &PlanInfo) -> u16 {
    info.bytes.saturating_sub(AROUND) as u16
}

/// A plan from its packet.
fn read(packet: &[u8]) -> Option<PlanSpecification> {
    imc::decode(&PacketView::new(packet).ok()?).ok()?
}

/// The bytes between header and checksum; empty if too short for a packet.
fn payload(packet: &[u8]) -> &[u8] {
    packet.get(HEADER_BYTES..packet.len().saturating_sub(FOOTER_BYTES)).unwrap_or_default()
}
