//! Settings of accounts and sessions.

use serde::{Deserialize, Serialize};

/// Accounts and sessions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Characters that a password must have at least.
    pub password_length: usize,
    /// Hours without a request after which a session ends.
    pub session_idle_h: u32,
    /// Days after which a session ends however busy it is.
    pub session_days: u32,
}

impl Default for Settings {
    fn default() -> Self {
        Self { password_length: 10, session_idle_h: 12, session_days: 30 }
    }
}
