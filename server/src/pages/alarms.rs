//! What happened to alarms: a table with a filter, made without scripts.

use super::frame::{Frame, PageError, html};
use super::names_for;
use super::rows::{self, at, picked_us};
use super::words::{self, word};
use crate::AppState;
use crate::http::alarms::{PRIORITIES, seen};
use crate::web::Who;
use askama::Template;
use axum::extract::{Query, State};
use axum::response::Response;
use imc::Address;
use serde::Deserialize;
use shore::alarms::Notes;
use std::collections::BTreeMap;

/// Changes on a page.
const PAGE: u32 = 100;

#[derive(Template)]
#[template(path = "alarms.html")]
struct AlarmsPage {
    frame: Frame,
    vessels: BTreeMap<u16, String>,
    priorities: [&'static str; 4],
    filter: Filter,
    /// What is wrong with `from` and `to`; empty for nothing.
    wrong: Wrong,
    rows: Vec<Row>,
    /// Where older ones are; empty for nowhere.
    older: String,
}

/// What is asked for, as the form has it.
#[derive(Debug, Clone, Default, Deserialize)]
pub(super) struct Filter {
    #[serde(default)]
    vessel: String,
    #[serde(default)]
    priority: String,
    #[serde(default)]
    from: String,
    #[serde(default)]
    to: String,
    before: Option<i64>,
}

#[derive(Default)]
struct Wrong {
    from: String,
    to: String,
}

struct Row {
    time: String,
    vessel: String,
    priority: String,
    what: String,
    text: String,
    by: String,
}

/// What happened to an alarm, in words: `returned` would read as if the alarm came back, while its condition has ended.
fn happened(what: String) -> String {
    match what.as_str() {
        "again" => word("raised again").to_owned(),
        "returned" => word("condition ended").to_owned(),
        "off the shelf" => word("unshelved").to_owned(),
        _ => what,
    }
}

/// `GET /alarms`.
pub(super) async fn page(
    State(state): State<AppState>,
    Who(who): Who,
    frame: Frame,
    Query(filter): Query<Filter>,
) -> Result<Response, PageError> {
    let vessels = names_for(&state, &who);
    let (from_us, to_us) = (picked_us(&filter.from), picked_us(&filter.to));
    let no_time = |time: &Result<_, ()>| {
        let wrong =
            time.is_err().then(|| frame.t("Not a valid time. Write it like 2026-06-01 12:00, in UTC."));
        wrong.map(|text| text.to_string()).unwrap_or_default()
    };
    let wrong = Wrong { from: no_time(&from_us), to: no_time(&to_us) };
    let priority = Some(filter.priority.clone()).filter(|one| PRIORITIES.contains(&&**one));
    let wanted = Notes {
        vessels: seen(&who),
        vessel: filter.vessel.parse().ok(),
        priority,
        from_us: from_us.unwrap_or_default(),
        to_us: to_us.unwrap_or_default(),
        before: filter.before,
        count: PAGE,
    };
    let found = state.shore.alarms.past(wanted).await?;
    let older = match found.last() {
        Some((last, _)) if found.len() == PAGE as usize => {
            let Filter { vessel, priority, from, to, .. } = &filter;
            let kept = [("vessel", &**vessel), ("priority", priority), ("from", from), ("to", to)];
            rows::older("/alarms", &kept, *last)
        }
        _ => String::new(),
    };
    let called = |vessel: Option<u16>, then: Option<String>| match vessel {
        None => frame.t("Server").to_string(),
        Some(vessel) => vessels.get(&vessel).cloned().or(then).unwrap_or_else(|| Address(vessel).to_string()),
    };
    let row = |(_, note): (i64, api::AlarmNote)| Row {
        time: at(note.time_us),
        vessel: called(note.vessel, note.vessel_name),
        priority: note.priority,
        what: happened(note.what),
        text: words::alarm(frame.language, &note.says, &note.text),
        by: note.by,
    };
    let rows = found.into_iter().map(row).collect();
    Ok(html(&AlarmsPage { frame, vessels, priorities: PRIORITIES, filter, wrong, rows, older }))
}
