//! Making, listing and revoking links, for users who may change a dataset.

use super::contents::content_of;
use super::links;
use super::service::{is_not_withdrawn, malformed};
use super::shares::path_for_account;
use super::{Datasets, find_version};
use crate::error::{Error, ErrorKind, Result};
use crate::identity::{Fault, Principal, Secret, password, persons};
use crate::logbook::check_text;
use api::{
    DatasetContent, DatasetShare, DatasetShareMade, DatasetShareRequest, DatasetVersion, LogWord, Said,
    ShareVisit, say,
};
use research::Limits;

/// Most characters of a link's label.
const LABEL: usize = 100;
/// Least characters of a link's password: it is given to its user, not chosen by them.
const PASSWORD: usize = 8;
/// Most days that a link is valid.
const DAYS: u32 = 730;
const DAY_US: i64 = 86_400_000_000;

impl Datasets {
    /// Links of a dataset, the newest first.
    ///
    /// # Errors
    /// The person may not see them.
    pub async fn shares(&self, who: &Principal, id: i64) -> Result<Vec<DatasetShare>> {
        self.changeable(who, id).await?;
        Ok(self.people.ask(links::Of(id)).await?)
    }

    /// How a link of a dataset was used, the newest first.
    ///
    /// # Errors
    /// The person may not see it.
    pub async fn visits(&self, who: &Principal, id: i64, share: i64) -> Result<Vec<ShareVisit>> {
        self.changeable(who, id).await?;
        Ok(self.people.ask(links::Visits { dataset: id, share }).await?)
    }

    /// Makes a link.
    ///
    /// # Errors
    /// The person may not, the named field is not valid, or the link would give no data.
    pub async fn share(
        &self,
        who: &Principal,
        from: String,
        id: i64,
        asked: DatasetShareRequest,
    ) -> Result<DatasetShareMade> {
        let dataset = self.changeable(who, id).await?;
        is_not_withdrawn(&dataset, None)?;
        let newest = dataset.versions.first().map(|version| version.number);
        let number = asked.version.or(newest);
        let number = number.ok_or_else(|| Error::refused(say("It has no version yet: publish it first.")))?;
        let version = find_version(&dataset.versions, number)?;
        let mut share = self.checked_share(who, &asked, version)?;
        let mut person = None;
        if let Some(name) = share.person.take() {
            let (number, name) = self.account(name).await?;
            (person, share.person) = (Some(number), Some(name));
        }
        share.content = self.shared_content(version, &share).await?;
        if share.content.rows == 0 {
            return Err(Error::refused(say("The link would give no detections: leave out less.")));
        }
        // The link's page compares with the present archive: earlier changes are reported too.
        let check = self.check_now(id, version).await?;
        share.had_changed = !check.is_same && check.written_by.is_none();
        let kept =
            if asked.password.is_empty() { None } else { Some(self.people.hash(asked.password).await?) };
        let secret = Secret::random();
        let subject = format!("{id} {}, version {number}, for {}", version.title, share.label);
        let add = links::Add { dataset: id, hash: secret.hash(), password: kept, person, share };
        let number = self.act(who, from, "dataset.share", subject, add).await?;
        let share = self.people.ask(links::Of(id)).await?.into_iter().find(|share| share.id == number);
        let share = share.ok_or_else(|| Error::new(ErrorKind::NotFound, say("The link is gone.")))?;
        let path = match person {
            Some(_) => path_for_account(number),
            None => format!("/s/{}", secret.text()),
        };
        Ok(DatasetShareMade { share, path })
    }

    /// The number of the account of this name, and the name as the account has it.
    async fn account(&self, name: String) -> Result<(i64, String)> {
        let unknown = malformed(
            say("person: there is no account {name}; ask an admin to make one").with("name", &name),
        );
        match self.people.ask(persons::Named(name)).await {
            Err(Fault::Refused(_)) => Err(unknown),
            found => Ok(found?),
        }
    }

    /// Validates a requested link.
    fn checked_share(
        &self,
        who: &Principal,
        asked: &DatasetShareRequest,
        version: &DatasetVersion,
    ) -> Result<DatasetShare> {
        let label = check_text("label", &asked.label, 1..=LABEL)?;
        if !(1..=DAYS).contains(&asked.days) {
            return Err(malformed(say("days: a link opens 1 to {days} days").with("days", DAYS)));
        }
        if !asked.password.is_empty() {
            password::check_new("lutra", &asked.password, PASSWORD)
                .map_err(|text| malformed(text.of_field("password")))?;
        }
        let person = asked.person.as_deref().map(str::trim).filter(|name| !name.is_empty());
        if person.is_some() && !asked.password.is_empty() {
            return Err(malformed(say(
                "password: a link for one account is opened by logging in; leave the password out",
            )));
        }
        for (field, time) in [("from_us", asked.from_us), ("to_us", asked.to_us)] {
            if time.is_some_and(|time| !(0..=9_007_199_254_740_991).contains(&time)) {
                return Err(malformed(
                    Said::from(say("is not a time from 1970 to 2255; give µs since 1970 UTC"))
                        .of_field(field),
                ));
            }
        }
        if asked.from_us.zip(asked.to_us).is_some_and(|(from, to)| to <= from) {
            return Err(malformed(say("to_us: the end is not after the beginning")));
        }
        let tags: Vec<String> =
            asked.tags.iter().map(|tag| tag.trim().to_owned()).filter(|tag| !tag.is_empty()).collect();
        if tags.len() > 200 {
            return Err(malformed(
                Said::from(
                    say("there are {count}; at most {most} are allowed")
                        .with("count", tags.len())
                        .with("most", 200),
                )
                .of_field("tags"),
            ));
        }
        Limits::new(&tags, &asked.area, asked.precision_m, false).map_err(malformed)?;
        if asked.precision_m.is_some() && !version.query.area.trim().is_empty() {
            let text = say(
                "precision_m: the version is of an area, and what is given would tell on which side of its border an animal was. \
                        Publish a version without an area, and give the area to the link.",
            );
            return Err(malformed(text));
        }
        let now_us = self.clock.utc().micros();
        Ok(DatasetShare {
            id: 0,
            version: version.number,
            label,
            has_password: !asked.password.is_empty(),
            person: person.map(str::to_owned),
            expires_us: now_us + i64::from(asked.days) * DAY_US,
            from_us: asked.from_us,
            to_us: asked.to_us,
            tags,
            area: asked.area.trim().to_owned(),
            precision_m: asked.precision_m,
            content: DatasetContent::default(),
            had_changed: false,
            made: LogWord { by: who.name.clone(), time_us: now_us },
            revoked: None,
            views: 0,
            downloads: 0,
            used_us: None,
        })
    }

    /// The content that a link gives: that of the version if it leaves nothing out.
    async fn shared_content(&self, version: &DatasetVersion, share: &DatasetShare) -> Result<DatasetContent> {
        let is_whole = share.from_us.is_none()
            && share.to_us.is_none()
            && share.tags.is_empty()
            && share.area.is_empty()
            && share.precision_m.is_none();
        if is_whole {
            return Ok(version.content.clone());
        }
        let frozen = self.frozen(version, Some(share), None).await?;
        content_of(&self.history, frozen).await
    }

    /// Revokes a link.
    ///
    /// # Errors
    /// The person may not, or it is revoked already.
    pub async fn revoke(&self, who: &Principal, from: String, id: i64, share: i64) -> Result<()> {
        self.changeable(who, id).await?;
        let known = self.people.ask(links::Of(id)).await?.into_iter().find(|one| one.id == share);
        let known = known.ok_or_else(|| Error::new(ErrorKind::NotFound, say("There is no such link.")))?;
        let subject = format!("{id}, link {share} for {}", known.label);
        let revoke = links::Revoke { dataset: id, share, by: who.name.clone(), now: self.clock.utc() };
        self.act(who, from, "dataset.share.revoke", subject, revoke).await
    }
}
