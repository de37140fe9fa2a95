//! Parts of a plan that are not carried out aboard, found before it is sailed.
//!
//! Nothing of a plan is dropped silently: what would change the author's intent refuses the plan; what merely
//! has no effect on a surface vessel is reported. The same text about several maneuvers is reported once, with
//! their number.

use crate::parameters::{self, ParameterError};
use crate::settings::Settings;
use imc::messages::{
    EntityParameter, LoiterDirection, Message, PlanManeuver, PlanSpecification, PlanTransition,
    SetEntityParameters,
};
use imc::{MessageList, tuples};
use mission::DraftNote;
use std::collections::BTreeMap;

/// The condition that every transition has, whatever it says.
const WHEN_DONE: &str = "ManeuverIsDone";
/// The value that consoles write where they want no attitude at a goal.
const NO_YAW: [f64; 2] = [0.0, -1.0];
/// So much of a foreign text is repeated.
const LONGEST_QUOTE: usize = 60;

/// A part that cannot be carried out: text and whether it refuses the plan.
type Finding = (bool, String);

/// All that cannot be followed in a plan.
pub(crate) fn notes(plan: &PlanSpecification, settings: &Settings) -> Vec<DraftNote> {
    let mut notes = Notes::default();
    for (list, when) in [(&plan.start_actions, "start"), (&plan.end_actions, "end")] {
        notes.actions(None, when, list, settings);
    }
    if !plan.variables.is_empty() {
        notes.add(None, (false, "the plan's variables have no effect".to_owned()));
    }
    for node in plan.maneuvers.of::<PlanManeuver>() {
        let id = node.maneuver_id.to_str_lossy();
        for (list, when) in [(&node.start_actions, "start"), (&node.end_actions, "end")] {
            notes.actions(Some(&id), when, list, settings);
        }
        for finding in node.data.get().iter().flat_map(fields) {
            notes.add(Some(&id), finding);
        }
    }
    for transition in plan.transitions.of::<PlanTransition>() {
        let from = transition.source_man.to_str_lossy();
        notes.actions(Some(&from), "transition", &transition.actions, settings);
        let condition = transition.conditions.to_str_lossy();
        if !condition.is_empty() && condition != WHEN_DONE {
            let text = format!("the condition '{}' counts as {WHEN_DONE}", quote(&condition));
            notes.add(Some(&from), (false, text));
        }
    }
    notes.finish()
}

#[derive(Debug, Default)]
struct Notes {
    /// The first maneuver that a finding is about, and how many there are.
    found: BTreeMap<Finding, (Option<String>, usize)>,
}

impl Notes {
    fn add(&mut self, maneuver: Option<&str>, finding: Finding) {
        self.found.entry(finding).or_insert_with(|| (maneuver.map(str::to_owned), 0)).1 += 1;
    }

    fn actions(&mut self, maneuver: Option<&str>, when: &str, list: &MessageList, settings: &Settings) {
        for (refuses, text) in list.iter().flatten().flat_map(|message| action(&message, settings)) {
            self.add(maneuver, (refuses, format!("{when} action: {text}")));
        }
    }

    fn finish(self) -> Vec<DraftNote> {
        let note = |((refuses, text), (maneuver, count)): (Finding, _)| match count {
            1 => DraftNote { maneuver, refuses, text },
            _ => DraftNote { maneuver, refuses, text: format!("{text} (and {} times more)", count - 1) },
        };
        self.found.into_iter().map(note).collect()
    }
}

/// Parts of an action that cannot be carried out.
fn action(message: &Message, settings: &Settings) -> Vec<Finding> {
    let known = |label: &str| match settings.labels.find(label) {
        Some(_) => Vec::new(),
        None => vec![(false, format!("there is no part '{}' aboard; nothing is done", quote(label)))],
    };
    match message {
        Message::SetEntityParameters(set) => set_parameters(set, settings),
        Message::PushEntityParameters(push) => known(&push.name.to_str_lossy()),
        Message::PopEntityParameters(pop) => known(&pop.name.to_str_lossy()),
        other => vec![(
            true,
            format!(
                "{} is not carried out aboard; only Set-, Push- and PopEntityParameters are, take it out",
                other.abbrev()
            ),
        )],
    }
}

fn set_parameters(set: &SetEntityParameters, settings: &Settings) -> Vec<Finding> {
    let label = set.name.to_str_lossy();
    let Some(entity) = settings.labels.find(&label) else {
        return vec![(false, format!("there is no part '{}' aboard; nothing is set", quote(&label)))];
    };
    let mut findings = Vec::new();
    for wanted in set.params.of::<EntityParameter>() {
        let (name, value) = (wanted.name.to_str_lossy(), wanted.value.to_str_lossy());
        let all = parameters::all();
        let parameter = all.iter().find(|parameter| parameter.entity == entity && parameter.name == name);
        match parameter.map(|parameter| parameter.try_live(settings, &value)) {
            Some(Ok(_)) => {}
            Some(Err(error)) => {
                findings.push((true, format!("{label}: {name} = {}: {error}", quote(&value))));
            }
            None if parameters::in_files(entity, &name) => {
                let error = ParameterError::FileOnly(name.into_owned());
                findings.push((true, format!("{label}: {error}")));
            }
            None => findings.push((false, format!("{label} has no parameter '{}' to set", quote(&name)))),
        }
    }
    findings
}

/// Fields of a maneuver that cannot be carried out.
fn fields(message: &Message) -> Vec<Finding> {
    let (z_m, timeout_s, custom) = match message {
        Message::Goto(m) => (m.z, m.timeout, Some(&m.custom)),
        Message::Launch(m) => (m.z, m.timeout, Some(&m.custom)),
        Message::Loiter(m) => (m.z, m.timeout, Some(&m.custom)),
        Message::StationKeeping(m) => (m.z, 0, Some(&m.custom)),
        Message::FollowPath(m) => (m.z, m.timeout, Some(&m.custom)),
        Message::FollowTrajectory(m) => (m.z, m.timeout, Some(&m.custom)),
        Message::Rows(m) => (m.z, m.timeout, Some(&m.custom)),
        Message::RowsCoverage(m) => (m.z, 0, Some(&m.custom)),
        Message::ScheduledGoto(m) => (if m.z == 0.0 { m.travel_z } else { m.z }, 0, None),
        Message::FollowSystem(m) => (m.z, 0, None),
        Message::IdleManeuver(m) => (0.0, 0, Some(&m.custom)),
        _ => (0.0, 0, None),
    };
    let mut findings = Vec::new();
    let mut left_out = |text: String| findings.push((false, text));
    // A depth below the surface is refused as such (`mission::PlanLimits::max_depth_m`).
    if z_m != 0.0 {
        left_out("z is not followed, the vessel stays on the surface".to_owned());
    }
    if timeout_s > 0 {
        left_out("the timeout is not kept, as in DUNE: a maneuver goes on until it is done".to_owned());
    }
    if let Some(custom) = custom.filter(|custom| !custom.is_empty()) {
        left_out(format!("the custom settings '{}' have no effect", quote(&custom.to_str_lossy())));
    }
    match message {
        Message::Goto(m) if !NO_YAW.contains(&m.yaw) => {
            left_out("roll, pitch and yaw at the goal are not taken up".to_owned());
        }
        Message::Loiter(m) if m.direction == LoiterDirection::Iwindcurr => {
            left_out("the direction into wind and current is sailed clockwise".to_owned());
        }
        Message::FollowReference(m) if m.altitude_interval > 0.0 => {
            left_out("the altitude interval has no effect, the vessel stays on the surface".to_owned());
        }
        Message::Teleoperation(m) => {
            let custom = m.custom.to_str_lossy();
            for (name, value) in tuples::parse(&custom) {
                match name {
                    "src" if value.parse::<imc::Address>().is_err() => {
                        findings.push((true, format!("src={} names no system that may steer", quote(value))));
                    }
                    "src" => {}
                    other => {
                        findings
                            .push((false, format!("the custom setting '{}' has no effect", quote(other))));
                    }
                }
            }
        }
        _ => {}
    }
    findings
}

/// The beginning of a foreign text.
fn quote(text: &str) -> String {
    let mut quoted: String = text.chars().take(LONGEST_QUOTE).collect();
    if quoted.len() < text.len() {
        quoted.push('…');
    }
    quoted
}

#[cfg(test)]
mod tests {
    use super::*;
    use imc::Address;
    use imc::messages as m;

    fn told(plan: &PlanSpecification) -> Vec<(Option<String>, bool, String)> {
        let notes = notes(plan, &Settings::otter("test", Address(0x2810)));
        notes.into_iter().map(|note| (note.maneuver, note.refuses, note.text)).collect()
    }

    fn with(data: impl Into<Message>, start: Vec<Message>) -> PlanManeuver {
        PlanManeuver {
            maneuver_id: "a".into(),
            data: imc::Nested::from(data),
            start_actions: start.into_iter().collect(),
            ..PlanManeuver::default()
        }
    }

    fn plan(nodes: Vec<PlanManeuver>) -> PlanSpecification {
        PlanSpecification { maneuvers: nodes.into_iter().collect(), ..PlanSpecification::default() }
    }

    fn set(name: &str, parameter: &str, value: &str) -> Message {
        let params = [EntityParameter { name: parameter.into(), value: value.into() }].into_iter().collect();
        SetEntityParameters { name: name.into(), params }.into()
    }

    #[test]
    fn a_plan_of_a_surface_vessel_has_nothing_to_tell() {
        let plain = m::Goto { yaw: -1.0, ..m::Goto::default() };
        let keep = m::PushEntityParameters { name: "Path Control".into() };
        let back = m::PopEntityParameters { name: "Path Control".into() };
        let actions = vec![keep.into(), set("Path Control", "ILOS Lookahead Distance", "12"), back.into()];
        assert_eq!(told(&plan(vec![with(plain, actions)])), []);
    }

    #[test]
    fn actions_that_cannot_be_carried_out_refuse_the_plan() {
        let found = told(&plan(vec![with(
            m::Goto::default(),
            vec![
                m::PowerChannelControl::default().into(),
                set("Path Control", "ILOS Lookahead Distance", "x"),
            ],
        )]));
        assert_eq!(found.len(), 2);
        assert!(found.iter().all(|(maneuver, refuses, _)| maneuver.as_deref() == Some("a") && *refuses));
        assert!(found.iter().any(|(_, _, text)| text.contains("PowerChannelControl")), "{found:?}");
        assert!(found.iter().any(|(_, _, text)| text.contains("ILOS Lookahead Distance = x")), "{found:?}");
    }

    #[test]
    fn a_plan_that_would_change_what_the_files_alone_may_set_is_refused() {
        for (name, parameter, value) in [
            ("Operational Limits", "Maximum Speed", "9"),
            ("Path Control", "Cross-track -- Monitor", "false"),
        ] {
            let found = told(&plan(vec![with(m::Goto::default(), vec![set(name, parameter, value)])]));
            let [(_, true, text)] = &found[..] else { panic!("{found:?}") };
            assert!(text.contains(parameter) && text.contains("configuration file only"), "{text}");
        }
    }

    #[test]
    fn parts_that_are_not_aboard_are_told_once() {
        let node = || with(m::Goto::default(), vec![set("Sidescan", "Active", "true")]);
        let found = told(&plan(vec![node(), node(), node()]));
        let text = "start action: there is no part 'Sidescan' aboard; nothing is set (and 2 times more)";
        assert_eq!(found, [(Some("a".to_owned()), false, text.to_owned())]);
        let found = told(&plan(vec![with(m::Goto::default(), vec![set("Path Control", "Active", "true")])]));
        assert!(found[0].2.ends_with("Path Control has no parameter 'Active' to set") && !found[0].1);
    }

    #[test]
    fn fields_without_effect_are_told() {
        let cases: Vec<(Message, &str)> = vec![
            (m::Goto { z: 2.0, z_units: m::ZUnits::Altitude, ..m::Goto::default() }.into(), "surface"),
            (m::Rows { timeout: 600, ..m::Rows::default() }.into(), "timeout"),
            (m::Goto { yaw: 1.0, ..m::Goto::default() }.into(), "yaw"),
            (m::StationKeeping { custom: "a=b".into(), ..m::StationKeeping::default() }.into(), "'a=b'"),
            (m::ScheduledGoto { travel_z: 3.0, ..m::ScheduledGoto::default() }.into(), "surface"),
            (m::Loiter { direction: LoiterDirection::Iwindcurr, ..m::Loiter::default() }.into(), "clockwise"),
            (m::Teleoperation { custom: "src=16385;x=1".into() }.into(), "'x'"),
        ];
        for (message, part) in cases {
            let found = told(&plan(vec![with(message, Vec::new())]));
            assert!(matches!(&found[..], [(_, false, text)] if text.contains(part)), "{part}: {found:?}");
        }
    }

    #[test]
    fn an_operator_that_is_no_system_refuses_the_plan() {
        let found = told(&plan(vec![with(m::Teleoperation { custom: "src=bridge".into() }, Vec::new())]));
        assert!(matches!(&found[..], [(_, true, text)] if text.contains("src=bridge")), "{found:?}");
    }

    #[test]
    fn conditions_and_variables_are_told() {
        let mut plan = plan(vec![with(m::Goto::default(), Vec::new())]);
        let to = |conditions: &str| PlanTransition {
            source_man: "a".into(),
            conditions: conditions.into(),
            ..PlanTransition::default()
        };
        plan.transitions = [to("ManeuverIsDone"), to(""), to("depth > 3")].into_iter().collect();
        plan.variables = [m::PlanVariable::default()].into_iter().collect();
        let found = told(&plan);
        assert_eq!(found.len(), 2);
        assert!(found.iter().any(|(_, _, text)| text.contains("'depth > 3'")), "{found:?}");
    }
}
