//! People: accounts, roles, sessions, tokens, and the log of what they did.
//!
//! `app.db` belongs to one thread ([`db`]); handlers ask it through [`People`]. Who may come in is answered from
//! memory ([`register`]) and what happened is written when the disk takes it ([`journal`]), so that no disk keeps
//! anybody from stopping a boat. The command line opens the same file by itself, also while a server runs. Nothing secret is kept readably: passwords as argon2id, random
//! secrets as SHA-256.

pub(crate) mod audit;
pub(crate) mod db;
mod handle;
mod hashing;
mod journal;
mod limiter;
mod login;
pub(crate) mod password;
pub(crate) mod persons;
mod register;
mod roles;
mod secret;
pub(crate) mod sessions;
pub(crate) mod tokens;
pub(crate) mod vessels;

#[cfg(test)]
pub(crate) use db::tests::fresh as migrated;
pub(crate) use db::{Fault, backup, open};
pub(crate) use handle::{FirstAdmin, People};
pub(crate) use journal::Line;
pub(crate) use limiter::network;
pub(crate) use login::{Attempt, Refused};
pub(crate) use roles::{Grants, Principal, Via};
pub(crate) use secret::{Secret, one_time_password, same};
