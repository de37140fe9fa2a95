//! What a supervisor does, and does next if things stay as they are: as a sentence for people, and as names and values of which programs
//! make words in their readers' language.

use super::clock_text;
use crate::arbiter::Standing;
use crate::bus::Bus;
use mission::{Outlook, Remedy};

pub(super) fn outlook_text(bus: &Bus, outlook: &Outlook) -> String {
    let Some(at) = outlook.at else { return outlook.remedy.to_string() };
    format!("{} at {}", outlook.remedy, clock_text(bus, at))
}

/// The same without its time. `acted`: something is in force already, so that no outlook means nothing further.
pub(super) fn next_values(outlook: Option<&Outlook>, acted: bool) -> Vec<(&'static str, String)> {
    let code = |code: &str| vec![("then", code.to_owned())];
    match outlook {
        None if acted => code("nothing"),
        None => code("carry_on"),
        Some(outlook) => remedy_values(("then", "plan"), &outlook.remedy),
    }
}

/// What a supervisor asked for, and how that stands. `blind`: the position is not known.
pub(super) fn now_values(remedy: &Remedy, standing: Standing, blind: bool) -> Vec<(&'static str, String)> {
    let mut values = remedy_values(("now", "now_plan"), remedy);
    let stands = match standing {
        Standing::Holds if blind && *remedy != Remedy::Stop => "blind",
        Standing::Holds => "holds",
        Standing::Waits(_) => "waits",
        Standing::AtRest => "at_rest",
        Standing::Settled => "settled",
    };
    if !values.is_empty() {
        values.push(("stands", stands.to_owned()));
    }
    values
}

/// A plan whose name would not come back out of a list of names and values is left out: the sentence has that one.
fn remedy_values((name, plan): (&'static str, &'static str), remedy: &Remedy) -> Vec<(&'static str, String)> {
    match remedy {
        Remedy::Hold => vec![(name, "hold".to_owned())],
        Remedy::Stop => vec![(name, "stop".to_owned())],
        Remedy::Run { plan_id } if plan_id.contains(';') => Vec::new(),
        Remedy::Run { plan_id } => vec![(name, "run".to_owned()), (plan, plan_id.clone())],
    }
}
