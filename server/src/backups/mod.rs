//! Checks the configured backup: it must be on its own disk, complete and recent.
//!
//! If a disk is not mounted, its mount point is a folder on the disk below: a backup there would fill the disk of the data,
//! or the root disk that the system needs. So the folder's disk is compared with both (`place`), before each configured
//! backup and, while the server runs, every ten minutes (`watched`, which does not block on a disk that hangs).

mod place;
mod watched;

pub(crate) use place::{Place, is_there, place};
pub(crate) use watched::{Watched, checks};

use crate::config::Config;
use shore::backup::{self, Held};
use shore::clock;
use std::path::Path;
use store::{Check, Health};
use units::UtcTime;

const HOUR_US: i64 = 3_600_000_000;

/// The last known state of the configured backup.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct State {
    /// When the newest complete backup was made; `None` without a backup, or if it cannot be accessed.
    pub(crate) made: Option<UtcTime>,
    /// The problem and remedy; `None` if it is in order, or no backup is configured.
    pub(crate) trouble: Option<String>,
    /// Whether a backup was set up.
    pub(crate) is_set_up: bool,
}

/// Looks at the configured backup.
pub(crate) fn look(config: &Config, now: UtcTime) -> State {
    let folder = &config.backup.folder;
    let without = |trouble: Option<String>| State { made: None, trouble, is_set_up: true };
    match place(config) {
        Place::Off => return State { is_set_up: false, ..without(None) },
        Place::NotSetUp => {
            let trouble = format!(
                "no backup is configured: backup.folder {} is not there. Mount a second disk there, or set backup.folder = \"\" if \
                 none is wanted",
                folder.display()
            );
            return State { is_set_up: false, ..without(Some(trouble)) };
        }
        Place::Refused(why) => return without(Some(format!("no backup is made: {why}"))),
        Place::Usable => {}
    }
    let made = match Held::read(folder) {
        Ok(held) => held.made(),
        Err(error) => return without(Some(format!("{error:#}"))),
    };
    State { made: Some(made), ..without(aged(config, made, now).or_else(|| aside(folder))) }
}

/// The problem with a backup that is too old.
fn aged(config: &Config, made: UtcTime, now: UtcTime) -> Option<String> {
    let (folder, when) = (config.backup.folder.display(), clock::written(made));
    let age_h = now.micros().saturating_sub(made.micros()) / HOUR_US;
    if made.micros() > now.micros().saturating_add(HOUR_US) {
        return Some(format!(
            "the backup in {folder} is dated {when}, which is yet to come: this computer's clock is wrong, or was then"
        ));
    }
    (age_h > 2 * i64::from(config.backup.every_h)).then(|| {
        format!(
            "the backup in {folder} is of {when}, {age_h} hours ago, and one is due every {} hours (backup.every_h): run \
             `lutra-server backup`, and look why it was not made (`systemctl status lutra-server-backup`)",
            config.backup.every_h
        )
    })
}

fn aside(folder: &Path) -> Option<String> {
    match backup::asides(folder) {
        Ok(asides) => asides.first().map(|aside| {
            format!(
                "a person must look at {}, and then remove it: see `lutra-server backup`",
                aside.display()
            )
        }),
        Err(error) => Some(format!("{error:#}")),
    }
}

/// The result in the form of the doctor's checks.
fn checked(config: &Config, State { made, trouble, .. }: State) -> Check {
    let name = "backup";
    let found = match (&made, trouble) {
        (_, Some(trouble)) => {
            return Check { name, health: Health::Warning, found: trouble, remedy: String::new() };
        }
        (None, None) => "no backup is configured: backup.folder is empty".to_owned(),
        (Some(made), None) => {
            format!("the one in {} is of {}", config.backup.folder.display(), clock::written(*made))
        }
    };
    Check { name, health: Health::Good, found, remedy: String::new() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    /// A data folder with a backup of it, which is in the same scratch folder.
    fn backed_up(scratch: &Path) -> Config {
        let mut config = Config { data: scratch.join("data"), ..Config::default() };
        config.backup.folder = scratch.join("backup");
        fs::create_dir_all(config.data.join("archive")).unwrap();
        backup::make(&config.data, &[], &config.backup.folder, true, &mut |_| ()).unwrap();
        config
    }

    #[test]
    fn a_backup_that_does_not_protect_is_said_with_the_remedy() {
        let scratch = tempfile::tempdir().unwrap();
        let mut config = backed_up(scratch.path());
        let now = clock::now();
        let trouble = |config: &Config, now| look(config, now).trouble.unwrap_or_default();
        let later = |hours: i64| UtcTime::from_micros(now.micros() + hours * HOUR_US);

        assert!(trouble(&config, now).contains("backup.on_any_disk = true"), "{}", trouble(&config, now));
        config.backup.on_any_disk = true;
        let State { made, trouble: none, .. } = look(&config, now);
        assert!(none.is_none() && made.is_some_and(|made| (now.micros() - made.micros()).abs() < 60_000_000));
        assert_eq!(checked(&config, look(&config, now)).health, Health::Good);
        assert_eq!(trouble(&config, later(47)), "");
        assert!(
            trouble(&config, later(50)).contains("due every 24 hours"),
            "{}",
            trouble(&config, later(50))
        );
        assert!(
            look(&config, later(50)).made.is_some()
                && checked(&config, look(&config, later(50))).health == Health::Warning
        );
        assert!(trouble(&config, later(-3)).contains("yet to come"));
        fs::create_dir_all(config.backup.folder.join("aside/2026-11-26")).unwrap();
        assert!(trouble(&config, now).contains("a person must look at"));
        fs::remove_file(config.backup.folder.join("backup.json")).unwrap();
        assert!(trouble(&config, now).contains("no whole backup"));
        fs::remove_dir_all(&config.backup.folder).unwrap();
        assert!(trouble(&config, now).contains("no whole backup"));
        config.backup.on_any_disk = false;
        assert!(
            trouble(&config, now).contains("is not there, and would come to lie on the disk of the data")
        );
        config.backup.folder = std::path::PathBuf::new();
        assert_eq!((trouble(&config, now), place(&config)), (String::new(), Place::Off));
        let config = Config { data: scratch.path().join("data"), ..Config::default() };
        if !config.backup.folder.exists() {
            assert!(trouble(&config, now).contains("if none is wanted") && !look(&config, now).is_set_up);
        }
    }
}
