//! The disk of the configured backup: its own, or one where it gives no protection and may fill another's space.
//!
//! File systems are compared by their device numbers, and the disks below them by `/sys/dev/block`: another partition on
//! the data's disk would be lost with it. Where Linux names no disk (a network share, btrfs, overlays) only the file
//! systems are compared.

use crate::config::{self, Config};
use std::collections::BTreeSet;
use std::fs;
use std::io::{Error, ErrorKind};
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};

/// Partitions that may hold the bare mount point of a disk that is not mounted.
const OF_THE_SYSTEM: [&str; 2] = ["/", "/var"];
/// Greatest depth of stacked block devices: encryption on a volume on an array.
const DEEPEST: u32 = 8;

/// The place of `backup.folder`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Place {
    /// No backup is configured: the folder is empty.
    Off,
    /// The default folder of the packages does not exist: no backup was set up.
    NotSetUp,
    /// It cannot be used: the reason and remedy.
    Refused(String),
    /// It is on a suitable disk.
    Usable,
}

/// Determines the place of the configured folder.
pub(crate) fn place(config: &Config) -> Place {
    let folder = &config.backup.folder;
    if folder.as_os_str().is_empty() {
        return Place::Off;
    }
    if config.backup.on_any_disk {
        return Place::Usable;
    }
    let is_there = match is_there(folder) {
        Ok(is_there) => is_there,
        Err(why) => return Place::Refused(why),
    };
    if !is_there && *folder == config::Backup::default().folder {
        return Place::NotSetUp;
    }
    // A folder that does not exist yet will be on the disk of its parent.
    let holds = folder.ancestors().find_map(Disk::of);
    let (Some(holds), Some(data)) = (holds, Disk::of(&config.data)) else { return Place::Usable };
    let system = OF_THE_SYSTEM.map(|path| Disk::of(Path::new(path)));
    wrong_disk(&holds, &data, &system).map_or(Place::Usable, |which| {
        let place = if is_there { "lies" } else { "is not there, and would come to lie" };
        Place::Refused(format!(
            "backup.folder {} {place} on {which}: is its own disk mounted? Mount it there, or name a folder on another disk; \
             backup.on_any_disk = true if it shall lie there all the same",
            folder.display()
        ))
    })
}

/// Whether a folder exists.
///
/// # Errors
/// This cannot be determined, or a link is broken: the reason and remedy.
pub(crate) fn is_there(folder: &Path) -> Result<bool, String> {
    let path = folder.display();
    match fs::metadata(folder) {
        Ok(_) => Ok(true),
        Err(error) if error.kind() != ErrorKind::NotFound => Err(out_of_reach(folder, &error)),
        Err(_) => match fs::read_link(folder) {
            Ok(to) => Err(format!(
                "backup.folder {path} is a link to {}, which is not there: is its disk mounted?",
                to.display()
            )),
            Err(_) => Ok(false),
        },
    }
}

fn out_of_reach(folder: &Path, error: &Error) -> String {
    let remedy = if error.kind() == ErrorKind::PermissionDenied {
        "let the server's user in (`ls -ld` shows who may)"
    } else {
        "its disk, or the computer that shares it, may be gone: look at `findmnt`, then `umount -l` and mount it again"
    };
    format!("backup.folder {} cannot be reached ({error}): {remedy}", folder.display())
}

/// The file system and disks of a folder.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
struct Disk {
    /// The number of the file system.
    file_system: u64,
    /// The whole disks below it, as Linux names them.
    whole: BTreeSet<PathBuf>,
}

impl Disk {
    fn of(folder: &Path) -> Option<Self> {
        let file_system = fs::metadata(folder).ok()?.dev();
        let (major, minor) = (rustix::fs::major(file_system), rustix::fs::minor(file_system));
        let mut whole = BTreeSet::new();
        disks_below(Path::new(&format!("/sys/dev/block/{major}:{minor}")), DEEPEST, &mut whole);
        Some(Self { file_system, whole })
    }

    fn is_partition_beside(&self, other: &Self) -> bool {
        !self.whole.is_disjoint(&other.whole)
    }
}

/// Adds the whole disks of a block device, which is at `device` below `/sys`.
fn disks_below(device: &Path, deeper: u32, whole: &mut BTreeSet<PathBuf>) {
    let Ok(device) = device.canonicalize() else { return };
    let made_of: Vec<PathBuf> = fs::read_dir(device.join("slaves"))
        .map(|entries| entries.flatten().map(|entry| entry.path()).collect())
        .unwrap_or_default();
    if deeper > 0 && !made_of.is_empty() {
        for below in &made_of {
            disks_below(below, deeper - 1, whole);
        }
    } else if device.join("partition").exists() {
        whole.extend(device.parent().map(Path::to_owned));
    } else {
        whole.insert(device);
    }
}

/// Names the unsuitable disk that a backup is on, if so.
fn wrong_disk(folder: &Disk, data: &Disk, system: &[Option<Disk>; 2]) -> Option<&'static str> {
    if folder.file_system == data.file_system {
        return Some("the disk of the data, which it would fill, and with which it would be lost");
    }
    if folder.is_partition_beside(data) {
        return Some("another partition of the disk of the data, with which it would be lost");
    }
    let at =
        system.iter().position(|one| one.as_ref().is_some_and(|one| one.file_system == folder.file_system));
    at.map(|at| match OF_THE_SYSTEM[at] {
        "/" => "the root disk, which it would fill, while the data has another one",
        _ => "the partition of /var, which it would fill, while the data has another one",
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file system on a disk of its own, or on one that Linux does not name.
    fn disk(file_system: u64, whole: &str) -> Disk {
        let whole = if whole.is_empty() { BTreeSet::new() } else { BTreeSet::from([whole.into()]) };
        Disk { file_system, whole }
    }

    #[test]
    fn a_backup_belongs_on_a_disk_of_its_own() {
        let wrong = |folder: &Disk, data: &Disk, root: &Disk, var: &Disk| {
            wrong_disk(folder, data, &[Some(root.clone()), Some(var.clone())]).unwrap_or_default()
        };
        let (root, var) = (disk(1, "sda"), disk(2, "sda"));
        let (data, own) = (disk(3, "sdb"), disk(4, "sdc"));
        assert_eq!(wrong(&own, &data, &root, &var), "");
        assert!(wrong(&data, &data, &root, &var).contains("disk of the data"));
        // Its disk is not mounted, and the folder is the bare mount point.
        assert!(wrong(&root, &data, &root, &root).contains("root disk"));
        assert!(wrong(&var, &data, &root, &var).contains("partition of /var"));
        // One disk in partitions: /, /var with the data, and another.
        let partition = "another partition of the disk of the data";
        assert!(wrong(&root, &var, &root, &var).contains(partition));
        assert!(wrong(&disk(9, "sda"), &var, &root, &var).contains(partition));
        assert!(wrong(&var, &root, &root, &var).contains(partition));
        // Its own partition on the system's disk is suitable, if the data has another disk.
        assert_eq!(wrong(&disk(9, "sda"), &data, &root, &var), "");
        // Disks that Linux does not name are distinguished only by their file system.
        assert_eq!(wrong(&disk(9, ""), &disk(8, ""), &root, &var), "");
    }

    #[test]
    fn partitions_volumes_and_arrays_are_traced_to_their_disks() {
        let sys = tempfile::tempdir().unwrap();
        let at = |path: &str| sys.path().join(path);
        for disk in ["sda/sda1", "sda/sda2", "sdb/sdb1", "md0/slaves", "dm-0/slaves"] {
            fs::create_dir_all(at(disk)).unwrap();
        }
        for partition in ["sda/sda1", "sda/sda2", "sdb/sdb1"] {
            fs::write(at(partition).join("partition"), "1").unwrap();
        }
        let made_of = |whole: &str, part: &str| {
            let link = at(whole).join("slaves").join(Path::new(part).file_name().unwrap());
            std::os::unix::fs::symlink(at(part), link).unwrap();
        };
        made_of("md0", "sda/sda2");
        made_of("md0", "sdb/sdb1");
        made_of("dm-0", "md0");
        let disks = |device: &str| {
            let mut whole = BTreeSet::new();
            disks_below(&at(device), DEEPEST, &mut whole);
            let name = |path: &PathBuf| path.file_name().unwrap().to_string_lossy().into_owned();
            whole.iter().map(name).collect::<Vec<_>>()
        };
        assert_eq!((disks("sda/sda1"), disks("sdb")), (vec!["sda".to_owned()], vec!["sdb".to_owned()]));
        assert_eq!(disks("dm-0"), ["sda", "sdb"]);
        assert!(disks("none").is_empty());
    }

    #[test]
    fn a_link_that_leads_nowhere_and_what_cannot_be_reached_are_not_taken_for_absent() {
        let scratch = tempfile::tempdir().unwrap();
        let link = scratch.path().join("link");
        std::os::unix::fs::symlink(scratch.path().join("gone"), &link).unwrap();
        assert!(is_there(&link).unwrap_err().contains("is a link to"));
        assert_eq!((is_there(&scratch.path().join("none")), is_there(scratch.path())), (Ok(false), Ok(true)));
        // A file in place of a folder represents any other error.
        let file = scratch.path().join("file");
        fs::write(&file, "").unwrap();
        assert!(is_there(&file.join("backup")).unwrap_err().contains("cannot be reached (Not a directory"));
        // ENOTCONN: what FUSE answers when its program died.
        let why = out_of_reach(&link, &Error::from_raw_os_error(107));
        assert!(why.contains("umount -l"), "{why}");
        let mut config = Config::default();
        config.backup.folder = link;
        assert!(matches!(place(&config), Place::Refused(why) if why.contains("is a link to")));
    }
}
