//! What a supervisor does next if nothing changes: as a sentence for people, and as names and values of which programs
//! make words in their readers' language.

use super::clock_text;
use crate::bus::Bus;
use mission::{Outlook, Remedy};

pub(super) fn outlook_text(bus: &Bus, outlook: &Outlook) -> String {
    let Some(at) = outlook.at else { return outlook.remedy.to_string() };
    format!("{} at {}", outlook.remedy, clock_text(bus, at))
}

/// The same without its time. `acted`: something is in force already, so that no outlook means nothing further. A plan
/// whose name would not come back out of a list of names and values is left out: the sentence has that one.
pub(super) fn next_values(outlook: Option<&Outlook>, acted: bool) -> Vec<(&'static str, String)> {
    let code = |code: &str| vec![("then", code.to_owned())];
    match outlook.map(|outlook| &outlook.remedy) {
        None if acted => code("nothing"),
        None => code("carry_on"),
        Some(Remedy::Hold) => code("hold"),
        Some(Remedy::Stop) => code("stop"),
        Some(Remedy::Run { plan_id }) if plan_id.contains(';') => Vec::new(),
        Some(Remedy::Run { plan_id }) => vec![("then", "run".to_owned()), ("plan", plan_id.clone())],
    }
}
