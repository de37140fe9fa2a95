//! Parameters of vessels; those of Lutra are described by the schema that the vessels read their files with.

use api::{ParameterAbout, VesselParameters};
use config::{Kind, Length, ParamSpec, SectionSpec};
use imc::Address;
use onboard::parameters::{self, Access, Parameter};
use operations::{EntityReport, Operations, ParameterReport};
use std::borrow::Cow;
use std::collections::BTreeMap;
use units::UtcTime;

/// Reported parameters, by entity label.
pub(crate) type ByEntity = BTreeMap<String, EntityReport>;

/// Parameters that a vessel reported since the server started.
pub(crate) fn reported(operations: &Operations, vessel: Address) -> ByEntity {
    let of = operations.commands().reports().entities(vessel).filter(|(_, entity)| entity.at.is_some());
    of.map(|(label, entity)| (label.to_owned(), entity.clone())).collect()
}

/// Parameters that a vessel reported last, by its history: `EntityParameters` of its entities, as [`super::history::at`]
/// gives them.
pub(crate) fn recorded(at: &api::At) -> ByEntity {
    let mut all = ByEntity::new();
    for update in at.values.iter().filter(|update| update.abbrev == "EntityParameters") {
        let field = |name: &str| Some(&update.fields.iter().find(|field| field.name == name)?.value);
        let Some(label) = field("name").and_then(|name| name.as_str()) else { continue };
        let Some(list) = field("params").and_then(|list| list.as_array()) else { continue };
        let text = |one: &serde_json::Value, name: &str| {
            Some(Cow::Owned(one.get("fields")?.get(name)?.as_str()?.to_owned()))
        };
        let values = list.iter().filter_map(|one| Some((text(one, "name")?, text(one, "value")?)));
        all.entry(label.to_owned()).or_default().take(values, UtcTime::from_micros(update.time_us));
    }
    all
}

/// Reported parameters with their descriptions.
pub(crate) fn described(entities: ByEntity, recorded: bool) -> VesselParameters {
    let known = parameters::all();
    // Lutra's own vessels also report saved values, for the next start; others are not described, as their parameters of
    // the same name may mean something else.
    let lutra =
        entities.values().flat_map(|entity| entity.parameters.values()).any(|one| one.saved.is_some());
    let entity = |(label, entity): (String, EntityReport)| {
        let names: Vec<&str> = entity.parameters.keys().map(String::as_str).collect();
        let parameter = |(name, told): (&String, &ParameterReport)| api::ParameterReport {
            name: name.clone(),
            value: told.value.clone(),
            saved: told.saved.clone(),
            cut: told.cut,
            time_us: told.at.micros(),
            about: if lutra { about(&known, &label, &names, name) } else { None },
        };
        api::EntityReport {
            time_us: entity.at.map_or(0, UtcTime::micros),
            parameters: entity.parameters.iter().map(parameter).collect(),
            left_out: u32::try_from(entity.left_out).unwrap_or(u32::MAX),
            entity: label,
        }
    };
    VesselParameters { entities: entities.into_iter().map(entity).collect(), recorded }
}

/// The description of a parameter. If several sections have one of its name, the section that shares the most names with
/// the report is taken: it is the one in use.
fn about(known: &[Parameter], label: &str, told: &[&str], name: &str) -> Option<ParameterAbout> {
    let usual = |one: &&Parameter| one.entity.label_and_task().0 == label;
    let called: Vec<&Parameter> = known.iter().filter(|one| one.name == name).collect();
    let of_entity: Vec<&Parameter> = called.iter().copied().filter(usual).collect();
    let candidates = if of_entity.is_empty() { called } else { of_entity };
    let homes = candidates.into_iter().flat_map(|one| one.homes.iter().map(move |home| (one, *home)));
    let homes: Vec<(&Parameter, &SectionSpec)> = homes.collect();
    let shared = |section: &SectionSpec| {
        told.iter().filter(|name| section.params().any(|spec| spec.matches(name))).count()
    };
    // `max_by_key` gives the last of equal ones; the first is meant, which is the usual one.
    let (parameter, section) = homes.into_iter().rev().max_by_key(|(_, section)| shared(section))?;
    let spec = section.params().find(|spec| spec.name == name)?;
    Some(description(parameter, section, spec))
}

fn description(parameter: &Parameter, section: &SectionSpec, spec: &ParamSpec) -> ParameterAbout {
    let (items, bounds, default) = match spec.kind {
        Kind::Float { default, min, max } => (Some(1), Some((min, max)), default.to_string()),
        Kind::Floats { default, length, min, max } => {
            let items = match length {
                Length::Exactly(items) => u32::try_from(items).ok(),
                Length::Any => None,
            };
            let texts: Vec<String> = default.iter().map(f64::to_string).collect();
            (items, Some((min, max)), texts.join(", "))
        }
        Kind::Choice { default, .. } => (None, None, default.to_owned()),
        _ => (None, None, String::new()),
    };
    let doc = match spec.kind {
        Kind::Choice { options, .. } => format!("{} One of: {}.", spec.doc, options.join(", ")),
        _ => spec.doc.to_owned(),
    };
    // A limit as wide as the number type is no limit.
    let limit = |value: f64| Some(value).filter(|value| value.abs() < f64::MAX);
    ParameterAbout {
        section: section.name().to_owned(),
        doc,
        unit: spec.unit.symbol().to_owned(),
        items,
        min: bounds.and_then(|(min, _)| limit(min)),
        max: bounds.and_then(|(_, max)| limit(max)),
        default,
        live: parameter.access == Access::Live,
        caution: parameter.caution().map(str::to_owned),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entity(values: &[(&str, &str)]) -> EntityReport {
        let mut told = EntityReport::default();
        let values = values.iter().map(|(name, value)| (Cow::Borrowed(*name), Cow::Borrowed(*value)));
        told.take(values, UtcTime::from_micros(5));
        told
    }

    fn one(label: &str, values: &[(&str, &str)]) -> VesselParameters {
        described([(label.to_owned(), entity(values))].into(), false)
    }

    fn unit(told: &VesselParameters, name: &str) -> Option<String> {
        let all = &told.entities[0].parameters;
        all.iter().find(|one| one.name == name).unwrap().about.as_ref().map(|about| about.unit.clone())
    }

    #[test]
    fn the_controller_that_runs_decides_what_its_gains_mean() {
        let label = "Heading & Speed Controller";
        let yaw = ("Yaw PID Gains", "60, 0, 0");
        let saved = ("Yaw PID Gains - Saved", "60, 0, 0");
        let by_force = one(label, &[yaw, saved, ("MPS Force PID Gains", "57, 2.8, 50")]);
        assert_eq!(unit(&by_force, "Yaw PID Gains").as_deref(), Some("N/rad"));
        let by_rpm = one(label, &[yaw, saved, ("MPS PID Gains", "450, 25, 0")]);
        assert_eq!(unit(&by_rpm, "Yaw PID Gains").as_deref(), Some("1/rad"));
    }

    #[test]
    fn a_vessel_of_another_program_is_not_described() {
        let told = one("Path Control", &[("ILOS Lookahead Distance", "10")]);
        assert_eq!(unit(&told, "ILOS Lookahead Distance"), None);
        assert!(told.entities[0].parameters[0].about.is_none() && !told.recorded);
    }

    #[test]
    fn every_parameter_is_described_under_any_label() {
        for parameter in parameters::all() {
            for label in [parameter.entity.label_and_task().0, "renamed"] {
                let saved = format!("{} - Saved", parameter.name);
                let told = one(label, &[(parameter.name, "1"), (&saved, "1")]);
                let about = told.entities[0].parameters[0].about.clone().unwrap();
                let words = about.doc.contains(" One of: ");
                assert!(!about.doc.is_empty() && !about.default.is_empty(), "{}", parameter.name);
                assert_eq!(about.items.is_none(), words, "{}", parameter.name);
                assert_eq!(about.live, parameter.access == Access::Live, "{}", parameter.name);
            }
        }
    }

    #[test]
    fn what_the_history_tells_is_the_same() {
        let field = |name: &str, value: serde_json::Value| api::Field {
            name: name.to_owned(),
            value,
            unit: String::new(),
            meaning: None,
        };
        let one = |name: &str, value: &str| {
            let fields = serde_json::json!({ "name": name, "value": value });
            serde_json::json!({ "abbrev": "EntityParameter", "fields": fields })
        };
        let params = vec![one("A", "1"), one("A - Saved", "2"), serde_json::json!({ "fields": 7 })];
        let update = api::Update {
            system: 1,
            id: 802,
            abbrev: "EntityParameters".to_owned(),
            entity: 4,
            instance: None,
            time_us: 9,
            received_us: 9,
            count: 0,
            period_s: None,
            fields: vec![field("name", "Path".into()), field("params", params.into())],
        };
        let all = recorded(&api::At { time_us: 9, values: vec![update], cut: false });
        let one = &all["Path"].parameters["A"];
        assert_eq!((one.value.as_str(), one.saved.as_deref(), one.at.micros()), ("1", Some("2"), 9));
    }
}
