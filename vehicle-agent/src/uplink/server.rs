//! Address and credentials of the server.

use anyhow::{Context as _, bail};
use std::path::PathBuf;

/// URL of the shore, and the token of this vessel.
#[derive(Clone, PartialEq, Eq)]
pub(crate) struct Server {
    pub(crate) url: String,
    pub(crate) host: String,
    pub(crate) port: u16,
    pub(crate) token: String,
    /// Certificates to trust; only for `wss`.
    pub(crate) authority: Option<PathBuf>,
}

impl std::fmt::Debug for Server {
    /// Without the token.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Server").field("url", &self.url).finish_non_exhaustive()
    }
}

impl Server {
    /// The server at a URL.
    pub(super) fn at(url: String, token: String, authority: Option<PathBuf>) -> anyhow::Result<Self> {
        let uri: tungstenite::http::Uri = url.parse().with_context(|| format!("URL: `{url}`"))?;
        let usual = match uri.scheme_str() {
            Some("ws") => 80,
            Some("wss") => 443,
            _ => bail!("URL: `{url}` must begin with ws:// or wss://"),
        };
        if usual == 443 && authority.is_none() {
            bail!("URL: wss:// needs `Certificate Authority`, the file that `lutra-server tls init` made");
        }
        let host = uri.host().with_context(|| format!("URL: `{url}` has no host"))?;
        let host = host.trim_matches(['[', ']']).to_owned();
        let port = uri.port_u16().unwrap_or(usual);
        Ok(Self { url, host, port, token, authority })
    }

    pub(super) fn is_secure(&self) -> bool {
        self.url.starts_with("wss:")
    }
}
