//! The sea chart as the server holds it: the set that lies on the disk, in memory, and what is asked of it.
//!
//! [`Charts`] looks every two seconds whether the file is another one, as after `lutra-server chart import`, and
//! takes the new set as a whole; whoever asks meanwhile gets answers of the old one. No file means no chart; a file
//! that cannot be read is a trouble, and the guard refuses plans until it is gone.

mod aboard;
mod answer;
mod areas;
mod cache;
mod drawing;
mod package;
mod settings;
pub(crate) mod verdict;

pub use aboard::ChartsAboard;
pub use answer::{at, corridor, described, way_m};
pub use areas::NoGo;
pub use package::ChartPackage;
pub use settings::Settings;
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
use planner::Router;
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

/// How often the file is looked at.
const LOOK_EVERY: Duration = Duration::from_secs(2);

/// The sea chart; cheap to clone.
#[derive(Clone)]
pub struct Charts(Arc<Shared>);

struct Shared {
    path: PathBuf,
    limits: GuardLimits,
    cache_bytes: usize,
    now: RwLock<Now>,
    /// What `now` was made of; held while a new one is read.
    seen: Mutex<Seen>,
    /// What people have closed.
    areas: Areas,
    /// What vessels are offered.
    offered: watch::Sender<Option<Arc<ChartPackage>>>,
}

/// What there is.
#[derive(Clone, Default)]
struct Now {
    set: Option<Arc<Set>>,
    trouble: Option<String>,
}

/// What tells one state of a file from another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Stamp {
    inode: u64,
    bytes: u64,
    modified: Option<SystemTime>,
}

/// What was looked at last.
#[derive(Debug, Default)]
struct Seen {
    /// The state of the file.
    stamp: Option<Stamp>,
    /// Whether vessels do not get that set, as it lacks something that is closed.
    withheld: bool,
    /// What vessels are to be offered.
    to_offer: ToOffer,
}

/// What the next look offers vessels.
#[derive(Debug, Default)]
enum ToOffer {
    /// What they are offered stays.
    #[default]
    Same,
    /// There is no chart any more.
    None,
    /// That of a set, once it was read to its end.
    Of(Box<LoadedIndex>),
}

impl Stamp {
    fn of(path: &Path) -> Option<Self> {
        let about = fs::metadata(path).ok()?;
        Some(Self { inode: about.ino(), bytes: about.len(), modified: about.modified().ok() })
    }
}

/// A chart set in memory.
pub struct Set {
    /// What names its contents, in hexadecimal digits.
    pub digest: String,
    /// The charts by name.
    pub charts: Vec<Chart>,
    /// How deep it is.
    pub index: Arc<DepthIndex>,
    /// Plans routes on it.
    pub router: Router,
    path: PathBuf,
    sheet: OnceLock<Sheet>,
    tiles: Mutex<Cache>,
}

impl Charts {
    /// Nothing yet; [`Self::look`] takes what is there.
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
        }))
    }

    /// What is demanded of the water where no vessel told its own limits.
    pub fn limits(&self) -> &GuardLimits {
        &self.0.limits
    }

    /// The set, if there is one.
    pub fn set(&self) -> Option<Arc<Set>> {
        self.now().set
    }

    /// What vessels are offered, as it changes.
    pub fn offered(&self) -> watch::Receiver<Option<Arc<ChartPackage>>> {
        self.0.offered.subscribe()
    }

    /// Why there is none although there is a file.
    pub fn trouble(&self) -> Option<String> {
        self.now().trouble
    }

    fn now(&self) -> Now {
        self.0.now.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Has the set hold these no-go areas from the next look on.
    pub(crate) fn close(&self, areas: NoGo) {
        self.0.areas.want(areas);
    }

    /// Why the set in force does not hold the no-go areas that people closed; `None` where it does.
    pub fn not_closed(&self) -> Option<String> {
        self.does_not_hold(None)
    }

    /// The same of these areas, or of those that were told last.
    pub(crate) fn does_not_hold(&self, areas: Option<&NoGo>) -> Option<String> {
        let now = self.now();
        self.0.areas.missing(now.set.as_ref().map(|set| set.charts.as_slice()), areas, now.trouble)
    }

    /// Limits by which no vessel enters an area that people closed: they are prohibited areas of the chart, of which a rule
    /// may think less.
    pub fn strict(&self, limits: GuardLimits) -> GuardLimits {
        if !self.0.areas.are_some() {
            return limits;
        }
        let floor = EntryRules { prohibited: EntryRule::Refuse, ..EntryRules::IGNORE };
        GuardLimits { entry: limits.entry.at_least(floor), ..limits }
    }

    /// Takes the set on the disk, if it is another one than before, or if parts of it turned out to be damaged. The set
    /// is in force at once; what vessels are offered follows when the file was read once to its end.
    pub fn look(&self) {
        self.take();
        self.offer();
    }

    /// Takes the set on the disk, and leaves what vessels are offered to the next look: a server that starts answers
    /// before the file, which may be of gigabytes, was read.
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
        let mut fresh = None;
        let now = match (stamp, load(&self.0.path, self.0.cache_bytes, damage.is_empty())) {
            (None, _) => Now::default(),
            (_, Ok((set, loaded))) => match before.set {
                Some(old) if old.digest == set.digest && damage.is_empty() && !released => {
                    Now { set: Some(old), trouble: None }
                }
                _ => {
                    fresh = Some(loaded);
                    tracing::info!(
                        charts = set.charts.len(),
                        digest = set.digest,
                        "the chart set is in force"
                    );
                    Now { set: Some(Arc::new(set)), trouble: None }
                }
            },
            // An import is about to be done: the set of before holds, and it is looked again.
            (_, Err(error)) if error.is_busy() => {
                tracing::debug!(%error, "the chart set is looked at again");
                return;
            }
            (_, Err(error)) => {
                tracing::error!(%error, "the chart set cannot be used");
                Now { set: None, trouble: Some(error.to_string()) }
            }
        };
        // Vessels keep the chart that they have rather than one that lacks what people closed.
        let withheld = now.set.as_ref().is_some_and(|set| self.0.areas.are_lacking(&set.charts));
        let kept = now.set.is_some() && fresh.is_none() || withheld;
        *self.0.now.write().unwrap_or_else(PoisonError::into_inner) = now;
        let newest = fresh.map_or(ToOffer::None, |loaded| ToOffer::Of(Box::new(loaded)));
        let to_offer = if kept { std::mem::take(&mut seen.to_offer) } else { newest };
        *seen = Seen { stamp, withheld, to_offer };
    }

    /// Offers vessels what was taken last, if they are not offered it yet.
    fn offer(&self) {
        let mut seen = self.0.seen.lock().unwrap_or_else(PoisonError::into_inner);
        let package = match std::mem::take(&mut seen.to_offer) {
            ToOffer::Same => return,
            ToOffer::None => None,
            ToOffer::Of(loaded) => package(&self.0.path, &loaded),
        };
        self.0.offered.send_if_modified(|offered| {
            let digest =
                |package: &Option<Arc<ChartPackage>>| package.as_ref().map(|package| package.digest());
            let differs = digest(offered) != digest(&package);
            *offered = package;
            differs
        });
    }

    /// Looks every two seconds until the server ends. What small zooms of a new set are drawn of is made beside that.
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

    /// Makes what small zooms of a set are drawn of, unless another set takes its place; whether all is made.
    fn prepare(&self, set: &Arc<Set>, stop: &CancellationToken) -> bool {
        let go_on = || !stop.is_cancelled() && self.set().is_some_and(|now| Arc::ptr_eq(&now, set));
        let done = set.sheet().and_then(|sheet| sheet.prepare(go_on).map_err(|why| why.to_string()));
        if let Err(trouble) = &done {
            tracing::debug!(trouble, "no small zooms of the charts");
        }
        done.is_ok()
    }

    /// Whether a vessel with these limits may set out from there by itself; not where there is no chart.
    pub fn afloat(&self, place: LatLon, limits: &GuardLimits) -> bool {
        let demand = Demand { position_m: 0.0, ..limits.demand(limits.autonomous_m) };
        self.set().is_some_and(|set| set.index.depth_at(place, &demand).navigable)
    }

    /// What the guard says of a plan by a vessel's limits; `None` where there is no chart.
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

/// What vessels get of a set; nothing where that cannot be read.
fn package(path: &Path, loaded: &LoadedIndex) -> Option<Arc<ChartPackage>> {
    let package = ChartPackage::open(path, loaded).inspect_err(|error| {
        tracing::error!(%error, "vessels get no chart: its depth index cannot be read");
    });
    package.ok().map(Arc::new)
}

/// The set on the disk, with its index rebuilt unless that is thought to be `sound`.
fn load(path: &Path, cache_bytes: usize, sound: bool) -> chartdb::Result<(Set, LoadedIndex)> {
    let loaded = if sound { chartdb::load_index(path)? } else { chartdb::remake_index(path)? };
    if let Some(why) = &loaded.rebuilt {
        tracing::warn!("{why}; made again from the charts");
    }
    let index = Arc::new(loaded.sealed.index.clone());
    let set = Set {
        digest: hex::encode(loaded.sealed.digest),
        charts: ChartDb::open(path)?.charts()?,
        router: Router::new(Arc::clone(&index)),
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

    /// Charts that could not be drawn, and why.
    pub fn undrawn(&self) -> Vec<String> {
        self.sheet.get().map(Sheet::unreadable).unwrap_or_default()
    }

    /// What is drawn; charts are read when a tile touches them.
    ///
    /// # Errors
    /// The charts cannot be read, or are others by now: then the new set is about to be taken.
    pub fn sheet(&self) -> Result<&Sheet, String> {
        if let Some(sheet) = self.sheet.get() {
            return Ok(sheet);
        }
        let made = drawing::sheet(&self.path, &self.digest)?;
        Ok(self.sheet.get_or_init(|| made))
    }

    /// A tile, packed by gzip.
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
