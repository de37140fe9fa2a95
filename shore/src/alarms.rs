//! Alarms as the API reports them, and the task that derives them.
//!
//! Once a second the task collects inputs that the hub does not have (link clocks, recording state, disk space) and has the
//! hub derive the alarms. Active alarms and the alarm log are written to app.db on every change, so that acknowledgements
//! survive a restart.

mod keep;
mod notes;

pub use notes::Notes;

use crate::Wanted;
use crate::charts::Charts;
use crate::error::{Error, ErrorKind, Result};
use crate::identity::{ASK_PATIENCE, Line, People, Principal};
use crate::links::Links;
use crate::owners::Owners;
use crate::recorder::Recorder;
use crate::router::Router;
use api::{AlarmList, AlarmNote, AlarmShelving, AlarmWord, ChartDifference, Role, Wording, say};
use hub::Fleet;
use imc::Address;
use keep::{PendingNotes, ReadStanding, Standing, keep};
use operations::Operations;
use operations::alarms::{
    Alarm, AlarmId, AlarmRefused, CertificateState, Key, Kind, LinkClock, Note, OtherChart, Priority, Saved,
    ShoreState, Signature, State,
};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::{Notify, watch};
use tokio::time::Interval;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;
use units::{Now, UtcTime};

/// Interval between two evaluations.
const EVERY: Duration = Duration::from_secs(1);
/// How long a response waits until the change is in app.db.
const WRITE_PATIENCE: Duration = Duration::from_secs(2);
/// Disk space and the list of expected vessels are read once every so many evaluations.
const SLOW_EVERY: u32 = 30;

/// Replaces vessel names by those that people assigned; vessels without one keep the name that they announce.
pub fn name(people: &People, alarms: &mut [api::Alarm]) {
    let given = people.vessels();
    for alarm in alarms {
        let given = given.iter().find(|given| Some(given.address) == alarm.vessel);
        if let Some(given) = given {
            alarm.vessel_name = Some(given.name.clone());
        }
    }
}

/// Converts an alarm of the hub; [`name`] sets the vessel's name.
pub fn alarm(fleet: &Fleet, alarm: &Alarm) -> api::Alarm {
    let advice = alarm.key.kind.advice();
    let word = |said: &Signature| AlarmWord { by: said.by.clone(), time_us: said.at.micros() };
    api::Alarm {
        id: alarm.id.0,
        vessel: alarm.key.vessel.map(|vessel| vessel.0),
        vessel_name: alarm.key.vessel.map(|vessel| fleet.title(vessel)),
        kind: alarm.key.kind.name().to_owned(),
        part: alarm.key.part.clone(),
        state: alarm.state.name().to_owned(),
        priority: alarm.priority.name().to_owned(),
        says: alarm.says.clone(),
        text: alarm.text.clone(),
        cause: advice.cause.to_owned(),
        consequence: advice.consequence.to_owned(),
        action: advice.action.to_owned(),
        since_us: alarm.since.micros(),
        over_us: alarm.over.map(UtcTime::micros),
        count: alarm.count,
        acknowledged: alarm.acknowledged.as_ref().map(word),
        escalated: alarm.escalated,
        chatters: alarm.chatters,
        shelved: alarm.shelved.as_ref().map(|shelf| AlarmShelving {
            by: shelf.said.by.clone(),
            time_us: shelf.said.at.micros(),
            until_us: shelf.until.micros(),
            reason: shelf.reason.clone(),
        }),
        collapsed: alarm.collapsed.map(|kind| kind.name().to_owned()),
        sounded: alarm.sounded,
        wants_acknowledgement: alarm.wants_acknowledgement(),
    }
}

/// Converts a change of an alarm for the API.
pub fn note(fleet: &Fleet, note: &Note) -> AlarmNote {
    AlarmNote {
        time_us: note.at.micros(),
        id: note.id.0,
        vessel: note.key.vessel.map(|vessel| vessel.0),
        vessel_name: note.key.vessel.map(|vessel| fleet.title(vessel)),
        kind: note.key.kind.name().to_owned(),
        priority: note.priority.name().to_owned(),
        what: note.what.to_owned(),
        by: note.by.clone(),
        says: note.says.clone(),
        text: note.text.clone(),
    }
}

/// Whether a user may see this alarm: the server's own alarms are visible to all, a vessel's alarms to all who may see it,
/// even while they display another vessel.
pub fn admits(wanted: &Wanted, key: &Key) -> bool {
    key.vessel.is_none_or(|vessel| wanted.grants.on(vessel.0).is_some())
}

/// Alarms that changed after `revision`.
pub(crate) fn changes(operations: &Operations, revision: u64, wanted: &Wanted) -> Vec<api::Alarm> {
    let changed = operations.alarms().changed(revision);
    changed.filter(|one| admits(wanted, &one.key)).map(|one| alarm(operations.fleet(), one)).collect()
}

/// Logs a new alarm: by the vessel's address, as all lines about vessels, and its name.
fn log_alarm(alarm: &api::Alarm) {
    let api::Alarm { vessel_name: name, text, kind, priority, .. } = alarm;
    let vessel = alarm.vessel.map(|vessel| tracing::field::display(Address(vessel)));
    tracing::warn!(vessel, name, kind, priority, "alarm: {text}");
}

/// Parses a stored alarm; `None` where this server does not know its values.
fn saved(alarm: api::Alarm) -> Option<Saved> {
    let said = |by: String, time_us| Signature { by, at: UtcTime::from_micros(time_us) };
    Some(Saved {
        id: AlarmId(alarm.id),
        key: Key { vessel: alarm.vessel.map(Address), kind: Kind::named(&alarm.kind)?, part: alarm.part },
        state: State::named(&alarm.state)?,
        priority: Priority::named(&alarm.priority)?,
        says: alarm.says,
        text: alarm.text,
        since: UtcTime::from_micros(alarm.since_us),
        over: alarm.over_us.map(UtcTime::from_micros),
        count: alarm.count,
        acknowledged: alarm.acknowledged.map(|word| said(word.by, word.time_us)),
        escalated: alarm.escalated,
        shelved: alarm.shelved.map(|shelf| {
            let until = UtcTime::from_micros(shelf.until_us);
            (said(shelf.by, shelf.time_us), until, shelf.reason)
        }),
    })
}

/// The alarm service; cheap to clone.
#[derive(Clone)]
pub struct Alarms {
    router: Router,
    people: People,
    /// Wakes the watch: a user acknowledged or shelved an alarm.
    done: Arc<Notify>,
    /// The last revision of the alarms that is completely in app.db; `None` while no task writes them.
    kept: watch::Sender<Option<u64>>,
    /// State of the server's TLS certificate; `None` without encryption.
    certificate: watch::Sender<Option<CertificateState>>,
}

/// What the watch needs besides the alarms: the sources of inputs that the hub does not have.
pub(crate) struct Watch {
    pub(crate) links: Links,
    pub(crate) charts: Charts,
    pub(crate) recorder: Recorder,
    /// The folder whose disk is checked for free space.
    pub(crate) data: PathBuf,
    pub(crate) owners: Owners,
    pub(crate) tasks: TaskTracker,
    pub(crate) stop: CancellationToken,
}

impl Alarms {
    pub(crate) fn new(router: Router, people: People) -> Self {
        Self {
            router,
            people,
            done: Arc::default(),
            kept: watch::Sender::default(),
            certificate: watch::Sender::default(),
        }
    }

    /// Takes over the state of the certificate from the task that serves it.
    pub fn certificate(&self, state: CertificateState) {
        self.certificate.send_replace(Some(state));
    }

    /// The last reported state of the certificate; `None` without encryption.
    pub fn known_certificate(&self) -> Option<CertificateState> {
        self.certificate.borrow().clone()
    }

    /// Active alarms, the most urgent first, and recent changes, limited to what the user may see.
    ///
    /// # Errors
    /// The server is stopping.
    pub async fn list(&self, wanted: Wanted) -> Result<AlarmList> {
        let ask = move |operations: &mut Operations, _: Now| {
            let (fleet, all) = (operations.fleet(), operations.alarms());
            let mut standing: Vec<_> = all.standing().filter(|one| admits(&wanted, &one.key)).collect();
            standing.sort_by_key(|one| std::cmp::Reverse((one.priority, one.since)));
            let history = all.notes().rev().filter(|one| admits(&wanted, &one.key));
            AlarmList {
                standing: standing.into_iter().map(|one| alarm(fleet, one)).collect(),
                history: history.map(|one| note(fleet, one)).collect(),
            }
        };
        let mut list = self.router.ask(ask).await?;
        name(&self.people, &mut list.standing);
        Ok(list)
    }

    /// Active alarms of all vessels and of the server itself.
    ///
    /// # Errors
    /// The server is stopping.
    pub(crate) async fn standing(&self) -> Result<Vec<api::Alarm>> {
        let ask = |operations: &mut Operations, _: Now| {
            let fleet = operations.fleet();
            operations.alarms().standing().map(|one| alarm(fleet, one)).collect::<Vec<_>>()
        };
        let mut standing = self.router.ask(ask).await?;
        name(&self.people, &mut standing);
        Ok(standing)
    }

    /// The log of alarm changes, the newest first, each with its number.
    ///
    /// # Errors
    /// app.db cannot be read.
    pub async fn past(&self, wanted: Notes) -> Result<Vec<(i64, AlarmNote)>> {
        Ok(self.people.ask(wanted).await?)
    }

    /// Acknowledges an alarm.
    ///
    /// # Errors
    /// There is no such alarm for this person, or they may not.
    pub async fn acknowledge(&self, who: &Principal, from: String, id: u64) -> Result<api::Alarm> {
        let by = who.name.clone();
        let act = move |operations: &mut Operations, now: Now| {
            operations.alarms_mut().acknowledge(now, AlarmId(id), &by)
        };
        self.change(who, from, AlarmId(id), "alarm.acknowledge", act).await
    }

    /// Shelves an alarm for some time.
    ///
    /// # Errors
    /// As [`Alarms::acknowledge`]; too long, or without a reason.
    pub async fn shelve(
        &self,
        who: &Principal,
        from: String,
        id: u64,
        span: Duration,
        reason: String,
    ) -> Result<api::Alarm> {
        let by = who.name.clone();
        let act = move |operations: &mut Operations, now: Now| {
            operations.alarms_mut().shelve(now, AlarmId(id), &by, span, &reason)
        };
        self.change(who, from, AlarmId(id), "alarm.shelve", act).await
    }

    /// Changes an alarm on behalf of a user, who must be operator of its vessel, or of any vessel where the alarm is the
    /// server's own.
    async fn change(
        &self,
        who: &Principal,
        from: String,
        id: AlarmId,
        action: &'static str,
        act: impl FnOnce(&mut Operations, Now) -> std::result::Result<(), AlarmRefused> + Send + 'static,
    ) -> Result<api::Alarm> {
        let find = move |operations: &mut Operations, _: Now| {
            operations.alarms().get(id).map(|one| alarm(operations.fleet(), one))
        };
        let known = self.router.ask(find).await?;
        let seen = |vessel: Option<u16>| vessel.is_none_or(|vessel| who.grants.on(vessel).is_some());
        let gone = || Error::new(ErrorKind::NotFound, say("There is no such alarm any more."));
        let known = known.filter(|known| seen(known.vessel)).ok_or_else(gone)?;
        let role = known.vessel.map_or_else(|| who.grants.somewhere(), |vessel| who.grants.on(vessel));
        if role < Some(Role::Operator) {
            return Err(Error::new(ErrorKind::Forbidden, not_operator(who, known.vessel)));
        }
        let place = known.vessel.map_or("server".to_owned(), |vessel| Address(vessel).to_string());
        let subject = format!("{place} {} {}: {}", known.kind, known.part, known.text);
        let done = move |operations: &mut Operations, now: Now| {
            act(operations, now)?;
            let known = operations.alarms().get(id).map(|one| alarm(operations.fleet(), one));
            let known = known.ok_or(AlarmRefused::Gone)?;
            Ok((operations.alarms().revision(), known))
        };
        let mut outcome = self.router.ask(done).await?;
        if let Ok((_, known)) = &mut outcome {
            name(&self.people, std::slice::from_mut(known));
        }
        let result = outcome.as_ref().err().map_or_else(|| "done".to_owned(), ToString::to_string);
        let line = Line { actor: who.actor(), address: from, action, subject, outcome: result };
        let recorded = async {
            if let Err(error) = self.people.record(vec![line], ASK_PATIENCE).await {
                tracing::error!(%error, action, "is not in the audit log");
            }
        };
        let written = async {
            if let Ok((revision, _)) = &outcome {
                self.written(*revision).await;
            }
        };
        tokio::join!(recorded, written);
        outcome.map(|(_, known)| known).map_err(|why: AlarmRefused| Error::refused(why.said()))
    }

    /// Waits until everything up to a revision is in app.db, so that a client that gets the response finds the change in
    /// the history too, even after a crash of the server. The wait is limited: an acknowledgement is valid even if it
    /// cannot be stored, so that a disk fault does not keep an alarm sounding.
    async fn written(&self, revision: u64) {
        self.done.notify_one();
        let mut kept = self.kept.subscribe();
        let written = kept.wait_for(|kept| kept.is_none_or(|kept| kept >= revision));
        if tokio::time::timeout(WRITE_PATIENCE, written).await.is_err() {
            tracing::warn!(
                "what somebody did to an alarm could not be saved within 2 s; it counts, but a restart could forget it: is the disk slow or full?"
            );
        }
    }

    /// Restores the alarms that were active when the server ended.
    ///
    /// # Errors
    /// app.db cannot be read, or the server is stopping.
    pub async fn restore(&self) -> Result<()> {
        let stood = self.people.ask(ReadStanding).await?;
        // A caution needs no acknowledgement: if its condition still holds, it is raised again.
        let kept = stood.into_iter().filter(|one| one.priority != "caution" || one.shelved.is_some());
        let saved: Vec<Saved> = kept.filter_map(saved).collect();
        let restore = move |operations: &mut Operations, now| {
            for one in saved {
                operations.alarms_mut().restore(now, one);
            }
        };
        Ok(self.router.ask(restore).await?)
    }

    /// Evaluates alarms until the server ends.
    pub(crate) async fn watch(self, watch: Watch) {
        if let Err(error) = self.restore().await {
            tracing::error!(%error, "what stood as alarm before the start is forgotten");
        }
        let mut every = tokio::time::interval(EVERY);
        every.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        let (told, standing) = watch::channel(Standing::default());
        let happened = PendingNotes::default();
        let keep =
            keep(self.people.clone(), standing, happened.clone(), self.kept.clone(), watch.stop.clone());
        watch.tasks.spawn(watch.owners.watch("the list of alarms", keep));
        let (mut disk, mut expected, mut looks, mut kept, mut logged) = (None, Vec::new(), 0_u32, 0, 0);
        measure(&[]);
        while let Some(due) = watch.stop.run_until_cancelled(self.next_look(&mut every)).await {
            if due && looks.is_multiple_of(SLOW_EVERY) {
                expected = self.people.linked().into_iter().map(Address).collect();
                self.believe(&watch.links, &expected).await;
                let folder = watch.data.clone();
                disk = tokio::task::spawn_blocking(move || room(&folder)).await.ok().flatten();
                measure_disk(disk);
            }
            looks = looks.wrapping_add(u32::from(due));
            let certificate = self.certificate.borrow().clone();
            let state = ShoreState { certificate, ..watch.shore_state(disk, expected.clone()) };
            let looked = self.look(state, kept).await;
            let Ok((revision, changed)) = looked else { return };
            if let Some((mut standing, notes)) = changed {
                happened.add(notes);
                name(&self.people, &mut standing);
                measure(&standing);
                standing.iter().filter(|alarm| alarm.id > logged).for_each(log_alarm);
                logged = standing.iter().map(|alarm| alarm.id).max().unwrap_or_default().max(logged);
                kept = revision;
                told.send_replace(Standing { revision, alarms: standing });
            }
        }
    }

    /// Waits for the next evaluation: true if the interval has passed, false if a user changed an alarm.
    async fn next_look(&self, every: &mut Interval) -> bool {
        tokio::select! {
            _ = every.tick() => true,
            () = self.done.notified() => false,
        }
    }

    /// Has the hub derive the alarms. Returns their revision and, if it is not `kept`, the active alarms and the changes
    /// since.
    async fn look(
        &self,
        shore: ShoreState,
        kept: u64,
    ) -> std::result::Result<(u64, Option<(Vec<api::Alarm>, Vec<AlarmNote>)>), crate::router::Stopped> {
        let look = move |operations: &mut Operations, now| {
            operations.watch(now, &shore);
            let revision = operations.alarms().revision();
            let changed = (revision != kept).then(|| {
                let all = operations.alarms();
                let standing = all.standing().map(|one| alarm(operations.fleet(), one)).collect();
                (
                    standing,
                    all.notes()
                        .filter(|one| one.revision > kept)
                        .map(|one| note(operations.fleet(), one))
                        .collect(),
                )
            });
            (revision, changed)
        };
        self.router.ask(look).await
    }

    /// Tells the hub which vessels have a link, including those whose link is open but not yet recorded in app.db.
    async fn believe(&self, links: &Links, expected: &[Address]) {
        let up = links.status().into_iter().filter(|(_, status)| status.up).map(|(vessel, _)| vessel);
        let linked: BTreeSet<Address> = expected.iter().copied().chain(up).collect();
        self.router.ask(move |operations, _| operations.hub_mut().set_linked(linked)).await.ok();
    }
}

impl Watch {
    /// State of the server itself, as input of the alarms.
    fn shore_state(&self, disk: Option<(u64, u64)>, expected: Vec<Address>) -> ShoreState {
        let status = self.links.status();
        let clocks = status.iter().filter_map(|(vessel, status)| {
            let clocks = status.clocks.filter(|_| status.up)?;
            let ahead_s = clocks.utc_ahead_us as f64 / 1e6;
            Some(LinkClock { vessel: *vessel, ahead_s, uncertainty_s: clocks.uncertainty_us as f64 / 1e6 })
        });
        let charts = status.iter().filter(|(_, status)| status.up).filter_map(|(vessel, _)| {
            let chart = self.links.chart(*vessel);
            let held = chart.digest.is_some();
            let difference = chart.difference.filter(|difference| match difference {
                ChartDifference::Declined => false,
                ChartDifference::NoneAshore => held,
                _ => true,
            })?;
            Some(OtherChart { vessel: *vessel, held, difference })
        });
        let recorder = self.recorder.state();
        let recorder = recorder.borrow();
        ShoreState {
            clocks: clocks.collect(),
            expected,
            charts: charts.collect(),
            // The hub knows them itself.
            contradictions: Vec::new(),
            recording: recorder.trouble.as_ref().map(|trouble| trouble.text.clone()),
            history: recorder.history_behind.clone(),
            disk,
            // Set by the task that serves the certificate.
            certificate: None,
            no_go: self.charts.not_closed(),
        }
    }
}

/// Publishes the number of active alarms by priority.
fn measure(standing: &[api::Alarm]) {
    for priority in Priority::ALL.map(Priority::name) {
        let count = standing.iter().filter(|alarm| alarm.priority == priority).count();
        metrics::gauge!("lutra_alarms", "priority" => priority).set(count as f64);
    }
}

fn measure_disk(room: Option<(u64, u64)>) {
    let Some((free, all)) = room else { return };
    metrics::gauge!("lutra_disk_free_bytes").set(free as f64);
    metrics::gauge!("lutra_disk_bytes").set(all as f64);
}

/// Free and total bytes of the disk that holds a folder.
pub fn room(folder: &Path) -> Option<(u64, u64)> {
    let disk = rustix::fs::statvfs(folder).ok()?;
    Some((disk.f_bavail.saturating_mul(disk.f_frsize), disk.f_blocks.saturating_mul(disk.f_frsize)))
}

/// Who may not acknowledge or shelve an alarm of a vessel, or of the server.
fn not_operator(who: &Principal, vessel: Option<u16>) -> Wording {
    let text = match vessel {
        None => {
            say("{name} may not do this: that needs the role operator on at least one vessel. Ask an admin.")
        }
        Some(vessel) => {
            say("{name} may not do this: that needs the role operator on vessel {vessel}. Ask an admin.")
                .with("vessel", vessel)
        }
    };
    text.with("name", &who.name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identity::Request;
    use keep::WriteStanding;
    use units::MonoTime;

    #[tokio::test]
    async fn what_somebody_acknowledged_is_so_after_a_restart() {
        let now = Now { mono: MonoTime::from_micros(1), utc: UtcTime::from_micros(1_790_000_000_000_000) };
        let mut alarms = operations::alarms::Alarms::default();
        let full = ShoreState { recording: Some("the disk is full".to_owned()), ..ShoreState::default() };
        alarms.watch(now, &Fleet::default(), &full);
        let id = alarms.standing().next().unwrap().id;
        alarms.acknowledge(now, id, "nils").unwrap();
        alarms.shelve(now, id, "nils", Duration::from_mins(5), "a disk comes").unwrap();
        let fleet = Fleet::default();
        let before: Vec<api::Alarm> = alarms.standing().map(|one| alarm(&fleet, one)).collect();
        let mut db = crate::identity::migrated().await;
        for _ in 0..2 {
            WriteStanding(before.clone()).run(&mut db).await.unwrap();
        }
        let mut after = operations::alarms::Alarms::default();
        for one in ReadStanding.run(&mut db).await.unwrap().into_iter().filter_map(saved) {
            after.restore(now, one);
        }
        let after: Vec<api::Alarm> = after.standing().map(|one| alarm(&fleet, one)).collect();
        let silent = |mut alarm: api::Alarm| {
            alarm.sounded = 0;
            alarm
        };
        assert_eq!(
            after.into_iter().map(silent).collect::<Vec<_>>(),
            before.into_iter().map(silent).collect::<Vec<_>>()
        );
    }
}
