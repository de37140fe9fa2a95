//! A message to a URL: one HTTP POST of JSON, signed.
//!
//! `Lutra-Delivery` is the message's number, the same when it is sent again. `Lutra-Signature` is `t=SECONDS,v1=HEX`: HEX is
//! HMAC-SHA256 (RFC 2104) by the rule's secret over `SECONDS.BODY`. Only an answer of 2xx counts as accepted; redirects are
//! not followed. The name is looked up once, and the connection goes to the address that was checked.

use super::settings::{Settings, Webhooks};
use crate::tls::trusting;
use anyhow::{Context as _, bail};
use bytes::Bytes;
use http_body_util::{BodyExt as _, Full, Limited};
use hyper::client::conn::http1;
use hyper::header::{CONTENT_TYPE, HOST, USER_AGENT};
use hyper::{Request, StatusCode, Uri};
use hyper_util::rt::TokioIo;
use ring::hmac;
use rustls::pki_types::ServerName;
use std::net::{IpAddr, SocketAddr};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpStream;

/// Bytes of an answer that are read.
const ANSWER_BYTES: usize = 4 * 1024;

/// A webhook's answer.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Answer {
    /// It accepted the message.
    Taken,
    /// It refused the message permanently.
    Refused(String),
}

/// A message for a webhook.
pub(super) struct Post<'a> {
    pub(super) url: &'a str,
    pub(super) secret: &'a str,
    /// The message's number.
    pub(super) delivery: i64,
    /// When it is sent, s since 1970 UTC.
    pub(super) now_s: i64,
    pub(super) body: String,
}

/// Sends a message.
///
/// # Errors
/// It was not accepted now; a later attempt may succeed.
pub(super) async fn post(settings: &Settings, post: Post<'_>) -> anyhow::Result<Answer> {
    let url: Uri = post.url.parse()?;
    let host = url.host().context("the URL names no host")?.trim_matches(['[', ']']).to_owned();
    let encrypted = url.scheme_str() == Some("https");
    let port = url.port_u16().unwrap_or(if encrypted { 443 } else { 80 });
    let address = match address(&host, port, settings.webhooks).await? {
        Ok(address) => address,
        Err(refused) => return Ok(Answer::Refused(refused)),
    };
    let stream = TcpStream::connect(address).await?;
    let (status, text) = if encrypted {
        let name = ServerName::try_from(host)?;
        let stream = trusting("notices.ca_file", &settings.ca_file)?.connect(name, stream).await?;
        exchange(stream, &url, post).await?
    } else {
        exchange(stream, &url, post).await?
    };
    Ok(match status {
        status if status.is_success() => Answer::Taken,
        // Temporary errors are retried.
        StatusCode::REQUEST_TIMEOUT | StatusCode::TOO_MANY_REQUESTS => bail!("it answers {status}: {text}"),
        status if status.is_server_error() => bail!("it answers {status}: {text}"),
        status if status.is_redirection() => {
            Answer::Refused(format!("it answers {status}, which is not followed: give the URL it leads to"))
        }
        status => Answer::Refused(format!("it answers {status}: {text}")),
    })
}

async fn exchange<S>(stream: S, url: &Uri, post: Post<'_>) -> anyhow::Result<(StatusCode, String)>
where
    S: AsyncRead + AsyncWrite + Unpin + Send + 'static,
{
    let (mut sender, connection) = http1::handshake(TokioIo::new(stream)).await?;
    // It ends when the sender is dropped or the other side hangs up.
    tokio::spawn(connection);
    let request = Request::post(url.path_and_query().map_or("/", |path| path.as_str()))
        .header(HOST, url.authority().context("the URL names no host")?.as_str())
        .header(USER_AGENT, concat!("lutra/", env!("CARGO_PKG_VERSION")))
        .header(CONTENT_TYPE, "application/json")
        .header("lutra-delivery", post.delivery)
        .header("lutra-signature", signature(post.secret, post.now_s, &post.body))
        .body(Full::new(Bytes::from(post.body)))?;
    let answer = sender.send_request(request).await?;
    let status = answer.status();
    let body = Limited::new(answer.into_body(), ANSWER_BYTES).collect().await;
    let text = body.map(|body| String::from_utf8_lossy(&body.to_bytes()).trim().chars().take(200).collect());
    Ok((status, text.unwrap_or_default()))
}

/// As `t=SECONDS,v1=HEX`.
pub(super) fn signature(secret: &str, now_s: i64, body: &str) -> String {
    let key = hmac::Key::new(hmac::HMAC_SHA256, secret.as_bytes());
    let tag = hmac::sign(&key, format!("{now_s}.{body}").as_bytes());
    format!("t={now_s},v1={}", hex::encode(tag.as_ref()))
}

/// The address of a name, if it is allowed; else why not.
async fn address(host: &str, port: u16, allowed: Webhooks) -> anyhow::Result<Result<SocketAddr, String>> {
    let found: Vec<SocketAddr> = tokio::net::lookup_host((host, port)).await?.collect();
    let first = found.first().with_context(|| format!("{host} has no address"))?;
    let private = found.iter().find(|one| !is_public(one.ip()));
    Ok(match (allowed, private) {
        (Webhooks::Any, _) | (Webhooks::Public, None) => Ok(*first),
        (Webhooks::Public, Some(one)) => Err(format!(
            "{host} leads to {}, which is not a public address; the server's configuration decides whether that may be \
             (notices.webhooks)",
            one.ip()
        )),
        (Webhooks::Off, _) => Err("this server sends no webhooks (notices.webhooks)".to_owned()),
    })
}

/// Whether an address is one of the public Internet (IANA's special-purpose registries).
fn is_public(address: IpAddr) -> bool {
    match address.to_canonical() {
        IpAddr::V4(v4) => {
            let [a, b, c, _] = v4.octets();
            let shared = a == 100 && (64..128).contains(&b);
            let benchmark = a == 198 && (b == 18 || b == 19);
            let protocol = (a, b, c) == (192, 0, 0);
            !(v4.is_private()
                || v4.is_loopback()
                || v4.is_link_local()
                || v4.is_broadcast()
                || v4.is_documentation()
                || v4.is_multicast()
                || a == 0
                || a >= 240
                || shared
                || benchmark
                || protocol)
        }
        // Global unicast without documentation prefixes, and without those that embed an IPv4 address.
        IpAddr::V6(v6) => {
            let [a, b, ..] = v6.segments();
            let documentation = (a, b) == (0x2001, 0x0db8) || a == 0x3fff;
            let wrapped = a == 0x2002 || (a, b) == (0x2001, 0) || (a, b) == (0x0064, 0xff9b);
            (a & 0xe000) == 0x2000 && !documentation && !wrapped
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_signature_is_that_of_the_time_and_the_body() {
        // By `printf '1700000000.{"a":1}' | openssl dgst -sha256 -hmac whsec`.
        let wanted = "t=1700000000,v1=8ad37ba156048ae0e0a5533c75cdf26fee88b07f93cb57ee4c80adb053012032";
        assert_eq!(signature("whsec", 1_700_000_000, "{\"a\":1}"), wanted);
    }

    #[test]
    fn only_public_addresses_are_public() {
        for one in ["1.1.1.1", "8.8.8.8", "193.71.1.1", "2a00:1450::1", "2606:4700::1111"] {
            assert!(is_public(one.parse().unwrap()), "{one}");
        }
        let private = [
            "127.0.0.1",
            "10.77.0.1",
            "172.16.0.1",
            "192.168.1.1",
            "169.254.169.254",
            "100.64.0.1",
            "0.0.0.0",
            "255.255.255.255",
            "224.0.0.1",
            "198.18.0.1",
            "192.0.0.8",
            "192.0.2.1",
            "240.0.0.1",
            "::1",
            "::",
            "fe80::1",
            "fc00::1",
            "fd12::1",
            "ff02::1",
            "::ffff:10.0.0.1",
            "::ffff:127.0.0.1",
            "2001:db8::1",
            "2002:7f00:1::",
            "64:ff9b::7f00:1",
        ];
        for one in private {
            assert!(!is_public(one.parse().unwrap()), "{one}");
        }
    }
}
