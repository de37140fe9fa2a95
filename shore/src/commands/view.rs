//! Leases and commands, as the API reports them.

use crate::charts::verdict;
use crate::{Wanted, decode};
use imc::Address;
use imc::messages::{PlanManeuver, PlanSpecification};
use imc::{Header, Packet};
use operations::{Answer, Command, Lease, Operations, PlanAboard, Stage};
use units::{LatLon, UtcTime};

/// The leases and commands that changed after these revisions.
pub(crate) fn changes(
    operations: &Operations,
    (leases, commands): (u64, u64),
    wanted: &Wanted,
) -> (Vec<api::Lease>, Vec<api::Command>) {
    let admitted = |vessel: Address| wanted.admits_system(vessel.0);
    let changed = operations.leases().changed(leases).filter(|(vessel, _)| admitted(*vessel));
    let further = operations.commands().changed(commands).filter(|one| admitted(one.vessel));
    (changed.map(|(vessel, one)| lease(vessel, one)).collect(), further.map(command).collect())
}

/// The lease of a vessel.
pub fn lease(vessel: Address, lease: &Lease) -> api::Lease {
    let Lease { held, waiting, last, .. } = lease;
    api::Lease {
        vessel: vessel.0,
        holder: held.as_ref().map(|held| api::LeaseHolder {
            name: held.holder.name.clone(),
            window: held.holder.key.clone(),
            since_us: held.since.micros(),
            until_us: held.until.micros(),
        }),
        waiting: waiting.as_ref().map(|waiting| api::LeaseWaiting {
            name: waiting.who.name.clone(),
            window: waiting.who.key.clone(),
            reason: waiting.reason.clone(),
            granted_us: waiting.granted_at.micros(),
        }),
        last: last.as_ref().map(|last| api::LeaseChange {
            change: last.change.name().to_owned(),
            who: last.who.clone(),
            from: last.from.clone(),
            reason: last.reason.clone(),
            time_us: last.at.micros(),
        }),
    }
}

/// A command without the vessel's answer.
pub fn command(command: &Command) -> api::Command {
    let step = |step: &operations::Step| api::CommandStep {
        stage: step.stage.name().to_owned(),
        time_us: step.at.micros(),
        text: step.in_full().into(),
        says: step.text.wording().cloned(),
        late: step.late,
        leg: (step.stage == Stage::Refused).then(|| verdict::of_words(&step.text)).flatten(),
    };
    api::Command {
        id: command.id.0,
        vessel: command.vessel.0,
        by: command.by.name.clone(),
        order: command.verb.to_owned(),
        subject: command.subject.clone(),
        steps: command.steps.iter().map(step).collect(),
        over: command.is_over(),
        plan: None,
        parameters: None,
    }
}

/// A command with the vessel's answer.
pub fn whole(one: &Command) -> api::Command {
    let (plan, parameters) = match &one.answer {
        Some(Answer::Plan(plan)) => (Some(given(plan)), None),
        Some(Answer::Parameters(values)) => {
            let parameter = |(name, value): &(String, String)| api::Parameter {
                name: name.clone(),
                value: value.clone(),
            };
            (None, Some(values.iter().map(parameter).collect()))
        }
        None => (None, None),
    };
    api::Command { plan, parameters, ..command(one) }
}

/// The plans that a vessel stores.
pub fn aboard(aboard: Option<&operations::PlansAboard>) -> api::PlansAboard {
    let plan = |plan: &PlanAboard| api::PlanAboard {
        plan_id: plan.plan_id.clone(),
        size: plan.size,
        changed_us: plan.changed.map(UtcTime::micros),
        changed_by: plan.changed_by.clone(),
        md5: hex::encode(&plan.md5),
    };
    api::PlansAboard {
        time_us: aboard.map(|aboard| aboard.at.micros()),
        plans: aboard.map(|aboard| aboard.plans.iter().map(plan).collect()).unwrap_or_default(),
    }
}

fn given(plan: &PlanSpecification) -> api::PlanGiven {
    let specification = imc::json::message_to_string(&plan.clone().into())
        .ok()
        .and_then(|text| serde_json::from_str(&text).ok());
    api::PlanGiven {
        plan_id: plan.plan_id.to_str_lossy().into_owned(),
        md5: imc::plan_digest::plan_md5(plan).map(hex::encode).unwrap_or_default(),
        maneuvers: u32::try_from(plan.maneuvers.len()).unwrap_or(u32::MAX),
        first_deg: first(plan).map(|place| [place.lat_deg(), place.lon_deg()]),
        specification: specification.unwrap_or_default(),
    }
}

/// Where the first maneuver begins: the place in its fields `lat` and `lon`, which every maneuver with a place has.
fn first(plan: &PlanSpecification) -> Option<LatLon> {
    let start = |one: &PlanManeuver| one.maneuver_id == plan.start_man_id;
    let maneuver = plan.maneuvers.of::<PlanManeuver>().find(start)?.data.get()?;
    let packet = Packet::new(Header::default(), maneuver).encode().ok()?;
    let update = decode::packet(&packet, None, UtcTime::from_micros(0), None)?;
    let number = |name: &str| update.fields.iter().find(|field| field.name == name)?.value.as_f64();
    LatLon::from_rad(number("lat")?, number("lon")?).ok()
}
