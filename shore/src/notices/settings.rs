//! How messages about alarms leave the server.

use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Messages about alarms to people who have no page open.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// URL of the pages, for links in messages; empty for messages without links.
    pub url: String,
    /// Authorities in PEM that are trusted when a mail server or webhook is reached by TLS.
    pub ca_file: PathBuf,
    /// Where webhooks may lead.
    pub webhooks: Webhooks,
    /// The mail server.
    pub mail: Mail,
}

/// Where webhooks may lead: a rule makes this server send requests to an address that a person chose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Webhooks {
    /// Nowhere.
    Off,
    /// To public addresses, by https.
    Public,
    /// Also to this computer and its networks, and by http.
    Any,
}

/// A mail server that takes messages (SMTP, RFC 5321).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Mail {
    /// Its name; empty for no mail.
    pub host: String,
    /// Its port.
    pub port: u16,
    /// Encryption.
    pub tls: MailTls,
    /// The user; empty for a server that asks for none.
    pub user: String,
    /// A file with that user's password.
    pub password_file: PathBuf,
    /// Sender of the messages.
    pub from: String,
}

/// How the conversation with a mail server is encrypted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum MailTls {
    /// Begun in the clear, encrypted before anything is said (RFC 3207); without that, nothing is sent.
    Starttls,
    /// From the first byte (RFC 8314).
    Tls,
    /// Not at all: for a server on this computer.
    None,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            url: String::new(),
            ca_file: "/etc/ssl/certs/ca-certificates.crt".into(),
            webhooks: Webhooks::Public,
            mail: Mail::default(),
        }
    }
}

impl Default for Mail {
    fn default() -> Self {
        Self {
            host: String::new(),
            port: 587,
            tls: MailTls::Starttls,
            user: String::new(),
            password_file: PathBuf::new(),
            from: String::new(),
        }
    }
}

impl Settings {
    /// Settings that are not consistent.
    pub fn problems(&self) -> Vec<String> {
        let mut problems = Vec::new();
        if !self.url.is_empty() && !self.url.starts_with("https://") && !self.url.starts_with("http://") {
            problems.push(format!("notices.url {:?} must begin with https:// or http://", self.url));
        }
        let Mail { host, user, password_file, from, .. } = &self.mail;
        if host.is_empty() {
            return problems;
        }
        if let Err(error) = from.parse::<lettre::message::Mailbox>() {
            problems.push(format!(
                "notices.mail.from {from:?} is not an e-mail address ({error}): give one like \
                 \"Lutra <lutra@example.org>\""
            ));
        }
        if user.is_empty() != password_file.as_os_str().is_empty() {
            problems
                .push("notices.mail.user and password_file belong together: give both or neither".to_owned());
        }
        problems
    }
}
