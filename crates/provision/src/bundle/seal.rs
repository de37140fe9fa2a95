//! The sealed form of a bundle.
//!
//! | bytes | what |
//! |---|---|
//! | 8 | `LUTRABDL` |
//! | 2 | format, little endian |
//! | 8 | length of the sealed part, little endian |
//! | 16 | salt of the passphrase |
//! | 12 | nonce |
//! | … | the plain form, by ChaCha20-Poly1305 (RFC 8439) with all before it as associated data; 16 bytes longer |
//! | 32 | SHA-256 of all before it: distinguishes a damaged copy from a wrong passphrase |
//!
//! The key is made of the passphrase by Argon2id (RFC 9106) with parameters that belong to the format: no file can ask for more
//! memory or time. Both are in the tree already, for passwords and TLS; the `age` format would do the same with some fifty
//! crates more.

use super::{Bundle, BundleError, FORMAT};
use argon2::{Algorithm, Argon2, Params, Version};
use ring::aead::{Aad, CHACHA20_POLY1305, LessSafeKey, Nonce, UnboundKey};
use sha2::{Digest as _, Sha256};

const MAGIC: &[u8; 8] = b"LUTRABDL";
const SALT_BYTES: usize = 16;
const NONCE_BYTES: usize = 12;
const TAG_BYTES: usize = 16;
const DIGEST_BYTES: usize = 32;
const LENGTH_AT: usize = MAGIC.len() + 2;
const SALT_AT: usize = LENGTH_AT + 8;
const NONCE_AT: usize = SALT_AT + SALT_BYTES;
const HEAD_BYTES: usize = NONCE_AT + NONCE_BYTES;
/// Sealed bundles are read whole; longer ones are refused before.
pub const MAX_BUNDLE_BYTES: u64 = 256 << 20;
/// Characters of a passphrase at least.
const PASSPHRASE_CHARS: usize = 12;
/// Argon2id: memory (KiB), passes, lanes. A Raspberry Pi takes about a second.
const MEMORY_KIB: u32 = 64 << 10;
const PASSES: u32 = 3;

/// Random bytes of one sealing, never used twice.
#[derive(Clone, Copy)]
pub struct Randomness(pub [u8; SALT_BYTES + NONCE_BYTES]);

impl std::fmt::Debug for Randomness {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Randomness(…)")
    }
}

/// The passphrase in what was typed or read from a file: its first line, without blanks around it. Ashore and aboard read it
/// so; `None` where there is more than one line, as it is unclear which is meant.
pub fn passphrase_in(text: &str) -> Option<&str> {
    let mut lines = text.trim().lines();
    let first = lines.next().unwrap_or_default().trim();
    lines.next().is_none().then_some(first)
}

/// Whether a passphrase is long enough to protect a bundle that a stranger finds.
pub fn passphrase_is_good(passphrase: &str) -> bool {
    passphrase.chars().count() >= PASSPHRASE_CHARS
}

/// How many bytes a sealed bundle has that begins so; `head` needs no more than its first 64.
///
/// # Errors
/// The bytes are not a bundle, or one of a format that this version does not know.
pub fn sealed_bytes(head: &[u8]) -> Result<u64, BundleError> {
    if !head.starts_with(MAGIC) {
        return Err(BundleError::NotABundle);
    }
    let cut = BundleError::CutShort { have: head.len() as u64, whole: (HEAD_BYTES + DIGEST_BYTES) as u64 };
    let number = |at: usize| head.get(at..at + 2).map(|two| u16::from_le_bytes([two[0], two[1]]));
    let format = number(MAGIC.len()).ok_or_else(|| cut.clone())?;
    if format > FORMAT {
        return Err(BundleError::NewerFormat(format));
    }
    let length = head.get(LENGTH_AT..SALT_AT).and_then(|eight| eight.try_into().ok()).map(u64::from_le_bytes);
    let whole = length.ok_or(cut)?.saturating_add((HEAD_BYTES + DIGEST_BYTES) as u64);
    if whole > MAX_BUNDLE_BYTES { Err(BundleError::TooLarge(whole)) } else { Ok(whole) }
}

impl Bundle {
    /// The sealed form, which only the passphrase opens.
    ///
    /// # Errors
    /// The passphrase is too short, or the bundle too large.
    pub fn seal(&self, passphrase: &str, random: Randomness) -> Result<Vec<u8>, BundleError> {
        if !passphrase_is_good(passphrase) {
            return Err(BundleError::WeakPassphrase);
        }
        let mut plain = self.pack()?;
        let whole = (HEAD_BYTES + plain.len() + TAG_BYTES + DIGEST_BYTES) as u64;
        if whole > MAX_BUNDLE_BYTES {
            return Err(BundleError::TooLarge(whole));
        }
        let mut bytes = MAGIC.to_vec();
        bytes.extend_from_slice(&self.manifest.format.to_le_bytes());
        bytes.extend_from_slice(&((plain.len() + TAG_BYTES) as u64).to_le_bytes());
        bytes.extend_from_slice(&random.0);
        let (key, nonce) = (key(passphrase, &bytes[SALT_AT..NONCE_AT])?, nonce(&bytes)?);
        let sealed = key.seal_in_place_append_tag(nonce, Aad::from(&bytes[..]), &mut plain);
        sealed.map_err(|_| BundleError::TooLarge(whole))?;
        bytes.append(&mut plain);
        let digest = Sha256::digest(&bytes);
        bytes.extend_from_slice(&digest);
        Ok(bytes)
    }

    /// Opens the sealed form.
    ///
    /// # Errors
    /// It is not what [`Self::seal`] wrote, or the passphrase is another.
    pub fn open(mut bytes: Vec<u8>, passphrase: &str) -> Result<Self, BundleError> {
        let (whole, have) = (sealed_bytes(&bytes)?, bytes.len() as u64);
        if have < whole || bytes.len() < HEAD_BYTES + DIGEST_BYTES {
            return Err(BundleError::CutShort { have, whole });
        }
        if have > whole {
            return Err(BundleError::TooLong(have - whole));
        }
        let digest = bytes.split_off(bytes.len() - DIGEST_BYTES);
        if Sha256::digest(&bytes)[..] != digest[..] {
            return Err(BundleError::Damaged);
        }
        let mut sealed = bytes.split_off(HEAD_BYTES);
        let (key, nonce) = (key(passphrase, &bytes[SALT_AT..NONCE_AT])?, nonce(&bytes)?);
        let plain = key.open_in_place(nonce, Aad::from(&bytes[..]), &mut sealed);
        Self::unpack(plain.map_err(|_| BundleError::WrongPassphrase)?)
    }
}

fn key(passphrase: &str, salt: &[u8]) -> Result<LessSafeKey, BundleError> {
    let mut key = [0; 32];
    let parameters = Params::new(MEMORY_KIB, PASSES, 1, Some(key.len()));
    let made = parameters.and_then(|parameters| {
        let argon = Argon2::new(Algorithm::Argon2id, Version::V0x13, parameters);
        argon.hash_password_into(passphrase.as_bytes(), salt, &mut key)
    });
    made.map_err(|_| BundleError::WrongPassphrase)?;
    let key = UnboundKey::new(&CHACHA20_POLY1305, &key).map_err(|_| BundleError::WrongPassphrase)?;
    Ok(LessSafeKey::new(key))
}

fn nonce(head: &[u8]) -> Result<Nonce, BundleError> {
    Nonce::try_assume_unique_for_key(&head[NONCE_AT..HEAD_BYTES]).map_err(|_| BundleError::Damaged)
}
