//! Files of a fleet in the data folder, each readable only by its owner and written atomically.
//!
//! `DATA/fleet/fleet.toml` is the file that was applied last, `NAME.token` a vessel's link token, which app.db knows by its hash
//! alone, `NAME.vpn` its VPN key and address, `server.key` the server's key (no vessel's: names of vessels end otherwise).
//! `DATA/vpn/` holds what WireGuard and nftables read. A token that is not in app.db is invalid: so a run that was killed
//! between the two does no harm, and the next one makes another.

use anyhow::{Context as _, ensure};
use provision::{INTERFACE, VpnKey};
use std::fs;
use std::io::{self, Write as _};
use std::net::Ipv4Addr;
use std::os::unix::fs::{DirBuilderExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};

/// A vessel's key and its address in the VPN.
#[derive(Debug, Clone)]
pub(super) struct VpnAccess {
    pub(super) key: VpnKey,
    pub(super) address: Ipv4Addr,
}

/// The folders.
#[derive(Debug, Clone)]
pub(super) struct Files {
    fleet: PathBuf,
    vpn: PathBuf,
}

impl Files {
    pub(super) fn new(data: &Path, vpn: Option<&Path>) -> Self {
        Self { fleet: data.join("fleet"), vpn: vpn.map_or_else(|| data.join("vpn"), Path::to_owned) }
    }

    /// The fleet file that was applied last.
    pub(super) fn applied(&self) -> PathBuf {
        self.fleet.join("fleet.toml")
    }

    pub(super) fn wireguard(&self) -> PathBuf {
        self.vpn.join(format!("{INTERFACE}.conf"))
    }

    pub(super) fn firewall(&self) -> PathBuf {
        self.vpn.join(format!("{INTERFACE}.nft"))
    }

    fn token_path(&self, name: &str) -> PathBuf {
        self.fleet.join(format!("{name}.token"))
    }

    fn vpn_path(&self, name: &str) -> PathBuf {
        self.fleet.join(format!("{name}.vpn"))
    }

    fn server_path(&self) -> PathBuf {
        self.fleet.join("server.key")
    }

    pub(super) fn token(&self, name: &str) -> anyhow::Result<Option<String>> {
        read(&self.token_path(name))
    }

    pub(super) fn keep_token(&self, name: &str, secret: &str) -> anyhow::Result<()> {
        write(&self.token_path(name), format!("{secret}\n").as_bytes())
    }

    pub(super) fn server_key(&self) -> anyhow::Result<Option<VpnKey>> {
        let path = self.server_path();
        let Some(text) = read(&path)? else { return Ok(None) };
        VpnKey::parse(&text).map(Some).with_context(|| damaged(&path))
    }

    pub(super) fn keep_server_key(&self, key: &VpnKey) -> anyhow::Result<()> {
        write(&self.server_path(), format!("{}\n", key.private()).as_bytes())
    }

    pub(super) fn vpn_access(&self, name: &str) -> anyhow::Result<Option<VpnAccess>> {
        let path = self.vpn_path(name);
        let Some(text) = read(&path)? else { return Ok(None) };
        let mut lines = text.lines();
        let key = lines.next().and_then(VpnKey::parse);
        let address = lines.next().and_then(|line| line.trim().parse().ok());
        let access = key.zip(address).map(|(key, address)| VpnAccess { key, address });
        access.map(Some).with_context(|| damaged(&path))
    }

    pub(super) fn keep_vpn_access(&self, name: &str, access: &VpnAccess) -> anyhow::Result<()> {
        let text = format!("{}\n{}\n", access.key.private(), access.address);
        write(&self.vpn_path(name), text.as_bytes())
    }

    /// Names that have a key of the VPN.
    pub(super) fn names(&self) -> anyhow::Result<Vec<String>> {
        let entries = match fs::read_dir(&self.fleet) {
            Ok(entries) => entries,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
            Err(error) => return Err(error).with_context(|| format!("cannot read {}", self.fleet.display())),
        };
        let mut names = Vec::new();
        for entry in entries {
            let name = entry?.file_name();
            names.extend(name.to_str().and_then(|name| name.strip_suffix(".vpn")).map(str::to_owned));
        }
        names.sort();
        Ok(names)
    }

    /// Deletes the secrets of a vessel. Returns whether there were any.
    pub(super) fn forget(&self, name: &str) -> anyhow::Result<bool> {
        let mut forgotten = false;
        for path in [self.token_path(name), self.vpn_path(name)] {
            match fs::remove_file(&path) {
                Ok(()) => forgotten = true,
                Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                Err(error) => return Err(error).with_context(|| format!("cannot remove {}", path.display())),
            }
        }
        Ok(forgotten)
    }
}

fn damaged(path: &Path) -> String {
    format!(
        "{} is damaged: remove it, and `lutra-server fleet apply` makes another; the boat needs a new bundle",
        path.display()
    )
}

/// Reads a file; `None` if it does not exist.
pub(super) fn read(path: &Path) -> anyhow::Result<Option<String>> {
    match fs::read_to_string(path) {
        Ok(text) => Ok(Some(text)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error).with_context(|| format!("cannot read {}", path.display())),
    }
}

/// Writes a file that only its owner can read, completely or not at all. Makes its folder if it is missing.
pub(super) fn write(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    // Renaming over a device would replace it.
    let special = fs::symlink_metadata(path).is_ok_and(|about| !about.is_file());
    ensure!(!special, "{} is not a regular file: give another name", path.display());
    let mut partial = path.as_os_str().to_owned();
    partial.push(".new");
    let partial = PathBuf::from(partial);
    let written = || -> io::Result<()> {
        fs::DirBuilder::new().recursive(true).mode(0o700).create(folder)?;
        fs::remove_file(&partial).or_else(|error| match error.kind() {
            io::ErrorKind::NotFound => Ok(()),
            _ => Err(error),
        })?;
        let mut file = fs::OpenOptions::new().write(true).create_new(true).mode(0o600).open(&partial)?;
        file.write_all(bytes)?;
        file.sync_all()?;
        fs::rename(&partial, path)?;
        fs::File::open(folder)?.sync_all()
    };
    let outcome = written();
    if outcome.is_err() {
        fs::remove_file(&partial).ok();
    }
    outcome.with_context(|| format!("cannot write {}; nothing of it is left", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt as _;

    #[test]
    fn secrets_are_read_as_they_were_kept_and_are_the_owners_alone() {
        let data = tempfile::tempdir().unwrap();
        let files = Files::new(data.path(), None);
        assert!(files.names().unwrap().is_empty() && files.token("otter-01").unwrap().is_none());
        let access = VpnAccess { key: VpnKey::from_random([3; 32]), address: [10, 8, 0, 11].into() };
        files.keep_vpn_access("otter-01", &access).unwrap();
        files.keep_token("otter-01", "lutra_link_x").unwrap();
        assert_eq!(files.names().unwrap(), ["otter-01"]);
        let read = files.vpn_access("otter-01").unwrap().unwrap();
        assert_eq!((read.key.private(), read.address), (access.key.private(), access.address));
        for entry in fs::read_dir(data.path().join("fleet")).unwrap() {
            let mode = entry.unwrap().metadata().unwrap().permissions().mode();
            assert_eq!(mode & 0o077, 0);
        }
        assert!(files.forget("otter-01").unwrap() && !files.forget("otter-01").unwrap());
    }

    #[test]
    fn a_damaged_key_is_told_with_the_remedy() {
        let data = tempfile::tempdir().unwrap();
        let files = Files::new(data.path(), None);
        write(&files.vpn_path("otter-01"), b"half").unwrap();
        let error = files.vpn_access("otter-01").unwrap_err().to_string();
        assert!(error.contains("otter-01.vpn is damaged: remove it"), "{error}");
    }
}
