//! Whether the configured backup protects: its folder lies on a disk of its own, and what is there is whole and not old.
//!
//! A disk that is not mounted leaves its folder behind, on the disk below: there a backup would fill the disk of the data, or the
//! root disk, without which nothing runs. So the folder's disk is compared with both ([`place`]), before each backup that
//! goes by the configuration and, while the server runs, every ten minutes ([`Watched`]).

use crate::config::{self, Config};
use shore::backup::{self, Held};
use shore::clock;
use std::os::unix::fs::MetadataExt as _;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use store::{Check, Health};
use tokio::sync::watch;
use tokio_util::sync::CancellationToken;
use units::UtcTime;

/// How often a running server looks.
const LOOK_EVERY: Duration = Duration::from_mins(10);
const HOUR_US: i64 = 3_600_000_000;

/// Where `backup.folder` lies.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Place {
    /// Nobody wants a backup: the folder is empty.
    Off,
    /// The folder of the packages, which nobody has made yet.
    NotSetUp,
    /// It cannot be used: why, and what to do.
    Refused(String),
    /// On a disk where it may lie.
    Usable,
}

/// Where the configured folder lies.
pub(crate) fn place(config: &Config) -> Place {
    let folder = &config.backup.folder;
    if folder.as_os_str().is_empty() {
        return Place::Off;
    }
    if config.backup.on_any_disk {
        return Place::Usable;
    }
    if !folder.exists() && *folder == config::Backup::default().folder {
        return Place::NotSetUp;
    }
    let disk = |path: &Path| std::fs::metadata(path).map(|about| about.dev()).ok();
    // One that is not there yet comes to the disk of the folder that is to hold it.
    let holds = folder.ancestors().find_map(disk);
    wrong_disk(holds, disk(&config.data), disk(Path::new("/"))).map_or(Place::Usable, |which| {
        let place = if folder.exists() { "lies" } else { "is not there, and would come to lie" };
        Place::Refused(format!(
            "backup.folder {} {place} on {which}: is its own disk mounted? Mount it there, or name a folder on another disk; \
             backup.on_any_disk = true if it shall lie there all the same",
            folder.display()
        ))
    })
}

/// On which disk a backup does not belong, if it lies there. Each is the number of a file system.
fn wrong_disk(folder: Option<u64>, data: Option<u64>, root: Option<u64>) -> Option<&'static str> {
    if folder.is_some() && folder == data {
        return Some("the disk of the data, which it would fill, and with which it would be lost");
    }
    (data.is_some() && folder == root)
        .then_some("the root disk, which it would fill, while the data has another one")
}

/// The configured backup as it was found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct State {
    /// When the newest whole backup was made; `None` without a backup, or where it cannot be reached.
    pub(crate) made: Option<UtcTime>,
    /// Why it does not protect, with the remedy; `None` while it does, or where no backup is wanted.
    pub(crate) trouble: Option<String>,
    /// Whether somebody set a backup up.
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
                "no backup is made: backup.folder {} is not there. Mount a second disk there, or set backup.folder = \"\" if \
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

/// What the age of a backup says against it.
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
    let asides = backup::asides(folder).unwrap_or_default();
    asides.first().map(|aside| {
        format!("a person must look at {}, and then remove it: see `lutra-server backup`", aside.display())
    })
}

/// For the doctor.
pub(crate) fn check(config: &Config, now: UtcTime) -> Check {
    let name = "backup";
    let State { made, trouble, .. } = look(config, now);
    let found = match (&made, trouble) {
        (_, Some(trouble)) => {
            return Check { name, health: Health::Warning, found: trouble, remedy: String::new() };
        }
        (None, None) => "none is wanted: backup.folder is empty".to_owned(),
        (Some(made), None) => {
            format!("the one in {} is of {}", config.backup.folder.display(), clock::written(*made))
        }
    };
    Check { name, health: Health::Good, found, remedy: String::new() }
}

/// The backup as a running server saw it last. It is looked at apart: a disk that hangs holds up nobody.
#[derive(Debug, Clone)]
pub(crate) struct Watched(watch::Sender<Option<State>>);

impl Watched {
    pub(crate) fn new() -> Self {
        Self(watch::Sender::new(None))
    }

    /// As it was found last; `None` before the first look has come to its end.
    pub(crate) fn state(&self) -> Option<State> {
        self.0.borrow().clone()
    }

    /// Looks until the server ends.
    pub(crate) async fn keep(self, config: Arc<Config>, clock: clock::Clock, stop: CancellationToken) {
        let mut every = tokio::time::interval(LOOK_EVERY);
        every.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        while stop.run_until_cancelled(every.tick()).await.is_some() {
            let (config, now) = (config.clone(), clock.utc());
            let looked = tokio::task::spawn_blocking(move || look(&config, now));
            match stop.run_until_cancelled(looked).await {
                None => return,
                Some(Ok(state)) => self.take(state),
                Some(Err(error)) => tracing::error!(%error, "the backup could not be looked at"),
            }
        }
    }

    /// Takes over what was found. When the last one was made stays known while it cannot be reached, so that its age grows on.
    fn take(&self, mut state: State) {
        let before = self.state().unwrap_or(State { made: None, trouble: None, is_set_up: false });
        state.made = state.made.or(before.made);
        match (&before.trouble, &state.trouble) {
            // Where nobody set one up, each start would say so: the doctor does.
            (None, Some(trouble)) if !state.is_set_up => tracing::debug!("{trouble}"),
            (None, Some(trouble)) => tracing::warn!("{trouble}"),
            (Some(_), None) => tracing::info!("the backup is well again"),
            _ => {}
        }
        self.0.send_replace(Some(state));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    const DATA: Option<u64> = Some(1);
    const ROOT: Option<u64> = Some(2);
    const OWN: Option<u64> = Some(3);

    #[test]
    fn a_backup_belongs_on_a_disk_of_its_own() {
        assert_eq!(wrong_disk(OWN, DATA, ROOT), None);
        assert!(wrong_disk(DATA, DATA, ROOT).unwrap().contains("disk of the data"));
        // Its disk is not mounted, and the folder is the bare one below.
        assert!(wrong_disk(ROOT, DATA, ROOT).unwrap().contains("root disk"));
        assert!(wrong_disk(ROOT, ROOT, ROOT).unwrap().contains("disk of the data"));
        assert_eq!(wrong_disk(OWN, ROOT, ROOT), None);
    }

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
        assert_eq!(check(&config, now).health, Health::Good);
        assert_eq!(trouble(&config, later(47)), "");
        assert!(
            trouble(&config, later(50)).contains("due every 24 hours"),
            "{}",
            trouble(&config, later(50))
        );
        assert!(
            look(&config, later(50)).made.is_some() && check(&config, later(50)).health == Health::Warning
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

    #[test]
    fn when_the_last_one_was_made_stays_known_while_its_disk_is_away() {
        let (watched, made) = (Watched::new(), Some(UtcTime::from_micros(7)));
        let away = State { made: None, trouble: Some("away".to_owned()), is_set_up: true };
        watched.take(State { made, trouble: None, ..away.clone() });
        watched.take(away.clone());
        assert_eq!(watched.state(), Some(State { made, ..away }));
    }
}
