//! Files of a fleet in the data folder, each readable only by its owner and written atomically.
//!
//! `DATA/fleet/fleet.toml` is the file that was applied last, `NAME.token` a vessel's link token, which app.db knows by its hash
//! alone. Keys of the VPN lie beside them ([`super::vpn`]); `DATA/vpn/` holds what WireGuard or OpenVPN and nftables read. A token
//! that is not in app.db is invalid: so a run that was killed between the two does no harm, and the next one makes another.

use super::Place;
use crate::config::Config;
use anyhow::{Context as _, ensure};
use std::fs;
use std::io::{self, Write as _};
use std::os::unix::fs::{DirBuilderExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};

/// The file that notes the folder of the VPN's files, where it was chosen.
const VPN_DIR: &str = "vpn-dir";

/// The folders.
#[derive(Debug, Clone)]
pub(super) struct Files {
    fleet: PathBuf,
    vpn: PathBuf,
    /// Where a backup has the files of `fleet`.
    backup: PathBuf,
}

impl Files {
    /// Those of a server. Without `--vpn-dir` the files of the VPN are where the last `fleet apply` was told to put them: a second
    /// set of them elsewhere would be the one that nothing reads.
    ///
    /// # Errors
    /// Where they are cannot be read.
    pub(super) fn of(config: &Config, place: &Place) -> anyhow::Result<Self> {
        let remembered = read(&config.data.join("fleet").join(VPN_DIR))?;
        let remembered = remembered.map(|text| PathBuf::from(text.trim_end_matches('\n')));
        let vpn = place.vpn_dir.clone().or(remembered);
        Ok(Self { backup: config.backup.folder.join("fleet"), ..Self::new(&config.data, vpn.as_deref()) })
    }

    /// Notes where the files of the VPN are, where that was said.
    ///
    /// # Errors
    /// The note cannot be written.
    pub(super) fn remember(&self, place: &Place) -> anyhow::Result<()> {
        let Some(vpn) = &place.vpn_dir else { return Ok(()) };
        let vpn = std::path::absolute(vpn).with_context(|| vpn.display().to_string())?;
        write(&self.fleet.join(VPN_DIR), format!("{}\n", vpn.display()).as_bytes())
    }

    /// Those of a data folder, without a backup.
    pub(super) fn new(data: &Path, vpn: Option<&Path>) -> Self {
        let vpn = vpn.map_or_else(|| data.join("vpn"), Path::to_owned);
        Self { fleet: data.join("fleet"), vpn, backup: PathBuf::from("fleet") }
    }

    /// The fleet file that was applied last.
    pub(super) fn applied(&self) -> PathBuf {
        self.fleet.join("fleet.toml")
    }

    /// The folder of the VPN's files.
    pub(super) fn vpn(&self) -> PathBuf {
        self.vpn.clone()
    }

    /// A file of the fleet's folder that holds a secret.
    pub(super) fn secret(&self, name: &str) -> PathBuf {
        self.fleet.join(name)
    }

    /// What to say of the server's key of the VPN where it cannot be used and boats go by it.
    pub(super) fn server_key_is(&self, became: Became, path: &Path) -> String {
        let backup = path.file_name().map_or_else(|| self.backup.clone(), |name| self.backup.join(name));
        let remove = match became {
            Became::Damaged => "remove what is left of it, and ",
            Became::Lost => "",
        };
        format!(
            "{there} {}, and boats have their keys by it: restore it from the backup: {} to {there}. Without a backup \
             {remove}`lutra-server fleet apply FILE --new-server-key` makes another, and puts every boat off the VPN until it has a new \
             bundle",
            became.words(),
            backup.display(),
            there = path.display(),
        )
    }

    fn token_path(&self, name: &str) -> PathBuf {
        self.fleet.join(format!("{name}.token"))
    }

    pub(super) fn token(&self, name: &str) -> anyhow::Result<Option<String>> {
        read(&self.token_path(name))
    }

    pub(super) fn keep_token(&self, name: &str, secret: &str) -> anyhow::Result<()> {
        write(&self.token_path(name), format!("{secret}\n").as_bytes())
    }

    /// Names of vessels that have a file with this extension, in order.
    pub(super) fn names(&self, extension: &str) -> anyhow::Result<Vec<String>> {
        let end = format!(".{extension}");
        let entries = entries(&self.fleet)?;
        let names = entries.iter().filter_map(|path| path.file_name()?.to_str()?.strip_suffix(&end));
        Ok(names.map(str::to_owned).collect())
    }

    /// Deletes a vessel's link token. Returns whether there was one.
    pub(super) fn forget_token(&self, name: &str) -> anyhow::Result<bool> {
        remove(&self.token_path(name))
    }
}

/// What became of a file of the fleet's folder.
#[derive(Debug, Clone, Copy)]
pub(super) enum Became {
    Damaged,
    Lost,
}

impl Became {
    const fn words(self) -> &'static str {
        match self {
            Self::Damaged => "is damaged",
            Self::Lost => "is not there",
        }
    }
}

/// What to say of a vessel's file that cannot be used.
pub(super) fn unusable(path: &Path, became: Became) -> String {
    let remove = match became {
        Became::Damaged => "remove it, and ",
        Became::Lost => "",
    };
    format!(
        "{} {}: bring it back from the backup; without one {remove}`lutra-server fleet apply` makes another where the vessel is in the \
         fleet file, and the boat needs a new bundle",
        path.display(),
        became.words()
    )
}

/// Reads a file; `None` if it does not exist. Bytes that are no text become `U+FFFD`, which no file of the fleet has: so the
/// place of the damage is found by those who read it.
pub(super) fn read(path: &Path) -> anyhow::Result<Option<String>> {
    match fs::read(path) {
        Ok(bytes) => Ok(Some(String::from_utf8_lossy(&bytes).into_owned())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error).with_context(|| format!("cannot read {}", path.display())),
    }
}

/// What is in a folder, in order; nothing if it does not exist.
pub(super) fn entries(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let unreadable = || format!("cannot read {}", folder.display());
    let entries = match fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(error).with_context(unreadable),
    };
    let paths = entries.map(|entry| entry.map(|entry| entry.path())).collect::<io::Result<Vec<_>>>();
    let mut paths = paths.with_context(unreadable)?;
    paths.sort();
    Ok(paths)
}

/// Makes a folder that only its owner can read, with those above it.
pub(super) fn make_folder(path: &Path) -> anyhow::Result<()> {
    let made = fs::DirBuilder::new().recursive(true).mode(0o700).create(path);
    made.with_context(|| format!("cannot make {}", path.display()))
}

/// Removes a file. Returns whether there was one.
pub(super) fn remove(path: &Path) -> anyhow::Result<bool> {
    match fs::remove_file(path) {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error).with_context(|| format!("cannot remove {}", path.display())),
    }
}

/// Removes files, all that can be. Returns whether there was one.
///
/// # Errors
/// The first that cannot be removed.
pub(super) fn remove_all(paths: &[PathBuf]) -> anyhow::Result<bool> {
    let removed: Vec<anyhow::Result<bool>> = paths.iter().map(|path| remove(path)).collect();
    removed.into_iter().try_fold(false, |any, one| Ok(one? || any))
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
        assert!(files.names("token").unwrap().is_empty() && files.token("otter-01").unwrap().is_none());
        files.keep_token("otter-01", "lutra_link_x").unwrap();
        assert_eq!(files.token("otter-01").unwrap().as_deref(), Some("lutra_link_x\n"));
        assert_eq!(files.names("token").unwrap(), ["otter-01"]);
        for entry in fs::read_dir(data.path().join("fleet")).unwrap() {
            let mode = entry.unwrap().metadata().unwrap().permissions().mode();
            assert_eq!(mode & 0o077, 0);
        }
        assert!(files.forget_token("otter-01").unwrap() && !files.forget_token("otter-01").unwrap());
    }
}
