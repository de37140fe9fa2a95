//! Drawn tiles in memory, bounded by bytes: the least recently used are evicted first.

use bytes::Bytes;
use std::collections::{BTreeMap, HashMap};

/// Zoom, column and row.
pub(super) type Key = (u8, u32, u32);

/// Memory of an entry besides its bytes.
const OVERHEAD: usize = 128;

/// A cache of tiles.
#[derive(Debug)]
pub(crate) struct Cache {
    most: usize,
    bytes: usize,
    clock: u64,
    tiles: HashMap<Key, (u64, Bytes)>,
    by_use: BTreeMap<u64, Key>,
}

impl Cache {
    /// An empty cache for so many bytes.
    pub(crate) fn new(most: usize) -> Self {
        Self { most, bytes: 0, clock: 0, tiles: HashMap::new(), by_use: BTreeMap::new() }
    }

    /// The tile, marked as most recently used.
    pub(crate) fn get(&mut self, key: Key) -> Option<Bytes> {
        let (used, tile) = self.tiles.get_mut(&key)?;
        self.by_use.remove(used);
        self.clock += 1;
        *used = self.clock;
        self.by_use.insert(self.clock, key);
        Some(tile.clone())
    }

    /// Keeps a tile and evicts the least recently used. A tile larger than the cache is not kept.
    pub(crate) fn put(&mut self, key: Key, tile: Bytes) {
        let takes = tile.len() + OVERHEAD;
        if takes > self.most {
            return;
        }
        self.remove(key);
        while self.bytes + takes > self.most {
            let Some((_, oldest)) = self.by_use.pop_first() else { break };
            self.remove(oldest);
        }
        self.clock += 1;
        self.bytes += takes;
        self.by_use.insert(self.clock, key);
        self.tiles.insert(key, (self.clock, tile));
    }

    fn remove(&mut self, key: Key) {
        if let Some((used, tile)) = self.tiles.remove(&key) {
            self.by_use.remove(&used);
            self.bytes -= tile.len() + OVERHEAD;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_used_longest_ago_makes_room() {
        let tile = |bytes: usize| Bytes::from(vec![7; bytes]);
        let mut cache = Cache::new(3 * (100 + OVERHEAD));
        for x in 0..3 {
            cache.put((9, x, 0), tile(100));
        }
        assert!(cache.get((9, 0, 0)).is_some());
        cache.put((9, 3, 0), tile(100));
        assert!(cache.get((9, 1, 0)).is_none() && cache.get((9, 0, 0)).is_some());
        cache.put((9, 4, 0), tile(10_000));
        assert!(cache.get((9, 4, 0)).is_none(), "larger than all room");
        cache.put((9, 0, 0), tile(50));
        assert_eq!((cache.get((9, 0, 0)).unwrap().len(), cache.tiles.len()), (50, 3));
        assert_eq!(cache.bytes, 250 + 3 * OVERHEAD);
        assert_eq!(cache.by_use.len(), 3);
    }
}
