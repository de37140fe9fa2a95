//! The plain form of a bundle: length of the manifest (u32, little endian), the manifest as JSON, the files one after another.
//!
//! Nothing is compressed, so that nothing grows when it is read; names are those of [`Part`], so that nothing has a path.

use super::{Bundle, BundleError, FORMAT, Item, Manifest, Part};
use crate::fleet::{Profile, is_name};

/// Bytes of a manifest at most.
const MAX_MANIFEST_BYTES: usize = 64 << 10;

impl Bundle {
    /// The plain form. Its secrets are readable.
    ///
    /// # Errors
    /// The manifest is too large.
    pub fn pack(&self) -> Result<Vec<u8>, BundleError> {
        let manifest =
            serde_json::to_vec(&self.manifest).map_err(|error| BundleError::Inside(error.to_string()))?;
        let length = u32::try_from(manifest.len()).ok().filter(|_| manifest.len() <= MAX_MANIFEST_BYTES);
        let length = length.ok_or_else(|| BundleError::Inside("a very long manifest".to_owned()))?;
        let mut bytes = length.to_le_bytes().to_vec();
        bytes.extend_from_slice(&manifest);
        for (_, file) in &self.files {
            bytes.extend_from_slice(file);
        }
        Ok(bytes)
    }

    /// Reads the plain form.
    ///
    /// # Errors
    /// It is of a newer format, or holds anything that [`Self::pack`] does not write.
    pub fn unpack(bytes: &[u8]) -> Result<Self, BundleError> {
        let (length, rest) = bytes.split_first_chunk::<4>().ok_or_else(|| inside("no manifest"))?;
        let length = u32::from_le_bytes(*length) as usize;
        if length > MAX_MANIFEST_BYTES || length > rest.len() {
            return Err(inside("a manifest that is longer than the bundle"));
        }
        let (manifest, mut rest) = rest.split_at(length);
        let manifest: Manifest = serde_json::from_slice(manifest)
            .map_err(|error| BundleError::Inside(format!("manifest: {error}")))?;
        if manifest.format > FORMAT {
            return Err(BundleError::NewerFormat(manifest.format));
        }
        if !is_name(&manifest.vessel) || !Profile::ALL.iter().any(|known| known.name() == manifest.profile) {
            return Err(inside("a vessel or profile that cannot be"));
        }
        let mut files: Vec<(Part, Vec<u8>)> = Vec::new();
        for item in &manifest.files {
            let part = Part::named(&item.name)
                .ok_or_else(|| BundleError::Inside(format!("a file {:?}", item.name)))?;
            if files.iter().any(|(known, _)| *known == part) {
                return Err(BundleError::Inside(format!("{} twice", item.name)));
            }
            let length = usize::try_from(item.bytes).ok().filter(|length| *length <= rest.len());
            let (file, after) =
                rest.split_at(length.ok_or_else(|| inside("a file that is longer than the bundle"))?);
            if *item != Item::of(part, file) {
                return Err(BundleError::Inside(format!(
                    "{} with another digest than the manifest says",
                    item.name
                )));
            }
            files.push((part, file.to_vec()));
            rest = after;
        }
        if !rest.is_empty() {
            return Err(inside("bytes of no file"));
        }
        let bundle = Self { manifest, files };
        match [Part::Overlay, Part::Token].into_iter().find(|part| bundle.file(*part).is_none()) {
            Some(part) => Err(BundleError::Inside(format!("no {}", part.name()))),
            None => Ok(bundle),
        }
    }
}

fn inside(what: &str) -> BundleError {
    BundleError::Inside(what.to_owned())
}
