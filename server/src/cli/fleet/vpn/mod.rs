//! The VPN of a fleet: keys, files, and the steps for root. `wireguard` and `openvpn` are its two kinds, `certificates` makes
//! what OpenVPN needs.

mod certificates;
mod openvpn;
mod wireguard;

use super::files::{self, Became, Files};
use super::state;
use crate::cli::say::say;
use anyhow::{Context as _, bail, ensure};
use provision::{Fleet, Part, Vessel, VpnKind, nftables};
use shore::identity::Line;
use std::fs;
use std::net::{Ipv4Addr, UdpSocket};
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

    /// The file of the server's key.
    fn shore_path(&self) -> PathBuf;

    /// Makes the server's key.
    fn make_shore(&self, now: UtcTime) -> anyhow::Result<()>;

    /// The address of a vessel that has a key which is good; `None` for one without.
    fn address(&self, name: &str) -> anyhow::Result<Option<Ipv4Addr>>;

    /// Gives a vessel this address: with a new key where `new` is set, otherwise with its present one.
    fn give(&self, name: &str, address: Ipv4Addr, new: bool, now: UtcTime) -> anyhow::Result<()>;

    /// A vessel's own file, with its key and address.
    fn path(&self, name: &str) -> PathBuf;

    /// The address at which the files for root, as they are, let in a vessel whose own file is damaged or lost; `None` where it
    /// has no such place, or where its own file is whole.
    fn standing(&self, name: &str) -> anyhow::Result<Option<Ipv4Addr>>;

    /// Names that have a key, or a place in the files for root, in order.
    fn names(&self) -> anyhow::Result<Vec<String>>;

    /// Takes a vessel's place in the files for root, then its key. Returns whether it had one of them.
    fn forget(&self, name: &str) -> anyhow::Result<bool>;

    /// The folder with a file for each vessel, which must be there also when it is empty.
    fn places(&self) -> Option<PathBuf>;

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

    /// The steps of root that put the files into force, in order.
    fn steps(&self) -> Vec<String>;
}

/// The VPN of this kind.
pub(super) fn of<'a>(kind: VpnKind, files: &'a Files) -> Box<dyn Tunnel + 'a> {
    match kind {
        VpnKind::WireGuard => Box::new(wireguard::WireGuard(files)),
        VpnKind::OpenVpn => Box::new(openvpn::OpenVpn(files)),
    }
}

/// Whether the server has its key.
///
/// # Errors
/// It is lost or damaged.
pub(super) fn require_server_key(tunnel: &dyn Tunnel, files: &Files) -> anyhow::Result<()> {
    ensure!(tunnel.has_shore()?, "{}", files.server_key_is(Became::Lost, &tunnel.shore_path()));
    Ok(())
}

/// Refuses another key of the server where boats have theirs by the one that is lost: that would put all of them off the VPN.
///
/// # Errors
/// It is damaged; or it is lost, and boats have keys, places or bundles.
pub(super) fn require_no_lost_server_key(kind: VpnKind, files: &Files, bundled: bool) -> anyhow::Result<()> {
    let tunnel = of(kind, files);
    if tunnel.has_shore()? {
        return Ok(());
    }
    let went_by_it = match state::applied(files) {
        Ok(fleet) => fleet.vpn.kind == kind,
        // With the fleet's folder the kind is lost.
        Err(_) => bundled,
    };
    if went_by_it || !tunnel.names()?.is_empty() {
        bail!(files.server_key_is(Became::Lost, &tunnel.shore_path()));
    }
    Ok(())
}

/// Prints the steps of root, which a person pastes together.
pub(super) fn tell_next(fleet: &Fleet, files: &Files) {
    say!("the VPN goes by the new files once root has them; a step that fails stops those after it:");
    let steps = steps(fleet, files);
    let last = steps.len().saturating_sub(1);
    for (at, step) in steps.iter().enumerate() {
        say!("  {step}{}", if at < last { " &&" } else { "" });
    }
}

/// The steps of root, also those that end a VPN of the other kind that was there before.
fn steps(fleet: &Fleet, files: &Files) -> Vec<String> {
    let kind = fleet.vpn.kind;
    let (unit, configuration) = match kind.other() {
        VpnKind::OpenVpn => ("openvpn-server@lutra", "/etc/openvpn/server/lutra.conf"),
        VpnKind::WireGuard => ("wg-quick@lutra", "/etc/wireguard/lutra.conf"),
    };
    let mut steps = Vec::new();
    // One that is damaged may have let boats in before.
    if of(kind.other(), files).has_shore().unwrap_or(true) {
        // Both have the same addresses. It may never have been installed.
        steps.push(format!(
            "if systemctl cat {unit} > /dev/null 2>&1; then sudo systemctl disable --now {unit}; fi"
        ));
        // It lets boats in by keys of before.
        steps.push(format!("sudo rm -f {configuration}"));
    }
    steps.extend(of(kind, files).steps());
    if !is_here(fleet.vpn.server_address) {
        // It could not listen at an address that was not there yet.
        steps.push("sudo systemctl restart lutra-server".to_owned());
    }
    steps
}

/// Whether this computer has an address.
fn is_here(address: Ipv4Addr) -> bool {
    UdpSocket::bind((address, 0)).is_ok()
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
/// A file that is damaged or lost is reported; its vessel keeps the place that it has, and it holds up no other.
fn members(tunnel: &dyn Tunnel, fleet: &Fleet) -> anyhow::Result<(Vec<Member>, Vec<String>)> {
    let (mut members, mut damaged) = (Vec::new(), Vec::new());
    let listed = fleet.vessels.iter().map(|vessel| (vessel.name.clone(), Some(vessel.vpn_address)));
    let left = left(tunnel, fleet)?.into_iter().map(|name| (name, None));
    for (name, given) in listed.chain(left) {
        let member = |name, address| Member { name, address: given.unwrap_or(address) };
        let why = match tunnel.address(&name) {
            Ok(Some(address)) => {
                members.push(member(name, address));
                continue;
            }
            Ok(None) => files::unusable(&tunnel.path(&name), Became::Lost),
            Err(error) => format!("{error:#}"),
        };
        match tunnel.standing(&name) {
            Ok(Some(address)) => {
                damaged.push(format!("{why}; until then {name} keeps the place that it has"));
                members.push(member(name, address));
            }
            // It never had one, or its key is not good any more, which `doubts` names.
            Ok(None) if !tunnel.path(&name).exists() || tunnel.address(&name).is_ok() => {}
            Ok(None) => damaged.push(format!("{why}; until then the files of the VPN leave {name} out")),
            Err(error) => damaged.push(format!("{why}; {error:#}: the files of the VPN leave {name} out")),
        }
    }
    Ok((members, damaged))
}

/// Vessels' files that are damaged or lost, each with its remedy.
pub(super) fn damaged(tunnel: &dyn Tunnel, fleet: &Fleet) -> anyhow::Result<Vec<String>> {
    Ok(members(tunnel, fleet)?.1)
}

/// The address that a vessel has in the VPN, though its own file be damaged or lost; `None` for one that is out.
pub(super) fn held(tunnel: &dyn Tunnel, name: &str) -> Option<Ipv4Addr> {
    tunnel.address(name).ok().flatten().or_else(|| tunnel.standing(name).ok().flatten())
}

/// What earlier versions left in the folders of this kind, which has no effect any more.
pub(super) fn remains(tunnel: &dyn Tunnel, files: &Files) -> Vec<PathBuf> {
    let mut remains = vec![files.secret("openvpn.crl"), files.secret("openvpn.issued")];
    if tunnel.places().is_some() {
        remains.push(tunnel.folder().join("lutra.crl"));
    }
    remains.retain(|path| path.exists());
    remains
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
    if tunnel.places().is_some_and(|folder| !folder.is_dir()) {
        return Ok(true);
    }
    for (path, text) in &wanted {
        if files::read(path)?.as_ref() != Some(text) {
            return Ok(true);
        }
    }
    Ok(!stale(tunnel, &wanted)?.is_empty())
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
    files::remove_all(&stale(&*tunnel, &wanted)?)?;
    if let Some(folder) = tunnel.places() {
        files::make_folder(&folder)?;
    }
    for (path, text) in &wanted {
        if files::read(path)?.as_ref() != Some(text) {
            files::write(path, text.as_bytes())?;
        }
    }
    Ok(Written { damaged })
}

/// Files of vessels, in the folder that OpenVPN looks into, that are not wanted.
fn stale(tunnel: &dyn Tunnel, wanted: &[(PathBuf, String)]) -> anyhow::Result<Vec<PathBuf>> {
    let Some(folder) = tunnel.places() else { return Ok(Vec::new()) };
    let mut stale = files::entries(&folder)?;
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
