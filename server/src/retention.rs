//! Automatic removal of recordings: for `lutra-server prune --as-configured` and the doctor.
//!
//! The store decides what is kept ([`store::plan_unattended`]). In addition a person must look if more would be removed
//! than a month or two without a run explain, or if the backup does not hold all of it.

use crate::backups;
use crate::config::{Config, Keep};
use anyhow::Context as _;
use shore::backup::Held;
use shore::clock;
use std::fs;
use std::os::unix::fs::MetadataExt as _;
use std::path::Path;
use store::{Check, Health, Keeping, Removal, Share, Unattended};
use units::UtcTime;

/// What the next run would do.
#[derive(Debug)]
pub(crate) struct Next {
    /// What is removed, or why not.
    pub(crate) verdict: Verdict,
    /// Additional notes.
    pub(crate) notes: Vec<String>,
}

/// How old recordings are treated.
#[derive(Debug)]
pub(crate) enum Verdict {
    /// All is kept.
    Off,
    /// Nothing is old enough.
    Nothing,
    /// These are removed.
    Goes(Vec<Removal>),
    /// A person must look: the reason and remedy.
    Refused(String),
}

/// Determines the next run. With `reads` everything to be removed is compared byte by byte with the backup; otherwise only
/// lengths are.
///
/// # Errors
/// The data folder or the backup cannot be read.
pub(crate) fn next(config: &Config, now: UtcTime, reads: bool) -> anyhow::Result<Next> {
    let Keep { history_days, archive_days } = config.retention;
    if history_days == 0 && archive_days == 0 {
        return Ok(Next { verdict: Verdict::Off, notes: Vec::new() });
    }
    if let Err(told) = clock::check(now) {
        return Ok(Next { verdict: Verdict::Refused(told), notes: Vec::new() });
    }
    let keeping = Keeping { history_days, archive_days, earliest: clock::EARLIEST, now };
    let plan = store::plan_unattended(&config.data, &keeping)?;
    let mut notes: Vec<String> = undatable(&plan, &config.data, now).into_iter().collect();
    let verdict = judge(config, plan, reads, &mut notes)?;
    Ok(Next { verdict, notes })
}

fn judge(config: &Config, plan: Unattended, reads: bool, notes: &mut Vec<String>) -> anyhow::Result<Verdict> {
    if plan.removals.is_empty() {
        return Ok(Verdict::Nothing);
    }
    let much = too_much(plan.days, "days of the archive", "archive")
        .or_else(|| too_much(plan.months, "months of the history", "history"));
    if let Some(why) = much {
        return Ok(Verdict::Refused(why));
    }
    let folder = &config.backup.folder;
    let lacks = if folder.as_os_str().is_empty() {
        Some("backup.folder is empty".to_owned())
    } else {
        let absent = || format!("backup.folder {} is not there", folder.display());
        backups::is_there(folder).map_or_else(Some, |is_there| (!is_there).then(absent))
    };
    if let Some(which) = lacks {
        return Ok(Verdict::Refused(format!(
            "no recordings are deleted without a backup, and {which}: mount a second disk, name a folder on it by backup.folder, and run \
             `lutra-server backup`"
        )));
    }
    if is_one_folder(folder, &config.data)? {
        return Ok(Verdict::Refused(format!(
            "backup.folder {} and the data folder {} are the same folder, or one is inside the other, so there is no second copy. \
             Set backup.folder to a folder on another disk",
            folder.display(),
            config.data.display()
        )));
    }
    let held = Held::read(folder)?;
    for removal in &plan.removals {
        let path = removal.path.strip_prefix(&config.data).unwrap_or(&removal.path);
        let lacks = held.lacks(&config.data, path, reads).context("cannot ask the backup")?;
        if let Some(why) = lacks {
            return Ok(Verdict::Refused(format!(
                "the backup in {}, made {}, does not hold all that would go: {why}. Run `lutra-server backup`, and look at both \
                 disks if it says so again",
                folder.display(),
                clock::written(held.made())
            )));
        }
    }
    if held.is_on_disk_of(&config.data) {
        notes.push(format!(
            "the backup in {} is on the disk of the data: deleting recordings frees no room, and the loss of that disk takes both",
            folder.display()
        ));
    }
    Ok(Verdict::Goes(plan.removals))
}

/// Whether two folders are the same or one is inside the other, also through links.
fn is_one_folder(one: &Path, other: &Path) -> anyhow::Result<bool> {
    let whole = |path: &Path| path.canonicalize().with_context(|| format!("cannot find {}", path.display()));
    let (one, other) = (whole(one)?, whole(other)?);
    let inode = |path: &Path| fs::metadata(path).map(|about| (about.dev(), about.ino()));
    Ok(one.starts_with(&other) || other.starts_with(&one) || inode(&one)? == inode(&other)?)
}

fn too_much(share: Share, what: &str, which: &str) -> Option<String> {
    let Share { there, going, before: Some(before), most } = share else { return None };
    let before = before.civil();
    let date = format!("{:04}-{:02}-{:02}", before.year, before.month, before.day);
    share.is_much().then(|| {
        format!(
            "{going} of {there} {what} would go, and no more than {most} go unconfirmed: see whether [retention] and the dates \
             in the data folder are right, then do it by hand, with the server stopped: lutra-server prune --{which}-before {date} \
             (it says what would go; --yes does it)"
        )
    })
}

fn undatable(plan: &Unattended, data: &Path, now: UtcTime) -> Option<String> {
    let name = |path: &std::path::PathBuf| path.strip_prefix(data).unwrap_or(path).display().to_string();
    let names: Vec<String> = plan.undatable.iter().take(5).map(name).collect();
    let more = plan.undatable.len().saturating_sub(names.len());
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    (!names.is_empty()).then(|| {
        format!(
            "these dates cannot be right: the clock was wrong then, or this computer's clock is wrong now ({}). They are kept, and \
             do not count: {}{more}",
            clock::written(now),
            names.join(", ")
        )
    })
}

/// Name of the check.
pub(crate) const NAME: &str = "retention";

/// For the doctor.
pub(crate) fn check(config: &Config, now: UtcTime) -> Check {
    let name = NAME;
    let Next { verdict, notes } = match next(config, now, false) {
        Ok(next) => next,
        Err(error) => {
            let remedy = "look whether data folder and backup can be read".to_owned();
            return Check { name, health: Health::Problem, found: format!("{error:#}"), remedy };
        }
    };
    let (health, found) = match verdict {
        Verdict::Off => (Health::Good, "all recordings are kept".to_owned()),
        Verdict::Nothing => (Health::Good, "no recordings are old enough to be deleted".to_owned()),
        Verdict::Goes(removals) => (Health::Good, told(&removals, &config.data)),
        Verdict::Refused(why) => {
            (Health::Warning, format!("nothing is deleted until a person has looked: {why}"))
        }
    };
    let health = if notes.is_empty() { health } else { Health::Warning };
    let found = std::iter::once(found).chain(notes).collect::<Vec<_>>().join("; ");
    Check { name, health, found, remedy: String::new() }
}

fn told(removals: &[Removal], data: &Path) -> String {
    let mib = removals.iter().map(|removal| removal.bytes).sum::<u64>() >> 20;
    let name =
        |removal: &Removal| removal.path.strip_prefix(data).unwrap_or(&removal.path).display().to_string();
    let (first, last) =
        (removals.first().map(name).unwrap_or_default(), removals.last().map(name).unwrap_or_default());
    format!("the next `prune --as-configured` takes {} items, {mib} MiB: {first} to {last}", removals.len())
}
