//! Contents of a data folder: the names that Lutra makes in it, and how a data folder is recognised.
//!
//! A typo in `--data` may name a home folder or a whole disk. There nothing is created, and no permissions are changed.

use anyhow::{Context as _, bail, ensure};
use std::fs;
use std::io;
use std::path::Path;

/// Files of a data folder or a backup.
const FILES: [&str; 12] = [
    "app.db",
    "app.db-wal",
    "app.db-shm",
    "app.db-journal",
    "app.db.part",
    "backup.json",
    "backup.json.new",
    "backup.lock",
    "fleet.lock",
    "imports.json",
    "imports.json.new",
    "lock",
];
/// Folders with the history in it.
const HISTORIES: [&str; 4] = ["history", "history.new", "history.old", "history.aside"];
/// Folders with files of Lutra's alone.
const FOLDERS: [&str; 11] = [
    "alternate",
    "aside",
    "charts",
    "doors",
    "fleet",
    "logbook",
    "outside",
    "sinks",
    "tls",
    "uploads",
    "vpn",
];
/// Any of these marks a folder as made by Lutra, whatever else it holds. Lutra's other names are too common: many homes
/// have an `archive`.
const MARKS: [&str; 8] = [
    "app.db",
    "archive/definitions",
    "archive/gaps.jsonl",
    "backup.json",
    "charts/chart.gpkg",
    "doors/udp.json",
    "history/catalogue.sqlite",
    "tls/ca-key.pem",
];
/// What a new folder may hold: the entry of every new file system, and the configuration.
const NO_MATTER: [&str; 2] = ["lost+found", "server.toml"];

/// Files of a day of the archive.
const DAY_FILES: [&str; 5] = ["Data.lsf", "Data.lsf.zst", "Arrivals.idx", "Arrivals.zst", "IMC.xml.gz"];

/// Working folder of a restore: inside the data folder or, prefixed with the data folder's name, beside it.
pub const RESTORING: &str = ".restoring";

/// Whether Lutra makes this entry, given by its path below the data folder.
pub fn is_ours(way: &[&str], is_folder: bool) -> bool {
    match way {
        [name] if is_folder => *name == "archive" || HISTORIES.contains(name) || FOLDERS.contains(name),
        [name] => FILES.contains(name),
        ["archive", name] if is_folder => is_system(name) || ["definitions", "packing"].contains(name),
        ["archive", name] => {
            name.starts_with("gaps.jsonl") || ["shortened.jsonl", "trimmed", "format.json"].contains(name)
        }
        ["archive", "definitions", name] => !is_folder && name.starts_with("IMC-"),
        ["archive", "packing", name] => !is_folder && DAY_FILES.contains(name),
        ["archive", system, day] => is_folder && is_system(system) && is_day(day),
        ["archive", system, day, name] => {
            !is_folder && DAY_FILES.contains(name) && is_system(system) && is_day(day)
        }
        [folder, name] if HISTORIES.contains(folder) => {
            !is_folder && (name.contains(".sqlite") || *name == "refused")
        }
        ["vpn", "openvpn"] => is_folder,
        ["vpn", "openvpn", name] => is_folder == (*name == "lutra.ccd"),
        ["vpn", "openvpn", "lutra.ccd", _] => !is_folder,
        [folder, _] => !is_folder && FOLDERS.contains(folder),
        _ => false,
    }
}

fn is_system(name: &str) -> bool {
    name.strip_prefix("0x").is_some_and(|hex| hex.len() == 4 && u16::from_str_radix(hex, 16).is_ok())
}

/// `20261121`, or a further part of it, `20261121-2`.
fn is_day(name: &str) -> bool {
    let (day, part) = name.split_once('-').unwrap_or((name, "2"));
    day.len() == 8
        && (1..=2).contains(&part.len())
        && (day.bytes().chain(part.bytes())).all(|byte| byte.is_ascii_digit())
}

/// Refuses a folder that holds other files and none of Lutra's. An absent or empty one is accepted.
///
/// # Errors
/// It is such a folder, or it cannot be read.
pub fn check(folder: &Path) -> anyhow::Result<()> {
    let entries = match fs::read_dir(folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        other => other.with_context(|| {
            format!(
                "cannot read {} (let the user who runs this read the folder and all in it)",
                folder.display()
            )
        })?,
    };
    ensure!(
        !folder.join(RESTORING).exists(),
        "a restore into {} was broken off, or is under way: run `lutra-server restore BACKUP --data {}` to its end",
        folder.display(),
        folder.display()
    );
    let mut foreign = Vec::new();
    for entry in entries {
        let entry = entry.with_context(|| folder.display().to_string())?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let is_folder = entry.file_type().with_context(|| entry.path().display().to_string())?.is_dir();
        if !is_ours(&[&name], is_folder) && !NO_MATTER.contains(&name.as_str()) {
            foreign.push(name);
        }
    }
    let Some(first) = foreign.iter().min() else { return Ok(()) };
    if is_there(folder) {
        return Ok(());
    }
    bail!(
        "{} is not a folder of Lutra's: it holds {first}, and nothing that a server wrote. Nothing was changed; choose an \
         empty or a new folder, or that of a server",
        folder.display()
    )
}

/// Whether Lutra has written data into this folder.
pub fn is_there(folder: &Path) -> bool {
    MARKS.iter().any(|mark| folder.join(mark).exists()) || has_days(&folder.join("archive"))
}

/// Refuses a folder with data of a later version that this one would misread. Nothing is written, not even a lock.
///
/// # Errors
/// It is such a folder; the error says what to do. Or it cannot be read.
pub fn refuse_newer(folder: &Path) -> anyhow::Result<()> {
    store::refuse_newer(folder)?;
    crate::identity::refuse_newer(folder)?;
    Ok(())
}

fn has_days(archive: &Path) -> bool {
    fs::read_dir(archive)
        .is_ok_and(|entries| entries.flatten().any(|entry| entry.file_name().to_str().is_some_and(is_system)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_known_by_what_lutra_makes_alone() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        check(&at("absent")).unwrap();
        check(folder.path()).unwrap();
        // A new disk, with the configuration, after a start that was killed early.
        fs::create_dir(at("lost+found")).unwrap();
        fs::create_dir(at("archive")).unwrap();
        fs::write(at("server.toml"), "").unwrap();
        check(folder.path()).unwrap();
        fs::write(at("letter.txt"), "x").unwrap();
        let told = check(folder.path()).unwrap_err().to_string();
        assert!(told.contains(&folder.path().display().to_string()) && told.contains("letter.txt"), "{told}");
        assert!(told.contains("choose an empty or a new folder, or that of a server"), "{told}");
        for mark in ["app.db", "archive/0x0801"] {
            fs::create_dir(at(mark)).unwrap();
            check(folder.path()).unwrap();
            fs::remove_dir(at(mark)).unwrap();
            check(folder.path()).unwrap_err();
        }
        check(&at("letter.txt")).unwrap_err();
    }

    #[test]
    fn files_of_openvpn_are_ours_and_what_lies_among_them_is_not() {
        assert!(is_ours(&["vpn", "openvpn"], true) && is_ours(&["vpn", "openvpn", "lutra.ccd"], true));
        assert!(is_ours(&["vpn", "openvpn", "lutra.conf"], false));
        assert!(is_ours(&["vpn", "openvpn", "lutra.ccd", "otter-01"], false));
        assert!(!is_ours(&["vpn", "openvpn", "letters"], true) && !is_ours(&["vpn", "letters"], true));
        assert!(!is_ours(&["vpn", "openvpn", "lutra.ccd", "letters"], true));
    }
}
