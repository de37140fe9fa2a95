//! Reports of vessels on request: parameters, and the plan that they execute. A request commands nothing, so every user who
//! may see a vessel may send one; the hub sends each request once for all users.

use crate::commands::Grounding;
use crate::error::{Error, ErrorKind, Result, slow};
use crate::history::{self, History};
use crate::router::Router;
use crate::{parameters, plans};
use api::{PlanUnderWay, VesselParameters, VesselQuery, VesselQuerySent, say};
use imc::Address;
use imc::messages::PlanSpecification;
use operations::{Operations, Question};
use units::Now;

/// Characters of a plan's or an entity's name.
const NAME: std::ops::RangeInclusive<usize> = 1..=100;

/// The reports of vessels; cheap to clone.
#[derive(Clone)]
pub struct Reports {
    router: Router,
    history: History,
    grounding: Grounding,
}

impl Reports {
    pub(crate) fn new(router: Router, history: History, grounding: Grounding) -> Self {
        Self { router, history, grounding }
    }

    /// The parameters that a vessel reported last: since the server started, else by the history.
    ///
    /// # Errors
    /// The history cannot be read, or the server is stopping.
    pub async fn parameters(&self, vessel: Address) -> Result<VesselParameters> {
        let ask = move |operations: &mut Operations, _| parameters::reported(operations, vessel);
        let reported = self.router.ask(ask).await?;
        if !reported.is_empty() {
            return Ok(parameters::described(reported, false));
        }
        let now_us = self.router.clock().utc().micros();
        let at = self.history.ask(move |reader| history::at(reader, vessel, now_us)).await?;
        Ok(parameters::described(parameters::recorded(&at), true))
    }

    /// Sends a request to a vessel.
    ///
    /// # Errors
    /// The request is not valid, or the vessel has not reported which entities it has.
    pub async fn ask(&self, vessel: Address, asked: VesselQuery) -> Result<VesselQuerySent> {
        if let VesselQuery::Plan { plan_id: name } = &asked
            && (!NAME.contains(&name.chars().count()) || name.chars().any(char::is_control))
        {
            let (least, most) = NAME.into_inner();
            return Err(Error::refused(
                say("plan_id: give {least} to {most} characters, without control characters")
                    .with("least", least)
                    .with("most", most),
            ));
        }
        let send = move |operations: &mut Operations, now: Now| {
            let (questions, entities) = questions(operations, vessel, asked)?;
            let asked = operations.commands_mut().reports_mut().ask(now, vessel, &questions);
            let packets = asked.map_err(Error::refused)?;
            let reached = operations.hub().reaches(now.mono, vessel);
            for packet in &packets {
                operations.hub_mut().send(now, packet);
            }
            let packets = u32::try_from(packets.len()).unwrap_or(u32::MAX);
            Ok(VesselQuerySent { time_us: now.utc.micros(), packets, reached, entities })
        };
        self.router.ask(send).await?
    }

    /// The plan that a vessel executes, as far as it is known.
    ///
    /// # Errors
    /// Plans cannot be read, or the server is stopping.
    pub async fn plan(&self, vessel: Address) -> Result<PlanUnderWay> {
        let known = self.router.ask(move |operations, _| sailed(operations, vessel)).await?;
        let nothing = PlanUnderWay {
            plan_id: None,
            maneuver: String::new(),
            source: None,
            digest: None,
            legs: Vec::new(),
            repeats: false,
            trouble: None,
        };
        let Some(Known { plan_id, maneuver, plan }) = known else { return Ok(nothing) };
        let (plan, source) = match plan {
            Some(plan) => (Some(plan), "vessel"),
            None => (self.grounding.drawn_here(vessel, plan_id.clone()).await?, "shore"),
        };
        let under_way = PlanUnderWay { plan_id: Some(plan_id), maneuver, ..nothing };
        let Some(plan) = plan else {
            let trouble =
                "The vessel has not reported this plan, and no plan ashore has its digest.".to_owned();
            return Ok(PlanUnderWay { trouble: Some(trouble), ..under_way });
        };
        // Laying out a long plan takes some milliseconds and must not block other tasks.
        let draw = move || (imc::plan_digest::plan_md5(&plan).ok().map(hex::encode), plans::route(&plan));
        let (digest, route) = slow(draw).await?;
        let under_way = PlanUnderWay { source: Some(source.to_owned()), digest, ..under_way };
        Ok(match route {
            Ok((legs, repeats)) => PlanUnderWay { legs, repeats, ..under_way },
            Err(why) => {
                PlanUnderWay { trouble: Some(format!("The plan cannot be drawn: {why}")), ..under_way }
            }
        })
    }
}

/// The requests, and their entities.
fn questions(
    operations: &Operations,
    vessel: Address,
    ask: VesselQuery,
) -> Result<(Vec<Question>, Vec<String>)> {
    let entities = match ask {
        VesselQuery::Plans {} => return Ok((vec![Question::Plans], Vec::new())),
        VesselQuery::Plan { plan_id } => return Ok((vec![Question::Plan(plan_id)], Vec::new())),
        VesselQuery::Parameters { entities } => entities,
    };
    let mut known: Vec<String> = operations
        .fleet()
        .system(vessel)
        .map(|one| one.entities().values().cloned().collect())
        .unwrap_or_default();
    known.sort_unstable();
    known.dedup();
    if known.is_empty() {
        let text = say(
            "The vessel has not reported which entities it has. It is asked for them as soon as it is heard.",
        );
        return Err(Error::new(ErrorKind::UnknownEntities, text));
    }
    if let Some(one) = entities.iter().find(|one| !known.contains(one)) {
        let one: String = one.chars().take(*NAME.end()).collect();
        return Err(Error::refused(say("entities: the vessel has no entity `{entity}`").with("entity", one)));
    }
    let asked = if entities.is_empty() { known } else { entities };
    Ok((asked.iter().cloned().map(Question::Parameters).collect(), asked))
}

/// What the hub knows of the plan that a vessel executes.
struct Known {
    plan_id: String,
    maneuver: String,
    plan: Option<PlanSpecification>,
}

fn sailed(operations: &Operations, vessel: Address) -> Option<Known> {
    let state = operations.plan_state(vessel)?;
    let plan_id = state.plan_id.to_str_lossy().into_owned();
    Some(Known {
        plan: operations.commands().reports().plan(vessel, &plan_id).map(|report| report.plan.clone()),
        plan_id,
        maneuver: state.man_id.to_str_lossy().into_owned(),
    })
}
