//! The bundle that is carried aboard: everything that one vessel needs of the shore, sealed with a passphrase.
//!
//! `manifest` says what a bundle holds, `pack` is the plain form, `seal` the sealed one.

mod manifest;
mod pack;
mod seal;

#[cfg(test)]
mod tests;

pub use manifest::{Item, Manifest, Part, Port};
pub use seal::{MAX_BUNDLE_BYTES, Randomness, passphrase_in, passphrase_is_good, sealed_bytes};

use thiserror::Error;

/// The newest format that is read.
pub const FORMAT: u16 = 2;
/// The first format, which agents of all versions read.
const FIRST: u16 = 1;

/// A vessel's files with what they are for.
#[derive(Clone, PartialEq, Eq)]
pub struct Bundle {
    /// Its manifest.
    pub manifest: Manifest,
    /// The files, in the manifest's order.
    files: Vec<(Part, Vec<u8>)>,
}

impl Bundle {
    /// A bundle of these files; what `manifest` says of files and format is made of them. Only a bundle for OpenVPN has the
    /// second format, so that an older agent says that it must be updated.
    pub fn new(mut manifest: Manifest, files: Vec<(Part, Vec<u8>)>) -> Self {
        let is_second = files.iter().any(|(part, _)| *part == Part::OpenVpn);
        manifest.format = if is_second { FORMAT } else { FIRST };
        manifest.files = files.iter().map(|(part, bytes)| Item::of(*part, bytes)).collect();
        Self { manifest, files }
    }

    /// A file's bytes, if there is one for this.
    pub fn file(&self, part: Part) -> Option<&[u8]> {
        self.files.iter().find(|(known, _)| *known == part).map(|(_, bytes)| &bytes[..])
    }
}

impl std::fmt::Debug for Bundle {
    /// Without the files, which hold secrets.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Bundle").field("manifest", &self.manifest).finish_non_exhaustive()
    }
}

/// Why a bundle cannot be used. Each says what to do.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum BundleError {
    /// Some other file.
    #[error("this file is not a bundle: make one with `lutra-server fleet bundle NAME`")]
    NotABundle,
    /// Made by a later program.
    #[error(
        "the bundle has format {0} and this program reads up to {FORMAT}: update lutra-agent, then try again"
    )]
    NewerFormat(u16),
    /// The end is missing.
    #[error("the bundle is cut short: {have} of {whole} bytes are there. Copy it again")]
    CutShort {
        /// Bytes that are there.
        have: u64,
        /// Bytes that it has.
        whole: u64,
    },
    /// There is more behind the end.
    #[error("behind the end of the bundle there are {0} bytes that do not belong to it. Copy it again")]
    TooLong(u64),
    /// More than any bundle has.
    #[error(
        "a bundle of {0} bytes is more than the {MAX_BUNDLE_BYTES} that are taken: make it with --no-chart; the chart comes by the link"
    )]
    TooLarge(u64),
    /// Some byte is another.
    #[error("the bundle is damaged: its bytes are not those that were written. Copy it again")]
    Damaged,
    /// The passphrase opens another bundle, if any.
    #[error(
        "the passphrase does not open this bundle: it is the one that `lutra-server fleet bundle` said when this file was made"
    )]
    WrongPassphrase,
    /// Too easily guessed.
    #[error("the passphrase is too short: take 12 characters or more")]
    WeakPassphrase,
    /// It opens, and makes no sense inside.
    #[error("the bundle holds what no bundle has ({0}): make another with `lutra-server fleet bundle`")]
    Inside(String),
}
