//! Days of the archive in their two forms, plain and compressed: whether a file in one form holds what one in the other
//! holds, by the digests of the plain bytes.

use super::manifest::{copy, hash_prefix};
use std::io;
use std::path::Path;
use store::Packed;

/// Whether the first `bytes` plain bytes of a compressed file have this digest, all of it read and unpacked.
///
/// # Errors
/// It cannot be read, or is damaged.
pub(super) fn begins_with(packed: &Path, bytes: u64, sha256: &str) -> io::Result<bool> {
    let mut packed = open(packed)?;
    let (_, found) = copy(&mut packed, bytes, &mut io::sink())?;
    Ok(packed.plain_bytes() >= bytes && found == sha256)
}

/// Whether a plain file begins with all the plain bytes of a compressed one. The compressed one is not unpacked: its head
/// has the digest of what it was made of.
///
/// # Errors
/// One cannot be read, or the head or the seek table of the compressed one is damaged.
pub(super) fn is_begin_of(packed: &Path, plain: &Path, plain_bytes: u64) -> io::Result<bool> {
    let packed = open(packed)?;
    let bytes = packed.plain_bytes();
    Ok(bytes <= plain_bytes && hash_prefix(plain, bytes)? == hex::encode(packed.plain_sha256()))
}

/// Plain bytes of a compressed file.
///
/// # Errors
/// It cannot be read, or its head or its seek table is damaged.
pub(super) fn plain_bytes(packed: &Path) -> io::Result<u64> {
    Ok(open(packed)?.plain_bytes())
}

fn open(packed: &Path) -> io::Result<Packed> {
    Packed::open(packed).map_err(|error| match error {
        store::StoreError::Io { source, .. } => source,
        other => io::Error::other(other),
    })
}
