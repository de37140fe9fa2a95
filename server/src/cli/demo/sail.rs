//! One Otter of a demo from its start to its end: its agent is kept running, and the vessel is given its plan
//! whenever it is ready and has nothing to do.

use super::agent::Agent;
use super::fleet::Otter;
use crate::cli::say::say;
use crate::relay::{Relay, Stopped};
use hub::{Door, Fleet, Liveness, Now};
use imc::messages::{
    EstimatedState, Payload, PlanControl, PlanControlOp, PlanControlState, PlanControlStateState,
    PlanControlType, PlanSpecification, TBRFishTag,
};
use imc::{Address, PacketView};
use std::collections::BTreeSet;
use std::fmt;
use std::path::PathBuf;
use std::time::{Duration, Instant};
use tokio::sync::watch;
use tokio_util::sync::CancellationToken;
use units::{LatLon, LocalFrame};

/// How often an agent that ended by itself is started again.
const RESTARTS: u32 = 3;
/// How long before; what it said before its end is no longer taken for its state then.
const RESTART_AFTER: Duration = Duration::from_secs(3);
/// How often the vessel is looked at.
const LOOK_EVERY: Duration = Duration::from_millis(200);
/// A state older than this says nothing.
const FRESH: Duration = Duration::from_secs(2);
/// After a request to start the plan the next waits so long.
const ASK_EVERY: Duration = Duration::from_secs(5);

/// The server, as an Otter's task knows it.
pub(super) struct Shore {
    pub(super) relay: Relay,
    /// The Otters that have begun to sail.
    pub(super) under_way: watch::Sender<BTreeSet<Address>>,
}

/// What became of an Otter.
#[derive(Debug, Default)]
pub(super) struct Report {
    pub(super) name: String,
    /// Where it was at the end, how fast (m/s), and how far from its start (m).
    place: Option<(LatLon, f64, f64)>,
    /// Transmissions of tags it heard.
    tags: u64,
    linked: bool,
    sailed: bool,
    given_up: bool,
}

impl Report {
    /// What it should have done and did not.
    pub(super) fn missing(&self) -> Option<String> {
        let what = match self {
            Self { given_up: true, .. } => "its agent does not keep running",
            Self { linked: false, .. } => "its link never stood",
            Self { sailed: false, .. } => "it never began its plan",
            Self { place: None, .. } => "nobody knows where it is",
            _ => return None,
        };
        Some(format!("{}: {what}", self.name))
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, place, tags, .. } = self;
        let Some((at, speed_mps, from_start_m)) = place else {
            return write!(f, "{name:<9} was not heard of");
        };
        let (lat_deg, lon_deg) = (at.lat_deg(), at.lon_deg());
        write!(
            f,
            "{name:<9} {lat_deg:.5} N {lon_deg:.5} E, {speed_mps:.1} m/s, {from_start_m:.0} m from its start; \
             {tags} transmissions of tags heard"
        )
    }
}

/// Keeps an Otter sailing until `stop`.
pub(super) async fn sail(
    (otter, plan): (Otter, PlanSpecification),
    program: PathBuf,
    folder: PathBuf,
    shore: Shore,
    stop: CancellationToken,
) -> Report {
    let mut watch = Watch::new(otter, plan, shore);
    for start in 0..=RESTARTS {
        let name = &watch.otter.name;
        let mut agent = match Agent::start(&program, &watch.otter, &folder) {
            Ok(agent) => agent,
            Err(error) => {
                say!("{name:<9} {error:#}");
                break;
            }
        };
        say!("{name:<9} starting, process {}", agent.id());
        let status = tokio::select! {
            status = agent.ended() => status,
            () = watch.look_after() => return watch.report,
            () = stop.cancelled() => {
                watch.remember().await;
                if !agent.end().await {
                    say!("{:<9} did not end in time and was killed", watch.otter.name);
                }
                return watch.report;
            }
        };
        let name = &watch.otter.name;
        let how = status.map_or_else(|error| error.to_string(), |status| status.to_string());
        let again = if start < RESTARTS { "it is started again" } else { "it stays away" };
        say!("{name:<9} its agent ended by itself ({how}); {again}. Its last words:\n{}", agent.last_words());
        if stop.run_until_cancelled(tokio::time::sleep(RESTART_AFTER)).await.is_none() {
            return watch.report;
        }
    }
    watch.report.given_up = true;
    stop.cancelled().await;
    watch.report
}

/// What the server knows of an Otter.
#[derive(Debug, Default)]
struct Seen {
    linked: bool,
    plan: Option<PlanControlState>,
    /// What the vessel said last of why it does not start a plan.
    refusal: Option<String>,
    place: Option<(LatLon, f64)>,
    tags: u64,
    /// Somebody commands it, so that it is not to be given its plan.
    commanded: bool,
}

impl Seen {
    fn of(fleet: &Fleet, now: Now, address: Address) -> Self {
        let Some(system) = fleet.system(address) else { return Self::default() };
        let live = system.liveness(now.mono) == Liveness::Live;
        let fresh = |id| system.latest(id).is_some_and(|(_, series)| series.age(now.mono) < FRESH);
        let reply: Option<PlanControl> = latest(fleet, address);
        Self {
            linked: live && system.doors().any(|(door, _)| door == Door::Link),
            plan: latest(fleet, address).filter(|_| fresh(PlanControlState::ID)),
            refusal: reply
                .filter(|reply| reply.r#type == PlanControlType::Failure)
                .map(|reply| reply.info.to_str_lossy().into_owned()),
            place: latest::<EstimatedState>(fleet, address).and_then(|state| {
                Some((imc::position::place(&state).ok()?, imc::position::ground_speed_mps(&state)))
            }),
            tags: system.latest(TBRFishTag::ID).map_or(0, |(_, series)| series.count()),
            commanded: false,
        }
    }
}

fn latest<T: Payload>(fleet: &Fleet, address: Address) -> Option<T> {
    let (_, series) = fleet.system(address)?.latest(T::ID)?;
    imc::decode(&PacketView::unchecked(series.packet()).ok()?).ok()?
}

/// Looks after a vessel through the server.
struct Watch {
    otter: Otter,
    plan: PlanSpecification,
    shore: Shore,
    requests: u16,
    report: Report,
}

impl Watch {
    fn new(otter: Otter, plan: PlanSpecification, shore: Shore) -> Self {
        let report = Report { name: otter.name.clone(), ..Report::default() };
        Self { otter, plan, shore, requests: 0, report }
    }

    /// Tells how it gets on, and starts its plan whenever it is ready for one; returns when the server ends.
    async fn look_after(&mut self) {
        let (begun, mut asked, mut linked, mut sailing) = (Instant::now(), None::<Instant>, false, false);
        let name = self.otter.name.clone();
        let mut looks = tokio::time::interval(LOOK_EVERY);
        loop {
            looks.tick().await;
            let Ok(seen) = self.look().await else { return };
            if seen.linked && !linked {
                if self.report.linked {
                    say!("{name:<9} link up again");
                } else {
                    say!("{name:<9} link up after {:.1} s", begun.elapsed().as_secs_f64());
                }
            }
            linked = seen.linked;
            self.report.linked |= linked;
            let Some(state) = seen.plan.filter(|_| linked) else { continue };
            let own = state.state == PlanControlStateState::Executing && state.plan_id == self.plan.plan_id;
            if own && !sailing {
                say!(
                    "{name:<9} sails {} after {:.1} s",
                    self.otter.pattern.words(),
                    begun.elapsed().as_secs_f64()
                );
                if !std::mem::replace(&mut self.report.sailed, true) {
                    self.shore.under_way.send_modify(|all| {
                        all.insert(self.otter.address);
                    });
                }
            }
            sailing = own;
            let waited = asked.is_none_or(|asked| asked.elapsed() >= ASK_EVERY);
            if state.state == PlanControlStateState::Ready && waited && !seen.commanded {
                if let Some(reason) = seen.refusal.filter(|_| asked.is_some()) {
                    say!("{name:<9} does not sail: {reason}; asked again");
                }
                asked = Some(Instant::now());
                if self.ask().await.is_err() {
                    return;
                }
            }
        }
    }

    async fn look(&self) -> Result<Seen, Stopped> {
        let address = self.otter.address;
        let seen = move |hub: &mut hub::Hub, now| {
            let commanded = hub.leases().of(address).held.is_some();
            Seen { commanded, ..Seen::of(hub.fleet(), now, address) }
        };
        self.shore.relay.look(seen).await
    }

    /// Sends the plan with the request to start it, as from a console.
    async fn ask(&mut self) -> Result<bool, Stopped> {
        self.requests = self.requests.wrapping_add(1);
        let start = PlanControl {
            r#type: PlanControlType::Request,
            op: PlanControlOp::Start,
            request_id: self.requests,
            plan_id: self.plan.plan_id.clone(),
            arg: self.plan.clone().into(),
            ..PlanControl::default()
        };
        let header = imc::Header {
            timestamp: self.shore.relay.clock().now().utc.seconds(),
            src: self.shore.relay.address(),
            dst: self.otter.address,
            ..imc::Header::default()
        };
        match imc::Packet::new(header, start).encode() {
            Ok(packet) => self.shore.relay.send(packet.into()).await,
            // Plans of a demo are small.
            Err(_) => Ok(false),
        }
    }

    /// Takes down where it is.
    async fn remember(&mut self) {
        let Ok(seen) = self.look().await else { return };
        let frame = LocalFrame::new(self.otter.start);
        self.report.place = seen.place.map(|(place, speed_mps)| {
            let from_start = frame.to_local(place);
            (place, speed_mps, from_start.north_m.hypot(from_start.east_m))
        });
        self.report.tags = seen.tags;
    }
}
