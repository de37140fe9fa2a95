//! People: accounts, roles, sessions, tokens, and the log of what they did.
//!
//! One thread writes `app.db` and a few connections read in parallel (`writer`); handlers use [`People`], where each query
//! and change is a [`Request`] with its arguments. Access is checked in memory (`register`) and the audit log is written
//! when the disk is free (`journal`), so that a slow disk never prevents stopping a boat. The command line opens the same
//! file directly, also while a server runs. No secret is stored in plain text: passwords as argon2id, random secrets as
//! SHA-256.

pub mod audit;
mod db;
mod fault;
mod handle;
mod hashing;
mod journal;
pub mod language;
mod limiter;
pub mod links;
mod login;
pub mod password;
pub mod persons;
mod register;
mod request;
mod roles;
mod secret;
pub mod sessions;
mod settings;
#[cfg(any(test, feature = "testing"))]
pub mod testing;
pub mod tokens;
mod version;
pub mod vessels;
mod writer;

pub use audit::Line;
#[cfg(test)]
pub(crate) use db::tests::fresh as migrated;
pub(crate) use db::wait;
pub use db::{backup, check, open, refuse_newer, with};
pub use fault::Fault;
pub use handle::{ASK_PATIENCE, FirstAdmin, People};
pub use language::Language;
pub use limiter::network;
pub use login::{Attempt, Refused};
pub use request::Request;
pub use roles::{Grants, Principal, Via};
pub use secret::{Secret, one_time_password, same};
pub use settings::Settings;
/// A connection to app.db.
pub use sqlx::SqliteConnection as Connection;
pub use writer::within_transaction;
