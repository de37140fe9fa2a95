//! What is kept and where: the disk, archive and history, what may go, backups, other stores, and whether all is well.

use crate::AppState;
use crate::backups::Watched;
use crate::config::Config;
use crate::doctor;
use crate::pages::frame::{Frame, PageError, html};
use crate::pages::rows::{bytes, vessel_name};
use crate::pages::words::{t, word};
use crate::web::ApiError;
use api::Vessel;
use askama::Template;
use axum::extract::{Query, State};
use axum::response::Response;
use serde::Deserialize;
use shore::alarms;
use shore::clock::written;
use shore::identity::Language;
use shore::recorder::RecorderState;
use shore::sinks::SinkState;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use store::{Check, Health, Reader, Retention, Usage};
use units::UtcTime;

/// Things that would go that are listed one by one.
const LISTED: usize = 50;

struct VesselRow {
    name: String,
    address: u16,
    archive: String,
    days: u32,
    arrived: String,
    said: String,
}

struct CheckRow {
    name: &'static str,
    state: &'static str,
    bad: bool,
    found: String,
    remedy: String,
}

struct SinkRow {
    kind: &'static str,
    target: String,
    behind: String,
    kept: u64,
    refused: u64,
    last: String,
    trouble: String,
}

/// What a retention would remove.
#[derive(Default)]
struct Removals {
    history_before: String,
    archive_before: String,
    /// Why it is not reported.
    problem: String,
    /// The command that removes it; empty when nothing was asked.
    command: String,
    listed: Vec<(String, String)>,
    /// How many more there are.
    more: usize,
    sum: String,
}

#[derive(Template)]
#[template(path = "admin_storage.html")]
struct StoragePage {
    frame: Frame,
    now: String,
    folder: String,
    free: String,
    total: String,
    full_percent: u64,
    archive: String,
    history: String,
    charts: String,
    people: String,
    months: Vec<(String, String)>,
    vessels: Vec<VesselRow>,
    problem: String,
    recorded: u64,
    not_recorded: u64,
    waiting: String,
    removals: Removals,
    /// `lutra-server` with the data folder that this server uses.
    program: String,
    sinks: Vec<SinkRow>,
    checks: Vec<CheckRow>,
}

/// Before which days something may go: dates, or empty.
#[derive(Debug, Default, Clone, Deserialize)]
pub(in crate::pages) struct Before {
    #[serde(default)]
    history_before: String,
    #[serde(default)]
    archive_before: String,
}

/// What was looked up on the disk.
struct Looked {
    usage: Usage,
    /// First and last sample of each system (µs).
    samples: BTreeMap<u16, (i64, i64)>,
    room: Option<(u64, u64)>,
    charts: u64,
    people: u64,
    removals: Removals,
    checks: Vec<Check>,
}

/// `GET /admin/storage`.
pub(in crate::pages) async fn page(
    State(state): State<AppState>,
    frame: Frame,
    Query(before): Query<Before>,
) -> Result<Response, PageError> {
    let (config, backup) = (state.config.clone(), state.backup.clone());
    let looked = tokio::task::spawn_blocking(move || look(&config, &backup, before));
    let looked = looked.await.map_err(|error| ApiError::internal(&error))??;
    let known = state.shore.people.vessels();
    let recorder: RecorderState = state.shore.recorder.state().borrow().clone();
    let (free, total) = looked.room.unwrap_or_default();
    let (usage, language) = (&looked.usage, frame.language);
    let page = StoragePage {
        frame,
        now: written(state.shore.clock.utc()),
        folder: state.config.data.display().to_string(),
        free: bytes(free),
        total: bytes(total),
        full_percent: (100 * total.saturating_sub(free)).checked_div(total).unwrap_or_default(),
        archive: bytes(usage.archive_bytes()),
        history: bytes(usage.history_bytes()),
        charts: bytes(looked.charts),
        people: bytes(looked.people),
        months: usage.history.iter().map(|(name, size)| (name.clone(), bytes(*size))).collect(),
        vessels: vessel_rows(language, (usage, &looked.samples), &known, state.shore.router.address()),
        problem: recorder.problem().unwrap_or_default(),
        recorded: recorder.recorded,
        not_recorded: recorder.not_recorded,
        waiting: bytes(state.shore.recorder.waiting_bytes() as u64),
        removals: looked.removals,
        program: program(&state.config.data),
        sinks: state.shore.sinks.iter().map(|sink| sink_row(language, &sink.borrow())).collect(),
        checks: looked.checks.into_iter().map(check_row).collect(),
    };
    Ok(html(&page))
}

fn program(data: &Path) -> String {
    format!("lutra-server --data {}", data.display())
}

fn look(config: &Config, backup: &Watched, before: Before) -> Result<Looked, ApiError> {
    let data = &config.data;
    let systems = Reader::open(data)?.systems()?;
    let samples = systems.into_iter().map(|one| (one.address.0, (one.extent.first_us, one.extent.last_us)));
    let size = |path: &Path| fs::metadata(path).map_or(0, |file| file.len());
    let set = config.chart_set();
    Ok(Looked {
        usage: store::usage(data)?,
        samples: samples.collect(),
        room: alarms::room(data),
        charts: chartdb::files(&set).iter().map(|file| size(file)).sum(),
        people: size(&data.join("app.db")) + size(&data.join("app.db-wal")),
        removals: removals(data, before)?,
        checks: doctor::look(config, false, |config| backup.checks(config)),
    })
}

/// What would go, and by which command.
fn removals(data: &Path, before: Before) -> Result<Removals, ApiError> {
    let Before { history_before, archive_before } = before;
    let read = |text: &str| match text.trim() {
        "" => Ok(None),
        text => text.parse::<UtcTime>().map(Some).map_err(|error| format!("{text}: {error}")),
    };
    let dates = read(&history_before).and_then(|history| Ok((history, read(&archive_before)?)));
    let mut told = Removals { history_before, archive_before, ..Removals::default() };
    let retention = match dates {
        Ok((None, None)) => return Ok(told),
        Ok((history_before, archive_before)) => Retention { history_before, archive_before },
        Err(problem) => return Ok(Removals { problem, ..told }),
    };
    let all = store::plan_retention(data, &retention)?;
    told.command = format!("{} prune", program(data));
    for (flag, text) in [("history", told.history_before.trim()), ("archive", told.archive_before.trim())] {
        if !text.is_empty() {
            told.command = format!("{} --{flag}-before {text}", told.command);
        }
    }
    told.sum = bytes(all.iter().map(|one| one.bytes).sum());
    told.more = all.len().saturating_sub(LISTED);
    let listed = all.into_iter().take(LISTED).map(|one| {
        let path = one.path.strip_prefix(data).unwrap_or(&one.path).display().to_string();
        (path, bytes(one.bytes))
    });
    told.listed = listed.collect();
    Ok(told)
}

fn vessel_rows(
    language: Language,
    (usage, samples): (&Usage, &BTreeMap<u16, (i64, i64)>),
    known: &[Vessel],
    own: imc::Address,
) -> Vec<VesselRow> {
    let between = |first: String, last: String| {
        t(language, "{from} to {to}").with("from", first).with("to", last).to_string()
    };
    let day = |time: UtcTime| written(time)[..10].to_owned();
    let row = |(address, one): (&imc::Address, &store::Archives)| {
        let said = samples.get(&address.0).map(|(first_us, last_us)| {
            let [first, last] = [*first_us, *last_us].map(|us| written(UtcTime::from_micros(us)));
            between(first, last)
        });
        let (first, last) = (day(one.first), day(one.last));
        VesselRow {
            name: if *address == own {
                t(language, "this server").to_string()
            } else {
                vessel_name(address.0, known)
            },
            address: address.0,
            archive: bytes(one.bytes),
            days: one.days,
            arrived: if first == last { first } else { between(first, last) },
            said: said.unwrap_or_else(|| "—".to_owned()),
        }
    };
    usage.archive.iter().map(row).collect()
}

fn sink_row(language: Language, sink: &SinkState) -> SinkRow {
    SinkRow {
        kind: sink.kind,
        target: sink.target.clone(),
        behind: sink.behind_bytes.map_or_else(|| t(language, "not known yet").to_string(), bytes),
        kept: sink.kept,
        refused: sink.refused,
        last: sink.last.map_or_else(|| t(language, "nothing since the start").to_string(), written),
        trouble: sink.trouble.clone().unwrap_or_default(),
    }
}

fn check_row(check: Check) -> CheckRow {
    let Check { name, health, found, remedy } = check;
    let state = match health {
        Health::Good => word("● well"),
        Health::Warning => word("▲ warning"),
        Health::Problem => word("■ needs repair"),
    };
    CheckRow { name, state, bad: health != Health::Good, found, remedy }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::http::testing::an_hour;

    fn ask(data: &Path, history: &str, archive: &str) -> Removals {
        let before = Before { history_before: history.to_owned(), archive_before: archive.to_owned() };
        removals(data, before).unwrap()
    }

    #[test]
    fn what_would_go_is_told_with_the_command_that_does_it() {
        let folder = tempfile::tempdir().unwrap();
        let data = folder.path();
        an_hour(data, UtcTime::from_micros(1_800_000_000_000_000));
        let nothing = ask(data, "", " ");
        assert!(nothing.command.is_empty() && nothing.listed.is_empty());
        let all = ask(data, "2027-02-01", "");
        assert_eq!(all.listed[0].0, "history/2027-01.sqlite");
        assert!(all.command.ends_with(" prune --history-before 2027-02-01"), "{}", all.command);
        assert!(ask(data, "2027-01-31", "").listed.is_empty());
        let wrong = ask(data, "yesterday", "");
        assert!(wrong.problem.starts_with("yesterday: no time in ISO 8601"), "{}", wrong.problem);
        assert!(wrong.command.is_empty());
    }
}
