//! What `archive compress` and `history compress` have in common.

use anyhow::bail;
use shore::clock;
use units::UtcTime;

/// After how many days something is compressed, and the time now. `key` is that of the configuration, `what` is compressed.
///
/// # Errors
/// The configuration turns it off and the command line does not say, or the clock cannot be right.
pub(super) fn when(
    given: Option<u16>,
    (key, configured): (&str, u16),
    what: &str,
) -> anyhow::Result<(u16, UtcTime)> {
    if given.is_none() && configured == 0 {
        bail!("{key} is 0, so no {what} is compressed: give --after-days DAYS");
    }
    let now = clock::now();
    if let Err(why) = clock::check(now) {
        bail!("no {what} is compressed: {why}");
    }
    Ok((given.unwrap_or(configured), now))
}
