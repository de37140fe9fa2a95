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

/// What a supervisor asked for, and how that stands; where another's remedy runs `instead`, that one. `blind`: the position is
/// not known.
pub(super) fn now_values(
    (remedy, standing): (&Remedy, Standing),
    instead: Option<&Remedy>,
    blind: bool,
) -> Vec<(&'static str, String)> {
    let deed = instead.unwrap_or(remedy);
    let mut values = remedy_values(("now", "now_plan"), deed);
    let stands = match standing {
        Standing::Holds if blind && *deed != Remedy::Stop => "blind",
        Standing::Holds if instead.is_some() => "outranked",
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_runs_in_place_of_a_demand_is_what_happens_now() {
        let run = |plan: &str| Remedy::Run { plan_id: plan.to_owned() };
        let coded = |standing, instead: Option<Remedy>, blind| {
            let values = now_values((&run("berth"), standing), instead.as_ref(), blind);
            values.iter().map(|(name, value)| format!("{name}={value}")).collect::<Vec<_>>().join(";")
        };
        assert_eq!(coded(Standing::Holds, None, false), "now=run;now_plan=berth;stands=holds");
        let home = || Some(run("home"));
        assert_eq!(coded(Standing::Holds, home(), false), "now=run;now_plan=home;stands=outranked");
        assert_eq!(coded(Standing::Holds, home(), true), "now=run;now_plan=home;stands=blind");
        assert_eq!(coded(Standing::Holds, Some(run("a;b")), false), "", "the sentence has it");
        assert_eq!(coded(Standing::AtRest, None, false), "now=run;now_plan=berth;stands=at_rest");
    }
}
