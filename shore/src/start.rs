//! Starts all services of a shore, and ends them in order.

use crate::alarms::{Alarms, Watch};
use crate::areas::NoGoAreas;
use crate::charts::{Charts, ChartsAboard};
use crate::clock::Clock;
use crate::commands::{Commands, Grounding, Helms};
use crate::datasets::Datasets;
use crate::fleet::Fleet;
use crate::history::{History, Imports};
use crate::identity::{FirstAdmin, People};
use crate::links::Links;
use crate::logbook::Logbook;
use crate::missions::Missions;
use crate::months::MonthCompression;
use crate::notices::Notices;
use crate::owners::Owners;
use crate::packing::Compression;
use crate::recorder::Recorder;
use crate::register::Register;
use crate::reports::Reports;
use crate::router::Router;
use crate::routing::Routing;
use crate::settings::Settings;
use crate::sinks::Sinks;
use crate::{Shore, folder, private};
use anyhow::Context as _;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
use store::Store;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

/// Time limit for writing the queue to disk at the end.
const LAST_WRITE: Duration = Duration::from_secs(30);
/// Time limit for closing open sockets.
const GOOD_BYE: Duration = Duration::from_secs(2);

/// The data folder is open and the hub runs, so that transports can be opened; no client is admitted yet.
pub struct Opened {
    /// The hub.
    pub router: Router,
    /// Watches the owners of state.
    pub owners: Owners,
    /// Tasks that outlive their request.
    pub tasks: TaskTracker,
    /// Cancelled when the server is about to end.
    pub stop: CancellationToken,
    clock: Clock,
    settings: Settings,
    recorder: Recorder,
    recording: std::thread::JoinHandle<()>,
}

/// A running shore.
pub struct Running {
    /// Its services.
    pub shore: Arc<Shore>,
    /// The account made at the very first start.
    pub first_admin: Option<FirstAdmin>,
    sinks: Option<Sinks>,
    data: PathBuf,
    compress_after_days: u16,
    compress_months_after_days: u16,
    recording: std::thread::JoinHandle<()>,
}

impl Opened {
    /// Opens the data folder, and starts recorder and hub.
    ///
    /// # Errors
    /// The data folder cannot be used, or belongs to another program.
    pub fn open(settings: Settings, clock: Clock) -> anyhow::Result<Self> {
        folder::check(&settings.data)?;
        folder::refuse_newer(&settings.data)?;
        let (tasks, owners, stop) =
            (TaskTracker::new(), Owners::new(clock.clone()), CancellationToken::new());
        let data = &settings.data;
        for told in private::keep(data).with_context(|| data.display().to_string())?.told(true) {
            tracing::warn!("{told}");
        }
        let store = Store::open_at_once(data)?;
        for note in &store.repairs().notes {
            tracing::warn!("{note}");
        }
        let (recorder, recording) = Recorder::start(store, &owners).context("cannot start a thread")?;
        let router = Router::start(
            settings.hub.clone(),
            recorder.clone(),
            clock.clone(),
            (&tasks, &owners),
            stop.clone(),
        );
        Ok(Self { router, owners, tasks, stop, clock, settings, recorder, recording })
    }

    /// Starts all services and their background tasks. The caller must not admit clients before this is done: only then are
    /// the vessels with a link known.
    ///
    /// # Errors
    /// app.db or a sink cannot be used.
    pub async fn start(self) -> anyhow::Result<Running> {
        let (router, trusted) = (self.router.clone(), self.settings.trusted.clone());
        let mut running = self.assemble().await?;
        router.believe(trusted, running.shore.people.linked()).await?;
        running.keep();
        Ok(running)
    }

    /// Starts all services without their background tasks: tests drive them.
    ///
    /// # Errors
    /// As [`Opened::start`].
    pub async fn assemble(self) -> anyhow::Result<Running> {
        let Self { router, owners, tasks, stop, clock, settings, recorder, recording } = self;
        let open_sinks = Sinks::open(&settings.sinks, &settings.data, &recorder, &clock)?;
        // Last of the steps that can fail: a new one-time password must also be shown.
        let (people, first_admin) =
            People::start(&settings.data, &settings.people, &owners, clock.clone()).await?;
        let (history, imports) = (History::new(&settings.data), Imports::new(&settings, clock.clone()));
        let charts = Charts::new(&settings);
        let areas = NoGoAreas::new(people.clone(), clock.clone(), charts.clone());
        areas.tell().await?;
        let first_look = charts.clone();
        tokio::task::spawn_blocking(move || first_look.take()).await?;
        let known = (charts.clone(), ChartsAboard::open(&settings.data));
        let links = Links::new(router.clone(), recorder.clone(), known, tasks.clone(), stop.clone());
        let fleet = Fleet::new(router.clone());
        let grounding = Grounding::new(router.clone(), people.clone(), fleet.clone(), charts.clone());
        let commands = Commands::new(router.clone(), people.clone(), grounding.clone(), tasks.clone());
        let alarms = Alarms::new(router.clone(), people.clone());
        let logbook = Logbook::new(people.clone(), clock.clone(), &settings.data);
        let missions = Missions::new(people.clone(), clock.clone(), history.clone());
        let register = Register::new(people.clone(), clock.clone());
        let datasets = Datasets::new(people.clone(), clock.clone(), history.clone(), register.clone());
        let notices = Notices::new(people.clone(), clock.clone(), settings.notices);
        let sinks = open_sinks.states();
        let reports = Reports::new(router.clone(), history.clone(), grounding.clone());
        let helms = Helms::default();
        let shore = Shore {
            commands,
            grounding,
            alarms,
            reports,
            people,
            fleet,
            history,
            imports,
            charts,
            areas,
            routing: Routing::default(),
            logbook,
            missions,
            register,
            datasets,
            notices,
            links,
            helms,
            router,
            recorder,
            clock,
            owners,
            sinks,
            stop,
            tasks,
        };
        let shore = Arc::new(shore);
        let Settings { data, compress_after_days, compress_months_after_days, .. } = settings;
        Ok(Running {
            shore,
            first_admin,
            sinks: Some(open_sinks),
            data,
            compress_after_days,
            compress_months_after_days,
            recording,
        })
    }
}

impl Running {
    /// Starts the background tasks: the audit log, changes of the chart set, sinks, compression of archive
    /// and history, the alarm watch.
    fn keep(&mut self) {
        let Shore {
            people,
            commands,
            alarms,
            areas,
            charts,
            routing,
            links,
            notices,
            recorder,
            owners,
            clock,
            tasks,
            stop,
            ..
        } = &*self.shore;
        people.keep(owners, tasks, stop);
        tasks.spawn(charts.clone().keep(stop.clone()));
        tasks.spawn(routing.clone().keep_prepared(charts.clone(), stop.clone()));
        tasks.spawn(areas.clone().keep(stop.clone()));
        if let Some(sinks) = self.sinks.take() {
            sinks.run(tasks, stop);
        }
        tasks.spawn(owners.watch("the log of orders", commands.clone().keep_log(stop.clone())));
        let watch = Watch {
            links: links.clone(),
            charts: charts.clone(),
            recorder: recorder.clone(),
            data: self.data.clone(),
            owners: owners.clone(),
            tasks: tasks.clone(),
            stop: stop.clone(),
        };
        if self.compress_after_days > 0 {
            let compression = Compression {
                data: self.data.clone(),
                after_days: self.compress_after_days,
                recorder: recorder.clone(),
                clock: clock.clone(),
            };
            tasks.spawn(owners.watch("the compression of old days", compression.keep(stop.clone())));
        }
        if self.compress_months_after_days > 0 {
            let compression = MonthCompression {
                data: self.data.clone(),
                after_days: self.compress_months_after_days,
                recorder: recorder.clone(),
                clock: clock.clone(),
            };
            tasks.spawn(owners.watch("the compression of old months", compression.keep(stop.clone())));
        }
        tasks.spawn(owners.watch("the watch for alarms", alarms.clone().watch(watch)));
        tasks.spawn(
            owners.watch("the messages about alarms", notices.clone().keep(alarms.clone(), stop.clone())),
        );
    }

    /// Ends the services, once no clients are admitted and [`Shore::stop`] was cancelled.
    pub async fn end(self) {
        let Shore { tasks, people, recorder, .. } = &*self.shore;
        tasks.close();
        if tokio::time::timeout(GOOD_BYE, tasks.wait()).await.is_err() {
            tracing::warn!("{} sockets were cut off", tasks.len());
        }
        people.finish().await;
        recorder.close();
        let recorded = tokio::task::spawn_blocking(|| self.recording.join());
        if tokio::time::timeout(LAST_WRITE, recorded).await.is_err() {
            tracing::error!("the disk hangs: what waited for it is not recorded");
        }
    }
}
