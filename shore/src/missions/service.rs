//! Recorded missions, with their access rules.
//!
//! A user who may see one of its vessels sees a mission, with those vessels only. Operators of all its vessels write and
//! change it.

use super::rows::{Change, Create, List, One, Row, Withdraw};
use super::summary;
use crate::clock::Clock;
use crate::error::{Error, ErrorKind, Result};
use crate::history::History;
use crate::identity::{People, Principal};
use crate::logbook::{Logbook, NEWER, TIMES_US, check_text, may_write, not_a_time};
use crate::once::{Key, Made, Once};
use api::{
    LogWord, Mission, MissionChange, MissionQuery, MissionRequest, MissionSummary, MissionVessel, Role, say,
};
use std::sync::Arc;
use store::TimeRange;
use tokio::sync::Semaphore;

/// Vessels of a mission.
const VESSELS: std::ops::RangeInclusive<usize> = 1..=32;
/// The longest mission (µs): a year and a day.
const LONGEST_US: i64 = 366 * 86_400 * 1_000_000;
/// Summaries that are made at once: each reads through the whole mission.
const AT_ONCE: usize = 2;

/// The missions; cheap to clone.
#[derive(Clone)]
pub struct Missions {
    people: People,
    clock: Clock,
    history: History,
    summing: Arc<Semaphore>,
}

impl Missions {
    pub(crate) fn new(people: People, clock: Clock, history: History) -> Self {
        Self { people, clock, history, summing: Arc::new(Semaphore::new(AT_ONCE)) }
    }

    /// A page of missions, the latest begin first.
    ///
    /// # Errors
    /// `before` is not a valid `next`, or app.db cannot be read.
    pub async fn page(
        &self,
        who: &Principal,
        withdrawn: bool,
        before: Option<&str>,
        count: u32,
    ) -> Result<api::Missions> {
        let before = before.map(Logbook::cursor).transpose()?;
        let all = who.grants.everywhere().is_some();
        let seen = (!all).then(|| who.grants.vessels_with(Role::Viewer).collect());
        let rows = self.people.ask(List { seen, withdrawn, before, count }).await?;
        let last = rows.last().filter(|_| rows.len() == count as usize);
        let next = last.map(|row| format!("{}.{}", row.mission.from_us, row.id));
        Ok(api::Missions { missions: rows.into_iter().map(|row| told(who, row)).collect(), next })
    }

    /// One mission.
    ///
    /// # Errors
    /// There is no such mission for this person.
    pub async fn one(&self, who: &Principal, id: i64) -> Result<Mission> {
        Ok(told(who, self.find(who, id).await?))
    }

    /// Stores a mission. If a person repeats a request with the same key, the first mission is the answer.
    ///
    /// # Errors
    /// The person may not, or the named field is not valid.
    pub async fn create(
        &self,
        who: &Principal,
        from: String,
        ask: MissionRequest,
        MissionQuery { key }: MissionQuery,
    ) -> Result<Mission> {
        let key = Key::new(Made::Mission, who.person, key)?;
        if let Some(key) = &key
            && let Some(first) = self.people.ask(key.clone()).await?
        {
            return self.one(who, first).await;
        }
        let mission = checked(ask)?;
        may_all(who, &mission.vessels)?;
        let subject = mission.name.clone();
        let make = Create { mission, by: who.name.clone(), now: self.clock.utc() };
        let create = Once { key, make };
        let id = self.people.act(who, from, "mission.create", subject, create).await?;
        self.one(who, id).await
    }

    /// Changes a mission; its earlier state is kept.
    ///
    /// # Errors
    /// The person may not, it was changed meanwhile, or the named field is not valid.
    pub async fn change(
        &self,
        who: &Principal,
        from: String,
        id: i64,
        change: MissionChange,
    ) -> Result<Mission> {
        let row = self.changeable(who, id).await?;
        if row.revision != change.revision {
            return Err(Error::new(ErrorKind::Newer, NEWER));
        }
        let mission = checked(change.mission)?;
        may_all(who, &mission.vessels)?;
        let subject = format!("{} (mission {id})", mission.name);
        let (by, now) = (who.name.clone(), self.clock.utc());
        let change = Change { id, revision: row.revision, mission, by, now };
        self.people.act(who, from, "mission.change", subject, change).await?;
        self.one(who, id).await
    }

    /// Marks a mission as withdrawn.
    ///
    /// # Errors
    /// The person may not, or it was changed meanwhile.
    pub async fn withdraw(&self, who: &Principal, from: String, id: i64) -> Result<Mission> {
        let row = self.changeable(who, id).await?;
        let subject = format!("{} (mission {id})", row.mission.name);
        let withdraw = Withdraw { id, revision: row.revision, by: who.name.clone(), now: self.clock.utc() };
        self.people.act(who, from, "mission.withdraw", subject, withdraw).await?;
        self.one(who, id).await
    }

    /// The summary of a mission from the history; until now if it has not ended.
    ///
    /// # Errors
    /// There is no such mission for this person, or the history cannot be read.
    pub async fn summary(&self, who: &Principal, id: i64) -> Result<MissionSummary> {
        let MissionRequest { vessels, from_us, to_us, .. } = self.one(who, id).await?.mission;
        let to_us = to_us.unwrap_or_else(|| self.clock.utc().micros().max(from_us));
        let _place = self.summing.acquire().await.map_err(|_| crate::router::Stopped)?;
        let range = TimeRange { from_us, to_us };
        let sum = move |reader: &mut store::Reader| -> store::Result<Vec<MissionVessel>> {
            vessels.into_iter().map(|vessel| summary::of_vessel(reader, vessel, range)).collect()
        };
        let mut vessels = self.history.ask(sum).await?;
        let named = self.people.vessels();
        for one in &mut vessels {
            let name = named.iter().find(|named| named.address == one.vessel);
            one.vessel_name = name.map(|named| named.name.clone());
        }
        Ok(MissionSummary { to_us, vessels })
    }

    /// A mission that the person may see.
    async fn find(&self, who: &Principal, id: i64) -> Result<Row> {
        let row = self.people.ask(One(id)).await?;
        let seen = |row: &Row| row.mission.vessels.iter().any(|vessel| who.grants.on(*vessel).is_some());
        let none = || {
            Error::new(ErrorKind::NotFound, say("There is no such mission; GET /api/v1/missions lists them."))
        };
        row.filter(seen).ok_or_else(none)
    }

    /// A mission that the person may change, and that is not withdrawn.
    async fn changeable(&self, who: &Principal, id: i64) -> Result<Row> {
        let row = self.find(who, id).await?;
        may_all(who, &row.mission.vessels)?;
        if let Some(by) = &row.withdrawn.0 {
            return Err(Error::refused(
                say("This mission was withdrawn by {by}: make a new one.").with("by", by),
            ));
        }
        Ok(row)
    }
}

/// Checks that a user may write about all these vessels.
fn may_all(who: &Principal, vessels: &[u16]) -> Result<()> {
    vessels.iter().try_for_each(|vessel| may_write(who, Some(*vessel)))
}

/// A mission as this person gets it.
fn told(who: &Principal, row: Row) -> Mission {
    let may_change = row.withdrawn.1.is_none() && may_all(who, &row.mission.vessels).is_ok();
    let word = |(by, at): (Option<String>, Option<i64>)| Some(LogWord { by: by?, time_us: at? });
    let mut mission = row.mission;
    mission.vessels.retain(|vessel| who.grants.on(*vessel).is_some());
    Mission {
        id: row.id,
        revision: row.revision,
        mission,
        written: LogWord { by: row.by, time_us: row.written_us },
        changed: word(row.changed),
        withdrawn: word(row.withdrawn),
        may_change,
    }
}

/// Validates a mission.
fn checked(ask: MissionRequest) -> Result<MissionRequest> {
    let MissionRequest { name, people, purpose, notes, mut vessels, from_us, to_us } = ask;
    let name = check_text("name", &name, 1..=120)?;
    if name.contains(['\n', '\t']) {
        return Err(malformed(say("name: has several lines: write one")));
    }
    let people = check_text("people", &people, 0..=500)?;
    let purpose = check_text("purpose", &purpose, 0..=2_000)?;
    let notes = check_text("notes", &notes, 0..=4_000)?;
    vessels.sort_unstable();
    vessels.dedup();
    if !VESSELS.contains(&vessels.len()) {
        return Err(malformed(say("vessels: choose 1 to {most} vessels").with("most", VESSELS.end())));
    }
    for (field, time_us) in [("from_us", Some(from_us)), ("to_us", to_us)] {
        if let Some(time_us) = time_us.filter(|time_us| !TIMES_US.contains(time_us)) {
            return Err(malformed(not_a_time(field, time_us)));
        }
    }
    if to_us.is_some_and(|to_us| to_us <= from_us) {
        return Err(malformed(say("to_us: the end is not after the beginning")));
    }
    if to_us.is_some_and(|to_us| to_us - from_us > LONGEST_US) {
        return Err(malformed(say("to_us: a mission has a year at most: make several")));
    }
    Ok(MissionRequest { name, people, purpose, notes, vessels, from_us, to_us })
}

fn malformed(text: impl Into<api::Said>) -> Error {
    Error::new(ErrorKind::Malformed, text)
}
