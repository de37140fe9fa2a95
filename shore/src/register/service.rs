//! The register of studies, with its access rules.
//!
//! Every user who may see a vessel sees the register, but deployments only on vessels that they may see. A deployment is
//! changed by researchers of its vessel; all other entries apply to the whole fleet, and are changed by researchers of all
//! vessels.

use super::import;
use super::rows::{All, Row, Step, Write, sees};
use crate::clock::Clock;
use crate::error::{Error, ErrorKind, Result};
use crate::identity::{People, Principal, vessels};
use crate::logbook::NEWER;
use api::{
    LogWord, RegisterAnswer, RegisterChange, RegisterEntry, RegisterImport, RegisterImportQuery,
    RegisterKind, RegisterRecord, Role, Said, Vessel, say,
};
use imc::Address;
use research::{KINDS, Names, Study, check, differences, kind_of, kind_said, kind_word, name_of, write_csv};
use std::collections::{BTreeMap, BTreeSet};

/// Bytes of a file of entries.
pub const FILE_BYTES: usize = 4 << 20;
/// Most problems in the text of a refused import; the preview has them all.
const TOLD: usize = 20;

/// The register; cheap to clone.
#[derive(Debug, Clone)]
pub struct Register {
    people: People,
    clock: Clock,
}

impl Register {
    pub(crate) fn new(people: People, clock: Clock) -> Self {
        Self { people, clock }
    }

    /// Parses a kind.
    ///
    /// # Errors
    /// There is no such kind; the text lists the kinds.
    pub fn kind(word: &str) -> Result<RegisterKind> {
        let words = KINDS.map(kind_word).join(", ");
        let found = KINDS.into_iter().find(|kind| kind_word(*kind) == word.trim());
        found.ok_or_else(|| {
            let shown: String = word.chars().take(40).collect();
            malformed(
                say("kind: `{kind}` is not one of {kinds}; give one of them")
                    .with("kind", shown)
                    .with("kinds", words),
            )
        })
    }

    /// All entries, or those of a kind, that the person may see.
    ///
    /// # Errors
    /// app.db cannot be read.
    pub async fn entries(&self, who: &Principal, kind: Option<RegisterKind>) -> Result<RegisterAnswer> {
        let (version, rows) = self.people.ask(All).await?;
        let wanted =
            |row: &Row| kind.is_none_or(|kind| kind_of(&row.record) == kind) && sees(who, &row.record);
        let entries = rows.into_iter().filter(wanted).map(|row| told(who, row)).collect();
        Ok(RegisterAnswer { version, entries })
    }

    /// The register's version, and the register for looking up detections.
    ///
    /// # Errors
    /// app.db cannot be read.
    pub async fn study(&self) -> Result<(i64, research::Study)> {
        let (version, rows) = self.people.ask(All).await?;
        Ok((version, super::study(rows)))
    }

    /// A table of a kind.
    ///
    /// # Errors
    /// app.db cannot be read.
    pub async fn csv(&self, who: &Principal, kind: RegisterKind) -> Result<Vec<u8>> {
        let entries = self.entries(who, Some(kind)).await?.entries;
        let named = Called::new(&self.people.vessels());
        Ok(write_csv(kind, entries.iter().map(|entry| &entry.record), &named.names()))
    }

    /// Adds an entry.
    ///
    /// # Errors
    /// The person may not, or the named field is not valid.
    pub async fn create(
        &self,
        who: &Principal,
        from: String,
        record: RegisterRecord,
    ) -> Result<RegisterEntry> {
        let record = checked(record)?;
        may(who, &record)?;
        let subject = subject(&record);
        let id = self.act(who, from, "register.create", subject, vec![Step::Add(record)], None).await?;
        self.one(who, id).await
    }

    /// Changes an entry; its earlier version is kept.
    ///
    /// # Errors
    /// The person may not, it was changed meanwhile, or the named field is not valid.
    pub async fn change(
        &self,
        who: &Principal,
        from: String,
        id: i64,
        change: RegisterChange,
    ) -> Result<RegisterEntry> {
        let row = self.find(who, id).await?;
        let record = checked(change.record)?;
        if kind_of(&record) != kind_of(&row.record) {
            let text = say("kind: this entry is of the kind {kind}; add another one")
                .with_said("kind", kind_said(kind_of(&row.record)));
            return Err(malformed(text));
        }
        may(who, &row.record)?;
        may(who, &record)?;
        if row.revision != change.revision {
            return Err(Error::new(ErrorKind::Newer, NEWER));
        }
        let named = Called::new(&self.people.vessels());
        let changed = differences(&row.record, &record, &named.names());
        if changed.is_empty() {
            return Ok(told(who, row));
        }
        let fields = changed.iter().map(|one| format!("{} `{}` → `{}`", one.column, one.before, one.after));
        let subject = format!("{}: {}", subject(&record), fields.collect::<Vec<_>>().join(", "));
        let steps = vec![Step::Change(id, change.revision, record)];
        self.act(who, from, "register.change", subject, steps, None).await?;
        self.one(who, id).await
    }

    /// Deletes an entry that nothing refers to; its last version is kept in app.db.
    ///
    /// # Errors
    /// The person may not, it was changed meanwhile, or another entry refers to it.
    pub async fn delete(&self, who: &Principal, from: String, id: i64, revision: u32) -> Result<()> {
        let row = self.find(who, id).await?;
        may(who, &row.record)?;
        if row.revision != revision {
            return Err(Error::new(ErrorKind::Newer, NEWER));
        }
        let subject = subject(&row.record);
        self.act(who, from, "register.delete", subject, vec![Step::Delete(id, revision)], None).await?;
        Ok(())
    }

    /// Determines the changes of a file of entries, and applies them if requested and nothing is wrong.
    ///
    /// # Errors
    /// There is no such kind; or the file is to be applied and has problems, or the register was changed meanwhile.
    pub async fn import(
        &self,
        who: &Principal,
        from: String,
        bytes: Vec<u8>,
        query: RegisterImportQuery,
    ) -> Result<RegisterImport> {
        let kind = Self::kind(&query.kind)?;
        let (version, rows) = self.people.ask(All).await?;
        let named = self.people.vessels();
        let asked = who.clone();
        let looked = crate::error::slow(move || {
            let called = Called::new(&named);
            let refusal = |record: &RegisterRecord| may(&asked, record).err().map(|error| error.text);
            import::look(kind, &bytes, (version, &rows), &called.names(), &refusal, &|record| {
                sees(&asked, record)
            })
        });
        let (mut answer, steps) = looked.await?;
        if !query.apply.unwrap_or(false) {
            return Ok(answer);
        }
        let Some(seen) = query.version else {
            let text =
                say("version: give the one in the answer that lists the changes; ask for it without apply");
            return Err(malformed(text));
        };
        if seen != version {
            return Err(Error::new(ErrorKind::Newer, NEWER));
        }
        if !answer.problems.is_empty() {
            return Err(Error::refused(problems(&answer)));
        }
        if !steps.is_empty() {
            let subject =
                format!("{}: {} new, {} changed, by a file", kind_word(kind), answer.added, answer.changed);
            self.act(who, from, "register.import", subject, steps, Some(version)).await?;
            answer.version = version + 1;
        }
        answer.applied = true;
        Ok(answer)
    }

    async fn act(
        &self,
        who: &Principal,
        from: String,
        action: &'static str,
        subject: String,
        steps: Vec<Step>,
        version: Option<i64>,
    ) -> Result<i64> {
        let (by, now) = (who.name.clone(), self.clock.utc());
        let write = Write { steps, version, by, now, asked: Some(who.clone()) };
        Ok(self.people.act(who, from, action, subject, write).await?)
    }

    async fn one(&self, who: &Principal, id: i64) -> Result<RegisterEntry> {
        Ok(told(who, self.find(who, id).await?))
    }

    /// An entry that the person may see.
    async fn find(&self, who: &Principal, id: i64) -> Result<Row> {
        let (_, rows) = self.people.ask(All).await?;
        let row = rows.into_iter().find(|row| row.id == id).filter(|row| sees(who, &row.record));
        row.ok_or_else(|| {
            Error::new(ErrorKind::NotFound, say("There is no such entry; GET /api/v1/register lists them."))
        })
    }
}

/// The address of a vessel by its name or address.
type FindVessel = Box<dyn Fn(&str) -> std::result::Result<u16, Said> + Send>;

/// Names of vessels, in both directions.
pub struct Called {
    name: Box<dyn Fn(u16) -> String + Send>,
    address: FindVessel,
    named: BTreeSet<u16>,
}

/// IMC's addresses of no system and of all.
const NOT_VESSELS: [u16; 2] = [0, 0xFFFF];

impl Called {
    /// From the named vessels.
    pub fn new(named: &[Vessel]) -> Self {
        let by_address: BTreeMap<u16, String> =
            named.iter().map(|vessel| (vessel.address, vessel.name.clone())).collect();
        let known: BTreeMap<Address, Vec<String>> =
            named.iter().map(|vessel| (Address(vessel.address), vec![vessel.name.clone()])).collect();
        let name = move |address: u16| {
            by_address.get(&address).cloned().unwrap_or_else(|| format!("0x{address:04X}"))
        };
        let address = move |text: &str| {
            if let Ok(address) = vessels::address(text) {
                return Ok(address);
            }
            let found = store::system(&known, text);
            found.map(|address| address.0).map_err(|error| Said::as_is(error.to_string()))
        };
        let named = named.iter().map(|vessel| vessel.address).collect();
        Self { name: Box::new(name), address: Box::new(address), named }
    }

    /// The vessel or fixed station of detections, by name or address: one that has a name here, or of which the register has a
    /// deployment.
    ///
    /// # Errors
    /// No such vessel or station is known; the error says what to do. A mistyped address must not make a new vessel.
    pub fn carrier(&self, text: &str, study: &Study) -> std::result::Result<u16, Said> {
        let address = (self.address)(text.trim())?;
        let shown = format!("0x{address:04X}");
        if NOT_VESSELS.contains(&address) {
            return Err(say("0 and 0xFFFF cannot be a vessel's address.").into());
        }
        if self.named.contains(&address) || study.is_carrier(address) {
            return Ok(address);
        }
        let text = say(
            "no vessel or station here has the address {address}: give it a name first (`lutra-server vessel add NAME {address}`), or register the deployment of its receiver",
        );
        Err(text.with("address", shown).into())
    }

    /// For reading and writing files of the register.
    pub fn names(&self) -> Names<'_> {
        Names { address: &*self.address, name: &*self.name }
    }
}

/// Validates an entry.
fn checked(mut record: RegisterRecord) -> Result<RegisterRecord> {
    let wrong = check(&mut record);
    if wrong.is_empty() {
        return Ok(record);
    }
    let told = wrong.into_iter().map(|(column, text)| Said::from(text).of_field(column));
    Err(malformed(Said::lines(told)))
}

/// Checks that a user may make this entry.
fn may(who: &Principal, record: &RegisterRecord) -> Result<()> {
    let (role, place) = match record {
        RegisterRecord::Deployment(one) if one.vessel.is_some() => {
            let vessel = one.vessel.unwrap_or_default();
            (who.grants.on(vessel), say("vessel {vessel}").with("vessel", vessel))
        }
        _ => (who.grants.everywhere(), say("all vessels")),
    };
    if role >= Some(Role::Researcher) {
        return Ok(());
    }
    let text = say("{name}: changing a {kind} takes the role researcher on {place}. Ask an admin.")
        .with("name", name_of(record))
        .with_said("kind", kind_said(kind_of(record)))
        .with_said("place", place);
    Err(Error::new(ErrorKind::Forbidden, text))
}

/// An entry as this person gets it.
fn told(who: &Principal, row: Row) -> RegisterEntry {
    let may_change = may(who, &row.record).is_ok();
    let written = LogWord { by: row.by, time_us: row.written_us };
    RegisterEntry { id: row.id, revision: row.revision, record: row.record, written, may_change }
}

/// Subject for the audit log.
fn subject(record: &RegisterRecord) -> String {
    format!("{} {}", kind_word(kind_of(record)), name_of(record))
}

/// Why a file is refused.
fn problems(answer: &RegisterImport) -> Said {
    let count = answer.problems.len();
    let told = answer.problems.iter().take(TOLD).map(|one| {
        let text = one.says.clone().map_or_else(|| Said::as_is(one.text.clone()), Said::from);
        let text = if one.column.is_empty() { text } else { text.of_field(&one.column) };
        match one.line {
            Some(line) => say("line {line}, {text}").with("line", line).with_said("text", text).into(),
            None => say("the register, {text}").with_said("text", text).into(),
        }
    });
    let more = (count > TOLD).then(|| say("… and {n} more").with("n", count - TOLD).into());
    let text = if count == 1 {
        say("Nothing was imported from the file, which has 1 problem:\n{problems}")
    } else {
        say("Nothing was imported from the file, which has {count} problems:\n{problems}")
    };
    text.with("count", count).with_lines("problems", told.chain(more)).into()
}

fn malformed(text: impl Into<Said>) -> Error {
    Error::new(ErrorKind::Malformed, text)
}
