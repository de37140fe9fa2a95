//! People: accounts, roles, sessions, tokens, and the log of what they did.
//!
//! One thread writes `app.db` and a few connections read beside it ([`writer`]); handlers ask through [`People`], each
//! question and change a [`Request`] with its arguments. Who may come in is answered from
//! memory ([`register`]) and what happened is written when the disk takes it ([`journal`]), so that no disk keeps
//! anybody from stopping a boat. The command line opens the same file by itself, also while a server runs. Nothing
//! secret is kept readably: passwords as argon2id, random secrets as SHA-256.

pub(crate) mod audit;
mod db;
mod fault;
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
#[cfg(test)]
pub(crate) mod testing;
pub(crate) mod tokens;
pub(crate) mod vessels;
mod writer;

#[cfg(test)]
pub(crate) use db::tests::fresh as migrated;
pub(crate) use db::{backup, open, wait};
pub(crate) use fault::Fault;
pub(crate) use handle::{ASK_PATIENCE, FirstAdmin, People};
pub(crate) use journal::Line;
pub(crate) use limiter::network;
pub(crate) use login::{Attempt, Refused};
pub(crate) use roles::{Grants, Principal, Via};
pub(crate) use secret::{Secret, one_time_password, same};
pub(crate) use writer::{Request, within_transaction};
