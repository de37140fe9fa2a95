//! Tags that were heard: what the history's rows tell, understood by the crate `detections`.

use super::events::{EventRow, Question};
use super::{Cell, Order, Page, Paged, Reader, Row};
use crate::error::Result;
use crate::history::{Extent, GroupKey, MonthKey};
use crate::range::TimeRange;
use detections::{Detection, Listening, Origin, TagFilter};
use imc::messages::{Event, Payload as _, TBRFishTag, TBRFishTagTransProtocol};
use imc::{Address, Text};
use std::collections::BTreeSet;
use units::UtcTime;

const EVENT_FIELDS: [&str; 2] = ["topic", "data"];
const TAG_FIELDS: [&str; 11] = [
    "serial_no",
    "unix_timestamp",
    "millis",
    "trans_protocol",
    "trans_id",
    "trans_data",
    "SNR",
    "trans_freq",
    "recv_mem_addr",
    "lat",
    "lon",
];

impl Reader {
    /// A page of the tags heard in a range, by when they were reported; of one system or of all. With `came_from` those
    /// alone that came ashore then or later.
    ///
    /// # Errors
    /// When the history cannot be read.
    pub fn detections(
        &mut self,
        system: Option<Address>,
        range: TimeRange,
        came_from: Option<UtcTime>,
        order: Order,
        page: Page,
    ) -> Result<Paged<Detection>> {
        let systems = system.map(|system| vec![system]);
        let wanted = DetectionsWanted { systems, range, came_from, tags: Vec::new() };
        self.detections_of(&wanted, order, page)
    }

    /// A page of the detections that are wanted, by when they were reported.
    ///
    /// # Errors
    /// When the history cannot be read.
    pub fn detections_of(
        &mut self,
        wanted: &DetectionsWanted,
        order: Order,
        page: Page,
    ) -> Result<Paged<Detection>> {
        self.detections_where(wanted, order, page, |_| true)
    }

    /// Of those, the ones that `is_wanted` says yes to.
    ///
    /// # Errors
    /// When the history cannot be read.
    pub fn detections_where(
        &mut self,
        wanted: &DetectionsWanted,
        order: Order,
        page: Page,
        is_wanted: impl Fn(&Detection) -> bool,
    ) -> Result<Paged<Detection>> {
        let DetectionsWanted { systems, range, came_from, tags } = wanted;
        let question = Question { systems: systems.as_deref(), range: *range, order };
        self.events(&question, page, |one: &Detection| {
            came_from.is_none_or(|from| one.origin.received >= Some(from))
                && (tags.is_empty() || tags.iter().any(|tag| tag.admits(one)))
                && is_wanted(one)
        })
    }

    /// From when to when vessels told something that may be of detections, in the files of a range; `None` where they told nothing.
    /// Within it there may be long times without any.
    ///
    /// # Errors
    /// When the history cannot be read.
    pub fn acoustic_extent(
        &mut self,
        systems: &BTreeSet<u16>,
        range: TimeRange,
    ) -> Result<Option<TimeRange>> {
        let mut ids = Vec::new();
        for (message, _) in Acoustic::MESSAGES {
            ids.push(self.table(message)?.desc.id);
        }
        let files: Vec<MonthKey> = self.parts(range)?.into_iter().map(|(key, _)| key).collect();
        let all = self.months_extents(|key| files.contains(&key))?;
        let mine =
            all.into_iter().filter(|(group, _)| ids.contains(&group.id) && systems.contains(&group.src));
        let told = mine.map(|(_, extent)| extent).filter(|extent| extent.count > 0).fold(
            None,
            |told: Option<TimeRange>, Extent { first_us, last_us, .. }| {
                let (from_us, to_us) = (first_us, last_us.saturating_add(1));
                Some(told.map_or(TimeRange { from_us, to_us }, |told| TimeRange {
                    from_us: told.from_us.min(from_us),
                    to_us: told.to_us.max(to_us),
                }))
            },
        );
        Ok(told)
    }

    /// A page of what receivers of vessels told in a range, the newest first: tags that were heard, and how they listened.
    ///
    /// # Errors
    /// When the history cannot be read.
    pub fn acoustics(
        &mut self,
        systems: &[Address],
        range: TimeRange,
        page: Page,
    ) -> Result<Paged<Acoustic>> {
        let question = Question { systems: Some(systems), range, order: Order::Newest };
        self.events(&question, page, |_: &Acoustic| true)
    }
}

/// What a receiver told.
#[derive(Debug, Clone, PartialEq)]
pub enum Acoustic {
    /// A tag that it heard.
    Heard(Detection),
    /// How it listened from then on.
    Listening(Origin, Listening),
}

/// Which detections.
#[derive(Debug, Clone, PartialEq)]
pub struct DetectionsWanted {
    /// Vessels; all where absent, none where empty.
    pub systems: Option<Vec<Address>>,
    /// By when they were reported.
    pub range: TimeRange,
    /// Those alone that came ashore then or later.
    pub came_from: Option<UtcTime>,
    /// Tags; all where empty.
    pub tags: Vec<TagFilter>,
}

impl EventRow for Detection {
    const MESSAGES: &'static [(&'static str, &'static [&'static str])] =
        &[("Event", &EVENT_FIELDS), ("TBRFishTag", &TAG_FIELDS)];
    // Two in truth; more where a clock stood still.
    const TOGETHER: usize = 1_000;

    fn read(group: GroupKey, row: Row) -> Option<Self> {
        let origin = origin(group, &row);
        if group.id == TBRFishTag::ID {
            return Some(Self::from_fish_tag(origin, &fish_tag(&row.cells)?));
        }
        Self::from_report(origin, &event(row)?)
    }

    fn fused(moment: Vec<Self>) -> Vec<Self> {
        detections::fused(moment)
    }

    fn bytes(&self) -> usize {
        self.raw.as_ref().map_or(0, String::len) + self.protocol.name().map_or(0, str::len)
    }
}

impl EventRow for Acoustic {
    const MESSAGES: &'static [(&'static str, &'static [&'static str])] = Detection::MESSAGES;
    const TOGETHER: usize = Detection::TOGETHER;

    fn read(group: GroupKey, row: Row) -> Option<Self> {
        if group.id == TBRFishTag::ID {
            return Detection::read(group, row).map(Self::Heard);
        }
        let origin = origin(group, &row);
        let event = event(row)?;
        match Detection::from_report(origin, &event) {
            Some(one) => Some(Self::Heard(one)),
            None => Some(Self::Listening(origin, Listening::from_report(&event)?)),
        }
    }

    fn fused(moment: Vec<Self>) -> Vec<Self> {
        let (mut heard, mut listened) = (Vec::new(), Vec::new());
        for one in moment {
            match one {
                Self::Heard(one) => heard.push(one),
                Self::Listening(origin, told) => listened.push(Self::Listening(origin, told)),
            }
        }
        listened.extend(detections::fused(heard).into_iter().map(Self::Heard));
        listened
    }

    fn bytes(&self) -> usize {
        match self {
            Self::Heard(one) => one.bytes(),
            Self::Listening(..) => 0,
        }
    }
}

/// Who told it, and when.
fn origin(group: GroupKey, row: &Row) -> Origin {
    Origin {
        system: Address(group.src),
        entity: group.src_ent,
        reported: row.time,
        received: Some(row.received),
    }
}

/// The Event that a row was made of.
fn event(row: Row) -> Option<Event> {
    let mut cells = row.cells.into_iter().map(text);
    Some(Event { topic: cells.next()??, data: cells.next()?? })
}

/// The message that a row was made of; `None` when it was cut short before the position.
fn fish_tag(cells: &[Cell]) -> Option<TBRFishTag> {
    fn integer<T: TryFrom<i64>>(cells: &[Cell], at: usize) -> Option<T> {
        match cells.get(at)? {
            Cell::Integer(value) => T::try_from(*value).ok(),
            _ => None,
        }
    }
    Some(TBRFishTag {
        serial_no: integer(cells, 0)?,
        unix_timestamp: integer(cells, 1)?,
        millis: integer(cells, 2)?,
        trans_protocol: TBRFishTagTransProtocol::from(integer::<u8>(cells, 3)?),
        trans_id: integer(cells, 4)?,
        trans_data: integer(cells, 5)?,
        snr: integer(cells, 6)?,
        trans_freq: integer(cells, 7)?,
        recv_mem_addr: integer(cells, 8)?,
        lat: cells.get(9).and_then(Cell::as_f64),
        lon: cells.get(10).and_then(Cell::as_f64),
    })
}

fn text(cell: Cell) -> Option<Text> {
    match cell {
        Cell::Text(text) => Some(text.into()),
        Cell::Raw(bytes) => Some(Text::from_bytes(bytes)),
        Cell::Nothing | Cell::Integer(_) | Cell::Real(_) => None,
    }
}
