//! The sea chart as the server holds it: the chart set on disk, loaded into memory, and queries to it.
//!
//! [`Charts`] checks every two seconds whether the file changed, as after `lutra-server chart import`, and replaces the set
//! as a whole; until then queries use the old one. Without a file there is no chart; while a file cannot be read, the
//! grounding guard refuses plans.

mod aboard;
mod answer;
mod areas;
mod cache;
mod drawing;
mod package;
mod settings;
mod traffic;
pub(crate) mod verdict;

pub use aboard::ChartsAboard;
pub use answer::{at, corridor, described, way_m};
pub use areas::NoGo;
pub use package::ChartPackage;
pub use settings::Settings;
pub use traffic::Traffic;
pub use verdict::{Limits, told};

use ::guard::GuardLimits;
use areas::Areas;
use cache::Cache;
use chartdb::{Chart, ChartDb, LoadedIndex};
use charts::depth_index::{Demand, DepthIndex, EntryRule, EntryRules};
use flate2::Compression;
use flate2::write::GzEncoder;
use mission::Plan;
use mission::check_plan;
use planner::{Cancel, PlanError, Prepared, Router};
use std::fs;
use std::io::Write as _;
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock, PoisonError, RwLock};
use std::time::{Duration, SystemTime};
use tiles::{Changed, NoTile, Sheet};
use tokio::sync::watch;
use tokio::task::JoinHandle;
use tokio_util::sync::CancellationToken;
use units::LatLon;

/// How often the file is checked for changes.
const LOOK_EVERY: Duration = Duration::from_secs(2);

/// The sea chart; cheap to clone.
#[derive(Clone)]
pub struct Charts(Arc<Shared>);

struct Shared {
    path: PathBuf,
    limits: GuardLimits,
    cache_bytes: usize,
    now: RwLock<Now>,
    /// The file state that `now` was made from; held while a new set is read.
    seen: Mutex<Seen>,
    /// The no-go areas.
    areas: Areas,
    /// The chart that vessels are offered.
    offered: watch::Sender<Option<Arc<ChartPackage>>>,
    /// Says that another set is in force.
    changed: watch::Sender<()>,
}

/// The current set.
#[derive(Clone, Default)]
struct Now {
    set: Option<Arc<Set>>,
    trouble: Option<String>,
}

/// Identifies one state of the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Stamp {
    inode: u64,
    bytes: u64,
    modified: Option<SystemTime>,
}

/// The last state that was read.
#[derive(Debug, Default)]
struct Seen {
    /// The state of the file.
    stamp: Option<Stamp>,
    /// Whether the set is withheld from vessels, because it lacks a closed area.
    withheld: bool,
    offer: Offer,
}

/// The next offer to vessels.
#[derive(Debug, Default)]
enum Offer {
    /// No change.
    #[default]
    AsBefore,
    /// Nothing: there is no set.
    Nothing,
    /// The set of this index, once it has been read.
    Set(LoadedIndex),
}

impl Stamp {
    fn of(path: &Path) -> Option<Self> {
        let about = fs::metadata(path).ok()?;
        Some(Self { inode: about.ino(), bytes: about.len(), modified: about.modified().ok() })
    }
}

/// A chart set in memory.
pub struct Set {
    /// Digest of its contents, in hexadecimal digits.
    pub digest: String,
    /// The charts by name.
    pub charts: Vec<Chart>,
    /// The depth index.
    pub index: Arc<DepthIndex>,
    /// Plans routes on it.
    pub router: Router,
    /// Its areas of ordered traffic.
    pub traffic: Traffic,
    /// Water that routes were asked in on the set before, and that is to be prepared again; the last one is the next.
    wanted: Mutex<Vec<Prepared>>,
    path: PathBuf,
    sheet: OnceLock<Sheet>,
    tiles: Mutex<Cache>,
}

impl Charts {
    /// Empty; [`Self::look`] loads the set.
    pub fn new(settings: &crate::Settings) -> Self {
        let cache_bytes = usize::try_from(settings.charts.tiles_mib << 20).unwrap_or(usize::MAX);
        Self(Arc::new(Shared {
            path: settings.chart_set(),
            limits: settings.charts.limits(),
            cache_bytes,
            now: RwLock::default(),
            seen: Mutex::default(),
            areas: Areas::default(),
            offered: watch::channel(None).0,
            changed: watch::channel(()).0,
        }))
    }

    /// The limits for vessels that have not reported their own.
    pub fn limits(&self) -> &GuardLimits {
        &self.0.limits
    }

    /// The set, if there is one.
    pub fn set(&self) -> Option<Arc<Set>> {
        self.now().set
    }

    /// The chart that vessels are offered, as it changes.
    pub fn offered(&self) -> watch::Receiver<Option<Arc<ChartPackage>>> {
        self.0.offered.subscribe()
    }

    /// Changes whenever another set is in force.
    pub fn changes(&self) -> watch::Receiver<()> {
        self.0.changed.subscribe()
    }

    /// Why the file cannot be used, if so.
    pub fn trouble(&self) -> Option<String> {
        self.now().trouble
    }

    fn now(&self) -> Now {
        self.0.now.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Sets the no-go areas, which the next look applies.
    pub(crate) fn close(&self, areas: NoGo) {
        self.0.areas.want(areas);
    }

    /// Why the current set lacks closed no-go areas; `None` where it has all.
    pub fn not_closed(&self) -> Option<String> {
        self.does_not_hold(None)
    }

    /// The same for these areas, or for those that were set last.
    pub(crate) fn does_not_hold(&self, areas: Option<&NoGo>) -> Option<String> {
        let now = self.now();
        self.0.areas.missing(now.set.as_ref().map(|set| set.charts.as_slice()), areas, now.trouble)
    }

    /// Limits that forbid entry into no-go areas: these are prohibited areas in the chart, which a configured rule may
    /// otherwise allow.
    pub fn strict(&self, limits: GuardLimits) -> GuardLimits {
        if !self.0.areas.are_some() {
            return limits;
        }
        let floor = EntryRules { prohibited: EntryRule::Refuse, ..EntryRules::IGNORE };
        GuardLimits { entry: limits.entry.at_least(floor), ..limits }
    }

    /// Loads the set on disk if it changed or if parts of it were found damaged. The set is in force at once; vessels are
    /// offered it when the file has been read completely.
    pub fn look(&self) {
        self.take();
        self.offer();
    }

    /// Loads the set on disk, and leaves the offer to vessels to the next look: a starting server answers before the file,
    /// which may have gigabytes, has been read.
    pub(crate) fn take(&self) {
        let mut seen = self.0.seen.lock().unwrap_or_else(PoisonError::into_inner);
        let before = self.now();
        let held = before.set.as_ref().map_or(&[][..], |set| &set.charts);
        if seen.stamp != Stamp::of(&self.0.path) || self.0.areas.differ(held) {
            self.0.areas.bring_into(&self.0.path);
        }
        let stamp = Stamp::of(&self.0.path);
        let damage = before.set.as_ref().map_or_else(Vec::new, |set| set.index.unreadable());
        let released = seen.withheld && !self.0.areas.are_lacking(held);
        if seen.stamp == stamp && damage.is_empty() && !released {
            return;
        }
        for what in &damage {
            tracing::error!(what, "a chart cannot be read; all charts are made ready again");
        }
        let mut fresh = Offer::Nothing;
        let now = match (stamp, load(&self.0.path, self.0.cache_bytes, damage.is_empty())) {
            (None, _) => Now::default(),
            (_, Ok((set, loaded))) => match before.set {
                Some(old) if old.digest == set.digest && damage.is_empty() && !released => {
                    fresh = std::mem::take(&mut seen.offer);
                    Now { set: Some(old), trouble: None }
                }
                _ => {
                    fresh = Offer::Set(loaded);
                    tracing::info!(
                        charts = set.charts.len(),
                        digest = set.digest,
                        "the chart set is in force"
                    );
                    let before = before.set.as_ref().map(|old| old.water_to_prepare()).unwrap_or_default();
                    *set.lock_wanted() = before;
                    Now { set: Some(Arc::new(set)), trouble: None }
                }
            },
            // An import is committing: the previous set stays in force, and the next look tries again.
            (_, Err(error)) if error.is_busy() => {
                tracing::debug!(%error, "the chart set is looked at again");
                return;
            }
            (_, Err(error)) => {
                tracing::error!(%error, "the chart set cannot be used");
                Now { set: None, trouble: Some(error.to_string()) }
            }
        };
        // Vessels keep their chart rather than get one without the closed areas.
        let withheld = now.set.as_ref().is_some_and(|set| self.0.areas.are_lacking(&set.charts));
        *self.0.now.write().unwrap_or_else(PoisonError::into_inner) = now;
        self.0.changed.send_replace(());
        *seen = Seen { stamp, withheld, offer: if withheld { Offer::AsBefore } else { fresh } };
    }

    /// Offers the loaded set to vessels, if not done yet.
    fn offer(&self) {
        let mut seen = self.0.seen.lock().unwrap_or_else(PoisonError::into_inner);
        let package = match std::mem::take(&mut seen.offer) {
            Offer::AsBefore => return,
            Offer::Nothing => None,
            Offer::Set(loaded) => package(&self.0.path, &loaded),
        };
        self.0.offered.send_if_modified(|offered| {
            let digest =
                |package: &Option<Arc<ChartPackage>>| package.as_ref().map(|package| package.digest());
            let differs = digest(offered) != digest(&package);
            *offered = package;
            differs
        });
    }

    /// Looks every two seconds until the server ends. Overviews of a new set, for small zooms, are made in parallel.
    pub async fn keep(self, stop: CancellationToken) {
        let mut every = tokio::time::interval(LOOK_EVERY);
        let mut told = Vec::new();
        let mut prepared: Option<(String, JoinHandle<bool>)> = None;
        let mut done: Option<String> = None;
        while stop.run_until_cancelled(every.tick()).await.is_some() {
            let charts = self.clone();
            tokio::task::spawn_blocking(move || charts.look()).await.ok();
            let Some(set) = self.set() else { continue };
            let damage = set.undrawn();
            for what in damage.iter().filter(|what| !told.contains(*what)) {
                tracing::error!(what, "a chart cannot be drawn; nothing is drawn where it lies");
            }
            told = damage;
            if prepared.as_ref().is_some_and(|(_, task)| task.is_finished())
                && let Some((digest, task)) = prepared.take()
                && task.await.unwrap_or(false)
            {
                done = Some(digest);
            }
            if prepared.is_none() && done.as_ref() != Some(&set.digest) {
                let (charts, stop, digest) = (self.clone(), stop.clone(), set.digest.clone());
                let task = tokio::task::spawn_blocking(move || charts.prepare(&set, &stop));
                prepared = Some((digest, task));
            }
        }
        if let Some((_, task)) = prepared {
            task.await.ok();
        }
    }

    /// Makes the overviews for small zooms, unless another set replaces this one; returns whether all are made.
    fn prepare(&self, set: &Arc<Set>, stop: &CancellationToken) -> bool {
        let go_on = || !stop.is_cancelled() && self.set().is_some_and(|now| Arc::ptr_eq(&now, set));
        let done = set.sheet().and_then(|sheet| sheet.prepare(go_on).map_err(|why| why.to_string()));
        if let Err(trouble) = &done {
            tracing::debug!(trouble, "no small zooms of the charts");
        }
        done.is_ok()
    }

    /// Whether a vessel with these limits may start an autonomous plan at this place; false without a chart.
    pub fn afloat(&self, place: LatLon, limits: &GuardLimits) -> bool {
        let demand = Demand { position_m: 0.0, ..limits.demand(limits.autonomous_m) };
        self.set().is_some_and(|set| set.index.depth_at(place, &demand).navigable)
    }

    /// The guard's verdict on a plan by a vessel's limits; `None` without a chart.
    pub fn guard(&self, plan: &Plan, from: Option<LatLon>, limits: &Limits) -> Option<api::Guard> {
        let limits = &Limits { demanded: self.strict(limits.demanded), ..*limits };
        let Now { set, trouble } = self.now();
        if let (None, Some(trouble)) = (&set, &trouble) {
            return Some(verdict::without(trouble, limits));
        }
        if let Some(missing) = self.not_closed() {
            return Some(verdict::not_closed(&missing, limits));
        }
        set.map(|set| told(&check_plan(plan, from, &set.index, &limits.demanded), limits))
    }
}

/// The package of a set for vessels; `None` if it cannot be read.
fn package(path: &Path, loaded: &LoadedIndex) -> Option<Arc<ChartPackage>> {
    let package = ChartPackage::open(path, loaded).inspect_err(|error| {
        tracing::error!(%error, "vessels get no chart: its depth index cannot be read");
    });
    package.ok().map(Arc::new)
}

/// The set on disk, with its index rebuilt unless it counts as `sound`.
fn load(path: &Path, cache_bytes: usize, sound: bool) -> chartdb::Result<(Set, LoadedIndex)> {
    let loaded = if sound { chartdb::load_index(path)? } else { chartdb::remake_index(path)? };
    if let Some(why) = &loaded.rebuilt {
        tracing::warn!("{why}; made again from the charts");
    }
    let index = Arc::new(loaded.sealed.index.clone());
    let charts = ChartDb::open(path)?.charts()?;
    let set = Set {
        digest: hex::encode(loaded.sealed.digest),
        traffic: Traffic::new(path, charts.clone()),
        charts,
        router: Router::new(Arc::clone(&index)),
        wanted: Mutex::default(),
        index,
        path: path.to_owned(),
        sheet: OnceLock::new(),
        tiles: Mutex::new(Cache::new(cache_bytes)),
    };
    Ok((set, loaded))
}

impl Set {
    /// The set in a file; so many bytes of drawn tiles are kept.
    ///
    /// # Errors
    /// There is none, or it cannot be read.
    pub fn open(path: &Path, cache_bytes: usize) -> chartdb::Result<Arc<Self>> {
        load(path, cache_bytes, true).map(|(set, _)| Arc::new(set))
    }

    /// What is to be prepared on the set after this one, the next one last: what this one still waits for, and before that what
    /// it has.
    fn water_to_prepare(&self) -> Vec<Prepared> {
        let (mut wanted, has) = (self.lock_wanted().clone(), self.router.prepared());
        wanted.retain(|one| !has.contains(one));
        wanted.extend(has.into_iter().rev());
        wanted
    }

    /// Prepares the water again that routes were asked in on the set before, what was asked for last first.
    ///
    /// # Errors
    /// When it was called off; it goes on where it ended.
    pub(crate) fn prepare_water(&self, cancel: &Cancel<'_>) -> Result<(), PlanError> {
        loop {
            let Some(next) = self.lock_wanted().last().cloned() else { return Ok(()) };
            let done = self.router.prepare(&next, cancel);
            if !matches!(done, Err(PlanError::Cancelled)) {
                // One that fails or takes too long is not tried again and again.
                self.lock_wanted().retain(|one| *one != next);
            }
            done?;
        }
    }

    fn lock_wanted(&self) -> std::sync::MutexGuard<'_, Vec<Prepared>> {
        self.wanted.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Charts that could not be drawn, and why.
    pub fn undrawn(&self) -> Vec<String> {
        self.sheet.get().map(Sheet::unreadable).unwrap_or_default()
    }

    /// The sheet that tiles are drawn from; charts are read when a tile touches them.
    ///
    /// # Errors
    /// The charts cannot be read, or have changed: then the new set is about to be loaded.
    pub fn sheet(&self) -> Result<&Sheet, String> {
        if let Some(sheet) = self.sheet.get() {
            return Ok(sheet);
        }
        let made = drawing::sheet(&self.path, &self.digest)?;
        Ok(self.sheet.get_or_init(|| made))
    }

    /// A tile, compressed by gzip.
    ///
    /// # Errors
    /// There is no such tile, or the charts cannot be read.
    pub fn tile(&self, zoom: u8, x: u32, y: u32) -> Result<bytes::Bytes, TileError> {
        let key = (zoom, x, y);
        let tiles = || self.tiles.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(tile) = tiles().get(key) {
            return Ok(tile);
        }
        let tile = self.sheet().map_err(TileError::Charts)?.tile(zoom, x, y);
        let tile = tile.map_err(|why| match why {
            NoTile::Changed(changed) => TileError::Charts(changed.to_string()),
            NoTile::Zoom(_) | NoTile::Place { .. } => TileError::None(why),
        })?;
        let mut packer = GzEncoder::new(Vec::new(), Compression::fast());
        let packed = packer.write_all(&tile).and_then(|()| packer.finish());
        let packed = bytes::Bytes::from(packed.map_err(|error| TileError::Charts(error.to_string()))?);
        tiles().put(key, packed.clone());
        Ok(packed)
    }
}

/// Why there is no tile.
#[derive(Debug)]
pub enum TileError {
    /// It does not exist.
    None(NoTile),
    /// The charts cannot be read.
    Charts(String),
}
