//! The demo's guide, printed once.

use super::cut::Times;
use super::fleet::{FISH, Otter};
use super::past::Past;
use std::fmt;

/// What the demo shows.
pub(super) struct Guide<'a> {
    pub(super) url: &'a str,
    pub(super) first: &'a Otter,
    pub(super) fish: bool,
    pub(super) past: Option<&'a Past>,
    pub(super) cut: Option<&'a (Times, Otter)>,
}

impl fmt::Display for Guide<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { url, first, .. } = self;
        let vessel = |otter: &Otter| format!("{url}/vessels/{}", otter.address.0);
        write!(f, "look at   these, after logging in. Ctrl-C ends the demo.")?;
        let mut item = |place: String, words: &str| write!(f, "\n  {place}\n          {words}");
        item(format!("{url}/"), "the map, where the Otters move, and a card for each")?;
        let own = "one vessel: instruments, plots, tables; Control takes it and sends it elsewhere";
        item(vessel(first), own)?;
        if self.fish {
            let words =
                format!("what its hydrophone hears of the {FISH} tagged fish around it, also on the map");
            item(format!("{}?tab=Tags", vessel(first)), &words)?;
        }
        item(
            format!("{url}/data"),
            "what was recorded, and files of it: positions, detections, logs, any message",
        )?;
        item(format!("{url}/plans"), "what they sail, to be changed on the map and brought aboard")?;
        if let Some(past) = self.past {
            let words =
                format!("a log of {} of yesterday, replayed; it is there in some seconds", past.otter.name);
            item(format!("{url}{}", past.page()), &words)?;
        }
        if let Some((times, otter)) = self.cut {
            let (first_s, lasts_s, every_s) =
                (times.first.as_secs(), times.lasts.as_secs(), times.every.as_secs());
            let words = format!(
                "a link that is cut: after {first_s} s, for {lasts_s} s, and again every {every_s} s. The alarm, what \
                 the vessel will do, and how the gap is filled"
            );
            item(format!("{}?tab=Link+loss", vessel(otter)), &words)?;
        }
        item(
            format!("{url}/admin/connections"),
            "who is connected; next to it storage, people, tokens and the audit log",
        )
    }
}
