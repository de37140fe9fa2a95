//! Warnings of the devices' drivers in the log book: each once in a while, and no more than a person can read.

use crate::bus::Bus;
use crate::entity::Entity;
use crate::output::Level;
use std::collections::BTreeMap;
use std::time::Duration;
use units::MonoTime;

/// The same warning is entered again after this time.
const AGAIN: Duration = Duration::from_mins(10);
/// Warnings of one part within that time.
const MOST: usize = 6;

/// Recent entries of each part.
#[derive(Debug, Clone, Default)]
pub(crate) struct Warnings(BTreeMap<Entity, Lately>);

#[derive(Debug, Clone, Default)]
struct Lately {
    entered: Vec<(MonoTime, String)>,
    left_out: u64,
}

impl Warnings {
    /// Enters a warning, unless the same is in the book already, or too many of this part are.
    pub(crate) fn take(&mut self, bus: &mut Bus, part: Entity, text: &str) {
        let now = bus.mono();
        let lately = self.0.entry(part).or_default();
        lately.entered.retain(|(at, _)| now.since(*at) < AGAIN);
        // Texts that differ in their numbers alone are the same.
        let words = words(text);
        if lately.entered.iter().any(|(_, before)| *before == words) || lately.entered.len() >= MOST {
            lately.left_out += 1;
            return;
        }
        lately.entered.push((now, words));
        let more = match std::mem::take(&mut lately.left_out) {
            0 => String::new(),
            count => format!(" ({count} warnings before it are in the agent's own log only)"),
        };
        bus.entry(part, Level::Warning, format!("{text}{more}"));
    }
}

fn words(text: &str) -> String {
    text.chars().filter(|c| !c.is_ascii_digit()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;
    use units::{Now, UtcTime};

    #[test]
    fn a_warning_is_entered_once_in_ten_minutes_and_a_part_that_warns_of_everything_only_so_often() {
        let at =
            |second: u64| Now { mono: MonoTime::from_micros(second * 1_000_000), utc: UtcTime::default() };
        let mut bus = Bus::new(&Settings::otter("test", imc::Address(0x2810)), at(0));
        let mut warnings = Warnings::default();
        for second in 0..300 {
            bus.begin(at(second));
            warnings.take(&mut bus, Entity::Hydrophone, &format!("{second} damaged lines"));
        }
        let text = |bus: &Bus| bus.entries().last().unwrap().text.to_str_lossy().into_owned();
        assert_eq!((bus.entries().count(), text(&bus)), (1, "0 damaged lines".to_owned()));
        bus.begin(at(700));
        warnings.take(&mut bus, Entity::Hydrophone, "700 damaged lines");
        let more = "700 damaged lines (299 warnings before it are in the agent's own log only)";
        assert_eq!((bus.entries().count(), text(&bus)), (2, more.to_owned()));
        for letter in 'a'..='z' {
            warnings.take(&mut bus, Entity::Hydrophone, &format!("something else: {letter}"));
            warnings.take(&mut bus, Entity::Gps, "of another part");
        }
        assert_eq!(bus.entries().count(), 2 + 5 + 1);
    }
}
