//! Which days of a store may be removed unattended.
//!
//! A wrong clock must not delete a season, neither the clock that named the days nor today's. So no age is computed: a
//! number of the newest days *with recordings* stay, however far apart they are. A day whose date is wrong by years
//! displaces one day, not all of them. Undated data (before [`Keeping::earliest`], or after [`Keeping::now`]) is neither
//! counted nor removed; leaving it out can only keep more. Winters without a boat do not matter, where a rule about gaps
//! would stop each spring.

use crate::archive::{self, DEFINITIONS};
use crate::error::{Named as _, Result};
use crate::history;
use crate::retention::Removal;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use units::UtcTime;

/// Days with recordings that count as a month of the history.
pub const DAYS_A_MONTH: u16 = 31;
/// As many days of the archive go at once, at most.
const MOST_DAYS: usize = 62;
/// As many months of the history, at most.
const MOST_MONTHS: usize = 2;

/// The data to keep.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Keeping {
    /// The newest so many days with recordings, from which whole months are made, in the history; 0: all.
    pub history_days: u16,
    /// The newest so many days with recordings in the archive, whichever vessels they are of; 0: all.
    pub archive_days: u16,
    /// No recording can be older.
    pub earliest: UtcTime,
    /// The present.
    pub now: UtcTime,
}

/// The data that would be removed.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Unattended {
    /// Months of the history, then days of the archive.
    pub removals: Vec<Removal>,
    /// Days of the archive that have a date that cannot be. They stay.
    pub undatable: Vec<PathBuf>,
    /// Days of the archive.
    pub days: Share,
    /// Months of the history.
    pub months: Share,
}

/// How much of something would go.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Share {
    /// So many are there and can be dated.
    pub there: usize,
    /// So many would go.
    pub going: usize,
    /// When the oldest that stays began, where something goes.
    pub before: Option<UtcTime>,
    /// So many may go at once, at most: about two months, and never more than a third of what is there.
    pub most: usize,
}

impl Share {
    /// Whether more would go than a month or two of waiting explains: a slip of the finger, or a clock.
    pub const fn is_much(self) -> bool {
        self.going > self.most
    }
}

/// The data that would be removed by that.
///
/// # Errors
/// When folders cannot be read.
pub fn plan_unattended(data: &Path, keeping: &Keeping) -> Result<Unattended> {
    let mut plan = Unattended::default();
    months(data, keeping, &mut plan)?;
    days(data, keeping, &mut plan)?;
    Ok(plan)
}

fn months(data: &Path, keeping: &Keeping, plan: &mut Unattended) -> Result<()> {
    let folder = data.join("history");
    let mut dated = Vec::new();
    for key in history::months(&folder)? {
        // Undated data is stored separately, and stays.
        let Some((start_us, end_us)) = key.range_us() else { continue };
        let path = folder.join(key.file_name());
        // These are times by vessels' clocks: logs of earlier years were brought in. They are few, and stay.
        if end_us > keeping.earliest.micros() && start_us <= keeping.now.micros() {
            dated.push((UtcTime::from_micros(start_us), path));
        }
    }
    let starts = dated.iter().map(|(start, _)| *start).collect();
    // The newest month is not a whole one.
    let keep = keeping.history_days.div_ceil(DAYS_A_MONTH);
    plan.months = share(&starts, if keep == 0 { 0 } else { keep + 1 }, MOST_MONTHS);
    for (_, path) in dated.into_iter().filter(|(start, _)| plan.months.goes(*start)) {
        let bytes = fs::metadata(&path).named(&path)?.len();
        plan.removals.push(Removal { path, bytes });
    }
    Ok(())
}

fn days(data: &Path, keeping: &Keeping, plan: &mut Unattended) -> Result<()> {
    let root = data.join("archive");
    let mut dated = Vec::new();
    for key in archive::days(&root)? {
        let path = key.folder(&root);
        match key.start() {
            Some(start) if (keeping.earliest..=keeping.now).contains(&start) => dated.push((start, path)),
            _ => plan.undatable.push(path),
        }
    }
    let starts = dated.iter().map(|(start, _)| *start).collect();
    plan.days = share(&starts, keeping.archive_days, MOST_DAYS);
    for (_, path) in dated.into_iter().filter(|(start, _)| plan.days.goes(*start)) {
        let definitions = fs::metadata(path.join(DEFINITIONS)).map_or(0, |file| file.len());
        let bytes = archive::bytes::disk_bytes(&path) + definitions;
        plan.removals.push(Removal { path, bytes });
    }
    Ok(())
}

/// The items to remove when the newest `keep` of these stay; 0 keeps all.
fn share(starts: &BTreeSet<UtcTime>, keep: u16, most: usize) -> Share {
    let there = starts.len();
    let going = if keep == 0 { 0 } else { there.saturating_sub(keep.into()) };
    let before = (going > 0).then(|| starts.iter().nth(going).copied()).flatten();
    Share { there, going, before, most: most.min(there / 3) }
}

impl Share {
    fn goes(self, start: UtcTime) -> bool {
        self.before.is_some_and(|before| start < before)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::archive::{DATA, DayKey};
    use imc::Address;
    use proptest::prelude::*;

    const DAY_US: i64 = 86_400_000_000;
    /// 2024-01-01 and 2026-11-21.
    const EARLIEST: UtcTime = UtcTime::from_micros(1_704_067_200_000_000);
    const NOW: UtcTime = UtcTime::from_micros(1_795_248_000_000_000);

    fn keeping(archive_days: u16) -> Keeping {
        Keeping { history_days: 0, archive_days, earliest: EARLIEST, now: NOW }
    }

    fn day(days_ago: i64) -> String {
        DayKey::of(Address(0x2810), UtcTime::from_micros(NOW.micros() - days_ago * DAY_US)).name()
    }

    fn record(data: &Path, days_ago: impl IntoIterator<Item = i64>) {
        for days_ago in days_ago {
            let folder = data.join("archive").join(day(days_ago));
            fs::create_dir_all(&folder).unwrap();
            fs::write(folder.join(DATA), "x").unwrap();
        }
    }

    fn gone(data: &Path, keeping: &Keeping) -> BTreeSet<PathBuf> {
        plan_unattended(data, keeping).unwrap().removals.into_iter().map(|one| one.path).collect()
    }

    #[test]
    fn days_with_recordings_count_and_winters_do_not() {
        let folder = tempfile::tempdir().unwrap();
        // Two summers of 60 days, a winter between them.
        record(folder.path(), (0..60).chain(300..360));
        assert!(gone(folder.path(), &keeping(0)).is_empty() && gone(folder.path(), &keeping(120)).is_empty());
        let plan = plan_unattended(folder.path(), &keeping(100)).unwrap();
        assert_eq!((plan.days.there, plan.days.going, plan.days.most), (120, 20, 40));
        assert!(!plan.days.is_much());
        let oldest: BTreeSet<_> =
            (340..360).map(|ago| folder.path().join("archive").join(day(ago))).collect();
        assert_eq!(gone(folder.path(), &keeping(100)), oldest);
        // Two vessels on one day are one day.
        let other = folder.path().join("archive/0x2811").join(&day(0)[7..]);
        fs::create_dir_all(&other).unwrap();
        fs::write(other.join(DATA), "x").unwrap();
        assert_eq!(gone(folder.path(), &keeping(100)), oldest);
        let much = plan_unattended(folder.path(), &keeping(36)).unwrap().days;
        assert!(much.is_much() && much.going == 84, "a third and no more: {much:?}");
    }

    #[test]
    fn dates_that_cannot_be_stay_and_push_nothing_out() {
        let folder = tempfile::tempdir().unwrap();
        record(folder.path(), 0..120);
        let before = gone(folder.path(), &keeping(100));
        // Recorded by a clock that was five years ahead, and by one that began at 1970.
        record(folder.path(), [-5 * 365, NOW.micros() / DAY_US]);
        let plan = plan_unattended(folder.path(), &keeping(100)).unwrap();
        assert_eq!(gone(folder.path(), &keeping(100)), before);
        let named: Vec<_> = plan.undatable.iter().map(|path| path.file_name().unwrap().to_owned()).collect();
        assert_eq!(named, ["19700101", "20311120"]);
        // A present that is behind keeps more; one that leads by years takes no more than days that lay in its future.
        let behind = Keeping { now: UtcTime::from_micros(NOW.micros() - 50 * DAY_US), ..keeping(100) };
        assert!(gone(folder.path(), &behind).is_empty());
        let ahead = Keeping { now: UtcTime::from_micros(NOW.micros() + 6 * 365 * DAY_US), ..keeping(100) };
        assert_eq!(gone(folder.path(), &ahead).len(), before.len() + 1);
    }

    #[test]
    fn months_of_the_history_are_counted_likewise() {
        let folder = tempfile::tempdir().unwrap();
        let history = folder.path().join("history");
        fs::create_dir_all(&history).unwrap();
        for month in ["2005-01", "2026-06", "2026-07", "2026-08", "2026-09", "2031-11"] {
            fs::write(history.join(format!("{month}.sqlite")), "x").unwrap();
        }
        fs::write(history.join("undated.sqlite"), "x").unwrap();
        let keep = |history_days| Keeping { history_days, ..keeping(0) };
        assert!(gone(folder.path(), &keep(90)).is_empty());
        assert_eq!(gone(folder.path(), &keep(62)), BTreeSet::from([history.join("2026-06.sqlite")]));
        let plan = plan_unattended(folder.path(), &keep(62)).unwrap();
        assert!(!plan.months.is_much() && plan.undatable.is_empty(), "{plan:?}");
        assert!(plan_unattended(folder.path(), &keep(31)).unwrap().months.is_much());
    }

    proptest! {
        /// Whatever days a wrong clock names, as many true days go more as there are wrong ones, at most.
        #[test]
        fn no_wrong_clock_takes_more_days_than_it_named(
            wrong in prop::collection::btree_set(-4_000_i64..30_000, 0..12),
            clock_error in -4_000_i64..4_000,
        ) {
            let folder = tempfile::tempdir().unwrap();
            record(folder.path(), 0..40);
            let right = gone(folder.path(), &keeping(35)).len();
            record(folder.path(), wrong.iter().copied());
            let now = UtcTime::from_micros(NOW.micros() + clock_error * DAY_US);
            let after = gone(folder.path(), &Keeping { now, ..keeping(35) });
            let truly: usize = (0..40).filter(|ago| after.contains(&folder.path().join("archive").join(day(*ago)))).count();
            prop_assert!(truly <= right + wrong.len(), "{truly} with {} wrong", wrong.len());
        }
    }
}
