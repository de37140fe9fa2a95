//! A section with typed values: what the rest of the program asks for its parameters.

use std::net::Ipv4Addr;
use std::sync::Arc;

use crate::ini::{Action, Change, Setting};
use crate::problem::{Place, Problem};
use crate::profile::Enabled;
use crate::read::{Complaint, default, read};
use crate::schema::{common, task_of};
use crate::spec::{Kind, Param, ParamSpec, SectionSpec};
use crate::value::Value;
use crate::{ProblemKind, Severity};

/// A section of the effective configuration.
#[derive(Clone, Debug)]
pub struct Section {
    pub(crate) name: String,
    pub(crate) spec: Option<&'static SectionSpec>,
    pub(crate) left_out: Option<&'static str>,
    pub(crate) place: Option<Place>,
    pub(crate) enabled: Enabled,
    pub(crate) runs: bool,
    pub(crate) label: Option<String>,
    pub(crate) parameters: Vec<Parameter>,
}

/// A parameter of a section with the value in force.
#[derive(Clone, Debug)]
pub struct Parameter {
    pub(crate) key: String,
    pub(crate) spec: Option<&'static ParamSpec>,
    pub(crate) value: Value,
    pub(crate) setting: Option<Setting>,
    pub(crate) rejected: bool,
}

impl Parameter {
    /// The key in the file.
    pub fn key(&self) -> &str {
        &self.key
    }

    /// The description, if Lutra knows the key.
    pub const fn spec(&self) -> Option<&'static ParamSpec> {
        self.spec
    }

    /// The value in force.
    pub const fn value(&self) -> &Value {
        &self.value
    }

    /// What the files say; `None` when the value is the default.
    pub const fn setting(&self) -> Option<&Setting> {
        self.setting.as_ref()
    }

    /// Whether the files' value was refused, so that the default is in force.
    pub const fn is_rejected(&self) -> bool {
        self.rejected
    }

    /// The line that gave the value in force; `None` for a default.
    pub fn place(&self) -> Option<&Place> {
        self.setting.as_ref().and_then(Setting::place)
    }
}

/// A Rust type that parameters can have.
pub trait FromValue: Sized {
    /// The value as this type, or `None` when it is of another.
    fn from_value(value: &Value) -> Option<Self>;
}

/// Implements [`FromValue`] for the type that one variant of [`Value`] holds.
macro_rules! from_value {
    ($($variant:ident => $type:ty),* $(,)?) => {$(
        impl FromValue for $type {
            fn from_value(value: &Value) -> Option<Self> {
                if let Value::$variant(inner) = value { Some(inner.clone()) } else { None }
            }
        }
    )*};
}

from_value! {
    Bool => bool,
    Int => i64,
    Float => f64,
    Text => String,
    Bytes => Vec<u8>,
    Choice => &'static str,
    Address => Ipv4Addr,
    Floats => Vec<f64>,
    Ints => Vec<i64>,
    Texts => Vec<String>,
    Rates => Vec<(String, f64)>,
    Pairs => Vec<(String, String)>,
}

impl Section {
    /// The section's name, such as `Simulators.Motor/Port`.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The task, such as `Simulators.Motor`: the text before the `/`.
    pub fn task(&self) -> &str {
        task_of(&self.name)
    }

    /// The instance, such as `Port`: the text behind the `/`.
    pub fn instance(&self) -> Option<&str> {
        self.name.split_once('/').map(|(_, instance)| instance)
    }

    /// The description, if Lutra knows the section.
    pub const fn spec(&self) -> Option<&'static SectionSpec> {
        self.spec
    }

    /// Why Lutra does without this task, if it knows the task and does.
    pub const fn left_out(&self) -> Option<&'static str> {
        self.left_out
    }

    /// Where the section begins; `None` when no file has it.
    pub const fn place(&self) -> Option<&Place> {
        self.place.as_ref()
    }

    /// The profiles in which the task runs; nothing for plain data.
    pub const fn enabled(&self) -> &Enabled {
        &self.enabled
    }

    /// Whether this is a task that Lutra knows and the selected profiles enable, or plain data.
    pub const fn runs(&self) -> bool {
        self.runs
    }

    /// The entity label of a task.
    pub fn label(&self) -> Option<&str> {
        self.label.as_deref()
    }

    /// All parameters: the known ones in the order of the documentation, then the unknown ones.
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// A parameter by its key.
    pub fn parameter(&self, key: &str) -> Option<&Parameter> {
        self.parameters.iter().find(|parameter| parameter.key == key)
    }

    /// The value of `param`, which is the default where the section does not have it.
    ///
    /// # Panics
    /// Never: a parameter's default has the parameter's type by the way it is made.
    pub fn get<T: FromValue>(&self, param: &Param<T>) -> T {
        self.parameter(param.spec.name)
            .and_then(|parameter| T::from_value(&parameter.value))
            .or_else(|| default(&param.spec.kind).as_ref().and_then(T::from_value))
            .expect("invariant: the constructors of Param give the default the type T")
    }

    /// The values of a repeated parameter that the files give, with the replacements of `{}` in their keys.
    pub fn each<T: FromValue>(&self, param: &Param<T>) -> Vec<(&'static str, T)> {
        let parts = param.spec.each.iter().zip(param.spec.keys());
        parts.filter_map(|(part, key)| Some((*part, T::from_value(&self.parameter(&key)?.value)?))).collect()
    }

    /// The section that `spec` describes with nothing but defaults.
    pub fn defaults(spec: &'static SectionSpec) -> Self {
        let known = spec.params().filter(|param| !param.is_repeated());
        let parameters = known.filter_map(|param| {
            let value = default(&param.kind)?;
            let key = param.name.to_owned();
            Some(Parameter { key, spec: Some(param), value, setting: None, rejected: false })
        });
        Self {
            name: spec.name().to_owned(),
            spec: Some(spec),
            left_out: None,
            place: None,
            enabled: Enabled::default(),
            runs: !spec.is_task(),
            label: None,
            parameters: parameters.collect(),
        }
    }

    /// Gives a parameter another value while the program runs; everything stays as it was when it is refused.
    ///
    /// # Errors
    /// When the section has no such parameter or the text is not a value of it.
    pub fn change(&mut self, key: &str, text: &str) -> Result<Value, Problem> {
        let known: Vec<_> = self.spec.into_iter().flat_map(SectionSpec::params).collect();
        let fixed = [common::ENABLED.spec.name, common::ENTITY_LABEL.spec.name];
        let changeable = |param: &&ParamSpec| param.kind != Kind::Unused && !fixed.contains(&param.name);
        let Some(spec) = known.iter().copied().filter(changeable).find(|param| param.matches(key)) else {
            let what = format!("[{}] has no parameter `{key}` that can be changed", self.name);
            let near = suggest::nearest(key, known.iter().map(|param| param.name));
            let near = near.map(|near| format!("`{near}`?")).unwrap_or_default();
            return Err(Problem::error(ProblemKind::UnknownKey, None, what).remedy(near));
        };
        let editable = |setting: &Setting| setting.attributes().get("editable").is_none_or(|it| it == "true");
        if !self.parameter(key).and_then(Parameter::setting).is_none_or(editable) {
            let what = format!("`{key}` of [{}] is marked as not editable", self.name);
            let remedy = "change it in its file and start again";
            return Err(Problem::error(ProblemKind::Attribute, None, what).remedy(remedy));
        }
        let outcome = read(spec, text);
        let Some(value) = outcome.value else {
            let fault = outcome.faults.into_iter().next().unwrap_or_else(|| unreadable(text));
            return Err(fault.about(Severity::Error, key, None));
        };
        let place = Place { file: Arc::from("(changed while running)"), line: 0 };
        let mut setting =
            self.parameter(key).and_then(|parameter| parameter.setting.clone()).unwrap_or_default();
        text.clone_into(&mut setting.value);
        setting.history.push(Change { place, last_line: 0, action: Action::Set, text: text.to_owned() });
        let changed = Parameter {
            key: key.to_owned(),
            spec: Some(spec),
            value: value.clone(),
            setting: Some(setting),
            rejected: false,
        };
        match self.parameters.iter_mut().find(|parameter| parameter.key == key) {
            Some(parameter) => *parameter = changed,
            None => self.parameters.push(changed),
        }
        Ok(value)
    }
}

fn unreadable(text: &str) -> Complaint {
    let what = format!("`{text}` is not a value");
    Complaint { kind: ProblemKind::WrongType, what, remedy: String::new() }
}

impl Complaint {
    /// The complaint as a problem of the option `key`.
    pub(crate) fn about(self, severity: Severity, key: &str, place: Option<&Place>) -> Problem {
        Problem::new(severity, self.kind, place, format!("`{key}`: {}", self.what)).remedy(self.remedy)
    }
}
