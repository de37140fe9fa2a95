//! Writes files under other names and renames them when all of them are on the disk.

use super::account::Account;
use super::place::Destination;
use anyhow::{Context as _, ensure};
use rustix::fs::{Mode, OFlags};
use std::ffi::OsString;
use std::fs::{self, DirBuilder, File, OpenOptions, Permissions};
use std::io::{self, ErrorKind, Write as _};
use std::os::unix::fs::{
    DirBuilderExt as _, MetadataExt as _, OpenOptionsExt as _, PermissionsExt as _, fchown,
};
use std::path::{Path, PathBuf};

/// Disk space that stays free, for the vessel's records.
const RESERVE_BYTES: u64 = 16 << 20;

/// The files that are missing or differ.
pub(super) fn due(wanted: Vec<Destination>) -> anyhow::Result<Vec<Destination>> {
    let mut due = Vec::new();
    for one in wanted {
        let there = is_there(&one).with_context(|| format!("cannot read {}", one.path.display()))?;
        let in_the_way = one.path.symlink_metadata().is_ok_and(|about| about.is_dir());
        ensure!(
            !in_the_way,
            "{} is a folder, where a file is to be: move it away. Nothing was changed",
            one.path.display()
        );
        if !there {
            due.push(one);
        }
    }
    Ok(due)
}

fn is_there(one: &Destination) -> io::Result<bool> {
    let about = match fs::symlink_metadata(&one.path) {
        Ok(about) => about,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(false),
        Err(error) => return Err(error),
    };
    let owned = one.owner.is_none_or(|owner| (about.uid(), about.gid()) == (owner.user, owner.group));
    Ok(about.is_file()
        && owned
        && about.permissions().mode() & 0o7777 == one.mode
        && about.len() == one.bytes.len() as u64
        && fs::read(&one.path)? == one.bytes)
}

/// Puts all in place. If anything fails before the last is written, nothing is changed.
pub(super) fn put(due: &[Destination]) -> anyhow::Result<()> {
    room(due)?;
    let mut staged = Staged::default();
    for one in due {
        staged
            .write(one)
            .with_context(|| format!("cannot write {}; nothing was changed", one.path.display()))?;
    }
    staged.finish()
}

/// Checks that the disks have room for all of it.
fn room(due: &[Destination]) -> anyhow::Result<()> {
    let needed: u64 = due.iter().map(|one| one.bytes.len() as u64).sum();
    for one in due {
        let there = one.path.ancestors().skip(1).find(|folder| folder.is_dir()).unwrap_or(Path::new("/"));
        let disk = rustix::fs::statvfs(there).with_context(|| there.display().to_string())?;
        enough(disk.f_bavail.saturating_mul(disk.f_frsize), needed, there)?;
    }
    Ok(())
}

fn enough(free: u64, needed: u64, place: &Path) -> anyhow::Result<()> {
    let wanted = needed.saturating_add(RESERVE_BYTES);
    ensure!(
        free >= wanted,
        "the disk of {} has {} MiB free and {} are needed: bring old logs ashore and remove them. Nothing was changed",
        place.display(),
        free >> 20,
        (wanted >> 20) + 1
    );
    Ok(())
}

/// Files written under other names; removed if dropped unfinished.
#[derive(Debug, Default)]
struct Staged {
    files: Vec<(PathBuf, PathBuf)>,
    folders: Vec<PathBuf>,
}

impl Staged {
    fn write(&mut self, one: &Destination) -> io::Result<()> {
        let folder = one.path.parent().unwrap_or(Path::new("/"));
        self.make_folder(folder, one.folder_mode, one.folder_owner)?;
        let mut name = OsString::from(".");
        name.push(one.path.file_name().unwrap_or_default());
        name.push(".provision-new");
        let beside = folder.join(name);
        // A remainder of a run that lost power.
        match fs::remove_file(&beside) {
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        let mut file = OpenOptions::new().write(true).create_new(true).mode(0o600).open(&beside)?;
        self.files.push((beside, one.path.clone()));
        file.write_all(&one.bytes)?;
        if let Some(Account { user, group }) = one.owner {
            fchown(&file, Some(user), Some(group))?;
        }
        file.set_permissions(Permissions::from_mode(one.mode))?;
        file.sync_all()
    }

    fn make_folder(&mut self, folder: &Path, mode: u32, owner: Option<Account>) -> io::Result<()> {
        let absent: Vec<&Path> = folder.ancestors().take_while(|folder| !folder.is_dir()).collect();
        for folder in absent.into_iter().rev() {
            DirBuilder::new().mode(mode).create(folder)?;
            self.folders.push(folder.to_owned());
            // Its parent may belong to the agent's user: the new folder is opened without following links, in case it was
            // replaced.
            let flags = OFlags::DIRECTORY | OFlags::NOFOLLOW | OFlags::CLOEXEC;
            let made = File::from(rustix::fs::open(folder, flags, Mode::empty())?);
            made.set_permissions(Permissions::from_mode(mode))?;
            if let Some(Account { user, group }) = owner {
                fchown(&made, Some(user), Some(group))?;
            }
        }
        Ok(())
    }

    fn finish(mut self) -> anyhow::Result<()> {
        self.folders.clear();
        // Files that are not in place when one fails are removed when this is dropped.
        while let Some((beside, place)) = self.files.first().cloned() {
            fs::rename(&beside, &place).with_context(|| {
                format!("cannot put {} in its place; run it again, which does the rest", place.display())
            })?;
            self.files.remove(0);
            let folder = place.parent().unwrap_or(Path::new("/"));
            File::open(folder)
                .and_then(|folder| folder.sync_all())
                .with_context(|| folder.display().to_string())?;
        }
        Ok(())
    }
}

impl Drop for Staged {
    fn drop(&mut self) {
        for (beside, _) in &self.files {
            fs::remove_file(beside).ok();
        }
        for folder in self.folders.iter().rev() {
            fs::remove_dir(folder).ok();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disk_that_is_nearly_full_is_told_before_anything_is_written() {
        let place = Path::new("/var/lib/lutra-agent");
        assert!(enough(64 << 20, 32 << 20, place).is_ok());
        let error = enough(20 << 20, 32 << 20, place).unwrap_err().to_string();
        assert!(
            error.contains("20 MiB free and 49 are needed") && error.contains("Nothing was changed"),
            "{error}"
        );
    }

    #[test]
    fn what_fails_half_way_leaves_nothing() {
        let root = tempfile::tempdir().unwrap();
        let destination = |path: PathBuf| Destination {
            path,
            bytes: b"x".to_vec(),
            mode: 0o640,
            owner: None,
            folder_mode: 0o755,
            folder_owner: None,
        };
        fs::write(root.path().join("file"), "no folder").unwrap();
        let due = [destination(root.path().join("etc/lutra/a")), destination(root.path().join("file/b"))];
        let error = format!("{:#}", put(&due).unwrap_err());
        assert!(error.contains("nothing was changed"), "{error}");
        assert!(!root.path().join("etc").exists(), "neither file nor folder is left");
    }
}
