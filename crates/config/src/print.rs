//! The effective configuration for people, line by line, and for programs, as JSON.

use std::fmt::{self, Write as _};

use serde_json::{Value as Json, json};

use crate::config::Config;
use crate::ini::Setting;
use crate::problem::{Place, Problem, Report};
use crate::section::{Parameter, Section};
use crate::spec::{Kind, ParamSpec, SectionSpec};
use crate::value::{Value, split_list};

/// How wide the column of values is.
const VALUE_COLUMN: usize = 62;

/// Every section and parameter with its value, unit and origin, then every problem.
impl fmt::Display for Config {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let address = self.address().map_or("no address".to_owned(), |address| format!("{address:#06x}"));
        let name = if self.vehicle().is_empty() { "(unnamed)" } else { self.vehicle() };
        writeln!(f, "vehicle  {name} ({address})")?;
        writeln!(f, "profiles {}", self.profiles.selected().join(", "))?;
        for file in &self.files {
            writeln!(f, "file     {file}")?;
        }
        for section in &self.sections {
            writeln!(f, "\n{}", Heading(section, self.profiles.selected()))?;
            for parameter in &section.parameters {
                writeln!(f, "{}", Line(parameter))?;
            }
        }
        writeln!(f, "\n{}", self.report)
    }
}

struct Heading<'a>(&'a Section, &'a [String]);

impl fmt::Display for Heading<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(section, selected) = self;
        write!(f, "[{}]", section.name())?;
        match (section.spec(), section.left_out()) {
            (None, None) => f.write_str("  unknown to Lutra")?,
            (None, Some(reason)) => write!(f, "  not used: {reason}")?,
            (Some(spec), _) if spec.is_task() => {
                let names = section.enabled().names();
                let names = if names.is_empty() { "Never".to_owned() } else { names.join(", ") };
                let state = if section.runs() { "runs" } else { "does not run" };
                write!(f, "  {state} in {} (enabled: {names})", selected.join(", "))?;
                write!(f, ", label \"{}\"", section.label().unwrap_or_default())?;
            }
            (Some(_), _) => {}
        }
        match section.place() {
            Some(place) => write!(f, "  # {place}"),
            None => Ok(()),
        }
    }
}

struct Line<'a>(&'a Parameter);

impl fmt::Display for Line<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(parameter) = self;
        let mut text = format!("  {} = {}", parameter.key(), parameter.value());
        let symbol = parameter.spec().map_or("", |spec| spec.unit.symbol());
        if !symbol.is_empty() {
            let _ = write!(text, " {symbol}");
        }
        write!(f, "{text:VALUE_COLUMN$}  # ")?;
        if parameter.spec().is_some_and(|spec| spec.kind == Kind::Unused) {
            f.write_str("no effect in Lutra, ")?;
        }
        match (parameter.place(), parameter.is_rejected()) {
            (None, _) => f.write_str("default"),
            (Some(place), false) => write!(f, "{place}{}", Others(parameter.setting())),
            (Some(place), true) => write!(f, "default, because the value of {place} is refused"),
        }
    }
}

/// The lines that had a part in a value before the last one.
struct Others<'a>(Option<&'a Setting>);

impl fmt::Display for Others<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let changes = self.0.map_or(&[][..], Setting::history);
        let Some((last, earlier)) = changes.split_last() else { return Ok(()) };
        for change in earlier.iter().rev() {
            let verb = if last.action.as_str() == "=" { "overrides" } else { "after" };
            write!(f, ", {verb} {}", change.place)?;
        }
        Ok(())
    }
}

impl Config {
    /// The effective configuration and the problems as JSON.
    pub fn to_json(&self) -> Json {
        json!({
            "vehicle": self.vehicle(),
            "address": self.address(),
            "profiles": {
                "selected": self.profiles.selected(),
                "known": self.profiles.known().collect::<Vec<_>>(),
            },
            "files": self.files.iter().map(AsRef::as_ref).collect::<Vec<&str>>(),
            "sections": self.sections.iter().map(|section| self.section_json(section)).collect::<Vec<_>>(),
            "report": self.report.to_json(),
        })
    }

    fn section_json(&self, section: &Section) -> Json {
        let is_task = section.spec().is_some_and(SectionSpec::is_task);
        let enabled: serde_json::Map<String, Json> = self
            .profiles
            .known()
            .map(|profile| (profile.to_owned(), json!(section.enabled().in_profile(profile))))
            .collect();
        json!({
            "name": section.name(),
            "task": is_task.then(|| section.task()),
            "instance": section.instance().filter(|_| is_task),
            "label": section.label().filter(|_| is_task),
            "known": section.spec().is_some(),
            "left_out": section.left_out(),
            "runs": section.runs(),
            "enabled": if is_task { Json::Object(enabled) } else { Json::Null },
            "source": section.place().map(Place::to_json),
            "parameters": section.parameters().iter().map(Parameter::to_json).collect::<Vec<_>>(),
        })
    }
}

impl Parameter {
    fn to_json(&self) -> Json {
        let history = self.setting().map_or(&[][..], Setting::history);
        let text = self.setting().map_or_else(|| self.value().to_string(), |given| given.value().to_owned());
        let history: Vec<Json> = history
            .iter()
            .map(|change| {
                json!({
                    "file": &*change.place.file,
                    "line": change.place.line,
                    "last_line": change.last_line,
                    "operator": change.action.as_str(),
                    "text": change.text,
                })
            })
            .collect();
        json!({
            "key": self.key(),
            "text": text,
            "list": split_list(&text).into_iter().filter(|item| !item.is_empty()).collect::<Vec<_>>(),
            "value": self.value().to_json(),
            "unit": self.spec().map(|spec| spec.unit.symbol()).filter(|symbol| !symbol.is_empty()),
            "known": self.spec().is_some(),
            "used": self.spec().is_some_and(|spec| spec.kind != Kind::Unused),
            "doc": self.spec().map(|spec: &ParamSpec| spec.doc),
            "rejected": self.is_rejected(),
            "source": self.place().map(Place::to_json),
            "history": history,
        })
    }
}

impl Value {
    /// The value as JSON: numbers as numbers, lists as lists, `name:value` pairs as `[name, value]`.
    pub fn to_json(&self) -> Json {
        match self {
            Self::Bool(value) => json!(value),
            Self::Int(value) => json!(value),
            Self::Float(value) => json!(value),
            Self::Text(text) => json!(text),
            Self::Bytes(_) | Self::Address(_) => json!(self.to_string()),
            Self::Choice(word) => json!(word),
            Self::Floats(values) => json!(values),
            Self::Ints(values) => json!(values),
            Self::Texts(texts) => json!(texts),
            Self::Rates(rates) => json!(rates),
            Self::Pairs(pairs) => json!(pairs),
        }
    }
}

impl Place {
    fn to_json(&self) -> Json {
        json!({ "file": &*self.file, "line": self.line })
    }
}

impl Report {
    /// The counts and the problems, worst first, as JSON.
    pub fn to_json(&self) -> Json {
        let counts = self.counts();
        json!({
            "errors": counts.errors,
            "warnings": counts.warnings,
            "notes": counts.notes,
            "left_out": self.left_out(),
            "problems": self.by_severity().into_iter().map(Problem::to_json).collect::<Vec<_>>(),
        })
    }
}

impl Problem {
    fn to_json(&self) -> Json {
        json!({
            "severity": self.severity.as_str(),
            "kind": self.kind.as_str(),
            "file": self.place.as_ref().map(|place| &*place.file),
            "line": self.place.as_ref().map(|place| place.line),
            "what": self.what,
            "remedy": self.remedy,
        })
    }
}
