//! The transports of IMC, one module each.
//!
//! Those of the IMC world ([`imcproxy`], [`udp`], [`tcp`]) have no authentication in their protocols. They
//! are off unless configured, belong on loopback or a VPN, and admit only declared addresses. Packets of a vessel that has
//! a link are not trusted there, unless `transports.trusted` names the transport.

mod imcproxy;
mod link;
mod tcp;
mod udp;

pub(crate) use link::open as open_link;

use crate::config::{Transports as TransportsConfig, parse_network};
use anyhow::Context as _;
use futures_util::FutureExt as _;
use futures_util::future::BoxFuture;
use hub::Transport;
use shore::owners::Owners;
use std::net::{IpAddr, SocketAddr};
use std::path::Path;
use std::sync::Arc;
use tokio::net::TcpListener;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio_util::task::TaskTracker;

/// The transports that are open.
#[derive(Debug, Clone, Default)]
pub struct Open {
    /// The IMCProxy transport's address.
    pub imcproxy: Option<SocketAddr>,
    /// The address at which datagrams are taken.
    pub udp: Option<SocketAddr>,
    /// The discovery port that was free.
    pub announce: Option<SocketAddr>,
}

/// Transports that have their ports and admit no peers yet.
pub(crate) struct Opened {
    open: Open,
    /// Each with its name for people.
    transports: Vec<(&'static str, BoxFuture<'static, ()>)>,
}

impl Opened {
    /// Starts to admit peers.
    pub(crate) fn serve(self, tasks: &TaskTracker, owners: &Owners) -> Open {
        for (name, transport) in self.transports {
            tasks.spawn(owners.watch(name, transport));
        }
        self.open
    }
}

/// Opens the configured transports. Data that they keep for the next start are in the folder `data`.
///
/// # Errors
/// A port is taken or an address is not ours; the message names the key.
pub(crate) async fn open(
    config: &TransportsConfig,
    data: &Path,
    shore: &shore::Opened,
) -> anyhow::Result<Opened> {
    let (mut open, mut transports) = (Open::default(), Vec::new());
    let shore::Opened { router, owners, tasks, stop, .. } = shore;
    let (router, tasks, stop) = (router.clone(), tasks.clone(), stop.clone());
    if let Some(address) = config.imcproxy.listen.get() {
        let listener = TcpListener::bind(address).await.with_context(|| {
            format!("cannot listen on {address}: choose another by transports.imcproxy.listen")
        })?;
        let address = listener.local_addr()?;
        router.ledger().opened(Transport::Proxy, address.to_string());
        open.imcproxy = Some(address);
        let access = Access::new(&config.imcproxy.allow, config.imcproxy.max_peers);
        let transport = imcproxy::serve(listener, access, router.clone(), tasks.clone(), stop.clone());
        transports.push(("the IMCProxy transport", transport.boxed()));
    }
    if let Some(address) = config.udp.listen.get() {
        let access = Access::new(&config.udp.allow, config.udp.max_peers);
        let node = udp::Node::open(address, &config.udp, access, data)?;
        (open.udp, open.announce) = (Some(node.address()), node.announce_address());
        let discovery =
            open.announce.map_or_else(|| "no discovery port".to_owned(), |at| format!("discovery {at}"));
        router.ledger().opened(Transport::Udp, format!("{}, {discovery}", node.address()));
        let transport = node.run(router.clone(), tasks.clone(), owners.clone(), stop.clone());
        transports.push(("the UDP transport", transport.boxed()));
    }
    for peer in &config.tcp.connect {
        let transport = tcp::keep_connected(peer.clone(), router.clone(), stop.clone());
        transports.push(("the TCP transport", transport.boxed()));
    }
    Ok(Opened { open, transports })
}

/// Admission rules of a transport: networks, and number of peers.
#[derive(Debug, Clone)]
pub(super) struct Access {
    allow: Arc<[(IpAddr, u8)]>,
    places: Arc<Semaphore>,
}

impl Access {
    /// Networks such as `10.77.0.0/24`; an empty list admits every peer.
    fn new(allow: &[String], places: usize) -> Self {
        Self {
            allow: allow.iter().filter_map(|text| parse_network(text)).collect(),
            places: Arc::new(Semaphore::new(places)),
        }
    }

    /// Whether an address is admitted.
    fn admits(&self, address: IpAddr) -> bool {
        self.allow.is_empty() || self.allow.iter().any(|(network, bits)| holds(*network, *bits, address))
    }

    /// A place for a peer, if one is free.
    fn permit(&self) -> Option<OwnedSemaphorePermit> {
        Arc::clone(&self.places).try_acquire_owned().ok()
    }
}

/// Whether a network contains an address.
fn holds(network: IpAddr, bits: u8, address: IpAddr) -> bool {
    match (network, address.to_canonical()) {
        (IpAddr::V4(network), IpAddr::V4(address)) => {
            let mask = u32::MAX.checked_shl(32 - u32::from(bits)).unwrap_or(0);
            network.to_bits() & mask == address.to_bits() & mask
        }
        (IpAddr::V6(network), IpAddr::V6(address)) => {
            let mask = u128::MAX.checked_shl(128 - u32::from(bits)).unwrap_or(0);
            network.to_bits() & mask == address.to_bits() & mask
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn networks_admit_their_own() {
        let access = Access::new(&["10.77.0.0/24".into(), "192.0.2.7".into(), "::1".into()], 1);
        for (address, admitted) in [
            ("10.77.0.1", true),
            ("10.77.1.1", false),
            ("192.0.2.7", true),
            ("192.0.2.8", false),
            ("::1", true),
            ("::ffff:10.77.0.9", true),
        ] {
            assert_eq!(access.admits(address.parse().unwrap()), admitted, "{address}");
        }
        assert!(Access::new(&["0.0.0.0/0".into()], 1).admits([1, 2, 3, 4].into()));
        assert!(Access::new(&[], 1).admits([1, 2, 3, 4].into()));
    }

    #[test]
    fn places_come_back() {
        let access = Access::new(&[], 1);
        let place = access.permit();
        assert!(place.is_some() && access.permit().is_none());
        drop(place);
        assert!(access.permit().is_some());
    }
}
