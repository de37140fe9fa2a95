//! Notes of the log book, with their access rules.
//!
//! A note on a vessel is visible to users who may see the vessel and written by its operators; a note on no vessel is
//! visible to all and written by operators of any vessel. It is changed by its author, as long as they may write, or by an
//! admin.

use super::photos::{self, ALL_BYTES, Photo, Photos};
use super::rows::{
    AddPhoto, Correct, Earlier, Filter, HAS_PHOTO, NEWER, Notes, One, PhotoBytes, Row, Said, Withdraw, Write,
};
use crate::clock::Clock;
use crate::error::{Error, ErrorKind, Result, slow};
use crate::identity::{Fault, People, Principal};
use crate::once::{Key, Made, Once};
use api::{
    LogNote, LogNoteChange, LogNoteQuery, LogNoteRequest, LogNoteRevision, LogNotes, LogWord, Role, Wording,
    say,
};
use imc::Address;
use std::path::Path;
use std::sync::Arc;
use tokio::sync::Mutex;

/// Most characters of a note.
const LETTERS: usize = 4_000;
/// Longest time that a note may have been in transit (ms).
const LONGEST_WAIT_MS: u32 = 3_600_000;
/// Times that JavaScript represents exactly (µs since 1970 UTC).
pub(crate) const TIMES_US: std::ops::RangeInclusive<i64> = 0..=9_007_199_254_740_991;

/// The time and number of a note, after which older ones come.
pub type Cursor = (i64, i64);

/// The log book; cheap to clone.
#[derive(Debug, Clone)]
pub struct Logbook {
    people: People,
    clock: Clock,
    photos: Photos,
    /// Photos are stored one at a time, so that their total stays within its limit.
    taking: Arc<Mutex<()>>,
}

impl Logbook {
    pub(crate) fn new(people: People, clock: Clock, data: &Path) -> Self {
        Self { people, clock, photos: Photos::new(data), taking: Arc::default() }
    }

    /// A page of notes, the newest first; `filter` includes what `who` may see.
    ///
    /// # Errors
    /// app.db cannot be read.
    pub async fn page(
        &self,
        who: &Principal,
        filter: Filter,
        before: Option<Cursor>,
        count: u32,
    ) -> Result<LogNotes> {
        let rows = self.people.ask(Notes { filter, before, count }).await?;
        let last = rows.last().map(|row| (row.time_us, row.id)).filter(|_| rows.len() == count as usize);
        let next = last.map(|(time_us, id)| format!("{time_us}.{id}"));
        Ok(LogNotes { notes: rows.into_iter().map(|row| self.told(who, row)).collect(), next })
    }

    /// Reads [`LogNotes::next`].
    ///
    /// # Errors
    /// It is malformed.
    pub fn cursor(text: &str) -> Result<Cursor> {
        let read = || {
            let (time_us, id) = text.split_once('.')?;
            Some((time_us.parse().ok()?, id.parse().ok()?))
        };
        read().ok_or_else(|| malformed(say("before: give `next` of the page before")))
    }

    /// Earlier revisions of a note, the newest first.
    ///
    /// # Errors
    /// There is no such note for this person.
    pub async fn earlier(&self, who: &Principal, id: i64) -> Result<Vec<LogNoteRevision>> {
        self.find(who, id).await?;
        let mut all = self.people.ask(Earlier(id)).await?;
        // A revision about another vessel is only for users who may see that one.
        all.retain(|one| sees(who, one.vessel));
        Ok(all)
    }

    /// Writes a note. If a person repeats a request with the same `key`, the first note is the answer.
    ///
    /// # Errors
    /// The person may not, or the named field is not valid.
    pub async fn write(
        &self,
        who: &Principal,
        from: String,
        ask: LogNoteRequest,
        LogNoteQuery { key, waited_ms }: LogNoteQuery,
    ) -> Result<LogNote> {
        let key = Key::new(Made::Note, who.person, key)?;
        let waited_ms = waited_ms.unwrap_or(0);
        if waited_ms > LONGEST_WAIT_MS {
            let text = say("waited_ms: a note is sent for {most} ms at most; give it a time");
            return Err(malformed(text.with("most", LONGEST_WAIT_MS)));
        }
        if let Some(key) = &key
            && let Some(first) = self.people.ask(key.clone()).await?
        {
            return self.one(who, first).await;
        }
        let now = self.clock.utc();
        // The note is about the time at which it was sent, not at which it arrived over a bad connection.
        let meant_us = now.micros() - i64::from(waited_ms) * 1_000;
        let said = said(&ask, meant_us)?;
        may_write(who, said.vessel)?;
        let subject = subject(said.vessel, &said.text);
        let make = Write { said, person: who.person, by: who.name.clone(), now };
        let write = Once { key, make };
        let id = self.people.act(who, from, "logbook.write", subject, write).await?;
        self.one(who, id).await
    }

    /// Corrects a note; its earlier text is kept.
    ///
    /// # Errors
    /// The person may not, the note was changed meanwhile, or the named field is not valid.
    pub async fn correct(
        &self,
        who: &Principal,
        from: String,
        id: i64,
        change: LogNoteChange,
    ) -> Result<LogNote> {
        let row = self.changeable(who, id).await?;
        if row.revision != change.revision {
            return Err(Error::new(ErrorKind::Newer, NEWER));
        }
        let said = said(&change.note, row.time_us)?;
        may_write(who, said.vessel)?;
        let subject = format!("{} (note {id}); before: {}", subject(said.vessel, &said.text), row.text);
        let by = who.name.clone();
        let correct = Correct { id, revision: change.revision, said, by, now: self.clock.utc() };
        self.people.act(who, from, "logbook.correct", subject, correct).await?;
        self.one(who, id).await
    }

    /// Marks a note as withdrawn. It is still listed on request.
    ///
    /// # Errors
    /// The person may not, or the note was changed meanwhile.
    pub async fn withdraw(&self, who: &Principal, from: String, id: i64) -> Result<LogNote> {
        let row = self.changeable(who, id).await?;
        let subject = format!("{} (note {id})", subject(row.vessel, &row.text));
        let withdraw = Withdraw { id, revision: row.revision, by: who.name.clone(), now: self.clock.utc() };
        self.people.act(who, from, "logbook.withdraw", subject, withdraw).await?;
        self.one(who, id).await
    }

    /// Gives a note its photo.
    ///
    /// # Errors
    /// The person may not, it is not a photo, the note has one, or there is no room.
    pub async fn add_photo(&self, who: &Principal, from: String, id: i64, bytes: Vec<u8>) -> Result<LogNote> {
        let row = self.changeable(who, id).await?;
        let media = photos::check(&bytes)?;
        let _one = self.taking.lock().await;
        if self.people.ask(One(id)).await?.is_none_or(|row| row.photo.is_some()) {
            return Err(Error::refused(HAS_PHOTO));
        }
        if self.people.ask(PhotoBytes).await? + bytes.len() as u64 > ALL_BYTES {
            let text = say("photo: the log book holds {most} GiB of photos and takes no more. The note is kept without it; ask an admin.").with("most", ALL_BYTES >> 30);
            return Err(Error::refused(text));
        }
        let (photos, length) = (self.photos.clone(), bytes.len());
        slow(move || photos.keep(id, &bytes)).await?.map_err(|error| unkept(&error))?;
        let subject = format!("{} (note {id}): {media}, {length} bytes", subject(row.vessel, &row.text));
        let add = AddPhoto { id, media, bytes: length };
        let added = self.people.act(who, from, "logbook.photo", subject, add).await;
        // After other errors app.db may have it: a file without a note is less harmful than a note without its file.
        if matches!(added, Err(Fault::Refused(_))) {
            self.photos.forget(id);
        }
        added?;
        self.one(who, id).await
    }

    /// The photo of a note.
    ///
    /// # Errors
    /// No photo that this person may see.
    pub async fn photo(&self, who: &Principal, id: i64) -> Result<Photo> {
        let none = || Error::new(ErrorKind::NotFound, say("This note has no photo."));
        let media = self.find(who, id).await?.photo.ok_or_else(none)?;
        let photos = self.photos.clone();
        let bytes = slow(move || photos.read(id)).await?.map_err(|error| {
            tracing::error!(%error, note = id, "a photo of the log book cannot be read");
            Error::new(ErrorKind::NotFound, say("The photo's file cannot be read: a backup may have it."))
        })?;
        Ok(Photo { media, bytes })
    }

    async fn one(&self, who: &Principal, id: i64) -> Result<LogNote> {
        Ok(self.told(who, self.find(who, id).await?))
    }

    /// A note that the person may see.
    async fn find(&self, who: &Principal, id: i64) -> Result<Row> {
        let row = self.people.ask(One(id)).await?.filter(|row| sees(who, row.vessel));
        row.ok_or_else(|| {
            Error::new(ErrorKind::NotFound, say("There is no such note; GET /api/v1/logbook lists them."))
        })
    }

    /// A note that the person may change, and that is not withdrawn.
    async fn changeable(&self, who: &Principal, id: i64) -> Result<Row> {
        let row = self.find(who, id).await?;
        if !may_change(who, &row) {
            let text = say(
                "{name} may not change this note: its author {by} may, while operator there, or an admin.",
            )
            .with("name", &who.name)
            .with("by", &row.by);
            return Err(Error::new(ErrorKind::Forbidden, text));
        }
        if let (Some(by), Some(_)) = (&row.withdrawn_by, row.withdrawn_us) {
            return Err(Error::refused(
                say("This note was withdrawn by {by}: write a new one.").with("by", by),
            ));
        }
        Ok(row)
    }

    /// A note as this person gets it.
    fn told(&self, who: &Principal, row: Row) -> LogNote {
        let may_change = row.withdrawn_us.is_none() && may_change(who, &row);
        let word = |by: Option<String>, at: Option<i64>| Some(LogWord { by: by?, time_us: at? });
        let named = self.people.vessels();
        let name = |vessel: u16| Some(named.iter().find(|named| named.address == vessel)?.name.clone());
        LogNote {
            id: row.id,
            revision: row.revision,
            time_us: row.time_us,
            vessel: row.vessel,
            vessel_name: row.vessel.and_then(name),
            lat_deg: row.lat_deg,
            lon_deg: row.lon_deg,
            text: row.text,
            by: row.by,
            written_us: row.written_us,
            corrected: word(row.corrected_by, row.corrected_us),
            withdrawn: word(row.withdrawn_by, row.withdrawn_us),
            photo: row.photo,
            may_change,
        }
    }
}

/// The role of a user on a vessel; for no vessel their highest role.
fn role(who: &Principal, vessel: Option<u16>) -> Option<Role> {
    vessel.map_or_else(|| who.grants.somewhere(), |vessel| who.grants.on(vessel))
}

fn sees(who: &Principal, vessel: Option<u16>) -> bool {
    role(who, vessel).is_some()
}

/// Checks that a user may write about this vessel.
///
/// # Errors
/// They may not; the text says which role it takes.
pub(crate) fn may_write(who: &Principal, vessel: Option<u16>) -> Result<()> {
    if role(who, vessel) >= Some(Role::Operator) {
        return Ok(());
    }
    let place = vessel
        .map_or_else(|| say("at least one vessel"), |vessel| say("vessel {vessel}").with("vessel", vessel));
    let text =
        say("vessel: {name} may not write here: that needs the role operator on {place}. Ask an admin.")
            .with("name", &who.name)
            .with_said("place", place);
    Err(Error::new(ErrorKind::Forbidden, text))
}

fn may_change(who: &Principal, row: &Row) -> bool {
    let admin = row.vessel.map_or_else(|| who.grants.everywhere(), |vessel| who.grants.on(vessel));
    // The number of a removed account may be reused.
    let author = row.person == who.person && row.by == who.name;
    admin == Some(Role::Admin) || (author && may_write(who, row.vessel).is_ok())
}

/// Validates a note; `time_us` is used where no time is given.
fn said(ask: &LogNoteRequest, time_us: i64) -> Result<Said> {
    let text = check_text("text", &ask.text, 1..=LETTERS)?;
    let time_us = ask.time_us.unwrap_or(time_us);
    if !TIMES_US.contains(&time_us) {
        return Err(malformed(not_a_time("time_us", time_us)));
    }
    let place = match (ask.lat_deg, ask.lon_deg) {
        (None, None) => None,
        (Some(lat_deg), Some(lon_deg)) => {
            let is_place = (-90.0..=90.0).contains(&lat_deg) && (-180.0..=180.0).contains(&lon_deg);
            Some((lat_deg, lon_deg)).filter(|_| is_place).map(Some).ok_or_else(|| {
                malformed(say(
                    "lat_deg: this is not a place: give degrees, latitude -90 to 90, longitude -180 to 180",
                ))
            })?
        }
        (None, Some(_)) => {
            return Err(malformed(say("lat_deg: a place has a latitude too: give both or neither")));
        }
        (Some(_), None) => {
            return Err(malformed(say("lon_deg: a place has a longitude too: give both or neither")));
        }
    };
    Ok(Said { time_us, vessel: ask.vessel, place, text })
}

/// What is said of a field of times that has none.
pub(crate) fn not_a_time(field: &str, time_us: i64) -> Wording {
    let text = say("{field}: {time_us} is not a time: give µs since 1970 UTC");
    text.with("field", field).with("time_us", time_us)
}

/// A text, trimmed and with normalised line ends.
///
/// # Errors
/// It is too short or long, or has control characters in it.
pub(crate) fn check_text(name: &str, text: &str, letters: std::ops::RangeInclusive<usize>) -> Result<String> {
    let text = text.replace("\r\n", "\n").trim().to_owned();
    let count = text.chars().count();
    if count < *letters.start() {
        return Err(malformed(say("{field}: empty; write something").with("field", name)));
    }
    if count > *letters.end() {
        let text = say("{field}: has {count} characters; at most {most} are allowed: shorten it");
        return Err(malformed(text.with("field", name).with("count", count).with("most", letters.end())));
    }
    if text.chars().any(|letter| letter.is_control() && letter != '\n' && letter != '\t') {
        let text = say("{field}: has control characters in it: write it without them");
        return Err(malformed(text.with("field", name)));
    }
    Ok(text)
}

/// Subject for the audit log.
fn subject(vessel: Option<u16>, text: &str) -> String {
    let place = vessel.map_or_else(|| "no vessel".to_owned(), |vessel| Address(vessel).to_string());
    let begin: String = text.chars().take(100).collect();
    format!("{place} {begin}")
}

fn malformed(text: impl Into<api::Said>) -> Error {
    Error::new(ErrorKind::Malformed, text)
}

/// The error for a file that could not be written.
fn unkept(error: &std::io::Error) -> Error {
    match error.kind() {
        std::io::ErrorKind::StorageFull | std::io::ErrorKind::QuotaExceeded => Error::new(
            ErrorKind::Unavailable,
            say(
                "photo: the server's disk is full. The note is kept without it; make room, then add the photo again.",
            ),
        ),
        _ => Error::internal(error),
    }
}
