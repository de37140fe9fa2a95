//! One Otter of a demo: its agent is kept running, and the vessel is given its plan whenever it is ready and idle, until a
//! user commands it.

use super::agent::Agent;
use super::fleet::Otter;
use crate::cli::say::{counted, say};
use api::{Command, Liveness, Update};
use imc::Address;
use imc::messages::PlanSpecification;
use operations::{LeaseRequest, Order};
use shore::commands::Issuer;
use shore::{Changes, Shore, Wanted, clock};
use std::collections::BTreeSet;
use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::sync::watch;
use tokio_util::sync::CancellationToken;
use units::{LatLon, LocalFrame};

/// How often an agent that ended unexpectedly is restarted.
const RESTARTS: u32 = 3;
/// Pause before a restart: by then the old agent's last state has expired.
const RESTART_AFTER: Duration = Duration::from_secs(3);
/// How often the vessel's state is read.
const LOOK_EVERY: Duration = Duration::from_millis(200);
/// An older state is ignored.
const FRESH_US: i64 = 2_000_000;
/// Least time between two requests to start the plan.
const ASK_EVERY: Duration = Duration::from_secs(5);
/// How long it waits for the outcome of an order; the order itself continues.
const PATIENCE: Duration = Duration::from_secs(10);
/// Messages that the demo reads.
const MESSAGES: [&str; 3] = ["PlanControlState", "PlanControl", "TBRFishTag"];
/// Orders by which a user takes over a vessel: the demo then leaves it alone.
const STEERS: [&str; 5] = ["vessel.abort", "plan.start", "plan.stop", "goto", "teleop.begin"];

/// The demo as a client of the shore: it commands as a script does.
pub(super) struct Crew {
    pub(super) shore: Arc<Shore>,
    /// A script of the admin.
    pub(super) by: Issuer,
    /// The Otters that have begun to sail.
    pub(super) under_way: watch::Sender<BTreeSet<Address>>,
}

/// Outcome of an Otter.
#[derive(Debug, Default)]
pub(super) struct Report {
    pub(super) name: String,
    /// Its last position, speed (m/s), and distance from its start (m).
    place: Option<(LatLon, f64, f64)>,
    /// Transmissions of tags it heard.
    tags: u64,
    linked: bool,
    sailed: bool,
    given_up: bool,
}

impl Report {
    /// What it failed to do.
    pub(super) fn missing(&self) -> Option<String> {
        let what = match self {
            Self { given_up: true, .. } => "its agent does not keep running",
            Self { linked: false, .. } => "its link never stood",
            Self { sailed: false, .. } => "it never began its plan",
            Self { place: None, .. } => "its position is not known",
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
             {} of tags heard",
            counted(*tags, "transmission")
        )
    }
}

/// Keeps an Otter sailing until `stop`.
pub(super) async fn sail(
    (otter, plan): (Otter, PlanSpecification),
    program: PathBuf,
    folder: PathBuf,
    crew: Crew,
    stop: CancellationToken,
) -> Report {
    let mut watch = Watch::new(otter, plan, crew);
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

/// State of an Otter as the shore knows it.
#[derive(Debug, Default)]
struct Seen {
    linked: bool,
    /// The plan that it executes.
    executes: Option<String>,
    /// Whether it can start a plan.
    is_ready: bool,
    /// The vessel's last reason for refusing a plan.
    refusal: Option<String>,
    place: Option<(LatLon, f64)>,
    tags: u64,
    /// A user has control, so the plan must not be started now.
    commanded: bool,
    /// Commands by users that stopped it or sent it elsewhere: number and user, the newest first.
    steered: Vec<(u64, String)>,
}

impl Seen {
    fn of(all: &Changes) -> Self {
        let Some(system) = all.systems.first() else { return Self::default() };
        let last = |abbrev: &str| {
            all.values.iter().filter(|one| one.abbrev == abbrev).max_by_key(|one| one.received_us)
        };
        let fresh = |one: &&Update| clock::now().micros() - one.received_us < FRESH_US;
        let plan = last("PlanControlState").filter(fresh);
        let is = |state: &str| plan.is_some_and(|plan| meaning(plan, "state") == Some(state));
        let failed = last("PlanControl").filter(|reply| meaning(reply, "type") == Some("FAILURE"));
        Self {
            linked: system.liveness == Liveness::Live
                && system.transports.iter().any(|transport| transport == "link"),
            executes: plan.filter(|_| is("EXECUTING")).and_then(|plan| text(plan, "plan_id")),
            is_ready: is("READY"),
            refusal: failed.and_then(|reply| text(reply, "info")),
            place: system
                .fix
                .as_ref()
                .and_then(|fix| Some((LatLon::from_deg(fix.lat_deg, fix.lon_deg).ok()?, fix.speed_mps?))),
            tags: last("TBRFishTag").map_or(0, |tags| tags.count),
            commanded: all.leases.iter().any(|lease| lease.holder.is_some()),
            steered: {
                let refused = |one: &Command| one.steps.last().is_some_and(|step| step.stage == "refused");
                let steers = |one: &&Command| STEERS.contains(&one.order.as_str()) && !refused(one);
                let steers = all.commands.iter().filter(steers);
                steers.rev().map(|one| (one.id, one.by.clone())).collect()
            },
        }
    }
}

fn meaning<'u>(update: &'u Update, name: &str) -> Option<&'u str> {
    update.fields.iter().find(|field| field.name == name)?.meaning.as_deref()
}

fn text(update: &Update, name: &str) -> Option<String> {
    Some(update.fields.iter().find(|field| field.name == name)?.value.as_str()?.to_owned())
}

/// Supervises a vessel through the server.
struct Watch {
    otter: Otter,
    plan: PlanSpecification,
    crew: Crew,
    report: Report,
    /// The numbers of the demo's own orders.
    own: BTreeSet<u64>,
    /// Whether it was reported that the vessel is left to a user.
    left: bool,
}

impl Watch {
    fn new(otter: Otter, plan: PlanSpecification, crew: Crew) -> Self {
        let report = Report { name: otter.name.clone(), ..Report::default() };
        Self { otter, plan, crew, report, own: BTreeSet::new(), left: false }
    }

    /// Reports progress, and starts the plan whenever the vessel is ready; returns when the server ends.
    async fn look_after(&mut self) {
        let (begun, mut asked, mut linked, mut sailing) = (Instant::now(), None::<Instant>, false, false);
        let name = self.otter.name.clone();
        let mut looks = tokio::time::interval(LOOK_EVERY);
        loop {
            looks.tick().await;
            let Some(seen) = self.look().await else { return };
            if seen.linked && !linked {
                if self.report.linked {
                    say!("{name:<9} link up again");
                } else {
                    say!("{name:<9} link up after {:.1} s", begun.elapsed().as_secs_f64());
                }
            }
            linked = seen.linked;
            self.report.linked |= linked;
            if !linked {
                continue;
            }
            let own = seen.executes.as_deref().is_some_and(|plan| self.plan.plan_id.to_str_lossy() == plan);
            if own && !sailing {
                say!(
                    "{name:<9} sails {} after {:.1} s",
                    self.otter.pattern.words(),
                    begun.elapsed().as_secs_f64()
                );
                if !std::mem::replace(&mut self.report.sailed, true) {
                    self.crew.under_way.send_modify(|all| {
                        all.insert(self.otter.address);
                    });
                }
            }
            sailing = own;
            self.leave_to(&seen);
            let waited = asked.is_none_or(|asked| asked.elapsed() >= ASK_EVERY);
            if seen.is_ready && waited && !seen.commanded && !self.left {
                if let Some(reason) = seen.refusal.filter(|_| asked.is_some()) {
                    say!("{name:<9} does not sail: {reason}; asked again");
                }
                asked = Some(Instant::now());
                if let Err(why) = self.start().await {
                    say!("{name:<9} is not started: {why}");
                }
            }
        }
    }

    /// A vessel that a user stopped or sent elsewhere is left alone: the demo would only undo that.
    fn leave_to(&mut self, seen: &Seen) {
        if self.left {
            return;
        }
        if let Some((_, who)) = seen.steered.iter().find(|(id, _)| !self.own.contains(id)) {
            say!("{:<9} is commanded by {who}: the demo leaves it alone from now on", self.otter.name);
            self.left = true;
        }
    }

    /// Its present state; `None` once the server ends.
    async fn look(&self) -> Option<Seen> {
        let Crew { shore, by, .. } = &self.crew;
        let wanted = Wanted {
            grants: by.who.grants.clone(),
            systems: Some([self.otter.address.0].into()),
            messages: Some(MESSAGES.map(str::to_owned).into()),
            ..Wanted::default()
        };
        let all = shore.fleet.changes(0, (0, 0, 0), Arc::new(wanted), true).await?;
        Some(Seen::of(&all))
    }

    /// Takes control, sends the plan, has it started, and gives control back: as a person does from a browser.
    async fn start(&mut self) -> shore::Result<()> {
        let (commands, vessel) = (self.crew.shore.commands.clone(), self.otter.address);
        let by = Issuer { window: format!("demo-{}", self.otter.name), ..self.crew.by.clone() };
        let reason = "the demo gives it its plan";
        let lease = commands.ask_lease(vessel, by.clone(), LeaseRequest::Request(reason.to_owned()), reason);
        lease.await?;
        let begun = self.order(&by).await;
        // So that a user can take control without asking.
        commands.ask_lease(vessel, by, LeaseRequest::Release, "").await?;
        begun
    }

    async fn order(&mut self, by: &Issuer) -> shore::Result<()> {
        // The vessel must have the plan before it can start it.
        self.see_out(by, Order::Upload(Box::new(self.plan.clone()))).await?;
        let plan_id = self.plan.plan_id.to_str_lossy().into_owned();
        self.see_out(by, Order::StartPlan { plan_id }).await
    }

    /// Gives an order, and waits for its outcome, with a time limit.
    async fn see_out(&mut self, by: &Issuer, order: Order) -> shore::Result<()> {
        let vessel = self.otter.address;
        let commands = self.crew.shore.commands.clone();
        let given = commands.issue(vessel, by, order).await?;
        self.own.insert(given.id);
        let (begun, mut looks) = (Instant::now(), tokio::time::interval(LOOK_EVERY));
        while begun.elapsed() < PATIENCE {
            looks.tick().await;
            if commands.one(vessel, given.id).await?.is_none_or(|one| one.over) {
                break;
            }
        }
        Ok(())
    }

    /// Stores its position.
    async fn remember(&mut self) {
        let Some(seen) = self.look().await else { return };
        let frame = LocalFrame::new(self.otter.start);
        self.report.place = seen.place.map(|(place, speed_mps)| {
            let from_start = frame.to_local(place);
            (place, speed_mps, from_start.north_m.hypot(from_start.east_m))
        });
        self.report.tags = seen.tags;
    }
}
