//! Writing to an InfluxDB by its HTTP API of version 1, which version 2, version 3 and VictoriaMetrics speak as well.
//!
//! One connection, one request at a time: hyper alone does that. hyper-util's pooled client would need one more crate to
//! speak TLS.

use crate::tls::trusting;
use anyhow::{Context as _, bail, ensure};
use bytes::Bytes;
use flate2::Compression;
use flate2::write::GzEncoder;
use http_body_util::{BodyExt as _, Full, Limited};
use hyper::client::conn::http1::{self, SendRequest};
use hyper::header::{AUTHORIZATION, CONTENT_ENCODING, HOST, HeaderValue};
use hyper::{Method, Request, StatusCode, Uri};
use hyper_util::rt::TokioIo;
use rustls::pki_types::ServerName;
use std::io::Write as _;
use std::path::Path;
use std::time::Duration;
use tokio::net::TcpStream;
use tokio_rustls::TlsConnector;

/// A server that says nothing for so long is taken to be gone.
const PATIENCE: Duration = Duration::from_secs(30);
/// Bytes of an answer that are read.
const ANSWER_BYTES: usize = 64 * 1024;

/// What became of lines that were sent.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Answer {
    /// All are kept.
    Kept,
    /// Some lines are refused, the others kept; why.
    Partly(String),
    /// The lines are refused as they are, and will be the next time; why.
    Refused(String),
}

/// The way to one database.
pub(crate) struct Client {
    host: String,
    port: u16,
    path: String,
    authorization: Option<HeaderValue>,
    tls: Option<TlsConnector>,
    connection: Option<SendRequest<Full<Bytes>>>,
}

impl Client {
    /// A client of the database at `url`; `ca` is a file of authorities that are trusted, for `https`.
    pub(crate) fn new(
        url: &str,
        database: &str,
        authorization: Option<HeaderValue>,
        ca: &Path,
    ) -> anyhow::Result<Self> {
        let uri: Uri = url.parse().with_context(|| format!("sinks.influx.url: {url:?} is not an address"))?;
        let host = uri.host().with_context(|| format!("sinks.influx.url: {url:?} names no host"))?.to_owned();
        let tls = match uri.scheme_str() {
            Some("http") => None,
            Some("https") => {
                ensure!(
                    !ca.as_os_str().is_empty(),
                    "sinks.influx.url is https: name the authority that signed its certificate by sinks.influx.ca_file"
                );
                Some(trusting("sinks.influx.ca_file", ca)?)
            }
            _ => bail!("sinks.influx.url: {url:?} must begin with http:// or https://"),
        };
        let port = uri.port_u16().unwrap_or(if tls.is_some() { 443 } else { 8086 });
        let base = uri.path().trim_end_matches('/');
        let path = format!("{base}/write?db={}&precision=u", escaped(database));
        Ok(Self { host, port, path, authorization, tls, connection: None })
    }

    /// Sends lines.
    ///
    /// # Errors
    /// The server is not there, does not let us in or cannot take them now: they are to be sent again later.
    pub(crate) async fn write(&mut self, lines: &str) -> anyhow::Result<Answer> {
        let mut body = GzEncoder::new(Vec::with_capacity(lines.len() / 4), Compression::fast());
        body.write_all(lines.as_bytes())?;
        let body = Bytes::from(body.finish()?);
        let outcome = tokio::time::timeout(PATIENCE, self.post(body)).await;
        if !matches!(outcome, Ok(Ok(_))) {
            self.connection = None;
        }
        let (status, text) = outcome.context("it does not answer")??;
        Ok(match status {
            status if status.is_success() => Answer::Kept,
            StatusCode::BAD_REQUEST if text.contains("partial write") => Answer::Partly(text),
            StatusCode::BAD_REQUEST | StatusCode::PAYLOAD_TOO_LARGE | StatusCode::UNPROCESSABLE_ENTITY => {
                Answer::Refused(text)
            }
            StatusCode::UNAUTHORIZED | StatusCode::FORBIDDEN => bail!(
                "it does not let the server in ({status}); look at sinks.influx.token_file, user and password_file"
            ),
            StatusCode::NOT_FOUND => bail!("there is no such database ({text}); create it, or name another"),
            _ => bail!("it answers {status}: {text}"),
        })
    }

    async fn post(&mut self, body: Bytes) -> anyhow::Result<(StatusCode, String)> {
        let mut sender = match self.connection.take().filter(|sender| !sender.is_closed()) {
            Some(sender) => sender,
            None => self.connect().await?,
        };
        let mut request = Request::builder()
            .method(Method::POST)
            .uri(&self.path)
            .header(HOST, format!("{}:{}", self.host, self.port))
            .header(CONTENT_ENCODING, "gzip");
        if let Some(authorization) = &self.authorization {
            request = request.header(AUTHORIZATION, authorization);
        }
        sender.ready().await?;
        let answer = sender.send_request(request.body(Full::new(body))?).await?;
        let status = answer.status();
        let text = Limited::new(answer.into_body(), ANSWER_BYTES).collect().await;
        let text = text.map_err(|error| anyhow::anyhow!("its answer cannot be read: {error}"))?.to_bytes();
        self.connection = Some(sender);
        let text = String::from_utf8_lossy(&text).trim().chars().take(300).collect();
        Ok((status, text))
    }

    async fn connect(&self) -> anyhow::Result<SendRequest<Full<Bytes>>> {
        let stream = TcpStream::connect((self.host.trim_matches(['[', ']']), self.port)).await?;
        stream.set_nodelay(true)?;
        match &self.tls {
            None => shake_hands(stream).await,
            Some(tls) => {
                let name = ServerName::try_from(self.host.trim_matches(['[', ']']).to_owned())?;
                shake_hands(tls.connect(name, stream).await?).await
            }
        }
    }
}

async fn shake_hands<S>(stream: S) -> anyhow::Result<SendRequest<Full<Bytes>>>
where
    S: tokio::io::AsyncRead + tokio::io::AsyncWrite + Unpin + Send + 'static,
{
    let (sender, connection) = http1::handshake(TokioIo::new(stream)).await?;
    // It ends when the sender is dropped or the server hangs up.
    tokio::spawn(connection);
    Ok(sender)
}

/// A name as a query has it.
fn escaped(name: &str) -> String {
    use std::fmt::Write as _;
    name.bytes().fold(String::new(), |mut text, byte| {
        if byte.is_ascii_alphanumeric() || b"-._~".contains(&byte) {
            text.push(char::from(byte));
        } else {
            write!(text, "%{byte:02X}").ok();
        }
        text
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_that_cannot_be_used_are_told_with_their_key() {
        let client = |url, ca| Client::new(url, "lutra", None, Path::new(ca)).map(|client| client.path);
        assert_eq!(
            client("http://127.0.0.1:8086/influx/", "").unwrap(),
            "/influx/write?db=lutra&precision=u"
        );
        for (url, ca) in
            [("ftp://there", ""), ("http://", ""), ("https://there", ""), ("https://there", "/none")]
        {
            let error = format!("{:#}", client(url, ca).unwrap_err());
            assert!(error.contains("sinks.influx."), "{error}");
        }
        assert_eq!(escaped("a b&precision=s"), "a%20b%26precision%3Ds");
    }
}
