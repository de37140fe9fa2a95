//! The requester, and their roles.

use super::language::Language;
use api::{Permission, Role};
use std::collections::BTreeMap;

/// The roles of a person on vessels, by IMC address.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Grants {
    everywhere: Option<Role>,
    vessels: BTreeMap<u16, Role>,
}

impl Grants {
    /// From the permissions in the database.
    pub fn new(permissions: &[Permission]) -> Self {
        let mut grants = Self::default();
        for permission in permissions {
            match permission.vessel {
                None => grants.everywhere = Some(permission.role),
                Some(vessel) => {
                    grants.vessels.insert(vessel, permission.role);
                }
            }
        }
        grants
    }

    /// The role on one vessel.
    pub fn on(&self, vessel: u16) -> Option<Role> {
        self.vessels.get(&vessel).copied().max(self.everywhere)
    }

    /// The role on all vessels.
    pub fn everywhere(&self) -> Option<Role> {
        self.everywhere
    }

    /// The highest role on any vessel.
    pub fn somewhere(&self) -> Option<Role> {
        self.vessels.values().copied().max().max(self.everywhere)
    }

    /// The vessels that are individually granted this role, besides the role on all vessels.
    pub fn vessels_with(&self, least: Role) -> impl Iterator<Item = u16> {
        self.vessels.iter().filter(move |(_, role)| **role >= least).map(|(vessel, _)| *vessel)
    }

    /// These roles, limited for a token to at most `role` on `vessel` (`None`: all).
    #[must_use]
    pub fn limited(&self, vessel: Option<u16>, role: Role) -> Self {
        let least = |own: Role| own.min(role);
        match vessel {
            None => Self {
                everywhere: self.everywhere.map(least),
                vessels: self.vessels.iter().map(|(vessel, own)| (*vessel, least(*own))).collect(),
            },
            Some(vessel) => Self {
                everywhere: None,
                vessels: self.on(vessel).map(|own| (vessel, least(own))).into_iter().collect(),
            },
        }
    }
}

/// How a requester authenticated.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Via {
    /// A browser's session.
    Session {
        /// Its number.
        id: i64,
        /// CSRF token, which every change must repeat, so that no other site can make it.
        csrf: String,
        /// Whether the password must be changed first.
        must_change_password: bool,
    },
    /// A token in the header.
    Token {
        /// Its number.
        id: i64,
        /// What it is for, as given by its creator.
        label: String,
    },
}

/// The requester.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Principal {
    /// The person's number.
    pub person: i64,
    /// Their name.
    pub name: String,
    /// Their roles.
    pub grants: Grants,
    /// The language of their pages; `None` follows what the browser asks for.
    pub language: Option<Language>,
    /// How they authenticated.
    pub via: Via,
}

impl Principal {
    /// Name in the audit log: distinguishes a person's scripts from the person.
    pub fn actor(&self) -> String {
        match &self.via {
            Via::Session { .. } => self.name.clone(),
            Via::Token { label, .. } => format!("{} (token {label})", self.name),
        }
    }

    /// The CSRF token; empty for scripts, which need none.
    pub fn csrf(&self) -> &str {
        match &self.via {
            Via::Session { csrf, .. } => csrf,
            Via::Token { .. } => "",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grants() -> Grants {
        Grants::new(&[
            Permission { vessel: None, role: Role::Viewer },
            Permission { vessel: Some(7), role: Role::Operator },
        ])
    }

    #[test]
    fn the_higher_role_counts() {
        assert_eq!(grants().on(7), Some(Role::Operator));
        assert_eq!(grants().on(8), Some(Role::Viewer));
        assert_eq!(grants().everywhere(), Some(Role::Viewer));
        assert_eq!(grants().somewhere(), Some(Role::Operator));
        assert_eq!(Grants::default().somewhere(), None);
    }

    #[test]
    fn a_token_never_adds_to_a_role() {
        let all = grants().limited(None, Role::Admin);
        assert_eq!(all, grants());
        let one = grants().limited(Some(8), Role::Admin);
        assert_eq!((one.on(8), one.on(7), one.everywhere()), (Some(Role::Viewer), None, None));
        assert_eq!(grants().limited(None, Role::Viewer).on(7), Some(Role::Viewer));
    }
}
