//! Closed days and months that should have been compressed long ago, and what keeps them from it.

use crate::archive::{ARRIVALS, DATA};
use crate::doctor::{Check, Health};
use crate::history::MonthKey;
use crate::layout::{ARCHIVE, HISTORY, free_bytes, reserved_bytes};
use crate::months::plan_months;
use crate::packing::{Packable, plan_packing};
use std::fs::{self, File};
use std::os::unix::fs::MetadataExt as _;
use std::path::Path;
use units::UtcTime;

/// Days that a server has for the work after a day is due: it looks every hour, works slowly, and may have been off.
const GRACE_DAYS: u16 = 2;

/// Checks that days are compressed `after_days` days after their end; 0 is never.
pub fn check_compression(data: &Path, after_days: u16, now: UtcTime) -> Check {
    if after_days == 0 {
        return good("days are not compressed: archive.compress_after_days is 0".to_owned());
    }
    let overdue_after = after_days.saturating_add(GRACE_DAYS);
    let days = match plan_packing(data, overdue_after, now) {
        Ok(days) => days,
        Err(error) => return warning(error.to_string(), "check the disk and the rights"),
    };
    let Some(oldest) = days.first() else {
        return good("every day that is due is compressed".to_owned());
    };
    let bytes: u64 = days.iter().map(|day| day.plain_bytes).sum();
    let found = format!(
        "{} days of systems ended more than {overdue_after} days ago and are not compressed, the oldest archive/{}, {} MiB",
        days.len(),
        oldest.key.name(),
        bytes >> 20
    );
    let root = data.join(ARCHIVE);
    let hindrance = days
        .iter()
        .find_map(|day| locked(&root, day))
        .or_else(|| no_room(&root, days.iter().map(|day| day.plain_bytes)));
    match hindrance {
        Some((why, remedy)) => warning(format!("{found}; {why}"), remedy),
        None => warning(
            found,
            "let the server run for a day; if they stay, its log says why (days of the archive are not compressed): \
             `lutra-server doctor --thorough` looks for damage, and `lutra-server archive compress` compresses them \
             at once while the server is stopped",
        ),
    }
}

/// Checks that months of the history are compressed `after_days` days after their end; 0 is never.
pub fn check_month_compression(data: &Path, after_days: u16, now: UtcTime) -> Check {
    if after_days == 0 {
        return good("months are not compressed: history.compress_after_days is 0".to_owned());
    }
    let overdue_after = after_days.saturating_add(GRACE_DAYS);
    let months = match plan_months(data, overdue_after, now) {
        Ok(months) => months,
        Err(error) => return warning(error.to_string(), "check the disk and the rights"),
    };
    let Some(oldest) = months.first() else {
        return good("every month that is due is compressed".to_owned());
    };
    let bytes: u64 = months.iter().map(|month| month.bytes).sum();
    let found = format!(
        "{} months of the history ended more than {overdue_after} days ago and are not compressed, the oldest history/{}, {} MiB",
        months.len(),
        oldest.key.file_name(),
        bytes >> 20
    );
    let root = data.join(HISTORY);
    let hindrance = months
        .iter()
        .find_map(|month| locked_month(&root, month.key))
        .or_else(|| no_room(&root, months.iter().map(|month| month.bytes)));
    match hindrance {
        Some((why, remedy)) => warning(format!("{found}; {why}"), remedy),
        None => warning(
            found,
            "let the server run for a day; if they stay, its log says why (months of the history are not compressed): \
             `lutra-server doctor --thorough` looks for damage, and `lutra-server history compress` compresses them at \
             once while the server is stopped",
        ),
    }
}

/// What keeps the server's user from replacing a month.
fn locked_month(root: &Path, key: MonthKey) -> Option<(String, &'static str)> {
    const REMEDY: &str = "let all of the history belong to the user that runs the server, with the right to write: \
                          chown -R --reference=DATA/history DATA/history, chmod -R u+rwX DATA/history";
    let (folder, file) = (fs::metadata(root).ok()?, fs::metadata(root.join(key.file_name())).ok()?);
    let is_writable =
        folder.mode() & 0o300 == 0o300 && file.uid() == folder.uid() && file.mode() & 0o600 == 0o600;
    (!is_writable).then(|| (format!("the server may not write history/{}", key.file_name()), REMEDY))
}

fn good(found: String) -> Check {
    Check { name: "compression", health: Health::Good, found, remedy: String::new() }
}

fn warning(found: String, remedy: &str) -> Check {
    Check { name: "compression", health: Health::Warning, found, remedy: remedy.to_owned() }
}

/// What keeps the server's user from reading a day or from changing its folder. The user is that of the archive: an administrator who
/// looks may do more.
fn locked(root: &Path, day: &Packable) -> Option<(String, &'static str)> {
    const REMEDY: &str = "let all of the archive belong to the user that runs the server, with the right to write: \
                          chown -R --reference=DATA/archive DATA/archive, chmod -R u+rwX DATA/archive";
    const UNREADABLE: &str = "check the disk; copy the day from a backup while the server is stopped";
    let folder = day.key.folder(root);
    let owner = fs::metadata(root).ok()?.uid();
    let own_folder = fs::metadata(&folder).ok()?;
    if own_folder.uid() != owner || own_folder.mode() & 0o300 != 0o300 {
        let why = format!("the server may not write in archive/{}", day.key.name());
        return Some((why, REMEDY));
    }
    for name in [DATA, ARRIVALS] {
        let path = folder.join(name);
        let Ok(file) = fs::metadata(&path) else { continue };
        if file.uid() != owner && file.mode() & 0o004 == 0 || file.uid() == owner && file.mode() & 0o400 == 0
        {
            let why = format!("the server may not read archive/{}/{name}", day.key.name());
            return Some((why, REMEDY));
        }
        if let Err(error) = File::open(&path) {
            return Some((format!("archive/{}/{name}: {error}", day.key.name()), UNREADABLE));
        }
    }
    None
}

/// Whether the disk has no room for any of them beside what recording needs.
fn no_room(root: &Path, bytes: impl Iterator<Item = u64>) -> Option<(String, &'static str)> {
    let smallest = bytes.min()?;
    let (free, needed) = (free_bytes(root).ok()?, reserved_bytes(root).ok()?.saturating_add(smallest));
    (free < needed).then(|| {
        let why = format!("{} MiB are free, and the smallest needs {} MiB", free >> 20, needed >> 20);
        (why, "make room: remove old months (retention), or move the data folder to a larger disk")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Accepted, Packing, Store, Transport};
    use std::os::unix::fs::PermissionsExt as _;

    const DAY_US: i64 = 86_400_000_000;
    /// 2026-11-21T08:00:00Z.
    const NOW: UtcTime = UtcTime::from_micros(1_795_248_000_000_000);

    fn recorded(data: &Path, days_ago: &[i64]) {
        let mut store = Store::open(data).unwrap();
        for days_ago in days_ago {
            let received = UtcTime::from_micros(NOW.micros() - days_ago * DAY_US);
            let header = imc::Header {
                timestamp: received.seconds(),
                src: imc::Address(0x2810),
                ..imc::Header::default()
            };
            let mut packet = Vec::new();
            imc::encode_into(&mut packet, &header, &imc::messages::Temperature { value: 1.0 }).unwrap();
            let accepted = Accepted { packet: &packet, received, transport: Transport::Tcp, link: None };
            store.accept(&accepted).unwrap();
        }
        store.close().unwrap();
    }

    #[test]
    fn days_that_stay_plain_are_named_with_what_keeps_them_so() {
        let folder = tempfile::tempdir().unwrap();
        let data = folder.path();
        recorded(data, &[9, 5, 0]);
        assert_eq!(check_compression(data, 0, NOW).health, Health::Good);
        assert_eq!(check_compression(data, 8, NOW).health, Health::Good, "it has two days for the work");
        let check = check_compression(data, 3, NOW);
        assert_eq!(check.health, Health::Warning);
        assert!(
            check.found.starts_with("1 days of systems") && check.found.contains("archive/0x2810/20261112"),
            "{check:?}"
        );
        assert!(check.remedy.contains("archive compress"), "{check:?}");

        let day = data.join("archive/0x2810/20261112");
        fs::set_permissions(&day, fs::Permissions::from_mode(0o500)).unwrap();
        let check = check_compression(data, 3, NOW);
        assert!(check.found.ends_with("may not write in archive/0x2810/20261112"), "{check:?}");
        assert!(check.remedy.contains("chown -R --reference"), "{check:?}");
        fs::set_permissions(&day, fs::Permissions::from_mode(0o700)).unwrap();
        fs::set_permissions(day.join(DATA), fs::Permissions::from_mode(0o000)).unwrap();
        let check = check_compression(data, 3, NOW);
        assert!(check.found.ends_with("may not read archive/0x2810/20261112/Data.lsf"), "{check:?}");
        fs::set_permissions(day.join(DATA), fs::Permissions::from_mode(0o600)).unwrap();

        let mut store = Store::open(data).unwrap();
        for day in plan_packing(data, 3, NOW).unwrap() {
            let mut packing = Packing::begin(data, &day).unwrap();
            while packing.work(1 << 20).unwrap() {}
            store.adopt(&mut packing).unwrap().unwrap();
        }
        assert_eq!(check_compression(data, 3, NOW).found, "every day that is due is compressed");
    }

    #[test]
    fn months_that_stay_plain_are_named_with_what_keeps_them_so() {
        let folder = tempfile::tempdir().unwrap();
        let data = folder.path();
        // October ended 20 days ago.
        recorded(data, &[40, 0]);
        assert_eq!(check_month_compression(data, 0, NOW).health, Health::Good);
        assert_eq!(
            check_month_compression(data, 19, NOW).health,
            Health::Good,
            "it has two days for the work"
        );
        let check = check_month_compression(data, 18, NOW);
        assert_eq!(check.health, Health::Warning);
        assert!(
            check.found.starts_with("1 months of") && check.found.contains("history/2026-10.sqlite"),
            "{check:?}"
        );
        assert!(check.remedy.contains("history compress"), "{check:?}");
        let month = data.join("history/2026-10.sqlite");
        fs::set_permissions(&month, fs::Permissions::from_mode(0o400)).unwrap();
        let check = check_month_compression(data, 18, NOW);
        assert!(check.found.ends_with("may not write history/2026-10.sqlite"), "{check:?}");
        fs::set_permissions(&month, fs::Permissions::from_mode(0o600)).unwrap();

        let mut store = Store::open(data).unwrap();
        for month in plan_months(data, 18, NOW).unwrap() {
            assert!(store.ready_month(month.key).unwrap());
            let packed = crate::PackedMonth::make(data, &month, &mut |_| true).unwrap();
            assert!(store.adopt_month(packed).unwrap().done().is_some());
        }
        assert_eq!(check_month_compression(data, 18, NOW).found, "every month that is due is compressed");
    }
}
