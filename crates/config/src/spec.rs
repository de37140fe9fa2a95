//! How a parameter is described: name, type, unit, range, default and one line of documentation.
//!
//! A section's parameters are constants of type [`Param`], each knowing the Rust type of its value, so that
//! `section.get(&ilos::LOOKAHEAD)` is an `f64` without any string or cast at the place of use.

use std::fmt;
use std::marker::PhantomData;

/// The unit of a parameter's value in the file. Angles are in degrees there, radians in programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// A pure number, a text or a list of such.
    None,
    /// Metres.
    Metre,
    /// Metres per second.
    MetrePerSecond,
    /// Metres per second squared.
    MetrePerSecondSquared,
    /// Degrees.
    Degree,
    /// Degrees per second.
    DegreePerSecond,
    /// Seconds.
    Second,
    /// Milliseconds.
    Millisecond,
    /// Hertz.
    Hertz,
    /// Revolutions per minute.
    Rpm,
    /// Revolutions per minute, per second.
    RpmPerSecond,
    /// Revolutions per minute for each metre per second.
    RpmPerMetrePerSecond,
    /// Actuation (-1 to 1) for each revolution per minute.
    ActuationPerRpm,
    /// Actuation (-1 to 1).
    Actuation,
    /// Actuation for each radian of error.
    ActuationPerRadian,
    /// Actuation per second.
    ActuationPerSecond,
    /// Newtons.
    Newton,
    /// Newtons for each metre per second.
    NewtonPerMetrePerSecond,
    /// Newtons for each radian of error.
    NewtonPerRadian,
    /// Kilograms.
    Kilogram,
    /// Percent.
    Percent,
    /// Parts per thousand.
    PerMille,
    /// Volts.
    Volt,
    /// Watt hours.
    WattHour,
    /// Degrees Celsius.
    Celsius,
    /// Mebibytes.
    Mebibyte,
    /// Bits per second.
    Baud,
    /// Bytes per second.
    BytePerSecond,
}

impl Unit {
    /// The unit's symbol; empty for pure numbers.
    pub const fn symbol(self) -> &'static str {
        match self {
            Self::None => "",
            Self::Metre => "m",
            Self::MetrePerSecond => "m/s",
            Self::MetrePerSecondSquared => "m/s^2",
            Self::Degree => "deg",
            Self::DegreePerSecond => "deg/s",
            Self::Second => "s",
            Self::Millisecond => "ms",
            Self::Hertz => "Hz",
            Self::Rpm => "rpm",
            Self::RpmPerSecond => "rpm/s",
            Self::RpmPerMetrePerSecond => "rpm/(m/s)",
            Self::ActuationPerRpm => "1/rpm",
            Self::Actuation => "of full actuation",
            Self::ActuationPerRadian => "1/rad",
            Self::ActuationPerSecond => "1/s",
            Self::Newton => "N",
            Self::NewtonPerMetrePerSecond => "N/(m/s)",
            Self::NewtonPerRadian => "N/rad",
            Self::Kilogram => "kg",
            Self::Percent => "%",
            Self::PerMille => "per mille",
            Self::Volt => "V",
            Self::WattHour => "Wh",
            Self::Celsius => "degC",
            Self::Mebibyte => "MiB",
            Self::Baud => "Bd",
            Self::BytePerSecond => "B/s",
        }
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.symbol())
    }
}

/// How many items a list may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Length {
    /// Any number.
    Any,
    /// Exactly so many.
    Exactly(usize),
}

/// The type of a parameter with its default and range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// A truth value.
    Bool {
        /// Used when the file says nothing.
        default: bool,
    },
    /// A whole number.
    Int {
        /// Used when the file says nothing.
        default: i64,
        /// The least allowed.
        min: i64,
        /// The greatest allowed.
        max: i64,
    },
    /// A number.
    Float {
        /// Used when the file says nothing.
        default: f64,
        /// The least allowed.
        min: f64,
        /// The greatest allowed.
        max: f64,
    },
    /// Text; an empty one means "none".
    Text {
        /// Used when the file says nothing.
        default: &'static str,
    },
    /// Text with escapes.
    Bytes {
        /// Used when the file says nothing, escapes included.
        default: &'static str,
    },
    /// One of a few words.
    Choice {
        /// Used when the file says nothing.
        default: &'static str,
        /// The words allowed.
        options: &'static [&'static str],
    },
    /// An IPv4 address.
    Address {
        /// Used when the file says nothing.
        default: [u8; 4],
    },
    /// A list of numbers.
    Floats {
        /// Used when the file says nothing.
        default: &'static [f64],
        /// How many items it must have.
        length: Length,
        /// The least allowed for each.
        min: f64,
        /// The greatest allowed for each.
        max: f64,
    },
    /// A list of whole numbers.
    Ints {
        /// Used when the file says nothing.
        default: &'static [i64],
        /// The least allowed for each.
        min: i64,
        /// The greatest allowed for each.
        max: i64,
    },
    /// A list of texts.
    Texts {
        /// Used when the file says nothing.
        default: &'static [&'static str],
    },
    /// A list of `name:number`.
    Rates {
        /// Used when the file says nothing.
        default: &'static [(&'static str, f64)],
        /// The least allowed for each number.
        min: f64,
        /// The greatest allowed for each number.
        max: f64,
    },
    /// A list of `name:text`.
    Pairs,
    /// Known to DUNE, without effect in Lutra; the documentation says why.
    Unused,
}

/// The description of one parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParamSpec {
    /// The key in the file. `{}` in it stands for each of [`ParamSpec::each`].
    pub name: &'static str,
    /// The replacements of `{}` in the name.
    pub each: &'static [&'static str],
    /// Type, default and range.
    pub kind: Kind,
    /// The unit in the file.
    pub unit: Unit,
    /// One line of documentation.
    pub doc: &'static str,
}

impl ParamSpec {
    /// Whether `key` is this parameter's key, or one of its keys.
    pub fn matches(&self, key: &str) -> bool {
        match self.name.split_once("{}") {
            None => self.name == key,
            Some((before, after)) => key
                .strip_prefix(before)
                .and_then(|rest| rest.strip_suffix(after))
                .is_some_and(|part| self.each.contains(&part)),
        }
    }

    /// Every key this parameter can have.
    pub fn keys(&self) -> Vec<String> {
        match self.name.split_once("{}") {
            None => vec![self.name.to_owned()],
            Some((before, after)) => self.each.iter().map(|part| format!("{before}{part}{after}")).collect(),
        }
    }

    /// Whether the name stands for several keys.
    pub const fn is_repeated(&self) -> bool {
        !self.each.is_empty()
    }
}

/// A parameter whose value has the Rust type `T`.
#[derive(Clone, Copy, Debug)]
pub struct Param<T> {
    /// The description.
    pub spec: ParamSpec,
    value: PhantomData<fn() -> T>,
}

impl<T> Param<T> {
    const fn new(name: &'static str, kind: Kind, unit: Unit) -> Self {
        Self { spec: ParamSpec { name, each: &[], kind, unit, doc: "" }, value: PhantomData }
    }

    /// The same parameter with its documentation.
    #[must_use]
    pub const fn doc(mut self, doc: &'static str) -> Self {
        self.spec.doc = doc;
        self
    }

    /// The same parameter, `{}` in its name standing for each of `parts`.
    #[must_use]
    pub const fn each(mut self, parts: &'static [&'static str]) -> Self {
        self.spec.each = parts;
        self
    }
}

impl Param<f64> {
    /// The same parameter with its range, both ends allowed.
    #[must_use]
    pub const fn within(mut self, least: f64, greatest: f64) -> Self {
        if let Kind::Float { min, max, .. } = &mut self.spec.kind {
            *min = least;
            *max = greatest;
        }
        self
    }
}

impl Param<i64> {
    /// The same parameter with its range, both ends allowed.
    #[must_use]
    pub const fn within(mut self, least: i64, greatest: i64) -> Self {
        if let Kind::Int { min, max, .. } = &mut self.spec.kind {
            *min = least;
            *max = greatest;
        }
        self
    }
}

impl Param<Vec<i64>> {
    /// The same parameter with the range of each item, both ends allowed.
    #[must_use]
    pub const fn within(mut self, least: i64, greatest: i64) -> Self {
        if let Kind::Ints { min, max, .. } = &mut self.spec.kind {
            *min = least;
            *max = greatest;
        }
        self
    }
}

impl Param<Vec<f64>> {
    /// The same parameter with the range of each item, both ends allowed.
    #[must_use]
    pub const fn within(mut self, least: f64, greatest: f64) -> Self {
        if let Kind::Floats { min, max, .. } = &mut self.spec.kind {
            *min = least;
            *max = greatest;
        }
        self
    }

    /// The same parameter with exactly so many items.
    #[must_use]
    pub const fn of_length(mut self, items: usize) -> Self {
        if let Kind::Floats { length, .. } = &mut self.spec.kind {
            *length = Length::Exactly(items);
        }
        self
    }
}

/// A truth value.
pub(crate) const fn flag(name: &'static str, default: bool) -> Param<bool> {
    Param::new(name, Kind::Bool { default }, Unit::None)
}

/// A whole number, not negative unless given another range.
pub(crate) const fn int(name: &'static str, default: i64, unit: Unit) -> Param<i64> {
    Param::new(name, Kind::Int { default, min: 0, max: i64::MAX }, unit)
}

/// A number, not negative unless given another range.
pub(crate) const fn float(name: &'static str, default: f64, unit: Unit) -> Param<f64> {
    Param::new(name, Kind::Float { default, min: 0.0, max: f64::MAX }, unit)
}

/// A text.
pub(crate) const fn text(name: &'static str, default: &'static str) -> Param<String> {
    Param::new(name, Kind::Text { default }, Unit::None)
}

/// A text with escapes.
pub(crate) const fn bytes(name: &'static str, default: &'static str) -> Param<Vec<u8>> {
    Param::new(name, Kind::Bytes { default }, Unit::None)
}

/// One of a few words.
pub(crate) const fn choice(
    name: &'static str,
    default: &'static str,
    options: &'static [&'static str],
) -> Param<&'static str> {
    Param::new(name, Kind::Choice { default, options }, Unit::None)
}

/// An IPv4 address.
pub(crate) const fn address(name: &'static str, default: [u8; 4]) -> Param<std::net::Ipv4Addr> {
    Param::new(name, Kind::Address { default }, Unit::None)
}

/// A list of numbers of any sign.
pub(crate) const fn floats(name: &'static str, default: &'static [f64], unit: Unit) -> Param<Vec<f64>> {
    Param::new(name, Kind::Floats { default, length: Length::Any, min: f64::MIN, max: f64::MAX }, unit)
}

/// A list of whole numbers, not negative unless given another range.
pub(crate) const fn ints(name: &'static str, default: &'static [i64], unit: Unit) -> Param<Vec<i64>> {
    Param::new(name, Kind::Ints { default, min: 0, max: i64::MAX }, unit)
}

/// A list of texts.
pub(crate) const fn texts(name: &'static str, default: &'static [&'static str]) -> Param<Vec<String>> {
    Param::new(name, Kind::Texts { default }, Unit::None)
}

/// A list of `name:number`, none negative.
pub(crate) const fn rates(
    name: &'static str,
    default: &'static [(&'static str, f64)],
    unit: Unit,
) -> Param<Vec<(String, f64)>> {
    Param::new(name, Kind::Rates { default, min: 0.0, max: f64::MAX }, unit)
}

/// A list of `name:text`, empty by default.
pub(crate) const fn pairs(name: &'static str) -> Param<Vec<(String, String)>> {
    Param::new(name, Kind::Pairs, Unit::None)
}

/// A key that DUNE knows and Lutra does not use.
pub(crate) const fn unused(name: &'static str, doc: &'static str) -> ParamSpec {
    ParamSpec { name, each: &[], kind: Kind::Unused, unit: Unit::None, doc }
}

/// What a section is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// A task: it has `Enabled`, an entity label and the other options that every task has.
    Task {
        /// The profiles in which it runs in Lutra's own configuration.
        enabled: &'static str,
        /// The entity label in Lutra's own configuration.
        label: &'static str,
    },
    /// Plain data with known keys.
    Data,
    /// Plain data for one of several things; the section's name goes on behind the given names.
    DataFor {
        /// The text behind the given name in Lutra's own configuration.
        example: &'static str,
    },
    /// Plain data with any keys, all of one kind.
    OpenData(ParamSpec),
}

/// The description of one section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionSpec {
    /// The names under which it is known; the first is the one Lutra writes.
    pub names: &'static [&'static str],
    /// What it is for.
    pub form: Form,
    /// One line of documentation.
    pub doc: &'static str,
    /// The parameters, in groups that sections may share.
    pub groups: &'static [&'static [ParamSpec]],
}

impl SectionSpec {
    /// A task.
    pub(crate) const fn task(
        names: &'static [&'static str],
        label: &'static str,
        enabled: &'static str,
    ) -> Self {
        Self { names, form: Form::Task { enabled, label }, doc: "", groups: &[] }
    }

    /// Plain data.
    pub(crate) const fn data(names: &'static [&'static str], form: Form) -> Self {
        Self { names, form, doc: "", groups: &[] }
    }

    pub(crate) const fn doc(mut self, doc: &'static str) -> Self {
        self.doc = doc;
        self
    }

    pub(crate) const fn groups(mut self, groups: &'static [&'static [ParamSpec]]) -> Self {
        self.groups = groups;
        self
    }

    /// The name Lutra writes.
    pub const fn name(&self) -> &'static str {
        self.names[0]
    }

    /// Whether this is a task.
    pub const fn is_task(&self) -> bool {
        matches!(self.form, Form::Task { .. })
    }

    /// The section's own parameters, in the order of the documentation.
    pub fn params(&self) -> impl Iterator<Item = &'static ParamSpec> {
        self.groups.iter().flat_map(|group| group.iter())
    }
}
