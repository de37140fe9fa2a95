//! Access data in memory: people and their roles, sessions, tokens, names of vessels.
//!
//! A request is authorised by what was last read from app.db, so that a disk that hangs, or a file locked by another
//! program, does not prevent stopping a boat. Everything is read again, and replaced at once, by the thread that writes
//! app.db after each of its changes, and by a reader whenever the change counter shows a change by another program. The
//! last use of a session or token is stored here first and written when app.db is free.

use super::fault::Fault;
use super::language::Language;
use super::persons;
use super::roles::{Grants, Principal, Via};
use super::secret::Secret;
use super::sessions::Lifetime;
use super::tokens::{API_PREFIX, LINK_PREFIX};
use api::{Role, Said, Vessel, say};
use sqlx::SqliteConnection;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::{Arc, PoisonError, RwLock};
use units::UtcTime;

/// A use is written down when the one written last is older than this, µs.
const USE_EVERY_US: i64 = 60_000_000;
/// How often a use is offered to app.db again while it takes none, µs.
const OFFER_EVERY_US: i64 = 5_000_000;

/// The stored hash of a secret.
type Hash = [u8; 32];

/// Result of looking up a secret.
#[derive(Debug)]
pub(crate) enum Found<T> {
    /// Found, with a use to be recorded, if that is due.
    Known(T, Option<Use>),
    /// It is known but not valid, for this reason.
    Refused(Said),
    /// It has expired.
    Over,
    /// It is not in the register. It may be newer.
    Unknown,
}

/// A use to be recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Use {
    /// A session, by its number.
    Session(i64),
    /// A token, by its number.
    Token(i64),
}

/// The register.
#[derive(Debug, Default)]
pub(crate) struct Register(RwLock<Arc<Book>>);

#[derive(Debug, Default)]
struct Book {
    /// The change counter when it was read; `None` before the first reading.
    changes: Option<i64>,
    people: BTreeMap<i64, Person>,
    sessions: BTreeMap<Hash, Session>,
    tokens: BTreeMap<Hash, Token>,
    vessels: Arc<[Vessel]>,
}

#[derive(Debug)]
struct Person {
    name: String,
    must_change_password: bool,
    grants: Grants,
    language: Option<Language>,
}

#[derive(Debug)]
struct Session {
    id: i64,
    person: i64,
    created_us: i64,
    used: Arc<Used>,
}

#[derive(Debug)]
struct Token {
    id: i64,
    label: String,
    expires_us: Option<i64>,
    opens: Opens,
    used: Arc<Used>,
}

#[derive(Debug, Clone, Copy)]
enum Opens {
    /// The API, for a person, with this role on this vessel or on all.
    Api { person: i64, vessel: Option<u16>, role: Role },
    /// The link of this vessel.
    Link(u16),
}

/// When something was used last, µs since 1970 UTC; 0 for never.
#[derive(Debug)]
struct Used {
    last: AtomicI64,
    written: AtomicI64,
    offered: AtomicI64,
}

impl Used {
    fn new(last_us: i64) -> Arc<Self> {
        let at = || AtomicI64::new(last_us);
        Arc::new(Self { last: at(), written: at(), offered: AtomicI64::new(0) })
    }

    fn last_us(&self) -> i64 {
        self.last.load(Ordering::Relaxed)
    }

    /// Notes a use; returns whether it is to be written to app.db.
    fn note(&self, now_us: i64) -> bool {
        self.last.fetch_max(now_us, Ordering::Relaxed);
        let due = now_us - self.written.load(Ordering::Relaxed) >= USE_EVERY_US
            && now_us - self.offered.load(Ordering::Relaxed) >= OFFER_EVERY_US;
        if due {
            self.offered.store(now_us, Ordering::Relaxed);
        }
        due
    }
}

impl Register {
    fn book(&self) -> Arc<Book> {
        Arc::clone(&self.0.read().unwrap_or_else(PoisonError::into_inner))
    }

    /// Reads everything again if app.db has changed. `moment` is a transaction, so that the data are consistent.
    ///
    /// # Errors
    /// It cannot be read; the register stays as it is.
    pub(crate) async fn catch_up(&self, moment: &mut SqliteConnection) -> Result<(), Fault> {
        let before = self.book();
        let changes: i64 = sqlx::query_scalar("SELECT changes FROM register").fetch_one(&mut *moment).await?;
        if before.changes == Some(changes) {
            return Ok(());
        }
        let book = read(moment, changes, &before).await?;
        let mut place = self.0.write().unwrap_or_else(PoisonError::into_inner);
        // Another connection may have read a later state meanwhile: the counter only grows.
        if place.changes < book.changes {
            *place = Arc::new(book);
        }
        Ok(())
    }

    /// Identifies one reading of app.db.
    pub(crate) fn version(&self) -> Option<i64> {
        self.book().changes
    }

    /// The user of this session.
    pub(crate) fn session(&self, secret: &Secret, life: Lifetime, now: UtcTime) -> Found<Principal> {
        let (book, now_us) = (self.book(), now.micros());
        let Some(session) = book.sessions.get(&secret.hash()) else { return Found::Unknown };
        let Some(person) = book.people.get(&session.person) else { return Found::Unknown };
        if now_us - session.used.last_us() > life.idle_us() || now_us - session.created_us > life.whole_us() {
            return Found::Over;
        }
        let via = Via::Session {
            id: session.id,
            csrf: secret.derived("csrf"),
            must_change_password: person.must_change_password,
        };
        let (name, grants) = (person.name.clone(), person.grants.clone());
        let due = session.used.note(now_us).then_some(Use::Session(session.id));
        let language = person.language;
        Found::Known(Principal { person: session.person, name, grants, language, via }, due)
    }

    /// The principal that the script with this token acts for.
    pub(crate) fn token(&self, text: &str, now: UtcTime) -> Found<Principal> {
        let Some(secret) = text.strip_prefix(API_PREFIX).and_then(Secret::parse) else { return Found::Over };
        let book = self.book();
        let Some(token) = book.tokens.get(&secret.hash()) else { return Found::Unknown };
        let Opens::Api { person: id, vessel, role } = token.opens else { return Found::Over };
        let Some(person) = book.people.get(&id) else { return Found::Unknown };
        if token.is_over(now) {
            return Found::Over;
        }
        if person.must_change_password {
            let text = say(
                "This token acts for {name}, who still has a one-time password: log in as {name} with a \
                            browser and choose a password first.",
            );
            return Found::Refused(text.with("name", &person.name).into());
        }
        let via = Via::Token { id: token.id, label: token.label.clone() };
        let (name, grants) = (person.name.clone(), person.grants.limited(vessel, role));
        let due = token.used.note(now.micros()).then_some(Use::Token(token.id));
        let language = person.language;
        Found::Known(Principal { person: id, name, grants, language, via }, due)
    }

    /// The vessel (IMC address) whose link this token opens.
    pub(crate) fn link(&self, text: &str, now: UtcTime) -> Found<u16> {
        let Some(secret) = text.strip_prefix(LINK_PREFIX).and_then(Secret::parse) else { return Found::Over };
        let book = self.book();
        let Some(token) = book.tokens.get(&secret.hash()) else { return Found::Unknown };
        let Opens::Link(vessel) = token.opens else { return Found::Over };
        if token.is_over(now) {
            return Found::Over;
        }
        Found::Known(vessel, token.used.note(now.micros()).then_some(Use::Token(token.id)))
    }

    /// A use has been written to app.db.
    pub(crate) fn written(&self, of: Use, now: UtcTime) {
        let book = self.book();
        let used = match of {
            Use::Session(id) => book.sessions.values().find(|one| one.id == id).map(|one| &one.used),
            Use::Token(id) => book.tokens.values().find(|one| one.id == id).map(|one| &one.used),
        };
        if let Some(used) = used {
            used.written.store(now.micros(), Ordering::Relaxed);
        }
    }

    /// Vessels that have used their link, and still have a valid token, by address.
    pub(crate) fn linked(&self, now: UtcTime) -> Vec<u16> {
        let book = self.book();
        let open = book.tokens.values().filter(|token| token.used.last_us() > 0 && !token.is_over(now));
        let mut vessels: Vec<u16> = open
            .filter_map(|token| match token.opens {
                Opens::Link(vessel) => Some(vessel),
                Opens::Api { .. } => None,
            })
            .collect();
        vessels.sort_unstable();
        vessels.dedup();
        vessels
    }

    /// The vessels that people have named, by name.
    pub(crate) fn vessels(&self) -> Arc<[Vessel]> {
        Arc::clone(&self.book().vessels)
    }
}

impl Token {
    fn is_over(&self, now: UtcTime) -> bool {
        self.expires_us.is_some_and(|expires_us| expires_us <= now.micros())
    }
}

/// Reads everything from app.db. A use that is in `before` and not yet in app.db is kept.
async fn read(db: &mut SqliteConnection, changes: i64, before: &Book) -> Result<Book, Fault> {
    Ok(Book {
        changes: Some(changes),
        vessels: super::vessels::list(db).await?.into(),
        people: read_people(db).await?,
        sessions: read_sessions(db, before).await?,
        tokens: read_tokens(db, before).await?,
    })
}

async fn read_people(db: &mut SqliteConnection) -> Result<BTreeMap<i64, Person>, Fault> {
    let sql = "SELECT id, name, must_change, language FROM person";
    let rows: Vec<(i64, String, bool, Option<String>)> = sqlx::query_as(sql).fetch_all(&mut *db).await?;
    let mut people = BTreeMap::new();
    for (id, name, must_change_password, language) in rows {
        // An unknown language counts as none: the browser's is used.
        let language = language.and_then(|code| Language::by_code(&code));
        let grants = persons::grants(db, id).await?;
        people.insert(id, Person { name, must_change_password, grants, language });
    }
    Ok(people)
}

async fn read_sessions(db: &mut SqliteConnection, before: &Book) -> Result<BTreeMap<Hash, Session>, Fault> {
    let sql = "SELECT hash, id, person, created_us, seen_us FROM session";
    let rows: Vec<(Vec<u8>, i64, i64, i64, i64)> = sqlx::query_as(sql).fetch_all(db).await?;
    let mut sessions = BTreeMap::new();
    for (hash, id, person, created_us, seen_us) in rows {
        let hash = whole(hash)?;
        let used = before.sessions.get(&hash).map(|one| Arc::clone(&one.used));
        let used = used.unwrap_or_else(|| Used::new(seen_us));
        sessions.insert(hash, Session { id, person, created_us, used });
    }
    Ok(sessions)
}

/// A row of the table of tokens: hash, person, vessel, role, number, label, end, last use.
type TokenRow = (Vec<u8>, Option<i64>, i64, Option<i64>, i64, String, Option<i64>, Option<i64>);

async fn read_tokens(db: &mut SqliteConnection, before: &Book) -> Result<BTreeMap<Hash, Token>, Fault> {
    let sql = "SELECT hash, person, vessel, role, id, label, expires_us, used_us FROM token";
    let rows: Vec<TokenRow> = sqlx::query_as(sql).fetch_all(db).await?;
    let mut tokens = BTreeMap::new();
    for (hash, person, vessel, role, id, label, expires_us, used_us) in rows {
        let hash = whole(hash)?;
        let Some(opens) = opened((person, vessel, role)) else { continue };
        let used = before.tokens.get(&hash).map(|one| Arc::clone(&one.used));
        let used = used.unwrap_or_else(|| Used::new(used_us.unwrap_or(0)));
        tokens.insert(hash, Token { id, label, expires_us, opens, used });
    }
    Ok(tokens)
}

/// A stored hash; no program makes one of another length.
fn whole(hash: Vec<u8>) -> Result<Hash, Fault> {
    hash.try_into().map_err(|_| sqlx::Error::Decode("a hash has another length than SHA-256".into()).into())
}

/// The access given by a row of the table of tokens; `None` for an invalid one.
fn opened((person, vessel, role): (Option<i64>, i64, Option<i64>)) -> Option<Opens> {
    match (person, role) {
        (Some(person), Some(role)) => {
            Some(Opens::Api { person, vessel: u16::try_from(vessel).ok(), role: persons::role(role)? })
        }
        _ => u16::try_from(vessel).ok().map(Opens::Link),
    }
}

#[cfg(test)]
mod tests;
