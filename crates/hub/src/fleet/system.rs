//! One system: its name, its entities and the last packet of each of its series.

use crate::Transport;
use bytes::Bytes;
use imc::catalogue::FieldKind;
use imc::messages::{Announce, EntityInfo, EntityList, EntityListOp, Payload as _, SystemType};
use imc::{Address, PacketView};
use std::collections::BTreeMap;
use std::time::Duration;
use units::{MonoTime, Now, UtcTime};

/// Series that are kept of a system; a new one beyond that is not kept (its packets are still recorded and
/// relayed). The largest real vehicle has about 400.
const SERIES_KEPT: usize = 8_192;
/// Bytes that the last packets of a system may have together.
const BYTES_KEPT: usize = 4 << 20;
/// The memory of a series beside its packet.
const SERIES_BYTES: usize = size_of::<SeriesKey>() + size_of::<Series>() + 64;
/// Letters of a name or label that are kept.
const NAME_CHARS: usize = 100;
/// A value is replaced by an older one when it has been kept for this long: the sender's clock was set back.
const CLOCK_SET_BACK_AFTER: Duration = Duration::from_secs(10);
/// How much a new interval counts in the mean period.
const PERIOD_GAIN: f32 = 0.1;

/// How sure it is that a system is there, by the time since something came from it. Systems say something every
/// second at least (their Heartbeat).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Liveness {
    /// Heard within two seconds.
    Live,
    /// Nothing for two to five seconds.
    Late,
    /// Nothing for five to ten seconds.
    Stale,
    /// Nothing for more than ten seconds.
    Lost,
}

impl Liveness {
    /// By the time since something came.
    pub fn after(silence: Duration) -> Self {
        match silence.as_millis() {
            0..=2_000 => Self::Live,
            2_001..=5_000 => Self::Late,
            5_001..=10_000 => Self::Stale,
            _ => Self::Lost,
        }
    }

    /// The word for people and machines.
    pub fn name(self) -> &'static str {
        match self {
            Self::Live => "live",
            Self::Late => "late",
            Self::Stale => "stale",
            Self::Lost => "lost",
        }
    }
}

/// The key of a series within a system.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SeriesKey {
    /// Message id.
    pub id: u16,
    /// Source entity.
    pub entity: u8,
    /// The message's own `id` field, where its first field is an 8-bit one of that name.
    pub instance: Option<u8>,
}

impl SeriesKey {
    /// The series of a packet.
    pub fn of(view: &PacketView<'_>) -> Self {
        let numbered = view
            .desc()
            .and_then(|desc| desc.fields.first())
            .is_some_and(|field| field.abbrev == "id" && field.kind == FieldKind::U8);
        let instance = view.payload().first().copied().filter(|_| numbered);
        Self { id: view.id(), entity: view.src_ent(), instance }
    }
}

/// The last packet of a series.
#[derive(Debug, Clone)]
pub struct Series {
    packet: Bytes,
    timestamp: f64,
    received: UtcTime,
    heard: MonoTime,
    revision: u64,
    count: u64,
    period_s: Option<f32>,
}

impl Series {
    /// The packet as it came.
    pub fn packet(&self) -> &[u8] {
        &self.packet
    }

    /// When it came.
    pub fn received(&self) -> UtcTime {
        self.received
    }

    /// How long ago it came.
    pub fn age(&self, now: MonoTime) -> Duration {
        now.since(self.heard)
    }

    /// Packets of the series so far.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The mean time between packets, seconds by the sender's clock; `None` after a single one.
    pub fn period_s(&self) -> Option<f32> {
        self.period_s
    }

    /// The age from which the value counts as old: three periods, at least two seconds.
    pub fn fresh_for(&self) -> Duration {
        Duration::from_secs_f32((3.0 * self.period_s.unwrap_or(1.0)).clamp(2.0, 3_600.0))
    }
}

/// One system.
#[derive(Debug)]
pub struct System {
    address: Address,
    name: Option<String>,
    kind: Option<SystemType>,
    services: String,
    transports: BTreeMap<Transport, MonoTime>,
    first_heard: UtcTime,
    last_heard: MonoTime,
    last_heard_utc: UtcTime,
    entities: BTreeMap<u8, String>,
    /// When it was first known that it had started again.
    restarted: Option<MonoTime>,
    series: BTreeMap<SeriesKey, Series>,
    bytes: usize,
    not_kept: u64,
}

impl System {
    pub(crate) fn new(address: Address, now: Now) -> Self {
        Self {
            address,
            name: None,
            kind: None,
            services: String::new(),
            transports: BTreeMap::new(),
            first_heard: now.utc,
            last_heard: now.mono,
            last_heard_utc: now.utc,
            entities: BTreeMap::new(),
            restarted: None,
            series: BTreeMap::new(),
            bytes: 0,
            not_kept: 0,
        }
    }

    /// Its IMC address.
    pub fn address(&self) -> Address {
        self.address
    }

    /// The name that it announced.
    pub fn name(&self) -> Option<&str> {
        self.name.as_deref()
    }

    /// What to call it: its name, a registered name, or its address.
    pub fn title(&self) -> String {
        self.name.clone().unwrap_or_else(|| self.address.to_string())
    }

    /// The kind of system that it announced.
    pub fn kind(&self) -> Option<SystemType> {
        self.kind
    }

    /// The services that it announced.
    pub fn services(&self) -> &str {
        &self.services
    }

    /// The transports by which it was heard, and when last.
    pub fn transports(&self) -> impl Iterator<Item = (Transport, MonoTime)> {
        self.transports.iter().map(|(transport, heard)| (*transport, *heard))
    }

    /// When it was first heard since the server started.
    pub fn first_heard(&self) -> UtcTime {
        self.first_heard
    }

    /// When it was last heard.
    pub fn last_heard(&self) -> MonoTime {
        self.last_heard
    }

    /// When it was last heard, by the shore's UTC.
    pub fn last_heard_utc(&self) -> UtcTime {
        self.last_heard_utc
    }

    /// Whether it is there.
    pub fn liveness(&self, now: MonoTime) -> Liveness {
        Liveness::after(now.since(self.last_heard))
    }

    /// Labels of its entities by number.
    pub fn entities(&self) -> &BTreeMap<u8, String> {
        &self.entities
    }

    /// The label of an entity.
    pub fn entity(&self, number: u8) -> Option<&str> {
        self.entities.get(&number).map(String::as_str)
    }

    /// Whether the last packet of a series is of the system's present life: what its entities are may be another since it started
    /// again.
    pub fn is_of_this_life(&self, series: &Series) -> bool {
        self.restarted.is_none_or(|at| series.heard >= at)
    }

    /// One series.
    pub fn series(&self, key: SeriesKey) -> Option<&Series> {
        self.series.get(&key)
    }

    /// All series, by message, entity and instance.
    pub fn all_series(&self) -> impl Iterator<Item = (SeriesKey, &Series)> {
        self.series.iter().map(|(key, series)| (*key, series))
    }

    /// The series of a message, the one that came last first.
    pub fn latest(&self, id: u16) -> Option<(SeriesKey, &Series)> {
        let of = self.series.iter().filter(|(key, _)| key.id == id);
        of.max_by_key(|(_, series)| series.revision).map(|(key, series)| (*key, series))
    }

    /// Packets whose series had no room.
    pub fn not_kept(&self) -> u64 {
        self.not_kept
    }

    /// The size of its series, bytes.
    pub(crate) fn size(&self) -> usize {
        self.bytes + self.series.len() * SERIES_BYTES
    }

    /// A packet came from the system.
    pub(crate) fn heard(&mut self, now: Now, view: &PacketView<'_>, transport: Transport) {
        self.last_heard = now.mono;
        self.last_heard_utc = now.utc;
        self.transports.insert(transport, now.mono);
        match view.id() {
            Announce::ID => {
                let Ok(Some(announce)) = imc::decode::<Announce>(view) else { return };
                let services = announce.services.to_str_lossy();
                if uid(&services) != uid(&self.services) && uid(&services).is_some() {
                    // It started again: numbers of entities are assigned at start.
                    self.entities.clear();
                    self.restarted = uid(&self.services).map(|_| now.mono).or(self.restarted);
                }
                self.services = services.chars().take(4_096).collect();
                self.name = Some(shortened(&announce.sys_name.to_str_lossy()));
                self.kind = Some(announce.sys_type);
            }
            EntityList::ID => {
                let Ok(Some(list)) = imc::decode::<EntityList>(view) else { return };
                if list.op == EntityListOp::Report {
                    let text = list.list.to_str_lossy();
                    let labels = imc::entities::parse(&text);
                    self.entities = labels.map(|(label, id)| (id, shortened(label))).collect();
                }
            }
            EntityInfo::ID => {
                let Ok(Some(info)) = imc::decode::<EntityInfo>(view) else { return };
                self.entities.insert(info.id, shortened(&info.label.to_str_lossy()));
            }
            _ => {}
        }
    }

    /// Takes a packet into its series. `None` when it is older than what is known or has no room, else the
    /// revision that the series had before.
    #[expect(
        clippy::option_option,
        reason = "no change, a change of something new, a change of something old"
    )]
    pub(crate) fn take(
        &mut self,
        now: Now,
        key: SeriesKey,
        packet: &Bytes,
        timestamp: f64,
        revision: u64,
    ) -> Option<Option<u64>> {
        if let Some(series) = self.series.get_mut(&key) {
            series.count += 1;
            let after = timestamp - series.timestamp;
            // A time that is not a number is neither before nor after, and must not freeze the series.
            if after < 0.0 && now.mono.since(series.heard) < CLOCK_SET_BACK_AFTER {
                return None;
            }
            if self.bytes - series.packet.len() + packet.len() > BYTES_KEPT {
                self.not_kept += 1;
                return None;
            }
            self.bytes = self.bytes - series.packet.len() + packet.len();
            if after > 0.0 && after < 3_600.0 {
                let mean = series.period_s.unwrap_or(after as f32);
                series.period_s = Some(mean + PERIOD_GAIN * (after as f32 - mean));
            }
            series.packet = packet.clone();
            series.timestamp = timestamp;
            series.received = now.utc;
            series.heard = now.mono;
            return Some(Some(std::mem::replace(&mut series.revision, revision)));
        }
        if self.series.len() >= SERIES_KEPT || self.bytes + packet.len() > BYTES_KEPT {
            self.not_kept += 1;
            return None;
        }
        self.bytes += packet.len();
        let packet = packet.clone();
        let (received, heard) = (now.utc, now.mono);
        let series = Series { packet, timestamp, received, heard, revision, count: 1, period_s: None };
        self.series.insert(key, series);
        Some(None)
    }
}

fn shortened(name: &str) -> String {
    name.chars().take(NAME_CHARS).collect()
}

/// The number that a node gives itself at each start.
fn uid(services: &str) -> Option<&str> {
    services.split(';').find_map(|uri| uri.split_once("/uid/")).map(|(_, uid)| uid.trim_end_matches('/'))
}
