//! Refusal of settings and commands that are not a number or outside what a model holds for.

use thiserror::Error;

/// A value that a model cannot be asked to use.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("{what} is {value}, which is not within {low} to {high}")]
pub struct OutOfRange {
    /// The quantity, with its unit.
    pub what: &'static str,
    /// The value found.
    pub value: f64,
    /// The least value allowed.
    pub low: f64,
    /// The greatest value allowed.
    pub high: f64,
}

/// `value` where it is a number within `low` to `high`.
pub(crate) fn within(what: &'static str, value: f64, low: f64, high: f64) -> Result<f64, OutOfRange> {
    if (low..=high).contains(&value) { Ok(value) } else { Err(OutOfRange { what, value, low, high }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_number_is_in_no_range() {
        assert!(within("x", f64::NAN, -1.0, 1.0).is_err());
        assert!(within("x", f64::INFINITY, -1.0, 1.0).is_err());
        assert!(within("x", 1.0, -1.0, 1.0).is_ok());
        let error = within("payload (kg)", 50.0, 0.0, 45.0).unwrap_err();
        assert_eq!(error.to_string(), "payload (kg) is 50, which is not within 0 to 45");
    }
}
