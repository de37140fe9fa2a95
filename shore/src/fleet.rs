//! The present state of the fleet, as the API reports it.

use crate::commands::view;
use crate::router::{Router, Stopped};
use crate::{Changes, Wanted, alarms, decode};
use api::{Fix, Liveness};
use detections::{Detection, fused};
use guard::GuardLimits;
use hub::{SeriesKey, System};
use imc::messages::{Announce, EstimatedState, GpsFix, GpsFixValidity};
use imc::{Address, PacketView};
use onboard::{Entity, Settings};
use operations::{EntityReport, Operations, Question};
use std::collections::BTreeSet;
use std::sync::Arc;
use tokio::sync::watch;
use units::{LatLon, Now};

/// Most series in one answer; a client that wants more gets the rest with its next frame.
const AT_ONCE: usize = 20_000;

/// The entities whose parameters define a vessel's guard limits, and those that every guard has.
const GUARD_PARTS: [Entity; 2] = [Entity::Grounding, Entity::Maneuver];
const GUARD_DEPTHS: [&str; 2] = ["Navigable Depth", "Autonomous Depth"];
/// Limits older than this are requested again: the vessel may have been restarted with other files.
const LIMITS_AGE_US: i64 = 300_000_000;

/// Handle of the fleet's state; cheap to clone.
#[derive(Clone)]
pub struct Fleet {
    router: Router,
}

impl Fleet {
    /// Uses the task that owns the state.
    pub fn new(router: Router) -> Self {
        Self { router }
    }

    /// All systems that `wanted` admits; `None` when the owner has ended.
    pub async fn systems(&self, wanted: Arc<Wanted>) -> Option<Vec<api::System>> {
        self.router.ask(move |operations, now| systems(operations.fleet(), now, &wanted)).await.ok()
    }

    /// Whether a system with this address was heard since the start.
    ///
    /// # Errors
    /// The server is stopping.
    pub async fn is_heard(&self, system: Address) -> Result<bool, Stopped> {
        self.router.ask(move |operations, _| operations.fleet().system(system).is_some()).await
    }

    /// The systems that were heard since the start, with the names that they gave themselves.
    ///
    /// # Errors
    /// The server is stopping.
    pub async fn heard(&self) -> Result<Vec<(Address, Option<String>)>, Stopped> {
        let named = |system: &System| (system.address(), system.name().map(str::to_owned));
        self.router.ask(move |operations, _| operations.fleet().systems().map(named).collect()).await
    }

    /// Last reported position of a vessel, however old.
    pub async fn place(&self, vessel: Address) -> Option<LatLon> {
        let ask = move |operations: &mut Operations, _| operations.fleet().system(vessel).and_then(fix);
        let fix = self.router.ask(ask).await.ok()??;
        LatLon::from_deg(fix.lat_deg, fix.lon_deg).ok()
    }

    /// Position of a vessel that is heard now.
    pub async fn place_now(&self, vessel: Address) -> Option<LatLon> {
        let ask = move |operations: &mut Operations, now: Now| {
            let live = |system: &&System| system.liveness(now.mono) == hub::Liveness::Live;
            operations.fleet().system(vessel).filter(live).and_then(fix)
        };
        let fix = self.router.ask(ask).await.ok()??;
        LatLon::from_deg(fix.lat_deg, fix.lon_deg).ok()
    }

    /// The limits of the vessel's own guard, from its reported parameters; `base` fills in what it did not report. `None`
    /// where it reported no depth limits, as with vessels of other programs. Old reports are requested again.
    pub async fn guard_limits(&self, vessel: Address, base: &GuardLimits) -> Option<GuardLimits> {
        let ask = move |operations: &mut Operations, now: Now| {
            ask_limits(operations, now, vessel);
            let reports = operations.commands().reports();
            GUARD_PARTS.map(|part| {
                let of = reports.entities(vessel).find(|(entity, _)| *entity == part.label_and_task().0);
                of.map(|(_, told)| told.clone()).unwrap_or_default()
            })
        };
        guard_limits(vessel, &self.router.ask(ask).await.ok()?, base)
    }

    /// Changes after `since`, the state of the systems if `described`, and changes of leases, commands and alarms after
    /// `control`; `None` when the owner has ended.
    pub async fn changes(
        &self,
        since: u64,
        control: (u64, u64, u64),
        wanted: Arc<Wanted>,
        described: bool,
    ) -> Option<Changes> {
        let take = move |operations: &mut Operations, now| {
            let raw = Raw::take(operations.fleet(), now, since, &wanted, described);
            let (leases, commands, alarms) = control;
            let control = (
                operations.leases().revision(),
                operations.commands().revision(),
                operations.alarms().revision(),
            );
            let alarms = alarms::changes(operations, alarms, &wanted);
            (raw, view::changes(operations, (leases, commands), &wanted), alarms, control)
        };
        let (raw, (leases, commands), alarms, control) = self.router.ask(take).await.ok()?;
        Some(Changes { leases, commands, alarms, control, ..raw.decode() })
    }

    /// Counts changes.
    pub fn revision(&self) -> watch::Receiver<u64> {
        self.router.revision()
    }
}

/// Requests the parameters of such entities from a vessel that has them and has not reported them lately.
fn ask_limits(operations: &mut Operations, now: Now, vessel: Address) {
    let Some(system) = operations.fleet().system(vessel) else { return };
    let reports = operations.commands().reports();
    let stale = |label: &str| {
        let at = reports.entities(vessel).find(|(entity, _)| *entity == label).and_then(|(_, told)| told.at);
        at.is_none_or(|at| now.utc.micros() - at.micros() > LIMITS_AGE_US)
    };
    let labels = GUARD_PARTS.map(|part| part.label_and_task().0);
    let has = |label: &&str| system.entities().values().any(|entity| entity == *label);
    // A vessel without a guard has no limits to report.
    if !has(&labels[0]) {
        return;
    }
    let wanted = labels.into_iter().filter(has).filter(|label| stale(label));
    let questions: Vec<Question> = wanted.map(|label| Question::Parameters(label.to_owned())).collect();
    // With too many open requests the next check asks again.
    let packets = operations.commands_mut().reports_mut().ask(now, vessel, &questions).unwrap_or_default();
    for packet in &packets {
        operations.hub_mut().send(now, packet);
    }
}

/// The limits of a vessel that reported these parameters.
fn guard_limits(
    vessel: Address,
    told: &[EntityReport; GUARD_PARTS.len()],
    base: &GuardLimits,
) -> Option<GuardLimits> {
    let mut settings = Settings::otter("told", vessel);
    settings.grounding.limits = *base;
    let mut taken = BTreeSet::new();
    for (part, told) in GUARD_PARTS.into_iter().zip(told) {
        // Lutra's own vessels also report saved values, for the next start; with others a parameter of the same name may
        // mean something else.
        let own = told.parameters.values().any(|one| one.saved.is_some());
        let values = told.parameters.iter().map(|(name, one)| (name.as_str(), one.value.as_str()));
        taken.extend(onboard::parameters::take_told(&mut settings, part, values.filter(|_| own)));
    }
    GUARD_DEPTHS.iter().all(|name| taken.contains(name)).then(|| settings.guard_limits())
}

fn systems(fleet: &hub::Fleet, now: Now, wanted: &Wanted) -> Vec<api::System> {
    let admitted = fleet.systems().filter(|system| wanted.admits_system(system.address().0));
    admitted.map(|system| describe(system, now)).collect()
}

fn describe(system: &System, now: Now) -> api::System {
    let mut transports: Vec<_> = system.transports().collect();
    transports.sort_by_key(|(_, heard)| std::cmp::Reverse(*heard));
    api::System {
        address: system.address().0,
        name: system.name().map(str::to_owned),
        kind: system.kind().map(|kind| format!("{kind:?}").to_uppercase()),
        liveness: match system.liveness(now.mono) {
            hub::Liveness::Live => Liveness::Live,
            hub::Liveness::Late => Liveness::Late,
            hub::Liveness::Stale => Liveness::Stale,
            hub::Liveness::Lost => Liveness::Lost,
        },
        heard_us: system.last_heard_utc().micros(),
        transports: transports.into_iter().map(|(transport, _)| transport.name().to_owned()).collect(),
        fix: fix(system),
        entities: system.entities().clone(),
    }
}

/// Where a system is: by its navigation, else by its receiver, else by its announcement.
fn fix(system: &System) -> Option<Fix> {
    estimated(system).or_else(|| received(system)).or_else(|| announced(system))
}

fn estimated(system: &System) -> Option<Fix> {
    let (view, state) = latest::<EstimatedState>(system)?;
    let place = imc::position::place(&state).ok()?;
    let speed_mps = imc::position::ground_speed_mps(&state);
    Some(Fix {
        time_us: view.header().time()?.micros(),
        lat_deg: place.lat_rad().to_degrees(),
        lon_deg: place.lon_rad().to_degrees(),
        heading_rad: turn(f64::from(state.psi)),
        course_rad: turn(imc::position::course_rad(&state)).filter(|_| speed_mps > 0.05),
        speed_mps: Some(speed_mps).filter(|speed| speed.is_finite()),
    })
}

fn received(system: &System) -> Option<Fix> {
    let (view, gps) = latest::<GpsFix>(system)?;
    let valid = |bit| gps.validity.contains(bit);
    let (lat_deg, lon_deg) = place(gps.lat, gps.lon).filter(|_| valid(GpsFixValidity::VALID_POS))?;
    Some(Fix {
        time_us: view.header().time()?.micros(),
        lat_deg,
        lon_deg,
        heading_rad: None,
        course_rad: turn(f64::from(gps.cog)).filter(|_| valid(GpsFixValidity::VALID_COG)),
        speed_mps: Some(f64::from(gps.sog)).filter(|_| valid(GpsFixValidity::VALID_SOG)),
    })
}

fn announced(system: &System) -> Option<Fix> {
    let (view, announce) = latest::<Announce>(system)?;
    let (lat_deg, lon_deg) = place(announce.lat, announce.lon)?;
    let time_us = view.header().time()?.micros();
    Some(Fix { time_us, lat_deg, lon_deg, heading_rad: None, course_rad: None, speed_mps: None })
}

fn latest<T: imc::messages::Payload>(system: &System) -> Option<(PacketView<'_>, T)> {
    let (_, series) = system.latest(T::ID)?;
    let view = PacketView::unchecked(series.packet()).ok()?;
    let message = imc::decode(&view).ok()??;
    Some((view, message))
}

/// Degrees of a position; `None` for 0/0, which senders use for an unknown position.
fn place(lat_rad: f64, lon_rad: f64) -> Option<(f64, f64)> {
    let known = lat_rad != 0.0 || lon_rad != 0.0;
    let earthly = lat_rad.abs() <= std::f64::consts::FRAC_PI_2 && lon_rad.abs() <= std::f64::consts::PI;
    (known && earthly).then(|| (lat_rad.to_degrees(), lon_rad.to_degrees()))
}

/// An angle from 0 to 2π; `None` for what is not a number.
fn turn(angle_rad: f64) -> Option<f64> {
    angle_rad.is_finite().then(|| angle_rad.rem_euclid(std::f64::consts::TAU))
}

/// Changes, not decoded yet: the hub's task only copies, so that many clients do not delay the relay.
struct Raw {
    revision: u64,
    systems: Vec<api::System>,
    values: Vec<(SeriesKey, hub::Series)>,
    events: Vec<hub::Event>,
    events_missed: u64,
}

impl Raw {
    fn take(fleet: &hub::Fleet, now: Now, since: u64, wanted: &Wanted, described: bool) -> Self {
        let admits = |address: Address, key: SeriesKey| {
            wanted.admits_system(address.0) && wanted.admits_message(address.0, key.id)
        };
        let changes = fleet.changes(since, AT_ONCE, admits);
        let events = if wanted.events { changes.events } else { Vec::new() };
        Self {
            revision: changes.revision,
            systems: if described { systems(fleet, now, wanted) } else { Vec::new() },
            values: changes.series.into_iter().map(|(_, key, series)| (key, series.clone())).collect(),
            events,
            events_missed: if wanted.events { changes.events_missed } else { 0 },
        }
    }

    fn decode(self) -> Changes {
        let event = |event: &hub::Event| decode::packet(&event.packet, None, event.received, None);
        let detection = |event: &hub::Event| {
            let view = PacketView::unchecked(&event.packet).ok()?;
            Detection::from_packet(&view, event.received)
        };
        let heard = fused(self.events.iter().filter_map(detection).collect());
        let of_the_present = self.events.iter().filter(|event| !event.late);
        Changes {
            revision: self.revision,
            systems: self.systems,
            values: self.values.iter().filter_map(|(key, series)| decode::series(*key, series)).collect(),
            events: of_the_present.filter_map(event).collect(),
            detections: heard.into_iter().map(decode::detection).collect(),
            events_missed: self.events_missed,
            ..Changes::default()
        }
    }
}
