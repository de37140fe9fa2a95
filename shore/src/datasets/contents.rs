//! Files of datasets: their inputs, and their contents.

use crate::error::{Error, ErrorKind, Result};
use crate::history::heard::{self, HeardFile};
use crate::history::{History, export};
use api::{DatasetContent, DatasetShare, DatasetVersion, Said, say};
use imc::Address;
use research::{About, LUTRA, Limits, Narrowed, Study};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;
use store::{DetectionsWanted, Exported, Reader, Selection, StoreError, TimeRange};
use tokio::sync::OwnedSemaphorePermit;
use tokio_util::sync::CancellationToken;

/// All inputs of a file of a published version, except the archive.
#[derive(Debug)]
pub struct Frozen {
    wanted: DetectionsWanted,
    names: BTreeMap<u16, String>,
    study: Study,
    /// Version of the register.
    register: i64,
    file: HeardFile,
}

impl Frozen {
    /// Of a version, as far as a link gives it, in a format.
    ///
    /// # Errors
    /// There is no such format, or not for datasets; or an entry that the question names no longer exists.
    pub(super) fn new(
        version: &DatasetVersion,
        share: Option<&DatasetShare>,
        format: Option<&str>,
        (register, study): (i64, Study),
    ) -> Result<Self> {
        let malformed = |text: Said| Error::new(ErrorKind::Malformed, text);
        let mut file = HeardFile::new(format, None)?;
        if !file.format.is_of_detections() {
            let text = say("format: {name} is of the whole register, not of a dataset; take it from /api/v1/detections.csv").with("name", file.format.name);
            return Err(malformed(text.into()));
        }
        let query = &version.query;
        // Names as they are: one that the register has no more is not taken for several.
        let (projects, area) = (query.projects.iter().map(String::as_str), query.area.trim());
        let narrowed = Narrowed::of(projects, (!area.is_empty()).then_some(area), &study);
        file.narrowed = narrowed.map_err(|text| {
            Error::refused(say("The archive has changed since: {text}").with_said("text", text))
        })?;
        file.without.clone_from(&query.without);
        // Otherwise detections after publication, or outside of a link's part, would change rows as neighbours.
        file.is_closed = true;
        file.about = about(version);
        let mut range =
            TimeRange { from_us: query.from_us.unwrap_or(0), to_us: query.to_us.unwrap_or(i64::MAX) };
        if let Some(share) = share {
            range.from_us = range.from_us.max(share.from_us.unwrap_or(i64::MIN));
            range.to_us = range.to_us.min(share.to_us.unwrap_or(i64::MAX)).max(range.from_us);
            let is_part = share.from_us.is_some() || share.to_us.is_some();
            let limits = Limits::new(&share.tags, &share.area, share.precision_m, is_part);
            file.limits = limits.map_err(malformed)?;
        }
        let systems = Some(query.vessels.iter().copied().map(Address).collect());
        let tags = export::tags(Some(&query.tags.join(",")))?;
        let wanted = DetectionsWanted { systems, range, came_from: None, tags };
        let named = version.vessels.iter().filter(|vessel| !vessel.name.is_empty());
        let names = named.map(|vessel| (vessel.system, vessel.name.clone())).collect();
        Ok(Self { wanted, names, study, register, file })
    }

    /// The file's name.
    pub fn name(&self) -> String {
        self.file.name()
    }

    /// Its media type.
    pub fn media(&self) -> &'static str {
        self.file.format.media()
    }

    /// The question as a text that differs whenever the bytes may differ.
    pub fn question(&self) -> String {
        let Self { wanted, names, register, file, .. } = self;
        format!(
            "{wanted:?} {names:?} {register} {} {:?} {:?} {:?} {:?}",
            file.format.name, file.narrowed, file.without, file.limits, file.about
        )
    }

    /// Writes the file.
    ///
    /// # Errors
    /// As [`heard::write()`].
    pub fn write(&self, data: &Path, out: &mut dyn Write) -> store::Result<Exported> {
        heard::write(data, &self.wanted, &self.names, &self.study, &self.file, out)
    }

    /// A version number of the archive that changes whenever the file's bytes may change.
    ///
    /// # Errors
    /// The history cannot be read.
    pub fn version(&self, data: &Path) -> store::Result<u64> {
        let (messages, range) = (self.file.messages(), self.file.read_range(self.wanted.range));
        let carriers = Selection { messages, range, ..Selection::default() };
        store::table_version(&mut Reader::open(data)?, &carriers)
    }

    /// The state of archive and register.
    pub(super) fn state(&self, data: &Path) -> store::Result<(u64, i64)> {
        Ok((self.version(data)?, self.register))
    }

    /// The file's content figures. Holds a place while they are computed.
    pub(super) async fn content(
        self: Arc<Self>,
        history: &History,
        place: OwnedSemaphorePermit,
        given_up: CancellationToken,
    ) -> Result<DatasetContent> {
        let data = history.data().to_owned();
        let computed = crate::error::slow(move || {
            let _place = place;
            let Self { wanted, names, study, file, .. } = &*self;
            heard::content(&data, wanted, names, study, file, &given_up)
        });
        Ok(computed.await??)
    }
}

/// What a file of a version says of itself.
fn about(version: &DatasetVersion) -> About {
    About {
        id: version.doi.clone(),
        title: version.title.clone(),
        summary: version.description.clone(),
        publisher: version.publisher.clone(),
        creators: version.authors.clone(),
        licence: version.licence.clone(),
        citation: version.citation.clone(),
        published_us: Some(version.published.time_us),
    }
}

/// What a file has. It takes the place of an export while it is computed, and ends when nobody waits for it.
pub(super) async fn content_of(history: &History, frozen: Frozen) -> Result<DatasetContent> {
    let Ok(place) = Arc::clone(&history.exports).try_acquire_owned() else {
        let text = say("Too many exports are running; try again in a moment.");
        return Err(Error::new(ErrorKind::Busy, text));
    };
    let given_up = CancellationToken::new();
    let _here = given_up.clone().drop_guard();
    Arc::new(frozen).content(history, place, given_up).await
}

/// The recorded vessels, which may have detections.
pub(super) async fn recorded(history: &History) -> Result<Vec<u16>> {
    let found = history.ask(|reader: &mut Reader| -> Result<Vec<u16>, StoreError> {
        Ok(reader.systems()?.into_iter().map(|system| system.address.0).collect())
    });
    Ok(found.await?)
}

/// The format whose bytes are published.
pub(super) const CANONICAL: &str = LUTRA.name;
