//! Makes the bytes of an index chart by chart, so that memory does not grow with their number, and takes over from the
//! index before what no change can have touched.
//!
//! A chart whose mark is the one that it had keeps its own part; one that meets no chart that came, changed or went
//! ([`seams::meet`]) keeps its seams as well, byte for byte. So the bytes are the same as if all were rebuilt.
//!
//! [`assemble_after`] leaves the index before where it is, and gives only what differs with a new directory: a small
//! change of a large set writes little.

use super::build::{BuildError, IndexBuilder};
use super::codec::{self, Span};
use super::index::{DepthIndex, Entry};
use super::piece::Piece;
use super::seams::{self, Around};
use crate::coverage::Source;
use crate::grid::{Bounds, PER_DEGREE};
use crate::s57::Feature;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Of neighbours that are kept in memory while seams are made.
const MOST_BYTES: usize = 160 << 20;

/// A chart of an index that is to be made.
#[derive(Debug, Clone, PartialEq)]
pub struct ChartToIndex {
    /// What it is.
    pub source: Source,
    /// Names its contents: another one wherever they differ.
    pub mark: [u8; 32],
    /// West, south, east and north of all its positions (degrees); `None` if it has none.
    pub bounds_deg: Option<[f64; 4]>,
}

impl ChartToIndex {
    fn bounds(&self) -> Bounds {
        let Some([west, south, east, north]) = self.bounds_deg else { return Bounds::EMPTY };
        // Rounded to the grid positions may lie beyond by one. Casts saturate, and what is off the globe is refused.
        let low = |deg: f64| ((deg * PER_DEGREE).floor() - 1.0) as i32;
        let high = |deg: f64| ((deg * PER_DEGREE).ceil() + 1.0) as i32;
        Bounds { min: [low(west), low(south)], max: [high(east), high(north)] }
    }
}

/// Gives the bytes of the index of these charts, part after part. `features` reads a chart; some are read twice.
///
/// # Errors
/// Those of `features` and `put`, and when a chart makes no index.
pub fn assemble<E: From<BuildError>>(
    charts: Vec<ChartToIndex>,
    before: Option<&DepthIndex>,
    features: impl Fn(&Source) -> Result<Vec<Feature>, E>,
    mut put: impl FnMut(&[u8]) -> Result<(), E>,
) -> Result<(), E> {
    let head = codec::head();
    put(&head)?;
    join(charts, before, (head.len() as u64, 0), features, put).map(|_| ())
}

/// Gives the bytes that make an index of these charts where they follow the first `base_bytes` of the index before. Of
/// those the pieces stay in use that no change touched. Returns the bytes of pieces that are in use, old and new.
///
/// # Errors
/// As those of [`assemble`].
pub fn assemble_after<E: From<BuildError>>(
    charts: Vec<ChartToIndex>,
    before: &DepthIndex,
    base_bytes: u64,
    features: impl Fn(&Source) -> Result<Vec<Feature>, E>,
    put: impl FnMut(&[u8]) -> Result<(), E>,
) -> Result<u64, E> {
    join(charts, Some(before), (base_bytes, base_bytes), features, put)
}

/// The pieces and the directory, from an offset on; pieces that lie before `base_bytes` stay there. Returns the bytes of
/// all pieces.
fn join<E: From<BuildError>>(
    mut charts: Vec<ChartToIndex>,
    before: Option<&DepthIndex>,
    (mut offset, base_bytes): (u64, u64),
    features: impl Fn(&Source) -> Result<Vec<Feature>, E>,
    mut put: impl FnMut(&[u8]) -> Result<(), E>,
) -> Result<u64, E> {
    charts.sort_by_cached_key(|chart| chart.source.rank());
    let boxes: Vec<Bounds> = charts.iter().map(ChartToIndex::bounds).collect();
    let kept = Kept::of(&charts, &boxes, before);
    let load = |at: usize| -> Result<Arc<Piece>, E> {
        if let Some(piece) = kept.own(at) {
            return Ok(Arc::new(piece));
        }
        let source = &charts[at].source;
        let mut builder = IndexBuilder::new();
        builder.add_features(source.clone(), &features(source)?)?;
        let piece = builder.own_part()?;
        if !boxes[at].contains(&piece.bounds()) {
            return Err(BuildError::Bounds(source.name.clone()).into());
        }
        Ok(Arc::new(piece))
    };
    let around = Around::new(boxes.clone(), MOST_BYTES, load);
    let mut made: BTreeMap<usize, (Entry, Span)> = BTreeMap::new();
    for at in codec::file_order(&boxes) {
        if let Some(stays) = kept.in_place(at, base_bytes) {
            made.insert(at, stays);
            continue;
        }
        let (entry, bytes, checksum) = if let Some(kept) = kept.whole(at) {
            kept
        } else {
            let piece = around.joined(at)?;
            let bytes = codec::piece_bytes(&piece);
            let checksum = crc32fast::hash(&bytes);
            (Entry::of(charts[at].mark, boxes[at], &piece), bytes, checksum)
        };
        let length = u32::try_from(bytes.len());
        let length = length.map_err(|_| BuildError::TooLarge(charts[at].source.name.clone()))?;
        put(&bytes)?;
        made.insert(at, (entry, Span { offset, length, checksum }));
        offset += u64::from(length);
    }
    let sources: Vec<Source> = charts.iter().map(|chart| chart.source.clone()).collect();
    let (entries, spans): (Vec<Entry>, Vec<Span>) = made.into_values().unzip();
    put(&codec::end(&sources, &entries, &spans))?;
    Ok(spans.iter().map(|span| u64::from(span.length)).sum())
}

/// The previous index's pieces of the charts.
struct Kept<'a> {
    before: Option<&'a DepthIndex>,
    /// The number there of charts that are the same.
    same: Vec<Option<usize>>,
    /// Whether the seams are the same too.
    untouched: Vec<bool>,
}

impl<'a> Kept<'a> {
    fn of(charts: &[ChartToIndex], boxes: &[Bounds], before: Option<&'a DepthIndex>) -> Self {
        let mut old: BTreeMap<&str, usize> = BTreeMap::new();
        let entries = before.map_or(&[][..], |index| &index.directory.entries);
        for (at, source) in before.map_or(&[][..], DepthIndex::sources).iter().enumerate() {
            old.insert(&source.name, at);
        }
        let mut changed: Vec<Bounds> = Vec::new();
        let mut same = Vec::with_capacity(charts.len());
        for (chart, bounds) in charts.iter().zip(boxes) {
            let there = old.remove(chart.source.name.as_str()).filter(|at| {
                let (source, entry) = (before.map(|index| &index.sources()[*at]), &entries[*at]);
                let same =
                    source == Some(&chart.source) && entry.mark == chart.mark && entry.bounds == *bounds;
                if !same {
                    changed.push(entry.bounds);
                }
                same
            });
            if there.is_none() {
                changed.push(*bounds);
            }
            same.push(there);
        }
        changed.extend(old.into_values().map(|gone| entries[gone].bounds));
        let untouched = |bounds: &Bounds| !changed.iter().any(|one| seams::meet(one, bounds));
        Self { before, same, untouched: boxes.iter().map(untouched).collect() }
    }

    /// A chart's own part; `None` where it changed or cannot be read.
    fn own(&self, at: usize) -> Option<Piece> {
        let piece = self.before?.sound_piece(self.same[at]?)?;
        Some(Piece::clone(&piece).own())
    }

    /// Where a chart with its seams lies; `None` where it changed, or lies beyond the first `base_bytes`.
    fn in_place(&self, at: usize, base_bytes: u64) -> Option<(Entry, Span)> {
        let (before, there) = (self.before?, self.same[at].filter(|_| self.untouched[at])?);
        let span = before.span(there)?;
        let within = span.offset + u64::from(span.length) <= base_bytes;
        within.then(|| (before.directory.entries[there].clone(), span))
    }

    /// A chart with its seams, as it lies there, and the checksum of it; `None` where it changed or cannot be read.
    fn whole(&self, at: usize) -> Option<(Entry, Vec<u8>, u32)> {
        let (before, there) = (self.before?, self.same[at].filter(|_| self.untouched[at])?);
        let (bytes, checksum) = before.piece_bytes(there)?;
        Some((before.directory.entries[there].clone(), bytes, checksum))
    }
}
