//! TLS: serving a certificate that may be replaced at any time, and a small private authority that makes one.
//!
//! A browser or vessel that trusts the authority's `ca.pem` once accepts every certificate made with it, also later ones.
//! [`Pair`] is a certificate with its key as read from their files, [`Keeper`] serves one and reloads it, [`authority`]
//! makes and renews certificates, [`x509`] reads validity and names of a certificate.

pub(crate) mod authority;
mod keeper;
mod pair;
mod x509;

pub(crate) use keeper::Keeper;
pub(crate) use pair::Pair;
pub(crate) use x509::first_in;

use units::UtcTime;

/// Days before its end from which a certificate should be renewed; the alarms use the same.
pub(crate) const TOLD_DAYS: i64 = 30;
pub(crate) const DAY_US: i64 = 86_400_000_000;

/// The day of a time (UTC), as rcgen takes it by `rcgen::date_time_ymd`.
pub(crate) fn day<T>(time: UtcTime, make: impl FnOnce(i32, u8, u8) -> T) -> T {
    let civil = time.civil();
    make(civil.year as i32, civil.month, civil.day)
}

/// Whole days until then; negative once it is over.
pub(crate) fn days_left(until: UtcTime, now: UtcTime) -> i64 {
    until.micros().saturating_sub(now.micros()).div_euclid(DAY_US)
}
