//! The data folder is readable only by the user who runs the server: it has password hashes, keys and vessel positions.

use crate::folder::is_ours;
use std::fs::{self, Metadata};
use std::io;
use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _};
use std::path::{Path, PathBuf};

/// Permission bits of other users.
const OTHERS: u32 = 0o077;

/// Result of a check.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// Files and folders that other users could access.
    pub open: u64,
    /// The first that belongs to another user, and how many there are.
    pub foreign: Option<(PathBuf, u64)>,
}

impl Found {
    /// Messages for people, if any; `changed` says whether the permissions were corrected.
    pub fn told(&self, changed: bool) -> Vec<String> {
        let mut told = Vec::new();
        if self.open > 0 {
            let count = self.open;
            told.push(if changed {
                format!("{count} files and folders of the data could be reached by other users and cannot any more")
            } else {
                format!("{count} files and folders of the data can be reached by other users: the next start ends that")
            });
        }
        if let Some((first, count)) = &self.foreign {
            told.push(format!(
                "{} belongs to another user, as do {} more files and folders, and is left as it is: run the server as \
                 that user, or give the data folder to the one that runs it (chown -R)",
                first.display(),
                count - 1
            ));
        }
        told
    }
}

/// From here on this process makes files and folders only for its own user.
pub fn begin() {
    rustix::process::umask(rustix::fs::Mode::from_raw_mode(OTHERS));
}

/// Checks who may access what Lutra made in a data folder.
///
/// # Errors
/// The folder cannot be read.
pub fn look(data: &Path) -> io::Result<Found> {
    walk(data, false)
}

/// Removes the access of other users to what Lutra made in a data folder that passed [`crate::folder::check`]. Names that
/// Lutra does not make are left as they are, and so is everything on another disk or behind a symbolic link. Entries of
/// another user are only reported.
///
/// # Errors
/// The folder cannot be read.
pub fn keep(data: &Path) -> io::Result<Found> {
    walk(data, true)
}

fn walk(data: &Path, change: bool) -> io::Result<Found> {
    let mut found = Found::default();
    let about = match fs::metadata(data) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(found),
        other => other?,
    };
    let own = rustix::process::geteuid().as_raw();
    one(data, &about, own, change, &mut found);
    let disk = about.dev();
    let mut folders = vec![(data.to_owned(), Vec::<String>::new())];
    while let Some((folder, way)) = folders.pop() {
        // Entries that vanish during the check, or cannot be read, cannot be corrected.
        let Ok(entries) = fs::read_dir(&folder) else { continue };
        for entry in entries.flatten() {
            let (path, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
            let Ok(about) = fs::symlink_metadata(&path) else { continue };
            let mut way = way.clone();
            way.push(name);
            let names: Vec<&str> = way.iter().map(String::as_str).collect();
            let is_known = (about.is_dir() || about.is_file()) && is_ours(&names, about.is_dir());
            if !is_known || about.dev() != disk {
                continue;
            }
            one(&path, &about, own, change, &mut found);
            if about.is_dir() {
                folders.push((path, way));
            }
        }
    }
    Ok(found)
}

fn one(path: &Path, about: &Metadata, own: u32, change: bool, found: &mut Found) {
    let mode = about.permissions().mode();
    if about.uid() != own {
        let (_, count) = found.foreign.get_or_insert_with(|| (path.to_owned(), 0));
        *count += 1;
    } else if mode & OTHERS != 0 {
        let private = fs::Permissions::from_mode(mode & 0o7700);
        if !change || fs::set_permissions(path, private).is_ok() {
            found.open += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mode(path: &Path) -> u32 {
        fs::metadata(path).unwrap().permissions().mode() & 0o777
    }

    #[test]
    fn what_an_earlier_version_left_open_is_closed_once_and_told() {
        let folder = tempfile::tempdir().unwrap();
        let data = folder.path();
        let deep = data.join("archive/0x0801/20261121");
        fs::create_dir_all(&deep).unwrap();
        fs::write(deep.join("Data.lsf"), "x").unwrap();
        for path in [data, &data.join("archive"), &deep] {
            fs::set_permissions(path, fs::Permissions::from_mode(0o755)).unwrap();
        }
        fs::set_permissions(deep.join("Data.lsf"), fs::Permissions::from_mode(0o644)).unwrap();
        // Targets of links are not touched.
        let elsewhere = tempfile::NamedTempFile::new().unwrap();
        fs::set_permissions(elsewhere.path(), fs::Permissions::from_mode(0o644)).unwrap();
        std::os::unix::fs::symlink(elsewhere.path(), data.join("app.db")).unwrap();
        let others = tempfile::tempdir().unwrap();
        let beyond = others.path().join("server.pem");
        fs::write(&beyond, "x").unwrap();
        fs::set_permissions(&beyond, fs::Permissions::from_mode(0o644)).unwrap();
        std::os::unix::fs::symlink(others.path(), data.join("tls")).unwrap();
        // Nor are files that a person put there.
        let put = [data.join("letter.txt"), deep.join("notes.txt"), data.join("sub/script.sh")];
        fs::create_dir(data.join("sub")).unwrap();
        for path in &put {
            fs::write(path, "x").unwrap();
            fs::set_permissions(path, fs::Permissions::from_mode(0o755)).unwrap();
        }
        let open = look(data).unwrap().open;
        assert!(open >= 4 && mode(&deep) == 0o755, "{open}");
        let found = keep(data).unwrap();
        assert_eq!((found.open, found.told(true).len()), (open, 1));
        assert_eq!((mode(data), mode(&deep), mode(&deep.join("Data.lsf"))), (0o700, 0o700, 0o600));
        assert_eq!((mode(elsewhere.path()), mode(&beyond)), (0o644, 0o644));
        assert_eq!(put.map(|path| mode(&path)), [0o755; 3]);
        assert_eq!(keep(data).unwrap(), Found::default());
    }

    #[test]
    fn what_belongs_to_somebody_else_is_told_and_left() {
        if !rustix::process::geteuid().is_root() {
            return;
        }
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("app.db");
        fs::write(&file, "x").unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o644)).unwrap();
        std::os::unix::fs::chown(&file, Some(12_345), None).unwrap();
        let found = keep(folder.path()).unwrap();
        assert_eq!(found.foreign, Some((file.clone(), 1)));
        let told = found.told(true).join("; ");
        assert!(told.contains("app.db belongs to another user"), "{told}");
        assert_eq!(mode(&file), 0o644);
    }
}
