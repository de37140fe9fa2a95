//! Profiles: which tasks run where. A task names the profiles it is enabled in; one or several are selected.

use std::collections::BTreeMap;

use crate::ini::Ini;
use crate::problem::{Problem, ProblemKind, Report};
use crate::value::split_list;

/// The profiles that exist without being declared.
pub const BUILT_IN: [&str; 3] = ["Hardware", "Simulation", "Hardware/Simulation"];
/// The name in `Enabled` that stands for every profile.
pub const ALWAYS: &str = "Always";
/// The name in `Enabled` that is never selected.
pub const NEVER: &str = "Never";

/// The profiles of a configuration and those selected.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Profiles {
    declared: BTreeMap<String, String>,
    selected: Vec<String>,
}

impl Profiles {
    pub(crate) fn new(ini: &Ini, selected: &[&str], report: &mut Report) -> Self {
        let section = ini.section("Profiles").into_iter().flat_map(crate::ini::IniSection::settings);
        let declared = section.map(|(name, setting)| (name.to_owned(), setting.value().to_owned())).collect();
        let selected = selected.iter().map(|name| (*name).to_owned()).collect();
        let profiles = Self { declared, selected };
        for name in profiles.selected.iter().filter(|name| !profiles.is_known(name)) {
            let known = profiles.known().collect::<Vec<_>>().join(", ");
            let what = format!("the selected profile `{name}` is not declared");
            let near = suggest::nearest(name, profiles.known());
            let near = near.map(|near| format!("`{near}`? ")).unwrap_or_default();
            report.add(
                Problem::error(ProblemKind::Profile, None, what)
                    .remedy(format!("{near}known are {known}; more are declared in [Profiles]")),
            );
        }
        profiles
    }

    /// All profiles, those built in first.
    pub fn known(&self) -> impl Iterator<Item = &str> {
        let declared = self.declared.keys().map(String::as_str).filter(|name| !BUILT_IN.contains(name));
        BUILT_IN.into_iter().chain(declared)
    }

    /// Whether there is a profile of this name.
    pub fn is_known(&self, name: &str) -> bool {
        BUILT_IN.contains(&name) || self.declared.contains_key(name)
    }

    /// What a declared profile is for.
    pub fn description(&self, name: &str) -> Option<&str> {
        self.declared.get(name).map(String::as_str)
    }

    /// The profiles selected.
    pub fn selected(&self) -> &[String] {
        &self.selected
    }
}

/// The profiles in which a task runs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Enabled {
    names: Vec<String>,
}

impl Enabled {
    /// From the text of an `Enabled` option; an empty or missing one means never.
    pub(crate) fn parse(text: &str) -> Self {
        let names = split_list(text).into_iter().filter(|name| !name.is_empty()).map(str::to_owned);
        Self { names: names.collect() }
    }

    /// The names as in the file.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Whether the task runs in this profile.
    pub fn in_profile(&self, profile: &str) -> bool {
        self.names.iter().any(|name| name == ALWAYS || name == profile)
    }

    /// Whether the task runs in one of the profiles selected.
    pub fn in_any_of(&self, profiles: &Profiles) -> bool {
        profiles.selected.iter().any(|profile| self.in_profile(profile))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn always_matches_any_profile_and_a_missing_option_none() {
        let enabled = Enabled::parse("Always");
        assert!(enabled.in_profile("Hardware") && enabled.in_profile("Bench"));
        for text in ["", "Never", "Simulation, Bench"] {
            assert!(!Enabled::parse(text).in_profile("Hardware"), "{text}");
        }
        assert!(Enabled::parse("Simulation,Bench").in_profile("Bench"));
    }

    #[test]
    fn selecting_an_undeclared_profile_is_an_error() {
        let mut report = Report::default();
        Profiles::new(&Ini::default(), &["Simulation", "Hardwere"], &mut report);
        assert_eq!(report.counts().errors, 1);
        assert!(report.problems()[0].remedy.starts_with("`Hardware`?"));
    }
}
