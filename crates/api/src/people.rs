//! People, what they may do, their sessions and tokens.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// What a person may do. Each role may do all that the ones before it may.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum Role {
    /// See the fleet and its history.
    Viewer,
    /// Export data.
    Researcher,
    /// Command vessels; on all vessels, also import logs.
    Operator,
    /// Manage people, vessels and the server.
    Admin,
}

impl Role {
    /// All roles, the least first.
    pub const ALL: [Self; 4] = [Self::Viewer, Self::Researcher, Self::Operator, Self::Admin];

    /// As written everywhere.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Viewer => "viewer",
            Self::Researcher => "researcher",
            Self::Operator => "operator",
            Self::Admin => "admin",
        }
    }
}

impl std::fmt::Display for Role {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl std::str::FromStr for Role {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|role| role.name() == text);
        found.ok_or_else(|| format!("{text:?} is not a role; it is viewer, researcher, operator or admin"))
    }
}

/// A role on one vessel or on all.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Permission {
    /// IMC address of the vessel; null for all vessels.
    pub vessel: Option<u16>,
    /// What may be done.
    pub role: Role,
}

/// A person with an account.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Person {
    /// Name to log in with.
    pub name: String,
    /// Permissions by vessel.
    pub permissions: Vec<Permission>,
    /// Whether a one-time password is still to be changed.
    pub must_change_password: bool,
    /// When the account was made, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub created_us: i64,
}

/// A browser in which a user is logged in.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Session {
    /// Number to revoke it by.
    #[cfg_attr(test, ts(type = "number"))]
    pub id: i64,
    /// The person.
    pub person: String,
    /// Login, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub created_us: i64,
    /// Last request (to the minute), µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub seen_us: i64,
    /// Address at login.
    pub address: String,
    /// The browser's user agent.
    pub agent: String,
}

/// A token, without its secret.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Token {
    /// Number to revoke it by.
    #[cfg_attr(test, ts(type = "number"))]
    pub id: i64,
    /// What it is for.
    pub label: String,
    /// For whom it acts; null for a vessel's link.
    pub person: Option<String>,
    /// The vessel it is limited to; null for all.
    pub vessel: Option<u16>,
    /// The most it may do; null for a vessel's link.
    pub role: Option<Role>,
    /// When it was made, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub created_us: i64,
    /// When it ends, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub expires_us: Option<i64>,
    /// When it was last used (to the minute), µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub used_us: Option<i64>,
}

/// A request for a token that acts for the requester.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct NewToken {
    /// What it is for.
    pub label: String,
    /// The most it may do.
    pub role: Role,
    /// Limits it to a vessel; null for all.
    pub vessel: Option<u16>,
    /// Days until it ends.
    pub days: u32,
}

/// A new token. Its secret is shown this once.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct TokenMade {
    /// Number to revoke it by.
    #[cfg_attr(test, ts(type = "number"))]
    pub id: i64,
    /// For the header `Authorization: Bearer SECRET`.
    pub secret: String,
}

/// A vessel that may connect by the vessel link.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Vessel {
    /// IMC address.
    pub address: u16,
    /// Name on the pages.
    pub name: String,
}

/// An action that a user carried out or tried.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct AuditEntry {
    /// Number, growing.
    #[cfg_attr(test, ts(type = "number"))]
    pub id: i64,
    /// When, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub time_us: i64,
    /// The person or program that did it.
    pub actor: String,
    /// From which address; `command line` for the program itself.
    pub address: String,
    /// What, like `user.add`.
    pub action: String,
    /// To whom or what.
    pub subject: String,
    /// `done`, or why not.
    pub outcome: String,
}

/// The requester.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Me {
    /// Name to log in with.
    pub name: String,
    /// Permissions by vessel.
    pub permissions: Vec<Permission>,
}
