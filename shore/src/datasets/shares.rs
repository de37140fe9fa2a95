//! What a client gets by a link.
//!
//! The address opens one version of one dataset, within the limits of the link. Roles are never considered: a user with every
//! role gets no more by a link than a stranger. A link for an account opens to that account alone; its address is no secret.

use super::contents::Frozen;
use super::links::{By, ForPerson, Led, Visit};
use super::{Datasets, find_version};
use crate::error::Result;
use crate::identity::{Principal, Refused, Secret, Via, same};
use api::{DatasetCheck, DatasetShare, DatasetVersion, Said, ShareVisit, ShareVisitKind, SharedDataset, say};
use research::embargo_us;
use std::net::IpAddr;
use std::time::Duration;

/// Begins the last part of the address of a link for an account, before its number.
const FOR_ACCOUNT: &str = "account-";
/// How long a correct password opens a link in a browser (µs).
const OPEN_US: i64 = 43_200_000_000;

/// Why a link gives nothing.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ShareClosed {
    /// There is no link with this address.
    #[error("There is no link with this address. Check that all of it was copied, or ask for a new one.")]
    Unknown,
    /// It was revoked.
    #[error("This link was revoked by those who made it. Ask them for a new one.")]
    Revoked,
    /// Its time is over.
    #[error("This link has ended. Ask those who made it for a new one.")]
    Expired,
    /// The dataset was withdrawn, and why.
    #[error("The dataset was withdrawn: {0}")]
    Withdrawn(String),
    /// The dataset of a link with a password was withdrawn: the reason is only for those who have the password.
    #[error("The dataset was withdrawn. Ask those who sent you this link.")]
    WithdrawnUntold,
    /// It is for an account, and the client is not logged in, or has not yet changed a one-time password.
    #[error("This link is for one account: log in.")]
    LogIn,
    /// Links were opened too often from this address.
    #[error("Links are opened too often from your network. Try again in {} s.", .0.as_secs() + 1)]
    Wait(Duration),
}

impl ShareClosed {
    /// The same with its wording.
    pub fn said(&self) -> Said {
        match self {
            Self::Unknown => say(
                "There is no link with this address. Check that all of it was copied, or ask for a new one.",
            ),
            Self::Revoked => say("This link was revoked by those who made it. Ask them for a new one."),
            Self::Expired => say("This link has ended. Ask those who made it for a new one."),
            Self::Withdrawn(reason) => say("The dataset was withdrawn: {reason}").with("reason", reason),
            Self::WithdrawnUntold => say("The dataset was withdrawn. Ask those who sent you this link."),
            Self::LogIn => say("This link is for one account: log in."),
            Self::Wait(wait) => say("Links are opened too often from your network. Try again in {n} s.")
                .with("n", wait.as_secs() + 1),
        }
        .into()
    }
}

/// A valid link.
pub struct OpenShare {
    /// The number of its dataset.
    pub dataset: i64,
    /// The link.
    pub share: DatasetShare,
    /// The version that it gives.
    pub version: DatasetVersion,
    /// End of the embargo (µs since 1970 UTC); `None` where the data are available.
    pub embargo_us: Option<i64>,
    /// Absent for a link for an account, which has no password either.
    secret: Option<Secret>,
    /// The password's hash.
    password: Option<String>,
}

impl std::fmt::Debug for OpenShare {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("OpenShare").field("share", &self.share.id).finish_non_exhaustive()
    }
}

impl Datasets {
    /// The link of an address by its last part, for a client who may be logged in as `who`.
    ///
    /// # Errors
    /// app.db cannot be read, or, within, why the link gives nothing.
    pub async fn open(
        &self,
        token: &str,
        address: IpAddr,
        who: Option<&Principal>,
    ) -> Result<std::result::Result<OpenShare, ShareClosed>> {
        if let Err(wait) = self.people.may_open_link(address) {
            return Ok(Err(ShareClosed::Wait(wait)));
        }
        let number = token.strip_prefix(FOR_ACCOUNT).and_then(|number| number.parse().ok());
        let (by, secret) = match (number, Secret::parse(token)) {
            (Some(number), _) => (By::Number(number), None),
            (None, Some(secret)) => (By::Secret(secret.hash()), Some(secret)),
            (None, None) => return Ok(Err(ShareClosed::Unknown)),
        };
        // Before the link is looked up: who is not logged in does not learn which numbers there are.
        if number.is_some() && !who.is_some_and(is_free) {
            return Ok(Err(ShareClosed::LogIn));
        }
        let Some(Led { share, password, person, dataset }) = self.people.ask(by).await? else {
            return Ok(Err(ShareClosed::Unknown));
        };
        if person.is_some() && person != who.map(|who| who.person) {
            return Ok(Err(ShareClosed::Unknown));
        }
        let now_us = self.clock.utc().micros();
        if share.revoked.is_some() {
            return Ok(Err(ShareClosed::Revoked));
        }
        if now_us >= share.expires_us {
            return Ok(Err(ShareClosed::Expired));
        }
        if let Some((_, _, reason)) = dataset.withdrawn {
            let closed = if password.is_none() {
                ShareClosed::Withdrawn(reason)
            } else {
                ShareClosed::WithdrawnUntold
            };
            return Ok(Err(closed));
        }
        let version = find_version(&dataset.versions, share.version)?.clone();
        let embargo_us = embargo_us(&version.embargo_until).filter(|end_us| now_us < *end_us);
        Ok(Ok(OpenShare { dataset: dataset.id, share, version, embargo_us, secret, password }))
    }

    /// What is shared with this account and open, the newest first.
    ///
    /// # Errors
    /// app.db cannot be read.
    pub async fn shared_with(&self, who: &Principal) -> Result<Vec<SharedDataset>> {
        let asked = ForPerson { person: who.person, now: self.clock.utc() };
        let open = self.people.ask(asked).await?;
        open.into_iter()
            .filter(|led| led.dataset.withdrawn.is_none())
            .map(|Led { share, dataset, .. }| {
                let version = find_version(&dataset.versions, share.version)?;
                Ok(SharedDataset {
                    path: path_for_account(share.id),
                    title: version.title.clone(),
                    version: share.version,
                    citation: version.citation.clone(),
                    rows: share.content.rows,
                    embargo_until: version.embargo_until.clone(),
                    made: share.made,
                    expires_us: share.expires_us,
                })
            })
            .collect()
    }

    /// Checks the password of a link; returns the cookie by which the link stays open in this browser.
    ///
    /// # Errors
    /// The password is wrong, or was guessed too often.
    pub async fn unlock(
        &self,
        open: &OpenShare,
        password: String,
        address: IpAddr,
    ) -> std::result::Result<String, Refused> {
        let Some(kept) = &open.password else { return Ok(open.key(self.clock.utc().micros())) };
        let account = format!("link/{}", open.share.id);
        let outcome = self.people.opens(account, password, kept.clone(), address).await;
        if matches!(outcome, Err(Refused::WrongPassword)) {
            let visit = self.visit(open, ShareVisitKind::WrongPassword, address, "");
            self.people.change(visit).await?;
        }
        outcome.map(|()| open.key(self.clock.utc().micros()))
    }

    /// Whether a link is open to a browser with this cookie; always if it has no password.
    pub fn is_unlocked(&self, open: &OpenShare, kept: Option<&str>) -> bool {
        let Some((until, _)) = kept.and_then(|kept| kept.split_once('.')) else {
            return open.password.is_none();
        };
        let until_us = until.parse::<i64>().unwrap_or_default();
        let now_us = self.clock.utc().micros();
        let is_ours = now_us < until_us && same(&open.key_until(until_us), kept.unwrap_or_default());
        open.password.is_none() || is_ours
    }

    /// Records the use of a link, before anything is sent.
    ///
    /// # Errors
    /// app.db cannot be written: then nothing is sent.
    pub async fn note(
        &self,
        open: &OpenShare,
        what: ShareVisitKind,
        address: IpAddr,
        file: &str,
    ) -> Result<()> {
        Ok(self.people.change(self.visit(open, what, address, file)).await?)
    }

    fn visit(&self, open: &OpenShare, what: ShareVisitKind, address: IpAddr, file: &str) -> Visit {
        let time_us = self.clock.utc().micros();
        let visit = ShareVisit { time_us, address: address.to_string(), what, file: file.to_owned() };
        Visit { share: open.share.id, visit }
    }

    /// The inputs of a file that a link gives.
    ///
    /// # Errors
    /// There is no such format, or an entry that the question names no longer exists.
    pub async fn shared_file(&self, open: &OpenShare, format: Option<&str>) -> Result<Frozen> {
        self.frozen(&open.version, Some(&open.share), format).await
    }

    /// Whether the archive still gives the bytes that the link's page names.
    ///
    /// # Errors
    /// Too much else is computed, or the archive cannot be read.
    pub async fn shared_check(&self, open: &OpenShare) -> Result<DatasetCheck> {
        let frozen = self.shared_file(open, None).await?;
        let of = (open.dataset, open.version.number, open.share.id);
        self.checked(of, frozen, &open.share.content).await
    }
}

impl OpenShare {
    /// Name of the cookie.
    pub fn cookie_name(&self) -> String {
        format!("lutra_link_{}", self.share.id)
    }

    fn key(&self, now_us: i64) -> String {
        self.key_until(now_us.saturating_add(OPEN_US))
    }

    /// Derived from the address and from the password's hash, which only the server has.
    fn key_until(&self, until_us: i64) -> String {
        let kept = self.password.as_deref().unwrap_or_default();
        let derived = self.secret.as_ref().map(|secret| secret.derived(&format!("link {until_us} {kept}")));
        format!("{until_us}.{}", derived.unwrap_or_default())
    }
}

/// The path of the page of a link for an account.
pub(super) fn path_for_account(share: i64) -> String {
    format!("/s/{FOR_ACCOUNT}{share}")
}

/// Whether an account is not held up by a one-time password.
fn is_free(who: &Principal) -> bool {
    !matches!(who.via, Via::Session { must_change_password: true, .. })
}
