//! The present troubles, derived from the fleet's live state.
//!
//! The age of a reading counts to the moment when its vessel was last heard: what stops with the link is the link's
//! silence and nothing else. A silent vessel has no other alarm.

use super::part::{PartKind, SentKinds, charge_rank};
use super::{Key, Kind, Priority, Trouble, shorten};
use api::{AlarmSaying, ChartDifference};
use hub::{Contradiction, Fleet, Liveness, Series, SeriesKey, System, Transport};
use imc::messages::{
    Abort, EntityState, EntityStateState, EstimatedState, FuelLevel, LogBookEntry, LogBookEntryType, Payload,
    SystemType, TBRSensor, Teleoperation, VehicleState, VehicleStateOpMode,
};
use imc::{Address, PacketView};
use std::collections::{BTreeMap, BTreeSet};
use std::slice::from_ref;
use std::time::Duration;
use units::{MonoTime, Now, UtcTime};

/// Charge below which an operator is warned and alarmed (%), as the vessels' own monitor has it by default.
const BATTERY_WARNING: f32 = 30.0;
const BATTERY_ALARM: f32 = 20.0;
/// So much more is needed before the charge counts as better (%).
const BATTERY_HYSTERESIS: f32 = 2.0;
/// Older positions do not count.
const POSITION_OLD: Duration = Duration::from_secs(10);
/// A hydrophone is silent after three of its periods, but not before this.
const HYDROPHONE_SILENT: Duration = Duration::from_mins(2);
/// Clocks may differ by this (s).
const CLOCK_OFFSET_S: f64 = 0.1;
/// Part of that below which they agree again.
const CLOCK_HYSTERESIS: f64 = 0.8;
/// An error in a log book is an alarm for so long.
const LOG_BOOK_LASTS: Duration = Duration::from_mins(1);
/// An entry of the log book about an abort raises no alarm this soon after the order.
const ABORT_TOLD: Duration = Duration::from_secs(10);
/// Errors of log books that are kept; the oldest goes first.
const LOG_BOOK_KEPT: usize = 1_000;
/// Motors that are reported one by one.
const MOTORS_TOLD: usize = 8;
/// Free space of the server's disk below which an alarm is raised (bytes, and part of the whole).
const DISK_CAUTION: (u64, f64) = (10 << 30, 0.05);
const DISK_WARNING: u64 = 1 << 30;
/// So long before a certificate's end an alarm comes, as a caution and as a warning (µs).
const CERTIFICATE_CAUTION_US: i64 = 30 * DAY_US;
const CERTIFICATE_WARNING_US: i64 = 7 * DAY_US;
const DAY_US: i64 = 86_400_000_000;
/// The part of a certificate's alarm that is about files which cannot be used.
const NEW_FILES: &str = "new files";

/// The clock of a vessel, as its link measures it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkClock {
    /// The vessel.
    pub vessel: Address,
    /// The vessel's clock minus the shore's (s).
    pub ahead_s: f64,
    /// By how much that may be wrong (s).
    pub uncertainty_s: f64,
}

/// A vessel that holds another sea chart than the shore.
#[derive(Debug, Clone, PartialEq)]
pub struct OtherChart {
    /// The vessel.
    pub vessel: Address,
    /// Whether it has any.
    pub held: bool,
    /// How they differ.
    pub difference: ChartDifference,
}

impl OtherChart {
    fn says(&self) -> AlarmSaying {
        let difference = match &self.difference {
            ChartDifference::Waiting { why } => ChartDifference::Waiting { why: bounded(why) },
            ChartDifference::Failed { why } => ChartDifference::Failed { why: bounded(why) },
            other => other.clone(),
        };
        AlarmSaying::Chart { held: self.held, difference }
    }
}

/// How the certificate is with which the server encrypts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CertificateState {
    /// Its file.
    pub file: String,
    /// When it ends.
    pub until: UtcTime,
    /// Why what lies in its place meanwhile is not used: file, reason and remedy.
    pub refused: Option<String>,
}

/// The server's state.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ShoreState {
    /// The clocks of vessels whose link is up.
    pub clocks: Vec<LinkClock>,
    /// Vessels that are expected to come in by their link.
    pub expected: Vec<Address>,
    /// Vessels with a link that is up that hold another sea chart than the shore.
    pub charts: Vec<OtherChart>,
    /// Who else sends with the address of vessels that have a link.
    pub contradictions: Vec<Contradiction>,
    /// Why nothing is recorded.
    pub recording: Option<String>,
    /// Why the history lags behind.
    pub history: Option<String>,
    /// Free and all bytes of the disk on which is recorded; `None` while unknown.
    pub disk: Option<(u64, u64)>,
    /// The certificate; `None` for a server that does not encrypt.
    pub certificate: Option<CertificateState>,
    /// Why the sea chart does not hold the no-go areas that people closed.
    pub no_go: Option<String>,
}

/// The result of an observation.
#[derive(Debug, Default)]
pub(super) struct Observed {
    pub(super) troubles: Vec<Trouble>,
    heard: BTreeSet<Address>,
    silent: BTreeSet<Address>,
}

impl Observed {
    /// Whether it cannot be determined at present if this holds.
    pub(super) fn unknown(&self, key: &Key) -> bool {
        key.vessel.is_some_and(|vessel| match key.kind {
            // Whether anything came since the start, and whether another peer sends in its name, is always known.
            Kind::NeverHeard | Kind::OtherSource => false,
            Kind::NotHeard => !self.heard.contains(&vessel) && !self.silent.contains(&vessel),
            _ => !self.heard.contains(&vessel),
        })
    }
}

/// The state kept between two observations.
#[derive(Debug, Default)]
pub(super) struct Observer {
    /// Events up to here were read.
    events: u64,
    /// When each vessel was last ordered to abort.
    aborts: BTreeMap<Address, MonoTime>,
    /// Errors in log books, by vessel and part.
    entries: BTreeMap<(Address, String), (MonoTime, Priority, AlarmSaying)>,
    /// Values that were beyond their threshold at the last observation.
    beyond: BTreeMap<(Address, Kind), Priority>,
    /// Labels of the parts that need a position, of the vessels that are heard.
    of_position: BTreeMap<Address, BTreeSet<String>>,
    /// When it was looked first.
    began: Option<UtcTime>,
}

impl Observer {
    /// Whether this follows from a lost position. Of a vessel that was not heard since the start only labels are known.
    pub(super) fn is_of_position(&self, key: &Key) -> bool {
        let labels = key.vessel.and_then(|vessel| self.of_position.get(&vessel));
        let called_so = || PartKind::of_label(&key.part).is_some_and(PartKind::needs_position);
        key.kind == Kind::Part && (labels.is_some_and(|labels| labels.contains(&key.part)) || called_so())
    }

    pub(super) fn observe(&mut self, now: Now, fleet: &Fleet, shore: &ShoreState) -> Observed {
        let mut seen = Observed::default();
        self.read_log_books(now, fleet);
        for system in fleet.systems().filter(|system| is_vessel(system)) {
            if system.liveness(now.mono) == Liveness::Lost {
                seen.silent.insert(system.address());
                seen.troubles.push(not_heard(system));
            } else {
                seen.heard.insert(system.address());
                let of_vessel = self.of_vessel(now, system, shore);
                seen.troubles.extend(of_vessel);
            }
        }
        self.beyond.retain(|(vessel, _), _| fleet.system(*vessel).is_some());
        self.of_position.retain(|vessel, _| fleet.system(*vessel).is_some());
        let began = *self.began.get_or_insert(now.utc);
        let never = shore.expected.iter().filter(|vessel| !came_in(fleet, **vessel));
        seen.troubles.extend(never.map(|vessel| never_heard(*vessel, began)));
        seen.troubles.extend(shore.contradictions.iter().map(other_source));
        seen.troubles.extend(of_server(shore));
        seen.troubles.extend(shore.certificate.iter().flat_map(|one| of_certificate(now.utc, one)));
        seen
    }

    fn of_vessel(&mut self, now: Now, system: &System, shore: &ShoreState) -> Vec<Trouble> {
        let vessel = system.address();
        let mut parts = Parts::default();
        let (sent, mut of_position) = (SentKinds::of(system), BTreeSet::new());
        for (entity, label, state) in states(now, system) {
            let kind = sent.kind(entity, &label);
            parts.take(kind, &label, &state);
            if kind.is_some_and(PartKind::needs_position) {
                of_position.insert(label);
            }
        }
        self.of_position.insert(vessel, of_position);
        if let Some(old) = old_position(now, system) {
            parts.position = Some(old);
        }
        let mut all = parts.troubles(vessel, Work::of(system));
        all.extend(self.battery(system, parts.battery));
        all.extend(self.clock(vessel, parts.clock, shore));
        if let Some(says) = parts.hydrophone.or_else(|| silent_hydrophone(now, system)) {
            all.push(trouble(vessel, Kind::Hydrophone, "", Priority::Warning, vec![says]));
        }
        if Work::of(system) != Work::Rest {
            let other = shore.charts.iter().find(|chart| chart.vessel == vessel);
            all.extend(
                other.map(|chart| trouble(vessel, Kind::Chart, "", Priority::Caution, vec![chart.says()])),
            );
        }
        // A fault that a part reports itself needs no log book.
        for part in parts.bad {
            self.entries.remove(&(vessel, part));
        }
        let written = self.entries.iter().filter(|((of, _), _)| *of == vessel);
        all.extend(written.map(|((_, part), (_, priority, says))| {
            trouble(vessel, Kind::LogBook, part, *priority, vec![says.clone()])
        }));
        all
    }

    fn read_log_books(&mut self, now: Now, fleet: &Fleet) {
        self.aborts.retain(|_, at| now.mono.since(*at) < ABORT_TOLD);
        let wanted = |_, key: SeriesKey| matches!(key.id, LogBookEntry::ID | Abort::ID);
        let changes = fleet.changes(self.events, usize::MAX, wanted);
        self.events = changes.revision;
        for event in &changes.events {
            let Ok(view) = PacketView::unchecked(&event.packet) else { continue };
            if view.id() == Abort::ID && fleet.system(view.dst()).is_some() {
                self.aborts.insert(view.dst(), now.mono);
            }
            let Ok(Some(entry)) = imc::decode::<LogBookEntry>(&view) else { continue };
            let priority = match entry.r#type {
                LogBookEntryType::Critical => Priority::Warning,
                LogBookEntryType::Error => Priority::Caution,
                _ => continue,
            };
            let words = entry.text.to_str_lossy();
            if self.aborts.contains_key(&view.src()) && words.to_lowercase().contains("abort") {
                // It carries out an order.
                continue;
            }
            let label = fleet.system(view.src()).and_then(|system| system.entity(view.src_ent()));
            let part = label.map_or_else(|| format!("entity {}", view.src_ent()), str::to_owned);
            let says = AlarmSaying::LogBook { part: bounded(&part), words: bounded(&words) };
            self.entries.insert((view.src(), part), (now.mono, priority, says));
        }
        self.entries.retain(|_, (at, ..)| now.mono.since(*at) < LOG_BOOK_LASTS);
        while self.entries.len() > LOG_BOOK_KEPT {
            let oldest = self.entries.iter().min_by_key(|(_, (at, ..))| *at).map(|(key, _)| key.clone());
            oldest.map(|key| self.entries.remove(&key));
        }
    }

    fn battery(&mut self, system: &System, told: Option<(Priority, AlarmSaying)>) -> Option<Trouble> {
        let vessel = system.address();
        let before = self.beyond.get(&(vessel, Kind::Battery)).copied();
        let limit = |limit: f32, priority: Priority| {
            if before.is_some_and(|before| before >= priority) { limit + BATTERY_HYSTERESIS } else { limit }
        };
        let level = charge(system);
        let low = level.and_then(|level| {
            if level < limit(BATTERY_ALARM, Priority::Alarm) {
                Some(Priority::Alarm)
            } else if level < limit(BATTERY_WARNING, Priority::Warning) {
                Some(Priority::Warning)
            } else {
                None
            }
        });
        match low {
            Some(priority) => self.beyond.insert((vessel, Kind::Battery), priority),
            None => self.beyond.remove(&(vessel, Kind::Battery)),
        };
        let charge = |level: f32| AlarmSaying::Charge { percent: level.round() as i32 };
        let low = low.zip(level).map(|(priority, level)| (priority, charge(level)));
        let priority = low.iter().chain(&told).map(|(priority, _)| *priority).max()?;
        let says = low.into_iter().chain(told).map(|(_, says)| says).collect();
        Some(trouble(vessel, Kind::Battery, "", priority, says))
    }

    fn clock(&mut self, vessel: Address, told: Option<AlarmSaying>, shore: &ShoreState) -> Option<Trouble> {
        let key = (vessel, Kind::Clock);
        let off = shore.clocks.iter().find(|clock| clock.vessel == vessel).filter(|clock| {
            let part = if self.beyond.contains_key(&key) { CLOCK_HYSTERESIS } else { 1.0 };
            // Only what the measurement's own doubt cannot explain.
            clock.ahead_s.abs() - clock.uncertainty_s > CLOCK_OFFSET_S * part
        });
        match off {
            Some(_) => self.beyond.insert(key, Priority::Warning),
            None => self.beyond.remove(&key),
        };
        let off = off.map(|clock| AlarmSaying::Clock { ahead_ms: (clock.ahead_s * 1e3).round() as i64 });
        Some(trouble(vessel, Kind::Clock, "", Priority::Warning, vec![off.or(told)?]))
    }
}

/// A vessel's activity, which decides how urgent its troubles are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd)]
enum Work {
    Rest,
    Plan,
    Steered,
}

impl Work {
    fn of(system: &System) -> Self {
        let Some(state) = latest::<VehicleState>(system) else { return Self::Rest };
        match state.op_mode {
            VehicleStateOpMode::Maneuver if state.maneuver_type == Teleoperation::ID => Self::Steered,
            VehicleStateOpMode::External => Self::Steered,
            VehicleStateOpMode::Maneuver | VehicleStateOpMode::Calibration => Self::Plan,
            _ => Self::Rest,
        }
    }
}

/// The reports of one vessel's parts, sorted by kind.
#[derive(Debug, Default)]
struct Parts {
    /// Labels of those with a fault.
    bad: Vec<String>,
    grounding: Option<(Priority, AlarmSaying)>,
    position: Option<AlarmSaying>,
    motors: Vec<AlarmSaying>,
    battery: Option<(Priority, AlarmSaying)>,
    hydrophone: Option<AlarmSaying>,
    clock: Option<AlarmSaying>,
    console: Option<AlarmSaying>,
    others: Vec<(String, Priority, AlarmSaying)>,
}

impl Parts {
    fn take(&mut self, kind: Option<PartKind>, label: &str, state: &EntityState) {
        let word = match state.state {
            EntityStateState::Fault => "fault",
            EntityStateState::Error => "error",
            EntityStateState::Failure => "failure",
            _ => return,
        };
        let bad = state.state != EntityStateState::Fault;
        self.bad.push(label.to_owned());
        let said = state.description.to_str_lossy();
        let says = AlarmSaying::Part { part: bounded(label), state: word.to_owned(), words: bounded(&said) };
        match kind {
            Some(PartKind::Grounding) => {
                // The supervisor cannot work: nothing is known of any danger.
                let blind = said.contains("not watched");
                let priority = match (blind, bad) {
                    (true, _) => Priority::Warning,
                    (false, true) => Priority::Emergency,
                    (false, false) => Priority::Alarm,
                };
                self.grounding = Some((priority, says));
            }
            Some(PartKind::Navigation) if bad => self.position = Some(says),
            Some(PartKind::Motor) => self.motors.push(says),
            Some(PartKind::Battery) => {
                let priority = if bad { Priority::Alarm } else { Priority::Warning };
                let worse = self.battery.as_ref().is_none_or(|(known, _)| *known < priority);
                if worse {
                    self.battery = Some((priority, says));
                }
            }
            Some(PartKind::Hydrophone) => self.hydrophone = Some(says),
            Some(PartKind::Clock) => self.clock = Some(says),
            Some(PartKind::Console) => self.console = Some(says),
            Some(PartKind::Navigation | PartKind::Compass | PartKind::Path) | None => {
                let priority = if bad { Priority::Warning } else { Priority::Caution };
                self.others.push((label.to_owned(), priority, says));
            }
        }
    }

    fn troubles(&self, vessel: Address, work: Work) -> Vec<Trouble> {
        let mut all = Vec::new();
        let mut push = |kind, part: &str, priority, says: &[AlarmSaying]| {
            all.push(trouble(vessel, kind, part, priority, says.to_vec()));
        };
        if let Some((priority, says)) = &self.grounding {
            push(Kind::Grounding, "", *priority, from_ref(says));
        }
        if let Some(says) = &self.position {
            let priority = if work == Work::Rest { Priority::Warning } else { Priority::Alarm };
            push(Kind::Position, "", priority, from_ref(says));
        }
        if !self.motors.is_empty() {
            let priority = if self.motors.len() > 1 { Priority::Alarm } else { Priority::Warning };
            push(Kind::Motor, "", priority, &self.motors[..self.motors.len().min(MOTORS_TOLD)]);
        }
        if let Some(says) = &self.console {
            push(Kind::NoConsole, "", Priority::Warning, from_ref(says));
        }
        for (label, priority, says) in &self.others {
            push(Kind::Part, label, *priority, from_ref(says));
        }
        all
    }
}

/// Whether this system can have alarms: real vessels, not consoles or imported systems.
fn is_vessel(system: &System) -> bool {
    let sails = match system.kind() {
        Some(kind) => {
            matches!(kind, SystemType::Uuv | SystemType::Usv | SystemType::Uav | SystemType::Ugv)
        }
        None => !system.address().is_ccu() && system.latest(VehicleState::ID).is_some(),
    };
    sails && is_there(system)
}

/// Whether anything came from the system itself, and not only from what was recorded of it.
fn is_there(system: &System) -> bool {
    system.transports().any(|(transport, _)| !matches!(transport, Transport::Shore | Transport::Import))
}

fn came_in(fleet: &Fleet, vessel: Address) -> bool {
    fleet.system(vessel).is_some_and(is_there)
}

fn never_heard(vessel: Address, began: UtcTime) -> Trouble {
    let says = vec![AlarmSaying::NeverHeard { since_us: began.micros() }];
    trouble(vessel, Kind::NeverHeard, "", Priority::Caution, says)
}

fn other_source(claim: &Contradiction) -> Trouble {
    let Contradiction { vessel, transport, peer } = claim;
    let says = AlarmSaying::OtherSource { peer: peer.clone(), transport: transport.to_string() };
    trouble(*vessel, Kind::OtherSource, transport.name(), Priority::Warning, vec![says])
}

fn not_heard(system: &System) -> Trouble {
    let priority = match Work::of(system) {
        Work::Rest => Priority::Caution,
        Work::Plan => Priority::Warning,
        Work::Steered => Priority::Alarm,
    };
    let says = AlarmSaying::NotHeard { since_us: system.last_heard_utc().micros() };
    trouble(system.address(), Kind::NotHeard, "", priority, vec![says])
}

fn of_server(shore: &ShoreState) -> Vec<Trouble> {
    let mut all = Vec::new();
    let mut push = |kind, priority, says| {
        let key = Key { vessel: None, kind, part: String::new() };
        all.push(Trouble { key, priority, says: vec![says] });
    };
    if let Some(text) = &shore.recording {
        push(Kind::Recording, Priority::Alarm, AlarmSaying::Server { words: bounded(text) });
    }
    if let Some(text) = &shore.history {
        push(Kind::History, Priority::Warning, AlarmSaying::Server { words: bounded(text) });
    }
    if let Some(text) = &shore.no_go {
        push(Kind::NoGoAreas, Priority::Alarm, AlarmSaying::NoGoAreas { words: bounded(text) });
    }
    if let Some((free, whole)) = shore.disk {
        let low = free < DISK_CAUTION.0 && (free as f64) < whole as f64 * DISK_CAUTION.1;
        let says = AlarmSaying::Disk { free_mib: free >> 20 };
        if free < DISK_WARNING {
            push(Kind::Disk, Priority::Warning, says);
        } else if low {
            push(Kind::Disk, Priority::Caution, says);
        }
    }
    all
}

/// That a certificate ends, and that its successor cannot be used: two troubles, so that each is acknowledged on its own.
fn of_certificate(now: UtcTime, certificate: &CertificateState) -> Vec<Trouble> {
    let CertificateState { file, until, refused } = certificate;
    let (left_us, file) = (until.micros().saturating_sub(now.micros()), bounded(file));
    let until_us = until.micros();
    let ending = if left_us <= 0 {
        Some((Priority::Alarm, AlarmSaying::CertificateEnded { file, until_us }))
    } else if left_us <= CERTIFICATE_WARNING_US {
        Some((Priority::Warning, AlarmSaying::CertificateEnds { file, until_us }))
    } else if left_us <= CERTIFICATE_CAUTION_US {
        Some((Priority::Caution, AlarmSaying::CertificateEnds { file, until_us }))
    } else {
        None
    };
    let refused = refused
        .as_ref()
        .map(|why| (Priority::Warning, AlarmSaying::CertificateRefused { words: bounded(why) }));
    let told = |(priority, says), part: &str| Trouble {
        key: Key { vessel: None, kind: Kind::Certificate, part: part.to_owned() },
        priority,
        says: vec![says],
    };
    let ending = ending.map(|ending| told(ending, ""));
    ending.into_iter().chain(refused.map(|refused| told(refused, NEW_FILES))).collect()
}

/// The last reports of a vessel's parts, with number and label.
fn states(now: Now, system: &System) -> Vec<(u8, String, EntityState)> {
    let said = system.all_series().filter(|(key, _)| key.id == EntityState::ID);
    // A part's report from long before its vessel was last heard is ignored: its number was reassigned, or it is gone.
    let fresh = said.filter(|(_, series)| age_then(now, system, series) < Duration::from_mins(1));
    let read = |(key, series): (SeriesKey, &Series)| {
        let label = system.entity(key.entity).map_or_else(|| format!("entity {}", key.entity), str::to_owned);
        Some((key.entity, label, decode::<EntityState>(series)?))
    };
    fresh.filter_map(read).collect()
}

fn old_position(now: Now, system: &System) -> Option<AlarmSaying> {
    let (_, series) = system.latest(EstimatedState::ID)?;
    let old = age_then(now, system, series) > POSITION_OLD;
    old.then(|| AlarmSaying::NoPosition { since_us: series.received().micros() })
}

fn silent_hydrophone(now: Now, system: &System) -> Option<AlarmSaying> {
    let (_, series) = system.latest(TBRSensor::ID)?;
    series.period_s()?;
    let silent = age_then(now, system, series) > series.fresh_for().max(HYDROPHONE_SILENT);
    silent.then(|| AlarmSaying::HydrophoneSilent { since_us: series.received().micros() })
}

/// The charge (%): what the monitor says, or the lowest of those that say one.
fn charge(system: &System) -> Option<f32> {
    let all = system.all_series().filter(|(key, _)| key.id == FuelLevel::ID);
    let read = |(key, series): (SeriesKey, &Series)| {
        Some((charge_rank(system, key.entity), decode::<FuelLevel>(series)?.value))
    };
    let known = all.filter_map(read).filter(|(_, value)| value.is_finite());
    known.min_by(|one, other| one.0.cmp(&other.0).then(one.1.total_cmp(&other.1))).map(|(_, value)| value)
}

/// How old a series was when its vessel was last heard.
fn age_then(now: Now, system: &System, series: &Series) -> Duration {
    series.age(now.mono).saturating_sub(now.mono.since(system.last_heard()))
}

fn latest<T: Payload>(system: &System) -> Option<T> {
    decode(system.latest(T::ID)?.1)
}

fn decode<T: Payload>(series: &Series) -> Option<T> {
    imc::decode(&PacketView::unchecked(series.packet()).ok()?).ok()?
}

fn trouble(vessel: Address, kind: Kind, part: &str, priority: Priority, says: Vec<AlarmSaying>) -> Trouble {
    Trouble { key: Key { vessel: Some(vessel), kind, part: part.to_owned() }, priority, says }
}

/// Others' words, no longer than an alarm shows.
fn bounded(words: &str) -> String {
    let mut words = words.to_owned();
    shorten(&mut words);
    words
}
