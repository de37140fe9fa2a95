//! Access rules of datasets, and their life cycle.
//!
//! A dataset belongs to vessels. Researchers of all of these may change, publish, share and download it; users who may see
//! all of them may read its published versions.

use super::checks::Checks;
use super::contents::{CANONICAL, Frozen, content_of, recorded};
use super::places::LinkPlaces;
use super::rows::{Create, Listed, Publish, Row, SetDraft, Withdraw};
use crate::clock::Clock;
use crate::error::{Error, ErrorKind, Result};
use crate::history::History;
use crate::identity::{People, Principal, Request};
use crate::logbook::{NEWER, check_text};
use crate::register::Register;
use api::{
    Dataset, DatasetAuthor, DatasetChange, DatasetContent, DatasetDraft, DatasetQuery, DatasetShare,
    DatasetState, DatasetVersion, DatasetVessel, DatasetWithdrawal, DatasetWithdrawn, LogWord, Role, Said,
    Wording, say,
};
use research::{Study, check_draft, citation, lacking};

/// Most characters of a reason.
const REASON: usize = 2_000;

/// The datasets; cheap to clone.
#[derive(Clone)]
pub struct Datasets {
    pub(super) people: People,
    pub(super) clock: Clock,
    pub(super) history: History,
    register: Register,
    pub(super) checks: Checks,
    pub(super) places: LinkPlaces,
}

impl Datasets {
    pub(crate) fn new(people: People, clock: Clock, history: History, register: Register) -> Self {
        Self { people, clock, history, register, checks: Checks::default(), places: LinkPlaces::default() }
    }

    /// Those that the person may see, the newest first.
    ///
    /// # Errors
    /// app.db cannot be read.
    pub async fn list(&self, who: &Principal) -> Result<Vec<Dataset>> {
        let rows = self.people.ask(Listed(None)).await?;
        Ok(rows.into_iter().filter_map(|row| told(who, row)).collect())
    }

    /// One of them.
    ///
    /// # Errors
    /// It does not exist, or the person may not see it.
    pub async fn one(&self, who: &Principal, id: i64) -> Result<Dataset> {
        let row = self.people.ask(Listed(Some(id))).await?.into_iter().next();
        row.and_then(|row| told(who, row)).ok_or_else(|| {
            Error::new(ErrorKind::NotFound, say("There is no such dataset; GET /api/v1/datasets lists them."))
        })
    }

    /// A published version of one.
    ///
    /// # Errors
    /// It does not exist, or the person may not see it; or it was withdrawn: then only title, citation and reason remain.
    pub async fn version(&self, who: &Principal, id: i64, number: u32) -> Result<DatasetVersion> {
        let dataset = self.one(who, id).await?;
        let version = find_version(&dataset.versions, number)?;
        is_not_withdrawn(&dataset, Some(version))?;
        Ok(version.clone())
    }

    /// Makes a dataset.
    ///
    /// # Errors
    /// The person may not, or the named field is not valid.
    pub async fn create(&self, who: &Principal, from: String, draft: DatasetDraft) -> Result<Dataset> {
        let (_, study) = self.register.study().await?;
        let draft = checked(draft, &study)?;
        may(who, &draft.query.vessels)?;
        let (subject, by, now) = (draft.title.clone(), who.name.clone(), self.clock.utc());
        let create = Create { draft, by, now };
        let id = self.people.act(who, from, "dataset.create", subject, create).await?;
        self.one(who, id).await
    }

    /// Replaces the draft.
    ///
    /// # Errors
    /// The person may not, there is no draft, it was changed meanwhile, or the named field is not valid.
    pub async fn change(
        &self,
        who: &Principal,
        from: String,
        id: i64,
        change: DatasetChange,
    ) -> Result<Dataset> {
        let dataset = self.mine(who, id, change.revision).await?;
        if dataset.draft.is_none() {
            let text = say("What is published never changes. Make a new version, and change that.");
            return Err(Error::refused(text));
        }
        let (_, study) = self.register.study().await?;
        let draft = checked(change.draft, &study)?;
        may(who, &draft.query.vessels)?;
        let subject = format!("{id} {}", draft.title);
        self.act(who, from, "dataset.change", subject, SetDraft { id, revision: change.revision, draft })
            .await?;
        self.one(who, id).await
    }

    /// Makes a draft of the newest version, to be changed and published as the next one.
    ///
    /// # Errors
    /// The person may not, there is a draft already, or no version yet.
    pub async fn new_version(
        &self,
        who: &Principal,
        from: String,
        id: i64,
        revision: u32,
    ) -> Result<Dataset> {
        let dataset = self.mine(who, id, revision).await?;
        if dataset.draft.is_some() {
            return Err(Error::refused(say("There is a draft already: change or publish that.")));
        }
        let version = dataset.versions.first();
        let version =
            version.ok_or_else(|| Error::refused(say("It has no version yet: publish it first.")))?;
        let draft = draft_of(version);
        let subject = format!("{id} {}", draft.title);
        self.act(who, from, "dataset.version", subject, SetDraft { id, revision, draft }).await?;
        self.one(who, id).await
    }

    /// Publishes the draft: freezes its question, counts its rows and hashes its canonical CSV.
    ///
    /// # Errors
    /// The person may not, the draft lacks what the text names, it has no detections, or it was changed meanwhile.
    pub async fn publish(&self, who: &Principal, from: String, id: i64, revision: u32) -> Result<Dataset> {
        let dataset = self.mine(who, id, revision).await?;
        let draft = dataset.draft.ok_or_else(|| {
            Error::refused(say("Nothing is waiting to be published. Make a new version first."))
        })?;
        let (register, study) = self.register.study().await?;
        let draft = checked(draft, &study)?;
        let wrong = lacking(&draft);
        if !wrong.is_empty() {
            return Err(malformed(told_wrong(wrong)));
        }
        let number = dataset.versions.first().map_or(0, |version| version.number) + 1;
        let mut version = self.frozen_version(who, draft, number, &study).await?;
        let frozen = Frozen::new(&version, None, Some(CANONICAL), (register, study))?;
        version.content = content_of(&self.history, frozen).await?;
        if version.content.rows == 0 {
            let text = say("It has no detections. Choose a longer time, more vessels, or all tags.");
            return Err(Error::refused(text));
        }
        version.citation = citation(&version);
        let subject = format!("{id} {}, version {number}, {} rows", version.title, version.content.rows);
        self.act(who, from, "dataset.publish", subject, Publish { id, revision, version }).await?;
        self.one(who, id).await
    }

    /// The version that a draft becomes, before its file is computed.
    async fn frozen_version(
        &self,
        who: &Principal,
        draft: DatasetDraft,
        number: u32,
        study: &Study,
    ) -> Result<DatasetVersion> {
        let now_us = self.clock.utc().micros();
        let mut query = draft.query;
        if query.vessels.is_empty() {
            query.vessels = recorded(&self.history).await?;
        }
        if query.vessels.is_empty() {
            return Err(Error::refused(say("Nothing is recorded yet that could be published.")));
        }
        query.to_us = Some(query.to_us.map_or(now_us, |to_us| to_us.min(now_us)));
        let named = self.people.vessels();
        let name = |system: u16| {
            let found = named.iter().find(|vessel| vessel.address == system);
            DatasetVessel { system, name: found.map(|vessel| vessel.name.clone()).unwrap_or_default() }
        };
        let person = |name: &String| {
            let person = study.person_named(name);
            let of =
                |text: fn(&api::RegisterPerson) -> &String| person.map(text).cloned().unwrap_or_default();
            DatasetAuthor {
                name: name.clone(),
                orcid: of(|person| &person.orcid),
                affiliation: of(|person| &person.affiliation),
            }
        };
        Ok(DatasetVersion {
            number,
            title: draft.title,
            description: draft.description,
            publisher: draft.publisher,
            authors: draft.authors.iter().map(person).collect(),
            licence: draft.licence,
            embargo_until: draft.embargo_until,
            doi: draft.doi,
            vessels: query.vessels.iter().copied().map(name).collect(),
            query,
            content: DatasetContent::default(),
            published: LogWord { by: who.name.clone(), time_us: now_us },
            citation: String::new(),
        })
    }

    /// Withdraws a dataset: it stays listed, its links end, and its data cannot be downloaded.
    ///
    /// # Errors
    /// The person may not, no reason is given, or it was changed meanwhile.
    pub async fn withdraw(
        &self,
        who: &Principal,
        from: String,
        id: i64,
        asked: DatasetWithdrawal,
    ) -> Result<Dataset> {
        let dataset = self.mine(who, id, asked.revision).await?;
        let reason = check_text("reason", &asked.reason, 1..=REASON)?;
        let title = dataset.versions.first().map(|version| version.title.clone());
        let title = title.or(dataset.draft.map(|draft| draft.title)).unwrap_or_default();
        let (by, now) = (who.name.clone(), self.clock.utc());
        let withdraw = Withdraw { id, revision: asked.revision, by, reason, now };
        self.act(who, from, "dataset.withdraw", format!("{id} {title}"), withdraw).await?;
        self.one(who, id).await
    }

    /// The inputs of a file of a published version.
    ///
    /// # Errors
    /// There is no such version, or the person may not see it; it was withdrawn; or the format does not exist.
    pub async fn file(&self, who: &Principal, id: i64, number: u32, format: Option<&str>) -> Result<Frozen> {
        let dataset = self.one(who, id).await?;
        let version = find_version(&dataset.versions, number)?;
        may(who, &version.query.vessels)?;
        is_not_withdrawn(&dataset, Some(version))?;
        self.frozen(version, None, format).await
    }

    pub(super) async fn frozen(
        &self,
        version: &DatasetVersion,
        share: Option<&DatasetShare>,
        format: Option<&str>,
    ) -> Result<Frozen> {
        Frozen::new(version, share, Some(format.unwrap_or(CANONICAL)), self.register.study().await?)
    }

    pub(super) async fn act<R: Request>(
        &self,
        who: &Principal,
        from: String,
        action: &'static str,
        subject: String,
        request: R,
    ) -> Result<R::Answer> {
        Ok(self.people.act(who, from, action, subject, request).await?)
    }

    /// A dataset that the person may change.
    pub(super) async fn changeable(&self, who: &Principal, id: i64) -> Result<Dataset> {
        let dataset = self.one(who, id).await?;
        if dataset.may_change {
            return Ok(dataset);
        }
        let text = say("This takes the role researcher on all vessels of the dataset. Ask an admin.");
        Err(Error::new(ErrorKind::Forbidden, text))
    }

    /// A dataset that is at this revision, not withdrawn, and that the person may change.
    async fn mine(&self, who: &Principal, id: i64, revision: u32) -> Result<Dataset> {
        let dataset = self.changeable(who, id).await?;
        is_not_withdrawn(&dataset, None)?;
        if dataset.revision != revision {
            return Err(Error::new(ErrorKind::Newer, NEWER));
        }
        Ok(dataset)
    }
}

pub(super) fn find_version(versions: &[DatasetVersion], number: u32) -> Result<&DatasetVersion> {
    versions.iter().find(|version| version.number == number).ok_or_else(|| {
        Error::new(
            ErrorKind::NotFound,
            say("The dataset has no such version; GET /api/v1/datasets/{id} lists them."),
        )
    })
}

pub(super) fn is_not_withdrawn(dataset: &Dataset, version: Option<&DatasetVersion>) -> Result<()> {
    let Some(withdrawn) = &dataset.withdrawn else { return Ok(()) };
    let text = match version {
        None => say("The dataset was withdrawn: {reason}"),
        Some(DatasetVersion { title, citation, .. }) => {
            say("The dataset was withdrawn: {reason}\nTitle: {title}\nCitation: {citation}")
                .with("title", title)
                .with("citation", citation)
        }
    };
    let text = text.with("reason", &withdrawn.reason);
    Err(Error::new(ErrorKind::Gone, text))
}

/// Validates a draft.
fn checked(mut draft: DatasetDraft, study: &Study) -> Result<DatasetDraft> {
    let wrong = check_draft(&mut draft, study);
    if wrong.is_empty() { Ok(draft) } else { Err(malformed(told_wrong(wrong))) }
}

fn told_wrong(wrong: Vec<(&str, Wording)>) -> Said {
    Said::lines(wrong.into_iter().map(|(field, text)| Said::from(text).of_field(field)))
}

/// The draft with which a next version begins.
fn draft_of(version: &DatasetVersion) -> DatasetDraft {
    DatasetDraft {
        title: version.title.clone(),
        description: version.description.clone(),
        publisher: version.publisher.clone(),
        authors: version.authors.iter().map(|author| author.name.clone()).collect(),
        licence: version.licence.clone(),
        embargo_until: version.embargo_until.clone(),
        // A DOI is that of one version.
        doi: String::new(),
        query: version.query.clone(),
    }
}

/// Whether a user has a role on all of these vessels; an empty list means all vessels.
fn has(who: &Principal, vessels: &[u16], role: Role) -> bool {
    if vessels.is_empty() {
        return who.grants.everywhere() >= Some(role);
    }
    vessels.iter().all(|vessel| who.grants.on(*vessel) >= Some(role))
}

fn may(who: &Principal, vessels: &[u16]) -> Result<()> {
    if has(who, vessels, Role::Researcher) {
        return Ok(());
    }
    let text = if vessels.is_empty() {
        say(
            "vessels: a dataset of all vessels takes the role researcher on all of them; name those of which you are researcher",
        )
    } else {
        say("vessels: this takes the role researcher on each of the dataset's vessels. Ask an admin.")
    };
    Err(Error::new(ErrorKind::Forbidden, text))
}

/// A dataset as this person gets it; `None` where they may see nothing of it.
fn told(who: &Principal, row: Row) -> Option<Dataset> {
    let Row { id, revision, draft, by, made_us, withdrawn, versions } = row;
    let may_change = draft
        .iter()
        .map(|draft| &draft.query)
        .chain(versions.iter().map(|one| &one.query))
        .all(|query| has(who, &query.vessels, Role::Researcher));
    let draft = draft.filter(|_| may_change);
    let sees = |version: &DatasetVersion| has(who, &version.query.vessels, Role::Viewer);
    let mut versions: Vec<DatasetVersion> = versions.into_iter().filter(sees).collect();
    if withdrawn.is_some() && !may_change {
        // Title, citation and reason stay; the figures and the question belong to the data.
        for version in &mut versions {
            (version.content, version.query) = (DatasetContent::default(), DatasetQuery::default());
            (version.vessels, version.description) = (Vec::new(), String::new());
        }
    }
    if draft.is_none() && versions.is_empty() {
        return None;
    }
    let state = match (&withdrawn, versions.is_empty()) {
        (Some(_), _) => DatasetState::Withdrawn,
        (None, true) => DatasetState::Draft,
        (None, false) => DatasetState::Published,
    };
    let withdrawn =
        withdrawn.map(|(by, time_us, reason)| DatasetWithdrawn { written: LogWord { by, time_us }, reason });
    let made = LogWord { by, time_us: made_us };
    Some(Dataset { id, revision, state, made, draft, versions, withdrawn, may_change })
}

pub(super) fn malformed(text: impl Into<Said>) -> Error {
    Error::new(ErrorKind::Malformed, text)
}
