//! WireGuard: a key for the server and for each vessel, and two files in `DATA/vpn`.

use super::super::files::{self, Became, Files};
use super::super::state;
use super::{Member, Tunnel, firewall};
use anyhow::Context as _;
use provision::{Fleet, INTERFACE, Part, Peer, Vessel, VpnKey, wireguard};
use std::collections::BTreeSet;
use std::net::Ipv4Addr;
use std::path::PathBuf;
use units::UtcTime;

/// What vessels' files in the fleet's folder end with.
const EXTENSION: &str = "vpn";

pub(super) struct WireGuard<'a>(pub(super) &'a Files);

impl WireGuard<'_> {
    fn server_key(&self) -> anyhow::Result<Option<VpnKey>> {
        let path = self.shore_path();
        let Some(text) = files::read(&path)? else { return Ok(None) };
        VpnKey::parse(&text).map(Some).with_context(|| self.0.server_key_is(Became::Damaged, &path))
    }

    fn own_server_key(&self) -> anyhow::Result<VpnKey> {
        self.server_key()?.with_context(|| self.0.server_key_is(Became::Lost, &self.shore_path()))
    }

    /// A vessel's key and address.
    fn access(&self, name: &str) -> anyhow::Result<Option<(VpnKey, Ipv4Addr)>> {
        let path = self.path(name);
        let Some(text) = files::read(&path)? else { return Ok(None) };
        let mut lines = text.lines();
        let key = lines.next().and_then(VpnKey::parse);
        let address = lines.next().and_then(|line| line.trim().parse().ok());
        key.zip(address).map(Some).with_context(|| files::unusable(&path, Became::Damaged))
    }

    /// The peers of the server's side as it is.
    fn peers(&self) -> anyhow::Result<Vec<Peer>> {
        Ok(files::read(&self.configuration())?.map_or_else(Vec::new, |text| wireguard::peers(&text)))
    }

    /// A vessel's place in it, where the vessel's own file is damaged or lost.
    fn standing_peer(&self, name: &str) -> anyhow::Result<Option<Peer>> {
        if matches!(self.access(name), Ok(Some(_))) {
            return Ok(None);
        }
        Ok(self.peers()?.into_iter().find(|peer| peer.name == name))
    }

    /// Takes a vessel's place. Returns whether it had one.
    fn end_place(&self, name: &str) -> anyhow::Result<bool> {
        let path = self.configuration();
        let Some(text) = files::read(&path)? else { return Ok(false) };
        let without = wireguard::without(&text, name);
        let had = without != text;
        if had {
            files::write(&path, without.as_bytes())?;
        }
        Ok(had)
    }

    fn configuration(&self) -> PathBuf {
        self.folder().join(format!("{INTERFACE}.conf"))
    }
}

impl Tunnel for WireGuard<'_> {
    fn has_shore(&self) -> anyhow::Result<bool> {
        Ok(self.server_key()?.is_some())
    }

    fn shore_path(&self) -> PathBuf {
        self.0.secret("server.key")
    }

    fn make_shore(&self, _: UtcTime) -> anyhow::Result<()> {
        let key = VpnKey::from_random(state::random()?);
        files::write(&self.shore_path(), format!("{}\n", key.private()).as_bytes())
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

    fn path(&self, name: &str) -> PathBuf {
        self.0.secret(&format!("{name}.{EXTENSION}"))
    }

    fn standing(&self, name: &str) -> anyhow::Result<Option<Ipv4Addr>> {
        Ok(self.standing_peer(name)?.map(|peer| peer.address))
    }

    fn names(&self) -> anyhow::Result<Vec<String>> {
        let placed = self.peers()?.into_iter().map(|peer| peer.name);
        Ok(self.0.names(EXTENSION)?.into_iter().chain(placed).collect::<BTreeSet<_>>().into_iter().collect())
    }

    fn forget(&self, name: &str) -> anyhow::Result<bool> {
        // Its place first, so that a place without a file is never that of a vessel whose access was taken. Each goes though the
        // other cannot.
        let place = self.end_place(name);
        let kept = files::remove(&self.path(name))?;
        Ok(place? || kept)
    }

    fn places(&self) -> Option<PathBuf> {
        None
    }

    fn folder(&self) -> PathBuf {
        self.0.vpn()
    }

    fn written(&self) -> Vec<PathBuf> {
        vec![self.configuration(), firewall(&self.folder())]
    }

    fn texts(&self, fleet: &Fleet, members: &[Member]) -> anyhow::Result<Vec<(PathBuf, String)>> {
        let key = self.own_server_key()?;
        let mut peers = Vec::new();
        for Member { name, address } in members {
            let public = match self.access(name) {
                Ok(Some((key, _))) => Some(key.public()),
                Ok(None) | Err(_) => self.standing_peer(name)?.map(|peer| peer.public),
            };
            peers.extend(public.map(|public| Peer { name: name.clone(), address: *address, public }));
        }
        Ok(vec![(self.configuration(), wireguard::ashore(fleet, &key, &peers))])
    }

    fn aboard(&self, fleet: &Fleet, vessel: &Vessel) -> anyhow::Result<(Part, String)> {
        let (key, _) = self.access(&vessel.name)?.with_context(|| state::no_key(&vessel.name))?;
        let server = self.own_server_key()?;
        Ok((Part::Vpn, wireguard::aboard(fleet, vessel, &key, &server.public())))
    }

    fn doubts(&self, _: UtcTime) -> anyhow::Result<Vec<String>> {
        Ok(Vec::new())
    }

    fn steps(&self) -> Vec<String> {
        let (wireguard, firewall) = (self.configuration(), firewall(&self.folder()));
        vec![
            format!("sudo install -m 600 {} {} /etc/wireguard/", wireguard.display(), firewall.display()),
            "sudo systemctl enable wg-quick@lutra".to_owned(),
            "sudo systemctl restart wg-quick@lutra".to_owned(),
        ]
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
        assert!(
            error.contains("otter-01.vpn is damaged: bring it back from the backup; without one remove it"),
            "{error}"
        );
    }
}
