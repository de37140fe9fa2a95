//! Alarms told to people who look at no page: by mail and by webhook, as each person asked.
//!
//! A person has rules: which alarms, how urgent, how long nobody acknowledged them, and where to. Once a second
//! `judge` holds what stands against the rules. What is to be told goes to an outbox in app.db first and is sent from
//! there, so that a restart loses no message; a message that the other side does not take is tried again for a day. One
//! alarm makes one message of its beginning and, if wanted, one of its end, however often it comes and goes meanwhile;
//! beyond [`PER_HOUR`] messages an hour a rule is quiet and its last message says so.

mod content;
mod judge;
mod mail;
mod rows;
mod rule;
mod service;
mod settings;
#[cfg(test)]
mod tests;
mod webhook;

pub use rows::Delivery;
pub use rule::{PER_HOUR, Rule, RuleChange, RuleRequest, Way};
pub use service::{Made, Mine, Notices};
pub use settings::{Mail, MailTls, Settings, Webhooks};
