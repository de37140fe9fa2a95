//! A chart's data of one of its objects.

use charts::s57::{Attribute, AttributeCode, ObjectClass};

/// The data of an object; its number in the sheet is its `id` in tiles.
#[derive(Debug, Clone, PartialEq)]
pub struct About {
    /// Class.
    pub class: ObjectClass,
    /// Record number in its chart.
    pub record: u32,
    /// Number of its chart: [`Sheet::source`](crate::Sheet::source).
    pub source: u32,
    /// Attributes in the order of the file, then the national ones.
    pub attributes: Vec<Attribute>,
}

impl About {
    /// The value of an attribute; `None` where it is absent or empty.
    pub fn text(&self, code: AttributeCode) -> Option<&str> {
        let mut values = self.attributes.iter().filter(|one| one.code == code).map(|one| one.value.trim());
        values.find(|value| !value.is_empty())
    }

    /// Its value as a finite number.
    pub fn number(&self, code: AttributeCode) -> Option<f64> {
        self.text(code)?.parse().ok().filter(|value: &f64| value.is_finite())
    }

    /// Its name, the international one first.
    pub fn name(&self) -> Option<&str> {
        self.text(AttributeCode::OBJNAM).or_else(|| self.text(AttributeCode::NOBJNM))
    }
}
