//! The VPN of a fleet: keys, files, and the steps for root. `wireguard` and `openvpn` are its two kinds, `certificates` makes
//! what OpenVPN needs.

mod certificates;
mod openvpn;
mod wireguard;

use super::files::{self, Files};
use provision::{Fleet, Part, Vessel, VpnKind, nftables};
use std::fs;
use std::io::ErrorKind;
use std::net::Ipv4Addr;
use std::path::{Path, PathBuf};
use units::UtcTime;

/// A vessel with a key, and its address in the VPN.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Member {
    pub(super) name: String,
    pub(super) address: Ipv4Addr,
}

/// What the two kinds of VPN have in common: keys in the fleet's folder, and files that root puts into force.
pub(super) trait Tunnel {
    /// Whether the server has its key.
    fn has_shore(&self) -> anyhow::Result<bool>;

    /// Makes the server's key.
    fn make_shore(&self, now: UtcTime) -> anyhow::Result<()>;

    /// The address of a vessel that has a key which is good; `None` for one without.
    fn address(&self, name: &str) -> anyhow::Result<Option<Ipv4Addr>>;

    /// Gives a vessel this address: with a new key where `new` is set, otherwise with its present one.
    fn give(&self, name: &str, address: Ipv4Addr, new: bool, now: UtcTime) -> anyhow::Result<()>;

    /// Names that have a key, in order.
    fn names(&self) -> anyhow::Result<Vec<String>>;

    /// Takes a vessel's key. Returns whether it had one.
    fn forget(&self, name: &str, now: UtcTime) -> anyhow::Result<bool>;

    /// The folder of the files that root puts into force.
    fn folder(&self) -> PathBuf;

    /// These files for the members, besides the firewall; the server has its key.
    fn texts(&self, fleet: &Fleet, members: &[Member]) -> anyhow::Result<Vec<(PathBuf, String)>>;

    /// A vessel's configuration, for its bundle.
    fn aboard(&self, fleet: &Fleet, vessel: &Vessel) -> anyhow::Result<(Part, String)>;

    /// What a person should know of the keys.
    fn doubts(&self, now: UtcTime) -> anyhow::Result<Vec<String>>;

    /// Prints the steps of root that put the files into force.
    fn tell_next(&self);
}

/// The VPN of this kind.
pub(super) fn of<'a>(kind: VpnKind, files: &'a Files) -> Box<dyn Tunnel + 'a> {
    match kind {
        VpnKind::WireGuard => Box::new(wireguard::WireGuard(files)),
        VpnKind::OpenVpn => Box::new(openvpn::OpenVpn(files)),
    }
}

/// Prints the steps of root, also those that end a VPN of the other kind that was there before.
pub(super) fn tell_next(kind: VpnKind, files: &Files) -> anyhow::Result<()> {
    use crate::cli::say::say;
    say!("the VPN goes by the new files once root has them:");
    let (other, unit) = match kind {
        VpnKind::WireGuard => (VpnKind::OpenVpn, "openvpn-server@lutra"),
        VpnKind::OpenVpn => (VpnKind::WireGuard, "wg-quick@lutra"),
    };
    if of(other, files).has_shore()? {
        say!("  sudo systemctl disable --now {unit}    # if it runs: both have the same addresses");
    }
    of(kind, files).tell_next();
    Ok(())
}

/// Where root's copy of the firewall's rules is loaded from.
pub(super) fn firewall(folder: &Path) -> PathBuf {
    folder.join(format!("{}.nft", provision::INTERFACE))
}

/// The members of the VPN: vessels of the fleet that have a key, then those that are no longer in the file and not revoked.
fn members(tunnel: &dyn Tunnel, fleet: &Fleet) -> anyhow::Result<Vec<Member>> {
    let mut members = Vec::new();
    for vessel in &fleet.vessels {
        if tunnel.address(&vessel.name)?.is_some() {
            members.push(Member { name: vessel.name.clone(), address: vessel.vpn_address });
        }
    }
    for name in left(tunnel, fleet)? {
        members.extend(tunnel.address(&name)?.map(|address| Member { name, address }));
    }
    Ok(members)
}

/// Vessels that have a key of the VPN and are no longer in the file.
pub(super) fn left(tunnel: &dyn Tunnel, fleet: &Fleet) -> anyhow::Result<Vec<String>> {
    let mut names = tunnel.names()?;
    names.retain(|name| fleet.vessels.iter().all(|vessel| vessel.name != *name));
    Ok(names)
}

/// Every file of the VPN with its text.
fn wanted(tunnel: &dyn Tunnel, fleet: &Fleet) -> anyhow::Result<Vec<(PathBuf, String)>> {
    let members = members(tunnel, fleet)?;
    let addresses: Vec<Ipv4Addr> = members.iter().map(|member| member.address).collect();
    let mut wanted = tunnel.texts(fleet, &members)?;
    wanted.push((firewall(&tunnel.folder()), nftables(fleet, &addresses)));
    Ok(wanted)
}

/// Whether files of the VPN differ from what they should be. The server has its key.
pub(super) fn differs(tunnel: &dyn Tunnel, fleet: &Fleet) -> anyhow::Result<bool> {
    let wanted = wanted(tunnel, fleet)?;
    for (path, text) in &wanted {
        if files::read(path)?.as_ref() != Some(text) {
            return Ok(true);
        }
    }
    Ok(!stale(&tunnel.folder(), &wanted)?.is_empty())
}

/// Writes the files of the VPN where they differ, and removes those of vessels that have no place any more. Returns whether
/// any did.
pub(super) fn write_vpn(files: &Files, fleet: &Fleet) -> anyhow::Result<bool> {
    let tunnel = of(fleet.vpn.kind, files);
    if !tunnel.has_shore()? {
        return Ok(false);
    }
    let wanted = wanted(&*tunnel, fleet)?;
    let mut changed = false;
    for (path, text) in &wanted {
        if files::read(path)?.as_ref() != Some(text) {
            files::write(path, text.as_bytes())?;
            changed = true;
        }
    }
    for path in stale(&tunnel.folder(), &wanted)? {
        files::remove(&path)?;
        changed = true;
    }
    Ok(changed)
}

/// Files of vessels, in the folder that OpenVPN looks into, that are not wanted.
fn stale(folder: &Path, wanted: &[(PathBuf, String)]) -> anyhow::Result<Vec<PathBuf>> {
    use anyhow::Context as _;
    let places = folder.join(provision::openvpn::PLACES);
    let entries = match fs::read_dir(&places) {
        Ok(entries) => entries,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(error).with_context(|| format!("cannot read {}", places.display())),
    };
    let mut stale = Vec::new();
    for entry in entries {
        let path = entry.with_context(|| format!("cannot read {}", places.display()))?.path();
        if wanted.iter().all(|(one, _)| *one != path) {
            stale.push(path);
        }
    }
    stale.sort();
    Ok(stale)
}
