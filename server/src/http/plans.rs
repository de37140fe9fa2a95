//! Plans for programs and for the editor.
//!
//! A plan of a vessel is visible to users who may see the vessel and changed by its operators; a plan of no vessel is
//! visible to all and changed by operators of any vessel. Saving drafts is not audited: the revisions have the author.

use crate::AppState;
use crate::web::{ApiError, InBody, InPath, QueryParams, Remote, Who, WholeBody, extract};
use api::{
    Command, ImportedPlan, PlanChange, PlanCheck, PlanDocument, PlanExportQuery, PlanImportQuery, PlanQuery,
    PlanRevision, PlanSummary, PlanUploadRequest, RefusalReason, Role, Said, StoredPlan, say,
};
use axum::Json;
use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use imc::Address;
use serde_json::json;
use shore::commands::Issuer;
use shore::identity::{Fault, Principal};
use shore::plans::{self, Change, Format, Row};
use units::UtcTime;

/// Characters of a file's name.
const FILE_NAME: std::ops::RangeInclusive<usize> = 1..=200;

/// A body, taken after rights were checked.
type Sent<T> = Result<InBody<T>, ApiError>;

/// `GET /api/v1/plans`.
pub(crate) async fn list(
    State(state): State<AppState>,
    Who(who): Who,
) -> Result<Json<Vec<PlanSummary>>, ApiError> {
    let mut rows = state.shore.people.ask(plans::List).await?;
    rows.retain(|row| may_see(&who, row.plan.vessel));
    let now = state.shore.clock.utc();
    Ok(Json(slow(move || rows.into_iter().map(|row| summary(row, now)).collect()).await?))
}

/// `POST /api/v1/plans`.
pub(crate) async fn create(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    sent: Sent<PlanDocument>,
) -> Result<Json<StoredPlan>, ApiError> {
    let plan = taken(sent)?;
    keep_new(&state, &who, remote, "plan.create", plan).await.map(Json)
}

/// `GET /api/v1/plans/{id}`.
pub(crate) async fn read(
    State(state): State<AppState>,
    Who(who): Who,
    InPath(id): InPath<i64>,
    QueryParams(query): QueryParams<PlanQuery>,
) -> Result<Json<StoredPlan>, ApiError> {
    let row = find(&state, &who, id, query.revision).await?;
    stored(&state, &who, row).await.map(Json)
}

/// `GET /api/v1/plans/{id}/revisions`.
pub(crate) async fn revisions(
    State(state): State<AppState>,
    Who(who): Who,
    InPath(id): InPath<i64>,
) -> Result<Json<Vec<PlanRevision>>, ApiError> {
    find(&state, &who, id, None).await?;
    Ok(Json(state.shore.people.ask(plans::Revisions(id)).await?))
}

/// `PUT /api/v1/plans/{id}`: 409 with the newer plan when there is one.
pub(crate) async fn save(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    InPath(id): InPath<i64>,
    sent: Sent<PlanChange>,
) -> Result<Response, ApiError> {
    let row = find(&state, &who, id, None).await?;
    may_change(&who, row.plan.vessel)?;
    let PlanChange { revision: from, draft, plan } = taken(sent)?;
    may_change(&who, plan.vessel)?;
    plans::limits(&plan).map_err(refused)?;
    let now = state.shore.clock.utc();
    if !draft {
        let judged = plan.clone();
        let check = slow(move || plans::check(&judged, now)).await?;
        if let Some(first) = check.problems.first() {
            let count = check.problems.len();
            let text = if count == 1 {
                say("The plan has a problem and stays a draft: {first}")
            } else {
                say("The plan has {count} problems and stays a draft: {first}")
            };
            return Err(refused(text.with("count", count).with_said("first", plans::said(first))));
        }
    }
    let subject = plan.name.clone();
    let save = plans::Save { id, from, plan, change: Change { author: who.name.clone(), now, draft } };
    let done = if draft {
        state.shore.people.change(save).await
    } else {
        state.shore.people.act(&who, remote.address.to_string(), "plan.save", subject, save).await
    };
    let row = find(&state, &who, id, None).await?;
    match done {
        Ok(()) => Ok(Json(stored(&state, &who, row).await?).into_response()),
        Err(Fault::Refused(text)) if row.revision != from => {
            let newer = stored(&state, &who, row).await?;
            let (text, says) = text.into_parts();
            let error = RefusalReason { code: "newer_revision".to_owned(), text, says, ..Default::default() };
            let body = json!({ "error": error, "newer": newer });
            Ok((StatusCode::CONFLICT, Json(body)).into_response())
        }
        Err(fault) => Err(fault.into()),
    }
}

/// `POST /api/v1/plans/{id}/duplicate`.
pub(crate) async fn duplicate(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    InPath(id): InPath<i64>,
) -> Result<Json<StoredPlan>, ApiError> {
    let row = find(&state, &who, id, None).await?;
    keep_new(&state, &who, remote, "plan.duplicate", row.plan).await.map(Json)
}

/// `DELETE /api/v1/plans/{id}`.
pub(crate) async fn delete(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    InPath(id): InPath<i64>,
) -> Result<(), ApiError> {
    let row = find(&state, &who, id, None).await?;
    may_change(&who, row.plan.vessel)?;
    let delete = plans::Delete { id, now: state.shore.clock.utc() };
    Ok(state.shore.people.act(&who, remote.address.to_string(), "plan.delete", row.plan.name, delete).await?)
}

/// `POST /api/v1/plans/{id}/restore`.
pub(crate) async fn restore(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    InPath(id): InPath<i64>,
) -> Result<Json<StoredPlan>, ApiError> {
    let row = state.shore.people.ask(plans::Load { id, revision: None }).await?;
    let row = row.filter(|row| may_see(&who, row.plan.vessel)).ok_or_else(no_such)?;
    may_change(&who, row.plan.vessel)?;
    let change = Change { author: who.name.clone(), now: state.shore.clock.utc(), draft: false };
    let restore = plans::Restore { id, change };
    state.shore.people.act(&who, remote.address.to_string(), "plan.restore", row.plan.name, restore).await?;
    stored(&state, &who, find(&state, &who, id, None).await?).await.map(Json)
}

/// `POST /api/v1/plans/check`.
pub(crate) async fn check(
    State(state): State<AppState>,
    Who(who): Who,
    sent: Sent<PlanDocument>,
) -> Result<Json<PlanCheck>, ApiError> {
    let plan = taken(sent)?;
    plans::limits(&plan).map_err(refused)?;
    judged(&state, &who, plan).await.map(Json)
}

/// `POST /api/v1/plans/{id}/upload`.
pub(crate) async fn upload(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    InPath(id): InPath<i64>,
    sent: Sent<PlanUploadRequest>,
) -> Result<(StatusCode, Json<Command>), ApiError> {
    let row = find(&state, &who, id, None).await?;
    let PlanUploadRequest { vessel, revision, window } = taken(sent)?;
    may_change(&who, Some(vessel))?;
    if row.revision != revision {
        let text = say("The plan is at revision {now}, not {revision}: look at it again.");
        let text = text.with("now", row.revision).with("revision", revision);
        return Err(ApiError::new(StatusCode::CONFLICT, "newer_revision", text));
    }
    if row.draft {
        return Err(refused(say("The plan is a draft; save it before it goes aboard.")));
    }
    if row.plan.vessel.is_some_and(|meant| meant != vessel) {
        return Err(refused(say("The plan is for another vessel; change that first.")));
    }
    let now = state.shore.clock.utc();
    let specification = slow(move || plans::aboard(&row.plan, now)).await?.map_err(refused)?;
    let by = Issuer { who, from: remote.address.to_string(), window };
    let order = operations::Order::Upload(Box::new(specification));
    Ok((StatusCode::ACCEPTED, Json(state.shore.commands.issue(Address(vessel), &by, order).await?)))
}

/// `GET /api/v1/plans/{id}/export`.
pub(crate) async fn export(
    State(state): State<AppState>,
    Who(who): Who,
    InPath(id): InPath<i64>,
    QueryParams(query): QueryParams<PlanExportQuery>,
) -> Result<Response, ApiError> {
    let row = find(&state, &who, id, None).await?;
    let format = Format::named(&query.format)
        .ok_or_else(|| ApiError::bad_request(say("format: give imc, geojson or gpx")))?;
    let text = plans::write(&row.plan, format).map_err(refused)?;
    let (media, ending) = format.kind();
    let disposition = format!("attachment; filename=\"{}.{ending}\"", extract::file_name(&row.plan.name));
    Ok(([(header::CONTENT_TYPE, media.to_owned()), (header::CONTENT_DISPOSITION, disposition)], text)
        .into_response())
}

/// `POST /api/v1/plans/import`: the body is the file.
pub(crate) async fn import(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    QueryParams(query): QueryParams<PlanImportQuery>,
    body: Result<WholeBody, ApiError>,
) -> Result<Json<ImportedPlan>, ApiError> {
    let file = query.name;
    if !FILE_NAME.contains(&file.chars().count()) || file.chars().any(char::is_control) {
        let (least, most) = FILE_NAME.into_inner();
        return Err(ApiError::bad_request(
            say("name: give the file's name, {least} to {most} letters")
                .with("least", least)
                .with("most", most),
        ));
    }
    let WholeBody(bytes) = body?;
    let told = file.clone();
    let read = slow(move || plans::read(&bytes, &file)).await?;
    let (plan, notes) = read.map_err(|text| {
        refused(say("{file} was not imported: {text}").with("file", told).with_said("text", text))
    })?;
    let stored = keep_new(&state, &who, remote, "plan.import", plan).await?;
    Ok(Json(ImportedPlan { stored, notes: notes.into_iter().map(Into::into).collect() }))
}

async fn keep_new(
    state: &AppState,
    who: &Principal,
    remote: Remote,
    action: &'static str,
    plan: PlanDocument,
) -> Result<StoredPlan, ApiError> {
    may_change(who, plan.vessel)?;
    plans::limits(&plan).map_err(refused)?;
    let subject = plan.name.clone();
    let change = Change { author: who.name.clone(), now: state.shore.clock.utc(), draft: true };
    let create = plans::Create { plan, change };
    let id = state.shore.people.act(who, remote.address.to_string(), action, subject, create).await?;
    stored(state, who, find(state, who, id, None).await?).await
}

/// The name of a plan that the person may see, and whether they may change it.
pub(crate) async fn seen_plan(
    state: &AppState,
    who: &Principal,
    id: i64,
) -> Result<(String, bool), ApiError> {
    let row = find(state, who, id, None).await?;
    let may = may_change(who, row.plan.vessel).is_ok();
    Ok((row.plan.name, may))
}

/// A plan that the person may see.
async fn find(state: &AppState, who: &Principal, id: i64, revision: Option<u32>) -> Result<Row, ApiError> {
    let row = state.shore.people.ask(plans::Load { id, revision }).await?;
    row.filter(|row| !row.deleted && may_see(who, row.plan.vessel)).ok_or_else(no_such)
}

fn may_see(who: &Principal, vessel: Option<u16>) -> bool {
    vessel.map_or_else(|| who.grants.somewhere(), |vessel| who.grants.on(vessel)).is_some()
}

fn may_change(who: &Principal, vessel: Option<u16>) -> Result<(), ApiError> {
    let role = vessel.map_or_else(|| who.grants.somewhere(), |vessel| who.grants.on(vessel));
    if role >= Some(Role::Operator) {
        return Ok(());
    }
    let text = match vessel {
        None => say("{name} may not change this plan: that needs the role operator on at least one vessel."),
        Some(vessel) => {
            say("{name} may not change this plan: that needs the role operator on vessel {vessel}.")
                .with("vessel", vessel)
        }
    };
    Err(ApiError::forbidden(text.with("name", &who.name)))
}

fn no_such() -> ApiError {
    ApiError::not_found(say("There is no such plan, or it was deleted; GET /api/v1/plans lists them."))
}

fn refused(text: impl Into<Said>) -> ApiError {
    ApiError::new(StatusCode::UNPROCESSABLE_ENTITY, "refused", text)
}

fn taken<T>(sent: Sent<T>) -> Result<T, ApiError> {
    sent.map(|InBody(sent)| sent)
}

/// Checking a long plan takes some milliseconds, which must not block other tasks.
async fn slow<R: Send + 'static>(work: impl FnOnce() -> R + Send + 'static) -> Result<R, ApiError> {
    tokio::task::spawn_blocking(work).await.map_err(|error| ApiError::internal(&error))
}

/// Checks a plan, also against the chart. The vessel's position is used only if the user may see the vessel.
async fn judged(state: &AppState, who: &Principal, plan: PlanDocument) -> Result<PlanCheck, ApiError> {
    let seen = plan.vessel.filter(|vessel| who.grants.on(*vessel).is_some());
    let judge = state.shore.grounding.of_drawing(seen.map(Address)).await;
    let now = state.shore.clock.utc();
    slow(move || plans::check_with(&plan, now, |plan| judge.guard(plan))).await
}

async fn stored(state: &AppState, who: &Principal, row: Row) -> Result<StoredPlan, ApiError> {
    let check = judged(state, who, row.plan.clone()).await?;
    Ok(StoredPlan {
        id: row.id,
        revision: row.revision,
        draft: row.draft,
        author: row.author,
        updated_us: row.updated.micros(),
        plan: row.plan,
        check,
    })
}

fn summary(row: Row, now: UtcTime) -> PlanSummary {
    let check = plans::check(&row.plan, now);
    PlanSummary {
        id: row.id,
        name: row.plan.name,
        vessel: row.plan.vessel,
        revision: row.revision,
        draft: row.draft,
        author: row.author,
        updated_us: row.updated.micros(),
        maneuvers: row.plan.maneuvers.len() as u32,
        problems: check.problems.len() as u32,
        digest: check.digest,
        total: check.total,
    }
}
