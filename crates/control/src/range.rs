//! Range checks of configuration values: every problem is found and named, not only the first.
//!
//! Names are written as paths (`yaw.pid.kp`), units as in the documentation of each field.

use std::fmt;
use std::ops::RangeInclusive;
use thiserror::Error;

/// One configuration value that is not a number or outside its range.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{parameter} = {value} {unit} is outside {min} to {max}")]
pub struct OutOfRange {
    /// Path of the field, for example `yaw.pid.kp`.
    pub parameter: String,
    /// Unit of value and limits.
    pub unit: &'static str,
    /// The value given.
    pub value: f64,
    /// Smallest value allowed.
    pub min: f64,
    /// Largest value allowed.
    pub max: f64,
}

/// A configuration that cannot be used, with everything that is wrong with it.
#[derive(Debug, Clone, PartialEq, Error)]
pub struct InvalidConfig {
    /// Never empty.
    pub problems: Vec<OutOfRange>,
}

impl fmt::Display for InvalidConfig {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (n, problem) in self.problems.iter().enumerate() {
            let separator = if n == 0 { "" } else { "; " };
            write!(f, "{separator}{problem}")?;
        }
        Ok(())
    }
}

/// Collects what is out of range.
#[derive(Default)]
pub(crate) struct RangeCheck {
    path: Vec<&'static str>,
    problems: Vec<OutOfRange>,
}

impl RangeCheck {
    /// Notes `value` unless it is a number within `range`.
    pub(crate) fn number(
        &mut self,
        name: &'static str,
        unit: &'static str,
        value: f64,
        range: RangeInclusive<f64>,
    ) {
        if !range.contains(&value) {
            let mut parameter = self.path.join(".");
            if !parameter.is_empty() {
                parameter.push('.');
            }
            parameter.push_str(name);
            self.problems.push(OutOfRange { parameter, unit, value, min: *range.start(), max: *range.end() });
        }
    }

    /// The same for a value that may be absent.
    pub(crate) fn optional(
        &mut self,
        name: &'static str,
        unit: &'static str,
        value: Option<f64>,
        range: RangeInclusive<f64>,
    ) {
        if let Some(value) = value {
            self.number(name, unit, value, range);
        }
    }

    /// Runs `check` with `name` in front of its parameters.
    pub(crate) fn within(&mut self, name: &'static str, check: impl FnOnce(&mut Self)) {
        self.path.push(name);
        check(self);
        self.path.pop();
    }

    /// The verdict.
    pub(crate) fn finish(self) -> Result<(), InvalidConfig> {
        if self.problems.is_empty() { Ok(()) } else { Err(InvalidConfig { problems: self.problems }) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_every_problem_with_its_path() {
        let mut check = RangeCheck::default();
        check.number("gap", "s", 0.5, 0.0..=1.0);
        check.within("yaw", |yaw| {
            yaw.number("limit", "rad", f64::NAN, 0.0..=1.0);
            yaw.optional("rate", "1/s", Some(-2.0), 0.0..=1.0);
            yaw.optional("other", "1/s", None, 0.0..=1.0);
        });
        assert_eq!(
            check.finish().unwrap_err().to_string(),
            "yaw.limit = NaN rad is outside 0 to 1; yaw.rate = -2 1/s is outside 0 to 1"
        );
    }
}
