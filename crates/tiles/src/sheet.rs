//! The charts of a set as they are drawn, each read when a tile touches it.

use crate::about::About;
use crate::cache::PieceCache;
use crate::cut::Cover;
use crate::layer::Layer;
use crate::overview::{self, overview};
use crate::piece::{Item, Piece};
use crate::shape::{Shape, contains};
use crate::world::{Bounds, LAST_ZOOM, Point, point};
use charts::coverage::{self, Source};
use charts::s57::{AttributeCode, Feature, GeoPoint};
use std::fmt;
use std::sync::Arc;

/// A chart of a set that is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct SheetChart {
    /// What it is.
    pub source: Source,
    /// West, south, east and north of all its positions (degrees); `None` if it has none.
    pub bounds_deg: Option<[f64; 4]>,
    /// Number of its features.
    pub features: u32,
}

/// Where a sheet reads its charts from, by their numbers in the sheet.
pub trait SheetReader: fmt::Debug + Send + Sync {
    /// The features of a chart.
    ///
    /// # Errors
    /// Why they cannot be had.
    fn features(&self, chart: usize) -> Result<Vec<Feature>, Unread>;

    /// The coverage of a chart, without regard to others.
    ///
    /// # Errors
    /// Why that cannot be had.
    fn coverage(&self, chart: usize) -> Result<Vec<coverage::Polygon>, Unread>;

    /// The stored overview of a chart for a zoom, made of it and of the better ones that it meets.
    fn kept(&self, chart: usize, better: &[usize], zoom: u8) -> Option<Vec<u8>>;

    /// Keeps what was made of a chart, for zoom 0 and those that follow.
    fn keep(&self, chart: usize, better: &[usize], zooms: &[Vec<u8>]);

    /// Forgets what is kept of other charts than these, by the better ones that each of all meets.
    fn sweep(&self, better: &[Vec<usize>]);
}

/// Why a chart could not be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Unread {
    /// The set is another one by now.
    #[error("the chart set changed a moment ago; ask again")]
    Changed,
    /// It is damaged; the text says what.
    #[error("{0}")]
    Damaged(String),
}

/// The charts of a sheet changed during a query; its owner is about to take the new ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the chart set changed a moment ago; ask again")]
pub struct Changed;

/// A chart set as drawn.
#[derive(Debug)]
pub struct Sheet {
    charts: Vec<SheetChart>,
    /// Their boxes.
    boxes: Vec<Bounds>,
    /// Number of the first object of each chart.
    first_objects: Vec<u32>,
    reader: Box<dyn SheetReader>,
    cache: PieceCache,
}

impl Sheet {
    /// Of these charts, the best first by [`Source::rank`]; of what is read, so many bytes are kept at most.
    pub fn new(charts: Vec<SheetChart>, reader: Box<dyn SheetReader>, most_bytes: usize) -> Self {
        let first = |next: &mut u32, chart: &SheetChart| {
            let first = *next;
            *next = first.saturating_add(chart.features);
            Some(first)
        };
        let first_objects = charts.iter().scan(0, first).collect();
        let boxes = charts.iter().map(|chart| chart.bounds_deg.map_or(Bounds::EMPTY, bounds)).collect();
        Self { charts, boxes, first_objects, reader, cache: PieceCache::new(most_bytes) }
    }

    /// Charts that could not be read when they were needed, and why. Nothing is drawn where they lie, as where there is
    /// no data.
    pub fn unreadable(&self) -> Vec<String> {
        self.cache.unreadable()
    }

    /// Makes what small zooms are drawn of, chart by chart, where it is not kept; until `go_on` says no.
    ///
    /// # Errors
    /// When the charts are others by now.
    pub fn prepare(&self, mut go_on: impl FnMut() -> bool) -> Result<(), Changed> {
        let mut all = Vec::with_capacity(self.charts.len());
        for chart in 0..self.charts.len() {
            if !go_on() {
                return Ok(());
            }
            let better = self.better(chart);
            if self.reader.kept(chart, &better, 0).is_none() {
                self.overviews(chart)?;
            }
            all.push(better);
        }
        self.reader.sweep(&all);
        Ok(())
    }

    /// The charts whose boxes meet a box, the best first.
    pub(crate) fn meeting(&self, bounds: Bounds) -> impl Iterator<Item = usize> {
        (0..self.boxes.len()).filter(move |chart| self.boxes[*chart].meets(&bounds))
    }

    /// The better charts that may cover part of a chart.
    fn better(&self, chart: usize) -> Vec<usize> {
        self.meeting(self.boxes[chart]).take_while(|other| *other < chart).collect()
    }

    /// A chart as drawn at a zoom.
    pub(crate) fn piece(&self, chart: usize, zoom: u8) -> Result<Arc<Piece>, Changed> {
        let detail = if zoom <= LAST_ZOOM { Some(zoom) } else { None };
        if let Some(piece) = self.cache.get((chart, detail)) {
            return Ok(piece);
        }
        let piece = match detail {
            None => self.made(chart)?,
            Some(zoom) => {
                let kept = self.reader.kept(chart, &self.better(chart), zoom);
                let kept = kept.and_then(|bytes| overview::from_bytes(chart as u32, &bytes));
                match kept {
                    Some(piece) => piece,
                    None => self.overviews(chart)?.swap_remove(usize::from(zoom)),
                }
            }
        };
        let bytes = piece.bytes();
        Ok(self.cache.put((chart, detail), piece, bytes))
    }

    /// The overviews of a chart, which are kept from now on.
    fn overviews(&self, chart: usize) -> Result<Vec<Piece>, Changed> {
        let whole = self.made(chart)?;
        let all: Vec<Piece> = (0..=LAST_ZOOM).map(|zoom| overview(&whole, zoom)).collect();
        let bytes: Vec<Vec<u8>> = all.iter().map(overview::to_bytes).collect();
        if !self.cache.is_unreadable(chart) {
            self.reader.keep(chart, &self.better(chart), &bytes);
        }
        Ok(all)
    }

    /// A chart, made of its features; an empty one, with a note, where it cannot be read.
    fn made(&self, chart: usize) -> Result<Piece, Changed> {
        let better = self.better(chart);
        let mut cover = Cover::default();
        for one in &better {
            cover.join(&*self.cover(*one)?);
        }
        match self.reader.features(chart) {
            Ok(features) => Ok(Piece::new(chart as u32, features, Some(&cover))),
            Err(Unread::Changed) => Err(Changed),
            Err(Unread::Damaged(why)) => {
                self.cache.note(chart, format!("{}: {why}", self.charts[chart].source.name));
                Ok(Piece::default())
            }
        }
    }

    /// The coverage of a chart; all of its box where that cannot be read, for a coarser chart must not replace it.
    fn cover(&self, chart: usize) -> Result<Arc<Cover>, Changed> {
        if let Some(cover) = self.cache.cover(chart) {
            return Ok(cover);
        }
        let mut cover = Cover::default();
        match self.reader.coverage(chart) {
            Ok(areas) => cover.add(&areas),
            Err(Unread::Changed) => return Err(Changed),
            Err(Unread::Damaged(why)) => {
                self.cache.note(chart, format!("{}: {why}", self.charts[chart].source.name));
                if !self.charts[chart].source.supplement {
                    cover.add_box(self.boxes[chart]);
                }
            }
        }
        Ok(self.cache.put_cover(chart, cover))
    }

    /// The number that an object of a chart has in tiles.
    pub(crate) fn number(&self, chart: usize, object: u32) -> u32 {
        self.first_objects[chart].saturating_add(object)
    }

    /// The data of an object.
    ///
    /// # Errors
    /// When the charts are others by now.
    pub fn about(&self, object: u32) -> Result<Option<About>, Changed> {
        let Some(chart) = self.first_objects.partition_point(|first| *first <= object).checked_sub(1) else {
            return Ok(None);
        };
        let piece = self.piece(chart, u8::MAX)?;
        Ok(piece.about(object - self.first_objects[chart]).cloned())
    }

    /// The chart of an object.
    pub fn source(&self, about: &About) -> &Source {
        &self.charts[about.source as usize].source
    }

    /// The number of a chart's record.
    ///
    /// # Errors
    /// When the charts are others by now.
    pub fn object_of(&self, chart: &str, record: u32) -> Result<Option<u32>, Changed> {
        let Some(chart) = self.charts.iter().position(|one| one.source.name == chart) else {
            return Ok(None);
        };
        let object = self.piece(chart, u8::MAX)?.of_record(record);
        Ok(object.map(|object| self.number(chart, object)))
    }

    /// The charts that are drawn in a box at a zoom.
    pub(crate) fn scene(&self, bounds: Bounds, zoom: u8) -> Result<Scene<'_>, Changed> {
        let pieces = self.meeting(bounds).map(|chart| Ok((chart, self.piece(chart, zoom)?)));
        Ok(Scene { sheet: self, pieces: pieces.collect::<Result<_, _>>()? })
    }
}

/// The box of a chart, widened by a unit: positions are rounded.
fn bounds([west, south, east, north]: [f64; 4]) -> Bounds {
    let corner = |lon_deg: f64, lat_deg: f64| point(GeoPoint { lon_deg, lat_deg });
    let (low, high) = (corner(west, north), corner(east, south));
    Bounds { min: Point::new(low.x - 1, low.y - 1), max: Point::new(high.x + 1, high.y + 1) }
}

/// The charts that one tile or one question touches.
pub(crate) struct Scene<'a> {
    pub(crate) sheet: &'a Sheet,
    pieces: Vec<(usize, Arc<Piece>)>,
}

/// An item with what is known of its object.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Placed<'a> {
    pub(crate) item: &'a Item,
    /// Number in the sheet.
    pub(crate) object: u32,
    pub(crate) about: Option<&'a About>,
}

impl Scene<'_> {
    /// The items of a layer that meet a box, by where they are and then by their objects.
    pub(crate) fn within(&self, layer: Option<Layer>, bounds: Bounds) -> Vec<Placed<'_>> {
        let mut found: Vec<(u64, Placed<'_>)> = Vec::new();
        for (chart, piece) in &self.pieces {
            for item in piece.within(layer, bounds) {
                let (object, about) = (self.sheet.number(*chart, item.object), piece.about(item.object));
                found.push((item.place(), Placed { item, object, about }));
            }
        }
        found.sort_by_key(|(place, _)| *place);
        found.into_iter().map(|(_, placed)| placed).collect()
    }

    /// Least depth of the charted area in which a danger lies (m); `None` on land and in waters of unknown depth.
    pub(crate) fn around_m(&self, danger: &Item) -> Result<Option<f64>, Changed> {
        let at = danger.shape.inner();
        let here = Bounds { min: at, max: at };
        let mut least_m: Option<f64> = None;
        for chart in self.sheet.meeting(here) {
            let loaded =
                self.pieces.iter().find(|(one, _)| *one == chart).map(|(_, piece)| Arc::clone(piece));
            let piece = loaded.map_or_else(|| self.sheet.piece(chart, u8::MAX), Ok)?;
            for water in piece.within(Some(Layer::Water), here) {
                let Shape::Areas(areas) = &water.shape else { continue };
                if areas.iter().any(|area| contains(area, at)) {
                    let depth_m = piece.about(water.object).and_then(|one| one.number(AttributeCode::DRVAL1));
                    let depth_m = depth_m.unwrap_or(f64::NEG_INFINITY);
                    least_m = Some(least_m.map_or(depth_m, |least_m| least_m.min(depth_m)));
                }
            }
        }
        Ok(least_m.filter(|least_m| least_m.is_finite()))
    }
}
