//! An index as a file: its bytes under the digest of the charts it was made of.
//!
//! Layout: the magic `LUTRACHI`, the digest (32 bytes), then the bytes of [`DepthIndex::to_bytes`]. So a file
//! shows without the charts which set it holds, ashore and aboard.

use super::codec::IndexError;
use super::index::DepthIndex;
use super::packed::PackedIndex;
use super::piece_cache::IndexBytes;
use std::sync::Arc;

const MAGIC: &[u8; 8] = b"LUTRACHI";
const HEAD_BYTES: usize = 40;

/// An index and the digest of its charts.
#[derive(Debug, Clone, PartialEq)]
pub struct SealedIndex {
    /// SHA-256 that names the contents of the chart set.
    pub digest: [u8; 32],
    /// The index.
    pub index: DepthIndex,
}

impl SealedIndex {
    /// As a file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Self::head(self.digest);
        bytes.extend(self.index.to_bytes());
        bytes
    }

    /// The digest that a file begins with, without reading the rest; `None` if it is not such a file.
    pub fn digest_of(bytes: &[u8]) -> Option<[u8; 32]> {
        let head = bytes.get(..HEAD_BYTES)?;
        if head.starts_with(MAGIC) { head[MAGIC.len()..].try_into().ok() } else { None }
    }

    /// The head of a file of an index over these charts.
    pub fn head(digest: [u8; 32]) -> Vec<u8> {
        [MAGIC.as_slice(), &digest].concat()
    }

    /// The index of a file, read as it is asked for; at most so many bytes of pieces are kept in memory.
    ///
    /// # Errors
    /// When the bytes are not such a file, of another version, or their directory is damaged.
    pub fn open(bytes: Arc<dyn IndexBytes>, most_bytes: usize) -> Result<Self, IndexError> {
        let head = bytes.read(0, HEAD_BYTES).map_err(|_| IndexError::Magic)?;
        let digest = Self::digest_of(&head).ok_or(IndexError::Magic)?;
        Ok(Self { digest, index: DepthIndex::open(bytes, HEAD_BYTES as u64, most_bytes)? })
    }

    /// The index of a file that something follows which brings it up to date ([`super::assemble_after`]), so that it is
    /// of the charts of this digest.
    ///
    /// # Errors
    /// As those of [`Self::open`].
    pub fn open_changed(
        bytes: Arc<dyn IndexBytes>,
        digest: [u8; 32],
        most_bytes: usize,
    ) -> Result<Self, IndexError> {
        Ok(Self { digest, index: DepthIndex::open(bytes, HEAD_BYTES as u64, most_bytes)? })
    }

    /// The bytes of [`Self::to_bytes`], read as they are asked for.
    pub fn packed(&self) -> PackedIndex {
        PackedIndex::of(Self::head(self.digest), &self.index)
    }

    /// Where the bytes of [`DepthIndex::to_bytes`] begin in a file.
    pub const fn head_bytes() -> u64 {
        HEAD_BYTES as u64
    }

    /// The index of a file, all of it in memory.
    ///
    /// # Errors
    /// When the bytes are not such a file, of another version, or damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, IndexError> {
        let digest = Self::digest_of(bytes).ok_or(IndexError::Magic)?;
        let index = DepthIndex::from_bytes(&bytes[HEAD_BYTES..])?;
        Ok(Self { digest, index })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_digest_comes_back_with_the_index() {
        let sealed = SealedIndex { digest: [7; 32], index: DepthIndex::default() };
        let bytes = sealed.to_bytes();
        assert_eq!(SealedIndex::digest_of(&bytes), Some([7; 32]));
        assert_eq!(SealedIndex::from_bytes(&bytes).unwrap(), sealed);
        assert!(SealedIndex::from_bytes(&bytes[..bytes.len() - 1]).is_err());
        assert_eq!(SealedIndex::from_bytes(b"LUTRACHI").unwrap_err(), IndexError::Magic);
    }
}
