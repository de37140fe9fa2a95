//! A cache of chart data, bounded by bytes: the least recently used goes first.

use crate::cut::Cover;
use crate::piece::Piece;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A chart, and the zoom of an overview; `None` for the chart itself.
pub(crate) type Key = (usize, Option<u8>);

#[derive(Default)]
struct Kept {
    /// With its bytes and when it was used last.
    pieces: BTreeMap<Key, (Arc<Piece>, usize, u64)>,
    covers: BTreeMap<usize, Arc<Cover>>,
    bytes: usize,
    uses: u64,
    /// By chart.
    unreadable: BTreeMap<usize, String>,
}

/// Most vertices of what charts cover; of charts that say it themselves these are few.
const MOST_COVER_VERTICES: usize = 1 << 20;

/// The charts that were read last.
pub(crate) struct PieceCache {
    most_bytes: usize,
    kept: Mutex<Kept>,
}

impl fmt::Debug for PieceCache {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "PieceCache({} bytes)", self.lock().bytes)
    }
}

impl PieceCache {
    pub(crate) fn new(most_bytes: usize) -> Self {
        Self { most_bytes, kept: Mutex::default() }
    }

    fn lock(&self) -> MutexGuard<'_, Kept> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn get(&self, key: Key) -> Option<Arc<Piece>> {
        let mut kept = self.lock();
        kept.uses += 1;
        let now = kept.uses;
        let (piece, _, used) = kept.pieces.get_mut(&key)?;
        *used = now;
        Some(Arc::clone(piece))
    }

    pub(crate) fn put(&self, key: Key, piece: Piece, bytes: usize) -> Arc<Piece> {
        let piece = Arc::new(piece);
        let mut kept = self.lock();
        let now = kept.uses;
        // Two that need the same at once may both have read it.
        let before = kept.pieces.insert(key, (Arc::clone(&piece), bytes, now));
        kept.bytes = kept.bytes + bytes - before.map_or(0, |(_, bytes, _)| bytes);
        while kept.bytes > self.most_bytes && kept.pieces.len() > 1 {
            let others = kept.pieces.iter().filter(|(other, _)| **other != key);
            let Some(oldest) = others.min_by_key(|(_, (.., used))| *used).map(|(other, _)| *other) else {
                break;
            };
            let gone = kept.pieces.remove(&oldest);
            kept.bytes -= gone.map_or(0, |(_, bytes, _)| bytes);
        }
        piece
    }

    pub(crate) fn cover(&self, chart: usize) -> Option<Arc<Cover>> {
        self.lock().covers.get(&chart).cloned()
    }

    pub(crate) fn put_cover(&self, chart: usize, cover: Cover) -> Arc<Cover> {
        let cover = Arc::new(cover);
        let mut kept = self.lock();
        kept.covers.insert(chart, Arc::clone(&cover));
        if kept.covers.values().map(|cover| cover.vertices()).sum::<usize>() > MOST_COVER_VERTICES {
            kept.covers.clear();
        }
        cover
    }

    pub(crate) fn note(&self, chart: usize, why: String) {
        self.lock().unreadable.insert(chart, why);
    }

    pub(crate) fn is_unreadable(&self, chart: usize) -> bool {
        self.lock().unreadable.contains_key(&chart)
    }

    pub(crate) fn unreadable(&self) -> Vec<String> {
        self.lock().unreadable.values().cloned().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_used_longest_ago_makes_room() {
        let cache = PieceCache::new(300);
        for chart in 0..3 {
            cache.put((chart, None), Piece::default(), 100);
        }
        assert!(cache.get((0, None)).is_some());
        cache.put((3, None), Piece::default(), 100);
        assert!(cache.get((1, None)).is_none() && cache.get((0, None)).is_some());
        // One that is larger than all room stays until the next.
        cache.put((4, Some(2)), Piece::default(), 1_000);
        assert!(cache.get((4, Some(2))).is_some() && cache.get((0, None)).is_none());
        cache.put((4, Some(2)), Piece::default(), 10);
        assert_eq!(cache.lock().bytes, 10);
    }
}
