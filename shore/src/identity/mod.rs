//! People: accounts, roles, sessions, tokens, and the log of what they did.
//!
//! `app.db` belongs to one thread ([`db`]); handlers ask it through [`People`]. Who may come in is answered from
//! memory (`register`) and what happened is written when the disk takes it (`journal`), so that no disk keeps
//! anybody from stopping a boat. The command line opens the same file by itself, also while a server runs. Nothing secret is kept readably: passwords as argon2id, random
//! secrets as SHA-256.

pub mod audit;
pub mod db;
mod handle;
mod hashing;
mod journal;
mod limiter;
mod login;
pub mod password;
pub mod persons;
mod register;
mod roles;
mod secret;
pub mod sessions;
mod settings;
pub mod tokens;
pub mod vessels;

#[cfg(test)]
pub(crate) use db::tests::fresh as migrated;
pub use db::{Fault, backup, open};
pub use handle::{FirstAdmin, People};
pub use journal::Line;
pub use limiter::network;
pub use login::{Attempt, Refused};
pub use roles::{Grants, Principal, Via};
pub use secret::{Secret, one_time_password, same};
pub use settings::Settings;
