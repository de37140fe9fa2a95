//! Alarms sent to people who have no page open: by mail and webhook, by each person's rules.
//!
//! A person has rules: which alarms, from which priority, after how long without acknowledgement, and where to. Once a
//! second `judge` compares the active alarms with the rules. A message is first put into an outbox in app.db and sent from
//! there, so that a restart loses none; a message that the other side does not accept is retried for a day. One alarm makes
//! one message at its beginning and, if wanted, one at its end, however often it recurs meanwhile; beyond [`PER_HOUR`]
//! messages an hour a rule is silent and its last message says so.

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
