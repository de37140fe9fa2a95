//! A login from name and password to a session.

use super::audit::Line;
use super::audit::{self, Act};
use super::fault::Fault;
use super::handle::People;
use super::limiter::Guess;
use super::persons::Account;
use super::request::Request;
use super::roles::Principal;
use super::secret::Secret;
use super::sessions::Lifetime;
use super::{persons, sessions};
use api::{Said, say};
use sha2::{Digest as _, Sha256};
use sqlx::SqliteConnection;
use std::net::IpAddr;
use std::time::Duration;
use thiserror::Error;
use units::UtcTime;

/// How long a login may wait for the hashing thread.
const PATIENCE: Duration = Duration::from_secs(10);

/// The data of a login attempt.
#[derive(Debug)]
pub struct Attempt {
    /// The name.
    pub name: String,
    /// The password.
    pub password: String,
    /// From which network address.
    pub address: IpAddr,
    /// The browser's user agent.
    pub agent: String,
    /// The cookie that identifies a known browser.
    pub device: Option<Secret>,
}

/// The cookies of a successful login.
#[derive(Debug)]
pub struct LoggedIn {
    pub session: Secret,
    pub device: Secret,
    pub must_change_password: bool,
}

/// Why a login is refused.
#[derive(Debug, Error)]
pub enum Refused {
    /// Wrong name or password, without saying which.
    #[error("Name or password is wrong.")]
    Wrong,
    /// The old password is wrong.
    #[error("The old password is wrong.")]
    WrongOld,
    /// The password of a link is wrong.
    #[error("The password is wrong.")]
    WrongPassword,
    /// Too many guesses.
    #[error("Too many attempts. Try again in {} s.", .0.as_secs() + 1)]
    Wait(Duration),
    /// The database failed.
    #[error(transparent)]
    Fault(#[from] Fault),
}

impl Refused {
    /// The same with its wording.
    pub fn said(&self) -> Said {
        match self {
            Self::Wrong => say("Name or password is wrong.").into(),
            Self::WrongOld => say("The old password is wrong.").into(),
            Self::WrongPassword => say("The password is wrong.").into(),
            Self::Wait(wait) => {
                say("Too many attempts. Try again in {n} s.").with("n", wait.as_secs() + 1).into()
            }
            Self::Fault(Fault::Refused(why) | Fault::NotYet(why)) => why.clone(),
            Self::Fault(fault) => Said::as_is(fault.to_string()),
        }
    }
}

impl People {
    /// Logs a person in.
    ///
    /// # Errors
    /// [`Refused`].
    pub async fn login(&self, attempt: Attempt) -> Result<LoggedIn, Refused> {
        let Attempt { name, password, address, agent, device } = attempt;
        let (account, device) = self.db.ask(FindAccount { name: name.clone(), device }).await?;
        let account_key: String = name.to_lowercase().chars().take(64).collect();
        let guess = Guess { address, account: account_key, device: device.as_ref().map(Secret::hash) };
        if let Err(wait) = self.limit(|limiter, now| limiter.take(&guess, now)) {
            tracing::warn!(%address, "login refused: too many attempts");
            return Err(Refused::Wait(wait));
        }
        let kept = account.as_ref().map(|account| account.password.clone());
        if !self.is_right(password, kept).await? {
            tracing::warn!(%address, "login refused: wrong name or password");
            let subject = name.chars().take(64).collect::<String>();
            self.write_refusal(address.to_string(), subject, "wrong name or password").await?;
            return Err(Refused::Wrong);
        }
        self.limit(|limiter, _| limiter.give_back(&guess));
        let account = account.ok_or(Refused::Wrong)?;
        let address = address.to_string();
        Ok(self
            .db
            .change(Begin { account, address, agent, device, life: self.life, now: self.clock.utc() })
            .await?)
    }

    /// Checks the password of a logged-in person again.
    ///
    /// # Errors
    /// [`Refused`].
    pub async fn confirm(&self, who: &Principal, password: String, address: IpAddr) -> Result<(), Refused> {
        // The person is logged in, so guesses by strangers do not count: the session takes the place of the known browser.
        let device = Some(Sha256::digest(who.csrf()).into());
        let guess = Guess { address, account: who.name.to_lowercase(), device };
        self.limit(|limiter, now| limiter.take(&guess, now)).map_err(Refused::Wait)?;
        let (account, _) = self.db.ask(FindAccount { name: who.name.clone(), device: None }).await?;
        let Some(account) = account else { return Err(persons::unknown(&who.name).into()) };
        if !self.is_right(password, Some(account.password)).await? {
            self.write_refusal(address.to_string(), who.name.clone(), "wrong password").await?;
            return Err(Refused::WrongOld);
        }
        self.limit(|limiter, _| limiter.give_back(&guess));
        Ok(())
    }

    /// Whether a password matches the hash `kept`, such as that of a link. Guesses are limited as for logins.
    ///
    /// # Errors
    /// [`Refused`].
    pub async fn opens(
        &self,
        what: String,
        password: String,
        kept: String,
        address: IpAddr,
    ) -> Result<(), Refused> {
        let guess = Guess { address, account: what.clone(), device: None };
        if let Err(wait) = self.limit(|limiter, now| limiter.take(&guess, now)) {
            tracing::warn!(%address, what, "not opened: too many attempts");
            return Err(Refused::Wait(wait));
        }
        if !self.is_right(password, Some(kept)).await? {
            tracing::warn!(%address, what, "not opened: wrong password");
            return Err(Refused::WrongPassword);
        }
        self.limit(|limiter, _| limiter.give_back(&guess));
        Ok(())
    }

    /// Takes one use of links from the budget of a network address: each use is recorded, and the client is anonymous.
    ///
    /// # Errors
    /// The time after which to try again.
    pub(crate) fn may_open_link(&self, address: IpAddr) -> Result<(), Duration> {
        self.limit(|limiter, now| limiter.take_link(address, now))
    }

    /// Compares in the hashing thread.
    async fn is_right(&self, password: String, kept: Option<String>) -> Result<bool, Refused> {
        match tokio::time::timeout(PATIENCE, self.hashing.is_right(password, kept)).await {
            Ok(Ok(is_right)) => Ok(is_right),
            Ok(Err(_)) | Err(_) => Err(Refused::Wait(PATIENCE)),
        }
    }

    async fn write_refusal(
        &self,
        address: String,
        subject: String,
        outcome: &'static str,
    ) -> Result<(), Fault> {
        let (actor, outcome) = ("-".to_owned(), outcome.to_owned());
        let line = Line { actor, address, action: "login", subject, outcome };
        self.db.change(audit::Record(vec![(self.clock.utc(), line)])).await
    }
}

/// Looks up the account, and whether the browser's cookie is known for it.
#[derive(Debug)]
struct FindAccount {
    name: String,
    device: Option<Secret>,
}

impl Request for FindAccount {
    type Answer = (Option<Account>, Option<Secret>);

    async fn run(self, db: &mut SqliteConnection) -> Result<Self::Answer, Fault> {
        let account = persons::find(db, &self.name).await?;
        let known = match (&account, &self.device) {
            (Some(account), Some(device)) => sessions::knows_device(db, account.id, device).await?,
            _ => false,
        };
        Ok((account, self.device.filter(|_| known)))
    }
}

/// Begins a session after a correct password.
#[derive(Debug)]
struct Begin {
    account: Account,
    address: String,
    agent: String,
    device: Option<Secret>,
    life: Lifetime,
    now: UtcTime,
}

impl Request for Begin {
    type Answer = LoggedIn;

    async fn run(self, db: &mut SqliteConnection) -> Result<LoggedIn, Fault> {
        let Self { account, address, agent, device, life, now } = self;
        let session = sessions::begin(db, account.id, &address, &agent, life, now).await?;
        let device = device.unwrap_or_else(Secret::random);
        sessions::know_device(db, account.id, &device, now).await?;
        let (actor, subject) = (&account.name, &account.name);
        let act = Act { actor, address: &address, action: "login", subject, outcome: "done" };
        audit::record(db, act, now).await?;
        Ok(LoggedIn { session, device, must_change_password: account.must_change })
    }
}
