//! What vessels tell of themselves: parameters, and the plan that they sail. Asking commands nothing, so whoever may
//! see a vessel may ask it; the hub asks each question once, however many people look.

use super::control::InBody;
use super::error::ApiError;
use super::grounding;
use super::guard::OfVessel;
use crate::plans;
use crate::shore::{AppState, history, parameters};
use api::{PlanUnderWay, VesselAsk, VesselAsked, VesselParameters};
use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use hub::{Hub, Question};
use imc::messages::{Payload as _, PlanControlState, PlanControlStateState, PlanSpecification};
use imc::{Address, PacketView};

/// Letters of a plan's or an entity's name.
const NAME: std::ops::RangeInclusive<usize> = 1..=100;

/// `GET /api/v1/vessels/{vessel}/parameters`.
pub(crate) async fn parameters(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
) -> Result<Json<VesselParameters>, ApiError> {
    let look = move |hub: &mut Hub, _| parameters::told(hub, vessel);
    let told = state.relay.look(look).await.map_err(|_| ApiError::stopping())?;
    if !told.is_empty() {
        return Ok(Json(parameters::described(told, false)));
    }
    let now_us = state.clock.utc().micros();
    let at = state.history.ask(move |reader| history::at(reader, vessel, now_us)).await?;
    Ok(Json(parameters::described(parameters::recorded(&at), true)))
}

/// `POST /api/v1/vessels/{vessel}/ask`.
pub(crate) async fn ask(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
    InBody(asked): InBody<VesselAsk>,
) -> Result<Json<VesselAsked>, ApiError> {
    if let VesselAsk::Plan { plan_id: name } = &asked
        && (!NAME.contains(&name.chars().count()) || name.chars().any(char::is_control))
    {
        let (least, most) = NAME.into_inner();
        return Err(refused(format!("plan_id: give {least} to {most} letters, none of control")));
    }
    let send = move |hub: &mut Hub, now: hub::Now| {
        let (questions, entities) = questions(hub, vessel, asked)?;
        let packets = hub.commands_mut().told_mut().ask(now, vessel, &questions).map_err(refused)?;
        let reached = hub.reaches(now.mono, vessel);
        for packet in &packets {
            hub.send(now, packet);
        }
        let packets = u32::try_from(packets.len()).unwrap_or(u32::MAX);
        Ok::<_, ApiError>(VesselAsked { time_us: now.utc.micros(), packets, reached, entities })
    };
    Ok(Json(state.relay.look(send).await.map_err(|_| ApiError::stopping())??))
}

/// The questions, and of which entities they are.
fn questions(hub: &Hub, vessel: Address, ask: VesselAsk) -> Result<(Vec<Question>, Vec<String>), ApiError> {
    let entities = match ask {
        VesselAsk::Plans {} => return Ok((vec![Question::Plans], Vec::new())),
        VesselAsk::Plan { plan_id } => return Ok((vec![Question::Plan(plan_id)], Vec::new())),
        VesselAsk::Parameters { entities } => entities,
    };
    let mut known: Vec<String> =
        hub.fleet().system(vessel).map(|one| one.entities().values().cloned().collect()).unwrap_or_default();
    known.sort_unstable();
    known.dedup();
    if known.is_empty() {
        let text =
            "The vessel has not told which entities it has. It is asked for them as soon as it is heard.";
        return Err(ApiError::new(StatusCode::CONFLICT, "unknown_entities", text));
    }
    if let Some(one) = entities.iter().find(|one| !known.contains(one)) {
        let one: String = one.chars().take(*NAME.end()).collect();
        return Err(refused(format!("entities: the vessel has no entity {one:?}")));
    }
    let asked = if entities.is_empty() { known } else { entities };
    Ok((asked.iter().cloned().map(Question::Parameters).collect(), asked))
}

/// What the hub knows of the plan that a vessel sails.
struct Known {
    plan_id: String,
    maneuver: String,
    plan: Option<PlanSpecification>,
}

/// `GET /api/v1/vessels/{vessel}/plan`.
pub(crate) async fn plan(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
) -> Result<Json<PlanUnderWay>, ApiError> {
    let look = move |hub: &mut Hub, _| sailed(hub, vessel);
    let known = state.relay.look(look).await.map_err(|_| ApiError::stopping())?;
    let nothing = PlanUnderWay {
        plan_id: None,
        maneuver: String::new(),
        source: None,
        digest: None,
        legs: Vec::new(),
        repeats: false,
        trouble: None,
    };
    let Some(Known { plan_id, maneuver, plan }) = known else { return Ok(Json(nothing)) };
    let (plan, source) = match plan {
        Some(plan) => (Some(plan), "vessel"),
        None => (grounding::drawn_here(&state, vessel, plan_id.clone()).await?, "shore"),
    };
    let under_way = PlanUnderWay { plan_id: Some(plan_id), maneuver, ..nothing };
    let Some(plan) = plan else {
        let trouble = "The vessel has not told this plan, and none kept ashore has its digest.".to_owned();
        return Ok(Json(PlanUnderWay { trouble: Some(trouble), ..under_way }));
    };
    // Laying out a long plan takes some milliseconds, which others need not wait for.
    let drawn = tokio::task::spawn_blocking(move || {
        (imc::plan_digest::plan_md5(&plan).ok().map(hex::encode), plans::route(&plan))
    });
    let (digest, route) = drawn.await.map_err(|error| ApiError::internal(&error))?;
    let under_way = PlanUnderWay { source: Some(source.to_owned()), digest, ..under_way };
    Ok(Json(match route {
        Ok((legs, repeats)) => PlanUnderWay { legs, repeats, ..under_way },
        Err(why) => PlanUnderWay { trouble: Some(format!("The plan cannot be drawn: {why}")), ..under_way },
    }))
}

fn sailed(hub: &Hub, vessel: Address) -> Option<Known> {
    let (_, series) = hub.fleet().system(vessel)?.latest(PlanControlState::ID)?;
    let state: PlanControlState = imc::decode(&PacketView::unchecked(series.packet()).ok()?).ok()??;
    let runs = matches!(state.state, PlanControlStateState::Executing | PlanControlStateState::Initializing);
    let plan_id = state.plan_id.to_str_lossy().into_owned();
    runs.then(|| Known {
        plan: hub.commands().told().plan(vessel, &plan_id).map(|told| told.plan.clone()),
        plan_id,
        maneuver: state.man_id.to_str_lossy().into_owned(),
    })
}

fn refused(text: String) -> ApiError {
    ApiError::new(StatusCode::UNPROCESSABLE_ENTITY, "refused", text)
}
