//! Rules: which alarms a person wants to be notified of, and their validation.

use super::settings::{Settings, Webhooks};
use api::{Wording, say};
use hyper::Uri;
use operations::alarms::Priority;
use std::time::Duration;

/// Most messages of one rule within an hour.
pub const PER_HOUR: usize = 10;
/// Longest delay of a rule for an acknowledgement.
const LONGEST: Duration = Duration::from_hours(24);
/// Most characters of a target.
const TARGET_CHARS: usize = 500;

/// How a message is sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// To a mail address.
    Mail,
    /// To a URL.
    Webhook,
}

impl Way {
    /// The word for people and app.db.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Mail => "mail",
            Self::Webhook => "webhook",
        }
    }

    /// The way of this name.
    pub fn named(name: &str) -> Option<Self> {
        [Self::Mail, Self::Webhook].into_iter().find(|one| one.name() == name)
    }
}

/// A rule as requested. Its target is not shown in logs: a URL may contain a secret.
#[derive(Clone, PartialEq, Eq)]
pub struct RuleRequest {
    /// How.
    pub way: Way,
    /// A mail address, or a URL.
    pub target: String,
    /// The least priority that is reported.
    pub least: Priority,
    /// IMC address of the vessel; `None` for all that the person may see, and the server itself.
    pub vessel: Option<u16>,
    /// How long an alarm must be active without an acknowledgement before it is reported.
    pub after: Duration,
    /// Whether the end of a reported alarm is reported too.
    pub also_over: bool,
}

impl std::fmt::Debug for RuleRequest {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} to {}, {} and more", self.way.name(), self.shown_target(), self.least.name())
    }
}

/// A change of an existing rule: everything but its way.
#[derive(Clone, PartialEq, Eq)]
pub struct RuleChange {
    /// A mail address, or a URL, as the rule's way has it.
    pub target: String,
    /// As in [`RuleRequest`].
    pub least: Priority,
    /// As in [`RuleRequest`].
    pub vessel: Option<u16>,
    /// As in [`RuleRequest`].
    pub after: Duration,
    /// As in [`RuleRequest`].
    pub also_over: bool,
}

impl RuleChange {
    /// The resulting rule of this way.
    pub fn of(self, way: Way) -> RuleRequest {
        let Self { target, least, vessel, after, also_over } = self;
        RuleRequest { way, target, least, vessel, after, also_over }
    }
}

impl From<RuleRequest> for RuleChange {
    fn from(RuleRequest { target, least, vessel, after, also_over, .. }: RuleRequest) -> Self {
        Self { target, least, vessel, after, also_over }
    }
}

/// Key that signs a webhook's messages. Not shown in logs.
#[derive(Clone, PartialEq, Eq)]
pub(super) struct SigningKey(pub(super) String);

impl std::fmt::Debug for SigningKey {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("SigningKey(…)")
    }
}

/// A stored rule.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rule {
    /// Its number.
    pub id: i64,
    /// Its owner.
    pub person: i64,
    /// Its content.
    pub ask: RuleRequest,
    /// When it was made, µs since 1970 UTC: alarms from before then send no message.
    pub made_us: i64,
    /// Key that signs a webhook's messages; never shown again.
    pub(super) key: SigningKey,
}

impl RuleRequest {
    /// Its target for logs: only the host of a URL.
    pub(super) fn shown_target(&self) -> String {
        match self.way {
            Way::Mail => self.target.clone(),
            Way::Webhook => {
                let url = self.target.parse::<Uri>().ok();
                url.as_ref().and_then(|url| url.host()).unwrap_or_default().to_owned()
            }
        }
    }

    /// Checks that this server supports the rule.
    ///
    /// # Errors
    /// What is wrong, with the remedy.
    pub fn check(&self, settings: &Settings) -> Result<(), Wording> {
        if self.after > LONGEST {
            return Err(say("An alarm may wait for an acknowledgement for 24 hours at most."));
        }
        self.check_target(settings)
    }

    /// Checks that this server can send to the target.
    ///
    /// # Errors
    /// What is wrong, with the remedy.
    pub fn check_target(&self, settings: &Settings) -> Result<(), Wording> {
        if self.target.chars().count() > TARGET_CHARS {
            return Err(say("Where to: {most} letters at most.").with("most", TARGET_CHARS));
        }
        match self.way {
            Way::Mail if settings.mail.host.is_empty() => Err(say(
                "This server sends no mail: its configuration names no mail server (notices.mail.host).",
            )),
            Way::Mail => match self.target.parse::<lettre::Address>() {
                Ok(_) => Ok(()),
                Err(_) => Err(say("\"{text}\" is not an e-mail address; give one like name@example.org.")
                    .with("text", &self.target)),
            },
            Way::Webhook => self.check_url(settings.webhooks),
        }
    }

    fn check_url(&self, webhooks: Webhooks) -> Result<(), Wording> {
        let url = self.target.parse::<Uri>();
        let Some(url) = url.ok().filter(|url| url.host().is_some() && url.scheme().is_some()) else {
            return Err(say("\"{text}\" is not a URL; give one like https://example.org/hook.")
                .with("text", &self.target));
        };
        if url.authority().is_some_and(|authority| authority.as_str().contains('@')) {
            return Err(say("A URL with a password in it is not kept: leave out what stands before the @."));
        }
        match (webhooks, url.scheme_str()) {
            (Webhooks::Off, _) => Err(say("This server sends no webhooks (notices.webhooks).")),
            (_, Some("https")) | (Webhooks::Any, Some("http")) => Ok(()),
            _ => Err(say("A webhook's URL begins with https://.")),
        }
    }
}
