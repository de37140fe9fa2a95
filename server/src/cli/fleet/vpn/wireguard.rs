//! WireGuard: a key for the server and for each vessel, and two files in `DATA/vpn`.

use super::super::files::{self, Files};
use super::super::state;
use super::{Member, Tunnel, firewall};
use crate::cli::say::say;
use anyhow::Context as _;
use provision::{Fleet, INTERFACE, Part, Peer, Vessel, VpnKey, wireguard};
use std::net::Ipv4Addr;
use std::path::PathBuf;
use units::UtcTime;

/// What vessels' files in the fleet's folder end with.
const EXTENSION: &str = "vpn";

pub(super) struct WireGuard<'a>(pub(super) &'a Files);

impl WireGuard<'_> {
    fn server_path(&self) -> PathBuf {
        self.0.secret("server.key")
    }

    fn server_key(&self) -> anyhow::Result<Option<VpnKey>> {
        let path = self.server_path();
        let Some(text) = files::read(&path)? else { return Ok(None) };
        VpnKey::parse(&text).map(Some).with_context(|| files::damaged(&path))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.secret(&format!("{name}.{EXTENSION}"))
    }

    /// A vessel's key and address.
    fn access(&self, name: &str) -> anyhow::Result<Option<(VpnKey, Ipv4Addr)>> {
        let path = self.path(name);
        let Some(text) = files::read(&path)? else { return Ok(None) };
        let mut lines = text.lines();
        let key = lines.next().and_then(VpnKey::parse);
        let address = lines.next().and_then(|line| line.trim().parse().ok());
        key.zip(address).map(Some).with_context(|| files::damaged(&path))
    }

    fn configuration(&self) -> PathBuf {
        self.folder().join(format!("{INTERFACE}.conf"))
    }
}

impl Tunnel for WireGuard<'_> {
    fn has_shore(&self) -> anyhow::Result<bool> {
        Ok(self.server_key()?.is_some())
    }

    fn make_shore(&self, _: UtcTime) -> anyhow::Result<()> {
        let key = VpnKey::from_random(state::random()?);
        files::write(&self.server_path(), format!("{}\n", key.private()).as_bytes())
    }

    fn address(&self, name: &str) -> anyhow::Result<Option<Ipv4Addr>> {
        Ok(self.access(name)?.map(|(_, address)| address))
    }

    fn give(&self, name: &str, address: Ipv4Addr, new: bool, _: UtcTime) -> anyhow::Result<()> {
        let present = if new { None } else { self.access(name)? };
        let key = match present {
            Some((key, _)) => key,
            None => VpnKey::from_random(state::random()?),
        };
        files::write(&self.path(name), format!("{}\n{address}\n", key.private()).as_bytes())
    }

    fn names(&self) -> anyhow::Result<Vec<String>> {
        self.0.names(EXTENSION)
    }

    fn forget(&self, name: &str) -> anyhow::Result<bool> {
        files::remove(&self.path(name))
    }

    fn keeps_place(&self) -> bool {
        false
    }

    fn folder(&self) -> PathBuf {
        self.0.vpn()
    }

    fn written(&self) -> Vec<PathBuf> {
        vec![self.configuration(), firewall(&self.folder())]
    }

    fn texts(&self, fleet: &Fleet, members: &[Member]) -> anyhow::Result<Vec<(PathBuf, String)>> {
        let key = self.server_key()?.context("there is no VPN key of the server")?;
        let mut peers = Vec::new();
        for Member { name, address } in members {
            let access = self.access(name)?;
            let public = access.map(|(key, _)| key.public());
            peers.extend(public.map(|public| Peer { name: name.clone(), address: *address, public }));
        }
        Ok(vec![(self.configuration(), wireguard::ashore(fleet, &key, &peers))])
    }

    fn aboard(&self, fleet: &Fleet, vessel: &Vessel) -> anyhow::Result<(Part, String)> {
        let (key, _) = self.access(&vessel.name)?.with_context(|| state::no_key(&vessel.name))?;
        let server = self.server_key()?.with_context(|| state::no_key("the server"))?;
        Ok((Part::Vpn, wireguard::aboard(fleet, vessel, &key, &server.public())))
    }

    fn doubts(&self, _: UtcTime) -> anyhow::Result<Vec<String>> {
        Ok(Vec::new())
    }

    fn tell_next(&self) {
        let (wireguard, firewall) = (self.configuration(), firewall(&self.folder()));
        say!("  sudo install -m 600 {} {} /etc/wireguard/", wireguard.display(), firewall.display());
        say!("  sudo systemctl enable wg-quick@lutra && sudo systemctl restart wg-quick@lutra");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOW: UtcTime = UtcTime::from_micros(1_795_700_000_000_000);

    #[test]
    fn a_vessel_that_moves_keeps_its_key_and_a_new_one_is_another() {
        let data = tempfile::tempdir().unwrap();
        let files = Files::new(data.path(), None);
        let vpn = WireGuard(&files);
        let (first, second) = ([10, 8, 0, 11].into(), [10, 8, 0, 12].into());
        vpn.give("otter-01", first, true, NOW).unwrap();
        let key = || vpn.access("otter-01").unwrap().unwrap().0.private();
        let made = key();
        vpn.give("otter-01", second, false, NOW).unwrap();
        assert_eq!((vpn.address("otter-01").unwrap(), key()), (Some(second), made.clone()));
        vpn.give("otter-01", second, true, NOW).unwrap();
        assert_ne!(key(), made);
        assert!(vpn.forget("otter-01").unwrap() && !vpn.forget("otter-01").unwrap());
    }

    #[test]
    fn a_damaged_key_is_told_with_the_remedy() {
        let data = tempfile::tempdir().unwrap();
        let files = Files::new(data.path(), None);
        files::write(&files.secret("otter-01.vpn"), b"half").unwrap();
        let error = WireGuard(&files).address("otter-01").unwrap_err().to_string();
        assert!(error.contains("otter-01.vpn is damaged: remove it"), "{error}");
    }
}
