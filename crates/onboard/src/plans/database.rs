//! The plan database, as DUNE's Plan.DB answers: plans by name, byte for byte as they came, with digests.
//!
//! A plan is kept as a whole little-endian packet, because its digest is over the bytes of the payload, and a
//! file of packets opens in any tool that reads logs.

use crate::bus::{Asker, Bus};
use crate::entity::Entity;
use crate::output::{Keep, Output, PlanChange, StoredPlan};
use imc::messages::{
    Message, PlanDB, PlanDBInformation, PlanDBOp, PlanDBState, PlanDBType, PlanSpecification,
};
use imc::{FOOTER_BYTES, HEADER_BYTES, Header, PacketView, plan_digest};
use std::collections::BTreeMap;

/// Plans kept; a full database refuses more.
const PLANS_KEPT: usize = 500;
/// Longest payload of a plan, so that a reply around it still fits a packet.
const LONGEST_PLAN: usize = 65_000;

#[derive(Debug, Clone)]
struct Entry {
    stored: StoredPlan,
    md5: [u8; 16],
    plan: PlanSpecification,
}

/// The plans.
#[derive(Debug, Clone, Default)]
pub(crate) struct Database {
    plans: BTreeMap<String, Entry>,
    changed: PlanChange,
    own_request: u16,
}

impl Database {
    /// With the plans that were kept. What does not read is left out and named.
    pub(crate) fn new(kept: Vec<StoredPlan>) -> (Self, Vec<String>) {
        let mut database = Self::default();
        let mut unreadable = Vec::new();
        for stored in kept {
            let Some(plan) = read(&stored.packet) else {
                unreadable.push(stored.id);
                continue;
            };
            if stored.change.time_s >= database.changed.time_s {
                database.changed = stored.change.clone();
            }
            let md5 = plan_digest::payload_md5(payload(&stored.packet));
            database.plans.insert(stored.id.clone(), Entry { stored, md5, plan });
        }
        (database, unreadable)
    }

    /// A plan by its name.
    pub(crate) fn plan(&self, id: &str) -> Option<&PlanSpecification> {
        self.plans.get(id).map(|entry| &entry.plan)
    }

    /// Answers a request.
    pub(crate) fn request(&mut self, bus: &mut Bus, asker: Asker, name: &str, request: &PlanDB) {
        if request.r#type != PlanDBType::Request {
            return;
        }
        let changes = matches!(request.op, PlanDBOp::Set | PlanDBOp::Del | PlanDBOp::Clear);
        let mut reply = PlanDB {
            op: request.op,
            request_id: request.request_id,
            plan_id: request.plan_id.clone(),
            ..PlanDB::default()
        };
        if matches!(request.op, PlanDBOp::Clear | PlanDBOp::GetState | PlanDBOp::GetDstate) {
            reply.plan_id = "".into();
        }
        if changes {
            let progress = PlanDB { r#type: PlanDBType::InProgress, info: "in progress".into(), ..reply.clone() };
            bus.send_to(Entity::PlanDatabase, asker, &progress);
        }
        let by = PlanChange { time_s: bus.seconds(), system: asker.system.0, name: name.to_owned() };
        let outcome = self.carry_out(bus, by, request);
        let (kind, arg, info) = match outcome {
            Ok((arg, info)) => (PlanDBType::Success, arg, info),
            Err(info) => (PlanDBType::Failure, None, info),
        };
        let reply = PlanDB { r#type: kind, arg, info: info.into(), ..reply };
        bus.send_to(Entity::PlanDatabase, asker, &reply);
    }

    fn carry_out(
        &mut self,
        bus: &mut Bus,
        by: PlanChange,
        request: &PlanDB,
    ) -> Result<(Option<Message>, String), String> {
        let id = request.plan_id.to_str_lossy().into_owned();
        let found = |database: &Self| database.plans.get(&id).cloned().ok_or("undefined plan".to_owned());
        match request.op {
            PlanDBOp::Set => {
                let Some(Message::PlanSpecification(plan)) = &request.arg else {
                    return Err("no plan specification given".to_owned());
                };
                if plan.plan_id != request.plan_id {
                    return Err("the plan has another id than the request".to_owned());
                }
                let info = if self.plans.contains_key(&id) { "OK (updated)" } else { "OK (new entry)" };
                let information = self.set(bus, by, plan)?;
                Ok((Some(information.into()), info.to_owned()))
            }
            PlanDBOp::Del => {
                found(self)?;
                self.plans.remove(&id);
                bus.put(Output::Keep(Keep::NoPlan(id)));
                self.change(bus, by);
                Ok((None, "OK".to_owned()))
            }
            PlanDBOp::Clear => {
                self.plans.clear();
                bus.put(Output::Keep(Keep::NoPlans));
                self.change(bus, by);
                Ok((None, "OK".to_owned()))
            }
            PlanDBOp::Get => Ok((Some(found(self)?.plan.into()), "OK".to_owned())),
            PlanDBOp::GetInfo => Ok((Some(information(&found(self)?).into()), "OK".to_owned())),
            PlanDBOp::GetState | PlanDBOp::GetDstate => Ok((Some(self.state().into()), "OK".to_owned())),
            PlanDBOp::Boot | PlanDBOp::Unlisted(_) => Err("unknown operation".to_owned()),
        }
    }

    /// Keeps a plan that came with a start, and tells everyone.
    pub(crate) fn keep_started(&mut self, bus: &mut Bus, by: PlanChange, plan: &PlanSpecification) {
        if self.plan(&plan.plan_id.to_str_lossy()) == Some(plan) {
            return;
        }
        if let Ok(information) = self.set(bus, by, plan) {
            self.own_request = self.own_request.wrapping_add(1);
            let told = PlanDB {
                r#type: PlanDBType::Success,
                op: PlanDBOp::Set,
                request_id: self.own_request,
                plan_id: plan.plan_id.clone(),
                arg: Some(information.into()),
                info: "OK".into(),
            };
            bus.send(Entity::PlanDatabase, &told);
        }
    }

    fn set(
        &mut self,
        bus: &mut Bus,
        by: PlanChange,
        plan: &PlanSpecification,
    ) -> Result<PlanDBInformation, String> {
        let id = plan.plan_id.as_str().filter(|id| !id.is_empty() && id.len() <= 200);
        let id = id.ok_or("a plan needs a name of 1 to 200 bytes of text")?.to_owned();
        if self.plans.len() >= PLANS_KEPT && !self.plans.contains_key(&id) {
            return Err(format!("the database is full with {PLANS_KEPT} plans"));
        }
        let mut packet = Vec::new();
        imc::encode_into(&mut packet, &Header::default(), plan).map_err(|error| error.to_string())?;
        if payload(&packet).len() > LONGEST_PLAN {
            return Err(format!("the plan is longer than {LONGEST_PLAN} bytes"));
        }
        let md5 = plan_digest::payload_md5(payload(&packet));
        let stored = StoredPlan { id: id.clone(), change: by.clone(), packet };
        bus.put(Output::Keep(Keep::Plan(stored.clone())));
        let entry = Entry { stored, md5, plan: plan.clone() };
        let information = information(&entry);
        self.plans.insert(id, entry);
        self.change(bus, by);
        Ok(information)
    }

    fn change(&mut self, bus: &mut Bus, by: PlanChange) {
        self.changed = by.clone();
        bus.put(Output::Keep(Keep::LastChange(by)));
    }

    /// The state of the whole database.
    pub(crate) fn state(&self) -> PlanDBState {
        let digests = self.plans.iter().map(|(id, entry)| (id.as_bytes(), entry.md5));
        PlanDBState {
            plan_count: self.plans.len() as u16,
            plan_size: self.plans.values().map(|entry| payload(&entry.stored.packet).len() as u32).sum(),
            change_time: self.changed.time_s,
            change_sid: self.changed.system,
            change_sname: self.changed.name.as_str().into(),
            md5: plan_digest::database_md5(digests).to_vec(),
            plans_info: self.plans.values().map(information).collect(),
        }
    }
}

fn information(entry: &Entry) -> PlanDBInformation {
    let StoredPlan { id, change, packet } = &entry.stored;
    PlanDBInformation {
        plan_id: id.as_str().into(),
        // A payload has at most 65535 bytes.
        plan_size: payload(packet).len() as u16,
        change_time: change.time_s,
        change_sid: change.system,
        change_sname: change.name.as_str().into(),
        md5: entry.md5.to_vec(),
    }
}

/// A plan from its packet.
fn read(packet: &[u8]) -> Option<PlanSpecification> {
    imc::decode(&PacketView::new(packet).ok()?).ok()?
}

/// What is between header and checksum; nothing of what is too short for a packet.
fn payload(packet: &[u8]) -> &[u8] {
    let end = packet.len().saturating_sub(FOOTER_BYTES);
    packet.get(HEADER_BYTES..end).unwrap_or_default()
}
