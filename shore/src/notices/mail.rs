//! Sends a message by mail, over an SMTP server.

use super::settings::{Mail, MailTls, Settings};
use anyhow::Context as _;
use lettre::message::header::ContentType;
use lettre::transport::smtp::authentication::Credentials;
use lettre::transport::smtp::client::{Certificate, CertificateStore, Tls, TlsParameters};
use lettre::{AsyncSmtpTransport, AsyncTransport as _, Message, Tokio1Executor};
use std::path::Path;
use std::time::Duration;

/// A server that is silent for this long counts as unreachable.
const PATIENCE: Duration = Duration::from_secs(20);

/// The mail server's answer.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Answer {
    /// It accepted the message.
    Taken,
    /// It refused the message permanently.
    Refused(String),
}

/// A message for a mail server.
pub(super) struct Letter<'a> {
    pub(super) to: &'a str,
    /// Identifies the message, also when it is sent again.
    pub(super) id: String,
    pub(super) subject: String,
    pub(super) text: String,
}

/// Sends a message.
///
/// # Errors
/// It was not accepted now; a later attempt may succeed.
pub(super) async fn send(settings: &Settings, letter: Letter<'_>) -> anyhow::Result<Answer> {
    let mail = &settings.mail;
    let message = Message::builder()
        .from(mail.from.parse().context("notices.mail.from")?)
        .to(letter.to.parse().context("the address of the rule")?)
        .subject(letter.subject)
        .message_id(Some(letter.id))
        .header(ContentType::TEXT_PLAIN)
        .body(letter.text)?;
    let transport = transport(mail, &settings.ca_file)?;
    match transport.send(message).await {
        Ok(_) => Ok(Answer::Taken),
        Err(error) if error.is_permanent() => Ok(Answer::Refused(told(&error))),
        Err(error) => Err(anyhow::anyhow!(told(&error))),
    }
}

fn transport(mail: &Mail, ca_file: &Path) -> anyhow::Result<AsyncSmtpTransport<Tokio1Executor>> {
    let tls = match mail.tls {
        MailTls::None => Tls::None,
        MailTls::Starttls => Tls::Required(trusting(&mail.host, ca_file)?),
        MailTls::Tls => Tls::Wrapper(trusting(&mail.host, ca_file)?),
    };
    let mut builder = AsyncSmtpTransport::<Tokio1Executor>::builder_dangerous(&mail.host)
        .port(mail.port)
        .tls(tls)
        .timeout(Some(PATIENCE));
    if !mail.user.is_empty() {
        let wrong = || format!("notices.mail.password_file {}", mail.password_file.display());
        let password = std::fs::read_to_string(&mail.password_file).with_context(wrong)?;
        let password = password.trim_end_matches(['\r', '\n']).to_owned();
        builder = builder.credentials(Credentials::new(mail.user.clone(), password));
    }
    Ok(builder.build())
}

fn trusting(host: &str, file: &Path) -> anyhow::Result<TlsParameters> {
    let wrong = || format!("notices.ca_file {}", file.display());
    let pem = std::fs::read(file).with_context(wrong)?;
    let mut builder = TlsParameters::builder(host.to_owned()).certificate_store(CertificateStore::None);
    builder = builder.add_root_certificate(Certificate::from_pem(&pem).with_context(wrong)?);
    Ok(builder.build()?)
}

/// An error with its causes.
fn told(error: &lettre::transport::smtp::Error) -> String {
    let mut text = error.to_string();
    let mut source = std::error::Error::source(error);
    while let Some(one) = source {
        let words = one.to_string();
        if !text.contains(&words) {
            text = format!("{text}: {words}");
        }
        source = one.source();
    }
    text.chars().take(300).collect()
}
