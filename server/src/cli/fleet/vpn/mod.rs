//! The VPN of a fleet: keys, files, and the steps for root. `wireguard` and `openvpn` are its two kinds, `certificates` makes
//! what OpenVPN needs.

mod certificates;
mod openvpn;
mod wireguard;

use super::files::{self, Files};
use super::state;
use crate::cli::say::say;
use anyhow::{Context as _, ensure};
use provision::{Fleet, Part, Vessel, VpnKind, nftables};
use shore::identity::Line;
use std::fs;
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
    fn forget(&self, name: &str) -> anyhow::Result<bool>;

    /// Whether a vessel keeps its place where its file ashore is damaged.
    fn keeps_place(&self) -> bool;

    /// The folder of the files that root puts into force.
    fn folder(&self) -> PathBuf;

    /// These files for the members, besides the firewall; the server has its key.
    fn texts(&self, fleet: &Fleet, members: &[Member]) -> anyhow::Result<Vec<(PathBuf, String)>>;

    /// What is written for root: files or folders of this kind alone.
    fn written(&self) -> Vec<PathBuf>;

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
pub(super) fn tell_next(kind: VpnKind, files: &Files) {
    say!("the VPN goes by the new files once root has them:");
    let (unit, configuration) = match kind.other() {
        VpnKind::OpenVpn => ("openvpn-server@lutra", "/etc/openvpn/server/lutra.conf"),
        VpnKind::WireGuard => ("wg-quick@lutra", "/etc/wireguard/lutra.conf"),
    };
    // One that is damaged may have let boats in before.
    if of(kind.other(), files).has_shore().unwrap_or(true) {
        say!("  sudo systemctl disable --now {unit}    # if it runs: both have the same addresses");
        say!("  sudo rm -f {configuration}    # it lets boats in by keys of before");
    }
    of(kind, files).tell_next();
}

/// What is left of a VPN of the other kind than the fleet's: names that have a key there, and files for root.
#[derive(Debug)]
pub(super) struct Leftover {
    kind: VpnKind,
    pub(super) names: Vec<String>,
    paths: Vec<PathBuf>,
    /// Folders that held them.
    folders: Vec<PathBuf>,
}

impl Leftover {
    pub(super) fn look(files: &Files, fleet: VpnKind) -> anyhow::Result<Self> {
        let kind = fleet.other();
        let tunnel = of(kind, files);
        let names = tunnel.names()?;
        let written = tunnel.written();
        let paths = written.iter().map(|path| own(path)).collect::<anyhow::Result<Vec<_>>>()?.concat();
        Ok(Self { kind, names, paths, folders: written.into_iter().filter(|path| path.is_dir()).collect() })
    }

    /// Lines of the audit log about its end.
    pub(super) fn lines(&self) -> Vec<Line> {
        self.names.iter().map(|name| ended(name, self.kind)).collect()
    }

    pub(super) const fn is_empty(&self) -> bool {
        self.names.is_empty() && self.paths.is_empty()
    }

    pub(super) fn tell(&self) {
        for name in &self.names {
            say!("will end the key of {name} by {}, which is not the fleet's VPN", self.kind.name());
        }
        for path in &self.paths {
            say!("will remove {}", path.display());
        }
    }

    /// Ends these keys, and removes these files. A vessel that goes over to the fleet's VPN has no second way in.
    pub(super) fn end(&self, files: &Files) -> anyhow::Result<()> {
        for name in &self.names {
            of(self.kind, files).forget(name)?;
        }
        self.remove_files()
    }

    /// Removes the files for root alone, and the folder that they were in if nothing else is in it.
    pub(super) fn remove_files(&self) -> anyhow::Result<()> {
        for path in &self.paths {
            let removed = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
            removed.with_context(|| format!("cannot remove {}", path.display()))?;
        }
        for folder in &self.folders {
            let is_empty = fs::read_dir(folder).is_ok_and(|mut all| all.next().is_none());
            if is_empty {
                fs::remove_dir(folder).with_context(|| format!("cannot remove {}", folder.display()))?;
            }
        }
        Ok(())
    }
}

/// The line of the audit log about the end of a vessel's key by this kind of VPN.
pub(super) fn ended(name: &str, kind: VpnKind) -> Line {
    state::line("fleet.revoke", &format!("{name}: key by {}", kind.name()))
}

/// What Lutra wrote at a path: the file, or of a folder its own files alone. Where a person chose the place, the folder may hold
/// the keys of other tunnels.
fn own(path: &Path) -> anyhow::Result<Vec<PathBuf>> {
    if !path.is_dir() {
        return Ok(path.exists().then(|| path.to_owned()).into_iter().collect());
    }
    let mut own = files::entries(path)?;
    own.retain(|path| path.file_stem().is_some_and(|stem| stem == provision::INTERFACE));
    Ok(own)
}

/// Where root's copy of the firewall's rules is loaded from.
pub(super) fn firewall(folder: &Path) -> PathBuf {
    folder.join(format!("{}.nft", provision::INTERFACE))
}

/// The members of the VPN: vessels of the fleet that have a key, then those that are no longer in the file and not revoked.
/// A file that is damaged is reported, and holds up no other vessel.
fn members(tunnel: &dyn Tunnel, fleet: &Fleet) -> anyhow::Result<(Vec<Member>, Vec<String>)> {
    let (mut members, mut damaged) = (Vec::new(), Vec::new());
    let left_out = |name: &str, error: &anyhow::Error| {
        format!("{error:#}; until then the new files of the VPN leave {name} out")
    };
    for vessel in &fleet.vessels {
        let is_in = match tunnel.address(&vessel.name) {
            Ok(address) => address.is_some(),
            Err(error) if tunnel.keeps_place() => {
                damaged.push(format!("{error:#}"));
                true
            }
            Err(error) => {
                damaged.push(left_out(&vessel.name, &error));
                false
            }
        };
        if is_in {
            members.push(Member { name: vessel.name.clone(), address: vessel.vpn_address });
        }
    }
    for name in left(tunnel, fleet)? {
        match tunnel.address(&name) {
            Ok(address) => members.extend(address.map(|address| Member { name, address })),
            Err(error) => damaged.push(left_out(&name, &error)),
        }
    }
    Ok((members, damaged))
}

/// Vessels that have a key of the VPN and are no longer in the file.
pub(super) fn left(tunnel: &dyn Tunnel, fleet: &Fleet) -> anyhow::Result<Vec<String>> {
    let mut names = tunnel.names()?;
    names.retain(|name| fleet.vessels.iter().all(|vessel| vessel.name != *name));
    Ok(names)
}

/// Files and their texts.
type Texts = Vec<(PathBuf, String)>;

/// Every file of the VPN with its text, and what is damaged.
fn wanted(tunnel: &dyn Tunnel, fleet: &Fleet) -> anyhow::Result<(Texts, Vec<String>)> {
    let (members, damaged) = members(tunnel, fleet)?;
    let addresses: Vec<Ipv4Addr> = members.iter().map(|member| member.address).collect();
    let mut wanted = tunnel.texts(fleet, &members)?;
    wanted.push((firewall(&tunnel.folder()), nftables(fleet, &addresses)));
    Ok((wanted, damaged))
}

/// Whether files of the VPN differ from what they should be. The server has its key.
pub(super) fn differs(tunnel: &dyn Tunnel, fleet: &Fleet) -> anyhow::Result<bool> {
    let (wanted, _) = wanted(tunnel, fleet)?;
    for (path, text) in &wanted {
        if files::read(path)?.as_ref() != Some(text) {
            return Ok(true);
        }
    }
    Ok(!stale(&tunnel.folder(), &wanted)?.is_empty())
}

/// Outcome of [`write_vpn`].
#[derive(Debug, Default)]
pub(super) struct Written {
    /// Vessels' files that cannot be read, each with its remedy.
    pub(super) damaged: Vec<String>,
}

impl Written {
    /// # Errors
    /// Vessels' files cannot be read.
    pub(super) fn whole(&self) -> anyhow::Result<()> {
        ensure!(self.damaged.is_empty(), "{}", self.damaged.join("; "));
        Ok(())
    }
}

/// Writes the files of the VPN where they differ, and removes those of vessels that have no place any more.
pub(super) fn write_vpn(files: &Files, fleet: &Fleet) -> anyhow::Result<Written> {
    let tunnel = of(fleet.vpn.kind, files);
    if !tunnel.has_shore()? {
        return Ok(Written::default());
    }
    let (wanted, damaged) = wanted(&*tunnel, fleet)?;
    // First: what is broken off then lets in too few, and not a boat whose access was ended.
    files::remove_all(&stale(&tunnel.folder(), &wanted)?)?;
    for (path, text) in &wanted {
        if files::read(path)?.as_ref() != Some(text) {
            files::write(path, text.as_bytes())?;
        }
    }
    Ok(Written { damaged })
}

/// Files of vessels, in the folder that OpenVPN looks into, that are not wanted.
fn stale(folder: &Path, wanted: &[(PathBuf, String)]) -> anyhow::Result<Vec<PathBuf>> {
    let mut stale = files::entries(&folder.join(provision::openvpn::PLACES))?;
    stale.retain(|path| wanted.iter().all(|(one, _)| one != path));
    Ok(stale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_of_other_tunnels_in_the_chosen_folder_stay() {
        let folder = tempfile::tempdir().unwrap();
        let chosen = folder.path().join("openvpn");
        fs::create_dir_all(chosen.join("lutra.ccd")).unwrap();
        for name in ["lutra.conf", "lutra.crl", "office.key", "lutra.ccd/otter-1"] {
            fs::write(chosen.join(name), name).unwrap();
        }
        let leftover = |paths: Vec<PathBuf>| Leftover {
            kind: VpnKind::OpenVpn,
            names: Vec::new(),
            paths,
            folders: vec![chosen.clone()],
        };
        let found = own(&chosen).unwrap();
        assert_eq!(found, ["lutra.ccd", "lutra.conf", "lutra.crl"].map(|name| chosen.join(name)));
        leftover(found).remove_files().unwrap();
        assert!(chosen.join("office.key").exists() && !chosen.join("lutra.ccd").exists());
        assert_eq!(own(&chosen).unwrap(), Vec::<PathBuf>::new(), "nothing more is left to remove");
        fs::remove_file(chosen.join("office.key")).unwrap();
        leftover(Vec::new()).remove_files().unwrap();
        assert!(!chosen.exists());
    }
}
