//! OpenVPN's configurations; openvpn(8) of version 2.6 names the directives.
//!
//! The VPN has a certificate authority of its own. The authority of the pages (`tls init`) is optional and may be another
//! organisation's, its certificates cannot be revoked, and browsers trust it: a key from a stolen boat must mean nothing to
//! them. A certificate is known by the name in it, which is the vessel's with the certificate's own number. The file of that name
//! gives the vessel its address (`client-config-dir`), and without that file OpenVPN refuses it (`ccd-exclusive`). So a certificate
//! that was replaced or taken is refused because it has no file, and no list of such certificates must be kept.

use super::INTERFACE;
use crate::fleet::{Fleet, Network, Vessel};
use std::fmt;
use std::fmt::Write as _;
use std::net::Ipv4Addr;

/// The name in the server's certificate, which vessels look for.
pub const SERVER: &str = "lutra-server";
/// Folder with a file for each vessel, beside the server's configuration.
pub const PLACES: &str = "lutra.ccd";
/// The peer is given up after this many keep-alives without an answer; the vessel then connects anew.
const SILENT: u16 = 3;
const STATIC_KEY: &str = "OpenVPN Static key V1";

/// A certificate and its private key, both in PEM. Does not show the key.
#[derive(Clone, PartialEq, Eq)]
pub struct Identity {
    /// The certificate.
    pub certificate: String,
    /// Its key. A secret.
    pub key: String,
}

/// What the server has of the VPN. Does not show itself.
#[derive(Clone, PartialEq, Eq)]
pub struct Shore {
    /// Signs the certificates of server and vessels.
    pub authority: Identity,
    /// The server's own.
    pub server: Identity,
    /// Encrypts the first packets of a connection (`tls-crypt`), so that strangers get no answer. All vessels share it.
    pub shield: String,
}

/// What a vessel has of the VPN: its certificate, and that of the authority that signed it.
#[derive(Clone, PartialEq, Eq)]
pub struct Aboard {
    /// The vessel's own.
    pub identity: Identity,
    /// The authority's certificate in PEM.
    pub authority: String,
}

impl fmt::Debug for Identity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Identity(…)")
    }
}

impl fmt::Debug for Shore {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Shore(…)")
    }
}

impl fmt::Debug for Aboard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Aboard(…)")
    }
}

impl Shore {
    /// Reads what [`Self::written`] wrote; `None` for anything else.
    pub fn parse(text: &str) -> Option<Self> {
        let blocks = blocks(text);
        let [authority, authority_key, server, server_key, shield] = &blocks[..] else { return None };
        Some(Self {
            authority: identity(authority, authority_key)?,
            server: identity(server, server_key)?,
            shield: labelled(shield, STATIC_KEY)?,
        })
    }

    /// The text of a file that holds all of it. A secret.
    pub fn written(&self) -> String {
        let Self { authority, server, shield } = self;
        [&authority.certificate, &authority.key, &server.certificate, &server.key, shield]
            .map(|one| one.trim())
            .join("\n")
            + "\n"
    }
}

impl Aboard {
    /// Reads what [`Self::written`] wrote, whatever lines stand before it; `None` for anything else.
    pub fn parse(text: &str) -> Option<Self> {
        let blocks = blocks(text);
        let [certificate, key, authority] = &blocks[..] else { return None };
        Some(Self { identity: identity(certificate, key)?, authority: labelled(authority, "CERTIFICATE")? })
    }

    /// The text of a file that holds all of it. A secret.
    pub fn written(&self) -> String {
        let Self { identity: Identity { certificate, key }, authority } = self;
        [certificate, key, authority].map(|one| one.trim()).join("\n") + "\n"
    }
}

/// The key that OpenVPN's `--genkey secret` would write of these random bytes. A secret.
pub fn static_key(random: &[u8; 256]) -> String {
    let mut text = format!("-----BEGIN {STATIC_KEY}-----\n");
    for line in random.chunks(16) {
        text.push_str(&hex::encode(line));
        text.push('\n');
    }
    writeln!(text, "-----END {STATIC_KEY}-----").ok();
    text
}

/// The blocks of a PEM text, each with its label.
fn blocks(text: &str) -> Vec<(String, String)> {
    let mut blocks = Vec::new();
    let mut open: Option<(String, String)> = None;
    for line in text.lines().map(str::trim) {
        let label = |begin: &str| line.strip_prefix(begin).and_then(|rest| rest.strip_suffix("-----"));
        if let Some(label) = label("-----BEGIN ") {
            open = Some((label.to_owned(), String::new()));
        }
        if let Some((_, block)) = &mut open {
            block.push_str(line);
            block.push('\n');
        }
        if let Some(ended) = label("-----END ") {
            blocks.extend(open.take().filter(|(label, _)| label == ended));
        }
    }
    blocks
}

fn labelled(block: &(String, String), label: &str) -> Option<String> {
    (block.0 == label).then(|| block.1.clone())
}

fn identity(certificate: &(String, String), key: &(String, String)) -> Option<Identity> {
    Some(Identity { certificate: labelled(certificate, "CERTIFICATE")?, key: labelled(key, "PRIVATE KEY")? })
}

/// The server's side.
pub fn ashore(fleet: &Fleet, shore: &Shore) -> String {
    let vpn = &fleet.vpn;
    let Shore { authority, server, shield } = shore;
    let mut text = format!(
        "# Lutra's VPN, the server's side. Written by `lutra-server fleet apply`: change the fleet file.\n\
         mode server\ntls-server\n\
         # IPv6 and IPv4.\nproto udp6\nport {port}\ndev {INTERFACE}\ndev-type tun\ntopology subnet\n\
         ifconfig {address} {mask}\npush \"topology subnet\"\npush \"route-gateway {address}\"\n\
         # Certificates with a file there may come in, each at its own address.\nclient-config-dir {PLACES}\nccd-exclusive\n\
         # Root opens the tunnel, and what strangers talk to has no rights. It reads that folder at each connection.\n\
         user nobody\ngroup nogroup\npersist-tun\npersist-key\n\
         # No tunnel without its firewall.\nscript-security 2\n\
         up \"/bin/sh -c 'chmod -R a+rX {PLACES} && exec nft -f {INTERFACE}.nft'\"\n\
         keepalive {every} {silent}\nexplicit-exit-notify 1\n\
         remote-cert-tls client\ndh none\n",
        port = vpn.port,
        address = vpn.server_address,
        mask = vpn.network.mask(),
        every = vpn.keepalive_s,
        silent = vpn.keepalive_s * SILENT,
    );
    text.push_str(COMMON);
    inline(
        &mut text,
        [
            ("ca", &authority.certificate),
            ("cert", &server.certificate),
            ("key", &server.key),
            ("tls-crypt", shield),
        ],
    );
    text
}

/// A vessel's side: its computer sends through the tunnel what is for addresses of the VPN, and takes no other route from the
/// server.
pub fn aboard(fleet: &Fleet, vessel: &Vessel, own: &Aboard, shield: &str) -> String {
    let mut text = format!(
        "# Lutra's VPN, the side of {name}. Written by `lutra-agent provision`: change the fleet file ashore.\n\
         client\nproto udp\nremote {host} {port}\nresolv-retry infinite\nconnect-retry 1 30\nnobind\n\
         dev {INTERFACE}\ndev-type tun\npersist-tun\nexplicit-exit-notify 1\n\
         # Refused, as while the server's files are replaced: ask again, do not end.\nauth-retry nointeract\n\
         # The server alone is the other end, and it sets no routes here.\n\
         remote-cert-tls server\nverify-x509-name {SERVER} name\n\
         pull-filter ignore \"route \"\npull-filter ignore \"route-ipv6\"\npull-filter ignore \"redirect-\"\n\
         pull-filter ignore \"dhcp-option\"\n",
        name = vessel.name,
        host = fleet.server.public_name,
        port = fleet.vpn.port,
    );
    text.push_str(COMMON);
    let Aboard { identity, authority } = own;
    inline(
        &mut text,
        [
            ("ca", &authority[..]),
            ("cert", &identity.certificate),
            ("key", &identity.key),
            ("tls-crypt", shield),
        ],
    );
    text
}

/// Both sides. A Raspberry Pi 4 has no instructions for AES: ChaCha20 comes first.
const COMMON: &str =
    "tls-version-min 1.2\ndata-ciphers CHACHA20-POLY1305:AES-256-GCM\nallow-compression no\nverb 3\n";

/// The file of a vessel's certificate in [`PLACES`], which has the name in the certificate.
pub fn place(network: Network, address: Ipv4Addr) -> String {
    format!("ifconfig-push {address} {}\n", network.mask())
}

/// The address in what [`place`] wrote; `None` for anything else.
pub fn placed(text: &str) -> Option<Ipv4Addr> {
    text.strip_prefix("ifconfig-push ")?.split_whitespace().next()?.parse().ok()
}

fn inline(text: &mut String, files: [(&str, &str); 4]) {
    for (name, file) in files {
        write!(text, "<{name}>\n{}\n</{name}>\n", file.trim()).ok();
    }
}
