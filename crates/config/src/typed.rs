//! From sections of text to sections of typed values, as the schema wants them.

use crate::edit::shortened;
use crate::ini::{Ini, IniSection, Setting};
use crate::line::{COMMENT_MARKS, is_misspelt_keyword};
use crate::problem::{Place, Problem, ProblemKind, Report, Severity};
use crate::profile::{ALWAYS, Enabled, NEVER, Profiles};
use crate::read::{default, read};
use crate::schema::{self, LEFT_OUT, SECTIONS, common};
use crate::section::{Parameter, Section};
use crate::spec::{Form, Kind, ParamSpec, SectionSpec};
use crate::value::Value;

const ENABLED: &str = common::ENABLED.spec.name;
const LABEL: &str = common::ENTITY_LABEL.spec.name;

/// All sections of `ini` with their typed values.
pub(crate) fn sections(
    ini: &Ini,
    profiles: &Profiles,
    vehicle_type: &str,
    report: &mut Report,
) -> Vec<Section> {
    ini.sections()
        .filter(|(name, _)| !name.starts_with("Require ") && !name.starts_with("Include "))
        .map(|(name, section)| {
            let mut reader = Reader { section, profiles, report: &mut *report, lenient: false };
            reader.section(name, vehicle_type)
        })
        .collect()
}

struct Reader<'a> {
    section: &'a IniSection,
    profiles: &'a Profiles,
    report: &'a mut Report,
    /// Whether errors are only warnings, because nothing of this section is in force.
    lenient: bool,
}

impl Reader<'_> {
    fn section(&mut self, name: &str, vehicle_type: &str) -> Section {
        let spec = schema::find(name);
        let text = |key: &str| self.section.setting(key).map(Setting::value).filter(|text| !text.is_empty());
        let enabled = text(ENABLED).map(Enabled::parse).unwrap_or_default();
        let label = text(LABEL).map(str::to_owned);
        let mut section = Section {
            name: name.to_owned(),
            spec,
            left_out: schema::reason_left_out(name),
            place: Some(self.section.place().clone()),
            runs: false,
            enabled,
            label,
            parameters: Vec::new(),
        };
        let Some(spec) = spec else {
            self.unknown(&section);
            section.parameters =
                self.section.settings().map(|(key, setting)| as_text(key, setting)).collect();
            return section;
        };
        let in_force = match spec.form {
            Form::Task { .. } => section.enabled.in_any_of(self.profiles),
            Form::Data | Form::OpenData(_) => true,
            Form::DataFor { .. } => {
                name.strip_prefix(spec.name()).is_some_and(|what| what == vehicle_type || what == "world")
            }
        };
        section.runs = in_force;
        self.lenient = !in_force;
        if let Form::Task { label, .. } = spec.form {
            self.task_options(&mut section, label);
        }
        section.parameters = match &spec.form {
            Form::OpenData(any) => self.open_data(any),
            Form::Task { .. } | Form::Data | Form::DataFor { .. } => self.parameters(spec),
        };
        section
    }

    fn unknown(&mut self, section: &Section) {
        let name = &section.name;
        if is_misspelt_keyword(name) {
            return; // reported as such already
        }
        if let Some(reason) = section.left_out {
            let what = format!("[{name}] is not used: {reason}");
            self.add(Severity::Note, ProblemKind::Unused, section.place(), what, "");
            return;
        }
        let names = SECTIONS.iter().flat_map(|spec| spec.names).chain(LEFT_OUT.iter().map(|(name, _)| name));
        let near = self.near(ProblemKind::UnknownSection, schema::task_of(name), names.copied());
        let what = format!("Lutra knows no section [{}]", shortened(name));
        let remedy = near.map_or_else(
            || "nothing is done with it; take it out unless DUNE needs it".to_owned(),
            |near| format!("[{near}]?"),
        );
        self.add(Severity::Warning, ProblemKind::UnknownSection, section.place(), what, &remedy);
    }

    /// `Enabled` and `Entity Label` of a task.
    fn task_options(&mut self, section: &mut Section, usual_label: &str) {
        let name = &section.name;
        match self.section.setting(ENABLED).filter(|setting| !setting.value().is_empty()) {
            None => {
                let what = format!("[{name}] has no `{ENABLED}` and therefore never runs");
                let remedy = "write `Enabled = Always`, the names of profiles, or `Never`";
                self.add(Severity::Warning, ProblemKind::Profile, section.place(), what, remedy);
            }
            Some(setting) => self.enabled(setting, &section.enabled),
        }
        if section.label.is_none() {
            if section.runs {
                let what = format!("[{name}] has no `{LABEL}`, which every task needs");
                let remedy = format!("write `{LABEL} = {usual_label}`");
                self.add(Severity::Error, ProblemKind::Label, section.place(), what, &remedy);
            }
            section.label = Some(usual_label.to_owned());
        }
    }

    fn enabled(&mut self, setting: &Setting, enabled: &Enabled) {
        for name in enabled.names() {
            if name == ALWAYS || name == NEVER || self.profiles.is_known(name) {
                continue;
            }
            let what = format!("`{ENABLED}`: there is no profile `{}`", shortened(name));
            let near = self.near(ProblemKind::Profile, name, self.profiles.known().chain([ALWAYS, NEVER]));
            let remedy = match near {
                Some(near) => format!("`{near}`?"),
                None => "declare it in [Profiles], or take it out".to_owned(),
            };
            self.add(Severity::Warning, ProblemKind::Profile, setting.place(), what, &remedy);
        }
    }

    fn parameters(&mut self, spec: &'static SectionSpec) -> Vec<Parameter> {
        let mut parameters = Vec::new();
        for param in spec.params() {
            for key in param.keys() {
                match self.section.setting(&key) {
                    Some(setting) => parameters.push(self.given(&key, Some(param), param, setting)),
                    None if param.is_repeated() => {}
                    None => parameters.extend(default(&param.kind).map(|value| Parameter {
                        key,
                        spec: Some(param),
                        value,
                        setting: None,
                        rejected: false,
                    })),
                }
            }
        }
        for (key, setting) in self.section.settings() {
            // The Otters' files write `Enabled` in models, too, where it has no meaning.
            let of_data = matches!(spec.form, Form::DataFor { .. }) && key == ENABLED;
            if of_data || spec.params().any(|param| param.matches(key)) {
                continue;
            }
            self.unknown_key(spec, key, setting);
            parameters.push(as_text(key, setting));
        }
        parameters
    }

    fn unknown_key(&mut self, spec: &'static SectionSpec, key: &str, setting: &Setting) {
        if key.contains(COMMENT_MARKS) {
            return; // reported as such already
        }
        let what = format!("[{}] has no parameter `{}`", spec.name(), shortened(key));
        let keys: Vec<String> = if self.report.is_full_of(ProblemKind::UnknownKey) {
            Vec::new()
        } else {
            spec.params().flat_map(ParamSpec::keys).collect()
        };
        let remedy = match suggest::nearest(key, keys.iter().map(String::as_str)) {
            Some(near) => format!("`{near}`?"),
            None => "it has no effect; take it out unless DUNE needs it".to_owned(),
        };
        self.add(Severity::Warning, ProblemKind::UnknownKey, setting.place(), what, &remedy);
    }

    fn open_data(&mut self, any: &ParamSpec) -> Vec<Parameter> {
        let section = self.section;
        section.settings().map(|(key, setting)| self.given(key, None, any, setting)).collect()
    }

    /// A parameter for which the files have a value.
    fn given(
        &mut self,
        key: &str,
        spec: Option<&'static ParamSpec>,
        wanted: &ParamSpec,
        setting: &Setting,
    ) -> Parameter {
        if wanted.kind == Kind::Unused {
            if !self.lenient {
                let what = format!("`{key}` has no effect: {}", wanted.doc);
                self.add(Severity::Note, ProblemKind::Unused, setting.place(), what, "");
            }
            return Parameter { spec, ..as_text(key, setting) };
        }
        let outcome = read(wanted, setting.value());
        for caution in outcome.cautions {
            self.report.add(caution.about(Severity::Warning, key, setting.place()));
        }
        let severity = if self.lenient { Severity::Warning } else { Severity::Error };
        for fault in outcome.faults {
            self.report.add(fault.about(severity, key, setting.place()));
        }
        let rejected = outcome.value.is_none();
        let value = outcome.value.or_else(|| default(&wanted.kind));
        let value = value.unwrap_or_else(|| Value::Text(setting.value().to_owned()));
        Parameter { key: key.to_owned(), spec, value, setting: Some(setting.clone()), rejected }
    }

    /// The nearest known name, unless the report is already full of such problems.
    fn near<'n>(
        &self,
        kind: ProblemKind,
        name: &str,
        names: impl Iterator<Item = &'n str>,
    ) -> Option<&'n str> {
        if self.report.is_full_of(kind) { None } else { suggest::nearest(name, names) }
    }

    fn add(
        &mut self,
        severity: Severity,
        kind: ProblemKind,
        place: Option<&Place>,
        what: String,
        remedy: &str,
    ) {
        self.report.add(Problem::new(severity, kind, place, what).remedy(remedy));
    }
}

fn as_text(key: &str, setting: &Setting) -> Parameter {
    let value = Value::Text(setting.value().to_owned());
    Parameter { key: key.to_owned(), spec: None, value, setting: Some(setting.clone()), rejected: false }
}
